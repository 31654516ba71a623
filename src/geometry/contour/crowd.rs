//! Where sheets of a surface come so near to each other that finer facets may cross.

use crate::field::Indicator;
use crate::geometry::health::{Through, crossing_pairs};
use crate::geometry::mesh::TriangleMesh;
use crate::geometry::vector::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// Facets that cross by less than this, in spacings, meet but for rounding.
pub const MEETING: f64 = 1e-5;

/// The cells of a lattice in or beside which a surface is creased, passes twice, or leaves a layer of samples alone on its side.
///
/// Elsewhere, as far as samples tell, a surface runs through the cells as one smooth sheet, away from any other.
#[derive(Debug, Clone)]
pub struct Crowd {
    /// Cells by their first sample, on a grid with a sample more on every side than the set has.
    cells: Indicator,
}

impl Crowd {
    /// Those around the given cells and around the lone samples of a set, which is empty along the border of its grid.
    pub(in crate::geometry) fn about(padded: &Indicator, cells: impl IntoIterator<Item = [usize; 3]>) -> Self {
        let mut crowd = Indicator::empty(*padded.grid());
        for [i, j, k] in cells {
            mark(&mut crowd, [i, j, k]);
        }
        for [i, j, k] in lone_samples(padded) {
            // The first of the eight cells around the sample, and the last.
            mark(&mut crowd, [i, j, k].map(|n| n.saturating_sub(1)));
            mark(&mut crowd, [i, j, k]);
        }
        Crowd { cells: crowd }
    }

    /// The same and the cells at these places and around them.
    pub(in crate::geometry) fn and_at(&self, places: &[Vec3]) -> Crowd {
        let mut crowd = self.clone();
        crowd.mark_at(places.iter().copied());
        crowd
    }

    /// The cells at these places alone and around them.
    pub(super) fn at(&self, places: impl IntoIterator<Item = Vec3>) -> Crowd {
        let mut crowd = Crowd { cells: Indicator::empty(*self.cells.grid()) };
        crowd.mark_at(places);
        crowd
    }

    fn mark_at(&mut self, places: impl IntoIterator<Item = Vec3>) {
        for place in places {
            if let Some(cell) = self.cell(place) {
                mark(&mut self.cells, cell);
            }
        }
    }

    /// The spacing of the lattice, mm.
    pub(super) fn h(&self) -> f64 {
        self.cells.grid().h()
    }

    /// Whether a place lies in such a cell; none lies there beyond the grid.
    fn holds(&self, place: Vec3) -> bool {
        self.cell(place).is_some_and(|cell| self.cells.contains(cell))
    }

    /// The cell of a place, if it is one of the grid.
    fn cell(&self, place: Vec3) -> Option<[usize; 3]> {
        // What lies on a face belongs to the cell behind it, whatever rounding says.
        let index = self.cells.grid().continuous_index(place).map(|x| (x + 1e-6).floor());
        let dims = self.cells.grid().dims();
        (0..3).all(|a| index[a] >= 0.0 && index[a] < dims[a] as f64).then(|| index.map(|x| x as usize))
    }

    /// Calls `mend(mesh, pair, moved)` for the pairs of facets of the crowd that cross by more than 1e-5 spacings, and again for those that
    /// then do, until none is left or nothing more is mended; `mend` tells the vertices that it moved.
    ///
    /// # Cost
    /// A tree over the facets of the crowd; then one for each round over the facets near what was moved in the last.
    pub fn mend_crossings(
        &self,
        mesh: &mut TriangleMesh,
        mut mend: impl FnMut(&mut TriangleMesh, [u32; 2], &mut Vec<u32>),
    ) {
        let (grid, all) = (self.cells.grid(), self.facets(mesh));
        let cell = |p: Vec3| grid.continuous_index(p).map(|x| x.floor() as i32);
        let (mut facets, mut moved) = (all.clone(), Vec::new());
        loop {
            for pair in crossing_pairs(mesh, &facets, MEETING * grid.h(), Through::Edges) {
                mend(mesh, pair, &mut moved);
            }
            if moved.is_empty() {
                return;
            }
            // What moved did so by less than two cells, and its facets are as long at most.
            let near: FxHashSet<[i32; 3]> =
                moved.drain(..).flat_map(|v| around(cell(mesh.vertices[v as usize]))).collect();
            let beside =
                |f: &u32| mesh.triangles[*f as usize].iter().any(|&v| near.contains(&cell(mesh.vertices[v as usize])));
            facets = all.iter().copied().filter(beside).collect();
        }
    }

    /// The facets of a mesh with a corner in such a cell.
    pub(super) fn facets(&self, mesh: &TriangleMesh) -> Vec<u32> {
        let held: Vec<bool> = mesh.vertices.par_iter().map(|&p| self.holds(p)).collect();
        let near = |t: &[u32; 3]| t.iter().any(|&v| held.get(v as usize) == Some(&true));
        mesh.triangles.par_iter().enumerate().filter(|(_, t)| near(t)).map(|(f, _)| f as u32).collect()
    }
}

/// A cell and those beside it.
fn around(cell: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (0..27).map(move |n| [cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1])
}

/// Marks a cell and those around it, and the next along each axis, whose first faces are their last.
fn mark(crowd: &mut Indicator, cell: [usize; 3]) {
    let dims = crowd.grid().dims();
    let range = |a: usize| cell[a].saturating_sub(1)..(cell[a] + 3).min(dims[a]);
    for k in range(2) {
        for j in range(1) {
            for i in range(0) {
                crowd.set([i, j, k], true);
            }
        }
    }
}

/// The samples that have the other side on both hands along some axis.
fn lone_samples(set: &Indicator) -> Vec<[usize; 3]> {
    let [nx, ny, nz] = set.grid().dims();
    let mut found = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            let row = set.row(j, k);
            let between =
                |rows: Option<[&[u64]; 2]>, w: usize| rows.map_or(0, |[a, b]| (row[w] ^ a[w]) & (row[w] ^ b[w]));
            let along_y = (j > 0 && j + 1 < ny).then(|| [set.row(j - 1, k), set.row(j + 1, k)]);
            let along_z = (k > 0 && k + 1 < nz).then(|| [set.row(j, k - 1), set.row(j, k + 1)]);
            for (w, &bits) in row.iter().enumerate() {
                let before = bits << 1 | if w > 0 { row[w - 1] >> 63 } else { 0 };
                let after = bits >> 1 | row.get(w + 1).map_or(0, |next| next << 63);
                let mut lone = (bits ^ before) & (bits ^ after) | between(along_y, w) | between(along_z, w);
                while lone != 0 {
                    let i = w * 64 + lone.trailing_zeros() as usize;
                    lone &= lone - 1;
                    if i < nx {
                        found.push([i, j, k]);
                    }
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::units::Length;

    #[test]
    fn lone_samples_are_those_between_two_of_the_other_side() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [70, 5, 4]).unwrap();
        let mut state = 3u64;
        let mut set = Indicator::empty(grid);
        for at in 0..grid.samples() {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            set.set(grid.index(at), (state >> 33).is_multiple_of(3));
        }
        let plain = |index: [usize; 3]| {
            (0..3).any(|a| {
                let other = |by: isize| {
                    let next = index[a].checked_add_signed(by).filter(|&n| n < grid.dims()[a])?;
                    Some(set.contains([0, 1, 2].map(|b| if b == a { next } else { index[b] })) != set.contains(index))
                };
                // Beyond the ends of a row there is nothing; beyond the grid across rows nothing is known.
                let beyond = (a == 0 && set.contains(index)).then_some(true);
                other(-1).or(beyond) == Some(true) && other(1).or(beyond) == Some(true)
            })
        };
        let want: Vec<[usize; 3]> =
            (0..grid.samples()).map(|at| grid.index(at)).filter(|&index| plain(index)).collect();
        assert_eq!(lone_samples(&set), want);
        assert!(want.len() > 100);
    }
}
