//! Changes tried out before they are advised: a place is cast on a lattice of its own, changed there, and printed again.

use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, add, sub};
use crate::morphology::{AsPrinted, Bead, Cells, Designed, StructuringElement, dilate};
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
    /// Box of the place in the frame of the build.
    extent: (Vec3, Vec3),
}

impl Trial {
    /// The place in a box, opened by the element, on as fine a lattice as there is room for; `None` if it would be too large.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    pub fn opened(part: &Part, bead: Bead, extent: (Vec3, Vec3)) -> Result<Option<Trial>> {
        let window = Trial::window(bead, extent);
        match Cells::covering_closely(&bead, window, MOST_CELLS)? {
            Some(cells) => Ok(Some(Trial { made: part.deposited(bead, cells)?.printed(1.0)?, extent })),
            None => Trial::around(part, bead, extent, |designed| designed.printed(1.0)),
        }
    }

    /// The place in a box, printed as said; `None` if its lattice would be too large.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    pub fn around(
        part: &Part,
        bead: Bead,
        extent: (Vec3, Vec3),
        print: impl Fn(Designed) -> Result<AsPrinted>,
    ) -> Result<Option<Trial>> {
        let Some(cells) = Cells::covering(&bead, Trial::window(bead, extent), MOST_CELLS)? else { return Ok(None) };
        Ok(Some(Trial { made: print(part.deposited(bead, cells)?)?, extent }))
    }

    /// The place in a box, opened by the element, on cells that divide the element as asked; `None` if it takes more than `most` of
    /// them.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    pub fn opened_on(
        part: &Part,
        bead: Bead,
        extent: (Vec3, Vec3),
        (division, most): ((usize, usize), u64),
    ) -> Result<Option<Trial>> {
        let window = Trial::window(bead, extent);
        let Some(cells) = Cells::divided_into(&bead, window, most.into(), division)? else { return Ok(None) };
        Ok(Some(Trial { made: part.deposited(bead, cells)?.printed(1.0)?, extent }))
    }

    /// The volume in a box that is designed and not printed for certain, mm³, on cells that divide the element as asked, and the number of
    /// cells; `None` if it takes more than `most`.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    pub fn certainly_lost(
        part: &Part,
        bead: Bead,
        extent: (Vec3, Vec3),
        (division, most): ((usize, usize), u64),
    ) -> Result<Option<(f64, u64)>> {
        // What is beyond an element's width, which the lattice adds, changes nothing in the box.
        let Some(cells) = Cells::divided_into(&bead, extent, most.into(), division)? else { return Ok(None) };
        let made = part.deposited(bead, cells)?.printed(1.0)?;
        // Cells on the rim of a box reach into the next one.
        let within = (add(extent.0, cells.cell_mm()), sub(extent.1, cells.cell_mm()));
        let lost = cells.volume_in(&made.designed.shape.inner, &made.upper, within);
        Ok(Some((lost.as_mm3(), cells.grid.samples() as u64)))
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

    /// The volume designed and not printed at the place, mm³: estimate, and the two numbers that it lies between.
    ///
    /// The place is what may be lost and hangs together with what may be lost in the box, but for the skin of what is
    /// certainly printed: contacts of a rod or a sheet end short of its ends. For certain counts what is lost in the box.
    ///
    /// # Errors
    /// None for shapes that exist.
    pub fn lost(&self) -> Result<[f64; 3]> {
        let (shape, cells) = (&self.made.designed.shape, &self.made.designed.cells);
        let possibly = shape.outer.difference(&self.made.lower)?;
        let near = |set: &Indicator| -> Result<Indicator> {
            let cube = StructuringElement::cuboid([3; 3], cells.grid.spacing())?;
            dilate(set, &cube)?.set.placed([1; 3], cells.grid)
        };
        // Every face is a cell thick in doubt, and all of them hang together: only what is beyond that makes a place.
        let pieces = components(&possibly.difference(&near(&self.made.lower)?)?, Adjacency::Corner);
        let mut met = vec![false; pieces.count()];
        for index in cells.indices_in(self.extent) {
            let piece = pieces.of(index).and_then(|piece| met.get_mut(piece as usize));
            piece.into_iter().for_each(|met| *met = true);
        }
        let place = near(&pieces.select(|piece| met.get(piece as usize) == Some(&true)))?.intersection(&possibly)?;
        let low = cells.volume_in(&shape.inner, &self.made.upper, self.extent);
        let about = shape.centres.difference(&self.made.centres)?.intersection(&place)?;
        let volume = |set: &Indicator| (cells.cell_volume() * set.count() as f64).as_mm3();
        Ok([volume(&about), low.as_mm3(), volume(&place)])
    }

    /// What one step of thickening adds along a direction, both sides together, millimetres.
    pub fn step_along(&self, direction: Vec3) -> f64 {
        let cell = self.made.designed.cells.cell_mm();
        2.0 * (0..3).map(|a| cell[a] * direction[a].abs()).sum::<f64>()
    }

    /// The least number of steps, from those that add `missing` along a direction on, after which nothing of the place is lost.
    ///
    /// # Errors
    /// None for shapes that exist.
    pub fn thickened(&self, direction: Vec3, missing: f64) -> Result<Option<usize>> {
        let first = self.steps_for(direction, missing);
        for steps in first..first + STEPS {
            let printed = self.made.designed.thickened(steps).printed_as(&self.made)?;
            let cells = &self.made.designed.cells;
            if cells.volume_in(&self.made.designed.shape.centres, &printed.centres, self.extent).as_mm3() == 0.0 {
                return Ok(Some(steps));
            }
        }
        Ok(None)
    }

    /// The least number of steps, as [`Trial::thickened`], after which no void of the place is filled.
    ///
    /// # Errors
    /// None for shapes that exist.
    pub fn widened(&self, direction: Vec3, missing: f64) -> Result<Option<usize>> {
        let first = self.steps_for(direction, missing);
        for steps in first..first + STEPS {
            let printed = self.made.designed.thinned(steps).printed_as(&self.made)?;
            let filled = printed.filled()?;
            let cells = &self.made.designed.cells;
            let none = Indicator::empty(cells.grid);
            if cells.volume_in(&filled, &none, self.extent).as_mm3() == 0.0 {
                return Ok(Some(steps));
            }
        }
        Ok(None)
    }

    fn steps_for(&self, direction: Vec3, missing: f64) -> usize {
        (missing / self.step_along(direction) - 1e-9).ceil().clamp(1.0, 64.0) as usize
    }
}
