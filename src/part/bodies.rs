//! How near the bodies of a part come to each other.

use crate::geometry::health::NO_LABEL;
use crate::geometry::vector::Vec3;
use crate::geometry::{Health, MeshDistance, TriangleMesh};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Two bodies, how near they come, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPair {
    pub bodies: [u32; 2],
    pub distance: f64,
    pub points: [Vec3; 2],
}

/// Nearest points of all bodies whose boxes come within reach.
pub(super) fn body_pairs(mesh: &TriangleMesh, health: &Health, reach: f64) -> Vec<BodyPair> {
    let mut facets: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (f, &body) in health.facet_body.iter().enumerate().filter(|(_, b)| **b != NO_LABEL) {
        facets.entry(body).or_default().push(f);
    }
    if facets.len() < 2 {
        return Vec::new();
    }
    let boxes: Vec<(u32, Vec3, Vec3)> = facets
        .keys()
        .filter_map(|&b| health.bodies.get(b as usize).map(|body| (b, body.box_mm[0], body.box_mm[1])))
        .collect();
    let near = |(a, b): &(&(u32, Vec3, Vec3), &(u32, Vec3, Vec3))| {
        (0..3).all(|x| a.1[x] - b.2[x] < reach && b.1[x] - a.2[x] < reach)
    };
    let mut candidates: Vec<(u32, u32)> = Vec::new();
    for (i, a) in boxes.iter().enumerate() {
        candidates.extend(boxes[i + 1..].iter().filter(|b| near(&(a, b))).map(|b| (a.0, b.0)));
    }
    let needed: std::collections::BTreeSet<u32> = candidates.iter().flat_map(|c| [c.0, c.1]).collect();
    let trees: BTreeMap<u32, MeshDistance> =
        needed.into_par_iter().map(|b| (b, MeshDistance::of_facets(mesh, facets[&b].iter().copied()))).collect();
    candidates
        .par_iter()
        .filter_map(|&(a, b)| {
            let (distance, p, q) = trees[&a].pair_distance(&trees[&b], reach)?;
            Some(BodyPair { bodies: [a, b], distance, points: [p, q] })
        })
        .collect()
}
