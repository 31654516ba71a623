//! Whether what lies deep in material or void is kept by an opening: proved for a region, ball by ball.

use super::held_balls::{Ball, HeldBalls};
use super::inscribed::{Region, Until, grown, largest_containing};
use crate::geometry::MeshDistance;
use crate::geometry::vector::{Vec3, along, distance, norm, sub, unit};

/// Boxes of less than this share of the ball that lie in no ball are told by a point that is as deep, and are halved until one is found, down to
/// a smaller share.
const LEAST: f64 = 0.02;
const SMALLEST: f64 = 0.002;
/// What lies beside a region by so many radii has to hang together with it: there a neck comes apart. It is told in boxes down to a coarser share.
const BESIDE: f64 = 1.5;
const COARSE: f64 = 0.08;
/// Depths that differ by less are one, millimetres.
const EQUAL: f64 = 1e-9;
/// A ball is sought for boxes up to this share of it.
const SOUGHT: f64 = 0.4;
/// The first step by which it is sought, in shares of it.
const STEP: f64 = 0.2;
/// What seeking one counts for, in points: most are found at once.
const PRICE: usize = 16;
/// Points that are looked at for one that this does not find, about the middle of a box of the least size.
const MOST: usize = 1 << 12;
/// Balls that are remembered: neighbouring boxes lie in the same ones.
const REMEMBERED: usize = 16;

/// What is asked of a region, lengths in millimetres.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// Points that are less deep do not count: corners and edges lie there.
    pub depth: f64,
    /// Radius of the ball that the opening is by.
    pub radius: f64,
    /// Radius of the balls that are to pass, a little less.
    pub passing: f64,
    /// A point that they may pass by, where that is known: the middle of a neck.
    pub by: Option<Vec3>,
}

/// What an opening does to what is deep in a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Opened {
    /// All of it is kept, and the smaller balls pass between all of it that touches: this is proved.
    Kept,
    /// All of it is kept, but by balls between which none was found to pass.
    Parted,
    /// About this point no ball was found that contains it.
    Doubtful(Vec3),
    /// The points that may be looked at were not enough.
    Open,
}

/// Whether all points of a region that lie as deep as `depth` on a side of the surface lie in balls of a radius on that side:
/// (X ⊖ B_depth) ∩ D ⊆ X ∘ B_radius, and whether balls little smaller pass between those that hold places beside each other, in it and about it:
/// what two balls hold that none joins is held by a neck, and comes apart before the opposite offset joins it again.
///
/// A point deeper than the radius lies in its own ball. A box of half diagonal h about c has none that deep if d(c) + h is less, and lies in a
/// ball about p if |p − c| + h ≤ d(p); any other is halved. `is_on_side` tells on which side a point lies; `left` is how many points may be
/// looked at, and afterwards how many were not.
///
/// # Cost
/// One nearest point for each box, and some hundred for each ball that is sought.
pub fn opened(
    surface: &MeshDistance,
    region: Region,
    Asked { depth, radius, passing, by }: Asked,
    left: &mut usize,
    is_on_side: impl Fn(Vec3) -> bool,
) -> Opened {
    let mut search = Search { surface, depth, radius, is_on_side, known: Vec::new(), held: HeldBalls::default() };
    if let Some(answer) = search.sought(&[region], Beyond::Told, left) {
        return answer;
    }
    if let Some(answer) = search.sought(&region.around(BESIDE * radius), Beyond::Left, left) {
        return answer;
    }
    if let Some(at) = by {
        let clear = surface.nearest(at, f64::INFINITY).map_or(0.0, |n| n.distance);
        search.hold(Region::between(at, at), (at, clear));
    }
    if search.held.hang_together(surface, passing) { Opened::Kept } else { Opened::Parted }
}

/// What is done with a box of the least size that lies in no ball.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Beyond {
    /// It is told: all has to be kept.
    Told,
    /// It is left: what is kept has to hang together, no more.
    Left,
}

/// The balls that were found, and the places they hold.
struct Search<'a, F> {
    surface: &'a MeshDistance,
    depth: f64,
    radius: f64,
    is_on_side: F,
    /// The last ones, with their numbers.
    known: Vec<(Ball, usize)>,
    held: HeldBalls,
}

impl<F: Fn(Vec3) -> bool> Search<'_, F> {
    /// Halves boxes until each is told to be held or not to be deep; an answer where one is neither.
    fn sought(&mut self, regions: &[Region], beyond: Beyond, left: &mut usize) -> Option<Opened> {
        let (depth, radius) = (self.depth, self.radius);
        let least = if beyond == Beyond::Told { LEAST } else { COARSE } * radius;
        // Whether a box that lies on one side is on the one that is asked for is asked once for all its halves.
        let mut open: Vec<(Region, Side)> = regions.iter().map(|r| (*r, Side::Unasked)).collect();
        while let Some((place, side)) = open.pop() {
            let (c, reach) = (place.centre, norm(place.half));
            let Some(near) = self.surface.nearest(c, f64::INFINITY) else { return Some(Opened::Open) };
            let clear = near.distance;
            *left = left.saturating_sub(1);
            if clear + reach < depth || self.is_known(place) {
                continue;
            }
            let is_whole = side == Side::Own || clear >= reach;
            if side == Side::Unasked && is_whole && !(self.is_on_side)(c) {
                continue;
            }
            if *left == 0 {
                return Some(Opened::Open);
            }
            let is_least = reach <= least;
            if clear - reach >= radius {
                self.hold(place, (c, clear));
                continue;
            }
            if clear >= reach && reach <= SOUGHT * radius {
                let most = if is_least && beyond == Beyond::Told { MOST } else { 0 };
                *left = left.saturating_sub(PRICE + most);
                if let Some(ball) = self.ball_about(place, clear, most) {
                    self.hold(place, ball);
                    continue;
                }
            }
            if is_least {
                if beyond == Beyond::Left {
                    continue;
                }
                // What is less deep than asked for is no place, but may have one beside it.
                let deeper = along(c, unit(sub(c, near.point)), (depth - clear).max(0.0));
                let is_deep = self.surface.nearest(deeper, f64::INFINITY).is_some_and(|n| n.distance >= depth - EQUAL);
                match is_deep {
                    true => return Some(Opened::Doubtful(deeper)),
                    false if reach <= SMALLEST * radius => return Some(Opened::Open),
                    false => {}
                }
            }
            let side = if is_whole { Side::Own } else { Side::Unasked };
            open.extend(place.halves().map(|half| (half, side)));
        }
        None
    }

    /// Whether one of the last balls holds a place, which is noted.
    fn is_known(&mut self, place: Region) -> bool {
        let reach = norm(place.half);
        let known = self.known.iter().find(|(ball, _)| distance(ball.0, place.centre) + reach <= ball.1);
        known.map(|(_, number)| self.held.hold(place, *number)).is_some()
    }

    fn hold(&mut self, place: Region, ball: Ball) {
        let number = self.held.add(ball);
        self.held.hold(place, number);
        self.known.insert(0, (ball, number));
        self.known.truncate(REMEMBERED);
    }

    /// A ball of the radius that holds a place whose middle lies so deep, sought at no more than so many points where it is not found at once.
    fn ball_about(&self, place: Region, clear: f64, most: usize) -> Option<Ball> {
        let (c, reach) = (place.centre, norm(place.half));
        let mut ball = grown(self.surface, (c, reach), (c, clear), (STEP * self.radius, self.radius));
        if most > 0 && ball.1 < self.radius {
            let until = Until { enough: self.radius, agree: LEAST * self.radius, most };
            ball = largest_containing(self.surface, (c, reach), until).map_or(ball, |b| (b.centre, b.radius));
        }
        (ball.1 >= self.radius).then_some(ball)
    }
}

/// What is known of the side of the surface on which a box lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Own,
    Unasked,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Winding, cuboid};
    use crate::random::Lcg;

    /// An opening of a box of edges 4, 3 and 2 by a ball keeps what is within its radius of the box that is so much smaller.
    #[test]
    fn what_an_opening_keeps_of_a_box_is_proved_and_no_more() {
        let mesh = cuboid([0.0; 3], [4.0, 3.0, 2.0]);
        let (surface, winding) = (MeshDistance::new(&mesh), Winding::new(&mesh));
        let region = Region::between([-0.5; 3], [4.5, 3.5, 2.5]);
        let asked = |depth, radius| {
            opened(&surface, region, Asked { depth, radius, passing: 0.99 * radius, by: None }, &mut (1 << 20), |p| {
                winding.at(p) > 0.5
            })
        };
        // The corner of what is so deep is √3 (r − d) from the middle of the last ball.
        let least = |radius: f64| radius * (1.0 - 1.0 / 3f64.sqrt());
        for radius in [0.3, 0.6, 0.9] {
            assert_eq!(asked(1.15 * least(radius), radius), Opened::Kept, "{radius}");
            let Opened::Doubtful(p) = asked(0.95 * least(radius), radius) else { panic!("{radius}") };
            let clear = surface.nearest(p, f64::INFINITY).unwrap().distance;
            assert!(clear < least(radius) && clear > 0.9 * least(radius), "{radius}: {p:?} {clear}");
        }
        assert!(matches!(asked(0.9, 1.05), Opened::Doubtful(_)));
    }

    #[test]
    fn the_largest_ball_that_contains_a_point_of_a_box_is_as_far_in_as_it_has_to_be() {
        let mesh = cuboid([0.0; 3], [4.0, 3.0, 2.0]);
        let surface = MeshDistance::new(&mesh);
        let mut rng = Lcg(3);
        for _ in 0..40 {
            // Within one of a face, three faces off the others: the ball in the middle contains it.
            let at = [1.0 + 2.0 * rng.unit(), 1.0 + rng.unit(), 0.05 + 1.9 * rng.unit()];
            let until = Until { enough: 2.0, agree: 0.01, most: 1 << 16 };
            let ball = largest_containing(&surface, (at, 0.0), until).unwrap();
            assert!(ball.radius <= 1.0 + 1e-9 && ball.high >= 1.0 - 1e-9 && ball.radius > 0.98, "{at:?} {ball:?}");
        }
        // On the diagonal of a corner at a depth t: r √3 − t √3 = r.
        for t in [0.1, 0.2, 0.3] {
            let radius = 3f64.sqrt() * t / (3f64.sqrt() - 1.0);
            let until = Until { enough: 2.0, agree: 0.002, most: 1 << 16 };
            let ball = largest_containing(&surface, ([t; 3], 0.0), until).unwrap();
            assert!(ball.radius <= radius + 1e-9 && ball.high >= radius - 1e-9, "{t}: {ball:?} {radius}");
            assert!(ball.radius > 0.98 * radius, "{t}: {ball:?} {radius}");
        }
    }
}
