//! How far points are from what a body covers on its way: the least of the signed distances to the body over all poses.
//!
//! Each is a function of the way gone, which changes by at most a millimetre per millimetre. It is looked at a spacing apart where the body
//! is near, and where it stands above the least found so far by d, d millimetres further on; distances on a lattice of the body's own do
//! for that. Where they fall and then rise, the least is sought by exact distances and their slopes.

use super::motion::reach_of;
use super::offset::Measured;
use super::rough::Rough;
use crate::error::Result;
use crate::geometry::vector::{Vec3, add, dot, norm, scale, sub};
use crate::geometry::{Leg, MeshDistance, TriangleMesh, Waypoint};
use crate::units::Length;

/// Distances farther from zero than this, in spacings, are not told apart.
pub(super) const REACH: f64 = 1.05;

/// How far apart the way is looked at where the body is near, in spacings.
const STRIDE: f64 = 1.0;

/// Between two looks, and between samples of the body's lattice, the distance may be less by so many spacings.
const DIP: f64 = 0.4;

/// What the looks fall and rise by less than, in spacings, is what bends between samples of that lattice.
const RIPPLE: f64 = 0.1;

/// A distance that changes by no more than this per millimetre that the body goes, is as good as least.
const FLAT: f64 = 0.02;

/// What a further look at the way may not better by this, in spacings, is as good as least.
const FINE: f64 = 0.002;

/// The way between two looks is looked at by so many more at most, and so many strides are taken to where the distance rises again.
const MOST_LOOKS: usize = 8;
const MOST_STRIDES: usize = 4;

/// Where the body turns the distance from falling to rising its slopes across the way cancel out all but this, at least.
const LEAST_STEEP: f64 = 0.2;

/// A body on its way.
pub(super) struct Moving {
    body: MeshDistance,
    rough: Rough,
    legs: Vec<Leg>,
    /// Where each leg starts, and where the last one ends: millimetres that no point of the body has gone more of.
    starts: Vec<f64>,
    /// Poses a stride apart at most.
    poses: Vec<Pose>,
    h: f64,
}

/// A place on the way, and the body's rotation and origin there.
struct Pose {
    at: f64,
    rows: [Vec3; 3],
    origin: Vec3,
}

/// A body as a point sees it from one place on the way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    /// The signed distance to it, negative inside.
    pub(super) value: f64,
    /// What the least distance over all places changes by per millimetre: outwards.
    pub(super) gradient: Vec3,
    /// How far it has gone.
    pub(super) at: f64,
    /// What the distance changes by per millimetre of way.
    slope: f64,
    /// How fast the body goes where the point is, per millimetre of way.
    speed: f64,
}

impl Sight {
    /// Whether the distance is as good as least here.
    fn is_flat(&self) -> bool {
        self.slope.abs() <= FLAT * self.speed
    }

    /// How far the surface is, negative inside, and the outward unit normal there, as far as both are seen from here.
    pub(super) fn off(&self) -> (f64, Vec3) {
        let steep = norm(self.gradient);
        if steep > 0.0 { (self.value / steep, scale(self.gradient, 1.0 / steep)) } else { (self.value, self.gradient) }
    }
}

impl Moving {
    /// A mesh that bounds a solid, on its way along waypoints.
    ///
    /// # Errors
    /// As [`Measured::around`].
    ///
    /// # Cost
    /// A cast of the mesh and as [`Rough::of`], and a pose for each spacing of the way.
    pub(super) fn new(mesh: &TriangleMesh, waypoints: &[Waypoint], spacing: Length) -> Result<Self> {
        let (reach, h) = (reach_of(mesh), spacing.as_mm());
        let legs: Vec<Leg> = waypoints.windows(2).map(|pair| Leg::new(pair[0], &pair[1])).collect();
        let (mut starts, mut poses) = (vec![0.0], Vec::new());
        for leg in &legs {
            // A leg on which nothing moves has a place of its own, too.
            let (start, way) = (starts.last().copied().unwrap_or_default(), leg.longest(reach).max(1e-9 * h));
            let steps = (way / (STRIDE * h)).ceil();
            poses.extend((0..=steps as u32).map(|step| {
                let share = f64::from(step) / steps;
                let pose = leg.at(share);
                Pose { at: start + share * way, rows: pose.rotation(), origin: pose.at_mm }
            }));
            starts.push(start + way);
        }
        let measured = Measured::around(mesh, Length::mm(0.0), spacing)?;
        let rough = Rough::of(&measured)?;
        Ok(Moving { body: measured.of.exact, rough, legs, starts, poses, h })
    }

    /// The body where it is nearest to a point, or where the point lies deepest in it, if that is nearer than [`REACH`]; any place where it
    /// lies deeper than that. `hint` is a place on the way where the body may be near.
    ///
    /// # Cost
    /// A look at the body's lattice for each spacing of the way on which the body stays about as near, and for each millimetre that it is
    /// farther away one for each millimetre of way; some four distances for each time that the body comes near.
    pub(super) fn least(&self, x: Vec3, hint: Option<f64>) -> Option<Sight> {
        let reach = REACH * self.h;
        let mut best = hint.map(|at| self.near(x, at));
        let least = |best: &Option<Sight>| best.map_or(reach, |b| b.value.min(reach));
        // The lowest look since the distance began to fall, or the highest since it began to rise.
        let (mut turn, mut falling) = ((0.0, f64::INFINITY), true);
        let mut number = 0;
        while let Some(pose) = self.poses.get(number) {
            let seen = self.rough.seen(pose.place_of(x));
            let lowest = seen.value - seen.off;
            let back = if falling { lowest - turn.1 } else { turn.1 - lowest };
            if back > RIPPLE * self.h {
                if falling {
                    self.consider(x, turn, &mut best);
                }
                falling = !falling;
            }
            if back < 0.0 || back > RIPPLE * self.h {
                turn = (pose.at, lowest);
            }
            if least(&best) < -reach {
                return best;
            }
            number += 1 + ((lowest - least(&best)).max(0.0) / (STRIDE * self.h)) as usize;
        }
        if falling {
            self.consider(x, turn, &mut best);
        }
        best.filter(|best| best.value < reach)
    }

    /// Looks exactly near a place on the way where the body seemed so near, if it may be nearer there.
    fn consider(&self, x: Vec3, (at, value): (f64, f64), best: &mut Option<Sight>) {
        let known = best.is_some_and(|best| (best.at - at).abs() < STRIDE * self.h);
        if known || value - DIP * self.h >= best.map_or(REACH * self.h, |best| best.value) {
            return;
        }
        let found = self.near(x, at);
        if best.is_none_or(|best| found.value < best.value) {
            *best = Some(found);
        }
    }

    /// The body where the distance to a point is least near a place on the way.
    ///
    /// # Cost
    /// Some four distances; one where the distance does not change.
    pub(super) fn near(&self, x: Vec3, at: f64) -> Sight {
        let mut last = self.seen(x, at);
        let way = -last.slope.signum();
        let mut stride = STRIDE * self.h / last.speed.max(1e-3);
        for _ in 0..MOST_STRIDES {
            let at = (last.at + way * stride).clamp(0.0, self.length());
            if last.is_flat() || at == last.at {
                break;
            }
            let next = self.seen(x, at);
            if next.slope * way > 0.0 {
                return if way > 0.0 { self.between(x, last, next) } else { self.between(x, next, last) };
            }
            // Higher, but falling: a stride over a valley.
            (last, stride) = if next.value > last.value { (last, 0.25 * stride) } else { (next, 2.0 * stride) };
        }
        last
    }

    /// The least distance between two places on the way where it falls after the first and rises before the second.
    ///
    /// In turn where the tangents at both meet, which is where planes change, and where the slope would vanish, which is where it changes
    /// evenly. Where it falls on one side of the least and rises on the other, the surface there is one that no facet has: an edge goes
    /// along it, and its gradient is between those on both sides, without a slope along the way.
    fn between(&self, x: Vec3, mut before: Sight, mut after: Sight) -> Sight {
        let nearer = |a: Sight, b: Sight| if b.value < a.value { b } else { a };
        let mut best = nearer(before, after);
        for round in 0..MOST_LOOKS {
            let (falling, rising, apart) = (before.slope, after.slope, after.at - before.at);
            let meeting = (after.value - before.value - rising * apart) / (falling - rising);
            let bound = (before.value + falling * meeting).max(0.5 * (before.value + after.value - apart));
            if bound > best.value - FINE * self.h || best.is_flat() {
                break;
            }
            let level = -falling * apart / (rising - falling);
            let place = if round.is_multiple_of(2) { meeting } else { level };
            let found = self.seen(x, before.at + place.clamp(0.02 * apart, 0.98 * apart));
            best = nearer(best, found);
            if found.slope > 0.0 { after = found } else { before = found }
        }
        let share = after.slope / (after.slope - before.slope);
        let mixed = add(scale(before.gradient, share), scale(after.gradient, 1.0 - share));
        let steep = norm(mixed) > LEAST_STEEP && !best.is_flat();
        if steep { Sight { gradient: mixed, slope: 0.0, ..best } } else { best }
    }

    /// The body from a place on the way.
    fn seen(&self, x: Vec3, at: f64) -> Sight {
        let number = self.starts.partition_point(|&start| start <= at).clamp(1, self.legs.len()) - 1;
        let (leg, start, way) =
            (&self.legs[number], self.starts[number], self.starts[number + 1] - self.starts[number]);
        let pose = leg.at(((at - start) / way).clamp(0.0, 1.0));
        let pose = Pose { at, rows: pose.rotation(), origin: pose.at_mm };
        let y = pose.place_of(x);
        let Some(nearest) = self.body.nearest(y, f64::INFINITY) else {
            return Sight { value: f64::INFINITY, gradient: [0.0; 3], at, slope: 0.0, speed: 0.0 };
        };
        let (off, facing) = (sub(y, nearest.point), self.body.normal(nearest.facet));
        let height = dot(off, facing);
        let over = height.abs() >= 0.99 * nearest.distance;
        let inside = if over { height < 0.0 } else { self.body.is_behind(y, &nearest) };
        let value = if inside { -nearest.distance } else { nearest.distance };
        // On the surface rounding alone tells the direction.
        let own = if nearest.distance > 1e-6 * self.h { scale(off, 1.0 / value) } else { facing };
        let gradient = pose.rows.map(|row| dot(row, own));
        let velocity = scale(leg.velocity(sub(x, pose.origin)), 1.0 / way);
        Sight { value, gradient, at, slope: -dot(gradient, velocity), speed: norm(velocity) }
    }

    fn length(&self) -> f64 {
        self.starts.last().copied().unwrap_or_default()
    }
}

impl Pose {
    /// Which point of the body is at a place.
    fn place_of(&self, x: Vec3) -> Vec3 {
        let ([a, b, c], [x, y, z]) = (self.rows, sub(x, self.origin));
        [a[0] * x + b[0] * y + c[0] * z, a[1] * x + b[1] * y + c[1] * z, a[2] * x + b[2] * y + c[2] * z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::random::Lcg;

    #[test]
    fn the_least_distance_is_that_of_many_poses() {
        let (h, bar) = (0.3, cuboid([1.0, -0.5, -0.7], [6.0, 0.5, 0.7]));
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let way = [
            Waypoint { at_mm: [0.0; 3], turn: [1.0, 0.0, 0.0, 0.0] },
            Waypoint { at_mm: [3.0, 0.0, 1.0], turn: [half, 0.0, 0.0, half] },
            Waypoint { at_mm: [3.0, 4.0, 1.0], turn: [half, half, 0.0, 0.0] },
        ];
        let moving = Moving::new(&bar, &way, Length::mm(h)).unwrap();
        let places = (0..=20_000).map(|n| moving.length() * f64::from(n) / 20_000.0);
        let poses: Vec<Waypoint> = places
            .map(|at| {
                let number = moving.starts.partition_point(|&start| start <= at).clamp(1, 2) - 1;
                moving.legs[number]
                    .at((at - moving.starts[number]) / (moving.starts[number + 1] - moving.starts[number]))
            })
            .collect();
        let in_box = |y: Vec3| {
            let beyond = [1.0 - y[0], y[0] - 6.0, y[1].abs() - 0.5, y[2].abs() - 0.7];
            let out = norm([beyond[0].max(beyond[1]).max(0.0), beyond[2].max(0.0), beyond[3].max(0.0)]);
            if out > 0.0 { out } else { beyond.into_iter().fold(f64::MIN, f64::max) }
        };
        let (mut random, mut near, mut off, mut worst) = (Lcg(5), 0, 0, 0.0f64);
        for n in 0..3000 {
            let x = random.point(-2.0, 8.0);
            let truth = poses.iter().map(|pose| in_box(pose.place_of(x))).fold(f64::INFINITY, f64::min);
            let found = moving.least(x, (n % 2 == 0).then(|| moving.length() * random.unit()));
            match found {
                None => assert!(truth > 0.99 * REACH * h, "{x:?}: {truth}"),
                Some(found) if truth.abs() < REACH * h => {
                    near += 1;
                    off += usize::from((found.value - truth).abs() > 0.02 * h);
                    worst = worst.max(found.value - truth);
                    assert!(found.value > truth - 0.01 * h, "{x:?}: {} {truth}", found.value);
                }
                Some(found) => assert!(found.value < 0.0 && truth < 0.0),
            }
        }
        // Of valleys near each other the deeper one may be missed.
        assert!(near > 200 && 10 * off < near && worst < 0.25 * h, "{off} of {near}, {worst}");
    }
}
