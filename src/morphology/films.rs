//! Pieces of a surface without thickness.

use crate::geometry::vector::{cross, dot, sub};
use crate::geometry::{DisjointSets, TriangleMesh};
use rustc_hash::FxHashMap;

/// A mesh without its pieces that are thinner than so much on the mean, mm: where two sides meet all along, rounding alone tells whether
/// anything is between.
pub(super) fn without_films(mesh: TriangleMesh, thick: f64) -> TriangleMesh {
    let mut sets = DisjointSets::new(mesh.vertices.len());
    for &[a, b, c] in &mesh.triangles {
        sets.join(a, b);
        sets.join(b, c);
    }
    let roots: Vec<u32> = mesh.triangles.iter().map(|t| sets.root(t[0])).collect();
    let mut sizes: FxHashMap<u32, (f64, f64)> = FxHashMap::default();
    for (facet, root) in roots.iter().enumerate() {
        // About a vertex of its own, so that a far origin costs no digits.
        let from = mesh.vertices[*root as usize];
        let [a, b, c] = mesh.corners(facet).map(|p| sub(p, from));
        let (volume, area) = sizes.entry(*root).or_default();
        *volume += dot(a, cross(b, c)) / 6.0;
        *area += mesh.facet_area(facet);
    }
    sizes.retain(|_, (volume, area)| 2.0 * volume.abs() < thick * *area);
    if sizes.is_empty() {
        return mesh;
    }
    let kept = (0..mesh.triangles.len()).filter(|&facet| !sizes.contains_key(&roots[facet]));
    TriangleMesh::weld(kept.map(|facet| mesh.corners(facet)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn a_film_beside_a_block_goes_and_the_block_stays() {
        let film = |thick: f64| cuboid([5.0, 0.0, 0.0], [9.0, 3.0, thick]);
        let block = cuboid([0.0; 3], [2.0, 2.0, 2.0]);
        for (thick, kept) in [(0.001, 12), (0.1, 24)] {
            let left = without_films(block.clone().joined(&film(thick)), 0.01);
            assert_eq!(left.triangles.len(), kept, "{thick}");
        }
        assert_eq!(without_films(block.clone(), 0.01), block);
    }
}
