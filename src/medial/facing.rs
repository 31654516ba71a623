//! A tree of the features by where they lie and which way they face, eight at a time: what opposes a patch, nearest first.

use super::feature::Feature;
use super::reach::Slabs;
use crate::geometry::bvh::{Bvh, bounds_of};
use crate::geometry::vector::{Vec3, add, angle, bounds, hull, unit};
use crate::geometry::wide::{rounded_up, wait_in_turn};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Range;

/// Boxes and cones that are compared at once.
const LANES: usize = 8;

/// What waits to be opened, at most: seven more for each step down, of which eleven lead to any of 2³¹ features.
const WAITING: usize = 96;

/// What rounding to f32 may add to the cosine of an angle between directions: some fifty steps.
const ROUNDING_TURN: f32 = 1e-5;

/// A child that is a feature has this bit.
const IS_FEATURE: u32 = 1 << 31;

/// No child.
const NONE: u32 = u32::MAX;

/// Eight boxes, each with a cone that holds the directions of what is in it.
#[derive(Debug, Clone, Copy)]
struct Eight {
    lo: [[f32; LANES]; 3],
    hi: [[f32; LANES]; 3],
    axis: [[f32; LANES]; 3],
    /// Half-angles of the cones, their sines and their cosines.
    spread: [f32; LANES],
    sin: [f32; LANES],
    cos: [f32; LANES],
    child: [u32; LANES],
}

/// The tree: the root is first.
#[derive(Debug, Clone, Default)]
pub struct Facing {
    nodes: Vec<Eight>,
    order: Vec<u32>,
}

/// What the tree is asked: which features lie near a patch, in its reach and at a wide angle to it.
pub(super) struct Query {
    low: [f32; 3],
    high: [f32; 3],
    axis: [f32; 3],
    sin: f32,
    cos: f32,
    least: f32,
    slabs: Slabs,
}

/// What is done with a feature that may oppose a patch.
///
/// A trait, because a method can be told to be compiled for the same vectors as the search, and a closure cannot.
pub(super) trait Visit {
    /// Takes a feature and the squared distance up to which features are visited, and returns what that is from now on.
    fn visit(&mut self, feature: u32, best2: f64) -> f64;
}

impl Query {
    /// A patch by its box and its axis, the least angle to that at which anything counts, and its reach.
    pub(super) fn new((lo, hi): (Vec3, Vec3), axis: Vec3, least: f64, slabs: Slabs) -> Self {
        let (sin, cos) = least.sin_cos();
        Query {
            low: lo.map(|x| (x as f32).next_down()),
            high: hi.map(|x| (x as f32).next_up()),
            axis: axis.map(|x| x as f32),
            sin: sin as f32,
            cos: cos as f32,
            least: (least as f32).next_down(),
            slabs,
        }
    }
}

impl Facing {
    /// The tree over features.
    ///
    /// # Cost
    /// As [`Bvh::new`], and an angle for each feature, on all cores; some 70 bytes a feature.
    pub(super) fn of(features: &[Feature]) -> Self {
        let tree = Bvh::new(&bounds_of(features.len(), |i| bounds(features[i].corners).unwrap_or_default()));
        let mut below = Vec::new();
        if !tree.nodes().is_empty() {
            plan(&tree, 0, &mut below);
        }
        let over = |run: &Range<usize>| {
            let of = |&i: &u32| (IS_FEATURE | i, Extent::of(&features[i as usize]));
            Eight::over(&tree.order()[run.clone()].iter().map(of).collect::<Vec<_>>())
        };
        let leaves = below.par_iter().map(|b| match b {
            Below::Features(run) => Some(over(run)),
            Below::Nodes(_) => None,
        });
        let mut known: Vec<Option<(Eight, Extent)>> = leaves.collect();
        // Every node stands before what is below it.
        for at in (0..below.len()).rev() {
            if let Below::Nodes(children) = &below[at] {
                let of = |&child: &u32| known[child as usize].map(|(_, extent)| (child, extent));
                known[at] = Some(Eight::over(&children.iter().filter_map(of).collect::<Vec<_>>()));
            }
        }
        let nodes = known.into_iter().flatten().map(|(eight, _)| eight).collect();
        Facing { nodes, order: tree.into_order() }
    }

    /// The features in the order of the leaves: work done in this order has its neighbours at hand.
    pub(super) fn order(&self) -> &[u32] {
        &self.order
    }

    /// The box over all features.
    pub(super) fn extent(&self) -> Option<([f32; 3], [f32; 3])> {
        let root = self.nodes.first()?;
        let used = || (0..LANES).filter(|&lane| root.child[lane] != NONE);
        Some((
            [0, 1, 2].map(|a| used().map(|lane| root.lo[a][lane]).fold(f32::INFINITY, f32::min)),
            [0, 1, 2].map(|a| used().map(|lane| root.hi[a][lane]).fold(f32::NEG_INFINITY, f32::max)),
        ))
    }

    /// Visits the features that may lie in the reach, face the patch and be no farther than √`best2`,
    /// the nearest boxes first. What is left out is certain not to. `first` is visited before all.
    ///
    /// # Cost
    /// For each node opened three dozen operations in f32 on eight boxes at once.
    #[inline(always)]
    pub(super) fn opposing(&self, query: &Query, (mut best2, first): (f64, Option<u32>), to: &mut impl Visit) {
        let mut squared = rounded_up(best2);
        let mut waiting = [(0f32, 0u32); WAITING];
        let mut depth = usize::from(!self.nodes.is_empty());
        if let Some(feature) = first {
            waiting[depth] = (0.0, IS_FEATURE | feature);
            depth += 1;
        }
        while depth > 0 {
            depth -= 1;
            let (far, child) = waiting[depth];
            if far > squared {
                continue;
            }
            if child & IS_FEATURE != 0 {
                best2 = to.visit(child & !IS_FEATURE, best2);
                squared = rounded_up(best2);
                continue;
            }
            let eight = &self.nodes[child as usize];
            let (mut near, far) = eight.near(query, squared);
            let lowest = depth;
            while near != 0 {
                let lane = near.trailing_zeros() as usize;
                near &= near - 1;
                let (far, child) = (far[lane], eight.child[lane]);
                if child == NONE || !query.slabs.may_meet(eight.box_of(lane)) {
                    continue;
                }
                wait_in_turn(&mut waiting, lowest..depth, (far, child));
                depth += 1;
            }
        }
    }
}

/// What is below a node of the tree.
enum Below {
    /// A run of features in the order of the tree.
    Features(Range<usize>),
    Nodes(Vec<u32>),
}

/// Plans the nodes below one of a binary tree, of which every three levels become one; returns its number.
fn plan(tree: &Bvh, node: usize, below: &mut Vec<Below>) -> u32 {
    let (number, run) = (below.len(), tree.span(node));
    if run.len() <= LANES {
        below.push(Below::Features(run));
        return number as u32;
    }
    below.push(Below::Nodes(Vec::new()));
    let mut lanes = vec![node];
    for _ in 0..LANES.ilog2() {
        let open = |&n: &usize| tree.nodes()[n].children().filter(|_| tree.span(n).len() > LANES);
        lanes = lanes.iter().flat_map(|n| open(n).map_or(vec![*n], |c| c.to_vec())).collect();
    }
    let children = lanes.into_iter().map(|n| plan(tree, n, below)).collect();
    below[number] = Below::Nodes(children);
    number as u32
}

/// A box and a cone of directions.
#[derive(Debug, Clone, Copy)]
struct Extent {
    sides: (Vec3, Vec3),
    axis: Vec3,
    /// Half-angle of the cone, radians; π holds all directions.
    spread: f64,
}

impl Extent {
    fn of(feature: &Feature) -> Self {
        let sides = bounds(feature.corners).unwrap_or_default();
        Extent { sides, axis: feature.axis, spread: feature.spread + feature.slack }
    }

    /// What holds all of some extents.
    fn over(all: &[(u32, Extent)]) -> Self {
        let axis = unit(all.iter().fold([0.0; 3], |sum, (_, e)| add(sum, e.axis)));
        let spread = all.iter().map(|(_, e)| angle(axis, e.axis) + e.spread).fold(0.0, f64::max);
        let spread = if axis == [0.0; 3] { PI } else { spread.min(PI) };
        let far = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        Extent { sides: all.iter().fold(far, |sides, (_, e)| hull(sides, e.sides)), axis, spread }
    }
}

impl Eight {
    /// The node over at most eight children, and what holds them all.
    fn over(children: &[(u32, Extent)]) -> (Self, Extent) {
        let (far, zero) = ([[f32::INFINITY; LANES]; 3], [0.0; LANES]);
        let child = [NONE; LANES];
        let mut eight = Eight { lo: far, hi: far, axis: [zero; 3], spread: zero, sin: zero, cos: zero, child };
        for (lane, (child, extent)) in children.iter().take(LANES).enumerate() {
            let spread = extent.spread + 1e-6;
            for a in 0..3 {
                eight.lo[a][lane] = (extent.sides.0[a] as f32).next_down();
                eight.hi[a][lane] = (extent.sides.1[a] as f32).next_up();
                eight.axis[a][lane] = extent.axis[a] as f32;
            }
            (eight.sin[lane], eight.cos[lane]) = (spread.sin() as f32, spread.cos() as f32);
            (eight.spread[lane], eight.child[lane]) = ((spread as f32).next_up(), *child);
        }
        (eight, Extent::over(children))
    }

    fn box_of(&self, lane: usize) -> ([f32; 3], [f32; 3]) {
        ([0, 1, 2].map(|a| self.lo[a][lane]), [0, 1, 2].map(|a| self.hi[a][lane]))
    }

    /// A bit for each box that may be near enough and hold a direction far enough from the patch's, and the squared
    /// distances of all.
    ///
    /// A direction in a cone of half-angle s about an axis can be at an angle of `least` to another if that is at
    /// least − s or more to the axis: no angle is computed.
    #[inline(always)]
    fn near(&self, q: &Query, squared: f32) -> (u32, [f32; LANES]) {
        let (mut near, mut far) = (0u32, [0f32; LANES]);
        for (lane, far) in far.iter_mut().enumerate() {
            let (mut d2, mut turn) = (0f32, 0f32);
            for a in 0..3 {
                let (below, above) = (self.lo[a][lane] - q.high[a], q.low[a] - self.hi[a][lane]);
                // Comparisons, which a processor has for all lanes at once.
                let outside = if below > above { below } else { above };
                let gap = if outside > 0.0 { outside } else { 0.0 };
                d2 += gap * gap;
                turn += q.axis[a] * self.axis[a][lane];
            }
            let most = q.cos * self.cos[lane] + q.sin * self.sin[lane] + ROUNDING_TURN;
            let faces = (turn <= most) | (self.spread[lane] >= q.least);
            near |= u32::from((d2 <= squared) & faces) << lane;
            *far = d2;
        }
        (near, far)
    }
}

#[cfg(test)]
mod tests {
    use super::super::chord::Patch;
    use super::super::reach::Reach;
    use super::*;
    use crate::geometry::vector::{dot, norm2, sub};
    use crate::random::Lcg;

    /// Notes what is visited.
    struct Noted<'a>(&'a mut [bool]);

    impl Visit for Noted<'_> {
        fn visit(&mut self, feature: u32, best2: f64) -> f64 {
            self.0[feature as usize] = true;
            best2
        }
    }

    /// Keeps the feature of the least known distance.
    struct Nearest {
        far2: Vec<f64>,
        visits: usize,
        best: Option<u32>,
    }

    impl Visit for Nearest {
        fn visit(&mut self, feature: u32, best2: f64) -> f64 {
            self.visits += 1;
            let d2 = self.far2[feature as usize];
            if d2 < best2 {
                self.best = Some(feature);
            }
            d2.min(best2)
        }
    }

    #[test]
    fn nothing_that_opposes_a_patch_is_left_out() {
        let mut random = Lcg(21);
        let some = |random: &mut Lcg, n: u64| {
            let base = random.point(-9.0, 9.0);
            let corners = [0; 3].map(|_| add(base, random.point(-0.3, 0.3)));
            let axis = unit(random.point(-1.0, 1.0));
            let (spread, slack) = ([0.0, 0.6, 1.4][n as usize % 3], 0.08 * random.unit());
            Feature { corners, axis, spread, slack, arc: [axis; 2], facet: 0, beside: 0 }
        };
        for count in [0, 1, 7, 8, 9, 64, 700] {
            let features: Vec<Feature> = (0..count).map(|n| some(&mut random, n)).collect();
            let tree = Facing::of(&features);
            let mut order = tree.order().to_vec();
            order.sort_unstable();
            assert!(order.iter().copied().eq(0..count as u32));
            let Some(extent) = tree.extent() else {
                assert_eq!(count, 0);
                continue;
            };
            let mut passed_over = 0;
            for n in 0..300 {
                let patch = Patch::from(&some(&mut random, n));
                let (reach, within2) = (Reach::new(&patch), 36.0 * random.unit());
                let sides = bounds(patch.corners).unwrap_or_default();
                let query = Query::new(sides, patch.axis, 2.6 - patch.spread, Slabs::new(&reach, extent));
                let mut visited = vec![false; features.len()];
                tree.opposing(&query, (within2, None), &mut Noted(&mut visited));
                for (f, visited) in features.iter().zip(visited) {
                    let (lo, hi) = bounds(f.corners).unwrap_or_default();
                    let gap = |a: usize| (lo[a] - sides.1[a]).max(sides.0[a] - hi[a]).max(0.0);
                    let near = norm2([gap(0), gap(1), gap(2)]) <= within2;
                    let turned = angle(f.axis, patch.axis) + f.spread + f.slack >= 2.6 - patch.spread;
                    let opposes = near && turned && reach.meets_corners(&f.corners);
                    assert!(visited || !opposes, "{f:?} {patch:?}");
                    passed_over += u64::from(!visited);
                }
            }
            assert!(passed_over > 250 * count, "{passed_over} of {}", 300 * count);
        }
    }

    #[test]
    fn a_nearer_bound_found_on_the_way_ends_the_search() {
        let mut random = Lcg(22);
        let features: Vec<Feature> = (0..4000)
            .map(|_| {
                let at = random.point(-9.0, 9.0);
                let axis = [0.0, 0.0, 1.0];
                Feature { corners: [at; 3], axis, spread: 0.0, slack: 0.0, arc: [axis; 2], facet: 0, beside: 0 }
            })
            .collect();
        let tree = Facing::of(&features);
        let axis = [0.0, 0.0, -1.0];
        let patch = Patch { corners: [[0.0, 0.0, -9.0]; 3], axis, spread: 0.0, slack: 0.0, whole: [[0.0; 3]; 3] };
        let query = Query::new(([0.0, 0.0, -9.0], [0.0, 0.0, -9.0]), axis, 2.6, {
            Slabs::new(&Reach::new(&patch), tree.extent().expect("features"))
        });
        let far2 = |f: &Feature| norm2(sub(f.corners[0], patch.corners[0]));
        let mut nearest = Nearest { far2: features.iter().map(far2).collect(), visits: 0, best: None };
        tree.opposing(&query, (f64::INFINITY, Some(7)), &mut nearest);
        let Nearest { visits, best, .. } = nearest;
        let reach = Reach::new(&patch);
        let within = features.iter().filter(|f| dot(f.axis, axis) < -0.9 && reach.holds(f.corners[0]));
        let least = within.map(far2).fold(f64::INFINITY, f64::min);
        assert!(best.is_some_and(|b| far2(&features[b as usize]) <= least));
        assert!(visits < 20, "{visits}");
    }
}
