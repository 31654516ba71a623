//! AM602: what a compensation offset joins, closes, splits or loses.

use super::apart::{TRIED, can_part, words};
use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Bracket, Finding, Limits, State};
use super::place::reported;
use super::room::{Beside, NO_ROOM};
use super::sheet::{Kind, Reading, Sheets};
use crate::error::Result;
use crate::geometry::BodyPair;
use crate::medial::Side;
use crate::part::Part;
use crate::process::Process;
use crate::units::{report_digits, short};

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
          none is found, no offset up to the limit does either, and this is a proof. What is to grow has been tried on the surface: beside \
          it has to be left as much, for the opposite offset; bodies to be moved apart have been moved, and their distances measured \
          again. The offset itself changes the part by closing or \
          removing what lies within half the distance between the contacts of a ball on its middle surface.",
    limits: "Corners and wedges are rounded or blunted by any offset and are not listed. A gap that closes may join a body to itself or \
             enclose a void; which of the two is not told. Offsets are uniform; scaling is not.",
    source: "Critical points of the distance function lie where the contacts of a ball oppose each other: F. Chazal, D. Cohen-Steiner, A. \
             Lieutier, A sampling theory for compact sets in Euclidean space, 2009.",
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
            Sheets { part, process, context, code, side, kinds, rods, necks, beside }.measure().0
        };
        let inwards = search(Side::Material, vec![kind("lost", Reading::WithinBody)]);
        let outwards =
            search(Side::Void, vec![kind("closed", Reading::WithinBody), kind("merged", Reading::BetweenBodies)]);
        let reach = short(limits.fail.unwrap_or(0.0).max(limits.warn.unwrap_or(0.0)));
        let mut measured = Measured {
            rule: Some("offset"),
            spent: inwards.spent + outwards.spent,
            cover: format!(
                "Offsets up to {reach} mm both ways. Inwards: {} Outwards: {}",
                inwards.cover, outwards.cover
            ),
            worst: least(inwards.worst, outwards.worst).map(halved),
            ..Measured::default()
        };
        let found = inwards.findings.into_iter().chain(outwards.findings);
        measured.findings = found.map(|f| told(part, f, limits)).collect();
        Ok(Outcome::Measured(Box::new(measured)))
    }
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
fn told(part: &Part, mut f: Finding, limits: Limits) -> Finding {
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
    let offset = short((f.value * 1e4).round() / 1e4);
    let width = short((width * 1e4).round() / 1e4);
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
            format!("do not grow by more than {offset} mm, or {}", parted(part, &f, limits, &grow)),
        ),
        "closed" => (
            format!("growing by {offset} mm closes {} of {width} mm", many("a gap", "gaps")),
            format!("do not grow by more than {offset} mm{}", or_else(&grow)),
        ),
        _ => (
            format!("shrinking by {offset} mm loses {} of {width} mm", many("a wall", "walls")),
            format!("do not shrink by more than {offset} mm{}", or_else(&grow)),
        ),
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
mod tests {
    use super::*;
    use crate::geometry::{Primitive, TriangleMesh, extruded};
    use crate::morphology::offset;
    use crate::part::Up;
    use crate::units::Length;

    fn slab(x: f64, thick: f64) -> TriangleMesh {
        let shape = Primitive::Box { edges: [thick, 6.0, 6.0].map(Length::mm) };
        let upright = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        shape.mesh(Length::mm(0.1)).transformed(upright, [x, 0.0, 0.0])
    }

    fn found(mesh: TriangleMesh, limit: &str) -> Vec<Finding> {
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
