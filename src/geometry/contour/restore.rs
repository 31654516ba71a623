//! Vertices that were drawn away from their places, put back as far as no facets cross.

use super::crowd::{Crowd, MEETING};
use super::surface::NEAREST;
use crate::geometry::bvh::{Bounds, Bvh, bounds_of};
use crate::geometry::health::{neighbours, triangles_cross};
use crate::geometry::mesh::TriangleMesh;
use crate::geometry::vector::{Vec3, add, bounds, corners_of, distance, hull, scale};
use rustc_hash::FxHashMap;

/// How far off its way back a vertex may go, in spacings.
const REACH: f64 = 0.5;

/// How often the part of its way that a vertex cannot go is halved.
const HALVINGS: usize = 4;

/// How far along the edges around it a vertex slides to find room, in eighths of them.
const SLIDES: usize = 4;

/// Facets cross by at most this, in spacings, when a vertex is put back: less than what counts, since others are cut from them.
const CLEAR: f64 = 0.1 * MEETING;

/// How often each vertex is put back: what went later may have made room.
const ROUNDS: usize = 2;

impl Crowd {
    /// Puts vertices of a mesh whose facets do not cross back to the places given with them, the farthest first, as far as still none do; those
    /// that find no room all the way, onto the surface beside theirs, if there is. `onto(p)` is the point of it nearest to one near it.
    ///
    /// # Cost
    /// A tree over the facets near what is put back, if anything is; for each vertex the facets around it against those near
    /// it, once for most and up to eighty times for some.
    pub(in crate::geometry) fn put_back(
        &self,
        mesh: &mut TriangleMesh,
        drawn: &[(u32, Vec3)],
        onto: impl Fn(Vec3) -> Vec3,
    ) {
        if drawn.is_empty() {
            return;
        }
        let room = Room::of(mesh, self, drawn);
        let mut away = drawn.to_vec();
        // Those first that are farthest away.
        let off = |&(v, place): &(u32, Vec3)| distance(mesh.vertices[v as usize], place);
        away.sort_by(|a, b| off(b).total_cmp(&off(a)).then(a.0.cmp(&b.0)));
        for _ in 0..ROUNDS {
            away.retain(|&(v, place)| {
                let Some(near) = room.near(mesh, v) else { return false };
                !near.goes_back(mesh, place) && !near.goes_onto(mesh, &onto)
            });
        }
    }
}

/// The facets that may meet what is put back.
struct Room {
    /// Those around each vertex that is, and their box wherever it goes.
    fans: FxHashMap<u32, (Vec<u32>, Bounds)>,
    /// A tree of all, by the boxes of each wherever its corners go.
    tree: Bvh,
    /// Where each vertex may go.
    ways: FxHashMap<u32, Bounds>,
    h: f64,
}

impl Room {
    fn of(mesh: &TriangleMesh, crowd: &Crowd, drawn: &[(u32, Vec3)]) -> Self {
        let h = crowd.h();
        let way = |&(v, place): &(u32, Vec3)| {
            let from = mesh.vertices[v as usize];
            let (lo, hi) = hull((from, from), (place, place));
            (v, (lo.map(|x| x - REACH * h), hi.map(|x| x + REACH * h)))
        };
        let ways: FxHashMap<u32, Bounds> = drawn.iter().map(way).collect();
        let facets = crowd.at(ways.values().flat_map(|&bounds| corners_of(bounds))).facets(mesh);
        let corner = |v: u32| {
            let p = mesh.vertices[v as usize];
            ways.get(&v).copied().unwrap_or((p, p))
        };
        let boxes = bounds_of(facets.len(), |at| {
            let [a, b, c] = mesh.triangles[facets[at] as usize].map(corner);
            hull(hull(a, b), c)
        });
        let mut fans: FxHashMap<u32, (Vec<u32>, Bounds)> = FxHashMap::default();
        for (&f, &bounds) in facets.iter().zip(&boxes) {
            for v in mesh.triangles[f as usize].into_iter().filter(|v| ways.contains_key(v)) {
                let fan = fans.entry(v).or_insert((Vec::new(), bounds));
                fan.0.push(f);
                fan.1 = hull(fan.1, bounds);
            }
        }
        Room { fans, tree: Bvh::new(&boxes).renamed(&facets), ways, h }
    }

    /// What is near a vertex that is put back.
    fn near(&self, mesh: &TriangleMesh, vertex: u32) -> Option<Near<'_>> {
        let ((fan, bounds), &way) = (self.fans.get(&vertex)?, self.ways.get(&vertex)?);
        let mut others = Vec::new();
        self.tree.in_box(*bounds, |f| {
            if !fan.contains(&f) {
                others.push(Facet::of(mesh, f));
            }
        });
        Some(Near { vertex, fan, others, way, h: self.h })
    }
}

/// A facet where it is.
struct Facet {
    corners: [u32; 3],
    plane: ([Vec3; 3], Vec3),
    bounds: Bounds,
}

impl Facet {
    fn of(mesh: &TriangleMesh, f: u32) -> Self {
        let places = mesh.corners(f as usize);
        Facet {
            corners: mesh.triangles[f as usize],
            plane: (places, mesh.normal(f as usize)),
            bounds: bounds(places).unwrap_or_default(),
        }
    }

    fn crosses(&self, other: &Facet, by: f64) -> bool {
        let ((lo, hi), (from, to)) = (self.bounds, other.bounds);
        (0..3).all(|a| lo[a] <= to[a] && from[a] <= hi[a])
            && !neighbours(self.corners, other.corners)
            && triangles_cross(self.plane, other.plane, by)
    }
}

/// A vertex, the facets around it, and those that they may meet.
struct Near<'a> {
    vertex: u32,
    fan: &'a [u32],
    others: Vec<Facet>,
    way: Bounds,
    h: f64,
}

impl Near<'_> {
    /// Moves the vertex as far to a place as there is room, and says whether that is all the way.
    fn goes_back(&self, mesh: &mut TriangleMesh, place: Vec3) -> bool {
        if self.goes(mesh, place) {
            return true;
        }
        let from = mesh.vertices[self.vertex as usize];
        let (mut at, mut beyond) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let t = 0.5 * (at + beyond);
            if self.goes(mesh, between(from, place, t)) { at = t } else { beyond = t }
        }
        false
    }

    /// Moves the vertex onto the surface, to the point next to it or along the edges around it, the nearest of these where there is room,
    /// and says whether there is.
    fn goes_onto(&self, mesh: &mut TriangleMesh, onto: &impl Fn(Vec3) -> Vec3) -> bool {
        let at = mesh.vertices[self.vertex as usize];
        let on = onto(at);
        if on == at || self.goes(mesh, on) {
            return true;
        }
        let next = |&f: &u32| {
            let corners = mesh.triangles[f as usize];
            let own = corners.iter().position(|&v| v == self.vertex)?;
            Some(mesh.vertices[corners[(own + 1) % 3] as usize])
        };
        let ring: Vec<Vec3> = self.fan.iter().filter_map(next).collect();
        let slid = (1..=SLIDES).flat_map(|n| ring.iter().map(move |&p| between(at, p, 0.125 * n as f64)));
        slid.map(onto).any(|on| self.goes(mesh, on))
    }

    /// Moves the vertex if there is room for it: within its way, where no facet around it crosses another and no vertex lies.
    fn goes(&self, mesh: &mut TriangleMesh, to: Vec3) -> bool {
        let within = (0..3).all(|a| self.way.0[a] <= to[a] && to[a] <= self.way.1[a]);
        if !within {
            return false;
        }
        let from = std::mem::replace(&mut mesh.vertices[self.vertex as usize], to);
        let fan: Vec<Facet> = self.fan.iter().map(|&f| Facet::of(mesh, f)).collect();
        let own = |f: &Facet| (0..3).all(|c| f.corners[c] == self.vertex || self.apart(f.plane.0[c], to));
        let apart = fan.iter().all(own) && self.others.iter().all(|f| f.plane.0.iter().all(|&p| self.apart(p, to)));
        let crosses =
            |(n, f): (usize, &Facet)| fan.iter().take(n).chain(&self.others).any(|g| f.crosses(g, CLEAR * self.h));
        let free = apart && !fan.iter().enumerate().any(crosses);
        if !free {
            mesh.vertices[self.vertex as usize] = from;
        }
        free
    }

    fn apart(&self, p: Vec3, q: Vec3) -> bool {
        distance(p, q) > 0.1 * NEAREST * self.h
    }
}

/// The point so far on the way between two.
fn between(p: Vec3, q: Vec3, t: f64) -> Vec3 {
    add(scale(p, 1.0 - t), scale(q, t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Indicator;
    use crate::grid::Grid;
    use crate::units::Length;

    /// A fan about each apex over a square of side 2 at its height.
    fn pyramids(apexes: &[(Vec3, f64)]) -> TriangleMesh {
        let mut mesh = TriangleMesh::default();
        for &(apex, base) in apexes {
            let first = mesh.vertices.len() as u32;
            mesh.vertices.push(apex);
            mesh.vertices.extend([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| [x, y, base]));
            mesh.triangles.extend((0..4).map(|n| [first, first + 1 + n, first + 1 + (n + 1) % 4]));
        }
        mesh
    }

    fn put_back(mesh: &mut TriangleMesh, place: Vec3, onto: impl Fn(Vec3) -> Vec3) -> Vec3 {
        let grid = Grid::new([-3.0; 3], Length::mm(1.0), [7; 3]).unwrap();
        Crowd::about(&Indicator::empty(grid), [[3; 3]]).put_back(mesh, &[(0, place)], onto);
        mesh.vertices[0]
    }

    #[test]
    fn a_vertex_goes_all_the_way_where_nothing_stands_in_it() {
        let mut mesh = pyramids(&[([0.0; 3], 0.0), ([0.1, 0.0, 1.0], 1.0)]);
        assert_eq!(put_back(&mut mesh, [0.0, 0.1, 0.9], |p| p), [0.0, 0.1, 0.9]);
    }

    #[test]
    fn a_vertex_stops_before_another_sheet() {
        let mut mesh = pyramids(&[([0.0; 3], 0.0), ([0.1, 0.0, 1.0], 1.0)]);
        let [x, y, z] = put_back(&mut mesh, [0.0, 0.0, 1.5], |p| p);
        // Sixteenths of its way and, in the second round, of what is left.
        assert!(x == 0.0 && y == 0.0 && (0.9..=1.0 + 1e-5).contains(&z), "{z}");
    }

    #[test]
    fn a_vertex_that_cannot_go_back_slides_along_the_surface() {
        // The surface is a ball on whose top another sheet's apex lies.
        let onto = |p: Vec3| scale(p, 0.9 / crate::geometry::vector::norm(p));
        let mut mesh = pyramids(&[([0.0, 0.0, 0.5], 0.0), ([0.0, 0.0, 0.7], 1.0)]);
        let at = put_back(&mut mesh, [0.0, 0.0, 0.9], onto);
        assert!((crate::geometry::vector::norm(at) - 0.9).abs() < 1e-12 && at[2] > 0.7, "{at:?}");
        let tree = crate::geometry::MeshDistance::new(&mesh);
        assert_eq!(crate::geometry::health::meetings(&tree, |_, _| true, MEETING).crossing.count, 0);
    }
}
