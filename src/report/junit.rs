//! The report as JUnit XML: one test case for each check.

use super::markup::{Markup, markup};
use super::phrase::{self, Numbered};
use super::schema::{CheckReport, Report};
use crate::check::State;

/// The report as JUnit XML, with what counts as failing beside a check that fails: warnings, or what is undecided.
///
/// A check that counts as failing is a failure; undecided, not run and not applicable are skipped with the reason, and so is one
/// whose findings are all accepted; one that broke
/// down is an error; a warning passes and says what it found in `system-out`. No times: the same input gives the same
/// bytes.
pub fn write(report: &Report, failing: &[State]) -> String {
    let findings = phrase::numbered(report);
    let cases: Vec<Case> = report.checks.iter().map(|c| Case::of(c, failing)).collect();
    let count = |case: Case| cases.iter().filter(|c| **c == case).count();
    let [failures, errors, skipped] = [Case::Failure, Case::Error, Case::Skipped].map(count);
    let cases = Markup::all(report.checks.iter().zip(&cases).map(|(c, told)| case(report, c, *told, &findings)));
    markup!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"amcheck\" tests=\"{}\" failures=\"{}\" errors=\"{}\">\n\
         <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\">\n{}</testsuite>\n</testsuites>\n",
        report.checks.len(),
        failures,
        errors,
        report.part.file,
        report.checks.len(),
        failures,
        errors,
        skipped,
        cases
    )
    .into_string()
}

/// What a check is as a test case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Case {
    Passed,
    Failure,
    Error,
    Skipped,
}

impl Case {
    fn of(c: &CheckReport, failing: &[State]) -> Self {
        let counts_as_failing = failing.contains(&c.state)
            || failing.contains(&State::Undecided) && c.state == State::Warn && !c.is_decided();
        match c.state {
            State::Fail => Case::Failure,
            State::Error => Case::Error,
            _ if counts_as_failing => Case::Failure,
            State::Pass if only_accepted(c) => Case::Skipped,
            State::Pass | State::Warn => Case::Passed,
            State::Undecided | State::NotRun | State::NotApplicable => Case::Skipped,
        }
    }
}

/// Whether a check would not pass but for what somebody accepts.
fn only_accepted(c: &CheckReport) -> bool {
    c.state == State::Pass && c.findings.iter().any(|f| f.accepted.is_some())
}

fn case(report: &Report, c: &CheckReport, told: Case, findings: &[Numbered]) -> Markup {
    let own: Vec<String> = findings.iter().filter(|n| n.check.name == c.name).map(line).collect();
    let first = own.first().cloned().unwrap_or_default();
    let why = c.why.clone().unwrap_or_else(|| first.clone());
    let body = match (told, c.state) {
        (Case::Failure, _) => {
            markup!("<failure message=\"{}\" type=\"{}\">{}</failure>", first, c.code, own.join("\n"))
        }
        (Case::Error, _) => markup!("<error message=\"{}\" type=\"{}\"/>", why, c.code),
        (Case::Passed, State::Warn) => markup!("<system-out>{}</system-out>", own.join("\n")),
        (Case::Passed, _) => Markup::default(),
        (Case::Skipped, State::Undecided) => markup!("<skipped message=\"{}\"/>", format!("undecided: {first}")),
        (Case::Skipped, State::NotRun) => markup!("<skipped message=\"{}\"/>", format!("not run: {why}")),
        (Case::Skipped, State::NotApplicable) => {
            markup!("<skipped message=\"{}\"/>", format!("not applicable: {why}"))
        }
        (Case::Skipped, _) => markup!("<skipped message=\"{}\"/>", own.join("\n")),
    };
    markup!("<testcase classname=\"amcheck.{}\" name=\"{}\">{}</testcase>\n", report.part.file, c.name, body)
}

/// A finding as one line: the same words as on the terminal.
fn line(n: &Numbered) -> String {
    let f = n.finding;
    let bracket = phrase::bracket(f.low, f.high).map_or(String::new(), |b| format!(" ({b})"));
    let held = phrase::acceptance(f).map_or(String::new(), |a| format!(" ({a})"));
    format!(
        "{} {}[{}] {}{bracket}, {}, at {} mm: {} {}{held}",
        if f.accepted.is_some() { "–" } else { f.state.glyph() },
        n.check.name,
        n.within,
        n.measured(),
        phrase::deciding(f),
        phrase::point(f.at_mm),
        f.message,
        f.fix
    )
}
