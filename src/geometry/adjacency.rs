//! Which facets share an edge.

use super::edges::EdgeTable;
use super::mesh::TriangleMesh;

/// No facet across an edge.
const NONE: u32 = u32::MAX;

/// The facet across each edge of each facet.
pub struct Adjacency {
    across: Vec<[u32; 3]>,
}

impl Adjacency {
    /// The neighbours among the facets for which `counts` holds; an edge without exactly two of them leads nowhere.
    ///
    /// # Cost
    /// That of the table of edges, O(facets).
    pub fn of(mesh: &TriangleMesh, counts: impl Fn(usize) -> bool) -> Self {
        let mut across = vec![[NONE; 3]; mesh.triangles.len()];
        for edge in EdgeTable::of(mesh).edges() {
            let mut along = edge.sides.iter().map(|s| s.1.facet()).filter(|&f| counts(f));
            let (Some(f), Some(g), None) = (along.next(), along.next(), along.next()) else { continue };
            for (own, other) in [(f, g), (g, f)] {
                let t = mesh.triangles[own];
                let leads = |e: &usize| edge.ends == [t[*e].min(t[(e + 1) % 3]), t[*e].max(t[(e + 1) % 3])];
                (0..3).filter(leads).for_each(|e| across[own][e] = other as u32);
            }
        }
        Adjacency { across }
    }

    /// The facet across edge `e` (from corner e to the next) of a facet.
    pub fn across(&self, facet: u32, e: usize) -> Option<u32> {
        self.across.get(facet as usize).map(|f| f[e]).filter(|&f| f != NONE)
    }

    /// The facets across the edges of a facet.
    pub fn beside(&self, facet: u32) -> impl Iterator<Item = u32> + '_ {
        (0..3).filter_map(move |e| self.across(facet, e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Lcg;

    #[test]
    fn neighbours_are_those_that_share_both_ends_of_an_edge_with_no_third() {
        let mut random = Lcg(17);
        for _ in 0..60 {
            let vertices = (0..9).map(|_| random.point(0.0, 1.0)).collect();
            let mut corner = || random.below(9) as u32;
            let triangles: Vec<[u32; 3]> = (0..14)
                .map(|_| [corner(), corner(), corner()])
                .filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
                .collect();
            let mesh = TriangleMesh { vertices, triangles };
            let counts = |f: usize| f % 5 != 3;
            let found = Adjacency::of(&mesh, counts);
            for (f, t) in mesh.triangles.iter().enumerate() {
                for e in 0..3 {
                    let ends = [t[e], t[(e + 1) % 3]];
                    let has = |g: &usize| ends.iter().all(|v| mesh.triangles[*g].contains(v));
                    let all: Vec<usize> = (0..mesh.triangles.len()).filter(|&g| counts(g)).filter(has).collect();
                    let want = match all[..] {
                        [g, h] if counts(f) => Some(if g == f { h } else { g } as u32),
                        _ => None,
                    };
                    assert_eq!(found.across(f as u32, e), want);
                }
            }
        }
    }
}
