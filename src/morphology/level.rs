//! Where the distance to a mesh has a value: crossings, normals and points of that surface.

use super::near::Near;
use crate::geometry::distance::Nearest;
use crate::geometry::vector::{Vec3, along, distance, dot, scale, sub};

/// Normals closer together than 25° belong to no crease of 30°, wherever on the cell's edges they were taken.
pub(super) const SMOOTH_COSINE: f64 = 0.906;

/// A point this near to a facet, in spacings, is on it: rounding alone tells which way it is off.
const ON_FACET: f64 = 1e-6;

/// A point within this many spacings of a level may be brought onto it.
const BESIDE: f64 = 0.6;

/// A point is on a level near the mesh if its distance is off by less than this, in spacings.
const ON_LEVEL: f64 = 0.001;

/// A point is brought from body to body at most so often: each time leaves cos² of the angle between their surfaces.
const MOST_PROJECTIONS: usize = 4;

/// The level set `{ x : d(x) = r }` of the signed distance d to a mesh, seen from the samples of a grid.
pub(super) struct Level {
    pub(super) near: Near,
    pub(super) r: f64,
}

/// What is known of a level at a point beside it.
pub(super) struct Seen {
    /// `d − r` there, with its slope.
    pub(super) value: (f64, Vec3),
    /// Outward normal of the level.
    pub(super) normal: Vec3,
}

impl Level {
    /// The slope of `d − r` at a sample where that is exact: outwards, of length 1.
    pub(super) fn slope(&self, index: [isize; 3], value: f64) -> Option<Vec3> {
        self.near.slope(index, value + self.r)
    }

    /// The level as seen from a point near it.
    pub(super) fn seen(&self, p: Vec3) -> Option<Seen> {
        let n = self.near.nearest(p)?;
        Some(Seen { value: self.value(p, &n), normal: self.normal_over(p, &n) })
    }

    /// Outward normal of the level at a point on it.
    pub(super) fn normal(&self, p: Vec3) -> Option<Vec3> {
        Some(self.normal_over(p, &self.near.nearest(p)?))
    }

    /// The plane that touches beside x the sheet of the level that p lies on, as a point and the outward normal.
    pub(super) fn beside(&self, x: Vec3, p: Vec3) -> Option<(Vec3, Vec3)> {
        let from = self.near.nearest(p)?;
        // A body's sheet goes on inside others.
        let own = || self.near.on_body_of(from.facet, x, 2.0 * (distance(x, p) + from.distance));
        let nearest = own().or_else(|| self.near.nearest(x))?;
        let sheet = match self.height(p, &from) {
            // Over a facet the level is flat, and seen from beyond the facet's rim it is no rounder.
            Some((_, facing)) => (from.point, facing),
            None => {
                let foot = self.near.mesh().nearest_of(x, from.facet);
                (foot.point, self.normal_over(x, &foot))
            }
        };
        let over_nearest = self.normal_over(x, &nearest);
        // A sheet goes on beyond its facet.
        let same = dot(sheet.1, over_nearest) > SMOOTH_COSINE;
        let (foot, normal) = if same { (nearest.point, over_nearest) } else { sheet };
        Some((along(foot, normal, self.r), normal))
    }

    /// `d − r` at a point near the level, with its slope: the side is that of the level, or where the level is too near to
    /// the mesh, that of the facet the point stands over or beside.
    fn value(&self, p: Vec3, n: &Nearest) -> (f64, Vec3) {
        let r = self.r;
        let over = (r.abs() <= 1.5 * self.near.h()).then(|| self.height(p, n)).flatten();
        let side = match over {
            Some((height, facing)) if n.distance < ON_FACET * self.near.h() => return (height - r, facing),
            Some((height, _)) => height.signum(),
            None if r.abs() > 1.5 * self.near.h() => r.signum(),
            None if self.near.is_inside(p, n) => -1.0,
            None => 1.0,
        };
        (side * n.distance - r, scale(sub(p, n.point), side / n.distance))
    }

    /// How high a point is over the facet of its nearest point, and the outward normal there; none if it is beside the facet.
    pub(super) fn height(&self, p: Vec3, n: &Nearest) -> Option<(f64, Vec3)> {
        let facing = self.near.facing(n);
        let height = dot(sub(p, n.point), facing);
        let over = height.abs() >= 0.99 * n.distance || n.distance < ON_FACET * self.near.h();
        over.then_some((height, facing))
    }

    /// Outward normal of the level at a point on it, whose nearest point of the mesh is given.
    fn normal_over(&self, p: Vec3, n: &Nearest) -> Vec3 {
        let apart = self.r.abs() > 0.05 * self.near.h() && n.distance > 0.5 * self.r.abs();
        if apart { scale(sub(p, n.point), self.r.signum() / n.distance) } else { self.near.facing(n) }
    }

    /// A point of a body's surface, or where other bodies of a union hold it, one near it that they hold less deep: beside the
    /// crease where they meet.
    fn uncovered(&self, q: Vec3) -> Vec3 {
        (0..MOST_PROJECTIONS).fold(q, |q, _| self.near.deepest(q).map_or(q, |n| n.point))
    }

    /// The point at distance |r| from the mesh on the line from the nearest mesh point through p, if p is near it.
    ///
    /// Close to the mesh, where that line has no certain direction, the facet there tells it, and the point counts if no other is nearer.
    pub(super) fn project(&self, p: Vec3) -> Option<Vec3> {
        let (n, h) = (self.near.nearest(p)?, self.near.h());
        if (n.distance - self.r.abs()).abs() >= BESIDE * h {
            return None;
        }
        if self.r == 0.0 {
            return Some(self.uncovered(n.point));
        }
        let on_ray = || along(n.point, sub(p, n.point), self.r.abs() / distance(p, n.point));
        if n.distance > 0.5 * h {
            return Some(on_ray());
        }
        let found = match self.height(p, &n) {
            Some((height, facing)) => along(p, facing, self.r - height),
            None if dot(sub(p, n.point), self.near.facing(&n)) * self.r > 0.0 => on_ray(),
            None => return None,
        };
        let apart = self.near.nearest(found)?.distance;
        ((apart - self.r.abs()).abs() < ON_LEVEL * h).then_some(found)
    }
}

/// The root in [0, 1] of the cubic with given values, of different signs, and slopes at 0 and 1; sought from `t`.
pub(super) fn root_of_cubic([a, b]: [f64; 2], [m, n]: [f64; 2], mut t: f64) -> f64 {
    let (square, cube) = (3.0 * (b - a) - 2.0 * m - n, 2.0 * (a - b) + m + n);
    for _ in 0..3 {
        let value = a + t * (m + t * (square + t * cube));
        t = (t - value / (m + t * (2.0 * square + t * 3.0 * cube))).clamp(0.0, 1.0);
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_of_a_cubic_is_found_from_the_linear_one() {
        // s = √(1 + x²) − c along a line past a ball's centre, and the plain line.
        let (f, slope) = (|x: f64| (1.0 + x * x).sqrt() - 1.1, |x: f64| x / (1.0 + x * x).sqrt());
        let (from, to) = (0.3, 0.6);
        let (a, b) = (f(from), f(to));
        let ends = [from, to].map(|x| (to - from) * slope(x));
        let x = from + (to - from) * root_of_cubic([a, b], ends, a / (a - b));
        assert!(f(x).abs() < 2e-5, "{}", f(x));
        assert_eq!(root_of_cubic([-1.0, 3.0], [4.0, 4.0], 0.25), 0.25);
    }
}
