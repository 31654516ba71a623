//! Changes tried out before they are advised: a place is cast on a lattice of its own, changed there, and printed again.

use super::departure::Departure;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, add, sub};
use crate::morphology::{AsPrinted, Bead, Cells, StructuringElement, dilate};
use crate::part::Part;
use crate::topology::{Adjacency, components};
use crate::units::Length;

/// Cells of a trial's lattice at most.
const MOST_CELLS: u128 = 1 << 22;
/// Steps tried beyond the first.
const STEPS: usize = 3;

/// A place of a part, as designed and as printed, on a lattice of the element.
pub struct Trial {
    made: AsPrinted,
    departure: Departure,
    /// Box of the place in the frame of the build.
    extent: (Vec3, Vec3),
}

impl Trial {
    /// The place in a box, printed on as fine a lattice as there is room for; `None` if it would be too large.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    pub fn closely(part: &Part, bead: Bead, extent: (Vec3, Vec3), departure: Departure) -> Result<Option<Trial>> {
        let window = Trial::window(bead, extent);
        let suits = |division: &(usize, usize)| departure.suits(&bead, *division);
        match Cells::covering_closely(&bead, window, MOST_CELLS, suits)? {
            Some(cells) => Trial::on(part, bead, extent, departure, cells).map(Some),
            None => Trial::around(part, bead, extent, departure),
        }
    }

    /// The place in a box, printed on a lattice like that of the whole part; `None` if it would be too large.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    pub fn around(part: &Part, bead: Bead, extent: (Vec3, Vec3), departure: Departure) -> Result<Option<Trial>> {
        let suits = |division: &(usize, usize)| departure.suits(&bead, *division);
        let cells = Cells::covering_where(&bead, Trial::window(bead, extent), MOST_CELLS, suits)?;
        cells.map(|cells| Trial::on(part, bead, extent, departure, cells)).transpose()
    }

    /// The place in a box, printed on cells that divide the element as asked; `None` if it takes more than `most` of them.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    pub fn divided(
        part: &Part,
        bead: Bead,
        extent: (Vec3, Vec3),
        departure: Departure,
        (division, most): ((usize, usize), u64),
    ) -> Result<Option<Trial>> {
        let cells = Cells::divided_into(&bead, Trial::window(bead, extent), most.into(), division)?;
        cells.map(|cells| Trial::on(part, bead, extent, departure, cells)).transpose()
    }

    fn on(part: &Part, bead: Bead, extent: (Vec3, Vec3), departure: Departure, cells: Cells) -> Result<Trial> {
        Ok(Trial { made: departure.print(part.deposited(bead, cells)?)?, departure, extent })
    }

    /// The volume in a box that departs from the drawing, mm³: estimate and the two numbers that it lies between, on cells that divide the
    /// element as asked, and the number of cells; `None` if it takes more than `most`.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    pub fn volumes_in(
        part: &Part,
        bead: Bead,
        extent: (Vec3, Vec3),
        departure: Departure,
        (division, most): ((usize, usize), u64),
    ) -> Result<Option<([f64; 3], u64)>> {
        // What is farther than an element's width, which the lattice adds, changes no printed cell in the box; what is filled also
        // depends on what is open half an element away.
        let reach = [if let Departure::Filled { .. } = departure { 0.6 * bead.widest().as_mm() } else { 0.0 }; 3];
        let window = (sub(extent.0, reach), add(extent.1, reach));
        let Some(cells) = Cells::divided_into(&bead, window, most.into(), division)? else { return Ok(None) };
        let trial = Trial::on(part, bead, extent, departure, cells)?;
        let [certain, about, possibly] = trial.departing()?;
        // Cells on the rim of a box reach into the next one, which has a lattice of its own.
        let half = trial.made.designed.cells.cell_mm().map(|side| 0.5 * side);
        let (inside, touched) =
            ((add(extent.0, half), sub(extent.1, half)), (sub(extent.0, half), add(extent.1, half)));
        let (low, high) = (trial.in_box(&certain, inside), trial.in_box(&possibly, touched));
        Ok(Some(([trial.in_box(&about, extent).clamp(low, high), low, high], trial.cells())))
    }

    /// Number of cells of the lattice.
    pub fn cells(&self) -> u64 {
        self.made.designed.cells.grid.samples() as u64
    }

    /// Width of a cell across the build direction.
    pub fn cell(&self) -> Length {
        self.made.designed.cells.grid.spacing()
    }

    /// The box with room for what the element does around it.
    fn window(bead: Bead, extent: (Vec3, Vec3)) -> (Vec3, Vec3) {
        let reach = 2.5 * bead.widest().as_mm();
        (sub(extent.0, [reach; 3]), add(extent.1, [reach; 3]))
    }

    /// The volume at the place that departs from the drawing, mm³: estimate, and the two numbers that it lies between.
    ///
    /// Void that is filled counts in the box and half an element around it. Material is what may depart and hangs together with what
    /// may depart in the box, but for the skin of what is certainly as drawn: contacts of a rod or a sheet end short of its ends. For
    /// certain counts what departs in the box.
    ///
    /// # Errors
    /// None for shapes that exist.
    pub fn volumes(&self) -> Result<[f64; 3]> {
        let cells = &self.made.designed.cells;
        let [certain, about, possibly] = self.departing()?;
        if let Departure::Filled { .. } = self.departure {
            let reach = [0.5 * self.made.designed.bead.widest().as_mm(); 3];
            let around = (sub(self.extent.0, reach), add(self.extent.1, reach));
            return Ok([about, certain, possibly].map(|set| self.in_box(&set, around)));
        }
        // Every face is a cell thick in doubt, and all of them hang together: only what is beyond that makes a place.
        let pieces = components(&possibly.difference(&near(&self.made.lower)?)?, Adjacency::Corner);
        let mut met = vec![false; pieces.count()];
        for index in cells.indices_in(self.extent) {
            let piece = pieces.of(index).and_then(|piece| met.get_mut(piece as usize));
            piece.into_iter().for_each(|met| *met = true);
        }
        let place = near(&pieces.select(|piece| met.get(piece as usize) == Some(&true)))?.intersection(&possibly)?;
        let volume = |set: &Indicator| (cells.cell_volume() * set.count() as f64).as_mm3();
        Ok([volume(&about.intersection(&place)?), self.in_box(&certain, self.extent), volume(&place)])
    }

    /// What departs from the drawing for certain, by the samples, and perhaps.
    fn departing(&self) -> Result<[Indicator; 3]> {
        match self.departure {
            Departure::Filled { .. } => self.made.filled(),
            _ => self.made.lost(),
        }
    }

    /// Volume of a set in a box, mm³.
    fn in_box(&self, set: &Indicator, extent: (Vec3, Vec3)) -> f64 {
        let cells = &self.made.designed.cells;
        cells.volume_in(set, &Indicator::empty(cells.grid), extent).as_mm3()
    }

    /// What one step of thickening adds along a direction, both sides together, millimetres.
    pub fn step_along(&self, direction: Vec3) -> f64 {
        let cell = self.made.designed.cells.cell_mm();
        2.0 * (0..3).map(|a| cell[a] * direction[a].abs()).sum::<f64>()
    }

    /// The least number of steps of growth, from those that add `missing` along a direction on, after which the place is printed as drawn:
    /// of material that is not printed, or of void that is filled.
    ///
    /// # Errors
    /// None for shapes that exist.
    pub fn remedied(&self, direction: Vec3, missing: f64) -> Result<Option<usize>> {
        let first = self.steps_for(direction, missing);
        for steps in first..first + STEPS {
            let designed = &self.made.designed;
            let grown = match self.departure {
                Departure::Filled { .. } => designed.thinned(steps),
                _ => designed.thickened(steps),
            };
            let made = self.departure.print(grown)?;
            // What the place was, not what was added to it, has to come out.
            let left = match self.departure {
                Departure::Filled { .. } => {
                    let [_, filled, _] = made.filled()?;
                    filled
                }
                _ => designed.shape.centres.difference(&made.centres)?,
            };
            if self.in_box(&left, self.extent) == 0.0 {
                return Ok(Some(steps));
            }
        }
        Ok(None)
    }

    fn steps_for(&self, direction: Vec3, missing: f64) -> usize {
        (missing / self.step_along(direction) - 1e-9).ceil().clamp(1.0, 64.0) as usize
    }
}

/// A set grown by a cell on every side.
fn near(set: &Indicator) -> Result<Indicator> {
    let cube = StructuringElement::cuboid([3; 3], set.grid().spacing())?;
    dilate(set, &cube)?.set.placed([1; 3], *set.grid())
}
