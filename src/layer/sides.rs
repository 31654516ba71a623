//! Sides in plan found by where they lie: near a place, along a line, nearest of all.

use super::line::{Side, foot, length};
use super::section::Point;

/// Sides in a leaf, at most.
const LEAF: usize = 8;
/// Boxes are larger than their sides by this share of the largest coordinate: the foot of a place may lie some 1e-16 of it beside its side.
const PAD: f64 = 1e-12;

/// Sides in their order, and a tree of boxes over them.
///
/// A box tells only which sides to look at. Its bounds are reckoned as what they bound is, and rounding keeps order: no side is left out
/// that the same question put to each side would find.
#[derive(Debug, Default)]
pub(super) struct Sides {
    all: Vec<Side>,
    /// With their numbers, leaf by leaf.
    runs: Vec<(usize, Side)>,
    /// A box is followed by those within it.
    boxes: Vec<Frame>,
}

/// A box, and the run of the sides in it.
#[derive(Debug)]
pub(super) struct Frame {
    /// Its least and its greatest corner.
    corners: [Point; 2],
    first: usize,
    count: usize,
    /// The first box behind those within this one.
    next: usize,
}

/// The nearest side to a place: its number, how far away it is, and its nearest point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Nearest {
    pub side: usize,
    pub far: f64,
    pub at: Point,
}

impl Frame {
    /// Lower and upper bound of how far the sides lie to the left of a line through x along d.
    #[inline]
    pub fn across(&self, x: Point, d: Point) -> [f64; 2] {
        let (right, above) = (usize::from(d[1] >= 0.0), usize::from(d[0] >= 0.0));
        let of = |n: usize, m: usize| (self.corners[m][1] - x[1]) * d[0] - (self.corners[n][0] - x[0]) * d[1];
        [of(right, 1 - above), of(1 - right, above)]
    }

    /// Lower and upper bound of how far the sides lie ahead of x along d.
    #[inline]
    pub fn along(&self, x: Point, d: Point) -> [f64; 2] {
        let (right, above) = (usize::from(d[0] >= 0.0), usize::from(d[1] >= 0.0));
        let of = |n: usize, m: usize| (self.corners[n][0] - x[0]) * d[0] + (self.corners[m][1] - x[1]) * d[1];
        [of(1 - right, 1 - above), of(right, above)]
    }

    /// No side is nearer to x.
    #[inline]
    fn away(&self, x: Point) -> f64 {
        length(x, [0, 1].map(|a| x[a].max(self.corners[0][a]).min(self.corners[1][a])))
    }

    fn is_leaf(&self) -> bool {
        self.count <= LEAF
    }
}

impl Sides {
    /// # Cost
    /// O(sides · log).
    pub fn new(all: Vec<Side>) -> Self {
        let mut runs: Vec<(usize, Side)> = all.iter().copied().enumerate().collect();
        let largest = all.iter().flat_map(|s| [s.from, s.to]).flatten().fold(0.0f64, |m, c| m.max(c.abs()));
        let mut boxes = Vec::with_capacity(4 * all.len() / LEAF + 1);
        frame(&mut runs, 0, PAD * largest, &mut boxes);
        Sides { all, runs, boxes }
    }

    pub fn all(&self) -> &[Side] {
        &self.all
    }

    /// The sides in the boxes that may hold what is sought, with their numbers, leaf by leaf.
    ///
    /// # Cost
    /// O(boxes that may, and the two within each).
    #[inline]
    pub fn in_boxes<'a>(&'a self, may: impl Fn(&Frame) -> bool + 'a) -> impl Iterator<Item = &'a (usize, Side)> {
        let mut at = 0;
        let leaf = move || {
            while let Some(b) = self.boxes.get(at) {
                let is_met = may(b);
                at = if is_met { at + 1 } else { b.next };
                if is_met && b.is_leaf() {
                    return self.runs.get(b.first..b.first + b.count);
                }
            }
            None
        };
        std::iter::from_fn(leaf).flatten()
    }

    /// The sides in boxes that reach into the strip of all lines along d within `half` of x.
    #[inline]
    pub fn in_strip(&self, x: Point, d: Point, half: f64) -> impl Iterator<Item = &(usize, Side)> {
        self.in_boxes(move |b| {
            let [lo, hi] = b.across(x, d);
            !(lo > half || hi < -half)
        })
    }

    /// The sides within `reach` of x.
    #[inline]
    pub fn within(&self, x: Point, reach: f64) -> impl Iterator<Item = &(usize, Side)> {
        let boxes = self.in_boxes(move |b| b.away(x) <= reach);
        boxes.filter(move |(_, s)| length(x, foot(x, s)) <= reach)
    }

    /// The nearest of the sides that are `wanted` by how far away they are, their nearest point and themselves; of equal ones the first.
    ///
    /// # Cost
    /// O(log) where most sides are wanted, up to O(sides).
    pub fn nearest(&self, x: Point, wanted: impl Fn(f64, Point, &Side) -> bool) -> Option<Nearest> {
        let mut best = None;
        self.seek(0, x, &wanted, &mut best);
        best
    }

    fn seek(&self, at: usize, x: Point, wanted: &impl Fn(f64, Point, &Side) -> bool, best: &mut Option<Nearest>) {
        let Some(b) = self.boxes.get(at) else { return };
        if b.is_leaf() {
            for &(side, ref s) in self.runs.get(b.first..b.first + b.count).unwrap_or_default() {
                let p = foot(x, s);
                let new = Nearest { side, far: length(x, p), at: p };
                let is_nearer = |b: &Nearest| new.far.total_cmp(&b.far).then(side.cmp(&b.side)).is_lt();
                if best.as_ref().is_none_or(is_nearer) && wanted(new.far, p, s) {
                    *best = Some(new);
                }
            }
            return;
        }
        let away = |n: usize| self.boxes.get(n).map_or(f64::INFINITY, |b| b.away(x));
        let halves = [at + 1, self.boxes.get(at + 1).map_or(at, |b| b.next)].map(|n| (away(n), n));
        let [near, far] = if halves[1].0 < halves[0].0 { [halves[1], halves[0]] } else { halves };
        for (away, n) in [near, far] {
            if best.is_none_or(|b| away <= b.far) {
                self.seek(n, x, wanted, best);
            }
        }
    }
}

/// Adds the box of a run that begins at `first`, and those within it: halves across its longer way.
fn frame(run: &mut [(usize, Side)], first: usize, pad: f64, boxes: &mut Vec<Frame>) {
    let points = || run.iter().flat_map(|(_, s)| [s.from, s.to]);
    let lo = points().fold([f64::INFINITY; 2], |m, p| [0, 1].map(|a| m[a].min(p[a] - pad)));
    let hi = points().fold([f64::NEG_INFINITY; 2], |m, p| [0, 1].map(|a| m[a].max(p[a] + pad)));
    let (at, count) = (boxes.len(), run.len());
    boxes.push(Frame { corners: [lo, hi], first, count, next: at + 1 });
    if count <= LEAF {
        run.sort_unstable_by_key(|(n, _)| *n);
        return;
    }
    let axis = usize::from(hi[1] - lo[1] > hi[0] - lo[0]);
    let place = |s: &Side| s.from[axis] + s.to[axis];
    let half = count / 2;
    run.select_nth_unstable_by(half, |(n, a), (m, b)| place(a).total_cmp(&place(b)).then(n.cmp(m)));
    let (left, right) = run.split_at_mut(half);
    frame(left, first, pad, boxes);
    frame(right, first + half, pad, boxes);
    let next = boxes.len();
    boxes.iter_mut().skip(at).take(1).for_each(|b| b.next = next);
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::random::Lcg;

    /// A ragged outline somewhere, its sides in any order; of every other one the corners lie on a lattice, where much is equal.
    pub fn ragged(rng: &mut Lcg, case: usize) -> Vec<Side> {
        let count = 3 + rng.below(if case.is_multiple_of(5) { 400 } else { 40 }) as usize;
        let away = [0, 1].map(|_| 300.0 * rng.unit() - 150.0);
        let mut corner = |n: usize| {
            let (s, c) = (std::f64::consts::TAU * n as f64 / count as f64).sin_cos();
            let r = 2.0 + 8.0 * rng.unit();
            let at = [r * c + away[0], r * s + away[1]];
            if case.is_multiple_of(2) { at.map(f64::round) } else { at }
        };
        let corners: Vec<Point> = (0..count).map(&mut corner).collect();
        let side = |n: usize| Side { from: corners[n], to: corners[(n + 1) % count], anchored: !n.is_multiple_of(3) };
        let mut sides: Vec<Side> = (0..count).map(side).collect();
        for n in (1..count).rev() {
            sides.swap(n, rng.below(n as u64 + 1) as usize);
        }
        sides
    }

    /// A place about a region: anywhere, on a corner, or on the middle of a side.
    pub fn place(rng: &mut Lcg, sides: &[Side]) -> Point {
        let s = sides[rng.below(sides.len() as u64) as usize];
        match rng.below(4) {
            0 => s.from,
            1 => [0, 1].map(|a| 0.5 * (s.from[a] + s.to[a])),
            _ => s.from.map(|c| c + 12.0 * rng.unit() - 6.0),
        }
    }

    /// A direction: any, or along an axis or a diagonal.
    pub fn direction(rng: &mut Lcg) -> Point {
        let turn = if rng.below(3) == 0 { rng.below(8) as f64 / 8.0 } else { rng.unit() };
        let (s, c) = (std::f64::consts::TAU * turn).sin_cos();
        [c, s]
    }

    fn numbers<'a>(found: impl Iterator<Item = &'a (usize, Side)>) -> Vec<usize> {
        let mut numbers: Vec<usize> = found.map(|(n, _)| *n).collect();
        numbers.sort_unstable();
        numbers
    }

    #[test]
    fn sides_within_reach_are_those_of_a_plain_search() {
        let mut rng = Lcg(41);
        for case in 0..300 {
            let all = ragged(&mut rng, case);
            let sides = Sides::new(all.clone());
            for _ in 0..10 {
                let (x, other) = (place(&mut rng, &all), all[rng.below(all.len() as u64) as usize]);
                // Also just as far as a side lies away, and none.
                for reach in [4.0 * rng.unit(), length(x, foot(x, &other)), 0.0] {
                    let plain = (0..all.len()).filter(|n| length(x, foot(x, &all[*n])) <= reach);
                    assert_eq!(numbers(sides.within(x, reach)), plain.collect::<Vec<_>>(), "{case}: {x:?} {reach}");
                }
            }
        }
    }

    #[test]
    fn no_side_that_reaches_into_a_strip_is_left_out() {
        let mut rng = Lcg(43);
        for case in 0..300 {
            let all = ragged(&mut rng, case);
            let sides = Sides::new(all.clone());
            for _ in 0..10 {
                let (x, d) = (place(&mut rng, &all), direction(&mut rng));
                let half = if rng.below(2) == 0 { 0.0 } else { 2.0 * rng.unit() };
                let across = |p: Point| (p[1] - x[1]) * d[0] - (p[0] - x[0]) * d[1];
                let reaches = |s: &Side| {
                    let (a, b) = (across(s.from), across(s.to));
                    a.min(b) <= half && a.max(b) >= -half
                };
                let found = numbers(sides.in_strip(x, d, half));
                let missed = (0..all.len()).find(|n| reaches(&all[*n]) && found.binary_search(n).is_err());
                assert_eq!(missed, None, "{case}: {x:?} {d:?} {half}");
                assert!(found.windows(2).all(|n| n[0] < n[1]), "{found:?}");
            }
        }
    }

    #[test]
    fn the_nearest_side_is_the_first_of_the_nearest_of_a_plain_search() {
        let mut rng = Lcg(47);
        for case in 0..300 {
            let all = ragged(&mut rng, case);
            let sides = Sides::new(all.clone());
            for _ in 0..10 {
                let x = place(&mut rng, &all);
                let least = if rng.below(2) == 0 { 0.0 } else { 3.0 * rng.unit() };
                let feet = all.iter().map(|s| foot(x, s)).enumerate();
                let feet = feet.map(|(side, at)| Nearest { side, far: length(x, at), at });
                let plain = feet.filter(|n| n.far >= least).min_by(|a, b| a.far.total_cmp(&b.far));
                assert_eq!(sides.nearest(x, |far, _, _| far >= least), plain, "{case}: {x:?} {least}");
            }
        }
        assert_eq!(Sides::new(Vec::new()).nearest([0.0; 2], |_, _, _| true), None);
    }
}
