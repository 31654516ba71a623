//! What each fuzz target does with bytes, and what must hold then; the tests do the same with seeded mutations.

use amcheck::Error;
use amcheck::access::Tool;
use amcheck::batch::Shard;
use amcheck::geometry::vector::Vec3;
use amcheck::geometry::{Health, InsideRule, Primitive, TriangleMesh, voxelize};
use amcheck::grid::Grid;
use amcheck::io::{Salvage, gcode, obj, ply, read, stl, threemf, toolpath};
use amcheck::process::{Process, waivers};
use amcheck::units::{Angle, Length};

/// An error has a documented exit code and can be printed.
fn plain(e: &Error, codes: &[u8]) {
    let text = format!("{e} {} {}", e.place().unwrap_or_default(), e.remedy());
    assert!(codes.contains(&e.exit_code()), "{} {text}", e.exit_code());
    assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{text:?}");
}

fn sound(mesh: &TriangleMesh) {
    assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.vertices.len()));
    assert!(mesh.vertices.iter().flatten().all(|x| x.is_finite()));
    assert_eq!(Health::of(mesh).facet_body.len(), mesh.triangles.len());
}

fn loaded(result: amcheck::Result<amcheck::io::Loaded>) {
    match result {
        Ok(loaded) => sound(&loaded.mesh),
        Err(e) => plain(&e, &[4, 5]),
    }
}

/// Binary and ASCII STL.
pub fn read_stl(bytes: &[u8]) {
    loaded(stl::read(bytes, Salvage::Refuse));
    loaded(stl::read(bytes, Salvage::KeepWhole));
}

/// OBJ.
pub fn read_obj(bytes: &[u8]) {
    loaded(obj::read(bytes));
}

/// ASCII PLY and both binaries.
pub fn read_ply(bytes: &[u8]) {
    loaded(ply::read(bytes));
}

/// 3MF, and whatever else its first bytes make of it.
pub fn read_threemf(bytes: &[u8]) {
    loaded(threemf::read(bytes));
    loaded(read("part.3mf", bytes, Salvage::KeepWhole));
}

/// G-code and lists of points.
pub fn read_path(bytes: &[u8]) {
    for read in [gcode::read, toolpath::read_points] {
        match read(bytes) {
            Ok(path) => assert!(path.length_mm().is_finite()),
            Err(e) => plain(&e, &[4, 5]),
        }
    }
}

/// A mesh cast onto a small grid: each corner is three numbers of 16 bits, so that facets meet, cross and vanish.
pub fn mesh_to_voxels(bytes: &[u8]) {
    let number = |b: &[u8]| f64::from(i16::from_le_bytes([b[0], b[1]])) / 2048.0;
    let corner = |b: &[u8]| -> Vec3 { [number(&b[0..2]), number(&b[2..4]), number(&b[4..6])] };
    let facets = bytes.chunks_exact(18).take(64).map(|f| [corner(&f[0..6]), corner(&f[6..12]), corner(&f[12..18])]);
    let mesh = TriangleMesh::weld(facets);
    if mesh.triangles.is_empty() {
        return;
    }
    sound(&mesh);
    let Some((lo, hi)) = mesh.bounds() else { return };
    let Ok(grid) = Grid::covering(lo, hi, Length::mm(1.7), 1, [0.3, 0.1, 0.2]) else { return };
    for rule in [InsideRule::Crossings, InsideRule::Winding] {
        match voxelize(&mesh, &grid, rule) {
            Ok(solid) => {
                let words = || solid.inner.words().iter().zip(solid.centres.words()).zip(solid.outer.words());
                assert!(words().all(|((i, c), o)| i & !c == 0 && c & !o == 0), "inner ⊆ centres ⊆ outer");
                assert!(solid.density.field().values().iter().all(|d| (0.0..=1.0).contains(d)));
            }
            Err(e) => plain(&e, &[2]),
        }
    }
}

/// A profile of a process.
pub fn profile(bytes: &[u8]) {
    if let Err(e) = Process::from_toml("mine.toml", &String::from_utf8_lossy(bytes)) {
        plain(&e, &[2]);
    }
}

/// A tool's description, with a mesh beside it for those that name one.
pub fn tool(bytes: &[u8]) {
    let mesh = Primitive::Ball { radius: Length::mm(2.0) }.mesh(Length::mm(0.5));
    match Tool::from_toml("mine", &String::from_utf8_lossy(bytes), |_| Ok(mesh.clone())) {
        Ok(tool) => {
            let drawn = tool.mesh(50.0, 12);
            assert!(tool.cutter_width().is_finite() && drawn.vertices.iter().flatten().all(|c| c.is_finite()));
        }
        Err(e) => plain(&e, &[2]),
    }
}

/// A file of acceptances.
pub fn acceptances(bytes: &[u8]) {
    if let Err(e) = waivers("accept.toml", &String::from_utf8_lossy(bytes)) {
        plain(&e, &[2]);
    }
}

/// Every word that has a grammar of its own.
pub fn options(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    for word in text.split('\n') {
        let errors = [
            Length::parse(word).err(),
            Angle::parse(word).err(),
            Primitive::parse(word).err(),
            Shard::parse(word).err(),
            Process::named("fdm").and_then(|mut p| p.override_limit(word)).err(),
        ];
        errors.iter().flatten().for_each(|e| plain(e, &[2]));
    }
}
