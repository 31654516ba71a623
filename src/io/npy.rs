//! NPY, the array format of NumPy, version 1.0.

use super::Raster;
use std::io::{Result, Write};

/// Writes samples as an array of shape (nz, ny, nx), type `<f4` or `|u1`.
///
/// # Errors
/// Those of `out`.
///
/// # Limits
/// NPY carries no origin and no spacing: see [`super::nrrd`] and [`super::vti`].
///
/// # Source
/// NumPy Enhancement Proposal 1, Kern 2007.
pub fn write(raster: Raster<'_>, out: &mut dyn Write) -> Result<()> {
    let [nx, ny, nz] = raster.grid().dims();
    let kind = match raster {
        Raster::Numbers(_) => "<f4",
        Raster::Bits(_) => "|u1",
    };
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({nz}, {ny}, {nx}), }}");
    // Magic, version and length take ten bytes; the data starts at a multiple of 64 after a line end.
    let padded = (10 + header.len() + 1).next_multiple_of(64) - 10;
    header.extend(std::iter::repeat_n(' ', padded - header.len() - 1));
    header.push('\n');
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(header.len() as u16).to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    raster.write_samples(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Field, Indicator};
    use crate::grid::Grid;
    use crate::units::Length;

    #[test]
    fn header_and_samples_stand_where_numpy_looks() {
        let grid = Grid::new([0.0; 3], Length::mm(0.5), [3, 2, 1]).unwrap();
        let field = Field::from_values(grid, vec![1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0], 0.0).unwrap();
        let mut bytes = Vec::new();
        write((&field).into(), &mut bytes).unwrap();
        assert_eq!(bytes.len(), 128 + 24);
        assert_eq!((&bytes[..8], bytes[127]), (&b"\x93NUMPY\x01\x00"[..], b'\n'));
        let text = String::from_utf8_lossy(&bytes[10..127]).into_owned();
        assert!(text.starts_with("{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 3), }"), "{text}");
        assert_eq!(bytes[128 + 20..], 6.0f32.to_le_bytes());

        let set = Indicator::from_predicate(grid, |at| at % 2 == 0);
        let mut bytes = Vec::new();
        write((&set).into(), &mut bytes).unwrap();
        assert_eq!(bytes[128..], [1, 0, 1, 0, 1, 0]);
    }
}
