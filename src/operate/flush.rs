//! An opening whose surface is midway in the bracket, and the surface of its part, which most of it lies in.

use super::midway::widened;
use super::operated::Operated;
use super::whole::Whole;
use crate::error::Result;
use crate::geometry::contour::MEETING;
use crate::geometry::health::{Through, crossing_pairs};
use crate::geometry::vector::{along, sub};
use crate::geometry::{MeshDistance, TriangleMesh, occupancy};
use crate::units::Volume;
use rayon::prelude::*;

/// Spacings that a surface midway is off by at most where it follows a face: half the diagonal of a sample's cube.
const OFF: f64 = 0.866_025_403_784_438_6;
/// What is left of the way to the part's surface: so no two vertices become one at its edges and corners.
const LEFT: f64 = 0.01;
/// How often facets that cross are put back at most.
const ROUNDS: usize = 16;

/// An opening whose surface is midway, laid into that of its part wherever it is about there, and bounded by its volume: an opening holds nothing
/// that its part does not. As it is where the part's facets do not bound a solid.
///
/// # Errors
/// As [`occupancy`].
///
/// # Cost
/// A nearest facet for each vertex, the facets that cross, some times, and the samples in the new surface.
pub(super) fn laid_into(part: &Whole, opening: Operated) -> Result<Operated> {
    let Some([lower, upper]) = opening.sides.as_ref().filter(|_| part.bounding && opening.inside.is_none()) else {
        return Ok(opening);
    };
    let mesh = uncrossed(laid(&opening.mesh, part, lower.grid().h()), &opening.mesh, lower.grid().h());
    let ([low, high], volume) = (opening.bracket, Volume::mm3(mesh.signed_volume()));
    if volume.as_mm3() < low.as_mm3() {
        return Ok(opening);
    }
    let inside = occupancy(&mesh, widened(upper)?.grid())?;
    let most = Volume::mm3(part.mesh.signed_volume());
    let high = if (volume.as_mm3()..high.as_mm3()).contains(&most.as_mm3()) { most } else { high };
    Ok(Operated { mesh, volume, bracket: [low, high], inside: Some(inside), ..opening })
}

/// A mesh whose vertices near a part's surface lie in it, but for a hundredth of the way.
fn laid(mesh: &TriangleMesh, part: &Whole, spacing_mm: f64) -> TriangleMesh {
    let (surface, reach) = (MeshDistance::new(&part.mesh), OFF * spacing_mm);
    let laid = |&p: &[f64; 3]| surface.nearest(p, reach).map_or(p, |near| along(near.point, sub(p, near.point), LEFT));
    TriangleMesh { vertices: mesh.vertices.par_iter().map(laid).collect(), triangles: mesh.triangles.clone() }
}

/// A mesh with the vertices of facets that cross put back to where they were, until none cross or all of it is as it was.
fn uncrossed(mut mesh: TriangleMesh, before: &TriangleMesh, spacing_mm: f64) -> TriangleMesh {
    let facets: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    for _ in 0..ROUNDS {
        let pairs = crossing_pairs(&mesh, &facets, MEETING * spacing_mm, Through::Inside);
        if pairs.is_empty() {
            return mesh;
        }
        for v in pairs.into_iter().flatten().flat_map(|f| mesh.triangles[f as usize]) {
            mesh.vertices[v as usize] = before.vertices[v as usize];
        }
    }
    before.clone()
}

#[cfg(test)]
mod tests {
    use super::super::{Element, open};
    use crate::geometry::{Primitive, cuboid};
    use crate::units::Length;

    #[test]
    fn an_opening_midway_lies_in_the_faces_of_its_part() {
        // A fin as thick as the spacing, on a plate: no sample tells for certain that the element does not fit into it.
        let plate = cuboid([0.0; 3], [60.0, 24.0, 4.0]);
        let part = plate.joined(&cuboid([29.0, 0.0, 4.0], [29.45, 24.0, 14.0]));
        let element = Element::BuiltIn(Primitive::parse("box:1x1x1mm").unwrap());
        let made = open(&part, &element, Length::mm(0.46875)).unwrap();
        assert!(made.path.contains("surface midway in the bracket"), "{}", made.path);
        let [low, high] = made.bracket.map(|v| v.as_mm3());
        assert!(low < 5760.0 && 5760.0 < high && high <= 5760.0 + 108.0 + 1e-6, "{low} {high}");
        // Midway it was 430 mm³ off; the top of what is left of the fin is not the part's.
        assert!((made.volume.as_mm3() - 5760.0).abs() < 0.02 * 5760.0, "{:?}", made.volume);
        let (lo, hi) = made.mesh.bounds().unwrap();
        for a in 0..2 {
            assert!(lo[a].abs() < 0.005 && (hi[a] - [60.0, 24.0][a]).abs() < 0.005, "{lo:?} {hi:?}");
        }
        assert!(crate::geometry::Health::of(&made.mesh).is_watertight());
        assert_eq!(made.crossings().count, 0);
        // The field beside it vanishes there.
        let (field, exact) = (made.field().unwrap(), crate::geometry::MeshDistance::new(&made.mesh));
        let values = field.values().iter().zip(0..).filter(|(v, _)| v.abs() < 0.2);
        for (value, at) in values.step_by(97) {
            let p = field.grid().position(field.grid().index(at));
            let near = exact.nearest(p, 1.0).unwrap();
            assert!((near.distance - f64::from(value.abs())).abs() < 1e-4, "{p:?} {value}");
        }
    }
}
