//! 3MF, the core specification and the production extension: units, meshes, components, transforms, build items,
//! objects of other model parts; and what slicers note in their projects of volumes that are no material.
//!
//! A package is opened as if an enemy had made it: named parts only, nothing written anywhere, sizes
//! capped before inflating, no DTD, no entity, no script, no printer setting. What a file *requires* and we do
//! not read is refused by name; it never becomes an empty part that passes.

mod assemble;
mod cura;
mod model;
mod package;
mod read;
mod relations;
mod role;
mod scene;
mod settings;
mod transform;
mod volumes;
mod write;
mod xml;

pub use read::read;
pub use write::write;
