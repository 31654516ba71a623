//! AM201: surface that hangs over.

use super::contract::{Check, Context, MapKind, MapWanted, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, Limits, State, Witness};
use super::place::{group_equal, locate, reported};
use crate::error::Result;
use crate::geometry::vector::along;
use crate::layer::{DownwardRegion, downward_regions};
use crate::part::Part;
use crate::process::Process;
use crate::units::{Angle, report_digits, short};

/// AM201 `overhang`.
pub struct Overhang;

static META: Meta = Meta {
    code: "AM201",
    name: "overhang",
    title: "Downward surface flatter than the process holds up",
    what: "Finds downward surface whose angle from the horizontal is below the limit: 0 degrees is a flat ceiling, 90 degrees a \
           vertical wall. The underside on the plate, up to half a layer, is no overhang.",
    why: "Such surface is printed on air: it droops or curls, or it needs supports, which cost material, time and surface.",
    how: "The slope of every facet decides, so angle and area are exact. Facets that hang together over edges bent by less than 20 \
          degrees are one region. A facet whose angle differs from the limit by less than a step of its coordinates can turn it is \
          equal to the limit, and passes.",
    limits: "Slope alone is judged: a short ledge or a bridge between two anchors may print well without support all the same. \
             Where the process prints supports an overhang warns; it fails only if the profile or the user gives a fail limit.",
    source: "The limit's sources stand in the profile; `amcheck processes` lists them.",
};

impl Check for Overhang {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        if process.powder_supports && limits_of(process, "overhang").is_none() {
            return Ok(Outcome::NotApplicable("loose powder holds the part up in this process".into()));
        }
        let Some(limits) = limits_of(process, "overhang") else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let widest = limits.fail.unwrap_or(0.0).max(limits.warn.unwrap_or(0.0));
        let regions =
            downward_regions(part.mesh(), 0.5 * process.layer_height_mm, Angle::degrees(widest), part.step(), |f| {
                covered(part, f)
            });
        let mut measured = Measured {
            cover: format!("Every facet that looks down at less than {}° was judged by its own slope.", short(widest)),
            rule: Some("overhang"),
            map: Some(MapWanted {
                kind: MapKind::Slope,
                title: "Overhang angle from the horizontal",
                unit: "deg",
                limits,
                open_end: 90.0,
                facets: Vec::new(),
                field: None,
            }),
            ..Measured::default()
        };
        let worst = regions.iter().min_by(|a, b| a.least_angle.as_radians().total_cmp(&b.least_angle.as_radians()));
        measured.worst = worst.map(|r| Worst {
            bracket: Bracket::exact(r.least_angle.as_degrees()),
            unit: "deg",
            at: Some(r.worst.0),
        });
        // What is smaller than a dot of the process is gathered in one finding.
        let dot = process.element.width_mm * process.element.width_mm;
        let (specks, regions): (Vec<_>, Vec<_>) = regions.iter().partition(|r| r.area_mm2 < dot);
        let judged = |list: &[&DownwardRegion], kind: &str| -> Vec<Finding> {
            let mut all: Vec<Finding> = list.iter().map(|r| finding(part, process, context, r, limits, kind)).collect();
            all.sort_by(|a, b| a.value.total_cmp(&b.value).then_with(|| Finding::worst_first(a, b)));
            all
        };
        measured.findings = group_equal(judged(&regions, "slope"), 0.5);
        measured.findings.extend(group_equal(judged(&specks, "specks"), 90.0));
        for f in &mut measured.findings {
            f.message = message(f);
            f.fix = fix(process, f);
        }
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// Whether material touches a facet from below.
fn covered(part: &Part, facet: u32) -> bool {
    if !part.bounds_solid(facet as usize) {
        return true;
    }
    !part.is_plain() && {
        let f = facet as usize;
        let below = along(part.mesh().centroid(f), part.mesh().normal(f), 20.0 * part.step());
        part.winding().at(below) >= 0.5
    }
}

fn finding(
    part: &Part,
    process: &Process,
    context: &Context,
    r: &DownwardRegion,
    limits: Limits,
    kind: &str,
) -> Finding {
    let bracket = Bracket::exact(r.least_angle.as_degrees());
    // The tie has been applied facet by facet, so what is left is below the limit.
    let mut f = Finding::judged(META.code, kind, bracket, Basis::Exact, limits, "deg", 0.0);
    if f.state == State::Pass {
        f.state = State::Warn;
    }
    f.area_mm2 = Some(report_digits(r.area_mm2));
    locate(&mut f, part, context, r.worst.0, r.extent);
    let layer = |z: f64| (z / process.layer_height_mm).floor().max(0.0) as u64;
    f.layers = Some([layer(r.extent.0[2]), layer(r.extent.1[2])]);
    let corners = part.mesh().corners(r.worst.1 as usize).map(|p| reported(part, p));
    f.witness = Some(Witness { kind: "facet".into(), points_mm: corners.to_vec() });
    f
}

fn message(f: &Finding) -> String {
    let area = short(f.area_mm2.unwrap_or(0.0));
    let angle = if f.value < 0.05 {
        "flat ceiling".to_string()
    } else {
        format!("{}° from the horizontal", short((f.value * 10.0).round() / 10.0))
    };
    match f.count {
        n if f.kind == "specks" => format!("{n} specks smaller than a dot, the flattest {angle}, {area} mm² in all"),
        1 => format!("{angle}, {area} mm² hanging over"),
        n => format!("{n} places, {angle}, {area} mm² hanging over in all"),
    }
}

fn fix(process: &Process, f: &Finding) -> String {
    let limit = f.warn.or(f.fail).unwrap_or(0.0);
    let slope = format!("slope it to {}° or more", short(limit));
    if process.prints_supports {
        format!("{slope}, turn the part, or let {} mm² be supported", short(f.area_mm2.unwrap_or(0.0)))
    } else {
        format!("{slope}, or turn the part; this process prints no supports")
    }
}
