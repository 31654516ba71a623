//! What hangs over in a process, and what of it holds itself: read by overhang, bridge, support and support-access.

use crate::access::{self_holding, standing, support_angle, upright};
use crate::geometry::TriangleMesh;
use crate::geometry::halfspace::cut;
use crate::geometry::vector::{Vec3, add, dot, scale};
use crate::layer::{
    Below, Ceiling, Floors, Ground, Island, Measuring, Search, SupportVolume, Unheld, ceilings, islands,
};
use crate::part::Part;
use crate::process::Process;
use crate::units::Angle;
use std::sync::Arc;

/// Pairs of a line and a side that may tell whether a span with ribs under it is within its limit.
const TELLING: u64 = 100_000_000;
/// Such pairs that may tell whether a ceiling holds itself that the first look leaves open, before any of the budget is spent.
const AGAIN: u64 = 60_000_000;
/// Such pairs that take as long as a sample.
pub const PAIRS: u64 = 4;

/// The rule of the longest bridge.
pub const BRIDGE: &str = "bridge";
/// The rule of the farthest ledge.
pub const LEDGE: &str = "bridge.ledge";
/// The rule of the widest round passage that lies across the build direction.
pub const CROWN: &str = "bridge.horizontal-hole";

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

/// What lies no more than a layer below a part's own facets, and the plate.
fn below_in<'a>(part: &'a Part, process: &Process) -> Below<'a, Part> {
    Below::of((part.mesh(), part.floors()), part, process.layer_height_mm, (plate_z(process), part.step()))
}

/// A ceiling alone, with ribs under it that hold it up.
struct Ribbed<'a> {
    below: Below<'a, Part>,
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
    let ground = Ribbed { below: below_in(part, process), numbers, ribs };
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
    ceilings(&mesh, &hanging, how.telling(0.0, TELLING), &ground)
}

/// The islands of a part that nothing carries, as it stands, lowest first.
///
/// # Cost
/// That of [`islands`], and a look below the first layer of each.
pub fn islands_of(part: &Part, process: &Process) -> Vec<Island> {
    begun(part, process, (part.mesh(), part.floors()), [0.0, 0.0, 1.0])
}

/// The islands that nothing carries of a part that stands with a direction of it up, in the frame of [`standing`], lowest first.
///
/// # Cost
/// That of [`islands_of`], and the floors of the part.
pub fn islands_turned(part: &Part, process: &Process, up: Vec3) -> Vec<Island> {
    let mesh = standing(part.mesh(), &upright(up));
    begun(part, process, (&mesh, &Floors::of(&mesh, part)), up)
}

fn begun(part: &Part, process: &Process, (mesh, floors): (&TriangleMesh, &Floors), up: Vec3) -> Vec<Island> {
    let (layer_mm, step) = (process.layer_height_mm, part.step());
    let below = Below::of((mesh, floors), part, layer_mm, (f64::NEG_INFINITY, step));
    let carrying = Carrying { part, below, up, layer_mm };
    islands(mesh, plate_z(process), layer_mm, step).into_iter().filter(|i| !carrying.carries(i)).collect()
}

/// What carries islands of a part that stands with a direction of it up.
struct Carrying<'a> {
    part: &'a Part,
    below: Below<'a, Part>,
    up: Vec3,
    layer_mm: f64,
}

impl Carrying<'_> {
    /// Whether other material lies no more than a layer below any of an island's first layer, or around it.
    ///
    /// Bodies that cross are looked for below 15 places of each piece of its facets; what lies below without crossing is found exactly.
    fn carries(&self, island: &Island) -> bool {
        let part = self.part;
        let top = island.lowest[2] + self.layer_mm;
        let is_other = |g: &u32| island.own_floors.binary_search(g).is_err();
        let rests = |f: u32| self.below.floors_under(f, top).any(|g| is_other(&g));
        let crossed = |f: u32| !part.is_plain() && self.lies_in_another(island, f);
        let carried = |f: u32| !part.bounds_solid(f as usize) || rests(f) || crossed(f);
        island.underside.iter().any(|&f| carried(f))
    }

    /// Whether what of a facet belongs to an island's first layer lies in another body.
    fn lies_in_another(&self, island: &Island, facet: u32) -> bool {
        // The facets are the same, however the part stands.
        let corners = |f: u32| self.part.mesh().corners(f as usize);
        let height = |p: Vec3| dot(p, self.up);
        let lowest = corners(island.facet).map(height).into_iter().fold(f64::INFINITY, f64::min);
        let first = cut(&corners(facet), |p| lowest + self.layer_mm - height(p));
        let down = scale(self.up, -20.0 * self.part.step());
        let place = |[a, b, c]: [Vec3; 3], i: usize, j: usize| {
            let [u, v] = [i, j].map(|n| 0.02 + 0.235 * n as f64);
            [0, 1, 2].map(|x| a[x] + u * (b[x] - a[x]) + v * (c[x] - a[x]))
        };
        let pieces = (1..first.len().saturating_sub(1)).map(|n| [first[0], first[n], first[n + 1]]);
        let mut places = pieces.flat_map(|t| (0..5).flat_map(move |i| (0..5 - i).map(move |j| place(t, i, j))));
        places.any(|p| self.part.winding().at(add(p, down)) >= 0.5)
    }
}

/// Up to this height a layer lies on the plate: half a layer.
pub fn plate_z(process: &Process) -> f64 {
    0.5 * process.layer_height_mm
}

/// The ceilings that hanging facets make, measured between their anchors; shared by all checks of a part that have the same budget.
///
/// # Cost
/// That of [`Below::ceilings`], and for what may or may not hold itself then a search of up to 60 million pairs of a line and a side for each
/// ceiling, and of what a budget of `refine` samples allows for all of them.
pub fn ceilings_of(part: &Part, process: &Process, refine: u64) -> Arc<Vec<Ceiling>> {
    let (how, holding) = (measuring(part, process, Search::Measure), self_holding(process));
    let angle = support_angle(process).unwrap_or(0.0);
    part.ceilings([angle, process.layer_height_mm, how.ledge_mm, how.bridge_mm, refine as f64], || {
        let below = below_in(part, process);
        let first = below.ceilings(Angle::degrees(angle), how);
        let open = first.iter().filter(|c| holding.is_open(c)).count() as u64;
        below.told(first, &holding, how, AGAIN.saturating_add(PAIRS.saturating_mul(refine) / open.max(1)))
    })
}

/// Samples of the budget that telling once more of a ceiling whether it holds itself has taken; `None` where the first 60 million pairs did.
pub fn told_with(c: &Ceiling) -> Option<u64> {
    (c.again > AGAIN).then(|| (c.again - AGAIN) / PAIRS)
}

/// A ceiling measured again, so that its spans are told from limits if so many pairs of lines and sides allow; places that
/// do not reach beyond `beyond` (bridge, ledge) are left as they are.
pub fn looked_at_again(part: &Part, process: &Process, c: &Ceiling, beyond: [f64; 2], pairs: u64) -> Option<Ceiling> {
    let how = measuring(part, process, Search::Tell { beyond, pairs });
    let below = below_in(part, process);
    ceilings(part.mesh(), &c.facets, how, &below).into_iter().find(|again| again.facets == c.facets)
}

fn measuring(part: &Part, process: &Process, search: Search) -> Measuring {
    let holding = self_holding(process);
    let (ledge_mm, bridge_mm) = (holding.ledge_mm.unwrap_or(0.0), holding.bridge_mm.unwrap_or(f64::INFINITY));
    let layer_mm = process.layer_height_mm;
    Measuring { plate_z: plate_z(process), layer_mm, ledge_mm, bridge_mm, step_mm: part.step(), search }
}

/// The facets that need support: what hangs over and does not hold itself.
pub fn needing_support(part: &Part, process: &Process, refine: u64) -> Unheld {
    self_holding(process).unheld(&ceilings_of(part, process, refine))
}

/// The share of a facet in plan that rests on nothing: neither on the plate nor on what lies no more than a layer below.
pub fn hanging_share(part: &Part, process: &Process, facet: u32) -> f64 {
    below_in(part, process).hanging_share(facet)
}

/// The supports that facets need, in columns so wide, and the bounds of the area that they touch: [`Below::supported`].
pub fn supported(part: &Part, process: &Process, unheld: &Unheld, column_mm: f64) -> (SupportVolume, [f64; 2]) {
    below_in(part, process).supported(unheld, column_mm)
}
