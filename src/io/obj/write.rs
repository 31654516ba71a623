//! Writing OBJ.

use crate::geometry::TriangleMesh;
use std::io::{Result, Write};

/// Writes a mesh as OBJ text; coordinates in as many digits as give the same f64 again.
///
/// # Errors
/// Those of `out`.
///
/// ```
/// use amcheck::io::obj;
/// let mesh = amcheck::geometry::TriangleMesh::weld([[[0.1; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
/// let mut bytes = Vec::new();
/// obj::write(&mesh, &mut bytes).unwrap();
/// assert_eq!(obj::read(&bytes)?.mesh, mesh);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> Result<()> {
    writeln!(out, "# millimetres")?;
    for [x, y, z] in &mesh.vertices {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for &[a, b, c] in &mesh.triangles {
        writeln!(out, "f {} {} {}", u64::from(a) + 1, u64::from(b) + 1, u64::from(c) + 1)?;
    }
    Ok(())
}
