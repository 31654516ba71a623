//! AM206: what the part stands on.

use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, State};
use super::place::locate;
use crate::error::Result;
use crate::layer::{section_area, shadow_area};
use crate::part::Part;
use crate::process::Process;
use crate::units::{coarse, report_digits, short};

/// AM206 `bed-contact`.
pub struct BedContact;

static META: Meta = Meta {
    code: "AM206",
    name: "bed-contact",
    title: "Area that stands on the plate",
    what: "Measures the area of the first layer and its share of the part's shadow on the plate, and the area of the facets that lie on \
           the plate.",
    why: "The first layer holds the whole part. Where little of it stands on the plate it comes loose: it warps, is pushed over, or needs \
          a brim, a raft or supports to stand.",
    how: "The first layer's area is the section at half its height, exact from the facets below it by the divergence theorem; facets \
          on the plate add up exactly. The shadow is bounded column by column: at least what is \
          solid at some height, at most all upward surface.",
    limits: "What supports and brims add is not counted. Adhesion depends on material and plate; the limit is a convention.",
    source: "A convention of this program; no published limit was found.",
};

impl Check for BedContact {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let Some(limits) = limits_of(process, "bed-contact") else {
            let why = if process.powder_supports {
                "the part lies in powder and stands on nothing"
            } else {
                "the process sets no limit for it: supports or welding hold the part"
            };
            return Ok(Outcome::NotApplicable(why.into()));
        };
        let sound = part.is_plain();
        let [low, high] = shadow_area(part.mesh(), |f| part.bounds_solid(f), context.spacing_mm);
        let mid = 0.5 * (low + high);
        // What is thinner than a layer is cut at half its own height.
        let level = 0.5 * process.layer_height_mm.min(part.extent()[2]);
        let first = section_area(part.mesh(), |f| part.bounds_solid(f), level).max(0.0);
        let contact = contact_area(part);
        // The shadow is at least the first layer.
        let low = low.max(first).max(f64::MIN_POSITIVE);
        let bracket = Bracket::new(first / mid.max(low), first / high.max(low), (first / low).min(1.0));
        let mut measured = Measured {
            worst: Some(Worst { bracket, unit: "1", at: None }),
            cover: format!(
                "First layer {} mm², facets on the plate {} mm², shadow {} mm².",
                short(first),
                short(contact),
                short(mid)
            ),
            rule: Some("bed-contact"),
            ..Measured::default()
        };
        let basis = if sound { Basis::Certified } else { Basis::Estimated };
        // Each side of the first layer, and of the shadow, is as the file's coordinates tell it.
        let tie = bracket.value * 4.0 * part.tie() / first.sqrt().max(part.tie());
        let mut f = Finding::judged(META.code, "contact", bracket, basis, limits, "1", tie);
        if f.state != State::Pass {
            let limit = limits.warn.or(limits.fail).unwrap_or(0.0);
            f.area_mm2 = Some(report_digits(first));
            f.layers = Some([0, 0]);
            f.message = format!(
                "first layer of {} mm² is {} % of the part's shadow of {} mm²",
                coarse(first),
                short((1000.0 * bracket.value).round() / 10.0),
                coarse(mid)
            );
            f.fix = format!("add a brim: {} mm² more would do", short((limit * high - first).max(0.0).ceil()));
            let extent = part.extent();
            locate(
                &mut f,
                part,
                context,
                [0.5 * extent[0], 0.5 * extent[1], 0.0],
                ([0.0; 3], [extent[0], extent[1], 0.0]),
            );
            measured.findings.push(f);
        }
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// Area of the facets that lie on the plate and look down.
fn contact_area(part: &Part) -> f64 {
    let mesh = part.mesh();
    let on_plate = part.step().max(1e-4);
    (0..mesh.triangles.len())
        .filter(|&f| part.bounds_solid(f) && mesh.corners(f).iter().all(|p| p[2] <= on_plate))
        .map(|f| (-0.5 * mesh.area_vector(f)[2]).max(0.0))
        .sum()
}
