//! AM302: liquid that the part keeps in this orientation, and cups that suck.

use super::basin::Basin;
use super::contract::{Check, Context, Measured, Meta, Outcome, ShapeShown, Worst, least_wall, limits_of};
use super::cup::{self, CupVents};
use super::finding::{Basis, Bracket, Finding, Limits, Spot, State};
use super::place::{group_equal, locate, reported, reported_box};
use super::tilt::{MEASURED_TILTS, best_tilt};
use super::void::{HALF_DIAGONAL, Voids};
use crate::access::up_option;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::contour::surface;
use crate::geometry::vector::Vec3;
use crate::part::Part;
use crate::process::Process;
use crate::topology::{Falls, Passage, retained};
use crate::units::{bulk, hundredths, report_digits, short};

/// AM302 `drain`.
pub struct Drain;

static META: Meta = Meta {
    code: "AM302",
    name: "drain",
    title: "Liquid kept in this orientation, and cups that suck",
    what: "Gives the volume of liquid that stays in the part while it hangs from the plate (build direction down), and the area of \
           film that each cup closes while its walls are printed. Sealed voids are left to trapped-volume.",
    why: "Kept resin is carried into the wash, cures where it should not and is paid for. A cup that closes on the film is under \
          vacuum at every layer: it tears the part off, or the film.",
    how: "A sample keeps liquid if every way to the outside rises above it: layers are added from the lowest up, regions are joined, \
          and what has not met the outside in its own layer keeps what it holds. The same from the other side gives the cups: what is \
          cut off from the outside while the layers above are not there yet. Done once with the samples that are wholly free, once \
          with all that may be; the volume between is bracketed. Its value comes from the densities: where a wall ends, the wall below \
          tells how much lies beside it, and how far it fills its last cube where the basin runs over; void on both sides of a wall \
          thinner than a cube counts half.",
    limits: "Holds for a plate above and a film below; where the printer has it the other way round, the two numbers change places. The plate closes nothing here: \
             what it closes of a part that stands flat on it `trapped-volume` says. \
             Films, drops and slow flow are not modelled, so nothing here fails. Basins of fewer than 27 samples are counted in the \
             cover. Of 25 tilts, looked at on a coarse grid of 64 samples, two are measured on the grid of the part; those that close no more film \
             than is allowed, or than the part does as it stands, come first. Of a cup whose rooms join above, at most eight get a vent.",
    source: "Priority flood: R. Barnes, C. Lehman, D. Mulla, Priority-flood: an optimal depression-filling algorithm, 2014.",
};

/// From this share of the film that is allowed on a tilt's cup is told: across slanted layers it is counted to a fifth.
const NEARLY: f64 = 0.8;
/// Cups for which a vent is tried; the others are told to have one.
const VENTED: usize = 12;

impl Check for Drain {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let (kept, suction) = (limits_of(process, "drain"), limits_of(process, "drain.suction"));
        if kept.is_none() && suction.is_none() {
            return Ok(Outcome::NotApplicable("nothing liquid is in this process, or it sets no limit".into()));
        }
        let voids = Voids::of(part)?;
        let mut judge = Judge {
            part,
            context,
            voids: &voids,
            wall_mm: least_wall(process).unwrap_or(context.spacing_mm),
            measured: Measured::default(),
            small: 0,
            shown: Indicator::empty(*voids.solid.outer.grid()),
        };
        if let Some(limits) = kept {
            judge.kept(limits, suction)?;
        }
        if let Some(limits) = suction {
            judge.suction(limits)?;
        }
        judge.finish()?;
        Ok(Outcome::Measured(Box::new(judge.measured)))
    }
}

struct Judge<'a> {
    part: &'a Part,
    context: &'a Context,
    voids: &'a Voids<'a>,
    /// The wall that has to stay around a vent.
    wall_mm: f64,
    measured: Measured,
    small: u64,
    /// The samples of all that is reported.
    shown: Indicator,
}

impl Judge<'_> {
    /// The basins of at least some samples, largest first, sealed voids left out.
    fn basins(&mut self, falls: Falls) -> Result<Vec<Basin>> {
        let solid = self.voids.solid;
        let likely = retained(&solid.outer.complement(), falls, Passage::Faces)?;
        let certain = retained(&solid.inner.complement(), falls, Passage::Corners)?.difference(&solid.outer)?;
        let (basins, small) = Basin::all(self.voids, &likely, &certain, falls)?;
        self.small += small;
        Ok(basins)
    }

    /// What stays in while the part hangs from the plate.
    fn kept(&mut self, limits: Limits, suction: Option<Limits>) -> Result<()> {
        let basins = self.basins(Falls::Up)?;
        let sum = basins.iter().map(|b| b.bracket()).fold(Bracket::exact(0.0), |s, b| Bracket {
            value: s.value + b.value,
            low: s.low + b.low,
            high: s.high + b.high,
        });
        let bracket = sum;
        let at = basins.first().map(Basin::bottom);
        self.worst(bracket, "mm3", at, "drain");
        let mut f = Finding::judged(META.code, "kept", bracket, Basis::Estimated, limits, "mm3", 0.0);
        let (Some(largest), Some(at)) = (basins.first(), at) else { return Ok(()) };
        if f.state == State::Pass {
            return Ok(());
        }
        locate(&mut f, self.part, self.context, at, largest.corners());
        f.count = basins.len() as u64;
        f.volume_mm3 = Some(report_digits(bracket.value));
        f.places = basins
            .iter()
            .map(|b| {
                let own = b.bracket().rounded();
                let at_mm = reported(self.part, b.bottom());
                let box_mm = Some(reported_box(self.part, b.corners()));
                Spot { at_mm, box_mm, value: own.value, low: own.low, high: own.high }
            })
            .collect();
        f.message = format!("keeps about {} mm³ of liquid while it hangs from the plate", short(bracket.value.round()));
        f.fix = self.tilting(bracket.value, suction)?;
        self.measured.findings.push(f);
        basins.iter().for_each(|b| b.join_into(&mut self.shown));
        Ok(())
    }

    /// What tilting the part does, in words.
    fn tilting(&self, kept: f64, suction: Option<Limits>) -> Result<String> {
        let drill = "drill a hole at the lowest place of each basin";
        let most = suction.map_or(f64::INFINITY, least_of);
        let Some(tilt) = best_tilt(self.voids, most)? else { return Ok(drill.into()) };
        let left = short(tilt.kept_mm3.round());
        if tilt.kept_mm3 >= 0.5 * kept {
            let which = if most.is_finite() { ", those first that close little film," } else { "" };
            return Ok(format!(
                "{drill}; the {MEASURED_TILTS} most promising of 25 tilts{which} keep {left} mm³ or more"
            ));
        }
        let angle = tilt.up[2].clamp(-1.0, 1.0).acos().to_degrees().round();
        let up = up_option(self.part.direction_to_file(tilt.up));
        let told = format!("tilt it by {angle}°, with --up {up}: measured again, it keeps about {left} mm³ then");
        let film = short(tilt.film_mm2().round());
        let cups = |least: f64| match tilt.films_mm2.iter().filter(|f| **f > least).count() {
            1 => ("it", format!("a cup closes about {film} mm² of film")),
            n => ("each", format!("{n} cups close film, the largest about {film} mm²")),
        };
        let cup = if tilt.film_mm2() > most {
            let (which, cups) = cups(most);
            format!(", but {cups}: drill {which} at the lowest place, too")
        } else if tilt.film_mm2() > NEARLY * most {
            format!(", and {}, nearly the {} that are allowed", cups(NEARLY * most).1, short(most))
        } else {
            String::new()
        };
        Ok(told + &cup)
    }

    /// The film that each cup closes.
    fn suction(&mut self, limits: Limits) -> Result<()> {
        let basins = self.basins(Falls::Down)?;
        let widest = least_of(limits);
        let mut found = Vec::new();
        let vents = CupVents::of(self.voids, self.wall_mm);
        for b in &basins {
            let bracket = b.film();
            let at = b.bottom();
            self.worst(bracket, "mm2", Some(at), "drain.suction");
            let mut f = Finding::judged(META.code, "cup", bracket, Basis::Estimated, limits, "mm2", 0.0);
            if f.state == State::Pass {
                continue;
            }
            locate(&mut f, self.part, self.context, at, b.corners());
            f.area_mm2 = Some(report_digits(bracket.value));
            f.volume_mm3 = Some(report_digits(b.volume));
            let half = 0.5 * self.context.spacing_mm;
            f.message = format!(
                "a cup that closes {} mm² of film between {} and {} mm above the plate",
                short(bracket.value.round()),
                short(((at[2] - half).max(0.0) * 10.0).round() / 10.0),
                short((b.rim_mm() * 10.0).round() / 10.0)
            );
            f.fix = if found.len() < VENTED { vents.advice(b, widest)? } else { cup::no_vent() };
            found.push(f);
            b.join_into(&mut self.shown);
        }
        // Cups of one kind differ by how the grid cuts their rims.
        let tolerance = found.first().map_or(0.0, |f: &Finding| 0.03 * f.value);
        let mut grouped = group_equal(found, tolerance);
        for f in grouped.iter_mut().filter(|f| f.count > 1) {
            f.message = format!("{} such cups, the first: {}", f.count, f.message);
        }
        self.measured.findings.extend(grouped);
        Ok(())
    }

    fn worst(&mut self, bracket: Bracket, unit: &'static str, at: Option<Vec3>, rule: &'static str) {
        let m = &mut self.measured;
        if m.worst.is_none() || (rule == "drain" && bracket.value > 0.0) {
            m.worst = Some(Worst { bracket, unit, at });
            m.rule = Some(rule);
        }
    }

    fn finish(&mut self) -> Result<()> {
        let m = &mut self.measured;
        let h = short(self.context.spacing_mm);
        // Walls may touch samples a diagonal off, on both sides of a cup.
        let narrow = hundredths(4.0 * HALF_DIAGONAL * self.context.spacing_mm);
        m.cover = format!(
            "Every layer of a grid of {h} mm was flooded, with the plate above and below. Cups narrower than {narrow} mm may be missed; \
             a smaller --voxel sees them."
        );
        if self.small > 0 {
            m.cover.push_str(&format!(
                " {} samples lie in basins too small to tell, {} in all.",
                self.small,
                bulk(self.small as f64 * self.context.spacing_mm.powi(3))
            ));
        }
        if !self.shown.is_empty() {
            let mesh = surface(&self.shown, |_| 0.5)?;
            m.shapes.push(ShapeShown { name: "liquid", title: "Liquid kept, and cups".into(), mesh });
        }
        Ok(())
    }
}

/// The tighter of the limits.
fn least_of(limits: Limits) -> f64 {
    limits.fail.into_iter().chain(limits.warn).fold(f64::INFINITY, f64::min)
}
