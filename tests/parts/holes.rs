//! What is round: holes and pins by their narrowest section, what runs out to a point by its mouth or its root, and none of it a slot or a wall; and what holds it.

use crate::shapes::facing;
use crate::{findings, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::{Finding, State};
use amcheck::geometry::{TriangleMesh, cuboid, revolved};
use amcheck::units::Length;

/// A round plate with a pit in its top, so wide at its mouth and at its floor, and its facets quartered so often.
fn pit(mouth: f64, floor: f64, depth: f64, sides: usize, quartered: usize) -> TriangleMesh {
    let top = depth + 2.0;
    let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, top], [0.5 * mouth, top], [0.5 * floor, 2.0], [0.0, 2.0]];
    divided(revolved(&outline, sides), quartered)
}

/// A round plate with a spike on it.
fn spike(root: f64, height: f64, sides: usize, quartered: usize) -> TriangleMesh {
    let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.5 * root, 2.0], [0.0, 2.0 + height]];
    divided(revolved(&outline, sides), quartered)
}

fn divided(mesh: TriangleMesh, quartered: usize) -> TriangleMesh {
    (0..quartered).fold(mesh, |mesh, _| {
        let quarters = (0..mesh.triangles.len()).flat_map(|t| {
            let [a, b, c] = mesh.corners(t);
            let middle = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|x| 0.5 * (p[x] + q[x]));
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        });
        TriangleMesh::weld(quarters.collect::<Vec<_>>())
    })
}

/// What a check finds in it, turned, with a limit of 1.3 mm for walls, pins, gaps and holes.
fn told(mesh: TriangleMesh, code: &str) -> Vec<Finding> {
    let mut options =
        Options::new(process("mjf", &["narrow-gap=1.3mm", "small-hole=1.3mm", "thin-wall=1.3mm", "thin-pin=1.3mm"]));
    options.only = vec![code.into()];
    options.voxel = Some(Length::mm(0.4));
    findings(&judge_mesh(mesh.transformed(facing([1.0, 2.0, 3.0]), [0.1, 0.2, 0.3]), &options), code).to_vec()
}

#[test]
fn a_pit_that_runs_out_to_a_point_is_a_hole_by_its_mouth_and_no_slot() {
    for (mouth, sides, quartered) in
        [(1.0, 48, 1), (0.95, 16, 2), (0.45, 24, 2), (0.8, 32, 1), (1.16, 48, 0), (0.3, 12, 0)]
    {
        let turn = std::f64::consts::TAU / sides as f64;
        let diameter = mouth * (turn.sin() / turn).sqrt();
        // The sides lean by so much: up to 15 degrees they are a rod's.
        for (degrees, is_hole) in [(3.0f64, true), (9.0, true), (14.0, true), (19.0, false), (40.0, false)] {
            let mesh = || pit(mouth, 0.0, 0.5 * mouth / degrees.to_radians().tan(), sides, quartered);
            let holes = told(mesh(), "AM104");
            let is_told =
                |f: &Finding| (f.value - diameter).abs() < 2e-3 * mouth && f.low <= diameter && diameter <= f.high;
            assert_eq!(holes.iter().map(is_told).collect::<Vec<_>>(), vec![true; usize::from(is_hole)], "{holes:?}");
            assert!(holes.iter().all(|f| f.state == State::Fail && f.message.contains("running out to a point")));
            assert_eq!(told(mesh(), "AM103"), [], "{mouth}, {degrees}");
        }
    }
}

#[test]
fn a_spike_is_a_pin_by_its_root_and_no_wall() {
    for (root, sides, quartered) in [(0.8, 48, 1), (0.8, 48, 2), (0.74, 12, 1), (1.36, 12, 2), (1.36, 24, 0)] {
        let turn = std::f64::consts::TAU / sides as f64;
        let diameter = root * (turn.sin() / turn).sqrt();
        for (degrees, is_pin) in [(3.0f64, true), (7.0, true), (12.0, true), (19.0, false)] {
            let mesh = || spike(root, 0.5 * root / degrees.to_radians().tan(), sides, quartered);
            let pins = told(mesh(), "AM102").into_iter().filter(|f| f.kind == "pin").collect::<Vec<_>>();
            let is_told = |f: &Finding| (f.value - diameter).abs() < 2e-3 * root && f.state == State::Fail;
            let wanted = vec![true; usize::from(is_pin && diameter < 1.3)];
            assert_eq!(pins.iter().map(is_told).collect::<Vec<_>>(), wanted, "{root}, {degrees}: {pins:?}");
            assert_eq!(told(mesh(), "AM101"), [], "{root}, {degrees}");
        }
    }
}

#[test]
fn a_dimple_is_neither_a_hole_nor_a_slot() {
    for (mouth, sides, quartered) in [(1.15, 16, 0), (1.0, 24, 1), (0.9, 48, 2), (0.5, 6, 0)] {
        let mesh = || pit(mouth, mouth, 0.75 * mouth, sides, quartered);
        for code in ["AM103", "AM104"] {
            assert_eq!(told(mesh(), code), [], "{mouth}, {sides}");
        }
    }
}

/// A round bar from one place to another.
fn bar(from: [f64; 3], to: [f64; 3], diameter: f64) -> TriangleMesh {
    let way = [0, 1, 2].map(|x| to[x] - from[x]);
    let (r, long) = (0.5 * diameter, way.iter().map(|w| w * w).sum::<f64>().sqrt());
    let upright = revolved(&[[0.0, 0.0], [r, 0.0], [r, long], [0.0, long]], 24);
    upright.transformed(facing(way), from)
}

#[test]
fn a_handle_is_held_at_both_ends_and_a_hook_is_not() {
    let pins = |bars: &[TriangleMesh]| {
        let base = cuboid([0.0; 3], [30.0, 10.0, 3.0]);
        let mesh = bars.iter().fold(base, |all, b| all.joined(b));
        let mut options = Options::new(process("fdm", &[]));
        options.only = vec!["AM102".into()];
        findings(&judge_mesh(mesh, &options), "AM102").to_vec()
    };
    for d in [1.2, 2.0, 2.6] {
        let [near, far] = [4.0, 26.0].map(|x| bar([x, 5.0, 2.0], [x, 5.0, 15.0], d));
        // The corners of a handle overlap by a quarter, half or all of the bars.
        for over in [0.0, 0.25 * d, 0.5 * d] {
            let across = bar([4.0 - over, 5.0, 15.0], [26.0 + over, 5.0, 15.0], d);
            assert_eq!(pins(&[near.clone(), far.clone(), across]), [], "{d}, {over}");
            let free = bar([4.0 - over, 5.0, 15.0], [20.0, 5.0, 15.0], d);
            let hook = pins(&[near.clone(), free]);
            assert!(hook.iter().any(|f| f.kind == "pin" && (f.value - d).abs() < 0.02 * d), "{d}, {over}: {hook:?}");
        }
    }
}
