//! What the field checks report on the parts of the corpus, beside what slicing or measuring the mesh by other means gave.

use crate::{judge_bytes, process};
use amcheck::analyze::Options;
use amcheck::check::Finding;
use std::path::PathBuf;

/// One finding, or one of its places: the value reported, the number measured independently, and whether that bears it out.
struct Row {
    part: String,
    check: String,
    kind: String,
    at: [f64; 3],
    value: f64,
    judged: f64,
    verdict: String,
}

fn rows() -> Vec<Row> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fixtures/judged/fields.csv");
    let text = std::fs::read_to_string(path).expect("fixtures/judged/fields.csv");
    let number = |s: &str| s.parse::<f64>().unwrap_or(f64::NAN);
    text.lines()
        .skip(1)
        .map(|line| {
            let mut cells = line.splitn(9, ',');
            let mut next = || cells.next().unwrap_or_default().to_string();
            let [part, check, kind] = [0; 3].map(|_| next());
            let [x, y, z, value, judged] = [0; 5].map(|_| number(&next()));
            let rest = next();
            let verdict = rest.rsplit(',').next().unwrap_or_default().to_string();
            Row { part, check, kind, at: [x, y, z], value, judged, verdict }
        })
        .collect()
}

/// Places move by a sample or so between versions of a search; values may not.
fn matches(row: &Row, f: &Finding) -> bool {
    let same = |at: [f64; 3], value: f64| {
        (0..3).all(|a| (at[a] - row.at[a]).abs() < 0.05) && (value - row.value).abs() <= 1e-3 * row.value.abs() + 1e-4
    };
    f.code == row.check
        && f.kind == row.kind
        && (same(f.at_mm, f.value) || f.places.iter().any(|p| same(p.at_mm, p.value)))
}

#[test]
fn every_finding_of_the_field_checks_was_judged_and_is_true() {
    let rows = rows();
    assert!(rows.iter().all(|r| r.judged.is_finite()), "a row without a measure");
    assert!(rows.iter().all(|r| r.verdict != "false"), "a finding known to be false");
    let Some(folder) = crate::models::corpus() else { return };
    let mut checks: Vec<String> = rows.iter().map(|r| r.check.clone()).collect();
    checks.extend(["AM102", "AM302", "AM401", "AM601"].map(String::from));
    checks.sort_unstable();
    checks.dedup();
    let mut files: Vec<_> =
        std::fs::read_dir(folder.join("clean")).expect("clean").flatten().map(|e| e.path()).collect();
    files.sort();
    let mut wrong = Vec::new();
    for file in files {
        let name = file.file_name().and_then(|n| n.to_str()).unwrap_or_default().to_string();
        let options = Options { only: checks.clone(), ..Options::new(process("fdm", &[])) };
        let report = judge_bytes(&name, &std::fs::read(&file).expect("a part"), &options).expect("a report");
        let found = report.findings();
        let own: Vec<&Row> = rows.iter().filter(|r| r.part == name).collect();
        for r in own.iter().filter(|r| r.verdict == "undecided") {
            if !found.iter().any(|f| matches(r, f) && !f.decided) {
                wrong.push(format!("decided: {name} {} {} {} at {:?}", r.check, r.kind, r.value, r.at));
            }
        }
        for f in found.iter().filter(|f| !own.iter().any(|r| matches(r, f))) {
            wrong.push(format!("not judged: {name} {} {} {} at {:?}", f.code, f.kind, f.value, f.at_mm));
        }
        for r in own.iter().filter(|r| !found.iter().any(|f| matches(r, f))) {
            wrong.push(format!("no longer found: {name} {} {} {} at {:?}", r.check, r.kind, r.value, r.at));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
