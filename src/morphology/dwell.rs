//! How long a path keeps a body over each place: one convolution of the path's δ with the body.

use super::element::lattice_box;
use crate::convolution::{convolve_fields, sum_grid};
use crate::error::{Error, Result};
use crate::field::{Field, Indicator, Nascent, Singular, indicator_function, superlevel};
use crate::grid::{Grid, samples_of};

/// A measure of the copies of a body that cover each place.
#[derive(Debug, Clone, PartialEq)]
pub struct Dwell {
    /// The measure of the copies over each sample, in the unit of the path's weights: millimetres of path where each weighs 1 a
    /// millimetre.
    pub field: Field<f32>,
    /// No sample is further from the convolution of the sampled operands.
    pub bound: f64,
}

/// The convolution `δ_P ∗ 1_B (x) = ∫_P 1_B(x − p) dP(p)` of a singular function P with a body: how much of P carries the body over x.
///
/// For a path of weight 1 this is the length along which the moving body covers x; it is positive on the sweep `P ⊕ B` and its integral
/// is the path's length times the body's volume. For the strokes of a nozzle, each millimetre weighing what is extruded over it in
/// volumes of the bead, it is the density of the material laid there: 1 where full, more where strokes overlap, less where they starve.
/// δ is spread by the kernel, so everything lies within its reach, along each axis, of where it is.
///
/// # Errors
/// [`Error::Operand`] for a P without a point, a kernel narrower than the body's spacing or P's pieces, or a box of P with more samples
/// than a grid may have; [`Error::TooLarge`] where the system has no memory for the samples of that box and the body.
///
/// # Cost
/// One convolution of the body's grid with that of P's box, however long the path is; before it (2·reach/h)³ additions for each piece.
///
/// # Limits
/// An estimate in f32. For sets that enclose the sweep take [`super::sweep()`] or [`super::deposit()`].
///
/// # Source
/// M. Behandish, Analytic Methods for Geometric Modeling, 2017, section 2.3; the rule for the length is Fubini's.
///
/// ```
/// use amcheck::{field::{Nascent, Singular}, geometry::{cuboid, occupancy}, grid::Grid, morphology::dwell, units::Length};
/// let h = Length::mm(0.25);
/// let grid = Grid::covering([0.0; 3], [1.0; 3], h, 1, [0.5; 3])?;
/// let cube = occupancy(&cuboid([0.0; 3], [1.0; 3]), &grid)?;
/// let path = Singular::on_polyline(&[[0.0; 3], [3.0, 4.0, 0.0]], 1.0, h)?;
/// let over = dwell(&cube, &path, Nascent::Triangle { width: h })?;
/// // 5 mm of path times 1 mm³.
/// assert!((over.integral() - 5.0).abs() < 1e-3);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn dwell(body: &Indicator, path: &Singular, kernel: Nascent) -> Result<Dwell> {
    let (lo, hi) = path.bounds().ok_or_else(|| Error::Operand {
        operation: "sweep",
        problem: "a path without a point".into(),
        remedy: "give at least one point".into(),
    })?;
    let (spacing, reach) = (body.grid().spacing(), kernel.reach());
    let grid: Grid = lattice_box(lo.map(|x| x - reach), hi.map(|x| x + reach), spacing, [0.0; 3])?;
    ask_for(&sum_grid(body.grid(), &grid)?)?;
    let density = path.dissipated(&grid, kernel)?;
    let sum = convolve_fields(&indicator_function(body), &density)?;
    let cell = grid.sample_volume().as_mm3();
    let mut field = sum.field;
    field.values_mut().iter_mut().for_each(|v| *v *= cell as f32);
    // The product with the cell rounds once more.
    let greatest = field.values().iter().fold(0f32, |most, v| most.max(v.abs()));
    Ok(Dwell { field, bound: sum.bound * cell + f64::from(greatest * f32::EPSILON) })
}

/// Bytes for each sample of the result: the density in two precisions, two spectra, the sum.
const BYTES_PER_SAMPLE: u128 = 24;

/// Asks for the memory of a convolution onto a grid before any of it is taken for good: what is not to be had cannot be refused later.
///
/// # Errors
/// [`Error::TooLarge`] with what is to be had, as a half, a quarter … of the need.
fn ask_for(sum: &Grid) -> Result<()> {
    let need_bytes = samples_of(sum.dims()).saturating_mul(BYTES_PER_SAMPLE);
    let is_to_be_had =
        |bytes: &u128| usize::try_from(*bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
    if is_to_be_had(&need_bytes) {
        return Ok(());
    }
    let halves = std::iter::successors(Some(need_bytes / 2), |bytes| Some(bytes / 2));
    Err(Error::TooLarge {
        what: format!("the dwell of a path over {:?} samples", sum.dims()),
        need_bytes,
        allowed_bytes: halves.take_while(|bytes| *bytes > 0).find(is_to_be_had).unwrap_or(0),
        remedy: "choose a larger spacing, or a part of the path".into(),
    })
}

impl Dwell {
    /// The samples that the body, widened by the kernel's support, covers for certain: where the measure is above its rounding. The
    /// body alone covers those of them that lie deeper than the support reaches.
    pub fn covered(&self) -> Indicator {
        superlevel(&self.field, self.bound as f32)
    }

    /// The integral over space: the measure of the path times the volume of the body.
    pub fn integral(&self) -> f64 {
        let sum: f64 = self.field.values().iter().map(|&v| f64::from(v)).sum();
        sum * self.field.grid().sample_volume().as_mm3()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Primitive, cuboid, occupancy};
    use crate::morphology::{StructuringElement, deposit, dilate};
    use crate::units::Length;

    #[test]
    fn strokes_a_bead_apart_lay_full_material_and_crossed_ones_twice_as_much() {
        // A bead of 4 × 4 × 2 samples; three layers of lines a width apart along x, and half a bead's material across some of them.
        let h = Length::mm(0.125);
        let (half, bead) = ([0.25, 0.25, 0.125], Primitive::parse("box:0.5x0.5x0.25mm").unwrap());
        let grid = Grid::covering([-0.25; 3], [0.25; 3], h, 1, [0.5; 3]).unwrap();
        let body = occupancy(&cuboid(half.map(|x: f64| -x), half), &grid).unwrap();
        assert_eq!(body.count(), 32);
        let line = |n: u32| [0.0, 6.0].map(|x| [x, 0.5 * f64::from(n % 8), 0.25 * f64::from(n / 8)]).to_vec();
        let mut strokes: Vec<Vec<[f64; 3]>> = (0..24).map(line).collect();
        let crossing = vec![[2.0, 0.5, 0.0], [2.0, 3.0, 0.0]];
        // A millimetre lays 0.125 mm³, two volumes of the bead.
        let lay = |stroke: &Vec<_>, per_mm| Singular::on_polyline(stroke, per_mm, h).unwrap();
        let lines = strokes.iter().map(|stroke| lay(stroke, 2.0)).fold(Singular::default(), Singular::plus);
        let path = lines.plus(lay(&crossing, 1.0));
        let laid = dwell(&body, &path, Nascent::Triangle { width: h }).unwrap();
        // 24 lines of 6 mm and half of 2.5 mm, at 0.125 mm³ each millimetre.
        let extruded = 0.125 * (144.0 + 1.25);
        assert!((laid.integral() / extruded - 1.0).abs() < 1e-5, "{}", laid.integral());
        let at = |p: [f64; 3]| {
            laid.field
                .grid()
                .sample_at(p)
                .map_or(0.0, |at| f64::from(laid.field.values()[laid.field.grid().offset(at)]))
        };
        for (place, density) in
            [([4.06, 2.06, 0.06], 1.0), ([2.06, 2.06, 0.06], 1.5), ([4.06, 2.06, 1.06], 0.0), ([8.0, 1.0, 0.06], 0.0)]
        {
            assert!((at(place) - density).abs() <= laid.bound + 1e-6, "{place:?}: {}", at(place));
        }
        // Where there is material, a bead is within the reach of the kernel; where beads lie deeper than that, there is material.
        strokes.push(crossing);
        let beads = deposit(&strokes, &bead, h, ([0.5; 3], Length::default())).unwrap();
        let cube = StructuringElement::cuboid([3; 3], h).unwrap();
        let near = dilate(&beads.points, &cube).unwrap().set;
        let deep = beads.points.complement();
        let deep = dilate(&deep, &cube).unwrap().set.placed([1; 3], *beads.points.grid()).unwrap().complement();
        let covered = laid.covered();
        assert!(deep.count() > 1000 && covered.count() > deep.count());
        let grid = *covered.grid();
        for at in 0..grid.samples() {
            let place = grid.position(grid.index(at));
            let within = |set: &Indicator| set.grid().sample_at(place).is_some_and(|at| set.contains(at));
            let is = covered.contains(grid.index(at));
            assert!((!is || within(&near)) && (is || !within(&deep)), "{place:?}");
        }
    }

    #[test]
    fn a_path_that_no_memory_holds_is_refused() {
        let h = Length::mm(0.25);
        let body = Indicator::from_predicate(Grid::new([0.0; 3], h, [3; 3]).unwrap(), |_| true);
        let far = Singular::on_points(&[([0.0; 3], 1.0), ([1e5; 3], 1.0)]).unwrap();
        let refused = dwell(&body, &far, Nascent::Triangle { width: h });
        let Err(Error::TooLarge { need_bytes, allowed_bytes, .. }) = refused else { panic!("{refused:?}") };
        assert!(need_bytes > 1 << 60 && 0 < allowed_bytes && allowed_bytes < need_bytes);
    }

    #[test]
    fn a_path_of_nothing_and_kernels_too_narrow_are_refused() {
        let h = Length::mm(0.25);
        let grid = Grid::new([0.0; 3], h, [3; 3]).unwrap();
        let body = Indicator::from_predicate(grid, |_| true);
        let width = |mm| Nascent::Gaussian { width: Length::mm(mm) };
        assert!(dwell(&body, &Singular::default(), width(0.5)).is_err());
        let path = Singular::on_polyline(&[[0.0; 3], [1.0; 3]], 1.0, h).unwrap();
        assert!(dwell(&body, &path, width(0.2)).is_err());
        assert!(dwell(&body, &path, width(0.25)).is_ok());
    }
}
