//! The part painted by each map, and the findings beside it.

use super::page::{Context, state_tag};
use super::viewer;
use crate::check::State;
use crate::report::markup::{Markup, markup};
use crate::report::phrase::{self, Numbered};

/// Most findings beside the pictures.
const LISTED: usize = 24;
/// Most maps that can be chosen; the style sheet knows as many.
pub const MAPS: usize = 9;

/// Pictures with a choice of map on the left, findings worst first on the right.
pub fn stage(c: &Context) -> Markup {
    let views: Vec<(&str, &str)> = if c.exhibit.maps.is_empty() {
        vec![("part", "Part")]
    } else {
        c.exhibit.maps.iter().take(MAPS).map(|m| (m.check.as_str(), m.title.as_str())).collect()
    };
    // The map of the worst finding is shown first.
    let first = c.findings.iter().find_map(|n| views.iter().position(|v| v.0 == n.check.name)).unwrap_or(0);
    let radios = Markup::all(views.iter().enumerate().map(|(i, _)| {
        markup!(
            "<input type=\"radio\" name=\"map\" id=\"map-{}\" class=\"choice\"{}>",
            i + 1,
            if i == first { Markup::raw(" checked") } else { Markup::default() }
        )
    }));
    let labels = Markup::all(
        views
            .iter()
            .enumerate()
            .map(|(i, v)| markup!("<label for=\"map-{}\"><kbd>{}</kbd> {}</label>", i + 1, i + 1, v.1)),
    );
    let figures = Markup::all(
        views
            .iter()
            .enumerate()
            .map(|(i, v)| markup!("<figure class=\"view view-{}\">{}</figure>", i + 1, c.image(v.0))),
    );
    markup!(
        "<section class=\"stage\" aria-label=\"Part and findings\"><div class=\"part\">{}<div class=\"tabs\" role=\"group\" \
         aria-label=\"Map\">{}</div>{}<div class=\"views\">{}</div>{}</div>{}</section>\n",
        radios,
        labels,
        viewer::place(),
        figures,
        left_out(c),
        list(c)
    )
}

/// What the display copy leaves out, said where it is seen.
fn left_out(c: &Context) -> Markup {
    match c.exhibit.facets_left_out {
        0 => Markup::default(),
        n => markup!(
            "<p class=\"note\">The pictures show a coarser copy: {} facets are left out. All numbers come from the whole part.</p>",
            phrase::thousands(n as u64)
        ),
    }
}

fn list(c: &Context) -> Markup {
    if c.findings.is_empty() {
        return Markup::raw("<div class=\"findings\"><p class=\"note\">No findings in the checks that ran.</p></div>");
    }
    let items = Markup::all(c.findings.iter().take(LISTED).map(item));
    let rest = match c.findings.len().saturating_sub(LISTED) {
        0 => Markup::default(),
        n => markup!("<li class=\"note\">{} more are in the checks below.</li>", n),
    };
    markup!("<ol class=\"findings\" aria-label=\"Findings, worst first\">{}{}</ol>", items, rest)
}

/// One finding: what, how much, where, what to do.
fn item(n: &Numbered) -> Markup {
    let f = n.finding;
    let bracket = phrase::bracket(f.low, f.high).map_or(String::new(), |b| format!(" ({b})"));
    let mut place = vec![format!("at {} mm", phrase::point(f.at_mm))];
    place.extend(n.size());
    let word = if f.state == State::Undecided { "To decide" } else { "Fix" };
    markup!(
        "<li class=\"finding {}\" id=\"{}\" data-finding=\"{}\" data-at=\"{}\"><a href=\"#{}\" class=\"pinned\"><span class=\"pin {}\">{}</span> \
         {} <span class=\"dim\">· {} {}</span></a><p>{}</p><p class=\"dim\"><b>{}{}</b>, {} · {}</p><p><b>{}:</b> {}</p></li>",
        f.state.word(),
        n.anchor(),
        n.number,
        format!("[{},{},{}]", f.at_mm[0], f.at_mm[1], f.at_mm[2]),
        n.anchor(),
        f.state.word(),
        n.number,
        state_tag(f.state),
        n.check.name,
        if f.decided { "" } else { "(bracket holds a limit)" },
        phrase::sentence(&f.message),
        n.measured(),
        bracket,
        phrase::deciding(f),
        place.join(" · "),
        word,
        phrase::sentence(&f.fix)
    )
}
