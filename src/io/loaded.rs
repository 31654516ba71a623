//! What every reader returns.

use crate::geometry::TriangleMesh;
use crate::notice::Notice;

/// What a reader hands over: a mesh in the unit of the file, and what the reader noticed.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// Coordinates in millimetres if `unit_mm` is 1 or unknown, otherwise still in file units.
    pub mesh: TriangleMesh,
    /// The format as a word, `STL (binary)`.
    pub format: &'static str,
    /// Millimetres per file unit, where the file says so.
    pub unit_mm: Option<f64>,
    /// What has to be repeated in the report.
    pub notices: Vec<Notice>,
    /// The coordinate step of the file's number format relative to the largest coordinate (2⁻²⁴ for binary STL).
    pub relative_step: f64,
}
