//! What adding samples to a set changes: pieces joined, tunnels closed or opened, voids enclosed or filled, each at its place.

use super::components::{Adjacency, Components, components};
use super::euler::euler_characteristic;
use super::thinning::Thinned;
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::geometry::DisjointSets;
use std::collections::BTreeMap;

/// One place where a larger set differs in kind from a smaller one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// A sample of the place, as a storage offset.
    pub at: usize,
    /// First and last index along each axis.
    pub extent: [[usize; 3]; 2],
    /// What is left of the added samples here when all that change nothing are taken away: a curve between pieces, a
    /// membrane across a tunnel, a whole void.
    pub samples: u64,
    /// Change of the Betti numbers from the smaller to the larger set.
    pub pieces: i64,
    pub tunnels: i64,
    pub voids: i64,
    /// First samples of the pieces of the smaller set that meet here.
    pub meets: Vec<usize>,
}

/// The changes from a set to a larger one, in storage order; their sums are the differences of the Betti numbers.
///
/// Added samples that are simple (taking one away changes no Betti number) are taken away from the outside in, until none
/// is left; what stays has the topology of the larger set. Each connected remnant is one place, and the change it makes is
/// counted: χ from the cells it adds, pieces and voids by union-find as the remnants are put in place one after another,
/// tunnels as the rest.
///
/// # Errors
/// [`Error::Operand`] if the first set is not part of the second, or for [`Adjacency::Edge`].
///
/// # Cost
/// A look at its neighbourhood for each added sample and each time one of its neighbours is taken away, some 50 ns together; three
/// labellings if something is left.
///
/// # Limits
/// Where two changes touch they are one place with their sum.
///
/// # Source
/// Simple points: G. Bertrand, G. Malandain, A new characterization of three-dimensional simple points, 1994.
///
/// ```
/// use amcheck::{field::Indicator, grid::Grid, topology::{Adjacency, changes}, units::Length};
/// let grid = Grid::new([0.0; 3], Length::mm(1.0), [7, 1, 1])?;
/// let two = Indicator::from_predicate(grid, |at| at < 2 || at > 4);
/// let one = Indicator::from_predicate(grid, |_| true);
/// let found = changes(&two, &one, Adjacency::Face)?;
/// assert_eq!((found.len(), found[0].pieces, found[0].meets.as_slice()), (1, -1, [0, 5].as_slice()));
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn changes(small: &Indicator, large: &Indicator, adjacency: Adjacency) -> Result<Vec<Change>> {
    Comparisons::default().changes(small, large, adjacency)
}

/// Pairs of sets on one grid that are compared one after another: what one shares with the one before is not thinned again.
#[derive(Debug, Default)]
pub struct Comparisons {
    last: Option<Thinned>,
}

impl Comparisons {
    /// As [`changes`], and the same whatever was compared before.
    ///
    /// # Errors
    /// As there.
    ///
    /// # Cost
    /// That of the connected parts of the added samples about which this pair and the one before are not alike, and a labelling of them.
    pub fn changes(&mut self, small: &Indicator, large: &Indicator, adjacency: Adjacency) -> Result<Vec<Change>> {
        let bad = |problem: &str| Error::Operand {
            operation: "changes",
            problem: problem.into(),
            remedy: "give a set and a larger one on its grid, and adjacency by faces or corners".into(),
        };
        let Some(dual) = adjacency.dual() else { return Err(bad("adjacency by edges has no dual")) };
        if !small.is_subset(large)? {
            return Err(bad("the first set is not part of the second"));
        }
        // One sample of outside all around, so that nothing is special at the border of the grid.
        let padded = |set: &Indicator| set.window([-1; 3], set.grid().dims().map(|n| n + 2));
        let (inner, outer) = (padded(small)?, padded(large)?);
        let thinned = match &self.last {
            Some(last) => last.again(inner, outer, adjacency)?,
            None => Thinned::of(inner, outer, adjacency)?,
        };
        let Thinned { small: inner, left, .. } = self.last.insert(thinned);
        if left.is_empty() {
            return Ok(Vec::new());
        }
        let places = components(left, Adjacency::Corner);
        let mut traced = Trace::new(inner, left, &places, adjacency, dual)?;
        let mut found = traced.changes()?;
        let grid = small.grid();
        for change in &mut found {
            let own = |p: [usize; 3]| p.map(|c| c - 1);
            change.at = grid.offset(own(inner.grid().index(change.at)));
            change.extent = change.extent.map(own);
            change.meets.iter_mut().for_each(|at| *at = grid.offset(own(inner.grid().index(*at))));
        }
        Ok(found)
    }
}

/// Remnants being put in place one after another.
struct Trace<'a> {
    small: &'a Indicator,
    left: &'a Indicator,
    places: &'a Components,
    adjacency: Adjacency,
    dual: Adjacency,
    pieces: Components,
    /// Components of the complement once all remnants are in place.
    holes: Components,
}

impl<'a> Trace<'a> {
    fn new(
        small: &'a Indicator,
        left: &'a Indicator,
        places: &'a Components,
        adjacency: Adjacency,
        dual: Adjacency,
    ) -> Result<Self> {
        let holes = components(&small.union(left)?.complement(), dual);
        Ok(Trace { small, left, places, adjacency, dual, pieces: components(small, adjacency), holes })
    }

    fn changes(&mut self) -> Result<Vec<Change>> {
        let mut samples: Vec<Vec<usize>> = vec![Vec::new(); self.places.count()];
        let grid = *self.small.grid();
        for at in self.left.iter() {
            if let Some(place) = self.places.of(grid.index(at)) {
                samples[place as usize].push(at);
            }
        }
        let boxes = self.places.boxes();
        let first = self.pieces.first_samples();
        let mut pieces = Sets::new(vec![false; self.pieces.count()]);
        let mut found: Vec<Change> = Vec::with_capacity(samples.len());
        for (own, extent) in samples.iter().zip(&boxes) {
            let (change, meets) = pieces.add(own, &grid, self.adjacency, |p| self.pieces.of(p));
            found.push(Change {
                at: own[own.len() / 2],
                extent: *extent,
                samples: own.len() as u64,
                pieces: change,
                tunnels: -self.characteristic(own, extent)?,
                voids: 0,
                meets: meets.into_iter().map(|l| grid.offset(first[l as usize])).collect(),
            });
        }
        // Voids the other way round: the last remnant is the first to be given back to the outside.
        let mut holes = Sets::new(self.holes.at_border());
        for (own, change) in samples.iter().zip(&mut found).rev() {
            let (given, _) = holes.add(own, &grid, self.dual, |p| self.holes.of(p));
            change.voids = -given;
        }
        for change in &mut found {
            change.tunnels += change.pieces + change.voids;
        }
        found.retain(|c| (c.pieces, c.tunnels, c.voids) != (0, 0, 0));
        Ok(found)
    }

    /// What the samples of a place add to the Euler characteristic: only cells within its box and one more are concerned.
    fn characteristic(&self, own: &[usize], [lo, hi]: &[[usize; 3]; 2]) -> Result<i64> {
        let first = lo.map(|c| c as isize - 1);
        let dims = [0, 1, 2].map(|a| hi[a] - lo[a] + 3);
        let before = self.small.window(first, dims)?;
        let mut after = before.clone();
        for &at in own {
            let p = self.small.grid().index(at);
            after.set([0, 1, 2].map(|a| (p[a] as isize - first[a]) as usize), true);
        }
        Ok(euler_characteristic(&after, self.adjacency)? - euler_characteristic(&before, self.adjacency)?)
    }
}

/// Components that grow together; those marked (that reach the border) are not counted.
struct Sets {
    forest: DisjointSets,
    marked: Vec<bool>,
    /// The sets of samples that have been added.
    added: BTreeMap<usize, u32>,
}

impl Sets {
    fn new(marked: Vec<bool>) -> Self {
        Sets { forest: DisjointSets::new(marked.len()), marked, added: BTreeMap::new() }
    }

    /// Adds samples to the sets; the change of the number of unmarked sets, and the old sets that were met.
    fn add(
        &mut self,
        samples: &[usize],
        grid: &crate::grid::Grid,
        adjacency: Adjacency,
        of: impl Fn([usize; 3]) -> Option<u32>,
    ) -> (i64, Vec<u32>) {
        let mut counted = 0i64;
        let mut meets = Vec::new();
        for &at in samples {
            let set = self.marked.len() as u32;
            self.forest.grow();
            self.marked.push(false);
            self.added.insert(at, set);
            counted += 1;
            let p = grid.index(at);
            for n in (0..27usize).filter(|&n| n != 13) {
                let d = [n % 3, n / 3 % 3, n / 9];
                if adjacency == Adjacency::Face && d.iter().filter(|c| **c != 1).count() > 1 {
                    continue;
                }
                let q = [0, 1, 2].map(|a| p[a] + d[a] - 1);
                let old = of(q);
                let Some(other) = old.or_else(|| self.added.get(&grid.offset(q)).copied()) else { continue };
                meets.extend(old);
                let (a, b) = (self.forest.root(set), self.forest.root(other));
                if a != b {
                    let (x, y) = (self.marked[a as usize], self.marked[b as usize]);
                    counted -= i64::from(!(x && y));
                    let root = self.forest.join(a, b);
                    self.marked[root as usize] = x || y;
                }
            }
        }
        meets.sort_unstable();
        meets.dedup();
        (counted, meets)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::topology::{Betti, betti};
    use crate::units::Length;

    fn sums(found: &[Change]) -> [i64; 3] {
        found.iter().fold([0; 3], |s, c| [s[0] + c.pieces, s[1] + c.tunnels, s[2] + c.voids])
    }

    fn numbers(b: Betti) -> [i64; 3] {
        [b.pieces, b.tunnels, b.voids].map(|n| n as i64)
    }

    #[test]
    fn changes_add_up_to_the_differences_of_the_betti_numbers() {
        let mut state = 2u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % n
        };
        for dims in [[3, 3, 3], [6, 5, 4], [66, 3, 3], [9, 9, 9]] {
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
            for round in 0..40 {
                let (few, many) = (round % 5 * 20, 10 + round % 7 * 15);
                let bits: Vec<(bool, bool)> =
                    (0..grid.samples()).map(|_| (below(100) < few, below(100) < many)).collect();
                let small = Indicator::from_predicate(grid, |at| bits[at].0);
                let large = Indicator::from_predicate(grid, |at| bits[at].0 || bits[at].1);
                for adjacency in [Adjacency::Face, Adjacency::Corner] {
                    let found = changes(&small, &large, adjacency).unwrap();
                    let pad = |s: &Indicator| s.window([-1; 3], dims.map(|n| n + 2)).unwrap();
                    let before = numbers(betti(&pad(&small), adjacency).unwrap());
                    let after = numbers(betti(&pad(&large), adjacency).unwrap());
                    assert_eq!(sums(&found), [0, 1, 2].map(|i| after[i] - before[i]), "{dims:?} {round} {adjacency:?}");
                }
            }
        }
    }

    fn block(p: [usize; 3], lo: [usize; 3], hi: [usize; 3]) -> bool {
        (0..3).all(|a| (lo[a]..hi[a]).contains(&p[a]))
    }

    #[test]
    fn each_change_stands_where_it_happens() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [30, 12, 12]).unwrap();
        let set = |f: &(dyn Fn([usize; 3]) -> bool + Sync)| Indicator::from_predicate(grid, |at| f(grid.index(at)));
        // A plate with a hole, a block with a room, and a block apart.
        let plate = |p| block(p, [1, 1, 1], [9, 11, 3]);
        let room = |p| block(p, [12, 1, 1], [20, 11, 11]) && !block(p, [14, 4, 4], [18, 8, 8]);
        let apart = |p| block(p, [22, 1, 1], [29, 11, 4]);
        let before = set(&|p| (plate(p) && !block(p, [4, 4, 0], [7, 7, 9])) || room(p) || apart(p));
        let after =
            set(&|p| plate(p) || block(p, [12, 1, 1], [20, 11, 11]) || apart(p) || block(p, [20, 3, 1], [22, 6, 3]));
        let found = changes(&before, &after, Adjacency::Face).unwrap();
        let kinds: Vec<[i64; 3]> = found.iter().map(|c| [c.pieces, c.tunnels, c.voids]).collect();
        assert_eq!(kinds.len(), 3, "{found:?}");
        let of = |kind: [i64; 3]| found.iter().find(|c| [c.pieces, c.tunnels, c.voids] == kind).expect("the change");
        let hole = of([0, -1, 0]);
        assert!(hole.extent[0][0] >= 4 && hole.extent[1][0] < 7 && hole.samples == 9);
        assert_eq!(of([0, 0, -1]).samples, 64);
        let bridge = of([-1, 0, 0]);
        assert!(bridge.extent[0][0] >= 20 && bridge.extent[1][0] < 22 && bridge.meets.len() == 2, "{bridge:?}");
        // A coat changes nothing.
        let coat = set(&|p| block(p, [0, 0, 0], [10, 12, 4]) && !block(p, [5, 5, 0], [6, 6, 9]) || room(p) || apart(p));
        assert!(changes(&before, &before.union(&coat).unwrap(), Adjacency::Face).unwrap().is_empty());
        assert!(changes(&after, &before, Adjacency::Face).is_err());
        assert!(changes(&before, &after, Adjacency::Edge).is_err());
    }
}
