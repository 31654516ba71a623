//! What a layer rests on: downward surface, islands, supports.

mod downward;
mod island;
mod support;

pub use downward::{DownwardRegion, downward_facets, downward_regions};
pub use island::{Island, islands};
pub use support::{Supports, supports};
