//! Convolution and correlation by real 3-D Fourier transforms, with exact counts where a verdict rests on them.

mod transform;

pub use transform::{Real, RowContent, Spectrum, Transform, Window, good_even_size, good_size};
