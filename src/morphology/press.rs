//! The place of a ball among facets that is nearest to a point, by the planes that stop it.

use crate::geometry::MeshDistance;
use crate::geometry::vector::{Vec3, add, along, cross, distance, dot, norm2, scale, sub};

/// Planes that may stop a ball: three in a corner, and a few that it left again.
const MOST_PLANES: usize = 8;

/// What a point lies beyond a plane by, as a share of the radius, and is still on it; and the least share of a direction that planes which are to
/// meet in a point leave each other.
const ROUNDING: f64 = 1e-10;

/// Sweeps over half-spaces.
const SWEEPS: usize = 60;

/// Planes whose normals have this cosine or more, turned, are the sides of one wall.
const SQUARELY: f64 = 1.0 - 1e-9;

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
pub(super) fn nearest_place(mesh: &MeshDistance, ball: f64, p: Vec3, reach: f64) -> Option<Vec3> {
    let exactly =
        |planes: &[HalfSpace], rounding| projection(p, planes, rounding).or_else(|| swept(p, planes, rounding));
    // Tangents at edges and corners take away more than what stands behind them: a way that leads between them may go on.
    let between = |planes: &[HalfSpace], rounding| swept(p, planes, rounding);
    stopped(mesh, ball, p, reach, exactly).or_else(|| stopped(mesh, ball, p, reach, between))
}

/// Where the centre of the ball comes to stand that goes from p to the `next` place by the planes that stop it so far.
fn stopped(
    mesh: &MeshDistance,
    ball: f64,
    p: Vec3,
    reach: f64,
    next: impl Fn(&[HalfSpace], f64) -> Option<Vec3>,
) -> Option<Vec3> {
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
        centre = next(&planes, ROUNDING * radius).filter(|&centre| distance(centre, p) <= reach)?;
    }
    None
}

/// The point of all half-spaces nearest to p, if they hold one; the last of them does not hold the point nearest of the others.
///
/// It lies on the last plane, and on one or two others or none: the point of those planes that is nearest to p, if none pulls it and it lies in
/// all half-spaces. However flat they meet, as the sides of a wedge do, that is exact.
fn projection(p: Vec3, planes: &[HalfSpace], rounding: f64) -> Option<Vec3> {
    let (last, others) = planes.split_last()?;
    let pairs = (0..others.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let alone = std::iter::once(on_plane(p, last));
    let on_two = others.iter().map(|a| on_line(p, [last, a]));
    let on_three = pairs.map(|(i, j)| on_point(p, [last, &others[i], &others[j]]));
    let in_all = |z: &Vec3| planes.iter().all(|plane| dot(plane.normal, *z) >= plane.offset - rounding);
    alone.chain(on_two).chain(on_three).flatten().find(in_all)
}

/// A point between half-spaces where the last sweep over them ends; none if two of them that have no point in common face each other squarely.
///
/// # Source
/// C. Hildreth, A quadratic programming procedure, 1957.
fn swept(p: Vec3, planes: &[HalfSpace], rounding: f64) -> Option<Vec3> {
    let (last, others) = planes.split_last()?;
    let apart = |other: &HalfSpace| dot(other.normal, last.normal) < -SQUARELY && other.offset + last.offset > rounding;
    if others.iter().any(apart) {
        return None;
    }
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
        if moved < rounding {
            break;
        }
    }
    Some(at)
}

/// The foot of p on a plane, if that pushes it there.
fn on_plane(p: Vec3, plane: &HalfSpace) -> Option<Vec3> {
    let push = plane.offset - dot(plane.normal, p);
    (push >= 0.0).then(|| along(p, plane.normal, push))
}

/// The foot of p on the line that two planes meet in, if both push it there.
fn on_line(p: Vec3, planes: [&HalfSpace; 2]) -> Option<Vec3> {
    let [m, n] = planes.map(|plane| plane.normal);
    let [a, b] = planes.map(|plane| plane.offset - dot(plane.normal, p));
    let (cosine, sine2) = (dot(m, n), norm2(cross(m, n)));
    let [push, other] = [a - cosine * b, b - cosine * a].map(|push| push / sine2);
    (sine2 > ROUNDING && push >= 0.0 && other >= 0.0).then(|| along(along(p, m, push), n, other))
}

/// The point that three planes meet in, if all of them push p there.
fn on_point(p: Vec3, planes: [&HalfSpace; 3]) -> Option<Vec3> {
    let [l, m, n] = planes.map(|plane| plane.normal);
    let [a, b, c] = planes.map(|plane| plane.offset - dot(plane.normal, p));
    // The three directions in which one plane is left and the other two are kept.
    let ways = [cross(m, n), cross(n, l), cross(l, m)];
    let volume = dot(l, ways[0]);
    let off = scale(add(add(scale(ways[0], a), scale(ways[1], b)), scale(ways[2], c)), 1.0 / volume);
    let pushes = ways.map(|way| dot(way, off) * volume.signum());
    (volume.abs() > ROUNDING && pushes.iter().all(|push| *push >= 0.0)).then(|| add(p, off))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{cuboid, extruded};

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
    fn a_ball_is_pressed_into_wedges_however_sharp() {
        for degrees in [40.0f64, 18.0, 12.0, 5.0, 1.0] {
            let half = 0.5 * degrees.to_radians();
            let far = 3.0 / half.sin();
            let y = far * half.tan();
            let wedge = extruded(&[[0.0, 0.0], [far, -y], [far, y]], &[[0, 1, 2]], 20.0);
            let mesh = MeshDistance::new(&wedge);
            let rest = 1.0 / half.sin();
            for off in [[-0.9, 0.1], [-0.5, 0.0], [-0.5, -0.7]] {
                let centre = nearest_place(&mesh, -1.0, [rest + off[0], 10.0, off[1]], 2.0);
                let centre = centre.unwrap_or_else(|| panic!("{degrees}° {off:?}"));
                assert!(distance(centre, [rest, 10.0, 0.0]) < 1e-6 * rest, "{degrees}°: {centre:?}, not at {rest}");
            }
        }
    }

    #[test]
    fn outside_it_rolls_into_grooves() {
        let mesh = MeshDistance::new(&cuboid([0.0; 3], [5.0; 3]).joined(&cuboid([0.0, 0.0, 5.0], [5.0, 2.0, 9.0])));
        let centre = nearest_place(&mesh, 0.7, [2.5, 2.1, 5.2], 2.0).unwrap();
        assert!(distance(centre, [2.5, 2.7, 5.7]) < 1e-6, "{centre:?}");
    }
}
