//! Where the chords of a patch lead: half-spaces that hold them all, and what of a feature lies in these.

use super::chord::{MARGIN, Patch, WALL_SEPARATION};
use crate::geometry::triangle::closest_pair;
use crate::geometry::vector::{Vec3, along, cross, distance, dot, scale, sub, unit};

/// Sines and cosines of the eighths of a turn.
const EIGHTHS: [(f64, f64); 8] = {
    const H: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [(0.0, 1.0), (H, H), (1.0, 0.0), (H, -H), (0.0, -1.0), (-H, -H), (-1.0, 0.0), (-H, H)]
};

/// The half-spaces that hold every chord of a patch: a pyramid about the cone of chord directions, swept over the patch.
///
/// One lane each, so that eight are tested at once; lanes without a half-space hold everything.
pub(super) struct Reach {
    /// Components of the outward directions: positive ones, negative ones.
    out: [[[f64; LANES]; 2]; 3],
    offset: [f64; LANES],
}

/// Half-spaces of a pyramid.
const LANES: usize = EIGHTHS.len();
/// What rounding to f32 may do to a height over a plane, relative to the coordinates: some fifteen steps.
const ROUNDING_F32: f64 = 1e-6;

/// The half-spaces of a reach in f32, a little wider: what a box of the tree is held against.
pub(super) struct Slabs {
    out: [[[f32; LANES]; 2]; 3],
    offset: [f32; LANES],
}

impl Slabs {
    /// The half-spaces for boxes that lie in one.
    pub(super) fn new(reach: &Reach, (lo, hi): ([f32; 3], [f32; 3])) -> Self {
        let largest: f64 = (0..3).map(|a| f64::from(lo[a].abs().max(hi[a].abs()))).sum();
        let margin = ROUNDING_F32 * largest;
        Slabs {
            out: reach.out.map(|parts| parts.map(|lanes| lanes.map(|x| x as f32))),
            offset: reach.offset.map(|x| ((x + margin) as f32).next_up()),
        }
    }

    /// Whether a box may have a point in all half-spaces taken one by one; `false` is certain.
    #[inline(always)]
    pub(super) fn may_meet(&self, (lo, hi): ([f32; 3], [f32; 3])) -> bool {
        let mut meets = true;
        for lane in 0..LANES {
            let least = |a: usize| self.out[a][0][lane] * lo[a] + self.out[a][1][lane] * hi[a];
            meets &= least(0) + least(1) + least(2) <= self.offset[lane];
        }
        meets
    }
}

impl Reach {
    pub(super) fn new(patch: &Patch) -> Self {
        let half_angle = 0.5 * (std::f64::consts::PI - WALL_SEPARATION) + MARGIN + patch.spread + patch.slack;
        Reach::of(&patch.corners, patch.axis, half_angle)
    }

    /// For lines from the hull of some points, at no more than an angle to the opposite of an axis.
    pub(super) fn of(from: &[Vec3], axis: Vec3, half_angle: f64) -> Self {
        let inward = scale(axis, -1.0);
        let offset = |w: Vec3| from.iter().map(|&p| dot(p, w)).fold(f64::NEG_INFINITY, f64::max);
        let mut reach = Reach { out: [[[0.0; LANES]; 2]; 3], offset: [f64::INFINITY; LANES] };
        if half_angle < 1.4 {
            let side = if inward[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
            let u = unit(cross(inward, side));
            let v = cross(inward, u);
            let (sin, cos) = half_angle.sin_cos();
            for (lane, (s, c)) in EIGHTHS.into_iter().enumerate() {
                let of = |a: usize| cos * (c * u[a] + s * v[a]) - sin * inward[a];
                let w = [of(0), of(1), of(2)];
                reach.set(lane, w, offset(w));
            }
        } else if half_angle < 1.57 {
            reach.set(0, axis, offset(axis));
        }
        reach
    }

    fn set(&mut self, lane: usize, w: Vec3, offset: f64) {
        for (parts, w) in self.out.iter_mut().zip(w) {
            (parts[0][lane], parts[1][lane]) = (w.max(0.0), w.min(0.0));
        }
        self.offset[lane] = offset;
    }

    /// The half-spaces one by one: p·w ≤ offset.
    fn planes(&self) -> impl Iterator<Item = (Vec3, f64)> {
        let [x, y, z] = &self.out;
        let of = |parts: &[[f64; LANES]; 2], lane: usize| parts[0][lane] + parts[1][lane];
        let plane = move |lane: usize| ([of(x, lane), of(y, lane), of(z, lane)], self.offset[lane]);
        (0..LANES).map(plane).filter(|(_, offset)| *offset < f64::INFINITY)
    }

    /// Whether each half-space holds a point of a triangle.
    #[inline(always)]
    pub(super) fn meets_corners(&self, t: &[Vec3; 3]) -> bool {
        let mut meets = true;
        for lane in 0..LANES {
            let of = |a: usize| self.out[a][0][lane] + self.out[a][1][lane];
            let (x, y, z, most) = (of(0), of(1), of(2), self.offset[lane]);
            let holds = |p: Vec3| p[0] * x + p[1] * y + p[2] * z <= most;
            meets &= holds(t[0]) | holds(t[1]) | holds(t[2]);
        }
        meets
    }

    /// Whether a point lies in all half-spaces.
    pub(super) fn holds(&self, p: Vec3) -> bool {
        self.meets_corners(&[p; 3])
    }

    /// The part of a feature inside all half-spaces, as a convex polygon; `None` if there is none.
    pub(super) fn clip(&self, feature: [Vec3; 3]) -> Option<Polygon> {
        let mut polygon = Polygon::new(feature);
        for (w, offset) in self.planes() {
            polygon = polygon.clipped(w, offset);
            if polygon.count == 0 {
                return None;
            }
        }
        Some(polygon)
    }
}

/// A convex polygon of at most a triangle's corners plus one for each clip.
pub(super) struct Polygon {
    points: [Vec3; 14],
    count: usize,
}

impl Polygon {
    fn new(t: [Vec3; 3]) -> Self {
        let mut points = [[0.0; 3]; 14];
        points[..3].copy_from_slice(&t);
        Polygon { points, count: 3 }
    }

    /// The part where p·w ≤ offset.
    fn clipped(&self, w: Vec3, offset: f64) -> Polygon {
        let mut out = Polygon { points: [[0.0; 3]; 14], count: 0 };
        for i in 0..self.count {
            let (p, q) = (self.points[i], self.points[(i + 1) % self.count]);
            let (a, b) = (dot(p, w) - offset, dot(q, w) - offset);
            if a <= 0.0 {
                out.push(p);
            }
            if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                out.push(along(p, sub(q, p), a / (a - b)));
            }
        }
        out
    }

    fn push(&mut self, p: Vec3) {
        if self.count < self.points.len() {
            self.points[self.count] = p;
            self.count += 1;
        }
    }

    /// Nearest points of another triangle and this polygon.
    fn closest(&self, from: [Vec3; 3]) -> (Vec3, Vec3) {
        let fan =
            |i: usize| [self.points[0], self.points[i.min(self.count - 1)], self.points[(i + 1).min(self.count - 1)]];
        let mut best = closest_pair(from, fan(1));
        for i in 2..self.count.saturating_sub(1) {
            let next = closest_pair(from, fan(i));
            if distance(next.0, next.1) < distance(best.0, best.1) {
                best = next;
            }
        }
        best
    }
}

/// Nearest points of two convex polygons, as the least over their fans.
pub(super) fn closest_polygons(a: &Polygon, b: &Polygon) -> (Vec3, Vec3) {
    let fan = |i: usize| [a.points[0], a.points[i.min(a.count - 1)], a.points[(i + 1).min(a.count - 1)]];
    let mut best = b.closest(fan(1));
    for i in 2..a.count.saturating_sub(1) {
        let next = b.closest(fan(i));
        if distance(next.0, next.1) < distance(best.0, best.1) {
            best = next;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::bounds;
    use crate::random::Lcg;

    #[test]
    fn lanes_hold_what_the_half_spaces_hold_one_by_one() {
        let mut random = Lcg(21);
        for n in 0..400 {
            let corners = [random.point(-1.0, 1.0), random.point(-1.0, 1.0), random.point(-1.0, 1.0)];
            let spread = [0.0, 0.3, 1.25, 1.4][n % 4];
            let patch = Patch { corners, axis: unit(random.point(-1.0, 1.0)), spread, slack: 0.0, whole: corners };
            let reach = Reach::new(&patch);
            let t = [random.point(-2.0, 2.0), random.point(-2.0, 2.0), random.point(-2.0, 2.0)];
            let (lo, hi) = bounds(t).unwrap();
            let (from, to) = (lo.map(|x| (x as f32).next_down()), hi.map(|x| (x as f32).next_up()));
            let least = |w: Vec3| (0..3).map(|a| if w[a] > 0.0 { w[a] * lo[a] } else { w[a] * hi[a] }).sum::<f64>();
            let may_meet = Slabs::new(&reach, ([-2.0; 3], [2.0; 3])).may_meet((from, to));
            let meets = |more: f64| reach.planes().all(|(w, offset)| least(w) <= offset + more);
            assert!(may_meet || !meets(0.0));
            assert!(!may_meet || meets(2e-5));
            let below = |(w, offset): (Vec3, f64)| t.iter().any(|p| dot(*p, w) <= offset);
            assert_eq!(reach.meets_corners(&t), reach.planes().all(below));
        }
    }
}
