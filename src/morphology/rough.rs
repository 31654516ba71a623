//! Distances to a body between the samples of a lattice of its own: for many looks that need not be exact.

use super::offset::Measured;
use crate::error::Result;
use crate::field::Field;
use crate::geometry::vector::{Vec3, norm};
use rayon::prelude::*;

/// What values that are not exact are off by at most, in spacings: half a diagonal.
const OFF: f64 = 0.87;
const DIAGONAL: f64 = 1.74;

/// How far from the surface values are exact, in spacings.
const EXACT: f64 = 3.0;

/// A body on its lattice.
pub(super) struct Rough {
    values: Field<f32>,
    /// The indices of its first and last cell.
    last: Vec3,
}

/// The distance to the body, and what it is off by at most beside what bends between samples.
#[derive(Clone, Copy)]
pub(super) struct Roughly {
    pub(super) value: f64,
    pub(super) off: f64,
}

impl Rough {
    /// A body measured on a grid.
    ///
    /// # Errors
    /// None for a grid that holds it.
    ///
    /// # Cost
    /// A distance for each sample within [`EXACT`] spacings of the surface.
    pub(super) fn of(body: &Measured) -> Result<Self> {
        let (grid, inside) = (*body.shell2.grid(), &body.sides.centres);
        let h = grid.h();
        let measured = |(at, &shell2): (usize, &u32)| {
            let (index, about) = (grid.index(at), h * f64::from(shell2).sqrt());
            let near = about <= (EXACT + OFF) * h;
            let exact = near.then(|| body.of.exact.nearest(grid.position(index), about + OFF * h)).flatten();
            let away = exact.map_or(about, |nearest| nearest.distance);
            (if inside.contains(index) { -away } else { away }) as f32
        };
        let values = body.shell2.values().par_iter().enumerate().map(measured).collect();
        let last = grid.dims().map(|n| n as f64 - 1.0 - 1e-9);
        Ok(Rough { values: Field::from_values(grid, values, f32::MAX)?, last })
    }

    /// The signed distance at a point: linear along the axes between samples, and outside the lattice that of its border and what the point is
    /// beyond it.
    pub(super) fn seen(&self, y: Vec3) -> Roughly {
        let grid = self.values.grid();
        let ([nx, ny, _], h, place) = (grid.dims(), grid.h(), grid.continuous_index(y));
        let within = [0, 1, 2].map(|a| place[a].clamp(0.0, self.last[a]));
        let [i, j, k] = within.map(|x| x as usize);
        let [u, v, w] = [within[0] - i as f64, within[1] - j as f64, within[2] - k as f64];
        let (values, first) = (self.values.values(), (k * ny + j) * nx + i);
        let along_x = |at: usize| {
            let (a, b) = (f64::from(values[at]), f64::from(values[at + 1]));
            a + u * (b - a)
        };
        let in_plane = |at: usize| {
            let (a, b) = (along_x(at), along_x(at + nx));
            a + v * (b - a)
        };
        let (a, b) = (in_plane(first), in_plane(first + nx * ny));
        let value = a + w * (b - a);
        if within != place {
            let beyond = h * norm([0, 1, 2].map(|a| place[a] - within[a]));
            return Roughly { value: value.max(0.0).hypot(beyond), off: 2.0 * OFF * h };
        }
        Roughly { value, off: if value.abs() < (EXACT - DIAGONAL) * h { 0.0 } else { OFF * h } }
    }
}
