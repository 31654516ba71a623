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
/// millimetres, as far as the normals at its ends tell: an arc of length l that turns by α rises α·l/8 above its chord.
/// At [`Halvings::Two`] the halves are split once more where the new vertex rose by more than four times that.
///
/// Facets are split by their marked edges into two, three or four; a closed manifold mesh stays one, in formats of f32
/// coordinates, too: vertices that would coincide stay at their midpoints.
///
/// # Cost
/// O(facets), a hash look-up for each marked edge of each facet, one projection for each marked edge.
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
    let once = Split::of(mesh, &marked, &project);
    if halvings == Halvings::One {
        return once.mesh;
    }
    let deep: Vec<bool> = once.rises.iter().map(|rise| 0.25 * rise > sagitta).collect();
    let still = |along: &[u32; 3]| along.map(|edge| deep.get(edge as usize) == Some(&true));
    let marked: Vec<[bool; 3]> = once.along.par_iter().map(still).collect();
    Split::of(&once.mesh, &marked, &project).mesh
}

/// No edge that was split.
const NONE: u32 = u32::MAX;

/// A mesh whose marked edges were split.
struct Split {
    mesh: TriangleMesh,
    /// How far the middle of each edge that was split lay off the surface; 0 for edges across a crease.
    rises: Vec<f64>,
    /// For each edge of each facet, which of those it is half of, or runs beside and turns as far as half of: [`NONE`] if none.
    along: Vec<[u32; 3]>,
}

impl Split {
    fn of(mesh: &TriangleMesh, marked: &[[bool; 3]], project: &(impl Fn(Vec3) -> Vec3 + Sync)) -> Self {
        let mut numbers: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        let (mut midpoints, mut lengths) = (Vec::new(), Vec::new());
        let (mut triangles, mut along) = (Vec::with_capacity(mesh.triangles.len()), Vec::with_capacity(marked.len()));
        let known = mesh.vertices.len() as u32;
        for (&[a, b, c], &marks) in mesh.triangles.iter().zip(marked) {
            let mut middle = |s: u32, e: u32, mark: bool| {
                mark.then(|| {
                    *numbers.entry([s.min(e), s.max(e)]).or_insert_with(|| {
                        let [p, q] = [s, e].map(|v| mesh.vertices[v as usize]);
                        midpoints.push(scale(add(p, q), 0.5));
                        lengths.push(distance(p, q));
                        known + midpoints.len() as u32 - 1
                    })
                })
            };
            let middles = [middle(a, b, marks[0]), middle(b, c, marks[1]), middle(c, a, marks[2])];
            for (triangle, beside) in split([a, b, c], middles) {
                triangles.push(triangle);
                along.push(beside.map(|edge| edge.map_or(NONE, |middle| middle - known)));
            }
        }
        let projected: Vec<Vec3> = midpoints.par_iter().map(|&p| project(p)).collect();
        let placed = kept_apart(&mesh.vertices, projected, &midpoints);
        let rise = |((p, q), length): ((&Vec3, &Vec3), &f64)| {
            let rise = distance(*p, *q);
            if rise < CREASED * length { rise } else { 0.0 }
        };
        let rises = placed.iter().zip(&midpoints).zip(&lengths).map(rise).collect();
        let mut vertices = mesh.vertices.clone();
        vertices.extend(placed);
        Split { mesh: TriangleMesh { vertices, triangles }, rises, along }
    }
}

/// The new vertices; where one would coincide with another, its midpoint instead.
///
/// Sheets that meet in a ridge are projected onto the same points there. Formats without indices join vertices that are
/// equal in f32, and edges of four facets would come of it.
fn kept_apart(vertices: &[Vec3], projected: Vec<Vec3>, midpoints: &[Vec3]) -> Vec<Vec3> {
    let place = |p: &Vec3| p.map(|x| (x as f32 + 0.0).to_bits());
    let mut new_at: FxHashMap<[u32; 3], u32> = FxHashMap::default();
    for p in &projected {
        *new_at.entry(place(p)).or_default() += 1;
    }
    let met: FxHashSet<[u32; 3]> =
        vertices.par_iter().map(place).filter(|at| new_at.contains_key(at)).collect::<Vec<_>>().into_iter().collect();
    let apart = |p: &Vec3| new_at.get(&place(p)) == Some(&1) && !met.contains(&place(p));
    projected.into_iter().zip(midpoints).map(|(p, &middle)| if apart(&p) { p } else { middle }).collect()
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
