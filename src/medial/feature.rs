//! The features a maximal ball can touch: facets, and the edges and vertices that bend towards the ball.

use crate::geometry::TriangleMesh;
use crate::geometry::bvh::{Bounds, Bvh, bounds_of};
use crate::geometry::vector::{Vec3, add, angle, bounds, cross, dot, norm2, scale, sub, unit};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// Edges bent by less than this are covered by the margin of their facets' cones, radians (5°).
pub const SHARP: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// The side of the surface on which balls are grown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Inside the part: the balls measure walls.
    Material,
    /// Outside the part: the balls measure gaps.
    Void,
}

impl Side {
    /// +1 where normals point away from the balls, −1 where they point at them.
    pub fn sign(self) -> f64 {
        match self {
            Side::Material => 1.0,
            Side::Void => -1.0,
        }
    }
}

/// One feature: a facet, an edge as (a, b, b) or a vertex as (a, a, a), with the cone of directions that point
/// away from a ball touching it.
#[derive(Debug, Clone, Copy)]
pub struct Feature {
    pub corners: [Vec3; 3],
    pub axis: Vec3,
    /// Half-angle of the cone, radians; 0 for a facet.
    pub spread: f64,
    /// Largest bend towards the ball at an edge too blunt to be a feature of its own, radians below [`SHARP`].
    pub slack: f64,
    /// The two ends of an edge's arc of directions; both are the axis for a facet or a vertex.
    pub arc: [Vec3; 2],
    /// A facet of the mesh the feature belongs to.
    pub facet: u32,
}

impl Feature {
    /// The largest angle between a direction and one that points away from a ball touching the feature.
    ///
    /// Exact for facets and edges; an upper bound for vertices.
    pub fn widest_angle(&self, direction: Vec3) -> f64 {
        let [m, n] = self.arc;
        if self.spread == 0.0 || m == n {
            return angle(direction, self.axis) + self.spread;
        }
        let across = unit(cross(m, n));
        let opposite = scale(direction, -1.0);
        // The antipode, dropped onto the plane of the arc: the widest angle is there if it falls inside the arc.
        let foot = sub(opposite, scale(across, dot(opposite, across)));
        let inside = dot(cross(m, foot), across) >= 0.0 && dot(cross(foot, n), across) >= 0.0;
        if inside && norm2(foot) > 0.0 {
            std::f64::consts::PI - angle(opposite, foot)
        } else {
            angle(direction, m).max(angle(direction, n))
        }
    }

    /// Whether the feature is a facet rather than an edge or a vertex.
    pub fn is_facet(&self) -> bool {
        self.corners[1] != self.corners[2]
    }
}

/// All features of a mesh for one side, with their tree.
pub struct Features {
    /// Facets first, in increasing order, then vertices and edges.
    pub list: Vec<Feature>,
    pub tree: Bvh,
    pub side: Side,
    /// Body of each facet of the mesh; empty if all are one.
    bodies: Vec<u32>,
}

impl Features {
    /// The features a ball on `side` can touch; `use_facet` leaves out facets that do not bound the solid.
    ///
    /// A ball in the material never touches a convex edge (its radius would be 0), only facets and reflex edges
    /// and vertices; in the void it is the other way round.
    pub fn new(mesh: &TriangleMesh, side: Side, use_facet: impl Fn(usize) -> bool) -> Self {
        let facets: Vec<u32> = (0..mesh.triangles.len()).filter(|&f| use_facet(f)).map(|f| f as u32).collect();
        let sign = side.sign();
        let of_facet = |&f: &u32| {
            let normal = mesh.normal(f as usize);
            let axis = scale(normal, sign);
            let corners = mesh.corners(f as usize);
            (norm2(normal) > 0.0).then_some(Feature {
                corners,
                axis,
                spread: 0.0,
                slack: 0.0,
                arc: [axis; 2],
                facet: f,
            })
        };
        let mut list: Vec<Feature> = facets.par_iter().filter_map(of_facet).collect();
        let bent = bent_edges(mesh, side, &shared_edges(mesh, &list));
        let mut slack: FxHashMap<u32, f64> = FxHashMap::default();
        for e in bent.iter().filter(|e| e.reflex && e.bend <= SHARP) {
            for facet in [e.facets.0, e.facets.1] {
                let most = slack.entry(facet).or_default();
                *most = most.max(e.bend);
            }
        }
        list.iter_mut().for_each(|f| f.slack = slack.get(&f.facet).copied().unwrap_or(0.0));
        let sharp: Vec<BentEdge> = bent.into_iter().filter(|e| e.bend > SHARP).collect();
        list.extend(vertices(mesh, &sharp));
        list.extend(sharp.into_iter().filter_map(|e| e.reflex.then_some(e.feature)));
        let tree = Bvh::new(&bounds_of(list.len(), |i| {
            let f = &list[i];
            let (lo, hi) = bounds(f.corners).unwrap_or(([0.0; 3], [0.0; 3]));
            Bounds { lo, hi, axis: f.axis, spread: f.spread + f.slack }
        }));
        Features { list, tree, side, bodies: Vec::new() }
    }
}

impl Features {
    /// The same features with the body of each facet of the mesh.
    pub fn of_bodies(self, bodies: &[u32]) -> Self {
        Features { bodies: bodies.to_vec(), ..self }
    }

    /// The body of a facet.
    pub fn body(&self, facet: u32) -> u32 {
        self.bodies.get(facet as usize).copied().unwrap_or(0)
    }
}

/// An edge between two facets that are not in one plane.
struct BentEdge {
    ends: (u32, u32),
    facets: (u32, u32),
    /// Angle between the normals, radians.
    bend: f64,
    /// Whether it bends towards a ball on the side.
    reflex: bool,
    feature: Feature,
}

/// An edge by its vertices, the lower first, and the first and the last facet along it.
type Shared = ((u32, u32), (u32, u32));

/// The edges that two facets or more have in common, in increasing order of their vertices.
fn shared_edges(mesh: &TriangleMesh, list: &[Feature]) -> Vec<Shared> {
    let of_facet = |f: &Feature| {
        let ([a, b, c], facet) = (mesh.triangles[f.facet as usize], f.facet);
        [(a, b), (b, c), (c, a)].map(|(p, q)| (u64::from(p.min(q)) << 32 | u64::from(p.max(q)), facet))
    };
    let mut edges: Vec<(u64, u32)> = list.par_iter().flat_map_iter(of_facet).collect();
    edges.par_sort_unstable();
    let ends = |key: u64| ((key >> 32) as u32, key as u32);
    let shared = edges.chunk_by(|a, b| a.0 == b.0).filter_map(|e| {
        let (&(key, f), &(_, g)) = (e.first()?, e.last()?);
        (f != g).then(|| (ends(key), (f, g)))
    });
    shared.collect()
}

/// The bent ones of the edges, in the same order.
fn bent_edges(mesh: &TriangleMesh, side: Side, edges: &[Shared]) -> Vec<BentEdge> {
    let sign = side.sign();
    edges
        .par_iter()
        .filter_map(|&(ends, (f, g))| {
            let (m, n) = (mesh.normal(f as usize), mesh.normal(g as usize));
            let bend = angle(m, n);
            if bend < 1e-7 {
                return None;
            }
            let (a, b) = (mesh.vertices[ends.0 as usize], mesh.vertices[ends.1 as usize]);
            // The edge in the direction in which facet f runs along it.
            let t = mesh.triangles[f as usize];
            let forward = (0..3).any(|e| t[e] == ends.0 && t[(e + 1) % 3] == ends.1);
            let along = if forward { sub(b, a) } else { sub(a, b) };
            let reflex = dot(cross(m, n), along) * sign < 0.0;
            let axis = scale(unit(add(m, n)), sign);
            Some(BentEdge {
                ends,
                facets: (f, g),
                bend,
                reflex,
                feature: Feature {
                    corners: [a, b, b],
                    axis,
                    spread: 0.5 * bend,
                    slack: 0.0,
                    arc: [scale(m, sign), scale(n, sign)],
                    facet: f.min(g),
                },
            })
        })
        .collect()
}

/// Vertices whose sharp edges all bend towards the ball: tips of pits (material) or of spikes (void).
fn vertices(mesh: &TriangleMesh, sharp: &[BentEdge]) -> Vec<Feature> {
    let mut at: BTreeMap<u32, (bool, Vec<&BentEdge>)> = BTreeMap::new();
    for e in sharp {
        for v in [e.ends.0, e.ends.1] {
            let entry = at.entry(v).or_insert((true, Vec::new()));
            entry.0 &= e.reflex;
            entry.1.push(e);
        }
    }
    at.into_iter()
        .filter(|(_, (all_reflex, edges))| *all_reflex && edges.len() >= 3)
        .filter_map(|(v, (_, edges))| {
            let axis = unit(edges.iter().fold([0.0; 3], |s, e| add(s, e.feature.axis)));
            let spread = edges.iter().map(|e| angle(axis, e.feature.axis) + e.feature.spread).fold(0.0, f64::max);
            let p = mesh.vertices[v as usize];
            (norm2(axis) > 0.0 && spread < 1.5).then(|| Feature {
                corners: [p, p, p],
                axis,
                spread,
                slack: 0.0,
                arc: [axis; 2],
                facet: edges[0].feature.facet,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box with a square notch along y in its top, as quads.
    fn notched() -> TriangleMesh {
        let outline =
            [[0.0, 0.0], [10.0, 0.0], [10.0, 5.0], [6.0, 5.0], [6.0, 2.0], [4.0, 2.0], [4.0, 5.0], [0.0, 5.0]];
        let mut facets = Vec::new();
        let at = |i: usize, y: f64| [outline[i][0], y, outline[i][1]];
        for i in 0..8 {
            let j = (i + 1) % 8;
            facets.push([at(i, 0.0), at(j, 0.0), at(j, 3.0)]);
            facets.push([at(i, 0.0), at(j, 3.0), at(i, 3.0)]);
        }
        for t in [[0, 5, 7], [5, 6, 7], [0, 4, 5], [0, 1, 4], [1, 3, 4], [1, 2, 3]] {
            let [a, b, c]: [usize; 3] = t;
            facets.push([at(a, 0.0), at(c, 0.0), at(b, 0.0)]);
            facets.push([at(a, 3.0), at(b, 3.0), at(c, 3.0)]);
        }
        // The outline runs so that y-sides face outwards only after turning all facets over.
        let mesh = TriangleMesh::weld(facets);
        if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh }
    }

    #[test]
    fn only_reflex_edges_are_features_of_the_material() {
        let mesh = notched();
        let edges = |side| Features::new(&mesh, side, |_| true).list.iter().filter(|f| !f.is_facet()).count();
        // Two bottom edges of the notch bend inwards; all other sharp edges bend outwards.
        assert_eq!(edges(Side::Material), 2);
        // 8 edges along y less the 2 reflex ones, 16 around the two faces, and the vertices whose edges are all convex.
        assert_eq!(edges(Side::Void), 6 + 16 + 12);
    }
}
