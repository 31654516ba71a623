//! What is told of chambers whose way out is narrow.

use super::finding::{Finding, State};
use super::vent::Venting;
use crate::geometry::vector::Vec3;
use crate::part::Part;
use crate::units::{bulk, hundredths, short};

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

    fn advice(&self, f: &Finding, own: &[&Tried]) -> String {
        let more = if own.iter().any(|t| t.counts) { self.more.as_str() } else { "" };
        let working = || own.iter().filter_map(|t| t.venting.vent());
        let Some(vent) = working().next() else {
            let partly = own.iter().find_map(|t| t.venting.partly(self.part));
            return partly.unwrap_or_else(|| format!("widen the way out to {} mm", short(self.widest)));
        };
        let vent = vent.words(self.part);
        match (f.state, f.count) {
            (State::Undecided, _) => {
                format!("look again with --voxel {}mm, or drill {vent}", short(0.5 * self.spacing_mm))
            }
            (_, 1) => format!("drill {vent}; measured again, it is then wide enough{more}"),
            (_, n) => {
                let works = working().count();
                format!("drill {vent}; {works} of {n} such vents were measured again and are wide enough{more}")
            }
        }
    }
}
