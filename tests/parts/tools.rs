//! Where tools come from, how far they lean and what they have to touch, on a cube of 20 mm whose truths are plain.

use super::{fixtures, judge_bytes, process};
use amcheck::analyze::Options;
use amcheck::check::State;
use amcheck::process::ToolChoice;
use amcheck::report::CheckReport;
use amcheck::{Error, error::ToolFault};

/// AM502 on the cube for one tool: entries are those of `[tools]`.
fn judged(tool: &str, entries: &[(&str, &[&str])], up: [f64; 3]) -> amcheck::Result<CheckReport> {
    let mut process = process("fdm", &[]);
    process.tools = process.tools.replaced(vec![ToolChoice::named(tool)?]);
    for (key, words) in entries {
        process.tools.finish.set(key, words)?;
    }
    let mut options = Options { only: vec!["tool-access".into()], ..Options::new(process) };
    options.up = Some(amcheck::part::Up::Along(up));
    let report = judge_bytes("block", &fixtures::bytes("block"), &options)?;
    Ok(report.checks.into_iter().find(|c| c.code == "AM502").expect("in the registry"))
}

const UP: [f64; 3] = [0.0, 0.0, 1.0];

#[test]
fn from_above_a_mill_touches_the_top_and_not_the_bottom() {
    let top = judged("end-mill-3", &[("from", &["+z"]), ("faces", &["+z:10deg"])], UP).unwrap();
    assert_eq!(top.state, State::Pass, "{top:?}");
    assert!(top.cover.as_ref().is_some_and(|c| c.contains("from 1 direction")), "{top:?}");
    let bottom = judged("end-mill-3", &[("from", &["+z"]), ("faces", &["-z:10deg"])], UP).unwrap();
    assert_eq!(bottom.state, State::Warn, "{bottom:?}");
    // A mill from above, as long as it is, lies beside the cube and never below it; the patches add up to the face.
    let found = &bottom.findings[0];
    assert!((found.value - 400.0).abs() < 1e-6 && found.high - found.low < 1e-6, "{found:?}");
    let below = judged("end-mill-3", &[("from", &["-z"]), ("faces", &["-z:10deg"])], UP).unwrap();
    assert_eq!(below.state, State::Pass, "{below:?}");
}

#[test]
fn a_machine_that_cannot_lean_is_one_that_comes_from_above() {
    for from in [&["cube"][..], &["axes"], &["faces"], &["sphere:40", "+z"]] {
        let upright =
            judged("end-mill-3", &[("from", from), ("tilt", &["0deg"]), ("faces", &["-z:10deg"])], UP).unwrap();
        assert_eq!(upright.state, State::Warn, "{from:?}: {upright:?}");
        let free = judged("end-mill-3", &[("from", from), ("faces", &["-z:10deg"])], UP).unwrap();
        // Forty directions and one from above: some come from below.
        assert_eq!(free.state, State::Pass, "{from:?}: {free:?}");
    }
}

#[test]
fn directions_and_faces_are_those_of_the_file_and_the_tilt_is_from_the_builds_up() {
    // Built on its side: the file's +z lies level in the build.
    let up = [1.0, 0.0, 0.0];
    let named = judged("end-mill-3", &[("from", &["+z"]), ("faces", &["+z:10deg"])], up).unwrap();
    assert_eq!(named.state, State::Pass, "{named:?}");
    let none = judged("end-mill-3", &[("from", &["+z"]), ("tilt", &["80deg"])], up).unwrap_err();
    assert!(matches!(none, Error::Tool { fault: ToolFault::NoDirections, .. }) && none.exit_code() == 2, "{none}");
    let upright = judged("end-mill-3", &[("tilt", &["0deg"]), ("faces", &["-x:10deg"])], up).unwrap();
    assert_eq!(upright.state, State::Warn, "{upright:?}");
}

#[test]
fn faces_that_are_not_there_are_an_error_and_a_box_holds_what_lies_in_it() {
    let away = judged("end-mill-3", &[("faces", &["box:100,100,100:101,101,101"])], UP).unwrap_err();
    assert!(matches!(away, Error::Tool { fault: ToolFault::NoFaces, .. }) && away.exit_code() == 2, "{away}");
    let floor = judged("end-mill-3", &[("from", &["+z"]), ("faces", &["box:5,5,-1:15,15,1"])], UP).unwrap();
    assert_eq!(floor.state, State::Warn, "{floor:?}");
    let found = &floor.findings[0];
    // The middle of the bottom, 10 × 10 mm, in patches of at most two spacings.
    assert!((found.value - 100.0).abs() < 0.1 * 100.0, "{found:?}");
}
