//! The thickness shown at a point of the surface.

use super::chord::Patch;
use super::feature::Features;
use crate::geometry::vector::Vec3;

/// Distance from a surface point to the nearest opposing surface on one side, up to `within`; `within` if there is none.
///
/// `whole` is the facet the point lies on. `opposite` is a feature that may be the nearest, and becomes the one that is: it saves
/// work on the next point nearby, and changes nothing else.
///
/// For pictures: on a wall it is the wall's thickness up to its rim; verdicts come from [`super::cover`].
pub fn opposing_distance(
    features: &Features,
    (p, axis): (Vec3, Vec3),
    within: f64,
    whole: [Vec3; 3],
    opposite: &mut Option<u32>,
) -> f64 {
    let patch = Patch { corners: [p; 3], axis, spread: 0.0, slack: 0.0, whole };
    features.nearest_chord(&patch, within, opposite).map_or(within, |c| c.length)
}
