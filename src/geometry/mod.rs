//! Meshes: their health, their voxels, and exact distances to them.

pub mod health;
pub mod mesh;
pub mod vector;

pub use health::Health;
pub use mesh::TriangleMesh;
