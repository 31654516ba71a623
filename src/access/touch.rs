//! Whether a coaxial tool touches a piece of the surface while all of it keeps clear of the part, exactly.

use super::meridian::{Meridian, lies_flat};
use super::placed::{InTheWay, Placed, ways};
use super::pose::{Rotation, transposed};
use super::setup::Setup;
use super::station::Station;
use super::surface::Patch;
use super::tool::Tool;
use crate::geometry::MeshDistance;
use crate::geometry::distance::Nearest;
use crate::geometry::vector::{Vec3, add, along, distance, dot, sub};
use std::cell::{OnceCell, RefCell};

/// What reaches into a tool by no more than this is not in its way, millimetres; of a thin one by no more than a share of its radius.
const SLACK: f64 = 0.05;
const SHARE: f64 = 0.05;
/// How far towards the middle of a patch its corners are asked, as a share of the way: on an edge two faces meet.
const INWARDS: f64 = 0.02;
/// How exactly it is told how far a tool is drawn back, millimetres.
const KEEPS_OFF: f64 = 1e-3;
/// Facets whose normals have a lower cosine are of two walls.
const ACROSS: f64 = 0.9;

impl Meridian {
    /// The largest radius of each piece, each once, in increasing order.
    fn radii(&self) -> Vec<f64> {
        let mut all: Vec<f64> = self.pieces().iter().filter_map(|p| self.largest_within(p.from, p.to)).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }

    /// What may reach into the tool and is not in its way.
    pub(super) fn slack(&self) -> f64 {
        SLACK.min(SHARE * self.cutter_radius())
    }
}

impl Station<'_> {
    /// The tip from which a coaxial tool touches the middle of a patch, if it touches its corners as well, each from a pose where all of the tool, thinner
    /// by its slack, keeps clear of the part. One that does not widen upwards has to get there from a `free` tip, straight.
    ///
    /// A flat end covers a place of a level patch from where it stands clear of the two walls nearest to it.
    ///
    /// # Cost
    /// A few looks at poses for each of the four points.
    pub(super) fn touches(
        &self,
        patch: &Patch,
        free: Option<Vec3>,
        (view, placed): (&MeshDistance, &Placed),
        before: &mut InTheWay,
    ) -> Option<Vec3> {
        let before = RefCell::new(before);
        let thin = self.thin()?;
        let radii = self.tool().meridian().map_or(Vec::new(), Meridian::radii);
        let wide = radii.iter().copied().fold(0.0, f64::max) + self.slack();
        let walls = OnceCell::new();
        let free = free.map(|tip| self.frame().map(|row| dot(row, tip)));
        let straight = thin.widens_upwards();
        let all_clear = |tips: &[Vec3]| {
            let clear = |tips: &[Vec3]| placed.is_clear((thin, 0.5 * self.slack()), tips, &mut before.borrow_mut());
            clear(tips) && (straight || free.is_some_and(|free| clear(&ways(tips, free, self.slack()))))
        };
        let is_clear = |tip: &Vec3| all_clear(&[*tip]);
        let touching = |at: Vec3| {
            let [here, normal] = [at, patch.normal].map(|v| self.frame().map(|row| dot(row, v)));
            match self.tool().flat_end().filter(|_| lies_flat(normal)) {
                Some(end) => {
                    let walls = || walls.get_or_init(|| walls_near(patch, view, wide));
                    let middle = sub(here, [0.0, 0.0, end.height]);
                    let beside = || covering((end.flat, &radii), self.frame(), walls(), sub(at, patch.at)).into_iter();
                    let beside = || beside().map(|aside| add(middle, aside)).find(is_clear);
                    Some(middle).filter(is_clear).or_else(beside)
                }
                None => self.contacts(normal).into_iter().map(|contact| sub(here, contact)).find(is_clear),
            }
        };
        let corners = patch.corners.map(|c| along(c, sub(patch.at, c), INWARDS));
        let back = transposed(*self.frame());
        let to_part = |tip: Vec3| back.map(|row| dot(row, tip));
        let normal = self.frame().map(|row| dot(row, patch.normal));
        let is_flat = self.tool().flat_end().is_some() && lies_flat(normal);
        if let (false, [contact]) = (is_flat, &self.contacts(normal)[..]) {
            // From one pose each: all at once.
            let [a, b, c] = corners;
            let tips = [patch.at, a, b, c].map(|at| sub(self.frame().map(|row| dot(row, at)), *contact));
            return all_clear(&tips).then(|| to_part(tips[0]));
        }
        let tip = touching(patch.at)?;
        corners.into_iter().all(|at| touching(at).is_some()).then(|| to_part(tip))
    }

    fn slack(&self) -> f64 {
        self.tool().meridian().map_or(SLACK, Meridian::slack)
    }
}

/// The two walls nearest to a patch, within a distance: their outward normals, and how far its middle lies from their planes. They are of facets that are not of
/// its plane.
pub(super) fn walls_near(patch: &Patch, view: &MeshDistance, within: f64) -> Vec<(Vec3, f64)> {
    let is_other = |f: u32, n: Vec3| dot(view.normal(f), n) < ACROSS;
    let told = |n: Nearest| (view.normal(n.facet), dot(view.normal(n.facet), sub(patch.at, n.point)));
    let first = view.nearest_where(patch.at, within, |f, _| is_other(f, patch.normal)).map(told);
    let Some(first) = first else { return Vec::new() };
    let second = view.nearest_where(patch.at, within, |f, _| is_other(f, patch.normal) && is_other(f, first.0));
    std::iter::once(first).chain(second.map(told)).collect()
}

/// How far a coaxial tool that widens upwards is drawn back along its axis, exactly, from a tip in the part's frame, if there is one, or, if that is less, from where its flat end covers the
/// middle of a level patch clear of its walls, and that tip; `None` if not within so much. What keeps it off by less than 1e-3 mm does not, nor do sides by less than its slack.
///
/// # Cost
/// A few dozen looks at poses.
pub fn drawn_back(
    tool: &Tool,
    setup: &Setup,
    patch: &Patch,
    tip: Option<Vec3>,
    within: f64,
    view: &MeshDistance,
) -> Option<(f64, Vec3)> {
    let meridian = tool.meridian().filter(|m| m.widens_upwards())?;
    let [here, normal] = [setup.to_frame(patch.at), setup.frame.map(|row| dot(row, patch.normal))];
    let mut tips: Vec<Vec3> = tip.into_iter().map(|tip| setup.to_frame(tip)).collect();
    if let Some(end) = tool.flat_end().filter(|_| lies_flat(normal)) {
        let middle = sub(here, [0.0, 0.0, end.height]);
        let radii = meridian.radii();
        let walls = walls_near(patch, view, radii.iter().copied().fold(0.0, f64::max));
        tips.push(middle);
        tips.extend(
            covering((end.flat, &radii), &setup.frame, &walls, [0.0; 3]).into_iter().map(|aside| add(middle, aside)),
        );
    }
    let least = |less: f64| {
        let thin = meridian.thinner(less);
        let is_clear =
            |tip: Vec3, by: f64| thin.is_clear(view, (&setup.frame, add(tip, [0.0, 0.0, by])), meridian.slack());
        tips.iter().fold(None, |best: Option<(f64, Vec3)>, &tip| {
            let mut between = [0.0, best.map_or(within, |b| b.0)];
            if !is_clear(tip, between[1]) {
                return best;
            }
            // The wider the way up, the clearer: it widens upwards.
            while between[1] - between[0] > KEEPS_OFF {
                let middle = 0.5 * (between[0] + between[1]);
                between[usize::from(is_clear(tip, middle))] = middle;
            }
            Some((between[1], tip))
        })
    };
    // Thinner by its slack it is shorter by as much; that counts where its sides are what does not pass.
    let (exact, slack) = (least(KEEPS_OFF), meridian.slack());
    let passing = least(slack).map(|(by, tip)| (by + slack, tip));
    let passing = passing.filter(|p| exact.is_none_or(|e| p.0 < e.0 - 2.0 * slack));
    passing.or(exact).map(|(by, tip)| (by, setup.to_part(tip)))
}

/// How far aside of a tip, in the frame of the part, a coaxial tool stands clear of it, but for its slack: off the walls nearest to the patch that it would touch from
/// there by as much as its cutter is wide. What has room there is kept from the patch by the shape of its end, and not by how wide it is.
///
/// # Cost
/// A few looks at poses.
pub fn clear_aside(tool: &Tool, setup: &Setup, patch: &Patch, tip: Vec3, view: &MeshDistance) -> Option<f64> {
    let meridian = tool.meridian()?;
    let thin = meridian.thinner(meridian.slack());
    let (here, tip) = (setup.to_frame(patch.at), setup.to_frame(tip));
    let radius = meridian.cutter_radius();
    let walls = walls_near(patch, view, radius);
    let poses = covering((f64::INFINITY, &[radius]), &setup.frame, &walls, [0.0; 3]);
    let poses = poses.into_iter().map(|aside| [here[0] + aside[0], here[1] + aside[1], tip[2]]);
    let clear = poses.filter(|pose| thin.is_clear(view, (&setup.frame, *pose), 0.5 * meridian.slack()));
    clear.map(|pose| distance(pose, tip)).min_by(f64::total_cmp)
}

/// Where the middle of a flat end may stand beside a place that it is to cover, `moved` from where the walls are told for: off each wall by as much as a piece of the tool is
/// wide, and off both; in a frame whose rows are given, the walls in that of the part.
fn covering((flat, radii): (f64, &[f64]), frame: &Rotation, walls: &[(Vec3, f64)], moved: Vec3) -> Vec<Vec3> {
    let upright: Vec<([f64; 2], f64)> = walls
        .iter()
        .filter_map(|&(normal, off)| {
            let [x, y, _] = frame.map(|row| dot(row, normal));
            let (level, off) = (x.hypot(y), off + dot(normal, moved));
            (level > 0.5).then(|| ([x / level, y / level], off / level))
        })
        .collect();
    let mut found: Vec<[f64; 2]> = Vec::new();
    for radius in radii {
        let by = |off: f64| (radius - off).max(0.0);
        found.extend(upright.iter().map(|&(n, off)| n.map(|c| c * by(off))));
        if let [(m, a), (n, b), ..] = upright[..] {
            let (turn, a, b) = (m[0] * n[1] - m[1] * n[0], by(a), by(b));
            if turn.abs() > 1e-6 {
                found.push([(a * n[1] - b * m[1]) / turn, (b * m[0] - a * n[0]) / turn]);
            }
        }
    }
    found.retain(|[x, y]| x.hypot(*y) <= flat * (1.0 + 1e-9));
    found.into_iter().map(|[x, y]| [x, y, 0.0]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::reach::{State, Touching, reach};
    use super::super::surface::patches;
    use super::*;
    use crate::geometry::union::united;
    use crate::geometry::{InsideRule, TriangleMesh, cuboid};
    use crate::units::Length;

    fn mill(diameter: f64, length: f64, holder: f64) -> Tool {
        let text = format!(
            "[[piece]]\nrole = \"cutter\"\ndiameter_mm = {diameter}\nlength_mm = {length}\n[[piece]]\nrole = \"holder\"\n\
             diameter_mm = {holder}\nlength_mm = 30\n"
        );
        Tool::from_toml("mill", &text, |_| Ok(TriangleMesh::default())).unwrap()
    }

    /// What cannot be touched for certain and what may be so, of the patches that are wanted, from one direction at a spacing.
    fn missed(mesh: &TriangleMesh, tool: Tool, up: Vec3, h: f64, wanted: impl Fn(&Patch) -> bool) -> [f64; 2] {
        let h = Length::mm(h);
        let setup = Setup::cast(mesh, InsideRule::Crossings, up, h, Length::mm(4.0)).unwrap();
        let surface: Vec<Patch> = patches(mesh, 2.0 * h.as_mm(), |_| true).into_iter().filter(wanted).collect();
        let stand_off = 2.0 * 3f64.sqrt() * h.as_mm();
        let found =
            reach(&surface, &[tool], &[&setup], (Touching::Exactly, stand_off), &MeshDistance::new(mesh), |_| false)
                .unwrap();
        let area = |wanted: fn(&State) -> bool| {
            surface.iter().zip(&found.states).filter(|(_, s)| wanted(s)).map(|(p, _)| p.area).sum::<f64>()
        };
        let never = area(|s| *s == State::Unreachable);
        [never, never + area(|s| matches!(s, State::Open | State::Near(_)))]
    }

    /// A block of 60 × 40 × 12 mm with a pocket of 40 × 20 mm, 4 mm deep.
    fn pocketed() -> TriangleMesh {
        let frame = [
            cuboid([0.0, 0.0, 8.0], [60.0, 10.0, 12.0]),
            cuboid([0.0, 30.0, 8.0], [60.0, 40.0, 12.0]),
            cuboid([0.0, 10.0, 8.0], [10.0, 30.0, 12.0]),
            cuboid([50.0, 10.0, 8.0], [60.0, 30.0, 12.0]),
        ];
        let parts = frame.into_iter().fold(cuboid([0.0; 3], [60.0, 40.0, 8.0]), |all, one| all.joined(&one));
        united(&parts, 1e-6).expect("one solid")
    }

    fn turned(mesh: &TriangleMesh, turn: f64) -> (TriangleMesh, [Vec3; 3]) {
        let (s, c) = turn.sin_cos();
        // About x, then as much about z.
        let rows = [[c, -s * c, s * s], [s, c * c, -c * s], [0.0, s, c]];
        let mut mesh = mesh.transformed(rows, [3.3, -1.7, 0.4]);
        // As an STL file rounds.
        mesh.vertices.iter_mut().flatten().for_each(|x| *x = f64::from(*x as f32));
        (mesh, rows)
    }

    #[test]
    fn what_a_holder_keeps_a_cutter_from_lies_in_the_bracket_however_coarse_the_lattice() {
        // A cutter of 4 mm that looks 1 mm out of a holder of 10 mm: on the floor the holder needs room of 3 mm beside it.
        let (part, tool) = (pocketed(), mill(4.0, 1.0, 10.0));
        let floor = |p: &Patch| p.normal[2] > 0.9 && (p.at[2] - 8.0).abs() < 1e-9;
        let inner = |by: f64| (40.0 - 2.0 * by) * (20.0 - 2.0 * by);
        let round = (4.0 - std::f64::consts::PI) * 4.0;
        let truth = 800.0 - (inner(3.0) - round);
        for h in [0.4, 0.8, 1.6] {
            let [low, high] = missed(&part, tool.clone(), [0.0, 0.0, 1.0], h, floor);
            assert!(low <= truth && truth <= high, "{h}: {low} {high} of {truth}");
            // Along the line: a patch that is touched in part, of two spacings, one as wide that may be, and what cubes hide.
            assert!(high - low < 7.0 * h * 2.0 * 60.0, "{h}: {low} {high} of {truth}");
        }
    }

    #[test]
    fn a_wall_is_touched_as_far_down_as_the_cutter_is_long_however_the_part_lies() {
        // 10 mm of 25 below the rim, past which a wider holder does not go.
        let (block, truth) = (cuboid([0.0; 3], [30.0, 30.0, 25.0]), 30.0 * 15.0);
        for turn in [0.0, 0.5, 1.1, 2.3] {
            let (part, rows) = turned(&block, turn);
            let up = rows.map(|row| row[2]);
            for side in [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]] {
                let normal = rows.map(|row| dot(row, side));
                let [low, high] = missed(&part, mill(4.0, 10.0, 20.0), up, 0.4, |p| dot(p.normal, normal) > 0.99);
                assert!(low <= truth && truth <= high, "{turn} {side:?}: {low} {high} of {truth}");
                assert!(high - low < 30.0 * 4.0, "{turn} {side:?}: {low} {high}");
            }
        }
    }

    #[test]
    fn a_floor_is_touched_up_to_its_walls_and_corners_by_what_is_thin() {
        let floor = |p: &Patch| p.normal[2] > 0.9 && (p.at[2] - 8.0).abs() < 1e-9;
        let (part, up) = (pocketed(), [0.0, 0.0, 1.0]);
        // What the round of the cutter leaves in four corners.
        let corners = (4.0 - std::f64::consts::PI) * 4.0;
        let [low, high] = missed(&part, mill(4.0, 20.0, 4.0), up, 0.4, floor);
        assert!(low <= corners && corners <= high && high < 4.0 * 4.0 * 4.0, "{low} {high} of {corners}");
    }

    #[test]
    fn a_tool_is_drawn_back_as_far_as_its_holder_stands_off_exactly() {
        let (part, h) = (pocketed(), Length::mm(1.6));
        let view = MeshDistance::new(&part);
        let setup = Setup::cast(&part, InsideRule::Crossings, [0.0, 0.0, 1.0], h, Length::mm(4.0)).unwrap();
        // The holder stands on the rim, 4 mm above the floor, within 3 mm of the walls; a cutter of 4 mm covers what is beside a wall and a corner from 2 mm off.
        for ([x, y], short) in
            [([20.0, 15.9], 0.0), ([20.0, 14.5], 0.0), ([20.0, 13.1], 0.0), ([20.0, 10.5], 3.0), ([11.0, 11.0], 3.0)]
        {
            let at = [x, y, 8.0];
            let patch = Patch { corners: [at; 3], at, normal: [0.0, 0.0, 1.0], area: 1.0, radius: 0.0, facet: 0 };
            let (told, tip) = drawn_back(&mill(4.0, 1.0, 10.0), &setup, &patch, Some(at), 9.0, &view).unwrap();
            assert!((told - short).abs() < 2e-3, "{x} {y}: {told} of {short}");
            assert!(distance(tip, at) <= 2.0 + 1e-9 && (tip[2] - 8.0).abs() < 1e-9, "{x} {y}: {tip:?}");
        }
    }
}
