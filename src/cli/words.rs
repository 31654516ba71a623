//! Words of the command line that several commands know: units, directions, spacings, counts.

use crate::error::{Error, Result, byte_count, nearest, printable};
use crate::io::machine;
use crate::memory::Allowance;
use crate::part::Up;
use crate::process::direction;
use crate::units::Length;

/// Memory that is allowed unless said.
pub const MEMORY: &str = "4GiB";

/// What the user's words and the machine allow.
pub fn allowance(memory: &str) -> Result<Allowance> {
    Ok(Allowance { bytes: bytes(memory)?, ceiling: machine::ceiling() })
}

/// A direction of the file; `None` for `best`.
pub fn up(text: &str) -> Result<Option<Up>> {
    if text == "best" {
        return Ok(None);
    }
    let axes = [
        ([0.0, 0.0, 1.0], Up::PlusZ),
        ([0.0, 0.0, -1.0], Up::MinusZ),
        ([1.0, 0.0, 0.0], Up::PlusX),
        ([-1.0, 0.0, 0.0], Up::MinusX),
        ([0.0, 1.0, 0.0], Up::PlusY),
        ([0.0, -1.0, 0.0], Up::MinusY),
    ];
    let up = |d: [f64; 3]| axes.iter().find(|(axis, _)| *axis == d).map_or(Up::Along(d), |(_, up)| *up);
    direction(text).map(up).map(Some).ok_or_else(|| {
        usage(
            &format!("`{}` is no direction", printable(text)),
            "use one of +z -z +x -x +y -y, three numbers such as 1,0,1, or best",
        )
    })
}

/// A unit's name and its millimetres.
pub fn units(text: &str) -> Result<(String, f64)> {
    let known = [("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("in", 25.4), ("um", 0.001)];
    known.iter().find(|(n, _)| *n == text).map(|(n, mm)| (n.to_string(), *mm)).ok_or_else(|| Error::UnknownName {
        what: "unit",
        given: printable(text),
        nearest: nearest(text, known.iter().map(|k| k.0)),
        known: known.iter().map(|k| k.0.to_string()).collect(),
    })
}

/// The length that an option takes, in a range that a grid can be made of.
pub fn length(option: &str, text: &str) -> Result<Length> {
    let length = Length::parse(text)?;
    if (1e-6..=1e6).contains(&length.as_mm()) {
        Ok(length)
    } else {
        let problem = format!("{option} {} is out of range", printable(text));
        Err(usage(&problem, "give a length from 0.000001mm to 1000000mm"))
    }
}

/// An option that takes a count.
pub struct Counted {
    option: &'static str,
    /// What is counted.
    of: &'static str,
    /// What may stand behind the number, and how many that is.
    suffixes: &'static [(&'static str, u128)],
    such_as: &'static str,
}

/// Samples for finer looks.
pub const LOOKS: Counted = Counted {
    option: "--refine",
    of: "samples",
    suffixes: &[("k", 1_000), ("M", 1_000_000), ("G", 1_000_000_000)],
    such_as: "64M",
};

/// Memory that is allowed.
const BYTES: Counted = Counted {
    option: "--memory",
    of: "bytes",
    suffixes: &[
        ("KiB", 1 << 10),
        ("MiB", 1 << 20),
        ("GiB", 1 << 30),
        ("kB", 1_000),
        ("MB", 1_000_000),
        ("GB", 1_000_000_000),
    ],
    such_as: MEMORY,
};

/// No file is read and nothing made with less memory.
const LEAST_BYTES: u128 = 1_000_000;

impl Counted {
    /// The number that a text says.
    ///
    /// # Errors
    /// [`Error::Usage`] with option and text, for what is no positive number or has another suffix.
    pub fn parse(&self, text: &str) -> Result<u128> {
        let text = text.trim();
        let digits = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
        let factor = match text[digits..].trim() {
            "" => Some(1),
            suffix => self.suffixes.iter().find(|(s, _)| s.eq_ignore_ascii_case(suffix)).map(|(_, f)| *f),
        };
        match (text[..digits].parse::<f64>(), factor) {
            (Ok(n), Some(f)) if n > 0.0 && n < 1e15 => Ok((n * f as f64) as u128),
            _ => Err(self.refused(text, &format!("is no number of {}", self.of))),
        }
    }

    fn refused(&self, text: &str, why: &str) -> Error {
        let names: Vec<&str> = self.suffixes.iter().map(|s| s.0).collect();
        let remedy = format!(
            "write a positive number with one of {} behind it, such as {} {}",
            names.join(", "),
            self.option,
            self.such_as
        );
        usage(&format!("{} `{}` {why}", self.option, printable(text)), &remedy)
    }
}

/// A number of bytes that something can be done with, such as 4GiB.
fn bytes(text: &str) -> Result<u128> {
    match BYTES.parse(text)? {
        few @ ..LEAST_BYTES => Err(BYTES.refused(text, &format!("is {}, too little for any part", byte_count(few)))),
        enough => Ok(enough),
    }
}

/// Each given word as it stands in a closed list.
pub fn one_of<'k>(what: &'static str, given: &[String], known: &[&'k str]) -> Result<Vec<&'k str>> {
    given
        .iter()
        .map(|g| {
            known.iter().find(|k| *k == g).copied().ok_or_else(|| Error::UnknownName {
                what,
                given: printable(g),
                nearest: nearest(g, known.iter().copied()),
                known: known.iter().map(|k| k.to_string()).collect(),
            })
        })
        .collect()
}

/// The error of an option that makes no sense as given.
pub fn usage(problem: &str, remedy: &str) -> Error {
    Error::Usage { problem: problem.into(), remedy: remedy.into() }
}
