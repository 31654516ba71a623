//! What the checks come to: the verdict, and the sentence that says it.

use super::phrase;
use super::schema::{CheckReport, Report, Verdict};
use crate::check::{Sense, State};

/// The worst state of all checks; one that broke down leaves the part undecided, and so does it that none came to an end.
pub fn verdict_of(checks: &[CheckReport]) -> Verdict {
    let verdict = |c: &CheckReport| match c.state {
        State::Fail => Some(Verdict::Fail),
        State::Undecided | State::Error => Some(Verdict::Undecided),
        State::Warn => Some(Verdict::Warn),
        State::Pass => Some(Verdict::Pass),
        State::NotRun | State::NotApplicable => None,
    };
    checks.iter().filter_map(verdict).max().unwrap_or(Verdict::Undecided)
}

/// The verdict as a sentence: number, consequence, remedy; and how many findings follow it.
pub fn sentence(report: &Report) -> String {
    let more = match report.findings().iter().filter(|f| f.counts()).count() {
        0 | 1 => String::new(),
        2 => " 1 more finding is below.".into(),
        n => format!(" {} more findings are below.", n - 1),
    };
    said(report, &more)
}

/// The verdict as a sentence that stands alone, as in a table of parts.
pub fn alone(report: &Report) -> String {
    said(report, "")
}

/// The verdict as a sentence, with what is to be said behind the worst finding.
fn said(report: &Report, more: &str) -> String {
    let mut findings = report.findings();
    let all = findings.len();
    findings.retain(|f| f.counts());
    let accepted = match all - findings.len() {
        0 => String::new(),
        1 => " 1 finding is accepted.".into(),
        n => format!(" {n} findings are accepted."),
    };
    let ran = report
        .checks
        .iter()
        .filter(|c| !matches!(c.state, State::NotRun | State::NotApplicable | State::Error))
        .count();
    let Some(worst) = findings.first() else {
        let but = if accepted.is_empty() { "" } else { " but for what is accepted" };
        let passing = match ran {
            0 => "No check came to an end".into(),
            1 => "The 1 check that ran passes".into(),
            _ => format!("All {ran} checks that ran pass"),
        };
        return format!("{passing}{but}, for {}.{accepted}", report.process.name);
    };
    let needed = match (worst.state, worst.fail, worst.warn) {
        (State::Fail | State::Undecided, Some(limit), _) => needed(worst.sense, limit, &worst.unit, "must"),
        (_, _, Some(limit)) => needed(worst.sense, limit, &worst.unit, "should"),
        _ => String::new(),
    };
    format!("{}{needed}: {}.{more}{accepted}", phrase::sentence(&worst.message), worst.fix)
}

fn needed(sense: Sense, limit: f64, unit: &str, word: &str) -> String {
    let sign = if sense == Sense::Min { "at least" } else { "at most" };
    match unit {
        // That there should be none is plain.
        _ if limit == 0.0 => String::new(),
        unit => format!(" ({word} be {sign} {})", phrase::quantity(limit, unit)),
    }
}
