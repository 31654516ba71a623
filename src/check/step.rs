//! Steps: how far the faces of a concave edge go on before they end.

use crate::geometry::vector::{Vec3, along, cross, distance, dot, norm, scale, sub, unit};
use crate::medial::reflex::ReflexEdge;
use crate::part::Part;

/// Facets that a profile crosses at most.
const CROSSED: usize = 512;
/// Profiles that follow every change along an edge; further ones are this share of its length apart at least.
const EXACT: usize = 4096;
/// A face has ended where it has turned away from the void as far as the edge turns towards it, but for this angle, radians (2°).
const ENDED: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// The part of a concave edge between two points of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    /// The edge, with the length and the middle of the part.
    pub edge: ReflexEdge,
    pub ends: [Vec3; 2],
    /// The ends of the edge that are its own.
    pub vertices: [Option<u32>; 2],
}

impl Stretch {
    /// The part from one distance along an edge to another.
    fn of(edge: &ReflexEdge, corners: [Vec3; 2], span: [f64; 2]) -> Self {
        let [p, q] = corners;
        let is_own = [span[0] <= 0.0, span[1] >= edge.length];
        let point = |x: f64| along(p, sub(q, p), x / edge.length);
        let ends = [if is_own[0] { p } else { point(span[0]) }, if is_own[1] { q } else { point(span[1]) }];
        let middle = along(ends[0], sub(ends[1], ends[0]), 0.5);
        let vertices = [0, 1].map(|i| is_own[i].then_some(edge.ends[i]));
        Stretch { edge: ReflexEdge { length: span[1] - span[0], middle, ..*edge }, ends, vertices }
    }
}

/// Where along a concave edge neither of its two faces ends within a length.
///
/// A face ends where, going up it, the surface comes to run along the other face again, or to fall back to it, having bent away from the void. Where
/// it bends towards the void first, as at the other side of a slot, it has that to undo.
///
/// # Cost
/// One profile wherever the facets that it crosses change, twice [`EXACT`] at most.
pub(super) fn higher_than(part: &Part, edge: &ReflexEdge, length: f64) -> Vec<Stretch> {
    let [p, q] = edge.ends.map(|v| part.mesh().vertices.get(v as usize).copied());
    match p.zip(q) {
        Some((p, q)) if edge.length > 0.0 => {
            spans(part, edge, p, length).into_iter().map(|span| Stretch::of(edge, [p, q], span)).collect()
        }
        _ => Vec::new(),
    }
}

/// The same as distances along the edge from its first end.
fn spans(part: &Part, edge: &ReflexEdge, from: Vec3, length: f64) -> Vec<[f64; 2]> {
    let run = Profile::run(part, edge);
    // A profile keeps off the corner before it; what takes a few such steps is noise.
    let step = part.tie().max(1e-9 * edge.length).min(0.1 * edge.length);
    let noise = 4.0 * step;
    let mut spans: Vec<[f64; 2]> = Vec::new();
    let (mut at, mut taken) = (0.0, 0);
    while at < edge.length {
        let profile = Profile { part, edge, from: along(from, run, at + step), run };
        let (is_step, alike) = profile.is_step_within(length, edge.length - at - step);
        let least = if taken < EXACT { step } else { edge.length / EXACT as f64 };
        let until = at + (step + alike).max(least);
        let until = if until > edge.length - 2.0 * step { edge.length } else { until };
        match spans.last_mut() {
            _ if is_step => {}
            Some(last) if at - last[1] <= noise => last[1] = until,
            _ => spans.push([if at <= noise { 0.0 } else { at }, until]),
        }
        (at, taken) = (until, taken + 1);
    }
    if let Some(last) = spans.last_mut().filter(|s| s[1] >= edge.length - noise) {
        last[1] = edge.length;
    }
    spans.retain(|s| s[1] - s[0] > noise);
    spans
}

/// The profile of a part across a concave edge.
struct Profile<'a> {
    part: &'a Part,
    edge: &'a ReflexEdge,
    /// A point of the edge and its direction.
    from: Vec3,
    run: Vec3,
}

/// Where a profile leaves a facet.
struct Leaving {
    /// The first corner of the edge that it crosses.
    corner: usize,
    at: Vec3,
    /// How the place moves for each millimetre that the profile moves along its own edge, and as far as it may.
    moves: Vec3,
    until: f64,
}

impl Profile<'_> {
    /// Unit vector along an edge.
    fn run(part: &Part, edge: &ReflexEdge) -> Vec3 {
        let [p, q] = edge.ends.map(|v| part.mesh().vertices.get(v as usize).copied().unwrap_or(edge.middle));
        unit(sub(q, p))
    }

    /// Whether one of the two faces ends within a length of the edge, and how far along the edge that stays so, up to a distance.
    fn is_step_within(&self, length: f64, most: f64) -> (bool, f64) {
        let [one, other] = [0, 1].map(|side| self.ends_within(side, length, most));
        match (one.0, other.0) {
            (true, true) => (true, one.1.max(other.1)),
            (true, false) => one,
            (false, true) => other,
            (false, false) => (false, one.1.min(other.1)),
        }
    }

    fn ends_within(&self, side: usize, length: f64, most: f64) -> (bool, f64) {
        let mesh = self.part.mesh();
        let mut facet = self.edge.facets[side];
        let apex = sub(mesh.centroid(facet as usize), self.from);
        // The surface is oriented: what is ahead is on the same hand of the normal all along.
        let hand = if dot(cross(self.edge.normals[side], self.run), apex) < 0.0 { -1.0 } else { 1.0 };
        let (mut at, mut gone, mut turned) = (self.from, 0.0, 0.0);
        // What has been gone is linear in the place along the edge, as long as the same facets are crossed.
        let (mut moves, mut longer, mut alike) = (self.run, 0.0, most.max(0.0));
        let mut entered = self.edge.ends;
        let Some(mut normal) = self.in_plane(facet) else { return (false, alike) };
        for _ in 0..CROSSED {
            let ahead = scale(cross(normal, self.run), hand);
            let Some(next) = self.leaves(facet, entered, at, ahead) else { return (false, alike) };
            gone += distance(at, next.at);
            longer += dot(sub(next.moves, moves), ahead);
            let crosses = (length - gone) / longer;
            alike = alike.min(next.until).min(if crosses > 0.0 { crosses } else { most });
            let Some(beyond) = self.part.adjacency().across(facet, next.corner).filter(|_| gone < length) else {
                return (false, alike);
            };
            let t = mesh.triangles[facet as usize];
            entered = [t[next.corner], t[(next.corner + 1) % 3]];
            (at, moves, facet) = (next.at, next.moves, beyond);
            // A facet without area has no direction of its own.
            let Some(bent) = self.in_plane(facet) else { continue };
            let to = scale(cross(bent, self.run), hand);
            turned += (-dot(to, normal)).atan2(dot(to, ahead));
            normal = bent;
            if turned >= self.edge.bend - ENDED {
                return (true, alike);
            }
        }
        (false, alike)
    }

    /// The normal of a facet as the profile shows it; `None` if the profile runs along it, or it has no area.
    fn in_plane(&self, facet: u32) -> Option<Vec3> {
        let n = self.part.mesh().normal(facet as usize);
        let flat = along(n, self.run, -dot(n, self.run));
        (norm(flat) > 1e-6).then(|| unit(flat))
    }

    /// Over which edge of a facet the profile leaves it.
    fn leaves(&self, facet: u32, entered: [u32; 2], at: Vec3, ahead: Vec3) -> Option<Leaving> {
        let mesh = self.part.mesh();
        let (t, corners) = (mesh.triangles[facet as usize], mesh.corners(facet as usize));
        let off = corners.map(|c| dot(sub(c, self.from), self.run));
        let crossing = |i: usize| {
            let j = (i + 1) % 3;
            let is_new = !(entered.contains(&t[i]) && entered.contains(&t[j]));
            let meets = (off[i] <= 0.0) != (off[j] <= 0.0);
            (is_new && meets).then(|| {
                let moves = scale(sub(corners[j], corners[i]), 1.0 / (off[j] - off[i]));
                Leaving { corner: i, at: along(corners[i], moves, -off[i]), moves, until: off[i].max(off[j]) }
            })
        };
        let far = |x: &Leaving| dot(sub(x.at, at), ahead);
        (0..3).filter_map(crossing).max_by(|a, b| far(a).total_cmp(&far(b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{TriangleMesh, extruded};
    use crate::medial::reflex::reflex_edges;
    use crate::part::Up;

    /// Whether the faces of the concave edges of an outline, 9 mm deep, end within a length, edge by edge from low x to high.
    fn steps(outline: &[[f64; 2]], caps: &[[usize; 3]], length: f64) -> Vec<bool> {
        let mesh: TriangleMesh = extruded(outline, caps, 9.0);
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
        let mut edges = reflex_edges(part.mesh(), 0.2, |_| true);
        edges.sort_by(|a, b| a.middle[0].total_cmp(&b.middle[0]));
        edges.iter().map(|e| higher_than(&part, e, length).is_empty()).collect()
    }

    #[test]
    fn a_step_is_as_high_as_it_rises() {
        // An L, its upright leg 6 mm over the foot, which reaches 8 mm beyond.
        let outline = [[0.0, 0.0], [10.0, 0.0], [10.0, 2.0], [2.0, 2.0], [2.0, 8.0], [0.0, 8.0]];
        let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        assert_eq!(steps(&outline, &caps, 5.99), [false]);
        assert_eq!(steps(&outline, &caps, 6.01), [true]);
        // Its top a bevel of 45°: it rises to 7 mm, over √2 mm of the bevel.
        let outline = [[0.0, 0.0], [10.0, 0.0], [10.0, 2.0], [2.0, 2.0], [2.0, 8.0], [1.0, 9.0], [0.0, 9.0]];
        let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6]];
        assert_eq!(steps(&outline, &caps, 7.3), [false]);
        assert_eq!(steps(&outline, &caps, 7.5), [true]);
    }

    #[test]
    fn a_slot_is_as_deep_as_its_walls_however_narrow_it_is() {
        // A slot 0.5 mm wide and 6 mm deep, from x = 3 on.
        let outline = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [3.5, 9.0], [3.5, 3.0], [3.0, 3.0], [3.0, 9.0], [0.0, 9.0]];
        let caps = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [0, 4, 5], [0, 5, 7], [5, 6, 7]];
        assert_eq!(steps(&outline, &caps, 5.9), [false; 2]);
        assert_eq!(steps(&outline, &caps, 6.1), [true; 2]);
    }

    /// Every facet in four.
    fn finer(mesh: &TriangleMesh) -> TriangleMesh {
        let split = |[a, b, c]: [Vec3; 3]| {
            let [d, e, f] = [(a, b), (b, c), (c, a)].map(|(p, q)| along(p, sub(q, p), 0.5));
            [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
        };
        TriangleMesh::weld((0..mesh.triangles.len()).flat_map(|f| split(mesh.corners(f))))
    }

    #[test]
    fn an_edge_is_judged_piece_by_piece_however_it_is_divided() {
        // The L again, its upright leg 6 mm high at one end and 1 mm at the other: 3.5 mm at half its depth.
        let outline = [[0.0, 0.0], [10.0, 0.0], [10.0, 2.0], [2.0, 2.0], [2.0, 8.0], [0.0, 8.0]];
        let mut mesh = extruded(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], 9.0);
        mesh.vertices.iter_mut().filter(|v| v[1] > 8.0 && v[2] > 5.0).for_each(|v| v[2] = 3.0);
        for divided in 0..4 {
            let part = Part::new(mesh.clone(), Up::PlusZ, 1e-6, 1.0).unwrap();
            let edges = reflex_edges(part.mesh(), 0.2, |_| true);
            assert_eq!(edges.len(), 1 << divided);
            let high: Vec<Stretch> = edges.iter().flat_map(|e| higher_than(&part, e, 3.5)).collect();
            let (most, length) = (
                high.iter().flat_map(|s| s.ends).map(|p| p[1]).fold(0.0, f64::max),
                high.iter().map(|s| s.edge.length),
            );
            assert!((most - 4.5).abs() < 1e-4 && (length.sum::<f64>() - 4.5).abs() < 1e-4, "{divided}: {high:?}");
            // All are joined at vertices; the last ends within an edge, or at a vertex that happens to be there.
            assert!(high.iter().flat_map(|s| s.vertices).filter(Option::is_none).count() <= 1);
            mesh = finer(&mesh);
        }
    }
}
