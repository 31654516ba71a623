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

/// Facets that need support, in increasing order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Unheld {
    /// Those of all ceilings that do not hold themselves for certain.
    pub facets: Vec<u32>,
    /// Those of ceilings that give way for certain; of the others it is open.
    pub sure: Vec<u32>,
}

impl Unheld {
    /// Those of which it is open, in increasing order.
    pub fn open(&self) -> Vec<u32> {
        self.facets.iter().copied().filter(|f| self.sure.binary_search(f).is_err()).collect()
    }

    /// Whether all of it gives way for certain.
    pub fn is_told(&self) -> bool {
        self.sure.len() == self.facets.len()
    }
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

    /// What of ceilings needs support.
    pub fn unheld(&self, ceilings: &[Ceiling]) -> Unheld {
        let of = |falls: &dyn Fn(&Ceiling) -> bool| {
            let mut facets: Vec<u32> = ceilings.iter().filter(|c| falls(c)).flat_map(|c| c.facets.clone()).collect();
            facets.sort_unstable();
            facets
        };
        Unheld { facets: of(&|c| !self.holds(c)), sure: of(&|c| self.gives_way(c)) }
    }

    /// Whether it is open if a ceiling holds itself.
    pub fn is_open(&self, ceiling: &Ceiling) -> bool {
        !self.holds(ceiling) && !self.gives_way(ceiling)
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
