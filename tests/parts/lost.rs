//! What AM106 says of pins of few facets and of wedges however their sides are divided.

use crate::shapes::{ears, lathe};
use crate::{findings, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::Finding;
use amcheck::geometry::{TriangleMesh, extruded};
use std::f64::consts::PI;

/// What lost-feature finds in it.
fn lost(mesh: TriangleMesh, name: &str) -> Vec<Finding> {
    let mut options = Options::new(process(name, &[]));
    options.only = vec!["lost-feature".into()];
    findings(&judge_mesh(mesh, &options), "AM106").to_vec()
}

#[test]
fn a_pin_is_lost_over_its_whole_length_however_few_facets_it_has() {
    for (radius, sides, high) in [(0.169f64, 4, 5.0), (0.169, 4, 12.0), (0.15, 12, 9.0)] {
        let outline = [[0.0, 0.0], [6.0, 0.0], [6.0, 3.0], [radius, 3.0], [radius, 3.0 + high], [0.0, 3.0 + high]];
        let truth = PI * radius * radius * high;
        for name in ["fdm", "sls"] {
            let found = lost(lathe(&outline, sides), name);
            let place = found.iter().find(|f| f.kind == "lost").expect("a pin narrower than the element");
            assert!(place.low <= truth && truth <= place.high, "{name} {sides}: {truth} not in {place:?}");
            assert!(place.high - place.low < 0.05 * truth, "{place:?}");
        }
    }
}

/// A block of 16 × 4 × 10 mm that runs out over its upper edge to a wedge of 14°, each of its sides so many strips.
fn overhanging(strips: usize) -> TriangleMesh {
    let along = |from: [f64; 2], to: [f64; 2]| {
        let at = move |k: usize, a: usize| from[a] + (to[a] - from[a]) * k as f64 / strips as f64;
        (0..strips).map(move |k| [at(k, 0), at(k, 1)])
    };
    let under = along([4.0, 2.0], [12.0, 4.0]);
    let over = along([12.0, 4.0], [4.0, 4.0]);
    let outline: Vec<[f64; 2]> =
        [[0.0, 0.0], [4.0, 0.0]].into_iter().chain(under).chain(over).chain([[4.0, 4.0], [0.0, 4.0]]).collect();
    extruded(&outline, &ears(&outline), 10.0)
}

#[test]
fn a_wedge_that_runs_out_to_its_edge_is_no_lost_feature_and_no_detail() {
    for strips in [1, 2, 5, 16] {
        for name in ["fdm", "sls", "sla", "lpbf"] {
            assert_eq!(lost(overhanging(strips), name), [], "{strips} {name}");
        }
    }
}
