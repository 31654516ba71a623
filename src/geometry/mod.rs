//! Meshes: their health, their voxels, and exact distances to them.

mod body_pairs;
mod box_pairs;
pub mod bvh;
pub mod cavity;
pub mod contour;
pub mod disjoint;
pub mod distance;
mod facet_bounds;
pub mod generate;
pub mod health;
pub mod mesh;
pub mod primitive;
pub mod refine;
pub mod solid;
mod swept;
pub mod triangle;
pub mod vector;
pub mod voxelize;
mod waypoint;
pub mod wide;
pub mod winding;

pub use body_pairs::{BodyPair, body_pairs};
pub use box_pairs::{LabelledBox, box_pairs};
pub use cavity::{Cavity, cavities};
pub use disjoint::DisjointSets;
pub use distance::MeshDistance;
pub use generate::{cuboid, extruded, revolved};
pub use health::Health;
pub use mesh::TriangleMesh;
pub use primitive::Primitive;
pub use solid::{Doubt, Enclosure, InsideRule, Solid};
pub use swept::swept;
pub use voxelize::{enclose, occupancy, voxelize, voxelize_layers};
pub use waypoint::Waypoint;
pub use winding::Winding;
