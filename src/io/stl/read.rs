//! Reading STL of either kind.

use super::decide::{self, Kind};
use super::{binary, text};
use crate::error::Result;
use crate::io::{Loaded, Salvage, accept};

/// No coordinate is further from what was meant than this share of the largest: both kinds are parsed as f32.
pub const RELATIVE_STEP: f64 = 1.0 / (1 << 24) as f64;

/// The mesh of an STL file, facets in file order, corners welded where their coordinates are equal.
///
/// A file whose length is 84 + 50·count is binary whatever its header says; any other that starts with
/// `solid` and goes on with `facet` or `endsolid` is ASCII. Normals and attribute bytes are ignored: the
/// winding decides.
///
/// # Errors
/// [`Error::Damaged`](crate::Error::Damaged) with byte, line or facet; [`Error::NoGeometry`](crate::Error::NoGeometry)
/// without facets or extent; [`Error::TooLarge`](crate::Error::TooLarge) beyond 2³²/3 facets or for a line of 16 MiB.
///
/// # Cost
/// One pass over the bytes; nothing is allocated on the word of a header.
///
/// ```
/// use amcheck::io::{Salvage, stl};
/// let text = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid";
/// assert_eq!(stl::read(text.as_bytes(), Salvage::Refuse)?.mesh.triangles.len(), 1);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn read(bytes: &[u8], salvage: Salvage) -> Result<Loaded> {
    let (mesh, format, notices) = match decide::kind(bytes)? {
        Kind::Text => {
            let (mesh, notices) = text::read(bytes, salvage)?;
            (mesh, "STL (ASCII)", notices)
        }
        Kind::Binary => {
            let (mesh, notices) = binary::read(bytes, salvage)?;
            (mesh, "STL (binary)", notices)
        }
    };
    let mesh = accept::with_extent(mesh, "STL")?;
    Ok(Loaded { mesh, format, unit_mm: None, notices, relative_step: RELATIVE_STEP })
}
