//! Writing binary STL.

use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;
use rustc_hash::{FxHashMap, FxHashSet};
use std::io::{Error, ErrorKind, Result, Write};

/// Writes a mesh as binary STL, in the unit of its coordinates, by `stl_io`.
///
/// Coordinates become f32; facet normals follow the winding.
///
/// # Errors
/// Those of `out`, and `InvalidInput` for more than 2³² − 1 facets or coordinates beyond f32.
///
/// ```
/// use amcheck::io::{Salvage, stl};
/// let mesh = amcheck::geometry::TriangleMesh::weld([[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
/// let mut bytes = Vec::new();
/// stl::write(&mesh, &mut bytes).unwrap();
/// assert_eq!(stl::read(&bytes, Salvage::Refuse)?.mesh, mesh);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn write(mesh: &TriangleMesh, mut out: &mut dyn Write) -> Result<()> {
    let too_much = |what: &str| Error::new(ErrorKind::InvalidInput, format!("{what} do not fit binary STL"));
    if u32::try_from(mesh.triangles.len()).is_err() {
        return Err(too_much("so many facets"));
    }
    if mesh.vertices.iter().flatten().any(|&x| !(x as f32).is_finite()) {
        return Err(too_much("coordinates beyond the range of f32"));
    }
    let single = |v: [f64; 3]| v.map(|x| x as f32);
    let facet = |f: usize| stl_io::Triangle {
        normal: stl_io::Normal::new(single(mesh.normal(f))),
        vertices: mesh.corners(f).map(|p| stl_io::Vertex::new(single(p))),
    };
    stl_io::write_stl(&mut out, (0..mesh.triangles.len()).map(facet))
}

/// How many vertices of a mesh fall on others in f32: far from the origin a written file may have facets without area and edges of more
/// than two facets for them.
///
/// # Cost
/// O(n).
///
/// ```
/// use amcheck::geometry::cuboid;
/// let far = |x: f64| amcheck::io::stl::merged(&cuboid([x, 0.0, 0.0], [x + 1e-4, 1.0, 1.0]));
/// assert_eq!((far(0.0), far(1e4)), (0, 4));
/// ```
pub fn merged(mesh: &TriangleMesh) -> usize {
    // Zero and its negative are one place; places of several vertices are as many in any format.
    let single = |v: &Vec3| v.map(|x| (x as f32 + 0.0).to_bits());
    let exact = |v: &Vec3| v.map(|x| (x + 0.0).to_bits());
    let mut first: FxHashMap<[u32; 3], &Vec3> = FxHashMap::default();
    first.reserve(mesh.vertices.len());
    let mut others: FxHashSet<[u64; 3]> = FxHashSet::default();
    for v in &mesh.vertices {
        let of = *first.entry(single(v)).or_insert(v);
        if exact(of) != exact(v) {
            others.insert(exact(v));
        }
    }
    others.len()
}
