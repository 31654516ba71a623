//! AM104: round passages smaller than the process keeps open.

use super::contract::{Check, Context, Measured, Meta, Outcome, limits_of};
use super::finding::{Finding, State};
use super::place::group_equal;
use super::rods::{as_judged, diameter_finding, looked, plain, remedy, search, worst};
use crate::error::Result;
use crate::medial::Side;
use crate::medial::rod::{End, Rod};
use crate::part::Part;
use crate::process::Process;
use crate::units::short;

/// AM104 `small-hole`.
pub struct SmallHole;

static META: Meta = Meta {
    code: "AM104",
    name: "small-hole",
    title: "Diameter of holes",
    what: "Measures rod-like void: round, square or hexagonal passages, through and blind. The diameter is that of the circle of equal area \
           at the narrowest section, and at the mouth of a hole that runs out to a point; the depth is the length over which the section stays alike.",
    why: "A hole below the limit closes: beads and cured resin shrink inwards, powder sinters in it or cannot be blown out.",
    how: "As AM102, on the void: the curve in which a plane across the axis cuts the surface is exact on the mesh; the bracket is its inscribed \
          and circumscribed circle about the centroid. Closed loops of edges beyond which the void widens on both sides, such as where two countersinks meet, are \
          holes too. What is judged here is not judged as a slot.",
    limits: "A round section whose circumscribed circle keeps the limit keeps it: facets may have taken the rest. Sections more than 1.5 times as \
             long as wide are slots, which narrow-gap judges. A blind hole less deep than wide is a dimple and is not judged. \
             Where holes cross, each piece up to the crossing is a hole of its own.",
    source: "Limits: see the profile.",
};

impl Check for SmallHole {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let (Some(limits), Some(found)) = (limits_of(process, "small-hole"), search(part, process, Side::Void)) else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let judged: Vec<Rod> = found.rods.iter().filter_map(|r| as_judged(Side::Void, r)).collect();
        let (holes, dimples): (Vec<&Rod>, usize) = (judged.iter().collect(), found.rods.len() - judged.len());
        let mut findings: Vec<Finding> = holes
            .iter()
            .map(|r| {
                let mut f = diameter_finding((part, context), (META.code, "hole"), r, limits);
                f.message = form(r);
                f
            })
            .filter(|f| f.state > State::Pass)
            .collect();
        findings.sort_by(Finding::worst_first);
        let mut findings = group_equal(findings, 0.004);
        for f in &mut findings {
            let (place, value) = (std::mem::take(&mut f.message), plain(f.value));
            f.message = match f.count {
                1 => format!("hole of {value} mm, {place}"),
                n => format!("{n} holes of {value} mm, the first {place}"),
            };
            f.fix = remedy(part, process, Side::Void, &holes, f);
        }
        let mut cover = looked(&found, holes.len(), "holes");
        if dimples > 0 {
            cover.push_str(&format!(" {dimples} dimples less deep than wide were left aside."));
        }
        Ok(Outcome::Measured(Box::new(Measured {
            worst: worst(holes),
            findings,
            cover,
            rule: Some("small-hole"),
            ..Measured::default()
        })))
    }
}

/// Depth, axis and ends in words.
fn form(rod: &Rod) -> String {
    let [x, y, z] = rod.narrowest.axis.map(|c| short((c * 100.0).round() / 100.0));
    if rod.is_orifice && rod.length == 0.0 {
        return format!("an orifice between wider passages, along ({x}, {y}, {z})");
    }
    if rod.ends.contains(&End::Point) {
        return format!("at its mouth, running out to a point over {} mm, along ({x}, {y}, {z})", plain(rod.length));
    }
    let kind = match rod.ends.iter().filter(|e| **e == End::Closed).count() {
        _ if rod.ends.contains(&End::Ring) => "a closed ring",
        0 => "through",
        1 => "blind",
        _ => "closed at both ends",
    };
    format!("{kind}, {} mm deep, along ({x}, {y}, {z})", plain(rod.length))
}
