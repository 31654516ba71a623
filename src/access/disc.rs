//! Digital discs, and the dilation of bit rows by them.

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
    pub(super) fn dilate_layer(
        &self,
        from: &[u64],
        to: &mut [u64],
        nx: usize,
        row: &mut Vec<u64>,
        kept: &mut Vec<u64>,
    ) {
        let words = nx.div_ceil(64);
        let rows = from.len() / words;
        let last = if nx.is_multiple_of(64) { !0 } else { !(!0u64 << (nx % 64)) };
        for y in (0..rows).filter(|y| from[y * words..(y + 1) * words].iter().any(|&w| w != 0)) {
            row.clear();
            row.extend_from_slice(&from[y * words..(y + 1) * words]);
            let mut width = 0;
            for dy in (0..self.half.len()).rev() {
                while width < self.half[dy] {
                    // A set widened by one to each side from a whole run, by more from what is already wide.
                    let step = self.half[dy] - width;
                    let by = step.min(63);
                    widen(row, kept, by);
                    width += by;
                    row[words - 1] &= last;
                }
                let mut add = |at: usize| {
                    to[at * words..(at + 1) * words].iter_mut().zip(row.iter()).for_each(|(t, &w)| *t |= w);
                };
                if y >= dy {
                    add(y - dy);
                }
                if dy > 0 && y + dy < rows {
                    add(y + dy);
                }
            }
        }
    }
}

/// Widens every run of a bit row by `by` samples, at most 63, to both sides.
fn widen(row: &mut [u64], kept: &mut Vec<u64>, by: usize) {
    let mut done = 0;
    while done < by {
        // What reaches `done` to both sides may be shifted by 2·done + 1 without a gap.
        let shift = (2 * done + 1).min(by - done);
        kept.clear();
        kept.extend_from_slice(row);
        for w in 0..row.len() {
            let below = if w > 0 { kept[w - 1] >> (64 - shift) } else { 0 };
            let above = kept.get(w + 1).map_or(0, |k| k << (64 - shift));
            row[w] |= kept[w] << shift | below | kept[w] >> shift | above;
        }
        done += shift;
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
                disc.dilate_layer(&from, &mut to, nx, &mut Vec::new(), &mut Vec::new());
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
