//! Openings and closings by any element: where the operands touch, twice.

use super::settled::{Settled, Touch};
use super::whole::Whole;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;
use crate::morphology::{Sandwich, Sides, StructuringElement, dilate, erode};
use crate::topology::{Adjacency, components};

/// How many samples off a place for the element may lie from those that the surface of all places holds: what the sides of the operands
/// leave open is no more at faces along the lattice.
const BESIDE: usize = 3;

/// The surface of a closing, and what it may fill too much.
pub(super) struct Closed {
    pub settled: Settled,
    /// Rooms for the element that the samples neither tell nor exclude, and that the surface fills: how many, and the middle of the element in one.
    pub filled: Option<(usize, Vec3)>,
}

/// The surface of a closing, that of the difference of the sum's own; `None` where either has none, or one that is not where the operands
/// touch all over.
///
/// What the sum's surface is off by comes back in the closing's: a thousandth of the spacing at the lattice, a third of it at creases. A room for the
/// element in which no sample tells of one is filled; [`Closed::filled`] counts those of which a sample farther than [`BESIDE`] from the outside of the sum's
/// surface may be one.
///
/// # Errors
/// As [`Touch::surface`].
///
/// # Cost
/// That of a sum, and of a difference of a mesh of as many facets as the sum has.
pub(super) fn closed(
    part: &TriangleMesh,
    element: &TriangleMesh,
    [a, b]: [&Sides; 2],
    found: &Sandwich,
) -> Result<Option<Closed>> {
    let Some(touch) = Touch::of_sum(part, element) else { return Ok(None) };
    let spacing = a.points.grid().spacing();
    let Some(sum) = whole(touch.surface(Sandwich::sides_of_sum(a, b)?.each_ref())?) else { return Ok(None) };
    let open = far_from(&Sandwich::rooms(a, b)?, &sum.inside.complement())?;
    // Samples from which a spacing in any direction is certainly in the result, so that what the sum's surface is off by does not
    // matter: a closing holds its part, as far as samples tell of it.
    let inner = erode(&found.lower, &StructuringElement::cuboid([3; 3], spacing)?)?.set;
    let certain = inner.placed([1; 3], *found.lower.grid())?.union(&a.full)?;
    let settled = whole(touch.back(&sum.mesh).surface([&certain, &found.upper])?);
    Ok(settled.map(|settled| Closed { settled, filled: rooms(&open, element) }))
}

/// How many pieces a set of places for a mirrored element has, and the middle of the element at one of them.
fn rooms(places: &Indicator, element: &TriangleMesh) -> Option<(usize, Vec3)> {
    let found = components(places, Adjacency::Corner);
    let at = places.grid().position(*found.first_samples().first()?);
    let (lo, hi) = element.bounds()?;
    Some((found.count(), [0, 1, 2].map(|n| at[n] - 0.5 * (lo[n] + hi[n]))))
}

/// The surface of an opening, that of the sum of the difference's own; `None` as for a closing, and where some place for the element may be
/// left out: the samples tell of one farther from the difference's surface than [`BESIDE`].
///
/// # Errors
/// As [`Touch::surface`].
///
/// # Cost
/// That of a difference, and of a sum of a mesh of as many facets as the difference has.
pub(super) fn opened(
    part: &Whole,
    element: &TriangleMesh,
    [a, b]: [&Sides; 2],
    found: &Sandwich,
) -> Result<Option<Settled>> {
    let Some(touch) = Touch::of_difference(part, element) else { return Ok(None) };
    let Some(places) = whole(touch.surface(Sandwich::sides_of_difference(a, b)?.each_ref())?) else { return Ok(None) };
    if !far_from(&Sandwich::places(a, b)?, &places.inside)?.is_empty() {
        return Ok(None);
    }
    Ok(whole(touch.back(&places.mesh).surface(found.sides())?))
}

/// The samples of a set that are farther than [`BESIDE`] from another set, which was sought two samples further.
fn far_from(possible: &Indicator, found: &Indicator) -> Result<Indicator> {
    let cube = StructuringElement::cuboid([2 * BESIDE + 1; 3], found.grid().spacing())?;
    possible.difference(&dilate(found, &cube)?.set.placed([BESIDE as isize + 2; 3], *possible.grid())?)
}

/// The surface, if all of it is where the operands touch.
fn whole(settled: Option<Settled>) -> Option<Settled> {
    settled.filter(|settled| settled.touching == settled.crossings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Primitive, cuboid, extruded};
    use crate::units::Length;

    const H: f64 = 0.2;

    fn sides(mesh: &TriangleMesh) -> Sides {
        Sides::of_mesh(mesh, Length::mm(H), [0.25; 3]).unwrap()
    }

    fn closing(part: &TriangleMesh, element: &TriangleMesh) -> Option<Closed> {
        let [a, b] = [sides(part), sides(element)];
        closed(part, element, [&a, &b], &Sandwich::closing(&a, &b).unwrap()).unwrap()
    }

    fn opening(part: &TriangleMesh, element: &TriangleMesh) -> Option<Settled> {
        let [a, b] = [sides(part), sides(element)];
        opened(&Whole::of(part), element, [&a, &b], &Sandwich::opening(&a, &b).unwrap()).unwrap()
    }

    /// A block of 6 × 4 × 3 mm with a slot in the middle of its top, 2 mm deep.
    fn slotted(wide: f64) -> TriangleMesh {
        let [p, q] = [3.0 - 0.5 * wide, 3.0 + 0.5 * wide];
        let outline = [[0.0, 0.0], [6.0, 0.0], [6.0, 4.0], [q, 4.0], [q, 2.0], [p, 2.0], [p, 4.0], [0.0, 4.0]];
        extruded(&outline, &[[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4], [0, 5, 6], [0, 6, 7]], 3.0)
    }

    #[test]
    fn a_closing_fills_the_slots_that_the_element_does_not_enter() {
        let element = cuboid([-0.5, 0.2, 0.0], [0.5, 1.2, 1.0]);
        // Faces along the lattice come back to a thousandth of a spacing, edges to a third: 40 mm of them, once at each step.
        let bar = 2.0 * 40.0 * (0.3 * H) * (0.3 * H);
        for (wide, volume) in [(0.7, 72.0), (1.6, 72.0 - 1.6 * 6.0)] {
            let found = closing(&slotted(wide), &element).expect("all of it where they touch");
            let (found, filled) = (found.settled.mesh.signed_volume(), found.filled);
            assert!((found - volume).abs() < bar && filled.is_none(), "{wide}: {found} for {volume}, {filled:?}");
        }
    }

    #[test]
    fn a_closing_tells_of_the_gaps_it_fills_that_are_about_as_wide_as_the_element() {
        // A void and a slot wider than the element by half a spacing or less, in which no sample tells of a room.
        let element = cuboid([-0.5, 0.2, 0.0], [0.5, 1.2, 1.0]);
        for wide in [1.02, 1.1, 1.2] {
            assert!(closing(&slotted(wide), &element).unwrap().filled.is_some(), "{wide}");
            let void = cuboid([2.0, 1.5, 1.0], [2.0 + wide, 1.5 + wide, 1.0 + wide]).flipped();
            let found = closing(&cuboid([0.0; 3], [6.0, 4.0, 4.0]).joined(&void), &element).unwrap();
            let (count, at) = found.filled.unwrap();
            let off = (0..3).map(|n| (at[n] - [2.0, 1.5, 1.0][n] - 0.5 * wide).abs()).fold(0.0, f64::max);
            assert!(count == 1 && off <= 2.0 * H, "{wide}: {count} {at:?}");
        }
    }

    #[test]
    fn an_opening_takes_the_fins_that_the_element_does_not_fit_into() {
        let element = cuboid([-0.7, 0.2, 0.0], [0.7, 1.2, 1.0]);
        let bar = 2.0 * 40.0 * (0.3 * H) * (0.3 * H);
        // Prongs 2.5 mm wide stay; prongs 0.5 mm wide go.
        for (wide, volume) in [(1.0, 72.0 - 6.0), (5.0, 36.0)] {
            let found = opening(&slotted(wide), &element).expect("all of it where they touch").mesh.signed_volume();
            assert!((found - volume).abs() < bar, "{wide}: {found} for {volume}");
        }
    }

    #[test]
    fn an_opening_is_none_where_a_wall_is_about_as_thick_as_the_element() {
        let element = cuboid([-0.7, 0.2, 0.0], [0.7, 1.2, 1.0]);
        // Prongs of 1.35 to 1.45 mm, where samples do not tell.
        for wide in [3.3, 3.2, 3.1] {
            assert!(opening(&slotted(wide), &element).is_none(), "{wide}");
        }
        let open = Primitive::parse("ball:1mm").unwrap().mesh(Length::mm(0.1));
        let open = TriangleMesh { triangles: open.triangles[1..].to_vec(), ..open };
        assert!(Touch::of_sum(&slotted(1.0), &open).is_none());
    }
}
