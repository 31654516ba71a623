//! Sheets that change their thickness: which of it is told, how often, and at what limit.

use crate::{findings, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::{Finding, State};
use amcheck::geometry::{TriangleMesh, extruded};

/// What thin-wall finds in it, limits of 0.8 and 1.2 mm.
fn walls(mesh: TriangleMesh) -> Vec<Finding> {
    let mut options = Options::new(process("fdm", &["thin-wall=0.8mm,1.2mm"]));
    options.only = vec!["thin-wall".into()];
    findings(&judge_mesh(mesh, &options), "AM101").to_vec()
}

#[test]
fn a_wall_that_tapers_through_both_limits_is_told_once_below_each() {
    for (thin, thick) in [(0.6, 1.6), (0.5, 1.5), (0.7, 1.3)] {
        let outline = [[0.0, 0.0], [20.0, 0.0], [20.0, thick], [0.0, thin]];
        let found = walls(extruded(&outline, &[[0, 1, 2], [0, 2, 3]], 10.0));
        let states: Vec<State> = found.iter().map(|f| f.state).collect();
        assert_eq!(states, [State::Fail, State::Warn], "{found:?}");
        // The thinnest ball touches the rim at x = 0 beside both sides: r = (thin + s r - r) / sqrt(1 + s²).
        let slope: f64 = (thick - thin) / 20.0;
        let rim = 2.0 * thin / (1.0 + slope.hypot(1.0) - slope);
        assert!(found[0].low <= rim && rim <= found[0].high && found[0].count == 1, "{rim}: {:?}", found[0]);
        assert!(found[0].value - rim < 1e-3, "{rim}: {:?}", found[0]);
        // What is thinner than the limit is the first one's: the second begins at it, on the slope of 1 : 20.
        assert!(found[1].low >= 0.8 - 1e-5 && found[1].value < 0.83 && found[1].count == 1, "{:?}", found[1]);
        let at = |f: &Finding| f.at_mm[0];
        assert!(at(&found[1]) > at(&found[0]) + 1.0, "{found:?}");
    }
}

#[test]
fn a_plate_that_ends_in_an_edge_is_as_thick_as_before_the_edge() {
    for (thickness, state) in [(0.9, State::Warn), (0.7, State::Fail)] {
        let half = 0.5 * thickness;
        // Its sides meet at 25 degrees: a ball between them sees its contacts as those of a wall.
        let tip = 10.0 + half / 12.5f64.to_radians().tan();
        let outline = [[0.0, 0.0], [10.0, 0.0], [tip, half], [10.0, thickness], [0.0, thickness]];
        let found = walls(extruded(&outline, &[[0, 1, 3], [0, 3, 4], [1, 2, 3]], 10.0));
        assert_eq!(found.len(), 1, "{found:?}");
        let f = &found[0];
        assert!(f.state == state && f.decided && (f.value - thickness).abs() < 1e-3, "{f:?}");
    }
}
