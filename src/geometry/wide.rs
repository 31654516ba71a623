//! The boxes of a tree four at a time, for the nearest of all and for rays.

use super::bvh::Node;
use super::vector::Vec3;
use std::ops::Range;

/// Boxes that are compared at once.
const LANES: usize = 4;

/// Boxes that wait to be opened, at most: three for each step down, of which there are half as many as a binary tree of 2²⁹
/// primitives is deep.
const WAITING: usize = 64;

/// What rounding to f32 may add to a squared distance, relative to it.
const ROUNDING: f32 = 1e-6;

/// One over the components of a direction is no greater for the bounds in f32.
const STEEPEST: f64 = 1e30;
/// A start on the very side of a box lies at least this far within it: times [`STEEPEST`] that is beyond all parts.
const ASIDE: f32 = 1e-20;

/// A child that is a leaf has this bit, its number of primitives less one, and where they start.
const IS_LEAF: u32 = 1 << 31;
const COUNT_AT: u32 = 29;

/// No child.
const NONE: u32 = u32::MAX;

/// Four boxes and what is in them; no box is infinitely far.
#[derive(Debug, Clone, Copy)]
struct Four {
    lo: [[f32; LANES]; 3],
    hi: [[f32; LANES]; 3],
    child: [u32; LANES],
}

/// A tree of boxes whose every second level is left out.
#[derive(Debug, Clone, Default)]
pub struct Wide {
    nodes: Vec<Four>,
}

impl Wide {
    /// The tree over the same leaves as a binary one of at most 2²⁹ primitives, whose root is first.
    pub fn over(nodes: &[Node]) -> Self {
        let mut wide = Wide { nodes: Vec::with_capacity(nodes.len() / 3 + 1) };
        if let Some(root) = nodes.first() {
            // A lone leaf is a child like any other.
            wide.add(nodes, root.children().map_or(vec![0], |children| children.to_vec()));
        }
        wide
    }

    /// Adds a node over the children of some nodes, or the nodes themselves where they are leaves; returns its number.
    fn add(&mut self, nodes: &[Node], above: Vec<usize>) -> u32 {
        let at = self.nodes.len();
        let far = [[f32::INFINITY; LANES]; 3];
        self.nodes.push(Four { lo: far, hi: far, child: [NONE; LANES] });
        let below = above.into_iter().flat_map(|n| nodes[n].children().map_or(vec![n], |c| c.to_vec()));
        for (lane, n) in below.take(LANES).enumerate() {
            let child = match nodes[n].children() {
                Some(children) => self.add(nodes, children.to_vec()),
                None => leaf(nodes[n].run()),
            };
            let (lo, hi) = nodes[n].box_f32();
            let four = &mut self.nodes[at];
            for a in 0..3 {
                (four.lo[a][lane], four.hi[a][lane]) = (lo[a], hi[a]);
            }
            four.child[lane] = child;
        }
        at as u32
    }

    /// Calls `visit(run, best)` for the runs of primitives in leaves whose boxes are no farther from `p` than the best so
    /// far, of four boxes the nearest first; `visit` returns the new best squared distance.
    ///
    /// # Cost
    /// Six subtractions in f32 for each of four boxes in a box opened.
    #[inline]
    pub fn nearest(&self, p: Vec3, mut best2: f64, mut visit: impl FnMut(Range<usize>, f64) -> f64) {
        let mut query = Query::of(p, best2);
        let mut waiting = [(0f32, 0u32); WAITING];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let (far, child) = waiting[depth];
            if far > query.squared {
                continue;
            }
            if child & IS_LEAF != 0 {
                let found = visit(run(child), best2);
                if found != best2 {
                    (best2, query.squared) = (found, rounded_up(found));
                }
                continue;
            }
            let four = &self.nodes[child as usize];
            let (far, first) = (four.squared_distances(&query), depth);
            let met = |&(&far, &child): &(&f32, &u32)| far <= query.squared && child != NONE;
            for (&far, &child) in far.iter().zip(&four.child).filter(met) {
                wait_in_turn(&mut waiting, first..depth, (far, child));
                depth += 1;
            }
        }
    }

    /// Calls `visit(run, far)` for the runs of primitives in leaves whose boxes may meet the segment `p + s·d`, `0 ≤ s ≤ far`,
    /// in the order of the tree; `visit` returns the new `far`.
    ///
    /// # Cost
    /// Six subtractions and products in f32 for each of four boxes in a box opened.
    #[inline]
    pub fn along_ray(&self, p: Vec3, d: Vec3, mut far: f64, mut visit: impl FnMut(Range<usize>, f64) -> f64) {
        let ray = BoxRay::of(p, d);
        // Four times the number of the node, and the lane.
        let mut waiting = [0usize; WAITING];
        let mut depth = 0;
        let open = |node: usize, far: f64, waiting: &mut [usize; WAITING], depth: &mut usize| {
            let Some(four) = self.nodes.get(node) else { return };
            let meets = four.may_meet(&ray, rounded_up(far));
            for lane in (0..LANES).rev().filter(|&lane| meets[lane] && four.child[lane] != NONE) {
                waiting[*depth] = LANES * node + lane;
                *depth += 1;
            }
        };
        open(0, far, &mut waiting, &mut depth);
        while depth > 0 {
            depth -= 1;
            let (four, lane) = (&self.nodes[waiting[depth] / LANES], waiting[depth] % LANES);
            let child = four.child[lane];
            if child & IS_LEAF == 0 {
                open(child as usize, far, &mut waiting, &mut depth);
            } else if ray.meets([0, 1, 2].map(|a| [four.lo[a][lane], four.hi[a][lane]]), far) {
                far = visit(run(child), far);
            }
        }
    }
}

fn leaf(run: Range<usize>) -> u32 {
    IS_LEAF | (run.len() as u32 - 1) << COUNT_AT | run.start as u32
}

fn run(leaf: u32) -> Range<usize> {
    let start = (leaf & ((1 << COUNT_AT) - 1)) as usize;
    start..start + ((leaf & !IS_LEAF) >> COUNT_AT) as usize + 1
}

/// Adds what waits to be opened, with its squared distance, to a range that ends with the nearest.
#[inline(always)]
pub fn wait_in_turn(waiting: &mut [(f32, u32)], range: Range<usize>, new: (f32, u32)) {
    let mut at = range.end;
    while at > range.start && waiting[at - 1].0 < new.0 {
        waiting[at] = waiting[at - 1];
        at -= 1;
    }
    waiting[at] = new;
}

/// A squared distance in f32 that is no less, whatever rounding did to those it is compared with.
#[inline]
pub fn rounded_up(squared: f64) -> f32 {
    (squared as f32 * (1.0 + ROUNDING)).next_up()
}

/// A ball in f32: its centre between two numbers along each axis, its squared radius rounded up.
struct Query {
    low: [f32; 3],
    high: [f32; 3],
    squared: f32,
}

impl Query {
    #[inline(always)]
    fn of(centre: Vec3, squared: f64) -> Self {
        let near = centre.map(|x| x as f32);
        Query { low: near.map(f32::next_down), high: near.map(f32::next_up), squared: rounded_up(squared) }
    }
}

/// A ray on its way through boxes, and in f32 two numbers that its start lies between along each axis; `inverse` is 1/d.
struct BoxRay {
    from: Vec3,
    inverse: Vec3,
    low: [f32; 3],
    high: [f32; 3],
    inverse_f32: [f32; 3],
}

impl BoxRay {
    #[inline(always)]
    fn of(from: Vec3, d: Vec3) -> Self {
        let (near, inverse) = (from.map(|x| x as f32), d.map(|x| 1.0 / x));
        // Never infinite: nothing times that is no number.
        let inverse_f32 = inverse.map(|x| x.clamp(-STEEPEST, STEEPEST) as f32);
        let (low, high) = (near.map(|x| x.next_down() - ASIDE), near.map(|x| x.next_up() + ASIDE));
        BoxRay { from, inverse, low, high, inverse_f32 }
    }

    /// Whether the ray meets a box before it is `far`.
    #[inline]
    fn meets(&self, sides: [[f32; 2]; 3], far: f64) -> bool {
        let (mut enter, mut leave) = (0.0f64, far);
        for (a, side) in sides.into_iter().enumerate() {
            let [s, t] = side.map(|x| (f64::from(x) - self.from[a]) * self.inverse[a]);
            // `min`/`max` drop a NaN from 0·∞, which leaves the slab open.
            enter = enter.max(s.min(t));
            leave = leave.min(s.max(t));
        }
        // What is seen through two boxes' edges meets one of them: the bounds are rounded.
        enter <= leave * (1.0 + 8.0 * f64::EPSILON)
    }
}

impl Four {
    /// Whether each box may be met by a ray before it is `far`; `false` is certain.
    #[inline(always)]
    fn may_meet(&self, ray: &BoxRay, far: f32) -> [bool; LANES] {
        let mut out = [false; LANES];
        for (lane, out) in out.iter_mut().enumerate() {
            let (mut enter, mut leave) = (0f32, far);
            for a in 0..3 {
                let s = (self.lo[a][lane] - ray.high[a]) * ray.inverse_f32[a];
                let t = (self.hi[a][lane] - ray.low[a]) * ray.inverse_f32[a];
                let (least, most) = if s < t { (s, t) } else { (t, s) };
                enter = if least > enter { least } else { enter };
                leave = if most < leave { most } else { leave };
            }
            *out = enter <= leave * (1.0 + ROUNDING);
        }
        out
    }

    #[inline(always)]
    fn squared_distances(&self, q: &Query) -> [f32; LANES] {
        let mut out = [0f32; LANES];
        for (lane, out) in out.iter_mut().enumerate() {
            for a in 0..3 {
                let (below, above) = (self.lo[a][lane] - q.high[a], q.low[a] - self.hi[a][lane]);
                // Comparisons, which a processor has for all lanes at once.
                let outside = if below > above { below } else { above };
                let gap = if outside > 0.0 { outside } else { 0.0 };
                *out += gap * gap;
            }
        }
        out
    }
}
