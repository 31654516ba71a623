//! The page of `amcheck orient`: chart, table, thumbnails.

use super::page::{Context, image_of};
use crate::access::{Orientation, up_option};
use crate::geometry::vector::Vec3;
use crate::report::chart;
use crate::report::markup::{Markup, markup};
use crate::report::orient::{OrientReport, columns, short_direction};
use crate::report::phrase::quoted_file;
use crate::report::render::Picture;

/// The orientations of a part as one HTML file without script; `pictures` are thumbnails named `1`, `2`, … by rank.
///
/// # Cost
/// O(orientations + bytes of the pictures).
pub fn orientations(report: &OrientReport, pictures: &[Picture]) -> String {
    let list = &report.orientations.list;
    markup!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>Orientations of {}</title>\n<style>\n{}\n</style>\n</head>\n<body>\n\
         <header class=\"top\"><span class=\"brand\">amcheck</span> <b class=\"name\">{}</b> <span>process: {}</span></header>\n<main>\n\
         <h2>Which way to print</h2>\n<p>{} directions were scored on the mesh, the best {} measured in full. Dark dots: no other \
         orientation is at least as good in everything. Best by cost, what topples last: <code>{}</code></p>\n{}<div class=\"wide card\">{}</div>\n\
         <h2>Table</h2>\n{}\
         <h2>How they stand</h2>\n<p class=\"note\">Seen from the front and below; what needs support is hatched.</p>\n{}\
         </main>\n<footer>amcheck {} · {}</footer>\n</body>\n</html>\n",
        report.file,
        Markup::raw(include_str!("page.css")),
        report.file,
        report.process,
        report.orientations.scored.to_string(),
        list.len().to_string(),
        best(list, &quoted_file(&report.file)),
        noticed(report),
        chart::orientations(list),
        table(list, up_option),
        figures(list, pictures),
        report.tool.version,
        report.schema
    )
    .into_string()
}

/// What was noticed about the file, where something was.
fn noticed(report: &OrientReport) -> Markup {
    let all = Markup::all(report.warnings.iter().map(|w| markup!("<li><b>{}</b> {}</li>", w.code, w.message)));
    if report.warnings.is_empty() { all } else { markup!("<ul class=\"notices\">{}</ul>\n", all) }
}

/// The orientations in the page of a report: this run's pose and the best others; or how to compare them.
pub(super) fn section(c: &Context) -> Markup {
    let file = quoted_file(&c.report.part.file);
    let Some(stances) = &c.exhibit.stances else {
        return markup!(
            "<section aria-label=\"Orientations\"><h2>Which way to print</h2><p class=\"note\">Orientations were not compared in this run; \
             <code>amcheck orient {}</code> compares them.</p></section>\n",
            file
        );
    };
    let found = &stances.orientations;
    let first = found.list.first().is_some_and(|o| o.from == "given");
    let best = match (first, best(&found.list, &file)) {
        (true, _) => markup!("No other comes before the pose of this run, by cost and what topples last."),
        (false, command) => markup!("Best by cost, what topples last: <code>{}</code>.", command),
    };
    markup!(
        "<section aria-label=\"Orientations\"><h2>Which way to print</h2><p>{} directions were scored on the mesh; the pose of this run and \
         the {} best others were measured on a grid of 64 samples. {} <code>amcheck orient {}</code> compares more of them, and finer.</p>{}\
         <p class=\"note\">Unbeaten: no other of the list is at least as good in everything. In the pictures, seen from the front and below, \
         what needs support is hatched.</p>{}</section>\n",
        found.scored.to_string(),
        found.list.len().saturating_sub(1).to_string(),
        best,
        file,
        table(&found.list, short_direction),
        figures(&found.list, &stances.pictures)
    )
}

/// The command that judges a part in the best orientation; `file` is a word for a shell.
fn best(list: &[Orientation], file: &str) -> String {
    list.first().map_or(String::new(), |o| format!("amcheck --up {} {file}", up_option(o.up)))
}

/// What is to be said of an orientation beside its numbers.
fn mark(o: &Orientation) -> String {
    let this = (o.from == "given").then_some("this run");
    let stands = match (o.fits, o.topples, o.pareto) {
        (false, ..) => Some("does not fit the machine"),
        (true, true, _) => Some("topples by itself"),
        (true, false, true) => Some("unbeaten"),
        (true, false, false) => None,
    };
    [this, stands].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// One row for each; `up` writes a direction.
fn table(list: &[Orientation], up: fn(Vec3) -> String) -> Markup {
    let columns = columns(list);
    let heads = columns.iter().map(|c| markup!("<th scope=\"col\">{}</th>", c.0));
    let rows = list.iter().enumerate().map(|(n, o)| {
        let rest = columns.iter().skip(1).map(|c| c.1(o));
        let cells = std::iter::once(up(o.up)).chain(rest).map(|c| markup!("<td>{}</td>", c));
        markup!("<tr><th scope=\"row\">{}</th>{}<td>{}</td></tr>\n", (n + 1).to_string(), Markup::all(cells), mark(o))
    });
    markup!(
        "<div class=\"wide card\" tabindex=\"0\" role=\"group\" aria-label=\"Table of orientations\"><table class=\"numbers\"><thead><tr><th scope=\"col\">#</th>{}\
         <th scope=\"col\">how it stands</th></tr></thead><tbody>\n{}</tbody></table></div>\n",
        Markup::all(heads),
        Markup::all(rows)
    )
}

fn figures(list: &[Orientation], pictures: &[Picture]) -> Markup {
    let figures = pictures.iter().map(|p| {
        let rank: usize = p.name.parse().unwrap_or(0);
        let of = list.get(rank.wrapping_sub(1));
        let up = of.map_or(String::new(), |o| short_direction(o.up));
        let this = if of.is_some_and(|o| o.from == "given") { ", this run" } else { "" };
        markup!("<figure>{}<figcaption>{} · up {}{}</figcaption></figure>\n", image_of(p), p.name, up, this)
    });
    markup!("<div class=\"stances\">{}</div>\n", Markup::all(figures))
}
