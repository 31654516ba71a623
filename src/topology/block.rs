//! The neighbourhood of a sample as bits of a word.

use crate::field::Indicator;
use crate::grid::Grid;

/// The 3×3×3 samples about one, as bits 9·(Δz + 1) + 3·(Δy + 1) + (Δx + 1); the one in the middle is left out.
#[derive(Clone, Copy)]
pub(super) struct Block {
    pub bits: u32,
}

impl Block {
    const MIDDLE: u32 = 1 << 13;
    /// Bits whose Δx, Δy, Δz is not the greatest, so that they may move one up.
    const NOT_LAST: [u32; 3] = [0o333333333, 0o077077077, 0o000777777];

    /// The members of a set among the neighbours of a sample.
    #[inline]
    pub fn about(set: &Indicator, [i, j, k]: [usize; 3]) -> Self {
        let [_, ny, nz] = set.grid().dims();
        let (word, bit) = (i / 64, i % 64);
        let mut bits = 0;
        for z in k.saturating_sub(1)..(k + 2).min(nz) {
            for y in j.saturating_sub(1)..(j + 2).min(ny) {
                let row = set.row(y, z);
                let here = row[word];
                let before = if bit > 0 {
                    here >> (bit - 1)
                } else {
                    here << 1 | if word > 0 { row[word - 1] >> 63 } else { 0 }
                };
                let behind = if bit == 63 { row.get(word + 1).map_or(0, |next| (next & 1) << 2) } else { 0 };
                let three = (before & if bit == 63 { 3 } else { 7 } | behind) as u32;
                bits |= three << (9 * (z + 1 - k) + 3 * (y + 1 - j));
            }
        }
        Block { bits: bits & !Self::MIDDLE }
    }

    /// The first sample of the next cluster of touching samples, and what remains without the cluster.
    #[inline]
    pub fn next_cluster(self) -> Option<(u32, Self)> {
        if self.bits == 0 {
            return None;
        }
        let mut cluster = self.bits & self.bits.wrapping_neg();
        loop {
            let mut wide = cluster;
            for (last, step) in Self::NOT_LAST.into_iter().zip([1, 3, 9]) {
                wide |= (wide & last) << step | (wide >> step) & last;
            }
            let grown = wide & self.bits;
            if grown == cluster {
                return Some((self.bits.trailing_zeros(), Block { bits: self.bits & !cluster }));
            }
            cluster = grown;
        }
    }
}

/// The storage offset of a neighbour by its place in a [`Block`].
#[inline]
pub(super) fn shifted(grid: &Grid, [i, j, k]: [usize; 3], place: u32) -> usize {
    let place = place as usize;
    grid.offset([i + place % 3 - 1, j + place / 3 % 3 - 1, k + place / 9 - 1])
}

/// Calls `visit` with the storage offsets of the up to 26 samples around one.
#[inline]
pub(super) fn for_each_neighbour(grid: &Grid, [i, j, k]: [usize; 3], mut visit: impl FnMut(usize)) {
    let [nx, ny, nz] = grid.dims();
    let span = |c: usize, n: usize| c.saturating_sub(1)..(c + 2).min(n);
    for z in span(k, nz) {
        for y in span(j, ny) {
            for x in span(i, nx) {
                if [x, y, z] != [i, j, k] {
                    visit((z * ny + y) * nx + x);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Length;

    #[test]
    fn blocks_hold_the_neighbours_and_fall_into_touching_clusters() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [130, 4, 3]).unwrap();
        let set = Indicator::from_predicate(grid, |at| (at * 2654435761) >> 7 & 3 == 0);
        for at in 0..grid.samples() {
            let index = grid.index(at);
            let block = Block::about(&set, index);
            let mut near = Vec::new();
            for_each_neighbour(&grid, index, |n| near.extend(set.contains(grid.index(n)).then_some(n)));
            let bits: Vec<usize> =
                (0..27).filter(|n| block.bits >> n & 1 == 1).map(|n| shifted(&grid, index, n)).collect();
            assert_eq!(bits, near, "{index:?}");
            // Every cluster is closed under touching, and what is left touches none of it.
            let (mut rest, mut seen) = (block, 0);
            while let Some((first, others)) = rest.next_cluster() {
                let cluster = rest.bits & !others.bits;
                assert_eq!(first, cluster.trailing_zeros());
                let place = |n: u32| [n % 3, n / 3 % 3, n / 9];
                let touch = |a: u32, b: u32| (0..3).all(|c| place(a)[c].abs_diff(place(b)[c]) <= 1);
                let members = |bits: u32| (0..27).filter(move |n| bits >> n & 1 == 1);
                assert!(members(cluster).all(|a| members(others.bits).all(|b| !touch(a, b))));
                (rest, seen) = (others, seen | cluster);
            }
            assert_eq!(seen, block.bits);
        }
    }
}
