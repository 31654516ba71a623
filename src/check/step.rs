//! Steps: how far the faces of a concave edge go on before they end.

use crate::geometry::vector::{Vec3, along, cross, distance, dot, norm, scale, sub, unit};
use crate::medial::reflex::ReflexEdge;
use crate::part::Part;

/// Facets that a profile crosses at most.
const CROSSED: usize = 512;
/// Where along the edge the profile is taken: not at the middle, where edges of other facets often end.
const AT: f64 = 0.4837;
/// A face has ended where it has turned away from the void as far as the edge turns towards it, but for this angle, radians (2°).
const ENDED: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// The profile of a part across a concave edge.
pub(super) struct Profile<'a> {
    part: &'a Part,
    edge: &'a ReflexEdge,
    /// A point of the edge and its direction.
    from: Vec3,
    run: Vec3,
}

impl<'a> Profile<'a> {
    /// The profile across an edge; `None` for one without length.
    pub fn across(part: &'a Part, edge: &'a ReflexEdge) -> Option<Self> {
        let [p, q] = edge.ends.map(|v| part.mesh().vertices.get(v as usize).copied());
        let (p, q) = p.zip(q)?;
        let run = unit(sub(q, p));
        (norm(run) > 0.5).then(|| Profile { part, edge, from: along(p, sub(q, p), AT), run })
    }

    /// Whether one of the two faces ends within a length of the edge: going up it, the surface comes to run along the other face again, or to fall
    /// back to it, having bent away from the void. Where it bends towards the void first, as at the other side of a slot, it has that to undo.
    pub fn is_step_within(&self, length: f64) -> bool {
        [0, 1].into_iter().any(|side| self.ends_within(side, length))
    }

    fn ends_within(&self, side: usize, length: f64) -> bool {
        let mesh = self.part.mesh();
        let mut facet = self.edge.facets[side];
        let apex = sub(mesh.centroid(facet as usize), self.from);
        // The surface is oriented: what is ahead is on the same hand of the normal all along.
        let hand = if dot(cross(self.edge.normals[side], self.run), apex) < 0.0 { -1.0 } else { 1.0 };
        let (mut at, mut gone, mut turned) = (self.from, 0.0, 0.0);
        let mut entered = self.edge.ends;
        let Some(mut normal) = self.in_plane(facet) else { return false };
        for _ in 0..CROSSED {
            let ahead = scale(cross(normal, self.run), hand);
            let Some((corner, next)) = self.leaves(facet, entered, at, ahead) else { return false };
            gone += distance(at, next);
            let Some(beyond) = self.part.adjacency().across(facet, corner).filter(|_| gone < length) else {
                return false;
            };
            let t = mesh.triangles[facet as usize];
            (entered, at, facet) = ([t[corner], t[(corner + 1) % 3]], next, beyond);
            // A facet without area has no direction of its own.
            let Some(bent) = self.in_plane(facet) else { continue };
            let to = scale(cross(bent, self.run), hand);
            turned += (-dot(to, normal)).atan2(dot(to, ahead));
            normal = bent;
            if turned >= self.edge.bend - ENDED {
                return true;
            }
        }
        false
    }

    /// The normal of a facet as the profile shows it; `None` if the profile runs along it, or it has no area.
    fn in_plane(&self, facet: u32) -> Option<Vec3> {
        let n = self.part.mesh().normal(facet as usize);
        let flat = along(n, self.run, -dot(n, self.run));
        (norm(flat) > 1e-6).then(|| unit(flat))
    }

    /// The edge of a facet, by its first corner, over which the profile leaves it, and where.
    fn leaves(&self, facet: u32, entered: [u32; 2], at: Vec3, ahead: Vec3) -> Option<(usize, Vec3)> {
        let mesh = self.part.mesh();
        let (t, corners) = (mesh.triangles[facet as usize], mesh.corners(facet as usize));
        let off = corners.map(|c| dot(sub(c, self.from), self.run));
        let crossing = |i: usize| {
            let j = (i + 1) % 3;
            let is_new = !(entered.contains(&t[i]) && entered.contains(&t[j]));
            let meets = (off[i] <= 0.0) != (off[j] <= 0.0);
            (is_new && meets).then(|| {
                let x = along(corners[i], sub(corners[j], corners[i]), off[i] / (off[i] - off[j]));
                (i, x)
            })
        };
        let far = |x: &(usize, Vec3)| dot(sub(x.1, at), ahead);
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
        edges.iter().map(|e| Profile::across(&part, e).unwrap().is_step_within(length)).collect()
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
}
