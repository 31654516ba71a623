//! AM401: the part as the process lays it down.

use super::budget::Budget;
use super::contract::{Check, Context, Measured, Meta, Outcome, ShapeShown, Worst, limits_of};
use super::departing::{Seeker, rounded};
use super::finding::{Bracket, Finding};
use super::lost_feature::one_by_state;
use crate::error::Result;
use crate::medial::Side;
use crate::morphology::AsPrinted as Made;
use crate::part::{Part, bead_of};
use crate::process::Process;
use crate::units::{bulk_within, short};

/// AM401 `as-printed`.
pub struct AsPrinted;

/// Share of the element that must lie in the part for it to be deposited.
pub const LAMBDA: f64 = 0.5;
/// Samples of the shape that is shown, at most.
const SHOWN: usize = 1 << 18;

static META: Meta = Meta {
    code: "AM401",
    name: "as-printed",
    title: "The part as the process lays it down",
    what: "Lays the element of the process (bead, spot or pixel, one layer high) along the outline as a slicer does, and compares: \
           material that is not printed because not even half of the element lies in it, and voids that close.",
    why: "What is finer than the element is not made as drawn: thin walls drop out, slots and holes close, and nothing of it \
          shows until the part is in hand.",
    how: "What half of the element lies in is printed as drawn, for a slicer moves the outline inwards by half a bead, or lays a narrower \
          one: of a round element, upright sheets from two fifths of its width on, of a square one from half. Beyond the outline material spreads, wherever so much of the element lies in the part that an upright face moves by half \
          the gap that closes in the process (`closing_gap_mm` of its element); where that is more than half the element, it spreads \
          beyond it by the rest, as far in every direction. Every pair of opposing features is searched as for \
          thin-wall and narrow-gap: sheets that hold too little of the element along their normal, slots that two moved faces cover, \
          between bodies too. What they hold is counted on lattices that divide the element, exactly at every position, once for the \
          cells wholly inside and once for the cells touched, and added up by the share of each cell that the mesh fills; where a limit lies between, on finer cells, as far as the budget goes. \
          A lattice of the whole part, where there is room for one, shows what else is lost or filled, and the printed shape, which \
          is shown with the part. A remedy is laid on a lattice and printed again before it is advised.",
    limits: "Void within half an element of what stays open does not count as filled, nor, where faces spread beyond that, void within 1.73 \
             times the spread: the rim of a slot, the coat on a face and in a corner. Slots of a \
             void that is sealed are not sought. On the \
             lattice of the whole part the spread is rounded down to whole cells; the cover line gives the width of the slots that close \
             there. Finer looks take cells that hold the spread whole. A slot narrower than what closes by less than two of the finest \
             cells (a twenty-fourth of the element) stays undecided. The element is a prism of whole cells. Layers are free along z, \
             not tied to the layer grid. Faces that lie move less than upright ones, slanting ones up to a quarter more, which no slot \
             is held to close by.",
    source: "A. Nelaturi, V. Shapiro, Representation and analysis of additively manufactured parts, 2015. Limits: see the profile.",
};

impl Check for AsPrinted {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let [lost, filled] = ["as-printed", "as-printed.filled"].map(|key| limits_of(process, key));
        if lost.is_none() && filled.is_none() {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        }
        let mut measured = Measured::default();
        let made = part.as_printed(process, LAMBDA)?;
        // Where the surface is not closed, inside is as doubtful on finer cells, and casts take many times as long.
        let mut budget = Budget::of(if part.health().is_solid() { context.refine } else { 0 });
        let mut words = Vec::new();
        for (rule, side, limits) in [("as-printed", Side::Material, lost), ("as-printed.filled", Side::Void, filled)] {
            let Some(limits) = limits else { continue };
            let seeker = Seeker::new(part, process, context, (side, limits));
            let (places, searched) = seeker.places(made.as_deref())?;
            words.push(searched);
            let brackets = seeker.measured(&places, &mut budget)?;
            let of_rank = places.iter().zip(brackets).enumerate();
            let findings = of_rank.map(|(rank, (place, bracket))| seeker.finding(place, bracket, rank));
            let findings: Vec<Finding> = findings.collect::<Result<_>>()?;
            let worst = worst(part, &findings);
            if measured.worst.as_ref().is_none_or(|known| known.bracket.value < worst.bracket.value) {
                (measured.worst, measured.rule) = (Some(worst), Some(rule));
            }
            measured.findings.extend(one_by_state(findings));
        }
        measured.budget = (budget.looks > 0).then_some(budget);
        match made {
            Some(made) => {
                words.insert(0, cover(part, &made)?);
                // Cells round where faces come to lie, by up to one of them.
                let [x, _, z] = made.designed.cells.cell_mm().map(rounded);
                let volume = bulk_within(made.volume().as_mm3(), made.bounds().map(|v| v.as_mm3()));
                measured.shapes.push(ShapeShown {
                    name: "as-printed",
                    title: format!("As printed on cells of {x} × {z} mm, {volume}"),
                    mesh: made.surface(SHOWN)?,
                });
            }
            None => words.push(format!(
                "An element of {} × {} mm is too fine for a lattice of the whole part.",
                short(bead_of(process).width.as_mm()),
                short(bead_of(process).height.as_mm())
            )),
        }
        measured.cover = words.join(" ");
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

fn worst(part: &Part, findings: &[Finding]) -> Worst {
    let worst = findings.iter().max_by(|a, b| a.value.total_cmp(&b.value));
    worst.map_or(Worst { bracket: Bracket::exact(0.0), unit: "mm3", at: None }, |f| Worst {
        bracket: Bracket { value: f.value, low: f.low, high: f.high },
        unit: "mm3",
        at: Some(part.to_build(f.at_mm)),
    })
}

fn cover(part: &Part, made: &Made) -> Result<String> {
    let [under, over] = [made.under()?, made.over()?].map(|v| v.map(|v| v.as_mm3()));
    // Cells are as coarse as the element; no more is missing than there is.
    let all = if part.is_plain() { part.mesh().signed_volume() } else { f64::INFINITY };
    let under = under.map(|missing| missing.min(all));
    let cells = &made.designed.cells;
    let [x, _, z] = cells.cell_mm();
    let grid = cells.grid.dims();
    let closes = 2.0 * made.spread.map_or(0.0, |s| x * cells.whole(s) as f64);
    Ok(format!(
        "{} × {} × {} cells of {} × {} mm, {} to the element; slots up to {} mm close: {} mm³ is not printed (between {} and {}), {} mm³ \
         is printed outside (between {} and {}).",
        grid[0],
        grid[1],
        grid[2],
        rounded(x),
        rounded(z),
        made.designed.element_cells(),
        rounded(closes),
        rounded(under[0]),
        rounded(under[1]),
        rounded(under[2]),
        rounded(over[0]),
        rounded(over[1]),
        rounded(over[2])
    ))
}
