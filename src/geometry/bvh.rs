//! A tree of boxes over primitives, each box with a cone that holds the primitives' normals.

use super::vector::{Vec3, add, angle, dot, unit};
use rayon::prelude::*;

/// Primitives in a leaf.
const LEAF: usize = 4;

/// What the tree needs to know of a primitive.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    pub lo: Vec3,
    pub hi: Vec3,
    /// Axis and half-angle (radians) of a cone that holds every normal of the primitive.
    pub axis: Vec3,
    pub spread: f64,
}

/// One node: a box, a cone of normals, and its two children or its run of primitives.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    lo: [f32; 3],
    hi: [f32; 3],
    axis: [f32; 3],
    spread: f32,
    /// Sine and cosine of the half-angle.
    turn: [f32; 2],
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
    pub fn run(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Squared distance from a point to the box, a lower bound for everything inside it.
    #[inline]
    pub fn distance2(&self, p: Vec3) -> f64 {
        (0..3).map(|a| (f64::from(self.lo[a]) - p[a]).max(p[a] - f64::from(self.hi[a])).max(0.0)).map(|d| d * d).sum()
    }

    /// Squared distance between the boxes, a lower bound for everything inside them.
    #[inline]
    pub fn box_distance2(&self, lo: Vec3, hi: Vec3) -> f64 {
        (0..3).map(|a| (f64::from(self.lo[a]) - hi[a]).max(lo[a] - f64::from(self.hi[a])).max(0.0)).map(|d| d * d).sum()
    }

    /// The box in f64.
    pub fn extent(&self) -> (Vec3, Vec3) {
        (self.lo.map(f64::from), self.hi.map(f64::from))
    }

    /// Whether the cone may hold a normal at an angle of at least `least` to the unit vector `direction`.
    ///
    /// `least` comes as (sine, cosine, value) so that no angle is computed in the walk; rounding only lets more through.
    #[inline]
    pub fn may_turn_from(&self, direction: Vec3, (sin, cos, least): (f64, f64, f64)) -> bool {
        let spread = f64::from(self.spread);
        if spread >= least {
            return true;
        }
        // angle(direction, axis) ≥ least − spread
        let bound = cos * f64::from(self.turn[1]) + sin * f64::from(self.turn[0]);
        dot(direction, self.axis.map(f64::from)) <= bound + 1e-5
    }

    /// Whether a ray `p + s·d`, `0 ≤ s ≤ far`, may meet the box; `inverse` is 1/d per axis.
    #[inline]
    fn meets_ray(&self, p: Vec3, inverse: Vec3, far: f64) -> bool {
        let (mut enter, mut leave) = (0.0f64, far);
        for a in 0..3 {
            let (s, t) = ((f64::from(self.lo[a]) - p[a]) * inverse[a], (f64::from(self.hi[a]) - p[a]) * inverse[a]);
            // `min`/`max` drop a NaN from 0·∞, which leaves the slab open.
            enter = enter.max(s.min(t));
            leave = leave.min(s.max(t));
        }
        enter <= leave
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

    /// Calls `visit(primitive, best)` for primitives in boxes nearer than the best distance so far to `p`,
    /// nearest boxes first; `visit` returns the new best squared distance.
    #[inline]
    pub fn nearest(&self, p: Vec3, mut best2: f64, mut visit: impl FnMut(u32, f64) -> f64) -> f64 {
        let mut stack = [(0usize, 0.0f64); 96];
        let mut depth = 0;
        if let Some(root) = self.nodes.first() {
            stack[0] = (0, root.distance2(p));
            depth = 1;
        }
        while depth > 0 {
            depth -= 1;
            let (at, d2) = stack[depth];
            if d2 >= best2 {
                continue;
            }
            let node = &self.nodes[at];
            match node.children() {
                Some([l, r]) => {
                    let (dl, dr) = (self.nodes[l].distance2(p), self.nodes[r].distance2(p));
                    let (near, far) = if dl <= dr { ((l, dl), (r, dr)) } else { ((r, dr), (l, dl)) };
                    for child in [far, near] {
                        if child.1 < best2 && depth < stack.len() {
                            stack[depth] = child;
                            depth += 1;
                        }
                    }
                }
                None => {
                    for &primitive in &self.order[node.run()] {
                        best2 = visit(primitive, best2);
                    }
                }
            }
        }
        best2
    }

    /// Calls `visit(primitive, ball)` for primitives in boxes that meet an open ball given by centre and radius, nearest boxes
    /// first; `visit` returns the ball to go on with, which has to lie in the one before.
    #[inline]
    pub fn in_shrinking_ball(&self, mut ball: (Vec3, f64), mut visit: impl FnMut(u32, (Vec3, f64)) -> (Vec3, f64)) {
        let mut stack = [0usize; 96];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[stack[depth]];
            if node.distance2(ball.0) >= ball.1 * ball.1 {
                continue;
            }
            match node.children() {
                Some([l, r]) => {
                    let (dl, dr) = (self.nodes[l].distance2(ball.0), self.nodes[r].distance2(ball.0));
                    let (near, far) = if dl <= dr { (l, r) } else { (r, l) };
                    for child in [far, near] {
                        if depth < stack.len() {
                            stack[depth] = child;
                            depth += 1;
                        }
                    }
                }
                None => {
                    for &primitive in &self.order[node.run()] {
                        ball = visit(primitive, ball);
                    }
                }
            }
        }
    }

    /// Calls `visit(primitive)` for every primitive whose box may meet the segment `p + s·d`, `0 ≤ s ≤ far`;
    /// `visit` returns the new `far`.
    pub fn along_ray(&self, p: Vec3, d: Vec3, mut far: f64, mut visit: impl FnMut(u32, f64) -> f64) {
        let inverse = d.map(|x| 1.0 / x);
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            let Some(node) = self.nodes.get(at) else { continue };
            if !node.meets_ray(p, inverse, far) {
                continue;
            }
            match node.children() {
                Some([l, r]) => stack.extend([r, l]),
                None => {
                    for &primitive in &self.order[node.run()] {
                        far = visit(primitive, far);
                    }
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
    let centre = |i: u32, a: usize| bounds[i as usize].lo[a] + bounds[i as usize].hi[a];
    let (lo, hi) = order.iter().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(lo, hi), &i| {
        ([0, 1, 2].map(|a| centre(i, a).min(lo[a])), [0, 1, 2].map(|a| centre(i, a).max(hi[a])))
    });
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
    let (axis, spread) =
        joined_cone((l.axis.map(f64::from), f64::from(l.spread)), (r.axis.map(f64::from), f64::from(r.spread)));
    Node {
        lo: [0, 1, 2].map(|a| l.lo[a].min(r.lo[a])),
        hi: [0, 1, 2].map(|a| l.hi[a].max(r.hi[a])),
        axis: axis.map(|x| x as f32),
        spread: spread as f32 + 1e-6,
        turn: turn(spread),
        first: number as u32,
        count: 0,
    }
}

fn leaf(bounds: &[Bounds], order: &[u32], offset: usize) -> Node {
    let mut lo = [f64::INFINITY; 3];
    let mut hi = [f64::NEG_INFINITY; 3];
    let mut cone: Option<(Vec3, f64)> = None;
    for &i in order {
        let b = &bounds[i as usize];
        lo = [0, 1, 2].map(|a| lo[a].min(b.lo[a]));
        hi = [0, 1, 2].map(|a| hi[a].max(b.hi[a]));
        cone = Some(cone.map_or((b.axis, b.spread), |c| joined_cone(c, (b.axis, b.spread))));
    }
    let (axis, spread) = cone.unwrap_or(([0.0; 3], std::f64::consts::PI));
    Node {
        lo: lo.map(|x| (x as f32).next_down()),
        hi: hi.map(|x| (x as f32).next_up()),
        axis: axis.map(|x| x as f32),
        spread: spread as f32 + 1e-6,
        turn: turn(spread),
        first: offset as u32,
        count: order.len() as u32,
    }
}

fn turn(spread: f64) -> [f32; 2] {
    let (sin, cos) = (spread + 1e-6).sin_cos();
    [sin as f32, cos as f32]
}

/// A cone that holds both cones.
fn joined_cone(a: (Vec3, f64), b: (Vec3, f64)) -> (Vec3, f64) {
    let between = angle(a.0, b.0);
    if a.1 >= std::f64::consts::PI || b.1 >= std::f64::consts::PI || between + a.1.max(b.1) > 3.0 {
        return ([0.0, 0.0, 1.0], std::f64::consts::PI);
    }
    if between + b.1 <= a.1 {
        return a;
    }
    if between + a.1 <= b.1 {
        return b;
    }
    let axis = unit(add(a.0, b.0));
    if dot(axis, axis) == 0.0 {
        return ([0.0, 0.0, 1.0], std::f64::consts::PI);
    }
    (axis, (angle(axis, a.0) + a.1).max(angle(axis, b.0) + b.1))
}

/// Bounds of many primitives, computed on all cores.
pub fn bounds_of(count: usize, of: impl Fn(usize) -> Bounds + Sync + Send) -> Vec<Bounds> {
    (0..count).into_par_iter().map(of).collect()
}
