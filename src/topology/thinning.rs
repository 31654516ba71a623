//! What is left of added samples once all that change no topology are taken away.

use super::block::Block;
use super::components::{Adjacency, components};
use crate::error::Result;
use crate::field::Indicator;
use std::collections::VecDeque;

/// Places in the table of neighbourhoods, as a power of two: 32 KiB.
const KNOWN: u32 = 13;

/// The added samples that cannot be taken away one by one without a change: from the outside in, layer by layer, so that what stays lies
/// in the middle.
///
/// Neither set may have a sample at the border of the grid.
///
/// # Errors
/// None for sets on one grid.
///
/// # Cost
/// O(samples/64), and for each added sample and each time one of its neighbours is taken away one look at its neighbourhood: nine words of
/// a set, whose rows all lie alike, and a table of neighbourhoods met before.
pub(super) fn thinned(small: &Indicator, large: &Indicator, adjacency: Adjacency) -> Result<Indicator> {
    let (mut large, mut added) = (large.clone(), large.difference(small)?);
    let around = Around::of(&added);
    let mut simple = Simple::new(adjacency);
    let mut queue: VecDeque<usize> = around.bordering(&added, &large).collect();
    let mut queued = Indicator::empty(*small.grid());
    let [set, left, queued] = [&mut large, &mut added, &mut queued].map(Indicator::words_mut);
    queue.iter().for_each(|&at| put(queued, at));
    while let Some(at) = queue.pop_front() {
        take(queued, at);
        if !simple.holds(around.block(set, at)) {
            continue;
        }
        take(set, at);
        take(left, at);
        let mut near = around.block(left, at) & !around.block(queued, at);
        while near != 0 {
            let next = around.neighbour(at, near.trailing_zeros() as usize);
            near &= near - 1;
            put(queued, next);
            queue.push_back(next);
        }
    }
    Ok(added)
}

/// A pair of sets, and what stays of the samples that the larger one adds.
#[derive(Debug)]
pub(super) struct Thinned {
    pub small: Indicator,
    large: Indicator,
    adjacency: Adjacency,
    pub left: Indicator,
}

impl Thinned {
    /// As [`thinned`].
    pub fn of(small: Indicator, large: Indicator, adjacency: Adjacency) -> Result<Self> {
        let left = thinned(&small, &large, adjacency)?;
        Ok(Thinned { small, large, adjacency, left })
    }

    /// The same of another pair, from what is known of this one.
    ///
    /// What is taken away hangs on the neighbourhoods of samples that touch one another: of a connected part of the added samples about which
    /// the pairs are alike the same stays, in whatever order the parts are taken.
    ///
    /// # Errors
    /// As [`thinned`].
    ///
    /// # Cost
    /// Some walks over the words, a labelling of the added samples, and that of [`thinned`] for the parts that differ.
    pub fn again(&self, small: Indicator, large: Indicator, adjacency: Adjacency) -> Result<Self> {
        if self.adjacency != adjacency || self.small.grid() != small.grid() {
            return Thinned::of(small, large, adjacency);
        }
        let mut alike = Indicator::empty(*small.grid()).complement();
        for (before, after) in [(&self.small, &small), (&self.large, &large)] {
            let pairs = before.words().iter().zip(after.words());
            alike.words_mut().iter_mut().zip(pairs).for_each(|(alike, (a, b))| *alike &= !(a ^ b));
        }
        let added = large.difference(&small)?;
        let around = Around::of(&added);
        let mut differing = around.bordering(&added, &alike).peekable();
        let left = if differing.peek().is_none() {
            self.left.intersection(&added)?
        } else {
            let parts = components(&added, Adjacency::Corner);
            let mut differs = vec![false; parts.count()];
            for at in differing {
                let part = parts.of(around.index(at)).and_then(|part| differs.get_mut(part as usize));
                part.into_iter().for_each(|differs| *differs = true);
            }
            let fresh = parts.select(|part| differs.get(part as usize) == Some(&true));
            let known = self.left.intersection(&added.difference(&fresh)?)?;
            thinned(&large.difference(&fresh)?, &large, adjacency)?.union(&known)?
        };
        Ok(Thinned { small, large, adjacency, left })
    }
}

#[inline]
fn put(words: &mut [u64], at: usize) {
    words[at / 64] |= 1 << (at % 64);
}

#[inline]
fn take(words: &mut [u64], at: usize) {
    words[at / 64] &= !(1 << (at % 64));
}

/// How the neighbours of a sample lie in the words of a grid, where a sample is told by the place of its bit.
struct Around {
    /// Words from the first of nine rows to each.
    rows: [usize; 9],
    /// Bits from the first neighbour to a sample.
    first: usize,
    /// Rows of a layer.
    layer: usize,
}

impl Around {
    fn of(set: &Indicator) -> Self {
        let (row, plane) = (set.words_per_row(), set.words_per_row() * set.grid().dims()[1]);
        Around {
            rows: std::array::from_fn(|n| n / 3 * plane + n % 3 * row),
            first: 64 * (plane + row) + 1,
            layer: set.grid().dims()[1],
        }
    }

    /// The bits of the 26 neighbours, as in [`Block`], of a sample that is not at the border.
    #[inline]
    fn block(&self, words: &[u64], at: usize) -> u32 {
        let from = at - self.first;
        let (word, bit) = (from / 64, from % 64);
        let mut bits = 0;
        if bit < 62 {
            for (n, row) in self.rows.iter().enumerate() {
                bits |= ((words[word + row] >> bit & 7) as u32) << (3 * n);
            }
        } else {
            for (n, row) in self.rows.iter().enumerate() {
                let three = words[word + row] >> bit | words[word + row + 1] << (64 - bit);
                bits |= ((three & 7) as u32) << (3 * n);
            }
        }
        bits & !MIDDLE
    }

    /// The neighbour at a place of the block.
    #[inline]
    fn neighbour(&self, at: usize, place: usize) -> usize {
        at - self.first + 64 * self.rows[place / 3] + place % 3
    }

    /// The index of a sample.
    fn index(&self, at: usize) -> [usize; 3] {
        let row = 64 * self.rows[1];
        [at % row, at / row % self.layer, at / row / self.layer]
    }

    /// The samples of a set, in storage order, that have a neighbour outside another one that holds them.
    fn bordering<'a>(&'a self, of: &'a Indicator, within: &'a Indicator) -> impl Iterator<Item = usize> + 'a {
        let words = within.words();
        let middle = self.rows[4];
        let bare = move |(word, &bits): (usize, &u64)| {
            let mut left = bits;
            if bits != 0 {
                let all = self.rows.iter().fold(!0, |all, row| {
                    // A sample at the border has neighbours in no row beyond, and none of these is asked for.
                    let at = |w: usize| (w + row).checked_sub(middle).and_then(|w| words.get(w)).copied().unwrap_or(0);
                    let (before, here, behind) = (word.checked_sub(1).map_or(0, at), at(word), at(word + 1));
                    all & here & (here << 1 | before >> 63) & (here >> 1 | behind << 63)
                });
                left &= !all;
            }
            (word, left)
        };
        of.words().iter().enumerate().map(bare).flat_map(|(word, mut left)| {
            std::iter::from_fn(move || {
                let bit = (left != 0).then(|| left.trailing_zeros() as usize)?;
                left &= left - 1;
                Some(64 * word + bit)
            })
        })
    }
}

/// The samples of a block that share a face with the middle, and those that share a face or an edge.
const FACES: u32 = 1 << 4 | 1 << 10 | 1 << 12 | 1 << 14 | 1 << 16 | 1 << 22;
const EDGES: u32 = FACES
    | 1 << 1
    | 1 << 3
    | 1 << 5
    | 1 << 7
    | 1 << 9
    | 1 << 11
    | 1 << 15
    | 1 << 17
    | 1 << 19
    | 1 << 21
    | 1 << 23
    | 1 << 25;
const MIDDLE: u32 = 1 << 13;
const ALL: u32 = (1 << 27) - 1;

/// Which neighbourhoods are those of simple samples; surfaces on a lattice have few kinds of them.
struct Simple {
    adjacency: Adjacency,
    /// Neighbourhoods met before, the last at each place, with the answer in the lowest bit.
    known: Vec<u32>,
}

impl Simple {
    fn new(adjacency: Adjacency) -> Self {
        Simple { adjacency, known: vec![!0; 1 << KNOWN] }
    }

    /// Whether a sample with such neighbours can be taken away without changing pieces, tunnels or voids.
    #[inline]
    fn holds(&mut self, inside: u32) -> bool {
        let place = inside.wrapping_mul(0x9e37_79b1) >> (32 - KNOWN);
        let known = &mut self.known[place as usize];
        if *known >> 1 != inside {
            *known = inside << 1 | u32::from(is_simple(inside, self.adjacency));
        }
        *known & 1 == 1
    }
}

fn is_simple(inside: u32, adjacency: Adjacency) -> bool {
    let outside = !inside & ALL & !MIDDLE;
    match adjacency {
        Adjacency::Corner => is_one_cluster(inside) && is_one_by_faces(outside),
        _ => is_one_by_faces(inside) && is_one_cluster(outside),
    }
}

/// Whether the samples are one cluster by corners, and not none.
fn is_one_cluster(bits: u32) -> bool {
    Block { bits }.next_cluster().is_some_and(|(_, rest)| rest.bits == 0)
}

/// Whether those that share a face with the middle are joined by faces among those that share a face or an edge with it.
fn is_one_by_faces(bits: u32) -> bool {
    const NOT_LAST: [u32; 3] = [0o333333333, 0o077077077, 0o000777777];
    let bits = bits & EDGES;
    let seeds = bits & FACES;
    if seeds == 0 {
        return false;
    }
    let mut cluster = seeds & seeds.wrapping_neg();
    loop {
        let mut grown = cluster;
        for (last, step) in NOT_LAST.into_iter().zip([1, 3, 9]) {
            grown |= (cluster & last) << step | (cluster >> step) & last;
        }
        let grown = grown & bits;
        if grown == cluster {
            return seeds & !cluster == 0;
        }
        cluster = grown;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::random::Lcg;
    use crate::units::Length;

    /// The same, sample by sample.
    fn plainly(small: &Indicator, large: &Indicator, adjacency: Adjacency) -> Indicator {
        let grid = *small.grid();
        let (mut set, mut added) = (large.clone(), large.difference(small).unwrap());
        let neighbours = |p: [usize; 3]| {
            (0..27).filter(|n| *n != 13).map(move |n| [p[0] + n % 3 - 1, p[1] + n / 3 % 3 - 1, p[2] + n / 9 - 1])
        };
        let is_inner = |set: &Indicator, p: [usize; 3]| neighbours(p).all(|q| set.contains(q));
        let mut queue: VecDeque<[usize; 3]> =
            added.iter().map(|at| grid.index(at)).filter(|p| !is_inner(&set, *p)).collect();
        while let Some(p) = queue.pop_front() {
            if !is_simple(Block::about(&set, p).bits, adjacency) {
                continue;
            }
            set.set(p, false);
            added.set(p, false);
            for q in neighbours(p).filter(|q| added.contains(*q)) {
                if !queue.contains(&q) {
                    queue.push_back(q);
                }
            }
        }
        added
    }

    #[test]
    fn the_same_stays_as_sample_by_sample() {
        let mut random = Lcg(7);
        let mut below = |n: u64| random.below(n);
        for dims in [[3, 3, 3], [64, 5, 4], [67, 4, 4], [130, 3, 5], [12, 11, 10]] {
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
            for round in 0..30 {
                let (few, many) = ([0, 3, 20, 60, 90][round % 5], [100, 98, 80, 40, 10, 3][round % 6]);
                let is_inner = |at: usize| (0..3).all(|a| (1..dims[a] - 1).contains(&grid.index(at)[a]));
                let bits: Vec<(bool, bool)> = (0..grid.samples())
                    .map(|at| (is_inner(at) && below(100) < few, is_inner(at) && below(100) < many))
                    .collect();
                let small = Indicator::from_predicate(grid, |at| bits[at].0);
                let large = Indicator::from_predicate(grid, |at| bits[at].0 || bits[at].1);
                for adjacency in [Adjacency::Face, Adjacency::Corner] {
                    let want = plainly(&small, &large, adjacency);
                    assert_eq!(thinned(&small, &large, adjacency).unwrap(), want, "{dims:?} {round} {adjacency:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_known_of_another_pair_changes_nothing() {
        let mut random = Lcg(11);
        let mut below = |n: u64| random.below(n);
        for dims in [[67, 5, 4], [130, 3, 5], [12, 11, 10]] {
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
            for round in 0..20 {
                let (few, many) = ([3, 20, 60][round % 3], [90, 40, 10, 3][round % 4]);
                let mut set = |percent| {
                    let is_inner = |at: usize| (0..3).all(|a| (1..dims[a] - 1).contains(&grid.index(at)[a]));
                    let bits: Vec<bool> = (0..grid.samples()).map(|at| is_inner(at) && below(100) < percent).collect();
                    Indicator::from_predicate(grid, |at| bits[at])
                };
                let mut known: Option<Thinned> = None;
                let (mut small, mut more) = (set(few), set(many));
                for share in [0, 0, 1, 3, 100] {
                    let (a, b) = (set(share), set(share));
                    small = small.union(&a).unwrap().difference(&b).unwrap();
                    more = more.union(&set(share)).unwrap().difference(&a).unwrap();
                    for adjacency in [Adjacency::Face, Adjacency::Corner] {
                        let large = small.union(&more).unwrap();
                        let want = thinned(&small, &large, adjacency).unwrap();
                        let (own, of) = (small.clone(), Thinned::of);
                        let found = known.as_ref().map_or_else(
                            || of(own.clone(), large.clone(), adjacency),
                            |known| known.again(own.clone(), large.clone(), adjacency),
                        );
                        let found = found.unwrap();
                        assert_eq!(found.left, want, "{dims:?} {round} {share} {adjacency:?}");
                        if adjacency == Adjacency::Face {
                            known = Some(found);
                        }
                    }
                }
            }
        }
    }
}
