//! The verdict as a banner, and the four answers.

use super::page::Context;
use crate::check::{Basis, State};
use crate::report::markup::{Markup, markup};
use crate::report::phrase::{self, Numbered};
use crate::report::schema::Verdict;
use crate::units::{short, told};

/// Glyph, verdict, counts; then number, consequence and remedy as one sentence.
pub fn banner(c: &Context) -> Markup {
    let state = phrase::verdict_state(c.report.verdict);
    let counts: Vec<String> = phrase::counts(c.report).into_iter().map(|(_, _, words)| words).collect();
    let since = c.report.baseline.as_ref().map_or(Markup::default(), |b| {
        let otherwise = if b.judged_otherwise.is_empty() { "" } else { "; judged otherwise" };
        let unknown = match b.not_compared.join(", ") {
            list if list.is_empty() => list,
            list => format!("; not compared, since the baseline did not run them: {list}"),
        };
        markup!("<p>Against the baseline: {}{}{}</p>", b.words, otherwise, unknown)
    });
    markup!(
        "<section class=\"banner {}\" aria-label=\"Verdict\"><h1><span class=\"state {}\"><span aria-hidden=\"true\">{}</span> {}</span> \
         <span class=\"counts\">{}</span></h1><p>{}</p>{}</section>\n",
        state.word(),
        state.word(),
        state.glyph(),
        phrase::headline(c.report.verdict),
        counts.join(" · "),
        c.report.summary,
        since
    )
}

/// The four questions somebody has before printing, each with an answer and what it rests on.
pub fn answers(c: &Context) -> Markup {
    let one = |question: &'static str, [answer, ground]: [String; 2]| {
        markup!("<div class=\"answer\"><h2>{}</h2><p class=\"big\">{}</p><p>{}</p></div>", question, answer, ground)
    };
    markup!(
        "<section class=\"answers\" aria-label=\"Four answers\">{}{}{}{}</section>\n",
        one("Can it be made?", can_it(c)),
        one("Where not?", where_not(c)),
        one("How sure is that?", how_sure(c)),
        one("What should change?", what_changes(c))
    )
}

fn can_it(c: &Context) -> [String; 2] {
    let answer = match c.report.verdict {
        Verdict::Pass => "Yes",
        Verdict::Warn => "Yes, with warnings",
        Verdict::Undecided => "Cannot tell yet",
        Verdict::Fail => "Not as it is",
    };
    let failing = names(c, State::Fail);
    let ground = if !failing.is_empty() {
        format!("fails: {}", failing.join(", "))
    } else {
        let (ran, all) = (ran(c), c.report.checks.len());
        format!("{} of {all} checks ran, {} pass", ran, c.report.count(State::Pass))
    };
    [answer.into(), ground]
}

fn where_not(c: &Context) -> [String; 2] {
    let Some(first) = c.worst() else {
        return ["Nowhere that was looked at".into(), "no finding that counts in the checks that ran".into()];
    };
    let part = &c.report.part;
    let place = phrase::whereabouts(part.posed(first.finding.at_mm), part.posed_box());
    let at = format!("{} at {} mm", first.check.name, phrase::point(first.finding.at_mm));
    let others = c.findings.iter().filter(|n| n.finding.counts()).count() - 1;
    let rest = match others {
        0 => "the only finding".into(),
        1 => "and 1 more finding".into(),
        n => format!("and {n} more findings; pins show them"),
    };
    [phrase::sentence(&place), format!("{at}, {rest}")]
}

fn how_sure(c: &Context) -> [String; 2] {
    let answer = c.worst().map_or_else(|| "Every pass is covered".into(), known);
    let decided = c.report.checks.iter().filter(|k| k.is_decided()).count();
    let asked = c.report.checks.len() - c.report.count(State::NotApplicable);
    let mut ground = match decided == asked {
        true => format!("all {asked} verdicts are decided"),
        false => format!("{decided} of {asked} verdicts are decided"),
    };
    let estimated = c.findings.iter().filter(|n| n.finding.counts() && n.finding.basis == Basis::Estimated).count();
    if estimated > 0 {
        ground.push_str(&format!(
            ", {estimated} {} estimated",
            if estimated == 1 { "finding is" } else { "findings are" }
        ));
    }
    let count = |state| c.report.count(state);
    let undecided = count(State::Undecided);
    let left = [
        (undecided, "undecided"),
        (c.report.undecided().saturating_sub(undecided), "of the warnings may be none"),
        (count(State::NotRun), "not run"),
        (count(State::Error), "broke down"),
    ];
    for (n, words) in left.into_iter().filter(|l| l.0 > 0) {
        ground.push_str(&format!(", {n} {words}"));
    }
    [answer, ground]
}

/// How well the value of a finding is known: `0.45 mm ± 0.0001 mm, certified`.
fn known(n: &Numbered) -> String {
    let f = n.finding;
    let half = 0.5 * (f.high - f.low);
    // What is up to half as far again on one side as on the mean is said by its far end; more than that by both.
    let value = told(f.value, f.low, f.high);
    let far = (f.high - value).max(value - f.low);
    match f.basis {
        Basis::Estimated => format!("{}, estimated", n.measured()),
        Basis::Exact => {
            let bracket = n.bracket().map_or(String::new(), |b| format!(" ({b})"));
            format!("{}{bracket}, exact", n.measured())
        }
        Basis::Certified if half < 1e-6 => format!("{}, certified", n.measured()),
        Basis::Certified if far > 1.5 * half => {
            let ends = phrase::bracket(f.low, f.high).unwrap_or_default().replace('–', " to ");
            format!("{ends} {}, certified", phrase::unit_sign(&f.unit))
        }
        Basis::Certified => {
            // One digit, rounded up: the claim stays true.
            let step = 10f64.powf(far.log10().floor());
            let far = (far / step - 1e-6).ceil() * step;
            format!("{} ± {}, certified", n.measured(), phrase::quantity(far, &f.unit))
        }
    }
}

fn what_changes(c: &Context) -> [String; 2] {
    let mut fixes = c.findings.iter().filter(|n| n.finding.counts() && !n.finding.fix.is_empty());
    let Some(first) = fixes.next() else {
        return ["Nothing".into(), "no check asks for a change".into()];
    };
    // Then what another check asks for: the same change at another place is no news.
    let other = fixes.find(|n| n.check.name != first.check.name);
    let then = other.map_or("no other check asks for a change".into(), |n| {
        format!("then, for {}: {}", n.check.name, n.finding.fix)
    });
    // What else it clears stands in its card.
    let change = first.finding.fix.split("; ").next().unwrap_or_default();
    [phrase::sentence(change), then]
}

/// Names of the checks in a state.
fn names(c: &Context, state: State) -> Vec<String> {
    c.report.checks.iter().filter(|k| k.state == state).map(|k| k.name.clone()).collect()
}

/// How many checks gave an answer.
fn ran(c: &Context) -> String {
    let ran =
        c.report.checks.iter().filter(|k| !matches!(k.state, State::NotRun | State::NotApplicable | State::Error));
    short(ran.count() as f64)
}
