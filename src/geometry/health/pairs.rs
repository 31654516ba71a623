//! Pairs of facets that are near each other.

use crate::geometry::bvh::{Bounds, Bvh, LEAF};
use crate::geometry::vector::{Vec3, bounds};

/// What rounding may take off a gap between boxes, relative to the tolerance.
const ROUNDING: f64 = 1e-9;

/// Nodes this far from the root are walked on one core.
const SPREAD: u32 = 9;

/// What is done with pairs of facets: a result is begun, takes up pairs, and is joined with that of other pairs.
pub(super) trait Gather: Sync {
    type Found: Send;

    fn begin(&self) -> Self::Found;
    fn pair(&self, found: &mut Self::Found, f: u32, g: u32);
    fn join(&self, found: Self::Found, later: Self::Found) -> Self::Found;
}

/// Gathers the pairs f < g of facets whose boxes are nowhere farther apart than `tolerance`, each once; in an order that depends on the
/// tree alone.
///
/// # Cost
/// One walk over the pairs of nodes that are as near, on all cores.
pub(super) fn near_pairs<G: Gather>(
    tree: &Bvh,
    corners: impl Fn(u32) -> [Vec3; 3] + Sync,
    tolerance: f64,
    gather: &G,
) -> G::Found {
    let walk = Walk { tree, corners, far: tolerance * (1.0 + ROUNDING), gather };
    if tree.nodes().is_empty() { gather.begin() } else { walk.within(0, 0) }
}

struct Walk<'a, C, G> {
    tree: &'a Bvh,
    corners: C,
    far: f64,
    gather: &'a G,
}

impl<C: Fn(u32) -> [Vec3; 3] + Sync, G: Gather> Walk<'_, C, G> {
    /// Pairs of facets below a node.
    fn within(&self, node: usize, depth: u32) -> G::Found {
        let mut found = self.gather.begin();
        match self.tree.nodes().get(node).and_then(|n| n.children()) {
            Some([a, b]) if depth < SPREAD => {
                let (own, other) = rayon::join(|| self.within(a, depth + 1), || self.within(b, depth + 1));
                let across = self.across([a, b], depth + 1);
                self.gather.join(self.gather.join(own, other), across)
            }
            _ => {
                self.all_within(node, &mut found);
                found
            }
        }
    }

    /// Pairs of a facet below one node and one below another.
    fn across(&self, [a, b]: [usize; 2], depth: u32) -> G::Found {
        match self.children_of([a, b]) {
            Some([[a, b], [c, d]]) if depth < SPREAD && self.near([a, b]) | self.near([c, d]) => {
                let (one, other) = rayon::join(|| self.across([a, b], depth + 1), || self.across([c, d], depth + 1));
                self.gather.join(one, other)
            }
            _ => {
                let mut found = self.gather.begin();
                self.all_across([a, b], &mut found);
                found
            }
        }
    }

    fn all_within(&self, node: usize, found: &mut G::Found) {
        let Some(at) = self.tree.nodes().get(node) else { return };
        if let Some([a, b]) = at.children() {
            self.all_within(a, found);
            self.all_within(b, found);
            self.all_across([a, b], found);
            return;
        }
        let boxed = self.boxes(node);
        for (n, (g, theirs)) in boxed.iter().enumerate() {
            for (f, own) in &boxed[..n] {
                self.visit((*f, *own), (*g, *theirs), found);
            }
        }
    }

    fn all_across(&self, pair: [usize; 2], found: &mut G::Found) {
        if !self.near(pair) {
            return;
        }
        if let Some([one, other]) = self.children_of(pair) {
            self.all_across(one, found);
            self.all_across(other, found);
            return;
        }
        let [own, theirs] = pair.map(|node| self.boxes(node));
        for g in theirs.iter() {
            for f in own.iter() {
                self.visit(*f, *g, found);
            }
        }
    }

    fn visit(&self, (f, own): (u32, Bounds), (g, theirs): (u32, Bounds), found: &mut G::Found) {
        if (0..3).all(|a| own.0[a] <= theirs.1[a] + self.far && theirs.0[a] <= own.1[a] + self.far) {
            self.gather.pair(found, f.min(g), f.max(g));
        }
    }

    fn near(&self, [a, b]: [usize; 2]) -> bool {
        let nodes = self.tree.nodes();
        let (Some(a), Some(b)) = (nodes.get(a), nodes.get(b)) else { return false };
        let (lo, hi) = b.extent();
        a.box_distance2(lo, hi) <= 3.0 * self.far * self.far
    }

    /// The pair divided: the children of the one that has more facets below it, as its number tells, each with the other.
    fn children_of(&self, [a, b]: [usize; 2]) -> Option<[[usize; 2]; 2]> {
        let below = |node: usize| self.tree.nodes().get(node).and_then(|n| n.children());
        match (below(a), below(b)) {
            (Some([c, d]), Some(_)) if self.wider(a, b) => Some([[c, b], [d, b]]),
            (_, Some([c, d])) => Some([[a, c], [a, d]]),
            (Some([c, d]), None) => Some([[c, b], [d, b]]),
            (None, None) => None,
        }
    }

    fn wider(&self, a: usize, b: usize) -> bool {
        let size = |node: usize| {
            let (lo, hi) = self.tree.nodes().get(node).map_or(([0.0; 3], [0.0; 3]), |n| n.extent());
            (0..3).map(|i| hi[i] - lo[i]).fold(0.0, f64::max)
        };
        size(a) >= size(b)
    }

    /// The facets of a leaf with their boxes.
    fn boxes(&self, node: usize) -> Boxes {
        let mut boxes = Boxes { all: [(0, ([0.0; 3], [0.0; 3])); LEAF], count: 0 };
        let run = self.tree.nodes().get(node).map(|n| n.run()).unwrap_or_default();
        for (to, &f) in boxes.all.iter_mut().zip(self.tree.order().get(run).unwrap_or_default()) {
            *to = (f, bounds((self.corners)(f)).unwrap_or_default());
            boxes.count += 1;
        }
        boxes
    }
}

struct Boxes {
    all: [(u32, Bounds); LEAF],
    count: usize,
}

impl std::ops::Deref for Boxes {
    type Target = [(u32, Bounds)];

    fn deref(&self) -> &Self::Target {
        &self.all[..self.count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::add;
    use crate::geometry::{MeshDistance, TriangleMesh};
    use crate::random::Lcg;
    use std::collections::BTreeMap;

    struct Seen;

    impl Gather for Seen {
        type Found = Vec<(u32, u32)>;

        fn begin(&self) -> Self::Found {
            Vec::new()
        }

        fn pair(&self, found: &mut Self::Found, f: u32, g: u32) {
            found.push((f, g));
        }

        fn join(&self, mut found: Self::Found, later: Self::Found) -> Self::Found {
            found.extend(later);
            found
        }
    }

    #[test]
    fn every_pair_of_near_boxes_is_visited_once() {
        let mut random = Lcg(17);
        let facets: Vec<[Vec3; 3]> = (0..300)
            .map(|_| {
                let base = random.point(-3.0, 3.0);
                [0; 3].map(|_| add(base, random.point(-0.5, 0.5)))
            })
            .collect();
        for count in [0, 1, 3, 9, 300] {
            let tree = MeshDistance::new(&TriangleMesh::weld(facets[..count].to_vec()));
            for tolerance in [0.0, 0.2] {
                let mut seen: BTreeMap<(u32, u32), usize> = BTreeMap::new();
                for pair in near_pairs(tree.tree(), |f| tree.corners(f), tolerance, &Seen) {
                    *seen.entry(pair).or_default() += 1;
                }
                let of = |f: u32| bounds(tree.corners(f)).unwrap();
                let near = |f: u32, g: u32| {
                    let (a, b) = (of(f), of(g));
                    (0..3).all(|i| a.0[i] <= b.1[i] + tolerance && b.0[i] <= a.1[i] + tolerance)
                };
                let last = count as u32;
                let pairs = (0..last).flat_map(|f| (f + 1..last).map(move |g| (f, g))).filter(|&(f, g)| near(f, g));
                assert_eq!(seen, pairs.map(|pair| (pair, 1)).collect());
            }
        }
    }
}
