//! The thinnest place on one feature, to the resolution of the coordinates.

use super::cover::{Question, Sample};
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
}

/// The thinnest sheet within a body on a feature that is thinner than `best`, and a bound below which there is none.
///
/// The search of the cover is run with what is known, less half a micrometre, as its only limit, until it finds nothing
/// or `budget` evaluations are spent; what it leaves open then stays in the bound.
pub fn thinnest_on(
    mesh: &MeshDistance,
    features: &Features,
    question: &Question,
    feature: u32,
    best: f64,
    budget: u64,
) -> Thinnest {
    let mut known = Thinnest { sample: None, low: 0.0 };
    let (mut least, mut spent, mut opposite) = (best, 0, None);
    for _ in 0..LOOKS {
        let below = least - GAIN;
        let (notice, finest) = (1.25 * least, question.finest / FINER);
        let narrower = Question { limits: vec![below], notice, agree: GAIN, finest, ..question.clone() };
        let cover = Seeker::new(mesh, features, &narrower, budget.saturating_sub(spent)).seek(feature, &mut opposite);
        spent += cover.evaluations;
        let sheets = cover.samples.iter().filter(|s| s.is_within_a_body(features) && s.low < below);
        let open = cover.unresolved.iter().filter(|u| u.extent > question.finest);
        let left = sheets.clone().map(|s| s.low).chain(open.map(|u| u.low)).fold(below, f64::min);
        known.low = known.low.max(left);
        let thinner = sheets.filter(|s| s.diameter < least).min_by(|a, b| a.diameter.total_cmp(&b.diameter));
        if let Some(s) = thinner {
            least = s.diameter;
            known.sample = Some(*s);
        }
        if thinner.is_none() || known.low >= least - GAIN || spent >= budget {
            break;
        }
    }
    known
}
