//! The rules a process can limit, each with its dimension and its sense.

use crate::error::{Error, Result, nearest};
use crate::units::{Angle, Length, short, split_unit};

/// What a limit is a number of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// Millimetres.
    Length,
    /// Degrees.
    Angle,
    /// Square millimetres.
    Area,
    /// Cubic millimetres.
    Volume,
    /// A pure number: a ratio or a count.
    Number,
    /// A part of a whole, at most 1.
    Share,
}

impl Dimension {
    /// The unit's name in files.
    pub fn unit(self) -> &'static str {
        match self {
            Dimension::Length => "mm",
            Dimension::Angle => "deg",
            Dimension::Area => "mm2",
            Dimension::Volume => "mm3",
            Dimension::Number | Dimension::Share => "1",
        }
    }

    /// A number in that unit from text with a unit.
    ///
    /// # Errors
    /// [`Error::Usage`] for text that is no such quantity, is negative, an angle above 90° or a share above 1.
    pub fn parse(self, text: &str) -> Result<f64> {
        let value = match self {
            Dimension::Length => Length::parse(text)?.as_mm(),
            Dimension::Angle => {
                let degrees = Angle::parse(text)?.as_degrees();
                // 45deg must come back as 45 exactly.
                if (degrees - degrees.round()).abs() < 1e-9 { degrees.round() } else { degrees }
            }
            Dimension::Area => match split_unit(text)? {
                (value, "" | "mm2" | "mm²") => value,
                _ => return Err(out_of_range(text, "an area such as 2mm2")),
            },
            Dimension::Volume => match split_unit(text)? {
                (value, "" | "mm3" | "mm³") => value,
                (value, "cm3" | "cm³" | "ml") => 1e3 * value,
                _ => return Err(out_of_range(text, "a volume such as 2mm3")),
            },
            Dimension::Number | Dimension::Share => match split_unit(text)? {
                (value, "" | "1") => value,
                (value, "%") => 0.01 * value,
                _ => return Err(out_of_range(text, "a number without a unit")),
            },
        };
        let most = match self {
            Dimension::Angle => 90.0,
            Dimension::Share => 1.0,
            _ => 1e6,
        };
        if (0.0..=most).contains(&value) {
            Ok(value)
        } else {
            Err(out_of_range(text, &format!("a value from 0 to {} {}", short(most), self.unit())))
        }
    }
}

fn out_of_range(text: &str, expected: &str) -> Error {
    Error::Usage {
        problem: format!("limit `{}` is out of range", crate::error::printable(text)),
        remedy: format!("give {expected}"),
    }
}

/// Which side of a rule's limit is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// At least the limit.
    Least,
    /// At most the limit.
    Most,
}

impl Bound {
    /// Whether a limit asks for more than another one.
    pub fn is_stricter(self, limit: f64, than: f64) -> bool {
        match self {
            Bound::Least => limit > than,
            Bound::Most => limit < than,
        }
    }
}

/// A rule that a process may limit.
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    /// The key in a process file: the name of a check, or `check.kind`.
    pub key: &'static str,
    pub dimension: Dimension,
    pub bound: Bound,
}

/// Kinds that measure something else than their check: a limit of the check is not one of theirs.
const APART: &[&str] = &["bridge.ledge", "bridge.horizontal-hole", "tall-feature.topple"];

impl Rule {
    /// Whether a limit given for `key` is also one of this rule: its own key, or a kind of that check.
    pub fn follows(&self, key: &str) -> bool {
        let kind = self.key.strip_prefix(key).is_some_and(|k| k.starts_with('.'));
        self.key == key || (kind && !APART.contains(&self.key))
    }
}

/// Every rule that a check of the registry reads.
pub const RULES: &[Rule] = &[
    Rule { key: "thin-wall", dimension: Dimension::Length, bound: Bound::Least },
    Rule { key: "thin-pin", dimension: Dimension::Length, bound: Bound::Least },
    Rule { key: "thin-pin.slenderness", dimension: Dimension::Number, bound: Bound::Most },
    Rule { key: "narrow-gap", dimension: Dimension::Length, bound: Bound::Least },
    Rule { key: "narrow-gap.between-bodies", dimension: Dimension::Length, bound: Bound::Least },
    Rule { key: "small-hole", dimension: Dimension::Length, bound: Bound::Least },
    Rule { key: "knife-edge", dimension: Dimension::Angle, bound: Bound::Least },
    Rule { key: "overhang", dimension: Dimension::Angle, bound: Bound::Least },
    Rule { key: "island", dimension: Dimension::Area, bound: Bound::Most },
    Rule { key: "trapped-volume", dimension: Dimension::Length, bound: Bound::Least },
    Rule { key: "trapped-volume.mouths", dimension: Dimension::Number, bound: Bound::Least },
    Rule { key: "trapped-volume.on-plate", dimension: Dimension::Volume, bound: Bound::Most },
    Rule { key: "trapped-volume.sealed", dimension: Dimension::Volume, bound: Bound::Most },
    Rule { key: "drain", dimension: Dimension::Volume, bound: Bound::Most },
    Rule { key: "drain.suction", dimension: Dimension::Area, bound: Bound::Most },
    Rule { key: "topology", dimension: Dimension::Number, bound: Bound::Most },
    Rule { key: "offset", dimension: Dimension::Length, bound: Bound::Least },
    Rule { key: "lost-feature", dimension: Dimension::Volume, bound: Bound::Most },
    Rule { key: "lost-feature.embossed", dimension: Dimension::Length, bound: Bound::Least },
    Rule { key: "lost-feature.engraved", dimension: Dimension::Length, bound: Bound::Least },
    Rule { key: "as-printed", dimension: Dimension::Volume, bound: Bound::Most },
    Rule { key: "as-printed.filled", dimension: Dimension::Volume, bound: Bound::Most },
    Rule { key: "blend", dimension: Dimension::Length, bound: Bound::Least },
    Rule { key: "support-access", dimension: Dimension::Volume, bound: Bound::Most },
    Rule { key: "tool-access", dimension: Dimension::Area, bound: Bound::Most },
    Rule { key: "bridge", dimension: Dimension::Length, bound: Bound::Most },
    Rule { key: "bridge.ledge", dimension: Dimension::Length, bound: Bound::Most },
    Rule { key: "bridge.horizontal-hole", dimension: Dimension::Length, bound: Bound::Most },
    Rule { key: "support", dimension: Dimension::Number, bound: Bound::Most },
    Rule { key: "tall-feature", dimension: Dimension::Number, bound: Bound::Most },
    Rule { key: "tall-feature.topple", dimension: Dimension::Length, bound: Bound::Least },
    Rule { key: "bed-contact", dimension: Dimension::Share, bound: Bound::Least },
];

/// The rule of a key.
///
/// # Errors
/// [`Error::UnknownName`] with the nearest key.
pub fn rule(key: &str) -> Result<&'static Rule> {
    RULES.iter().find(|r| r.key == key).ok_or_else(|| Error::UnknownName {
        what: "limit",
        given: crate::error::printable(key),
        nearest: nearest(key, RULES.iter().map(|r| r.key)),
        known: RULES.iter().map(|r| r.key.to_string()).collect(),
    })
}
