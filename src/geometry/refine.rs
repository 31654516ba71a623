//! Finer facets where a surface is curved.

use super::mesh::TriangleMesh;
use super::vector::{Vec3, add, angle, cross, distance, dot, norm2, scale};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

/// The mesh with a new vertex `project(midpoint)` on every edge that a curved surface leaves by more than `sagitta`
/// millimetres, as far as the normals at its ends tell: an arc of length l that turns by α rises α·l/8 above its chord.
///
/// Facets are split by their marked edges into two, three or four; a closed manifold mesh stays one, in formats of f32
/// coordinates, too: vertices that would coincide stay at their midpoints.
///
/// # Cost
/// O(facets), a hash look-up for each marked edge of each facet, one projection for each marked edge.
pub fn split_curved_edges(mesh: &TriangleMesh, sagitta: f64, project: impl Fn(Vec3) -> Vec3 + Sync) -> TriangleMesh {
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
    let marked: Vec<[bool; 3]> = mesh
        .triangles
        .par_iter()
        .map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(|[s, e]| curved([s.min(e), s.max(e)])))
        .collect();
    let mut numbers: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let mut midpoints = Vec::new();
    let mut triangles = Vec::with_capacity(mesh.triangles.len());
    for (&[a, b, c], &marks) in mesh.triangles.iter().zip(&marked) {
        let mut middle = |s: u32, e: u32, mark: bool| {
            mark.then(|| {
                *numbers.entry([s.min(e), s.max(e)]).or_insert_with(|| {
                    midpoints.push(scale(add(mesh.vertices[s as usize], mesh.vertices[e as usize]), 0.5));
                    (mesh.vertices.len() + midpoints.len() - 1) as u32
                })
            })
        };
        let middles = [middle(a, b, marks[0]), middle(b, c, marks[1]), middle(c, a, marks[2])];
        split(&mut triangles, [a, b, c], middles);
    }
    let projected: Vec<Vec3> = midpoints.par_iter().map(|&p| project(p)).collect();
    let mut vertices = mesh.vertices.clone();
    vertices.extend(kept_apart(&mesh.vertices, projected, &midpoints));
    TriangleMesh { vertices, triangles }
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

/// A facet cut by the new vertices on its edges ab, bc, ca.
fn split(triangles: &mut Vec<[u32; 3]>, [a, b, c]: [u32; 3], middles: [Option<u32>; 3]) {
    match middles {
        [None, None, None] => triangles.push([a, b, c]),
        [Some(d), None, None] => triangles.extend([[a, d, c], [d, b, c]]),
        [None, Some(e), None] => triangles.extend([[a, b, e], [a, e, c]]),
        [None, None, Some(f)] => triangles.extend([[a, b, f], [f, b, c]]),
        [Some(d), Some(e), None] => triangles.extend([[d, b, e], [a, d, e], [a, e, c]]),
        [None, Some(e), Some(f)] => triangles.extend([[e, c, f], [a, b, e], [a, e, f]]),
        [Some(d), None, Some(f)] => triangles.extend([[a, d, f], [d, b, c], [d, c, f]]),
        [Some(d), Some(e), Some(f)] => triangles.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]),
    }
}

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
    fn a_refined_ball_is_closed_and_four_times_rounder() {
        let ball = Primitive::parse("ball:2mm").unwrap();
        let coarse = ball.mesh(Length::mm(0.02));
        let fine = split_curved_edges(&coarse, 0.001, |p| scale(p, 2.0 / super::super::vector::norm(p)));
        let edges: HashSet<(u32, u32)> =
            fine.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        assert_eq!(edges.len(), 3 * fine.triangles.len());
        assert!(edges.iter().all(|&(s, e)| edges.contains(&(e, s))));
        let missing = |mesh: &TriangleMesh| ball.volume().as_mm3() - mesh.signed_volume();
        assert!(missing(&fine) > 0.0 && missing(&fine) < missing(&coarse) / 3.0);
    }

    #[test]
    fn flat_faces_are_left_alone() {
        // A box has curved edges only along its rims, as far as vertex normals tell; a coarse bound marks none.
        let cube = Primitive::parse("box:2x2x2mm").unwrap().mesh(Length::mm(1.0));
        assert_eq!(split_curved_edges(&cube, 10.0, |p| p), cube);
    }
}
