//! Windows of a set: the same lattice, another box of it.

use super::Indicator;
use crate::error::Result;
use crate::grid::Grid;
use rayon::prelude::*;

impl Indicator {
    /// The set on the box of the same lattice that starts `first` samples from this grid's first sample and has
    /// `dims` samples; what lies outside this grid is outside the set.
    ///
    /// # Errors
    /// [`crate::Error::Operand`] if a count is zero.
    ///
    /// # Cost
    /// One walk over the words of the window.
    pub fn window(&self, first: [isize; 3], dims: [usize; 3]) -> Result<Self> {
        let grid = self.grid();
        let origin = [0, 1, 2].map(|a| grid.origin()[a] + grid.h() * first[a] as f64);
        self.placed(first, Grid::new(origin, grid.spacing(), dims)?)
    }

    /// As [`Indicator::window`], on a given grid: its first sample is the one `first` samples from this grid's.
    ///
    /// # Errors
    /// None for grids that exist; the result is checked like any indicator.
    pub fn placed(&self, first: [isize; 3], target: Grid) -> Result<Self> {
        let mut out = Indicator::empty(target);
        let [nx, ny, nz] = self.grid().dims();
        let [mx, my, _] = target.dims();
        let words = out.words_per_row();
        let last = if mx.is_multiple_of(64) { !0 } else { !(!0u64 << (mx % 64)) };
        out.words_mut().par_chunks_mut(words).enumerate().for_each(|(row, to)| {
            let at = |axis: usize, i: usize, n: usize| i.checked_add_signed(first[axis]).filter(|&s| s < n);
            let (Some(j), Some(k)) = (at(1, row % my, ny), at(2, row / my, nz)) else { return };
            let from = self.row(j, k);
            for (w, word) in to.iter_mut().enumerate() {
                *word = bits_from(from, nx, first[0] + (w * 64) as isize);
            }
            if let Some(word) = to.last_mut() {
                *word &= last;
            }
        });
        Ok(out)
    }

    /// Unites the set with another one whose first sample lies at `first`; what of it lies beyond this grid is left out.
    ///
    /// # Cost
    /// One walk over the words of the other set.
    pub fn unite_window(&mut self, first: [usize; 3], part: &Self) {
        let [nx, ny, nz] = self.grid().dims();
        let (words, [mx, my, mz]) = (self.words_per_row(), part.grid().dims());
        let last = if nx.is_multiple_of(64) { !0 } else { !(!0u64 << (nx % 64)) };
        let span = first[0] / 64..words.min((first[0] + mx).div_ceil(64));
        for (k, j) in (0..mz).flat_map(|k| (0..my).map(move |j| (k, j))) {
            let (row, y, z) = (part.row(j, k), first[1] + j, first[2] + k);
            if y >= ny || z >= nz {
                continue;
            }
            let to = &mut self.words_mut()[(z * ny + y) * words..][..words];
            for (w, word) in to.iter_mut().enumerate().take(span.end).skip(span.start) {
                *word |= bits_from(row, mx, (64 * w) as isize - first[0] as isize);
            }
            to[words - 1] &= last;
        }
    }

    /// The least box that holds the set, as its first sample and its counts; `None` for the empty set.
    pub fn support_box(&self) -> Option<([usize; 3], [usize; 3])> {
        let [_, ny, _] = self.grid().dims();
        let words = self.words_per_row();
        let rows = self.words().par_chunks(words).enumerate().filter_map(|(row, bits)| {
            let first = bits.iter().position(|&w| w != 0)?;
            let last = bits.iter().rposition(|&w| w != 0)?;
            let lo = first * 64 + bits[first].trailing_zeros() as usize;
            let hi = last * 64 + 63 - bits[last].leading_zeros() as usize;
            Some(([lo, row % ny, row / ny], [hi, row % ny, row / ny]))
        });
        let (lo, hi) =
            rows.reduce_with(|(a, b), (c, d)| ([0, 1, 2].map(|i| a[i].min(c[i])), [0, 1, 2].map(|i| b[i].max(d[i]))))?;
        Some((lo, [0, 1, 2].map(|i| hi[i] - lo[i] + 1)))
    }

    /// The set reflected about the world's origin: { −x : x ∈ S }.
    pub fn reflected(&self) -> Self {
        let grid = self.grid();
        let dims = grid.dims();
        let origin = [0, 1, 2].map(|a| -(grid.origin()[a] + grid.h() * (dims[a] - 1) as f64));
        // The counts and the spacing are those of a grid that exists, and a negated position is finite.
        let Ok(mirrored) = Grid::new(origin, grid.spacing(), dims) else { return self.clone() };
        let mut out = Indicator::empty(mirrored);
        let (words, [nx, ny, nz]) = (self.words_per_row(), dims);
        out.words_mut().par_chunks_mut(words).enumerate().for_each_init(
            Vec::new,
            |backwards: &mut Vec<u64>, (row, to)| {
                let from = self.row(ny - 1 - row % ny, nz - 1 - row / ny);
                backwards.clear();
                backwards.extend(from.iter().rev().map(|w| w.reverse_bits()));
                let padding = 64 * words - nx;
                for (w, word) in to.iter_mut().enumerate() {
                    *word = bits_from(backwards, 64 * words, (64 * w + padding) as isize);
                }
            },
        );
        out
    }
}

/// Sixty-four bits of a row from position `start`, which may lie before it or beyond it.
#[inline]
pub(crate) fn bits_from(row: &[u64], samples: usize, start: isize) -> u64 {
    if start >= samples as isize || start <= -64 {
        return 0;
    }
    let word = |i: isize| usize::try_from(i).ok().and_then(|i| row.get(i)).copied().unwrap_or(0);
    let (at, shift) = (start.div_euclid(64), start.rem_euclid(64));
    if shift == 0 { word(at) } else { word(at) >> shift | word(at + 1) << (64 - shift) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Length;

    fn pattern(dims: [usize; 3]) -> Indicator {
        let grid = Grid::new([1.0, 2.0, -3.0], Length::mm(0.5), dims).unwrap();
        Indicator::from_predicate(grid, |at| at % 7 < 3 || at % 5 == 0)
    }

    #[test]
    fn windows_hold_the_same_samples() {
        for nx in [3, 64, 70, 130] {
            let set = pattern([nx, 4, 3]);
            for first in [[0, 0, 0], [-70, -1, -2], [5, 1, 1], [63, 0, 0], [-1, 2, 0], [200, 0, 0]] {
                let view = set.window(first, [67, 5, 4]).unwrap();
                view.validate().unwrap();
                for at in 0..view.grid().samples() {
                    let index = view.grid().index(at);
                    let [i, j, k] = [0, 1, 2].map(|a| index[a] as isize + first[a]);
                    let want = i >= 0 && j >= 0 && k >= 0 && set.contains([i as usize, j as usize, k as usize]);
                    assert_eq!(view.contains(index), want, "{first:?} {index:?}");
                }
            }
        }
    }

    #[test]
    fn a_window_is_united_where_it_lies() {
        for dims in [[70, 9, 6], [64, 5, 4], [130, 6, 5]] {
            let (mut all, part) = (pattern(dims), pattern([67, 4, 3]).complement());
            for first in [[0, 0, 0], [1, 2, 1], [63, 4, 3], [69, 0, 0], [500, 0, 0], [0, 0, 20]] {
                let want = all.union(&part.placed(first.map(|i: usize| -(i as isize)), *all.grid()).unwrap()).unwrap();
                all.unite_window(first, &part);
                all.validate().unwrap();
                assert_eq!(all, want, "{dims:?} {first:?}");
                all = pattern(dims);
            }
        }
    }

    #[test]
    fn the_box_and_the_reflection_are_hand_computable() {
        let grid = Grid::new([1.0, 0.0, 0.0], Length::mm(1.0), [70, 3, 2]).unwrap();
        let mut set = Indicator::empty(grid);
        assert_eq!(set.support_box(), None);
        set.set([2, 1, 0], true);
        set.set([66, 0, 1], true);
        assert_eq!(set.support_box(), Some(([2, 0, 0], [65, 2, 2])));
        let mirrored = set.reflected();
        assert_eq!(mirrored.grid().origin(), [-70.0, -2.0, -1.0]);
        assert!(mirrored.contains([67, 1, 1]) && mirrored.contains([3, 2, 0]));
        assert_eq!(mirrored.reflected(), set);
    }
}
