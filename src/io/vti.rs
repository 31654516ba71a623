//! VTI, image data of VTK: what ParaView reads.

use super::Raster;
use std::io::{Error, ErrorKind, Result, Write};

/// Writes samples as point data of one name, with origin and spacing in millimetres, appended raw.
///
/// # Errors
/// Those of `out`, and `InvalidInput` for a name of other characters than letters, digits, `_`, `-` and space.
///
/// # Source
/// VTK User's Guide, 11th edition, 2010, XML file formats.
pub fn write(raster: Raster<'_>, name: &str, out: &mut dyn Write) -> Result<()> {
    if !name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | ' ')) {
        return Err(Error::new(ErrorKind::InvalidInput, "the name does not fit an XML attribute"));
    }
    let grid = raster.grid();
    let [x, y, z] = grid.dims().map(|n| n - 1);
    let [ox, oy, oz] = grid.origin();
    let h = grid.h();
    let kind = match raster {
        Raster::Numbers(_) => "Float32",
        Raster::Bits(_) => "UInt8",
    };
    let extent = format!("0 {x} 0 {y} 0 {z}");
    write!(
        out,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<ImageData WholeExtent=\"{extent}\" Origin=\"{ox} {oy} {oz}\" Spacing=\"{h} {h} {h}\">\n\
         <Piece Extent=\"{extent}\">\n<PointData Scalars=\"{name}\">\n\
         <DataArray type=\"{kind}\" Name=\"{name}\" format=\"appended\" offset=\"0\"/>\n</PointData>\n</Piece>\n\
         </ImageData>\n<AppendedData encoding=\"raw\">\n_"
    )?;
    out.write_all(&raster.bytes().to_le_bytes())?;
    raster.write_samples(out)?;
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Indicator;
    use crate::grid::Grid;
    use crate::units::Length;

    #[test]
    fn the_size_stands_before_the_samples() {
        let grid = Grid::new([1.0, 2.0, 3.0], Length::mm(0.25), [70, 2, 1]).unwrap();
        let set = Indicator::from_predicate(grid, |at| at == 69);
        let mut bytes = Vec::new();
        write((&set).into(), "solid", &mut bytes).unwrap();
        let at = bytes.windows(2).position(|w| w == b"\n_").unwrap() + 2;
        let head = std::str::from_utf8(&bytes[..at]).unwrap();
        assert!(head.contains("WholeExtent=\"0 69 0 1 0 0\" Origin=\"1 2 3\" Spacing=\"0.25 0.25 0.25\""), "{head}");
        assert_eq!(bytes[at..at + 8], 140u64.to_le_bytes());
        let samples = &bytes[at + 8..at + 8 + 140];
        assert_eq!((samples[69], samples.iter().map(|&b| u32::from(b)).sum::<u32>()), (1, 1));
        assert!(write((&set).into(), "a\"b", &mut Vec::new()).is_err());
    }
}
