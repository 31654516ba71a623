//! The thinnest place on one feature, to the resolution of the coordinates.

use super::chord::WALL_SEPARATION;
use super::cover::{Own, Question, Sample};
use super::feature::Features;
use super::seek::Seeker;
use crate::geometry::MeshDistance;

/// Gain in thickness that is worth a further look, millimetres.
const GAIN: f64 = 5e-4;
/// The smallest patch is finer than the question's by so much: the value is sought further than the bound is claimed.
const FINER: f64 = 16.0;
/// Searches on one feature, each below what the one before it found.
const LOOKS: usize = 12;

/// What is known of a feature after it was searched for something thinner than a sheet that is there.
#[derive(Debug, Clone, Copy)]
pub struct Thinnest {
    /// The thinnest sheet on the feature, if it is thinner than what was known.
    pub sample: Option<Sample>,
    /// No sheet on the feature that is wider than the question's finest patch is thinner.
    pub low: f64,
    /// Evaluations that it took.
    pub spent: u64,
}

/// The thinnest sheet within a body on a feature that is thinner than `best`, and a bound below which there is none.
///
/// The search of the cover is run with what is known, less half a micrometre, as its only limit, until it finds nothing
/// or `budget` evaluations are spent; what it leaves open then stays in the bound. A limit of the question that lies
/// within that half micrometre is asked for itself, so that what is just as thick as a limit is told from what is
/// thinner. Only one's own is found and bounded.
pub fn thinnest_on(
    mesh: &MeshDistance,
    features: &Features,
    question: &Question,
    feature: u32,
    best: f64,
    budget: u64,
    own: Own,
) -> Thinnest {
    let mut known = Thinnest { sample: None, low: 0.0, spent: 0 };
    let (mut least, mut opposite) = (best, None);
    for _ in 0..LOOKS {
        let near = question.limits.iter().rev().find(|&&limit| limit <= least && limit > least - GAIN);
        let (below, agree) = near.map_or((least - GAIN, GAIN), |&limit| (limit, question.tolerance));
        let (notice, finest) = (1.25 * least, question.finest / FINER);
        let narrower = Question { limits: vec![below], notice, agree, finest, ..question.clone() };
        let left = budget.saturating_sub(known.spent);
        let cover = Seeker::new(mesh, features, &narrower, left).for_own(own).seek(feature, &mut opposite);
        known.spent += cover.evaluations;
        let mut thin: Vec<&Sample> =
            cover.samples.iter().filter(|s| s.is_within_a_body(features) && s.low < below).collect();
        // Whether a sample counts may take long: only of the first that does in each order it matters.
        thin.sort_by(|a, b| a.low.total_cmp(&b.low));
        let open = cover.unresolved.iter().filter(|u| u.extent > question.finest);
        let mut left = open.map(|u| u.low).fold(below, f64::min);
        for s in &thin {
            if s.low >= left {
                break;
            }
            if (own.counts)(s) {
                left = left.min((own.from)(s.centre, narrower.resolution(s.low), s.low));
            }
        }
        known.low = known.low.max(left);
        // One that is almost a wall bounds what is beside it and is none itself.
        let is_wall = |s: &&Sample| s.diameter < least && s.separation >= WALL_SEPARATION;
        let mut walls: Vec<&Sample> = thin.into_iter().filter(is_wall).collect();
        walls.sort_by(|a, b| a.diameter.total_cmp(&b.diameter));
        let thinner = walls.into_iter().find(|s| (own.counts)(s));
        if let Some(s) = thinner {
            least = s.diameter;
            known.sample = Some(*s);
        }
        let told = known.low >= least - GAIN && question.class(known.low) == question.class(least);
        if thinner.is_none() || told || known.spent >= budget {
            break;
        }
    }
    known
}
