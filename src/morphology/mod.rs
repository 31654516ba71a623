//! Dilation, erosion, opening, closing, offset, sweep: the words of the field, and nothing else.

mod element;
mod minkowski;

pub use element::{Shape, Sides, StructuringElement};
pub use minkowski::{Morphed, Path, dilate, dilate_along, erode, erode_by_path};
