//! Chambers with fewer mouths than a process needs to empty them.

use super::bore::{Vent, Wanted};
use super::budget::Budget;
use super::contract::Context;
use super::filling::Filling;
use super::finding::{Basis, Bracket, Finding, Limits, State};
use super::place::{group_equal, locate, reported};
use super::throat::Ground;
use super::vent::{drilled, vents};
use super::void::{HALF_DIAGONAL, Trapped, Voids, rises, way_out};
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::Solid;
use crate::morphology::grown;
use crate::topology::{Adjacency, Chamber, Components, Side, border, chambers, components};
use crate::units::{bulk, report_digits, short};

/// Counts the mouths of chambers.
pub(super) struct Mouths<'a> {
    pub voids: &'a Voids<'a>,
    pub context: &'a Context,
    pub limits: Limits,
    /// Room for a ball of this diameter makes a chamber, mm.
    pub room_mm: f64,
    /// What a vent that is tried has to be like; its ball is the one that has to pass a mouth.
    pub wanted: Wanted,
}

impl Mouths<'_> {
    /// A finding for all chambers with as many mouths, and the chambers, those left out whose way out is known to be too narrow.
    ///
    /// What is advised has been drilled into the sets and the mouths were counted again.
    ///
    /// # Errors
    /// As [`Voids::mouths`].
    pub fn findings(
        &self,
        clearance: &Field<u32>,
        known: &[&Trapped],
        budget: &mut Budget,
    ) -> Result<(Vec<Finding>, Vec<Trapped>)> {
        let mut rooms = Vec::new();
        for (chamber, mouths) in self.voids.mouths(clearance, self.room_mm, self.wanted.ball_mm)? {
            let room = self.voids.trapped(&chamber, clearance)?;
            if known.iter().any(|k| k.overlaps(&room)) || self.judged(mouths.bracket()).state == State::Pass {
                continue;
            }
            if self.is_wide_open(clearance, &chamber, &room, budget)? {
                continue;
            }
            let count = self.voids.settled(clearance, (&room, &chamber, &mouths), self.wanted.ball_mm, budget)?;
            if self.judged(count).state > State::Pass {
                rooms.push((room, count));
            }
        }
        let places: Vec<&Trapped> = rooms.iter().map(|(t, _)| t).collect();
        let part = self.voids.part();
        let found: Vec<Option<Vent>> = vents(part, &places, self.wanted)?.into_iter().map(|v| v.vent()).collect();
        let enough = self.counted_again(&found, &rooms)?;
        let tried: Vec<([f64; 3], Option<Vent>)> =
            places.iter().zip(found).zip(enough).map(|((t, v), ok)| (reported(part, t.at), v.filter(|_| ok))).collect();
        let located = |(t, count): &(Trapped, Bracket)| {
            let mut f = self.judged(*count);
            locate(&mut f, part, self.context, t.at, t.extent);
            f.volume_mm3 = Some(report_digits(t.volume_mm3.value));
            f
        };
        let mut findings = group_equal(rooms.iter().map(located).collect(), 0.0);
        findings.iter_mut().for_each(|f| self.describe(f, &tried));
        Ok((findings, rooms.into_iter().map(|(t, _)| t).collect()))
    }

    /// Whether the ball that makes a chamber gets out of it for certain, by the surface where the samples do not tell.
    fn is_wide_open(
        &self,
        clearance: &Field<u32>,
        chamber: &Chamber,
        room: &Trapped,
        budget: &mut Budget,
    ) -> Result<bool> {
        let is_told =
            way_out(chamber, self.voids.spacing_mm()).high < self.room_mm || !self.voids.part().health().is_solid();
        Ok(!is_told && self.voids.lets_out(clearance, room, (self.room_mm, Ground::Nothing), budget)?)
    }

    fn judged(&self, count: Bracket) -> Finding {
        Finding::judged("AM301", "mouths", count, Basis::Estimated, self.limits, "1", 0.0)
    }

    fn needed(&self) -> f64 {
        self.limits.warn.or(self.limits.fail).unwrap_or(2.0)
    }

    /// Whether each chamber has as many mouths as are needed once all vents are drilled: its own that are certain and the vent, which is
    /// wider than the ball by its diameter, are enough, and when they are counted again none of them has run into another.
    fn counted_again(&self, found: &[Option<Vent>], rooms: &[(Trapped, Bracket)]) -> Result<Vec<bool>> {
        let all: Vec<Vent> = found.iter().flatten().copied().collect();
        if all.is_empty() {
            return Ok(vec![false; rooms.len()]);
        }
        let Solid { inner, centres, outer, density, doubt } = self.voids.solid;
        let [inner, centres, outer] = [inner, centres, outer].map(|set| drilled(set, &all));
        let open = Solid { inner, centres, outer, density: density.clone(), doubt: *doubt };
        let opened = Voids::within(self.voids.part(), &open)?;
        let clearance = opened.clearance()?;
        let found = opened.mouths(&clearance, self.room_mm, self.wanted.ball_mm)?;
        let mut after = Vec::new();
        for (chamber, mouths) in found {
            after.push((opened.trapped(&chamber, &clearance)?, mouths.bracket().value));
        }
        let is_enough = |(t, own): &(Trapped, Bracket)| {
            // What is wide open after drilling is no chamber any more.
            let counted = after.iter().all(|(r, count)| !r.overlaps(t) || *count >= self.needed());
            counted && own.low + 1.0 >= self.needed()
        };
        Ok(rooms.iter().map(is_enough).collect())
    }

    fn describe(&self, f: &mut Finding, tried: &[([f64; 3], Option<Vent>)]) {
        let ball = short(self.wanted.ball_mm);
        let mouths = match f.low == f.high {
            true => format!("{} mouth{} of at least {ball} mm", f.value, if f.value == 1.0 { "" } else { "s" }),
            false => format!("{} to {} mouths of about {ball} mm", f.low, f.high),
        };
        let volume = bulk(f.volume_mm3.unwrap_or(0.0));
        f.message = match f.count {
            1 => format!("a chamber of about {volume} with {mouths}"),
            n => format!("{n} chambers, about {volume} in all, each with {mouths}"),
        };
        let own = || tried.iter().filter(|(at, _)| f.places.iter().any(|p| p.at_mm == *at)).filter_map(|t| t.1);
        let (needed, wide) = (short(self.needed()), short(self.room_mm));
        f.fix = match (own().next(), own().count() as u64) {
            (Some(v), 1) if f.count == 1 => {
                format!("drill {}: counted again, it then has {needed}", v.words(self.voids.part()))
            }
            (Some(v), n) => {
                format!("drill {}: counted again, {n} of {} then have {needed}", v.words(self.voids.part()), f.count)
            }
            (None, _) => format!("give it {needed} mouths of at least {ball} mm, far from each other"),
        };
        f.fix += &format!("; one of {wide} mm is enough by itself");
    }
}

/// The mouths of a chamber for balls of three sizes: as asked, and narrower and wider by what the samples do not tell.
pub(super) struct Counted {
    told: Components,
    narrow: Components,
    wide: Components,
}

impl Counted {
    /// How many there are: told, at least and at most.
    fn bracket(&self) -> Bracket {
        let [told, narrow, wide] = [&self.told, &self.narrow, &self.wide].map(|of| of.count() as f64);
        Bracket::new(told, told.min(narrow).min(wide), told.max(narrow).max(wide))
    }

    /// Those for the narrower ball in which there is none for the wider one; `None` where one holds several, which the samples do not
    /// part.
    fn doubtful(&self) -> Option<Vec<u32>> {
        let mut holds = vec![0u32; self.narrow.count()];
        for first in self.wide.first_samples() {
            *holds.get_mut(self.narrow.of(first)? as usize)? += 1;
        }
        let is_parted = holds.iter().all(|&n| n <= 1);
        is_parted.then(|| (0..holds.len() as u32).filter(|&m| holds[m as usize] == 0).collect())
    }
}

impl Voids<'_> {
    /// Chambers with room for a ball of `room_mm` whose way out is narrower, each with its mouths that let a ball of `ball_mm` out.
    ///
    /// A mouth is a place where the void as wide as the ball goes on from the balls that fill the chamber to the outside, or
    /// where these balls themselves reach out of the grid.
    fn mouths(&self, clearance: &Field<u32>, room_mm: f64, ball_mm: f64) -> Result<Vec<(Chamber, Counted)>> {
        let exits = border(&self.grid, &Side::ALL);
        let level = |diameter: f64| ((0.5 * diameter / self.grid.h()).powi(2).ceil() as u32).max(1);
        let mut found = Vec::new();
        for chamber in chambers(clearance, &exits, level(room_mm), |at| self.is_sealed(at))? {
            if self.is_sealed(chamber.deepest) || !rises(&chamber) {
                continue;
            }
            let own = Filling::of(&chamber, clearance, self.solid)?.whole()?;
            let untold = 4.0 * HALF_DIAGONAL * self.grid.h();
            let of = |ball: f64| self.mouths_of(&own, clearance, &exits, level(ball));
            let (told, narrow, wide) = (of(ball_mm)?, of((ball_mm - untold).max(0.0))?, of(ball_mm + untold)?);
            found.push((chamber, Counted { told, narrow, wide }));
        }
        Ok(found)
    }

    /// The places where the void of so much clearance goes on from what fills a chamber to the outside.
    fn mouths_of(&self, own: &Indicator, clearance: &Field<u32>, exits: &Indicator, least: u32) -> Result<Components> {
        let wide = Indicator::from_predicate(self.grid, |at| clearance.values()[at] >= least);
        let beyond = wide.difference(own)?;
        let parts = components(&beyond, Adjacency::Corner);
        let mut out = vec![false; parts.count()];
        for at in exits.intersection(&beyond)?.iter() {
            parts.of(self.grid.index(at)).into_iter().for_each(|l| out[l as usize] = true);
        }
        let goes_on = parts.select(|l| out[l as usize]).intersection(&grown(own, 1))?;
        let reaches_out = own.intersection(exits)?.intersection(&wide)?;
        Ok(components(&goes_on.union(&reaches_out)?, Adjacency::Corner))
    }

    /// How many mouths of a chamber let the ball out, those that the samples leave open told by the surface itself: with all others
    /// closed, it gets out for certain, or is stuck for certain.
    ///
    /// # Errors
    /// As [`Voids::lets_out`].
    fn settled(
        &self,
        clearance: &Field<u32>,
        (room, chamber, mouths): (&Trapped, &Chamber, &Counted),
        ball_mm: f64,
        budget: &mut Budget,
    ) -> Result<Bracket> {
        let bracket = mouths.bracket();
        let doubtful = mouths.doubtful().filter(|_| bracket.low < bracket.high && self.part().health().is_solid());
        let Some(doubtful) = doubtful else { return Ok(bracket) };
        let (mut sure, mut open) = (mouths.wide.count(), mouths.narrow.count());
        for mouth in doubtful {
            let mut alone = clearance.clone();
            mouths.narrow.select(|m| m != mouth).iter().for_each(|at| alone.values_mut()[at] = 0);
            let shut = self.room_about(&alone, (chamber.deepest, chamber.widest), budget)?;
            let Some(throat) = shut.and_then(|shut| shut.throat) else { continue };
            let way = Trapped { throat: Some(self.place(throat.at)), ..room.clone() };
            if self.lets_out(&alone, &way, (ball_mm, Ground::Nothing), budget)? {
                sure += 1;
            } else if self.is_barred(&alone, &way, ball_mm, budget)? {
                open -= 1;
            }
        }
        let (low, high) = (sure as f64, open as f64);
        Ok(Bracket::new(bracket.value.clamp(low, high), low, high))
    }
}

#[cfg(test)]
mod tests {
    use super::super::bore::Leading;
    use super::super::finding::Sense;
    use super::super::void::tests::{flask, part, turned};
    use super::*;
    use crate::geometry::revolved;
    use crate::random::Lcg;

    #[test]
    fn a_hole_is_one_mouth_however_thin_its_wall() {
        for (wall, neck) in [(0.6, 4.0), (1.0, 3.6), (1.0, 4.0), (1.0, 6.0), (1.5, 4.0), (2.0, 6.0), (3.0, 4.0)] {
            for h in [0.15, 0.24] {
                let part = part(flask(20.0, 20.0 - 2.0 * wall, neck), h, [0.2, -0.3, 0.1]);
                let voids = Voids::of(&part).unwrap();
                let counts = |ball: f64| {
                    let found = voids.mouths(&voids.clearance().unwrap(), 10.0, ball).unwrap();
                    let told = |b: Bracket| [b.value, b.low, b.high];
                    found.into_iter().map(|(_, mouths)| told(mouths.bracket())).collect::<Vec<_>>()
                };
                // A ball of the neck's own width may pass or not, as far as the samples tell.
                let [told, none] = [[1.0, 1.0, 1.0], [0.0, 0.0, 0.0]];
                assert_eq!((counts(2.5), counts(neck + 1.0)), (vec![told], vec![none]), "{wall} {neck} {h}");
                let [[_, low, high]] = counts(neck)[..] else { panic!("{wall} {neck} {h}") };
                assert_eq!([low, high], [0.0, 1.0], "{wall} {neck} {h}");
            }
        }
    }

    #[test]
    fn a_room_that_lets_out_the_ball_that_makes_it_a_chamber_needs_no_second_mouth() {
        let context = Context { refine: 1 << 26, spacing_mm: 0.3 };
        let limits = Limits { fail: None, warn: Some(2.0), sense: Sense::Min };
        let wanted = Wanted { ball_mm: 4.0, wall_mm: 1.0, leading: Leading::Anywhere };
        for (neck, told) in [(9.85, 1), (10.15, 0)] {
            for at in [[0.0; 3], [0.13, -0.07, 0.21]] {
                let part = part(flask(20.0, 17.0, neck), 0.3, at);
                let voids = Voids::of(&part).unwrap();
                let mouths = Mouths { voids: &voids, context: &context, limits, room_mm: 10.0, wanted };
                let clearance = voids.clearance().unwrap();
                let met = voids.mouths(&clearance, 10.0, 4.0).unwrap();
                assert_eq!(met.len(), 1, "{neck} at {at:?}: by the samples it is a chamber");
                let (found, _) = mouths.findings(&clearance, &[], &mut Budget::of(context.refine)).unwrap();
                assert_eq!(found.len(), told, "{neck} at {at:?}: {found:?}");
            }
        }
    }

    #[test]
    fn a_mouth_about_as_wide_as_the_ball_is_measured_on_the_surface() {
        let mut rng = Lcg(61);
        let ball = 3.0;
        for case in 0..24 {
            // A room with a mouth of 4.4 mm above, and one below that lets the ball out or does not by a few hundredths.
            let by = if case % 2 == 0 { 0.1 + 0.1 * rng.unit() } else { -0.04 - 0.1 * rng.unit() };
            let a = 0.5 * (ball + by) / (std::f64::consts::PI / 64.0).cos();
            let outline =
                [[a, -8.0], [8.0, -8.0], [8.0, 8.0], [2.2, 8.0], [2.2, 6.0], [6.0, 6.0], [6.0, -6.0], [a, -6.0]];
            let mesh = turned(&revolved(&outline, 64), || rng.unit());
            let part = part(mesh, 0.2 + 0.05 * rng.unit(), [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let clearance = voids.clearance().unwrap();
            let found = voids.mouths(&clearance, 9.0, ball).unwrap();
            let [(chamber, mouths)] = &found[..] else { panic!("{case}: {} rooms", found.len()) };
            let samples = mouths.bracket();
            assert_eq!([samples.low, samples.high], [1.0, 2.0], "{case}");
            let room = voids.trapped(chamber, &clearance).unwrap();
            let settled = |budget: u64| {
                let count = voids.settled(&clearance, (&room, chamber, mouths), ball, &mut Budget::of(budget)).unwrap();
                [count.value, count.low, count.high]
            };
            assert_eq!(settled(1 << 26), [if by > 0.0 { 2.0 } else { 1.0 }; 3], "{case}: {by}");
            assert_eq!(settled(0), [samples.value, 1.0, 2.0], "{case}");
        }
    }
}
