//! Whether a ball is stuck in a chamber: what the grid leaves open at narrow places is ruled out by the surface itself.

use super::ball_way::MOST_ASKED;
use super::budget::Budget;
use super::void::{HALF_DIAGONAL, Trapped, Voids};
use crate::error::Result;
use crate::field::Field;
use crate::geometry::vector::Vec3;
use crate::topology::{Chamber, Side, border, chambers};

/// Narrow places that are looked at one after another.
const MOST_PLACES: usize = 32;
/// Samples on each side of a narrow place that are looked at with it.
const REACH: isize = 3;
/// A search for chambers counts as one sample of so many.
const SEARCHED: u64 = 8;
/// How often the cube of a sample is halved.
const HALVINGS: u32 = 4;

impl Voids<'_> {
    /// Whether no ball of this diameter gets from a chamber to the outside for certain.
    ///
    /// A ball may have its middle in the cube of a sample whose clearance is less than its radius by two half diagonals. Where such
    /// samples lead out, the cubes at the throat are halved four times, and a sample is ruled out if every part lies so near to the surface
    /// that no ball has its middle in it; then the next throat is looked at, for as many as there are. A ball with a radius of less than two half
    /// diagonals may have its middle in cubes that the part touches, too. *Yes* is a proof; *no* says nothing.
    ///
    /// # Cost
    /// For each throat a search for chambers, and a distance for each cube that is halved, up to [`MOST_ASKED`].
    pub(super) fn is_barred(
        &self,
        clearance: &Field<u32>,
        chamber: &Trapped,
        ball_mm: f64,
        budget: &mut Budget,
    ) -> Result<bool> {
        let (grid, radius) = (*clearance.grid(), 0.5 * ball_mm / self.spacing_mm());
        let Some(start) = grid.sample_at(chamber.at).map(|index| grid.offset(index)) else { return Ok(false) };
        let squared = |r: f64| ((r.max(0.0) * r.max(0.0)).ceil() as u32).max(1);
        let least = squared(radius - 2.0 * HALF_DIAGONAL);
        let mut left = clearance.clone();
        if radius < 2.0 * HALF_DIAGONAL {
            self.open_touched(&mut left, least);
        }
        let level = squared(radius + 2.0 * HALF_DIAGONAL).min(left.values()[start]);
        if level <= least {
            return Ok(false);
        }
        for _ in 0..MOST_PLACES {
            let Some(room) = self.room_about(&left, (start, level), budget)? else { return Ok(false) };
            let Some(throat) = room.throat.filter(|throat| throat.clearance >= least) else { return Ok(true) };
            if !budget.allows(MOST_ASKED) {
                return Ok(false);
            }
            let asked = self.rule_out(&mut left, grid.index(throat.at), least, 0.5 * ball_mm);
            budget.note(1, asked);
            if left.values()[throat.at] > 0 {
                return Ok(false);
            }
        }
        Ok(false)
    }

    /// Gives the samples in whose cubes are both void and material a clearance.
    fn open_touched(&self, left: &mut Field<u32>, least: u32) {
        let grid = *left.grid();
        let (outer, inner) = (&self.solid.outer, &self.solid.inner);
        let touched = outer.iter().filter(|&at| !inner.contains(grid.index(at)));
        touched.for_each(|at| left.values_mut()[at] = least);
    }

    /// The chamber that holds a sample, shut at a level of clearance; `None` if it is open there, or the budget does not allow a search.
    ///
    /// # Errors
    /// As [`chambers`].
    ///
    /// # Cost
    /// That of [`chambers`]; an eighth of the grid's samples of the budget.
    pub(super) fn room_about(
        &self,
        clearance: &Field<u32>,
        (at, level): (usize, u32),
        budget: &mut Budget,
    ) -> Result<Option<Chamber>> {
        let cost = clearance.grid().samples() as u64 / SEARCHED;
        if !budget.allows(cost) {
            return Ok(None);
        }
        budget.note(0, cost);
        let found = chambers(clearance, &border(clearance.grid(), &Side::ALL), level, |_| false)?;
        Ok(found.into_iter().find(|room| room.holds(at)))
    }

    /// Takes away the samples about one in whose cubes no ball has its middle, one by one while distances may be asked; how many were.
    fn rule_out(&self, left: &mut Field<u32>, about: [usize; 3], least: u32, radius_mm: f64) -> u64 {
        let (grid, mut asked) = (*left.grid(), 0);
        let edge = 2 * REACH + 1;
        let offsets = (0..edge.pow(3)).map(|n| [n, n / edge, n / edge.pow(2)].map(|n| n % edge - REACH));
        for offset in offsets {
            let index = [0, 1, 2].map(|a| about[a].checked_add_signed(offset[a]).filter(|&x| x < grid.dims()[a]));
            let [Some(i), Some(j), Some(k)] = index else { continue };
            let at = grid.offset([i, j, k]);
            if left.values()[at] >= least {
                let cube = Cube { middle: grid.position([i, j, k]), half: 0.5 * grid.h() };
                if !self.may_hold(cube, radius_mm, HALVINGS, &mut asked) {
                    left.values_mut()[at] = 0;
                }
            }
        }
        asked
    }

    /// Whether a ball may have its middle in a cube of void, for all that halving it so often tells.
    fn may_hold(&self, cube: Cube, radius_mm: f64, halvings: u32, asked: &mut u64) -> bool {
        *asked += 1;
        let away = self.part().distance().nearest(cube.middle, f64::INFINITY).map_or(f64::INFINITY, |n| n.distance);
        let doubt = 2.0 * HALF_DIAGONAL * cube.half;
        if away + doubt < radius_mm {
            return false;
        }
        // A ball that has its middle there is in nobody's way, and where nothing more is asked it may be.
        if away >= radius_mm || halvings == 0 || *asked > MOST_ASKED {
            return true;
        }
        cube.eighths().any(|part| self.may_hold(part, radius_mm, halvings - 1, asked))
    }
}

/// A cube by its middle and half its edge, millimetres.
#[derive(Debug, Clone, Copy)]
struct Cube {
    middle: Vec3,
    half: f64,
}

impl Cube {
    fn eighths(self) -> impl Iterator<Item = Cube> {
        let half = 0.5 * self.half;
        (0..8).map(move |n: usize| {
            let middle = [0, 1, 2].map(|a| self.middle[a] + if n >> a & 1 == 1 { half } else { -half });
            Cube { middle, half }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::void::tests::{flask, part, turned};
    use super::*;
    use crate::random::Lcg;

    #[test]
    fn what_is_stuck_in_a_large_chamber_is_known_and_nothing_else() {
        let mut rng = Lcg(7);
        let mut barred = 0;
        for case in 0..40 {
            let neck = 2.0 + rng.unit();
            let ball = neck * (0.95 + 0.15 * rng.unit());
            let h = 0.15 + 0.1 * rng.unit();
            let mesh = turned(&flask(15.0, 11.0, neck), || rng.unit());
            let part = part(mesh, h, [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let clearance = voids.clearance().unwrap();
            let chambers = voids.narrow(&clearance, ball, &mut voids.nothing()).unwrap();
            let Some(chamber) = chambers.first() else { continue };
            let mut budget = Budget::of(1 << 26);
            let is_barred = voids.is_barred(&clearance, chamber, ball, &mut budget).unwrap();
            assert!(!is_barred || ball >= neck, "{case}: a ball of {ball} is not stuck in {neck}");
            // What is left of a cube is half a diagonal of its last halves away.
            let doubt = 2.0 * HALF_DIAGONAL * h / 16.0;
            assert!(
                is_barred || ball <= neck + doubt,
                "{case}: a ball of {ball} is stuck in {neck}, h {h}: {budget:?}"
            );
            barred += usize::from(is_barred);
        }
        assert!(barred > 15, "{barred}");
    }

    #[test]
    fn what_gets_out_of_a_hole_of_a_few_samples_is_not_stuck() {
        let mut rng = Lcg(8);
        let (mut asked, mut barred) = (0, 0);
        for case in 0..60 {
            let neck = 1.6 + 1.6 * rng.unit();
            let ball = neck * (0.5 + 0.8 * rng.unit());
            let h = (0.4 + 0.4 * rng.unit()) * neck;
            let mesh = match case % 2 {
                0 => flask(18.0, 12.0, neck),
                _ => turned(&flask(18.0, 12.0, neck), || rng.unit()),
            };
            let part = part(mesh, h, [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let clearance = voids.clearance().unwrap();
            let chambers = voids.narrow(&clearance, ball, &mut voids.nothing()).unwrap();
            let Some(chamber) = chambers.first() else { continue };
            let is_barred = voids.is_barred(&clearance, chamber, ball, &mut Budget::of(1 << 26)).unwrap();
            assert!(!is_barred || ball >= neck, "{case}: a ball of {ball} is not stuck in {neck}, h {h}");
            asked += 1;
            barred += usize::from(is_barred);
        }
        assert!(asked > 30 && barred > 3, "{asked} {barred}");
    }
}
