//! Concave edges that lie in one corner: a ball comes to rest over each of them at the same place.

use super::resting::{Ball, Descent};
use crate::geometry::vector::{Vec3, along, distance, dot, sub, unit};
use crate::medial::reflex::ReflexEdge;
use crate::part::Part;
use rustc_hash::{FxHashMap, FxHashSet};
use std::ops::ControlFlow;

/// Places of a ball that are no further from each other than this share of its radius are one.
const SAME: f64 = 0.1;
/// A ball at rest is no further from an edge of its corner than so many radii: 1/cos 75°.
const DEEPEST: f64 = 3.87;

/// A set of edges, to be asked which of them lie in a corner.
pub(super) struct Corners<'a> {
    part: &'a Part,
    pub radius: f64,
    edges: &'a [ReflexEdge],
    descent: Descent,
    of_facet: FxHashMap<u32, Vec<usize>>,
}

impl<'a> Corners<'a> {
    /// Of some edges and a ball of a radius.
    pub fn new(part: &'a Part, radius: f64, edges: &'a [ReflexEdge]) -> Self {
        let mut of_facet: FxHashMap<u32, Vec<usize>> = FxHashMap::default();
        for (n, edge) in edges.iter().enumerate() {
            edge.facets.iter().for_each(|&f| of_facet.entry(f).or_default().push(n));
        }
        Corners { part, radius, edges, descent: Descent::Straight, of_facet }
    }

    /// As a ball that comes down in some way finds them.
    pub fn entered(self, descent: Descent) -> Self {
        Corners { descent, ..self }
    }

    /// How many of the edges lie in the corner in which the ball is at rest with its centre there.
    ///
    /// # Cost
    /// A look at the facets within four radii, and a ball for each edge of one of them.
    pub fn holding(&self, centre: Vec3) -> usize {
        let mut near = FxHashSet::default();
        self.part.distance().within(centre, DEEPEST * self.radius, |met| {
            near.extend(self.of_facet.get(&met.facet).into_iter().flatten().copied());
            ControlFlow::Continue(())
        });
        let edges = near.iter().filter_map(|&n| self.edges.get(n));
        edges.filter(|edge| self.lies_there(edge, centre)).count()
    }

    /// Whether the ball that comes down over the nearest point of an edge comes to rest with its centre there.
    fn lies_there(&self, edge: &ReflexEdge, centre: Vec3) -> bool {
        let run = run(self.part, edge);
        let half = 0.5 * edge.length;
        let foot = along(edge.middle, run, dot(sub(centre, edge.middle), run).clamp(-half, half));
        let is_near = distance(foot, centre) <= DEEPEST * self.radius;
        let ball = Ball { part: self.part, radius: self.radius, descent: self.descent };
        let rest = || ball.rest(foot, edge.outward(), 0.0);
        is_near && rest().is_some_and(|rest| distance(rest, centre) <= SAME * self.radius)
    }
}

/// Unit vector along an edge.
pub(super) fn run(part: &Part, edge: &ReflexEdge) -> Vec3 {
    let [p, q] = edge.ends.map(|v| part.mesh().vertices.get(v as usize).copied().unwrap_or(edge.middle));
    unit(sub(q, p))
}
