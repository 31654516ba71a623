//! Where a moved set meets another, from coarse to fine: only nodes that may meet are looked into, only translations that are
//! undecided are refined.

use super::cells::{OF_PAIR, Swept, all_met, gathered, set_bits, sweep};
use super::direct::sum_grid;
use super::tree::{Ground, LEVELS, Neighbourhood, Nodes, SIDE, bits_from};
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::grid::Grid;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// A set A made ready to be met by any number of others.
#[derive(Debug, Clone)]
pub struct Descent {
    grid: Grid,
    ground: Ground,
}

/// Translations along a side of the blocks that are decided independently: the width of a node of the highest level.
const BLOCK: usize = 64;

impl Descent {
    /// The set made ready.
    ///
    /// # Cost
    /// Five word reads for every 4³ samples; 64 bytes for every 4³ samples that the boundary of the set is near.
    pub fn new(set: &Indicator) -> Self {
        Descent { grid: *set.grid(), ground: Ground::new(set) }
    }

    /// A ⊕ (−B) = { t : (B + t) ∩ A ≠ ∅ }: the translations at which B meets A, nothing cut off.
    ///
    /// Translations are decided in cells of 64, 16 and 4 samples: none of a cell meets if no node of B that holds anything
    /// comes over a node of A that does; all do if a node of B lies in B and passes over a sample of A in all of them. The rest
    /// are decided sample by sample.
    ///
    /// # Errors
    /// [`crate::Error::Operand`] for different spacings.
    ///
    /// # Cost
    /// For every 4³ translations about the boundary of the result the pairs of 4³ nodes that may meet there, some hundred
    /// operations each. The result, one bit a sample, twice.
    pub fn met_by(&self, b: &Indicator) -> Result<Indicator> {
        whole(self.met(b, None, &Allowance::new(u64::MAX))?)
    }

    /// As [`Descent::met_by`] if no more than `most` moves of 4³ cells over others decide it, otherwise nothing: thin and
    /// scattered sets, which no node lies in, leave much undecided until the last level.
    ///
    /// # Errors
    /// As there.
    ///
    /// # Cost
    /// As there; two to five nanoseconds for each move, on one core.
    pub fn met_by_at_most(&self, b: &Indicator, most: u64) -> Result<Option<Indicator>> {
        self.met(b, None, &Allowance::new(most))
    }

    /// As [`Descent::met_by`], of the translations in some boxes, millimetres, or in a cell of 4³ that one of them touches;
    /// all others are left out of the set. A box may reach beyond what there is, without end too.
    ///
    /// # Errors
    /// As there, and [`Error::Operand`] for a box with a corner that is no number.
    ///
    /// # Cost
    /// As there, of these translations only.
    pub fn met_within(&self, b: &Indicator, boxes: &[[[f64; 3]; 2]]) -> Result<Indicator> {
        whole(self.met(b, Some(boxes), &Allowance::new(u64::MAX))?)
    }

    fn met(&self, b: &Indicator, boxes: Option<&[[[f64; 3]; 2]]>, allowance: &Allowance) -> Result<Option<Indicator>> {
        let [dims, reach] = [self.grid.dims(), b.grid().dims()];
        let far = [0, 1, 2].map(|a| -(b.grid().origin()[a] + b.grid().h() * (reach[a] - 1) as f64));
        let grid = sum_grid(&self.grid, &Grid::new(far, b.grid().spacing(), reach)?)?;
        let first = reach.map(|n| (1 - n as isize).div_euclid(BLOCK as isize));
        let count = [0, 1, 2].map(|a| (dims[a].div_ceil(BLOCK) as isize - first[a]) as usize);
        let nodes = Nodes::all(b);
        let zero = [0, 1, 2].map(|a| reach[a] as isize - 1 + first[a] * BLOCK as isize);
        let wanted = boxes.map(|boxes| wanted(boxes, &grid, zero, count)).transpose()?;
        let arch = Arch::new();
        let blocks: Vec<Option<Vec<u64>>> = (0..count.iter().product())
            .into_par_iter()
            .map(|at| {
                let [i, j, k] = [at % count[0], at / count[0] % count[1], at / (count[0] * count[1])];
                let mut search = Search::new(&self.ground, &nodes, allowance);
                if let Some(wanted) = &wanted {
                    search.wanted = Some((wanted, [i, j, k].map(|n| n as u32)));
                }
                let cell = [0, 1, 2].map(|a| [i, j, k][a] as isize + first[a]);
                arch.dispatch(Decision { search, cell })
            })
            .collect();
        if allowance.is_spent() {
            return Ok(None);
        }
        let mut met = Indicator::empty(grid);
        let (words, [nx, ny, _]) = (met.words_per_row(), grid.dims());
        let last = if nx.is_multiple_of(64) { !0 } else { !(!0u64 << (nx % 64)) };
        met.words_mut().par_chunks_mut(words).enumerate().for_each_init(
            || vec![0u64; count[0]],
            |row_of_blocks, (row, out)| {
                // Rows of the result begin reach − 1 translations below zero, blocks at a multiple of their width.
                let at = |a: usize, i: usize| (i as isize - zero[a]) as usize;
                let (y, z) = (at(1, row % ny), at(2, row / ny));
                let start = (z / BLOCK * count[1] + y / BLOCK) * count[0];
                for (word, block) in row_of_blocks.iter_mut().zip(&blocks[start..]) {
                    *word = block.as_ref().map_or(0, |rows| rows[z % BLOCK * BLOCK + y % BLOCK]);
                }
                for (w, word) in out.iter_mut().enumerate() {
                    *word = bits_from(row_of_blocks, (at(0, 0) + 64 * w) as isize);
                }
                out[words - 1] &= last;
            },
        );
        Ok(Some(met))
    }
}

/// How many moves all threads together may make. Whether more are needed does not depend on their order.
struct Allowance {
    most: u64,
    made: AtomicU64,
}

impl Allowance {
    fn new(most: u64) -> Self {
        Allowance { most, made: AtomicU64::new(0) }
    }

    fn spend(&self, moves: u64) {
        self.made.fetch_add(moves, Ordering::Relaxed);
    }

    fn is_spent(&self) -> bool {
        self.made.load(Ordering::Relaxed) > self.most
    }
}

fn whole(met: Option<Indicator>) -> Result<Indicator> {
    met.ok_or_else(|| Error::Internal { problem: "a descent without a limit was given up".into() })
}

/// The cells of 4³ translations that boxes touch, as the nodes of their set; `zero` is the translation, on the grid of the result,
/// at which the first of the blocks begins.
fn wanted(boxes: &[[[f64; 3]; 2]], grid: &Grid, zero: [isize; 3], blocks: [usize; 3]) -> Result<Vec<Nodes>> {
    let cells = blocks.map(|n| n * BLOCK / SIDE as usize);
    let mut set = Indicator::empty(Grid::new([0.0; 3], grid.spacing(), cells)?);
    for [low, high] in boxes {
        if low.iter().chain(high).any(|x| x.is_nan()) {
            return Err(Error::Operand {
                operation: "translations within boxes",
                problem: format!("a box from {low:?} to {high:?}"),
                remedy: "give numbers in millimetres".into(),
            });
        }
        let (low, high) = (grid.continuous_index(*low), grid.continuous_index(*high));
        let range = |a: usize| {
            let cell = |at: f64| (at as isize).saturating_sub(zero[a]).div_euclid(SIDE);
            let (first, last) = (cell((low[a] - 0.5).ceil()), cell((high[a] + 0.5).floor()));
            first.max(0) as usize..(last + 1).clamp(0, cells[a] as isize) as usize
        };
        for (k, j) in range(2).flat_map(|k| range(1).map(move |j| (k, j))) {
            range(0).for_each(|i| set.set([i, j, k], true));
        }
    }
    Ok(Nodes::all(&set))
}

/// A node of the moved set over what it may meet.
#[derive(Clone, Copy)]
struct Pair<'a> {
    node: [u32; 3],
    any: u64,
    full: u64,
    cells: &'a Neighbourhood,
}

impl Pair<'_> {
    /// The cells of a node, moved by as many cells, that come over something.
    #[inline(always)]
    fn over_something(&self, by: [u32; 3]) -> u64 {
        let (shift, z) = (8 * by[1] + by[0], by[2] as usize);
        gathered([0, 1, 2, 3].map(|layer| self.cells[z + layer] >> shift))
    }

    /// The node of the level below that a cell is.
    #[inline(always)]
    fn part(&self, part: [u32; 3]) -> [u32; 3] {
        [0, 1, 2].map(|a| SIDE as u32 * self.node[a] + part[a])
    }
}

/// The nodes of the moved set that may meet something, level by level, while a block of translations is decided.
struct Search<'a> {
    ground: &'a Ground,
    nodes: &'a [Nodes],
    /// Candidates of each level, from 2.
    candidates: [Vec<[u32; 3]>; LEVELS - 1],
    /// Those that are over something.
    pairs: [Vec<Pair<'a>>; LEVELS - 1],
    /// What is asked for, where that is not all, and which block this is.
    wanted: Option<(&'a [Nodes], [u32; 3])>,
    /// Bit rows of the block: row 64·z + y.
    out: Vec<u64>,
    allowance: &'a Allowance,
    /// Moves made and not yet told.
    moves: u64,
    swept: Swept,
}

impl<'a> Search<'a> {
    fn new(ground: &'a Ground, nodes: &'a [Nodes], allowance: &'a Allowance) -> Self {
        let (candidates, pairs) = Default::default();
        Search {
            ground,
            nodes,
            candidates,
            pairs,
            wanted: None,
            out: Vec::new(),
            allowance,
            moves: 0,
            swept: Swept::default(),
        }
    }

    /// Which of the cells of a cell of translations, of a level from 2, are asked for.
    #[inline(always)]
    fn wanted(&self, level: usize, corner: [usize; 3]) -> u64 {
        let Some((wanted, block)) = self.wanted else { return !0 };
        let width = 1 << (2 * level);
        wanted[level - 2].any([0, 1, 2].map(|a| block[a] * (BLOCK / width) as u32 + (corner[a] / width) as u32))
    }

    /// The bit rows of a block of translations; `None` if none of them meets anything.
    #[inline(always)]
    fn block(mut self, cell: [isize; 3]) -> Option<Vec<u64>> {
        if self.wanted(LEVELS, [0; 3]) == 0 {
            return None;
        }
        let top = &self.nodes[LEVELS - 1];
        let [nx, ny, nz] = top.dims;
        for at in 0..nx * ny * nz {
            let node = [at % nx, at / nx % ny, at / (nx * ny)].map(|n| n as u32);
            if top.any(node) != 0 && self.ground.any(LEVELS, over(node, cell)).is_some() {
                self.candidates[LEVELS - 2].push(node);
            }
        }
        if self.candidates[LEVELS - 2].is_empty() {
            return None;
        }
        self.out = vec![0; BLOCK * BLOCK];
        for by in set_bits(self.decide(LEVELS, cell, [0; 3])) {
            let (cell, corner) = within(LEVELS, cell, [0; 3], by);
            self.refine(LEVELS, by);
            for by in set_bits(self.decide(2, cell, corner)) {
                let (cell, corner) = within(2, cell, corner, by);
                let met = self.met_by_samples(by, cell);
                self.put(met, corner, 1);
            }
        }
        self.allowance.spend(self.moves);
        Some(self.out)
    }

    /// Marks the cells of a cell of translations, of a level from 2, at which something is met for certain, and tells those that
    /// are undecided; `corner` is its first translation within the block.
    #[inline(always)]
    fn decide(&mut self, level: usize, cell: [isize; 3], corner: [usize; 3]) -> u64 {
        self.allowance.spend(std::mem::take(&mut self.moves));
        if self.allowance.is_spent() {
            return 0;
        }
        let wanted = self.wanted(level, corner);
        let [possible, sure] = self.met_by_cells(level, cell).map(|cells| cells & wanted);
        self.put(sure, corner, width(level));
        possible & !sure
    }

    /// The translations, of one of the cells of a cell, at which any sample is met.
    #[inline(always)]
    fn met_by_samples(&mut self, by: [u32; 3], within: [isize; 3]) -> u64 {
        let mut met = [0; 4];
        self.swept.forget();
        // Full nodes first: where all translations of a cell meet, one of them often tells.
        for full in [true, false] {
            for pair in &self.pairs[0] {
                let nodes = if full { pair.full } else { pair.any & !pair.full };
                if nodes == 0 {
                    continue;
                }
                for part in set_bits(pair.over_something(by) & nodes) {
                    let node = pair.part(part);
                    self.moves += OF_PAIR;
                    let Some((number, cells)) = self.ground.samples(over(node, within)) else { continue };
                    let node = self.nodes[0].any(node);
                    if self.swept.contains(node, number) {
                        continue;
                    }
                    self.moves += sweep(node, cells, &mut met);
                    if all_met(&met) {
                        return !0;
                    }
                }
            }
        }
        gathered(met)
    }

    /// The cells of translations, of a cell, in which something may be met, and those in which something is met for certain;
    /// notes the pairs.
    #[inline(always)]
    fn met_by_cells(&mut self, level: usize, cell: [isize; 3]) -> [u64; 2] {
        let (mut possible, mut sure) = ([0; 4], [0; 4]);
        let pairs = &mut self.pairs[level - 2];
        pairs.clear();
        self.moves += OF_PAIR * self.candidates[level - 2].len() as u64;
        for &node in &self.candidates[level - 2] {
            let index = over(node, cell);
            let Some(cells) = self.ground.any(level, index) else { continue };
            let pair =
                Pair { node, any: self.nodes[level - 1].any(node), full: self.nodes[level - 1].full(node), cells };
            pairs.push(pair);
            self.moves += sweep(pair.any, cells, &mut possible);
            if let Some(cells) = self.ground.sure(level, index) {
                self.moves += sweep(pair.full, cells, &mut sure);
            }
        }
        [possible, sure].map(gathered)
    }

    /// The candidates of the level below for one of the cells of a cell.
    #[inline(always)]
    fn refine(&mut self, level: usize, by: [u32; 3]) {
        let below = &mut self.candidates[level - 3];
        below.clear();
        for pair in &self.pairs[level - 2] {
            below.extend(set_bits(pair.over_something(by) & pair.any).map(|part| pair.part(part)));
        }
    }

    /// Marks cells of translations, given as the 64 of a cell, each `width` wide.
    #[inline(always)]
    fn put(&mut self, cells: u64, corner: [usize; 3], width: usize) {
        for (layer, z) in (0..4).map(|z| (cells >> (16 * z) & 0xFFFF, z)).filter(|(layer, _)| *layer != 0) {
            for y in 0..4 {
                let four = layer >> (4 * y) & 0xF;
                let bits = (0..4).filter(|x| four >> x & 1 == 1).fold(0, |row, x| {
                    let all = if width >= 64 { !0 } else { (1u64 << width) - 1 };
                    row | all << (corner[0] + width * x)
                });
                if bits == 0 {
                    continue;
                }
                for k in 0..width {
                    let row = (corner[2] + width * z + k) * BLOCK + corner[1] + width * y;
                    self.out[row..row + width].iter_mut().for_each(|o| *o |= bits);
                }
            }
        }
    }
}

/// A block to be decided, all of it in the instructions of the machine at hand, which a closure of this size would not be.
struct Decision<'a> {
    search: Search<'a>,
    cell: [isize; 3],
}

impl NullaryFnOnce for Decision<'_> {
    type Output = Option<Vec<u64>>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.search.block(self.cell)
    }
}

/// Translations along a cell of a level below.
#[inline(always)]
fn width(level: usize) -> usize {
    1 << (2 * (level - 1))
}

/// One of the cells of a cell of translations, and its first translation within the block.
#[inline(always)]
fn within(level: usize, cell: [isize; 3], corner: [usize; 3], by: [u32; 3]) -> ([isize; 3], [usize; 3]) {
    ([0, 1, 2].map(|a| SIDE * cell[a] + by[a] as isize), [0, 1, 2].map(|a| corner[a] + width(level) * by[a] as usize))
}

/// The node of the standing set that a node of the moved one comes over first.
#[inline(always)]
fn over(node: [u32; 3], cell: [isize; 3]) -> [isize; 3] {
    [0, 1, 2].map(|a| node[a] as isize + cell[a])
}

#[cfg(test)]
mod tests {
    use super::super::direct::dilate_by_runs;
    use super::*;
    use crate::units::Length;

    fn sparse(origin: [f64; 3], dims: [usize; 3], seed: u64, one_in: u64) -> Indicator {
        let grid = Grid::new(origin, Length::mm(0.5), dims).unwrap();
        let (mut state, mut set) = (seed, Indicator::empty(grid));
        for at in 0..grid.samples() {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            if (state >> 33).is_multiple_of(one_in) {
                set.set(grid.index(at), true);
            }
        }
        set
    }

    /// Boxes and holes of random sizes: solid, so that cells are full.
    fn blocks(origin: [f64; 3], dims: [usize; 3], seed: u64, count: usize) -> Indicator {
        let grid = Grid::new(origin, Length::mm(0.5), dims).unwrap();
        let mut state = seed;
        let mut random = |n: usize| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as usize % n.max(1)
        };
        let mut set = Indicator::empty(grid);
        for n in 0..count {
            let lo = dims.map(&mut random);
            let hi = [0, 1, 2].map(|a| lo[a] + random(dims[a]));
            let block = Indicator::from_predicate(grid, |at| {
                let index = grid.index(at);
                (0..3).all(|a| (lo[a]..hi[a]).contains(&index[a]))
            });
            set = if n % 3 == 2 { set.difference(&block).unwrap() } else { set.union(&block).unwrap() };
        }
        set
    }

    #[test]
    fn what_is_met_is_the_dilation_by_the_reflected_set_bit_for_bit() {
        let sizes = [[1, 1, 1], [5, 4, 3], [64, 9, 2], [65, 17, 30], [130, 70, 66], [3, 90, 7]];
        let (mut seed, mut full) = (1, 0);
        for a_dims in sizes {
            for b_dims in sizes.into_iter().filter(|b| b.iter().product::<usize>() * a_dims[0] < 20_000_000) {
                seed += 1;
                let pairs = [
                    (sparse([3.0, -1.0, 2.0], a_dims, seed, 40), sparse([-0.5, 4.0, 1.5], b_dims, seed + 99, 60)),
                    (blocks([3.0, -1.0, 2.0], a_dims, seed, 6), blocks([-0.5, 4.0, 1.5], b_dims, seed + 99, 5)),
                    (blocks([3.0, -1.0, 2.0], a_dims, seed, 6), sparse([-0.5, 4.0, 1.5], b_dims, seed + 99, 500)),
                ];
                for (a, b) in pairs {
                    let met = Descent::new(&a).met_by(&b).unwrap();
                    met.validate().unwrap();
                    let plain = dilate_by_runs(&a, &b.reflected()).unwrap();
                    assert!(met == plain, "{a_dims:?} by {b_dims:?}: {} {}", met.count(), plain.count());
                    full += usize::from(met.count() > 0);
                }
            }
        }
        assert!(full > 50, "{full}");
    }

    #[test]
    fn a_descent_with_too_few_moves_says_nothing() {
        let a = blocks([3.0, -1.0, 2.0], [90, 70, 66], 5, 6);
        let b = sparse([-0.5, 4.0, 1.5], [65, 40, 80], 6, 30);
        let ready = Descent::new(&a);
        let all = ready.met_by(&b).unwrap();
        assert!((0..24).any(|n| ready.met_by_at_most(&b, 1 << n).unwrap().is_none()));
        for most in [1 << 20, 1 << 22, u64::MAX] {
            assert!(ready.met_by_at_most(&b, most).unwrap().is_none_or(|met| met == all), "{most}");
        }
        assert!(ready.met_by_at_most(&b, 0).unwrap().is_none());
        let nothing = Indicator::empty(*b.grid());
        assert!(ready.met_by_at_most(&nothing, 0).unwrap().is_some_and(|met| met.is_empty()));
    }

    #[test]
    fn within_boxes_the_same_is_said_and_nothing_beyond() {
        let a = blocks([3.0, -1.0, 2.0], [90, 70, 66], 5, 6);
        let b = blocks([-0.5, 4.0, 1.5], [65, 40, 80], 6, 5);
        let ready = Descent::new(&a);
        let all = ready.met_by(&b).unwrap();
        let grid = *all.grid();
        assert!(ready.met_within(&b, &[]).unwrap().is_empty());
        let endless = [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]];
        assert_eq!(ready.met_within(&b, &[endless]).unwrap(), ready.met_by(&b).unwrap());
        let [behind, ahead] = [[[f64::NEG_INFINITY; 3]; 2], [[f64::INFINITY; 3]; 2]];
        assert!(ready.met_within(&b, &[behind, ahead]).unwrap().is_empty());
        assert!(ready.met_within(&b, &[[[f64::NAN; 3], [0.0; 3]]]).is_err());
        let ends = |index: [usize; 3], by: f64| [-by, by].map(|s| grid.position(index).map(|x| x + s));
        let middle = grid.dims().map(|n| n / 2);
        for list in [vec![ends(middle, 0.1)], vec![ends([3, 2, 1], 4.0), ends(middle, 9.3), ends([200, 9, 60], 300.0)]]
        {
            let met = ready.met_within(&b, &list).unwrap();
            assert!(met.is_subset(&all).unwrap());
            let missed = all.difference(&met).unwrap();
            for at in missed.iter() {
                let p = grid.position(grid.index(at));
                assert!(list.iter().all(|[lo, hi]| (0..3).any(|i| p[i] < lo[i] || p[i] > hi[i])), "{p:?}");
            }
            assert!(list.len() == 1 || !met.is_empty());
        }
    }

    #[test]
    fn one_point_met_by_one_point_is_where_they_coincide() {
        let at = |origin, index| {
            let mut set = Indicator::empty(Grid::new(origin, Length::mm(0.5), [7, 6, 5]).unwrap());
            set.set(index, true);
            set
        };
        let (a, b) = (at([1.0, 2.0, 3.0], [6, 0, 4]), at([0.0, 0.5, -1.0], [1, 5, 0]));
        let met = Descent::new(&a).met_by(&b).unwrap();
        assert_eq!(met.count(), 1);
        let t = met.grid().position(met.grid().index(met.iter().next().unwrap()));
        assert_eq!(t, [4.0 - 0.5, 2.0 - 3.0, 5.0 + 1.0]);
    }

    #[test]
    fn different_spacings_are_refused() {
        let coarse = Indicator::empty(Grid::new([0.0; 3], Length::mm(1.0), [2; 3]).unwrap());
        assert!(Descent::new(&sparse([0.0; 3], [2; 3], 1, 2)).met_by(&coarse).is_err());
    }
}
