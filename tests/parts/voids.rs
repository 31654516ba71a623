//! Voids: what is sealed, what is narrow, what is neither.

use crate::shapes::{facing, flask};
use crate::{findings, judge_bytes, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::State;
use amcheck::geometry::union::united;
use amcheck::geometry::{TriangleMesh, cuboid};
use amcheck::process::BUILTIN;
use amcheck::units::Length;

fn only(name: &str, checks: &[&str]) -> Options {
    Options { only: checks.iter().map(|c| c.to_string()).collect(), ..Options::new(process(name, &[])) }
}

#[test]
fn a_block_and_an_open_basin_trap_nothing_in_any_process() {
    for (name, _) in BUILTIN {
        for rotation in [facing([0.0, 0.0, 1.0]), facing([1.0, 1.0, 1.0])] {
            for mesh in [cuboid([0.0; 3], [20.0; 3]), flask(20.0, 16.0, 15.0)] {
                let mut options = only(name, &["AM301"]);
                options.voxel = Some(Length::mm(0.25));
                let report = judge_mesh(mesh.transformed(rotation, [0.0; 3]), &options);
                assert!(findings(&report, "AM301").is_empty(), "{name}: {:?}", findings(&report, "AM301"));
            }
        }
    }
}

#[test]
fn a_neck_is_as_wide_as_it_is_in_every_process_that_has_to_be_emptied() {
    for name in ["sla", "sls", "mjf", "lpbf", "binder-jet"] {
        let mut options = only(name, &["AM301"]);
        options.voxel = Some(Length::mm(0.2));
        options.phase = [0.31, -0.22, 0.47];
        let report = judge_mesh(flask(20.0, 16.0, 1.0), &options);
        let f = &findings(&report, "AM301")[0];
        assert!(f.state == State::Fail && f.low <= 1.0 && 1.0 <= f.high, "{name}: {f:?}");
        assert!(f.volume_mm3.is_some_and(|v| (v - 4096.0).abs() < 0.03 * 4096.0), "{name}: {f:?}");
        assert!(f.fix.contains("vent"), "{}", f.fix);
    }
}

/// Flasks side by side, their necks so wide, turned.
fn flasks(necks: &[f64], rotation: [[f64; 3]; 3]) -> TriangleMesh {
    let all = necks
        .iter()
        .enumerate()
        .map(|(n, &neck)| flask(20.0, 14.0, neck).transformed(facing([0.0, 0.0, 1.0]), [30.0 * n as f64, 0.0, 0.0]));
    all.reduce(|a, b| a.joined(&b)).expect("a flask").transformed(rotation, [0.0; 3])
}

#[test]
fn equal_chambers_are_one_finding_with_the_ways_out_that_were_tried_at_each() {
    for (neck, kind, words) in [(1.0, "narrow-way-out", "3 of 3 such vents"), (4.0, "mouths", "3 of 3 then have 2")] {
        for rotation in [facing([0.0, 0.0, 1.0]), facing([0.0, 0.0, -1.0])] {
            let mut options = only("sla", &["AM301"]);
            options.voxel = Some(Length::mm(0.25));
            let report = judge_mesh(flasks(&[neck; 3], rotation), &options);
            let found: Vec<_> = findings(&report, "AM301").iter().filter(|f| f.kind == kind).collect();
            assert_eq!((found.len(), found[0].count, found[0].places.len()), (1, 3, 3), "{found:?}");
            assert!(found[0].fix.contains(words), "{}", found[0].fix);
            assert!(found[0].volume_mm3.is_some_and(|v| (v - 3.0 * 2744.0).abs() < 0.05 * 3.0 * 2744.0), "{found:?}");
        }
    }
}

#[test]
fn a_bore_through_a_chamber_has_two_mouths_also_where_one_is_on_the_plate() {
    for name in ["sla", "lpbf", "sls"] {
        let mut options = only(name, &["AM301"]);
        options.voxel = Some(Length::mm(0.25));
        let one = findings(&judge_mesh(flask(20.0, 14.0, 4.0), &options), "AM301").to_vec();
        assert!(one.iter().any(|f| f.kind == "mouths" && f.value == 1.0), "{name}: {one:?}");
        let both = findings(&judge_mesh(bored(20.0, 14.0, 4.0), &options), "AM301").to_vec();
        assert_eq!(both, [], "{name}");
    }
}

#[test]
fn what_the_plate_closes_is_told_whatever_the_way_out_is_without_it() {
    // Under a limit of 3 mm for ways out: narrower, within what the samples tell, and wider.
    for neck in [2.5, 3.2, 4.4] {
        let mut options = only("lpbf", &["AM301"]);
        options.voxel = Some(Length::mm(0.25));
        let over = flask(20.0, 14.0, neck).transformed(facing([0.0, 0.0, -1.0]), [0.0; 3]);
        let found = findings(&judge_mesh(over, &options), "AM301").to_vec();
        let closed: Vec<_> = found.iter().filter(|f| f.kind == "on-plate").collect();
        let truth = 14f64.powi(3) + 3.0 * neck * neck;
        let [one] = closed[..] else { panic!("{neck}: {found:?}") };
        assert!(one.low <= truth && truth <= one.high && one.high - one.low < 0.01 * truth, "{neck} {truth}: {one:?}");
        assert_eq!(found.iter().any(|f| f.kind == "narrow-way-out"), neck < 3.0, "{neck}: {found:?}");
    }
}

#[test]
fn a_cup_over_the_plate_with_a_hole_in_its_side_is_closed_only_if_the_hole_is_too_narrow_for_any_part() {
    // Walls of 3 mm around a room of 14 × 14 × 9 mm, one with a square hole in its middle; lpbf wants 3 mm, and fails below 2.
    for (hole, told) in [(2.4, 0), (1.6, 1)] {
        let (a, b) = (10.0 - 0.5 * hole, 10.0 + 0.5 * hole);
        let (low, high) = (6.0 - 0.5 * hole, 6.0 + 0.5 * hole);
        let boxes = [
            [[0.0, 0.0, 9.0], [20.0, 20.0, 12.0]],
            [[0.0, 0.0, 0.0], [20.0, 3.0, 12.0]],
            [[0.0, 17.0, 0.0], [20.0, 20.0, 12.0]],
            [[17.0, 0.0, 0.0], [20.0, 20.0, 12.0]],
            [[0.0, 0.0, 0.0], [3.0, a, 12.0]],
            [[0.0, b, 0.0], [3.0, 20.0, 12.0]],
            [[0.0, 0.0, 0.0], [3.0, 20.0, low]],
            [[0.0, 0.0, high], [3.0, 20.0, 12.0]],
        ];
        let all = boxes.map(|[lo, hi]| cuboid(lo, hi)).into_iter().reduce(|m, b| m.joined(&b)).expect("boxes");
        let mut options = only("lpbf", &["AM301"]);
        options.voxel = Some(Length::mm(0.2));
        let found = findings(&judge_mesh(united(&all, 1e-6).expect("a cup"), &options), "AM301").to_vec();
        assert_eq!(found.iter().filter(|f| f.kind == "on-plate").count(), told, "{hole}: {found:?}");
    }
}

/// A cube with a cubic room in its middle and a square bore through its top and its bottom.
fn bored(edge: f64, room: f64, bore: f64) -> TriangleMesh {
    let (h, r, b) = (0.5 * edge, 0.5 * room, 0.5 * bore);
    let square = |a: f64, z: f64| [[-a, -a, z], [a, -a, z], [a, a, z], [-a, a, z]];
    let rings = [
        square(h, -h),
        square(h, h),
        square(b, h),
        square(b, r),
        square(r, r),
        square(r, -r),
        square(b, -r),
        square(b, -h),
    ];
    let mut facets = Vec::new();
    for (n, lower) in rings.iter().enumerate() {
        let upper = &rings[(n + 1) % rings.len()];
        for i in 0..4 {
            let j = (i + 1) % 4;
            facets.extend([[lower[i], lower[j], upper[j]], [lower[i], upper[j], upper[i]]]);
        }
    }
    TriangleMesh::weld(facets)
}

#[test]
fn the_trapped_volumes_of_the_corpus_are_found_exactly() {
    let Some(folder) = crate::models::corpus() else { return };
    let cases: [(&str, &[f64], f64); 6] = [
        ("clean/openscad_trapped_sphere.stl", &[112.644], 112.644),
        ("clean/nop_gridfinity_1_cavity.stl", &[46_591.908], 46_591.908),
        ("clean/nop_gridfinity_10_cavities.stl", &[74_302.0, 3_391.0], 515_306.0),
        ("clean/enable_compliant_finger.stl", &[595.6, 4.13], 3_310.3),
        ("clean/prusa_y_motor_holder_slits.stl", &[54.4, 12.0], 505.2),
        ("calibration/hollow_cube_1mm.stl", &[], 0.0),
    ];
    for (file, truths, sum) in cases {
        let bytes = std::fs::read(folder.join(file)).expect(file);
        let report = judge_bytes(file, &bytes, &only("fdm", &["AM301"])).expect("a report");
        let found = findings(&report, "AM301");
        if truths.is_empty() {
            assert!(found.is_empty(), "{file}: {found:?}");
            continue;
        }
        assert_eq!(found.len(), 1, "{file}");
        // The manifest prints three digits after the point, or none.
        let close = |value: f64, truth: f64| {
            (value - truth).abs() <= 1e-3 + 1e-5 * truth + if truth > 100.0 { 0.9 } else { 0.01 }
        };
        assert!(close(found[0].volume_mm3.unwrap_or(0.0), sum), "{file}: {:?}", found[0].volume_mm3);
        for truth in truths {
            assert!(found[0].places.iter().any(|p| close(p.value, *truth)), "{file} {truth}: {:?}", found[0].places);
        }
    }
}

#[test]
fn printing_changes_what_it_should_and_nothing_else() {
    let Some(folder) = crate::models::corpus() else { return };
    // Pieces nearer than 0.2 mm fuse (gaps of the manifest, strictly less); nothing at all happens to the others. A pin that fuses with its
    // hole all round closes it; the finger's joint, and links of a chain, fuse on both sides, which makes a tunnel.
    type Told<'a> = &'a [(&'a str, u64)];
    let cases: [(&str, u64, Told); 10] = [
        ("calibration/tolerance_pins.stl", 3, &[("hole-closed", 3)]),
        ("calibration/kickstarter_fdm_v4.stl", 1, &[("hole-closed", 1)]),
        ("clean/voron2_door_hinge_pip.stl", 0, &[]),
        ("clean/enable_pip_finger.stl", 1, &[("bridged", 1)]),
        ("clean/enable_pip_hand_16.stl", 0, &[]),
        ("clean/voron0_x_carriage_support.stl", 0, &[]),
        ("formats/chain_loop.3mf", 28, &[]),
        ("calibration/hole_test.stl", 0, &[]),
        ("clean/gyroid_puzzle.ply", 0, &[]),
        ("clean/prusa_y_motor_holder_slits.stl", 0, &[]),
    ];
    for (file, pairs, others) in cases {
        let bytes = std::fs::read(folder.join(file)).expect(file);
        let report = judge_bytes(file, &bytes, &only("fdm", &["AM402"])).expect("a report");
        let found = findings(&report, "AM402");
        let fused = found.iter().find(|f| f.kind == "fused");
        assert_eq!(fused.map_or(0, |f| f.value as u64), pairs, "{file}: {fused:?}");
        let told: Vec<(&str, u64)> =
            found.iter().filter(|f| f.kind != "fused").map(|f| (f.kind.as_str(), f.value as u64)).collect();
        assert_eq!(told, others, "{file}");
    }
}

#[test]
fn offsets_lose_the_thin_walls_and_merge_the_near_pins() {
    let Some(folder) = crate::models::corpus() else { return };
    let cases: [(&str, &str, &[f64]); 2] = [
        ("calibration/thinwall.stl", "lost", &[0.175, 0.25]),
        ("calibration/tolerance_pins.stl", "merged", &[0.05, 0.075, 0.1, 0.125, 0.15]),
    ];
    for (file, kind, truths) in cases {
        let bytes = std::fs::read(folder.join(file)).expect(file);
        let report = judge_bytes(file, &bytes, &only("fdm", &["AM602"])).expect("a report");
        let mut values: Vec<f64> =
            findings(&report, "AM602").iter().filter(|f| f.kind == kind).map(|f| f.value).collect();
        values.sort_by(f64::total_cmp);
        assert_eq!(values.len(), truths.len(), "{file}: {values:?}");
        // The manifest prints gaps to four digits.
        assert!(values.iter().zip(truths).all(|(v, t)| (v - t).abs() < 2e-4), "{file}: {values:?}");
    }
}
