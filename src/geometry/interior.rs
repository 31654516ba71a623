//! A point within a solid, however thin.

use super::distance::MeshDistance;
use super::mesh::TriangleMesh;
use super::vector::{Vec3, add, along, norm2, scale};

/// Where on its largest facet a chord starts: off the middle, where corners of a faceted shape meet.
const WEIGHTS: [f64; 3] = [0.23, 0.32, 0.45];

/// A chord is at least this long beside the farthest corner: shorter ones are rounding.
const LEAST: f64 = 1e-12;

/// A point within the solid that a mesh bounds, wound outwards: the middle of the chord inwards from its largest facet; `None` if that
/// has no area or nothing lies behind it.
///
/// # Cost
/// O(facets): a tree over them.
pub fn interior_point(mesh: &TriangleMesh) -> Option<Vec3> {
    let area2 = |&f: &usize| norm2(mesh.area_vector(f));
    let largest = (0..mesh.triangles.len()).max_by(|f, g| area2(f).total_cmp(&area2(g)).then(g.cmp(f)))?;
    if area2(&largest) == 0.0 {
        return None;
    }
    let corners = mesh.corners(largest);
    let from = corners.iter().zip(WEIGHTS).fold([0.0; 3], |sum, (&p, w)| add(sum, scale(p, w)));
    let inwards = scale(mesh.normal(largest), -1.0);
    let farthest = mesh.vertices.iter().map(|&p| norm2(p)).fold(0.0, f64::max).sqrt();
    let (far, _) = MeshDistance::new(mesh).first_hit(from, inwards, LEAST * farthest, f64::INFINITY)?;
    Some(along(from, inwards, 0.5 * far))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Primitive, Winding, cuboid};
    use crate::units::Length;

    #[test]
    fn the_point_is_within_thin_plates_rods_and_hollow_bodies() {
        let hollow = cuboid([0.0; 3], [4.0; 3]).joined(&cuboid([0.1; 3], [3.9; 3]).flipped());
        let ring = Primitive::parse("cylinder:r3h0.01mm").unwrap().mesh(Length::mm(0.01));
        let turned = cuboid([0.0; 3], [3.0, 2.0, 1e-4])
            .transformed([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]], [100.0, -20.0, 3.0]);
        for mesh in [hollow, ring, turned, cuboid([5.0; 3], [5.001, 9.0, 5.001])] {
            let p = interior_point(&mesh).unwrap();
            // Winding numbers are to a few thousandths.
            assert!((Winding::new(&mesh).at(p) - 1.0).abs() < 0.05, "{p:?}");
        }
    }

    #[test]
    fn there_is_none_in_a_sheet_or_in_nothing() {
        let sheet =
            TriangleMesh { vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], triangles: vec![[0, 1, 2]] };
        assert_eq!(interior_point(&sheet), None);
        assert_eq!(interior_point(&TriangleMesh::default()), None);
        let needle = TriangleMesh { vertices: vec![[0.0; 3]; 3], triangles: vec![[0, 1, 2]] };
        assert_eq!(interior_point(&needle), None);
    }
}
