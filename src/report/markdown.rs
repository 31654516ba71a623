//! The report as Markdown for a job summary or a comment: short, escaped, and within the limits of such places.

use super::baseline::Comparison;
use super::phrase::{self, Numbered};
use super::schema::Report;
use crate::check::State;

/// Most rows of a table; a comment may have 64 kB.
const ROWS: usize = 40;

/// Verdict, findings worst first, what passed, what did not run, and what changed since a baseline.
///
/// Texts from files are escaped, so that they are never markup, links or mentions. Ends with a line feed; stays below
/// 64 kB.
pub fn write(report: &Report, comparison: Option<&Comparison>) -> String {
    let state = phrase::verdict_state(report.verdict);
    let counts: Vec<String> = phrase::counts(report).into_iter().map(|(_, _, words)| words).collect();
    let mut out = format!(
        "### {} {}: {}\n\n{}\n\n{} · {}\n",
        state.glyph(),
        phrase::headline(report.verdict),
        escaped(&report.part.file),
        escaped(&report.summary),
        counts.join(" · "),
        escaped(&format!("process {}, grid {}", report.process.name, phrase::quantity(report.grid.spacing_mm, "mm")))
    );
    let findings = phrase::numbered(report);
    if !findings.is_empty() {
        out.push_str("\n| | Check | Value | Limit | Place (mm) | Change |\n|---|---|---|---|---|---|\n");
        findings.iter().take(ROWS).for_each(|n| out.push_str(&row(n)));
        if findings.len() > ROWS {
            out.push_str(&format!("\n{} more stand in the report.\n", findings.len() - ROWS));
        }
    }
    if let Some(c) = comparison {
        out.push_str(&changes(c));
    }
    out.push_str(&others(report));
    out
}

fn row(n: &Numbered) -> String {
    let f = n.finding;
    let bracket = n.bracket().map_or(String::new(), |b| format!(" ({b})"));
    let count = if f.count > 1 { format!(" and {} more", f.count - 1) } else { String::new() };
    format!(
        "| {} | {} | {}{bracket} | {} | {}{count} | {} |\n",
        if f.accepted.is_some() { "–" } else { f.state.glyph() },
        escaped(&n.check.name),
        n.measured(),
        phrase::deciding(f),
        phrase::point(f.at_mm),
        match phrase::acceptance(f) {
            Some(said) if f.accepted.is_some() => format!("_{}_", escaped(&cut(&said))),
            Some(said) => escaped(&cut(&format!("{said}; {}", f.fix))),
            None => escaped(&cut(&f.fix)),
        }
    )
}

/// The part about the baseline.
fn changes(c: &Comparison) -> String {
    let mut out = format!("\n**Against the baseline:** {}\n", c.words());
    for said in &c.conditions {
        out.push_str(&format!("\nJudged otherwise: {}\n", escaped(said)));
    }
    out.extend(c.not_compared_words().map(|said| format!("\n{}\n", escaped(&phrase::sentence(&said)))));
    out.extend(c.bodies_words().map(|said| format!("\n{}\n", phrase::sentence(&said))));
    let moved: Vec<_> = c.changes.iter().filter(|c| c.is_told()).collect();
    if !moved.is_empty() {
        out.push_str("\n| | Check | Value |\n|---|---|---|\n");
        for c in moved.iter().take(ROWS) {
            out.push_str(&format!("| {} | {} | {} |\n", c.delta.word(), escaped(&c.check), c.words()));
        }
    }
    out
}

/// Passes and what gave no answer, folded.
fn others(report: &Report) -> String {
    let line = |state: State| -> Vec<String> {
        let of = report.checks.iter().filter(|c| c.state == state);
        of.map(|c| match (&c.worst, &c.why) {
            (_, Some(why)) => format!("- {} {}: {}\n", state.glyph(), escaped(&c.name), escaped(&cut(why))),
            (Some(w), _) => {
                let value = phrase::measured(w.value, w.low, w.high, &w.unit);
                format!("- {} {}: {value}\n", state.glyph(), escaped(&c.name))
            }
            _ => format!("- {} {}\n", state.glyph(), escaped(&c.name)),
        })
        .collect()
    };
    let states = [State::Error, State::Pass, State::NotRun, State::NotApplicable];
    let lines: Vec<String> = states.into_iter().flat_map(line).collect();
    if lines.is_empty() {
        return String::new();
    }
    format!(
        "\n<details><summary>The other {}</summary>\n\n{}\n</details>\n",
        match lines.len() {
            1 => "check".into(),
            n => format!("{n} checks"),
        },
        lines.concat()
    )
}

/// A text of at most 300 characters.
fn cut(text: &str) -> String {
    if text.chars().count() <= 300 { text.into() } else { text.chars().take(299).chain(['…']).collect() }
}

/// A text that Markdown shows as it is.
///
/// ```
/// assert_eq!(amcheck::report::markdown::escaped("a|b_<i>@x"), "a\\|b\\_&lt;i&gt;&#64;x");
/// ```
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '@' => out.push_str("&#64;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '#' | '|' | '~' | '!' | '$' => out.extend(['\\', c]),
            // A colon and slashes make a bare address a link.
            ':' => out.push_str("&#58;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
