//! One HTML file: complete without script, without network, in the light and in the dark, and on paper.
//!
//! Everything that matters is HTML, SVG and PNG made here; `page.js` only adds. The file opens from disk, and its
//! Content-Security-Policy forbids every connection.

mod cards;
mod method;
mod orient;
mod overview;
mod page;
mod stage;
mod thickness;
mod verdict;
mod viewer;
mod volume;

pub use orient::orientations;
pub use page::page;
