//! Readers and health against real models with known numbers; skipped where the models are absent.

use amcheck::Error;
use amcheck::geometry::Health;
use amcheck::geometry::health::Role;
use amcheck::io::{Loaded, Salvage, read_path};
use std::path::PathBuf;

fn models() -> Option<PathBuf> {
    let given = std::env::var_os("AMCHECK_MODELS").map(PathBuf::from);
    let folder = given.unwrap_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/models")));
    let found = folder.is_dir();
    if !found {
        println!("skipped: no models at {}", folder.display());
    }
    found.then_some(folder)
}

fn load(name: &str) -> Option<Result<Loaded, Error>> {
    Some(read_path(&models()?.join(name), 1 << 30, Salvage::Refuse).map(|(_, loaded)| loaded))
}

/// File, facets, open, non-manifold and miswound edges, duplicates, zero-area facets, shells, bodies, voids.
const STL: &[(&str, [u64; 9])] = &[
    ("clean/prusa_x_end_motor.stl", [8202, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("clean/prusa_y_motor_holder_slits.stl", [2802, 0, 0, 0, 0, 0, 16, 1, 15]),
    ("clean/prusa_x_carriage.stl", [7200, 0, 0, 0, 0, 0, 5, 1, 3]),
    ("clean/voron2_front_idler.stl", [10584, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("clean/voron2_door_hinge_pip.stl", [19900, 0, 0, 0, 0, 0, 2, 2, 0]),
    ("clean/voron0_x_carriage_support.stl", [25608, 0, 0, 0, 0, 0, 2, 2, 0]),
    ("clean/snappy_cable_chain_16.stl", [13760, 0, 0, 0, 0, 0, 16, 16, 0]),
    ("clean/nop_enviro_case.stl", [14188, 0, 0, 0, 0, 24, 1, 1, 0]),
    ("clean/nop_gridfinity_10_cavities.stl", [7660, 0, 0, 0, 0, 0, 11, 1, 10]),
    ("clean/nop_gridfinity_1_cavity.stl", [3776, 0, 0, 0, 0, 0, 2, 1, 1]),
    ("clean/openscad_trapped_sphere.stl", [4160, 0, 0, 0, 0, 0, 2, 1, 1]),
    ("clean/openflexure_stand.stl", [4578, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("clean/enable_pip_finger.stl", [25080, 0, 0, 0, 0, 0, 3, 3, 0]),
    ("clean/enable_pip_hand_16.stl", [54956, 0, 0, 0, 0, 0, 16, 16, 0]),
    ("clean/enable_compliant_finger.stl", [19092, 0, 0, 0, 0, 0, 9, 1, 8]),
    ("calibration/thinwall.stl", [1628, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("calibration/tolerance_pins.stl", [13680, 0, 0, 0, 0, 0, 6, 6, 0]),
    ("calibration/hole_test.stl", [16126, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("calibration/overhang_40_80.stl", [3280, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("calibration/dimensional_stack.stl", [5208, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("calibration/support_test.stl", [3242, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("calibration/hollow_cube_1mm.stl", [160, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("calibration/kickstarter_fdm_v4.stl", [12234, 0, 0, 0, 0, 0, 6, 6, 0]),
    ("calibration/slop_calibrator.stl", [1676, 0, 0, 0, 0, 0, 3, 3, 0]),
    ("calibration/cylinder1000.stl", [3996, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("broken/open_576_edges.stl", [3476, 576, 0, 0, 0, 0, 1, 1, 0]),
    ("broken/closed_metres.stl", [7436, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("broken/shared_edge.stl", [24, 0, 1, 0, 0, 0, 2, 2, 0]),
    ("broken/soup_100_loose.stl", [100, 300, 0, 0, 0, 0, 100, 100, 0]),
    ("broken/flipped_solid.stl", [10, 0, 0, 13, 0, 0, 1, 1, 0]),
    ("broken/self_touch_tardis.stl", [3636, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("broken/one_trailing_byte.stl", [288, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("broken/header_not_utf8.stl", [12, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("broken/huge_150m_inverted.stl", [60, 0, 3, 0, 0, 24, 4, 1, 0]),
    ("broken/real_part_40_nm_edges.stl", [7826, 0, 40, 0, 0, 0, 1, 1, 0]),
    ("broken/coincident_bodies.stl", [34428, 0, 6083, 0, 3004, 0, 1, 1, 0]),
    ("broken/ascii_cr_only.stl", [12, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("broken/ascii_nonstandard.stl", [12, 0, 0, 0, 0, 0, 1, 1, 0]),
];

const OBJ_AND_PLY: &[(&str, [u64; 9])] = &[
    ("clean/gyroid_puzzle.ply", [28394, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("clean/prusa_text_12.obj", [1694, 0, 0, 0, 0, 0, 12, 12, 0]),
    ("calibration/two_hollow_squares.obj", [96, 0, 0, 0, 0, 0, 2, 2, 0]),
    ("calibration/bridge_40.obj", [28, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("calibration/u_overhang.obj", [28, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("calibration/v_standing.obj", [24, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("broken/nonmanifold_18_edges.obj", [1442, 0, 18, 0, 3, 1, 4, 2, 0]),
    ("formats/featuretype_closed.ply", [3476, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("formats/crlf_header.ply", [12, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("formats/negative_indices.obj", [12, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("formats/quads_utf16.obj", [12, 0, 0, 0, 0, 0, 1, 1, 0]),
];

const THREEMF: &[(&str, [u64; 9])] = &[
    ("formats/box.3mf", [12, 0, 0, 0, 0, 0, 1, 1, 0]),
    ("formats/cube_gears.3mf", [25692, 0, 0, 0, 0, 92, 17, 17, 0]),
    // The same gears, each in a model part of its own.
    ("formats/production_required.3mf", [25692, 0, 0, 0, 0, 92, 17, 17, 0]),
    ("formats/chain_loop.3mf", [7680, 0, 0, 0, 0, 0, 40, 40, 0]),
    ("formats/units_transform.3mf", [60, 0, 0, 0, 0, 0, 2, 2, 0]),
    ("formats/benchy_225k.3mf", [225154, 0, 0, 0, 0, 11, 1, 1, 0]),
];

fn expect(table: &[(&str, [u64; 9])]) {
    for (name, expected) in table {
        let Some(loaded) = load(name) else { return };
        let mesh = loaded.unwrap_or_else(|e| panic!("{name}: {e}")).mesh;
        let h = Health::of(&mesh);
        let found = [
            mesh.triangles.len() as u64,
            h.open_edges.count,
            h.non_manifold_edges.count,
            h.miswound_edges.count,
            h.duplicate_facets.count,
            h.zero_area_facets.count,
            h.shells.len() as u64,
            h.bodies.len() as u64,
            h.count_of(Role::Cavity),
        ];
        assert_eq!(&found, expected, "{name}");
    }
}

#[test]
fn stl_files_have_the_counts_of_the_manifest() {
    expect(STL);
}

#[test]
fn obj_and_ply_files_have_the_counts_of_the_manifest() {
    expect(OBJ_AND_PLY);
}

#[test]
fn threemf_files_have_the_counts_of_the_manifest() {
    expect(THREEMF);
    for (name, size, volume) in [
        ("formats/box.3mf", [10.0, 20.0, 30.0], 6000.0),
        ("formats/units_transform.3mf", [70.0, 60.0, 30.0], 14_000.0),
        ("formats/benchy_225k.3mf", [60.001, 31.004, 48.0], 15_550.5),
    ] {
        let Some(loaded) = load(name) else { return };
        let mesh = loaded.unwrap().mesh;
        let (lo, hi) = mesh.bounds().unwrap();
        // The manifest prints three decimals; a transform of it has seven digits.
        (0..3).for_each(|a| assert!((hi[a] - lo[a] - size[a]).abs() < 1e-3, "{name}: {lo:?} {hi:?}"));
        assert!((Health::of(&mesh).volume_mm3() / volume - 1.0).abs() < 1e-5, "{name}");
    }
}

#[test]
fn extensions_are_refused_by_name() {
    let Some(loaded) = load("formats/beam_lattice_only.3mf") else { return };
    let error = loaded.unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }) && error.to_string().contains("beamlattice"), "{error}");
}

#[test]
fn known_volumes_are_met() {
    // Volumes of the manifest, printed there to three decimals.
    for (name, cavities, volume) in [
        ("clean/nop_gridfinity_1_cavity.stl", 1, 46_591.908),
        ("clean/nop_gridfinity_10_cavities.stl", 10, 515_306.0),
        ("clean/openscad_trapped_sphere.stl", 1, 112.644),
        ("clean/enable_compliant_finger.stl", 8, 3310.3),
    ] {
        let Some(loaded) = load(name) else { return };
        let h = Health::of(&loaded.unwrap().mesh);
        let voids: Vec<f64> = h.shells.iter().filter(|s| s.role == Role::Cavity).map(|s| s.volume_mm3.abs()).collect();
        assert_eq!(voids.len(), cavities, "{name}");
        assert!((voids.iter().sum::<f64>() / volume - 1.0).abs() < 2e-5, "{name}: {voids:?}");
    }
    let Some(cylinder) = load("calibration/cylinder1000.stl") else { return };
    assert!((Health::of(&cylinder.unwrap().mesh).volume_mm3() - 3141.572).abs() < 1e-3);
}

#[test]
fn what_can_be_mended_is_mended() {
    let mended = |name: &str| {
        let loaded = load(name)?.unwrap();
        // Well below the resolution of any process, well above the rounding of these files.
        Some(Health::of(&amcheck::geometry::health::repaired(&loaded.mesh, 1e-4).mesh))
    };
    let Some(stitched) = mended("broken/open_576_edges.stl") else { return };
    let twin = Health::of(&load("formats/featuretype_closed.ply").unwrap().unwrap().mesh);
    assert!(stitched.is_watertight());
    // Corners moved by up to 1e-6 of a part of 12 mm³ and 46 mm².
    assert!((stitched.volume_mm3() - twin.volume_mm3()).abs() < 1e-4);
    let turned = mended("broken/flipped_solid.stl").unwrap();
    assert!(turned.is_watertight() && turned.count_of(Role::Body) == 1);
    // Walls between coincident bodies go, the volume stays.
    let joined = mended("broken/coincident_bodies.stl").unwrap();
    assert!(joined.non_manifold_edges.count < 100 && joined.duplicate_facets.count == 0);
    assert!((joined.volume_mm3() - 17_431.630).abs() < 1e-3);
    let outward = mended("broken/huge_150m_inverted.stl").unwrap();
    assert!(!outward.inverted && outward.is_solid());
}

#[test]
fn oddities_are_said() {
    let Some(carriage) = load("clean/prusa_x_carriage.stl") else { return };
    let codes = |loaded: Loaded| -> Vec<String> {
        let own = loaded.notices.iter().map(|n| n.code.clone());
        let health = Health::of(&loaded.mesh);
        own.chain(health.notices().into_iter().chain(health.units_guess()).map(|n| n.code)).collect()
    };
    assert_eq!(codes(carriage.unwrap()), ["inner-shells", "ghost-shell"]);
    for (name, expected) in [
        ("broken/huge_150m_inverted.stl", &["non-manifold", "zero-area", "inverted", "ghost-shell", "units-guess"][..]),
        ("broken/closed_metres.stl", &["units-guess"]),
        ("broken/one_trailing_byte.stl", &["trailing-bytes"]),
        ("broken/ascii_nonstandard.stl", &["stray-text"]),
    ] {
        assert_eq!(codes(load(name).unwrap().unwrap()), expected, "{name}");
    }
}

#[test]
fn broken_files_are_refused_with_their_place() {
    for (name, place) in [
        ("broken/bad_vertex.stl", Some("line 89")),
        ("broken/truncated_ascii.stl", Some("line 4")),
        ("broken/empty_0_bytes.stl", None),
        ("broken/empty_header_only.stl", None),
        ("broken/empty_solid_26_bytes.stl", None),
        ("broken/index_out_of_range.obj", Some("line 23")),
        ("broken/fuzz_bad_crc.3mf", Some("3D/3dmodel.model")),
        ("broken/decimal_comma.3mf", Some("3D/3dmodel.model, line 9")),
        ("broken/not_a_zip.3mf", None),
        ("broken/build_item_missing_object.3mf", Some("3D/3dmodel.model, line 85")),
        ("broken/dtd_in_model.3mf", Some("3D/3dmodel.model, line 4")),
        ("broken/float_max.obj", Some("line 3")),
        ("broken/fuzz_crash.ply", Some("line 7")),
        ("formats/points_only.ply", None),
    ] {
        let Some(loaded) = load(name) else { return };
        let error = loaded.unwrap_err();
        assert_eq!((error.exit_code(), error.place().as_deref()), (4, place), "{name}: {error}");
    }
}

#[test]
#[ignore = "a measurement, not a test"]
fn loading_and_health_in_time() {
    let Some(folder) = models() else { return };
    for name in ["formats/benchy_225k.3mf", "clean/enable_pip_hand_16.stl", "clean/nop_enviro_case.stl"] {
        for _ in 0..3 {
            let start = std::time::Instant::now();
            let (_, loaded) = read_path(&folder.join(name), 1 << 30, Salvage::Refuse).unwrap();
            let read = start.elapsed();
            let health = Health::of(&loaded.mesh);
            println!("{name}: read {read:?}, health {:?}, {} bodies", start.elapsed() - read, health.bodies.len());
        }
    }
}
