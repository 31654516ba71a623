//! What pictures need beyond the report: a display mesh with a value at every corner, and slices.

use super::stances::Stances;
use crate::check::Sense;
use crate::geometry::vector::Vec3;
use crate::grid::Grid;
use crate::medial::Side;

/// What of a part an exhibit is mounted of; the report is the same whatever it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exhibited {
    /// Nothing: the exhibit stays empty.
    Nothing,
    /// The part with its maps, layers and slices.
    Part,
    /// The same, and this many ways to stand it up, compared in full.
    Stances(usize),
}

/// The part for display: corners are not shared, three per facet, so that a map may differ across an edge.
///
/// Facets are split until none is longer than the resolution, so that a large triangle shows the variation inside it.
#[derive(Debug, Clone, Default)]
pub struct Exhibit {
    /// Three corners per facet, in the frame of the build (z up, plate at the lowest point), millimetres.
    pub corners: Vec<Vec3>,
    /// One map per check that has one.
    pub maps: Vec<SurfaceMap>,
    /// Slices through the worst finding, one per axis.
    pub slices: Vec<Slice>,
    /// How the display copy differs from the part; `None` where it has all facets, as it has unless the part is very large.
    pub coarsened: Option<Coarsened>,
    /// Further shapes that can be shown with the part: supports, trapped volumes, what no tool reaches, as printed.
    pub layers: Vec<Layer>,
    /// The part's density, coarse enough for a page: about 128 samples along the longest side.
    pub volume: Option<Volume>,
    /// Ways to stand the part up, where they were compared.
    pub stances: Option<Stances>,
}

/// What a display copy with fewer facets than the part leaves out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coarsened {
    pub facets_left_out: usize,
    /// No point of the copy lies farther from the part's surface, millimetres.
    pub within_mm: f64,
}

/// Solid fractions on a grid in the frame of the build.
#[derive(Debug, Clone)]
pub struct Volume {
    pub grid: Grid,
    /// 0 is empty, 255 solid; x fastest, then y, then z.
    pub density: Vec<u8>,
}

/// A shape that can be shown with the part.
#[derive(Debug, Clone)]
pub struct Layer {
    /// A short name, such as `supports`.
    pub name: String,
    /// What is shown, such as `Supports, 12 cm³`.
    pub title: String,
    /// Three corners per facet, in the frame of the build, millimetres.
    pub corners: Vec<Vec3>,
}

/// A scalar at every corner of the exhibit.
#[derive(Debug, Clone)]
pub struct SurfaceMap {
    /// Name of the check, such as `thin-wall`.
    pub check: String,
    /// What is shown, such as `Wall thickness`.
    pub title: String,
    /// `mm` or `deg`.
    pub unit: String,
    pub sense: Sense,
    pub fail: Option<f64>,
    pub warn: Option<f64>,
    /// Values beyond this end of the scale are only known to be beyond it.
    pub open_end: f64,
    /// What lies between the two sides that a value is the distance of; a section fills it with the map's colour.
    pub fills: Option<Side>,
    /// One value per corner; NaN where nothing is measured.
    pub values: Vec<f32>,
}

/// A picture of one plane through the part.
#[derive(Debug, Clone)]
pub struct Slice {
    /// 0, 1, 2 for planes across x, y, z.
    pub axis: usize,
    /// Position of the plane along its axis, millimetres.
    pub at_mm: f64,
    /// World position of the centre of the first pixel, along the two axes that remain, in increasing order.
    pub origin_mm: [f64; 2],
    pub spacing_mm: f64,
    pub width: usize,
    pub height: usize,
    /// Solid fraction of each pixel, rows along the first remaining axis.
    pub density: Vec<f32>,
    /// Findings that lie in or near the plane: number as in the report (from 1), and position in the plane.
    pub pins: Vec<(usize, [f64; 2])>,
}
