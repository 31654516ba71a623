//! Signed distance to a boundary.

use super::{Field, Indicator};
use crate::error::{Error, Result};
use rayon::prelude::*;

/// Signed distance in millimetres, **negative inside**; the background is positive.
#[derive(Debug, Clone, PartialEq)]
pub struct SignedDistance(Field<f32>);

impl SignedDistance {
    /// Wraps a field of distances.
    ///
    /// # Errors
    /// [`Error::Operand`] if the background is not positive or a value is not finite.
    pub fn new(field: Field<f32>) -> Result<Self> {
        let distance = SignedDistance(field);
        distance.validate()?;
        Ok(distance)
    }

    /// Checks the invariants, cheap to dear: positive background; every value finite.
    ///
    /// # Errors
    /// [`Error::Operand`] naming the first value that breaks one.
    pub fn validate(&self) -> Result<()> {
        let bad = |problem: String| Error::Operand {
            operation: "signed distance",
            problem,
            remedy: "a signed distance is finite, negative inside and positive outside".into(),
        };
        if self.0.background().is_nan() || self.0.background() <= 0.0 {
            return Err(bad(format!("background is {}", self.0.background())));
        }
        let broken = |v: &f32| !v.is_finite();
        let sound = self.0.values().par_chunks(1 << 14).all(|chunk| chunk.iter().filter(|v| broken(v)).count() == 0);
        match (!sound).then(|| self.0.values().iter().position(broken)).flatten() {
            Some(at) => Err(bad(format!("value {} at sample {:?}", self.0.values()[at], self.0.grid().index(at)))),
            None => Ok(()),
        }
    }

    /// The field of distances.
    pub fn field(&self) -> &Field<f32> {
        &self.0
    }

    /// The sublevel set `{ d ≤ level }`: the solid offset outwards by `level` millimetres.
    pub fn at_most(&self, level: f32) -> Indicator {
        Indicator::from_predicate(*self.0.grid(), |at| self.0.values()[at] <= level)
    }

    /// The open sublevel set `{ d < 0 }`.
    pub fn interior(&self) -> Indicator {
        Indicator::from_predicate(*self.0.grid(), |at| self.0.values()[at] < 0.0)
    }
}
