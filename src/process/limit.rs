//! One limit of a process.

use serde::{Deserialize, Serialize};

/// The source of a limit that was typed.
pub(super) const TYPED: &str = "command line";

/// Where a limit comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LimitBasis {
    /// Published by the sources that stand beside it.
    Sourced,
    /// Ours, with its reason; it warns and never fails.
    Convention,
    /// The user's own.
    User,
}

impl LimitBasis {
    /// The word for it in files.
    pub fn word(self) -> &'static str {
        match self {
            LimitBasis::Sourced => "sourced",
            LimitBasis::Convention => "convention",
            LimitBasis::User => "user",
        }
    }
}

/// A fail and a warn limit in the unit of their rule.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    pub fail: Option<f64>,
    pub warn: Option<f64>,
    pub basis: LimitBasis,
    /// The sources, or the reason of a convention.
    pub source: String,
    /// Whether the command line or the user's file put it in place of a built-in one.
    pub overridden: bool,
}

impl Limit {
    /// Whether it was typed, and stands in no file.
    pub fn is_typed(&self) -> bool {
        self.overridden && self.source == TYPED
    }

    /// The same limit as it may be applied: a convention's fail limit only warns.
    pub fn applied(&self) -> Self {
        match self.basis {
            LimitBasis::Convention => Limit { fail: None, warn: self.warn.or(self.fail), ..self.clone() },
            _ => self.clone(),
        }
    }
}
