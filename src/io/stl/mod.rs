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

pub(super) use decide::{fits_binary, looks_like_text, may_be_binary};
pub use read::{RELATIVE_STEP, read};
pub use write::{merged, write};
