//! What turns the exit code to 1.

use super::words::one_of;
use crate::check::State;
use crate::error::Result;
use crate::report::{Report, Verdict};

/// What turns the exit code to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FailOn {
    Fail,
    Warn,
    Undecided,
    New,
    Never,
}

impl FailOn {
    /// What a word of `--fail-on` names.
    ///
    /// # Errors
    /// [`crate::Error::UnknownName`].
    pub fn named(text: &str) -> Result<Self> {
        let known = [
            ("fail", FailOn::Fail),
            ("warn", FailOn::Warn),
            ("undecided", FailOn::Undecided),
            ("new", FailOn::New),
            ("never", FailOn::Never),
        ];
        let names: Vec<&str> = known.iter().map(|k| k.0).collect();
        let chosen = one_of("state for --fail-on", &[text.to_string()], &names)?;
        Ok(known.iter().find(|k| chosen.contains(&k.0)).map_or(FailOn::Fail, |k| k.1))
    }

    /// The states of checks that count as failing beside those that fail.
    pub fn failing(self) -> &'static [State] {
        match self {
            FailOn::Fail | FailOn::New | FailOn::Never => &[],
            FailOn::Warn => &[State::Warn, State::Undecided],
            FailOn::Undecided => &[State::Undecided],
        }
    }

    /// Exit code of a report; `worse` says that a failure is new or worse than the baseline's.
    pub fn exit_code(self, report: &Report, worse: bool) -> u8 {
        match (report.verdict, self) {
            (_, FailOn::Never) => 0,
            (_, FailOn::New) => u8::from(worse),
            (Verdict::Fail, _) => 1,
            (Verdict::Undecided, FailOn::Undecided | FailOn::Warn) => 1,
            (Verdict::Undecided, _) => 3,
            (Verdict::Warn, FailOn::Warn) => 1,
            (_, FailOn::Undecided) => u8::from(report.undecided() > 0),
            _ => 0,
        }
    }
}
