//! AM401: the part as the process lays it down.

use super::contract::{Check, Context, Measured, Meta, Outcome, ShapeShown, Worst, limits_of};
use super::detail::{Detail, Sought};
use super::finding::{Basis, Bracket, Finding, Limits};
use super::lost_feature::one_by_state;
use super::place::locate;
use super::trial::Trial;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::Vec3;
use crate::medial::Side;
use crate::morphology::{AsPrinted as Made, Bead};
use crate::part::{Part, bead_of, spread_of};
use crate::process::Process;
use crate::topology::{Adjacency, components};
use crate::units::{Length, bulk, report_digits, short};

/// AM401 `as-printed`.
pub struct AsPrinted;

/// Share of the element that must lie in the part for it to be deposited.
pub const LAMBDA: f64 = 0.5;
/// Places judged one by one, largest first.
const PLACES: usize = 24;
/// Places whose remedy is tried out.
const TRIED: usize = 4;
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
    how: "The share of the element in the part is counted, exactly, at every position of a lattice that divides the element: once \
          for the cells wholly inside, once for the cells touched. What half of the element lies in is printed as drawn, for a \
          slicer moves the outline inwards by half a bead, or lays a narrower one. Beyond the outline material spreads, wherever so \
          much of the element lies in the part that a flat face moves by half the gap that closes in the process (`closing_gap_mm` of its element). So \
          the printed shape lies between two sets, and a place is \
          reported where even the larger one leaves it out, or the smaller one fills it. A remedy is laid on the lattice and \
          printed again before it is advised. The printed shape is shown with the part.",
    limits: "The spread is rounded down to whole cells of the lattice; the cover line gives the width of the slots that close. The \
             element is a prism of whole cells. Layers are free along z, not tied to the layer grid. Where the lattice of the whole \
             part would be too large, sheets and slots are judged on the mesh by their widths and volumes are estimates.",
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
        let judge = Judge { part, process, context, bead: bead_of(process), spread: spread_of(process) };
        let mut measured = Measured { rule: lost.map(|_| "as-printed"), ..Measured::default() };
        match part.as_printed(process, LAMBDA)? {
            Some(made) => {
                let shape = &made.designed.shape;
                // A cell that is touched holds some of the part, and what not even the larger set prints is not printed. What
                // only the samples show is reported too, as an estimate: a pass would claim that it is printed.
                let certain = shape.outer.difference(&made.upper)?;
                let gone = certain.union(&shape.centres.difference(&made.centres)?)?;
                let closed = made.filled()?;
                let mut left = String::new();
                for (set, limits, kind) in [(&gone, lost, "lost"), (&closed, filled, "filled")] {
                    if let Some(limits) = limits {
                        let (findings, rest) = judge.places(&made, set, limits, kind)?;
                        measured.findings.extend(findings);
                        left.push_str(&rest);
                    }
                }
                measured.cover = cover(&made)? + &left;
                measured.spent = made.designed.cells.grid.samples() as u64;
                measured.shapes.push(ShapeShown {
                    name: "as-printed",
                    title: format!("As printed, {}", bulk(made.volume().as_mm3())),
                    mesh: made.surface(SHOWN)?,
                });
            }
            None => judge.on_the_mesh([lost, filled], &mut measured)?,
        }
        let worst = measured.findings.iter().filter(|f| f.kind == "lost").max_by(|a, b| a.value.total_cmp(&b.value));
        measured.worst = Some(worst.map_or(Worst { bracket: Bracket::exact(0.0), unit: "mm3", at: None }, |f| Worst {
            bracket: Bracket { value: f.value, low: f.low, high: f.high },
            unit: "mm3",
            at: Some(part.to_build(f.at_mm)),
        }));
        let (lost, filled) = std::mem::take(&mut measured.findings).into_iter().partition(|f| f.kind == "lost");
        measured.findings = [one_by_state(lost), one_by_state(filled)].concat();
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

struct Judge<'a> {
    part: &'a Part,
    process: &'a Process,
    context: &'a Context,
    bead: Bead,
    /// How far a face spreads.
    spread: Length,
}

/// A place on the way to a finding.
struct Place {
    bracket: Bracket,
    basis: Basis,
    at: Vec3,
    extent: (Vec3, Vec3),
    /// Across the place, and the width there.
    direction: Vec3,
    width: f64,
}

impl Judge<'_> {
    /// The components of what is certainly lost or filled, the largest one by one, and a sentence on the others.
    fn places(&self, made: &Made, set: &Indicator, limits: Limits, kind: &str) -> Result<(Vec<Finding>, String)> {
        let parts = components(set, Adjacency::Corner);
        let (sizes, boxes, firsts) = (parts.sizes(), parts.boxes(), parts.first_samples());
        let mut order: Vec<usize> = (0..parts.count()).collect();
        order.sort_by_key(|&i| (std::cmp::Reverse(sizes[i]), i));
        let cells = &made.designed.cells;
        let cell = cells.cell_mm();
        let (mut findings, mut small) = (Vec::new(), order.len().saturating_sub(PLACES));
        for (rank, &i) in order.iter().take(PLACES).enumerate() {
            let corner = |index: [usize; 3], side: f64| {
                let p = cells.position(index);
                [0, 1, 2].map(|a| p[a] + side * 2.5 * cell[a])
            };
            let extent = (corner(boxes[i][0], -1.0), corner(boxes[i][1], 1.0));
            let (least, about, most) = match kind {
                "lost" => (
                    cells.volume_in(&made.designed.shape.inner, &made.upper, extent),
                    cells.volume_in(&made.designed.shape.centres, &made.centres, extent),
                    cells.volume_in(&made.designed.shape.outer, &made.lower, extent),
                ),
                _ => (
                    cells.volume_in(set, &made.designed.shape.outer, extent),
                    cells.cell_volume() * sizes[i] as f64,
                    cells.volume_in(&made.upper, &made.designed.shape.inner, extent),
                ),
            };
            let span = [0, 1, 2].map(|a| extent.1[a] - extent.0[a] - 4.0 * cell[a]);
            let thin = (0..3).min_by(|&a, &b| span[a].total_cmp(&span[b])).unwrap_or(0);
            let value = about.as_mm3().max(least.as_mm3());
            let place = Place {
                bracket: Bracket::new(value, least.as_mm3(), most.as_mm3()),
                basis: if least.as_mm3() > 0.0 { Basis::Certified } else { Basis::Estimated },
                at: cells.position(firsts[i]),
                extent,
                direction: [0, 1, 2].map(|a| if a == thin { 1.0 } else { 0.0 }),
                width: span[thin],
            };
            // What is filled at the bottom of a sharp notch is less than the limit, and no slot.
            if place.bracket.value <= limits.warn.or(limits.fail).unwrap_or(0.0) {
                small += 1;
                continue;
            }
            findings.push(self.finding(&place, limits, kind, rank < TRIED)?);
        }
        let text = match small {
            0 => String::new(),
            n => format!(" {n} smaller places are {kind} too."),
        };
        Ok((findings, text))
    }

    /// Sheets and slots by their widths, where no lattice holds the part: a slab is lost if thinner than λ of the element, a slot
    /// filled if narrower than twice the spread.
    fn on_the_mesh(&self, limits: [Option<Limits>; 2], measured: &mut Measured) -> Result<()> {
        let rows = [(Side::Material, limits[0], "lost"), (Side::Void, limits[1], "filled")];
        for (side, limits, kind) in rows {
            let Some(limits) = limits else { continue };
            let width = if kind == "lost" { LAMBDA * self.bead.widest().as_mm() } else { 2.0 * self.spread.as_mm() };
            let found = Sought { part: self.part, process: self.process, context: self.context, side, width }.search();
            measured.spent += found.evaluations;
            let tie = self.part.tie();
            let thin = found.sheets(|t| t.diameter < self.least_width(kind, t.direction()) - tie);
            for (rank, detail) in thin.iter().take(PLACES).enumerate() {
                measured.findings.push(self.finding(&self.place_of(detail), limits, kind, rank < TRIED)?);
            }
            measured.cover.push_str(&format!(
                "{} {} are {kind} by their width, all sought down to {} mm across. ",
                thin.len(),
                if side == Side::Material { "sheets" } else { "slots" },
                short(found.finest)
            ));
        }
        measured.cover.push_str(&format!(
            "An element of {} × {} mm is too fine for a lattice of the whole part.",
            short(self.bead.width.as_mm()),
            short(self.bead.height.as_mm())
        ));
        Ok(())
    }

    /// The width across a direction below which material is lost, or a void filled.
    fn least_width(&self, kind: &str, direction: Vec3) -> f64 {
        let across = self.bead.width_along(direction).as_mm();
        if kind == "lost" { LAMBDA * across } else { (2.0 * self.spread.as_mm()).min(across) }
    }

    fn place_of(&self, detail: &Detail) -> Place {
        Place {
            bracket: Bracket::new(detail.volume, 0.0, detail.volume),
            basis: Basis::Estimated,
            at: detail.thinnest.centre,
            extent: detail.extent,
            direction: detail.thinnest.direction(),
            width: detail.thinnest.diameter,
        }
    }

    fn finding(&self, place: &Place, limits: Limits, kind: &str, tried: bool) -> Result<Finding> {
        let mut f = Finding::judged(META.code, kind, place.bracket, place.basis, limits, "mm3", 0.0);
        locate(&mut f, self.part, self.context, place.at, place.extent);
        f.volume_mm3 = Some(report_digits(place.bracket.value));
        let what = if kind == "lost" { "of material is not printed" } else { "of void is filled" };
        f.message = format!("{} mm³ {what}", rounded(place.bracket.value));
        let needed = self.least_width(kind, place.direction);
        let verb = if kind == "lost" { "thicken" } else { "widen" };
        let trial = if tried {
            Trial::around(self.part, self.bead, place.extent, |d| d.compensated(LAMBDA, self.spread))?
        } else {
            None
        };
        let missing = (needed - place.width).max(0.0);
        let steps = match &trial {
            Some(t) if kind == "lost" => t.thickened(place.direction, missing)?,
            Some(t) => t.widened(place.direction, missing)?,
            None => None,
        };
        f.fix = match (&trial, steps) {
            (Some(t), Some(steps)) => format!(
                "{verb} by {} mm; checked: none of it is {kind} then",
                rounded(steps as f64 * t.step_along(place.direction))
            ),
            _ => format!("less than {} mm across is {kind} here", rounded(needed)),
        };
        Ok(f)
    }
}

fn cover(made: &Made) -> Result<String> {
    let [under, over] = [made.under()?, made.over()?].map(|v| v.map(|v| v.as_mm3()));
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

/// Three decimals, for sentences.
fn rounded(x: f64) -> String {
    let digits = if x.abs() >= 100.0 { 1.0 } else { 1e3 };
    short((x * digits).round() / digits)
}
