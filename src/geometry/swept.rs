//! The solid that a closed mesh sweeps along a way.

use super::mesh::TriangleMesh;
use super::vector::{Vec3, add, dot};
use rustc_hash::FxHashMap;

/// The closed mesh of what a closed mesh B sweeps along one translation: `∪ { B + p + t·v : 0 ≤ t ≤ 1 }` is where its
/// winding number is positive.
///
/// Facets that look along v stand at the end of the way, the others at its start, and quadrilaterals along v join them
/// at the silhouette. A ray from x against v leaves B once more for each facet looking along v that it meets before it is
/// |v| long, so that the winding number about x is that of B + p and one more for each of them: never negative, and
/// positive just where some copy holds x.
///
/// # Limits
/// A mesh that is not closed sweeps one that is not, and where winding numbers are negative the sweep may hold too much.
///
/// # Cost
/// O(facets).
///
/// ```
/// use amcheck::geometry::{cuboid, swept};
/// let bar = swept(&cuboid([0.0; 3], [1.0, 2.0, 3.0]), [5.0, 0.0, 0.0], [4.0, 0.0, 0.0]);
/// assert_eq!((bar.signed_volume(), bar.bounds()), (30.0, Some(([5.0, 0.0, 0.0], [10.0, 2.0, 3.0]))));
/// ```
pub fn swept(mesh: &TriangleMesh, p: Vec3, v: Vec3) -> TriangleMesh {
    let count = mesh.vertices.len() as u32;
    let at_start = mesh.vertices.iter().map(|&x| add(x, p));
    let at_end = mesh.vertices.iter().map(|&x| add(x, add(p, v)));
    let mut triangles = Vec::with_capacity(mesh.triangles.len());
    // Ways of an edge along facets that look along v, less ways back: what is left is silhouette.
    let mut silhouette: FxHashMap<[u32; 2], i32> = FxHashMap::default();
    for (facet, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        if dot(mesh.area_vector(facet), v) <= 0.0 {
            triangles.push([a, b, c]);
            continue;
        }
        triangles.push([a, b, c].map(|vertex| vertex + count));
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let (edge, way) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
            *silhouette.entry(edge).or_default() += way;
        }
    }
    let mut edges: Vec<([u32; 2], i32)> = silhouette.into_iter().filter(|(_, ways)| *ways != 0).collect();
    edges.sort_unstable();
    for ([low, high], ways) in edges {
        let [a, b] = if ways > 0 { [low, high] } else { [high, low] };
        for _ in 0..ways.unsigned_abs() {
            triangles.extend([[a, b, b + count], [a, b + count, a + count]]);
        }
    }
    TriangleMesh { vertices: at_start.chain(at_end).collect(), triangles }
}

#[cfg(test)]
mod tests {
    use super::super::voxelize::occupancy;
    use super::super::{Primitive, cuboid, revolved};
    use super::*;
    use crate::field::Indicator;
    use crate::grid::Grid;
    use crate::random::Lcg;
    use crate::units::Length;

    const STILL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    /// The samples of copies so dense that only those within `step` of the surface may be missed.
    fn of_copies(mesh: &TriangleMesh, v: Vec3, grid: &Grid, copies: u32) -> Indicator {
        let mut all = Indicator::empty(*grid);
        for n in 0..=copies {
            let t = f64::from(n) / f64::from(copies);
            let copy = mesh.transformed(STILL, v.map(|x| t * x));
            all = all.union(&occupancy(&copy, grid).unwrap()).unwrap();
        }
        all
    }

    #[test]
    fn the_swept_solid_is_the_union_of_all_copies() {
        let mut random = Lcg(5);
        // A ring, a pair of boxes and a wedge: concave, in two bodies, with facets along the way.
        let ring = revolved(&[[1.0, 0.0], [2.0, 0.0], [2.5, 0.5], [1.5, 1.0]], 24);
        let boxes = cuboid([0.0; 3], [1.0, 2.0, 0.5]).joined(&cuboid([1.5, 0.0, -1.0], [2.0, 0.5, 1.0]));
        let cone = Primitive::parse("cone:r1r0h2mm").unwrap().mesh(Length::mm(0.05));
        for mesh in [ring, boxes, cone] {
            for turned in [false, true, true, true] {
                let mesh = if turned { mesh.transformed(random.rotation(), [0.0; 3]) } else { mesh.clone() };
                let v = if turned { random.point(-3.0, 3.0) } else { [2.0, 0.0, 0.0] };
                let whole = swept(&mesh, [0.0; 3], v);
                let (lo, hi) = whole.bounds().unwrap();
                let grid = Grid::covering(lo, hi, Length::mm(0.17), 2, [0.23, 0.31, 0.27]).unwrap();
                let exact = occupancy(&whole, &grid).unwrap();
                let copies = of_copies(&mesh, v, &grid, 60);
                assert!(copies.is_subset(&exact).unwrap(), "a copy reaches out of the sweep");
                // Copies v/60 apart leave gaps at most so deep, over less than the whole surface.
                let missed = exact.difference(&copies).unwrap().volume().as_mm3();
                let step = v.iter().map(|x| x * x).sum::<f64>().sqrt() / 60.0;
                assert!(missed <= 0.5 * step * whole.area(), "{missed} of {step}");
            }
        }
    }

    #[test]
    fn the_volume_of_a_swept_convex_solid_is_its_own_and_its_shadow_times_the_way() {
        let ball = Primitive::parse("ball:1mm").unwrap().mesh(Length::mm(0.0005));
        let long = swept(&ball, [0.0; 3], [0.0, 3.0, 4.0]);
        let truth = 4.0 / 3.0 * std::f64::consts::PI + 5.0 * std::f64::consts::PI;
        assert!((long.signed_volume() / truth - 1.0).abs() < 2e-3, "{} {truth}", long.signed_volume());
    }
}
