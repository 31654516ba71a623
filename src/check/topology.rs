//! AM402: pieces, tunnels and voids as designed and as printed.

use super::apart::{self, can_part};
use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::detail::{Between, Detail};
use super::finding::{Basis, Bracket, Finding, Limits, Spot, State};
use super::least_width::LeastWidth;
use super::mend::{self, TRIED, growth};
use super::place::{locate, reported};
use super::room::{Fit, Growth};
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::BodyPair;
use crate::geometry::health::NO_LABEL;
use crate::geometry::vector::{Vec3, bounds};
use crate::medial::Side;
use crate::morphology::{AsPrinted, Cells};
use crate::notice::Notice;
use crate::part::Part;
use crate::process::Process;
use crate::topology::{Adjacency, Betti, Change, betti, changes, components};
use crate::units::short;

/// AM402 `topology`.
pub struct Topology;

static META: Meta = Meta {
    code: "AM402",
    name: "topology",
    title: "What printing joins, splits, closes or opens",
    what: "Compares pieces, tunnels and enclosed voids of the part as designed with those of the part as its process lays it down, \
           and shows each place where they differ: bodies that fuse, pieces that are lost or split, holes that close or open, voids \
           that are enclosed or filled.",
    why: "A hinge that fuses, a hole that closes or a wall that opens is another part than the one that was designed, however small \
          the volume that makes the difference.",
    how: "Bodies fuse where they stand nearer than the gap that closes in the process, by their exact distance. \
          For the rest the part is printed on a lattice as by as-printed; what the mesh shows to be too thin to be printed, or too narrow \
          to stay open, is lost or closed wherever the lattice stands. First what is not \
          printed is taken away from the design, then what is printed beside it is added. Of either, all samples that change no Betti \
          number are taken away; what stays is one small remnant for each change, and the change it makes is counted from the Euler \
          characteristic and by union-find. The changes add up to the differences of the Betti numbers. What is to be thickened or widened \
          has been, on a lattice of the place, and was printed again; bodies to be moved apart have been moved, and measured again.",
    limits: "An estimate: the lattice has a few cells across the element, and what is finer than a cell is not seen; where the lattice \
             sees other numbers than the mesh has, a notice says so. Positions of beads are those of the lattice, not of a slicer. \
             Two changes that touch are one place.",
    source: "Betti numbers of as-printed shapes: S. Nelaturi and others, 2019. Simple points: G. Bertrand, G. Malandain, A new \
             characterization of three-dimensional simple points, 1994.",
};

/// Share of the element that must lie in the part for it to be laid down.
const LAMBDA: f64 = 0.5;
impl Check for Topology {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let Some(limits) = limits_of(process, "topology") else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let mut measured = Measured { rule: Some("topology"), ..Measured::default() };
        let mut events = fused(part, process);
        let fuse = !events.is_empty();
        match part.as_printed(process, LAMBDA)? {
            Some(printed) => {
                let [before, after] = whole(part, &Printed::new(part, process, context, &printed)?, &mut events)?;
                let wide = printed.designed.cells.wide;
                measured.cover =
                    format!("Laid down with {wide} cells across the element: {} as designed", words(before));
                // Between bodies the lattice shows another thing at every turn.
                measured.cover.push_str(&if fuse {
                    "; bodies fuse by their distances, whatever the lattice shows between them.".into()
                } else {
                    format!(", {} as printed.", words(after))
                });
                measured.notices.extend(unlike(part, before));
            }
            None => {
                let width = short(process.element.width_mm);
                let why = format!("an element of {width} mm is too fine for a lattice of the whole part");
                if events.is_empty() {
                    return Ok(Outcome::NotApplicable(why));
                }
                let text = format!("{why}; only whether bodies fuse was looked at");
                measured.notices.push(Notice::new("topology-by-distance", text.clone()));
                measured.cover = text;
            }
        }
        let judge = Judge { part, context, process, limits };
        for kind in KINDS {
            let own: Vec<&Event> = events.iter().filter(|e| e.kind == kind.0).collect();
            measured.findings.extend(judge.finding(kind, &own)?);
        }
        let all: u64 = events.iter().map(|e| e.times).sum();
        let at = events.first().map(|e| e.at);
        measured.worst = Some(Worst { bracket: Bracket::exact(all as f64), unit: "1", at });
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// The part as printed on a lattice, whose sheets that are too thin are lost and whose slots that are too narrow are filled wherever the
/// lattice stands.
struct Printed<'a> {
    on_lattice: &'a AsPrinted,
    centres: Indicator,
    /// What is too narrow of material and of void.
    narrow: [Vec<Lacking>; 2],
}

/// A sheet or a slot, and how much it lacks of what would be printed as drawn, millimetres.
struct Lacking {
    extent: (Vec3, Vec3),
    missing: f64,
}

impl<'a> Printed<'a> {
    fn new(part: &Part, process: &Process, context: &Context, on_lattice: &'a AsPrinted) -> Result<Self> {
        let mut centres = on_lattice.centres.clone();
        let mut narrow = [Side::Material, Side::Void].map(|_| Vec::new());
        for side in [Side::Material, Side::Void] {
            let least = LeastWidth::new(part, process, context, side);
            let places = least.narrow(Between::SidesOfABody).places;
            if places.is_empty() {
                continue;
            }
            let cells = least.cells(&places, &on_lattice.designed)?;
            centres = if side == Side::Material { centres.difference(&cells)? } else { centres.union(&cells)? };
            let lacks = |d: &Detail| Lacking {
                extent: d.extent,
                missing: least.along(d.thinnest.direction()) - d.thinnest.diameter,
            };
            narrow[side as usize] = places.iter().map(lacks).collect();
        }
        Ok(Printed { on_lattice, centres, narrow })
    }

    /// The most that sheets lack which are lost in a box, or slots which are filled; 0 if none is there.
    fn missing(&self, step: Step, extent: (Vec3, Vec3)) -> f64 {
        let side = if step == Step::Lost { Side::Material } else { Side::Void };
        let meets = |n: &&Lacking| (0..3).all(|a| n.extent.0[a] <= extent.1[a] && extent.0[a] <= n.extent.1[a]);
        self.narrow[side as usize].iter().filter(meets).map(|n| n.missing).fold(0.0, f64::max)
    }
}

/// All changes from the design to the print, and the numbers before and after.
fn whole(part: &Part, printed: &Printed, events: &mut Vec<Event>) -> Result<[Betti; 2]> {
    let designed = without_specks(part, printed.on_lattice);
    let seen = betti(&designed, Adjacency::Face)?;
    // Where the lattice sees another part than the mesh describes, what is smaller than an element is not told.
    let cells = &printed.on_lattice.designed.cells;
    let least = if of_mesh(part).is_some_and(|b| b != seen) { (cells.wide * cells.wide) as u64 } else { 0 };
    let both = designed.intersection(&printed.centres)?;
    let lost = changes(&both, &designed, Adjacency::Face)?.into_iter().map(|c| (c, Step::Lost));
    let gained = changes(&both, &printed.centres, Adjacency::Face)?.into_iter().map(|c| (c, Step::Gained));
    for (change, step) in lost.chain(gained) {
        let mut own = Vec::new();
        events_of(part, cells, &change, step, &mut own);
        // What happens between bodies is told by their distance.
        own.retain(|e| change.samples >= least && e.bodies.len() < 2);
        own.iter_mut().for_each(|e| e.missing = printed.missing(step, e.extent));
        events.extend(own);
    }
    Ok([seen, betti(&printed.centres, Adjacency::Face)?])
}

/// The part on the lattice without what thin edges leave of it: of more pieces than there are bodies, the smallest that
/// hold fewer cells than an element.
fn without_specks(part: &Part, printed: &AsPrinted) -> Indicator {
    let designed = &printed.designed.shape.centres;
    let pieces = components(designed, Adjacency::Face);
    let sizes = pieces.sizes();
    let mut order: Vec<u32> =
        (0..sizes.len() as u32).filter(|&p| sizes[p as usize] < printed.designed.element_cells()).collect();
    order.sort_by_key(|&p| (sizes[p as usize], p));
    order.truncate(sizes.len().saturating_sub(part.health().bodies.len()));
    if order.is_empty() {
        return designed.clone();
    }
    order.sort_unstable();
    pieces.select(|p| order.binary_search(&p).is_err())
}

/// Bodies that stand nearer than the gap that closes: exact distances, equal passes.
fn fused(part: &Part, process: &Process) -> Vec<Event> {
    let least = process.element.closing_gap_mm - part.tie();
    let near = part.body_pairs().iter().filter(|p| p.distance > part.step() && p.distance < least);
    near.map(|p| Event {
        kind: "fused",
        times: 1,
        at: p.middle(),
        extent: bounds(p.points).unwrap_or_default(),
        bodies: p.bodies.map(|b| u64::from(b) + 1).to_vec(),
        missing: 0.0,
    })
    .collect()
}

/// Whether samples are taken away from the design, or added beside it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Lost,
    Gained,
}

/// One thing that happens at one place, as often as given.
#[derive(Debug, Clone)]
struct Event {
    kind: &'static str,
    times: u64,
    at: Vec3,
    extent: (Vec3, Vec3),
    /// The bodies that meet here, counted from 1.
    bodies: Vec<u64>,
    /// By how much the place is narrower than what would be printed as drawn, millimetres, where its sides tell.
    missing: f64,
}

/// Kind, words for one, words for many, and what to let grow: the material, or the void.
type Kind = (&'static str, &'static str, &'static str, &'static str, Side);

const KINDS: [Kind; 10] = [
    ("fused", "pieces fuse", "places where pieces fuse", "open the gap", Side::Void),
    ("piece-lost", "a piece is not printed", "pieces are not printed", "thicken it", Side::Material),
    ("split", "a piece falls apart", "places where a piece falls apart", "thicken the neck", Side::Material),
    ("hole-closed", "a hole closes", "holes close", "open it", Side::Void),
    ("bridged", "a slot is bridged", "places where a slot is bridged", "widen it", Side::Void),
    ("hole-opened", "a hole opens in a wall", "holes open in walls", "thicken the wall", Side::Material),
    ("loop-cut", "a strut or rib is cut", "struts or ribs are cut", "thicken it", Side::Material),
    ("void-enclosed", "a void is enclosed", "voids are enclosed", "widen its way out", Side::Void),
    ("void-opened", "a closed void is opened", "closed voids are opened", "thicken its wall", Side::Material),
    ("void-filled", "a void is filled", "voids are filled", "widen it", Side::Void),
];

/// What a change means, read forward for what is added and backward for what is lost.
fn kinds_of(c: &Change, step: Step) -> Vec<(&'static str, u64)> {
    let all = match step {
        Step::Gained => [
            ("fused", -c.pieces),
            ("hole-closed", -c.tunnels),
            ("bridged", c.tunnels),
            ("void-enclosed", c.voids),
            ("void-filled", -c.voids),
        ],
        Step::Lost => [
            ("split", -c.pieces),
            ("piece-lost", c.pieces),
            ("hole-opened", -c.tunnels),
            ("loop-cut", c.tunnels),
            ("void-opened", c.voids),
        ],
    };
    all.into_iter().filter(|k| k.1 > 0).map(|(kind, times)| (kind, times as u64)).collect()
}

fn events_of(part: &Part, cells: &Cells, c: &Change, step: Step, events: &mut Vec<Event>) {
    let half = cells.cell_mm().map(|c| 0.5 * c);
    let corner = |p: [usize; 3], sign: f64| {
        let q = cells.position(p);
        [0, 1, 2].map(|a| q[a] + sign * half[a])
    };
    let place = |at: usize| cells.position(cells.grid.index(at));
    for (kind, times) in kinds_of(c, step) {
        events.push(Event {
            kind,
            times,
            at: place(c.at),
            extent: (corner(c.extent[0], -1.0), corner(c.extent[1], 1.0)),
            bodies: bodies_at(part, c.meets.iter().map(|&at| place(at))),
            missing: 0.0,
        });
    }
}

/// The bodies whose surfaces are nearest to some points, counted from 1.
fn bodies_at(part: &Part, points: impl Iterator<Item = Vec3>) -> Vec<u64> {
    let body = |p: Vec3| {
        let near = part.distance().nearest(p, f64::INFINITY)?;
        let body = *part.health().facet_body.get(near.facet as usize)?;
        (body != NO_LABEL).then(|| u64::from(body) + 1)
    };
    let mut bodies: Vec<u64> = points.filter_map(body).collect();
    bodies.sort_unstable();
    bodies.dedup();
    bodies
}

/// Pieces, tunnels and voids in words.
fn words(b: Betti) -> String {
    let many = |n: u64, one: &str| format!("{n} {one}{}", if n == 1 { "" } else { "s" });
    format!("{}, {} and {}", many(b.pieces, "piece"), many(b.tunnels, "tunnel"), many(b.voids, "void"))
}

/// What the mesh has itself, where it tells: a closed manifold whose shells do not touch.
fn of_mesh(part: &Part) -> Option<Betti> {
    let (mesh, health) = (part.mesh(), part.health());
    if !health.is_watertight() || !part.is_plain() {
        return None;
    }
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    let (vertices, facets) = (used.iter().filter(|u| **u).count() as i64, mesh.triangles.len() as i64);
    // Three edges for two facets; the solid has half of the characteristic of its surface.
    let surface = vertices - facets / 2;
    let pieces = health.bodies.len() as i64;
    let voids: i64 = health.bodies.iter().map(|b| b.cavities.len() as i64).sum();
    let tunnels = pieces + voids - surface / 2;
    (surface % 2 == 0 && tunnels >= 0).then_some(Betti {
        pieces: pieces as u64,
        tunnels: tunnels as u64,
        voids: voids as u64,
    })
}

/// Says where the lattice sees another part than the mesh describes.
fn unlike(part: &Part, seen: Betti) -> Option<Notice> {
    let has = of_mesh(part)?;
    (has != seen).then(|| {
        let text = format!(
            "the lattice of the as-printed part sees {}, the mesh has {}: changes smaller than an element are not told",
            words(seen),
            words(has)
        );
        Notice::new("topology-unresolved", text)
    })
}

struct Judge<'a> {
    part: &'a Part,
    context: &'a Context,
    process: &'a Process,
    limits: Limits,
}

impl Judge<'_> {
    /// One finding for all events of a kind, the largest first.
    fn finding(&self, (kind, one, many, remedy, side): Kind, events: &[&Event]) -> Result<Option<Finding>> {
        let span = |e: &Event| (0..3).map(|a| e.extent.1[a] - e.extent.0[a]).sum::<f64>();
        let mut order: Vec<&Event> = events.to_vec();
        order.sort_by(|a, b| span(b).total_cmp(&span(a)));
        let Some(&first) = order.first() else { return Ok(None) };
        let times: u64 = order.iter().map(|e| e.times).sum();
        let bracket = Bracket::exact(times as f64);
        let mut f = Finding::judged(META.code, kind, bracket, Basis::Estimated, self.limits, "1", 0.0);
        if f.state == State::Pass {
            return Ok(None);
        }
        let extent = bounds(order.iter().flat_map(|e| [e.extent.0, e.extent.1])).unwrap_or_default();
        locate(&mut f, self.part, self.context, first.at, extent);
        f.count = order.len() as u64;
        let spot = |e: &&Event| {
            let times = e.times as f64;
            Spot { at_mm: reported(self.part, e.at), value: times, low: times, high: times }
        };
        f.places = order.iter().map(spot).collect();
        let mut bodies: Vec<u64> = order.iter().flat_map(|e| e.bodies.iter().copied()).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let named = if kind == "fused" && bodies.len() > 1 {
            let list: Vec<String> = bodies.iter().take(8).map(u64::to_string).collect();
            format!(" (bodies {}{})", list.join(", "), if bodies.len() > 8 { " and others" } else { "" })
        } else {
            String::new()
        };
        f.message = if times == 1 { format!("{one}{named}") } else { format!("{times} {many}{named}") };
        f.fix = match kind {
            "fused" => self.parted(&order),
            _ => {
                let tried = order.iter().take(TRIED);
                let grown = tried.map(|e| growth(self.part, self.process, side, (e.extent, e.missing)));
                let grown = grown.collect::<Result<Vec<_>>>()?;
                let tries: Vec<mend::Growth> = grown.into_iter().flatten().collect();
                mend::words(remedy, &tries, order.len())
            }
        };
        if self.part.health().bodies.len() > 1 && !bodies.is_empty() {
            f.bodies = Some(bodies);
        }
        Ok(Some(f))
    }

    /// What is said of pieces that fuse: whether they can be moved apart, or their gap opened, tried with the nearest of them.
    fn parted(&self, events: &[&Event]) -> String {
        let to = self.process.element.closing_gap_mm;
        let own = |p: &&BodyPair| events.iter().any(|e| e.at == p.middle());
        let pairs: Vec<&BodyPair> = self.part.body_pairs().iter().filter(own).take(apart::TRIED).collect();
        let moved: Vec<Option<bool>> = pairs.iter().map(|p| can_part(self.part, p, to)).collect();
        let growth = Growth::new(self.part, self.process, Side::Void);
        let opened = Fit::counts(pairs.iter().map(|p| growth.fits_between(p.points, to - p.distance)));
        let opening = growth.tried(format!("open the gap to {} mm", short(to)), "open", to, opened);
        apart::words(&moved, to, &opening)
    }
}

#[cfg(test)]
mod tests {
    use super::super::least_width::tests::webbed;
    use super::*;

    fn change(pieces: i64, tunnels: i64, voids: i64) -> Change {
        Change { at: 0, extent: [[0; 3]; 2], samples: 1, pieces, tunnels, voids, meets: Vec::new() }
    }

    #[test]
    fn every_change_has_a_name_in_either_direction() {
        let kinds = |c: Change, step| kinds_of(&c, step);
        assert_eq!(kinds(change(-2, 0, 0), Step::Gained), [("fused", 2)]);
        assert_eq!(kinds(change(0, -1, 1), Step::Gained), [("hole-closed", 1), ("void-enclosed", 1)]);
        assert_eq!(kinds(change(0, 1, -1), Step::Gained), [("bridged", 1), ("void-filled", 1)]);
        assert_eq!(kinds(change(1, 0, 0), Step::Lost), [("piece-lost", 1)]);
        assert_eq!(kinds(change(-1, 0, 0), Step::Lost), [("split", 1)]);
        assert_eq!(kinds(change(0, -1, 0), Step::Lost), [("hole-opened", 1)]);
        assert_eq!(kinds(change(0, 1, 1), Step::Lost), [("loop-cut", 1), ("void-opened", 1)]);
    }

    #[test]
    fn a_web_that_alone_joins_two_blocks_and_is_too_thin_leaves_them_apart() {
        let process = Process::named("fdm").unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        let apart: &[&str] = &["split"];
        for (thick, long, wanted) in [(0.15, 6.0, apart), (0.35, 6.0, &[]), (0.15, 0.3, &[])] {
            let part = webbed(thick, long);
            let Outcome::Measured(measured) = Topology.run(&part, &process, &context).unwrap() else { panic!() };
            let found: Vec<&str> = measured.findings.iter().map(|f| f.kind.as_str()).collect();
            assert_eq!(found, wanted, "{thick} × {long}");
        }
    }
}
