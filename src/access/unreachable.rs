//! Which patches no pose of a list can touch, for certain.
//!
//! All tips at which a tool touches a patch lie in a few [`Tips`]; where the tool overlaps the part for certain in every cell
//! that they meet, it cannot touch the patch. Whether a tool can get there is another question, and not asked.

use super::meridian::{Meridian, level_and_rise};
use super::setup::Setup;
use super::stack::{Sense, Stack};
use super::station::Station;
use super::surface::Patch;
use super::tool::Tool;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, sub};
use rayon::prelude::*;
use std::borrow::Cow;

/// The patches, of those that are open, that no listed tool touches anywhere in any setup or at any rotation.
///
/// # Errors
/// As [`Station::surely_hits_of`].
///
/// # Cost
/// One dilation for each tool and setup, or rotation, while any patch is left.
pub(super) fn unreachable(
    patches: &[Patch],
    open: Vec<usize>,
    stations: &[(usize, usize, Station)],
    setups: &[&Setup],
) -> Result<Vec<usize>> {
    let mut left = open;
    for (_, s, station) in stations {
        if left.is_empty() {
            break;
        }
        left = match station.tool().meridian() {
            Some(m) => untouched_by_coaxial(m, station.tool(), setups[*s], patches, left)?,
            None => untouched_by_points(station, setups[0], patches, left)?,
        };
    }
    Ok(left)
}

fn untouched_by_coaxial(
    m: &Meridian,
    tool: &Tool,
    setup: &Setup,
    patches: &[Patch],
    left: Vec<usize>,
) -> Result<Vec<usize>> {
    let sharp = &tool.sharp;
    let surely = Stack::surely(m, setup.grid().spacing());
    let surely = surely.dilate(with_room_for_tips(m, &setup.inner)?.as_ref(), Sense::Obstacle);
    let convex = m.cutter_is_convex();
    let untouched = |p: &usize| {
        let patch = &patches[*p];
        let [at, normal] = [patch.at, patch.normal].map(|v| setup.to_frame(v));
        if m.widens_upwards() && normal[2] < -1e-3 {
            // It has nothing that looks up.
            return true;
        }
        let tips = if !sharp.is_empty() {
            sharp.iter().map(|s| Tips::of_ring(at, s.at_mm[0].hypot(s.at_mm[1]), s.at_mm[2], patch.radius)).collect()
        } else if convex {
            m.support_of(at, normal, patch.radius).into_iter().collect()
        } else {
            Tips::of_surface(m, at, setup.grid().h(), patch.radius)
        };
        !tips.is_empty() && tips.iter().all(|t| t.are_blocked(&surely))
    };
    Ok(left.into_par_iter().with_max_len(64).filter(untouched).collect())
}

/// The set on a grid that also holds the tips, far below it, of a tool that touches with the upper end of its cutter.
fn with_room_for_tips<'a>(m: &Meridian, set: &'a Indicator) -> Result<Cow<'a, Indicator>> {
    if m.widens_upwards() {
        return Ok(Cow::Borrowed(set));
    }
    let below = (m.cutter_length() / set.grid().h()).ceil() as usize + 2;
    let [x, y, z] = set.grid().dims();
    Ok(Cow::Owned(set.window([0, 0, -(below as isize)], [x, y, z + below])?))
}

/// A tool of any shape is meant to touch with its sharp points only.
fn untouched_by_points(station: &Station, setup: &Setup, patches: &[Patch], left: Vec<usize>) -> Result<Vec<usize>> {
    let tips = |p: usize| {
        let corners = patches[p].corners.map(|c| setup.to_frame(c));
        let points = station.contacts(setup.to_frame(patches[p].normal));
        points.into_iter().map(move |point| Tips::of_point(corners, point))
    };
    let half = 0.5 * setup.grid().h();
    let around = |t: Tips| [t.low.map(|c| c - half), t.high.map(|c| c + half)];
    let boxes: Vec<[Vec3; 2]> = left.iter().flat_map(|&p| tips(p).map(around)).collect();
    let Some(surely) = station.surely_hits_of(setup.inner_descent(), &boxes)? else { return Ok(Vec::new()) };
    Ok(left.into_par_iter().with_max_len(64).filter(|&p| tips(p).all(|t| t.are_blocked(&surely))).collect())
}

/// Where tips may be: the points of a box, millimetres, that lie between two distances from a vertical.
#[derive(Debug, Clone, Copy)]
struct Tips {
    low: Vec3,
    high: Vec3,
    vertical: [f64; 2],
    between: [f64; 2],
}

impl Tips {
    /// The tips at which one point of a tool lies in a triangle.
    fn of_point(corners: [Vec3; 3], point: Vec3) -> Self {
        let end = |pick: fn(f64, f64) -> f64| {
            [0, 1, 2].map(|a| corners.iter().map(|c| c[a] - point[a]).reduce(pick)).map(|v| v.unwrap_or(0.0))
        };
        Tips { low: end(f64::min), high: end(f64::max), vertical: [0.0; 2], between: [0.0, f64::INFINITY] }
    }

    /// The tips at which some point of a circle about the axis lies within `slack` of a point.
    fn of_ring(at: Vec3, radius: f64, height: f64, slack: f64) -> Self {
        Tips::of_shell(at, [radius; 2], [height; 2], slack)
    }

    /// The tips at which some point between two radii and two heights lies within `slack` of a point.
    fn of_shell(at: Vec3, radii: [f64; 2], heights: [f64; 2], slack: f64) -> Self {
        let wide = radii[1] + slack;
        Tips {
            low: [at[0] - wide, at[1] - wide, at[2] - heights[1] - slack],
            high: [at[0] + wide, at[1] + wide, at[2] - heights[0] + slack],
            vertical: [at[0], at[1]],
            between: [radii[0] - slack, wide],
        }
    }

    /// The tips at which any point of a cutter's surface lies within `slack` of a point: pieces of its height a spacing high,
    /// those of the same radii together.
    fn of_surface(m: &Meridian, at: Vec3, h: f64, slack: f64) -> Vec<Self> {
        let layers = (m.cutter_length() / h).ceil().max(1.0) as usize;
        let mut shells: Vec<([f64; 2], [f64; 2])> = Vec::new();
        for k in 0..layers {
            let heights = [k as f64 * h, (k + 1) as f64 * h];
            let Some(radii) = m.surface_between(heights[0], heights[1]) else { continue };
            match shells.last_mut() {
                Some((same, joined)) if *same == radii => joined[1] = heights[1],
                _ => shells.push((radii, heights)),
            }
        }
        shells.into_iter().map(|(radii, heights)| Tips::of_shell(at, radii, heights, slack)).collect()
    }

    /// Whether every cell that holds one of them is in the set; what lies outside its grid is not.
    fn are_blocked(&self, set: &Indicator) -> bool {
        let grid = set.grid();
        let (low, high) = (grid.continuous_index(self.low), grid.continuous_index(self.high));
        let dims = grid.dims();
        let range = |a: usize| {
            let (first, last) = ((low[a] - 0.5).ceil(), (high[a] + 0.5).floor());
            (first >= 0.0 && last < dims[a] as f64).then_some(first as usize..=last as usize)
        };
        let (Some(x), Some(y), Some(z)) = (range(0), range(1), range(2)) else { return false };
        let middle = grid.continuous_index([self.vertical[0], self.vertical[1], 0.0]);
        // A cell reaches further than its middle by at most half its diagonal.
        let [least, most] = self.between.map(|b| b / grid.h());
        let counts = |i: usize, j: usize| {
            let beside = (i as f64 - middle[0]).hypot(j as f64 - middle[1]);
            beside >= least - 0.75 && beside <= most + 0.75
        };
        y.into_iter().all(|j| x.clone().filter(|&i| counts(i, j)).all(|i| z.clone().all(|k| set.contains([i, j, k]))))
    }
}

impl Meridian {
    /// The tips at which a convex cutter touches a plane of this normal within `slack` of a point.
    fn support_of(&self, at: Vec3, normal: Vec3, slack: f64) -> Option<Tips> {
        let [level, rise] = level_and_rise(normal);
        let s = self.support(level, rise)?;
        let slack = slack + s.radius * 2e-3;
        if s.flat > 0.0 {
            return Some(Tips::of_shell(at, [0.0, s.flat], [s.height; 2], slack));
        }
        let outwards = if level > 0.0 { [-normal[0] / level, -normal[1] / level] } else { [0.0; 2] };
        let flank = if self.widens_upwards() { s.height } else { s.flank.max(s.height) };
        let touching = [outwards[0] * s.radius, outwards[1] * s.radius, s.height];
        let tip = sub(at, touching);
        let low = [tip[0] - slack, tip[1] - slack, tip[2] - slack - (flank - s.height)];
        Some(Tips { low, high: tip.map(|c| c + slack), vertical: [0.0; 2], between: [0.0, f64::INFINITY] })
    }
}

#[cfg(test)]
mod tests {
    use super::super::pose::{Rotation, axis_directions, axis_rotations, lattice_directions};
    use super::super::reach::{State, Touching, reach};
    use super::super::surface::patches;
    use super::super::tool::SharpPoint;
    use super::*;
    use crate::geometry::vector::{add, dot, scale};
    use crate::geometry::{InsideRule, MeshDistance, Primitive, TriangleMesh};
    use crate::process::ToolChoice;
    use crate::units::Length;

    const H: Length = Length::mm(0.25);
    const STAND_OFF: f64 = 0.25 * 2.0 * 1.732_050_807_568_877_2;

    type Block = [Vec3; 2];

    fn boxes(list: &[Block]) -> TriangleMesh {
        let one = |[lo, hi]: &Block| {
            let size = sub(*hi, *lo);
            let text = format!("box:{}x{}x{}mm", size[0], size[1], size[2]);
            let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            Primitive::parse(&text).unwrap().mesh(H).transformed(still, scale(add(*lo, *hi), 0.5))
        };
        list.iter().map(one).reduce(|a, b| a.joined(&b)).unwrap()
    }

    /// A hook without any symmetry: a shaft, a foot to one side and a toe to another, which is meant to touch with its end.
    const HOOK: [Block; 3] = [
        [[-1.0, -1.0, 0.0], [1.0, 1.0, 24.0]],
        [[-1.0, -1.0, 0.0], [5.0, 1.0, 2.0]],
        [[3.0, -1.0, 0.0], [5.0, 3.0, 1.5]],
    ];
    const TOE: Vec3 = [4.0, 3.0, 0.75];

    fn hook() -> Tool {
        let sharp = vec![SharpPoint { name: "toe".into(), at_mm: TOE }];
        Tool::from_mesh("hook", boxes(&HOOK), sharp).unwrap()
    }

    /// Areas reached, unreachable and open among the wanted patches, and the patches that are unreachable.
    fn judged(mesh: &TriangleMesh, tool: Tool, up: &[Vec3], wanted: impl Fn(&Patch) -> bool) -> ([f64; 3], Vec<Patch>) {
        let cast = |&d: &Vec3| Setup::cast(mesh, InsideRule::Winding, d, H, Length::mm(4.0)).unwrap();
        let setups: Vec<Setup> = up.iter().map(cast).collect();
        let surface = patches(mesh, 0.5, |_| true);
        let list: Vec<&Setup> = setups.iter().collect();
        let found =
            reach(&surface, &[tool], &list, (Touching::Exactly, STAND_OFF), &MeshDistance::new(mesh), |_| false)
                .unwrap();
        let (mut areas, mut never) = ([0.0; 3], Vec::new());
        for (p, state) in surface.iter().zip(&found.states).filter(|(p, _)| wanted(p)) {
            let kind = match state {
                State::Reached(_) => 0,
                State::Unreachable => 1,
                State::Open | State::Near(_) => 2,
            };
            areas[kind] += p.area;
            if kind == 1 {
                never.push(*p);
            }
        }
        (areas, never)
    }

    #[test]
    fn a_closed_cavity_is_reached_from_nowhere_by_a_hook_and_the_outside_everywhere() {
        let ball = |r: &str| Primitive::parse(r).unwrap().mesh(Length::mm(0.02));
        let hollow = ball("ball:9mm").joined(&ball("ball:5mm").flipped());
        let inside = |p: &Patch| p.at.iter().map(|x| x * x).sum::<f64>() < 36.0;
        let ([reached, never, open], _) = judged(&hollow, hook(), &axis_directions(), inside);
        assert!(reached == 0.0 && open == 0.0 && never > 300.0, "{reached} {never} {open}");
        let ([reached, never, open], _) =
            judged(&boxes(&[[[-6.0; 3], [6.0, 7.0, 8.0]]]), hook(), &axis_directions(), |_| true);
        assert!(never == 0.0 && open == 0.0 && reached > 900.0, "{reached} {never} {open}");
    }

    #[test]
    fn the_floor_of_a_slot_narrower_than_the_toe_is_out_of_reach_and_that_of_a_wider_one_is_not() {
        // A slot along x, 6 mm deep.
        let slotted = |half: f64| {
            boxes(&[
                [[-10.0, -9.0, -4.0], [10.0, 9.0, 0.0]],
                [[-10.0, -9.0, 0.0], [10.0, -half, 6.0]],
                [[-10.0, half, 0.0], [10.0, 9.0, 6.0]],
            ])
        };
        let floor = |p: &Patch| p.normal[2] > 0.9 && p.at[2].abs() < 1e-6 && p.at[1].abs() < 0.4 && p.at[0].abs() < 6.0;
        let ([reached, never, open], _) = judged(&slotted(0.5), hook(), &axis_directions(), floor);
        assert!(reached == 0.0 && open == 0.0 && never > 8.0, "{reached} {never} {open}");
        let ([reached, never, open], _) = judged(&slotted(6.0), hook(), &axis_directions(), floor);
        assert!(never == 0.0 && open == 0.0 && reached > 8.0, "{reached} {never} {open}");
    }

    /// Whether two sets of open boxes overlap, the second turned by a rotation of the axes and moved.
    fn overlap(part: &[Block], tool: &[Block], turn: Rotation, tip: Vec3) -> bool {
        tool.iter().any(|b| {
            let ends = b.map(|p| add(turn.map(|row| dot(row, p)), tip));
            part.iter()
                .any(|a| (0..3).all(|i| ends[0][i].min(ends[1][i]) < a[1][i] && a[0][i] < ends[0][i].max(ends[1][i])))
        })
    }

    #[test]
    fn at_whatever_is_unreachable_every_touching_pose_overlaps_the_part() {
        let mut state = 11u64;
        let mut random = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        let mut seen = 0;
        for _ in 0..3 {
            let part: Vec<Block> = (0..7)
                .map(|_| {
                    let lo = [0; 3].map(|_| 10.0 * random());
                    [lo, lo.map(|x| x + 1.5 + 6.0 * random())]
                })
                .collect();
            let (_, never) = judged(&boxes(&part), hook(), &axis_directions(), |_| true);
            for p in never {
                seen += 1;
                let (s, t) = (random(), random());
                let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                let [a, b, c] = p.corners;
                let x = add(a, add(scale(sub(b, a), s), scale(sub(c, a), t)));
                for turn in axis_rotations() {
                    let tip = sub(x, turn.map(|row| dot(row, TOE)));
                    assert!(overlap(&part, &HOOK, turn, tip), "{x:?} is touched at {turn:?}");
                }
            }
        }
        assert!(seen > 500, "{seen}");
    }

    /// A cylinder of radius 10 and height 20 mm with a bore of radius 3 mm, 12 mm deep from above.
    fn cup() -> TriangleMesh {
        crate::geometry::revolved(&[[0.0, 0.0], [10.0, 0.0], [10.0, 20.0], [3.0, 20.0], [3.0, 8.0], [0.0, 8.0]], 96)
    }

    fn coaxial(text: &str) -> Tool {
        Tool::chosen(&ToolChoice { name: "mine".into(), text: text.into(), mesh: None }).unwrap()
    }

    const SHORT: &str = "[[piece]]\nrole = \"cutter\"\ndiameter_mm = 3\nlength_mm = 6\n[[piece]]\nrole = \"holder\"\n\
                         diameter_mm = 12\nlength_mm = 30\n";

    #[test]
    fn a_named_circle_of_a_coaxial_tool_and_a_stepped_cutter_are_decided_too() {
        let deep = |p: &Patch| p.at[0].hypot(p.at[1]) < 3.1 && p.at[2] < 13.0 && p.at[2] > 7.9;
        // The step of the second touches first, 3 mm above its tip, which comes down to 14 mm.
        let mouth =
            |p: &Patch| p.normal[2].abs() < 0.1 && p.at[0].hypot(p.at[1]) < 3.1 && (17.5..19.0).contains(&p.at[2]);
        let named = format!("{SHORT}[[sharp]]\nname = \"rim\"\nat_mm = [0.0, 1.5, 0.0]\n");
        let stepped = "[[piece]]\nrole = \"cutter\"\ndiameter_mm = 2\nlength_mm = 3\n[[piece]]\nrole = \"cutter\"\n\
                       diameter_mm = 4\nlength_mm = 3\n[[piece]]\nrole = \"holder\"\ndiameter_mm = 12\nlength_mm = 30\n";
        for text in [named.as_str(), stepped] {
            let ([reached, never, open], _) = judged(&cup(), coaxial(text), &lattice_directions()[..1], deep);
            assert!(reached == 0.0 && never > 100.0 && open < 0.15 * never, "{reached} {never} {open}: {text}");
            let ([reached, never, open], _) = judged(&cup(), coaxial(text), &lattice_directions()[..1], mouth);
            assert!(never == 0.0 && open == 0.0 && reached > 25.0, "{reached} {never} {open}: {text}");
        }
    }
}
