//! The commands that make shapes, run as a user runs them: the built binary, files, exit codes, messages.

use amcheck::geometry::{Health, Primitive, TriangleMesh};
use amcheck::io::{Salvage, read, stl};
use amcheck::units::Length;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder of its own for each test, gone at the end.
struct Bench(PathBuf);

/// What a run said.
struct Said {
    code: i32,
    out: String,
    err: String,
}

impl Bench {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("amcheck-operate-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let bench = Bench(folder);
        bench.put("part.stl", &mesh("box:8x6x4mm"));
        bench
    }

    fn put(&self, name: &str, mesh: &TriangleMesh) {
        let mut bytes = Vec::new();
        stl::write(mesh, &mut bytes).unwrap();
        std::fs::write(self.0.join(name), bytes).unwrap();
    }

    fn amcheck(&self, words: &str) -> Said {
        let run = Command::new(env!("CARGO_BIN_EXE_amcheck")).args(words.split(' ')).current_dir(&self.0).output();
        let run = run.unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Said { code: run.status.code().unwrap(), out: text(run.stdout), err: text(run.stderr) }
    }

    /// What lies in the folder, hidden files included.
    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(&self.0)
            .unwrap()
            .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn mesh(text: &str) -> TriangleMesh {
    Primitive::parse(text).unwrap().mesh(Length::mm(0.01))
}

/// The mesh of a written file, which must be closed.
fn closed(file: &Path) -> TriangleMesh {
    let bytes = std::fs::read(file).unwrap();
    let loaded = read(&file.to_string_lossy(), &bytes, Salvage::Refuse).unwrap();
    let health = Health::of(&loaded.mesh);
    assert!(health.is_solid() && health.is_watertight() && !health.inverted, "{}: {health:?}", file.display());
    loaded.mesh
}

/// The numbers of the line `volume 1 mm³, certified 2 … 3 mm³`.
fn volumes(out: &str) -> [f64; 3] {
    let line = out.lines().find(|l| l.starts_with("volume")).unwrap();
    let numbers: Vec<f64> = line.split([' ', ',']).filter_map(|w| w.parse().ok()).collect();
    numbers.try_into().unwrap_or_else(|_| panic!("{line}"))
}

/// What is printed has at most four decimals or six digits.
const PRINTED: f64 = 1e-4;

#[test]
fn every_operation_encloses_the_true_volume_and_writes_a_closed_mesh() {
    let bench = Bench::new("truth");
    bench.put("pin.stl", &mesh("box:2x1x1mm"));
    std::fs::write(bench.0.join("path.csv"), "0, 0, 0\n10, 0, 0\n").unwrap();
    std::fs::write(bench.0.join("path.xyz"), "# up\n0 0 0\n0 0 10\n").unwrap();
    // Steiner: V + A·r + M·r² + 4π/3·r³ with M = π·(8 + 6 + 4) for a box.
    let grown = |r: f64| 192.0 + 208.0 * r + PI * 18.0 * r * r + 4.0 / 3.0 * PI * r.powi(3);
    // Opening by a ball rounds 12 edges and 8 corners: the offset of the box that is smaller by r on all sides.
    let rounded = 48.0 + 88.0 + PI * 12.0 + 4.0 / 3.0 * PI;
    for (words, truth, file) in [
        ("offset part.stl --by 0.5mm", grown(0.5), "part_offset.stl"),
        ("offset part.stl --by -0.5mm", 7.0 * 5.0 * 3.0, "part_offset.stl"),
        ("offset part.stl --by 0.1cm --out grown.ply", grown(1.0), "grown.ply"),
        ("open part.stl --radius 1mm", rounded, "part_open.stl"),
        ("close part.stl --radius 1mm --out deep/er/closed.obj", 192.0, "deep/er/closed.obj"),
        ("minkowski part.stl ball:1mm", grown(1.0), "part_minkowski.stl"),
        ("minkowski part.stl pin.stl --out sum.3mf", 10.0 * 7.0 * 5.0, "sum.3mf"),
        ("minkowski box:8x6x4mm box:2x1x1mm", 10.0 * 7.0 * 5.0, "box_minkowski.stl"),
        ("difference part.stl box:2x1x1mm", 6.0 * 5.0 * 3.0, "part_difference.stl"),
        ("obstacle part.stl cylinder:r1h3mm", (48.0 + 28.0 + PI) * 7.0, "part_obstacle.stl"),
        ("sweep pin.stl --along path.csv", 12.0, "pin_sweep.stl"),
        ("sweep cylinder:r1h3mm --along path.xyz", PI * 13.0, "cylinder_sweep.stl"),
    ] {
        let said = bench.amcheck(words);
        assert_eq!((said.code, said.err.as_str()), (0, ""), "{words}");
        let [volume, low, high] = volumes(&said.out);
        let slack = PRINTED * truth;
        assert!(low - slack <= truth && truth <= high + slack, "{words}: {truth} not in {low} … {high}");
        assert!(low - slack <= volume && volume <= high + slack, "{words}: {volume} not in {low} … {high}");
        let mesh = closed(&bench.0.join(file));
        // Coordinates of a binary STL have 24 bits.
        assert!((mesh.signed_volume() - volume).abs() < 1e-3 * volume, "{words}: {} {volume}", mesh.signed_volume());
        for word in ["path ", "triangles ", "box ", file] {
            assert!(said.out.contains(word), "{words}: no {word} in {}", said.out);
        }
        assert!(said.out.contains(&format!("triangles  {}\n", mesh.triangles.len())), "{words}: {}", said.out);
    }
    assert!(bench.names().iter().all(|n| !n.starts_with('.')), "{:?}", bench.names());
}

#[test]
fn a_real_part_is_offset_opened_and_closed_to_closed_meshes() {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    let models = std::env::var_os("AMCHECK_MODELS").map_or_else(beside, PathBuf::from);
    let part = models.join("clean/prusa_y_motor_holder_slits.stl");
    if !part.exists() {
        println!("skipped: no {}", part.display());
        return;
    }
    let bench = Bench::new("real");
    std::fs::copy(&part, bench.0.join("slits.stl")).unwrap();
    for words in ["offset --by 0.5mm", "offset --by -0.5mm", "open --radius 1mm", "close --radius 1mm"] {
        let said = bench.amcheck(&format!("{words} slits.stl --out made.stl"));
        assert_eq!(said.code, 0, "{words}: {}", said.err);
        let [volume, low, high] = volumes(&said.out);
        assert!(low <= volume && volume <= high, "{words}: {}", said.out);
        let made = closed(&bench.0.join("made.stl"));
        assert!((made.signed_volume() - volume).abs() < 1e-3 * volume, "{words}");
    }
}

#[test]
fn a_scene_for_viewers_units_and_spacing_are_heeded() {
    let bench = Bench::new("options");
    let said = bench.amcheck("offset part.stl --by 1in --units in --voxel 0.1in --out scene.glb");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(std::fs::read(bench.0.join("scene.glb")).unwrap().starts_with(b"glTF"));
    assert!(said.out.contains("at 2.54 mm"), "{}", said.out);
    let inch = 25.4f64.powi(3);
    let truth = (192.0 + 208.0 + PI * 18.0 + 4.0 / 3.0 * PI) * inch;
    let [volume, low, high] = volumes(&said.out);
    assert!(low <= truth && truth <= high && (volume / truth - 1.0).abs() < 0.01, "{volume} {truth}");
}

#[test]
fn the_answer_does_not_depend_on_the_number_of_threads() {
    let bench = Bench::new("threads");
    let run = |threads: &str, out: &str| {
        let words = format!("minkowski part.stl cone:r1r0h1mm --voxel 0.2mm --out {out}");
        let done = Command::new(env!("CARGO_BIN_EXE_amcheck"))
            .args(words.split(' '))
            .env("RAYON_NUM_THREADS", threads)
            .current_dir(&bench.0)
            .output();
        assert!(done.unwrap().status.success());
        std::fs::read(bench.0.join(out)).unwrap()
    };
    assert!(run("1", "one.stl") == run("3", "three.stl"));
}

#[test]
fn what_cannot_be_made_is_said_and_leaves_nothing() {
    let bench = Bench::new("faults");
    std::fs::write(bench.0.join("empty.stl"), b"").unwrap();
    std::fs::write(bench.0.join("one.csv"), "1, 2, 3\n").unwrap();
    std::fs::write(bench.0.join("still.csv"), "1, 2, 3\n1, 2, 3\n").unwrap();
    std::fs::write(bench.0.join("bad.csv"), "0 0 0\n1 nan 2\n").unwrap();
    std::fs::write(bench.0.join("strokes.csv"), "0 0 0\n1 0 0\n\n0 5 0\n1 5 0\n").unwrap();
    let mut open = mesh("box:4x4x4mm");
    open.triangles.pop();
    bench.put("open.stl", &open);
    std::fs::create_dir(bench.0.join("folder.stl")).unwrap();
    let before = bench.names();
    for (words, code, says) in [
        ("offset empty.stl --by 1mm", 4, &["E013", "empty", "--> empty.stl"][..]),
        ("offset prt.stl --by 1mm", 4, &["E010", "no such file", "`part.stl`"]),
        ("minkowski part.stl empty.stl", 4, &["E013", "--> empty.stl"]),
        ("minkowski part.stl none.stl", 4, &["E010", "none.stl"]),
        ("offset open.stl --by 1mm", 4, &["E014", "open", "--> open.stl: near"]),
        ("difference part.stl box:9x1x1mm", 2, &["E041", "9.000 mm long in x", "8.000", "fits nowhere"]),
        ("open part.stl --radius 50mm", 2, &["E041", "fits nowhere"]),
        ("minkowski part.stl ball:9000mm", 5, &["E020", "--voxel", "--memory"]),
        ("minkowski part.stl box:9000x9000x9000mm", 5, &["E020"]),
        ("offset part.stl --by -2.5mm", 4, &["E013", "nothing remains"]),
        ("offset part.stl --by 1mm --voxel 0.0001mm", 5, &["E020", "--voxel", "fits"]),
        ("offset part.stl --by nan", 2, &["E001", "nan"]),
        ("offset part.stl --by 1e999mm", 2, &["E001", "finite"]),
        ("close part.stl --radius 0mm", 2, &["E041", "0 mm is not positive"]),
        ("open part.stl --radius -1mm", 2, &["E041", "-1 mm is not positive"]),
        ("close part.stl --radius infmm", 2, &["E001"]),
        ("minkowski part.stl bell:2mm", 2, &["E002", "bell", "`ball`"]),
        ("minkowski part.stl ball:0mm", 2, &["E041", "not positive"]),
        ("minkowski part.stl box:1x2mm", 2, &["E001", "box:1x2mm"]),
        ("sweep part.stl --along one.csv", 4, &["E013", "two points", "--> one.csv"]),
        ("sweep part.stl --along still.csv", 2, &["E041"]),
        ("sweep part.stl --along bad.csv", 4, &["E011", "bad.csv: line 2"]),
        ("sweep part.stl --along strokes.csv", 4, &["E012", "2 strokes"]),
        ("sweep part.stl --along none.csv", 4, &["E010"]),
        ("offset part.stl --by 1mm --voxel 0mm", 2, &["E001", "--voxel"]),
        ("offset part.stl --by 1mm --memory lots", 2, &["E001", "lots"]),
        ("offset part.stl --by 1mm --out part.step", 2, &["E002", "`step`", "`stl`"]),
        ("offset part.stl --by 1mm --out part", 2, &["E002", "stl, glb, obj, ply, 3mf"]),
        ("offset part.stl --by 1mm --out folder.stl", 6, &["E030", "folder"]),
        ("offset part.stl --by 1mm --out part.stl/x.stl", 6, &["E030", "part.stl"]),
        ("open part.stl --radius 50mm --out new/deep/x.stl", 2, &["E041"]),
        ("offset part.stl", 2, &["--by"]),
        ("sweep part.stl", 2, &["--along"]),
        ("minkowski part.stl", 2, &["<B>"]),
    ] {
        let said = bench.amcheck(words);
        assert_eq!((said.code, said.out.as_str()), (code, ""), "{words}: {}", said.err);
        for word in says {
            assert!(said.err.contains(word), "{words}: no `{word}` in {}", said.err);
        }
        assert_eq!(bench.names(), before, "{words}");
    }
}

#[test]
fn a_result_that_stood_there_survives_a_failure() {
    let bench = Bench::new("survivor");
    assert_eq!(bench.amcheck("offset part.stl --by 1mm --voxel 0.5mm").code, 0);
    let old = std::fs::read(bench.0.join("part_offset.stl")).unwrap();
    assert_eq!(bench.amcheck("offset part.stl --by -2.5mm").code, 4);
    assert_eq!(std::fs::read(bench.0.join("part_offset.stl")).unwrap(), old);
}
