//! AM602: what a compensation offset joins, closes, splits or loses.

use super::apart::{TRIED, can_part, words};
use super::closing::{closing, closing_finding, rods_within};
use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Bracket, Finding, Limits, State};
use super::for_good::Told;
use super::gone::Known;
use super::place::{group_equal, reported};
use super::room::{Beside, NO_ROOM};
use super::sheet::{Kind, Reading, Sheets};
use super::vanishing::{Vanished, vanishing, vanishing_finding};
use crate::error::Result;
use crate::geometry::BodyPair;
use crate::medial::Side;
use crate::medial::rod::Rods;
use crate::part::Part;
use crate::process::Process;
use crate::units::{report_digits, short};
use std::borrow::Cow;

/// Offsets that differ by less are equal, millimetres.
const EQUAL: f64 = 0.002;
/// Four decimals show no less, millimetres.
const SHOWN: f64 = 5e-5;

/// AM602 `offset`.
pub struct Offset;

static META: Meta = Meta {
    code: "AM602",
    name: "offset",
    title: "What a compensation offset joins, closes, splits or loses",
    what: "Gives the offset at which the part becomes another: outwards (a coat, machining stock, a grown print) where bodies merge \
           or a slot or hole closes, inwards (shrinkage, etching) where a wall splits or is lost.",
    why: "Parts are offset to compensate what the process adds or takes away. An offset that closes a slot or removes a wall cannot \
          be undone by the opposite offset afterwards.",
    how: "Growing by d closes a gap between opposing surfaces when 2 d is as wide as the gap, shrinking by d loses a wall when 2 d is as \
          thick as the wall. So gaps and walls up to twice the offset are searched on the mesh as for narrow-gap and thin-wall: where \
          none is found, no offset up to the limit closes or loses anything between two sides that oppose each other to within 30 degrees, and \
          this is a proof. An ellipse or a lens is thinner beside its middle than in it; an offset that narrows it is brought back by the opposite \
          one as long as a ball of its radius contains the middle of the thin place: between sides that lean, a wall or a gap goes at half its local \
          thickness, the largest such ball, where its sides are parallel, or at the largest ball in the section of a neck. The upper end of that \
          bracket bounds these balls; up to the lower end all of the place that is as deep as its thinnest has been proved to be kept, and balls to pass \
          between all of it. Where they were not found to pass, its thinnest place is told, with the balls as the upper end. \
          What lies between three or five sides is sought apart. Holes, pins and struts are looked for as for small-hole and \
          thin-pin: the offset at which one goes is at most the radius of the largest ball about a point of its narrowest section, and at least \
          the least distance of its line to the surface. Of each body and each closed void the largest ball is sought, by halving boxes: \
          none is lost or filled as a whole by less than its radius, and each is by the bound on all. That bound is the upper end of its bracket. \
          What is to grow has been tried on the surface: beside \
          it has to be left as much, for the opposite offset, with what is as thin there grown too; bodies to be moved apart have been moved, and their distances measured \
          again. The offset itself changes the part by closing or \
          removing what lies within half the distance between the contacts of a ball on its middle surface.",
    limits: "Corners and wedges are rounded or blunted by any offset and are not listed. That nothing between three or more sides goes is no proof, but \
             for whole bodies and closed voids where the text of the search says that all were decided: a hole or a pin is missed if its section is \
             more than 1.5 (material: 1.8) times as long as wide, if it tapers by more than 30 degrees, if it is blind and less deep than wide or not about as wide all along, or if no facet that was looked from has its \
             middle on it; a pocket, or a joint of several arms, is not looked for. \
             The parallel sides of a cross or an L go at half their width, though what lies between its arms is wider and stays. A gap that closes may join a body to itself or \
             enclose a void; which of the two is not told. Offsets are uniform; scaling is not.",
    source: "Critical points of the distance function lie where the contacts of a ball oppose each other: F. Chazal, D. Cohen-Steiner, A. \
             Lieutier, A sampling theory for compact sets in Euclidean space, 2009. Local thickness: T. Hildebrand, P. Rüegsegger, A new method for the \
             model-independent assessment of thickness in three-dimensional images, 1997.",
};

impl Check for Offset {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let Some(limits) = limits_of(process, "offset") else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let twice = Limits { fail: limits.fail.map(|l| 2.0 * l), warn: limits.warn.map(|l| 2.0 * l), ..limits };
        let kind = |name, reading| Kind { name, rule: "offset", limits: twice, reading };
        let search = |side, kinds| {
            let (code, rods, necks, beside) = (META.code, Vec::new(), Vec::new(), Beside::AsMuch);
            Sheets { part, process, context, code, side, kinds, rods, necks, beside, told: Told::AsGone }.measure().0
        };
        let inwards = search(Side::Material, vec![kind("lost", Reading::WithinBody)]);
        let outwards =
            search(Side::Void, vec![kind("closed", Reading::WithinBody), kind("merged", Reading::BetweenBodies)]);
        let reach = short(limits.fail.unwrap_or(0.0).max(limits.warn.unwrap_or(0.0)));
        let mut measured = Measured {
            rule: Some("offset"),
            cover: format!(
                "Offsets up to {reach} mm both ways. Inwards: {} Outwards: {}",
                inwards.cover, outwards.cover
            ),
            worst: least(inwards.worst, outwards.worst).map(halved),
            ..Measured::default()
        };
        let widest = limits.fail.unwrap_or(0.0).max(limits.warn.unwrap_or(0.0));
        let rods = [Side::Material, Side::Void].map(|side| rods_within(part, process, side, widest));
        let whole = vanishing(part, widest);
        let pieces = whole.as_ref().map_or(&[][..], |found| &found.pieces);
        for ((side, found), rods) in
            [(Side::Material, inwards.findings), (Side::Void, outwards.findings)].into_iter().zip(&rods)
        {
            let known = Known { part, side, rods, pieces };
            measured.findings.extend(found.into_iter().map(|f| told(part, f, limits, &known)));
        }
        let between_more = add_rods((part, context), &rods, (limits, widest), &mut measured);
        let whole = add_pieces((part, context), whole, limits, &mut measured);
        measured.cover.push_str(&format!(" {between_more} {whole}"));
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// Adds the rods without opposing sides that an offset closes or severs; what was looked at, in words.
fn add_rods(
    (part, context): (&Part, &Context),
    rods: &[Cow<Rods>; 2],
    (limits, widest): (Limits, f64),
    measured: &mut Measured,
) -> String {
    for (side, rods) in [Side::Material, Side::Void].into_iter().zip(rods) {
        let found = closing(part, side, rods, widest, &measured.findings);
        let findings = found.iter().map(|c| closing_finding((part, context), (META.code, side), c, limits));
        add(measured, findings.collect(), |f| closes(f, side));
    }
    let places: u64 = rods.iter().map(|r| r.places).sum();
    format!("Holes, pins and struts without opposing sides were looked for from {places} places.")
}

/// Adds the bodies that are lost and the closed voids that are filled as a whole; what was looked at, in words.
fn add_pieces(
    (part, context): (&Part, &Context),
    whole: Option<Vanished>,
    limits: Limits,
    measured: &mut Measured,
) -> String {
    let Some(Vanished { pieces, all, open }) = whole else {
        return "Bodies and closed voids were not measured as a whole: the surface is open, or meets itself.".into();
    };
    for side in [Side::Material, Side::Void] {
        let unknown = pieces.iter().filter(|p| p.side == side && !p.is_known(part, &measured.findings));
        let findings = unknown.map(|p| vanishing_finding((part, context), META.code, p, limits));
        let findings = findings.collect();
        add(measured, findings, |f| vanishes(f, side));
    }
    let pieces = if all == 1 { "1 body or closed void".into() } else { format!("{all} bodies and closed voids") };
    match open {
        0 => format!("In {pieces} the largest ball was sought."),
        n => format!("In {pieces} the largest ball was sought; for {n} of them the search ended undecided."),
    }
}

/// Adds findings of offsets, equal ones as one, told by what they stand for then.
fn add(measured: &mut Measured, mut findings: Vec<Finding>, tell: impl Fn(&mut Finding)) {
    findings.retain(|f| f.state > State::Pass);
    findings.sort_by(|a, b| a.value.total_cmp(&b.value).then_with(|| Finding::worst_first(a, b)));
    let mut grouped = group_equal(findings, EQUAL);
    grouped.iter_mut().for_each(tell);
    measured.findings.extend(grouped);
}

/// What is said of a hole that closes, or of a pin or a strut that goes.
fn closes(f: &mut Finding, side: Side) {
    let (offset, width) = (rounded(f.value), rounded(2.0 * f.value));
    let what = match (side, f.count) {
        (Side::Void, 1) => "closes a hole".to_string(),
        (Side::Void, n) => format!("closes {n} holes"),
        (Side::Material, 1) => "loses a pin or strut".to_string(),
        (Side::Material, n) => format!("loses {n} pins or struts"),
    };
    let verb = if side == Side::Void { "growing" } else { "shrinking" };
    let of = if f.count == 1 { "" } else { " of the first" };
    f.message =
        format!("{verb} by {offset} mm {what}: the largest ball in the narrowest section{of} is {width} mm wide");
    f.fix = at_most(side, f);
}

/// What is said of a body or a closed void that goes as a whole.
fn vanishes(f: &mut Finding, side: Side) {
    let (offset, width) = (rounded(f.value), rounded(2.0 * f.value));
    let (what, it) = match (side, f.count) {
        (Side::Void, 1) => ("growing", "fills a closed void".to_string()),
        (Side::Void, n) => ("growing", format!("fills {n} closed voids")),
        (Side::Material, 1) => ("shrinking", "loses a whole body".to_string()),
        (Side::Material, n) => ("shrinking", format!("loses {n} whole bodies")),
    };
    let first = if f.count == 1 { "it" } else { "the first" };
    f.message = format!("{what} by {offset} mm {it}: the largest ball in {first} is {width} mm wide");
    f.fix = at_most(side, f);
}

/// The hint not to offset by as much as a finding says.
fn at_most(side: Side, f: &Finding) -> String {
    let verb = if side == Side::Void { "grow" } else { "shrink" };
    if f.value < SHOWN {
        format!("do not {verb} it at all")
    } else {
        format!("do not {verb} by more than {} mm", rounded(f.value))
    }
}

/// Four decimals, for sentences; what they would show as nothing is below one of them.
fn rounded(mm: f64) -> String {
    if mm < SHOWN { "less than 0.0001".into() } else { short(mm) }
}

fn least(a: Option<Worst>, b: Option<Worst>) -> Option<Worst> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.bracket.value < a.bracket.value { b } else { a }),
        (a, b) => a.or(b),
    }
}

fn halved(w: Worst) -> Worst {
    let Bracket { value, low, high } = w.bracket;
    Worst { bracket: Bracket { value: 0.5 * value, low: 0.5 * low, high: 0.5 * high }, ..w }
}

/// A finding about a width, as one about the offset of half of it.
///
/// Its hint to grow stays: it has been tried with the width that an offset of the limit asks for, on both sides of the surface.
fn told(part: &Part, mut f: Finding, limits: Limits, known: &Known) -> Finding {
    let width = f.value;
    for x in [&mut f.value, &mut f.low, &mut f.high, &mut f.margin] {
        *x = report_digits(0.5 * *x);
    }
    for p in &mut f.places {
        for x in [&mut p.value, &mut p.low, &mut p.high] {
            *x = report_digits(0.5 * *x);
        }
    }
    (f.fail, f.warn) = (limits.fail, limits.warn);
    let (offset, width) = (rounded(f.value), rounded(width));
    let [less, more] = [Side::Material, Side::Void].map(|side| at_most(side, &f));
    let many = |one: &str, more: &str| if f.count == 1 { one.to_string() } else { format!("{} {more}", f.count) };
    let pair = match f.bodies.as_deref() {
        Some([a, b]) if f.kind == "merged" => format!(" {a} and {b}"),
        _ => String::new(),
    };
    if f.state == State::Undecided || !f.decided || f.kind.ends_with("-undecided") {
        return f;
    }
    let grow = std::mem::take(&mut f.fix);
    (f.message, f.fix) = match f.kind.as_str() {
        "merged" => (
            format!("growing by {offset} mm merges {}{pair}, {width} mm apart", many("bodies", "pairs of bodies")),
            format!("{}{}", more, or_else(&parted(part, &f, limits, &grow))),
        ),
        "closed" => {
            (format!("growing by {offset} mm {}", known.goes(&f, &width)), format!("{}{}", more, or_else(&grow)))
        }
        _ => (format!("shrinking by {offset} mm {}", known.goes(&f, &width)), format!("{}{}", less, or_else(&grow))),
    };
    f
}

/// A hint to grow as the second choice; that there is no room for it is no choice.
fn or_else(grow: &str) -> String {
    if grow.starts_with(NO_ROOM) { format!("; {grow}") } else { format!(", or {grow}") }
}

/// What is said of moving the bodies of a finding apart, tried with each pair.
fn parted(part: &Part, f: &Finding, limits: Limits, grow: &str) -> String {
    let to = 2.0 * limits.fail.unwrap_or(0.0).max(limits.warn.unwrap_or(0.0));
    let own = |p: &&BodyPair| f.places.iter().any(|s| s.at_mm == reported(part, p.middle()));
    let pairs = part.body_pairs().iter().filter(own).take(TRIED);
    let tries: Vec<Option<bool>> = pairs.map(|p| can_part(part, p, to)).collect();
    words(&tries, to, grow)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::{Primitive, TriangleMesh, cuboid, extruded};
    use crate::morphology::offset;
    use crate::part::Up;
    use crate::units::Length;

    fn slab(x: f64, thick: f64) -> TriangleMesh {
        let shape = Primitive::Box { edges: [thick, 6.0, 6.0].map(Length::mm) };
        let upright = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        shape.mesh(Length::mm(0.1)).transformed(upright, [x, 0.0, 0.0])
    }

    /// What is found of a part in fdm with a limit to offsets.
    pub(in crate::check) fn found(mesh: TriangleMesh, limit: &str) -> Vec<Finding> {
        let part = Part::new(mesh, Up::PlusZ, 1e-9, 2.0).unwrap();
        let mut process = Process::named("fdm").unwrap();
        process.override_limit(&format!("offset={limit}")).unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        match Offset.run(&part, &process, &context).unwrap() {
            Outcome::Measured(m) => m.findings,
            Outcome::NotApplicable(why) => panic!("{why}"),
        }
    }

    #[test]
    fn a_body_goes_with_its_corner_and_not_with_its_legs() {
        // The largest ball in an angle of legs of 1 mm lies in its corner, 0.5858 mm = √2/(1 + √2).
        let outline = [[0.0, 0.0], [5.0, 0.0], [5.0, 1.0], [1.0, 1.0], [1.0, 4.0], [0.0, 4.0]];
        let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        let said: Vec<(f64, String)> =
            found(extruded(&outline, &caps, 5.0), "0.6mm").into_iter().map(|f| (f.value, f.message)).collect();
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(said[0].0 == 0.5 && said[0].1.contains("wall of 1 mm"), "{said:?}");
        let corner = 2f64.sqrt() / (1.0 + 2f64.sqrt());
        assert!((said[1].0 - corner).abs() < 0.006 && said[1].1.contains("loses a whole body"), "{said:?}");
    }

    #[test]
    fn what_is_to_grow_leaves_as_much_beside_it() {
        // A wall of 0.3 mm beside a slot of 0.9 mm in a block: to stand 0.3 mm both ways, wall and slot have to be 0.6 mm wide.
        let comb = |slot: f64| {
            let (a, b, c) = (3.3, 3.3 + slot, 8.0);
            let outline = [
                [0.0, 0.0],
                [c, 0.0],
                [c, 9.0],
                [b, 9.0],
                [b, 2.0],
                [a, 2.0],
                [a, 9.0],
                [3.0, 9.0],
                [3.0, 2.0],
                [0.0, 2.0],
            ];
            let caps = [[0, 1, 4], [1, 2, 3], [1, 3, 4], [0, 4, 5], [0, 5, 8], [5, 6, 7], [5, 7, 8], [0, 8, 9]];
            extruded(&outline, &caps, 6.0)
        };
        let fix = |slot: f64| {
            let all = found(comb(slot), "0.3mm,0.3mm");
            all.into_iter().find(|f| f.kind == "lost").map(|f| f.fix).unwrap_or_default()
        };
        assert!(fix(0.9).contains(", or thicken by 0.3 mm to 0.6 mm: there is room"), "{}", fix(0.9));
        // The other side is open: there it grows whatever the slot is like.
        assert!(fix(0.62).contains("there is room"), "{}", fix(0.62));
        let between =
            slab(0.0, 2.0).joined(&slab(1.0 + 0.65 + 0.15, 0.3)).joined(&slab(1.0 + 0.65 + 0.3 + 0.65 + 1.0, 2.0));
        let all = found(between, "0.3mm,0.3mm");
        let lost = all.iter().find(|f| f.kind == "lost").unwrap();
        assert!(
            lost.fix.contains("there is no room to thicken it to 0.6 mm: less than 0.6 mm would be left"),
            "{}",
            lost.fix
        );
    }

    #[test]
    fn walls_of_a_comb_that_all_grow_leave_each_other_no_room() {
        let comb = (0..5).fold(slab(0.0, 2.0), |all, n| all.joined(&slab(1.95 + 1.1 * f64::from(n), 0.3)));
        let comb = comb.joined(&slab(1.0 + 5.0 * 1.1 + 0.8 + 1.0, 2.0));
        let found = found(comb, "0.3mm,0.3mm");
        let lost = found.iter().find(|f| f.kind == "lost").unwrap();
        // By half on both sides each slot of 0.8 mm would be 0.5 mm wide.
        assert!(lost.count == 5 && lost.fix.contains("there is no room to thicken it to 0.6 mm"), "{}", lost.fix);
        assert!(lost.fix.contains("once what is thin there is thickened too"), "{}", lost.fix);
    }

    /// An upright prism of so many sides, of an inscribed circle of so large a radius.
    fn prism(sides: usize, radius: f64, height: f64) -> TriangleMesh {
        let out = radius / (std::f64::consts::PI / sides as f64).cos();
        crate::geometry::revolved(&[[0.0, 0.0], [out, 0.0], [out, height], [0.0, height]], sides)
    }

    #[test]
    fn what_lies_between_three_or_five_sides_goes_at_the_radius_of_the_ball_in_it() {
        for sides in [3, 5] {
            for (side, kind) in [(Side::Void, "closed"), (Side::Material, "lost")] {
                let thing = prism(sides, 0.22, 6.0);
                let mesh = match side {
                    Side::Material => thing,
                    Side::Void => cuboid([-3.0, -3.0, -2.0], [3.0, 3.0, 8.0]).joined(&cavity(sides)),
                };
                let all = found(mesh.clone(), "0.3mm,0.3mm");
                let told: Vec<(&str, f64, u64)> = all.iter().map(|f| (f.kind.as_str(), f.value, f.count)).collect();
                assert!(told.len() == 1 && told[0].0 == kind && told[0].2 == 1, "{sides} {told:?}");
                assert!(
                    (told[0].1 - 0.22).abs() < 1e-4 && all[0].low <= 0.22 && all[0].low > 0.2 && all[0].high < 0.225,
                    "{:?}",
                    all[0]
                );
                assert!(found(mesh, "0.21mm,0.21mm").is_empty());
            }
        }
    }

    #[test]
    fn an_orifice_closes_at_the_radius_of_the_ball_in_it() {
        for sides in [3, 24] {
            let inner = 0.25 * (std::f64::consts::PI / f64::from(sides)).cos();
            let outline = [[0.75, 0.0], [3.0, 0.0], [3.0, 1.0], [0.75, 1.0], [0.25, 0.5]];
            let sunk = crate::geometry::revolved(&outline, sides as usize);
            let all = found(sunk.clone(), "0.3mm,0.3mm");
            let closed: Vec<&Finding> = all.iter().filter(|f| f.kind == "closed").collect();
            assert!(closed.len() == 1 && (closed[0].value - inner).abs() < 1e-3, "{sides}: {all:?}");
            // The report's six digits.
            assert!(closed[0].low <= inner + 1e-6 && inner <= closed[0].high + 1e-6, "{sides}: {closed:?}");
            let less = format!("{0}mm,{0}mm", 0.96 * inner);
            assert!(found(sunk, &less).is_empty(), "{sides}");
        }
    }

    /// A closed void of so many sides, 3 mm high.
    fn cavity(sides: usize) -> TriangleMesh {
        prism(sides, 0.22, 3.0)
            .transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.3, 0.2, 1.5])
            .flipped()
    }

    #[test]
    fn bodies_that_all_but_touch_are_told_without_lengths_of_nothing() {
        let all = found(slab(0.0, 2.0).joined(&slab(2.000_001, 2.0)), "0.3mm,0.3mm");
        let f = all.iter().find(|f| f.kind == "merged").unwrap();
        let said = "growing by less than 0.0001 mm merges bodies 1 and 2, less than 0.0001 mm apart";
        assert!(f.message == said && f.fix.starts_with("do not grow it at all, or move them to 0.6 mm apart"), "{f:?}");
    }

    #[test]
    fn a_small_ball_is_lost_and_a_small_void_filled_as_a_whole() {
        let ball = |x: f64| {
            let mesh = Primitive::Ball { radius: Length::mm(0.25) }.mesh(Length::mm(1e-3));
            mesh.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [x, 0.2, 0.1])
        };
        let mesh = cuboid([-3.0; 3], [3.0; 3]).joined(&ball(0.0).flipped()).joined(&ball(5.0));
        let all = found(mesh.clone(), "0.3mm,0.3mm");
        let told: Vec<&str> = all.iter().map(|f| f.message.as_str()).collect();
        assert!(told.len() == 2, "{told:?}");
        let says = |what: &str| told.iter().any(|m| m.contains(what));
        assert!(says("mm fills a closed void: the largest ball") && says("mm loses a whole body: "), "{told:?}");
        assert!(all.iter().all(|f| f.low <= 0.25 && f.value > 0.248 && f.high < 0.254), "{all:?}");
        assert!(found(mesh, "0.24mm,0.24mm").is_empty());
    }

    #[test]
    fn what_goes_is_called_what_it_is() {
        let upright = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let pin = crate::geometry::revolved(&[[0.0, 0.0], [0.25, 0.0], [0.25, 5.0], [0.0, 5.0]], 24);
        let plate = cuboid([-4.0, -4.0, -2.0], [4.0, 4.0, 0.5]);
        let on_plate = |m: TriangleMesh| crate::geometry::union::united(&plate.clone().joined(&m), 1e-6).unwrap();
        let bored = crate::geometry::revolved(&[[0.25, 0.0], [4.0, 0.0], [4.0, 6.0], [0.25, 6.0]], 24);
        let wall = cuboid([-3.0, -0.25, 0.0], [3.0, 0.25, 5.0]);
        let ball = Primitive::Ball { radius: Length::mm(0.25) }.mesh(Length::mm(1e-3));
        let block = || cuboid([-3.0; 3], [3.0; 3]);
        for (mesh, said) in [
            (on_plate(pin), "loses a pin or strut of 0."),
            (bored, "closes a hole of 0."),
            (on_plate(wall), "loses a wall of 0.5 mm"),
            (block().joined(&ball.transformed(upright, [5.0, 0.0, 0.0])), "loses a whole body"),
            (block().joined(&ball.transformed(upright, [0.3, 0.2, 0.1]).flipped()), "fills a closed void"),
            (block().joined(&cuboid([5.0; 3], [5.5; 3])), "loses a whole body of 0.5 mm"),
        ] {
            let all = found(mesh, "0.3mm,0.3mm");
            let told: Vec<&str> = all.iter().map(|f| f.message.as_str()).collect();
            assert!(told.len() == 1 && told[0].contains(said), "{said}: {told:?}");
        }
    }

    #[test]
    fn the_offset_at_which_something_changes_is_half_a_gap_or_a_wall() {
        // Two bodies 0.5 mm apart, one of them 0.3 mm thick.
        let mesh = slab(0.0, 3.0).joined(&slab(1.5 + 0.5 + 0.15, 0.3));
        let all = found(mesh.clone(), "0.4mm");
        let told: Vec<(&str, f64)> = all.iter().map(|f| (f.kind.as_str(), f.value)).collect();
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told.iter().any(|t| t.0 == "merged" && (t.1 - 0.25).abs() < 1e-9), "{told:?}");
        assert!(told.iter().any(|t| t.0 == "lost" && (t.1 - 0.15).abs() < 1e-9), "{told:?}");
        assert!(found(mesh.clone(), "0.14mm,0.14mm").is_empty());
        // The offset says so, too: just beyond these numbers the pieces are others.
        let pieces = |by: f64| {
            let shaped = offset(&mesh, Length::mm(by), Length::mm(0.05)).unwrap();
            crate::geometry::Health::of(&shaped.mesh).bodies.len()
        };
        assert_eq!([0.19, 0.31, -0.09, -0.21].map(pieces), [2, 1, 2, 1]);
    }
}
