//! The part painted by each map, and the findings beside it.

use super::page::{Context, state_tag};
use super::viewer;
use crate::check::{Basis, State};
use crate::report::glb::MAPS;
use crate::report::markup::{Markup, markup};
use crate::report::phrase::{self, Numbered};

/// Most findings beside the pictures.
const LISTED: usize = 24;
/// Most characters of pictures of whole views; those of maps without findings go first.
const PAINTED: usize = 620_000;

/// A view that can be chosen.
struct View<'a> {
    check: &'a str,
    title: &'a str,
    /// State of the check that the map belongs to.
    state: State,
    picture: Markup,
}

/// Pictures with a choice of map on the left, findings worst first on the right.
pub fn stage(c: &Context) -> Markup {
    let views = views(c);
    // The map of the worst finding is shown first.
    let first = c.findings.iter().find_map(|n| views.iter().position(|v| v.check == n.check.name)).unwrap_or(0);
    let radios = Markup::all(views.iter().enumerate().map(|(i, _)| {
        markup!(
            "<input type=\"radio\" name=\"map\" id=\"map-{}\" class=\"choice\"{}>",
            i + 1,
            if i == first { Markup::raw(" checked") } else { Markup::default() }
        )
    }));
    let labels = Markup::all(views.iter().enumerate().map(|(i, v)| label(i, v)));
    let figures = Markup::all(views.iter().enumerate().map(|(i, v)| {
        let quiet = i != first && v.state <= State::Pass;
        let class = format!("view view-{}{}", i + 1, if quiet { " quiet" } else { "" });
        markup!("<figure class=\"{}\">{}</figure>", class, v.picture)
    }));
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

/// The maps with their pictures; where those are too long together, maps without findings go without.
fn views<'a>(c: &Context<'a>) -> Vec<View<'a>> {
    if c.exhibit.maps.is_empty() {
        return vec![View { check: "part", title: "Part", state: State::Pass, picture: c.image("part") }];
    }
    let state = |name: &str| c.report.checks.iter().find(|k| k.name == name).map_or(State::Pass, |k| k.state);
    let mut views: Vec<View> = c
        .exhibit
        .maps
        .iter()
        .take(MAPS)
        .map(|m| View { check: &m.check, title: &m.title, state: state(&m.check), picture: c.image(&m.check) })
        .collect();
    let mut order: Vec<usize> = (0..views.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(views[i].state), i));
    let mut room = PAINTED;
    for i in order {
        let length = views[i].picture.len();
        if length > room {
            views[i].picture = markup!(
                "<p class=\"note\">The picture of this map stands beside the page as {}.png.</p>",
                views[i].check
            );
        } else {
            room -= length;
        }
    }
    views
}

/// A map's label: its key, its name, and a glyph where its check found something.
fn label(i: usize, v: &View) -> Markup {
    let key = match i {
        0..=8 => markup!("<kbd>{}</kbd> ", i + 1),
        9 => Markup::raw("<kbd>0</kbd> "),
        _ => Markup::default(),
    };
    let found = match v.state {
        State::Fail | State::Undecided | State::Warn | State::Error => {
            markup!(" <span class=\"state {}\" aria-hidden=\"true\">{}</span>", v.state.word(), v.state.glyph())
        }
        _ => Markup::default(),
    };
    markup!("<label for=\"map-{}\">{}{}{}</label>", i + 1, key, v.title, found)
}

/// Rules by which the chosen map is shown, for as many as there are.
pub(super) fn style(c: &Context) -> Markup {
    let n = c.exhibit.maps.len().clamp(1, MAPS);
    let all = |rule: &dyn Fn(usize) -> String| (1..=n).map(rule).collect::<Vec<_>>().join(",");
    let shown = all(&|i| format!("#map-{i}:checked~.views .view-{i}"));
    let label = |on: &'static str| all(&|i| format!("#map-{i}:{on}~.tabs label:nth-child({i})"));
    let (checked, focused) = (label("checked"), label("focus-visible"));
    Markup::made(format!(
        "{shown}{{display:block}}{checked}{{background:var(--ink);color:var(--card);border-color:var(--ink)}}\
         {focused}{{outline:3px solid var(--focus);outline-offset:2px}}\n"
    ))
}

/// What the display copy leaves out, said where it is seen.
fn left_out(c: &Context) -> Markup {
    c.exhibit.coarsened.map_or(Markup::default(), |copy| {
        markup!(
            "<p class=\"note\">The pictures show a coarser copy: {} facets are left out, and no point of it lies farther than {} from the part's surface. \
             Histograms are of the copy; all numbers come from the whole part.</p>",
            phrase::thousands(copy.facets_left_out as u64),
            phrase::at_most(copy.within_mm, "mm")
        )
    })
}

fn list(c: &Context) -> Markup {
    if c.findings.is_empty() {
        return Markup::raw("<div class=\"found\"><p class=\"note\">No findings in the checks that ran.</p></div>");
    }
    let items = Markup::all(c.findings.iter().take(LISTED).map(|n| item(c, n)));
    let rest = match c.findings.len().saturating_sub(LISTED) {
        0 => Markup::default(),
        n => markup!("<li class=\"note\">{} more are in the checks below.</li>", n),
    };
    let head = match c.findings.len() {
        1 => "1 finding".to_string(),
        n => format!("{n} findings, worst first"),
    };
    markup!(
        "<div class=\"found\"><div class=\"findhead\"><h2>{}</h2><span class=\"step\" hidden><button type=\"button\" data-step=\"-1\"><span aria-hidden=\"true\">‹</span> \
         Previous <kbd>p</kbd></button> <button type=\"button\" data-step=\"1\">Next <kbd>n</kbd> <span aria-hidden=\"true\">›</span></button></span></div>\
         <ol class=\"findings\" aria-label=\"Findings, worst first\" tabindex=\"0\">{}{}</ol></div>",
        head,
        items,
        rest
    )
}

/// The class that colours a finding: its state, or grey where somebody accepts it.
pub(super) fn class(n: &Numbered) -> &'static str {
    if n.finding.accepted.is_some() { "accepted" } else { n.finding.state.word() }
}

/// One finding: what, how much, where, what to do.
fn item(c: &Context, n: &Numbered) -> Markup {
    let f = n.finding;
    let bracket = n.bracket().map_or(String::new(), |b| format!(" ({b})"));
    let basis = if f.basis == Basis::Estimated { ", estimated" } else { "" };
    let part = &c.report.part;
    let mut place =
        vec![phrase::whereabouts(part.posed(f.at_mm), part.posed_box()), format!("at {} mm", phrase::point(f.at_mm))];
    place.extend(n.size());
    let word = if f.state == State::Undecided { "To decide" } else { "Fix" };
    let held = phrase::acceptance(f)
        .map_or(Markup::default(), |said| markup!("<p class=\"held\">{}</p>", phrase::sentence(&said)));
    markup!(
        "<li class=\"finding {}\" id=\"{}\" data-finding=\"{}\" data-at=\"{}\"><a href=\"#{}\" class=\"pinned\"><span class=\"pin {}\">{}</span> \
         {} <span class=\"dim\">· {} {}</span></a><p>{}</p><p class=\"dim\"><b>{}{}</b>{}, {} · {}</p>{}<p><b>{}:</b> {}</p></li>",
        class(n),
        n.anchor(),
        n.number,
        format!("[{},{},{}]", f.at_mm[0], f.at_mm[1], f.at_mm[2]),
        n.anchor(),
        class(n),
        n.number,
        state_tag(f.state),
        n.check.name,
        if f.decided { "" } else { "(bracket holds a limit)" },
        phrase::sentence(&f.message),
        n.measured(),
        bracket,
        basis,
        phrase::deciding(f),
        place.join(" · "),
        held,
        word,
        phrase::sentence(&f.fix)
    )
}
