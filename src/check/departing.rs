//! Places that are not printed as drawn: sheets and slots by their widths, and what else a lattice of the whole part shows.

use super::budget::Budget;
use super::contract::{Context, limits_of};
use super::departure::{Departure, Place, Volumes};
use super::detail::{Between, Detail};
use super::finding::{Basis, Bracket, Finding, Limits, State};
use super::laid::bodies_at;
use super::least_width::LeastWidth;
use super::place::locate;
use super::trial::Trial;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, add, sub};
use crate::medial::Side;
use crate::morphology::{AsPrinted, Bead, Cells};
use crate::part::{Part, bead_of};
use crate::process::Process;
use crate::topology::{Adjacency, components};
use crate::units::{Length, report_digits, short};

/// Places that are measured whatever the budget for finer looks is, largest first.
const MEASURED: usize = 6;
/// Samples that have to be left for another: as many as its lattice may take.
const FIRST_LOOK: u64 = 1 << 22;
/// Times that what is still open has another share of the budget.
const ROUNDS: usize = 3;
/// Places whose remedy is tried out.
const TRIED: usize = 4;
/// What is at least so many widths of the element across is broad: its rim, which stays open, matters little.
const BROAD: f64 = 2.0;
/// A remedy is tried out up to so many widths of the element from the narrowest place.
const TRIED_WITHIN: f64 = 6.0;

/// Seeks on one side of the surface what is not printed as drawn, and measures it.
pub(super) struct Seeker<'a> {
    part: &'a Part,
    process: &'a Process,
    context: &'a Context,
    side: Side,
    limits: Limits,
    bead: Bead,
    least: LeastWidth<'a>,
}

/// A place that may not be printed as drawn.
pub(super) struct Candidate {
    /// Volume that may depart, mm³: by which places are ranked, as it was measured, and what the lattice of the whole part says of it.
    about: f64,
    holds: f64,
    known: Option<(Volumes, Length)>,
    extent: (Vec3, Vec3),
    /// The middle of the narrowest place, the direction across it, and the width there.
    at: Vec3,
    direction: Vec3,
    width: f64,
    /// What it is, where it was measured on the mesh.
    noun: Option<&'static str>,
    /// Boxes around the patches of a slot; none for what counts as a whole.
    patches: Vec<(Vec3, Vec3)>,
    /// Whether what lies between its sides is what departs: a sheet, or a slot that is broad.
    flat: bool,
    /// The rule of narrow-gap that a slot or hole comes under.
    gap_rule: Option<&'static str>,
}

impl<'a> Seeker<'a> {
    pub fn new(part: &'a Part, process: &'a Process, context: &'a Context, (side, limits): (Side, Limits)) -> Self {
        let least = LeastWidth::new(part, process, context, side);
        Seeker { part, process, context, side, limits, bead: bead_of(process), least }
    }

    fn kind(&self) -> &'static str {
        if self.side == Side::Material { "lost" } else { "filled" }
    }

    fn departure(&self) -> Departure {
        Departure::of_outline(self.side, self.process)
    }

    /// The places that may depart, largest first: all sheets and slots that are narrow enough, and what else a lattice of the whole part
    /// shows, if there is one.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    pub fn places(&self, made: Option<&AsPrinted>) -> Result<(Vec<Candidate>, String)> {
        let found = self.least.narrow(match self.side {
            Side::Material => Between::SidesOfABody,
            Side::Void => Between::Surfaces,
        });
        let mut places: Vec<Candidate> = found.places.iter().map(|d| self.candidate(d)).collect();
        let mut words = format!(
            "{} {} narrow enough to be {}, all sought down to {} mm across.",
            places.len(),
            match (self.side, places.len()) {
                (Side::Material, 1) => "sheet is",
                (Side::Material, _) => "sheets are",
                (Side::Void, 1) => "slot is",
                (Side::Void, _) => "slots are",
            },
            self.kind(),
            short(found.finest)
        );
        if let Some(made) = made {
            let (others, small) = self.on_the_lattice(made, &places)?;
            places.extend(others);
            match small {
                0 => {}
                1 => words.push_str(&format!(" One smaller place is {} too.", self.kind())),
                n => words.push_str(&format!(" {n} smaller places are {} too.", self.kind())),
            }
        }
        places.sort_by(|a, b| b.about.total_cmp(&a.about));
        Ok((places, words))
    }

    fn candidate(&self, detail: &Detail) -> Candidate {
        let bodies = || bodies_at(self.part, detail.thinnest.contacts.into_iter()).len();
        let of_gap = || if bodies() > 1 { "narrow-gap.between-bodies" } else { "narrow-gap" };
        Candidate {
            gap_rule: (self.side == Side::Void).then(of_gap),
            about: detail.volume,
            holds: detail.holds,
            known: None,
            extent: detail.extent,
            at: detail.thinnest.centre,
            direction: detail.thinnest.direction(),
            width: detail.thinnest.diameter,
            noun: Some(match (detail.noun(), self.side) {
                (noun, Side::Material) => noun,
                ("sheet", Side::Void) => "slot",
                ("rod", Side::Void) => "hole",
                (_, Side::Void) => "pit",
            }),
            patches: match self.side {
                Side::Void => detail.patches.iter().map(|patch| patch.extent).collect(),
                Side::Material => Vec::new(),
            },
            flat: detail.noun() == "sheet"
                && (self.side == Side::Material || detail.spans[1] >= BROAD * self.bead.width.as_mm()),
        }
    }

    /// What departs on the lattice of the whole part beside the places that are known, and how many others are too small to tell.
    ///
    /// Where the lattice alone does not tell, what the mesh shows to be as wide as is asked is left out.
    fn on_the_lattice(&self, made: &AsPrinted, beside: &[Candidate]) -> Result<(Vec<Candidate>, usize)> {
        // What only the samples show is reported too: a pass would claim that it is printed. A cell that is touched holds some of the
        // part, and what not even the larger set prints is not printed.
        let [certain, about, possibly] = if self.side == Side::Material { made.lost()? } else { made.filled()? };
        let set = match self.side {
            Side::Material => made.designed.shape.outer.difference(&made.upper)?.union(&about)?,
            Side::Void => certain.union(&about)?,
        };
        let seen = self.hanging_together(&made.designed.cells, &set, [&about, &certain, &possibly], beside);
        let is_open = |c: &Candidate| c.known.is_some_and(|(volumes, _)| self.place(c).open_limit(volumes).is_some());
        if !seen.0.iter().any(is_open) {
            return Ok(seen);
        }
        let stays = self.least.staying(&made.designed, &made.designed.shape.centres)?.difference(&certain)?;
        let left = |set: &Indicator| set.difference(&stays);
        let departs = [left(&about)?, certain.clone(), left(&possibly)?];
        Ok(self.hanging_together(&made.designed.cells, &left(&set)?, departs.each_ref(), beside))
    }

    /// The pieces of a set of cells beside the places that are known, with the volumes in their boxes of what departs: about, for certain
    /// and perhaps; and how many others are too small to tell.
    fn hanging_together(
        &self,
        cells: &Cells,
        set: &Indicator,
        departs: [&Indicator; 3],
        beside: &[Candidate],
    ) -> (Vec<Candidate>, usize) {
        let none = Indicator::empty(cells.grid);
        let volume_in = |set: &Indicator, extent| cells.volume_in(set, &none, extent).as_mm3();
        let parts = components(set, Adjacency::Corner);
        let (sizes, boxes, firsts) = (parts.sizes(), parts.boxes(), parts.first_samples());
        let (cell, least) = (cells.cell_mm(), self.limits.warn.or(self.limits.fail).unwrap_or(0.0));
        let (mut places, mut small) = (Vec::new(), 0);
        for (i, [first, last]) in boxes.iter().enumerate() {
            let extent =
                (sub(cells.position(*first), cell.map(|c| 2.5 * c)), add(cells.position(*last), cell.map(|c| 2.5 * c)));
            if beside.iter().any(|c| meet(c.extent, extent)) {
                continue;
            }
            let known = departs.map(|set| volume_in(set, extent));
            // What is filled at the bottom of a sharp notch is less than the limit, and no slot.
            if known[0] <= least {
                small += 1;
                continue;
            }
            let span = [0, 1, 2].map(|a| extent.1[a] - extent.0[a] - 4.0 * cell[a]);
            let thin = (0..3).min_by(|&a, &b| span[a].total_cmp(&span[b])).unwrap_or(0);
            places.push(Candidate {
                about: (cells.cell_volume() * sizes[i] as f64).as_mm3(),
                holds: (cells.cell_volume() * sizes[i] as f64).as_mm3(),
                known: Some((known, cells.grid.spacing())),
                extent,
                at: cells.position(firsts[i]),
                direction: [0, 1, 2].map(|a| if a == thin { 1.0 } else { 0.0 }),
                width: span[thin],
                noun: None,
                patches: Vec::new(),
                flat: false,
                gap_rule: None,
            });
        }
        (places, small)
    }

    /// What of each place departs, told from the limits as far as the budget goes: each has its share of it, and what others leave goes to
    /// what is still open.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    pub fn measured(&self, places: &[Candidate], budget: &mut Budget) -> Result<Vec<(Bracket, Basis)>> {
        let mut known: Vec<Option<(Volumes, Length)>> = Vec::with_capacity(places.len());
        for (rank, place) in places.iter().enumerate() {
            let measured = place.known.is_some() || rank < MEASURED || budget.left >= FIRST_LOOK;
            known.push(if measured { Some(self.first_look(place, rank, budget)?) } else { None });
        }
        for _ in 0..ROUNDS {
            let is_open = |known: &Option<(Volumes, Length)>, place: &Candidate| {
                known.is_some_and(|(volumes, _)| self.place(place).open_limit(volumes).is_some())
            };
            let mut left = known.iter().zip(places).filter(|(known, place)| is_open(known, place)).count() as u64;
            for (known, place) in known.iter_mut().zip(places) {
                if let (true, Some(found)) = (is_open(known, place), *known) {
                    let share = budget.left / left.max(1);
                    *known = Some(self.place(place).told(found, share, budget)?);
                    left = left.saturating_sub(1);
                }
            }
        }
        Ok(known.into_iter().zip(places).map(|(known, place)| self.bracket(place, known)).collect())
    }

    /// What the lattice of the part or a coarse one of its own tells of a place.
    fn first_look(&self, place: &Candidate, rank: usize, budget: &mut Budget) -> Result<(Volumes, Length)> {
        if let Some(known) = place.known {
            return Ok(known);
        }
        let trial = Trial::around(self.part, self.bead, place.extent, self.departure())?;
        if let (Some(trial), true) = (&trial, rank >= MEASURED) {
            budget.note(1, trial.cells());
        }
        match trial {
            Some(trial) => Ok((trial.volumes()?, trial.cell())),
            // No such lattice holds it, and a box holds no more than its own volume.
            None => Ok(([place.holds, 0.0, self.most_in(place.extent)], self.bead.width)),
        }
    }

    fn bracket(&self, place: &Candidate, known: Option<(Volumes, Length)>) -> (Bracket, Basis) {
        let Some(([value, low, high], _)) = known else {
            let most = self.most_in(place.extent);
            return (Bracket::new(place.holds.min(most), 0.0, most), Basis::Estimated);
        };
        // Cells that are too coarse for a sheet or a slot tell less of it than what lies between its sides.
        let value = if place.flat { place.holds } else { value };
        (Bracket::new(value.clamp(low, high), low, high), Basis::Certified)
    }

    /// By how much a place is narrower than what would be printed as drawn.
    fn missing(&self, place: &Candidate) -> f64 {
        (self.least.along(place.direction) - place.width).max(0.0)
    }

    fn place<'p>(&'p self, place: &'p Candidate) -> Place<'p> {
        Place {
            part: self.part,
            bead: self.bead,
            departure: self.departure(),
            limits: self.limits,
            extent: place.extent,
            narrowest: place.at,
            across: place.direction,
            missing: self.missing(place),
            likely: place.flat.then_some(place.holds),
            patches: &place.patches,
        }
    }

    /// The finding of a place, with a remedy that was tried out where it is among the largest.
    ///
    /// # Errors
    /// As [`Part::deposited`].
    pub fn finding(&self, candidate: &Candidate, (bracket, basis): (Bracket, Basis), rank: usize) -> Result<Finding> {
        let mut f = Finding::judged("AM401", self.kind(), bracket, basis, self.limits, "mm3", 0.0);
        locate(&mut f, self.part, self.context, candidate.at, candidate.extent);
        f.volume_mm3 = Some(report_digits(bracket.value));
        let what = match (self.side, f.decided) {
            (Side::Material, true) => "of material is not printed".to_string(),
            (Side::Void, true) => "of void is filled".to_string(),
            (side, false) => {
                let verb =
                    if side == Side::Material { "of material may not be printed" } else { "of void may be filled" };
                format!("{verb}, between {} and {} mm³", rounded(bracket.low), rounded(bracket.high))
            }
        };
        let by = candidate.noun.map_or(String::new(), |noun| format!(": a {noun} of {} mm", rounded(candidate.width)));
        f.message = format!("{} mm³ {what}{by}", rounded(bracket.value));
        let tried = if rank < TRIED && f.state > State::Pass { self.remedied(candidate)? } else { None };
        let verb = if self.side == Side::Material { "thicken" } else { "widen" };
        f.fix = match tried {
            Some((by, place)) => {
                let asked = self.asks_beyond(candidate, candidate.width + by);
                format!("{verb} by {} mm; checked{place}: none of it is {} then{asked}", rounded(by), self.kind())
            }
            None => {
                let needed = self.least.along(candidate.direction);
                let round = if candidate.flat { "" } else { ", and of what is round somewhat more" };
                format!("less than {} mm between flat sides is {} here{round}", rounded(needed), self.kind())
            }
        };
        Ok(f)
    }

    /// What narrow-gap asks of a gap beyond such a width, in words.
    fn asks_beyond(&self, candidate: &Candidate, width: f64) -> String {
        let limit = candidate.gap_rule.and_then(|rule| limits_of(self.process, rule)).and_then(|l| l.fail);
        let wider = limit.filter(|l| width < l - self.part.tie());
        wider.map_or(String::new(), |l| format!("; narrow-gap asks for {} mm", short(l)))
    }

    /// Volume of a box, mm³, and of what an element reaches around it.
    fn most_in(&self, (lo, hi): (Vec3, Vec3)) -> f64 {
        (0..3).map(|a| hi[a] - lo[a] + self.bead.widest().as_mm()).product()
    }

    /// By how much a place has to grow to be printed as drawn, and where that was tried; `None` if it is not seen to depart on the cells
    /// that it was tried on, or no growth helps.
    fn remedied(&self, place: &Candidate) -> Result<Option<(f64, &'static str)>> {
        let reach = TRIED_WITHIN * self.bead.widest().as_mm();
        let near = ([0, 1, 2].map(|a| place.at[a] - reach), [0, 1, 2].map(|a| place.at[a] + reach));
        let lo = [0, 1, 2].map(|a| place.extent.0[a].max(near.0[a]));
        let hi = [0, 1, 2].map(|a| place.extent.1[a].min(near.1[a]));
        let Some(trial) = Trial::closely(self.part, self.bead, (lo, hi), self.departure())? else { return Ok(None) };
        if trial.volumes()?[0] == 0.0 {
            return Ok(None);
        }
        let steps = trial.remedied(place.direction, self.missing(place))?;
        let where_it_is = if (lo, hi) == place.extent { "" } else { " where it is narrowest" };
        Ok(steps.map(|n| (n as f64 * trial.step_along(place.direction), where_it_is)))
    }
}

fn meet(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> bool {
    (0..3).all(|i| a.0[i] <= b.1[i] && b.0[i] <= a.1[i])
}

/// Three decimals, for sentences; what they would show as nothing is below one of them.
pub(super) fn rounded(x: f64) -> String {
    match x.abs() {
        a if a >= 100.0 => short(x.round()),
        a if a >= 5e-4 || a == 0.0 => short((x * 1e3).round() / 1e3),
        _ => "less than 0.001".into(),
    }
}
