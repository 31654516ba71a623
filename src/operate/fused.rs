//! Bodies of a part that a result makes one of.

use super::pieces::Pieces;
use super::whole::Whole;
use crate::geometry::vector::{Vec3, add, scale};
use crate::geometry::{MeshDistance, TriangleMesh};
use crate::notice::Notice;
use crate::units::short;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// As few vertices of a piece may be nearest to another body: at a gap that is thinner than the spacing they may be drawn there.
const STRAY: usize = 8;

impl Pieces<'_> {
    /// Says that bodies of the part came out as one where the result lies within the part, as each piece of it then lies within one body.
    ///
    /// # Cost
    /// O(facets); where there are fewer pieces than bodies, the union of these and a distance to it for each vertex.
    pub fn fused_bodies(&self, part: &TriangleMesh) -> Option<Notice> {
        let made = self.bodies();
        if Pieces::of(part).bodies() <= made {
            return None;
        }
        let whole = Whole::of(part);
        let bodies = Pieces::of(&whole.mesh);
        if bodies.bodies() <= made {
            return None;
        }
        let counts = self.vertices_beside(&whole.mesh, &bodies);
        let volumes = bodies.volumes();
        let is_solid = |body: u32| volumes.get(body as usize).is_some_and(|volume| *volume > 0.0);
        let mut joined: Vec<(u32, u32, Vec3)> = counts
            .into_iter()
            .filter(|&((_, body), (count, _))| count > STRAY && is_solid(body))
            .map(|((piece, body), (count, sum))| (piece, body, scale(sum, 1.0 / count as f64)))
            .collect();
        joined.sort_by_key(|&(piece, body, _)| (piece, body));
        let fused: Vec<&[(u32, u32, Vec3)]> =
            joined.chunk_by(|a, b| a.0 == b.0).filter(|bodies| bodies.len() > 1).collect();
        let [(_, _, one), (_, _, other), ..] = fused.first()? else { return None };
        let at = scale(add(*one, *other), 0.5);
        let count: usize = fused.iter().map(|bodies| bodies.len()).sum();
        let text = format!(
            "{count} bodies of the part come as {}, near ({}) mm: a gap between them is thinner than the spacing; choose a smaller --voxel",
            fused.len(),
            at.map(short).join(", ")
        );
        Some(Notice::new("thinner-than-spacing", text).counted(count as u64).at(at))
    }

    /// For each piece and each body that vertices of it are nearest to, how many are, counted once for each facet, and the sum of their places.
    fn vertices_beside(&self, part: &TriangleMesh, bodies: &Pieces) -> FxHashMap<(u32, u32), (usize, Vec3)> {
        let exact = MeshDistance::new(part);
        let nearest = |p: &Vec3| exact.nearest(*p, f64::INFINITY).map(|n| bodies.piece_of(n.facet));
        let of_vertex: Vec<Option<u32>> = self.mesh.vertices.par_iter().map(nearest).collect();
        let mut counts: FxHashMap<(u32, u32), (usize, Vec3)> = FxHashMap::default();
        for (facet, triangle) in self.mesh.triangles.iter().enumerate() {
            let first = triangle[0] as usize;
            if let Some(&Some(body)) = of_vertex.get(first) {
                let (count, sum) = counts.entry((self.piece_of(facet as u32), body)).or_default();
                (*count, *sum) = (*count + 1, add(*sum, self.mesh.vertices[first]));
            }
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::cuboid;
    use crate::operate::offset;
    use crate::units::Length;

    #[test]
    fn bodies_that_come_as_one_are_told_and_others_are_not() {
        let h = Length::mm(0.2);
        for (gap, told) in [(0.004, true), (1.0, false)] {
            let part = cuboid([0.0; 3], [2.0; 3]).joined(&cuboid([2.0 + gap, 0.0, 0.0], [4.0, 2.0, 2.0]));
            // Turned, so that no layer of samples lies in the gap.
            let (sin, cos) = 0.4f64.sin_cos();
            let part = part.transformed([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);
            let found = offset(&part, Length::mm(0.0), h).unwrap().pieces().fused_bodies(&part);
            assert_eq!(found.is_some(), told, "{found:?}");
        }
        // One that vanishes is not fused.
        let part = cuboid([0.0; 3], [2.0; 3]).joined(&cuboid([2.5, 0.0, 0.0], [2.6, 2.0, 2.0]));
        assert_eq!(offset(&part, Length::mm(-0.2), h).unwrap().pieces().fused_bodies(&part), None);
    }
}
