//! Edges where the surface bends towards the void: the notches of a part, and the rounds made of shallow ones.

use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, along, angle, distance, dot, norm, sub, unit};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// An edge between two facets that face each other across the void.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReflexEdge {
    pub ends: [u32; 2],
    pub facets: [u32; 2],
    /// Angle between the normals of its facets, radians: 0 for a flat surface, π/2 at the foot of an upright wall.
    pub bend: f64,
    pub length: f64,
    pub middle: Vec3,
    /// Unit normals of its facets.
    pub normals: [Vec3; 2],
    /// Heights of its facets over it.
    pub heights: [f64; 2],
}

impl ReflexEdge {
    /// Unit vector into the void, halfway between the facets.
    pub fn outward(&self) -> Vec3 {
        unit([0, 1, 2].map(|a| self.normals[0][a] + self.normals[1][a]))
    }

    /// Radius of the round that edges like this one, as far apart as its lower facet is high, are the facets of.
    ///
    /// The radius of the circle inscribed in a regular polygon with sides s and bends φ: s / (2·tan(φ/2)).
    pub fn inscribed_radius(&self) -> f64 {
        0.5 * self.heights[0].min(self.heights[1]) / (0.5 * self.bend).tan()
    }

    /// Where a ball of a radius rests that touches both facets: the centre of its fillet across the middle of the edge.
    pub fn fillet_centre(&self, radius: f64) -> Vec3 {
        along(self.middle, self.outward(), radius / (0.5 * self.bend).cos())
    }
}

/// All edges with exactly two facets that bend towards the void by at least `least`, radians, in order of their vertices.
///
/// `use_facet` leaves out facets that do not bound the solid.
///
/// # Cost
/// One sort of the edges.
pub fn reflex_edges(mesh: &TriangleMesh, least: f64, use_facet: impl Fn(usize) -> bool + Sync) -> Vec<ReflexEdge> {
    let mut sides: Vec<(u32, u32, u32)> = (0..mesh.triangles.len())
        .into_par_iter()
        .filter(|&f| use_facet(f))
        .flat_map_iter(|f| {
            let [a, b, c] = mesh.triangles[f];
            [(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), p.max(q), f as u32))
        })
        .collect();
    sides.par_sort_unstable();
    let edges: Vec<&[(u32, u32, u32)]> =
        sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).filter(|c| c.len() == 2).collect();
    edges.into_par_iter().filter_map(|c| reflex(mesh, [c[0].0, c[0].1], [c[0].2, c[1].2], least)).collect()
}

/// Edges, or parts of them, that share a key, such as a vertex or a facet, as lists of indices: each list in increasing order,
/// the lists by their first member.
pub fn joined<E>(edges: &[E], keys: impl Fn(&E) -> Vec<u32>) -> Vec<Vec<usize>> {
    let mut with_key: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (i, e) in edges.iter().enumerate() {
        keys(e).into_iter().for_each(|key| with_key.entry(key).or_default().push(i));
    }
    let mut seen = vec![false; edges.len()];
    let mut groups = Vec::new();
    for first in 0..edges.len() {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let (mut group, mut next) = (Vec::new(), vec![first]);
        while let Some(i) = next.pop() {
            group.push(i);
            for &j in keys(&edges[i]).iter().filter_map(|key| with_key.get(key)).flatten() {
                if !std::mem::replace(&mut seen[j], true) {
                    next.push(j);
                }
            }
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

fn reflex(mesh: &TriangleMesh, ends: [u32; 2], facets: [u32; 2], least: f64) -> Option<ReflexEdge> {
    let normals = facets.map(|f| mesh.normal(f as usize));
    let bend = angle(normals[0], normals[1]);
    if bend < least || normals.iter().any(|n| norm(*n) < 0.5) {
        return None;
    }
    let [p, q] = ends.map(|v| mesh.vertices[v as usize]);
    let middle = along(p, sub(q, p), 0.5);
    // The second facet rises above the first where the edge is reflex.
    let rises = dot(normals[0], sub(mesh.centroid(facets[1] as usize), middle)) > 0.0;
    let length = distance(p, q);
    let heights = facets.map(|f| 2.0 * mesh.facet_area(f as usize) / length);
    (rises && length > 0.0).then_some(ReflexEdge { ends, facets, bend, length, middle, normals, heights })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An L of legs 10 mm, 2 mm thick, 5 mm deep, its inner corner a right angle.
    fn angle_bracket() -> TriangleMesh {
        let outline = [[0.0, 0.0], [10.0, 0.0], [10.0, 2.0], [2.0, 2.0], [2.0, 10.0], [0.0, 10.0]];
        let at = |i: usize, y: f64| [outline[i][0], y, outline[i][1]];
        let mut facets = Vec::new();
        for i in 0..6 {
            let j = (i + 1) % 6;
            facets.push([at(i, 0.0), at(j, 5.0), at(j, 0.0)]);
            facets.push([at(i, 0.0), at(i, 5.0), at(j, 5.0)]);
        }
        for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
            facets.push([at(a, 0.0), at(b, 0.0), at(c, 0.0)]);
            facets.push([at(a, 5.0), at(c, 5.0), at(b, 5.0)]);
        }
        let mesh = TriangleMesh::weld(facets);
        if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh }
    }

    #[test]
    fn a_bracket_has_one_notch_and_the_centre_of_a_fillet_in_it() {
        let mesh = angle_bracket();
        let edges = reflex_edges(&mesh, 0.1, |_| true);
        assert_eq!(edges.len(), 1, "{edges:?}");
        let e = edges[0];
        assert!((e.bend.to_degrees() - 90.0).abs() < 1e-9 && (e.length - 5.0).abs() < 1e-12);
        let centre = e.fillet_centre(0.5);
        assert!((centre[0] - 2.5).abs() < 1e-12 && (centre[2] - 2.5).abs() < 1e-12, "{centre:?}");
        // Inside out, all other edges of the prism are notches: five along it, six around either end.
        assert_eq!(reflex_edges(&mesh.flipped(), 0.1, |_| true).len(), 5 + 12);
    }
}
