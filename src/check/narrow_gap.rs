//! AM103: slots and clearances narrower than the process keeps open.

use super::contract::{Check, Context, MapKind, MapWanted, Meta, Outcome, limits_of};
use super::finding::Limits;
use super::for_good::Told;
use super::rods::round_void;
use super::room::Beside;
use super::sheet::{Kind, Reading, Sheets};
use crate::error::Result;
use crate::medial::Side;
use crate::part::Part;
use crate::process::Process;

/// AM103 `narrow-gap`.
pub struct NarrowGap;

static META: Meta = Meta {
    code: "AM103",
    name: "narrow-gap",
    title: "Width of slots and clearance between bodies",
    what: "Measures the void between two opposing surfaces: slots and closed slits within a body, and the clearance between \
           separate bodies, each by its own limit.",
    why: "A gap narrower than the process resolves fuses: moving parts do not move, slots close, powder stays.",
    how: "Within a body as AM101, on the void. Between two bodies the exact least distance of their surfaces is taken, by a \
          search over both box trees. Equal gaps are one finding with a count.",
    limits: "Bodies that touch or cross are one piece and are noted, not judged. A groove that tapers by more than 30 degrees, or by 4 and more to its bottom edge, is no \
             slot there, and round void is none however deep: holes and dimples are small-hole's. The gap to the plate is not judged.",
    source: "Limits: see the profile.",
};

impl Check for NarrowGap {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let rules = [
            ("slot", "narrow-gap", Reading::WithinBody),
            ("gap-between-bodies", "narrow-gap.between-bodies", Reading::BetweenBodies),
        ];
        let kinds: Vec<Kind> = rules
            .into_iter()
            .filter_map(|(name, rule, reading)| Some(Kind { name, rule, limits: limits_of(process, rule)?, reading }))
            .collect();
        let Some(widest) = kinds.iter().map(|k| k.limits).reduce(wider) else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let rods = round_void(part, process);
        let (code, side, beside) = (META.code, Side::Void, Beside::Limit);
        let (necks, told) = (Vec::new(), Told::AsThin);
        let sheets = Sheets { part, process, context, code, side, kinds, rods, necks, beside, told };
        let (mut measured, facets) = sheets.measure();
        measured.map = Some(MapWanted {
            kind: MapKind::Gap,
            title: "Gap width",
            unit: "mm",
            limits: widest,
            open_end: sheets.notice(),
            facets,
            field: None,
        });
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// The larger of two pairs of limits, for the scale of the map.
fn wider(a: Limits, b: Limits) -> Limits {
    let larger = |x: Option<f64>, y: Option<f64>| match (x, y) {
        (Some(x), Some(y)) => Some(x.max(y)),
        (x, y) => x.or(y),
    };
    Limits { fail: larger(a.fail, b.fail), warn: larger(a.warn, b.warn), sense: a.sense }
}
