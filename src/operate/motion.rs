//! What a body covers while it moves and turns.

use super::element::Element;
use super::operated::Operated;
use super::shape::{checked, from_sandwich, with_surface};
use super::whole::Whole;
use crate::error::{Error, Result};
use crate::geometry::vector::hull;
use crate::geometry::{TriangleMesh, Waypoint};
use crate::grid::Grid;
use crate::morphology::{Placement, Sandwich, between_copies, copies, motion_surface, placements_along};
use crate::units::Length;

/// Where samples stand about the box of the motion, in spacings.
const BETWEEN: [f64; 3] = [0.23, 0.31, 0.27];

/// What an element covers from pose to pose, going straight and turning evenly the shorter way about its own origin: the
/// surface of exact distances to it on its way, and a certified bracket from copies no farther apart than half a spacing.
///
/// Faces lie where they are at any phase of the lattice, curved faces of a built-in element inscribed by a hundredth of the spacing. An
/// element whose facets bound more or less than a solid gets the surface of the samples that copies hold, up to half a spacing off, and
/// the path says so.
///
/// # Errors
/// As [`placements_along`] and [`super::sweep`].
///
/// # Cost
/// One cast of the element for each copy, and the surface, as [`motion_surface`] has it.
pub fn sweep_motion(element: &Element, waypoints: &[Waypoint], spacing: Length) -> Result<Operated> {
    let mesh = element.faceted(spacing)?;
    let placements = placements_along(&mesh, waypoints, spacing)?;
    let whole = Whole::of(&mesh);
    let (lo, hi) = box_of(&whole.mesh, &placements)?;
    let grid = Grid::covering(lo, hi, spacing, 2, BETWEEN)?;
    let copies = copies(&whole.mesh, &placements, &grid)?;
    let found = between_copies(&copies)?;
    let count = placements.len();
    if !whole.bounding {
        let same = Sandwich { upper: found.lower.clone(), paths: Vec::new(), ..found };
        let path = format!("{count} copies on the way, sample by sample");
        return checked("sweep", Operated { path, ..from_sandwich(same)? });
    }
    let (mesh, inside) = motion_surface(&whole.mesh, waypoints, &copies)?;
    let path = whole.path(format!("exact distances on the way, certified by {count} copies"));
    checked("sweep", with_surface(found, mesh, inside, path))
}

/// The box of all copies.
fn box_of(mesh: &TriangleMesh, placements: &[Placement]) -> Result<([f64; 3], [f64; 3])> {
    let boxes = placements.iter().filter_map(|p| mesh.transformed(p.rotation, p.translation).bounds());
    boxes.reduce(hull).ok_or_else(|| Error::NoGeometry {
        problem: "the mesh has no facets".into(),
        remedy: "give a closed mesh".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Primitive, cuboid};
    use std::f64::consts::PI;

    const AHEAD: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

    /// A box of 10 × 2 × 4 mm beside its origin.
    fn arm() -> Element {
        Element::Mesh(cuboid([5.0, -1.0, 0.0], [15.0, 1.0, 4.0]))
    }

    fn way<const N: usize>(poses: [([f64; 3], [f64; 4]); N]) -> [Waypoint; N] {
        poses.map(|(at_mm, turn)| Waypoint { at_mm, turn })
    }

    /// Once about z through the origin, in quarters.
    fn whole_turn() -> [Waypoint; 5] {
        let quarter = |n: i32| (0.25 * PI * f64::from(n)).sin_cos();
        way([0, 1, 2, 3, 4].map(|n| ([0.0; 3], [quarter(n).1, 0.0, 0.0, quarter(n).0])))
    }

    /// Checks a surface against a volume, to a share of it, and a box, to a twentieth of the spacing.
    fn lies(made: &Operated, (volume, share): (f64, f64), (lo, hi): ([f64; 3], [f64; 3]), h: f64) {
        let [low, high] = made.bracket.map(|v| v.as_mm3());
        assert!(low < volume && volume < high, "{volume} not in {low} … {high}");
        assert!((made.volume.as_mm3() / volume - 1.0).abs() < share, "{h}: {:?} for {volume}", made.volume);
        let found = made.mesh.bounds().unwrap();
        let off = (0..3).map(|a| (found.0[a] - lo[a]).abs().max((found.1[a] - hi[a]).abs())).fold(0.0, f64::max);
        assert!(off < 0.05 * h, "{h}: {off} off, {found:?}");
    }

    #[test]
    fn what_goes_straight_lies_where_it_is_at_any_spacing() {
        for h in [0.5, 0.3212, 0.25] {
            let made =
                sweep_motion(&arm(), &way([([0.0; 3], AHEAD), ([10.0, 0.0, 0.0], AHEAD)]), Length::mm(h)).unwrap();
            lies(&made, (160.0, 0.0005), ([5.0, -1.0, 0.0], [25.0, 1.0, 4.0]), h);
            // Askew: four of the faces are those that edges go along.
            let made =
                sweep_motion(&arm(), &way([([0.0; 3], AHEAD), ([7.0, 5.0, 3.0], AHEAD)]), Length::mm(h)).unwrap();
            lies(&made, (396.0, 0.002), ([5.0, -1.0, 0.0], [22.0, 6.0, 7.0]), h);
            assert!(made.path.starts_with("exact distances on the way") && made.crossings().count == 0);
        }
    }

    #[test]
    fn a_whole_turn_is_a_ring_and_a_turn_about_a_side_a_fan() {
        let h = 0.5;
        let made = sweep_motion(&arm(), &whole_turn(), Length::mm(h)).unwrap();
        let far = 15f64.hypot(1.0);
        lies(&made, (PI * (226.0 - 25.0) * 4.0, 0.002), ([-far, -far, 0.0], [far, far, 4.0]), h);
        let field = made.field().unwrap();
        let at = |p: [f64; 3]| field.at(field.grid().continuous_index(p).map(|x| x.round() as isize));
        assert!(at([10.0, 0.0, 2.0]) < 0.0 && at([0.0, 0.0, 2.0]) > 0.0);
    }

    #[test]
    fn near_the_axis_and_for_facets_that_bound_no_solid_it_is_right_too() {
        // A hole of 0.4 mm about the axis of what turns, far from its ends.
        let h = 0.1;
        let bar = cuboid([0.4, -0.3, 0.0], [6.0, 0.3, 1.0]);
        let turn = whole_turn();
        let made = sweep_motion(&Element::Mesh(bar.clone()), &turn, Length::mm(h)).unwrap();
        let far = 6f64.hypot(0.3);
        lies(&made, (PI * (36.09 - 0.16), 0.002), ([-far, -far, 0.0], [far, far, 1.0]), h);
        let hole = made.mesh.vertices.iter().map(|p| p[0].hypot(p[1])).fold(f64::INFINITY, f64::min);
        assert!((hole - 0.4).abs() < 0.05 * h, "{hole}");
        let inverted = sweep_motion(&Element::Mesh(bar.flipped()), &turn, Length::mm(h));
        assert!(inverted.is_err() || inverted.is_ok_and(|made| made.path.ends_with("sample by sample")));
        // Two bodies that overlap are one.
        let both = cuboid([5.0, -1.0, 0.0], [11.0, 1.0, 4.0]).joined(&cuboid([9.0, -1.0, 0.0], [15.0, 1.0, 4.0]));
        let made =
            sweep_motion(&Element::Mesh(both), &way([([0.0; 3], AHEAD), ([10.0, 0.0, 0.0], AHEAD)]), Length::mm(0.5))
                .unwrap();
        lies(&made, (160.0, 0.0005), ([5.0, -1.0, 0.0], [25.0, 1.0, 4.0]), 0.5);
        // The same turn, told twice.
        let still = way([([0.0; 3], AHEAD), ([0.0; 3], AHEAD.map(|x| -x))]);
        let made = sweep_motion(&arm(), &still, Length::mm(0.5)).unwrap();
        lies(&made, (80.0, 0.0005), ([5.0, -1.0, 0.0], [15.0, 1.0, 4.0]), 0.5);
    }

    #[test]
    fn a_bar_turned_once_covers_a_disk() {
        let bar = Element::BuiltIn(Primitive::parse("box:8x1x1mm").unwrap());
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turns = [[1.0, 0.0, 0.0, 0.0], [half, 0.0, 0.0, half], [0.0, 0.0, 0.0, 1.0]];
        let way = turns.map(|turn| Waypoint { at_mm: [10.0, 0.0, 0.0], turn });
        let made = sweep_motion(&bar, &way, Length::mm(0.2)).unwrap();
        let (disk, [low, high]) = (PI * (16.0 + 0.25), made.bracket.map(|v| v.as_mm3()));
        assert!(low < disk && disk < high, "{disk}: {low} … {high}");
        assert!((made.volume.as_mm3() / disk - 1.0).abs() < 0.002, "{:?} {disk}", made.volume);
        assert!(matches!(sweep_motion(&bar, &way[..1], Length::mm(0.2)), Err(Error::Operand { .. })));
    }
}
