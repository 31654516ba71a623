//! Which supports come off, in what order, and what keeps the others.

use super::setup::{Setup, flipped};
use super::station::Station;
use super::surface::Patch;
use super::tool::Tool;
use crate::error::{Error, Result, ToolFault};
use crate::field::Indicator;
use crate::geometry::MeshDistance;
use crate::geometry::vector::{Vec3, along, compare, distance, dot, hull};
use crate::morphology::{StructuringElement, dilate};
use crate::topology::{Adjacency, Components, components};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// So many of the supports that supports keep, the largest, are tried alone.
const TRIED_ALONE: usize = 8;

/// Points of a contact that are tried, from its rim inwards.
const POINTS_TRIED: usize = 30;

/// Supports as samples: all of them, those just below what they hold up, and those just above the part they stand on.
#[derive(Debug, Clone, Copy)]
pub struct Columns<'a> {
    pub all: &'a Indicator,
    pub heads: &'a Indicator,
    pub feet: &'a Indicator,
}

/// What keeps a support from coming off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keeper {
    /// The part itself.
    Part,
    /// The support itself: no tool gets past it to its contact, whatever else stands.
    Itself,
    /// Other supports that cannot be taken away either.
    Others,
    /// Supports; of the smaller ones it is not asked which.
    Supports,
}

/// A support that stays.
#[derive(Debug, Clone, PartialEq)]
pub struct Stuck {
    /// Component of the columns.
    pub component: u32,
    /// The contact that no tool reaches, by its point that a tool comes nearest to.
    pub contact: Patch,
    /// Area of that contact, mm².
    pub area_mm2: f64,
    /// Box of that contact.
    pub extent: (Vec3, Vec3),
    /// How far the best tool stops short of it along its axis, the tool and its direction.
    pub short: Option<(f64, usize, Vec3)>,
    pub keeper: Keeper,
}

/// The order in which supports come off.
#[derive(Debug, Clone, PartialEq)]
pub struct Removal {
    /// The supports: components of the columns over shared faces.
    pub supports: Components,
    /// Box of each, in the frame of the part.
    pub boxes: Vec<(Vec3, Vec3)>,
    /// Those that come off in each round.
    pub rounds: Vec<Vec<u32>>,
    /// Those that stay.
    pub stuck: Vec<Stuck>,
    /// The samples that stay.
    pub remaining: Indicator,
}

/// A contact of a support: a connected patch of surface that it holds, or stands on.
struct Contact {
    component: u32,
    points: Vec<Patch>,
    area: f64,
    extent: (Vec3, Vec3),
}

/// Takes supports away in rounds: one goes when each of its contacts can be reached past the part and what is still standing,
/// the supports themselves being cut back by the stand-off from their contacts.
///
/// A contact is reached if the cutter of a tool, free of part and standing supports, comes within the stand-off of one of its
/// points with nothing of the part in between; up to 30 points are tried, from the rim inwards; contacts smaller than
/// four squares of the grid tear off. `surface` are the patches of
/// the part's surface, `setups` the directions, the first being +z in the part's frame, whose grid the columns stand on.
/// Where the columns stand is an assumption, so the answer is an estimate.
///
/// # Errors
/// [`Error::Tool`] without setups; [`Error::Operand`] if the grids differ.
///
/// # Cost
/// For each tool and setup two dilations, one more in each further round and for each of the largest supports that supports
/// keep; four times as many for a tool of any shape.
pub fn remove(
    columns: Columns,
    surface: &[Patch],
    tools: &[Tool],
    setups: &[&Setup],
    stand_off: f64,
    view: &MeshDistance,
) -> Result<Removal> {
    let fault = |tool: &str, fault| Error::Tool { tool: tool.into(), fault };
    let Some(first) = setups.first() else { return Err(fault("list", ToolFault::NoDirections)) };
    let found = components(columns.all, Adjacency::Face);
    let grid = *columns.all.grid();
    let edges = |[lo, hi]: [[usize; 3]; 2]| {
        let half = 0.5 * grid.h();
        (grid.position(lo).map(|x| x - half), grid.position(hi).map(|x| x + half))
    };
    let mut rounds = Vec::new();
    let mut open = contacts(columns, surface, |at| found.of(at));
    let mut bare = Vec::new();
    for setup in setups {
        for (t, tool) in tools.iter().enumerate() {
            for station in Station::all(tool, first, setup) {
                bare.push((t, *setup, station?));
            }
        }
    }
    let cut = cut_back(columns, stand_off)?;
    let mut standing: Vec<bool> = vec![true; found.count()];
    while !open.is_empty() {
        let left = cut.intersection(&found.select(|c| standing[c as usize]))?;
        let stations = with_supports(&bare, &left)?;
        let missed: Vec<bool> =
            open.par_iter().with_max_len(16).map(|c| !reached(c, &stations, stand_off, view)).collect();
        let mut keeps = vec![false; found.count()];
        open.iter().zip(&missed).filter(|(_, m)| **m).for_each(|(c, _)| keeps[c.component as usize] = true);
        let freed: Vec<u32> =
            (0..found.count() as u32).filter(|&c| standing[c as usize] && !keeps[c as usize]).collect();
        let mut missed = missed.into_iter();
        open.retain(|_| missed.next().unwrap_or(false));
        if freed.is_empty() {
            break;
        }
        freed.iter().for_each(|&c| standing[c as usize] = false);
        rounds.push(freed);
    }
    let mut stuck: Vec<Stuck> = open.par_iter().with_max_len(16).map(|c| stuck(c, &bare, stand_off, view)).collect();
    let left = standing.iter().filter(|s| **s).count();
    for component in largest(&found, &stuck) {
        // What stands alone is held off by nothing else.
        let own = if left > 1 { Some(cut.intersection(&found.select(|c| c == component))?) } else { None };
        let alone = own.map(|own| with_supports(&bare, &own)).transpose()?;
        for (contact, s) in
            open.iter().zip(&mut stuck).filter(|(_, s)| s.component == component && s.keeper != Keeper::Part)
        {
            let others = alone.as_ref().is_some_and(|alone| reached(contact, alone, stand_off, view));
            s.keeper = if others { Keeper::Others } else { Keeper::Itself };
        }
    }
    Ok(Removal {
        boxes: found.boxes().into_iter().map(edges).collect(),
        rounds,
        stuck,
        remaining: found.select(|c| standing[c as usize]),
        supports: found,
    })
}

/// The contacts of all supports, each with the patches of surface just above its heads or just below its feet.
fn contacts(columns: Columns, surface: &[Patch], component: impl Fn([usize; 3]) -> Option<u32>) -> Vec<Contact> {
    let grid = columns.all.grid();
    let [heads, feet] = [columns.heads, columns.feet].map(|s| components(s, Adjacency::Corner));
    let mut groups: BTreeMap<(u32, bool, u32), Contact> = BTreeMap::new();
    for p in surface.iter().filter(|p| p.normal[2].abs() > 1e-3) {
        let (above, ends) = if p.normal[2] < 0.0 { (false, &heads) } else { (true, &feet) };
        let towards = if above { 1.0 } else { -1.0 };
        let beside = [0.3, 0.8, 1.3].into_iter().find_map(|k| {
            let index = grid.sample_at(along(p.at, [0.0, 0.0, towards], k * grid.h()))?;
            Some((component(index)?, ends.of(index)?))
        });
        if let Some((component, end)) = beside {
            let contact = groups.entry((component, above, end)).or_insert_with(|| Contact {
                component,
                points: vec![],
                area: 0.0,
                extent: (p.at, p.at),
            });
            contact.area += p.area;
            contact.extent = hull(contact.extent, (p.at, p.at));
            contact.points.push(*p);
        }
    }
    let least = 4.0 * grid.h() * grid.h();
    groups.into_values().filter(|c| c.area >= least).map(from_the_rim).collect()
}

/// The points of a contact from the furthest from its middle inwards, thinned out.
fn from_the_rim(mut contact: Contact) -> Contact {
    contact.points.sort_by(|a, b| compare(a.at, b.at));
    let n = contact.points.len().max(1) as f64;
    let middle = contact.points.iter().fold([0.0; 3], |m, p| along(m, p.at, 1.0 / n));
    contact.points.sort_by(|a, b| distance(b.at, middle).total_cmp(&distance(a.at, middle)));
    // Close together at both ends: a contact may be open from without, or, around a post or a neck, from within.
    let last = contact.points.len().saturating_sub(1) as f64;
    let tried = POINTS_TRIED.min(contact.points.len());
    let at = |i: usize| {
        let turn = std::f64::consts::PI * i as f64 / tried.saturating_sub(1).max(1) as f64;
        (0.5 * last * (1.0 - turn.cos())).round() as usize
    };
    let mut chosen: Vec<usize> = (0..tried).map(at).collect();
    chosen.dedup();
    contact.points = chosen.into_iter().filter_map(|i| contact.points.get(i).copied()).collect();
    contact
}

/// The columns without what lies within the stand-off of a contact: there the tool cuts.
fn cut_back(columns: Columns, stand_off: f64) -> Result<Indicator> {
    let grid = columns.all.grid();
    let ends = columns.heads.union(columns.feet)?;
    if ends.is_empty() {
        return Ok(columns.all.clone());
    }
    let by = (stand_off / grid.h()).ceil() as usize;
    let near = dilate(&ends, &StructuringElement::cuboid([2 * by + 1; 3], grid.spacing())?)?.set;
    columns.all.difference(&near.placed([by as isize; 3], *grid)?)
}

/// The stations with supports in the way as well.
fn with_supports<'a>(
    bare: &[(usize, &Setup, Station<'a>)],
    supports: &Indicator,
) -> Result<Vec<(usize, Vec3, Station<'a>)>> {
    let points: Vec<Vec3> = supports.iter().map(|at| supports.grid().position(supports.grid().index(at))).collect();
    let mut seen: Vec<(Vec3, Indicator)> = Vec::new();
    for (_, setup, _) in bare.iter().filter(|(_, _, station)| station.tool().meridian().is_some()) {
        if seen.iter().all(|(d, _)| *d != setup.direction) {
            let opposite = seen.last().filter(|(d, _)| dot(*d, setup.direction) < -1.0 + 1e-12);
            let set = match opposite {
                Some((_, set)) => flipped(set, *setup.grid())?,
                None => in_setup(&points, setup),
            };
            seen.push((setup.direction, set));
        }
    }
    let one = |(tool, setup, station): &(usize, &Setup, Station<'a>)| {
        let turned = seen.iter().find(|(d, _)| *d == setup.direction).map(|(_, set)| set);
        let set = if station.tool().meridian().is_some() { turned } else { Some(supports) };
        let set = set.ok_or_else(|| Error::Internal { problem: "a support was not seen from a setup".into() })?;
        Ok((*tool, setup.direction, station.with_more(&station.hits_of(set)?)?))
    };
    bare.par_iter().map(one).collect()
}

/// Points as samples of a setup.
fn in_setup(points: &[Vec3], setup: &Setup) -> Indicator {
    let mut set = Indicator::empty(*setup.grid());
    for &p in points {
        if let Some(index) = setup.grid().sample_at(setup.to_frame(p)) {
            set.set(index, true);
        }
    }
    set
}

fn reached(contact: &Contact, stations: &[(usize, Vec3, Station)], stand_off: f64, view: &MeshDistance) -> bool {
    contact.points.iter().any(|p| stations.iter().any(|(_, _, station)| station.beside(p, stand_off, view).is_some()))
}

/// The largest of the supports that supports keep.
fn largest(found: &Components, stuck: &[Stuck]) -> Vec<u32> {
    let sizes = found.sizes();
    let kept: BTreeSet<u32> = stuck.iter().filter(|s| s.keeper == Keeper::Supports).map(|s| s.component).collect();
    let mut kept: Vec<u32> = kept.into_iter().collect();
    kept.sort_by_key(|&c| std::cmp::Reverse(sizes[c as usize]));
    kept.truncate(TRIED_ALONE);
    kept
}

/// What keeps a contact that is never reached.
fn stuck(contact: &Contact, bare: &[(usize, &Setup, Station)], stand_off: f64, view: &MeshDistance) -> Stuck {
    let may = |p: &Patch, setup: &Setup, station: &Station| {
        station.tool().meridian().is_none() || dot(p.normal, setup.direction) > -1e-3
    };
    let by_part = !contact.points.iter().any(|p| {
        bare.iter().any(|(_, setup, station)| may(p, setup, station) && station.stand(p, stand_off, view).is_some())
    });
    let nearest = contact.points.iter().flat_map(|p| {
        bare.iter().filter_map(|(tool, setup, station)| {
            station.retreat_of_tip(p).map(|(short, _)| (*p, (short, *tool, setup.direction)))
        })
    });
    let best = nearest.min_by(|a, b| a.1.0.total_cmp(&b.1.0));
    let any =
        Patch { corners: [[0.0; 3]; 3], at: [0.0; 3], normal: [0.0, 0.0, -1.0], area: 0.0, radius: 0.0, facet: 0 };
    let at = best.map(|b| b.0).or(contact.points.first().copied()).unwrap_or(any);
    Stuck {
        component: contact.component,
        contact: at,
        area_mm2: contact.area,
        extent: contact.extent,
        short: best.map(|b| b.1),
        keeper: if by_part { Keeper::Part } else { Keeper::Supports },
    }
}

#[cfg(test)]
mod tests {
    use super::super::pose::lattice_directions;
    use super::super::surface::patches;
    use super::*;
    use crate::geometry::union::united;
    use crate::geometry::{InsideRule, TriangleMesh, cuboid, revolved};
    use crate::layer::{Supports, supports};
    use crate::units::Length;

    const H: Length = Length::mm(0.4);
    const STAND_OFF: f64 = 0.4 * 2.0 * 1.732_050_807_568_877_2;

    fn pliers() -> Tool {
        let text = "[[piece]]\nrole = \"cutter\"\nshape = \"cone\"\ndiameter_mm = 2\nupper_diameter_mm = 6\nlength_mm = 30\n\
                    [[piece]]\nrole = \"holder\"\ndiameter_mm = 16\nlength_mm = 50\n";
        Tool::from_toml("pliers", text, |_| Ok(TriangleMesh::default())).unwrap()
    }

    fn taken_away(mesh: &TriangleMesh, made: impl Fn(&Setup) -> Supports) -> Removal {
        taken_away_by(pliers(), mesh, made)
    }

    fn taken_away_by(tool: Tool, mesh: &TriangleMesh, made: impl Fn(&Setup) -> Supports) -> Removal {
        let cast = |&d: &Vec3| Setup::cast(mesh, InsideRule::Crossings, d, H, Length::mm(4.0)).unwrap();
        let setups: Vec<Setup> = lattice_directions().iter().map(cast).collect();
        let made = made(&setups[0]);
        let surface = patches(mesh, 0.8, |_| true);
        let list: Vec<&Setup> = setups.iter().collect();
        let columns = Columns { all: &made.columns, heads: &made.heads, feet: &made.feet_on_part };
        remove(columns, &surface, &[tool], &list, STAND_OFF, &MeshDistance::new(mesh)).unwrap()
    }

    /// Columns under all flat ceilings above the plate.
    fn under_ceilings<'m>(mesh: &'m TriangleMesh) -> impl Fn(&Setup) -> Supports + 'm {
        move |setup| {
            let hangs = |f: &u32| mesh.normal(*f as usize)[2] < -0.9 && mesh.centroid(*f as usize)[2] > 0.1;
            let facets: Vec<u32> = (0..mesh.triangles.len() as u32).filter(hangs).collect();
            supports(&setup.centres, mesh, &facets, 0.0).unwrap()
        }
    }

    #[test]
    fn supports_under_a_table_come_off() {
        let table = revolved(&[[0.0, 0.0], [3.0, 0.0], [3.0, 10.0], [12.0, 10.0], [12.0, 13.0], [0.0, 13.0]], 64);
        let removal = taken_away(&table, under_ceilings(&table));
        assert_eq!((removal.supports.count(), removal.rounds.len(), removal.stuck.len()), (1, 1, 0));
        // A ring of radii 3 and 12 mm, 10 mm high; a sample is missed at the rims.
        let volume = std::f64::consts::PI * (144.0 - 9.0) * 10.0;
        let standing = removal.supports.sizes()[0] as f64 * H.as_mm().powi(3);
        assert!((standing / volume - 1.0).abs() < 0.1, "{standing} {volume}");
        assert!(removal.remaining.is_empty());
    }

    #[test]
    fn supports_in_a_bottle_with_a_narrow_neck_stay_and_the_part_keeps_them() {
        let profile =
            [[0.0, 0.0], [12.0, 0.0], [12.0, 30.0], [1.5, 30.0], [1.5, 20.0], [9.0, 20.0], [9.0, 3.0], [0.0, 3.0]];
        let bottle = revolved(&profile, 64);
        let removal = taken_away(&bottle, under_ceilings(&bottle));
        assert_eq!((removal.supports.count(), removal.rounds.len()), (1, 0));
        assert!(!removal.stuck.is_empty() && removal.stuck.iter().all(|s| s.keeper == Keeper::Part));
        let head = removal.stuck.iter().find(|s| s.contact.normal[2] < 0.0).unwrap();
        assert!((head.contact.at[2] - 20.0).abs() < 1e-6 && head.area_mm2 > 200.0, "{head:?}");
        assert!(head.short.is_some_and(|(short, _, _)| short > 2.0), "{head:?}");
        // A jar whose neck lets the tool lean in, with a narrow rim for a ceiling.
        let profile =
            [[0.0, 0.0], [20.0, 0.0], [20.0, 16.0], [14.0, 16.0], [14.0, 13.0], [16.0, 13.0], [16.0, 3.0], [0.0, 3.0]];
        let jar = revolved(&profile, 64);
        let removal = taken_away(&jar, under_ceilings(&jar));
        assert_eq!((removal.supports.count(), removal.stuck.len()), (1, 0), "{:?}", removal.stuck);
    }

    #[test]
    fn only_the_contact_that_no_tool_reaches_keeps_a_support() {
        // A bracket with a tooth that hangs down to 0.8 mm above its floor: the rest of the floor is open.
        let boxes = [
            ([0.0, 0.0, 0.0], [20.0, 10.0, 2.0]),
            ([0.0, 0.0, 0.0], [4.0, 10.0, 20.0]),
            ([0.0, 0.0, 18.0], [20.0, 10.0, 20.0]),
            ([14.0, 4.0, 2.8], [16.0, 6.0, 19.0]),
        ];
        let whole = boxes.into_iter().map(|(lo, hi)| cuboid(lo, hi)).reduce(|a, b| a.joined(&b)).unwrap();
        let bracket = united(&whole, 1e-6).unwrap();
        let removal = taken_away(&bracket, under_ceilings(&bracket));
        assert_eq!((removal.supports.count(), removal.rounds.len(), removal.stuck.len()), (1, 0, 1));
        let stuck = &removal.stuck[0];
        // All of the tooth's end but for patches at its rim that no column stands under.
        assert!(stuck.area_mm2 > 3.0 && stuck.area_mm2 <= 4.0 && (stuck.contact.at[2] - 2.8).abs() < 1e-9, "{stuck:?}");
    }

    #[test]
    fn a_tool_of_any_shape_takes_them_off_as_well() {
        let bent = revolved(&[[0.0, 0.0], [1.0, 0.0], [3.0, 30.0], [8.0, 30.0], [8.0, 80.0], [0.0, 80.0]], 24);
        let points = [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let sharp = points.map(|at_mm| super::super::tool::SharpPoint { name: "jaw".into(), at_mm }).to_vec();
        let tool = Tool::from_mesh("pliers", bent, sharp).unwrap();
        let table = revolved(&[[0.0, 0.0], [3.0, 0.0], [3.0, 10.0], [12.0, 10.0], [12.0, 13.0], [0.0, 13.0]], 64);
        let removal = taken_away_by(tool.clone(), &table, under_ceilings(&table));
        assert_eq!((removal.supports.count(), removal.rounds.len(), removal.stuck.len()), (1, 1, 0));
        let profile =
            [[0.0, 0.0], [12.0, 0.0], [12.0, 30.0], [1.5, 30.0], [1.5, 20.0], [9.0, 20.0], [9.0, 3.0], [0.0, 3.0]];
        let bottle = revolved(&profile, 64);
        let removal = taken_away_by(tool, &bottle, under_ceilings(&bottle));
        assert_eq!((removal.supports.count(), removal.rounds.len()), (1, 0));
        assert!(!removal.stuck.is_empty() && removal.stuck.iter().all(|s| s.keeper == Keeper::Part));
    }

    #[test]
    fn what_stands_around_goes_before_what_stands_inside() {
        let table = revolved(&[[0.0, 20.0], [15.0, 20.0], [15.0, 23.0], [0.0, 23.0]], 64);
        let removal = taken_away(&table, |setup| {
            let grid = *setup.grid();
            let ring = |top: f64| {
                Indicator::from_predicate(grid, |at| {
                    let [x, y, z] = grid.position(grid.index(at));
                    let r = x.hypot(y);
                    // A post in the middle, and a wall around it down to the plate; 20 mm of column each.
                    (r < 2.0 || (r > 5.0 && r < 14.0)) && z < 20.0 && z > top
                })
            };
            // The plate itself is part of the world here: without it tools come from below.
            Supports {
                columns: ring(0.0),
                heads: ring(20.0 - 0.4),
                feet_on_part: Indicator::empty(grid),
                feet_on_plate: Indicator::empty(grid),
            }
        });
        assert_eq!(removal.supports.count(), 2);
        assert!(removal.stuck.is_empty(), "{:?}", removal.stuck);
        let first = &removal.rounds[0];
        let widest = |c: u32| removal.boxes[c as usize].1[0];
        assert!(first.iter().any(|&c| widest(c) > 10.0), "the wall goes first");
    }

    #[test]
    fn what_fills_a_cup_is_in_its_own_way_and_keeps_what_stands_in_it() {
        // Upside down: 27 mm deep, 24 mm wide.
        let cup = revolved(&[[12.0, 0.0], [15.0, 0.0], [15.0, 30.0], [0.0, 30.0], [0.0, 27.0], [12.0, 27.0]], 64);
        let filled = taken_away(&cup, under_ceilings(&cup));
        assert_eq!((filled.supports.count(), filled.rounds.len()), (1, 0));
        assert!(
            !filled.stuck.is_empty() && filled.stuck.iter().all(|s| s.keeper == Keeper::Itself),
            "{:?}",
            filled.stuck
        );
        // A plug with a hole of 5 mm, through which no tool gets up to 27 mm, and a post in that hole.
        let both = taken_away(&cup, |setup| {
            let grid = *setup.grid();
            let above = |least: f64| {
                Indicator::from_predicate(grid, |at| {
                    let [x, y, z] = grid.position(grid.index(at));
                    let r = x.hypot(y);
                    (r < 0.9 || (r > 2.5 && r < 11.8)) && z < 27.0 && z > least
                })
            };
            Supports {
                columns: above(0.0),
                heads: above(27.0 - 0.4),
                feet_on_part: Indicator::empty(grid),
                feet_on_plate: Indicator::empty(grid),
            }
        });
        assert_eq!((both.supports.count(), both.rounds.len()), (2, 0));
        let wide = |s: &&Stuck| both.boxes[s.component as usize].1[0] > 5.0;
        assert!(both.stuck.len() == 2 && both.stuck.iter().filter(wide).all(|s| s.keeper == Keeper::Itself));
    }
}
