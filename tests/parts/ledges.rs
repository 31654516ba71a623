//! What reaches out: how far, from what holds it.

use crate::shapes::{about_z, ears};
use crate::{findings, judge_bytes, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::Finding;
use amcheck::geometry::{TriangleMesh, extruded};
use amcheck::part::Up;
use amcheck::process::Process;

fn ledges(mesh: TriangleMesh) -> Vec<Finding> {
    let mut options = Options::new(process("fdm", &[]));
    options.only = vec!["AM203".into()];
    findings(&judge_mesh(mesh, &options), "AM203").to_vec()
}

/// A base 20 mm long with a wall at its end, from which an arm reaches over the base with a gap, and out beyond it.
fn arm(gap: f64, out: f64) -> TriangleMesh {
    let (low, high, far) = (3.0, 3.0 + gap, 20.0 + out);
    let outline = [[0.0, 0.0], [20.0, 0.0], [20.0, low], [2.0, low], [2.0, high], [far, high], [far, 6.0], [0.0, 6.0]];
    extruded(&outline, &ears(&outline), 20.0)
}

#[test]
fn an_arm_over_a_gap_less_than_a_layer_high_reaches_out_beyond_what_it_rests_on() {
    for (gap, out) in [(0.05, 6.0), (0.1, 1.5), (0.1, 15.0), (0.19, 6.0)] {
        for turn in [0.0, 31.0] {
            let found = ledges(arm(gap, out).transformed(about_z(turn), [3.0, 5.0, 0.0]));
            let is_told = |f: &Finding| f.kind == "ledge" && f.low <= out + 1e-4 && out <= f.high + 1e-4;
            assert!(found.len() == 1 && is_told(&found[0]), "{gap}, {out}: {found:?}");
        }
    }
    // A layer and more below is nothing to rest on.
    let found = ledges(arm(0.25, 6.0));
    assert!(found.len() == 1 && found[0].low <= 24.0 && 24.0 <= found[0].high + 1e-4, "{found:?}");
}

#[test]
fn a_turn_in_which_nothing_is_said_to_hang_over_has_nothing_hanging_over_in_powder_too() {
    let mut told = 0;
    for (name, limits) in ["sls", "fdm"].into_iter().zip([&["overhang=20deg,45deg"][..], &[]]) {
        for part in ["finned_bracket", "gallows", "basin", "hollow_sealed", "slits_015"] {
            let bytes = std::fs::read(format!("fixtures/parts/{part}.stl")).expect("a committed part");
            let mut options = Options::new(process(name, limits));
            options.only = vec!["AM201".into()];
            let hanging = |options: &Options| {
                let report = judge_bytes(part, &bytes, options).expect("a report");
                findings(&report, "AM201").to_vec()
            };
            let found = hanging(&options);
            let turn = |f: &Finding| {
                let said = f.fix.split_once("turn it with --up ")?.1.split_once(": measured so, nothing hangs over")?;
                let axes =
                    [("+x", Up::PlusX), ("-x", Up::MinusX), ("+y", Up::PlusY), ("-y", Up::MinusY), ("-z", Up::MinusZ)];
                axes.into_iter().find(|(word, _)| *word == said.0).map(|(_, up)| up)
            };
            options.up = found.iter().find_map(turn);
            if options.up.is_some() {
                told += 1;
                assert_eq!(hanging(&options), [], "{part} in {name}: {found:?}");
            }
        }
    }
    assert!(told >= 3, "{told}");
}

#[test]
fn what_powder_holds_inherits_no_limits_of_what_hangs_in_air() {
    let of = |own: &str| {
        let text = format!("inherits = \"fdm\"\n[machine]\npowder_supports = true\n{own}");
        let process = Process::from_toml("mine.toml", &text).expect("a profile");
        ["overhang", "bridge", "bridge.ledge", "thin-wall"].map(|key| process.limit(key).is_some())
    };
    assert_eq!(of(""), [false, false, false, true]);
    assert_eq!(of("[limits.overhang]\nwarn = \"30deg\"\n"), [true, false, false, true]);
}
