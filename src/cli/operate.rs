//! `amcheck offset|open|close|minkowski|difference|obstacle|sweep`: from words to a written shape.

use super::args::{How, Moved, Operation, Pair};
use super::complaint::{Answer, Complaint};
use super::made::{Before, Outputs};
use super::need::{Growth, Surface};
use super::operand::{Operand, one_from_stdin};
use super::told::summary;
use super::toolpath as printed;
use super::words::{allowance, length, units};
use crate::error::{Error, Result, printable};
use crate::geometry::vector::{Vec3, bounds, norm, sub};
use crate::geometry::{Primitive, TriangleMesh};
use crate::grid::{BYTES_PER_SAMPLE, Fitting};
use crate::io::motion::{Motion, read_motion};
use crate::memory::Allowance;
use crate::notice::{Notice, number_of};
use crate::operate::{self, Element, Operated, Reach};
use crate::units::{Length, short};
use std::path::Path;

/// What is closed reaches as far as it did, what is opened at most.
const CLOSING: Reach = Reach::Around([0.0; 3], [0.0; 3]);
const OPENING: Reach = Reach::Within([0.0; 3], [0.0; 3]);

/// Bytes for each sample of the result of an operation with a ball: sets, distances, the surface.
pub(super) const BYTES_BY_DISTANCES: u128 = 24;

/// Bytes for each sample of an opening or closing by a ball: distances to the part and to what the ball reaches.
const BYTES_BY_ROLLING: u128 = 32;

/// Bytes for each sample of the result of any other: sets, distances, and transforms of doubles, padded.
const BYTES_BY_SETS: u128 = 72;

/// By this share a built-in part is faceted finer for an opening by a ball: its chords lie no deeper than a ball may reach in, so that one as large as
/// the part fits.
const FINER: f64 = 0.4;

/// The longest side of a result, millimetres.
const LONGEST: f64 = 1e9;

/// Samples of the default spacing along the longest side.
const DEFAULT_SAMPLES: f64 = 128.0;

/// Samples across the thinnest direction of what is swept, where no spacing is given.
const ACROSS: f64 = 4.0;

/// Memory that a spacing for something thin keeps to, whatever the machine has.
const BUDGET: u128 = 1 << 30;

/// Makes the shape, writes it, and returns what goes to stdout.
pub fn operate(operation: &Operation) -> Answer<String> {
    match operation {
        Operation::Offset { part, by, how } => {
            let by = Length::parse(by)?;
            let room = [2.0 * by.as_mm().max(0.0); 3];
            let job = Job::new("offset", part, how)?;
            let out = by.as_mm();
            let reach = if out >= 0.0 { Reach::Around } else { Reach::Within };
            job.reaching(reach([-out; 3], [out; 3])).moving(by).growing(Growth::Rounded(out.max(0.0))).run(
                room,
                BYTES_BY_DISTANCES,
                None,
                |part, h| operate::offset(&part.mesh(h), by, h),
            )
        }
        Operation::Open { by, how } => {
            let (job, element) = moved("open", by, how)?;
            job.telling(crossings).reaching(OPENING).run([0.0; 3], bytes_about(&element), Some(&element), |part, h| {
                operate::open(&part.mesh(h * finer_for(part, &element)), &element.element, h)
            })
        }
        Operation::Close { by, how } => {
            let (job, element) = moved("close", by, how)?;
            job.telling(crossings).reaching(CLOSING).run(
                element.extent(),
                bytes_about(&element),
                Some(&element),
                |part, h| operate::close(&part.mesh(h), &element.element, h),
            )
        }
        Operation::Minkowski { pair, how } => {
            let (job, element) = two("minkowski", pair, how)?;
            let (lo, hi) = element.bounds().unwrap_or_default();
            job.reaching(Reach::Around(lo, hi)).moving_by(&element, 1.0).run(
                element.extent(),
                bytes_with(&element),
                Some(&element),
                |part, h| operate::minkowski(&part.mesh(h), &element.element, h),
            )
        }
        Operation::Difference { pair, how } => {
            let (job, element) = two("difference", pair, how)?;
            let (lo, hi) = element.bounds().unwrap_or_default();
            let reach = Reach::Within(lo.map(|x| -x), hi.map(|x| -x));
            job.reaching(reach).moving_by(&element, -1.0).run(
                [0.0; 3],
                bytes_with(&element),
                Some(&element),
                |part, h| operate::difference(&part.mesh(h), &element.element, h),
            )
        }
        Operation::Obstacle { pair, how } => {
            let (job, element) = two("obstacle", pair, how)?;
            let (lo, hi) = element.bounds().unwrap_or_default();
            job.reaching(Reach::Around(hi.map(|x| -x), lo.map(|x| -x))).moving_by(&element, 1.0).run(
                element.extent(),
                bytes_with(&element),
                Some(&element),
                |part, h| operate::obstacle(&part.mesh(h), &element.element, h),
            )
        }
        Operation::Sweep { part, gcode: Some(code), bead, design, how, .. } => {
            printed::print(code, part.as_deref(), bead.as_deref(), design.as_deref(), how)
        }
        Operation::Sweep { part: Some(part), along: Some(along), how, .. } => {
            one_from_stdin(&[part, along])?;
            let read = || allowance(&how.memory)?.content(along).and_then(|bytes| read_motion(&bytes));
            let motion = read().map_err(|e| Complaint::about(Some(along), e))?;
            let mut job = Job::new("sweep", part, how)?.sparing(&[part, along])?;
            let room = room_of(&motion, &job.part);
            job.spacing = Some(job.spacing.map_or_else(|| sweep_spacing(job.part.extent(), room), Ok)?);
            job.run(room, BYTES_BY_SETS, None, |part, h| match &motion {
                Motion::Points(path) => operate::sweep(&part.element, path, h),
                Motion::Poses(poses) => operate::sweep_motion(&part.element, poses, h),
            })
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
    /// What is told of the result beside the rest.
    tell: fn(&Operated) -> String,
    /// How far the exact result reaches about each body of the part, where that is known.
    reach: Option<Reach>,
    /// How far the surface moves outwards, where it moves evenly.
    by: Option<Length>,
    growth: Growth,
}

impl Job {
    /// Understands the options, finds a place for the result and reads the part.
    fn new(operation: &str, name: &Path, how: &How) -> Answer<Self> {
        let unit_mm = how.units.as_deref().map(units).transpose()?.map(|(_, mm)| mm);
        let spacing = how.voxel.as_deref().map(|text| length("--voxel", text)).transpose()?;
        let memory = allowance(&how.memory)?;
        let to = Outputs::open(how)?;
        let part = Operand::read(name, unit_mm, &memory)?;
        let to = to.or_at(format!("{}_{operation}.stl", part.stem))?.sparing(&[name])?;
        Ok(Job {
            part,
            spacing,
            memory,
            unit_mm,
            to,
            tell: |_| String::new(),
            reach: None,
            by: None,
            growth: Growth::Plain(0.0),
        })
    }

    /// The same job, with more to tell of its result.
    fn telling(self, tell: fn(&Operated) -> String) -> Self {
        Job { tell, ..self }
    }

    /// The same job, whose exact result reaches so far about each body of the part.
    fn reaching(self, reach: Reach) -> Self {
        Job { reach: Some(reach), ..self }
    }

    /// The same job, whose surface moves outwards by so much.
    fn moving(self, by: Length) -> Self {
        Job { by: Some(by), ..self }
    }

    /// The same job, whose surface moves by a ball's radius, to the side that `outwards` tells, if the element is a ball.
    fn moving_by(self, element: &Operand, outwards: f64) -> Self {
        match element.element {
            Element::BuiltIn(Primitive::Ball { radius }) => self.moving(radius * outwards),
            _ => self,
        }
    }

    /// The same job, whose surface grows so.
    fn growing(self, growth: Growth) -> Self {
        Job { growth, ..self }
    }

    /// The same job, if none of its results takes the place of an input.
    fn sparing(mut self, inputs: &[&Path]) -> Result<Self> {
        self.to = self.to.sparing(inputs)?;
        Ok(self)
    }

    /// Makes and writes the shape; `room` is how much larger than the part it may be,
    /// `bytes_per_sample` what that takes; a picture shows the element `beside` it.
    fn run(
        self,
        room: Vec3,
        bytes_per_sample: u128,
        beside: Option<&Operand>,
        make: impl Fn(&Operand, Length) -> Result<Operated>,
    ) -> Answer<String> {
        let extent = self.part.extent();
        let longer = [0, 1, 2].map(|a| extent[a].max(room[a]));
        if let Some(&side) = longer.iter().find(|side| side.is_nan() || **side > LONGEST) {
            return Err(Error::Usage {
                problem: format!("a result {side:e} mm long is out of range"),
                remedy: format!("choose lengths up to {LONGEST:e} mm, and check the units"),
            }
            .into());
        }
        let spacing = self.spacing.unwrap_or_else(|| default_spacing(longer));
        let surface = Surface::of(&self.part.mesh(spacing), self.growth);
        surface.admit(plus(extent, room), spacing, bytes_per_sample, self.memory.least())?;
        let made = make(&self.part, spacing)?;
        let before = if self.to.has_picture() { self.before(beside, spacing) } else { Vec::new() };
        let loses = self.to.loses(&made.mesh);
        let missing = self.missing(&made, spacing, make)?;
        let written = self.to.write(&made, &before)?;
        let notices: Vec<_> = self.part.notices.into_iter().map(Notice::as_read).chain(loses).chain(missing).collect();
        Ok(summary(&made, spacing, &notices, &(self.tell)(&made), &written))
    }

    /// What is to be said of what the spacing does not show.
    fn missing(
        &self,
        made: &Operated,
        spacing: Length,
        make: impl Fn(&Operand, Length) -> Result<Operated>,
    ) -> Result<Vec<Notice>> {
        let (part, pieces) = (self.part.mesh(spacing), made.pieces());
        let again = |body: &TriangleMesh, finer: Length| make(&Operand::of(body.clone()), finer);
        let short = self.reach.and_then(|reach| {
            let lost = made.lost_bodies(&part, reach, spacing, again);
            lost.or_else(|| made.falls_short(&part, reach, spacing))
        });
        let crumbs = pieces.left_out(&part, self.reach, spacing);
        let thin = self.by.map(|by| made.thinned_out(&part, by, spacing)).transpose()?.flatten();
        let grows = self.by.map_or(self.reach == Some(CLOSING), |by| by.as_mm() >= 0.0);
        let apart = (grows && crumbs.is_none()).then(|| pieces.comes_apart(&part)).flatten();
        let within = self.by.map_or(self.reach == Some(OPENING), |by| by.as_mm() <= 0.0);
        let fused = within.then(|| pieces.fused_bodies(&part)).flatten();
        let told = [crumbs, made.may_fill_too_much(), short, thin, apart, fused, made.misses(&part, spacing)];
        Ok(told.into_iter().flatten().collect())
    }

    /// What the picture shows beside the result: the part, and the element about the part's middle.
    fn before(&self, beside: Option<&Operand>, spacing: Length) -> Vec<Before> {
        let part = self.part.mesh(spacing);
        let middle = |mesh: &TriangleMesh| mesh.bounds().map(|(lo, hi)| [0, 1, 2].map(|a| 0.5 * (lo[a] + hi[a])));
        let at = middle(&part).unwrap_or_default();
        let element = beside.map(|o| {
            let mut mesh = o.mesh(spacing);
            let to = sub(at, middle(&mesh).unwrap_or_default());
            mesh.vertices.iter_mut().for_each(|p| *p = plus(*p, to));
            Before { mesh, title: printable(&o.stem) }
        });
        let part = Before { mesh: part, title: printable(&self.part.stem) };
        std::iter::once(part).chain(element).collect()
    }
}

/// A job on a part, and its element.
fn two(operation: &str, pair: &Pair, how: &How) -> Answer<(Job, Operand)> {
    pair_of(operation, &pair.part, &pair.element, how)
}

/// A job on a part, and the element or ball that is moved about.
fn moved(operation: &str, by: &Moved, how: &How) -> Answer<(Job, Operand)> {
    match (&by.element, &by.radius) {
        (Some(element), _) => pair_of(operation, &by.part, element, how),
        (None, Some(radius)) => {
            let ball = Operand::ball(Length::parse(radius)?)?;
            Ok((Job::new(operation, &by.part, how)?.growing(growth_by(&ball)), ball))
        }
        (None, None) => Err(Error::Usage {
            problem: format!("`{operation}` needs a ball or another element beside the part"),
            remedy: format!("write `amcheck {operation} PART --radius 1mm` or `amcheck {operation} PART box:2x1x1mm`"),
        }
        .into()),
    }
}

fn pair_of(operation: &str, part: &Path, element: &Path, how: &How) -> Answer<(Job, Operand)> {
    one_from_stdin(&[part, element])?;
    let mut job = Job::new(operation, part, how)?.sparing(&[element])?;
    let element = Operand::read(element, job.unit_mm, &job.memory)?;
    // An element may well be small.
    job.part.notices.extend(element.notices.iter().filter(|n| n.code != "units-guess").cloned());
    Ok((job.growing(growth_by(&element)), element))
}

/// How many facets of a result cross, if any do.
fn crossings(made: &Operated) -> String {
    let found = made.crossings();
    found.at_mm.map_or_else(String::new, |at| {
        let place = at.map(short).join(", ");
        format!(
            "note       {} near ({place}) mm, as happens where it is thinner than the spacing and by a hair along edges; choose a smaller \
             --voxel\n",
            number_of(found.count, ["pair of facets crosses,", "pairs of facets cross, one"])
        )
    })
}

/// How a surface grows with an element: by a ball's radius, or by what another reaches from its middle.
fn growth_by(element: &Operand) -> Growth {
    match element.element {
        Element::BuiltIn(Primitive::Ball { radius }) => Growth::Rounded(radius.as_mm()),
        _ => Growth::Plain(0.5 * norm(element.extent())),
    }
}

/// How much finer than usual a part is faceted that is opened by an element; the facets of a ball are inscribed along and across.
fn finer_for(part: &Operand, element: &Operand) -> f64 {
    use Element::BuiltIn;
    match (&part.element, &element.element) {
        (BuiltIn(Primitive::Ball { .. }), BuiltIn(Primitive::Ball { .. })) => 0.5 * FINER,
        (_, BuiltIn(Primitive::Ball { .. })) => FINER,
        _ => 1.0,
    }
}

fn bytes_with(element: &Operand) -> u128 {
    match element.element {
        Element::BuiltIn(Primitive::Ball { .. }) => BYTES_BY_DISTANCES,
        _ => BYTES_BY_SETS,
    }
}

fn bytes_about(element: &Operand) -> u128 {
    match element.element {
        Element::BuiltIn(Primitive::Ball { .. }) => BYTES_BY_ROLLING,
        _ => BYTES_BY_SETS,
    }
}

/// How much larger than a part its sweep may be: a part that turns stays in a ball about its origin.
fn room_of(motion: &Motion, part: &Operand) -> Vec3 {
    let sides = |places: &mut dyn Iterator<Item = Vec3>| {
        let (lo, hi) = bounds(places).unwrap_or_default();
        sub(hi, lo)
    };
    match motion {
        Motion::Points(path) => sides(&mut path.iter().copied()),
        Motion::Poses(poses) => {
            let (way, own) = (sides(&mut poses.iter().map(|pose| pose.at_mm)), part.extent());
            [0, 1, 2].map(|a| way[a] + (2.0 * part.reach() - own[a]).max(0.0))
        }
    }
}

fn default_spacing(extent: Vec3) -> Length {
    Length::mm(extent.into_iter().fold(0.0, f64::max) / DEFAULT_SAMPLES)
}

/// The default spacing for a body swept over `room`: fine enough to show it at its thinnest.
fn sweep_spacing(body: Vec3, room: Vec3) -> Result<Length> {
    let extent = plus(body, room);
    let usual = default_spacing(extent);
    let fine = affordable(extent, thinnest(body), BYTES_BY_SETS)?;
    Ok(if fine < usual { fine } else { usual })
}

/// The spacing with [`ACROSS`] samples over the least side of a box.
pub(super) fn thinnest(sides: Vec3) -> Length {
    Length::mm(sides.into_iter().fold(f64::INFINITY, f64::min) / ACROSS)
}

/// The spacing, or the finest one above it whose samples take no more than [`BUDGET`].
pub(super) fn affordable(extent: Vec3, spacing: Length, bytes_per_sample: u128) -> Result<Length> {
    Ok(Fitting::coarsened(extent, spacing, BUDGET / bytes_per_sample * BYTES_PER_SAMPLE)?.spacing)
}

fn plus(a: Vec3, b: Vec3) -> Vec3 {
    [0, 1, 2].map(|i| a[i] + b[i])
}
