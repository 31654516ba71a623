//! Writing PLY.

use crate::geometry::TriangleMesh;
use std::io::{Error, ErrorKind, Result, Write};

/// Writes a mesh as binary little-endian PLY with coordinates in f64.
///
/// # Errors
/// Those of `out`, and `InvalidInput` for more than 2³¹ vertices, which readers take for signed numbers.
///
/// ```
/// use amcheck::io::ply;
/// let mesh = amcheck::geometry::TriangleMesh::weld([[[0.1; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
/// let mut bytes = Vec::new();
/// ply::write(&mesh, &mut bytes).unwrap();
/// assert_eq!(ply::read(&bytes)?.mesh, mesh);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> Result<()> {
    if i32::try_from(mesh.vertices.len()).is_err() {
        return Err(Error::new(ErrorKind::InvalidInput, "so many vertices do not fit PLY"));
    }
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment millimetres\nelement vertex {}\nproperty double x\n\
         property double y\nproperty double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    )?;
    for x in mesh.vertices.iter().flatten() {
        out.write_all(&x.to_le_bytes())?;
    }
    for t in &mesh.triangles {
        out.write_all(&[3])?;
        for v in t {
            out.write_all(&v.to_le_bytes())?;
        }
    }
    Ok(())
}
