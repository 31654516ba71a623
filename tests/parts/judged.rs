//! What is reported on printed parts, each finding judged by a measure that shares no code with the checks.

use crate::models::corpus;
use crate::{findings, judge_bytes, process};
use amcheck::analyze::Options;
use std::collections::BTreeMap;

/// Each row: process, part, check, kind, place, value, what an independent measure gave, by what measure, and the verdict on the finding.
///
/// In fdm every finding of the checks that are named was judged; in other processes those rows are what a judge found true.
const ROWS: &str = include_str!("../../fixtures/judged/clean.csv");

/// Between a value and the same value judged otherwise, millimetres or degrees: ten times the digits of the table.
const CLOSE: f64 = 0.005;
/// Facets of one slope are told as one finding, whose first place any of them may be.
const SAME_SLOPE: f64 = 0.05;

struct Row {
    check: &'static str,
    kind: &'static str,
    value: f64,
    judged: f64,
    verdict: &'static str,
}

fn rows() -> BTreeMap<[&'static str; 2], Vec<Row>> {
    let mut parts: BTreeMap<[&str; 2], Vec<Row>> = BTreeMap::new();
    for line in ROWS.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [process, part, check, kind, _, _, _, value, judged, _, verdict] = fields[..] else {
            panic!("eleven columns: {line}")
        };
        let number = |text: &str| text.parse::<f64>().unwrap_or_else(|e| panic!("{line}: {e}"));
        parts.entry([process, part]).or_default().push(Row {
            check,
            kind,
            value: number(value),
            judged: number(judged),
            verdict,
        });
    }
    parts
}

fn close(check: &str) -> f64 {
    if check == "AM201" { SAME_SLOPE } else { CLOSE }
}

#[test]
fn what_was_judged_agrees_and_nothing_judged_is_false() {
    for ([process, part], rows) in rows() {
        let part = format!("{part} in {process}");
        for row in rows {
            assert!(["true", "neck"].contains(&row.verdict), "{part}: {} {} is {}", row.check, row.value, row.verdict);
            let apart = (row.value - row.judged).abs();
            assert!(apart <= close(row.check), "{part}: {} {} was judged {}", row.check, row.value, row.judged);
        }
    }
}

#[test]
fn every_finding_on_a_printed_part_has_been_judged() {
    let Some(folder) = corpus() else { return };
    let mut wrong = Vec::new();
    for ([name, part], rows) in rows() {
        let path = folder.join(format!("clean/{part}.stl"));
        let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut checks: Vec<&str> = rows.iter().map(|r| r.check).collect();
        checks.sort_unstable();
        checks.dedup();
        let mut options = Options::new(process(name, &[]));
        if name != "fdm" {
            options.only = checks.iter().map(|c| c.to_string()).collect();
        }
        let report = judge_bytes(part, &bytes, &options).expect("a report");
        let part = format!("{part} in {name}");
        for f in report.checks.iter().flat_map(|c| &c.findings) {
            let [lo, hi] = f.box_mm;
            if !(0..3).all(|a| lo[a] <= f.at_mm[a] && f.at_mm[a] <= hi[a]) {
                wrong.push(format!(
                    "{part}: {} {} at {:?} lies outside of its box {:?}",
                    f.code, f.kind, f.at_mm, f.box_mm
                ));
            }
        }
        for check in checks {
            let mut left: Vec<&Row> = rows.iter().filter(|r| r.check == check).collect();
            for f in findings(&report, check) {
                let known = left.iter().position(|r| r.kind == f.kind && (r.value - f.value).abs() <= close(check));
                match known {
                    Some(i) => drop(left.remove(i)),
                    None if name == "fdm" => {
                        wrong.push(format!("{part}: {check} {} {} at {:?} is not judged", f.kind, f.value, f.at_mm))
                    }
                    None => {}
                }
            }
            wrong.extend(left.iter().map(|r| format!("{part}: {check} {} {} is not found", r.kind, r.value)));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
