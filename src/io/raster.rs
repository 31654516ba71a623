//! What the volume writers have in common: samples on a grid as little-endian numbers.

use crate::field::{Field, Indicator};
use crate::grid::Grid;
use std::io::{Result, Write};

/// Samples to be written: numbers, or in and out as 1 and 0.
#[derive(Debug, Clone, Copy)]
pub enum Raster<'a> {
    /// Four bytes a sample.
    Numbers(&'a Field<f32>),
    /// One byte a sample.
    Bits(&'a Indicator),
}

impl<'a> From<&'a Field<f32>> for Raster<'a> {
    fn from(field: &'a Field<f32>) -> Self {
        Raster::Numbers(field)
    }
}

impl<'a> From<&'a Indicator> for Raster<'a> {
    fn from(set: &'a Indicator) -> Self {
        Raster::Bits(set)
    }
}

impl Raster<'_> {
    /// The grid of the samples.
    pub fn grid(&self) -> &Grid {
        match self {
            Raster::Numbers(field) => field.grid(),
            Raster::Bits(set) => set.grid(),
        }
    }

    /// Bytes of all samples.
    pub(super) fn bytes(&self) -> u64 {
        let each = match self {
            Raster::Numbers(_) => 4,
            Raster::Bits(_) => 1,
        };
        self.grid().samples() as u64 * each
    }

    /// The samples, x fastest, then y, then z.
    pub(super) fn write_samples(&self, out: &mut dyn Write) -> Result<()> {
        let [nx, ny, nz] = self.grid().dims();
        let mut row = Vec::with_capacity(4 * nx);
        match self {
            Raster::Numbers(field) => {
                for values in field.values().chunks(nx) {
                    row.clear();
                    row.extend(values.iter().flat_map(|v| v.to_le_bytes()));
                    out.write_all(&row)?;
                }
            }
            Raster::Bits(set) => {
                for (k, j) in (0..nz).flat_map(|k| (0..ny).map(move |j| (k, j))) {
                    row.clear();
                    let bits = set.row(j, k).iter().flat_map(|word| (0..64).map(move |bit| (word >> bit & 1) as u8));
                    row.extend(bits.take(nx));
                    out.write_all(&row)?;
                }
            }
        }
        Ok(())
    }
}
