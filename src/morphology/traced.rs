//! The surface where a field of exact distances vanishes.

use super::level::{Level, SMOOTH_COSINE, Seen, root_of_cubic};
use super::thin::Thin;
use super::walls::Walls;
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::TriangleMesh;
use crate::geometry::contour::{Edge, Sheets, bend_between, creased_surface, linear_crossing, sharp_surface};
use crate::geometry::refine::{Halvings, split_curved_edges};
use crate::geometry::vector::{Vec3, add, along, dot, scale, sub, unit};

/// Slopes along an edge that are this near to the mean one, of at most 1, belong to no crease that matters.
const SMOOTH_SLOPE: f64 = 0.1;

/// A crossing is sought by at most this many distances along an edge: most take two, edges almost along the surface more.
const MOST_STEPS: usize = 8;

/// A step of Newton's along an edge that is this short, in spacings, ends on the surface, and the normal where it started is
/// the one there.
const NEAR_CROSSING: f64 = 0.1;

/// Edges of a result that are inscribed deeper than this, in spacings, are split.
const FINE: f64 = 0.003;

/// Those of what another surface is measured to.
const BETWEEN: f64 = 0.01;

/// A field that is exact within a spacing of zero, of the right sign elsewhere, and what it was measured to.
pub(super) struct Traced {
    /// Millimetres, negative inside.
    pub(super) values: Field<f32>,
    /// The level that the zeros lie on; none if there is no such surface.
    pub(super) level: Option<Level>,
    /// Where they lie on the part itself instead.
    pub(super) walls: Option<Walls>,
}

impl Traced {
    /// The surface of `{ s ≤ 0 }`: its vertices on the level, its creases kept, its edges split where they are
    /// inscribed by more than [`FINE`], and no facets that cross, as far as the samples tell where sheets come near each other. What
    /// passes between samples is kept as [`Thin`] finds it.
    pub(super) fn surface(&self) -> Result<TriangleMesh> {
        let mut inside = self.inside();
        let thin = Thin::between(&mut inside, self);
        let (mesh, crowd) = sharp_surface(&inside, &thin)?;
        let mesh = split_curved_edges(&mesh, Some(&crowd), self.deepest(FINE), self.halvings(), |p| self.onto(p));
        Ok(thin.without_films(mesh))
    }

    /// The surface that another one is measured to: its edges are split where they are inscribed by more than [`BETWEEN`], and facets
    /// may cross where creases lie close.
    pub(super) fn between(&self) -> Result<TriangleMesh> {
        let mesh = creased_surface(&self.inside(), self)?;
        Ok(split_curved_edges(&mesh, None, self.deepest(BETWEEN), self.halvings(), |p| self.onto(p)))
    }

    /// Outwards the surface is round along all convex edges; elsewhere it is as flat as the part.
    fn halvings(&self) -> Halvings {
        let outwards = self.walls.is_none() && self.level.as_ref().is_some_and(|level| level.r > 0.0);
        if outwards { Halvings::Two } else { Halvings::One }
    }

    fn inside(&self) -> Indicator {
        Indicator::from_predicate(*self.values.grid(), |at| self.values.values()[at] <= 0.0)
    }

    /// So many spacings in millimetres.
    fn deepest(&self, spacings: f64) -> f64 {
        spacings * self.values.grid().h()
    }

    /// The point of an edge that is so far along it, of 1.
    pub(super) fn point_of(&self, edge: Edge, t: f64) -> Vec3 {
        let grid = self.values.grid();
        [0, 1, 2].map(|i| grid.origin()[i] + grid.h() * (edge.from[i] as f64 + if i == edge.axis { t } else { 0.0 }))
    }

    /// The slope of the field at a sample with a value, where it is exact.
    pub(super) fn slope(&self, index: [isize; 3], value: f64) -> Option<Vec3> {
        self.level_of(index)?.slope(index, value)
    }

    /// Whether it was measured to several bodies as one.
    pub(super) fn is_union(&self) -> bool {
        let of_walls = self.walls.as_ref().map(Walls::level);
        self.level.iter().chain(of_walls).any(|level| level.near.is_of_union())
    }

    /// The level that a sample was measured to, if it was to one.
    fn level_of(&self, index: [isize; 3]) -> Option<&Level> {
        match &self.walls {
            Some(walls) if walls.hold(index) => Some(walls.level()),
            Some(walls) if walls.pressed(index) => None,
            _ => self.level.as_ref(),
        }
    }

    /// The surface as seen from a point near it.
    fn seen(&self, p: Vec3) -> Option<Seen> {
        let on_wall = self.walls.as_ref().and_then(|walls| walls.seen(p));
        on_wall.or_else(|| self.walls.as_ref()?.seen_pressed(p)).or_else(|| self.level.as_ref()?.seen(p))
    }

    /// The field at a point near the surface, as far as what was measured there tells.
    pub(super) fn value_at(&self, p: Vec3) -> Option<f64> {
        self.seen(p).map(|seen| seen.value.0)
    }

    /// Where an edge enters a union of bodies from its end outside, and the outward normal there.
    fn entry(&self, edge: Edge, [a, b]: [f64; 2]) -> Option<(f64, Vec3)> {
        let level = self.level.as_ref().filter(|level| level.r == 0.0 && self.walls.is_none())?;
        let (from, to) = if a > b { (0.0, 1.0) } else { (1.0, 0.0) };
        let p = self.point_of(edge, from);
        let d = sub(self.point_of(edge, to), p);
        let (t, normal) = level.near.entry(p, d)?;
        Some((if a > b { t } else { 1.0 - t }, normal))
    }

    /// Where `s` vanishes along an edge, from `t` on: by Newton's steps, which end on a plane; where these leave what is known
    /// to hold the crossing, by regula falsi that halves the value of an end kept twice (Dowell and Jarratt 1971, "A modified
    /// regula falsi method", BIT 11).
    ///
    /// The ends are places on the edge with the values there.
    pub(super) fn stepped_crossing(&self, edge: Edge, mut t: f64, ends: [(f64, f64); 2]) -> (f64, Option<Vec3>) {
        let [mut low, mut high] = ends;
        let (a, b) = (low.1, high.1);
        let (mut note, mut last) = (None, None);
        for _ in 0..MOST_STEPS {
            let p = self.point_of(edge, t);
            let Some(Seen { value: (s, slope), normal }) = self.seen(p) else { break };
            let newton = t - s / (self.values.grid().h() * slope[edge.axis]);
            let (before, at_low) = (t, (s > 0.0) == (a > 0.0));
            let (end, kept) = if at_low { (&mut low, &mut high) } else { (&mut high, &mut low) };
            *end = (t, s);
            kept.1 *= if last == Some(at_low) { 0.5 } else { 1.0 };
            last = Some(at_low);
            let by_newton = (low.0..=high.0).contains(&newton) && slope[edge.axis] * (b - a) > 0.0;
            if s != 0.0 {
                t = if by_newton { newton } else { low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1) };
            }
            let step = (t - before).abs();
            note = (by_newton && step < NEAR_CROSSING).then_some(normal);
            if step < if by_newton { NEAR_CROSSING } else { 0.1 * NEAR_CROSSING } {
                break;
            }
        }
        (t, note)
    }
}

/// Newton's step along an edge from its end that is farther from the surface, if it stays on the edge: on the crossing itself where the
/// surface is flat up to a crease between there and the nearer end.
fn newton_from_farther_end([a, b]: [f64; 2], slopes: [Option<f64>; 2]) -> Option<f64> {
    let (end, value, slope) = if a.abs() > b.abs() { (0.0, a, slopes[0]?) } else { (1.0, b, slopes[1]?) };
    let t = end - value / slope;
    (slope * (b - a) > 0.0 && (0.0..=1.0).contains(&t)).then_some(t)
}

impl Sheets for Traced {
    /// The normal, if it was taken near the crossing.
    type Note = Option<Vec3>;

    /// The root of the cubic through the exact values and slopes at both ends; where these tell of a crease, by distances
    /// between.
    fn crossing(&self, edge: Edge) -> (f64, Option<Vec3>) {
        let h = self.values.grid().h();
        let mut next = edge.from;
        next[edge.axis] += 1;
        let (a, b) = (f64::from(self.values.at(edge.from)), f64::from(self.values.at(next)));
        let t = linear_crossing(&self.values, edge, 0.0);
        if !(0.0..=1.0).contains(&t) {
            return (t, None);
        }
        if let Some((t, normal)) = self.entry(edge, [a, b]) {
            return (t, Some(normal));
        }
        let slopes = [self.slope(edge.from, a), self.slope(next, b)];
        if let [Some(m), Some(n)] = slopes {
            let ends = [m, n].map(|slope| h * slope[edge.axis]);
            if ends.iter().all(|slope| (slope - (b - a)).abs() < SMOOTH_SLOPE * h) {
                let root = root_of_cubic([a, b], ends, t);
                return (root, Some(unit(add(scale(m, 1.0 - root), scale(n, root)))));
            }
        }
        let along_edge = slopes.map(|slope| slope.map(|slope| h * slope[edge.axis]));
        self.stepped_crossing(edge, newton_from_farther_end([a, b], along_edge).unwrap_or(t), [(0.0, a), (1.0, b)])
    }

    /// Known unless those seen beside the points tell that the surface is not creased there.
    fn normals(&self, _: [isize; 3], corners: &[Vec3], seen: &[Option<Vec3>]) -> Option<Vec<Vec3>> {
        let pairs = || (0..corners.len()).flat_map(|i| (0..i).map(move |j| [i, j]));
        let smooth = |[i, j]: [usize; 2]| matches!((seen[i], seen[j]), (Some(m), Some(n)) if dot(m, n) > SMOOTH_COSINE);
        if pairs().all(smooth) {
            return None;
        }
        let on_walls: Vec<Option<Vec3>> =
            corners.iter().map(|&p| self.walls.as_ref().and_then(|walls| walls.normal(p))).collect();
        let pressed = |p| Some(self.walls.as_ref()?.seen_pressed(p)?.normal);
        let normal =
            |(&p, wall): (&Vec3, &Option<Vec3>)| wall.or_else(|| pressed(p)).or_else(|| self.level.as_ref()?.normal(p));
        let normals: Vec<Vec3> = corners.iter().zip(&on_walls).map(normal).collect::<Option<_>>()?;
        // Outwards every convex edge is rounded and inwards every concave one: only the other kind is a crease, but on
        // walls, which keep theirs.
        let r = self.level.as_ref().filter(|_| on_walls.iter().any(Option::is_none)).map_or(0.0, |level| level.r);
        let opening: f64 = pairs().map(|[i, j]| dot(sub(corners[i], corners[j]), sub(normals[i], normals[j]))).sum();
        (opening * r <= 0.0).then_some(normals)
    }

    fn bend(&self, ends: [Vec3; 2], normals: [Option<Vec3>; 2]) -> f64 {
        bend_between(ends, normals)
    }

    fn beside(&self, x: Vec3, (p, normal): (Vec3, Vec3)) -> (Vec3, Vec3) {
        let walls = self.walls.as_ref();
        if walls.is_some_and(|walls| walls.normal(p).is_some() || walls.seen_pressed(p).is_some()) {
            return (p, normal);
        }
        self.level.as_ref().and_then(|level| level.beside(x, p)).unwrap_or((p, normal))
    }

    fn onto(&self, p: Vec3) -> Vec3 {
        let on_wall = self.walls.as_ref().and_then(|walls| walls.project(p));
        let on_ball = || {
            let (s, slope) = self.walls.as_ref()?.seen_pressed(p)?.value;
            (s.abs() < 0.25 * self.values.grid().h()).then(|| along(p, slope, -s))
        };
        on_wall.or_else(on_ball).or_else(|| self.level.as_ref()?.project(p)).unwrap_or(p)
    }
}
