//! NRRD, nearly raw raster data: what 3D Slicer, ITK and ParaView read.

use super::Raster;
use std::io::{Result, Write};

/// Writes samples with origin and spacing in millimetres, x fastest, raw.
///
/// The origin is the centre of the first sample, as NRRD's node-centred axes have it.
///
/// # Errors
/// Those of `out`.
///
/// # Source
/// Kindlmann, Definition of the NRRD file format, 2005 (version 4).
pub fn write(raster: Raster<'_>, out: &mut dyn Write) -> Result<()> {
    let grid = raster.grid();
    let [nx, ny, nz] = grid.dims();
    let [x, y, z] = grid.origin();
    let h = grid.h();
    let kind = match raster {
        Raster::Numbers(_) => "float",
        Raster::Bits(_) => "uint8",
    };
    write!(
        out,
        "NRRD0004\ntype: {kind}\ndimension: 3\nspace dimension: 3\nsizes: {nx} {ny} {nz}\n\
         space directions: ({h},0,0) (0,{h},0) (0,0,{h})\nspace origin: ({x},{y},{z})\n\
         space units: \"mm\" \"mm\" \"mm\"\ncenterings: node node node\nkinds: domain domain domain\n\
         endian: little\nencoding: raw\n\n"
    )?;
    raster.write_samples(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Field;
    use crate::grid::Grid;
    use crate::units::Length;

    #[test]
    fn the_header_places_the_samples() {
        let grid = Grid::new([-1.5, 2.0, 0.25], Length::mm(0.5), [3, 2, 1]).unwrap();
        let mut bytes = Vec::new();
        write((&Field::constant(grid, 7.0f32)).into(), &mut bytes).unwrap();
        let at = bytes.windows(2).position(|w| w == b"\n\n").unwrap();
        let text = std::str::from_utf8(&bytes[..at]).unwrap();
        for line in [
            "NRRD0004",
            "type: float",
            "sizes: 3 2 1",
            "space directions: (0.5,0,0) (0,0.5,0) (0,0,0.5)",
            "space origin: (-1.5,2,0.25)",
        ] {
            assert!(text.lines().any(|l| l == line), "{line}");
        }
        assert_eq!(bytes[at + 2..], 7.0f32.to_le_bytes().repeat(6));
    }
}
