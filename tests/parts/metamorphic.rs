//! What must not change the answer: turning, moving, the phase of the grid, what stands beside a wall.

use crate::shapes::{about_z, ball, facing};
use crate::{findings, judge_bytes, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::State;
use amcheck::geometry::{TriangleMesh, cuboid};
use amcheck::io::stl;

const UPRIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A 0.24 mm plate, 10 × 8 mm, upright along x.
fn wall() -> TriangleMesh {
    cuboid([0.0, 0.0, 0.0], [10.0, 0.24, 8.0])
}

fn thinnest(mesh: TriangleMesh, options: &Options) -> (State, f64) {
    let report = judge_mesh(mesh, options);
    let f = findings(&report, "AM101").first().expect("the wall is found").clone();
    (f.state, f.value)
}

#[test]
fn a_wall_measures_the_same_however_it_is_turned_and_moved() {
    let options = Options::new(process("fdm", &["thin-wall=0.4mm"]));
    for degrees in [0.0, 10.0, 17.0, 30.0, 45.0, 90.0] {
        for shift in [[0.0; 3], [0.137, 0.291, 0.073], [1000.0, -500.0, 20.0]] {
            let (state, value) = thinnest(wall().transformed(about_z(degrees), shift), &options);
            // Coordinates near 1000 mm carry 1e-13; the value follows from differences of them.
            assert!(state == State::Fail && (value - 0.24).abs() < 1e-9, "{degrees}° {shift:?}: {value}");
        }
    }
    for axis in [[1.0, 1.0, 1.0], [0.3, -0.8, 0.5], [0.0, 0.1, 1.0]] {
        let (state, value) = thinnest(wall().transformed(facing(axis), [0.0; 3]), &options);
        assert!(state == State::Fail && (value - 0.24).abs() < 1e-9, "{axis:?}: {value}");
    }
}

#[test]
fn a_wall_as_thick_as_the_limit_meets_it_however_it_was_turned_before_it_was_written() {
    let mut options = Options::new(process("fdm", &["thin-wall=0.8mm,0.8mm"]));
    options.only = vec!["thin-wall".into()];
    let mut missed = 0.0f64;
    for n in 0..24 {
        // STL holds f32: near 200 mm a coordinate is up to 8e-6 mm off, and both faces of the wall are.
        let turned = cuboid([0.0; 3], [10.0, 0.8, 8.0]).transformed(about_z(7.3 * f64::from(n)), [190.0, -80.0, 40.0]);
        let mut bytes = Vec::new();
        stl::write(&turned, &mut bytes).expect("memory");
        let report = judge_bytes("wall.stl", &bytes, &options).expect("a report");
        let check = report.checks.iter().find(|c| c.code == "AM101").expect("in the registry");
        assert!(check.findings.is_empty(), "{n}: {:?}", check.findings);
        missed = missed.max(0.8 - check.worst.as_ref().expect("a wall").value);
    }
    // Without a tie some would fail.
    assert!(missed > 1e-6, "{missed}");
}

#[test]
fn a_small_fin_on_a_ball_of_72_000_facets_is_found() {
    let fin = cuboid([-1.0, -0.12, 0.0], [1.0, 0.12, 2.0]).transformed(facing([1.0, 1.0, 1.0]), [5.4, 5.4, 5.4]);
    let part = ball([0.0; 3], 10.0, 134).joined(&fin);
    assert!(part.triangles.len() > 70_000);
    let (state, value) = thinnest(part, &Options::new(process("fdm", &["thin-wall=0.4mm"])));
    assert!(state == State::Fail && (value - 0.24).abs() < 1e-9, "{value}");
}

#[test]
fn the_phase_of_the_grid_changes_no_verdict() {
    let part = || wall().joined(&cuboid([0.0, 1.0, 0.0], [10.0, 4.0, 8.0]));
    let mut options = Options::new(process("fdm", &[]));
    let at_rest = judge_mesh(part(), &options);
    options.phase = [0.37, 0.21, 0.11];
    let moved = judge_mesh(part(), &options);
    assert_eq!(at_rest.checks, moved.checks);
    assert!((at_rest.part.volume_mm3.value - moved.part.volume_mm3.value).abs() < 1e-6);
}

#[test]
fn a_convex_block_raises_no_alarm_in_any_process_and_any_turn() {
    for name in amcheck::process::BUILTIN.iter().map(|p| p.0) {
        for rotation in [UPRIGHT, facing([1.0, 1.0, 1.0]), about_z(30.0)] {
            let report = judge_mesh(
                cuboid([0.0; 3], [20.0; 3]).transformed(rotation, [0.0; 3]),
                &Options::new(process(name, &[])),
            );
            let raised: Vec<_> =
                report.findings().into_iter().filter(|f| f.code == "AM101" || f.code == "AM103").collect();
            assert!(raised.is_empty(), "{name}: {raised:?}");
        }
    }
}

#[test]
fn a_solid_block_on_the_plate_needs_nothing_in_any_process() {
    for name in amcheck::process::BUILTIN.iter().map(|p| p.0) {
        for degrees in [0.0, 30.0, 45.0] {
            let part = cuboid([0.0; 3], [20.0; 3]).transformed(about_z(degrees), [0.0; 3]);
            let report = judge_mesh(part, &Options::new(process(name, &[])));
            let raised: Vec<_> = report.findings().into_iter().filter(|f| f.code.starts_with("AM20")).collect();
            assert!(raised.is_empty(), "{name}: {raised:?}");
        }
    }
}

#[test]
fn the_best_orientation_is_taken_and_any_direction_can_be() {
    let mut options = Options::new(process("fdm", &[]));
    let t = || cuboid([8.0, 8.0, 0.0], [12.0, 12.0, 20.0]).joined(&cuboid([0.0, 0.0, 20.0], [20.0, 20.0, 23.0]));
    let support =
        |o: &Options| judge_mesh(t(), o).checks.iter().find(|c| c.code == "AM204").and_then(|c| c.worst.clone());
    // The plate hangs over by 384 mm² at 20 mm, beside a stem that it touches.
    let upright = support(&options).expect("a value").value;
    assert!(upright > 3.0, "{upright}");
    options.up = None;
    assert_eq!(support(&options).expect("a value").value, 0.0);
    options.up = Some(amcheck::part::Up::Along([0.0, 0.0, -2.0]));
    assert_eq!(support(&options).expect("a value").value, 0.0);
}

#[test]
fn two_runs_and_any_number_of_threads_give_the_same_bytes() {
    let part = || ball([0.0; 3], 5.0, 20).joined(&wall());
    let options = Options::new(process("fdm", &[]));
    let report = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| amcheck::report::json::write(&judge_mesh(part(), &options)))
    };
    let one = report(1);
    assert!(one == report(1) && one == report(3));
}
