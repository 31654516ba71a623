//! Where grid and mesh meet: medial balls, feature pairs, witnesses and covers.
//!
//! A wall is a pair of opposing features with an empty ball between them. [`cover`] searches all pairs by branch and
//! bound, so that *no wall thinner than the limit* is a proof and not a sampling; [`cluster`] turns what it finds into places.

mod area;
mod axes;
pub mod axis;
mod blocked;
pub mod chord;
pub mod cluster;
pub mod cover;
pub mod crease;
mod edge;
mod facing;
pub mod feature;
mod flat;
mod head;
mod held;
mod held_balls;
pub mod inscribed;
pub mod map;
pub mod opened;
mod orifice;
mod reach;
pub mod refine;
pub mod reflex;
pub mod rod;
mod rod_end;
pub mod section;
mod seed;
mod seek;
mod slab;
pub mod strip;
pub mod thickness;
mod unopposed;
mod waist;
mod wedge;

pub use cover::{Cover, Own, Passed, Question, Sample, Shape};
pub use feature::{Bends, Features, Side};
pub use wedge::{runs_out, stays};
