//! The command as a user meets it: exit codes, messages, files, and nothing left behind.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A folder of one test's own, gone with it; runs start in it.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("amcheck-cli-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        Scratch(folder)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.0.join(name), bytes).expect("a file in the temporary folder");
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.0.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect("UTF-8")
    }

    fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.join(folder)).expect("a folder");
        let mut names: Vec<String> = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_amcheck"));
        command.args(arguments).current_dir(&self.0).env_remove("NO_COLOR").stdin(Stdio::null());
        command
    }

    fn run(&self, arguments: &[&str]) -> Ran {
        Ran::from(self.command(arguments).output().expect("amcheck starts"), arguments)
    }

    /// Runs what must be refused with an exit code and an error code, in at most five lines, leaving nothing.
    fn refused(&self, arguments: &[&str], exit: i32, code: &str, words: &[&str]) -> Ran {
        let before = self.names(".");
        let ran = self.run(arguments);
        let said = format!("{arguments:?} ended with {} and said:\n{}", ran.exit, ran.err);
        assert_eq!(ran.exit, exit, "{said}");
        assert!(ran.out.is_empty() && ran.err.lines().count() <= 5, "{said}");
        for word in [format!("error[{code}]: ").as_str(), "\n  help: "].iter().chain(words) {
            assert!(ran.err.contains(word), "`{word}` is missing: {said}");
        }
        assert_eq!(self.names("."), before, "something was left: {said}");
        ran
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// How a run ended and what it said.
struct Ran {
    exit: i32,
    out: String,
    err: String,
}

impl Ran {
    fn from(output: Output, arguments: &[&str]) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap_or_else(|e| panic!("{arguments:?} wrote no UTF-8: {e}"));
        let exit = output.status.code().unwrap_or_else(|| panic!("{arguments:?} was killed: {}", output.status));
        Ran { exit, out: text(output.stdout), err: text(output.stderr) }
    }
}

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/parts")
}

fn fixture(name: &str) -> String {
    fixtures().join(format!("{name}.stl")).to_string_lossy().into_owned()
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(fixture(name)).expect("a fixture")
}

/// A binary STL of facets given by their corners.
fn stl(facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((facets.len() as u32).to_le_bytes());
    for facet in facets {
        bytes.extend([0; 12]);
        bytes.extend(facet.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Facets that have nothing to do with each other.
fn soup() -> Vec<u8> {
    let mut state = 1u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f32 / (1 << 24) as f32 * 10.0
    };
    let facets: Vec<_> = (0..30).map(|_| [0; 3].map(|_| [0; 3].map(|_| next()))).collect();
    stl(&facets)
}

#[test]
fn a_warning_that_may_be_none_is_undecided() {
    let s = Scratch::new();
    let part = fixture("finned_bracket");
    let asked = [part.as_str(), "--refine", "1000", "--only", "as-printed", "--out", "r"];
    let ran = s.run(&[&asked[..], &["--fail-on", "undecided"]].concat());
    assert_eq!(ran.exit, 1, "{}", ran.out);
    assert_eq!(s.run(&[&asked[..], &["--fail-on", "fail"]].concat()).exit, 0);
    let report: serde_json::Value = serde_json::from_str(&s.text("r/report.json")).expect("JSON");
    let check =
        report["checks"].as_array().expect("checks").iter().find(|c| c["name"] == "as-printed").expect("it ran");
    assert!(check["state"] == "warn" && check["findings"][0]["decided"] == false, "{check}");
    assert!(report["grid"]["refined"].as_u64() <= report["grid"]["refine_budget"].as_u64(), "{}", report["grid"]);
    let page = s.text("r/report.html");
    assert!(
        page.contains("0 of 22 verdicts are decided, 1 of the warnings may be none"),
        "what the page says of how sure it is"
    );
    // The bracket is 0 to 10.8: ± 6 about 8 leaves some of it out.
    let told = page.split("How sure is that?").nth(1).expect("the question").split("</p>").next().expect("an answer");
    assert!(told.contains("8 mm³ ± 8 mm³"), "{told}");
}

#[test]
fn the_worst_value_stands_beside_the_limit_that_it_is_judged_by() {
    let mut judged = 0;
    let reports = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/reports")).expect("reports");
    for path in reports.map(|e| e.expect("a report").path()) {
        let text = std::fs::read_to_string(&path).expect("UTF-8");
        let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        for check in report["checks"].as_array().expect("checks") {
            let (state, worst, limit) = (check["state"].as_str(), &check["worst"], &check["limit"]);
            let (Some(value), Some(sense)) = (worst["value"].as_f64(), limit["sense"].as_str()) else { continue };
            // A value on its limit is as good as one that meets it.
            let breaks = |key: &str| {
                limit[key].as_f64().is_some_and(|l| if sense == "min" { value < l - 1e-5 } else { value > l + 1e-5 })
            };
            let as_told = match state {
                Some("pass") => !breaks("fail") && !breaks("warn"),
                Some("warn") => breaks("warn") || check["findings"][0]["decided"] == false,
                Some("fail") => breaks("fail"),
                _ => continue,
            };
            assert!(as_told, "{}: {} {state:?} {worst} {limit}", path.display(), check["name"]);
            judged += 1;
        }
    }
    assert!(judged > 300, "{judged}");
    let s = Scratch::new();
    let pair = fixture("pair_010");
    let limits = ["--only", "narrow-gap", "--limit", "narrow-gap.between-bodies=0.05mm,0.07mm"];
    let report: serde_json::Value =
        serde_json::from_str(&s.run(&[&[pair.as_str(), "--json"][..], &limits].concat()).out).expect("JSON");
    let check =
        report["checks"].as_array().expect("checks").iter().find(|c| c["name"] == "narrow-gap").expect("it ran");
    assert!(check["state"] == "pass" && check["worst"]["value"] == 0.1 && check["limit"]["fail"] == 0.05, "{check}");
}

#[test]
fn a_unit_that_a_file_names_is_told_and_overruled_aloud() {
    let s = Scratch::new();
    let block = fixture("block");
    assert_eq!(s.run(&["offset", block.as_str(), "--by", "0.5mm", "--out", "in_mm.3mf"]).exit, 0);
    let judged = |more: &[&str]| -> serde_json::Value {
        let ran = s.run(&[&["in_mm.3mf", "--json", "--only", "build-volume"], more].concat());
        serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{e}: {}{}", ran.out, ran.err))
    };
    let overruled = |report: &serde_json::Value| {
        let warnings = report["warnings"].as_array().expect("warnings");
        warnings.iter().find(|w| w["code"] == "units-overruled").map(|w| w["message"].to_string())
    };
    let plain = judged(&[]);
    assert!(plain["part"]["units"] == "mm" && plain["part"]["units_from"] == "file", "{}", plain["part"]);
    assert!(overruled(&plain).is_none() && overruled(&judged(&["--units", "mm"])).is_none());
    let said = overruled(&judged(&["--units", "in"])).expect("a warning");
    assert!(said.contains("its unit is mm; it was read as in"), "{said}");
    let swept = s.run(&["offset", "in_mm.3mf", "--by", "0.5mm", "--units", "cm", "--out", "o.stl"]);
    assert!(swept.out.contains("its unit is mm; it was read as cm"), "{}{}", swept.out, swept.err);
}

#[test]
fn a_path_may_have_a_line_of_names_and_no_comma_too_many() {
    let s = Scratch::new();
    s.write("path.csv", "x,y,z\r\n0,0,0\r\n5,0,0\r\n");
    s.write("comma.csv", "0,0,0,\n5,0,0,\n");
    let swept = s.run(&["sweep", "box:2x2x2mm", "--along", "path.csv", "--out", "o.stl"]);
    assert_eq!((swept.exit, swept.err.as_str()), (0, ""), "{}", swept.out);
    let asked = ["sweep", "box:2x2x2mm", "--along", "comma.csv", "--out", "p.stl"];
    s.refused(&asked, 4, "E011", &["comma.csv: line 1", "a comma stands behind the 3 numbers", "take the comma"]);
}

#[test]
fn what_orient_wrote_is_what_it_says() {
    let s = Scratch::new();
    let block = fixture("block");
    for (formats, names) in
        [("stl", &["best.stl"][..]), ("json,html,stl", &["orientations.html", "orientations.json", "best.stl"])]
    {
        let ran = s.run(&["orient", block.as_str(), "--best", "2", "--out", "o", "--format", formats]);
        let line = ran.out.lines().find(|l| l.starts_with("written:")).unwrap_or_else(|| panic!("{}", ran.out));
        assert!(names.iter().all(|n| line.contains(n)), "{line}");
        assert!(ran.out.contains("note: best.stl stands on z = 0 at x = "), "{}", ran.out);
    }
}

#[test]
fn another_pose_is_another_condition() {
    let s = Scratch::new();
    let block = fixture("block");
    for (up, out) in [("+z", "a"), ("-x", "b")] {
        s.run(&[block.as_str(), "--only", "build-volume", "--up", up, "--out", out]);
    }
    let said = s.run(&["compare", "a/report.json", "b/report.json"]).out;
    assert!(said.contains("judged otherwise: up +z → -x"), "{said}");
}

#[test]
fn the_exit_code_is_the_verdict() {
    let s = Scratch::new();
    for (part, more, exit) in [
        ("block", &[][..], 0),
        ("wall_111_024", &[], 1),
        ("wall_111_024", &["--fail-on", "never"], 0),
        ("wall_080", &[], 0),
        ("wall_080", &["--fail-on", "warn"], 1),
        ("flask_020", &["--process", "sla", "--voxel", "1mm", "--only", "trapped-volume", "--refine", "1"], 3),
        ("block_open", &[], 3),
        ("block_open", &["--fail-on", "undecided"], 1),
        ("block_open", &["--fail-on", "never"], 0),
        // A part that no check judged is no part that passes.
        ("block", &["--only", "drain"], 3),
    ] {
        let part = fixture(part);
        let ran = s.run(&[&[part.as_str(), "--format", "json", "--quiet"], more].concat());
        assert_eq!((ran.exit, ran.err.as_str()), (exit, ""), "{part} {more:?}: {}", ran.out);
        assert_eq!(ran.out.lines().count(), 1, "{}", ran.out);
    }
}

#[test]
fn the_command_to_type_next_judges_by_the_same() {
    let s = Scratch::new();
    let part = fixture("flask_020");
    let by = ["--up", "+x", "--limit", "trapped-volume=2.5mm,3.5mm", "--tool", "end-mill-3", "--tool-from=-z"];
    let asked = ["--process", "sla", "--voxel", "1mm", "--only", "trapped-volume", "--refine", "1", "--format", "json"];
    let ran = s.run(&[&[part.as_str()], &asked[..], &by[..]].concat());
    let next = "--up +x --voxel 1mm --limit 'trapped-volume=2.5mm,3.5mm' --tool end-mill-3 --tool-from -z --only trapped-volume --refine 1M";
    assert!(ran.exit == 3 && ran.out.contains(next), "{}", ran.out);
}

#[test]
fn words_that_make_no_sense_are_refused() {
    let s = Scratch::new();
    let block = fixture("block");
    let with = |more: &[&str], code: &str, words: &[&str]| {
        s.refused(&[&[block.as_str()], more].concat(), 2, code, words);
    };
    with(&["--bogus"], "E001", &["--bogus"]);
    with(&["--proces", "fdm"], "E001", &["--proces", "did you mean `--process`?"]);
    with(&["--json", "--quiet"], "E001", &["--json", "--quiet"]);
    with(&["--process", "fmd"], "E002", &["`fmd`", "`fdm`"]);
    with(&["--limit", "thinwall=0.4mm"], "E002", &["`thinwall`", "`thin-wall`"]);
    with(&["--limit", "thin-wall=0.4deg"], "E001", &["0.4deg"]);
    with(&["--limit", "thin-wall"], "E001", &["thin-wall=0.4mm"]);
    for voxel in ["0", "0mm", "nan", "-1", "-1mm", "inf", "1e99mm", "1e-9", ""] {
        with(&["--voxel", voxel], "E001", &[voxel]);
    }
    for width in ["0", "-1mm", "nan", "1e9mm", "1m", ""] {
        with(&["--thickness", width], "E001", &[]);
    }
    for count in ["0", "-1", "x", "1TiB"] {
        with(&[&format!("--memory={count}")], "E001", &[count]);
    }
    for count in ["-3", "4G", "2e9", "abc", ""] {
        with(&["--memory", count], "E001", &[&format!("--memory `{count}` is no number of bytes"), "--memory 4GiB"]);
    }
    with(&["--memory", "10"], "E001", &["--memory `10` is 10 B, too little", "KiB, MiB, GiB", "--memory 4GiB"]);
    with(&["--refine", "64MiB"], "E001", &["--refine `64MiB` is no number of samples", "--refine 64M"]);
    for limit in ["overhang=91deg", "thin-wall=nan", "thin-wall=-1mm", "thin-wall=0.8mm,0.4mm", "narrow-gap=infmm"] {
        with(&["--limit", limit], "E001", &[]);
    }
    with(&["--limit", "thin-wall=0.4mm", "--limit", "AM101 =0.5mm"], "E001", &["thin-wall is given twice", "0.5mm"]);
    for option in [["--faces", "+z:30deg"], ["--tool-from", "axes"], ["--tool-tilt", "30deg"]] {
        with(&option, "E001", &[option[0], "fdm has none", "--tool end-mill-3"]);
    }
    for none in [&["--only", "mesh", "--skip", "AM001"][..], &["--only", "mesh,drain", "--skip", "drain,mesh"]] {
        with(none, "E001", &["--only mesh", "leaves no check to run"]);
    }
    with(&["--only", "thinwall"], "E002", &["`thin-wall`"]);
    with(&["--skip", "AM999"], "E002", &["AM999"]);
    with(&["--format", "jsn"], "E002", &["`json`"]);
    with(&["--fail-on", "warm"], "E002", &["`warn`"]);
    with(&["--fail-on", "new"], "E001", &["--baseline"]);
    with(&["--units", "inch"], "E002", &["`inch`"]);
    with(&["--up", "+w"], "E001", &["+w"]);
    with(&["--threads", "0"], "E001", &["--threads"]);
    with(&["--threads", "99999"], "E001", &["99999", "--threads"]);
    with(&["--process", "none.toml"], "E003", &["none.toml"]);
    s.refused(&["explain", "thinwall"], 2, "E002", &["`thin-wall`"]);
}

#[test]
fn what_was_meant_by_a_mistyped_command_is_said() {
    let s = Scratch::new();
    s.write("block.stl", bytes("block"));
    for (words, code, said) in [
        (&["orinet", "block.stl"][..], "E002", &["unknown command `orinet`", "did you mean `orient`?"][..]),
        (&["orinet", "block.stl", "--best", "3"], "E002", &["did you mean `orient`?"]),
        (&["explan", "E014"], "E002", &["did you mean `explain`?"]),
        (&["proceses"], "E002", &["did you mean `processes`?"]),
        (&["frobnicate", "block.stl"], "E002", &["unknown command `frobnicate`", "known are", "orient"]),
        (&["block.stl", "b.stl"], "E001", &["one part is judged at a time", "`amcheck batch block.stl b.stl`"]),
        (&["block.stl", "block.stl", "--process", "sla"], "E001", &["`amcheck batch block.stl block.stl`"]),
        (&["block.stl", "--only", "mesh", "orient"], "E001", &["`amcheck orient block.stl`"]),
        (&["--quiet", "orient", "block.stl"], "E001", &["`orient` stands behind options", "`amcheck orient …`"]),
        (&["--quiet", "processes"], "E001", &["`processes` stands behind options"]),
    ] {
        s.refused(words, 2, code, said);
    }
}

#[test]
fn what_is_no_fault_is_not_to_be_repaired() {
    let s = Scratch::new();
    s.write("nested.stl", boxes(&[[[0.0; 3], [10.0; 3]], [[2.0; 3], [8.0; 3]]]));
    let nested = s.run(&["nested.stl", "--repair", "--only", "mesh", "--json", "--format", "json"]);
    assert!(nested.exit == 0 && nested.out.contains("nothing was to be repaired"), "{}", nested.out);
    let told = s.run(&["explain", "E014"]).out;
    assert!(told.contains("encloses nothing") && told.contains("one missing facet"), "{told}");
}

#[test]
fn one_is_told_as_one() {
    let s = Scratch::new();
    s.write("block.stl", bytes("block"));
    let one = s.run(&["batch", "block.stl", "--only", "mesh", "--out", "b", "--format", "json"]);
    assert!(one.out.contains("1 part in ") && one.out.contains("1 does not fail"), "{}", one.out);
    let merged = s.run(&["merge", "b", "--out", "m"]);
    assert!(merged.out.starts_with("1 part: 1 does not fail"), "{}", merged.out);
    assert!(s.text("b/index.html").contains("<h1>1 part</h1>"));
    let point = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";
    s.write("point.ply", point);
    s.refused(&["point.ply"], 4, "E013", &["holds 1 point and no faces"]);
}

#[test]
fn what_test_cases_and_alerts_say_are_sentences() {
    let s = Scratch::new();
    let formats = ["--only", "thin-wall", "--out", "r", "--format", "json,junit,sarif"];
    s.run(&[&[fixture("wall_111_024").as_str()], &formats[..]].concat());
    let read = |name: &str| serde_json::from_str::<serde_json::Value>(&s.text(name)).expect("JSON");
    let found = read("r/report.json")["checks"].as_array().expect("checks").clone();
    let finding = found.iter().find_map(|c| c["findings"].get(0)).expect("a finding");
    let sentence = |key: &str| {
        let text = finding[key].as_str().expect("a text");
        text[..1].to_uppercase() + text[1..].trim_end_matches('.')
    };
    let [message, fix] = ["message", "fix"].map(sentence);
    let alert =
        read("r/report.sarif")["runs"][0]["results"][0]["message"]["text"].as_str().expect("a text").to_string();
    assert!(alert.starts_with(&format!("{message}. ")) && alert.ends_with(&format!(" mm. {fix}")), "{alert}");
    let tests = s.text("r/report.junit.xml").replace("&#39;", "'").replace("&quot;", "\"").replace("&gt;", ">");
    assert!(tests.contains(&format!(" mm: {message}. {fix}")), "{tests}");
}

#[test]
fn a_limit_by_which_nothing_is_judged_is_told() {
    let s = Scratch::new();
    let block = fixture("block");
    let told = |more: &[&str]| {
        let ran = s.run(&[&[block.as_str(), "--json", "--format", "json", "--out", "r"], more].concat());
        let report: serde_json::Value = serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{e}: {}", ran.err));
        let warnings = report["warnings"].as_array().expect("warnings").iter();
        warnings.filter(|w| w["code"] == "limit-idle").map(|w| w["message"].to_string()).collect::<Vec<_>>()
    };
    let idle = told(&["--only", "thin-wall", "--limit", "overhang=30deg", "--limit", "narrow-gap=0.3mm"]);
    assert!(idle.len() == 2 && idle.iter().any(|text| text.contains("overhang")), "{idle:?}");
    assert!(told(&["--only", "overhang", "--limit", "overhang=30deg"]).is_empty());
    // What a profile limits is there for every run.
    s.write("mine.toml", "inherits = \"fdm\"\n[limits.overhang]\nfail = \"30deg\"\n");
    assert!(told(&["--only", "thin-wall", "--process", "mine.toml"]).is_empty());
    // A process with tools of its own needs none.
    assert!(told(&["--process", "lpbf", "--only", "mesh", "--tool-from", "axes"]).is_empty());
}

#[test]
fn a_profile_with_an_unknown_key_is_refused_at_its_line() {
    let s = Scratch::new();
    s.write("mine.toml", "inherits = \"fdm\"\n[machine]\nlayer_heigth_mm = 0.2\n");
    s.refused(
        &[&fixture("block"), "--process", "mine.toml"],
        2,
        "E003",
        &["--> mine.toml: line 3", "`machine.layer_heigth_mm`", "did you mean `layer_height_mm`?"],
    );
}

#[test]
fn what_cannot_be_read_is_named() {
    let s = Scratch::new();
    s.write("block.stl", bytes("block"));
    s.write("cut.stl", &bytes("block")[..300]);
    s.write("text.stl", "Dear reader, this is no part.\n");
    s.write("empty.stl", "");
    s.write("soup.stl", soup());
    s.write("one.stl", stl(&[[[0.0; 3], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]]]));
    std::fs::create_dir(s.0.join("folder")).expect("a folder");
    for (part, code, words) in [
        ("blok.stl", "E010", &["no such file", "did you mean `block.stl`?"][..]),
        ("folder", "E010", &["directory"]),
        ("cut.stl", "E011", &["byte 300", "triangle 5 of 12"]),
        ("text.stl", "E012", &["text"]),
        ("empty.stl", "E013", &["empty"]),
        ("soup.stl", "E014", &["not a solid"]),
        ("one.stl", "E014", &["not a solid"]),
    ] {
        s.refused(&[part, "--out", "results"], 4, code, &[&[part], words].concat());
    }
    s.refused(&["block.stl", "--baseline", "text.stl"], 4, "E011", &["text.stl", "line 1"]);
    s.refused(&["compare", "text.stl", "none.json"], 4, "E011", &["text.stl", "line 1"]);
    s.write("later.json", "{\"schema\": \"amcheck-report/2\", \"verdicts\": []}");
    s.refused(&["compare", "later.json", "later.json"], 2, "E001", &["amcheck-report/2", "amcheck-report/1"]);
    let ran = s.run(&["cut.stl", "--salvage", "--json", "--format", "json"]);
    assert!(ran.exit != 70 && ran.err.lines().count() <= 5, "{}{}", ran.out, ran.err);
}

#[test]
fn a_grid_that_is_too_large_says_which_spacing_fits() {
    let s = Scratch::new();
    let (block, budget) = (fixture("block"), ["--memory", "320MiB", "--format", "json", "--quiet"]);
    let ran = s.refused(
        &[&[block.as_str(), "--voxel", "0.001mm"], &budget[..]].concat(),
        5,
        "E020",
        &["needs ", " GB", "allowed are 335.5 MB", "0.001 mm"],
    );
    let fits = ran.err.split_whitespace().skip_while(|w| *w != "--voxel").nth(1).expect("a spacing");
    assert_eq!(s.run(&[&[block.as_str(), "--voxel", fits], &budget[..]].concat()).exit, 0, "{fits} does not fit");
}

#[test]
fn what_judging_takes_is_known_before_it_is_spent() {
    let s = Scratch::new();
    let bracket = fixture("finned_bracket");
    let plan = s.run(&[&bracket, "--plan"]);
    assert_eq!((plan.exit, plan.err.as_str()), (0, ""));
    assert!(s.names(".").is_empty(), "nothing is written");
    let json = s.run(&[&bracket, "--json", "--format", "json"]).out;
    let report: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let samples = format!("{} mm, {} samples", report["grid"]["spacing_mm"], report["grid"]["samples"]);
    for said in ["116 triangles", samples.as_str(), "memory  at most ", " of 4.3 GB allowed", " s of one processor"] {
        assert!(plan.out.contains(said), "no {said:?} in {}", plan.out);
    }
    s.refused(&[&bracket, "--plan", "--voxel", "0.001mm"], 5, "E020", &["--voxel"]);
    // Facets are those of the file, as in the report, where what passes through itself is united before it is judged.
    let crossed = "bar_through_itself";
    let facets = u32::from_le_bytes(bytes(crossed)[80..84].try_into().expect("four bytes"));
    let plan = s.run(&[&fixture(crossed), "--plan"]).out;
    assert!(plan.contains(&format!("stl: {facets} triangles, ")), "{facets}: {plan}");
}

#[test]
fn a_place_that_cannot_be_written_is_known_before_the_work() {
    let s = Scratch::new();
    s.write("file", "x");
    s.refused(&[&fixture("block"), "--out", "file/results"], 6, "E030", &["file/results", "--out"]);
    assert_eq!(s.read("file"), b"x");
}

#[test]
fn a_run_that_fails_leaves_the_earlier_report() {
    let s = Scratch::new();
    assert_eq!(s.run(&[&fixture("block"), "--out", "a/b", "--quiet"]).exit, 0);
    let (names, report) = (s.names("a/b"), s.read("a/b/report.json"));
    assert!(names.contains(&"report.html".into()) && names.iter().all(|n| !n.contains("partial")), "{names:?}");
    s.write("cut.stl", &bytes("block")[..300]);
    s.refused(&["cut.stl", "--out", "a/b"], 4, "E011", &[]);
    s.refused(&["cut.stl", "--out", "c/d"], 4, "E011", &[]);
    assert_eq!((s.names("a/b"), s.read("a/b/report.json")), (names, report));
}

#[test]
fn what_is_accepted_is_shown_and_does_not_count_until_its_day() {
    let s = Scratch::new();
    let entry = |more: &str| {
        format!(
            "[[accept]]\ncheck = \"thin-wall\"\nbox_mm = [[-20, -20, -20], [20, 20, 20]]\nreason = \"a living hinge\"\n{more}"
        )
    };
    s.write("accept.toml", entry("until = 2027-06-30\n"));
    s.write("mine.toml", format!("inherits = \"fdm\"\n{}", entry("")));
    s.write("bad.toml", entry("untill = 2027-06-30\n"));
    s.write("unknown.toml", entry("").replace("thin-wall", "thin-wal"));
    s.write("idle.toml", entry("").replace("[[-20, -20, -20], [20, 20, 20]]", "[[90, 90, 90], [91, 91, 91]]"));
    let part = fixture("wall_111_024");
    let run = |more: &[&str]| s.run(&[&[part.as_str(), "--only", "thin-wall", "--out", "r"], more].concat());
    let formats = "json,html,markdown,junit,sarif";
    let held = run(&["--accept", "accept.toml", "--today", "2027-06-30", "--format", formats]);
    assert_eq!(held.exit, 0, "{}{}", held.out, held.err);
    assert!(
        held.out.contains("1 accepted") && held.out.contains("accepted until 2027-06-30: a living hinge"),
        "{}",
        held.out
    );
    let text = |name: &str| String::from_utf8(s.read(&format!("r/{name}"))).expect("UTF-8");
    let report: serde_json::Value = serde_json::from_str(&text("report.json")).expect("JSON");
    let finding = &report["checks"][2]["findings"][0];
    assert_eq!((&report["verdict"], &finding["state"]), (&"pass".into(), &"fail".into()));
    assert_eq!(finding["accepted"], serde_json::json!({"reason": "a living hinge", "until": "2027-06-30"}));
    assert!(text("report.junit.xml").contains("<skipped message=\"– thin-wall[1]"), "{}", text("report.junit.xml"));
    assert!(text("report.sarif").contains("\"justification\": \"a living hinge\""));
    for page in ["report.html", "report.md"] {
        assert!(text(page).contains("a living hinge"), "{page}");
    }
    s.write("held.json", text("report.json"));
    let against = ["--baseline", "held.json", "--fail-on", "new", "--format", "json,markdown,junit,sarif"];
    let withdrawn = run(&against);
    assert_eq!(withdrawn.exit, 1, "{}", withdrawn.out);
    assert_eq!(withdrawn.out.matches("no longer accepted").count(), 2, "{}", withdrawn.out);
    assert!(withdrawn.out.contains("baseline: 1 same (1 no longer accepted)"), "{}", withdrawn.out);
    assert!(text("report.md").contains(", no longer accepted |"), "{}", text("report.md"));
    let failure = "<failure message=\"no longer accepted: ✖ thin-wall[1]";
    assert!(text("report.junit.xml").contains(failure), "{}", text("report.junit.xml"));
    let alerts: serde_json::Value = serde_json::from_str(&text("report.sarif")).expect("JSON");
    let alert = &alerts["runs"][0]["results"][0];
    assert!(alert["message"]["text"].as_str().is_some_and(|t| t.contains(". No longer accepted")), "{alert}");
    assert!(alert["baselineState"] == "updated" && alert["suppressions"].is_null(), "{alert}");
    assert_eq!(run(&[&against[..], &["--accept", "accept.toml", "--today", "2027-06-30"]].concat()).exit, 0);
    for name in ["report.junit.xml", "report.sarif"] {
        assert!(!text(name).to_lowercase().contains("no longer"), "{name}");
    }
    let ended = run(&["--accept", "accept.toml", "--today", "2027-07-01"]);
    assert_eq!(ended.exit, 1, "{}", ended.out);
    assert!(ended.out.contains("acceptance ended on 2027-06-30: a living hinge"), "{}", ended.out);
    assert_eq!(run(&["--process", "mine.toml"]).exit, 0);
    let idle = run(&["--accept", "idle.toml", "--json"]);
    assert!(idle.exit == 1 && idle.out.contains("acceptance-unused"), "{}", idle.out);
    s.write("kind.toml", entry("kind = \"wal\"\n"));
    let misspelt = run(&["--accept", "kind.toml", "--json"]);
    assert!(misspelt.exit == 1 && misspelt.out.contains("none is of the kind `wal`, only of "), "{}", misspelt.out);
    s.refused(&[&part, "--accept", "bad.toml"], 2, "E003", &["bad.toml: line 5", "untill"]);
    s.refused(&[&part, "--accept", "unknown.toml"], 2, "E003", &["unknown.toml: line 1", "`thin-wall`"]);
    s.refused(&[&part, "--accept", "none.toml"], 2, "E003", &["none.toml"]);
    s.refused(&[&part, "--today", "yesterday"], 2, "E001", &["2026-11-21"]);
}

#[test]
fn the_entries_of_the_page_accept_every_finding() {
    let s = Scratch::new();
    let part = fixture("finned_bracket");
    assert_eq!(s.run(&[&part, "--out", "r", "--quiet"]).exit, 1);
    let page = s.text("r/report.html");
    let shown = page.split("<pre tabindex=\"0\">").skip(1).filter_map(|rest| rest.split("</pre>").next());
    let entries: String = shown.filter(|text| text.starts_with("[[accept]]")).collect::<Vec<_>>().join("\n");
    let report = |folder: &str| -> serde_json::Value {
        serde_json::from_str(&s.text(&format!("{folder}/report.json"))).expect("JSON")
    };
    let findings = |report: &serde_json::Value| -> Vec<serde_json::Value> {
        let checks = report["checks"].as_array().expect("checks").iter();
        checks.flat_map(|c| c["findings"].as_array().into_iter().flatten().cloned()).collect()
    };
    let before = findings(&report("r"));
    assert!(before.len() > 3 && entries.matches("[[accept]]").count() == before.len(), "{entries}");
    s.write("accept.toml", entries.replace("&quot;", "\"").replace('…', "meant"));
    let ran = s.run(&[&part, "--accept", "accept.toml", "--out", "t"]);
    assert_eq!(ran.exit, 0, "{}{}", ran.out, ran.err);
    let after = findings(&report("t"));
    assert!(after.len() == before.len() && after.iter().all(|f| f["accepted"]["reason"] == "meant"), "{after:#?}");
    assert!(!s.text("t/report.html").contains("[[accept]]"));
}

#[test]
fn a_watched_part_is_judged_again_when_it_changes() {
    use std::io::{BufRead, BufReader};
    let s = Scratch::new();
    s.refused(&["-", "--watch"], 2, "E001", &["standard input"]);
    s.write("part.stl", bytes("wall_111_200"));
    let mut child = s
        .command(&["part.stl", "--watch", "--only", "thin-wall", "--format", "json"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("amcheck starts");
    let mut lines = BufReader::new(child.stdout.take().expect("a pipe")).lines().map_while(Result::ok);
    let first: Vec<String> = lines.by_ref().take_while(|l| !l.starts_with("watching")).collect();
    assert!(first.iter().any(|l| l.contains("PRINTABLE") && !l.contains("NOT")), "{first:?}");
    let old = s.text("reports/part/report.json");
    // Written under another name first, as most programs save.
    s.write("part.stl.new", bytes("wall_111_024"));
    std::fs::rename(s.0.join("part.stl.new"), s.0.join("part.stl")).expect("a file");
    let second: Vec<String> = lines.by_ref().take_while(|l| !l.starts_with("compared")).collect();
    assert!(second.iter().any(|l| l.contains("NOT PRINTABLE")), "{second:?}");
    assert!(second.iter().any(|l| l.starts_with("new") && l.contains("0.24 mm")), "{second:?}");
    assert_ne!(old, s.text("reports/part/report.json"));
    child.kill().expect("it still runs");
    child.wait().expect("it ends");
}

#[test]
fn json_is_one_document_that_the_schema_accepts() {
    let s = Scratch::new();
    let schema = serde_json::from_str(&s.run(&["schema"]).out).expect("the schema is JSON");
    let validator = jsonschema::validator_for(&schema).expect("the schema is one");
    for (part, more) in [
        ("block", &[][..]),
        ("block_open", &[]),
        ("wall_111_024", &["--process", "lpbf", "--up", "-y"]),
        ("flask_020", &["--process", "sla", "--voxel", "1mm", "--refine", "1"]),
        ("bar_300", &["--only", "build-volume", "--units", "in"]),
    ] {
        let part = fixture(part);
        let ran = s.run(&[&[part.as_str(), "--json", "--out", "r"], more].concat());
        let report: serde_json::Value = serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{part}: {e}"));
        let faults: Vec<String> = validator.iter_errors(&report).map(|e| format!("{}: {e}", e.instance_path)).collect();
        assert!(faults.is_empty() && ran.err.is_empty(), "{part}: {faults:?} {}", ran.err);
        assert_eq!(s.text("r/report.json"), ran.out, "{part}: the file says something else");
    }
}

#[test]
fn boxes_are_those_of_the_file_however_the_part_is_turned() {
    let s = Scratch::new();
    let part = fixture("wall_111_024");
    let boxes = |up: &str| {
        let ran = s.run(&[&part, "--json", "--out", "r", "--only", "thin-wall", "--up", up]);
        let report: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
        let mut checks = report["checks"].as_array().expect("a list").iter();
        let wall = checks.find_map(|c| c["findings"].get(0)).expect("a finding");
        [&report["part"]["box_mm"], &wall["box_mm"]]
            .map(|b| serde_json::from_value::<[[f64; 3]; 2]>(b.clone()).expect("a box"))
    };
    let [whole, wall] = boxes("+z");
    for up in ["+x", "-y", "0.36,0.48,0.8", "-0.639893,-0.195635,0.743145"] {
        let [turned, found] = boxes(up);
        let near = |a: f64, b: f64| (a - b).abs() < 2e-4;
        assert!((0..3).all(|a| near(turned[0][a], whole[0][a]) && near(turned[1][a], whole[1][a])), "{up}: {turned:?}");
        // Of a place the box is that in the build, as the file has it, which holds the place.
        assert!((0..3).all(|a| found[0][a] < wall[0][a] + 0.1 && found[1][a] > wall[1][a] - 0.1), "{up}: {found:?}");
    }
}

#[test]
fn a_part_that_is_refused_does_not_keep_the_verdict_of_an_earlier_one() {
    let s = Scratch::new();
    std::fs::copy(fixture("block"), s.0.join("part.stl")).expect("a part");
    let run = |only: &str| s.run(&["part.stl", "--out", "r", "--format", "json,badge", "--only", only]);
    assert_eq!(run("mesh").exit, 0);
    let badge = || String::from_utf8(s.read("r/badge.svg")).expect("UTF-8");
    assert!(badge().contains("printable"), "{}", badge());
    // A wrong word says nothing of the part.
    assert!(run("mash").exit == 2 && badge().contains("printable"));
    s.write("part.stl", "solid of nothing\nendsolid\n");
    let refused = run("mesh");
    assert_eq!(refused.exit, 4, "{}", refused.err);
    assert!(refused.err.contains("note: r/report.json is of an earlier run"), "{}", refused.err);
    assert!(badge().contains("not judged"), "{}", badge());
    // A file that is asked about is never replaced, whatever its name.
    std::fs::create_dir(s.0.join("own")).expect("a folder");
    s.write("own/badge.svg", "<svg/>");
    assert_eq!(s.run(&["own/badge.svg", "--out", "own"]).exit, 4);
    assert_eq!(s.read("own/badge.svg"), b"<svg/>");
    let elsewhere = s.run(&["part.stl", "--out", "new"]);
    assert!(elsewhere.exit == 4 && !elsewhere.err.contains("note:") && !s.0.join("new").exists(), "{}", elsewhere.err);
}

#[test]
fn a_part_that_is_refused_is_an_error_of_junit_and_an_alert() {
    let s = Scratch::new();
    s.write("part.stl", bytes("block"));
    let run = |more: &[&str]| s.run(&[&["part.stl", "--only", "mesh", "--out", "r"], more].concat());
    let tests = || s.text("r/report.junit.xml");
    let alerts = || serde_json::from_str::<serde_json::Value>(&s.text("r/report.sarif")).expect("JSON");
    let is_refused = |word: &str| {
        let (tests, alerts) = (tests(), alerts());
        assert!(tests.contains("tests=\"1\" failures=\"0\" errors=\"1\"") && tests.contains("<error "), "{tests}");
        assert!(tests.contains("name=\"part.stl\"") && tests.contains(word), "{tests}");
        let result = &alerts["runs"][0]["results"][0];
        assert!(
            result["level"] == "error" && result["ruleId"].as_str().is_some_and(|id| id.starts_with('E')),
            "{result}"
        );
        assert_eq!(result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"], "part.stl");
        assert_eq!(alerts["runs"][0]["invocations"][0]["executionSuccessful"], false);
    };
    let both = ["--format", "json,junit,sarif"];
    assert_eq!(run(&both).exit, 0);
    assert!(tests().contains("errors=\"0\"") && alerts()["runs"][0]["results"].as_array().is_some_and(Vec::is_empty));
    s.write("part.stl", &bytes("block")[..300]);
    let refused = run(&both);
    assert!(refused.exit == 4 && refused.err.contains("note: r/report.json is of an earlier run"), "{}", refused.err);
    is_refused("byte 300");
    // What an earlier run left says so as well where nothing of the kind is asked for now.
    s.write("part.stl", bytes("block"));
    assert_eq!(run(&["--format", "junit,sarif"]).exit, 0);
    s.write("part.stl", "");
    let refused = run(&["--format", "json"]);
    assert!(refused.exit == 4 && !refused.err.contains("note:"), "{}", refused.err);
    is_refused("E013");
    assert_eq!(s.names("r"), [".amcheck-files", "report.junit.xml", "report.sarif", "timings.json"]);
    // A part that is not there, and one that is too large, are missing from no list either.
    std::fs::remove_file(s.0.join("part.stl")).expect("a part");
    assert_eq!(run(&both).exit, 4);
    is_refused("E010");
    s.write("part.stl", bytes("block"));
    assert_eq!(run(&[&both[..], &["--voxel", "0.001mm", "--memory", "320MiB"]].concat()).exit, 5);
    is_refused("E020");
    assert_eq!(run(&both).exit, 0);
    assert!(tests().contains("errors=\"0\""));
}

/// A run that goes on until it is stopped, which a test that fails does as well.
#[cfg(unix)]
struct Going(std::process::Child);

#[cfg(unix)]
impl Drop for Going {
    fn drop(&mut self) {
        let _ = self.0.kill();
    }
}

#[cfg(unix)]
#[test]
fn a_watched_part_that_breaks_or_goes_is_told_as_in_any_other_run() {
    use std::io::{BufRead, BufReader};
    let s = Scratch::new();
    s.write("part.stl", bytes("block"));
    let mut command = s.command(&["part.stl", "--watch", "--only", "mesh", "--format", "json,badge,junit"]);
    let going = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let Going(child) = &mut Going(going.expect("amcheck starts"));
    let mut out = BufReader::new(child.stdout.take().expect("a pipe")).lines().map_while(Result::ok);
    let mut told = BufReader::new(child.stderr.take().expect("a pipe")).lines().map_while(Result::ok);
    assert!(out.any(|l| l.starts_with("watching 1 file")));
    std::fs::remove_file(s.0.join("part.stl")).expect("a part");
    assert_eq!(told.next().as_deref(), Some("note: part.stl is gone; it is judged again when it is back"));
    // Long enough for several more looks: it is told once.
    std::thread::sleep(std::time::Duration::from_millis(1600));
    s.write("part.stl", &bytes("block")[..300]);
    let error: Vec<String> = told.by_ref().take(5).collect();
    for said in
        ["error[E011]", "--> part.stl: byte 300", "help: ", "note: reports/part/report.json is of an earlier run"]
    {
        assert!(error.iter().any(|l| l.contains(said)), "no {said} in {error:?}");
    }
    assert!(s.text("reports/part/badge.svg").contains("not judged"));
    assert!(s.text("reports/part/report.junit.xml").contains("errors=\"1\""));
    s.write("part.stl", bytes("block"));
    assert!(out.any(|l| l.contains("no finding changed")));
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(0));
    assert_eq!(told.collect::<Vec<_>>(), Vec::<String>::new());
}

#[test]
fn what_ends_with_an_exit_code_is_a_failure_of_junit_and_alerts_name_the_file_as_it_was_given() {
    let s = Scratch::new();
    std::fs::create_dir(s.0.join("left side")).expect("a folder");
    std::fs::copy(fixture("wall_111_024"), s.0.join("left side/part.stl")).expect("a part");
    let run = |fail_on: &str| {
        let limited = ["./left side/part.stl", "--only", "thin-wall", "--limit", "thin-wall=0.1mm,0.6mm"];
        s.run(&[&limited[..], &["--out", "r", "--format", "junit,sarif", "--fail-on", fail_on]].concat()).exit
    };
    let failures = || String::from_utf8(s.read("r/report.junit.xml")).expect("UTF-8").matches("<failure ").count();
    assert_eq!((run("fail"), failures()), (0, 0));
    assert_eq!((run("warn"), failures()), (1, 1));
    let alerts = String::from_utf8(s.read("r/report.sarif")).expect("UTF-8");
    assert!(alerts.contains("\"uri\": \"left%20side/part.stl\""), "{alerts}");
    // However it is spelt: below the folder from there, elsewhere from the root.
    std::fs::create_dir(s.0.join("work")).expect("a folder");
    let given = s.0.join("left side/part.stl").to_string_lossy().into_owned();
    for (from, path, named) in [
        (".", given.as_str(), "\"left%20side/part.stl\""),
        (".", "work/../left side/part.stl", "\"left%20side/part.stl\""),
        ("work", "../left side/part.stl", "\"file:///"),
        ("work", given.as_str(), "\"file:///"),
    ] {
        let arguments = [path, "--only", "mesh", "--format", "sarif", "--out", "q"];
        let ran = s.command(&arguments).current_dir(s.0.join(from)).output().expect("amcheck starts");
        assert!(ran.status.success(), "{from} {path}: {ran:?}");
        let alerts = s.text(&format!("{from}/q/report.sarif"));
        let uri = alerts.split("\"uri\": ").nth(1).and_then(|rest| rest.lines().next()).expect("a place");
        assert!(uri.starts_with(named) && uri.contains("left%20side/part.stl\""), "{from} {path}: {uri}");
    }
}

#[test]
fn the_same_part_gives_the_same_bytes() {
    let s = Scratch::new();
    let formats = "json,html,png,glb,markdown,junit,sarif,badge";
    let runs = [("a", "1"), ("b", "2"), ("c", "2"), ("d", "3")];
    for (out, threads) in runs {
        let ran = s.run(&[&fixture("slits_015"), "--quiet", "--format", formats, "--out", out, "--threads", threads]);
        assert!(s.names(out).len() > 12 && ran.err.is_empty(), "{:?} {}", s.names(out), ran.err);
    }
    for (other, _) in &runs[1..] {
        assert_eq!(s.names("a"), s.names(other));
        for name in s.names("a").iter().filter(|n| *n != "timings.json") {
            assert!(s.read(&format!("a/{name}")) == s.read(&format!("{other}/{name}")), "{name} differs in {other}");
        }
    }
}

#[test]
fn the_summary_is_short_and_plain() {
    let s = Scratch::new();
    for entry in std::fs::read_dir(fixtures()).expect("the fixtures").flatten() {
        let part = entry.path().to_string_lossy().into_owned();
        if !part.ends_with(".stl") {
            continue;
        }
        let ran = s.run(&[&part, "--format", "json"]);
        assert!((4..=30).contains(&ran.out.lines().count()), "{part}:\n{}", ran.out);
        assert!(!ran.out.contains('\u{1b}') && ran.err.is_empty(), "{part}:\n{}{}", ran.out, ran.err);
    }
    let named = s.command(&[&fixture("block"), "--format", "json"]).env("NO_COLOR", "1").output().expect("runs");
    assert!(!named.stdout.contains(&0x1b) && !named.stderr.contains(&0x1b));
}

#[test]
fn what_is_known_can_be_asked_for() {
    let s = Scratch::new();
    let check = s.run(&["explain", "AM101"]);
    assert_eq!(check.out, s.run(&["explain", "thin-wall"]).out);
    for (arguments, words) in [
        (&["explain", "AM101"][..], &["thin-wall", "Source", "Limits by process"][..]),
        (&["explain", "E011"], &["E011", "Exit code 4"]),
        (&["processes"], &["fdm", "sla", "sls", "mjf", "lpbf", "binder-jet", "inherits"]),
        (&["completions", "bash"], &["_amcheck", "--process"]),
        (&["--help"], &["--voxel", "Exit codes"]),
        (&["--version"], &[env!("CARGO_PKG_VERSION")]),
    ] {
        let ran = s.run(arguments);
        assert_eq!((ran.exit, ran.err.as_str()), (0, ""), "{arguments:?}");
        assert!(words.iter().all(|w| ran.out.contains(w)), "{arguments:?} lacks one of {words:?}:\n{}", ran.out);
    }
    assert!(s.names(".").is_empty(), "asking leaves no file");
}

#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let s = Scratch::new();
    let block = fixture("block");
    for arguments in [&[block.as_str(), "--json", "--format", "json"][..], &["completions", "zsh"], &["--help"]] {
        let mut child =
            s.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("amcheck starts");
        drop(child.stdout.take());
        let ran = Ran::from(child.wait_with_output().expect("it ends"), arguments);
        assert_eq!((ran.exit, ran.err.as_str()), (0, ""), "{arguments:?}");
    }
}

#[test]
fn a_part_can_come_by_standard_input() {
    let s = Scratch::new();
    let input = std::fs::File::open(fixture("wall_111_024")).expect("a fixture");
    let output = s.command(&["-", "--format", "json", "--quiet"]).stdin(input).output().expect("amcheck runs");
    assert_eq!(Ran::from(output, &["-"]).exit, 1);
    assert!(s.names("reports/stdin").contains(&"report.json".into()));
}

/// The name holds a slash, so that `<` becomes a folder; the file's own name still closes and opens elements.
#[cfg(unix)]
#[test]
fn the_name_of_a_part_is_no_markup() {
    let s = Scratch::new();
    let names = ["</script><img src=x>.stl", "--><img src=x onerror=y>.stl", "\u{1b}[31m<img src=x>.stl"];
    std::fs::create_dir(s.0.join("<")).expect("a folder");
    for name in names {
        s.write(name, bytes("block"));
        let part = format!("./{name}");
        let ran = s.run(&[&part, "--out", "r", "--format", "json,html,markdown,junit,sarif,badge"]);
        assert_eq!((ran.exit, ran.err.as_str()), (0, ""), "{name}");
        assert!(!ran.out.contains('\u{1b}'), "{name}: an escape sequence reaches the terminal");
        for page in ["report.html", "report.md", "report.junit.xml", "badge.svg"] {
            assert!(!s.text(&format!("r/{page}")).contains("<img src=x"), "{name} is markup in {page}");
        }
        let page = s.text("r/report.html");
        assert_eq!(page.matches("</script>").count(), page.matches("<script").count(), "{name} ends a script");
        s.run(&["orient", &part, "--directions", "4", "--best", "1", "--format", "html", "--out", "r"]);
        assert!(!s.text("r/orientations.html").contains("<img src=x"), "{name} is markup among the orientations");
    }
}

#[test]
fn reports_are_compared() {
    let s = Scratch::new();
    let (block, wall) = (fixture("block"), fixture("wall_111_024"));
    let only = ["--only", "thin-wall", "--format", "json", "--out"];
    s.run(&[&[block.as_str()][..], &only, &["block"]].concat());
    s.run(&[&[wall.as_str()][..], &only, &["wall"]].concat());
    let new = |part: &str, old: &str| {
        let old = format!("{old}/report.json");
        s.run(&[&[part, "--baseline", &old, "--fail-on", "new"][..], &only, &["r"]].concat())
    };
    assert_eq!([new(&wall, "wall").exit, new(&wall, "block").exit, new(&block, "wall").exit], [0, 1, 0]);
    let compare =
        |old: &str, new: &str| s.run(&["compare", &format!("{old}/report.json"), &format!("{new}/report.json")]);
    for (old, now, exit, word) in
        [("block", "wall", 1, "1 new"), ("wall", "block", 0, "1 fixed"), ("wall", "wall", 0, "1 same")]
    {
        let ran = compare(old, now);
        assert_eq!((ran.exit, ran.err.as_str()), (exit, ""), "{old} {now}");
        assert!(ran.out.contains(word), "{old} {now}: {}", ran.out);
    }
    // The same wall of 0.24 mm, which warns by one limit and fails by another.
    for (limit, out) in [("thin-wall=0.2mm,0.5mm", "warns"), ("thin-wall=0.5mm", "fails")] {
        s.run(&[&[wall.as_str(), "--limit", limit, "--fail-on", "never"][..], &only, &[out]].concat());
    }
    for (old, now, exit, words) in [
        ("warns", "fails", 1, ["1 worse", "warn → fail"]),
        ("fails", "warns", 0, ["1 better", "fail → warn"]),
        ("fails", "fails", 0, ["1 same", "compared"]),
    ] {
        let ran = compare(old, now);
        assert_eq!(ran.exit, exit, "{old} {now}: {}", ran.out);
        assert!(words.iter().all(|w| ran.out.contains(w)), "{old} {now}: {}", ran.out);
    }
    let ran = s.run(
        &[
            &[wall.as_str(), "--limit", "thin-wall=0.5mm", "--baseline", "warns/report.json", "--fail-on", "new"][..],
            &only,
            &["r"],
        ]
        .concat(),
    );
    assert_eq!(ran.exit, 1, "{}", ran.out);
}

#[test]
fn what_the_baseline_did_not_run_is_not_compared() {
    let s = Scratch::new();
    let wall = fixture("wall_111_024");
    let json = ["--format", "json", "--fail-on", "never", "--out"];
    s.run(&[&[wall.as_str(), "--only", "mesh"][..], &json, &["old"]].concat());
    s.run(&[&[wall.as_str(), "--only", "mesh,thin-wall"][..], &json, &["now"]].concat());
    let ran = s.run(&["compare", "old/report.json", "now/report.json"]);
    assert_eq!(ran.exit, 0, "{}", ran.out);
    assert!(ran.out.contains("not compared: the baseline did not run AM101 thin-wall"), "{}", ran.out);
    assert!(ran.out.contains("1 unchecked"), "{}", ran.out);
    let since = ["--only", "mesh,thin-wall", "--baseline", "old/report.json", "--fail-on", "new", "--out", "r"];
    let ran = s.run(&[&[wall.as_str()][..], &since].concat());
    assert_eq!(ran.exit, 0, "{}", ran.out);
}

#[test]
fn what_is_undecided_or_warns_and_is_new_is_no_success() {
    let s = Scratch::new();
    let names = ["block", "block_open", "wall_080"];
    for name in names {
        s.run(&[&fixture(name), "--format", "json", "--fail-on", "never", "--out", name]);
    }
    let since = |part: &str, old: &str, fail_on: &str| {
        let (part, old) = (fixture(part), format!("{old}/report.json"));
        s.run(&[&part, "--baseline", &old, "--fail-on", fail_on, "--format", "json,junit,html", "--out", "r"]).exit
    };
    for (part, old, [new, new_warn]) in
        [("block_open", "block", [3, 1]), ("wall_080", "block", [0, 1]), ("block", "block_open", [0, 0])]
    {
        assert_eq!([since(part, old, "new"), since(part, old, "new-warn")], [new, new_warn], "{part} {old}");
        assert_eq!([since(part, part, "new"), since(part, part, "new-warn")], [0, 0], "{part}");
    }
    let compared = s.run(&["compare", "block/report.json", "block_open/report.json"]);
    assert_eq!(compared.exit, 3, "{}", compared.out);
    s.refused(&["block.stl", "--fail-on", "new-warn"], 2, "E001", &["--fail-on new-warn", "--baseline"]);
}

#[test]
fn what_failed_before_is_no_failure_of_the_files_either() {
    let s = Scratch::new();
    let wall = fixture("wall_111_024");
    let run = |more: &[&str]| {
        let usual = [&wall, "--only", "thin-wall", "--format", "json,junit,sarif,html,markdown", "--out", "r"];
        s.run(&[&usual[..], more].concat()).exit
    };
    let failures = || s.text("r/report.junit.xml").matches("<failure ").count();
    assert_eq!((run(&[]), failures()), (1, 1));
    assert!(!s.text("r/report.sarif").contains("baselineState") && !s.text("r/report.json").contains("\"baseline\""));
    s.write("old.json", s.read("r/report.json"));
    assert_eq!((run(&["--baseline", "old.json", "--fail-on", "new"]), failures()), (0, 0));
    assert!(s.text("r/report.junit.xml").contains("was there before"));
    assert!(s.text("r/report.sarif").contains("\"baselineState\": \"unchanged\""));
    let told: serde_json::Value = serde_json::from_str(&s.text("r/report.json")).expect("JSON");
    assert_eq!(told["baseline"]["words"], "1 same");
    assert!(s.text("r/report.html").contains("Against the baseline: 1 same"));
    // Without that, all that fails is a failure.
    assert_eq!((run(&["--baseline", "old.json"]), failures()), (1, 1));
}

#[test]
fn no_report_takes_the_place_of_its_baseline() {
    let s = Scratch::new();
    let (block, wall) = (fixture("block"), fixture("wall_111_024"));
    assert_eq!(s.run(&[&block, "--only", "thin-wall", "--format", "json", "--out", "r/s"]).exit, 0);
    let old = s.read("r/s/report.json");
    let mut spellings = vec!["r/s/report.json", "./r/../r/s/report.json"];
    if cfg!(unix) {
        #[cfg(unix)]
        std::os::unix::fs::symlink("r/s/report.json", s.0.join("link.json")).expect("a link");
        spellings.push("link.json");
    }
    for spelling in spellings {
        let words = [&wall, "--only", "thin-wall", "--out", "r/s", "--baseline", spelling, "--fail-on", "new"];
        s.refused(&words, 2, "E001", &["r/s/report.json", spelling, "--out"]);
        assert!(s.read("r/s/report.json") == old, "{spelling}: the baseline was replaced");
    }
    // What is not written replaces nothing.
    let usual = [wall.as_str(), "--only", "thin-wall", "--out", "r/s", "--format", "junit", "--baseline"];
    assert_eq!(s.run(&[&usual[..], &["r/s/report.json", "--fail-on", "new"]].concat()).exit, 1);
    assert!(s.read("r/s/report.json") == old);
}

/// A binary STL of boxes given by their corners.
fn boxes(corners: &[[[f64; 3]; 2]]) -> Vec<u8> {
    let meshes = corners.iter().map(|[lo, hi]| amcheck::geometry::cuboid(*lo, *hi));
    let facets = |m: amcheck::geometry::TriangleMesh| -> Vec<[[f32; 3]; 3]> {
        (0..m.triangles.len()).map(|f| m.corners(f).map(|p| p.map(|x| x as f32))).collect()
    };
    stl(&meshes.flat_map(facets).collect::<Vec<_>>())
}

#[test]
fn a_joint_that_is_welded_is_worse_and_one_whose_part_is_gone_is_fixed() {
    let s = Scratch::new();
    let first = [[0.0; 3], [10.0; 3]];
    s.write("apart.stl", boxes(&[first, [[10.15, 0.0, 0.0], [20.0, 10.0, 10.0]]]));
    s.write("welded.stl", boxes(&[first, [[10.0, 0.0, 0.0], [20.0, 10.0, 10.0]]]));
    s.write("alone.stl", boxes(&[first]));
    s.write("wider.stl", boxes(&[first, [[11.0, 0.0, 0.0], [20.0, 10.0, 10.0]]]));
    let only = ["--only", "mesh,narrow-gap", "--format", "json,markdown,junit", "--out"];
    assert_eq!(s.run(&[&["apart.stl"][..], &only, &["old"]].concat()).exit, 1);
    let since = |part: &str| {
        s.run(&[&[part, "--baseline", "old/report.json", "--fail-on", "new"][..], &only, &["new"]].concat())
    };
    let welded = since("welded.stl");
    assert_eq!(welded.exit, 1, "{}", welded.out);
    assert!(
        welded.out.contains("bodies 2 → 1") && welded.out.contains("bodies 1 and 2 are one body now"),
        "{}",
        welded.out
    );
    assert!(s.text("new/report.md").contains("Bodies 2 → 1"));
    assert!(s.text("new/report.junit.xml").contains("<failure message=\"worse: 0.15 mm"));
    for (part, words) in [("alone.stl", "bodies 2 → 1"), ("wider.stl", "compared with the baseline: 1 fixed")] {
        let fixed = since(part);
        assert_eq!(fixed.exit, 0, "{part}: {}", fixed.out);
        assert!(fixed.out.contains("1 fixed") && fixed.out.contains(words), "{part}: {}", fixed.out);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_stdout_is_an_error() {
    let s = Scratch::new();
    let block = fixture("block");
    for arguments in [
        &[&block, "--only", "mesh", "--json"][..],
        &["--help"],
        &["processes"],
        &["batch", &block, "--only", "mesh", "--format", "json", "--out", "out"],
    ] {
        let full = std::fs::File::options().write(true).open("/dev/full").expect("a full device");
        let ran = Ran::from(s.command(arguments).stdout(full).output().expect("amcheck starts"), arguments);
        assert_eq!(ran.exit, 6, "{arguments:?}: {}", ran.err);
        assert!(ran.err.contains("error[E030]: cannot write standard output"), "{}", ran.err);
    }
    assert!(s.names("out").contains(&"table.csv".into()), "the work is done all the same");
}

#[test]
fn a_report_of_another_part_does_not_make_way_in_silence() {
    let s = Scratch::new();
    for (from, to) in [("wall_080", "a/part.stl"), ("rib_010", "b/part.stl")] {
        let folder = Path::new(to).parent().expect("a folder");
        std::fs::create_dir_all(s.0.join(folder)).expect("a folder");
        s.write(to, bytes(from));
    }
    let told = |part: &str, more: &[&str]| {
        let ran = s.run(&[&[part, "--only", "thin-wall", "--format", "json"], more].concat());
        ran.out.contains("held the report of another part") && ran.out.contains("--out")
    };
    assert!(!told("a/part.stl", &[]), "the first");
    assert!(!told("./a/../a/part.stl", &[]), "the same again");
    s.write("a/part.stl", bytes("rib_010"));
    assert!(!told("a/part.stl", &[]), "the same, changed");
    assert!(told("b/part.stl", &[]) && !told("b/part.stl", &[]), "another of that name, once");
    assert!(!told("a/part.stl", &["--out", "r"]) && !told("b/part.stl", &["--out", "r"]), "a folder that was named");
    // The report that stands there is of the second part.
    let oriented = |part: &str, more: &[&str]| {
        let ran = s.run(&[&["orient", part, "--directions", "1", "--format", "json"], more].concat());
        assert_eq!(ran.exit, 0, "{}", ran.err);
        ["holds the report of another part beside the orientations", "held the orientations of another part, which"]
            .map(|said| ran.out.contains(said))
    };
    assert_eq!(oriented("b/part.stl", &[]), [false; 2], "its own report");
    assert_eq!(oriented("a/part.stl", &["--out", "o"]), [false; 2], "a folder that was named");
    assert_eq!(oriented("a/part.stl", &[]), [true; 2]);
    assert_eq!(oriented("a/part.stl", &[]), [true, false]);
    let ran = s.run(&["b/part.stl", "--only", "thin-wall", "--format", "json"]);
    assert!(ran.out.contains("holds the orientations of another part beside the report"), "{}", ran.out);
    assert!(s.names("reports").iter().eq(["part"]), "{:?}", s.names("reports"));
}

#[test]
fn no_report_of_an_earlier_run_lies_beside_a_new_one() {
    let s = Scratch::new();
    let part = fixture("wall_111_024");
    let run = |format: &str, more: &[&str]| {
        s.run(&[&[part.as_str(), "--only", "thin-wall", "--out", "r", "--format", format], more].concat());
    };
    run("html,png,json,markdown,sarif", &[]);
    assert!(["report.md", "close-thin-wall.png"].iter().all(|n| s.names("r").contains(&(*n).into())));
    s.write("r/notes.md", "mine");
    s.write("r/photo.png", "mine");
    run("badge", &["--baseline", "r/report.json"]);
    let list = ".amcheck-files";
    assert_eq!(s.names("r"), [list, "badge.svg", "notes.md", "photo.png", "report.json", "timings.json"]);
    run("html", &[]);
    assert_eq!(s.names("r"), [list, "notes.md", "photo.png", "report.html", "timings.json"]);
}

#[test]
fn what_somebody_put_into_the_folder_stays_whatever_its_name() {
    let s = Scratch::new();
    s.write("part.stl", bytes("block"));
    let run = |more: &[&str]| {
        let ran = s.run(&[&["part.stl", "--only", "mesh", "--out", "."], more].concat());
        assert_eq!(ran.exit, 0, "{}", ran.err);
    };
    let mine = ["badge.svg", "best.stl", "bridge.png", "close-blend.png", "report.md", "repaired.3mf", "summary.png"];
    mine.iter().for_each(|name| s.write(name, "mine"));
    let unharmed = |when: &str| mine.iter().for_each(|name| assert_eq!(s.read(name), b"mine", "{name} {when}"));
    run(&["--format", "json"]);
    run(&["--format", "json", "--repair"]);
    let orient = ["orient", "part.stl", "--directions", "4", "--best", "1", "--format", "json", "--out", "."];
    assert_eq!(s.run(&orient).exit, 0);
    unharmed("before anything of that name was written");
    s.write("part.stl", "solid of nothing\nendsolid\n");
    assert_eq!(s.run(&["part.stl", "--out", "."]).exit, 4);
    unharmed("beside a part that is refused");
    s.write("part.stl", bytes("block"));
    // What a run wrote and somebody changed since is theirs; a list that names others' files is none of ours.
    run(&["--format", "markdown,junit"]);
    s.write("report.md", "mine");
    s.write("notes.md", "mine");
    let of_mine = "3fd30542fe3f61b14bd4a4b2dc0b6fb30fa6f63ebce52dd1778aaa8c4dc02cff";
    s.write(".amcheck-files", format!("{}{of_mine}  notes.md\n", s.text(".amcheck-files")));
    run(&["--format", "json"]);
    unharmed("after it was changed");
    assert!(s.names(".").contains(&"notes.md".into()) && !s.names(".").contains(&"report.junit.xml".into()));
}

#[test]
fn the_unit_is_guessed_only_of_what_was_read_as_millimetres() {
    let s = Scratch::new();
    let guessed = |unit: &str| {
        let ran =
            s.run(&[&fixture("block"), "--units", unit, "--only", "mesh", "--json", "--format", "json", "--out", "r"]);
        assert!(ran.out.contains("\"units_from\": \"option\""), "{}", ran.err);
        ran.out.contains("units-guess")
    };
    assert!(!guessed("um") && !guessed("m"));
    let facet = |p: [[f32; 3]; 3]| p.map(|p| p.map(|x| x * 0.02));
    let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    s.write("small.stl", stl(&[[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(facet)));
    let small = s.run(&["small.stl", "--only", "mesh", "--json", "--format", "json", "--out", "r"]);
    assert!(small.out.contains("units-guess"), "{}{}", small.out, small.err);
}

#[test]
fn orientations_of_a_broken_part_say_so() {
    let s = Scratch::new();
    let whole = bytes("block");
    let facets = u32::from_le_bytes(whole[80..84].try_into().expect("four bytes"));
    s.write("open.stl", [&whole[..80], &(facets - 1).to_le_bytes(), &whole[84..whole.len() - 50]].concat());
    let ran = s.run(&["orient", "open.stl", "--directions", "4", "--best", "1", "--format", "json,html", "--out", "r"]);
    assert_eq!(ran.exit, 0, "{}", ran.err);
    for said in ["note: STL (binary) carries no unit", "note: 3 open edges"] {
        assert!(ran.out.contains(said), "{said}: {}", ran.out);
    }
    let answer: serde_json::Value = serde_json::from_str(&s.text("r/orientations.json")).expect("JSON");
    assert_eq!((&answer["watertight"], &answer["warnings"][1]["code"]), (&false.into(), &"open-edges".into()));
    assert!(s.text("r/orientations.html").contains("3 open edges"));
}
