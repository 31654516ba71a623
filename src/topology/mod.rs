//! Components, Betti numbers and escape diameters of sets of samples.

mod block;
mod chamber;
mod change;
mod components;
mod escape;
mod euler;
mod retention;
mod thinning;

pub use chamber::{Chamber, Throat, chambers};
pub use change::{Change, Comparisons, changes};
pub use components::{Adjacency, Components, components};
pub use escape::{Escape, Pocket, Side, border, escape};
pub use euler::{Betti, betti, euler_characteristic};
pub use retention::{Falls, Passage, retained, retained_towards};
