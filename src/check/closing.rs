//! Holes, pins and struts that an offset closes or severs though no two of their sides oppose each other: those of three or five sides.

use super::contract::Context;
use super::finding::{Basis, Bracket, Finding, Limits};
use super::rods::{is_passage, placed, up_to};
use crate::geometry::distance::Nearest;
use crate::geometry::vector::{Vec3, along, distance, norm, scale, sub, unit};
use crate::medial::Side;
use crate::medial::inscribed::{Largest, Place, Region, Until, largest_ball};
use crate::medial::rod::{End, Rod, Rods};
use crate::medial::section::across;
use crate::part::Part;
use crate::process::Process;
use std::borrow::Cow;

/// The equal-area diameter of a triangle is up to so many times that of the circle in it, where it is up to 1.5 times as long as wide.
const TRIANGLE: f64 = 1.4;
/// Bound and ball that differ by less than this share of the offset are one.
const AGREE: f64 = 0.002;
/// Points that a search in one section may look at.
const MOST: usize = 1 << 14;
/// The least width beyond an open end, in shares of the narrowest section.
const WIDER: f64 = 0.9;
/// The least of the sections of an even rod, in shares of the greatest.
const EVEN: f64 = 0.9;
/// Steps between two stations of a rod at which its clearance is taken.
const STEPS: usize = 16;

/// A rod that an offset closes or severs.
pub(super) struct Closing<'a> {
    pub rod: &'a Rod,
    /// The offset at which it does: the largest ball in its narrowest section is not larger than the upper end, and a ball
    /// of the lower end passes all along its line.
    pub offset: Bracket,
}

/// The rods on a side, as far as offsets ask for them.
pub(super) fn rods_within<'a>(part: &'a Part, process: &Process, side: Side, offset: f64) -> Cow<'a, Rods> {
    part.rods(up_to(process, side, 2.0 * TRIANGLE * offset))
}

/// The rods that an offset closes or severs, but for those that findings speak for.
///
/// A way through a hole crosses its narrowest section, and so does what a pin holds together: once the offset is as large as the largest
/// ball about a point of that section, nothing passes. Below the least distance of the line's points to the surface it still does.
///
/// # Limits
/// What leads nowhere at an end, and is not about as wide all along, is left out: it becomes shorter. Rods are looked for from the middles of facets and beside the corners of long ones, and are at most 1.5 (material: 1.8) times as long as wide across: what is not found
/// is not proved to be absent.
///
/// # Cost
/// Some thousand nearest points for each rod that is narrow enough.
pub(super) fn closing<'a>(part: &Part, side: Side, rods: &'a Rods, offset: f64, known: &[Finding]) -> Vec<Closing<'a>> {
    let kind = if side == Side::Material { "lost" } else { "closed" };
    let spots: Vec<Vec3> =
        known.iter().filter(|f| f.kind == kind).flat_map(|f| &f.places).map(|s| part.to_build(s.at_mm)).collect();
    let narrow =
        rods.rods.iter().filter(|r| is_passage(side, r) && r.narrowest.inscribed < 2.0 * (offset - part.tie()));
    let narrow = narrow.filter(|r| (0..2).all(|end| !is_blocked(part, r, end)) || is_even(r));
    let unknown = narrow.filter(|r| !spots.iter().any(|p| r.nears(*p, 1.0)));
    let bracketed = unknown.filter_map(|rod| {
        let ball = largest_in_section(part, side, rod, offset)?;
        let low = clearance(part, rod).min(ball.radius);
        (ball.radius < offset - part.tie()).then(|| Closing { rod, offset: Bracket::new(ball.radius, low, ball.high) })
    });
    bracketed.collect()
}

/// Whether a rod leads nowhere at an end: it is closed there, or less wide beyond. Then a taper towards it only becomes shorter.
fn is_blocked(part: &Part, rod: &Rod, end: usize) -> bool {
    if rod.ends[end] == End::Ring {
        return false;
    }
    let last = rod.line.len().saturating_sub(1);
    let (at, before) = if end == 0 { (0, 1) } else { (last, last.saturating_sub(1)) };
    let (Some(at), Some(before)) = (rod.line.get(at), rod.line.get(before)) else { return true };
    let outward = unit(sub(at.0, before.0));
    let beyond = along(at.0, outward, at.1);
    rod.ends[end] == End::Closed
        || part.distance().first_hit(at.0, outward, 0.0, at.1).is_some()
        || part.distance().nearest(beyond, WIDER * 0.5 * rod.narrowest.inscribed).is_some()
}

/// Whether the sections of a rod are alike: once the narrowest is gone, so is about all of it.
fn is_even(rod: &Rod) -> bool {
    let widths = rod.line.iter().map(|s| s.1);
    widths.clone().fold(f64::INFINITY, f64::min) >= EVEN * widths.fold(0.0, f64::max)
}

/// The largest ball of a side about a point of a rod's narrowest section; `None` if the rod is all near its closed ends.
fn largest_in_section(part: &Part, side: Side, rod: &Rod, offset: f64) -> Option<Largest> {
    largest_in_plane((part, side), section_of(rod)?, offset)
}

/// The largest ball of a side about a point of a plane that is seen from a centre in it and no farther off than a radius.
pub(super) fn largest_in_plane(
    (part, side): (&Part, Side),
    (centre, axis, radius): (Vec3, Vec3, f64),
    offset: f64,
) -> Option<Largest> {
    let [u, v] = across(axis);
    let region = Region { centre, axes: [u, v, axis], half: [radius, radius, 0.0] };
    let until = Until { enough: offset, agree: AGREE * offset, most: MOST };
    largest_ball(part.distance(), region, until, |p, nearest| {
        let in_material = part.winding().at(p) > 0.5;
        match in_material == (side == Side::Material) {
            false => Place::Off,
            true if is_seen(part, centre, p, nearest) => Place::Within,
            true => Place::Unknown,
        }
    })
}

/// Centre, axis and radius of the narrowest section that is not as near to a closed end as it is wide: there the face across is nearer
/// than the sides, and nothing has to pass.
fn section_of(rod: &Rod) -> Option<(Vec3, Vec3, f64)> {
    let section = &rod.narrowest;
    let radius = 0.5 * section.circumscribed;
    if is_free(rod, section.centre) {
        return Some((section.centre, section.axis, radius));
    }
    let free = rod.line.windows(2).filter(|w| is_free(rod, w[0].0) && w[0].0 != w[1].0);
    let [at, next] = free.min_by(|a, b| a[0].1.total_cmp(&b[0].1))?.first_chunk::<2>()?;
    Some((at.0, unit(sub(next.0, at.0)), radius * at.1 / section.diameter()))
}

/// Whether a point of a rod's line is farther from its closed ends than the rod is wide on one side.
fn is_free(rod: &Rod, p: Vec3) -> bool {
    let caps = [(rod.ends[0], rod.line.first()), (rod.ends[1], rod.line.last())];
    let closed = caps.into_iter().filter(|c| c.0 == End::Closed).filter_map(|c| c.1);
    closed.map(|cap| distance(cap.0, p)).all(|far| far >= 0.5 * rod.narrowest.circumscribed)
}

/// Whether nothing lies between the middle of a section and a point: then it is a point of the same section.
fn is_seen(part: &Part, centre: Vec3, p: Vec3, nearest: &Nearest) -> bool {
    let way = sub(p, centre);
    let far = norm(way);
    far <= nearest.distance || part.distance().first_hit(centre, scale(way, 1.0 / far), 0.0, far).is_none()
}

/// A radius that balls about all points of a rod's line have for certain, but for what lies as near to a closed end as it is wide: the distance
/// to the surface changes by no more than the way.
fn clearance(part: &Part, rod: &Rod) -> f64 {
    let stations: Vec<(Vec3, f64)> = rod.line.iter().filter(|s| is_free(rod, s.0)).copied().collect();
    let far = |p: Vec3| part.distance().nearest(p, f64::INFINITY).map_or(0.0, |n| n.distance);
    let between = |w: &[(Vec3, f64)]| {
        let way = sub(w[1].0, w[0].0);
        let step = norm(way) / STEPS as f64;
        let at = |k: usize| far(along(w[0].0, way, k as f64 / STEPS as f64));
        (0..STEPS).map(|k| 0.5 * (at(k) + at(k + 1) - step)).fold(f64::INFINITY, f64::min)
    };
    let least = stations.windows(2).map(between).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least.max(0.0) } else { far(rod.narrowest.centre) }
}

/// The finding of a rod that an offset closes or severs.
pub(super) fn closing_finding(
    (part, context): (&Part, &Context),
    (code, side): (&str, Side),
    closing: &Closing,
    limits: Limits,
) -> Finding {
    let kind = if side == Side::Material { "lost" } else { "closed" };
    let mut f = Finding::judged(code, kind, closing.offset, Basis::Certified, limits, "mm", part.tie());
    placed(&mut f, part, context, closing.rod);
    f
}
