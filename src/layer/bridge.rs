//! Overhangs between anchors: bridges, arches and cantilevers.

use super::beneath::{Ground, Resting, left_to_span};
use super::line::Side;
use super::passage::{Crown, SHALLOW, crown};
use super::plan::Plan;
use super::reading::{Farthest, Limits, Search};
use super::section::Point;
use super::sliver::with_slivers;
use super::step_down::{Descent, Descents};
use super::stretch::lifted;
use crate::geometry::vector::{Vec3, angle, bounds, cross, dot, norm, sub};
use crate::geometry::{DisjointSets, TriangleMesh};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

/// Downward surface flatter than this (5°) is a ceiling that strands can cross; steeper surface is printed in steps.
pub const FLAT: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// A passage lies that climbs by no more than this, about 19°: of a steeper one less and less hangs over, and what is narrow of it is a ledge.
const LYING: f64 = 0.35;

/// A connected piece of downward surface, and how far it spans.
#[derive(Debug, Clone, PartialEq)]
pub struct Ceiling {
    /// Facets in increasing order.
    pub facets: Vec<u32>,
    /// Area, mm².
    pub area_mm2: f64,
    /// Share of the area that is flatter than a ceiling may be.
    pub flat_share: f64,
    pub extent: (Vec3, Vec3),
    /// Whether strands along the greatest span are level: the ceiling is flat, or slopes only across them, as the underside of a lying
    /// cylinder between two walls does.
    pub is_level: bool,
    /// Whether any of its border is an anchor; without one it hangs in mid-air and reaches out from nothing.
    pub is_anchored: bool,
    /// The edges by which it hangs on walls, on the plate and on other bodies; the ceiling lies to the right of them in plan.
    pub anchors: Vec<[Vec3; 2]>,
    /// The greatest free span from anchor to anchor, with the points between which it was measured.
    pub bridge: Option<Reach>,
    /// The farthest that material which no bridge holds reaches out from an anchor or from a bridge, or that a flat ledge reaches out from
    /// the nearest anchor, where strands through it exceed their limit by more.
    pub cantilever: Option<Reach>,
    /// Whether the cantilever is such a ledge.
    pub is_beside: bool,
    /// Whether strands cross it from anchor to anchor, though it may be told as a ledge.
    pub is_spanned: bool,
    /// The round passage whose crown this is; `None` for flat ceilings, for what reaches out by more than half its span and for what does
    /// not rise between its anchors.
    pub crown: Option<Crown>,
    /// What measuring it took, in pairs of a line and a side.
    pub pairs: u64,
    /// What of these it took to tell once more whether it holds itself.
    pub again: u64,
    /// A length that exceeds its limit by no more equals it, as far as the coordinates tell.
    pub tie_mm: f64,
}

impl Ceiling {
    /// The same with the narrower bounds of an earlier look at it for its bridge.
    pub(super) fn narrowed_by(self, earlier: &Ceiling) -> Ceiling {
        let bridge = self.bridge.zip(earlier.bridge).map(|(own, earlier)| {
            let best = if earlier.low_mm > own.low_mm { earlier } else { own };
            Reach { high_mm: own.high_mm.min(earlier.high_mm), ..best }
        });
        // Where an earlier look has ruled out that anything reaches out, nothing does that is not shown.
        let cantilever = self.cantilever.filter(|c| c.low_mm > 0.0 || earlier.cantilever.is_some());
        Ceiling {
            bridge: bridge.or(self.bridge),
            cantilever,
            pairs: self.pairs + earlier.pairs,
            again: self.pairs + earlier.again,
            ..self
        }
    }
}

/// A length with bounds, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    pub low_mm: f64,
    pub high_mm: f64,
    pub at: Vec3,
    pub ends: [Vec3; 2],
}

/// How the surface runs above a span.
#[derive(Debug, Clone, Copy)]
pub(super) struct Profile {
    /// How far the middle lies above that of the ends.
    pub rise_mm: f64,
    /// The way from a quarter of the span to three quarters, where a fillet at either end no longer matters.
    pub tilt: Vec3,
}

impl Profile {
    /// The facets above a span from end to end.
    fn of(mesh: &TriangleMesh, facets: &[u32], [from, to]: [Vec3; 2]) -> Self {
        let at = |t: f64| lifted(mesh, facets, [0, 1].map(|n| from[n] + t * (to[n] - from[n])));
        Profile { rise_mm: at(0.5)[2] - 0.5 * (from[2] + to[2]), tilt: sub(at(0.75), at(0.25)) }
    }

    /// Whether strands along the span lie in one layer, or nearly.
    fn is_level(&self) -> bool {
        let [run, climb] = [self.tilt[0].hypot(self.tilt[1]), self.tilt[2].abs()];
        self.rise_mm.abs() <= 2.0 * SHALLOW * run && climb <= SHALLOW * run
    }
}

/// How ceilings are measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measuring {
    /// What lies up to this height lies on the plate.
    pub plate_z: f64,
    /// Height of a layer: what is lower beside a ceiling by less holds nothing.
    pub layer_mm: f64,
    /// Places so near an anchor hold themselves.
    pub ledge_mm: f64,
    /// Strands so long hold themselves; infinite where the process does not say.
    pub bridge_mm: f64,
    /// No coordinate is further from what was meant.
    pub step_mm: f64,
    pub search: Search,
}

impl Measuring {
    /// A length that exceeds its limit by no more equals it, and keeps it.
    pub fn tie_mm(&self) -> f64 {
        4.0 * self.step_mm + 1e-6
    }

    /// The same with a search that tells whether bridges are longer than their limit, and ledges farther than a length beyond theirs, with so
    /// many pairs of a line and a side.
    pub fn telling(self, ledge_mm: f64, pairs: u64) -> Self {
        Measuring { search: Search::Tell { beyond: [self.bridge_mm + self.tie_mm(), ledge_mm], pairs }, ..self }
    }
}

/// The ceilings that the facets `hanging` make, joined over common edges.
///
/// The edge to a facet that is not hanging is an anchor where the surface folds towards the void (the dihedral angle of the void is
/// below 180°: a wall or a self-supporting slope goes down from it) and goes down by a layer within the length of a ledge, where it lies on the plate, up to `plate_z`, and where the `ground` holds
/// the neighbour. Ceilings on both sides of a lower step are one, and a lip less than a layer deep belongs to its ceiling. All other edges are free. What rests on the ground beneath spans nothing: it is taken out of the region, and its border
/// is an anchor. The spans are those of the region's plan, along lines across the longest anchors, along the longest free edges, every
/// 15° from the first of them, and from each place to its nearest anchor and to the nearest on its other side, where it would be told every 1.5° as well; places within `ledge_mm` of an anchor hold themselves, and so do those within it of a bridge. Ceilings that overlap themselves in
/// plan, as in a screw, are measured as if they did not.
///
/// # Cost
/// O(facets), and for each ceiling wider than `ledge_mm` a search over its boundary as [`Search`] says.
pub fn ceilings(mesh: &TriangleMesh, hanging: &[u32], how: Measuring, ground: &impl Ground) -> Vec<Ceiling> {
    let mut joined = with_slivers(mesh, hanging, how.step_mm);
    let descents = Descents::new(mesh, hanging, how, ground);
    let mut boundary = Boundary::of(mesh, &joined);
    let steps = boundary.settle(mesh, &descents);
    if !steps.is_empty() {
        joined.extend(steps);
        boundary = Boundary::of(mesh, &joined);
        boundary.settle(mesh, &descents);
    }
    let mut members: std::collections::BTreeMap<u32, Vec<usize>> = Default::default();
    let mut sets = DisjointSets::new(joined.len());
    for &(i, j) in &boundary.inner {
        sets.join(i as u32, j as u32);
    }
    for i in 0..joined.len() {
        members.entry(sets.root(i as u32)).or_default().push(i);
    }
    let mut rims: std::collections::BTreeMap<u32, Vec<&Rim>> = Default::default();
    for rim in &boundary.rims {
        rims.entry(sets.root(rim.member as u32)).or_default().push(rim);
    }
    let pieces: Vec<(u32, Vec<usize>)> = members.into_iter().collect();
    pieces
        .into_par_iter()
        .with_max_len(1)
        .filter_map(|(of, members)| {
            // Slivers and steps only carry the boundary on: they come behind the hanging facets.
            let facets: Vec<u32> = members.iter().filter_map(|&i| hanging.get(i).copied()).collect();
            let rims = rims.get(&of).map_or(&[][..], |r| r);
            let all = members.iter().filter_map(|&i| joined.get(i)).map(|(f, _)| *f);
            let resting = all.filter_map(|f| Resting::of(f, mesh.corners(f as usize), ground)).collect::<Vec<_>>();
            describe(mesh, facets, rims, how, (ground, &resting))
        })
        .collect()
}

/// An edge between a hanging facet and one that is not.
struct Rim {
    /// Place of the hanging facet in the list, and its number.
    member: usize,
    facet: u32,
    normal: Vec3,
    from: Vec3,
    to: Vec3,
    neighbour: Option<u32>,
    /// Whether the surface folds towards the void and goes down far enough to hold it.
    is_held: bool,
}

/// Edges inside and around a set of facets.
struct Boundary {
    inner: Vec<(usize, usize)>,
    rims: Vec<Rim>,
}

impl Boundary {
    fn of(mesh: &TriangleMesh, hanging: &[(u32, Vec3)]) -> Self {
        let mut at = vec![u32::MAX; mesh.triangles.len()];
        let mut touched = vec![false; mesh.vertices.len()];
        for (i, &(f, _)) in hanging.iter().enumerate() {
            at[f as usize] = i as u32;
            mesh.triangles[f as usize].iter().for_each(|&v| touched[v as usize] = true);
        }
        let mut others: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        let mut of_edge: FxHashMap<(u32, u32), Vec<usize>> = FxHashMap::default();
        for (f, t) in mesh.triangles.iter().enumerate() {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                if !touched[a as usize] || !touched[b as usize] {
                    continue;
                }
                let key = (a.min(b), a.max(b));
                if at[f] == u32::MAX {
                    others.insert(key, f as u32);
                } else {
                    of_edge.entry(key).or_default().push(at[f] as usize);
                }
            }
        }
        let mut boundary = Boundary { inner: Vec::new(), rims: Vec::new() };
        // In the order of the facets, so that the result does not depend on the hash.
        for (i, &(f, normal)) in hanging.iter().enumerate() {
            let t = mesh.triangles[f as usize];
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                let key = (a.min(b), a.max(b));
                let sharing = &of_edge[&key];
                boundary.inner.extend(sharing.iter().filter(|&&j| j < i).map(|&j| (j, i)));
                if sharing.len() == 1 {
                    let [from, to] = [a, b].map(|v| mesh.vertices[v as usize]);
                    boundary.rims.push(Rim {
                        member: i,
                        facet: f,
                        normal,
                        from,
                        to,
                        neighbour: others.get(&key).copied(),
                        is_held: false,
                    });
                }
            }
        }
        boundary
    }

    /// Finds out which edges are held; the facets of steps that are too low for that, with the normal of what they lead away from.
    fn settle<G: Ground>(&mut self, mesh: &TriangleMesh, descents: &Descents<G>) -> Vec<(u32, Vec3)> {
        let descend = |rim: &mut Rim| {
            let way = rim.neighbour.filter(|&g| folds_to_void(mesh, rim, g));
            match way.map(|g| descents.from([rim.from, rim.to], g)) {
                Some(Descent::Ends(steps)) => steps.into_iter().map(|f| (f, rim.normal)).collect(),
                held => {
                    rim.is_held = held.is_some();
                    Vec::new()
                }
            }
        };
        let mut steps: Vec<(u32, Vec3)> = self.rims.par_iter_mut().with_min_len(64).flat_map_iter(descend).collect();
        steps.sort_by_key(|s| s.0);
        steps.dedup_by_key(|s| s.0);
        steps
    }
}

/// Angle of a facet from the horizontal.
pub(super) fn slope(mesh: &TriangleMesh, f: u32) -> f64 {
    angle(mesh.normal(f as usize), [0.0, 0.0, -1.0])
}

fn describe(
    mesh: &TriangleMesh,
    facets: Vec<u32>,
    rims: &[&Rim],
    how: Measuring,
    (ground, resting): (&impl Ground, &[Resting]),
) -> Option<Ceiling> {
    let extent = bounds(facets.iter().flat_map(|&f| mesh.corners(f as usize)))?;
    let area = |f: &u32| mesh.facet_area(*f as usize);
    let area_mm2: f64 = facets.iter().map(area).sum();
    let flat: f64 = facets.iter().filter(|&&f| slope(mesh, f) <= FLAT).map(area).sum();
    let own: FxHashSet<u32> = facets.iter().copied().collect();
    let mut beside = Vec::new();
    let mut sides = Vec::with_capacity(rims.len());
    let mut anchors = Vec::new();
    for rim in rims {
        let folded = rim.neighbour.filter(|&g| folds_to_void(mesh, rim, g));
        beside.extend(folded);
        let on_plate = rim.from[2].max(rim.to[2]) <= how.plate_z;
        let anchored = on_plate || rim.is_held || rim.neighbour.is_some_and(|g| ground.holds(g));
        let plan = |p: Vec3| [p[0], p[1]];
        if anchored {
            anchors.push([rim.from, rim.to]);
        }
        let of = own.contains(&rim.facet).then_some(rim.facet);
        sides.push((of, Side { from: plan(rim.from), to: plan(rim.to), anchored }));
    }
    let sides = left_to_span(&sides, resting);
    let is_anchored = sides.iter().any(|s| s.anchored);
    let flat_share = if area_mm2 > 0.0 { flat / area_mm2 } else { 0.0 };
    let flat = flat_share >= 0.5;
    let tie_mm = how.tie_mm();
    let ledge_mm = how.ledge_mm + tie_mm;
    // An arch is judged by its diameter, not by its strands.
    let limits = Limits { ledge: ledge_mm, bridge: if flat { how.bridge_mm + tie_mm } else { f64::INFINITY } };
    // What is smaller than a ledge in every direction is one.
    let diagonal = (extent.1[0] - extent.0[0]).hypot(extent.1[1] - extent.0[1]);
    let small = diagonal <= ledge_mm && is_anchored;
    let plan = if small { None } else { Plan::new(sides, how.step_mm) };
    let spans = plan.as_ref().map(|p| p.spans(limits, how.search)).unwrap_or_default();
    let lifted = |f: Farthest| reach(mesh, &facets, f);
    let [mut bridge, cantilever] = [spans.bridge, spans.cantilever].map(|s| s.map(lifted));
    let mut crown = crowned(mesh, &facets, &beside, [bridge.filter(|_| !flat), cantilever]);
    let mut pairs = spans.pairs;
    // A narrow crown lies within the ledge limit of its anchors, all of it, and the passage below is as wide all the same. A dome is held
    // on all sides.
    if let Some(plan) = plan.filter(|_| !flat && is_anchored && bridge.is_none() && cantilever.is_none()) {
        let across = plan.spans(Limits { ledge: 0.0, bridge: f64::INFINITY }, Search::Judge);
        pairs += across.pairs;
        let narrow = across.bridge.map(lifted);
        let round = crowned(mesh, &facets, &beside, [narrow, across.cantilever.map(lifted)]);
        crown = round.filter(|c| c.is_straight && c.grade <= LYING);
        bridge = narrow.filter(|_| crown.is_some());
    }
    let is_level = flat || bridge.is_some_and(|b| Profile::of(mesh, &facets, b.ends).is_level());
    Some(Ceiling {
        area_mm2,
        flat_share,
        extent,
        is_level,
        is_anchored,
        anchors,
        bridge,
        cantilever,
        is_beside: spans.is_beside,
        is_spanned: spans.is_spanned,
        crown,
        pairs,
        again: 0,
        tie_mm,
        facets,
    })
}

/// The round passage that a ceiling with a bridge and a cantilever is the crown of; `beside` are the facets with which the surface goes on.
fn crowned(
    mesh: &TriangleMesh,
    facets: &[u32],
    beside: &[u32],
    [bridge, cantilever]: [Option<Reach>; 2],
) -> Option<Crown> {
    let steepest = facets.iter().map(|&f| slope(mesh, f)).fold(0.0, f64::max);
    // The mouth of a passage in a round body bulges by no more than half its width.
    let bulges = |b: &Reach| cantilever.is_none_or(|c| c.low_mm <= 0.5 * b.low_mm);
    let arched = bridge.filter(|b| steepest > FLAT && bulges(b));
    arched.and_then(|b| crown(mesh, facets, beside, b, Profile::of(mesh, facets, b.ends)))
}

/// Whether the surface folds towards the void at an edge: the neighbour lies in front of the hanging facet.
fn folds_to_void(mesh: &TriangleMesh, rim: &Rim, neighbour: u32) -> bool {
    let edge = sub(rim.to, rim.from);
    let far = mesh.corners(neighbour as usize);
    let tip = far.iter().copied().find(|&p| p != rim.from && p != rim.to);
    let Some(tip) = tip else { return false };
    let out = sub(tip, rim.from);
    let height = norm(cross(edge, out)) / norm(edge).max(f64::MIN_POSITIVE);
    dot(rim.normal, out) > 1e-3 * height
}

/// A length in plan as one on the ceiling: heights are those of the facets above the points.
fn reach(mesh: &TriangleMesh, facets: &[u32], f: Farthest) -> Reach {
    let lift = |p: Point| lifted(mesh, facets, p);
    Reach { low_mm: f.low, high_mm: f.high, at: lift(f.at), ends: f.ends.map(lift) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::extruded;
    use crate::layer::{SelfHolding, downward_facets};
    use crate::units::Angle;

    fn found(mesh: &TriangleMesh, ledge: f64) -> Vec<Ceiling> {
        found_within(mesh, 45.0, [ledge, f64::INFINITY])
    }

    fn found_within(mesh: &TriangleMesh, degrees: f64, [ledge_mm, bridge_mm]: [f64; 2]) -> Vec<Ceiling> {
        let hanging = downward_facets(mesh, 0.0, Angle::degrees(degrees), 1e-9);
        let (layer_mm, search) = (0.2, Search::Measure);
        let how = Measuring { plate_z: 1e-4, layer_mm, ledge_mm, bridge_mm, step_mm: 1e-9, search };
        ceilings(mesh, &hanging, how, &())
    }

    fn turned(mesh: &TriangleMesh, turn: f64) -> TriangleMesh {
        let (s, c) = turn.sin_cos();
        mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [3.3 * turn, -1.7 * turn, 0.0])
    }

    /// A bench with legs of 2 mm, `span` apart, with an arm of `arm` beyond the right one.
    fn bench(span: f64, arm: f64) -> TriangleMesh {
        let (a, b) = (2.0, 2.0 + span);
        let outline = [
            [0.0, 0.0],
            [a, 0.0],
            [a, 8.0],
            [b, 8.0],
            [b, 0.0],
            [b + 2.0, 0.0],
            [b + 2.0, 8.0],
            [b + 2.0 + arm, 8.0],
            [b + 2.0 + arm, 10.0],
            [0.0, 10.0],
        ];
        extruded(
            &outline,
            &[[0, 1, 2], [0, 2, 9], [9, 2, 3], [9, 3, 6], [3, 4, 5], [3, 5, 6], [6, 7, 8], [6, 8, 9]],
            6.0,
        )
    }

    #[test]
    fn a_span_as_long_as_its_limit_holds_however_it_was_turned_before_it_was_written() {
        let (step_mm, limit) = (3.9e-6, 2.0);
        let limits = SelfHolding { bridge_mm: Some(limit), ledge_mm: Some(0.5), crown_mm: None };
        for (span, n) in (0..24).flat_map(|n| [(limit, n), (limit + 1e-4, n)]) {
            let mut mesh = turned(&bench(span, 0.3), 0.26 * f64::from(n));
            let written = |x: f64| f64::from((x + 50.0) as f32) - 50.0;
            mesh.vertices.iter_mut().for_each(|p| *p = p.map(written));
            let hanging = downward_facets(&mesh, 0.02, Angle::degrees(45.0), step_mm);
            let (plate_z, layer_mm, search) = (0.02, 0.04, Search::Measure);
            let how = Measuring { plate_z, layer_mm, ledge_mm: 0.5, bridge_mm: limit, step_mm, search };
            let all = ceilings(&mesh, &hanging, how, &());
            assert_eq!(all.iter().all(|c| limits.holds(c)), span == limit, "{span} {n} {all:?}");
        }
    }

    #[test]
    fn a_bench_is_a_bridge_and_a_cantilever() {
        for (span, arm, turn) in [(10.0, 3.0, 0.0), (37.3, 0.9, 0.7), (4.1, 8.0, 2.1), (20.0, 5.0, 4.0)] {
            let all = found(&turned(&bench(span, arm), turn), 0.0);
            assert_eq!(all.len(), 2, "{all:?}");
            let bridge = all.iter().find_map(|c| c.bridge).unwrap();
            assert!(bridge.low_mm <= span + 1e-9 && span <= bridge.high_mm + 1e-9, "{span}: {bridge:?}");
            assert!(bridge.high_mm - bridge.low_mm < 1e-6 && bridge.ends.iter().all(|p| (p[2] - 8.0).abs() < 1e-9));
            let arm_found = all.iter().find_map(|c| c.cantilever).unwrap();
            assert!(
                arm_found.low_mm <= arm && arm <= arm_found.high_mm + 1e-9 && arm_found.low_mm > 0.9 * arm,
                "{arm_found:?}"
            );
            assert!(all.iter().all(|c| c.flat_share == 1.0 && c.crown.is_none()));
        }
    }

    #[test]
    fn a_lying_hole_is_a_crown_whose_diameter_is_known() {
        // A block with a tunnel of 16 sides whose corners lie on a circle of 5 mm; as an outline with a slit along its floor.
        let n = 16;
        let tunnel: Vec<[f64; 2]> = (0..=n)
            .map(|i| (-0.5 * std::f64::consts::PI + std::f64::consts::TAU * i as f64 / n as f64).sin_cos())
            .map(|(s, c)| [2.5 * c, 5.0 + 2.5 * s])
            .collect();
        let mut facets = Vec::new();
        for w in tunnel.windows(2) {
            let p = |q: [f64; 2], y: f64| [q[0], y, q[1]];
            facets.push([p(w[0], 0.0), p(w[1], 9.0), p(w[1], 0.0)]);
            facets.push([p(w[0], 0.0), p(w[0], 9.0), p(w[1], 9.0)]);
        }
        let mut tube = TriangleMesh::weld(facets);
        let up = tube.normal(0)[2];
        if up < 0.0 {
            tube = tube.flipped();
        }
        let all = found(&turned(&tube, 0.4), 0.4);
        assert_eq!(all.len(), 1, "{all:?}");
        let Crown { diameter_mm, low_mm: low, high_mm: high, sagitta_mm, .. } = all[0].crown.unwrap();
        assert!(low <= 5.0 + 1e-9 && 5.0 <= high + 1e-9 && high - low < 2.5, "{low} {high}");
        assert!((diameter_mm - 5.0).abs() <= sagitta_mm + 1e-9, "{diameter_mm} {sagitta_mm}");
    }

    /// A tube of `n` sides, corners on a circle of `diameter`, its axis turned by `turn` from +y in plan and climbing by `climb`; each of
    /// its edges goes from `mouths[0]` to `mouths[1]`, as far along y as these say at x.
    fn tunnel(n: usize, diameter: f64, way: [f64; 2], mouths: [&dyn Fn(f64) -> f64; 2]) -> TriangleMesh {
        phased_tunnel((n, 0.0), diameter, way, mouths)
    }

    /// The same with its corners turned about the axis by a share of a facet.
    fn phased_tunnel(
        (n, phase): (usize, f64),
        diameter: f64,
        [turn, climb]: [f64; 2],
        mouths: [&dyn Fn(f64) -> f64; 2],
    ) -> TriangleMesh {
        let way = [-turn.sin() * climb.cos(), turn.cos() * climb.cos(), climb.sin()];
        let level = [turn.cos(), turn.sin(), 0.0];
        let up = cross(level, way);
        let end = |i: usize, mouth: &dyn Fn(f64) -> f64| {
            let (s, c) = (std::f64::consts::TAU * ((i % n) as f64 + phase) / n as f64).sin_cos();
            let on = [0, 1, 2].map(|k| 0.5 * diameter * (c * level[k] + s * up[k]));
            let at = |t: f64| [0, 1, 2].map(|k| on[k] + t * way[k]);
            // A mouth that bends is met after a few steps.
            let t = (0..60).fold(0.0, |t, _| t + (mouth(at(t)[0]) - at(t)[1]) / way[1]);
            let [x, y, z] = at(t);
            [x, y, z + 30.0]
        };
        let mut facets = Vec::new();
        for i in 0..n {
            let [a, b] = [i, i + 1].map(|i| mouths.map(|m| end(i, m)));
            facets.extend([[a[0], b[1], b[0]], [a[0], a[1], b[1]]]);
        }
        let tube = TriangleMesh::weld(facets);
        // What hangs over is the upper half, which looks down at the axis.
        let top = (0..tube.triangles.len()).max_by(|&f, &g| tube.centroid(f)[2].total_cmp(&tube.centroid(g)[2]));
        if tube.normal(top.unwrap())[2] > 0.0 { tube.flipped() } else { tube }
    }

    #[test]
    fn an_oblique_or_climbing_hole_has_the_diameter_of_its_cylinder() {
        let mouths: [&dyn Fn(f64) -> f64; 2] = [&|_| 0.0, &|_| 20.0];
        for (turn, climb) in [(0.0, 0.0), (0.8, 0.0), (-0.4, 0.0), (0.0, 0.35), (0.0, -0.52), (0.5, 0.3), (-0.8, -0.2)]
        {
            for (n, diameter) in [(64, 10.0), (48, 4.5), (24, 6.3)] {
                let all = found(&turned(&tunnel(n, diameter, [turn, climb], mouths), 0.9 * turn + climb), 0.4);
                assert_eq!(all.len(), 1, "{turn} {climb}: {all:?}");
                let crown = all[0].crown.unwrap_or_else(|| panic!("{turn} {climb} {n}: {:?}", all[0]));
                let (low, high) = (crown.low_mm, crown.high_mm);
                assert!(low <= diameter + 1e-6 && diameter <= high + 1e-6, "{turn} {climb} {n}: {crown:?}");
                let off = (crown.diameter_mm - diameter).abs();
                assert!(off <= crown.sagitta_mm + 1e-6, "{turn} {climb} {n}: {crown:?}");
                assert!((crown.grade - climb.tan().abs()).abs() < 1e-6, "{climb}: {crown:?}");
            }
        }
    }

    #[test]
    fn a_hole_has_its_diameter_wherever_its_facets_begin() {
        let mouths: [&dyn Fn(f64) -> f64; 2] = [&|_| 0.0, &|_| 15.0];
        // Where a facet turns by more than the slopes of a crown, the crown is one or two of them.
        let coarse = [10, 12, 13, 15, 16, 17, 24].map(|n| (45.0, n));
        for (degrees, n) in coarse.into_iter().chain([32, 48, 64].into_iter().flat_map(|n| [(45.0, n), (19.0, n)])) {
            for phase in (0..20).map(|n| 0.05 * f64::from(n)) {
                let mesh = turned(&phased_tunnel((n, phase), 8.0, [0.0; 2], mouths), 0.3);
                let all = found_within(&mesh, degrees, [0.4, 2.0]);
                let crown =
                    all.first().and_then(|c| c.crown).unwrap_or_else(|| panic!("{degrees} {n} {phase}: {all:?}"));
                let off = (crown.diameter_mm - 8.0).abs();
                assert!(all.len() == 1 && off <= 1e-6, "{degrees} {n} {phase}: {crown:?}");
            }
        }
    }

    #[test]
    fn a_hole_with_round_ends_is_the_hole_that_it_is_with_flat_ones() {
        // A capsule: rings of 30 sides, those of its ends ever smaller.
        let (sides, radius) = (30, 2.17);
        let ring = |k: i32, n: usize| {
            let over = (f64::from(k.abs()) - 1.0) * 17f64.to_radians();
            let (s, c) = (std::f64::consts::TAU * (n % 30) as f64 / f64::from(sides)).sin_cos();
            let y = f64::from(k.signum()) * (4.0 + radius * over.sin());
            [radius * over.cos() * s, y, 9.0 + radius * over.cos() * c]
        };
        let rings: Vec<i32> = (-5..=5).filter(|k| *k != 0).collect();
        let mut facets = Vec::new();
        for (k, l) in rings.iter().zip(rings.iter().skip(1)) {
            for n in 0..sides as usize {
                let [a, b, c, d] = [ring(*k, n), ring(*k, n + 1), ring(*l, n + 1), ring(*l, n)];
                facets.extend([[a, b, c], [a, c, d]]);
            }
        }
        let tube = TriangleMesh::weld(facets);
        let top = (0..tube.triangles.len()).max_by(|&f, &g| tube.centroid(f)[2].total_cmp(&tube.centroid(g)[2]));
        let tube = if tube.normal(top.unwrap())[2] > 0.0 { tube.flipped() } else { tube };
        for turn in [0.0, 0.6] {
            for ledge in [0.1, 1.0] {
                let all = found_within(&turned(&tube, turn), 19.0, [ledge, 2.5]);
                let crown = all.iter().find_map(|c| c.crown).unwrap_or_else(|| panic!("{all:?}"));
                assert!((crown.diameter_mm - 2.0 * radius).abs() <= crown.sagitta_mm + 0.1, "{crown:?}");
            }
        }
    }

    #[test]
    fn a_hole_whose_crown_is_narrower_than_two_ledges_has_a_diameter() {
        let mouths: [&dyn Fn(f64) -> f64; 2] = [&|_| 0.0, &|_| 15.0];
        let holding = SelfHolding { bridge_mm: Some(2.5), ledge_mm: Some(1.0), crown_mm: Some(5.0) };
        for (n, diameter) in [(48, 5.1), (96, 5.1), (96, 5.6), (200, 4.9), (48, 4.6), (96, 8.0)] {
            for turn in [0.0, 0.7] {
                let mesh = turned(&tunnel(n, diameter, [0.0; 2], mouths), turn);
                let all = found_within(&mesh, 19.0, [1.0, 2.5]);
                assert_eq!(all.len(), 1, "{all:?}");
                let crown = all[0].crown.unwrap_or_else(|| panic!("{n} {diameter}: {:?}", all[0]));
                assert!((crown.diameter_mm - diameter).abs() <= crown.sagitta_mm + 1e-6, "{n} {diameter}: {crown:?}");
                assert_eq!(holding.holds(&all[0]), diameter < 5.0, "{n} {diameter}: {:?}", all[0]);
            }
        }
    }

    #[test]
    fn a_tube_whose_rings_have_other_corners_is_as_wide_as_its_rings() {
        // Facets that stand on one ring hang over up to 18.75°, those that stand on the other go on at 19.3°.
        let (radius, steps) = (2.17, [12.5f64, 11.5]);
        let corner = |ring: usize, n: i32| {
            let (s, c) = (steps[ring] * (f64::from(n) - [0.0, 0.18][ring])).to_radians().sin_cos();
            [radius * s, 3.0 * ring as f64, 9.0 + radius * c]
        };
        let mut facets = Vec::new();
        for n in -7..7 {
            let [a, b, c, d] = [corner(0, n), corner(0, n + 1), corner(1, n + 1), corner(1, n)];
            facets.extend([[a, b, c], [a, c, d]]);
        }
        let tube = TriangleMesh::weld(facets);
        let tube = if tube.normal(14)[2] > 0.0 { tube.flipped() } else { tube };
        for turn in [0.0, 0.6] {
            let all = found_within(&turned(&tube, turn), 19.0, [1.0, 2.5]);
            let diameters: Vec<f64> = all.iter().filter_map(|c| c.crown).map(|c| c.diameter_mm).collect();
            assert!(!diameters.is_empty() && diameters.iter().all(|d| (3.9..4.8).contains(d)), "{all:?}");
        }
    }

    #[test]
    fn a_small_dome_within_two_ledges_is_held_all_round() {
        let mut facets = Vec::new();
        let at = |ring: i32, n: i32| {
            let (over, about) = (f64::from(ring) * 0.1, std::f64::consts::TAU * f64::from(n % 40) / 40.0);
            [2.8 * over.sin() * about.cos(), 2.8 * over.sin() * about.sin(), 9.0 + 2.8 * over.cos()]
        };
        for (ring, n) in (0..14).flat_map(|r| (0..40).map(move |n| (r, n))) {
            let [a, b, c, d] = [at(ring, n), at(ring + 1, n), at(ring + 1, n + 1), at(ring, n + 1)];
            facets.extend([[a, b, c], [a, c, d]].into_iter().filter(|[p, q, r]| p != q && q != r && p != r));
        }
        let dome = TriangleMesh::weld(facets).flipped();
        let all = found_within(&dome, 19.0, [1.0, 2.5]);
        assert!(all.len() == 1 && all[0].crown.is_none() && all[0].bridge.is_none(), "{all:?}");
    }

    #[test]
    fn a_ledge_along_a_wall_between_two_walls_is_no_bridge_from_one_to_the_other() {
        // A shelf in a niche: a wall behind it and one at either end.
        let niche = |long: f64, deep: f64| {
            let p = |x: f64, y: f64, z: f64| [x, y, z];
            let quads = [
                [p(0.0, 0.0, 6.0), p(0.0, deep, 6.0), p(long, deep, 6.0), p(long, 0.0, 6.0)],
                [p(0.0, deep, 6.0), p(0.0, deep, 0.0), p(long, deep, 0.0), p(long, deep, 6.0)],
                [p(0.0, 0.0, 6.0), p(0.0, 0.0, 0.0), p(0.0, deep, 0.0), p(0.0, deep, 6.0)],
                [p(long, 0.0, 6.0), p(long, deep, 6.0), p(long, deep, 0.0), p(long, 0.0, 0.0)],
            ];
            TriangleMesh::weld(quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]))
        };
        let told = |long: f64, deep: f64, limits: [f64; 2]| {
            let mut all = found_within(&turned(&niche(long, deep), 0.3), 45.0, limits);
            assert_eq!(all.len(), 1, "{all:?}");
            all.remove(0)
        };
        for (long, deep, limits) in [(9.2, 0.584, [0.5, 2.0]), (35.2, 2.3, [1.0, 2.5]), (40.0, 1.1, [0.4, 10.0])] {
            let c = told(long, deep, limits);
            let ledge = c.cantilever.unwrap_or_else(|| panic!("{c:?}"));
            assert!(c.is_beside && c.bridge.is_none_or(|b| b.high_mm <= limits[1] + 1e-5), "{c:?}");
            assert!(ledge.low_mm <= deep + 1e-9 && deep <= ledge.high_mm + 1e-9, "{c:?}");
            assert!(ledge.low_mm > 0.97 * deep && ledge.high_mm < 1.03 * deep, "{c:?}");
        }
        // As deep as that, the walls at its ends are the nearer hold.
        let c = told(12.0, 3.0, [0.4, 10.0]);
        let bridge = c.bridge.unwrap_or_else(|| panic!("{c:?}"));
        assert!((bridge.low_mm - 12.0).abs() < 1e-6 && bridge.high_mm < 12.2 && c.cantilever.is_none(), "{c:?}");
        // A shelf that keeps the limit keeps it.
        let c = told(9.2, 0.49, [0.5, 2.0]);
        assert!(c.cantilever.is_none() && c.bridge.is_none(), "{c:?}");
    }

    #[test]
    fn a_hole_that_leaves_by_a_round_face_is_the_hole_that_it_is_in_a_block() {
        let holding = SelfHolding { bridge_mm: Some(10.0), ledge_mm: Some(0.4), crown_mm: Some(6.0) };
        let radius = 20.0f64;
        let mouths: [&dyn Fn(f64) -> f64; 2] =
            [&|x| -(radius * radius - x * x).sqrt(), &|x| (radius * radius - x * x).sqrt()];
        for (diameter, held) in [(3.0, true), (8.0, false)] {
            for turn in [0.0, 0.3, 2.0] {
                let all = found(&turned(&tunnel(64, diameter, [0.0; 2], mouths), turn), 0.4);
                assert_eq!(all.len(), 1, "{all:?}");
                let crown = all[0].crown.unwrap();
                assert!((crown.diameter_mm - diameter).abs() <= crown.sagitta_mm + 1e-6, "{crown:?}");
                assert!(all[0].cantilever.is_none(), "{all:?}");
                assert_eq!(holding.holds(&all[0]), held, "{diameter}");
            }
        }
    }

    #[test]
    fn a_collar_within_the_limit_holds_itself() {
        let holding = SelfHolding { ledge_mm: Some(0.4), ..SelfHolding::default() };
        let n = 128;
        for width in [0.39, 0.399, 0.4, 0.41, 0.6] {
            let at = |i: usize, r: f64, z: f64| {
                let (s, c) = (std::f64::consts::TAU * (i % n) as f64 / n as f64).sin_cos();
                [r * c, r * s, z]
            };
            let mut facets = Vec::new();
            let wide = 5.0 + width;
            for i in 0..n {
                let [a, b, c, d] = [at(i, 5.0, 0.0), at(i + 1, 5.0, 0.0), at(i + 1, 5.0, 10.0), at(i, 5.0, 10.0)];
                facets.extend([[a, b, c], [a, c, d]]);
                let [e, f] = [at(i + 1, wide, 10.0), at(i, wide, 10.0)];
                facets.extend([[d, c, e], [d, e, f]]);
            }
            let all = found(&turned(&TriangleMesh::weld(facets), 0.7), 0.4);
            assert_eq!(all.len(), 1, "{all:?}");
            assert_eq!(holding.holds(&all[0]), width <= 0.4, "{width}: {:?}", all[0].cantilever);
        }
    }

    #[test]
    fn the_underside_of_a_lying_cylinder_between_walls_is_bridged_layer_by_layer() {
        let at = |i: i32, y: f64, low: bool| {
            let (s, c) = (f64::from(i) * 14.4f64.to_radians()).sin_cos();
            [5.0 * s, y, if low { 0.0 } else { 9.0 - 5.0 * c }]
        };
        let mut facets = Vec::new();
        for i in -3..3 {
            let quads = [
                [at(i, 0.0, false), at(i, 3.5, false), at(i + 1, 3.5, false), at(i + 1, 0.0, false)],
                [at(i, 0.0, true), at(i, 0.0, false), at(i + 1, 0.0, false), at(i + 1, 0.0, true)],
                [at(i, 3.5, false), at(i, 3.5, true), at(i + 1, 3.5, true), at(i + 1, 3.5, false)],
            ];
            facets.extend(quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]));
        }
        for turn in [0.0, 0.4, 2.0] {
            let all = found(&turned(&TriangleMesh::weld(facets.clone()), turn), 0.4);
            assert_eq!(all.len(), 1, "{all:?}");
            let span = all[0].bridge.unwrap();
            assert!(span.low_mm <= 3.5 + 1e-9 && 3.5 <= span.high_mm + 1e-9 && span.high_mm < 3.6, "{span:?}");
            assert!(all[0].is_level && all[0].crown.is_none() && all[0].flat_share < 0.5, "{all:?}");
            let holding =
                |bridge: f64| SelfHolding { bridge_mm: Some(bridge), crown_mm: Some(9.0), ..SelfHolding::default() };
            assert!(holding(4.0).holds(&all[0]) && !holding(3.0).holds(&all[0]));
        }
    }

    #[test]
    fn a_strand_that_climbs_is_no_bridge() {
        // The roof of a lean-to, open at both gables, between a low wall and a high one.
        for (degrees, holds) in [(2.5f64, true), (10.0, false), (30.0, false)] {
            let top = 3.0 + 6.0 * degrees.to_radians().tan();
            let at = |x: f64, y: f64, z: f64| [x, y, z];
            let quads = [
                [at(0.0, 0.0, 3.0), at(0.0, 20.0, 3.0), at(6.0, 20.0, top), at(6.0, 0.0, top)],
                [at(0.0, 0.0, 0.0), at(0.0, 20.0, 0.0), at(0.0, 20.0, 3.0), at(0.0, 0.0, 3.0)],
                [at(6.0, 0.0, top), at(6.0, 20.0, top), at(6.0, 20.0, 0.0), at(6.0, 0.0, 0.0)],
            ];
            let facets = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
            let all = found(&turned(&TriangleMesh::weld(facets), 0.3), 0.4);
            assert_eq!(all.len(), 1, "{all:?}");
            let most = SelfHolding { bridge_mm: Some(10.0), crown_mm: Some(8.0), ledge_mm: Some(0.4) };
            assert!(all[0].crown.is_none() && most.holds(&all[0]) == holds, "{degrees}: {all:?}");
        }
    }

    #[test]
    fn the_underside_of_a_ball_is_no_bridge() {
        let mut facets = Vec::new();
        let ring = |lat: f64, i: usize| {
            let lon = std::f64::consts::TAU * i as f64 / 24.0;
            [5.0 * lat.sin() * lon.cos(), 5.0 * lat.sin() * lon.sin(), 9.0 - 5.0 * lat.cos()]
        };
        for k in 0..8 {
            let (a, b) = (0.1 * k as f64, 0.1 * (k + 1) as f64);
            for i in 0..24 {
                facets.push([ring(a, i), ring(b, i + 1), ring(b, i)]);
                facets.push([ring(a, i), ring(a, i + 1), ring(b, i + 1)]);
            }
        }
        let cap = TriangleMesh::weld(facets.into_iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]));
        let all = found(&cap, 0.4);
        assert!(all.iter().all(|c| c.bridge.is_none() && c.crown.is_none()), "{all:?}");
    }
}
