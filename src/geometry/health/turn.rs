//! Shells that are wound inside out.

use super::{Health, Role};
use crate::geometry::TriangleMesh;

/// Turns the shells that are wound inside out.
pub fn turn_shells(mesh: &mut TriangleMesh, health: &Health) {
    for (t, &shell) in mesh.triangles.iter_mut().zip(&health.facet_shell) {
        let inverted = health.shells.get(shell as usize).is_some_and(|s| s.role == Role::Inverted);
        if health.inverted || inverted {
            t.swap(1, 2);
        }
    }
}
