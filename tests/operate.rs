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
        ("open part.stl box:2x1x1mm", 192.0, "part_open.stl"),
        ("open part.stl cylinder:r1h1mm --out turned.stl", (8.0 * 6.0 - (4.0 - PI)) * 4.0, "turned.stl"),
        ("close part.stl pin.stl --out shut.stl", 192.0, "shut.stl"),
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
fn a_sweep_lies_where_it_does_however_its_path_is_told() {
    let bench = Bench::new("poses");
    let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    bench.put("arm.stl", &mesh("box:10x2x4mm").transformed(still, [10.0, 0.0, 2.0]));
    std::fs::write(bench.0.join("points.csv"), "0, 0, 0\n10, 0, 0\n").unwrap();
    std::fs::write(bench.0.join("poses.csv"), "0, 0, 0, 1, 0, 0, 0\n10, 0, 0, 1, 0, 0, 0\n").unwrap();
    for way in ["points", "poses"] {
        for (voxel, h) in [("", 0.3212), (" --voxel 0.5mm", 0.5)] {
            let said = bench.amcheck(&format!("sweep arm.stl --along {way}.csv --out made.stl{voxel}"));
            assert_eq!(said.code, 0, "{}", said.err);
            let made = closed(&bench.0.join("made.stl"));
            assert!((made.signed_volume() / 160.0 - 1.0).abs() < 0.005, "{way}{voxel}: {}", made.signed_volume());
            let (lo, hi) = made.bounds().unwrap();
            let off =
                |found: [f64; 3], truth: [f64; 3]| (0..3).map(|a| (found[a] - truth[a]).abs()).fold(0.0, f64::max);
            let off = off(lo, [5.0, -1.0, 0.0]).max(off(hi, [25.0, 1.0, 4.0]));
            assert!(off < 0.05 * h, "{way}{voxel}: {off} {lo:?} {hi:?}");
        }
    }
}

#[test]
fn a_ball_as_large_as_a_part_is_what_its_opening_leaves_or_nothing_is() {
    let bench = Bench::new("as-large");
    let truth = 4.0 / 3.0 * PI * 125.0;
    for part in ["box:10x10x10mm", "cylinder:r5h10mm", "ball:5mm"] {
        for radius in ["4.99mm", "5mm"] {
            let said = bench.amcheck(&format!("open {part} --radius {radius} --voxel 0.2mm --out open.stl"));
            assert_eq!(said.code, 0, "{part} {radius}: {}", said.err);
            let [volume, low, high] = volumes(&said.out);
            assert!(low <= truth && truth <= high, "{part} {radius}: {low} … {high}");
            assert!((volume / truth - 1.0).abs() < 0.02, "{part} {radius}: {volume}");
        }
        // Where it stands is a point, without volume.
        for words in ["offset PART --by -5mm", "difference PART ball:5mm", "open PART --radius 5.1mm"] {
            let said = bench.amcheck(&words.replace("PART", part));
            assert!(said.code == 4 && said.err.contains("error[E013]"), "{words} {part}: {}", said.err);
        }
    }
}

#[test]
fn a_bracket_that_leaves_much_open_is_told() {
    let bench = Bench::new("wide");
    for (words, told) in [
        ("offset box:1x1x1mm --by 0.1mm --voxel 2mm", "more than half of it"),
        ("minkowski box:1x1x1mm box:1x1x1mm --voxel 3mm", "no volume of it is certain"),
        ("offset part.stl --by 0.1mm", ""),
    ] {
        let said = bench.amcheck(&format!("{words} --out made.stl"));
        assert!(said.code == 0 && said.out.contains(told), "{words}: {}", said.out);
        assert_eq!(said.out.contains("a smaller --voxel says more"), !told.is_empty(), "{words}: {}", said.out);
    }
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

/// Two layers of a frame of 10 × 6 mm (outer edge of the beads), 0.4 mm wide, 0.2 mm high, and a travel between them.
const FRAME: &str = "G21\nG90\nM82\nG0 X0.2 Y0.2 Z0.2\nG1 X9.8 E1\nG1 Y5.8 E2\nG1 X0.2 E3\nG1 Y0.2 E4\n\
                     G0 X3 Y3 Z0.4\nG0 X0.2 Y0.2\nG1 X9.8 E5\nG1 Y5.8 E6\nG1 X0.2 E7\nG1 Y0.2 E8\n";

#[test]
fn gcode_is_swept_and_compared_with_its_design() {
    let bench = Bench::new("gcode");
    std::fs::write(bench.0.join("frame.gcode"), FRAME).unwrap();
    let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    bench.put("design.stl", &mesh("box:10x6x0.4mm").transformed(still, [5.0, 3.0, 0.2]));
    let said =
        bench.amcheck("sweep --gcode frame.gcode --bead 0.4x0.2mm --design design.stl --voxel 0.05mm --picture f.png");
    assert_eq!((said.code, said.err.as_str()), (0, ""));
    // A frame with round outer corners: the design's inner 9.2 × 5.2 mm are missing, and four corners of r²·(1 − π/4).
    let corners = 4.0 * 0.04 * (1.0 - PI / 4.0) * 0.4;
    let (frame, hole) = ((60.0 - 9.2 * 5.2) * 0.4 - corners, 9.2 * 5.2 * 0.4 + corners);
    for (word, truth) in [("volume", frame), ("missing", hole), ("over", 0.0)] {
        let line = said.out.lines().find(|l| l.starts_with(word)).unwrap();
        let numbers: Vec<f64> = line.split([' ', ',']).filter_map(|w| w.parse().ok()).collect();
        let [estimate, low, high] = numbers[..] else { panic!("{line}") };
        assert!(low - 1e-3 <= truth && truth <= high + 1e-3, "{truth}: {line}");
        assert!((estimate - truth).abs() < 0.02 * frame, "{truth}: {line}");
    }
    assert!(said.out.contains("bead       0.4 × 0.4 × 0.2 mm along 60.8 mm in 2 strokes"), "{}", said.out);
    let made = closed(&bench.0.join("frame_sweep.stl"));
    assert!((made.signed_volume() / frame - 1.0).abs() < 0.02, "{} {frame}", made.signed_volume());
    assert!(std::fs::read(bench.0.join("f.png")).unwrap().starts_with(b"\x89PNG"));
    // Without options the bead is that of the fdm process; a built-in element stands about the path.
    let said = bench.amcheck("sweep --gcode frame.gcode --out plain.stl");
    assert!(said.code == 0 && said.out.contains(" mm along 60.8 mm"), "{} {}", said.out, said.err);
    let said = bench.amcheck("sweep ball:0.3mm --gcode frame.gcode --out ball.stl");
    assert!(said.code == 0 && said.out.contains("0.6 × 0.6 × 0.6"), "{} {}", said.out, said.err);
}

#[test]
fn fields_and_a_picture_are_written_on_demand() {
    let bench = Bench::new("fields");
    for words in ["offset part.stl --by 1mm", "minkowski part.stl box:2x1x1mm", "open part.stl --radius 1mm"] {
        let said = bench.amcheck(&format!(
            "{words} --voxel 0.25mm --field a.npy --field a.nrrd --field deep/a.vti --picture a.png"
        ));
        assert_eq!((said.code, said.err.as_str()), (0, ""), "{words}");
        assert_eq!(said.out.matches("written").count(), 5, "{}", said.out);
        let npy = std::fs::read(bench.0.join("a.npy")).unwrap();
        let vti = std::fs::read(bench.0.join("deep/a.vti")).unwrap();
        let nrrd = std::fs::read(bench.0.join("a.nrrd")).unwrap();
        assert!(nrrd.starts_with(b"NRRD0004") && nrrd.ends_with(&npy[128..]), "the same samples in the same order");
        let shape = String::from_utf8_lossy(&npy[..128]).into_owned();
        let counts: Vec<usize> = shape.split(['(', ',', ')', ' ']).filter_map(|w| w.parse().ok()).collect();
        let values: Vec<f32> = npy[128..].chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!(values.len(), counts.iter().product::<usize>(), "{words}: {shape}");
        // [z, y, x] of a box of 8 × 6 × 4 mm, in C order, as the help says.
        assert!(
            counts.len() == 3 && counts.is_sorted() && shape.contains("'fortran_order': False"),
            "{words}: {shape}"
        );
        let help = bench.amcheck(&format!("{} --help", words.split(' ').next().unwrap())).out;
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(help.contains("f32[z, y, x] in C order"), "{help}");
        // Negative inside: as many samples as the volume has cubes, but for the surface.
        let [volume, ..] = volumes(&said.out);
        let inside = values.iter().filter(|v| **v <= 0.0).count() as f64 * 0.25f64.powi(3);
        assert!((inside / volume - 1.0).abs() < 0.2, "{words}: {inside} {volume}");
        assert!(String::from_utf8_lossy(&vti[..400]).contains("signed_distance_mm"));
        // A panel for the part, the element where there is one, and the result.
        let panels = if words.starts_with("offset") { 2 } else { 3 };
        assert_eq!(image::open(bench.0.join("a.png")).unwrap().width(), panels * 560, "{words}");
    }
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
    std::fs::write(bench.0.join("one.gcode"), "G0 X1 Y1\nG1 X1 Y1 E1\n").unwrap();
    std::fs::write(bench.0.join("none.gcode"), "; nothing\nG28\n").unwrap();
    std::fs::write(bench.0.join("arc.gcode"), "G1 X1 E1\nG2 X2 Y2 E2\n").unwrap();
    std::fs::write(bench.0.join("plane.gcode"), "G18\nG2 X2 Z2 I1 E2\n").unwrap();
    std::fs::write(bench.0.join("spline.gcode"), "G1 X1 E1\nG5 X2 Y2 I1 J1 P1 Q1 E2\n").unwrap();
    std::fs::write(bench.0.join("good.gcode"), FRAME).unwrap();
    for name in ["large.stl", "large.csv", "large.gcode"] {
        std::fs::write(bench.0.join(name), vec![b'\n'; 2 << 20]).unwrap();
    }
    let mut open = mesh("box:4x4x4mm");
    open.triangles.pop();
    bench.put("open.stl", &open);
    std::fs::create_dir(bench.0.join("folder.stl")).unwrap();
    std::fs::write(bench.0.join("waiting.csv"), "1 0 0 1 0 0 0\n1 0 0 1 0 0 0\n").unwrap();
    let before = bench.names();
    for (words, code, says) in [
        ("offset empty.stl --by 1mm", 4, &["E013", "empty", "--> empty.stl"][..]),
        ("offset prt.stl --by 1mm", 4, &["E010", "no such file", "`part.stl`"]),
        ("minkowski part.stl empty.stl", 4, &["E013", "--> empty.stl"]),
        ("minkowski part.stl none.stl", 4, &["E010", "none.stl"]),
        ("offset open.stl --by 1mm", 4, &["E014", "open", "--> open.stl: near"]),
        (
            "difference part.stl box:9x1x1mm",
            4,
            &["E013", "nothing remains", "longer in x than the part, 9 mm to 8 mm", "fits nowhere"],
        ),
        ("open part.stl --radius 50mm", 4, &["E013", "fits nowhere"]),
        ("minkowski part.stl ball:9000mm --voxel 0.1mm", 5, &["E020", "--voxel", "--memory"]),
        ("minkowski part.stl box:9000x9000x9000mm --voxel 0.1mm", 5, &["E020"]),
        ("open part.stl box:9x1x1mm", 4, &["E013", "longer in x than the part, 9 mm to 8 mm", "fits nowhere"]),
        ("open part.stl", 2, &["E001", "--radius"]),
        ("close part.stl ball:1mm --radius 1mm", 2, &["E001", "--radius"]),
        ("open - -", 2, &["E001", "standard input"]),
        ("sweep part.stl --along waiting.csv", 2, &["E041"]),
        ("offset part.stl --by -2.5mm", 4, &["E013", "nothing remains"]),
        ("offset part.stl --by 1mm --voxel 0.0001mm", 5, &["E020", "--voxel", "fits"]),
        // Whatever is read keeps to the memory that is allowed, a third of it at most.
        ("offset large.stl --by 1mm --memory 3MiB", 5, &["E020", "large.stl", "--memory"]),
        ("minkowski part.stl large.stl --memory 3MiB", 5, &["E020", "large.stl", "--memory"]),
        ("sweep part.stl --along large.csv --memory 3MiB", 5, &["E020", "large.csv", "--memory"]),
        ("sweep --gcode large.gcode --memory 3MiB", 5, &["E020", "large.gcode", "--memory"]),
        ("orient large.stl --memory 3MiB", 5, &["E020", "large.stl", "--memory"]),
        ("orient part.stl --memory 3MiB", 5, &["E020", "triangles", "--memory"]),
        ("part.stl --tool large.stl --memory 3MiB", 5, &["E020", "large.stl", "--memory"]),
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
        ("sweep --gcode one.gcode", 4, &["E013", "two points", "--> one.gcode"]),
        ("sweep --gcode none.gcode", 4, &["E013", "--> none.gcode"]),
        ("sweep --gcode arc.gcode", 4, &["E011", "arc.gcode: line 2"]),
        ("sweep --gcode plane.gcode", 4, &["E012", "plane", "line 2"]),
        ("sweep --gcode spline.gcode", 4, &["E012", "spline", "line 2"]),
        ("sweep --gcode lost.gcode", 4, &["E010", "lost.gcode"]),
        ("sweep --gcode good.gcode --bead 0.4mm", 2, &["E001", "0.4mm", "--bead"]),
        ("sweep --gcode good.gcode --bead 0.4x0mm", 2, &["E041", "not positive"]),
        ("sweep --gcode good.gcode --bead nanxnan", 2, &["E001"]),
        ("sweep --gcode good.gcode --voxel 0.0001mm", 5, &["E020", "--voxel"]),
        ("sweep --gcode good.gcode --design empty.stl", 4, &["E013", "--> empty.stl"]),
        ("sweep part.stl --gcode good.gcode", 4, &["E012", "mesh as a bead"]),
        ("sweep cone:r1r0h1mm --gcode good.gcode", 4, &["E012", "cone as a bead"]),
        ("sweep part.stl --along still.csv --bead 1x1mm", 2, &["E001", "--bead"]),
        ("offset part.stl --by 1mm --field x.raw", 2, &["E002", "`raw`", "npy, nrrd, vti"]),
        ("offset part.stl --by 1mm --picture x.jpg", 2, &["E002", "jpg"]),
        ("offset part.stl --by 1mm --field part.stl/x.npy", 6, &["E030"]),
        ("offset part.stl --by -2.5mm --field deep/x.npy --picture x.png", 4, &["E013", "nothing remains"]),
        ("offset part.stl --by 1mm --voxel 0mm", 2, &["E001", "--voxel"]),
        ("offset part.stl --by 1mm --memory lots", 2, &["E001", "lots"]),
        ("offset part.stl --by 1mm --out part.step", 2, &["E002", "`step`", "`stl`"]),
        ("offset part.stl --by 1mm --out part", 2, &["E002", "stl, glb, obj, ply, 3mf"]),
        ("offset part.stl --by 1mm --out folder.stl", 6, &["E030", "folder"]),
        ("offset part.stl --by 1mm --out part.stl/x.stl", 6, &["E030", "part.stl"]),
        ("open part.stl --radius 50mm --out new/deep/x.stl", 4, &["E013"]),
        // What a result is made of is never replaced by it.
        ("offset part.stl --by 1mm --out part.stl", 6, &["E030", "part.stl", "made from this very file"]),
        ("offset part.stl --by 1mm --out ./part.stl", 6, &["E030", "--out"]),
        ("minkowski box:1x1x1mm part.stl --out part.stl", 6, &["E030", "part.stl"]),
        ("sweep ball:1mm --along still.csv --out x.stl --field still.npy --picture part.stl/p.png", 6, &["E030"]),
        ("sweep --gcode good.gcode --design part.stl --out part.stl", 6, &["E030", "part.stl"]),
        ("minkowski - -", 2, &["E001", "standard input", "2 operands"]),
        ("sweep - --along -", 2, &["E001", "standard input"]),
        ("sweep --gcode - --design -", 2, &["E001", "standard input"]),
        ("offset", 2, &["`amcheck offset --help`"]),
        ("offset box:8x6x0.4mm --by -0.199mm --voxel 0.5mm", 4, &["E013", "at this spacing", "smaller spacing"]),
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
