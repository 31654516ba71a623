//! Fine sheets of material or void, found on the mesh: what AM106 and AM401 judge.

use super::contract::{Context, limits_of};
use super::search;
use super::sheet_shape::RUN_OUT;
use super::thin_body::ThinBody;
use crate::geometry::health::Role;
use crate::geometry::vector::{Vec3, add, distance, hull, scale, sub, unit};
use crate::medial::chord::{NEARLY_WALL, PARALLEL};
use crate::medial::cluster::{Group, group, principal_extents};
use crate::medial::crease::{SharpEdge, sharp_edges};
use crate::medial::{Passed, Sample, Shape, Side, runs_out};
use crate::part::{Part, bead_of};
use crate::process::Process;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::f64::consts::PI;

/// A group that thins to less than this share of its thickest may run out to an edge: each of its balls is followed to where it thins most.
const THINS: f64 = 0.3;

/// Contacts that are less than this share of a thickness off the sides of a wedge lie on them.
const ON_SIDES: f64 = 0.02;

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
    pub(super) part: &'a Part,
    pub(super) process: &'a Process,
    pub(super) side: Side,
    width: f64,
    link: f64,
    /// Sheets, and where each lies.
    samples: Vec<(Sample, Lies)>,
    /// Where else sheets as thin may be, on the features of samples.
    passed: Vec<Passed>,
    /// Nothing thinner is missing but what is smaller than this.
    pub finest: f64,
}

/// Where a ball lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lies {
    InASheet,
    /// In what hangs together with a wedge.
    BesideAWedge,
    /// In a wedge that runs out to an edge.
    InAWedge,
}

/// One sheet, rod or speck.
#[derive(Debug, Clone)]
pub struct Detail {
    pub thinnest: Thin,
    /// No ball in it is smaller.
    pub low: f64,
    /// Area of the patches that it was found on, and that times thickness: how large it is beside others.
    pub area: f64,
    pub volume: f64,
    /// Area that lies on it as it was measured, on all patches, and that times thickness: the volume between its sides.
    pub covers: f64,
    pub holds: f64,
    /// Box around its patches and what lies opposite.
    pub extent: (Vec3, Vec3),
    /// Sides of its middle surface, longest first.
    pub spans: [f64; 3],
    /// A facet of its thinnest place.
    pub facet: u32,
    /// The body, where it is one altogether: then its volume is exact.
    pub whole: Option<u32>,
    /// Its patches and what lies opposite: those that were sampled, and those on the same features that may be as thin.
    pub patches: Vec<Patch>,
    /// Its balls, those of sampled patches before others.
    pub places: Vec<Thin>,
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

impl Patch {
    /// A patch with such a box, from which such a chord leads across.
    fn across((lo, hi): (Vec3, Vec3), [from, to]: [Vec3; 2]) -> Self {
        let way = sub(to, from);
        Patch { extent: hull((lo, hi), (add(lo, way), add(hi, way))), across: unit(way) }
    }
}

impl From<&Passed> for Thin {
    fn from(p: &Passed) -> Self {
        let [a, b] = p.chord;
        Thin { centre: scale(add(a, b), 0.5), contacts: p.chord, diameter: p.low }
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
        let cover = self.part.cover(self.side, &question);
        let body = |facet: u32| self.part.health().facet_body.get(facet as usize).copied();
        let samples: Vec<Sample> = cover
            .samples
            .iter()
            .filter(|s| !matches!(s.shape, Shape::Waist | Shape::Bent) && s.diameter < self.width)
            .filter(|s| {
                (self.between == Between::Surfaces || body(s.facet) == body(s.opposite)) && !self.is_sealed(s.facet)
            })
            .copied()
            .collect();
        let link = 1.5 * 0.75 * self.width;
        let sharp = sharp_edges(self.part.mesh(), self.part.adjacency(), self.side, PI - NEARLY_WALL);
        let mut lies = vec![Lies::InASheet; samples.len()];
        for members in grouped(self.part, &samples, link) {
            let group: Vec<&Sample> = members.iter().map(|&i| &samples[i]).collect();
            if !may_run_out(&group, &sharp) {
                continue;
            }
            let in_wedge: Vec<bool> = group.par_iter().map(|s| self.is_in_wedge(s)).collect();
            if in_wedge.contains(&true) {
                let of = |wedge| if wedge { Lies::InAWedge } else { Lies::BesideAWedge };
                members.iter().zip(in_wedge).for_each(|(&i, wedge)| lies[i] = of(wedge));
            }
        }
        let samples = samples.into_iter().zip(lies).filter(|(s, _)| s.shape == Shape::Sheet).collect();
        let thin = cover.unresolved.iter().filter(|u| u.low < self.width);
        let open = thin.map(|u| u.extent).fold(question.finest, f64::max);
        Found {
            part: self.part,
            process: self.process,
            side: self.side,
            width: self.width,
            link,
            samples,
            passed: cover.passed.iter().filter(|p| p.low < self.width).copied().collect(),
            finest: (1e3 * open).ceil() / 1e3,
        }
    }
}

impl Sought<'_> {
    /// Whether a ball lies between sides that lean, and lean until they meet.
    fn is_in_wedge(&self, s: &Sample) -> bool {
        s.shape == Shape::Wedge || runs_out(self.part.distance(), s.centre, s.diameter, RUN_OUT * self.width)
    }

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
        let parallel = |s: &Sample| s.separation >= PARALLEL && s.low >= 1e-3 * self.width;
        let counts = |(s, lies): &&(Sample, Lies)| wanted(&Thin::from(s)) && (*lies != Lies::InAWedge || parallel(s));
        let (chosen, lies): (Vec<Sample>, Vec<Lies>) = self.samples.iter().filter(counts).copied().unzip();
        let groups = grouped(self.part, &chosen, self.link);
        let passed = self.passed_beside(&chosen, &groups, wanted);
        let mut out: Vec<Detail> = groups
            .into_iter()
            .zip(passed)
            .filter_map(|(members, passed)| {
                let samples: Vec<Sample> = members.iter().map(|&i| chosen[i]).collect();
                if members.iter().all(|&i| lies[i] == Lies::InASheet) {
                    return summed(&samples, &passed);
                }
                summed(&samples, &[]).filter(|d| d.area >= self.width * self.width)
            })
            .collect();
        out.sort_by(|a, b| b.volume.total_cmp(&a.volume));
        out
    }

    /// For each group, the patches that were passed over because of it: those that may hold what is wanted on the features of its
    /// samples, nearest to one of them.
    fn passed_beside(&self, chosen: &[Sample], groups: &[Group], wanted: impl Fn(&Thin) -> bool) -> Vec<Vec<&Passed>> {
        let mut on: FxHashMap<u32, Vec<(usize, Vec3)>> = FxHashMap::default();
        for (g, members) in groups.iter().enumerate() {
            for s in members.iter().map(|&i| &chosen[i]) {
                on.entry(s.feature).or_default().push((g, s.contacts[0]));
            }
        }
        let mut out = vec![Vec::new(); groups.len()];
        for p in self.passed.iter().filter(|p| wanted(&Thin::from(*p))) {
            let away = |at: &Vec3| distance(*at, p.chord[0]);
            let beside = match on.get(&p.feature).map(Vec::as_slice) {
                // In the order of their groups: mostly all are of one.
                Some([first, .., last]) if first.0 == last.0 => Some(first),
                of => of.into_iter().flatten().min_by(|a, b| away(&a.1).total_cmp(&away(&b.1))),
            };
            if let Some(of) = beside.and_then(|(g, _)| out.get_mut(*g)) {
                of.push(p);
            }
        }
        out
    }
}

/// Whether a group may run out to an edge: it thins as far as that, or lies between the sides of a wedge at its thinnest.
fn may_run_out(group: &[&Sample], sharp: &[SharpEdge]) -> bool {
    let thickest = group.iter().map(|s| s.diameter).fold(0.0, f64::max);
    let thinnest = group.iter().min_by(|a, b| a.diameter.total_cmp(&b.diameter));
    let in_wedge = |s: &&Sample| sharp.iter().any(|e| e.off(s.contacts) < ON_SIDES * s.diameter);
    group.iter().any(|s| s.low < THINS * thickest) || thinnest.is_some_and(in_wedge)
}

/// Samples that lie side by side in a sheet between the same bodies.
fn grouped(part: &Part, samples: &[Sample], link: f64) -> Vec<Group> {
    let of = |facet: u32| part.health().facet_body.get(facet as usize).map_or(0, |&b| u64::from(b));
    let bodies = |s: &Sample| of(s.facet).min(of(s.opposite)) << 32 | of(s.facet).max(of(s.opposite));
    group(samples, link, bodies, |f| part.mesh().triangles.get(f as usize).copied().unwrap_or_default())
}

fn summed(samples: &[Sample], passed: &[&Passed]) -> Option<Detail> {
    let thinnest = samples.iter().min_by(|a, b| a.diameter.total_cmp(&b.diameter))?;
    let sampled = samples.iter().map(|s| (s.sides, s.contacts));
    let patches: Vec<Patch> =
        sampled.chain(passed.iter().map(|p| (p.sides, p.chord))).map(|(sides, to)| Patch::across(sides, to)).collect();
    let centres: Vec<Vec3> = samples.iter().map(|s| s.centre).collect();
    let [long, wide, high] = principal_extents(&centres);
    // What was passed over makes it longer; how wide it is is known where it was sampled.
    let places: Vec<Thin> = samples.iter().map(Thin::from).chain(passed.iter().map(|p| Thin::from(*p))).collect();
    let [longest, ..] = principal_extents(&places.iter().map(|t| t.centre).collect::<Vec<_>>());
    Some(Detail {
        thinnest: Thin::from(thinnest),
        low: samples.iter().map(|s| s.low).fold(thinnest.diameter, f64::min),
        area: 0.5 * samples.iter().map(|s| s.area).sum::<f64>(),
        volume: 0.5 * samples.iter().map(|s| s.area * s.diameter).sum::<f64>(),
        covers: 0.5 * samples.iter().map(|s| s.thin).sum::<f64>(),
        holds: 0.5 * samples.iter().map(|s| s.thin * s.diameter).sum::<f64>(),
        extent: patches.iter().map(|p| p.extent).reduce(hull)?,
        spans: [long.max(longest), wide, high],
        facet: thinnest.facet,
        whole: None,
        patches,
        places,
    })
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
            covers: b.volume / b.width,
            holds: b.volume,
            extent: b.extent,
            spans,
            facet: b.facet,
            whole: Some(b.body),
            patches: vec![Patch { extent: b.extent, across: thinnest.direction() }],
            places: vec![thinnest],
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::geometry::union::united;
    use crate::part::Up;

    #[test]
    fn slots_hold_what_lies_between_their_sides() {
        // Fins of 1.5 mm on a plate, with slots of 0.12 × 36 × 14 mm between them.
        let (slots, pitch) = (12, 1.62);
        let fins = (0..=slots).map(|n| {
            let x = pitch * f64::from(n);
            cuboid([x, 0.0, 2.0], [x + 1.5, 36.0, 16.0])
        });
        let plate = cuboid([0.0; 3], [pitch * f64::from(slots) + 1.5, 36.0, 2.0]);
        let comb = united(&fins.fold(plate, |all, fin| all.joined(&fin)), 1e-6).expect("one solid");
        let part = Part::new(comb, Up::PlusZ, 1e-6, 1.0).unwrap();
        let process = Process::named("mjf").unwrap();
        let truth = 0.12 * 36.0 * 14.0;
        let context = Context { refine: 1 << 26, spacing_mm: 0.25 };
        let (side, between) = (Side::Void, Between::Surfaces);
        let sought = Sought { part: &part, process: &process, context: &context, side, between, width: 0.4 };
        let found = sought.search().sheets(|t| t.diameter < 0.2);
        assert_eq!(found.len(), slots as usize);
        for slot in &found {
            assert!((slot.holds / truth - 1.0).abs() < 0.02, "{} of {truth}", slot.holds);
            assert!((slot.covers / 504.0 - 1.0).abs() < 0.02, "{} of 504", slot.covers);
        }
    }
}
