//! The page of `amcheck orient`: chart, table, thumbnails.

use super::page::image_of;
use crate::report::chart;
use crate::report::markup::{Markup, markup};
use crate::report::orient::{HEADS, OrientReport, direction, row};
use crate::report::render::Picture;

/// The orientations of a part as one HTML file without script; `pictures` are thumbnails named `1`, `2`, … by rank.
///
/// # Cost
/// O(orientations + bytes of the pictures).
pub fn orientations(report: &OrientReport, pictures: &[Picture]) -> String {
    let list = &report.orientations.list;
    let heads = HEADS.iter().map(|h| markup!("<th scope=\"col\">{}</th>", *h));
    let rows = list.iter().enumerate().map(|(n, o)| {
        let rank = (n + 1).to_string();
        let mark = match (o.fits, o.pareto) {
            (false, _) => "does not fit the machine",
            (true, true) => "unbeaten",
            (true, false) => "",
        };
        let cells = row(o).into_iter().map(|c| markup!("<td>{}</td>", c));
        markup!("<tr><th scope=\"row\">{}</th>{}<td>{}</td></tr>\n", rank, Markup::all(cells), mark)
    });
    let figures = pictures.iter().map(|p| {
        let rank: usize = p.name.parse().unwrap_or(0);
        let up = list.get(rank.wrapping_sub(1)).map_or(String::new(), |o| direction(o.up));
        markup!("<figure>{}<figcaption>{} · up {}</figcaption></figure>\n", image_of(p), p.name, up)
    });
    let best = list.first().map_or(String::new(), |o| format!("amcheck --up {} {}", direction(o.up), report.file));
    markup!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>Orientations of {}</title>\n<style>\n{}\n\
         .grid{display:grid;grid-template-columns:repeat(auto-fill,minmax(230px,1fr));gap:12px}.grid figure{background:var(--card);border:1px solid var(--line);border-radius:10px;padding:8px}\
         .wide{overflow-x:auto;background:var(--card);border:1px solid var(--line);border-radius:10px;padding:8px}td,th{text-align:right;padding:.2rem .5rem;white-space:nowrap}</style>\n</head>\n<body>\n\
         <header class=\"top\"><span class=\"brand\">amcheck</span> <b class=\"name\">{}</b> <span>process: {}</span></header>\n<main>\n\
         <h2>Which way to print</h2>\n<p>{} directions were scored on the mesh, the best {} measured in full. Dark dots: no other \
         orientation is at least as good in everything. Best by cost: <code>{}</code></p>\n<div class=\"wide\">{}</div>\n\
         <h2>Table</h2>\n<div class=\"wide\"><table>\n<tr><th scope=\"col\"></th>{}<th scope=\"col\"></th></tr>\n{}</table></div>\n\
         <h2>How they stand</h2>\n<p class=\"note\">Seen from the front and below; what needs support is hatched.</p>\n<div class=\"grid\">{}</div>\n\
         </main>\n<footer>amcheck {} · {}</footer>\n</body>\n</html>\n",
        report.file,
        Markup::raw(include_str!("page.css")),
        report.file,
        report.process,
        report.orientations.scored.to_string(),
        list.len().to_string(),
        best,
        chart::orientations(list),
        Markup::all(heads),
        Markup::all(rows),
        Markup::all(figures),
        report.tool.version,
        report.schema
    )
    .into_string()
}
