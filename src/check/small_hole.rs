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
    what: "Measures rod-like void: round, square, hexagonal or star-shaped passages, through and blind. The diameter is that of the circle of equal area \
           at the narrowest section, and at the mouth of a hole that runs out to a point; the depth is the length over which the section stays alike.",
    why: "A hole below the limit closes: beads and cured resin shrink inwards, powder sinters in it or cannot be blown out.",
    how: "As AM102, on the void: the curve in which a plane across the axis cuts the surface is exact on the mesh; the bracket is its inscribed \
          and circumscribed circle about the centroid. Closed loops of edges beyond which the void widens on both sides, such as where two countersinks meet, are \
          holes too. What is judged here is not judged as a slot.",
    limits: "A round section whose circumscribed circle keeps the limit keeps it: facets may have taken the rest. Sections more than 1.5 times as \
             long as wide, by the rectangle about them, are slots, which narrow-gap judges, and so are bent ones: those not all seen from their centroid. The arms of a \
             star are judged by it too. A blind hole less deep than wide is a dimple and is not judged. \
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{TriangleMesh, cuboid, extruded};
    use crate::part::Up;

    /// A block with a closed void 6 mm high, its section a star of so many arms between two radii, stretched along x.
    fn star(arms: usize, [inner, outer]: [f64; 2], stretch: f64) -> (TriangleMesh, f64) {
        let n = 2 * arms;
        let corner = |i: usize| {
            let (s, c) = (std::f64::consts::PI * i as f64 / arms as f64).sin_cos();
            let r = if i.is_multiple_of(2) { outer } else { inner };
            [stretch * r * c, r * s]
        };
        let outline: Vec<[f64; 2]> = (0..n).map(corner).collect();
        let tips = (0..arms).map(|k| [(2 * k + n - 1) % n, 2 * k, 2 * k + 1]);
        let middle = (1..arms - 1).map(|k| [1, 2 * k + 1, 2 * k + 3]);
        let caps: Vec<[usize; 3]> = tips.chain(middle).collect();
        let void = extruded(&outline, &caps, 6.0);
        let void = if void.signed_volume() < 0.0 { void } else { void.flipped() };
        let area = -void.signed_volume() / 6.0;
        let (lo, hi) = void.bounds().unwrap();
        (cuboid(lo.map(|x| x - 3.0), hi.map(|x| x + 3.0)).joined(&void), area)
    }

    #[test]
    fn a_star_is_a_hole_as_wide_as_the_circle_of_its_area() {
        for (arms, radii, stretch, is_hole) in [
            (4, [0.3, 0.9], 1.0, true),
            (5, [0.35, 0.9], 1.0, true),
            (6, [0.5, 0.9], 1.0, true),
            (6, [0.4, 0.9], 1.25, true),
            (6, [0.4, 0.9], 2.2, false),
        ] {
            let (mesh, area) = star(arms, radii, stretch);
            let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
            let context = Context { refine: 1_000_000, spacing_mm: 0.2 };
            let Outcome::Measured(found) = SmallHole.run(&part, &Process::named("fdm").unwrap(), &context).unwrap()
            else {
                panic!()
            };
            let told: Vec<f64> = found.findings.iter().map(|f| f.value).collect();
            let wide = 2.0 * (area / std::f64::consts::PI).sqrt();
            match told[..] {
                [one] => assert!(is_hole && (one - wide).abs() < 1e-4, "{arms} {radii:?} {stretch}: {one} for {wide}"),
                _ => assert!(!is_hole && told.is_empty(), "{arms} {radii:?} {stretch}: {told:?}"),
            }
        }
    }
}
