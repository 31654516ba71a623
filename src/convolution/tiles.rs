//! Overlap-save: a small element in a large grid, tile by tile, equal to the whole bit for bit.

use super::convolver::Counts;
use super::direct::sum_grid;
use super::precision::{Precision, Workload};
use super::size::{good_even_size, good_size};
use super::spectrum::Spectrum;
use super::transform::{Real, RowContent, Transform, Window};
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use crate::grid::{Grid, samples_of};
use rayon::prelude::*;

/// `(1_A ∗ 1_B)(t) = #{ (a, b) : a + b = t }` in tiles: the same counts as the whole transform gives.
///
/// Tiles whose samples of A are all outside or all inside are not transformed.
///
/// # Errors
/// [`Error::Operand`] for different spacings; [`Error::PrecisionLost`] if a tile's counts could not be rounded.
///
/// # Cost
/// Two transforms for each tile that the boundary of A comes near; a tile's spectrum, and the result.
pub fn convolve_tiled(a: &Indicator, b: &Indicator) -> Result<Counts> {
    let grid = sum_grid(a.grid(), b.grid())?;
    let mut counts = vec![0u32; grid.samples()];
    let (precision, bound) = in_tiles(a, b, &grid, &mut counts, grid.dims()[0], |row, start, values| {
        row[start..start + values.len()].copy_from_slice(values);
    })?;
    Ok(Counts { field: Field::from_values(grid, counts, 0)?, precision, bound })
}

/// A ⊕ B = { a + b } in tiles, and the arithmetic that was used.
///
/// # Errors
/// As [`convolve_tiled`].
///
/// # Cost
/// As there, the result being one bit a sample.
pub fn dilate_tiled(a: &Indicator, b: &Indicator) -> Result<(Indicator, Precision)> {
    let grid = sum_grid(a.grid(), b.grid())?;
    let mut sum = Indicator::empty(grid);
    let words = sum.words_per_row();
    let (precision, _) = in_tiles(a, b, &grid, sum.words_mut(), words, |row, start, values| {
        for (at, _) in values.iter().enumerate().filter(|(_, count)| **count > 0) {
            row[(start + at) / 64] |= 1 << ((start + at) % 64);
        }
    })?;
    Ok((sum, precision))
}

/// Sides of the cyclic transform for an element: four times the element, or the whole where that is less.
fn tile_sides(element: [usize; 3], sum: [usize; 3]) -> [usize; 3] {
    let side = |a: usize| (4 * element[a]).max(48).min(sum[a] + element[a]);
    [good_even_size(side(0)), good_size(side(1)), good_size(side(2))]
}

/// Fills `out`, `row_len` items a row, tile by tile: `emit(row, start, counts)` stores a piece of a row.
fn in_tiles<O: Send>(
    a: &Indicator,
    b: &Indicator,
    grid: &Grid,
    out: &mut [O],
    row_len: usize,
    emit: impl Fn(&mut [O], usize, &[u32]) + Sync,
) -> Result<(Precision, f64)> {
    let padded = tile_sides(b.grid().dims(), grid.dims());
    let padded_samples = samples_of(padded);
    let largest = a.count().min(padded_samples.min(u128::from(u64::MAX)) as u64);
    let work = Workload::of_counts(largest, b.count(), padded_samples);
    let precision = if work.bound(Precision::Single) < super::ALLOWED { Precision::Single } else { Precision::Double };
    let bound = work.demand(precision)?;
    match precision {
        Precision::Single => Tiler::<f32>::new(a, b, grid, padded)?.run(out, row_len, emit)?,
        _ => Tiler::<f64>::new(a, b, grid, padded)?.run(out, row_len, emit)?,
    }
    Ok((precision, bound))
}

struct Tiler<'a, T: Real> {
    a: &'a Indicator,
    element: [usize; 3],
    element_count: u32,
    sum: [usize; 3],
    plan: Transform<T>,
    spectrum: Spectrum<T>,
    /// Samples of the result that one tile gives.
    tile: [usize; 3],
}

/// What the samples of A under a tile are.
enum Content {
    Empty,
    Full,
    Mixed,
}

impl<'a, T: Real> Tiler<'a, T> {
    fn new(a: &'a Indicator, b: &Indicator, grid: &Grid, padded: [usize; 3]) -> Result<Self> {
        let plan = Transform::new(padded);
        let spectrum = plan.forward(|j, k, row| super::convolver::bits(b, j, k, row))?;
        let element = b.grid().dims();
        let tile = [0, 1, 2].map(|i| padded[i] + 1 - element[i]);
        let element_count = u32::try_from(b.count()).map_err(|_| Error::Internal { problem: "element".into() })?;
        Ok(Tiler { a, element, element_count, sum: grid.dims(), plan, spectrum, tile })
    }

    fn run<O: Send>(&self, out: &mut [O], row_len: usize, emit: impl Fn(&mut [O], usize, &[u32]) + Sync) -> Result<()> {
        let slab = row_len * self.sum[1] * self.tile[2];
        out.par_chunks_mut(slab).enumerate().try_for_each_init(
            || (self.plan.spectrum(), vec![0u32; self.tile.iter().product()]),
            |(product, counts), (slab, rows)| {
                for y in (0..self.sum[1]).step_by(self.tile[1]) {
                    for x in (0..self.sum[0]).step_by(self.tile[0]) {
                        self.tile_at([x, y, slab * self.tile[2]], product, counts, rows, row_len, &emit)?;
                    }
                }
                Ok(())
            },
        )
    }

    fn tile_at<O>(
        &self,
        first: [usize; 3],
        product: &mut Spectrum<T>,
        counts: &mut [u32],
        rows: &mut [O],
        row_len: usize,
        emit: &impl Fn(&mut [O], usize, &[u32]),
    ) -> Result<()> {
        match self.content(first) {
            Content::Empty => return Ok(()),
            Content::Full => counts.fill(self.element_count),
            Content::Mixed => self.counts(first, product, counts)?,
        }
        let kept = [0, 1, 2].map(|i| self.tile[i].min(self.sum[i] - first[i]));
        for k in 0..kept[2] {
            for j in 0..kept[1] {
                let row = (k * self.sum[1] + first[1] + j) * row_len;
                let from = (k * self.tile[1] + j) * self.tile[0];
                emit(&mut rows[row..row + row_len], first[0], &counts[from..from + kept[0]]);
            }
        }
        Ok(())
    }

    fn counts(&self, first: [usize; 3], product: &mut Spectrum<T>, counts: &mut [u32]) -> Result<()> {
        self.plan.forward_into(product, |j, k, row| self.row_under(first, j, k, row))?;
        product.multiply(&self.spectrum)?;
        // The first m − 1 samples along each axis have wrapped around; the others are the whole's.
        let window = Window { start: self.element.map(|m| m - 1), dims: self.tile };
        self.plan.inverse_in_place(product, window, counts, self.tile[0], |row, out| {
            out.iter_mut().zip(row).for_each(|(o, &v)| {
                let v: f64 = v.into();
                *o = (v + 0.5).max(0.0) as u32;
            });
        })
    }

    /// Row `(j, k)` of the samples of A under a tile; the tile's transform starts m − 1 samples before its result.
    fn row_under(&self, first: [usize; 3], j: usize, k: usize, row: &mut [T]) -> RowContent {
        let dims = self.a.grid().dims();
        let at =
            |axis: usize, i: usize| (first[axis] + i).checked_sub(self.element[axis] - 1).filter(|&s| s < dims[axis]);
        let (Some(y), Some(z)) = (at(1, j), at(2, k)) else { return RowContent::Zero };
        let bits = self.a.row(y, z);
        if bits.iter().all(|&w| w == 0) {
            return RowContent::Zero;
        }
        row.iter_mut().enumerate().for_each(|(i, v)| {
            let inside = at(0, i).is_some_and(|s| bits[s / 64] >> (s % 64) & 1 == 1);
            *v = if inside { T::one() } else { T::zero() };
        });
        RowContent::Filled
    }

    /// Whether any, or all, of the samples of A that the results of a tile depend on are inside.
    fn content(&self, first: [usize; 3]) -> Content {
        let dims = self.a.grid().dims();
        let lo = [0, 1, 2].map(|i| first[i].saturating_sub(self.element[i] - 1));
        let hi = [0, 1, 2].map(|i| (first[i] + self.tile[i].min(self.sum[i] - first[i])).min(dims[i]));
        let clipped = (0..3)
            .any(|i| first[i] + 1 < self.element[i] || first[i] + self.tile[i].min(self.sum[i] - first[i]) > dims[i]);
        let (mut any, mut all) = (false, !clipped);
        for k in lo[2]..hi[2] {
            for j in lo[1]..hi[1] {
                let (row_any, row_all) = row_range(self.a.row(j, k), lo[0], hi[0]);
                any |= row_any;
                all &= row_all;
                if any && !all {
                    return Content::Mixed;
                }
            }
        }
        match (any, all) {
            (false, _) => Content::Empty,
            (true, true) => Content::Full,
            (true, false) => Content::Mixed,
        }
    }
}

/// Whether any, and whether all, of the samples `lo..hi` of a bit row are inside.
fn row_range(bits: &[u64], lo: usize, hi: usize) -> (bool, bool) {
    let (mut any, mut all, mut at) = (false, true, lo);
    while at < hi {
        let take = (64 - at % 64).min(hi - at);
        let mask = (!0u64 >> (64 - take)) << (at % 64);
        let found = bits[at / 64] & mask;
        any |= found != 0;
        all &= found == mask;
        at += take;
    }
    (any, all)
}

#[cfg(test)]
mod tests {
    use super::super::{Convolver, dilate_by_runs};
    use super::*;
    use crate::units::Length;

    fn blobs(dims: [usize; 3], seed: u64) -> Indicator {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
        let mut state = seed;
        let mut random = |n: usize| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as usize % n
        };
        let balls: Vec<[usize; 4]> =
            (0..6).map(|_| [random(dims[0]), random(dims[1]), random(dims[2]), 1 + random(20).pow(2)]).collect();
        Indicator::from_predicate(grid, |at| {
            let p = grid.index(at);
            balls.iter().any(|b| (0..3).map(|i| p[i].abs_diff(b[i]).pow(2)).sum::<usize>() <= b[3])
        })
    }

    #[test]
    fn tiles_are_the_whole_bit_for_bit() {
        for (dims, element) in [([150, 90, 70], [9, 4, 6]), ([61, 130, 20], [1, 1, 1]), ([100, 50, 120], [17, 2, 11])] {
            let (a, b) = (blobs(dims, 3), blobs(element, 8));
            let whole = Convolver::new(&a, element).unwrap().convolve(&b).unwrap();
            let tiled = convolve_tiled(&a, &b).unwrap();
            assert_eq!(tiled.field, whole.field);
            let (sum, _) = dilate_tiled(&a, &b).unwrap();
            assert_eq!(sum, whole.at_least(1));
            assert_eq!(sum, dilate_by_runs(&a, &b).unwrap());
        }
    }

    #[test]
    fn a_full_grid_is_full_only_where_the_element_fits() {
        // Three tiles along each axis: the middle one is full, but for the tile that the missing sample is in or near.
        let b = blobs([5, 4, 3], 1);
        let whole = Grid::new([0.0; 3], Length::mm(1.0), [100; 3]).unwrap();
        for missing in [None, Some([95, 60, 60]), Some([60, 60, 60])] {
            let a = Indicator::from_predicate(whole, |at| Some(whole.index(at)) != missing);
            let sum = sum_grid(&whole, b.grid()).unwrap();
            let tiler = Tiler::<f32>::new(&a, &b, &sum, tile_sides(b.grid().dims(), sum.dims())).unwrap();
            assert_eq!(matches!(tiler.content(tiler.tile), Content::Full), missing != Some([60, 60, 60]));
            assert!(matches!(tiler.content([0; 3]), Content::Mixed));
            assert_eq!(convolve_tiled(&a, &b).unwrap().field, super::super::convolve_directly(&a, &b).unwrap());
        }
    }
}
