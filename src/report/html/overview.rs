//! All checks in one table, worst first: state, worst value, limits, margin, findings.

use super::page::{Context, state_tag};
use crate::check::{Basis, State};
use crate::report::markup::{Markup, markup};
use crate::report::phrase::{self, Numbered};
use crate::report::schema::CheckReport;

/// The table; a row leads to the card of its check.
pub fn table(c: &Context) -> Markup {
    let mut checks: Vec<&CheckReport> = c.report.checks.iter().collect();
    checks.sort_by_key(|k| rank(k.state));
    let rows = Markup::all(checks.iter().map(|k| row(c, k)));
    markup!(
        "<section aria-label=\"All checks\"><h2>All {} checks</h2><div class=\"wide card\" tabindex=\"0\" role=\"group\" aria-label=\"Table of all checks\"><table class=\"checks\"><thead><tr><th scope=\"col\">State</th>\
         <th scope=\"col\">Check</th><th scope=\"col\">Worst value</th><th scope=\"col\">Limit</th><th scope=\"col\">Margin</th>\
         <th scope=\"col\">Findings</th></tr></thead><tbody>{}</tbody></table></div></section>\n",
        checks.len(),
        rows
    )
}

/// Worst first; what gave no answer stands behind what passes.
fn rank(state: State) -> usize {
    let order =
        [State::Fail, State::Error, State::Undecided, State::Warn, State::Pass, State::NotRun, State::NotApplicable];
    order.iter().position(|s| *s == state).unwrap_or(order.len())
}

fn row(c: &Context, k: &CheckReport) -> Markup {
    let own: Vec<&Numbered> = c.findings.iter().filter(|n| n.check.name == k.name).collect();
    let worst = own.iter().find(|n| n.finding.counts());
    // A check with a card leads to it; one that gave no answer has none.
    let name = match k.state {
        State::NotRun | State::NotApplicable => markup!("{}", k.title),
        _ => markup!("<a href=\"#check-{}\">{}</a>", k.name, k.title),
    };
    let (value, limit, margin) = match (worst, &k.worst, &k.limit) {
        _ if k.why.is_some() && worst.is_none() => return unanswered(k, name),
        (Some(n), _, _) => {
            let f = n.finding;
            let margin =
                phrase::deciding_limit(f).map_or(String::new(), |(_, l)| phrase::margin(f.value, l, f.sense, &f.unit));
            (with_bracket(n), phrase::limits(f.fail, f.warn, f.sense, &f.unit), margin)
        }
        (None, Some(w), Some(l)) => {
            let margin = l.warn.or(l.fail).map_or(String::new(), |x| phrase::margin(w.value, x, l.sense, &l.unit));
            let value = phrase::measured(w.value, w.low, w.high, &w.unit);
            (value, phrase::limits(l.fail, l.warn, l.sense, &l.unit), margin)
        }
        (None, Some(w), None) => (phrase::measured(w.value, w.low, w.high, &w.unit), String::new(), String::new()),
        (None, None, _) => ("–".into(), String::new(), String::new()),
    };
    let pins =
        Markup::all(own.iter().take(6).map(|n| {
            markup!("<a href=\"#{}\" class=\"pin {}\">{}</a> ", n.anchor(), super::stage::class(n), n.number)
        }));
    let more = match own.len().saturating_sub(6) {
        0 => Markup::default(),
        n => markup!("<span class=\"dim\">+ {}</span>", n),
    };
    markup!(
        "<tr class=\"{}\"><td>{}</td><th scope=\"row\">{} <span class=\"dim\">{}</span></th><td>{}</td><td>{}</td><td>{}</td><td class=\"pinrow\">{}{}</td></tr>",
        k.state.word(),
        state_tag(k.state),
        name,
        k.name,
        value,
        limit,
        margin,
        pins,
        more
    )
}

/// A check without an answer: why.
fn unanswered(k: &CheckReport, name: Markup) -> Markup {
    markup!(
        "<tr class=\"{}\"><td>{}</td><th scope=\"row\">{} <span class=\"dim\">{}</span></th><td colspan=\"4\" class=\"why\">{}</td></tr>",
        k.state.word(),
        state_tag(k.state),
        name,
        k.name,
        k.why.clone().unwrap_or_default()
    )
}

/// `0.45 mm (0.44–0.46)`, and whether it is an estimate.
fn with_bracket(n: &Numbered) -> String {
    let f = n.finding;
    let bracket = n.bracket().map_or(String::new(), |b| format!(" ({b})"));
    let basis = if f.basis == Basis::Estimated { ", estimated" } else { "" };
    format!("{}{bracket}{basis}", n.measured())
}
