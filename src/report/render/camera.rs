//! An orthographic camera, and the sides to look from.

use crate::geometry::vector::{Vec3, cross, dot, unit};

/// An orthographic camera: world millimetres to samples, depth growing towards the eye.
#[derive(Debug, Clone, Copy)]
pub struct Camera {
    pub right: Vec3,
    pub up: Vec3,
    /// From the part towards the eye.
    pub toward: Vec3,
    /// Samples for one millimetre.
    pub scale: f64,
    /// Where the world's origin falls, in samples.
    pub shift: [f64; 2],
}

/// Azimuth and elevation of the sides to look from, in degrees, the usual first.
pub const SIDES: [[f64; 2]; 8] = [
    [-58.0, 28.0],
    [-122.0, 28.0],
    [32.0, 28.0],
    [148.0, 28.0],
    [-58.0, -24.0],
    [-122.0, -24.0],
    [32.0, -24.0],
    [148.0, -24.0],
];

impl Camera {
    /// A camera that looks from an azimuth and elevation, not yet fitted to anything.
    pub fn from_side([azimuth, elevation]: [f64; 2]) -> Self {
        let (a, e) = (azimuth.to_radians(), elevation.to_radians());
        let toward = [e.cos() * a.cos(), e.cos() * a.sin(), e.sin()];
        let right = unit(cross([0.0, 0.0, 1.0], toward));
        Camera { right, up: cross(toward, right), toward, scale: 1.0, shift: [0.0; 2] }
    }

    /// The same camera, fitted so that the points fill the rectangle `[x0, y0, x1, y1]` of samples.
    pub fn fitted(mut self, points: impl IntoIterator<Item = Vec3>, [x0, y0, x1, y1]: [f64; 4]) -> Self {
        let (mut lo, mut hi) = ([f64::MAX; 2], [f64::MIN; 2]);
        for p in points {
            for (a, c) in [dot(self.right, p), -dot(self.up, p)].into_iter().enumerate() {
                (lo[a], hi[a]) = (lo[a].min(c), hi[a].max(c));
            }
        }
        if lo[0] > hi[0] {
            (lo, hi) = ([0.0; 2], [1.0; 2]);
        }
        let side = |a: usize| (hi[a] - lo[a]).max(1e-9);
        self.scale = ((x1 - x0) / side(0)).min((y1 - y0) / side(1));
        self.shift = [
            0.5 * (x0 + x1) - 0.5 * (lo[0] + hi[0]) * self.scale,
            0.5 * (y0 + y1) - 0.5 * (lo[1] + hi[1]) * self.scale,
        ];
        self
    }

    /// The same side, `scale` samples a millimetre, with `centre` at the sample `at`.
    pub fn centred(mut self, centre: Vec3, scale: f64, at: [f64; 2]) -> Self {
        self.scale = scale;
        self.shift = [at[0] - dot(self.right, centre) * scale, at[1] + dot(self.up, centre) * scale];
        self
    }

    /// Sample position and depth (in samples, growing towards the eye) of a point.
    #[inline]
    pub fn project(&self, p: Vec3) -> [f64; 3] {
        [
            self.shift[0] + self.scale * dot(self.right, p),
            self.shift[1] - self.scale * dot(self.up, p),
            self.scale * dot(self.toward, p),
        ]
    }
}

/// The corners of a facet of the exhibit.
pub fn facet(corners: &[Vec3], f: usize) -> Option<[Vec3; 3]> {
    corners.get(3 * f..3 * f + 3).and_then(|c| c.try_into().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fitted_view_fills_its_rectangle_and_keeps_right_angles() {
        let points = [[0.0, 0.0, 0.0], [10.0, 5.0, 3.0], [2.0, 9.0, -4.0]];
        let c = Camera::from_side(SIDES[0]).fitted(points, [100.0, 50.0, 300.0, 250.0]);
        assert!(dot(c.right, c.up).abs() < 1e-12 && dot(c.right, c.toward).abs() < 1e-12);
        for p in points.map(|p| c.project(p)) {
            assert!(p[0] >= 99.99 && p[0] <= 300.01 && p[1] >= 49.99 && p[1] <= 250.01, "{p:?}");
        }
    }
}
