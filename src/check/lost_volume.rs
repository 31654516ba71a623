//! How much of a place is lost, told from the limit in finer windows.

use super::budget::Budget;
use super::detail::Detail;
use super::finding::Limits;
use super::trial::Trial;
use crate::error::Result;
use crate::geometry::vector::{Vec3, distance};
use crate::morphology::Bead;
use crate::part::Part;
use crate::units::Length;

/// Cells along the width and the height of the element, level by level.
const DIVISIONS: [(usize, usize); 5] = [(10, 6), (16, 10), (24, 16), (32, 21), (48, 32)];
/// Cells of a finer look at a whole place at most: four bytes each while its pieces are told apart.
const MOST_CELLS: u64 = 1 << 25;
/// Cells along a window on a part of a place that is larger, with the element's width on either side.
const WINDOW_CELLS: usize = 200;

/// A volume between two numbers, mm³: estimate, lower and upper bound.
pub(super) type Volumes = [f64; 3];

/// A place that may be lost, and what is sought of it.
pub(super) struct LostPlace<'a> {
    pub part: &'a Part,
    pub bead: Bead,
    pub limits: Limits,
    pub detail: &'a Detail,
    /// Width of the cells that its volume was counted on.
    pub cell: Length,
}

impl LostPlace<'_> {
    /// The bounds of the lost volume, narrowed on finer and finer cells until every limit is told from them or the budget ends.
    ///
    /// The place is counted as a whole while there is room for that. One that is larger and seems to be above a limit is taken window by
    /// window, those at its thinnest first, until what is lost for certain adds up to more.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    ///
    /// # Cost
    /// The samples that the budget notes, at some 20 ns each.
    pub fn told(&self, mut known: Volumes, budget: &mut Budget) -> Result<Volumes> {
        let finer = |(wide, _): &&(usize, usize)| self.bead.width.as_mm() / (*wide as f64) < 0.9 * self.cell.as_mm();
        for &division in DIVISIONS.iter().filter(finer) {
            let Some(limit) = self.open_limit(known) else { break };
            let (asked, detail) = ((division, MOST_CELLS.min(budget.left)), self.detail);
            if let Some(counted) = Trial::opened_on(self.part, self.bead, detail.extent, asked)? {
                budget.note(1, counted.cells());
                // Each level has a disc of whole cells of its own: bounds of two levels do not bound one volume.
                known = counted.lost()?;
            } else if known[0] > limit {
                let lost = self.lost_in_windows(division, limit, budget)?;
                known = [known[0].max(lost), known[1].max(lost), known[2].max(lost)];
            }
        }
        Ok(known)
    }

    /// A limit that the bounds do not tell; the least of them.
    fn open_limit(&self, [_, low, high]: Volumes) -> Option<f64> {
        let limits = self.limits.fail.into_iter().chain(self.limits.warn);
        limits.filter(|&limit| low <= limit && limit < high).reduce(f64::min)
    }

    /// What is lost for certain in windows on the place, until it is more than a limit.
    fn lost_in_windows(&self, division: (usize, usize), limit: f64, budget: &mut Budget) -> Result<f64> {
        let (thin, cell) = (&self.detail.thinnest, self.bead.width.as_mm() / division.0 as f64);
        let missing = self.bead.width_along(thin.direction()).as_mm() - thin.diameter;
        // The outer set is up to two cells thicker than the sheet and has to be thinner than the element all the same.
        if 2.0 * cell >= missing {
            return Ok(0.0);
        }
        let side = cell * (WINDOW_CELLS - 2 * (division.0 + 4)) as f64;
        let mut lost = 0.0;
        for window in self.windows(side) {
            let asked = (division, MOST_CELLS.min(budget.left));
            let Some((more, cells)) = Trial::certainly_lost(self.part, self.bead, window, asked)? else { break };
            budget.note(1, cells);
            lost += more;
            if lost > limit {
                break;
            }
        }
        Ok(lost)
    }

    /// Boxes of at most such a side that tile the place, those nearest to its thinnest ball first.
    fn windows(&self, side: f64) -> Vec<(Vec3, Vec3)> {
        let (lo, hi) = self.detail.extent;
        let counts = [0, 1, 2].map(|a| (((hi[a] - lo[a]) / side).ceil() as usize).clamp(1, 64));
        let step = [0, 1, 2].map(|a| (hi[a] - lo[a]) / counts[a] as f64);
        let corner = |n: [usize; 3]| [0, 1, 2].map(|a| lo[a] + step[a] * n[a] as f64);
        let mut all: Vec<(Vec3, Vec3)> = (0..counts.iter().product())
            .map(|n: usize| [n % counts[0], n / counts[0] % counts[1], n / (counts[0] * counts[1])])
            .map(|n| (corner(n), corner(n.map(|i| i + 1))))
            .collect();
        let middle = |w: &(Vec3, Vec3)| [0, 1, 2].map(|a| 0.5 * (w.0[a] + w.1[a]));
        let away = |w: &(Vec3, Vec3)| distance(middle(w), self.detail.thinnest.centre);
        all.sort_by(|a, b| away(a).total_cmp(&away(b)));
        all
    }
}
