//! The door: words become options, one call is made, the answer is written and an exit code returned.

mod args;
mod batch;
mod command;
mod complaint;
mod deliver;
mod judge;
mod lists;
mod made;
mod operand;
mod operate;
mod orient;
mod progress;
mod toolpath;
mod watch;
mod words;

pub use args::{Arguments, Batch, Command, How, Judging, Operation, Pair};
pub use command::main;
