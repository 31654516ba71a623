//! Random numbers for tests, the same in every run.

/// A linear congruential generator with the constants of D. E. Knuth's MMIX.
pub(crate) struct Lcg(pub u64);

impl Lcg {
    pub fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) % n
    }

    /// In `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        self.below(1 << 31) as f64 / f64::from(1u32 << 31)
    }

    pub fn point(&mut self, lo: f64, hi: f64) -> [f64; 3] {
        [0; 3].map(|_| lo + (hi - lo) * self.unit())
    }

    /// A rotation, from a quaternion drawn in the unit ball.
    pub fn rotation(&mut self) -> [[f64; 3]; 3] {
        let q = loop {
            let q = [0; 4].map(|_| 2.0 * self.unit() - 1.0);
            let n: f64 = q.iter().map(|x| x * x).sum();
            if n > 0.01 && n < 1.0 {
                break q.map(|x| x / n.sqrt());
            }
        };
        let [w, x, y, z] = q;
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }
}
