//! The reading room and its counterpart: one format, one file.
//!
//! Formats are recognised by content, never by suffix; no number in a header is believed before the bytes
//! behind it have been counted.

mod accept;
mod loaded;
pub mod obj;
mod path;
pub mod ply;
mod polygon;
mod read;
mod salvage;
mod sniff;
pub mod stl;
pub mod threemf;
mod words;

pub use loaded::Loaded;
pub use path::read_path;
pub use read::read;
pub use salvage::Salvage;
