//! From a set of samples and a level back to a surface: closed and manifold, always.
//!
//! Each cell of eight samples is cut by polygons whose corners lie on its edges; the polygons follow from one rule on
//! the faces (inside corners are separated), so neighbours agree, every polygon edge has exactly two polygons and every
//! vertex one ring of them. Polygons are cut into triangles only by diagonals that no other cell can have. Where normals
//! are known, a polygon that a crease or a corner passes gets a vertex on it, and the crease becomes an edge, unless facets would cross.

mod crowd;
mod feature;
mod polygon;
mod restore;
mod sheets;
mod surface;
mod uncross;

pub use crowd::{Crowd, MEETING};
pub use feature::SMOOTH_COSINE;
pub use sheets::{Sheets, bend_between, creased};
pub use surface::{
    Edge, creased_surface, crossing_between, level_surface, linear_crossing, sharp_surface, superlevel_surface, surface,
};
