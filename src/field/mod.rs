//! Defining functions on a grid: geometry as functions that are positive inside.
//!
//! Three kinds carry everything above: [`Indicator`] (in or out, one bit a sample), [`Density`] (the solid
//! fraction of each sample's cube) and [`SignedDistance`] (millimetres, **negative inside**). Each wraps a
//! [`Field`] or bit rows, has a background that holds everywhere outside its grid, and converts into another
//! kind only by a named function.

mod algebra;
mod density;
mod indicator;
mod sampled;
mod signed_distance;
mod singular;
mod window;

pub use algebra::{
    Blend, complement, equal_up_to, indicator_function, inner_product, lp_norm, overlap_volume, product, sum,
    superlevel,
};
pub use density::Density;
pub use indicator::Indicator;
pub use sampled::Field;
pub use signed_distance::SignedDistance;
pub use singular::{Nascent, Singular, contact_area, volume_fraction};
pub(crate) use window::bits_from;
