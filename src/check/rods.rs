//! Findings from rods of material or void: what AM102 and AM104 share.

use super::contract::{Context, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, Limits, State, Witness};
use super::place::{locate, reported};
use super::room::{Fit, Growth, NO_ROOM};
use crate::geometry::vector::{Vec3, along, dot, sub, unit};
use crate::medial::Side;
use crate::medial::rod::{End, Rod, Rods, Wanted};
use crate::medial::section::eight_across;
use crate::part::Part;
use crate::process::Process;
use crate::units::{enough, report_digits, short};
use std::borrow::Cow;

/// A pin's section is at most this elongated, greatest over least width: 1 × 1.5 mm is still a pin.
const PIN: f64 = 1.81;
/// A hole's section is at most this many times as long as wide; what is longer is a slot.
const HOLE: f64 = 1.5;
/// A passage shorter than this share of its width is an edge of something else, unless it widens beyond either end.
const SHORTEST: f64 = 0.1;

/// The rule that limits the diameter of rods on a side.
pub fn rule_of(side: Side) -> &'static str {
    match side {
        Side::Material => "thin-pin",
        Side::Void => "small-hole",
    }
}

/// Pins as wide as this are judged by their slenderness, mm, whatever the limit of their diameter.
const SLENDER: f64 = 3.75;

/// What a process wants to know of the rods on a side: a quarter beyond its widest limit, and of pins up to [`SLENDER`] where their
/// slenderness is limited; `None` without a limit.
fn wanted(process: &Process, side: Side) -> Option<Wanted> {
    let limits = limits_of(process, rule_of(side))?;
    let widest = limits.fail.into_iter().chain(limits.warn).fold(0.0, f64::max);
    let is_slender = side == Side::Material && limits_of(process, "thin-pin.slenderness").is_some();
    let least = if is_slender { SLENDER } else { 0.0 };
    (widest > 0.0).then_some(Wanted { side, within: least.max(1.25 * widest), elongation: elongation(side) })
}

fn elongation(side: Side) -> f64 {
    if side == Side::Material { PIN } else { HOLE }
}

/// What finds all rods up to an equal-area diameter: the search that the rule for diameters shares, if that goes as far.
pub fn up_to(process: &Process, side: Side, width: f64) -> Wanted {
    let shared = wanted(process, side).filter(|w| w.within >= width);
    shared.unwrap_or(Wanted { side, within: width, elongation: elongation(side) })
}

/// All rods on a side that the process has a limit for.
pub fn search<'a>(part: &'a Part, process: &Process, side: Side) -> Option<Cow<'a, Rods>> {
    Some(part.rods(wanted(process, side)?))
}

/// From where rods were looked for, and how many of a kind were found.
pub fn looked(found: &Rods, count: usize, kind: &str) -> String {
    format!(
        "Looked across from {} places, none of the middles of facets, or of places beside the corners of long ones, further than {} mm from one that looks the same way: {count} {kind}.",
        found.places,
        plain(found.spacing)
    )
}

/// Whether a rod is judged by its diameter.
///
/// A pin has a free end, with a head or without, or is a ring, and is at least as high as wide; a strut held at both ends is a wall, unless no
/// two of its sides face each other, as in one of three or five sides. A blind hole is at least as deep
/// as wide; a passage may be short, and without length where it is an orifice. Over half of that the sections are alike, so that a ball is no pin. What runs out to a point is neither: [`as_judged`].
pub fn is_judged(side: Side, rod: &Rod) -> bool {
    let held = side == Side::Material && rod.ends == [End::Open; 2] && rod.narrowest.is_faced;
    !held && is_passage(side, rod)
}

/// Whether a rod is long enough to be a hole, a pin or a strut, or is an orifice, and does not run out to a point.
pub fn is_passage(side: Side, rod: &Rod) -> bool {
    let least = if side == Side::Void && !rod.ends.contains(&End::Closed) { SHORTEST } else { 1.0 };
    let width = rod.diameter();
    let is_long = rod.length >= (least - 1e-3) * width && rod.run >= 0.5 * least * width;
    !rod.ends.contains(&End::Point) && (is_long || rod.is_orifice)
}

/// A rod as its rule judges it: at its narrowest section, and where it runs out to a point at its base, if it is at least as long as wide there.
pub fn as_judged(side: Side, rod: &Rod) -> Option<Rod> {
    let at_base = || {
        let base = rod.base.clone().filter(|b| rod.length >= b.diameter())?;
        Some(Rod { narrowest: base, ..rod.clone() })
    };
    if is_judged(side, rod) { Some(rod.clone()) } else { at_base() }
}

/// The rods that the rule for their diameter judges, and no other rule does.
pub fn judged(part: &Part, process: &Process, side: Side) -> Vec<Rod> {
    let found = search(part, process, side);
    found.map_or(Vec::new(), |r| r.rods.iter().filter_map(|r| as_judged(side, r)).collect())
}

/// Void that is no slot, as it is about as wide in every direction across an axis: holes, and what is blind however deep.
pub fn round_void(part: &Part, process: &Process) -> Vec<Rod> {
    let is_blind = |r: &Rod| r.ends.iter().any(|e| matches!(e, End::Closed | End::Point));
    let found = search(part, process, Side::Void);
    found.map_or(Vec::new(), |r| r.rods.iter().filter(|r| is_blind(r) || is_judged(Side::Void, r)).cloned().collect())
}

/// Rods of material between two wider pieces, however short: they carry whatever hangs on them.
pub fn necks(part: &Part, process: &Process) -> Vec<Rod> {
    let found = search(part, process, Side::Material);
    let between = |r: &&Rod| r.ends == [End::Open; 2];
    found.map_or(Vec::new(), |r| r.rods.iter().filter(between).cloned().collect())
}

/// Equal-area diameter between the inscribed and the circumscribed one.
pub fn bracket(rod: &Rod) -> Bracket {
    Bracket::new(rod.diameter(), rod.narrowest.inscribed, rod.narrowest.circumscribed)
}

/// The rod of least diameter, for the report's worst value.
pub fn worst<'a>(rods: impl IntoIterator<Item = &'a Rod>) -> Option<Worst> {
    let least = rods.into_iter().min_by(|a, b| a.diameter().total_cmp(&b.diameter()))?;
    Some(Worst { bracket: bracket(least), unit: "mm", at: Some(least.narrowest.centre) })
}

/// A finding on a rod's diameter: judged by its equal-area diameter, where it may stand for a circle that keeps the limit, it does.
pub fn diameter_finding(
    (part, context): (&Part, &Context),
    (code, kind): (&str, &str),
    rod: &Rod,
    limits: Limits,
) -> Finding {
    let tie = rod.narrowest.facet_loss() + part.tie();
    let mut f = Finding::judged(code, kind, Bracket::exact(rod.diameter()), Basis::Exact, limits, "mm", tie);
    let b = bracket(rod).rounded();
    (f.low, f.high) = (b.low, b.high);
    placed(&mut f, part, context, rod);
    f
}

/// Puts a finding on a rod, with the points that bear it out.
pub fn placed(f: &mut Finding, part: &Part, context: &Context, rod: &Rod) {
    locate(f, part, context, rod.narrowest.centre, rod.sides());
    let ends = [rod.line.first(), rod.line.last()].into_iter().flatten().map(|e| e.0);
    let points = [rod.narrowest.centre].into_iter().chain(ends).map(|p| reported(part, p));
    f.witness = Some(Witness { kind: Witness::SECTION.into(), points_mm: points.collect() });
    f.area_mm2 = Some(report_digits(rod.narrowest.area));
    if part.health().bodies.len() > 1 {
        let body = part.health().facet_body.get(rod.narrowest.facet as usize).copied().unwrap_or(u32::MAX);
        f.bodies = Some(vec![u64::from(body) + 1]);
    }
}

/// What to change to keep one limit.
fn to_keep(f: &Finding, verb: &str, limit: f64) -> String {
    format!("{verb} by {} mm to {} mm", enough(limit - f.value), short(limit))
}

/// What to change, from the limits that are broken.
fn to_limit(f: &Finding, verb: &str) -> String {
    let to = |limit: f64| to_keep(f, verb, limit);
    match (f.state, f.fail.filter(|l| f.value < *l), f.warn.filter(|l| f.value < *l)) {
        (State::Fail, Some(fail), Some(warn)) => format!("{}; {} mm clears the warning too", to(fail), short(warn)),
        (_, Some(limit), None) | (_, None, Some(limit)) | (_, Some(_), Some(limit)) => to(limit),
        (_, None, None) => format!("{} mm is as much as the limit asks", short(f.value)),
    }
}

/// What to change, tried at each place on the surface: whether what lies beside a rod keeps its own limit (the gap beside a pin, the wall
/// around a hole) after it has grown to the limit.
pub fn remedy(part: &Part, process: &Process, side: Side, rods: &[&Rod], f: &Finding) -> String {
    let verb = if side == Side::Material { "thicken" } else { "widen" };
    let room = Growth::new(part, process, side);
    let broken = || f.fail.into_iter().chain(f.warn).filter(|l| f.value < *l);
    let own = |r: &&&Rod| f.places.iter().any(|p| p.at_mm == reported(part, r.narrowest.centre));
    // All that is thinner grows, by half of what it lacks on each side.
    let tried = |target: f64| {
        let growth = |r: &Rod| 0.5 * (target - r.diameter()).max(0.0);
        let others: Vec<(&Rod, f64)> = rods.iter().map(|r| (*r, growth(r))).filter(|(_, by)| *by > 0.0).collect();
        let fits = rods.iter().filter(own).map(|r| fit(part, r, (0.5 * (target - f.value), room.beside), &others));
        Fit::counts(fits)
    };
    let (most, least) = (broken().fold(f.value, f64::max), broken().fold(f64::INFINITY, f64::min));
    let fits = tried(most);
    let is_cramped = |[_, alone, cramped]: [usize; 3]| alone + cramped > 0;
    if f.state < State::Fail || !is_cramped(fits) || least >= most {
        return room.tried(to_limit(f, verb), verb, most, fits);
    }
    // Where there is no room for what clears the warning, there may be for what no longer fails.
    let fits = tried(least);
    let hint = room.tried(to_keep(f, verb, least), verb, least, fits);
    if is_cramped(fits) { hint } else { format!("{hint}; {NO_ROOM} for {} mm", short(most)) }
}

/// Surface whose normal is nearer than 45° to a rod's axis is what the rod stands on or leaves through, and not beside it.
const ACROSS: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Surface that leans by more than this towards a rod's axis, as a cosine (75°), crosses it.
const SLANTS: f64 = 0.26;
/// A rod's last section lies no farther from the face that it leaves through than so many of its diameters: half of the tangent of 72°.
const PAST_END: f64 = 1.5;
/// What lies no farther from a rod's line than so many of its radii lies on its side.
const ON_SIDE: f64 = 1.2;

/// Whether a rod can grow on all sides and leave beside it what has to be left, with other rods grown as well.
pub fn fit(part: &Part, rod: &Rod, (by, beside): (f64, f64), others: &[(&Rod, f64)]) -> Fit {
    let stride = rod.line.len().div_ceil(12).max(1);
    let (within, most) = (by + beside, others.iter().map(|o| o.1).fold(0.0, f64::max));
    let tries = rod.line.windows(2).step_by(stride).flat_map(|w| {
        let middle = [0, 1, 2].map(|a| 0.5 * (w[0].0[a] + w[1].0[a]));
        let axis = unit(sub(w[1].0, w[0].0));
        eight_across(axis).into_iter().map(move |d| {
            let side = part.distance().first_hit(middle, d, 0.0, 2.0 * w[0].1.max(w[1].1));
            let beyond = side.and_then(|(at, _)| {
                let (far, facet) = part.distance().first_hit(middle, d, at + part.step(), at + within + most)?;
                let (normal, met) = (part.distance().normal(facet), along(middle, d, far));
                let is_beside = dot(normal, axis).abs() < ACROSS && !ends_at(rod, normal, met);
                is_beside.then_some((far - at, met))
            });
            match beyond {
                Some((gap, _)) if gap < within => Fit::Cramped,
                Some((gap, met)) if gap < within + growth_at(others, met) => Fit::Alone,
                _ => Fit::Roomy,
            }
        })
    });
    tries.min().unwrap_or(Fit::Roomy)
}

/// Whether a slanting face is one that a rod leaves through: its plane crosses the rod's line near an end, where sections still fit, or beyond.
fn ends_at(rod: &Rod, normal: Vec3, on_face: Vec3) -> bool {
    let (mut from_start, mut from_end) = (rod.line.windows(2), rod.line.windows(2).rev());
    let ends = [from_start.next().map(|w| [w[1], w[0]]), from_end.next().map(|w| [w[0], w[1]])];
    ends.into_iter().flatten().any(|[inner, end]| {
        let lean = dot(normal, unit(sub(end.0, inner.0)));
        lean.abs() >= SLANTS && (dot(normal, sub(on_face, end.0)) / lean).abs() <= PAST_END * end.1
    })
}

/// By how much the rod on whose side a point lies grows there.
fn growth_at(others: &[(&Rod, f64)], p: Vec3) -> f64 {
    let on = |rod: &Rod| {
        let (lo, hi) = rod.extent;
        let slack = (ON_SIDE - 1.0) * rod.narrowest.circumscribed;
        (0..3).all(|a| lo[a] - slack <= p[a] && p[a] <= hi[a] + slack) && rod.nears(p, ON_SIDE)
    };
    others.iter().filter(|(rod, _)| on(rod)).map(|o| o.1).fold(0.0, f64::max)
}

/// Millimetres in a sentence.
pub fn plain(mm: f64) -> String {
    short((mm * 1e3).round() / 1e3)
}

#[cfg(test)]
mod tests {
    use super::super::contract::{Check, Outcome};
    use super::super::thin_pin::ThinPin;
    use super::*;
    use crate::geometry::{TriangleMesh, cuboid, revolved};
    use crate::medial::rod::tests::{plate_with_hole, wire};
    use crate::part::Up;
    use std::f64::consts::PI;

    /// The findings of AM102 on what is turned on a lathe.
    fn pins(profile: &[[f64; 2]], process: &str) -> Vec<Finding> {
        let part = Part::new(revolved(profile, 48), Up::PlusZ, 1e-6, 1.0).unwrap();
        let context = Context { refine: 0, spacing_mm: 0.1 };
        let found = ThinPin.run(&part, &Process::named(process).unwrap(), &context);
        let Ok(Outcome::Measured(found)) = found else { panic!("not measured") };
        found.findings
    }

    #[test]
    fn a_hole_has_room_beside_it_however_it_slants_through_its_plate() {
        let process = Process::named("fdm").unwrap();
        for degrees in [0.0f64, 30.0, 45.0, 50.0, 60.0] {
            let fitting = |margin: f64| {
                // Longer along x, and then slanted by that much: its section across its axis stays round.
                let (tan, cos) = (degrees.to_radians().tan(), degrees.to_radians().cos());
                let mesh = plate_with_hole([20.0 * cos, 20.0, 10.0], 0.8, margin);
                let mesh = mesh.transformed([[1.0 / cos, 0.0, tan], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);
                let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
                let found = search(&part, &process, Side::Void).unwrap();
                let [hole] = &found.rods[..] else { panic!("{degrees}: {:?}", found.rods.len()) };
                assert!((hole.diameter() - 1.6).abs() < 0.01, "{degrees}: {}", hole.diameter());
                fit(&part, hole, (0.2, 0.8), &[])
            };
            assert_eq!((fitting(4.0), fitting(0.5)), (Fit::Roomy, Fit::Cramped), "{degrees}");
        }
    }

    #[test]
    fn the_box_of_a_hole_ends_where_it_does_and_the_hole_fills_it() {
        // A plate of 3 mm beside what is taller.
        let mesh = plate_with_hole([20.0, 20.0, 3.0], 0.8, 4.0).joined(&cuboid([30.0, 0.0, 0.0], [40.0, 20.0, 15.0]));
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
        let process = Process::named("fdm").unwrap();
        let found = search(&part, &process, Side::Void).unwrap();
        let limits = Limits { fail: Some(2.0), warn: None, sense: super::super::finding::Sense::Min };
        let context = Context { refine: 0, spacing_mm: 0.2 };
        let f = diameter_finding((&part, &context), ("AM104", "hole"), &found.rods[0], limits);
        let off =
            (0..3).map(|a| (f.box_mm[0][a] - [4.0, 4.0, 0.0][a]).abs() + (f.box_mm[1][a] - [5.6, 5.6, 3.0][a]).abs());
        assert!(off.sum::<f64>() < 0.02, "{:?}", f.box_mm);
        assert!((f.fills(f.box_mm).unwrap() - 0.25 * PI).abs() < 0.01);
    }

    #[test]
    fn a_hole_is_half_as_long_again_as_wide_at_most_whatever_its_corners() {
        // Through a plate of 10 × 10 × 3 mm: so wide, and so many times as long.
        let plate = |wide: f64, times: f64| {
            let ring = |x: f64, y: f64, z: f64| [[-x, -y, z], [x, -y, z], [x, y, z], [-x, y, z]];
            let [outer, inner] =
                [(5.0, 5.0), (0.5 * times * wide, 0.5 * wide)].map(|(x, y)| [0.0, 3.0].map(|z| ring(x, y, z)));
            let mut facets = Vec::new();
            for k in 0..4 {
                let n = (k + 1) % 4;
                let mut quad = |a, b, c, d| facets.extend([[a, b, c], [a, c, d]]);
                quad(outer[0][k], outer[0][n], outer[1][n], outer[1][k]);
                quad(inner[0][k], inner[1][k], inner[1][n], inner[0][n]);
                quad(outer[1][k], outer[1][n], inner[1][n], inner[1][k]);
                quad(outer[0][k], inner[0][k], inner[0][n], outer[0][n]);
            }
            TriangleMesh::weld(facets)
        };
        let process = Process::named("fdm").unwrap();
        for (times, is_hole) in [(1.0, true), (1.15, true), (1.3, true), (1.49, true), (1.52, false), (2.0, false)] {
            let part = Part::new(plate(1.2, times), Up::PlusZ, 1e-6, 1.0).unwrap();
            let found = search(&part, &process, Side::Void).unwrap();
            let wide = found.rods.first().map(|r| r.narrowest.diameter());
            assert_eq!(wide.is_some(), is_hole, "{times}: {wide:?}");
            let alike = 1.2 * (4.0 * times / PI).sqrt();
            assert!(wide.is_none_or(|w| (w - alike).abs() < 1e-6), "{times}: {wide:?} for {alike}");
        }
    }

    #[test]
    fn a_spring_is_no_slender_pin() {
        // Three turns of 4 mm in radius, 9 mm high in all, and one turn alone.
        let spring = |turns: usize| {
            let coil = |k: usize| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / 96.0).sin_cos();
                ([4.0 * c, 4.0 * s, 3.0 * k as f64 / 96.0], unit([-8.0 * PI * s, 8.0 * PI * c, 3.0]))
            };
            let part =
                Part::new(wire(&(0..=96 * turns).map(coil).collect::<Vec<_>>(), 0.5, 24, false), Up::PlusZ, 1e-6, 1.0);
            let context = Context { refine: 0, spacing_mm: 0.1 };
            let found = ThinPin.run(&part.unwrap(), &Process::named("fdm").unwrap(), &context);
            let Ok(Outcome::Measured(found)) = found else { panic!("not measured") };
            found.findings.iter().filter(|f| f.kind == "slender-pin").count()
        };
        assert_eq!([spring(3), spring(1)], [0, 1]);
    }

    #[test]
    fn slender_pins_wider_than_the_limit_of_their_diameter_are_found() {
        // A pin in the middle of a plate of 2 mm; in sls no wider than a tenth of their length.
        let pin = |r: f64, tall: f64| {
            let z = 2.0 + tall;
            pins(&[[0.0, 0.0], [6.0, 0.0], [6.0, 2.0], [r, 2.0], [r, z], [0.0, z]], "sls")
        };
        for r in [0.45, 0.52, 0.8, 1.5] {
            assert_eq!(pin(r, 19.0 * r), []);
            let found = pin(r, 21.0 * r);
            assert!(found.len() == 1 && found[0].kind == "slender-pin", "{r}: {found:?}");
            assert!(found[0].fix.contains("there is room for it"), "{}", found[0].fix);
        }
        // In a well that leaves 0.35 mm beside it.
        let well =
            [[0.0, 0.0], [4.0, 0.0], [4.0, 14.0], [0.95, 14.0], [0.95, 2.0], [0.6, 2.0], [0.6, 15.0], [0.0, 15.0]];
        let found = pins(&well, "sls");
        assert!(found.len() == 1 && found[0].fix.starts_with(NO_ROOM), "{found:?}");
    }

    #[test]
    fn pins_in_a_row_that_all_grow_leave_each_other_no_room() {
        let row = |apart: f64| {
            let pin = revolved(&[[0.0, 0.0], [0.15, 0.0], [0.15, 3.0], [0.0, 3.0]], 24);
            let at = |n: i32| {
                pin.transformed(
                    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                    [f64::from(n) * (0.3 + apart), 0.0, 0.0],
                )
            };
            (1..6)
                .fold(at(0), |all: TriangleMesh, n| all.joined(&at(n)))
                .joined(&cuboid([0.0, 3.0, 0.0], [5.0, 6.0, 2.0]))
        };
        let fix_for = |apart: f64, limits: &str| {
            let part = Part::new(row(apart), Up::PlusZ, 1e-6, 1.0).unwrap();
            let mut process = Process::named("sla").unwrap();
            process.override_limit(&format!("thin-pin={limits}")).unwrap();
            let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
            let Outcome::Measured(m) = ThinPin.run(&part, &process, &context).unwrap() else { panic!() };
            m.findings.iter().find(|f| f.kind == "pin").unwrap().fix.clone()
        };
        let fix = |apart: f64| fix_for(apart, "0.5mm");
        // Each is to grow by 0.1 mm all round, and sla asks for gaps of 0.2 mm.
        assert!(fix(0.5).contains("there is room for it"), "{}", fix(0.5));
        // By 0.45 mm for the warning.
        let fails = fix_for(0.5, "0.5mm,1.2mm");
        assert!(fails.contains("to 0.5 mm: there is room") && fails.contains("no room for 1.2 mm"), "{fails}");
        assert!(fix(0.35).contains("no room") && fix(0.35).contains("once what is thin there"), "{}", fix(0.35));
    }
}
