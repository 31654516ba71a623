//! Components, Betti numbers and escape diameters of sets of samples.

mod components;
mod euler;

pub use components::{Adjacency, Components, components};
pub use euler::{Betti, betti, euler_characteristic};
