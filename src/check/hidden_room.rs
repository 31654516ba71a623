//! Rooms that a whole grid does not tell from passages of uneven width: they are measured on the surface itself.

use super::budget::Budget;
use super::finding::Bracket;
use super::throat::Stands;
use super::void::{HALF_DIAGONAL, LEAST_RISE, Trapped, Voids};
use super::widest_way::{Way, WaysOut};
use crate::error::Result;
use crate::field::Field;
use crate::geometry::vector::Vec3;
use crate::topology::Chamber;

/// What is found beside the rooms that the whole grid tells.
#[derive(Debug, Default)]
pub(super) struct Hidden {
    pub rooms: Vec<Trapped>,
    /// Places whose way out was not followed to its end.
    pub unfollowed: u64,
}

impl Voids<'_> {
    /// Rooms that a ball of `room_mm` fits into and whose way out is, or may be, narrower than `limit_mm`, beside those told.
    ///
    /// On a grid of spacing h both may be wrong by 2√3·h: a room of 3.6 mm behind a neck of 2.6 mm looks like a passage at 0.4 mm, and
    /// at no level like a room. So every [peak](Voids::peaks) is moved to its widest place by the surface, and its
    /// [widest way](WaysOut::from) is followed to the outside or to what is told. It is no room if the ball of the limit gets there, or one that
    /// it is [`LEAST_RISE`] times as wide as. Each of the others is told with the bracket of its way.
    ///
    /// # Cost
    /// That of the peaks, and of a way for each that lies on no way of another.
    pub(super) fn hidden_rooms(
        &self,
        clearance: &Field<u32>,
        (room_mm, limit_mm): (f64, f64),
        told: &[&Trapped],
        budget: &mut Budget,
    ) -> Result<Hidden> {
        let (part, h) = (self.part(), self.spacing_mm());
        let stands = Stands::of(clearance, limit_mm);
        let wanted = room_mm.max(LEAST_RISE * limit_mm);
        // A ball's middle lies within half a diagonal of a sample; its widest place may lie further on.
        let widest = |from: Vec3| self.widest_about(from, 4.0 * HALF_DIAGONAL * h, wanted);
        let middles = told.iter().flat_map(|t| [t.at, widest(t.at).1]).collect();
        let mut ways = WaysOut::of(part, (clearance, &stands), limit_mm, middles);
        let mut hidden = Hidden::default();
        for peak in self.peaks(clearance, &stands, (room_mm, limit_mm)) {
            let ball = |wide: f64| limit_mm.min(wide / LEAST_RISE);
            let from = self.place(peak.at);
            let may_be = 2.0 * (peak.distance_mm + HALF_DIAGONAL * h);
            if self.is_sealed(peak.at) || ways.is_known(from, ball(may_be)) {
                continue;
            }
            let (wide_mm, middle) = widest(from);
            if wide_mm < room_mm - part.tie() || ways.is_known(middle, ball(wide_mm)) {
                continue;
            }
            match ways.from((middle, wide_mm), ball(wide_mm), budget) {
                None => hidden.unfollowed += 1,
                // What is narrower than the limit is a passage if the best estimate says so.
                Some(way) if way.width_mm.low >= ball(wide_mm) => {}
                Some(way) if wide_mm < LEAST_RISE * limit_mm && way.width_mm.value >= ball(wide_mm) => {}
                Some(way) => hidden.rooms.push(self.room((middle, wide_mm), way, clearance)?),
            }
        }
        Ok(hidden)
    }

    /// A room by the points that its widest way was followed from.
    fn room(&self, (middle, wide_mm): (Vec3, f64), way: Way, clearance: &Field<u32>) -> Result<Trapped> {
        let grid = clearance.grid();
        let inside =
            way.room.iter().chain([&middle]).filter_map(|&p| grid.sample_at(p)).map(|index| grid.offset(index));
        let mut inside: Vec<usize> = inside.filter(|&at| clearance.values()[at] > 0).collect();
        inside.sort_unstable();
        inside.dedup();
        if inside.is_empty() {
            inside.extend(grid.sample_at(middle).map(|index| grid.offset(index)));
        }
        let deepest = inside.iter().copied().max_by_key(|&at| clearance.values()[at]).unwrap_or_default();
        let region = inside.iter().map(|&at| (at as u32, 1)).collect();
        let chamber = Chamber { deepest, widest: clearance.values()[deepest], throat: None, region };
        let Bracket { value, low, high } = way.width_mm;
        // What leads into a room that is told may be shut there.
        let low = if way.leads_out { low } else { 0.0 };
        let way_out_mm = Bracket::new(value.min(wide_mm), low.min(wide_mm), high);
        Ok(Trapped { at: middle, way_out_mm, throat: way.throat, ..self.trapped(&chamber, clearance)? })
    }
}

#[cfg(test)]
mod tests {
    use super::super::void::tests::{flask, part, turned};
    use super::*;
    use crate::random::Lcg;

    /// What is told of a part's rooms on its grid alone, and what is found beside it.
    fn looked_for(voids: &Voids, (room_mm, limit_mm): (f64, f64)) -> [Vec<Trapped>; 2] {
        let clearance = voids.clearance().unwrap();
        let mut met = voids.nothing();
        let mut told = voids.narrow(&clearance, limit_mm, &mut met).unwrap();
        told.extend(voids.small_rooms(&clearance, limit_mm, &mut met).unwrap());
        let (known, mut budget) = (told.iter().collect::<Vec<_>>(), Budget::of(1 << 24));
        let found = voids.hidden_rooms(&clearance, (room_mm, limit_mm), &known, &mut budget).unwrap();
        assert_eq!(found.unfollowed, 0);
        [told, found.rooms]
    }

    #[test]
    fn a_room_is_found_that_the_grid_does_not_tell_from_its_neck_and_a_passage_is_none() {
        let mut rng = Lcg(92);
        let (mut hidden, mut missed) = (0, 0);
        for case in 0..24 {
            let h = 0.6 + 0.1 * rng.unit();
            for (room, neck, is_room) in [(4.6, 1.8, true), (4.4, 1.2, true), (3.2, 3.1, false), (2.8, 1.2, false)] {
                let mesh = turned(&flask(9.0, room, neck), || rng.unit());
                let part = part(mesh, h, [0, 1, 2].map(|_| rng.unit() - 0.5));
                let voids = Voids::of(&part).unwrap();
                let [told, found] = looked_for(&voids, (3.0, 3.5));
                if is_room {
                    // What the outer set closes altogether is told as what may be sealed.
                    let closed = !voids.sealed().unwrap().undecided.is_empty();
                    missed += usize::from(!closed && told.is_empty() && found.is_empty());
                    hidden += found.len();
                } else {
                    assert!(found.is_empty(), "{case}: {room} behind {neck}, h {h}: {}", found.len());
                }
                for t in &found {
                    assert!(t.way_out_mm.low <= neck && neck <= t.way_out_mm.high, "{case}: {:?}", t.way_out_mm);
                }
            }
        }
        assert!(hidden > 8 && missed < 3, "{hidden} hidden, {missed} missed");
    }

    #[test]
    fn a_room_that_differs_from_its_neck_by_four_half_diagonals_is_never_taken_for_a_passage() {
        let mut rng = Lcg(94);
        for case in 0..60 {
            // 1.53 mm are 2.8 to 3.4 spacings, and 3.55 to 4.5: only the latter are told for certain.
            let coarse = case % 2 == 0;
            let h = if coarse { 0.45 + 0.1 * rng.unit() } else { 0.34 + 0.09 * rng.unit() };
            let mesh = turned(&flask(12.0, 3.03, 1.5), || rng.unit());
            let part = part(mesh, h, [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let [told, found] = looked_for(&voids, (2.5, 2.5));
            let closed = !voids.sealed().unwrap().undecided.is_empty();
            let count = told.len() + found.len();
            assert!(count == 1 || closed && count < 2, "{case}: {count} at {h}, closed {closed}");
            for t in &found {
                let b = t.way_out_mm;
                assert!(b.low <= 1.5 && 1.5 <= b.high && b.high < 2.5, "{case}: {b:?}");
            }
        }
    }

    #[test]
    fn a_room_whose_way_out_has_no_sample_is_found_wherever_it_lies() {
        let mut rng = Lcg(93);
        for case in 0..30 {
            let mesh = turned(&flask(16.0, 6.5, 1.0), || rng.unit());
            let part = part(mesh, 1.1333, [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let [told, found] = looked_for(&voids, (3.0, 3.5));
            let all: Vec<&Trapped> = told.iter().chain(&found).collect();
            let [one] = all[..] else { panic!("{case}: {}", all.len()) };
            assert!(one.way_out_mm.low <= 1.0 && 1.0 <= one.way_out_mm.high, "{case}: {:?}", one.way_out_mm);
        }
    }
}
