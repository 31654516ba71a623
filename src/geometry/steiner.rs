//! What decides how a surface grows as its body is offset.

use super::DisjointSets;
use super::edges::EdgeTable;
use super::mesh::TriangleMesh;
use super::vector::{cross, distance, dot, norm, sub};
use std::f64::consts::PI;

/// The numbers of Steiner's formula for a mesh, of which only the convex edges are asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steiner {
    /// Area, mm².
    pub area_mm2: f64,
    /// Half the sum, over convex edges, of length times turning angle: the integral of the mean curvature of a convex body, mm.
    pub turning_mm: f64,
    /// Pieces that hang together over edges of two facets.
    pub pieces: usize,
}

impl Steiner {
    /// Those of a mesh; edges of one facet or of more than two turn nowhere.
    ///
    /// # Cost
    /// O(facets).
    ///
    /// ```
    /// use amcheck::geometry::{Steiner, cuboid};
    /// let cube = Steiner::of(&cuboid([0.0; 3], [2.0, 2.0, 2.0]));
    /// assert!((cube.turning_mm - 6.0 * std::f64::consts::PI).abs() < 1e-9 && cube.pieces == 1);
    /// ```
    pub fn of(mesh: &TriangleMesh) -> Self {
        let turning = |ends: [u32; 2], sides: [usize; 2]| {
            let [a, b] = ends.map(|v| mesh.vertices.get(v as usize).copied().unwrap_or_default());
            let [m, n] = sides.map(|f| mesh.normal(f));
            let away = sub(mesh.centroid(sides[1]), a);
            let convex = dot(m, away) < 0.0;
            if convex { distance(a, b) * norm(cross(m, n)).atan2(dot(m, n)) } else { 0.0 }
        };
        let table = EdgeTable::of(mesh);
        let pieces = pieces(&table, mesh.triangles.len());
        let turns = table.edges().filter_map(|edge| match edge.sides {
            [one, other] => Some(turning(edge.ends, [one.1.facet(), other.1.facet()])),
            _ => None,
        });
        Steiner { area_mm2: mesh.area(), turning_mm: 0.5 * turns.sum::<f64>(), pieces }
    }

    /// The area of what rolls about the edges and corners of a convex body that is offset by a length, and no less than of others: 2·M·r +
    /// 4·π·r² for each piece.
    pub fn rounded_mm2(&self, by_mm: f64) -> f64 {
        2.0 * self.turning_mm * by_mm + 4.0 * PI * by_mm * by_mm * self.pieces as f64
    }
}

impl TriangleMesh {
    /// How many pieces the facets form that hang together over edges of two facets.
    ///
    /// # Cost
    /// O(facets).
    pub fn pieces(&self) -> usize {
        pieces(&EdgeTable::of(self), self.triangles.len())
    }
}

fn pieces(table: &EdgeTable, facets: usize) -> usize {
    let mut sets = DisjointSets::new(facets);
    for edge in table.edges() {
        if let [one, other] = edge.sides {
            sets.join(one.1.facet() as u32, other.1.facet() as u32);
        }
    }
    (0..facets as u32).filter(|&f| sets.root(f) == f).count()
}

#[cfg(test)]
mod tests {
    use super::super::{Primitive, cuboid};
    use super::*;
    use crate::units::Length;

    #[test]
    fn convex_bodies_have_their_mean_width_and_notches_turn_nowhere() {
        // A ball's is 4·π·r; facets inscribed by 0.01 mm are a little less.
        let ball = Steiner::of(&Primitive::parse("ball:3mm").unwrap().mesh(Length::mm(0.01)));
        assert!((ball.turning_mm / (12.0 * PI) - 1.0).abs() < 0.01 && ball.pieces == 1, "{ball:?}");
        let grown = 4.0 * PI * 16.0;
        assert!(((ball.area_mm2 + ball.rounded_mm2(1.0)) / grown - 1.0).abs() < 0.01);
        let two = cuboid([0.0; 3], [1.0, 2.0, 3.0]).joined(&cuboid([5.0, 0.0, 0.0], [6.0, 2.0, 3.0]));
        assert!((Steiner::of(&two).turning_mm - 2.0 * 4.0 * 6.0 * 0.25 * PI).abs() < 1e-9);
        assert_eq!(Steiner::of(&two).pieces, 2);
        // Two that share an edge are two.
        let beside = cuboid([0.0; 3], [1.0, 1.0, 1.0]).joined(&cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0]));
        assert_eq!(TriangleMesh::weld((0..24).map(|f| beside.corners(f))).pieces(), 2);
        assert!(Steiner::of(&cuboid([0.0; 3], [1.0, 1.0, 1.0]).flipped()).turning_mm.abs() < 1e-9);
    }
}
