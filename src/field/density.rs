//! The solid fraction of each sample's cube.

use super::{Field, Indicator};
use crate::error::{Error, Result};
use crate::units::Volume;
use rayon::prelude::*;

/// Solid fraction per sample, in `[0, 1]`: the mean of the indicator over the sample's cube.
///
/// The background is 0. Sums of a density are volumes without the sampling bias of an indicator.
#[derive(Debug, Clone, PartialEq)]
pub struct Density(Field<f32>);

impl Density {
    /// Wraps a field of fractions.
    ///
    /// # Errors
    /// [`Error::Operand`] if a value lies outside `[0, 1]` or the background is not 0.
    pub fn new(field: Field<f32>) -> Result<Self> {
        let density = Density(field);
        density.validate()?;
        Ok(density)
    }

    /// Checks the invariants, cheap to dear: background 0; every value finite and in `[0, 1]`.
    ///
    /// # Errors
    /// [`Error::Operand`] naming the first value that breaks one.
    pub fn validate(&self) -> Result<()> {
        let bad = |problem: String| Error::Operand {
            operation: "density",
            problem,
            remedy: "a density is a solid fraction between 0 and 1".into(),
        };
        if self.0.background() != 0.0 {
            return Err(bad(format!("background is {}", self.0.background())));
        }
        let broken = |v: &f32| !(0.0..=1.0).contains(v);
        let sound = self.0.values().par_chunks(1 << 14).all(|chunk| chunk.iter().filter(|v| broken(v)).count() == 0);
        match (!sound).then(|| self.0.values().iter().position(broken)).flatten() {
            Some(at) => Err(bad(format!("value {} at sample {:?}", self.0.values()[at], self.0.grid().index(at)))),
            None => Ok(()),
        }
    }

    /// The field of fractions.
    pub fn field(&self) -> &Field<f32> {
        &self.0
    }

    /// ∫ ρ dV, summed layer by layer in f64 so that the result does not depend on the number of threads.
    pub fn volume(&self) -> Volume {
        let [nx, ny, _] = self.0.grid().dims();
        let sum: f64 = self.0.values().chunks(nx * ny).map(|l| l.iter().map(|&v| f64::from(v)).sum::<f64>()).sum();
        self.0.grid().sample_volume() * sum
    }

    /// The superlevel set `{ ρ ≥ level }`.
    pub fn at_least(&self, level: f32) -> Indicator {
        Indicator::from_predicate(*self.0.grid(), |at| self.0.values()[at] >= level)
    }
}
