//! Euler characteristic and Betti numbers of sets of samples.

use super::components::{Adjacency, components};
use crate::error::{Error, Result};
use crate::field::Indicator;
use rayon::prelude::*;

/// Pieces, tunnels and voids of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Betti {
    /// Connected pieces, β₀.
    pub pieces: u64,
    /// Independent tunnels, β₁.
    pub tunnels: u64,
    /// Enclosed voids, β₂.
    pub voids: u64,
}

/// Euler characteristic χ = V − E + F − C of a set of samples.
///
/// With [`Adjacency::Corner`] the set is the union of its closed cubes, and V, E, F, C count the corners, edges, faces and
/// cubes of that union; the complement then goes with faces. With [`Adjacency::Face`] it is the union of the open cubes
/// and of the open faces, edges and corners all of whose cubes are in the set: V counts samples, E pairs, F squares and C
/// blocks of 2×2×2, and the complement goes with corners.
///
/// # Errors
/// [`Error::Operand`] for [`Adjacency::Edge`], whose complement has no partner.
///
/// # Cost
/// O(samples/64): cells are counted as bits of words.
pub fn euler_characteristic(set: &Indicator, adjacency: Adjacency) -> Result<i64> {
    let [_, ny, nz] = set.grid().dims();
    let merge = match adjacency {
        Adjacency::Corner => |a: u64, b: u64| a | b,
        Adjacency::Face => |a: u64, b: u64| a & b,
        Adjacency::Edge => {
            return Err(Error::Operand {
                operation: "Euler characteristic",
                problem: "adjacency by edges has no dual".into(),
                remedy: "use adjacency by faces or by corners".into(),
            });
        }
    };
    let words = set.words_per_row();
    let empty = vec![0u64; words];
    let row = |j: usize, k: usize| if j < ny && k < nz { set.row(j, k) } else { &empty };
    // Bits before the row are outside; one more word holds what is shifted out of the last.
    let bits = |row: &[u64], w: usize| row.get(w).copied().unwrap_or(0);
    let count = |layer: usize| -> i64 {
        let mut sum = 0;
        for j in 0..=ny {
            let back = |j: usize, k: usize| if j == 0 || k == 0 { empty.as_slice() } else { row(j - 1, k - 1) };
            // The four rows that meet at the edge along x between (j−1, k−1) and (j, k).
            let four = [back(j + 1, layer + 1), back(j, layer + 1), back(j + 1, layer), back(j, layer)];
            let mut carry = [0u64; 4];
            for w in 0..=words {
                let here = four.map(|row| bits(row, w));
                let before = [0, 1, 2, 3].map(|r| here[r] << 1 | carry[r]);
                carry = here.map(|word| word >> 63);
                let both = [0, 1, 2, 3].map(|r| merge(here[r], before[r]));
                let ones = |word: u64| i64::from(word.count_ones());
                let cubes = ones(here[0]);
                let faces = ones(both[0]) + ones(merge(here[0], here[1])) + ones(merge(here[0], here[2]));
                let edges = ones(merge(both[0], both[1]))
                    + ones(merge(both[0], both[2]))
                    + ones(merge(merge(here[0], here[1]), merge(here[2], here[3])));
                let corners = ones(merge(merge(both[0], both[1]), merge(both[2], both[3])));
                sum += corners - edges + faces - cubes;
            }
        }
        sum
    };
    let sum: i64 = (0..nz + 1).into_par_iter().with_max_len(4).map(count).sum();
    // With corners the cells are those of the complex; with faces their duals, which swaps the signs.
    Ok(if adjacency == Adjacency::Corner { sum } else { -sum })
}

/// Betti numbers of a set: β₀ its components, β₂ the components of the complement (with the dual adjacency) that do not
/// reach the border of the grid, β₁ = β₀ + β₂ − χ.
///
/// # Errors
/// As [`euler_characteristic`].
///
/// # Cost
/// Two component labellings and one count.
///
/// ```
/// use amcheck::{field::Indicator, grid::Grid, topology::{Adjacency, betti}, units::Length};
/// let grid = Grid::new([0.0; 3], Length::mm(1.0), [5, 5, 3])?;
/// let ring = Indicator::from_predicate(grid, |at| {
///     let [i, j, k] = grid.index(at);
///     k == 1 && (1..4).contains(&i) && (1..4).contains(&j) && [i, j] != [2, 2]
/// });
/// let b = betti(&ring, Adjacency::Face)?;
/// assert_eq!((b.pieces, b.tunnels, b.voids), (1, 1, 0));
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn betti(set: &Indicator, adjacency: Adjacency) -> Result<Betti> {
    let euler = euler_characteristic(set, adjacency)?;
    let dual = adjacency.dual().unwrap_or(adjacency);
    let pieces = components(set, adjacency).count() as i64;
    let voids = components(&set.complement(), dual).at_border().iter().filter(|&&open| !open).count() as i64;
    let tunnels = u64::try_from(pieces + voids - euler)
        .map_err(|_| Error::Internal { problem: format!("negative tunnels: {pieces} + {voids} - {euler}") })?;
    Ok(Betti { pieces: pieces as u64, tunnels, voids: voids as u64 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::units::Length;
    use std::collections::HashSet;

    /// Cells of the union of closed cubes, as points of the doubled lattice: parities tell their dimension.
    fn closed_cells(set: &Indicator) -> i64 {
        let mut cells = HashSet::new();
        for at in set.iter() {
            let p = set.grid().index(at).map(|c| 2 * c as i64 + 1);
            for n in 0..27 {
                cells.insert([p[0] + n % 3 - 1, p[1] + n / 3 % 3 - 1, p[2] + n / 9 - 1]);
            }
        }
        cells.iter().map(|c| if c.iter().map(|x| x & 1).sum::<i64>() % 2 == 0 { 1 } else { -1 }).sum()
    }

    /// Simplices of the dual: samples, pairs, squares and blocks all of whose samples are in the set.
    fn open_cells(set: &Indicator) -> i64 {
        let mut sum = 0;
        for at in set.iter() {
            let p = set.grid().index(at);
            for extent in 0..8usize {
                let all = (0..8usize)
                    .filter(|corner| corner & !extent == 0)
                    .all(|corner| set.contains([0, 1, 2].map(|a| p[a] + (corner >> a & 1))));
                sum += i64::from(all) * if extent.count_ones() % 2 == 0 { 1 } else { -1 };
            }
        }
        sum
    }

    #[test]
    fn characteristics_equal_the_counts_of_cells() {
        let mut state = 8u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % n
        };
        for dims in [[1, 1, 1], [64, 3, 2], [67, 2, 3], [7, 6, 5]] {
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
            for percent in [0, 20, 50, 80, 100] {
                let bits: Vec<bool> = (0..grid.samples()).map(|_| below(100) < percent).collect();
                let set = Indicator::from_predicate(grid, |at| bits[at]);
                assert_eq!(euler_characteristic(&set, Adjacency::Corner).unwrap(), closed_cells(&set));
                assert_eq!(euler_characteristic(&set, Adjacency::Face).unwrap(), open_cells(&set));
                for adjacency in [Adjacency::Corner, Adjacency::Face] {
                    betti(&set, adjacency).unwrap();
                }
            }
        }
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [2, 2, 2]).unwrap();
        assert!(euler_characteristic(&Indicator::empty(grid), Adjacency::Edge).is_err());
    }

    #[test]
    fn shapes_that_can_be_counted_by_hand() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [11, 9, 7]).unwrap();
        let set =
            |inside: &(dyn Fn([usize; 3]) -> bool + Sync)| Indicator::from_predicate(grid, |at| inside(grid.index(at)));
        let block = |p: [usize; 3], lo: [usize; 3], hi: [usize; 3]| (0..3).all(|a| (lo[a]..hi[a]).contains(&p[a]));
        let solid = |p| block(p, [1; 3], [10, 8, 6]);
        let counted = |s: &Indicator| {
            let [a, b] = [Adjacency::Corner, Adjacency::Face].map(|adjacency| betti(s, adjacency).unwrap());
            assert_eq!(a, b, "no two cubes here meet in an edge or a corner alone");
            (a.pieces, a.tunnels, a.voids)
        };
        assert_eq!(counted(&set(&solid)), (1, 0, 0));
        let two_holes = |p: [usize; 3]| solid(p) && !block(p, [3, 3, 0], [4, 5, 7]) && !block(p, [6, 3, 0], [8, 5, 7]);
        assert_eq!(counted(&set(&two_holes)), (1, 2, 0));
        let two_voids = |p: [usize; 3]| solid(p) && !block(p, [2, 2, 2], [4, 5, 4]) && !block(p, [6, 3, 2], [8, 5, 5]);
        assert_eq!(counted(&set(&two_voids)), (1, 0, 2));
        let pair = |p: [usize; 3]| block(p, [0; 3], [2, 2, 2]) || block(p, [5; 3], [11, 9, 7]);
        assert_eq!(counted(&set(&pair)), (2, 0, 0));
        // Two cubes that meet in a corner: one piece as closed cubes, two as open ones.
        let corner = set(&|p| p == [3, 3, 3] || p == [4, 4, 4]);
        assert_eq!(betti(&corner, Adjacency::Corner).unwrap(), Betti { pieces: 1, tunnels: 0, voids: 0 });
        assert_eq!(betti(&corner, Adjacency::Face).unwrap(), Betti { pieces: 2, tunnels: 0, voids: 0 });
    }
}
