//! What of a surface the tools of a list can touch from the directions of a list.

use super::meridian::Meridian;
use super::placed::{InTheWay, Placed};
use super::setup::Setup;
use super::station::{Stand, Station};
use super::surface::Patch;
use super::tool::Tool;
use super::touch::walls_near;
use super::unreachable::unreachable;
use crate::error::{Error, Result, ToolFault};
use crate::geometry::MeshDistance;
use crate::geometry::vector::{Vec3, add, dot, unit};
use rayon::prelude::*;

/// A tool and a direction of the lists, by which a patch is reached or nearly reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standing {
    pub tool: usize,
    /// Index in the list of setups.
    pub setup: usize,
    pub tip: Vec3,
}

/// How a coaxial tool has to come to a patch to reach it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Touching {
    /// It touches its middle and its corners from poses where all of it, thinner by its slack, keeps clear of every facet: dear for large tools on large meshes.
    Exactly,
    /// It comes within the stand-off of its middle, free, with nothing in between.
    WithinStandOff,
}

/// What is known of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum State {
    /// A tool comes to it as is asked; one of any shape within the stand-off.
    Reached(Standing),
    /// A coaxial tool comes within the stand-off, and none was found to touch all of it as is asked.
    Near(Standing),
    /// No listed tool touches any point of it from any listed direction.
    Unreachable,
    /// The spacing does not tell.
    Open,
}

/// The states of all patches, and how near the tools come to those that are not reached.
#[derive(Debug, Clone, PartialEq)]
pub struct Reach {
    pub states: Vec<State>,
    /// For patches that are not reached: how far the best tool stops short along its axis, and which.
    pub short: Vec<Option<(f64, Standing)>>,
    /// For those that are not shut off: how far the best tool is from touching where it is free beside, if that is less. A round end stays away from the
    /// foot of a wall, however far up it is drawn back along that.
    pub beside: Vec<Option<(f64, Standing)>>,
    /// Setups that were looked at before all was reached.
    pub setups_used: usize,
}

impl Reach {
    /// How far the best tool is from touching a patch that is not reached, and which.
    pub fn stops(&self, patch: usize) -> Option<(f64, Standing)> {
        self.beside.get(patch).copied().flatten().or(*self.short.get(patch)?)
    }
}

/// What tools can touch of patches of a part's surface.
///
/// A coaxial tool comes to a patch as `touching` asks, one of any shape within the stand-off, since a contact is never certain on a lattice: poses
/// there are certified free of every cube that the part touches. Unreachable is exact about contact: for a convex cutter the tips that touch a plane are known,
/// and a patch is unreachable if at all of them the tool overlaps cubes that lie wholly in the part, in every setup. Patches that
/// are `shut_off`, on the walls of a void that is closed all round, are unreachable for that, and only how far the tools stop short of them is asked.
///
/// # Errors
/// [`Error::Tool`] without any setup, or for a cutter larger than the part.
///
/// # Cost
/// Two dilations of the part's bits for each tool and setup, four times as many for a tool of any shape, and a few dozen samples for each patch.
pub fn reach(
    patches: &[Patch],
    tools: &[Tool],
    setups: &[&Setup],
    (touching, stand_off): (Touching, f64),
    view: &MeshDistance,
    shut_off: impl Fn(&Patch) -> bool,
) -> Result<Reach> {
    if setups.is_empty() {
        let tool = tools.first().map_or("list", |t| t.name.as_str()).to_string();
        return Err(Error::Tool { tool, fault: ToolFault::NoDirections });
    }
    let mut found = Reach {
        states: vec![State::Open; patches.len()],
        short: vec![None; patches.len()],
        beside: vec![None; patches.len()],
        setups_used: 0,
    };
    let (shut, mut open): (Vec<usize>, Vec<usize>) = (0..patches.len()).partition(|&p| shut_off(&patches[p]));
    let mut stations: Vec<(usize, usize, Station)> = Vec::new();
    for (s, setup) in setups.iter().enumerate() {
        if open.is_empty() && shut.is_empty() {
            break;
        }
        found.setups_used = s + 1;
        let exactly = touching == Touching::Exactly && tools.iter().any(|t| t.meridian().is_some());
        let placed = (exactly && !open.is_empty()).then(|| Placed::of(view, &setup.frame));
        for (t, tool) in tools.iter().enumerate() {
            for station in Station::all(tool, setups[0], setup) {
                let station = station?;
                let axis = station.axis();
                let look = Look { station: &station, by: (t, s), stand_off, view, placed: placed.as_ref() };
                let known = &found.states;
                let looked: Vec<(usize, State)> = open
                    .par_chunks(256)
                    .flat_map_iter(|some| {
                        let mut before = InTheWay::default();
                        let at = |&p: &usize| match may_touch(tool, &patches[p], axis) {
                            true => (p, look.at(&patches[p], known[p], &mut before)),
                            false => (p, known[p]),
                        };
                        some.iter().map(at).collect::<Vec<_>>()
                    })
                    .collect();
                looked.iter().for_each(|&(p, state)| found.states[p] = state);
                open.retain(|&p| !matches!(found.states[p], State::Reached(_)));
                stations.push((t, s, station));
            }
        }
    }
    let missed = [&shut[..], &open[..]].concat();
    nearest(patches, &missed, &stations, &mut found);
    nearest_beside((patches, view), (&open, stand_off), &stations, &mut found);
    for p in shut.into_iter().chain(unreachable(patches, open, &stations, setups)?) {
        found.states[p] = State::Unreachable;
    }
    Ok(found)
}

/// A station from which patches are looked at.
struct Look<'a> {
    station: &'a Station<'a>,
    /// Its tool and its setup.
    by: (usize, usize),
    stand_off: f64,
    view: &'a MeshDistance,
    /// The part's facets before the tool, where it has to touch exactly.
    placed: Option<&'a Placed<'a>>,
}

impl Look<'_> {
    /// What is known of a patch now that was known so far.
    fn at(&self, patch: &Patch, so_far: State, before: &mut InTheWay) -> State {
        let (tool, setup) = self.by;
        let by = |tip| Standing { tool, setup, tip };
        let exact = self.station.tool().meridian().zip(self.placed);
        // What can be drawn out needs no free pose beside to get there.
        let drawn_out = exact.filter(|(m, _)| m.widens_upwards());
        if let Some((_, placed)) = drawn_out {
            if let Some(tip) = self.station.touches(patch, None, (self.view, placed), before) {
                return State::Reached(by(tip));
            }
            if so_far != State::Open {
                return so_far;
            }
        }
        let Some(Stand { tip, .. }) = self.station.stand(patch, self.stand_off, self.view) else { return so_far };
        let mut touches = |placed| self.station.touches(patch, Some(tip), (self.view, placed), before).is_some();
        let reached = exact.is_none_or(|(_, placed)| drawn_out.is_none() && touches(placed));
        if reached { State::Reached(by(tip)) } else { State::Near(by(tip)) }
    }
}

/// Whether a tool can touch a patch at all that it comes to along an axis: one that widens upwards has nothing that looks up.
fn may_touch(tool: &Tool, patch: &Patch, axis: Vec3) -> bool {
    tool.meridian().is_none_or(|m| !m.widens_upwards() || dot(patch.normal, axis) > -1e-3)
}

/// How far the tools stop short of what is not reached.
fn nearest(patches: &[Patch], missed: &[usize], stations: &[(usize, usize, Station)], found: &mut Reach) {
    let mut best: Vec<Option<(f64, Standing)>> = vec![None; missed.len()];
    for (tool, setup, station) in stations.iter().take_while(|_| !missed.is_empty()) {
        let (axis, rise) = (station.axis(), station.rise());
        let nearer = |(best, &p): (&mut Option<(f64, Standing)>, &usize)| {
            let patch = &patches[p];
            if may_touch(station.tool(), patch, axis) {
                let below = best.map_or(f64::INFINITY, |b| b.0);
                let nearer = station.retreat(patch, below, rise.as_ref());
                *best = nearer.map(|(short, tip)| (short, Standing { tool: *tool, setup: *setup, tip })).or(*best);
            }
        };
        best.par_iter_mut().zip(missed).for_each(nearer);
    }
    missed.iter().zip(best).for_each(|(&p, short)| found.short[p] = short);
}

/// How far the tools are from touching what is not reached where they are free beside it, with those that are nearer so.
fn nearest_beside(
    (patches, view): (&[Patch], &MeshDistance),
    (missed, stand_off): (&[usize], f64),
    stations: &[(usize, usize, Station)],
    found: &mut Reach,
) {
    let radii = stations.iter().filter_map(|(.., s)| s.tool().meridian()).map(Meridian::cutter_radius);
    let near = radii.fold(0.0, f64::max) + stand_off;
    let walls: Vec<Vec<Vec3>> = missed.par_iter().map(|&p| walls_beside(&patches[p], view, near)).collect();
    let mut best: Vec<Option<(f64, Standing)>> = vec![None; missed.len()];
    for (tool, setup, station) in stations.iter().take_while(|_| !missed.is_empty()) {
        let (axis, rise) = (station.axis(), station.rise());
        let nearer = |best: &mut Option<(f64, Standing)>, p: usize, walls: &[Vec3]| {
            let patch = &patches[p];
            let below = best.or(found.short[p]).map_or(f64::INFINITY, |b| b.0);
            if may_touch(station.tool(), patch, axis) {
                let off = station.off_beside(patch, walls, below, rise.as_ref());
                *best = off.map(|(off, tip)| (off, Standing { tool: *tool, setup: *setup, tip })).or(*best);
            }
        };
        best.par_iter_mut().zip(missed).zip(&walls).for_each(|((best, &p), walls)| nearer(best, p, walls));
    }
    missed.iter().zip(best).for_each(|(&p, beside)| found.beside[p] = beside);
}

/// The normals of the two walls nearest to a patch, and the way off both.
fn walls_beside(patch: &Patch, view: &MeshDistance, within: f64) -> Vec<Vec3> {
    match walls_near(patch, view, within)[..] {
        [(first, _), (second, _), ..] => vec![first, second, unit(add(first, second))],
        [(first, _)] => vec![first],
        [] => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::pose::{axis_directions, lattice_directions};
    use super::super::struck::strike;
    use super::super::surface::patches;
    use super::*;
    use crate::geometry::{InsideRule, Primitive, TriangleMesh, revolved};
    use crate::units::Length;

    const H: Length = Length::mm(0.25);
    /// Twice √3 spacings: what a contact needs on a lattice.
    const STAND_OFF: f64 = 0.25 * 2.0 * 1.732_050_807_568_877_2;

    /// A pin with a holder of 12 mm.
    fn pin(diameter: f64, length: f64) -> Tool {
        let text = format!(
            "[[piece]]\nrole = \"cutter\"\ndiameter_mm = {diameter}\nlength_mm = {length}\n[[piece]]\nrole = \"holder\"\n\
             diameter_mm = 12\nlength_mm = 30\n"
        );
        Tool::from_toml("pin", &text, |_| Ok(TriangleMesh::default())).unwrap()
    }

    struct Judged {
        patches: Vec<Patch>,
        reach: Reach,
    }

    impl Judged {
        fn new(mesh: &TriangleMesh, tool: Tool, directions: &[Vec3]) -> Self {
            let cast = |&d: &Vec3| Setup::cast(mesh, InsideRule::Crossings, d, H, Length::mm(4.0)).unwrap();
            let setups: Vec<Setup> = directions.iter().map(cast).collect();
            let patches = patches(mesh, 0.5, |_| true);
            let list: Vec<&Setup> = setups.iter().collect();
            let reach =
                reach(&patches, &[tool], &list, (Touching::Exactly, STAND_OFF), &MeshDistance::new(mesh), |_| false)
                    .unwrap();
            Judged { patches, reach }
        }

        /// Areas reached, unreachable and open among the patches that are wanted.
        fn areas(&self, wanted: impl Fn(&Patch) -> bool) -> [f64; 3] {
            let mut areas = [0.0; 3];
            for (p, state) in self.patches.iter().zip(&self.reach.states).filter(|(p, _)| wanted(p)) {
                areas[match state {
                    State::Reached(_) => 0,
                    State::Unreachable => 1,
                    State::Open | State::Near(_) => 2,
                }] += p.area;
            }
            areas
        }
    }

    /// A cylinder of radius 10 and height 20 mm with a bore of radius 3 mm, 12 mm deep from above.
    fn cup() -> TriangleMesh {
        revolved(&[[0.0, 0.0], [10.0, 0.0], [10.0, 20.0], [3.0, 20.0], [3.0, 8.0], [0.0, 8.0]], 96)
    }

    fn floor(p: &Patch) -> bool {
        p.normal[2] > 0.9 && p.at[2] < 9.0
    }

    fn bore(p: &Patch, from: f64, to: f64) -> bool {
        p.normal[2].abs() < 0.1 && p.at[0].hypot(p.at[1]) < 4.0 && (from..to).contains(&p.at[2])
    }

    #[test]
    fn a_blind_hole_is_reached_as_deep_as_the_tool_is_long() {
        let up = &axis_directions()[..1];
        let long = Judged::new(&cup(), pin(3.0, 16.0), up);
        let [reached, never, open] = long.areas(|p| floor(p) && p.at[0].hypot(p.at[1]) < 2.0);
        assert!(reached > 10.0 && never == 0.0 && open == 0.0, "{reached} {never} {open}");
        let short = Judged::new(&cup(), pin(3.0, 6.0), up);
        let [reached, never, _] = short.areas(floor);
        let area = std::f64::consts::PI * 9.0;
        assert!(reached == 0.0 && never > 0.95 * area, "{reached} {never}");
        // The holder stops at the rim, so the tip stops 6 mm short of the floor; a step, a cube, half the lattice.
        for (p, short) in short.patches.iter().zip(&short.reach.short).filter(|(p, _)| floor(p)) {
            let middle = p.at[0].hypot(p.at[1]) < 1.0;
            let (by, _) = short.unwrap();
            assert!(!middle || (by - 6.0).abs() <= 0.25 * (0.5 + 1.0 + 1.0), "{by}");
        }
        // Walls: the upper 6 mm can be touched, the rest not; two spacings on either side stay open.
        let [reached, never, _] = short.areas(|p| bore(p, 15.0, 19.0));
        assert!(never == 0.0 && reached > 60.0, "{reached} {never}");
        let [reached, never, open] = short.areas(|p| bore(p, 8.5, 13.0));
        assert!(reached == 0.0 && never > 70.0 && open == 0.0, "{reached} {never} {open}");
        // What keeps the pin from them is the holder, 6 mm above its tip.
        let setup = Setup::cast(&cup(), InsideRule::Crossings, up[0], H, Length::mm(4.0)).unwrap();
        let tool = pin(3.0, 6.0);
        for (n, p) in short.patches.iter().enumerate().filter(|(_, p)| bore(p, 9.0, 13.0)) {
            let (_, standing) = short.reach.stops(n).unwrap();
            let (height, _) = strike(tool.meridian().unwrap(), &setup, standing.tip).unwrap();
            assert!(height > 5.5, "{height} {p:?}");
        }
    }

    #[test]
    fn a_round_end_stops_short_of_the_foot_of_a_wall_by_no_more_than_it_is_wide() {
        // A pocket of radius 10 mm, 9 mm deep, and a ball of 6 mm.
        let pan = revolved(&[[0.0, 0.0], [14.0, 0.0], [14.0, 14.0], [10.0, 14.0], [10.0, 5.0], [0.0, 5.0]], 96);
        let text = "[[piece]]\nrole = \"cutter\"\nshape = \"ball-end\"\ndiameter_mm = 6\nlength_mm = 30\n";
        let ball = Tool::from_toml("ball", text, |_| Ok(TriangleMesh::default())).unwrap();
        let judged = Judged::new(&pan, ball, &axis_directions()[..1]);
        let within = |p: &Patch| p.at[0].hypot(p.at[1]) < 10.01 && p.at[2] > 4.9;
        let mut missed = 0;
        for (n, p) in judged.patches.iter().enumerate().filter(|(_, p)| within(p)) {
            if let Some((by, _)) = judged.reach.stops(n) {
                // Two samples more to the side, and a step and a cube up.
                assert!(by <= (3.0 + 2.0 * 0.25f64).hypot(2.0 * 0.25), "{by} {p:?}");
                missed += 1;
            }
        }
        assert!(missed > 100, "{missed}");
    }

    #[test]
    fn a_tool_wider_than_the_hole_touches_nothing_in_it() {
        let wide = Judged::new(&cup(), pin(9.0, 30.0), &axis_directions());
        let [reached, never, _] = wide.areas(|p| floor(p) || bore(p, 8.0, 17.0));
        assert!(reached == 0.0 && never > 170.0, "{reached} {never}");
        let [reached, never, _] = wide.areas(|p| p.at[0].hypot(p.at[1]) > 9.9);
        assert!(never == 0.0 && reached > 1200.0);
    }

    #[test]
    fn an_undercut_is_reached_from_the_side_and_not_from_above() {
        let profile =
            [[0.0, 0.0], [10.0, 0.0], [10.0, 5.0], [4.0, 5.0], [4.0, 15.0], [10.0, 15.0], [10.0, 20.0], [0.0, 20.0]];
        let spool = revolved(&profile, 96);
        let groove = |p: &Patch| p.at[0].hypot(p.at[1]) < 8.0 && (5.5..14.5).contains(&p.at[2]);
        let all = axis_directions();
        let above = Judged::new(&spool, pin(3.0, 9.0), &all[..2]);
        let [reached, never, _] = above.areas(groove);
        assert!(reached == 0.0 && never > 200.0, "{reached} {never}");
        let side = Judged::new(&spool, pin(3.0, 9.0), &all);
        // Beside the middle the flat end would strike the core before it is deep enough, and the corners are round: only what
        // lies away from them is compared.
        let middle = |p: &Patch| groove(p) && p.at[1].abs() < 0.5 && p.at[0] > 3.9;
        let walls = |p: &Patch| (p.normal[2].abs() < 0.1 && (7.0..13.0).contains(&p.at[2])) || p.at[0] > 5.0;
        let [reached, never, _] = side.areas(|p| middle(p) && walls(p));
        assert!(never == 0.0 && reached > 5.0, "{reached} {never}");
        let stand = side.patches.iter().zip(&side.reach.states).find(|(p, _)| middle(p) && walls(p));
        let Some((_, State::Reached(by))) = stand else { panic!("{stand:?}") };
        assert_eq!(all[by.setup], [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_closed_cavity_is_reached_from_nowhere() {
        let ball = |r: &str| Primitive::parse(r).unwrap().mesh(Length::mm(0.02));
        let hollow = ball("ball:9mm").joined(&ball("ball:5mm").flipped());
        let judged = Judged::new(&hollow, pin(1.0, 40.0), &lattice_directions());
        let [reached, never, open] = judged.areas(|p| p.at.iter().map(|x| x * x).sum::<f64>() < 36.0);
        assert!(reached == 0.0 && open == 0.0 && never > 300.0, "{reached} {never} {open}");
        let [reached, never, _] = judged.areas(|p| p.at.iter().map(|x| x * x).sum::<f64>() > 36.0);
        assert!(never == 0.0 && reached > 950.0, "{reached} {never}");
    }

    #[test]
    fn directions_and_sizes_that_make_no_sense_are_errors() {
        let mesh = cup();
        let view = MeshDistance::new(&mesh);
        let none = reach(&[], &[pin(3.0, 6.0)], &[], (Touching::Exactly, STAND_OFF), &view, |_| false).unwrap_err();
        assert!(matches!(none, Error::Tool { fault: ToolFault::NoDirections, .. }));
    }

    #[test]
    fn what_strikes_first_is_named() {
        let setup = Setup::cast(&cup(), InsideRule::Crossings, [0.0, 0.0, 1.0], H, Length::mm(4.0)).unwrap();
        let tool = pin(3.0, 6.0);
        let (height, at) = strike(tool.meridian().unwrap(), &setup, [0.0, 0.0, 8.0]).unwrap();
        assert!((height - 6.0).abs() <= 0.5 && (at[2] - 14.0).abs() < 0.5, "{height} {at:?}");
    }

    #[test]
    fn what_is_shut_off_is_unreachable_and_nothing_else_changes() {
        let mesh = Primitive::parse("box:6x6x4mm").unwrap().mesh(Length::mm(1.0));
        let cast = |&d: &Vec3| Setup::cast(&mesh, InsideRule::Crossings, d, H, Length::mm(4.0)).unwrap();
        let setups: Vec<Setup> = axis_directions().iter().map(cast).collect();
        let (list, surface): (Vec<&Setup>, _) = (setups.iter().collect(), patches(&mesh, 0.5, |_| true));
        let (tools, view) = ([pin(1.0, 20.0)], MeshDistance::new(&mesh));
        let on_top = |p: &Patch| p.at[2] > 1.99;
        let [plain, told] = [false, true].map(|asked| {
            reach(&surface, &tools, &list, (Touching::Exactly, STAND_OFF), &view, |p| asked && on_top(p)).unwrap()
        });
        for (p, patch) in surface.iter().enumerate() {
            if on_top(patch) {
                assert!(matches!(plain.states[p], State::Reached(_)), "{patch:?}");
                assert!(told.states[p] == State::Unreachable && told.short[p].is_some(), "{patch:?}");
            } else {
                assert_eq!((told.states[p], told.short[p]), (plain.states[p], plain.short[p]));
            }
        }
    }

    #[test]
    fn a_floor_wider_than_the_cutter_is_short_by_what_the_holder_stands_off() {
        // The holder of 12 mm meets the rim of a hole of 10 mm, 13 mm above its floor, 8 mm above the tip of a cutter of 6 mm.
        let profile = [[0.0, 0.0], [9.0, 0.0], [9.0, 21.0], [5.0, 21.0], [5.0, 8.0], [0.0, 8.0]];
        let mesh = revolved(&profile, 192);
        let tool = pin(6.0, 8.0);
        let judged = Judged::new(&mesh, tool.clone(), &axis_directions()[..1]);
        let setup = Setup::cast(&mesh, InsideRule::Crossings, [0.0, 0.0, 1.0], H, Length::mm(4.0)).unwrap();
        // Beside the wall the cutter is known to be free only a cube off it.
        let on_floor = |p: &Patch| floor(p) && p.at[2] > 7.9 && p.at[0].hypot(p.at[1]) < 4.4;
        let mut seen = 0;
        for (p, short) in judged.patches.iter().zip(&judged.reach.short).filter(|(p, _)| on_floor(p)) {
            let (by, standing) = short.expect("not reached");
            seen += 1;
            assert!((5.0..=5.5).contains(&by), "{by} at {:?}", p.at);
            let away = (standing.tip[0] - p.at[0]).hypot(standing.tip[1] - p.at[1]);
            assert!(away <= 3.0 && (standing.tip[2] - 8.0).abs() < 1e-6, "the end covers the place: {standing:?}");
            let (height, at) = strike(tool.meridian().unwrap(), &setup, standing.tip).expect("the holder");
            assert!((height - 8.0).abs() < 0.5 && (at[2] - 16.0).abs() < 0.5, "{height} {at:?}");
        }
        assert!(seen > 100, "{seen}");
    }
}
