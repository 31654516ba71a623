//! AM301: voids that keep what is in them.

use super::bore::{Leading, Wanted};
use super::budget::Budget;
use super::contract::{Check, Context, Measured, Meta, Outcome, ShapeShown, Worst, least_wall, limits_of};
use super::enclosed::ROUNDING;
use super::finding::{Basis, Bracket, Finding, Limits, Sense, Spot, State, Witness};
use super::mouth::Mouths;
use super::place::{group_equal, locate, reported, reported_box};
use super::vent::{advice, vents};
use super::void::{HALF_DIAGONAL, Trapped, Voids};
use super::way_out::{Telling, Tried};
use crate::error::Result;
use crate::geometry::vector::{add, scale};
use crate::geometry::{Solid, TriangleMesh};
use crate::grid::Grid;
use crate::part::Part;
use crate::process::Process;
use crate::units::{Length, bulk, hundredths, report_digits, short};

/// AM301 `trapped-volume`.
pub struct TrappedVolume;

static META: Meta = Meta {
    code: "AM301",
    name: "trapped-volume",
    title: "Voids that keep powder, resin or air",
    what: "Finds voids without a way out, with their volume, and voids whose widest way out is narrower than the process needs to \
           empty them, with the diameter of the largest ball that can leave.",
    why: "Powder and resin that cannot leave stay in the part: they weigh, leak, crack it in the furnace or never cure. Where only \
          air is kept, a sealed void is often meant, but it should be known.",
    how: "Closed shells of the mesh around void are sealed for certain, and their volumes are exact. Other voids are sealed for \
          certain if they are parted from the outside even when every sample that is not wholly material is taken as free. For the \
          rest a ball is let out: where the distance to the part is at least the ball's radius, connected regions are labelled; \
          from each that does not lead out the void is flooded, widest places first, until it does. The narrowest place of that \
          flood is the throat. With exact distances at the samples replaced by distances between samples its radius is within \
          1.73 samples. Mouths are where the void goes on to the outside as wide as a ball \
          of the limit; one about as wide is measured on the surface with all others closed. A vent is named only after it has been drilled into the sets and the way out was measured or the mouths were counted again, and only if it leaves \
             the part in as many pieces as it is in and the least wall of the process on all sides. \
          A room that the samples do not tell from a passage is measured on the surface itself: each place that is wider by the surface than all about it \
          is followed to the outside over points up to eight times finer, the widest first, and is no room only if a ball of the limit, or one that it is a \
          quarter wider than, gets there. \
          Where a limit lies within the bracket of a closed mesh, the middle of a ball of the limit is followed from the throat over points up to \
          eight times finer, with the distance to the surface itself, and so for what the plate closes; and one of 0.99 of the limit is stuck \
          where no cube at any way out, halved four times, may hold its middle by the distance to the surface, or where it gets nowhere from \
          the widest place, wherever it may stand between points eight times finer. \
          What stays undecided is looked at again with half the \
          spacing; both as far as the budget for finer samples goes.",
    limits: "A chamber counts if it is at least a quarter wider than its way out; what is less is a passage, judged by narrow-gap. \
             Mouths are counted of chambers with room for a ball twice as wide as the widest limit that do not let that ball out. \
             Rooms too narrow for a ball of the fail limit, down to a quarter of the warn limit or to what the grid tells, only warn, \
             because limits for ways out are written for hollow parts; what hides in them is told in one finding. The plate does not close a void here, except in the sentence on what stands on the plate. Where \
             bodies cross or touch, or a shell crosses itself, and could not be united (a note says so), only the grid tells. Volumes of chambers with a way out end at the throat and are estimates; \
             what the plate closes is counted down to the plate, by the void in each cube, with a bracket of the cubes that may belong to it.",
    source: "Widest paths: M. Pollack, The maximum capacity through a network, 1960. Escape diameters as in a merge tree: H. Carr, J. \
             Snoeyink, U. Axen, Computing contour trees in all dimensions, 2003. Limits: see the profile.",
};

/// Ways out that differ by no more than this are alike, millimetres.
const ALIKE: f64 = 0.004;

/// Mouths are counted of chambers with room for a ball so many times as wide as the limit.
const MOUTHS_ROOM: f64 = 2.0;

/// Without a limit for the way out a vent of this diameter is tried, millimetres: the least hole of the process families.
const PLAIN_VENT: f64 = 2.0;

impl Check for TrappedVolume {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let (sealed, way_out) = (limits_of(process, "trapped-volume.sealed"), limits_of(process, "trapped-volume"));
        if sealed.is_none() && way_out.is_none() {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        }
        let (mut h, mut budget) = (context.spacing_mm, Budget::of(context.refine));
        let mut measured = look(part, part.solid()?, process, context, &mut budget)?;
        // Windows at the throats have told what is open; what is shut is a matter of the whole void. At a surface that is not
        // closed inside is as doubtful at any spacing.
        while part.health().is_solid() && measured.findings.iter().any(|f| !f.decided) {
            h *= 0.5;
            let whole = Grid::covering([0.0; 3], part.extent(), Length::mm(h), 1, [0.0; 3])?;
            let (samples, edge) = (whole.samples() as u64, [2.0 * h; 3]);
            measured.budget = Some(budget);
            if !budget.allows(samples) {
                break;
            }
            let Ok(solid) = part.window(scale(edge, -1.0), add(part.extent(), edge), Length::mm(h)) else {
                budget.too_large += 1;
                break;
            };
            budget.note(1, samples);
            measured = look(part, &solid, process, &Context { spacing_mm: h, ..*context }, &mut budget)?;
        }
        measured.budget = (budget != Budget::of(context.refine) || measured.budget.is_some()).then_some(budget);
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// What is found on the grid of one solid of the part.
fn look(part: &Part, solid: &Solid, process: &Process, context: &Context, budget: &mut Budget) -> Result<Measured> {
    let (sealed, way_out) = (limits_of(process, "trapped-volume.sealed"), limits_of(process, "trapped-volume"));
    let voids = Voids::within(part, solid)?;
    let found = voids.sealed()?;
    let mut judge = Judge {
        part,
        context,
        voids: &voids,
        wall_mm: least_wall(process).unwrap_or(context.spacing_mm),
        leading: if plate_closes(process).is_some() { Leading::OffThePlate } else { Leading::Anywhere },
        mouths: limits_of(process, "trapped-volume.mouths").and_then(|l| l.warn.or(l.fail)).unwrap_or(1.0),
        measured: Measured::default(),
        shapes: Vec::new(),
        doubtful_rooms: 0,
        unfollowed: 0,
    };
    let widest = way_out.map_or(0.0, |l| l.fail.unwrap_or(0.0).max(l.warn.unwrap_or(0.0)));
    if let Some(limits) = sealed {
        judge.sealed("sealed", &found.certain, limits, widest)?;
        judge.sealed("may-be-sealed", &found.undecided, limits, widest)?;
    }
    if let Some(limits) = way_out {
        let clearance = voids.clearance()?;
        let mut met = voids.nothing();
        let mut chambers = voids.narrow(&clearance, widest, &mut met)?;
        // A hollow that a ball of the tighter limit fits into is judged by both, a smaller one only warns.
        let room = limits.fail.map_or(widest, |fail| fail.min(widest));
        let mut small = voids.small_rooms(&clearance, widest, &mut met.clone())?;
        chambers.extend(small.extract_if(.., |t| voids.has_room(t, room)));
        let told: Vec<&Trapped> = chambers.iter().chain(&small).collect();
        let hidden = voids.hidden_rooms(&clearance, (room, widest), &told, budget)?;
        judge.unfollowed = hidden.unfollowed;
        chambers.extend(hidden.rooms);
        for chamber in &mut chambers {
            voids.open_for_certain(&clearance, chamber, limits, budget)?;
            voids.shut_for_certain(&clearance, chamber, limits, budget)?;
        }
        judge.narrow(&chambers, limits, widest)?;
        judge.small_rooms(&small, widest)?;
        // Where supports tie the part to the plate, it closes what is open below until the part is cut off.
        if let Some(most) = plate_closes(process) {
            let standing = voids.above_plate(&clearance)?;
            // A way out that no part fails for is one.
            let least = limits.fail.unwrap_or(widest);
            let mut held = voids.on_plate(&standing, least)?;
            // What is told as narrow is told again only where the plate makes it narrower for certain.
            let is_told = |k: &Trapped| judge.way_out(k, limits).state > State::Pass;
            let as_narrow = |t: &Trapped, k: &Trapped| k.overlaps(t) && t.way_out_mm.high >= k.way_out_mm.low;
            held.retain(|t| !chambers.iter().any(|k| is_told(k) && as_narrow(t, k)));
            let held = voids.still_shut(&standing, held, least, budget)?;
            judge.on_plate(&held, (most, least));
        }
        if let Some(mouths) = limits_of(process, "trapped-volume.mouths") {
            let ball = limits.fail.unwrap_or(widest);
            let wanted = judge.wanted(ball);
            let mouths = Mouths { voids: &voids, context, limits: mouths, room_mm: MOUTHS_ROOM * widest, wanted };
            let is_told = |t: &&Trapped| judge.way_out(t, limits).state > State::Pass;
            let told: Vec<&Trapped> = chambers.iter().filter(is_told).collect();
            let (findings, rooms) = mouths.findings(&clearance, &told, budget)?;
            for f in findings {
                let at = rooms.iter().find(|t| reported(part, t.at) == f.at_mm).map(|t| t.at);
                judge.note(f, at, "1", "trapped-volume.mouths");
            }
        }
    }
    judge.finish(&found.nooks, way_out.map(|_| widest));
    Ok(judge.measured)
}

/// Limits for what the plate closes, where supports tie the part to it.
fn plate_closes(process: &Process) -> Option<Limits> {
    limits_of(process, "trapped-volume.on-plate").filter(|_| process.prints_supports)
}

/// What findings are made with.
struct Judge<'a> {
    part: &'a Part,
    context: &'a Context,
    voids: &'a Voids<'a>,
    /// The wall that has to stay around a vent.
    wall_mm: f64,
    /// Where a vent may lead.
    leading: Leading,
    /// Ways out that the process asks of a hollow.
    mouths: f64,
    measured: Measured,
    shapes: Vec<(f64, TriangleMesh)>,
    /// Rooms narrower than the limit that may have a way out as wide as it.
    doubtful_rooms: usize,
    /// Places whose way out was not followed to its end.
    unfollowed: u64,
}

impl Judge<'_> {
    /// One finding for all sealed voids, the largest first, each with a place of its own.
    fn sealed(&mut self, kind: &str, places: &[Trapped], limits: Limits, ball: f64) -> Result<()> {
        let mut order: Vec<&Trapped> = places.iter().collect();
        order.sort_by(|a, b| b.volume_mm3.value.total_cmp(&a.volume_mm3.value));
        let Some(&largest) = order.first() else { return Ok(()) };
        let mut f = Finding::judged(META.code, kind, largest.volume_mm3, largest.basis, limits, "mm3", 0.0);
        let sum = self.locate_all(&mut f, &order, |t| t.volume_mm3);
        let certain = kind == "sealed";
        f.message = match (order.len(), certain) {
            (1, true) => format!("a sealed void of {} mm³", short(largest.volume_mm3.value)),
            (1, false) => format!("a void of about {} mm³ that may be sealed", short(largest.volume_mm3.value)),
            (n, true) => format!("{n} sealed voids, {} mm³ in all", short(sum)),
            (n, false) => format!("{n} voids that may be sealed, about {} mm³ in all", short(sum)),
        };
        f.fix = if certain {
            let vent = self.vent_words(&order, if ball > 0.0 { ball } else { PLAIN_VENT })?;
            vent + &self.more_ways()
        } else {
            let half = short(0.5 * self.context.spacing_mm);
            format!("look again with --voxel {half}mm, or close the mesh so that its shells tell")
        };
        self.note(f, Some(largest.at), "mm3", "trapped-volume.sealed");
        self.shapes.extend(order.iter().map(|t| (t.volume_mm3.value, t.shape.clone())));
        Ok(())
    }

    /// A finding for the chambers that break or may break the limit alike.
    fn narrow(&mut self, places: &[Trapped], limits: Limits, widest: f64) -> Result<()> {
        let mut order: Vec<&Trapped> = places.iter().collect();
        order.sort_by(|a, b| a.way_out_mm.value.total_cmp(&b.way_out_mm.value));
        let all = vents(self.part, &order, self.wanted(widest))?;
        let (mut findings, mut tried) = (Vec::new(), Vec::new());
        for (t, vent) in order.iter().zip(all) {
            let mut f = self.way_out(t, limits);
            if f.state == State::Pass {
                continue;
            }
            locate(&mut f, self.part, self.context, t.at, t.extent);
            f.volume_mm3 = Some(report_digits(t.volume_mm3.value));
            f.places = vec![self.spot(t, t.way_out_mm)];
            f.witness = t.throat.map(|throat| Witness {
                kind: "throat".into(),
                points_mm: vec![reported(self.part, t.at), reported(self.part, throat)],
            });
            let counts = self.voids.has_room(t, MOUTHS_ROOM * widest);
            tried.push(Tried { at_mm: f.at_mm, venting: vent, counts });
            findings.push(f);
            self.shapes.push((t.volume_mm3.value, t.shape.clone()));
        }
        let telling = Telling { part: self.part, spacing_mm: self.context.spacing_mm, widest, more: self.more_ways() };
        // As close as the report tells them.
        for mut f in group_equal(findings, ALIKE) {
            telling.describe(&mut f, &tried);
            let at = order.iter().find(|t| reported(self.part, t.at) == f.at_mm).map(|t| t.at);
            self.note(f, at, "mm", "trapped-volume");
        }
        Ok(())
    }

    fn way_out(&self, t: &Trapped, limits: Limits) -> Finding {
        Finding::judged(META.code, "narrow-way-out", t.way_out_mm, t.basis, limits, "mm", self.part.tie())
    }

    /// One finding for the rooms that are narrower than the limit and whose way out is narrower still: limits for ways out are
    /// written for hollows that a ball of theirs fits into, so these only warn.
    fn small_rooms(&mut self, places: &[Trapped], limit: f64) -> Result<()> {
        let limits = Limits { fail: None, warn: Some(limit), sense: Sense::Min };
        let (mut order, doubtful): (Vec<&Trapped>, Vec<&Trapped>) =
            places.iter().partition(|t| t.way_out_mm.high < limit);
        self.doubtful_rooms = doubtful.len();
        order.sort_by(|a, b| a.way_out_mm.value.total_cmp(&b.way_out_mm.value));
        let Some(&narrowest) = order.first() else { return Ok(()) };
        let bracket = narrowest.way_out_mm;
        let mut f = Finding::judged(META.code, "small-room", bracket, narrowest.basis, limits, "mm", self.part.tie());
        let sum = self.locate_all(&mut f, &order, |t| t.way_out_mm);
        let [low, high] = [bracket.low, bracket.high].map(hundredths);
        f.message = match order.len() {
            1 => format!(
                "a room of about {} whose widest way out is {low} to {high} mm",
                bulk(narrowest.volume_mm3.value)
            ),
            n => format!("{n} rooms, about {} in all, the narrowest way out {low} to {high} mm", bulk(sum)),
        };
        f.fix = self.vent_words(&order, limit)?;
        self.note(f, Some(narrowest.at), "mm", "trapped-volume");
        self.shapes.extend(order.iter().map(|t| (t.volume_mm3.value, t.shape.clone())));
        Ok(())
    }

    /// One finding for all that the plate closes and that is open otherwise; what may be as wide open as wanted may hold nothing.
    fn on_plate(&mut self, news: &[Trapped], (limits, least): (Limits, f64)) {
        let Some(largest) = news.iter().max_by(|a, b| a.volume_mm3.value.total_cmp(&b.volume_mm3.value)) else {
            return;
        };
        let sum = |of: fn(&Bracket) -> f64| news.iter().map(|t| of(&t.volume_mm3)).sum::<f64>();
        let shut = news.iter().filter(|t| t.way_out_mm.high < least).map(|t| t.volume_mm3.low).sum::<f64>();
        let bracket = Bracket::new(sum(|b| b.value), shut, sum(|b| b.high));
        let tie = 2.0 * ROUNDING * bracket.high;
        let mut f = Finding::judged(META.code, "on-plate", bracket, Basis::Estimated, limits, "mm3", tie);
        if f.state == State::Pass {
            return;
        }
        locate(&mut f, self.part, self.context, largest.at, largest.extent);
        f.count = news.len() as u64;
        f.volume_mm3 = Some(report_digits(bracket.value));
        f.places = news.iter().map(|t| self.spot(t, t.volume_mm3)).collect();
        let [low, value, high] = [bracket.low, bracket.value, bracket.high].map(|v| short(v.round()));
        let volume = if low == high { value } else { format!("{low} to {high}") };
        f.message = format!(
            "the plate leaves {volume} mm³ of void no way out of {} mm until the part is cut off",
            short(least)
        );
        f.fix = "let it out above the plate".into();
        self.note(f, Some(largest.at), "mm3", "trapped-volume.on-plate");
    }

    /// Gives a finding the places of several, the first the foremost; returns their volume, mm³.
    fn locate_all(&self, f: &mut Finding, order: &[&Trapped], value: impl Fn(&Trapped) -> Bracket) -> f64 {
        let Some((first, others)) = order.split_first() else { return 0.0 };
        locate(f, self.part, self.context, first.at, first.extent);
        for t in others {
            let corners = [t.extent.0, t.extent.1].map(|p| reported(self.part, p));
            for (a, c) in (0..3).flat_map(|a| corners.map(|c| (a, c[a]))) {
                f.box_mm[0][a] = f.box_mm[0][a].min(c);
                f.box_mm[1][a] = f.box_mm[1][a].max(c);
            }
        }
        let sum = order.iter().map(|t| t.volume_mm3.value).sum::<f64>();
        f.count = order.len() as u64;
        f.volume_mm3 = Some(report_digits(sum));
        f.places = order.iter().map(|t| self.spot(t, value(t))).collect();
        sum
    }

    fn spot(&self, t: &Trapped, b: Bracket) -> Spot {
        let b = b.rounded();
        let box_mm = Some(reported_box(self.part, t.extent));
        Spot { at_mm: reported(self.part, t.at), box_mm, value: b.value, low: b.low, high: b.high }
    }

    /// What else is wanted of a hollow once it has a way out.
    fn more_ways(&self) -> String {
        let more = format!("; to empty a hollow this process asks for {} ways out", short(self.mouths));
        if self.mouths > 1.0 { more } else { String::new() }
    }

    fn vent_words(&self, places: &[&Trapped], ball: f64) -> Result<String> {
        advice(self.part, places, self.wanted(ball))
    }

    fn wanted(&self, ball_mm: f64) -> Wanted {
        Wanted { ball_mm, wall_mm: self.wall_mm, leading: self.leading }
    }

    fn note(&mut self, f: Finding, at: Option<[f64; 3]>, unit: &'static str, rule: &'static str) {
        if self.measured.findings.iter().all(|g| g.state < f.state) {
            let bracket = Bracket { value: f.value, low: f.low, high: f.high };
            self.measured.worst = Some(Worst { bracket, unit, at });
            self.measured.rule = Some(rule);
        }
        self.measured.findings.push(f);
    }

    fn finish(&mut self, nooks: &u64, limit: Option<f64>) {
        let m = &mut self.measured;
        if m.worst.is_none() {
            m.worst = Some(Worst { bracket: Bracket::exact(0.0), unit: "mm3", at: None });
            m.rule = Some("trapped-volume.sealed");
        }
        let h = short(self.context.spacing_mm);
        m.cover = match limit {
            Some(limit) => {
                // A room is climbed to from a sample half a diagonal off, and as much may be lost on the way to the next.
                let (least, doubt) = (self.voids.least_room_mm(limit), 4.0 * HALF_DIAGONAL * self.context.spacing_mm);
                let narrower = format!(" Narrower rooms were looked for down to {} mm.", hundredths(least));
                format!(
                    "Every void of the mesh and of a grid of {h} mm was looked at; each room {} mm wide or more lets a ball of {} mm out \
                     unless it is listed.{} What is wider than its way out by less than {} mm may be missed; a smaller --voxel sees it.",
                    short(((limit + doubt) * 100.0).ceil() / 100.0),
                    short(limit),
                    if least < limit { &narrower } else { "" },
                    short((doubt * 100.0).ceil() / 100.0)
                )
            }
            None => format!("Every closed shell of the mesh and every void of a grid of {h} mm was looked at."),
        };
        let mut left = |count: u64, what: &str| {
            if count > 0 {
                m.cover.push_str(&format!(" {count} {what}."));
            }
        };
        left(*nooks, "samples lie in nooks that the grid closes and that were not followed");
        left(self.doubtful_rooms as u64, "such rooms may have a way out as wide as the limit and are not listed");
        left(self.unfollowed, "more may be wider than their way out, which the budget did not allow to follow");
        let volume: f64 = self.shapes.iter().map(|s| s.0).sum();
        let mesh = self.shapes.drain(..).fold(TriangleMesh::default(), |all, (_, one)| all.joined(&one));
        if !mesh.triangles.is_empty() {
            let title = format!("Trapped volumes, {}", bulk(volume));
            m.shapes.push(ShapeShown { name: "trapped", title, mesh });
        }
    }
}
