//! What a surface is like between the samples, and the points on its creases.

use super::feature::{Cell, Plane, feature_point, middle, nearer_feature_point};
use super::surface::{Edge, NEAREST};
use crate::geometry::vector::{Vec3, add, dot, scale, sub};
use crate::grid::Grid;

/// How often a feature is sought from planes that touch the surface nearer to it: each time leaves about the square of what
/// was missing.
const STEPS: usize = 2;

/// A surface as seen between samples: what [`sharp_surface`](super::sharp_surface) asks of it.
pub trait Sheets: Sync {
    /// What is known of a crossing beside its place, such as the normal there.
    type Note: Copy + Send + Sync;

    /// Where the surface crosses an edge of the lattice, from 0 to 1.
    fn crossing(&self, edge: Edge) -> (f64, Self::Note);

    /// The place of the surface that the vertex on an edge of the lattice stands for, where that is not on the edge.
    fn aside(&self, _edge: Edge) -> Option<Vec3> {
        None
    }

    /// The outward unit normal at each of the points where the surface leaves the cell whose first sample is `cell`; nothing
    /// where it is smooth.
    fn normals(&self, cell: [isize; 3], corners: &[Vec3], notes: &[Self::Note]) -> Option<Vec<Vec3>>;

    /// How far the surface leaves the line between two crossings, in any unit.
    fn bend(&self, _ends: [Vec3; 2], _notes: [Self::Note; 2]) -> f64 {
        0.0
    }

    /// The plane that touches beside a point the sheet that another plane touches: a point of it, and the outward normal.
    fn beside(&self, _point: Vec3, plane: (Vec3, Vec3)) -> (Vec3, Vec3) {
        plane
    }

    /// The point of the surface nearest to a point near it, as far as that is known.
    fn onto(&self, point: Vec3) -> Vec3 {
        point
    }
}

/// The normals noted at crossings, if all are known and two of them are at least as far apart as the cosine tells: then there is a crease.
pub fn creased(notes: &[Option<Vec3>], smooth_cosine: f64) -> Option<Vec<Vec3>> {
    let normals: Vec<Vec3> = notes.iter().copied().collect::<Option<_>>()?;
    let leaves = |(at, &m): (usize, &Vec3)| normals.iter().take(at).any(|&n| dot(m, n) <= smooth_cosine);
    normals.iter().enumerate().any(leaves).then_some(normals)
}

/// How far a surface leaves the line between two crossings, by the normals noted there; 0 where one is not known.
pub fn bend_between([p, q]: [Vec3; 2], normals: [Option<Vec3>; 2]) -> f64 {
    match normals {
        [Some(m), Some(n)] => dot(sub(m, n), sub(p, q)).abs(),
        _ => 0.0,
    }
}

/// A surface of which the crossings alone are known.
pub(super) struct Crossings<C>(pub(super) C);

impl<C: Fn(Edge) -> f64 + Sync> Sheets for Crossings<C> {
    type Note = ();

    fn crossing(&self, edge: Edge) -> (f64, ()) {
        ((self.0)(edge), ())
    }

    fn normals(&self, _: [isize; 3], _: &[Vec3], _: &[()]) -> Option<Vec<Vec3>> {
        None
    }
}

/// The vertex of a polygon on a crease or in a corner, where the sheets at its corners meet, if there is one in its cell; nothing for a
/// smooth polygon.
///
/// Drawn a little to the middle of the polygon, so that no two polygons have one point.
pub(super) fn vertex_on_feature<S: Sheets>(
    sheets: &S,
    grid: &Grid,
    cell: [isize; 3],
    corners: &[Vec3],
    notes: &[S::Note],
) -> Option<Option<Vec3>> {
    let normals = sheets.normals(cell, corners, notes)?;
    let planes: Vec<Plane> = corners.iter().copied().zip(normals).collect();
    let cell = Cell { first: [0, 1, 2].map(|a| grid.origin()[a] + grid.h() * cell[a] as f64), h: grid.h() };
    let Some(mut x) = feature_point(cell, &planes) else { return Some(None) };
    for _ in 0..STEPS {
        let nearer: Vec<Plane> = planes.iter().map(|&plane| sheets.beside(x, plane)).collect();
        let Some(found) = nearer_feature_point(cell, x, &nearer) else { break };
        x = found;
    }
    Some(Some(add(scale(sheets.onto(x), 1.0 - NEAREST), scale(middle(&planes), NEAREST))))
}
