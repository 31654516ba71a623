//! A tree of boxes over primitives.

use super::vector::{Vec3, add, greatest, hull, least};
use rayon::prelude::*;
use std::ops::Range;

/// Primitives in a leaf, at most.
pub const LEAF: usize = 4;

/// The box of a primitive, by its least and greatest corner.
pub type Bounds = (Vec3, Vec3);

/// One node: a box, and its two children or its run of primitives.
///
/// The box has a fourth component of 0, so that all are worked on at once.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    lo: [f32; 4],
    hi: [f32; 4],
    first: u32,
    count: u32,
}

impl Node {
    /// The two children, or `None` in a leaf.
    #[inline]
    pub fn children(&self) -> Option<[usize; 2]> {
        (self.count == 0).then_some([self.first as usize, self.first as usize + 1])
    }

    /// The run of [`Bvh::order`] in a leaf.
    #[inline]
    pub fn run(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Squared distance from a point to the box, a lower bound for everything inside it.
    #[inline]
    pub fn distance2(&self, p: Vec3) -> f64 {
        self.box_distance2(p, p)
    }

    /// Squared distance between the boxes, a lower bound for everything inside them.
    #[inline]
    pub fn box_distance2(&self, lo: Vec3, hi: Vec3) -> f64 {
        let (lo, hi) = ([lo[0], lo[1], lo[2], 0.0], [hi[0], hi[1], hi[2], 0.0]);
        let mut d2 = [0.0f64; 4];
        for a in 0..4 {
            let (below, above) = (f64::from(self.lo[a]) - hi[a], lo[a] - f64::from(self.hi[a]));
            // Comparisons, not `max`, which also minds what is not a number: two components in one instruction.
            let gap = if below > above { below } else { above };
            let gap = if gap > 0.0 { gap } else { 0.0 };
            d2[a] = gap * gap;
        }
        d2[0] + d2[1] + d2[2]
    }

    /// The box, rounded outwards.
    #[inline]
    pub fn box_f32(&self) -> ([f32; 3], [f32; 3]) {
        ([self.lo[0], self.lo[1], self.lo[2]], [self.hi[0], self.hi[1], self.hi[2]])
    }

    /// The height of the box in a direction: no point in it is higher.
    #[inline]
    pub fn farthest_corner(&self, d: Vec3) -> f64 {
        let (lo, hi) = self.extent();
        let of = |a: usize| d[a] * if d[a] > 0.0 { hi[a] } else { lo[a] };
        of(0) + of(1) + of(2)
    }

    /// The box in f64.
    #[inline]
    pub fn extent(&self) -> (Vec3, Vec3) {
        (wide(&self.lo), wide(&self.hi))
    }
}

/// A node, and the primitives below it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    node: u32,
    /// Where in [`Bvh::order`] they start.
    pub start: u32,
    count: u32,
}

impl Span {
    /// The run of [`Bvh::order`].
    #[inline]
    pub fn run(&self) -> Range<usize> {
        self.start as usize..(self.start + self.count) as usize
    }

    /// The two halves below a node, the left one first.
    #[inline]
    fn halves(&self, [left, right]: [usize; 2]) -> [Span; 2] {
        let count = self.count / 2;
        [
            Span { node: left as u32, start: self.start, count },
            Span { node: right as u32, start: self.start + count, count: self.count - count },
        ]
    }
}

/// A box to be met, rounded outwards to f32.
#[derive(Debug, Clone, Copy)]
pub struct Reached {
    lo: [f32; 4],
    hi: [f32; 4],
}

impl Reached {
    /// That of a box.
    pub fn of((lo, hi): Bounds) -> Self {
        Reached { lo: narrow(lo, f32::next_down), hi: narrow(hi, f32::next_up) }
    }

    #[inline]
    fn meets(&self, node: &Node) -> bool {
        (0..4).fold(true, |meets, a| meets & (self.lo[a] <= node.hi[a]) & (node.lo[a] <= self.hi[a]))
    }
}

/// A bounding volume hierarchy: median splits, boxes rounded outwards to f32.
///
/// # Cost
/// O(n log n) to build, on all cores; about 20 bytes a primitive.
#[derive(Debug, Clone, Default)]
pub struct Bvh {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Bvh {
    /// The tree over primitives given by their bounds.
    pub fn new(bounds: &[Bounds]) -> Self {
        let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
        let mut nodes = Vec::new();
        if !order.is_empty() {
            nodes.resize(1 + nodes_below(order.len()), leaf(bounds, &[], 0));
            if let [root, below @ ..] = &mut nodes[..] {
                *root = build(bounds, &mut order, 0, (below, 1));
            }
        }
        Bvh { nodes, order }
    }

    /// The same tree with primitive `i` called `names[i]`.
    pub fn renamed(mut self, names: &[u32]) -> Self {
        self.order.iter_mut().for_each(|i| *i = names[*i as usize]);
        self
    }

    /// The nodes; the root is first. Empty for no primitives.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Primitives in the order of the leaves.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The same, and nothing else of the tree.
    pub fn into_order(self) -> Vec<u32> {
        self.order
    }

    /// The run of [`Bvh::order`] below a node.
    ///
    /// # Cost
    /// A step for each level below.
    pub fn span(&self, node: usize) -> Range<usize> {
        let (mut first, mut last) = (node, node);
        while let Some([left, _]) = self.nodes[first].children() {
            first = left;
        }
        while let Some([_, right]) = self.nodes[last].children() {
            last = right;
        }
        self.nodes[first].run().start..self.nodes[last].run().end
    }

    /// The whole tree; `None` if it is empty.
    pub fn whole(&self) -> Option<Span> {
        (!self.order.is_empty()).then_some(Span { node: 0, start: 0, count: self.order.len() as u32 })
    }

    /// The box of what is below a node.
    pub fn extent(&self, span: Span) -> Bounds {
        self.nodes[span.node as usize].extent()
    }

    /// The nodes of at most so many primitives, or leaves, that a part of the tree consists of, from left to right.
    ///
    /// # Cost
    /// O(nodes above them).
    pub fn cut(&self, part: Span, most: usize) -> Vec<Span> {
        let mut found = Vec::new();
        let mut waiting = vec![part];
        while let Some(span) = waiting.pop() {
            match self.nodes[span.node as usize].children() {
                Some(children) if span.count as usize > most => {
                    waiting.extend(span.halves(children).into_iter().rev());
                }
                _ => found.push(span),
            }
        }
        found
    }

    /// Visits those of these nodes whose boxes may meet a box and that do not end before a place of [`Bvh::order`], from right to left.
    ///
    /// # Cost
    /// O(depth + nodes visited).
    #[inline]
    pub fn meeting(&self, part: Span, reached: &Reached, from: u32, most: usize, visit: &mut impl FnMut(Span)) {
        let node = &self.nodes[part.node as usize];
        if part.start + part.count <= from || !reached.meets(node) {
            return;
        }
        match node.children() {
            Some(children) if part.count as usize > most => {
                let [left, right] = part.halves(children);
                self.meeting(right, reached, from, most, visit);
                self.meeting(left, reached, from, most, visit);
            }
            _ => visit(part),
        }
    }

    /// Where each primitive below `count` stands in [`Bvh::order`]; at the end, if it is not in the tree.
    ///
    /// Work done in this order has its neighbours at hand: what it reads is mostly in the cache already.
    pub fn ranks(&self, count: usize) -> Vec<u32> {
        let mut ranks = vec![u32::MAX; count];
        for (rank, &i) in self.order.iter().enumerate() {
            if let Some(at) = ranks.get_mut(i as usize) {
                *at = rank as u32;
            }
        }
        ranks
    }

    /// Visits the items of the leaves whose boxes may overlap a box, by its least and greatest corner.
    ///
    /// # Cost
    /// O(log n + items visited).
    pub fn in_box(&self, reach: (Vec3, Vec3), mut visit: impl FnMut(u32)) {
        self.any_in_box(reach, |item| {
            visit(item);
            false
        });
    }

    /// Whether a predicate holds for an item of a leaf whose box may overlap a box, by its least and greatest corner.
    ///
    /// # Cost
    /// As [`Bvh::in_box`], and nothing after the first for which it holds.
    pub fn any_in_box(&self, reach: (Vec3, Vec3), mut is: impl FnMut(u32) -> bool) -> bool {
        !self.nodes.is_empty() && self.any_below(0, &Reached::of(reach), &mut is)
    }

    fn any_below(&self, node: usize, reached: &Reached, is: &mut impl FnMut(u32) -> bool) -> bool {
        let node = &self.nodes[node];
        reached.meets(node)
            && match node.children() {
                Some([left, right]) => self.any_below(right, reached, is) || self.any_below(left, reached, is),
                None => self.order[node.run()].iter().any(|&item| is(item)),
            }
    }

    /// Calls `visit(run, ball)` for the runs of primitives in leaves that meet an open ball given by centre and radius, nearest boxes
    /// first; `visit` returns the ball to go on with, which has to lie in the one before.
    #[inline]
    pub fn in_shrinking_ball(
        &self,
        mut ball: (Vec3, f64),
        mut visit: impl FnMut(Range<usize>, (Vec3, f64)) -> (Vec3, f64),
    ) {
        // A node, its squared distance, and how often the ball had shrunk by then.
        let mut stack = [(0usize, 0.0f64, 0u32); 64];
        let (mut depth, mut shrunk) = (0, 0u32);
        if let Some(root) = self.nodes.first() {
            stack[0] = (0, root.distance2(ball.0), 0);
            depth = 1;
        }
        while depth > 0 {
            depth -= 1;
            let (at, known, when) = stack[depth];
            let node = &self.nodes[at];
            let d2 = if when == shrunk { known } else { node.distance2(ball.0) };
            if d2 >= ball.1 * ball.1 {
                continue;
            }
            match node.children() {
                Some([l, r]) => {
                    let (dl, dr) = (self.nodes[l].distance2(ball.0), self.nodes[r].distance2(ball.0));
                    let (near, far) = if dl <= dr { ((l, dl), (r, dr)) } else { ((r, dr), (l, dl)) };
                    for (child, d2) in [far, near] {
                        if d2 < ball.1 * ball.1 && depth < stack.len() {
                            stack[depth] = (child, d2, shrunk);
                            depth += 1;
                        }
                    }
                }
                None => {
                    let next = visit(node.run(), ball);
                    shrunk += u32::from(next != ball);
                    ball = next;
                }
            }
        }
    }
}

/// How many nodes a node over `count` primitives has below it.
fn nodes_below(count: usize) -> usize {
    if count <= LEAF { 0 } else { 2 + nodes_below(count / 2) + nodes_below(count - count / 2) }
}

/// The node over `order`, whose runs start at `offset`; the nodes below it go to a place whose first node has a number.
fn build(bounds: &[Bounds], order: &mut [u32], offset: usize, (below, number): (&mut [Node], usize)) -> Node {
    if order.len() <= LEAF {
        return leaf(bounds, order, offset);
    }
    let centre = |i: u32, a: usize| bounds[i as usize].0[a] + bounds[i as usize].1[a];
    let middles = order.iter().map(|&i| add(bounds[i as usize].0, bounds[i as usize].1));
    let (lo, hi) = middles.fold(EMPTY, |(lo, hi), m| (least(m, lo), greatest(m, hi)));
    let axis = (0..3).max_by(|&a, &b| (hi[a] - lo[a]).total_cmp(&(hi[b] - lo[b]))).unwrap_or(0);
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&i, &j| centre(i, axis).total_cmp(&centre(j, axis)).then(i.cmp(&j)));
    let (left, right) = order.split_at_mut(middle);
    // The two children first, then what is below the left one, then what is below the right one.
    let (children, below) = below.split_at_mut(2);
    let (below_l, below_r) = below.split_at_mut(nodes_below(middle));
    let (number_l, number_r) = (number + 2, number + 2 + below_l.len());
    let parallel = left.len() > 2048;
    let mut left = || build(bounds, left, offset, (below_l, number_l));
    let mut right = || build(bounds, right, offset + middle, (below_r, number_r));
    let (l, r) = if parallel { rayon::join(left, right) } else { (left(), right()) };
    (children[0], children[1]) = (l, r);
    let extent = hull(l.extent(), r.extent());
    Node { lo: narrow(extent.0, |x| x), hi: narrow(extent.1, |x| x), first: number as u32, count: 0 }
}

/// The box that holds nothing.
const EMPTY: (Vec3, Vec3) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);

/// The first three components in f64.
#[inline]
fn wide(v: &[f32]) -> Vec3 {
    match v {
        [x, y, z, ..] => [f64::from(*x), f64::from(*y), f64::from(*z)],
        _ => [0.0; 3],
    }
}

/// A corner of a box in f32, rounded further by `round`.
#[inline]
fn narrow(v: Vec3, round: impl Fn(f32) -> f32) -> [f32; 4] {
    [round(v[0] as f32), round(v[1] as f32), round(v[2] as f32), 0.0]
}

fn leaf(bounds: &[Bounds], order: &[u32], offset: usize) -> Node {
    let extent = order.iter().fold(EMPTY, |extent, &i| hull(extent, bounds[i as usize]));
    Node {
        lo: narrow(extent.0, f32::next_down),
        hi: narrow(extent.1, f32::next_up),
        first: offset as u32,
        count: order.len() as u32,
    }
}

/// Bounds of many primitives, computed on all cores.
pub fn bounds_of(count: usize, of: impl Fn(usize) -> Bounds + Sync + Send) -> Vec<Bounds> {
    (0..count).into_par_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Lcg;

    fn boxes(random: &mut Lcg, count: usize) -> Vec<Bounds> {
        let some = |_| {
            let lo = random.point(-9.0, 9.0);
            (lo, add(lo, random.point(0.0, 0.5)))
        };
        (0..count).map(some).collect()
    }

    #[test]
    fn distances_of_boxes_are_those_of_their_components() {
        let mut random = Lcg(13);
        let tree = Bvh::new(&boxes(&mut random, 300));
        for node in tree.nodes() {
            let (from, to) = node.extent();
            let lo = random.point(-9.0, 9.0);
            let hi = add(lo, random.point(0.0, 1.0));
            let gap = |a: usize| (from[a] - hi[a]).max(lo[a] - to[a]).max(0.0);
            assert_eq!(node.box_distance2(lo, hi), (0..3).map(|a| gap(a) * gap(a)).sum::<f64>());
        }
    }

    #[test]
    fn no_primitive_that_a_shrinking_ball_still_meets_is_left_out() {
        let mut random = Lcg(14);
        let bounds = boxes(&mut random, 500);
        let tree = Bvh::new(&bounds);
        for _ in 0..200 {
            let (from, mut ball) = (random.point(-9.0, 9.0), ([0.0; 3], 0.0));
            ball.0 = add(from, [0.0, 0.0, 4.0]);
            ball.1 = 4.0;
            let (mut visited, mut last) = (vec![false; bounds.len()], ball);
            tree.in_shrinking_ball(ball, |run, _| {
                for &i in &tree.order()[run] {
                    visited[i as usize] = true;
                    // Balls that touch at one point lie in each other.
                    let radius = if i % 5 == 0 { 0.9 * last.1 } else { last.1 };
                    last = (add(from, [0.0, 0.0, radius]), radius);
                }
                last
            });
            let away = |b: &Bounds| {
                let gap = |a: usize| (b.0[a] - last.0[a]).max(last.0[a] - b.1[a]).max(0.0);
                (0..3).map(|a| gap(a) * gap(a)).sum::<f64>().sqrt()
            };
            assert!(bounds.iter().zip(visited).all(|(b, seen)| seen || away(b) >= last.1));
        }
    }
}
