//! A straight vent for a trapped volume, drilled into the sets and looked at again before it is suggested.

use super::place::reported;
use super::tooling::direction_in_file;
use super::void::{HALF_DIAGONAL, Trapped, rises, way_out};
use crate::distance::squared_distance;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::Solid;
use crate::geometry::vector::{Vec3, along, distance, dot, sub};
use crate::part::Part;
use crate::topology::{Adjacency, Chamber, Side, border, chambers, components};
use crate::units::{hundredths, short};

/// A channel along an axis from a trapped place to the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vent {
    pub from: Vec3,
    pub to: Vec3,
    /// 0, 1, 2 for x, y, z; the sign tells which way.
    pub axis: usize,
    pub upward: bool,
    pub diameter_mm: f64,
    /// Length of the material on its axis, to a sample for each piece of it.
    pub wall_mm: f64,
}

impl Vent {
    /// In words, in the frame of the file: `a straight vent of 4 mm towards +z through about 3.2 mm of material`.
    pub fn words(&self, part: &Part) -> String {
        let mut way = [0.0; 3];
        way[self.axis] = if self.upward { 1.0 } else { -1.0 };
        format!(
            "a straight vent of {} mm towards {} through about {} mm of material",
            short(self.diameter_mm),
            direction_in_file(part, way),
            short((self.wall_mm * 10.0).round() / 10.0)
        )
    }
}

/// What a vent has to be like.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// Diameter of the ball that it lets out, mm.
    pub ball_mm: f64,
    /// The wall that stays on every side of it, mm.
    pub wall_mm: f64,
    /// Whether it may go through the plate.
    pub downward: Downward,
}

/// Whether a vent may lead down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Downward {
    Allowed,
    /// The plate is there.
    Closed,
}

impl Wanted {
    /// The least multiple of half a millimetre that is wider than the ball by two samples, because the sets know it only so well.
    pub fn diameter_mm(&self, h: f64) -> f64 {
        ((self.ball_mm + 2.0 * h) * 2.0).ceil() / 2.0
    }
}

/// Lines beside a vent along which its wall is looked for.
const LINES: usize = 16;

/// The shortest of the straight vents along the axes that end outside and leave a wall around them.
pub(super) fn shortest_vent(solid: &Solid, at: Vec3, wanted: Wanted) -> Option<Vent> {
    let grid = solid.centres.grid();
    let start = grid.sample_at(at)?;
    let diameter_mm = wanted.diameter_mm(grid.h());
    let mut found: Vec<Vent> = Vec::new();
    for (axis, upward) in (0..3).flat_map(|axis| [true, false].map(|upward| (axis, upward))) {
        if axis == 2 && !upward && wanted.downward == Downward::Closed {
            continue;
        }
        let mut end = start;
        end[axis] = if upward { grid.dims()[axis] - 1 } else { 0 };
        let passed = start[axis].min(end[axis])..=start[axis].max(end[axis]);
        let wall = passed.filter(|&c| solid.centres.contains(with(start, axis, c))).count();
        if wall > 0 {
            let wall_mm = wall as f64 * grid.h();
            found.push(Vent { from: at, to: grid.position(end), axis, upward, diameter_mm, wall_mm });
        }
    }
    found.sort_by(|a, b| a.wall_mm.total_cmp(&b.wall_mm));
    found.into_iter().find(|v| leaves_a_wall(solid, v, wanted))
}

fn with(mut index: [usize; 3], axis: usize, at: usize) -> [usize; 3] {
    index[axis] = at;
    index
}

/// Whether a vent has a wall all round: a quarter, half and three quarters of the way through each piece of material on its axis,
/// everything as far beside it as the wall is thick is material. Where the plate is there a vent that reaches it is a notch in what stands on it, and needs no wall below.
fn leaves_a_wall(solid: &Solid, vent: &Vent, wanted: Wanted) -> bool {
    let grid = solid.centres.grid();
    let (u, v, beside) = ((vent.axis + 1) % 3, (vent.axis + 2) % 3, 0.5 * vent.diameter_mm + wanted.wall_mm);
    let Some(start) = grid.sample_at(vent.from) else { return false };
    let is_notch = wanted.downward == Downward::Closed && vent.from[2] <= 0.5 * vent.diameter_mm;
    let is_walled = |c: usize| {
        (0..LINES).all(|n| {
            let turn = std::f64::consts::TAU * n as f64 / LINES as f64;
            let mut at = grid.position(with(start, vent.axis, c));
            at[u] += beside * turn.cos();
            at[v] += beside * turn.sin();
            (is_notch && at[2] < 0.0) || grid.sample_at(at).is_some_and(|sample| solid.centres.contains(sample))
        })
    };
    along_walls(solid, vent, start).into_iter().all(is_walled)
}

/// Places a quarter, half and three quarters through the pieces of material on the axis of a vent, as indices along it.
fn along_walls(solid: &Solid, vent: &Vent, start: [usize; 3]) -> Vec<usize> {
    let last = solid.centres.grid().dims()[vent.axis].saturating_sub(1);
    let passed = if vent.upward { start[vent.axis]..=last } else { 0..=start[vent.axis] };
    let material: Vec<usize> = passed.filter(|&c| solid.centres.contains(with(start, vent.axis, c))).collect();
    let quarters = |piece: &[usize]| [1, 2, 3].map(|n| piece.get(n * piece.len() / 4).copied());
    material.chunk_by(|a, b| a + 1 == *b).flat_map(quarters).flatten().collect()
}

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
pub(super) fn vents(solid: &Solid, places: &[&Trapped], wanted: Wanted) -> Result<Vec<Venting>> {
    let mut found: Vec<Option<Vent>> = places.iter().map(|t| shortest_vent(solid, t.at, wanted)).collect();
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
    let solid = part.solid()?;
    let found = vents(solid, places, wanted)?;
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
            let diameter = short(wanted.diameter_mm(solid.centres.grid().h()));
            let it = if n == 1 { "it is not meant, fill it" } else { "they are not meant, fill them" };
            let wall = hundredths(wanted.wall_mm);
            format!(
                "if {it}: no straight vent of {diameter} mm along x, y or z has room in this part with {wall} mm of wall around it"
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
    use super::super::void::Voids;
    use super::super::void::tests::{flask, part};
    use super::*;

    /// What is drilled for a sealed cube of `room` in one of `edge`, mm: a ball of 3.5 mm, a wall of 0.5 mm.
    fn drilled_into(edge: f64, room: f64, h: f64) -> Venting {
        let part = part(flask(edge, room, 0.0), h, [0.2, -0.1, 0.3]);
        let voids = Voids::of(&part).unwrap();
        let found = voids.sealed().unwrap().certain;
        let wanted = Wanted { ball_mm: 3.5, wall_mm: 0.5, downward: Downward::Allowed };
        vents(voids.solid, &[&found[0]], wanted).unwrap()[0]
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
            let wanted = Wanted { ball_mm: 3.0, wall_mm: 0.5, downward: Downward::Allowed };
            let venting = vents(voids.solid, &[&place], wanted).unwrap()[0];
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
    fn a_vent_leads_the_way_of_the_file_and_leaves_the_floor_beside_it() {
        use crate::access::Up;
        use crate::geometry::cuboid;
        use crate::grid::Grid;
        use crate::units::Length;
        // A room whose wall towards +y of the file is the thinnest.
        let room = cuboid([0.0; 3], [30.0; 3]).joined(&cuboid([8.0, 14.0, 8.0], [22.0, 28.0, 22.0]).flipped());
        let ups = [Up::PlusZ, Up::Along([0.0, 0.0, -1.0]), Up::Along([1.0, 0.0, 0.0]), Up::Along([0.0, -1.0, 0.0])];
        for up in ups {
            let mut part = Part::new(room.clone(), up, 1e-6, 1.0).unwrap();
            part.cast_on(Grid::covering([0.0; 3], part.extent(), Length::mm(0.5), 1, [0.0; 3]).unwrap());
            let wanted = Wanted { ball_mm: 3.0, wall_mm: 0.5, downward: Downward::Allowed };
            let middle = part.to_build([15.0, 21.0, 15.0]);
            let vent = shortest_vent(part.solid().unwrap(), middle, wanted).unwrap();
            assert!(vent.words(&part).contains("towards +y through about 2 mm"), "{up:?}: {}", vent.words(&part));
        }
        // A cup on the plate, from just above its floor of 2 mm: a vent of 4 mm would leave a tenth of it.
        let cup = cuboid([0.0; 3], [20.0; 3]).joined(&cuboid([2.0; 3], [18.0, 18.0, 18.0]).flipped());
        let mut part = Part::new(cup, Up::PlusZ, 1e-6, 1.0).unwrap();
        part.cast_on(Grid::covering([0.0; 3], part.extent(), Length::mm(0.1), 1, [0.0; 3]).unwrap());
        let wanted = Wanted { ball_mm: 3.5, wall_mm: 0.5, downward: Downward::Closed };
        let low = shortest_vent(part.solid().unwrap(), [10.0, 10.0, 2.1], wanted).unwrap();
        assert!(low.axis == 2 && low.upward, "{low:?}");
        let high = shortest_vent(part.solid().unwrap(), [10.0, 10.0, 4.6], wanted).unwrap();
        assert!(high.axis != 2, "{high:?}");
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
        let across = Vent {
            from: middle,
            to: [0.0, middle[1], middle[2]],
            axis: 0,
            upward: false,
            diameter_mm: 5.0,
            wall_mm: 1.0,
        };
        let block = Vent {
            from: [middle[0], middle[1], 28.0],
            to: [middle[0], middle[1], 31.0],
            axis: 2,
            upward: true,
            ..across
        };
        let through = Vent { from: [0.0, middle[1], middle[2]], to: [30.0, middle[1], middle[2]], ..across };
        assert_eq!(keep_the_part_whole(&waisted, &[through, block]), [false, true]);
    }
}
