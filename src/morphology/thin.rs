//! Sheets and gaps that pass between samples.
//!
//! What is thinner than the spacing may hold no sample for a while, at the end of a sharp wedge or in a thin wall, and then a surface
//! between samples leaves out what is there. Where both ends of an edge of the lattice are on one side and the surface crosses it
//! twice, the end that is nearer is turned to the other side, so that the sheet stays whole; the vertices around it are put onto the
//! surface afterwards, as far as no facets cross. Two sheets with a gap between them need a sample each: where they come nearer than
//! about two spacings to each other one of them, or the gap, may be left out as before.

use super::corners::met_by_corners;
use super::films::without_films;
use super::traced::Traced;
use crate::field::Indicator;
use crate::geometry::TriangleMesh;
use crate::geometry::contour::{Edge, Sheets};
use crate::geometry::vector::{Vec3, add, scale};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// A sample is turned only where what it then hangs together with does: between the two the field is on the wrong side by this much
/// at most, in spacings. A gap of twice that is bridged at most.
const APART: f64 = 0.05;

/// Sheets are kept whole that are thicker than twice this, in spacings: where two sides meet all along, rounding makes thinner ones.
const THICK: f64 = 0.01;

/// Where a vertex stands that is put onto the surface later, as a share of its edge from the turned sample.
const STAND: f64 = 0.001;

/// How often samples are sought at whose faces turned ones meet by their corners: each turned one may have new ones.
const ROUNDS: usize = 3;

/// How often the way into a sheet is halved.
const HALVINGS: usize = 8;

/// So many samples of a row are looked at together.
const BLOCK: usize = 32;

/// A place on an edge and the field there.
type OnEdge = (f64, f64);

/// A surface that passes between samples, and the samples that were turned for it.
pub(super) struct Thin<'a> {
    of: &'a Traced,
    /// The edges that the surface crosses twice, with a place on each between the two.
    through: FxHashMap<(usize, usize), OnEdge>,
    /// The samples that were turned, and a point of the sheet for each.
    turned: FxHashMap<usize, Vec3>,
}

/// The side of the surface that a sheet is made of.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Inside,
    Outside,
}

impl Side {
    /// Whether the surface between samples joins two of this side that differ in so many of three places by one: those inside over edges
    /// alone, those outside over the diagonals of faces, too.
    fn joins(self, away: usize) -> bool {
        away > 0 && away <= if self == Side::Inside { 1 } else { 2 }
    }

    /// A value of the field, below zero on this side.
    fn of(self, value: f64) -> f64 {
        if self == Side::Inside { value } else { -value }
    }
}

impl<'a> Thin<'a> {
    /// Turns the samples of a set that sheets pass, first those of the inside.
    ///
    /// # Cost
    /// A look at all edges of the lattice; for those with ends near the surface and on one side of it their slopes, and where these tell
    /// of a sheet one value of the field, and three for each of up to eighteen samples around one that may be turned.
    pub(super) fn between(inside: &mut Indicator, of: &'a Traced) -> Self {
        let found = passed(of);
        let mut thin = Thin { of, through: FxHashMap::default(), turned: FxHashMap::default() };
        for &(edge, through) in &found {
            thin.through.insert((thin.offset(edge.from), edge.axis), through);
        }
        // Outside of the nearest facet may be inside of another body.
        let sides: &[Side] = if of.is_union() { &[Side::Inside] } else { &[Side::Inside, Side::Outside] };
        for &side in sides {
            for &(edge, through) in found.iter().filter(|(_, through)| side.of(through.1) < 0.0) {
                thin.turn_end(inside, side, edge, through);
            }
            if side == Side::Inside {
                thin.join_corners(inside);
            }
        }
        thin
    }

    /// The surface without what is no thicker than rounding, where samples were turned.
    ///
    /// # Cost
    /// O(facets), where any were.
    pub(super) fn without_films(&self, mesh: TriangleMesh) -> TriangleMesh {
        if self.turned.is_empty() { mesh } else { without_films(mesh, THICK * self.of.values.grid().h()) }
    }

    fn offset(&self, index: [isize; 3]) -> usize {
        self.of.values.grid().offset(index.map(|i| i as usize))
    }

    /// Turns the end of an edge that is nearer to the sheet across it, or the other one.
    fn turn_end(&mut self, inside: &mut Indicator, side: Side, edge: Edge, (t, _): OnEdge) {
        let ends = [edge.from, next(edge)].map(|index| index.map(|i| i as usize));
        let as_found = |index: &[usize; 3]| inside.contains(*index) == (side == Side::Outside);
        if !ends.iter().all(as_found) {
            return;
        }
        let point = self.of.point_of(edge, t);
        let depth = |index: [usize; 3]| self.of.values.at(index.map(|i| i as isize)).abs();
        let nearer_first = if depth(ends[0]) <= depth(ends[1]) { ends } else { [ends[1], ends[0]] };
        if let Some(sample) = nearer_first.into_iter().find(|&sample| self.may_turn(inside, side, sample, point)) {
            self.turn(inside, side, sample, point);
        }
    }

    fn turn(&mut self, inside: &mut Indicator, side: Side, sample: [usize; 3], point: Vec3) {
        inside.set(sample, side == Side::Inside);
        self.turned.insert(self.of.values.grid().offset(sample), point);
    }

    /// Whether a sample that stands for a point of a sheet would hang together only with what the sheet does.
    ///
    /// Inside all that it would join are asked. Outside one is enough of those that hang together around it, since no straight way leads past
    /// an edge of the part.
    fn may_turn(&self, inside: &Indicator, side: Side, sample: [usize; 3], point: Vec3) -> bool {
        let grid = self.of.values.grid();
        let dims = grid.dims();
        if (0..3).any(|a| sample[a] == 0 || sample[a] + 1 >= dims[a]) || self.turned.contains_key(&grid.offset(sample))
        {
            return false;
        }
        let like = |way: usize| inside.contains(beside(sample, way)) == (side == Side::Inside);
        let around: Vec<usize> = (0..27).filter(|&way| way != MIDDLE && like(way)).collect();
        let joined = |way: &usize| side.joins(away(MIDDLE, *way));
        let hangs = |way: usize| self.hang_together(side, [point, self.point(beside(sample, way))], APART);
        match side {
            Side::Inside => around.iter().filter(|way| joined(way)).all(|&way| hangs(way)),
            Side::Outside => pieces(&around, side).iter().all(|piece| {
                let mut touching = piece.iter().copied().filter(|way| joined(way)).peekable();
                touching.peek().is_none() || touching.any(hangs)
            }),
        }
    }

    /// The point that a sample stands for.
    fn point(&self, sample: [usize; 3]) -> Vec3 {
        let grid = self.of.values.grid();
        self.turned.get(&grid.offset(sample)).copied().unwrap_or_else(|| grid.position(sample))
    }

    /// Whether what is between two points is on a side, or off it by at most so many spacings.
    fn hang_together(&self, side: Side, [p, q]: [Vec3; 2], by: f64) -> bool {
        let on_way = |t: f64| self.of.value_at(add(scale(p, 1.0 - t), scale(q, t)));
        let off = by * self.of.values.grid().h();
        [0.5, 0.25, 0.75].into_iter().all(|t| on_way(t).is_some_and(|value| side.of(value) <= off))
    }

    /// Turns samples where two of a face of the lattice meet by their corner alone and what they stand for hangs together.
    fn join_corners(&mut self, inside: &mut Indicator) {
        for _ in 0..ROUNDS {
            let faces = met_by_corners(inside);
            let before = self.turned.len();
            for (pair, others) in faces {
                let still = pair.iter().all(|&p| inside.contains(p)) && !others.iter().any(|&o| inside.contains(o));
                let points = pair.map(|sample| self.point(sample));
                if !still || !self.hang_together(Side::Inside, points, 0.0) {
                    continue;
                }
                let point = scale(add(points[0], points[1]), 0.5);
                let depth = |index: [usize; 3]| self.of.values.at(index.map(|i| i as isize));
                let nearer_first = if depth(others[0]) <= depth(others[1]) { others } else { [others[1], others[0]] };
                let found = nearer_first.into_iter().find(|&sample| self.may_turn(inside, Side::Inside, sample, point));
                if let Some(sample) = found {
                    self.turn(inside, Side::Inside, sample, point);
                }
            }
            if self.turned.len() == before {
                return;
            }
        }
    }

    /// For the ends of an edge that were turned the points that they stand for.
    fn turned_ends(&self, edge: Edge) -> [Option<Vec3>; 2] {
        let dims = self.of.values.grid().dims();
        let on_grid = |index: [isize; 3]| (0..3).all(|a| (0..dims[a] as isize).contains(&index[a]));
        [edge.from, next(edge)].map(|index| {
            let asked = !self.turned.is_empty() && on_grid(index);
            asked.then(|| self.turned.get(&self.offset(index)).copied())?
        })
    }

    /// The place on an edge with one end turned in the sheet that this end stands for, if the sheet crosses the edge.
    fn leaves(&self, edge: Edge) -> Option<OnEdge> {
        let dims = self.of.values.grid().dims();
        let known = (0..3).all(|a| (0..dims[a] as isize).contains(&edge.from[a]));
        let found = known.then(|| self.through.get(&(self.offset(edge.from), edge.axis)).copied())??;
        let point = self.turned_ends(edge).into_iter().flatten().next()?;
        let within = self.of.point_of(edge, found.0);
        (within == point || self.hang_together(self.side_of(point)?, [point, within], APART)).then_some(found)
    }

    /// The side that a point is on, if that is known.
    fn side_of(&self, point: Vec3) -> Option<Side> {
        let value = self.of.value_at(point)?;
        Some(if value <= 0.0 { Side::Inside } else { Side::Outside })
    }

    /// Where the way from a point beside a sheet to one in it enters that, as its last part tells.
    fn on_the_way(&self, side: Side, from: Vec3, to: Vec3) -> Option<Vec3> {
        let at = |t: f64| add(scale(from, 1.0 - t), scale(to, t));
        let (mut out, mut within) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let t = 0.5 * (out + within);
            if side.of(self.of.value_at(at(t))?) <= 0.0 { within = t } else { out = t }
        }
        Some(at(within))
    }
}

/// A sample among the 27 around it.
const MIDDLE: usize = 13;

/// One of the 27 samples around one that is not at the border.
fn beside(sample: [usize; 3], way: usize) -> [usize; 3] {
    let steps = [way % 3, way / 3 % 3, way / 9];
    [0, 1, 2].map(|a| sample[a] + steps[a] - 1)
}

/// Those of the 27 samples, of one side, that hang together.
fn pieces(ways: &[usize], side: Side) -> Vec<Vec<usize>> {
    let mut left = ways.to_vec();
    let mut found = Vec::new();
    while let Some(first) = left.pop() {
        let mut piece = vec![first];
        let mut at = 0;
        while let Some(&way) = piece.get(at) {
            let (near, far) = left.into_iter().partition(|&other| side.joins(away(way, other)));
            piece.extend::<Vec<usize>>(near);
            left = far;
            at += 1;
        }
        found.push(piece);
    }
    found
}

/// In how many places two of them differ by one; more than three where they are no neighbours.
fn away(one: usize, other: usize) -> usize {
    let steps = |way: usize| [way % 3, way / 3 % 3, way / 9];
    let (p, q) = (steps(one), steps(other));
    (0..3).map(|a| p[a].abs_diff(q[a]).pow(3)).sum()
}

fn next(edge: Edge) -> [isize; 3] {
    let mut next = edge.from;
    next[edge.axis] += 1;
    next
}

/// The edges of the lattice whose ends are on one side and whose middle part is on the other, as the planes tell that the surface has at
/// their ends, and the field between.
fn passed(of: &Traced) -> Vec<(Edge, OnEdge)> {
    let grid = of.values.grid();
    let ([nx, ny, nz], h) = (grid.dims(), grid.h());
    let values = of.values.values();
    let ends = |index: [usize; 3], axis: usize| {
        let (at, stride) = (grid.offset(index), [1, nx, nx * ny][axis]);
        let inner = index[axis] + 1 < [nx, ny, nz][axis];
        inner.then(|| [values[at], values[at + stride]])
    };
    let of_plane = |k: usize| {
        let mut found = Vec::new();
        for j in 0..ny {
            let row = (k * ny + j) * nx;
            for (block, samples) in values[row..row + nx].chunks(BLOCK).enumerate() {
                // Most lie far from the surface.
                if samples.iter().fold(f32::MAX, |least, value| least.min(value.abs())) >= h as f32 {
                    continue;
                }
                for index in (0..samples.len()).map(|i| [block * BLOCK + i, j, k]) {
                    found.extend((0..3).filter_map(|axis| {
                        let [a, b] = ends(index, axis)?;
                        if (a > 0.0) != (b > 0.0) || a.abs() + b.abs() >= h as f32 {
                            return None;
                        }
                        let edge = Edge { from: index.map(|n| n as isize), axis };
                        Some((edge, through(of, edge, [a, b].map(f64::from))?))
                    }));
                }
            }
        }
        found
    };
    (0..nz).into_par_iter().flat_map_iter(of_plane).collect()
}

/// The place in the middle between the two where the surface crosses an edge with these values at its ends, if it does.
fn through(of: &Traced, edge: Edge, [a, b]: [f64; 2]) -> Option<OnEdge> {
    let h = of.values.grid().h();
    let side = if a > 0.0 { 1.0 } else { -1.0 };
    let falls = side * of.slope(edge.from, a)?[edge.axis];
    if falls >= 0.0 {
        return None;
    }
    let rises = side * of.slope(next(edge), b)?[edge.axis];
    let (first, last) = (a.abs() / (-falls * h), 1.0 - b.abs() / (rises * h));
    if rises <= 0.0 || first >= last {
        return None;
    }
    let t = 0.5 * (first + last);
    let value = of.value_at(of.point_of(edge, t))?;
    (side * value < -THICK * h).then_some((t, value))
}

impl Sheets for Thin<'_> {
    type Note = <Traced as Sheets>::Note;

    /// As without samples turned; at one of these, where the surface leaves its sheet again.
    fn crossing(&self, edge: Edge) -> (f64, Self::Note) {
        let first = match self.turned_ends(edge) {
            [None, None] => return self.of.crossing(edge),
            [Some(_), Some(_)] => return (0.5, None),
            [first, _] => first.is_some(),
        };
        let Some(through) = self.leaves(edge) else {
            return (if first { STAND } else { 1.0 - STAND }, None);
        };
        let [a, b] = [edge.from, next(edge)].map(|index| f64::from(self.of.values.at(index)));
        let [low, high] = if first { [through, (1.0, b)] } else { [(0.0, a), through] };
        let t = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
        self.of.stepped_crossing(edge, t, [low, high])
    }

    fn aside(&self, edge: Edge) -> Option<Vec3> {
        let (point, t) = match self.turned_ends(edge) {
            [Some(point), None] => (point, STAND),
            [None, Some(point)] => (point, 1.0 - STAND),
            _ => return None,
        };
        if self.leaves(edge).is_some() {
            return None;
        }
        let p = self.of.point_of(edge, t);
        let side = self.side_of(point)?;
        let foot = Some(self.of.onto(p)).filter(|&foot| foot != p && self.hang_together(side, [point, foot], APART));
        foot.or_else(|| self.on_the_way(side, p, point))
    }

    fn normals(&self, cell: [isize; 3], corners: &[Vec3], seen: &[Self::Note]) -> Option<Vec<Vec3>> {
        self.of.normals(cell, corners, seen)
    }

    fn bend(&self, ends: [Vec3; 2], normals: [Self::Note; 2]) -> f64 {
        self.of.bend(ends, normals)
    }

    fn beside(&self, x: Vec3, plane: (Vec3, Vec3)) -> (Vec3, Vec3) {
        self.of.beside(x, plane)
    }

    fn onto(&self, p: Vec3) -> Vec3 {
        self.of.onto(p)
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::contour::MEETING;
    use crate::geometry::health::{Through, crossing_pairs};
    use crate::geometry::{TriangleMesh, cuboid};
    use crate::morphology::{Shaped, close_by_ball, offset, open_by_ball};
    use crate::random::Lcg;
    use crate::units::Length;

    /// A wedge of an angle, 6 mm long and 3 mm high, its edge along z, turned about it.
    fn wedge(angle_deg: f64, turn_deg: f64) -> TriangleMesh {
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        let y = 6.0 * (0.5 * angle_deg).to_radians().tan();
        let turned = |[x, y]: [f64; 2], z: f64| [cos * x - sin * y, sin * x + cos * y, z];
        let outline = [[0.0, 0.0], [6.0, -y], [6.0, y]];
        let vertices = [0.0, 3.0].into_iter().flat_map(|z| outline.map(|p| turned(p, z))).collect();
        let triangles = vec![[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
        TriangleMesh { vertices, triangles }
    }

    /// The volume of the wedge and of its offsets inwards, which are wedges of the same angle.
    fn volume(angle_deg: f64, by: f64) -> f64 {
        let half = (0.5 * angle_deg).to_radians();
        let long = 6.0 + by + by / half.sin();
        long * long * half.tan() * (3.0 + 2.0 * by)
    }

    const H: f64 = 0.12;

    fn crossing(made: &TriangleMesh) -> usize {
        let all: Vec<u32> = (0..made.triangles.len() as u32).collect();
        crossing_pairs(made, &all, MEETING * H, Through::Inside).len()
    }

    #[test]
    fn sharp_edges_keep_their_ends() {
        for turn in [5.0, 11.0, 17.0, 28.0, 33.0, 40.0, 45.0] {
            for angle in [8.0, 12.0, 16.0, 20.0, 30.0, 40.0] {
                let part = wedge(angle, turn);
                let check = |made: Shaped, truth: f64| {
                    assert_eq!(made.mesh.pieces(), 1, "{angle}° turned by {turn}°");
                    assert_eq!(crossing(&made.mesh), 0, "{angle}° turned by {turn}°");
                    // At the three edges along z no more is missing than a square of half a spacing together.
                    let off = made.mesh.signed_volume() - truth;
                    assert!(off.abs() < 0.25 * H * H * 3.0, "{angle}° turned by {turn}°: {off} mm³ of {truth}");
                };
                check(close_by_ball(&part, Length::mm(0.5), Length::mm(H)).unwrap(), volume(angle, 0.0));
                for by in [-0.3, -0.05, 0.0] {
                    check(offset(&part, Length::mm(by), Length::mm(H)).unwrap(), volume(angle, by));
                }
                // Smaller than the spacing a ball may lie between samples, beyond the wall that it is to touch.
                let opened = open_by_ball(&part, Length::mm(0.05), Length::mm(H)).unwrap();
                assert_eq!(opened.mesh.pieces(), 1, "{angle}° turned by {turn}°");
            }
        }
    }

    #[test]
    fn a_void_stays_closed_behind_walls_as_thin_as_the_spacing_and_bodies_stay_apart() {
        let mut random = Lcg(7);
        for _ in 0..6 {
            let turn = random.rotation();
            let made = |part: TriangleMesh, by: f64| {
                offset(&part.transformed(turn, [0.03, 0.01, 0.02]), Length::mm(by), Length::mm(H)).unwrap().mesh
            };
            let void = || cuboid([0.0; 3], [0.6, 0.6, 0.36]).flipped();
            for wall in [0.8 * H, 1.1 * H, 1.4 * H] {
                let hollow = cuboid([-wall; 3], [0.6 + wall, 0.6 + wall, 0.36 + wall]).joined(&void());
                assert_eq!(made(hollow, 0.0).pieces(), 2, "{wall} mm, {turn:?}");
            }
            let one = || cuboid([0.0; 3], [0.5, 0.5, 0.5]);
            let other = cuboid([0.5 + 0.6 * H, 0.0, 0.0], [1.0 + 0.6 * H, 0.5, 0.5]);
            assert_eq!(made(one().joined(&other), -0.1 * H).pieces(), 2, "{turn:?}");
        }
    }

    #[test]
    fn sheets_and_gaps_thinner_than_the_spacing_stay_whole() {
        for turn in [0.0f64, 7.0, 23.0, 45.0] {
            let (sin, cos) = turn.to_radians().sin_cos();
            let tilted = |mesh: TriangleMesh| {
                let about_z = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
                let about_x = [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]];
                mesh.transformed(about_z, [0.0; 3]).transformed(about_x, [0.03, 0.01, 0.02])
            };
            for thick in [0.02, 0.05, 0.1] {
                let plate = tilted(cuboid([0.0; 3], [3.0, thick, 2.0]));
                let made = offset(&plate, Length::mm(0.0), Length::mm(H)).unwrap().mesh;
                let hollow =
                    cuboid([-1.0; 3], [4.0, 1.0 + thick, 3.0]).joined(&cuboid([0.0; 3], [3.0, thick, 2.0]).flipped());
                let kept = offset(&tilted(hollow), Length::mm(0.0), Length::mm(H)).unwrap().mesh;
                let (of_plate, of_hollow) = (6.0 * thick, 5.0 * (2.0 + thick) * 4.0 - 6.0 * thick);
                // Along the rim of 10 mm up to half a spacing may be missing.
                let missing = 10.0 * 0.5 * H * thick;
                for (made, pieces, short_by) in
                    [(&made, 1, of_plate - made.signed_volume()), (&kept, 2, kept.signed_volume() - of_hollow)]
                {
                    assert_eq!((made.pieces(), crossing(made)), (pieces, 0), "{thick} mm turned by {turn}°");
                    assert!(
                        (-1e-3..missing).contains(&short_by),
                        "{thick} mm turned by {turn}°: {short_by} of {of_plate} mm³"
                    );
                }
            }
        }
    }
}
