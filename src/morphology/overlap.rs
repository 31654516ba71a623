//! Overlap counts of a small element on bit rows, and the sets of cells that follow from them.

use super::columns::Columns;
use crate::error::{Error, Result};
use crate::field::Indicator;
use pulp::Arch;
use rayon::prelude::*;

/// Most cells an element may have along x: a window, a cell wider on either side, then spans at most two words.
const WIDEST: usize = 62;
/// Most cells along z, and most altogether, of an element whose cells are counted: a column's count is a byte, an element's two.
const TALLEST_COUNTED: usize = u8::MAX as usize;
const MOST_COUNTED: u64 = u16::MAX as u64;
/// Layers that are taken by one core at least; the first of them sums as many as the element is high.
const SHARE: usize = 16;

/// A prism of lattice cells: for each row along y a run along x, the same in every layer.
///
/// It stands on the cells `[0, wide) × [0, wide) × [0, high)`; a placement is the cell that its first corner is moved to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Prism {
    /// First cell and end of the run of each row.
    runs: Vec<(usize, usize)>,
    high: usize,
}

impl Prism {
    /// The prism over `wide × wide` cells and `high` layers whose cells satisfy `within(i, j)`; runs must be unbroken.
    ///
    /// # Errors
    /// [`Error::Operand`] if it has no cell or is wider than 62.
    pub fn new(wide: usize, high: usize, within: impl Fn(usize, usize) -> bool) -> Result<Self> {
        let run = |j: usize| {
            let first = (0..wide).find(|&i| within(i, j)).unwrap_or(0);
            let end = (first..wide).find(|&i| !within(i, j)).unwrap_or(wide);
            (first, end)
        };
        let prism = Prism { runs: (0..wide).map(run).collect(), high };
        if wide > WIDEST || prism.cells() == 0 {
            return Err(prism.refused(&format!("at most {WIDEST} cells wide")));
        }
        Ok(prism)
    }

    fn refused(&self, most: &str) -> Error {
        Error::Operand {
            operation: "overlap count",
            problem: format!("an element of {} cells, {} wide", self.cells(), self.runs.len()),
            remedy: format!("choose a coarser lattice: {most}"),
        }
    }

    /// Number of cells.
    pub fn cells(&self) -> u64 {
        self.runs.iter().map(|(a, b)| (b - a) as u64).sum::<u64>() * self.high as u64
    }

    /// Number of cells before a plane across x.
    pub fn cells_before(&self, x: usize) -> u64 {
        self.runs.iter().map(|&(a, b)| (b.min(x).max(a) - a) as u64).sum::<u64>() * self.high as u64
    }

    /// The placements at which at least `least` cells of the element lie in the set: `{ p : |A ∩ (p + B)| ≥ least }`.
    ///
    /// Counts are exact. Placements before the set's grid are not looked at: the set must keep an element's width from it.
    ///
    /// # Errors
    /// [`Error::Operand`] for an element of more than 65,535 cells or taller than 255, unless all of its cells are asked for.
    ///
    /// # Cost
    /// O(samples) and O(rows of the element) for each word that has a border in reach: the counts of columns are kept from layer to layer
    /// and summed along x, and each row of the element is the difference of two such sums.
    pub fn placements(&self, set: &Indicator, least: u64) -> Result<Indicator> {
        if least >= self.cells() {
            return Ok(self.eroded(set));
        }
        if self.high > TALLEST_COUNTED || self.cells() > MOST_COUNTED {
            return Err(self.refused("at most 65,535 cells, 255 high"));
        }
        let mut out = Indicator::empty(*set.grid());
        let layer = set.words_per_row() * set.grid().dims()[1];
        let least = least.clamp(1, MOST_COUNTED) as u16;
        let share = SHARE.max(2 * self.high);
        out.words_mut().par_chunks_mut(share * layer).enumerate().for_each(|(at, planes)| {
            // The same code for the widest vectors of the machine.
            Arch::new().dispatch(|| {
                let mut columns = Columns::on(set, share * at, (self.runs.len(), self.high));
                for plane in planes.chunks_mut(layer) {
                    self.place_on_layer(&mut columns, least, plane);
                    columns.rise();
                }
            });
        });
        Ok(out)
    }

    /// The placements at which the whole element lies in the set.
    fn eroded(&self, set: &Indicator) -> Indicator {
        let mut out = Indicator::empty(*set.grid());
        let ([nx, ny, nz], words) = (set.grid().dims(), set.words_per_row());
        let rows: Vec<(usize, (usize, usize))> =
            self.runs.iter().copied().enumerate().filter(|(_, (first, end))| first < end).collect();
        let tallest = rows.iter().map(|(dy, _)| dy + 1).max().unwrap_or(0);
        out.words_mut().par_chunks_mut(words * ny).enumerate().for_each(|(k, plane)| {
            if k + self.high > nz || tallest > ny {
                return;
            }
            let layer = |z: usize| &set.words()[z * words * ny..(z + 1) * words * ny];
            let mut common = layer(k).to_vec();
            for z in k + 1..k + self.high {
                common.iter_mut().zip(layer(z)).for_each(|(c, row)| *c &= row);
            }
            for j in 0..=ny - tallest {
                for w in 0..words {
                    let held = |&(dy, run): &(usize, (usize, usize))| {
                        let row = &common[(j + dy) * words..(j + dy + 1) * words];
                        all_of(row[w], row.get(w + 1).copied().unwrap_or(0), run)
                    };
                    let target = &mut plane[j * words + w];
                    *target = !0;
                    for row in &rows {
                        *target &= held(row);
                        if *target == 0 {
                            break;
                        }
                    }
                }
                if !nx.is_multiple_of(64) {
                    plane[(j + 1) * words - 1] &= !(!0u64 << (nx % 64));
                }
            }
        });
        out
    }

    #[inline(always)]
    fn place_on_layer(&self, columns: &mut Columns, least: u16, plane: &mut [u64]) {
        let (nx, ny, words) = (columns.set.grid().dims()[0], columns.ny, columns.words);
        let mut ends = vec![(0, 0); words];
        for (j, target) in plane.chunks_mut(words).enumerate() {
            let rows = j..(j + self.runs.len()).min(ny);
            ends.fill((0, if rows.len() == self.runs.len() { !0 } else { 0 }));
            for y in rows.clone() {
                let row = &columns.ends[y * words..(y + 1) * words];
                ends.iter_mut().zip(row).for_each(|((any, all), row)| (*any, *all) = (*any | row.0, *all & row.1));
            }
            if ends.iter().any(|&(any, all)| any != 0 && all != !0) {
                rows.for_each(|y| columns.sum_row(y));
            }
            for (w, (word, (any, all))) in target.iter_mut().zip(&ends).enumerate() {
                *word = match (*any, *all) {
                    (0, _) => 0,
                    (_, u64::MAX) => !0,
                    _ => self.count(columns, (j, w), least),
                };
            }
            if let (Some(last), false) = (target.last_mut(), nx.is_multiple_of(64)) {
                *last &= !(!0u64 << (nx % 64));
            }
        }
    }

    /// Bit i: whether the placement at sample `64·w + i` of row j holds at least `least` cells.
    #[inline(always)]
    fn count(&self, columns: &Columns, (j, w): (usize, usize), least: u16) -> u64 {
        let mut counts = [0u16; 64];
        for (y, &(first, end)) in (j..columns.ny).zip(&self.runs) {
            let before = &columns.before[y * columns.pitch + 64 * w..(y + 1) * columns.pitch];
            let (from, to) = (&before[first..first + 64], &before[end..end + 64]);
            for i in 0..64 {
                // Sums along a long row wrap; their differences do not.
                counts[i] += to[i].wrapping_sub(from[i]);
            }
        }
        let mut bytes = [0u8; 64];
        (0..64).for_each(|i| bytes[i] = u8::from(counts[i] >= least));
        let mut word = 0;
        for at in 0..8 {
            // Gathers the lowest bits of eight bytes: no two of the products meet in a bit.
            let eight = u64::from_le_bytes(std::array::from_fn(|i| bytes[8 * at + i]));
            word |= (eight.wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * at);
        }
        word
    }

    /// All cells that the element covers from a set of placements, `reach` cells further on every side: `P ⊕ B ⊕ [−reach, reach]³`.
    ///
    /// # Cost
    /// O(words·rows of the element).
    pub fn deposited(&self, placements: &Indicator, reach: usize) -> Indicator {
        let mut out = Indicator::empty(*placements.grid());
        let [nx, ny, nz] = placements.grid().dims();
        let words = placements.words_per_row();
        // Rows of the grown element: the run of row `dy` holds those of its neighbours.
        let wide = self.runs.len();
        let mut grown: Vec<((isize, isize), isize)> = (-(reach as isize)..(wide + reach) as isize)
            .filter_map(|dy| {
                let near = (dy - reach as isize).max(0) as usize..((dy + reach as isize + 1).max(0) as usize).min(wide);
                let runs = self.runs[near].iter().filter(|(first, end)| first < end);
                let ends = runs.map(|&(a, b)| (a as isize, b as isize)).reduce(|(a, b), (c, d)| (a.min(c), b.max(d)));
                ends.map(|(a, b)| ((a - reach as isize, b + reach as isize), dy))
            })
            .collect();
        // Rows that are alike are smeared along x once.
        grown.sort_unstable();
        out.words_mut().par_chunks_mut(words * ny).enumerate().for_each(|(k, plane)| {
            let mut gathered = vec![0u64; words * ny];
            for z in (k + 1).saturating_sub(self.high + reach)..(k + reach + 1).min(nz) {
                let layer = &placements.words()[z * words * ny..(z + 1) * words * ny];
                gathered.iter_mut().zip(layer).for_each(|(g, row)| *g |= row);
            }
            let mut smeared = vec![0u64; words * ny];
            for alike in grown.chunk_by(|(a, _), (b, _)| a == b) {
                let Some(&(run, _)) = alike.first() else { continue };
                smeared.fill(0);
                let rows = smeared.chunks_mut(words).zip(gathered.chunks(words));
                rows.for_each(|(target, row)| smear(row, run, target));
                for &(_, dy) in alike {
                    let from = words * (-dy).clamp(0, ny as isize) as usize;
                    let to = words * dy.clamp(0, ny as isize) as usize;
                    plane[to..].iter_mut().zip(&smeared[from..]).for_each(|(target, row)| *target |= row);
                }
            }
            if !nx.is_multiple_of(64) {
                plane.chunks_mut(words).for_each(|row| row[words - 1] &= !(!0u64 << (nx % 64)));
            }
        });
        out
    }
}

/// Bit i: whether all bits `i + first .. i + end` of two words that follow each other are set; a run of n bits is told by
/// log₂ n shifts.
fn all_of(word: u64, next: u64, (first, end): (usize, usize)) -> u64 {
    let both = u128::from(word) | u128::from(next) << 64;
    if both == 0 || both == u128::MAX {
        return both as u64;
    }
    let (mut all, mut covered) = (both >> first, 1);
    while 2 * covered < end - first {
        all &= all >> covered;
        covered *= 2;
    }
    (all & all >> (end - first - covered)) as u64
}

/// Sets in `target` every bit at `first..end` from a bit of `row`.
fn smear(row: &[u64], (first, end): (isize, isize), target: &mut [u64]) {
    for w in 0..row.len() {
        let before = if w > 0 { row[w - 1] } else { 0 };
        let after = row.get(w + 1).copied().unwrap_or(0);
        if before | row[w] | after == 0 || first >= end || target[w] == u64::MAX {
            continue;
        }
        if before & row[w] & after == u64::MAX {
            target[w] = u64::MAX;
            continue;
        }
        let onwards = first.max(0);
        if onwards < end {
            let length = (end - onwards) as usize;
            let both = u128::from(before) | u128::from(row[w]) << 64;
            let (mut any, mut covered) = (both << onwards, 1);
            while 2 * covered < length {
                any |= any << covered;
                covered *= 2;
            }
            target[w] |= ((any | any << (length - covered)) >> 64) as u64;
        }
        for d in first..end.min(0) {
            target[w] |= row[w] >> -d | after << (64 + d);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::units::Length;

    fn noise(grid: Grid, seed: u64, share: u64) -> Indicator {
        let [nx, ny, nz] = grid.dims();
        Indicator::from_predicate(grid, |at| {
            let [i, j, k] = grid.index(at);
            let clear = i >= 6 && j >= 6 && k >= 4 && i + 6 < nx && j + 6 < ny && k + 4 < nz;
            // Splitmix: blocks of noise between full and empty stretches.
            let mut x = (at as u64 ^ seed).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            clear && ((i / 40 + j / 9) % 2 == 0 || (x >> 33) % 100 < share)
        })
    }

    fn contains(set: &Indicator, at: [isize; 3]) -> bool {
        at.iter().all(|&c| c >= 0) && set.contains(at.map(|c| c as usize))
    }

    #[test]
    fn placements_and_deposits_are_those_of_the_definition() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [150, 23, 14]).unwrap();
        // Without symmetry: an L and a full square, one and three layers high.
        let lopsided = Prism::new(4, 3, |i, j| j < 2 || i < 1).unwrap();
        let square = Prism::new(2, 1, |_, _| true).unwrap();
        let large = Prism::new(9, 4, |i, j| i + j > 1).unwrap();
        // As wide as there is room for, in two rows.
        let wide = Prism::new(62, 1, |i, j| j < 2 && i + j > 0).unwrap();
        for (prism, share) in [(lopsided, 40), (square, 70), (large, 99), (wide, 100)] {
            let set = noise(grid, 7, share);
            let cells: Vec<[isize; 3]> = (0..prism.high)
                .flat_map(|z| {
                    prism.runs.iter().enumerate().flat_map(move |(y, &(a, b))| (a..b).map(move |x| [x, y, z]))
                })
                .map(|c| c.map(|x| x as isize))
                .collect();
            for least in [1, prism.cells() / 2, prism.cells() - 1, prism.cells()] {
                let found = prism.placements(&set, least).unwrap();
                let wanted = Indicator::from_predicate(grid, |at| {
                    let p = grid.index(at).map(|c| c as isize);
                    let held = |c: &&[isize; 3]| contains(&set, [p[0] + c[0], p[1] + c[1], p[2] + c[2]]);
                    cells.iter().filter(held).count() as u64 >= least
                });
                assert!(!found.is_empty() && found == wanted, "{least} of {}", prism.cells());
                found.validate().unwrap();
                for reach in [0isize, 1] {
                    let near = |c: &[isize; 3]| {
                        (-reach..=reach)
                            .flat_map(move |x| (-reach..=reach).map(move |y| (x, y)))
                            .flat_map(move |(x, y)| (-reach..=reach).map(move |z| [x, y, z]))
                            .map(|d| [0, 1, 2].map(|a| c[a] + d[a]))
                            .collect::<Vec<_>>()
                    };
                    let moves: Vec<[isize; 3]> = cells.iter().flat_map(near).collect();
                    let covered = Indicator::from_predicate(grid, |at| {
                        let p = grid.index(at).map(|c| c as isize);
                        moves.iter().any(|m| contains(&found, [0, 1, 2].map(|a| p[a] - m[a])))
                    });
                    assert!(prism.deposited(&found, reach as usize) == covered);
                }
            }
        }
    }

    #[test]
    fn sums_of_high_columns_along_a_row_may_exceed_sixteen_bits() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [300, 3, 256]).unwrap();
        let prism = Prism::new(2, 250, |_, _| true).unwrap();
        let found = prism.placements(&Indicator::empty(grid).complement(), prism.cells() - 1).unwrap();
        let wanted = Indicator::from_predicate(grid, |at| {
            let [i, j, k] = grid.index(at);
            i + 2 <= 300 && j + 2 <= 3 && k + 250 <= 256
        });
        assert!(found == wanted);
    }

    #[test]
    fn elements_too_large_to_count_are_refused() {
        assert!(Prism::new(63, 1, |_, _| true).is_err());
        let set = Indicator::empty(Grid::new([0.0; 3], Length::mm(1.0), [40; 3]).unwrap());
        for (wide, high) in [(1, 256), (60, 19)] {
            let large = Prism::new(wide, high, |_, _| true).unwrap();
            assert!(large.placements(&set, large.cells() - 1).is_err());
            assert!(large.placements(&set, large.cells()).unwrap().is_empty());
        }
        assert!(Prism::new(3, 1, |_, _| false).is_err());
        assert_eq!(Prism::new(4, 2, |i, j| (i + j) % 3 != 0 || i != j).unwrap().cells() % 2, 0);
    }
}
