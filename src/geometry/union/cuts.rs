//! Where the facets of a mesh cut each other.

use super::points::Points;
use crate::geometry::health::pairs::{groups, near_pairs};
use crate::geometry::triangle::closest_point;
use crate::geometry::vector::{Vec3, along, cross, distance, dot, norm, sub, unit};
use crate::geometry::{MeshDistance, TriangleMesh};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Facets whose normals are at less than this sine to each other meet in no line that is known well.
const PARALLEL: f64 = 1e-9;

/// The points and the segments in which the facets of a mesh meet others.
pub(super) struct Cuts<'a> {
    mesh: &'a TriangleMesh,
    tolerance: f64,
    pub(super) points: Points,
    /// Points within the edges of the mesh, each edge by its vertices, the lesser first.
    pub(super) on_edge: BTreeMap<[u32; 2], Vec<u32>>,
    /// The segments within each facet that others cut it along.
    pub(super) segments: BTreeMap<u32, Vec<[u32; 2]>>,
}

/// A facet, its corners and its unit normal.
#[derive(Clone, Copy)]
struct Facet {
    number: u32,
    vertices: [u32; 3],
    corners: [Vec3; 3],
    normal: Vec3,
}

impl<'a> Cuts<'a> {
    /// All cuts of a mesh; what is nearer than the tolerance meets.
    ///
    /// # Cost
    /// O(T log T + pairs of facets whose boxes meet).
    pub(super) fn of(mesh: &'a TriangleMesh, tree: &MeshDistance, tolerance: f64) -> Self {
        let found = groups(tree.tree()).map_init(Vec::new, |near, group| {
            let mut pairs = Vec::new();
            near_pairs(tree.tree(), &|f| tree.corners(f), group, tolerance, near, |f, g| {
                let met = met([f, g].map(|f| Facet::of(mesh, f)), tolerance);
                pairs.extend(met.map(|met| ([f, g], met)));
            });
            pairs
        });
        let mut pairs: Vec<([u32; 2], Met)> = found.flatten_iter().collect();
        // Points are numbered in the order of the facets, whatever the tree.
        pairs.par_sort_unstable_by_key(|(pair, _)| *pair);
        let points = Points::new(&mesh.vertices, tolerance);
        let (on_edge, segments) = Default::default();
        let mut cuts = Cuts { mesh, tolerance, points, on_edge, segments };
        pairs.into_iter().for_each(|(pair, met)| cuts.cut(pair.map(|f| Facet::of(mesh, f)), met));
        cuts.share_along_needles();
        cuts
    }

    /// The numbers of the facets that have points of others on them.
    pub(super) fn is_cut(&self, facet: u32) -> bool {
        self.segments.contains_key(&facet) || edges(self.triangle(facet)).iter().any(|e| self.on_edge.contains_key(e))
    }

    /// Whether a facet is no wider than the tolerance: its sides are one and the same line, and it falls into no pieces.
    pub(super) fn is_needle(&self, facet: u32) -> bool {
        Facet::of(self.mesh, facet).is_needle(self.tolerance)
    }

    /// Notes what is on one side of a needle on its other sides, and so on over all needles beside it.
    fn share_along_needles(&mut self) {
        let all = (0..self.mesh.triangles.len() as u32).map(|f| Facet::of(self.mesh, f));
        let needles: Vec<Facet> = all.filter(|f| f.is_needle(self.tolerance)).collect();
        loop {
            let before: usize = self.on_edge.values().map(Vec::len).sum();
            for needle in &needles {
                let sides = edges(needle.vertices);
                let on_sides = sides.iter().filter_map(|e| self.on_edge.get(e)).flatten();
                let points: Vec<u32> = on_sides.chain(&needle.vertices).copied().collect();
                points.into_iter().for_each(|point| self.note_on_edges(needle, point));
            }
            self.on_edge.values_mut().for_each(|points| {
                points.sort_unstable();
                points.dedup();
            });
            if self.on_edge.values().map(Vec::len).sum::<usize>() == before {
                return;
            }
        }
    }

    fn triangle(&self, facet: u32) -> [u32; 3] {
        self.mesh.triangles.get(facet as usize).copied().unwrap_or_default()
    }

    fn cut(&mut self, [f, g]: [Facet; 2], met: Met) {
        match met {
            Met::InOnePlane => {
                self.cut_in_plane([&f, &g]);
                self.cut_in_plane([&g, &f]);
            }
            Met::Along(ends) => {
                self.note([&f, &g], ends);
                self.note([&g, &f], ends);
            }
        }
    }

    /// Cuts the second of two facets in one plane along what the edges of the first have in it.
    fn cut_in_plane(&mut self, [f, g]: [&Facet; 2]) {
        for i in 0..3 {
            let [p, q] = [f.corners[i], f.corners[(i + 1) % 3]];
            let Some([from, to]) = within(g, [p, q], self.tolerance) else { continue };
            let ends = [from, to].map(|t| along(p, sub(q, p), t));
            if distance(ends[0], ends[1]) > self.tolerance {
                self.note([g, f], ends);
            }
        }
    }

    /// Cuts a facet along a segment that it has in common with another, whose edges get the ends too.
    fn note(&mut self, [f, other]: [&Facet; 2], ends: [Vec3; 2]) {
        let ends = ends.map(|p| self.points.at(p));
        for facet in [f, other] {
            ends.iter().for_each(|&point| self.note_on_edges(facet, point));
        }
        if ends[0] != ends[1] {
            self.segments.entry(f.number).or_default().push([ends[0].min(ends[1]), ends[0].max(ends[1])]);
        }
    }

    fn note_on_edges(&mut self, f: &Facet, point: u32) {
        let p = self.points.place(point);
        for edge in edges(f.vertices) {
            let [a, b] = edge.map(|v| self.points.place(v));
            if !f.vertices.contains(&point) && distance(closest_point(p, [a, b, b]), p) <= self.tolerance {
                self.on_edge.entry(edge).or_default().push(point);
            }
        }
    }
}

impl Facet {
    fn of(mesh: &TriangleMesh, number: u32) -> Self {
        let facet = number as usize;
        let vertices = mesh.triangles.get(facet).copied().unwrap_or_default();
        Facet { number, vertices, corners: mesh.corners(facet), normal: mesh.normal(facet) }
    }

    /// Whether it is no wider than the tolerance.
    fn is_needle(&self, tolerance: f64) -> bool {
        let [a, b, c] = self.corners;
        let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
        norm(cross(sub(b, a), sub(c, a))) <= tolerance * longest
    }

    /// Where the boundary of a facet passes through a plane that its corners have such heights over.
    fn crossed(&self, heights: [f64; 3]) -> Option<[Vec3; 2]> {
        let mut ends: Vec<Vec3> = (0..3).filter(|&i| heights[i] == 0.0).map(|i| self.corners[i]).collect();
        for i in 0..3 {
            let j = (i + 1) % 3;
            if heights[i] * heights[j] < 0.0 {
                // From the lesser vertex, so that both facets of the edge find the same point.
                let (i, j) = if self.vertices[i] < self.vertices[j] { (i, j) } else { (j, i) };
                let share = heights[i] / (heights[i] - heights[j]);
                ends.push(along(self.corners[i], sub(self.corners[j], self.corners[i]), share));
            }
        }
        Some([*ends.first()?, *ends.last()?])
    }

    /// The heights of the corners over the plane of another facet; 0 within the tolerance.
    fn heights_over(&self, other: &Facet, tolerance: f64) -> [f64; 3] {
        self.corners.map(|p| {
            let height = dot(sub(p, other.corners[0]), other.normal);
            if height.abs() <= tolerance { 0.0 } else { height }
        })
    }
}

/// The edges of a facet, the lesser vertex first.
pub(super) fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(|[u, v]| [u.min(v), u.max(v)])
}

/// How two facets meet.
#[derive(Clone, Copy)]
enum Met {
    InOnePlane,
    /// In a segment or a point.
    Along([Vec3; 2]),
}

/// How two facets cut each other, if they do: not in a corner that is theirs, and neighbours over an edge only if one is folded onto the
/// other.
fn met([f, g]: [Facet; 2], tolerance: f64) -> Option<Met> {
    if [f, g].iter().any(|f| f.is_needle(tolerance)) {
        return None;
    }
    let heights = [f.heights_over(&g, tolerance), g.heights_over(&f, tolerance)];
    let apart = |h: [f64; 3]| h.iter().all(|x| *x > 0.0) || h.iter().all(|x| *x < 0.0);
    if heights.into_iter().any(apart) {
        return None;
    }
    let shared = f.vertices.iter().filter(|v| g.vertices.contains(v)).count();
    if heights.contains(&[0.0; 3]) {
        return (shared < 2 || shared == 3 || folded(&f, &g)).then_some(Met::InOnePlane);
    }
    let line = cross(f.normal, g.normal);
    if shared > 1 || norm(line) < PARALLEL {
        return None;
    }
    let common = |heights| common([&f, &g], heights, unit(line), tolerance);
    let on_both =
        |p: &Vec3| [&f, &g].iter().all(|facet| distance(closest_point(*p, facet.corners), *p) <= 2.0 * tolerance);
    // A corner that is near the plane of the other, but beside it, is not met.
    let ends = common(heights)
        .filter(|ends| ends.iter().all(on_both))
        .or_else(|| common([f.heights_over(&g, 0.0), g.heights_over(&f, 0.0)]))?;
    let own = |p: Vec3| shared == 1 && f.corners.contains(&p) && g.corners.contains(&p);
    (!ends.into_iter().all(own)).then_some(Met::Along(ends))
}

/// The ends of what two facets have in common along the line in which their planes meet, by the heights of their corners over those.
fn common([f, g]: [&Facet; 2], heights: [[f64; 3]; 2], line: Vec3, tolerance: f64) -> Option<[Vec3; 2]> {
    let ordered = |mut ends: [Vec3; 2]| {
        if dot(ends[0], line) > dot(ends[1], line) {
            ends.reverse();
        }
        ends
    };
    let [a, b] = [ordered(f.crossed(heights[0])?), ordered(g.crossed(heights[1])?)];
    let far = |p: Vec3| dot(p, line);
    let from = if far(a[0]) >= far(b[0]) { a[0] } else { b[0] };
    let to = if far(a[1]) <= far(b[1]) { a[1] } else { b[1] };
    (far(to) - far(from) >= -tolerance).then_some([from, to])
}

/// Whether two facets in one plane with a common edge lie on the same side of it.
fn folded(f: &Facet, g: &Facet) -> bool {
    let tip = |of: &Facet, other: &Facet| (0..3).find(|&i| !other.vertices.contains(&of.vertices[i]));
    let (Some(i), Some(j)) = (tip(f, g), tip(g, f)) else { return false };
    let [a, b] = [f.corners[(i + 1) % 3], f.corners[(i + 2) % 3]];
    let side = |p: Vec3| cross(sub(b, a), sub(p, a));
    dot(side(f.corners[i]), side(g.corners[j])) > 0.0
}

/// The shares of an edge between which it lies in a facet of the same plane, its border included.
fn within(g: &Facet, [p, q]: [Vec3; 2], tolerance: f64) -> Option<[f64; 2]> {
    let mut span = [0.0f64, 1.0];
    for i in 0..3 {
        let side = sub(g.corners[(i + 1) % 3], g.corners[i]);
        let inward = unit(cross(g.normal, side));
        let [a, b] = [p, q].map(|x| dot(sub(x, g.corners[i]), inward));
        let [a, b] = [a, b].map(|x| if x.abs() <= tolerance { 0.0 } else { x });
        match (a < 0.0, b < 0.0) {
            (true, true) => return None,
            (true, false) => span[0] = span[0].max(a / (a - b)),
            (false, true) => span[1] = span[1].min(a / (a - b)),
            (false, false) => {}
        }
    }
    (span[0] <= span[1]).then_some(span)
}
