//! Which arithmetic a count may be trusted to: the rule, as code.

use super::transform::Real;
use crate::error::{Error, Result};

/// The arithmetic a convolution was done in; every result says which.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Precision {
    /// 32-bit floating point.
    Single,
    /// 64-bit floating point.
    Double,
    /// Integers modulo the prime [`MODULUS`]: exact for every count below it.
    Modular,
}

/// The prime 15·2²⁷ + 1, which has roots of unity for every power of two up to 2²⁷ and exceeds 1024³.
pub const MODULUS: u32 = 2_013_265_921;

/// The largest error a rounded count may carry: what is nearer than this to an integer is that integer.
pub const ALLOWED: f64 = 0.45;

/// Size of a convolution, as far as its rounding depends on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Workload {
    /// ‖f‖₂² of the first operand: for an indicator the number of its samples.
    pub energy_a: f64,
    /// ‖g‖₂² of the second operand.
    pub energy_b: f64,
    /// ‖f‖₁; for an indicator the number of its samples again.
    pub mass_a: f64,
    /// ‖g‖₁.
    pub mass_b: f64,
    /// Samples of the padded grid.
    pub padded: u128,
}

impl Workload {
    /// The workload of two indicators with the given numbers of samples.
    pub fn of_counts(a: u64, b: u64, padded: u128) -> Self {
        let [a, b] = [a as f64, b as f64];
        Workload { energy_a: a, energy_b: b, mass_a: a, mass_b: b, padded }
    }

    /// A rigorous bound on the error of any value of a convolution done in `T`, in the unit of the values.
    ///
    /// With a relative 2-norm error η of one transform (N. J. Higham, Accuracy and Stability of Numerical
    /// Algorithms, 2002, §24.1) the product of two spectra is off by `(2η + η²)·‖f‖₂‖g‖₂` in every value after an exact
    /// inverse, its own rounding adds `4u·(1+η)²·‖f‖₂‖g‖₂`, and the inverse transform adds `η·‖f∗g‖₂`, where
    /// `‖f∗g‖₂ ≤ min(‖f‖₁‖g‖₂, ‖f‖₂‖g‖₁)` (Young). η = 24·u·(log₂N + 3): a level of butterflies costs at most
    /// 4√2·u, and twiddle factors from an angle of up to 2π, itself rounded, are off by up to 2π·2.5u + u; a pass that
    /// takes 3, 5 or 8 points at once turns them but once and costs less than the log₂ of that in levels. Three more
    /// levels stand for the split of the real rows.
    pub fn rounding_bound<T: Real>(&self) -> f64 {
        let u = T::ROUNDOFF;
        let levels = (self.padded.max(2) as f64).log2() + 3.0;
        let eta = 24.0 * u * levels;
        let norms = (self.energy_a * self.energy_b).sqrt();
        let product = (2.0 * eta + eta * eta + 4.0 * u * (1.0 + eta).powi(2)) * norms;
        let young = (self.mass_a * self.energy_b.sqrt()).min(self.mass_b * self.energy_a.sqrt());
        let disturbed = (self.padded as f64).sqrt() * product;
        product + eta * (young + disturbed)
    }

    /// The bound for a given arithmetic; 0 for integers that cannot wrap, infinite for those that can.
    pub fn bound(&self, precision: Precision) -> f64 {
        match precision {
            Precision::Single => self.rounding_bound::<f32>(),
            Precision::Double => self.rounding_bound::<f64>(),
            Precision::Modular if self.mass_a.min(self.mass_b) < f64::from(MODULUS) => 0.0,
            Precision::Modular => f64::INFINITY,
        }
    }

    /// The cheapest arithmetic whose counts are provably exact.
    ///
    /// # Errors
    /// [`Error::PrecisionLost`] if none is: both operands have more samples than [`MODULUS`].
    pub fn exact_precision(&self) -> Result<Precision> {
        let all = [Precision::Single, Precision::Double, Precision::Modular];
        all.into_iter()
            .find(|&p| self.bound(p) < ALLOWED)
            .ok_or(Error::PrecisionLost { bound: self.bound(Precision::Double), allowed: ALLOWED })
    }

    /// Agrees to a given arithmetic, and says the bound.
    ///
    /// # Errors
    /// [`Error::PrecisionLost`] if counts done in it could not be rounded.
    pub fn demand(&self, precision: Precision) -> Result<f64> {
        let bound = self.bound(precision);
        if bound < ALLOWED { Ok(bound) } else { Err(Error::PrecisionLost { bound, allowed: ALLOWED }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cubes(a: u64, b: u64, n: u128) -> Workload {
        Workload::of_counts(a.pow(3), b.pow(3), n.pow(3))
    }

    #[test]
    fn single_precision_is_refused_where_it_is_known_to_fail() {
        // Two solid 128³ cubes in 256³ were measured to be off by 0.625 in f32: a distance to integers cannot see that.
        let solid = cubes(128, 128, 256);
        assert!(matches!(solid.demand(Precision::Single), Err(Error::PrecisionLost { .. })));
        assert_eq!(solid.exact_precision().unwrap(), Precision::Double);
        assert_eq!(cubes(8, 8, 16).exact_precision().unwrap(), Precision::Single);
    }

    #[test]
    fn the_bound_covers_the_errors_measured_on_solid_cubes() {
        // Padded side, solid side, largest error of f32 and of f64 against the exact counts.
        for (n, side, single, double) in
            [(64, 32, 4.9e-3, 7.3e-12), (128, 64, 6.3e-2, 1.2e-10), (256, 128, 0.625, 9.3e-10)]
        {
            assert!(cubes(side, side, n).bound(Precision::Single) > single);
            assert!(cubes(side, side, n).bound(Precision::Double) > double);
        }
    }

    #[test]
    fn large_solids_go_from_double_to_integers_to_a_refusal() {
        assert_eq!(cubes(512, 512, 1024).exact_precision().unwrap(), Precision::Double);
        assert_eq!(cubes(1200, 1200, 2400).exact_precision().unwrap(), Precision::Modular);
        assert!(matches!(cubes(1300, 1300, 2600).exact_precision(), Err(Error::PrecisionLost { .. })));
    }
}
