//! Dilation, erosion, opening, closing, offset, sweep: the words of the field, and nothing else.
//!
//! On sets of samples the operators are exact, whatever path they take. On shapes known from three sides ([`Sides`])
//! they enclose the true result between two sets and its volume between two numbers ([`Sandwich`]).

mod bead;
mod bead_surface;
mod bodies;
mod buried;
mod cells;
mod columns;
mod corners;
mod cost;
mod covered;
mod deposit;
mod dwell;
mod element;
mod films;
mod least_element;
mod level;
mod minkowski;
mod missed;
mod motion;
mod moving;
mod near;
mod offset;
mod opening;
mod overlap;
mod places;
mod press;
mod remains;
mod rolling;
mod rough;
mod sandwich;
mod spread;
mod sweep;
mod thin;
mod traced;
mod unsweep;
mod walls;
mod within;

pub use bead::deposit;
pub use bead_surface::deposit_surface;
pub use cells::Cells;
pub use covered::motion_surface;
pub use deposit::{AsPrinted, Designed};
pub(crate) use deposit::{grown, opened};
pub use dwell::{Dwell, dwell};
pub use element::{Shape, Sides, StructuringElement};
pub use least_element::{Bead, Footprint};
pub use minkowski::{Morphed, Path, dilate, dilate_along, erode, erode_by_path};
pub use missed::{Contact, Missed, missed};
pub use motion::placements_along;
pub use offset::{NEAR_PART, Shaped, offset};
pub use opening::{closing, opening, regularize};
pub use remains::{Remains, remains};
pub use rolling::{close_by_ball, open_by_ball};
pub use sandwich::Sandwich;
pub use sweep::{Placement, between_copies, copies, path_cells, sweep, sweep_poses, sweep_set, sweep_surface};
pub use unsweep::{unsweep, unsweep_poses, unsweep_set};
