//! How far in from a sharp edge the material is thinner than asked: along the medial axis.

use crate::geometry::distance::{MeshDistance, TouchingBall};
use crate::geometry::vector::{Vec3, add, along, distance, dot, norm, scale, sub, unit};

/// Balls from an edge inwards, at most.
const STEPS: usize = 2000;
/// The first of them, as a share of the thickness asked for.
const FIRST_STEP: f64 = 0.05;
/// Wedges sharper than 0.5 degrees are followed as if they were not.
const LEAST_SINE: f64 = 0.0044;
/// A first ball this much smaller than the wedge's own was stopped by something else.
const ENDED: f64 = 0.9;
/// Sides further from parallel than 4 degrees are a wedge's: its balls grow by the sine of half of that, for each step inwards.
const GROWS: f64 = 0.0349;
/// The surface may intrude into a ball by this share of its radius.
const AGREE: f64 = 1e-9;
/// Halvings of the step in which a wedge becomes as thick as asked, or ends.
const HALVINGS: usize = 30;

/// An edge and the wedge of material behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wedge {
    /// A point of the edge.
    pub edge: Vec3,
    /// Unit vector from there into the material, between the sides.
    pub inward: Vec3,
    /// Angle between the sides at the edge, radians.
    pub angle: f64,
}

impl Wedge {
    /// The distance from the edge at which the material is as thick as asked or the wedge ends, and its thickness there.
    ///
    /// Thickness is the diameter of the largest balls that touch both sides, whose centres are the medial axis that runs out to the edge. With
    /// unit vectors u, v from a centre to where its ball touches, the balls grow most along −(u + v), by |u + v| / 2 for each step, and that
    /// way is gone: straight in, and at the end of an edge away from what ends it. A wedge ends where the way turns back, for the ball meets
    /// something before it, or where it is less than that of sides 4° from parallel, and than that of the edge. Sides may curve away from or
    /// towards each other.
    ///
    /// # Cost
    /// A ball takes a nearest point and a walk over what it holds as it shrinks; a wedge of angle φ that becomes as thick as asked has
    /// ln(10 / sin(φ/2)) / sin(φ/2) of them, and 30 more. No step is longer than the ball's radius, so that no surface is crossed unseen.
    pub fn thinner_than(&self, surface: &MeshDistance, thick: f64) -> (f64, f64) {
        let sine = (0.5 * self.angle).sin().max(LEAST_SINE);
        let growth = GROWS.min(ENDED * sine);
        let start = along(self.edge, self.inward, FIRST_STEP * thick);
        let free = surface.nearest(start, thick).map_or(thick, |n| n.distance);
        // Before the first ball nothing says that there is a wedge.
        if free < ENDED * FIRST_STEP * thick * sine {
            return (0.0, 0.0);
        }
        let goes_on = |last: &Ball, next: &Ball| {
            next.radius >= last.radius && next.growth >= growth && dot(next.onward, last.onward) > 0.0
        };
        let edge = Ball { centre: self.edge, radius: 0.0, onward: self.inward, growth: sine };
        let (mut last, mut p) = (edge, start);
        let mut past = Ball::about(surface, p, thick);
        for _ in 0..STEPS {
            let Some(next) = past.filter(|b| 2.0 * b.radius < thick && goes_on(&last, b)) else { break };
            p = along(next.centre, next.onward, next.radius);
            last = next;
            past = Ball::about(surface, p, thick);
        }
        // In which step it becomes thick or ends is known; where is not.
        let mut thin = last;
        let from = last.centre;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let share = 0.5 * (low + high);
            let ball = Ball::about(surface, along(from, sub(p, from), share), thick);
            match ball.filter(|b| 2.0 * b.radius < thick && goes_on(&last, b)) {
                Some(ball) => (low, thin) = (share, ball),
                None => (high, past) = (share, ball),
            }
        }
        match past.filter(|b| 2.0 * b.radius >= thick) {
            Some(reached) => (distance(self.edge, reached.centre), thick),
            None => (distance(self.edge, thin.centre), 2.0 * thin.radius),
        }
    }
}

/// A ball within the material that cannot grow, with what its contacts tell.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ball {
    centre: Vec3,
    radius: f64,
    /// Unit vector along which it would grow, and by how much for each step.
    onward: Vec3,
    growth: f64,
}

impl Ball {
    /// The largest ball that touches the surface where that is nearest to a point, on its side, or one of radius `within`; `None` for a point on
    /// the surface.
    fn about(surface: &MeshDistance, p: Vec3, within: f64) -> Option<Ball> {
        let large = |centre, onward| Ball { centre, radius: within, onward, growth: 1.0 };
        let Some(near) = surface.nearest(p, within) else { return Some(large(p, [0.0; 3])) };
        let away = unit(sub(p, near.point));
        if away == [0.0; 3] {
            return None;
        }
        let TouchingBall { centre, radius, stop, .. } =
            surface.touching_ball(near.point, away, within, AGREE * near.distance);
        let Some(stop) = stop else { return Some(large(centre, away)) };
        let [u, v] = [near.point, stop.point].map(|q| unit(sub(q, centre)));
        let back = add(u, v);
        Some(Ball { centre, radius, onward: unit(scale(back, -1.0)), growth: 0.5 * norm(back) })
    }
}
