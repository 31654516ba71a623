//! What turns the exit code to 1.

use super::words::one_of;
use crate::check::State;
use crate::error::Result;
use crate::report::baseline::Comparison;
use crate::report::{Report, Verdict};

/// What turns the exit code to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FailOn {
    Fail,
    Warn,
    Undecided,
    New,
    NewWarn,
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
            ("new-warn", FailOn::NewWarn),
            ("never", FailOn::Never),
        ];
        let names: Vec<&str> = known.iter().map(|k| k.0).collect();
        let chosen = one_of("state for --fail-on", &[text.to_string()], &names)?;
        Ok(known.iter().find(|k| chosen.contains(&k.0)).map_or(FailOn::Fail, |k| k.1))
    }

    /// Whether only what is new or worse than in a baseline counts.
    pub fn is_of_news(self) -> bool {
        matches!(self, FailOn::New | FailOn::NewWarn)
    }

    /// The states that count as failing: of checks, or of what is new or worse.
    pub fn failing(self) -> &'static [State] {
        match self {
            FailOn::Never => &[],
            FailOn::Fail | FailOn::New => &[State::Fail],
            FailOn::Warn | FailOn::NewWarn => &[State::Fail, State::Warn, State::Undecided],
            FailOn::Undecided => &[State::Fail, State::Undecided],
        }
    }

    /// Exit code of a report that may have been compared with a baseline.
    pub fn exit_code(self, report: &Report, comparison: Option<&Comparison>) -> u8 {
        match (report.verdict, self) {
            (_, FailOn::Never) => 0,
            (_, FailOn::New | FailOn::NewWarn) => self.exit_code_of_news(comparison.and_then(Comparison::worst_news)),
            (Verdict::Fail, _) => 1,
            (Verdict::Undecided, FailOn::Undecided | FailOn::Warn) => 1,
            (Verdict::Undecided, _) => 3,
            (Verdict::Warn, FailOn::Warn) => 1,
            (_, FailOn::Undecided) => u8::from(report.undecided() > 0),
            _ => 0,
        }
    }

    /// Exit code of the worst state of what is new or worse.
    fn exit_code_of_news(self, worst: Option<State>) -> u8 {
        match worst {
            Some(state) if self.failing().contains(&state) => 1,
            Some(State::Undecided) => 3,
            _ => 0,
        }
    }

    /// Exit code of a comparison of two reports.
    pub fn exit_code_of_comparison(comparison: &Comparison) -> u8 {
        FailOn::New.exit_code_of_news(comparison.worst_news())
    }
}
