//! AM402: pieces, tunnels and voids as designed and as printed.

use super::altered::{Altered, Event};
use super::apart::{self, can_part};
use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, Limits, Spot, State};
use super::fusing::Fusing;
use super::laid::Laid;
use super::mend::{self, TRIED, growth};
use super::place::{locate, reported};
use super::room::{Fit, Growth};
use crate::error::Result;
use crate::geometry::BodyPair;
use crate::geometry::vector::bounds;
use crate::medial::Side;
use crate::notice::Notice;
use crate::part::Part;
use crate::process::Process;
use crate::topology::Betti;
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
    how: "The part is printed on a lattice as by as-printed; what the mesh shows to be too thin to be printed, or too narrow \
          to stay open, is lost or closed wherever the lattice stands, and what it shows to be wide enough stays. Where the samples have \
          another number of pieces, tunnels or voids than the mesh, the design is made of all cells that it touches, or of those that it fills, \
          if that has the right numbers. First what is not \
          printed is taken away from the design; then the gaps between bodies that are nearer than the gap that closes in the process, by \
          their exact distance, are filled, and bodies that touch are joined; then what else is printed beside the design is added. Of each, \
          all samples that change no Betti \
          number are taken away; what stays is one small remnant for each change, and the change it makes is counted from the Euler \
          characteristic and by union-find. The changes add up to the differences of the Betti numbers. What is to be thickened or widened \
          has been, on a lattice of the place, and was printed again; bodies to be moved apart have been moved, and measured again.",
    limits: "An estimate: the lattice has a few cells across the element, and what is finer than a cell is not seen; where the lattice \
             sees other numbers than the mesh has, a notice says so, and neither changes smaller than an element nor several tunnels at one \
             place are told. Where it does not show bodies apart that fuse, and where there is none, what fuses is told pair by pair: the \
             first that joins two pieces fuses them, each further one makes a tunnel. Positions of beads are those of the lattice, not of a slicer. \
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
        let fusing = Fusing::new(part, process);
        let altered = match part.as_printed(process, LAMBDA)? {
            Some(printed) => {
                let mut laid = Laid::new(part, process, context, &printed)?;
                let altered = Altered::on_lattice(part, &mut laid, &fusing, context)?;
                let (wide, before) = (printed.designed.cells.wide, words(laid.seen));
                measured.cover = format!("Laid down with {wide} cells across the element: {before} as designed");
                measured.cover.push_str(&match altered.after {
                    Some(after) => format!(", {} as printed.", words(after)),
                    None => "; the lattice does not show all bodies apart that fuse, so that only their distances tell what fuses, and no \
                             numbers as printed are given."
                        .into(),
                });
                measured.notices.extend(unlike(&laid));
                altered
            }
            None => {
                let width = short(process.element.width_mm);
                let why = format!("an element of {width} mm is too fine for a lattice of the whole part");
                let altered = Altered::by_distance(&fusing);
                if altered.events.is_empty() {
                    return Ok(Outcome::NotApplicable(why));
                }
                let text = format!("{why}; only whether bodies fuse was looked at");
                measured.notices.push(Notice::new("topology-by-distance", text.clone()));
                measured.cover = text;
                altered
            }
        };
        let events = altered.events;
        let judge = Judge { part, context, process, limits, fusing };
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

/// How often something happens at so many places, in words: at one place it may happen several times.
fn counted(one: &str, many: &str, [places, times]: [u64; 2]) -> String {
    match (places, times) {
        (_, 1) => one.into(),
        (1, _) if many.starts_with("places") => format!("{one} {times} times"),
        _ if many.starts_with("places") && times > places => format!("{places} {many}, {times} times in all"),
        _ => format!("{times} {many}"),
    }
}

/// Pieces, tunnels and voids in words.
fn words(b: Betti) -> String {
    let many = |n: u64, one: &str| format!("{n} {one}{}", if n == 1 { "" } else { "s" });
    format!("{}, {} and {}", many(b.pieces, "piece"), many(b.tunnels, "tunnel"), many(b.voids, "void"))
}

/// Says where the lattice sees another part than the mesh describes.
fn unlike(laid: &Laid) -> Option<Notice> {
    let has = laid.has.filter(|has| *has != laid.seen)?;
    let text = format!(
        "the lattice of the as-printed part sees {}, the mesh has {}: changes smaller than an element, and of several tunnels at one place, \
         are not told",
        words(laid.seen),
        words(has)
    );
    Some(Notice::new("topology-unresolved", text))
}

struct Judge<'a> {
    part: &'a Part,
    context: &'a Context,
    process: &'a Process,
    limits: Limits,
    fusing: Fusing<'a>,
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
            Spot { at_mm: reported(self.part, e.at), box_mm: None, value: times, low: times, high: times }
        };
        f.places = order.iter().map(spot).collect();
        let mut bodies: Vec<u64> = order.iter().flat_map(|e| e.bodies.iter().copied()).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let named = if bodies.len() > 1 {
            let list: Vec<String> = bodies.iter().take(8).map(u64::to_string).collect();
            format!(" (bodies {}{})", list.join(", "), if bodies.len() > 8 { " and others" } else { "" })
        } else {
            String::new()
        };
        f.message = format!("{}{named}", counted(one, many, [order.len() as u64, times]));
        f.fix = match kind {
            "fused" => self.parted(&order),
            _ => {
                // What grows by what the narrowest of them needs.
                order.sort_by(|a, b| b.missing.total_cmp(&a.missing));
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
        let meets = |p: &BodyPair, e: &Event| p.bodies.iter().all(|&b| e.bodies.contains(&(u64::from(b) + 1)));
        let own = |p: &&BodyPair| events.iter().any(|e| meets(p, e));
        let pairs: Vec<&BodyPair> = self.fusing.with_gaps().filter(own).take(apart::TRIED).collect();
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
    use crate::geometry::{TriangleMesh, cuboid, extruded, revolved};
    use crate::part::Up;

    #[test]
    fn places_are_counted_as_places() {
        let (one, many) = ("a slot is bridged", "places where a slot is bridged");
        assert_eq!(counted(one, many, [1, 1]), "a slot is bridged");
        assert_eq!(counted(one, many, [1, 3]), "a slot is bridged 3 times");
        assert_eq!(counted(one, many, [7, 7]), "7 places where a slot is bridged");
        assert_eq!(counted(one, many, [70, 99]), "70 places where a slot is bridged, 99 times in all");
        assert_eq!(counted("a void is enclosed", "voids are enclosed", [2, 15]), "15 voids are enclosed");
    }

    /// A mesh turned by so many degrees about x and then about z.
    fn turned(mesh: &TriangleMesh, about_x: f64, about_z: f64) -> TriangleMesh {
        let ((s, c), (t, u)) = (about_x.to_radians().sin_cos(), about_z.to_radians().sin_cos());
        mesh.transformed([[u, -t * c, t * s], [t, u * c, -u * s], [0.0, s, c]], [0.013, 0.007, 0.011])
    }

    /// What is told of a mesh under fdm: kinds with their numbers, the cover line, and the codes of notices.
    fn told(mesh: TriangleMesh) -> (Vec<(String, f64)>, String, Vec<String>) {
        let process = Process::named("fdm").unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
        let Outcome::Measured(measured) = Topology.run(&part, &process, &context).unwrap() else { panic!() };
        let found = measured.findings.iter().map(|f| (f.kind.clone(), f.value)).collect();
        (found, measured.cover, measured.notices.iter().map(|n| n.code.clone()).collect())
    }

    #[test]
    fn a_facet_without_area_is_no_tunnel() {
        let mut mesh = cuboid([0.0; 3], [8.0; 3]);
        mesh.triangles.extend([[0, 0, 1], [2, 2, 3]]);
        let (found, cover, notices) = told(mesh);
        assert!(found.is_empty() && cover.contains("1 piece, 0 tunnels and 0 voids as designed"), "{cover}");
        assert!(notices.is_empty(), "{notices:?}");
    }

    /// A square ring, split by a slot so wide, 1 mm high.
    fn split_ring(gap: f64) -> TriangleMesh {
        let (l, u) = (2.0 - 0.5 * gap, 2.0 + 0.5 * gap);
        let outline = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, l],
            [2.5, l],
            [2.5, 1.5],
            [1.5, 1.5],
            [1.5, 2.5],
            [2.5, 2.5],
            [2.5, u],
            [4.0, u],
            [4.0, 4.0],
            [0.0, 4.0],
        ];
        let caps = [
            [0, 1, 5],
            [1, 4, 5],
            [1, 2, 3],
            [1, 3, 4],
            [0, 5, 6],
            [0, 6, 11],
            [11, 6, 7],
            [11, 7, 10],
            [7, 8, 10],
            [8, 9, 10],
        ];
        extruded(&outline, &caps, 1.0)
    }

    #[test]
    fn slots_and_sheets_are_told_by_their_widths_however_they_stand() {
        let bridged: &[(String, f64)] = &[("bridged".into(), 1.0)];
        for (gap, wanted) in [(0.21, &[][..]), (0.19, bridged)] {
            let (found, cover, notices) = told(turned(&split_ring(gap), 27.0, 19.0));
            assert!(found == wanted && notices.is_empty(), "{gap}: {found:?}, {notices:?}, {cover}");
        }
        // More than half of the element lies in it.
        let (found, cover, _) = told(turned(&cuboid([0.0; 3], [4.0, 0.19, 4.0]), 27.0, 19.0));
        assert!(found.is_empty(), "{found:?}, {cover}");
    }

    #[test]
    fn a_slanting_gap_that_closes_fuses_its_bodies_and_one_that_does_not_changes_nothing() {
        let fused: &[(String, f64)] = &[("fused".into(), 1.0)];
        for (gap, wanted) in [(0.22, &[][..]), (0.17, fused)] {
            for [x, z] in [[27.0, 19.0], [8.0, 41.0], [63.0, 5.0]] {
                let bodies = cuboid([0.0; 3], [4.0; 3]).joined(&cuboid([4.0 + gap, 0.3, -0.4], [7.0, 4.5, 5.0]));
                let (found, cover, _) = told(turned(&bodies, x, z));
                assert!(found == wanted, "{gap} at {x}, {z}: {found:?}, {cover}");
            }
        }
    }

    #[test]
    fn a_pin_that_turns_in_its_hole_is_not_bridged_to_it_however_both_stand() {
        let process = Process::named("sla").unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.025 };
        let pin = revolved(&[[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.0, 1.0]], 48);
        for (gap, wanted) in [(0.205, &[][..]), (0.19, &["fused", "hole-closed"])] {
            // The corners of both polygons lie on the same rays.
            let hole = 0.5 + gap / (std::f64::consts::PI / 48.0).cos();
            let collar = revolved(&[[hole, 0.0], [1.2, 0.0], [1.2, 1.0], [hole, 1.0]], 48);
            let part = Part::new(turned(&pin.clone().joined(&collar), 27.0, 19.0), Up::PlusZ, 1e-6, 1.0).unwrap();
            let Outcome::Measured(measured) = Topology.run(&part, &process, &context).unwrap() else { panic!() };
            let found: Vec<&str> = measured.findings.iter().map(|f| f.kind.as_str()).collect();
            assert_eq!(found, wanted, "{gap}: {}", measured.cover);
        }
    }

    #[test]
    fn a_wedge_changes_nothing_and_a_void_behind_too_thin_a_wall_opens() {
        let wedge = extruded(&[[0.0, 0.0], [4.0, 0.0], [4.0, 0.7]], &[[0, 1, 2]], 3.0);
        let (found, cover, notices) = told(turned(&wedge, 27.0, 19.0));
        assert!(found.is_empty() && notices.is_empty(), "{found:?}, {notices:?}, {cover}");
        let walled = cuboid([0.0; 3], [3.0; 3]).joined(&cuboid([0.08, 0.8, 0.8], [2.2; 3]).flipped());
        let (found, cover, notices) = told(turned(&walled, 27.0, 19.0));
        assert!(found == [("void-opened".to_string(), 1.0)] && notices.is_empty(), "{found:?}, {notices:?}, {cover}");
    }

    #[test]
    fn bodies_that_meet_at_two_places_fuse_and_make_a_tunnel() {
        let bar = |x: f64| cuboid([x, 0.0, 0.0], [x + 1.0, 3.0, 1.0]);
        let across = |y: f64| cuboid([0.0, y, 0.0], [4.0, y + 1.0, 1.0]);
        // Four bars about a square, each 0.1 mm from the next.
        let ring = bar(0.0).joined(&bar(3.0)).joined(&across(3.1)).joined(&across(-1.1));
        let (found, cover, notices) = told(ring);
        assert_eq!(found, [("fused".to_string(), 3.0), ("bridged".to_string(), 1.0)], "{cover} {notices:?}");
        assert!(
            cover.ends_with("4 pieces, 0 tunnels and 0 voids as designed, 1 piece, 1 tunnel and 0 voids as printed.")
        );
        // Two cubes that share an edge are one piece in print.
        let (found, cover, _) = told(cuboid([0.0; 3], [1.0; 3]).joined(&cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0])));
        assert_eq!(found, [("fused".to_string(), 1.0)], "{cover}");
        assert!(cover.contains("2 pieces, 0 tunnels and 0 voids as designed, 1 piece, 0 tunnels"), "{cover}");
    }

    #[test]
    fn a_curved_gap_that_closes_has_no_pores_where_the_coats_of_its_faces_meet() {
        let process = Process::named("sla").unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.05 };
        let ball = crate::geometry::Primitive::parse("ball:4mm").unwrap().mesh(crate::units::Length::mm(0.02));
        for (gap, [x, z]) in [(0.1, [63.0, 5.0]), (0.1, [61.0, 23.0]), (0.15, [8.0, 41.0])] {
            let over = ball.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0, 0.0, 4.0 + gap]);
            let bodies = over.joined(&cuboid([-4.5, -4.5, -2.0], [4.5, 4.5, 0.0]));
            let part = Part::new(turned(&bodies, x, z), Up::PlusZ, 1e-6, 1.0).unwrap();
            let Outcome::Measured(measured) = Topology.run(&part, &process, &context).unwrap() else { panic!() };
            let found: Vec<(&str, f64)> = measured.findings.iter().map(|f| (f.kind.as_str(), f.value)).collect();
            assert_eq!(found, [("fused", 1.0)], "{gap} at {x}, {z}: {}", measured.cover);
        }
    }

    #[test]
    fn a_lying_round_hole_that_is_wide_enough_stays_however_it_is_turned() {
        use crate::geometry::revolved;
        // A ring of 3 × 3 mm and 4 mm tall, laid down and turned; in fdm gaps of up to 0.2 mm close.
        for (inner, turn) in [(0.125, 27.0), (0.13, 63.0), (0.125, 0.0)] {
            let wall = [[inner, 0.0], [1.5, 0.0], [1.5, 4.0], [inner, 4.0]];
            let (found, cover, _) = told(turned(&revolved(&wall, 24), 90.0, turn));
            assert!(
                found.is_empty() && cover.ends_with("1 piece, 1 tunnel and 0 voids as printed."),
                "{turn}: {cover}"
            );
        }
    }

    #[test]
    fn the_gap_that_is_advised_is_as_wide_as_one_that_stays_open() {
        // Four bars about a square, each so far from the next; in sla 0.2 mm stay open.
        let ring = |gap: f64| {
            let bar = |x: f64| cuboid([x, 0.0, 0.0], [x + 5.0, 13.0, 5.0]);
            let across = |y: f64| cuboid([0.0, y, 0.0], [18.0, y + 5.0, 5.0]);
            turned(&bar(0.0).joined(&bar(13.0)).joined(&across(13.0 + gap)).joined(&across(-5.0 - gap)), 27.0, 19.0)
        };
        let process = Process::named("sla").unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        let part = Part::new(ring(0.1), Up::PlusZ, 1e-6, 1.0).unwrap();
        let Outcome::Measured(measured) = Topology.run(&part, &process, &context).unwrap() else { panic!() };
        let bridged = measured.findings.iter().find(|f| f.kind == "bridged").unwrap();
        let by = bridged.fix.split_whitespace().find_map(|word| word.parse::<f64>().ok());
        assert!(by.is_none_or(|by| by >= 0.1 - 1e-9), "{}", bridged.fix);
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
