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
