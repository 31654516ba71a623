//! What of a mesh's health has to be said in the report.

use super::boxes::middle;
use super::{Fault, Health, Role};
use crate::geometry::vector::sub;
use crate::notice::{Notice, number_of};
use crate::units::{Length, report_digits, short};

impl Health {
    /// Everything worth saying, with stable codes, in a fixed order: `open-edges`, `non-manifold`, `miswound`,
    /// `duplicate-facets`, `zero-area`, `inverted`, `inner-shells`, `swallowed-shells`, `ghost-shell`.
    pub fn notices(&self) -> Vec<Notice> {
        let mut out = Vec::new();
        let mut say = |code: &str, fault: Fault, message: String| {
            if fault.count > 0 {
                let notice = Notice::new(code, message).counted(fault.count);
                out.push(fault.at_mm.into_iter().fold(notice, Notice::at));
            }
        };
        say("open-edges", self.open_edges, self.open_message());
        let n = self.non_manifold_edges;
        say(
            "non-manifold",
            n,
            number_of(n.count, ["edge has more than two facets", "edges have more than two facets"]),
        );
        let n = self.miswound_edges;
        say(
            "miswound",
            n,
            number_of(
                n.count,
                ["edge has facets wound against each other", "edges have facets wound against each other"],
            ),
        );
        let n = self.duplicate_facets;
        say(
            "duplicate-facets",
            n,
            format!(
                "{}, {} mm² in all",
                number_of(n.count, ["facet repeats another", "facets repeat another"]),
                short(report_digits(self.duplicate_mm2))
            ),
        );
        let n = self.zero_area_facets;
        say(
            "zero-area",
            n,
            number_of(n.count, ["facet has no area and was passed over", "facets have no area and were passed over"]),
        );
        if self.inverted {
            let all = Fault { count: self.shells.len() as u64, at_mm: None };
            say("inverted", all, "the whole mesh is wound inside out and was read as solid".into());
        }
        let n = self.fault_of(Role::Inverted);
        say(
            "inverted",
            n,
            number_of(n.count, ["shell wound inside out, read as solid", "shells wound inside out, read as solid"]),
        );
        let n = self.fault_of(Role::Cavity);
        say("inner-shells", n, self.inner_message(n.count));
        let n = self.fault_of(Role::Swallowed);
        say(
            "swallowed-shells",
            n,
            number_of(
                n.count,
                ["solid shell within the material of another", "solid shells within the material of another"],
            ),
        );
        let n = self.fault_of(Role::Ghost);
        say(
            "ghost-shell",
            n,
            number_of(n.count, ["closed shell without volume passed over", "closed shells without volume passed over"]),
        );
        out
    }

    /// A guess at the unit where the longest side is under 2 mm or over 1000 mm, for a file that was read in millimetres.
    ///
    /// It only warns: nothing is ever rescaled unasked. 98 % of engineered parts are 10 to 201 mm long.
    pub fn units_guess(&self) -> Option<Notice> {
        let [lo, hi] = self.box_mm?;
        let longest = sub(hi, lo).into_iter().fold(0.0, f64::max);
        if longest <= 0.0 || (2.0..=1000.0).contains(&longest) {
            return None;
        }
        let units = [("inch", 25.4), ("cm", 10.0), ("m", 1000.0), ("um", 0.001)];
        // The usual length that is nearest by factor to the middle of that range.
        let likely = units
            .iter()
            .filter(|(_, mm)| (10.0..=250.0).contains(&(longest * mm)))
            .min_by(|a, b| (longest * a.1 / 50.0).ln().abs().total_cmp(&(longest * b.1 / 50.0).ln().abs()));
        let guess = match likely {
            Some((unit, _)) => format!("if the file is in {unit}, say --units {}", unit.replace("inch", "in")),
            None => "check the scale of the export".into(),
        };
        let size = |mm: f64| short(longest * mm);
        Some(Notice::new(
            "units-guess",
            format!(
                "the longest side is {} mm; read as inch it is {} mm, as m {} mm: {guess}",
                precise(longest),
                size(25.4),
                size(1000.0)
            ),
        ))
    }

    fn open_message(&self) -> String {
        let count = number_of(self.open_edges.count, ["open edge", "open edges"]);
        match self.largest_hole {
            Some(hole) if self.holes == 1 => {
                format!("{count} around one hole with a rim of {}", Length::mm(hole.length_mm))
            }
            Some(hole) => format!(
                "{count} around {} holes, the largest with {} and a rim of {}",
                self.holes,
                number_of(hole.edges, ["edge", "edges"]),
                Length::mm(hole.length_mm)
            ),
            None => count,
        }
    }

    fn inner_message(&self, count: u64) -> String {
        let volumes = || self.shells.iter().filter(|s| s.role == Role::Cavity).map(|s| s.volume_mm3.abs());
        let (least, most) = (volumes().fold(f64::INFINITY, f64::min), volumes().fold(0.0, f64::max));
        let range = if count == 1 {
            format!("{} mm³", short(most))
        } else {
            format!("{} to {} mm³", short(least), short(most))
        };
        format!("{} inside the material, {range}", number_of(count, ["closed void", "closed voids"]))
    }

    /// How many shells have a role, and the middle of the box of the largest.
    fn fault_of(&self, role: Role) -> Fault {
        let own = || self.shells.iter().filter(|s| s.role == role);
        let largest = own().reduce(|a, b| if b.volume_mm3.abs() > a.volume_mm3.abs() { b } else { a });
        let middle = largest.map(|s| middle(s.box_mm));
        Fault { count: own().count() as u64, at_mm: middle }
    }
}

/// Three digits of a length that may be far below a millimetre.
fn precise(mm: f64) -> String {
    if mm < 0.01 { format!("{mm:.2e}") } else { short(mm) }
}
