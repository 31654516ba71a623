//! Components, Betti numbers and escape diameters of sets of samples.

mod block;
mod chamber;
mod change;
mod components;
mod escape;
mod euler;
mod retention;

pub use chamber::{Chamber, Throat, chambers};
pub use change::{Change, changes};
pub use components::{Adjacency, Components, components};
pub use escape::{Escape, Pocket, Side, border, escape};
pub use euler::{Betti, betti, euler_characteristic};
pub use retention::{Falls, Passage, retained, retained_towards};
