//! Convolution without a transform: the plain sum, and shifted bit rows.

use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::grid::Grid;
use rayon::prelude::*;

/// `(1_A ∗ 1_B)(t) = #{ (a, b) : a + b = t }` by the plain double sum: the oracle of everything faster.
///
/// # Errors
/// [`crate::Error::Operand`] if the spacings differ.
///
/// # Cost
/// One addition for each pair of samples of A and B.
pub fn convolve_directly(a: &Indicator, b: &Indicator) -> Result<Field<u32>> {
    let grid = sum_grid(a.grid(), b.grid())?;
    let mut counts = Field::constant(grid, 0u32);
    let shifts: Vec<[usize; 3]> = b.iter().map(|at| b.grid().index(at)).collect();
    for at in a.iter() {
        let from = a.grid().index(at);
        for shift in &shifts {
            let to = grid.offset([0, 1, 2].map(|axis| from[axis] + shift[axis]));
            counts.values_mut()[to] += 1;
        }
    }
    Ok(counts)
}

/// A ⊕ B = { a + b } by shifted bit rows: for every run of B along x, A widened by the run's length and shifted.
///
/// # Errors
/// [`crate::Error::Operand`] if the spacings differ.
///
/// # Cost
/// (runs of B) · (words of A) word operations, both cores; one more copy of A, widened.
pub fn dilate_by_runs(a: &Indicator, b: &Indicator) -> Result<Indicator> {
    let grid = sum_grid(a.grid(), b.grid())?;
    let mut sum = Indicator::empty(grid);
    let mut runs = runs_along_x(b);
    runs.sort_unstable_by_key(|run| (run.length, run.k, run.j, run.start));
    let reach = b.grid().dims()[0] - 1;
    let mut widened = Widened::new(a, reach);
    for group in runs.chunk_by(|p, q| p.length == q.length) {
        widened.widen_to(group[0].length);
        add_shifted(&mut sum, &widened, group);
    }
    Ok(sum)
}

/// Number of runs of a set along x: the cost of using it as an element of [`dilate_by_runs`].
pub fn run_count(set: &Indicator) -> usize {
    runs_along_x(set).len()
}

/// The grid of a sum: origins add, counts are nA + nB − 1.
///
/// # Errors
/// [`crate::Error::Operand`] if the spacings differ.
pub fn sum_grid(a: &Grid, b: &Grid) -> Result<Grid> {
    a.one_spacing_with("convolution", b)?;
    let axes = [0, 1, 2];
    Grid::new(axes.map(|i| a.origin()[i] + b.origin()[i]), a.spacing(), axes.map(|i| a.dims()[i] + b.dims()[i] - 1))
}

/// Samples `start .. start + length` of row `(j, k)`, all inside, with none before and none after.
struct Run {
    j: usize,
    k: usize,
    start: usize,
    length: usize,
}

fn runs_along_x(set: &Indicator) -> Vec<Run> {
    let [nx, ny, _] = set.grid().dims();
    let mut runs: Vec<Run> = Vec::new();
    for at in set.iter() {
        let (i, j, k) = (at % nx, at / nx % ny, at / (nx * ny));
        match runs.last_mut() {
            Some(run) if run.j == j && run.k == k && run.start + run.length == i => run.length += 1,
            _ => runs.push(Run { j, k, start: i, length: 1 }),
        }
    }
    runs
}

/// A set whose every run reaches `length − 1` samples further along x, in rows with room for it.
struct Widened {
    words: Vec<u64>,
    per_row: usize,
    dims: [usize; 3],
    length: usize,
    occupied: Vec<bool>,
}

impl Widened {
    fn new(set: &Indicator, reach: usize) -> Self {
        let dims = set.grid().dims();
        let per_row = (dims[0] + reach).div_ceil(64);
        let mut words = vec![0; per_row * dims[1] * dims[2]];
        let occupied = words
            .par_chunks_mut(per_row)
            .zip(set.words().par_chunks(set.words_per_row()))
            .map(|(to, from)| {
                to[..from.len()].copy_from_slice(from);
                from.iter().any(|&w| w != 0)
            })
            .collect();
        Widened { words, per_row, dims, length: 1, occupied }
    }

    /// Widens by doubling: a set widened to n and shifted by at most n, united with itself, is widened further.
    fn widen_to(&mut self, length: usize) {
        while self.length < length {
            let step = self.length.min(length - self.length);
            self.words.par_chunks_mut(self.per_row).zip(&self.occupied).filter(|(_, o)| **o).for_each(|(row, _)| {
                for at in (step / 64..row.len()).rev() {
                    row[at] |= shifted_word(row, at, step);
                }
            });
            self.length += step;
        }
    }

    fn row(&self, j: usize, k: usize) -> Option<&[u64]> {
        let at = k * self.dims[1] + j;
        self.occupied[at].then(|| &self.words[at * self.per_row..(at + 1) * self.per_row])
    }
}

/// Word `at` of a row shifted upwards by `by` samples.
#[inline]
fn shifted_word(row: &[u64], at: usize, by: usize) -> u64 {
    let (words, bits) = (by / 64, by % 64);
    let here = at.checked_sub(words).and_then(|i| row.get(i)).copied().unwrap_or(0);
    if bits == 0 {
        return here;
    }
    let below = at.checked_sub(words + 1).and_then(|i| row.get(i)).copied().unwrap_or(0);
    here << bits | below >> (64 - bits)
}

/// Unites shifted copies of a widened set, one for each run, into the sum.
fn add_shifted(sum: &mut Indicator, widened: &Widened, runs: &[Run]) {
    let [_, ny, _] = sum.grid().dims();
    let per_row = sum.words_per_row();
    sum.words_mut().par_chunks_mut(per_row).enumerate().for_each(|(row, out)| {
        let (j, k) = (row % ny, row / ny);
        for run in runs {
            let (Some(from_j), Some(from_k)) = (j.checked_sub(run.j), k.checked_sub(run.k)) else { continue };
            if from_j >= widened.dims[1] || from_k >= widened.dims[2] {
                continue;
            }
            if let Some(from) = widened.row(from_j, from_k) {
                unite_shifted(out, from, run.start);
            }
        }
    });
}

/// `out |= from << by`; what would fall beyond the last sample of `out` is zero by the size of the sum's grid.
#[inline]
fn unite_shifted(out: &mut [u64], from: &[u64], by: usize) {
    let (words, bits) = (by / 64, by % 64);
    let Some(out) = out.get_mut(words..) else { return };
    if bits == 0 {
        out.iter_mut().zip(from).for_each(|(o, &f)| *o |= f);
        return;
    }
    let mut carry = 0;
    let last = from.len().min(out.len());
    for (o, &f) in out.iter_mut().zip(from) {
        *o |= f << bits | carry;
        carry = f >> (64 - bits);
    }
    if let Some(o) = out.get_mut(last) {
        *o |= carry;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Length;

    pub(crate) fn random_set(dims: [usize; 3], seed: u64, one_in: u64) -> Indicator {
        let grid = Grid::new([0.25, -1.0, 3.0], Length::mm(0.5), dims).unwrap();
        let mut set = Indicator::empty(grid);
        let mut state = seed;
        for at in 0..grid.samples() {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            if (state >> 33).is_multiple_of(one_in) {
                set.set(grid.index(at), true);
            }
        }
        set
    }

    #[test]
    fn bit_rows_are_the_support_of_the_plain_sum() {
        for (a, b) in
            [([1, 1, 1], [1, 1, 1]), ([5, 4, 3], [3, 2, 4]), ([64, 2, 2], [65, 1, 2]), ([130, 3, 2], [70, 2, 1])]
        {
            for one_in in [1, 2, 9] {
                let (a, b) = (random_set(a, 3, one_in), random_set(b, 17, one_in.max(2)));
                let counts = convolve_directly(&a, &b).unwrap();
                let fast = dilate_by_runs(&a, &b).unwrap();
                fast.validate().unwrap();
                let slow = Indicator::from_predicate(*counts.grid(), |at| counts.values()[at] >= 1);
                assert_eq!(fast, slow);
            }
        }
    }

    #[test]
    fn the_plain_sum_is_hand_computable() {
        let grid = |n| Grid::new([1.0, 0.0, 0.0], Length::mm(1.0), [n, 1, 1]).unwrap();
        let a = Indicator::from_predicate(grid(3), |at| at != 1);
        let b = Indicator::from_predicate(grid(2), |_| true);
        let counts = convolve_directly(&a, &b).unwrap();
        assert_eq!(counts.values(), [1, 1, 1, 1]);
        assert_eq!(counts.grid().origin(), [2.0, 0.0, 0.0]);
    }

    #[test]
    fn different_spacings_are_refused() {
        let coarse = Indicator::empty(Grid::new([0.0; 3], Length::mm(1.0), [2; 3]).unwrap());
        assert!(convolve_directly(&random_set([2; 3], 1, 2), &coarse).is_err());
    }
}
