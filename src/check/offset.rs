//! AM602: what a compensation offset joins, closes, splits or loses.

use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Bracket, Finding, Limits, State};
use super::sheet::{Kind, Reading, Sheets};
use crate::error::Result;
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
          none is found, no offset up to the limit does either, and this is a proof. The offset itself changes the part by closing or \
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
            Sheets { part, process, context, code: META.code, side, kinds, rods: Vec::new(), necks: Vec::new() }
                .measure()
                .0
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
        measured.findings = inwards.findings.into_iter().chain(outwards.findings).map(|f| told(f, limits)).collect();
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
fn told(mut f: Finding, limits: Limits) -> Finding {
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
    let limit = short(limits.warn.or(limits.fail).unwrap_or(0.0));
    (f.message, f.fix) = match f.kind.as_str() {
        "merged" => (
            format!("growing by {offset} mm merges {}{pair}, {width} mm apart", many("bodies", "pairs of bodies")),
            format!(
                "move them {} mm apart to stand an offset of {limit} mm",
                short(2.0 * limits.warn.or(limits.fail).unwrap_or(0.0))
            ),
        ),
        "closed" => (
            format!("growing by {offset} mm closes {} of {width} mm", many("a gap", "gaps")),
            format!(
                "do not grow by more than {offset} mm, or widen to more than {} mm",
                short(2.0 * limits.warn.or(limits.fail).unwrap_or(0.0))
            ),
        ),
        _ => (
            format!("shrinking by {offset} mm loses {} of {width} mm", many("a wall", "walls")),
            format!(
                "do not shrink by more than {offset} mm, or thicken to more than {} mm",
                short(2.0 * limits.warn.or(limits.fail).unwrap_or(0.0))
            ),
        ),
    };
    f
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Primitive, TriangleMesh};
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
