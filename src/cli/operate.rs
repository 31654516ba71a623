//! `amcheck offset|open|close|minkowski|difference|obstacle|sweep`: from words to a written shape.

use super::args::{How, Operation, Pair};
use super::complaint::{Answer, Complaint};
use super::made::{Before, Outputs};
use super::operand::Operand;
use super::toolpath as printed;
use super::words::{allowance, length, units};
use crate::error::{Error, Place, Result, printable};
use crate::geometry::Primitive;
use crate::geometry::vector::{Vec3, bounds};
use crate::grid::Fitting;
use crate::io::toolpath;
use crate::memory::Allowance;
use crate::notice::Notice;
use crate::operate::{self, Element, Operated};
use crate::units::{Length, short};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Bytes for each sample of the result of an operation with a ball: sets, distances, the surface.
pub(super) const BYTES_BY_DISTANCES: u128 = 24;

/// Bytes for each sample of an opening or closing by a ball: distances to the part and to what the ball reaches.
const BYTES_BY_ROLLING: u128 = 32;

/// Bytes for each sample of the result of any other: sets, distances, and transforms of doubles, padded.
const BYTES_BY_SETS: u128 = 72;

/// Share of the longest side that the default spacing is.
const DEFAULT_SAMPLES: f64 = 128.0;

/// Makes the shape, writes it, and returns what goes to stdout.
pub fn operate(operation: &Operation) -> Answer<String> {
    match operation {
        Operation::Offset { part, by, how } => {
            let by = Length::parse(by)?;
            let room = [2.0 * by.as_mm().max(0.0); 3];
            Job::new("offset", part, how)?
                .run(room, BYTES_BY_DISTANCES, |part, h| operate::offset(&part.mesh(h), by, h))
        }
        Operation::Open { part, radius, how } => {
            let (ball, _) = ball(radius)?;
            Job::new("open", part, how)?
                .run([0.0; 3], BYTES_BY_ROLLING, |part, h| operate::open(&part.mesh(h), &ball, h))
        }
        Operation::Close { part, radius, how } => {
            let (ball, radius) = ball(radius)?;
            let room = [2.0 * radius.as_mm(); 3];
            Job::new("close", part, how)?.run(room, BYTES_BY_ROLLING, |part, h| operate::close(&part.mesh(h), &ball, h))
        }
        Operation::Minkowski { pair, how } => {
            let (job, element) = two("minkowski", pair, how)?;
            job.run(element.extent(), bytes_with(&element), |part, h| {
                operate::minkowski(&part.mesh(h), &element.element, h)
            })
        }
        Operation::Difference { pair, how } => {
            let (job, element) = two("difference", pair, how)?;
            job.run([0.0; 3], bytes_with(&element), |part, h| operate::difference(&part.mesh(h), &element.element, h))
        }
        Operation::Obstacle { pair, how } => {
            let (job, element) = two("obstacle", pair, how)?;
            job.run(element.extent(), bytes_with(&element), |part, h| {
                operate::obstacle(&part.mesh(h), &element.element, h)
            })
        }
        Operation::Sweep { part, gcode: Some(code), bead, design, how, .. } => {
            printed::print(code, part.as_deref(), bead.as_deref(), design.as_deref(), how)
        }
        Operation::Sweep { part: Some(part), along: Some(along), how, .. } => {
            let path = stroke(along, &allowance(&how.memory)?).map_err(|e| Complaint::about(Some(along), e))?;
            let (lo, hi) = bounds(path.iter().copied()).unwrap_or_default();
            let room = [0, 1, 2].map(|a| hi[a] - lo[a]);
            let mut job = Job::new("sweep", part, how)?;
            job.spacing = job.spacing.or_else(|| Some(default_spacing(plus(job.part.extent(), room))));
            job.run(room, BYTES_BY_SETS, |part, h| operate::sweep(&part.element, &path, h))
        }
        Operation::Sweep { .. } => Err(Error::Usage {
            problem: "a sweep needs a part and a path".into(),
            remedy: "write `amcheck sweep PART --along PATH` or `amcheck sweep --gcode PATH`".into(),
        }
        .into()),
    }
}

/// An operation on a part: what it reads, how finely, where the result goes.
struct Job {
    part: Operand,
    spacing: Option<Length>,
    memory: Allowance,
    unit_mm: Option<f64>,
    to: Outputs,
}

impl Job {
    /// Understands the options, finds a place for the result and reads the part.
    fn new(operation: &str, part: &Path, how: &How) -> Answer<Self> {
        let unit_mm = how.units.as_deref().map(units).transpose()?.map(|(_, mm)| mm);
        let spacing = how.voxel.as_deref().map(|text| length("--voxel", text)).transpose()?;
        let memory = allowance(&how.memory)?;
        let to = Outputs::open(how)?;
        let part = Operand::read(part, unit_mm, &memory)?;
        let to = to.or_at(format!("{}_{operation}.stl", part.stem))?;
        Ok(Job { part, spacing, memory, unit_mm, to })
    }

    /// Makes and writes the shape; `room` is how much larger than the part it may be,
    /// `bytes_per_sample` what that takes.
    fn run(
        self,
        room: Vec3,
        bytes_per_sample: u128,
        make: impl Fn(&Operand, Length) -> Result<Operated>,
    ) -> Answer<String> {
        let extent = self.part.extent();
        let spacing = self.spacing.unwrap_or_else(|| default_spacing(extent));
        Fitting::within(plus(extent, room), spacing, bytes_per_sample, self.memory.least())?;
        let made = make(&self.part, spacing)?;
        let before =
            self.to.has_picture().then(|| Before { mesh: self.part.mesh(spacing), title: printable(&self.part.stem) });
        let written = self.to.write(&made, before.as_ref())?;
        Ok(summary(&made, spacing, &self.part.notices, "", &written))
    }
}

/// A job on a part, and its element.
fn two(operation: &str, pair: &Pair, how: &How) -> Answer<(Job, Operand)> {
    let mut job = Job::new(operation, &pair.part, how)?;
    let element = Operand::read(&pair.element, job.unit_mm, &job.memory)?;
    job.part.notices.extend(element.notices.iter().cloned());
    Ok((job, element))
}

fn bytes_with(element: &Operand) -> u128 {
    match element.element {
        Element::BuiltIn(Primitive::Ball { .. }) => BYTES_BY_DISTANCES,
        _ => BYTES_BY_SETS,
    }
}

/// A ball of a positive radius.
fn ball(radius: &str) -> Result<(Element, Length)> {
    let radius = Length::parse(radius)?;
    let shape = Primitive::Ball { radius };
    shape.validate()?;
    Ok((Element::BuiltIn(shape), radius))
}

/// The one stroke of a path.
fn stroke(file: &Path, memory: &Allowance) -> Result<Vec<Vec3>> {
    let mut strokes = toolpath::read_points(&memory.content(file)?)?.strokes;
    match (strokes.pop(), strokes.len()) {
        (Some(stroke), 0) => Ok(stroke),
        (_, others) => Err(Error::Unsupported {
            what: format!("a path of {} strokes", others + 1),
            place: Place::Whole,
            remedy: "sweep along one stroke at a time: an empty line ends a stroke".into(),
        }),
    }
}

fn default_spacing(extent: Vec3) -> Length {
    Length::mm(extent.into_iter().fold(0.0, f64::max) / DEFAULT_SAMPLES)
}

fn plus(a: Vec3, b: Vec3) -> Vec3 {
    [0, 1, 2].map(|i| a[i] + b[i])
}

/// What was made, in a few lines; `told` are more.
pub(super) fn summary(made: &Operated, spacing: Length, notices: &[Notice], told: &str, written: &[PathBuf]) -> String {
    let [low, high] = made.bracket.map(|v| short(v.as_mm3()));
    let (lo, hi) = made.mesh.bounds().unwrap_or_default();
    let point = |p: Vec3| p.map(short).join(", ");
    let mut text = String::new();
    let _ = writeln!(text, "volume     {}, certified {low} … {high} mm³", made.volume);
    let _ = writeln!(text, "box        {} … {} mm", point(lo), point(hi));
    let _ = writeln!(text, "path       {} at {spacing}", made.path);
    let _ = writeln!(text, "triangles  {}", made.mesh.triangles.len());
    text += told;
    for notice in notices {
        let _ = writeln!(text, "note       {}", printable(&notice.message));
    }
    for path in written {
        let _ = writeln!(text, "written    {}", printable(&path.to_string_lossy()));
    }
    text
}
