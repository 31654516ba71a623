//! Slots and sheets as the process lays them down, beside their closed forms.

use crate::{findings, judge_bytes, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::{Finding, State};
use amcheck::geometry::{TriangleMesh, cuboid, extruded};
use amcheck::process::Process;

fn places(mesh: TriangleMesh) -> Vec<Finding> {
    places_in("fdm", mesh)
}

fn places_in(name: &str, mesh: TriangleMesh) -> Vec<Finding> {
    let options = Options { only: vec!["as-printed".into()], ..Options::new(process(name, &[])) };
    findings(&judge_mesh(mesh, &options), "AM401").to_vec()
}

/// Two blocks with faces of 6 x 5 mm, so far apart along x, turned about z.
fn slot(gap: f64, turn: f64) -> TriangleMesh {
    let blocks = cuboid([0.0; 3], [3.0, 6.0, 5.0]).joined(&cuboid([3.0 + gap, 0.0, 0.0], [6.0 + gap, 6.0, 5.0]));
    let (s, c) = turn.to_radians().sin_cos();
    blocks.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.013, 0.107, 0.031])
}

#[test]
fn an_upright_slot_closes_below_the_gap_of_the_process_whatever_way_it_is_turned() {
    for turn in [0.0, 17.0, 45.0, 71.0] {
        for gap in [0.06, 0.1, 0.15] {
            let found = places(slot(gap, turn));
            let [f] = found.as_slice() else { panic!("{gap} mm at {turn} degrees: {found:?}") };
            assert!(f.kind == "filled" && f.state == State::Warn && f.decided, "{gap} mm at {turn} degrees: {f:?}");
            // All of it but for half an element from the rim: a cube of cells of 0.2 mm either way, as far as it reaches along the slot, and
            // 0.15 to 0.167 mm along z, by how the element is divided.
            let (s, c) = f64::to_radians(turn).sin_cos();
            let long = 6.0 - 0.4 * (s.abs() + c.abs());
            let (most, least) = (gap * long * (5.0 - 0.3), gap * long * (5.0 - 1.0 / 3.0));
            let found = format!("{gap} mm at {turn} degrees: {least} {most} {f:?}");
            assert!(f.low <= most && least <= f.high, "{found}");
            // The estimate is what lies between the sides, rim and all, as far as the bracket lets it.
            assert!(f.value > 0.98 * least && f.value < 1.001 * gap * 6.0 * 5.0, "{found}");
        }
        for gap in [0.25, 0.3, 1.0] {
            assert!(places(slot(gap, turn)).is_empty(), "{gap} mm at {turn} degrees: {:?}", places(slot(gap, turn)));
        }
    }
}

#[test]
fn a_slot_as_wide_as_the_gap_that_closes_stays_open_wherever_the_lattice_begins() {
    // A block of 8 × 4 × 6 mm with a slot of 4 mm down its middle.
    let slotted = |gap: f64| {
        let (a, b) = (4.0 - 0.5 * gap, 4.0 + 0.5 * gap);
        let outline = [[0.0, 0.0], [8.0, 0.0], [8.0, 6.0], [b, 6.0], [b, 2.0], [a, 2.0], [a, 6.0], [0.0, 6.0]];
        extruded(&outline, &[[0, 1, 4], [0, 4, 5], [0, 5, 7], [5, 6, 7], [1, 2, 4], [2, 3, 4]], 4.0)
    };
    for name in ["sla", "sls", "binder-jet"] {
        let gap = Process::named(name).unwrap().element.closing_gap_mm;
        for (turn, away) in [(0.0, 0.0), (0.0, 0.37), (17.0, 0.0)] {
            let (s, c) = f64::to_radians(turn).sin_cos();
            let of = |gap: f64| {
                let rows = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
                places_in(
                    name,
                    slotted(gap).transformed(rows, [0.0; 3]).joined(&cuboid([20.0 + away; 3], [21.0 + away; 3])),
                )
            };
            let filled: Vec<Finding> = of(gap).into_iter().filter(|f| f.kind == "filled").collect();
            assert!(filled.is_empty(), "{name} {turn} {away}: {filled:?}");
            assert!(of(0.8 * gap).iter().any(|f| f.kind == "filled" && f.decided), "{name} {turn} {away}");
        }
    }
}

#[test]
fn a_lying_slot_closes_where_two_moved_faces_cover_it() {
    // The least share laid is that of a disc up to a quarter of its width from its rim, 0.8045: faces across z move by the rest of 0.2 mm.
    let lying = |gap: f64| {
        let blocks = cuboid([0.0; 3], [6.0, 5.0, 2.0]).joined(&cuboid([0.0, 0.0, 2.0 + gap], [6.0, 5.0, 4.0 + gap]));
        places(blocks)
    };
    let moved = 0.2 * 0.1955;
    let found = lying(1.2 * moved);
    assert!(found.len() == 1 && found[0].kind == "filled" && found[0].decided, "{found:?}");
    assert!(lying(2.6 * moved).is_empty(), "{:?}", lying(2.6 * moved));
}

#[test]
fn a_sheet_is_lost_that_the_middle_of_a_bead_holds_less_than_half_of() {
    for turn in [0.0f64, 30.0] {
        let (s, c) = turn.to_radians().sin_cos();
        let sheet = |thick: f64| {
            let mesh = cuboid([0.0; 3], [thick, 6.0, 5.0]);
            places(mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.02, 0.01, 0.03]))
        };
        // 0.404 of the width of 0.4 mm.
        let found = sheet(0.13);
        assert!(found.len() == 1 && found[0].kind == "lost" && found[0].decided, "{turn}: {found:?}");
        let truth = 0.13 * 6.0 * 5.0;
        assert!(found[0].low <= truth && truth <= found[0].high, "{turn}: {truth} {found:?}");
        assert!(sheet(0.2).is_empty(), "{turn}: {:?}", sheet(0.2));
    }
}

#[test]
fn of_five_clearances_around_pins_those_below_the_closing_gap_are_told_with_their_volumes() {
    let Some(folder) = crate::models::corpus() else { return };
    let name = "tolerance_pins.stl";
    let bytes = std::fs::read(folder.join("calibration").join(name)).expect("a part");
    let options = Options { only: vec!["as-printed".into()], ..Options::new(process("fdm", &[])) };
    let report = judge_bytes(name, &bytes, &options).expect("a report");
    // Radial gaps of 0.0999, 0.1498 and 0.1998 mm around pins of 8 mm; narrow-gap measures 265.8, 267.5 and 269.1 mm² of them.
    let mut places: Vec<(bool, f64, f64, f64)> = findings(&report, "AM401")
        .iter()
        .flat_map(|f| f.places.iter().map(|p| (f.decided, p.value, p.low, p.high)))
        .collect();
    places.sort_by(|a, b| a.1.total_cmp(&b.1));
    assert_eq!(places.iter().map(|p| p.0).collect::<Vec<_>>(), [true, true, false], "{places:?}");
    for ((_, value, low, high), truth) in places.into_iter().zip([0.0999 * 265.8, 0.1498 * 267.5, 0.1998 * 269.1]) {
        assert!((value - truth).abs() < 0.01 * truth && low <= truth && truth <= high, "{truth}: {value} {low} {high}");
    }
}
