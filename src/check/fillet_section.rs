//! Cross-sections of fillets, and what they add along edges that turn.

use crate::geometry::vector::{Vec3, add, along, angle, distance, dot, scale, sub, unit};
use crate::medial::reflex::ReflexEdge;
use crate::part::Part;
use std::collections::BTreeMap;

/// Steps of the angle on either side of an edge over which a section is measured; even.
const RAYS: usize = 16;
/// Edges that turn by less than this keep their sections apart, radians (120°): what lies between sharper ones is no longer a sector of either.
const SHARPEST: f64 = 120.0 * std::f64::consts::PI / 180.0;

/// What a fillet fills of a plane across its edge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Section {
    /// Square millimetres.
    pub area: f64,
    /// First moment about the edge, ∫ x dA, mm³: its area times the way from the edge to its centroid.
    pub moment: Vec3,
}

impl Section {
    /// The section of a ball between two planes, bent by φ: r²·(tan(φ/2) − φ/2), a kite without the ball's sector.
    pub fn between_planes(edge: &ReflexEdge, radius: f64) -> Self {
        let half = 0.5 * edge.bend;
        let (sine, cosine) = half.sin_cos();
        let [kite, sector] = [radius * radius * half.tan(), radius * radius * half];
        let centre = radius / cosine;
        let contact = radius * half.tan() * sine;
        let out = kite * (centre + contact) / 3.0 - sector * (centre - 2.0 * radius * sine / (3.0 * half));
        Section { area: kite - sector, moment: scale(edge.outward(), out) }
    }

    /// The section under a ball that lies so from its edge, from contact to contact, with the distance ρ from the ball's centre to the surface:
    /// ½·∫ (ρ² − r²) dθ, and its moment ⅓·∫ (ρ³ − r³)·d dθ about the centre.
    pub fn under_a_ball(
        from_edge: Vec3,
        contacts: [Vec3; 2],
        radius: f64,
        surface: impl Fn(Vec3) -> f64 + Copy,
    ) -> Self {
        let down = unit(scale(from_edge, -1.0));
        let sections = contacts.map(|contact| swept(contact, down, radius, surface));
        let area = sections[0].area + sections[1].area;
        Section { area, moment: add(scale(from_edge, area), add(sections[0].moment, sections[1].moment)) }
    }

    /// The part of each of so many edges in a section that they have in common.
    pub fn shared_by(self, edges: usize) -> Self {
        let share = 1.0 / edges.max(1) as f64;
        Section { area: share * self.area, moment: scale(self.moment, share) }
    }

    /// The mean of some sections.
    pub fn mean(sections: &[Section]) -> Self {
        match sections {
            [] => Section::default(),
            // The same at all places is no sum, which would round.
            [first, others @ ..] if others.iter().all(|s| s == first) => *first,
            _ => {
                let share = 1.0 / sections.len() as f64;
                let sum = sections.iter().fold(Section::default(), |sum, s| Section {
                    area: sum.area + s.area,
                    moment: add(sum.moment, s.moment),
                });
                Section { area: share * sum.area, moment: scale(sum.moment, share) }
            }
        }
    }

    /// By how much what a fillet adds along an edge grows at an end from which another one leads on, mm³.
    ///
    /// On the outside of the turn φ each has half of a sector, A·c·φ/2 with the distance c of the centroid from the edge; on the inside both are
    /// cut at half the turn, −A·c·tan(φ/2). In a ring of many edges either is what Pappus' theorem says.
    fn growth(&self, leaves: Vec3, leads_on: Vec3) -> f64 {
        let turn = angle(leaves, leads_on);
        if turn > SHARPEST {
            return 0.0;
        }
        let inwards = dot(self.moment, unit(along(leads_on, leaves, -dot(leads_on, leaves))));
        if inwards > 0.0 { -inwards * (0.5 * turn).tan() } else { -inwards * 0.5 * turn }
    }
}

/// A section's part from one direction of the ball's centre to another, about that, by Simpson's rule.
fn swept(from: Vec3, to: Vec3, radius: f64, surface: impl Fn(Vec3) -> f64) -> Section {
    let turn = angle(from, to);
    let level = unit(along(to, from, -dot(from, to)));
    let mut whole = Section::default();
    for n in 0..=RAYS {
        let (s, c) = (turn * n as f64 / RAYS as f64).sin_cos();
        let towards = along(scale(from, c), level, s);
        let far = surface(towards).max(radius);
        let weight = if n == 0 || n == RAYS { 1.0 } else { [2.0, 4.0][n % 2] } * turn / (3.0 * RAYS as f64);
        whole.area += weight * 0.5 * (far * far - radius * radius);
        whole.moment = along(whole.moment, towards, weight * (far.powi(3) - radius.powi(3)) / 3.0);
    }
    whole
}

/// The ends of edges at which exactly one other of them leads on: for each edge, the directions in which it leaves there and the other goes on.
///
/// # Cost
/// O(n·log n).
pub(super) fn turns(part: &Part, edges: &[ReflexEdge]) -> Vec<Vec<[Vec3; 2]>> {
    let mut with_vertex: BTreeMap<u32, Vec<(usize, Vec3)>> = BTreeMap::new();
    for (i, edge) in edges.iter().enumerate() {
        for (vertex, out) in ends(part, edge) {
            with_vertex.entry(vertex).or_default().push((i, out));
        }
    }
    let mut turns = vec![Vec::new(); edges.len()];
    for pair in with_vertex.values() {
        if let [(i, out), (j, other)] = pair[..] {
            turns[i].push([out, scale(other, -1.0)]);
            turns[j].push([other, scale(out, -1.0)]);
        }
    }
    turns
}

/// The vertices that a stretch of an edge reaches, and the directions in which it leaves there.
fn ends(part: &Part, edge: &ReflexEdge) -> Vec<(u32, Vec3)> {
    let vertices = &part.mesh().vertices;
    let at = |v: u32| vertices.get(v as usize).map(|p| (v, *p));
    let reaches = |p: Vec3| (distance(p, edge.middle) - 0.5 * edge.length).abs() <= 1e-9 * edge.length;
    let all = edge.ends.into_iter().filter_map(at).filter(|(_, p)| reaches(*p));
    all.map(|(v, p)| (v, unit(sub(p, edge.middle)))).collect()
}

/// What a fillet with a section adds along an edge that turns so at its ends, mm³.
pub(super) fn added(edge: &ReflexEdge, section: &Section, turns: &[[Vec3; 2]]) -> f64 {
    let grows: f64 = turns.iter().map(|[leaves, leads_on]| section.growth(*leaves, *leads_on)).sum();
    (edge.length * section.area + grows).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::revolved;
    use crate::medial::reflex::reflex_edges;
    use crate::part::Up;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    /// Between two planes at right angles, along z through the origin.
    fn square() -> ReflexEdge {
        let normals = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let (ends, facets, heights) = ([0, 1], [0, 1], [5.0; 2]);
        ReflexEdge { ends, facets, bend: FRAC_PI_2, length: 2.0, middle: [0.0; 3], normals, heights }
    }

    #[test]
    fn a_section_between_planes_is_a_kite_without_a_sector() {
        let found = Section::between_planes(&square(), 0.5);
        assert!((found.area - 0.25 * (1.0 - FRAC_PI_4)).abs() < 1e-12);
        // Of the square of 0.5 mm about (0.25, 0.25) less the quarter disc about 0.5·(1 − 4 / 3π).
        let moment = 0.25 * 0.25 - 0.25 * FRAC_PI_4 * 0.5 * (1.0 - 4.0 / (3.0 * PI));
        assert!((0..2).all(|a| (found.moment[a] - moment).abs() < 1e-12), "{found:?} {moment}");
    }

    #[test]
    fn the_same_section_is_measured_under_a_ball() {
        let even = Section::between_planes(&square(), 0.5);
        let surface = |d: Vec3| (0..2).filter(|&a| d[a] < 0.0).map(|a| -0.5 / d[a]).fold(f64::INFINITY, f64::min);
        let contacts = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let found = Section::under_a_ball([0.5, 0.5, 0.0], contacts, 0.5, surface);
        // Simpson's rule with sixteen steps.
        assert!((found.area - even.area).abs() < 1e-5 && distance(found.moment, even.moment) < 1e-5, "{found:?}");
    }

    #[test]
    fn fillets_about_rings_add_what_pappus_theorem_says() {
        // A boss of 2 mm on a plate, and a pit of 2 mm in it: the centroids run on circles further out, and further in.
        let boss = [[0.0, 0.0], [6.0, 0.0], [6.0, 2.0], [2.0, 2.0], [2.0, 6.0], [0.0, 6.0]];
        let pit = [[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [2.0, 6.0], [2.0, 2.0], [0.0, 2.0]];
        let (radius, sides) = (1.0, 96);
        let area = 1.0 - FRAC_PI_4;
        let out = (0.5 - FRAC_PI_4 * (1.0 - 4.0 / (3.0 * PI))) / area;
        for (outline, centroid) in [(boss, 2.0 + out), (pit, 2.0 - out)] {
            let part = Part::new(revolved(&outline, sides), Up::PlusZ, 1e-6, 1.0).unwrap();
            let edges = reflex_edges(part.mesh(), 0.8, |_| true);
            let turns = turns(&part, &edges);
            let all: f64 =
                edges.iter().zip(&turns).map(|(e, turns)| added(e, &Section::between_planes(e, radius), turns)).sum();
            // The corners lie on the circle.
            let truth = 2.0 * PI * centroid * area;
            assert!(edges.len() == sides && (all - truth).abs() < 1e-3 * truth, "{all} not {truth}");
        }
    }
}
