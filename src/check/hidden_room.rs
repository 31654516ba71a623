//! Rooms that a whole grid does not tell from passages of uneven width: they are measured on the surface itself.

use super::void::{HALF_DIAGONAL, LEAST_RISE, Trapped, Voids, holds, rises};
use crate::error::Result;
use crate::field::Field;
use crate::geometry::vector::Vec3;
use crate::topology::Chamber;

/// A chamber with what is measured of it on the surface.
struct Room {
    chamber: Chamber,
    /// The middle of its widest place.
    middle: Vec3,
}

impl Voids<'_> {
    /// Rooms that a ball of `room_mm` fits into and whose way out is, or may be, narrower than `limit_mm`, beside those told.
    ///
    /// On a grid of spacing h both may be wrong by 2√3·h: a room of 3.6 mm behind a neck of 2.6 mm looks like a passage at 0.4 mm.
    /// So every chamber of the grid, however little it rises over its throat, is measured on the surface: a ball is moved to its
    /// widest place, and another to the widest place within half a diagonal of the throat. A room holds the ball of `room_mm` and
    /// is [`LEAST_RISE`] times as wide as its throat. Each is told with the bracket of the whole grid.
    ///
    /// # Cost
    /// O(samples) for each of about ten levels, and two searches of some hundred distances for each chamber.
    pub(super) fn hidden_rooms(
        &self,
        clearance: &Field<u32>,
        (room_mm, limit_mm): (f64, f64),
        told: &[&Trapped],
    ) -> Result<Vec<Trapped>> {
        let mut found = Vec::new();
        for room in self.rooms_by_surface(clearance, (room_mm, limit_mm))? {
            let own = self.extent(&room.chamber);
            if told.iter().any(|t| holds(t.extent, room.middle) && holds(own, t.at)) {
                continue;
            }
            found.push(Trapped { at: room.middle, ..self.trapped(&room.chamber, clearance)? });
        }
        Ok(found)
    }

    /// The chambers of this grid that hold the ball of `room_mm` and rise over their throat by the surface.
    fn rooms_by_surface(&self, clearance: &Field<u32>, (room_mm, limit_mm): (f64, f64)) -> Result<Vec<Room>> {
        let (h, extent) = (clearance.grid().h(), self.part().extent());
        let samples = |diameter: f64| 0.5 * diameter / h;
        // A ball's middle lies within half a diagonal of a sample, and what the part touches within as much of its own.
        let least = (samples(room_mm) - 2.0 * HALF_DIAGONAL).max(1.0);
        // In steps of a tenth, or of the squares that there are.
        let next = |r: &f64| Some((r * r + 1.0).floor().sqrt().max(1.1 * r));
        let levels = std::iter::successors(Some(least.powi(2).ceil().sqrt()), next);
        let levels: Vec<f64> = levels.take_while(|&r| r < samples(limit_mm) + 1.0).collect();
        let chambers = self.closed_at(clearance, &levels, &mut self.nothing())?;
        let rooms = chambers.into_iter().filter(|c| !rises(c)).filter_map(|chamber| {
            // A way out that has no sample of its own is narrower than any room that has.
            let throat = chamber.throat.map(|throat| self.place(throat.at));
            let neck = throat.map_or(0.0, |at| self.widest_about(at, HALF_DIAGONAL * h, limit_mm).0);
            if neck >= limit_mm - self.part().tie() {
                return None;
            }
            let wanted = room_mm.max(LEAST_RISE * neck);
            // Its widest sample is off by the doubt of two clearances and as much for where samples stand.
            let reach = 4.0 * HALF_DIAGONAL * h;
            let (wide_mm, middle) = self.widest_about(self.place(chamber.deepest), reach, wanted);
            let is_room = wide_mm >= wanted - self.part().tie();
            let within = holds(([0.0; 3], extent), middle);
            (is_room && within).then_some(Room { chamber, middle })
        });
        Ok(rooms.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::void::tests::{flask, part, turned};
    use super::*;
    use crate::random::Lcg;

    /// What is told of a part's rooms on its grid alone, and what is found beside it.
    fn looked_for(voids: &Voids) -> [Vec<Trapped>; 2] {
        let clearance = voids.clearance().unwrap();
        let mut met = voids.nothing();
        let mut told = voids.narrow(&clearance, 3.5, &mut met).unwrap();
        told.extend(voids.small_rooms(&clearance, 3.5, &mut met).unwrap());
        let found = voids.hidden_rooms(&clearance, (3.0, 3.5), &told.iter().collect::<Vec<_>>()).unwrap();
        [told, found]
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
                let [told, found] = looked_for(&voids);
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
    fn a_room_whose_way_out_has_no_sample_is_found_wherever_it_lies() {
        let mut rng = Lcg(93);
        for case in 0..30 {
            let mesh = turned(&flask(16.0, 6.5, 1.0), || rng.unit());
            let part = part(mesh, 1.1333, [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let [told, found] = looked_for(&voids);
            let all: Vec<&Trapped> = told.iter().chain(&found).collect();
            let [one] = all[..] else { panic!("{case}: {}", all.len()) };
            assert!(one.way_out_mm.low <= 1.0 && 1.0 <= one.way_out_mm.high, "{case}: {:?}", one.way_out_mm);
        }
    }
}
