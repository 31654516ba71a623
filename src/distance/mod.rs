//! Distances on grids alone: the exact Euclidean transform, nearest features, the reverse transform, the ridge.

mod feature;
mod near;
mod panel;
mod reverse;
mod signed;
mod squared;

pub use feature::{NOWHERE, nearest_sample};
pub use near::NearBoundary;
pub use reverse::union_of_balls;
pub use signed::signed_distance;
pub use squared::{FAR, REACH, signed_squared, squared_depth, squared_distance};
