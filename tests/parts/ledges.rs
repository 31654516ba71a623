//! What reaches out: how far, from what holds it.

use crate::shapes::{about_z, ears};
use crate::{findings, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::Finding;
use amcheck::geometry::{TriangleMesh, extruded};

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
