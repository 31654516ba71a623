//! amcheck: can this part be printed, where not, how sure is that, and what should change.
//!
//! # Conventions
//!
//! * Lengths are millimetres; angles are degrees at the edges and radians inside. f64 in geometry, f32 in fields.
//! * Right-handed x, y, z; the build direction is +z once the part is posed. The plate is at its lowest point.
//! * A [`grid::Grid`] has the world position of the *centre* of sample `[0,0,0]`, one cubic spacing, and counts.
//!   Arrays have shape `(nz, ny, nx)`: x fastest, a layer is a contiguous plane.
//! * Defining functions are positive inside; a signed distance is **negative inside**. Every field has a background,
//!   its value everywhere outside its grid. Touching is not collision.
//! * *Convolve* and *correlate* are different words: erosion correlates.
//! * Overhang angles are measured from the horizontal: 0° is a flat ceiling, 90° a vertical wall.
//! * Comparison with a limit is strict on the bracket; equal to the limit passes.
//! * Same input, same bytes, for any number of threads.
//!
//! # First uses
//!
//! Shapes and their algebra, without the report (`default-features = false`): a coat of 0.2 mm on a cube, with bounds that hold its volume.
//!
//! ```
//! use amcheck::{geometry::cuboid, operate, units::Length};
//! let coated = operate::offset(&cuboid([0.0; 3], [10.0; 3]), Length::mm(0.2), Length::mm(0.1))?;
//! // Steiner's formula: V + A·r + (edges · angle / 2)·r² + (4π/3)·r³.
//! let truth = 1000.0 + 600.0 * 0.2 + 30.0 * std::f64::consts::PI * 0.04 + 4.0 / 3.0 * std::f64::consts::PI * 0.008;
//! let [low, high] = coated.bracket.map(|v| v.as_mm3());
//! assert!(low <= truth && truth <= high);
//! # Ok::<(), amcheck::Error>(())
//! ```
//!
//! A part against a process, as the command judges it:
//!
//! ```
//! # #[cfg(feature = "report")] {
//! use amcheck::analyze::{Options, prepare, run};
//! use amcheck::io::{Salvage, read};
//! use amcheck::process::Process;
//! let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/parts/wall_080.stl");
//! let bytes = std::fs::read(&file).expect("a part");
//! let mut options = Options::new(Process::named("fdm")?);
//! options.only = vec!["thin-wall".into()];
//! let prepared = prepare("wall_080.stl", &bytes, read("wall_080.stl", &bytes, Salvage::Refuse)?, &options)?;
//! let report = run(prepared, &options)?.report;
//! let wall = report.checks.iter().find(|c| c.name == "thin-wall").and_then(|c| c.worst.as_ref());
//! assert!(wall.is_some_and(|w| w.low <= 0.8 && 0.8 <= w.high));
//! # }
//! # Ok::<(), amcheck::Error>(())
//! ```
//!
//! # Layers
//!
//! A module uses only modules of a lower layer or of its own folder; a test reads the `use` lines and says so:
//! error and notice, units, grid, field, {geometry, distance, convolution}, {io, morphology, medial, topology,
//! layer, process}, access, part, check, report, {analyze, batch}, cli.

pub mod access;
#[cfg(feature = "report")]
pub mod analyze;
#[cfg(feature = "report")]
pub mod batch;
pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
pub mod convolution;
pub mod distance;
pub mod error;
pub mod field;
pub mod geometry;
pub mod grid;
pub mod io;
pub mod layer;
pub mod medial;
#[cfg(feature = "report")]
pub mod memory;
pub mod morphology;
pub mod notice;
mod once;
pub mod operate;
pub mod part;
pub mod process;
#[cfg(test)]
mod random;
#[cfg(feature = "report")]
pub mod report;
pub mod topology;
pub mod units;

pub use error::{Error, Result};
