//! Offsets, openings and closings of real parts: closed meshes whose facets cross as often as is said, volumes in their
//! brackets, in the expected order.
//!
//! The parts come from the folder in `AMCHECK_MODELS`, else from `../shared/models`; without them the test says so.

use amcheck::geometry::health::meetings;
use amcheck::geometry::{Health, MeshDistance, Primitive, TriangleMesh};
use amcheck::io::{Salvage, read};
use amcheck::operate::{Element, Operated, close, offset, open};
use amcheck::units::Length;
use std::path::PathBuf;
use std::time::Instant;

const PARTS: [&str; 5] = [
    "prusa_x_carriage.stl",
    "openflexure_stand.stl",
    "voron2_front_idler.stl",
    "nop_gridfinity_1_cavity.stl",
    "prusa_y_motor_holder_slits.stl",
];

/// Parts with walls and gaps thinner than the spacing.
const THIN: [&str; 2] = ["enable_pip_hand_16.stl", "enable_compliant_finger.stl"];

fn folder() -> Option<PathBuf> {
    let named = std::env::var_os("AMCHECK_MODELS").map(PathBuf::from);
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    named.or(Some(beside)).filter(|f| f.join("clean").is_dir())
}

/// The parts of these names; those that are absent are said to be skipped.
fn parts(names: &[&'static str]) -> Vec<(&'static str, TriangleMesh)> {
    let Some(folder) = folder() else {
        println!("skipped: no models (set AMCHECK_MODELS)");
        return Vec::new();
    };
    let part = |&name: &&'static str| match std::fs::read(folder.join("clean").join(name)) {
        Ok(bytes) => Some((name, read(name, &bytes, Salvage::default()).unwrap().mesh)),
        Err(_) => {
            println!("skipped: {name} is absent");
            None
        }
    };
    names.iter().filter_map(part).collect()
}

fn report(name: &str, what: &str, h: Length, run: impl FnOnce() -> amcheck::Result<Operated>) -> f64 {
    let started = Instant::now();
    let made = run().unwrap_or_else(|e| panic!("{name} {what}: {e}: {}", e.remedy()));
    let took = started.elapsed();
    let [low, high] = made.bracket.map(|v| v.as_mm3());
    let volume = made.volume.as_mm3();
    println!(
        "{name} {what} at {h}: {low:.0} ≤ {volume:.1} ≤ {high:.0} mm³, {} facets, {took:.2?}",
        made.mesh.triangles.len()
    );
    let health = Health::of(&made.mesh);
    assert!(health.is_watertight(), "{name} {what}: open");
    assert_eq!(health.non_manifold_edges.count, 0, "{name} {what}: not manifold");
    // All pairs of facets. Offsets promise that none cross; openings and closings count those at walls thinner than the spacing.
    let crossing = meetings(&MeshDistance::new(&made.mesh), |_, _| true, 1e-5 * h.as_mm()).crossing;
    assert_eq!(crossing.count, made.crossings().count, "{name} {what}: {crossing:?}");
    assert!(crossing.count == 0 || what.ends_with("1 mm"), "{name} {what}: {crossing:?}");
    println!("{name} {what}: {} pairs cross", crossing.count);
    volume
}

#[test]
fn real_parts_grow_shrink_open_and_close_to_closed_meshes() {
    for (name, part) in parts(&PARTS) {
        let samples = 128;
        let h = Length::mm(longest(&part) / samples as f64);
        let ball = Element::BuiltIn(Primitive::Ball { radius: Length::mm(1.0) });
        let own = part.signed_volume();
        let grown = report(name, "+0.5 mm", h, || offset(&part, Length::mm(0.5), h));
        let shrunk = report(name, "-0.5 mm", h, || offset(&part, Length::mm(-0.5), h));
        let opened = report(name, "opened 1 mm", h, || open(&part, &ball, h));
        let closed = report(name, "closed 1 mm", h, || close(&part, &ball, h));
        // A percent is left for what contouring cuts off sharp edges twice.
        assert!(shrunk < own && own < grown);
        assert!(opened < 1.01 * own && 0.99 * own < closed, "{name}: {opened} {own} {closed}");
    }
}

#[test]
fn real_parts_with_thin_walls_and_gaps_keep_them_whole() {
    for (name, part) in parts(&THIN) {
        for by in [0.5, -0.1] {
            let volume = |samples: f64| {
                let h = Length::mm(longest(&part) / samples);
                report(name, &format!("{by:+} mm"), h, || offset(&part, Length::mm(by), h))
            };
            // Up to a spacing along the rims of what is thinner may be missing.
            let (coarse, fine) = (volume(128.0), volume(200.0));
            assert!((coarse / fine - 1.0).abs() < 0.01, "{name} {by:+} mm: {coarse} and {fine} mm³");
        }
    }
}

fn longest(part: &TriangleMesh) -> f64 {
    let (lo, hi) = part.bounds().unwrap();
    (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max)
}
