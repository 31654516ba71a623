//! Which bodies of a mesh come near each other, how near, and where.

use super::health::NO_LABEL;
use super::vector::Vec3;
use super::{Health, LabelledBox, MeshDistance, TriangleMesh, box_pairs};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Two bodies, how near they come, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPair {
    pub bodies: [u32; 2],
    pub distance: f64,
    pub points: [Vec3; 2],
}

impl BodyPair {
    /// Halfway between the two nearest points.
    pub fn middle(&self) -> Vec3 {
        [0, 1, 2].map(|a| 0.5 * (self.points[0][a] + self.points[1][a]))
    }
}

/// Nearest points of all bodies whose boxes come within reach.
pub fn body_pairs(mesh: &TriangleMesh, health: &Health, reach: f64) -> Vec<BodyPair> {
    let mut facets: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (f, &body) in health.facet_body.iter().enumerate().filter(|(_, b)| **b != NO_LABEL) {
        facets.entry(body).or_default().push(f);
    }
    if facets.len() < 2 {
        return Vec::new();
    }
    let boxes: Vec<LabelledBox> = facets
        .keys()
        .filter_map(|&b| health.bodies.get(b as usize).map(|body| (b, body.box_mm[0], body.box_mm[1])))
        .collect();
    let candidates = box_pairs(boxes, reach);
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
