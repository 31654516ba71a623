//! What a layer rests on: downward surface, islands, bridges, supports, pillars; sections, sight and liquid by layers.

mod beneath;
mod bridge;
mod clip;
mod column;
mod directions;
mod downward;
mod ground;
mod island;
mod line;
mod outermost;
mod outlines;
mod passage;
mod pieces;
mod plan;
mod reading;
mod section;
mod sight;
mod sliver;
mod step_down;
mod stretch;
mod support;
mod tall;
mod walk;

pub use beneath::{Ground, lies_below, share_below};
pub use bridge::{Ceiling, FLAT, Measuring, Reach, SelfHolding, ceilings};
pub use column::{SupportVolume, shadow_area, support_volume, support_volumes};
pub use downward::{DownwardRegion, downward_facets, downward_regions};
pub use ground::{Below, Bounding};
pub use island::{Island, islands};
pub use passage::Crown;
pub use reading::Search;
pub use section::{Point, clip_below, section_area, section_points};
pub use sight::hidden_from_outside;
pub use stretch::{above, lifted, stretch};
pub use support::{Supports, supports};
pub use tall::{Counting, TallFeature, tall_features};
