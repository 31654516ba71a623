//! The spectrum of a real field.

use super::transform::Real;
use crate::error::{Error, Result};
use rayon::prelude::*;
use rustfft::num_complex::Complex;

/// The half spectrum of a real field: frequencies `0 ..= nx/2` along x, all along y and z.
#[derive(Debug, Clone)]
pub struct Spectrum<T> {
    pub(super) dims: [usize; 3],
    pub(super) plane_pitch: usize,
    pub(super) values: Vec<Complex<T>>,
}

impl<T: Real> Spectrum<T> {
    /// The counts of the real field the spectrum belongs to.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Frequencies kept along x.
    pub fn columns(&self) -> usize {
        self.dims[0] / 2 + 1
    }

    /// The coefficient at a frequency; the first index is at most `nx/2`.
    pub fn at(&self, [p, q, r]: [usize; 3]) -> Complex<T> {
        self.values[r * self.plane_pitch + q * self.columns() + p]
    }

    /// Multiplies by another spectrum, frequency by frequency: the spectrum of the cyclic convolution.
    ///
    /// # Errors
    /// [`Error::Internal`] if the spectra are of different sizes; so for [`Spectrum::multiply_conjugate`].
    pub fn multiply(&mut self, other: &Self) -> Result<()> {
        self.combine(other, |a, b| a * b)
    }

    /// Multiplies another spectrum by the conjugate of this one, in place: the spectrum of the cyclic correlation
    /// `t ↦ Σ_x other(x)·self(x − t)`.
    pub fn multiply_conjugate(&mut self, other: &Self) -> Result<()> {
        self.combine(other, |a, b| b * a.conj())
    }

    /// Applies a function to every coefficient with its frequency `[p, q, r]`, planes in parallel.
    pub fn map(&mut self, change: impl Fn([usize; 3], Complex<T>) -> Complex<T> + Sync) {
        let (columns, ny) = (self.columns(), self.dims[1]);
        self.values.par_chunks_mut(self.plane_pitch).enumerate().for_each(|(r, plane)| {
            for (at, value) in plane.iter_mut().take(columns * ny).enumerate() {
                *value = change([at % columns, at / columns, r], *value);
            }
        });
    }

    /// `Σ_ω |f̂(ω)|² / N` over the whole spectrum: by Parseval the sum of the squared samples.
    pub fn energy(&self) -> f64 {
        let (columns, ny) = (self.columns(), self.dims[1]);
        let even = self.dims[0].is_multiple_of(2);
        let planes: Vec<f64> = self
            .values
            .par_chunks(self.plane_pitch)
            .map(|plane| {
                let weighted = plane.iter().take(columns * ny).enumerate().map(|(at, value)| {
                    let p = at % columns;
                    let own_mirror = p == 0 || (even && p == columns - 1);
                    let (re, im): (f64, f64) = (value.re.into(), value.im.into());
                    (re * re + im * im) * if own_mirror { 1.0 } else { 2.0 }
                });
                weighted.sum()
            })
            .collect();
        planes.iter().sum::<f64>() / self.dims.iter().product::<usize>() as f64
    }

    fn combine(&mut self, other: &Self, op: impl Fn(Complex<T>, Complex<T>) -> Complex<T> + Sync) -> Result<()> {
        if self.dims != other.dims {
            return Err(Error::Internal { problem: format!("spectra of {:?} and {:?}", self.dims, other.dims) });
        }
        let chunk = self.plane_pitch;
        self.values.par_chunks_mut(chunk).zip(other.values.par_chunks(chunk)).for_each(|(mine, theirs)| {
            mine.iter_mut().zip(theirs).for_each(|(a, &b)| *a = op(*a, b));
        });
        Ok(())
    }
}
