//! Findings from sheets of material or void: what AM101 and AM103 share.

use super::budget::Budget;
use super::contract::{Context, Measured, Worst};
use super::finding::{Basis, Bracket, Finding, Limits, State, Witness};
use super::for_good::{Gone, Told};
use super::place::{group_equal, locate, reported};
use super::room::{Beside, Thin};
use super::search::{self, BOXES};
use super::sheet_shape::{Form, Scale, Sheet, sheet_of};
use super::sheet_thinnest::{Seeking, Sought, share_of_told};
use super::sheet_words::{Room, Rooms};
use crate::geometry::vector::{Vec3, along, angle, bounds, scale, sub};
use crate::medial::chord::WALL_SEPARATION;
use crate::medial::cluster::group;
use crate::medial::cover::{FacetSheet, Unresolved};
use crate::medial::rod::Rod;
use crate::medial::{Cover, Question, Sample, Shape, Side};
use crate::part::Part;
use crate::process::Process;
use crate::units::{report_digits, short};
use rayon::prelude::*;

/// Balls and rays whose lengths differ by less are as long, millimetres.
pub(super) const TOUCH: f64 = 1e-3;
/// Straight across a wall a line is no longer than this many diameters of its ball: flat sides that lean by 30° have 1.08.
const PAST: f64 = 1.5;
/// A ball touches a facet, and not an edge of it, if its middle is seen no farther off the normal than this (1°).
const ACROSS: f64 = std::f64::consts::PI / 180.0;

/// Whose surfaces bound the sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    WithinBody,
    BetweenBodies,
}

/// One kind of finding with its own limits.
#[derive(Debug, Clone)]
pub struct Kind {
    pub name: &'static str,
    pub rule: &'static str,
    pub limits: Limits,
    pub reading: Reading,
}

/// The search for thin sheets on one side of a part's surface.
pub struct Sheets<'a> {
    pub part: &'a Part,
    pub process: &'a Process,
    pub context: &'a Context,
    pub code: &'static str,
    pub side: Side,
    pub kinds: Vec<Kind>,
    /// Rods, which are judged by a rule of their own.
    pub rods: Vec<Rod>,
    /// Rods that hold two pieces together, however short: necks that are judged like a wall.
    pub necks: Vec<Rod>,
    /// What a hint to grow has to leave.
    pub beside: Beside,
    pub told: Told,
}

impl Sheets<'_> {
    /// Up to this width sheets are noticed: a quarter more than the widest limit.
    pub fn notice(&self) -> f64 {
        1.25 * self.widest()
    }

    pub(super) fn widest(&self) -> f64 {
        self.kinds.iter().flat_map(|k| [k.limits.fail, k.limits.warn]).flatten().fold(0.0, f64::max)
    }

    fn question(&self) -> Question {
        let limits: Vec<f64> = self.kinds.iter().flat_map(|k| [k.limits.fail, k.limits.warn]).flatten().collect();
        search::question(self.part, self.process, self.context, self.side, &limits)
    }

    /// Samples that are farther apart than twice this are not beside each other.
    pub(super) fn resolution(&self) -> f64 {
        0.75 * self.widest()
    }

    /// Searches, groups and judges.
    pub fn measure(&self) -> (Measured, Vec<FacetSheet>) {
        let question = self.question();
        let cover = self.part.cover(self.side, &question);
        let mut measured = Measured { rule: self.kinds.first().map(|k| k.rule), ..Measured::default() };
        let mut wedges = cover.samples.iter().filter(|s| s.shape == Shape::Wedge).count();
        let thin = cover.samples.iter().filter(|s| s.shape == Shape::Sheet && s.diameter < self.widest());
        let thin = Thin::of(thin, self.resolution());
        for kind in &self.kinds {
            match kind.reading {
                Reading::WithinBody => self.within((kind, &thin), &question, &cover, &mut measured, &mut wedges),
                Reading::BetweenBodies => self.between((kind, &thin), &cover, &mut measured),
            }
        }
        // What may be as thin as something already found is no news.
        let known = measured.findings.iter().map(|f| f.value).fold(f64::INFINITY, f64::min);
        if let Some(open) =
            self.budget_ended(&question, &cover, (known - TOUCH).min(self.widest())).filter(|f| f.state > State::Pass)
        {
            measured.findings.push(open);
        }
        measured.cover = self.cover_text(&question, &cover, wedges);
        (measured, cover.facets.clone())
    }

    pub(super) fn body(&self, facet: u32) -> u32 {
        self.part.health().facet_body.get(facet as usize).copied().unwrap_or(u32::MAX)
    }

    /// The samples of a shape whose two surfaces belong to one body, and to no rod.
    pub(super) fn own(&self, cover: &Cover, shape: Shape) -> Vec<Sample> {
        let samples = cover.samples.iter().filter(|s| s.shape == shape && self.body(s.facet) == self.body(s.opposite));
        samples.filter(|s| !self.rods.iter().any(|r| r.holds(s.centre))).copied().collect()
    }

    /// Sheets whose two surfaces belong to one body.
    fn within(
        &self,
        (kind, thin): (&Kind, &Thin),
        q: &Question,
        cover: &Cover,
        measured: &mut Measured,
        wedges: &mut usize,
    ) {
        let tie = self.part.tie();
        let fail = kind.limits.fail.unwrap_or(0.0) - tie;
        let warn = kind.limits.warn.unwrap_or(0.0).max(kind.limits.fail.unwrap_or(0.0)) - tie;
        let own = self.own(cover, Shape::Sheet);
        let longest = self.part.extent().into_iter().fold(0.0, f64::max);
        let scale = Scale { wide: longest.min(warn), tight: longest.min(if fail > 0.0 { fail } else { warn }) };
        let mut sheets: Vec<(Sheet, Vec<Sample>)> = Vec::new();
        let mut noticed: Option<Sample> = None;
        for (from, to) in [(0.0, fail), (fail.max(0.0), warn), (warn, f64::INFINITY)] {
            let level: Vec<Sample> = own.iter().filter(|s| s.diameter >= from && s.diameter < to).copied().collect();
            if to.is_infinite() {
                noticed = level.into_iter().min_by(|a, b| a.diameter.total_cmp(&b.diameter));
                continue;
            }
            for samples in self.groups(&level) {
                match sheet_of(&samples, from, scale, self) {
                    Some(sheet) => sheets.push((sheet, samples)),
                    None => *wedges += samples.len(),
                }
            }
        }
        self.add_bent_walls(cover, &mut sheets, ([fail, warn], scale));
        sheets.extend(self.waists(cover, &sheets, [fail, warn]));
        sheets.sort_by(|a, b| a.0.thinnest.diameter.total_cmp(&b.0.thinnest.diameter));
        let told = share_of_told(sheets.len());
        let seeking = Seeking { question: q, scale, levels: [fail, warn], reach: 1.5 * self.resolution(), told };
        let mut sought = self.thinnest_of(&seeking, sheets);
        self.leave_known_waists(&mut sought);
        *wedges += sought.iter().filter(|s| s.sheet.is_none()).map(|s| s.samples.len()).sum::<usize>();
        let mut budget = measured.budget.unwrap_or(Budget::of(self.context.refine));
        sought.iter().for_each(|s| budget.note(s.budget.looks, BOXES * s.budget.spent));
        measured.budget = (budget.looks > 0).then_some(budget);
        let judged = |s: Sought| {
            let sheet = s.sheet?;
            let gone = (self.told == Told::AsGone).then(|| self.gone(&sheet, &s.samples, kind.limits)).flatten();
            if gone.as_ref().is_some_and(|g| g.bracket.low >= warn) {
                return None;
            }
            let thinnest = (sheet.thinnest.contacts, sheet.thinnest.diameter);
            let room = self.room((kind, thin), thinnest, s.samples.iter());
            Some((self.finding(kind, &sheet, gone.as_ref()), room))
        };
        let judged: Vec<(Finding, Room)> = sought.into_par_iter().with_max_len(1).filter_map(judged).collect();
        let with_place = |(f, room): (Finding, Room)| {
            let at_mm = f.at_mm;
            (f, (at_mm, room))
        };
        let (mut findings, rooms): (Vec<Finding>, Rooms) = judged.into_iter().map(with_place).unzip();
        findings.sort_by(|a, b| a.value.total_cmp(&b.value).then_with(|| Finding::worst_first(a, b)));
        let thinnest = findings
            .first()
            .map(|f| (Bracket { value: f.value, low: f.low, high: f.high }, self.part.to_build(f.at_mm)));
        let thinnest =
            thinnest.or_else(|| noticed.map(|s| (Bracket::new(s.diameter, s.low.max(warn), s.diameter), s.centre)));
        self.note_worst(kind, measured, thinnest);
        let tolerance = |f: &[Finding]| f.first().map_or(0.0, |f| (0.01 * f.value).max(0.004));
        let step = tolerance(&findings);
        let mut grouped = group_equal(findings, step);
        grouped.iter_mut().for_each(|f| self.describe(f, &rooms));
        measured.findings.extend(grouped);
    }

    /// The samples that lie side by side in one body.
    pub(super) fn groups(&self, samples: &[Sample]) -> Vec<Vec<Sample>> {
        let corners = |f: u32| self.part.mesh().triangles.get(f as usize).copied().unwrap_or_default();
        let groups = group(samples, 1.5 * self.resolution(), |s| u64::from(self.body(s.facet)), corners);
        groups
            .into_iter()
            .map(|members| members.into_iter().filter_map(|i| samples.get(i).copied()).collect())
            .collect()
    }

    fn note_worst(&self, kind: &Kind, measured: &mut Measured, met: Option<(Bracket, Vec3)>) {
        if let Some((bracket, at)) = met
            && measured.worst.as_ref().is_none_or(|w| bracket.value < w.bracket.value)
        {
            measured.worst = Some(Worst { bracket, unit: "mm", at: Some(at) });
            measured.rule = Some(kind.rule);
        }
    }

    fn finding(&self, kind: &Kind, sheet: &Sheet, gone: Option<&Gone>) -> Finding {
        let s = &sheet.thinnest;
        let bracket = gone.map_or(Bracket::new(s.diameter, sheet.low, s.diameter), |g| g.bracket);
        // What is thin over less than its own thickness, or just short of a wall, is a neck: no part fails for it if it carries nothing.
        let blunt = sheet.form == Form::Spot || s.separation < WALL_SEPARATION;
        let carries = || self.necks.iter().any(|r| r.holds(s.centre));
        let is_spot = blunt && sheet.area < s.diameter * s.diameter;
        let neck = is_spot && !carries() && !self.is_waist(sheet) && !self.is_whole(sheet);
        let Limits { fail, warn, sense } = kind.limits;
        let limits = if neck { Limits { fail: None, warn: warn.or(fail), sense } } else { kind.limits };
        let mut f = Finding::judged(self.code, kind.name, bracket, Basis::Certified, limits, "mm", self.part.tie());
        if bracket.high - bracket.low <= self.part.step() {
            f.basis = Basis::Exact;
        }
        f.area_mm2 = Some(report_digits(sheet.thin));
        locate(&mut f, self.part, self.context, gone.map_or(s.centre, |g| g.at), sheet.extent);
        let points = |p: &[Vec3]| p.iter().map(|p| reported(self.part, *p)).collect();
        f.witness = Some(match gone {
            Some(g) => Witness { kind: "containing-ball".into(), points_mm: points(&[g.at, g.ball]) },
            None => {
                let [a, b] = s.contacts;
                Witness { kind: "medial-ball".into(), points_mm: points(&[s.centre, a, b]) }
            }
        });
        let [long, wide, _] = sheet.spans.map(|x| short((x * 10.0).round() / 10.0));
        f.message = match sheet.form {
            Form::Plate => format!("over {long} × {wide} mm"),
            Form::Rod => format!("rod-like, {long} mm long"),
            Form::Spot => "at one spot".into(),
        };
        if let Some(ray) = self.along_normal(s) {
            f.message.push_str(&format!(" ({} mm along the normal)", short(ray)));
        }
        if self.part.health().bodies.len() > 1 {
            f.bodies = Some(vec![u64::from(self.body(s.facet)) + 1]);
        }
        f
    }

    /// Whether the body is no wider in any direction than what a wall has to be: then it is thin as a whole, and no neck of anything.
    fn is_whole(&self, Sheet { thinnest, .. }: &Sheet) -> bool {
        let body = self.part.health().bodies.get(self.body(thinnest.facet) as usize);
        body.is_some_and(|b| (0..3).all(|a| b.box_mm[1][a] - b.box_mm[0][a] <= self.widest()))
    }

    /// The ray definition of thickness: from the first contact straight across, where that differs from the ball's diameter; at an edge the
    /// surface has no normal, and a line past the edge of the other side is not across.
    fn along_normal(&self, s: &Sample) -> Option<f64> {
        let inward = scale(self.part.mesh().normal(s.facet as usize), -self.side.sign());
        if angle(inward, sub(s.centre, s.contacts[0])) > ACROSS {
            return None;
        }
        let (ray, _) = self.part.distance().first_hit(s.contacts[0], inward, 1e-3 * s.diameter, PAST * s.diameter)?;
        ((ray - s.diameter).abs() > TOUCH).then_some(ray)
    }

    /// Exact clearances between bodies, one finding for each pair.
    fn between(&self, (kind, thin): (&Kind, &Thin), cover: &Cover, measured: &mut Measured) {
        let widest = kind.limits.fail.unwrap_or(0.0).max(kind.limits.warn.unwrap_or(0.0)) - self.part.tie();
        let apart = self.part.body_pairs().iter().filter(|p| p.distance > self.part.step());
        let (mut findings, mut rooms) = (Vec::new(), Rooms::new());
        for pair in apart {
            let middle = pair.middle();
            self.note_worst(kind, measured, Some((Bracket::exact(pair.distance), middle)));
            if pair.distance >= widest {
                continue;
            }
            let mut f = Finding::judged(
                self.code,
                kind.name,
                Bracket::exact(pair.distance),
                Basis::Exact,
                kind.limits,
                "mm",
                self.part.tie(),
            );
            let near: Vec<&Sample> = cover
                .samples
                .iter()
                .filter(|s| {
                    let pair_of = [self.body(s.facet), self.body(s.opposite)];
                    s.diameter < widest && (pair_of == pair.bodies || pair_of == [pair.bodies[1], pair.bodies[0]])
                })
                .collect();
            let extent = bounds(near.iter().map(|s| s.centre).chain(pair.points)).unwrap_or((middle, middle));
            f.area_mm2 = Some(report_digits(0.5 * near.iter().map(|s| s.thin).sum::<f64>()));
            f.bodies = Some(pair.bodies.iter().map(|&b| u64::from(b) + 1).collect());
            locate(&mut f, self.part, self.context, middle, extent);
            let points = pair.points.map(|p| reported(self.part, p));
            f.witness = Some(Witness { kind: "nearest-pair".into(), points_mm: points.to_vec() });
            f.message = format!("between bodies {} and {}", pair.bodies[0] + 1, pair.bodies[1] + 1);
            rooms.push((f.at_mm, self.room((kind, thin), (pair.points, pair.distance), near.iter().copied())));
            findings.push(f);
        }
        findings.sort_by(|a, b| a.value.total_cmp(&b.value).then_with(|| Finding::worst_first(a, b)));
        let mut grouped = group_equal(findings, 0.002);
        grouped.iter_mut().for_each(|f| self.describe(f, &rooms));
        measured.findings.extend(grouped);
    }

    /// Whether a rod lies right behind a place of the surface: how thick it is there is judged by its own rule.
    pub(super) fn lies_on_a_rod(&self, u: &Unresolved) -> bool {
        let inward = scale(self.part.mesh().normal(u.facet as usize), -self.side.sign());
        self.rods.iter().any(|r| r.holds(along(u.at, inward, 0.5 * r.narrowest.inscribed)))
    }

    /// The places that the budget left open, as one undecided finding.
    fn budget_ended(&self, q: &Question, cover: &Cover, below: f64) -> Option<Finding> {
        let kind = self.kinds.iter().find(|k| k.reading == Reading::WithinBody)?;
        let open: Vec<_> = left_open(q, cover, below).filter(|u| !self.lies_on_a_rod(u)).collect();
        let worst = open.iter().min_by(|a, b| a.low.total_cmp(&b.low))?;
        let bracket = Bracket { value: worst.low, low: worst.low, high: self.notice().max(worst.low) };
        let mut f =
            Finding::judged(self.code, kind.name, bracket, Basis::Certified, kind.limits, "mm", self.part.tie());
        let extent = bounds(open.iter().map(|u| u.at)).unwrap_or((worst.at, worst.at));
        locate(&mut f, self.part, self.context, worst.at, extent);
        f.kind = format!("{}-undecided", kind.name);
        f.count = open.len() as u64;
        let bound = if worst.low > 0.0 {
            format!("none is thinner than {} mm", short(worst.low))
        } else {
            "how thin they are is not known".into()
        };
        f.message = format!("{} places were not decided before the budget ended; {bound}", open.len());
        f.fix = format!("run again with --refine {}M", Budget::more_than(self.context.refine));
        Some(f)
    }
}
/// The places that the budget left open and that may be thinner than so much.
pub(super) fn left_open<'c>(q: &Question, cover: &'c Cover, below: f64) -> impl Iterator<Item = &'c Unresolved> {
    let finest = q.finest;
    cover.unresolved.iter().filter(move |u| u.extent > finest && u.low < below)
}

#[cfg(test)]
mod tests {
    use super::super::contract::{Check, Outcome};
    use super::super::thin_wall::ThinWall;
    use super::*;
    use crate::geometry::{TriangleMesh, cuboid, extruded, revolved};
    use crate::part::Up;

    /// Two cones that are so high, upright and end to end, joined where they are so wide.
    fn hourglass(waist: f64, sides: usize, high: f64) -> TriangleMesh {
        let outline = [[0.0, 0.0], [4.0, 0.0], [0.5 * waist, high], [4.0, 2.0 * high], [0.0, 2.0 * high]];
        revolved(&outline, sides)
    }

    fn found(mesh: TriangleMesh) -> Vec<Finding> {
        let process = Process::named("fdm").unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
        let Outcome::Measured(found) = ThinWall.run(&part, &process, &context).unwrap() else { panic!() };
        found.findings
    }

    #[test]
    fn a_waist_between_cones_is_judged_like_a_wall() {
        for (waist, sides, state) in [(0.4, 6, Some(State::Fail)), (0.4, 48, Some(State::Fail)), (2.0, 24, None)] {
            let found = found(hourglass(waist, sides, 4.0));
            assert_eq!(found.first().map(|f| f.state), state, "{waist} {sides}: {found:?}");
            // Across the sides of a regular polygon, an even number of them.
            let width = waist * (std::f64::consts::PI / sides as f64).cos();
            for f in &found {
                assert!(f.low <= width && (f.value - width).abs() < 1e-3, "{} … {} for {width}", f.low, f.value);
            }
        }
    }

    #[test]
    fn a_waist_is_seen_however_many_sides_it_has_and_however_it_stands() {
        for sides in [4, 5, 6, 7, 8, 12, 24] {
            let width = 0.6 * (std::f64::consts::PI / sides as f64).cos();
            for degrees in [11.0, 29.0, 53.0] {
                let found = found(posed(&hourglass(0.6, sides, 6.0), degrees));
                let first = found.first().unwrap_or_else(|| panic!("{sides} at {degrees}: passes"));
                let is_it = first.state == State::Fail && first.low <= width && (first.value - width).abs() < 1e-3;
                assert!(is_it, "{sides} at {degrees}: {first:?} for {width}");
            }
        }
    }

    /// A blade of 3 × 0.6 × 4 mm that is turned by 120° from its foot to its head, in so many slices.
    fn twisted_blade(slices: usize) -> TriangleMesh {
        let ring = |k: usize| {
            let (s, c) = ((k as f64 / slices as f64) * 120f64.to_radians()).sin_cos();
            let z = 4.0 * k as f64 / slices as f64;
            [[-1.5, -0.3], [1.5, -0.3], [1.5, 0.3], [-1.5, 0.3]]
                .map(|[x, y]: [f64; 2]| [c * x - s * y, s * x + c * y, z])
        };
        let mut facets = Vec::new();
        for k in 0..slices {
            let (below, above) = (ring(k), ring(k + 1));
            for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
                facets.extend([[below[i], below[j], above[j]], [below[i], above[j], above[i]]]);
            }
        }
        let (foot, head) = (ring(0), ring(slices));
        facets.extend([[foot[0], foot[2], foot[1]], [foot[0], foot[3], foot[2]]]);
        facets.extend([[head[0], head[1], head[2]], [head[0], head[2], head[3]]]);
        TriangleMesh::weld(facets)
    }

    #[test]
    fn a_twisted_blade_is_a_wall_however_finely_it_is_drawn() {
        for slices in [20, 60, 200] {
            let blade = twisted_blade(slices);
            let found = found(posed(&blade, 17.0));
            let first = found.first().unwrap_or_else(|| panic!("{slices}: passes"));
            assert_eq!(first.state, State::Fail, "{slices}: {first:?}");
            assert!(first.low < 0.6 && first.value < 0.6, "{slices}: {first:?}");
        }
    }

    /// So many fins of 0.7 × 20 mm, 10 mm high and 3 mm apart, on a base.
    fn fins(count: usize) -> TriangleMesh {
        let mut outline = vec![[0.0, 0.0], [3.0 * count as f64 - 2.3, 0.0]];
        for left in (0..count).rev().map(|n| 3.0 * n as f64) {
            outline.extend([[left + 0.7, 3.0], [left + 0.7, 13.0], [left, 13.0], [left, 3.0]]);
        }
        let fins: Vec<usize> = (0..count).map(|n| 2 + 4 * n).collect();
        let feet: Vec<usize> = std::iter::once(1).chain(fins.iter().flat_map(|f| [*f, f + 3])).collect();
        let mut caps: Vec<[usize; 3]> = feet.windows(2).map(|pair| [0, pair[0], pair[1]]).collect();
        caps.extend(fins.iter().flat_map(|f| [[*f, f + 1, f + 2], [*f, f + 2, f + 3]]));
        extruded(&outline, &caps, 20.0)
    }

    #[test]
    fn the_area_of_a_wall_depends_neither_on_how_many_there_are_nor_on_how_finely_it_is_drawn() {
        for count in [2, 10, 40] {
            let found = found(posed(&fins(count), 17.0));
            let area: f64 = found.iter().filter_map(|f| f.area_mm2).sum();
            assert!((area / (200.0 * count as f64) - 1.0).abs() < 0.05, "{count}: {area}");
        }
        // A groove 0.5 mm deep leaves a ring of 0.9 mm, a line of which runs 122.8 mm round.
        for sides in [64, 256] {
            let outline =
                [[0.0, 0.0], [20.0, 0.0], [20.0, 6.0], [19.1, 6.0], [19.1, 5.5], [17.1, 5.5], [17.1, 6.0], [0.0, 6.0]];
            let found = found(revolved(&outline, sides));
            let area: f64 = found.iter().filter_map(|f| f.area_mm2).sum();
            assert!((0.5..=1.5).contains(&(area / (122.8 * 0.5))), "{sides}: {area}");
        }
    }

    /// Two cubes of 10 mm that overlap at a corner by so much along x, y and z, in one.
    fn corner_to_corner(overlap: [f64; 3]) -> TriangleMesh {
        let notch = overlap.map(|by| 10.0 - by);
        let mut one = Vec::new();
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let at = |height: f64, [a, b]: [f64; 2]| {
                let mut p = [0.0; 3];
                (p[axis], p[u], p[v]) = (height, a, b);
                p
            };
            let (low, high) = ([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]], 10.0);
            one.extend([[0, 2, 1], [0, 3, 2]].map(|t| t.map(|i: usize| at(0.0, low[i]))));
            let bent = [[0.0, 0.0], [10.0, 0.0], [10.0, notch[v]], [notch[u], notch[v]], [notch[u], 10.0], [0.0, 10.0]];
            one.extend((1..5).map(|i| [0, i, i + 1].map(|i: usize| at(high, bent[i]))));
        }
        let other: Vec<[Vec3; 3]> =
            one.iter().map(|t| [t[0], t[2], t[1]].map(|p: Vec3| [0, 1, 2].map(|a| 10.0 + notch[a] - p[a]))).collect();
        TriangleMesh::weld(one.into_iter().chain(other))
    }

    #[test]
    fn corners_that_overlap_join_their_blocks_by_a_waist() {
        // Six edges go round it, each apart from the opposite one by the diagonal of two overlaps.
        for (overlap, apart) in [([0.4, 0.4, 0.4], [0.4, 0.4]), ([0.2, 0.3, 0.25], [0.2, 0.25])] {
            let width = f64::hypot(apart[0], apart[1]);
            for degrees in [0.0, 11.0, 29.0, 53.0] {
                let found = found(posed(&corner_to_corner(overlap), degrees));
                let is_it = |f: &Finding| f.state == State::Fail && (f.value - width).abs() < 1e-3;
                assert!(found.first().is_some_and(is_it), "{overlap:?} at {degrees}: {found:?} for {width}");
            }
        }
    }

    #[test]
    fn the_thin_rim_of_a_cone_hides_no_waist_beside_it() {
        let found = found(hourglass(0.6, 48, 1.5));
        let width = 0.6 * (std::f64::consts::PI / 48.0).cos();
        let is_it = |f: &Finding| f.state == State::Fail && (f.value - width).abs() < 1e-3;
        assert!(found.first().is_some_and(is_it), "{found:?}");
    }

    /// A mesh in a pose of its own for each angle.
    fn posed(mesh: &TriangleMesh, degrees: f64) -> TriangleMesh {
        let (s, c) = degrees.to_radians().sin_cos();
        mesh.transformed([[c, -s * c, s * s], [s, c * c, -s * c], [0.0, s, c]], [0.3, -0.7, 0.11])
    }

    const POSES: [f64; 7] = [0.0, 11.0, 17.0, 29.0, 41.0, 53.0, 73.0];

    #[test]
    fn a_grain_that_is_a_body_of_its_own_fails_as_a_wall_does() {
        // What of its sides opposes is as large as its thickness squared, but for rounding.
        for (wide, state) in [(0.5, Some(State::Fail)), (1.0, Some(State::Warn)), (1.4, None)] {
            let cubes = cuboid([0.0; 3], [8.0; 3]).joined(&cuboid([12.0, 0.0, 0.0], [12.0 + wide, wide, wide]));
            for degrees in POSES {
                let found = found(posed(&cubes, degrees));
                assert_eq!(found.first().map(|f| f.state), state, "{wide} at {degrees}: {found:?}");
            }
        }
    }

    #[test]
    fn a_field_of_pins_leaves_nothing_open() {
        // Pins of 0.82 mm, which fdm judges by a rule of their own, five by five.
        let pin = revolved(&[[0.0, 1.0], [0.41, 1.0], [0.41, 6.0], [0.0, 6.0]], 24);
        let at = |n: usize| [2.0 + 4.0 * (n % 5) as f64, 2.0 + 4.0 * (n / 5) as f64, 0.0];
        let put = |n| pin.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], at(n));
        let field = (1..25).fold(put(0), |all, n| all.joined(&put(n)));
        let process = Process::named("fdm").unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        let part = Part::new(posed(&field, 28.0), Up::PlusZ, 1e-6, 1.0).unwrap();
        let Outcome::Measured(found) = ThinWall.run(&part, &process, &context).unwrap() else { panic!() };
        assert!(found.findings.iter().all(|f| f.state != State::Undecided), "{:?}", found.findings);
        assert!(found.cover.ends_with("25 rods are judged by their diameter."), "{}", found.cover);
    }

    #[test]
    fn at_an_edge_a_wall_has_no_thickness_along_a_normal() {
        // Under a lid of 0.5 mm; a line up from the edge of the room may pass the lid's underside, and meets the floor.
        let room = cuboid([1.0; 3], [19.0, 19.0, 19.5]);
        let hollow = cuboid([0.0; 3], [20.0; 3]).joined(&room.flipped());
        for degrees in POSES {
            let found = found(posed(&hollow, degrees));
            let first = found.first().unwrap_or_else(|| panic!("{degrees}: passes"));
            assert!((first.value - 0.5).abs() < 1e-6 && !first.message.contains("normal"), "{degrees}: {first:?}");
        }
    }

    #[test]
    fn a_thin_web_fails_whatever_the_wider_limit() {
        // A frame of 6 mm about a window of 1.15 mm, and a web of 0.055 mm in the window's middle.
        let (half, thick) = (0.575, 0.0275);
        let frame = [
            ([-6.0, -6.0, -3.0], [-half, 6.0, 3.0]),
            ([half, -6.0, -3.0], [6.0, 6.0, 3.0]),
            ([-1.0, -6.0, -3.0], [1.0, -half, 3.0]),
            ([-1.0, half, -3.0], [1.0, 6.0, 3.0]),
            ([-1.0, -1.0, -thick], [1.0, 1.0, thick]),
        ];
        let mesh = frame.map(|(lo, hi)| cuboid(lo, hi)).into_iter().reduce(|a, b| a.joined(&b)).unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        for limits in ["0.8mm,1.2mm", "0.8mm,2mm", "1mm"] {
            let mut process = Process::named("fdm").unwrap();
            process.override_limit(&format!("thin-wall={limits}")).unwrap();
            let part = Part::new(mesh.clone(), Up::PlusZ, 1e-6, 2.5).unwrap();
            let Outcome::Measured(found) = ThinWall.run(&part, &process, &context).unwrap() else { panic!() };
            let first = found.findings.first().unwrap_or_else(|| panic!("{limits}: passes"));
            assert!(first.state == State::Fail && (first.value - 0.055).abs() < 1e-6, "{limits}: {first:?}");
        }
    }

    #[test]
    fn a_wall_is_told_beside_its_thinner_places_and_those_once() {
        // 0.8 mm thick and 14 mm long between two blocks, with a notch near either end that leaves 0.43 and 0.47 mm.
        let top =
            [[3.0, 0.8], [4.5, 0.8], [5.0, 0.43], [5.5, 0.8], [14.5, 0.8], [15.0, 0.47], [15.5, 0.8], [17.0, 0.8]];
        let ends = [[17.0, 4.0], [20.0, 4.0], [20.0, 0.0], [0.0, 0.0], [0.0, 4.0], [3.0, 4.0]];
        let outline: Vec<[f64; 2]> = top.into_iter().chain(ends).collect();
        // A strip under the notches about the two lower corners, and a block at either end.
        let mut caps: Vec<[usize; 3]> = (0..4).map(|i| [11, i, i + 1]).collect();
        caps.extend([
            [11, 4, 10],
            [10, 4, 5],
            [10, 5, 6],
            [10, 6, 7],
            [10, 7, 8],
            [10, 8, 9],
            [11, 12, 13],
            [11, 13, 0],
        ]);
        let mesh = extruded(&outline, &caps, 6.0);
        let volume = 6.0 * (20.0 * 0.8 + 2.0 * 3.0 * 3.2 - 0.5 * (0.37 + 0.33));
        assert!((mesh.signed_volume() - volume).abs() < 1e-9, "{} not {volume}", mesh.signed_volume());
        let mut process = Process::named("fdm").unwrap();
        process.override_limit("thin-wall=0.5mm,1mm").unwrap();
        let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        let Outcome::Measured(found) = ThinWall.run(&part, &process, &context).unwrap() else { panic!() };
        let told: Vec<(State, f64, u64)> = found.findings.iter().map(|f| (f.state, f.value, f.count)).collect();
        let fails: Vec<f64> = told.iter().filter(|t| t.0 == State::Fail).map(|t| t.1).collect();
        assert!(matches!(fails[..], [a, b] if (a - 0.43).abs() < 1e-3 && (b - 0.47).abs() < 1e-3), "{told:?}");
        let broad: f64 = found.findings.iter().filter(|f| f.state == State::Warn).filter_map(|f| f.area_mm2).sum();
        assert!(told.iter().all(|t| t.0 == State::Fail || t.1 >= 0.5) && broad > 60.0, "{told:?}, {broad} mm²");
    }

    #[test]
    fn a_plate_is_as_thick_as_it_is_and_not_as_its_chamfered_rim() {
        // 0.5 mm thick; what a chamfer of 36° leaves of its rim is 0.05 to 0.3 mm high.
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        for rim in [0.05, 0.1, 0.2, 0.3] {
            let inset = 6.0 - (0.5 - rim) / 36f64.to_radians().tan();
            let outline = [[0.0, 0.0], [inset, 0.0], [6.0, 0.5 - rim], [6.0, 0.5], [0.0, 0.5]];
            let mesh = extruded(&outline, &[[0, 1, 4], [1, 2, 4], [2, 3, 4]], 6.0);
            for degrees in [0.0f64, 17.0, 41.0] {
                let (s, c) = degrees.to_radians().sin_cos();
                let turned = mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);
                let mut process = Process::named("fdm").unwrap();
                process.override_limit("thin-wall=0.7mm,1mm").unwrap();
                let part = Part::new(turned, Up::PlusZ, 1e-6, 1.0).unwrap();
                let Outcome::Measured(found) = ThinWall.run(&part, &process, &context).unwrap() else { panic!() };
                let told: Vec<f64> = found.findings.iter().map(|f| f.value).collect();
                assert!(matches!(told[..], [one] if (one - 0.5).abs() < 1e-3), "{rim}, {degrees}: {told:?}");
            }
        }
    }

    #[test]
    fn a_fin_that_tapers_to_a_flat_rim_is_a_wall_though_its_rim_runs_out_at_one_end() {
        // 8 mm long, 1.2 mm thick at its foot; its rim widens from nothing to 0.3 mm.
        let foot = [[0.0, -0.6, 0.0], [8.0, -0.6, 0.0], [8.0, 0.6, 0.0], [0.0, 0.6, 0.0]];
        let [edge, near, far] = [[0.0, 0.0, 4.0], [8.0, -0.15, 4.0], [8.0, 0.15, 4.0]];
        let [a, b, c, d] = foot;
        let facets = [
            [a, d, c],
            [a, c, b],
            [a, b, near],
            [a, near, edge],
            [b, c, far],
            [b, far, near],
            [c, d, edge],
            [c, edge, far],
            [d, a, edge],
            [edge, near, far],
        ];
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        for limit in [0.4, 0.5, 0.8, 1.0] {
            let mut process = Process::named("fdm").unwrap();
            process.override_limit(&format!("thin-wall={limit}mm")).unwrap();
            let part = Part::new(TriangleMesh::weld(facets), Up::PlusZ, 1e-6, 1.25 * limit).unwrap();
            let Outcome::Measured(found) = ThinWall.run(&part, &process, &context).unwrap() else { panic!() };
            let first = found.findings.first().unwrap_or_else(|| panic!("{limit}: passes"));
            assert!(first.state == State::Fail && first.value < limit, "{limit}: {first:?}");
        }
    }

    /// A block of 12 × 12 × 6 mm with a blind pit from below, its four sides at 40° to the vertical, that ends `skin` under the top.
    fn pitted(skin: f64) -> TriangleMesh {
        let (deep, half) = (6.0 - skin, (6.0 - skin) * 40f64.to_radians().tan());
        let ring = |h: f64, z: f64| [[-h, -h, z], [h, -h, z], [h, h, z], [-h, h, z]];
        let (low, top, mouth, tip) = (ring(6.0, 0.0), ring(6.0, 6.0), ring(half, 0.0), [0.0, 0.0, deep]);
        let mut facets = vec![[top[0], top[1], top[2]], [top[0], top[2], top[3]]];
        for k in 0..4 {
            let n = (k + 1) % 4;
            facets.extend([[low[k], low[n], top[n]], [low[k], top[n], top[k]]]);
            facets.extend([[low[k], mouth[k], mouth[n]], [low[k], mouth[n], low[n]], [mouth[k], tip, mouth[n]]]);
        }
        TriangleMesh::weld(facets)
    }

    #[test]
    fn a_skin_over_a_pit_is_a_wall_however_thin_and_whatever_the_limits() {
        let context = Context { refine: 64_000_000, spacing_mm: 0.1 };
        for skin in [0.002, 0.01, 0.03, 0.1, 0.4] {
            for limits in ["0.5mm", "1mm", "0.7mm,1mm", "1mm,2mm", "3mm"] {
                let mut process = Process::named("fdm").unwrap();
                process.override_limit(&format!("thin-wall={limits}")).unwrap();
                let part = Part::new(pitted(skin), Up::PlusZ, 1e-6, 4.0).unwrap();
                assert!(part.health().is_solid());
                let Outcome::Measured(found) = ThinWall.run(&part, &process, &context).unwrap() else { panic!() };
                let first = found.findings.first().unwrap_or_else(|| panic!("{skin} within {limits}: passes"));
                let is_there = first.state >= State::Warn && first.low <= skin && skin <= first.high + 1e-9;
                assert!(is_there && (first.value - skin).abs() < 0.02 * skin + 1e-6, "{skin}, {limits}: {first:?}");
            }
        }
    }
}
