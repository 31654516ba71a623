//! What is said of sheets: their places, what to change there, and how far the search went.

use super::finding::{Finding, Limits};
use super::room::{Fit, Growth, NO_ROOM, Thin};
use super::sheet::{Kind, Sheets, left_open};
use crate::geometry::vector::Vec3;
use crate::medial::{Cover, Question, Sample, Side};
use crate::units::{enough, short};

/// Whether there is room to grow to the limit that fails, and to the one that warns.
pub type Room = [Fit; 2];
/// Where findings lie, and what room there is.
pub type Rooms = Vec<([f64; 3], Room)>;

impl Sheets<'_> {
    /// Whether there is room to grow to the limit that fails and to the one that warns, which for a neck is the one that fails
    /// where no other is set: where a sheet is thinnest, given by its contacts and their distance, and at samples of it. All else that is
    /// thinner than that grows as well.
    pub(super) fn room<'s>(
        &self,
        (kind, thin): (&Kind, &Thin),
        (contacts, width): ([Vec3; 2], f64),
        samples: impl ExactSizeIterator<Item = &'s Sample> + Clone,
    ) -> Room {
        let fits = |to: f64| {
            let growth = self.growth(to).among(thin, to - self.part.tie());
            growth.fits_between(contacts, to - width).min(growth.fits(samples.clone(), to))
        };
        let Limits { fail, warn, .. } = kind.limits;
        [fail, warn.or(fail)].map(|limit| limit.map_or(Fit::Cramped, fits))
    }

    /// Growth to a width, with what it has to leave.
    fn growth(&self, to: f64) -> Growth<'_> {
        Growth::new(self.part, self.process, self.side).leaving(self.beside, to)
    }

    /// Completes message and fix once the count is known.
    pub(super) fn describe(&self, f: &mut Finding, rooms: &Rooms) {
        let value = short(f.value);
        let (noun, verb) = match (self.side, f.kind.as_str()) {
            (Side::Material, _) => ("wall", "thicken"),
            (Side::Void, "slot" | "closed") => ("slot", "widen"),
            (Side::Void, _) => ("clearance", "open"),
        };
        let place = std::mem::take(&mut f.message);
        let area = f.area_mm2.filter(|a| *a > 0.0).map_or(String::new(), |a| match (a * 10.0).round() / 10.0 {
            0.0 => ", less than 0.1 mm²".into(),
            tenths => format!(", {} mm²", short(tenths)),
        });
        f.message = match f.count {
            1 => format!("{noun} of {value} mm {place}{area}"),
            n if area.is_empty() => format!("{n} {noun}s of {value} mm, the first {place}"),
            n => format!("{n} {noun}s of {value} mm{area} in all, the first {place}"),
        };
        let to = |limit: f64| format!("{verb} by {} mm to {} mm", enough(limit - f.value), short(limit));
        let below = |limit: Option<f64>| limit.filter(|l| f.value < *l - self.part.tie());
        let own = |at: &[f64; 3]| f.places.iter().any(|p| p.at_mm == *at);
        let counts = |side: usize| Fit::counts(rooms.iter().filter(|(at, _)| own(at)).map(|(_, r)| r[side]));
        let tried = |hint, to, side| self.growth(to).tried(hint, verb, to, counts(side));
        f.fix = match (below(f.fail), below(f.warn)) {
            (Some(fail), Some(warn)) if warn > fail && counts(1)[1..] == [0; 2] => {
                tried(format!("{}; {} mm clears the warning too", to(fail), short(warn)), warn, 1)
            }
            (Some(limit), _) => tried(to(limit), limit, 0),
            (None, Some(limit)) => tried(to(limit), limit, 1),
            (None, None) => format!("{} mm is as much as the limit asks", value),
        };
        if f.kind == "gap-between-bodies" {
            let or = if f.fix.starts_with(NO_ROOM) { "; join" } else { ", or join" };
            f.fix.push_str(&format!("{or} the bodies if that is meant"));
        }
    }

    pub(super) fn cover_text(&self, q: &Question, cover: &Cover, wedges: usize) -> String {
        let noun = if self.side == Side::Material { "wall" } else { "gap" };
        let mut text = format!(
            "All {} features were searched: no other {noun} thinner than {} mm is wider than {} mm.",
            self.part.features(self.side).list.len(),
            short(self.widest()),
            short((q.finest * 1e3).ceil() / 1e3)
        );
        if !self.rods.is_empty() {
            let rods = match self.side {
                Side::Material => "rods are judged by their diameter",
                Side::Void => "round holes and dimples are no slots",
            };
            text.push_str(&format!(" {} {rods}.", self.rods.len()));
        }
        if wedges > 0 {
            text.push_str(&format!(" {wedges} samples lie in wedges, which are no {noun}s."));
        }
        let mut open = left_open(q, cover, self.widest()).map(|u| self.lies_on_a_rod(u)).peekable();
        if open.peek().is_some() {
            text.push_str(match open.all(|on_a_rod| on_a_rod) {
                true if self.side == Side::Material => " What the budget left open lies on rods.",
                true => " What the budget left open lies on round holes.",
                false => " The budget ended before all was decided.",
            });
        }
        text
    }
}
