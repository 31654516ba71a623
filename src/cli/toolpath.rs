//! `amcheck sweep --gcode`: the shape that a toolpath deposits.

use super::args::How;
use super::complaint::{Answer, Complaint};
use super::made::{Before, Outputs};
use super::operand::{Operand, one_from_stdin};
use super::operate::{BYTES_BY_DISTANCES, affordable, thinnest};
use super::told::summary;
use super::words::{allowance, length, units};
use crate::error::{Error, Place, Result, printable};
use crate::geometry::Primitive;
use crate::geometry::vector::{Vec3, bounds};
use crate::grid::Fitting;
use crate::io::gcode;
use crate::io::toolpath::Toolpath;
use crate::memory::Allowance;
use crate::notice::Notice;
use crate::operate::{Departure, Element, deposit};
use crate::process::Process;
use crate::units::{Length, Volume, enclosed, short};
use std::fmt::Write;
use std::path::Path;

/// Strokes whose heights differ by less lie in one layer, millimetres.
const SAME_LAYER: f64 = 1e-3;
/// Layers whose distance differs from the bead's height by a larger share are not of that bead.
const OTHERWISE: f64 = 0.05;

/// What a bead is, and by how much the path is lowered to run through its middle.
struct Hung {
    shape: Primitive,
    below: f64,
}

/// Deposits the bead along the extrusion moves, writes the shape, and returns what goes to stdout.
pub fn print(code: &Path, part: Option<&Path>, bead: Option<&str>, design: Option<&Path>, how: &How) -> Answer<String> {
    let unit_mm = how.units.as_deref().map(units).transpose()?.map(|(_, mm)| mm);
    let spacing = how.voxel.as_deref().map(|text| length("--voxel", text)).transpose()?;
    let memory = allowance(&how.memory)?;
    let read: Vec<&Path> = [Some(code), part, design].into_iter().flatten().collect();
    one_from_stdin(&read)?;
    let to = Outputs::open(how)?;
    let bead = match part {
        Some(part) => Hung { shape: own_bead(&Operand::read(part, unit_mm, &memory)?)?, below: 0.0 },
        None => nozzle_bead(bead)?,
    };
    let path = strokes(code, bead.below, &memory).map_err(|e| Complaint::about(Some(code), e))?;
    let design = design.map(|file| Operand::read(file, unit_mm, &memory)).transpose()?;
    let stem = code.file_stem().map_or_else(|| "path".into(), |s| s.to_string_lossy().into_owned());
    let to = to.or_at(format!("{stem}_sweep.stl"))?.sparing(&read)?;
    let half = bead.shape.half_extent();
    let (lo, hi) = bounds(path.strokes.iter().flatten().copied()).unwrap_or_default();
    let extent = [0, 1, 2].map(|a| hi[a] - lo[a] + 2.0 * half[a]);
    let spacing = spacing.map_or_else(|| default_spacing(half, extent), Ok)?;
    Fitting::within(extent, spacing, BYTES_BY_DISTANCES, memory.least())?;
    let made = deposit(&path, &bead.shape, spacing)?;
    let design = design.map(|d| d.mesh(spacing));
    let departure = design.as_ref().map(|mesh| made.departure(mesh)).transpose()?;
    let apart = design.as_ref().and_then(|mesh| elsewhere(mesh.bounds()?, (lo, hi), half));
    let before: Vec<Before> = design.into_iter().map(|mesh| Before { mesh, title: "design".into() }).collect();
    let written = to.write(&made.shape, &before)?;
    let told = told(&path, &bead, departure.as_ref());
    let notices: Vec<Notice> = path.notices.iter().cloned().chain(layers(&path, &bead)).chain(apart).collect();
    Ok(summary(&made.shape, spacing, &notices, &told, &written))
}

/// Says that the layers of a path are not as far apart as the bead of a nozzle is high, where most of them are so.
fn layers(path: &Toolpath, bead: &Hung) -> Option<Notice> {
    if bead.below == 0.0 {
        return None;
    }
    let level = |stroke: &Vec<Vec3>| stroke.first().map(|p| p[2]).filter(|z| stroke.iter().all(|p| p[2] == *z));
    let mut heights: Vec<f64> = path.strokes.iter().filter_map(level).collect();
    heights.sort_by(f64::total_cmp);
    heights.dedup_by(|a, b| (*a - *b).abs() < SAME_LAYER);
    let mut steps: Vec<f64> = heights.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_by(f64::total_cmp);
    let (step, high) = (*steps.get(steps.len() / 2)?, 2.0 * bead.shape.half_extent()[2]);
    ((step - high).abs() > OTHERWISE * high).then(|| {
        let text = format!(
            "layers lie {} mm apart, and the bead is {} mm high: give the file's own with --bead WIDTHxHEIGHTmm",
            short((1e3 * step).round() / 1e3),
            short(high)
        );
        Notice::new("bead-height", text)
    })
}

/// Says that a design and a deposit have nothing in common, not even their boxes.
fn elsewhere(design: (Vec3, Vec3), path: (Vec3, Vec3), half: Vec3) -> Option<Notice> {
    let apart = |a: usize| path.0[a] - half[a] > design.1[a] || path.1[a] + half[a] < design.0[a];
    (0..3).any(apart).then(|| {
        let box_of = |(lo, hi): (Vec3, Vec3)| format!("{} … {} mm", lo.map(short).join(", "), hi.map(short).join(", "));
        let text = format!(
            "the design lies at {} and the path at {}: they do not meet, and both have to be in the same frame",
            box_of(design),
            box_of(path)
        );
        Notice::new("design-elsewhere", text)
    })
}

/// The strokes of a file, lowered.
fn strokes(code: &Path, below: f64, memory: &Allowance) -> Result<Toolpath> {
    let mut path = gcode::read(&memory.content(code)?)?;
    path.strokes.iter_mut().flatten().for_each(|p| p[2] -= below);
    Ok(path)
}

/// The built-in element that was named as the bead; it stands about the path.
fn own_bead(part: &Operand) -> Result<Primitive> {
    match part.element {
        Element::BuiltIn(shape) => Ok(shape),
        Element::Mesh(_) => Err(Error::Unsupported {
            what: "a mesh as a bead".into(),
            place: Place::Whole,
            remedy: "take a ball, a box or a cylinder".into(),
        }),
    }
}

/// The bead of a nozzle: a disk as wide and high as said, hanging below the path.
fn nozzle_bead(words: Option<&str>) -> Result<Hung> {
    let (width, height) = match words {
        Some(words) => width_and_height(words)?,
        None => {
            let process = Process::named("fdm")?;
            (Length::mm(process.element.width_mm), Length::mm(process.layer_height_mm))
        }
    };
    let shape = Primitive::Cylinder { radius: width * 0.5, height };
    shape.validate()?;
    Ok(Hung { shape, below: 0.5 * height.as_mm() })
}

fn width_and_height(words: &str) -> Result<(Length, Length)> {
    let bad = || Error::Usage {
        problem: format!("`{}` is no bead", printable(words)),
        remedy: "write width and height, such as --bead 0.45x0.2mm".into(),
    };
    let (width, height) = words.split_once('x').ok_or_else(bad)?;
    let unit = height.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let length = |text: &str| Length::parse(text).map_err(|_| bad());
    Ok((length(&format!("{width}{unit}"))?, length(height)?))
}

/// A quarter of the bead's thinnest side, coarser where the whole path would take too much.
fn default_spacing(half: Vec3, extent: Vec3) -> Result<Length> {
    affordable(extent, thinnest(half.map(|x| 2.0 * x)), BYTES_BY_DISTANCES)
}

/// What was deposited and how it departs from the design.
fn told(path: &Toolpath, bead: &Hung, departure: Option<&Departure>) -> String {
    let mut text = String::new();
    let size = bead.shape.half_extent().map(|x| short(2.0 * x)).join(" × ");
    let (strokes, length) = (path.strokes.len(), Length::mm(path.length_mm()));
    let plural = if strokes == 1 { "" } else { "s" };
    let _ = writeln!(text, "bead       {size} mm along {length} in {strokes} stroke{plural}");
    let line = |volumes: [Volume; 3]| {
        let [estimate, low, high] = volumes.map(|v| v.as_mm3());
        let [estimate, low, high] = enclosed(estimate, [low, high]);
        format!("{estimate} mm³, certified {low} … {high} mm³")
    };
    if let Some(departure) = departure {
        let _ = writeln!(text, "missing    {}", line(departure.missing));
        let _ = writeln!(text, "over       {}", line(departure.over));
    }
    text
}
