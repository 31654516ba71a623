//! AM102: pins and wires thinner or more slender than the process makes.

use super::contract::{Check, Context, Measured, Meta, Outcome, limits_of};
use super::finding::{Basis, Bracket, Finding, Limits, State};
use super::place::group_equal;
use super::rods::{as_judged, diameter_finding, fit, looked, placed, plain, remedy, search, worst};
use super::room::{Fit, Growth, NO_ROOM};
use crate::error::Result;
use crate::geometry::vector::{bounds, distance};
use crate::medial::Side;
use crate::medial::rod::{End, Rod};
use crate::part::Part;
use crate::process::Process;
use crate::units::short;

/// AM102 `thin-pin`.
pub struct ThinPin;

static META: Meta = Meta {
    code: "AM102",
    name: "thin-pin",
    title: "Diameter of pins",
    what: "Measures rod-like material: pins and wires with a free end, with a head or without, that are about as wide in every direction across an axis and at least as \
           long as wide. The diameter is that of the circle of equal area at the narrowest section, and at the root of what runs out to a point; height over diameter is the slenderness, with the mean diameter where \
           a pin tapers.",
    why: "A thin pin has a handful of beads or spots in each layer: it is bent by the next pass, burnt for want of cooling time, or snaps off \
          when it is cleaned.",
    how: "From the middle of each facet, and from beside the corners of long ones, a ray goes straight across; where one at right angles to it meets two sides about as near, the surface is \
          cut by the plane of both and the axis turned until the sides along the cut are parallel to it. The curve is exact on the mesh: the \
          bracket is its inscribed and circumscribed circle about the centroid. The section is followed both ways to where it changes. \
          What is judged here is not judged as a wall.",
    limits: "A round section whose circumscribed circle keeps the limit keeps it: facets may have taken the rest. Sections more elongated than 1.8 \
             (1 by 1.5 mm) are walls, and so are struts \
             held at both ends of which two sides face each other. Sides that draw together by more than 30 degrees are no pin's, and what runs out to a point, or is wound up to less than a third of its length, is not judged by its slenderness. \
             Pins wider than 3.75 mm and a quarter beyond the limit of their diameter are not looked for. A pin on which no such place lies \
             is not seen as one; below the wall limit it is then found as a wall.",
    source: "Limits: see the profile.",
};

/// A rod so many times as long as its box is wide is wound up.
const WOUND: f64 = 3.0;

impl Check for ThinPin {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let (Some(limits), Some(found)) = (limits_of(process, "thin-pin"), search(part, process, Side::Material))
        else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let judged: Vec<Rod> = found.rods.iter().filter_map(|r| as_judged(Side::Material, r)).collect();
        let pins: Vec<&Rod> = judged.iter().collect();
        let mut findings: Vec<Finding> =
            pins.iter().map(|r| too_thin(part, context, r, limits)).filter(|f| f.state > State::Pass).collect();
        if let Some(most) = limits_of(process, "thin-pin.slenderness") {
            let thickened = Growth::new(part, process, Side::Material);
            findings.extend(pins.iter().filter_map(|r| too_slender((part, context), r, most, &thickened)));
        }
        findings.sort_by(Finding::worst_first);
        let mut findings = group_equal(findings, 0.004);
        findings.iter_mut().for_each(describe);
        for f in findings.iter_mut().filter(|f| f.kind == "pin") {
            f.fix = remedy(part, process, Side::Material, &pins, f);
        }
        let mut cover = looked(&found, pins.len(), "pins");
        let is_wall = |r: &&Rod| r.ends == [End::Open; 2] && r.narrowest.is_faced && r.length >= r.diameter();
        let struts = found.rods.iter().filter(is_wall).count();
        if struts > 0 {
            cover.push_str(&format!(" {struts} struts held at both ends are judged as walls."));
        }
        Ok(Outcome::Measured(Box::new(Measured {
            worst: worst(pins),
            findings,
            cover,
            rule: Some("thin-pin"),
            ..Measured::default()
        })))
    }
}

fn too_thin(part: &Part, context: &Context, rod: &Rod, limits: Limits) -> Finding {
    let mut f = diameter_finding((part, context), (META.code, "pin"), rod, limits);
    f.message = form(rod);
    f
}

/// A pin with a free end that is too high for its diameter.
fn too_slender((part, context): (&Part, &Context), rod: &Rod, limits: Limits, thickened: &Growth) -> Option<Finding> {
    if rod.ends.contains(&End::Point) || !rod.ends.iter().any(|end| [End::Closed, End::Head].contains(end)) {
        return None;
    }
    if winds(rod) {
        return None;
    }
    let widest = rod.line.iter().map(|s| s.1).fold(rod.narrowest.circumscribed, f64::max);
    let [low, high] = [widest, rod.narrowest.inscribed].map(|d| rod.length / d.max(1e-9));
    let slenderness = rod.length / rod.mean_diameter();
    // The circle that a round section may stand for is wider.
    let rounder = rod.length / (rod.mean_diameter() + rod.narrowest.facet_loss()).max(1e-9);
    let tie = 1e-6 + slenderness - rounder;
    let mut f = Finding::judged(META.code, "slender-pin", Bracket::exact(slenderness), Basis::Exact, limits, "1", tie);
    let b = Bracket::new(slenderness, low, high).rounded();
    (f.low, f.high) = (b.low, b.high);
    placed(&mut f, part, context, rod);
    f.message = format!("{} mm in diameter, {}", plain(rod.mean_diameter()), form(rod));
    let limit = f.fail.filter(|l| rounder > *l).or(f.warn)?;
    // Rounded so that what was followed to the letter keeps the limit.
    let [to, short_to] = [(1e2 * rod.length / limit).ceil() / 1e2, (1e2 * rod.mean_diameter() * limit).floor() / 1e2];
    let by = 0.5 * (to - rod.narrowest.inscribed).max(0.0);
    let thicken = match fit(part, rod, (by, thickened.beside), &[]) {
        Fit::Roomy => format!("thicken to {} mm: there is room for it, checked on the surface; or ", plain(to)),
        _ => format!("{NO_ROOM} to thicken it to {} mm; ", plain(to)),
    };
    f.fix = format!("{thicken}shorten to {} mm", plain(short_to));
    (f.state > State::Pass).then_some(f)
}

/// Whether a rod is wound up, as a spring is: it is no higher for its length.
fn winds(rod: &Rod) -> bool {
    let reach = bounds(rod.line.iter().map(|s| s.0)).map_or(0.0, |(lo, hi)| distance(lo, hi));
    rod.length > WOUND * reach
}

/// Height, axis and ends in words.
fn form(rod: &Rod) -> String {
    let [x, y, z] = rod.narrowest.axis.map(|c| short((c * 100.0).round() / 100.0));
    let held = match rod.ends.iter().filter(|e| **e == End::Closed).count() {
        _ if rod.ends.contains(&End::Ring) => "a closed ring",
        _ if rod.ends.contains(&End::Point) => "running out to a point",
        _ if rod.ends.contains(&End::Head) => "with a head that nothing else holds",
        _ if rod.ends.contains(&End::Narrower) => "stepped",
        0 => "held at both ends",
        1 => "free at one end",
        _ => "free at both ends",
    };
    format!("{} mm long, {held}, along ({x}, {y}, {z})", plain(rod.length))
}

/// Completes message and fix once the count is known.
fn describe(f: &mut Finding) {
    let place = std::mem::take(&mut f.message);
    let value = plain(f.value);
    let (one, many) = match f.kind.as_str() {
        "pin" => (format!("pin of {value} mm, {place}"), format!("pins of {value} mm, the first {place}")),
        _ => (
            format!("pin {value} times as high as wide, {place}"),
            format!("pins {value} times as high as wide, the first {place}"),
        ),
    };
    f.message = if f.count == 1 { one } else { format!("{} {many}", f.count) };
}
