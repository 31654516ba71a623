//! AM502: surface that no tool of the list can touch.

use super::contract::{Check, Context, MapKind, MapWanted, Measured, Meta, Outcome, ShapeShown, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, Limits, Sense, Witness};
use super::place::{locate, reported};
use super::powder::{Powder, area, between};
use super::tooling::{Tooling, direction_in_file, round};
use super::untouched::{Pieces, Region, area_of, gathered, pieces};
use crate::access::{Patch, Reach, Setup, State, Tool, Touching, patches, reach};
use crate::error::{Error, Result, ToolFault};
use crate::field::Field;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, bounds};
use crate::notice::number_of;
use crate::part::Part;
use crate::process::Process;
use crate::units::{report_digits, short};
use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::ops::Add;

/// AM502 `tool-access`.
pub struct ToolAccess;

static META: Meta = Meta {
    code: "AM502",
    name: "tool-access",
    title: "Surface that no tool can touch",
    what: "Finds surface that none of the listed tools can touch without running into the part, from any of the listed directions: \
           its area, how far the best tool stops short of it at most, since only poses on a lattice are tried, and what strikes where. The map shows that distance. Where powder holds the part up, also where it stays: on surface that no tool touches, \
           no straight line of air leaves, and no way out wide enough comes near.",
    why: "What no tool reaches cannot be blasted, deburred, machined, tapped or measured, and powder on it stays.",
    how: "The part is turned so that a tool comes from above and cast; a coaxial tool, exact, is laid over the cubes slice by slice. \
          The surface is cut into patches of at most two spacings. A patch is unreachable if in every pose that touches any point of \
          it the tool overlaps cubes that lie wholly in the part; it is reached by a tool that the user named if the cutter touches its middle and its corners from poses where \
          no facet reaches further into the tool than 0.05 mm, or a twentieth of a thin cutter's radius, which is exact, and by another if, free of all cubes that the part touches, the cutter comes within 2·√3 \
          spacings of its middle with nothing in between. What is neither is in the upper bound. Room that is advised about a tool was taken off the part's cubes, and the tool set there again. Powder leaves the middle of a patch in a straight \
          line along any direction listed, exactly, or where a ball as wide as the escape hole of AM301 comes from outside to within its radius, in sight of it.",
    limits: "It holds for the tools and directions listed: 26, between the faces, edges and corners of a cube, unless the process or \
             --tool-from and --tool-tilt say otherwise; another direction may do better. --faces restricts it to the faces that matter. What a rounder corner than the cutter keeps it from, and narrow places within about four spacings of a tool's width, may stay open: their area is given, and for tools that the user named they are undecided. A tool \
             of any shape comes along the six axes, or the directions of --tool-from, in four quarter turns about its own axis, with sphere:N at N rotations spread evenly over all, and touches only with its tip, or the [[sharp]] points of its description, within 2·√3 spacings; \
             one thinner than two spacings proves nothing unreachable. Tools that the user did not name never make a part fail.",
    source: "Inaccessibility measure: A. Mirzendehdel, M. Behandish, S. Nelaturi, Topology optimization with accessibility \
             constraint for multi-axis machining, 2020; obstacles: L. Kavraki, Computation of configuration-space obstacles using \
             the fast Fourier transform, 1995.",
};

/// Unreachable pieces below this are only counted, in the worst value and the cover line, mm².
const LEAST_AREA: f64 = 0.01;
/// Separate findings, worst first; what remains is gathered in one.
const MOST_FINDINGS: usize = 4;

impl Check for ToolAccess {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let Some(limits) = limits_of(process, "tool-access") else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        if process.tools.finishing.is_empty() {
            return Ok(Outcome::NotApplicable("the process lists no finishing tool; name one with --tool".into()));
        }
        // Only tools that the user named make a part fail.
        let limits = if process.tools.named {
            limits
        } else {
            Limits { fail: None, warn: limits.warn.or(limits.fail), ..limits }
        };
        let tooling = Tooling::of_finishing(part, process, context)?;
        let finish = &process.tools.finish;
        let mut surface = patches(part.mesh(), 2.0 * tooling.spacing, |f| part.bounds_solid(f));
        surface.retain(|p| finish.wants(part.to_file(p.at), part.direction_to_file(p.normal)));
        if let (true, Some(tool)) = (surface.is_empty() && !finish.faces.is_empty(), tooling.tools.first()) {
            return Err(Error::Tool { tool: tool.name.clone(), fault: ToolFault::NoFaces });
        }
        let setups: Vec<&Setup> = tooling.setups.iter().collect();
        // No tool gets into a void that is closed all round, however narrow.
        let shut_off = |p: &Patch| part.bounds_sealed_void(p.facet as usize);
        // Tools that the user did not name make no part fail: what comes near is enough, and quick.
        let touching = if process.tools.named { Touching::Exactly } else { Touching::WithinStandOff };
        let found = reach(&surface, &tooling.tools, &setups, (touching, tooling.stand_off), part.distance(), shut_off)?;
        let Pieces { regions, open } = pieces(&surface, &found, part, tooling.spacing)?;
        let powder = if process.powder_supports {
            let never: Vec<usize> = (0..surface.len()).filter(|&p| found.states[p] == State::Unreachable).collect();
            let hole = process.limit("trapped-volume").and_then(|l| l.fail.or(l.warn));
            Some(Powder::on(part, &tooling.setups, &surface, &never, hole)?)
        } else {
            None
        };
        let judged = Judged {
            part,
            context,
            tooling: &tooling,
            surface: &surface,
            found: &found,
            touching,
            powder: powder.as_ref(),
            limits,
            corners: OnceCell::new(),
        };
        let mut measured = Measured {
            cover: judged.cover(),
            rule: Some("tool-access"),
            map: judged.map()?,
            shapes: judged.shape().into_iter().collect(),
            ..Measured::default()
        };
        let least = regions.first().map_or(0.0, |r| r.area);
        let open_beside = regions.iter().map(|r| r.area + r.open);
        let most = open_beside.chain(open.first().map(|o| area_of(&surface, o))).fold(0.0, f64::max);
        let at = regions.first().map(|r| surface[r.worst].at);
        measured.worst = Some(Worst { bracket: Bracket::new(least, least, most), unit: "mm2", at });
        let seen = regions.partition_point(|r| r.area >= LEAST_AREA).max(usize::from(!regions.is_empty()));
        let (own, rest) = regions[..seen].split_at(seen.min(MOST_FINDINGS));
        measured.findings = own
            .iter()
            .map(|r| judged.finding(r, Bracket::new(r.area, r.area, r.area + r.open), "unreachable", 1))
            .collect();
        if let (Some(all), Some(largest)) = (gathered(rest), rest.first()) {
            let most = rest.iter().map(|r| r.area + r.open).fold(0.0, f64::max);
            let bracket = Bracket::new(largest.area, largest.area, most);
            measured.findings.push(judged.finding(&all, bracket, "small-places", rest.len() as u64));
        }
        if process.tools.named {
            measured.findings.extend(judged.narrow(&open));
        }
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// Whether it is not known of a patch that it is touched, nor that it is not.
fn is_open(state: &State) -> bool {
    matches!(state, State::Open | State::Near(_))
}

/// What is told of, and what it is told from.
pub(super) struct Judged<'a> {
    pub(super) part: &'a Part,
    pub(super) context: &'a Context,
    pub(super) tooling: &'a Tooling<'a>,
    pub(super) surface: &'a [Patch],
    pub(super) found: &'a Reach,
    pub(super) touching: Touching,
    pub(super) powder: Option<&'a Powder>,
    pub(super) limits: Limits,
    /// The part's concave edges.
    pub(super) corners: OnceCell<Vec<[Vec3; 2]>>,
}

impl Judged<'_> {
    fn area_of(&self, wanted: impl Fn(&State) -> bool) -> f64 {
        self.surface.iter().zip(&self.found.states).filter(|(_, s)| wanted(s)).map(|(p, _)| p.area).fold(0.0, f64::add)
    }

    /// What may be touched or not.
    fn open_area(&self) -> f64 {
        self.area_of(is_open)
    }

    /// The surface that cannot be touched for certain, as a shape.
    fn shape(&self) -> Option<ShapeShown> {
        let pairs = self.surface.iter().zip(&self.found.states);
        let never: Vec<[Vec3; 3]> = pairs.filter(|(_, s)| **s == State::Unreachable).map(|(p, _)| p.corners).collect();
        let title = format!("Surface no tool can touch, {}", area(self.area_of(|s| *s == State::Unreachable)));
        (!never.is_empty()).then(|| ShapeShown { name: "inaccessible", title, mesh: TriangleMesh::weld(never) })
    }

    /// Whether all that is reached is touched, and not only come near to.
    fn is_exact(&self) -> bool {
        self.touching == Touching::Exactly && self.tooling.tools.iter().all(|t| t.meridian().is_some())
    }

    /// That so much is out of reach is certain; that no more is, only where the rest is touched exactly.
    fn basis(&self, least: f64) -> Basis {
        let breaks = self.limits.fail.or(self.limits.warn).is_some_and(|most| least > most);
        if breaks || self.is_exact() { Basis::Certified } else { Basis::Estimated }
    }

    fn stand_off(&self) -> String {
        short(round(self.tooling.stand_off))
    }

    fn cover(&self) -> String {
        let all = self.area_of(|_| true);
        let share = |area: f64| format!("{:.1} %", 100.0 * area / all.max(1e-12));
        let mut by: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        for (p, state) in self.surface.iter().zip(&self.found.states) {
            if let State::Reached(s) = state {
                *by.entry((s.setup, s.tool)).or_default() += p.area;
            }
        }
        let mut by: Vec<_> = by.into_iter().collect();
        by.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let best: Vec<String> = by
            .iter()
            .take(3)
            .map(|&((s, t), area)| {
                let from = direction_in_file(self.part, self.tooling.setups[s].direction);
                format!("{} by {} from {from}", share(area), self.tooling.tools[t].name)
            })
            .collect();
        let best = if best.is_empty() { String::new() } else { format!(": {} first", best.join(", ")) };
        let powder = self.powder.and_then(Powder::sentence).map_or(String::new(), |s| format!(" {s}"));
        let within = if !self.is_exact() { format!(" within {} mm", self.stand_off()) } else { String::new() };
        format!(
            "{} of the surface is reached{within}{best}; {} cannot be touched and {} may or may not be, by {}, and for these only.{powder}",
            share(self.area_of(|s| matches!(s, State::Reached(_)))),
            share(self.area_of(|s| *s == State::Unreachable)),
            share(self.open_area()),
            self.tooling.described(),
        )
    }

    /// How far the best tool stops short, on the surface.
    fn map(&self) -> Result<Option<MapWanted>> {
        let Some(setup) = self.tooling.setups.first() else { return Ok(None) };
        let grid = *setup.grid();
        let mut field = Field::constant(grid, f32::NAN);
        let mut longest = self.tooling.stand_off;
        for (p, patch) in self.surface.iter().enumerate() {
            let value = match (&self.found.states[p], self.found.stops(p)) {
                (State::Reached(_), _) => 0.0,
                (_, Some((short, _))) => short,
                (_, None) => continue,
            };
            longest = longest.max(value);
            let base = grid.continuous_index(patch.at).map(|c| c.floor().max(0.0) as usize);
            for corner in 0..8usize {
                let index = [0, 1, 2].map(|a| (base[a] + (corner >> a & 1)).min(grid.dims()[a] - 1));
                let at = grid.offset(index);
                let cell: &mut f32 = &mut field.values_mut()[at];
                *cell = if cell.is_nan() { value as f32 } else { cell.max(value as f32) };
            }
        }
        Ok(Some(MapWanted {
            kind: MapKind::Sampled,
            title: "How far the tools stop short of the surface",
            unit: "mm",
            limits: Limits { fail: None, warn: Some(report_digits(self.tooling.stand_off)), sense: Sense::Max },
            open_end: longest,
            facets: Vec::new(),
            field: Some(field),
        }))
    }

    /// The surface beside none of the others of which is not known whether the tools touch it, where a piece of it is more than the limits allow.
    fn narrow(&self, pieces: &[Vec<usize>]) -> Option<Finding> {
        let largest = pieces.first()?;
        let bracket = Bracket::new(0.0, 0.0, area_of(self.surface, largest));
        let mut f = Finding::judged(META.code, "narrow", bracket, self.basis(0.0), self.limits, "mm2", LEAST_AREA);
        let at = |p: &usize| self.surface[*p].at;
        let widest = largest.iter().max_by(|a, b| self.surface[**a].area.total_cmp(&self.surface[**b].area));
        let widest = widest.filter(|_| !f.decided)?;
        let all: Vec<usize> = pieces.iter().flatten().copied().collect();
        f.area_mm2 = Some(report_digits(area_of(self.surface, &all)));
        f.count = pieces.len() as u64;
        locate(&mut f, self.part, self.context, at(widest), bounds(all.iter().map(at))?);
        let near: Vec<usize> =
            all.iter().copied().filter(|&p| matches!(self.found.states[p], State::Near(_))).collect();
        let near = match near.is_empty() {
            false => {
                format!(": they come within {} mm of {} of it", self.stand_off(), area(area_of(self.surface, &near)))
            }
            true => String::new(),
        };
        f.message = format!(
            "a lattice of {} mm does not tell of {} in {} whether {} can touch it{near}",
            short(round(self.tooling.spacing)),
            area(area_of(self.surface, &all)),
            number_of(f.count, ["place", "places"]),
            self.names()
        );
        f.fix = "name the faces that matter with --faces, or a tool that is clearly thinner or wider; --voxel makes this lattice no finer".into();
        Some(f)
    }

    /// A piece, or several told as one, of which the largest is judged.
    fn finding(&self, region: &Region, bracket: Bracket, kind: &str, count: u64) -> Finding {
        let mut f = Finding::judged(META.code, kind, bracket, self.basis(bracket.low), self.limits, "mm2", 0.0);
        f.count = count;
        f.area_mm2 = Some(report_digits(region.area));
        let at = self.surface[region.worst].at;
        locate(&mut f, self.part, self.context, at, region.extent);
        let places = if count > 1 { format!("{count} places, {}", area(region.area)) } else { area(region.area) };
        f.message = format!("{places} cannot be touched by {}", self.names());
        if let Some([least, most]) = self.powder.map(|p| p.stays_on(&region.patches)) {
            let stays = if most > 0.0 {
                format!("powder stays on {}", between(least, most))
            } else {
                "powder leaves it".into()
            };
            f.message += &format!("; {stays}");
        }
        f.fix = format!("let {} stay as printed, or name another tool with --tool", area(region.area));
        let Some((worst, way)) = self.held_off(region.worst) else { return f };
        let otherwise = if count == 1 { self.otherwise(region, &worst) } else { None };
        let (otherwise, other_way) =
            match otherwise.map(|(share, o)| (share, self.held_off(o.patch).unwrap_or((o, None)))) {
                Some((share, (o, way))) => (Some((share, o)), way),
                None => (None, None),
            };
        let (tool, from, stops) = (&worst.tool, &worst.from, short(round(worst.stops)));
        f.message += &match &otherwise {
            Some((share, o)) => format!(
                "; {} stops at most {} mm short of {} of it, from {}{}; at worst {tool} stops at most {stops} mm short, from {from}{}",
                o.tool,
                short(round(o.stops)),
                if *share < 0.995 { format!("some {:.0} %", 100.0 * share) } else { "nearly all".into() },
                o.from,
                o.by,
                worst.by
            ),
            None => format!("; at worst {tool} stops at most {stops} mm short of it, from {from}{}", worst.by),
        };
        if let Some(way) = other_way.or(way) {
            f.fix = format!("{way}; or {}", f.fix);
        }
        let points = [vec![reported(self.part, at)], worst.points].concat();
        f.witness = Some(Witness { kind: "obstructed-tool".into(), points_mm: points });
        f
    }

    fn names(&self) -> String {
        self.tooling.tools.iter().map(Tool::touching).collect::<Vec<_>>().join(" or ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{cuboid, extruded, revolved};
    use crate::part::Up;
    use crate::process::ToolChoice;
    use std::f64::consts::FRAC_PI_2;

    /// What is found where a tool does not reach a mesh.
    fn measured(mesh: TriangleMesh, tool: &str) -> Measured {
        let mut part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
        let spacing = crate::units::Length::mm(0.25);
        part.cast_on(crate::grid::Grid::covering([0.0; 3], part.extent(), spacing, 2, [0.0; 3]).unwrap());
        let context = Context { refine: 0, spacing_mm: 0.25 };
        let mut process = Process::named("lpbf").unwrap();
        process.tools = process.tools.replaced(vec![ToolChoice::named(tool).unwrap()]);
        let found = ToolAccess.run(&part, &process, &context).unwrap();
        let Outcome::Measured(found) = found else { panic!("not measured") };
        *found
    }

    fn advice(mesh: TriangleMesh, tool: &str) -> Vec<String> {
        measured(mesh, tool).findings.into_iter().map(|f| f.fix).collect()
    }

    #[test]
    fn each_place_is_told_and_judged_by_itself() {
        // Rooms without a way in, of 24 to 96 mm² of wall.
        let sides = [2.0, 2.5, 3.0, 3.5, 4.0, 2.2];
        let room = |n: usize| cuboid([8.0 * n as f64 + 2.0, 2.0, 2.0], [8.0 * n as f64 + 2.0 + sides[n], 6.0, 6.0]);
        let block = cuboid([0.0; 3], [50.0, 8.0, 8.0]);
        let hollow = (0..sides.len()).fold(block, |all, n| all.joined(&room(n).flipped()));
        let found = measured(hollow, "end-mill-3");
        let largest = 2.0 * 4.0 * (2.0 * 4.0 + 4.0);
        assert!((found.worst.unwrap().bracket.value - largest).abs() < 1e-6);
        let areas: Vec<(&str, u64, f64)> = found.findings.iter().map(|f| (f.kind.as_str(), f.count, f.value)).collect();
        assert!((areas[0].2 - largest).abs() < 1e-6, "{areas:?}");
        // What is gathered is judged by the largest of it, and told with its sum.
        let gathered = found.findings.iter().find(|f| f.kind == "small-places").expect("more than four");
        let of = |side: f64| 2.0 * 4.0 * (2.0 * side + 4.0);
        assert!((gathered.value - of(2.2)).abs() < 1e-6 && gathered.count == 2, "{areas:?}");
        assert!((gathered.area_mm2.unwrap() - of(2.2) - of(2.0)).abs() < 1e-6, "{areas:?}");
    }

    /// A cylinder of radius 18 and height 25 mm with a bore from above.
    fn bored(radius: f64, deep: f64) -> TriangleMesh {
        let rim = [[0.0, 0.0], [18.0, 0.0], [18.0, 25.0], [radius, 25.0]];
        revolved(&[&rim[..], &[[radius, 25.0 - deep], [0.0, 25.0 - deep]]].concat(), 64)
    }

    #[test]
    fn room_is_advised_for_what_collides_and_only_as_high_as_it_does() {
        // The holder of 28 mm begins 20 mm above the tip, and the bore is 22 mm deep.
        let fixes = advice(bored(3.5, 22.0), "end-mill-6");
        assert!(!fixes.is_empty(), "the floor is out of reach");
        for fix in &fixes {
            assert!(fix.contains("28 mm wide from 20 to 22 mm up it, for its holder"), "{fixes:?}");
            assert!(!fix.contains("cutter and neck"), "{fixes:?}");
        }
        // One too narrow for the cutter.
        let fixes = advice(bored(2.5, 12.0), "end-mill-6");
        assert!(fixes.iter().any(|f| f.contains("6 mm wide from 0 to 12 mm up it, for its cutter; then")), "{fixes:?}");
    }

    #[test]
    fn what_is_wide_enough_is_not_advised_to_be_as_wide() {
        // A tap of 3 mm in a hole of 3 mm: its end is a cone of 2 mm, and leaves the lowest walls and the corner.
        let found = measured(bored(1.5, 12.0), "tap-m3");
        assert!(!found.findings.is_empty());
        for f in found.findings.iter().filter(|f| f.kind != "narrow") {
            let deeper = ["1.5", "1.6", "1.7", "1.8", "1.9"].iter().any(|d| f.fix.contains(&format!("from 0 to {d}")));
            assert!(deeper || f.fix.contains("the corner"), "{f:?}");
            assert!(!f.message.contains("stops at most 11"), "{}", f.message);
        }
    }

    #[test]
    fn a_corner_is_advised_a_fillet_and_a_socket_without_one_is_not() {
        // A channel of 14 mm, 8 mm deep.
        let outline =
            [[0.0, 0.0], [30.0, 0.0], [30.0, 14.0], [22.0, 14.0], [22.0, 6.0], [8.0, 6.0], [8.0, 14.0], [0.0, 14.0]];
        let caps = [[0, 1, 5], [1, 4, 5], [1, 2, 4], [2, 3, 4], [0, 5, 7], [5, 6, 7]];
        let corner = advice(extruded(&outline, &caps, 30.0), "ball-mill-6");
        assert!(corner.iter().any(|fix| fix.contains("give the corner a fillet")), "{corner:?}");
        // A ball of 10 mm in a socket 1 mm wider all round has no corner.
        let arc = |radius: f64| {
            let turns = (0..=24).map(|n| (FRAC_PI_2 * f64::from(n) / 24.0).sin_cos());
            turns.map(move |(sin, cos)| [radius * sin, 8.0 - radius * cos]).collect::<Vec<_>>()
        };
        let socket = [vec![[0.0, 0.0], [9.0, 0.0], [9.0, 8.0]], arc(6.0).into_iter().rev().collect()].concat();
        let upper = arc(5.0).into_iter().rev().skip(1).map(|[r, z]| [r, 16.0 - z]);
        let ball: Vec<[f64; 2]> = arc(5.0).into_iter().chain(upper).collect();
        let joint = advice(revolved(&socket, 48).joined(&revolved(&ball, 48)), "blast-nozzle");
        assert!(!joint.is_empty() && !joint.iter().any(|fix| fix.contains("corner")), "{joint:?}");
    }
}
