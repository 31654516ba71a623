//! AM001: the mesh as the boundary of a solid.

use super::contract::{Check, Context, Measured, Meta, Outcome, ShapeShown, Worst};
use super::finding::{Basis, Bracket, Finding, Limits, Sense, State};
use super::place::{locate, reported};
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::Health;
use crate::geometry::contour;
use crate::geometry::health::{self, Fault};
use crate::grid::Grid;
use crate::notice::number_of;
use crate::part::Part;
use crate::process::Process;
use crate::units::{Length, bulk, report_digits, short};

/// A kind of fault: name, what was read, words for one and for several, remedy, and where it stands in another mesh's health.
type Kind = (&'static str, Fault, [&'static str; 2], &'static str, fn(&Health) -> Fault);

/// AM001 `mesh`.
pub struct Mesh;

/// Samples along the longest side of the region of doubt, as it is shown.
const SHOWN: f64 = 64.0;

static META: Meta = Meta {
    code: "AM001",
    name: "mesh",
    title: "Mesh: open, non-manifold, miswound, duplicate, crossing facets",
    what: "Counts open edges, edges of more than two facets, edges whose facets disagree in winding, doubled facets and \
           facets of one body that pass through each other or lie on each other, and gives the worst place of each. Bodies, closed inner voids, ghosts and facets without area are noted beside them.",
    why: "A slicer has to guess what is inside where the surface has holes or contradicts itself; different slicers guess \
          differently, and parts of the model can vanish.",
    how: "Corners are welded where their coordinates are equal (0.0 = -0.0); every edge is then counted with its direction. \
          Which shell lies in which is decided by rays in several directions and, where these disagree, by solid angles. \
          Facets whose boxes overlap are tried on each other. Where the facets do not agree, inside is where the \
          generalized winding number is at least one half; where they cross, the part is the union.",
    limits: "Crossings and overlaps shallower than twice the resolution of the file count as touching. \
             A facet that crosses others is taken to bound the part where its middle does. Faults warn; what they do to the \
             other checks is that inside comes from the winding number. Where that lies within ¼ of one half in samples whose \
             cubes no facet touches, the part stays undecided; a hole that a cube covers leaves no such place.",
    source: "Winding number: A. Jacobson, L. Kavan, O. Sorkine-Hornung, Robust inside-outside segmentation using generalized \
             winding numbers, 2013.",
};

impl Check for Mesh {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, _: &Process, context: &Context) -> Result<Outcome> {
        let h = part.health_as_read();
        let faults: [Kind; 6] = [
            (
                "open-edges",
                h.open_edges,
                ["open edge", "open edges"],
                "close the holes with a mesh repair, or export the solid again",
                |h| h.open_edges,
            ),
            (
                "non-manifold",
                h.non_manifold_edges,
                ["edge with more than two facets", "edges with more than two facets"],
                "unite the bodies that share them, or move them apart by 0.01 mm",
                |h| h.non_manifold_edges,
            ),
            (
                "miswound",
                h.miswound_edges,
                ["edge whose facets are wound against each other", "edges whose facets are wound against each other"],
                "make the normals consistent and export again",
                |h| h.miswound_edges,
            ),
            (
                "duplicate-facets",
                h.duplicate_facets,
                ["facet that repeats another", "facets that repeat another"],
                "delete the doubled surface",
                |h| h.duplicate_facets,
            ),
            // Mending cuts nothing: as many would be left.
            (
                "overlapping-facets",
                part.meetings().overlapping,
                [
                    "pair of facets that lie on each other in one plane",
                    "pairs of facets that lie on each other in one plane",
                ],
                "unite the body with itself, so that the surface is there once",
                |_| Fault { count: u64::MAX, at_mm: None },
            ),
            (
                "self-crossing",
                part.meetings().crossing,
                ["pair of facets that pass through each other", "pairs of facets that pass through each other"],
                "unite the body with itself, so that no surface lies inside the material",
                |_| Fault { count: u64::MAX, at_mm: None },
            ),
        ];
        let limits = Limits { fail: None, warn: Some(0.0), sense: Sense::Max };
        let mut measured = Measured { cover: cover(part), ..Measured::default() };
        let all: u64 = faults.iter().map(|f| f.1.count).sum();
        // What mending would leave is tried on what it would be given, so that the hint is no guess.
        let mended = (all > 0).then(|| {
            let mesh = part.mesh_as_read();
            Health::of(&health::repaired(mesh, health::repair_tolerance(mesh)).mesh)
        });
        for (kind, Fault { count, at_mm }, text, fix, left) in faults {
            if count == 0 {
                continue;
            }
            let mut f = Finding::judged(META.code, kind, Bracket::exact(count as f64), Basis::Exact, limits, "1", 0.0);
            let at = at_mm.unwrap_or_else(|| part.extent().map(|x| 0.5 * x));
            locate(
                &mut f,
                part,
                context,
                at,
                h.largest_hole.filter(|_| kind == "open-edges").map_or((at, at), |r| (r.box_mm[0], r.box_mm[1])),
            );
            f.area_mm2 = match kind {
                "duplicate-facets" => Some(report_digits(h.duplicate_mm2)),
                "overlapping-facets" => Some(report_digits(part.meetings().overlap_mm2)),
                _ => None,
            };
            let area = f.area_mm2.map_or(String::new(), |a| format!(", {} mm² in all", short(a)));
            f.message = format!("{}{area}, worst at {}", number_of(count, text), at_text(reported(part, at)));
            f.fix = match mended.as_ref().map(|h| left(h).count) {
                Some(rest) if rest < count => format!("--repair leaves {rest} of them; or {fix}"),
                _ => fix.into(),
            };
            measured.findings.push(f);
        }
        measured.findings.extend(uncertain(part, context, mended.as_ref())?);
        measured.shapes.extend(region(part));
        measured.worst = Some(Worst { bracket: Bracket::exact(all as f64), unit: "1", at: None });
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// Says that the part stays undecided where the winding number does not tell inside from outside beyond the cubes that facets touch:
/// there what was judged may not be the part that was meant.
fn uncertain(part: &Part, context: &Context, mended: Option<&Health>) -> Result<Option<Finding>> {
    let Some(doubt) = part.solid()?.doubt.filter(|d| d.share > 0.0) else { return Ok(None) };
    let limits = Limits { fail: Some(0.0), warn: None, sense: Sense::Max };
    // The region was sampled: it fills no more than its box, and may be nothing.
    let h = part.solid()?.centres.grid().h();
    let within: f64 = (0..3).map(|a| doubt.extent.1[a] - doubt.extent.0[a] + h).product();
    let bracket = Bracket::new(doubt.volume_mm3, 0.0, within.max(doubt.volume_mm3));
    let mut f = Finding::judged(META.code, "uncertain-inside", bracket, Basis::Estimated, limits, "mm3", 0.0);
    f.state = State::Undecided;
    f.decided = false;
    f.volume_mm3 = Some(report_digits(doubt.volume_mm3));
    let at = doubt.at_mm;
    locate(&mut f, part, context, at, doubt.extent);
    f.message = format!(
        "inside cannot be told from outside in about {}, {} % of what may be the part, least at {}",
        bulk(doubt.volume_mm3),
        short(doubt.percent()),
        at_text(reported(part, at))
    );
    f.fix = match mended.filter(|h| h.is_solid()) {
        Some(_) => "--repair makes it a solid; look at what it did",
        None => "make the normals consistent and close the holes with a mesh repair, or export the solid again",
    }
    .into();
    Ok(Some(f))
}

/// Where inside cannot be told from outside: the places with a winding number within ¼ of one half, on a grid of their own.
fn region(part: &Part) -> Option<ShapeShown> {
    let solid = part.solid().ok()?;
    let (lo, hi) = solid.doubt.filter(|d| d.share > 0.0)?.extent;
    let half = 0.5 * solid.centres.grid().h();
    let (lo, hi) = (lo.map(|x| x - half), hi.map(|x| x + half));
    let h = (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max) / SHOWN;
    let grid = Grid::covering(lo, hi, Length::mm(h), 1, [0.0; 3]).ok()?;
    // On a facet itself the number is the mean of both sides.
    let is_doubtful = |p| (part.winding().at(p) - 0.5).abs() < 0.25 && part.distance().nearest(p, 1e-3 * h).is_none();
    let doubtful = Indicator::from_predicate(grid, |at| is_doubtful(grid.position(grid.index(at))));
    let title = format!("Inside in doubt, about {}", bulk(doubtful.volume().as_mm3()));
    let mesh = contour::surface(&doubtful, |_| 0.5).ok()?;
    (!doubtful.is_empty()).then_some(ShapeShown { name: "uncertain", title, mesh })
}

fn cover(part: &Part) -> String {
    let h = part.health_as_read();
    format!(
        "{} facets in {} shells, {} bodies; every edge was counted, and every facet was tried on those \
         it may cross.",
        h.facet_body.len(),
        h.shells.len(),
        h.bodies.len()
    )
}

fn at_text([x, y, z]: [f64; 3]) -> String {
    format!("{x:.2}, {y:.2}, {z:.2} mm")
}
