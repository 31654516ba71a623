//! Whether raised and engraved strokes can be widened in place.

use super::detail::Detail;
use super::relief::Stroke;
use crate::geometry::vector::{along, cross, dot, scale};

/// Steps along a stroke, as a share of the limit: nothing narrower is printed; and how many there are at most each way.
const STEP: f64 = 0.1;
const STEPS: f64 = 2000.0;
/// Heights at which it is looked beside a stroke, as shares of the way down to its foot.
const LEVELS: [f64; 3] = [0.0, 0.35, 0.7];
/// Facets whose normals have a greater cosine with the way to them face it.
const FACING: f64 = 0.9;
/// What lies nearer than this share of the limit is the stroke's own side.
const OWN: f64 = 0.01;

/// Whether a stroke can be widened to the limit without what lies beside it being nearer than the limit then, though it be widened as much:
/// straight across, so that what it stands on does not count, all along it from where it was found, as far as it is straight, and at each of
/// its balls. Where it runs into itself at an angle it is not its own neighbour.
///
/// # Cost
/// Twelve rays for each step along the stroke, and four for each ball.
pub fn has_room(stroke: &Stroke, detail: &Detail, limit: f64) -> bool {
    let room = Room { detail, limit };
    room.is_along(stroke)
        && detail
            .places
            .iter()
            .all(|thin| room.is_at(&Stroke { centre: thin.centre, between: thin.direction(), ..*stroke }))
}

struct Room<'a> {
    detail: &'a Detail,
    limit: f64,
}

impl Room<'_> {
    /// Whether there is room all along a stroke, as far as it is straight.
    fn is_along(&self, stroke: &Stroke) -> bool {
        let long = cross(stroke.between, stroke.up);
        let most = STEPS * STEP * self.limit;
        let [forth, back] = [1.0, -1.0].map(|sign| {
            let way = scale(long, sign);
            let free = stroke.part.distance().first_hit(stroke.centre, way, 0.0, most).map_or(most, |(at, _)| at);
            stroke.as_thin(way, free)
        });
        let steps = ((forth + back) / (STEP * self.limit)).ceil().max(1.0);
        let foot = stroke.foot().unwrap_or(0.0);
        (0..=steps as usize).all(|n| {
            // Not quite to its ends.
            let share = 0.001 + 0.998 * n as f64 / steps;
            let place = along(stroke.centre, long, share * (forth + back) - back);
            LEVELS.iter().all(|level| self.is_at(&Stroke { centre: along(place, stroke.up, -level * foot), ..*stroke }))
        })
    }

    /// Whether there is room on both sides of a place.
    fn is_at(&self, stroke: &Stroke) -> bool {
        let reach = stroke.reach(stroke.centre);
        let grown = self.limit - reach.iter().sum::<f64>();
        let surface = stroke.part.distance();
        grown <= 0.0
            || [1.0, -1.0].iter().zip(reach).all(|(sign, reach)| {
                let outward = scale(stroke.between, *sign);
                let (from, most) = (reach + OWN * self.limit, reach + grown + (1.0 - OWN) * self.limit);
                surface.first_hit(stroke.centre, outward, from, most).is_none_or(|(_, facet)| {
                    let is_own = self.detail.sides.binary_search(&facet).is_ok();
                    is_own && stroke.side.sign() * dot(surface.normal(facet), outward) > -FACING
                })
            })
    }
}
