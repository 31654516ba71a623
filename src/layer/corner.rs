//! The corner of a hole or a notch in a region: no one direction has a strand at every place about it.

use super::line::{Side, length};
use super::plan::Plan;
use super::section::Point;
use super::strip::{Known, Strip, Sweep};

impl Plan {
    /// The strands at the places within `reach` of x, where of the region's sides no more than two are `met` and these are free ones of a corner that
    /// points into the region: each place lies on the region's side of one of them, and has a strand along it. `None` elsewhere.
    ///
    /// No place is left out, and beside the middle of either side no other strand passes: the bound is attained.
    ///
    /// # Cost
    /// Two strips.
    pub(super) fn about_corner(&self, x: Point, reach: f64, met: &[(usize, Side)], all: f64) -> Option<Strip> {
        let [(_, a), (_, b)] = met else { return None };
        let (a, b) = if a.to == b.from { (a, b) } else { (b, a) };
        if a.to != b.from || a.anchored || b.anchored || self.before(a, b.to) >= 0.0 {
            return None;
        }
        let (mut sweep, tiny) = (Sweep::default(), self.tiny());
        let mut both = Strip { longest: 0.0, is_whole: true, pairs: 0 };
        for side in [a, b] {
            let long = length(side.from, side.to);
            // The region lies left of it.
            let along = [0, 1].map(|n| self.turn() * (side.to[n] - side.from[n]) / long);
            let off = (side.from[1] - x[1]) * along[0] - (side.from[0] - x[0]) * along[1];
            let from = (off + tiny).max(-reach);
            if from < reach {
                let known = Known { all, some: 0.0 };
                let strip = sweep.between(self.sides(), [x, along], [from, reach], [reach, tiny], known);
                both.longest = both.longest.max(strip.longest);
                both.is_whole &= strip.is_whole;
                both.pairs += strip.pairs;
            }
        }
        Some(both)
    }
}
