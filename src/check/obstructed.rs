//! How tools are held off from surface that they cannot touch.

use super::place::reported;
use super::tool_access::Judged;
use super::tooling::{direction_in_file, round};
use super::untouched::Region;
use crate::access::{Meridian, Room, Standing, clear_aside, drawn_back, gets_in, rooms, strike};
use crate::geometry::triangle::closest_on_segments;
use crate::geometry::vector::{Vec3, distance};
use crate::medial::reflex::{ReflexEdge, reflex_edges};
use crate::units::short;

/// So many patches of a piece are asked what holds the tools off.
const MOST_ASKED: usize = 128;
/// What holds the tools off from less than this share of a piece is not told apart.
const LEAST_SHARE: f64 = 0.2;
/// What comes nearer by less than this is as near, millimetres.
const NEARER: f64 = 0.1;
/// An edge bent by this much and more is a corner, and none of a round wall, radians (30°).
const CORNER: f64 = 0.52;

/// How the tool that comes nearest to a patch is held off, in words.
pub(super) struct Obstructed {
    pub(super) patch: usize,
    /// `end-mill-6` and `+z`.
    pub(super) tool: String,
    pub(super) from: String,
    pub(super) stops: f64,
    /// `, held off by its holder`.
    pub(super) by: String,
    /// From where it would touch.
    by_standing: Standing,
    /// The height above its tip at which it strikes there.
    strikes: Option<f64>,
    /// The touching tip, and where it strikes, in the frame of the file.
    pub(super) points: Vec<Vec3>,
}

impl Judged<'_> {
    /// Whether a patch lies so near to a concave edge.
    fn is_in_corner(&self, p: usize, within: f64) -> bool {
        let mesh = self.part.mesh();
        let edges = || reflex_edges(mesh, CORNER, |f| self.part.bounds_solid(f));
        let ends = |e: ReflexEdge| e.ends.map(|v| mesh.vertices[v as usize]);
        let corners = self.corners.get_or_init(|| edges().into_iter().map(ends).collect());
        let at = self.surface[p].at;
        corners.iter().any(|edge| distance(closest_on_segments(*edge, [at; 2]).0, at) <= within)
    }

    /// The share of a piece that something else holds the tools off from than at its worst place, and how the worst patch of that share
    /// is: a floor by the holder, where its corners are by the cutter.
    pub(super) fn otherwise(&self, region: &Region, worst: &Obstructed) -> Option<(f64, Obstructed)> {
        let asked = region.patches.iter().step_by(region.patches.len().div_ceil(MOST_ASKED).max(1));
        let (mut all, mut theirs, mut other) = (0.0, 0.0, Vec::new());
        for &p in asked {
            let area = self.surface[p].area;
            all += area;
            let known = self.obstructed(p).filter(|o| !o.by.is_empty() && o.by != worst.by);
            if let Some(o) = known.filter(|o| o.stops < worst.stops) {
                theirs += area;
                other.push(o);
            }
        }
        let farthest = other.into_iter().max_by(|a, b| a.stops.total_cmp(&b.stops));
        Some((theirs / all, farthest.filter(|_| theirs >= LEAST_SHARE * all)?))
    }

    /// How the tool that comes nearest to a patch is held off, and how far: exactly, where it is only drawn back. Also what would let it get there, if that is known.
    pub(super) fn held_off(&self, p: usize) -> Option<(Obstructed, Option<String>)> {
        let (stops, standing) = self.found.stops(p)?;
        let (tool, setup) = (&self.tooling.tools[standing.tool], &self.tooling.setups[standing.setup]);
        let (patch, view) = (&self.surface[p], self.part.distance());
        let own = drawn_back(tool, setup, patch, Some(standing.tip), stops + self.tooling.stand_off, view);
        let own = own.filter(|_| self.found.beside[p].is_none());
        let (stops, standing) = own.map_or((stops, standing), |(stops, tip)| (stops, Standing { tip, ..standing }));
        let (stops, standing) = self.over_an_end(p, (stops, standing));
        let (tool, setup) = (&self.tooling.tools[standing.tool], &self.tooling.setups[standing.setup]);
        let mut found = self.obstructed_from(p, stops, standing);
        let aside = clear_aside(tool, setup, patch, standing.tip, view);
        if self.is_by_its_end(&found, aside) {
            found.stops = aside.map_or(stops, |aside| aside.min(stops));
            let way = format!("give the corner a fillet that the end of {} fits, which was not tried", found.tool);
            return Some((found, Some(way)));
        }
        let way = self.way(&found);
        Some((found, way))
    }

    /// The same, or what comes nearer with a flat end on a level patch: in a hole little wider than a tool the lattice knows of no free pose.
    fn over_an_end(&self, p: usize, known: (f64, Standing)) -> (f64, Standing) {
        let (patch, view) = (&self.surface[p], self.part.distance());
        let pairs =
            self.tooling.tools.iter().enumerate().flat_map(|(tool, t)| {
                self.tooling.setups.iter().enumerate().map(move |(setup, s)| (tool, t, setup, s))
            });
        pairs.fold(known, |best, (tool, t, setup, s)| {
            let nearer = drawn_back(t, s, patch, None, best.0, view).filter(|(by, _)| *by < best.0 - NEARER);
            nearer.map_or(best, |(by, tip)| (by, Standing { tool, setup, tip }))
        })
    }

    /// How the tool that comes nearest to a patch is held off, as far as the lattice says.
    fn obstructed(&self, p: usize) -> Option<Obstructed> {
        let (stops, standing) = self.found.stops(p)?;
        Some(self.obstructed_from(p, stops, standing))
    }

    fn obstructed_from(&self, p: usize, stops: f64, standing: Standing) -> Obstructed {
        let (tool, setup) = (&self.tooling.tools[standing.tool], &self.tooling.setups[standing.setup]);
        let struck = tool.meridian().and_then(|m| Some((m, strike(m, setup, standing.tip)?)));
        // A layer strikes with what is widest in it.
        let role = |(m, (height, _)): &(&Meridian, (f64, Vec3))| m.role_at(height + 0.5 * self.tooling.spacing).word();
        let at = struck.map(|(_, (_, place))| place);
        Obstructed {
            patch: p,
            tool: tool.name.clone(),
            from: direction_in_file(self.part, setup.direction),
            stops,
            by: struck.as_ref().map_or(String::new(), |s| format!(", held off by its {}", role(s))),
            strikes: struck.map(|(_, (height, _))| height),
            by_standing: standing,
            points: [standing.tip].into_iter().chain(at).map(|p| reported(self.part, p)).collect(),
        }
    }

    /// Whether a tool stands clear beside a patch in a corner: what is in the way is the corner itself.
    fn is_by_its_end(&self, found: &Obstructed, aside: Option<f64>) -> bool {
        let tool = &self.tooling.tools[found.by_standing.tool];
        let Some((m, height)) = tool.meridian().zip(found.strikes) else { return false };
        let stands = self.found.beside[found.patch].is_some() || aside.is_some();
        stands && height < m.cutter_radius() && self.is_in_corner(found.patch, m.cutter_radius() + self.tooling.spacing)
    }

    /// The rooms that let a tool get where it would touch, if the part's field, with them taken off, lets it.
    fn way(&self, found: &Obstructed) -> Option<String> {
        let Standing { tool, setup, tip } = found.by_standing;
        let (m, setup) = (self.tooling.tools[tool].meridian()?, &self.tooling.setups[setup]);
        let rooms = rooms(m, setup, tip, self.part.distance());
        if rooms.is_empty() || !gets_in(m, setup, tip, &rooms) {
            return None;
        }
        let told = |v: f64| short(round(v));
        let point = |p: Vec3| reported(self.part, p).map(told).join(", ");
        let room = |room: &Room| {
            let roles: Vec<&str> = room.roles.iter().map(|r| r.word()).collect();
            let [low, high] = room.heights.map(told);
            format!(
                "{} mm wide from {low} to {high} mm up it, for its {}",
                told(2.0 * room.radius),
                roles.join(" and ")
            )
        };
        let rooms: Vec<String> = rooms.iter().map(room).collect();
        Some(format!(
            "make room about the line from {} along {}: {}; then {} touches {}",
            point(tip),
            found.from,
            rooms.join(", and "),
            found.tool,
            point(self.surface[found.patch].at)
        ))
    }
}
