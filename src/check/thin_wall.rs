//! AM101: walls thinner than the process makes.

use super::contract::{Check, Context, MapKind, MapWanted, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, Limits, State, Witness};
use super::for_good::Told;
use super::place::{group_equal, locate, reported};
use super::rods::{judged, necks, plain};
use super::room::{Beside, Fit, Growth};
use super::sheet::{Kind, Reading, Sheets};
use super::thin_body::{ThinBody, room_in, thin_bodies};
use crate::error::Result;
use crate::medial::Side;
use crate::part::Part;
use crate::process::Process;
use crate::units::{enough, report_digits, short};
use rayon::prelude::*;

/// AM101 `thin-wall`.
pub struct ThinWall;

static META: Meta = Meta {
    code: "AM101",
    name: "thin-wall",
    title: "Thickness of walls",
    what: "Measures the thickness of material between two opposing surfaces: the diameter of the largest ball inside that touches \
           both, where its contacts are at least 150 degrees apart. A body with no such surfaces is as thick as the distance of the two \
           parallel planes it lies between; the largest ball found in it bounds that from below.",
    why: "A wall thinner than a bead, a spot or a few pixels is dropped, broken or warped; which of these depends on the slicer, \
          but none of them is the designed wall.",
    how: "All pairs of opposing features of the mesh are searched by branch and bound: where no chord between opposing features is \
          shorter than the limit there is no wall that thin, and this is a proof. Where there is one, an empty ball between the \
          two is the witness; it is measured on the mesh, not on voxels. Equal places are one finding with a count. A sheet with a limit \
          within its bracket is searched again, feature by feature, until the limit is told or the budget ends; what is thinner \
          and lies by another sheet is told there.",
    limits: "A convex edge is no wall. Where sides lean towards each other by up to 40 degrees, and others there that lean by 30 at most are as near to within a twentieth, \
             the place counts as a wall: it is as thin as that either way. What is thin over less than its own thickness squared is a neck at one spot: it has no area that could break or be dropped, so it warns and never fails, unless it is a rod or a waist that holds two pieces together, or a body of its own that is no wider, which is judged like any wall; a waist that three sides hold is not seen. A body thin as a whole is measured along the normals of its 64 largest facets and 13 directions of a cube. A sheet that tapers by more than 30 degrees, or by 4 and more to an edge of up to 60 degrees, is a wedge, which knife-edge judges: what of it runs out to the edge is left \
             to that, and what is behind counts. One that grows again beyond its thinnest place is a wall however thin \
             (a ball there stands for what lies within three quarters of its width), \
             and a pin with a free end is judged by thin-pin. What is thin over less than a sixteenth of the search resolution is not looked for; the cover line gives the \
             number. Bodies that overlap or touch are united first; \
             where that makes no closed surface, as the notes say, facets count whole.",
    source: "Medial balls: J. Ma, S. W. Bae, S. Choi, 3D medial axis point approximation using nearest neighbors and the normal field, 2012. \
             Limits: see the profile.",
};

impl Check for ThinWall {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let Some(limits) = limits_of(process, "thin-wall") else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let sheets = Sheets {
            part,
            process,
            context,
            code: META.code,
            side: Side::Material,
            kinds: vec![Kind { name: "wall", rule: "thin-wall", limits, reading: Reading::WithinBody }],
            rods: judged(part, process, Side::Material),
            necks: necks(part, process),
            beside: Beside::Limit,
            told: Told::AsThin,
        };
        let (mut measured, facets) = sheets.measure();
        add_bodies(&sheets, limits, &mut measured);
        measured.map = Some(MapWanted {
            kind: MapKind::Wall,
            title: "Wall thickness",
            unit: "mm",
            limits,
            open_end: sheets.notice(),
            facets,
            field: None,
        });
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// The bodies that are thinner than a wall as a whole and have no place that was judged as a wall or a pin.
fn add_bodies(sheets: &Sheets, limits: Limits, measured: &mut Measured) {
    let (part, several) = (sheets.part, sheets.part.health().bodies.len() > 1);
    let widest = limits.fail.into_iter().chain(limits.warn).fold(0.0, f64::max);
    let of_rod = |b: &ThinBody| {
        let body = |facet: u32| part.health().facet_body.get(facet as usize).copied();
        sheets.rods.iter().any(|r| body(r.narrowest.facet) == Some(b.body))
    };
    let known = |b: &ThinBody| {
        let own = |f: &Finding| f.bodies.as_ref().map_or(!several, |of| of.contains(&(u64::from(b.body) + 1)));
        measured.findings.iter().any(|f| f.state >= State::Warn && f.kind == "wall" && own(f))
    };
    let thin: Vec<ThinBody> = thin_bodies(part, |_| widest).into_iter().filter(|b| !of_rod(b) && !known(b)).collect();
    let thin: Vec<(Bracket, ThinBody)> = thin.into_par_iter().map(|b| (thickness(part, &b), b)).collect();
    let least = thin.iter().min_by(|a, b| a.1.width.total_cmp(&b.1.width));
    if let Some((wide, b)) = least.filter(|b| measured.worst.as_ref().is_none_or(|w| b.1.width < w.bracket.value)) {
        measured.worst = Some(Worst { bracket: *wide, unit: "mm", at: Some(b.middle) });
    }
    let mut findings: Vec<Finding> = thin.iter().map(|(wide, b)| body_finding(sheets, limits, (b, *wide))).collect();
    findings.sort_by(|a, b| a.value.total_cmp(&b.value).then_with(|| Finding::worst_first(a, b)));
    let mut grouped = group_equal(findings, 0.004);
    for f in grouped.iter_mut().filter(|f| f.count > 1) {
        f.message = format!("{} bodies, the first {}", f.count, f.message);
    }
    measured.findings.extend(grouped);
}

/// The thickness of a body: planes that far apart hold it, and the ball found in it is no wider than any do.
fn thickness(part: &Part, b: &ThinBody) -> Bracket {
    Bracket::new(b.width, room_in(part, b), b.width)
}

fn body_finding(sheets: &Sheets, limits: Limits, (b, bracket): (&ThinBody, Bracket)) -> Finding {
    let part = sheets.part;
    let mut f = Finding::judged(META.code, "body", bracket, Basis::Certified, limits, "mm", part.tie());
    f.volume_mm3 = (b.volume > 0.0).then(|| report_digits(b.volume));
    locate(&mut f, part, sheets.context, b.middle, b.extent);
    f.witness = Some(Witness { kind: "planes".into(), points_mm: b.sides().map(|p| reported(part, p)).to_vec() });
    f.bodies = (part.health().bodies.len() > 1).then(|| vec![u64::from(b.body) + 1]);
    let [x, y, z] = [0, 1, 2].map(|a| plain(b.extent.1[a] - b.extent.0[a]));
    let room = if f.low > 0.0 { format!(", with room for a ball of {} mm", plain(f.low)) } else { String::new() };
    f.message = format!("body of {x} × {y} × {z} mm, no more than {} mm thick anywhere{room}", plain(b.width));
    let limit = limits.fail.filter(|l| b.width < *l).or(limits.warn).unwrap_or(b.width);
    let growth = Growth::new(part, sheets.process, Side::Material);
    let fits = growth.fits_between(b.sides(), limit - b.width);
    let hint = format!("thicken by {} mm to {} mm", enough(limit - b.width), short(limit));
    f.fix = growth.tried(hint, "thicken", limit, Fit::counts([fits])) + "; or leave it out";
    f
}
