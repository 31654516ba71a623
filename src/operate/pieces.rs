//! The pieces of a surface, each with its box.

use crate::geometry::vector::{Vec3, cross, dot, hull, sub};
use crate::geometry::{DisjointSets, TriangleMesh};

/// A box by its least and its greatest corner.
pub(super) type Box3 = (Vec3, Vec3);

/// The pieces of a surface that hang together over corners, in the order of their first vertices.
pub struct Pieces<'a> {
    pub(super) mesh: &'a TriangleMesh,
    /// The piece of each facet.
    of: Vec<u32>,
    /// The box of each piece.
    pub(super) boxes: Vec<Box3>,
}

impl<'a> Pieces<'a> {
    /// Those of a mesh.
    ///
    /// # Cost
    /// O(facets).
    pub fn of(mesh: &'a TriangleMesh) -> Self {
        let mut sets = DisjointSets::new(mesh.vertices.len());
        for &[a, b, c] in &mesh.triangles {
            sets.join(a, b);
            sets.join(b, c);
        }
        let mut of: Vec<u32> = mesh.triangles.iter().map(|t| sets.root(t[0])).collect();
        let mut numbers = vec![None; mesh.vertices.len()];
        of.iter().for_each(|&root| numbers[root as usize] = Some(0));
        let mut count = 0..;
        numbers.iter_mut().flatten().for_each(|number| *number = count.next().unwrap_or_default());
        let mut boxes = vec![([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]); count.start as usize];
        for (facet, piece) in of.iter_mut().enumerate() {
            *piece = numbers[*piece as usize].unwrap_or_default();
            let around = &mut boxes[*piece as usize];
            *around = mesh.corners(facet).into_iter().fold(*around, |all, p| hull(all, (p, p)));
        }
        Pieces { mesh, of, boxes }
    }

    /// The volume of each piece, mm³: negative where its facets face inwards.
    pub fn volumes(&self) -> Vec<f64> {
        // About a corner of its own box, so that a far origin costs no digits.
        let mut volumes = vec![0.0; self.boxes.len()];
        for (facet, &piece) in self.of.iter().enumerate() {
            let from = self.boxes[piece as usize].0;
            let [a, b, c] = self.mesh.corners(facet).map(|p| sub(p, from));
            volumes[piece as usize] += dot(a, cross(b, c)) / 6.0;
        }
        volumes
    }

    /// How many of them are bodies, not voids.
    pub fn bodies(&self) -> usize {
        self.volumes().iter().filter(|volume| **volume > 0.0).count()
    }

    /// The piece of a facet.
    pub fn piece_of(&self, facet: u32) -> u32 {
        self.of.get(facet as usize).copied().unwrap_or_default()
    }

    /// A piece by itself.
    pub fn mesh(&self, piece: usize) -> TriangleMesh {
        let own = self.of.iter().enumerate().filter(|(_, of)| **of as usize == piece);
        TriangleMesh::weld(own.map(|(facet, _)| self.mesh.corners(facet)))
    }
}
