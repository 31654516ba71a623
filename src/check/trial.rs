//! Changes tried out before they are advised: a place is cast on a lattice of its own, changed there, and printed again.

use super::departure::Departure;
use crate::error::Result;
use crate::field::{Density, Indicator};
use crate::geometry::Enclosure;
use crate::geometry::vector::{Vec3, add, sub};
use crate::morphology::{AsPrinted, Bead, Cells, StructuringElement, dilate};
use crate::part::Part;
use crate::topology::{Adjacency, components};
use crate::units::Length;

/// Cells of a trial's lattice at most.
const MOST_CELLS: u128 = 1 << 22;
/// What the rounding of corners to 2⁻¹⁶ of a cell may change of the share of a cell that is cut by as many as sixteen whole sections.
const ROUNDING: f64 = 1.0 / 4096.0;
/// Steps tried beyond the first.
const STEPS: usize = 3;

/// A place of a part, as designed and as printed, on a lattice of the element.
pub struct Trial {
    made: AsPrinted,
    /// The share of each cell that is material, where the mesh tells it.
    density: Option<Density>,
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
        let window = Trial::window(bead, extent, departure);
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
        let cells = Cells::covering_where(&bead, Trial::window(bead, extent, departure), MOST_CELLS, suits)?;
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
        let cells =
            Cells::divided_into(&bead, counting(bead, departure, around(&bead, extent)), most.into(), division)?;
        cells.map(|cells| Trial::on(part, bead, extent, departure, cells)).transpose()
    }

    fn on(part: &Part, bead: Bead, extent: (Vec3, Vec3), departure: Departure, cells: Cells) -> Result<Trial> {
        let (designed, density) = part.deposited_with_density(bead, cells)?;
        Ok(Trial { made: departure.print(designed)?, density, departure, extent })
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
        let window = counting(bead, departure, extent);
        let Some(cells) = Cells::divided_into(&bead, window, most.into(), division)? else { return Ok(None) };
        let trial = Trial::on(part, bead, extent, departure, cells)?;
        let [certain, about, possibly] = trial.departing()?;
        // Cells on the rim of a box reach into the next one, which has a lattice of its own.
        let cells = &trial.made.designed.cells;
        let (low, _) = trial.volume(&cells.within(&certain, cells.held(extent)));
        let (_, high) = trial.volume(&cells.within(&possibly, cells.touched(extent)));
        let about = trial.middle(&cells.within(&about, extent));
        Ok(Some(([about.clamp(low, high), low, high], trial.cells())))
    }

    /// Number of cells of the lattice.
    pub fn cells(&self) -> u64 {
        self.made.designed.cells.grid.samples() as u64
    }

    /// Width of a cell across the build direction.
    pub fn cell(&self) -> Length {
        self.made.designed.cells.grid.spacing()
    }

    /// The box with room for what the element does around it, and what spreads beyond it.
    fn window(bead: Bead, extent: (Vec3, Vec3), departure: Departure) -> (Vec3, Vec3) {
        let reach = 2.5 * bead.widest().as_mm() + 3.0 * departure.beyond(&bead);
        (sub(extent.0, [reach; 3]), add(extent.1, [reach; 3]))
    }

    /// The volume at the place that departs from the drawing, mm³: estimate, and the two numbers that it lies between.
    ///
    /// It counts in the box and half an element around it, since contacts of a rod or a sheet end short of its ends. Of void it is all
    /// that is filled there, of material what hangs together there with what departs in the box: not the rounding of edges elsewhere.
    /// What may depart is a skin as thick as the doubt on every face; only what is beyond the skin of what is certainly as drawn holds
    /// a place together.
    ///
    /// # Errors
    /// None for shapes that exist.
    pub fn volumes(&self) -> Result<[f64; 3]> {
        let cells = &self.made.designed.cells;
        let around = around(&self.made.designed.bead, self.extent);
        let [certain, about, possibly] = self.departing()?;
        let (mut certain, mut possibly) =
            (cells.within(&certain, cells.held(around)), cells.within(&possibly, cells.touched(around)));
        let mut about = cells.within(&about, around);
        if !matches!(self.departure, Departure::Filled { .. }) {
            let sampled = self.made.designed.shape.centres.difference(&self.made.centres)?;
            certain = self.hanging_together(&certain);
            let beyond = possibly.difference(&near(&self.made.lower)?)?;
            possibly = near(&self.hanging_together(&beyond))?.intersection(&possibly)?.union(&certain)?;
            about = about.intersection(&near(&sampled.intersection(&possibly)?)?)?;
        }
        let ((low, _), (_, high)) = (self.volume(&certain), self.volume(&possibly));
        Ok([self.middle(&about).clamp(low, high), low, high])
    }

    /// The pieces of a set of cells that meet the box of the place.
    fn hanging_together(&self, set: &Indicator) -> Indicator {
        let cells = &self.made.designed.cells;
        let pieces = components(set, Adjacency::Corner);
        let mut met = vec![false; pieces.count()];
        for index in cells.indices_in(cells.touched(self.extent)) {
            let piece = pieces.of(index).and_then(|piece| met.get_mut(piece as usize));
            piece.into_iter().for_each(|met| *met = true);
        }
        pieces.select(|piece| met.get(piece as usize) == Some(&true))
    }

    /// Cells in which the print departs from the drawing: all of them for certain, by the samples, and some perhaps.
    fn departing(&self) -> Result<[Indicator; 3]> {
        match self.departure {
            Departure::Filled { .. } => self.made.filled_within(),
            _ => self.made.lost_within(),
        }
    }

    /// The middle of what a set of cells may hold of what departs, mm³.
    fn middle(&self, set: &Indicator) -> f64 {
        let (low, high) = self.volume(set);
        0.5 * (low + high)
    }

    /// The two numbers that the volume of material in a set of cells lies between, mm³; of void, where that is what departs.
    fn volume(&self, set: &Indicator) -> (f64, f64) {
        let Enclosure { inner, outer, .. } = &self.made.designed.shape;
        let cells = &self.made.designed.cells;
        let mut sum = (0.0, 0.0);
        for at in set.iter() {
            let index = cells.grid.index(at);
            let (least, most) = match &self.density {
                _ if inner.contains(index) => (1.0, 1.0),
                _ if !outer.contains(index) => (0.0, 0.0),
                Some(density) => {
                    let share = f64::from(density.field().values()[at]);
                    ((share - ROUNDING).max(0.0), (share + ROUNDING).min(1.0))
                }
                None => (0.0, 1.0),
            };
            let (least, most) =
                if let Departure::Filled { .. } = self.departure { (1.0 - most, 1.0 - least) } else { (least, most) };
            sum = (sum.0 + least, sum.1 + most);
        }
        let cell = cells.cell_volume().as_mm3();
        (cell * sum.0, cell * sum.1)
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

/// A box and half an element around it: what departs at a place ends there.
fn around(bead: &Bead, (lo, hi): (Vec3, Vec3)) -> (Vec3, Vec3) {
    let reach = [0.5 * bead.widest().as_mm(); 3];
    (sub(lo, reach), add(hi, reach))
}

/// The box that a lattice has to cover for what departs in a box to be counted on it.
///
/// What is farther than an element's width, which the lattice adds, and than what spreads beyond the element, changes no printed cell in
/// the box; what is filled also depends on what is open as far away as a coat is thick.
fn counting(bead: Bead, departure: Departure, (lo, hi): (Vec3, Vec3)) -> (Vec3, Vec3) {
    let beyond = departure.beyond(&bead);
    let coat = if beyond > 0.0 { 0.9 * bead.widest().as_mm() + 1.8 * beyond } else { 0.6 * bead.widest().as_mm() };
    let open = if let Departure::Filled { .. } = departure { coat } else { 0.0 };
    let reach = [open + beyond; 3];
    (sub(lo, reach), add(hi, reach))
}

/// A set grown by a cell on every side.
fn near(set: &Indicator) -> Result<Indicator> {
    let cube = StructuringElement::cuboid([3; 3], set.grid().spacing())?;
    dilate(set, &cube)?.set.placed([1; 3], *set.grid())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{TriangleMesh, cuboid, extruded};
    use crate::morphology::Footprint;
    use crate::part::Up;
    use crate::units::Length;

    const BEAD: Bead = Bead { footprint: Footprint::Disc, width: Length::mm(0.4), height: Length::mm(0.2) };

    /// A block with a fin of 0.3 mm that stands 2 mm out of it, 3 mm high, turned about z; and the box that the middle of the fin turns in.
    fn finned(angle: f64) -> (Part, (Vec3, Vec3)) {
        let outline =
            [[0.0, 0.0], [4.0, 0.0], [4.0, 1.85], [6.0, 1.85], [6.0, 2.15], [4.0, 2.15], [4.0, 4.0], [0.0, 4.0]];
        let caps = [[0, 1, 2], [0, 2, 5], [0, 5, 7], [5, 6, 7], [2, 3, 4], [2, 4, 5]];
        let (s, c) = angle.sin_cos();
        let turned = |[x, y]: [f64; 2], z: f64| [c * x - s * y, s * x + c * y, z];
        let mut mesh: TriangleMesh = extruded(&outline, &caps, 3.0);
        mesh.vertices.iter_mut().for_each(|p| *p = turned([p[0], p[2]], 3.0 - p[1]));
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
        let [a, b] = [turned([4.1, 2.0], 0.1), turned([5.9, 2.0], 2.9)].map(|p| part.to_build(p));
        let extent = ([0, 1, 2].map(|i| a[i].min(b[i])), [0, 1, 2].map(|i| a[i].max(b[i])));
        (part, extent)
    }

    #[test]
    fn a_fin_that_is_lost_is_bracketed_whichever_way_it_stands() {
        // The disc enters the fin as far as the corners at its foot let it.
        let half = (0.15f64 / 0.2).asin();
        let entered = 0.04 * (half - half.sin() * half.cos());
        let truth = 3.0 * (2.0 * 0.3 - entered);
        for (step, division) in [(16, 10), (24, 16), (16, 10), (32, 21)].into_iter().enumerate() {
            let (part, extent) = finned(0.37 * step as f64);
            let trial = Trial::divided(&part, BEAD, extent, Departure::Opened, (division, 1 << 26)).unwrap().unwrap();
            let [value, low, high] = trial.volumes().unwrap();
            assert!(low <= truth && truth <= high, "{truth} not in {low} … {high}");
            // Cells wholly within the fin alone would hold a sixth less at best.
            assert!(low <= value && value <= high && high - low < 0.05 * truth, "{value} in {low} … {high}");
        }
    }

    #[test]
    fn a_slot_that_closes_is_bracketed_by_what_it_holds() {
        let half = 0.5 * BEAD.widest().as_mm();
        let spread = Length::mm(0.1);
        for (gap, at) in [(0.1, 2.0), (0.07, 2.013), (0.12, 2.017)] {
            let both = cuboid([0.0; 3], [at, 4.0, 3.0]).joined(&cuboid([at + gap, 0.0, 0.0], [4.2, 4.0, 3.0]));
            let part = Part::new(both, Up::PlusZ, 1e-6, 1.0).unwrap();
            let extent = (part.to_build([at - 0.1, 1.0, 1.0]), part.to_build([at + gap + 0.1, 3.0, 2.0]));
            let filled = Departure::Filled { lambda: 0.5, spread };
            let (volumes, _) = Trial::volumes_in(&part, BEAD, extent, filled, ((16, 10), 1 << 26)).unwrap().unwrap();
            let trial = Trial::divided(&part, BEAD, extent, filled, ((16, 10), 1 << 26)).unwrap().unwrap();
            for ([value, low, high], around) in [(volumes, 0.0), (trial.volumes().unwrap(), half)] {
                let truth = gap * (2.0 + 2.0 * around) * (1.0 + 2.0 * around);
                assert!(low <= truth && truth <= high, "{truth} not in {low} … {high}");
                // What is in doubt is a cell about the rim of the box.
                assert!(low <= value && value <= high && high - low < 0.15 * truth, "{value} in {low} … {high}");
            }
        }
    }
}
