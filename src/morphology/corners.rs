//! Where samples of a set meet by their corners alone.

use crate::field::Indicator;
use rayon::prelude::*;

/// Two samples.
pub(super) type Pair = [[usize; 3]; 2];

/// The faces of a lattice of which two corners that are not neighbours are in a set, and the others are not: these two, and the others.
pub(super) fn met_by_corners(set: &Indicator) -> Vec<(Pair, Pair)> {
    let [_, ny, nz] = set.grid().dims();
    let shifted = |row: &[u64], w: usize| row[w] >> 1 | row.get(w + 1).map_or(0, |next| next << 63);
    let of_plane = |k: usize| {
        let mut found = Vec::new();
        for j in 0..ny {
            let row = set.row(j, k);
            let along_y = (j + 1 < ny).then(|| set.row(j + 1, k));
            let along_z = (k + 1 < nz).then(|| set.row(j, k + 1));
            let along_both = along_y.and(along_z).map(|_| set.row(j + 1, k + 1));
            for (w, &bits) in row.iter().enumerate() {
                let along_x = shifted(row, w);
                let met = |b: u64, c: u64, d: u64| (bits ^ b) & (bits ^ c) & !(bits ^ d);
                let with = |other: Option<&[u64]>| other.map_or(0, |o| met(along_x, o[w], shifted(o, w)));
                let across = along_both.zip(along_y.zip(along_z)).map_or(0, |(d, (b, c))| met(b[w], c[w], d[w]));
                for ([u, v], mut mask) in [([0, 1], with(along_y)), ([0, 2], with(along_z)), ([1, 2], across)] {
                    while mask != 0 {
                        let bit = mask.trailing_zeros() as usize;
                        mask &= mask - 1;
                        let moved = |axes: &[usize]| {
                            let mut index = [w * 64 + bit, j, k];
                            axes.iter().for_each(|&a| index[a] += 1);
                            index
                        };
                        let (one, other) = ([moved(&[]), moved(&[u, v])], [moved(&[u]), moved(&[v])]);
                        found.push(if bits >> bit & 1 == 1 { (one, other) } else { (other, one) });
                    }
                }
            }
        }
        found
    };
    (0..nz).into_par_iter().flat_map_iter(of_plane).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::random::Lcg;
    use crate::units::Length;

    #[test]
    fn faces_are_those_that_a_look_at_each_finds() {
        let mut random = Lcg(5);
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [67, 5, 4]).unwrap();
        let mut set = Indicator::empty(grid);
        for at in 0..grid.samples() {
            set.set(grid.index(at), random.below(2) == 0);
        }
        let mut plain = Vec::new();
        for at in 0..grid.samples() {
            let first = grid.index(at);
            for [u, v] in [[0, 1], [0, 2], [1, 2]] {
                let moved = |axes: &[usize]| {
                    let mut index = first;
                    axes.iter().for_each(|&a| index[a] += 1);
                    index
                };
                let corners = [moved(&[]), moved(&[u]), moved(&[v]), moved(&[u, v])];
                if corners.iter().any(|c| (0..3).any(|a| c[a] >= grid.dims()[a])) {
                    continue;
                }
                match corners.map(|c| set.contains(c)) {
                    [true, false, false, true] => plain.push(([corners[0], corners[3]], [corners[1], corners[2]])),
                    [false, true, true, false] => plain.push(([corners[1], corners[2]], [corners[0], corners[3]])),
                    _ => {}
                }
            }
        }
        let mut found = met_by_corners(&set);
        found.sort_unstable();
        plain.sort_unstable();
        assert!(plain.len() > 100 && found == plain);
    }
}
