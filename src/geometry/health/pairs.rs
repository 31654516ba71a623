//! Pairs of facets that are near each other.

use crate::geometry::bvh::{Bounds, Bvh, LEAF, Reached, Span};
use crate::geometry::vector::{Vec3, bounds, hull};
use rayon::prelude::*;

/// What rounding may take off a gap between boxes, relative to the tolerance.
const ROUNDING: f64 = 1e-9;

/// Facets that look for others together, at most.
const GROUP: usize = 32;

/// The parts of a tree whose facets look for others together, from left to right, on all cores.
pub(in crate::geometry) fn groups(tree: &Bvh) -> impl IndexedParallelIterator<Item = Span> {
    let groups = tree.whole().map_or_else(Vec::new, |whole| tree.cut(whole, GROUP));
    groups.into_par_iter().with_min_len(16).with_max_len(64)
}

/// Calls `visit(f, g)`, f < g, for the pairs of a facet of a leaf in a group and one of the same leaf or a later one whose boxes are
/// nowhere farther apart than `tolerance`: over all groups each pair once. `near` is a list to work with.
///
/// # Cost
/// One walk of the tree for a group, and for each of its leaves one of what is near the group.
pub(in crate::geometry) fn near_pairs(
    tree: &Bvh,
    corners: &impl Fn(u32) -> [Vec3; 3],
    group: Span,
    tolerance: f64,
    near: &mut Vec<Span>,
    mut visit: impl FnMut(u32, u32),
) {
    let order = tree.order();
    let far = tolerance * (1.0 + ROUNDING);
    let Some(whole) = tree.whole() else { return };
    near.clear();
    let around = Reached::of(wider(tree.extent(group), far));
    tree.meeting(whole, &around, group.start, GROUP, &mut |span| near.push(span));
    for leaf in tree.cut(group, 0) {
        let mut own = [(0u32, ([0.0; 3], [0.0; 3])); LEAF];
        let count = leaf.run().len().min(LEAF);
        for (own, &f) in own.iter_mut().zip(&order[leaf.run()]) {
            *own = (f, grown(corners(f), far));
        }
        let Some(around) = own[..count].iter().map(|o| o.1).reduce(hull) else { continue };
        let mut in_leaf = |other: Span| {
            for (place, &g) in order[other.run()].iter().enumerate() {
                let theirs = grown(corners(g), 0.0);
                let before = if other.start == leaf.start { place } else { count };
                for &(f, _) in own[..before].iter().filter(|(_, of_f)| overlap(*of_f, theirs)) {
                    visit(f.min(g), f.max(g));
                }
            }
        };
        let reached = Reached::of(around);
        near.iter().for_each(|&part| tree.meeting(part, &reached, leaf.start, 0, &mut in_leaf));
    }
}

/// A box, wider by `by` on all sides.
#[inline]
fn wider((lo, hi): Bounds, by: f64) -> Bounds {
    (lo.map(|x| x - by), hi.map(|x| x + by))
}

/// The box of a facet, wider by `by` on all sides.
#[inline]
fn grown(corners: [Vec3; 3], by: f64) -> (Vec3, Vec3) {
    wider(bounds(corners).unwrap_or(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3])), by)
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
            for group in groups(tree.tree()).collect::<Vec<_>>() {
                near_pairs(tree.tree(), &|f| tree.corners(f), group, tolerance, &mut Vec::new(), |f, g| {
                    *seen.entry((f, g)).or_default() += 1
                });
            }
            let near = |f: u32, g: u32| overlap(grown(tree.corners(f), tolerance), grown(tree.corners(g), 0.0));
            let pairs = (0..300).flat_map(|f| (f + 1..300).map(move |g| (f, g))).filter(|&(f, g)| near(f, g));
            assert_eq!(seen, pairs.map(|pair| (pair, 1)).collect());
        }
    }
}
