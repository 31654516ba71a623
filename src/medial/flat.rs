//! Flat faces, of however many facets, as far as they lie about a place.

use crate::geometry::triangle::closest_point;
use crate::geometry::vector::{Vec3, distance, dot, norm, sub, unit};
use crate::geometry::{Adjacency, TriangleMesh};

/// Facets of a face that are looked at; a face of more about one place is wide.
const LOOKED_AT: usize = 256;
/// A corner that lies off the plane of a neighbour by up to this many steps lies in it: each of four corners may be off by one.
const IN_PLANE: f64 = 4.0;
/// A facet lower than this many steps is a needle whose direction is not known to 5 degrees: it lies in no plane.
const NEEDLE: f64 = 11.5;

/// Whether a facet is so low over an edge of it that nothing is known of its direction.
pub(super) fn is_needle(mesh: &TriangleMesh, f: u32, ends: [u32; 2], step: f64) -> bool {
    let [a, b] = ends.map(|v| mesh.vertices[v as usize]);
    norm(mesh.area_vector(f as usize)) <= NEEDLE * step * distance(a, b)
}

/// Whether two facets that share the edge between `ends` lie in one plane, as well as coordinates good to `step` tell.
pub(super) fn is_flat(mesh: &TriangleMesh, [f, g]: [u32; 2], ends: [u32; 2], step: f64) -> bool {
    let [a, b] = ends.map(|v| mesh.vertices[v as usize]);
    let run = distance(a, b);
    let twice = [f, g].map(|f| mesh.area_vector(f as usize));
    let heights = twice.map(|n| norm(n) / run);
    let apex = |f: u32| mesh.triangles[f as usize].into_iter().find(|v| !ends.contains(v));
    let (taller, lower) = if heights[0] >= heights[1] { (twice[0], g) } else { (twice[1], f) };
    let Some(tip) = apex(lower).map(|v| mesh.vertices[v as usize]) else { return false };
    let lies_in = dot(unit(taller), sub(tip, a)).abs() <= IN_PLANE * step;
    // What is folded back lies in the plane too.
    !is_needle(mesh, lower, ends, step) && lies_in && dot(twice[0], twice[1]) > 0.0
}

/// The facet that shows a flat face to be wide: one that comes within `reach` of a place and of which a corner is further than that from the
/// line for which `off` measures; `None` if the face is narrow there.
///
/// The face is all that is joined to `first` over edges between facets of one plane, within `reach` of the place: how it is divided does not tell.
///
/// # Cost
/// O(facets of the face there), at most 256.
pub(super) fn wide_facet(
    (mesh, next): (&TriangleMesh, &Adjacency),
    first: u32,
    (place, reach, step): (Vec3, f64, f64),
    off: impl Fn(Vec3) -> f64,
) -> Option<u32> {
    let is_wide = |f: u32| mesh.corners(f as usize).into_iter().any(|p| off(p) > reach);
    let (mut known, mut at) = (vec![first], 0);
    while let Some(&f) = known.get(at) {
        if is_wide(f) || known.len() > LOOKED_AT {
            return Some(f);
        }
        at += 1;
        let t = mesh.triangles[f as usize];
        for e in 0..3 {
            let Some(g) = next.across(f, e).filter(|g| !known.contains(g)) else { continue };
            let is_near = || distance(place, closest_point(place, mesh.corners(g as usize))) <= reach;
            if is_flat(mesh, [f, g], [t[e], t[(e + 1) % 3]], step) && is_near() {
                known.push(g);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip along x from y = 0 to `widths[0]`, another from there on, which rises by `rise` in all, as four facets.
    fn strips(widths: [f64; 2], rise: f64) -> TriangleMesh {
        let (near, far) = (widths[0], widths[0] + widths[1]);
        let quad = |y: f64, z: f64, v: f64, w: f64| {
            let [a, b, c, d] = [[0.0, y, z], [4.0, y, z], [4.0, v, w], [0.0, v, w]];
            [[a, b, c], [a, c, d]]
        };
        TriangleMesh::weld([quad(0.0, 0.0, near, 0.0), quad(near, 0.0, far, rise)].concat())
    }

    #[test]
    fn a_face_is_as_wide_as_all_of_its_facets_and_no_wider_than_its_plane() {
        let found = |widths, rise| {
            let mesh = strips(widths, rise);
            let next = Adjacency::of(&mesh, |_| true);
            wide_facet((&mesh, &next), 0, ([2.0, 0.0, 0.0], 0.05, 1e-6), |p| p[1].hypot(p[2]))
        };
        assert!(found([0.02, 3.0], 0.0).is_some_and(|f| f > 1));
        assert_eq!(found([0.3, 3.0], 0.0), Some(0));
        assert_eq!(found([0.02, 0.02], 0.0), None);
        // Bent by a hundredth, or folded back onto itself.
        assert_eq!(found([0.02, 3.0], 0.03), None);
        assert_eq!(found([0.02, -3.0], 0.0), None);
        // What lies out of reach is not asked.
        assert_eq!(found([0.049, 0.0], 0.0), None);
    }

    #[test]
    fn a_needle_lies_in_no_plane() {
        for (height, flat) in [(1e-5, false), (2e-5, true)] {
            let mesh = strips([height, 3.0], 0.0);
            // The facet of the needle that has the shared edge, and its neighbour across.
            let next = Adjacency::of(&mesh, |_| true);
            let t = mesh.triangles[1];
            let across = (0..3).find_map(|e| next.across(1, e).filter(|g| *g > 1).map(|g| (g, [t[e], t[(e + 1) % 3]])));
            let (g, ends) = across.unwrap();
            assert_eq!(is_flat(&mesh, [1, g], ends, 1e-6), flat);
        }
    }
}
