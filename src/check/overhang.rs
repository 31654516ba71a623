//! AM201: surface that hangs over.

use super::contract::{Check, Context, MapKind, MapWanted, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, Limits, State, Witness};
use super::hanging::{Supports, hanging_share, islands_of, islands_turned, needing_support, plate_z};
use super::place::{group_equal, locate, reported};
use crate::access::{Question, flattest, support_angle, up_option};
use crate::error::Result;
use crate::geometry::vector::Vec3;
use crate::layer::{DownwardRegion, Island, downward_regions, support_volumes};
use crate::part::Part;
use crate::process::Process;
use crate::units::{Angle, report_digits, short};

/// AM201 `overhang`.
pub struct Overhang;

static META: Meta = Meta {
    code: "AM201",
    name: "overhang",
    title: "Downward surface flatter than the process holds up",
    what: "Finds downward surface whose angle from the horizontal is below the limit: 0 degrees is a flat ceiling, 90 degrees a \
           vertical wall. The underside on the plate, up to half a layer, is no overhang.",
    why: "Such surface is printed on air: it droops or curls, or it needs supports, which cost material, time and surface.",
    how: "The slope of every facet decides, so angle and area are exact. Facets that hang together over edges bent by less than 20 \
          degrees are one region. A facet whose angle differs from the limit by less than a step of its coordinates can turn it is \
          equal to the limit, be it the one that fails or the one that warns, and passes it. Of a facet that lies in part no more than a layer above \
          other material, or, flatter than 5 degrees, in part on the plate, the rest counts. The volume below a region is measured as `support` measures \
          that below all. Where it is open if a ceiling holds itself, what it hangs over is open too, and is told with an angle up to 90 degrees.",
    limits: "A bridge between two anchors, a ledge or the crown of a lying hole that is within its own limit holds itself: it is left to \
             `bridge`. For the rest slope alone is judged; \
             what is smaller than a dot of the process warns at most. \
             Where the process prints supports an overhang warns; it fails only if the profile or the user gives a fail limit.",
    source: "The limit's sources stand in the profile; `amcheck processes` lists them.",
};

/// What holds itself hangs over no more than a wall does, degrees.
const UPRIGHT: f64 = 90.0;

impl Check for Overhang {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        if process.powder_supports && limits_of(process, "overhang").is_none() {
            return Ok(Outcome::NotApplicable("loose powder holds the part up in this process".into()));
        }
        let Some(limits) = limits_of(process, "overhang") else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let widest = support_angle(process).unwrap_or(0.0);
        let wanted = needing_support(part, process, context.refine);
        let regions_of = |facets: &[u32]| {
            let share = |f: u32| facets.binary_search(&f).map_or(0.0, |_| hanging_share(part, process, f));
            downward_regions(part.mesh(), plate_z(process), Angle::degrees(widest), part.step(), share)
        };
        let mut all = regions_of(&wanted.sure);
        let open = if wanted.is_told() { Vec::new() } else { regions_of(&wanted.open()) };
        // A speck warns at most, whether or not it holds itself.
        let (specks, open): (Vec<_>, Vec<_>) = open.into_iter().partition(|r| r.area_mm2 < dot(process));
        all.extend(specks);
        let mut measured = Measured {
            cover: format!(
                "Every facet that looks down at less than {}° was judged by its own slope; what holds itself is judged by `bridge`.",
                short(widest)
            ),
            rule: Some("overhang"),
            map: Some(MapWanted {
                kind: MapKind::Slope,
                title: "Overhang angle from the horizontal",
                unit: "deg",
                limits,
                open_end: 90.0,
                facets: Vec::new(),
                field: None,
            }),
            ..Measured::default()
        };
        let flattest = |list: &[DownwardRegion]| {
            list.iter().map(|r| (r.least_angle.as_degrees(), r.worst.0)).min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let [sure, may] = [&all, &open].map(|list| flattest(list));
        measured.worst = match (sure, may) {
            (sure, Some((low, at))) if sure.is_none_or(|s| low < s.0) => {
                let high = sure.map_or(UPRIGHT, |s| s.0);
                Some(Worst { bracket: Bracket::new(low, low, high), unit: "deg", at: Some(at) })
            }
            (sure, _) => sure.map(|(least, at)| Worst { bracket: Bracket::exact(least), unit: "deg", at: Some(at) }),
        };
        let turn = if all.is_empty() { None } else { better_turn(part, process, &all, limits) };
        let told = Told { part, process, context, limits, turn };
        measured.findings.extend(told.findings(&all, |r| r.least_angle.as_degrees()));
        measured.findings.extend(told.findings(&open, |_| UPRIGHT));
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// What regions are told as.
struct Told<'a> {
    part: &'a Part,
    process: &'a Process,
    context: &'a Context,
    limits: Limits,
    /// A turn that helps, in words.
    turn: Option<String>,
}

impl Told<'_> {
    /// Regions with the greatest angle that they may have, worst first.
    fn findings(&self, all: &[DownwardRegion], greatest: impl Fn(&DownwardRegion) -> f64) -> Vec<Finding> {
        let (part, process) = (self.part, self.process);
        // As `support` measures it, for each region by itself.
        let below: Vec<Option<f64>> = if process.prints_supports && !all.is_empty() {
            let groups: Vec<&[u32]> = all.iter().map(|r| r.facets.as_slice()).collect();
            let found = support_volumes(part.mesh(), |f| part.bounds_solid(f), &groups, 0.0, self.context.spacing_mm);
            found.iter().map(|v| Some(report_digits(0.5 * (v.volume_mm3[0] + v.volume_mm3[1])))).collect()
        } else {
            vec![None; all.len()]
        };
        // What is smaller than a dot of the process is gathered in one finding, and no part fails for it.
        let limits = self.limits;
        let of_specks = Limits { fail: None, warn: limits.warn.or(limits.fail), ..limits };
        let (specks, regions): (Vec<_>, Vec<_>) = all.iter().zip(below).partition(|(r, _)| r.area_mm2 < dot(process));
        let supports = |r: &DownwardRegion| Supports::below(part, process, &r.facets);
        let (sealed, regions): (Vec<_>, Vec<_>) = regions.into_iter().partition(|(r, _)| supports(r) == Supports::Stay);
        let mut told = Vec::new();
        for (list, kind, limits, equal) in
            [(regions, "slope", limits, 0.5), (sealed, "slope", limits, 0.5), (specks, "specks", of_specks, 90.0)]
        {
            let supports = list.iter().map(|(r, _)| supports(r)).max().unwrap_or(Supports::None);
            let one = |(r, volume_mm3): &(&DownwardRegion, Option<f64>)| Finding {
                volume_mm3: *volume_mm3,
                ..self.finding(r, [r.least_angle.as_degrees(), greatest(r)], limits, kind)
            };
            let mut found: Vec<Finding> = list.iter().map(one).collect();
            found.sort_by(|a, b| a.value.total_cmp(&b.value).then_with(|| Finding::worst_first(a, b)));
            for mut f in group_equal(found, equal) {
                f.message = message(&f);
                f.fix = fix(supports, &f, self.turn.as_deref());
                told.push(f);
            }
        }
        told
    }

    fn finding(&self, r: &DownwardRegion, [least, greatest]: [f64; 2], limits: Limits, kind: &str) -> Finding {
        let (part, process) = (self.part, self.process);
        // Facet by facet: what is equal to the stricter limit is no part of a region, but may be all there is to the other.
        let tie = r.certain_angle.as_degrees() - least;
        let basis = if least == greatest { Basis::Exact } else { Basis::Certified };
        let mut f = Finding::judged(META.code, kind, Bracket::new(least, least, greatest), basis, limits, "deg", tie);
        if f.state == State::Pass {
            f.state = State::Warn;
        }
        f.area_mm2 = Some(report_digits(r.area_mm2));
        locate(&mut f, part, self.context, r.worst.0, r.extent);
        let layer = |z: f64| (z / process.layer_height_mm).floor().max(0.0) as u64;
        f.layers = Some([layer(r.extent.0[2]), layer(r.extent.1[2])]);
        let corners = part.mesh().corners(r.worst.1 as usize).map(|p| reported(part, p));
        f.witness = Some(Witness { kind: "facet".into(), points_mm: corners.to_vec() });
        f
    }
}

/// The area of a dot of the process, mm²: a square as wide as what it lays.
fn dot(process: &Process) -> f64 {
    process.element.width_mm * process.element.width_mm
}

fn message(f: &Finding) -> String {
    let area = short(f.area_mm2.unwrap_or(0.0));
    let angle = if f.value < 0.05 {
        "flat ceiling".to_string()
    } else {
        format!("{}° from the horizontal", short((f.value * 10.0).round() / 10.0))
    };
    if f.high == UPRIGHT {
        let places = if f.count > 1 { format!("{} places, ", f.count) } else { String::new() };
        return format!(
            "{places}{angle}, {area} mm² hanging over unless it holds itself as a bridge or ledge, which is open"
        );
    }
    match f.count {
        1 if f.kind == "specks" => format!("a speck smaller than a dot, {angle}, {area} mm²"),
        n if f.kind == "specks" => format!("{n} specks smaller than a dot, the flattest {angle}, {area} mm² in all"),
        1 => format!("{angle}, {area} mm² hanging over"),
        n => format!("{n} places, {angle}, {area} mm² hanging over in all"),
    }
}

/// A turn that more than halves what hangs over, in words, with what hangs over then, and with what begins in mid-air if that is more; none
/// that makes what only warns fail.
fn better_turn(part: &Part, process: &Process, regions: &[DownwardRegion], limits: Limits) -> Option<String> {
    let now: f64 = regions.iter().map(|r| r.area_mm2).sum();
    let turn = part.least_hanging(&Question::of(process, part.step()))?;
    let fails = |flattest: Angle| limits.fail.is_some_and(|l| flattest.as_degrees() < l - 1e-6);
    let as_it_stands = flattest(part.mesh(), regions.iter().flat_map(|r| r.facets.iter().copied()));
    let becomes_worse = fails(turn.flattest) && !fails(as_it_stands);
    (turn.hanging_mm2 < 0.5 * now && !becomes_worse).then(|| {
        let up = up_option(part.direction_to_file(turn.up));
        let then = match turn.hanging_mm2 {
            left if left > 0.0 => format!("{} mm² hang over in all", upwards(left)),
            _ => "nothing hangs over".into(),
        };
        format!("turn it with --up {up}: measured so, {then}{}", mid_air(part, process, turn.up))
    })
}

/// How much begins in mid-air of a part turned up so, in words, where it is more than as it stands: first layers of islands, as AM202 finds them.
fn mid_air(part: &Part, process: &Process, up: Vec3) -> String {
    let area = |all: Vec<Island>| all.iter().map(|i| i.first_layer_area_mm2).sum::<f64>();
    let is_judged = !process.powder_supports && limits_of(process, "island").is_some();
    let then = if is_judged { area(islands_turned(part, process, up)) } else { 0.0 };
    let now = if then > 0.0 { area(islands_of(part, process)) } else { 0.0 };
    // Turned by its rounding, an island is as large as it was.
    match then > now * (1.0 + 1e-6) {
        true => format!(" and {} mm² begin in mid-air, {} as it stands", upwards(then), upwards(now)),
        false => String::new(),
    }
}

/// An area in a sentence that must not be told as less than it is: whole square millimetres, hundredths of what is less than one.
fn upwards(mm2: f64) -> String {
    short(if mm2 < 1.0 { (100.0 * mm2).ceil() / 100.0 } else { mm2.ceil() })
}

fn fix(supports: Supports, f: &Finding, turn: Option<&str>) -> String {
    let limit = f.warn.or(f.fail).unwrap_or(0.0);
    let area = short(f.area_mm2.unwrap_or(0.0));
    let mut ways = vec![format!("slope it to {}° or more", short(limit))];
    ways.extend(turn.map(String::from));
    ways.push(match (supports, f.volume_mm3.filter(|v| *v >= 0.5)) {
        (Supports::None, _) => return format!("{}; this process prints no supports", ways.join(", ")),
        (Supports::Stay, _) => {
            return format!("{}; a support would stay in there: the void is sealed", ways.join(", or "));
        }
        (Supports::Hold, Some(v)) => format!("let {area} mm² be supported by about {} mm³", short(v.round())),
        (Supports::Hold, None) => format!("let {area} mm² be supported"),
    });
    let end = ways.pop().unwrap_or_default();
    format!("{}, or {end}", ways.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{cuboid, union::united};
    use crate::part::Up;

    #[test]
    fn a_turn_after_which_more_begins_in_mid_air_says_so() {
        // A plate with two prongs of 2 × 8 mm, 6 and 9 mm tall: upside down the shorter begins above the plate.
        let prongs = cuboid([0.0, 0.0, 1.0], [2.0, 8.0, 8.0]).joined(&cuboid([18.0, 0.0, 1.0], [20.0, 8.0, 11.0]));
        let mesh = united(&cuboid([0.0; 3], [20.0, 8.0, 2.0]).joined(&prongs), 1e-6).unwrap();
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 2.0).unwrap();
        let said = |process: &str, z: f64| mid_air(&part, &Process::named(process).unwrap(), [0.0, 0.0, z]);
        for process in ["fdm", "sla", "lpbf"] {
            assert_eq!(said(process, -1.0), " and 16 mm² begin in mid-air, 0 as it stands", "{process}");
            assert_eq!(said(process, 1.0), "", "{process}");
        }
        // Loose powder holds it up.
        assert_eq!(said("sls", -1.0), "");
    }
}
