//! Whether raised and engraved strokes can be widened in place.

use super::detail::Detail;
use super::relief::Stroke;
use crate::geometry::vector::{Vec3, along, dot, scale, sub};

/// Steps along a stroke, as a share of the limit: nothing narrower is printed; and so many limits it is followed each way at most.
const STEP: f64 = 0.1;
const MOST: f64 = 200.0;
/// Heights at which it is looked beside a stroke, as shares of the way down to its foot.
const LEVELS: [f64; 3] = [0.0, 0.35, 0.7];
/// Facets whose normals have a greater cosine with the way to them face it; others may run up to the stroke.
const FACING: f64 = 0.9;
/// So much further than on along a plane they are followed to it, and so many limits.
const BENT: f64 = 1.5;
const ROUND: f64 = 0.5;
/// A line across a ball that is longer or shorter than it by this share is none across the stroke.
const AT_ITS_END: f64 = 0.05;
/// What lies nearer than this share of the limit is the stroke's own side.
const OWN: f64 = 0.01;

/// Whether a stroke can be widened to the limit without what lies beside it being nearer than the limit then, though it be widened as much:
/// straight across, so that what it stands on does not count, all along it from where it was found, as far as it is straight, and at each of
/// its balls. What runs up to it at an angle, as strokes do where they meet, is no neighbour: the gap between them ends at any width.
///
/// # Cost
/// Some twelve rays for each step along the stroke, two for each sixteenth of its thickness, and four for each ball.
pub fn has_room(stroke: &Stroke, detail: &Detail, limit: f64) -> bool {
    let room = Room { limit };
    // At the level of the stroke's own place: a ball may lie in the plane of what it stands on.
    let level = |p: Vec3| along(p, stroke.up, dot(sub(stroke.centre, p), stroke.up));
    let mut balls = detail.places.iter().filter_map(|t| {
        let ball = Stroke { centre: level(t.centre), between: t.direction(), ..*stroke };
        // Beside an end of the stroke a line through it meets that end.
        let wide = ball.reach(ball.centre).iter().sum::<f64>();
        ((wide - t.diameter).abs() < AT_ITS_END * t.diameter).then_some(ball)
    });
    room.is_along(stroke) && balls.all(|ball| room.is_at(&ball))
}

struct Room {
    limit: f64,
}

impl Room {
    /// Whether there is room all along a stroke, as far as it is straight.
    fn is_along(&self, stroke: &Stroke) -> bool {
        let (ways, most) = (stroke.ways(), MOST * self.limit);
        let [forth, back] = ways.map(|way| stroke.as_thin(way, stroke.clear(stroke.centre, way, most)));
        let steps = ((forth + back) / (STEP * self.limit)).ceil().max(1.0);
        let foot = stroke.foot().unwrap_or(0.0);
        (0..=steps as usize).all(|n| {
            // Not quite to its ends.
            let share = 0.001 + 0.998 * n as f64 / steps;
            let place = along(stroke.centre, ways[0], share * (forth + back) - back);
            LEVELS.iter().all(|level| self.is_at(&Stroke { centre: along(place, stroke.up, -level * foot), ..*stroke }))
        })
    }

    /// Whether there is room on both sides of a place.
    fn is_at(&self, stroke: &Stroke) -> bool {
        let reach = stroke.reach(stroke.centre);
        let grown = self.limit - reach.iter().sum::<f64>();
        grown <= 0.0
            || [1.0, -1.0].iter().zip(reach).all(|(sign, reach)| {
                let outward = scale(stroke.between, *sign);
                let (from, most) = (reach + OWN * self.limit, reach + grown + (1.0 - OWN) * self.limit);
                let hit = stroke.part.distance().first_hit(stroke.centre, outward, from, most);
                hit.is_none_or(|(at, facet)| self.runs_up(stroke, outward, [reach, at], facet))
            })
    }

    /// Whether the facet that is met straight across beyond a side runs up to that side: seen along the side from beside it.
    fn runs_up(&self, stroke: &Stroke, outward: Vec3, [side, at]: [f64; 2], facet: u32) -> bool {
        let (surface, [long, _]) = (stroke.part.distance(), stroke.ways());
        let [across, on] = [outward, long].map(|way| dot(surface.normal(facet), way));
        // How far on the plane of the facet meets the side.
        let ahead = (at - side) * across / on;
        let beside = along(stroke.centre, outward, side + OWN * self.limit);
        let within = BENT * ahead.abs() + ROUND * self.limit;
        across.abs() < FACING && surface.first_hit(beside, scale(long, ahead.signum()), 0.0, within).is_some()
    }
}
