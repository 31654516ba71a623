//! Real transforms of eight neighbouring rows at once, a row to a lane.
//!
//! A row of even length is taken as one of half the length with the odd samples for imaginary parts, whose spectrum
//! tells the two apart by symmetry; one of odd length as it stands.

use super::column::{ColumnPlan, ColumnScratch, Way, twiddle};
use super::lanes::{Strip, WIDTH, Wide};
use super::transform::{Engine, Real};
use ndarray::ArrayViewMut1;
use pulp::{Arch, Simd, WithSimd};

/// Rows transformed together.
pub(super) const ROWS: usize = WIDTH;

/// Strips that a half spectrum of so many samples takes; what is beyond it in the last one is zero.
pub(super) fn strips(samples: usize) -> usize {
    (samples / 2 + 1).div_ceil(WIDTH)
}

/// Plans for real rows of one length.
pub(super) struct RowPlan<T: Real> {
    len: usize,
    inner: ColumnPlan<T>,
    /// `exp(−2πi k/n)`, that the halves of a row are told apart by.
    twiddles: Vec<[T; 2]>,
    arch: Arch,
}

/// Eight rows, and the room to transform them.
pub(super) struct RowScratch<T> {
    rows: Vec<T>,
    /// A strip to a frequency, a lane to a row.
    strips: Vec<Strip<T>>,
    inner: ColumnScratch<T>,
}

impl<T: Real> RowScratch<T> {
    /// One of the rows.
    pub fn row(&mut self, at: usize) -> &mut [T] {
        let len = self.rows.len() / ROWS;
        &mut self.rows[at * len..][..len]
    }
}

impl<T: Real> RowPlan<T> {
    pub fn new(len: usize) -> Self {
        let inner = ColumnPlan::new(if len.is_multiple_of(2) { len / 2 } else { len }, Engine::Lanes);
        let twiddles = (0..=inner.len() / 2).map(|k| twiddle(k, len)).collect();
        RowPlan { len, inner, twiddles, arch: Arch::new() }
    }

    pub fn scratch(&self) -> RowScratch<T> {
        RowScratch {
            rows: vec![T::zero(); ROWS * self.len],
            strips: vec![Strip::default(); (self.inner.len() + 1).next_multiple_of(WIDTH)],
            inner: self.inner.scratch(),
        }
    }

    /// The half spectra of the rows in the scratch, one after another; fewer than eight where `spectra` ends.
    pub fn forward(&self, scratch: &mut RowScratch<T>, spectra: &mut [Strip<T>]) {
        self.arch.dispatch(Gather { len: self.len, scratch });
        self.transform(Way::There, scratch);
        self.arch.dispatch(Split { plan: self, scratch, spectra });
    }

    /// The rows of eight half spectra, times their length, into the scratch. Imaginary parts at the two self-mirrored
    /// frequencies are rounding, and passed over.
    pub fn back(&self, scratch: &mut RowScratch<T>, spectra: [&[Strip<T>]; ROWS]) {
        self.arch.dispatch(Join { plan: self, scratch, spectra });
        self.transform(Way::Back, scratch);
        self.arch.dispatch(Scatter { len: self.len, scratch });
    }

    fn transform(&self, way: Way, scratch: &mut RowScratch<T>) {
        let strips = &mut scratch.strips[..self.inner.len()];
        self.inner.run(way, ArrayViewMut1::from(strips), &mut scratch.inner);
    }

    fn is_halved(&self) -> bool {
        self.len.is_multiple_of(2)
    }
}

/// Equal parts of a buffer.
#[inline(always)]
fn eight_rows<T>(rows: &[T], len: usize) -> [&[T]; ROWS] {
    let row = |r: usize| &rows[r * len..][..len];
    [row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7)]
}

#[inline(always)]
fn eight<T>(row: &[T], at: usize) -> &[T; WIDTH] {
    &row.as_chunks().0[at]
}

/// Samples of eight rows, a lane each.
struct Gather<'a, T> {
    len: usize,
    scratch: &'a mut RowScratch<T>,
}

impl<T: Real> WithSimd for Gather<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let RowScratch { rows, strips, .. } = self.scratch;
        let rows = eight_rows(rows, self.len);
        if !self.len.is_multiple_of(2) {
            for (x, strip) in strips.iter_mut().enumerate().take(self.len) {
                *strip = Strip { re: rows.map(|row| row[x]), im: [T::zero(); WIDTH] };
            }
            return;
        }
        for (at, four) in strips.as_chunks_mut::<{ WIDTH / 2 }>().0.iter_mut().enumerate().take(self.len / WIDTH) {
            let [a, b, c, d, e, f, g, h] = rows;
            let samples = [
                eight(a, at),
                eight(b, at),
                eight(c, at),
                eight(d, at),
                eight(e, at),
                eight(f, at),
                eight(g, at),
                eight(h, at),
            ];
            let [a, b, c, d, e, f, g, h] = T::transposed(simd, samples);
            four[0] = Strip { re: a, im: b };
            four[1] = Strip { re: c, im: d };
            four[2] = Strip { re: e, im: f };
            four[3] = Strip { re: g, im: h };
        }
        for x in (self.len / WIDTH * WIDTH..self.len).step_by(2) {
            strips[x / 2] = Strip { re: rows.map(|row| row[x]), im: rows.map(|row| row[x + 1]) };
        }
    }
}

/// The spectra of even and odd samples told apart and put together, and written row by row.
struct Split<'a, T: Real> {
    plan: &'a RowPlan<T>,
    scratch: &'a mut RowScratch<T>,
    spectra: &'a mut [Strip<T>],
}

impl<T: Real> WithSimd for Split<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let strips = &mut self.scratch.strips[..];
        let half = self.plan.len / 2;
        if self.plan.is_halved() {
            let [even, odd] = [strips[0].re, strips[0].im];
            let nothing = [T::zero(); WIDTH];
            strips[0] = Strip { re: std::array::from_fn(|r| even[r] + odd[r]), im: nothing };
            strips[half] = Strip { re: std::array::from_fn(|r| even[r] - odd[r]), im: nothing };
            for (k, &twiddle) in self.plan.twiddles.iter().enumerate().skip(1) {
                for lane in 0..Wide::<T, S>::COUNT {
                    let a = Wide::read(simd, &strips[k], lane).scaled(T::of(0.5));
                    let b = Wide::read(simd, &strips[half - k], lane).scaled(T::of(0.5)).conjugate();
                    let (even, odd) = (a.plus(b), a.minus(b).turned(twiddle));
                    even.minus_i(odd).write(&mut strips[k], lane);
                    even.plus_i(odd).conjugate().write(&mut strips[half - k], lane);
                }
            }
        } else {
            strips[half + 1..].fill(Strip::default());
        }
        let width = super::row::strips(self.plan.len);
        for (at, eight) in strips.as_chunks::<WIDTH>().0.iter().enumerate().take(width) {
            let [a, b, c, d, e, f, g, h] = eight;
            let re = T::transposed(simd, [&a.re, &b.re, &c.re, &d.re, &e.re, &f.re, &g.re, &h.re]);
            let im = T::transposed(simd, [&a.im, &b.im, &c.im, &d.im, &e.im, &f.im, &g.im, &h.im]);
            for (r, row) in self.spectra.chunks_exact_mut(width).enumerate() {
                row[at] = Strip { re: re[r], im: im[r] };
            }
        }
    }
}

/// The reverse of [`Split`], times two.
struct Join<'a, T: Real> {
    plan: &'a RowPlan<T>,
    scratch: &'a mut RowScratch<T>,
    spectra: [&'a [Strip<T>]; ROWS],
}

impl<T: Real> WithSimd for Join<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let strips = &mut self.scratch.strips[..];
        for (at, eight) in strips.as_chunks_mut::<WIDTH>().0.iter_mut().enumerate().take(self.spectra[0].len()) {
            let [a, b, c, d, e, f, g, h] = self.spectra;
            let [a, b, c, d, e, f, g, h] = [&a[at], &b[at], &c[at], &d[at], &e[at], &f[at], &g[at], &h[at]];
            let re = T::transposed(simd, [&a.re, &b.re, &c.re, &d.re, &e.re, &f.re, &g.re, &h.re]);
            let im = T::transposed(simd, [&a.im, &b.im, &c.im, &d.im, &e.im, &f.im, &g.im, &h.im]);
            for (r, strip) in eight.iter_mut().enumerate() {
                *strip = Strip { re: re[r], im: im[r] };
            }
        }
        let half = self.plan.len / 2;
        if !self.plan.is_halved() {
            strips[0].im = [T::zero(); WIDTH];
            for k in 1..=half {
                let Strip { re, im } = strips[k];
                strips[self.plan.len - k] = Strip { re, im: im.map(|v| T::zero() - v) };
            }
            return;
        }
        let [mean, highest] = [strips[0].re, strips[half].re];
        let sum = |sign: T| std::array::from_fn(|r| mean[r] + sign * highest[r]);
        strips[0] = Strip { re: sum(T::one()), im: sum(T::zero() - T::one()) };
        for (k, &[c, s]) in self.plan.twiddles.iter().enumerate().skip(1) {
            for lane in 0..Wide::<T, S>::COUNT {
                let a = Wide::read(simd, &strips[k], lane);
                let b = Wide::read(simd, &strips[half - k], lane).conjugate();
                let (even, odd) = (a.plus(b), a.minus(b).turned([c, T::zero() - s]));
                even.plus_i(odd).write(&mut strips[k], lane);
                even.minus_i(odd).conjugate().write(&mut strips[half - k], lane);
            }
        }
    }
}

/// The reverse of [`Gather`].
struct Scatter<'a, T> {
    len: usize,
    scratch: &'a mut RowScratch<T>,
}

impl<T: Real> WithSimd for Scatter<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let RowScratch { rows, strips, .. } = self.scratch;
        let halved = self.len.is_multiple_of(2);
        let whole = if halved { self.len / WIDTH } else { 0 };
        for (at, four) in strips.as_chunks::<{ WIDTH / 2 }>().0.iter().enumerate().take(whole) {
            let [a, b, c, d] = four;
            let samples = T::transposed(simd, [&a.re, &a.im, &b.re, &b.im, &c.re, &c.im, &d.re, &d.im]);
            for (r, row) in rows.chunks_exact_mut(self.len).enumerate() {
                row[at * WIDTH..][..WIDTH].copy_from_slice(&samples[r]);
            }
        }
        for (r, row) in rows.chunks_exact_mut(self.len).enumerate() {
            for x in whole * WIDTH..self.len {
                row[x] = match (halved, x % 2) {
                    (false, _) => strips[x].re[r],
                    (true, 0) => strips[x / 2].re[r],
                    (true, _) => strips[x / 2].im[r],
                };
            }
        }
    }
}
