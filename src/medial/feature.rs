//! The features a maximal ball can touch: facets, and the edges and vertices that bend towards the ball.

use super::facing::Facing;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, add, angle, cross, dot, norm2, scale, sub, unit};
use rayon::prelude::*;

/// Edges bent by less than this are covered by the margin of their facets' cones, radians (5°).
pub const SHARP: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// The foot of a unit vector on a plane that is at right angles to it is rounding, and shorter than this.
const SHORT: f64 = 1e-10;

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
    /// The other facet of an edge; the same one for a facet or a vertex.
    pub beside: u32,
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
        // A shorter foot is rounding: the direction is at right angles to all of the arc.
        if inside && norm2(foot) > SHORT * SHORT {
            std::f64::consts::PI - angle(opposite, foot)
        } else {
            angle(direction, m).max(angle(direction, n))
        }
    }

    /// Whether the feature is a facet rather than an edge or a vertex.
    pub fn is_facet(&self) -> bool {
        self.corners[1] != self.corners[2]
    }

    /// Whether the feature is an edge.
    pub fn is_edge(&self) -> bool {
        self.corners[0] != self.corners[1] && !self.is_facet()
    }
}

/// All features of a mesh for one side, with their tree.
pub struct Features {
    /// Facets first, in increasing order, then vertices and edges.
    pub list: Vec<Feature>,
    pub(super) facing: Facing,
    pub side: Side,
    /// Body of each facet of the mesh; empty if all are one.
    bodies: Vec<u32>,
}

impl Features {
    /// The features a ball on `side` can touch; `use_facet` leaves out facets that do not bound the solid.
    ///
    /// A ball in the material never touches a convex edge (its radius would be 0), only facets and reflex edges
    /// and vertices; in the void it is the other way round.
    pub fn new(mesh: &TriangleMesh, side: Side, use_facet: impl Fn(usize) -> bool + Sync) -> Self {
        Features::of(mesh, side, &Bends::of(mesh, use_facet))
    }

    /// As [`Features::new`], of facets whose bends are known.
    pub fn of(mesh: &TriangleMesh, side: Side, bends: &Bends) -> Self {
        let sign = side.sign();
        let mut slack = vec![0.0f64; mesh.triangles.len()];
        for b in bends.edges.iter().filter(|b| b.angle <= SHARP && b.is_reflex(side)) {
            for facet in [b.facets.0, b.facets.1] {
                let most = &mut slack[facet as usize];
                *most = most.max(b.angle);
            }
        }
        let of_facet = |&facet: &u32| {
            let (f, axis) = (facet as usize, scale(mesh.normal(facet as usize), sign));
            Feature {
                corners: mesh.corners(f),
                axis,
                spread: 0.0,
                slack: slack[f],
                arc: [axis; 2],
                facet,
                beside: facet,
            }
        };
        let sharp: Vec<&Bend> = bends.edges.iter().filter(|b| b.angle > SHARP).collect();
        let edges: Vec<Feature> = sharp.par_iter().map(|b| b.feature(mesh, sign)).collect();
        let reflex: Vec<bool> = sharp.iter().map(|b| b.is_reflex(side)).collect();
        let mut list: Vec<Feature> = bends.facets.par_iter().map(of_facet).collect();
        list.extend(vertices(mesh, &sharp, &edges, &reflex));
        list.extend(edges.into_iter().zip(reflex).filter_map(|(e, reflex)| reflex.then_some(e)));
        Features { facing: Facing::of(&list), list, side, bodies: Vec::new() }
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

/// The edges at which a surface bends: the same for balls on either side of it.
pub struct Bends {
    /// The facets with area among those that count, in increasing order.
    facets: Vec<u32>,
    /// In increasing order of their vertices.
    edges: Vec<Bend>,
}

/// An edge between two facets.
struct Bend {
    /// Its vertices, the lower first.
    ends: (u32, u32),
    /// The first and the last facet along it.
    facets: (u32, u32),
    /// Angle between the normals, radians; 0 where it is too small to matter.
    angle: f64,
    /// Positive where the surface bends away from the material, negative where it bends towards it.
    turn: f64,
}

impl Bends {
    /// The bends between the facets for which `use_facet` holds.
    ///
    /// # Cost
    /// One sort of the edges.
    pub fn of(mesh: &TriangleMesh, use_facet: impl Fn(usize) -> bool + Sync) -> Self {
        let counts = |f: &u32| use_facet(*f as usize) && norm2(mesh.normal(*f as usize)) > 0.0;
        let facets: Vec<u32> = (0..mesh.triangles.len() as u32).into_par_iter().filter(counts).collect();
        let of_facet = |&facet: &u32| {
            let [a, b, c] = mesh.triangles[facet as usize];
            [(a, b), (b, c), (c, a)].map(|(p, q)| (u64::from(p.min(q)) << 32 | u64::from(p.max(q)), facet))
        };
        let sides: Vec<[(u64, u32); 3]> = facets.par_iter().map(of_facet).collect();
        let mut sides = sides.into_flattened();
        sides.par_sort_unstable();
        let ends = |key: u64| ((key >> 32) as u32, key as u32);
        let shared = sides.chunk_by(|a, b| a.0 == b.0).filter_map(|e| {
            let (&(key, f), &(_, g)) = (e.first()?, e.last()?);
            (f != g).then(|| (ends(key), (f, g)))
        });
        let shared: Vec<_> = shared.collect();
        let edges = shared.into_par_iter().map(|(ends, facets)| Bend::of(mesh, ends, facets)).collect();
        Bends { facets, edges }
    }
}

impl Bend {
    fn of(mesh: &TriangleMesh, ends: (u32, u32), facets: (u32, u32)) -> Self {
        let (m, n) = (mesh.normal(facets.0 as usize), mesh.normal(facets.1 as usize));
        let bend = angle(m, n);
        if bend < 1e-7 {
            return Bend { ends, facets, angle: 0.0, turn: 0.0 };
        }
        let (a, b) = (mesh.vertices[ends.0 as usize], mesh.vertices[ends.1 as usize]);
        // The edge in the direction in which the first facet runs along it.
        let t = mesh.triangles[facets.0 as usize];
        let forward = (0..3).any(|e| t[e] == ends.0 && t[(e + 1) % 3] == ends.1);
        let along = if forward { sub(b, a) } else { sub(a, b) };
        Bend { ends, facets, angle: bend, turn: dot(cross(m, n), along) }
    }

    /// Whether it bends towards a ball on the side.
    fn is_reflex(&self, side: Side) -> bool {
        self.turn * side.sign() < 0.0
    }

    fn feature(&self, mesh: &TriangleMesh, sign: f64) -> Feature {
        let (m, n) = (mesh.normal(self.facets.0 as usize), mesh.normal(self.facets.1 as usize));
        let (a, b) = (mesh.vertices[self.ends.0 as usize], mesh.vertices[self.ends.1 as usize]);
        Feature {
            corners: [a, b, b],
            axis: scale(unit(add(m, n)), sign),
            spread: 0.5 * self.angle,
            slack: 0.0,
            arc: [scale(m, sign), scale(n, sign)],
            facet: self.facets.0.min(self.facets.1),
            beside: self.facets.0.max(self.facets.1),
        }
    }
}

/// Vertices whose sharp edges all bend towards the ball: tips of pits (material) or of spikes (void).
fn vertices(mesh: &TriangleMesh, sharp: &[&Bend], edges: &[Feature], reflex: &[bool]) -> Vec<Feature> {
    let mut at: Vec<(u32, usize)> =
        sharp.iter().enumerate().flat_map(|(i, b)| [(b.ends.0, i), (b.ends.1, i)]).collect();
    at.par_sort_unstable();
    let tip = |meeting: &[(u32, usize)]| {
        let &[(v, first), _, _, ..] = meeting else { return None };
        if !meeting.iter().all(|(_, i)| reflex[*i]) {
            return None;
        }
        let meeting = || meeting.iter().map(|(_, i)| &edges[*i]);
        let axis = unit(meeting().fold([0.0; 3], |s, e| add(s, e.axis)));
        let spread = meeting().map(|e| angle(axis, e.axis) + e.spread).fold(0.0, f64::max);
        let p = mesh.vertices[v as usize];
        (norm2(axis) > 0.0 && spread < 1.5).then_some(Feature {
            corners: [p; 3],
            axis,
            spread,
            slack: 0.0,
            arc: [axis; 2],
            facet: edges[first].facet,
            beside: edges[first].facet,
        })
    };
    at.chunk_by(|a, b| a.0 == b.0).filter_map(tip).collect()
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
