//! Lattices whose cells divide an element.

use super::least_element::{Bead, Footprint};
use super::overlap::Prism;
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, add, sub};
use crate::grid::Grid;
use crate::units::{Length, Volume};

/// Cells along the width and the height of an element, finest first; a lattice takes the first that it has room for.
const DIVISIONS: [(usize, usize); 7] = [(6, 4), (5, 3), (4, 3), (4, 2), (3, 2), (2, 2), (2, 1)];
/// Those of places that are looked at by themselves.
const CLOSE_DIVISIONS: [(usize, usize); 3] = [(24, 16), (16, 10), (10, 6)];

/// A lattice whose cells divide an element: `wide` cells across and `high` along z.
///
/// Its grid is cubic in a frame that is stretched along z by `stretch`, so that flat elements have whole numbers of cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cells {
    pub grid: Grid,
    pub wide: usize,
    pub high: usize,
    pub stretch: f64,
}

impl Cells {
    /// The finest lattice over a box that takes at most `most` cells, if there is one.
    ///
    /// # Errors
    /// [`Error::Operand`] for an element or a box without extent.
    pub fn covering(bead: &Bead, window: (Vec3, Vec3), most: u128) -> Result<Option<Self>> {
        Cells::covering_where(bead, window, most, |_| true)
    }

    /// As [`Cells::covering`], among divisions of the element that suit.
    ///
    /// # Errors
    /// As there.
    pub fn covering_where(
        bead: &Bead,
        window: (Vec3, Vec3),
        most: u128,
        suits: impl Fn(&(usize, usize)) -> bool,
    ) -> Result<Option<Self>> {
        Cells::divided(bead, window, most, DIVISIONS.iter().filter(|d| suits(d)))
    }

    /// As [`Cells::covering_where`], with up to four times as many cells along each side of the element: for a place by itself.
    ///
    /// # Errors
    /// As there.
    pub fn covering_closely(
        bead: &Bead,
        window: (Vec3, Vec3),
        most: u128,
        suits: impl Fn(&(usize, usize)) -> bool,
    ) -> Result<Option<Self>> {
        Cells::divided(bead, window, most, CLOSE_DIVISIONS.iter().filter(|d| suits(d)))
    }

    /// The lattice over a box with so many cells along the width and the height of the element, unless it takes more than `most`.
    ///
    /// # Errors
    /// As [`Cells::covering`].
    pub fn divided_into(
        bead: &Bead,
        window: (Vec3, Vec3),
        most: u128,
        division: (usize, usize),
    ) -> Result<Option<Self>> {
        Cells::divided(bead, window, most, [division].iter())
    }

    fn divided<'a>(
        bead: &Bead,
        (lo, hi): (Vec3, Vec3),
        most: u128,
        divisions: impl Iterator<Item = &'a (usize, usize)>,
    ) -> Result<Option<Self>> {
        let (width, height) = (bead.width.as_mm(), bead.height.as_mm());
        if !(width > 0.0 && height > 0.0 && width.is_finite() && height.is_finite()) {
            return Err(Error::Operand {
                operation: "deposit",
                problem: format!("an element of {width} by {height} mm"),
                remedy: "give the element a width, and the machine a layer height".into(),
            });
        }
        for &(wide, high) in divisions {
            let h = width / wide as f64;
            let stretch = h / (height / high as f64);
            let margin = wide.max(high) + 3;
            let count = |a: usize, scale: f64| ((hi[a] - lo[a]) * scale / h).ceil() + 2.0 * margin as f64 + 1.0;
            let cells = count(0, 1.0) * count(1, 1.0) * count(2, stretch);
            if cells.is_nan() || cells > most as f64 {
                continue;
            }
            let stretched = |p: Vec3| [p[0], p[1], p[2] * stretch];
            let grid = Grid::covering(stretched(lo), stretched(hi), Length::mm(h), margin, [0.0; 3])?;
            return Ok(Some(Cells { grid, wide, high, stretch }));
        }
        Ok(None)
    }

    /// Sides of a cell in millimetres.
    pub fn cell_mm(&self) -> Vec3 {
        let h = self.grid.h();
        [h, h, h / self.stretch]
    }

    /// Volume of one cell.
    pub fn cell_volume(&self) -> Volume {
        let [x, y, z] = self.cell_mm();
        Volume::mm3(x * y * z)
    }

    /// Centre of a cell in the frame of the part.
    pub fn position(&self, index: [usize; 3]) -> Vec3 {
        let [x, y, z] = self.grid.position(index);
        [x, y, z / self.stretch]
    }

    /// The box of the centres of all cells that lie in a box.
    pub fn held(&self, (lo, hi): (Vec3, Vec3)) -> (Vec3, Vec3) {
        let half = self.cell_mm().map(|side| 0.5 * side);
        (add(lo, half), sub(hi, half))
    }

    /// The box of the centres of all cells that meet a box.
    pub fn touched(&self, (lo, hi): (Vec3, Vec3)) -> (Vec3, Vec3) {
        let half = self.cell_mm().map(|side| 0.5 * side);
        (sub(lo, half), add(hi, half))
    }

    /// The cells whose centres lie in a box of the part's frame.
    pub fn indices_in(&self, window: (Vec3, Vec3)) -> impl Iterator<Item = [usize; 3]> {
        let [x, y, z] = self.ranges_in(window);
        z.flat_map(move |k| {
            let x = x.clone();
            y.clone().flat_map(move |j| x.clone().map(move |i| [i, j, k]))
        })
    }

    fn ranges_in(&self, (lo, hi): (Vec3, Vec3)) -> [std::ops::Range<usize>; 3] {
        let cell = self.cell_mm();
        let first = self.position([0; 3]);
        let dims = self.grid.dims();
        let index = |p: Vec3, a: usize| ((p[a] - first[a]) / cell[a]).clamp(-1.0, dims[a] as f64);
        [0, 1, 2].map(|a| (index(lo, a).ceil().max(0.0) as usize)..((index(hi, a).floor() + 1.0) as usize).min(dims[a]))
    }

    /// The cells of a set whose centres lie in a box of the part's frame.
    pub fn within(&self, set: &Indicator, window: (Vec3, Vec3)) -> Indicator {
        let mut inside = Indicator::empty(self.grid);
        self.indices_in(window).filter(|&index| set.contains(index)).for_each(|index| inside.set(index, true));
        inside
    }

    /// Volume of the cells of one set that are not in another, centres within a box of the part's frame.
    pub fn volume_in(&self, from: &Indicator, without: &Indicator, window: (Vec3, Vec3)) -> Volume {
        let [x, y, z] = self.ranges_in(window);
        let mut count = 0u64;
        for (j, k) in z.flat_map(|k| y.clone().map(move |j| (j, k))) {
            let (a, b) = (from.row(j, k), without.row(j, k));
            count += x.clone().filter(|i| (a[i / 64] & !b[i / 64]) >> (i % 64) & 1 == 1).count() as u64;
        }
        self.cell_volume() * count as f64
    }

    /// A mesh in the frame of the part, in the stretched frame.
    pub fn stretched(&self, mesh: &TriangleMesh) -> TriangleMesh {
        let mut stretched = mesh.clone();
        stretched.vertices.iter_mut().for_each(|p| p[2] *= self.stretch);
        stretched
    }

    /// A mesh in the stretched frame, in the frame of the part.
    pub fn to_part(&self, mut mesh: TriangleMesh) -> TriangleMesh {
        mesh.vertices.iter_mut().for_each(|p| p[2] /= self.stretch);
        mesh
    }

    /// Whole cells across in a length.
    pub fn whole(&self, length: Length) -> usize {
        (length.as_mm() / self.cell_mm()[0] + 1e-6) as usize
    }

    /// The element as cells: those whose centre lies in it.
    pub(super) fn element(&self, footprint: Footprint) -> Result<Prism> {
        let middle = 0.5 * (self.wide as f64 - 1.0);
        let radius2 = (0.5 * self.wide as f64).powi(2);
        Prism::new(self.wide, self.high, |i, j| match footprint {
            Footprint::Square => true,
            Footprint::Disc => (i as f64 - middle).powi(2) + (j as f64 - middle).powi(2) <= radius2,
        })
    }
}
