//! AM105: edges so sharp that the material before them is thinner than a wall.

use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::cut::Cut;
use super::finding::{Basis, Bracket, Finding, Limits, State, Witness};
use super::place::{group_equal, locate, reported};
use super::rods::plain;
use super::sheet_shape::RUN_OUT;
use crate::error::Result;
use crate::geometry::vector::bounds;
use crate::medial::crease::{Crease, Ridge, Sharpness, creases, length, ridges};
use crate::medial::strip::strip_area;
use crate::part::Part;
use crate::process::Process;
use crate::units::{report_digits, short};
use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// AM105 `knife-edge`.
pub struct KnifeEdge;

/// Wedges up to this angle are measured: those whose balls have contacts 120 degrees apart or more.
const WIDEST: f64 = 60.0;
/// A wedge that never gets as thick as this share of the wall limit is a nick in the surface, no edge of the part.
const NICK: f64 = 0.25;
/// An angle that a step of the coordinates can change by more than this, degrees, is that of a sliver and says nothing.
const DOUBTFUL: f64 = 5.0;

static META: Meta = Meta {
    code: "AM105",
    name: "knife-edge",
    title: "Angle of sharp edges",
    what: "Measures the angle of the material at every sharp edge, and how far in from the edge it is thinner than the wall limit.",
    why: "Before a sharp edge the material is thinner than a wall: it is not printed, or it breaks off and leaves a ragged edge further in.",
    how: "The angle between the two facets of each edge is exact. One that differs from a limit by less than a step of the coordinates can turn its \
          facets is equal to the limit, and passes. The depth is where the ball that touches both sides of the mesh, straight \
          or curved, first is as thick as the wall limit, or where it no longer grows; the area is that of the strip up to there, in which \
          what two edges share at their corner counts once. A face or a rounding \
          between the sides, up to a twentieth of the wall limit that warns, makes it no less of an edge, which is told once, where it is sharpest; facets of one plane are one face. Edges that follow each other are one finding. A cut that is advised has been made at up to 24 places \
          along them: it stays within the material, and a wall as thick as the limit is left at the blunt face and behind it. Walls and wedges share the rule that a ball with contacts \
          120 degrees apart or more is thin: from 150 degrees, if it does not run out to an edge, it is a wall and AM101 judges it; a wedge of \
          up to 60 degrees that runs out to an edge of the mesh is measured here.",
    limits: "A convex right angle, a chamfer and a thread of 60 degrees are no knife edges. What is shorter than the wall limit or never as thick as a \
             quarter of it is counted and not judged. A wedge blunted by a face or a rounding wider than a twentieth of the wall limit that warns is a wall where its sides lean by less \
             than 30 degrees, as thick as the largest ball under that face, up to 1.3 times as wide as the face is; from 30 to 60 degrees it is duller than the 30 degrees that every built-in process asks of a sharp edge, and it is only \
             counted, in the cover line of thin-wall: a profile with a wider limit here does not reach it.",
    source: "Limits: see the profile.",
};

/// Where an edge is, and what cutting it back to a wall, and to a thicker one, has shown.
type Tried = ([f64; 3], [Cut; 2]);

impl Check for KnifeEdge {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let Some(limits) = limits_of(process, META.name) else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let wall = limits_of(process, "thin-wall").and_then(|l| l.fail.or(l.warn));
        let Some(wall) = wall.filter(|w| *w > 0.0) else {
            return Ok(Outcome::NotApplicable("the process sets no wall limit to measure the edge by".into()));
        };
        // What thin-wall takes for a wedge is one here, be it blunt.
        let thin = limits_of(process, "thin-wall").and_then(|l| l.warn).unwrap_or(wall).max(wall);
        let sought = Sharpness { widest: WIDEST.to_radians(), thick: wall, blunt: RUN_OUT * thin, step: part.step() };
        let found = creases(part.mesh(), part.distance(), part.adjacency(), sought);
        let widest = limits.fail.into_iter().chain(limits.warn).fold(0.0, f64::max).to_radians();
        let is_deep = |c: &Crease| c.thickness >= NICK * wall && c.doubt < DOUBTFUL.to_radians();
        let deep: Vec<&Crease> = found.iter().filter(|c| is_deep(c)).collect();
        let chosen = |c: &Crease| c.angle < widest && is_deep(c);
        let lines = ridges(&found, chosen);
        let long = |r: &&Ridge| r.creases.iter().map(|&i| length(part.mesh(), &found[i])).sum::<f64>() >= wall;
        // What is too short to be judged is the worst of nothing.
        let too_short: FxHashSet<usize> =
            lines.iter().filter(|r| !long(r)).flat_map(|r| r.creases.iter().copied()).collect();
        let counting = found.iter().enumerate().filter(|(i, c)| is_deep(c) && !too_short.contains(i)).map(|(_, c)| c);
        let worst = counting.min_by(|a, b| a.angle.total_cmp(&b.angle)).map(|c| Worst {
            bracket: Bracket::exact(c.angle.to_degrees()),
            unit: "deg",
            at: Some(middle(part, c)),
        });
        let (mut findings, cuts): (Vec<Finding>, Vec<Tried>) = lines
            .par_iter()
            .filter(long)
            .filter_map(|r| sharp(part, context, &found, r, (limits, [wall, thin])))
            .filter(|(f, _)| f.state > State::Pass)
            .map(|(f, cuts)| (f.clone(), (f.at_mm, cuts)))
            .unzip();
        let judged = lines.iter().filter(long).count();
        findings.sort_by(Finding::worst_first);
        let mut findings = group_equal(findings, 0.05);
        for f in &mut findings {
            let own = || cuts.iter().filter(|(at, _)| f.places.iter().any(|p| p.at_mm == *at));
            let [cut, deeper] = [0, 1].map(|n| own().fold(Cut::default(), |all, (_, cuts)| all.joined(cuts[n])));
            f.fix = cut.words(wall);
            if thin > wall {
                f.fix += &deeper.words_beside(&cut, thin);
            }
            if f.count > 1 {
                f.message = format!("{} such edges, the first an {}", f.count, f.message);
            }
        }
        let cover = format!(
            "All edges were measured: {} of at most {WIDEST} degrees, {} of them on slivers or nicks never {} mm thick; {} lines of edges below the limit are \
             shorter than {} mm.",
            found.len(),
            found.len() - deep.len(),
            plain(NICK * wall),
            lines.len() - judged,
            plain(wall)
        );
        Ok(Outcome::Measured(Box::new(Measured {
            worst,
            findings,
            cover,
            rule: Some(META.name),
            ..Measured::default()
        })))
    }
}

fn middle(part: &Part, c: &Crease) -> [f64; 3] {
    let [a, b] = c.ends.map(|v| part.mesh().vertices[v as usize]);
    [0, 1, 2].map(|x| 0.5 * (a[x] + b[x]))
}

/// The finding of a line of sharp edges, at its sharpest, and what cutting it back to a wall, and to a thicker one, has shown.
fn sharp(
    part: &Part,
    context: &Context,
    found: &[Crease],
    ridge: &Ridge,
    (limits, [wall, thin]): (Limits, [f64; 2]),
) -> Option<(Finding, [Cut; 2])> {
    let line: Vec<&Crease> = ridge.creases.iter().map(|&i| &found[i]).collect();
    // What is certainly the sharpest: its own doubt is what it may be equal to a limit by.
    let sharpest = line.iter().min_by(|a, b| (a.angle + a.doubt).total_cmp(&(b.angle + b.doubt)))?;
    let long: f64 = line.iter().map(|c| length(part.mesh(), c)).sum();
    let area = strip_area(part.mesh(), &line);
    let depth = line.iter().map(|c| c.depth).fold(0.0, f64::max);
    let (degrees, doubt) = (sharpest.angle.to_degrees(), sharpest.doubt.to_degrees());
    let value = Bracket::new(degrees, (degrees - doubt).max(0.0), degrees + doubt).rounded();
    let exact = Bracket::exact(degrees);
    let judged = Finding::judged(META.code, "edge", exact, Basis::Exact, limits, "deg", doubt.max(1e-6));
    let mut f = Finding { low: value.low, high: value.high, ..judged };
    let corners = line.iter().flat_map(|c| c.ends.map(|v| part.mesh().vertices[v as usize]));
    let extent = bounds(corners)?;
    locate(&mut f, part, context, middle(part, sharpest), extent);
    let points = sharpest.ends.map(|v| reported(part, part.mesh().vertices[v as usize]));
    f.witness = Some(Witness { kind: "edge".into(), points_mm: points.to_vec() });
    f.area_mm2 = Some(report_digits(area));
    f.message = format!(
        "edge of {}°{}, {} mm long: up to {} mm in from it the material is thinner than {} mm",
        short((f.value * 10.0).round() / 10.0),
        if sharpest.blunt > 0.0 { format!(", blunted to {} mm", plain(sharpest.blunt)) } else { String::new() },
        plain(long),
        plain(depth),
        plain(wall)
    );
    Some((f, [wall, thin].map(|w| Cut::of_line(part, &line, depth * w / wall, w))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{cuboid, extruded};
    use crate::part::Up;
    use crate::process::Process;

    #[test]
    fn an_edge_too_short_to_be_judged_is_not_the_worst_of_what_passes() {
        // A wedge of 20 degrees beside a block, so deep along its edge.
        let process = Process::named("fdm").unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        for (deep, state) in [(0.3, None), (3.0, Some(State::Warn))] {
            let wedge = extruded(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0 * 20f64.to_radians().tan()]], &[[0, 1, 2]], deep);
            let part = Part::new(wedge.joined(&cuboid([9.0, 0.0, 0.0], [19.0; 3])), Up::PlusZ, 1e-6, 1.0).unwrap();
            let Outcome::Measured(found) = KnifeEdge.run(&part, &process, &context).unwrap() else { panic!() };
            assert_eq!(found.findings.first().map(|f| f.state), state, "{deep}: {:?}", found.findings);
            assert_eq!(found.worst.map(|w| w.bracket.value < 20.1), state.map(|_| true), "{deep}");
        }
    }
}
