//! The display copy as a binary glTF: what the page's 3-D view reads, and any other viewer too.
//!
//! glTF 2.0 (ISO/IEC 12113) with `KHR_mesh_quantization`. Positions are 16-bit steps of the part's box; each map is a
//! scalar attribute (`_THIN_WALL`) of 16-bit steps of its scale, with [`UNMEASURED`] where nothing is measured; ends,
//! limits and units stand in the mesh's `extras`. Pictures only: measure on the part, not on this copy.

use super::exhibit::{Exhibit, SurfaceMap};
use super::joined::Points;
use super::render::colour::Scale;
use crate::check::Sense;
use crate::geometry::vector::{Vec3, bounds};
use crate::medial::Side;
use serde_json::{Value, json};

/// Code of a corner where nothing is measured; measured values are 0 to 65534.
pub const UNMEASURED: u16 = u16::MAX;
/// Most maps in one file.
pub const MAPS: usize = 12;

/// Corners that a coarse copy joins stand at their mean, in steps so many times finer than those that join them: round faces stay smooth.
const FINER: f64 = 8.0;

/// A vertex: three coordinates, then one code for each map.
pub(super) type Vertex = [u16; 3 + MAPS];

/// How fine a copy is: steps along the longest side of the box, and steps of each map's scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Detail {
    pub cells: u32,
    pub codes: u32,
}

impl Detail {
    /// As fine as the format allows.
    pub const FULL: Detail = Detail { cells: 65535, codes: 65534 };
}

/// Least corner and sides of the box that positions are steps of, and how many steps are used.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    low: Vec3,
    side: Vec3,
    detail: Detail,
    /// Steps along each side.
    used: Vec3,
}

impl Frame {
    pub(super) fn new(low: Vec3, side: Vec3, detail: Detail) -> Self {
        let longest = side.iter().copied().fold(0.0, f64::max);
        let used = side.map(|side| (f64::from(detail.cells) * side / longest).ceil().clamp(1.0, 65535.0));
        Frame { low, side, detail, used }
    }

    /// How fine the copy is.
    pub(super) fn detail(&self) -> Detail {
        self.detail
    }

    /// The step of a coordinate, 0 to 65535; in a coarse copy only some steps are used.
    #[inline]
    pub(super) fn step(&self, x: f64, axis: usize) -> u16 {
        self.step_of(x, axis, self.used[axis])
    }

    /// The step of the mean of coordinates that fall on one step: [`FINER`] times as fine.
    #[inline]
    pub(super) fn fine_step(&self, x: f64, axis: usize) -> u16 {
        self.step_of(x, axis, (FINER * self.used[axis]).min(65535.0))
    }

    #[inline]
    fn step_of(&self, x: f64, axis: usize, used: f64) -> u16 {
        let share = (x - self.low[axis]) / self.side[axis];
        rounded(rounded(share * used) / used * 65535.0).clamp(0.0, 65535.0) as u16
    }

    /// The step of a value on its scale.
    #[inline]
    pub(super) fn code(&self, value: f32, scale: &Scale) -> u16 {
        if !value.is_finite() {
            return if value == f32::INFINITY { UNMEASURED - 1 } else { UNMEASURED };
        }
        let share = (f64::from(value) - scale.low) / (scale.high - scale.low);
        let used = f64::from(self.detail.codes.clamp(1, 65534));
        rounded(rounded(share * used) / used * 65534.0).clamp(0.0, 65534.0) as u16
    }
}

/// `f64::round` for what is less than 2⁵³ and anything as large for what is more, without a call of the system's library.
#[inline]
fn rounded(x: f64) -> f64 {
    let whole = x as i64 as f64;
    let rest = x - whole;
    if rest >= 0.5 {
        whole + 1.0
    } else if rest <= -0.5 {
        whole - 1.0
    } else {
        whole
    }
}

/// The exhibit as GLB bytes, as fine as the format allows; see [`write_at`].
pub fn write(exhibit: &Exhibit) -> Vec<u8> {
    write_at(exhibit, Detail::FULL, Some(Detail::FULL))
}

/// The exhibit as GLB bytes, corners that agree in place and in every map joined.
///
/// The first mesh is the part, the others are its layers. Meshes are in millimetres with z up; the scene's root turns
/// them to glTF's metres with y up.
///
/// # Cost
/// O(corners), one hash look-up each.
///
/// A coarser `detail`, or one of the layers, joins the corners that fall on one of fewer steps at their mean and drops the facets that vanish
/// (vertex clustering, Rossignac & Borrel 1993); without a detail for them the layers are left out.
///
/// # Limits
/// The first twelve maps are written. At full detail a side of 250 mm has steps of 0.004 mm. Of a very large part this is the
/// exhibit's coarser copy; the mesh's `extras` say how many facets are left out and within how many millimetres.
pub fn write_at(exhibit: &Exhibit, detail: Detail, layers: Option<Detail>) -> Vec<u8> {
    Copy::of(&Source::of(exhibit), detail).with(layers)
}

/// What copies of an exhibit of any detail have in common.
pub struct Source<'a> {
    exhibit: &'a Exhibit,
    maps: Vec<(&'a SurfaceMap, Scale)>,
    /// Least corner and sides of the box of part and layers.
    frame: (Vec3, Vec3),
    part: Points,
    layers: Vec<Points>,
}

impl<'a> Source<'a> {
    /// The exhibit made ready.
    pub fn of(exhibit: &'a Exhibit) -> Self {
        let all = exhibit.layers.iter().flat_map(|l| &l.corners).chain(&exhibit.corners);
        let (low, high) = bounds(all.copied()).unwrap_or(([0.0; 3], [1.0; 3]));
        Source {
            exhibit,
            maps: exhibit.maps.iter().take(MAPS).map(|m| (m, Scale::of(m))).collect(),
            frame: (low, [0, 1, 2].map(|a| (high[a] - low[a]).max(1e-9))),
            part: Points::of(&exhibit.corners),
            layers: exhibit.layers.iter().map(|l| Points::of(&l.corners)).collect(),
        }
    }
}

/// A copy of the part, to which layers of any detail are added.
pub struct Copy<'a> {
    source: &'a Source<'a>,
    frame: Frame,
    part: Builder,
    mesh: Value,
}

impl<'a> Copy<'a> {
    /// The part as fine as wanted.
    pub fn of(source: &'a Source, detail: Detail) -> Self {
        let frame = Frame::new(source.frame.0, source.frame.1, detail);
        let mut part = Builder::default();
        let shape = part.primitive(&source.part, &source.maps, frame, 0);
        let described: Vec<Value> =
            source.maps.iter().map(|(m, scale)| described(m, scale, &attribute(&m.check))).collect();
        let left_out = source.exhibit.coarsened;
        let coarse = detail != Detail::FULL || left_out.is_some();
        let mut extras = json!({"unmeasured": UNMEASURED, "coarse": coarse, "maps": described});
        if let Some(copy) = left_out {
            extras["facets_left_out"] = json!(copy.facets_left_out);
            extras["within_mm"] = json!(copy.within_mm);
        }
        let mesh = json!({"primitives": [shape], "extras": extras});
        Copy { source, frame, part, mesh }
    }

    /// The bytes of the copy with its layers, or without them.
    pub fn with(&self, layers: Option<Detail>) -> Vec<u8> {
        let (mut to, mut meshes) = (self.part.clone(), vec![self.mesh.clone()]);
        let all = || self.source.exhibit.layers.iter().zip(&self.source.layers);
        let drawn = layers.iter().flat_map(|d| all().map(move |l| (*d, l)));
        for (detail, (layer, points)) in drawn.filter(|(_, (l, _))| l.corners.len() >= 3) {
            let frame = Frame::new(self.frame.low, self.frame.side, detail);
            let shape = to.primitive(points, &[], frame, 1);
            meshes.push(json!({"name": layer.name, "primitives": [shape], "extras": {"title": layer.title}}));
        }
        let document = document(meshes, &to, &self.frame);
        packed(document.to_string().into_bytes(), to.bin)
    }
}

/// What the file says of its meshes.
fn document(meshes: Vec<Value>, to: &Builder, frame: &Frame) -> Value {
    let mut nodes: Vec<Value> =
        (0..meshes.len()).map(|m| json!({"mesh": m, "translation": frame.low, "scale": frame.side})).collect();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let children: Vec<usize> = (0..nodes.len()).collect();
    nodes.push(json!({"children": children, "rotation": [-half, 0.0, 0.0, half], "scale": [0.001, 0.001, 0.001]}));
    let material = |colour: [f64; 4], mode: &str| json!({"alphaMode": mode, "pbrMetallicRoughness": {"baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 0.8}});
    json!({
        "asset": {"version": "2.0", "generator": "amcheck"},
        "extensionsUsed": ["KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "scene": 0,
        "scenes": [{"nodes": [nodes.len() - 1]}],
        "nodes": nodes,
        "materials": [material([0.7, 0.76, 0.81, 1.0], "OPAQUE"), material([0.3, 0.35, 0.8, 0.5], "BLEND")],
        "meshes": meshes,
        "buffers": [{"byteLength": to.bin.len()}],
        "bufferViews": to.views,
        "accessors": to.accessors,
    })
}

/// The binary chunk in the making, and what describes it.
#[derive(Clone, Default)]
struct Builder {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Builder {
    /// Writes facets and their maps; returns the primitive that draws them.
    fn primitive(&mut self, points: &Points, maps: &[(&SurfaceMap, Scale)], frame: Frame, material: usize) -> Value {
        let (vertices, indices) = points.joined(maps, frame);
        let mut attributes = serde_json::Map::new();
        let start = self.bin.len();
        vertices.iter().for_each(|v| put(&mut self.bin, &[v[0], v[1], v[2], 0]));
        let least = [0, 1, 2].map(|a| vertices.iter().map(|v| v[a]).min().unwrap_or(0));
        let most = [0, 1, 2].map(|a| vertices.iter().map(|v| v[a]).max().unwrap_or(0));
        let position = self.accessor(
            start,
            Some(8),
            json!({"componentType": 5123, "normalized": true,
            "count": vertices.len(), "type": "VEC3", "min": least, "max": most}),
        );
        attributes.insert("POSITION".into(), json!(position));
        for (k, (map, _)) in maps.iter().enumerate() {
            let start = self.bin.len();
            vertices.iter().for_each(|v| put(&mut self.bin, &[v[3 + k], 0]));
            let scalar = json!({"componentType": 5123, "count": vertices.len(), "type": "SCALAR"});
            attributes.insert(attribute(&map.check), json!(self.accessor(start, Some(4), scalar)));
        }
        let start = self.bin.len();
        indices.iter().for_each(|i| self.bin.extend(i.to_le_bytes()));
        let order =
            self.accessor(start, None, json!({"componentType": 5125, "count": indices.len(), "type": "SCALAR"}));
        json!({"attributes": attributes, "indices": order, "material": material})
    }

    /// Describes what was written since `start`: vertices have a stride, indices none. Returns the accessor.
    fn accessor(&mut self, start: usize, stride: Option<usize>, mut accessor: Value) -> usize {
        let mut view = json!({"buffer": 0, "byteOffset": start, "byteLength": self.bin.len() - start,
            "target": if stride.is_some() { 34962 } else { 34963 }});
        if let Some(stride) = stride {
            view["byteStride"] = json!(stride);
        }
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
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
        "fills": map.fills.map(|side| if side == Side::Material { "material" } else { "void" }),
    })
}

fn put(bin: &mut Vec<u8>, words: &[u16]) {
    words.iter().for_each(|w| bin.extend(w.to_le_bytes()));
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
            fills: None,
            values,
        }];
        assert_eq!(count(&exhibit), 6);
    }

    #[test]
    fn codes_span_the_scale_and_say_what_is_not_measured() {
        let scale = Scale { low: 0.0, high: 4.0, fail: None, warn: None, sense: Sense::Min };
        let frame = Frame::new([0.0; 3], [10.0, 5.0, 1.0], Detail::FULL);
        assert_eq!(
            [0.0, 2.0, 4.0, 9.0, f32::NAN, f32::INFINITY].map(|v| frame.code(v, &scale)),
            [0, 32767, 65534, 65534, UNMEASURED, 65534]
        );
        let coarse = Frame::new(frame.low, frame.side, Detail { cells: 10, codes: 4 });
        assert_eq!([0.0, 0.4, 0.6, 10.0].map(|x| coarse.step(x, 0)), [0, 0, 6554, 65535]);
        assert_eq!([0.0, 0.6, 5.0].map(|x| coarse.step(x, 1)), [0, 13107, 65535]);
        assert_eq!([0.1, 1.1, 4.0].map(|v| coarse.code(v, &scale)), [0, 16384, 65534]);
    }

    #[test]
    fn rounding_is_that_of_the_library() {
        let mut random = crate::random::Lcg(3);
        let near = |x: f64| [x, x.next_up(), x.next_down(), -x, -x.next_up(), -x.next_down()];
        let some = (0..2000).flat_map(|n| near(0.5 * f64::from(n)));
        for x in some.chain((0..2000).map(|_| random.point(-1e6, 1e6)[0])).chain([0.0, -0.0, 1e18, -1e18]) {
            assert_eq!(rounded(x), x.round(), "{x}");
        }
        assert!(rounded(1e300) > 65535.0 && rounded(-1e300) < 0.0);
    }
}
