//! Charts as SVG by plotters: a gauge for each check, a histogram for each map.
//!
//! Colours are a closed list that the page's style sheet maps to the light and the dark theme; letters are measured
//! with the font beside the code, so that the text is the same on every machine.

use super::exhibit::SurfaceMap;
use super::markup::{Markup, escaped};
use super::phrase;
use super::render::colour::{Scale, Zone};
use crate::check::Sense;
use crate::geometry::vector::{Vec3, cross, norm, sub};
use crate::units::short;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

/// Name under which the font is known to plotters.
const FONT: &str = "amcheck-sans";

const INK: RGBColor = RGBColor(24, 33, 43);
const FAINT: RGBColor = RGBColor(88, 99, 112);
const TRACK: RGBColor = RGBColor(214, 220, 226);
const FAIL: RGBColor = RGBColor(226, 109, 135);
const WARN: RGBColor = RGBColor(246, 205, 98);
const GOOD: RGBColor = RGBColor(150, 177, 197);

/// What a gauge shows.
#[derive(Debug, Clone, Copy)]
pub struct Gauge<'a> {
    pub value: f64,
    pub low: f64,
    pub high: f64,
    pub fail: Option<f64>,
    pub warn: Option<f64>,
    pub sense: Sense,
    pub unit: &'a str,
}

/// An SVG in the making failed; the page then goes without the chart, and the numbers beside it stay.
type Drawn = std::result::Result<(), DrawingAreaErrorKind<std::convert::Infallible>>;

/// The error of the SVG backend, made one that needs no input or output.
fn quiet<E: std::error::Error + Send + Sync>(
    _: DrawingAreaErrorKind<E>,
) -> DrawingAreaErrorKind<std::convert::Infallible> {
    DrawingAreaErrorKind::LayoutError
}

/// Value with bracket whiskers on a bar: the span beyond each limit is shaded, each limit has a tick with its word.
///
/// # Cost
/// O(1).
pub fn gauge(g: &Gauge) -> Markup {
    let label = format!(
        "Gauge: {}, {}",
        phrase::measured(g.value, g.low, g.high, g.unit),
        phrase::limits(g.fail, g.warn, g.sense, g.unit)
    );
    svg(640, 104, &label, |area| draw_gauge(area, g))
}

fn draw_gauge(area: &DrawingArea<SVGBackend, plotters::coord::Shift>, g: &Gauge) -> Drawn {
    let (x0, x1, y0, y1) = (16i32, 624i32, 26i32, 40i32);
    let most =
        [Some(g.high), g.fail.map(|l| 2.0 * l), g.warn.map(|l| 1.6 * l)].into_iter().flatten().fold(0.0, f64::max);
    let least = [Some(g.low), g.fail, g.warn].into_iter().flatten().fold(0.0, f64::min);
    let end = if most > least { least + (most - least) * 1.06 } else { least + 1.0 };
    let across = |v: f64| x0 + ((v - least) / (end - least) * f64::from(x1 - x0)).round() as i32;
    let bar = |from: i32, to: i32, colour: RGBColor| {
        area.draw(&Rectangle::new([(from, y0), (to, y1)], colour.filled())).map_err(quiet)
    };
    bar(x0, x1, TRACK)?;
    for (limit, colour) in [(g.warn, WARN), (g.fail, FAIL)] {
        if let Some(l) = limit {
            match g.sense {
                Sense::Min => bar(x0, across(l), colour)?,
                Sense::Max => bar(across(l), x1, colour)?,
            }
        }
    }
    let mut ticks: Vec<(i32, &str, f64)> = [(g.fail, "must"), (g.warn, "should")]
        .into_iter()
        .filter_map(|(l, word)| l.map(|l| (across(l), word, l)))
        .collect();
    ticks.sort_by_key(|t| t.0);
    let crowded = ticks.len() == 2 && ticks[1].0 - ticks[0].0 < 190;
    for (i, (x, word, limit)) in ticks.iter().enumerate() {
        area.draw(&Rectangle::new([(x - 1, y0 - 12), (x + 1, y1 + 12)], INK.filled())).map_err(quiet)?;
        // Two near ticks have their words left and right of them.
        let (h, dx) = match (crowded, i) {
            (true, 0) => (HPos::Right, 8),
            (true, _) => (HPos::Left, -8),
            _ if *x < 90 => (HPos::Left, -14),
            _ if *x > 550 => (HPos::Right, 14),
            _ => (HPos::Center, 0),
        };
        let style = TextStyle::from((FONT, 25).into_font()).color(&FAINT).pos(Pos::new(h, VPos::Top));
        let text = format!("{word} {} {}", phrase::relation(g.sense), short(*limit));
        area.draw(&Text::new(text, (x + dx, y1 + 20), style)).map_err(quiet)?;
    }
    let (low, high, y) = (across(g.low), across(g.high), (y0 + y1) / 2);
    area.draw(&PathElement::new([(low, y), (high, y)], INK.stroke_width(4))).map_err(quiet)?;
    for x in [low, high] {
        area.draw(&PathElement::new([(x, y - 13), (x, y + 13)], INK.stroke_width(4))).map_err(quiet)?;
    }
    area.draw(&Circle::new((across(g.value), y), 9, INK.filled())).map_err(quiet)
}

/// Shares of the painted surface over the values of a map, with the limits drawn; bars change colour at a limit.
///
/// Each facet counts with its area, at the mean of its corners.
///
/// # Cost
/// O(facets).
pub fn histogram(map: &SurfaceMap, corners: &[Vec3]) -> Markup {
    let scale = Scale::of(map);
    let shares = shares(map, corners, &scale);
    let label = format!("Histogram of {}: share of the measured surface", map.title.to_lowercase());
    svg(760, 260, &label, |area| draw_histogram(area, map, &scale, &shares))
}

/// Number of bars.
const BARS: usize = 48;

/// Share of the measured area in each bar, percent; the last bar holds all beyond the open end.
fn shares(map: &SurfaceMap, corners: &[Vec3], scale: &Scale) -> Vec<f64> {
    let mut bars = vec![0.0; BARS];
    for (c, v) in corners.chunks_exact(3).zip(map.values.chunks_exact(3)) {
        let value = f64::from(v.iter().sum::<f32>()) / 3.0;
        if value.is_finite() {
            let at = (value - scale.low) / (scale.high - scale.low) * BARS as f64;
            bars[(at.max(0.0) as usize).min(BARS - 1)] += norm(cross(sub(c[1], c[0]), sub(c[2], c[0])));
        }
    }
    let total: f64 = bars.iter().sum();
    bars.iter().map(|b| if total > 0.0 { 100.0 * b / total } else { 0.0 }).collect()
}

fn draw_histogram(
    area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
    map: &SurfaceMap,
    scale: &Scale,
    shares: &[f64],
) -> Drawn {
    let top = shares.iter().copied().fold(1.0, f64::max) * 1.18;
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(46)
        .y_label_area_size(64)
        .build_cartesian_2d(scale.low..scale.high, 0.0..top)
        .map_err(quiet)?;
    let text = |size: i32| TextStyle::from((FONT, size).into_font()).color(&FAINT);
    let unit = phrase::unit_sign(&map.unit);
    chart
        .configure_mesh()
        .disable_x_mesh()
        .y_labels(4)
        .x_labels(8)
        .light_line_style(TRANSPARENT)
        .bold_line_style(TRACK)
        .axis_style(FAINT)
        .label_style(text(17))
        .axis_desc_style(text(17))
        .x_desc(if unit.is_empty() { map.title.clone() } else { format!("{} ({unit})", map.title) })
        .y_desc("% of surface")
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .draw()
        .map_err(quiet)?;
    let step = (scale.high - scale.low) / shares.len() as f64;
    let bars = shares.iter().enumerate().filter(|(_, s)| **s > 0.0).flat_map(|(i, share)| {
        let (from, to) = (scale.low + i as f64 * step, scale.low + (i + 1) as f64 * step);
        // A bar that holds a limit changes its colour there.
        let mut cuts: Vec<f64> =
            [scale.fail, scale.warn].into_iter().flatten().filter(|l| *l > from && *l < to).collect();
        cuts.extend([from, to]);
        cuts.sort_by(f64::total_cmp);
        let pieces: Vec<[f64; 2]> = cuts.windows(2).map(|w| [w[0], w[1]]).collect();
        pieces.into_iter().map(move |[a, b]| {
            let colour = match scale.zone((0.5 * (a + b)) as f32) {
                Zone::Fail => FAIL,
                Zone::Warn => WARN,
                _ => GOOD,
            };
            Rectangle::new([(a, 0.0), (b, *share)], colour.filled())
        })
    });
    chart.draw_series(bars).map_err(quiet)?;
    for (limit, word, height) in [(scale.fail, "must", 0.99), (scale.warn, "should", 0.89)] {
        if let Some(l) = limit.filter(|l| *l > scale.low && *l < scale.high) {
            chart.draw_series([PathElement::new([(l, 0.0), (l, top)], INK.stroke_width(2))]).map_err(quiet)?;
            let words = format!("{word} {} {}", phrase::relation(map.sense), short(l));
            let style = TextStyle::from((FONT, 17).into_font()).color(&INK);
            let offset = (scale.high - scale.low) * 0.008;
            chart.draw_series([Text::new(words, (l + offset, top * height), style)]).map_err(quiet)?;
        }
    }
    Ok(())
}

/// Runs a drawing on an SVG of a size and makes it part of a page; nothing where plotters fails.
fn svg(
    width: u32,
    height: u32,
    label: &str,
    draw: impl Fn(&DrawingArea<SVGBackend, plotters::coord::Shift>) -> Drawn,
) -> Markup {
    let regular: &'static [u8] = include_bytes!("assets/DejaVuSans-subset.ttf");
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

#[cfg(test)]
mod tests {
    use super::*;

    const GAUGE: Gauge =
        Gauge { value: 0.45, low: 0.42, high: 0.49, fail: Some(0.5), warn: Some(0.8), sense: Sense::Min, unit: "mm" };

    #[test]
    fn a_gauge_has_both_limits_and_is_well_formed() {
        let text = gauge(&GAUGE).into_string();
        for needle in ["must ≥ 0.5", "should ≥ 0.8", "role=\"img\"", "#E26D87", "#F6CD62"] {
            assert!(text.contains(needle), "{needle} is missing in {text}");
        }
        let mut reader = quick_xml::Reader::from_str(&text);
        loop {
            match reader.read_event() {
                Ok(quick_xml::events::Event::Eof) => break,
                Ok(_) => {}
                Err(e) => panic!("{e} in {text}"),
            }
        }
    }

    #[test]
    fn a_histogram_counts_area() {
        let square = |x: f64, s: f64| [[x, 0.0, 0.0], [x + s, 0.0, 0.0], [x, s, 0.0]];
        let corners: Vec<Vec3> = square(0.0, 1.0).into_iter().chain(square(5.0, 3.0)).collect();
        let map = SurfaceMap {
            check: "a".into(),
            title: "</svg>".into(),
            unit: "mm".into(),
            sense: Sense::Min,
            fail: Some(1.0),
            warn: None,
            open_end: 4.8,
            values: vec![0.05, 0.05, 0.05, 9.0, 9.0, 9.0],
        };
        let shares = shares(&map, &corners, &Scale::of(&map));
        assert_eq!((shares[0], shares[BARS - 1]), (10.0, 90.0));
        assert!(!histogram(&map, &corners).into_string().contains("</svg>\n("));
    }
}
