//! Fine sheets of material or void, found on the mesh: what AM106 and AM401 judge.

use super::contract::{Context, limits_of};
use super::search;
use super::thin_body::ThinBody;
use crate::geometry::health::Role;
use crate::geometry::vector::{Vec3, bounds, sub, unit};
use crate::medial::chord::PARALLEL;
use crate::medial::cluster::{group, principal_extents};
use crate::medial::{Sample, Shape, Side};
use crate::part::{Part, bead_of};
use crate::process::Process;

/// What rises or sinks by no more than this is relief, millimetres.
pub const RELIEF_MM: f64 = 2.0;
/// A group that thins to less than this share of the width sought runs out to an edge: only what is parallel in it counts.
const RUN_OUT: f64 = 0.3;

/// The widest limit of a rule, millimetres; 0 without one.
pub fn rule_width(process: &Process, rule: &str) -> f64 {
    limits_of(process, rule).and_then(|l| l.warn.or(l.fail)).unwrap_or(0.0)
}

/// Up to this width material is sought: the element's own, or that of raised detail.
pub fn raised_width(process: &Process) -> f64 {
    bead_of(process).widest().as_mm().max(rule_width(process, "lost-feature.embossed"))
}

/// Whose opposing surfaces are looked between; never those of a void that is closed on all sides, which nobody sees or needs open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Between {
    /// Those of one body.
    SidesOfABody,
    /// Those of different bodies too.
    Surfaces,
}

/// What is sought: everything thinner than a width, on one side of the surface.
pub struct Sought<'a> {
    pub part: &'a Part,
    pub process: &'a Process,
    pub context: &'a Context,
    pub side: Side,
    pub between: Between,
    pub width: f64,
}

/// What was found.
pub struct Found<'a> {
    part: &'a Part,
    width: f64,
    link: f64,
    samples: Vec<Sample>,
    /// Nothing thinner is missing but what is smaller than this.
    pub finest: f64,
    pub evaluations: u64,
}

/// One sheet, rod or speck.
#[derive(Debug, Clone)]
pub struct Detail {
    pub thinnest: Thin,
    /// No ball in it is smaller.
    pub low: f64,
    pub area: f64,
    /// Area times thickness: the volume between its sides.
    pub volume: f64,
    /// Box around its contacts.
    pub extent: (Vec3, Vec3),
    /// Sides of its middle surface, longest first.
    pub spans: [f64; 3],
    /// A facet of its thinnest place.
    pub facet: u32,
    /// The body, where it is one altogether: then its volume is exact.
    pub whole: Option<u32>,
    /// The patches of its samples and what lies opposite.
    pub patches: Vec<Patch>,
}

/// A patch of surface and what lies opposite.
#[derive(Debug, Clone, Copy)]
pub struct Patch {
    /// Box around both.
    pub extent: (Vec3, Vec3),
    /// Unit vector from side to side.
    pub across: Vec3,
}

/// A ball between two opposing sides.
#[derive(Debug, Clone, Copy)]
pub struct Thin {
    pub centre: Vec3,
    pub contacts: [Vec3; 2],
    pub diameter: f64,
}

impl Thin {
    /// Unit vector from side to side.
    pub fn direction(&self) -> Vec3 {
        unit(sub(self.contacts[1], self.contacts[0]))
    }
}

impl From<&Sample> for Thin {
    fn from(s: &Sample) -> Self {
        Thin { centre: s.centre, contacts: s.contacts, diameter: s.diameter }
    }
}

impl<'a> Sought<'a> {
    /// Searches by branch and bound.
    pub fn search(&self) -> Found<'a> {
        let question = search::question(self.part, self.process, self.context, self.side, &[self.width]);
        let (cover, evaluations) = self.part.cover(self.side, &question);
        let body = |facet: u32| self.part.health().facet_body.get(facet as usize).copied();
        let samples = cover
            .samples
            .iter()
            .filter(|s| s.shape == Shape::Sheet && s.diameter < self.width)
            .filter(|s| {
                (self.between == Between::Surfaces || body(s.facet) == body(s.opposite)) && !self.is_sealed(s.facet)
            })
            .copied()
            .collect();
        let resolution = 0.75 * self.width;
        let thin = cover.unresolved.iter().filter(|u| u.low < self.width);
        let open = thin.map(|u| u.extent).fold(question.finest, f64::max);
        Found {
            part: self.part,
            width: self.width,
            link: 1.5 * resolution,
            samples,
            finest: (1e3 * open).ceil() / 1e3,
            evaluations,
        }
    }
}

impl Sought<'_> {
    /// Whether a facet bounds a void that is closed on all sides.
    fn is_sealed(&self, facet: u32) -> bool {
        let health = self.part.health();
        let shell = health.facet_shell.get(facet as usize).and_then(|&s| health.shells.get(s as usize));
        self.side == Side::Void && shell.is_some_and(|s| s.role == Role::Cavity)
    }
}

impl Found<'_> {
    /// The sheets made of those balls that are wanted, largest first; wedges are left out but for what is parallel in them.
    pub fn sheets(&self, wanted: impl Fn(&Thin) -> bool) -> Vec<Detail> {
        let chosen: Vec<Sample> = self.samples.iter().filter(|s| wanted(&Thin::from(*s))).copied().collect();
        let of = |facet: u32| self.part.health().facet_body.get(facet as usize).map_or(0, |&b| u64::from(b));
        let bodies = |s: &Sample| of(s.facet).min(of(s.opposite)) << 32 | of(s.facet).max(of(s.opposite));
        let corners = |f: u32| self.part.mesh().triangles[f as usize];
        let mut out: Vec<Detail> = group(&chosen, self.link, bodies, corners)
            .into_iter()
            .filter_map(|members| {
                let samples: Vec<Sample> = members.into_iter().map(|i| chosen[i]).collect();
                let runs_out = samples.iter().any(|s| s.low < RUN_OUT * self.width);
                if !runs_out {
                    return summed(&samples);
                }
                let parallel = |s: &&Sample| s.separation >= PARALLEL && s.low >= 1e-3 * self.width;
                summed(&samples.iter().filter(parallel).copied().collect::<Vec<_>>())
                    .filter(|d| d.area >= self.width * self.width)
            })
            .collect();
        out.sort_by(|a, b| b.volume.total_cmp(&a.volume));
        out
    }
}

fn summed(samples: &[Sample]) -> Option<Detail> {
    let thinnest = samples.iter().min_by(|a, b| a.diameter.total_cmp(&b.diameter))?;
    Some(Detail {
        thinnest: Thin::from(thinnest),
        low: samples.iter().map(|s| s.low).fold(thinnest.diameter, f64::min),
        area: 0.5 * samples.iter().map(|s| s.area).sum::<f64>(),
        volume: 0.5 * samples.iter().map(|s| s.area * s.diameter).sum::<f64>(),
        extent: bounds(samples.iter().flat_map(|s| s.contacts))?,
        spans: principal_extents(&samples.iter().map(|s| s.centre).collect::<Vec<_>>()),
        facet: thinnest.facet,
        whole: None,
        patches: samples.iter().map(patch).collect(),
    })
}

fn patch(sample: &Sample) -> Patch {
    let ([a, b], reach) = (sample.contacts, 0.5 * sample.area.sqrt());
    let extent = ([0, 1, 2].map(|x| a[x].min(b[x]) - reach), [0, 1, 2].map(|x| a[x].max(b[x]) + reach));
    Patch { extent, across: Thin::from(sample).direction() }
}

impl From<&ThinBody> for Detail {
    fn from(b: &ThinBody) -> Self {
        let mut spans = [0, 1, 2].map(|a| b.extent.1[a] - b.extent.0[a]);
        spans.sort_by(|a, b| b.total_cmp(a));
        let thinnest = Thin { centre: b.middle, contacts: b.sides(), diameter: b.width };
        Detail {
            thinnest,
            low: 0.0,
            area: b.volume / b.width,
            volume: b.volume,
            extent: b.extent,
            spans,
            facet: b.facet,
            whole: Some(b.body),
            patches: vec![Patch { extent: b.extent, across: thinnest.direction() }],
        }
    }
}

impl Detail {
    /// What it looks like.
    pub fn noun(&self) -> &'static str {
        if self.whole.is_some() {
            "body"
        } else if self.spans[0] < self.thinnest.diameter {
            "speck"
        } else if self.spans[1] < 0.5 * self.thinnest.diameter {
            "rod"
        } else {
            "sheet"
        }
    }

    /// Whether it is a low ridge or a shallow groove.
    pub fn is_relief(&self) -> bool {
        self.noun() == "sheet" && self.spans[1] <= RELIEF_MM
    }
}
