//! The court: each check reads a part and a process and returns an outcome.
//!
//! A new check is one file here, one line in [`registry`], one part that must pass, one that must fail and one row in the
//! table of expected results; a test fails if any is missing.

mod acceptance;
mod apart;
mod as_printed;
mod basin;
mod bed_contact;
mod blend;
mod bridge;
mod budget;
mod build_volume;
mod chamfer;
mod contract;
mod cut;
mod departing;
mod departure;
mod detail;
mod drain;
mod enclosed;
mod fillet;
mod filling;
mod finding;
mod hanging;
mod island;
mod knife_edge;
mod least_width;
mod lost_feature;
mod mend;
mod mesh;
mod narrow_gap;
mod offset;
mod overhang;
mod place;
mod powder;
pub mod registry;
mod rib;
mod rods;
mod roof;
mod room;
mod search;
mod sheet;
mod sheet_shape;
mod sheet_thinnest;
mod sheet_words;
mod small_hole;
mod support;
mod support_access;
mod tall_feature;
mod thin_body;
mod thin_pin;
mod thin_wall;
mod throat;
mod tool_access;
mod tooling;
mod topology;
mod trapped_volume;
mod trial;
mod vent;
mod void;

pub use acceptance::Acceptance;
pub use budget::Budget;
pub use contract::{Check, Context, MapKind, MapWanted, Measured, Meta, Outcome, ShapeShown, Worst, limits_of};
pub use finding::{Accepted, Basis, Bracket, Finding, Limits, Sense, Spot, State, Witness};
pub use place::name_apart;
pub use tooling::setup_samples;
