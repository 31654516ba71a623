//! Caps: facets with a corner on the opposite edge, which have no direction of their own.

use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, cross, distance, dot, norm, scale, sub};
use rustc_hash::FxHashMap;

/// Passes over the caps that are left: a row of them along an edge goes one by one.
const PASSES: usize = 64;
/// The least cosine between a facet and what takes its place.
const SAME_WAY: f64 = 0.99;

/// A mesh without its caps, if it has any that can go: the facet behind the longest edge of each is divided at the corner that lies on that
/// edge to within `step`.
///
/// The flip of that edge: facets (a, b, c) and (b, a, d), with c on ab, become (c, a, d) and (b, c, d). The surface moves by no more than the
/// step, which is how far the file's coordinates are from what was meant; what is closed stays closed. A cap stays that lies beside more than one facet,
/// and one whose flip would fold the surface or make an edge that is there already.
///
/// # Cost
/// O(facets); without caps one look at each, with some a table of all edges.
pub(super) fn without_caps(mesh: &TriangleMesh, step: f64) -> Option<TriangleMesh> {
    let caps: Vec<u32> = (0..mesh.triangles.len() as u32).filter(|&f| is_cap(mesh, f, step)).collect();
    if caps.is_empty() {
        return None;
    }
    let mut flips = Flips::of(mesh.clone());
    let mut left = caps;
    for _ in 0..PASSES {
        let before = left.len();
        left.retain(|&f| !flips.flip(f, step));
        if left.is_empty() || left.len() == before {
            break;
        }
    }
    flips.changed.then(|| flips.mesh.in_order())
}

/// The corners of a facet from one end of its longest edge, and its height over that edge.
fn upon_longest(mesh: &TriangleMesh, facet: u32) -> ([u32; 3], f64) {
    let mut t = mesh.triangles[facet as usize];
    let at = |v: u32| mesh.vertices[v as usize];
    let length = |i: usize| distance(at(t[i]), at(t[(i + 1) % 3]));
    let longest = (0..3).max_by(|&i, &j| length(i).total_cmp(&length(j))).unwrap_or(0);
    let long = length(longest);
    t.rotate_left(longest);
    (t, norm(mesh.area_vector(facet as usize)) / long.max(f64::MIN_POSITIVE))
}

/// Whether a corner lies on the opposite edge, away from both of its ends.
fn is_cap(mesh: &TriangleMesh, facet: u32, step: f64) -> bool {
    let ([a, b, c], height) = upon_longest(mesh, facet);
    let [p, q, r] = [a, b, c].map(|v| mesh.vertices[v as usize]);
    height <= step && distance(p, r) > 2.0 * step && distance(q, r) > 2.0 * step
}

/// A mesh whose edges are flipped, with the facet along each.
struct Flips {
    mesh: TriangleMesh,
    /// The facet that runs from one vertex to another; `None` where several do.
    along: FxHashMap<[u32; 2], Option<u32>>,
    changed: bool,
}

impl Flips {
    fn of(mesh: TriangleMesh) -> Self {
        let mut along: FxHashMap<[u32; 2], Option<u32>> = FxHashMap::default();
        for (f, &[a, b, c]) in mesh.triangles.iter().enumerate() {
            for edge in [[a, b], [b, c], [c, a]] {
                along.entry(edge).and_modify(|f| *f = None).or_insert(Some(f as u32));
            }
        }
        Flips { mesh, along, changed: false }
    }

    /// Flips the longest edge of a cap; whether it is none any more.
    fn flip(&mut self, cap: u32, step: f64) -> bool {
        if !is_cap(&self.mesh, cap, step) {
            return true;
        }
        let [a, b, c] = upon_longest(&self.mesh, cap).0;
        let one = |edge: [u32; 2]| self.along.get(&edge).copied().flatten();
        let (Some(own), Some(behind)) = (one([a, b]), one([b, a])) else { return false };
        let across = self.mesh.triangles[behind as usize].into_iter().find(|v| *v != a && *v != b);
        let Some(d) = across.filter(|d| *d != c && own == cap && !is_cap(&self.mesh, behind, step)) else {
            return false;
        };
        let is_free = |edge: [u32; 2]| !self.along.contains_key(&edge);
        let normal = self.mesh.normal(behind as usize);
        let made = [[c, a, d], [b, c, d]];
        if !(is_free([c, d]) && is_free([d, c]) && made.iter().all(|t| self.looks(*t, normal))) {
            return false;
        }
        [[a, b], [b, a]].iter().for_each(|edge| {
            self.along.remove(edge);
        });
        for (facet, t) in [cap, behind].into_iter().zip(made) {
            self.mesh.triangles[facet as usize] = t;
            for edge in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
                self.along.insert(edge, Some(facet));
            }
        }
        self.changed = true;
        true
    }

    /// Whether a facet between three vertices looks in a direction.
    fn looks(&self, t: [u32; 3], normal: Vec3) -> bool {
        let [p, q, r] = t.map(|v| self.mesh.vertices[v as usize]);
        let area = cross(sub(q, p), sub(r, p));
        let size = norm(area);
        size > 0.0 && dot(scale(area, 1.0 / size), normal) >= SAME_WAY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::{add, along};
    use crate::geometry::{Health, cuboid};
    use crate::random::Lcg;

    /// A mesh with vertices put on edges of facets, one side of which keeps the whole edge with caps between.
    fn capped(mesh: &TriangleMesh, random: &mut Lcg, off: f64) -> TriangleMesh {
        let mut out = mesh.clone();
        for _ in 0..6 {
            let f = random.below(out.triangles.len() as u64) as usize;
            if is_cap(&out, f as u32, 1e-6) {
                continue;
            }
            let [a, b, c] = out.triangles[f];
            let [p, q] = [a, b].map(|v| out.vertices[v as usize]);
            let at = along(p, sub(q, p), 0.2 + 0.6 * random.unit());
            let new = out.vertices.len() as u32;
            out.vertices.push(add(at, random.point(-off, off)));
            out.triangles[f] = [a, new, c];
            out.triangles.extend([[new, b, c], [a, b, new]]);
        }
        out
    }

    #[test]
    fn caps_go_and_the_surface_stays_closed_where_it_was() {
        let mut random = Lcg(41);
        let (s, c) = 0.7f64.sin_cos();
        let turn = [[c, -s, 0.0], [0.6 * s, 0.6 * c, -0.8], [0.8 * s, 0.8 * c, 0.6]];
        let mut gone = 0;
        for n in 0..200 {
            let block = cuboid([0.0; 3], [4.0, 3.0, 2.0]).transformed(turn, [0.0; 3]);
            let mesh = capped(&block, &mut random, if n % 2 == 0 { 0.0 } else { 2e-7 });
            let Some(made) = without_caps(&mesh, 1e-6) else { panic!("{n}: no cap was seen") };
            let left = (0..made.triangles.len() as u32).filter(|&f| is_cap(&made, f, 1e-6)).count();
            gone += usize::from(left == 0);
            let health = Health::of(&made);
            assert!(health.is_solid() && health.is_watertight(), "{n}");
            assert!((made.signed_volume() - 24.0).abs() < 1e-5 && made.triangles.len() == mesh.triangles.len(), "{n}");
        }
        assert!(gone > 190, "{gone}");
        assert!(without_caps(&cuboid([0.0; 3], [4.0, 3.0, 2.0]), 1e-6).is_none());
    }
}
