//! Wavefront OBJ: the faces of a text file; lines, points, textures and materials are left aside.

mod read;
mod write;

pub use read::read;
pub use write::write;
