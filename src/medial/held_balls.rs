//! Whether what balls hold hangs together: whether others pass between those that hold places beside each other.

use super::inscribed::{Region, grown};
use crate::geometry::MeshDistance;
use crate::geometry::vector::{Vec3, along, distance, sub, unit};
use std::collections::BTreeSet;

/// A ball passes in steps of no less than this share of its radius.
const LEAST: f64 = 0.002;
/// It strides past what is in the way so many times, by shares of its radius, and is pushed off by steps from this share of it down.
const STRIDES: usize = 32;
const SHORTER: [f64; 3] = [0.3, 0.1, 0.03];
const STEP: f64 = 0.1;
/// Balls that are joined by a way over others are joined beside each other: within so many radii.
const BESIDE: f64 = 4.0;
/// Places that are looked at.
const MANY: usize = 1 << 16;

/// A middle and the distance to the surface there.
pub(super) type Ball = (Vec3, f64);

/// Places, and the balls that hold them.
#[derive(Debug, Default)]
pub(super) struct HeldBalls {
    balls: Vec<Ball>,
    /// Boxes with the axes of the frame, each with the ball that holds it.
    places: Vec<(Region, usize)>,
    /// The balls that each is joined with.
    joined: Vec<Vec<usize>>,
}

impl HeldBalls {
    /// Adds a ball, and returns its number.
    pub fn add(&mut self, ball: Ball) -> usize {
        self.balls.push(ball);
        self.joined.push(Vec::new());
        self.balls.len() - 1
    }

    /// A place that a ball holds.
    pub fn hold(&mut self, place: Region, ball: usize) {
        self.places.push((place, ball));
    }

    /// Whether balls of a radius pass between all that hold places which touch, straight or over others beside them.
    ///
    /// Two sides of a neck touch in it, and are held by two balls; what passes elsewhere, as around a ring, is no way through it.
    ///
    /// # Cost
    /// Nearest points between the middles of two, as close to each other as the distances there exceed the radius. Near ones are tried first, and
    /// those that a way joins are not tried.
    pub fn hang_together(&mut self, surface: &MeshDistance, radius: f64) -> bool {
        if self.places.len() > MANY {
            return false;
        }
        let mut pairs = self.touching();
        pairs.sort_by(|a, b| self.apart(*a).total_cmp(&self.apart(*b)).then(a.cmp(b)));
        let mut parted = Vec::new();
        for (a, b) in pairs {
            if self.has_way(a, b, radius) {
                continue;
            }
            let ends = self.balls.get(a).zip(self.balls.get(b));
            if ends.is_some_and(|(p, q)| passes(surface, *p, *q, radius)) {
                self.join(a, b);
            } else {
                parted.push((a, b));
            }
        }
        parted.into_iter().all(|(a, b)| self.has_way(a, b, radius) || self.has_detour(a, b, (surface, radius)))
    }

    /// Whether a ball gets from one to another past what is in the way, and joins them if it does.
    fn has_detour(&mut self, a: usize, b: usize, (surface, radius): (&MeshDistance, f64)) -> bool {
        let Some((p, q)) = self.balls.get(a).copied().zip(self.balls.get(b).copied()) else { return false };
        let gets_there = strides(surface, p, q, radius) || strides(surface, q, p, radius);
        if gets_there {
            self.join(a, b);
        }
        gets_there
    }

    fn apart(&self, (a, b): (usize, usize)) -> f64 {
        self.balls.get(a).zip(self.balls.get(b)).map_or(f64::INFINITY, |(p, q)| distance(p.0, q.0))
    }

    fn join(&mut self, a: usize, b: usize) {
        for (from, to) in [(a, b), (b, a)] {
            if let Some(joined) = self.joined.get_mut(from) {
                joined.push(to);
            }
        }
    }

    /// The pairs of balls that hold places which touch.
    fn touching(&self) -> Vec<(usize, usize)> {
        let end = |r: &Region, axis: usize, sign: f64| r.centre[axis] + sign * r.half[axis];
        let span = |axis: usize| {
            let low = self.places.iter().map(|p| end(&p.0, axis, -1.0)).fold(f64::INFINITY, f64::min);
            self.places.iter().map(|p| end(&p.0, axis, 1.0)).fold(f64::NEG_INFINITY, f64::max) - low
        };
        let along = (0..3).max_by(|&a, &b| span(a).total_cmp(&span(b))).unwrap_or(0);
        let mut places: Vec<&(Region, usize)> = self.places.iter().collect();
        places.sort_by(|a, b| end(&a.0, along, -1.0).total_cmp(&end(&b.0, along, -1.0)));
        let mut pairs = BTreeSet::new();
        for (i, (region, ball)) in places.iter().enumerate() {
            // Halves of halves: their faces agree but for rounding.
            let slack = 1e-9 * region.half[along] + f64::EPSILON * end(region, along, 1.0).abs();
            let near =
                places.iter().skip(i + 1).take_while(|p| end(&p.0, along, -1.0) <= end(region, along, 1.0) + slack);
            let touches = |r: &Region| {
                (0..3).all(|x| (r.centre[x] - region.centre[x]).abs() <= (r.half[x] + region.half[x]) * (1.0 + 1e-9))
            };
            for (_, other) in near.filter(|p| p.1 != *ball && touches(&p.0)) {
                pairs.insert((*ball.min(other), *ball.max(other)));
            }
        }
        pairs.into_iter().collect()
    }

    /// Whether joined balls lead from one to another, all beside the first.
    fn has_way(&self, from: usize, to: usize, radius: f64) -> bool {
        let mut met = BTreeSet::from([from]);
        let mut open = vec![from];
        while let Some(at) = open.pop() {
            if at == to {
                return true;
            }
            for &next in self.joined.get(at).into_iter().flatten() {
                if self.apart((from, next)) <= BESIDE * radius && met.insert(next) {
                    open.push(next);
                }
            }
        }
        false
    }
}

/// Whether a ball of a radius passes straight between the middles of two: the distance to the surface changes by no more than the way.
fn passes(surface: &MeshDistance, a: Ball, b: Ball, radius: f64) -> bool {
    let far = distance(a.0, b.0);
    if 0.5 * (a.1 + b.1 - far) >= radius {
        return true;
    }
    if far <= LEAST * radius {
        return false;
    }
    let middle = [0, 1, 2].map(|x| 0.5 * (a.0[x] + b.0[x]));
    let clear = surface.nearest(middle, f64::INFINITY).map_or(0.0, |n| n.distance);
    clear >= radius && passes(surface, a, (middle, clear), radius) && passes(surface, (middle, clear), b, radius)
}

/// Whether a ball of a radius that strides from the middle of one to that of another gets there, pushed off from what is in the way.
fn strides(surface: &MeshDistance, from: Ball, to: Ball, radius: f64) -> bool {
    // Pushed off a little farther than it has to be: it would pass nothing else.
    let enough = 0.5 * (radius + from.1.min(to.1));
    let stride = |at: Ball, long: f64| {
        let far = distance(at.0, to.0);
        let next = along(at.0, unit(sub(to.0, at.0)), long.min(far));
        let clear = surface.nearest(next, f64::INFINITY)?.distance;
        let next = grown(surface, (next, -radius), (next, clear), (STEP * radius, enough));
        let is_nearer = next.1 >= radius && distance(next.0, to.0) < far;
        (is_nearer && passes(surface, at, next, radius)).then_some(next)
    };
    let mut at = from;
    for _ in 0..STRIDES {
        if passes(surface, at, to, radius) {
            return true;
        }
        let Some(next) = SHORTER.iter().find_map(|share| stride(at, share * radius)) else { return false };
        at = next;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    /// Two boxes of 2 mm, joined by a bar as wide as given: places on both sides of its middle, held by the balls in the boxes.
    fn over_a_bar(width: f64, radius: f64) -> bool {
        let half = 0.5 * width;
        let bar = cuboid([0.5, -half, -half], [3.5, half, half]);
        let ends = cuboid([-1.0; 3], [1.0; 3]).joined(&cuboid([3.0, -1.0, -1.0], [5.0, 1.0, 1.0]));
        let mesh = crate::geometry::union::united(&ends.joined(&bar), 1e-7).unwrap();
        let surface = MeshDistance::new(&mesh);
        let mut held = HeldBalls::default();
        for (lo, hi, at) in [(1.0, 2.0, [0.0; 3]), (2.0, 3.0, [4.0, 0.0, 0.0])] {
            let ball = held.add((at, surface.nearest(at, f64::INFINITY).unwrap().distance));
            held.hold(Region::between([lo, -half, -half], [hi, half, half]), ball);
        }
        held.hang_together(&surface, radius)
    }

    #[test]
    fn a_ball_passes_along_a_bar_that_is_as_wide_and_along_no_other() {
        assert!(over_a_bar(1.0, 0.49));
        assert!(!over_a_bar(1.0, 0.51));
        assert!(over_a_bar(0.6, 0.29));
        assert!(!over_a_bar(0.6, 0.31));
    }

    /// A square frame of bars of 1 mm, one of them 0.6 mm: balls pass the other way round.
    #[test]
    fn a_way_round_a_ring_is_no_way_through_its_neck() {
        let bars = [
            cuboid([0.0, 0.0, 0.0], [1.0, 4.0, 1.0]),
            cuboid([3.0, 0.0, 0.0], [4.0, 4.0, 1.0]),
            cuboid([0.5, 3.0, 0.0], [3.5, 4.0, 1.0]),
            cuboid([0.5, 0.2, 0.2], [3.5, 0.8, 0.8]),
        ];
        let frame = bars.into_iter().reduce(|a, b| a.joined(&b)).unwrap();
        let surface = MeshDistance::new(&crate::geometry::union::united(&frame, 1e-7).unwrap());
        let ring = [[0.5, 0.5], [0.5, 2.0], [0.5, 3.5], [2.0, 3.5], [3.5, 3.5], [3.5, 2.0], [3.5, 0.5]];
        let hangs = |radius: f64| {
            let mut held = HeldBalls::default();
            for (i, [x, y]) in ring.into_iter().enumerate() {
                let at = [x, y, 0.5];
                let ball = held.add((at, surface.nearest(at, f64::INFINITY).unwrap().distance));
                // Those at the corners touch the next ones, the first and the last each other in the thin bar.
                let (from, to) = match i {
                    0 => ([-0.8, -0.8], [1.5, 0.8]),
                    6 => ([-1.5, -0.8], [0.8, 0.8]),
                    2 | 4 => ([-0.8; 2], [0.8; 2]),
                    _ => ([-0.72; 2], [0.72; 2]),
                };
                held.hold(Region::between([x + from[0], y + from[1], 0.0], [x + to[0], y + to[1], 1.0]), ball);
            }
            assert!(held.touching().contains(&(0, 6)));
            held.hang_together(&surface, radius)
        };
        assert!(hangs(0.29));
        assert!(!hangs(0.31));
    }
}
