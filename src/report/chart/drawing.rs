//! What every chart is drawn with: font, colours, and the walk from plotters to the page.

use crate::report::markup::{Markup, escaped};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

/// Name under which the font is known to plotters.
pub(super) const FONT: &str = "amcheck-sans";

pub(super) const INK: RGBColor = RGBColor(24, 33, 43);
pub(super) const FAINT: RGBColor = RGBColor(88, 99, 112);
pub(super) const TRACK: RGBColor = RGBColor(214, 220, 226);
pub(super) const FAIL: RGBColor = RGBColor(226, 109, 135);
pub(super) const WARN: RGBColor = RGBColor(246, 205, 98);
pub(super) const GOOD: RGBColor = RGBColor(150, 177, 197);
/// Ground of the page's cards, behind words that would cross a line.
pub(super) const PAPER: RGBColor = RGBColor(254, 254, 254);

/// Where a chart is drawn, in pixels.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// An SVG in the making failed; the page then goes without the chart, and the numbers beside it stay.
pub(super) type Drawn<T = ()> = std::result::Result<T, DrawingAreaErrorKind<std::convert::Infallible>>;

/// The error of the SVG backend, made one that needs no input or output.
pub(super) fn quiet<E: std::error::Error + Send + Sync>(
    _: DrawingAreaErrorKind<E>,
) -> DrawingAreaErrorKind<std::convert::Infallible> {
    DrawingAreaErrorKind::LayoutError
}

/// Runs a drawing on an SVG of a size and makes it part of a page; nothing where plotters fails.
pub(super) fn svg(width: u32, height: u32, label: &str, draw: impl Fn(&Area) -> Drawn) -> Markup {
    let regular: &'static [u8] = include_bytes!("../assets/DejaVuSans-subset.ttf");
    if register_font(FONT, FontStyle::Normal, regular).is_err() {
        return Markup::default();
    }
    let mut text = String::new();
    let done = {
        let area = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
        draw(&area).and_then(|()| area.present().map_err(quiet))
    };
    if done.is_err() {
        return Markup::default();
    }
    let head = format!("<svg class=\"chart\" role=\"img\" aria-label=\"{}\" ", escaped(label));
    // Plotters breaks lines between elements and pads them; a page holds many.
    let body: String = text.replacen("<svg ", &head, 1).lines().map(str::trim).collect::<Vec<_>>().join("\n");
    Markup::made(body)
}
