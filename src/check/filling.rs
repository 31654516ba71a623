//! The void that a chamber holds, or a labelled piece of it, on a window of its own.

use crate::distance::union_of_balls;
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::contour::{Edge, linear_crossing, surface};
use crate::geometry::{Solid, TriangleMesh};
use crate::grid::Grid;
use crate::topology::Chamber;
use rayon::prelude::*;

/// A set of samples of a solid's grid, on the box that holds it.
pub(super) struct Filling<'a> {
    solid: &'a Solid,
    /// Index of the window's first sample in the grid of the solid.
    first: [usize; 3],
    pub set: Indicator,
}

impl<'a> Filling<'a> {
    /// The balls of clearance about the samples of a chamber, one sample wider so that they reach the walls.
    ///
    /// # Errors
    /// None for a chamber of the solid.
    ///
    /// # Cost
    /// O(samples of the window).
    pub fn of(chamber: &Chamber, clearance: &Field<u32>, solid: &'a Solid) -> Result<Self> {
        Filling::grown(chamber, clearance, solid, 1.0)
    }

    /// As [`Filling::of`], so many samples wider.
    pub fn grown(chamber: &Chamber, clearance: &Field<u32>, solid: &'a Solid, by: f64) -> Result<Self> {
        let grid = *clearance.grid();
        let reach = (f64::from(chamber.widest).sqrt() + by).ceil() as usize + 1;
        let (mut lo, mut hi) = ([usize::MAX; 3], [0; 3]);
        for &(first, count) in &chamber.region {
            let p = grid.index(first as usize);
            (0..3).for_each(|a| (lo[a], hi[a]) = (lo[a].min(p[a]), hi[a].max(p[a])));
            hi[0] = hi[0].max(p[0] + count as usize - 1);
        }
        let first = lo.map(|c| c.saturating_sub(reach));
        let end = [0, 1, 2].map(|a| (hi[a] + reach + 1).min(grid.dims()[a]));
        let window = Grid::new(grid.position(first), grid.spacing(), [0, 1, 2].map(|a| end[a] - first[a]))?;
        let nothing = Filling { solid, first, set: Indicator::empty(window) };
        let balls = nothing.balls(chamber, clearance, |c| (c.sqrt() + by).powi(2))?;
        let set = balls.difference(&nothing.material()?)?;
        Ok(Filling { set, ..nothing })
    }

    /// Closed balls about the samples of a chamber, on the window: their squared radii from the squared clearance.
    ///
    /// # Errors
    /// None for a chamber of the solid.
    pub fn balls(
        &self,
        chamber: &Chamber,
        clearance: &Field<u32>,
        squared: impl Fn(f64) -> f64 + Sync,
    ) -> Result<Indicator> {
        let (grid, window, first) = (*clearance.grid(), *self.set.grid(), self.first);
        let mut own = Indicator::empty(window);
        for at in chamber.offsets() {
            let p = grid.index(at);
            own.set([0, 1, 2].map(|a| p[a] - first[a]), true);
        }
        union_of_balls(&window, |at| {
            let p = window.index(at);
            let clear = || clearance.values()[grid.offset([0, 1, 2].map(|a| p[a] + first[a]))];
            own.contains(p).then(|| squared(f64::from(clear())) as u32)
        })
    }

    /// The cubes wholly in the part, on the window.
    ///
    /// # Errors
    /// None.
    pub fn material(&self) -> Result<Indicator> {
        self.solid.inner.placed(self.first.map(|c| c as isize), *self.set.grid())
    }

    /// The cubes that the part touches, on the window.
    ///
    /// # Errors
    /// None.
    pub fn touched(&self) -> Result<Indicator> {
        self.solid.outer.placed(self.first.map(|c| c as isize), *self.set.grid())
    }

    /// Whether some of a cube is above the plate.
    pub fn is_above_plate(&self, index: [usize; 3]) -> bool {
        self.above_plate(index) > 0.0
    }

    /// Whether the plate caps the clearance in a layer to less than a sample and a half.
    pub fn is_by_the_plate(&self, layer: usize) -> bool {
        let grid = self.set.grid();
        grid.position([0, 0, layer])[2] < 1.5 * grid.h()
    }

    /// The share of a cube that is above the plate.
    fn above_plate(&self, index: [usize; 3]) -> f64 {
        let grid = self.set.grid();
        (grid.position(index)[2] / grid.h() + 0.5).clamp(0.0, 1.0)
    }

    /// A set on the grid of the solid, one sample of its surroundings about it.
    ///
    /// # Errors
    /// None for a set on that grid.
    pub fn around(set: &Indicator, solid: &'a Solid) -> Result<Self> {
        let dims = set.grid().dims();
        let (lo, count) = set.support_box().unwrap_or(([0; 3], [1; 3]));
        let first = lo.map(|c| c.saturating_sub(1));
        let end = [0, 1, 2].map(|a| (lo[a] + count[a] + 1).min(dims[a]));
        let window = Grid::new(set.grid().position(first), set.grid().spacing(), [0, 1, 2].map(|a| end[a] - first[a]))?;
        Ok(Filling { solid, first, set: set.placed(first.map(|c| c as isize), window)? })
    }

    /// The set on the grid of the solid.
    ///
    /// # Errors
    /// None.
    pub fn whole(&self) -> Result<Indicator> {
        self.set.placed(self.first.map(|c| -(c as isize)), *self.solid.inner.grid())
    }

    /// Volume of the void in it, by the densities, mm³; below the plate there is none.
    pub fn volume_mm3(&self) -> f64 {
        void_above_plate(self, &self.set)
    }

    /// The surface of the void within the set, where the density passes one half.
    ///
    /// # Errors
    /// As [`surface`].
    pub fn surface(&self) -> Result<TriangleMesh> {
        let (grid, density) = (*self.set.grid(), self.solid.density.field());
        let void = Indicator::from_predicate(grid, |at| {
            let index = grid.index(at);
            self.set.contains(index) && density.at(self.lifted(index.map(|i| i as isize))) < 0.5
        });
        surface(&void, |edge| linear_crossing(density, Edge { from: self.lifted(edge.from), ..edge }, 0.5))
    }

    /// An index of the window as one of the solid's grid.
    fn lifted(&self, index: [isize; 3]) -> [isize; 3] {
        [0, 1, 2].map(|a| index[a] + self.first[a] as isize)
    }
}

/// Volume of the void in a set on the window of a filling, by the densities, mm³; what is below the plate is no part of it.
pub(super) fn void_above_plate(window: &Filling, set: &Indicator) -> f64 {
    let density = window.solid.density.field();
    let void = |at: usize| {
        let index = set.grid().index(at);
        (window.above_plate(index) - f64::from(density.at(window.lifted(index.map(|i| i as isize))))).max(0.0)
    };
    set.iter().map(void).sum::<f64>() * set.grid().h().powi(3)
}

/// A set with the samples around it that are not wholly material.
pub(super) fn ringed(set: &Indicator, material: &Indicator) -> Indicator {
    let [nx, ny, nz] = set.grid().dims();
    let words = set.words_per_row();
    let last = if nx % 64 == 0 { !0 } else { (1u64 << (nx % 64)) - 1 };
    let wide = |row: &[u64], w: usize| {
        let (before, behind) = (if w > 0 { row[w - 1] >> 63 } else { 0 }, row.get(w + 1).map_or(0, |n| n << 63));
        row[w] | row[w] << 1 | row[w] >> 1 | before | behind
    };
    let mut out = set.clone();
    out.words_mut().par_chunks_mut(words).enumerate().for_each(|(at, to)| {
        let (j, k) = (at % ny, at / ny);
        for z in k.saturating_sub(1)..(k + 2).min(nz) {
            for y in j.saturating_sub(1)..(j + 2).min(ny) {
                let row = set.row(y, z);
                to.iter_mut().enumerate().for_each(|(w, to)| *to |= wide(row, w));
            }
        }
        let material = material.row(j, k);
        for ((to, material), own) in to.iter_mut().zip(material).zip(set.row(j, k)) {
            *to &= !material | own;
        }
        if let Some(word) = to.last_mut() {
            *word &= last;
        }
    });
    out
}
