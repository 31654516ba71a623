//! The union of a mesh by its exact arrangement.

use super::arrangement::Arrangement;
use super::cuts::edges;
use super::exact::{Exact, turn};
use crate::geometry::{DisjointSets, TriangleMesh};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Weights of the corners of a piece for a place in it, until one is found from which no edge is seen.
const PLACES: [[u32; 3]; 8] =
    [[1, 1, 1], [5, 3, 7], [11, 6, 4], [3, 13, 8], [17, 5, 9], [6, 23, 29], [31, 14, 19], [37, 41, 12]];

/// The pieces of an arrangement behind which the winding number is at least 1 and before which it is less, as one mesh; of pieces that
/// lie on each other one. `None` if a place in a piece cannot be seen past edges.
///
/// # Cost
/// For each region of pieces joined over edges that no other piece has, one line through the mesh.
pub(super) fn bounding(arrangement: &Arrangement) -> Option<TriangleMesh> {
    let region = regions(&arrangement.pieces);
    let mut pieces_of: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    region.iter().enumerate().for_each(|(piece, &of)| pieces_of.entry(of).or_default().push(piece));
    let asked: Vec<Option<bool>> =
        pieces_of.par_iter().map(|(_, pieces)| bounds(arrangement, widest(arrangement, pieces)?)).collect();
    let mut kept = Vec::new();
    for (pieces, bounds) in pieces_of.values().zip(asked) {
        if bounds? {
            kept.extend(pieces);
        }
    }
    kept.sort_unstable();
    Some(surface(arrangement, &kept))
}

/// The region of each piece: those joined over edges that two pieces have.
fn regions(pieces: &[[u32; 3]]) -> Vec<u32> {
    let mut at: FxHashMap<[u32; 2], (u32, u32, u32)> = FxHashMap::default();
    for (piece, &triangle) in (0u32..).zip(pieces) {
        for edge in edges(triangle) {
            let known = at.entry(edge).or_insert((piece, piece, 0));
            *known = (known.0, piece, known.2 + 1);
        }
    }
    let mut sets = DisjointSets::new(pieces.len());
    at.values().filter(|known| known.2 == 2).for_each(|&(a, b, _)| _ = (a != b).then(|| sets.join(a, b)));
    (0..pieces.len() as u32).map(|piece| sets.root(piece)).collect()
}

/// The piece of the most area, of equal ones the first.
fn widest(arrangement: &Arrangement, pieces: &[usize]) -> Option<usize> {
    let area = |&piece: &usize| {
        let corners = arrangement.pieces.get(piece).copied().unwrap_or_default().map(|p| arrangement.place(p));
        TriangleMesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]] }.facet_area(0)
    };
    pieces.iter().copied().reduce(|most, piece| if area(&piece) > area(&most) { piece } else { most })
}

/// Whether a piece bounds the union: by the winding numbers on both sides of a place in it, what lies there on each other counted as one.
fn bounds(arrangement: &Arrangement, piece: usize) -> Option<bool> {
    let number = *arrangement.facet.get(piece)?;
    let (axis, _) = arrangement.facets.get(number as usize)?.plane.axes();
    let corners = arrangement.pieces.get(piece)?.map(|p| arrangement.points.get(p as usize));
    let [Some(a), Some(b), Some(c)] = corners else { return None };
    let seen = PLACES.iter().find_map(|&weights| seen(arrangement, &Exact::mean([a, b, c], weights), axis))?;
    let own = seen.here.iter().find(|(f, _)| *f == number)?.1;
    let below = seen.above + seen.here.iter().map(|(_, sign)| sign).sum::<i32>();
    let [behind, before] = if own > 0 { [below, seen.above] } else { [seen.above, below] };
    let first = seen.here.iter().filter(|(_, sign)| *sign == own).map(|(f, _)| *f).min();
    Some(behind >= 1 && before < 1 && first == Some(number))
}

/// What a line through a place along an axis meets.
struct Seen {
    /// The winding number just above the place.
    above: i32,
    /// The facets that the place lies on, 1 those that face along the axis and −1 those that face the other way.
    here: Vec<(u32, i32)>,
}

/// What a line through a place meets; `None` if it meets an edge.
fn seen(arrangement: &Arrangement, place: &Exact, axis: usize) -> Option<Seen> {
    let axes = [(axis + 1) % 3, (axis + 2) % 3];
    let (mut lo, mut hi) = (place.near().map(|x| x - 1.0), place.near().map(|x| x + 1.0));
    (lo[axis], hi[axis]) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut seen = Some(Seen { above: 0, here: Vec::new() });
    arrangement.tree.tree().in_box((lo, hi), |f| {
        let (Some(facet), Some(found)) = (arrangement.facets.get(f as usize), seen.as_mut()) else { return };
        let sign = facet.plane.normal[axis].signum() as i32;
        let [r, s, t] = &facet.corners.map(Exact::on_lattice);
        let turns = [[r, s], [s, t], [t, r]].map(|[r, s]| turn(axes, [r, s, place]) as i32);
        match sign {
            // Seen edge-on.
            0 if turns == [0; 3] => seen = None,
            0 => {}
            _ if turns.iter().any(|turn| turn * sign < 0) => {}
            _ if turns.contains(&0) => seen = None,
            _ => match (place.side(&facet.plane) as i32 * sign).cmp(&0) {
                Ordering::Less => found.above += sign,
                Ordering::Equal => found.here.push((f, sign)),
                Ordering::Greater => {}
            },
        }
    });
    seen
}

/// The mesh of some pieces.
fn surface(arrangement: &Arrangement, kept: &[usize]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let mut known: FxHashMap<u32, u32> = FxHashMap::default();
    for triangle in kept.iter().filter_map(|&piece| arrangement.pieces.get(piece)) {
        let corners = triangle.map(|p| {
            *known.entry(p).or_insert_with(|| {
                mesh.vertices.push(arrangement.place(p));
                mesh.vertices.len() as u32 - 1
            })
        });
        mesh.triangles.push(corners);
    }
    mesh
}
