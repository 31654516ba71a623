//! Pictures of the part by a renderer of our own: no graphics card, the same bytes everywhere.
//!
//! `raster` throws facets into a depth buffer with four samples a pixel, `paint` colours the samples by a map and its
//! limits, `canvas` and `lettering` draw what stands over it, `png` encodes. `sides` chooses where to look from;
//! `view` and `section` put pictures together.

mod camera;
mod canvas;
pub mod colour;
pub(super) mod lettering;
mod paint;
mod pair;
mod picture;
mod pin;
mod png;
mod raster;
mod section;
mod sides;
mod stance;
mod summary;
mod view;

pub use pair::{Panel, side_by_side};
pub use picture::{Picture, pictures, thumbnail};
pub use stance::stance;
