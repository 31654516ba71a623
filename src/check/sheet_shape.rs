//! What a group of samples makes: a plate, a rod, a spot, or a wedge that runs out to an edge.

use crate::geometry::vector::{Vec3, bounds, cross, dot, norm, sub, unit};
use crate::medial::Sample;
use crate::medial::chord::{PARALLEL, WALL_SEPARATION};
use crate::medial::cluster::principal_extents;
use rayon::prelude::*;

/// An edge blunted by a face no wider than this share of the limit (or of a smaller part) is one that a sheet runs out to.
pub const RUN_OUT: f64 = 0.05;

/// What tapers is a speck if its area is less than that of a square of so many thicknesses.
const LEAST_WIDTHS: f64 = 3.0;

/// Half of the tighter limit is the side of the least square that is a sheet beside an edge: what one limit judges must not hang on another.
const LEAST_SIDE: f64 = 0.5;

/// Sine of the angle between two directions across that are as good as at right angles, and of the one that a direction across may be off the
/// plane across an axis.
const AROUND: f64 = 0.85;
const LEVEL: f64 = 0.45;

/// The limits that sheets are judged by, or the part if that is smaller, millimetres.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    pub wide: f64,
    pub tight: f64,
}

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
    /// Area of the patches it was found on, on one side, mm².
    pub area: f64,
    /// Area of what of them is thin, mm².
    pub thin: f64,
    pub extent: (Vec3, Vec3),
    pub spans: [f64; 3],
    pub form: Form,
    /// The axis of what is thin from all sides around it: a waist, or the end of a rod.
    pub axis: Option<Vec3>,
}

impl Sheet {
    /// Adds what lies beside its samples and is as thin.
    pub fn add_area(&mut self, samples: &[Sample]) {
        self.thin += 0.5 * samples.iter().map(|s| s.thin).sum::<f64>();
        let of_samples = samples.iter().flat_map(|s| s.contacts);
        self.extent = bounds(of_samples.chain([self.extent.0, self.extent.1])).unwrap_or(self.extent);
    }
}

/// Where a sheet ends.
pub trait Ends: Sync {
    /// Whether a sample lies in a wedge that runs out to an edge.
    fn runs_out(&self, sample: &Sample, scale: Scale) -> bool;

    /// Whether a sheet goes on thinning beyond a sample until its sides meet, or to less than `from`.
    fn thins_out(&self, sample: &Sample, from: f64) -> bool;

    /// Whether it comes to no end and to no less than `from` where it thins most from a sample on.
    fn stays(&self, sample: &Sample, from: f64) -> bool;
}

/// Sums a group up, or says that it is a wedge: `None`.
///
/// None of the samples is thinner than `from`.
pub fn sheet_of(samples: &[Sample], from: f64, scale: Scale, ends: &impl Ends) -> Option<Sheet> {
    let staying = staying(samples, scale, ends);
    if staying.len() < samples.len() { blunt(&staying, from, scale, ends) } else { summed(&staying) }
}

/// What is a sheet in a group that thins out to an edge: what of it tapers as a wall may and yet ends before, if that is no speck, or else what
/// is parallel, or a skin.
pub fn blunt_sheet(samples: &[Sample], from: f64, scale: Scale, ends: &impl Ends) -> Option<Sheet> {
    blunt(&staying(samples, scale, ends), from, scale, ends)
}

/// The samples that do not run out to an edge.
fn staying<'s>(samples: &'s [Sample], scale: Scale, ends: &impl Ends) -> Vec<&'s Sample> {
    samples.par_iter().filter(|s| !ends.runs_out(s, scale)).collect()
}

/// [`blunt_sheet`] of what stays.
fn blunt(staying: &[&Sample], from: f64, scale: Scale, ends: &impl Ends) -> Option<Sheet> {
    let ends_before = |s: &&&Sample| s.separation >= WALL_SEPARATION && !ends.thins_out(s, from);
    let ended: Vec<&Sample> = staying.iter().filter(ends_before).copied().collect();
    let tapered = || ended.iter().filter(|s| s.separation < PARALLEL);
    let area = tapered().map(|s| s.area).sum::<f64>();
    let mean = tapered().map(|s| s.area * s.diameter).sum::<f64>() / area.max(f64::MIN_POSITIVE);
    let is_speck = 0.5 * area <= (LEAST_WIDTHS * mean).powi(2);
    if !is_speck {
        return summed(&ended);
    }
    parallel_sheet(staying, scale).or_else(|| skin(&ended, from, ends))
}

/// What of a group thins to no less than `from` and leads nowhere, if its thinnest place is known and it is no speck: a skin between two rooms
/// beside an edge.
fn skin(samples: &[&Sample], from: f64, ends: &impl Ends) -> Option<Sheet> {
    if !samples.iter().any(|s| s.separation >= PARALLEL && ends.stays(s, from)) {
        return None;
    }
    let skin: Vec<&Sample> = samples.iter().filter(|s| ends.stays(s, from)).copied().collect();
    summed(&skin).filter(|s| s.thinnest.separation >= PARALLEL && s.area >= s.thinnest.diameter.powi(2))
}

/// What is a sheet in a group that thins out to an edge: only what is parallel, and only if it is as large as half the tighter limit squared.
fn parallel_sheet(staying: &[&Sample], scale: Scale) -> Option<Sheet> {
    let is_parallel = |s: &&&Sample| s.separation >= PARALLEL && s.low >= 1e-3 * scale.wide;
    let parallel: Vec<&Sample> = staying.iter().filter(is_parallel).copied().collect();
    summed(&parallel).filter(|s| s.area >= (LEAST_SIDE * scale.tight).powi(2))
}

/// What of a sheet may be thinner than a limit that its thinnest place is below: the samples whose bound is, or that place alone.
pub fn below(sheet: &Sheet, samples: &[Sample], limit: f64) -> Sheet {
    let thin: Vec<&Sample> = samples.iter().filter(|s| s.low < limit).collect();
    let (thinnest, low) = (sheet.thinnest, sheet.low);
    let spot = || Sheet {
        area: 0.0,
        thin: 0.0,
        extent: bounds(thinnest.contacts).unwrap_or(sheet.extent),
        spans: [0.0; 3],
        form: Form::Spot,
        ..sheet.clone()
    };
    let Some(part) = summed(&thin) else { return spot() };
    let is_spot = part.spans[0] < thinnest.diameter || part.area < thinnest.diameter.powi(2);
    let form = if is_spot { Form::Spot } else { part.form };
    Sheet { thinnest, low, form, ..part }
}

/// Samples around a waist as one: it widens both ways, so that none of them lies in a wedge.
pub fn waist_of(samples: &[Sample]) -> Option<Sheet> {
    summed(&samples.iter().collect::<Vec<_>>())
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
        thin: 0.5 * parallel.iter().map(|s| s.thin).sum::<f64>(),
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

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::medial::Shape;

    /// Samples of a plate of 10 × 2 mm, 0.9 mm thick, and 0.7 mm over some of its length; bounds are 0.05 mm less.
    pub fn plate(thin: usize) -> Vec<Sample> {
        (0..40)
            .map(|n| {
                let (x, y) = (0.5 * (n / 2) as f64, (n % 2) as f64);
                let diameter = if n / 2 < thin { 0.7 } else { 0.9 };
                Sample {
                    centre: [x, y, 0.0],
                    contacts: [-0.5, 0.5].map(|side| [x, y, side * diameter]),
                    diameter,
                    low: diameter - 0.05,
                    separation: std::f64::consts::PI,
                    shape: Shape::Sheet,
                    area: 1.0,
                    thin: 1.0,
                    edge: 1.0,
                    sides: ([x, y, 0.0], [x, y, 0.0]),
                    feature: 0,
                    facet: 0,
                    opposite: 0,
                }
            })
            .collect()
    }

    /// No sheet ends.
    struct Nowhere;

    impl Ends for Nowhere {
        fn runs_out(&self, _: &Sample, _: Scale) -> bool {
            false
        }

        fn thins_out(&self, _: &Sample, _: f64) -> bool {
            false
        }

        fn stays(&self, _: &Sample, _: f64) -> bool {
            true
        }
    }

    #[test]
    fn a_sheet_below_a_limit_is_what_of_it_may_be() {
        for (thin, area, form) in [(1, 1.0, Form::Rod), (0, 0.0, Form::Spot), (10, 10.0, Form::Plate)] {
            let samples = plate(thin);
            let scale = Scale { wide: 1.2, tight: 0.8 };
            let sheet = sheet_of(&samples, 0.0, scale, &Nowhere).unwrap();
            assert!((sheet.area - 20.0).abs() < 1e-9 && sheet.form == Form::Plate);
            let part = below(&sheet, &samples, 0.8);
            assert!((part.area - area).abs() < 1e-9 && part.form == form, "{thin}: {part:?}");
            assert_eq!((part.thinnest.diameter, part.low), (sheet.thinnest.diameter, sheet.low));
        }
    }
}
