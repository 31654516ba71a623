//! Processes: limits with value, unit, basis and source; built-in profiles as data.
//!
//! A limit that no source supports is a *convention*: it says so and warns at most. A user's own limit is *user*.

mod builtin;
mod date;
mod finishing;
mod limit;
mod override_limit;
mod profile;
mod rule;
mod tools;
mod waiver;

pub use builtin::{BUILTIN, builtin};
pub use date::Date;
pub use finishing::{Approach, FaceChoice, Finishing, direction};
pub use limit::{Limit, LimitBasis};
pub use profile::{Element, Process};
pub use rule::{Bound, Dimension, RULES, Rule, rule};
pub use tools::{TOOLS, ToolChoice, Tools};
pub use waiver::{Region, Waiver, waivers};
