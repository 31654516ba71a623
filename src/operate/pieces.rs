//! The pieces of a surface, each with its box.

use crate::geometry::vector::{Vec3, cross, dot, hull, sub};
use crate::geometry::{DisjointSets, TriangleMesh};
use rustc_hash::FxHashMap;

/// A box by its least and its greatest corner.
pub(super) type Box3 = (Vec3, Vec3);

/// The pieces of a surface that hang together over corners, in the order of their first vertices.
pub(super) struct Pieces<'a> {
    mesh: &'a TriangleMesh,
    /// The piece of each facet.
    of: Vec<u32>,
    /// The box of each piece.
    pub boxes: Vec<Box3>,
}

impl<'a> Pieces<'a> {
    /// # Cost
    /// O(facets).
    pub fn of(mesh: &'a TriangleMesh) -> Self {
        let mut sets = DisjointSets::new(mesh.vertices.len());
        for &[a, b, c] in &mesh.triangles {
            sets.join(a, b);
            sets.join(b, c);
        }
        let mut roots: Vec<u32> = mesh.triangles.iter().map(|t| sets.root(t[0])).collect();
        let mut distinct = roots.clone();
        distinct.sort_unstable();
        distinct.dedup();
        let numbers: FxHashMap<u32, u32> = distinct.iter().copied().zip(0..).collect();
        let mut boxes = vec![([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]); distinct.len()];
        for (facet, root) in roots.iter_mut().enumerate() {
            *root = numbers.get(root).copied().unwrap_or_default();
            let piece = &mut boxes[*root as usize];
            *piece = mesh.corners(facet).into_iter().fold(*piece, |all, p| hull(all, (p, p)));
        }
        Pieces { mesh, of: roots, boxes }
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
