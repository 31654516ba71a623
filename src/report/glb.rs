//! The display copy as a binary glTF: what the page's 3-D view reads, and any other viewer too.
//!
//! glTF 2.0 (ISO/IEC 12113) with `KHR_mesh_quantization`. Positions are 16-bit steps of the part's box; each map is a
//! scalar attribute (`_THIN_WALL`) of 16-bit steps of its scale, with [`UNMEASURED`] where nothing is measured; ends,
//! limits and units stand in the mesh's `extras`. Pictures only: measure on the part, not on this copy.

use super::exhibit::{Exhibit, SurfaceMap};
use super::render::colour::Scale;
use crate::check::Sense;
use crate::geometry::vector::{Vec3, bounds};
use rustc_hash::FxHashMap;
use serde_json::{Value, json};

/// Code of a corner where nothing is measured; measured values are 0 to 65534.
pub const UNMEASURED: u16 = u16::MAX;
/// Most maps in one file.
pub const MAPS: usize = 9;

/// A vertex: three coordinates, then one code for each map.
type Vertex = [u16; 3 + MAPS];

/// The exhibit as GLB bytes, corners that agree in place and in every map joined.
///
/// The mesh is in millimetres with z up; the scene's root turns it to glTF's metres with y up.
///
/// # Cost
/// O(corners), one hash look-up each.
///
/// # Limits
/// The first nine maps are written. A side of 250 mm has steps of 0.004 mm.
pub fn write(exhibit: &Exhibit) -> Vec<u8> {
    let maps: Vec<(&SurfaceMap, Scale)> = exhibit.maps.iter().take(MAPS).map(|m| (m, Scale::of(m))).collect();
    let (low, high) = bounds(exhibit.corners.iter().copied()).unwrap_or(([0.0; 3], [1.0; 3]));
    let side = [0, 1, 2].map(|a| (high[a] - low[a]).max(1e-9));
    let (vertices, indices) = joined(exhibit, &maps, low, side);
    let mut bin = Vec::with_capacity(vertices.len() * (8 + 4 * maps.len()) + indices.len() * 4);
    let mut views: Vec<Value> = Vec::new();
    let mut accessors: Vec<Value> = Vec::new();
    let mut attributes = serde_json::Map::new();
    let start = bin.len();
    vertices.iter().for_each(|v| put(&mut bin, &[v[0], v[1], v[2], 0]));
    let least = [0, 1, 2].map(|a| vertices.iter().map(|v| v[a]).min().unwrap_or(0));
    let most = [0, 1, 2].map(|a| vertices.iter().map(|v| v[a]).max().unwrap_or(0));
    views.push(view(start, bin.len(), Some(8)));
    accessors.push(json!({"bufferView": 0, "componentType": 5123, "normalized": true, "count": vertices.len(),
        "type": "VEC3", "min": least, "max": most}));
    attributes.insert("POSITION".into(), json!(0));
    let mut extras = Vec::new();
    for (k, (map, scale)) in maps.iter().enumerate() {
        let start = bin.len();
        vertices.iter().for_each(|v| put(&mut bin, &[v[3 + k], 0]));
        views.push(view(start, bin.len(), Some(4)));
        accessors.push(json!({"bufferView": k + 1, "componentType": 5123, "count": vertices.len(), "type": "SCALAR"}));
        let name = attribute(&map.check);
        attributes.insert(name.clone(), json!(k + 1));
        extras.push(described(map, scale, &name));
    }
    let start = bin.len();
    indices.iter().for_each(|i| bin.extend(i.to_le_bytes()));
    views.push(view(start, bin.len(), None));
    accessors
        .push(json!({"bufferView": views.len() - 1, "componentType": 5125, "count": indices.len(), "type": "SCALAR"}));
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let document = json!({
        "asset": {"version": "2.0", "generator": "amcheck"},
        "extensionsUsed": ["KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "scene": 0,
        "scenes": [{"nodes": [1]}],
        "nodes": [
            {"mesh": 0, "translation": low, "scale": side},
            {"children": [0], "rotation": [-half, 0.0, 0.0, half], "scale": [0.001, 0.001, 0.001]}
        ],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.7, 0.76, 0.81, 1.0], "metallicFactor": 0.0,
            "roughnessFactor": 0.8}}],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": accessors.len() - 1, "material": 0}],
            "extras": {"unmeasured": UNMEASURED, "maps": extras}}],
        "buffers": [{"byteLength": bin.len()}],
        "bufferViews": views,
        "accessors": accessors,
    });
    packed(document.to_string().into_bytes(), bin)
}

/// Vertices in the order of first use, and the triangles that use them; triangles without extent are left out.
fn joined(exhibit: &Exhibit, maps: &[(&SurfaceMap, Scale)], low: Vec3, side: Vec3) -> (Vec<Vertex>, Vec<u32>) {
    let mut known: FxHashMap<Vertex, u32> = FxHashMap::default();
    let (mut vertices, mut indices) = (Vec::new(), Vec::with_capacity(exhibit.corners.len()));
    for (f, corners) in exhibit.corners.chunks_exact(3).enumerate() {
        let mut triangle = [0u32; 3];
        for (k, p) in corners.iter().enumerate() {
            let mut vertex: Vertex = [0; 3 + MAPS];
            for a in 0..3 {
                vertex[a] = ((p[a] - low[a]) / side[a] * 65535.0).round().clamp(0.0, 65535.0) as u16;
            }
            for (m, (map, scale)) in maps.iter().enumerate() {
                vertex[3 + m] = code(map.values.get(3 * f + k).copied().unwrap_or(f32::NAN), scale);
            }
            triangle[k] = *known.entry(vertex).or_insert_with(|| {
                vertices.push(vertex);
                (vertices.len() - 1) as u32
            });
        }
        if triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0] {
            indices.extend(triangle);
        }
    }
    (vertices, indices)
}

/// The step of a map's scale that a value falls on.
fn code(value: f32, scale: &Scale) -> u16 {
    if !value.is_finite() {
        return if value == f32::INFINITY { UNMEASURED - 1 } else { UNMEASURED };
    }
    let share = (f64::from(value) - scale.low) / (scale.high - scale.low);
    (share * 65534.0).round().clamp(0.0, 65534.0) as u16
}

/// The attribute of a check: letters, digits and underscores, as glTF asks of attributes of one's own.
fn attribute(check: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() } else { '_' };
    format!("_{}", check.chars().map(plain).collect::<String>())
}

/// What a reader needs to know about a map.
fn described(map: &SurfaceMap, scale: &Scale, name: &str) -> Value {
    json!({
        "attribute": name, "check": map.check, "title": map.title, "unit": map.unit, "low": scale.low, "high": scale.high,
        "fail": scale.fail, "warn": scale.warn, "sense": if map.sense == Sense::Max { "max" } else { "min" },
    })
}

fn put(bin: &mut Vec<u8>, words: &[u16]) {
    words.iter().for_each(|w| bin.extend(w.to_le_bytes()));
}

/// A stretch of the buffer: vertices have a stride, indices none.
fn view(from: usize, to: usize, stride: Option<usize>) -> Value {
    match stride {
        Some(stride) => {
            json!({"buffer": 0, "byteOffset": from, "byteLength": to - from, "byteStride": stride, "target": 34962})
        }
        None => json!({"buffer": 0, "byteOffset": from, "byteLength": to - from, "target": 34963}),
    }
}

/// Header and the two chunks, each padded to four bytes.
fn packed(mut text: Vec<u8>, mut bin: Vec<u8>) -> Vec<u8> {
    text.resize(text.len().next_multiple_of(4), b' ');
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut out = Vec::with_capacity(28 + text.len() + bin.len());
    out.extend(b"glTF");
    out.extend(2u32.to_le_bytes());
    out.extend(((28 + text.len() + bin.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &bin)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_joined_only_where_every_map_agrees() {
        let square =
            [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]];
        let mut exhibit = Exhibit { corners: square.to_vec(), ..Exhibit::default() };
        let count = |e: &Exhibit| {
            let bytes = write(e);
            let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
            assert_eq!(bytes.len(), u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize);
            let document: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
            document["accessors"][0]["count"].as_u64().unwrap()
        };
        assert_eq!(count(&exhibit), 4);
        let text = String::new;
        let values = vec![1.0, 1.0, 1.0, f32::NAN, 2.0, 2.0];
        let (fail, warn) = (Some(1.0), None);
        let sense = Sense::Min;
        exhibit.maps = vec![SurfaceMap {
            check: "a-b".into(),
            title: text(),
            unit: text(),
            sense,
            fail,
            warn,
            open_end: 4.0,
            values,
        }];
        assert_eq!(count(&exhibit), 6);
    }

    #[test]
    fn codes_span_the_scale_and_say_what_is_not_measured() {
        let scale = Scale { low: 0.0, high: 4.0, fail: None, warn: None, sense: Sense::Min };
        assert_eq!(
            [0.0, 2.0, 4.0, 9.0, f32::NAN, f32::INFINITY].map(|v| code(v, &scale)),
            [0, 32767, 65534, 65534, UNMEASURED, 65534]
        );
    }
}
