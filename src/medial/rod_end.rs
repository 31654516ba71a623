//! What is beyond the ends of a rod: a face across it, a point, something wider, or a narrower rod.

use super::rod::{End, Search, TAPER};
use super::section::{Plane, Section, across, eight_across, section};
use crate::geometry::vector::{Vec3, along, dot, norm, sub, unit};

/// An end this near, in diameters, closes the rod.
const CLOSED: f64 = 0.75;
/// Of eight directions beyond an end those in which a rod as wide leads on aside, however it stands; one may be a ray that slips through.
const LEADS_ON: usize = 2;
/// Where that is looked at, in shares of the way to the cap, besides just beyond the end.
const ASIDE: [f64; 2] = [0.5, 0.8];
/// Or a section so many times as wide as the end's: of a plate only the directions in its plane lead on.
const SWOLLEN: f64 = 1.1;
/// A point so far, in diameters, closes it if the sides draw together all the way, more steeply than a rod's.
const POINTED: f64 = 4.0;
/// Where that is looked at, in shares of the way, and the least sine.
const BEFORE: [f64; 3] = [0.25, 0.5, 0.75];
const DRAWN_IN: f64 = 0.8 * TAPER;
/// A point is no farther than so many diameters of the last section: sides that draw together by half a degree.
const SLIMMEST: f64 = 114.0;

impl Search<'_> {
    /// Whether a rod that stops being alike goes on with a narrower section.
    pub(super) fn narrows(&self, end: Option<&Section>, inner: Option<&Section>, kind: End) -> bool {
        let (Some(end), Some(inner), End::Open) = (end, inner, kind) else { return false };
        let outward = unit(sub(end.centre, inner.centre));
        let beyond = self.settled(along(end.centre, outward, 0.02 * end.diameter()), end.axis);
        beyond.is_some_and(|s| s.diameter() < 0.9 * end.diameter())
    }

    /// Where a rod that stops being alike is closed, by a face or by sides that draw together to a point, with the width of its end.
    pub(super) fn closed(&self, end: &Section, inner: &Section, kind: End) -> Option<(Vec3, f64)> {
        if kind != End::Open {
            return None;
        }
        let outward = unit(sub(end.centre, inner.centre));
        let far = self.cap(end, outward)?;
        let beyond = |t: f64| along(end.centre, outward, t);
        let draws_in = || BEFORE.iter().all(|share| self.draws_in(beyond(share * far), end, outward));
        // What leads on aside may do so anywhere before the cap.
        let leads_on = || {
            let looked = [0.5 * far.min(0.2 * end.diameter()), ASIDE[0] * far, ASIDE[1] * far];
            looked.into_iter().any(|t| self.widens(beyond(t), end) || self.swells(beyond(t), end, outward))
        };
        let is_closed = (far <= CLOSED * end.diameter() || draws_in()) && !leads_on();
        is_closed.then_some((along(end.centre, outward, far), end.diameter()))
    }

    /// Distance from the end of a rod to a face across it, if one is near, else to a point.
    fn cap(&self, end: &Section, outward: Vec3) -> Option<f64> {
        let [u, v] = across(end.axis);
        // Beside the axis: a fan of facets has its tip on it, where rays slip through. The nearer ones reach into a point.
        let beside = [(0.002, 0.003), (0.05, 0.011), (-0.031, 0.043), (-0.017, -0.05)];
        let hits = beside.into_iter().filter_map(|(a, b)| {
            let from = [0, 1, 2].map(|x| end.centre[x] + end.inscribed * (a * u[x] + b * v[x]));
            self.distance.first_hit(from, outward, 0.0, POINTED * end.diameter()).map(|(far, _)| far)
        });
        let hits: Vec<f64> = hits.collect();
        // What slips through near the axis does not open an end.
        let near = hits.iter().copied().filter(|far| *far <= CLOSED * end.diameter()).reduce(f64::max);
        near.or_else(|| hits.into_iter().reduce(f64::max))
    }

    /// What is met from a point beyond the end of a rod, straight aside in eight directions, as far as the rod is wide and a little more.
    fn beside(&self, beyond: Vec3, end: &Section) -> [Option<u32>; 8] {
        eight_across(end.axis)
            .map(|d| self.distance.first_hit(beyond, d, 0.0, 0.55 * end.circumscribed).map(|(_, facet)| facet))
    }

    /// Whether there is more of the side's stuff beside a point beyond the end of a rod than its section holds.
    fn widens(&self, beyond: Vec3, end: &Section) -> bool {
        self.beside(beyond, end).iter().filter(|met| met.is_none()).count() >= LEADS_ON
    }

    /// Whether the section across a rod's way, at a point beyond its end, is wider than the end's: of a plate as thick as the rod only what lies
    /// in its plane leads on.
    fn swells(&self, beyond: Vec3, end: &Section, outward: Vec3) -> bool {
        let within = 0.5 * self.wanted.elongation * self.wanted.within;
        let start = self.distance.first_hit(beyond, across(outward)[0], 0.0, within).map(|(_, facet)| facet);
        let plane = Plane { point: beyond, normal: outward };
        let found = start.and_then(|start| section(self.mesh, self.next, plane, start, 1.5 * within));
        found.is_none_or(|s| s.diameter() > SWOLLEN * end.diameter())
    }

    /// Whether the sides about a point beyond the end of a rod draw together, more steeply than those of a rod.
    fn draws_in(&self, beyond: Vec3, end: &Section, outward: Vec3) -> bool {
        let leans = |f: u32| self.wanted.side.sign() * dot(self.distance.normal(f), outward) >= DRAWN_IN;
        self.beside(beyond, end).into_iter().all(|met| met.is_some_and(leans))
    }
}

/// Where the sides of a rod meet beyond its end, as they draw together from the section before that, with a diameter of nothing.
pub(super) fn apex(end: &Section, inner: &Section) -> Option<(Vec3, f64)> {
    let way = sub(end.centre, inner.centre);
    let shrinks = inner.diameter() - end.diameter();
    let far = (norm(way) * end.diameter() / shrinks).min(SLIMMEST * end.diameter());
    (shrinks > 0.0).then(|| (along(end.centre, unit(way), far), 0.0))
}

/// Ends a way at its first section from which on all are thinner than that, if there is one.
pub(super) fn run_out(way: &mut Vec<Section>, point: f64) -> Option<End> {
    let thick = way.iter().rposition(|s| s.diameter() >= point).map_or(0, |at| at + 1);
    (thick < way.len()).then(|| {
        way.truncate(thick + 1);
        End::Point
    })
}
