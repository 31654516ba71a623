//! Small good files of every format: two cubes, one with a cavity.

use amcheck::geometry::TriangleMesh;
use amcheck::io::{obj, ply, stl, threemf};
use std::io::Write;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

pub const MODEL: &str = "3D/3dmodel.model";
pub const RELATIONS: &str = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;

/// An axis-aligned cube, its facets outward.
pub fn cube(low: f64, edge: f64) -> TriangleMesh {
    let corner = |i: usize| [0, 1, 2].map(|a| low + if i >> a & 1 == 1 { edge } else { 0.0 });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    TriangleMesh::weld(quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|t| t.map(corner)))
}

/// A cube with a cavity, and another beside it.
pub fn mesh() -> TriangleMesh {
    cube(0.0, 10.0).joined(&cube(2.5, 5.0).flipped()).joined(&cube(20.0, 8.125))
}

pub fn stl_binary() -> Vec<u8> {
    let mut out = Vec::new();
    stl::write(&mesh(), &mut out).unwrap();
    out
}

pub fn stl_text() -> Vec<u8> {
    let mesh = mesh();
    let mut out = b"solid two cubes\n".to_vec();
    for f in 0..mesh.triangles.len() {
        let [x, y, z] = mesh.normal(f);
        write!(out, "  facet normal {x} {y} {z}\n    outer loop\n").unwrap();
        for [x, y, z] in mesh.corners(f) {
            writeln!(out, "      vertex {x:e} {y} {z}").unwrap();
        }
        write!(out, "    endloop\n  endfacet\n").unwrap();
    }
    out.extend_from_slice(b"endsolid two cubes\n");
    out
}

pub fn obj_text() -> Vec<u8> {
    let mut out = b"mtllib part.mtl\no part\n".to_vec();
    obj::write(&mesh(), &mut out).unwrap();
    out.extend_from_slice(b"v 30 0 0\nv 31 0 0\nv 31 1 0\nv 30.2 0.5 0\nv 30 1 0\nf -5 -4 -3 -2 -1\nl 1 2\n");
    out
}

pub fn ply_binary() -> Vec<u8> {
    let mut out = Vec::new();
    ply::write(&mesh(), &mut out).unwrap();
    out
}

pub fn ply_text() -> Vec<u8> {
    let mesh = mesh();
    let mut out = format!(
        "ply\nformat ascii 1.0\ncomment cubes\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    mesh.vertices.iter().for_each(|[x, y, z]| writeln!(out, "{x} {y} {z} 7").unwrap());
    mesh.triangles.iter().for_each(|[a, b, c]| writeln!(out, "3 {a} {b} {c}").unwrap());
    out
}

pub fn threemf_package() -> Vec<u8> {
    let mut out = Vec::new();
    threemf::write(&mesh(), &mut out).unwrap();
    out
}

/// A package of parts as they are given; deflated.
pub fn package(parts: &[(&str, &[u8])]) -> Vec<u8> {
    zipped(parts, CompressionMethod::Deflated)
}

/// A package whose parts stand in it as they are.
pub fn stored(parts: &[(&str, &[u8])]) -> Vec<u8> {
    zipped(parts, CompressionMethod::Stored)
}

fn zipped(parts: &[(&str, &[u8])], method: CompressionMethod) -> Vec<u8> {
    let options = SimpleFileOptions::default().compression_method(method);
    let mut archive = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in parts {
        archive.start_file(*name, options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A package with this model part.
pub fn with_model(model: &str) -> Vec<u8> {
    package(&[("_rels/.rels", RELATIONS.as_bytes()), (MODEL, model.as_bytes())])
}

/// A model part with these resources beside a tetrahedron as object 1, and this build.
pub fn model(attributes: &str, resources: &str, build: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<model {attributes} xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n<resources>\n{TETRAHEDRON}\n{resources}\n</resources>\n<build>\n{build}\n</build>\n</model>\n"
    )
}

pub const TETRAHEDRON: &str = r#"<object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="6" y="0" z="0"/><vertex x="0" y="6" z="0"/><vertex x="0" y="0" z="6"/></vertices><triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="1" v2="2" v3="3"/><triangle v1="0" v2="3" v3="2"/></triangles></mesh></object>"#;
