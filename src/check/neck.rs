//! The section at which a neck parts: nothing passes between the wider places on both sides of it.

use super::closing::largest_in_plane;
use crate::geometry::vector::{Vec3, along, dot, scale, sub, unit};
use crate::medial::inscribed::{Largest, grown};
use crate::medial::section::{Plane, Section, across, section};
use crate::medial::{Sample, Side};
use crate::part::Part;

/// Planes through a thin place that are tried, turned about the line between its sides.
const TURNS: usize = 8;
/// A section that reaches farther than so many of the offsets that are asked about is that of a wall.
const WITHIN: f64 = 8.0;
/// Balls on both sides of a neck are larger than the largest in its section by this ratio.
const WIDER: f64 = 1.005;
/// How far beside the section they are sought from, and by which steps, in shares of the largest ball in it.
const BESIDE: f64 = 0.3;
const STEP: f64 = 0.1;

/// The largest ball about a point of the narrowest plane section through a thin place, if larger ones lie on both sides of it: X ⊖ B_r is parted
/// there once r is as large, and the opposite offset joins what it parted again, or does not; `None` where no such section was found.
///
/// Planes through the line to a side of the place are tried, and that across its axis, if it is known to be thin from all sides. A section is
/// bounded by one curve of the surface, so that what goes from one side of the plane to the other beside the place goes through it.
///
/// # Cost
/// The facets along some curves, and some thousand nearest points.
pub(super) fn parting(
    (part, side): (&Part, Side),
    (thinnest, axis): (&Sample, Option<Vec3>),
    offset: f64,
) -> Option<Largest> {
    let narrowest = narrowest_section(part, (thinnest, axis), WITHIN * offset)?;
    let [centre, normal] = [narrowest.centre, narrowest.axis];
    let ball = largest_in_plane((part, side), (centre, normal, 0.5 * narrowest.circumscribed), offset)?;
    let widens = |sign: f64| {
        let from = along(ball.centre, normal, sign * BESIDE * ball.radius);
        let clear = part.distance().nearest(from, f64::INFINITY).map_or(0.0, |n| n.distance);
        let enough = WIDER * ball.high;
        // Where it climbs to need not contain where it came from.
        let top = grown(part.distance(), (from, f64::NEG_INFINITY), (from, clear), (STEP * ball.radius, enough));
        top.1 >= enough && sign * dot(sub(top.0, ball.centre), normal) > 0.0
    };
    [-1.0, 1.0].into_iter().all(widens).then_some(ball)
}

/// The section of the least area.
fn narrowest_section(part: &Part, (thinnest, axis): (&Sample, Option<Vec3>), within: f64) -> Option<Section> {
    let at = thinnest.centre;
    let way = unit(sub(thinnest.contacts[0], at));
    let [u, v] = across(way);
    let turned = (0..TURNS).map(|k| {
        let (s, c) = (std::f64::consts::PI * k as f64 / TURNS as f64).sin_cos();
        along(scale(u, c), v, s)
    });
    let given = axis.map(|axis| along(axis, way, -dot(axis, way))).filter(|axis| dot(*axis, *axis) > 0.25).map(unit);
    let next = part.adjacency();
    // The plane need not cut the facets of the contacts where these are edges and corners.
    let touched = [thinnest.facet, thinnest.opposite];
    let starts: Vec<u32> = touched.into_iter().chain(touched.into_iter().flat_map(|f| next.beside(f))).collect();
    let cut = |normal: Vec3| {
        let plane = Plane { point: at, normal };
        starts.iter().find_map(|start| section(part.mesh(), next, plane, *start, within))
    };
    turned.chain(given).filter_map(cut).min_by(|a, b| a.area.total_cmp(&b.area))
}
