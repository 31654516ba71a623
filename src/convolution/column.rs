//! Complex transforms of eight neighbouring columns at once.
//!
//! J. W. Cooley and J. W. Tukey's algorithm in the order of T. G. Stockham (1966), that needs no sorting: each pass
//! takes a factor r of the length, reads r strips and writes r strips, and all eight columns use the same twiddle
//! factors. The first pass reads where the columns stand and the last one writes there, so nothing is gathered.

use super::lanes::{Strip, WIDTH, Wide};
use super::transform::{Engine, Real};
use ndarray::ArrayViewMut1;
use pulp::{Arch, Simd, WithSimd};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Which way a transform goes; neither is divided by the length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// `f̂(k) = Σ_x f(x)·exp(−2πi kx/n)`.
    There,
    /// `f(x) = Σ_k f̂(k)·exp(2πi kx/n)`: the transform there, read in the opposite order.
    Back,
}

/// Twiddle factors and the order of passes for columns of one length.
pub(super) struct ColumnPlan<T: Real> {
    len: usize,
    passes: Vec<Pass<T>>,
    /// One column after another: where it is chosen, and for lengths with prime factors above 5, which no padded grid has.
    library: Option<Arc<dyn Fft<T>>>,
    arch: Arch,
}

/// Where columns are transformed.
pub(super) struct ColumnScratch<T> {
    /// Two buffers that passes read and write in turn: 32 KiB, a first cache, for 256 numbers of single precision.
    lanes: [Vec<Strip<T>>; 2],
    /// Eight columns, and the library's own scratch.
    columns: [Vec<Complex<T>>; 2],
}

/// One factor: `groups` sub-transforms of `radix` points, `stride` of them side by side.
struct Pass<T> {
    radix: usize,
    groups: usize,
    stride: usize,
    /// `radix − 1` to a group.
    twiddles: Vec<[T; 2]>,
}

/// `exp(−2πi k/n)`.
pub(super) fn twiddle<T: Real>(k: usize, n: usize) -> [T; 2] {
    let (sine, cosine) = (-TAU * k as f64 / n as f64).sin_cos();
    [T::of(cosine), T::of(sine)]
}

impl<T: Real> ColumnPlan<T> {
    pub fn new(len: usize, engine: Engine) -> Self {
        let factors = factors(len).filter(|_| engine == Engine::Lanes);
        let library = factors.is_none().then(|| FftPlanner::new().plan_fft_forward(len));
        let mut stride = 1;
        let passes = factors.into_iter().flatten().map(|radix| {
            let (rest, before) = (len / stride, stride);
            stride *= radix;
            let groups = rest / radix;
            let turns = (0..groups).flat_map(|p| (1..radix).map(move |k| twiddle(p * k, rest)));
            Pass { radix, groups, stride: before, twiddles: turns.collect() }
        });
        ColumnPlan { len, passes: passes.collect(), library, arch: Arch::new() }
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn scratch(&self) -> ColumnScratch<T> {
        let columns = self.library.as_ref().map_or([0; 2], |fft| [WIDTH * self.len, fft.get_inplace_scratch_len()]);
        let lanes = if self.library.is_some() { 0 } else { self.len };
        ColumnScratch {
            lanes: [(); 2].map(|()| vec![Strip::default(); lanes]),
            columns: columns.map(|len| vec![Complex::default(); len]),
        }
    }

    /// Transforms the columns in place; they are as long as planned, or nothing happens.
    pub fn run(&self, way: Way, column: ArrayViewMut1<Strip<T>>, scratch: &mut ColumnScratch<T>) {
        if column.len() == self.len {
            let column = Column { strips: column, way };
            self.arch.dispatch(Run { plan: self, column, scratch });
        }
    }
}

/// The factors of a length, large ones last, where twiddle factors are spared; none if a prime above 5 is left.
fn factors(len: usize) -> Option<Vec<usize>> {
    let (mut rest, mut factors) = (len, Vec::new());
    for prime in [5, 3] {
        while rest.is_multiple_of(prime) {
            factors.push(prime);
            rest /= prime;
        }
    }
    let mut twos = rest.is_power_of_two().then(|| rest.trailing_zeros())?;
    let odd = factors.len();
    while twos > 0 {
        let bits = match twos {
            1 => 1,
            2 | 4 => 2,
            _ => 3,
        };
        factors.insert(odd, 1 << bits);
        twos -= bits;
    }
    Some(factors)
}

/// Strips that a pass reads or writes.
trait Strips<T> {
    fn strip(&self, at: usize) -> &Strip<T>;
    fn strip_mut(&mut self, at: usize) -> &mut Strip<T>;
}

impl<T> Strips<T> for [Strip<T>] {
    #[inline(always)]
    fn strip(&self, at: usize) -> &Strip<T> {
        &self[at]
    }
    #[inline(always)]
    fn strip_mut(&mut self, at: usize) -> &mut Strip<T> {
        &mut self[at]
    }
}

/// Columns where they stand, written in the order of a way.
struct Column<'a, T> {
    strips: ArrayViewMut1<'a, Strip<T>>,
    way: Way,
}

impl<T> Strips<T> for Column<'_, T> {
    #[inline(always)]
    fn strip(&self, at: usize) -> &Strip<T> {
        &self.strips[at]
    }
    #[inline(always)]
    fn strip_mut(&mut self, at: usize) -> &mut Strip<T> {
        match self.way {
            Way::Back if at > 0 => {
                let opposite = self.strips.len() - at;
                &mut self.strips[opposite]
            }
            _ => &mut self.strips[at],
        }
    }
}

struct Run<'a, 'b, T: Real> {
    plan: &'a ColumnPlan<T>,
    column: Column<'b, T>,
    scratch: &'a mut ColumnScratch<T>,
}

impl<T: Real> WithSimd for Run<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        if let Some(fft) = &self.plan.library {
            return one_by_one(&**fft, &mut self.column, &mut self.scratch.columns);
        }
        let Some((first, later)) = self.plan.passes.split_first() else { return };
        let [from, to] = &mut self.scratch.lanes;
        let (mut from, mut to) = (&mut from[..], &mut to[..]);
        first.run(simd, &self.column, from);
        let Some((last, middle)) = later.split_last() else {
            from.iter().enumerate().for_each(|(at, strip)| *self.column.strip_mut(at) = *strip);
            return;
        };
        for pass in middle {
            pass.run(simd, from, to);
            std::mem::swap(&mut from, &mut to);
        }
        last.run(simd, from, &mut self.column);
    }
}

impl<T: Real> Pass<T> {
    #[inline(always)]
    fn run<S: Simd>(&self, simd: S, from: &(impl Strips<T> + ?Sized), to: &mut (impl Strips<T> + ?Sized)) {
        match self.radix {
            2 => self.each::<S, 2>(simd, from, to),
            3 => self.each::<S, 3>(simd, from, to),
            4 => self.each::<S, 4>(simd, from, to),
            5 => self.each::<S, 5>(simd, from, to),
            _ => self.each::<S, 8>(simd, from, to),
        }
    }

    #[inline(always)]
    fn each<S: Simd, const R: usize>(
        &self,
        simd: S,
        from: &(impl Strips<T> + ?Sized),
        to: &mut (impl Strips<T> + ?Sized),
    ) {
        let (groups, stride) = (self.groups, self.stride);
        for (group, twiddles) in self.twiddles.chunks_exact(R - 1).enumerate() {
            for at in 0..stride {
                for lane in 0..Wide::<T, S>::COUNT {
                    let mut points = [Wide::read(simd, from.strip(at + stride * group), lane); R];
                    for (k, point) in points.iter_mut().enumerate().skip(1) {
                        *point = Wide::read(simd, from.strip(at + stride * (group + k * groups)), lane);
                    }
                    let sums = butterfly(points);
                    sums[0].write(to.strip_mut(at + stride * R * group), lane);
                    for k in 1..R {
                        // The factors of the first group are all 1, and the last pass has no other.
                        let sum = if group == 0 { sums[k] } else { sums[k].turned(twiddles[k - 1]) };
                        sum.write(to.strip_mut(at + stride * (R * group + k)), lane);
                    }
                }
            }
        }
    }
}

/// The transform of R points.
#[inline(always)]
fn butterfly<T: Real, S: Simd, const R: usize>(a: [Wide<T, S>; R]) -> [Wide<T, S>; R] {
    let mut y = a;
    match R {
        2 => [y[0], y[1]] = [a[0].plus(a[1]), a[0].minus(a[1])],
        3 => {
            let sum = a[1].plus(a[2]);
            let middle = a[0].minus(sum.scaled(T::of(0.5)));
            let side = a[1].minus(a[2]).scaled(T::of(0.75f64.sqrt()));
            [y[0], y[1], y[2]] = [a[0].plus(sum), middle.minus_i(side), middle.plus_i(side)];
        }
        4 => [y[0], y[1], y[2], y[3]] = four([a[0], a[1], a[2], a[3]]),
        5 => {
            let (sin1, cos1) = (TAU / 5.0).sin_cos();
            let (sin2, cos2) = (2.0 * TAU / 5.0).sin_cos();
            let [sin1, cos1, sin2, cos2] = [sin1, cos1, sin2, cos2].map(T::of);
            let (outer, inner) = (a[1].plus(a[4]), a[2].plus(a[3]));
            let (outer_side, inner_side) = (a[1].minus(a[4]), a[2].minus(a[3]));
            let first = a[0].plus(outer.scaled(cos1)).plus(inner.scaled(cos2));
            let second = a[0].plus(outer.scaled(cos2)).plus(inner.scaled(cos1));
            let first_side = outer_side.scaled(sin1).plus(inner_side.scaled(sin2));
            let second_side = outer_side.scaled(sin2).minus(inner_side.scaled(sin1));
            y[0] = a[0].plus(outer).plus(inner);
            [y[1], y[4]] = [first.minus_i(first_side), first.plus_i(first_side)];
            [y[2], y[3]] = [second.minus_i(second_side), second.plus_i(second_side)];
        }
        _ => {
            let even = four([a[0], a[2], a[4], a[6]]);
            let odd = four([a[1], a[3], a[5], a[7]]);
            let half = T::of(0.5f64.sqrt());
            let one = odd[1].minus_i(odd[1]).scaled(half);
            let three = odd[3].plus_i(odd[3]).scaled(half);
            [y[0], y[4]] = [even[0].plus(odd[0]), even[0].minus(odd[0])];
            [y[1], y[5]] = [even[1].plus(one), even[1].minus(one)];
            [y[2], y[6]] = [even[2].minus_i(odd[2]), even[2].plus_i(odd[2])];
            [y[3], y[7]] = [even[3].minus(three), even[3].plus(three)];
        }
    }
    y
}

#[inline(always)]
fn four<T: Real, S: Simd>(a: [Wide<T, S>; 4]) -> [Wide<T, S>; 4] {
    let (even, even_side) = (a[0].plus(a[2]), a[0].minus(a[2]));
    let (odd, odd_side) = (a[1].plus(a[3]), a[1].minus(a[3]));
    [even.plus(odd), even_side.minus_i(odd_side), even.minus(odd), even_side.plus_i(odd_side)]
}

/// Strips that are spread over the columns together: a cache line of each column in double precision.
const BLOCK: usize = 4;

#[inline(always)]
fn one_by_one<T: Real>(fft: &dyn Fft<T>, column: &mut Column<T>, [columns, scratch]: &mut [Vec<Complex<T>>; 2]) {
    let len = fft.len();
    for first in (0..len).step_by(BLOCK) {
        let count = BLOCK.min(len - first);
        let mut block = [Strip::default(); BLOCK];
        (0..count).for_each(|k| block[k] = *column.strip(first + k));
        for (lane, one) in columns.chunks_exact_mut(len).enumerate() {
            for (number, strip) in one[first..first + count].iter_mut().zip(&block) {
                *number = Complex::new(strip.re[lane], strip.im[lane]);
            }
        }
    }
    fft.process_with_scratch(columns, scratch);
    for first in (0..len).step_by(BLOCK) {
        let count = BLOCK.min(len - first);
        let mut block = [Strip::default(); BLOCK];
        for (lane, one) in columns.chunks_exact(len).enumerate() {
            for (number, strip) in one[first..first + count].iter().zip(&mut block) {
                (strip.re[lane], strip.im[lane]) = (number.re, number.im);
            }
        }
        (0..count).for_each(|k| *column.strip_mut(first + k) = block[k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array1;

    fn noise(len: usize) -> Array1<Strip<f64>> {
        let number = |at: usize| (at * 2654435761 % 1021) as f64 / 1021.0 - 0.5;
        let half = |at: usize| std::array::from_fn(|lane| number(at * WIDTH + lane));
        (0..len).map(|at| Strip { re: half(2 * at), im: half(2 * at + 1) }).collect()
    }

    #[test]
    fn factors_multiply_to_the_length_and_large_primes_have_none() {
        for len in 1..2000 {
            let rest = [2, 3, 5].into_iter().fold(len, |mut rest, prime| {
                while rest % prime == 0 {
                    rest /= prime;
                }
                rest
            });
            assert_eq!(factors(len).map(|f| f.into_iter().product()), (rest == 1).then_some(len));
        }
        assert_eq!(factors(128), Some(vec![4, 4, 8]));
    }

    #[test]
    fn every_lane_is_the_plain_sum_and_the_way_back_leads_back() {
        let lengths = || (1..=50).chain([64, 75, 128]);
        let both = [Engine::Lanes, Engine::Library].into_iter().flat_map(|e| lengths().map(move |len| (e, len)));
        for (engine, len) in both {
            let (plan, before) = (ColumnPlan::<f64>::new(len, engine), noise(len));
            let (mut after, mut scratch) = (before.clone(), plan.scratch());
            plan.run(Way::There, after.view_mut(), &mut scratch);
            for (k, lane) in (0..len).flat_map(|k| (0..WIDTH).map(move |lane| (k, lane))) {
                let want: Complex<f64> = before
                    .iter()
                    .enumerate()
                    .map(|(x, f)| {
                        let turn = -TAU * (k * x % len) as f64 / len as f64;
                        Complex::new(f.re[lane], f.im[lane]) * Complex::from_polar(1.0, turn)
                    })
                    .sum();
                let off = Complex::new(after[k].re[lane], after[k].im[lane]) - want;
                assert!(off.norm() < 1e-13, "{len}: {k} in lane {lane} is off by {off}");
            }
            plan.run(Way::Back, after.view_mut(), &mut scratch);
            for (a, b) in before.iter().zip(&after) {
                let parts = a.re.iter().chain(&a.im).zip(b.re.iter().chain(&b.im));
                parts.for_each(|(a, b)| assert!((a - b / len as f64).abs() < 1e-14, "{len}: {a} {b}"));
            }
        }
    }

    #[test]
    fn every_machine_rounds_alike() {
        for len in [16, 45, 128] {
            let plan = ColumnPlan::<f64>::new(len, Engine::Lanes);
            let (mut wide, mut narrow) = (noise(len), noise(len));
            plan.run(Way::There, wide.view_mut(), &mut plan.scratch());
            let column = Column { strips: narrow.view_mut(), way: Way::There };
            Run { plan: &plan, column, scratch: &mut plan.scratch() }.with_simd(pulp::Scalar::new());
            assert_eq!(wide, narrow);
        }
    }
}
