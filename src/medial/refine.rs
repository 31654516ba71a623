//! The thinnest place on a few features, to the resolution of the coordinates.

use super::chord::{Patch, WALL_SEPARATION};
use super::cover::{Question, Sample, Shape};
use super::feature::Features;
use crate::geometry::MeshDistance;
use crate::geometry::vector::scale;
use std::collections::VecDeque;

/// Patches looked at for one feature.
const MOST_PATCHES: usize = 300;
/// Gain in thickness that is worth a further look, millimetres.
const GAIN: f64 = 5e-4;

/// The thinnest sheet on a facet that is thinner than `best`, if there is one.
///
/// Branch and bound on the shortest chord of a patch: a patch whose bound is not below the best ball found is left, others
/// are halved.
pub fn thinnest_on(
    mesh: &MeshDistance,
    features: &Features,
    question: &Question,
    facet: u32,
    best: &Sample,
) -> Option<Sample> {
    let feature = features.of_facet(facet)?;
    let mut found: Option<Sample> = None;
    let mut queue = VecDeque::from([Patch::from(feature)]);
    for _ in 0..MOST_PATCHES {
        let Some(patch) = queue.pop_front() else { break };
        let least = found.map_or(best.diameter, |s| s.diameter);
        let Some(chord) = features.nearest_chord(&patch, least - GAIN) else { continue };
        let ball =
            mesh.touching_ball(patch.centroid(), scale(patch.axis, -1.0), 0.51 * question.notice, question.tolerance);
        if let Some(stop) = ball.stop
            && ball.separation() >= WALL_SEPARATION
            && 2.0 * ball.radius < least
        {
            found = Some(Sample {
                shape: Shape::Sheet,
                centre: ball.centre,
                contacts: [ball.from, stop.point],
                diameter: 2.0 * ball.radius,
                low: chord.bound.min(2.0 * ball.radius),
                separation: ball.separation(),
                area: 0.0,
                facet,
                opposite: stop.facet,
            });
        }
        if patch.longest_edge().0 > question.finest() / 16.0 {
            queue.extend(patch.halves());
        }
    }
    found
}
