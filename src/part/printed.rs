//! A part as a process prints it.

use super::Part;
use super::health::Role;
use crate::error::{Error, Result};
use crate::field::Density;
use crate::geometry::InsideRule;
use crate::geometry::vector::{add, sub};
use crate::morphology::{AsPrinted, Bead, Cells, Designed, Footprint};
use crate::process::Process;
use crate::units::Length;
use std::sync::Arc;

/// What was deposited first, and by what.
pub(super) type Printed = ((Bead, f64, Length), Result<Option<Arc<AsPrinted>>>);

/// Cells that a part is deposited on at most: eight bytes for sixty-four of them, for each of some seven sets.
const MOST_CELLS: u128 = 1 << 26;

impl Part {
    /// The part as the process prints it: what at least the share λ of its element holds as drawn, and no face spread by more than
    /// [`spread_of`] the process; shared by all who ask for the same.
    ///
    /// `None` if the element is too fine for a lattice of the whole part: nothing is then known of it.
    ///
    /// # Errors
    /// [`Error::Operand`] for an element without extent or λ outside `[0, 1]`, otherwise as [`crate::geometry::enclose`].
    pub fn as_printed(&self, process: &Process, lambda: f64) -> Result<Option<Arc<AsPrinted>>> {
        let (bead, spread) = (bead_of(process), spread_of(process));
        let make = || {
            let (lo, hi) = self.mesh.bounds().unwrap_or_default();
            let room = [bead.beyond_half(spread).as_mm(); 3];
            let Some(cells) = Cells::covering(&bead, (sub(lo, room), add(hi, room)), MOST_CELLS)? else {
                return Ok(None);
            };
            self.deposited(bead, cells)?.compensated(lambda, spread).map(|made| Some(Arc::new(made)))
        };
        let (of, made) = self.kept.printed.get_or_init(|| ((bead, lambda, spread), make()));
        if *of == (bead, lambda, spread) { made.clone() } else { make() }
    }

    /// The part, or what a window of it holds, on a lattice of an element.
    ///
    /// # Errors
    /// As [`crate::geometry::enclose`].
    pub fn deposited(&self, bead: Bead, cells: Cells) -> Result<Designed> {
        let by_crossings =
            self.health.is_solid().then(|| Designed::cast(&self.mesh, InsideRule::Crossings, bead, cells));
        match by_crossings {
            Some(Err(Error::Operand { .. })) | None => Designed::cast(&self.mesh, InsideRule::Winding, bead, cells),
            Some(cast) => cast,
        }
    }

    /// As [`Part::deposited`], with the share of each cell that the part fills, where the mesh tells it.
    ///
    /// Shares add up what every facet bounds: of bodies that overlap they would count the overlap twice, and an open surface has none.
    ///
    /// # Errors
    /// As there.
    pub fn deposited_with_density(&self, bead: Bead, cells: Cells) -> Result<(Designed, Option<Density>)> {
        let swallowed = self.health.shells.iter().any(|shell| shell.role == Role::Swallowed);
        if !swallowed && self.is_plain() {
            match Designed::cast_with_density(&self.mesh, bead, cells) {
                Ok((designed, density)) => return Ok((designed, Some(density))),
                Err(Error::Operand { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        Ok((self.deposited(bead, cells)?, None))
    }
}

/// The element of a process as a prism: a pixel is square, a bead and a spot are round.
pub fn bead_of(process: &Process) -> Bead {
    let footprint = if process.element.kind == "pixel" { Footprint::Square } else { Footprint::Disc };
    Bead { footprint, width: Length::mm(process.element.width_mm), height: Length::mm(process.layer_height_mm) }
}

/// How far a printed face may lie outside the drawn one: half the gap that closes, however narrow the element is.
pub fn spread_of(process: &Process) -> Length {
    Length::mm(0.5 * process.element.closing_gap_mm)
}
