//! How tools are held off from surface that they cannot touch.

use super::place::reported;
use super::tool_access::Judged;
use super::tooling::{direction_in_file, round};
use super::untouched::Region;
use crate::access::{Standing, drawn_back, strike};
use crate::geometry::triangle::closest_on_segments;
use crate::geometry::vector::{Vec3, distance};
use crate::medial::reflex::{ReflexEdge, reflex_edges};
use crate::units::short;

/// So many patches of a piece are asked what holds the tools off.
const MOST_ASKED: usize = 128;
/// What holds the tools off from less than this share of a piece is not told apart.
const LEAST_SHARE: f64 = 0.2;
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
    /// `open a way to this place, at least 28 mm wide and 5.4 mm deep from +z`, where it is known what strikes.
    pub(super) way: Option<String>,
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
            let known = self.obstructed(p, |stops, _| stops).filter(|o| !o.by.is_empty() && o.by != worst.by);
            if let Some(o) = known.filter(|o| o.stops < worst.stops) {
                theirs += area;
                other.push(o);
            }
        }
        let farthest = other.into_iter().max_by(|a, b| a.stops.total_cmp(&b.stops));
        Some((theirs / all, farthest.filter(|_| theirs >= LEAST_SHARE * all)?))
    }

    /// How far the tool that comes nearest to a patch stops short, where the lattice says so much: exactly, where it is only drawn back.
    pub(super) fn drawn_back(&self, p: usize, stops: f64, by: &Standing) -> f64 {
        let (tool, setup) = (&self.tooling.tools[by.tool], &self.tooling.setups[by.setup]);
        let within = stops + self.tooling.stand_off;
        let exact = drawn_back(tool, setup, &self.surface[p], by.tip, within, self.part.distance());
        exact.filter(|_| self.found.beside[p].is_none()).unwrap_or(stops)
    }

    /// How the tool that comes nearest to a patch is held off, and how far, told from how far the lattice says.
    pub(super) fn obstructed(&self, p: usize, told: impl Fn(f64, &Standing) -> f64) -> Option<Obstructed> {
        let (stops, standing) = self.found.stops(p)?;
        let stops = told(stops, &standing);
        let (tool, setup) = (&self.tooling.tools[standing.tool], &self.tooling.setups[standing.setup]);
        let from = direction_in_file(self.part, setup.direction).to_string();
        let points = vec![reported(self.part, standing.tip)];
        let mut found =
            Obstructed { patch: p, tool: tool.name.clone(), from, stops, by: String::new(), way: None, points };
        let spacing = self.tooling.spacing;
        if let Some((m, (height, place))) = tool.meridian().and_then(|m| Some((m, strike(m, setup, standing.tip)?))) {
            // A layer strikes with what is widest in it.
            found.by = format!(", held off by its {}", m.role_at(height + 0.5 * spacing).word());
            // What is still outside where it strikes has to get in.
            let wide = 2.0 * m.largest_within(height - 1.0, height + stops + spacing).unwrap_or(m.cutter_radius());
            let [wide, deep] = [wide, stops].map(|v| short(round(v)));
            // It comes as near beside: what is in the way is the corner itself.
            let by_its_end = self.found.beside[p].is_some()
                && height < m.cutter_radius()
                && self.is_in_corner(p, m.cutter_radius() + spacing);
            found.way = Some(match by_its_end {
                true => format!(
                    "give the corner a fillet as large as the end of {} is round, or name a tool with a smaller end",
                    found.tool
                ),
                false => {
                    format!("open a way to this place, at least {wide} mm wide and {deep} mm deep from {}", found.from)
                }
            });
            found.points.push(reported(self.part, place));
        }
        Some(found)
    }
}
