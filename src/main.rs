//! The `amcheck` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    // Nothing is printed by a panic itself: what breaks down is told in one error like any other.
    std::panic::set_hook(Box::new(|_| {}));
    ExitCode::from(amcheck::cli::guarded(|| amcheck::cli::main(std::env::args_os())))
}
