//! Cracks in a surface: edges along which more facets run one way than the other.

use crate::geometry::vector::{Vec3, cross, distance, norm, sub};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The triangles that close the cracks of a surface, if none of them is wider than `most_mm`.
///
/// As many facets then run along each edge one way as the other.
///
/// # Cost
/// O(T), and the square of the edges around each crack.
pub(super) fn filling(vertices: &[Vec3], triangles: &[[u32; 3]], most_mm: f64) -> Option<Vec<[u32; 3]>> {
    let mut filled = Vec::new();
    for mut around in cycles(missing(triangles)) {
        while around.len() > 2 {
            let count = around.len();
            let corner = |i: usize| [around[(i + count - 1) % count], around[i], around[(i + 1) % count]];
            let area = |i: usize| twice_area(vertices, corner(i));
            let least = (0..count).min_by(|&i, &j| area(i).total_cmp(&area(j)))?;
            filled.push(corner(least));
            around.remove(least);
        }
    }
    filled.iter().all(|&triangle| width(vertices, triangle) <= most_mm).then_some(filled)
}

/// Whether as many facets run along each edge one way as the other, and there are any.
pub(super) fn is_closed(triangles: &[[u32; 3]]) -> bool {
    !triangles.is_empty() && surplus(triangles).is_empty()
}

/// The edges, from the lesser point to the greater, along which more facets run one way than the other, and by how many more forwards.
fn surplus(triangles: &[[u32; 3]]) -> Vec<([u32; 2], i64)> {
    let edge = |a: u32, b: u32| ([a.min(b), a.max(b)], a < b);
    let of_facet = |&[a, b, c]: &[u32; 3]| [edge(a, b), edge(b, c), edge(c, a)];
    let mut edges: Vec<([u32; 2], bool)> = triangles.par_iter().flat_map_iter(of_facet).collect();
    edges.par_sort_unstable();
    let forwards = |of: &[([u32; 2], bool)]| of.iter().map(|(_, forwards)| if *forwards { 1 } else { -1 }).sum();
    let alike = edges.chunk_by(|a, b| a.0 == b.0);
    alike.filter_map(|of| Some((of.first()?.0, forwards(of)))).filter(|(_, surplus)| *surplus != 0).collect()
}

/// The edges that are missing, from point to point.
fn missing(triangles: &[[u32; 3]]) -> BTreeMap<u32, Vec<u32>> {
    let mut missing: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for ([a, b], surplus) in surplus(triangles) {
        let (from, to) = if surplus > 0 { (b, a) } else { (a, b) };
        missing.entry(from).or_default().extend((0..surplus.abs()).map(|_| to));
    }
    missing
}

/// The cycles without a point twice that directed edges fall into; as many come to each point as go from it.
fn cycles(mut edges: BTreeMap<u32, Vec<u32>>) -> Vec<Vec<u32>> {
    let mut found = Vec::new();
    let starts: Vec<u32> = edges.keys().copied().collect();
    for start in starts {
        let mut path = vec![start];
        while let Some(next) = path.last().and_then(|at| edges.get_mut(at)).and_then(Vec::pop) {
            match path.iter().position(|&p| p == next) {
                Some(first) => {
                    found.push(path[first..].to_vec());
                    path.truncate(first + 1);
                }
                None => path.push(next),
            }
        }
    }
    found
}

fn corners(vertices: &[Vec3], triangle: [u32; 3]) -> [Vec3; 3] {
    triangle.map(|v| vertices.get(v as usize).copied().unwrap_or_default())
}

fn twice_area(vertices: &[Vec3], triangle: [u32; 3]) -> f64 {
    let [a, b, c] = corners(vertices, triangle);
    norm(cross(sub(b, a), sub(c, a)))
}

/// The least height of a triangle.
fn width(vertices: &[Vec3], triangle: [u32; 3]) -> f64 {
    let [a, b, c] = corners(vertices, triangle);
    let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
    if longest > 0.0 { twice_area(vertices, triangle) / longest } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn cracks_are_closed_and_holes_are_not() {
        let mut mesh = cuboid([0.0; 3], [4.0, 4.0, 2.0]);
        assert_eq!(filling(&mesh.vertices, &mesh.triangles, 0.0), Some(Vec::new()));
        // A point within an edge on one side of it, a little beside.
        let [a, b, c] = mesh.triangles[0];
        let [p, q] = [a, b].map(|v| mesh.vertices[v as usize]);
        let between = [0, 1, 2].map(|i| 0.3 * p[i] + 0.7 * q[i] + 1e-6);
        let m = mesh.vertices.len() as u32;
        mesh.vertices.push(between);
        mesh.triangles[0] = [a, m, c];
        mesh.triangles.push([m, b, c]);
        let filled = filling(&mesh.vertices, &mesh.triangles, 1e-5).expect("a crack");
        assert_eq!(filled.len(), 1);
        mesh.triangles.extend(filled);
        assert!(is_closed(&mesh.triangles));
        mesh.triangles.remove(0);
        assert_eq!(filling(&mesh.vertices, &mesh.triangles, 1e-3), None);
    }
}
