//! Changes tried out before they are advised: a place is cast on a lattice of its own, changed there, and printed again.

use crate::error::Result;
use crate::geometry::vector::{Vec3, add, sub};
use crate::morphology::{AsPrinted, Bead, Cells, Designed};
use crate::part::Part;

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
        let reach = 2.5 * bead.widest().as_mm();
        let window = (sub(extent.0, [reach; 3]), add(extent.1, [reach; 3]));
        let Some(cells) = Cells::covering(&bead, window, MOST_CELLS)? else { return Ok(None) };
        Ok(Some(Trial { made: print(part.deposited(bead, cells)?)?, extent }))
    }

    /// The two numbers that the volume designed and not printed in the box lies between, mm³.
    pub fn lost(&self) -> [f64; 2] {
        let shape = &self.made.designed.shape;
        [(&shape.inner, &self.made.upper), (&shape.outer, &self.made.lower)]
            .map(|(from, without)| self.made.designed.cells.volume_in(from, without, self.extent).as_mm3())
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
            let none = crate::field::Indicator::empty(cells.grid);
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
