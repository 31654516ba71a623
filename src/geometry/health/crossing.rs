//! Facets that cross each other or lie on each other: where a surface passes through itself, is doubled or folded.

use super::measure::Fault;
use super::overlap::{Overlap, overlap_of};
use super::pairs::{groups, near_pairs};
use crate::geometry::bvh::Bvh;
use crate::geometry::distance::MeshDistance;
use crate::geometry::mesh::TriangleMesh;
use crate::geometry::vector::{Vec3, along, bounds, cross, distance, dot, sub, unit};
use rayon::prelude::*;

/// Two facets that cross, and the segment they have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Crossing {
    facets: [u32; 2],
    middle: Vec3,
    length: f64,
}

/// How a surface meets itself away from the corners and edges that its facets share.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Meetings {
    /// Pairs of facets that pass through each other; the place is the middle of the longest common segment.
    pub crossing: Fault,
    /// Pairs of facets that lie on each other in one plane, unless on the same three corners; the place is in the largest overlap.
    pub overlapping: Fault,
    /// Area that such pairs have in common, mm², each pair for itself.
    pub overlap_mm2: f64,
}

/// What was met so far. Areas are counted in whole squares of the tolerance, so that their sum depends on no order.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    crossings: u64,
    longest: Option<Crossing>,
    overlaps: u64,
    squares: u128,
    largest: Option<Overlap>,
}

impl Tally {
    fn and(self, other: Tally) -> Tally {
        Tally {
            crossings: self.crossings + other.crossings,
            longest: greatest(self.longest, other.longest, |c| (c.length, c.facets)),
            overlaps: self.overlaps + other.overlaps,
            squares: self.squares + other.squares,
            largest: greatest(self.largest, other.largest, |o| (o.area, o.facets)),
        }
    }
}

/// The one of greater size, of equal ones that of the lower facets.
fn greatest<T>(a: Option<T>, b: Option<T>, key: impl Fn(&T) -> (f64, [u32; 2])) -> Option<T> {
    match (a, b) {
        (Some(p), Some(q)) => {
            let ((size_p, facets_p), (size_q, facets_q)) = (key(&p), key(&q));
            Some(if (size_q, facets_p) > (size_p, facets_q) { q } else { p })
        }
        (p, q) => p.or(q),
    }
}

/// Where facets of the tree cross each other or lie on each other by more than `tolerance` (millimetres), as far as `compared`
/// names the pair.
///
/// Two facets cross if an edge of one has its ends on both sides of the other's plane and meets the other's inside, each
/// by more than the tolerance. They lie on each other if the corners of each are within the tolerance of the other's plane
/// and, seen along its normal, one covers more than the square of the tolerance of the other's inside, wider than the step of f32
/// coordinates at the mesh's longest side. Facets that only touch,
/// or cross exactly through an edge, are not counted; where a surface passes through itself, other facets nearby then are.
///
/// # Cost
/// O(T log T + pairs of overlapping boxes), facets in parallel.
///
/// # Source
/// T. Möller, A fast triangle-triangle intersection test, 1997, for the plane test first.
pub fn meetings(tree: &MeshDistance, compared: impl Fn(u32, u32) -> bool + Sync, tolerance: f64) -> Meetings {
    meetings_through(tree, |f, g| compared(f, g).then_some(Through::Inside), tolerance)
}

/// As [`meetings`]; `compared` says what counts as a crossing of the pair.
pub fn meetings_through(
    tree: &MeshDistance,
    compared: impl Fn(u32, u32) -> Option<Through> + Sync,
    tolerance: f64,
) -> Meetings {
    let square = tolerance * tolerance;
    let hair = hair(tree.tree());
    // Facets whose boxes are farther apart than the tolerance neither cross nor lie on each other by more.
    let tally = groups(tree.tree())
        .map_init(Vec::new, |near, group| {
            let mut found = Tally::default();
            near_pairs(tree.tree(), &|f| tree.corners(f), group, tolerance, near, |f, g| {
                if let Some(through) = compared(f, g) {
                    let longest = cross_of([f, g].map(|f| (tree.corners(f), tree.normal(f))), tolerance, through);
                    let longest = longest.map(|ends| Crossing::between([f, g], ends));
                    let largest = overlap_of(tree, [f, g], [tolerance, hair]);
                    // Nearly all pairs only touch, and a tally is long to hand on.
                    if longest.is_some() || largest.is_some() {
                        found = found.and(Tally {
                            crossings: u64::from(longest.is_some()),
                            overlaps: u64::from(largest.is_some()),
                            squares: largest.map_or(0, |o| (o.area / square) as u128),
                            longest,
                            largest,
                        });
                    }
                }
            });
            found
        })
        .reduce(Tally::default, Tally::and);
    Meetings {
        crossing: Fault { count: tally.crossings, at_mm: tally.longest.map(|c| c.middle) },
        overlapping: Fault { count: tally.overlaps, at_mm: tally.largest.map(|o| o.middle) },
        overlap_mm2: tally.squares as f64 * square,
    }
}

/// The step of f32 coordinates at the longest side of all there is: needles no higher come of rounding, whatever digits they are written with.
fn hair(tree: &Bvh) -> f64 {
    let longest = tree.nodes().first().map_or(0.0, |root| {
        let (lo, hi) = root.extent();
        sub(hi, lo).into_iter().fold(0.0, f64::max)
    });
    f64::from(f32::EPSILON) * longest
}

/// What counts as a crossing of two facets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Through {
    /// An edge of one through the inside of the other, by more than the tolerance, as [`meetings`] has it.
    Inside,
    /// The same, or an edge through an edge up to the tolerance.
    Edges,
}

impl Through {
    /// How far from its edges an edge has to meet a facet.
    fn margin(self, tolerance: f64) -> f64 {
        match self {
            Through::Inside => tolerance,
            Through::Edges => -tolerance,
        }
    }
}

/// The pairs, of some facets of a manifold mesh, that cross each other by more than `tolerance` millimetres.
///
/// # Cost
/// As [`meetings`] of a mesh of those facets alone.
pub fn crossing_pairs(mesh: &TriangleMesh, facets: &[u32], tolerance: f64, through: Through) -> Vec<[u32; 2]> {
    let planes: Vec<([Vec3; 3], Vec3)> =
        facets.par_iter().map(|&f| (mesh.corners(f as usize), mesh.normal(f as usize))).collect();
    let boxes: Vec<(Vec3, Vec3)> = planes.par_iter().map(|(corners, _)| bounds(*corners).unwrap_or_default()).collect();
    let tree = Bvh::new(&boxes);
    let plane = |n: u32| planes.get(n as usize).copied().unwrap_or_default();
    let pairs = groups(&tree).map_init(Vec::new, |near, group| {
        let mut found = Vec::new();
        near_pairs(&tree, &|n| plane(n).0, group, tolerance, near, |f, g| {
            let pair = [f, g].map(|n| facets.get(n as usize).copied().unwrap_or_default());
            let [a, b] = pair.map(|facet| mesh.triangles.get(facet as usize).copied().unwrap_or_default());
            if !neighbours(a, b) && cross_of([plane(f), plane(g)], tolerance, through).is_some() {
                found.push(pair);
            }
        });
        found
    });
    pairs.flatten_iter().collect()
}

/// Whether two triangles, given with their unit normals, cross each other by more than `tolerance` millimetres, through edges too.
pub fn triangles_cross(a: ([Vec3; 3], Vec3), b: ([Vec3; 3], Vec3), tolerance: f64) -> bool {
    // The plane of one may tell what the plane of the other does not.
    cross_of([a, b], tolerance, Through::Edges).is_some() || cross_of([b, a], tolerance, Through::Edges).is_some()
}

/// Whether facets have an edge in common, as most pairs that are near each other do: known by the numbers of their corners.
pub fn neighbours(a: [u32; 3], b: [u32; 3]) -> bool {
    a.iter().filter(|v| b.contains(v)).count() >= 2
}

impl Crossing {
    fn between(facets: [u32; 2], [p, q]: [Vec3; 2]) -> Self {
        Crossing { facets, middle: along(p, sub(q, p), 0.5), length: distance(p, q) }
    }
}

/// The ends of the segment in which two triangles cross, given with their unit normals.
fn cross_of([(s, m), (t, n)]: [([Vec3; 3], Vec3); 2], tolerance: f64, through: Through) -> Option<[Vec3; 2]> {
    // Most triangles that are near do not reach through each other's plane.
    if one_sided(s, t[0], n, tolerance) {
        return None;
    }
    // Neighbours share corners; what meets at a corner is within the tolerance of both facets' planes there.
    if s.iter().filter(|p| t.contains(p)).count() >= 2 {
        return None;
    }
    let margin = through.margin(tolerance);
    let mut points = pierced(s, t, n, [tolerance, margin]);
    points.extend(pierced(t, s, m, [tolerance, margin]));
    Some([*points.first()?, *points.last()?])
}

/// Whether a triangle has no corners on both sides of a plane.
#[inline]
fn one_sided(s: [Vec3; 3], on_plane: Vec3, normal: Vec3, tolerance: f64) -> bool {
    let heights = s.map(|p| dot(normal, sub(p, on_plane)));
    heights.iter().all(|&d| d >= -tolerance) || heights.iter().all(|&d| d <= tolerance)
}

/// Where the edges of one triangle meet the inside of another, so far from its edges.
fn pierced(s: [Vec3; 3], t: [Vec3; 3], normal: Vec3, [tolerance, margin]: [f64; 2]) -> Vec<Vec3> {
    let heights = s.map(|p| dot(normal, sub(p, t[0])));
    let inside = |x: Vec3| {
        (0..3).all(|e| {
            let (a, b) = (t[e], t[(e + 1) % 3]);
            dot(unit(cross(normal, sub(b, a))), sub(x, a)) > margin
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
    use crate::geometry::Primitive;
    use crate::units::Length;

    fn all(mesh: &TriangleMesh, tolerance: f64) -> Fault {
        meetings(&MeshDistance::new(mesh), |_, _| true, tolerance).crossing
    }

    /// Every pair, without the tree.
    fn plainly(mesh: &TriangleMesh, tolerance: f64) -> u64 {
        let tree = MeshDistance::new(mesh);
        let n = mesh.triangles.len() as u32;
        let pairs = (0..n).flat_map(|f| (f + 1..n).map(move |g| (f, g)));
        pairs
            .filter(|&(f, g)| {
                cross_of([f, g].map(|f| (tree.corners(f), tree.normal(f))), tolerance, Through::Inside).is_some()
            })
            .count() as u64
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
        let within = meetings(&MeshDistance::new(&both), |f, g| (f < n) == (g < n), 1e-9);
        assert_eq!(within, Meetings::default());
    }
}
