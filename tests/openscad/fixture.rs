//! The fixtures: sources, committed outputs, and what is known of them.

use amcheck::geometry::TriangleMesh;
use amcheck::geometry::vector::{Vec3, sub};
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What `R` is made of `A` and `B`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Operation {
    Sum,
    Obstacle,
    Difference,
    Opening,
    Closing,
    Sweep,
    Reachable,
}

/// A fixture by name, with its operation and, where there is one, its volume in closed form.
pub struct Fixture {
    pub name: &'static str,
    pub operation: Operation,
    pub closed_form_mm3: Option<f64>,
}

const fn fixture(name: &'static str, operation: Operation, closed_form_mm3: Option<f64>) -> Fixture {
    Fixture { name, operation, closed_form_mm3 }
}

pub const FIXTURES: [Fixture; 18] = [
    fixture("f01_box_box", Operation::Sum, Some(234.0)),
    fixture("f02_box_ball", Operation::Sum, None),
    fixture("f03_L_tetra", Operation::Sum, None),
    fixture("f04_L_tetra_obstacle", Operation::Obstacle, Some(673.0)),
    fixture("f05_erode_tetra", Operation::Difference, Some(441.0 + 1.0 / 12.0)),
    fixture("f06_open_ball", Operation::Opening, None),
    fixture("f07_close_cone", Operation::Closing, None),
    fixture("f08_sweep", Operation::Sweep, None),
    fixture("f09_U_U", Operation::Sum, None),
    fixture("f10_hole_cylinder", Operation::Sum, None),
    fixture("f11_cavity", Operation::Sum, Some(1284.25)),
    fixture("f12_thin_plate", Operation::Sum, None),
    fixture("f13_star_cone", Operation::Sum, None),
    fixture("f14_torus_ball", Operation::Sum, None),
    fixture("f15_access", Operation::Reachable, None),
    fixture("f16_edge_touch", Operation::Sum, Some(367.75)),
    fixture("f17_erode_empty", Operation::Difference, Some(0.0)),
    fixture("f18_ball_ball", Operation::Sum, None),
];

/// The polyline of `f08_sweep`, as in its source.
pub const SWEEP_PATH: [Vec3; 4] = [[0.0, 0.0, 0.0], [8.0, 1.0, 0.0], [10.0, 7.0, 2.0], [4.0, 9.0, 5.0]];
/// The window of `f15_access`, as in its source.
pub const ACCESS_WINDOW: [Vec3; 2] = [[-3.0, -3.0, -3.0], [17.0, 15.0, 14.0]];
/// The parts that each source renders.
pub const PARTS: [&str; 3] = ["A", "B", "R"];

/// What is measured on one output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    pub volume_mm3: f64,
    pub area_mm2: f64,
    pub box_mm: [Vec3; 2],
    pub facets: usize,
    pub euler: i64,
}

impl Measured {
    pub fn of(mesh: &TriangleMesh) -> Self {
        let (lo, hi) = mesh.bounds().unwrap_or_default();
        Measured {
            volume_mm3: mesh.signed_volume(),
            area_mm2: mesh.area(),
            box_mm: [lo, hi],
            facets: mesh.triangles.len(),
            euler: euler(mesh),
        }
    }
}

/// One fixture as it was rendered; an empty result has no `r`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    pub name: String,
    pub operation: Operation,
    pub source_sha256: String,
    pub a: Measured,
    pub b: Measured,
    pub r: Option<Measured>,
    /// User seconds of rendering R, for the comparison of speeds; not compared by any test.
    pub seconds: f64,
}

/// `reference.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    pub openscad: String,
    pub fixtures: Vec<Entry>,
}

pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/openscad")
}

pub fn source(name: &str) -> PathBuf {
    folder().join(format!("{name}.scad"))
}

pub fn stl(folder: &Path, name: &str, part: &str) -> PathBuf {
    folder.join(format!("{name}_{part}.stl"))
}

pub fn reference() -> Reference {
    let text = std::fs::read_to_string(folder().join("reference.json")).expect("fixtures/openscad/reference.json");
    serde_json::from_str(&text).expect("reference.json is of the known form")
}

pub fn sha256(path: &Path) -> String {
    use sha2::{Digest, Sha256};
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// A binary STL as written by OpenSCAD: 80 bytes, a count, 50 bytes a facet.
pub fn load(path: &Path) -> TriangleMesh {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    assert_eq!(bytes.len(), 84 + 50 * count, "{}", path.display());
    let number = |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    TriangleMesh::weld(
        (0..count)
            .map(|f| [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| number(84 + 50 * f + 12 + 12 * corner + 4 * axis)))),
    )
}

/// Directed edges that no facet runs the other way: none in a closed mesh.
pub fn open_edges(mesh: &TriangleMesh) -> usize {
    let mut edges: FxHashMap<[u32; 2], i64> = FxHashMap::default();
    for &[a, b, c] in &mesh.triangles {
        for [s, e] in [[a, b], [b, c], [c, a]] {
            *edges.entry([s.min(e), s.max(e)]).or_default() += if s < e { 1 } else { -1 };
        }
    }
    edges.values().filter(|&&n| n != 0).count()
}

/// V − E + F.
fn euler(mesh: &TriangleMesh) -> i64 {
    let mut edges: Vec<[u32; 2]> = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[s, e]| [s.min(e), s.max(e)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    mesh.vertices.len() as i64 - edges.len() as i64 + mesh.triangles.len() as i64
}

/// The least distance from a point to the facets of a mesh: nearest point of each triangle, plainly.
pub fn distance_to(mesh: &TriangleMesh, p: Vec3) -> f64 {
    use amcheck::geometry::vector::{cross, dot, norm};
    let to_segment = |a: Vec3, b: Vec3| {
        let (d, v) = (sub(b, a), sub(p, a));
        let t = if dot(d, d) > 0.0 { (dot(v, d) / dot(d, d)).clamp(0.0, 1.0) } else { 0.0 };
        norm([0, 1, 2].map(|i| v[i] - t * d[i]))
    };
    (0..mesh.triangles.len())
        .map(|facet| {
            let [a, b, c] = mesh.corners(facet);
            let n = cross(sub(b, a), sub(c, a));
            let over = [[a, b], [b, c], [c, a]].iter().all(|&[s, e]| dot(cross(sub(e, s), sub(p, s)), n) >= 0.0);
            if over && dot(n, n) > 0.0 {
                (dot(sub(p, a), n) / norm(n)).abs()
            } else {
                to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a))
            }
        })
        .fold(f64::INFINITY, f64::min)
}
