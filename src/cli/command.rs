//! From words to an exit code: which command was asked for, and where its answer goes.

use super::args::{Arguments, Command};
use super::complaint::{Answer, Complaint};
use super::{batch, judge, lists, mistyped, operate, orient, plan, stdout, tools, watch};
use crate::error::{Error, printable};
use crate::report::terminal::{self, Palette};
use clap::error::{ContextKind, ContextValue};
use clap::{CommandFactory, Parser};
use std::ffi::OsString;
use std::io::{IsTerminal, Write};
use std::path::Path;

/// Runs the command line and returns the exit code; results go to stdout, errors and progress to stderr.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let words: Vec<OsString> = arguments.into_iter().collect();
    let arguments = match Arguments::try_parse_from(&words) {
        Ok(arguments) => arguments,
        Err(e) => return refuse(&e, &words),
    };
    let command_meant = arguments.part.as_deref().filter(|_| arguments.command.is_none()).and_then(mistyped::no_part);
    if let Some(error) = command_meant {
        return failed(&Complaint::from(error));
    }
    stop_cleanly(&arguments);
    let part = arguments.part.as_deref();
    let done: Answer<(String, u8)> = match &arguments.command {
        Some(Command::Explain { name }) => lists::explain(name).map_err(Complaint::from),
        Some(Command::Compare { old, new }) => judge::compare_reports(old, new).map_err(Complaint::from),
        Some(Command::Batch(options)) => batch::batch(options).map_err(Complaint::from),
        Some(Command::Merge { folders, out }) => batch::merge_tables(folders, out.as_deref()).map_err(Complaint::from),
        Some(Command::Orient(how)) => orient::orient(how).map(|text| (text, 0)),
        Some(Command::Make(operation)) => operate::operate(operation).map(|text| (text, 0)),
        Some(Command::Tools { name }) => tools::list(name.as_deref()).map(|text| (text, 0)).map_err(Complaint::from),
        Some(Command::Processes) => Ok((lists::processes(), 0)),
        Some(Command::Schema) => Ok((crate::report::json::SCHEMA_TEXT.to_string(), 0)),
        Some(Command::Completions { shell }) => {
            let mut text = Vec::new();
            clap_complete::generate(*shell, &mut Arguments::command(), "amcheck", &mut text);
            Ok((String::from_utf8_lossy(&text).into_owned(), 0))
        }
        None if arguments.plan => plan::plan(&arguments).map_err(|e| Complaint::about(part, e)),
        None if arguments.watch => watch::watch(&arguments),
        None => judge::judge(&arguments),
    };
    let said = done.and_then(|(text, code)| stdout::put(&text).map(|()| code).map_err(Complaint::from));
    said.unwrap_or_else(|complaint| failed(&complaint))
}

/// Says what failed; its exit code.
fn failed(complaint: &Complaint) -> u8 {
    complain(complaint);
    complaint.error.exit_code()
}

/// Runs the command; a broken promise of ours ends in one error and its own exit code, and leaves nothing half-written.
pub fn guarded(command: impl FnOnce() -> u8 + std::panic::UnwindSafe) -> u8 {
    std::panic::catch_unwind(command).unwrap_or_else(|panic| {
        crate::io::abandon_temporaries();
        broken_down(panic.as_ref())
    })
}

/// Says what broke; the exit code of a broken promise.
fn broken_down(panic: &(dyn std::any::Any + Send)) -> u8 {
    failed(&Complaint::from(Error::broken_down(panic)))
}

/// On Ctrl-C and on being told to end: nothing half-written stays, and the exit code says so; to watch ends like that and no other way.
fn stop_cleanly(arguments: &Arguments) {
    let watches = arguments.watch;
    // Without a handler the process ends at once, which leaves at most a hidden file.
    let _ = ctrlc::set_handler(move || {
        crate::io::abandon_temporaries();
        if watches {
            std::process::exit(0);
        }
        complain(&Complaint::from(Error::Interrupted));
        std::process::exit(i32::from(Error::Interrupted.exit_code()));
    });
}

/// Answers words that are no command: the help where it was asked for, else an error like any other.
fn refuse(e: &clap::Error, words: &[OsString]) -> u8 {
    use clap::error::ErrorKind;
    match e.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            stdout::outcome(e.print()).map_or_else(|e| failed(&Complaint::from(e)), |()| 0)
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = e.print();
            2
        }
        _ => failed(&Complaint::from(meant(e, words).unwrap_or_else(|| usage(e)))),
    }
}

/// What was meant, where a word stands behind the part or the first one is nearly a command.
fn meant(e: &clap::Error, words: &[OsString]) -> Option<Error> {
    match e.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(second)) => mistyped::behind_part(words, second),
        _ => words.get(1).and_then(|first| mistyped::misspelt(Path::new(first))),
    }
}

/// The first sentence of what clap says, with the nearest name where it knows one.
fn usage(e: &clap::Error) -> Error {
    let text = e.to_string();
    let first: Vec<&str> = text.lines().map(str::trim).take_while(|l| !l.is_empty()).collect();
    let problem = first.join(" ").trim_start_matches("error: ").to_string();
    let suggested = [ContextKind::SuggestedArg, ContextKind::SuggestedSubcommand, ContextKind::SuggestedValue]
        .into_iter()
        .filter_map(|kind| e.get(kind))
        .find_map(|value| match value {
            ContextValue::String(name) => Some(name),
            ContextValue::Strings(names) => names.first(),
            _ => None,
        });
    let remedy = suggested.map_or(format!("see `{} --help`", asked(e)), |name| format!("did you mean `{name}`?"));
    Error::Usage { problem, remedy }
}

/// The command that was misused, with the one beneath it, as clap's line of usage begins: `amcheck offset`.
fn asked(e: &clap::Error) -> String {
    let usage = match e.get(ContextKind::Usage) {
        Some(ContextValue::StyledStr(text)) => text.to_string(),
        _ => String::new(),
    };
    let is_name = |word: &&str| word.chars().all(|c| c.is_ascii_lowercase());
    let words: Vec<&str> = usage.split_whitespace().skip_while(|w| *w != "amcheck").take_while(is_name).collect();
    if words.is_empty() { "amcheck".into() } else { words.join(" ") }
}

/// Says on standard error what failed, where, and what to do about it.
pub(super) fn complain(Complaint { error, file: part, note }: &Complaint) {
    // The part is named only where the part is the trouble: options, profiles and earlier reports have places of their own.
    let file = match error.as_ref() {
        Error::Usage { .. } | Error::UnknownName { .. } | Error::Damaged { format: "report", .. } => None,
        Error::Profile { file: path, .. } | Error::CannotRead { path, .. } | Error::CannotWrite { path, .. } => {
            Some(path.clone())
        }
        _ => part.as_ref().map(|p| p.to_string_lossy().into_owned()),
    };
    let mut text = terminal::error(error, file.as_deref(), palette(std::io::stderr().is_terminal()));
    text.extend(note.iter().map(|note| format!("  note: {}\n", printable(note))));
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Colour only on a terminal and without `NO_COLOR`.
pub(super) fn palette(terminal: bool) -> Palette {
    let refused = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
    if terminal && !refused { Palette::Ansi } else { Palette::Plain }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_one_error_with_its_own_code() {
        // Not through `guarded`: what gives up the temporaries of the process would hold up the tests beside this one.
        assert_eq!(broken_down(&"on purpose"), 70);
        assert_eq!(guarded(|| 3), 3);
        let said = Error::broken_down(&String::from("at\u{1b}[2J"));
        assert_eq!((said.exit_code(), said.to_string().contains('\u{1b}')), (70, false));
    }
}
