//! Straight channels from a place inside a part to the outside.

use super::tooling::direction_in_file;
use super::void::HALF_DIAGONAL;
use crate::access::{flat_face_normals, square_to};
use crate::geometry::Solid;
use crate::geometry::vector::{Vec3, along, angle};
use crate::part::Part;
use crate::units::short;
use std::cell::OnceCell;

/// A channel from a trapped place to the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vent {
    pub from: Vec3,
    pub to: Vec3,
    /// Where it leads, of length 1.
    pub way: Vec3,
    pub diameter_mm: f64,
    /// Length of the material on its axis, to a sample for each piece of it.
    pub wall_mm: f64,
    /// Length of its axis before the first piece of material.
    pub clear_mm: f64,
}

impl Vent {
    /// The same from where it enters material, so that nothing of the room that it leads out of is cut.
    pub fn starting_at_its_wall(self) -> Self {
        Vent { from: along(self.from, self.way, self.clear_mm), clear_mm: 0.0, ..self }
    }

    /// In words, in the frame of the file: `a straight vent of 4 mm towards +z through about 3.2 mm of material`.
    pub fn words(&self, part: &Part) -> String {
        format!(
            "a straight vent of {} mm towards {} through about {} mm of material",
            short(self.diameter_mm),
            direction_in_file(part, self.way),
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
    pub leading: Leading,
}

/// Where a vent may lead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Leading {
    Anywhere,
    /// Not down to the plate, which closes what leads there.
    OffThePlate,
    /// Not down to the plate, and not steeply up: what is above is not there yet while a cup sucks.
    Sideways,
}

impl Wanted {
    /// The least multiple of half a millimetre that is wider than the ball by two samples, because the sets know it only so well.
    pub fn diameter_mm(&self, h: f64) -> f64 {
        self.wider_by(2.0 * h)
    }

    /// The same off the axes: wider by four half diagonals, since there neither the middles of the ball lie on its axis nor the cubes
    /// that are left beside it.
    fn slanting_mm(&self, h: f64) -> f64 {
        self.wider_by(4.0 * HALF_DIAGONAL * h)
    }

    fn wider_by(&self, by: f64) -> f64 {
        ((self.ball_mm + by) * 2.0).ceil() / 2.0
    }
}

/// Lines beside a vent along which its wall is looked for.
const LINES: usize = 16;
/// The cosine of the slope of a surface that a vent may lead through (60°).
const SLOPE: f64 = 0.5;
/// What is nearer to a vent than this share of the wall that it has to leave is too near: less is rounding.
const NEARER: f64 = 1.0 - 1e-6;
/// A vent that leads up more than this is steep, the sine of 45°.
const STEEP: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Directions closer than this, in radians, are one.
const SAME: f64 = 1e-3;
const ALONG_AXES: [Vec3; 6] =
    [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];

/// The directions in which vents may lead.
pub(super) struct Ways<'a> {
    part: &'a Part,
    faces: OnceCell<Vec<Vec3>>,
}

impl<'a> Ways<'a> {
    /// Those of a part: along the axes, and out of its largest flat faces.
    pub fn of(part: &'a Part) -> Self {
        Ways { part, faces: OnceCell::new() }
    }

    /// Out of the part's largest flat faces, where that is not along an axis.
    fn out_of_faces(&self) -> &[Vec3] {
        let slanting = |n: &Vec3| !is_along_axis(*n);
        self.faces.get_or_init(|| {
            let normals = flat_face_normals(self.part.mesh(), &|f| self.part.bounds_solid(f));
            normals.into_iter().filter(slanting).collect()
        })
    }

    /// The shortest of the straight vents along the axes that end outside and leave a wall around them; where none does, of those
    /// that lead out of a flat face.
    ///
    /// # Cost
    /// A line of samples for each direction, and [`LINES`] beside its pieces of material until one has a wall.
    pub fn shortest(&self, solid: &Solid, at: Vec3, wanted: Wanted) -> Option<Vent> {
        let along = |ways: &[Vec3]| {
            let mut bores: Vec<Bore> = ways.iter().filter_map(|way| Bore::of(solid, at, *way, wanted)).collect();
            bores.sort_by(|a, b| a.vent.wall_mm.total_cmp(&b.vent.wall_mm));
            let keeps = |bore: &Bore| bore.leaves_a_wall() && bore.keeps_its_distance(self.part);
            bores.into_iter().find(keeps).map(|bore| bore.vent)
        };
        along(&ALONG_AXES).or_else(|| along(self.out_of_faces()))
    }
}

fn is_along_axis(way: Vec3) -> bool {
    ALONG_AXES.iter().any(|a| angle(*a, way) <= SAME)
}

/// A vent that is tried: samples on its axis, as far apart as those of the grid.
struct Bore<'a> {
    solid: &'a Solid,
    wanted: Wanted,
    vent: Vent,
    /// Steps from the middle of the first sample at which there is material.
    material: Vec<usize>,
}

impl<'a> Bore<'a> {
    /// The vent along a direction, where it leads out through material, and may lead there.
    fn of(solid: &'a Solid, from: Vec3, way: Vec3, wanted: Wanted) -> Option<Self> {
        let grid = solid.centres.grid();
        let first = grid.position(grid.sample_at(from)?);
        let on_axis = |n: usize| grid.sample_at(along(first, way, n as f64 * grid.h()));
        let end = (0..).take_while(|&n| on_axis(n).is_some()).last()?;
        let leads_down = way[2] < 0.0 && on_axis(end)?[2] == 0;
        let may_lead = match wanted.leading {
            Leading::Anywhere => true,
            Leading::OffThePlate => !leads_down,
            Leading::Sideways => !leads_down && way[2] <= STEEP,
        };
        if !may_lead {
            return None;
        }
        let is_material = |n: &usize| on_axis(*n).is_some_and(|sample| solid.centres.contains(sample));
        let material: Vec<usize> = (0..=end).filter(is_material).collect();
        let to = along(first, way, end as f64 * grid.h());
        let diameter_mm = if is_along_axis(way) { wanted.diameter_mm(grid.h()) } else { wanted.slanting_mm(grid.h()) };
        let clear_mm = material.first().map_or(0.0, |&n| n as f64 * grid.h() - 0.5 * grid.h());
        let wall_mm = material.len() as f64 * grid.h();
        let vent = Vent { from, to, way, diameter_mm, wall_mm, clear_mm: clear_mm.max(0.0) };
        (!material.is_empty()).then_some(Bore { solid, wanted, vent, material })
    }

    /// Whether it has a wall all round: on every line as far beside it as the wall is thick there is material along half of each piece of
    /// material on its axis, or more, without a gap. Where walls are round or slant they begin and end elsewhere beside it than on it.
    /// Where the plate is there a vent that reaches it is a notch in what stands on it, and needs no wall below.
    fn leaves_a_wall(&self) -> bool {
        let (grid, vent) = (self.solid.centres.grid(), &self.vent);
        let Some(first) = grid.sample_at(vent.from).map(|sample| grid.position(sample)) else { return false };
        let [u, v] = square_to(vent.way);
        let beside = 0.5 * vent.diameter_mm + self.wanted.wall_mm;
        let is_notch = self.wanted.leading == Leading::Sideways && vent.from[2] <= 0.5 * vent.diameter_mm;
        let is_wall = |at: Vec3| {
            let is_material = || grid.sample_at(at).is_some_and(|sample| self.solid.centres.contains(sample));
            (is_notch && at[2] < 0.0) || is_material()
        };
        let is_walled = |piece: &[usize]| {
            (0..LINES).all(|line| {
                let (sin, cos) = (std::f64::consts::TAU * line as f64 / LINES as f64).sin_cos();
                let start = along(along(first, u, beside * cos), v, beside * sin);
                let mut run = 0;
                piece.iter().any(|&n| {
                    run = if is_wall(along(start, vent.way, n as f64 * grid.h())) { run + 1 } else { 0 };
                    2 * run >= piece.len()
                })
            })
        };
        self.material.chunk_by(|a, b| a + 1 == *b).all(is_walled)
    }

    /// Whether the surface of the part comes nowhere nearer to its side than the wall is thick, but about the ends of the material beside it, as
    /// far as a slope of 60° there reaches: a room or a face that runs along it leaves it no wall.
    fn keeps_its_distance(&self, part: &Part) -> bool {
        let (grid, vent, wall) = (self.solid.centres.grid(), &self.vent, self.wanted.wall_mm);
        let Some(first) = grid.sample_at(vent.from).map(|sample| grid.position(sample)) else { return false };
        let [u, v] = square_to(vent.way);
        let radius = 0.5 * vent.diameter_mm;
        let is_notch = self.wanted.leading == Leading::Sideways && vent.from[2] <= radius;
        let is_material = |at: Vec3| grid.sample_at(at).is_some_and(|sample| self.solid.centres.contains(sample));
        let is_near = |at: Vec3| part.distance().nearest(at, NEARER * wall).is_some();
        let ends = (wall / SLOPE / grid.h()).ceil() as usize;
        (0..LINES).all(|line| {
            let (sin, cos) = (std::f64::consts::TAU * line as f64 / LINES as f64).sin_cos();
            let start = along(along(first, u, radius * cos), v, radius * sin);
            let beside = |n: usize| along(start, vent.way, n as f64 * grid.h());
            let inside: Vec<usize> = self.material.iter().copied().filter(|&n| is_material(beside(n))).collect();
            inside.chunk_by(|a, b| a + 1 == *b).all(|run| {
                let deep = run.get(ends..run.len().saturating_sub(ends)).unwrap_or_default();
                deep.iter().map(|&n| beside(n)).all(|at| (is_notch && at[2] < wall) || !is_near(at))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::Up;
    use crate::geometry::{Primitive, TriangleMesh, cuboid};
    use crate::grid::Grid;
    use crate::units::Length;

    fn cast(mesh: TriangleMesh, up: Up, h: f64) -> Part {
        let mut part = Part::new(mesh, up, 1e-6, 1.0).unwrap();
        part.cast_on(Grid::covering([0.0; 3], part.extent(), Length::mm(h), 1, [0.0; 3]).unwrap());
        part
    }

    fn shortest(part: &Part, at: Vec3, wanted: Wanted) -> Option<Vent> {
        Ways::of(part).shortest(part.solid().unwrap(), at, wanted)
    }

    #[test]
    fn a_vent_leads_the_way_of_the_file_and_leaves_the_floor_beside_it() {
        // A room whose wall towards +y of the file is the thinnest.
        let room = cuboid([0.0; 3], [30.0; 3]).joined(&cuboid([8.0, 14.0, 8.0], [22.0, 28.0, 22.0]).flipped());
        let ups = [Up::PlusZ, Up::Along([0.0, 0.0, -1.0]), Up::Along([1.0, 0.0, 0.0]), Up::Along([0.0, -1.0, 0.0])];
        for up in ups {
            let part = cast(room.clone(), up, 0.5);
            let wanted = Wanted { ball_mm: 3.0, wall_mm: 0.5, leading: Leading::Anywhere };
            let middle = part.to_build([15.0, 21.0, 15.0]);
            let vent = shortest(&part, middle, wanted).unwrap();
            assert!(vent.words(&part).contains("towards +y through about 2 mm"), "{up:?}: {}", vent.words(&part));
        }
        // A room whose floor is its thinnest wall, and the plate below that.
        let room = cuboid([0.0; 3], [30.0; 3]).joined(&cuboid([8.0, 8.0, 2.0], [22.0, 22.0, 20.0]).flipped());
        let part = cast(room, Up::PlusZ, 0.5);
        let towards = |leading| {
            let vent = shortest(&part, [15.0, 15.0, 11.0], Wanted { ball_mm: 3.0, wall_mm: 0.5, leading });
            vent.unwrap().words(&part)
        };
        assert!(towards(Leading::Anywhere).contains("towards -z"), "{}", towards(Leading::Anywhere));
        assert!(!towards(Leading::OffThePlate).contains("towards -z"), "{}", towards(Leading::OffThePlate));
        // A cup on the plate, from just above its floor of 2 mm: a vent of 4 mm would leave a tenth of it.
        let cup = cuboid([0.0; 3], [20.0; 3]).joined(&cuboid([2.0; 3], [18.0, 18.0, 18.0]).flipped());
        let part = cast(cup, Up::PlusZ, 0.1);
        let wanted = Wanted { ball_mm: 3.5, wall_mm: 0.5, leading: Leading::Sideways };
        assert_eq!(shortest(&part, [10.0, 10.0, 2.1], wanted), None);
        let high = shortest(&part, [10.0, 10.0, 4.6], wanted).unwrap();
        assert_eq!(high.way[2], 0.0, "{high:?}");
    }

    /// Walls of 3 mm about a room, and a vent of 4 mm with as much around it: along an axis that is not square to them these begin too far
    /// up or down beside it.
    #[test]
    fn a_round_wall_has_room_for_a_vent_along_an_axis() {
        // A ball of 14 mm with a wall of 2 mm: 2.7 mm beside the axis the wall begins 0.8 mm lower than on it.
        let ball = |radius: f64| Primitive::Ball { radius: Length::mm(radius) }.mesh(Length::mm(0.02));
        let hollow = ball(7.0).joined(&ball(5.0).flipped());
        for h in [0.1, 0.2] {
            let part = cast(hollow.clone(), Up::PlusZ, h);
            let wanted = |wall_mm: f64| Wanted { ball_mm: 3.5, wall_mm, leading: Leading::Anywhere };
            let vent = shortest(&part, part.to_build([0.0; 3]), wanted(0.7)).unwrap();
            assert!(vent.diameter_mm == 4.0 && (vent.wall_mm - 2.0).abs() <= 2.0 * h, "{vent:?}");
            // Nothing of it is left 5 mm beside the axis: there is no such wall.
            assert_eq!(shortest(&part, part.to_build([0.0; 3]), wanted(3.0)), None);
        }
    }

    #[test]
    fn no_vent_runs_along_a_face_with_less_than_a_wall_beside_it() {
        // Through 12 mm below a room; a slot beside 2 mm of that way leaves 0.3 mm.
        let room =
            cuboid([0.0; 3], [40.0, 40.0, 44.0]).joined(&cuboid([14.0, 14.0, 12.0], [26.0, 26.0, 26.0]).flipped());
        let wanted = Wanted { ball_mm: 3.0, wall_mm: 1.0, leading: Leading::Anywhere };
        let slot = |near: f64| cuboid([22.0 + near, 10.0, 3.0], [38.0, 30.0, 5.0]).flipped();
        for (near, down) in [(0.3, false), (1.6, true)] {
            let part = cast(room.clone().joined(&slot(near)), Up::PlusZ, 0.25);
            let vent = shortest(&part, part.to_build([20.0, 20.0, 19.0]), wanted).unwrap();
            assert_eq!(vent.words(&part).contains("towards -z"), down, "{near}: {}", vent.words(&part));
        }
    }

    #[test]
    fn where_no_axis_has_room_a_vent_leads_out_of_a_face() {
        let room = cuboid([0.0; 3], [30.0; 3]).joined(&cuboid([3.0; 3], [27.0, 27.0, 26.0]).flipped());
        let wanted = Wanted { ball_mm: 3.0, wall_mm: 3.0, leading: Leading::Anywhere };
        for (up, slanting) in [([1.0, 0.0, 1.0], false), ([0.4, -0.5, 0.6], true), ([0.3, 0.8, -0.4], true)] {
            let part = cast(room.clone(), Up::Along(up), 0.25);
            let vent = shortest(&part, part.to_build([15.0, 15.0, 14.5]), wanted).unwrap();
            let words = vent.words(&part);
            assert!((vent.wall_mm - 3.0).abs() <= 1.3, "{up:?}: {words}");
            assert_eq!(!is_along_axis(vent.way), slanting, "{up:?}: {words}");
            // Square to a face, in the frame of the file it leads along an axis.
            assert!(["+x", "-x", "+y", "-y", "+z", "-z"].iter().any(|way| words.contains(&format!("towards {way} "))));
        }
    }
}
