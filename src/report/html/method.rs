//! What the verdict rests on: slices, histograms, health of the mesh, the grid, the limits, the data.

use super::page::Context;
use crate::check::State;
use crate::error::byte_count;
use crate::report::chart;
use crate::report::json;
use crate::report::markup::{Markup, markup};
use crate::report::phrase;
use crate::units::short;

/// Slices through the worst finding.
pub fn slices(c: &Context) -> Markup {
    let figures: Vec<Markup> = c
        .exhibit
        .slices
        .iter()
        .filter_map(|s| ["x", "y", "z"].get(s.axis).map(|axis| (s, axis)))
        .map(|(s, axis)| {
            let at = short((s.at_mm * 100.0).round() / 100.0);
            markup!(
                "<figure>{}<figcaption>{} = {} mm, frame of the build</figcaption></figure>",
                c.image(&format!("slice-{axis}")),
                *axis,
                at
            )
        })
        .collect();
    if figures.is_empty() {
        return Markup::default();
    }
    let which = if c.findings.is_empty() { "Slices through the middle" } else { "Slices through the worst finding" };
    markup!(
        "<section aria-label=\"Slices\"><h2>{}</h2><div class=\"slices\">{}</div></section>\n",
        which,
        Markup::all(figures)
    )
}

/// How the measured surface is spread over the values of each map.
pub fn histograms(c: &Context) -> Markup {
    let charts: Vec<Markup> = c
        .exhibit
        .maps
        .iter()
        .map(|m| (m, chart::histogram(m, &c.exhibit.corners)))
        .filter(|(_, chart)| !chart.is_empty())
        .map(|(m, chart)| markup!("<figure><h3>{}</h3>{}</figure>", m.title, chart))
        .collect();
    if charts.is_empty() {
        return Markup::default();
    }
    markup!(
        "<section aria-label=\"Histograms\"><h2>Histograms</h2><div class=\"charts\">{}</div></section>\n",
        Markup::all(charts)
    )
}

/// The part as it was read, and what was noticed about it.
pub fn health(c: &Context) -> Markup {
    let p = &c.report.part;
    let volume = phrase::measured(p.volume_mm3.value, p.volume_mm3.low, p.volume_mm3.high, "mm3");
    let bracket = phrase::bracket(p.volume_mm3.low, p.volume_mm3.high).map_or(String::new(), |b| format!(" ({b})"));
    let units = match p.units_from.as_str() {
        "assumed" => "assumed, the file does not say",
        "option" => "given on the command line",
        "file" => "from the file",
        other => other,
    };
    let rows = [
        ("File", p.file.clone()),
        ("Extent", phrase::extent(p.box_mm)),
        ("Triangles", phrase::thousands(p.triangles)),
        ("Bodies", phrase::thousands(p.bodies)),
        ("Surface", if p.watertight { "watertight".into() } else { "not watertight".into() }),
        ("Volume", format!("{volume}{bracket}")),
        ("Area", phrase::quantity(p.area_mm2, "mm2")),
        ("Unit", format!("{} ({units})", p.units)),
    ];
    let notices = Markup::all(c.report.warnings.iter().map(|w| {
        let count = w.count.map_or(String::new(), |n| format!(" · {}", phrase::thousands(n)));
        let at = w.at_mm.map_or(String::new(), |p| format!(" · at {} mm", phrase::point(p)));
        markup!("<li><b>{}</b> {}<span class=\"dim\">{}{}</span></li>", w.code, w.message, count, at)
    }));
    let notices = if c.report.warnings.is_empty() {
        Markup::raw("<p>Nothing was noticed about the file.</p>")
    } else {
        markup!("<ul class=\"notices\">{}</ul>", notices)
    };
    markup!(
        "<section class=\"two\" aria-label=\"Mesh health\"><div class=\"card\"><h2>The part as read</h2><dl>{}</dl></div>\
         <div class=\"card\"><h2>What was noticed</h2>{}</div></section>\n",
        pairs(&rows),
        notices
    )
}

/// How it was measured: grid, refinement, what a bracket is, what was not run.
pub fn method(c: &Context) -> Markup {
    let g = &c.report.grid;
    let p = &c.report.process;
    let silent = c.report.count(State::NotRun) + c.report.count(State::NotApplicable);
    let rows = [
        (
            "Grid",
            format!(
                "{} mm, {} × {} × {} = {} samples",
                short(g.spacing_mm),
                g.dims[0],
                g.dims[1],
                g.dims[2],
                phrase::thousands(g.samples)
            ),
        ),
        ("Memory", byte_count(g.memory_bytes.into())),
        (
            "Refined",
            format!(
                "{} samples by all checks together; each may take {} for what the grid leaves open",
                phrase::thousands(g.refined),
                phrase::thousands(g.refine_budget)
            ),
        ),
        (
            "Process",
            format!(
                "{} ({}), layers of {}, {}",
                p.name,
                p.title,
                phrase::quantity(p.layer_height_mm, "mm"),
                if p.prints_supports { "prints supports" } else { "prints no supports" }
            ),
        ),
        (
            "Machine",
            format!(
                "{} × {} × {} mm",
                short(p.build_volume_mm[0]),
                short(p.build_volume_mm[1]),
                short(p.build_volume_mm[2])
            ),
        ),
        ("Not run", format!("{silent} of {} checks did not run or do not apply", c.report.checks.len())),
    ];
    markup!(
        "<section class=\"card\" aria-label=\"Method\"><h2>How it was measured</h2><dl>{}</dl><p>The grid says where to look; lengths are then measured \
         on the mesh itself. Each value stands between a low and a high end that hold the truth. A check fails only if its whole bracket is on the wrong side of \
         the limit and passes only if all of it is on the right side; otherwise it is undecided. Estimated values have no such ends and warn at most. Equal to \
         the limit passes. Colours and pictures come from a display copy; the numbers do not.</p></section>\n",
        pairs(&rows)
    )
}

/// Every limit that was applied, with its source.
pub fn limits(c: &Context) -> Markup {
    let rows = Markup::all(c.report.process.limits.iter().map(|(name, l)| {
        markup!(
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td></tr>",
            *name,
            phrase::limits(l.fail, l.warn, l.sense, &l.unit),
            if l.overridden { format!("{}, overridden", l.basis) } else { l.basis.clone() },
            l.source
        )
    }));
    if rows.is_empty() {
        return Markup::default();
    }
    markup!(
        "<section aria-label=\"Limits\"><details class=\"fold\"><summary>Limits of the process and their sources</summary><div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"Table\"><table><thead>\
         <tr><th scope=\"col\">Check</th><th scope=\"col\">Limits</th><th scope=\"col\">Basis</th><th scope=\"col\">Source</th></tr></thead><tbody>{}</tbody></table></div></details></section>\n",
        rows
    )
}

/// The whole report as JSON, once: people unfold it, scripts parse it.
pub fn json(c: &Context) -> Markup {
    // Escaped as JSON, so that the text is the same for a parser and for HTML.
    let text = Markup::made(json::inside_html(&json::write(c.report)));
    markup!(
        "<section class=\"data\" aria-label=\"Data\"><details class=\"fold\"><summary>The whole report as JSON ({})</summary><pre id=\"report-json\" tabindex=\"0\">{}</pre></details></section>\n",
        c.report.schema,
        text
    )
}

/// Rows of a definition list.
fn pairs(rows: &[(&str, String)]) -> Markup {
    Markup::all(rows.iter().map(|(name, text)| markup!("<div><dt>{}</dt><dd>{}</dd></div>", *name, *text)))
}
