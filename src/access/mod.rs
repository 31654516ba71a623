//! What can be reached, and which way to print.

mod direction;
mod orient;
mod up;

pub use orient::{Orientation, Orientations, Question, orientations, self_holding, standing, upright, wanting_support};
pub use up::Up;
