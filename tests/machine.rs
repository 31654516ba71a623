//! What the machine sets: memory that may be had, places that cannot be written, languages, pipes.
#![cfg(all(feature = "cli", unix))]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A folder of one test's own, gone with it; runs start in it.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("amcheck-machine-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        Scratch(folder)
    }

    /// Runs a line of shell in which `$AMCHECK` is the command and `$PARTS` the fixtures.
    fn shell(&self, line: &str) -> Output {
        let parts = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/parts");
        Command::new("bash")
            .args(["-c", line])
            .env("AMCHECK", env!("CARGO_BIN_EXE_amcheck"))
            .env("PARTS", parts)
            .current_dir(&self.0)
            .stdin(Stdio::null())
            .output()
            .expect("bash runs")
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap_or_else(|| panic!("killed: {output:?}"))
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_limit_of_the_shell_refuses_in_a_sentence_before_the_kernel_does() {
    let s = Scratch::new();
    let mut refused = 0;
    // From far too little, in steps, to enough; the part needs about 80 MB by itself.
    for mib in [120, 160, 200, 300, 400, 500, 600, 1000, 2000, 4000] {
        let line = format!("ulimit -v {} && $AMCHECK $PARTS/block.stl --voxel 0.1mm --format json --quiet", mib * 1024);
        let output = s.shell(&line);
        match code(&output) {
            0 => {}
            5 => {
                refused += 1;
                assert!(said(&output).contains("`ulimit -v` allows no more"), "{mib} MiB: {}", said(&output));
            }
            other => panic!("{mib} MiB ended with {other}: {}", said(&output)),
        }
    }
    assert!((1..10).contains(&refused), "{refused} of 10 limits refused");
}

#[test]
fn what_is_allowed_is_kept_within_a_tenth() {
    let status = "/proc/self/status";
    if !Path::new(status).exists() {
        println!("skipped: the system does not tell the peak");
        return;
    }
    let s = Scratch::new();
    for (part, voxel, process) in [
        ("block", "2mm", "fdm"),
        ("block", "0.25mm", "fdm"),
        ("block", "0.12mm", "fdm"),
        ("finned_bracket", "2mm", "fdm"),
        ("finned_bracket", "0.2mm", "fdm"),
        ("slits_015", "0.1mm", "fdm"),
        ("flask_020", "0.1mm", "sla"),
        ("finned_bracket", "0.15mm", "lpbf"),
        ("hollow_sealed", "0.15mm", "sls"),
        ("basin", "0.3mm", "mjf"),
        ("table_40", "0.3mm", "binder-jet"),
        ("table_40", "0.5mm", "fdm --tool end-mill-3"),
    ] {
        // A batch of one part tells its peak.
        let line =
            format!("$AMCHECK batch $PARTS/{part}.stl --voxel {voxel} --process {process} --json --out {part}{voxel}");
        let output = s.shell(&line);
        let row: serde_json::Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {output:?}"));
        let folder = s.0.join(format!("{part}{voxel}")).join(row["folder"].as_str().expect("a folder"));
        let report = std::fs::read_to_string(folder.join("report.json")).expect("a report");
        let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
        let need = report["grid"]["memory_bytes"].as_f64().expect("the need") / f64::from(1 << 20);
        let peak = row["peak_mib"].as_f64().expect("the peak");
        println!("{part} at {voxel}, {process}: {peak} MiB of {need:.0}");
        assert!(peak <= 1.1 * need, "{part} at {voxel}: {peak} MiB, {need:.0} were said");
        // A need that is never taken would refuse what fits.
        assert!(peak >= 0.25 * need, "{part} at {voxel}: {peak} MiB, {need:.0} were said");
    }
}

#[test]
fn language_home_and_threads_change_no_byte() {
    let s = Scratch::new();
    let run = |settings: &str, out: &str| {
        let line =
            format!("{settings} $AMCHECK $PARTS/finned_bracket.stl --out {out} --format json,html,markdown --quiet");
        let output = s.shell(&line);
        assert_eq!(code(&output), 1, "{settings}: {}", said(&output));
        ["report.json", "report.html", "report.md"].map(|name| std::fs::read(s.0.join(out).join(name)).expect(name))
    };
    let plain = run("env", "a");
    for (i, settings) in [
        "env -i AMCHECK=\"$AMCHECK\" PARTS=\"$PARTS\"",
        "env LC_ALL=tr_TR.UTF-8 LANG=tr_TR.UTF-8",
        "env LC_ALL=de_DE.UTF-8 LC_NUMERIC=de_DE.UTF-8",
        "env RAYON_NUM_THREADS=1 TZ=Asia/Tokyo",
        "env TMPDIR=/nowhere HOME=/nowhere",
    ]
    .into_iter()
    .enumerate()
    {
        assert!(run(settings, &format!("b{i}")) == plain, "{settings} changes the report");
    }
}

#[test]
fn a_closed_output_ends_quietly_and_a_full_one_does_not() {
    let s = Scratch::new();
    let closed = s.shell("$AMCHECK $PARTS/block.stl --quiet --format json >&-");
    assert_eq!((code(&closed), said(&closed).as_str()), (0, ""));
    let piped = s.shell("$AMCHECK $PARTS/wall_080.stl --format json --json | head -c 10; exit ${PIPESTATUS[0]}");
    assert_eq!((code(&piped), said(&piped).as_str()), (0, ""));
    let full = s.shell("$AMCHECK $PARTS/block.stl --quiet --format json > /dev/full");
    assert!(code(&full) == 6 && said(&full).contains("standard output"), "{}", said(&full));
}

#[test]
fn pipes_devices_and_folders_are_no_parts() {
    let s = Scratch::new();
    let pipe = s.shell("mkfifo p.stl && timeout 20 $AMCHECK p.stl");
    assert!(code(&pipe) == 4 && said(&pipe).contains("with - for its name"), "{}", said(&pipe));
    let device = s.shell("timeout 20 $AMCHECK /dev/zero");
    assert_eq!(code(&device), 4, "{}", said(&device));
    let endless = s.shell("timeout 60 $AMCHECK - --memory 96MiB < /dev/zero");
    assert_eq!(code(&endless), 5, "{}", said(&endless));
    // Files named - or with a space, a sign and bytes that are no UTF-8.
    let odd = s
        .shell("cp $PARTS/block.stl $'a #\\xff.stl' && $AMCHECK ./$'a #\\xff.stl' --quiet --out r && ls r/report.json");
    assert_eq!(code(&odd), 0, "{}", said(&odd));
}

#[test]
fn a_place_that_takes_no_file_leaves_none() {
    let s = Scratch::new();
    if s.shell("id -u").stdout == b"0\n" {
        // The superuser may read and write anywhere, so somebody else tries.
        let line =
            "cp $AMCHECK a && cp $PARTS/block.stl b.stl && chmod 755 a . && chmod 000 b.stl && mkdir -m 700 locked";
        let nobody = "setpriv --reuid=65534 --regid=65534 --clear-groups";
        if code(&s.shell(&format!("{line} && {nobody} true"))) == 0 {
            let output = s.shell(&format!("cp b.stl c.stl; chmod 644 c.stl; {nobody} ./a c.stl --out locked/r"));
            assert!(code(&output) == 6 && said(&output).contains("locked"), "{}", said(&output));
            let output = s.shell(&format!("mkdir -m 777 open && cd open && {nobody} ../a ../b.stl"));
            assert!(code(&output) == 4 && said(&output).contains("permi"), "{}", said(&output));
        } else {
            println!("skipped: nobody else can be tried as");
        }
    } else {
        let output = s.shell("mkdir locked && chmod 500 locked && $AMCHECK $PARTS/block.stl --out locked/r");
        assert!(code(&output) == 6 && said(&output).contains("locked"), "{}", said(&output));
        let output = s.shell("cp $PARTS/block.stl b.stl && chmod 000 b.stl && $AMCHECK b.stl");
        assert!(code(&output) == 4 && said(&output).contains("permi"), "{}", said(&output));
    }
    let batch = s.shell("touch file && $AMCHECK batch $PARTS --out file/r");
    assert!(code(&batch) == 6 && said(&batch).contains("E030"), "{}", said(&batch));
    let full = s.shell("mkdir small && mount -t tmpfs -o size=64k none small 2>&1");
    if code(&full) != 0 {
        println!("skipped: no small file system can be made here");
        return;
    }
    let output =
        s.shell("$AMCHECK $PARTS/finned_bracket.stl --out small/r; c=$?; find small -type f; umount small; exit $c");
    assert!(code(&output) == 6 && said(&output).contains("E030"), "{}", said(&output));
    assert!(output.stdout.is_empty(), "left: {}", String::from_utf8_lossy(&output.stdout));
}

#[test]
fn what_is_repaired_stands_beside_the_report() {
    let s = Scratch::new();
    let first = s.shell("$AMCHECK $PARTS/block.stl --repair --format json --out sound");
    assert!(code(&first) == 0 && !s.0.join("sound/repaired.3mf").exists(), "{}", said(&first));
    assert!(String::from_utf8_lossy(&first.stdout).contains("nothing was to be repaired"));
    // Every facet doubled.
    let bytes =
        std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/parts/block.stl")).expect("a fixture");
    let facets = (bytes.len() - 84) / 50;
    let doubled = [&bytes[..80], &(2 * facets as u32).to_le_bytes(), &bytes[84..], &bytes[84..]].concat();
    std::fs::write(s.0.join("doubled.stl"), doubled).expect("a file");
    let left = s.shell("$AMCHECK doubled.stl --format json --out left");
    assert!(!s.0.join("left/repaired.3mf").exists());
    assert!(String::from_utf8_lossy(&left.stdout).contains("--repair leaves 0"), "{left:?}");
    let mended = s.shell("$AMCHECK doubled.stl --repair --format json --out mended");
    assert!(String::from_utf8_lossy(&mended.stdout).contains("doubled facets were dropped"), "{mended:?}");
    let again = s.shell("$AMCHECK mended/repaired.3mf --format json --out again --fail-on warn");
    assert_eq!(code(&again), 0, "{again:?}");
}
