//! Seeded mutations of the corpus through the whole command: 1,400 files, one table.

use crate::good;
use crate::mutations::{Lcg, mutate};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Exit codes that a part may end with.
const CODES: [u64; 5] = [0, 1, 3, 4, 5];

/// A part that is in work for so many seconds hangs. This asks for no speed: beside other tests one that takes 4 s takes 14.
const HANGS: f64 = 60.0;

/// Kinds of failure whose place is the whole file: not a format that is read, nothing in it, too large.
const OF_THE_WHOLE: [&str; 3] = ["E012", "E013", "E020"];

/// Suffix and bytes of the files that are taken apart: the formats, and what people draw.
fn corpus() -> Vec<(&'static str, Vec<u8>)> {
    let parts = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/parts");
    let fixture = |name: &str| std::fs::read(parts.join(name)).expect("a fixture");
    vec![
        ("stl", good::stl_binary()),
        ("stl", good::stl_text()),
        ("obj", good::obj_text()),
        ("ply", good::ply_binary()),
        ("ply", good::ply_text()),
        ("3mf", good::threemf_package()),
        ("stl", fixture("wall_080.stl")),
        ("stl", fixture("pair_010.stl")),
        ("stl", fixture("block_cavity.stl")),
        ("stl", fixture("slits_015.stl")),
    ]
}

/// A folder of one test's own, gone with it.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Judges so many mutations of every file of the corpus as one batch; the rows of its table.
fn batch(name: &str, of_each: u64, more: &[&str]) -> Vec<Value> {
    let folder = Folder(std::env::temp_dir().join(format!("amcheck-pipeline-{name}-{}", std::process::id())));
    let parts = folder.0.join("in");
    std::fs::create_dir_all(&parts).expect("a temporary folder");
    for (at, (suffix, whole)) in corpus().into_iter().enumerate() {
        for case in 0..of_each {
            let mut random = Lcg(case * 2654435761 + 97 * at as u64 + name.len() as u64);
            let mut bytes = whole.clone();
            (0..1 + random.below(3)).for_each(|_| mutate(&mut bytes, &mut random));
            std::fs::write(parts.join(format!("{at}-{case}.{suffix}")), bytes).expect("a file");
        }
    }
    let output = Command::new(env!("CARGO_BIN_EXE_amcheck"))
        .args(["batch", "in", "--out", "out", "--json", "--format", "json", "--jobs", "2"])
        .args(more)
        .current_dir(&folder.0)
        .output()
        .expect("amcheck starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let rows: Vec<Value> =
        text.lines().map(|l| serde_json::from_str(l).unwrap_or_else(|e| panic!("{l}: {e}"))).collect();
    assert_eq!(rows.len() as u64, 10 * of_each, "{}", String::from_utf8_lossy(&output.stderr));
    rows
}

/// What every line must keep.
fn hold(rows: &[Value]) {
    let mut judged = 0;
    for row in rows {
        let code = row["code"].as_u64().expect("a code");
        assert!(CODES.contains(&code), "{row}");
        assert!(row["seconds"].as_f64() < Some(HANGS), "{row}");
        // Both parts that are in work count, and nothing is told where the system does not tell.
        assert!(row["peak_mib"].as_f64().is_none_or(|mib| mib < 2048.0), "{row}");
        let error = &row["error"];
        let whole = OF_THE_WHOLE.iter().any(|c| error["code"] == *c);
        assert!(code < 4 || whole || error["place"].is_string(), "no place: {row}");
        judged += usize::from(code < 4);
    }
    println!("{judged} of {} were judged", rows.len());
    // Mutations that all are refused, or none, would test nothing.
    assert!(rows.len() / 10 < judged && judged < 4 * rows.len() / 5, "{judged} of {}", rows.len());
}

#[test]
fn every_mutation_of_the_corpus_ends_in_a_line_of_the_table() {
    // What deposits and what tools reach take a second a part; the other test runs them too.
    // The allowance keeps grids coarse; every tenth case would else be a cube of seventeen million samples.
    hold(&batch("quick", 140, &["--memory", "224MiB", "--skip", "as-printed,topology,support-access,tool-access"]));
}

#[test]
fn some_mutations_go_through_every_check() {
    // Some more than above: the part turned before its tools.
    let rows = batch("all", 6, &["--memory", "300MiB", "--process", "lpbf"]);
    hold(&rows);
}
