//! AM203: ceilings between anchors.

use super::budget::Budget;
use super::chamfer::Chamfer;
use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, State, Witness};
use super::hanging::{BRIDGE, CROWN, LEDGE, PAIRS, Supports, ceilings_of, looked_at_again, told_with};
use super::place::{group_equal, locate, reported};
use super::rib::Ribbing;
use super::roof::Roof;
use crate::access::self_holding;
use crate::error::Result;
use crate::geometry::DisjointSets;
use crate::geometry::vector::{Vec3, along, scale};
use crate::layer::{Ceiling, Reach};
use crate::part::Part;
use crate::process::Process;
use crate::units::{hundredths, report_digits, short};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// AM203 `bridge`.
pub struct Bridge;

/// Findings whose remedy is tried, worst first.
const TRIED: usize = 16;

static META: Meta = Meta {
    code: "AM203",
    name: "bridge",
    title: "Ceilings between anchors: free spans, ledges, crowns of lying holes",
    what: "Measures every piece of downward surface that needs an anchor: how far a flat ceiling spans freely from anchor to opposite \
           anchor (bridge), how far it reaches out beyond its anchors and bridges (ledge, or cantilever), and the diameter of a round passage \
           across the build direction whose crown hangs over (horizontal-hole).",
    why: "A strand drawn from anchor to anchor holds over a short way and sags over a long one; a ledge holds while it is no wider than \
          what the layer below grips; the crown of a small hole closes by itself. What is within these limits is no overhang and needs \
          no support: `overhang` and `support` leave it out.",
    how: "Facets below the overhang angle that share edges make a ceiling. An edge is an anchor where the surface folds down towards the void and is a layer lower within the length of a ledge, \
          where it lies on the plate, or on another body. What has material no more than a layer below it rests there, and spans nothing. The bridge at a place is the shortest straight line through it, inside the \
          ceiling, with an anchor at both ends, among lines across the longest anchors, along the longest free edges, every 15 degrees from the first of them, and from the place to its nearest anchor and to the nearest on its other side, and where it would be told, every 1.5 degrees; the ceiling's span is the greatest \
          over its places. Places with no such line reach out: the shortest way inside the ceiling counts, to an anchor or to a place with such a line, \
          for a strand between two anchors carries what is laid beside it; round corners where a slit lies between. A place beyond both limits is \
          what exceeds its limit by less: a ledge along a wall, told with its reach from there and not with the length of strands along it, or a \
          bridge; a ceiling is told as what its place farthest from all anchors is, and as the other one too where that exceeds its limit by more. Squares of places are \
          bounded and split until the bracket is within a percent or the budget ends. Places within the ledge limit of an anchor are left \
          out, and of a bridge too where they have none. Ribs that are advised have been put under the ceiling and it has been measured again, as anchors; a chamfer has been laid \
          along all anchors of a ledge, against its wall, with the gap that the process asks for below it; roofs for a hole have a wall \
          above them. The crown's diameter follows from its chord and the slopes at its two ends, midway between the facets that meet there, all \
          across the axis, the direction that its facets contain: it is the cylinder's, however the hole lies or climbs, and never more than that of the circle with \
          its chord and its rise. A crown that is all within the ledge limit of its sides is measured too, where the passage is straight and climbs by 19° at most.",
    limits: "Strands are straight: a ceiling that bends in plan is measured as what no straight line crosses. Ceilings above one another that are \
             one piece, as in a screw, are measured as if in one plane. How cooling and speed change what holds is not known here. \
             Sloped surface that reaches out, and the crown of a passage that bends, narrows or crosses another as wide, are judged by `overhang` alone, and what \
             has no anchor at all is an `island`.",
    source: "The limits' sources stand in the profile; `amcheck processes` lists them.",
};

impl Check for Bridge {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        if process.powder_supports && limits_of(process, BRIDGE).is_none() {
            return Ok(Outcome::NotApplicable("loose powder holds the part up in this process".into()));
        }
        if limits_of(process, BRIDGE).is_none() {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        }
        let all = ceilings_of(part, process, context.refine);
        let (rule, worst) = nearest_to_its_limit(process, &all);
        let mut measured = Measured {
            cover: format!("All {} pieces of downward surface below the overhang angle were measured.", all.len()),
            rule: Some(rule),
            worst: Some(worst),
            ..Measured::default()
        };
        let mut budget = Budget::of(context.refine);
        all.iter().filter_map(told_with).for_each(|samples| budget.note(1, samples));
        let mut told = |c: &Ceiling| {
            let first = judged(part, process, context, c);
            match first.iter().any(|f| !f.decided) {
                true => told_apart(part, process, context, c, &mut budget).unwrap_or(first),
                false => first,
            }
        };
        let mut found: Vec<(Finding, &Ceiling)> =
            all.iter().flat_map(|c| told(c).into_iter().map(move |f| (f, c))).collect();
        measured.budget = (budget.looks > 0).then_some(budget);
        found.sort_by(|a, b| Finding::worst_first(&a.0, &b.0));
        // What breaks a rule of its own, and worse than any bridge, is the worst there is.
        let of_rule = found.first().and_then(|(f, c)| match f.kind.as_str() {
            "ledge" => Some((f, LEDGE, c.cantilever?)),
            "horizontal-hole" => Some((f, CROWN, c.bridge?)),
            _ => None,
        });
        if let Some((f, rule, reach)) = of_rule {
            let bracket = Bracket { value: f.value, low: f.low, high: f.high };
            measured.worst = Some(Worst { bracket, unit: "mm", at: Some(reach.at) });
            measured.rule = Some(rule);
        }
        let remedies: Vec<Tried> = found.par_iter().take(TRIED).map(|(f, c)| Tried::of(part, process, f, c)).collect();
        let below: Vec<_> = found.iter().map(|(f, c)| (f.at_mm, Supports::below(part, process, &c.facets))).collect();
        measured.findings = group_equal(found.into_iter().map(|(f, _)| f).collect(), 0.05);
        for f in &mut measured.findings {
            f.fix = advised(part, f, &remedies, &below);
            if f.count > 1 {
                f.message = format!("{} places: {}", f.count, f.message);
            }
        }
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// The bridge of a flat ceiling or the lying hole that has most of its limit, with its rule.
fn nearest_to_its_limit(process: &Process, all: &[Ceiling]) -> (&'static str, Worst) {
    let of = |rule, judged: f64, bracket, at| {
        let limit = limits_of(process, rule).and_then(|l| l.warn.or(l.fail));
        limit.map(|limit| (judged / limit, rule, Worst { bracket, unit: "mm", at: Some(at) }))
    };
    let flat = |c: &Ceiling| c.bridge.filter(|_| c.flat_share >= 0.5);
    let bridge = |c: &Ceiling| flat(c).and_then(|b| of(BRIDGE, b.low_mm, bracket(&b), b.at));
    let hole = |c: &Ceiling| {
        let (crown, b) = (c.crown.filter(|c| c.is_straight)?, c.bridge?);
        let diameter = Bracket::new(crown.diameter_mm, crown.low_mm, crown.high_mm);
        of(CROWN, crown.diameter_mm - crown.sagitta_mm, diameter, b.at)
    };
    let most = all.iter().flat_map(|c| [bridge(c), hole(c)]).flatten().max_by(|a, b| a.0.total_cmp(&b.0));
    let none = (BRIDGE, Worst { bracket: Bracket::exact(0.0), unit: "mm", at: None });
    most.map_or(none, |(_, rule, worst)| (rule, worst))
}

fn bracket(r: &Reach) -> Bracket {
    Bracket::new(r.low_mm, r.low_mm, r.high_mm)
}

/// What a ceiling breaks, once a finer look has told its spans from the limits within their brackets, as far as the budget goes; `None` where
/// these are those up to which it holds itself, for which all ceilings have been looked at.
fn told_apart(
    part: &Part,
    process: &Process,
    context: &Context,
    c: &Ceiling,
    budget: &mut Budget,
) -> Option<Vec<Finding>> {
    // Whatever is no longer than the least limit within a bracket does not matter; other spans are as they were.
    let holding = self_holding(process);
    let spans = [(BRIDGE, c.bridge, holding.bridge_mm), (LEDGE, c.cantilever, holding.ledge_mm)];
    let asked = spans.map(|(rule, reach, told)| {
        let limits = limits_of(process, rule).into_iter().flat_map(|l| [l.fail, l.warn]).flatten();
        let within = limits.filter(|&l| reach.is_some_and(|r| r.low_mm <= l && l < r.high_mm) && Some(l) != told);
        (within.reduce(f64::min), reach)
    });
    if asked.iter().all(|(limit, _)| limit.is_none()) {
        return None;
    }
    let beyond =
        asked.map(|(limit, reach)| limit.map(|l| l + c.tie_mm).or(reach.map(|r| r.high_mm)).unwrap_or(f64::INFINITY));
    let closer = looked_at_again(part, process, c, beyond, budget.left.saturating_mul(PAIRS))?;
    budget.note(1, closer.pairs / PAIRS);
    // Where nothing reaches out for certain, nothing does, however coarse the second look.
    let cantilever = closer.cantilever.filter(|_| c.cantilever.is_some());
    Some(judged(part, process, context, &Ceiling { cantilever, ..closer }))
}

/// What a ceiling breaks: its bridge and its ledge if it is flat, its diameter if it is a crown.
fn judged(part: &Part, process: &Process, context: &Context, c: &Ceiling) -> Vec<Finding> {
    let mut found = Vec::new();
    let flat = c.flat_share >= 0.5;
    // Where no place shows a strand but a long one is not ruled out, nothing may need it: `overhang` does not count on that.
    if let Some(b) = c.bridge.filter(|b| flat && (b.low_mm > 0.0 || c.cantilever.is_none())) {
        found.extend(place(part, process, context, c, "bridge", BRIDGE, bracket(&b), b.ends));
    }
    // Where no place shows a ledge but one is not ruled out, it is told as undecided: `overhang` does not count on it either.
    if let Some(b) = c.cantilever.filter(|_| flat && c.is_anchored) {
        found.extend(place(part, process, context, c, "ledge", LEDGE, bracket(&b), b.ends));
    }
    if let (Some(crown), Some(b)) = (c.crown.filter(|c| c.is_straight), c.bridge) {
        // Like any hole it is judged by its diameter; the facets' bounds are shown.
        let diameter = Bracket::exact(crown.diameter_mm - crown.sagitta_mm);
        let hole = place(part, process, context, c, "horizontal-hole", CROWN, diameter, b.ends);
        found.extend(hole.map(|mut f| {
            let shown = Bracket::new(crown.diameter_mm, crown.low_mm, crown.high_mm).rounded();
            (f.value, f.low, f.high) = (shown.value, shown.low, shown.high);
            f.places.iter_mut().for_each(|p| (p.value, p.low, p.high) = (shown.value, shown.low, shown.high));
            f.message = format!("crown of a lying hole of about {} mm hangs over", hundredths(shown.value));
            f
        }));
    }
    found
}

#[allow(clippy::too_many_arguments)]
fn place(
    part: &Part,
    process: &Process,
    context: &Context,
    c: &Ceiling,
    kind: &str,
    rule: &str,
    bracket: Bracket,
    ends: [Vec3; 2],
) -> Option<Finding> {
    let limits = limits_of(process, rule)?;
    let mut f = Finding::judged(META.code, kind, bracket, Basis::Certified, limits, "mm", 4.0 * part.step() + 1e-6);
    if f.state == State::Pass {
        return None;
    }
    f.area_mm2 = Some(report_digits(c.area_mm2));
    locate(&mut f, part, context, scale(along(ends[0], ends[1], 1.0), 0.5), c.extent);
    let layer = |z: f64| (z / process.layer_height_mm).floor().max(0.0) as u64;
    f.layers = Some([layer(c.extent.0[2]), layer(c.extent.1[2])]);
    f.witness = Some(Witness { kind: "span".into(), points_mm: ends.map(|p| reported(part, p)).to_vec() });
    let value = hundredths(bracket.value);
    f.message = match kind {
        "bridge" if bracket.value == 0.0 => {
            format!("ceiling of {} mm² may span up to {} mm freely", short(c.area_mm2.round()), up_to(bracket.high))
        }
        "bridge" => {
            format!("ceiling of {} mm² spans {value} mm freely from anchor to anchor", short(c.area_mm2.round()))
        }
        "ledge" if bracket.value == 0.0 => {
            format!("a flat ledge may reach up to {} mm out from what holds it", up_to(bracket.high))
        }
        "ledge" if c.is_beside => format!("flat ledge reaches {value} mm out from its nearest anchor"),
        "ledge" if c.is_spanned || !is_one_chain(&c.anchors) => {
            format!("flat ledge reaches {value} mm out from what holds it")
        }
        "ledge" => format!("flat ledge reaches {value} mm out from its only anchor"),
        _ => format!("crown of a lying hole of about {value} mm hangs over"),
    };
    Some(f)
}

/// An upper bound to the hundredth.
fn up_to(high: f64) -> String {
    short((high * 100.0).ceil() / 100.0)
}

/// Whether edges hang together end to end.
fn is_one_chain(edges: &[[Vec3; 2]]) -> bool {
    let mut sets = DisjointSets::new(edges.len());
    let mut at: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    for (n, end) in edges.iter().enumerate().flat_map(|(n, ends)| ends.map(|end| (n as u32, end))) {
        sets.join(n, *at.entry(end.map(f64::to_bits)).or_insert(n));
    }
    (1..edges.len() as u32).all(|n| sets.root(n) == sets.root(0))
}

/// A remedy tried at the place of a finding.
struct Tried {
    kind: String,
    at_mm: [f64; 3],
    remedy: Remedy,
}

enum Remedy {
    Ribs(Ribbing),
    Chamfer(Option<Chamfer>),
    Roof(Option<Roof>),
}

impl Tried {
    fn of(part: &Part, process: &Process, f: &Finding, c: &Ceiling) -> Self {
        let limit = limit_of(f);
        let remedy = match f.kind.as_str() {
            "bridge" => Remedy::Ribs(Ribbing::of(part, process, c, limit)),
            "ledge" => Remedy::Chamfer(Chamfer::of(part, process, c, limit)),
            _ => Remedy::Roof(Roof::of(part, process, c)),
        };
        Tried { kind: f.kind.clone(), at_mm: f.at_mm, remedy }
    }

    fn works(&self, part: &Part) -> bool {
        match &self.remedy {
            Remedy::Ribs(ribs) => ribs.holds(),
            Remedy::Chamfer(chamfer) => chamfer.is_some_and(|c| c.has_room()),
            Remedy::Roof(roof) => roof.is_some_and(|r| r.has_room(part)),
        }
    }
}

/// What is asked for: to keep the warn limit.
fn limit_of(f: &Finding) -> f64 {
    f.warn.or(f.fail).unwrap_or(0.0)
}

/// The hint of a finding, from what was tried at its places and what supports can do below them.
fn advised(part: &Part, f: &Finding, remedies: &[Tried], below: &[([f64; 3], Supports)]) -> String {
    let own = |t: &&Tried| t.kind == f.kind && f.places.iter().any(|p| p.at_mm == t.at_mm);
    let tries: Vec<&Tried> = remedies.iter().filter(own).collect();
    let (limit, length) = (limit_of(f), short(limit_of(f)));
    let first = match tries.first().map(|t| &t.remedy) {
        Some(Remedy::Ribs(ribs)) => ribs.words(part, limit),
        Some(Remedy::Chamfer(Some(chamfer))) => chamfer.words(limit),
        Some(Remedy::Roof(Some(roof))) => roof.words(part, limit),
        _ => format!("no more than {length} mm holds itself"),
    };
    let others = match (f.count, tries.len()) {
        (1, _) | (_, 0) => String::new(),
        (places, tried) => {
            let working = tries.iter().filter(|t| t.works(part)).count();
            format!("; tried at {tried} of {places} places, {working} of them have room for their own")
        }
    };
    let without = matches!(tries.first().map(|t| &t.remedy), Some(Remedy::Ribs(ribs)) if !ribs.holds());
    let here = below.iter().filter(|(at, _)| f.places.iter().any(|p| p.at_mm == *at)).map(|(_, supports)| *supports);
    let support = match (here.max(), without) {
        (None | Some(Supports::None), _) => "; this process prints no supports",
        (Some(Supports::Stay), _) => "; a support would stay in there: the void is sealed",
        (Some(Supports::Hold), true) => "; let it be supported",
        (Some(Supports::Hold), false) => "; or let it be supported",
    };
    format!("{first}{others}{support}")
}

#[cfg(test)]
mod tests {
    use super::super::roof::tests::block;
    use super::*;
    use crate::part::Up;

    fn found(part: &Part, process: &str) -> Vec<Finding> {
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        match Bridge.run(part, &Process::named(process).unwrap(), &context).unwrap() {
            Outcome::Measured(measured) => measured.findings,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn an_anchor_is_the_only_one_if_its_edges_hang_together() {
        let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [5.0, 2.0, 0.0]];
        assert!(is_one_chain(&[]) && is_one_chain(&[[a, b], [c, d], [b, c]]));
        assert!(!is_one_chain(&[[a, b], [c, d]]));
    }

    /// A lip all round the mouth of a tube, of so many sides, that no strand reaches: it holds itself while it is no wider than a ledge may be.
    #[test]
    fn a_lip_that_runs_round_holds_itself_however_many_sides_it_has() {
        use crate::geometry::revolved;
        for (sides, radius, lip) in [(64, 4.0, 0.45), (256, 20.0, 0.1), (256, 20.0, 0.4)] {
            let mouth = radius - lip;
            let wall =
                [[radius, 0.0], [radius + 4.0, 0.0], [radius + 4.0, 10.0], [mouth, 10.0], [mouth, 8.0], [radius, 8.0]];
            let part = Part::new(revolved(&wall, sides), Up::PlusZ, 1e-6, 0.0).unwrap();
            let lpbf = Process::named("lpbf").unwrap();
            assert!(super::super::hanging::needing_support(&part, &lpbf, 0).facets.is_empty(), "{sides} {lip}");
            assert_eq!(found(&part, "lpbf"), [], "{sides} {lip}");
        }
    }

    #[test]
    fn a_lying_hole_is_told_with_its_value() {
        for (process, sides, diameter) in [("fdm", 16, 9.0), ("lpbf", 20, 7.3)] {
            let all = found(&block(sides, diameter, 6.0), process);
            assert_eq!(all.len(), 1, "{process} {sides} {diameter}: {all:?}");
            let f = &all[0];
            assert!(f.kind == "horizontal-hole" && f.low <= diameter && diameter <= f.high, "{f:?}");
            let words = format!("crown of a lying hole of about {} mm hangs over", hundredths(f.value));
            assert_eq!(f.message, words, "{process} {sides} {diameter}");
        }
        assert_eq!(found(&block(96, 4.8, 6.0), "sla"), []);
    }
}
