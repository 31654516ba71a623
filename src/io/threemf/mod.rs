//! 3MF, the core specification: units, meshes, components, transforms, build items.
//!
//! A package is opened as if an enemy had made it: named parts only, nothing written anywhere, sizes
//! capped before inflating, no DTD, no entity, no script, no printer setting. What a file *requires* and we do
//! not read is refused by name; it never becomes an empty part that passes.

mod assemble;
mod model;
mod package;
mod read;
mod relations;
mod transform;
mod write;
mod xml;

pub use read::read;
pub use write::write;
