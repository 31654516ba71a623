//! What hangs over in a process, and what of it holds itself: read by overhang, bridge, support and support-access.

use super::contract::limits_of;
use crate::access::self_holding;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, add, along, bounds, sub};
use crate::layer::{
    Ceiling, FLAT, Ground, Measuring, Search, ceilings, clip_below, downward_facets, lies_below, share_below,
};
use crate::part::Part;
use crate::process::Process;
use crate::units::Angle;
use rayon::prelude::*;
use std::sync::Arc;

/// Pairs of a line and a side that may tell whether a span with ribs under it is within its limit.
const TELLING: u64 = 100_000_000;

/// Pairs of a line and a side that may tell whether a ceiling reaches beyond a ledge.
const OPEN: u64 = 20_000_000;

/// The rule of the longest bridge.
pub const BRIDGE: &str = "bridge";
/// The rule of the farthest ledge.
pub const LEDGE: &str = "bridge.ledge";
/// The rule of the widest round passage that lies across the build direction.
pub const CROWN: &str = "bridge.horizontal-hole";

/// The angle from the horizontal below which downward surface needs support, degrees: the stricter of the overhang limits.
pub fn support_angle(process: &Process) -> Option<f64> {
    let limits = limits_of(process, "overhang")?;
    Some(limits.fail.unwrap_or(0.0).max(limits.warn.unwrap_or(0.0)))
}

/// What supports can do for surface that hangs over, least first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Supports {
    /// The process prints none.
    None,
    /// They hold it and stay in the void that it bounds, which is sealed.
    Stay,
    /// They hold it, and nothing says that they cannot be taken out.
    Hold,
}

impl Supports {
    /// Below facets that hang over.
    pub fn below(part: &Part, process: &Process, facets: &[u32]) -> Self {
        match process.prints_supports {
            false => Supports::None,
            true if facets.iter().all(|&f| part.bounds_sealed_void(f as usize)) => Supports::Stay,
            true => Supports::Hold,
        }
    }
}

/// The facets of the solid that look down at less than the process' angle, off the plate, with no body right below them.
fn hanging(part: &Part, process: &Process) -> Vec<u32> {
    let Some(angle) = support_angle(process) else { return Vec::new() };
    downward_facets(part.mesh(), plate_z(process), Angle::degrees(angle), part.step())
        .into_par_iter()
        .with_max_len(64)
        .filter(|&f| !covered(part, f) && !rests(part, f, process.layer_height_mm))
        .collect()
}

/// Whether there is material no more than a layer below a whole facet: what is laid there rests on it, as on a support.
fn rests(part: &Part, facet: u32, layer_mm: f64) -> bool {
    let corners = part.mesh().corners(facet as usize);
    let middle = part.mesh().centroid(facet as usize);
    let below = |p: Vec3| {
        let from = along(p, part.mesh().normal(facet as usize), 2.0 * part.step());
        part.distance().first_hit(from, [0.0, 0.0, -1.0], 0.0, layer_mm + 4.0 * part.step()).is_some()
    };
    below(middle) && corners.iter().all(|&c| below(along(middle, sub(c, middle), 0.98)))
}

/// What of the part lies no more than a layer below its own facets, and the plate.
struct Below<'a> {
    part: &'a Part,
    layer_mm: f64,
    plate_z: f64,
}

impl<'a> Below<'a> {
    fn of(part: &'a Part, process: &Process) -> Self {
        Below { part, layer_mm: process.layer_height_mm, plate_z: plate_z(process) }
    }

    /// The part of a ceiling's facet that lies on the plate, as triangles; of a steeper one that is a narrow strip.
    fn on_plate(&self, facet: u32) -> impl Iterator<Item = [Vec3; 3]> {
        let mesh = self.part.mesh();
        let is_flat = mesh.normal(facet as usize)[2] <= -FLAT.cos();
        let low = if is_flat { clip_below(mesh.corners(facet as usize), self.plate_z) } else { Vec::new() };
        (1..low.len().saturating_sub(1)).map(move |n| [low[0], low[n], low[n + 1]])
    }
}

impl Ground for Below<'_> {
    fn holds(&self, facet: u32) -> bool {
        // What looks up has its own material right below it.
        let looks_down = self.part.mesh().normal(facet as usize)[2] < 0.0;
        covered(self.part, facet) || looks_down && rests(self.part, facet, self.layer_mm)
    }

    fn beneath(&self, facet: u32) -> Vec<[Vec3; 3]> {
        let (mesh, tie) = (self.part.mesh(), 4.0 * self.part.step());
        let corners = mesh.corners(facet as usize);
        let Some((lo, hi)) = bounds(corners) else { return Vec::new() };
        let reach = ([lo[0], lo[1], lo[2] - self.layer_mm - tie], [hi[0], hi[1], hi[2] + tie]);
        let mut found = Vec::new();
        self.part.distance().tree().in_box(reach, |g| {
            let carries = g != facet && mesh.normal(g as usize)[2] > 0.0 && self.part.bounds_solid(g as usize);
            // The two sides of an upright wall that leans by its rounding overlap in plan by that.
            let height = [-tie, self.layer_mm + tie];
            if carries && lies_below(corners, mesh.corners(g as usize), height, 2.0 * tie) {
                found.push(g);
            }
        });
        // In the order of the facets, whatever the tree.
        found.sort_unstable();
        found.into_iter().map(|g| mesh.corners(g as usize)).chain(self.on_plate(facet)).collect()
    }
}

/// A ceiling alone, with ribs under it that hold it up.
struct Ribbed<'a> {
    below: Below<'a>,
    /// The numbers that its facets and their neighbours have in the part.
    numbers: Vec<u32>,
    /// What the ribs cover, in plan.
    ribs: &'a [[Vec3; 3]],
}

impl Ribbed<'_> {
    fn number(&self, facet: u32) -> Option<u32> {
        self.numbers.get(facet as usize).copied()
    }
}

impl Ground for Ribbed<'_> {
    fn holds(&self, facet: u32) -> bool {
        self.number(facet).is_some_and(|f| self.below.holds(f))
    }

    fn beneath(&self, facet: u32) -> Vec<[Vec3; 3]> {
        let own = self.number(facet).map_or(Vec::new(), |f| self.below.beneath(f));
        own.into_iter().chain(self.ribs.iter().copied()).collect()
    }
}

/// A ceiling measured again as [`ceilings_of`] measures it, with ribs under it: triangles that tell what they cover in plan.
///
/// # Cost
/// That of the ceiling's own search; no more of the part is looked at than lies about it.
pub fn respanned(part: &Part, process: &Process, ceiling: &Ceiling, ribs: &[[Vec3; 3]]) -> Vec<Ceiling> {
    let mut numbers = Vec::new();
    let around = part.tie() + 1e-6;
    let (mut lo, hi) = (ceiling.extent.0.map(|x| x - around), ceiling.extent.1.map(|x| x + around));
    lo[2] -= process.layer_height_mm;
    part.distance().tree().in_box((lo, hi), |f| numbers.push(f));
    numbers.sort_unstable();
    let mesh = TriangleMesh::weld(numbers.iter().map(|&f| part.mesh().corners(f as usize)));
    let own = |f: &u32| numbers.binary_search(f).ok().map(|at| at as u32);
    let hanging: Vec<u32> = ceiling.facets.iter().filter_map(own).collect();
    let how = measuring(part, process, Search::Measure);
    let ground = Ribbed { below: Below::of(part, process), numbers, ribs };
    let quickly = ceilings(&mesh, &hanging, Measuring { search: Search::Judge, ..how }, &ground);
    // A quick search that finds nothing in its way has looked at all of it.
    let limit = self_holding(process).bridge_mm.unwrap_or(0.0);
    let within = |c: &Ceiling| c.cantilever.is_none() && c.bridge.is_none_or(|b| b.high_mm <= limit);
    if quickly.iter().all(within) {
        return quickly;
    }
    let measured = ceilings(&mesh, &hanging, how, &ground);
    let open = |c: &Ceiling| c.bridge.is_some_and(|b| b.low_mm <= limit && limit < b.high_mm);
    if !measured.iter().any(open) {
        return measured;
    }
    let search = Search::Tell { beyond: [limit, 0.0], pairs: TELLING };
    ceilings(&mesh, &hanging, Measuring { search, ..how }, &ground)
}

/// Whether material lies no more than a layer below any of an underside, or around it.
///
/// Bodies that cross are looked for below 15 places of each facet; what lies below without crossing is found exactly.
pub fn is_carried(part: &Part, underside: &[u32], layer_mm: f64) -> bool {
    let ground = Below { part, layer_mm, plate_z: f64::NEG_INFINITY };
    let inside_another = |f: u32| {
        let [a, b, c] = part.mesh().corners(f as usize);
        let place = |i: usize, j: usize| {
            let [u, v] = [i, j].map(|n| 0.02 + 0.235 * n as f64);
            [0, 1, 2].map(|x| a[x] + u * (b[x] - a[x]) + v * (c[x] - a[x]))
        };
        let mut places = (0..5).flat_map(|i| (0..5 - i).map(move |j| (i, j)));
        let below = [0.0, 0.0, -20.0 * part.step()];
        places.any(|(i, j)| part.winding().at(add(place(i, j), below)) >= 0.5)
    };
    underside
        .iter()
        .any(|&f| covered(part, f) || !ground.beneath(f).is_empty() || !part.is_plain() && inside_another(f))
}

/// Up to this height a layer lies on the plate: half a layer.
pub fn plate_z(process: &Process) -> f64 {
    0.5 * process.layer_height_mm
}

/// The ceilings that hanging facets make, measured between their anchors; shared by all checks of a part.
pub fn ceilings_of(part: &Part, process: &Process) -> Arc<Vec<Ceiling>> {
    let how = measuring(part, process, Search::Measure);
    let key = [support_angle(process).unwrap_or(0.0), process.layer_height_mm, how.ledge_mm, how.bridge_mm];
    part.ceilings(key, || {
        let below = Below::of(part, process);
        let found = ceilings(part.mesh(), &hanging(part, process), how, &below);
        told_from_ledges(part, found, how, &below)
    })
}

/// Ceilings of which a first look does not show whether they reach beyond a ledge, looked at again for that alone: overhang and
/// bridge read the same answer.
fn told_from_ledges(part: &Part, mut found: Vec<Ceiling>, how: Measuring, below: &Below) -> Vec<Ceiling> {
    let is_open = |c: &Ceiling| c.cantilever.is_some_and(|r| r.low_mm == 0.0);
    let mut open: Vec<u32> = found.iter().filter(|c| is_open(c)).flat_map(|c| c.facets.clone()).collect();
    if open.is_empty() {
        return found;
    }
    open.sort_unstable();
    let search = Search::Tell { beyond: [f64::INFINITY, 0.0], pairs: OPEN };
    let told = ceilings(part.mesh(), &open, Measuring { search, ..how }, below);
    for c in found.iter_mut().filter(|c| is_open(c)) {
        if let Some(again) = told.iter().find(|t| t.facets == c.facets) {
            (c.cantilever, c.is_beside) = (again.cantilever, again.is_beside);
            c.pairs += again.pairs;
        }
    }
    found
}

/// A ceiling measured again, so that its spans are told from limits if so many pairs of lines and sides allow; places that
/// do not reach beyond `beyond` (bridge, ledge) are left as they are.
pub fn looked_at_again(part: &Part, process: &Process, c: &Ceiling, beyond: [f64; 2], pairs: u64) -> Option<Ceiling> {
    let how = measuring(part, process, Search::Tell { beyond, pairs });
    let below = Below::of(part, process);
    ceilings(part.mesh(), &c.facets, how, &below).into_iter().find(|again| again.facets == c.facets)
}

fn measuring(part: &Part, process: &Process, search: Search) -> Measuring {
    let holding = self_holding(process);
    let (ledge_mm, bridge_mm) = (holding.ledge_mm.unwrap_or(0.0), holding.bridge_mm.unwrap_or(f64::INFINITY));
    let layer_mm = process.layer_height_mm;
    Measuring { plate_z: plate_z(process), layer_mm, ledge_mm, bridge_mm, step_mm: part.step(), search }
}

/// The facets that need support: what hangs over and does not hold itself, in increasing order.
pub fn needing_support(part: &Part, process: &Process) -> Vec<u32> {
    let holding = self_holding(process);
    let mut facets: Vec<u32> =
        ceilings_of(part, process).iter().filter(|c| !holding.holds(c)).flat_map(|c| c.facets.clone()).collect();
    facets.sort_unstable();
    facets
}

/// The share of a facet in plan that rests on nothing: neither on the plate nor on what lies no more than a layer below.
pub fn hanging_share(part: &Part, process: &Process, facet: u32) -> f64 {
    let under = Below::of(part, process).beneath(facet);
    1.0 - share_below(part.mesh().corners(facet as usize), &under)
}

/// Whether material touches a facet from below, or the facet does not bound the solid.
pub fn covered(part: &Part, facet: u32) -> bool {
    if !part.bounds_solid(facet as usize) {
        return true;
    }
    !part.is_plain() && part.is_inside_before(facet, 20.0 * part.step())
}
