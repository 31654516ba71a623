//! The thickness shown at a point of the surface.

use super::chord::Patch;
use super::feature::Features;
use crate::geometry::vector::Vec3;

/// Distance from a surface point to the nearest opposing surface on one side, up to `within`; `within` if there is none.
///
/// `whole` is the facet the point lies on.
///
/// For pictures: on a wall it is the wall's thickness up to its rim; verdicts come from [`super::cover`].
pub fn opposing_distance(features: &Features, p: Vec3, axis: Vec3, within: f64, whole: [Vec3; 3]) -> f64 {
    let patch = Patch { corners: [p; 3], axis, spread: 0.0, slack: 0.0, whole };
    features.nearest_chord(&patch, within).map_or(within, |c| c.length)
}
