//! Closed meshes of plain solids: boxes, prisms and solids of revolution.

use super::mesh::TriangleMesh;
use super::vector::Vec3;

/// The box between its least and its greatest corner.
///
/// ```
/// let plate = amcheck::geometry::cuboid([0.0; 3], [4.0, 3.0, 0.5]);
/// assert_eq!(plate.signed_volume(), 6.0);
/// ```
pub fn cuboid(lo: Vec3, hi: Vec3) -> TriangleMesh {
    let corner = |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 1 { hi[a] } else { lo[a] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    TriangleMesh::weld(
        quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|t: [usize; 3]| t.map(corner)),
    )
}

/// The prism over a closed outline in x–z along y from 0 to `depth`; `caps` are the triangles of the outline's corners that
/// fill it. The sense of the outline does not matter.
pub fn extruded(outline: &[[f64; 2]], caps: &[[usize; 3]], depth: f64) -> TriangleMesh {
    let at = |i: usize, y: f64| outline.get(i).map_or([0.0; 3], |p| [p[0], y, p[1]]);
    let mut facets = Vec::new();
    for i in 0..outline.len() {
        let j = (i + 1) % outline.len();
        facets.push([at(i, 0.0), at(j, 0.0), at(j, depth)]);
        facets.push([at(i, 0.0), at(j, depth), at(i, depth)]);
    }
    for &[a, b, c] in caps {
        facets.push([at(a, 0.0), at(c, 0.0), at(b, 0.0)]);
        facets.push([at(a, depth), at(b, depth), at(c, depth)]);
    }
    outward(TriangleMesh::weld(facets))
}

/// The solid that a closed outline in (r, z) sweeps about the z axis, in `sides` steps; points with r = 0 lie on the axis. The
/// corners lie on the true circles. The sense of the outline does not matter.
///
/// ```
/// let cone = amcheck::geometry::revolved(&[[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]], 360);
/// assert!((cone.signed_volume() / (std::f64::consts::PI * 12.0) - 1.0).abs() < 1e-4);
/// ```
pub fn revolved(outline: &[[f64; 2]], sides: usize) -> TriangleMesh {
    let at = |[r, z]: [f64; 2], s: usize| {
        let (sine, cosine) = (std::f64::consts::TAU * (s % sides) as f64 / sides as f64).sin_cos();
        [r * cosine, r * sine, z]
    };
    let mut facets = Vec::new();
    for (&p, &q) in outline.iter().zip(outline.iter().cycle().skip(1)) {
        for s in 0..sides {
            if q[0] > 0.0 {
                facets.push([at(p, s), at(q, s + 1), at(q, s)]);
            }
            if p[0] > 0.0 {
                facets.push([at(p, s), at(p, s + 1), at(q, s + 1)]);
            }
        }
    }
    outward(TriangleMesh::weld(facets))
}

/// The mesh, its facets turned if they enclose less than nothing.
fn outward(mesh: TriangleMesh) -> TriangleMesh {
    if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh }
}
