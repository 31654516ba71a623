//! Components, Betti numbers and escape diameters of sets of samples.

mod components;
mod escape;
mod euler;

pub use components::{Adjacency, Components, components};
pub use escape::{Escape, Pocket, Side, border, escape};
pub use euler::{Betti, betti, euler_characteristic};
