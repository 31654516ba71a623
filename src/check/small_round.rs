//! Rounds in concave edges of a smaller radius than asked: the largest ball that touches the facets they are written with.

use super::fillet::Fillets;
use super::finding::{Basis, Bracket, Finding, Limits, State};
use super::notch::{CODE, MISSED, NAMED, Notches, RELIEF, rounded, sharp_bend};
use super::place::{group_equal, locate};
use super::resting::{Ball, Descent};
use super::round_corner::{chord_radius, corner_bend, divides_a_facet};
use super::shared_corner::{Corners, run};
use crate::geometry::vector::{Vec3, angle, bounds, cross, distance, norm, sub};
use crate::medial::cluster::principal_extents;
use crate::medial::reflex::{ReflexEdge, joined};
use crate::units::short;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// A ball that stays no further than this share of its radius from a round touches it.
const TOUCHED: f64 = 2e-3;
/// A ball that stays no further than this share of its radius from what it would touch fits a round as it was written.
const NEAR: f64 = 0.01;
/// How a round turns is seen from a ball of this share of the asked radius: one that the round is smaller than by enough to be told.
const LESS: f64 = 0.95;
/// Edges of a round that a ball stays away from by less than this share of the most lie towards its sides.
const DEEP: f64 = 0.5;
/// Edges of a round shorter than this share of its longest say nothing of it.
const CRUMB: f64 = 0.1;
/// Edges of a round that are measured.
const TRIED: usize = 9;
/// Radii that differ by less than this share of the asked one are equal.
const EQUAL: f64 = 0.05;

/// The rounds of a part, as a ball finds them that comes down over their edges in one way.
#[derive(Clone, Copy)]
pub(super) struct Rounds<'a> {
    notches: Notches<'a>,
    /// The sharp edges: what lies in a corner with one of them is told with that.
    sharp: &'a [ReflexEdge],
    descent: Descent,
}

impl<'a> Rounds<'a> {
    /// Of a part whose sharp edges are known.
    pub fn of(notches: Notches<'a>, sharp: &'a [ReflexEdge]) -> Self {
        Rounds { notches, sharp, descent: Descent::Straight }
    }

    /// Rounds of a smaller radius than asked.
    ///
    /// Between steep walls no ball comes straight out over an edge that does not lie in the middle of its round: there it is steered, and what it finds
    /// tells of a round that has no other edge.
    pub fn smaller(&self, shallow: &[ReflexEdge]) -> Vec<Finding> {
        let asked = self.notches.radius;
        let small: Vec<ReflexEdge> = shallow
            .par_iter()
            .map(|e| ReflexEdge { bend: corner_bend(self.notches.part, e), ..*e })
            .filter(|e| e.inscribed_radius() < 0.98 * asked)
            .collect();
        let straight = self.tight(&small);
        let found: BTreeSet<[u32; 2]> = straight.iter().map(|t| t.edge.ends).collect();
        let others: Vec<ReflexEdge> = small.into_iter().filter(|e| !found.contains(&e.ends)).collect();
        let steered = Rounds { descent: Descent::Steered, ..*self };
        let all = [&straight[..], &steered.tight(&others)].concat();
        let of_their_own = self.joined(&all).into_iter().filter(|members| members.iter().all(|&i| i >= straight.len()));
        let (mut findings, rooms): (Vec<Finding>, Vec<([f64; 3], bool)>) = self
            .joined(&straight)
            .into_iter()
            .map(|members| (self, members))
            .chain(of_their_own.map(|members| (&steered, members)))
            .filter_map(|(rounds, members)| rounds.round(&members.into_iter().map(|i| all[i]).collect::<Vec<_>>()))
            .map(|(f, fits)| (f.clone(), (f.at_mm, fits)))
            .unzip();
        findings.sort_by(|a, b| a.value.total_cmp(&b.value).then_with(|| Finding::worst_first(a, b)));
        let mut grouped = group_equal(findings, EQUAL * asked);
        for f in &mut grouped {
            let value = rounded(f.value);
            f.message = match f.count {
                1 => format!("fillet of about {value} mm"),
                n => format!("{n} fillets of about {value} mm"),
            };
            let own = |at: &[f64; 3]| f.places.iter().any(|p| p.at_mm == *at);
            let tried = |fits: bool| rooms.iter().filter(|r| r.1 == fits && own(&r.0)).count();
            f.fix = self.enlarged(f.value, [tried(true), tried(false)]);
            f.places.truncate(NAMED);
        }
        grouped
    }

    /// The edges of rounds of a smaller radius than asked, but for what lies in a corner with a sharp edge.
    fn tight(&self, small: &[ReflexEdge]) -> Vec<Tight> {
        let corners = Corners::new(self.notches.part, self.notches.radius, self.sharp).entered(self.descent);
        let is_apart = |t: &Tight| {
            let rest = self.rest(&t.edge, self.notches.radius, 0.0);
            rest.is_none_or(|centre| corners.holding(centre) == 0)
        };
        let tight = small.par_iter().filter_map(|edge| Some(Tight { missed: self.missed(edge)?, edge: *edge }));
        tight.filter(is_apart).collect()
    }

    /// Edges that share a vertex, or corners of facets beside them: not of a wall from one edge of it to the next, which is wider than any round is.
    fn joined(&self, tight: &[Tight]) -> Vec<Vec<usize>> {
        let (part, mesh) = (self.notches.part, self.notches.part.mesh());
        let of_a_round = |edge: &ReflexEdge, facet: u32| {
            let run = run(part, edge);
            let off = mesh.corners(facet as usize).map(|c| norm(cross(sub(c, edge.middle), run)));
            off.into_iter().all(|off| off <= 2.0 * self.notches.radius)
        };
        joined(tight, |t| {
            let facets = t.edge.facets.into_iter().filter(|&f| of_a_round(&t.edge, f));
            t.edge.ends.into_iter().chain(facets.flat_map(|f| mesh.triangles[f as usize])).collect()
        })
    }

    /// What trying the asked radius over rounds of another has shown, at `roomy` and `cramped` of them.
    fn enlarged(&self, radius: f64, [roomy, cramped]: [usize; 2]) -> String {
        let to = short(self.notches.radius);
        let hint = format!("enlarge the radius by {} mm to {to} mm", rounded(self.notches.radius - radius));
        let met = "the ball would rest on an edge beside it";
        match [roomy, cramped] {
            [_, 0] => format!("{hint}: there is room for it, checked on the surface"),
            [0, _] => format!("there is no room to enlarge the radius to {to} mm: {met}"),
            [n, m] => {
                format!("{hint}: checked on the surface, there is room at {n} of {} places; elsewhere {met}", n + m)
            }
        }
    }

    /// How far a ball of the asked radius stays away from an edge of a round, if by more than a tenth of what its radius is larger by.
    ///
    /// Over a round that turns by φ that is 1/cos(φ/2) − 1: one that turns no further than the least of sharp edges is none. By as much the
    /// middle of a ball that grows rises beyond its radius.
    fn missed(&self, edge: &ReflexEdge) -> Option<f64> {
        let rest = self.rest(edge, self.notches.radius, touching(edge) + NEAR)?;
        let missed = distance(rest, edge.middle) - self.notches.radius;
        let smaller = self.notches.radius - missed / MISSED;
        let less = LESS * self.notches.radius;
        let rises = |before: Vec3| distance(rest, before) > (1.0 + MISSED) * (self.notches.radius - less);
        let turns = (smaller <= 0.0 || !self.misses(edge, smaller, touching(edge)))
            && self.rest(edge, less, 0.0).is_none_or(rises);
        turns.then_some(missed)
    }

    /// Whether a ball of radius r comes down over an edge and stays more than a share of r away.
    fn misses(&self, edge: &ReflexEdge, r: f64, share: f64) -> bool {
        self.rest(edge, r, share).is_some()
    }

    /// Where the centre of a ball of radius r comes to rest over an edge, if the ball stays more than a share of r away.
    fn rest(&self, edge: &ReflexEdge, r: f64, share: f64) -> Option<Vec3> {
        Ball { part: self.notches.part, radius: r, descent: self.descent }.rest(edge.middle, edge.outward(), share)
    }

    /// The largest ball, up to the asked radius, that touches the facets beside an edge, and the largest radius of a round that they are facets of:
    /// its facets may be its chords.
    fn largest(&self, edge: &ReflexEdge) -> (f64, f64) {
        let share = touching(edge);
        let (mut low, mut high) = (0.0, self.notches.radius);
        while high - low > TOUCHED * self.notches.radius {
            let middle = 0.5 * (low + high);
            if self.misses(edge, middle, share) { high = middle } else { low = middle }
        }
        (low, high / (0.5 * edge.bend).cos())
    }

    /// The share by which a ball that is taken to touch a round is larger than it at most: in one that turns by φ, a ball larger by ΔR stays
    /// ΔR·(1/cos(φ/2) − 1) away from its bottom, and half of it where the round is measured.
    fn too_large(&self, edges: &[Tight]) -> f64 {
        let normals = || edges.iter().flat_map(|t| t.edge.normals);
        let turn = normals().map(|n| normals().take(2).map(|m| angle(m, n)).fold(0.0, f64::max)).fold(0.0, f64::max);
        TOUCHED / (DEEP * (1.0 / (0.5 * turn).cos() - 1.0).max(MISSED))
    }

    /// The edges at which a round is measured: the longest of those that the asked ball stays far from, and the one where it stays farthest from
    /// it, which is where it is narrowest. What divides its facets is none, unless there is nothing else.
    fn measured<'b>(&self, edges: &'b [Tight]) -> Vec<&'b ReflexEdge> {
        let missed = most_missed(edges);
        let mut longest: Vec<&Tight> = edges.iter().collect();
        longest.sort_by(|a, b| b.edge.length.total_cmp(&a.edge.length));
        let is_corner = |t: &&Tight| !divides_a_facet(self.notches.part, &t.edge, self.notches.radius, sharp_bend());
        let is_deep = |t: &&Tight| t.missed >= DEEP * missed;
        let mut measured: Vec<&Tight> = longest.iter().copied().filter(is_deep).filter(is_corner).take(TRIED).collect();
        if measured.is_empty() {
            measured = longest.iter().copied().filter(is_deep).take(TRIED).collect();
        }
        let crumb = measured.first().map_or(0.0, |t| CRUMB * t.edge.length);
        measured.retain(|t| t.edge.length >= crumb);
        longest.retain(|t| t.edge.length >= crumb);
        longest.sort_by(|a, b| b.missed.total_cmp(&a.missed));
        measured.extend(longest.iter().copied().find(is_corner).or(longest.first().copied()));
        measured.into_iter().map(|t| &t.edge).collect()
    }

    /// One round, if it is long enough to be a fillet: the median over the longest of its edges that the asked ball stays far from, or what is
    /// there where it stays farthest from it, if that is clearly less.
    ///
    /// And whether a ball of the asked radius comes to rest on faces beside it.
    fn round(&self, edges: &[Tight]) -> Option<(Finding, bool)> {
        let vertices = &self.notches.part.mesh().vertices;
        let ends: Vec<_> = edges.iter().flat_map(|t| t.edge.ends).map(|v| vertices[v as usize]).collect();
        let long = principal_extents(&ends)[0];
        if long < RELIEF * self.notches.least {
            return None;
        }
        // What is relief by the warn limit may fail all the same.
        let warn = self.notches.limits.warn.filter(|warn| long >= RELIEF * warn);
        let limits = Limits { warn, ..self.notches.limits };
        let missed = most_missed(edges);
        let longest = self.measured(edges);
        let lead = *longest.first()?;
        let fits = |e: &&ReflexEdge| {
            let rest = self.rest(e, self.notches.radius, touching(e));
            rest.is_some_and(|centre| Fillets(self.notches.part).lies_on_a_face(centre, self.notches.radius))
        };
        let has_room = longest.iter().all(fits);
        // A ball larger than the circle whose chords they are may touch all of few facets.
        let circle = longest.iter().map(|e| chord_radius(self.notches.part, e)).fold(0.0, f64::max);
        let mut radii: Vec<((f64, f64), Vec3)> = longest.into_iter().map(|e| (self.largest(e), e.middle)).collect();
        radii.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
        let (least, ((middling, _), _)) = (*radii.first()?, *radii.get(radii.len() / 2)?);
        let low = least.0.0 * (1.0 - self.too_large(edges));
        // One that narrows is told by its narrowest place.
        let narrows = least.0.0 < middling - EQUAL * self.notches.radius;
        let ((radius, high), at) =
            if narrows { least } else { ((middling, radii.iter().map(|r| r.0.1).fold(0.0, f64::max)), lead.middle) };
        let bracket = Bracket::new(radius.min(circle), low.min(circle), high.min(circle));
        let mut f = Finding::judged(CODE, "round", bracket, Basis::Estimated, limits, "mm", self.notches.part.tie());
        // A round of few facets that may be as large as asked is told where the ball misses it as it misses a sharp edge.
        if f.state == State::Pass || (f.high >= self.notches.radius && missed <= MISSED * self.notches.radius) {
            return None;
        }
        locate(&mut f, self.notches.part, self.notches.context, at, bounds(ends)?);
        Some((f, has_room))
    }
}

/// An edge of a round, and how far the asked ball stays away from it.
#[derive(Clone, Copy)]
struct Tight {
    edge: ReflexEdge,
    missed: f64,
}

/// How far the asked ball stays away from a round where it stays farthest from it.
fn most_missed(edges: &[Tight]) -> f64 {
    edges.iter().map(|t| t.missed).fold(0.0, f64::max)
}

/// The share of its radius that a ball stays away from an edge whose two facets it touches.
fn touching(edge: &ReflexEdge) -> f64 {
    1.0 / (0.5 * edge.bend).cos() - 1.0 + TOUCHED
}
