//! What is too thin to be made: pins of few facets, wires, and wedges however their sides are divided.

use crate::shapes::{ears, lathe};
use crate::{findings, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::Finding;
use amcheck::geometry::{TriangleMesh, extruded};
use std::f64::consts::PI;

/// What a check finds in it.
fn findings_of(mesh: TriangleMesh, name: &str, code: &str) -> Vec<Finding> {
    let mut options = Options::new(process(name, &["lost-feature=9mm3,0.001mm3"]));
    options.only = vec![code.into()];
    findings(&judge_mesh(mesh, &options), code).to_vec()
}

#[test]
fn a_pin_is_lost_over_its_whole_length_however_few_facets_it_has() {
    // Of five sides no two face each other.
    for (radius, sides, high) in
        [(0.169f64, 4, 5.0), (0.169, 4, 12.0), (0.15, 12, 9.0), (0.17, 5, 6.0), (0.17, 3, 6.0), (0.08, 24, 8.0)]
    {
        let outline = [[0.0, 0.0], [6.0, 0.0], [6.0, 3.0], [radius, 3.0], [radius, 3.0 + high], [0.0, 3.0 + high]];
        let truth = PI * radius * radius * high;
        for name in ["fdm", "sls"] {
            let found = findings_of(lathe(&outline, sides), name, "AM106");
            let place =
                found.iter().find(|f| f.kind == "lost").unwrap_or_else(|| panic!("{name} {sides} {radius}: {found:?}"));
            assert!(place.low <= truth && truth <= place.high, "{name} {sides}: {truth} not in {place:?}");
            assert!(place.high - place.low < 0.05 * truth && place.count == 1, "{place:?}");
        }
    }
}

#[test]
fn a_wire_is_a_pin_however_thin_it_is() {
    for (radius, high) in [(0.08, 8.0), (0.03, 5.0), (0.03, 20.0)] {
        let outline = [[0.0, 0.0], [6.0, 0.0], [6.0, 3.0], [radius, 3.0], [radius, 3.0 + high], [0.0, 3.0 + high]];
        let found = findings_of(lathe(&outline, 24), "fdm", "AM102");
        let pin = found.iter().find(|f| f.kind == "pin").expect("a pin");
        assert!((pin.value - 2.0 * radius).abs() < 1e-3 && pin.message.contains("free at one end"), "{pin:?}");
    }
    // A cone runs out to a point: it is one pin, as wide as its root and as long as it is.
    let cone = lathe(&[[0.0, 0.0], [6.0, 0.0], [6.0, 3.0], [0.5, 3.0], [0.0, 9.0]], 24);
    let found = findings_of(cone, "fdm", "AM102");
    assert!(found.len() == 1 && found[0].count == 1 && (found[0].value - 1.0).abs() < 1e-3, "{found:?}");
    assert!(found[0].message.contains("6 mm long, running out to a point"), "{found:?}");
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
            assert_eq!(findings_of(overhanging(strips), name, "AM106"), [], "{strips} {name}");
        }
    }
}
