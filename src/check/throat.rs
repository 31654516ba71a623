//! Whether a ball fits into a chamber, and gets out of it: told on finer grids about the narrowest place of its way alone.

use super::budget::Budget;
use super::finding::{Bracket, Limits};
use super::void::{HALF_DIAGONAL, Trapped, Voids};
use crate::distance::squared_distance;
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::vector::{Vec3, add, along, sub, unit};
use crate::grid::Grid;
use crate::topology::{Adjacency, Components, components};
use crate::units::Length;

/// Windows about a throat, in turn: half the edge in diameters of the ball, beyond both ends of a throat as long as the ball or
/// three times as long; and the spacing in that of the whole grid, a half at most.
const WINDOWS: [(f64, f64); 4] = [(0.75, 0.5), (0.75, 0.25), (1.75, 0.5), (1.75, 0.25)];

/// The samples that a ball may stand on for certain, and from where to their neighbours along the axes.
struct Stands {
    grid: Grid,
    parts: Components,
}

impl Stands {
    /// By the squared clearance, and by the surface itself where that leaves it open and `free` tells; none outside the box.
    ///
    /// What the part touches lies within half a diagonal of the samples that stand for it, and half a spacing more lets the ball
    /// go on to the next sample. `free` says whether nothing of the surface is within a distance of a point.
    fn of(
        clearance: &Field<u32>,
        ball_mm: f64,
        [lo, hi]: [Vec3; 2],
        free: Option<&(dyn Fn(Vec3, f64) -> bool + Sync)>,
    ) -> Self {
        let grid = *clearance.grid();
        let needed = 0.5 * ball_mm / grid.h() + 0.5;
        let squares = |root: f64| (root.max(0.0) * root.max(0.0)).ceil() as u32;
        let (least, perhaps) = (squares(needed + HALF_DIAGONAL), squares(needed - HALF_DIAGONAL));
        let own = Indicator::from_predicate(grid, |at| {
            let c = clearance.values()[at];
            if c < perhaps || c == 0 {
                return false;
            }
            let p = grid.position(grid.index(at));
            let within = (0..3).all(|a| lo[a] <= p[a] && p[a] <= hi[a]);
            within && (c >= least || free.is_some_and(|free| free(p, needed * grid.h())))
        });
        Stands { grid, parts: components(&own, Adjacency::Face) }
    }

    fn at(&self, p: Vec3) -> Option<u32> {
        self.grid.sample_at(p).and_then(|index| self.parts.of(index))
    }

    /// Places of the samples in a box, each with its piece.
    fn each(&self, [lo, hi]: [Vec3; 2]) -> impl Iterator<Item = (Vec3, u32)> + '_ {
        let dims = self.grid.dims();
        let [first, last] = [lo, hi].map(|p| {
            let c = self.grid.continuous_index(p);
            [0, 1, 2].map(|a| c[a].round().clamp(0.0, dims[a] as f64 - 1.0) as usize)
        });
        let rows = (first[2]..=last[2]).flat_map(move |k| (first[1]..=last[1]).map(move |j| (j, k)));
        let samples = rows.flat_map(move |(j, k)| (first[0]..=last[0]).map(move |i| [i, j, k]));
        samples.filter_map(|index| Some((self.grid.position(index), self.parts.of(index)?)))
    }
}

/// What a part is on while something is let out of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ground {
    /// Nothing: a ball may leave downward.
    Nothing,
    /// The plate, at height 0, which caps the clearance too.
    Plate,
}

impl Voids<'_> {
    /// Whether a ball of this diameter gets from a chamber to the outside for certain.
    ///
    /// Where the whole grid leaves that open at the throat alone, grids up to four times finer about the throat are asked, each
    /// as far as the budget goes. A way has to lead over samples where the ball fits in any case, so that *yes* is a proof;
    /// *no* says nothing. On the plate the clearance is the one that it caps.
    ///
    /// # Cost
    /// O(samples) of the grid and of each window.
    pub(super) fn lets_out(
        &self,
        clearance: &Field<u32>,
        chamber: &Trapped,
        (ball_mm, ground): (f64, Ground),
        budget: &mut Budget,
    ) -> Result<bool> {
        let (part, h) = (self.part(), clearance.grid().h());
        let all = [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]];
        let whole = Stands::of(clearance, ball_mm, all, None);
        let (Some(throat), Some(inside)) = (chamber.throat, whole.at(chamber.at)) else { return Ok(false) };
        let out = whole.parts.at_border();
        if out[inside as usize] {
            return Ok(true);
        }
        let on_plate = ground == Ground::Plate;
        let free = |p: Vec3, within: f64| !(on_plate && p[2] < within) && part.distance().nearest(p, within).is_none();
        for (reach, finer) in WINDOWS.map(|(reach, finer)| ([reach * ball_mm; 3], finer * h)) {
            let window = [sub(throat, reach), add(throat, reach)];
            // What is nearer than the ball and the doubt lies within the padding.
            let pad = [0.5 * ball_mm + 3.0 * finer; 3];
            let (lo, hi) = (sub(window[0], pad), add(window[1], pad));
            let samples = (0..3).map(|a| ((hi[a] - lo[a]) / finer).ceil() + 1.0).product::<f64>() as u64;
            if !budget.allows(samples) {
                continue;
            }
            let Ok(solid) = part.window(lo, hi, Length::mm(finer)) else {
                budget.too_large += 1;
                continue;
            };
            budget.note(1, samples);
            let clear = squared_distance(&solid.outer)?;
            let clear = if on_plate { self.in_window(&solid).above_plate(&clear)? } else { clear };
            let near = Stands::of(&clear, ball_mm, window, Some(&free));
            // A sample of the window lies within half a diagonal of one of the whole grid; both leave room for that.
            let mut joined: Vec<[bool; 2]> = vec![[false; 2]; near.parts.count()];
            for (p, piece) in whole.each(window) {
                if let Some(by) = near.at(p).and_then(|l| joined.get_mut(l as usize)) {
                    *by = [by[0] || piece == inside, by[1] || out[piece as usize]];
                }
            }
            // Beyond the part's box a ball leaves along an axis; what gets there stands on the first samples beyond it.
            let faces = (0..6).map(|n| (n / 2, if n % 2 == 0 { 0.0 } else { part.extent()[n / 2] }));
            for (axis, at) in faces.filter(|face| !(on_plate && *face == (2, 0.0))) {
                let beyond = |p: Vec3| if at > 0.0 { p[axis] >= at } else { p[axis] <= at };
                let mut layer = window;
                layer[0][axis] = layer[0][axis].max(at - 2.0 * finer);
                layer[1][axis] = layer[1][axis].min(at + 2.0 * finer);
                if layer[0][axis] <= layer[1][axis] {
                    near.each(layer)
                        .filter(|(p, _)| beyond(*p))
                        .for_each(|(_, piece)| joined[piece as usize][1] = true);
                }
            }
            if joined.contains(&[true; 2]) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether a ball of this diameter fits into the widest place of a room: its middle is moved to where the surface is
    /// furthest.
    pub(super) fn has_room(&self, room: &Trapped, ball_mm: f64) -> bool {
        let surface = self.part().distance();
        let clear = |p: Vec3| surface.nearest(p, f64::INFINITY).map_or(f64::INFINITY, |n| n.distance);
        let wanted = 0.5 * (ball_mm - self.part().tie());
        let (mut p, mut step) = (room.at, 0.5 * self.solid.inner.grid().h());
        let (mut most, least_step) = (clear(p), 1e-4 * ball_mm);
        while most < wanted && step > least_step && most > 0.0 {
            let aside = (0..27).filter(|n| *n != 13).map(|n: i32| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1].map(f64::from));
            let moved = aside.map(|d| along(p, unit(d), step.min(0.5 * most))).map(|q| (clear(q), q));
            match moved.max_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((wider, q)) if wider > most => (most, p) = (wider, q),
                _ => step *= 0.5,
            }
        }
        most >= wanted
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
    use super::super::void::tests::{flask, part, turned};
    use super::*;
    use crate::random::Lcg;

    #[test]
    fn no_ball_wider_than_the_neck_gets_out_and_windows_let_out_what_the_whole_grid_leaves_open() {
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
            // With the surface itself only the step is left: half a spacing of the finest window, and as much for samples off the axis.
            let doubt = 2.0 * (0.5 + 2.0 * HALF_DIAGONAL) * 0.25 * h;
            assert!(out || ball > neck - doubt, "{case}: no ball of {ball} through a neck of {neck}, h {h}");
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
            let shut = voids.on_plate(&standing, 4.5, &mut voids.nothing()).unwrap();
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
