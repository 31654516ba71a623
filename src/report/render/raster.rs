//! Facets into a depth buffer: which facet is seen at each sample.

use super::camera::Camera;
use crate::geometry::vector::Vec3;
use pulp::Arch;

/// No facet is seen here.
pub const NOTHING: u32 = u32::MAX;

/// For each sample the facet nearest to the eye and its depth.
pub struct Raster {
    pub width: usize,
    pub height: usize,
    pub facet: Vec<u32>,
    /// In samples, growing towards the eye.
    pub depth: Vec<f32>,
    /// For each row the first covered column and the one after the last.
    covered: Vec<[usize; 2]>,
}

/// Which facets can be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Faces {
    /// Those that face the eye: enough for a closed surface.
    Front,
    /// Both sides: an open surface shows its inside.
    Both,
}

impl Raster {
    /// Facets seen by a camera on `width` × `height` samples; sample `[i, j]` stands at `(i + ½, j + ½)`.
    ///
    /// A sample on an edge belongs to both facets, the nearer wins, and of equals the first in order, so that there
    /// are no cracks and the result does not depend on threads.
    ///
    /// # Cost
    /// O(facets + covered samples).
    pub fn new(corners: &[Vec3], camera: &Camera, width: usize, height: usize, faces: Faces) -> Self {
        let mut raster = Raster {
            width,
            height,
            facet: vec![NOTHING; width * height],
            depth: vec![f32::MIN; width * height],
            covered: vec![[usize::MAX, 0]; height],
        };
        // The same code for the widest vectors of the machine.
        Arch::new().dispatch(|| {
            for (f, c) in corners.chunks_exact(3).enumerate() {
                raster.throw(f as u32, [camera.project(c[0]), camera.project(c[1]), camera.project(c[2])], faces);
            }
        });
        raster
    }

    /// The columns of a row that may be covered, one more on each side; empty for a row without facets.
    pub fn covered(&self, row: usize) -> std::ops::Range<usize> {
        match self.covered.get(row) {
            Some(&[from, to]) if from < to => from.saturating_sub(1)..(to + 1).min(self.width),
            _ => 0..0,
        }
    }

    /// One facet by its projected corners.
    #[inline(always)]
    fn throw(&mut self, f: u32, [a, b, c]: [Vec3; 3], faces: Faces) {
        // The screen's y runs down, so a facet that faces the eye runs clockwise here and has a negative area.
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if !twice.is_finite() || twice.abs() < 1e-12 || (twice > 0.0 && faces == Faces::Front) {
            return;
        }
        let (left, right) = (a[0].min(b[0]).min(c[0]), a[0].max(b[0]).max(c[0]));
        let (top, bottom) = (a[1].min(b[1]).min(c[1]), a[1].max(b[1]).max(c[1]));
        let rows = (top - 0.5).ceil().max(0.0) as usize
            ..((bottom - 0.5).floor() + 1.0).clamp(0.0, self.height as f64) as usize;
        if right < 0.0 || left > self.width as f64 || rows.is_empty() {
            return;
        }
        let [a, b, c] = if twice > 0.0 { [a, b, c] } else { [a, c, b] };
        let twice = twice.abs();
        let slope = |i: usize, j: usize| {
            let (ab, ac) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
            let (dab, dac) = (b[2] - a[2], c[2] - a[2]);
            (dab * ac[j] - dac * ab[j]) / twice * if i == 0 { 1.0 } else { -1.0 }
        };
        let (dx, dy) = (slope(0, 1), slope(1, 0));
        for j in rows {
            let y = j as f64 + 0.5;
            let (mut from, mut to) = (0.5, self.width as f64 - 0.5);
            for (p, q) in [(a, b), (b, c), (c, a)] {
                // Inside is where (q − p) × (s − p) ≥ 0.
                let (ex, ey) = (q[0] - p[0], q[1] - p[1]);
                let along = ex * (y - p[1]) + ey * p[0];
                if ey > 0.0 {
                    to = f64::min(to, along / ey + 1e-6);
                } else if ey < 0.0 {
                    from = f64::max(from, along / ey - 1e-6);
                } else if ex * (y - p[1]) < 0.0 {
                    to = f64::MIN;
                }
            }
            if from > to {
                continue;
            }
            let (i0, i1) = ((from - 0.5).ceil() as usize, (to - 0.5).floor() as usize);
            let z0 = a[2] + dx * (i0 as f64 + 0.5 - a[0]) + dy * (y - a[1]);
            if let Some([first, last]) = self.covered.get_mut(j) {
                (*first, *last) = ((*first).min(i0), (*last).max(i1 + 1));
            }
            self.span(j * self.width + i0, (i1 + 1).saturating_sub(i0), f, z0, dx);
        }
    }

    /// One row of a facet, from a position in storage.
    #[inline(always)]
    fn span(&mut self, start: usize, length: usize, f: u32, z0: f64, dx: f64) {
        let end = start + length;
        let (Some(facets), Some(depths)) = (self.facet.get_mut(start..end), self.depth.get_mut(start..end)) else {
            return;
        };
        for (i, (facet, depth)) in facets.iter_mut().zip(depths).enumerate() {
            let z = (z0 + dx * i as f64) as f32;
            if z > *depth {
                (*depth, *facet) = (z, f);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain_camera() -> Camera {
        Camera { right: [1.0, 0.0, 0.0], up: [0.0, -1.0, 0.0], toward: [0.0, 0.0, 1.0], scale: 1.0, shift: [0.0; 2] }
    }

    #[test]
    fn spans_equal_the_test_of_every_sample() {
        let mut seed = 7u64;
        let mut draw = |range: f64| {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) as f64 / (1u64 << 31) as f64 * range
        };
        let corners: Vec<Vec3> = (0..60).map(|_| [draw(40.0) - 4.0, draw(40.0) - 4.0, draw(9.0)]).collect();
        let raster = Raster::new(&corners, &plain_camera(), 32, 32, Faces::Both);
        for j in 0..32 {
            for i in 0..32 {
                let s = [i as f64 + 0.5, j as f64 + 0.5];
                let mut best = (f64::MIN, NOTHING);
                for (f, c) in corners.chunks_exact(3).enumerate() {
                    let edge = |p: Vec3, q: Vec3| (q[0] - p[0]) * (s[1] - p[1]) - (q[1] - p[1]) * (s[0] - p[0]);
                    let w = [edge(c[1], c[2]), edge(c[2], c[0]), edge(c[0], c[1])];
                    let area: f64 = w.iter().sum();
                    if w.iter().all(|x| x * area >= 0.0) {
                        let z = (0..3).map(|k| w[k] / area * c[k][2]).sum();
                        if z > best.0 {
                            best = (z, f as u32);
                        }
                    }
                }
                assert_eq!(raster.facet[j * 32 + i], best.1, "sample {i}, {j}");
                if best.1 != NOTHING {
                    // f32 depth of at most 9.
                    assert!((f64::from(raster.depth[j * 32 + i]) - best.0).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn two_facets_of_a_square_leave_no_crack_and_back_faces_can_be_left_out() {
        let [a, b, c, d] = [[1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [9.0, 9.0, 0.0], [1.0, 9.0, 0.0]];
        let count = |r: Raster| r.facet.iter().filter(|&&f| f != NOTHING).count();
        let front = [a, c, b, a, d, c];
        assert_eq!(count(Raster::new(&front, &plain_camera(), 10, 10, Faces::Front)), 64);
        let back = [a, b, c, a, c, d];
        assert_eq!(count(Raster::new(&back, &plain_camera(), 10, 10, Faces::Front)), 0);
        assert_eq!(count(Raster::new(&back, &plain_camera(), 10, 10, Faces::Both)), 64);
    }
}
