//! Where a surface ends, and how much its winding number may change away from it.

use super::TriangleMesh;
use super::bvh::{Bounds, Bvh};
use super::edges::EdgeTable;
use super::vector::{Vec3, add, distance, dot, greatest, least, norm2, scale, sub};
use std::f64::consts::PI;

/// The edges along which a mesh ends, each as often as its facets use it more one way than the other.
///
/// # Cost
/// O(m log m) to build for m facets.
#[derive(Debug, Clone)]
pub(super) struct Rim {
    edges: Vec<[Vec3; 2]>,
    tree: Bvh,
    /// Length of the edges below each node of the tree, each as often as it counts.
    lengths: Vec<f64>,
    /// How often each edge counts.
    weights: Vec<f64>,
}

impl Rim {
    /// The rim of a mesh; a closed one has none.
    pub(super) fn of(mesh: &TriangleMesh) -> Self {
        let table = EdgeTable::of(mesh);
        let open = table.edges().filter(|edge| edge.imbalance() != 0);
        let open = open.map(|edge| (edge.ends.map(|v| mesh.vertices[v as usize]), f64::from(edge.imbalance().abs())));
        let (edges, weights): (Vec<[Vec3; 2]>, Vec<f64>) = open.unzip();
        let boxes: Vec<Bounds> = edges.iter().map(|&[a, b]| (least(a, b), greatest(a, b))).collect();
        let tree = Bvh::new(&boxes);
        let mut lengths = vec![0.0; tree.nodes().len()];
        // Children stand behind their parents.
        for (n, node) in tree.nodes().iter().enumerate().rev() {
            lengths[n] = match node.children() {
                Some([left, right]) => lengths[left] + lengths[right],
                None => tree.order()[node.run()].iter().map(|&e| length(edges[e as usize]) * weights[e as usize]).sum(),
            };
        }
        Rim { edges, tree, lengths, weights }
    }

    /// A bound of |w(q) − w(p)|, w the winding number of the mesh, for every q at most `radius` from p that is seen from there: no facet
    /// lies between. Infinite where the rim comes as near.
    ///
    /// # Method
    /// Off the surface ∇w(x) = (1/4π) ∮ (y − x) × dy/|y − x|³ along the rim, as the field of a current (Biot and Savart), so
    /// |∇w(x)| ≤ (1/4π) ∮ |dy|/|y − x|². With D the distance of an edge from p, |y − x| ≥ |y − p|·(1 − radius/D), and
    /// ∫ |dy|/|y − p|² ≤ min(length/D², π/D) over a straight edge. Edges that are far for their number count together.
    ///
    /// # Cost
    /// O(log k) for k edges, O(k) near them.
    pub(super) fn change(&self, p: Vec3, radius: f64) -> f64 {
        let nodes = self.tree.nodes();
        let mut open: Vec<usize> = if nodes.is_empty() { Vec::new() } else { vec![0] };
        let mut flux = 0.0;
        while let Some(n) = open.pop() {
            let node = &nodes[n];
            let (lo, hi) = node.extent();
            let apart = node.distance2(p).sqrt();
            match node.children() {
                Some(children) if apart <= distance(lo, hi) + radius => open.extend(children),
                Some(_) => flux += self.lengths[n] / (apart - radius).powi(2),
                None => {
                    for &e in &self.tree.order()[node.run()] {
                        let edge = self.edges[e as usize];
                        let d = from_edge(p, edge);
                        if d <= radius {
                            return f64::INFINITY;
                        }
                        let whole = (length(edge) / (d * d)).min(PI / d);
                        flux += self.weights[e as usize] * whole / (1.0 - radius / d).powi(2);
                    }
                }
            }
        }
        radius * flux / (4.0 * PI)
    }
}

fn length([a, b]: [Vec3; 2]) -> f64 {
    distance(a, b)
}

/// Distance of a point from a straight edge.
fn from_edge(p: Vec3, [a, b]: [Vec3; 2]) -> f64 {
    let way = sub(b, a);
    let along = if norm2(way) > 0.0 { (dot(sub(p, a), way) / norm2(way)).clamp(0.0, 1.0) } else { 0.0 };
    distance(p, add(a, scale(way, along)))
}

#[cfg(test)]
mod tests {
    use super::super::MeshDistance;
    use super::super::voxelize::tests::{block, sphere, winding};
    use super::*;
    use crate::random::Lcg;

    /// Random places off random torn surfaces: no place that is seen differs by more.
    #[test]
    fn no_place_that_is_seen_differs_by_more_than_the_bound() {
        let mut r = Lcg(5);
        for n in 0..60 {
            let mut mesh = match n % 3 {
                0 => block([0.0; 3], [5.0, 4.0, 3.0]),
                1 => sphere(2.5, 2),
                _ => sphere(2.5, 3),
            };
            for _ in 0..1 + r.below(10) {
                mesh.triangles.swap_remove(r.below(mesh.triangles.len() as u64) as usize);
            }
            if n % 5 == 0 {
                // A facet that is turned counts twice along each of its edges.
                mesh.triangles[0].swap(0, 1);
            }
            let (rim, surface) = (Rim::of(&mesh), MeshDistance::new(&mesh));
            for _ in 0..60 {
                let p = r.point(-4.0, 6.0);
                let radius = distance(p, surface.nearest(p, 99.0).expect("a facet").point) * r.unit();
                let (change, w) = (rim.change(p, radius), winding(&mesh, p));
                for _ in 0..8 {
                    let to = r.point(-1.0, 1.0);
                    let q = add(p, scale(to, radius * r.unit() / norm2(to).sqrt()));
                    let moved = (winding(&mesh, q) - w).abs();
                    assert!(moved <= change + 1e-9, "{n} {p:?} {q:?} {moved} {change}");
                }
            }
        }
    }

    /// Along the axis of a round hole, where all of the rim pulls the same way, and farther off, where parts of it pull against each other.
    #[test]
    fn before_a_hole_the_bound_is_near_to_what_changes() {
        let mut open = sphere(2.5, 4);
        open.triangles.retain(|t| t.iter().any(|&v| open.vertices[v as usize][2] < 2.0));
        let rim = Rim::of(&open);
        for (z, times) in [(2.0, 1.5), (1.0, 2.5), (-1.0, 6.0)] {
            let [low, high] = [z - 0.05, z + 0.05].map(|z| winding(&open, [0.0, 0.0, z]));
            let (change, truth) = (rim.change([0.0, 0.0, z], 0.05), 0.5 * (high - low).abs());
            assert!(change > truth && change < times * truth, "{z} {change} {truth}");
        }
    }

    #[test]
    fn a_closed_surface_has_no_rim_and_changes_nowhere() {
        let rim = Rim::of(&block([0.0; 3], [5.0, 4.0, 3.0]));
        assert_eq!(rim.change([1.0; 3], 0.5), 0.0);
        assert_eq!(Rim::of(&TriangleMesh::default()).change([0.0; 3], 1.0), 0.0);
    }
}
