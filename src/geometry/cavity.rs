//! Cavities that the mesh itself bounds: closed shells around void, inside the material of a body.

use super::distance::MeshDistance;
use super::health::{Health, Role};
use super::mesh::TriangleMesh;
use super::vector::Vec3;
use super::winding::Winding;
use std::collections::BTreeMap;

/// A void that a closed shell of the mesh bounds.
#[derive(Debug, Clone)]
pub struct Cavity {
    /// The shell of [`Health::shells`].
    pub shell: u32,
    /// Volume of void, mm³: that of the shell without the bodies that lie loose in it.
    pub volume_mm3: f64,
    /// Least and greatest corner.
    pub box_mm: [Vec3; 2],
    /// Centroid of one of its facets.
    pub on_wall: Vec3,
    /// Whether no other shell comes nearer than the step: then it is sealed, by the theorem of Jordan and Brouwer.
    pub apart: bool,
    around: Winding,
}

impl Cavity {
    /// Whether a point lies within the shell.
    pub fn holds(&self, p: Vec3) -> bool {
        (0..3).all(|a| self.box_mm[0][a] <= p[a] && p[a] <= self.box_mm[1][a]) && self.around.at(p).abs() > 0.5
    }
}

/// The cavities of a mesh, in order of their first facets; exact up to the coordinates' resolution `step`.
///
/// # Limits
/// A shell that crosses itself is not noticed. A mesh that is no solid has none.
///
/// # Cost
/// O(facets of the shells concerned · log facets).
pub fn cavities(mesh: &TriangleMesh, health: &Health, step: f64) -> Vec<Cavity> {
    let wanted: Vec<u32> =
        (0..health.shells.len() as u32).filter(|&s| health.shells[s as usize].role == Role::Cavity).collect();
    if wanted.is_empty() || !health.is_solid() {
        return Vec::new();
    }
    let mut facets: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (f, &s) in health.facet_shell.iter().enumerate() {
        facets.entry(s).or_default().push(f);
    }
    let real = |s: u32| health.shells.get(s as usize).is_some_and(|s| s.role != Role::Ghost);
    let mut trees: BTreeMap<u32, MeshDistance> = BTreeMap::new();
    let mut found: Vec<Cavity> = Vec::new();
    for &s in &wanted {
        let shell = &health.shells[s as usize];
        let near: Vec<u32> =
            facets.keys().copied().filter(|&t| t != s && real(t) && close(health, s, t, step)).collect();
        for t in near.iter().chain([&s]) {
            trees.entry(*t).or_insert_with(|| MeshDistance::of_facets(mesh, facets[t].iter().copied()));
        }
        let apart = near.iter().all(|t| trees[&s].pair_distance(&trees[t], 2.0 * step).is_none());
        let own = TriangleMesh::weld(facets[&s].iter().map(|&f| mesh.corners(f)));
        found.push(Cavity {
            shell: s,
            volume_mm3: shell.volume_mm3.abs(),
            box_mm: shell.box_mm,
            on_wall: mesh.centroid(shell.first_facet),
            apart,
            around: Winding::new(&own),
        });
    }
    // A loose body takes its volume from the smallest cavity around it.
    for shell in health.shells.iter().filter(|s| matches!(s.role, Role::Body | Role::Inverted)) {
        let inside = mesh.centroid(shell.first_facet);
        let around = found.iter_mut().filter(|c| c.holds(inside));
        let volume = |c: &&mut Cavity| health.shells[c.shell as usize].volume_mm3.abs();
        if let Some(cavity) = around.min_by(|a, b| volume(a).total_cmp(&volume(b))) {
            cavity.volume_mm3 -= shell.volume_mm3.abs();
        }
    }
    found
}

/// Whether the boxes of two shells come within two steps.
fn close(health: &Health, s: u32, t: u32, step: f64) -> bool {
    let (a, b) = (health.shells[s as usize].box_mm, health.shells[t as usize].box_mm);
    (0..3).all(|x| a[0][x] - b[1][x] <= 2.0 * step && b[0][x] - a[1][x] <= 2.0 * step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::units::Length;

    fn cube(edge: f64, at: Vec3) -> TriangleMesh {
        let shape = Primitive::Box { edges: [Length::mm(edge); 3] };
        shape.mesh(Length::mm(0.1)).transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], at)
    }

    #[test]
    fn a_loose_body_takes_its_volume_and_a_touching_shell_the_certainty() {
        let hollow = cube(20.0, [0.0; 3]).joined(&cube(16.0, [0.0; 3]).flipped());
        let rattle = hollow.clone().joined(&cube(4.0, [1.0; 3]).joined(&cube(2.0, [1.0; 3]).flipped()));
        let found = cavities(&rattle, &Health::of(&rattle), 1e-6);
        let volumes: Vec<(f64, bool)> = found.iter().map(|c| (c.volume_mm3, c.apart)).collect();
        assert_eq!(volumes, [(4096.0 - 64.0, true), (8.0, true)]);
        assert!(found[0].holds([7.0; 3]) && !found[0].holds([9.0; 3]));
        let touching = hollow.joined(&cube(4.0, [6.0, 0.0, 0.0]));
        assert!(!cavities(&touching, &Health::of(&touching), 1e-6)[0].apart);
        assert!(cavities(&cube(5.0, [0.0; 3]), &Health::of(&cube(5.0, [0.0; 3])), 1e-6).is_empty());
    }
}
