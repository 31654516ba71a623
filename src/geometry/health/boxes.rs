//! Axis-aligned boxes as pairs of corners.

use crate::geometry::vector::Vec3;

/// The box of no point.
pub(super) const EMPTY: [Vec3; 2] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];

/// The least box that holds another and a point.
pub(super) fn grown([lo, hi]: [Vec3; 2], p: Vec3) -> [Vec3; 2] {
    [[0, 1, 2].map(|a| lo[a].min(p[a])), [0, 1, 2].map(|a| hi[a].max(p[a]))]
}

/// Whether a box lies in another that is larger by a margin.
pub(super) fn lies_in(inner: [Vec3; 2], outer: [Vec3; 2], margin: f64) -> bool {
    (0..3).all(|a| inner[0][a] >= outer[0][a] - margin && inner[1][a] <= outer[1][a] + margin)
}

/// The middle of a box.
pub(super) fn middle([lo, hi]: [Vec3; 2]) -> Vec3 {
    [0, 1, 2].map(|a| 0.5 * (lo[a] + hi[a]))
}
