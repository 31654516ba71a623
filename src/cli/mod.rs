//! The door: words become options, one call is made, the answer is written and an exit code returned.

mod args;
mod complaint;
mod deliver;
mod judge;
mod lists;
mod made;
mod operand;
mod operate;
mod words;

pub use args::{Arguments, Command, How, Operation, Pair};

use crate::report::terminal::{self, Palette};
use clap::{CommandFactory, Parser};
use complaint::{Answer, Complaint};
use std::io::{IsTerminal, Write};

/// Runs the command line and returns the exit code; results go to stdout, errors and progress to stderr.
pub fn main(arguments: impl IntoIterator<Item = std::ffi::OsString>) -> u8 {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(e) => {
            let shown =
                matches!(e.kind(), clap::error::ErrorKind::DisplayHelp | clap::error::ErrorKind::DisplayVersion);
            let _ = e.print();
            return if shown { 0 } else { 2 };
        }
    };
    let part = arguments.part.as_deref();
    let done: Answer<(String, u8)> = match &arguments.command {
        Some(Command::Explain { name }) => lists::explain(name).map_err(Complaint::from),
        Some(Command::Compare { old, new }) => judge::compare_reports(old, new).map_err(Complaint::from),
        Some(Command::Make(operation)) => operate::operate(operation).map(|text| (text, 0)),
        Some(Command::Processes) => Ok((lists::processes(), 0)),
        Some(Command::Schema) => Ok((crate::report::json::SCHEMA_TEXT.to_string(), 0)),
        Some(Command::Completions { shell }) => {
            let mut text = Vec::new();
            clap_complete::generate(*shell, &mut Arguments::command(), "amcheck", &mut text);
            Ok((String::from_utf8_lossy(&text).into_owned(), 0))
        }
        None => judge::judge(&arguments).map_err(|e| Complaint::about(part, e)),
    };
    match done {
        Ok((text, code)) => print(&text).map_or(code, |()| code),
        Err(complaint) => {
            complain(&complaint);
            complaint.error.exit_code()
        }
    }
}

/// Writes to stdout; a reader that has gone away (`| head`) is no error.
fn print(text: &str) -> Option<()> {
    std::io::stdout().lock().write_all(text.as_bytes()).ok()
}

fn complain(complaint: &Complaint) {
    let file = complaint.file.as_deref().map(|p| p.to_string_lossy());
    let text = terminal::error(&complaint.error, file.as_deref(), palette(std::io::stderr().is_terminal()));
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Colour only on a terminal and without `NO_COLOR`.
fn palette(terminal: bool) -> Palette {
    let refused = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
    if terminal && !refused { Palette::Ansi } else { Palette::Plain }
}
