//! Panels of columns: gathered, transformed and scattered together, a few cache lines wide.

use super::transform::Real;
use ndarray::{ArrayViewMut2, Axis};
use rustfft::Fft;
use rustfft::num_complex::Complex;
use rustfft::num_traits::Zero;

/// Columns transformed together: two or four cache lines of complex numbers.
const PANEL: usize = 16;
/// Rows copied together between a plane and a panel.
const BLOCK: usize = 4;

/// Scratch for a panel of neighbouring columns: gathered, transformed, scattered.
pub(super) struct Panel<T> {
    pitch: usize,
    columns: Vec<Complex<T>>,
    transformed: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
}

impl<T: Real> Panel<T> {
    /// Scratch for the columns of a plan.
    pub fn new(plan: &dyn Fft<T>) -> Self {
        // Columns of a power of two would all fall into the same cache sets; a block more spreads them.
        let pitch = plan.len().next_multiple_of(BLOCK) + BLOCK;
        let zeros = |n| vec![Complex::zero(); n];
        Panel {
            pitch,
            columns: zeros(pitch * 2 * PANEL),
            transformed: zeros(pitch * 2 * PANEL),
            scratch: zeros(plan.get_outofplace_scratch_len()),
        }
    }

    /// Transforms every column of a contiguous plane.
    pub fn run_plane(&mut self, plan: &dyn Fft<T>, plane: &mut [Complex<T>], columns: usize) {
        if plan.len() == 1 {
            return;
        }
        if let Ok(sheet) = ArrayViewMut2::from_shape((plan.len(), columns), plane) {
            self.run(plan, sheet);
        }
    }

    /// Transforms every column of a sheet of shape `(length, columns)`, rows contiguous.
    pub fn run(&mut self, plan: &dyn Fft<T>, mut sheet: ArrayViewMut2<Complex<T>>) {
        let columns = sheet.ncols();
        let panels = (columns / PANEL).max(1);
        let width = columns.div_ceil(panels);
        for first in (0..columns).step_by(width) {
            let last = (first + width).min(columns);
            self.gather(&sheet, first, last);
            let columns = self.columns.chunks_exact_mut(self.pitch);
            let pairs = columns.zip(self.transformed.chunks_exact_mut(self.pitch));
            for (from, to) in pairs.take(last - first) {
                let n = plan.len();
                plan.process_outofplace_with_scratch(&mut from[..n], &mut to[..n], &mut self.scratch);
            }
            self.scatter(&mut sheet, first, last);
        }
    }

    /// Copies columns `first..last` of a sheet into the panel, four rows at a time.
    fn gather(&mut self, sheet: &ArrayViewMut2<Complex<T>>, first: usize, last: usize) {
        let width = last - first;
        let row = |z: usize| sheet.row(z).to_slice().and_then(|r| r.get(first..last)).unwrap_or(&[]);
        let whole = sheet.nrows() / BLOCK * BLOCK;
        for at in (0..whole).step_by(BLOCK) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|z| &row(at + z)[..width]);
            for (w, column) in self.columns.chunks_exact_mut(self.pitch).take(width).enumerate() {
                column[at..at + BLOCK].copy_from_slice(&[a[w], b[w], c[w], d[w]]);
            }
        }
        for z in whole..sheet.nrows() {
            let places = self.columns[z..].iter_mut().step_by(self.pitch);
            row(z).iter().zip(places).for_each(|(&v, place)| *place = v);
        }
    }

    /// Copies the transformed columns back to `first..last` of a sheet, four rows at a time.
    fn scatter(&self, sheet: &mut ArrayViewMut2<Complex<T>>, first: usize, last: usize) {
        let columns = self.transformed.chunks_exact(self.pitch).take(last - first);
        for (block, mut rows) in sheet.axis_chunks_iter_mut(Axis(0), BLOCK).enumerate() {
            let at = block * BLOCK;
            let mut rows = rows.outer_iter_mut().filter_map(|r| r.into_slice()?.get_mut(first..last));
            match [(); BLOCK].map(|()| rows.next()) {
                [Some(a), Some(b), Some(c), Some(d)] => {
                    let places = a.iter_mut().zip(b).zip(c.iter_mut().zip(d));
                    for (((a, b), (c, d)), column) in places.zip(columns.clone()) {
                        let four = &column[at..at + BLOCK];
                        (*a, *b, *c, *d) = (four[0], four[1], four[2], four[3]);
                    }
                }
                fewer => {
                    for (z, row) in fewer.into_iter().flatten().enumerate() {
                        row.iter_mut().zip(columns.clone()).for_each(|(v, column)| *v = column[at + z]);
                    }
                }
            }
        }
    }
}
