//! Finer facets where a surface is curved.

use super::contour::Crowd;
use super::mesh::TriangleMesh;
use super::vector::{Vec3, add, angle, cross, distance, dot, norm2, scale, sub};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;

/// How often an edge is halved at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Halvings {
    One,
    Two,
}

/// An edge that rises by more than this share of its length crosses a crease: an arc that turns by a radian rises so far.
const CREASED: f64 = 0.125;

/// The mesh with a new vertex `project(midpoint)` on every edge that a curved surface leaves by more than `sagitta`
/// millimetres. At [`Halvings::Two`] the halves are split once more where the new vertex rose by more than four times that.
///
/// Normals at an edge's ends tell which midpoints to project: an arc of length l that turns by α rises α·l/8 above its chord.
/// A crease has no one normal, so that the flat edges that end there are tried, too, and left as they are.
///
/// Facets are split by their halved edges into two, three or four; a closed manifold mesh stays one, in formats of f32
/// coordinates, too: vertices that would coincide stay at their midpoints. Those at which facets of a crowd cross, or of facets that
/// fold, are drawn back towards theirs until none do, no farther than that takes.
///
/// # Cost
/// O(facets), a hash look-up for each tried edge of each facet, one projection for each tried edge; a tree over the facets of the
/// crowd.
pub fn split_curved_edges(
    mesh: &TriangleMesh,
    crowd: Option<&Crowd>,
    sagitta: f64,
    halvings: Halvings,
    project: impl Fn(Vec3) -> Vec3 + Sync,
) -> TriangleMesh {
    let normals = vertex_normals(mesh);
    let curved = |[a, b]: [u32; 2]| {
        let [p, q] = [a, b].map(|v| mesh.vertices[v as usize]);
        let (m, n, rise) = (normals[a as usize], normals[b as usize], 8.0 * sagitta / distance(p, q));
        // Below a right angle it is at least its sine and at most π/2 of it, which is cheaper.
        let (sine2, rise2) = (norm2(cross(m, n)), rise * rise * norm2(m) * norm2(n));
        match dot(m, n) > 0.0 {
            true if sine2 < 0.39 * rise2 => false,
            true if sine2 > 1.001 * rise2 => true,
            _ => angle(m, n) > rise,
        }
    };
    let marked = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]].map(|[s, e]| curved([s.min(e), s.max(e)]));
    let marked: Vec<[bool; 3]> = mesh.triangles.par_iter().map(marked).collect();
    let known = mesh.vertices.len();
    let halved = Halved::of(mesh, &marked, sagitta, &project);
    let (mut once, along) = halved.split(mesh);
    let crowd = crowd.map(|crowd| crowd.and_at(&halved.folds(mesh)));
    if halvings == Halvings::One {
        uncross(&mut once, crowd.as_ref(), known, &halved.ends, &project);
        return once;
    }
    let deep = halved.deep(mesh, sagitta);
    let still = |along: &[u32; 3]| along.map(|edge| deep.get(edge as usize) == Some(&true));
    let marked: Vec<[bool; 3]> = along.par_iter().map(still).collect();
    let again = Halved::of(&once, &marked, sagitta, &project);
    let mut twice = again.split(&once).0;
    let crowd = crowd.map(|crowd| crowd.and_at(&again.folds(&once)));
    uncross(&mut twice, crowd.as_ref(), known, &[halved.ends, again.ends].concat(), &project);
    twice
}

/// How often a vertex goes half the way back to the middle of its edge before it goes there.
const STEPS: u8 = 3;

/// Draws vertices back to the middles of their edges until no two facets of the crowd cross, if none does where all are; of the vertices
/// of a pair that crosses the one that was drawn least, and of those the farthest from there; then as far towards the surface as none do. `ends` are the edges of those from `known` on.
fn uncross(
    mesh: &mut TriangleMesh,
    crowd: Option<&Crowd>,
    known: usize,
    ends: &[[u32; 2]],
    project: impl Fn(Vec3) -> Vec3,
) {
    let Some(crowd) = crowd else { return };
    let edge_of = |v: u32| (v as usize).checked_sub(known).and_then(|at| ends.get(at).copied());
    let mut drawn: BTreeMap<u32, (u8, Vec3)> = BTreeMap::new();
    crowd.mend_crossings(mesh, |mesh, pair, moved| {
        let first = |candidates: &[u32]| {
            let rise = |&v: &u32| {
                let at = middle(edge_of(v)?.map(|end| mesh.vertices[end as usize]));
                let steps = drawn.get(&v).map(|drawn| drawn.0).unwrap_or_default();
                Some((steps, -distance(mesh.vertices[v as usize], at), v, at)).filter(|rise| rise.1 < 0.0)
            };
            let all = candidates.iter().filter_map(rise);
            all.min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)))
        };
        let corners = pair.map(|facet| mesh.triangles[facet as usize]).concat();
        // A half of a half is in the middle of an edge whose ends may be new ones.
        let beyond: Vec<u32> = corners.iter().filter_map(|&v| edge_of(v)).flatten().collect();
        if let Some((steps, _, v, at)) = first(&corners).or_else(|| first(&beyond)) {
            let p = &mut mesh.vertices[v as usize];
            let of = drawn.entry(v).or_insert((0, *p));
            of.0 = of.0.saturating_add(1);
            *p = if steps < STEPS { middle([*p, at]) } else { at };
            moved.push(v);
        }
    });
    let places: Vec<(u32, Vec3)> = drawn.into_iter().map(|(v, (_, place))| (v, place)).collect();
    crowd.put_back(mesh, &places, project);
}

/// No edge that is halved.
const NONE: u32 = u32::MAX;

/// Edges of a mesh that are halved.
struct Halved {
    /// For each edge of each facet, its number among them: [`NONE`] if it is not.
    edges: Vec<[u32; 3]>,
    /// The ends of each.
    ends: Vec<[u32; 2]>,
    /// The new vertex of each.
    vertices: Vec<Vec3>,
}

fn middle([p, q]: [Vec3; 2]) -> Vec3 {
    scale(add(p, q), 0.5)
}

impl Halved {
    /// Those of the marked edges whose middle is farther than `sagitta` off the surface.
    fn of(mesh: &TriangleMesh, marked: &[[bool; 3]], sagitta: f64, project: &(impl Fn(Vec3) -> Vec3 + Sync)) -> Self {
        let mut numbers: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        let mut tried: Vec<[u32; 2]> = Vec::new();
        let mut number = |edge: [u32; 2]| {
            *numbers.entry(edge).or_insert_with(|| {
                tried.push(edge);
                tried.len() as u32 - 1
            })
        };
        let numbered = |(&[a, b, c], &marks): (&[u32; 3], &[bool; 3])| {
            let edges = [(a, b, marks[0]), (b, c, marks[1]), (c, a, marks[2])];
            edges.map(|(s, e, mark)| if mark { number([s.min(e), s.max(e)]) } else { NONE })
        };
        let mut edges: Vec<[u32; 3]> = mesh.triangles.iter().zip(marked).map(numbered).collect();
        let places = |ends: [u32; 2]| ends.map(|v| mesh.vertices[v as usize]);
        let placed = |&ends: &[u32; 2]| (ends, project(middle(places(ends))));
        let tried: Vec<([u32; 2], Vec3)> = tried.par_iter().map(placed).collect();
        let rises = |&(ends, p): &([u32; 2], Vec3)| distance(middle(places(ends)), p) > sagitta;
        let mut count = 0..;
        let kept: Vec<u32> =
            tried.iter().map(|edge| if rises(edge) { count.next().unwrap_or(NONE) } else { NONE }).collect();
        edges.par_iter_mut().flatten().for_each(|edge| *edge = kept.get(*edge as usize).copied().unwrap_or(NONE));
        let (ends, mut vertices): (Vec<[u32; 2]>, Vec<Vec3>) = tried.into_iter().filter(rises).unzip();
        keep_apart(&mesh.vertices, &mut vertices, &ends);
        Halved { edges, ends, vertices }
    }

    /// Which of them rise so far that their halves still do, by a quarter of it, but do not cross a crease.
    fn deep(&self, mesh: &TriangleMesh, sagitta: f64) -> Vec<bool> {
        let deep = |(&ends, &p): (&[u32; 2], &Vec3)| {
            let [a, b] = ends.map(|v| mesh.vertices[v as usize]);
            let rise = distance(p, middle([a, b]));
            0.25 * rise > sagitta && rise < CREASED * distance(a, b)
        };
        self.ends.iter().zip(&self.vertices).map(deep).collect()
    }

    /// A place on each facet that they fold: a part of it lies the other way round.
    fn folds(&self, mesh: &TriangleMesh) -> Vec<Vec3> {
        let known = mesh.vertices.len();
        let place =
            |v: u32| mesh.vertices.get(v as usize).copied().unwrap_or_else(|| self.vertices[v as usize - known]);
        let area = |[a, b, c]: [Vec3; 3]| cross(sub(b, a), sub(c, a));
        let fold = |(&facet, edges): (&[u32; 3], &[u32; 3])| {
            let middles = edges.map(|edge| (edge != NONE).then(|| known as u32 + edge));
            let whole = area(facet.map(place));
            let folded = |(part, _): ([u32; 3], _)| dot(area(part.map(place)), whole) < 0.0;
            let cut = middles.iter().any(Option::is_some);
            (cut && split(facet, middles).any(folded)).then(|| place(facet[0]))
        };
        mesh.triangles.par_iter().zip(&self.edges).filter_map(fold).collect()
    }

    /// The mesh of their halves; and for each edge of each of its facets, which of them it is half of, or runs beside and
    /// turns as far as half of: [`NONE`] if none.
    fn split(&self, mesh: &TriangleMesh) -> (TriangleMesh, Vec<[u32; 3]>) {
        let known = mesh.vertices.len() as u32;
        let (mut triangles, mut along) =
            (Vec::with_capacity(mesh.triangles.len()), Vec::with_capacity(self.edges.len()));
        for (&facet, edges) in mesh.triangles.iter().zip(&self.edges) {
            let middles = edges.map(|edge| (edge != NONE).then(|| known + edge));
            for (triangle, beside) in split(facet, middles) {
                triangles.push(triangle);
                along.push(beside.map(|middle| middle.map_or(NONE, |middle| middle - known)));
            }
        }
        let vertices = [&mesh.vertices[..], &self.vertices].concat();
        (TriangleMesh { vertices, triangles }, along)
    }
}

/// Puts new vertices that would coincide with others at the middles of their edges.
///
/// Sheets that meet in a ridge are projected onto the same points there. Formats without indices join vertices that are
/// equal in f32, and edges of four facets would come of it.
fn keep_apart(vertices: &[Vec3], projected: &mut [Vec3], edges: &[[u32; 2]]) {
    let place = |p: &Vec3| p.map(|x| (x as f32 + 0.0).to_bits());
    let mut new_at: FxHashMap<[u32; 3], u32> = FxHashMap::default();
    for p in projected.iter() {
        *new_at.entry(place(p)).or_default() += 1;
    }
    let met: FxHashSet<[u32; 3]> =
        vertices.par_iter().map(place).filter(|at| new_at.contains_key(at)).collect::<Vec<_>>().into_iter().collect();
    let apart = |p: &Vec3| new_at.get(&place(p)) == Some(&1) && !met.contains(&place(p));
    for (p, &ends) in projected.iter_mut().zip(edges) {
        if !apart(p) {
            *p = middle(ends.map(|v| vertices[v as usize]));
        }
    }
}

/// The parts of a facet cut by the new vertices on its edges ab, bc, ca; with the edge of each of their edges that it is half
/// of or turns as far as, named by its new vertex.
///
/// A part's edge between two new vertices runs along the third edge; one from a new vertex to the corner beyond turns as far
/// as half of the edge that it starts on if that is beside one that is flat.
fn split([a, b, c]: [u32; 3], middles: [Option<u32>; 3]) -> impl Iterator<Item = ([u32; 3], [Option<u32>; 3])> {
    let [d, e, f] = middles;
    let (parts, count) = match middles {
        [None, None, None] => ([([a, b, c], [None; 3]); 4], 1),
        [Some(m), None, None] => ([([a, m, c], [d, None, None]), ([m, b, c], [d, None, None]), NOTHING, NOTHING], 2),
        [None, Some(m), None] => ([([a, b, m], [None, e, None]), ([a, m, c], [None, e, None]), NOTHING, NOTHING], 2),
        [None, None, Some(m)] => ([([a, b, m], [None, None, f]), ([m, b, c], [None, None, f]), NOTHING, NOTHING], 2),
        [Some(m), Some(n), None] => {
            ([([m, b, n], [d, e, None]), ([a, m, n], [d, None, e]), ([a, n, c], [e, e, None]), NOTHING], 3)
        }
        [None, Some(m), Some(n)] => {
            ([([m, c, n], [e, f, None]), ([a, b, m], [None, e, e]), ([a, m, n], [e, None, f]), NOTHING], 3)
        }
        [Some(m), None, Some(n)] => {
            ([([a, m, n], [d, None, f]), ([m, b, c], [d, None, d]), ([m, c, n], [d, f, None]), NOTHING], 3)
        }
        [Some(k), Some(m), Some(n)] => {
            ([([a, k, n], [d, e, f]), ([k, b, m], [d, e, f]), ([n, m, c], [d, e, f]), ([k, m, n], [f, d, e])], 4)
        }
    };
    parts.into_iter().take(count)
}

/// In place of a part that there is not.
const NOTHING: ([u32; 3], [Option<u32>; 3]) = ([0; 3], [None; 3]);

/// Area vectors of the facets around each vertex, summed in the order of the facets.
fn vertex_normals(mesh: &TriangleMesh) -> Vec<Vec3> {
    let areas: Vec<Vec3> = (0..mesh.triangles.len()).into_par_iter().map(|f| mesh.area_vector(f)).collect();
    let mut normals = vec![[0.0; 3]; mesh.vertices.len()];
    for (facet, &area) in mesh.triangles.iter().zip(&areas) {
        for &v in facet {
            normals[v as usize] = add(normals[v as usize], area);
        }
    }
    normals
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Indicator;
    use crate::geometry::health::meetings;
    use crate::geometry::{MeshDistance, Primitive};
    use crate::grid::Grid;
    use crate::random::Lcg;
    use crate::units::Length;
    use std::collections::HashSet;

    /// A lattice of 0.25 mm about the origin, crowded everywhere.
    fn everywhere() -> Crowd {
        let grid = Grid::new([-3.0; 3], Length::mm(0.25), [25; 3]).unwrap();
        Crowd::about(&Indicator::empty(grid), (0..grid.samples()).map(|at| grid.index(at)))
    }

    #[test]
    fn halves_that_would_cross_are_flat() {
        // Two balls, one a little inside the other; halves of the edges are put somewhere near the surface.
        let ball = |r: f64, d: f64| Primitive::Ball { radius: Length::mm(r) }.mesh(Length::mm(d));
        let sheets = ball(2.0, 0.05).joined(&ball(1.9, 0.03).flipped());
        let noise =
            |p: Vec3| scale(p, 1.0 + 0.08 * (Lcg(p[0].to_bits() ^ p[1].to_bits() ^ p[2].to_bits()).unit() - 0.5));
        let crossings =
            |mesh: &TriangleMesh| meetings(&MeshDistance::new(mesh), |_, _| true, 1e-5 * 0.25).crossing.count;
        assert_eq!(crossings(&sheets), 0);
        for halvings in [Halvings::One, Halvings::Two] {
            let made = |crowd: Option<&Crowd>| split_curved_edges(&sheets, crowd, 0.003, halvings, noise);
            let (free, tamed) = (made(None), made(Some(&everywhere())));
            assert!(crossings(&free) > 20, "{}", crossings(&free));
            assert_eq!(crossings(&tamed), 0);
            // The same facets; and not all of them are flat.
            assert_eq!(free.triangles, tamed.triangles);
            let moved = free.vertices.iter().zip(&tamed.vertices).filter(|(a, b)| a != b).count();
            assert!(moved > 0 && 10 * moved < 9 * (free.vertices.len() - sheets.vertices.len()), "{moved}");
        }
    }

    #[test]
    fn a_refined_ball_is_closed_and_its_edges_are_split_twice() {
        let ball = Primitive::parse("ball:2mm").unwrap();
        let coarse = ball.mesh(Length::mm(0.02));
        let fine =
            split_curved_edges(&coarse, None, 0.001, Halvings::Two, |p| scale(p, 2.0 / super::super::vector::norm(p)));
        let edges: HashSet<(u32, u32)> =
            fine.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        assert_eq!(edges.len(), 3 * fine.triangles.len());
        assert!(edges.iter().all(|&(s, e)| edges.contains(&(e, s))));
        let missing = |mesh: &TriangleMesh| ball.volume().as_mm3() - mesh.signed_volume();
        // Edges of 0.02 mm rise become of 0.005, and those of 0.00125: but the flattest are split once.
        assert!(
            missing(&fine) > 0.0 && missing(&fine) < missing(&coarse) / 8.0,
            "{} {}",
            missing(&fine),
            missing(&coarse)
        );
    }

    #[test]
    fn flat_faces_are_left_alone() {
        // A box has curved edges only along its rims, as far as vertex normals tell; a coarse bound marks none.
        let cube = Primitive::parse("box:2x2x2mm").unwrap().mesh(Length::mm(1.0));
        assert_eq!(split_curved_edges(&cube, None, 10.0, Halvings::Two, |p| p), cube);
    }
}
