//! Whether parts topple: their centres of mass over their footprints.

use super::contract::{Context, limits_of};
use super::finding::{Basis, Bracket, Finding, State, Witness};
use super::place::{group_equal, locate, reported};
use crate::geometry::vector::{Vec3, bounds};
use crate::geometry::{DisjointSets, Hull, Prism, TriangleMesh};
use crate::layer::section_points;
use crate::part::Part;
use crate::process::Process;
use crate::units::short;
use std::collections::BTreeMap;

/// How much deeper than asked the centre of mass lies over a foot that is advised, millimetres.
const SPARE: f64 = 1.0;
/// Feet that are tried, and sides of the polygon that one is.
const FEET: usize = 8;
const SIDES: usize = 32;

/// What the topple rule of AM205 finds: bodies, or bodies that fuse, whose centre of mass lies too little inside their footprint.
///
/// A body without a section in the first layer stands on no footprint of its own, and is left to others.
pub(super) fn topple(part: &Part, process: &Process, context: &Context) -> Vec<Finding> {
    if !part.is_plain() || limits_of(process, "tall-feature.topple").is_none() {
        return Vec::new();
    }
    let found = standing(part, process).into_iter().filter_map(|own| toppling(part, process, context, &own));
    let mut findings: Vec<Finding> = found.collect();
    findings.sort_by(Finding::worst_first);
    let mut findings = group_equal(findings, part.tie());
    for f in findings.iter_mut().filter(|f| f.count > 1) {
        f.message = format!("{} bodies: {}", f.count, f.message);
    }
    findings
}

/// What is printed in one piece.
struct Standing {
    mesh: TriangleMesh,
    /// Its bodies, counted from 1; none where they are all of the part.
    bodies: Option<Vec<u64>>,
}

impl Standing {
    /// Whether facets of other bodies reach to within so high above the plate in a convex outline.
    fn meets_another(&self, part: &Part, outline: &Hull, high: f64) -> bool {
        let own = |f: u32| {
            let body = part.health().facet_body.get(f as usize).map(|&b| u64::from(b) + 1);
            self.bodies.as_ref().is_none_or(|own| body.is_some_and(|b| own.contains(&b)))
        };
        let base: Vec<Vec3> = outline.corners().iter().map(|&[x, y]| [x, y, -part.step()]).collect();
        Prism { base, along: [0.0, 0.0, high + part.step()] }.is_met(part.distance(), |f| !own(f))
    }
}

/// The pieces that a part is printed in: bodies nearer than the gap that closes fuse. Facets that bound no solid are left out.
///
/// # Cost
/// O(facets), in time and memory, however many pieces there are.
fn standing(part: &Part, process: &Process) -> Vec<Standing> {
    let (mesh, health) = (part.mesh(), part.health());
    let mut pieces = DisjointSets::new(health.bodies.len());
    for pair in part.body_pairs().iter().filter(|p| p.distance < process.element.closing_gap_mm) {
        let [a, b] = pair.bodies;
        pieces.join(a, b);
    }
    let mut own: BTreeMap<u32, (Vec<u64>, Vec<usize>)> = BTreeMap::new();
    for body in 0..health.bodies.len() as u32 {
        own.entry(pieces.root(body)).or_default().0.push(u64::from(body) + 1);
    }
    let is_one = own.len() == 1;
    let only = own.keys().next().copied();
    for f in (0..mesh.triangles.len()).filter(|&f| part.bounds_solid(f)) {
        let body = health.facet_body.get(f).copied().filter(|&body| (body as usize) < health.bodies.len());
        let root = if is_one { only } else { body.map(|body| pieces.root(body)) };
        root.and_then(|root| own.get_mut(&root)).into_iter().for_each(|(_, facets)| facets.push(f));
    }
    let piece = |(bodies, facets): (Vec<u64>, Vec<usize>)| Standing {
        mesh: TriangleMesh::weld(facets.into_iter().map(|f| mesh.corners(f))),
        bodies: (!is_one).then_some(bodies),
    };
    own.into_values().map(piece).collect()
}

/// How far the centre of mass lies inside the footprint, if that is too little.
fn toppling(part: &Part, process: &Process, context: &Context, own: &Standing) -> Option<Finding> {
    let limits = limits_of(process, "tall-feature.topple")?;
    let centre = own.mesh.centre_of_mass(|_| true)?;
    let footprint = Hull::of(section_points(&own.mesh, 0.5 * process.layer_height_mm));
    let depth = footprint.depth([centre[0], centre[1]]);
    if !depth.is_finite() {
        return None;
    }
    // The section moves by what half a layer and a coordinate step move it; what is within them is on the edge.
    let mut f = Finding::judged("AM205", "topple", Bracket::exact(depth), Basis::Exact, limits, "mm", part.tie());
    if f.state == State::Pass {
        return None;
    }
    let corners = (0..own.mesh.triangles.len()).flat_map(|f| own.mesh.corners(f));
    locate(&mut f, part, context, centre, bounds(corners)?);
    f.bodies = own.bodies.clone();
    f.witness = Some(Witness { kind: "centre-of-mass".into(), points_mm: vec![reported(part, centre)] });
    let least = limits.warn.or(limits.fail).unwrap_or(0.0);
    let what = match f.bodies.as_deref() {
        None => "the part",
        Some([_]) => "the body",
        Some(_) => "what these bodies make",
    };
    f.message = if depth < 0.0 {
        format!("the centre of mass lies {} mm outside the footprint: {what} topples", short(round(-depth)))
    } else {
        format!("the centre of mass lies only {} mm inside the footprint", short(round(depth)))
    };
    let volume = own.mesh.signed_volume();
    // As thick as a wall, so that it is none that is too thin.
    let wall = limits_of(process, "thin-wall").and_then(|l| l.warn.or(l.fail)).unwrap_or(0.0);
    let thick = wall.max(process.layer_height_mm);
    let gap = limits_of(process, "narrow-gap.between-bodies").and_then(|l| l.fail.or(l.warn)).unwrap_or(0.0);
    f.fix = match broader_foot(&footprint, centre, volume, thick, least + SPARE) {
        Some(foot) if own.meets_another(part, &foot.outline, thick + gap) => {
            "lay it down: another body stands where a foot broad enough would be".into()
        }
        Some(Foot { wider, inside, .. }) => format!(
            "give it a foot {} mm thick, {} mm broader on that side: measured again, the centre of mass lies {} mm inside",
            short(thick),
            short((100.0 * wider).ceil() / 100.0),
            short((100.0 * inside).floor() / 100.0)
        ),
        None => "give it a broader foot, or lay it down".into(),
    };
    Some(f)
}

/// How far inside its footprint the centre of mass of a part in one piece lies once volumes are added at places, mm³ and mm, where that is too little and was not
/// before.
///
/// # Cost
/// O(facets).
pub(super) fn toppled_by(part: &Part, process: &Process, added: &[(f64, Vec3)]) -> Option<f64> {
    let limits = limits_of(process, "tall-feature.topple")?;
    let all = if part.is_plain() { standing(part, process) } else { Vec::new() };
    let [own] = &all[..] else { return None };
    let (centre, volume) = (own.mesh.centre_of_mass(|_| true)?, own.mesh.signed_volume());
    let footprint = Hull::of(section_points(&own.mesh, 0.5 * process.layer_height_mm));
    let is_too_little = |depth: f64| limits.judge(&Bracket::exact(depth), Basis::Exact, part.tie()).0 != State::Pass;
    let before = footprint.depth([centre[0], centre[1]]);
    let whole = volume + added.iter().map(|a| a.0).sum::<f64>();
    let along = |a: usize| (volume * centre[a] + added.iter().map(|(v, at)| v * at[a]).sum::<f64>()) / whole;
    let after = footprint.depth([along(0), along(1)]);
    (before.is_finite() && !is_too_little(before) && is_too_little(after)).then_some(after)
}

/// Two decimals, for sentences.
pub(super) fn round(mm: f64) -> f64 {
    (100.0 * mm).round() / 100.0
}

/// A foot that a part is given: how far it reaches beyond the footprint, how deep inside it the centre of mass lies then, and all of it in plan.
struct Foot {
    wider: f64,
    inside: f64,
    outline: Hull,
}

/// The foot as thick, under all within some distance of the centre of mass, whose own mass is counted.
fn broader_foot(footprint: &Hull, centre: Vec3, volume: f64, thick: f64, least: f64) -> Option<Foot> {
    let corners = || footprint.corners().iter().copied();
    let (area, middle) = centroid(footprint);
    let short_of = -footprint.depth([centre[0], centre[1]]);
    let mut reach = least;
    for _ in 0..FEET {
        // Corners of a polygon about the circle, so that the circle lies within it.
        let out = reach / (std::f64::consts::PI / SIDES as f64).cos();
        let round = (0..SIDES).map(|n| {
            let (s, c) = (std::f64::consts::TAU * n as f64 / SIDES as f64).sin_cos();
            [centre[0] + out * c, centre[1] + out * s]
        });
        let broader = Hull::of(corners().chain(round));
        let (whole, of_whole) = centroid(&broader);
        let moved = [0, 1].map(|a| {
            let moment = volume * centre[a] + thick * (whole * of_whole[a] - area * middle[a]);
            moment / (volume + thick * (whole - area))
        });
        let inside = broader.depth(moved);
        if inside >= least {
            return Some(Foot { wider: short_of + out, inside, outline: broader });
        }
        reach += 1.1 * (least - inside);
    }
    None
}

/// Area and centre of a hull.
fn centroid(hull: &Hull) -> (f64, [f64; 2]) {
    let corners = hull.corners();
    let Some(&[x0, y0]) = corners.first() else { return (0.0, [0.0; 2]) };
    let (mut area, mut moment) = (0.0, [0.0; 2]);
    for w in corners.windows(2) {
        let twice = (w[0][0] - x0) * (w[1][1] - y0) - (w[1][0] - x0) * (w[0][1] - y0);
        area += 0.5 * twice;
        (0..2).for_each(|a| moment[a] += twice / 6.0 * (corners[0][a] + w[0][a] + w[1][a]));
    }
    (area, if area > 0.0 { moment.map(|m| m / area) } else { [x0, y0] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{cuboid, extruded};
    use crate::part::Up;

    #[test]
    fn a_foot_carries_the_centre_of_mass_and_its_own_mass_is_counted() {
        let square = Hull::of([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]]);
        let (area, middle) = centroid(&square);
        assert!(area == 100.0 && middle.iter().all(|c| (c - 5.0).abs() < 1e-12), "{area} {middle:?}");
        // Three millimetres outside on +x: five have to be added to be two inside, and a little more for the foot's own mass.
        let Foot { wider, inside, .. } = broader_foot(&square, [13.0, 5.0, 20.0], 1000.0, 0.2, 2.0).expect("a foot");
        assert!(inside >= 2.0 && (5.0..5.2).contains(&wider), "{wider} {inside}");
        let heavy = broader_foot(&square, [13.0, 5.0, 20.0], 10.0, 1.0, 2.0).expect("a foot");
        assert!(heavy.inside >= 2.0, "{}", heavy.inside);
    }

    #[test]
    fn no_foot_is_advised_where_another_body_stands() {
        let process = Process::named("fdm").unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        // A foot of 10 mm under an arm of 20 mm; a low block beside it, near and far, and one that is higher above the plate.
        let outline = [[0.0, 0.0], [10.0, 0.0], [10.0, 20.0], [30.0, 20.0], [30.0, 32.0], [0.0, 32.0]];
        let arm = extruded(&outline, &[[0, 1, 2], [0, 2, 5], [2, 3, 4], [2, 4, 5]], 10.0);
        for (from, to, is_free) in [(10.5, [0.0, 3.0], false), (30.0, [0.0, 3.0], true), (10.5, [4.0, 6.0], true)] {
            let block = cuboid([from, 1.0, to[0]], [from + 4.0, 9.0, to[1]]);
            let part = Part::new(arm.clone().joined(&block), Up::PlusZ, 1e-6, 1.0).unwrap();
            let found = topple(&part, &process, &context);
            let told = found.iter().find(|f| f.bodies == Some(vec![1])).unwrap();
            assert_eq!(told.fix.starts_with("give it a foot"), is_free, "{from}: {}", told.fix);
        }
    }

    #[test]
    fn every_body_stands_by_itself_unless_it_fuses_with_its_neighbour() {
        let process = Process::named("fdm").unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        // A foot of 4 mm under an arm of 20 mm; a block under its end, apart or so near that it fuses.
        let arm = cuboid([0.0; 3], [4.0, 4.0, 10.0]).joined(&cuboid([4.0, 0.0, 8.0], [24.0, 4.0, 10.0]));
        for (gap, toppling) in [(3.0, 1), (0.1, 0)] {
            let block = cuboid([18.0, 0.0, 0.0], [24.0, 4.0, 8.0 - gap]);
            let part = Part::new(arm.clone().joined(&block), Up::PlusZ, 1e-6, 1.0).unwrap();
            let found = topple(&part, &process, &context);
            assert_eq!(found.len(), toppling, "{gap}: {found:?}");
            assert!(found.iter().all(|f| f.kind == "topple" && f.bodies.is_some()), "{found:?}");
        }
    }
}
