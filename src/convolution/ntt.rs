//! Convolution of counts in integers: a number-theoretic transform modulo 2013265921.
//!
//! Exact for every count below the modulus, whatever the sizes; slower than floating point, and therefore taken only
//! where the floating-point bound does not suffice, and as the oracle of the tests.

use super::precision::MODULUS;
use ndarray::{Array3, ArrayViewMut2, Axis};
use rayon::prelude::*;

/// A generator of the multiplicative group modulo [`MODULUS`].
const GENERATOR: u32 = 31;

/// Roots of unity for one power-of-two length.
struct Roots {
    powers: Vec<u32>,
}

/// Which way a transform goes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    Forward,
    Inverse,
}

impl Roots {
    fn new(length: usize, direction: Direction) -> Self {
        let primitive = power(GENERATOR, (MODULUS - 1) / length as u32);
        let root = if direction == Direction::Forward { primitive } else { power(primitive, MODULUS - 2) };
        let powers = std::iter::successors(Some(1), |&p| Some(multiply(p, root))).take(length / 2 + 1).collect();
        Roots { powers }
    }

    /// Cooley and Tukey's transform in place: bit reversal, then butterflies of growing length.
    fn run(&self, values: &mut [u32]) {
        let n = values.len();
        if n < 2 {
            return;
        }
        let shift = usize::BITS - n.trailing_zeros();
        for i in 0..n {
            let j = i.reverse_bits() >> shift;
            if i < j {
                values.swap(i, j);
            }
        }
        let mut half = 1;
        while half < n {
            let step = n / (2 * half);
            for block in values.chunks_exact_mut(2 * half) {
                let (low, high) = block.split_at_mut(half);
                for (at, (a, b)) in low.iter_mut().zip(high).enumerate() {
                    let turned = multiply(*b, self.powers[at * step]);
                    (*a, *b) = (add(*a, turned), add(*a, MODULUS - turned));
                }
            }
            half *= 2;
        }
    }
}

/// The cyclic convolution of two arrays of counts modulo [`MODULUS`]; every side a power of two.
///
/// # Cost
/// Three transforms of `N·log2 N` modular products, two arrays.
pub(super) fn cyclic_convolution(mut a: Array3<u32>, mut b: Array3<u32>) -> Array3<u32> {
    transform(&mut a, Direction::Forward);
    transform(&mut b, Direction::Forward);
    let scale = power((a.len() as u64 % u64::from(MODULUS)) as u32, MODULUS - 2);
    ndarray::Zip::from(&mut a).and(&b).par_for_each(|a, &b| *a = multiply(multiply(*a, b), scale));
    transform(&mut a, Direction::Inverse);
    a
}

fn transform(values: &mut Array3<u32>, direction: Direction) {
    let (nz, ny, nx) = values.dim();
    let [along_x, along_y, along_z] = [nx, ny, nz].map(|n| Roots::new(n, direction));
    values.axis_iter_mut(Axis(0)).into_par_iter().for_each_init(
        || vec![0; ny],
        |column, mut plane| {
            plane.rows_mut().into_iter().filter_map(|row| row.into_slice()).for_each(|row| along_x.run(row));
            columns(&along_y, &mut plane, column);
        },
    );
    values
        .axis_iter_mut(Axis(1))
        .into_par_iter()
        .for_each_init(|| vec![0; nz], |column, mut sheet| columns(&along_z, &mut sheet, column));
}

fn columns(roots: &Roots, sheet: &mut ArrayViewMut2<u32>, column: &mut [u32]) {
    for mut lane in sheet.columns_mut() {
        column.iter_mut().zip(&lane).for_each(|(c, &v)| *c = v);
        roots.run(column);
        lane.iter_mut().zip(column.iter()).for_each(|(v, &c)| *v = c);
    }
}

fn add(a: u32, b: u32) -> u32 {
    let sum = u64::from(a) + u64::from(b);
    (if sum >= u64::from(MODULUS) { sum - u64::from(MODULUS) } else { sum }) as u32
}

fn multiply(a: u32, b: u32) -> u32 {
    (u64::from(a) * u64::from(b) % u64::from(MODULUS)) as u32
}

fn power(base: u32, mut exponent: u32) -> u32 {
    let (mut result, mut square) = (1, base);
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = multiply(result, square);
        }
        square = multiply(square, square);
        exponent >>= 1;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generator_has_full_order() {
        // p − 1 = 2²⁷·3·5: a generator is no square, cube or fifth power.
        for prime in [2, 3, 5] {
            assert_ne!(power(GENERATOR, (MODULUS - 1) / prime), 1);
        }
        assert_eq!(power(GENERATOR, MODULUS - 1), 1);
    }

    #[test]
    fn cyclic_convolution_is_the_plain_sum_even_near_the_modulus() {
        let (nz, ny, nx) = (2, 4, 8);
        let mut state = 9u64;
        let mut random = |_| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as u32 % MODULUS
        };
        let a = Array3::from_shape_fn((nz, ny, nx), &mut random);
        let b = Array3::from_shape_fn((nz, ny, nx), &mut random);
        let found = cyclic_convolution(a.clone(), b.clone());
        for ((k, j, i), &got) in found.indexed_iter() {
            let mut want = 0;
            for ((z, y, x), &v) in a.indexed_iter() {
                want = add(want, multiply(v, b[[(k + nz - z) % nz, (j + ny - y) % ny, (i + nx - x) % nx]]));
            }
            assert_eq!(got, want, "{i} {j} {k}");
        }
    }
}
