//! Ribs put under a ceiling before they are advised: it is measured again between them, and what they stand on is looked for.

use super::contract::limits_of;
use super::hanging::{LEDGE, respanned};
use super::place::reported;
use super::rods::plain;
use crate::geometry::vector::{Vec3, along, distance, dot, sub, unit};
use crate::layer::{Ceiling, Reach, above, stretch};
use crate::part::Part;
use crate::process::Process;
use crate::units::{hundredths, short};

/// Ribs under one ceiling at most: what needs more is better supported.
const MOST: usize = 8;
/// Rounds of looking for the span that is still too long.
const ROUNDS: usize = 3;
/// Thickness of a rib where the process asks for none of a wall, millimetres.
const THICK: f64 = 1.0;
/// How far a rib is drawn beyond the ceiling, so that it ends in what bounds it, millimetres.
const BEYOND: f64 = 0.05;
/// So far below the ceiling the ends of a rib are looked at, in layers.
const UNDER: f64 = 0.5;
/// What rounding to hundredths may take from the end of a rib, millimetres; one that it would move is told as much longer and higher than it is measured.
const ROUNDED: f64 = 0.01;
/// What rounding moves by no more than this it leaves where it is, millimetres.
const EXACT: f64 = 1e-5;

/// A wall under a ceiling: from end to end at the ceiling's height.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Rib {
    ends: [Vec3; 2],
}

impl Rib {
    /// The way from end to end, level.
    fn way(&self) -> Vec3 {
        let [a, b] = self.ends;
        unit([b[0] - a[0], b[1] - a[1], 0.0])
    }

    /// The ends moved apart by so much each.
    fn longer(&self, by: f64) -> [Vec3; 2] {
        [along(self.ends[0], self.way(), -by), along(self.ends[1], self.way(), by)]
    }

    /// The ends as they are read: told, and rounded to hundredths.
    fn read(&self, part: &Part) -> [Vec3; 2] {
        self.told(part).map(|p| part.to_build(reported(part, p).map(in_hundredths)))
    }

    /// The ends as they are told: longer and higher where rounding to hundredths would make it shorter or lower.
    fn told(&self, part: &Part) -> [Vec3; 2] {
        let ways = [self.way(), [0.0, 0.0, 1.0]].map(|way| part.direction_to_file(way));
        let is_round = |p: &Vec3| {
            let at = reported(part, *p);
            let moved = sub(at.map(in_hundredths), at);
            ways.iter().all(|&way| dot(moved, way).abs() < EXACT)
        };
        if self.ends.iter().all(is_round) {
            return self.ends;
        }
        self.longer(BEYOND + ROUNDED).map(|p| along(p, [0.0, 0.0, 1.0], ROUNDED))
    }
}

/// What trying ribs has shown.
#[derive(Debug, Clone, PartialEq)]
pub enum Ribbing {
    /// With these ribs no span is longer than the limit.
    Holds(Held),
    /// More would be needed than are advised.
    TooMany,
    /// Nowhere across the span does one reach from border to border, or it would leave a gap that closes beside it.
    NoPlace,
    /// A rib as tall as this does, but stands only if it is so thick, which leaves no room beside it.
    TooTall { tall: f64, thick: f64 },
    /// So long is a span that is left with all ribs in place.
    StillSpans(f64),
    /// So far does what is left with all ribs in place reach out from them or from an anchor: farther than before and than a ledge may.
    StillReaches(f64),
    /// One would stand on another body, or come nearer to one than the process keeps apart.
    Joins,
}

/// Ribs under which a ceiling holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    ribs: Vec<Rib>,
    thick: f64,
    /// Heights of the lowest and the tallest.
    tall: [f64; 2],
    /// Whether all stand on the part, and none on the plate.
    on_part: bool,
    /// Whether one reaches from wall to wall over its whole height.
    closes: bool,
    /// The longest span that is left, for certain.
    span: f64,
}

impl Ribbing {
    /// Puts ribs across the longest span of a ceiling, and across what is then still too long.
    ///
    /// # Cost
    /// A search of the ceiling's plan for each round, three at most, twice where ribs have to be thicker than a wall to stand.
    pub fn of(part: &Part, process: &Process, ceiling: &Ceiling, limit: f64) -> Self {
        let wall = limits_of(process, "thin-wall").and_then(|l| l.warn.or(l.fail)).unwrap_or(THICK);
        let first = Trying { part, process, ceiling, limit, thick: wall }.run();
        let slender = limits_of(process, "tall-feature").and_then(|l| l.warn.or(l.fail));
        match (&first, slender) {
            (Ribbing::Holds(held), Some(most)) if held.tall[1] > most * wall => {
                // Rounded up to tenths: a tall rib has to stand by itself before the ceiling reaches it.
                let thick = (10.0 * held.tall[1] / most - 1e-6).ceil() / 10.0;
                match (Trying { part, process, ceiling, limit, thick }).run() {
                    Ribbing::NoPlace => Ribbing::TooTall { tall: held.tall[1], thick },
                    found => found,
                }
            }
            _ => first,
        }
    }

    pub fn holds(&self) -> bool {
        matches!(self, Ribbing::Holds(_))
    }

    /// In words, for a limit of spans.
    pub fn words(&self, part: &Part, limit: f64) -> String {
        let limit = short(limit);
        match self {
            Ribbing::Holds(held) => held.words(part),
            Ribbing::TooMany => {
                format!("more than {MOST} ribs would be needed under it for spans of no more than {limit} mm")
            }
            Ribbing::NoPlace => "no rib has a place across it".into(),
            Ribbing::Joins => "a rib under it would join it to another body".into(),
            Ribbing::TooTall { tall, thick } => format!(
                "a rib under it would be {} mm tall and stand only if it were {} mm thick, which leaves no room beside it",
                plain(*tall),
                plain(*thick)
            ),
            Ribbing::StillSpans(span) => {
                format!(
                    "ribs across its longest spans leave one of {} mm, measured again: no rib is advised",
                    plain(*span)
                )
            }
            Ribbing::StillReaches(reach) => {
                format!(
                    "ribs across its longest spans leave what reaches {} mm out beside them, measured again: no rib is advised",
                    plain(*reach)
                )
            }
        }
    }
}

impl Held {
    fn words(&self, part: &Part) -> String {
        let point = |p: Vec3| reported(part, p).map(hundredths).join(", ");
        let ends = self.ribs.first().map(|r| r.told(part).map(point));
        let [from, to] = ends.unwrap_or_default();
        let (ribs, first) = match self.ribs.len() {
            1 => ("a rib".to_string(), String::new()),
            n => (format!("{n} ribs"), "the first ".into()),
        };
        let more = match self.ribs.len() {
            1 => String::new(),
            _ => {
                let others = self.ribs.iter().skip(1).map(|r| r.told(part).map(point));
                let others: Vec<String> = others.map(|[from, to]| format!("from {from} to {to}")).collect();
                format!(", the {} {}", if others.len() == 1 { "other" } else { "others" }, others.join(" and "))
            }
        };
        let stands = if self.on_part { "on the part" } else { "on the plate" };
        let left = match self.span > 0.0 {
            // Not told as less than it is.
            true => format!("no span is then longer than {} mm", short((1e3 * self.span - 1e-4).ceil() / 1e3)),
            false => "nothing then spans freely".to_string(),
        };
        let closes = if self.closes {
            "; it reaches from side to side: leave a way through it where something has to pass"
        } else {
            ""
        };
        let tall = match self.tall.map(plain) {
            [low, high] if low == high => high,
            [low, high] => format!("{low} to {high}"),
        };
        format!(
            "put {ribs} of {} mm under it, {first}from {from} to {to}{more}, {tall} mm tall, {stands}: measured again, {left}{closes}",
            plain(self.thick),
        )
    }
}

/// Ribs of one thickness under a ceiling.
struct Trying<'a> {
    part: &'a Part,
    process: &'a Process,
    ceiling: &'a Ceiling,
    limit: f64,
    thick: f64,
}

impl Trying<'_> {
    fn run(&self) -> Ribbing {
        let mut ribs: Vec<Rib> = Vec::new();
        // What hangs out from a rib has to hold as well as what did before, as closely as that is measured.
        let ledge = limits_of(self.process, LEDGE).and_then(|l| l.warn.or(l.fail)).unwrap_or(0.0);
        let reaches = 1.01 * self.reach(std::slice::from_ref(self.ceiling)).max(ledge) + self.part.tie();
        let Some(mut longest) = self.ceiling.bridge else { return Ribbing::StillSpans(0.0) };
        for _ in 0..ROUNDS {
            match self.across(&longest) {
                Some(more) if more.is_empty() => return Ribbing::NoPlace,
                Some(more) if ribs.len() + more.len() <= MOST => ribs.extend(more),
                _ => return Ribbing::TooMany,
            }
            let plan: Vec<[Vec3; 3]> = ribs.iter().flat_map(|r| self.in_plan(r)).collect();
            let left = respanned(self.part, self.process, self.ceiling, &plan);
            let span = left.iter().filter_map(|c| c.bridge).max_by(|a, b| a.high_mm.total_cmp(&b.high_mm));
            if self.reach(&left) > reaches {
                return Ribbing::StillReaches(self.reach(&left));
            }
            match span.filter(|s| s.high_mm > self.limit + 1e-6) {
                Some(long) if long.low_mm > self.limit => longest = long,
                Some(long) => return Ribbing::StillSpans(long.high_mm),
                None => return self.standing(ribs, span.map_or(0.0, |s| s.high_mm)),
            }
        }
        Ribbing::StillSpans(longest.high_mm)
    }

    /// How far ceilings reach out from an anchor, or may.
    fn reach(&self, ceilings: &[Ceiling]) -> f64 {
        ceilings.iter().filter_map(|c| c.cantilever).map(|c| c.high_mm).fold(0.0, f64::max)
    }

    /// Ribs across a span that leave even stretches no longer than the limit, each from border to border of the ceiling; `None` for too
    /// many, and none where the stretches would be gaps that close. Where a rib would run along a groove it stands beside it.
    fn across(&self, span: &Reach) -> Option<Vec<Rib>> {
        let [from, to] = span.ends.map(|p| [p[0], p[1], 0.0]);
        let (long, way) = (distance(from, to), unit(sub(to, from)));
        let count = ((long - self.limit) / (self.limit + self.thick) - 1e-9).ceil().max(1.0);
        let free = (long - count * self.thick) / (count + 1.0);
        let gap = limits_of(self.process, "narrow-gap").and_then(|l| l.warn.or(l.fail)).unwrap_or(0.0);
        if count > MOST as f64 {
            return None;
        }
        if free <= 0.0 || free < gap - self.part.tie() {
            return Some(Vec::new());
        }
        let middle = |n: usize| along(from, way, (n as f64 + 1.0) * (free + self.thick) - 0.5 * self.thick);
        let beside = |n: usize, shift: f64| {
            let p = along(middle(n), way, shift * self.thick);
            stretch(self.part.mesh(), &self.ceiling.facets, [p[0], p[1]], [-way[1], way[0]])
                .and_then(|ends| self.footed(Rib { ends }))
        };
        let rib = |n: usize| [0.0, 0.3, -0.3, 0.6, -0.6].into_iter().find_map(|shift| beside(n, shift));
        Some((0..count as usize).filter_map(rib).collect())
    }

    /// A rib whose ends are free over all of its thickness, or else in what they meet: so much longer where that slants. `None` where one would touch
    /// something, as the corner of a post, with a part of its thickness alone.
    fn footed(&self, rib: Rib) -> Option<Rib> {
        let way = rib.way();
        // From before where a side that slants is met first.
        let before = self.thick.min(0.5 * distance(rib.ends[0], rib.ends[1]));
        let end = |p: Vec3, out: Vec3| {
            let from = along(along(p, out, -before), [0.0, 0.0, -1.0], UNDER * self.process.layer_height_mm);
            let hits = [-0.49, 0.0, 0.49].map(|side| {
                let at = along(from, [-way[1], way[0], 0.0], side * self.thick);
                self.part.distance().first_hit(at, out, 0.0, before + self.thick).map(|hit| hit.0)
            });
            match hits {
                [None, None, None] => Some(p),
                [Some(a), Some(b), Some(c)] => Some(along(p, out, (a.max(b).max(c) - before).max(0.0))),
                _ => None,
            }
        };
        Some(Rib { ends: [end(rib.ends[0], way.map(|x| -x))?, end(rib.ends[1], way)?] })
    }

    /// The outline of a rib from above, as two triangles: of the one that is put where the words say, which is what is measured again.
    fn in_plan(&self, rib: &Rib) -> [[Vec3; 3]; 2] {
        let read = Rib { ends: rib.read(self.part) };
        let ([a, b], way) = (read.longer(BEYOND), read.way());
        let aside = [-0.5 * self.thick * way[1], 0.5 * self.thick * way[0], 0.0];
        let [p, q, r, s] = [along(a, aside, -1.0), along(b, aside, -1.0), along(b, aside, 1.0), along(a, aside, 1.0)];
        [[p, q, r], [p, r, s]]
    }

    /// What ribs stand on, looked for below five places along the middle and both sides of each; and whether that is the ceiling's
    /// body, and no other is near.
    fn standing(&self, ribs: Vec<Rib>, span: f64) -> Ribbing {
        let mut held = Held { ribs, thick: self.thick, tall: [f64::INFINITY, 0.0], on_part: true, closes: false, span };
        for rib in &held.ribs {
            let ([a, b], way) = (rib.ends, rib.way());
            for (n, side) in (0..5).flat_map(|n| [-0.49, 0.0, 0.49].map(|side| (n, side))) {
                let at = along(a, sub(b, a), 0.05 + 0.225 * f64::from(n));
                let at = [at[0] - side * self.thick * way[1], at[1] + side * self.thick * way[0]];
                // Beside the ceiling there is nothing to hold.
                let Some(top) = above(self.part.mesh(), &self.ceiling.facets, at) else { continue };
                let met = self.below(top);
                let tall = met.unwrap_or(top[2]);
                if self.joins(top, tall) {
                    return Ribbing::Joins;
                }
                held.on_part &= met.is_some();
                held.tall = [held.tall[0].min(tall), held.tall[1].max(tall)];
            }
            held.closes |= self.closes(rib);
        }
        Ribbing::Holds(held)
    }

    /// Whether material as tall, below a place of the ceiling, comes nearer to another body than the process keeps apart.
    fn joins(&self, top: Vec3, tall: f64) -> bool {
        let bodies = &self.part.health().facet_body;
        let own = self.ceiling.facets.first().and_then(|&f| bodies.get(f as usize));
        let apart = limits_of(self.process, "narrow-gap").and_then(|l| l.fail.or(l.warn)).unwrap_or(0.0);
        let is_other = |f: u32, _| bodies.get(f as usize) != own;
        let within = apart.max(2.0 * self.part.tie());
        self.part.health().bodies.len() > 1
            && (0..=4).any(|n| {
                let p = along(top, [0.0, 0.0, -0.25 * f64::from(n)], tall);
                self.part.distance().nearest_where(p, within, is_other).is_some()
            })
    }

    /// How far below a place of the ceiling the part is met; `None` where the plate is met first.
    fn below(&self, top: Vec3) -> Option<f64> {
        let hit = self.part.distance().first_hit(top, [0.0, 0.0, -1.0], 4.0 * self.part.step() + 1e-6, top[2]);
        hit.map(|h| h.0)
    }

    /// Whether a rib meets walls at both ends, halfway down.
    fn closes(&self, rib: &Rib) -> bool {
        let middle = middle(rib.ends);
        let tall = self.below(middle).unwrap_or(middle[2]);
        let from = along(middle, [0.0, 0.0, -1.0], 0.5 * tall);
        let ([a, b], way) = (rib.ends, rib.way());
        let reach = 0.5 * distance(a, b) + self.thick;
        [way, way.map(|x| -x)].iter().all(|&w| self.part.distance().first_hit(from, w, 0.0, reach).is_some())
    }
}

fn middle([a, b]: [Vec3; 2]) -> Vec3 {
    along(a, sub(b, a), 0.5)
}

/// A coordinate as it is told.
fn in_hundredths(mm: f64) -> f64 {
    (100.0 * mm).round() / 100.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::upright;
    use crate::check::hanging::ceilings_of;
    use crate::geometry::{TriangleMesh, cuboid, extruded};
    use crate::part::Up;

    /// A bench 6 mm deep on legs of 3 mm and 8 mm tall, so far apart.
    fn bench(span: f64) -> TriangleMesh {
        let (a, b) = (3.0, 3.0 + span);
        let outline =
            [[0.0, 0.0], [a, 0.0], [a, 8.0], [b, 8.0], [b, 0.0], [b + 3.0, 0.0], [b + 3.0, 11.0], [0.0, 11.0]];
        extruded(&outline, &[[0, 1, 2], [0, 2, 7], [7, 2, 3], [7, 3, 6], [3, 4, 5], [3, 5, 6]], 6.0)
    }

    fn tried(mesh: TriangleMesh) -> (Ribbing, Part) {
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
        let process = Process::named("fdm").unwrap();
        let ceilings = ceilings_of(&part, &process, 0);
        let longest = ceilings.iter().max_by(|a, b| a.area_mm2.total_cmp(&b.area_mm2)).unwrap();
        (Ribbing::of(&part, &process, longest, 10.0), part)
    }

    #[test]
    fn a_rib_is_told_as_it_is_where_rounding_takes_nothing_and_longer_where_it_would() {
        let (_, part) = tried(bench(18.0));
        let rib = |y: f64, z: f64| Rib { ends: [[1.234_56, 0.0, z], [1.234_56, y, z]] };
        assert_eq!(rib(4.0, 8.0).told(&part), rib(4.0, 8.0).ends);
        for (y, z) in [(4.004, 8.0), (4.0, 8.004)] {
            let [a, b] = rib(y, z).told(&part);
            assert!(a[1] < 0.0 && in_hundredths(b[1]) > y && in_hundredths(b[2]) > z, "{a:?} {b:?}");
        }
    }

    #[test]
    fn ribs_are_as_few_as_do_and_the_spans_between_them_are_measured() {
        for (span, ribs) in [(18.0, 1), (21.2, 1), (21.3, 2), (40.0, 3)] {
            let (found, part) = tried(bench(span));
            let Ribbing::Holds(held) = &found else { panic!("{span}: {found:?}") };
            let free = (span - 1.2 * f64::from(ribs)) / (f64::from(ribs) + 1.0);
            assert_eq!((held.ribs.len(), held.on_part, held.closes), (ribs as usize, false, false), "{held:?}");
            assert!(
                (held.span - free).abs() < 1e-6
                    && held.tall.iter().all(|t| (t - 8.0).abs() < 1e-9)
                    && held.thick == 1.2,
                "{held:?}"
            );
            assert!(found.words(&part, 10.0).contains("on the plate"), "{}", found.words(&part, 10.0));
        }
        assert!(matches!(tried(bench(120.0)).0, Ribbing::TooMany));
    }

    #[test]
    fn spans_beside_a_rib_are_those_beside_the_one_that_is_read() {
        for aside in [0.0, 0.002, 0.013, 0.0249] {
            let (found, part) = tried(bench(18.0).transformed(upright([0.0, 0.0, 1.0]), [aside, 0.0, 0.0]));
            let Ribbing::Holds(held) = &found else { panic!("{aside}: {found:?}") };
            let words = found.words(&part, 10.0);
            let after = |mark: &str| {
                let rest = words.split_once(mark).unwrap().1;
                let number: String = rest.chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
                number.parse::<f64>().unwrap()
            };
            // In the frame of the file the left leg ends at 3 mm and so much beside.
            let (left, middle) = (3.0 + aside, after(", from "));
            let truth = (middle - 0.6 - left).max(left + 18.0 - middle - 0.6);
            assert!(
                (held.span - truth).abs() < 1e-6 && after("longer than ") >= truth - 1e-9,
                "{aside} {truth}: {words}"
            );
        }
    }

    #[test]
    fn no_rib_is_advised_that_would_join_a_body_under_the_ceiling() {
        // Rails that slide between the legs: a rib would stand on them.
        for top in [7.4, 4.0] {
            let rail = cuboid([4.0, 0.0, 0.0], [20.0, 6.0, top]);
            assert_eq!(tried(bench(18.0).joined(&rail)).0, Ribbing::Joins, "{top}");
        }
        let beside = cuboid([4.0, 7.0, 0.0], [20.0, 9.0, 7.0]);
        assert!(tried(bench(18.0).joined(&beside)).0.holds());
    }

    #[test]
    fn no_rib_is_put_that_a_part_of_its_thickness_alone_would_hold() {
        // In the middle of the open side a post half as thick as the rib.
        let post = cuboid([11.7, 5.95, 0.0], [12.3, 7.0, 9.0]);
        let mesh = crate::geometry::union::united(&bench(18.0).joined(&post), 1e-6).unwrap();
        assert_eq!(tried(mesh).0, Ribbing::NoPlace);
        // One that is thicker than it holds all of it.
        let post = cuboid([11.0, 5.95, 0.0], [13.0, 7.0, 9.0]);
        let mesh = crate::geometry::union::united(&bench(18.0).joined(&post), 1e-6).unwrap();
        assert!(tried(mesh).0.holds());
    }

    #[test]
    fn a_rib_over_a_step_is_as_tall_as_what_is_below_it() {
        let step = cuboid([2.5, 3.0, -1.0], [22.0, 6.0, 2.0]);
        let mesh = crate::geometry::union::united(&bench(18.0).joined(&step), 1e-6).unwrap();
        let (found, part) = tried(mesh);
        let Ribbing::Holds(held) = &found else { panic!("{found:?}") };
        assert!((held.tall[0] - 6.0).abs() < 1e-6 && (held.tall[1] - 9.0).abs() < 1e-6, "{held:?}");
        assert!(found.words(&part, 10.0).contains("6 to 9 mm tall"), "{}", found.words(&part, 10.0));
    }

    #[test]
    fn a_rib_stands_beside_a_score_lower_than_a_layer() {
        let (a, m, b) = (3.0, 11.0, 19.0);
        let legs = [[0.0, 0.0], [a, 0.0], [a, 8.0], [m - 0.05, 8.0], [m, 7.91], [m + 0.05, 8.0], [b, 8.0], [b, 0.0]];
        let outline = [&legs[..], &[[b + 3.0, 0.0], [b + 3.0, 11.0], [0.0, 11.0]]].concat();
        let under = (2..6).map(|n| [10, n, n + 1]);
        let caps: Vec<[usize; 3]> = under.chain([[0, 1, 2], [0, 2, 10], [10, 6, 9], [6, 7, 8], [6, 8, 9]]).collect();
        let (found, _) = tried(extruded(&outline, &caps, 6.0));
        let Ribbing::Holds(held) = &found else { panic!("{found:?}") };
        assert!(held.ribs.len() == 1 && held.span < 8.0, "{held:?}");
    }

    #[test]
    fn no_rib_hangs_on_the_corners_of_posts() {
        // A table on four posts of 3 mm: from post to post it is 2.2 mm, and from corner to corner 3.1.
        let table = |turn: f64| {
            let mut mesh = cuboid([0.0, 0.0, 10.0], [8.2, 8.2, 12.0]);
            for (x, y) in [(0.0, 0.0), (5.2, 0.0), (0.0, 5.2), (5.2, 5.2)] {
                mesh = mesh.joined(&cuboid([x, y, 0.0], [x + 3.0, y + 3.0, 11.0]));
            }
            let (s, c) = turn.sin_cos();
            let mesh = crate::geometry::union::united(&mesh, 1e-6).unwrap();
            mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.0; 3])
        };
        for turn in [0.0, 0.3] {
            let part = Part::new(table(turn), Up::PlusZ, 1e-6, 1.0).unwrap();
            let process = Process::named("sla").unwrap();
            for ceiling in ceilings_of(&part, &process, 0).iter().filter(|c| c.bridge.is_some()) {
                let found = Ribbing::of(&part, &process, ceiling, 1.0);
                let Ribbing::Holds(held) = &found else { continue };
                for rib in &held.ribs {
                    let across = [-rib.way()[1], rib.way()[0], 0.0];
                    let (s, c) = turn.sin_cos();
                    let of_post = |x: f64| (0.0..=3.0).contains(&x) || (5.2..=8.2).contains(&x);
                    let is_in = |p: Vec3| {
                        let p = part.to_file(p);
                        of_post(c * p[0] + s * p[1]) && of_post(c * p[1] - s * p[0])
                    };
                    for end in rib.longer(0.1) {
                        let inside = [-0.45, 0.0, 0.45].map(|side| is_in(along(end, across, side * held.thick)));
                        assert!(inside == [true; 3] || inside == [false; 3], "{turn}: {inside:?} {held:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_rib_in_a_room_stands_on_its_floor_and_a_tall_one_is_thicker() {
        let room = |height: f64| {
            let (outer, void) =
                (cuboid([0.0; 3], [20.0, 24.0, height + 4.0]), cuboid([2.0; 3], [18.0, 22.0, height + 2.0]));
            outer.joined(&void.flipped())
        };
        let (found, part) = tried(room(9.0));
        let Ribbing::Holds(held) = &found else { panic!("{found:?}") };
        assert!(
            held.on_part && held.closes && held.tall.iter().all(|t| (t - 9.0).abs() < 1e-9) && held.thick == 1.2,
            "{held:?}"
        );
        assert!(found.words(&part, 10.0).contains("on the part") && found.words(&part, 10.0).contains("leave a way"));
        let (found, _) = tried(room(16.0));
        let Ribbing::Holds(held) = &found else { panic!("{found:?}") };
        assert!((held.thick - 2.0).abs() < 1e-9, "{held:?}");
        // So tall that it would fill all of the room to stand.
        let (found, part) = tried(room(130.0));
        assert_eq!(found, Ribbing::TooTall { tall: 130.0, thick: 16.3 });
        assert!(found.words(&part, 10.0).contains("130 mm tall and stand only if it were 16.3 mm thick"));
    }
}
