//! A straight vent for a trapped volume, drilled into the sets and looked at again before it is suggested.

use super::bore::{Vent, Wanted, Ways};
use super::place::reported;
use super::void::{HALF_DIAGONAL, Trapped, rises, way_out};
use crate::distance::squared_distance;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::Solid;
use crate::geometry::vector::{Vec3, along, distance, dot, sub};
use crate::part::Part;
use crate::topology::{Adjacency, Chamber, Side, border, chambers, components};
use crate::units::{hundredths, short};

/// Samples of the least piece that counts: what is smaller may be how the grid cuts an edge.
const LEAST_PIECE: u64 = 27;

/// Whether each of some vents leaves the part in as many pieces as it is in.
fn keep_the_part_whole(solid: &Solid, vents: &[Vent]) -> Vec<bool> {
    if vents.is_empty() {
        return Vec::new();
    }
    whole_after(solid, vents, pieces(solid, &[]))
}

/// Pieces of the part with some vents drilled.
fn pieces(solid: &Solid, vents: &[Vent]) -> usize {
    let mut left = solid.centres.clone();
    vents.iter().for_each(|v| drill(&mut left, v, 0.5 * v.diameter_mm));
    components(&left, Adjacency::Face).sizes().into_iter().filter(|&size| size >= LEAST_PIECE).count()
}

/// As [`keep_the_part_whole`]: those that part it together are looked at half by half.
fn whole_after(solid: &Solid, vents: &[Vent], before: usize) -> Vec<bool> {
    if vents.is_empty() || pieces(solid, vents) <= before {
        return vec![true; vents.len()];
    }
    match vents.split_at(vents.len() / 2) {
        ([], one) => vec![false; one.len()],
        (first, second) => [first, second].map(|half| whole_after(solid, half, before)).concat(),
    }
}

/// What each vent does for the place it leads to, all drilled at once: whether a ball of `ball_mm` gets from there to the outside, and
/// from the other rooms of the place, which a passage may part from it.
///
/// A cube is taken away only if all of it lies in the channel, so what works here works in the part.
fn drilled_for(solid: &Solid, tried: &[(&Trapped, Vent)], ball_mm: f64) -> Result<Vec<Venting>> {
    let vents: Vec<Vent> = tried.iter().map(|t| t.1).collect();
    let grid = *solid.outer.grid();
    let exits = border(&grid, &Side::ALL);
    // The bracket of a way out is as wide as four half diagonals; its middle is compared.
    let level = ((0.5 * ball_mm / grid.h()).powi(2).ceil() as u32).max(1);
    let clearance = squared_distance(&drilled(&solid.outer, &vents))?;
    let free = Indicator::from_predicate(grid, |at| clearance.values()[at] >= level);
    let parts = components(&free, Adjacency::Corner);
    let mut open = vec![false; parts.count()];
    exits.intersection(&free)?.iter().filter_map(|at| parts.of(grid.index(at))).for_each(|l| open[l as usize] = true);
    let leads_out = |v: &Vent| grid.sample_at(v.from).and_then(|i| parts.of(i)).is_some_and(|l| open[l as usize]);
    let mut shut = chambers(&clearance, &exits, level, |_| false)?;
    shut.retain(rises);
    // A place is all that its way out shuts, before anything is drilled.
    let before = if shut.is_empty() {
        Vec::new()
    } else {
        chambers(&squared_distance(&solid.outer)?, &exits, level, |_| false)?
    };
    let answer = |(place, vent): &(&Trapped, Vent)| {
        let at = grid.sample_at(place.at).map(|i| grid.offset(i));
        let own = before.iter().find(|c| at.is_some_and(|at| c.holds(at)));
        let left: Vec<&Chamber> = shut.iter().filter(|c| own.is_some_and(|own| own.holds(c.deepest))).collect();
        match left.first() {
            _ if !leads_out(vent) => Venting::LeadsNowhere,
            None => Venting::Works(*vent),
            Some(room) => {
                let way_out_mm = way_out(room, grid.h());
                let at = grid.position(grid.index(room.deepest));
                Venting::LeavesRooms {
                    vent: *vent,
                    rooms: left.len(),
                    at,
                    way_out_mm: [way_out_mm.low, way_out_mm.high],
                }
            }
        }
    };
    Ok(tried.iter().map(answer).collect())
}

/// The outer set without the cubes that lie wholly in a vent.
pub(super) fn drilled(outer: &Indicator, vents: &[Vent]) -> Indicator {
    let mut left = outer.clone();
    for vent in vents {
        let radius = 0.5 * vent.diameter_mm - HALF_DIAGONAL * outer.grid().h();
        drill(&mut left, vent, radius);
    }
    left
}

/// Takes away the cubes whose centres lie within a radius of the axis.
fn drill(set: &mut Indicator, vent: &Vent, radius: f64) {
    let grid = *set.grid();
    let clamped = |p: Vec3, a: usize, by: f64| {
        ((p[a] + by - grid.origin()[a]) / grid.h()).clamp(0.0, grid.dims()[a] as f64 - 1.0) as usize
    };
    let (lo, hi) = ([0, 1, 2].map(|a| vent.from[a].min(vent.to[a])), [0, 1, 2].map(|a| vent.from[a].max(vent.to[a])));
    let first = [0, 1, 2].map(|a| clamped(lo, a, -radius));
    let last = [0, 1, 2].map(|a| clamped(hi, a, radius + grid.h()));
    let length = distance(vent.from, vent.to).max(1e-9);
    let axis = sub(vent.to, vent.from).map(|c| c / length);
    for k in first[2]..=last[2] {
        for j in first[1]..=last[1] {
            for i in first[0]..=last[0] {
                let p = grid.position([i, j, k]);
                let s = dot(sub(p, vent.from), axis).clamp(0.0, length);
                if distance(p, along(vent.from, axis, s)) <= radius {
                    set.set([i, j, k], false);
                }
            }
        }
    }
}

/// A place and what could be drilled to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Venting {
    /// This vent leads out, measured again.
    Works(Vent),
    /// This vent leads out of the widest room of the place; others, one of them here, keep a way out that is narrower, mm.
    LeavesRooms { vent: Vent, rooms: usize, at: Vec3, way_out_mm: [f64; 2] },
    /// A vent leaves the part whole and does not lead out.
    LeadsNowhere,
    /// None has a wall around it and leaves the part in one piece.
    NoRoom,
}

impl Venting {
    /// The vent that works.
    pub fn vent(self) -> Option<Vent> {
        if let Venting::Works(vent) = self { Some(vent) } else { None }
    }

    /// In words, a vent that opens a part of the place.
    pub fn partly(self, part: &Part) -> Option<String> {
        let Venting::LeavesRooms { vent, rooms, at, way_out_mm } = self else { return None };
        let at = reported(part, at).map(|c| short((10.0 * c).round() / 10.0)).join(", ");
        let [low, high] = way_out_mm.map(hundredths);
        let others = match rooms {
            1 => format!("a room behind it, at {at}, keeps a way out of {low} to {high} mm: give it one of its own"),
            n => format!(
                "{n} rooms behind it keep narrow ways out, one at {at} of {low} to {high} mm: give each one of its own"
            ),
        };
        Some(format!("drill {}; measured again, {others}", vent.words(part)))
    }
}

/// For each place its shortest vent that leaves the part whole, looked at again.
pub(super) fn vents(part: &Part, places: &[&Trapped], wanted: Wanted) -> Result<Vec<Venting>> {
    let solid = part.solid()?;
    let ways = Ways::of(part);
    let mut found: Vec<Option<Vent>> = places.iter().map(|t| ways.shortest(solid, t.at, wanted)).collect();
    let tried: Vec<Vent> = found.iter().flatten().copied().collect();
    let mut whole = keep_the_part_whole(solid, &tried).into_iter();
    found.iter_mut().for_each(|v| *v = v.filter(|_| whole.next().unwrap_or(false)));
    let drilled: Vec<(&Trapped, Vent)> =
        places.iter().copied().zip(&found).filter_map(|(t, v)| v.map(|v| (t, v))).collect();
    let mut does =
        if drilled.is_empty() { Vec::new() } else { drilled_for(solid, &drilled, wanted.ball_mm)? }.into_iter();
    Ok(found.into_iter().map(|v| v.and_then(|_| does.next()).unwrap_or(Venting::NoRoom)).collect())
}

/// What is advised for places that something does not leave, the largest first.
pub(super) fn advice(part: &Part, places: &[&Trapped], wanted: Wanted) -> Result<String> {
    let found = vents(part, places, wanted)?;
    let working = found.iter().filter_map(|v| v.vent()).count();
    Ok(match (found.iter().find_map(|v| v.vent()), found.len()) {
        (Some(v), 1) => format!("if it is not meant, drill {}; measured again, it then leads out", v.words(part)),
        (Some(v), n) => {
            format!(
                "where they are not meant: {}; {working} of {n} such vents were measured again and lead out",
                v.words(part)
            )
        }
        (None, n) if found.iter().all(|v| *v == Venting::NoRoom) => {
            let diameter = short(wanted.diameter_mm(part.solid()?.centres.grid().h()));
            let it = if n == 1 { "it is not meant, fill it" } else { "they are not meant, fill them" };
            let wall = hundredths(wanted.wall_mm);
            format!(
                "if {it}: no straight vent of {diameter} mm along x, y or z or square to a large flat face has room in this part with {wall} mm of \
                 wall around it"
            )
        }
        (None, n) => match (found.iter().find_map(|v| v.partly(part)), n) {
            (Some(partly), 1) => format!("if it is not meant, {partly}"),
            (Some(partly), _) => format!("where they are not meant: {partly}"),
            (None, _) => format!("if it is not meant, give it a way out of at least {} mm", short(wanted.ball_mm)),
        },
    })
}

#[cfg(test)]
mod tests {
    use super::super::bore::Leading;
    use super::super::void::Voids;
    use super::super::void::tests::{flask, part};
    use super::*;

    /// What is drilled for a sealed cube of `room` in one of `edge`, mm: a ball of 3.5 mm, a wall of 0.5 mm.
    fn drilled_into(edge: f64, room: f64, h: f64) -> Venting {
        let part = part(flask(edge, room, 0.0), h, [0.2, -0.1, 0.3]);
        let voids = Voids::of(&part).unwrap();
        let found = voids.sealed().unwrap().certain;
        let wanted = Wanted { ball_mm: 3.5, wall_mm: 0.5, leading: Leading::Anywhere };
        vents(&part, &[&found[0]], wanted).unwrap()[0]
    }

    #[test]
    fn a_vent_is_narrower_than_the_cube_by_the_wall_on_either_side() {
        // 4 mm and 2 × 0.5 mm, within a sample on either side; for the narrower ones nothing has room.
        for edge in [1.0, 4.0, 4.8] {
            assert_eq!(drilled_into(edge, 0.6 * edge, 0.05), Venting::NoRoom, "{edge}");
        }
        for edge in [5.4, 8.0, 20.0] {
            let h = (edge / 100.0f64).min(0.1);
            let Venting::Works(vent) = drilled_into(edge, 0.8 * edge, h) else { panic!("{edge}") };
            assert_eq!(vent.diameter_mm, 4.0);
            assert!((vent.wall_mm - 0.1 * edge).abs() <= h, "{vent:?}");
        }
    }

    #[test]
    fn a_vent_into_one_of_two_rooms_tells_the_room_that_stays_shut() {
        use crate::geometry::vector::bounds;
        use crate::geometry::{cuboid, extruded};
        for (passage, leaves) in [(1.0, true), (5.0, false)] {
            let (low, high) = (5.0 - 0.5 * passage, 5.0 + 0.5 * passage);
            let left = [[0.0, 0.0], [10.0, 0.0], [10.0, low], [14.0, low], [14.0, 0.0], [22.0, 0.0]];
            let right = [[22.0, 10.0], [14.0, 10.0], [14.0, high], [10.0, high], [10.0, 10.0], [0.0, 10.0]];
            let caps = [
                [0, 1, 2],
                [0, 2, 9],
                [0, 9, 10],
                [0, 10, 11],
                [2, 3, 8],
                [2, 8, 9],
                [5, 6, 7],
                [5, 7, 8],
                [5, 8, 3],
                [5, 3, 4],
            ];
            let rooms = extruded(&[left, right].concat(), &caps, 10.0);
            let (lo, hi) = bounds(rooms.vertices.iter().copied()).unwrap();
            let block = cuboid(lo.map(|c| c - 2.0), hi.map(|c| c + 2.0)).joined(&rooms.flipped());
            let part = part(block, 0.3, [0.2, -0.1, 0.3]);
            let voids = Voids::of(&part).unwrap();
            let found = voids.sealed().unwrap().certain;
            let at = voids.clearance().unwrap();
            let widest =
                (0..at.values().len()).filter(|&n| voids.is_sealed(n)).max_by_key(|&n| at.values()[n]).unwrap();
            let place = Trapped { at: voids.place(widest), ..found[0].clone() };
            let wanted = Wanted { ball_mm: 3.0, wall_mm: 0.5, leading: Leading::Anywhere };
            let venting = vents(&part, &[&place], wanted).unwrap()[0];
            let words = venting.partly(&part);
            assert_eq!(venting.vent().is_none(), leaves, "{passage}: {venting:?}");
            assert_eq!(
                words.is_some_and(|w| w.contains("a room behind it, at ")
                    && w.contains(" keeps a way out of 0")
                    && w.ends_with(" mm: give it one of its own")),
                leaves
            );
        }
    }

    #[test]
    fn a_vent_that_parts_the_part_is_none() {
        // A bar of 4 mm between two blocks; a vent of 5 mm across it would part them.
        let part = part(flask(30.0, 1.0, 0.0), 0.25, [0.0; 3]);
        let solid = part.solid().unwrap();
        let grid = *solid.centres.grid();
        let mut waisted = solid.clone();
        let middle = part.extent().map(|c| 0.5 * c);
        waisted.centres = Indicator::from_predicate(grid, |at| {
            let p = grid.position(grid.index(at));
            let beside = [0, 1].map(|a| (p[a] - middle[a]).abs());
            solid.centres.contains(grid.index(at)) && ((p[2] - middle[2]).abs() > 6.0 || beside[0].max(beside[1]) < 2.0)
        });
        let (to, way) = ([0.0, middle[1], middle[2]], [-1.0, 0.0, 0.0]);
        let across = Vent { from: middle, to, way, diameter_mm: 5.0, wall_mm: 1.0, clear_mm: 0.0 };
        let up = [0.0, 0.0, 1.0];
        let block = Vent { from: [middle[0], middle[1], 28.0], to: [middle[0], middle[1], 31.0], way: up, ..across };
        let through = Vent { from: [0.0, middle[1], middle[2]], to: [30.0, middle[1], middle[2]], ..across };
        assert_eq!(keep_the_part_whole(&waisted, &[through, block]), [false, true]);
    }
}
