//! Crossings of a ray with the facets of a mesh.

use super::boxes::{EMPTY, grown};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, cross, dot, norm, sub};

/// Facets in a leaf of the tree.
const LEAF: usize = 4;
/// Relative nearness of a crossing to an edge, or of its start to a facet, that counts as a tie.
const TIE: f64 = 1e-9;

/// Facets in a tree of boxes.
pub(super) struct FacetTree<'a> {
    mesh: &'a TriangleMesh,
    order: Vec<u32>,
    nodes: Vec<Node>,
    extent: f64,
}

struct Node {
    box_mm: [Vec3; 2],
    first: u32,
    /// Number of facets of a leaf; 0 for an inner node, whose children are the next node and `first`.
    count: u32,
}

/// One crossing: the facet, and +1 where the ray leaves through its front, −1 where it enters.
pub(super) struct Crossing {
    pub(super) facet: usize,
    pub(super) sign: i32,
}

impl<'a> FacetTree<'a> {
    /// The tree over some facets of a mesh; ties are judged by `extent`, the longest side of the mesh.
    ///
    /// # Cost
    /// O(facets · log facets).
    pub(super) fn new(mesh: &'a TriangleMesh, facets: Vec<u32>, extent: f64) -> Self {
        let mut tree = FacetTree { mesh, order: Vec::new(), nodes: Vec::with_capacity(facets.len()), extent };
        let mut items: Vec<(Vec3, u32)> = facets.into_iter().map(|f| (mesh.centroid(f as usize), f)).collect();
        tree.build(&mut items, 0);
        tree.order = items.into_iter().map(|i| i.1).collect();
        tree
    }

    /// Halving at the median of the longest side of the centroids: the depth is at most log₂(facets), so
    /// recursion is safe. Returns the box of the facets; `first` is the place of the first in the order.
    fn build(&mut self, items: &mut [(Vec3, u32)], first: usize) -> [Vec3; 2] {
        let at = self.nodes.len();
        self.nodes.push(Node { box_mm: EMPTY, first: first as u32, count: items.len() as u32 });
        if items.len() <= LEAF {
            let corners = items.iter().flat_map(|i| self.mesh.corners(i.1 as usize));
            self.nodes[at].box_mm = corners.fold(EMPTY, grown);
            return self.nodes[at].box_mm;
        }
        let spread = items.iter().map(|i| i.0).fold(EMPTY, grown);
        let sides = sub(spread[1], spread[0]);
        let axis = (1..3).fold(0, |best, a| if sides[a] > sides[best] { a } else { best });
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then_with(|| a.1.cmp(&b.1)));
        let (low, high) = items.split_at_mut(middle);
        let one = self.build(low, first);
        let second = self.nodes.len() as u32;
        let other = self.build(high, first + middle);
        let box_mm = other.into_iter().fold(one, grown);
        self.nodes[at] = Node { box_mm, first: second, count: 0 };
        box_mm
    }

    /// All crossings of the ray from `start` along `direction` with facets that `wanted` names, or `None` for
    /// a tie: a crossing too near an edge, or a start on a facet.
    pub(super) fn crossings(
        &self,
        start: Vec3,
        direction: Vec3,
        wanted: impl Fn(usize) -> bool,
    ) -> Option<Vec<Crossing>> {
        let inverse = direction.map(|d| 1.0 / d);
        let mut found = Vec::new();
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            let Some(node) = self.nodes.get(at) else { continue };
            if !meets(node.box_mm, start, inverse, TIE * self.extent) {
                continue;
            }
            if node.count == 0 {
                stack.extend([at + 1, node.first as usize]);
                continue;
            }
            let leaf = &self.order[node.first as usize..(node.first + node.count) as usize];
            for facet in leaf.iter().map(|&f| f as usize).filter(|&f| wanted(f)) {
                match crossing(self.mesh.corners(facet), start, direction, self.extent) {
                    Hit::Miss => {}
                    Hit::Tie => return None,
                    Hit::Through(sign) => found.push(Crossing { facet, sign }),
                }
            }
        }
        Some(found)
    }
}

/// Whether a ray meets a box grown by a margin.
fn meets([lo, hi]: [Vec3; 2], start: Vec3, inverse: Vec3, margin: f64) -> bool {
    let (mut near, mut far) = (0.0f64, f64::INFINITY);
    for a in 0..3 {
        let (t0, t1) = ((lo[a] - margin - start[a]) * inverse[a], (hi[a] + margin - start[a]) * inverse[a]);
        near = near.max(t0.min(t1));
        far = far.min(t0.max(t1));
    }
    near <= far
}

enum Hit {
    Miss,
    Tie,
    Through(i32),
}

/// The crossing of one facet, by barycentric coordinates.
fn crossing([a, b, c]: [Vec3; 3], start: Vec3, direction: Vec3, extent: f64) -> Hit {
    let (e1, e2, from_a) = (sub(b, a), sub(c, a), sub(start, a));
    let normal = cross(e1, e2);
    let length = norm(normal);
    if length == 0.0 {
        return Hit::Miss;
    }
    let (slope, height) = (dot(normal, direction) / length, dot(normal, from_a) / length);
    if slope.abs() < TIE {
        return if height.abs() < TIE * extent { Hit::Tie } else { Hit::Miss };
    }
    let t = -height / slope;
    let beside = cross(from_a, direction);
    let scale = -1.0 / (slope * length);
    let (v, w) = (dot(e2, beside) * scale, -dot(e1, beside) * scale);
    let least = v.min(w).min(1.0 - v - w);
    if least < -TIE || t < -TIE * extent {
        Hit::Miss
    } else if least < TIE || t < TIE * extent {
        Hit::Tie
    } else {
        Hit::Through(if slope > 0.0 { 1 } else { -1 })
    }
}

/// The solid angle of a facet seen from a point, divided by 4π: facets of a closed shell add up to its
/// winding number (Van Oosterom, Strackee 1983).
pub(super) fn winding_of([a, b, c]: [Vec3; 3], p: Vec3) -> f64 {
    let [a, b, c] = [a, b, c].map(|q| sub(q, p));
    let (la, lb, lc) = (norm(a), norm(b), norm(c));
    let above = dot(a, cross(b, c));
    let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    above.atan2(below) / (2.0 * std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACET: [Vec3; 3] = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 2.0, 1.0]];

    #[test]
    fn a_ray_crosses_misses_or_ties() {
        let hit = |start, direction| match crossing(FACET, start, direction, 2.0) {
            Hit::Miss => 0,
            Hit::Tie => 9,
            Hit::Through(sign) => sign,
        };
        let up = [0.0, 0.0, 1.0];
        assert_eq!(hit([0.5, 0.5, 0.0], up), 1);
        assert_eq!(hit([0.5, 0.5, 2.0], [0.0, 0.0, -1.0]), -1);
        assert_eq!(hit([0.5, 0.5, 2.0], up), 0);
        assert_eq!(hit([1.5, 1.5, 0.0], up), 0);
        assert_eq!(hit([1.0, 0.0, 0.0], up), 9, "edge");
        assert_eq!(hit([0.5, 0.5, 1.0], up), 9, "start on the facet");
        assert_eq!(hit([-1.0, 0.5, 1.0], [1.0, 0.0, 0.0]), 9, "in its plane");
        assert_eq!(hit([0.2, 0.3, 0.0], [0.3, 0.1, 1.0]), 1);
    }

    #[test]
    fn solid_angles_of_a_closed_shell_add_up() {
        let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let shell = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|t: [usize; 3]| t.map(|v| p[v]));
        let winding = |at| shell.iter().map(|&f| winding_of(f, at)).sum::<f64>();
        // Rounding of four arctangents.
        assert!((winding([0.1, 0.1, 0.1]) - 1.0).abs() < 1e-14);
        assert!(winding([1.0, 1.0, 1.0]).abs() < 1e-14);
    }
}
