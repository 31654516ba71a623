//! Real parts with measured truths, when the corpus is there.

use crate::{findings, judge_bytes, process};
use amcheck::analyze::Options;
use amcheck::check::{Finding, State};
use amcheck::report::Report;
use std::path::PathBuf;

/// The corpus: `AMCHECK_MODELS`, or `../shared/models` beside the repository.
pub fn corpus() -> Option<PathBuf> {
    let folder = std::env::var_os("AMCHECK_MODELS")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/models"), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: no model corpus (set AMCHECK_MODELS to its folder)");
    None
}

fn judged(file: &str, limits: &[&str]) -> Option<Report> {
    let path = corpus()?.join(file);
    let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    Some(judge_bytes(file, &bytes, &Options::new(process("fdm", limits))).expect("a report"))
}

/// What the issue allows between a value and the truth, millimetres.
const CLOSE: f64 = 0.005;

/// Each truth is the value of a finding, inside its bracket; in order, none beside them below `up_to`.
fn expect(found: &[Finding], truths: &[f64], up_to: f64) {
    let values: Vec<f64> = found.iter().map(|f| f.value).filter(|v| *v < up_to).collect();
    assert_eq!(values.len(), truths.len(), "{values:?}");
    for (f, truth) in found.iter().zip(truths) {
        // Truths are printed to four decimals.
        assert!((f.value - truth).abs() < CLOSE && f.low - 1e-4 <= *truth && *truth <= f.high + 1e-4, "{truth}: {f:?}");
        assert!(f.high - f.low < 2.0 * 0.2, "a bracket wider than two samples: {f:?}");
    }
}

fn failing(report: &Report, code: &str) -> usize {
    findings(report, code).iter().filter(|f| f.state == State::Fail).count()
}

#[test]
fn thinwall_has_four_walls() {
    for (limit, fails) in [("thin-wall=0.4mm", 1), ("thin-wall=0.6mm", 2), ("thin-wall=0.9mm", 3)] {
        let Some(report) = judged("calibration/thinwall.stl", &[limit]) else { return };
        expect(findings(&report, "AM101"), &[0.35, 0.5, 0.8, 1.0], 1.2);
        assert_eq!(failing(&report, "AM101"), fails, "{limit}");
    }
}

#[test]
fn tolerance_pins_have_five_gaps() {
    for (limit, fails) in [("narrow-gap=0.15mm", 2), ("narrow-gap=0.25mm", 4), ("narrow-gap=0.35mm", 5)] {
        let Some(report) = judged("calibration/tolerance_pins.stl", &[limit]) else { return };
        expect(findings(&report, "AM103"), &[0.0999, 0.1498, 0.1998, 0.2498, 0.2997], 0.5);
        assert_eq!(failing(&report, "AM103"), fails, "{limit}");
        assert_eq!(report.part.bodies, 6);
    }
}

#[test]
fn kickstarter_has_five_gaps_and_four_slopes() {
    let Some(report) = judged("calibration/kickstarter_fdm_v4.stl", &["narrow-gap=0.3mm,0.6mm", "overhang=45deg"])
    else {
        return;
    };
    let gaps: Vec<Finding> =
        findings(&report, "AM103").iter().filter(|f| f.kind == "gap-between-bodies").cloned().collect();
    expect(&gaps, &[0.1863, 0.2863, 0.3863, 0.4863, 0.5863], 0.6);
    assert_eq!(gaps.iter().filter(|f| f.state == State::Fail).count(), 2);
    let slopes = findings(&report, "AM201");
    for (angle, area) in [(15.0, 261.0), (20.0, 268.0), (30.0, 512.0)] {
        let f = slopes.iter().find(|f| (f.value - angle).abs() < 0.01 && f.kind == "slope").expect("the plate");
        assert!((f.area_mm2.unwrap_or(0.0) / area - 1.0).abs() < 0.02, "{f:?}");
    }
    // The plate at 45° passes at 45°; some 100 mm² of small facets truly lie a little below.
    let near: f64 = slopes.iter().filter(|f| f.value > 44.0).filter_map(|f| f.area_mm2).sum();
    assert!(near < 150.0, "{near} mm² of 682 + 100");
}

#[test]
fn overhang_has_four_plates_below_45_degrees() {
    let Some(report) = judged("calibration/overhang_40_80.stl", &[]) else { return };
    for (angle, area) in [(10.0, 147.0), (20.0, 145.0), (30.0, 145.0), (40.0, 146.0)] {
        let f = findings(&report, "AM201").iter().find(|f| (f.value - angle).abs() < 0.01 && f.kind == "slope");
        let share = f.and_then(|f| f.area_mm2).unwrap_or(0.0) / area;
        assert!((share - 1.0).abs() < 0.02, "{angle}°: {f:?}");
    }
}

#[test]
fn bridges_and_cantilevers_have_their_spans() {
    let Some(report) = judged("calibration/bridge_40.obj", &[]) else { return };
    let f = &findings(&report, "AM203")[0];
    assert!(f.kind == "bridge" && (f.value - 40.0).abs() < CLOSE && f.low <= 40.0 && f.high >= 40.0, "{f:?}");
    assert!(f.high - f.low < CLOSE && f.state == State::Warn);
    // Every bridge that is longer than the limit is found, at its exact length.
    let Some(report) = judged("calibration/kickstarter_fdm_v4.stl", &["bridge=60mm,5mm"]) else { return };
    let spans: Vec<f64> = findings(&report, "AM203").iter().filter(|f| f.kind == "bridge").map(|f| f.value).collect();
    for span in [10.0, 20.0, 30.0, 40.0, 50.0] {
        assert!(spans.iter().any(|s| (s - span).abs() < CLOSE), "{span}: {spans:?}");
    }
    // A strip of 60 mm whose end is bounded by a facet of no width: the bridge goes on to the wall behind it.
    let Some(report) = judged("clean/openflexure_stand.stl", &[]) else { return };
    let long = findings(&report, "AM203").iter().find(|f| f.kind == "bridge" && (f.value - 60.0).abs() < 0.6);
    assert!(long.is_some(), "{:?}", findings(&report, "AM203"));
    let Some(report) = judged("calibration/u_overhang.obj", &[]) else { return };
    let f = &findings(&report, "AM203")[0];
    assert!(f.kind == "ledge" && f.low <= 9.0 && 9.0 <= f.high && f.low > 8.5, "{f:?}");
}

#[test]
fn obj_parts_give_their_truths() {
    let Some(report) = judged("calibration/u_overhang.obj", &["thin-wall=1.1mm"]) else { return };
    assert!((findings(&report, "AM101")[0].value - 1.0).abs() < CLOSE);
    assert!((report.part.volume_mm3.value - 290.0).abs() < 1e-3);
    let Some(report) = judged("calibration/two_hollow_squares.obj", &["thin-wall=1.1mm"]) else { return };
    assert!((findings(&report, "AM101")[0].value - 1.011).abs() < CLOSE, "{:?}", findings(&report, "AM101"));
    let Some(report) = judged("calibration/v_standing.obj", &[]) else { return };
    assert!(findings(&report, "AM201").is_empty());
}

#[test]
fn the_web_and_the_fifteen_slits_of_the_motor_holder_are_found() {
    let file = "clean/prusa_y_motor_holder_slits.stl";
    let Some(report) = judged(file, &["narrow-gap=0.6mm"]) else { return };
    let web = &findings(&report, "AM101")[0];
    assert!((web.value - 0.2).abs() < CLOSE && web.state == State::Fail, "{web:?}");
    let slits = &findings(&report, "AM103")[0];
    assert!((slits.value - 0.5).abs() < CLOSE && slits.count == 15, "{slits:?}");
}

#[test]
fn hole_test_has_fifteen_holes_and_one_fails_at_2_mm() {
    let Some(report) = judged("calibration/hole_test.stl", &[]) else { return };
    let holes = findings(&report, "AM104");
    assert!(holes.len() == 1 && holes[0].state == State::Fail && (holes[0].value - 1.0).abs() < CLOSE, "{holes:?}");
    let Some(report) = judged("calibration/hole_test.stl", &["small-hole=15.5mm"]) else { return };
    let mut holes: Vec<&Finding> = findings(&report, "AM104").iter().collect();
    holes.sort_by(|a, b| a.value.total_cmp(&b.value));
    assert_eq!(holes.len(), 15);
    for (i, f) in holes.iter().enumerate() {
        // Equal-area diameters of the slice at z = 2.5 go from 1.000 to 14.998.
        let truth = (i + 1) as f64;
        assert!((f.value - truth).abs() < CLOSE && f.low <= truth && truth <= f.high + 1e-4, "{truth}: {f:?}");
    }
}

#[test]
fn square_slots_are_holes_as_wide_as_they_are() {
    let Some(report) = judged("calibration/slop_calibrator.stl", &["small-hole=13mm"]) else { return };
    let mut holes: Vec<&Finding> = findings(&report, "AM104").iter().collect();
    holes.sort_by(|a, b| a.value.total_cmp(&b.value));
    // Clearance of a plug of 10 mm: 0 to 0.45 mm per side.
    let clearances: Vec<f64> = holes.iter().map(|f| 0.5 * (f.low - 10.0)).collect();
    assert_eq!(clearances.len(), 10, "{clearances:?}");
    assert!(clearances.iter().enumerate().all(|(i, c)| (c - 0.05 * i as f64).abs() < 1e-5), "{clearances:?}");
}

#[test]
fn discs_and_spires_have_their_diameters() {
    use amcheck::medial::Side;
    use amcheck::medial::rod::Wanted;
    let Some(folder) = corpus() else { return };
    let rods_of = |file: &str, within: f64| {
        let bytes = std::fs::read(folder.join(file)).expect(file);
        let loaded = amcheck::io::read(file, &bytes, amcheck::io::Salvage::Refuse).expect(file);
        let prepared = amcheck::analyze::prepare(file, &bytes, loaded, &Options::new(process("fdm", &[]))).expect(file);
        prepared.part().rods(Wanted { side: Side::Material, within, elongation: 1.81 }).into_owned().rods
    };
    let close = |d: &f64, t: f64| (d - t).abs() < 0.01;
    // Six discs on top of each other, each 5 mm high.
    let discs = rods_of("calibration/dimensional_stack.stl", 40.0);
    // The lowest is no full disc above 4 mm: there is an inscription in its upper face.
    for (truth, height) in [(30.0, 4.0), (25.0, 5.0), (20.0, 5.0), (15.0, 5.0), (10.0, 5.0), (5.0, 5.0)] {
        // Of 400 corners on the circle: the equal-area diameter is a ten-thousandth less.
        let disc = discs.iter().find(|r| close(&r.diameter(), truth));
        assert!(
            disc.is_some_and(|r| (r.length - height).abs() < 0.05),
            "{truth}: {:?}",
            discs.iter().map(|r| (r.diameter(), r.length)).collect::<Vec<_>>()
        );
    }
    let spires = rods_of("calibration/kickstarter_fdm_v4.stl", 3.0);
    assert_eq!(spires.iter().filter(|r| close(&r.diameter(), 0.681) && r.length > 20.0).count(), 9);
}

#[test]
fn bodies_printed_in_place_have_exact_gaps() {
    let cases: [(&str, &[(f64, u64)]); 4] = [
        ("clean/voron2_door_hinge_pip.stl", &[(0.298, 1)]),
        ("clean/voron0_x_carriage_support.stl", &[(0.2, 1)]),
        ("clean/enable_pip_finger.stl", &[(0.196, 1), (0.354, 1)]),
        ("clean/enable_pip_hand_16.stl", &[(0.231, 4), (0.4, 11)]),
    ];
    for (file, gaps) in cases {
        let Some(report) = judged(file, &[]) else { return };
        let found: Vec<&Finding> =
            findings(&report, "AM103").iter().filter(|f| f.kind == "gap-between-bodies").collect();
        assert_eq!(found.len(), gaps.len(), "{file}: {found:?}");
        for (f, (gap, count)) in found.iter().zip(gaps) {
            assert!((f.value - gap).abs() < CLOSE && f.count == *count, "{file}: {f:?}");
        }
    }
}

#[test]
fn broken_parts_end_as_the_manifest_asks() {
    let Some(folder) = corpus() else { return };
    let codes = [
        ("bad_vertex.stl", 4),
        ("empty_0_bytes.stl", 4),
        ("empty_solid_26_bytes.stl", 4),
        ("empty_header_only.stl", 4),
        ("truncated_ascii.stl", 4),
        ("soup_100_loose.stl", 4),
    ];
    for (file, code) in codes {
        let bytes = std::fs::read(folder.join("broken").join(file)).expect(file);
        let e = judge_bytes(file, &bytes, &Options::new(process("fdm", &[]))).expect_err(file);
        assert_eq!(e.exit_code(), code, "{file}: {e}");
        if file == "bad_vertex.stl" {
            assert_eq!(e.place().as_deref(), Some("line 89"));
        }
    }
    for (file, notice, count) in [
        ("open_576_edges.stl", "open-edges", Some(576)),
        ("shared_edge.stl", "non-manifold", Some(1)),
        ("coincident_bodies.stl", "duplicate-facets", Some(3004)),
        ("flipped_solid.stl", "miswound", Some(13)),
        ("real_part_40_nm_edges.stl", "non-manifold", Some(40)),
        ("closed_metres.stl", "units-guess", None),
        ("huge_150m_inverted.stl", "inverted", None),
    ] {
        let bytes = std::fs::read(folder.join("broken").join(file)).expect(file);
        let report = judge_bytes(file, &bytes, &Options::new(process("fdm", &[]))).expect(file);
        let said = report
            .warnings
            .iter()
            .find(|n| n.code == notice)
            .unwrap_or_else(|| panic!("{file}: {:?}", report.warnings));
        assert!(count.is_none() || said.count == count, "{file}: {said:?}");
        let uncertain = findings(&report, "AM001").iter().any(|f| f.kind == "uncertain-inside" && !f.decided);
        assert!(!uncertain, "{file}: inside is known well enough");
    }
}

#[test]
fn a_surface_that_is_folded_onto_itself_warns_with_its_place() {
    let Some(report) = judged("broken/self_touch_tardis.stl", &[]) else { return };
    // Facets at x = 50.642 lie on each other where a corner was rounded past its neighbour.
    let found: Vec<&Finding> = findings(&report, "AM001").iter().collect();
    assert_eq!(found.iter().map(|f| f.kind.as_str()).collect::<Vec<_>>(), ["overlapping-facets"], "{found:?}");
    assert!(
        (found[0].at_mm[0] - 50.642).abs() < 1e-3 && found[0].area_mm2.is_some_and(|a| a > 0.0 && a < 1e-3),
        "{found:?}"
    );
}

#[test]
fn links_of_a_chain_are_near_and_none_touches() {
    let Some(report) = judged("formats/chain_loop.3mf", &[]) else { return };
    // Brute force over all pairs of facets: 28 pairs of links 0.0201 to 0.0213 mm apart, 12 more 0.777 mm, none cross.
    assert!(report.warnings.iter().all(|n| n.code != "touching-bodies"), "{:?}", report.warnings);
    let gaps: Vec<(f64, u64)> = findings(&report, "AM103").iter().map(|f| (f.value, f.count)).collect();
    assert!(gaps.len() == 1 && (gaps[0].0 - 0.020075).abs() < 1e-6 && gaps[0].1 == 28, "{gaps:?}");
}

#[test]
fn a_part_with_576_open_edges_gets_the_findings_of_its_closed_twin() {
    let inches = |file: &str| {
        let bytes = std::fs::read(corpus()?.join(file)).expect("a file of the corpus");
        let options = Options { units: Some(("in".into(), 25.4)), ..Options::new(process("fdm", &[])) };
        Some(judge_bytes(file, &bytes, &options).expect("a report"))
    };
    let Some(closed) = inches("formats/featuretype_closed.ply") else { return };
    let open = inches("broken/open_576_edges.stl").expect("the corpus is there");
    // Float32 corners of an inch part turn a short facet by a few hundredths of a per cent.
    crate::same_answer::same("twins", &without_mesh(closed), &without_mesh(open.clone()), 1e-3, |p| p);
    assert_eq!(findings(&open, "AM001").iter().map(|f| f.value).collect::<Vec<_>>(), [576.0]);
}

/// A report without the check that tells the twins apart.
fn without_mesh(mut report: Report) -> Report {
    report.checks.retain(|c| c.code != "AM001");
    report
}
