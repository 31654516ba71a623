//! The door: words become options, one call is made, the answer is written and an exit code returned.

mod args;
mod command;
mod deliver;
mod judge;
mod lists;

pub use args::{Arguments, Command};
pub use command::main;
