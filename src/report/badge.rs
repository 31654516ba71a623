//! A badge as SVG, written here: no service is asked.

use super::markup::markup;
use super::phrase;
use super::render::colour::{PAPER, state_colour};
use super::render::lettering::{Lettering, Style};
use super::schema::{Report, Verdict};
use crate::check::State;

/// `amcheck | 2 fail` as SVG, in the colour of the verdict.
pub fn write(report: &Report) -> String {
    let state = phrase::verdict_state(report.verdict);
    let word = match report.verdict {
        Verdict::Pass => "printable".to_string(),
        Verdict::Warn => format!("{} warn", report.count(State::Warn)),
        Verdict::Undecided => format!("{} undecided", report.count(State::Undecided)),
        Verdict::Fail => format!("{} fail", report.count(State::Fail)),
    };
    drawn(&word, state)
}

/// `amcheck | not judged` as SVG, for a part that was refused.
pub fn not_judged() -> String {
    drawn("not judged", State::Error)
}

fn drawn(word: &str, state: State) -> String {
    let (letters, style) = (Lettering::new(), Style::regular(11.0, PAPER));
    let [left, right] = ["amcheck", word].map(|t| letters.width(t, &style).ceil() as usize);
    let [r, g, b] = state_colour(state);
    markup!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"20\" role=\"img\" aria-label=\"amcheck: {}\">\
         <title>amcheck: {}</title><clipPath id=\"r\"><rect width=\"{}\" height=\"20\" rx=\"4\"/></clipPath>\
         <g clip-path=\"url(#r)\"><rect width=\"{}\" height=\"20\" fill=\"#3a4550\"/><rect x=\"{}\" width=\"{}\" height=\"20\" fill=\"{}\"/></g>\
         <g fill=\"#fff\" font-family=\"DejaVu Sans,Verdana,sans-serif\" font-size=\"11\"><text x=\"8\" y=\"14\" textLength=\"{}\">amcheck</text>\
         <text x=\"{}\" y=\"14\" textLength=\"{}\">{}</text></g></svg>\n",
        left + right + 32,
        word,
        word,
        left + right + 32,
        left + 16,
        left + 16,
        right + 16,
        format!("#{r:02x}{g:02x}{b:02x}"),
        left,
        left + 24,
        right,
        word
    )
    .into_string()
}
