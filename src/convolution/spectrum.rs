//! The spectrum of a real field.

use super::lanes::{Strip, WIDTH};
use super::row::strips;
use super::transform::Real;
use crate::error::{Error, Result};
use pulp::Arch;
use rayon::prelude::*;
use rustfft::num_complex::Complex;

/// The half spectrum of a real field: frequencies `0 ..= nx/2` along x, all along y and z.
///
/// Kept eight frequencies along x to a strip; the last strip of a row is filled up with zeros.
#[derive(Debug, Clone)]
pub struct Spectrum<T> {
    pub(super) dims: [usize; 3],
    pub(super) plane_pitch: usize,
    pub(super) values: Vec<Strip<T>>,
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
        let strip = &self.values[r * self.plane_pitch + q * strips(self.dims[0]) + p / WIDTH];
        Complex::new(strip.re[p % WIDTH], strip.im[p % WIDTH])
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
        let (columns, width) = (self.columns(), strips(self.dims[0]));
        let len = width * self.dims[1];
        self.values.par_chunks_mut(self.plane_pitch).enumerate().for_each(|(r, plane)| {
            for (at, strip) in plane[..len].iter_mut().enumerate() {
                let (first, q) = (at % width * WIDTH, at / width);
                for (lane, p) in (0..WIDTH).zip(first..columns) {
                    let value = change([p, q, r], Complex::new(strip.re[lane], strip.im[lane]));
                    (strip.re[lane], strip.im[lane]) = (value.re, value.im);
                }
            }
        });
    }

    /// `Σ_ω |f̂(ω)|² / N` over the whole spectrum: by Parseval the sum of the squared samples.
    pub fn energy(&self) -> f64 {
        let (columns, width) = (self.columns(), strips(self.dims[0]));
        let len = width * self.dims[1];
        let even = self.dims[0].is_multiple_of(2);
        let planes: Vec<f64> = self
            .values
            .par_chunks(self.plane_pitch)
            .map(|plane| {
                let weighted = plane[..len].iter().enumerate().flat_map(|(at, strip)| {
                    strip.re.iter().zip(&strip.im).zip(at % width * WIDTH..columns).map(move |((&re, &im), p)| {
                        let own_mirror = p == 0 || (even && p == columns - 1);
                        let (re, im): (f64, f64) = (re.into(), im.into());
                        (re * re + im * im) * if own_mirror { 1.0 } else { 2.0 }
                    })
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
        let (arch, chunk) = (Arch::new(), self.plane_pitch);
        self.values.par_chunks_mut(chunk).zip(other.values.par_chunks(chunk)).for_each(|(mine, theirs)| {
            arch.dispatch(|| {
                for (a, b) in mine.iter_mut().zip(theirs) {
                    for lane in 0..WIDTH {
                        let [x, y] = [&*a, b].map(|strip| Complex::new(strip.re[lane], strip.im[lane]));
                        let value = op(x, y);
                        (a.re[lane], a.im[lane]) = (value.re, value.im);
                    }
                }
            });
        });
        Ok(())
    }
}
