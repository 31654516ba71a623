//! G-code: the strokes along which a machine deposits or cuts.

mod arc;
mod faults;
mod firmware;
mod kept;
mod machine;
mod strokes;
mod words;

use faults::{damaged, unsupported};
pub use machine::read;
