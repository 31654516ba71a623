//! Chamfers put under a ledge before they are advised: whether its wall goes down far enough, and nothing is in the way.

use super::contract::limits_of;
use super::hanging::support_angle;
use super::rods::plain;
use crate::geometry::triangle::closest_on_segments;
use crate::geometry::vector::{Vec3, along, distance, sub, unit};
use crate::layer::{Ceiling, stretch};
use crate::part::Part;
use crate::process::Process;
use crate::units::short;

/// Places along the anchors of a ledge that are tried, at most.
const PLACES: usize = 24;
/// Heights at which the wall behind a chamfer is felt for, as shares of its own.
const FELT: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// A wall that leans away from the chamfer by more than this share of its reach, and no less than that length in millimetres, does not
/// carry it.
const AWAY: (f64, f64) = (0.25, 0.05);

/// What is no farther from an anchor, in millimetres, lies on it.
const AT_ANCHOR: f64 = 1e-3;

/// What trying a chamfer under a ledge has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chamfer {
    /// How far it reaches out where the ledge is deepest, and how far down.
    leg: f64,
    height: f64,
    /// Its angle from the horizontal, degrees.
    angle: f64,
    /// Places along the anchors: with room; where the wall ends too soon; where something is in the way.
    roomy: usize,
    loose: usize,
    blocked: usize,
    /// How much material lies above the farthest place of the ledge.
    above: f64,
}

/// What is found at one place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Roomy,
    Loose,
    Blocked,
    /// The ledge holds itself here.
    Held,
}

impl Chamfer {
    /// Lays the chamfer that leaves no more than `limit` of a ledge hanging along all its anchors; `None` without an overhang angle, and
    /// where the ledge reaches out from a strand.
    ///
    /// # Cost
    /// At most 8 rays at each of 24 places, and a walk over the ledge's facets.
    pub fn of(part: &Part, process: &Process, ledge: &Ceiling, limit: f64) -> Option<Self> {
        let reach = ledge.cantilever?;
        // A chamfer along the anchors brings no strand between them nearer to what reaches out beyond it.
        let in_plan = |p: Vec3| [p[0], p[1], 0.0];
        let held = in_plan(reach.ends[1]);
        let by =
            |anchor: &[Vec3; 2]| distance(closest_on_segments(anchor.map(in_plan), [held; 2]).0, held) <= AT_ANCHOR;
        if !ledge.anchors.iter().any(by) {
            return None;
        }
        let angle = support_angle(process).filter(|a| *a > 0.0 && *a < 90.0)?;
        let leg = (100.0 * (reach.high_mm - limit) - 1e-4).ceil() / 100.0;
        let slope = angle.to_radians().tan();
        let gap = limits_of(process, "narrow-gap").and_then(|l| l.fail.or(l.warn)).unwrap_or(0.0);
        let tried = Trying { part, ledge, limit, leg, slope, gap };
        let found: Vec<Place> = tried.places().into_iter().map(|(at, out)| tried.at(at, out)).collect();
        let count = |of: Place| found.iter().filter(|p| **p == of).count();
        let far = reach.ends[0];
        let up = part.distance().first_hit(far, [0.0, 0.0, 1.0], 4.0 * part.step() + 1e-6, part.extent()[2]);
        Some(Chamfer {
            leg,
            height: (100.0 * leg * slope - 1e-4).ceil() / 100.0,
            angle,
            roomy: count(Place::Roomy),
            loose: count(Place::Loose),
            blocked: count(Place::Blocked),
            above: up.map_or(0.0, |h| h.0),
        })
    }

    pub fn has_room(&self) -> bool {
        self.roomy > 0 && self.loose + self.blocked == 0
    }

    /// In words, for a limit of ledges.
    pub fn words(&self, limit: f64) -> String {
        let size = format!("{} × {} mm", plain(self.leg), plain(self.height));
        let (tried, limit) = (self.roomy + self.loose + self.blocked, short(limit));
        let why = match self.loose >= self.blocked {
            true => "the wall that it would start from does not go down so far",
            false => "something is in the way",
        };
        let back = match self.above > 0.0 && self.above <= 2.0 * self.leg {
            true => {
                format!("cut it back to {limit} mm with the {} mm of material above", plain(self.above))
            }
            false => format!("let it reach out no more than {limit} mm"),
        };
        match (self.roomy, self.loose + self.blocked) {
            (0, 0) => back,
            (_, 0) => format!(
                "put a chamfer of {size} under it, {}° steep: there is room for it, checked on the surface at {tried} places, and no more than \
                 {limit} mm then hangs over; or {back}",
                short(self.angle)
            ),
            (0, _) => format!("{back}; a chamfer of {size} has no room under it: {why}"),
            (n, _) => format!(
                "{back}; a chamfer of {size} under it has room at {n} of {tried} places, checked on the surface; elsewhere {why}"
            ),
        }
    }
}

/// A chamfer along the anchors of a ledge.
struct Trying<'a> {
    part: &'a Part,
    ledge: &'a Ceiling,
    limit: f64,
    leg: f64,
    /// How far down it goes for each millimetre out.
    slope: f64,
    /// What has to stay free below it.
    gap: f64,
}

impl Trying<'_> {
    /// Places evenly over the anchors, each with the direction out over the ledge.
    fn places(&self) -> Vec<(Vec3, Vec3)> {
        let whole: f64 = self.ledge.anchors.iter().map(|[a, b]| distance(*a, *b)).sum();
        let count = ((whole / self.leg.max(self.limit)).ceil() as usize).clamp(3, PLACES);
        let (mut found, mut next, mut passed) = (Vec::with_capacity(count), 0, 0.0);
        for &[a, b] in &self.ledge.anchors {
            let (long, run) = (distance(a, b), unit(sub(b, a)));
            while next < count {
                let on_it = (next as f64 + 0.5) / count as f64 * whole - passed;
                if on_it > long {
                    break;
                }
                found.push((along(a, run, on_it), unit([run[1], -run[0], 0.0])));
                next += 1;
            }
            passed += long;
        }
        found
    }

    /// What a chamfer meets that starts at a place of an anchor and goes out.
    fn at(&self, at: Vec3, out: Vec3) -> Place {
        let start = along(at, out, 1e-3 * self.leg);
        let facets = &self.ledge.facets;
        let Some([_, end]) = stretch(self.part.mesh(), facets, [start[0], start[1]], [out[0], out[1]]) else {
            return Place::Held;
        };
        let reach = distance([at[0], at[1], 0.0], [end[0], end[1], 0.0]);
        if reach <= self.limit {
            return Place::Held;
        }
        let leg = self.leg.min(reach);
        let below = |share: f64| [at[0], at[1], at[2] - share * leg * self.slope];
        if FELT.iter().any(|&share| below(share)[2] > 0.0 && !self.is_carried(below(share), out, leg * (1.0 - share))) {
            return Place::Loose;
        }
        // The part of its underside that is above the plate.
        let foot = (at[2] / (leg * self.slope)).min(1.0);
        let (tip, foot) = (along(at, out, leg), along(below(foot), out, leg * (1.0 - foot)));
        let away = unit([out[0] * self.slope, out[1] * self.slope, -1.0]);
        match self.is_free(tip, foot) && self.is_free(along(tip, away, self.gap), along(foot, away, self.gap)) {
            true => Place::Roomy,
            false => Place::Blocked,
        }
    }

    /// Whether the wall stands behind a place of the chamfer's back, seen from its underside so far out.
    fn is_carried(&self, back: Vec3, out: Vec3, reach: f64) -> bool {
        let slack = (AWAY.0 * self.leg).max(AWAY.1);
        let from = along(back, out, reach + 4.0 * self.part.step() + 1e-4);
        self.part.distance().first_hit(from, out.map(|x| -x), 0.0, reach + slack).is_some()
    }

    /// Whether nothing lies between two points, but for what they lie on.
    fn is_free(&self, from: Vec3, to: Vec3) -> bool {
        let (long, way) = (distance(from, to), unit(sub(to, from)));
        self.part.distance().first_hit(from, way, 0.02 * long, 0.95 * long).is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::hanging::ceilings_of;
    use crate::geometry::{TriangleMesh, cuboid, extruded};
    use crate::part::Up;

    /// A post 4 mm thick and so tall below an arm of 3 mm that is 2 mm thick, all 6 mm deep; what stands under the post is a plate.
    fn gallows(below: f64) -> TriangleMesh {
        let top = below + 2.0;
        let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, below], [7.0, below], [7.0, top], [0.0, top]];
        extruded(&outline, &[[0, 1, 2], [0, 2, 5], [2, 3, 4], [2, 4, 5]], 6.0)
    }

    fn tried(mesh: TriangleMesh) -> Chamfer {
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
        let process = Process::named("fdm").unwrap();
        let all = ceilings_of(&part, &process);
        let ledges = all.iter().filter(|c| c.cantilever.is_some());
        let ledge = ledges.max_by(|a, b| a.extent.0[2].total_cmp(&b.extent.0[2])).unwrap();
        Chamfer::of(&part, &process, ledge, 0.4).unwrap()
    }

    #[test]
    fn a_ledge_on_a_wall_takes_a_chamfer_that_leaves_the_limit() {
        let found = tried(gallows(10.0));
        assert!(found.has_room() && found.leg >= 2.6 && found.leg < 2.7 && found.height == found.leg, "{found:?}");
        assert!((found.above - 2.0).abs() < 1e-9 && found.angle == 45.0, "{found:?}");
        let said = found.words(0.4);
        assert!(said.starts_with("put a chamfer of 2.6") && said.contains("with the 2 mm of material above"), "{said}");
        // Nearer to the plate than it is high it ends on the plate.
        assert!(tried(gallows(1.5)).has_room());
    }

    #[test]
    fn a_chamfer_has_no_room_above_something_or_on_a_wall_that_ends() {
        let shelf = cuboid([5.0, 0.0, 0.0], [7.0, 6.0, 9.0]);
        let found = tried(gallows(10.0).joined(&shelf));
        assert!(found.roomy == 0 && found.blocked > 0 && !found.words(0.4).contains("put a chamfer"), "{found:?}");
        // The post steps back 1 mm below the arm.
        let outline =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 9.0], [4.0, 9.0], [4.0, 10.0], [7.0, 10.0], [7.0, 12.0], [0.0, 12.0]];
        let caps = [[0, 1, 2], [0, 2, 7], [2, 3, 4], [2, 4, 7], [4, 5, 6], [4, 6, 7]];
        let found = tried(extruded(&outline, &caps, 6.0));
        assert!(found.roomy == 0 && found.loose > 0, "{found:?}");
    }
}
