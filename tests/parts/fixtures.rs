//! The committed fixture parts and the generator that writes them.
//!
//! `cargo test --release --test parts generate_fixtures -- --ignored` writes `fixtures/parts` anew.

use crate::shapes::{
    angle_bracket, bar_through_itself, block_and_speck, facing, finned_bracket, flask, gallows, pin, ramp, relief,
    ribbed, table, tunnel, washer, wedge,
};
use amcheck::geometry::{TriangleMesh, cuboid};
use std::path::PathBuf;

/// Where the fixture parts lie.
pub fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fixtures/parts")
}

/// The bytes of a fixture part.
pub fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(folder().join(format!("{name}.stl"))).unwrap_or_else(|e| panic!("fixtures/parts/{name}.stl: {e}"))
}

/// Every fixture part by name; `fixtures/README.md` has its true values.
pub fn all() -> Vec<(&'static str, TriangleMesh)> {
    let block = cuboid([0.0; 3], [20.0; 3]);
    let leaning = |thick: f64| {
        let plate = cuboid([-5.0, -5.0, -0.5 * thick], [5.0, 5.0, 0.5 * thick]);
        plate.transformed(facing([1.0, 1.0, 1.0]), [0.0; 3])
    };
    let mut open = block.clone();
    open.triangles.pop();
    let slits = (0..5).fold(block.clone(), |part, i| {
        let x = 3.0 + 3.0 * i as f64;
        part.joined(&cuboid([x, 4.0, 4.0], [x + 0.15, 16.0, 16.0]).flipped())
    });
    let hollow = block.clone().joined(&cuboid([5.0; 3], [15.0; 3]).flipped());
    let pair = |gap: f64| cuboid([0.0; 3], [10.0; 3]).joined(&cuboid([10.0 + gap, 0.0, 0.0], [20.0 + gap, 10.0, 10.0]));
    vec![
        ("block", block),
        ("block_open", open),
        ("bar_through_itself", bar_through_itself()),
        ("bar_300", cuboid([0.0; 3], [300.0, 10.0, 10.0])),
        ("wall_111_024", leaning(0.24)),
        ("wall_111_200", leaning(2.0)),
        ("wall_080", cuboid([0.0; 3], [20.0, 0.8, 10.0])),
        ("pin_060", pin(0.6, 4.0)),
        ("pin_060_tall", pin(0.6, 9.0)),
        ("pin_400", pin(4.0, 8.0)),
        ("hole_100", washer(1.0)),
        ("hole_200", washer(2.0)),
        ("wedge_20", wedge(20.0)),
        ("wedge_60", wedge(60.0)),
        ("slits_015", slits),
        ("pair_010", pair(0.1)),
        ("pair_100", pair(1.0)),
        ("table", table(0.0)),
        ("table_hanging", table(4.0)),
        ("table_40", crate::shapes::bench(40.0)),
        ("gallows", gallows()),
        ("tunnel_10", tunnel(10.0)),
        ("tunnel_05", tunnel(5.0)),
        ("pillar_24", cuboid([0.0; 3], [2.0, 2.0, 24.0])),
        ("pillar_12", cuboid([0.0; 3], [2.0, 2.0, 12.0])),
        ("ramp_30", ramp(30.0)),
        ("ramp_45", ramp(45.0)),
        ("block_cavity", hollow),
        ("finned_bracket", finned_bracket()),
        ("hollow_sealed", cuboid([0.0; 3], [20.0; 3]).joined(&cuboid([2.0; 3], [18.0; 3]).flipped())),
        ("flask_020", flask(20.0, 16.0, 2.0)),
        ("vial_008", flask(8.0, 3.0, 0.8)),
        ("basin", flask(20.0, 16.0, 15.0)),
        ("rib_010", ribbed(0.1, 2.0)),
        ("relief_050", relief()),
        ("speck_025", block_and_speck(0.25)),
        ("bracket_sharp", angle_bracket(0.0)),
        ("bracket_round", angle_bracket(1.0)),
    ]
}

#[test]
#[ignore = "writes fixtures/parts"]
fn generate_fixtures() {
    std::fs::create_dir_all(folder()).expect("the folder");
    for (name, mesh) in all() {
        let mut bytes = Vec::new();
        amcheck::io::stl::write(&mesh, &mut bytes).expect("in memory");
        std::fs::write(folder().join(format!("{name}.stl")), bytes).expect("the file");
    }
}

#[test]
fn committed_fixtures_are_what_the_generator_makes() {
    for (name, mesh) in all() {
        let mut made = Vec::new();
        amcheck::io::stl::write(&mesh, &mut made).expect("in memory");
        assert!(made == bytes(name), "fixtures/parts/{name}.stl is stale: run the generator");
    }
}
