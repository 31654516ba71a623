//! `amcheck orient`: the ways to stand a part up, compared.

use super::args::Orienting;
use super::asked::process;
use super::complaint::{Answer, Complaint};
use super::deliver::{Delivery, Files};
use super::judge::on_threads;
use super::leftover;
use super::record::{Record, Said};
use super::words::{allowance, one_of, units, usage};
use crate::access::{Orientation, Question, orientations, standing};
use crate::error::{Error, Result};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;
use crate::io::stl;
use crate::notice::Notice;
use crate::part::{Part, Up};
use crate::report::orient::{self, ORIENT_SCHEMA, OrientReport};
use crate::report::render::Picture;
use crate::report::stances::thumbnail;
use crate::report::{Tool, html, terminal};
use crate::units::hundredths;
use rayon::prelude::*;

/// Formats that the orientations can be written in.
const FORMATS: &[&str] = &["json", "html", "png", "stl"];
/// The orientations that get a thumbnail.
const PICTURED: usize = 12;
/// Most directions and orientations in full that may be asked for.
const MOST: [usize; 2] = [100_000, 1000];

/// The part as it stands in an orientation, twice as far from the origin along x as it was in its file, or more.
///
/// Turned, its coordinates are off by up to √3 of their resolution there, and a reader takes that of the new file for it: nearer to the origin, surface at the
/// limit would no longer equal it.
fn written(part: &Part, rotation: &[Vec3; 3]) -> TriangleMesh {
    let posed = standing(part.mesh(), rotation);
    let far = 2.0 * part.step() / stl::RELATIVE_STEP;
    let right = posed.bounds().map_or(0.0, |(_, hi)| far - hi[0]).max(0.0);
    posed.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [right, 0.0, 0.0])
}

/// The best pose as a file, and where it stands in that.
fn best_pose(part: &Part, best: &Orientation) -> Result<(Vec<u8>, String)> {
    let mesh = written(part, &best.rotation);
    let mut bytes = Vec::new();
    let refused = |e: std::io::Error| Error::CannotWrite { path: "best.stl".into(), reason: e.to_string() };
    stl::write(&mesh, &mut bytes).map_err(refused)?;
    let [from, to] = mesh.bounds().map_or([0.0; 2], |(lo, hi)| [lo[0], hi[0]]).map(hundredths);
    Ok((bytes, format!("best.stl stands on z = 0 at x = {from} to {to} mm, as far out as the digits of STL need")))
}

/// Compares the orientations, writes the answer and returns what goes to stdout.
pub fn orient(a: &Orienting) -> Answer<String> {
    run(a).map_err(|e| Complaint::about(Some(&a.part), e))
}

fn run(a: &Orienting) -> Result<String> {
    let formats = one_of("format", &a.format, FORMATS)?;
    if !(1..=MOST[0]).contains(&a.directions) || !(1..=MOST[1]).contains(&a.best) {
        return Err(usage(
            "--directions or --best is out of range",
            "give 1 to 100000 directions, the best 1 to 1000 in full",
        ));
    }
    let process = process(&a.process)?;
    let scale = a.units.as_deref().map(units).transpose()?.map(|(_, mm)| mm);
    let stem = a.part.file_stem().map_or_else(|| "part".into(), |s| s.to_string_lossy().into_owned());
    let stem = if stem == "-" { "stdin".into() } else { stem };
    let folder = a.out.clone().unwrap_or_else(|| std::path::Path::new("reports").join(&stem));
    let delivery = Delivery::open(&folder)?.saying(Said::Orientations, &a.part);
    // A folder that was named is meant.
    let mut notes = match a.out {
        None => Record::of(&folder).notes(&folder, &a.part, Said::Orientations),
        Some(_) => Vec::new(),
    };
    let memory = allowance(&a.memory)?;
    let loaded = memory.mesh(&a.part)?;
    let threads = memory.admit_orienting(loaded.mesh.triangles.len() as u64)?;
    let overruled = loaded.overruled_by(scale);
    let mut warnings = loaded.notices;
    warnings.extend(overruled);
    let known = scale.or(loaded.unit_mm);
    if known.is_none() {
        warnings.push(Notice::units_assumed(loaded.format));
    }
    let scale = known.unwrap_or(1.0);
    let file = loaded.mesh.scaled(scale);
    let largest = file.vertices.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    let part = Part::new(file, Up::PlusZ, largest * loaded.relative_step, 0.0)?;
    warnings.extend(if scale == 1.0 { part.health_as_read().units_guess() } else { None });
    warnings.extend(part.notices());
    let question = Question { directions: a.directions, best: a.best, ..Question::of(&process, part.step()) };
    let found = on_threads(threads, || orientations(part.mesh(), &part, &question))??;
    let name = a.part.file_name().map_or_else(|| stem.clone(), |n| n.to_string_lossy().into_owned());
    let report = OrientReport {
        schema: ORIENT_SCHEMA.into(),
        tool: Tool { name: "amcheck".into(), version: env!("CARGO_PKG_VERSION").into() },
        file: name,
        process: process.name.clone(),
        volume_mm3: crate::units::report_digits(part.mesh().signed_volume()),
        watertight: part.health_as_read().is_watertight(),
        warnings,
        orientations: found,
    };
    let mut files = Files::default();
    let list = &report.orientations.list;
    let pictures: Vec<Picture> = if formats.iter().any(|f| ["html", "png"].contains(f)) {
        let picture = |(n, o): (usize, &Orientation)| thumbnail(&part, o, n + 1);
        list.par_iter().take(PICTURED).enumerate().map(picture).collect()
    } else {
        Vec::new()
    };
    if formats.contains(&"html") {
        files.push("orientations", "orientations.html", html::orientations(&report, &pictures).into_bytes());
    }
    if formats.contains(&"json") {
        files.push("data", "orientations.json", orient::json(&report).into_bytes());
    }
    if let Some(best) = list.first().filter(|_| formats.contains(&"stl")) {
        let (bytes, place) = best_pose(&part, best)?;
        notes.push(place);
        files.push("best pose", "best.stl", bytes);
    }
    if formats.contains(&"png") {
        for p in pictures {
            files.push("picture", &format!("orientation-{}.png", p.name), p.png);
        }
    }
    let names = files.names();
    let written = delivery.deliver(files, &[&a.part])?;
    leftover::remove(&folder, &names, leftover::of_orienting, &[&a.part])?;
    if a.json {
        return Ok(orient::json(&report));
    }
    let of_text = |w: &(String, String, u64)| w.0 != "picture" || formats == ["png"];
    let places: Vec<String> = written.into_iter().filter(of_text).map(|w| w.1).collect();
    let notes: String = notes.iter().map(|text| terminal::note(text) + "\n").collect();
    Ok(format!("{}{notes}written: {}\n", orient::text(&report), places.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::extruded;
    use crate::layer::downward_facets;
    use crate::units::Angle;

    /// A mesh as an STL file has it.
    fn stored(mesh: &TriangleMesh) -> TriangleMesh {
        let vertices = mesh.vertices.iter().map(|v| v.map(|x| f64::from(x as f32))).collect();
        TriangleMesh { vertices, ..mesh.clone() }
    }

    #[test]
    fn surface_at_the_limit_equals_it_in_the_file_of_the_best_pose_too() {
        // A side that leans by 45 degrees in forty strips, a metre from the origin, where a coordinate is off by up to 0.00006 mm.
        let side = (1..40).map(|n| [-4.0 + 0.1 * f64::from(n), 4.0 - 0.1 * f64::from(n)]);
        let outline: Vec<[f64; 2]> =
            [[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [-4.0, 4.0]].into_iter().chain(side).collect();
        let caps: Vec<[usize; 3]> = (2..=outline.len() - 1).map(|i| [1, i, (i + 1) % outline.len()]).collect();
        let made = extruded(&outline, &caps, 3.0);
        let up = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mesh = stored(&made.transformed(up, [1000.123, 0.777, 0.0]));
        let hanging = |mesh: &TriangleMesh| {
            let most = mesh.bounds().map_or(0.0, |(lo, hi)| lo.into_iter().chain(hi).map(f64::abs).fold(0.0, f64::max));
            downward_facets(mesh, 0.05, Angle::degrees(45.0), most * stl::RELATIVE_STEP).len()
        };
        assert_eq!(hanging(&mesh), 0);
        assert!(hanging(&stored(&standing(&mesh, &up))) > 10);
        let part = Part::new(mesh, Up::PlusZ, 1005.2 * stl::RELATIVE_STEP, 0.0).unwrap();
        let turned = [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
        for rotation in [up, turned] {
            assert_eq!(hanging(&stored(&written(&part, &rotation))), 0);
        }
    }
}
