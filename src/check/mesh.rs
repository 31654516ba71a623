//! AM001: the mesh as the boundary of a solid.

use super::contract::{Check, Context, Measured, Meta, Outcome, Worst};
use super::finding::{Basis, Bracket, Finding, Limits, Sense};
use super::place::{locate, reported};
use crate::error::Result;
use crate::geometry::health::Fault;
use crate::part::Part;
use crate::process::Process;

/// AM001 `mesh`.
pub struct Mesh;

static META: Meta = Meta {
    code: "AM001",
    name: "mesh",
    title: "Mesh: open, non-manifold, miswound, duplicate, crossing facets",
    what: "Counts open edges, edges of more than two facets, edges whose facets disagree in winding, doubled facets and \
           facets of one body that pass through each other, and gives the worst place of each. Bodies, closed inner voids, ghosts and facets without area are noted beside them.",
    why: "A slicer has to guess what is inside where the surface has holes or contradicts itself; different slicers guess \
          differently, and parts of the model can vanish.",
    how: "Corners are welded where their coordinates are equal (0.0 = -0.0); every edge is then counted with its direction. \
          Which shell lies in which is decided by rays in several directions and, where these disagree, by solid angles. \
          Facets whose boxes overlap are tried on each other. Where the facets do not agree, inside is where the \
          generalized winding number is at least one half; where they cross, the part is the union.",
    limits: "Crossings shallower than twice the resolution of the file, and facets that overlap in one plane, count as touching. \
             A facet that crosses others is taken to bound the part where its middle does. Faults warn; what they do to the \
             other checks is that inside comes from the winding number.",
    source: "Winding number: A. Jacobson, L. Kavan, O. Sorkine-Hornung, Robust inside-outside segmentation using generalized \
             winding numbers, 2013.",
};

impl Check for Mesh {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, _: &Process, context: &Context) -> Result<Outcome> {
        let h = part.health();
        let faults = [
            ("open-edges", h.open_edges, "open edges", "close the holes with a mesh repair, or export the solid again"),
            (
                "non-manifold",
                h.non_manifold_edges,
                "edges with more than two facets",
                "unite the bodies that share them, or move them apart by 0.01 mm",
            ),
            (
                "miswound",
                h.miswound_edges,
                "edges whose facets are wound against each other",
                "make the normals consistent and export again",
            ),
            ("duplicate-facets", h.duplicate_facets, "facets that repeat another", "delete the doubled surface"),
            (
                "self-crossing",
                part.crossings(),
                "pairs of facets that pass through each other",
                "unite the body with itself, so that no surface lies inside the material",
            ),
        ];
        let limits = Limits { fail: None, warn: Some(0.0), sense: Sense::Max };
        let mut measured = Measured { cover: cover(part), ..Measured::default() };
        for (kind, Fault { count, at_mm }, text, fix) in faults {
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
            f.message = format!("{count} {text}, worst at {}", at_text(reported(part, at)));
            f.fix = fix.into();
            measured.findings.push(f);
        }
        let all: u64 = faults.iter().map(|f| f.1.count).sum();
        measured.worst = Some(Worst { bracket: Bracket::exact(all as f64), unit: "1", at: None });
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

fn cover(part: &Part) -> String {
    let h = part.health();
    format!(
        "{} facets in {} shells, {} bodies; every edge was counted, and every facet was tried on those \
         it may cross.",
        part.mesh().triangles.len(),
        h.shells.len(),
        h.bodies.len()
    )
}

fn at_text([x, y, z]: [f64; 3]) -> String {
    format!("{x:.2}, {y:.2}, {z:.2} mm")
}
