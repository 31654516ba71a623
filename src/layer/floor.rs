//! The surface of a solid that looks up, found by what lies above it.

use super::ground::Bounding;
use crate::geometry::TriangleMesh;
use crate::geometry::bvh::{Bvh, bounds_of};
use crate::geometry::ray::Ray;
use crate::geometry::vector::{Vec3, bounds};

/// The facets of a solid that look up: what is laid closely above them rests on it.
///
/// # Cost
/// O(facets + n log n) to build for n facets that look up, some 20 bytes for each.
#[derive(Debug, Clone)]
pub struct Floors {
    tree: Bvh,
}

impl Floors {
    /// { f : f bounds the solid, n_z > 0 }.
    pub fn of(mesh: &TriangleMesh, facets: &impl Bounding) -> Self {
        let looks_up = |f: &usize| mesh.area_vector(*f)[2] > 0.0 && facets.bounds_solid(*f);
        let names: Vec<u32> = (0..mesh.triangles.len()).filter(looks_up).map(|f| f as u32).collect();
        let extent = |n: usize| names.get(n).and_then(|&f| bounds(mesh.corners(f as usize))).unwrap_or_default();
        Floors { tree: Bvh::new(&bounds_of(names.len(), extent)).renamed(&names) }
    }

    /// Whether a line straight down from a place, so long, meets one of them. The mesh is that of [`Floors::of`].
    pub fn lie_below(&self, mesh: &TriangleMesh, place: Vec3, depth: f64) -> bool {
        let down = Ray::of(place, [0.0, 0.0, -1.0]);
        let foot = [place[0], place[1], place[2] - depth];
        let is_met = |f: u32| down.hit(mesh.corners(f as usize)).is_some_and(|s| 0.0 < s && s < depth);
        self.tree.any_in_box((foot, place), is_met)
    }

    /// Those of which the boxes may overlap a box, by its least and greatest corner, in no order.
    pub fn in_box(&self, reach: (Vec3, Vec3), visit: impl FnMut(u32)) {
        self.tree.in_box(reach, visit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{MeshDistance, extruded};
    use crate::random::Lcg;

    #[test]
    fn floors_lie_where_a_ray_down_meets_them() {
        // A channel of 3 mm under a roof of 2 mm, and the same turned.
        let outline =
            [[0.0, 0.0], [10.0, 0.0], [10.0, 8.0], [0.0, 8.0], [0.0, 6.0], [8.0, 6.0], [8.0, 3.0], [0.0, 3.0]];
        let caps = [[0, 1, 6], [0, 6, 7], [1, 2, 5], [1, 5, 6], [2, 3, 4], [2, 4, 5]];
        let upright = extruded(&outline, &caps, 5.0);
        let (s, c) = 0.4f64.sin_cos();
        let leaning = upright.transformed([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]], [0.0; 3]);
        let mut random = Lcg(7);
        for mesh in [upright, leaning] {
            let (floors, all) = (Floors::of(&mesh, &|_: usize| true), MeshDistance::new(&mesh));
            let (lo, hi) = mesh.bounds().unwrap_or_default();
            let mut met = 0;
            for _ in 0..2_000 {
                let place = [0, 1, 2].map(|a| lo[a] + random.unit() * (hi[a] + 1.0 - lo[a]));
                let depth = 4.0 * random.unit();
                let hit = all.first_hit(place, [0.0, 0.0, -1.0], 0.0, depth);
                // From within, the first that a ray meets looks down.
                let expected = hit.is_some_and(|(_, f)| mesh.normal(f as usize)[2] > 0.0);
                let outside = hit.is_none_or(|_| expected);
                if outside {
                    assert_eq!(floors.lie_below(&mesh, place, depth), expected, "{place:?} {depth}");
                    met += u32::from(expected);
                }
            }
            assert!(met > 200, "{met}");
        }
    }
}
