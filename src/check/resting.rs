//! Where a ball that comes down over a concave edge comes to rest.

use crate::geometry::vector::{Vec3, add, along, distance, dot, sub, unit};
use crate::part::Part;

/// A ball that reaches no deeper than this share of its radius is clear.
const CLEAR: f64 = 1e-6;
/// What turns further than this is a groove or a hole, no fillet, radians (150°).
pub(super) const GROOVE: f64 = 150.0 * std::f64::consts::PI / 180.0;
/// Steps after which a ball that is still not clear takes longer ones: between steep walls each gains little.
const STRAIGHT: usize = 6;
/// Facets that a ball slides over at most.
const SLIDES: usize = 16;
/// Walls that a ball is pushed away from at most.
const PUSHES: usize = 64;
/// By how much more than it reaches into them: between walls that turn by 150° what it lacks falls by a quarter each time.
const PUSHED: f64 = 1.5;
/// Pushes after which a ball lies between walls that do not part, if it lacks more than half of what it lacked and has not so many times the room:
/// between those that do it lacks a tenth then, or has twice the room.
const WATCHED: usize = 8;
/// How many times the room.
const WIDENS: f64 = 1.25;

/// How a ball gets out from a point of the surface.
enum Way {
    /// It touches the surface there.
    Touches,
    /// It is clear with its centre here.
    Clear(Vec3),
    /// Other surface is in the way.
    Barred,
}

/// How a ball gets out from an edge before it comes down over it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Descent {
    /// Straight out: where other surface bars that way, the edge lies in a groove or a hole.
    Straight,
    /// Where other surface bars the way, away from what it reaches into, one after the other.
    Steered,
}

/// A ball outside a part.
#[derive(Clone, Copy)]
pub(super) struct Ball<'a> {
    pub part: &'a Part,
    pub radius: f64,
    pub descent: Descent,
}

impl Ball<'_> {
    /// Where the centre comes to rest over a point of the surface, if the ball stays more than a share of its radius away from it.
    ///
    /// The ball moves out from the point by what it lacks, and after a few steps by more, until it is clear; where the surface on the other side
    /// is in the way, it moves away from what it reaches into, one after the other. From there it falls back and slides
    /// along what it touches. One that is not clear within its radius over cos 75° lies in a groove or a hole.
    pub fn rest(&self, foot: Vec3, outward: Vec3, share: f64) -> Option<Vec3> {
        let deepest = self.radius / (0.5 * GROOVE).cos();
        let over = match self.straight(foot, outward, share, deepest) {
            Way::Touches => return None,
            Way::Clear(centre) => Some(centre),
            Way::Barred if self.descent == Descent::Straight => None,
            Way::Barred => self.steered(foot, outward, deepest),
        };
        let rest = self.slid(over?, foot, share);
        (distance(rest, foot) > (1.0 + share) * self.radius).then_some(rest)
    }

    /// Straight out from a point.
    fn straight(&self, foot: Vec3, outward: Vec3, share: f64, deepest: f64) -> Way {
        let (surface, r) = (self.part.distance(), self.radius);
        let opposite = surface.first_hit(foot, outward, 4.0 * self.part.step() + CLEAR * r, deepest);
        let room = opposite.map_or(deepest, |(far, _)| far);
        let mut away = (1.0 + share) * r;
        for looks in 0..40 {
            if away > room {
                break;
            }
            let centre = along(foot, outward, away);
            match surface.nearest(centre, r * (1.0 - CLEAR)) {
                None if looks == 0 => return Way::Touches,
                None => return Way::Clear(centre),
                Some(near) => away += (r - near.distance) * if looks < STRAIGHT { 1.0 } else { 4.0 },
            }
        }
        Way::Barred
    }

    /// Away from what the ball reaches into, by more than it does where that is free: between two walls that part it comes out where both leave it
    /// room.
    fn steered(&self, foot: Vec3, outward: Vec3, deepest: f64) -> Option<Vec3> {
        let (surface, r) = (self.part.distance(), self.radius);
        let mut centre = along(foot, outward, 4.0 * self.part.step() + CLEAR * r);
        let (mut lacked, mut room) = (f64::INFINITY, 0.0);
        for pushes in 0..PUSHES {
            let Some(near) = surface.nearest(centre, r * (1.0 - CLEAR)) else { return Some(centre) };
            let lacks = r - near.distance;
            if pushes % WATCHED == 0 {
                if lacks > 0.5 * lacked && near.distance < WIDENS * room {
                    return None;
                }
                (lacked, room) = (lacks, near.distance);
            }
            let (way, far) = (unit(sub(centre, near.point)), PUSHED * lacks);
            // No further than to the middle of what is free.
            let free = surface.first_hit(centre, way, CLEAR * r, 2.0 * far).map_or(far, |(hit, _)| far.min(0.5 * hit));
            centre = along(centre, way, free);
            if distance(centre, foot) > deepest {
                return None;
            }
        }
        None
    }

    /// The centre of a ball that is clear of the surface, slid along what it touches towards a point, until it is within its radius and a share of
    /// it or goes no further.
    fn slid(&self, mut centre: Vec3, to: Vec3, share: f64) -> Vec3 {
        let (surface, r) = (self.part.distance(), self.radius);
        let is_clear = |c: Vec3| surface.nearest(c, r * (1.0 - CLEAR)).is_none();
        let mut touched = surface.nearest(centre, 1.01 * r);
        let mut stuck = false;
        for _ in 0..SLIDES {
            let way = sub(to, centre);
            let level = touched.map_or(way, |touched| {
                let normal = unit(sub(centre, touched.point));
                along(way, normal, -dot(way, normal))
            });
            let (mut clear, mut met) = (0.0, 1.0);
            if is_clear(add(centre, level)) {
                clear = 1.0;
            }
            while clear < 1.0 && met - clear > 1e-3 {
                let middle = 0.5 * (clear + met);
                if is_clear(along(centre, level, middle)) { clear = middle } else { met = middle }
            }
            // What stops it is what it slides along next: in a round of facets it touches more than one.
            touched = surface.nearest(along(centre, level, met), 1.01 * r);
            let before = distance(centre, to);
            centre = along(centre, level, clear);
            let now = distance(centre, to);
            let was_stuck = std::mem::replace(&mut stuck, now > before - CLEAR * r);
            if now <= (1.0 + share) * r || (stuck && was_stuck) {
                break;
            }
        }
        centre
    }
}
