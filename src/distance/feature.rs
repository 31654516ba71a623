//! Which sample of a set is nearest.

use super::panel::{LANES, Panel, Row};
use super::squared::{Limits, internal};
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use ndarray::{ArrayViewMut2, ArrayViewMut3, Axis};
use pulp::Arch;
use rayon::prelude::*;

/// Stands for no sample at all.
pub const NOWHERE: u32 = u32::MAX;

/// For every sample the storage offset of the nearest sample of the set; of several, the first in storage.
///
/// Samples of the set are their own nearest. [`NOWHERE`] where none is within [`super::REACH`] spacings, and as the background. The
/// squared distance is that of the two indices, [`super::squared_distance`] without the second table.
///
/// # Errors
/// [`Error::TooLarge`] if offsets do not fit 32 bits.
///
/// # Cost
/// O(N log n), four bytes a sample.
///
/// ```
/// use amcheck::{distance::nearest_sample, field::Indicator, grid::Grid, units::Length};
/// let grid = Grid::new([0.0; 3], Length::mm(1.0), [5, 1, 1])?;
/// let mut set = Indicator::empty(grid);
/// set.set([0, 0, 0], true);
/// set.set([4, 0, 0], true);
/// assert_eq!(nearest_sample(&set)?.values(), [0, 0, 0, 4, 4]);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn nearest_sample(set: &Indicator) -> Result<Field<u32>> {
    let grid = set.grid();
    let limits = Limits::of(grid);
    if grid.samples() >= NOWHERE as usize {
        return Err(Error::TooLarge {
            what: format!("offsets of {:?} samples", grid.dims()),
            need_bytes: 8 * grid.samples() as u128,
            allowed_bytes: 4 * grid.samples() as u128,
            remedy: "choose a larger spacing, or look at a window of the part".into(),
        });
    }
    let [nx, ny, nz] = grid.dims();
    let arch = Arch::new();
    let mut nearest = vec![NOWHERE; grid.samples()];
    nearest.par_chunks_mut(nx * ny).enumerate().try_for_each_init(
        || limits.panel(ny),
        |panel, (k, plane)| -> Result<()> {
            let panel = panel.as_mut().map_err(|e| e.clone())?;
            for (j, row) in plane.chunks_mut(nx).enumerate() {
                along_row(set.row(j, k), ((k * ny + j) * nx) as u32, row);
            }
            let rows = ArrayViewMut2::from_shape((ny, nx), plane).map_err(internal)?;
            // Within a row only x differs.
            let square = |x: usize, site: u32| limits.square(x.abs_diff(site as usize % nx));
            arch.dispatch(|| across(rows, panel, limits.far, square));
            Ok(())
        },
    )?;
    let mut volume = ArrayViewMut3::from_shape((nz, ny, nx), &mut nearest).map_err(internal)?;
    volume.axis_iter_mut(Axis(1)).into_par_iter().enumerate().try_for_each_init(
        || limits.panel(nz),
        |panel, (j, rows)| -> Result<()> {
            let panel = panel.as_mut().map_err(|e| e.clone())?;
            let square = |x: usize, site: u32| {
                let site = site as usize;
                limits.far.min(limits.square(x.abs_diff(site % nx)) + limits.square(j.abs_diff(site / nx % ny)))
            };
            arch.dispatch(|| across(rows, panel, limits.far, square));
            Ok(())
        },
    )?;
    Field::from_values(*grid, nearest, NOWHERE)
}

/// The nearest set bit for each position of a row, as `start +` its position; the lower of two.
fn along_row(bits: &[u64], start: u32, row: &mut [u32]) {
    let is = |i: usize| bits[i / 64] >> (i % 64) & 1 == 1;
    let mut last = NOWHERE;
    for (i, nearest) in row.iter_mut().enumerate() {
        if is(i) {
            last = i as u32;
        }
        *nearest = last;
    }
    let mut next = NOWHERE;
    for (i, nearest) in row.iter_mut().enumerate().rev() {
        let i32 = i as u32;
        if is(i) {
            next = i32;
        }
        if next != NOWHERE && (*nearest == NOWHERE || next - i32 < i32 - *nearest) {
            *nearest = next;
        }
        if *nearest != NOWHERE {
            *nearest += start;
        }
    }
}

/// One pass across rows; `square(x, site)` is the squared distance, over the axes done before, from the line at x.
#[inline(always)]
fn across(mut rows: ArrayViewMut2<u32>, panel: &mut Panel, far: u32, square: impl Fn(usize, u32) -> u32) {
    let (n, nx) = rows.dim();
    let mut sites: Vec<Row> = vec![[NOWHERE; LANES]; n];
    panel.set(0, &[far; LANES]);
    panel.set(n + 1, &[far; LANES]);
    for x in (0..nx).step_by(LANES) {
        let width = LANES.min(nx - x);
        let mut known = false;
        for (s, (to, from)) in sites.iter_mut().zip(rows.rows()).enumerate() {
            let mut values = [0; LANES];
            for (lane, (to, &site)) in to.iter_mut().zip(from.iter().skip(x).take(width)).enumerate() {
                *to = site;
                values[lane] = if site == NOWHERE { far } else { square(x + lane, site) };
                known |= site != NOWHERE;
            }
            panel.set(s + 1, &values);
        }
        if !known {
            continue;
        }
        panel.solve();
        for (y, mut to) in rows.rows_mut().into_iter().enumerate() {
            let (from, found) = (panel.sites(y + 1), panel.value(y + 1));
            for (lane, to) in to.iter_mut().skip(x).take(width).enumerate() {
                // The row of a site is 1..=n wherever the line has a site at all.
                let near = sites.get((from[lane] as usize).wrapping_sub(1)).filter(|_| found[lane] < far);
                *to = near.map_or(NOWHERE, |row| row[lane]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::units::Length;

    #[test]
    fn axes_of_more_samples_than_a_square_has_bits_for_are_right() {
        let n = 70_000;
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [1, n, 1]).unwrap();
        let mut set = Indicator::empty(grid);
        set.set([0, 0, 0], true);
        set.set([0, n - 1, 0], true);
        let found = nearest_sample(&set).unwrap();
        for (at, &nearest) in found.values().iter().enumerate() {
            let truth = match at {
                _ if at < crate::distance::REACH as usize => 0,
                _ if n - 1 - at < crate::distance::REACH as usize => n as u32 - 1,
                _ => NOWHERE,
            };
            assert_eq!(nearest, truth, "{at}");
        }
    }

    #[test]
    fn the_nearest_is_the_first_of_the_least_in_all_pairs() {
        let mut state = 9u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % n
        };
        for dims in [[1, 1, 1], [9, 1, 1], [1, 9, 1], [1, 1, 9], [17, 5, 6], [20, 13, 4], [3, 4, 40]] {
            let grid = Grid::new([0.0; 3], Length::mm(0.5), dims).unwrap();
            for percent in [0, 1, 5, 50, 100] {
                let bits: Vec<bool> = (0..grid.samples()).map(|_| below(100) < percent).collect();
                let set = Indicator::from_predicate(grid, |at| bits[at]);
                let found = nearest_sample(&set).unwrap();
                for at in 0..grid.samples() {
                    let p = grid.index(at);
                    let truth = set
                        .iter()
                        .map(|b| ((0..3).map(|a| p[a].abs_diff(grid.index(b)[a]).pow(2)).sum::<usize>(), b))
                        .min()
                        .map_or(NOWHERE, |(_, b)| b as u32);
                    assert_eq!(found.values()[at], truth, "{dims:?} {percent} {p:?}");
                }
            }
        }
    }
}
