//! Straight lines across a region in plan: where they cross its boundary, and the nearest points of its sides.

use super::section::Point;

/// One stretch of a region's boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    pub from: Point,
    pub to: Point,
    /// Whether the region is held up along it.
    pub anchored: bool,
}

/// A line's stretch inside the region.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chord {
    pub t: [f64; 2],
    pub anchored: bool,
}

/// A side seen along a direction from a place: how far its ends lie across it and along it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turned {
    pub across: [f64; 2],
    along: [f64; 2],
    anchored: bool,
}

impl Turned {
    #[inline]
    pub fn new(s: &Side, x: Point, d: Point) -> Self {
        let across = |p: Point| (p[1] - x[1]) * d[0] - (p[0] - x[0]) * d[1];
        let along = |p: Point| (p[0] - x[0]) * d[0] + (p[1] - x[1]) * d[1];
        Turned { across: [across(s.from), across(s.to)], along: [along(s.from), along(s.to)], anchored: s.anchored }
    }

    pub fn lo(&self) -> f64 {
        self.across[0].min(self.across[1])
    }

    pub fn hi(&self) -> f64 {
        self.across[0].max(self.across[1])
    }

    /// Where the line at an offset crosses the side; an end on the line counts as above it.
    #[inline]
    pub fn met_by(&self, offset: f64) -> Option<Crossing> {
        let (a, b) = (self.across[0] - offset, self.across[1] - offset);
        let [p, q] = self.along;
        let at = || Crossing { t: p + (q - p) * a / (a - b), rises: a < 0.0, anchored: self.anchored };
        ((a < 0.0) != (b < 0.0)).then(at)
    }
}

/// Where a line crosses a side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    t: f64,
    /// Whether the side goes from the right of the line to its left.
    rises: bool,
    anchored: bool,
}

/// Calls back with the stretches of a line inside the region, from all its crossings with the boundary.
///
/// Where two pieces of the region meet along a side, as the two treads of a step do in plan, the line leaves the one before it enters the
/// other: crossings nearer than `tiny` to each other change places if that makes it so.
pub(super) fn chords(crossings: &mut [Crossing], tiny: f64, mut found: impl FnMut(Chord)) {
    crossings.sort_by(|a, b| a.t.total_cmp(&b.t));
    let Some(enters) = crossings.first().map(|c| c.rises) else { return };
    for n in (1..crossings.len().saturating_sub(1)).step_by(2) {
        let [out, into] = [crossings[n], crossings[n + 1]];
        if out.rises == enters && into.rises != enters && into.t - out.t <= tiny {
            crossings.swap(n, n + 1);
        }
    }
    for pair in crossings.chunks_exact(2) {
        found(Chord { t: [pair[0].t, pair[1].t], anchored: pair[0].anchored && pair[1].anchored });
    }
}

/// How far the first and the last anchored side that the line at an offset crosses lie apart on it: no anchored stretch is longer.
pub(super) fn between_anchors(sides: &[Turned], offset: f64) -> f64 {
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    for c in sides.iter().filter(|s| s.anchored).filter_map(|s| s.met_by(offset)) {
        (lo, hi) = (lo.min(c.t), hi.max(c.t));
    }
    hi - lo
}

/// The stretch that holds the place from which crossings are counted; `None` outside the region.
pub(super) fn own_chord(crossings: &mut [Crossing], tiny: f64) -> Option<Chord> {
    let mut own = None;
    chords(crossings, tiny, |c| {
        if c.t[0] <= 0.0 && c.t[1] >= 0.0 {
            own = Some(c);
        }
    });
    own
}

/// The stretches through a place along directions that stand evenly over half a turn, each as [`own_chord`] has it, and how many pairs of
/// a side and a direction were looked at: a side is met by the directions between its ends alone.
///
/// # Cost
/// O(sides + pairs), which is about the directions times the sides that a line meets.
pub(super) fn all_round(sides: &[Side], x: Point, directions: &[Point], tiny: f64) -> (Vec<Option<Chord>>, usize) {
    let mut crossings: Vec<Vec<Crossing>> = vec![Vec::new(); directions.len()];
    let (count, mut met) = (directions.len() as i64, sides.len());
    let first = directions.first().map_or(0.0, |d| d[1].atan2(d[0]));
    let turn = |p: Point| ((p[1] - x[1]).atan2(p[0] - x[0]) - first) * count as f64 / std::f64::consts::PI;
    for s in sides {
        let (a, b) = (turn(s.from), turn(s.to));
        let (a, b) = (a.min(b), a.max(b));
        // Seen from the place no side takes more than half a turn.
        let (a, b) = if b - a > count as f64 { (b, a + 2.0 * count as f64) } else { (a, b) };
        // Where a side ends at the place itself rounding tells which directions meet it.
        let (a, b) = if x == s.from || x == s.to { (0.0, count as f64) } else { (a, b) };
        // One more on either side: which of the directions at its ends meet it is told as for any line.
        for n in (a.floor() as i64..=b.ceil() as i64).take(directions.len()) {
            let at = n.rem_euclid(count) as usize;
            met += 1;
            let crossing = directions.get(at).and_then(|d| Turned::new(s, x, *d).met_by(0.0));
            crossing.into_iter().for_each(|c| crossings[at].push(c));
        }
    }
    (crossings.iter_mut().map(|met| own_chord(met, tiny)).collect(), met)
}

pub(super) fn length(a: Point, b: Point) -> f64 {
    ((b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)).sqrt()
}

/// The point of a side that is nearest to x.
pub(super) fn foot(x: Point, s: &Side) -> Point {
    let d = [s.to[0] - s.from[0], s.to[1] - s.from[1]];
    let l2 = d[0] * d[0] + d[1] * d[1];
    let t = if l2 > 0.0 { ((x[0] - s.from[0]) * d[0] + (x[1] - s.from[1]) * d[1]) / l2 } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    [s.from[0] + t * d[0], s.from[1] + t * d[1]]
}

#[cfg(test)]
mod tests {
    use super::super::directions::turned;
    use super::*;
    use crate::random::Lcg;

    #[test]
    fn stretches_all_round_are_those_of_each_direction() {
        let mut rng = Lcg(31);
        for case in 0..200 {
            let count = 3 + rng.below(20) as usize;
            let corner = |n: usize, r: f64| {
                let (s, c) = (std::f64::consts::TAU * n as f64 / count as f64).sin_cos();
                [r * c + 3.0, r * s - 2.0]
            };
            let radii: Vec<f64> = (0..count).map(|_| 2.0 + 8.0 * rng.unit()).collect();
            let side = |n: usize| {
                let [from, to] = [n, (n + 1) % count].map(|n| corner(n, radii[n]));
                Side { from, to, anchored: !n.is_multiple_of(3) }
            };
            let sides: Vec<Side> = (0..count).map(side).collect();
            // Anywhere, and on corners and middles of sides.
            let x = match case % 4 {
                0 => sides[0].from,
                1 => [0, 1].map(|a| 0.5 * (sides[1].from[a] + sides[1].to[a])),
                _ => [0, 1].map(|_| 20.0 * rng.unit() - 10.0),
            };
            let (s, c) = rng.unit().sin_cos();
            let directions = turned([c, s], 120);
            let (found, pairs) = all_round(&sides, x, &directions, 1e-9);
            for (d, found) in directions.iter().zip(found) {
                let mut met: Vec<Crossing> = sides.iter().filter_map(|s| Turned::new(s, x, *d).met_by(0.0)).collect();
                let plain = own_chord(&mut met, 1e-9);
                let told = |c: Option<Chord>| c.map(|c| (c.t, c.anchored));
                assert_eq!(told(found), told(plain), "{case}: {x:?} {d:?}");
            }
            assert!(pairs <= count * 130, "{pairs}");
        }
    }
}
