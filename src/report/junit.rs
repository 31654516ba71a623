//! The report as JUnit XML: one test case for each check.

use super::baseline::{self, Change, Comparison, Delta};
use super::markup::{Markup, markup};
use super::phrase::{self, Numbered};
use super::schema::{CheckReport, Report};
use crate::check::State;
use crate::error::Error;

/// The report as JUnit XML, with the states that count as failing. With a comparison only what is new or worse counts.
///
/// A check that counts as failing is a failure; undecided, not run and not applicable are skipped with the reason, and so is one
/// whose findings are all accepted; one that broke
/// down is an error, whatever counts. What warns or fails and does not count passes, and says what it found in `system-out`. Beside a comparison a check that
/// fails by what the baseline had as well is skipped, and every finding says whether it was there before. No times: the same input gives the same bytes.
pub fn write(report: &Report, failing: &[State], since: Option<&Comparison>) -> String {
    let findings = phrase::numbered(report);
    let counting = Counting { failing, since };
    let cases: Vec<Case> = report.checks.iter().map(|c| Case::of(c, &counting)).collect();
    let count = |case: Case| cases.iter().filter(|c| **c == case).count();
    let [failures, errors, skipped] = [Case::Failure, Case::Error, Case::Skipped].map(count);
    let cases =
        Markup::all(report.checks.iter().zip(&cases).map(|(c, told)| case(report, c, *told, (&findings, &counting))));
    suite(&report.part.file, [report.checks.len(), failures, errors, skipped], cases)
}

/// Of a part of a name that was refused: one test case, which is an error, so that it is missing nowhere.
pub fn refused(name: &str, error: &Error) -> String {
    let place = error.place().map_or(String::new(), |place| format!(" ({place})"));
    let case = markup!(
        "<testcase classname=\"amcheck.{}\" name=\"judged\"><error message=\"{}\" type=\"{}\">{}</error></testcase>\n",
        name,
        format!("{error}{place}"),
        error.code(),
        error.remedy()
    );
    suite(name, [1, 0, 1, 0], case)
}

/// The suite of a part: tests, failures, errors and what was skipped, and its test cases.
fn suite(name: &str, [tests, failures, errors, skipped]: [usize; 4], cases: Markup) -> String {
    markup!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"amcheck\" tests=\"{}\" failures=\"{}\" errors=\"{}\">\n\
         <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\">\n{}</testsuite>\n</testsuites>\n",
        tests,
        failures,
        errors,
        name,
        tests,
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

/// What counts as a failure.
struct Counting<'a> {
    /// The states that count.
    failing: &'a [State],
    /// With a comparison only what is news.
    since: Option<&'a Comparison>,
}

impl Counting<'_> {
    fn is_failing(&self, c: &CheckReport) -> bool {
        match self.since {
            Some(_) => self.news(c).next().is_some(),
            None => {
                let open = c.state == State::Warn && !c.is_decided();
                self.has(c.state) || open && self.failing.contains(&State::Undecided)
            }
        }
    }

    fn has(&self, state: State) -> bool {
        self.failing.contains(&state)
    }

    /// What of a check is new or worse, and counts.
    fn news<'s>(&'s self, c: &'s CheckReport) -> impl Iterator<Item = &'s Change> {
        let all = self.since.into_iter().flat_map(|s| &s.changes);
        all.filter(|change| change.check == c.name && change.news().is_some_and(|state| self.has(state)))
    }

    /// The findings of a check as lines, what counts as news first; beside a comparison each with what it was before.
    fn lines(&self, c: &CheckReport, findings: &[Numbered]) -> Vec<String> {
        let joined = self.news(c).filter(|change| change.new.is_none());
        let joined = joined.map(|change| format!("{}: {}", change.delta.word(), baseline::from_to(change)));
        let mut own: Vec<(bool, String)> =
            findings.iter().filter(|n| n.check.name == c.name).map(|n| self.line(n)).collect();
        own.sort_by_key(|(is_news, _)| !is_news);
        joined.chain(own.into_iter().map(|(_, line)| line)).collect()
    }

    /// A finding as a line, and whether it counts as news.
    fn line(&self, n: &Numbered) -> (bool, String) {
        let change = self.since.and_then(|s| s.of(n.finding));
        let is_news = change.and_then(Change::news).is_some_and(|state| self.has(state));
        (is_news, change.map(before).unwrap_or_default() + &line(n))
    }
}

/// What a line says first: what its finding was in the baseline.
fn before(change: &Change) -> String {
    let was = match (change.delta, change.withdrawn()) {
        (Delta::New | Delta::Worse, None) => change.delta.word().to_string(),
        (Delta::New | Delta::Worse, Some(said)) => format!("{}, {said}", change.delta.word()),
        (Delta::Unchecked, _) => "not compared, the baseline did not run this check".to_string(),
        (_, said) => said.unwrap_or("was there before").to_string(),
    };
    was + ": "
}

impl Case {
    fn of(c: &CheckReport, counting: &Counting) -> Self {
        match c.state {
            State::Error => Case::Error,
            _ if counting.is_failing(c) => Case::Failure,
            State::Fail if counting.since.is_some() => Case::Skipped,
            State::Pass if only_accepted(c) => Case::Skipped,
            State::Fail | State::Pass | State::Warn => Case::Passed,
            State::Undecided | State::NotRun | State::NotApplicable => Case::Skipped,
        }
    }
}

/// Whether a check would not pass but for what somebody accepts.
fn only_accepted(c: &CheckReport) -> bool {
    c.state == State::Pass && c.findings.iter().any(|f| f.accepted.is_some())
}

fn case(report: &Report, c: &CheckReport, told: Case, (findings, counting): (&[Numbered], &Counting)) -> Markup {
    let own = counting.lines(c, findings);
    let first = own.first().cloned().unwrap_or_default();
    let why = c.why.clone().unwrap_or_else(|| first.clone());
    let body = match (told, c.state) {
        (Case::Failure, _) => {
            markup!("<failure message=\"{}\" type=\"{}\">{}</failure>", first, c.code, own.join("\n"))
        }
        (Case::Error, _) => markup!("<error message=\"{}\" type=\"{}\"/>", why, c.code),
        (Case::Passed, State::Fail | State::Warn) => markup!("<system-out>{}</system-out>", own.join("\n")),
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
    let bracket = n.bracket().map_or(String::new(), |b| format!(" ({b})"));
    let held = phrase::acceptance(f).map_or(String::new(), |a| format!(" ({a})"));
    format!(
        "{} {}[{}] {}{bracket}, {}, at {} mm: {}{held}",
        if f.accepted.is_some() { "–" } else { f.state.glyph() },
        n.check.name,
        n.within,
        n.measured(),
        phrase::deciding(f),
        phrase::point(f.at_mm),
        phrase::sentences([f.message.as_str(), &f.fix])
    )
}
