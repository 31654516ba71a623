//! Exact squared Euclidean distances between samples.

use super::panel::{LANES, Panel, Row};
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use crate::grid::Grid;
use ndarray::{ArrayViewMut2, ArrayViewMut3, Axis};
use pulp::Arch;
use rayon::prelude::*;

/// The squared distance where there is nothing to measure to, or nothing within [`REACH`].
pub const FAR: u32 = u32::MAX;

/// How far distances are told, spacings: a squared one, the square that a pass adds to it and the number of a row share a word of 30 bits.
pub const REACH: u32 = 23_168;

/// Which samples get a distance; the others get 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    /// Samples outside, to the nearest sample inside.
    Outside,
    /// Samples inside, to the nearest sample outside; everything beyond the grid is outside.
    Inside,
    /// Both, each to the other.
    Both,
}

/// Squared distance of every sample to the nearest sample of the set, in units of the spacing: 0 in the set.
///
/// d²(x) = min { |x − y|² : y ∈ A }, exactly; [`FAR`] where that is [`REACH`]² or more, and everywhere if A is empty. The background is [`FAR`].
///
/// # Errors
/// None on a grid that there is.
///
/// # Cost
/// O(N log n), four bytes a sample.
///
/// # Source
/// Separable passes as in Saito and Toriwaki 1994; envelopes by monotone minima.
///
/// ```
/// use amcheck::{distance::squared_distance, field::Indicator, grid::Grid, units::Length};
/// let grid = Grid::new([0.0; 3], Length::mm(1.0), [4, 3, 1])?;
/// let mut set = Indicator::empty(grid);
/// set.set([0, 0, 0], true);
/// assert_eq!(squared_distance(&set)?.values(), [0, 1, 4, 9, 1, 2, 5, 10, 4, 5, 8, 13]);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn squared_distance(set: &Indicator) -> Result<Field<u32>> {
    Field::from_values(*set.grid(), transform(set, Side::Outside, |d2, inside| if inside { 0 } else { d2 })?, FAR)
}

/// Squared distance of every sample of the set to the nearest sample outside it, in units of the spacing: 0 outside.
///
/// Everything beyond the grid is outside, as the background of an indicator says, so the depth is finite.
///
/// # Errors
/// As [`squared_distance`].
pub fn squared_depth(set: &Indicator) -> Result<Field<u32>> {
    Field::from_values(*set.grid(), transform(set, Side::Inside, |d2, inside| if inside { d2 } else { 0 })?, 0)
}

/// Both in one pass: d² outside and −d² inside, in units of the spacing; never 0.
///
/// Outside an empty set it is `i32::MAX`, which is the background too.
///
/// # Errors
/// As [`squared_distance`].
pub fn signed_squared(set: &Indicator) -> Result<Field<i32>> {
    let values = transform(set, Side::Both, |d2, inside| {
        let d2 = i32::try_from(d2).unwrap_or(i32::MAX);
        if inside { -d2 } else { d2 }
    })?;
    Field::from_values(*set.grid(), values, i32::MAX)
}

/// What a transform can be made of: between the passes a word travels in the place of the result.
pub(super) trait Store: Copy + Default + Send + Sync {
    fn pack(word: u32) -> Self;
    fn unpack(self) -> u32;
}

impl Store for u32 {
    fn pack(word: u32) -> Self {
        word
    }
    fn unpack(self) -> u32 {
        self
    }
}

impl Store for i32 {
    fn pack(word: u32) -> Self {
        word as i32
    }
    fn unpack(self) -> u32 {
        self as u32
    }
}

/// Words stay below the bit patterns of infinity and of what is not a number.
impl Store for f32 {
    fn pack(word: u32) -> Self {
        f32::from_bits(word)
    }
    fn unpack(self) -> u32 {
        self.to_bits()
    }
}

/// A squared distance more than any on the grid or, on long ones, than any that is told; and room for panels of all axes.
pub(super) struct Limits {
    pub far: u32,
}

impl Limits {
    /// Cut off at `far`, sums of squares stay right below it: what is farther on one axis alone is farther altogether.
    pub fn of(grid: &Grid) -> Self {
        let farthest: u128 = grid.dims().iter().map(|&n| (n as u128 + 1).pow(2)).sum();
        let told = REACH * REACH;
        Limits { far: u32::try_from(farthest).map_or(told, |far| far.min(told)) }
    }

    /// The square of a whole number of spacings, or `far` if it is less.
    #[inline(always)]
    pub fn square(&self, spacings: usize) -> u32 {
        (spacings.min(REACH as usize) as u32).pow(2).min(self.far)
    }

    pub fn panel(&self, n: usize) -> Result<Panel> {
        Panel::new(n, self.far).ok_or_else(|| Error::Internal { problem: format!("no panel of {n} rows") })
    }

    fn work(&self, n: usize) -> Result<Work> {
        Ok(Work { panel: self.panel(n)?, block: vec![[[0; LANES]; PANELS]; n] })
    }
}

/// A view whose shape we have got wrong.
pub(super) fn internal(error: ndarray::ShapeError) -> Error {
    Error::Internal { problem: error.to_string() }
}

/// What one thread works in.
struct Work {
    panel: Panel,
    block: Vec<Block>,
}

/// The transform of one or both sides; `finish` makes the result from d² ([`FAR`] if there is none) and the class.
pub(super) fn transform<T: Store>(
    set: &Indicator,
    side: Side,
    finish: impl Fn(u32, bool) -> T + Copy + Send + Sync,
) -> Result<Vec<T>> {
    let grid = set.grid();
    let limits = Limits::of(grid);
    let [nx, ny, nz] = grid.dims();
    // The same code for the widest vectors of the machine.
    let arch = Arch::new();
    let mut values = vec![T::default(); grid.samples()];
    values.par_chunks_mut(nx * ny).enumerate().try_for_each_init(
        || limits.work(ny),
        |work, (k, plane)| -> Result<()> {
            let work = work.as_mut().map_err(|e| e.clone())?;
            let mut any = 0;
            for (j, row) in plane.chunks_mut(nx).enumerate() {
                any |= along_row(set.row(j, k), limits.far, row);
            }
            if any != 0 {
                let plane = ArrayViewMut2::from_shape((ny, nx), plane).map_err(internal)?;
                let keep = |word| T::pack(word);
                arch.dispatch(|| across(plane, work, side, limits.far, keep));
            }
            Ok(())
        },
    )?;
    let mut volume = ArrayViewMut3::from_shape((nz, ny, nx), &mut values).map_err(internal)?;
    let far = limits.far;
    let last = move |word: u32| {
        let (d2, inside) = (word >> 1, word & 1 == 1);
        finish(if d2 >= far { FAR } else { d2 }, inside)
    };
    volume.axis_iter_mut(Axis(1)).into_par_iter().try_for_each_init(
        || limits.work(nz),
        |work, lines| -> Result<()> {
            let work = work.as_mut().map_err(|e| e.clone())?;
            arch.dispatch(|| across(lines, work, side, limits.far, last));
            Ok(())
        },
    )?;
    Ok(values)
}

/// Squared distances along a row from its bits, as words `d² << 1 | inside`; returns the union of the bits.
fn along_row<T: Store>(bits: &[u64], far: u32, row: &mut [T]) -> u64 {
    let n = row.len();
    let any = bits.iter().fold(0, |any, w| any | w);
    if any == 0 {
        row.fill(T::pack(far << 1));
        return 0;
    }
    let mut from = 0;
    while from < n {
        let inside = u32::from(bits[from / 64] >> (from % 64) & 1 == 1);
        let to = end_of_run(bits, from, n);
        // Beyond the grid everything is outside: an end for what is inside, none for what is outside.
        let (before, behind) = (from > 0 || inside == 1, to < n || inside == 1);
        let run = &mut row[from..to];
        let length = run.len();
        for (i, value) in run.iter_mut().enumerate() {
            let (a, b) = ((i + 1) as u32, (length - i) as u32);
            let d = match (before, behind) {
                (true, true) => {
                    if a < b {
                        a
                    } else {
                        b
                    }
                }
                (true, false) => a,
                _ => b,
            };
            // The square of more is no less than `far`, and may not fit.
            let d = if d < REACH { d } else { REACH };
            *value = T::pack((d * d) << 1 | inside);
        }
        from = to;
    }
    any
}

/// The first position behind `from` whose bit differs from that of `from`, or n.
#[inline]
fn end_of_run(bits: &[u64], from: usize, n: usize) -> usize {
    let flip = if bits[from / 64] >> (from % 64) & 1 == 1 { !0 } else { 0 };
    let mut word = from / 64;
    let mut mask = !0u64 << (from % 64);
    while word < bits.len() {
        let found = (bits[word] ^ flip) & mask;
        if found != 0 {
            return (word * 64 + found.trailing_zeros() as usize).min(n);
        }
        (word, mask) = (word + 1, !0);
    }
    n
}

/// Panels that are fetched together: a few cache lines in a row cost little more than one.
const PANELS: usize = 8;

/// Words of a few panels side by side, row by row.
type Block = [Row; PANELS];

/// One pass across rows: the lines of a view whose rows are contiguous, block by block.
#[inline(always)]
fn across<T: Store>(mut lines: ArrayViewMut2<T>, work: &mut Work, side: Side, far: u32, store: impl Fn(u32) -> T) {
    let (_, nx) = lines.dim();
    let Work { panel, block } = work;
    for x in (0..nx).step_by(PANELS * LANES) {
        let width = (PANELS * LANES).min(nx - x);
        let (mut some, mut every) = ([0; PANELS], [1; PANELS]);
        for (to, from) in block.iter_mut().zip(lines.rows()) {
            let from = from.to_slice().unwrap_or(&[]);
            for (to, from) in to.as_flattened_mut().iter_mut().zip(&from[x..x + width]) {
                *to = from.unpack();
            }
            for (p, row) in to.iter().enumerate() {
                some[p] |= row.iter().fold(0, |some, word| some | word) & 1;
                every[p] &= row.iter().fold(1, |every, word| every & word);
            }
        }
        for p in 0..width.div_ceil(LANES) {
            if side != Side::Inside && every[p] == 0 {
                envelope(block, p, panel, 0, far);
            }
            if side != Side::Outside && some[p] == 1 {
                envelope(block, p, panel, 1, far);
            }
        }
        for (from, mut to) in block.iter().zip(lines.rows_mut()) {
            if let Some(to) = to.as_slice_mut() {
                for (to, from) in to[x..x + width].iter_mut().zip(from.as_flattened()) {
                    *to = store(*from);
                }
            }
        }
    }
}

/// Replaces the distances of one class (0 outside, 1 inside) by their lower envelopes along the lines of panel `p`.
#[inline(always)]
fn envelope(block: &mut [Block], p: usize, panel: &mut Panel, class: u32, far: u32) {
    let n = block.len();
    let mut least = [far; LANES];
    for (s, row) in block.iter().enumerate() {
        let values = row[p].map(|word| if word & 1 == class { word >> 1 } else { 0 });
        for (least, value) in least.iter_mut().zip(values) {
            *least = if value < *least { value } else { *least };
        }
        panel.set(s + 1, &values);
    }
    let beyond = [if class == 1 { 0 } else { far }; LANES];
    if least.iter().chain(&beyond).all(|&v| v >= far) {
        return;
    }
    panel.set(0, &beyond);
    panel.set(n + 1, &beyond);
    panel.solve();
    for (y, row) in block.iter_mut().enumerate() {
        let found = panel.value(y + 1);
        for (word, found) in row[p].iter_mut().zip(found) {
            let found = (if found < far { found } else { far }) << 1 | class;
            *word = if *word & 1 == class { found } else { *word };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Length;

    /// The definition, in all pairs; beyond the grid everything is outside.
    fn brute(set: &Indicator) -> Vec<i32> {
        let grid = set.grid();
        let dims = grid.dims().map(|n| n as i64);
        let square = |at: usize, b: usize| -> i64 {
            let (a, b) = (grid.index(at), grid.index(b));
            (0..3).map(|c| (a[c] as i64 - b[c] as i64).pow(2)).sum()
        };
        let inside = |at: usize| set.contains(grid.index(at));
        (0..grid.samples())
            .map(|at| {
                let others = (0..grid.samples()).filter(|&b| inside(b) != inside(at)).map(|b| square(at, b)).min();
                if !inside(at) {
                    return others.map_or(i32::MAX, |d2| d2 as i32);
                }
                let index = grid.index(at).map(|i| i as i64);
                let border = (0..3).map(|c| (index[c] + 1).min(dims[c] - index[c]).pow(2)).min().unwrap();
                -(others.map_or(border, |d2| d2.min(border)) as i32)
            })
            .collect()
    }

    fn check(set: &Indicator) {
        let truth = brute(set);
        assert_eq!(signed_squared(set).unwrap().values(), truth, "{:?}", set.grid().dims());
        let outside: Vec<u32> = truth.iter().map(|&d| if d == i32::MAX { FAR } else { d.max(0) as u32 }).collect();
        let inside: Vec<u32> = truth.iter().map(|&d| (-d).max(0) as u32).collect();
        assert_eq!(squared_distance(set).unwrap().values(), outside);
        assert_eq!(squared_depth(set).unwrap().values(), inside);
    }

    #[test]
    fn transforms_equal_all_pairs() {
        let mut state = 3u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % n
        };
        for dims in [[1, 1, 1], [5, 1, 1], [1, 7, 1], [1, 1, 9], [17, 5, 3], [16, 16, 4], [3, 11, 13], [66, 4, 5]] {
            let grid = Grid::new([0.0; 3], Length::mm(0.5), dims).unwrap();
            for density in [0, 1, 3, 30, 97, 100] {
                let bits: Vec<bool> = (0..grid.samples()).map(|_| below(100) < density).collect();
                check(&Indicator::from_predicate(grid, |at| bits[at]));
            }
            // Blobs, so that there is something deep on both sides.
            let centre = dims.map(|n| below(n as u64) as f64);
            let radius = 0.3 * *dims.iter().max().unwrap() as f64;
            check(&Indicator::from_predicate(grid, |at| {
                let p = grid.index(at);
                (0..3).map(|a| (p[a] as f64 - centre[a]).powi(2)).sum::<f64>() < radius * radius
            }));
        }
    }

    #[test]
    fn one_sample_and_its_complement_on_a_larger_grid() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [40, 33, 29]).unwrap();
        let seed = [13usize, 20, 7];
        let mut set = Indicator::empty(grid);
        set.set(seed, true);
        let d2 = |at: usize| -> u32 { (0..3).map(|a| grid.index(at)[a].abs_diff(seed[a]).pow(2) as u32).sum() };
        let truth: Vec<u32> = (0..grid.samples()).map(d2).collect();
        assert_eq!(squared_distance(&set).unwrap().values(), truth);
        let depth = squared_depth(&set.complement()).unwrap();
        for (at, (&found, d2)) in depth.values().iter().zip(truth).enumerate() {
            let p = grid.index(at);
            let border = (0..3).map(|a| (p[a] + 1).min(grid.dims()[a] - p[a]).pow(2) as u32).min().unwrap();
            assert_eq!(found, d2.min(border));
        }
    }

    #[test]
    fn a_grid_longer_than_distances_are_told_has_those_that_are_nearer() {
        for (axis, n) in [(0, 80_000), (1, 40_000), (2, 30_000)] {
            let mut dims = [1, 2, 1];
            dims[axis] = n;
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
            let mut set = Indicator::empty(grid);
            let mut seed = [0; 3];
            seed[axis] = 5;
            set.set(seed, true);
            let found = squared_distance(&set).unwrap();
            for (at, &found) in found.values().iter().enumerate() {
                let d2: usize = (0..3).map(|a| grid.index(at)[a].abs_diff(seed[a]).pow(2)).sum();
                let told = if d2 < REACH.pow(2) as usize { d2 as u32 } else { FAR };
                assert_eq!(found, told, "axis {axis}, sample {:?}", grid.index(at));
            }
            assert!(signed_squared(&set.complement()).unwrap().values().iter().all(|d2| [-1, 1, 2].contains(d2)));
        }
    }
}
