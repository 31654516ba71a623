//! The surface between samples inside and outside.

use super::crowd::Crowd;
use super::feature::creases_joined;
use super::polygon::{EDGES, Polygon, polygons_of_all_cells};
use super::sheets::{Crossings, Sheets, vertex_on_feature};
use super::uncross::{Fans, uncrossed};
use crate::error::{Error, Result};
use crate::field::{Field, Indicator, SignedDistance};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, add, scale};
use crate::grid::Grid;
use crate::units::Length;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// How near to a sample a vertex may come, as a share of the edge: vertices of different edges stay apart.
pub(super) const NEAREST: f64 = 1e-3;

/// An edge of the lattice, from a sample to its next one along an axis; indices may be −1 at the border of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// The sample it starts at.
    pub from: [isize; 3],
    /// 0, 1 or 2 for x, y, z.
    pub axis: usize,
}

/// The surface between the samples inside a set and all others, its vertices at `crossing(edge)` along each edge from
/// an inside to an outside sample or back: 0 is the edge's first sample, 1 its last.
///
/// The mesh is closed and 2-manifold and wound outwards for every set, and no two of its facets cross. Crossings nearer to a sample than a
/// thousandth of the edge are moved to that distance.
///
/// # Errors
/// [`Error::TooLarge`] if the vertices do not fit 32-bit indices.
///
/// # Cost
/// O(words of the set + facets); two planes of vertex numbers for each thread.
///
/// # Source
/// Lorensen and Cline 1987, with the face rule and the diagonals chosen here.
pub fn surface(inside: &Indicator, crossing: impl Fn(Edge) -> f64 + Sync) -> Result<TriangleMesh> {
    Ok(cut_all(inside, &Crossings(crossing))?.mesh)
}

/// As [`surface`], with vertices on creases and in corners, and creases as edges; and where its sheets come near each other.
///
/// As [`creased_surface`], but that a crease finer than the cells is blunted where facets would cross by more than 1e-5 spacings.
///
/// # Errors
/// As [`surface`].
///
/// # Cost
/// A tree over the facets near creases more.
pub fn sharp_surface(inside: &Indicator, sheets: &impl Sheets) -> Result<(TriangleMesh, Crowd)> {
    let Contour { mut mesh, on_feature, mut fans, mut crowd, aside } = cut_all(inside, sheets)?;
    let onto = |p: Vec3| sheets.onto(p);
    if !aside.is_empty() {
        fans.put_aside(&mut mesh, &crowd, &aside, onto);
        crowd = crowd.and_at(&aside.iter().map(|&(_, place)| place).collect::<Vec<Vec3>>());
    }
    let turned = creases_joined(&mut mesh, &on_feature);
    uncrossed(&mut mesh, &crowd, &fans, &turned, onto);
    Ok((mesh, crowd))
}

/// As [`surface`], with vertices on creases and in corners, and creases as edges.
///
/// Where the normals at the corners of a polygon differ by more than 30°, it becomes a fan about the point nearest to all
/// tangent planes there, and then to those of the same sheets beside that point, if it lies in the cell; an edge between
/// two such fans is turned to run along the crease. Other polygons are cut where the surface bends least. Closed and
/// 2-manifold like [`surface`]; facets may cross where a crease is finer than the cells.
///
/// # Errors
/// As [`surface`].
///
/// # Source
/// L. P. Kobbelt, M. Botsch, U. Schwanecke, H.-P. Seidel, *Feature sensitive surface extraction from volume data*, 2001.
pub fn creased_surface(inside: &Indicator, sheets: &impl Sheets) -> Result<TriangleMesh> {
    let Contour { mut mesh, on_feature, .. } = cut_all(inside, sheets)?;
    creases_joined(&mut mesh, &on_feature);
    Ok(mesh)
}

/// A surface of fans and plain polygons.
struct Contour {
    mesh: TriangleMesh,
    /// Which of its vertices lie on features.
    on_feature: Vec<bool>,
    fans: Fans,
    crowd: Crowd,
    /// Vertices that stand for a place of the surface which is not on their edge.
    aside: Vec<(u32, Vec3)>,
}

/// The surface, polygon by polygon.
///
/// Polygons without a feature are cut from the corner whose diagonals bend least, the first of equals.
fn cut_all<S: Sheets>(inside: &Indicator, sheets: &S) -> Result<Contour> {
    let grid = inside.grid();
    // One sample more on every side, so that the surface closes where the set meets the border.
    let padded = inside.window([-1; 3], grid.dims().map(|n| n + 2))?;
    let cut = Cut::new(&padded);
    let origin = padded.grid().origin();
    let position = |edge: Edge| {
        let (t, note) = sheets.crossing(edge);
        let t = if t.is_finite() { t.clamp(NEAREST, 1.0 - NEAREST) } else { 0.5 };
        let place = [0, 1, 2].map(|a| {
            let step = if a == edge.axis { t } else { 0.0 };
            origin[a] + grid.h() * ((edge.from[a] + 1) as f64 + step)
        });
        (place, note, sheets.aside(edge))
    };
    let of_plane: Vec<Plane<S::Note>> =
        (0..cut.dims[2]).into_par_iter().with_max_len(1).map(|k| cut.vertices_of_plane(k, &position)).collect();
    let mut firsts = vec![0usize];
    firsts.extend(of_plane.iter().scan(0, |sum, plane| {
        *sum += plane.vertices.len();
        Some(*sum)
    }));
    let total = firsts.last().copied().unwrap_or(0);
    if total > (u32::MAX / 2) as usize {
        return Err(Error::TooLarge {
            what: "a surface".into(),
            need_bytes: total as u128 * 24,
            allowed_bytes: u128::from(u32::MAX / 2) * 24,
            remedy: "choose a larger spacing".into(),
        });
    }
    let (mut vertices, mut notes, mut aside) = (Vec::with_capacity(total), Vec::with_capacity(total), Vec::new());
    for plane in of_plane {
        let first = vertices.len() as u32;
        aside.extend(plane.aside.into_iter().map(|(v, place)| (first + v, place)));
        vertices.extend(plane.vertices);
        notes.extend(plane.notes);
    }
    let places: FxHashMap<u32, Vec3> = aside.iter().copied().collect();
    let table = polygons_of_all_cells();
    let slabs: Vec<Slab> = (0..cut.dims[2].saturating_sub(1))
        .into_par_iter()
        .with_max_len(4)
        .map_init(
            || [cut.blank(), cut.blank()],
            |[lower, upper], k| {
                let known = Known { vertices: &vertices, notes: &notes, aside: &places };
                cut.slab(k, [firsts[k], firsts[k + 1]], [lower, upper], &table, known, (grid, sheets))
            },
        )
        .collect();
    let crowd = Crowd::about(&padded, slabs.iter().flat_map(|slab| slab.crowded.iter().copied()));
    Ok(Contour { aside, ..join(slabs, vertices, crowd) })
}

/// The surface `{ d = level }` of a signed distance, negative inside, linear along edges.
///
/// # Errors
/// As [`surface`].
pub fn level_surface(distance: &SignedDistance, level: Length) -> Result<TriangleMesh> {
    let level = level.as_mm() as f32;
    let field = distance.field();
    surface(&distance.at_most(level), |edge| linear_crossing(field, edge, level))
}

/// The surface of the superlevel set `{ f > level }` of a defining function, linear along edges.
///
/// # Errors
/// As [`surface`].
pub fn superlevel_surface(field: &Field<f32>, level: f32) -> Result<TriangleMesh> {
    let inside = Indicator::from_predicate(*field.grid(), |at| field.values()[at] > level);
    surface(&inside, |edge| linear_crossing(field, edge, level))
}

/// Where a field passes a level along an edge, if it were linear there.
pub fn linear_crossing(field: &Field<f32>, edge: Edge, level: f32) -> f64 {
    let mut next = edge.from;
    next[edge.axis] += 1;
    crossing_between(field.at(edge.from), field.at(next), level)
}

/// Where a function with these values at the ends of an edge passes a level, if it were linear between them.
pub fn crossing_between(a: f32, b: f32, level: f32) -> f64 {
    let (a, b) = (f64::from(a), f64::from(b));
    (f64::from(level) - a) / (b - a)
}

/// The vertices on the edges that start in a plane, in order.
struct Plane<N> {
    vertices: Vec<Vec3>,
    notes: Vec<N>,
    /// Those, counted from the first, that stand for a place which is not on their edge.
    aside: Vec<(u32, Vec3)>,
}

/// All vertices on edges, as [`Plane`] has them.
struct Known<'a, N> {
    vertices: &'a [Vec3],
    notes: &'a [N],
    aside: &'a FxHashMap<u32, Vec3>,
}

/// A set with an empty border, seen as edges and cells.
struct Cut<'a> {
    set: &'a Indicator,
    dims: [usize; 3],
}

/// Triangles of one layer of cells, and vertices within polygons: on a feature, or in the middle of a polygon that no
/// diagonal may cut.
#[derive(Default)]
struct Slab {
    centres: Vec<Vec3>,
    /// The middles of their polygons.
    middles: Vec<Vec3>,
    on_feature: Vec<bool>,
    /// Cells that a crease passes, or that hold several polygons or one with a vertex within.
    crowded: Vec<[usize; 3]>,
    /// Corners; those at `CENTRE` and above count centres of this slab.
    triangles: Vec<[u32; 3]>,
}

const CENTRE: u32 = 1 << 31;

impl<'a> Cut<'a> {
    fn new(set: &'a Indicator) -> Self {
        Cut { set, dims: set.grid().dims() }
    }

    fn blank(&self) -> Vec<u32> {
        vec![0; 3 * self.dims[0] * self.dims[1]]
    }

    /// Calls `found(place, edge)` for the crossed edges that start in plane k, in order, and counts them.
    fn edges_of_plane(&self, k: usize, mut found: impl FnMut(usize, Edge)) -> usize {
        let [nx, ny, nz] = self.dims;
        let mut count = 0;
        for j in 0..ny {
            let row = self.set.row(j, k);
            let along_y = (j + 1 < ny).then(|| self.set.row(j + 1, k));
            let along_z = (k + 1 < nz).then(|| self.set.row(j, k + 1));
            for (w, &bits) in row.iter().enumerate() {
                let next = row.get(w + 1).copied().unwrap_or(0);
                let masks = [
                    bits ^ (bits >> 1 | next << 63),
                    along_y.map_or(0, |r| bits ^ r[w]),
                    along_z.map_or(0, |r| bits ^ r[w]),
                ];
                let mut any = masks[0] | masks[1] | masks[2];
                while any != 0 {
                    let bit = any.trailing_zeros() as usize;
                    any &= any - 1;
                    let i = w * 64 + bit;
                    for (axis, mask) in masks.iter().enumerate() {
                        if mask >> bit & 1 == 1 {
                            let from = [i, j, k].map(|x| x as isize - 1);
                            found(3 * (j * nx + i) + axis, Edge { from, axis });
                            count += 1;
                        }
                    }
                }
            }
        }
        count
    }

    /// The vertices on the edges that start in plane k.
    fn vertices_of_plane<N>(&self, k: usize, position: &impl Fn(Edge) -> (Vec3, N, Option<Vec3>)) -> Plane<N> {
        let mut plane = Plane { vertices: Vec::new(), notes: Vec::new(), aside: Vec::new() };
        self.edges_of_plane(k, |_, edge| {
            let (vertex, note, aside) = position(edge);
            plane.aside.extend(aside.map(|place| (plane.vertices.len() as u32, place)));
            plane.vertices.push(vertex);
            plane.notes.push(note);
        });
        plane
    }

    /// The triangles of the cells between plane k and the next; `firsts` are the numbers of the planes' first vertices.
    fn slab<S: Sheets>(
        &self,
        k: usize,
        firsts: [usize; 2],
        numbers: [&mut Vec<u32>; 2],
        table: &[Vec<Polygon>],
        known: Known<'_, S::Note>,
        (grid, sheets): (&Grid, &S),
    ) -> Slab {
        let [lower, upper] = numbers;
        for (plane, (numbers, first)) in [&mut *lower, &mut *upper].into_iter().zip(firsts).enumerate() {
            let mut number = first as u32;
            self.edges_of_plane(k + plane, |place, _| {
                numbers[place] = number;
                number += 1;
            });
        }
        let mut slab = Slab::default();
        let (mut corners, mut places, mut noted) = (Vec::new(), Vec::new(), Vec::new());
        self.cells(k, |i, j, config| {
            for polygon in &table[config] {
                corners.clear();
                corners.extend(polygon.edges.iter().map(|&edge| {
                    let (corner, axis) = EDGES[edge];
                    let place = 3 * ((j + (corner >> 1 & 1)) * self.dims[0] + i + (corner & 1)) + axis;
                    if corner >> 2 & 1 == 1 { upper[place] } else { lower[place] }
                }));
                places.clear();
                let on_edge = |&v: &u32| known.vertices[v as usize];
                places.extend(corners.iter().map(|v| known.aside.get(v).copied().unwrap_or_else(|| on_edge(v))));
                noted.clear();
                noted.extend(corners.iter().map(|&v| known.notes[v as usize]));
                // Cells count from the padded border.
                let cell = [i, j, k].map(|n| n as isize - 1);
                let creased = vertex_on_feature(sheets, grid, cell, &places, &noted);
                if creased.is_some() || table[config].len() > 1 || polygon.fans.is_empty() {
                    slab.crowded.push([i, j, k]);
                }
                let bend = |[a, b]: [usize; 2]| sheets.bend([places[a], places[b]], [noted[a], noted[b]]);
                let middle = || scale(corners.iter().map(on_edge).fold([0.0; 3], add), 1.0 / corners.len() as f64);
                slab.cut_polygon(&polygon.fans, &corners, (creased.flatten(), middle), |p| sheets.onto(p), bend);
            }
        });
        slab
    }

    /// Calls `cell(i, j, configuration)` for the cells above plane k that are cut.
    fn cells(&self, k: usize, mut cell: impl FnMut(usize, usize, usize)) {
        let [_, ny, _] = self.dims;
        for j in 0..ny - 1 {
            let rows = [(j, k), (j + 1, k), (j, k + 1), (j + 1, k + 1)].map(|(j, k)| self.set.row(j, k));
            for w in 0..rows[0].len() {
                let pair = rows.map(|r| (r[w], r[w] >> 1 | r.get(w + 1).copied().unwrap_or(0) << 63));
                let any = pair.iter().fold(0, |m, p| m | p.0 | p.1);
                let all = pair.iter().fold(!0, |m, p| m & p.0 & p.1);
                let mut mixed = any & !all;
                while mixed != 0 {
                    let bit = mixed.trailing_zeros() as usize;
                    mixed &= mixed - 1;
                    let config = pair
                        .iter()
                        .enumerate()
                        .map(|(r, p)| (p.0 >> bit & 1) << (2 * r) | (p.1 >> bit & 1) << (2 * r + 1))
                        .sum::<u64>() as usize;
                    cell(w * 64 + bit, j, config);
                }
            }
        }
    }
}

impl Slab {
    /// Adds a polygon as triangles: a fan about a vertex on a feature, or from a corner, or about its middle.
    fn cut_polygon(
        &mut self,
        fans: &[usize],
        corners: &[u32],
        (on_feature, middle): (Option<Vec3>, impl FnOnce() -> Vec3),
        onto: impl FnOnce(Vec3) -> Vec3,
        bend: impl Fn([usize; 2]) -> f64,
    ) {
        let n = corners.len();
        let corner = |c: usize| corners[c % n];
        let worst = |from: usize| (2..n - 1).map(|d| bend([from, (from + d) % n])).fold(0.0, f64::max);
        let flattest = || match fans {
            [only] => Some(*only),
            _ => fans.iter().map(|&from| (from, worst(from))).min_by(|a, b| a.1.total_cmp(&b.1)).map(|best| best.0),
        };
        if let (None, Some(from)) = (on_feature, flattest()) {
            self.triangles.extend((1..n - 1).map(|d| [corner(from), corner(from + d), corner(from + d + 1)]));
            return;
        }
        let (centre, middle) = (CENTRE + self.centres.len() as u32, middle());
        self.centres.push(on_feature.unwrap_or_else(|| onto(middle)));
        self.middles.push(middle);
        self.on_feature.push(on_feature.is_some());
        self.triangles.extend((0..n).map(|c| [centre, corner(c), corner(c + 1)]));
    }
}

/// One mesh of all slabs.
fn join(slabs: Vec<Slab>, mut vertices: Vec<Vec3>, crowd: Crowd) -> Contour {
    let mut on_feature = vec![false; vertices.len()];
    let mut fans = Fans { first: vertices.len(), middles: Vec::new(), aside: None };
    let mut triangles = Vec::with_capacity(slabs.iter().map(|s| s.triangles.len()).sum());
    for slab in slabs {
        let shift = vertices.len() as u32;
        vertices.extend_from_slice(&slab.centres);
        on_feature.extend_from_slice(&slab.on_feature);
        fans.middles.extend_from_slice(&slab.middles);
        let global = |v: u32| if v >= CENTRE { v - CENTRE + shift } else { v };
        triangles.extend(slab.triangles.iter().map(|t| t.map(global)));
    }
    Contour { mesh: TriangleMesh { vertices, triangles }, on_feature, fans, crowd, aside: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::super::crowd::MEETING;
    use super::*;
    use crate::geometry::Primitive;
    use crate::grid::Grid;
    use rustc_hash::FxHashMap;
    use std::marker::PhantomData;

    /// Every directed edge once, its reverse once, and one ring of facets around every vertex.
    fn assert_manifold(mesh: &TriangleMesh) {
        let mut next: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        let mut corners: FxHashMap<u32, usize> = FxHashMap::default();
        for &[a, b, c] in &mesh.triangles {
            for (p, q, r) in [(a, b, c), (b, c, a), (c, a, b)] {
                assert!(next.insert((p, q), r).is_none(), "edge {p} {q} used twice");
                *corners.entry(p).or_default() += 1;
            }
        }
        for &(p, q) in next.keys() {
            assert!(next.contains_key(&(q, p)), "edge {p} {q} is open");
        }
        for (&v, &count) in &corners {
            let start = next.keys().find(|k| k.0 == v).unwrap().1;
            let (mut at, mut steps) = (start, 0);
            loop {
                at = next[&(v, at)];
                steps += 1;
                if at == start {
                    break;
                }
            }
            assert_eq!(steps, count, "vertex {v} joins two sheets");
        }
    }

    #[test]
    fn random_sets_have_closed_manifold_surfaces_of_the_right_volume_sign() {
        let mut state = 1u64;
        for (dims, one_in) in [([1, 1, 1], 1), ([2, 2, 2], 2), ([6, 5, 4], 2), ([6, 5, 4], 3), ([5, 5, 5], 5)] {
            for _ in 0..30 {
                let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
                let mut set = Indicator::empty(grid);
                for at in 0..grid.samples() {
                    state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                    set.set(grid.index(at), (state >> 33).is_multiple_of(one_in));
                }
                let mesh = surface(&set, |_| 0.5).unwrap();
                assert_manifold(&mesh);
                assert_eq!(set.is_empty(), mesh.triangles.is_empty());
                assert!(set.is_empty() || mesh.signed_volume() > 0.0);
            }
        }
    }

    /// Pairs of facets that cross by more than rounding.
    fn crossings(mesh: &TriangleMesh) -> u64 {
        let tree = crate::geometry::MeshDistance::new(mesh);
        crate::geometry::health::meetings(&tree, |_, _| true, MEETING).crossing.count
    }

    #[test]
    fn no_facets_of_a_plain_surface_cross_whatever_its_set_and_its_crossings() {
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 31) as f64
        };
        // All sets of a cell, and larger ones, with crossings anywhere and at the ends.
        for round in 0..3000 {
            let dims = if round < 2048 { [2; 3] } else { [5, 4, 4] };
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
            let bits: Vec<bool> = (0..grid.samples()).map(|_| random() < 0.5).collect();
            let set = Indicator::from_predicate(grid, |at| if round < 2048 { round >> at & 1 == 1 } else { bits[at] });
            let noise: Vec<f64> = (0..499).map(|_| (random() * 1.6 - 0.3).clamp(0.0, 1.0)).collect();
            let of = |e: Edge| {
                noise
                    [(e.from[0] * 131 + e.from[1] * 57 + e.from[2] * 31 + e.axis as isize * 7).rem_euclid(499) as usize]
            };
            let mesh = surface(&set, of).unwrap();
            assert_eq!(crossings(&mesh), 0, "{round}");
        }
    }

    /// A surface told by functions.
    struct Told<T, C, N, B>(C, N, B, PhantomData<fn() -> T>);

    /// A surface of these crossings and their notes, normals and bends.
    fn told<T, C, N, B>(crossing: C, normals: N, bend: B) -> Told<T, C, N, B>
    where
        C: Fn(Edge) -> (f64, T),
        N: Fn([isize; 3], &[Vec3], &[T]) -> Option<Vec<Vec3>>,
        B: Fn([Vec3; 2], [T; 2]) -> f64,
    {
        Told(crossing, normals, bend, PhantomData)
    }

    impl<T, C, N, B> Sheets for Told<T, C, N, B>
    where
        T: Copy + Send + Sync,
        C: Fn(Edge) -> (f64, T) + Sync,
        N: Fn([isize; 3], &[Vec3], &[T]) -> Option<Vec<Vec3>> + Sync,
        B: Fn([Vec3; 2], [T; 2]) -> f64 + Sync,
    {
        type Note = T;

        fn crossing(&self, edge: Edge) -> (f64, T) {
            (self.0)(edge)
        }

        fn normals(&self, cell: [isize; 3], corners: &[Vec3], notes: &[T]) -> Option<Vec<Vec3>> {
            (self.1)(cell, corners, notes)
        }

        fn bend(&self, ends: [Vec3; 2], notes: [T; 2]) -> f64 {
            (self.2)(ends, notes)
        }
    }

    /// Normals of a shape known in closed form, by central differences.
    fn normals(shape: impl Fn(Vec3) -> f64 + Sync) -> impl Fn([isize; 3], &[Vec3], &[()]) -> Option<Vec<Vec3>> + Sync {
        move |_, corners, _| {
            let step = |p: Vec3, a: usize, by: f64| shape([0, 1, 2].map(|i| p[i] + if i == a { by } else { 0.0 }));
            let slope = |p: Vec3| [0, 1, 2].map(|a| step(p, a, 1e-6) - step(p, a, -1e-6));
            Some(corners.iter().map(|&p| crate::geometry::vector::unit(slope(p))).collect())
        }
    }

    #[test]
    fn creases_and_corners_of_a_turned_box_are_kept() {
        let block = Primitive::parse("box:4x3x2mm").unwrap();
        let (s, c) = 0.5f64.sin_cos();
        let turned = |p: Vec3| {
            let q = [c * p[0] + s * p[1], -s * p[0] + c * p[1], p[2]];
            block.signed_distance([q[0], c * q[1] + s * q[2], -s * q[1] + c * q[2]])
        };
        let grid = Grid::covering([-3.0; 3], [3.0; 3], Length::mm(0.25), 1, [0.13, 0.4, 0.2]).unwrap();
        let values = (0..grid.samples()).map(|at| turned(grid.position(grid.index(at))) as f32);
        let field = Field::from_values(grid, values.collect(), 1.0).unwrap();
        let inside = Indicator::from_predicate(grid, |at| field.values()[at] <= 0.0);
        let crossing = |edge: Edge| {
            let at = |t: f64| {
                [0, 1, 2]
                    .map(|a| grid.origin()[a] + 0.25 * (edge.from[a] as f64 + if a == edge.axis { t } else { 0.0 }))
            };
            let (mut lo, mut hi, sign) = (0.0, 1.0, turned(at(0.0)) <= 0.0);
            for _ in 0..40 {
                let t = 0.5 * (lo + hi);
                if (turned(at(t)) <= 0.0) == sign { lo = t } else { hi = t }
            }
            lo
        };
        let blunt = surface(&inside, crossing).unwrap();
        let (sharp, _) =
            sharp_surface(&inside, &told(|edge| (crossing(edge), ()), normals(turned), |_, _| 0.0)).unwrap();
        assert_manifold(&sharp);
        let missing = |mesh: &TriangleMesh| (24.0 - mesh.signed_volume()).abs();
        // Chords across 36 mm of edges cost a strip of about h²/12 each; with features only cells at corners are short.
        assert!(missing(&blunt) > 0.1, "{}", missing(&blunt));
        println!("turned box: {} blunt, {} sharp", missing(&blunt), missing(&sharp));
        assert!(missing(&sharp) < 0.1 * missing(&blunt), "{} {}", missing(&sharp), missing(&blunt));
        let farthest = sharp.vertices.iter().map(|&p| turned(p).abs()).fold(0.0, f64::max);
        assert!(farthest < 0.1 * 0.25, "{farthest}");
    }

    #[test]
    fn a_sharp_surface_is_manifold_whatever_the_normals_say() {
        let mut state = 5u64;
        let mut random = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 31) as f64
        };
        for _ in 0..60 {
            let grid = Grid::new([0.0; 3], Length::mm(1.0), [6, 5, 4]).unwrap();
            let bits: Vec<bool> = (0..grid.samples()).map(|_| random() < 0.4).collect();
            let noise: Vec<Vec3> = (0..997).map(|_| [0; 3].map(|_| random() - 0.5)).collect();
            let set = Indicator::from_predicate(grid, |at| bits[at]);
            let normal = |p: &Vec3| {
                let at = (p[0] * 131.0 + p[1] * 57.0 + p[2] * 31.0).abs() as usize;
                crate::geometry::vector::unit(noise[at % 997])
            };
            let normals = |_: [isize; 3], corners: &[Vec3], _: &[()]| Some(corners.iter().map(normal).collect());
            let (mesh, _) = sharp_surface(&set, &told(|_| (0.5, ()), normals, |_, _| 0.0)).unwrap();
            assert_manifold(&mesh);
            assert_eq!(crossings(&mesh), 0);
        }
    }

    #[test]
    fn polygons_are_cut_along_the_flattest_diagonals() {
        let (rod, h) = (Primitive::parse("cylinder:r2h9mm").unwrap(), 0.4);
        // Aslant, so that neither diagonal of most quadrilaterals runs along the rod.
        let (s, c) = 0.6f64.sin_cos();
        let turned = |p: Vec3| rod.signed_distance([c * p[0] + s * p[2], p[1], c * p[2] - s * p[0]]);
        let grid = Grid::covering([-6.0; 3], [6.0; 3], Length::mm(h), 1, [0.13, 0.4, 0.2]).unwrap();
        let values = (0..grid.samples()).map(|at| turned(grid.position(grid.index(at))) as f32);
        let field = Field::from_values(grid, values.collect(), 9.0).unwrap();
        let inside = Indicator::from_predicate(grid, |at| field.values()[at] <= 0.0);
        let slope = |p: Vec3| {
            let at = |a: usize, e: f64| turned([0, 1, 2].map(|b| p[b] + if a == b { e } else { 0.0 }));
            crate::geometry::vector::unit([0, 1, 2].map(|a| at(a, 1e-5) - at(a, -1e-5)))
        };
        let crossing = |edge: Edge| {
            let t = linear_crossing(&field, edge, 0.0);
            let p =
                [0, 1, 2].map(|a| grid.origin()[a] + h * (edge.from[a] as f64 + if a == edge.axis { t } else { 0.0 }));
            (t, slope(p))
        };
        let smooth = |_: [isize; 3], _: &[Vec3], _: &[Vec3]| None;
        let bend = |[p, q]: [Vec3; 2], [m, n]: [Vec3; 2]| {
            [0, 1, 2].map(|a| (m[a] - n[a]) * (p[a] - q[a])).iter().sum::<f64>().abs()
        };
        let missing = |mesh: &TriangleMesh| rod.volume().as_mm3() - mesh.signed_volume();
        let (plain, _) = sharp_surface(&inside, &told(crossing, smooth, |_, _| 0.0)).unwrap();
        let (flat, _) = sharp_surface(&inside, &told(crossing, smooth, bend)).unwrap();
        assert_manifold(&flat);
        assert_eq!(plain.vertices, flat.vertices);
        println!("rod: {} missing, {} along the flattest diagonals", missing(&plain), missing(&flat));
        assert!(missing(&flat) < 0.95 * missing(&plain), "{} {}", missing(&flat), missing(&plain));
    }

    #[test]
    fn a_plane_of_samples_becomes_a_box_of_its_extent() {
        let grid = Grid::new([1.0, 2.0, 3.0], Length::mm(0.5), [70, 3, 4]).unwrap();
        let mesh = surface(&Indicator::from_predicate(grid, |_| true), |_| 0.5).unwrap();
        assert_manifold(&mesh);
        let (lo, hi) = mesh.bounds().unwrap();
        assert_eq!((lo, hi), ([0.75, 1.75, 2.75], [35.75, 3.25, 4.75]));
    }

    #[test]
    fn the_surface_of_a_ball_is_round_to_second_order() {
        let ball = Primitive::parse("ball:2mm").unwrap();
        let error = |h: f64| {
            let grid = Grid::covering([-2.0; 3], [2.0; 3], Length::mm(h), 1, [0.13, 0.4, -0.2]).unwrap();
            let values = (0..grid.samples()).map(|at| ball.signed_distance(grid.position(grid.index(at))) as f32);
            let field = SignedDistance::new(Field::from_values(grid, values.collect(), 1.0).unwrap()).unwrap();
            let mesh = level_surface(&field, Length::mm(0.0)).unwrap();
            assert_manifold(&mesh);
            (mesh.signed_volume() / ball.volume().as_mm3() - 1.0).abs()
        };
        let (coarse, fine) = (error(0.2), error(0.1));
        // Chords h long cut off h²/4r at most: 3·h²/4r² of the volume, and a quarter of that at half the spacing.
        assert!(coarse < 7.5e-3 && fine < coarse / 3.0, "{coarse} {fine}");
    }
}
