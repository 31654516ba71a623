//! Wedges along the medial axis: from a sharp edge inwards to where the material is as thick as asked, and from a ball out to where its sheet ends.

use crate::geometry::distance::{MeshDistance, TouchingBall};
use crate::geometry::vector::{Vec3, add, along, cross, distance, dot, norm, scale, sub, unit};

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
/// Balls from a sheet outwards, at most: each step is this share of the way to where its sides would meet, or half the step before.
const DESCENT: usize = 200;
const STRIDE: f64 = 0.5;
/// A ball so much smaller than the first lies where the sides meet.
const MET: f64 = 0.02;
/// The least step of a descent, and the least by which its ball has to shrink, as shares of the ball's radius.
const SHRINKS: f64 = 1e-3;
/// Sides further from parallel than 30 degrees are no wall's.
const LEANS: f64 = 0.2589;
/// Of sides that turn towards each other those of a wedge lean by up to so many times as much from one ball to the next, and by up to 60 degrees.
const TURNS: f64 = 1.3;
const SHARP: f64 = 0.5;
/// Ways within a sheet, from where it thins most, that are tried where the end of an edge is in the way, degrees.
const ASIDE: [f64; 4] = [45.0, -45.0, 75.0, -75.0];
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
        let edge = Ball { centre: self.edge, radius: 0.0, onward: self.inward, growth: sine, aside: [0.0; 3] };
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
    let Some(first) = Ball::about(surface, centre, 2.0 * diameter) else { return false };
    let least = (MET * first.radius).max(0.5 * from);
    match descend(surface, first, least, (&[], |_, _| true)) {
        (_, End::Level) => true,
        (last, End::Least) => last.goes_on(surface),
        (_, End::Met) => false,
    }
}

/// Whether a ball of a sheet lies in a wedge that runs out to an edge, or to a face no wider than `blunt`.
///
/// One goes from it to where the sheet thins most, as for [`stays`], and aside where the end of an edge is in the way. All the way the sides
/// have to lean towards each other: by up to 30°, as a wall's may, or by up to 60° where they turn gradually; and by as much as those of a
/// wedge that `Wedge::thinner_than` follows inwards, so that each ball belongs to the edge or to the sheet behind its wedge. What leans by
/// less is a sheet that ends in a wedge, and what is stopped by a wider face a wall as thick as that. A ball whose own sides lean by more than
/// 30° is no sheet's: it has run out if it is itself no wider than `blunt` and leads nowhere else.
///
/// # Cost
/// That of [`stays`], and four balls more for each whose way straight on is barred; one ball where the sides are parallel.
pub fn runs_out(surface: &MeshDistance, centre: Vec3, diameter: f64, blunt: f64) -> bool {
    let Some(first) = Ball::about(surface, centre, 2.0 * diameter).filter(|b| b.growth <= LEANS) else {
        return diameter <= blunt && !stays(surface, centre, diameter, 0.0);
    };
    let mut least = first.growth;
    let leans = |last: &Ball, next: &Ball| {
        let most = LEANS.max(TURNS * last.growth).min(SHARP);
        least = if next.growth <= most { least.min(next.growth) } else { least };
        next.growth <= most
    };
    let (last, end) = descend(surface, first, MET * first.radius, (&ASIDE, leans));
    match end {
        End::Met => least >= GROWS.min(ENDED * last.growth),
        End::Level => false,
        End::Least => {
            // A ball that touches both sides and a face between them is wider than that.
            let face = 2.0 * last.radius * ((1.0 - last.growth) / (1.0 + last.growth)).sqrt();
            face <= blunt && least >= GROWS && !last.goes_on(surface)
        }
    }
}

/// How a descent ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// At a ball smaller than asked for: the sides meet.
    Met,
    /// Where the sides are parallel.
    Level,
    /// At a ball from which none that may be met is smaller.
    Least,
}

/// The last ball of those that touch both sides, from a first on to where they shrink most, until one is smaller than `least`, or none is
/// smaller. Where the first step that way leads to none that may be met, those at some angles to it within the sheet are tried, degrees.
fn descend(
    surface: &MeshDistance,
    first: Ball,
    least: f64,
    (aside, mut may_be_met): (&[f64], impl FnMut(&Ball, &Ball) -> bool),
) -> (Ball, End) {
    let (mut last, mut share) = (first, STRIDE);
    for _ in 0..DESCENT {
        if last.radius < least {
            return (last, End::Met);
        }
        if last.growth <= SHRINKS {
            return (last, End::Level);
        }
        let mut smaller = |angle: f64, share: f64| match last.a_step(surface, angle, share) {
            None => Step::TooShort,
            Some(p) => match Ball::about(surface, p, last.radius) {
                None => Step::Surface,
                Some(b) if b.radius < (1.0 - SHRINKS) * last.radius && may_be_met(&last, &b) => Step::To(b),
                Some(_) => Step::Refused,
            },
        };
        let step = match smaller(0.0, share) {
            Step::Refused if share == STRIDE => {
                let mut turned = aside.iter().map(|&angle| smaller(angle, STRIDE));
                turned.find(|step| matches!(step, Step::To(_))).unwrap_or(Step::Refused)
            }
            step => step,
        };
        match step {
            Step::To(ball) => (last, share) = (ball, STRIDE),
            Step::Refused => share *= 0.5,
            Step::Surface => return (last, End::Met),
            Step::TooShort => break,
        }
    }
    (last, End::Least)
}

/// What a step of a descent leads to.
enum Step {
    To(Ball),
    /// A ball that is no smaller, or not to be met.
    Refused,
    /// A point of the surface.
    Surface,
    TooShort,
}

/// A ball within the material that cannot grow, with what its contacts tell.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ball {
    centre: Vec3,
    radius: f64,
    /// Unit vector along which it would grow, and by how much for each step.
    onward: Vec3,
    growth: f64,
    /// Unit vector at right angles to that within the sheet.
    aside: Vec3,
}

impl Ball {
    /// A share of the way to where the sides would meet, or to what lies before that, from where the sheet thins most turned by an angle within
    /// it, degrees; `None` if that is no step.
    fn a_step(&self, surface: &MeshDistance, angle: f64, share: f64) -> Option<Vec3> {
        let (sin, cos) = angle.to_radians().sin_cos();
        let way = add(scale(self.onward, -cos), scale(self.aside, sin));
        let far = self.radius / self.growth;
        let free = surface.first_hit(self.centre, way, 0.0, far).map_or(far, |(s, _)| s);
        let step = share * free;
        (step >= SHRINKS * self.radius).then(|| along(self.centre, way, step))
    }

    /// Whether there is more of a sheet beyond its thinnest ball: no surface within a few radii.
    fn goes_on(&self, surface: &MeshDistance) -> bool {
        surface.first_hit(self.centre, scale(self.onward, -1.0), 0.0, BEFORE * self.radius).is_none()
    }

    /// The largest ball that touches the surface where that is nearest to a point, on its side, or one of radius `within`; `None` for a point on
    /// the surface.
    fn about(surface: &MeshDistance, p: Vec3, within: f64) -> Option<Ball> {
        let large = |centre, onward| Ball { centre, radius: within, onward, growth: 1.0, aside: [0.0; 3] };
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
        let onward = unit(scale(back, -1.0));
        Some(Ball { centre, radius, onward, growth: 0.5 * norm(back), aside: unit(cross(onward, sub(u, v))) })
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

    /// A prism 6 mm long: a plate 0.8 mm thick behind a wedge of an angle, up to an edge or a face of some width.
    fn sharpened(degrees: f64, face: f64) -> MeshDistance {
        let run = 0.5 * (0.8 - face) / (0.5 * degrees).to_radians().tan();
        let half = 0.5 * face;
        let mut outline = vec![[0.0, -half], [run, -0.4], [run + 4.0, -0.4], [run + 4.0, 0.4], [run, 0.4]];
        let mut caps = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4]];
        if face > 0.0 {
            outline.push([0.0, half]);
            caps.push([0, 4, 5]);
        }
        MeshDistance::new(&extruded(&outline, &caps, 6.0))
    }

    #[test]
    fn sides_that_turn_towards_each_other_run_out_to_an_edge_of_up_to_60_degrees() {
        for (edge, out) in [(32.0, true), (40.0, true), (55.0, true), (70.0, false)] {
            // What a plane cuts off a rod of radius 8, which meets it at that angle.
            let edge = f64::to_radians(edge);
            let arc = (0..=96).map(|k| edge * (1.0 - f64::from(k) / 48.0));
            let outline: Vec<[f64; 2]> = arc.map(|t| [8.0 * t.sin(), 8.0 * (t.cos() - edge.cos())]).collect();
            let fan: Vec<[usize; 3]> = (1..outline.len() - 1).map(|k| [0, k, k + 1]).collect();
            let part = MeshDistance::new(&extruded(&outline, &fan, 6.0));
            // A ball whose contacts are about 155 degrees apart, and between two facets on no side.
            let (sin, cos) = 24.8f64.to_radians().sin_cos();
            let r = 8.0 * (cos - edge.cos()) / (1.0 + cos);
            assert_eq!(runs_out(&part, [(8.0 - r) * sin, 3.0, r], 2.0 * r, 0.05), out, "{edge}");
        }
        // A wedge of 20 degrees of which one side is chamfered to an edge of 50.
        let (taper, chamfer) = (20f64.to_radians().tan(), 50f64.to_radians().tan());
        let at = |x: f64| 0.3 * chamfer + (x - 0.3) * taper;
        let outline = [[0.0, 0.0], [5.0, 0.0], [5.0, at(5.0)], [0.3, at(0.3)]];
        let part = MeshDistance::new(&extruded(&outline, &[[0, 1, 2], [0, 2, 3]], 6.0));
        let r = 0.6 * at(2.0) / 2.0;
        assert!(!runs_out(&part, [2.0, 3.0, r], 2.0 * r, 0.05));
    }

    #[test]
    fn a_wedge_runs_out_to_its_edge_also_at_its_ends_and_the_plate_behind_it_does_not() {
        for degrees in [5.0, 12.0, 28.0_f64] {
            let half = (0.5 * degrees).to_radians();
            for (face, blunt, out) in [(0.0, 0.0, true), (0.04, 0.05, true), (0.04, 0.03, false), (0.3, 0.05, false)] {
                let part = sharpened(degrees, face);
                let run = 0.5 * (0.8 - face) / half.tan();
                // Where the ball that touches both sides is so thick; beside the end of the edge it touches that too.
                for (thick, y) in [(0.4, 3.0), (0.7, 3.0), (0.6, 0.31), (0.35, 5.82)] {
                    let x = (0.5 * thick / half.cos() - 0.5 * face) / half.tan();
                    let told = runs_out(&part, [x, y, 0.0], thick, blunt);
                    assert_eq!(told, out, "{degrees} to {face}: {thick} at {y}");
                }
                assert!(!runs_out(&part, [run + 2.0, 3.0, 0.0], 0.8, blunt), "{degrees}: the plate");
            }
        }
    }
}
