//! What is too thin to be made: pins of few facets, wires, wedges however their sides are divided, and what thins between round sides.

use crate::shapes::{ears, lathe};
use crate::{findings, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::{Finding, State};
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

/// Height of what stands upright, millimetres.
const HIGH: f64 = 6.0;

/// A side 9 mm wide that bends away from y = 0, to which it is nearest in its middle, with a radius of 6 mm.
fn round_side(nearest: f64) -> Vec<[f64; 2]> {
    (-32..=32).map(|n| 4.5 * f64::from(n) / 32.0).map(|x| [x, nearest + 6.0 - (36.0 - x * x).sqrt()]).collect()
}

/// A flat side as wide.
fn flat_side(y: f64) -> Vec<[f64; 2]> {
    round_side(0.0).into_iter().map(|[x, _]| [x, y]).collect()
}

/// What stands upright between two sides.
fn upright([below, above]: [Vec<[f64; 2]>; 2]) -> TriangleMesh {
    let steps = below.len() - 1;
    let outline: Vec<[f64; 2]> = below.into_iter().chain(above.into_iter().rev()).collect();
    let last = outline.len() - 1;
    let strips = (0..steps).flat_map(|n| [[n, n + 1, last - n], [n + 1, last - n - 1, last - n]]);
    let turned = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]];
    extruded(&outline, &strips.collect::<Vec<_>>(), HIGH).transformed(turned, [0.013, 0.107, 0.0])
}

/// What lies between a round side of 6 mm radius and a plane, `nearest` apart at the nearest, as far as they are less than `apart` apart, but for
/// so much at both rims; mm³.
fn between_round_and_flat(nearest: f64, apart: f64, rim: f64) -> f64 {
    let x = (2.0 * 6.0 * (apart - nearest) - (apart - nearest).powi(2)).sqrt() - rim;
    // ∫ (nearest + 6 − √(36 − x²)) dx from −x to x.
    HIGH * (2.0 * x * (nearest + 6.0) - (x * (36.0 - x * x).sqrt() + 36.0 * (x / 6.0).asin()))
}

#[test]
fn a_skin_beside_a_round_hollow_is_lost_as_far_as_the_element_does_not_fit_however_thin_it_is_in_its_middle() {
    for thinnest in [0.02, 0.1, 0.2, 0.3] {
        let found = findings_of(upright([flat_side(0.0), round_side(thinnest)]), "sls", "AM106");
        let [f] = found.as_slice() else { panic!("{thinnest}: {found:?}") };
        let [most, least] = [0.0, 0.25].map(|rim| between_round_and_flat(thinnest, 0.4, rim));
        assert!(f.kind == "lost" && f.decided && f.low <= most && least <= f.high, "{thinnest}: {least} {most} {f:?}");
        assert!(f.value > 0.5 * least && f.value < 1.1 * most, "{thinnest}: {least} {most} {f:?}");
    }
}

#[test]
fn a_gap_beside_a_round_fills_as_far_as_the_element_does_not_fit_however_narrow_it_is_in_its_middle() {
    for gap in [0.03, 0.1, 0.2] {
        let mesh = upright([round_side(gap), flat_side(4.0)]).joined(&upright([flat_side(-2.0), flat_side(0.0)]));
        let mut options = Options::new(process("sls", &[]));
        options.only = vec!["as-printed".into()];
        let apart = options.process.element.closing_gap_mm;
        let found: Vec<Finding> =
            findings(&judge_mesh(mesh, &options), "AM401").iter().filter(|f| f.kind == "filled").cloned().collect();
        let [f] = found.as_slice() else { panic!("{gap}: {found:?}") };
        let [most, least] = [0.0, 0.25].map(|rim| between_round_and_flat(gap, apart, rim));
        assert!(f.state > State::Pass && f.low <= most && least <= f.high, "{gap}: {least} {most} {f:?}");
        assert!(f.value > 0.5 * least, "{gap}: {least} {most} {f:?}");
    }
}
