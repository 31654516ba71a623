//! Sets as trees of nodes of 4³ cells: samples at the bottom, nodes of 4, 16 and 64 samples above.
//!
//! Laid over each other, the one that moves is asked node by node (64 bits), the one that stands by the 8³ cells that a node
//! moved by less than its width may come over (a neighbourhood, one cache line).

use crate::field::Indicator;
use rayon::prelude::*;
use std::borrow::Cow;

/// Levels of nodes above the samples.
pub(super) const LEVELS: usize = 3;
/// Cells along a node.
pub(super) const SIDE: isize = 4;
/// Nodes before the first, at every level: a neighbourhood that begins there may still reach into the set.
const BEFORE: isize = 2;

/// 8³ cells: layer z, bit 8·y + x.
pub(super) type Neighbourhood = [u64; 8];

/// A table of neighbourhoods; those that are empty or full are not stored.
#[derive(Debug, Clone)]
struct Neighbourhoods {
    dims: [usize; 3],
    slots: Vec<u32>,
    stored: Vec<Neighbourhood>,
}

const EMPTY: u32 = 0;
const FULL: u32 = 1;
/// Neighbourhoods along x that 64 cells hold.
const AT_ONCE: usize = 15;

impl Neighbourhoods {
    /// The table of a set of cells.
    fn of(cells: &Cells) -> Self {
        let dims = cells.dims.map(|n| (n - cells.before).div_ceil(SIDE as usize) + BEFORE as usize);
        let planes: Vec<(Vec<u32>, Vec<Neighbourhood>)> = (0..dims[2])
            .into_par_iter()
            .map(|k| {
                let (mut slots, mut own) = (Vec::with_capacity(dims[0] * dims[1]), Vec::new());
                let mut rows = [0u64; 64];
                for (j, first) in (0..dims[1]).flat_map(|j| (0..dims[0]).step_by(AT_ONCE).map(move |first| (j, first)))
                {
                    let corner = [first, j, k].map(|n| SIDE * (n as isize - BEFORE) + cells.before as isize);
                    cells.rows_around(corner, &mut rows);
                    let (any, all) = rows.iter().fold((0, !0), |(any, all), row| (any | row, all & row));
                    for shift in (first..dims[0].min(first + AT_ONCE)).map(|i| SIDE as usize * (i - first)) {
                        if any >> shift & 0xFF == 0 || all >> shift & 0xFF == 0xFF {
                            slots.push(if any >> shift & 0xFF == 0 { EMPTY } else { FULL });
                            continue;
                        }
                        let cells = bytes_of(&rows, shift);
                        // Flat faces: the same as the one before along x or y.
                        let before =
                            |step: usize| slots.len().checked_sub(step).map(|at| slots[at]).filter(|s| *s > FULL);
                        let same = [before(1), before(dims[0])]
                            .into_iter()
                            .flatten()
                            .find(|s| own[(s - FULL - 1) as usize] == cells);
                        slots.push(same.unwrap_or_else(|| {
                            own.push(cells);
                            own.len() as u32 + FULL
                        }));
                    }
                }
                (slots, own)
            })
            .collect();
        let mut table = Neighbourhoods { dims, slots: Vec::new(), stored: vec![[0; 8], [!0; 8]] };
        for (slots, own) in planes {
            let before = table.stored.len() as u32 - 2;
            table.slots.extend(slots.into_iter().map(|s| if s > FULL { s + before } else { s }));
            table.stored.extend(own);
        }
        table
    }

    /// The table of the nodes of this one that hold anything.
    fn above(&self) -> Self {
        let [nx, ny, _] = self.dims;
        let some = |[i, j, k]: [usize; 3]| self.slots[(k * ny + j) * nx + i] != EMPTY;
        Neighbourhoods::of(&Cells { before: BEFORE as usize, ..Cells::those(self.dims, some) })
    }

    /// The cells that a node at an index may come over, with a number that equal ones often share; `None` if there are none.
    #[inline(always)]
    fn at(&self, index: [isize; 3]) -> Option<(u32, &Neighbourhood)> {
        let [i, j, k] = index.map(|n| (n + BEFORE) as usize);
        let inside = i < self.dims[0] && j < self.dims[1] && k < self.dims[2];
        let slot = if inside { self.slots[(k * self.dims[1] + j) * self.dims[0] + i] } else { EMPTY };
        (slot != EMPTY).then(|| (slot, &self.stored[slot as usize]))
    }
}

/// The set that stands.
#[derive(Debug, Clone)]
pub(super) struct Ground {
    /// By level, from 1: of the cells that hold any of the set within the width of a cell and the next one.
    any: Vec<Neighbourhoods>,
    /// By level, from 2: of the cells that a full cell of the other meets, moved by less than its width in whatever way.
    sure: Vec<Neighbourhoods>,
}

impl Ground {
    pub fn new(set: &Indicator) -> Self {
        let samples = Cells { dims: set.grid().dims(), before: 0, words: Cow::Borrowed(set.words()) };
        let mut any = vec![Neighbourhoods::of(&samples)];
        let mut sure: Vec<Neighbourhoods> = Vec::new();
        let mut step = SIDE as usize;
        for level in 1..LEVELS {
            // The last sample of a cell: a full cell of the other holds it however it is moved.
            let last = |cell: [usize; 3]| set.contains(cell.map(|c| step * c + step - 1));
            sure.push(Neighbourhoods::of(&Cells::those(samples.dims.map(|n| n.div_ceil(step)), last)));
            any.push(any[level - 1].above());
            step *= SIDE as usize;
        }
        Ground { any, sure }
    }

    /// What a node of this level may meet at an index, in cells of the level below.
    #[inline(always)]
    pub fn any(&self, level: usize, index: [isize; 3]) -> Option<&Neighbourhood> {
        Some(self.any[level - 1].at(index)?.1)
    }

    /// What a node of the lowest level may meet at an index, with a number that equal neighbourhoods often share.
    #[inline(always)]
    pub fn samples(&self, index: [isize; 3]) -> Option<(u32, &Neighbourhood)> {
        self.any[0].at(index)
    }

    /// What full cells of the level below meet for certain; levels from 2.
    #[inline(always)]
    pub fn sure(&self, level: usize, index: [isize; 3]) -> Option<&Neighbourhood> {
        Some(self.sure[level - 2].at(index)?.1)
    }
}

/// A set of cells as bit rows along x; the cell at index c is bit c + `before`.
struct Cells<'a> {
    dims: [usize; 3],
    before: usize,
    words: Cow<'a, [u64]>,
}

impl Cells<'_> {
    fn those(dims: [usize; 3], hold: impl Fn([usize; 3]) -> bool + Sync) -> Self {
        let [nx, ny, nz] = dims;
        let mut words = vec![0; nx.div_ceil(64) * ny * nz];
        words.par_chunks_mut(nx.div_ceil(64)).enumerate().for_each(|(row, words)| {
            let held = (0..nx).filter(|&i| hold([i, row % ny, row / ny]));
            held.for_each(|i| words[i / 64] |= 1 << (i % 64));
        });
        Cells { dims, before: 0, words: words.into() }
    }

    /// 64 bits along x of 8 × 8 rows from a corner on, row 8·z + y.
    fn rows_around(&self, corner: [isize; 3], rows: &mut [u64; 64]) {
        let [nx, ny, nz] = self.dims;
        let words = nx.div_ceil(64);
        let index = |first: isize, step: usize, n: usize| {
            first.checked_add_unsigned(step)?.try_into().ok().filter(|&i: &usize| i < n)
        };
        for (at, row) in rows.iter_mut().enumerate() {
            *row = match (index(corner[1], at % 8, ny), index(corner[2], at / 8, nz)) {
                (Some(j), Some(k)) => bits_from(&self.words[(k * ny + j) * words..][..words], corner[0]),
                _ => 0,
            };
        }
    }
}

/// The neighbourhood of eight cells along x from one of them on.
fn bytes_of(rows: &[u64; 64], shift: usize) -> Neighbourhood {
    let mut cells = [0; 8];
    for (layer, rows) in cells.iter_mut().zip(rows.chunks_exact(8)) {
        *layer = rows.iter().rev().fold(0, |layer, row| layer << 8 | (row >> shift & 0xFF));
    }
    cells
}

/// 64 bits of a row from one of them on; what lies outside is 0.
pub(super) fn bits_from(row: &[u64], first: isize) -> u64 {
    let word = |w: isize| if w >= 0 { row.get(w as usize).copied().unwrap_or(0) } else { 0 };
    let (w, bit) = (first.div_euclid(64), first.rem_euclid(64));
    if bit == 0 { word(w) } else { word(w) >> bit | word(w + 1) << (64 - bit) }
}

/// The nodes of one level of the set that moves: bit 16·z + 4·y + x for each cell of the level below.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    pub dims: [usize; 3],
    /// Cells that hold any of the set.
    any: Vec<u64>,
    /// Cells that lie in the set.
    full: Vec<u64>,
}

impl Nodes {
    /// The nodes of a set, by level from 1.
    pub fn all(set: &Indicator) -> Vec<Nodes> {
        let lowest = |node: [usize; 3]| {
            let mut word = 0;
            let [_, ny, nz] = set.grid().dims();
            for (z, y) in (0..4).flat_map(|z| (0..4).map(move |y| (z, y))) {
                let (j, k) = (4 * node[1] + y, 4 * node[2] + z);
                if j < ny && k < nz {
                    word |= (bits_from(set.row(j, k), 4 * node[0] as isize) & 0xF) << (16 * z + 4 * y);
                }
            }
            [word, 0]
        };
        let mut levels = vec![Nodes::new(set.grid().dims(), lowest)];
        for level in 1..LEVELS {
            let below = &levels[level - 1];
            let of = |node: [usize; 3]| {
                let cells = (0..64).map(|bit| [0, 1, 2].map(|a| 4 * node[a] + (bit >> (2 * a) & 3)));
                cells.enumerate().fold([0u64; 2], |words, (bit, cell)| {
                    let cell = cell.map(|c| c as u32);
                    let whole = if level == 1 { below.any(cell) } else { below.full(cell) };
                    [words[0] | u64::from(below.any(cell) != 0) << bit, words[1] | u64::from(whole == !0) << bit]
                })
            };
            let next = Nodes::new(below.dims, of);
            levels.push(next);
        }
        levels
    }

    fn new(cells: [usize; 3], of: impl Fn([usize; 3]) -> [u64; 2]) -> Self {
        let dims = cells.map(|n| n.div_ceil(4));
        let count = dims.iter().product();
        let (mut any, mut full) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for at in 0..count {
            let [some, whole] = of([at % dims[0], at / dims[0] % dims[1], at / (dims[0] * dims[1])]);
            any.push(some);
            full.push(whole);
        }
        Nodes { dims, any, full }
    }

    #[inline(always)]
    fn offset(&self, node: [u32; 3]) -> Option<usize> {
        let [i, j, k] = node.map(|n| n as usize);
        (i < self.dims[0] && j < self.dims[1] && k < self.dims[2]).then(|| (k * self.dims[1] + j) * self.dims[0] + i)
    }

    /// Cells of a node that hold any of the set.
    #[inline(always)]
    pub fn any(&self, node: [u32; 3]) -> u64 {
        self.offset(node).map_or(0, |at| self.any[at])
    }

    /// Cells of a node that lie in the set; levels from 2.
    #[inline(always)]
    pub fn full(&self, node: [u32; 3]) -> u64 {
        self.offset(node).map_or(0, |at| self.full[at])
    }
}

/// How many nodes of 4³ samples hold some of a set and not all: the measure of its boundary that the cost of a descent grows with.
pub fn boundary_nodes(set: &Indicator) -> usize {
    let ([_, ny, nz], words) = (set.grid().dims(), set.words_per_row());
    let of_row = |at: usize| -> usize {
        let (j, k) = (4 * (at % ny.div_ceil(4)), 4 * (at / ny.div_ceil(4)));
        let whole = j + 4 <= ny && k + 4 <= nz;
        let rows = || (k..nz.min(k + 4)).flat_map(|k| (j..ny.min(j + 4)).map(move |j| set.row(j, k)));
        let in_word = |w: usize| {
            let (any, all) = rows().fold((0, !0), |(any, all), row| (any | row[w], all & row[w]));
            let fours =
                |any: u64, all: u64| (any | any >> 1 | any >> 2 | any >> 3, all & all >> 1 & all >> 2 & all >> 3);
            let (any, all) = fours(any, if whole { all } else { 0 });
            (any & !all & 0x1111_1111_1111_1111).count_ones() as usize
        };
        (0..words).map(in_word).sum()
    };
    (0..ny.div_ceil(4) * nz.div_ceil(4)).into_par_iter().map(of_row).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::units::Length;

    #[test]
    fn boundary_nodes_are_those_that_hold_some_and_not_all() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [70, 9, 8]).unwrap();
        let set = Indicator::from_predicate(grid, |at| {
            let [i, j, k] = grid.index(at);
            (3..67).contains(&i) && j < 8 && k < 8
        });
        // Four columns of nodes cut at each end, full ones between.
        assert_eq!(boundary_nodes(&set), 2 * 4);
        // Without it: those, the ones that the grid ends in beyond them, and all of the last row.
        assert_eq!(boundary_nodes(&set.complement()), 3 * 4 + 2 * 18);
        assert_eq!(boundary_nodes(&Indicator::empty(grid)), 0);
    }
}
