//! The reading room and its counterpart: one format, one file.
//!
//! Formats are recognised by content, never by suffix; no number in a header is believed before the bytes
//! behind it have been counted. Meshes are read as STL, 3MF, OBJ and PLY and written as these and GLB; paths are
//! read as G-code and lists of points and poses; fields are written as NPY, NRRD and VTI. A writer takes any
//! `std::io::Write`; to a file it goes through [`write_atomically`], so that no half-written file is ever left.

// What comes from outside is neither unwrapped nor indexed.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic))]

mod accept;
mod atomic;
pub mod gcode;
pub mod glb;
mod loaded;
pub mod machine;
pub mod motion;
pub mod npy;
pub mod nrrd;
pub mod obj;
mod path;
pub mod ply;
mod polygon;
mod raster;
mod read;
mod rows;
mod salvage;
mod sniff;
pub mod stl;
mod temporary;
pub mod threemf;
pub mod toolpath;
pub mod vti;
mod words;

pub use atomic::{Content, write_atomically, write_together};
pub use loaded::Loaded;
#[cfg(feature = "report")]
pub(crate) use path::bytes_of;
pub use path::{content_of, read_path};
pub use raster::Raster;
pub use read::{read, reading_bytes};
pub use salvage::Salvage;
pub use sniff::plain_text;
pub use temporary::{Temporary, abandon_temporaries};
