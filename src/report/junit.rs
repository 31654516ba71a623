//! The report as JUnit XML: one test case for each check.

use super::markup::{Markup, markup};
use super::phrase::{self, Numbered};
use super::schema::{CheckReport, Report};
use crate::check::State;

/// The report as JUnit XML.
///
/// A check that fails is a failure; undecided, not run and not applicable are skipped with the reason, and so is one
/// whose findings are all accepted; one that broke
/// down is an error; a warning passes and says what it found in `system-out`. No times: the same input gives the same
/// bytes.
pub fn write(report: &Report) -> String {
    let findings = phrase::numbered(report);
    let count = |states: &[State]| states.iter().map(|s| report.count(*s)).sum::<usize>();
    let skipped = count(&[State::Undecided, State::NotRun, State::NotApplicable])
        + report.checks.iter().filter(|c| only_accepted(c)).count();
    let cases = Markup::all(report.checks.iter().map(|c| case(report, c, &findings)));
    markup!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"amcheck\" tests=\"{}\" failures=\"{}\" errors=\"{}\">\n\
         <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\">\n{}</testsuite>\n</testsuites>\n",
        report.checks.len(),
        count(&[State::Fail]),
        count(&[State::Error]),
        report.part.file,
        report.checks.len(),
        count(&[State::Fail]),
        count(&[State::Error]),
        skipped,
        cases
    )
    .into_string()
}

/// Whether a check would not pass but for what somebody accepts.
fn only_accepted(c: &CheckReport) -> bool {
    c.state == State::Pass && c.findings.iter().any(|f| f.accepted.is_some())
}

fn case(report: &Report, c: &CheckReport, findings: &[Numbered]) -> Markup {
    let own: Vec<String> = findings.iter().filter(|n| n.check.name == c.name).map(line).collect();
    let first = own.first().cloned().unwrap_or_default();
    let why = c.why.clone().unwrap_or_else(|| first.clone());
    let body = match c.state {
        State::Pass if only_accepted(c) => {
            markup!("<skipped message=\"{}\"/>", own.join("\n"))
        }
        State::Pass => Markup::default(),
        State::Warn => markup!("<system-out>{}</system-out>", own.join("\n")),
        State::Fail => markup!("<failure message=\"{}\" type=\"{}\">{}</failure>", first, c.code, own.join("\n")),
        State::Error => markup!("<error message=\"{}\" type=\"{}\"/>", why, c.code),
        State::Undecided => markup!("<skipped message=\"{}\"/>", format!("undecided: {first}")),
        State::NotRun => markup!("<skipped message=\"{}\"/>", format!("not run: {why}")),
        State::NotApplicable => markup!("<skipped message=\"{}\"/>", format!("not applicable: {why}")),
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
