//! Meshes: their health, their voxels, and exact distances to them.

pub mod bvh;
pub mod distance;
pub mod mesh;
pub mod triangle;
pub mod vector;

pub use distance::MeshDistance;
pub use mesh::TriangleMesh;
