//! Real 3-D transforms, convolutions, dilations and openings of sets: `cargo bench --bench convolution`.

use amcheck::convolution::{Convolver, Precision, Real, RowContent, Transform, Window};
use amcheck::field::Indicator;
use amcheck::grid::Grid;
use amcheck::morphology::{StructuringElement, dilate, opening};
use amcheck::units::Length;
use divan::Bencher;

fn main() {
    divan::main();
}

const SIZES: [usize; 3] = [128, 256, 512];

fn noise<T: Real>(n: usize) -> Vec<T> {
    (0..n * n * n).map(|at| T::of((at * 2654435761 % 1021) as f64)).collect()
}

fn fill<T: Real>(values: &[T], n: usize) -> impl Fn(usize, usize, &mut [T]) -> RowContent + Sync + '_ {
    move |j, k, row| {
        row.copy_from_slice(&values[(k * n + j) * n..][..n]);
        RowContent::Filled
    }
}

/// The forward transform of a full field into a spectrum that is there already.
#[divan::bench(types = [f32, f64], args = SIZES, sample_count = 7, sample_size = 1)]
fn forward<T: Real>(bencher: Bencher, n: usize) {
    let plan = Transform::<T>::new([n; 3]);
    let (values, mut spectrum) = (noise::<T>(n), plan.spectrum());
    bencher.bench_local(|| plan.forward_into(&mut spectrum, fill(&values, n)));
}

/// Forward, times a kept spectrum, and back.
#[divan::bench(types = [f32, f64], args = SIZES, sample_count = 7, sample_size = 1)]
fn there_and_back<T: Real>(bencher: Bencher, n: usize) {
    let plan = Transform::<T>::new([n; 3]);
    let (values, mut spectrum) = (noise::<T>(n), plan.spectrum());
    let kept = plan.forward(fill(&values, n)).unwrap();
    let mut out = vec![T::of(0.0); n * n * n];
    bencher.bench_local(|| {
        plan.forward_into(&mut spectrum, fill(&values, n)).unwrap();
        spectrum.multiply(&kept).unwrap();
        let window = Window { start: [0; 3], dims: [n; 3] };
        plan.inverse_in_place(&mut spectrum, window, &mut out, n, |row, o| o.copy_from_slice(row)).unwrap();
    });
}

/// A ball of three eighths of the grid with a slit, as a set.
fn part(n: usize) -> Indicator {
    let grid = Grid::new([0.0; 3], Length::mm(1.0), [n; 3]).unwrap();
    Indicator::from_predicate(grid, |at| {
        let p = grid.index(at);
        let r2: usize = p.iter().map(|&i| i.abs_diff(n / 2).pow(2)).sum();
        r2 <= (3 * n / 8).pow(2) && p[0] != n / 2
    })
}

/// One convolution with an eighth of the grid, the part's spectrum kept: counts, exact.
#[divan::bench(args = [128, 224], sample_count = 5, sample_size = 1)]
fn convolve_with_kept_spectrum(bencher: Bencher, n: usize) {
    let element = part(n / 8);
    let convolver = Convolver::new(&part(n), [n / 8; 3]).unwrap();
    convolver.convolve_in(Precision::Double, &element).unwrap();
    bencher.bench_local(|| convolver.convolve_in(Precision::Double, &element).unwrap());
}

/// Dilation by a digital ball of radius 10, whatever path is cheapest.
#[divan::bench(args = [256, 512], sample_count = 5, sample_size = 1)]
fn dilate_by_a_ball(bencher: Bencher, n: usize) {
    let (set, ball) = (part(n), StructuringElement::ball(Length::mm(10.0), Length::mm(1.0)).unwrap());
    bencher.bench_local(|| dilate(&set, &ball).unwrap());
}

/// Opening by a digital ball of radius 10.
#[divan::bench(args = [256, 512], sample_count = 3, sample_size = 1)]
fn open_by_a_ball(bencher: Bencher, n: usize) {
    let (set, ball) = (part(n), StructuringElement::ball(Length::mm(10.0), Length::mm(1.0)).unwrap());
    bencher.bench_local(|| opening(&set, &ball).unwrap());
}
