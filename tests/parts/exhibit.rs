//! What the exhibit shows beside the walls: local thickness, and where inside is in doubt.

use super::process;
use amcheck::analyze::{Analysis, Options, prepare, run};
use amcheck::io::{Salvage, read};
use amcheck::report::json;
use amcheck::units::Length;

/// A committed part, judged.
fn judged(name: &str, options: &Options) -> Analysis {
    let bytes = std::fs::read(format!("fixtures/parts/{name}")).expect("a committed part");
    let loaded = read(name, &bytes, Salvage::Refuse).expect("a mesh");
    run(prepare(name, &bytes, loaded, options).expect("a part"), options).expect("a report")
}

#[test]
fn the_fins_of_the_sample_are_as_thick_by_ball_and_by_ray_as_they_are() {
    let mut options = Options::new(process("fdm", &[]));
    options.thickness = Some(Length::mm(2.0));
    let analysis = judged("finned_bracket.stl", &options);
    let text = json::write(&analysis.report);
    let schema = serde_json::from_str(json::SCHEMA_TEXT).expect("the published schema");
    let value = serde_json::from_str(&text).expect("JSON");
    assert!(jsonschema::validator_for(&schema).expect("a schema").is_valid(&value));
    let t = analysis.report.thickness.expect("asked for");
    // A certified volume never shrinks with the width, and its ends stand in order.
    for list in [&t.material_below, &t.void_below] {
        assert!(!list.is_empty() && list.iter().all(|v| v.low_mm3 <= v.high_mm3), "{list:?}");
        assert!(list.windows(2).all(|w| w[0].low_mm3 <= w[1].low_mm3 && w[0].high_mm3 <= w[1].high_mm3), "{list:?}");
    }
    // The ray ends exactly on the other side of each fin.
    let ray = analysis.exhibit.maps.iter().find(|m| m.check == "ray-thickness").expect("a map");
    for fin in [0.45f32, 0.6, 0.9, 1.2] {
        let on_it = ray.values.iter().filter(|v| (**v - fin).abs() < 1e-4).count();
        assert!(on_it > 0, "no ray measures the fin of {fin} mm");
    }
    // A ball inside a fin is no wider than it: nothing on the surface of the thinnest shows more than its upper bound.
    let ball = analysis.exhibit.maps.iter().find(|m| m.check == "local-thickness").expect("a map");
    let slack = 2.0 * 3f32.sqrt() * t.spacing_mm as f32;
    let thinnest = ray.values.iter().zip(&ball.values).filter(|(r, b)| (**r - 0.45).abs() < 1e-4 && b.is_finite());
    let middle: Vec<f32> = thinnest.map(|(_, b)| *b).collect();
    assert!(!middle.is_empty());
    let near = middle.iter().filter(|b| **b <= 0.45 + slack).count();
    assert!(near * 10 >= middle.len() * 9, "{near} of {} near the fin's thickness", middle.len());
}

#[test]
fn where_inside_is_in_doubt_is_shown() {
    let options = Options::new(process("fdm", &[]));
    let doubtful = |name: &str| judged(name, &options).exhibit.layers.into_iter().find(|l| l.name == "uncertain");
    assert!(doubtful("block.stl").is_none());
    // One facet of the block's side is missing, half of its face: the doubt lies about the hole and leaves the far side alone.
    let layer = doubtful("block_open.stl").expect("a region");
    let analysis = judged("block_open.stl", &options);
    let hole =
        analysis.report.warnings.iter().find(|w| w.code == "uncertain-inside").and_then(|w| w.at_mm).expect("a place");
    let size = analysis.report.part.posed_box();
    let extent = [0, 1, 2].map(|a| size[1][a] - size[0][a]);
    assert!(!layer.corners.is_empty() && layer.corners.len().is_multiple_of(3));
    let near = analysis.report.part.posed(hole);
    let away = |p: &[f64; 3]| (0..3).map(|a| (p[a] - near[a]).powi(2)).sum::<f64>().sqrt();
    assert!(layer.corners.iter().map(away).fold(f64::INFINITY, f64::min) < 2.0, "{near:?}");
    let reach = [0, 1, 2].map(|a| layer.corners.iter().map(|p| p[a]).fold(f64::NEG_INFINITY, f64::max));
    let least = [0, 1, 2].map(|a| layer.corners.iter().map(|p| p[a]).fold(f64::INFINITY, f64::min));
    assert!((0..3).any(|a| reach[a] - least[a] < 0.6 * extent[a]), "{least:?} to {reach:?} of {extent:?}");
}
