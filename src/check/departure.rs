//! How much of a place is not printed as drawn, told from the limits on finer and finer cells.

use super::as_printed::LAMBDA;
use super::budget::Budget;
use super::finding::Limits;
use super::trial::Trial;
use crate::error::Result;
use crate::geometry::vector::{Vec3, distance};
use crate::medial::Side;
use crate::morphology::{AsPrinted, Bead, Designed};
use crate::part::{Part, spread_of};
use crate::process::Process;
use crate::units::Length;

/// Cells along the width and the height of the element, level by level.
const DIVISIONS: [(usize, usize); 7] = [(4, 3), (8, 5), (10, 6), (16, 10), (24, 16), (32, 21), (48, 28)];
/// Cells of a finer look at a whole place at most: eight bytes each, for what is material of them and while its pieces are told apart.
const MOST_CELLS: u64 = 1 << 25;
/// Side of the parts that a place with patches is counted in, in widths of the element.
const PART: f64 = 10.0;
/// Such parts along its longest side at most.
const MOST_PARTS: f64 = 48.0;
/// Cells along a window on a part of a place that is larger, with the element's width on either side.
const WINDOW_CELLS: usize = 200;

/// A volume between two numbers, mm³: estimate, lower and upper bound.
pub(super) type Volumes = [f64; 3];

/// In what a print departs from the drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Departure {
    /// Material that the opening by the element leaves out.
    Opened,
    /// Material that a compensated outline leaves out.
    Unprinted { lambda: f64, spread: Length },
    /// Void that a compensated outline fills.
    Filled { lambda: f64, spread: Length },
}

impl Departure {
    /// What a process that compensates its outline does on one side of the surface.
    pub fn of_outline(side: Side, process: &Process) -> Self {
        let (lambda, spread) = (LAMBDA, spread_of(process));
        match side {
            Side::Material => Departure::Unprinted { lambda, spread },
            Side::Void => Departure::Filled { lambda, spread },
        }
    }

    /// The print that is compared with the drawing.
    ///
    /// # Errors
    /// As [`Designed::compensated`].
    pub fn print(self, designed: Designed) -> Result<AsPrinted> {
        match self {
            Departure::Opened => designed.printed(1.0),
            Departure::Unprinted { lambda, spread } | Departure::Filled { lambda, spread } => {
                designed.compensated(lambda, spread)
            }
        }
    }

    /// How far faces spread beyond half the element, millimetres.
    pub(super) fn beyond(self, bead: &Bead) -> f64 {
        match self {
            Departure::Opened => 0.0,
            Departure::Unprinted { spread, .. } | Departure::Filled { spread, .. } => bead.beyond_half(spread).as_mm(),
        }
    }

    /// Whether cells of such a division hold the spread of a face whole: otherwise it is rounded down, and slots that close stay open.
    pub(super) fn suits(self, bead: &Bead, (wide, _): (usize, usize)) -> bool {
        let Departure::Filled { spread, .. } = self else { return true };
        let cells = spread.as_mm() / bead.width.as_mm() * wide as f64;
        (cells - cells.round()).abs() < 1e-3
    }
}

/// A place that departs from the drawing, and what is sought of it.
pub(super) struct Place<'a> {
    pub part: &'a Part,
    pub bead: Bead,
    pub departure: Departure,
    pub limits: Limits,
    /// Its box and the middle of its narrowest place.
    pub extent: (Vec3, Vec3),
    pub narrowest: Vec3,
    /// The unit vector across it there, and by how much it is narrower than what would be printed as drawn, millimetres.
    pub across: Vec3,
    pub missing: f64,
    /// Its volume, mm³, where that is known better than by the samples of a lattice.
    pub likely: Option<f64>,
    /// Boxes around all of its patches, which may meet; without them it counts as a whole.
    pub patches: &'a [(Vec3, Vec3)],
}

impl Place<'_> {
    /// The bounds of the volume, narrowed on finer and finer cells until every limit is told from them or the budget ends.
    ///
    /// What is known comes with the width of the cells that told it; what is returned, too. The place is counted as a whole while its
    /// share of the budget allows that. One that is larger and seems to be above a limit is taken window by window, those at its
    /// narrowest first, until what departs for certain adds up to more. Cells are passed over that are too wide for anything to be
    /// certain in it.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    ///
    /// # Cost
    /// The samples that the budget notes, at some 20 ns each.
    pub fn told(&self, known: (Volumes, Length), share: u64, budget: &mut Budget) -> Result<(Volumes, Length)> {
        let (mut known, mut coarsest) = known;
        let cell = |(wide, _): (usize, usize)| self.bead.width.as_mm() / wide as f64;
        for division in DIVISIONS {
            let Some(limit) = self.open_limit(known) else { break };
            if cell(division) > 0.9 * coarsest.as_mm() || !self.departure.suits(&self.bead, division) {
                continue;
            }
            // The set on the doubtful side is up to two cells narrower than the place and has to depart all the same.
            let seems_above = self.likely.unwrap_or(known[0]) > limit;
            if seems_above && 2.0 * self.cell_across(division) >= self.missing {
                continue;
            }
            let asked = (division, MOST_CELLS.min(share).min(budget.left));
            // Each level has a disc of whole cells of its own: bounds of two levels do not bound one volume.
            if let Some((counted, looks, cells)) = self.counted(asked)? {
                budget.note(looks, cells);
                (known, coarsest) = (counted, Length::mm(cell(division)));
            } else if seems_above {
                let certain = self.certain_in_windows(division, limit, budget)?;
                known = [known[0].max(certain), known[1].max(certain), known[2].max(certain)];
            }
        }
        Ok((known, coarsest))
    }

    /// How far a cell reaches across the place where it is narrowest.
    fn cell_across(&self, (wide, high): (usize, usize)) -> f64 {
        let [x, y, z] = self.across.map(f64::abs);
        (x + y) * self.bead.width.as_mm() / wide as f64 + z * self.bead.height.as_mm() / high as f64
    }

    /// A limit that the bounds do not tell; the least of them.
    pub fn open_limit(&self, [_, low, high]: Volumes) -> Option<f64> {
        let limits = self.limits.fail.into_iter().chain(self.limits.warn);
        limits.filter(|&limit| low <= limit && limit < high).reduce(f64::min)
    }

    /// The volumes on cells that divide the element as asked, with the looks and the cells that it took; `None` if it takes more than
    /// allowed.
    fn counted(&self, asked: ((usize, usize), u64)) -> Result<Option<(Volumes, u64, u64)>> {
        if self.patches.is_empty() {
            let trial = Trial::divided(self.part, self.bead, self.extent, self.departure, asked)?;
            return trial.map(|t| Ok((t.volumes()?, 1, t.cells()))).transpose();
        }
        let (division, most) = asked;
        let (mut sum, mut looks, mut cells) = ([0.0; 3], 0, 0);
        let parts = self.parts();
        let needed: f64 = parts.iter().map(|part| self.cells_for(part, division)).sum();
        if needed > most as f64 {
            return Ok(None);
        }
        for part in parts {
            let found = Trial::volumes_in(self.part, self.bead, part, self.departure, (division, most))?;
            let Some((volumes, taken)) = found else { return Ok(None) };
            (0..3).for_each(|i| sum[i] += volumes[i]);
            (looks, cells) = (looks + 1, cells + taken);
        }
        Ok(Some((sum, looks, cells)))
    }

    /// Cells that a part of the place takes with what the element reaches around it, about.
    fn cells_for(&self, (lo, hi): &(Vec3, Vec3), (wide, high): (usize, usize)) -> f64 {
        let across = self.bead.width.as_mm() / wide as f64;
        let cell = [across, across, self.bead.height.as_mm() / high as f64];
        let around = 3.3 * self.bead.widest().as_mm() + 6.0 * self.departure.beyond(&self.bead);
        (0..3).map(|a| (hi[a] - lo[a] + around) / cell[a]).product()
    }

    /// Boxes that do not overlap, around all patches and half an element about them; the nearest to the narrowest point first.
    fn parts(&self) -> Vec<(Vec3, Vec3)> {
        let longest = (0..3).map(|a| self.extent.1[a] - self.extent.0[a]).fold(0.0, f64::max);
        let side = (PART * self.bead.width.as_mm()).max(longest / MOST_PARTS);
        let reach = 0.5 * self.bead.widest().as_mm();
        let mut parts: std::collections::BTreeMap<[i64; 3], (Vec3, Vec3)> = Default::default();
        for (lo, hi) in self.patches {
            let (lo, hi) = (lo.map(|x| x - reach), hi.map(|x| x + reach));
            let (first, last) = (lo.map(|x| (x / side).floor() as i64), hi.map(|x| (x / side).floor() as i64));
            for (i, j, k) in (first[0]..=last[0])
                .flat_map(|i| (first[1]..=last[1]).flat_map(move |j| (first[2]..=last[2]).map(move |k| (i, j, k))))
            {
                let tile = [i, j, k];
                let from = [0, 1, 2].map(|a| lo[a].max(tile[a] as f64 * side));
                let to = [0, 1, 2].map(|a| hi[a].min((tile[a] + 1) as f64 * side));
                let part = parts.entry(tile).or_insert((from, to));
                *part = ([0, 1, 2].map(|a| part.0[a].min(from[a])), [0, 1, 2].map(|a| part.1[a].max(to[a])));
            }
        }
        let mut parts: Vec<_> = parts.into_values().collect();
        parts.sort_by(|a, b| self.away(a).total_cmp(&self.away(b)));
        parts
    }

    /// How far the narrowest point is from a box.
    fn away(&self, (lo, hi): &(Vec3, Vec3)) -> f64 {
        distance([0, 1, 2].map(|a| self.narrowest[a].max(lo[a]).min(hi[a])), self.narrowest)
    }

    /// What departs for certain in windows on the place, until it is more than a limit.
    fn certain_in_windows(&self, division: (usize, usize), limit: f64, budget: &mut Budget) -> Result<f64> {
        let cell = self.bead.width.as_mm() / division.0 as f64;
        let side = cell * (WINDOW_CELLS - 2 * (division.0 + 4)) as f64;
        let mut certain = 0.0;
        let windows = if self.patches.is_empty() { self.windows(side) } else { self.parts() };
        for window in windows {
            let asked = (division, MOST_CELLS.min(budget.left));
            let found = Trial::volumes_in(self.part, self.bead, window, self.departure, asked)?;
            let Some(([_, more, _], cells)) = found else { break };
            budget.note(1, cells);
            certain += more;
            // Where it is narrowest nothing is certain: nothing is elsewhere.
            if certain > limit || certain == 0.0 {
                break;
            }
        }
        Ok(certain)
    }

    /// Boxes of at most such a side that tile the place, those nearest to its narrowest first.
    fn windows(&self, side: f64) -> Vec<(Vec3, Vec3)> {
        let (lo, hi) = self.extent;
        let counts = [0, 1, 2].map(|a| (((hi[a] - lo[a]) / side).ceil() as usize).clamp(1, 64));
        let step = [0, 1, 2].map(|a| (hi[a] - lo[a]) / counts[a] as f64);
        let corner = |n: [usize; 3]| [0, 1, 2].map(|a| lo[a] + step[a] * n[a] as f64);
        let mut all: Vec<(Vec3, Vec3)> = (0..counts.iter().product())
            .map(|n: usize| [n % counts[0], n / counts[0] % counts[1], n / (counts[0] * counts[1])])
            .map(|n| (corner(n), corner(n.map(|i| i + 1))))
            .collect();
        all.sort_by(|a, b| self.away(a).total_cmp(&self.away(b)));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::morphology::Footprint;
    use crate::part::Up;

    #[test]
    fn elements_of_either_footprint_are_counted_on_every_division() {
        let fin = cuboid([0.0; 3], [2.0, 2.0, 0.5]).joined(&cuboid([0.5, 1.0, 0.4], [1.5, 1.25, 2.0]));
        let part = Part::new(fin, Up::PlusZ, 1e-6, 1.0).unwrap();
        let extent = (part.to_build([0.9, 1.0, 1.4]), part.to_build([1.0, 1.25, 1.5]));
        let outline = Departure::of_outline(Side::Material, &Process::named("mjf").unwrap());
        for footprint in [Footprint::Disc, Footprint::Square] {
            let bead = Bead { footprint, width: Length::mm(0.5), height: Length::mm(0.3) };
            for division in DIVISIONS {
                let trial = Trial::divided(&part, bead, extent, outline, (division, 1 << 24));
                assert!(trial.unwrap().is_some(), "{footprint:?} {division:?}");
            }
        }
    }
}
