//! The conservative pyramid: coarse sets that decide most translations without a ripple.

use super::convolver::{Convolver, difference_grid};
use crate::error::Result;
use crate::field::Indicator;
use crate::grid::Grid;

/// What coarse sets can say of a translation.
#[derive(Debug, Clone, PartialEq)]
pub struct Coarse {
    /// Translations, on the fine lattice, at which the sets certainly overlap.
    pub blocked: Indicator,
    /// Translations at which they certainly do not.
    pub free: Indicator,
}

impl Coarse {
    /// The share of translations that are left to a finer level.
    pub fn undecided(&self) -> f64 {
        let all = self.free.grid().samples() as f64;
        1.0 - (self.free.count() + self.blocked.count()) as f64 / all
    }
}

/// The set on a lattice twice as coarse: a coarse sample is inside if any of its eight is.
///
/// # Errors
/// As [`Grid::new`].
pub fn coarsened_any(set: &Indicator) -> Result<Indicator> {
    coarsened(set, 1)
}

/// As [`coarsened_any`], inside only if all of its eight are.
///
/// # Errors
/// As [`Grid::new`].
pub fn coarsened_all(set: &Indicator) -> Result<Indicator> {
    coarsened(set, 8)
}

/// Decides translations of B against A from sets twice as coarse.
///
/// With t = 2T + r, r ∈ {0, 1}³: if A and B + t share a sample, their coarse sets of *any* overlap at T or at T + e for
/// some e ∈ {0, 1}³ per axis where r or a carry asks for it; and if the coarse sets of *all* overlap at T, A and B + t
/// share a sample for each of the eight r. No other level of precision is involved: what is said is certain.
///
/// # Errors
/// As [`Convolver::correlate`].
///
/// # Cost
/// Two correlations of an eighth of the samples.
pub fn decide_coarsely(a: &Indicator, b: &Indicator) -> Result<Coarse> {
    let overlap = |coarse: fn(&Indicator) -> Result<Indicator>| {
        let (a, b) = (coarse(a)?, coarse(b)?);
        Ok::<_, crate::Error>((Convolver::new(&a, b.grid().dims())?.correlate(&b)?.at_least(1), b.grid().dims()))
    };
    let (any, reach) = overlap(coarsened_any)?;
    let (all, _) = overlap(coarsened_all)?;
    let fine = difference_grid(a.grid(), b.grid())?;
    let size = b.grid().dims();
    // Coarse sample i of a correlation is the translation i − (reach − 1), fine sample i the one i − (size − 1).
    let at = |index: [usize; 3], set: &Indicator, step: [isize; 3]| {
        let coarse = [0, 1, 2].map(|axis| {
            let t = index[axis] as isize - (size[axis] as isize - 1);
            t.div_euclid(2) + step[axis] + reach[axis] as isize - 1
        });
        coarse.iter().all(|&c| c >= 0) && set.contains(coarse.map(|c| c as usize))
    };
    let steps: Vec<[isize; 3]> = (0..8).map(|s: isize| [s & 1, s >> 1 & 1, s >> 2 & 1]).collect();
    let blocked = Indicator::from_predicate(fine, |offset| at(fine.index(offset), &all, [0; 3]));
    let possible = Indicator::from_predicate(fine, |offset| {
        let index = fine.index(offset);
        steps.iter().any(|&step| at(index, &any, step))
    });
    Ok(Coarse { blocked, free: possible.complement() })
}

fn coarsened(set: &Indicator, least: usize) -> Result<Indicator> {
    let grid = set.grid();
    let h = grid.h();
    let coarse =
        Grid::new(grid.origin().map(|o| o + 0.5 * h), grid.spacing() * 2.0, grid.dims().map(|n| n.div_ceil(2)))?;
    Ok(Indicator::from_predicate(coarse, |at| {
        let first = coarse.index(at).map(|i| 2 * i);
        let inside = (0..8).filter(|c| set.contains([0, 1, 2].map(|a| first[a] + (c >> a & 1))));
        inside.count() >= least
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Length;

    fn blobs(dims: [usize; 3], seed: u64) -> Indicator {
        let grid = Grid::new([0.5, -2.0, 1.0], Length::mm(0.5), dims).unwrap();
        let mut state = seed;
        let mut random = |n: usize| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as usize % n
        };
        let balls: Vec<[usize; 4]> =
            (0..4).map(|_| [random(dims[0]), random(dims[1]), random(dims[2]), 4 + random(30)]).collect();
        Indicator::from_predicate(grid, |at| {
            let p = grid.index(at);
            balls.iter().any(|b| (0..3).map(|i| p[i].abs_diff(b[i]).pow(2)).sum::<usize>() <= b[3])
        })
    }

    #[test]
    fn what_the_coarse_level_says_is_true_at_the_fine_one() {
        for (seed, dims, element) in
            [(1, [31, 24, 18], [9, 8, 7]), (2, [16, 17, 30], [6, 11, 4]), (3, [9, 9, 9], [9, 9, 9])]
        {
            let (a, b) = (blobs(dims, seed), blobs(element, seed + 9));
            let exact = Convolver::new(&a, element).unwrap().correlate(&b).unwrap().at_least(1);
            let coarse = decide_coarsely(&a, &b).unwrap();
            assert!(coarse.blocked.is_subset(&exact).unwrap(), "blocked for certain and free");
            assert!(coarse.free.intersection(&exact).unwrap().is_empty(), "free for certain and blocked");
            assert!(coarse.undecided() < 0.6, "nothing was decided: {}", coarse.undecided());
            assert!(!coarse.free.is_empty());
        }
    }

    #[test]
    fn coarse_sets_are_nested_around_the_fine_one() {
        let set = blobs([13, 12, 11], 4);
        let (any, all) = (coarsened_any(&set).unwrap(), coarsened_all(&set).unwrap());
        assert!(all.is_subset(&any).unwrap());
        assert!(all.volume() <= set.volume() && set.volume() <= any.volume());
        assert_eq!(any.grid().origin(), [0.75, -1.75, 1.25]);
    }
}
