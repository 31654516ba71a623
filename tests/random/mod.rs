//! Random turns, shifts, sizes and counts for tests, the same in every run.
#![allow(dead_code)]

use amcheck::geometry::TriangleMesh;
use amcheck::geometry::vector::Vec3;

/// A linear congruential generator (Knuth's constants).
pub struct Random(pub u64);

impl Random {
    /// A whole number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % n
    }

    /// Uniform in [lo, hi).
    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        lo + (hi - lo) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// A whole number from `lo` to `hi`, both included.
    pub fn whole(&mut self, lo: usize, hi: usize) -> usize {
        (self.between(lo as f64, hi as f64 + 1.0) as usize).min(hi)
    }

    /// A point of a cube about the origin.
    pub fn point(&mut self, reach: f64) -> Vec3 {
        [0; 3].map(|_| self.between(-reach, reach))
    }

    /// A rotation, from a quaternion drawn in the unit ball.
    pub fn rotation(&mut self) -> [Vec3; 3] {
        loop {
            let q = [0; 4].map(|_| self.between(-1.0, 1.0));
            let n: f64 = q.iter().map(|x| x * x).sum();
            if n > 0.05 && n < 1.0 {
                let [w, x, y, z] = q.map(|c| c / n.sqrt());
                return [
                    [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
                    [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
                    [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
                ];
            }
        }
    }

    /// The mesh under a random turn and shift.
    pub fn moved(&mut self, mesh: &TriangleMesh) -> TriangleMesh {
        let rotation = self.rotation();
        mesh.transformed(rotation, self.point(30.0))
    }
}
