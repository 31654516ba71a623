//! An opening lies in the part and a closing holds it: vertices that say otherwise are drawn back onto the part.

use crate::geometry::vector::{add, dot, scale, sub};
use crate::geometry::{MeshDistance, TriangleMesh, Winding};
use rayon::prelude::*;

/// Nearer to the part than this, in spacings, a vertex lies on it.
const ON_PART: f64 = 0.005;

/// How far, in spacings, a vertex can have left its side: those further off are where the surface is right.
const REACH: f64 = 2.0;

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

/// Draws the vertices of a surface that lie on the wrong side of a part onto the part's nearest point.
///
/// Where a wall or a gap is thinner than the samples, the samples' surface may cross the part's. It is closed as before.
///
/// # Cost
/// A distance to the part for each vertex; a winding number for those that lie behind their nearest facet.
pub(super) fn drawn_back(surface: &mut TriangleMesh, part: &TriangleMesh, exact: &MeshDistance, h: f64, side: Side) {
    let outward = if side == Side::Within { 1.0 } else { -1.0 };
    let behind = |&p: &[f64; 3]| {
        let nearest = exact.nearest(p, REACH * h)?;
        let off = sub(p, nearest.point);
        // Beside an edge the other facet may tell the side: only what stands over its facet on the right one is let go.
        let wrong = outward * dot(off, exact.normal(nearest.facet)) > -0.999 * nearest.distance;
        (nearest.distance > ON_PART * h && wrong).then_some(nearest.point)
    };
    let suspected: Vec<(usize, [f64; 3])> =
        surface.vertices.par_iter().enumerate().filter_map(|(at, p)| Some((at, behind(p)?))).collect();
    if suspected.is_empty() {
        return;
    }
    let winding = Winding::new(part);
    let on_part: Vec<(usize, [f64; 3])> = suspected
        .into_par_iter()
        .filter(|&(at, _)| (winding.at(surface.vertices[at]) > 0.5) == (side == Side::Outside))
        .collect();
    for (at, q) in on_part {
        let off = sub(surface.vertices[at], q);
        surface.vertices[at] = add(q, scale(off, KEPT));
    }
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
}
