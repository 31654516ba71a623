//! Finer facets where a surface is curved.

use super::mesh::TriangleMesh;
use super::vector::{Vec3, add, angle, cross, distance, dot, norm2, scale};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

/// How often an edge is halved at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Halvings {
    One,
    Two,
}

/// An edge that rises by more than this share of its length crosses a crease: an arc that turns by a radian rises so far.
const CREASED: f64 = 0.125;

/// The mesh with a new vertex `project(midpoint)` on every edge that a curved surface leaves by more than `sagitta`
/// millimetres. At [`Halvings::Two`] the halves are split once more where the new vertex rose by more than four times that.
///
/// Normals at an edge's ends tell which midpoints to project: an arc of length l that turns by α rises α·l/8 above its chord.
/// A crease has no one normal, so that the flat edges that end there are tried, too, and left as they are.
///
/// Facets are split by their halved edges into two, three or four; a closed manifold mesh stays one, in formats of f32
/// coordinates, too: vertices that would coincide stay at their midpoints.
///
/// # Cost
/// O(facets), a hash look-up for each tried edge of each facet, one projection for each tried edge.
pub fn split_curved_edges(
    mesh: &TriangleMesh,
    sagitta: f64,
    halvings: Halvings,
    project: impl Fn(Vec3) -> Vec3 + Sync,
) -> TriangleMesh {
    let normals = vertex_normals(mesh);
    let curved = |[a, b]: [u32; 2]| {
        let [p, q] = [a, b].map(|v| mesh.vertices[v as usize]);
        let (m, n, rise) = (normals[a as usize], normals[b as usize], 8.0 * sagitta / distance(p, q));
        // Below a right angle it is at least its sine and at most π/2 of it, which is cheaper.
        let (sine2, rise2) = (norm2(cross(m, n)), rise * rise * norm2(m) * norm2(n));
        match dot(m, n) > 0.0 {
            true if sine2 < 0.39 * rise2 => false,
            true if sine2 > 1.001 * rise2 => true,
            _ => angle(m, n) > rise,
        }
    };
    let marked = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]].map(|[s, e]| curved([s.min(e), s.max(e)]));
    let marked: Vec<[bool; 3]> = mesh.triangles.par_iter().map(marked).collect();
    let halved = Halved::of(mesh, &marked, sagitta, &project);
    let (once, along) = halved.split(mesh);
    if halvings == Halvings::One {
        return once;
    }
    let deep = halved.deep(sagitta);
    let still = |along: &[u32; 3]| along.map(|edge| deep.get(edge as usize) == Some(&true));
    let marked: Vec<[bool; 3]> = along.par_iter().map(still).collect();
    Halved::of(&once, &marked, sagitta, &project).split(&once).0
}

/// No edge that is halved.
const NONE: u32 = u32::MAX;

/// Edges of a mesh that are halved.
struct Halved {
    /// For each edge of each facet, its number among them: [`NONE`] if it is not.
    edges: Vec<[u32; 3]>,
    /// The ends of each.
    ends: Vec<[Vec3; 2]>,
    /// The new vertex of each.
    vertices: Vec<Vec3>,
}

fn middle([p, q]: [Vec3; 2]) -> Vec3 {
    scale(add(p, q), 0.5)
}

impl Halved {
    /// Those of the marked edges whose middle is farther than `sagitta` off the surface.
    fn of(mesh: &TriangleMesh, marked: &[[bool; 3]], sagitta: f64, project: &(impl Fn(Vec3) -> Vec3 + Sync)) -> Self {
        let mut numbers: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        let mut tried: Vec<[u32; 2]> = Vec::new();
        let mut number = |edge: [u32; 2]| {
            *numbers.entry(edge).or_insert_with(|| {
                tried.push(edge);
                tried.len() as u32 - 1
            })
        };
        let numbered = |(&[a, b, c], &marks): (&[u32; 3], &[bool; 3])| {
            let edges = [(a, b, marks[0]), (b, c, marks[1]), (c, a, marks[2])];
            edges.map(|(s, e, mark)| if mark { number([s.min(e), s.max(e)]) } else { NONE })
        };
        let mut edges: Vec<[u32; 3]> = mesh.triangles.iter().zip(marked).map(numbered).collect();
        let placed = |edge: &[u32; 2]| {
            let ends = edge.map(|v| mesh.vertices[v as usize]);
            (ends, project(middle(ends)))
        };
        let tried: Vec<([Vec3; 2], Vec3)> = tried.par_iter().map(placed).collect();
        let rises = |&(ends, p): &([Vec3; 2], Vec3)| distance(middle(ends), p) > sagitta;
        let mut count = 0..;
        let kept: Vec<u32> =
            tried.iter().map(|edge| if rises(edge) { count.next().unwrap_or(NONE) } else { NONE }).collect();
        edges.par_iter_mut().flatten().for_each(|edge| *edge = kept.get(*edge as usize).copied().unwrap_or(NONE));
        let (ends, mut vertices): (Vec<[Vec3; 2]>, Vec<Vec3>) = tried.into_iter().filter(rises).unzip();
        keep_apart(&mesh.vertices, &mut vertices, &ends);
        Halved { edges, ends, vertices }
    }

    /// Which of them rise so far that their halves still do, by a quarter of it, but do not cross a crease.
    fn deep(&self, sagitta: f64) -> Vec<bool> {
        let deep = |(&[a, b], &p): (&[Vec3; 2], &Vec3)| {
            let rise = distance(p, middle([a, b]));
            0.25 * rise > sagitta && rise < CREASED * distance(a, b)
        };
        self.ends.iter().zip(&self.vertices).map(deep).collect()
    }

    /// The mesh of their halves; and for each edge of each of its facets, which of them it is half of, or runs beside and
    /// turns as far as half of: [`NONE`] if none.
    fn split(&self, mesh: &TriangleMesh) -> (TriangleMesh, Vec<[u32; 3]>) {
        let known = mesh.vertices.len() as u32;
        let (mut triangles, mut along) =
            (Vec::with_capacity(mesh.triangles.len()), Vec::with_capacity(self.edges.len()));
        for (&facet, edges) in mesh.triangles.iter().zip(&self.edges) {
            let middles = edges.map(|edge| (edge != NONE).then(|| known + edge));
            for (triangle, beside) in split(facet, middles) {
                triangles.push(triangle);
                along.push(beside.map(|middle| middle.map_or(NONE, |middle| middle - known)));
            }
        }
        let vertices = [&mesh.vertices[..], &self.vertices].concat();
        (TriangleMesh { vertices, triangles }, along)
    }
}

/// Puts new vertices that would coincide with others at the middles of their edges.
///
/// Sheets that meet in a ridge are projected onto the same points there. Formats without indices join vertices that are
/// equal in f32, and edges of four facets would come of it.
fn keep_apart(vertices: &[Vec3], projected: &mut [Vec3], edges: &[[Vec3; 2]]) {
    let place = |p: &Vec3| p.map(|x| (x as f32 + 0.0).to_bits());
    let mut new_at: FxHashMap<[u32; 3], u32> = FxHashMap::default();
    for p in projected.iter() {
        *new_at.entry(place(p)).or_default() += 1;
    }
    let met: FxHashSet<[u32; 3]> =
        vertices.par_iter().map(place).filter(|at| new_at.contains_key(at)).collect::<Vec<_>>().into_iter().collect();
    let apart = |p: &Vec3| new_at.get(&place(p)) == Some(&1) && !met.contains(&place(p));
    for (p, &ends) in projected.iter_mut().zip(edges) {
        if !apart(p) {
            *p = middle(ends);
        }
    }
}

/// The parts of a facet cut by the new vertices on its edges ab, bc, ca; with the edge of each of their edges that it is half
/// of or turns as far as, named by its new vertex.
///
/// A part's edge between two new vertices runs along the third edge; one from a new vertex to the corner beyond turns as far
/// as half of the edge that it starts on if that is beside one that is flat.
fn split([a, b, c]: [u32; 3], middles: [Option<u32>; 3]) -> impl Iterator<Item = ([u32; 3], [Option<u32>; 3])> {
    let [d, e, f] = middles;
    let (parts, count) = match middles {
        [None, None, None] => ([([a, b, c], [None; 3]); 4], 1),
        [Some(m), None, None] => ([([a, m, c], [d, None, None]), ([m, b, c], [d, None, None]), NOTHING, NOTHING], 2),
        [None, Some(m), None] => ([([a, b, m], [None, e, None]), ([a, m, c], [None, e, None]), NOTHING, NOTHING], 2),
        [None, None, Some(m)] => ([([a, b, m], [None, None, f]), ([m, b, c], [None, None, f]), NOTHING, NOTHING], 2),
        [Some(m), Some(n), None] => {
            ([([m, b, n], [d, e, None]), ([a, m, n], [d, None, e]), ([a, n, c], [e, e, None]), NOTHING], 3)
        }
        [None, Some(m), Some(n)] => {
            ([([m, c, n], [e, f, None]), ([a, b, m], [None, e, e]), ([a, m, n], [e, None, f]), NOTHING], 3)
        }
        [Some(m), None, Some(n)] => {
            ([([a, m, n], [d, None, f]), ([m, b, c], [d, None, d]), ([m, c, n], [d, f, None]), NOTHING], 3)
        }
        [Some(k), Some(m), Some(n)] => {
            ([([a, k, n], [d, e, f]), ([k, b, m], [d, e, f]), ([n, m, c], [d, e, f]), ([k, m, n], [f, d, e])], 4)
        }
    };
    parts.into_iter().take(count)
}

/// In place of a part that there is not.
const NOTHING: ([u32; 3], [Option<u32>; 3]) = ([0; 3], [None; 3]);

/// Area vectors of the facets around each vertex, summed in the order of the facets.
fn vertex_normals(mesh: &TriangleMesh) -> Vec<Vec3> {
    let areas: Vec<Vec3> = (0..mesh.triangles.len()).into_par_iter().map(|f| mesh.area_vector(f)).collect();
    let mut normals = vec![[0.0; 3]; mesh.vertices.len()];
    for (facet, &area) in mesh.triangles.iter().zip(&areas) {
        for &v in facet {
            normals[v as usize] = add(normals[v as usize], area);
        }
    }
    normals
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::units::Length;
    use std::collections::HashSet;

    #[test]
    fn a_refined_ball_is_closed_and_its_edges_are_split_twice() {
        let ball = Primitive::parse("ball:2mm").unwrap();
        let coarse = ball.mesh(Length::mm(0.02));
        let fine = split_curved_edges(&coarse, 0.001, Halvings::Two, |p| scale(p, 2.0 / super::super::vector::norm(p)));
        let edges: HashSet<(u32, u32)> =
            fine.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        assert_eq!(edges.len(), 3 * fine.triangles.len());
        assert!(edges.iter().all(|&(s, e)| edges.contains(&(e, s))));
        let missing = |mesh: &TriangleMesh| ball.volume().as_mm3() - mesh.signed_volume();
        // Edges of 0.02 mm rise become of 0.005, and those of 0.00125: but the flattest are split once.
        assert!(
            missing(&fine) > 0.0 && missing(&fine) < missing(&coarse) / 8.0,
            "{} {}",
            missing(&fine),
            missing(&coarse)
        );
    }

    #[test]
    fn flat_faces_are_left_alone() {
        // A box has curved edges only along its rims, as far as vertex normals tell; a coarse bound marks none.
        let cube = Primitive::parse("box:2x2x2mm").unwrap().mesh(Length::mm(1.0));
        assert_eq!(split_curved_edges(&cube, 10.0, Halvings::Two, |p| p), cube);
    }
}
