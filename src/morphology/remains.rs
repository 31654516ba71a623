//! What an offset leaves that is thinner than the samples.

use super::element::StructuringElement;
use super::minkowski::dilate;
use super::press::nearest_place;
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::vector::{Vec3, compare};
use crate::geometry::{MeshDistance, TriangleMesh, Winding};
use crate::units::Length;
use rayon::prelude::*;

/// By so much more than it is offset, in spacings, a place has to be from the part: of a wall exactly as thick as what is taken off nothing is left.
const CLEAR: f64 = 0.02;

/// Samples nearer than this to what shows need no look.
const SHOWN: usize = 2;

/// A place that an exact offset leaves, farther than any other from the surface that was made of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remains {
    /// How far from the surface.
    pub beyond: Length,
    /// The place, millimetres.
    pub at_mm: Vec3,
}

/// What an inward offset leaves of a part, or an outward one of the gaps in it, farther from the surface `made` of it than two samples; `field`
/// are the distances that it was made of.
///
/// Looked for from the samples within a spacing of it, each by the nearest place of a ball of that radius.
///
/// # Errors
/// None on a grid that there is.
///
/// # Cost
/// A dilation of the samples; where some are left two distances to the part and a winding number for each, and a distance to the surface.
pub fn remains(part: &TriangleMesh, by: Length, made: &TriangleMesh, field: &Field<f32>) -> Result<Option<Remains>> {
    let (grid, h) = (*field.grid(), field.grid().h());
    let side = -by.as_mm().signum() as f32;
    let shown = Indicator::from_predicate(grid, |at| side * field.values()[at] <= 0.0);
    let cube = StructuringElement::cuboid([2 * SHOWN + 1; 3], grid.spacing())?;
    let near = dilate(&shown, &cube)?.set.placed([SHOWN as isize; 3], grid)?;
    let beside = Indicator::from_predicate(grid, |at| side * field.values()[at] <= h as f32).difference(&near)?;
    if by.as_mm() == 0.0 || beside.is_empty() {
        return Ok(None);
    }
    let (of_part, of_made, winding) = (MeshDistance::new(part), MeshDistance::new(made), Winding::new(part));
    let ball = by.as_mm() + CLEAR * h * by.as_mm().signum();
    // Past a sharp edge the ball may come to rest on the other side.
    let lies_in = |place: &Vec3| (winding.at(*place) > 0.5) == (by.as_mm() < 0.0);
    let place = |at: usize| nearest_place(&of_part, ball, grid.position(grid.index(at)), h).filter(lies_in);
    let beyond = |place: Vec3| of_made.nearest(place, f64::INFINITY).map(|n| (n.distance, place));
    let samples: Vec<usize> = beside.iter().collect();
    let found = samples.into_par_iter().filter_map(|at| beyond(place(at)?)).max_by(|a, b| {
        // The place settles ties, so that the order of the work does not.
        a.0.total_cmp(&b.0).then_with(|| compare(a.1, b.1))
    });
    Ok(found.map(|(distance, at_mm)| Remains { beyond: Length::mm(distance), at_mm }))
}

#[cfg(test)]
mod tests {
    use super::super::offset;
    use super::*;
    use crate::geometry::{cuboid, extruded};

    fn of(part: &TriangleMesh, by: f64, h: f64) -> (TriangleMesh, Option<Remains>) {
        let shape = offset(part, Length::mm(by), Length::mm(h)).unwrap();
        let found = remains(part, Length::mm(by), &shape.mesh, &shape.field).unwrap();
        (shape.mesh, found)
    }

    #[test]
    fn the_tip_that_is_left_of_a_wedge_is_told_and_so_is_the_end_of_a_notch() {
        let half = 6f64.to_radians();
        let (far, y) = (3.0 / half.sin(), 3.0 / half.cos());
        let wedge = extruded(&[[0.0, 0.0], [far, -y], [far, y]], &[[0, 1, 2]], 6.0);
        let back =
            [[-2.0, -y - 2.0], [far, -y - 2.0], [far, -y], [0.0, 0.0], [far, y], [far, y + 2.0], [-2.0, y + 2.0]];
        let block = extruded(&back, &[[0, 1, 3], [1, 2, 3], [3, 4, 5], [3, 5, 6], [0, 3, 6]], 6.0);
        let tip = 1.0 / half.sin();
        for h in [0.2, 0.3, 0.4] {
            for (part, by) in [(&wedge, -1.0), (&block, 1.0)] {
                let (made, found) = of(part, by, h);
                let found = found.expect("a tip");
                let mesh = MeshDistance::new(&made);
                let end = |y: f64| [tip + CLEAR * h / half.sin(), y, 0.0];
                let to_surface = |y: f64| mesh.nearest(end(y), f64::INFINITY).unwrap().distance;
                let between = |t: f64| 1.0 + CLEAR * h + t * (4.0 - 2.0 * CLEAR * h);
                let short_by = (0..=100).map(|n| to_surface(between(0.01 * f64::from(n)))).fold(0.0, f64::max);
                let beyond = found.beyond.as_mm();
                // The ends are looked at every 0.04 mm here, and where samples are there.
                assert!((beyond - short_by).abs() < 0.05 * h, "{by} {h}: {beyond} of {short_by}");
                assert!((found.at_mm[0] - tip).abs() < h && found.at_mm[2].abs() < 0.1 * h, "{found:?}");
            }
        }
    }

    #[test]
    fn nothing_is_told_of_what_shows_or_of_what_nothing_is_left_of() {
        let plate =
            |thick: f64| cuboid([0.0; 3], [6.0, 5.0, 4.0]).joined(&cuboid([8.0, 0.0, 0.0], [8.0 + thick, 5.0, 4.0]));
        for (part, by, told) in [(plate(2.0), -1.0, false), (plate(1.9), -1.0, false), (plate(2.05), -1.0, true)] {
            assert_eq!(of(&part, by, 0.3).1.is_some(), told, "{by}");
        }
        assert_eq!(of(&plate(3.0), 0.4, 0.3).1, None);
    }
}
