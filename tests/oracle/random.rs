//! Random turns, shifts and sizes, the same in every run.

use amcheck::geometry::TriangleMesh;
use amcheck::geometry::vector::Vec3;

/// A linear congruential generator (Knuth's constants).
pub struct Random(pub u64);

impl Random {
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

/// A closed outline in (r, z), counter-clockwise, turned about z in `n` steps; r = 0 lies on the axis.
pub fn lathe(outline: &[[f64; 2]], n: usize) -> TriangleMesh {
    let at = |[r, z]: [f64; 2], j: usize| {
        let (s, c) = (std::f64::consts::TAU * (j % n) as f64 / n as f64).sin_cos();
        [r * c, r * s, z]
    };
    let mut facets = Vec::new();
    for (i, &p) in outline.iter().enumerate() {
        let q = outline[(i + 1) % outline.len()];
        for j in 0..n {
            if q[0] > 0.0 {
                facets.push([at(p, j), at(q, j + 1), at(q, j)]);
            }
            if p[0] > 0.0 {
                facets.push([at(p, j), at(p, j + 1), at(q, j + 1)]);
            }
        }
    }
    let mesh = TriangleMesh::weld(facets);
    if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh }
}

/// A box between two corners.
pub fn cuboid(lo: Vec3, hi: Vec3) -> TriangleMesh {
    let corner = |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 1 { hi[a] } else { lo[a] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    TriangleMesh::weld(
        quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|t: [usize; 3]| t.map(corner)),
    )
}
