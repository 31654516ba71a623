//! Exact distances from points to a mesh, rays through it, and maximal balls that touch it.

use super::bvh::{Bvh, LEAF, bounds_of};
use super::facet_bounds::{FacetBounds, LANES};
use super::mesh::TriangleMesh;
use super::ray::Ray;
use super::triangle::{closest_pair, closest_point};
use super::vector::{Vec3, along, bounds, dot, norm2, sub};
use super::wide::Wide;
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};

/// The point of a mesh that is nearest to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    pub point: Vec3,
    pub facet: u32,
    pub distance: f64,
}

/// What is nearer touches, millimetres: far below what floats resolve in the coordinates of a part.
const TOUCHING_MM: f64 = 1e-12;

/// A ball that meets no box.
const NOTHING: (Vec3, f64) = ([0.0; 3], 0.0);

/// A mesh with its tree of boxes, ready for distances; all lengths in millimetres.
///
/// # Cost
/// O(T log T) to build, some 300 bytes a facet; a query visits O(log T) boxes of a mesh that is not adversarial.
#[derive(Debug, Clone)]
pub struct MeshDistance {
    triangles: Vec<[Vec3; 3]>,
    normals: Vec<Vec3>,
    tree: Bvh,
    /// The same leaves below boxes four at a time.
    wide: Wide,
    /// For each leaf what tells that its facets are too far.
    leaves: Vec<FacetBounds>,
    /// The number of the leaf whose run starts at a place in the tree's order.
    numbers: Vec<u32>,
}

impl MeshDistance {
    /// The distances to the facets of a mesh.
    pub fn new(mesh: &TriangleMesh) -> Self {
        Self::to_some(mesh, |_| true)
    }

    /// The distances to some facets; facets are numbered in the order given.
    pub fn of_facets(mesh: &TriangleMesh, facets: impl IntoIterator<Item = usize>) -> Self {
        let (triangles, normals): (Vec<_>, Vec<_>) =
            facets.into_iter().map(|f| (mesh.corners(f), mesh.normal(f))).unzip();
        let all: Vec<u32> = (0..triangles.len() as u32).collect();
        Self::over(triangles, normals, &all)
    }

    /// The distances to the facets of a mesh for which `counts` holds; facets keep their numbers.
    pub fn to_some(mesh: &TriangleMesh, counts: impl Fn(usize) -> bool) -> Self {
        let names: Vec<u32> = (0..mesh.triangles.len()).filter(|&f| counts(f)).map(|f| f as u32).collect();
        let (mut triangles, mut normals) = (Vec::new(), Vec::new());
        let facets = (0..mesh.triangles.len()).into_par_iter();
        facets.map(|f| (mesh.corners(f), mesh.normal(f))).unzip_into_vecs(&mut triangles, &mut normals);
        Self::over(triangles, normals, &names)
    }

    /// The distances to the triangles of these numbers.
    fn over(triangles: Vec<[Vec3; 3]>, normals: Vec<Vec3>, numbers: &[u32]) -> Self {
        let of = |n: usize| bounds(triangles[numbers[n] as usize]).unwrap_or_default();
        let tree = Bvh::new(&bounds_of(numbers.len(), of)).renamed(numbers);
        let (leaves, numbers) = leaves(&triangles, &tree);
        MeshDistance { wide: Wide::over(tree.nodes()), triangles, normals, tree, leaves, numbers }
    }

    /// The corners of a facet.
    pub fn corners(&self, facet: u32) -> [Vec3; 3] {
        self.triangles[facet as usize]
    }

    /// Outward unit normal of a facet; zero without area.
    pub fn normal(&self, facet: u32) -> Vec3 {
        self.normals[facet as usize]
    }

    /// The tree of boxes over the facets.
    pub fn tree(&self) -> &Bvh {
        &self.tree
    }

    /// The nearest point of the mesh that is nearer than `within`, if there is one.
    pub fn nearest(&self, p: Vec3, within: f64) -> Option<Nearest> {
        self.nearest_where(p, within, |_, _| true)
    }

    /// The nearest point nearer than `within` that satisfies a predicate on (facet, point).
    ///
    /// Only the nearest point of each facet is offered.
    pub fn nearest_where(&self, p: Vec3, within: f64, accept: impl Fn(u32, Vec3) -> bool) -> Option<Nearest> {
        self.search(p, (None, within * within), 0.0, accept)
    }

    /// The nearest point nearer than `within`, or, where some are nearer than `enough`, any one of those.
    ///
    /// # Cost
    /// As [`nearest`](Self::nearest) where there are none: the first one ends the search, however many facets are about as near.
    pub fn nearest_or_any(&self, p: Vec3, within: f64, enough: f64) -> Option<Nearest> {
        self.search(p, (None, within * within), enough * enough, |_, _| true)
    }

    /// The nearest point of the mesh, sought from a facet that should be near it.
    ///
    /// # Cost
    /// The less, the nearer the facet is: boxes further away are not opened.
    pub fn nearest_from(&self, p: Vec3, facet: u32) -> Nearest {
        let start = self.nearest_of(p, facet);
        self.search(p, (Some(start), start.distance * start.distance), 0.0, |_, _| true).unwrap_or(start)
    }

    /// The point of one facet that is nearest to another point.
    pub fn nearest_of(&self, p: Vec3, facet: u32) -> Nearest {
        let point = closest_point(p, self.triangles[facet as usize]);
        Nearest { point, facet, distance: norm2(sub(p, point)).sqrt() }
    }

    /// How many facets a search for the nearest point nearer than `within` looks at: what it costs.
    ///
    /// # Cost
    /// As the search.
    pub fn looks(&self, p: Vec3, within: f64) -> u64 {
        let mut looks = 0;
        self.wide.nearest(p, within * within, |run, mut best2| {
            looks += run.len() as u64;
            self.each_within(run, p, best2.sqrt(), |f| best2 = best2.min(norm2(sub(p, self.nearest_of(p, f).point))));
            best2
        });
        looks
    }

    /// Whether a point lies behind the facet of its nearest point, and at an edge or a corner behind the facet that it stands most squarely
    /// to: inside, if the facets bound a solid.
    pub fn is_behind(&self, p: Vec3, nearest: &Nearest) -> bool {
        let mut height = 0.0f64;
        self.within(p, nearest.distance * (1.0 + 1e-9), |n| {
            let over = dot(sub(p, n.point), self.normals[n.facet as usize]);
            if over.abs() > height.abs() {
                height = over;
            }
            ControlFlow::Continue(())
        });
        height < 0.0
    }

    /// The nearest acceptable point, if it is nearer than the one found so far, whose squared distance is given; one whose squared
    /// distance is below `enough2` ends the search.
    fn search(
        &self,
        p: Vec3,
        (mut found, best2): (Option<Nearest>, f64),
        enough2: f64,
        accept: impl Fn(u32, Vec3) -> bool,
    ) -> Option<Nearest> {
        self.wide.nearest(p, best2, |run, mut best2| {
            self.each_within(run, p, best2.sqrt(), |f| {
                let q = closest_point(p, self.triangles[f as usize]);
                let d2 = norm2(sub(p, q));
                let nearer = d2 < best2 || (d2 == best2 && found.is_some_and(|n| f < n.facet));
                if nearer && accept(f, q) {
                    best2 = if d2 < enough2 { 0.0 } else { d2 };
                    found = Some(Nearest { point: q, facet: f, distance: d2.sqrt() });
                }
            });
            best2
        });
        found
    }

    /// The facets nearer to a point than a radius, each with its nearest point, in no order, until `visit` breaks.
    ///
    /// # Cost
    /// As a search for the nearest one, and an exact distance for each facet given.
    pub fn within(&self, p: Vec3, radius: f64, mut visit: impl FnMut(Nearest) -> ControlFlow<()>) {
        self.tree.in_shrinking_ball((p, radius), |run, ball| {
            let mut going = ControlFlow::Continue(());
            self.each_within(run, p, radius, |facet| {
                let found = self.nearest_of(p, facet);
                if going.is_continue() && found.distance < radius {
                    going = visit(found);
                }
            });
            if going.is_continue() { ball } else { NOTHING }
        });
    }

    /// Calls `visit` for the facets of a leaf that may be within a distance of a point.
    #[inline(always)]
    fn each_within(&self, run: Range<usize>, p: Vec3, radius: f64, mut visit: impl FnMut(u32)) {
        let near = self.leaves[self.numbers[run.start] as usize].may_be_within(p, radius);
        self.tree.order()[run].iter().zip(near).filter(|(_, near)| *near).for_each(|(&facet, _)| visit(facet));
    }

    /// The first facet met by `p + s·d` for `near < s < far`, with s.
    pub fn first_hit(&self, p: Vec3, d: Vec3, near: f64, far: f64) -> Option<(f64, u32)> {
        let mut found: Option<(f64, u32)> = None;
        let ray = Ray::of(p, d);
        self.wide.along_ray(p, d, far, |run, far| {
            self.tree.order()[run].iter().fold(far, |far, &f| match ray.hit(self.triangles[f as usize]) {
                Some(s) if s > near && (s < far || (s == far && found.is_some_and(|(_, g)| f < g))) => {
                    found = Some((s, f));
                    s
                }
                _ => far,
            })
        });
        found
    }

    /// Least distance to the facets of another mesh if it is below `within`, with the nearest points.
    ///
    /// # Cost
    /// A best-first walk over both trees, which ends where they touch; exact up to rounding.
    pub fn pair_distance(&self, other: &MeshDistance, within: f64) -> Option<(f64, Vec3, Vec3)> {
        let (mine, theirs) = (self.tree.nodes(), other.tree.nodes());
        if mine.is_empty() || theirs.is_empty() {
            return None;
        }
        let mut best2 = within * within;
        let mut found = None;
        let mut stack = vec![(0usize, 0usize, 0.0f64)];
        while let Some((a, b, bound)) = stack.pop() {
            if bound >= best2 {
                continue;
            }
            if best2 <= TOUCHING_MM * TOUCHING_MM {
                break;
            }
            let (na, nb) = (&mine[a], &theirs[b]);
            let pairs: Vec<(usize, usize)> = match (na.children(), nb.children()) {
                (Some(ca), Some(cb)) => ca.into_iter().flat_map(|x| cb.map(|y| (x, y))).collect(),
                (Some(ca), None) => ca.map(|x| (x, b)).to_vec(),
                (None, Some(cb)) => cb.map(|y| (a, y)).to_vec(),
                (None, None) => {
                    for &f in &self.tree.order()[na.run()] {
                        for &g in &other.tree.order()[nb.run()] {
                            let (p, q) = closest_pair(self.corners(f), other.corners(g));
                            let d2 = norm2(sub(p, q));
                            if d2 < best2 {
                                best2 = d2;
                                found = Some((d2.sqrt(), p, q));
                            }
                        }
                    }
                    continue;
                }
            };
            let mut next: Vec<_> = pairs
                .into_iter()
                .map(|(x, y)| {
                    let (lo, hi) = theirs[y].extent();
                    (x, y, mine[x].box_distance2(lo, hi))
                })
                .filter(|n| n.2 < best2)
                .collect();
            next.sort_by(|x, y| y.2.total_cmp(&x.2));
            stack.extend(next);
        }
        found
    }
}

/// What bounds the distances of the facets of each leaf, and the leaves' numbers by the start of their runs.
fn leaves(triangles: &[[Vec3; 3]], tree: &Bvh) -> (Vec<FacetBounds>, Vec<u32>) {
    const { assert!(LEAF == LANES) };
    let runs: Vec<Range<usize>> = tree.nodes().iter().filter(|n| n.children().is_none()).map(|n| n.run()).collect();
    let mut numbers = vec![0; tree.order().len()];
    for (number, run) in runs.iter().enumerate() {
        numbers[run.start] = number as u32;
    }
    let bounds = |run: &Range<usize>| FacetBounds::of(tree.order()[run.clone()].iter().map(|&f| triangles[f as usize]));
    (runs.par_iter().map(bounds).collect(), numbers)
}

/// A ball on one side of a surface that touches it in two points and holds none of it inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TouchingBall {
    pub centre: Vec3,
    pub radius: f64,
    /// The contact the ball was grown from.
    pub from: Vec3,
    /// The contact that stopped it, and its facet; `None` where nothing stopped it below the cap.
    pub stop: Option<Nearest>,
}

impl TouchingBall {
    /// Angle between the two contacts seen from the centre, radians; 0 without a second contact.
    pub fn separation(&self) -> f64 {
        self.stop.map_or(0.0, |s| super::vector::angle(sub(self.from, self.centre), sub(s.point, self.centre)))
    }
}

impl MeshDistance {
    /// The largest empty ball that touches the surface at `p` and lies on the side of `inward`, up to radius `cap`.
    ///
    /// max { r ≤ cap : B(p + r·m, r) ∩ ∂S = ∅ } by shrinking: a ball that holds a point q is replaced by the one
    /// through p and q, r = |q − p|² / 2 m·(q − p), until it holds none.
    /// `tolerance` is what a surface point may intrude; `p` lies on the surface and `inward` is a unit vector.
    ///
    /// # Source
    /// J. Ma, S. W. Bae, S. Choi, *3D medial axis point approximation using nearest neighbors and the normal field*,
    /// The Visual Computer 28, 2012, here with exact nearest points of facets.
    pub fn touching_ball(&self, p: Vec3, inward: Vec3, cap: f64, tolerance: f64) -> TouchingBall {
        let mut ball = TouchingBall { centre: along(p, inward, cap), radius: cap, from: p, stop: None };
        // Balls that touch at p lie in each other as they shrink: what one walk has left out, none of them holds.
        self.tree.in_shrinking_ball((ball.centre, ball.radius), |run, (centre, radius)| {
            self.each_within(run, centre, radius, |facet| self.shrink_off(facet, inward, tolerance, &mut ball));
            (ball.centre, ball.radius)
        });
        ball
    }

    /// Shrinks a ball that touches at `ball.from` until a facet intrudes by no more than the tolerance.
    #[inline]
    fn shrink_off(&self, facet: u32, inward: Vec3, tolerance: f64, ball: &mut TouchingBall) {
        let p = ball.from;
        for _ in 0..64 {
            let point = closest_point(ball.centre, self.triangles[facet as usize]);
            let least = ball.radius - tolerance;
            let d2 = norm2(sub(point, ball.centre));
            if least <= 0.0 || d2 >= least * least {
                return;
            }
            let chord = sub(point, p);
            let depth = dot(inward, chord);
            let radius = norm2(chord) / (2.0 * depth);
            if !(depth > 0.0 && radius < ball.radius) {
                return;
            }
            let stop = Nearest { point, facet, distance: radius };
            *ball = TouchingBall { centre: along(p, inward, radius), radius, from: p, stop: Some(stop) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn nearest_and_rays_of_a_box() {
        let m = MeshDistance::new(&cuboid([0.0; 3], [2.0, 3.0, 4.0]));
        let n = m.nearest([1.0, 1.5, 5.0], f64::INFINITY).unwrap();
        assert_eq!((n.point, n.distance), ([1.0, 1.5, 4.0], 1.0));
        assert!(m.nearest([1.0, 1.5, 5.0], 0.9).is_none());
        let (s, f) = m.first_hit([1.1, 1.5, -1.0], [0.0, 0.0, 1.0], 0.0, 100.0).unwrap();
        assert_eq!((s, m.normal(f)), (1.0, [0.0, 0.0, -1.0]));
    }

    #[test]
    fn searches_find_what_looking_at_every_facet_finds() {
        let mut random = crate::random::Lcg(11);
        // Facets large and small, needles, and copies whose distances are equal.
        let mut facets: Vec<[Vec3; 3]> = (0..700)
            .map(|n| {
                let (base, size) = (random.point(-10.0, 10.0), [0.1, 1.0, 8.0][n % 3]);
                let [a, b, c] = [0; 3].map(|_| along(base, random.point(-1.0, 1.0), size));
                if n % 7 == 0 { [a, b, along(a, c, 1e-5)] } else { [a, b, c] }
            })
            .collect();
        facets.extend_from_within(..100);
        let mesh = MeshDistance::new(&TriangleMesh::weld(facets));
        for n in 0..3000 {
            let p = random.point(-12.0, 12.0);
            let all: Vec<Nearest> = (0..mesh.triangles.len() as u32).map(|f| mesh.nearest_of(p, f)).collect();
            let least = |some: &[Nearest]| *some.iter().min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap();
            let want = least(&all);
            assert_eq!(mesh.nearest(p, f64::INFINITY).unwrap().distance, want.distance);
            assert_eq!(mesh.nearest_from(p, n % 800).facet, want.facet);
            assert!(mesh.nearest(p, want.distance * (1.0 - 1e-12)).is_none());
            let enough = want.distance * [0.5, 1.5][n as usize % 2];
            let some = mesh.nearest_or_any(p, f64::INFINITY, enough).unwrap().distance;
            assert!(some == want.distance || some < enough, "{n}: {some}");
            let odd: Vec<Nearest> = all.iter().filter(|n| n.facet % 2 == 1).copied().collect();
            let found = mesh.nearest_where(p, f64::INFINITY, |f, _| f % 2 == 1).unwrap();
            assert_eq!(found.distance, least(&odd).distance);
            let radius = want.distance + 2.0 * random.unit();
            let mut within = Vec::new();
            mesh.within(p, radius, |n| {
                within.push(n.facet);
                ControlFlow::Continue(())
            });
            within.sort_unstable();
            let wanted: Vec<u32> = all.iter().filter(|n| n.distance < radius).map(|n| n.facet).collect();
            assert_eq!(within, wanted);
        }
    }

    #[test]
    fn rays_meet_first_what_looking_at_every_facet_says() {
        let mut random = crate::random::Lcg(12);
        let on_lattice = |p: Vec3, n: usize| if n.is_multiple_of(2) { p.map(f64::round) } else { p };
        let facets: Vec<[Vec3; 3]> = (0..600)
            .map(|n| {
                let base = random.point(-6.0, 6.0);
                [0; 3].map(|_| on_lattice(along(base, random.point(-1.0, 1.0), [0.5, 3.0][n % 2]), n))
            })
            .collect();
        let mesh = MeshDistance::new(&TriangleMesh::weld(facets));
        let mut met = 0;
        for n in 0..4000 {
            let p = on_lattice(random.point(-7.0, 7.0), n);
            let d = match n % 4 {
                0 => [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [-0.0, 0.0, 1.0]][n / 4 % 3],
                1 => [0.6, 0.0, 0.8],
                _ => super::super::vector::unit(random.point(-1.0, 1.0)),
            };
            let (near, far) = (0.1 * random.unit(), [0.5, 4.0, f64::INFINITY][n % 3]);
            let hit = |f: u32| {
                Ray::of(p, d).hit(mesh.triangles[f as usize]).filter(|s| *s > near && *s < far).map(|s| (s, f))
            };
            let all = (0..mesh.triangles.len() as u32).filter_map(hit);
            let want = all.min_by(|a, b| a.0.total_cmp(&b.0));
            assert_eq!(mesh.first_hit(p, d, near, far), want, "{p:?} {d:?}");
            met += usize::from(want.is_some());
        }
        assert!(met > 1000, "{met}");
    }

    #[test]
    fn the_ball_in_a_slab_has_the_slabs_thickness() {
        let m = MeshDistance::new(&cuboid([0.0; 3], [20.0, 20.0, 0.5]));
        let b = m.touching_ball([7.0, 9.0, 0.5], [0.0, 0.0, -1.0], 10.0, 1e-9);
        assert!((b.radius - 0.25).abs() < 1e-12 && (b.separation() - std::f64::consts::PI).abs() < 1e-9);
        // Near a convex edge the neighbouring face stops the ball at a right angle.
        let b = m.touching_ball([0.1, 9.0, 0.5], [0.0, 0.0, -1.0], 10.0, 1e-9);
        assert!((b.radius - 0.1).abs() < 1e-9 && (b.separation().to_degrees() - 90.0).abs() < 1e-3);
    }

    #[test]
    fn pair_distance_of_two_boxes() {
        let a = MeshDistance::new(&cuboid([0.0; 3], [1.0; 3]));
        let b = MeshDistance::new(&cuboid([1.3, 0.2, 1.4], [2.0; 3]));
        let (d, p, q) = a.pair_distance(&b, 10.0).unwrap();
        assert!((d - 0.5).abs() < 1e-12 && (p[0] - 1.0).abs() < 1e-12 && (q[0] - 1.3).abs() < 1e-12, "{d} {p:?} {q:?}");
        assert!(a.pair_distance(&b, 0.499).is_none());
    }
}
