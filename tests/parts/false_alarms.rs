//! What people complain of: nothing is raised where nothing is wrong, and nothing passes that is no part.

use crate::shapes::{about_z, angle_bracket, ears, lathe};
use crate::{findings, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::{Finding, State};
use amcheck::geometry::{TriangleMesh, cuboid, extruded};
use amcheck::process::BUILTIN;
use amcheck::report::Report;

fn judged(name: &str, mesh: &TriangleMesh) -> Report {
    judge_mesh(mesh.clone(), &Options::new(process(name, &[])))
}

/// A block of 20 mm whose edges along y have chamfers of 3 mm at 45°.
fn chamfered() -> TriangleMesh {
    let (a, b) = (3.0, 17.0);
    let outline = [[a, 0.0], [b, 0.0], [20.0, a], [20.0, b], [b, 20.0], [a, 20.0], [0.0, b], [0.0, a]];
    extruded(&outline, &ears(&outline), 20.0)
}

/// A rod of 10 mm with a thread: grooves of a pitch of 2 mm, flanks at so many degrees from the horizontal.
fn threaded(degrees: f64) -> TriangleMesh {
    let (depth, flat) = (0.8, 0.3);
    let rise = depth * degrees.to_radians().tan();
    let mut outline = vec![[0.0, 0.0], [6.0, 0.0]];
    let mut z = 1.0;
    for _ in 0..6 {
        outline.extend([
            [6.0, z],
            [6.0 - depth, z + rise],
            [6.0 - depth, z + rise + flat],
            [6.0, z + 2.0 * rise + flat],
        ]);
        z += 2.0 * rise + 2.0 * flat;
    }
    outline.extend([[6.0, z + 1.0], [0.0, z + 1.0]]);
    lathe(&outline, 64)
}

/// A round basin of 30 mm, 20 mm high, its walls and its floor 5 mm thick, its inner edge a bevel of 45°.
fn basin() -> TriangleMesh {
    lathe(&[[0.0, 0.0], [15.0, 0.0], [15.0, 20.0], [10.0, 20.0], [10.0, 8.0], [7.0, 5.0], [0.0, 5.0]], 64)
}

/// A plate of 40 × 12 × 4 mm with strokes of a width and height, as far apart as they are wide.
fn lettered(wide: f64, high: f64) -> TriangleMesh {
    let mut outline = vec![[0.0, 0.0], [40.0, 0.0], [40.0, 4.0]];
    for i in (0..4).rev() {
        let x = 10.0 + 2.0 * wide * f64::from(i);
        outline.extend([[x + wide, 4.0], [x + wide, 4.0 + high], [x, 4.0 + high], [x, 4.0]]);
    }
    outline.push([0.0, 4.0]);
    extruded(&outline, &ears(&outline), 12.0)
}

#[test]
fn sound_parts_raise_nothing_in_any_process() {
    let parts: [(&str, TriangleMesh); 8] = [
        ("a solid cube", cuboid([0.0; 3], [20.0; 3])),
        ("a cube turned about z", cuboid([0.0; 3], [20.0; 3]).transformed(about_z(33.0), [0.0; 3])),
        ("chamfers", chamfered()),
        ("a fillet", angle_bracket(1.5)),
        ("a thread with flanks of 45°", threaded(45.0)),
        ("a thread with flanks of 60°", threaded(60.0)),
        ("text", lettered(2.4, 1.0)),
        ("an open basin", basin()),
    ];
    let mut raised: Vec<String> = Vec::new();
    for (process, _) in BUILTIN {
        for (name, mesh) in &parts {
            // A basin does hold resin while it hangs from the plate: that is no false alarm.
            let told = |f: &&Finding| !(*name == "an open basin" && f.code == "AM302");
            let report = judged(process, mesh);
            let all = report.findings().into_iter().filter(told);
            raised.extend(all.map(|f| format!("{process}, {name}: {} {} {}", f.code, f.kind, f.message)));
        }
    }
    assert!(raised.is_empty(), "{}", raised.join("\n"));
}

/// Flanks of 30° hang over; they are thin walls, gaps, lost or blended by no process.
#[test]
fn a_steep_thread_hangs_over_and_is_nothing_else() {
    for (process, _) in BUILTIN {
        let report = judged(process, &threaded(30.0));
        let other: Vec<String> = report
            .findings()
            .into_iter()
            .filter(|f| !f.code.starts_with("AM20") && f.code != "AM501")
            .map(|f| format!("{} {} {}", f.code, f.kind, f.message))
            .collect();
        assert!(other.is_empty(), "{process}: {other:?}");
    }
}

#[test]
fn nothing_that_is_no_part_passes() {
    let cube = cuboid([0.0; 3], [20.0; 3]);
    let sheet = {
        let mut both = cube.clone();
        both.triangles.extend(cube.flipped().triangles);
        both
    };
    for (name, _) in BUILTIN {
        let options = Options::new(process(name, &[]));
        let refused = |mesh: TriangleMesh| {
            let loaded = amcheck::io::Loaded {
                mesh,
                format: "mesh",
                unit_mm: Some(1.0),
                notices: Vec::new(),
                relative_step: f64::EPSILON,
            };
            amcheck::analyze::prepare("mesh", b"", loaded, &options).err().map(|e| e.exit_code())
        };
        assert_eq!(refused(TriangleMesh { vertices: Vec::new(), triangles: Vec::new() }), Some(4), "{name}: empty");
        assert_eq!(refused(sheet.clone()), Some(4), "{name}: all shell");
        assert_eq!(
            refused(TriangleMesh { vertices: cube.vertices.clone(), triangles: cube.triangles[..4].to_vec() }),
            Some(4)
        );
        // Inside out: judged as the solid it bounds, and told.
        let report = judged(name, &cube.flipped());
        assert!(report.warnings.iter().any(|n| n.code == "inverted"), "{name}: {:?}", report.warnings);
        assert!(findings(&report, "AM001").iter().all(|f| f.state > State::Pass));
        let thin = judged(name, &cuboid([0.0; 3], [20.0, 0.05, 20.0]).flipped());
        assert!(
            findings(&thin, "AM101").iter().any(|f| f.state == State::Fail),
            "{name}: a sheet of 0.05 mm passes inside out"
        );
    }
}

#[test]
fn a_ceiling_that_rests_on_another_body_in_part_spans_only_what_is_left() {
    // An arm of 10 × 8 mm at z = 20, held on its left; under it a block one layer lower, from 6 mm on.
    let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 20.0], [14.0, 20.0], [14.0, 24.0], [0.0, 24.0]];
    let arm = extruded(&outline, &ears(&outline), 8.0);
    let mut options = Options::new(process("fdm", &["bridge.ledge=0.5mm"]));
    options.only = vec!["bridge".into()];
    let spans = |mesh: TriangleMesh| -> Vec<(String, f64, f64)> {
        let report = judge_mesh(mesh, &options);
        findings(&report, "AM203").iter().map(|f| (f.kind.clone(), f.low, f.high)).collect()
    };
    let holds = |found: &[(String, f64, f64)], kind: &str, truth: f64| {
        found.len() == 1
            && found
                .iter()
                .all(|(k, low, high)| k == kind && *low <= truth && truth <= *high && high - low < 0.05 * truth)
    };
    let alone = spans(arm.clone());
    assert!(holds(&alone, "ledge", 10.0), "{alone:?}");
    // Beneath the far end, with what reaches beyond it: what is left is held on both sides, and a bridge of 6 mm is none too long.
    let held = spans(arm.clone().joined(&cuboid([10.0, -3.0, 0.0], [17.0, 11.0, 19.8])));
    assert!(held.is_empty(), "{held:?}");
    // Beside the column: 4 mm are left.
    let near = spans(arm.clone().joined(&cuboid([4.5, -3.0, 0.0], [10.0, 11.0, 19.8])));
    assert!(holds(&near, "ledge", 4.0), "{near:?}");
    // Two layers lower it holds nothing.
    let low = spans(arm.joined(&cuboid([10.0, -3.0, 0.0], [17.0, 11.0, 19.6])));
    assert!(holds(&low, "ledge", 10.0), "{low:?}");
}
