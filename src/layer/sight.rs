//! What is seen of the void from outside.

use crate::error::Result;
use crate::field::Indicator;

/// The samples outside the part that no straight line of samples reaches from the border of the grid.
///
/// { c ∉ S : for each d of the 26 directions of the lattice, some c + n·d, n ≥ 1, lies in S }. What a straight tool along one of those
/// directions cannot see.
///
/// # Errors
/// None but [`crate::Error::Internal`] if the words do not fit the grid.
///
/// # Cost
/// 26 passes over words of 64 samples.
pub fn hidden_from_outside(centres: &Indicator) -> Result<Indicator> {
    let grid = *centres.grid();
    let [nx, ny, nz] = grid.dims();
    let wpr = centres.words_per_row();
    let mut seen = vec![0u64; wpr * ny * nz];
    for sz in [-1isize, 0, 1] {
        for sy in [-1isize, 0, 1] {
            for sx in [-1isize, 0, 1] {
                if (sx, sy, sz) != (0, 0, 0) {
                    look(centres, [sx, sy, sz], &mut seen);
                }
            }
        }
    }
    let last = if nx.is_multiple_of(64) { !0 } else { !(!0u64 << (nx % 64)) };
    let words = seen.iter().zip(centres.words()).enumerate().map(|(at, (seen, solid))| {
        let row = if (at + 1).is_multiple_of(wpr) { last } else { !0 };
        !seen & !solid & row
    });
    Indicator::from_words(grid, words.collect())
}

/// Adds what light that travels along a direction reaches.
fn look(centres: &Indicator, [sx, sy, sz]: [isize; 3], seen: &mut [u64]) {
    let [nx, ny, nz] = centres.grid().dims();
    let wpr = centres.words_per_row();
    let row_of = |j: usize, k: usize| (k * ny + j) * wpr;
    let forward = |n: usize, s: isize, at: usize| if s < 0 { n - 1 - at } else { at };
    if sy == 0 && sz == 0 {
        for row in 0..ny * nz {
            along_row(centres.row(row % ny, row / ny), nx, sx, &mut seen[row * wpr..(row + 1) * wpr]);
        }
        return;
    }
    let mut light = vec![0u64; wpr * ny * nz];
    for ck in 0..nz {
        for cj in 0..ny {
            let (j, k) = (forward(ny, sy, cj), forward(nz, sz, ck));
            let (fj, fk) = (j as isize - sy, k as isize - sz);
            let inside = fj >= 0 && fk >= 0 && fj < ny as isize && fk < nz as isize;
            let at = row_of(j, k);
            for w in 0..wpr {
                let arriving = if inside {
                    let from = row_of(fj as usize, fk as usize);
                    shifted(&light[from..from + wpr], w, sx, nx)
                } else {
                    !0
                };
                light[at + w] = arriving & !centres.words()[at + w];
                seen[at + w] |= light[at + w];
            }
        }
    }
}

/// A word of a row moved by one sample along x; light enters at the end.
fn shifted(row: &[u64], w: usize, sx: isize, nx: usize) -> u64 {
    match sx {
        0 => row[w],
        1 => row[w] << 1 | if w == 0 { 1 } else { row[w - 1] >> 63 },
        _ => {
            let carry = if w + 1 < row.len() { row[w + 1] << 63 } else { 0 };
            let entry = if w == (nx - 1) / 64 { 1 << ((nx - 1) % 64) } else { 0 };
            row[w] >> 1 | carry | entry
        }
    }
}

/// Light along a row: up to the first sample inside.
fn along_row(row: &[u64], nx: usize, sx: isize, seen: &mut [u64]) {
    let order: Box<dyn Iterator<Item = usize>> = if sx > 0 { Box::new(0..nx) } else { Box::new((0..nx).rev()) };
    for i in order {
        if row[i / 64] >> (i % 64) & 1 == 1 {
            return;
        }
        seen[i / 64] |= 1 << (i % 64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::random::Lcg;
    use crate::units::Length;

    fn sets() -> Vec<Indicator> {
        let mut rng = Lcg(9);
        [[5, 4, 3], [70, 5, 6], [64, 7, 4], [9, 9, 9]]
            .into_iter()
            .flat_map(|dims| [(dims, 2), (dims, 4), (dims, 7)])
            .map(|(dims, one_in)| {
                let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
                let mut set = Indicator::empty(grid);
                for at in 0..grid.samples() {
                    set.set(grid.index(at), rng.below(one_in) == 0);
                }
                set
            })
            .collect()
    }

    #[test]
    fn hidden_is_what_no_walk_in_26_directions_sees() {
        for set in sets() {
            let dims = set.grid().dims();
            let hidden = hidden_from_outside(&set).unwrap();
            for at in 0..set.grid().samples() {
                let index = set.grid().index(at);
                let clear = |d: [isize; 3]| {
                    let mut p = index.map(|c| c as isize);
                    loop {
                        p = [0, 1, 2].map(|a| p[a] + d[a]);
                        if (0..3).any(|a| p[a] < 0 || p[a] >= dims[a] as isize) {
                            return true;
                        }
                        if set.contains(p.map(|c| c as usize)) {
                            return false;
                        }
                    }
                };
                let steps = [-1isize, 0, 1];
                let any = steps
                    .iter()
                    .any(|&x| steps.iter().any(|&y| steps.iter().any(|&z| (x, y, z) != (0, 0, 0) && clear([x, y, z]))));
                assert_eq!(hidden.contains(index), !set.contains(index) && !any, "{index:?} {dims:?}");
            }
        }
    }
}
