//! The boxes of a tree four at a time, for the nearest of all.

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
                let mut at = depth;
                while at > first && waiting[at - 1].0 < far {
                    waiting[at] = waiting[at - 1];
                    at -= 1;
                }
                waiting[at] = (far, child);
                depth += 1;
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

fn rounded_up(squared: f64) -> f32 {
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

impl Four {
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
