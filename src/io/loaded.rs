//! What every reader returns.

use crate::geometry::TriangleMesh;
use crate::notice::Notice;
use crate::units::unit_name;

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

impl Loaded {
    /// That the file says how long its unit is, where somebody says otherwise.
    pub fn overruled_by(&self, given_mm: Option<f64>) -> Option<Notice> {
        let (of_file, given) = self.unit_mm.zip(given_mm).filter(|(file, given)| file != given)?;
        let (format, of_file, given) = (self.format, unit_name(of_file), unit_name(given));
        Some(Notice::new(
            "units-overruled",
            format!("{format} says that its unit is {of_file}; it was read as {given}"),
        ))
    }
}
