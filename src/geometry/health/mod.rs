//! How well a mesh bounds a solid: edges, shells, bodies, and what of it has to be said.
//!
//! Below: the mesh and its vectors. Above: the readers of the report, voxelization (which trusts a closed
//! mesh and votes on any other), and the labels of bodies that gaps are measured between.

mod bodies;
mod boxes;
mod caps;
mod cracks;
mod crossing;
mod ghosts;
mod measure;
mod needles;
mod nesting;
mod notices;
mod outward;
mod overlap;
pub(in crate::geometry) mod pairs;
mod rays;
mod repair;
mod shells;
mod sides;
mod turn;

pub use bodies::{Body, NO_LABEL, Role};
pub use cracks::{Crack, cracks};
pub use crossing::{Meetings, Through, crossing_pairs, meetings, meetings_through, neighbours, triangles_cross};
pub use ghosts::without_ghosts;
pub use measure::{Fault, Health, Hole};
pub use needles::without_slivers;
pub use repair::{Repair, Repaired, TURNED, agreed, repair_tolerance, repaired, without_cracks};
pub use shells::Shell;
pub use sides::{Sides, Spoken};
pub use turn::turn_shells;
