//! Closed shells that hold no volume.

use super::{Health, Role};
use crate::geometry::TriangleMesh;

/// A closed mesh without its shells that hold no volume, if there are such and others remain.
///
/// What a slicer fills is the same with and without them; their box is not.
pub fn without_ghosts(mesh: &TriangleMesh, health: &Health) -> Option<TriangleMesh> {
    let ghosts = health.count_of(Role::Ghost);
    if ghosts == 0 || ghosts == health.shells.len() as u64 || !health.is_solid() {
        return None;
    }
    let role = |f: usize| {
        let shell = health.facet_shell.get(f).and_then(|&s| health.shells.get(s as usize));
        shell.map(|shell| shell.role)
    };
    let kept = (0..mesh.triangles.len()).filter(|&f| role(f) != Some(Role::Ghost));
    Some(TriangleMesh::weld(kept.map(|f| mesh.corners(f))).in_order())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn a_sheet_beside_a_box_is_left_out_and_one_for_itself_is_not() {
        let block = cuboid([0.0; 3], [1.0, 2.0, 3.0]).in_order();
        let sheet = TriangleMesh {
            vertices: vec![[0.0, 0.0, -9.0], [1.0, 0.0, -9.0], [0.0, 1.0, -9.0]],
            triangles: vec![[0, 1, 2], [0, 2, 1]],
        };
        let both = block.clone().joined(&sheet);
        assert_eq!(without_ghosts(&both, &Health::of(&both)), Some(block.clone()));
        for alone in [block, sheet] {
            assert_eq!(without_ghosts(&alone, &Health::of(&alone)), None);
        }
    }
}
