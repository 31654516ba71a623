//! Strands beyond which nothing is bridged, and squares of a region all of which sees what holds it.

use super::line::{Side, Turned, chords, foot, length};
use super::plan::{Cell, Plan};
use super::section::Point;
use super::walk::Holds;
use crate::geometry::halfspace::cut;

/// Squares that more sides cross are split rather than bounded by what is left of them.
const CROSSED: usize = 8;
/// A strand that another leaves no more than so many times what is not seen is covered by it.
const COVERED: f64 = 16.0;

/// What the strands from anchor to anchor cover, by what bounds it.
pub(super) struct Outermost {
    pub strands: Vec<Side>,
    /// Whether there are any strands: anchors alone may bound what they cover.
    pub is_spanned: bool,
}

impl Plan {
    /// The strands from anchor to anchor that bound what such strands cover: those beside a corner of the boundary that no strand on the
    /// other side of it covers.
    ///
    /// Between the corners the strands of a direction sweep trapezoids, so what they cover is bounded by anchors and by these.
    ///
    /// # Cost
    /// O(directions · sides · (log + sides that a line meets)).
    pub(super) fn outermost(&self) -> Outermost {
        let mut found = Outermost { strands: Vec::new(), is_spanned: false };
        for &d in self.lines() {
            let origin = self.sides().all().first().map_or([0.0; 2], |s| s.from);
            let mut turned: Vec<Turned> = self.sides().all().iter().map(|s| Turned::new(s, origin, d)).collect();
            turned.sort_by(|a, b| a.lo().total_cmp(&b.lo()));
            let mut corners: Vec<f64> = turned.iter().flat_map(|s| s.across).collect();
            corners.sort_by(f64::total_cmp);
            corners.dedup_by(|a, b| *a - *b < 0.5 * self.tiny());
            let place = |t: f64, o: f64| [origin[0] + t * d[0] - o * d[1], origin[1] + t * d[1] + o * d[0]];
            let (mut at_hand, mut next): (Vec<Turned>, usize) = (Vec::new(), 0);
            for corner in corners {
                let beside = [corner - self.tiny(), corner + self.tiny()];
                while let Some(s) = turned.get(next).filter(|s| s.lo() < beside[1]) {
                    at_hand.push(*s);
                    next += 1;
                }
                at_hand.retain(|s| s.hi() >= beside[0]);
                let strands = beside.map(|o| anchored(&at_hand, o, self.tiny()));
                found.is_spanned |= strands.iter().any(|s| !s.is_empty());
                for (own, other) in [(0, 1), (1, 0)] {
                    let bare = strands[own].iter().filter(|s| !is_covered(s, &strands[other], COVERED * self.tiny()));
                    let ends = bare.map(|s| s.map(|t| place(t, beside[own])));
                    found.strands.extend(ends.map(|[from, to]| Side { from, to, anchored: true }));
                }
            }
        }
        found
    }

    /// An upper bound of the ways from the region's places in a square to its nearest hold; infinite where not all of them are known
    /// to see it.
    ///
    /// Let M be the sides that the square's circle meets. If each has the others in front of it, so has it all of the region in the
    /// circle: a place behind a side could be reached from it inside the circle only by coming in through another, which would have the
    /// first one behind it. What the half-planes leave of the square is a convex polygon Q. A straight way from a place in Q to its foot
    /// on the hold that leaves the region by a free side ends behind that side; if all free sides as near have the feet of Q in front of
    /// them, there is no such way, and one that leaves by an anchored side has found a nearer hold. The distance to a segment is
    /// convex: none in Q has more than Q's corners.
    ///
    /// Where each of M is free and has the others behind it, as at a corner that points into the region, what lies behind all of them in the
    /// circle is not the region: a straight way from there to one of them meets none before. So each place lies before one of them, and there
    /// are as many such polygons, each with a hold of its own.
    ///
    /// # Cost
    /// O(log + free sides as near as what sees the hold), three times for each side of a corner.
    pub(super) fn in_sight(&self, cell: &Cell, met: &[(usize, Side)], holds: &Holds) -> f64 {
        let x = cell.centre;
        if met.len() > CROSSED || holds.by().all().is_empty() {
            return f64::INFINITY;
        }
        let of_all = |is: &dyn Fn(&Side, &Side) -> bool| met.iter().all(|(_, s)| met.iter().all(|(_, o)| is(s, o)));
        let faces = |s: &Side, o: &Side| self.is_before(s, o.from) && self.is_before(s, o.to);
        if of_all(&faces) {
            let sides: Vec<&Side> = met.iter().map(|(_, s)| s).collect();
            return self.in_sight_before(&sides, cell, x, holds);
        }
        let is_behind = |s: &Side, p: Point| self.before(s, p) <= 0.0;
        if !of_all(&|s, o| !s.anchored && (s == o || is_behind(s, o.from) && is_behind(s, o.to))) {
            return f64::INFINITY;
        }
        // Beside the corner another hold than that of its middle may be the nearer one.
        let before_one = |s: &Side| {
            let (on, share) = (foot(x, s), cell.half / length(s.from, s.to).max(f64::MIN_POSITIVE));
            let beside = |t: f64| [0, 1].map(|n| on[n] + t * share * (s.to[n] - s.from[n]));
            let from = [x, beside(-1.0), beside(1.0)];
            from.into_iter().map(|p| self.in_sight_before(&[s], cell, p, holds)).fold(f64::INFINITY, f64::min)
        };
        let mut farthest = 0.0f64;
        for (_, s) in met {
            farthest = farthest.max(before_one(s));
            if farthest.is_infinite() {
                break;
            }
        }
        farthest
    }

    /// The bound of [`Plan::in_sight`] for the places of a square before sides, and the hold nearest to a point.
    fn in_sight_before(&self, sides: &[&Side], cell: &Cell, from: Point, holds: &Holds) -> f64 {
        let x = cell.centre;
        let Some(hold) = holds.by().nearest(from, |_, _, _| true).and_then(|n| holds.by().all().get(n.side)) else {
            return f64::INFINITY;
        };
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let mut left: Vec<Point> = square.map(|s| [x[0] + s[0] * cell.half, x[1] + s[1] * cell.half]).to_vec();
        sides.iter().for_each(|s| left = cut(&left, |p| self.ahead(s, p)));
        let feet: Vec<Point> = left.iter().map(|&p| foot(p, hold)).collect();
        let reach = left.iter().chain(&feet).map(|&p| length(x, p)).fold(0.0, f64::max);
        let mut near = self.sides().within(x, reach).filter(|(_, s)| !s.anchored);
        match near.all(|(_, s)| feet.iter().all(|&p| self.is_before(s, p))) {
            true => left.iter().zip(&feet).map(|(&p, &q)| length(p, q)).fold(0.0, f64::max),
            false => f64::INFINITY,
        }
    }

    /// Whether a point lies on the region's side of a side's line, or on the line.
    fn is_before(&self, s: &Side, p: Point) -> bool {
        self.ahead(s, p) >= -1e-9 * self.extent()
    }
}

/// The stretches of a line from anchor to anchor.
fn anchored(sides: &[Turned], offset: f64, tiny: f64) -> Vec<[f64; 2]> {
    let mut crossings: Vec<_> = sides.iter().filter_map(|s| s.met_by(offset)).collect();
    let mut found = Vec::new();
    chords(&mut crossings, tiny, |c| {
        if c.anchored {
            found.push(c.t);
        }
    });
    found
}

fn is_covered(strand: &[f64; 2], others: &[[f64; 2]], slack: f64) -> bool {
    others.iter().any(|o| o[0] <= strand[0] + slack && strand[1] <= o[1] + slack)
}
