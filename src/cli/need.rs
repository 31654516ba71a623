//! What an operation takes: its samples, and the surface that is drawn through them.

use crate::error::{Error, Result};
use crate::geometry::vector::Vec3;
use crate::geometry::{Steiner, TriangleMesh};
use crate::grid::Fitting;
use crate::units::{Length, short};

/// Bytes for a facet of a result, with what it is made from: 1,728 cubes offset by a spacing are 5.5 million facets and take 95 each.
const BYTES_PER_FACET: f64 = 100.0;

/// Facets of a surface for a square of a spacing: two for each edge of the lattice that crosses it, and at most √3 of those.
const FACETS_PER_SQUARE: f64 = 3.5;

/// A round is cut twice below the one radius, once below the other, in spacings: where chords of a spacing, or of half of it, lie deeper than
/// three thousandths of it.
const CUT: [f64; 2] = [10.5, 42.0];

/// How far a result may grow beyond the part, and what of its surface is cut finer than the lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Growth {
    /// By as much, millimetres, with rounds that are cut until they are smooth.
    Rounded(f64),
    /// By as much, with a facet or two in each cell of the lattice.
    Plain(f64),
}

/// The surface of a part that grows.
pub struct Surface {
    part: Steiner,
    growth: Growth,
}

impl Surface {
    /// Of a part's mesh.
    pub fn of(part: &TriangleMesh, growth: Growth) -> Self {
        Surface { part: Steiner::of(part), growth }
    }

    /// Facets at a spacing: an estimate from above.
    fn facets(&self, spacing: Length) -> f64 {
        let h = spacing.as_mm();
        let (by, finer) = match self.growth {
            Growth::Plain(by) => (by, 1.0),
            Growth::Rounded(by) if by <= CUT[0] * h => (by, 8.0),
            Growth::Rounded(by) if by <= CUT[1] * h => (by, 3.0),
            Growth::Rounded(by) => (by, 1.0),
        };
        FACETS_PER_SQUARE / (h * h) * (self.part.area_mm2 + finer * self.part.rounded_mm2(by))
    }

    /// Refuses what takes more than is allowed: a box at a spacing, at so many bytes for each sample, and the surface in it.
    ///
    /// # Errors
    /// [`Error::TooLarge`] with a spacing that fits.
    pub fn admit(&self, extent: Vec3, spacing: Length, bytes_per_sample: u128, allowed_bytes: u128) -> Result<()> {
        let need = |spacing: Length| {
            let samples = Fitting::of(extent, spacing).samples.saturating_mul(bytes_per_sample);
            samples.saturating_add((self.facets(spacing) * BYTES_PER_FACET) as u128)
        };
        if need(spacing) <= allowed_bytes {
            return Ok(());
        }
        let coarser = std::iter::successors(Some(spacing), |h| Some(*h * 1.02)).take_while(|h| h.as_mm() < 1e12);
        let fits = coarser.into_iter().find(|&h| need(h) <= allowed_bytes);
        let what = format!(
            "a grid of {} samples with a surface of some {} facets at {spacing}",
            Fitting::of(extent, spacing).samples,
            short(self.facets(spacing).min(1e18).round())
        );
        let remedy = match fits {
            Some(h) => {
                format!("--voxel {}mm fits, or allow more with --memory", short((h.as_mm() * 1e3).ceil() / 1e3))
            }
            None => "allow more with --memory".into(),
        };
        Err(Error::TooLarge { what, need_bytes: need(spacing), allowed_bytes, remedy })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::operate::offset;

    #[test]
    fn the_surface_is_no_larger_than_it_is_taken_to_be_and_not_much_smaller() {
        let cubes = (0..8).map(|n| [n & 1, n >> 1 & 1, n >> 2].map(f64::from));
        let cubes = cubes.map(|at| cuboid(at, at.map(|x| x + 0.5))).reduce(|a, b| a.joined(&b)).unwrap();
        let block = cuboid([0.0; 3], [8.0, 6.0, 4.0]);
        for (part, by, h) in [(&cubes, 0.1, 0.1), (&cubes, 0.2, 0.05), (&block, 1.0, 0.2), (&block, 0.0, 0.2)] {
            let made = offset(part, Length::mm(by), Length::mm(h)).unwrap().mesh.triangles.len() as f64;
            let told = Surface::of(part, Growth::Rounded(by)).facets(Length::mm(h));
            assert!(made <= told && told < 5.0 * made, "{by} at {h}: {made} of {told}");
        }
    }

    #[test]
    fn a_spacing_that_fits_is_told_and_fits() {
        let part = cuboid([0.0; 3], [8.0, 6.0, 4.0]);
        let (surface, extent) = (Surface::of(&part, Growth::Rounded(1.0)), [10.0, 8.0, 6.0]);
        let refused = surface.admit(extent, Length::mm(0.01), 24, 1 << 26);
        let Err(Error::TooLarge { remedy, .. }) = refused else { panic!("{refused:?}") };
        let fits = remedy.split_whitespace().nth(1).unwrap();
        surface.admit(extent, Length::parse(fits).unwrap(), 24, 1 << 26).expect(&remedy);
    }
}
