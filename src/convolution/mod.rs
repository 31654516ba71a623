//! Convolution and correlation by real 3-D Fourier transforms, with exact counts where a verdict rests on them.
//!
//! [`Convolver`] keeps a part's spectrum and lays any number of elements over it; [`Workload`] is the rule that says
//! which arithmetic is exact, and refuses the rest. [`Descent`] tells where they meet at all, from coarse to fine, in bits alone.

mod cells;
mod column;
mod convolver;
mod descent;
mod direct;
mod lanes;
mod lowpass;
mod ntt;
mod precision;
mod pyramid;
mod row;
mod size;
mod spectrum;
mod square;
mod tiles;
mod transform;
mod tree;

pub use convolver::{Convolver, Counts, Estimate, convolve_fields, correlate_fields};
pub use descent::Descent;
pub use direct::{convolve_directly, dilate_by_runs, run_count, sum_grid};
pub use lowpass::{LowPass, correlate_low_pass};
pub use precision::{ALLOWED, MODULUS, Precision, Workload};
pub use pyramid::{Coarse, coarsened_all, coarsened_any, decide_coarsely};
pub use size::{good_even_size, good_size};
pub use spectrum::Spectrum;
pub use tiles::{convolve_tiled, dilate_tiled};
pub use transform::{Real, RowContent, Transform, Window};
pub use tree::boundary_nodes;
