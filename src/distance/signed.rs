//! Signed distance in millimetres from a set of samples.

use super::squared::{FAR, Side, transform};
use crate::error::Result;
use crate::field::{Field, Indicator, SignedDistance};

/// Signed distance to the boundary between the samples of a set and the others, negative inside, millimetres.
///
/// With d the distance from a sample to the nearest sample of the other class, centre to centre, the value is
/// ±(d − h/2): the boundary is taken to lie half a sample from the centres on either side of it, which is exact where
/// it is a plane of cube faces. To the faces of the set's cubes the true distance lies in [d − √3·h/2, d − h/2] outside
/// the set and, by the complement, inside; to the solid that was sampled there is no bound from the samples alone.
///
/// Everything beyond the grid is outside. The value is `f32::MAX` where the set is [`super::REACH`] spacings away or more, or empty; so is the
/// background.
///
/// # Errors
/// As [`super::squared_distance`].
///
/// # Cost
/// O(N log n), four bytes a sample; the squared distances are exact integers until the last step.
///
/// ```
/// use amcheck::{distance::signed_distance, field::Indicator, grid::Grid, units::Length};
/// let grid = Grid::new([0.0; 3], Length::mm(0.2), [5, 1, 1])?;
/// let mut set = Indicator::empty(grid);
/// set.set([1, 0, 0], true);
/// assert_eq!(signed_distance(&set)?.field().values(), [0.1, -0.1, 0.1, 0.3, 0.5]);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn signed_distance(set: &Indicator) -> Result<SignedDistance> {
    let h = set.grid().h() as f32;
    let values = transform(set, Side::Both, move |d2, inside| {
        // By way of i32, which every machine turns into floats at once; the root of FAR is not used.
        let distance = ((d2 as i32 as f32).sqrt() - 0.5) * h;
        let distance = if d2 == FAR { f32::MAX } else { distance };
        if inside { -distance } else { distance }
    })?;
    SignedDistance::new(Field::from_values(*set.grid(), values, f32::MAX)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::units::Length;

    #[test]
    fn a_slab_is_half_as_deep_as_it_is_thick() {
        let grid = Grid::new([0.0; 3], Length::mm(0.5), [9, 20, 9]).unwrap();
        for thickness in 1..8usize {
            let slab = Indicator::from_predicate(grid, |at| (6..6 + thickness).contains(&grid.index(at)[1]));
            let field = signed_distance(&slab).unwrap();
            // Along the middle line the ends of the grid are farther than the faces.
            let deepest = (0..20).map(|j| field.field().at([4, j, 4])).fold(f32::MAX, f32::min);
            let expected = -0.5 * (thickness.div_ceil(2) as f32 - 0.5);
            assert!((deepest - expected).abs() < 1e-6, "{thickness}: {deepest}");
            assert_eq!(field.interior(), slab);
        }
        assert_eq!(signed_distance(&Indicator::empty(grid)).unwrap().field().at([0, 0, 0]), f32::MAX);
    }
}
