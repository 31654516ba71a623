//! In or out: one bit a sample.

use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::units::Volume;
use rayon::prelude::*;

/// The indicator function of a set of samples, as bit rows along x.
///
/// Row `(j, k)` is `words_per_row` words; bit `i % 64` of word `i / 64` is sample `i`. Bits beyond the last
/// sample of a row are always 0, so that rows can be counted, shifted and combined word by word.
/// The background is *outside*.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Indicator {
    grid: GridBits,
    words: Vec<u64>,
}

/// A grid compared by its bits, so that indicators can be compared exactly.
#[derive(Debug, Clone, Copy)]
struct GridBits(Grid);

impl PartialEq for GridBits {
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}
impl Eq for GridBits {}

impl Indicator {
    /// The empty set.
    pub fn empty(grid: Grid) -> Self {
        let [nx, ny, nz] = grid.dims();
        Indicator { grid: GridBits(grid), words: vec![0; nx.div_ceil(64) * ny * nz] }
    }

    /// The set of samples whose storage offset satisfies the predicate; rows are evaluated in parallel.
    pub fn from_predicate(grid: Grid, inside: impl Fn(usize) -> bool + Sync) -> Self {
        let mut set = Indicator::empty(grid);
        let [nx, _, _] = grid.dims();
        let words = set.words_per_row();
        set.words.par_chunks_mut(words).enumerate().for_each(|(row, out)| {
            for (word, out) in out.iter_mut().enumerate() {
                let first = 64 * word;
                *out = (first..nx.min(first + 64))
                    .fold(0, |bits, i| bits | u64::from(inside(row * nx + i)) << (i - first));
            }
        });
        set
    }

    /// The set from bit rows laid out as described on the type.
    ///
    /// # Errors
    /// [`Error::Operand`] if the number of words is wrong or a padding bit is set.
    pub fn from_words(grid: Grid, words: Vec<u64>) -> Result<Self> {
        let set = Indicator { grid: GridBits(grid), words };
        set.validate()?;
        Ok(set)
    }

    /// Checks the invariants, cheap to dear: number of words; padding bits zero.
    ///
    /// # Errors
    /// [`Error::Operand`] naming the first that is broken.
    pub fn validate(&self) -> Result<()> {
        let [nx, ny, nz] = self.grid().dims();
        let bad = |problem: String| Error::Operand {
            operation: "indicator",
            problem,
            remedy: "pack rows along x into whole words, padding bits zero".into(),
        };
        if self.words.len() != self.words_per_row() * ny * nz {
            return Err(bad(format!("{} words for counts {:?}", self.words.len(), self.grid().dims())));
        }
        if !nx.is_multiple_of(64) {
            let padding = !0u64 << (nx % 64);
            if let Some(row) = self.words.chunks(self.words_per_row()).position(|r| r[r.len() - 1] & padding != 0) {
                return Err(bad(format!("padding bit set in row {row}")));
            }
        }
        Ok(())
    }

    /// The grid of the set.
    pub fn grid(&self) -> &Grid {
        &self.grid.0
    }

    /// Words in one row along x.
    pub fn words_per_row(&self) -> usize {
        self.grid().dims()[0].div_ceil(64)
    }

    /// All bit rows.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// All bit rows, to be changed; padding bits must stay 0.
    pub fn words_mut(&mut self) -> &mut [u64] {
        &mut self.words
    }

    /// The bit row at `(j, k)`.
    pub fn row(&self, j: usize, k: usize) -> &[u64] {
        let words = self.words_per_row();
        let start = (k * self.grid().dims()[1] + j) * words;
        &self.words[start..start + words]
    }

    /// Whether a sample is inside; samples outside the grid are not.
    pub fn contains(&self, [i, j, k]: [usize; 3]) -> bool {
        let [nx, ny, nz] = self.grid().dims();
        i < nx && j < ny && k < nz && self.row(j, k)[i / 64] >> (i % 64) & 1 == 1
    }

    /// Puts a sample inside or outside; one outside of the grid stays outside, and nothing changes.
    pub fn set(&mut self, [i, j, k]: [usize; 3], inside: bool) {
        let [nx, ny, nz] = self.grid().dims();
        if i >= nx || j >= ny || k >= nz {
            return;
        }
        let at = (k * ny + j) * self.words_per_row() + i / 64;
        if inside {
            self.words[at] |= 1 << (i % 64);
        } else {
            self.words[at] &= !(1 << (i % 64));
        }
    }

    /// Number of samples inside.
    pub fn count(&self) -> u64 {
        self.words.par_iter().map(|w| u64::from(w.count_ones())).sum()
    }

    /// Number of samples inside times the volume of a sample.
    pub fn volume(&self) -> Volume {
        self.grid().sample_volume() * self.count() as f64
    }

    /// Whether no sample is inside.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&w| w == 0)
    }

    /// A ∪ B.
    ///
    /// # Errors
    /// [`Error::Operand`] if the grids differ; so for the other binary operations.
    pub fn union(&self, other: &Self) -> Result<Self> {
        self.combine(other, "union", |a, b| a | b)
    }

    /// A ∩ B.
    ///
    /// # Errors
    /// [`Error::Operand`] if the grids differ.
    pub fn intersection(&self, other: &Self) -> Result<Self> {
        self.combine(other, "intersection", |a, b| a & b)
    }

    /// A ∖ B.
    ///
    /// # Errors
    /// [`Error::Operand`] if the grids differ.
    pub fn difference(&self, other: &Self) -> Result<Self> {
        self.combine(other, "difference", |a, b| a & !b)
    }

    /// The samples of the grid that are not inside.
    pub fn complement(&self) -> Self {
        let mut out = self.clone();
        let words = self.words_per_row();
        let nx = self.grid().dims()[0];
        let last = if nx.is_multiple_of(64) { !0 } else { !(!0u64 << (nx % 64)) };
        out.words.par_chunks_mut(words).for_each(|row| {
            row.iter_mut().for_each(|w| *w = !*w);
            row[words - 1] &= last;
        });
        out
    }

    /// Whether every sample of this set is in the other.
    ///
    /// # Errors
    /// [`Error::Operand`] if the grids differ.
    pub fn is_subset(&self, other: &Self) -> Result<bool> {
        Ok(self.difference(other)?.is_empty())
    }

    /// Storage offsets of the samples inside, in increasing order.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        let nx = self.grid().dims()[0];
        self.words.chunks(self.words_per_row()).enumerate().flat_map(move |(row, words)| {
            words.iter().enumerate().flat_map(move |(w, &bits)| {
                let mut rest = bits;
                std::iter::from_fn(move || {
                    (rest != 0).then(|| {
                        let bit = rest.trailing_zeros() as usize;
                        rest &= rest - 1;
                        row * nx + w * 64 + bit
                    })
                })
            })
        })
    }

    fn combine(&self, other: &Self, operation: &'static str, op: impl Fn(u64, u64) -> u64 + Sync) -> Result<Self> {
        if self.grid != other.grid {
            return Err(Error::Operand {
                operation,
                problem: format!("grids differ: {:?} and {:?}", self.grid(), other.grid()),
                remedy: "cast both shapes on one grid".into(),
            });
        }
        let words = self.words.par_iter().zip(&other.words).map(|(&a, &b)| op(a, b)).collect();
        Ok(Indicator { grid: self.grid, words })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Length;

    fn grid(nx: usize) -> Grid {
        Grid::new([0.0; 3], Length::mm(0.5), [nx, 3, 2]).unwrap()
    }

    #[test]
    fn samples_outside_of_the_grid_cannot_be_set() {
        let mut set = Indicator::empty(grid(5));
        for outside in [[5, 0, 0], [64, 0, 0], [0, 3, 0], [0, 0, 2], [usize::MAX; 3]] {
            set.set(outside, true);
            assert!(set.is_empty(), "{outside:?}");
        }
        let all = set.complement();
        let mut kept = all.clone();
        kept.set([0, 3, 0], false);
        assert_eq!(kept, all);
        all.validate().unwrap();
    }

    #[test]
    fn set_algebra_on_rows_that_do_not_fill_a_word() {
        for nx in [1, 63, 64, 65, 130] {
            let g = grid(nx);
            let a = Indicator::from_predicate(g, |at| at % 3 == 0);
            let b = Indicator::from_predicate(g, |at| at % 2 == 0);
            a.validate().unwrap();
            a.complement().validate().unwrap();
            assert_eq!(a.union(&a.complement()).unwrap().count(), g.samples() as u64);
            assert_eq!(
                a.intersection(&b).unwrap().iter().collect::<Vec<_>>(),
                (0..g.samples()).filter(|at| at % 6 == 0).collect::<Vec<_>>()
            );
            // De Morgan.
            assert_eq!(a.union(&b).unwrap().complement(), a.complement().intersection(&b.complement()).unwrap());
            assert!(a.difference(&b).unwrap().is_subset(&a).unwrap());
        }
    }

    #[test]
    fn different_grids_do_not_mix() {
        assert!(Indicator::empty(grid(3)).union(&Indicator::empty(grid(4))).is_err());
        assert!(Indicator::from_words(grid(3), vec![8; 6]).is_err(), "padding bit");
    }
}
