//! AM501: supports that cannot come out again.

use super::contract::{Check, Context, Measured, Meta, Outcome, ShapeShown, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, Limits, Witness};
use super::hanging::needing_support;
use super::place::{locate, reported};
use super::tooling::{Tooling, direction_in_file, round};
use crate::access::{Columns, Keeper, Removal, Setup, Stuck, patches, remove};
use crate::error::Result;
use crate::geometry::contour::surface;
use crate::geometry::vector::hull;
use crate::layer::{Supports, support_volumes, supports};
use crate::notice::number_of;
use crate::part::Part;
use crate::process::Process;
use crate::topology::Components;
use crate::units::{bulk_within, report_digits, short};
use std::collections::BTreeMap;

/// AM501 `support-access`.
pub struct SupportAccess;

static META: Meta = Meta {
    code: "AM501",
    name: "support-access",
    title: "Supports that no tool can take off",
    what: "Puts columns under all surface flatter than the overhang limit that does not hold itself, takes them away in rounds with the listed tools, and \
           gives what stays for ever: its volume, the contact that no tool reaches, and whether the part, other supports or the support itself keeps the tools off.",
    why: "A support that cannot be taken off stays in the part; in a cavity it cannot even be seen.",
    how: "Columns go straight down from every overhang to the part or the plate; a support is what hangs together. It comes off in a \
          round if each of its contacts with the part is reached: the cutter, free of the part and of all supports that still stand \
          (cut back by the stand-off from their contacts), comes within 2·√3 spacings of a point of the contact with nothing in \
          between. This is repeated until nothing more comes off. The part has left the plate, so tools may come from below. What \
          the part alone does not keep is tried with no support but its own standing, the eight largest of these.",
    limits: "Where supports stand is an assumption: a slicer makes thinner ones, and soluble supports need no tool. Contacts smaller than four squares of the grid are taken to tear off; up to \
             30 points of the others are tried, from 26 directions. An estimate, so it warns and never fails; a support is as large as what lies \
             below the facets that hang on it, as `support` measures it, in proportion where several hang from the same.",
    source: "S. Nelaturi, M. Behandish, A. Mirzendehdel, J. de Kleer, Automatic support removal for additive manufacturing post \
             processing, 2019.",
};

/// Separate findings, largest first.
const MOST_FINDINGS: usize = 4;

impl Check for SupportAccess {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let (Some(limits), Some(hangs)) = (limits_of(process, "support-access"), limits_of(process, "overhang")) else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        if !process.prints_supports || process.tools.removal.is_empty() {
            return Ok(Outcome::NotApplicable("the process prints no supports that a tool takes off".into()));
        }
        let angle = hangs.warn.or(hangs.fail).unwrap_or(0.0);
        let facets = needing_support(part, process, context.refine).facets;
        let mut measured = Measured {
            cover: format!("No surface flatter than {}° needs support.", short(angle)),
            rule: Some("support-access"),
            worst: Some(Worst { bracket: Bracket::exact(0.0), unit: "mm3", at: None }),
            ..Measured::default()
        };
        if facets.is_empty() {
            return Ok(Outcome::Measured(Box::new(measured)));
        }
        let tooling = Tooling::of_removal(part, process, context)?;
        let Some(first) = tooling.setups.first() else { return Ok(Outcome::Measured(Box::new(measured))) };
        let made = supports(&first.centres, part.mesh(), &facets, 0.0)?;
        let columns = Columns { all: &made.columns, heads: &made.heads, feet: &made.feet_on_part };
        let pieces = patches(part.mesh(), 2.0 * tooling.spacing, |f| part.bounds_solid(f));
        let setups: Vec<&Setup> = tooling.setups.iter().collect();
        let removal = remove(columns, &pieces, &tooling.tools, &setups, tooling.stand_off, part.distance())?;
        let volumes = volumes(part, &made, &removal.supports, &facets, context.spacing_mm);
        let judged = Judged { part, context, tooling: &tooling, removal: &removal, volumes, limits };
        measured.cover = judged.cover(angle);
        let findings = judged.kept().into_values().map(|worst| judged.finding(worst));
        measured.findings = findings.collect();
        measured.findings.sort_by(|a, b| b.value.total_cmp(&a.value).then_with(|| Finding::worst_first(a, b)));
        let stays = sum(judged.kept().keys().map(|&c| judged.volumes[c as usize]));
        let largest = |f: &Finding| (Bracket::new(f.value, f.low, f.high), Some(part.to_build(f.at_mm)));
        let (bracket, at) = measured.findings.first().map_or((Bracket::exact(0.0), None), largest);
        measured.worst = Some(Worst { bracket, unit: "mm3", at });
        judged.gather(&mut measured.findings);
        if !removal.remaining.is_empty() {
            measured.shapes.push(ShapeShown {
                name: "supports-that-stay",
                title: format!("Supports that stay, {}", bulk_within(stays.value, [stays.low, stays.high])),
                mesh: surface(&removal.remaining, |_| 0.5)?,
            });
        }
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// Volume of each support: what lies below the facets that hang on it, as `support` measures it; several that hang from the same
/// facets have theirs in proportion to their samples.
fn volumes(part: &Part, made: &Supports, pieces: &Components, facets: &[u32], column_mm: f64) -> Vec<Bracket> {
    let (family, lists) = made.families((pieces.count(), |at| pieces.of(at)), part.mesh(), facets);
    let groups: Vec<&[u32]> = lists.iter().map(Vec::as_slice).collect();
    let found = support_volumes(part.mesh(), |f| part.bounds_solid(f), &groups, 0.0, column_mm);
    let sizes = pieces.sizes();
    let mut of_family = vec![0; sizes.len()];
    family.iter().zip(&sizes).for_each(|(&of, size)| of_family[of as usize] += size);
    let sample = made.columns.grid().sample_volume().as_mm3();
    let share = |(&of, &size): (&u32, &u64)| {
        let [low, high] = found[of as usize].volume_mm3.map(|v| v * size as f64 / of_family[of as usize] as f64);
        // What no column of facets shows is as large as its samples.
        if high > 0.0 { Bracket::new(0.5 * (low + high), low, high) } else { Bracket::exact(size as f64 * sample) }
    };
    family.iter().zip(&sizes).map(share).collect()
}

fn sum(brackets: impl Iterator<Item = Bracket>) -> Bracket {
    brackets.fold(Bracket::exact(0.0), |a, b| Bracket {
        value: a.value + b.value,
        low: a.low + b.low,
        high: a.high + b.high,
    })
}

struct Judged<'a> {
    part: &'a Part,
    context: &'a Context,
    tooling: &'a Tooling<'a>,
    removal: &'a Removal,
    volumes: Vec<Bracket>,
    limits: Limits,
}

impl Judged<'_> {
    /// For each support that stays the largest contact that keeps it.
    fn kept(&self) -> BTreeMap<u32, &Stuck> {
        let mut kept: BTreeMap<u32, &Stuck> = BTreeMap::new();
        for s in &self.removal.stuck {
            let worst = kept.entry(s.component).or_insert(s);
            if s.area_mm2 > worst.area_mm2 {
                *worst = s;
            }
        }
        kept
    }

    fn cover(&self, angle: f64) -> String {
        let all = sum(self.volumes.iter().copied()).value;
        let (supports, stays) = (self.removal.supports.count(), self.kept().len());
        let peeled = match self.removal.rounds.as_slice() {
            [] if supports == 0 => "none is as wide as a sample".to_string(),
            [] if stays == 0 => "they tear off".to_string(),
            [] => "none comes off".to_string(),
            [all] if all.len() == 1 => "1 comes off at once".to_string(),
            [all] => format!("{} come off at once", all.len()),
            rounds => {
                let counts: Vec<String> = rounds.iter().map(|r| r.len().to_string()).collect();
                format!("they come off in {} rounds of {}", rounds.len(), counts.join(", "))
            }
        };
        format!(
            "{} of {} mm³ under surface flatter than {}°: {peeled}, {stays} {}, by {}, within {} mm, and for these only.",
            number_of(supports as u64, ["support", "supports"]),
            short(if all < 1.0 { round(all) } else { all.round() }),
            short(angle),
            if stays == 1 { "stays" } else { "stay" },
            self.tooling.described(),
            short(round(self.tooling.stand_off)),
        )
    }

    fn finding(&self, worst: &Stuck) -> Finding {
        let c = worst.component as usize;
        let bracket = self.volumes[c];
        let volume = bracket.value;
        let mut f = Finding::judged(META.code, "stays", bracket, Basis::Estimated, self.limits, "mm3", 0.0);
        f.volume_mm3 = Some(report_digits(volume));
        f.area_mm2 = Some(report_digits(worst.area_mm2));
        locate(&mut f, self.part, self.context, worst.contact.at, hull(self.removal.boxes[c], worst.extent));
        let area = short(round(worst.area_mm2));
        let stands = worst.contact.normal[2] > 0.0;
        let contact =
            if stands { format!("the {area} mm² that it stands on") } else { format!("its contact of {area} mm²") };
        let why = match worst.keeper {
            Keeper::Part => format!("the part keeps the tools from {contact}"),
            Keeper::Itself => format!("it is in the way of its own removal, for no tool gets past it to {contact}"),
            Keeper::Others => format!("other supports keep the tools from {contact}"),
            Keeper::Supports => format!("supports keep the tools from {contact}"),
        };
        f.message = format!("a support of {} mm³ stays: {why}", short(round(volume)));
        f.fix = match stands {
            true => format!("slope or remove what hangs over them, so that no support stands on these {area} mm²"),
            false => format!("slope or remove the {area} mm² that hang over"),
        };
        if worst.keeper == Keeper::Itself {
            f.fix += ", or divide the support into pieces that come out one by one";
        }
        // How near a tool comes is measured past the part alone.
        if let (Keeper::Part, Some((short_by, tool, direction))) = (worst.keeper, worst.short) {
            let from = direction_in_file(self.part, direction);
            let name = &self.tooling.tools[tool].name;
            f.message += &format!("; {name} stops {} mm short, from {from}", short(round(short_by)));
        }
        f.witness = Some(Witness { kind: "contact".into(), points_mm: vec![reported(self.part, worst.contact.at)] });
        f
    }

    /// Gathers what is beyond the number of separate findings in the last one, which is judged by the largest of it.
    fn gather(&self, findings: &mut Vec<Finding>) {
        if findings.len() <= MOST_FINDINGS {
            return;
        }
        let rest = findings.split_off(MOST_FINDINGS);
        let bracket = sum(rest.iter().map(|f| Bracket { value: f.value, low: f.low, high: f.high })).rounded();
        let Some(mut f) = rest.into_iter().reduce(|mut all, f| {
            all.count += f.count;
            all.places.extend(f.places);
            for a in 0..3 {
                all.box_mm[0][a] = all.box_mm[0][a].min(f.box_mm[0][a]);
                all.box_mm[1][a] = all.box_mm[1][a].max(f.box_mm[1][a]);
            }
            all
        }) else {
            return;
        };
        f.volume_mm3 = Some(bracket.value);
        f.kind = "stay".into();
        f.message = format!("{} more supports, {} mm³ in all, stay", f.count, short(round(bracket.value)));
        findings.push(f);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::part::Up;

    #[test]
    fn each_support_is_told_and_judged_by_itself() {
        // Sealed rooms 6 mm high with ceilings too wide for a bridge.
        let sides = [12.0, 13.0, 14.0, 15.0, 16.0, 12.5];
        let room = |n: usize| cuboid([18.0 * n as f64 + 1.0, 2.0, 2.0], [18.0 * n as f64 + 1.0 + sides[n], 16.0, 8.0]);
        let block = cuboid([0.0; 3], [108.0, 18.0, 10.0]);
        let hollow = (0..sides.len()).fold(block, |all, n| all.joined(&room(n).flipped()));
        let part = Part::new(hollow, Up::PlusZ, 1e-6, 1.0).unwrap();
        let (process, context) = (Process::named("fdm").unwrap(), Context { refine: 0, spacing_mm: 0.5 });
        let Ok(Outcome::Measured(found)) = SupportAccess.run(&part, &process, &context) else { panic!() };
        let about = |value: f64, truth: f64| (value - truth).abs() < 0.1 * truth;
        let of = |side: f64| side * 14.0 * 6.0;
        assert!(about(found.worst.as_ref().unwrap().bracket.value, of(16.0)), "{:?}", found.worst);
        let gathered = found.findings.iter().find(|f| f.kind == "stay").expect("more than four");
        assert!(gathered.count == 2 && about(gathered.value, of(12.5)), "{gathered:?}");
        assert!(about(gathered.volume_mm3.unwrap(), of(12.5) + of(12.0)), "{gathered:?}");
    }
}
