//! Hanging facets and the slivers between them.

use super::bridge::slope;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, cross, distance, norm, norm2, sub};
use rustc_hash::FxHashMap;

/// A facet narrower than this, in millimetres, has no direction worth judging.
const SLIVER: f64 = 0.01;

/// How far a coordinate step can turn a facet, radians.
pub fn turned_by([a, b, c]: [Vec3; 3], step: f64) -> f64 {
    let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
    let height = norm(cross(sub(b, a), sub(c, a))) / longest;
    if height > 0.0 { 2.0 * step / height } else { f64::INFINITY }
}

/// The hanging facets with their normals, and behind them the slivers that continue them: each with the normal of the facet it
/// continues, for its own is what the steps of the coordinates make of it.
pub(super) fn with_slivers(mesh: &TriangleMesh, hanging: &[u32], step: f64) -> Vec<(u32, Vec3)> {
    let mut list: Vec<(u32, Vec3)> = hanging.iter().map(|&f| (f, mesh.normal(f as usize))).collect();
    let mut taken = vec![false; mesh.triangles.len()];
    hanging.iter().for_each(|&f| taken[f as usize] = true);
    let narrow = |f: usize| {
        let [a, b, c] = mesh.corners(f);
        let longest2 = norm2(sub(b, a)).max(norm2(sub(c, b))).max(norm2(sub(a, c)));
        norm2(mesh.area_vector(f)) < SLIVER * SLIVER * longest2
    };
    let slivers: Vec<usize> = (0..mesh.triangles.len()).filter(|&f| !taken[f] && narrow(f)).collect();
    if slivers.is_empty() {
        return list;
    }
    let mut normals: FxHashMap<(u32, u32), Vec3> = FxHashMap::default();
    let edges = |f: usize| {
        let t = mesh.triangles[f];
        [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])].map(|(a, b)| (a.min(b), a.max(b)))
    };
    // Only edges that a sliver may have are asked for.
    let mut narrow_at = vec![false; mesh.vertices.len()];
    slivers.iter().flat_map(|&f| mesh.triangles[f]).for_each(|v| narrow_at[v as usize] = true);
    for &f in hanging {
        let asked = edges(f as usize).into_iter().filter(|e| narrow_at[e.0 as usize] && narrow_at[e.1 as usize]);
        normals.extend(asked.map(|e| (e, mesh.normal(f as usize))));
    }
    // A chain of slivers is followed for a few links.
    for _ in 0..4 {
        for &f in &slivers {
            let continued = edges(f).into_iter().find_map(|e| normals.get(&e).copied());
            let doubt = turned_by(mesh.corners(f), step);
            let looks_down = doubt.is_infinite() || slope(mesh, f as u32) < std::f64::consts::FRAC_PI_4 + doubt;
            if let Some(normal) = continued.filter(|_| !taken[f] && looks_down) {
                taken[f] = true;
                list.push((f as u32, normal));
                normals.extend(edges(f).map(|e| (e, normal)));
            }
        }
    }
    list
}
