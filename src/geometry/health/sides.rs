//! The winding number on both sides of each facet of a surface.

use super::pairs::{groups, near_pairs};
use crate::geometry::edges::EdgeTable;
use crate::geometry::triangle::{closest_pair_within, closest_point};
use crate::geometry::vector::{Vec3, add, along, distance, dot, sub, unit};
use crate::geometry::{MeshDistance, TriangleMesh, Winding};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// What is evaluated beside the facets of a mesh.
pub struct Sides<'a> {
    pub mesh: &'a TriangleMesh,
    pub winding: &'a Winding,
    /// How far beside a facet, millimetres.
    pub off: f64,
}

/// The winding numbers on both sides of each facet, and the facet that spoke for each.
pub struct Spoken {
    /// Just behind and just before.
    pub sides: Vec<(f64, f64)>,
    pub speaker: Vec<u32>,
}

impl Sides<'_> {
    /// The winding number just behind and just before each facet.
    pub fn of_each(&self) -> Vec<(f64, f64)> {
        (0..self.mesh.triangles.len()).into_par_iter().map(|f| self.beside(f)).collect()
    }

    /// The same for at most so many facets, spread evenly over their order.
    pub fn of_some(&self, count: usize) -> Vec<(f64, f64)> {
        let each = self.mesh.triangles.len().div_ceil(count.max(1)).max(1);
        let some: Vec<usize> = (0..self.mesh.triangles.len()).step_by(each).collect();
        some.into_par_iter().with_max_len(1).map(|f| self.beside(f)).collect()
    }

    /// The same for a closed surface, where one facet speaks for all that are joined to it and that nothing else touches.
    ///
    /// The winding number of a closed surface changes only across it. Two facets with a common edge have the same numbers on
    /// their sides if no third facet comes within `tolerance` of either but at the corners they share; `tree` holds
    /// all facets of the mesh.
    ///
    /// # Cost
    /// O(T log T) and a winding number for each facet that something else touches.
    pub fn of_closed(&self, tree: &MeshDistance, tolerance: f64) -> Spoken {
        let count = self.mesh.triangles.len();
        let clear = self.clear(tree, tolerance);
        let patch = self.patches(&clear);
        let mut speaker = vec![usize::MAX; count];
        for f in 0..count {
            let at = &mut speaker[patch[f]];
            if *at == usize::MAX || self.mesh.facet_area(f) > self.mesh.facet_area(*at) {
                *at = f;
            }
        }
        let known: Vec<(f64, f64)> = speaker
            .par_iter()
            .with_max_len(1024)
            .map(|&f| if f == usize::MAX { (0.0, 0.0) } else { self.beside(f) })
            .collect();
        Spoken {
            sides: patch.iter().map(|&p| known[p]).collect(),
            speaker: patch.into_iter().map(|p| speaker[p] as u32).collect(),
        }
    }

    fn beside(&self, f: usize) -> (f64, f64) {
        let (p, n) = (self.mesh.centroid(f), self.mesh.normal(f));
        (self.winding.at(along(p, n, -self.off)), self.winding.at(along(p, n, self.off)))
    }

    /// For each facet whether others come near it only at the corners they share with it.
    fn clear(&self, tree: &MeshDistance, tolerance: f64) -> Vec<bool> {
        let has_area = |f| self.mesh.facet_area(f) > 0.0;
        let near: Vec<AtomicBool> = (0..self.mesh.triangles.len()).map(|f| AtomicBool::new(!has_area(f))).collect();
        // Each pair is looked at once; a mark is only ever set, so that no order matters.
        groups(tree.tree()).for_each_init(Vec::new, |spans, group| {
            near_pairs(tree.tree(), &|f| tree.corners(f), group, tolerance, spans, |f, g| {
                if !self.apart(f as usize, g as usize, tolerance) {
                    [f, g].iter().for_each(|&n| near[n as usize].store(true, Ordering::Relaxed));
                }
            });
        });
        near.into_iter().map(|n| !n.into_inner()).collect()
    }

    fn apart(&self, f: usize, g: usize, tolerance: f64) -> bool {
        let (s, t) = (self.mesh.corners(f), self.mesh.corners(g));
        let own = |of: usize, other: usize| {
            let theirs = self.mesh.triangles[other];
            let [a, b, c] = self.mesh.triangles[of];
            [!theirs.contains(&a), !theirs.contains(&b), !theirs.contains(&c)]
        };
        let (own_s, own_t) = (own(f, g), own(g, f));
        if parted_by_a_plane([s, t], [own_s, own_t], tolerance) {
            return true;
        }
        let own_corners = |of: [Vec3; 3], own: [bool; 3]| -> Vec<Vec3> {
            of.into_iter().zip(own).filter(|(_, own)| *own).map(|(p, _)| p).collect()
        };
        let far = |a: [Vec3; 3], b: [Vec3; 3]| {
            closest_pair_within(a, b, tolerance).is_none_or(|(p, q)| distance(p, q) > tolerance)
        };
        match (own_corners(s, own_s).as_slice(), own_corners(t, own_t).as_slice()) {
            ([_, _, _], [_, _, _]) => far(s, t),
            (&[a, b], &[c, d]) => far([a, b, b], t) && far([c, d, d], s),
            (&[a], &[b]) => {
                distance(a, closest_point(a, t)) > tolerance && distance(b, closest_point(b, s)) > tolerance
            }
            _ => false,
        }
    }

    /// For each facet the least facet it is joined to by edges between two clear ones.
    fn patches(&self, clear: &[bool]) -> Vec<usize> {
        let mut patch: Vec<usize> = (0..clear.len()).collect();
        fn root(patch: &mut [usize], mut f: usize) -> usize {
            while patch[f] != f {
                patch[f] = patch[patch[f]];
                f = patch[f];
            }
            f
        }
        for edge in EdgeTable::of(self.mesh).edges() {
            let [(_, a), (_, b)] = edge.sides else { continue };
            if a.direction() != b.direction() && clear[a.facet()] && clear[b.facet()] {
                let (a, b) = (root(&mut patch, a.facet()), root(&mut patch, b.facet()));
                patch[a.max(b)] = a.min(b);
            }
        }
        (0..clear.len()).map(|f| root(&mut patch, f)).collect()
    }
}

/// Whether a plane through what two triangles share, or between them if they share nothing, has the corners that each has for
/// itself on its own side, farther away than the tolerance: enough, and quick, but not necessary for them to be apart. The
/// normal is that from one triangle to the other, seen from a shared corner and along a shared edge.
fn parted_by_a_plane([s, t]: [[Vec3; 3]; 2], [own_s, own_t]: [[bool; 3]; 2], tolerance: f64) -> bool {
    let shared = || s.into_iter().zip(own_s).filter(|(_, own)| !own).map(|(p, _)| p);
    let (base, sharing) = shared().next().map_or((s[0], false), |p| (p, true));
    let corners = |of: [Vec3; 3], own: [bool; 3]| of.into_iter().zip(own).filter(|(_, own)| *own).map(|(p, _)| p);
    let ahead = |p: Vec3| if sharing { unit(sub(p, base)) } else { sub(p, base) };
    let lean = corners(s, own_s).fold([0.0; 3], |d, p| add(d, ahead(p)));
    let mut normal = corners(t, own_t).fold(lean, |d, p| sub(d, ahead(p)));
    if let Some(edge) = shared().nth(1).map(|p| unit(sub(p, base))) {
        normal = along(normal, edge, -dot(normal, edge));
    }
    let normal = unit(normal);
    let height = |p: Vec3| dot(normal, sub(p, base));
    let least = corners(s, own_s).map(height).fold(f64::INFINITY, f64::min);
    let most = corners(t, own_t).map(height).fold(f64::NEG_INFINITY, f64::max);
    // Only finite heights that are compared part anything: without own corners there are none.
    let finite = least.is_finite() && most.is_finite();
    finite && if sharing { least > tolerance && most < -tolerance } else { least - most > tolerance }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::units::Length;

    fn ball(at: Vec3, radius: f64) -> TriangleMesh {
        let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Primitive::Ball { radius: Length::mm(radius) }.mesh(Length::mm(0.02)).transformed(one, at)
    }

    #[test]
    fn one_facet_speaks_for_what_every_facet_says_for_itself() {
        // Two balls that cross, one inside both, and two blocks with a common face.
        let block = |x: f64| {
            let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            Primitive::Box { edges: [Length::mm(2.0); 3] }.mesh(Length::mm(0.1)).transformed(one, [x, 0.0, 9.0])
        };
        let parts = [ball([4.0, 0.1, 0.2], 3.0), ball([2.0, 0.0, 0.0], 0.5), block(0.0), block(2.0), block(1.0)];
        let mesh = parts.iter().fold(ball([0.0; 3], 3.0), |all, part| all.joined(part));
        let (winding, tree) = (Winding::new(&mesh), MeshDistance::new(&mesh));
        let sides = Sides { mesh: &mesh, winding: &winding, off: 1e-3 };
        let (each, spoken) = (sides.of_each(), sides.of_closed(&tree, 1e-6).sides);
        let inside = |w: f64| w.round() as i64;
        for (f, (a, b)) in each.iter().zip(&spoken).enumerate() {
            assert_eq!((inside(a.0), inside(a.1)), (inside(b.0), inside(b.1)), "facet {f}: {a:?} {b:?}");
        }
        let clear = sides.clear(&tree, 1e-6).into_iter().filter(|c| *c).count();
        assert!(clear > mesh.triangles.len() / 2, "{clear} of {}", mesh.triangles.len());
    }
}
