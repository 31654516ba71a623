//! The real three-dimensional Fourier transform.
//!
//! Three one-dimensional passes, arranged so that memory is walked twice and not six times: rows along x and
//! columns along y are done plane by plane while the plane is in cache, columns along z where they stand. Eight
//! rows or columns go together, one to a lane of the processor's registers, so that a butterfly moves nothing
//! between lanes. Planes are a little longer than they need to be, so that no stride is a multiple of a page.
//! Eight rows that hold nothing are never transformed.

use super::column::{ColumnPlan, ColumnScratch, Way};
use super::lanes::{Lanes, Strip};
use super::row::{ROWS, RowPlan, RowScratch, strips};
use super::spectrum::Spectrum;
use crate::error::{Error, Result};
use ndarray::{ArrayViewMut2, ArrayViewMut3, Axis, ShapeBuilder};
use rayon::prelude::*;
use rustfft::FftNum;

/// What transforms columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Engine {
    /// Eight columns at once in the lanes of registers: the quickest, most of all where memory is waited for.
    Lanes,
    /// The library `rustfft`, column by column: about as quick in double precision within a plane in cache.
    Library,
}

/// A floating-point number that transforms are made of: `f32` or `f64`.
pub trait Real: FftNum + Default + Into<f64> + Lanes {
    /// What transforms the columns along y.
    const ALONG_Y: Engine;
    /// The unit roundoff: half the distance from 1 to the next number.
    const ROUNDOFF: f64;
    /// The nearest number of this kind.
    fn of(value: f64) -> Self;
}

impl Real for f32 {
    const ALONG_Y: Engine = Engine::Lanes;
    const ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;
    fn of(value: f64) -> Self {
        value as f32
    }
}

impl Real for f64 {
    const ALONG_Y: Engine = Engine::Library;
    const ROUNDOFF: f64 = f64::EPSILON / 2.0;
    fn of(value: f64) -> Self {
        value
    }
}

/// What a source of rows has to say about one row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowContent {
    /// All samples are zero; the buffer was not touched.
    Zero,
    /// The buffer holds the row.
    Filled,
}

/// The box of a cyclic field that an inverse transform hands out; indices wrap around.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// First sample along each axis.
    pub start: [usize; 3],
    /// Samples along each axis.
    pub dims: [usize; 3],
}

/// Plans for real transforms of one size, to be shared by any number of threads and transforms.
pub struct Transform<T: Real> {
    dims: [usize; 3],
    rows: RowPlan<T>,
    columns: [ColumnPlan<T>; 2],
}

/// What a thread needs to transform a plane.
struct PlaneScratch<T> {
    rows: RowScratch<T>,
    columns: ColumnScratch<T>,
}

impl<T: Real> Transform<T> {
    /// Plans for fields of the given counts.
    ///
    /// # Cost
    /// Microseconds per length; nothing is measured.
    pub fn new(dims: [usize; 3]) -> Self {
        let [nx, ny, nz] = dims.map(|n| n.max(1));
        Transform {
            dims: [nx, ny, nz],
            rows: RowPlan::new(nx),
            columns: [ColumnPlan::new(ny, T::ALONG_Y), ColumnPlan::new(nz, Engine::Lanes)],
        }
    }

    /// Counts of the real field.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Bytes that one spectrum takes.
    pub fn spectrum_bytes(&self) -> u128 {
        self.plane_pitch() as u128 * self.dims[2] as u128 * size_of::<Strip<T>>() as u128
    }

    /// An all-zero spectrum, to be filled by [`Transform::forward_into`] as often as wanted.
    pub fn spectrum(&self) -> Spectrum<T> {
        let plane_pitch = self.plane_pitch();
        let values = (0..plane_pitch * self.dims[2]).into_par_iter().map(|_| Strip::default()).collect();
        Spectrum { dims: self.dims, plane_pitch, values }
    }

    /// The spectrum `f̂(ω) = Σ_x f(x)·exp(−2πi ω·x/n)` of a field whose rows along x come from `row(j, k, buffer)`.
    ///
    /// # Errors
    /// None that can be met: the spectrum is made to fit.
    ///
    /// # Cost
    /// 2.5·N·log2 N operations, two walks over memory, one spectrum.
    pub fn forward(&self, row: impl Fn(usize, usize, &mut [T]) -> RowContent + Sync) -> Result<Spectrum<T>> {
        let mut spectrum = self.spectrum();
        self.forward_into(&mut spectrum, row)?;
        Ok(spectrum)
    }

    /// As [`Transform::forward`], into a spectrum that is there already.
    ///
    /// # Errors
    /// [`Error::Internal`] if the spectrum is of another size.
    pub fn forward_into(
        &self,
        spectrum: &mut Spectrum<T>,
        row: impl Fn(usize, usize, &mut [T]) -> RowContent + Sync,
    ) -> Result<()> {
        self.expect_size(spectrum)?;
        let plane_len = strips(self.dims[0]) * self.dims[1];
        spectrum.values.par_chunks_mut(spectrum.plane_pitch).enumerate().for_each_init(
            || self.plane_scratch(),
            |scratch, (k, plane)| self.plane_forward(scratch, &mut plane[..plane_len], |j, buffer| row(j, k, buffer)),
        );
        self.columns_along_z(spectrum, Way::There);
        Ok(())
    }

    /// The field of a spectrum, divided by N, one row of a window at a time: `consume(row, out_row)` sees the
    /// samples of each row in order and writes what it wants to keep to `out`, `row_len` items a row.
    ///
    /// The spectrum is used up. Planes and rows outside the window are never transformed back.
    ///
    /// # Errors
    /// [`Error::Internal`] if sizes do not fit.
    ///
    /// # Cost
    /// As [`Transform::forward`]; no field of the padded size is ever held.
    pub fn inverse<O: Send>(
        &self,
        mut spectrum: Spectrum<T>,
        window: Window,
        out: &mut [O],
        row_len: usize,
        consume: impl Fn(&[T], &mut [O]) + Sync,
    ) -> Result<()> {
        self.inverse_in_place(&mut spectrum, window, out, row_len, consume)
    }

    /// As [`Transform::inverse`], leaving the buffer of the spectrum to be filled again; its content is lost.
    ///
    /// # Errors
    /// As [`Transform::inverse`].
    pub fn inverse_in_place<O: Send>(
        &self,
        spectrum: &mut Spectrum<T>,
        window: Window,
        out: &mut [O],
        row_len: usize,
        consume: impl Fn(&[T], &mut [O]) + Sync,
    ) -> Result<()> {
        self.expect_size(spectrum)?;
        let fits = (0..3).all(|a| window.dims[a] <= self.dims[a] && window.start[a] < self.dims[a]);
        if !fits || row_len == 0 || out.len() != row_len * window.dims[1] * window.dims[2] {
            return Err(Error::Internal { problem: format!("window {window:?} of {:?}", self.dims) });
        }
        self.columns_along_z(spectrum, Way::Back);
        let plane_len = strips(self.dims[0]) * self.dims[1];
        let scale = T::of(1.0 / self.dims.iter().product::<usize>() as f64);
        let mut planes: Vec<_> = spectrum.values.chunks_mut(spectrum.plane_pitch).collect();
        planes.rotate_left(window.start[2]);
        let targets = out.par_chunks_mut(row_len * window.dims[1]);
        planes.into_par_iter().take(window.dims[2]).zip(targets).for_each_init(
            || self.plane_scratch(),
            |scratch, (plane, target)| {
                let mut rows = target.chunks_exact_mut(row_len);
                self.plane_back(scratch, &mut plane[..plane_len], window, |row| {
                    row.rotate_left(window.start[0]);
                    let kept = &mut row[..window.dims[0]];
                    kept.iter_mut().for_each(|v| *v = *v * scale);
                    rows.next().into_iter().for_each(|out_row| consume(kept, out_row));
                });
            },
        );
        Ok(())
    }

    fn plane_scratch(&self) -> PlaneScratch<T> {
        PlaneScratch { rows: self.rows.scratch(), columns: self.columns[0].scratch() }
    }

    fn plane_forward(
        &self,
        scratch: &mut PlaneScratch<T>,
        plane: &mut [Strip<T>],
        row: impl Fn(usize, &mut [T]) -> RowContent,
    ) {
        let mut any = false;
        for (group, spectra) in plane.chunks_mut(strips(self.dims[0]) * ROWS).enumerate() {
            let mut filled = false;
            for (lane, j) in (0..ROWS).zip(group * ROWS..self.dims[1]) {
                let buffer = scratch.rows.row(lane);
                match row(j, buffer) {
                    RowContent::Zero => buffer.fill(T::zero()),
                    RowContent::Filled => filled = true,
                }
            }
            if filled {
                self.rows.forward(&mut scratch.rows, spectra);
            } else {
                spectra.fill(Strip::default());
            }
            any |= filled;
        }
        if any {
            self.columns_along_y(plane, Way::There, &mut scratch.columns);
        }
    }

    /// The rows of a window, unscaled, in order.
    fn plane_back(
        &self,
        scratch: &mut PlaneScratch<T>,
        plane: &mut [Strip<T>],
        window: Window,
        mut consume: impl FnMut(&mut [T]),
    ) {
        self.columns_along_y(plane, Way::Back, &mut scratch.columns);
        let width = strips(self.dims[0]);
        for first in (0..window.dims[1]).step_by(ROWS) {
            let count = ROWS.min(window.dims[1] - first);
            // The last row stands in for those that the window does not have.
            let spectra = std::array::from_fn(|lane| {
                let j = (window.start[1] + first + lane.min(count - 1)) % self.dims[1];
                &plane[j * width..][..width]
            });
            self.rows.back(&mut scratch.rows, spectra);
            (0..count).for_each(|lane| consume(scratch.rows.row(lane)));
        }
    }

    fn columns_along_y(&self, plane: &mut [Strip<T>], way: Way, scratch: &mut ColumnScratch<T>) {
        if let Ok(mut sheet) = ArrayViewMut2::from_shape((self.dims[1], strips(self.dims[0])), plane) {
            sheet.axis_iter_mut(Axis(1)).for_each(|column| self.columns[0].run(way, column, scratch));
        }
    }

    fn columns_along_z(&self, spectrum: &mut Spectrum<T>, way: Way) {
        let width = strips(self.dims[0]);
        let shape = (self.dims[2], self.dims[1], width).strides((spectrum.plane_pitch, width, 1));
        if let Ok(mut all) = ArrayViewMut3::from_shape(shape, &mut spectrum.values) {
            all.axis_iter_mut(Axis(1)).into_par_iter().for_each_init(
                || self.columns[1].scratch(),
                |scratch, mut sheet| {
                    sheet.axis_iter_mut(Axis(1)).for_each(|column| self.columns[1].run(way, column, scratch));
                },
            );
        }
    }

    /// Strips from one plane to the next: an odd number of cache lines, and some distance from a multiple of a page.
    fn plane_pitch(&self) -> usize {
        let page = 4096 / size_of::<Strip<T>>();
        let pitch = (strips(self.dims[0]) * self.dims[1]) | 1;
        if pitch % page < 2 || page - pitch % page < 2 { pitch + 4 } else { pitch }
    }

    fn expect_size(&self, spectrum: &Spectrum<T>) -> Result<()> {
        if spectrum.dims == self.dims {
            return Ok(());
        }
        Err(Error::Internal { problem: format!("a spectrum of {:?} for plans of {:?}", spectrum.dims, self.dims) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustfft::num_complex::Complex;
    use rustfft::num_traits::Zero;

    fn noise(n: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        (0..n)
            .map(|_| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
            })
            .collect()
    }

    fn forward<T: Real>(plan: &Transform<T>, values: &[f64]) -> Spectrum<T> {
        let [nx, ny, _] = plan.dims();
        plan.forward(|j, k, row| {
            let from = &values[(k * ny + j) * nx..][..nx];
            row.iter_mut().zip(from).for_each(|(r, &v)| *r = T::of(v));
            if from.iter().all(|&v| v == 0.0) { RowContent::Zero } else { RowContent::Filled }
        })
        .unwrap()
    }

    fn naive(values: &[f64], [nx, ny, nz]: [usize; 3], [p, q, r]: [usize; 3]) -> Complex<f64> {
        let mut sum = Complex::zero();
        for (at, &v) in values.iter().enumerate() {
            let (i, j, k) = (at % nx, at / nx % ny, at / (nx * ny));
            let turn = (p * i) as f64 / nx as f64 + (q * j) as f64 / ny as f64 + (r * k) as f64 / nz as f64;
            sum += Complex::from_polar(v, -std::f64::consts::TAU * turn);
        }
        sum
    }

    const SIZES: [[usize; 3]; 6] = [[1, 1, 1], [2, 1, 3], [6, 5, 4], [9, 8, 1], [5, 1, 7], [34, 3, 2]];

    #[test]
    fn the_spectrum_is_the_plain_sum_over_samples() {
        for dims in SIZES {
            let values = noise(dims.iter().product(), 7);
            let spectrum = forward(&Transform::<f64>::new(dims), &values);
            for r in 0..dims[2] {
                for q in 0..dims[1] {
                    for p in 0..spectrum.columns() {
                        let off = spectrum.at([p, q, r]) - naive(&values, dims, [p, q, r]);
                        // 204 terms below ½ in f64: rounding stays below 1e-12.
                        assert!(off.norm() < 1e-12, "{dims:?} at {p},{q},{r}: {off}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_inverse_of_the_forward_is_the_field_and_windows_wrap() {
        for dims in SIZES.into_iter().chain([[48, 40, 36]]) {
            let values = noise(dims.iter().product(), 11);
            let plan = Transform::<f32>::new(dims);
            let start = dims.map(|n| n / 2);
            let mut out = vec![0f32; values.len()];
            plan.inverse(forward(&plan, &values), Window { start, dims }, &mut out, dims[0], |row, o| {
                o.copy_from_slice(row)
            })
            .unwrap();
            for (at, &found) in out.iter().enumerate() {
                let index = [at % dims[0], at / dims[0] % dims[1], at / (dims[0] * dims[1])];
                let [i, j, k] = [0, 1, 2].map(|a| (index[a] + start[a]) % dims[a]);
                let want = values[(k * dims[1] + j) * dims[0] + i];
                assert!((f64::from(found) - want).abs() < 1e-6, "{dims:?} at {index:?}: {found} {want}");
            }
        }
    }

    #[test]
    fn parseval_holds_and_zero_rows_are_the_same_as_rows_of_zeros() {
        for dims in SIZES {
            let mut values = noise(dims.iter().product(), 3);
            values[..dims[0]].fill(0.0);
            let spectrum = forward(&Transform::<f64>::new(dims), &values);
            let sum: f64 = values.iter().map(|v| v * v).sum();
            assert!((spectrum.energy() - sum).abs() < 1e-12 * sum.max(1.0), "{dims:?}");
        }
    }

    #[test]
    fn a_wrong_window_is_refused_not_a_panic() {
        let plan = Transform::<f32>::new([4, 4, 4]);
        let window = Window { start: [0; 3], dims: [5, 1, 1] };
        assert!(plan.inverse(plan.spectrum(), window, &mut [0f32; 5], 5, |_, _| {}).is_err());
    }
}
