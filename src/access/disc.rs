//! Digital discs, and the dilation of bit rows by them.

use pulp::Arch;

/// The squares of a lattice that a disc about the middle of one of them takes: half the width of every row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Disc {
    /// At row offset ±j the offsets −half[j] … half[j].
    half: Vec<usize>,
}

/// What is rounded away when a real radius is compared with distances of the lattice.
const ROUNDING: f64 = 1e-12;

impl Disc {
    /// Squares that an open disc of `radius` spacings about a square's middle overlaps; `None` without any.
    pub fn overlapping(radius: f64) -> Option<Self> {
        let r = radius * (1.0 + ROUNDING);
        Disc::of(r, |i, j| (i - 0.5).max(0.0).powi(2) + (j - 0.5).max(0.0).powi(2) < r * r)
    }

    /// Squares that an open disc overlaps wherever in its square it is centred.
    pub fn surely(radius: f64) -> Option<Self> {
        let r = radius * (1.0 - ROUNDING);
        Disc::of(r, |i, j| i * i + j * j < r * r)
    }

    /// Squares that an open disc may overlap if it may be centred anywhere in its square.
    pub fn possibly(radius: f64) -> Option<Self> {
        let r = radius * (1.0 + ROUNDING);
        Disc::of(r, |i, j| (i - 1.0).max(0.0).powi(2) + (j - 1.0).max(0.0).powi(2) < r * r)
    }

    /// Squares whose middles lie in the closed disc.
    pub fn middles(radius: f64) -> Option<Self> {
        let r = radius * (1.0 + ROUNDING);
        Disc::of(r, |i, j| i * i + j * j <= r * r)
    }

    fn of(radius: f64, inside: impl Fn(f64, f64) -> bool) -> Option<Self> {
        if !(0.0..1e6).contains(&radius) {
            return None;
        }
        let most = radius.ceil() as usize + 1;
        let mut half = Vec::new();
        for j in 0..=most {
            let Some(widest) = (0..=most).rev().find(|&i| inside(i as f64, j as f64)) else { break };
            half.push(widest);
        }
        (!half.is_empty()).then_some(Disc { half })
    }

    /// Rows on either side of the middle one.
    pub fn reach(&self) -> usize {
        self.half.len() - 1
    }

    /// Half the width at a row offset.
    pub fn half_width(&self, row: usize) -> Option<usize> {
        self.half.get(row).copied()
    }

    /// Number of squares.
    pub fn squares(&self) -> usize {
        self.half.iter().enumerate().map(|(j, w)| (2 * w + 1) * if j == 0 { 1 } else { 2 }).sum()
    }

    /// `to` ∪= `from` ⊕ disc, on one layer of `nx` samples a row; what leaves the layer is dropped.
    ///
    /// # Cost
    /// For every row of the disc some ten operations for each word between the first row that is not empty and the last, all rows at once.
    pub(super) fn dilate_layer(&self, from: &[u64], to: &mut [u64], nx: usize, panel: &mut Panel) {
        // The same code for the widest vectors of the machine.
        Arch::new().dispatch(|| {
            let Some(first) = panel.take(from, nx) else { return };
            let mut width = 0;
            for dy in (0..self.half.len()).rev() {
                while width < self.half[dy] {
                    let by = (self.half[dy] - width).min(63);
                    panel.widen(by);
                    width += by;
                }
                if first >= dy {
                    panel.add(first - dy, 0);
                } else {
                    panel.add(0, dy - first);
                }
                if dy > 0 {
                    panel.add(first + dy, 0);
                }
            }
            panel.give(to, nx);
        });
    }
}

/// The rows of a layer side by side: the first words of all rows, then their second words, and so on.
#[derive(Debug, Default)]
pub(super) struct Panel {
    rows: usize,
    /// Rows that are widened: from the first that is not empty to the last.
    filled: usize,
    wide: Vec<u64>,
    /// What is gathered, of all rows of the layer.
    sum: Vec<u64>,
    /// Words as they were before the step, of the column to the left.
    before: Vec<u64>,
    none: Vec<u64>,
}

impl Panel {
    /// Takes the rows of a layer; returns the first that is not empty, if there is one.
    #[inline(always)]
    fn take(&mut self, from: &[u64], nx: usize) -> Option<usize> {
        let words = nx.div_ceil(64);
        let filled = |row: &[u64]| row.iter().any(|&w| w != 0);
        let first = from.chunks_exact(words).position(filled)?;
        let last = from.chunks_exact(words).rposition(filled)?;
        (self.rows, self.filled) = (from.len() / words, last - first + 1);
        self.wide.clear();
        for word in 0..words {
            self.wide.extend(from[first * words..(last + 1) * words].iter().skip(word).step_by(words));
        }
        self.sum.clear();
        self.sum.resize(words * self.rows, 0);
        self.none.clear();
        self.none.resize(self.filled, 0);
        Some(first)
    }

    /// Widens every run of every row by `by` samples, at most 63, to both sides.
    #[inline(always)]
    fn widen(&mut self, by: usize) {
        let mut done = 0;
        while done < by {
            // What reaches `done` to both sides may be shifted by 2·done + 1 without a gap.
            let shift = (2 * done + 1).min(by - done);
            self.before.clear();
            self.before.resize(self.filled, 0);
            let mut rest = self.wide.as_mut_slice();
            while !rest.is_empty() {
                let (column, after) = rest.split_at_mut(self.filled);
                let next = if after.is_empty() { &self.none } else { &after[..self.filled] };
                for ((word, before), next) in column.iter_mut().zip(&mut self.before).zip(next) {
                    let here = *word;
                    *word = here | here << shift | here >> shift | *before >> (64 - shift) | next << (64 - shift);
                    *before = here;
                }
                rest = after;
            }
            done += shift;
        }
    }

    /// Adds the widened rows less the first `left_out` to the sum from row `at` on.
    #[inline(always)]
    fn add(&mut self, at: usize, left_out: usize) {
        for (sum, wide) in self.sum.chunks_exact_mut(self.rows).zip(self.wide.chunks_exact(self.filled)) {
            let (_, sum) = sum.split_at_mut(at.min(self.rows));
            let (_, wide) = wide.split_at(left_out.min(self.filled));
            sum.iter_mut().zip(wide).for_each(|(sum, &wide)| *sum |= wide);
        }
    }

    /// Adds the sum to a layer.
    #[inline(always)]
    fn give(&self, to: &mut [u64], nx: usize) {
        let words = nx.div_ceil(64);
        let last = if nx.is_multiple_of(64) { !0 } else { !(!0u64 << (nx % 64)) };
        for (word, sum) in self.sum.chunks_exact(self.rows).enumerate() {
            let kept = if word + 1 == words { last } else { !0 };
            to.iter_mut().skip(word).step_by(words).zip(sum).for_each(|(to, sum)| *to |= sum & kept);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_four_readings_are_nested_and_hand_computable() {
        let r = 2.0;
        let surely = Disc::surely(r).unwrap();
        // |k| < 2: nine squares.
        assert_eq!(surely.squares(), 9);
        let middles = Disc::middles(r).unwrap();
        assert_eq!(middles.squares(), 13);
        let [overlapping, possibly] = [Disc::overlapping(r).unwrap(), Disc::possibly(r).unwrap()];
        assert!(surely.squares() < middles.squares() && middles.squares() < overlapping.squares());
        assert!(overlapping.squares() < possibly.squares());
        assert_eq!(Disc::surely(0.0), None);
        assert_eq!(Disc::middles(0.0).unwrap().squares(), 1);
    }

    #[test]
    fn layers_are_dilated_like_their_squares() {
        for nx in [9, 64, 65, 140] {
            let (words, rows) = (usize::div_ceil(nx, 64), 23);
            let set: Vec<(usize, usize)> = (0..40).map(|n| (n * 37 % nx, n * 11 % rows)).collect();
            let mut from = vec![0u64; words * rows];
            set.iter().for_each(|&(x, y)| from[y * words + x / 64] |= 1 << (x % 64));
            for r in [0.3, 1.0, 4.2, 11.0, 80.0] {
                let disc = Disc::overlapping(r).unwrap();
                let mut to = vec![0u64; words * rows];
                disc.dilate_layer(&from, &mut to, nx, &mut Panel::default());
                for y in 0..rows {
                    for x in 0..words * 64 {
                        let near = |&(a, b): &(usize, usize)| {
                            disc.half_width(y.abs_diff(b)).is_some_and(|w| x.abs_diff(a) <= w)
                        };
                        let want = x < nx && set.iter().any(near);
                        assert_eq!(to[y * words + x / 64] >> (x % 64) & 1 == 1, want, "{nx} {r} {x} {y}");
                    }
                }
            }
        }
    }
}
