//! Real 3-D transforms and convolutions: `cargo bench --bench convolution`.

use amcheck::convolution::{Real, RowContent, Transform, Window};
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

/// Forward and back.
#[divan::bench(types = [f32, f64], args = SIZES, sample_count = 7, sample_size = 1)]
fn there_and_back<T: Real>(bencher: Bencher, n: usize) {
    let plan = Transform::<T>::new([n; 3]);
    let (values, mut spectrum) = (noise::<T>(n), plan.spectrum());
    let mut out = vec![T::of(0.0); n * n * n];
    bencher.bench_local(|| {
        plan.forward_into(&mut spectrum, fill(&values, n)).unwrap();
        let window = Window { start: [0; 3], dims: [n; 3] };
        plan.inverse_in_place(&mut spectrum, window, &mut out, n, |row, o| o.copy_from_slice(row)).unwrap();
    });
}
