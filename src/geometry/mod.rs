//! Meshes: their health, their voxels, and exact distances to them.

pub mod mesh;
pub mod primitive;
pub mod vector;

pub use mesh::TriangleMesh;
pub use primitive::Primitive;
