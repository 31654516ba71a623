//! Charts as SVG by plotters: a gauge for each check, a histogram for each map.
//!
//! Colours are a closed list that the page's style sheet maps to the light and the dark theme; letters are measured
//! with the font beside the code, so that the text is the same on every machine.

mod drawing;
mod gauge;
mod histogram;
mod scatter;

pub use gauge::{Gauge, gauge};
pub use histogram::histogram;
pub use scatter::orientations;
