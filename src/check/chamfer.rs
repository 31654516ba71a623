//! Chamfers put under a ledge before they are advised: whether its wall goes down far enough, and nothing is in the way.

use super::contract::limits_of;
use super::rods::plain;
use super::topple::{round, toppled_by};
use crate::access::support_angle;
use crate::geometry::Prism;
use crate::geometry::triangle::closest_on_segments;
use crate::geometry::vector::{Vec3, add, along, distance, dot, scale, sub, unit};
use crate::layer::{Ceiling, stretch};
use crate::part::Part;
use crate::process::Process;
use crate::units::short;

/// Pieces that the anchors of a ledge are tried in are no longer than this, millimetres, as long as that makes no more of them; anchors
/// shorter than half a piece, that follow each other, are one.
const PIECE_MM: f64 = 1.0;
const PIECES: f64 = 100.0;
/// And no fewer of them.
const FEWEST: f64 = 3.0;
/// What is no farther into a piece from its ends than this share of it does not count: what stands beside the anchor begins there.
const BESIDE: f64 = 0.01;
/// Heights at which the wall behind a chamfer is felt for, as shares of its own.
const FELT: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// A wall that leans away from the chamfer by more than this share of its reach, and no less than that length in millimetres, does not
/// carry it.
const AWAY: (f64, f64) = (0.25, 0.05);

/// Cosine of the angle up to which a facet of the wall looks out of it.
const LOOKS_OUT: f64 = 0.5;

/// What is no farther from an anchor, in millimetres, lies on it.
const AT_ANCHOR: f64 = 1e-3;

/// Steps between the places along a ledge's way out where the material above is measured.
const LOOKS_UP: usize = 8;

/// What trying a chamfer under a ledge has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chamfer {
    /// Whether the plate is nearer than it is high.
    is_cut: bool,
    /// How far it reaches out where the ledge is deepest, and how far down.
    leg: f64,
    height: f64,
    /// Its angle from the horizontal, degrees.
    angle: f64,
    /// Places along the anchors: with room; where the wall ends too soon; where something is in the way.
    roomy: usize,
    loose: usize,
    blocked: usize,
    /// How much material lies above what of the ledge is beyond the limit, at most along its way out.
    above: f64,
    /// How far inside the footprint the centre of mass lies with it, if the part topples then and did not.
    topples: Option<f64>,
}

/// What is found at one place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Roomy,
    Loose,
    Blocked,
    /// The ledge holds itself here.
    Held,
}

impl Chamfer {
    /// Lays the chamfer that leaves no more than `limit` of a ledge hanging along all its anchors; `None` without an overhang angle, and
    /// where the ledge reaches out from a strand.
    ///
    /// # Cost
    /// Some rays, the facets in a box and a walk over the ledge's facets for each of some 100 places, or of the anchors if they are longer.
    pub fn of(part: &Part, process: &Process, ledge: &Ceiling, limit: f64) -> Option<Self> {
        let reach = ledge.cantilever?;
        // A chamfer along the anchors brings no strand between them nearer to what reaches out beyond it.
        let in_plan = |p: Vec3| [p[0], p[1], 0.0];
        let held = in_plan(reach.ends[1]);
        let by =
            |anchor: &[Vec3; 2]| distance(closest_on_segments(anchor.map(in_plan), [held; 2]).0, held) <= AT_ANCHOR;
        if !ledge.anchors.iter().any(by) {
            return None;
        }
        let angle = support_angle(process).filter(|a| *a > 0.0 && *a < 90.0)?;
        let leg = (100.0 * (reach.high_mm - limit) - 1e-4).ceil() / 100.0;
        let slope = angle.to_radians().tan();
        let gap = limits_of(process, "narrow-gap").and_then(|l| l.fail.or(l.warn)).unwrap_or(0.0);
        let tried = Trying { part, ledge, limit, leg, slope, gap };
        let pieces = tried.pieces();
        let found: Vec<Place> = pieces.iter().map(|piece| tried.at(piece)).collect();
        let count = |of: Place| found.iter().filter(|p| **p == of).count();
        let beyond = 1.0 - limit / reach.high_mm;
        let back = sub(reach.ends[1], reach.ends[0]);
        let places = (0..=LOOKS_UP).map(|n| along(reach.ends[0], back, beyond * n as f64 / LOOKS_UP as f64));
        let up = |from| part.distance().first_hit(from, [0.0, 0.0, 1.0], 4.0 * part.step() + 1e-6, part.extent()[2]);
        let above = places.filter_map(up).map(|(height, _)| height).fold(0.0, f64::max);
        let is_cut = ledge.extent.0[2] < leg * slope;
        // One that is cut off at the plate broadens the foot.
        let added: Vec<(f64, Vec3)> =
            pieces.iter().zip(&found).filter_map(|(p, place)| tried.added(p, *place)).collect();
        let topples = if is_cut { None } else { toppled_by(part, process, &added) };
        Some(Chamfer {
            is_cut,
            topples,
            leg,
            height: (100.0 * leg * slope - 1e-4).ceil() / 100.0,
            angle,
            roomy: count(Place::Roomy),
            loose: count(Place::Loose),
            blocked: count(Place::Blocked),
            above,
        })
    }

    pub fn has_room(&self) -> bool {
        self.roomy > 0 && self.loose + self.blocked == 0 && self.topples.is_none()
    }

    /// In words, for a limit of ledges.
    pub fn words(&self, limit: f64) -> String {
        let cut = if self.is_cut { ", cut off at the plate" } else { "" };
        let size = format!("{} × {} mm", plain(self.leg), plain(self.height));
        let (tried, limit) = (self.roomy + self.loose + self.blocked, short(limit));
        let why = match self.loose >= self.blocked {
            true => "the wall that it would start from does not go down so far",
            false => "something is in the way",
        };
        let back = match self.above > 0.0 && self.above <= 2.0 * self.leg {
            true => {
                format!("cut it back to {limit} mm with the {} mm of material above", plain(self.above))
            }
            false => format!("let it reach out no more than {limit} mm"),
        };
        match (self.roomy, self.loose + self.blocked) {
            (0, 0) => back,
            (_, 0) if self.topples.is_some() => format!(
                "{back}; with a chamfer of {size} under it the part would topple: its centre of mass would lie {} of its footprint",
                self.topples.map_or(String::new(), where_it_lies)
            ),
            (_, 0) => format!(
                "put a chamfer of {size} under it{cut}, {}° steep: there is room for it, checked on the surface at {tried} places, and no more than \
                 {limit} mm then hangs over; or {back}",
                short(self.angle)
            ),
            (0, _) => format!("{back}; a chamfer of {size} has no room under it: {why}"),
            (n, _) => format!(
                "{back}; a chamfer of {size} under it has room at {n} of {tried} places, checked on the surface; elsewhere {why}"
            ),
        }
    }
}

/// How far inside a footprint, or outside.
fn where_it_lies(depth: f64) -> String {
    let far = short(round(depth.abs()));
    if depth < 0.0 { format!("{far} mm outside") } else { format!("only {far} mm inside") }
}

/// A chamfer along the anchors of a ledge.
struct Trying<'a> {
    part: &'a Part,
    ledge: &'a Ceiling,
    limit: f64,
    leg: f64,
    /// How far down it goes for each millimetre out.
    slope: f64,
    /// What has to stay free below it.
    gap: f64,
}

/// A piece of an anchor: its middle, the direction out over the ledge, and its length.
struct Piece {
    at: Vec3,
    out: Vec3,
    long: f64,
}

impl Trying<'_> {
    /// All of the anchors, in pieces.
    fn pieces(&self) -> Vec<Piece> {
        let whole: f64 = self.ledge.anchors.iter().map(|[a, b]| distance(*a, *b)).sum();
        let most = PIECE_MM.max(whole / PIECES).min(whole / FEWEST);
        let (mut found, mut passed) = (Vec::new(), 0.0);
        for &[a, b] in &self.ledge.anchors {
            let (long, run) = (distance(a, b), unit(sub(b, a)));
            passed += long;
            if long <= 0.0 || passed < 0.5 * most {
                continue;
            }
            passed = 0.0;
            let count = (long / most).ceil().max(1.0);
            let middle = |n: usize| along(a, run, (n as f64 + 0.5) * long / count);
            let out = unit([run[1], -run[0], 0.0]);
            found.extend((0..count as usize).map(|n| Piece { at: middle(n), out, long: long / count }));
        }
        found
    }

    /// The volume of the chamfer at a piece with room for it, and its centre of mass.
    fn added(&self, piece: &Piece, place: Place) -> Option<(f64, Vec3)> {
        let (leg, high) = (self.leg, self.leg * self.slope);
        let middle = along(piece.at, piece.out, leg / 3.0);
        (place == Place::Roomy).then(|| (0.5 * leg * high * piece.long, along(middle, [0.0, 0.0, -1.0], high / 3.0)))
    }

    /// What a chamfer meets that starts at a piece of an anchor and goes out.
    fn at(&self, piece: &Piece) -> Place {
        let Piece { at, out, .. } = *piece;
        let start = along(at, out, 1e-3 * self.leg);
        let facets = &self.ledge.facets;
        let Some([_, end]) = stretch(self.part.mesh(), facets, [start[0], start[1]], [out[0], out[1]]) else {
            return Place::Held;
        };
        let reach = distance([at[0], at[1], 0.0], [end[0], end[1], 0.0]);
        if reach <= self.limit {
            return Place::Held;
        }
        let leg = self.leg.min(reach);
        let below = |share: f64| [at[0], at[1], at[2] - share * leg * self.slope];
        if FELT.iter().any(|&share| below(share)[2] > 0.0 && !self.is_carried(below(share), out, leg * (1.0 - share))) {
            return Place::Loose;
        }
        // The part of its underside that is above the plate.
        let foot = (at[2] / (leg * self.slope)).min(1.0);
        let (tip, foot) = (along(at, out, leg), along(below(foot), out, leg * (1.0 - foot)));
        match self.is_free(piece, [tip, foot]) && self.is_solid(piece, foot[2]) {
            true => Place::Roomy,
            false => Place::Blocked,
        }
    }

    /// Whether the wall stands behind a place of the chamfer's back, seen from its underside so far out.
    fn is_carried(&self, back: Vec3, out: Vec3, reach: f64) -> bool {
        let slack = (AWAY.0 * self.leg).max(AWAY.1);
        let from = along(back, out, reach + 4.0 * self.part.step() + 1e-4);
        self.part.distance().first_hit(from, out.map(|x| -x), 0.0, reach + slack).is_some()
    }

    /// Whether no hole or pocket opens in the wall behind a piece of the chamfer, down to a height: right behind the wall there are no facets but
    /// those that look out of it.
    fn is_solid(&self, piece: &Piece, low: f64) -> bool {
        let (deep, high) = (1e-2 * self.leg, piece.at[2] - low);
        let wide = scale([-piece.out[1], piece.out[0], 0.0], 0.9 * piece.long);
        let top = along(along(piece.at, wide, -0.5), [0.0, 0.0, 1.0], -0.02 * high);
        let back = [1e-3 * deep, deep].map(|by| along(top, piece.out, -by));
        let down = [0.0, 0.0, -0.96 * high];
        let base = vec![back[0], back[1], add(back[1], down), add(back[0], down)];
        let surface = self.part.distance();
        !Prism { base, along: wide }.is_met(surface, |f| dot(surface.normal(f), piece.out) < LOOKS_OUT)
    }

    /// Whether nothing lies under a piece of the chamfer, from its tip to its foot and as far below as has to stay free, but for what it
    /// lies on; and no other body there or in it, with which it would be one.
    fn is_free(&self, piece: &Piece, [tip, foot]: [Vec3; 2]) -> bool {
        let (long, way) = (distance(tip, foot), unit(sub(foot, tip)));
        let away = unit([piece.out[0] * self.slope, piece.out[1] * self.slope, -1.0]);
        let beside = (BESIDE * piece.long + 4.0 * self.part.step()).min(0.4 * piece.long);
        let wide = piece.long - 2.0 * beside;
        let run = scale([-piece.out[1], piece.out[0], 0.0], wide);
        let free = scale(away, self.gap.max(1e-6));
        let beside = |p: Vec3| along(p, run, -0.5);
        let ends = [0.02, 0.95].map(|share| beside(along(tip, way, share * long)));
        let under = Prism { base: vec![ends[0], ends[1], add(ends[1], free), add(ends[0], free)], along: run };
        let [tip, foot, top] = [tip, foot, piece.at].map(beside);
        let [tip_below, low] = [tip, foot].map(|p| add(p, free));
        let whole = Prism { base: vec![top, tip, tip_below, low, [top[0], top[1], low[2]]], along: run };
        let body = |facet: u32| self.part.health().facet_body.get(facet as usize).copied();
        let own = self.ledge.facets.first().and_then(|&f| body(f));
        let surface = self.part.distance();
        !under.is_met(surface, |_| true) && !whole.is_met(surface, |f| body(f) != own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::hanging::ceilings_of;
    use crate::geometry::{TriangleMesh, cuboid, extruded};
    use crate::part::Up;

    /// A post 4 mm thick and so tall below an arm of 3 mm that is 2 mm thick, all 6 mm deep; what stands under the post is a plate.
    fn gallows(below: f64) -> TriangleMesh {
        let top = below + 2.0;
        let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, below], [7.0, below], [7.0, top], [0.0, top]];
        extruded(&outline, &[[0, 1, 2], [0, 2, 5], [2, 3, 4], [2, 4, 5]], 6.0)
    }

    fn tried(mesh: TriangleMesh) -> Chamfer {
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
        let process = Process::named("fdm").unwrap();
        let all = ceilings_of(&part, &process, 0);
        let ledges = all.iter().filter(|c| c.cantilever.is_some());
        let ledge = ledges.max_by(|a, b| a.extent.0[2].total_cmp(&b.extent.0[2])).unwrap();
        Chamfer::of(&part, &process, ledge, 0.4).unwrap()
    }

    #[test]
    fn a_ledge_on_a_wall_takes_a_chamfer_that_leaves_the_limit() {
        let found = tried(gallows(10.0));
        assert!(found.has_room() && found.leg >= 2.6 && found.leg < 2.7 && found.height == found.leg, "{found:?}");
        assert!((found.above - 2.0).abs() < 1e-9 && found.angle == 45.0, "{found:?}");
        let said = found.words(0.4);
        assert!(said.starts_with("put a chamfer of 2.6") && said.contains("with the 2 mm of material above"), "{said}");
        // A wedge above, from 0.1 mm at its edge to 2.3 mm at the wall.
        let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 10.0], [7.0, 10.0], [7.0, 10.1], [4.0, 12.3], [0.0, 12.3]];
        let wedge = tried(extruded(&outline, &[[0, 1, 2], [0, 2, 5], [0, 5, 6], [2, 3, 4], [2, 4, 5]], 6.0));
        assert!((wedge.above - (2.3 - 0.4 * 2.2 / 3.0)).abs() < 0.02, "{wedge:?}");
        // Nearer to the plate than it is high it ends on the plate.
        let low = tried(gallows(1.5));
        assert!(low.has_room() && low.words(0.4).contains("mm under it, cut off at the plate,"), "{}", low.words(0.4));
        assert!(!said.contains("cut off"), "{said}");
    }

    #[test]
    fn a_chamfer_has_no_room_above_something_or_on_a_wall_that_ends() {
        let shelf = cuboid([5.0, 0.0, 0.0], [7.0, 6.0, 9.0]);
        let found = tried(gallows(10.0).joined(&shelf));
        assert!(found.roomy == 0 && found.blocked > 0 && !found.words(0.4).contains("put a chamfer"), "{found:?}");
        // The post steps back 1 mm below the arm.
        let outline =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 9.0], [4.0, 9.0], [4.0, 10.0], [7.0, 10.0], [7.0, 12.0], [0.0, 12.0]];
        let caps = [[0, 1, 2], [0, 2, 7], [2, 3, 4], [2, 4, 7], [4, 5, 6], [4, 6, 7]];
        let found = tried(extruded(&outline, &caps, 6.0));
        assert!(found.roomy == 0 && found.loose > 0, "{found:?}");
    }

    #[test]
    fn a_chamfer_that_topples_the_part_is_not_advised() {
        let hook = |arm: f64| {
            let x = 10.0 + arm;
            let outline = [[0.0, 0.0], [10.0, 0.0], [10.0, 40.0], [x, 40.0], [x, 46.0], [0.0, 46.0]];
            tried(extruded(&outline, &[[0, 1, 2], [0, 2, 5], [2, 3, 4], [2, 4, 5]], 6.0))
        };
        // Without it the centre of mass lies 1.9 mm inside; the chamfer of 19.6 mm weighs 192.1 of then 772.1 parts.
        let found = hook(20.0);
        let outside = (400.0 * 5.0 + 180.0 * 15.0 + 192.08 * (10.0 + 19.6 / 3.0)) / 772.08 - 10.0;
        assert!(!found.has_room() && (found.topples.unwrap() + outside).abs() < 0.05, "{found:?} {outside}");
        let said = found.words(0.4);
        assert!(
            said.contains("the part would topple: its centre of mass would lie 0.2")
                && said.contains("mm outside of its footprint"),
            "{said}"
        );
        assert!(hook(10.0).has_room());
    }

    #[test]
    fn a_chamfer_meets_what_is_narrow_wherever_it_stands() {
        for y in [0.1, 0.7, 1.3, 2.1, 3.3, 4.9, 5.7] {
            let post = cuboid([5.0, y, 0.0], [6.0, y + 0.2, 9.0]);
            let found = tried(gallows(10.0).joined(&post));
            assert!(!found.has_room() && found.roomy > 0 && found.blocked > 0, "{y}: {found:?}");
            assert!(!found.words(0.4).contains("there is room"), "{y}");
        }
        // A body that lies in it would be one with the part.
        let found = tried(gallows(10.0).joined(&cuboid([4.5, 2.0, 8.8], [5.0, 4.0, 9.5])));
        assert!(!found.has_room() && found.roomy > 0 && found.blocked > 0, "{found:?}");
        // A slot in the post, wherever it opens.
        for (z, is_open) in [(7.6, true), (8.1, true), (8.8, true), (9.4, true), (5.0, false)] {
            let post = [[0.0, 0.0], [4.0, 0.0], [4.0, z], [2.0, z], [2.0, z + 0.3], [4.0, z + 0.3], [4.0, 10.0]];
            let outline = [&post[..], &[[7.0, 10.0], [7.0, 12.0], [0.0, 12.0]]].concat();
            let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 9], [3, 4, 9], [4, 5, 6], [4, 6, 9], [6, 7, 8], [6, 8, 9]];
            let found = tried(extruded(&outline, &caps, 6.0));
            assert_eq!(found.has_room(), !is_open, "{z}: {found:?}");
        }
        // What ends below the gap under it is not in the way.
        assert!(tried(gallows(10.0).joined(&cuboid([5.0, 2.0, 0.0], [6.0, 2.2, 7.0]))).has_room());
    }
}
