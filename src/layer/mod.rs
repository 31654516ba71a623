//! What a layer rests on: downward surface, islands, supports.

mod downward;
mod island;

pub use downward::{DownwardRegion, downward_regions};
pub use island::{Island, islands};
