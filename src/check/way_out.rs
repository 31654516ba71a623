//! What is told of chambers whose way out is narrow.

use super::finding::{Finding, State};
use super::vent::Venting;
use crate::geometry::vector::Vec3;
use crate::part::Part;
use crate::units::{bulk, enough, hundredths, short};

/// What was tried for a chamber.
pub(super) struct Tried {
    /// Its place, as reported.
    pub at_mm: Vec3,
    pub venting: Venting,
    /// Whether its mouths are counted once its way out is wide enough.
    pub counts: bool,
}

/// What the words rest on.
pub(super) struct Telling<'a> {
    pub part: &'a Part,
    pub spacing_mm: f64,
    /// The widest limit of a way out, mm.
    pub widest: f64,
    /// What else is wanted of a chamber whose mouths are counted.
    pub more: String,
}

impl Telling<'_> {
    /// Gives a finding its message and what is advised, from what was tried for its places.
    pub fn describe(&self, f: &mut Finding, tried: &[Tried]) {
        let volume = bulk(f.volume_mm3.unwrap_or(0.0));
        let chambers = match f.count {
            1 => format!("a chamber of about {volume}"),
            n => format!("{n} chambers, about {volume} in all,"),
        };
        let [low, high] = [f.low, f.high].map(hundredths);
        f.message = match &f.witness {
            Some(_) => format!("{chambers} whose widest way out is {low} to {high} mm"),
            None => format!("{chambers} without a way out at this spacing"),
        };
        let own: Vec<&Tried> = tried.iter().filter(|t| f.places.iter().any(|place| place.at_mm == t.at_mm)).collect();
        f.fix = self.advice(f, &own);
    }

    /// What would tell whether a way out is wide enough: half the spacing, unless one drawn at its limit would stay undecided then; that is
    /// decided once it is wider by half its bracket.
    fn deciding(&self, f: &Finding) -> String {
        let (limit, half) = (f.fail.or(f.warn).unwrap_or(self.widest), 0.5 * (f.high - f.low));
        let finer = format!("look again with --voxel {}mm", short(0.5 * self.spacing_mm));
        if (f.value - limit).abs() > 0.5 * half {
            return finer;
        }
        let [limit, enough] = [short(limit), enough(limit + half)];
        format!(
            "samples do not tell it from {limit} mm; one of {enough} mm is told to be wide enough: widen it, {finer}"
        )
    }

    fn advice(&self, f: &Finding, own: &[&Tried]) -> String {
        let more = if own.iter().any(|t| t.counts) { self.more.as_str() } else { "" };
        let working = || own.iter().filter_map(|t| t.venting.vent());
        let Some(vent) = working().next() else {
            let partly = own.iter().find_map(|t| t.venting.partly(self.part));
            return partly.unwrap_or_else(|| format!("widen the way out to {} mm", short(self.widest)));
        };
        let vent = vent.words(self.part);
        match (f.state, f.count) {
            (State::Undecided, _) => format!("{}, or drill {vent}", self.deciding(f)),
            (_, 1) => format!("drill {vent}; measured again, it is then wide enough{more}"),
            (_, n) => {
                let works = working().count();
                format!("drill {vent}; {works} of {n} such vents were measured again and are wide enough{more}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Basis, Bracket, Limits, Sense};
    use crate::geometry::cuboid;
    use crate::part::Up;

    #[test]
    fn one_drawn_at_its_limit_is_told_how_wide_would_do() {
        let part = Part::new(cuboid([0.0; 3], [9.0; 3]), Up::PlusZ, 1e-6, 1.0).unwrap();
        let telling = Telling { part: &part, spacing_mm: 0.1, widest: 5.0, more: String::new() };
        let limits = Limits { fail: Some(5.0), warn: None, sense: Sense::Min };
        let open = |value: f64| {
            let bracket = Bracket::new(value, value - 0.3, value + 0.3);
            Finding::judged("AM301", "chamber", bracket, Basis::Certified, limits, "mm", 0.0)
        };
        assert_eq!(telling.deciding(&open(4.8)), "look again with --voxel 0.05mm");
        let told = telling.deciding(&open(4.9));
        assert!(told.starts_with("samples do not tell it from 5 mm; one of 5.3 mm is told"), "{told}");
    }
}
