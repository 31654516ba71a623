//! One enum for everything that can go wrong; every message names value, place and remedy.
//!
//! A finding about a part is a *result* and lives in [`crate::check`]; an [`Error`] is a *failure* to
//! answer. Each variant has a stable code (`E010`), an exit code and a remedy, so that the command line
//! prints any of them in the same few lines and `amcheck explain E010` has something to say.

use std::fmt;

/// Result of a fallible operation of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Where in an input the trouble sits.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Place {
    /// The whole input; nothing finer is known.
    #[default]
    Whole,
    /// Byte offset from the start of the file.
    Byte(u64),
    /// Line, counted from 1.
    Line(u64),
    /// Facet, counted from 1.
    Facet(u64),
    /// A member of an archive, with the line inside it when known.
    Member { name: String, line: Option<u64> },
    /// A named key or option.
    Key(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Whole => write!(f, "whole file"),
            Place::Byte(at) => write!(f, "byte {at}"),
            Place::Line(at) => write!(f, "line {at}"),
            Place::Facet(at) => write!(f, "facet {at}"),
            Place::Member { name, line: Some(line) } => write!(f, "{}, line {line}", printable(name)),
            Place::Member { name, line: None } => write!(f, "{}", printable(name)),
            Place::Key(key) => write!(f, "{}", printable(key)),
        }
    }
}

/// What is wrong with a tool, or with the directions it comes from.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ToolFault {
    /// No piece of it may touch the part.
    #[error("it has no cutter")]
    NoCutter,
    /// A piece that must not touch stands beside, or below, one that may.
    #[error("its {piece} begins {from_mm} mm above the tip, inside the cutter, which ends at {cutter_end_mm} mm")]
    HolderInsideCutter { piece: &'static str, from_mm: f64, cutter_end_mm: f64 },
    /// The cutter fits nowhere beside or inside the part.
    #[error("its cutter is {cutter_mm:.3} mm wide and the longest side of the part {part_mm:.3} mm")]
    LargerThanPart { cutter_mm: f64, part_mm: f64 },
    /// Its surface has a boundary.
    #[error("its mesh is open at {edges} {}", if *edges == 1 { "edge" } else { "edges" })]
    OpenMesh { edges: u64 },
    /// A point that is meant to touch lies inside the tool or beside it.
    #[error("its point `{name}` at ({}) mm lies {off_mm:.3} mm off its surface", at_mm.map(|x| x.to_string()).join(", "))]
    SharpOffSurface { name: String, at_mm: [f64; 3], off_mm: f64 },
    /// It is to come from nowhere.
    #[error("no direction is listed for it")]
    NoDirections,
    /// It is to touch nothing.
    #[error("none of the part's surface is among the faces named")]
    NoFaces,
}

impl ToolFault {
    /// What to try next, as one sentence.
    pub fn remedy(&self) -> &'static str {
        match self {
            ToolFault::NoCutter => "give one piece role = \"cutter\", or for a mesh name a [[sharp]] point",
            ToolFault::HolderInsideCutter { .. } => "list the pieces from the tip upwards: cutter, neck, holder",
            ToolFault::LargerThanPart { .. } => "choose a tool no wider than the part, or check the unit of its sizes",
            ToolFault::OpenMesh { .. } => "close the holes of the tool's mesh, or export a closed solid",
            ToolFault::SharpOffSurface { .. } => {
                "a mesh touches with its tip, at its file's origin, +z to the hand: move it there, or describe it in a TOML file with [[sharp]] points on its surface"
            }
            ToolFault::NoDirections => "list at least one direction, within the tilt that is allowed",
            ToolFault::NoFaces => {
                "name faces that are there: directions and boxes are those of the file, in millimetres"
            }
        }
    }
}

/// Everything that can keep amcheck from answering.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// An option or argument that makes no sense as given.
    #[error("{problem}")]
    Usage { problem: String, remedy: String },

    /// A name that is not in a closed list.
    #[error("unknown {what} `{given}`")]
    UnknownName { what: &'static str, given: String, nearest: Option<String>, known: Vec<String> },

    /// A process, tool or accept file that cannot be used.
    #[error("{file}: {problem}")]
    Profile { file: String, place: Place, problem: String, remedy: String },

    /// A tool that cannot be used as it is described, or on this part.
    #[error("tool {tool}: {fault}")]
    Tool { tool: String, fault: ToolFault },

    /// The operating system did not hand the input over.
    #[error("cannot read {path}: {reason}")]
    CannotRead { path: String, reason: String, remedy: String },

    /// The input is of a known format and breaks its rules.
    #[error("damaged {format}: {problem}")]
    Damaged { format: &'static str, place: Place, problem: String, remedy: String },

    /// The input is intact but asks for something that is not read here.
    #[error("{what} is not supported")]
    Unsupported { what: String, place: Place, remedy: String },

    /// The input holds no geometry that could be analysed.
    #[error("{problem}")]
    NoGeometry { problem: String, remedy: String },

    /// The surface is no solid: it encloses nothing, as beside too little of it winding numbers are those of one; or a shape is to be made of it, which takes a
    /// closed one whose facets agree.
    #[error("the surface is not a solid: {problem}")]
    NotSolid { problem: String, at_mm: Option<[f64; 3]>, remedy: String },

    /// The question needs more memory or more samples than it may have.
    #[error("{what} needs {}, allowed are {}", byte_count(*need_bytes), byte_count(*allowed_bytes))]
    TooLarge { what: String, need_bytes: u128, allowed_bytes: u128, remedy: String },

    /// A result could not be written; what was there before is untouched.
    #[error("cannot write {path}: {reason}")]
    CannotWrite { path: String, reason: String },

    /// A floating-point count is too uncertain to be rounded to an integer.
    #[error("precision lost: a count may be off by {bound:.3}, allowed is {allowed:.3}")]
    PrecisionLost { bound: f64, allowed: f64 },

    /// Operands of a field operation do not fit together.
    #[error("{operation}: {problem}")]
    Operand { operation: &'static str, problem: String, remedy: String },

    /// The user stopped the run.
    #[error("interrupted")]
    Interrupted,

    /// A broken promise of our own.
    #[error("internal error: {problem}")]
    Internal { problem: String },
}

impl Error {
    /// What a panic carries, as the broken promise it is.
    pub fn broken_down(panic: &(dyn std::any::Any + Send)) -> Self {
        let said = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        Error::Internal { problem: printable(said.unwrap_or("unknown")) }
    }

    /// The stable code of this kind of failure, as `amcheck explain` knows it.
    pub fn code(&self) -> &'static str {
        match self {
            Error::Usage { .. } => "E001",
            Error::UnknownName { .. } => "E002",
            Error::Profile { .. } => "E003",
            Error::Tool { .. } => "E004",
            Error::CannotRead { .. } => "E010",
            Error::Damaged { .. } => "E011",
            Error::Unsupported { .. } => "E012",
            Error::NoGeometry { .. } => "E013",
            Error::NotSolid { .. } => "E014",
            Error::TooLarge { .. } => "E020",
            Error::CannotWrite { .. } => "E030",
            Error::PrecisionLost { .. } => "E040",
            Error::Operand { .. } => "E041",
            Error::Interrupted => "E050",
            Error::Internal { .. } => "E070",
        }
    }

    /// The process exit code that belongs to this failure.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Usage { .. }
            | Error::UnknownName { .. }
            | Error::Profile { .. }
            | Error::Tool { .. }
            | Error::Operand { .. } => 2,
            Error::CannotRead { .. }
            | Error::Damaged { .. }
            | Error::Unsupported { .. }
            | Error::NoGeometry { .. }
            | Error::NotSolid { .. } => 4,
            Error::TooLarge { .. } => 5,
            Error::CannotWrite { .. } => 6,
            Error::PrecisionLost { .. } | Error::Internal { .. } => 70,
            Error::Interrupted => 130,
        }
    }

    /// Where in the input the trouble sits, as text; `None` where there is no finer place.
    pub fn place(&self) -> Option<String> {
        match self {
            Error::Damaged { place, .. } | Error::Unsupported { place, .. } | Error::Profile { place, .. } => {
                (*place != Place::Whole).then(|| place.to_string())
            }
            Error::NotSolid { at_mm: Some([x, y, z]), .. } => Some(format!("near {x:.3}, {y:.3}, {z:.3} mm")),
            _ => None,
        }
    }

    /// What to try next, as one sentence.
    pub fn remedy(&self) -> String {
        match self {
            Error::Usage { remedy, .. }
            | Error::Profile { remedy, .. }
            | Error::CannotRead { remedy, .. }
            | Error::Damaged { remedy, .. }
            | Error::Unsupported { remedy, .. }
            | Error::NoGeometry { remedy, .. }
            | Error::NotSolid { remedy, .. }
            | Error::TooLarge { remedy, .. }
            | Error::Operand { remedy, .. } => remedy.clone(),
            Error::Tool { fault, .. } => fault.remedy().into(),
            Error::UnknownName { nearest: Some(name), .. } => format!("did you mean `{name}`?"),
            Error::UnknownName { known, .. } => format!("known are: {}", known.join(", ")),
            Error::CannotWrite { .. } => "choose another place with --out, or free some space".into(),
            Error::PrecisionLost { .. } => "use the exact path, or smaller tiles".into(),
            Error::Interrupted => "run the same command again; nothing half-written was left".into(),
            Error::Internal { .. } => "please report this with the command and the part".into(),
        }
    }
}

/// Bytes for people: `179 kB`, `1.2 MB`.
///
/// ```
/// assert_eq!(amcheck::error::byte_count(28_249_833_216), "28.2 GB");
/// ```
pub fn byte_count(n: u128) -> String {
    match n {
        0..1000 => format!("{n} B"),
        1000..1_000_000 => format!("{} kB", (n as f64 / 1e3).round()),
        1_000_000..1_000_000_000 => format!("{:.1} MB", n as f64 / 1e6),
        _ => format!("{:.1} GB", n as f64 / 1e9),
    }
}

/// Text from a file or a user with control characters escaped, cut to 120 characters.
///
/// ```
/// assert_eq!(amcheck::error::printable("a\u{1b}[2Jb"), "a\\u{1b}[2Jb");
/// ```
pub fn printable(text: &str) -> String {
    let mut out = escaped(&text.chars().take(120).collect::<String>());
    if text.chars().nth(120).is_some() {
        out.push('…');
    }
    out
}

/// Text with control characters escaped, at its full length: what a parser says quotes what it read.
///
/// ```
/// assert_eq!(amcheck::error::escaped("unknown `a\u{1b}[2J`"), "unknown `a\\u{1b}[2J`");
/// ```
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() { out.extend(c.escape_default()) } else { out.push(c) }
    }
    out
}

/// The entry of `known` that is nearest to `given` by edit distance, if it is near enough to be a typing slip.
///
/// ```
/// assert_eq!(amcheck::error::nearest("thinwall", ["thin-wall", "overhang"]), Some("thin-wall".to_string()));
/// assert_eq!(amcheck::error::nearest("zzz", ["thin-wall"]), None);
/// ```
pub fn nearest<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let given_lower = given.to_lowercase();
    known
        .into_iter()
        .map(|k| (edit_distance(&given_lower, &k.to_lowercase()), k))
        .filter(|(d, k)| *d <= 1 + k.len() / 3)
        .min()
        .map(|(_, k)| k.to_string())
}

/// Levenshtein distance between two words.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let change = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_one_exit_code_of_the_published_table() {
        let e = Error::Damaged {
            format: "STL",
            place: Place::Line(89),
            problem: "bad number".into(),
            remedy: "re-export".into(),
        };
        assert_eq!((e.code(), e.exit_code(), e.place().as_deref()), ("E011", 4, Some("line 89")));
    }

    #[test]
    fn edit_distance_counts_slips() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
    }
}
