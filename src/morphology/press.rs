//! The place of a ball among facets that is nearest to a point, by the planes that stop it.

use crate::geometry::MeshDistance;
use crate::geometry::vector::{Vec3, along, distance, dot, scale, sub};

/// Planes that may stop a ball: three in a corner, and a few that it left again.
const MOST_PLANES: usize = 8;

/// Sweeps over the planes; each halves what is violated, or more, unless they meet below 60°.
const SWEEPS: usize = 60;

/// All points z with `normal · z ≥ offset`.
#[derive(Clone, Copy)]
struct HalfSpace {
    normal: Vec3,
    offset: f64,
}

/// The centre of a ball of radius |ball| that facets stop near a point, on their outer side for `ball` > 0, no facet
/// reaching into it, and no farther from the point than `reach`; none if it is not found, or no facet is in the way.
///
/// Each facet in the way gives the half-space beyond its tangent at the foot, and the centre goes to the point of all
/// half-spaces that is nearest to p. Among the faces of a convex edge or corner that is the nearest place; elsewhere it is
/// one that fits, and others may be nearer.
///
/// # Cost
/// One distance to the mesh for each plane.
///
/// # Source
/// The projection onto an intersection of half-spaces: C. Hildreth, A quadratic programming procedure, 1957.
pub(super) fn nearest_place(mesh: &MeshDistance, ball: f64, p: Vec3, reach: f64) -> Option<Vec3> {
    let radius = ball.abs();
    let mut planes: Vec<HalfSpace> = Vec::with_capacity(MOST_PLANES);
    let mut centre = p;
    while planes.len() < MOST_PLANES {
        // What reaches in by rounding alone does not.
        let Some(n) = mesh.nearest(centre, radius * (1.0 - 1e-9)) else {
            return (!planes.is_empty()).then_some(centre);
        };
        let facing = scale(mesh.normal(n.facet), ball.signum());
        let off = sub(centre, n.point);
        let normal = match n.distance > 1e-9 * radius {
            true => scale(off, 1f64.copysign(dot(off, facing)) / n.distance),
            false => facing,
        };
        planes.push(HalfSpace { normal, offset: dot(normal, n.point) + radius });
        centre = projection(p, &planes);
        if distance(centre, p) > reach {
            return None;
        }
    }
    None
}

/// The point of all half-spaces nearest to p, or where the last sweep ends.
fn projection(p: Vec3, planes: &[HalfSpace]) -> Vec3 {
    let mut pushes = [0.0f64; MOST_PLANES];
    let mut at = p;
    for _ in 0..SWEEPS {
        let mut moved = 0.0f64;
        for (push, plane) in pushes.iter_mut().zip(planes) {
            let more = (plane.offset - dot(plane.normal, at)).max(-*push);
            *push += more;
            at = along(at, plane.normal, more);
            moved = moved.max(more.abs());
        }
        if moved < 1e-10 {
            break;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn a_ball_is_pressed_into_the_corner_of_a_thin_plate() {
        let mesh = MeshDistance::new(&cuboid([0.0; 3], [12.0, 8.0, 1.2]));
        // From inside and from outside of the corner, its edges and its faces.
        for p in [
            [0.05, 0.1, 0.1],
            [-0.1, 0.2, 0.1],
            [-0.1, -0.1, -0.05],
            [0.1, 0.2, 1.15],
            [3.0, 0.1, 0.6],
            [3.0, 0.1, -0.1],
        ] {
            let centre = nearest_place(&mesh, -0.5, p, 2.0).unwrap();
            let want = [p[0].clamp(0.5, 11.5), p[1].clamp(0.5, 7.5), p[2].clamp(0.5, 0.7)];
            assert!(distance(centre, want) < 1e-6, "{p:?}: {centre:?}, not {want:?}");
        }
        assert_eq!(nearest_place(&mesh, -0.61, [3.0, 4.0, 0.2], 2.0), None);
        assert_eq!(nearest_place(&mesh, -0.5, [3.0, 4.0, 5.0], 2.0), None);
    }

    #[test]
    fn outside_it_rolls_into_grooves() {
        let mesh = MeshDistance::new(&cuboid([0.0; 3], [5.0; 3]).joined(&cuboid([0.0, 0.0, 5.0], [5.0, 2.0, 9.0])));
        let centre = nearest_place(&mesh, 0.7, [2.5, 2.1, 5.2], 2.0).unwrap();
        assert!(distance(centre, [2.5, 2.7, 5.7]) < 1e-6, "{centre:?}");
    }
}
