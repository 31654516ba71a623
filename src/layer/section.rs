//! A level section of the part: its points and its area.

use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, cross, sub};
use rayon::prelude::*;

/// A point of a layer's plane.
pub type Point = [f64; 2];

/// Where the edges of a mesh cross the plane z = `level`: the corners of the section's outlines, twice each.
///
/// A corner that lies in the plane counts as lying above it, so an outline of facets that lie in the plane comes from the facets
/// below.
///
/// # Cost
/// O(facets).
pub fn section_points(mesh: &TriangleMesh, level: f64) -> Vec<Point> {
    let crossing = |p: Vec3, q: Vec3| {
        ((p[2] < level) != (q[2] < level)).then(|| {
            let t = (level - p[2]) / (q[2] - p[2]);
            [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]
        })
    };
    (0..mesh.triangles.len())
        .into_par_iter()
        .flat_map_iter(|f| {
            let [a, b, c] = mesh.corners(f);
            [(a, b), (b, c), (c, a)].into_iter().filter_map(move |(p, q)| crossing(p, q))
        })
        .collect()
}

/// Area of the section of a closed surface at z = `level`, mm²: A = −∫ n_z dA over the surface below (divergence theorem).
///
/// `bounding` says which facets bound the solid. Exact for a closed surface that does not cross itself.
///
/// # Cost
/// O(facets).
pub fn section_area(mesh: &TriangleMesh, bounding: impl Fn(usize) -> bool + Sync, level: f64) -> f64 {
    let below = |f: usize| {
        let corners = mesh.corners(f);
        if corners.iter().all(|p| p[2] > level) {
            return 0.0;
        }
        let clipped = clip_below(corners, level);
        let fan = 1..clipped.len().saturating_sub(1);
        fan.map(|i| -0.5 * cross(sub(clipped[i], clipped[0]), sub(clipped[i + 1], clipped[0]))[2]).sum()
    };
    let parts: Vec<f64> = (0..mesh.triangles.len()).into_par_iter().filter(|&f| bounding(f)).map(below).collect();
    parts.iter().sum()
}

/// The part of a triangle below a height.
pub fn clip_below(t: [Vec3; 3], top: f64) -> Vec<Vec3> {
    let mut out = Vec::with_capacity(4);
    for i in 0..3 {
        let (p, q) = (t[i], t[(i + 1) % 3]);
        if p[2] <= top {
            out.push(p);
        }
        if (p[2] < top && q[2] > top) || (p[2] > top && q[2] < top) {
            let s = (top - p[2]) / (q[2] - p[2]);
            out.push([0, 1, 2].map(|a| p[a] + s * (q[a] - p[a])));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Hull;

    #[test]
    fn the_section_of_a_tetrahedron() {
        let p = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]];
        let mesh =
            TriangleMesh::weld([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|t: [usize; 3]| t.map(|v| p[v])));
        for level in [0.1, 1.0, 2.9] {
            let side: f64 = 3.0 - level;
            assert!((section_area(&mesh, |_| true, level) - 0.5 * side * side).abs() < 1e-12);
            let hull = Hull::of(section_points(&mesh, level));
            assert!((hull.area() - 0.5 * side * side).abs() < 1e-12);
        }
    }
}
