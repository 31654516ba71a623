//! What can be wrong with a line of G-code.

use crate::error::{Error, Place};

/// A line that cannot be.
pub(super) fn damaged(line: u64, problem: String) -> Error {
    Error::Damaged { format: "G-code", place: Place::Line(line), problem, remedy: "write the G-code again".into() }
}

/// A line that is not read here.
pub(super) fn unsupported(line: u64, what: &str) -> Error {
    Error::Unsupported {
        what: format!("{what} in G-code"),
        place: Place::Line(line),
        remedy: "let the slicer write straight moves and arcs in the xy plane".into(),
    }
}
