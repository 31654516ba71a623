//! The page `reports/openscad`: each fixture with both results, their difference, and the numbers.

use super::render::processor_seconds;
use super::{Case, cases};
use amcheck::field::Indicator;
use amcheck::geometry::contour::surface;
use amcheck::geometry::{MeshDistance, TriangleMesh, occupancy};
use amcheck::operate::Operated;
use amcheck::report::render::{Panel, side_by_side};
use std::fmt::Write;
use std::path::Path;

/// Spacing of the pictures and of the difference.
const SHOWN_MM: f64 = 0.125;
/// Spacing of the table.
const FINE_MM: f64 = 0.05;
const PANEL: [usize; 2] = [300, 240];

/// One row of the table.
struct Row {
    name: String,
    operation: String,
    /// User seconds: OpenSCAD, amcheck at [`FINE_MM`], amcheck at its default spacing and at twice that.
    seconds: [f64; 4],
    /// OpenSCAD's volume; amcheck's estimate and bracket.
    volume: f64,
    found: [f64; 3],
    /// Of OpenSCAD's result, and of the surface that is shown.
    facets: [usize; 2],
    differing: f64,
    path: String,
}

/// Writes the page and prints the table of README.
#[test]
#[ignore = "writes reports/openscad"]
fn page() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/openscad");
    std::fs::create_dir_all(&folder).unwrap();
    let rows: Vec<Row> = cases().iter().map(|case| row(case, &folder)).collect();
    std::fs::write(folder.join("index.html"), html(&rows)).unwrap();
    std::fs::write(folder.join("table.md"), table(&rows)).unwrap();
    print!("{}", table(&rows));
}

/// The numbers of the page and of README are those of this version; their seconds are those of the machine that wrote them.
#[test]
fn the_page_and_readme_say_what_is_found() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |name: &str| std::fs::read_to_string(root.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let (page, table, readme) =
        (read("reports/openscad/index.html"), read("reports/openscad/table.md"), read("README.md"));
    let kept: Vec<&str> = table.lines().skip(2).collect();
    assert_eq!(kept.len(), cases().len());
    for (case, line) in cases().iter().zip(kept) {
        let name = &case.entry.name;
        assert!(readme.lines().any(|l| l == line), "README lacks: {line}");
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        assert!(cells[0].trim_matches('`') == name && cells[9] == "yes", "{line}");
        let row = format!("<td>{}</td></tr>", cells[1..].join("</td><td>"));
        assert!(page.contains(&row), "the page lacks: {row}");
        let found = match case.made(FINE_MM) {
            Ok(made) => [made.bracket[0], made.bracket[1], made.volume].map(|v| v.as_mm3()),
            Err(_) => [0.0, most_left(case), 0.0],
        };
        let truth = case.r.as_ref().map_or(0.0, TriangleMesh::signed_volume);
        let said = |at: usize| cells[at].split('…').map(|x| x.trim().parse().unwrap()).collect::<Vec<f64>>();
        let said: Vec<f64> = [6, 7, 8].into_iter().flat_map(said).collect();
        // As they are rounded: a bracket to 0.1, volumes to 0.01 mm³.
        for ((said, found), step) in said.iter().zip(found.into_iter().chain([truth])).zip([0.1, 0.1, 0.01, 0.01]) {
            assert!((said - found).abs() < 0.51 * step, "{name}: {found} is said to be {said}");
        }
    }
}

fn row(case: &Case, folder: &Path) -> Row {
    let name = case.entry.name.clone();
    let nothing = TriangleMesh::default();
    let truth = case.r.as_ref().unwrap_or(&nothing);
    let volume = truth.signed_volume();
    let shown = case.made(SHOWN_MM);
    let mesh = shown.as_ref().map_or(&nothing, |made| &made.mesh);
    let (differing, difference) = difference(truth, shown.as_ref().ok());
    let before = processor_seconds()[0];
    let fine = case.made(FINE_MM);
    let spent = processor_seconds()[0] - before;
    // The default of the commands is the longest side over 128. The mean of twenty, since a tick is a hundredth of a second.
    let (lo, hi) = case.a.bounds().unwrap();
    let longest = (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max);
    let coarser = [128.0, 64.0].map(|samples| {
        let before = processor_seconds()[0];
        (0..20).for_each(|_| drop(case.made(longest / samples)));
        (processor_seconds()[0] - before) / 20.0
    });
    let (found, path) = match &fine {
        Ok(made) => ([made.volume, made.bracket[0], made.bracket[1]].map(|v| v.as_mm3()), made.path.clone()),
        // The one refusal that is a result: nothing remains, or the element fits nowhere, and OpenSCAD says the same.
        Err(e) => {
            assert!(case.r.is_none() && e.code() == "E013", "{name}: {e}");
            ([0.0, 0.0, most_left(case)], "nothing remains".into())
        }
    };
    let captions = [format!("{volume:.3} mm³"), format!("{:.3} mm³ at {SHOWN_MM} mm", mesh.signed_volume())];
    let third = format!("{differing:.3} mm³ of samples differ");
    let panels = [
        Panel { mesh: truth, title: "OpenSCAD", caption: &captions[0] },
        Panel { mesh, title: "amcheck", caption: &captions[1] },
        Panel { mesh: &difference, title: "difference", caption: &third },
    ];
    std::fs::write(folder.join(format!("{name}.png")), side_by_side(&panels, PANEL)).unwrap();
    let facets = [truth.triangles.len(), mesh.triangles.len()];
    let operation = format!("{:?}", case.fixture.operation).to_lowercase();
    eprintln!("{name}: {spent:.2} s");
    Row {
        name,
        operation,
        seconds: [case.entry.seconds, spent, coarser[0], coarser[1]],
        volume,
        found,
        facets,
        differing,
        path,
    }
}

/// Samples that are inside one result and not the other: their volume, and the surface around them. A surface keeps a thousandth of
/// a spacing from samples, so that those on OpenSCAD's faces tell of nothing.
fn difference(truth: &TriangleMesh, made: Option<&Operated>) -> (f64, TriangleMesh) {
    let Some(made) = made else { return (truth.signed_volume(), truth.clone()) };
    let grid = *made.field().unwrap().grid();
    let inside = |mesh: &TriangleMesh| {
        if mesh.triangles.is_empty() { Indicator::empty(grid) } else { occupancy(mesh, &grid).unwrap() }
    };
    let (a, b) = (inside(truth), inside(&made.mesh));
    let mut differing = a.difference(&b).unwrap().union(&b.difference(&a).unwrap()).unwrap();
    let exact = MeshDistance::new(truth);
    for at in differing.clone().iter() {
        let index = grid.index(at);
        if exact.nearest(grid.position(index), 2e-3 * grid.h()).is_some() {
            differing.set(index, false);
        }
    }
    (differing.volume().as_mm3(), surface(&differing, |_| 0.5).unwrap())
}

/// The upper bound of an empty result.
fn most_left(case: &Case) -> f64 {
    case.enclosed(FINE_MM, 0).volume[1].as_mm3()
}

/// The rows as Markdown.
fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| fixture | operation | OpenSCAD, s | amcheck, s | at L/128, s | at L/64, s | certified, mm³ | amcheck, mm³ | OpenSCAD, mm³ | inside |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for r in rows {
        let _ = writeln!(text, "| {} |", cells(r, &format!("`{}`", r.name)).join(" | "));
    }
    text
}

/// A row of the table, for a name as it is to be shown.
fn cells(r: &Row, name: &str) -> [String; 10] {
    let [estimate, low, high] = r.found;
    let seconds = [2, 2, 3, 3].iter().zip(r.seconds).map(|(&digits, s)| format!("{s:.digits$}")).collect::<Vec<_>>();
    let bracket = format!("{low:.1} … {high:.1}");
    [
        name.into(),
        r.operation.clone(),
        seconds[0].clone(),
        seconds[1].clone(),
        seconds[2].clone(),
        seconds[3].clone(),
        bracket,
        format!("{estimate:.2}"),
        format!("{:.2}", r.volume),
        inside(r).into(),
    ]
}

fn inside(r: &Row) -> &'static str {
    let slack = 1e-4 * r.volume.abs().max(1.0);
    if r.found[1] - slack <= r.volume && r.volume <= r.found[2] + slack { "yes" } else { "NO" }
}

fn html(rows: &[Row]) -> String {
    let mut text = String::from(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>amcheck against OpenSCAD</title>\n<style>body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;\
         max-width:68rem;padding:0 1rem;color:#18212b;background:#fff}figure{margin:0 0 2.5rem}img{width:100%;height:auto;\
         border:1px solid #cdd4da}h2{margin:0 0 .25rem}dl{display:grid;grid-template-columns:max-content 1fr;gap:0 1rem;\
         margin:.5rem 0}dt{color:#586370}dd{margin:0}a{color:#0b5394}div{overflow-x:auto}table{border-collapse:collapse;margin:1rem 0 2.5rem;font-size:.875rem}\
         td,th{padding:.15rem .6rem .15rem 0;text-align:left;white-space:nowrap;border-bottom:1px solid #e3e8ec;\
         font-variant-numeric:tabular-nums}</style>\n<h1>amcheck against OpenSCAD</h1>\n",
    );
    let _ = writeln!(
        text,
        "<p>Each fixture is rendered by OpenSCAD's <code>minkowski()</code> from <code>fixtures/openscad/*.scad</code> and \
         made by amcheck from the rendered operands A and B. Left OpenSCAD's result, in the middle amcheck's surface, right \
         the samples that lie in one and not in the other, but for those on OpenSCAD's surface; all at {SHOWN_MM} mm. The numbers are those at {FINE_MM} mm, \
         in user seconds of all threads, OpenSCAD's as kept with the references; certified is the bracket that the exact volume lies in; L is the longest side, L/128 the default spacing of the commands, L/64 twice that. Made by <code>cargo test --release --test openscad page -- --ignored</code>.</p>"
    );
    let heads = [
        "fixture",
        "operation",
        "OpenSCAD, s",
        "amcheck, s",
        "at L/128, s",
        "at L/64, s",
        "certified, mm³",
        "amcheck, mm³",
        "OpenSCAD, mm³",
        "inside",
    ];
    let _ = writeln!(text, "<div><table><tr><th>{}</th></tr>", heads.join("</th><th>"));
    for r in rows {
        let name = format!("<a href=\"#{name}\">{name}</a>", name = r.name);
        let _ = writeln!(text, "<tr><td>{}</td></tr>", cells(r, &name).join("</td><td>"));
    }
    text += "</table></div>\n";
    for r in rows {
        let [estimate, low, high] = r.found;
        let share = if r.volume > 0.0 { 100.0 * r.differing / r.volume } else { 0.0 };
        let _ = write!(
            text,
            "<figure id=\"{name}\"><h2>{name}</h2>\n<img src=\"{name}.png\" width=\"900\" height=\"296\" \
             alt=\"OpenSCAD's result, amcheck's result and their difference\">\n<dl><dt>operation</dt><dd>{}</dd>\
             <dt>OpenSCAD</dt><dd>{:.3} mm³, {} facets, {:.2} s</dd><dt>amcheck</dt><dd>{estimate:.3} mm³, certified {low:.3} \
             … {high:.3} mm³, {:.2} s, {}</dd><dt>inside the bracket</dt><dd>{}</dd><dt>difference</dt><dd>{:.3} mm³ of \
             samples at {SHOWN_MM} mm ({share:.2} % of the volume); {} facets are shown</dd></dl></figure>\n",
            r.operation,
            r.volume,
            r.facets[0],
            r.seconds[0],
            r.seconds[1],
            r.path,
            inside(r),
            r.differing,
            r.facets[1],
            name = r.name,
        );
    }
    text + "</html>\n"
}
