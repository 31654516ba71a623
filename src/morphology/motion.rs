//! Motions that turn a body: the poses on the way, near enough to each other.

use super::sweep::Placement;
use crate::error::{Error, Result};
use crate::geometry::vector::norm;
use crate::geometry::{Leg, TriangleMesh, Waypoint};
use crate::units::Length;

/// More poses than this are not swept: each is cast by itself.
const MOST_POSES: f64 = 262_144.0;

/// Placements of a mesh along waypoints, straight and evenly turning from one to the next, between which no point of the way of a
/// vertex is longer than half a spacing, as [`super::sweep_poses`] asks for.
///
/// A vertex at distance ρ from the mesh's origin goes at most |Δt| + ρ·θ while the origin goes Δt and the mesh turns by θ.
///
/// # Errors
/// [`Error::Operand`] for fewer than two waypoints or none that differs, turns that are not of unit length, and a motion of more than a
/// quarter of a million placements.
///
/// # Cost
/// O(vertices + placements).
pub fn placements_along(mesh: &TriangleMesh, waypoints: &[Waypoint], spacing: Length) -> Result<Vec<Placement>> {
    let refused = |problem: String, remedy: &str| Error::Operand { operation: "sweep", problem, remedy: remedy.into() };
    for (number, waypoint) in (1..).zip(waypoints) {
        let length = waypoint.turn.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !((length - 1.0).abs() < 1e-6 && norm(waypoint.at_mm).is_finite()) {
            let problem = format!("waypoint {number} is no finite place and unit quaternion: {waypoint:?}");
            return Err(refused(problem, "give places in millimetres and unit quaternions w, x, y, z"));
        }
    }
    let (Some(&first), true) = (waypoints.first(), waypoints.len() > 1) else {
        return Err(refused(format!("a motion of {} pose(s)", waypoints.len()), "give at least two poses"));
    };
    let reach = reach_of(mesh);
    let way = |pair: &[Waypoint]| match pair {
        [from, to] => Leg::new(*from, to).longest(reach),
        _ => 0.0,
    };
    if waypoints.iter().all(|other| *other == first) {
        let problem = format!("{} poses that are all the same", waypoints.len());
        return Err(refused(problem, "give at least two different poses"));
    }
    let steps = |pair: &[Waypoint]| (way(pair) * (1.0 + 1e-9) / (0.5 * spacing.as_mm())).ceil().max(1.0);
    let count: f64 = waypoints.windows(2).map(steps).sum();
    if count.is_nan() || count > MOST_POSES {
        let problem = format!("at {spacing} the motion has {count} placements, half a spacing apart");
        return Err(refused(problem, "choose a larger spacing, or sweep a part of the motion"));
    }
    let between = waypoints.windows(2).flat_map(|pair| {
        let steps = steps(pair);
        (1..=steps as u32).map(move |step| pair[0].towards(&pair[1], f64::from(step) / steps))
    });
    let placed = |at: Waypoint| Placement { rotation: at.rotation(), translation: at.at_mm };
    Ok(std::iter::once(first).chain(between).map(placed).collect())
}

/// How far the vertices of a mesh are from its origin at most.
pub(super) fn reach_of(mesh: &TriangleMesh) -> f64 {
    mesh.vertices.iter().map(|&p| norm(p)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::geometry::vector::distance;

    #[test]
    fn no_vertex_goes_further_than_half_a_spacing() {
        let (bar, h) = (cuboid([-4.0, -0.5, -0.5], [4.0, 0.5, 0.5]), 0.3);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let way = [
            Waypoint { at_mm: [0.0; 3], turn: [1.0, 0.0, 0.0, 0.0] },
            Waypoint { at_mm: [2.0, 0.0, 1.0], turn: [half, 0.0, 0.0, half] },
            Waypoint { at_mm: [2.0, 0.0, 1.0], turn: [-half, 0.0, 0.0, -half] },
            Waypoint { at_mm: [2.0, 5.0, 1.0], turn: [half, half, 0.0, 0.0] },
        ];
        let placed = placements_along(&bar, &way, Length::mm(h)).unwrap();
        let images = |p: &Placement| bar.transformed(p.rotation, p.translation).vertices;
        for pair in placed.windows(2) {
            for (p, q) in images(&pair[0]).into_iter().zip(images(&pair[1])) {
                assert!(distance(p, q) <= 0.5 * h);
            }
        }
        let ends = [placed[0], placed[placed.len() - 1]].map(|p| images(&p)[0]);
        assert!(distance(ends[0], way[0].image(bar.vertices[0])) < 1e-9);
        assert!(distance(ends[1], way[3].image(bar.vertices[0])) < 1e-9);
    }

    #[test]
    fn what_is_no_motion_is_refused() {
        let (bar, still) = (cuboid([0.0; 3], [1.0; 3]), Waypoint { at_mm: [0.0; 3], turn: [1.0, 0.0, 0.0, 0.0] });
        let far = Waypoint { at_mm: [1e9, 0.0, 0.0], ..still };
        let skew = Waypoint { turn: [1.0, 1.0, 0.0, 0.0], ..still };
        for way in [vec![], vec![still], vec![still; 3], vec![still, far], vec![still, skew]] {
            assert!(matches!(placements_along(&bar, &way, Length::mm(0.1)), Err(Error::Operand { .. })), "{way:?}");
        }
    }
}
