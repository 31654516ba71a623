//! What prints without support although it hangs over.

use super::bridge::Ceiling;

/// What prints without support although it hangs over; `None` where the process does not say.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SelfHolding {
    /// Longest bridge between anchors.
    pub bridge_mm: Option<f64>,
    /// Farthest ledge from an anchor.
    pub ledge_mm: Option<f64>,
    /// Widest round passage across the build direction.
    pub crown_mm: Option<f64>,
}

impl SelfHolding {
    /// Whether a ceiling holds itself for certain, as a bridge, the crown of a lying hole, or a ledge.
    pub fn holds(&self, ceiling: &Ceiling) -> bool {
        let within = |high: f64, limit: Option<f64>| limit.is_some_and(|l| high <= l + ceiling.tie_mm);
        match (ceiling.cantilever, ceiling.bridge, ceiling.crown) {
            (Some(_), _, _) => false,
            (None, None, _) => self.ledge_mm.is_some(),
            (None, Some(_), Some(c)) => within(c.diameter_mm - c.sagitta_mm, self.crown_mm),
            (None, Some(b), None) => ceiling.is_level && within(b.high_mm, self.bridge_mm),
        }
    }

    /// Whether it does not for certain: what was measured of it already is too much.
    pub fn gives_way(&self, ceiling: &Ceiling) -> bool {
        let beyond = |low: f64, limit: Option<f64>| limit.is_none_or(|l| low > l + ceiling.tie_mm);
        match (ceiling.cantilever, ceiling.bridge, ceiling.crown) {
            (Some(reach), _, _) => reach.low_mm > 0.0,
            (None, None, _) => self.ledge_mm.is_none(),
            (None, Some(_), Some(c)) => beyond(c.diameter_mm - c.sagitta_mm, self.crown_mm),
            (None, Some(b), None) => !ceiling.is_level || beyond(b.low_mm, self.bridge_mm),
        }
    }
}
