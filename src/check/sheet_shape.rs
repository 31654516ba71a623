//! What a group of samples makes: a plate, a rod, a spot, or a wedge that runs out to an edge.

use crate::geometry::vector::{Vec3, bounds, cross, dot, norm, sub, unit};
use crate::medial::Sample;
use crate::medial::chord::{PARALLEL, WALL_SEPARATION};
use crate::medial::cluster::principal_extents;

/// A sheet that thins to less than this share of the limit (or of a smaller part) may have run out to an edge.
pub const RUN_OUT: f64 = 0.05;

/// What tapers is a speck if its area is less than that of a square of so many thicknesses.
const LEAST_WIDTHS: f64 = 3.0;

/// Sine of the angle between two directions across that are as good as at right angles, and of the one that a direction across may be off the
/// plane across an axis.
const AROUND: f64 = 0.85;
const LEVEL: f64 = 0.45;

/// What the middle surface of a sheet looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    Plate,
    Rod,
    Spot,
}

/// A sheet summed up.
#[derive(Debug, Clone)]
pub struct Sheet {
    pub thinnest: Sample,
    pub low: f64,
    pub area: f64,
    pub extent: (Vec3, Vec3),
    pub spans: [f64; 3],
    pub form: Form,
    /// The axis of what is thin from all sides around it: a waist, or the end of a rod.
    pub axis: Option<Vec3>,
}

/// Whether a sample is so thin that its sheet has run out to an edge. What may be that thin, and is not known to be, has not.
pub fn runs_out(sample: &Sample, scale: f64) -> bool {
    sample.diameter < RUN_OUT * scale
}

/// Sums a group up, or says that it is a wedge: `None`.
pub fn sheet_of(samples: &[Sample], scale: f64, thins_out: impl Fn(&Sample) -> bool) -> Option<Sheet> {
    if samples.iter().any(|s| runs_out(s, scale)) {
        return blunt_sheet(samples, scale, thins_out);
    }
    summed(&samples.iter().collect::<Vec<_>>())
}

/// What is a sheet in a group that thins out to an edge: what of it tapers as a wall may and yet ends before, if that is no speck, or else what
/// [`parallel_sheet`] says.
pub fn blunt_sheet(samples: &[Sample], scale: f64, thins_out: impl Fn(&Sample) -> bool) -> Option<Sheet> {
    let ends_before = |s: &&Sample| s.separation >= WALL_SEPARATION && !runs_out(s, scale) && !thins_out(s);
    let blunt: Vec<&Sample> = samples.iter().filter(ends_before).collect();
    let tapered = || blunt.iter().filter(|s| s.separation < PARALLEL);
    let area = tapered().map(|s| s.area).sum::<f64>();
    let mean = tapered().map(|s| s.area * s.diameter).sum::<f64>() / area.max(f64::MIN_POSITIVE);
    let is_speck = 0.5 * area <= (LEAST_WIDTHS * mean).powi(2);
    if is_speck { parallel_sheet(samples, scale) } else { summed(&blunt) }
}

/// What is a sheet in a group that thins out to an edge: only what is parallel, and only if it is as large as the limit squared.
pub fn parallel_sheet(samples: &[Sample], scale: f64) -> Option<Sheet> {
    let parallel: Vec<&Sample> = samples.iter().filter(|s| s.separation >= PARALLEL && s.low >= 1e-3 * scale).collect();
    summed(&parallel).filter(|s| s.area >= scale * scale)
}

/// Samples as one sheet.
fn summed(parallel: &[&Sample]) -> Option<Sheet> {
    let thinnest = **parallel.iter().min_by(|a, b| a.diameter.total_cmp(&b.diameter))?;
    let area = 0.5 * parallel.iter().map(|s| s.area).sum::<f64>();
    let spans = principal_extents(&parallel.iter().map(|s| s.centre).collect::<Vec<_>>());
    let form = if spans[0] < thinnest.diameter {
        Form::Spot
    } else if spans[1] < 0.5 * thinnest.diameter {
        Form::Rod
    } else {
        Form::Plate
    };
    Some(Sheet {
        thinnest,
        low: parallel.iter().map(|s| s.low).fold(thinnest.diameter, f64::min),
        area,
        extent: bounds(parallel.iter().flat_map(|s| s.contacts))?,
        spans,
        form,
        axis: axis_of(parallel),
    })
}

/// The axis that all directions across are about at right angles to, if they go around it.
fn axis_of(samples: &[&Sample]) -> Option<Vec3> {
    let across = |s: &Sample| unit(sub(s.contacts[1], s.contacts[0]));
    let first = across(samples.first()?);
    let turned = samples.iter().map(|s| cross(first, across(s))).max_by(|a, b| norm(*a).total_cmp(&norm(*b)))?;
    let axis = unit(turned);
    let is_level = |s: &&Sample| dot(across(s), axis).abs() <= LEVEL;
    (norm(turned) >= AROUND && samples.iter().all(is_level)).then_some(axis)
}
