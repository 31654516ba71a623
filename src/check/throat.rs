//! Whether a ball fits into a chamber, and gets out of it: told by the surface itself about the narrowest place of its way alone.

use super::ball_way::{Beside, End, Lattice, MOST_ASKED, Met, Place, Search};
use super::budget::Budget;
use super::finding::{Bracket, Limits};
use super::void::{HALF_DIAGONAL, Trapped, Voids};
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::vector::{Vec3, along, distance, unit};
use crate::grid::Grid;
use crate::part::Part;
use crate::topology::{Adjacency, Components, components};
use std::ops::ControlFlow;

/// Steps of the lattices in the spacing of the whole grid, in turn.
const FINER: [f64; 3] = [0.5, 0.25, 0.125];
/// A way is followed as far from the throat, in diameters of the ball.
const FAR: f64 = 6.0;
/// A ball that is certainly stuck is narrower than the limit by this share of it.
const BELOW: f64 = 0.99;

/// The samples of a grid that a ball may stand on for certain, and from where to their neighbours along the axes.
pub(super) struct Stands {
    grid: Grid,
    parts: Components,
    /// Which pieces lie outside.
    out: Vec<bool>,
}

impl Stands {
    /// By the squared clearance: what the part touches lies within half a diagonal of the samples that stand for it, and half a
    /// spacing more lets the ball go on to the next sample.
    pub(super) fn of(clearance: &Field<u32>, ball_mm: f64) -> Self {
        let grid = *clearance.grid();
        let needed = 0.5 * ball_mm / grid.h() + 0.5 + HALF_DIAGONAL;
        let least = (needed * needed).ceil() as u32;
        let own = Indicator::from_predicate(grid, |at| clearance.values()[at] >= least);
        let parts = components(&own, Adjacency::Face);
        Stands { grid, out: parts.at_border(), parts }
    }

    /// The piece of the sample nearest to a point.
    pub(super) fn at(&self, p: Vec3) -> Option<u32> {
        self.grid.sample_at(p).and_then(|index| self.parts.of(index))
    }

    /// Whether a piece lies outside.
    pub(super) fn is_out(&self, piece: u32) -> bool {
        self.out.get(piece as usize).is_some_and(|&out| out)
    }

    /// All samples of the pieces outside.
    pub(super) fn outside(&self) -> Indicator {
        self.parts.select(|piece| self.is_out(piece))
    }

    /// The piece of the sample nearest to a point, its offset in storage and how far away it is.
    pub(super) fn beside(&self, p: Vec3) -> Option<(u32, usize, f64)> {
        let index = self.grid.sample_at(p)?;
        let piece = self.parts.of(index)?;
        Some((piece, self.grid.offset(index), distance(self.grid.position(index), p)))
    }
}

/// Whether nothing of a part's surface is so near to a point.
fn is_clear(part: &Part, p: Vec3, within_mm: f64) -> bool {
    let mut clear = true;
    part.distance().within(p, within_mm, |_| {
        clear = false;
        ControlFlow::Break(())
    });
    clear
}

/// What a part is on while something is let out of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ground {
    /// Nothing: a ball may leave downward.
    Nothing,
    /// The plate, at height 0, which caps the clearance too.
    Plate,
}

/// The ways of a ball beside a throat: where the whole grid has room for it, and over finer and finer lattices.
struct Ways<'a> {
    part: &'a Part,
    extent: Vec3,
    clearance: &'a Field<u32>,
    ball_mm: f64,
    on_plate: bool,
    whole: &'a Stands,
    /// The piece of the whole grid that lies in the chamber.
    inside: Option<u32>,
    /// The middle of the chamber.
    middle: Vec3,
    /// The searches over coarser lattices, each of half the step of the one before.
    coarser: Vec<Search>,
}

impl Ways<'_> {
    /// Which ends are met by a way over a lattice through the throat, and how many points were asked.
    fn followed(&mut self, throat: Vec3, step: f64) -> (Option<Met>, u64) {
        let h = self.clearance.grid().h();
        // What lies at both ends of the throat is told in the first step, so that finer ones need not go far.
        let reach = if self.coarser.is_empty() { (1.75 * self.ball_mm).clamp(h, 10.0 * h) } else { h };
        let reach = (reach / step).ceil() as i32;
        let (edge, close) = (2 * reach + 1, (h / step).ceil() as i32);
        let starts = (0..edge.pow(3)).map(|n| [n, n / edge, n / edge.pow(2)].map(|n| n % edge - reach));
        // Away from the throat what is wide enough to matter is met in strides.
        let starts = starts.filter(|at| at.iter().all(|x| x.abs() <= close) || at.iter().all(|x| x % 4 == 0));
        // Where there is a way through the throat it is met before what lies around the part.
        let mut starts: Vec<[i32; 3]> = starts.collect();
        starts.sort_by_key(|at| at.iter().map(|x| x * x).sum::<i32>());
        let mut search = Search::over(Lattice { origin: throat, step }, Beside::Face);
        let mut met = Some(Met::default());
        for start in starts {
            if met.is_some_and(|met| met != Met::BOTH) {
                met = search.met_from(start, &|p| match distance(p, throat) > FAR * self.ball_mm {
                    true => Place::Blocked,
                    false => self.place(p, step),
                });
            }
        }
        let asked = search.asked;
        self.coarser.push(search);
        (met, asked)
    }

    /// Whether the ball has room about a point with half a step to spare; what the whole grid tells to lie in the material is left out.
    fn stands(&self, p: Vec3, step: f64) -> bool {
        let (needed, grid) = (0.5 * (self.ball_mm + step), self.clearance.grid());
        let is_void = |at| self.clearance.values()[grid.offset(at)] > 0;
        // Where nothing of the surface is within a diagonal, the cube of the nearest sample lies on one side of it.
        let told = needed > 2.0 * HALF_DIAGONAL * grid.h();
        let buried = told && grid.sample_at(p).is_some_and(|at| !is_void(at));
        !(buried || self.on_plate && p[2] < needed) && is_clear(self.part, p, needed)
    }

    /// What is at a point of a lattice: an end also where points of coarser lattices lead to one, each with half its step to spare.
    fn place(&self, p: Vec3, step: f64) -> Place {
        if !self.stands(p, step) {
            return Place::Blocked;
        }
        let (mut p, mut step) = (p, step);
        let mut end = self.end(p, step);
        for search in self.coarser.iter().rev() {
            let Some((q, near)) = search.beside(p, step).filter(|_| end.is_none()) else { break };
            if !self.stands(q, search.step()) {
                break;
            }
            (p, step) = (q, search.step());
            end = near.or_else(|| self.end(p, step));
        }
        end.map_or(Place::Free, Place::End)
    }

    /// The end that a point with half a step to spare has reached, by where it is and by the whole grid.
    fn end(&self, p: Vec3, step: f64) -> Option<End> {
        let (extent, h) = (self.extent, self.clearance.grid().h());
        // Beyond the part's box a ball leaves along an axis, on the plate not downward.
        if (0..3).any(|a| p[a] > extent[a] || p[a] < 0.0 && !(self.on_plate && a == 2)) {
            return Some(End::Outside);
        }
        // A room that the whole grid has no sample for holds a ball about its middle.
        if distance(p, self.middle) <= step {
            return Some(End::Chamber);
        }
        let (piece, at, away) = self.whole.beside(p)?;
        let spare = h * (f64::from(self.clearance.values()[at]).sqrt() - HALF_DIAGONAL) - 0.5 * self.ball_mm;
        // Samples of the whole grid have half its spacing to spare, or more.
        match away <= spare.max(0.5 * h) + 0.5 * step {
            true if self.whole.out[piece as usize] => Some(End::Outside),
            true if Some(piece) == self.inside => Some(End::Chamber),
            _ => None,
        }
    }
}

impl Voids<'_> {
    /// Whether a ball of this diameter gets from a chamber to the outside for certain.
    ///
    /// Where the whole grid leaves that open, its middle is followed from the throat over finer and finer lattices, as far as the
    /// budget goes, until it stands where the whole grid has room for it. A way has to lead over points where the ball fits with half a
    /// step to spare, so that *yes* is a proof; *no* says nothing. On the plate the clearance is the one that it caps.
    ///
    /// # Cost
    /// O(samples) of the grid, and a distance for each point beside the way that the grid has no room for.
    pub(super) fn lets_out(
        &self,
        clearance: &Field<u32>,
        chamber: &Trapped,
        (ball_mm, ground): (f64, Ground),
        budget: &mut Budget,
    ) -> Result<bool> {
        let Some(throat) = chamber.throat else { return Ok(false) };
        let whole = Stands::of(clearance, ball_mm);
        Ok(self.is_let_out((clearance, &whole), (chamber.at, throat), (ball_mm, ground), budget))
    }

    /// As [`Voids::lets_out`], from the middle of a chamber through its throat, where the stands of the ball are known.
    pub(super) fn is_let_out(
        &self,
        (clearance, whole): (&Field<u32>, &Stands),
        (middle, throat): (Vec3, Vec3),
        (ball_mm, ground): (f64, Ground),
        budget: &mut Budget,
    ) -> bool {
        let inside = whole.at(middle);
        if inside.is_some_and(|l| whole.out[l as usize]) {
            return true;
        }
        let on_plate = ground == Ground::Plate;
        let (part, extent, coarser) = (self.part(), self.part().extent(), Vec::new());
        let mut ways = Ways { part, extent, clearance, ball_mm, on_plate, whole, inside, middle, coarser };
        for step in FINER.map(|f| f * clearance.grid().h()) {
            if !budget.allows(MOST_ASKED) {
                break;
            }
            let (met, asked) = ways.followed(throat, step);
            budget.note(1, asked);
            if met == Some(Met::BOTH) {
                return true;
            }
        }
        false
    }

    /// Whether a ball of this diameter fits into the widest place of a room.
    pub(super) fn has_room(&self, room: &Trapped, ball_mm: f64) -> bool {
        self.widest_about(room.at, f64::INFINITY, ball_mm).0 >= ball_mm - self.part().tie()
    }

    /// Diameter and middle of a ball that touches the surface at most, moved from a point to where it is wider until it is as wide
    /// as wanted or its middle would leave the reach.
    pub(super) fn widest_about(&self, from: Vec3, reach_mm: f64, wanted_mm: f64) -> (f64, Vec3) {
        let surface = self.part().distance();
        let clear = |p: Vec3| surface.nearest(p, f64::INFINITY).map_or(f64::INFINITY, |n| n.distance);
        let wanted = 0.5 * (wanted_mm - self.part().tie());
        let (mut p, mut step) = (from, (0.5 * self.solid.inner.grid().h()).min(reach_mm));
        let (mut most, least_step) = (clear(p), 1e-4 * wanted_mm);
        while most < wanted && step > least_step && most > 0.0 {
            let aside = (0..27).filter(|n| *n != 13).map(|n: i32| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1].map(f64::from));
            let moved =
                aside.map(|d| along(p, unit(d), step.min(0.5 * most))).filter(|q| distance(*q, from) <= reach_mm);
            match moved.map(|q| (clear(q), q)).max_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((wider, q)) if wider > most => (most, p) = (wider, q),
                _ => step *= 0.5,
            }
        }
        (2.0 * most, p)
    }

    /// Raises the low end of a chamber's way out to the limits that a ball is known to pass.
    ///
    /// # Errors
    /// As [`Voids::lets_out`].
    pub(super) fn open_for_certain(
        &self,
        clearance: &Field<u32>,
        chamber: &mut Trapped,
        limits: Limits,
        budget: &mut Budget,
    ) -> Result<()> {
        for limit in limits.fail.into_iter().chain(limits.warn) {
            let Bracket { value, low, high } = chamber.way_out_mm;
            if low >= limit || high < limit || !self.part().health().is_solid() {
                continue;
            }
            // Where one ball is stuck, so is a wider one.
            if !self.lets_out(clearance, chamber, (limit, Ground::Nothing), budget)? {
                break;
            }
            chamber.way_out_mm = Bracket { value: value.max(limit), low: limit, high };
        }
        Ok(())
    }

    /// Lowers the high end of a chamber's way out below the limits that no ball gets past for certain: as [`Voids::is_barred`] tells,
    /// or as its middle is followed from the widest place and gets nowhere.
    ///
    /// # Errors
    /// As [`Voids::is_barred`].
    pub(super) fn shut_for_certain(
        &self,
        clearance: &Field<u32>,
        chamber: &mut Trapped,
        limits: Limits,
        budget: &mut Budget,
    ) -> Result<()> {
        for limit in limits.warn.into_iter().chain(limits.fail) {
            let (Bracket { value, low, high }, ball) = (chamber.way_out_mm, BELOW * limit);
            if low >= ball || high < limit || !self.part().health().is_solid() {
                continue;
            }
            if self.is_barred(clearance, chamber, ball, budget)? || self.gets_nowhere(chamber, ball, budget) {
                let neck = chamber.throat.map(|t| self.widest_about(t, HALF_DIAGONAL * self.spacing_mm(), ball).0);
                chamber.way_out_mm = Bracket { value: neck.unwrap_or(value).clamp(low, ball), low, high: ball };
            }
        }
        Ok(())
    }

    /// Whether the middle of a ball, followed from the widest place of a chamber over a lattice, wherever it may stand by half a diagonal,
    /// gets nowhere.
    ///
    /// # Cost
    /// A distance for each point that it may stand on, up to [`MOST_ASKED`] for each lattice.
    fn gets_nowhere(&self, chamber: &Trapped, ball_mm: f64, budget: &mut Budget) -> bool {
        let extent = self.part().extent();
        let (wide, middle) = self.widest_about(chamber.at, f64::INFINITY, ball_mm / BELOW);
        for step in FINER.map(|f| f * self.spacing_mm()) {
            if wide < ball_mm || !budget.allows(MOST_ASKED) {
                break;
            }
            let needed = (0.5 * ball_mm - HALF_DIAGONAL * step).max(0.0);
            let place = |p: Vec3| {
                if (0..3).any(|a| p[a] > extent[a] || p[a] < 0.0) {
                    Place::End(End::Outside)
                } else if is_clear(self.part(), p, needed) {
                    Place::Free
                } else {
                    Place::Blocked
                }
            };
            let mut search = Search::over(Lattice { origin: middle, step }, Beside::Corner);
            let met = search.met_from([0; 3], &place);
            budget.note(1, search.asked);
            if met == Some(Met::default()) {
                return true;
            }
        }
        false
    }

    /// Those of the places that the plate closes from which no ball of the limit is known to get out; the clearance is the one that
    /// the plate caps.
    ///
    /// # Errors
    /// As [`Voids::lets_out`].
    pub(super) fn still_shut(
        &self,
        standing: &Field<u32>,
        places: Vec<Trapped>,
        limit_mm: f64,
        budget: &mut Budget,
    ) -> Result<Vec<Trapped>> {
        let mut left = Vec::new();
        for t in places {
            let is_doubtful = t.way_out_mm.high >= limit_mm && self.part().health().is_solid();
            if !(is_doubtful && self.lets_out(standing, &t, (limit_mm, Ground::Plate), budget)?) {
                left.push(t);
            }
        }
        Ok(left)
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::Sense;
    use super::super::void::tests::{flask, part, turned};
    use super::*;
    use crate::random::Lcg;

    #[test]
    fn no_ball_wider_than_the_neck_gets_out_and_what_the_whole_grid_leaves_open_is_decided() {
        let mut rng = Lcg(41);
        let (mut passed, mut in_doubt) = (0, 0);
        for case in 0..120 {
            let neck = 1.5 + 2.0 * rng.unit();
            let ball = neck * (0.75 + 0.3 * rng.unit());
            let mesh = turned(&flask(8.0, 5.0, neck), || rng.unit());
            let h = 0.25 + 0.1 * rng.unit();
            let part = part(mesh, h, [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let clearance = voids.clearance().unwrap();
            let chambers = voids.narrow(&clearance, 4.5, &mut voids.nothing()).unwrap();
            let Some(chamber) = chambers.first() else { continue };
            let mut budget = Budget::of(1 << 24);
            let out = voids.lets_out(&clearance, chamber, (ball, Ground::Nothing), &mut budget).unwrap();
            assert!(!out || ball <= neck, "{case}: a ball of {ball} through a neck of {neck}");
            // Only the finest step is left: half of it to spare, and half a diagonal for points off the axis.
            let doubt = 2.0 * (0.5 + HALF_DIAGONAL) * 0.125 * h;
            assert!(out || ball > neck - doubt, "{case}: no ball of {ball} through a neck of {neck}, h {h}");
            let limits = Limits { fail: Some(ball), warn: None, sense: Sense::Min };
            let mut shut = chamber.clone();
            voids.shut_for_certain(&clearance, &mut shut, limits, &mut budget).unwrap();
            assert!(
                shut.way_out_mm.high >= neck && shut.way_out_mm.low <= neck,
                "{case}: {:?} of {neck}",
                shut.way_out_mm
            );
            let doubt = 2.0 * HALF_DIAGONAL * 0.125 * h;
            assert!(
                shut.way_out_mm.high < ball || BELOW * ball < neck + doubt,
                "{case}: {ball} is not stuck in {neck}"
            );
            passed += usize::from(out);
            in_doubt += usize::from(out && ball > chamber.way_out_mm.low);
        }
        assert!(passed > 15 && in_doubt > 15, "{passed} {in_doubt}");
    }

    #[test]
    fn without_a_budget_nothing_is_looked_at() {
        let part = part(flask(8.0, 5.0, 2.0), 0.3, [0.0; 3]);
        let voids = Voids::of(&part).unwrap();
        let clearance = voids.clearance().unwrap();
        let chambers = voids.narrow(&clearance, 4.5, &mut voids.nothing()).unwrap();
        let mut budget = Budget::of(1000);
        assert!(!voids.lets_out(&clearance, &chambers[0], (1.95, Ground::Nothing), &mut budget).unwrap());
        assert_eq!((budget.looks, budget.left), (0, 1000));
        let mut budget = Budget::of(1 << 24);
        assert!(
            voids.lets_out(&clearance, &chambers[0], (1.8, Ground::Nothing), &mut budget).unwrap() && budget.looks > 0
        );
    }

    #[test]
    fn on_the_plate_nothing_leaves_through_a_neck_below() {
        let upright = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let over = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        for (axes, leaves_the_plate) in [(upright, true), (over, false)] {
            let part = part(flask(8.0, 5.0, 3.0).transformed(axes, [0.0; 3]), 0.3, [0.1, 0.2, 0.3]);
            let voids = Voids::of(&part).unwrap();
            let clearance = voids.clearance().unwrap();
            let standing = voids.above_plate(&clearance).unwrap();
            let mut budget = Budget::of(1 << 24);
            let free = voids.narrow(&clearance, 4.5, &mut voids.nothing()).unwrap();
            assert!(voids.lets_out(&clearance, &free[0], (2.8, Ground::Nothing), &mut budget).unwrap());
            let shut = voids.on_plate(&standing, 4.5).unwrap();
            let out = voids.lets_out(&standing, &shut[0], (2.8, Ground::Plate), &mut budget).unwrap();
            assert_eq!(out, leaves_the_plate);
        }
    }

    #[test]
    fn room_is_measured_on_the_surface_itself() {
        // A cube of 3.6 mm a side takes a ball of 3.6 mm, wherever the lattice stands.
        let mut rng = Lcg(74);
        for case in 0..8 {
            let mesh = turned(&flask(8.0, 3.6, 1.0), || rng.unit());
            let part = part(mesh, 0.15 + 0.1 * rng.unit(), [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let clearance = voids.clearance().unwrap();
            let rooms = voids.small_rooms(&clearance, 4.0, &mut voids.nothing()).unwrap();
            assert_eq!(rooms.len(), 1, "{case}");
            assert!(voids.has_room(&rooms[0], 3.59) && !voids.has_room(&rooms[0], 3.61), "{case}");
        }
    }
}
