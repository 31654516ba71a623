//! Straight lines across a region in plan: how far from anchor to anchor, how far from the nearest place that is held.

use super::directions::{directions, turned};
use super::line::{Chord, Side, all_round, length};
use super::outermost::Outermost;
use super::reading::{Farthest, Found, Limits, Search, Spans};
use super::section::Point;
use super::sides::Sides;
use super::strip::{Known, Sweep};
use super::walk::{Holds, Walk};
use std::cell::OnceCell;

/// A region in plan, by its sides in any order.
pub struct Plan {
    sides: Sides,
    lines: Vec<Point>,
    /// Directions all round, for places that would be told.
    turns: Vec<Point>,
    lo: Point,
    extent: f64,
    /// Length of the whole boundary.
    around: f64,
    /// Area, positive where the region lies left of its sides.
    area: f64,
    /// What is narrower is not seen.
    tiny: f64,
    anchors: Holds,
    held: OnceCell<Held>,
}

/// What strands between the anchors do for a region.
struct Held {
    /// The anchors and the outermost strands between them; `None` where these are the anchors alone.
    by: Option<Holds>,
    /// Whether any line in the region's directions goes from anchor to anchor.
    is_spanned: bool,
}

/// A square of the search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    pub centre: Point,
    pub half: f64,
    /// Upper bounds of bridge, cantilever and ledge beside an anchor over the region's places in it.
    high: [f64; 3],
}

/// What is asked of squares.
#[derive(Debug, Clone, Copy)]
struct Asked {
    /// Where the strands in a direction are no longer, no other is tried.
    enough: f64,
    /// Lines are held against smaller squares than of this reach, and against those of the first levels.
    lined: f64,
}

/// The centre of a square: outside the region, or inside with its shortest ways to an anchor and to a place that is held.
#[derive(Debug, Clone, Copy)]
enum Centre {
    Outside,
    Inside([f64; 2]),
    /// On a strand, in its direction, with its shortest way to an anchor.
    Spanned(f64, Point),
}

/// Two sides along which strands run may each be off by a step at both ends along both axes: a strip between a strand and a side that is
/// narrower than so many steps is none.
const UNTOLD: f64 = 8.0;
/// Lines through a place that would be told are tried every 1.5°: strands between straight walls are within 1/11,000 of the shortest.
const FINE: usize = 120;
/// Where the effort does not reach, a level of squares may take this part of what is left.
const SHARE: u64 = 3;
/// The smallest half of a square, as a share of the region's extent.
const FINEST: f64 = 1e-4;
/// The half of the squares of the first levels, as a share of the extent.
const COARSE: f64 = 0.02;

impl Plan {
    /// A region from its boundary, whose coordinates are within `step` of what was meant; `None` without sides or extent.
    pub fn new(sides: Vec<Side>, step: f64) -> Option<Self> {
        let points = || sides.iter().flat_map(|s| [s.from, s.to]);
        let lo = points().fold([f64::INFINITY; 2], |m, p| [m[0].min(p[0]), m[1].min(p[1])]);
        let hi = points().fold([f64::NEG_INFINITY; 2], |m, p| [m[0].max(p[0]), m[1].max(p[1])]);
        let extent = (hi[0] - lo[0]).max(hi[1] - lo[1]);
        if !(extent > 0.0 && extent.is_finite()) {
            return None;
        }
        let lines = directions(&sides);
        let turns = lines.first().map_or(Vec::new(), |first| turned(*first, FINE));
        let turned = |s: &Side| (s.from[0] - lo[0]) * (s.to[1] - lo[1]) - (s.from[1] - lo[1]) * (s.to[0] - lo[0]);
        let area = 0.5 * sides.iter().map(turned).sum::<f64>();
        let around = sides.iter().map(|s| length(s.from, s.to)).sum();
        let tiny = (1e-9 * extent).max(UNTOLD * step);
        let anchors = Holds::new(sides.iter().filter(|s| s.anchored).copied().collect());
        let sides = Sides::new(sides);
        Some(Plan { sides, lines, turns, lo, extent, around, area, tiny, anchors, held: OnceCell::new() })
    }

    /// The spans of the region; places within the ledge limit of an anchor need none and are left out.
    ///
    /// For a place x and a direction d, let the chord be the stretch of the line through x along d that lies in the region and holds
    /// x. The bridge at x is the shortest chord with both ends on anchored sides, among the directions tried: across anchored sides and
    /// along free ones, those of the greatest length, every 15° from the first of them, and those from x to its nearest anchored side and to
    /// the nearest on its other side, for a groove that runs round is crossed in more directions than a list holds; a place whose bridge would be
    /// told is looked at every 1.5° as well. What is narrower than a few steps of the
    /// coordinates is not seen: a region that was turned before it was written has strips as narrow between its strands and its sides.
    /// Branch and bound over squares: a square's bound is the longest chord of all lines that meet
    /// it, exact by looking on both sides of every corner between them, in the best direction: a listed one or that of the centre's own strand,
    /// for no place of the square needs a longer strand than the direction has in which all of it has strands; about the corner of a hole in
    /// the directions of its two sides; of the smallest squares any. Where the effort does not reach, the squares are looked at that bound most.
    ///
    /// Where the way to the nearest anchor exceeds the limit of ledges by less than the bridge at x does that of bridges, x is part of a
    /// ledge beside that anchor, and its strand is no span: [`Found`] says which of the two a region is told as.
    ///
    /// The cantilever at a place x without a bridge is the shortest way from x, inside the region, to an anchored side or to a place
    /// with a bridge: a strand between two anchors carries what is laid beside it. Whether the strand is too long is the bridge's
    /// matter. Ways are straight, or by corners whose shortest
    /// ways are found by Dijkstra's search over those that see each other. No place of a square has a longer way than its centre
    /// and the distance to it, unless a side with the centre behind it lies between: then than a way from that side. Nor has any
    /// a longer one than the corners of what the square's sides leave of it, to a hold that all of it sees.
    ///
    /// # Cost
    /// O(directions · (log + sides in a strip · (log + those that a line meets))) for each square. Pairs of a line and a side count against
    /// what the search may spend, as if every side were held against every strip, and what is open then stays in the bracket. A look all
    /// round a place is one of O(sides + directions · those that a line meets). The outermost strands are sought once, where a place has no
    /// bridge, at O(directions · sides · those that a line meets), and do not count.
    pub fn spans(&self, limits: Limits, search: Search) -> Spans {
        let mut found = Found::new(limits);
        let mut cells = self.first_cells();
        let mut closed = [0.0f64; 3];
        loop {
            let mut centres = Vec::with_capacity(cells.len());
            for cell in &cells {
                let told = found.told_beyond(search);
                centres.push(self.measure(cell.centre, limits, told, &mut found));
                if search.is_answered(&found) {
                    return found.told([0.0; 3], self.lo);
                }
            }
            let enough = found.enough(search);
            // Until a place is known beyond the ledge limit, all may lie beside their anchors; a quick look ends before that helps.
            let some = search == Search::Judge || limits.ledge == 0.0;
            let is_known = some || found.lengths.iter().any(Option::is_some);
            let lined = if is_known { f64::INFINITY } else { (0.5 * limits.ledge).max(self.finest()) };
            let asked = Asked { enough: enough[0], lined };
            let bounded = cells.iter_mut().zip(&centres).map(|(cell, at)| self.bound(cell, *at, limits, asked));
            let work: usize = bounded.sum();
            found.pairs += work as u64;
            let each = (work / cells.len().max(1)) as u64;
            let is_open = |c: &Cell| (0..3).any(|n| c.high[n] > enough[n].max(closed[n])) && c.half > self.finest();
            let (mut open, mut done): (Vec<Cell>, Vec<Cell>) = cells.into_iter().partition(is_open);
            // Where not all can be looked at, those are that bound the region most, and a share of the effort is kept for their quarters.
            let may = search.effort().saturating_sub(found.pairs) / (4 * SHARE * each).max(1);
            if open.len() as u64 > may {
                let excess = |c: &Cell| (0..3).map(|n| c.high[n] / enough[n]).fold(0.0, f64::max);
                open.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
                done.extend(open.drain(may as usize..));
            }
            done.iter().for_each(|c| (0..3).for_each(|n| closed[n] = closed[n].max(c.high[n])));
            if open.is_empty() {
                break;
            }
            cells = open.iter().flat_map(quarters).collect();
        }
        found.told(closed, self.lo)
    }

    fn first_cells(&self) -> Vec<Cell> {
        const ACROSS: usize = 6;
        let half = 0.5 * self.extent / ACROSS as f64;
        let at = |n: usize, axis: usize| self.lo[axis] + half * (2 * n + 1) as f64;
        (0..ACROSS * ACROSS)
            .map(|n| Cell { centre: [at(n % ACROSS, 0), at(n / ACROSS, 1)], half, high: [f64::INFINITY; 3] })
            .collect()
    }

    /// Measures the centre of a square, if it lies in the region and not within the ledge limit of an anchor.
    fn measure(&self, x: Point, limits: Limits, told: f64, found: &mut Found) -> Centre {
        if !self.holds(x) {
            return Centre::Outside;
        }
        let walk = self.walk(x, &self.anchors);
        let most = self.farthest(walk);
        if most <= limits.ledge || self.is_on_side(x) {
            return Centre::Inside([most; 2]);
        }
        if let Some(ends) = self.strand(x, told, found) {
            if found.note(x, ends, walk.unwrap_or(Walk { least: most, most, anchor: x })) {
                self.measure_middle(ends, limits, told, found);
            }
            let long = length(ends[0], ends[1]).max(f64::MIN_POSITIVE);
            return Centre::Spanned(most, [0, 1].map(|n| (ends[1][n] - ends[0][n]) / long));
        }
        let walk = self.walk(x, self.held());
        let from_held = self.farthest(walk);
        if from_held > limits.ledge {
            let (low, end) = walk.map_or((0.5 * self.extent, x), |w| (w.least, w.anchor));
            found.keep(1, Farthest { low, high: low, at: x, ends: [x, end] });
        }
        Centre::Inside([most, from_held])
    }

    /// Measures the middle of a strand that was found near one of its ends: there it may well be the best hold.
    fn measure_middle(&self, [from, to]: [Point; 2], limits: Limits, told: f64, found: &mut Found) {
        let x = [0, 1].map(|n| 0.5 * (from[n] + to[n]));
        let walk = self.walk(x, &self.anchors).filter(|w| w.most > limits.ledge && self.holds(x));
        if let Some((walk, ends)) = walk.filter(|_| !self.is_on_side(x)).zip(self.strand(x, told, found)) {
            found.note(x, ends, walk);
        }
    }

    /// Nobody walks farther inside the region than along its whole boundary.
    fn farthest(&self, walk: Option<Walk>) -> f64 {
        walk.map_or(f64::INFINITY, |w| w.most).min(self.around)
    }

    /// The longest of the shortest ways from the places within `reach` of x to a hold, where `behind` are the sides there that have x behind
    /// them and x itself has a way of `from`: an upper bound, which is sought no further once it exceeds what is `told`.
    ///
    /// From a place straight towards x: there it ends, or before at a side that has x behind it.
    fn farthest_about(&self, x: Point, reach: f64, from: f64, behind: &[usize], holds: &Holds, told: f64) -> f64 {
        let bound = |way: f64| (way + reach).min(self.around);
        let mut farthest = from;
        for &side in behind {
            if bound(farthest) > told || bound(farthest) >= self.around {
                break;
            }
            farthest = farthest.max(self.walk_along(side, x, reach, holds));
        }
        bound(farthest)
    }

    /// Lines along a side may or may not meet the anchors at its ends: a place on it shows nothing that no place beside it shows.
    fn is_on_side(&self, x: Point) -> bool {
        self.sides.within(x, self.tiny).next().is_some()
    }

    /// The shortest line through a place from anchor to anchor: of those all round as well, where it would be longer than what is `told`.
    fn strand(&self, x: Point, told: f64, found: &mut Found) -> Option<[Point; 2]> {
        if self.anchors.by().all().is_empty() {
            return None;
        }
        let along = |d: Point| self.sides.chord_at(x, d, self.tiny).filter(|c| c.anchored).map(|c| (c, d));
        let long = |c: &Chord| c.t[1] - c.t[0];
        let shortest = |lines: &mut dyn Iterator<Item = Point>| {
            lines.filter_map(along).min_by(|a, b| long(&a.0).total_cmp(&long(&b.0)))
        };
        let mut own = shortest(&mut self.lines.iter().copied().chain(self.anchors.across(x, self.tiny)))?;
        if long(&own.0) > told {
            let (all_round, met) = all_round(self.sides.all(), x, &self.turns, self.tiny);
            found.pairs += met as u64;
            let chords = all_round.into_iter().zip(self.turns.iter().copied());
            let anchored = chords.filter_map(|(c, d)| Some((c.filter(|c| c.anchored)?, d)));
            own = anchored.chain([own]).min_by(|a, b| long(&a.0).total_cmp(&long(&b.0)))?;
        }
        let (c, d) = own;
        Some(c.t.map(|t| [x[0] + t * d[0], x[1] + t * d[1]]))
    }

    /// Bounds a square; how many sides lines were held against.
    fn bound(&self, cell: &mut Cell, centre: Centre, limits: Limits, Asked { enough, lined }: Asked) -> usize {
        let ledge = limits.ledge;
        // Counted as if each side had been held against the square: how sides are found does not change how far the effort reaches.
        let mut work = 2 * self.sides.all().len();
        let reach = cell.half * std::f64::consts::SQRT_2;
        let x = cell.centre;
        cell.high = [0.0; 3];
        let mut met: Vec<(usize, Side)> = self.sides.within(x, reach).copied().collect();
        met.sort_unstable_by_key(|(n, _)| *n);
        let from_centre = match centre {
            Centre::Outside if met.is_empty() => return work,
            Centre::Outside => [0.0; 2],
            Centre::Inside(most) => most,
            Centre::Spanned(most, _) => [most, 0.0],
        };
        // A centre that is no place of the region though it lies on a side's line has that side before it.
        let within = if matches!(centre, Centre::Outside) { self.tiny } else { 0.0 };
        let is_behind = |s: &Side| self.before(s, x) < 0.0 || self.ahead(s, x).abs() < within;
        let behind: Vec<usize> = met.iter().filter(|(_, s)| is_behind(s)).map(|(n, _)| *n).collect();
        let farthest = |from: f64, holds: &Holds, told: f64| self.farthest_about(x, reach, from, &behind, holds, told);
        let near = (from_centre[0] + reach).min(self.around) <= ledge
            && farthest(from_centre[0], &self.anchors, ledge) <= ledge;
        if near || from_centre[0] <= ledge + reach && self.in_sight(cell, &met, &self.anchors) <= ledge {
            return work;
        }
        if reach > lined && cell.half < COARSE * self.extent {
            cell.high = [2.0 * self.extent, self.around, self.around];
            return work;
        }
        let (mut all, mut some, mut sweep) = (f64::INFINITY, 0.0f64, Sweep::default());
        // Once it is known that no listed line goes from anchor to anchor, none has to be tried.
        let is_bare = self.held.get().is_some_and(|held| !held.is_spanned);
        let listed = if is_bare { &[][..] } else { &self.lines };
        // The shortest strand of the centre, or one square to the nearest anchor, cuts the search in other directions short.
        let own = match centre {
            Centre::Spanned(_, along) => Some(along),
            _ => self.anchors.square(x),
        };
        let mut try_each = |lines: &mut dyn Iterator<Item = Point>, all: &mut f64| {
            for d in lines {
                let known = Known { all: *all, some };
                let strip = sweep.strip(&self.sides, [x, d], [reach, self.tiny], known);
                work += strip.pairs;
                some = some.max(strip.longest);
                *all = if strip.is_whole { all.min(strip.longest) } else { *all };
                if *all <= enough {
                    break;
                }
            }
        };
        try_each(&mut own.into_iter().chain(listed.iter().copied()), &mut all);
        let corner = if all > enough { self.about_corner(x, reach, &met, all) } else { None };
        if let Some(strip) = corner.filter(|strip| strip.is_whole) {
            all = all.min(strip.longest);
        }
        // At a corner strands on its two sides differ however small the square is: there they are turned all round.
        if all.is_finite() && all > enough && cell.half <= self.finest() {
            try_each(&mut self.turns.iter().copied(), &mut all);
        }
        work += corner.map_or(0, |strip| strip.pairs);
        let beyond_ledge = |reach: f64| if reach <= ledge { 0.0 } else { reach };
        cell.high[0] = if all.is_finite() { all } else { some };
        if !all.is_finite() {
            let held = self.held();
            let out = farthest(from_centre[1], held, self.around).min(self.in_sight(cell, &met, held));
            cell.high[1] = beyond_ledge(out);
        }
        if cell.high[0] > limits.bridge {
            let out =
                farthest(from_centre[0], &self.anchors, self.around).min(self.in_sight(cell, &met, &self.anchors));
            let [bridge, beside] = limits.apart(cell.high[0], out);
            (cell.high[0], cell.high[2]) = (bridge, beyond_ledge(beside));
        }
        work
    }

    /// 1 where the region lies left of its sides, -1 where it lies right of them.
    pub(super) fn turn(&self) -> f64 {
        self.area.signum()
    }

    /// Positive where a point lies on the region's side of a side's line, and 0 on it.
    pub(super) fn before(&self, s: &Side, x: Point) -> f64 {
        self.area * ((s.to[0] - s.from[0]) * (x[1] - s.from[1]) - (s.to[1] - s.from[1]) * (x[0] - s.from[0]))
    }

    /// How far a point lies on the region's side of a side's line.
    pub(super) fn ahead(&self, s: &Side, x: Point) -> f64 {
        self.before(s, x) / (self.area.abs() * length(s.from, s.to)).max(f64::MIN_POSITIVE)
    }

    /// Whether a point lies in the region.
    pub(super) fn holds(&self, x: Point) -> bool {
        self.sides.chord_at(x, self.lines[0], self.tiny).is_some()
    }

    pub(super) fn sides(&self) -> &Sides {
        &self.sides
    }

    /// What holds its places: its anchors, and the outermost strands between them.
    fn held(&self) -> &Holds {
        let found = self.held.get_or_init(|| {
            let Outermost { strands, is_spanned } = self.outermost();
            let by = || self.anchors.by().all().iter().copied().chain(strands.iter().copied()).collect();
            Held { by: (!strands.is_empty()).then(|| Holds::new(by())), is_spanned }
        });
        found.by.as_ref().unwrap_or(&self.anchors)
    }

    /// The directions of the lines that are tried.
    pub(super) fn lines(&self) -> &[Point] {
        &self.lines
    }

    /// The half of squares that are looked at no closer.
    fn finest(&self) -> f64 {
        FINEST * self.extent
    }

    /// What is narrower is not seen.
    pub(super) fn tiny(&self) -> f64 {
        self.tiny
    }

    pub(super) fn extent(&self) -> f64 {
        self.extent
    }
}

fn quarters(c: &Cell) -> impl Iterator<Item = Cell> + use<> {
    let (centre, half) = (c.centre, 0.5 * c.half);
    [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].into_iter().map(move |s| Cell {
        centre: [centre[0] + s[0] * half, centre[1] + s[1] * half],
        half,
        high: [f64::INFINITY; 3],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Lcg;

    /// A limit of ledges, and none of bridges.
    fn ledge(mm: f64) -> Limits {
        Limits { ledge: mm, bridge: f64::INFINITY }
    }

    /// A polygon whose sides are anchored where said, turned and shifted.
    fn region(corners: &[Point], anchored: &[bool], turn: f64, shift: Point) -> Plan {
        let (s, c) = turn.sin_cos();
        let put = |p: Point| [c * p[0] - s * p[1] + shift[0], s * p[0] + c * p[1] + shift[1]];
        let n = corners.len();
        let sides = (0..n)
            .map(|i| Side {
                from: put(corners[i]),
                to: put(corners[(i + 1) % n]),
                anchored: anchored[i % anchored.len()],
            })
            .collect();
        Plan::new(sides, 1e-9).unwrap()
    }

    #[test]
    fn treads_that_meet_in_plan_are_left_before_they_are_entered() {
        // A tread of 1 mm that hangs on its left, and beside it, above its edge, a ceiling of 7 mm between two walls.
        let tread = |x: f64, to: f64, right: bool| {
            let p = [[x, 0.0], [to, 0.0], [to, 4.0], [x, 4.0]];
            [false, right, false, true].into_iter().enumerate().map(move |(n, anchored)| Side {
                from: p[n],
                to: p[(n + 1) % 4],
                anchored,
            })
        };
        for treads in [[(0.0, 1.0, false), (1.0, 8.0, true)], [(1.0, 8.0, true), (0.0, 1.0, false)]] {
            let sides = treads.into_iter().flat_map(|(x, to, right)| tread(x, to, right)).collect();
            let spans = Plan::new(sides, 1e-9).unwrap().spans(ledge(0.0), Search::Measure);
            let bridge = spans.bridge.unwrap();
            // A square on the seam has no more than the strands beside the level ones, 15° off.
            assert!(
                (bridge.low - 7.0).abs() < 1e-9 && bridge.high < 7.0 / 15f64.to_radians().cos() + 1e-3,
                "{spans:?}"
            );
            assert!(spans.cantilever.is_some_and(|c| c.at[0] < 1.0), "{spans:?}");
        }
    }

    fn rectangle(a: f64, b: f64) -> [Point; 4] {
        [[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]]
    }

    /// Low and high hold the truth, and do not lie farther apart than a share of it.
    fn holds(f: Option<Farthest>, truth: f64, share: f64) {
        let f = f.unwrap();
        assert!(f.low <= truth * (1.0 + 1e-6) && truth <= f.high * (1.0 + 1e-6), "{truth}: {f:?}");
        assert!(f.high - f.low <= share * truth, "{truth}: {f:?}");
    }

    #[test]
    fn squares_whose_middle_lies_on_a_side_are_bounded_too() {
        // A bar of 24 × 4 mm between two anchors, with a free stem of 11 mm: coordinates at which squares are divided.
        let corners = [
            [-12.0, -2.0],
            [12.0, -2.0],
            [12.0, 2.0],
            [2.0, 2.0],
            [2.0, 13.0],
            [-2.0, 13.0],
            [-2.0, 2.0],
            [-12.0, 2.0],
        ];
        let anchored = [false, true, false, false, false, false, false, true];
        for turn in [0.0, 0.5 * std::f64::consts::PI, 0.3] {
            let plan = region(&corners, &anchored, turn, [0.0; 2]);
            let spans = plan.spans(Limits { ledge: 0.4, bridge: 10.0 }, Search::Measure);
            holds(spans.cantilever, 11.0, 0.02);
            holds(spans.bridge, 24.0, 0.02);
        }
    }

    #[test]
    fn rectangles_under_any_turn() {
        let mut rng = Lcg(17);
        for _ in 0..40 {
            let turn = std::f64::consts::TAU * rng.unit();
            let shift = [50.0 * rng.unit(), 50.0 * rng.unit()];
            let (a, b) = (5.0 + 40.0 * rng.unit(), 2.0 + 20.0 * rng.unit());
            let held =
                |anchored: &[bool]| region(&rectangle(a, b), anchored, turn, shift).spans(ledge(0.0), Search::Measure);
            // From one end to the other: the span is the length, and nothing is a cantilever.
            let spans = held(&[false, true, false, true]);
            holds(spans.bridge, a, 1e-6);
            assert_eq!(spans.cantilever, None);
            // Held all around: as far as the narrower way.
            holds(held(&[true]).bridge, a.min(b), 0.05);
            // Held on one side only: a cantilever that reaches as far as it is deep.
            let spans = held(&[false, true, false, false]);
            assert_eq!(spans.bridge, None);
            holds(spans.cantilever, a, 0.05);
            assert!(held(&[true]).cantilever.is_none());
        }
    }

    #[test]
    fn a_region_that_was_turned_before_it_was_written_has_the_same_spans() {
        // A region with a notch, held on some of its sides, and a long narrow strip held at its ends.
        let comb = [[0.0, 0.0], [9.0, 0.0], [9.0, 4.0], [6.0, 4.0], [6.0, 1.0], [3.0, 1.0], [3.0, 4.0], [0.0, 4.0]];
        let comb_held = [false, false, true, false, true, false, true, false].map(|held| !held);
        let strip = rectangle(40.0, 1.5);
        let step = f64::powi(2.0, -24) * 200.0;
        for n in 0..60 {
            let (turn, shift) = (0.11 * f64::from(n), [120.0, -77.0]);
            let written = |p: Point| p.map(|c| f64::from(c as f32));
            let spans = |corners: &[Point], held: &[bool]| {
                let sides = region(corners, held, turn, shift).sides().all().to_vec();
                let sides = sides.into_iter().map(|s| Side { from: written(s.from), to: written(s.to), ..s });
                Plan::new(sides.collect(), step).unwrap().spans(ledge(0.0), Search::Measure)
            };
            let found = spans(&strip, &[false, true]);
            holds(found.bridge, 40.0, 1e-5);
            assert_eq!(found.cantilever, None, "{n}");
            let (found, plain) =
                (spans(&comb, &comb_held), region(&comb, &comb_held, 0.0, [0.0; 2]).spans(ledge(0.0), Search::Measure));
            let value = |f: Option<Farthest>| f.map(|f| (1e3 * f.low).round());
            assert_eq!(found.cantilever.is_some(), plain.cantilever.is_some(), "{n}");
            let lengths = [found.bridge, plain.bridge].map(value);
            assert!(lengths[0].zip(lengths[1]).is_none_or(|(a, b)| (a - b).abs() <= 0.05 * b), "{n}: {lengths:?}");
        }
    }

    #[test]
    fn discs_and_ledges() {
        let n = 48;
        let disc: Vec<Point> = (0..n)
            .map(|i| (std::f64::consts::TAU * i as f64 / n as f64).sin_cos())
            .map(|(s, c)| [6.0 * c, 6.0 * s])
            .collect();
        // The shortest line through the middle runs across two sides.
        holds(
            region(&disc, &[true], 0.0, [0.0; 2]).spans(ledge(0.0), Search::Measure).bridge,
            12.0 * 3.75f64.to_radians().cos(),
            0.06,
        );
        // A ledge of 0.4 mm along a wall of 30 mm is held by the wall.
        let narrow = region(&rectangle(30.0, 0.4), &[true, false, false, false], 0.3, [1.0; 2]);
        let none = narrow.spans(ledge(0.5), Search::Measure);
        assert_eq!((none.bridge, none.cantilever), (None, None));
        // Squares follow the length of the strip: those of the last round are a sixteenth of its width.
        holds(narrow.spans(ledge(0.0), Search::Measure).cantilever, 0.4, 0.1);
    }

    /// The corners of a circle about the origin, `n` of them.
    fn circle(n: usize, radius: f64) -> Vec<Point> {
        let corner = |i: usize| (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
        (0..n).map(corner).map(|(s, c)| [radius * c, radius * s]).collect()
    }

    /// What lies between two circles of `n` sides each, the inner and the outer one anchored or free.
    fn ring(n: usize, radii: [f64; 2], anchored: [bool; 2]) -> Plan {
        let [inner, outer] = radii.map(|r| circle(n, r));
        let side = |c: &[Point], from: usize, to: usize, anchored| Side { from: c[from % n], to: c[to % n], anchored };
        let sides =
            (0..n).flat_map(|i| [side(&inner, i + 1, i, anchored[0]), side(&outer, i, i + 1, anchored[1])]).collect();
        Plan::new(sides, 1e-9).unwrap()
    }

    #[test]
    fn a_groove_that_runs_round_is_spanned_straight_across_however_many_sides_it_has() {
        for n in [64, 256, 720] {
            let spans = ring(n, [5.0, 14.9], [true; 2]).spans(ledge(0.4), Search::Measure);
            let bridge = spans.bridge.unwrap();
            let least = 9.9 * (std::f64::consts::PI / n as f64).cos();
            // Squares are left as they are within a percent; of very many sides the effort leaves more.
            let high = if n < 720 { 1.011 * 9.9 } else { 1.03 * 9.9 };
            assert!(bridge.low > 0.99 * least && bridge.low <= 1.002 * 9.9 && bridge.high <= high, "{n}: {bridge:?}");
            assert_eq!(spans.cantilever, None, "{n}");
        }
    }

    #[test]
    fn beside_a_free_hole_each_place_has_a_strand_along_one_side_of_its_corner() {
        // Square rooms of 1.95 and of 9.9 with a square hole in the middle, turned: strands pass the hole on either side.
        let root = 2f64.sqrt();
        for (room, hole) in [(1.95, 0.4), (9.9, 2.0), (9.9, 0.05)] {
            for turn in [0.0, 0.4, 1.1] {
                let mut plan = ring(4, [0.5 * root * hole, 0.5 * root * room], [false, true]);
                let (s, c) = f64::sin_cos(turn);
                let at = |p: Point| [c * p[0] - s * p[1], s * p[0] + c * p[1]];
                let sides = plan.sides.all().iter().map(|s| Side { from: at(s.from), to: at(s.to), ..*s });
                plan = Plan::new(sides.collect(), 1e-9).unwrap();
                let spans = plan.spans(ledge(0.1), Search::Measure);
                holds(spans.bridge, room, 0.011 * room);
                assert_eq!(spans.cantilever, None, "{room} {turn}");
            }
        }
    }

    #[test]
    fn a_ledge_that_runs_round_reaches_as_far_as_it_is_wide() {
        for n in [64, 256] {
            let spans = ring(n, [2.0, 8.0], [true, false]).spans(ledge(0.4), Search::Measure);
            assert_eq!(spans.bridge, None, "{n}");
            holds(spans.cantilever, 6.0, 0.04);
        }
    }

    #[test]
    fn a_ledge_as_wide_as_its_limit_is_told_from_a_wider_one() {
        for (n, width) in [0.39, 0.399, 0.4, 0.401, 0.41].into_iter().enumerate() {
            let narrow = region(&rectangle(30.0, width), &[true, false, false, false], 0.3 + n as f64, [1.0; 2]);
            let found = narrow.spans(ledge(0.4 + 1e-6), Search::Measure).cantilever;
            assert_eq!(found.is_some(), width > 0.4, "{width}: {found:?}");
            assert!(
                found.is_none_or(|f| f.low > 0.4 && f.low <= width && width <= f.high + 1e-9),
                "{width}: {found:?}"
            );
        }
    }

    #[test]
    fn a_lip_round_a_hole_as_wide_as_its_limit_is_told_from_a_wider_one() {
        let tell = Search::Tell { beyond: [0.0; 2], pairs: 60_000_000 };
        for n in [16, 64, 256] {
            for width in [0.4995, 0.5, 0.501] {
                // Sides are parallel, so that no place is farther from the wall than the lip is wide.
                let inner = 8.0 - width / (std::f64::consts::PI / n as f64).cos();
                let spans = ring(n, [inner, 8.0], [false, true]).spans(ledge(0.5 + 1e-6), tell);
                let found = spans.bridge.or(spans.cantilever);
                assert_eq!(found.is_some_and(|f| f.low > 0.0), width > 0.5, "{n} {width}: {spans:?}");
                assert_eq!(found.is_some(), width > 0.5, "{n} {width}: {spans:?}");
            }
        }
    }

    #[test]
    fn what_lies_beyond_a_strand_reaches_out_from_the_strand() {
        let mut rng = Lcg(23);
        for _ in 0..12 {
            let (turn, shift) = (std::f64::consts::TAU * rng.unit(), [9.0 * rng.unit(), 9.0 * rng.unit()]);
            let (span, deep, out) = (6.0 + 6.0 * rng.unit(), 1.0 + 3.0 * rng.unit(), 2.0 + 9.0 * rng.unit());
            // A bar between two anchors with an arm from its middle.
            let (a, b) = (0.4 * span, 0.6 * span);
            let corners = [
                [0.0, 0.0],
                [span, 0.0],
                [span, deep],
                [b, deep],
                [b, deep + out],
                [a, deep + out],
                [a, deep],
                [0.0, deep],
            ];
            let held = [false, true, false, false, false, false, false, true];
            let spans = region(&corners, &held, turn, shift).spans(ledge(0.0), Search::Measure);
            holds(spans.cantilever, out, 0.03);
            holds(spans.bridge, span, 0.03);
            // The bar's edge bulges as a round body does: no more than the sagitta lies beyond the last strand.
            let (radius, half) = (2.0 * span, 0.5 * span);
            let bulge = |n: i32| {
                let x = half * f64::from(n) / 8.0;
                [half - x, deep + (radius * radius - x * x).sqrt() - (radius * radius - half * half).sqrt()]
            };
            let corners: Vec<Point> = [[0.0, 0.0], [span, 0.0]].into_iter().chain((-8..=8).map(bulge)).collect();
            let held: Vec<bool> = (0..corners.len()).map(|n| n == 1 || n + 1 == corners.len()).collect();
            let sagitta = bulge(0)[1] - deep;
            let plan = region(&corners, &held, turn, shift);
            holds(plan.spans(ledge(0.0), Search::Measure).cantilever, sagitta, 0.1);
            assert_eq!(plan.spans(ledge(1.01 * sagitta), Search::Measure).cantilever, None);
        }
    }

    #[test]
    fn a_pocket_with_two_arms_is_bridged_across_its_arms() {
        let pocket = [[0.0, 0.0], [30.0, 0.0], [30.0, 4.0], [4.0, 4.0], [4.0, 30.0], [0.0, 30.0]];
        let spans = region(&pocket, &[true], 0.2, [3.0, 1.0]).spans(ledge(0.0), Search::Measure);
        // In the corner the shortest line is one across the inner corner: longer than an arm is wide, shorter than the diagonal.
        let f = spans.bridge.unwrap();
        assert!(f.low >= 4.0 - 1e-6 && f.high < 7.5, "{f:?}");
    }

    #[test]
    fn a_cantilever_round_corners_is_as_long_as_the_way_to_its_anchor() {
        let mut rng = Lcg(5);
        for _ in 0..12 {
            let (turn, shift) = (std::f64::consts::TAU * rng.unit(), [9.0 * rng.unit(), 9.0 * rng.unit()]);
            let (a, b, w) = (12.0 + 8.0 * rng.unit(), 9.0 + 8.0 * rng.unit(), 1.0 + 2.0 * rng.unit());
            // An angle of two arms held at the end of one.
            let angle = [[0.0, 0.0], [a, 0.0], [a, w], [w, w], [w, b], [0.0, b]];
            let held = |of: usize, n: usize| (0..n).map(|i| i == of).collect::<Vec<bool>>();
            let spans = region(&angle, &held(1, 6), turn, shift).spans(ledge(0.0), Search::Measure);
            assert_eq!(spans.bridge, None);
            holds(spans.cantilever, (a - w) + w.hypot(b - w), 0.02);
            // Two arms beside each other with a slit between them, which the crow flies over.
            let (half, slit) = (0.5 * w, 0.05 + 0.1 * rng.unit());
            let (low, high) = (w - slit, w + slit);
            let folded = [
                [0.0, 0.0],
                [a, 0.0],
                [a, 2.0 * w],
                [0.0, 2.0 * w],
                [0.0, high],
                [a - half, high],
                [a - half, low],
                [0.0, low],
            ];
            let spans = region(&folded, &held(7, 8), turn, shift).spans(ledge(0.0), Search::Measure);
            assert_eq!(spans.bridge, None);
            holds(spans.cantilever, (a - half) + 2.0 * slit + (a - half).hypot(w - slit), 0.02);
        }
    }
}
