//! A card for each check: state, gauge, value and bracket, limits and their source, margin, place, fix.

use super::page::{Context, state_tag};
use super::stage::class;
use crate::check::{Basis, Sense, State, registry};
use crate::report::chart::{self, Gauge};
use crate::report::markup::{Markup, markup};
use crate::report::phrase::{self, Numbered};
use crate::report::schema::{CheckReport, LimitReport};
use crate::units::short;

/// Most rows in the table of a card.
const ROWS: usize = 100;

/// Cards of what needs attention, worst first; then the passes and what did not run, folded but present.
pub fn section(c: &Context) -> Markup {
    let mut open: Vec<&CheckReport> = c.report.checks.iter().filter(|k| attention(k.state)).collect();
    open.sort_by_key(|k| std::cmp::Reverse(k.state));
    let cards = Markup::all(open.iter().map(|k| card(c, k)));
    let nothing = if open.is_empty() {
        Markup::raw("<p class=\"note\">Every check that ran passes.</p>")
    } else {
        Markup::default()
    };
    markup!(
        "<section id=\"checks\" aria-label=\"Checks\"><h2>Checks</h2>{}<div class=\"cards\">{}</div>{}{}</section>\n",
        nothing,
        cards,
        passes(c),
        silent(c)
    )
}

fn attention(state: State) -> bool {
    matches!(state, State::Fail | State::Undecided | State::Warn | State::Error)
}

fn passes(c: &Context) -> Markup {
    let passing: Vec<&CheckReport> = c.report.checks.iter().filter(|k| k.state == State::Pass).collect();
    if passing.is_empty() {
        return Markup::default();
    }
    let names: Vec<&str> = passing.iter().map(|k| k.name.as_str()).collect();
    markup!(
        "<details class=\"fold\"><summary>{} {} <span class=\"dim\">{}</span></summary><div class=\"cards\">{}</div></details>",
        state_tag(State::Pass),
        passing.len(),
        names.join(", "),
        Markup::all(passing.iter().map(|k| card(c, k)))
    )
}

/// What did not run and what does not apply, with the reason: never a pass.
fn silent(c: &Context) -> Markup {
    let rows = |state: State| {
        Markup::all(c.report.checks.iter().filter(|k| k.state == state).map(|k| {
            let why = k.why.clone().unwrap_or_else(|| "no reason given".into());
            markup!("<tr><td>{}</td><th scope=\"row\">{}</th><td>{}</td></tr>", state_tag(k.state), k.name, why)
        }))
    };
    let rows = Markup::all([rows(State::NotRun), rows(State::NotApplicable)]);
    if rows.is_empty() {
        return Markup::default();
    }
    markup!(
        "<h3>Said nothing about</h3><div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"Table\"><table class=\"plain\">{}</table></div>",
        rows
    )
}

fn card(c: &Context, k: &CheckReport) -> Markup {
    let findings: Vec<&Numbered> = c.findings.iter().filter(|n| n.check.name == k.name).collect();
    let first = findings.first().copied();
    let picture = match first {
        Some(n) => markup!("<figure class=\"close\">{}</figure>", c.image(&format!("close-{}", n.check.name))),
        None => Markup::default(),
    };
    let accepted = match phrase::accepted(k) {
        0 => Markup::default(),
        n => markup!(" <span class=\"dim\">{} accepted</span>", n),
    };
    markup!(
        "<article class=\"card {}\" id=\"check-{}\"><h3>{} {}{}</h3><p class=\"dim\">{} <code>{}</code></p>{}{}<dl>{}</dl>{}{}{}</article>",
        k.state.word(),
        k.name,
        k.title,
        state_tag(k.state),
        accepted,
        k.name,
        k.code,
        gauge(k, first),
        picture,
        facts(c, k, &findings),
        table(&findings),
        explained(k),
        acceptable(c, &findings)
    )
}

/// What, why, how, what it may miss and the source: the words of `amcheck explain`.
fn explained(k: &CheckReport) -> Markup {
    let Some(meta) = registry::metas().find(|m| m.code == k.code) else { return Markup::default() };
    let parts =
        [("What", meta.what), ("Why", meta.why), ("How", meta.how), ("Limits", meta.limits), ("Source", meta.source)];
    let rows =
        Markup::all(parts.map(|(head, text)| markup!("<div><dt>{}</dt><dd>{}</dd></div>", head, one_line(text))));
    markup!("<details class=\"aside\"><summary>What, why and how</summary><dl>{}</dl></details>", rows)
}

/// A text of the program without the line breaks of its source.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The entries by which somebody accepts findings that nobody accepts yet.
fn acceptable(c: &Context, findings: &[&Numbered]) -> Markup {
    let open: Vec<&Numbered> = findings.iter().copied().filter(|n| n.finding.accepted.is_none()).collect();
    let what = match open[..] {
        [] => return Markup::default(),
        [n] => format!("Accept finding {}", n.number),
        _ => "Accept a finding".into(),
    };
    let entries: Vec<String> = open.iter().take(ROWS).map(|n| entry(c, n)).collect();
    let more = match open.len().saturating_sub(ROWS) {
        0 => Markup::default(),
        left => markup!("<p class=\"note\">{} more are like these.</p>", left),
    };
    markup!(
        "<details class=\"aside\"><summary>{}</summary><p class=\"note\">In the process file, or in a file named by --accept:</p><pre tabindex=\"0\">{}</pre>{}</details>",
        what,
        entries.join("\n"),
        more
    )
}

/// The entry by which somebody accepts a finding.
fn entry(c: &Context, n: &Numbered) -> String {
    let f = n.finding;
    // As far as the place may move and still be the same place, and no worse than now.
    let within = (2.0 * c.report.grid.spacing_mm).max(0.1);
    let worst = if f.sense == Sense::Min { f.low } else { f.high };
    let place = if f.count == 1 {
        format!("at_mm = [{}]\nwithin_mm = {}", phrase::point(f.at_mm), short(within))
    } else {
        let corner = |p: [f64; 3], by: f64| p.map(|x| short(((x + by) * 100.0).round() / 100.0)).join(", ");
        format!("box_mm = [[{}], [{}]]", corner(f.box_mm[0], -within), corner(f.box_mm[1], within))
    };
    // Areas are told by facets and samples, which another export changes.
    let area =
        f.area_mm2.filter(|_| f.unit != "mm2").map(|area| format!("no_larger_than_mm2 = {}\n", short(1.5 * area)));
    format!(
        "[[accept]] # finding {}, {}\ncheck = \"{}\"\nkind = \"{}\"\n{place}\nno_worse_than = {worst}\n{}reason = \"…\" # and perhaps: until = 2027-12-31\n",
        n.number,
        n.measured(),
        n.check.name,
        f.kind,
        area.unwrap_or_default()
    )
}

/// The value that stands for the check: of its worst finding, else the worst value it met.
fn gauge(k: &CheckReport, first: Option<&Numbered>) -> Markup {
    let limits =
        |l: Option<&LimitReport>| (l.and_then(|l| l.fail), l.and_then(|l| l.warn), l.map_or(Sense::Min, |l| l.sense));
    match (first, &k.worst) {
        (Some(n), _) => {
            let f = n.finding;
            let (value, low, high, unit) = (f.value, f.low, f.high, f.unit.as_str());
            chart::gauge(&Gauge { value, low, high, fail: f.fail, warn: f.warn, sense: f.sense, unit })
        }
        (None, Some(w)) => {
            let (fail, warn, sense) = limits(k.limit.as_ref());
            chart::gauge(&Gauge { value: w.value, low: w.low, high: w.high, fail, warn, sense, unit: &w.unit })
        }
        (None, None) => Markup::default(),
    }
}

/// The rows of a card.
fn facts(c: &Context, k: &CheckReport, findings: &[&Numbered]) -> Markup {
    let mut rows: Vec<(&'static str, String)> = Vec::new();
    if let Some(n) = findings.first() {
        finding_rows(&mut rows, n);
    } else if let Some(w) = &k.worst {
        rows.push(("Worst", phrase::measured(w.value, w.low, w.high, &w.unit)));
        rows.extend(phrase::bracket(w.low, w.high).map(|b| ("Bracket", b)));
        if let Some(l) = &k.limit {
            rows.push(("Limit", phrase::limits(l.fail, l.warn, l.sense, &l.unit)));
            rows.extend(l.warn.or(l.fail).map(|x| ("Margin", phrase::margin(w.value, x, l.sense, &l.unit))));
        }
        rows.extend(w.at_mm.map(|p| ("Where", format!("{} mm", phrase::point(p)))));
    }
    let limit = findings.first().map_or(k.limit.as_ref(), |n| c.report.limit_of(k, n.finding));
    rows.extend(limit.map(|l| ("From", origin(l))));
    let places: u64 = findings.iter().map(|n| n.finding.count).sum();
    if places > 0 {
        rows.push(("Count", format!("{} in {}", places_word(places), findings_word(findings.len()))));
    }
    rows.extend(findings.first().map(|n| {
        (if n.finding.state == State::Undecided { "To decide" } else { "Fix" }, phrase::sentence(&n.finding.fix))
    }));
    rows.extend(k.cover.clone().map(|cover| ("Cover", cover)));
    rows.extend(k.refined.map(|looks| ("Refined", phrase::finer_looks(looks))));
    rows.extend(k.why.clone().map(|why| ("Why", why)));
    Markup::all(rows.into_iter().map(|(name, text)| markup!("<div><dt>{}</dt><dd>{}</dd></div>", name, text)))
}

fn finding_rows(rows: &mut Vec<(&'static str, String)>, n: &Numbered) {
    let f = n.finding;
    rows.push(("Worst", n.measured()));
    let bracket = n.bracket().map_or_else(String::new, |b| format!("{b}, "));
    rows.push(("Bracket", format!("{bracket}{}", phrase::known(f.basis))));
    if f.basis == Basis::Estimated {
        rows.push(("Basis", "An estimate: no bound is known, so it warns at most.".into()));
    }
    rows.push(("Limit", phrase::limits(f.fail, f.warn, f.sense, &f.unit)));
    let against = |word: &str, limit: Option<f64>| {
        limit.map(|l| format!("{} to {word}", phrase::margin(f.value, l, f.sense, &f.unit)))
    };
    let margins: Vec<String> = [against("must", f.fail), against("should", f.warn)].into_iter().flatten().collect();
    if !margins.is_empty() {
        rows.push(("Margin", margins.join("; ")));
    }
    let mut place = vec![format!("{} mm", phrase::point(f.at_mm))];
    place.extend(n.size());
    rows.push(("Where", place.join(" · ")));
}

/// Where a limit comes from.
fn origin(l: &LimitReport) -> String {
    let basis = match l.basis.as_str() {
        "sourced" => "source",
        "convention" => "convention",
        other => other,
    };
    let overridden = if l.overridden { " (overridden)" } else { "" };
    if l.source.is_empty() { format!("{basis}{overridden}") } else { format!("{basis}: {}{overridden}", l.source) }
}

fn places_word(n: u64) -> String {
    if n == 1 { "1 place".into() } else { format!("{} places", phrase::thousands(n)) }
}

fn findings_word(n: usize) -> String {
    if n == 1 { "1 finding".into() } else { format!("{n} findings") }
}

/// All findings of a check as a table, where there is more than one or one stands for several places.
fn table(findings: &[&Numbered]) -> Markup {
    let many = findings.len() > 1 || findings.iter().any(|n| n.finding.places.len() > 1);
    if !many {
        return Markup::default();
    }
    let row = |tag: Markup, value: String, bracket: Option<String>, at: [f64; 3]| {
        let bracket = bracket.unwrap_or_default();
        markup!("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>", tag, value, bracket, phrase::point(at))
    };
    let mut rows = Vec::new();
    for n in findings {
        let f = n.finding;
        let tag = markup!("<a href=\"#{}\" class=\"pin {}\">{}</a>", n.anchor(), class(n), n.number);
        if f.places.len() > 1 {
            rows.extend(f.places.iter().map(|p| {
                let value = phrase::measured(p.value, p.low, p.high, &f.unit);
                row(tag.clone(), value, phrase::bracket_of(f, [p.low, p.high]), p.at_mm)
            }));
        } else {
            rows.push(row(tag, n.measured(), n.bracket(), f.at_mm));
        }
    }
    let left = rows.len().saturating_sub(ROWS);
    rows.truncate(ROWS);
    let more =
        if left > 0 { markup!("<p class=\"note\">{} more stand in the JSON.</p>", left) } else { Markup::default() };
    markup!(
        "<details><summary>All places</summary><div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"Table\"><table><thead><tr><th scope=\"col\">Pin</th><th scope=\"col\">Value</th>\
         <th scope=\"col\">Bracket</th><th scope=\"col\">Place, mm</th></tr></thead><tbody>{}</tbody></table></div>{}</details>",
        Markup::all(rows),
        more
    )
}
