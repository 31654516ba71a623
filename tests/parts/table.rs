//! Check × fixture × process → state and value: the table of expected results.

use crate::{findings, fixtures, judge_bytes, process};
use amcheck::analyze::Options;
use amcheck::check::State::{self, Fail, NotApplicable, Pass, Undecided, Warn};

/// One expected result; `value` is the worst finding's, `count` how many places it stands for.
pub struct Row {
    pub code: &'static str,
    pub part: &'static str,
    pub process: &'static str,
    pub limits: &'static [&'static str],
    pub state: State,
    pub value: Option<f64>,
    pub count: u64,
}

const fn row(code: &'static str, part: &'static str, state: State, value: Option<f64>, count: u64) -> Row {
    Row { code, part, process: "fdm", limits: &[], state, value, count }
}

/// Values are exact but for float32 coordinates, hence the tolerance of 2e-6 mm (half a step at 20 mm, twice).
pub const TABLE: &[Row] = &[
    row("AM001", "block", Pass, None, 0),
    row("AM001", "block_open", Undecided, None, 1),
    row("AM001", "bar_through_itself", Warn, Some(12.0), 1),
    row("AM002", "block", Pass, None, 0),
    row("AM002", "bar_300", Warn, Some(300.0 / 220.0), 1),
    Row { process: "sla", ..row("AM002", "bar_300", Fail, Some(310.0 / std::f64::consts::SQRT_2 / 145.0), 1) },
    row("AM101", "wall_111_200", Pass, None, 0),
    row("AM101", "wall_111_024", Fail, Some(0.24), 1),
    row("AM101", "wall_080", Warn, Some(0.8), 1),
    Row { limits: &["thin-wall=0.8mm,0.8mm"], ..row("AM101", "wall_080", Pass, None, 0) },
    Row { limits: &["thin-wall=0.81mm"], ..row("AM101", "wall_080", Fail, Some(0.8), 1) },
    row("AM101", "finned_bracket", Fail, Some(0.45), 1),
    row("AM103", "finned_bracket", Fail, Some(0.15), 1),
    row("AM201", "finned_bracket", Warn, Some(0.0), 1),
    row("AM101", "block", Pass, None, 0),
    row("AM102", "pin_400", Pass, None, 0),
    row("AM102", "pin_060", Fail, Some(0.6), 1),
    Row { limits: &["thin-pin=0.5mm,0.5mm"], ..row("AM102", "pin_060_tall", Warn, Some(15.0), 1) },
    Row { limits: &["thin-pin=0.6mm,0.6mm"], ..row("AM102", "pin_060", Pass, None, 0) },
    row("AM101", "pin_060", Pass, None, 0),
    row("AM104", "hole_200", Pass, None, 0),
    row("AM104", "hole_100", Fail, Some(1.0), 1),
    Row { process: "sla", ..row("AM104", "hole_100", Pass, None, 0) },
    row("AM105", "wedge_60", Pass, None, 0),
    row("AM105", "wedge_20", Warn, Some(20.0), 1),
    row("AM105", "block", Pass, None, 0),
    row("AM103", "pair_100", Pass, None, 0),
    row("AM103", "pair_010", Fail, Some(0.1), 1),
    row("AM103", "slits_015", Fail, Some(0.15), 5),
    row("AM103", "block", Pass, None, 0),
    row("AM201", "ramp_45", Pass, None, 0),
    row("AM201", "ramp_30", Warn, Some(30.0), 1),
    Row { limits: &["overhang=35deg"], ..row("AM201", "ramp_30", Fail, Some(30.0), 1) },
    Row { process: "sls", ..row("AM201", "ramp_30", NotApplicable, None, 0) },
    row("AM201", "table", Pass, None, 0),
    row("AM201", "tunnel_05", Pass, None, 0),
    row("AM201", "tunnel_10", Warn, None, 1),
    row("AM202", "table", Pass, None, 0),
    row("AM202", "table_hanging", Warn, Some(6.0), 1),
    row("AM501", "table", Pass, None, 0),
    row("AM501", "block_cavity", Pass, None, 0),
    Row { limits: &["bridge=5mm"], ..row("AM501", "block_cavity", Warn, None, 1) },
    row("AM501", "tunnel_05", Pass, None, 0),
    Row { process: "sls", ..row("AM501", "block_cavity", NotApplicable, None, 0) },
    row("AM502", "block", NotApplicable, None, 0),
    Row { process: "sls", ..row("AM502", "block", Pass, None, 0) },
    Row { process: "sls", ..row("AM502", "block_cavity", Warn, Some(600.0), 1) },
    Row { limits: &["island=0mm2"], ..row("AM202", "table_hanging", Fail, Some(6.0), 1) },
    row("AM203", "table", Pass, None, 0),
    row("AM203", "block", Pass, None, 0),
    row("AM203", "tunnel_05", Pass, None, 0),
    row("AM203", "tunnel_10", Warn, Some(10.0), 1),
    row("AM203", "table_40", Warn, Some(40.0), 1),
    Row { limits: &["bridge=30mm,10mm"], ..row("AM203", "table_40", Fail, Some(40.0), 1) },
    Row { limits: &["bridge=40mm,40mm"], ..row("AM203", "table_40", Pass, None, 0) },
    row("AM203", "finned_bracket", Warn, Some(8.0), 1),
    Row { process: "sls", ..row("AM203", "table_40", NotApplicable, None, 0) },
    row("AM204", "block", Pass, None, 0),
    row("AM204", "table", Pass, None, 0),
    row("AM204", "gallows", Warn, Some(1664.0 / 736.0), 1),
    Row { limits: &["support=0.1"], ..row("AM204", "ramp_30", Fail, None, 1) },
    Row { process: "mjf", ..row("AM204", "gallows", NotApplicable, None, 0) },
    row("AM205", "block", Pass, None, 0),
    row("AM205", "pillar_12", Pass, None, 0),
    row("AM205", "pillar_24", Warn, None, 1),
    row("AM205", "gallows", Warn, None, 1),
    Row { process: "sla", ..row("AM205", "pin_060_tall", Pass, None, 0) },
    Row { limits: &["tall-feature=14.9"], process: "sla", ..row("AM205", "pin_060_tall", Fail, None, 1) },
    row("AM206", "block", Pass, None, 0),
    row("AM206", "gallows", Pass, None, 0),
    Row { limits: &["bed-contact=0.5"], ..row("AM206", "gallows", Fail, Some(0.2), 1) },
    Row { process: "sls", ..row("AM206", "gallows", NotApplicable, None, 0) },
    row("AM301", "block", Pass, None, 0),
    row("AM301", "hollow_sealed", Warn, Some(4096.0), 1),
    row("AM301", "slits_015", Warn, None, 5),
    row("AM301", "flask_020", Pass, None, 0),
    Row { process: "sls", ..row("AM301", "hollow_sealed", Fail, Some(4096.0), 1) },
    Row { process: "sls", ..row("AM301", "flask_020", Fail, None, 1) },
    row("AM301", "vial_008", Pass, None, 0),
    // A ball of 3 mm, the fail limit, just fits into the room; only narrower rooms are not judged by it.
    Row { process: "sls", ..row("AM301", "vial_008", Fail, Some(0.8), 1) },
    Row { process: "sls", limits: &["trapped-volume=3.1mm,3.5mm"], ..row("AM301", "vial_008", Warn, Some(0.8), 1) },
    Row { process: "sls", ..row("AM301", "basin", Pass, None, 0) },
    Row { process: "lpbf", ..row("AM301", "basin", Pass, None, 0) },
    Row { process: "sla", ..row("AM302", "block", Pass, None, 0) },
    Row { process: "sla", ..row("AM302", "basin", Warn, None, 1) },
    row("AM302", "basin", NotApplicable, None, 0),
    row("AM402", "block", Pass, None, 0),
    row("AM402", "pair_100", Pass, None, 0),
    row("AM402", "pair_010", Warn, Some(1.0), 1),
    row("AM602", "block", Pass, None, 0),
    row("AM602", "pair_100", Pass, None, 0),
    row("AM602", "pair_010", Warn, Some(0.05), 1),
    row("AM106", "block", Pass, None, 0),
    row("AM106", "rib_010", Warn, None, 1),
    // The corner of a cube of edge a: a/√3 from its corner to the face across, a³/6.
    row("AM101", "speck_025", Fail, Some(0.144337567), 1),
    Row { limits: &["lost-feature=1mm3,0.001mm3"], ..row("AM106", "speck_025", Warn, Some(0.0026041667), 1) },
    row("AM106", "speck_025", Pass, Some(0.0026041667), 0),
    row("AM106", "relief_050", Warn, Some(0.3), 1),
    Row { limits: &["lost-feature.engraved=0.3mm,0.3mm"], ..row("AM106", "relief_050", Warn, Some(0.5), 1) },
    Row {
        limits: &["lost-feature.engraved=0.3mm,0.3mm", "lost-feature.embossed=0.5mm,0.5mm"],
        ..row("AM106", "relief_050", Pass, None, 0)
    },
    row("AM401", "block", Pass, None, 0),
    row("AM401", "rib_010", Warn, None, 1),
    // All of the slot but for half an element from its rim: 0.1 × (10 − 0.4) × (10 − 0.3).
    row("AM401", "pair_010", Warn, Some(9.312), 1),
    row("AM401", "pair_100", Pass, None, 0),
    Row { process: "sla", ..row("AM401", "block", Pass, None, 0) },
    Row { process: "sls", ..row("AM601", "block", Pass, None, 0) },
    Row { process: "sls", ..row("AM601", "bracket_round", Pass, None, 0) },
    Row { process: "sls", ..row("AM601", "bracket_sharp", Warn, Some(0.0), 1) },
    row("AM601", "bracket_sharp", NotApplicable, None, 0),
    Row { limits: &["blend=0.4mm"], ..row("AM601", "bracket_sharp", Fail, Some(0.0), 1) },
];

#[test]
fn every_row_of_the_table_holds() {
    for r in TABLE {
        let options = Options::new(process(r.process, r.limits));
        let report = judge_bytes(r.part, &fixtures::bytes(r.part), &options).expect("a report");
        let check = report.checks.iter().find(|c| c.code == r.code).expect("in the registry");
        let place = format!("{} on {} {:?}: {:?}", r.code, r.part, r.limits, check.findings);
        assert_eq!(check.state, r.state, "{place}");
        let found = findings(&report, r.code);
        assert_eq!(found.first().map_or(0, |f| f.count), r.count, "{place}");
        if let (Some(value), Some(f)) = (r.value, found.first()) {
            let exact = f.basis == amcheck::check::Basis::Exact || f.high - f.low < 1e-9;
            let close = !exact || (f.value - value).abs() <= 2e-6;
            assert!(close && f.low <= value + 2e-6 && value <= f.high + 2e-6, "{place}");
            assert!(f.fix.chars().any(|c| c.is_ascii_digit()) || r.code == "AM001", "a fix has a number: {place}");
        }
    }
}

#[test]
fn fins_side_by_side_are_separate_places() {
    let options = Options::new(process("fdm", &[]));
    let report = judge_bytes("finned_bracket", &fixtures::bytes("finned_bracket"), &options).expect("a report");
    let fins: Vec<f64> = findings(&report, "AM101").iter().map(|f| f.value).filter(|v| *v < 0.95).collect();
    assert_eq!(fins.len(), 3, "{fins:?}");
    // Float32 coordinates near 40 mm have a step of 4e-6 mm.
    assert!(fins.iter().zip([0.45, 0.6, 0.9]).all(|(v, t)| (v - t).abs() < 8e-6), "{fins:?}");
}

#[test]
fn every_check_has_a_part_that_breaks_it_and_one_that_passes() {
    for meta in amcheck::check::registry::metas() {
        let states: Vec<State> = TABLE.iter().filter(|r| r.code == meta.code).map(|r| r.state).collect();
        assert!(states.contains(&Pass), "{} has no passing part", meta.code);
        assert!(states.iter().any(|s| matches!(s, Warn | Fail)), "{} has no failing part", meta.code);
    }
}

#[test]
fn a_bar_that_runs_through_itself_has_the_volume_of_the_union() {
    let options = Options::new(process("fdm", &[]));
    let bytes = fixtures::bytes("bar_through_itself");
    let report = judge_bytes("bar_through_itself", &bytes, &options).expect("a report");
    let volume = report.part.volume_mm3;
    assert!(volume.low <= 896.0 && 896.0 <= volume.high, "{volume:?}");
    // 32 mm² of top and bottom are covered twice; a voxel cut by two sheets has the sum of their shares, at most half a
    // voxel too much.
    let most = 896.0 + 0.5 * 32.0 * report.grid.spacing_mm;
    assert!((896.0 - 1e-3..most).contains(&volume.value), "{volume:?}");
}

#[test]
fn no_support_is_offered_in_a_sealed_void() {
    let options = Options::new(process("fdm", &[]));
    let report = judge_bytes("hollow_sealed", &fixtures::bytes("hollow_sealed"), &options).expect("a report");
    let found: Vec<_> = ["AM201", "AM203"].iter().flat_map(|code| findings(&report, code)).collect();
    assert!(!found.is_empty(), "its roof hangs over");
    for f in found {
        assert!(f.fix.ends_with("a support would stay in there: the void is sealed"), "{}", f.fix);
    }
    // The same surface above a room that is open is offered one.
    let report = judge_bytes("ramp_30", &fixtures::bytes("ramp_30"), &options).expect("a report");
    assert!(findings(&report, "AM201")[0].fix.contains("be supported"));
}
