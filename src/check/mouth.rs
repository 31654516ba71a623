//! Chambers with fewer mouths than a process needs to empty them.

use super::bore::{Vent, Wanted};
use super::contract::Context;
use super::filling::Filling;
use super::finding::{Basis, Bracket, Finding, Limits, State};
use super::place::{group_equal, locate, reported};
use super::vent::{drilled, vents};
use super::void::{HALF_DIAGONAL, Trapped, Voids, rises};
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::Solid;
use crate::morphology::grown;
use crate::topology::{Adjacency, Side, border, chambers, components};
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
    pub fn findings(&self, clearance: &Field<u32>, known: &[&Trapped]) -> Result<(Vec<Finding>, Vec<Trapped>)> {
        let mut rooms = self.voids.mouths(clearance, self.room_mm, self.wanted.ball_mm)?;
        rooms.retain(|(t, count)| !known.iter().any(|k| k.overlaps(t)) && self.judged(*count).state > State::Pass);
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
        let after = opened.mouths(&clearance, self.room_mm, self.wanted.ball_mm)?;
        let is_enough = |(t, own): &(Trapped, Bracket)| {
            // What is wide open after drilling is no chamber any more.
            let counted = after.iter().all(|(r, count)| !r.overlaps(t) || count.value >= self.needed());
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
        let needed = short(self.needed());
        f.fix = match (own().next(), own().count() as u64) {
            (Some(v), 1) if f.count == 1 => {
                format!("drill {}: counted again, it then has {needed}", v.words(self.voids.part()))
            }
            (Some(v), n) => {
                format!("drill {}: counted again, {n} of {} then have {needed}", v.words(self.voids.part()), f.count)
            }
            (None, _) => format!("give it {needed} mouths of at least {ball} mm, far from each other"),
        };
    }
}

impl Voids<'_> {
    /// Chambers with room for a ball of `room_mm` whose way out is narrower, each with the number of its mouths that let
    /// a ball of `ball_mm` out.
    ///
    /// A mouth is a place where the void as wide as the ball goes on from the balls that fill the chamber to the outside, or
    /// where these balls themselves reach out of the grid. The bracket holds the numbers for balls that are smaller and larger by what the
    /// samples do not tell.
    pub fn mouths(&self, clearance: &Field<u32>, room_mm: f64, ball_mm: f64) -> Result<Vec<(Trapped, Bracket)>> {
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
            let [told, narrow, wide] = [of(ball_mm)?, of((ball_mm - untold).max(0.0))?, of(ball_mm + untold)?];
            let [least, most] = [told.min(narrow).min(wide), told.max(narrow).max(wide)];
            let bracket = Bracket::new(told as f64, least as f64, most as f64);
            found.push((self.trapped(&chamber, clearance)?, bracket));
        }
        Ok(found)
    }

    /// The places where the void of so much clearance goes on from what fills a chamber to the outside.
    fn mouths_of(&self, own: &Indicator, clearance: &Field<u32>, exits: &Indicator, least: u32) -> Result<u64> {
        let wide = Indicator::from_predicate(self.grid, |at| clearance.values()[at] >= least);
        let beyond = wide.difference(own)?;
        let parts = components(&beyond, Adjacency::Corner);
        let mut out = vec![false; parts.count()];
        for at in exits.intersection(&beyond)?.iter() {
            parts.of(self.grid.index(at)).into_iter().for_each(|l| out[l as usize] = true);
        }
        let goes_on = parts.select(|l| out[l as usize]).intersection(&grown(own, 1))?;
        let reaches_out = own.intersection(exits)?.intersection(&wide)?;
        Ok(components(&goes_on.union(&reaches_out)?, Adjacency::Corner).count() as u64)
    }
}
