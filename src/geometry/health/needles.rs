//! Needles: facets with an edge shorter than what the file tells apart, whose direction is rounding.

use crate::geometry::edges::EdgeTable;
use crate::geometry::vector::distance;
use crate::geometry::{DisjointSets, TriangleMesh};

use super::caps::without_caps;

/// Vertices that an edge of at most so many steps joins are one: each may be off by half a step along each axis.
const ONE: f64 = 2.0;

/// A mesh without the needles and caps that it can do without, if it has any.
///
/// Edges no longer than two steps are collapsed, then the longest edges of caps flipped. The surface moves by no more than two steps, and what is closed
/// stays closed. Where the box of the mesh would change by more, all stays.
///
/// # Cost
/// O(facets); with slivers some tables of all edges.
pub fn without_slivers(mesh: &TriangleMesh, step: f64) -> Option<TriangleMesh> {
    let collapsed = without_needles(mesh, step);
    without_caps(collapsed.as_ref().unwrap_or(mesh), step).or(collapsed).filter(|made| reaches_as_far(made, mesh, step))
}

/// Whether the boxes of two meshes are the same to within two steps: a needle may be all that reaches somewhere.
fn reaches_as_far(a: &TriangleMesh, b: &TriangleMesh, step: f64) -> bool {
    let (Some(a), Some(b)) = (a.bounds(), b.bounds()) else { return false };
    (0..3).all(|n| (a.0[n] - b.0[n]).abs() <= ONE * step && (a.1[n] - b.1[n]).abs() <= ONE * step)
}

/// A mesh in which the ends of edges no longer than two steps are one vertex, if there are such and no edge gets more or fewer than two facets by
/// that.
///
/// # Cost
/// O(facets); with such edges two tables of all edges.
fn without_needles(mesh: &TriangleMesh, step: f64) -> Option<TriangleMesh> {
    let mut sets = DisjointSets::new(mesh.vertices.len());
    let mut any = false;
    for &[a, b, c] in &mesh.triangles {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            if p != q && distance(mesh.vertices[p as usize], mesh.vertices[q as usize]) <= ONE * step {
                sets.join(p, q);
                any = true;
            }
        }
    }
    if !any {
        return None;
    }
    let joined = mesh.triangles.iter().map(|t| t.map(|v| sets.root(v)));
    let kept = joined.filter(|[a, b, c]| a != b && b != c && c != a);
    let made = TriangleMesh::weld(kept.map(|t| t.map(|v| mesh.vertices[v as usize]))).in_order();
    (!made.triangles.is_empty() && unpaired(&made) <= unpaired(mesh)).then_some(made)
}

/// Edges that are not those of exactly two facets, one each way.
fn unpaired(mesh: &TriangleMesh) -> usize {
    let table = EdgeTable::of(mesh);
    let is_paired = |sides: &[(u32, crate::geometry::edges::Side)]| {
        sides.len() == 2 && sides.iter().map(|s| s.1.direction()).sum::<i32>() == 0
    };
    table.edges().filter(|edge| !is_paired(edge.sides)).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::{add, along, sub};
    use crate::geometry::{Health, cuboid};
    use crate::random::Lcg;

    /// A mesh with edges divided beside a corner, so near that the piece between is a needle.
    fn needled(mesh: &TriangleMesh, random: &mut Lcg) -> TriangleMesh {
        let mut out = mesh.clone();
        for _ in 0..5 {
            let (f, e) = (random.below(mesh.triangles.len() as u64) as usize, random.below(3) as usize);
            let [a, b] = [0, 1].map(|i| out.triangles[f][(e + i) % 3]);
            let find = |out: &TriangleMesh, a: u32, b: u32| {
                (0..out.triangles.len())
                    .find(|&g| (0..3).any(|e| [out.triangles[g][e], out.triangles[g][(e + 1) % 3]] == [a, b]))
            };
            let (Some(f), Some(g)) = (find(&out, a, b), find(&out, b, a)) else { continue };
            let [p, q] = [a, b].map(|v| out.vertices[v as usize]);
            let new = out.vertices.len() as u32;
            out.vertices.push(add(along(p, sub(q, p), 1e-7), random.point(-3e-7, 3e-7)));
            for (facet, from, to) in [(f, a, b), (g, b, a)] {
                let third = out.triangles[facet].into_iter().find(|v| *v != from && *v != to).unwrap();
                out.triangles[facet] = [from, new, third];
                out.triangles.push([new, to, third]);
            }
        }
        out
    }

    #[test]
    fn needles_go_and_what_cannot_go_stays() {
        let mut random = Lcg(29);
        for n in 0..100 {
            let block = cuboid([0.0; 3], [4.0, 3.0, 2.0]).in_order();
            let mesh = needled(&block, &mut random);
            let made = without_slivers(&mesh, 1e-6).unwrap_or_else(|| panic!("{n}: no needle was seen"));
            let health = Health::of(&made);
            assert!(health.is_solid() && health.is_watertight(), "{n}");
            assert_eq!(made.triangles.len(), block.triangles.len(), "{n}");
            assert!((made.signed_volume() - 24.0).abs() < 1e-5, "{n}");
            assert_eq!(without_slivers(&made, 1e-6), None);
        }
        // What a needle alone reaches is not lost.
        let spike = [[4.0, 3.0, 2.0], [4.0, 3.0, 2.0 + 1e-7], [1e6, 3.0, 2.0]];
        let mut spiked = cuboid([0.0; 3], [4.0, 3.0, 2.0]);
        spiked.triangles.extend([[8, 9, 10], [8, 10, 9]]);
        spiked.vertices.extend(spike);
        assert_eq!(without_slivers(&spiked, 1e-6), None);
        // A film no thicker than that would be left with two sides in one place.
        let film = cuboid([0.0; 3], [4.0, 3.0, 1e-6]);
        assert_eq!(without_slivers(&film, 1e-6), None);
    }
}
