//! The strip of material along a line of sharp edges, up to the depth at which it is no longer thin.

use super::crease::{Crease, inward};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, add, distance, dot, sub, unit};
use std::collections::BTreeMap;

/// Strips that turn away from each other are joined up to where they meet, but for what lies beyond a right angle.
const MITRE: f64 = -1.0;

/// The area of the strip along creases that follow each other, between both sides of the wedge, mm².
///
/// Each crease has a strip as long as itself and as wide as its depth; where the next one turns by θ, as seen along the strips, both end at the
/// line that halves the angle between them. So a strip is narrower by tan(θ/2) at each such end for each millimetre inwards, and where a
/// line bends inwards nothing counts twice: a disc of radius R that is sharp all round has π·(R² − (R − d)²).
///
/// # Cost
/// O(creases · log creases).
pub fn strip_area(mesh: &TriangleMesh, line: &[&Crease]) -> f64 {
    let mut at: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (n, crease) in line.iter().enumerate() {
        crease.ends.iter().for_each(|&v| at.entry(v).or_default().push(n));
    }
    let narrowing = |n: usize, vertex: u32| {
        let others = at.get(&vertex).into_iter().flatten().filter(|&&other| other != n);
        match others.filter_map(|&other| line.get(other)).collect::<Vec<_>>()[..] {
            [other] => half_turn(mesh, [line[n], other], vertex).map_or(0.0, |turn| turn.tan().max(MITRE)),
            _ => 0.0,
        }
    };
    let strip = |n: usize, crease: &Crease| {
        let [a, b] = crease.ends.map(|v| mesh.vertices[v as usize]);
        let (long, narrows) = (distance(a, b), crease.ends.map(|v| narrowing(n, v)).iter().sum::<f64>());
        let deep = if narrows > 0.0 { crease.depth.min(long / narrows) } else { crease.depth };
        deep * (long - 0.5 * narrows * deep)
    };
    line.iter().enumerate().map(|(n, crease)| strip(n, crease)).sum()
}

/// Half the angle by which a line turns towards the material from one crease to the next at a vertex that both have, as seen along their strips.
fn half_turn(mesh: &TriangleMesh, [from, to]: [&Crease; 2], vertex: u32) -> Option<f64> {
    let point = |v: u32| mesh.vertices[v as usize];
    let away = |c: &Crease| c.ends.into_iter().find(|v| *v != vertex).map(|v| unit(sub(point(v), point(vertex))));
    let turn: Vec3 = add(away(from)?, away(to)?);
    let into = unit(add(inward(mesh, from)?, inward(mesh, to)?));
    Some((0.5 * dot(turn, into)).clamp(-1.0, 1.0).asin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Adjacency, MeshDistance, extruded, revolved};
    use crate::medial::crease::{Sharpness, creases};

    /// The area along all sharp edges of a mesh up to a thickness, and the sum of length times depth.
    fn areas(mesh: &TriangleMesh, thick: f64) -> [f64; 2] {
        let mesh = if mesh.signed_volume() < 0.0 { mesh.clone().flipped() } else { mesh.clone() };
        let sought = Sharpness { widest: 1.0, thick, blunt: 0.0, step: 1e-9 };
        let found = creases(&mesh, &MeshDistance::new(&mesh), &Adjacency::of(&mesh, |_| true), sought);
        let line: Vec<&Crease> = found.iter().collect();
        let product = |c: &&Crease| crate::medial::crease::length(&mesh, c) * c.depth;
        [strip_area(&mesh, &line), line.iter().map(product).sum()]
    }

    #[test]
    fn a_round_edge_has_a_ring_and_a_straight_one_a_rectangle() {
        // Two cones base to base, 30 degrees at the rim.
        let (radius, half) = (10.0f64, 15f64.to_radians());
        let rise = radius * half.tan();
        let disc = revolved(&[[0.0, -rise], [radius, 0.0], [0.0, rise]], 96);
        let [ring, product] = areas(&disc, 1.2);
        let depth = 0.6 / half.sin();
        let truth = std::f64::consts::PI * (radius.powi(2) - (radius - depth).powi(2));
        assert!((ring / truth - 1.0).abs() < 0.005 && product > 1.1 * truth, "{ring} for {truth}, not {product}");
        let wedge = extruded(&[[0.0, 0.0], [10.0, 10.0 * half.tan()], [10.0, -10.0 * half.tan()]], &[[0, 2, 1]], 8.0);
        let [straight, product] = areas(&wedge, 1.2);
        assert!((straight - 8.0 * depth).abs() < 1e-6 && (product - straight).abs() < 1e-9, "{straight}");
    }

    #[test]
    fn edges_round_a_square_share_its_corners() {
        // A pyramid on its mirror image, 16 mm wide, 30 degrees at the edges.
        let (half, high) = (8.0f64, 8.0 * 15f64.to_radians().tan());
        let rim = [[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]];
        let facets = (0..4).flat_map(|n| {
            let [a, b] = [rim[n], rim[(n + 1) % 4]];
            [[a, b, [0.0, 0.0, high]], [b, a, [0.0, 0.0, -high]]]
        });
        let mesh = TriangleMesh::weld(facets);
        let depth = 0.5 / 15f64.to_radians().sin();
        let [area, _] = areas(&mesh, 1.0);
        let truth = 4.0 * (half * half - (half - depth).powi(2));
        assert!((area - truth).abs() < 1e-6, "{area} for {truth}");
    }
}
