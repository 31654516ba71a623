//! What of a part lies no more than a layer below its own surface, and what of that surface hangs over.

use super::beneath::{Ground, resting_on, share_below};
use super::bridge::{Ceiling, FLAT, Measuring, ceilings};
use super::column::{SupportVolume, support_volume};
use super::downward::downward_facets;
use super::floor::Floors;
use super::reading::Search;
use super::section::clip_below;
use super::self_holding::{SelfHolding, Unheld};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, along, bounds, cross, sub};
use crate::units::Angle;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Pairs of a line and a side that may tell whether a ceiling reaches beyond a ledge.
const OPEN: u64 = 20_000_000;

/// What the facets of a mesh bound, however it is turned.
pub trait Bounding: Sync {
    /// Whether a facet bounds the solid.
    fn bounds_solid(&self, facet: usize) -> bool;

    /// Whether material touches a facet from outside, or the facet does not bound the solid.
    fn is_covered(&self, facet: u32) -> bool {
        !self.bounds_solid(facet as usize)
    }
}

/// Facets that bound the solid where a function says so, and that nothing touches.
impl<F: Fn(usize) -> bool + Sync> Bounding for F {
    fn bounds_solid(&self, facet: usize) -> bool {
        self(facet)
    }
}

/// What of hanging facets rests on something.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Carried {
    /// What lies on the plate with nothing between: its area in plan, mm², and the volume beneath it, mm³.
    pub lying: [f64; 2],
    /// The area in plan of what rests on material no more than a layer below, mm².
    pub resting_mm2: f64,
    /// The area of what hangs over nothing, mm².
    pub hanging_mm2: f64,
}

/// The material of a part no more than a layer below its own facets, and the plate.
pub struct Below<'a, B> {
    mesh: &'a TriangleMesh,
    floors: &'a Floors,
    facets: &'a B,
    layer_mm: f64,
    plate_z: f64,
    step_mm: f64,
}

impl<'a, B: Bounding> Below<'a, B> {
    /// Of a mesh with its floors: what lies up to `plate_z` lies on the plate.
    pub fn of(
        (mesh, floors): (&'a TriangleMesh, &'a Floors),
        facets: &'a B,
        layer_mm: f64,
        (plate_z, step_mm): (f64, f64),
    ) -> Self {
        Below { mesh, floors, facets, layer_mm, plate_z, step_mm }
    }

    /// The facets of the solid that look down at less than an angle, off the plate, with no body right below them.
    fn hanging(&self, angle: Angle) -> Vec<u32> {
        downward_facets(self.mesh, self.plate_z, angle, self.step_mm)
            .into_par_iter()
            .with_max_len(64)
            .filter(|&f| !self.facets.is_covered(f) && !self.rests(f))
            .collect()
    }

    /// The ceilings that the facets make which hang over at less than an angle, measured between their anchors.
    ///
    /// # Cost
    /// That of [`ceilings`], and a line or a few for each facet that looks down. Where a search does not show whether a ceiling reaches
    /// beyond a ledge, [`Search::Measure`] looks again for that alone: all who ask read the same answer.
    pub fn ceilings(&self, angle: Angle, how: Measuring) -> Vec<Ceiling> {
        let found = ceilings(self.mesh, &self.hanging(angle), how, self);
        if how.search == Search::Measure { self.told_from_ledges(found, how) } else { found }
    }

    /// Ceilings of which a first look leaves open whether they hold themselves, looked at once more for that alone with so many pairs of a
    /// line and a side each; the others as they are. What this does not tell keeps its first bounds.
    ///
    /// Where the first look has ruled out that anything reaches out, bridges alone are asked for.
    ///
    /// # Cost
    /// That of a [`Search::Tell`] for each that is open.
    pub fn told(&self, first: Vec<Ceiling>, holding: &SelfHolding, how: Measuring, pairs: u64) -> Vec<Ceiling> {
        let looks = [false, true].map(|reaches| {
            let is_asked = |c: &&Ceiling| holding.is_open(c) && c.cantilever.is_some() == reaches;
            let mut open: Vec<u32> = first.iter().filter(is_asked).flat_map(|c| c.facets.iter().copied()).collect();
            open.sort_unstable();
            let ledge_mm = if reaches { 0.0 } else { f64::INFINITY };
            let look = || ceilings(self.mesh, &open, how.telling(ledge_mm, pairs), self);
            if open.is_empty() { Vec::new() } else { look() }
        });
        let again: FxHashMap<u32, Ceiling> =
            looks.into_iter().flatten().filter_map(|c| Some((*c.facets.first()?, c))).collect();
        let closer = |c: &Ceiling| {
            let same = again.get(c.facets.first()?).filter(|again| again.facets == c.facets)?;
            let told = same.clone().narrowed_by(c);
            let Ceiling { pairs, again, bridge, .. } = told;
            Some(if holding.is_open(&told) { Ceiling { pairs, again, bridge, ..c.clone() } } else { told })
        };
        first.into_iter().map(|c| closer(&c).unwrap_or(c)).collect()
    }

    fn told_from_ledges(&self, mut found: Vec<Ceiling>, how: Measuring) -> Vec<Ceiling> {
        let is_open = |c: &Ceiling| c.cantilever.is_some_and(|r| r.low_mm == 0.0);
        let mut open: Vec<u32> = found.iter().filter(|c| is_open(c)).flat_map(|c| c.facets.clone()).collect();
        if open.is_empty() {
            return found;
        }
        open.sort_unstable();
        let search = Search::Tell { beyond: [f64::INFINITY, 0.0], pairs: OPEN };
        let told = ceilings(self.mesh, &open, Measuring { search, ..how }, self);
        for c in found.iter_mut().filter(|c| is_open(c)) {
            if let Some(again) = told.iter().find(|t| t.facets == c.facets) {
                (c.cantilever, c.is_beside) = (again.cantilever, again.is_beside);
                c.pairs += again.pairs;
            }
        }
        found
    }

    /// Whether there is material no more than a layer below a whole facet: what is laid there rests on it, as on a support.
    fn rests(&self, facet: u32) -> bool {
        let corners = self.mesh.corners(facet as usize);
        let middle = self.mesh.centroid(facet as usize);
        let below = |p: Vec3| {
            let from = along(p, self.mesh.normal(facet as usize), 2.0 * self.step_mm);
            self.floors.lie_below(self.mesh, from, self.layer_mm + 4.0 * self.step_mm)
        };
        below(middle) && corners.iter().all(|&c| below(along(middle, sub(c, middle), 0.98)))
    }

    /// The facets that look up no more than a layer below a piece of a facet, and the triangles of each on which it rests, in increasing order.
    fn under(&self, facet: u32, piece: [Vec3; 3]) -> Vec<(u32, Vec<[Vec3; 3]>)> {
        let (mesh, tie) = (self.mesh, 4.0 * self.step_mm);
        let Some((lo, hi)) = bounds(piece) else { return Vec::new() };
        let reach = ([lo[0], lo[1], lo[2] - self.layer_mm - tie], [hi[0], hi[1], hi[2] + tie]);
        let mut found = Vec::new();
        self.floors.in_box(reach, |g| {
            // The two sides of an upright wall that leans by its rounding overlap in plan by that.
            let height = [-tie, self.layer_mm + tie];
            let on =
                if g == facet { Vec::new() } else { resting_on(piece, mesh.corners(g as usize), height, 2.0 * tie) };
            if !on.is_empty() {
                found.push((g, on));
            }
        });
        found.sort_unstable_by_key(|(g, _)| *g);
        found
    }

    /// The facets that look up no more than a layer below some of what of a facet lies below a height, once for each piece of it.
    pub fn floors_under(&self, facet: u32, top: f64) -> impl Iterator<Item = u32> {
        let below = clip_below(self.mesh.corners(facet as usize), top);
        let pieces = (1..below.len().saturating_sub(1)).map(move |n| [below[0], below[n], below[n + 1]]);
        pieces.flat_map(move |piece| self.under(facet, piece)).map(|(g, _)| g)
    }

    /// The share of a facet in plan that rests on nothing: neither on the plate nor on what lies no more than a layer below.
    pub fn hanging_share(&self, facet: u32) -> f64 {
        1.0 - share_below(self.mesh.corners(facet as usize), &self.beneath(facet))
    }

    /// What of a facet lies on the plate with nothing between: its area in plan and the volume beneath it, down to the plate.
    pub fn lying(&self, facet: u32) -> [f64; 2] {
        let on: Vec<[Vec3; 3]> =
            self.under(facet, self.mesh.corners(facet as usize)).into_iter().flat_map(|(_, on)| on).collect();
        let free = self.on_plate(facet).filter(|&low| share_below(low, &on) == 0.0);
        free.fold([0.0; 2], |[area, volume], [a, b, c]| {
            let plan = 0.5 * cross(sub(b, a), sub(c, a))[2].abs();
            [area + plan, volume + plan * (a[2] + b[2] + c[2]) / 3.0]
        })
    }

    /// The supports that facets need, less what of these lies on the plate or rests on something, and the bounds of the area that they touch
    /// from below, mm²: from those that give way for certain to all that do not hold themselves for certain.
    ///
    /// # Cost
    /// One or two [`support_volume`], in columns so wide, and a look below each facet.
    pub fn supported(&self, unheld: &Unheld, column_mm: f64) -> (SupportVolume, [f64; 2]) {
        let of = |facets: &[u32]| {
            let carried = self.carried(facets);
            let columns = support_volume(self.mesh, |f| self.facets.bounds_solid(f), facets, 0.0, column_mm);
            (columns.without(&carried, self.layer_mm), carried.hanging_mm2)
        };
        let (all, touched) = of(&unheld.facets);
        if unheld.is_told() {
            return (all, [touched; 2]);
        }
        let (sure, least) = of(&unheld.sure);
        (all.down_to(&sure), [least, touched])
    }

    /// What of hanging facets needs no support after all, and how much is left.
    fn carried(&self, hanging: &[u32]) -> Carried {
        let of = |&f: &u32| {
            let share = self.hanging_share(f);
            let lying = if share < 1.0 { self.lying(f) } else { [0.0; 2] };
            let resting = -0.5 * self.mesh.area_vector(f as usize)[2] * (1.0 - share) - lying[0];
            Carried { lying, resting_mm2: resting, hanging_mm2: self.mesh.facet_area(f as usize) * share }
        };
        // Summed in their order, so that the sum depends on no number of threads.
        let each: Vec<Carried> = hanging.par_iter().with_min_len(64).map(of).collect();
        each.iter().fold(Carried::default(), |sum, c| Carried {
            lying: [sum.lying[0] + c.lying[0], sum.lying[1] + c.lying[1]],
            resting_mm2: sum.resting_mm2 + c.resting_mm2,
            hanging_mm2: sum.hanging_mm2 + c.hanging_mm2,
        })
    }

    /// The part of a ceiling's facet that lies on the plate, as triangles; of a steeper one that is a narrow strip.
    fn on_plate(&self, facet: u32) -> impl Iterator<Item = [Vec3; 3]> {
        let is_flat = self.mesh.normal(facet as usize)[2] <= -FLAT.cos();
        let low = if is_flat { clip_below(self.mesh.corners(facet as usize), self.plate_z) } else { Vec::new() };
        (1..low.len().saturating_sub(1)).map(move |n| [low[0], low[n], low[n + 1]])
    }
}

impl<B: Bounding> Ground for Below<'_, B> {
    fn holds(&self, facet: u32) -> bool {
        // What looks up has its own material right below it.
        let looks_down = self.mesh.normal(facet as usize)[2] < 0.0;
        self.facets.is_covered(facet) || looks_down && self.rests(facet)
    }

    fn beneath(&self, facet: u32) -> Vec<[Vec3; 3]> {
        let under = self.under(facet, self.mesh.corners(facet as usize)).into_iter();
        under.flat_map(|(_, on)| on).chain(self.on_plate(facet)).collect()
    }
}
