//! Values on a grid, with the value that holds everywhere else.

use crate::error::{Error, Result};
use crate::grid::Grid;
use ndarray::Array3;

/// A sampled function: one value per sample of a grid and a background outside it.
///
/// The array has shape `(nz, ny, nx)` in standard layout, so that a layer is a contiguous plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Field<T> {
    grid: Grid,
    values: Array3<T>,
    background: T,
}

impl<T: Copy> Field<T> {
    /// A field with the same value everywhere.
    pub fn constant(grid: Grid, value: T) -> Self {
        Field { grid, values: Array3::from_elem(grid.shape(), value), background: value }
    }

    /// A field from values in storage order (x fastest, then y, then z).
    ///
    /// # Errors
    /// [`Error::Operand`] if the number of values is not the number of samples.
    pub fn from_values(grid: Grid, values: Vec<T>, background: T) -> Result<Self> {
        let given = values.len();
        let values = Array3::from_shape_vec(grid.shape(), values).map_err(|_| Error::Operand {
            operation: "field",
            problem: format!("{given} values for {} samples", grid.samples()),
            remedy: "give one value for each sample".into(),
        })?;
        Ok(Field { grid, values, background })
    }

    /// The grid the values stand on.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The value everywhere outside the grid.
    pub fn background(&self) -> T {
        self.background
    }

    /// The values as an array of shape `(nz, ny, nx)`.
    pub fn array(&self) -> &Array3<T> {
        &self.values
    }

    /// The values in storage order: x fastest, then y, then z.
    pub fn values(&self) -> &[T] {
        self.values.as_slice().unwrap_or(&[])
    }

    /// The values in storage order, to be changed in place.
    pub fn values_mut(&mut self) -> &mut [T] {
        self.values.as_slice_mut().unwrap_or(&mut [])
    }

    /// The value at a sample, or the background outside the grid.
    pub fn at(&self, [i, j, k]: [isize; 3]) -> T {
        let inside = |v: isize, n: usize| v >= 0 && (v as usize) < n;
        let [nx, ny, nz] = self.grid.dims();
        if inside(i, nx) && inside(j, ny) && inside(k, nz) {
            self.values[[k as usize, j as usize, i as usize]]
        } else {
            self.background
        }
    }

    /// The values, given away in storage order.
    pub fn into_values(self) -> Vec<T> {
        self.values.into_raw_vec_and_offset().0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Length;

    #[test]
    fn outside_is_background() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [2, 1, 1]).unwrap();
        let f = Field::from_values(grid, vec![1.0f32, 2.0], -1.0).unwrap();
        assert_eq!([f.at([0, 0, 0]), f.at([1, 0, 0]), f.at([2, 0, 0]), f.at([0, -1, 0])], [1.0, 2.0, -1.0, -1.0]);
        assert!(Field::from_values(grid, vec![0u8; 3], 0).is_err());
    }
}
