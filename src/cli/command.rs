//! From words to an exit code: which command was asked for, and where its answer goes.

use super::args::{Arguments, Command};
use super::{judge, lists};
use crate::error::Error;
use crate::report::terminal::{self, Palette};
use clap::{CommandFactory, Parser};
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
    let part = arguments.part.clone();
    let done = match &arguments.command {
        Some(Command::Explain { name }) => lists::explain(name),
        Some(Command::Compare { old, new }) => judge::compare_reports(old, new),
        Some(Command::Processes) => Ok((lists::processes(), 0)),
        Some(Command::Schema) => Ok((crate::report::json::SCHEMA_TEXT.to_string(), 0)),
        Some(Command::Completions { shell }) => {
            let mut text = Vec::new();
            clap_complete::generate(*shell, &mut Arguments::command(), "amcheck", &mut text);
            Ok((String::from_utf8_lossy(&text).into_owned(), 0))
        }
        None => judge::judge(&arguments),
    };
    match done {
        Ok((text, code)) => print(&text).map_or(code, |()| code),
        Err(e) => {
            complain(&e, part.as_deref());
            e.exit_code()
        }
    }
}

/// Writes to stdout; a reader that has gone away (`| head`) is no error.
fn print(text: &str) -> Option<()> {
    std::io::stdout().lock().write_all(text.as_bytes()).ok()
}

fn complain(error: &Error, part: Option<&std::path::Path>) {
    let file = part.map(|p| p.to_string_lossy().into_owned());
    let text = terminal::error(error, file.as_deref(), palette(std::io::stderr().is_terminal()));
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Colour only on a terminal and without `NO_COLOR`.
pub(super) fn palette(terminal: bool) -> Palette {
    let refused = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
    if terminal && !refused { Palette::Ansi } else { Palette::Plain }
}
