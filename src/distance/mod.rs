//! Distances on grids alone: the exact Euclidean transform, nearest features, the reverse transform, the ridge.

mod panel;
mod signed;
mod squared;

pub use signed::signed_distance;
pub use squared::{FAR, signed_squared, squared_depth, squared_distance};
