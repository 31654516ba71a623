//! A part cast onto a grid: what is certainly inside, what is inside at the samples, what is touched, and how full.

use crate::error::{Error, Result};
use crate::field::{Density, Indicator};
use crate::geometry::vector::Vec3;

/// How inside is told from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InsideRule {
    /// Sum of signed surface crossings along a row: exact, for surfaces without boundary whose facets agree in winding.
    #[default]
    Crossings,
    /// Generalized winding number of at least one half: for surfaces with holes, flipped facets or loose sheets.
    Winding,
}

/// Where a winding number does not tell inside from outside clearly, among the samples whose cubes no facet touches: the
/// touched ones are in `outer` and not in `inner`, whatever the number says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Doubt {
    /// Samples in doubt over those and the ones inside, in `[0, 1]`: the winding number lies within ¼ of one half.
    pub share: f64,
    /// Volume of the samples in doubt, mm³.
    pub volume_mm3: f64,
    /// Box of the samples in doubt; a point if there are none.
    pub extent: (Vec3, Vec3),
    /// The evaluated place whose winding number is nearest to one half, millimetres.
    pub at_mm: [f64; 3],
    /// The winding number there.
    pub winding: f64,
}

impl Doubt {
    /// The share in percent, to hundredths, upwards: what is there is not said to be none.
    pub fn percent(&self) -> f64 {
        (1e4 * self.share).ceil() / 100.0
    }
}

/// A solid S on a grid, with Q the closed cube of a sample and c its centre.
///
/// * `inner` = { Q ⊂ S }: cubes that no facet touches and whose centre is inside;
/// * `centres` = { c ∈ S };
/// * `outer` = { Q ∩ S ≠ ∅ }: `centres` and every cube that a facet touches;
/// * `density` = vol(Q ∩ S) / vol Q.
///
/// Always `inner ⊆ centres ⊆ outer`, and the union of the cubes of `inner` lies in S, which lies in the union of the
/// cubes of `outer` (as far as S lies on the grid). An increasing operator applied to both ends keeps the sandwich.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Cubes wholly inside.
    pub inner: Indicator,
    /// Samples inside.
    pub centres: Indicator,
    /// Cubes touched.
    pub outer: Indicator,
    /// Solid fraction of each cube.
    pub density: Density,
    /// What the winding number left in doubt; `None` where crossings decided.
    pub doubt: Option<Doubt>,
}

/// The three sets of a [`Solid`] without its density, for lattices too large for a number a sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Enclosure {
    /// Cubes wholly inside.
    pub inner: Indicator,
    /// Samples inside.
    pub centres: Indicator,
    /// Cubes touched.
    pub outer: Indicator,
}

impl Solid {
    /// Checks the invariants, cheap to dear: one grid; `inner ⊆ centres ⊆ outer`; densities in `[0, 1]`, 1 on
    /// `inner`, 0 off `outer`.
    ///
    /// # Errors
    /// [`Error::Operand`] naming the first that is broken.
    pub fn validate(&self) -> Result<()> {
        let bad = |problem: String| Error::Operand {
            operation: "solid",
            problem,
            remedy: "cast the part again; the three sets and the density belong to one grid".into(),
        };
        if !self.inner.is_subset(&self.centres)? || !self.centres.is_subset(&self.outer)? {
            return Err(bad("inner, centres and outer are not nested".into()));
        }
        self.density.validate()?;
        if self.density.field().grid() != self.centres.grid() {
            return Err(bad("the density stands on another grid".into()));
        }
        let values = self.density.field().values();
        let [nx, _, _] = self.centres.grid().dims();
        let wpr = self.centres.words_per_row();
        let rows = values.chunks(nx).zip(self.inner.words().chunks(wpr)).zip(self.outer.words().chunks(wpr));
        for (row, ((values, inner), outer)) in rows.enumerate() {
            for (i, &value) in values.iter().enumerate() {
                let is = |bits: &[u64]| bits[i / 64] >> (i % 64) & 1 == 1;
                if (is(inner) && value != 1.0) || (!is(outer) && value != 0.0) {
                    return Err(bad(format!("density {value} at sample {i} of row {row} contradicts the sets")));
                }
            }
        }
        Ok(())
    }
}
