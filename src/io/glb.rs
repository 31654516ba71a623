//! Binary glTF 2.0: a mesh for viewers, with colours and measured values at its vertices.

use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, add, scale, sub};
use serde_json::{Value, json};
use std::io::{Error, ErrorKind, Result, Write};

/// One number for every vertex, shown by viewers that know its name.
#[derive(Debug, Clone, Copy)]
pub struct Attribute<'a> {
    /// The name, such as `thickness_mm`; written as glTF wants its own names: `_THICKNESS_MM`.
    pub name: &'a str,
    /// One value for each vertex.
    pub values: &'a [f32],
}

/// A mesh with what is known at its vertices.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The surface, millimetres.
    pub mesh: &'a TriangleMesh,
    /// One colour for each vertex in linear RGB, 0 to 1 (not sRGB), or none.
    pub colours: Option<&'a [[f32; 3]]>,
    /// Further values.
    pub attributes: &'a [Attribute<'a>],
}

/// Component type of glTF: 32-bit float.
const FLOAT: u32 = 5126;
/// Component type of glTF: unsigned 32-bit whole number.
const UNSIGNED: u32 = 5125;
/// Bytes of the file's head and of the heads of its two chunks.
const HEADS: usize = 12 + 8 + 8;

/// Writes a scene as GLB: metres, y up, as glTF fixes it; millimetre (x, y, z) becomes (x, z, −y)/1000.
///
/// Positions are stored about the middle of the part, which stands in the node, so that a far origin costs no
/// digits of f32.
///
/// # Errors
/// Those of `out`, and `InvalidInput` for colours or attributes of another number than the vertices, values
/// that are not finite (glTF forbids them), and 4 GiB or more.
pub fn write(scene: &Scene<'_>, out: &mut dyn Write) -> Result<()> {
    let mut buffer = Buffer::default();
    let vertices = scene.mesh.vertices.len();
    let middle = scene.mesh.bounds().map_or([0.0; 3], |(lo, hi)| scale(add(lo, hi), 0.5));
    let positions: Vec<[f32; 3]> =
        scene.mesh.vertices.iter().map(|&p| metres(sub(p, middle)).map(|x| x as f32)).collect();
    let mut attributes = serde_json::Map::new();
    let position = buffer.floats(positions.iter().flatten().copied(), vertices, "VEC3")?;
    buffer.set_range(&positions);
    attributes.insert("POSITION".into(), position.into());
    if let Some(colours) = scene.colours {
        same_number("colours", colours.len(), vertices)?;
        let at = buffer.floats(colours.iter().flatten().copied(), vertices, "VEC3")?;
        attributes.insert("COLOR_0".into(), at.into());
    }
    for attribute in scene.attributes {
        same_number(attribute.name, attribute.values.len(), vertices)?;
        let at = buffer.floats(attribute.values.iter().copied(), vertices, "SCALAR")?;
        attributes.insert(format!("_{}", attribute.name.trim_start_matches('_').to_uppercase()), at.into());
    }
    let indices = buffer.indices(&scene.mesh.triangles);
    let text = json!({
        "asset": { "version": "2.0", "generator": "amcheck" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "translation": metres(middle) }],
        "meshes": [{ "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }] }],
        "materials": [{
            "doubleSided": true,
            "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.8 }
        }],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{ "byteLength": buffer.bytes.len() }],
    });
    chunks(text.to_string().into_bytes(), buffer.bytes, out)
}

/// Millimetres with z up as metres with y up.
fn metres([x, y, z]: Vec3) -> Vec3 {
    [x, z, -y].map(|v| v / 1000.0 + 0.0)
}

fn same_number(name: &str, found: usize, vertices: usize) -> Result<()> {
    if found == vertices {
        return Ok(());
    }
    Err(Error::new(ErrorKind::InvalidInput, format!("{found} {name} for {vertices} vertices")))
}

/// The two chunks, each padded to four bytes: JSON with spaces, data with zeros.
fn chunks(mut text: Vec<u8>, mut bytes: Vec<u8>, out: &mut dyn Write) -> Result<()> {
    text.resize(text.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let length = |n: usize| u32::try_from(n).map_err(|_| Error::new(ErrorKind::InvalidInput, "GLB ends at 4 GiB"));
    let whole = length(HEADS + text.len() + bytes.len())?;
    out.write_all(b"glTF")?;
    out.write_all(&2u32.to_le_bytes())?;
    out.write_all(&whole.to_le_bytes())?;
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", bytes)] {
        out.write_all(&length(chunk.len())?.to_le_bytes())?;
        out.write_all(kind)?;
        out.write_all(&chunk)?;
    }
    Ok(())
}

/// The data chunk with its table of contents.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds floats; the number of their accessor.
    fn floats(&mut self, values: impl Iterator<Item = f32>, count: usize, kind: &str) -> Result<usize> {
        let start = self.bytes.len();
        for value in values {
            if !value.is_finite() {
                return Err(Error::new(ErrorKind::InvalidInput, format!("{value} cannot be written as glTF")));
            }
            self.bytes.extend_from_slice(&value.to_le_bytes());
        }
        Ok(self.accessor(start, 34962, FLOAT, count, kind))
    }

    fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(triangles.iter().flatten().flat_map(|v| v.to_le_bytes()));
        self.accessor(start, 34963, UNSIGNED, 3 * triangles.len(), "SCALAR")
    }

    fn accessor(&mut self, start: usize, target: u32, component: u32, count: usize, kind: &str) -> usize {
        let view = self.views.len();
        self.views.push(
            json!({ "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start, "target": target }),
        );
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    /// Least and greatest of the positions, which glTF demands, as the f32 that were written.
    fn set_range(&mut self, positions: &[[f32; 3]]) {
        let fold = |pick: fn(f32, f32) -> f32, start: f32| {
            positions.iter().fold([start; 3], |[a, b, c], &[x, y, z]| [pick(a, x), pick(b, y), pick(c, z)])
        };
        if let (Some(Value::Object(accessor)), false) = (self.accessors.last_mut(), positions.is_empty()) {
            accessor.insert("min".into(), json!(fold(f32::min, f32::INFINITY)));
            accessor.insert("max".into(), json!(fold(f32::max, f32::NEG_INFINITY)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> TriangleMesh {
        TriangleMesh::weld([[[1000.0, 0.0, 0.0], [1002.0, 0.0, 0.0], [1000.0, 4.0, 6.0]]])
    }

    fn parts(bytes: &[u8]) -> (Value, Vec<u8>) {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
        let text = word(12);
        assert_eq!((text % 4, &bytes[16..20], &bytes[24 + text..28 + text]), (0, &b"JSON"[..], &b"BIN\0"[..]));
        let data = bytes[28 + text..].to_vec();
        assert_eq!((word(20 + text), data.len() % 4), (data.len(), 0));
        (serde_json::from_slice(&bytes[20..20 + text]).unwrap(), data)
    }

    #[test]
    fn positions_are_metres_with_y_up_about_the_middle() {
        let mut bytes = Vec::new();
        let (mesh, values) = (mesh(), [0.1f32, 0.2, 0.3]);
        let colours = [[1.0f32, 0.0, 0.5]; 3];
        let attributes = [Attribute { name: "thickness_mm", values: &values }];
        write(&Scene { mesh: &mesh, colours: Some(&colours), attributes: &attributes }, &mut bytes).unwrap();
        let (json, data) = parts(&bytes);
        assert_eq!(json["nodes"][0]["translation"], json!([1.001, 0.003, -0.002]));
        assert_eq!(json["accessors"][0]["max"], json!([0.001f32, 0.003f32, 0.002f32]));
        let names = json["meshes"][0]["primitives"][0]["attributes"].as_object().unwrap();
        assert_eq!(names.keys().collect::<Vec<_>>(), ["COLOR_0", "POSITION", "_THICKNESS_MM"]);
        assert_eq!(json["buffers"][0]["byteLength"], 3 * (12 + 12 + 4 + 4));
        let float = |at: usize| f32::from_le_bytes(data[at..at + 4].try_into().unwrap());
        // The third vertex: y = 4 mm is 2 mm from the middle, and becomes −z.
        assert_eq!([float(24), float(28), float(32)], [-0.001, 0.003, -0.002]);
        assert_eq!(float(72), 0.1);
    }

    #[test]
    fn what_gltf_forbids_is_refused() {
        let mesh = mesh();
        let mut out = Vec::new();
        let nan = [Attribute { name: "x", values: &[f32::NAN, 0.0, 0.0] }];
        assert!(write(&Scene { mesh: &mesh, colours: None, attributes: &nan }, &mut out).is_err());
        let short = [Attribute { name: "x", values: &[0.0] }];
        assert!(write(&Scene { mesh: &mesh, colours: None, attributes: &short }, &mut out).is_err());
        assert!(out.is_empty());
    }
}
