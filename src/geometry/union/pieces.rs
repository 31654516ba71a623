//! The pieces that a facet falls into along its cuts.

use super::cuts::{Cuts, edges};
use crate::geometry::TriangleMesh;
use crate::geometry::triangle::closest_point;
use crate::geometry::vector::{Vec3, distance};
use rustc_hash::FxHashMap;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::BTreeMap;

/// The triangles of points that the facets of a mesh fall into along their cuts; a facet that cannot be cut stays whole.
///
/// # Cost
/// For each facet that something meets, a constrained Delaunay triangulation and a comparison of its points with its segments.
pub(super) fn pieces(mesh: &TriangleMesh, cuts: &mut Cuts, tolerance: f64) -> Vec<[u32; 3]> {
    let mut pieces = Vec::new();
    for (facet, &triangle) in (0u32..).zip(&mesh.triangles) {
        if cuts.is_needle(facet) {
            continue;
        }
        let net = cuts.is_cut(facet).then(|| {
            let plane = Flat::of(mesh, facet)?;
            Net::of((facet, triangle), &plane, cuts, tolerance)
        });
        match net.flatten() {
            Some(net) => pieces.extend(net.pieces(triangle, cuts, tolerance)),
            None => pieces.push(triangle),
        }
    }
    pieces
}

/// The plane of a facet seen along an axis, so that the facet runs counter-clockwise.
struct Flat {
    axes: [usize; 2],
    dropped: usize,
    corner: Vec3,
    normal: Vec3,
}

impl Flat {
    fn of(mesh: &TriangleMesh, facet: u32) -> Option<Self> {
        let normal = mesh.normal(facet as usize);
        let dropped = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()))?;
        let (a, b) = ((dropped + 1) % 3, (dropped + 2) % 3);
        let axes = if normal[dropped] > 0.0 { [a, b] } else { [b, a] };
        (normal[dropped] != 0.0).then(|| Flat { axes, dropped, corner: mesh.corners(facet as usize)[0], normal })
    }

    fn seen(&self, p: Vec3) -> Point2<f64> {
        // Far below every tolerance, and too small for the triangulation.
        let x = |a: usize| if p[a].abs() < 1e-100 { 0.0 } else { p[a] };
        Point2::new(x(self.axes[0]), x(self.axes[1]))
    }

    fn lifted(&self, seen: Point2<f64>) -> Vec3 {
        let (mut p, [a, b]) = ([0.0; 3], self.axes);
        (p[a], p[b]) = (seen.x, seen.y);
        let off = self.normal[a] * (seen.x - self.corner[a]) + self.normal[b] * (seen.y - self.corner[b]);
        p[self.dropped] = self.corner[self.dropped] - off / self.normal[self.dropped];
        p
    }
}

/// The triangulation of a facet and the points of its vertices.
#[derive(Default)]
struct Net {
    net: ConstrainedDelaunayTriangulation<Point2<f64>>,
    point: FxHashMap<FixedVertexHandle, u32>,
}

impl Net {
    fn of((facet, triangle): (u32, [u32; 3]), plane: &Flat, cuts: &mut Cuts, tolerance: f64) -> Option<Self> {
        let mut made = Net::default();
        let mut handles: BTreeMap<u32, FixedVertexHandle> = BTreeMap::new();
        let segments = &cuts.segments.get(&facet).cloned().unwrap_or_default()[..];
        let crossed: Vec<u32> = crossings(segments, plane, cuts);
        let cuts = &*cuts;
        let on_edges = edges(triangle).into_iter().filter_map(|e| cuts.on_edge.get(&e)).flatten();
        for &p in triangle.iter().chain(on_edges).chain(segments.iter().flatten()).chain(&crossed) {
            let handle = made.net.insert(plane.seen(cuts.points.place(p))).ok()?;
            made.point.entry(handle).or_insert(p);
            handles.insert(p, handle);
        }
        let drawn = edges(triangle).into_iter().chain(segments.iter().copied());
        for ends in drawn {
            made.draw_through(ends, (&handles, cuts), tolerance)?;
        }
        Some(made)
    }

    /// Draws a segment from point to point, through all that lie on it; `None` where another is in the way.
    fn draw_through(
        &mut self,
        ends: [u32; 2],
        (handles, cuts): (&BTreeMap<u32, FixedVertexHandle>, &Cuts),
        tolerance: f64,
    ) -> Option<()> {
        let [a, b] = ends.map(|p| cuts.points.place(p));
        let on = |p: &u32| {
            let place = cuts.points.place(*p);
            distance(closest_point(place, [a, b, b]), place) <= tolerance
        };
        let far = |p: &u32| distance(cuts.points.place(*p), a);
        let mut chain: Vec<u32> = handles.keys().copied().filter(on).collect();
        chain.sort_by(|p, q| far(p).total_cmp(&far(q)));
        let chain: Vec<FixedVertexHandle> = chain.iter().filter_map(|p| handles.get(p).copied()).collect();
        chain.windows(2).all(|w| self.draw([w[0], w[1]])).then_some(())
    }

    /// Draws a segment, unless it would cross another.
    fn draw(&mut self, [a, b]: [FixedVertexHandle; 2]) -> bool {
        a == b || !self.net.try_add_constraint(a, b).is_empty()
    }

    /// The pieces as triangles of points.
    fn pieces(&self, triangle: [u32; 3], cuts: &Cuts, tolerance: f64) -> Vec<[u32; 3]> {
        let point = |v: &FixedVertexHandle| self.point.get(v).copied().unwrap_or_default();
        let ends = edges(triangle).map(|e| e.map(|v| cuts.points.place(v)));
        // The edges of the facet that a point is on, a bit for each.
        let borders = |p: u32| {
            let near = |[a, b]: [Vec3; 2]| {
                let place = cuts.points.place(p);
                distance(closest_point(place, [a, b, b]), place) <= tolerance
            };
            (0..3).fold(0u8, |bits, i| bits | u8::from(near(ends[i])) << i)
        };
        let corners = self.net.inner_faces().map(|face| face.vertices().map(|v| point(&v.fix())));
        // What lies between an edge and the points on it is no piece.
        let whole = |t: &[u32; 3]| {
            let distinct = t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
            distinct && t.iter().fold(7, |bits, &p| bits & borders(p)) == 0
        };
        corners.filter(whole).collect()
    }
}

/// The points in which the segments of a facet cross each other.
fn crossings(segments: &[[u32; 2]], plane: &Flat, cuts: &mut Cuts) -> Vec<u32> {
    let ends: Vec<[Point2<f64>; 2]> = segments.iter().map(|s| s.map(|p| plane.seen(cuts.points.place(p)))).collect();
    let mut found = Vec::new();
    for (n, &[a, b]) in ends.iter().enumerate() {
        for &[c, d] in &ends[..n] {
            let turn =
                |p: Point2<f64>, q: Point2<f64>, r: Point2<f64>| (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
            let [c_side, d_side] = [turn(a, b, c), turn(a, b, d)];
            if c_side * d_side < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0 {
                let share = c_side / (c_side - d_side);
                let met = Point2::new(c.x + share * (d.x - c.x), c.y + share * (d.y - c.y));
                found.push(cuts.points.at(plane.lifted(met)));
            }
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}
