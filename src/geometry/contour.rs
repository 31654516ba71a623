//! From a set of samples and a level back to a surface: closed and manifold, always.
//!
//! Each cell of eight samples is cut by polygons whose corners lie on its edges; the polygons follow from one rule on
//! the faces (inside corners are separated), so neighbours agree, every polygon edge has exactly two polygons and every
//! vertex one ring of them. Polygons are cut into triangles only by diagonals that no other cell can have.

use super::mesh::TriangleMesh;
use super::vector::{Vec3, add, scale};
use crate::error::{Error, Result};
use crate::field::{Field, Indicator, SignedDistance};
use crate::units::Length;
use rayon::prelude::*;

/// How near to a sample a vertex may come, as a share of the edge: vertices of different edges stay apart.
const NEAREST: f64 = 1e-3;

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
/// The mesh is closed and 2-manifold and wound outwards for every set. Crossings nearer to a sample than a
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
    let grid = inside.grid();
    // One sample more on every side, so that the surface closes where the set meets the border.
    let padded = inside.window([-1; 3], grid.dims().map(|n| n + 2))?;
    let cut = Cut::new(&padded);
    let counts: Vec<usize> = (0..cut.dims[2]).into_par_iter().map(|k| cut.edges_of_plane(k, |_, _| {})).collect();
    let mut firsts = vec![0usize];
    firsts.extend(counts.iter().scan(0, |sum, &n| {
        *sum += n;
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
    let table = polygons_of_all_cells();
    let origin = padded.grid().origin();
    let position = |edge: Edge| {
        let t = crossing(edge);
        let t = if t.is_finite() { t.clamp(NEAREST, 1.0 - NEAREST) } else { 0.5 };
        [0, 1, 2].map(|a| {
            let step = if a == edge.axis { t } else { 0.0 };
            origin[a] + grid.h() * ((edge.from[a] + 1) as f64 + step)
        })
    };
    let slabs: Vec<Slab> = (0..cut.dims[2])
        .into_par_iter()
        .map_init(
            || [cut.blank(), cut.blank()],
            |[lower, upper], k| cut.slab(k, [firsts[k], firsts[k + 1]], [lower, upper], &table, &position),
        )
        .collect();
    Ok(join(slabs, total))
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
    let (a, b) = (f64::from(field.at(edge.from)), f64::from(field.at(next)));
    (f64::from(level) - a) / (b - a)
}

/// A set with an empty border, seen as edges and cells.
struct Cut<'a> {
    set: &'a Indicator,
    dims: [usize; 3],
}

/// Vertices and triangles of one layer of cells; extra vertices, in polygons that no diagonal may cut, come last.
struct Slab {
    vertices: Vec<Vec3>,
    centres: Vec<Vec3>,
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

    /// The vertices of plane k and the triangles of the cells between it and the next.
    fn slab(
        &self,
        k: usize,
        firsts: [usize; 2],
        [lower, upper]: [&mut Vec<u32>; 2],
        table: &[Vec<Polygon>],
        position: &impl Fn(Edge) -> Vec3,
    ) -> Slab {
        let mut slab = Slab { vertices: Vec::new(), centres: Vec::new(), triangles: Vec::new() };
        let mut number = firsts[0] as u32;
        let mut corner_of = Vec::new();
        self.edges_of_plane(k, |place, edge| {
            lower[place] = number;
            number += 1;
            corner_of.push(edge);
        });
        slab.vertices = corner_of.iter().map(|&edge| position(edge)).collect();
        if k + 1 == self.dims[2] {
            return slab;
        }
        let mut number = firsts[1] as u32;
        self.edges_of_plane(k + 1, |place, _| {
            upper[place] = number;
            number += 1;
        });
        self.cells(k, |i, j, config| {
            for polygon in &table[config] {
                let vertex = |edge: usize| {
                    let (corner, axis) = EDGES[edge];
                    let place = 3 * ((j + (corner >> 1 & 1)) * self.dims[0] + i + (corner & 1)) + axis;
                    if corner >> 2 & 1 == 1 { upper[place] } else { lower[place] }
                };
                slab.cut_polygon(polygon, vertex, |first, axis| position(edge_of_cell([i, j, k], first, axis)));
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

/// The corners of a polygon as edges of the cell, and how to cut it: from which corner, or from its centre.
#[derive(Debug, Clone)]
struct Polygon {
    edges: Vec<usize>,
    fan: Option<usize>,
}

/// The twelve edges of a cell: first corner (bits x, y, z) and axis.
const EDGES: [(usize, usize); 12] =
    [(0, 0), (2, 0), (4, 0), (6, 0), (0, 1), (1, 1), (4, 1), (5, 1), (0, 2), (1, 2), (2, 2), (3, 2)];

/// The six faces, corners counter-clockwise seen from outside the cell.
const FACES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// The edge between two corners that differ in one bit.
fn edge_between(a: usize, b: usize) -> usize {
    let axis = (a ^ b).trailing_zeros() as usize;
    EDGES.iter().position(|&e| e == (a.min(b), axis)).unwrap_or(0)
}

/// Whether two edges of the cell lie on one face: a diagonal between them could be a neighbour's too.
fn share_a_face(a: usize, b: usize) -> bool {
    let on = |face: &[usize; 4], edge: usize| (0..4).any(|c| edge_between(face[c], face[(c + 1) % 4]) == edge);
    FACES.iter().any(|face| on(face, a) && on(face, b))
}

/// The polygons of all 256 cells.
fn polygons_of_all_cells() -> Vec<Vec<Polygon>> {
    (0..256usize).map(polygons_of_cell).collect()
}

fn polygons_of_cell(config: usize) -> Vec<Polygon> {
    let inside = |corner: usize| config >> corner & 1 == 1;
    // On every face, from the edge where the walk around it enters a run of inside corners to where it leaves.
    let mut next = [usize::MAX; 12];
    for face in FACES {
        for at in 0..4 {
            if inside(face[at]) || !inside(face[(at + 1) % 4]) {
                continue;
            }
            let entered = edge_between(face[at], face[(at + 1) % 4]);
            let run = (1..4).take_while(|&n| inside(face[(at + n) % 4])).count();
            let left = edge_between(face[(at + run) % 4], face[(at + run + 1) % 4]);
            next[entered] = left;
        }
    }
    let mut polygons = Vec::new();
    for start in 0..12 {
        let mut edges = Vec::new();
        let mut at = start;
        while next[at] != usize::MAX {
            edges.push(at);
            at = std::mem::replace(&mut next[at], usize::MAX);
        }
        if !edges.is_empty() {
            let n = edges.len();
            let clean = |from: usize| (2..n - 1).all(|d| !share_a_face(edges[from], edges[(from + d) % n]));
            let fan = (0..n).find(|&from| clean(from));
            polygons.push(Polygon { edges, fan });
        }
    }
    polygons
}

/// The lattice edge that is a cell's edge from corner `first` along `axis`; cells count from the padded border.
fn edge_of_cell(cell: [usize; 3], first: usize, axis: usize) -> Edge {
    Edge { from: [0, 1, 2].map(|a| (cell[a] + (first >> a & 1)) as isize - 1), axis }
}

impl Slab {
    /// Adds a polygon as triangles: a fan from one corner, or from a new vertex in the middle.
    fn cut_polygon(&mut self, polygon: &Polygon, vertex: impl Fn(usize) -> u32, place: impl Fn(usize, usize) -> Vec3) {
        let n = polygon.edges.len();
        let corner = |c: usize| vertex(polygon.edges[c % n]);
        if let Some(from) = polygon.fan {
            self.triangles.extend((1..n - 1).map(|d| [corner(from), corner(from + d), corner(from + d + 1)]));
            return;
        }
        let corners = polygon.edges.iter().map(|&edge| place(EDGES[edge].0, EDGES[edge].1));
        let sum = corners.fold([0.0; 3], add);
        let centre = CENTRE + self.centres.len() as u32;
        self.centres.push(scale(sum, 1.0 / n as f64));
        self.triangles.extend((0..n).map(|c| [centre, corner(c), corner(c + 1)]));
    }
}

fn join(slabs: Vec<Slab>, total: usize) -> TriangleMesh {
    let centres: usize = slabs.iter().map(|s| s.centres.len()).sum();
    let mut mesh = TriangleMesh {
        vertices: Vec::with_capacity(total + centres),
        triangles: Vec::with_capacity(slabs.iter().map(|s| s.triangles.len()).sum()),
    };
    slabs.iter().for_each(|s| mesh.vertices.extend_from_slice(&s.vertices));
    for slab in slabs {
        let shift = mesh.vertices.len() as u32;
        mesh.vertices.extend_from_slice(&slab.centres);
        let global = |v: u32| if v >= CENTRE { v - CENTRE + shift } else { v };
        mesh.triangles.extend(slab.triangles.iter().map(|t| t.map(global)));
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::grid::Grid;
    use rustc_hash::FxHashMap;

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
