//! How the places of a region are read: as parts of bridges, of ledges beside their anchors, or of what reaches out.

use super::section::Point;
use super::walk::Walk;

/// A bracket narrower than this share of its value is left as it is.
const CLOSE: f64 = 0.01;
/// A place this share of its strand from the nearest anchor is no part of a ledge, whatever the limits: the middle of a plain bridge lies
/// half of it away, and the corner of two anchors a third.
const CORNER: f64 = 0.4;
/// A place is clearly on a ledge whose strand exceeds its limit by so much more than its way to the anchor does.
const CLEARLY: f64 = 1.1;

/// A length that a place of the region has, with bounds over the whole region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Farthest {
    /// Measured exactly at `at`: no place is known to have more.
    pub low: f64,
    /// No place has more.
    pub high: f64,
    pub at: Point,
    /// The two points between which it was measured.
    pub ends: [Point; 2],
}

/// What a region's free spans are.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spans {
    /// Over the places that lie on a line from anchor to anchor: the greatest of their shortest such lines.
    pub bridge: Option<Farthest>,
    /// Over the places that lie on no such line: the longest of their shortest ways, inside the region, to an anchor or to a place that
    /// lies on one; or the reach of a ledge beside an anchor, where that is more.
    pub cantilever: Option<Farthest>,
    /// Whether the cantilever is a ledge beside an anchor whose strands exceed their limit by more.
    pub is_beside: bool,
    /// Whether any line goes from anchor to anchor, or none is known not to.
    pub is_spanned: bool,
    /// Pairs of a line and a side that finding them took.
    pub pairs: u64,
}

/// What is asked of a region's spans, and what may be spent on it in pairs of a line and a side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Search {
    /// The spans, as narrowly as 20 million pairs bound them.
    Measure,
    /// Whether the region holds itself: the first place that lies on no line from anchor to anchor, or on a ledge, ends the search, and so do
    /// 50,000 pairs. What is found is true, but a longer bridge or a farther cantilever may be left out.
    Judge,
    /// Whether bridge and cantilever are longer than two lengths, with so many pairs: places that can be no longer are left as they are.
    Tell { beyond: [f64; 2], pairs: u64 },
}

impl Search {
    pub(super) fn effort(self) -> u64 {
        match self {
            Search::Measure => 20_000_000,
            Search::Judge => 50_000,
            Search::Tell { pairs, .. } => pairs,
        }
    }

    /// Whether nothing that is still open can change the answer.
    pub(super) fn is_answered(self, found: &Found) -> bool {
        self == Search::Judge && found.lengths[1].or(found.lengths[2]).is_some()
    }

    /// Lengths up to which nothing has to be told apart.
    fn of_no_interest(self) -> [f64; 3] {
        match self {
            Search::Tell { beyond: [bridge, ledge], .. } => [bridge, ledge, ledge],
            Search::Measure | Search::Judge => [0.0; 3],
        }
    }
}

/// Up to what places hold themselves, millimetres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// From an anchor.
    pub ledge: f64,
    /// From anchor to anchor; infinite where nothing is known of it, and strands then are the best hold that there is.
    pub bridge: f64,
}

impl Limits {
    /// What is nearer to an anchor than this share of its strand is a ledge beside the anchor: it exceeds the limit of ledges by less
    /// than the strand does that of bridges.
    fn share(self) -> f64 {
        (self.ledge / self.bridge).min(CORNER)
    }

    /// Bounds of bridge and of ledge beside an anchor, where no strand is longer and no place farther from an anchor.
    pub(super) fn apart(self, strand: f64, way: f64) -> [f64; 2] {
        let share = self.share();
        if share > 0.0 { [strand.min(way / share), way.min(share * strand)] } else { [strand, 0.0] }
    }
}

/// What the places that were looked at have.
///
/// A place beyond both limits is read as what exceeds its limit by less. At the corner of two anchors strands are as short as may be, so
/// wherever a ledge goes on from a corner, some place reads as a bridge that exceeds its limit as much as the ledge does; and near the ends of
/// a bridge some reads as a ledge that does so. Neither is told: the reading of the place that is farthest from all anchors is the region's, and the
/// other one is told beside it only where it exceeds its limit by more.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    limits: Limits,
    /// Bridge, cantilever, and ledge beside an anchor.
    pub lengths: [Option<Farthest>; 3],
    /// The farthest from an anchor of places on bridges beyond the limit, and of places on ledges that are clearly so.
    deepest: f64,
    firm: f64,
    pub pairs: u64,
}

impl Found {
    pub fn new(limits: Limits) -> Self {
        Found { limits, lengths: [None; 3], deepest: 0.0, firm: 0.0, pairs: 0 }
    }

    pub fn keep(&mut self, n: usize, candidate: Farthest) {
        if let Some(best) = self.lengths.get_mut(n).filter(|b| b.is_none_or(|b| candidate.low > b.low)) {
            *best = Some(candidate);
        }
    }

    /// Takes in a place on a strand, beyond the ledge limit; whether it reads as a ledge farther out than those before.
    pub fn note(&mut self, at: Point, ends: [Point; 2], walk: Walk) -> bool {
        let strand = (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1]);
        if walk.most < self.limits.share() * strand {
            let is_farther = self.low(2) < walk.least;
            if CLEARLY * walk.most < self.limits.share() * strand {
                self.firm = self.firm.max(walk.least);
            }
            self.keep(2, Farthest { low: walk.least, high: walk.most, at, ends: [at, walk.anchor] });
            return is_farther;
        }
        if strand > self.limits.bridge {
            self.deepest = self.deepest.max(walk.most);
        }
        self.keep(0, Farthest { low: strand, high: strand, at, ends });
        false
    }

    fn low(&self, n: usize) -> f64 {
        self.lengths.get(n).copied().flatten().map_or(0.0, |f| f.low)
    }

    /// Whether the places farthest from all anchors are on a ledge, as far as the search tells, and clearly so where others are not.
    fn is_ledge(&self) -> bool {
        let alone = self.deepest == 0.0 && self.low(2) > 0.0;
        alone || self.firm > self.deepest * (1.0 - 2.0 * CLOSE)
    }

    /// Bounds up to which squares need no closer look.
    pub fn enough(&self, search: Search) -> [f64; 3] {
        let share = self.limits.share();
        let bridge = if self.is_ledge() { self.low(0).max(self.firm / share) } else { self.low(0) };
        let known = [bridge, self.low(1), self.low(2).max(share * self.low(0))];
        let least = search.of_no_interest();
        [0, 1, 2].map(|n| (known[n] * (1.0 + CLOSE)).max(least[n]) + 1e-9)
    }

    /// The length beyond which a strand would be told as the region's bridge; a search that judges tells none.
    pub fn told_beyond(&self, search: Search) -> f64 {
        if search == Search::Judge { f64::INFINITY } else { self.low(0).max(search.of_no_interest()[0]) }
    }

    /// The region's spans, with the bounds of all squares.
    pub fn told(self, closed: [f64; 3], at: Point) -> Spans {
        let Limits { ledge, bridge: limit } = self.limits;
        let share = self.limits.share();
        let [bridge, cantilever, beside] = self.lengths;
        let mut bridge = raised(bridge, closed[0], 0.0, at);
        let mut cantilever = raised(cantilever, closed[1], ledge, at);
        let is_spanned = bridge.or(beside).is_some();
        let exceeds = bridge.is_some_and(|b| b.high > limit);
        let told = beside.filter(|b| self.is_ledge() || b.low > share * self.low(0) * (1.0 + 2.0 * CLOSE));
        let beside = match told {
            Some(_) => raised(told, closed[2], ledge, at),
            None if exceeds => None,
            None => raised(None, closed[2], ledge, at),
        };
        let as_ledge =
            |b: &Farthest| b.high > limit && told.is_some_and(|t| share * b.high <= t.low * (1.0 + 2.0 * CLOSE));
        if self.is_ledge() && bridge.as_ref().is_some_and(as_ledge) {
            bridge = None;
        }
        let is_beside = beside.is_some_and(|b| cantilever.is_none_or(|c| b.low > c.low));
        if let Some(b) = beside {
            let other = cantilever.unwrap_or(b);
            let farther = if is_beside { b } else { other };
            cantilever = Some(Farthest { high: b.high.max(other.high), ..farther });
        }
        Spans { bridge, cantilever, is_beside, is_spanned, pairs: self.pairs }
    }
}

/// A length with the bound of all squares; one that no sample showed, but that is not ruled out, has a low of 0.
fn raised(found: Option<Farthest>, high: f64, least: f64, at: Point) -> Option<Farthest> {
    match found {
        Some(f) => Some(Farthest { high: f.high.max(high), ..f }),
        None => (high > least).then_some(Farthest { low: 0.0, high, at, ends: [at; 2] }),
    }
}
