//! Shortest ways inside a region to its anchors, round corners where walls stand between.

use super::line::{Side, foot, length};
use super::plan::Plan;
use super::section::Point;
use super::sides::{Nearest, Sides};
use rustc_hash::FxHashMap;
use std::cell::OnceCell;

/// What holds places of a region up, and the shortest ways to it from the region's corners.
#[derive(Debug, Default)]
pub(super) struct Holds {
    /// Anchored sides, or these and strands between them.
    by: Sides,
    ways: OnceCell<Ways>,
}

impl Holds {
    pub fn new(by: Vec<Side>) -> Self {
        Holds { by: Sides::new(by), ways: OnceCell::new() }
    }

    pub fn by(&self) -> &Sides {
        &self.by
    }

    /// The direction square to the hold that is nearest as the crow flies.
    pub fn square(&self, x: Point) -> Option<Point> {
        self.nearest(x).and_then(|n| self.square_to(n.side))
    }

    /// The directions in which a place is likely to lie between two holds: to the nearest as the crow flies, or square to it from a place on it,
    /// and to the nearest on the other side of the place.
    pub fn across(&self, x: Point, tiny: f64) -> impl Iterator<Item = Point> {
        let way = |far: f64, p: Point| [(p[0] - x[0]) / far, (p[1] - x[1]) / far];
        let towards = |n: Nearest| if n.far > tiny { Some(way(n.far, n.at)) } else { self.square_to(n.side) };
        let nearest = self.nearest(x).and_then(towards);
        // Within 60° of straight across: what lies aside is the next wall of a corner.
        let is_opposite =
            |d: Point, far: f64, p: Point| far > tiny && (p[0] - x[0]) * d[0] + (p[1] - x[1]) * d[1] < -0.5 * far;
        let opposite = |d: Point| self.by.nearest(x, |far, p, _| is_opposite(d, far, p)).map(|n| way(n.far, n.at));
        nearest.into_iter().chain(nearest.and_then(opposite))
    }

    /// The nearest hold that has a length.
    fn nearest(&self, x: Point) -> Option<Nearest> {
        self.by.nearest(x, |_, _, s| s.from != s.to)
    }

    /// The direction square to a hold that has a length.
    fn square_to(&self, hold: usize) -> Option<Point> {
        let s = self.by.all().get(hold)?;
        let long = length(s.from, s.to);
        Some([(s.to[1] - s.from[1]) / long, (s.from[0] - s.to[0]) / long])
    }

    fn ways(&self, plan: &Plan) -> &Ways {
        self.ways.get_or_init(|| Ways::of(plan, self))
    }
}

/// How far a place of a region is from what holds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Walk {
    /// The shortest way inside the region is at least this long.
    pub least: f64,
    /// And at most this long; equal to `least` unless there were too many corners to look round.
    pub most: f64,
    /// The place at its end, on what holds.
    pub anchor: Point,
}

/// The shortest ways from the corners of a region.
#[derive(Debug)]
struct Ways {
    corners: Vec<Corner>,
    /// For each side its two corners.
    ends: Vec<[usize; 2]>,
    /// Whether all corners were looked round.
    exact: bool,
}

#[derive(Debug, Clone, Copy)]
struct Corner {
    at: Point,
    /// Length of the shortest way to an anchor, and its end.
    length: f64,
    anchor: Point,
}

/// The nearest candidates that are tried for being seen.
const TRIED: usize = 64;
/// Sides that lines of sight between corners are held against at most, were each held against all.
const EFFORT: usize = 4_000_000;

impl Ways {
    /// Shortest ways from all corners: straight to a hold that is seen, or by way of another corner.
    ///
    /// # Cost
    /// O(corners² + sides·corners); log and the sides near it for each line of sight that may shorten a way, of which there are as many as
    /// would hold 4 million sides against them if each were held against all.
    fn of(plan: &Plan, holds: &Holds) -> Self {
        let sides = plan.sides().all();
        let mut known: FxHashMap<[u64; 2], usize> = FxHashMap::default();
        let mut corners: Vec<Corner> = Vec::new();
        let mut index = |p: Point| {
            *known.entry(p.map(f64::to_bits)).or_insert_with(|| {
                corners.push(Corner { at: p, length: f64::INFINITY, anchor: p });
                corners.len() - 1
            })
        };
        let ends: Vec<[usize; 2]> = sides.iter().map(|s| [index(s.from), index(s.to)]).collect();
        for (_, ends) in sides.iter().zip(&ends).filter(|(s, _)| s.anchored) {
            ends.iter().for_each(|&n| corners[n].length = 0.0);
        }
        let mut ways = Ways { corners, ends, exact: true };
        if !holds.by.all().is_empty() {
            ways.find(plan, holds);
        }
        ways
    }

    /// Dijkstra's search from what holds over the corners.
    fn find(&mut self, plan: &Plan, holds: &Holds) {
        let count = self.corners.len();
        let mut left = EFFORT;
        let mut looks = |from: Point, to: Point| {
            let may = left > 0;
            left = left.saturating_sub(2 * plan.sides().all().len());
            may.then(|| plan.sees(from, to) && plan.holds([0, 1].map(|a| 0.5 * (from[a] + to[a]))))
        };
        for n in 0..count {
            let at = self.corners[n].at;
            if self.corners[n].length == 0.0 {
                continue;
            }
            // Strands end at corners.
            let straight = holds.straight(at);
            let on_one = |w: &Walk| w.most <= 1e-9 * plan.extent();
            if let Some(w) = straight.filter(|w| on_one(w) || looks(at, w.anchor) == Some(true)) {
                self.corners[n] = Corner { at, length: w.most, anchor: w.anchor };
                continue;
            }
            let feet = nearest_of(holds.feet(at).collect());
            match feet.iter().skip(1).find(|f| looks(at, f.1) == Some(true)) {
                Some(&(length, anchor, _)) => self.corners[n] = Corner { at, length, anchor },
                None => self.exact &= holds.by.all().len() <= TRIED,
            }
        }
        let mut beside: Vec<Vec<usize>> = vec![Vec::new(); count];
        for &[a, b] in &self.ends {
            beside[a].push(b);
            beside[b].push(a);
        }
        let mut open: Vec<usize> = (0..count).collect();
        while let Some(place) = (0..open.len())
            .min_by(|&a, &b| self.corners[open[a]].length.total_cmp(&self.corners[open[b]].length))
            .filter(|&p| self.corners[open[p]].length.is_finite())
        {
            let from = open.swap_remove(place);
            let c = self.corners[from];
            let round = self.is_reflex(plan, from);
            for &to in &open {
                let length = c.length + length(c.at, self.corners[to].at);
                if length >= self.corners[to].length {
                    continue;
                }
                if beside[from].contains(&to) || (round && looks(c.at, self.corners[to].at) == Some(true)) {
                    self.corners[to] = Corner { length, anchor: c.anchor, ..self.corners[to] };
                }
            }
        }
        self.exact &= left > 0;
    }

    /// Whether a shortest way may bend at a corner: not where the region has less than half a turn about it.
    fn is_reflex(&self, plan: &Plan, corner: usize) -> bool {
        let sides = || self.ends.iter().zip(plan.sides().all());
        let mut into = sides().filter(|(ends, _)| ends[1] == corner).map(|(_, s)| s);
        let mut out = sides().filter(|(ends, _)| ends[0] == corner).map(|(_, s)| s);
        match (into.next(), out.next(), into.next(), out.next()) {
            (Some(a), Some(b), None, None) => plan.before(a, b.to) <= 0.0,
            _ => true,
        }
    }

    /// The lengths of the shortest ways from a side's ends.
    fn ends_lengths(&self, side: usize) -> [f64; 2] {
        self.ends.get(side).map_or([f64::INFINITY; 2], |ends| ends.map(|n| self.corners[n].length))
    }

    /// The shortest way from a place, straight or by way of a corner, if its first stretch, to a point, may be gone.
    fn shortest(&self, plan: &Plan, holds: &Holds, x: Point, may: impl Fn(Point) -> bool) -> Option<Walk> {
        let near = holds.straight(x)?;
        let round = self.corners.iter().filter(|c| c.length.is_finite());
        let round = round.map(|c| (c.length + length(x, c.at), c.at, c.anchor));
        let ways = nearest_of(holds.feet(x).chain(round).collect());
        let seen = ways.iter().find(|w| plan.sees(x, w.1) && may(w.1));
        Some(match seen {
            Some(&(most, _, anchor)) => Walk { least: if self.exact { most } else { near.least }, most, anchor },
            None => Walk { most: f64::INFINITY, ..near },
        })
    }
}

impl Holds {
    /// The nearest hold, as the crow flies.
    fn straight(&self, x: Point) -> Option<Walk> {
        self.by.nearest(x, |_, _, _| true).map(|n| Walk { least: n.far, most: n.far, anchor: n.at })
    }

    /// The nearest points of all that holds, as ways that end there.
    fn feet(&self, x: Point) -> impl Iterator<Item = (f64, Point, Point)> {
        self.by.all().iter().map(move |s| foot(x, s)).map(move |p| (length(x, p), p, p))
    }
}

/// The shortest ways of those given, as many as are tried, the shortest first and equal ones in their order.
fn nearest_of(ways: Vec<(f64, Point, Point)>) -> Vec<(f64, Point, Point)> {
    let mut ways: Vec<(usize, (f64, Point, Point))> = ways.into_iter().enumerate().collect();
    let shorter = |(n, a): &(usize, (f64, Point, Point)), (m, b): &(usize, (f64, Point, Point))| {
        a.0.total_cmp(&b.0).then(n.cmp(m))
    };
    if ways.len() > TRIED {
        ways.select_nth_unstable_by(TRIED, shorter);
        ways.truncate(TRIED);
    }
    ways.sort_unstable_by(shorter);
    ways.into_iter().map(|(_, way)| way).collect()
}

impl Plan {
    /// How far a place inside the region is from what holds it; `None` if nothing does.
    pub(super) fn walk(&self, x: Point, holds: &Holds) -> Option<Walk> {
        let straight = holds.straight(x).filter(|w| self.sees(x, w.anchor));
        straight.or_else(|| holds.ways(self).shortest(self, holds, x, |_| true))
    }

    /// The longest of the shortest ways from the places of a side within `reach` of x: an upper bound. They go along the side, to
    /// the place nearest to x and on from there, or to one of its ends.
    pub(super) fn walk_along(&self, side: usize, x: Point, reach: f64, holds: &Holds) -> f64 {
        let Some(s) = self.sides().all().get(side) else { return f64::INFINITY };
        if s.anchored {
            return 0.0;
        }
        let nearest = foot(x, s);
        let (whole, middle) = (length(s.from, s.to), length(s.from, nearest));
        let (first, last) = ((middle - reach).max(0.0), (middle + reach).min(whole));
        let [from_a, from_b] = match [s.from, s.to].map(|end| self.straight_inside(end, holds)) {
            [Some(a), Some(b)] => [a.most, b.most],
            _ => holds.ways(self).ends_lengths(side),
        };
        // The farthest place is where the ways to both ends are equally long.
        let even = if from_a.is_finite() && from_b.is_finite() { 0.5 * (whole + from_b - from_a) } else { last };
        let t = even.clamp(first, last);
        let by_ends = (t + from_a).min(whole - t + from_b);
        let round = || holds.ways(self).shortest(self, holds, nearest, |p| self.joins(nearest, p));
        let way = self.straight_inside(nearest, holds).or_else(round);
        by_ends.min(way.map_or(f64::INFINITY, |w| w.most + reach))
    }

    /// The way from a place of the boundary straight to its nearest hold, if it lies inside the region and nothing stands in it.
    fn straight_inside(&self, from: Point, holds: &Holds) -> Option<Walk> {
        holds.straight(from).filter(|w| w.most == 0.0 || (self.sees(from, w.anchor) && self.joins(from, w.anchor)))
    }

    /// Whether the region lies about the middle between two points of its boundary that see each other.
    fn joins(&self, a: Point, b: Point) -> bool {
        self.holds([0, 1].map(|n| 0.5 * (a[n] + b[n])))
    }

    /// Whether the way from a point to one of the boundary crosses no side before, and touches no corner: a way that does is
    /// found by way of the corner.
    fn sees(&self, x: Point, p: Point) -> bool {
        let l = length(x, p);
        if l == 0.0 {
            return true;
        }
        let d = [(p[0] - x[0]) / l, (p[1] - x[1]) / l];
        let across = |q: Point| (q[1] - x[1]) * d[0] - (q[0] - x[0]) * d[1];
        let along = |q: Point| (q[0] - x[0]) * d[0] + (q[1] - x[1]) * d[1];
        let (tiny, end) = (1e-9 * self.extent(), l - 1e-6 * self.extent());
        // Where a side crosses the way, it does so between its ends, to within far less than these ends of the way.
        let mut near = self.sides().in_boxes(move |b| {
            let ([right, left], [back, front]) = (b.across(x, d), b.along(x, d));
            right <= tiny && left >= -tiny && front >= 0.0 && back <= l
        });
        near.all(|(_, s)| {
            let (a, b) = (across(s.from), across(s.to));
            let start = along(s.from);
            let t = start + (along(s.to) - start) * a / (a - b);
            let touches = a.abs() <= tiny && start > tiny && start < end;
            !touches && ((a < 0.0) == (b < 0.0) || t <= tiny || t >= end)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::sides::tests::{place, ragged};
    use super::*;
    use crate::random::Lcg;

    #[test]
    fn what_is_seen_is_what_no_side_of_all_stands_before() {
        let mut rng = Lcg(61);
        let mut seen = [0; 2];
        for case in 0..200 {
            let all = ragged(&mut rng, case);
            let plan = Plan::new(all.clone(), 1e-9).unwrap();
            for _ in 0..40 {
                let [x, p] = [0; 2].map(|_| place(&mut rng, &all));
                let l = length(x, p);
                let d = [(p[0] - x[0]) / l, (p[1] - x[1]) / l];
                let across = |q: Point| (q[1] - x[1]) * d[0] - (q[0] - x[0]) * d[1];
                let along = |q: Point| (q[0] - x[0]) * d[0] + (q[1] - x[1]) * d[1];
                let (tiny, end) = (1e-9 * plan.extent(), l - 1e-6 * plan.extent());
                let plain = l == 0.0
                    || all.iter().all(|s| {
                        let (a, b, start) = (across(s.from), across(s.to), along(s.from));
                        let t = start + (along(s.to) - start) * a / (a - b);
                        let touches = a.abs() <= tiny && start > tiny && start < end;
                        !touches && ((a < 0.0) == (b < 0.0) || t <= tiny || t >= end)
                    });
                assert_eq!(plan.sees(x, p), plain, "{case}: {x:?} {p:?}");
                seen[usize::from(plain)] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n > 500), "{seen:?}");
    }
}
