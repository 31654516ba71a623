//! Pairs of facets that are near each other.

use crate::geometry::bvh::{Bvh, LEAF};
use crate::geometry::vector::{Vec3, bounds, hull};
use rayon::prelude::*;
use std::ops::Range;

/// What rounding may take off a gap between boxes, relative to the tolerance.
const ROUNDING: f64 = 1e-9;

/// The runs of facets in the leaves of a tree, on all cores.
pub(in crate::geometry) fn leaves(tree: &Bvh) -> impl IndexedParallelIterator<Item = Option<Range<usize>>> {
    tree.nodes().par_iter().with_min_len(256).with_max_len(1024).map(|n| n.children().is_none().then(|| n.run()))
}

/// Calls `visit(f, g)`, f < g, for the pairs of a facet in the leaf of a run and one in the same leaf or a later one whose boxes are
/// nowhere farther apart than `tolerance`: over all leaves each pair once.
///
/// # Cost
/// One walk of the tree for the facets of a leaf.
pub(in crate::geometry) fn near_pairs(
    tree: &Bvh,
    corners: &impl Fn(u32) -> [Vec3; 3],
    run: Range<usize>,
    tolerance: f64,
    stack: &mut Vec<usize>,
    mut visit: impl FnMut(u32, u32),
) {
    let (nodes, order) = (tree.nodes(), tree.order());
    let far = tolerance * (1.0 + ROUNDING);
    let mut own = [(0u32, ([0.0; 3], [0.0; 3])); LEAF];
    let count = run.len().min(LEAF);
    for (own, &f) in own.iter_mut().zip(&order[run.clone()]) {
        *own = (f, grown(corners(f), far));
    }
    let Some((lo, hi)) = own[..count].iter().map(|o| o.1).reduce(hull) else { return };
    stack.push(0);
    while let Some(at) = stack.pop() {
        let Some(node) = nodes.get(at) else { continue };
        if node.box_distance2(lo, hi) > 0.0 {
            continue;
        }
        if let Some(children) = node.children() {
            stack.extend(children);
            continue;
        }
        let other = node.run();
        if other.start < run.start {
            continue;
        }
        for (place, &g) in order[other.clone()].iter().enumerate() {
            let theirs = grown(corners(g), 0.0);
            let before = if other.start == run.start { place } else { count };
            for &(f, _) in own[..before].iter().filter(|(_, of_f)| overlap(*of_f, theirs)) {
                visit(f.min(g), f.max(g));
            }
        }
    }
}

/// The box of a facet, wider by `by` on all sides.
#[inline]
fn grown(corners: [Vec3; 3], by: f64) -> (Vec3, Vec3) {
    let (lo, hi) = bounds(corners).unwrap_or(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]));
    (lo.map(|x| x - by), hi.map(|x| x + by))
}

/// Whether two boxes have a point in common.
#[inline]
fn overlap((lo, hi): (Vec3, Vec3), (from, to): (Vec3, Vec3)) -> bool {
    (0..3).all(|a| lo[a] <= to[a] && from[a] <= hi[a])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::add;
    use crate::geometry::{MeshDistance, TriangleMesh};
    use crate::random::Lcg;
    use std::collections::BTreeMap;

    #[test]
    fn every_pair_of_near_boxes_is_visited_once() {
        let mut random = Lcg(17);
        let facets: Vec<[Vec3; 3]> = (0..300)
            .map(|_| {
                let base = random.point(-3.0, 3.0);
                [0; 3].map(|_| add(base, random.point(-0.5, 0.5)))
            })
            .collect();
        let tree = MeshDistance::new(&TriangleMesh::weld(facets));
        for tolerance in [0.0, 0.2] {
            let mut seen: BTreeMap<(u32, u32), usize> = BTreeMap::new();
            for run in leaves(tree.tree()).collect::<Vec<_>>().into_iter().flatten() {
                near_pairs(tree.tree(), &|f| tree.corners(f), run, tolerance, &mut Vec::new(), |f, g| {
                    *seen.entry((f, g)).or_default() += 1
                });
            }
            let near = |f: u32, g: u32| overlap(grown(tree.corners(f), tolerance), grown(tree.corners(g), 0.0));
            let pairs = (0..300).flat_map(|f| (f + 1..300).map(move |g| (f, g))).filter(|&(f, g)| near(f, g));
            assert_eq!(seen, pairs.map(|pair| (pair, 1)).collect());
        }
    }
}
