//! Edges of a lattice that the convolution of two operands crosses, and what they leave free.

use crate::field::Indicator;
use crate::geometry::gauss_image::GaussImage;
use crate::geometry::patch::Patch;
use crate::geometry::reduced_convolution::reduced_convolution;
use crate::geometry::vector::Vec3;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::VecDeque;

/// Crossings that are kept, at most.
const MOST: usize = 16_000_000;

/// A patch crosses an edge.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    /// Three times where the edge's first sample is stored, and its axis.
    edge: u64,
    /// From 0 to 1 along the edge.
    at: f32,
    normal: [f32; 3],
}

impl Crossing {
    /// By edge, along each, and of those in one place in an order that no number of threads changes.
    fn compare(&self, other: &Self) -> Ordering {
        let normals =
            || self.normal.iter().zip(&other.normal).fold(Ordering::Equal, |o, (m, n)| o.then(m.total_cmp(n)));
        self.edge.cmp(&other.edge).then(self.at.total_cmp(&other.at)).then_with(normals)
    }
}

/// The edges that patches cross, near the boundary.
pub(super) struct Met {
    /// In order along the edges.
    crossings: Vec<Crossing>,
    /// By axis, the first samples of the edges.
    pub(super) edges: [Indicator; 3],
}

impl Met {
    /// Those that the convolution of two operands crosses, but for edges whose ends are both certainly inside or both certainly
    /// outside; `None` if they are too many.
    pub(super) fn by(images: [&GaussImage; 2], [lower, upper]: &[Indicator; 2]) -> Option<Self> {
        let grid = *lower.grid();
        let take = |patch: Patch, crossings: &mut Vec<Crossing>| {
            let mut normal = None;
            patch.crossings(&grid, |crossed| {
                let mut to = crossed.from;
                to[crossed.axis] += 1;
                let ends = [crossed.from, to];
                if ends.iter().all(|&end| lower.contains(end)) || !ends.iter().any(|&end| upper.contains(end)) {
                    return;
                }
                let edge = 3 * grid.offset(crossed.from) as u64 + crossed.axis as u64;
                let normal = *normal.get_or_insert_with(|| patch.normal().map(|x| x as f32));
                crossings.push(Crossing { edge, at: crossed.at as f32, normal });
            });
        };
        let mut crossings = reduced_convolution(images, MOST, take)?;
        crossings.par_sort_unstable_by(Crossing::compare);
        let mut edges = [0; 3].map(|_| Indicator::empty(grid));
        for same in crossings.chunk_by(|p, q| p.edge == q.edge) {
            edges[(same[0].edge % 3) as usize].set(grid.index((same[0].edge / 3) as usize), true);
        }
        Some(Met { crossings, edges })
    }

    /// Where an edge is first met from its start or its end, with a normal there, on either side.
    pub(super) fn first(&self, from: [usize; 3], axis: usize, from_start: bool) -> Option<(f64, Vec3)> {
        let edge = 3 * self.edges[axis].grid().offset(from) as u64 + axis as u64;
        let start = self.crossings.partition_point(|c| c.edge < edge);
        let same = self.crossings[start..].iter().take_while(|c| c.edge == edge);
        let crossing = if from_start { same.take(1).last() } else { same.last() }?;
        Some((f64::from(crossing.at), crossing.normal.map(f64::from)))
    }
}

/// The free samples, with those of the open ones that edges which are not met join to them.
///
/// # Cost
/// A few words for each row of open samples, once more whenever a row beside it gained some.
pub(super) fn flooded(mut free: Indicator, open: &Indicator, met: &[Indicator; 3]) -> Indicator {
    let [_, ny, nz] = free.grid().dims();
    let words = free.words_per_row();
    let rows: Vec<usize> = (0..ny * nz).filter(|row| open.row(row % ny, row / ny).iter().any(|w| *w != 0)).collect();
    let mut waits = vec![false; ny * nz];
    rows.iter().for_each(|&row| waits[row] = true);
    let mut waiting: VecDeque<usize> = rows.into();
    while let Some(row) = waiting.pop_front() {
        waits[row] = false;
        let (j, k) = (row % ny, row / ny);
        // From the rows before and behind, through the edges that start there or here.
        let beside = [
            (j > 0).then(|| ((j - 1, k), 1, (j - 1, k))),
            (j + 1 < ny).then(|| ((j + 1, k), 1, (j, k))),
            (k > 0).then(|| ((j, k - 1), 2, (j, k - 1))),
            (k + 1 < nz).then(|| ((j, k + 1), 2, (j, k))),
        ];
        let mut reached: Vec<u64> = free.row(j, k).to_vec();
        for ((y, z), axis, (ey, ez)) in beside.into_iter().flatten() {
            let through = free.row(y, z).iter().zip(met[axis].row(ey, ez));
            reached.iter_mut().zip(through).zip(open.row(j, k)).for_each(|((r, (f, m)), o)| *r |= f & !m & o);
        }
        spread(&mut reached, open.row(j, k), met[0].row(j, k));
        if reached != free.row(j, k) {
            free.words_mut()[row * words..(row + 1) * words].copy_from_slice(&reached);
            for ((y, z), ..) in beside.into_iter().flatten() {
                let next = z * ny + y;
                if !waits[next] && open.row(y, z).iter().zip(free.row(y, z)).any(|(o, f)| o & !f != 0) {
                    waits[next] = true;
                    waiting.push_back(next);
                }
            }
        }
    }
    free
}

/// Spreads bits along a row over those that are open and not parted by an edge that is met.
fn spread(row: &mut [u64], open: &[u64], met: &[u64]) {
    loop {
        let mut gained = false;
        for w in 0..row.len() {
            let before = if w > 0 { (row[w - 1] & !met[w - 1]) >> 63 } else { 0 };
            let after = row.get(w + 1).map_or(0, |next| next << 63);
            loop {
                let up = (row[w] & !met[w]) << 1 | before;
                let down = (row[w] >> 1 | after) & !met[w];
                let new = (up | down) & open[w] & !row[w];
                if new == 0 {
                    break;
                }
                row[w] |= new;
                gained = true;
            }
        }
        if !gained {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::random::Lcg;
    use crate::units::Length;

    #[test]
    fn the_flood_reaches_what_steps_from_sample_to_sample_reach() {
        let mut random = Lcg(3);
        for dims in [[70, 5, 4], [130, 3, 1], [64, 6, 5], [9, 9, 9]] {
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
            let mut share = |part: f64| {
                let mut set = Indicator::empty(grid);
                (0..grid.samples()).for_each(|at| set.set(grid.index(at), random.point(0.0, 1.0)[0] < part));
                set
            };
            let (seeds, open, met) = (share(0.03), share(0.8), [share(0.3), share(0.4), share(0.4)]);
            let mut want = seeds.clone();
            let mut waiting: Vec<usize> = seeds.iter().collect();
            while let Some(at) = waiting.pop() {
                let from = grid.index(at);
                for (axis, forwards) in (0..3).flat_map(|axis| [(axis, true), (axis, false)]) {
                    let mut to = from;
                    to[axis] = if forwards { from[axis] + 1 } else { from[axis].wrapping_sub(1) };
                    let edge = if forwards { from } else { to };
                    if to[axis] < dims[axis] && open.contains(to) && !want.contains(to) && !met[axis].contains(edge) {
                        want.set(to, true);
                        waiting.push(grid.offset(to));
                    }
                }
            }
            assert!(want.count() > seeds.count() + 10);
            assert!(flooded(seeds, &open, &met) == want, "{dims:?}");
        }
    }
}
