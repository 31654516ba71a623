//! The press on an invented part: every format is looked at from outside.

mod sample;

use amcheck::analyze::{Options, prepare, run};
use amcheck::check::State;
use amcheck::geometry::TriangleMesh;
use amcheck::io::Loaded;
use amcheck::process::Process;
use amcheck::report::terminal::{self, Outputs, Palette};
use amcheck::report::{Report, html, json, render};

fn outputs() -> Outputs {
    Outputs {
        notes: Vec::new(),
        part: "bracket.stl".into(),
        judged_by: Vec::new(),
        written: vec![
            ("report".into(), "reports/bracket/report.html".into(), 179_000),
            ("data".into(), "reports/bracket/report.json".into(), 9_120),
        ],
        seconds: Some(1.3),
    }
}

#[test]
fn the_schema_accepts_the_report_and_refuses_a_broken_one() {
    let schema: serde_json::Value = serde_json::from_str(json::SCHEMA_TEXT).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let mut value: serde_json::Value = serde_json::from_str(&json::write(&sample::report("bracket.stl"))).unwrap();
    if let Err(e) = validator.validate(&value) {
        panic!("{e} at {}", e.instance_path);
    }
    value["checks"][2]["findings"][0]["state"] = "perhaps".into();
    assert!(!validator.is_valid(&value));
    value["checks"][2]["findings"] = serde_json::json!([]);
    assert!(validator.is_valid(&value));
    value["checks"][5].as_object_mut().unwrap().remove("why");
    assert!(!validator.is_valid(&value), "a check that did not run must say why");
}

/// What `tests/parts` makes of every committed part is what is kept, byte for byte.
#[test]
fn every_kept_report_keeps_to_the_schema() {
    let validator = jsonschema::validator_for(&serde_json::from_str(json::SCHEMA_TEXT).unwrap()).unwrap();
    let kept = sample::kept();
    assert!(kept.len() > 30, "{} reports are kept", kept.len());
    for (name, text) in kept {
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let faults: Vec<String> = validator.iter_errors(&value).map(|e| format!("{}: {e}", e.instance_path)).collect();
        assert!(faults.is_empty(), "{name}: {faults:?}");
    }
}

#[test]
fn json_reads_back_as_the_same_report_and_hides_no_markup() {
    let report = sample::report(sample::HOSTILE);
    let text = json::write(&report);
    let back: Report = serde_json::from_str(&text).unwrap();
    assert!(json::write(&back) == text, "what was read back is written differently");
    let inside = json::inside_html(&text);
    assert!(!inside.contains('<') && !inside.contains('>'));
    assert!(serde_json::from_str::<Report>(&inside).unwrap() == back);
    assert_eq!(back.part.file, sample::HOSTILE);
}

#[test]
fn the_summary_is_short_worst_first_and_plain_without_colour() {
    let report = sample::report("bracket.stl");
    let text = terminal::summary(&report, &outputs(), Palette::Plain);
    println!("{text}");
    assert!(text.lines().count() <= 30, "{text}");
    assert!(text.chars().all(|c| c == '\n' || !c.is_control()));
    let at = |needle: &str| text.find(needle).unwrap_or_else(|| panic!("{needle} is missing in\n{text}"));
    assert!(at("thin-wall[1]") < at("blend[1]") && at("blend[1]") < at("thin-wall[2]"), "{text}");
    assert!(text.contains("0.45 mm") && text.contains("must ≥ 0.5 mm") && text.contains("fix: Thicken"));
    let coloured = terminal::summary(&report, &outputs(), Palette::Ansi);
    assert!(coloured.contains("\u{1b}[1;31m"));
}

#[test]
fn a_hundred_findings_and_hostile_names_still_fit_thirty_lines() {
    let mut report = sample::report("a\u{1b}[2J\nb.stl");
    let one = report.checks[2].findings[0].clone();
    report.checks[2].findings = vec![one; 100];
    for (c, state) in report.checks.iter_mut().zip([State::Error, State::Pass]) {
        (c.state, c.why) = (state, Some("line\nline".repeat(80)));
    }
    let text = terminal::summary(&report, &outputs(), Palette::Plain);
    assert!(text.lines().count() <= 30, "{} lines\n{text}", text.lines().count());
    assert!(text.contains("more in the report") && !text.contains('\u{1b}'));
}

#[test]
fn twenty_two_checks_fit_the_terminal_and_every_one_of_them_the_page() {
    let (report, exhibit) = sample::crowded("bracket.stl");
    let text = terminal::summary(&report, &outputs(), Palette::Plain);
    println!("{text}");
    assert!(text.lines().count() <= 30 && text.lines().all(|l| l.chars().count() <= 120), "{text}");
    // Every failing check shows its worst before any shows its second, and what is accepted is said.
    let shown: Vec<&str> = text.lines().filter(|l| l.starts_with('✖') && l.contains('[')).collect();
    let second = shown.iter().position(|l| l.contains("[2]")).unwrap_or(shown.len());
    let failing = report.checks.iter().filter(|c| c.state == State::Fail).count();
    assert!(second >= failing.min(shown.len()), "{text}");
    assert!(text.contains("accepted until 2027-06-30: A living hinge"), "{text}");
    let pictures = render::pictures(&report, &exhibit);
    std::fs::write(shelf().join("crowded.png"), &pictures.iter().find(|p| p.name == "summary").unwrap().png).unwrap();
    let page = html::page(&report, &exhibit, &pictures);
    std::fs::write(shelf().join("crowded.html"), &page).unwrap();
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
    for c in &report.checks {
        assert!(page.contains(&c.title), "{} is missing", c.title);
    }
    assert!(page.contains("All 22 checks") && page.contains("<kbd>0</kbd>") && page.contains("id=\"map-10\""));
    assert!(page.contains(", estimated") && page.contains("Acceptance ended on 2025-06-30"));
    assert!(page.contains("class=\"finding accepted\"") && page.contains("What, why and how"));
    let schema: serde_json::Value = serde_json::from_str(json::SCHEMA_TEXT).unwrap();
    let value: serde_json::Value = serde_json::from_str(&json::write(&report)).unwrap();
    let faults: Vec<String> =
        jsonschema::validator_for(&schema).unwrap().iter_errors(&value).map(|e| e.to_string()).collect();
    assert!(faults.is_empty(), "{faults:?}");
}

/// Where tests leave what a person may want to look at.
fn shelf() -> std::path::PathBuf {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("press");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn every_map_every_check_and_every_slice_gets_a_picture() {
    let report = sample::report("bracket.stl");
    let pictures = render::pictures(&report, &sample::exhibit(2.0));
    for p in &pictures {
        std::fs::write(shelf().join(format!("{}.png", p.name)), &p.png).unwrap();
        let image = image::load_from_memory(&p.png).unwrap();
        assert!(image.width() >= 460 && p.png.len() < 120_000, "{}: {} bytes", p.name, p.png.len());
        assert!(!p.alt.is_empty());
    }
    let names: Vec<&str> = pictures.iter().map(|p| p.name.as_str()).collect();
    for name in [
        "summary",
        "thin-wall",
        "overhang",
        "narrow-gap",
        "close-thin-wall",
        "close-trapped-volume",
        "slice-x",
        "slice-z",
    ] {
        assert!(names.contains(&name), "{name} is missing in {names:?}");
    }
    assert!(pictures == render::pictures(&report, &sample::exhibit(2.0)), "the same input gives other bytes");
}

#[test]
fn an_empty_exhibit_and_an_empty_report_still_give_pictures() {
    let mut report = sample::report("bracket.stl");
    report.checks.clear();
    let pictures = render::pictures(&report, &amcheck::report::Exhibit::default());
    assert_eq!(pictures.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["part", "summary"]);
}

fn page_of(file: &str) -> String {
    let report = sample::report(file);
    let exhibit = sample::exhibit(2.0);
    let pictures = render::pictures(&report, &exhibit);
    html::page(&report, &exhibit, &pictures)
}

#[test]
fn the_page_is_whole_small_and_asks_for_nothing() {
    let page = page_of("bracket.stl");
    std::fs::write(shelf().join("report.html"), &page).unwrap();
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
    for needle in [
        "Can it be made?",
        "Where not?",
        "How sure is that?",
        "What should change?",
        "Not printable as is",
        "must ≥ 0.5 mm, should ≥ 0.8 mm",
        "−0.05 mm (−10 %) to must",
        "left out by --skip island",
        "id=\"thin-wall-1\"",
        "id=\"check-narrow-gap\"",
        "Slices through the worst finding",
        "duplicate-facets",
        "default-src 'none'",
    ] {
        assert!(page.contains(needle), "{needle} is missing");
    }
    for foreign in ["http://", "https://", "//cdn", "url(", "@import"] {
        let rest = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!rest.contains(foreign), "the page names {foreign}");
    }
    assert!(page == page_of("bracket.stl"), "the same input gives other bytes");
}

#[test]
fn a_hostile_name_stays_a_name_in_the_page() {
    let page = page_of(sample::HOSTILE);
    assert!(!page.contains("<img src=x>") && !page.contains("</script><"), "the name breaks out");
    assert!(page.contains("&lt;/script&gt;&lt;img src=x&gt;.stl") && page.contains("\\u003c/script\\u003e"));
    assert_eq!(page.matches("</script>").count(), page.matches("<script").count());
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| page_of("bracket.stl"))
    };
    assert!(with(1) == with(3));
}

/// Says how long the press takes for about 100,000 corners; a figure to read (`--nocapture`), not a limit.
#[test]
fn the_time_of_the_press_is_said() {
    let (report, exhibit) = (sample::report("bracket.stl"), sample::exhibit(1.8));
    let start = std::time::Instant::now();
    let pictures = render::pictures(&report, &exhibit);
    let drawn = start.elapsed();
    let page = html::page(&report, &exhibit, &pictures);
    let printed = start.elapsed() - drawn;
    println!("{} corners: pictures {drawn:.0?}, page {printed:.0?}, {} bytes", exhibit.corners.len(), page.len());
}

#[test]
fn a_page_of_a_large_part_shows_a_coarser_copy_and_says_so() {
    let mut exhibit = sample::exhibit(0.9);
    // Values that do not compress.
    let mut seed = 3u64;
    for v in exhibit.maps.iter_mut().flat_map(|m| &mut m.values) {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        *v = (seed >> 40) as f32 / (1u64 << 24) as f32 * 4.0;
    }
    let report = sample::report("bracket.stl");
    let page = html::page(&report, &exhibit, &[]);
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
    std::fs::write(shelf().join("large.html"), &page).unwrap();
    assert!(page.contains("a coarser copy, corners within ") && page.contains("viewer-part"), "{} bytes", page.len());
}

#[test]
fn commands_on_the_page_are_quoted_for_a_shell() {
    let page = html::page(&sample::report("mein $(id) 'teil'.stl"), &sample::exhibit(9.0), &[]);
    let quoted = amcheck::report::markup::escaped(r"amcheck orient 'mein $(id) '\''teil'\''.stl'");
    assert!(page.contains(&format!("<code>{quoted}</code>")), "no {quoted}");
}

/// Exhibits that no careful pipeline makes: the press says what it can and never panics or hangs.
#[test]
fn broken_exhibits_do_no_harm() {
    let nan = f64::NAN;
    let strange: [&dyn Fn(&mut amcheck::report::Exhibit); 8] = [
        &|e| e.corners[5] = [nan, 0.0, f64::INFINITY],
        &|e| e.corners.iter_mut().for_each(|p| *p = [nan; 3]),
        &|e| e.corners.iter_mut().for_each(|p| *p = p.map(|x| x * 1e12)),
        &|e| e.corners.truncate(7),
        &|e| e.maps.iter_mut().for_each(|m| m.values.truncate(4)),
        &|e| e.maps.iter_mut().for_each(|m| (m.fail, m.warn, m.open_end) = (Some(nan), Some(-1.0), nan)),
        &|e| e.maps.iter_mut().for_each(|m| m.values.iter_mut().for_each(|v| *v = f32::INFINITY)),
        &|e| e.slices.iter_mut().for_each(|s| (s.width, s.height, s.spacing_mm, s.axis) = (0, 9, 0.0, 7)),
    ];
    for (i, spoil) in strange.iter().enumerate() {
        let mut exhibit = sample::exhibit(9.0);
        spoil(&mut exhibit);
        let mut report = sample::report("bracket.stl");
        if i == 0 {
            let f = &mut report.checks[2].findings[0];
            (f.value, f.low, f.high, f.at_mm, f.box_mm) = (nan, nan, f64::INFINITY, [nan; 3], [[nan; 3]; 2]);
        }
        let pictures = render::pictures(&report, &exhibit);
        let page = html::page(&report, &exhibit, &pictures);
        assert!(!pictures.is_empty() && page.ends_with("</html>\n"), "{i}");
        assert!(terminal::summary(&report, &outputs(), Palette::Plain).lines().count() <= 30, "{i}");
    }
}

/// A wall of 50 × 30 mm whose thickness grows from 0.5 to 1.4 mm, two triangles a side.
fn taper() -> TriangleMesh {
    let at = |x: f64, y: f64, z: f64| [x, if y > 0.0 { 0.5 + 0.9 * x / 50.0 } else { 0.0 }, z];
    let c = [[0.0, 0.0, 0.0], [50.0, 0.0, 0.0], [50.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let corner = |i: usize, z: f64| at(c[i][0], c[i][1], z);
    let mut facets = vec![];
    for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
        facets.push([corner(i, 0.0), corner(j, 0.0), corner(j, 30.0)]);
        facets.push([corner(i, 0.0), corner(j, 30.0), corner(i, 30.0)]);
    }
    for (z, order) in [(0.0, [0, 2, 1]), (0.0, [0, 3, 2]), (30.0, [0, 1, 2]), (30.0, [0, 2, 3])] {
        facets.push(order.map(|i| corner(i, z)));
    }
    TriangleMesh::weld(facets)
}

/// The value at every corner of the display copy is the thickness there, though the triangle's own corners know only the ends.
#[test]
fn a_triangle_of_50_mm_shows_the_variation_inside_it() {
    let mesh = taper();
    let options = Options { only: vec!["thin-wall".into()], ..Options::new(Process::named("fdm").unwrap()) };
    let loaded = Loaded { mesh, format: "STL (binary)", unit_mm: None, notices: vec![], relative_step: 2f64.powi(-24) };
    let made = run(prepare("a.stl", &[], loaded, &options).unwrap(), &options).unwrap().exhibit;
    let wall = made.maps.iter().find(|m| m.check == "thin-wall").unwrap();
    let apart = |p: [f64; 3], q: [f64; 3]| (0..3).map(|a| (p[a] - q[a]).powi(2)).sum::<f64>().sqrt();
    let mut seen = [0usize; 4];
    for (c, v) in made.corners.chunks_exact(3).zip(wall.values.chunks_exact(3)) {
        // On the flat side, away from the rims, where the nearest opposing point is on the other side.
        let inside = |p: &[f64; 3]| p[1] < 1e-6 && (2.0..48.0).contains(&p[0]) && (2.0..28.0).contains(&p[2]);
        if !c.iter().all(inside) {
            continue;
        }
        let longest = [0, 1, 2].map(|i| apart(c[i], c[(i + 1) % 3])).into_iter().fold(0.0, f64::max);
        assert!(longest <= wall.open_end + 1e-9, "a piece of {longest} mm");
        for (p, v) in c.iter().zip(v) {
            // The distance to a plane that leans by 0.9 in 50; corners are read a hundredth of a piece inside.
            let lean = (0.9f64 / 50.0).atan().cos();
            let true_value = (0.5 + 0.9 * p[0] / 50.0) * lean;
            assert!((f64::from(*v) - true_value).abs() < 0.01 * longest * 0.018 + 2e-3, "{v} at {p:?} is {true_value}");
            seen[(p[0] / 12.5) as usize] += 1;
        }
    }
    assert!(seen.iter().all(|n| *n > 50), "{seen:?}");
}
