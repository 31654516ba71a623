//! Connected components of sets of samples.

use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::DisjointSets;
use crate::grid::Grid;
use rayon::prelude::*;

/// Which samples count as neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Adjacency {
    /// Cubes that share a face: 6 neighbours.
    Face,
    /// Cubes that share an edge: 18 neighbours.
    Edge,
    /// Cubes that share a corner: 26 neighbours.
    Corner,
}

impl Adjacency {
    /// The adjacency of the complement that goes with this one, so that a closed digital surface separates: faces and
    /// corners belong together; edges have no partner among the three.
    pub fn dual(self) -> Option<Self> {
        match self {
            Adjacency::Face => Some(Adjacency::Corner),
            Adjacency::Corner => Some(Adjacency::Face),
            Adjacency::Edge => None,
        }
    }

    /// Rows before (j, k) in storage that hold neighbours, as (Δj, Δk, reach along x).
    fn rows_before(self) -> &'static [(isize, isize, u32)] {
        match self {
            Adjacency::Face => &[(-1, 0, 0), (0, -1, 0)],
            Adjacency::Edge => &[(-1, 0, 1), (0, -1, 1), (-1, -1, 0), (1, -1, 0)],
            Adjacency::Corner => &[(-1, 0, 1), (0, -1, 1), (-1, -1, 1), (1, -1, 1)],
        }
    }
}

/// A maximal stretch of samples along x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Run {
    pub from: u32,
    pub to: u32,
    /// Component, counted from 0.
    pub label: u32,
}

/// The connected components of a set, numbered from 0 by their first sample in storage order.
#[derive(Debug, Clone, PartialEq)]
pub struct Components {
    grid: Grid,
    count: usize,
    /// The first run of each row, and the number of runs at the end.
    rows: Vec<u32>,
    runs: Vec<Run>,
}

/// The connected components of a set of samples.
///
/// # Cost
/// O(samples/64 + runs·α): runs along x are found in parallel and joined by union-find; twelve bytes a run.
///
/// ```
/// use amcheck::{field::Indicator, grid::Grid, topology::{Adjacency, components}, units::Length};
/// let grid = Grid::new([0.0; 3], Length::mm(1.0), [2, 2, 1])?;
/// let diagonal = Indicator::from_predicate(grid, |at| at == 0 || at == 3);
/// assert_eq!(components(&diagonal, Adjacency::Face).count(), 2);
/// assert_eq!(components(&diagonal, Adjacency::Edge).count(), 1);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn components(set: &Indicator, adjacency: Adjacency) -> Components {
    let grid = *set.grid();
    let [nx, ny, nz] = grid.dims();
    let by_row: Vec<Vec<Run>> =
        (0..ny * nz).into_par_iter().map(|row| runs_of(set.row(row % ny, row / ny), nx)).collect();
    let mut rows = Vec::with_capacity(ny * nz + 1);
    let mut runs: Vec<Run> = Vec::with_capacity(by_row.iter().map(Vec::len).sum());
    for row in &by_row {
        rows.push(runs.len() as u32);
        runs.extend(row);
    }
    rows.push(runs.len() as u32);
    let mut forest = DisjointSets::new(runs.len());
    for row in 0..ny * nz {
        let (j, k) = ((row % ny) as isize, (row / ny) as isize);
        for &(dj, dk, reach) in adjacency.rows_before() {
            if j + dj < 0 || j + dj >= ny as isize || k + dk < 0 {
                continue;
            }
            let other = ((k + dk) * ny as isize + j + dj) as usize;
            let spans = |row: usize| rows[row] as usize..rows[row + 1] as usize;
            join(&mut forest, &runs, spans(other), spans(row), reach);
        }
    }
    let mut count = 0;
    for at in 0..runs.len() {
        // The root is the first of its component, so it has its number already.
        let root = forest.root(at as u32) as usize;
        runs[at].label = if root == at {
            count += 1;
            count - 1
        } else {
            runs[root].label
        };
    }
    Components { grid, count: count as usize, rows, runs }
}

/// The runs of a row; their labels are not yet known.
fn runs_of(bits: &[u64], nx: usize) -> Vec<Run> {
    let mut runs = Vec::new();
    let mut open: Option<u32> = None;
    for (w, &word) in bits.iter().enumerate() {
        let before = if open.is_some() { word << 1 | 1 } else { word << 1 };
        let mut changes = word ^ before;
        while changes != 0 {
            let at = (w * 64) as u32 + changes.trailing_zeros();
            match open.take() {
                Some(from) => runs.push(Run { from, to: at, label: 0 }),
                None => open = Some(at),
            }
            changes &= changes - 1;
        }
    }
    runs.extend(open.map(|from| Run { from, to: nx as u32, label: 0 }));
    runs
}

/// Joins the runs of two rows that come within `reach` samples of one another.
fn join(forest: &mut DisjointSets, runs: &[Run], a: std::ops::Range<usize>, b: std::ops::Range<usize>, reach: u32) {
    let (mut i, mut j) = (a.start, b.start);
    while i < a.end && j < b.end {
        let (p, q) = (runs[i], runs[j]);
        if p.from < q.to + reach && q.from < p.to + reach {
            forest.join(i as u32, j as u32);
        }
        if p.to < q.to { i += 1 } else { j += 1 }
    }
}

impl Components {
    /// Number of components.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The component of a sample, or `None` outside the set and the grid.
    pub fn of(&self, [i, j, k]: [usize; 3]) -> Option<u32> {
        let [_, ny, nz] = self.grid.dims();
        if j >= ny || k >= nz {
            return None;
        }
        let row = k * ny + j;
        let runs = &self.runs[self.rows[row] as usize..self.rows[row + 1] as usize];
        let at = runs.partition_point(|run| run.to as usize <= i);
        runs.get(at).filter(|run| run.from as usize <= i).map(|run| run.label)
    }

    /// Number of samples of each component.
    pub fn sizes(&self) -> Vec<u64> {
        let mut sizes = vec![0; self.count];
        self.runs.iter().for_each(|run| sizes[run.label as usize] += u64::from(run.to - run.from));
        sizes
    }

    /// First and last index along each axis of each component.
    pub fn boxes(&self) -> Vec<[[usize; 3]; 2]> {
        let mut boxes = vec![[[usize::MAX; 3], [0; 3]]; self.count];
        self.for_each_run(|j, k, run| {
            let [lo, hi] = &mut boxes[run.label as usize];
            let (first, last) = ([run.from as usize, j, k], [run.to as usize - 1, j, k]);
            (0..3).for_each(|a| (lo[a], hi[a]) = (lo[a].min(first[a]), hi[a].max(last[a])));
        });
        boxes
    }

    /// The first sample of each component in storage order.
    pub fn first_samples(&self) -> Vec<[usize; 3]> {
        let mut first = Vec::with_capacity(self.count);
        self.for_each_run(|j, k, run| {
            if run.label as usize == first.len() {
                first.push([run.from as usize, j, k]);
            }
        });
        first
    }

    /// Whether each component reaches the border of the grid.
    pub fn at_border(&self) -> Vec<bool> {
        let last = self.grid.dims().map(|n| n - 1);
        let touches = |[lo, hi]: &[[usize; 3]; 2]| (0..3).any(|a| lo[a] == 0 || hi[a] == last[a]);
        self.boxes().iter().map(touches).collect()
    }

    /// The samples of the components for which `wanted` holds.
    pub fn select(&self, wanted: impl Fn(u32) -> bool) -> Indicator {
        let mut set = Indicator::empty(self.grid);
        let (words, ny) = (set.words_per_row(), self.grid.dims()[1]);
        let bits = set.words_mut();
        self.for_each_run(|j, k, run| {
            if wanted(run.label) {
                let row = words * (k * ny + j);
                let (from, last) = (run.from as usize, run.to as usize - 1);
                for word in from / 64..=last / 64 {
                    let first = from.saturating_sub(64 * word);
                    let end = (last - 64 * word).min(63);
                    bits[row + word] |= !0 << first & !0 >> (63 - end);
                }
            }
        });
        set
    }

    /// Some components, each on a window of its own: its box with `margin` samples around it, cut at the grid; with the index of the
    /// window's first sample. In the order of the labels, each of which is named once.
    ///
    /// # Errors
    /// None for labels below [`Components::count`]; others are left empty at the origin.
    ///
    /// # Cost
    /// O(runs + samples of the windows / 64), where [`Components::select`] walks over all for each.
    pub fn split(&self, labels: &[usize], margin: usize) -> Result<Vec<([usize; 3], Indicator)>> {
        let (boxes, dims) = (self.boxes(), self.grid.dims());
        let mut place = vec![usize::MAX; self.count];
        let mut windows = Vec::with_capacity(labels.len());
        for (at, &label) in labels.iter().enumerate() {
            let [lo, hi] = boxes.get(label).copied().unwrap_or_default();
            let first = lo.map(|i| i.saturating_sub(margin));
            let counts = [0, 1, 2].map(|a| (hi[a] + margin + 1).min(dims[a]) - first[a]);
            let origin = [0, 1, 2].map(|a| self.grid.origin()[a] + self.grid.h() * first[a] as f64);
            windows.push((first, Indicator::empty(Grid::new(origin, self.grid.spacing(), counts)?)));
            place.get_mut(label).into_iter().for_each(|p| *p = at);
        }
        self.for_each_run(|j, k, run| {
            if let Some((first, set)) = windows.get_mut(place[run.label as usize]) {
                let [x, y, z] = *first;
                (run.from..run.to).for_each(|i| set.set([i as usize - x, j - y, k - z], true));
            }
        });
        Ok(windows)
    }

    /// The component of every sample, counted from 1; 0 outside the set.
    pub fn labels(&self) -> Field<u32> {
        let [nx, _, _] = self.grid.dims();
        let mut field = Field::constant(self.grid, 0);
        field.values_mut().par_chunks_mut(nx).enumerate().for_each(|(row, values)| {
            for run in &self.runs[self.rows[row] as usize..self.rows[row + 1] as usize] {
                values[run.from as usize..run.to as usize].fill(run.label + 1);
            }
        });
        field
    }

    /// Calls `visit(j, k, run)` for all runs in storage order.
    pub(super) fn for_each_run(&self, mut visit: impl FnMut(usize, usize, &Run)) {
        let ny = self.grid.dims()[1];
        for (row, span) in self.rows.windows(2).enumerate() {
            self.runs[span[0] as usize..span[1] as usize].iter().for_each(|run| visit(row % ny, row / ny, run));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Length;

    /// Flood fill from every sample not yet reached, in storage order.
    fn flood(set: &Indicator, adjacency: Adjacency) -> Vec<u32> {
        let grid = set.grid();
        let mut labels = vec![0; grid.samples()];
        let mut count = 0;
        for start in set.iter() {
            if labels[start] != 0 {
                continue;
            }
            count += 1;
            let mut stack = vec![start];
            labels[start] = count;
            while let Some(at) = stack.pop() {
                let p = grid.index(at).map(|c| c as isize);
                for n in 0..27 {
                    let d = [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1];
                    let steps: isize = d.iter().map(|c: &isize| c.abs()).sum();
                    let most = match adjacency {
                        Adjacency::Face => 1,
                        Adjacency::Edge => 2,
                        Adjacency::Corner => 3,
                    };
                    let q = [0, 1, 2].map(|a| (p[a] + d[a]) as usize);
                    if steps <= most && set.contains(q) && labels[grid.offset(q)] == 0 {
                        labels[grid.offset(q)] = count;
                        stack.push(grid.offset(q));
                    }
                }
            }
        }
        labels
    }

    #[test]
    fn labels_are_those_of_a_flood() {
        let mut state = 5u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % n
        };
        for dims in [[1, 1, 1], [130, 3, 2], [64, 5, 4], [9, 8, 7], [1, 20, 20]] {
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
            for percent in [0, 10, 25, 40, 70, 100] {
                let bits: Vec<bool> = (0..grid.samples()).map(|_| below(100) < percent).collect();
                let set = Indicator::from_predicate(grid, |at| bits[at]);
                for adjacency in [Adjacency::Face, Adjacency::Edge, Adjacency::Corner] {
                    let found = components(&set, adjacency);
                    let truth = flood(&set, adjacency);
                    assert_eq!(found.labels().values(), truth, "{dims:?} {percent} {adjacency:?}");
                    assert_eq!(found.sizes().iter().sum::<u64>(), set.count());
                    assert_eq!(found.select(|_| true), set);
                    let labels: Vec<usize> = (0..found.count()).rev().step_by(1 + found.count() / 9).collect();
                    for margin in [0, 1] {
                        let windows = found.split(&labels, margin).unwrap();
                        for (label, (first, window)) in labels.iter().zip(windows) {
                            let whole = found.select(|l| l as usize == *label);
                            let cut = whole.placed(first.map(|i| i as isize), *window.grid()).unwrap();
                            assert_eq!((&cut, cut.count()), (&window, found.sizes()[*label]));
                        }
                    }
                    for (label, first) in found.first_samples().into_iter().enumerate() {
                        assert_eq!(truth.iter().position(|&l| l == label as u32 + 1), Some(grid.offset(first)));
                    }
                    assert!((0..grid.samples()).all(|at| found.of(grid.index(at)).map_or(0, |l| l + 1) == truth[at]));
                }
            }
        }
    }
}
