//! The surface of what a bead leaves along strokes, from distances to the bead on its way.

use super::bead::{Grown, pieces};
use super::element::Sides;
use super::level::SMOOTH_COSINE;
use crate::error::Result;
use crate::geometry::contour::{Edge, Sheets, bend_between, creased, sharp_surface};
use crate::geometry::refine::{Halvings, split_curved_edges};
use crate::geometry::vector::{Vec3, along, dot, norm2, sub, unit};
use crate::geometry::{Primitive, TriangleMesh};
use crate::grid::Grid;
use rustc_hash::FxHashMap;

/// Halvings of an edge of the lattice: the crossing is known to a ten-millionth of the spacing.
const HALVINGS: usize = 24;
/// Steps of golden section on a piece, which leave a millionth of it.
const SECTIONS: usize = 30;
const GOLDEN: f64 = 0.618_033_988_749_894_8;
/// The step of differences that give a normal, in spacings.
const STEP: f64 = 1e-4;
/// Edges that are inscribed deeper than this, in spacings, are split.
const FINE: f64 = 0.003;
/// Points this near to the surface, in spacings, may be brought onto it.
const BESIDE: f64 = 0.6;

/// The surface of `∪ { p + B : p ∈ P }`, with the samples of [`deposit`](super::deposit) inside: vertices lie where the least of the distances to the
/// swept pieces vanishes, whatever the phase of the lattice, and creases are edges, as those of [`sharp_surface`].
///
/// What holds no sample is left out, and so are gaps between beads that leave none.
///
/// # Errors
/// As [`sharp_surface`], and as [`deposit`](super::deposit) for a cone.
///
/// # Cost
/// For each edge of the lattice that crosses the surface 24 tests of each piece that comes near it, and the distance to those that hold the crossing, seven to one
/// of them. A distance is one evaluation for balls and for cylinders on the level, else 34.
pub fn deposit_surface(strokes: &[Vec<Vec3>], bead: &Primitive, made: &Sides) -> Result<TriangleMesh> {
    let grid = *made.points.grid();
    let laid = Laid::of(strokes, bead, grid)?;
    let (surface, crowd) = sharp_surface(&made.points, &laid)?;
    Ok(split_curved_edges(&surface, Some(&crowd), FINE * grid.h(), Halvings::One, |p| laid.onto(p)))
}

/// The pieces of all strokes, by the cubes that their beads come near.
struct Laid<'a> {
    bead: &'a Primitive,
    held: Grown,
    pieces: Vec<[Vec3; 2]>,
    grid: Grid,
    edge: f64,
    near: FxHashMap<[i64; 3], Vec<u32>>,
}

impl<'a> Laid<'a> {
    fn of(strokes: &[Vec<Vec3>], bead: &'a Primitive, grid: Grid) -> Result<Self> {
        let (h, half) = (grid.h(), bead.half_extent());
        let edge = (2.0 * half.into_iter().fold(0.0, f64::max)).max(4.0 * h);
        let pieces = pieces(strokes, edge);
        let mut near: FxHashMap<[i64; 3], Vec<u32>> = FxHashMap::default();
        for (number, [a, b]) in pieces.iter().enumerate() {
            let end = |axis: usize, by: f64, least: fn(f64, f64) -> f64| {
                ((least(a[axis], b[axis]) + by * (half[axis] + h)) / edge).floor() as i64
            };
            let (lo, hi) = ([0, 1, 2].map(|x| end(x, -1.0, f64::min)), [0, 1, 2].map(|x| end(x, 1.0, f64::max)));
            for x in lo[0]..=hi[0] {
                for (y, z) in (lo[1]..=hi[1]).flat_map(|y| (lo[2]..=hi[2]).map(move |z| (y, z))) {
                    near.entry([x, y, z]).or_default().push(number as u32);
                }
            }
        }
        let held = Grown::of(bead, 0.0, (1e-6 * h, 0.0))?;
        Ok(Laid { bead, held, pieces, grid, edge, near })
    }

    /// The pieces whose bead may come within so many spacings of a point, of one at most.
    fn beside(&self, p: Vec3, spacings: f64) -> impl Iterator<Item = &[Vec3; 2]> {
        let cube = p.map(|x| (x / self.edge).floor() as i64);
        let reach = self.bead.half_extent().map(|x| x + spacings * self.grid.h());
        let comes_near =
            move |[a, b]: &&[Vec3; 2]| (0..3).all(|x| (a[x].min(b[x]) - p[x]).max(p[x] - a[x].max(b[x])) <= reach[x]);
        self.near.get(&cube).into_iter().flatten().filter_map(|&n| self.pieces.get(n as usize)).filter(comes_near)
    }

    /// Whether the bead on a piece holds a point.
    fn meets(&self, p: Vec3, [a, b]: &[Vec3; 2]) -> bool {
        self.held.met(sub(*a, p), sub(*b, p))
    }

    /// The distance to the bead at a place on a piece.
    fn distance_at(&self, p: Vec3, [a, b]: &[Vec3; 2], t: f64) -> f64 {
        self.bead.signed_distance(sub(p, along(*a, sub(*b, *a), t)))
    }

    /// The place on a piece where its bead is nearest, if that is the one nearest to the point: a ball's, and a cylinder's on the level.
    fn foot(&self, p: Vec3, [a, b]: &[Vec3; 2]) -> Option<f64> {
        let (way, off) = (sub(*b, *a), sub(p, *a));
        let is_foot = match self.bead {
            Primitive::Ball { .. } => true,
            Primitive::Cylinder { .. } => way[2] == 0.0,
            _ => false,
        };
        let length2 = norm2(way);
        is_foot.then(|| if length2 > 0.0 { (dot(off, way) / length2).clamp(0.0, 1.0) } else { 0.0 })
    }

    /// The distance to the bead where it is nearest on a piece: convex in the place on it, as every bead is convex.
    fn distance(&self, p: Vec3, piece: &[Vec3; 2]) -> f64 {
        let at = |t: f64| self.distance_at(p, piece, t);
        if let Some(t) = self.foot(p, piece) {
            return at(t);
        }
        let (mut low, mut high) = (0.0, 1.0);
        let mut places = [1.0 - GOLDEN, GOLDEN];
        let mut values = places.map(at);
        for _ in 0..SECTIONS {
            if values[0] <= values[1] {
                high = places[1];
                places = [high - GOLDEN * (high - low), places[0]];
                values = [at(places[0]), values[0]];
            } else {
                low = places[0];
                places = [places[1], low + GOLDEN * (high - low)];
                values = [values[1], at(places[1])];
            }
        }
        values[0].min(values[1]).min(at(0.0)).min(at(1.0))
    }

    /// The outward unit normal of a piece's bead at a point of it.
    fn normal(&self, p: Vec3, piece: &[Vec3; 2]) -> Vec3 {
        let step = STEP * self.grid.h();
        // Where the nearest place is the foot it stays the nearest to first order.
        let fixed = self.foot(p, piece);
        let value = |q: Vec3| fixed.map_or_else(|| self.distance(q, piece), |t| self.distance_at(q, piece, t));
        let off = |axis: usize, by: f64| [0, 1, 2].map(|a| if a == axis { p[a] + by } else { p[a] });
        unit([0, 1, 2].map(|axis| value(off(axis, step)) - value(off(axis, -step))))
    }

    /// The nearest to a point of some pieces, and its distance.
    fn nearest_of<'p>(&self, p: Vec3, of: impl Iterator<Item = &'p [Vec3; 2]>) -> Option<(f64, &'p [Vec3; 2])> {
        of.map(|piece| (self.distance(p, piece), piece)).min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl Sheets for Laid<'_> {
    /// The normal at the crossing.
    type Note = Option<Vec3>;

    fn crossing(&self, edge: Edge) -> (f64, Option<Vec3>) {
        let point = |t: f64| {
            let step = |axis| if axis == edge.axis { t } else { 0.0 };
            [0, 1, 2].map(|a| self.grid.origin()[a] + self.grid.h() * (edge.from[a] as f64 + step(a)))
        };
        let near: Vec<&[Vec3; 2]> = self.beside(point(0.5), 0.51).collect();
        let holds = |t: f64| near.iter().any(|piece| self.meets(point(t), piece));
        let (mut within, mut beyond) = if holds(0.0) { (0.0, 1.0) } else { (1.0, 0.0) };
        for _ in 0..HALVINGS {
            let between = 0.5 * (within + beyond);
            if holds(between) { within = between } else { beyond = between }
        }
        let p = point(within);
        let seen = self.nearest_of(p, near.into_iter().filter(|piece| self.meets(p, piece)));
        (within, seen.map(|(_, piece)| self.normal(p, piece)))
    }

    fn normals(&self, _: [isize; 3], _: &[Vec3], notes: &[Option<Vec3>]) -> Option<Vec<Vec3>> {
        creased(notes, SMOOTH_COSINE)
    }

    fn bend(&self, ends: [Vec3; 2], normals: [Option<Vec3>; 2]) -> f64 {
        bend_between(ends, normals)
    }

    fn onto(&self, p: Vec3) -> Vec3 {
        let near = self.nearest_of(p, self.beside(p, BESIDE)).filter(|(off, _)| off.abs() < BESIDE * self.grid.h());
        near.map_or(p, |(off, piece)| along(p, self.normal(p, piece), -off))
    }
}
