//! Facets that cross each other: where a surface passes through itself.

use super::measure::Fault;
use crate::geometry::distance::MeshDistance;
use crate::geometry::vector::{Vec3, along, bounds, cross, distance, dot, sub, unit};
use rayon::prelude::*;

/// Two facets that cross, and the segment they have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Crossing {
    facets: [u32; 2],
    middle: Vec3,
    length: f64,
}

/// The pairs of facets of the tree that cross each other by more than `tolerance` (millimetres), as far as `compared` names
/// the pair; the place is the middle of the longest common segment.
///
/// Two facets cross if an edge of one has its ends on both sides of the other's plane and meets the other's inside, each
/// by more than the tolerance. Facets that only touch, lie in each other's plane, or cross exactly through an edge are not
/// counted; where a surface passes through itself, other facets nearby then are.
///
/// # Cost
/// O(T log T + pairs of overlapping boxes), facets in parallel.
///
/// # Source
/// T. Möller, A fast triangle-triangle intersection test, 1997, for the plane test first.
pub fn crossings(tree: &MeshDistance, compared: impl Fn(u32, u32) -> bool + Sync, tolerance: f64) -> Fault {
    let order = tree.tree().order();
    let worse = |a: (u64, Option<Crossing>), b: (u64, Option<Crossing>)| {
        let worst = match (a.1, b.1) {
            (Some(p), Some(q)) if (q.length, p.facets) > (p.length, q.facets) => Some(q),
            (None, q) => q,
            (p, _) => p,
        };
        (a.0 + b.0, worst)
    };
    let (count, worst) = order
        .par_iter()
        .with_min_len(256)
        .map_init(Vec::new, |stack, &f| {
            let mut found = (0, None);
            let Some(extent) = bounds(tree.corners(f)) else { return found };
            for_overlapping(tree, extent, stack, |g| {
                if g > f && compared(f, g) {
                    let crossing = cross_of(tree, f, g, tolerance);
                    found = worse(found, (u64::from(crossing.is_some()), crossing));
                }
            });
            found
        })
        .reduce(|| (0, None), worse);
    Fault { count, at_mm: worst.map(|w| w.middle) }
}

/// Visits the facets whose boxes in the tree overlap a box.
pub(super) fn for_overlapping(
    tree: &MeshDistance,
    (lo, hi): (Vec3, Vec3),
    stack: &mut Vec<usize>,
    mut visit: impl FnMut(u32),
) {
    let (nodes, order) = (tree.tree().nodes(), tree.tree().order());
    stack.push(0);
    while let Some(at) = stack.pop() {
        let Some(node) = nodes.get(at) else { continue };
        if node.box_distance2(lo, hi) > 0.0 {
            continue;
        }
        match node.children() {
            Some(children) => stack.extend(children),
            None => order[node.run()].iter().for_each(|&g| visit(g)),
        }
    }
}

/// The segment in which two facets cross.
fn cross_of(tree: &MeshDistance, f: u32, g: u32, tolerance: f64) -> Option<Crossing> {
    let (s, t) = (tree.corners(f), tree.corners(g));
    // Neighbours share corners; what meets at a corner is within the tolerance of both facets' planes there.
    if s.iter().filter(|p| t.contains(p)).count() >= 2 {
        return None;
    }
    let (m, n) = (tree.normal(f), tree.normal(g));
    let mut points = pierced(s, t, n, tolerance);
    if points.is_empty() && one_sided(s, t[0], n, tolerance) {
        return None;
    }
    points.extend(pierced(t, s, m, tolerance));
    let (&p, &q) = (points.first()?, points.last()?);
    Some(Crossing { facets: [f, g], middle: along(p, sub(q, p), 0.5), length: distance(p, q) })
}

/// Whether a triangle has no corners on both sides of a plane.
fn one_sided(s: [Vec3; 3], on_plane: Vec3, normal: Vec3, tolerance: f64) -> bool {
    let heights = s.map(|p| dot(normal, sub(p, on_plane)));
    heights.iter().all(|&d| d >= -tolerance) || heights.iter().all(|&d| d <= tolerance)
}

/// Where the edges of one triangle meet the inside of another.
fn pierced(s: [Vec3; 3], t: [Vec3; 3], normal: Vec3, tolerance: f64) -> Vec<Vec3> {
    let heights = s.map(|p| dot(normal, sub(p, t[0])));
    let inside = |x: Vec3| {
        (0..3).all(|e| {
            let (a, b) = (t[e], t[(e + 1) % 3]);
            dot(unit(cross(normal, sub(b, a))), sub(x, a)) > tolerance
        })
    };
    (0..3)
        .map(|e| (e, (e + 1) % 3))
        .filter(|&(a, b)| heights[a].min(heights[b]) < -tolerance && heights[a].max(heights[b]) > tolerance)
        .map(|(a, b)| along(s[a], sub(s[b], s[a]), heights[a] / (heights[a] - heights[b])))
        .filter(|&x| inside(x))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Primitive, TriangleMesh};
    use crate::units::Length;

    fn all(mesh: &TriangleMesh, tolerance: f64) -> Fault {
        crossings(&MeshDistance::new(mesh), |_, _| true, tolerance)
    }

    /// Every pair, without the tree.
    fn plainly(mesh: &TriangleMesh, tolerance: f64) -> u64 {
        let tree = MeshDistance::new(mesh);
        let n = mesh.triangles.len() as u32;
        let pairs = (0..n).flat_map(|f| (f + 1..n).map(move |g| (f, g)));
        pairs.filter(|&(f, g)| cross_of(&tree, f, g, tolerance).is_some()).count() as u64
    }

    fn ball(at: Vec3) -> TriangleMesh {
        let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Primitive::Ball { radius: Length::mm(3.0) }.mesh(Length::mm(0.02)).transformed(one, at)
    }

    #[test]
    fn a_sound_surface_and_surfaces_that_only_touch_do_not_cross() {
        assert_eq!(all(&ball([0.0; 3]), 1e-9).count, 0);
        let box_ = |x: f64| {
            let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            Primitive::Box { edges: [Length::mm(2.0); 3] }.mesh(Length::mm(0.1)).transformed(one, [x, 0.3, 0.1])
        };
        assert_eq!(all(&box_(0.0).joined(&box_(2.0)), 1e-9).count, 0);
    }

    #[test]
    fn two_balls_cross_in_a_circle_and_the_tree_finds_every_pair() {
        let both = ball([0.0; 3]).joined(&ball([4.0, 0.1, 0.2]));
        let found = all(&both, 1e-9);
        assert_eq!(found.count, plainly(&both, 1e-9));
        assert!(found.count > 20, "{found:?}");
        // The spheres meet where both centres are 3 mm away; a facet lies at most a sagitta deep in each direction.
        let at = found.at_mm.unwrap();
        let deep = |centre: Vec3| 3.0 - distance(at, centre);
        assert!([[0.0; 3], [4.0, 0.1, 0.2]].into_iter().all(|c| (0.0..0.04).contains(&deep(c))), "{found:?}");
    }

    #[test]
    fn what_is_shallower_than_the_tolerance_is_a_touch() {
        let both = ball([0.0; 3]).joined(&ball([5.9995, 0.0, 0.0]));
        assert_eq!(all(&both, 0.01).count, 0);
        assert_eq!(all(&both, 0.01).count, plainly(&both, 0.01));
    }

    #[test]
    fn only_the_pairs_that_are_compared_count() {
        let one = ball([0.0; 3]);
        let n = one.triangles.len() as u32;
        let both = one.joined(&ball([4.0, 0.1, 0.2]));
        let within = crossings(&MeshDistance::new(&both), |f, g| (f < n) == (g < n), 1e-9);
        assert_eq!(within, Fault { count: 0, at_mm: None });
    }
}
