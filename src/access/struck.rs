//! What of a coaxial tool runs into a part where it would touch, and the room that it needs there.

use super::meridian::{Meridian, Outline, Piece, Role};
use super::setup::Setup;
use crate::geometry::MeshDistance;
use crate::geometry::halfspace::cut;
use crate::geometry::vector::Vec3;
use std::f64::consts::TAU;

/// Sides of the prism about a room that facets are cut by.
const SIDES: usize = 24;
/// Rooms whose radii differ by less are one, millimetres.
const SAME: f64 = 1e-6;
/// Heights are told in such steps, outwards, millimetres.
const TOLD_IN: f64 = 0.01;

/// A stretch of a tool that the part is in the way of: what it is, how wide, and between which heights above the tip.
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    pub roles: Vec<Role>,
    pub radius: f64,
    pub heights: [f64; 2],
}

impl Room {
    /// Whether the room reaches into a cube that begins so far off the axis, between two heights.
    fn reaches(&self, beside: f64, [low, high]: [f64; 2]) -> bool {
        beside < self.radius && low < self.heights[1] && high > self.heights[0]
    }
}

impl Meridian {
    /// The room that the tool takes on a straight way in along its axis: at each height as wide as what is widest below.
    fn on_its_way_in(&self) -> Meridian {
        let mut widest = (0.0f64, Role::Cutter);
        let mut pieces = Vec::new();
        for p in self.pieces() {
            let straight = |role: Role, [from, to]: [f64; 2], lower: f64, upper: f64| Piece {
                role,
                from,
                to,
                outline: Outline::Straight { lower, upper },
            };
            let (before, by) = widest;
            let own = if p.radius(p.to).max(p.radius(p.from)) > before - SAME { p.role } else { by };
            match p.outline {
                Outline::Straight { lower, upper } => {
                    let lower = lower.max(before);
                    pieces.push(straight(own, [p.from, p.to], lower, upper.max(lower)));
                }
                Outline::LowerBall { .. } if before == 0.0 => pieces.push(*p),
                Outline::Ball { radius } if before == 0.0 => {
                    let middle = (p.from + radius).min(p.to);
                    pieces.push(Piece { to: middle, outline: Outline::LowerBall { radius }, ..*p });
                    pieces.push(straight(p.role, [middle, p.to], radius, radius));
                }
                Outline::LowerBall { radius } | Outline::Ball { radius } => {
                    let wide = radius.max(before);
                    pieces.push(straight(if radius > before { p.role } else { by }, [p.from, p.to], wide, wide));
                }
            }
            let most = pieces.last().map_or(0.0, |p| p.radius(p.to));
            if most > before {
                widest = (most, p.role);
            }
        }
        Meridian::new(pieces)
    }
}

/// The rooms that a coaxial tool needs on its way straight in to a tip, in the frame of the part, where the part reaches into it by more than
/// its slack; from the tip upwards. Facets tell where they begin and end, cubes what lies between.
///
/// # Cost
/// An exact distance for each facet beside the tool, and a look at each cube that it takes.
pub fn rooms(tool: &Meridian, setup: &Setup, tip: Vec3, view: &MeshDistance) -> Vec<Room> {
    let whole = tool.on_its_way_in();
    let thin = whole.thinner(tool.slack());
    let facets = thin.facets_beside(view, (&setup.frame, setup.to_frame(tip)));
    let cubes: Vec<[f64; 2]> =
        struck_cubes(&thin, setup, tip).filter(|c| !c.met.is_empty()).map(|c| c.heights()).collect();
    let last = whole.pieces().len().saturating_sub(1);
    let mut found: Vec<Room> = Vec::new();
    for (n, piece) in whole.pieces().iter().enumerate() {
        let to = if n == last { f64::INFINITY } else { piece.to };
        let struck = facets.iter().filter(|corners| thin.piece_meets(n, corners, 0.5 * tool.slack()));
        let wide = piece.radius(piece.from).max(piece.radius(piece.to));
        let spans = struck.filter_map(|corners| span(corners, [piece.from, to], wide));
        let facets = spans.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        let Some([low, high]) = with_what_lies_within(facets, [piece.from, to], &cubes) else { continue };
        let heights = [(low / TOLD_IN).floor() * TOLD_IN, (high / TOLD_IN).ceil() * TOLD_IN];
        let radius = whole.largest_within(low - SAME, high + SAME).unwrap_or(wide).min(wide);
        match found.last_mut() {
            Some(room) if (room.radius - radius).abs() < SAME && room.heights[1] + 2.0 * TOLD_IN > heights[0] => {
                room.heights[1] = heights[1].max(room.heights[1]);
                if !room.roles.contains(&piece.role) {
                    room.roles.push(piece.role);
                }
            }
            _ => found.push(Room { roles: vec![piece.role], radius, heights }),
        }
    }
    found
}

/// The heights between which a piece of a tool is struck, from those of the facets that reach into it: what is wholly in the part before the first of them, or behind
/// the last, has none.
fn with_what_lies_within(facets: Option<[f64; 2]>, [from, to]: [f64; 2], cubes: &[[f64; 2]]) -> Option<[f64; 2]> {
    let mut own = cubes.iter().filter(|[low, high]| *low >= from && *high <= to);
    let Some([low, high]) = facets else {
        let top = own.clone().map(|c| c[1]).reduce(f64::max)?;
        return Some([from, to.min(top)]);
    };
    let before = own.clone().any(|c| c[1] < low);
    let behind = own.rfind(|c| c[0] > high);
    Some([if before { from } else { low }, behind.map_or(high, |c| if to.is_finite() { to } else { c[1] })])
}

/// The heights of what of a triangle lies between two heights and about as near to the axis as a radius.
fn span(corners: &[Vec3; 3], [lo, hi]: [f64; 2], radius: f64) -> Option<[f64; 2]> {
    let mut left = cut(&cut(corners, |p| p[2] - lo), |p| if hi.is_finite() { hi - p[2] } else { 1.0 });
    for side in 0..SIDES {
        let (sin, cos) = (TAU * side as f64 / SIDES as f64).sin_cos();
        left = cut(&left, |p| radius - cos * p[0] - sin * p[1]);
    }
    let heights = left.iter().map(|p| [p[2]; 2]);
    heights.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// Whether a coaxial tool gets straight in to a tip once a part has some rooms about its axis there: none of the cubes that lie wholly in the
/// part is in its way then, but for those that a room reaches into.
///
/// # Cost
/// A look at each cube that the tool takes.
pub fn gets_in(tool: &Meridian, setup: &Setup, tip: Vec3, rooms: &[Room]) -> bool {
    let way_in = tool.on_its_way_in().thinner(tool.slack());
    struck_cubes(&way_in, setup, tip).all(|cubes| {
        cubes.met.iter().all(|&(_, beside)| rooms.iter().any(|room| room.reaches(beside, cubes.heights())))
    })
}

/// The cubes of a layer that lie wholly in the part and that a tool reaches into.
struct Struck {
    /// That of the middle of the layer above the tip, and half of its own.
    height: f64,
    half: f64,
    /// With how far off the axis each begins.
    met: Vec<([usize; 3], f64)>,
}

impl Struck {
    fn heights(&self) -> [f64; 2] {
        [self.height - self.half, self.height + self.half]
    }
}

fn struck_cubes<'a>(tool: &'a Meridian, setup: &'a Setup, tip: Vec3) -> impl Iterator<Item = Struck> + 'a {
    let grid = setup.grid();
    let h = grid.h();
    let middle = grid.continuous_index(setup.to_frame(tip));
    let layers = (0..grid.dims()[2]).filter(move |&k| k as f64 > middle[2] - 0.5);
    layers.filter_map(move |k| {
        let z = (k as f64 - middle[2]) * h;
        let r = tool.largest_within(z - 0.5 * h, z + 0.5 * h)?;
        let span = |a: usize| {
            let (lo, hi) = ((middle[a] - r / h).floor().max(0.0), (middle[a] + r / h).ceil().max(0.0));
            lo as usize..=(hi as usize).min(grid.dims()[a] - 1)
        };
        let cubes = span(1).flat_map(|j| span(0).map(move |i| [i, j, k]));
        let met = cubes.filter_map(|index| {
            let off = [0, 1].map(|a| ((index[a] as f64 - middle[a]).abs() - 0.5).max(0.0) * h);
            let beside = off[0].hypot(off[1]);
            (beside < r && setup.inner.contains(index)).then_some((index, beside))
        });
        Some(Struck { height: z, half: 0.5 * h, met: met.collect() })
    })
}

/// The height above the tip at which a coaxial tool first strikes the part from a pose, and where, in the frame of the part.
pub fn strike(tool: &Meridian, setup: &Setup, tip: Vec3) -> Option<(f64, Vec3)> {
    let grid = setup.grid();
    let middle = grid.continuous_index(setup.to_frame(tip));
    let off = |i: [usize; 3]| (i[0] as f64 - middle[0]).hypot(i[1] as f64 - middle[1]);
    struck_cubes(tool, setup, tip).find_map(|cubes| {
        let nearest = cubes.met.iter().map(|m| m.0).min_by(|a, b| off(*a).total_cmp(&off(*b)))?;
        Some((cubes.height.max(0.0), setup.to_part(grid.position(nearest))))
    })
}

#[cfg(test)]
mod tests {
    use super::super::tool::Tool;
    use super::*;
    use crate::geometry::{InsideRule, TriangleMesh, revolved};
    use crate::process::ToolChoice;
    use crate::units::Length;

    /// A cylinder of radius 20 and height 25 mm with a bore from above.
    fn bored(radius: f64, deep: f64) -> TriangleMesh {
        let rim = [[0.0, 0.0], [20.0, 0.0], [20.0, 25.0], [radius, 25.0]];
        revolved(&[&rim[..], &[[radius, 25.0 - deep], [0.0, 25.0 - deep]]].concat(), 96)
    }

    /// The rooms that a tool needs to stand at a tip, and whether it gets in by them, and by each of them alone.
    fn needed(mesh: &TriangleMesh, tool: &str, tip: Vec3) -> (Vec<Room>, bool, Vec<bool>) {
        let tool = Tool::chosen(&ToolChoice::named(tool).unwrap()).unwrap();
        let h = Length::mm(0.4);
        let setup = Setup::cast(mesh, InsideRule::Crossings, [0.0, 0.0, 1.0], h, Length::mm(4.0)).unwrap();
        let m = tool.meridian().unwrap();
        let rooms = rooms(m, &setup, tip, &MeshDistance::new(mesh));
        let alone = rooms.iter().map(|room| gets_in(m, &setup, tip, std::slice::from_ref(room))).collect();
        let all = gets_in(m, &setup, tip, &rooms);
        (rooms, all, alone)
    }

    fn told(room: &Room) -> (Vec<Role>, f64, [i64; 2]) {
        (room.roles.clone(), (2e3 * room.radius).round() / 1e3, room.heights.map(|z| (100.0 * z).round() as i64))
    }

    #[test]
    fn only_what_collides_needs_room_and_only_where_it_does() {
        // The holder begins 20 mm above the tip: 2 mm of it are below the rim of a hole 22 mm deep that the cutter fits.
        let (rooms, all, _) = needed(&bored(3.5, 22.0), "end-mill-6", [0.0, 0.0, 3.0]);
        assert_eq!(rooms.iter().map(told).collect::<Vec<_>>(), [(vec![Role::Holder], 28.0, [2000, 2200])]);
        assert!(all && !needed(&bored(3.5, 22.0), "end-mill-6", [0.0, 0.0, 3.0]).0.is_empty());
        // A hole of 5 mm is too narrow for the cutter, and for the holder above: neither room alone is enough.
        let (rooms, all, alone) = needed(&bored(2.5, 22.0), "end-mill-6", [0.0, 0.0, 3.0]);
        let want = [(vec![Role::Cutter, Role::Neck], 6.0, [0, 2000]), (vec![Role::Holder], 28.0, [2000, 2200])];
        assert_eq!(rooms.iter().map(told).collect::<Vec<_>>(), want);
        assert!(all && alone == [false, false], "{all} {alone:?}");
        // The cone of a tap at a wall 0.25 mm above the floor reaches 1.75 mm into that: the hole has to be as much deeper.
        let (rooms, all, _) = needed(&bored(1.5, 12.0), "tap-m3", [0.0, 0.0, 11.25]);
        assert_eq!(rooms.iter().map(told).collect::<Vec<_>>(), [(vec![Role::Cutter], 2.85, [0, 175])]);
        assert!(all);
        // A tap fits the hole of its own diameter, whatever its facets leave of that.
        assert_eq!(needed(&bored(1.5, 12.0), "tap-m3", [0.0, 0.0, 13.0]).0, []);
    }

    #[test]
    fn what_narrows_upwards_needs_room_for_its_widest_on_its_way_in() {
        // The ball of 2 mm does not pass the bore of 1.6 mm that its stem fits.
        let (rooms, all, _) = needed(&bored(0.8, 9.0), "touch-probe", [0.0, 0.0, 16.0]);
        let [room] = &rooms[..] else { panic!("{rooms:?}") };
        assert_eq!((room.roles.as_slice(), 2.0 * room.radius, room.heights[1]), (&[Role::Cutter][..], 2.0, 9.0));
        assert!(all);
    }
}
