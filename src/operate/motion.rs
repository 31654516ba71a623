//! What a body covers while it moves and turns.

use super::shape::{Element, Operated, checked, from_sandwich};
use crate::error::{Error, Result};
use crate::geometry::vector::hull;
use crate::geometry::{TriangleMesh, Waypoint};
use crate::grid::Grid;
use crate::morphology::{Placement, Sandwich, placements_along, sweep_poses};
use crate::units::Length;

/// Where samples stand about the box of the motion, in spacings.
const BETWEEN: [f64; 3] = [0.23, 0.31, 0.27];

/// What an element covers from pose to pose, going straight and turning evenly the shorter way about its own origin: the
/// samples of copies no farther apart than half a spacing, and a certified bracket.
///
/// # Errors
/// As [`placements_along`] and [`super::sweep`].
///
/// # Cost
/// One cast of the element for each copy.
pub fn sweep_motion(element: &Element, waypoints: &[Waypoint], spacing: Length) -> Result<Operated> {
    let mesh = element.faceted(spacing)?;
    let placements = placements_along(&mesh, waypoints, spacing)?;
    let (lo, hi) = box_of(&mesh, &placements)?;
    let grid = Grid::covering(lo, hi, spacing, 2, BETWEEN)?;
    let found = sweep_poses(&mesh, &placements, &grid)?;
    let same = Sandwich { upper: found.lower.clone(), paths: Vec::new(), ..found };
    let path = format!("{} copies on the way, sample by sample", placements.len());
    checked("sweep", Operated { path, ..from_sandwich(same)? })
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
    use crate::geometry::Primitive;
    use std::f64::consts::PI;

    #[test]
    fn a_bar_turned_once_covers_a_disk() {
        let bar = Element::BuiltIn(Primitive::parse("box:8x1x1mm").unwrap());
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turns = [[1.0, 0.0, 0.0, 0.0], [half, 0.0, 0.0, half], [0.0, 0.0, 0.0, 1.0]];
        let way = turns.map(|turn| Waypoint { at_mm: [10.0, 0.0, 0.0], turn });
        let made = sweep_motion(&bar, &way, Length::mm(0.2)).unwrap();
        let (disk, [low, high]) = (PI * (16.0 + 0.25), made.bracket.map(|v| v.as_mm3()));
        assert!(low < disk && disk < high, "{disk}: {low} … {high}");
        assert!((made.volume.as_mm3() / disk - 1.0).abs() < 0.03, "{:?} {disk}", made.volume);
        assert!(matches!(sweep_motion(&bar, &way[..1], Length::mm(0.2)), Err(Error::Operand { .. })));
    }
}
