//! The edges of a mesh with the facets along them.

use crate::geometry::TriangleMesh;

/// A facet along an edge, and whether it runs from the lower vertex to the higher.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side(u32);

impl Side {
    pub(super) fn facet(self) -> usize {
        (self.0 >> 1) as usize
    }

    /// +1 from the lower vertex to the higher, −1 the other way.
    pub(super) fn direction(self) -> i32 {
        if self.0 & 1 == 0 { 1 } else { -1 }
    }
}

/// One edge: its vertices, the lower first, and the facets along it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge<'a> {
    pub(super) ends: [u32; 2],
    pub(super) sides: &'a [(u32, Side)],
}

/// All edges of a mesh, grouped by their lower vertex.
///
/// Facets with two equal corners are left out: their two remaining sides run along one edge in opposite
/// directions and cancel.
///
/// # Cost
/// O(facets) by counting, and a sort of the few edges that start at each vertex.
pub(super) struct EdgeTable {
    starts: Vec<u32>,
    entries: Vec<(u32, Side)>,
}

/// Whether two corners of a facet are one vertex.
pub(super) fn is_collapsed([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// The Euler characteristic V − E + F of a closed surface, each of whose edges has two sides: 2 for a ball, 0 for a torus. Facets two of
/// whose corners are one vertex are passed over.
///
/// # Cost
/// O(vertices + facets).
///
/// ```
/// use amcheck::geometry::{closed_characteristic, cuboid};
/// assert_eq!(closed_characteristic(&cuboid([0.0; 3], [1.0, 2.0, 3.0])), 2);
/// ```
pub fn closed_characteristic(mesh: &TriangleMesh) -> i64 {
    let mut used = vec![false; mesh.vertices.len()];
    let facets = mesh.triangles.iter().filter(|t| !is_collapsed(**t));
    let facets = facets.inspect(|t| t.iter().for_each(|&v| used[v as usize] = true)).count() as i64;
    // Three edges for two facets.
    used.iter().filter(|u| **u).count() as i64 - facets / 2
}

impl EdgeTable {
    pub(super) fn of(mesh: &TriangleMesh) -> Self {
        let sides = || {
            mesh.triangles.iter().enumerate().filter(|(_, t)| !is_collapsed(**t)).flat_map(|(f, &[a, b, c])| {
                [(a, b), (b, c), (c, a)].map(|(from, to)| {
                    let side = Side((f as u32) << 1 | u32::from(from > to));
                    (from.min(to), from.max(to), side)
                })
            })
        };
        let mut starts = vec![0u32; mesh.vertices.len() + 1];
        sides().for_each(|(low, ..)| starts[low as usize + 1] += 1);
        for v in 1..starts.len() {
            starts[v] += starts[v - 1];
        }
        let mut next = starts.clone();
        let mut entries = vec![(0u32, Side(0)); starts[mesh.vertices.len()] as usize];
        sides().for_each(|(low, high, side)| {
            let at = &mut next[low as usize];
            entries[*at as usize] = (high, side);
            *at += 1;
        });
        for v in 0..mesh.vertices.len() {
            entries[starts[v] as usize..starts[v + 1] as usize].sort_unstable();
        }
        EdgeTable { starts, entries }
    }

    /// The edges in order of their vertices.
    pub(super) fn edges(&self) -> impl Iterator<Item = Edge<'_>> {
        self.starts.windows(2).enumerate().flat_map(move |(v, range)| {
            self.entries[range[0] as usize..range[1] as usize]
                .chunk_by(|a, b| a.0 == b.0)
                .map(move |sides| Edge { ends: [v as u32, sides[0].0], sides })
        })
    }

    /// A facet along the edge between two vertices, if there is one.
    pub(super) fn facet_along(&self, a: u32, b: u32) -> Option<usize> {
        let low = a.min(b) as usize;
        let bucket = &self.entries[self.starts[low] as usize..self.starts[low + 1] as usize];
        let at = bucket.partition_point(|e| e.0 < a.max(b));
        bucket.get(at).filter(|e| e.0 == a.max(b)).map(|e| e.1.facet())
    }
}

impl Edge<'_> {
    /// The sum of the directions: zero where as many facets run one way as the other.
    pub(super) fn imbalance(&self) -> i32 {
        self.sides.iter().map(|s| s.1.direction()).sum()
    }

    /// Whether two facets run along the edge in the same direction.
    pub(super) fn is_miswound(&self) -> bool {
        self.sides.len() == 2 && self.imbalance() != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_has_six_balanced_edges() {
        let mesh = TriangleMesh {
            vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2], [1, 1, 2]],
        };
        let table = EdgeTable::of(&mesh);
        assert_eq!(table.edges().count(), 6);
        assert!(table.edges().all(|e| e.sides.len() == 2 && e.imbalance() == 0));
        assert_eq!(table.facet_along(2, 3), Some(2));
        assert_eq!(table.facet_along(1, 1), None);
    }
}
