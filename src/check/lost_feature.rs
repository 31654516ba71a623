//! AM106: material that the process' element cannot make at all, and detail too fine to read.

use super::budget::Budget;
use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::departing::rounded;
use super::departure::{Departure, Place};
use super::detail::{Between, Detail, Sought, raised_width, rule_width};
use super::finding::{Basis, Bracket, Finding, Limits, State, Witness};
use super::place::{group_equal, locate, reported};
use super::relief::relief;
use super::stroke_room::has_room;
use super::thin_body::thin_bodies;
use super::trial::Trial;
use crate::error::Result;
use crate::geometry::vector::Vec3;
use crate::medial::Side;
use crate::morphology::Bead;
use crate::part::{Part, bead_of};
use crate::process::Process;
use crate::units::{report_digits, short};

/// AM106 `lost-feature`.
pub struct LostFeature;

/// Places whose volume is measured on a lattice of their own, and for which a thickness that prints is sought; others are measured as
/// far as the budget for finer looks goes.
const MEASURED: usize = 6;
/// Samples that have to be left for that: as many as its lattice may take.
const FIRST_LOOK: u64 = 1 << 22;

static META: Meta = Meta {
    code: "AM106",
    name: "lost-feature",
    title: "Material that the process' element cannot make",
    what: "Finds sheets, rods and specks that the least element of the process (its bead, spot or pixel, one layer high) does not fit \
           into: what the opening of the part by that element removes altogether, whole bodies among it. Raised and engraved detail that prints, but \
           narrower than the process shows it, is named apart.",
    why: "A slicer drops such material without a word, or prints it wider than drawn.",
    how: "Every pair of opposing features is searched as for thin-wall. A sheet with normal n is lost if it is thinner than the \
          element along n, and so is a rod into whose section it does not fit, and a body that lies between two planes nearer to each other than that. Its volume is measured on a lattice that divides the element: the material in cells in which nothing can be printed, and in \
          those in which perhaps not all is; where a limit lies between, on finer cells or window by window, as far as the budget goes. Convex edges, which every opening rounds, hold no ball between opposing sides and are never \
          counted; nor is a wedge that thins to its edge. The thickness that is suggested has been given to the cells and the \
          opening taken again.",
    limits: "Detail ends with a face on one side and is three times as wide on the other, at most 2 mm apart, and nowhere wider between them; relief \
             lower than half its width, and what is not half as long again as wide, are not looked at here. Each lost place is judged by itself; the cover line tells the volume of all. \
             Volume is bracketed for what is lost and hangs together within the place and half an element around it, rounding of edges \
             that touch it there included. \
             The element is made of whole cells, and another division makes another one: the bracket holds for the element of the \
             division that gave it.",
    source: "Opening: G. Matheron, Random Sets and Integral Geometry, 1975. Limits: see the profile.",
};

impl Check for LostFeature {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let lost = limits_of(process, "lost-feature");
        let [raised, engraved] = ["lost-feature.embossed", "lost-feature.engraved"].map(|k| limits_of(process, k));
        if lost.is_none() && raised.is_none() && engraved.is_none() {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        }
        let bead = bead_of(process);
        let mut measured = Measured { rule: lost.map(|_| "lost-feature"), ..Measured::default() };
        let (side, between) = (Side::Material, Between::SidesOfABody);
        let sought = Sought { part, process, context, side, between, width: raised_width(process) };
        let found = sought.search();
        let mut covered = format!(
            "No material thinner than {} mm over more than {} mm was left out",
            short(bead.widest().as_mm()),
            short(found.finest)
        );
        if let Some(limits) = lost {
            let whole = thin_bodies(part, |n| bead.width_along(n).as_mm());
            let is_whole = |d: &Detail| {
                let body = part.health().facet_body.get(d.facet as usize);
                whole.iter().any(|b| body == Some(&b.body))
            };
            let mut gone = found.places(|s| s.diameter < bead.width_along(s.direction()).as_mm() - part.tie());
            gone.extend(found.rods_beside(&gone, |n| bead.width_along(n).as_mm()));
            gone.retain(|d| !is_whole(d));
            gone.extend(whole.iter().map(Detail::from));
            gone.sort_by(|a, b| b.volume.total_cmp(&a.volume));
            let judge = Lost { part, context, bead, limits };
            // Where the surface is not closed, inside is as doubtful on finer cells, and casts take many times as long.
            let samples = if part.health().is_solid() { context.refine } else { 0 };
            let (mut findings, mut budget) = (Vec::new(), Budget::of(samples));
            for (i, detail) in gone.iter().enumerate() {
                findings.push(judge.finding(detail, i, &mut budget)?);
            }
            measured.budget = (budget.looks > 0).then_some(budget);
            let lost: Vec<f64> = findings.iter().map(|f| f.value).filter(|v| *v > 0.0).collect();
            let all = match lost.len() {
                0 | 1 => String::new(),
                _ if !lie_apart(&findings) => ", counted each with what it shares with others,".into(),
                _ => format!(", {} mm³ in all,", rounded(lost.iter().sum())),
            };
            let places = lost.len();
            measured.worst = Some(findings.iter().max_by(|a, b| a.value.total_cmp(&b.value)).map_or(
                Worst { bracket: Bracket::exact(0.0), unit: "mm3", at: None },
                |f| Worst {
                    bracket: Bracket { value: f.value, low: f.low, high: f.high },
                    unit: "mm3",
                    at: Some(part.to_build(f.at_mm)),
                },
            ));
            measured.findings.extend(one_by_state(findings));
            covered.push_str(&format!(
                "; {places} places{all} are lost to an element of {} × {} mm",
                short(bead.width.as_mm()),
                short(bead.height.as_mm())
            ));
        }
        if let Some(limits) = raised {
            let width = rule_width(process, "lost-feature.embossed");
            let fine = found.sheets(|s| {
                s.diameter < width - part.tie() && s.diameter >= bead.width_along(s.direction()).as_mm() - part.tie()
            });
            let finest = finest_relief(part, Side::Material, &found.sheets(|s| s.diameter < width - part.tie()));
            measured.findings.extend(details((part, context), Side::Material, (&fine, finest), limits));
        }
        if let Some(limits) = engraved {
            let fused = limits_of(process, "narrow-gap").and_then(|l| l.fail).unwrap_or(0.0);
            let width = rule_width(process, "lost-feature.engraved");
            let (side, between) = (Side::Void, Between::SidesOfABody);
            let sought = Sought { part, process, context, side, between, width };
            let found = sought.search();
            let fine = found.sheets(|s| s.diameter < width - part.tie() && s.diameter >= fused - part.tie());
            let finest = finest_relief(part, Side::Void, &found.sheets(|s| s.diameter < width - part.tie()));
            measured.findings.extend(details((part, context), Side::Void, (&fine, finest), limits));
        }
        measured.cover = covered + ".";
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// Places that vanish.
struct Lost<'a> {
    part: &'a Part,
    context: &'a Context,
    bead: Bead,
    limits: Limits,
}

impl Lost<'_> {
    fn finding(&self, detail: &Detail, rank: usize, budget: &mut Budget) -> Result<Finding> {
        let normal = detail.thinnest.direction();
        let needed = self.bead.width_along(normal).as_mm();
        let measured = rank < MEASURED || budget.left >= FIRST_LOOK;
        let trial =
            if measured { Trial::closely(self.part, self.bead, detail.extent, Departure::Opened)? } else { None };
        if let (Some(trial), true) = (&trial, rank >= MEASURED) {
            budget.note(1, trial.cells());
        }
        let counted = trial.as_ref().map(|t| Ok((t.cell(), t.volumes()?))).transpose()?;
        let about = detail.volume;
        let (bracket, basis) = match counted {
            _ if detail.whole.is_some() => (Bracket::exact(about), Basis::Exact),
            Some((cell, counted)) => {
                let place = Place {
                    part: self.part,
                    bead: self.bead,
                    departure: Departure::Opened,
                    limits: self.limits,
                    extent: detail.extent,
                    narrowest: detail.thinnest.centre,
                    across: normal,
                    missing: needed - detail.thinnest.diameter,
                    // Between the sides of a sheet lies what it holds; the sides of a rod or a speck have no such volume.
                    likely: (detail.noun() == "sheet").then_some(about),
                    patches: &[],
                };
                let ([value, low, high], _) = place.told((counted, cell), budget.left, budget)?;
                // Cells that are too coarse for a sheet tell less of it than what lies between its sides.
                (Bracket::new(place.likely.unwrap_or(value).clamp(low, high), low, high), Basis::Certified)
            }
            None => (Bracket::new(about, 0.0, about.max(detail.area * needed)), Basis::Estimated),
        };
        let mut f = Finding::judged(META.code, "lost", bracket, basis, self.limits, "mm3", 0.0);
        let t = &detail.thinnest;
        locate(&mut f, self.part, self.context, t.centre, detail.extent);
        f.area_mm2 = detail.whole.is_none().then(|| report_digits(detail.area));
        f.bodies = detail.whole.map(|body| vec![u64::from(body) + 1]);
        f.volume_mm3 = Some(report_digits(bracket.value));
        let points = [t.centre, t.contacts[0], t.contacts[1]].map(|p| reported(self.part, p));
        f.witness = Some(Witness { kind: "medial-ball".into(), points_mm: points.to_vec() });
        let (is_lost, at_most) = if f.decided { ("is", "") } else { ("may be", "at most ") };
        let volume = if f.decided { bracket.value } else { bracket.high };
        f.message = format!(
            "{} of {} mm {is_lost} lost: the element is {} mm wide across it; {at_most}{} mm³",
            detail.noun(),
            rounded(t.diameter),
            rounded(needed),
            rounded(volume)
        );
        let missing = needed - t.diameter;
        let steps = match &trial {
            Some(trial) if rank < MEASURED => trial.remedied(normal, missing)?,
            _ => None,
        };
        f.fix = match (&trial, steps) {
            (Some(trial), Some(steps)) => {
                let added = steps as f64 * trial.step_along(normal);
                let to = t.diameter + added;
                format!("thicken by {} mm to {} mm; checked: none of it is lost then", rounded(added), rounded(to))
            }
            _ => {
                format!(
                    "the element is {} mm wide across it, {} mm more than the {}",
                    rounded(needed),
                    rounded(missing),
                    detail.noun()
                )
            }
        };
        Ok(f)
    }
}

/// The width of the finest stroke, what is too fine for detail and told as a wall or a gap among them.
fn finest_relief(part: &Part, side: Side, all: &[Detail]) -> f64 {
    let strokes = all.iter().filter(|d| relief(part, side, &d.thinnest).is_some());
    strokes.map(|d| d.thinnest.diameter).fold(f64::INFINITY, f64::min)
}

/// Findings of detail that is narrower than the process shows; the finest of all strokes says how many times they have to be enlarged.
fn details(
    (part, context): (&Part, &Context),
    side: Side,
    (found, finest): (&[Detail], f64),
    limits: Limits,
) -> Vec<Finding> {
    let (kind, noun) = match side {
        Side::Material => ("embossed-detail", "raised detail"),
        Side::Void => ("engraved-detail", "engraved detail"),
    };
    let limit = limits.warn.or(limits.fail).unwrap_or(0.0);
    let mut findings: Vec<Finding> = found
        .iter()
        .filter_map(|d| Some((d, relief(part, side, &d.thinnest)?)))
        .map(|(d, stroke)| {
            let t = &d.thinnest;
            let bracket = Bracket::new(t.diameter, d.low, t.diameter);
            let mut f = Finding::judged(META.code, kind, bracket, Basis::Certified, limits, "mm", part.tie());
            locate(&mut f, part, context, t.centre, d.extent);
            f.area_mm2 = Some(report_digits(d.area));
            let points = [t.centre, t.contacts[0], t.contacts[1]].map(|p| reported(part, p));
            f.witness = Some(Witness { kind: "medial-ball".into(), points_mm: points.to_vec() });
            f.fix = if has_room(&stroke, d, limit) { "room".into() } else { String::new() };
            f
        })
        .collect();
    findings.sort_by(|a, b| a.value.total_cmp(&b.value).then_with(|| Finding::worst_first(a, b)));
    // One finding for a family of strokes: an inscription is one place to change.
    let roomy = findings.iter().filter(|f| f.fix == "room").count();
    let all = findings.len();
    let mut grouped = group_equal(findings, limit);
    for f in &mut grouped {
        f.message = match f.count {
            1 => format!("{noun} {} mm wide", rounded(f.value)),
            n => format!("{n} strokes of {noun}, the finest {} mm wide", rounded(f.value)),
        };
        let finer = finest < f.value - part.tie();
        if finer {
            f.message += &format!("; others beside, down to {} mm, are finer still", rounded(finest));
        }
        let factor = (1e2 * limit / finest.min(f.value) - 1e-4).ceil() / 1e2;
        f.fix = if roomy == all {
            format!(
                "widen to {} mm: there is room for it, checked on the surface; or enlarge it {} times",
                short(limit),
                short(factor)
            )
        } else {
            let meets = match all {
                1 => "it would meet its neighbour".into(),
                _ => format!("{} of {all} strokes would meet their neighbours", all - roomy),
            };
            let of_all = if finer { " at the finest" } else { "" };
            format!("enlarge it {} times, to {} mm{of_all}: widened in place, {meets}", short(factor), short(limit))
        };
    }
    grouped
}

/// What is not within its limit, largest first, as one finding for each state: what is decided by itself.
pub fn one_by_state(mut findings: Vec<Finding>) -> Vec<Finding> {
    findings.retain(|f| f.state > State::Pass);
    findings.sort_by(|a, b| b.value.total_cmp(&a.value).then_with(|| Finding::worst_first(a, b)));
    let (decided, open): (Vec<_>, Vec<_>) = findings.into_iter().partition(|f| f.decided);
    [decided, open].map(joined).concat()
}

/// Findings as one, with their sum where no two count the same.
fn joined(findings: Vec<Finding>) -> Vec<Finding> {
    let apart = lie_apart(&findings);
    let mut grouped = group_equal(findings, f64::INFINITY);
    for f in grouped.iter_mut().filter(|f| f.count > 1) {
        let sum =
            if apart { format!(", {} mm³ in all", rounded(f.volume_mm3.unwrap_or(f.value))) } else { String::new() };
        f.volume_mm3 = f.volume_mm3.filter(|_| apart);
        f.message = format!("{} places{sum}; the largest: {}", f.count, f.message);
    }
    grouped
}

/// Whether the boxes of findings lie apart: what hangs together is counted with each place that it lies beside.
fn lie_apart(findings: &[Finding]) -> bool {
    let mut boxes: Vec<[Vec3; 2]> = findings.iter().map(|f| f.box_mm).collect();
    boxes.sort_by(|a, b| a[0][0].total_cmp(&b[0][0]));
    let meets = |a: &[Vec3; 2], b: &[Vec3; 2]| (0..3).all(|c| a[0][c] <= b[1][c] && b[0][c] <= a[1][c]);
    boxes
        .iter()
        .enumerate()
        .all(|(n, a)| boxes.iter().skip(n + 1).take_while(|b| b[0][0] <= a[1][0]).all(|b| !meets(a, b)))
}

#[cfg(test)]
mod tests {
    use super::super::void::tests::turned;
    use super::*;
    use crate::geometry::union::united;
    use crate::geometry::{TriangleMesh, cuboid};
    use crate::part::Up;
    use crate::random::Lcg;

    #[test]
    fn places_that_count_the_same_have_no_sum() {
        let of = |lo: f64, hi: f64| {
            let limits = Limits { fail: None, warn: Some(0.1), sense: crate::check::Sense::Max };
            let mut f = Finding::judged("AM106", "lost", Bracket::exact(1.0), Basis::Exact, limits, "mm3", 0.0);
            (f.box_mm, f.volume_mm3) = ([[lo, 0.0, 0.0], [hi, 1.0, 1.0]], Some(1.0));
            f
        };
        let apart = one_by_state(vec![of(0.0, 1.0), of(2.0, 3.0), of(1.2, 1.8)]);
        assert!(
            apart[0].message.starts_with("3 places, 3 mm³ in all") && apart[0].volume_mm3 == Some(3.0),
            "{apart:?}"
        );
        let shared = one_by_state(vec![of(0.0, 1.0), of(2.0, 3.0), of(0.8, 1.8)]);
        assert!(shared[0].message.starts_with("3 places; the largest") && shared[0].volume_mm3.is_none(), "{shared:?}");
    }

    /// What AM106 calls raised or engraved in fdm.
    fn told(mesh: TriangleMesh) -> Vec<String> {
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 3.0).unwrap();
        let context = Context { refine: 1_000_000, spacing_mm: 0.1 };
        let process = Process::named("fdm").unwrap();
        let Ok(Outcome::Measured(found)) = LostFeature.run(&part, &process, &context) else { panic!("not measured") };
        let findings = found.findings.iter().filter(|f| f.message.contains("detail"));
        findings.map(|f| f.message.clone()).collect()
    }

    /// A plate of 20 × 20 × 4 mm with a fin or, 6 mm higher, a slot in it, 0.5 × 10 mm and so high, in one piece.
    fn part(height: f64, sunk: bool) -> TriangleMesh {
        let (top, [x, y]) = (if sunk { 10.0 } else { 4.0 }, [[5.0, 15.0], [9.75, 10.25]]);
        let mut facets: Vec<[[f64; 3]; 3]> = Vec::new();
        let mut quad = |[p, q, r, s]: [[f64; 3]; 4]| facets.extend([[p, q, r], [p, r, s]]);
        let plate = cuboid([0.0; 3], [20.0, 20.0, top]);
        let end = if sunk { top - height } else { top + height };
        let at = |p: [f64; 2], z: f64| [p[0], p[1], z];
        let inner = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
        let outer = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]];
        for i in 0..4 {
            let j = (i + 1) % 4;
            quad([at(outer[i], top), at(outer[j], top), at(inner[j], top), at(inner[i], top)]);
            quad([at(inner[i], top), at(inner[j], top), at(inner[j], end), at(inner[i], end)]);
        }
        quad(inner.map(|p| at(p, end)));
        let rest = (0..plate.triangles.len()).map(|f| plate.corners(f));
        facets.extend(rest.filter(|c| c.iter().any(|p| p[2] != top)));
        TriangleMesh::weld(facets)
    }

    /// Every facet cut into four.
    fn cut(mesh: &TriangleMesh) -> TriangleMesh {
        let middle = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|a| 0.5 * (p[a] + q[a]));
        let quarters = (0..mesh.triangles.len()).flat_map(|f| {
            let [p, q, r] = mesh.corners(f);
            let [a, b, c] = [middle(p, q), middle(q, r), middle(r, p)];
            [[p, a, c], [a, q, b], [c, b, r], [a, b, c]]
        });
        TriangleMesh::weld(quarters)
    }

    #[test]
    fn fins_and_slots_are_detail_up_to_two_millimetres_however_they_are_turned_and_divided() {
        for (height, sunk) in [1.0, 1.9, 2.0, 2.1, 3.0, 6.0].into_iter().flat_map(|h| [(h, false), (h, true)]) {
            let mesh = part(height, sunk);
            assert!(mesh.signed_volume() > 0.0);
            for degrees in [0.0f64, 10.0, 30.0, 45.0] {
                let (s, c) = degrees.to_radians().sin_cos();
                let turned = mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [3.7, -0.3, 0.0]);
                for divided in [turned.clone(), cut(&turned)] {
                    let found = told(divided);
                    assert_eq!(found.len(), usize::from(height <= 2.0), "{height} {sunk} {degrees}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn an_inscription_is_enlarged_by_its_finest_stroke() {
        // Beside the fin of 0.5 mm one that is no detail, but lost: 0.3 mm.
        let finer = cuboid([5.0, 3.0, 3.9], [15.0, 3.3, 5.0]);
        let mesh = united(&part(1.0, false).joined(&finer), 1e-6).unwrap();
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 3.0).unwrap();
        let (process, context) = (Process::named("fdm").unwrap(), Context { refine: 1_000_000, spacing_mm: 0.1 });
        let Ok(Outcome::Measured(found)) = LostFeature.run(&part, &process, &context) else { panic!() };
        let detail = found.findings.iter().find(|f| f.kind == "embossed-detail").unwrap();
        assert!(detail.message.ends_with("; others beside, down to 0.3 mm, are finer still"), "{}", detail.message);
        assert!(detail.fix.contains("enlarge it 2 times"), "{}", detail.fix);
    }

    #[test]
    fn strokes_that_stand_apart_have_room_whatever_their_pose() {
        let mut rng = Lcg(5);
        let mut told = 0;
        for case in 0..16 {
            let strokes = cuboid([3.0, 3.0, 2.9], [9.0, 3.3, 3.5]).joined(&cuboid([3.0, 5.8, 2.9], [9.0, 6.275, 3.5]));
            let mesh = united(&cuboid([0.0; 3], [12.0, 9.0, 3.0]).joined(&strokes), 1e-6).unwrap();
            let turned = if case == 0 { mesh } else { turned(&mesh, || rng.unit()) };
            let part = Part::new(turned, Up::PlusZ, 1e-6, 3.0).unwrap();
            let (process, context) = (Process::named("lpbf").unwrap(), Context { refine: 1_000_000, spacing_mm: 0.1 });
            let Ok(Outcome::Measured(found)) = LostFeature.run(&part, &process, &context) else { panic!() };
            for f in found.findings.iter().filter(|f| f.kind == "embossed-detail") {
                assert!(f.fix.contains("there is room for it"), "{case}: {}", f.fix);
                told += 1;
            }
        }
        assert!(told >= 12, "{told}");
    }

    #[test]
    fn a_stroke_has_room_only_if_it_has_it_all_along() {
        let advice = |blocks: &[TriangleMesh]| {
            let mesh = blocks.iter().fold(part(1.0, false), |m, b| m.joined(b));
            let mesh = if blocks.is_empty() { mesh } else { united(&mesh, 1e-6).unwrap() };
            let part = Part::new(mesh, Up::PlusZ, 1e-6, 3.0).unwrap();
            let (process, context) = (Process::named("fdm").unwrap(), Context { refine: 1_000_000, spacing_mm: 0.1 });
            let Ok(Outcome::Measured(found)) = LostFeature.run(&part, &process, &context) else { panic!() };
            let detail = found.findings.iter().find(|f| f.message.contains("raised detail"));
            detail.map(|f| f.fix.clone()).unwrap_or_default()
        };
        assert!(advice(&[]).contains("there is room"), "{}", advice(&[]));
        for (x, top) in [(5.2, 5.0), (6.1, 4.5), (8.3, 5.0), (12.6, 4.4), (14.4, 5.0)] {
            let block = cuboid([x, 10.47, 3.0], [x + 0.3, 12.0, top]);
            assert!(advice(&[block]).contains("it would meet its neighbour"), "{x} {top}");
        }
        // A wide bar at an angle of 45 degrees that runs up to the stroke, and one whose corner is 0.3 mm beside it.
        let bar = cuboid([0.0, -0.6, 3.0], [4.0, 0.6, 5.0]);
        let c = 0.5f64.sqrt();
        let aslant = |y: f64| bar.transformed([[c, -c, 0.0], [c, c, 0.0], [0.0, 0.0, 1.0]], [8.0, y, 0.0]);
        assert!(advice(&[aslant(10.25)]).contains("there is room"), "{}", advice(&[aslant(10.25)]));
        let apart = advice(&[aslant(10.55 + 0.6 * c)]);
        assert!(apart.contains("it would meet its neighbour"), "{apart}");
    }
}
