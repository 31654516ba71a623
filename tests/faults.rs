//! Files that are broken on purpose: each ends in a mesh with a notice or in one typed error with its place.
//!
//! The rows are hand-made, one for each fault that files in the wild are known for; the mutations are seeded
//! and take small good files apart without knowing what they mean.

#[cfg(feature = "report")]
#[path = "faults/geometry.rs"]
mod geometry;
#[path = "faults/good.rs"]
mod good;
#[path = "faults/list.rs"]
mod list;
#[path = "faults/mutations.rs"]
mod mutations;
#[cfg(feature = "cli")]
#[path = "faults/pipeline.rs"]
mod pipeline;
#[path = "faults/projects.rs"]
mod projects;
#[path = "faults/rows.rs"]
mod rows;
