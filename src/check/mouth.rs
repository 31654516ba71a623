//! Chambers with fewer mouths than a process needs to empty them.

use super::contract::Context;
use super::finding::{Basis, Bracket, Finding, Limits, State};
use super::place::{group_equal, locate, reported};
use super::vent::{Vent, Wanted, drilled, vents};
use super::void::{Trapped, Voids};
use crate::error::Result;
use crate::field::Field;
use crate::geometry::Solid;
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
        let found: Vec<Option<Vent>> =
            vents(self.voids.solid, &places, self.wanted)?.into_iter().map(|v| v.vent()).collect();
        let enough = self.counted_again(&found, &places)?;
        let part = self.voids.part();
        let tried: Vec<([f64; 3], Option<Vent>)> =
            places.iter().zip(found).zip(enough).map(|((t, v), ok)| (reported(part, t.at), v.filter(|_| ok))).collect();
        let located = |(t, count): &(Trapped, u64)| {
            let mut f = self.judged(*count);
            locate(&mut f, part, self.context, t.at, t.extent);
            f.volume_mm3 = Some(report_digits(t.volume_mm3.value));
            f
        };
        let mut findings = group_equal(rooms.iter().map(located).collect(), 0.0);
        findings.iter_mut().for_each(|f| self.describe(f, &tried));
        Ok((findings, rooms.into_iter().map(|(t, _)| t).collect()))
    }

    fn judged(&self, count: u64) -> Finding {
        let bracket = Bracket::exact(count as f64);
        Finding::judged("AM301", "mouths", bracket, Basis::Estimated, self.limits, "1", 0.0)
    }

    fn needed(&self) -> f64 {
        self.limits.warn.or(self.limits.fail).unwrap_or(2.0)
    }

    /// Whether each place has as many mouths as are needed once all vents are drilled.
    fn counted_again(&self, found: &[Option<Vent>], places: &[&Trapped]) -> Result<Vec<bool>> {
        let all: Vec<Vent> = found.iter().flatten().copied().collect();
        if all.is_empty() {
            return Ok(vec![false; places.len()]);
        }
        let Solid { inner, centres, outer, density, doubt } = self.voids.solid;
        let [inner, centres, outer] = [inner, centres, outer].map(|set| drilled(set, &all));
        let open = Solid { inner, centres, outer, density: density.clone(), doubt: *doubt };
        let after = Voids::within(self.voids.part(), &open)?;
        let clearance = after.clearance()?;
        let rooms = after.mouths(&clearance, self.room_mm, self.wanted.ball_mm)?;
        // What is wide open after drilling is no chamber any more.
        let is_enough = |t: &&Trapped| rooms.iter().all(|(r, count)| !r.overlaps(t) || *count as f64 >= self.needed());
        Ok(places.iter().map(is_enough).collect())
    }

    fn describe(&self, f: &mut Finding, tried: &[([f64; 3], Option<Vent>)]) {
        let ball = short(self.wanted.ball_mm);
        let mouths = format!("{} mouth{} of at least {ball} mm", f.value, if f.value == 1.0 { "" } else { "s" });
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
