//! Many parts in one run: one line each, nothing judged twice, nothing half-written.
#![cfg(feature = "cli")]

use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A folder of one test's own, gone with it; runs start in it.
struct Scratch(PathBuf);

impl Scratch {
    /// With a folder `in` that holds these fixtures.
    fn with(fixtures: &[&str]) -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("amcheck-batch-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let s = Scratch(std::env::temp_dir().join(name));
        std::fs::create_dir_all(s.0.join("in/deeper")).expect("a temporary folder");
        for name in fixtures {
            let from = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/parts/{name}.stl"));
            std::fs::copy(from, s.0.join(format!("in/{name}.stl"))).expect("a fixture");
        }
        s
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_amcheck"));
        command.args(arguments).current_dir(&self.0).stdin(Stdio::null());
        command
    }

    /// Exit code and the rows printed; every run here asks for JSON lines and for no pictures.
    fn batch(&self, arguments: &[&str]) -> (i32, Vec<Value>) {
        let arguments = [&["batch"], arguments, &["--json", "--format", "json"]].concat();
        let output = self.command(&arguments).output().expect("amcheck starts");
        (code(&output), rows(&output.stdout))
    }

    /// Every name below a folder, sorted.
    fn names(&self, folder: &str) -> Vec<String> {
        let mut open = vec![self.0.join(folder)];
        let mut names = Vec::new();
        while let Some(folder) = open.pop() {
            for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
                if entry.path().is_dir() {
                    open.push(entry.path());
                }
                names.push(entry.path().strip_prefix(&self.0).expect("below").to_string_lossy().into_owned());
            }
        }
        names.sort();
        names
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap_or_else(|| panic!("killed: {}", output.status))
}

fn rows(bytes: &[u8]) -> Vec<Value> {
    let text = String::from_utf8_lossy(bytes);
    text.lines().map(|l| serde_json::from_str(l).unwrap_or_else(|e| panic!("{l}: {e}"))).collect()
}

/// Part, code and whether the result was there before, of each row.
fn seen(rows: &[Value]) -> Vec<(&str, u64, bool)> {
    rows.iter()
        .map(|r| {
            (
                r["part"].as_str().expect("a name"),
                r["code"].as_u64().expect("a code"),
                r["reused"].as_bool().expect("a flag"),
            )
        })
        .collect()
}

#[test]
fn one_bad_part_keeps_nobody_waiting_and_the_worst_code_wins() {
    let s = Scratch::with(&["block", "wall_111_024"]);
    std::fs::write(s.0.join("in/deeper/bad.stl"), "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 blah\n")
        .expect("");
    std::fs::write(s.0.join("in/notes.md"), "no part").expect("");
    let (exit, first) = s.batch(&["in", "--out", "out"]);
    assert_eq!(seen(&first), [("block.stl", 0, false), ("deeper/bad.stl", 4, false), ("wall_111_024.stl", 1, false)]);
    assert_eq!(exit, 4);
    assert_eq!(
        (first[1]["error"]["code"].as_str(), first[1]["error"]["place"].as_str()),
        (Some("E011"), Some("line 4"))
    );
    // The same again: nothing is computed, and the table says the same.
    let (_, second) = s.batch(&["in", "--out", "out"]);
    assert!(seen(&second).iter().all(|r| r.2), "{second:?}");
    let (_, third) = s.batch(&["in", "--out", "out", "--limit", "thin-wall=0.1mm"]);
    assert!(seen(&third).iter().all(|r| !r.2), "another limit is another question");
    std::fs::copy(s.0.join("in/wall_111_024.stl"), s.0.join("in/block.stl")).expect("another content");
    let (_, fourth) = s.batch(&["in", "--out", "out"]);
    assert_eq!(seen(&fourth)[0], ("block.stl", 1, false), "another content is another part");
    assert!(seen(&s.batch(&["in", "--out", "out", "--fresh"]).1).iter().all(|r| !r.2));
    assert!(s.names("out").iter().all(|n| !n.contains("/.")), "{:?}", s.names("out"));
    let listed = s.batch(&["list.txt", "--out", "out"]);
    assert_eq!((listed.0, listed.1.len()), (4, 0), "a list that is not there");
    std::fs::write(s.0.join("list.txt"), "in/wall_111_024.stl\nin/gone.stl\n").expect("");
    let (exit, rows) = s.batch(&["list.txt", "--out", "out"]);
    assert_eq!((exit, rows[0]["error"]["code"].as_str()), (4, Some("E010")));
}

/// Whatever changes the result asks another question: acceptances and the day, limits, process, pose, formats and all the others.
#[test]
fn no_kept_result_answers_another_question() {
    let s = Scratch::with(&["wall_111_024"]);
    let accept = |until: &str| {
        format!(
            "[[accept]]\ncheck = \"thin-wall\"\nat_mm = [0, 0, 0]\nwithin_mm = 1000\nno_worse_than = 0.01\nreason = \"meant\"\n{until}"
        )
    };
    std::fs::write(s.0.join("held.toml"), accept("")).expect("");
    std::fs::write(s.0.join("until.toml"), accept("until = 2030-01-01\n")).expect("");
    std::fs::write(s.0.join("own.toml"), "inherits = \"fdm\"\n[machine]\nlayer_height_mm = 0.1\n").expect("");
    let questions: [&[&str]; 22] = [
        &[],
        &["--accept", "held.toml"],
        &["--accept", "until.toml", "--today", "2029-12-31"],
        &["--accept", "until.toml", "--today", "2030-01-02"],
        &["--limit", "thin-wall=0.2mm"],
        &["--limit", "thin-wall=0.2mm,0.3mm"],
        &["--process", "lpbf"],
        &["--process", "own.toml"],
        &["--up", "+x"],
        &["--units", "in"],
        &["--voxel", "0.2mm"],
        &["--thickness", "2mm"],
        &["--refine", "1M"],
        &["--skip", "blend"],
        &["--tool", "end-mill-3"],
        &["--tool", "end-mill-3", "--tool-from", "axes"],
        &["--tool", "end-mill-3", "--tool-tilt", "30deg"],
        &["--tool", "end-mill-3", "--faces", "+z:30deg"],
        &["--repair"],
        &["--salvage"],
        &["--fail-on", "warn"],
        &["--fail-on", "never"],
    ];
    let mut codes = Vec::new();
    for asked in questions {
        let arguments = [&["in", "--out", "out", "--only", "thin-wall,mesh"][..], asked].concat();
        let (_, rows) = s.batch(&arguments);
        assert!(!rows[0]["reused"].as_bool().expect("a flag"), "{asked:?} was answered by an earlier run");
        codes.push(rows[0]["code"].as_u64().expect("a code"));
        let (_, again) = s.batch(&arguments);
        assert!(again[0]["reused"].as_bool().expect("a flag"), "{asked:?} was asked twice");
        assert_eq!((&again[0]["code"], &again[0]["line"]), (&rows[0]["code"], &rows[0]["line"]), "{asked:?}");
    }
    assert_eq!(codes[..4], [1, 0, 0, 1], "without, accepted, before its end, after it");
}

#[test]
fn files_of_one_name_in_several_folders_are_told_apart() {
    let s = Scratch::with(&["block"]);
    std::fs::copy(s.0.join("in/block.stl"), s.0.join("in/deeper/block.stl")).expect("a copy");
    let asked = ["batch", "in", "--only", "mesh", "--out", "out", "--json", "--format", "junit,markdown,json"];
    let ran = s.command(&asked).output().expect("amcheck starts");
    let (rows, places) = (rows(&ran.stdout), ["block.stl", "deeper/block.stl"]);
    for (row, place) in rows.iter().zip(places) {
        let read = |name: &str| s.text(&format!("out/{}/{name}", row["folder"].as_str().expect("a folder")));
        assert_eq!(row["part"], place);
        let tests = read("report.junit.xml");
        assert!(tests.contains(&format!("<testsuite name=\"{place}\" ")), "{tests}");
        assert!(tests.contains(&format!("classname=\"amcheck.{place}\" ")), "{tests}");
        assert!(read("report.md").lines().next().is_some_and(|l| l.ends_with(&format!(": {place}"))), "{place}");
        let report: Value = serde_json::from_str(&read("report.json")).expect("JSON");
        assert_eq!(report["part"]["file"], "block.stl", "a report is that of the part alone");
    }
    assert_eq!(rows.len(), 2);
}

#[test]
fn a_part_that_is_refused_stands_in_the_lists_of_others() {
    let s = Scratch::with(&["block"]);
    std::fs::write(s.0.join("in/deeper/bad.stl"), "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 blah\n")
        .expect("");
    std::fs::write(s.0.join("list.txt"), "in/deeper/bad.stl\nin/block.stl\nin/gone.stl\n").expect("");
    let asked = ["batch", "list.txt", "--only", "mesh", "--out", "out", "--json", "--format", "junit,sarif"];
    let errors = || -> Vec<String> {
        let ran = s.command(&asked).output().expect("amcheck starts");
        assert_eq!(rows(&ran.stdout).len(), 3);
        let lists: Vec<String> = s.names("out").into_iter().filter(|n| n.ends_with("report.junit.xml")).collect();
        let texts = lists.iter().map(|name| s.text(name)).filter(|text| text.contains("errors=\"1\""));
        let name = |text: String| text.split("<testsuite name=\"").nth(1)?.split('"').next().map(String::from);
        let mut names: Vec<String> = texts.filter_map(name).collect();
        names.sort();
        let alerts = s.names("out").into_iter().filter(|n| n.ends_with("report.sarif"));
        let alerts = alerts.filter(|name| s.text(name).contains("\"executionSuccessful\": false")).count();
        assert_eq!(alerts, names.len());
        names
    };
    let both = ["in/deeper/bad.stl", "in/gone.stl"];
    assert_eq!([errors(), errors()], [both, both], "what is not judged again stands there as well");
    // What can be read again is refused no longer.
    std::fs::copy(s.0.join("in/block.stl"), s.0.join("in/gone.stl")).expect("a copy");
    assert_eq!(errors(), ["in/deeper/bad.stl"]);
}

#[test]
fn a_row_says_what_the_command_says_alone() {
    let s = Scratch::with(&["wall_111_024"]);
    let (_, rows) = s.batch(&["in", "--out", "out"]);
    let alone =
        s.command(&["in/wall_111_024.stl", "--json", "--format", "json", "--out", "alone"]).output().expect("runs");
    let folder = rows[0]["folder"].as_str().expect("a folder");
    assert_eq!(s.text(&format!("out/{folder}/report.json")).as_bytes(), alone.stdout);
    let report: Value = serde_json::from_slice(&alone.stdout).expect("JSON");
    assert_eq!(rows[0]["sha256"], report["part"]["sha256"]);
    // Nothing follows a line of the table.
    let [line, summary] = [&rows[0]["line"], &report["summary"]].map(|text| text.as_str().expect("a sentence"));
    assert_eq!(summary.strip_prefix(line), Some(" 5 more findings are below."));
}

#[test]
fn shares_are_joined_into_the_table_of_the_whole() {
    let fixtures = ["block", "wall_080", "wall_111_024", "ramp_30", "table_hanging", "slits_015"];
    let s = Scratch::with(&fixtures);
    let (whole, rows) = s.batch(&["in", "--out", "whole", "--only", "mesh,build-volume,overhang"]);
    assert_eq!(rows.len(), fixtures.len());
    for share in ["1/3", "2/3", "3/3"] {
        // All shares of a job array may write to one folder.
        s.batch(&["in", "--out", "shares", "--only", "mesh,build-volume,overhang", "--shard", share]);
    }
    let merged = s.command(&["merge", "shares"]).output().expect("runs");
    assert_eq!(code(&merged), whole);
    let without_time = |name: &str| -> Vec<Value> {
        let mut rows: Vec<Value> = s.text(name).lines().map(|l| serde_json::from_str(l).expect("JSON")).collect();
        for row in &mut rows {
            let row = row.as_object_mut().expect("an object");
            ["seconds", "peak_mib"].iter().for_each(|k| drop(row.remove(*k)));
        }
        rows
    };
    assert_eq!(without_time("shares/table.jsonl"), without_time("whole/table.jsonl"));
    let said = |output: Output| String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(!said(merged).contains("note:"));
    // Two of the shares are run again after a part was taken out.
    std::fs::remove_file(s.0.join("in/slits_015.stl")).expect("a part");
    for share in ["1/3", "2/3"] {
        s.batch(&["in", "--out", "shares", "--only", "mesh,build-volume,overhang", "--shard", share]);
    }
    let merged = s.command(&["merge", "shares"]).output().expect("runs");
    assert!(said(merged).contains("the shares are not all of the same list of parts"));
    std::fs::remove_file(s.0.join("shares/table-2-of-3.jsonl")).expect("a share");
    let merged = s.command(&["merge", "shares", "--out", "all"]).output().expect("runs");
    assert!(String::from_utf8_lossy(&merged.stdout).contains("share 2 of 3 has no table"));
    assert_eq!(code(&merged), 4);
    for bad in ["0/3", "4/3", "x"] {
        assert_eq!(code(&s.command(&["batch", "in", "--shard", bad]).output().expect("runs")), 2, "{bad}");
    }
}

#[test]
fn shares_of_another_number_go_when_a_new_one_comes() {
    let s = Scratch::with(&["block", "wall_080"]);
    let asked = ["--out", "out", "--only", "mesh"];
    for share in ["1/3", "2/3", "3/3", "1/2", "2/2"] {
        s.batch(&[&["in"], &asked[..], &["--shard", share]].concat());
    }
    let tables = || -> Vec<String> { s.names("out").into_iter().filter(|n| n.ends_with(".jsonl")).collect() };
    assert_eq!(tables(), ["out/table-1-of-2.jsonl", "out/table-2-of-2.jsonl"]);
    s.batch(&[&["in"], &asked[..]].concat());
    assert_eq!(tables(), ["out/table.jsonl"]);
}

#[test]
fn parts_of_one_name_in_two_batches_both_stand() {
    let s = Scratch::with(&["block", "wall_111_024"]);
    for (name, fixture) in [("a", "wall_111_024"), ("b", "block")] {
        std::fs::create_dir(s.0.join(name)).expect("a folder");
        std::fs::copy(s.0.join(format!("in/{fixture}.stl")), s.0.join(name).join("bracket.stl")).expect("a part");
        s.batch(&[name, "--out", &format!("out-{name}"), "--only", "thin-wall"]);
    }
    let merged = s.command(&["merge", "out-a", "out-b", "--out", "joined"]).output().expect("runs");
    assert_eq!(code(&merged), 1, "a part that fails is not covered by one of its name");
    assert_eq!(
        seen(&rows(s.text("joined/table.jsonl").as_bytes())),
        [("out-a/bracket.stl", 1, false), ("out-b/bracket.stl", 0, false)]
    );
}

#[test]
fn what_a_batch_left_is_no_part_of_the_next() {
    let s = Scratch::with(&["block"]);
    let judged = || s.batch(&[".", "--out", "checked", "--only", "mesh"]).1.len();
    judged();
    let result = s.names("checked/parts").into_iter().find(|n| n.ends_with("row.json")).expect("a result");
    let folder = s.0.join(result).parent().expect("a folder").to_path_buf();
    std::fs::copy(s.0.join("in/block.stl"), folder.join("repaired.stl")).expect("a mesh");
    assert_eq!(judged(), 1);
}

#[test]
fn a_run_that_was_killed_goes_on_where_it_stopped() {
    let s = Scratch::with(&["block", "finned_bracket", "slits_015", "wall_080", "wall_111_024"]);
    let arguments = ["batch", "in", "--out", "out", "--json", "--format", "json", "--jobs", "1"];
    let mut child = s.command(&arguments).stdout(Stdio::piped()).spawn().expect("amcheck starts");
    let mut first = String::new();
    BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut first).expect("a row");
    child.kill().expect("it can be killed");
    child.wait().expect("it ends");
    assert!(!s.0.join("out/table.csv").exists(), "a table of half the parts");
    let (_, rows) = s.batch(&["in", "--out", "out", "--jobs", "1"]);
    assert!(rows.len() == 5 && seen(&rows)[0].2, "{rows:?}");
    assert!(s.names("out").iter().all(|n| !n.contains("partial")), "{:?}", s.names("out"));
    assert_eq!(s.text("out/table.csv").lines().count(), 6);
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_nothing_half_written() {
    let s = Scratch::with(&["finned_bracket", "slits_015"]);
    for (arguments, left) in [
        (&["batch", "in", "--out", "out", "--json"][..], "partial"),
        (&["in/finned_bracket.stl", "--out", "results/of/one", "--refine", "900G"], "results"),
    ] {
        let child = s.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
        // Long enough for the handler to stand and the folder to be made, too short for the end.
        std::thread::sleep(std::time::Duration::from_millis(60));
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
        let ended = child.wait_with_output().expect("it ends");
        if code(&ended) == 130 {
            assert!(String::from_utf8_lossy(&ended.stderr).contains("E050"));
            assert!(s.names(".").iter().all(|n| !n.contains(left)), "{:?}", s.names("."));
        } else {
            assert!([0, 1].contains(&code(&ended)), "{ended:?}");
            println!("{arguments:?} was done before it could be interrupted");
        }
    }
}

#[test]
fn what_runs_left_beside_their_reports_is_no_part() {
    let s = Scratch::with(&["block"]);
    let output =
        s.command(&["orient", "in/block.stl", "--out", "in/o", "--format", "json,stl"]).output().expect("runs");
    assert_eq!(code(&output), 0, "{output:?}");
    let best = s.0.join("in/o/best.stl");
    assert!(best.exists());
    let parts = |operands: &[&str]| {
        let words = [&["batch"], operands, &["--out", "out", "--format", "json"]].concat();
        let output = s.command(&words).output().expect("runs");
        assert_eq!(code(&output), 0, "{output:?}");
        s.text("out/table.csv").lines().count() - 1
    };
    assert_eq!(parts(&["in"]), 1);
    // One that is named is judged, and one that somebody has put in its place.
    assert_eq!(parts(&["in", "in/o/best.stl"]), 2);
    std::fs::copy(s.0.join("in/block.stl"), &best).expect("copied");
    assert_eq!(parts(&["in"]), 2);
}

#[test]
fn the_page_begins_with_the_worst_and_no_line_points_below_it() {
    let s = Scratch::with(&["block", "finned_bracket"]);
    let (_, rows) = s.batch(&["in", "--out", "out", "--only", "thin-wall", "--fail-on", "never"]);
    assert_eq!(rows.len(), 2);
    let (page, table) = (s.text("out/index.html"), s.text("out/table.csv"));
    assert!(page.find("finned_bracket.stl") < page.find("block.stl"), "{page}");
    assert!(table.find("block.stl") < table.find("finned_bracket.stl"), "{table}");
    for text in [page, table] {
        assert!(text.contains("Wall of 0.45 mm") && !text.contains("below."), "{text}");
    }
}

#[cfg(unix)]
#[test]
fn names_break_out_of_no_page_and_no_table() {
    let s = Scratch::with(&["block"]);
    let name = "=cmd|' <img src=x onerror=y>,\"\u{1b}[31m.stl";
    std::fs::rename(s.0.join("in/block.stl"), s.0.join("in").join(name)).expect("renamed");
    let output = s.command(&["batch", "in", "--out", "out", "--format", "json,html"]).output().expect("runs");
    assert_eq!(code(&output), 0, "{output:?}");
    assert!(!output.stdout.contains(&0x1b), "an escape sequence reaches the terminal");
    let page = s.text("out/index.html");
    assert!(!page.contains("<img src=x") && page.contains("&lt;img src=x"), "{page}");
    assert!(s.text("out/table.csv").lines().nth(1).expect("a row").starts_with("\"'=cmd|"));
    let thumbnail = page.split("<img src=\"").nth(1).and_then(|p| p.split('"').next()).expect("a thumbnail");
    let bytes = std::fs::read(s.0.join("out").join(thumbnail)).expect("the thumbnail stands where the page says");
    assert!(bytes.starts_with(b"\x89PNG"));
}

#[test]
fn what_breaks_down_is_a_line() {
    use amcheck::batch::{Earlier, Store, Work, entries, run};
    let s = Scratch::with(&["block", "wall_080"]);
    let store = Store::open(&s.0.join("out")).expect("a folder");
    let judge = |entry: &amcheck::batch::Entry, _: &[u8]| match entry.name.as_str() {
        "block.stl" => panic!("on purpose"),
        _ => Err(amcheck::Error::Interrupted),
    };
    let named = |entry: &amcheck::batch::Entry| entry.name.clone();
    let refused = |_: &amcheck::batch::Entry, _: &amcheck::Error| Vec::new();
    let content = |entry: &amcheck::batch::Entry| amcheck::io::content_of(&entry.path, 1 << 20);
    let (settings, jobs, earlier) = (String::new(), 1, Earlier::Keep);
    let (content, judge, refused, named) = (&content, &judge, &refused, &named);
    let work = Work { content, judge, refused, named, settings, among: None, jobs, earlier };
    let parts = entries(&[s.0.join("in")]).expect("two parts");
    let rows = run(&parts, &store, &work, |_| ());
    assert_eq!(rows.iter().map(|r| r.code).collect::<Vec<_>>(), [70, 130]);
    let error = rows[0].error.as_ref().expect("an error");
    assert!(error.code == "E070" && rows[0].line.contains("on purpose"), "{:?}", rows[0]);
    assert!(s.names("out/parts").is_empty(), "what broke down is not kept");
}

#[test]
fn every_part_of_the_corpus_ends_with_its_code() {
    let given = std::env::var_os("AMCHECK_MODELS").map(PathBuf::from);
    let folder = given.unwrap_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/models")));
    if !folder.is_dir() {
        println!("skipped: no models at {}", folder.display());
        return;
    }
    // Quick checks only: what is told here is how files end, not what is found in them.
    let s = Scratch::with(&[]);
    let folder = folder.to_string_lossy().into_owned();
    let (exit, rows) = s.batch(&[&folder, "--out", "out", "--only", "mesh,build-volume"]);
    assert_eq!((exit, rows.len()), (4, 70));
    let refused: Vec<&str> = seen(&rows).into_iter().filter(|r| r.1 == 4).map(|r| r.0).collect();
    assert_eq!(
        refused,
        [
            "broken/bad_vertex.stl",
            "broken/build_item_missing_object.3mf",
            "broken/decimal_comma.3mf",
            "broken/dtd_in_model.3mf",
            "broken/empty_0_bytes.stl",
            "broken/empty_header_only.stl",
            "broken/empty_solid_26_bytes.stl",
            "broken/float_max.obj",
            "broken/fuzz_bad_crc.3mf",
            "broken/fuzz_crash.ply",
            "broken/index_out_of_range.obj",
            "broken/not_a_zip.3mf",
            "broken/soup_100_loose.stl",
            "broken/truncated_ascii.stl",
            "formats/beam_lattice_only.3mf",
            "formats/points_only.ply",
        ]
    );
    assert!(seen(&rows).iter().all(|r| [0, 1, 4].contains(&r.1)), "{rows:?}");
    // Each is refused at once; the guard is wide because other tests run beside this one.
    let slow: Vec<&Value> = rows.iter().filter(|r| r["code"] == 4 && r["seconds"].as_f64() > Some(1.0)).collect();
    assert!(slow.is_empty(), "{slow:?}");
}
