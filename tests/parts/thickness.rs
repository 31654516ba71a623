//! Local thickness as the report shows it, on a part whose walls are known.

use super::process;
use amcheck::analyze::{Options, prepare, run};
use amcheck::io::{Salvage, read};
use amcheck::report::json;
use amcheck::units::Length;

#[test]
fn the_fins_of_the_sample_are_as_thick_by_ball_and_by_ray_as_they_are() {
    let bytes = std::fs::read("fixtures/parts/finned_bracket.stl").expect("a committed part");
    let mut options = Options::new(process("fdm", &[]));
    options.thickness = Some(Length::mm(2.0));
    let loaded = read("finned_bracket.stl", &bytes, Salvage::Refuse).expect("a mesh");
    let prepared = prepare("finned_bracket.stl", &bytes, loaded, &options).expect("a part");
    let analysis = run(prepared, &options).expect("a report");
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
