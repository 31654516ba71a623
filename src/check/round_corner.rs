//! The corners of a round, which tell how large it is, and the edges that only divide its facets.

use crate::geometry::vector::{Vec3, along, angle, cross, distance, dot, norm, sub, unit};
use crate::medial::reflex::ReflexEdge;
use crate::part::Part;
use std::ops::ControlFlow;

/// An edge bent by less than this share of what a corner beside it is bent by divides a facet.
const DIVIDES: f64 = 1.0 / 3.0;
/// Edges that run in directions closer than this run side by side, radians (15°).
const SIDE_BY_SIDE: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Edges that divide a facet beside a corner and are crossed at most.
const CROSSED: usize = 3;

/// By how much a round bends at an edge: between the widest pieces of the facets beside it, where further edges divide these.
///
/// A ball touches the facets, and stays as far from the corner between them as they are bent there, however the corner itself was cut.
pub(super) fn corner_bend(part: &Part, edge: &ReflexEdge) -> f64 {
    let [one, other] = edge.facets;
    let normal = |facets| Beside::of(part, edge, facets).normal;
    angle(normal([other, one]), normal([one, other])).max(edge.bend)
}

/// The radius of the round whose chords both facets beside an edge are, with all the pieces that further edges divide them into: 2·r·sin(φ/2) is
/// as far as the wider of them goes, for what ends a round may have cut the other short.
pub(super) fn chord_radius(part: &Part, edge: &ReflexEdge) -> f64 {
    let [one, other] = edge.facets;
    let [a, b] = [[other, one], [one, other]].map(|facets| Beside::of(part, edge, facets).reach);
    a.max(b) / (2.0 * (0.5 * edge.bend).sin())
}

/// A facet beside an edge, in however many pieces.
struct Beside {
    /// The normal of the widest piece.
    normal: Vec3,
    /// How far the farthest corner of any is from the line of the edge.
    reach: f64,
}

impl Beside {
    /// The facet that is entered over an edge from another one.
    fn of(part: &Part, edge: &ReflexEdge, [mut from, mut facet]: [u32; 2]) -> Self {
        let (mesh, surface) = (part.mesh(), part.distance());
        let [p, q] = edge.ends.map(|v| mesh.vertices[v as usize]);
        let run = unit(sub(q, p));
        let off = |facet: u32| {
            let corners = mesh.corners(facet as usize).map(|c| norm(cross(sub(c, p), run)));
            corners.into_iter().fold(0.0, f64::max)
        };
        let (mut widest, mut normal) = (width(part, facet), surface.normal(facet));
        let mut beside = Beside { normal, reach: off(facet) };
        for _ in 0..CROSSED {
            let corners = mesh.corners(facet as usize);
            let divides = |e: usize| {
                let to = part.adjacency().across(facet, e).filter(|to| *to != from)?;
                let is_alike = || angle(normal, surface.normal(to)) < DIVIDES * edge.bend;
                let goes_on = width(part, to) == 0.0 || is_alike();
                (goes_on && runs_along(run, [corners[e], corners[(e + 1) % 3]])).then_some(to)
            };
            let Some(to) = (0..3).find_map(divides) else { break };
            (from, facet) = (facet, to);
            beside.reach = beside.reach.max(off(facet));
            let wide = width(part, facet);
            if wide > 0.0 {
                normal = surface.normal(facet);
            }
            if wide > widest {
                (widest, beside.normal) = (wide, normal);
            }
        }
        beside
    }
}

/// How wide a facet is across its longest side.
fn width(part: &Part, facet: u32) -> f64 {
    let [a, b, c] = part.distance().corners(facet);
    let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
    2.0 * part.mesh().facet_area(facet as usize) / longest.max(f64::MIN_POSITIVE)
}

/// Whether an edge runs side by side with a direction.
fn runs_along(run: Vec3, [p, q]: [Vec3; 2]) -> bool {
    norm(cross(unit(sub(q, p)), run)) <= SIDE_BY_SIDE.sin()
}

/// Whether an edge divides a facet of a round of at most some radius: a corner runs beside it, bent by more than three times as much but no
/// sharp edge, no further away than the facets of such a round are wide there.
///
/// A ball touches a facet in the middle of its width; from what divides it further out it stays away as from a corner.
///
/// # Cost
/// A look at the facets within a radius.
pub(super) fn divides_a_facet(part: &Part, edge: &ReflexEdge, radius: f64, sharp_bend: f64) -> bool {
    let vertices = &part.mesh().vertices;
    let [p, q] = edge.ends.map(|v| vertices[v as usize]);
    let run = unit(sub(q, p));
    let wide = |bend: f64| 2.0 * radius * (0.5 * bend).tan();
    let mut found = false;
    part.distance().within(edge.middle, wide(sharp_bend), |near| {
        found = corners_of(part, near.facet).any(|(bend, ends)| {
            let is_corner = bend * DIVIDES > edge.bend && bend <= sharp_bend;
            is_corner && runs_along(run, ends) && away(edge.middle, ends) <= wide(bend)
        });
        if found { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    found
}

/// The concave edges of a facet: by how much they are bent, and their ends.
fn corners_of(part: &Part, facet: u32) -> impl Iterator<Item = (f64, [Vec3; 2])> + '_ {
    let (mesh, surface) = (part.mesh(), part.distance());
    let corners = mesh.corners(facet as usize);
    (0..3).filter_map(move |e| {
        let other = part.adjacency().across(facet, e)?;
        let ends = [corners[e], corners[(e + 1) % 3]];
        let rises = dot(surface.normal(facet), sub(mesh.centroid(other as usize), ends[0])) > 0.0;
        rises.then(|| (angle(surface.normal(facet), surface.normal(other)), ends))
    })
}

/// How far a point is from an edge.
fn away(from: Vec3, [p, q]: [Vec3; 2]) -> f64 {
    let way = unit(sub(q, p));
    distance(from, along(p, way, dot(sub(from, p), way).clamp(0.0, distance(p, q))))
}
