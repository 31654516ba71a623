//! The page put together: head, sections in reading order, foot.

use super::{cards, method, orient, overview, stage, thickness, verdict, viewer, volume};
use crate::check::State;
use crate::report::exhibit::Exhibit;
use crate::report::markup::{Markup, markup};
use crate::report::phrase::{self, Numbered};
use crate::report::render::Picture;
use crate::report::schema::Report;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Bytes that the whole page may take.
const LENGTH: usize = 2_000_000;

/// What all sections of the page read.
pub(super) struct Context<'a> {
    pub(super) report: &'a Report,
    pub(super) exhibit: &'a Exhibit,
    pub(super) pictures: &'a [Picture],
    pub(super) findings: Vec<Numbered<'a>>,
}

impl Context<'_> {
    /// The worst finding that counts.
    pub(super) fn worst(&self) -> Option<&Numbered<'_>> {
        self.findings.iter().find(|n| n.finding.counts())
    }

    /// A picture by its name, as an image that carries its own bytes; nothing where there is none.
    pub(super) fn image(&self, name: &str) -> Markup {
        self.pictures.iter().find(|p| p.name == name).map_or(Markup::default(), image_of)
    }
}

/// A picture as an image that carries its own bytes.
pub(super) fn image_of(p: &Picture) -> Markup {
    let [w, h] = dimensions(&p.png);
    let data = Markup::made(STANDARD.encode(&p.png));
    markup!(
        "<img src=\"data:image/png;base64,{}\" width=\"{}\" height=\"{}\" alt=\"{}\">",
        data,
        w.to_string(),
        h.to_string(),
        p.alt
    )
}

/// The page of a report.
///
/// Every text from the part, the process and the command line is escaped. The same input gives the same bytes.
///
/// # Cost
/// O(findings + facets + bytes of the pictures).
///
/// # Limits
/// At most 24 findings are listed beside the pictures and 100 places in each table; the JSON in the page has all.
pub fn page(report: &Report, exhibit: &Exhibit, pictures: &[Picture]) -> String {
    let context = Context { report, exhibit, pictures, findings: phrase::numbered(report) };
    let state = phrase::verdict_state(report.verdict);
    let title = format!("{} {} · {}", state.glyph(), report.part.file, phrase::headline(report.verdict));
    let head = markup!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data: blob:; \
         style-src 'unsafe-inline'; script-src 'unsafe-inline' blob:; base-uri 'none'; form-action 'none'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<meta name=\"generator\" content=\"amcheck {}\">\n\
         <title>{}</title>\n",
        report.tool.version,
        title
    );
    let style =
        markup!("<style>\n{}{}</style>\n</head>\n", Markup::raw(include_str!("page.css")), stage::style(&context));
    let above = [
        Markup::raw("<body>\n<a class=\"skip\" href=\"#checks\">Skip to the checks</a>\n"),
        header(report),
        Markup::raw("<main>\n"),
        verdict::banner(&context),
        verdict::answers(&context),
        stage::stage(&context),
        overview::table(&context),
        cards::section(&context),
        method::slices(&context),
        volume::panel(&context),
        method::histograms(&context),
        thickness::section(&context),
        orient::section(&context),
        method::health(&context),
        method::method(&context),
        method::limits(&context),
        method::json(&context),
        Markup::raw("</main>\n"),
        footer(report),
    ];
    let above = Markup::all([head, style].into_iter().chain(above));
    // The part is shown as finely as what is left of the page's length allows.
    let room = LENGTH.saturating_sub(above.len());
    let below = [
        viewer::data(&context, room),
        markup!(
            "<script>\n{}{}</script>\n</body>\n</html>\n",
            Markup::raw(include_str!("page.js")),
            Markup::raw(include_str!("slices.js"))
        ),
    ];
    Markup::all([above].into_iter().chain(below)).into_string()
}

/// Part, process and the two buttons.
fn header(report: &Report) -> Markup {
    let part = &report.part;
    let facts = format!(
        "{} · {} triangles · {}",
        phrase::extent(part.box_mm),
        phrase::thousands(part.triangles),
        if part.watertight { "watertight" } else { "not watertight" }
    );
    markup!(
        "<header class=\"top\"><span class=\"brand\">amcheck</span> <b class=\"name\">{}</b> <span>{}</span> \
         <span>process: {}</span><span class=\"buttons\" hidden><button type=\"button\" id=\"theme\">Dark / light</button> \
         <button type=\"button\" id=\"print\">Print / PDF</button></span></header>\n",
        part.file,
        facts,
        if report.process.title.is_empty() { &report.process.name } else { &report.process.title }.as_str()
    )
}

fn footer(report: &Report) -> Markup {
    markup!(
        "<footer>amcheck {} · report format {} · no connection is made by this page · input sha-256 <code>{}</code></footer>\n",
        report.tool.version,
        report.schema,
        report.part.sha256
    )
}

/// The state as glyph and word, in its colour.
pub(super) fn state_tag(state: State) -> Markup {
    markup!(
        "<span class=\"state {}\"><span aria-hidden=\"true\">{}</span> {}</span>",
        state.word(),
        state.glyph(),
        phrase::state_word(state)
    )
}

/// Width and height of a PNG file, from its first chunk.
fn dimensions(png: &[u8]) -> [u32; 2] {
    [16, 20].map(|at| png.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(1, u32::from_be_bytes))
}
