//! An opening lies in the part and a closing holds it: vertices that say otherwise are drawn back onto the part.

use crate::geometry::distance::Nearest;
use crate::geometry::vector::{Vec3, add, along, distance, dot, scale, sub, unit};
use crate::geometry::{MeshDistance, TriangleMesh, Winding};
use rayon::prelude::*;

/// Nearer to the part than this, in spacings, a vertex lies on it.
const ON_PART: f64 = 0.005;

/// How far, in spacings, a vertex can have left its side: those further off are where the surface is right.
const REACH: f64 = 2.0;

/// A facet is as near as the nearest one up to rounding.
const AS_NEAR: f64 = 1.0 + 1e-9;

/// What of its distance from the part a vertex keeps, so that no two come to stand in one point.
const KEPT: f64 = 1e-3;

/// On which side of a part's surface a shape may end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    /// Within the part, as openings do.
    Within,
    /// Outside of it, as closings do.
    Outside,
}

/// Draws the vertices of a surface that lie on the wrong side of a part to the part's surface.
///
/// Where a wall or a gap is thinner than the samples, the samples' surface may cross the part's, and where facets lie on each
/// other the nearest one may face the wrong way. The surface is closed as before.
///
/// # Cost
/// A distance to the part for each vertex, two for those that are off it; winding numbers for those that lie behind their nearest
/// facet or behind one as near.
pub(super) fn drawn_back(surface: &mut TriangleMesh, part: &TriangleMesh, exact: &MeshDistance, h: f64, side: Side) {
    let outward = if side == Side::Within { 1.0 } else { -1.0 };
    let behind = |&p: &Vec3| {
        let nearest = exact.nearest(p, REACH * h).filter(|nearest| nearest.distance > ON_PART * h)?;
        let off = sub(p, nearest.point);
        // Beside an edge the other facet may tell the side: only what stands over its facet on the right one is let go, unless
        // another facet that lies on it faces the other way.
        let wrong = |least: f64, facet: u32| outward * dot(off, exact.normal(facet)) > least * nearest.distance;
        let doubled = || exact.nearest_where(p, nearest.distance * AS_NEAR, |facet, _| wrong(0.0, facet)).is_some();
        (wrong(-0.999, nearest.facet) || doubled()).then_some(nearest)
    };
    let suspected: Vec<(usize, Nearest)> =
        surface.vertices.par_iter().enumerate().filter_map(|(at, p)| Some((at, behind(p)?))).collect();
    if suspected.is_empty() {
        return;
    }
    let winding = Winding::new(part);
    let on_part: Vec<(usize, Vec3)> = suspected
        .into_par_iter()
        .filter(|&(at, _)| (winding.at(surface.vertices[at]) > 0.5) == (side == Side::Outside))
        .map(|(at, nearest)| {
            let bounds = |facet: u32, q: Vec3| is_boundary(exact, &winding, facet, q, h);
            if bounds(nearest.facet, nearest.point) {
                return (at, nearest.point);
            }
            let found = exact.nearest_where(surface.vertices[at], REACH * h, bounds);
            (at, found.unwrap_or(nearest).point)
        })
        .collect();
    for (at, q) in on_part {
        let off = sub(surface.vertices[at], q);
        surface.vertices[at] = add(q, scale(off, KEPT));
    }
}

/// Whether a point of a facet has material on one side only: facets that lie on each other, or inside the material, have not.
fn is_boundary(exact: &MeshDistance, winding: &Winding, facet: u32, q: Vec3, h: f64) -> bool {
    let [a, b, c] = exact.corners(facet);
    let centre = scale(add(add(a, b), c), 1.0 / 3.0);
    // A little into the facet, so that no side is missed at a sharp rim.
    let inwards = (0.01 * h).min(0.5 * distance(centre, q));
    let beside = along(q, unit(sub(centre, q)), inwards);
    let in_material = |off: f64| winding.at(along(beside, exact.normal(facet), off * h)) > 0.5;
    !in_material(1e-3) && in_material(-1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn vertices_on_the_wrong_side_come_back_and_others_stay() {
        let part = cuboid([0.0; 3], [4.0, 4.0, 0.4]);
        let exact = MeshDistance::new(&part);
        let made = cuboid([0.1, 0.1, -0.2], [3.9, 4.3, 0.3]);
        let mut within = made.clone();
        drawn_back(&mut within, &part, &exact, 0.5, Side::Within);
        let (lo, hi) = within.bounds().unwrap();
        assert!(lo[2] > -1e-3 && hi[1] < 4.0 + 1e-3, "{lo:?} {hi:?}");
        // The corner at (0.1, 0.1, 0.3) lies in the part and stays.
        assert!(within.vertices.contains(&[0.1, 0.1, 0.3]));
        let mut around = made.clone();
        drawn_back(&mut around, &part, &exact, 0.5, Side::Outside);
        assert!(around.vertices.contains(&[0.1, 0.1, -0.2]) && !around.vertices.contains(&[0.1, 0.1, 0.3]));
    }

    #[test]
    fn a_skin_without_thickness_is_no_part_of_an_opening() {
        // A plate, and above it two facets that lie on each other, the one that faces down first.
        let skin = |z: f64| [[1.0, 1.0, z], [1.0, 3.0, z], [3.0, 1.0, z]];
        let [a, b, c] = skin(1.0);
        let part = TriangleMesh::weld([[a, b, c], [a, c, b]]).joined(&cuboid([0.0; 3], [4.0, 4.0, 0.4]));
        let exact = MeshDistance::new(&part);
        let made = cuboid([0.1, 0.1, 0.1], [3.9, 3.9, 0.3]).joined(&cuboid([1.2, 1.2, 0.3], [1.6, 1.6, 1.2]));
        let mut within = made.clone();
        drawn_back(&mut within, &part, &exact, 0.5, Side::Within);
        let (_, hi) = within.bounds().unwrap();
        assert!(hi[2] < 0.4 + 1e-2, "{hi:?}");
    }
}
