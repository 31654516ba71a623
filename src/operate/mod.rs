//! Shapes made from shapes: offset, open, close, Minkowski sum and difference, sweep, obstacle, deposit — mesh or path
//! in, mesh out, with a certified volume bracket and the path that was taken.
//!
//! No shape is ever returned whose operation failed: every result is checked against its own bracket, and an error
//! is an error.

mod deposit;
mod element;
mod flush;
mod fused;
mod left_out;
mod lost;
mod met;
mod midway;
mod motion;
mod operated;
mod pieces;
mod settled;
mod shape;
mod twice;
mod whole;

pub use deposit::{Departure, Deposit, deposit};
pub use element::Element;
pub use left_out::Reach;
pub use motion::sweep_motion;
pub use operated::Operated;
pub use pieces::Pieces;
pub use shape::{close, difference, minkowski, obstacle, offset, open, reachable, sweep};
pub use whole::solid_volume;
