//! The union of bodies that overlap or touch, and of a surface that passes through itself, as one mesh.

mod cuts;
mod pieces;
mod points;
mod united;

pub use united::united;
