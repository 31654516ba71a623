//! AM101: walls thinner than the process makes.

use super::contract::{Check, Context, MapKind, MapWanted, Meta, Outcome, limits_of};
use super::rods::judged;
use super::sheet::{Kind, Reading, Sheets};
use crate::error::Result;
use crate::medial::Side;
use crate::part::Part;
use crate::process::Process;

/// AM101 `thin-wall`.
pub struct ThinWall;

static META: Meta = Meta {
    code: "AM101",
    name: "thin-wall",
    title: "Thickness of walls",
    what: "Measures the thickness of material between two opposing surfaces: the diameter of the largest ball inside that touches \
           both, where its contacts are at least 150 degrees apart.",
    why: "A wall thinner than a bead, a spot or a few pixels is dropped, broken or warped; which of these depends on the slicer, \
          but none of them is the designed wall.",
    how: "All pairs of opposing features of the mesh are searched by branch and bound: where no chord between opposing features is \
          shorter than the limit there is no wall that thin, and this is a proof. Where there is one, an empty ball between the \
          two is the witness; it is measured on the mesh, not on voxels. Equal places are one finding with a count.",
    limits: "A convex edge is no wall. What is thin over less than its own thickness squared is a neck at one spot: it has no area that could break or be dropped, so it warns and never fails. A sheet that tapers by more than 30 degrees, or runs out to an edge, is a wedge, which knife-edge judges, \
             and a pin with a free end is judged by thin-pin. What is thin over less than a sixteenth of the search resolution is not looked for; the cover line gives the \
             number. Bodies that cross each other without sharing edges are taken as they are.",
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
        };
        let (mut measured, facets) = sheets.measure();
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
