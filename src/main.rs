//! The `amcheck` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    // A broken promise of ours ends in one line and its own exit code, never in a backtrace.
    std::panic::set_hook(Box::new(|_| {}));
    match std::panic::catch_unwind(|| amcheck::cli::main(std::env::args_os())) {
        Ok(code) => ExitCode::from(code),
        Err(panic) => {
            let what = panic
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| panic.downcast_ref::<&str>().copied())
                .unwrap_or("unknown");
            eprintln!("error[E070]: internal error: {what}\n  help: please report this with the command and the part");
            ExitCode::from(70)
        }
    }
}
