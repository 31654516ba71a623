//! G-code: the strokes along which a machine deposits or cuts.

mod arc;
mod faults;
mod firmware;
mod machine;
mod words;

use faults::{damaged, unsupported};
pub use machine::read;
