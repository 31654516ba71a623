//! The union of bodies that overlap or touch, and of a surface that passes through itself, as one mesh.

mod arrangement;
mod bounding;
mod contact;
mod cracks;
mod cuts;
mod exact;
mod net;
mod pieces;
mod points;
mod united;

pub use united::united;
