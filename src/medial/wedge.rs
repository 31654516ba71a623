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
/// Balls from a sheet outwards, at most: each step is half the way to where its sides would meet, or half the step before.
const DESCENT: usize = 200;
/// A ball so much smaller than the first lies where the sides meet.
const MET: f64 = 0.02;
/// The least step of a descent, and the least by which its ball has to shrink, as shares of the ball's radius.
const SHRINKS: f64 = 1e-3;
/// Where a sheet ends, the surface lies before its last ball within so many radii.
const BEFORE: f64 = 3.0;

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

/// Whether the balls of a sheet come to no edge, no rim and no diameter below `from`, if one goes from a place where it thins most.
///
/// The balls that touch both sides shrink along u + v, with the unit vectors u, v from a centre to where its ball touches. At an edge they
/// shrink to nothing, at a rim that joins the sides they are stopped by it; over the thinnest place of a skin between two rooms they grow
/// again, and there is more of it beyond. From where the sides are parallel one goes nowhere.
///
/// # Cost
/// At most 200 balls; six where the sides are flat.
pub fn stays(surface: &MeshDistance, centre: Vec3, diameter: f64, from: f64) -> bool {
    let within = 2.0 * diameter;
    let Some(mut last) = Ball::about(surface, centre, within) else { return false };
    let (least, mut share) = ((MET * last.radius).max(0.5 * from), 0.5);
    for _ in 0..DESCENT {
        if last.radius < least {
            return false;
        }
        if last.growth <= SHRINKS {
            return true;
        }
        let way = scale(last.onward, -1.0);
        let far = last.radius / last.growth;
        let free = surface.first_hit(last.centre, way, 0.0, far).map_or(far, |(s, _)| s);
        let step = share * free;
        if step < SHRINKS * last.radius {
            break;
        }
        match Ball::about(surface, along(last.centre, way, step), within) {
            None => return false,
            Some(next) if next.radius < (1.0 - SHRINKS) * last.radius => (last, share) = (next, 0.5),
            Some(_) => share *= 0.5,
        }
    }
    surface.first_hit(last.centre, scale(last.onward, -1.0), 0.0, BEFORE * last.radius).is_none()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::extruded;

    /// A plate 10 mm wide and 0.2 mm thick at its left end, over a groove of which the sides lean by 30° up to a skin of `skin`; its
    /// right end tapers from 0.2 mm to `rim`.
    fn plate(skin: f64, rim: f64) -> MeshDistance {
        let run = (0.2 - skin) * 3f64.sqrt();
        let under = [[0.0, 0.0], [3.0 - run, 0.0], [3.0, 0.2 - skin], [3.0 + run, 0.0], [7.0, 0.0], [10.0, 0.2 - rim]];
        let mut outline = under.to_vec();
        outline.extend([[10.0, 0.2], [7.0, 0.2], [3.0 + run, 0.2], [3.0, 0.2], [3.0 - run, 0.2], [0.0, 0.2]]);
        let caps: Vec<[usize; 3]> = (0..5).flat_map(|n| [[n, n + 1, 10 - n], [n, 10 - n, 11 - n]]).collect();
        MeshDistance::new(&extruded(&outline, &caps, 4.0))
    }

    #[test]
    fn a_wedge_leads_to_an_edge_and_a_groove_does_not() {
        for (skin, rim) in [(0.05, 0.01), (0.01, 0.05), (0.002, 0.002)] {
            let plate = plate(skin, rim);
            let stays = |x: f64, thick: f64, from: f64| stays(&plate, [x, 2.0, 0.2 - 0.5 * thick], thick, from);
            // Over the groove, at its deepest place and on both sides, and along the taper.
            for aside in [0.0, 0.01, 0.05] {
                let thick = skin + aside / 3f64.sqrt();
                for x in [3.0 + aside, 3.0 - aside] {
                    assert!(stays(x, thick, 0.98 * skin) && !stays(x, thick, 1.02 * skin), "{skin}, {x}");
                }
            }
            for x in [8.0, 9.0, 9.9] {
                assert!(!stays(x, 0.2 - (0.2 - rim) * (x - 7.0) / 3.0, 0.0), "{rim}: {x}");
            }
        }
    }
}
