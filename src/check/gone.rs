//! What an offset loses or closes between sides that oppose each other, by name: a wall, a pin, a hole, a whole body.

use super::finding::{Finding, Spot};
use super::vanishing::Vanishing;
use crate::medial::Side;
use crate::medial::rod::Rods;
use crate::part::Part;

/// What goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Thing {
    /// A whole body, or a closed void.
    Piece,
    /// A pin or strut, or a hole.
    Rod,
    /// A wall, or a gap.
    Sheet,
    /// What is thin at one spot, or several things.
    Place,
}

/// What is known of a side of the surface.
pub(super) struct Known<'a> {
    pub part: &'a Part,
    pub side: Side,
    pub rods: &'a Rods,
    pub pieces: &'a [Vanishing],
}

impl Known<'_> {
    /// What happens at a finding's offset to what is so wide there, in words: `loses a wall of 0.5 mm`, `closes 3 holes of 0.5 mm`.
    pub fn goes(&self, f: &Finding, width: &str) -> String {
        let things: Vec<(Thing, Option<usize>)> = f.places.iter().map(|spot| self.thing(f, spot)).collect();
        let thing = match things[..] {
            [first, ref others @ ..] if others.iter().all(|t| t.0 == first.0) => first.0,
            _ => Thing::Place,
        };
        let [one, many] = match (thing, self.side) {
            (Thing::Piece, Side::Material) => ["a whole body", "whole bodies"],
            (Thing::Piece, Side::Void) => ["a closed void", "closed voids"],
            (Thing::Rod, Side::Material) => ["a pin or strut", "pins or struts"],
            (Thing::Rod, Side::Void) => ["a hole", "holes"],
            (Thing::Sheet, Side::Material) => ["a wall", "walls"],
            (Thing::Sheet, Side::Void) => ["a gap", "gaps"],
            (Thing::Place, Side::Material) => ["a thin place", "thin places"],
            (Thing::Place, Side::Void) => ["a narrow place", "narrow places"],
        };
        let verb = match (thing, self.side) {
            (_, Side::Material) => "loses",
            (Thing::Piece, Side::Void) => "fills",
            (_, Side::Void) => "closes",
        };
        // Several places of one piece, or of one hole, go with it.
        let one_by_one: Option<Vec<usize>> = things.iter().map(|t| t.1.filter(|_| t.0 == thing)).collect();
        let count = one_by_one.map_or(f.count as usize, |mut all| {
            all.sort_unstable();
            all.dedup();
            all.len()
        });
        match count {
            1 => format!("{verb} {one} of {width} mm"),
            n => format!("{verb} {n} {many} of {width} mm"),
        }
    }

    /// What goes at a place of a finding; of pieces and rods, which one.
    fn thing(&self, f: &Finding, spot: &Spot) -> (Thing, Option<usize>) {
        let at = self.part.to_build(spot.at_mm);
        let piece = || self.pieces.iter().position(|p| p.side == self.side && p.goes_at(self.part, spot));
        let rod = || self.rods.rods.iter().position(|r| r.nears(at, 1.0));
        if let Some(n) = piece() {
            (Thing::Piece, Some(n))
        } else if let Some(n) = rod() {
            (Thing::Rod, Some(n))
        } else if f.area_mm2.is_some_and(|area| area >= f.count as f64 * (2.0 * f.value).powi(2)) {
            (Thing::Sheet, None)
        } else {
            (Thing::Place, None)
        }
    }
}
