//! What a check is and what it returns.

use super::budget::Budget;
use super::finding::{Bracket, Finding, Limits, Sense};
use crate::error::Result;
use crate::field::Field;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;
use crate::medial::cover::FacetSheet;
use crate::part::Part;
use crate::process::{Bound, Limit, Process, rule};

/// The text of a check: this is what `amcheck explain` prints and the page shows.
#[derive(Debug, Clone, Copy)]
pub struct Meta {
    /// `AM101`.
    pub code: &'static str,
    /// `thin-wall`.
    pub name: &'static str,
    /// What is measured, one line.
    pub title: &'static str,
    pub what: &'static str,
    pub why: &'static str,
    pub how: &'static str,
    /// What it may miss.
    pub limits: &'static str,
    pub source: &'static str,
}

/// What a run may spend.
#[derive(Debug, Clone, Copy)]
pub struct Context {
    /// Budget for deciding what is open, in samples; the same input gives the same answer on any machine.
    pub refine: u64,
    /// Spacing of the grid, millimetres.
    pub spacing_mm: f64,
}

/// The worst value a check met.
#[derive(Debug, Clone, PartialEq)]
pub struct Worst {
    pub bracket: Bracket,
    pub unit: &'static str,
    /// In the frame of the build.
    pub at: Option<Vec3>,
}

/// What a surface map shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapKind {
    /// Thickness of the material.
    Wall,
    /// Width of the void.
    Gap,
    /// Angle of downward surface from the horizontal.
    Slope,
    /// The field of the map, read at the surface.
    Sampled,
    /// How far the inward normal goes to the next surface.
    Ray,
}

/// A surface map a check wants beside its findings.
#[derive(Debug, Clone, PartialEq)]
pub struct MapWanted {
    pub kind: MapKind,
    pub title: &'static str,
    pub unit: &'static str,
    pub limits: Limits,
    /// Values beyond this end are only known to be beyond it.
    pub open_end: f64,
    /// What the check already knows of each facet of the mesh; empty for maps that need no search.
    pub facets: Vec<FacetSheet>,
    /// What a [`MapKind::Sampled`] map reads, in the frame of the build; NaN where nothing is measured.
    pub field: Option<Field<f32>>,
}

/// A shape worth showing beside the part: supports, a trapped volume, the part as printed.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeShown {
    /// A short name, such as `supports`.
    pub name: &'static str,
    /// What is shown, such as `Supports, 12 cm³`.
    pub title: String,
    /// Its surface in the frame of the build.
    pub mesh: TriangleMesh,
}

/// A check that ran.
#[derive(Debug, Clone, Default)]
pub struct Measured {
    pub worst: Option<Worst>,
    /// Findings, places in the frame of the file; passes need none.
    pub findings: Vec<Finding>,
    /// What was searched and how sure a pass is, one sentence.
    pub cover: String,
    /// The rule whose limit stands beside the worst value.
    pub rule: Option<&'static str>,
    pub map: Option<MapWanted>,
    /// Shapes to be shown with the part.
    pub shapes: Vec<ShapeShown>,
    /// What finer looks at open places took, where there were any to decide.
    pub budget: Option<Budget>,
    /// What the report has to repeat.
    pub notices: Vec<crate::notice::Notice>,
}

/// What a check says.
#[derive(Debug, Clone)]
pub enum Outcome {
    Measured(Box<Measured>),
    /// The check makes no sense here; the reason.
    NotApplicable(String),
}

/// One check. Stateless; safe to run beside others.
pub trait Check: Sync {
    /// Code, name and explanation.
    fn meta(&self) -> &'static Meta;

    /// Judges a part by a process.
    ///
    /// # Errors
    /// What kept it from an answer; the report says so, and it is never a pass.
    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome>;
}

/// The limits of a rule as the court applies them, or `None` if the process does not limit it.
pub fn limits_of(process: &Process, key: &str) -> Option<Limits> {
    let Limit { fail, warn, .. } = process.limit(key)?;
    let sense =
        rule(key).map(|r| r.bound).ok().map_or(Sense::Min, |b| if b == Bound::Most { Sense::Max } else { Sense::Min });
    (fail.is_some() || warn.is_some()).then_some(Limits { fail, warn, sense })
}

/// The thinnest wall that the process prints, mm, where it has a limit for it.
pub fn least_wall(process: &Process) -> Option<f64> {
    limits_of(process, "thin-wall").and_then(|l| l.fail.or(l.warn))
}
