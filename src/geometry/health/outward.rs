//! The mesh with its normals out of the material.

use super::{Health, Role};
use crate::geometry::TriangleMesh;
use std::borrow::Cow;

impl Health {
    /// The mesh this is the health of, with every shell wound the way its role wants: bodies outward, cavities
    /// inward. Shells that do not close are turned only where the whole mesh is inside out.
    ///
    /// Facets keep their order and vertices, so that all labels of this health stay valid. A mesh that is
    /// already right is returned as it is.
    pub fn outward<'m>(&self, mesh: &'m TriangleMesh) -> Cow<'m, TriangleMesh> {
        let turned: Vec<bool> = self
            .shells
            .iter()
            .map(|shell| match shell.role {
                Role::Ghost => false,
                Role::Open => self.inverted,
                Role::Cavity => shell.volume_mm3 > 0.0,
                Role::Body | Role::Inverted | Role::Swallowed => shell.volume_mm3 < 0.0,
            })
            .collect();
        if !turned.contains(&true) {
            return Cow::Borrowed(mesh);
        }
        let mut out = mesh.clone();
        for (triangle, &shell) in out.triangles.iter_mut().zip(&self.facet_shell) {
            if turned.get(shell as usize).is_some_and(|&t| t) {
                triangle.swap(1, 2);
            }
        }
        Cow::Owned(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::Vec3;

    fn cube(centre: Vec3, edge: f64) -> TriangleMesh {
        let corner = |i: usize| [0, 1, 2].map(|a| centre[a] + if i >> a & 1 == 1 { 0.5 * edge } else { -0.5 * edge });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        TriangleMesh::weld(quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|t| t.map(corner)))
    }

    #[test]
    fn every_way_of_being_inside_out_is_put_right() {
        let (outer, inner, beside) = (cube([0.0; 3], 4.0), cube([0.0; 3], 2.0), cube([9.0, 0.0, 0.0], 1.0));
        let right = outer.clone().joined(&inner.flipped()).joined(&beside);
        assert!(matches!(Health::of(&right).outward(&right), Cow::Borrowed(_)));
        for wrong in [
            right.flipped(),
            outer.clone().joined(&inner.flipped()).joined(&beside.flipped()),
            outer.flipped().joined(&inner).joined(&beside),
            outer.flipped().joined(&inner.flipped()).joined(&beside),
        ] {
            let health = Health::of(&wrong);
            let mended = health.outward(&wrong);
            let again = Health::of(&mended);
            assert_eq!((again.volume_mm3(), again.count_of(Role::Cavity)), (57.0, 1));
            // Rounding of 36 sixths.
            assert!((mended.signed_volume() - 57.0).abs() < 1e-12);
            assert!(matches!(again.outward(&mended), Cow::Borrowed(_)));
        }
    }
}
