//! STL, binary and ASCII: facets without topology, unit or precision beyond f32.
//!
//! The crate `stl_io` parses every facet. It is never handed a file as it came, because it drops geometry
//! without a word (second solids, counts too small) and refuses
//! files that everybody else reads. Our own pre-readers decide what the file is, count, check, normalise,
//! and name the place of a fault.

mod binary;
mod decide;
mod read;
mod text;
mod write;

/// No coordinate is further from what was meant than this share of the largest: both kinds are parsed as f32.
pub const RELATIVE_STEP: f64 = 1.0 / (1 << 24) as f64;

pub(super) use decide::{fits_binary, looks_like_text, may_be_binary};
pub use read::read;
pub use write::{merged, write};
