//! The door: words become options, one call is made, the answer is written and an exit code returned.

mod args;
mod asked;
mod batch;
mod command;
mod complaint;
mod deliver;
mod fail_on;
mod judge;
mod leftover;
mod lists;
mod made;
mod mistyped;
mod named;
mod need;
mod operand;
mod operate;
mod orient;
mod plan;
mod progress;
mod record;
mod refusal;
mod stdout;
mod told;
mod toolpath;
mod tools;
mod watch;
mod words;

pub use args::{Arguments, Batch, Command, How, Judging, Operation, Pair};
pub use command::{guarded, main};
