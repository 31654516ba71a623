//! The reverse transform: from balls to the set they cover.

use super::panel::{LANES, Panel, Row};
use super::squared::{Limits, internal};
use crate::error::Result;
use crate::field::Indicator;
use crate::grid::Grid;
use ndarray::{ArrayViewMut2, ArrayViewMut3, Axis};
use pulp::Arch;
use rayon::prelude::*;

/// The samples covered by closed balls about samples: { x : ∃ y, |x − y|² ≤ r²(y) }.
///
/// `radius_squared` gives r² of the ball about the sample at a storage offset, in squares of the spacing, or none; a ball
/// of radius 0 is its centre, one of more than [`super::REACH`] spacings is no larger than that. Distances between samples are whole numbers squared, so an open ball is the closed one
/// of r² − 1 for whole r², and of ⌊r²⌋ otherwise.
///
/// # Errors
/// As [`super::squared_distance`].
///
/// # Cost
/// O(N log n) however large and however many the balls; four bytes a sample.
///
/// # Source
/// Saito and Toriwaki 1994; Coeurjolly and Montanvert 2007: one lower envelope of the parabolas |x − y|² − r²(y).
///
/// ```
/// use amcheck::{distance::union_of_balls, grid::Grid, units::Length};
/// let grid = Grid::new([0.0; 3], Length::mm(1.0), [7, 7, 7])?;
/// let ball = union_of_balls(&grid, |at| (grid.index(at) == [3, 3, 3]).then_some(3))?;
/// assert_eq!(ball.count(), 27);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn union_of_balls(grid: &Grid, radius_squared: impl Fn(usize) -> Option<u32> + Sync) -> Result<Indicator> {
    let limits = Limits::of(grid);
    let [nx, ny, nz] = grid.dims();
    // No ball needs to reach beyond the grid, or farther than distances are told; f = most − r² is what is minimized.
    let most = limits.far - 1;
    let arch = Arch::new();
    let mut values = vec![0u32; grid.samples()];
    values.par_chunks_mut(nx * ny).enumerate().try_for_each_init(
        || limits.panel(nx).and_then(|x| Ok((x, limits.panel(ny)?))),
        |panels, (k, plane)| -> Result<()> {
            let (along, across_rows) = panels.as_mut().map_err(|e| e.clone())?;
            for (i, value) in plane.iter_mut().enumerate() {
                *value = radius_squared(k * nx * ny + i).map_or(limits.far, |r2| most - r2.min(most));
            }
            if plane.iter().all(|&value| value == limits.far) {
                return Ok(());
            }
            let rows = ArrayViewMut2::from_shape((ny, nx), plane).map_err(internal)?;
            arch.dispatch(|| {
                let mut rows = rows;
                across(rows.view_mut().reversed_axes(), along, limits.far);
                across(rows, across_rows, limits.far);
            });
            Ok(())
        },
    )?;
    let mut volume = ArrayViewMut3::from_shape((nz, ny, nx), &mut values).map_err(internal)?;
    volume.axis_iter_mut(Axis(1)).into_par_iter().try_for_each_init(
        || limits.panel(nz),
        |panel, rows| -> Result<()> {
            let panel = panel.as_mut().map_err(|e| e.clone())?;
            arch.dispatch(|| across(rows, panel, limits.far));
            Ok(())
        },
    )?;
    Ok(Indicator::from_predicate(*grid, |at| values[at] <= most))
}

/// Lower envelopes along the first axis of a view, cut off at `far`.
#[inline(always)]
fn across(mut rows: ArrayViewMut2<u32>, panel: &mut Panel, far: u32) {
    let (n, width) = rows.dim();
    panel.set(0, &[far; LANES]);
    panel.set(n + 1, &[far; LANES]);
    for x in (0..width).step_by(LANES) {
        let mut least = far;
        for (s, row) in rows.rows().into_iter().enumerate() {
            let mut values: Row = [0; LANES];
            for (to, &from) in values.iter_mut().zip(row.iter().skip(x)) {
                *to = from;
                least = least.min(from);
            }
            panel.set(s + 1, &values);
        }
        if least == far {
            continue;
        }
        panel.solve();
        for (y, mut row) in rows.rows_mut().into_iter().enumerate() {
            for (to, from) in row.iter_mut().skip(x).zip(panel.value(y + 1)) {
                *to = from.min(far);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::squared_distance;
    use super::*;
    use crate::units::Length;

    #[test]
    fn balls_cover_what_they_cover_in_all_pairs() {
        let mut state = 4u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % n
        };
        for dims in [[1, 1, 1], [17, 1, 1], [1, 19, 2], [18, 7, 9], [5, 21, 6]] {
            let grid = Grid::new([0.0; 3], Length::mm(0.5), dims).unwrap();
            for (percent, largest) in [(0, 1), (2, 40), (2, 1 << 31), (30, 3), (100, 2)] {
                let balls: Vec<Option<u32>> =
                    (0..grid.samples()).map(|_| (below(100) < percent).then(|| below(largest) as u32)).collect();
                let found = union_of_balls(&grid, |at| balls[at]).unwrap();
                for at in 0..grid.samples() {
                    let p = grid.index(at);
                    let d2 = |b: usize| (0..3).map(|a| p[a].abs_diff(grid.index(b)[a]).pow(2)).sum::<usize>();
                    let truth = (0..grid.samples()).any(|b| balls[b].is_some_and(|r2| d2(b) <= r2 as usize));
                    assert_eq!(found.contains(p), truth, "{dims:?} {percent} {p:?}");
                }
            }
        }
    }

    #[test]
    fn equal_balls_are_a_sublevel_set_of_the_distance() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [70, 50, 40]).unwrap();
        let set = Indicator::from_predicate(grid, |at| at % 7919 == 13);
        let d2 = squared_distance(&set).unwrap();
        for r2 in [0, 1, 2, 50, 333] {
            let balls = union_of_balls(&grid, |at| set.contains(grid.index(at)).then_some(r2)).unwrap();
            assert_eq!(balls, Indicator::from_predicate(grid, |at| d2.values()[at] <= r2));
        }
    }
}
