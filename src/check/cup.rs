//! Vents against the suction of a cup: drilled into the sets, and all that stays closed of the cup measured again.

use super::basin::Basin;
use super::bore::{Leading, Vent, Wanted, Ways};
use super::place::reported;
use super::tooling::direction_in_file;
use super::vent::drilled;
use super::void::Voids;
use crate::error::Result;
use crate::geometry::vector::Vec3;
use crate::part::Part;
use crate::topology::{Falls, Passage, retained};
use crate::units::short;

/// A vent against suction, millimetres: the least hole that drains, by the escape limit of resin.
const VENT: f64 = 3.5;
const WANTED: Wanted = Wanted { ball_mm: VENT, wall_mm: 0.0, leading: Leading::Sideways };
/// Rooms of a cup that get a vent.
const ROOMS: usize = 8;

/// The vents of the cups of a part.
pub(super) struct CupVents<'a> {
    voids: &'a Voids<'a>,
    ways: Ways<'a>,
    /// The wall that has to stay around a vent.
    wall_mm: f64,
}

/// What vents do for a cup.
struct Vented {
    vents: Vec<Vent>,
    /// The most film that one of the cups closes which stay of it, mm².
    film_mm2: f64,
}

impl<'a> CupVents<'a> {
    /// Those of a part whose voids are known, with the wall that has to stay around a vent.
    pub fn of(voids: &'a Voids<'a>, wall_mm: f64) -> Self {
        CupVents { voids, ways: Ways::of(voids.part()), wall_mm }
    }

    /// In words, what vents do for a cup that may close at most so much film.
    ///
    /// # Errors
    /// None for a cup of the part.
    ///
    /// # Cost
    /// A flood of the void for each set of rooms that joins above: one where one vent does.
    pub fn advice(&self, cup: &Basin, widest_mm2: f64) -> Result<String> {
        let Vented { vents, film_mm2 } = self.drilled_into(cup, widest_mm2)?;
        let still = short(film_mm2.round());
        let part = self.voids.part();
        Ok(match &vents[..] {
            [] => no_vent(),
            _ if film_mm2 >= cup.film().low => no_vent(),
            [vent] if film_mm2 <= widest_mm2 => {
                format!("drill a straight vent {}; measured again, {still} mm² stay closed", placed(part, vent))
            }
            _ if film_mm2 <= widest_mm2 => {
                let each: Vec<String> = vents.iter().map(|v| placed(part, v)).collect();
                format!(
                    "drill a straight vent into each of {} rooms that join above, {}; measured again, {still} mm² stay closed",
                    vents.len(),
                    each.join("; ")
                )
            }
            [vent] => format!(
                "{}; a straight vent {}, which was tried, leaves {still} mm² closed",
                no_vent(),
                placed(part, vent)
            ),
            _ => format!(
                "give it holes of at least {} mm near the plate, one for each room; the {} straight vents that were tried leave {still} \
                 mm² closed",
                short(VENT),
                vents.len()
            ),
        })
    }

    /// A vent at the bottom of a cup, then one at that of each cup that stays of it and closes too much, as long as that helps.
    fn drilled_into(&self, cup: &Basin, widest_mm2: f64) -> Result<Vented> {
        let solid = self.voids.solid;
        let mut vented = Vented { vents: Vec::new(), film_mm2: f64::INFINITY };
        let mut rooms: Vec<[Vec3; 2]> = vec![Self::starts(cup)?];
        let mut tried: Vec<[Vec3; 2]> = Vec::new();
        loop {
            let before = vented.vents.len();
            let new = rooms.iter().filter_map(|starts| self.leading_out_of(starts));
            vented.vents.extend(new.take(ROOMS - before));
            if vented.vents.len() == before {
                return Ok(vented);
            }
            tried.append(&mut rooms);
            let free = drilled(&solid.outer, &vented.vents).complement();
            let left = cup.left(self.voids, &retained(&free, Falls::Down, Passage::Faces)?)?;
            vented.film_mm2 = left.iter().map(|b| b.film().value).fold(0.0, f64::max);
            let closed = left.iter().filter(|b| b.film().value > widest_mm2);
            rooms = closed.map(Self::starts).collect::<Result<_>>()?;
            // A room that its vent does not open is not drilled again.
            rooms.retain(|starts| !tried.contains(starts));
        }
    }

    /// Where vents of a room may start: so high above its floor that they cut two samples into it, and at the floor.
    fn starts(room: &Basin) -> Result<[Vec3; 2]> {
        let h = room.spacing_mm();
        let layers = (0.5 * WANTED.diameter_mm(h) / h).floor() - 2.0;
        Ok([room.over_floor(layers.max(0.0) as usize)?, room.over_floor(0)?])
    }

    /// The shortest vent into a room from the first of its starts that has one, through nothing but its wall.
    fn leading_out_of(&self, starts: &[Vec3; 2]) -> Option<Vent> {
        let wanted = Wanted { wall_mm: self.wall_mm, ..WANTED };
        starts.iter().find_map(|at| self.ways.shortest(self.voids.solid, *at, wanted)).map(Vent::starting_at_its_wall)
    }
}

/// A vent with its place on the inside of the wall, in the frame of the file: `of 4 mm at 1.5, 0, 2 towards +z through about 2 mm of material`.
fn placed(part: &Part, vent: &Vent) -> String {
    let at = reported(part, vent.from).map(|c| short((10.0 * c).round() / 10.0)).join(", ");
    let wall = short((vent.wall_mm * 10.0).round() / 10.0);
    let way = direction_in_file(part, vent.way);
    format!("of {} mm at {at} towards {way} through about {wall} mm of material", short(vent.diameter_mm))
}

/// What is advised where no straight vent was tried, or none leads out.
pub(super) fn no_vent() -> String {
    format!("give it a hole of at least {} mm near the plate", short(VENT))
}

#[cfg(test)]
mod tests {
    use super::super::void::tests::part;
    use super::*;
    use crate::field::Indicator;
    use crate::geometry::{TriangleMesh, cuboid};

    /// A tray of 26 × 14 × 14 mm, open at the top: two rooms of 9 × 8 mm on its floor, parted by a wall that ends at a height.
    fn tray(wall_top: f64) -> TriangleMesh {
        let (lo, hi) = ([0.0; 3], [26.0, 14.0, 14.0]);
        let rest = [
            cuboid(lo, [3.0, hi[1], hi[2]]),
            cuboid([23.0, 0.0, 0.0], hi),
            cuboid(lo, [hi[0], 3.0, hi[2]]),
            cuboid([0.0, 11.0, 0.0], hi),
            cuboid([12.0, 1.0, 1.0], [14.0, 13.0, wall_top]),
        ];
        rest.iter().fold(cuboid(lo, [hi[0], hi[1], 3.0]), |tray, more| tray.joined(more))
    }

    fn advised(mesh: TriangleMesh, widest_mm2: f64) -> String {
        let part = part(mesh, 0.25, [0.2, -0.1, 0.3]);
        let voids = Voids::of(&part).unwrap();
        let kept = retained(&voids.solid.outer.complement(), Falls::Down, Passage::Faces).unwrap();
        let certain = retained(&voids.solid.inner.complement(), Falls::Down, Passage::Corners).unwrap();
        let certain = certain.difference(&voids.solid.outer).unwrap();
        let (cups, _) = Basin::all(&voids, &kept, &certain, Falls::Down).unwrap();
        let [cup] = &cups[..] else { panic!("one cup") };
        CupVents::of(&voids, 0.5).advice(cup, widest_mm2).unwrap()
    }

    /// The cup of a tray, and what its vents are asked.
    fn vents_of(mesh: TriangleMesh, widest_mm2: f64) -> Vec<Vent> {
        let part = part(mesh, 0.25, [0.2, -0.1, 0.3]);
        let voids = Voids::of(&part).unwrap();
        let kept = retained(&voids.solid.outer.complement(), Falls::Down, Passage::Faces).unwrap();
        let (cups, _) = Basin::all(&voids, &kept, &Indicator::empty(*kept.grid()), Falls::Down).unwrap();
        CupVents::of(&voids, 0.5).drilled_into(&cups[0], widest_mm2).unwrap().vents
    }

    #[test]
    fn vents_lie_above_the_floor_and_cut_nothing_but_their_wall() {
        // The middle of the floor lies beside the wall of 2 mm between the rooms.
        let vents = vents_of(tray(9.0), 50.0);
        assert_eq!(vents.len(), 2);
        for vent in vents {
            // A floor of 3 mm, of which it cuts two samples, and walls of 3 mm.
            let lowest = vent.from[2] - 0.5 * vent.diameter_mm;
            assert!((2.25..=3.0).contains(&lowest), "{vent:?}");
            assert!((vent.wall_mm - 3.0).abs() <= 0.5 && vent.clear_mm == 0.0, "{vent:?}");
            let along_x = vent.way[0].abs() > 0.5;
            let (at, faces) = if along_x { (vent.from[0], [3.0, 23.0]) } else { (vent.from[1], [3.0, 11.0]) };
            assert!(faces.into_iter().any(|face| (at - face).abs() <= 0.4), "{vent:?}");
            // Nothing of the wall between the rooms lies in its way.
            assert!(along_x || (vent.from[0] - 13.0).abs() >= 1.0 + 0.5 * vent.diameter_mm, "{vent:?}");
        }
    }

    #[test]
    fn rooms_that_join_above_the_vent_of_one_stay_closed() {
        // Where the other room may stay closed, its film of 72 mm² is told; else it gets a vent of its own.
        let one = advised(tray(9.0), 100.0);
        assert!(
            one.starts_with("drill a straight vent of 4 mm at ") && one.ends_with("again, 72 mm² stay closed"),
            "{one}"
        );
        let each = advised(tray(9.0), 50.0);
        assert!(each.starts_with("drill a straight vent into each of 2 rooms"), "{each}");
        assert!(each.ends_with("again, 0 mm² stay closed"), "{each}");
        // A wall that ends in the floor parts no rooms.
        let low = advised(tray(2.5), 50.0);
        assert!(low.starts_with("drill a straight vent of 4 mm") && low.ends_with("again, 0 mm² stay closed"), "{low}");
    }
}
