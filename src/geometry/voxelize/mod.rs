//! Casting a mesh onto a grid: what lies inside, what is touched, how full each cube is.

mod cast;
mod crossings;
mod fraction;
mod lattice;
mod shell;
#[cfg(test)]
pub(super) mod tests;
#[cfg(test)]
mod torn;
mod winding;

pub use cast::{enclose, occupancy, voxelize, voxelize_layers};
