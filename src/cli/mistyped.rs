//! What was meant by words that clap takes for a part and no more: a misspelt command, a command behind its part, several parts.

use super::args::Arguments;
use super::words::usage;
use crate::error::{Error, nearest, printable};
use crate::report::phrase::quoted;
use clap::{CommandFactory, Parser};
use std::ffi::OsString;
use std::path::Path;

/// That a word is no file, and nearly the name of a command.
pub fn misspelt(word: &Path) -> Option<Error> {
    unknown(word).filter(
        |error| matches!(error, Error::UnknownName { given, nearest: Some(_), known, .. } if !known.contains(given)),
    )
}

/// That what was taken for the part is no file, and nearly the name of a command, or one that stands behind options.
pub fn no_part(part: &Path) -> Option<Error> {
    let behind_options = || {
        let given =
            part.to_str().filter(|given| !part.exists() && commands().iter().any(|command| command == given))?;
        Some(usage(&format!("`{given}` stands behind options"), &format!("write it first: `amcheck {given} …`")))
    };
    misspelt(part).or_else(behind_options)
}

/// What is to be said of words of which `second` stands behind what was taken for the part.
pub fn behind_part(words: &[OsString], second: &str) -> Option<Error> {
    let is_second = |at: &usize| words.get(*at).is_some_and(|word| word.to_string_lossy() == second);
    let part_before = |at: usize| Arguments::try_parse_from(words.get(..at)?).ok()?.part;
    let part = (1..words.len()).filter(is_second).find_map(part_before)?;
    if let Some(error) = no_part(&part) {
        return Some(error);
    }
    let (first, second_shown) = (printable(&part.to_string_lossy()), printable(second));
    if commands().iter().any(|command| command == second) {
        let problem = format!("`{second_shown}` stands behind `{first}`");
        return Some(usage(
            &problem,
            &format!("write the command first: `amcheck {second_shown} {}`", quoted(&part.to_string_lossy())),
        ));
    }
    unknown(&part).or_else(|| {
        let words = [&part.to_string_lossy(), second].map(quoted).join(" ");
        let remedy = format!("judge several with `amcheck batch {words}`");
        Some(usage(&format!("one part is judged at a time, and `{second_shown}` is a second one"), &remedy))
    })
}

/// The word as a command that there is not, where it looks like one and names no file.
fn unknown(word: &Path) -> Option<Error> {
    let given = word.to_str().filter(|given| looks_like_command(given) && !word.exists())?;
    let known = commands();
    let nearest = nearest(given, known.iter().map(String::as_str));
    Some(Error::UnknownName { what: "command", given: printable(given), nearest, known })
}

fn looks_like_command(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_alphabetic()) && word.chars().all(|c| c.is_ascii_alphabetic() || c == '-')
}

fn commands() -> Vec<String> {
    Arguments::command().get_subcommands().map(|command| command.get_name().to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(words: &[&str], second: &str) -> (String, String) {
        let words: Vec<OsString> = words.iter().map(OsString::from).collect();
        let error = behind_part(&words, second).expect("what was meant");
        (error.to_string(), error.remedy())
    }

    #[test]
    fn what_is_nearly_a_command_is_no_part() {
        let near = |word: &str| misspelt(Path::new(word)).map(|error| error.remedy());
        assert_eq!(near("orinet").as_deref(), Some("did you mean `orient`?"));
        assert_eq!(near("proceses").as_deref(), Some("did you mean `processes`?"));
        // What is there is no slip, and what has a dot no command; a command is not misspelt.
        for part in ["src", "orinet.stl", "-", "zzzzzzzz", "", "close"] {
            assert_eq!(near(part), None, "{part}");
        }
    }

    #[test]
    fn a_second_word_is_a_part_or_a_command_at_the_wrong_place() {
        let (problem, remedy) = said(&["amcheck", "--quiet", "orinet", "a.stl"], "a.stl");
        assert_eq!((problem.as_str(), remedy.as_str()), ("unknown command `orinet`", "did you mean `orient`?"));
        let (problem, remedy) = said(&["amcheck", "frobnicate", "a.stl"], "a.stl");
        assert!(problem == "unknown command `frobnicate`" && remedy.contains("orient"), "{remedy}");
        for (words, second) in [(["amcheck", "a.stl", "b.stl"], "b.stl"), (["amcheck", "a.stl", "a.stl"], "a.stl")] {
            let (problem, remedy) = said(&words, second);
            assert!(problem.contains("one part is judged at a time"), "{problem}");
            assert_eq!(remedy, format!("judge several with `amcheck batch a.stl {second}`"));
        }
        let (_, remedy) = said(&["amcheck", "a.stl", "--only", "mesh", "orient"], "orient");
        assert_eq!(remedy, "write the command first: `amcheck orient a.stl`");
        let (_, remedy) = said(&["amcheck", "a b.stl", "$(id).stl"], "$(id).stl");
        assert_eq!(remedy, "judge several with `amcheck batch 'a b.stl' '$(id).stl'`");
    }
}
