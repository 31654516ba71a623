//! The court: each check reads a part and a process and returns an outcome.

mod finding;

pub use finding::{Basis, Bracket, Finding, Limits, Sense, Spot, State, Witness};
