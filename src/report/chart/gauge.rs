//! The gauge of a check: value, bracket and limits on one bar.

use super::drawing::{Area, Drawn, FAIL, FAINT, FONT, INK, TRACK, WARN, quiet, svg};
use crate::check::Sense;
use crate::report::markup::Markup;
use crate::report::phrase;
use crate::units::short;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

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

/// Width of the drawing, the bar's ends and its upper and lower side, pixels.
const WIDTH: i32 = 640;
const BAR: [i32; 2] = [16, 624];
const SIDES: [i32; 2] = [26, 40];

/// Value with bracket whiskers on a bar: the span beyond each limit is shaded, each limit has a tick with its word.
///
/// A value that is better than three times every limit stands as an arrow at the bar's end, so that the limits stay
/// apart.
///
/// # Cost
/// O(1).
pub fn gauge(g: &Gauge) -> Markup {
    let label = format!(
        "Gauge: {}, {}",
        phrase::measured(g.value, g.low, g.high, g.unit),
        phrase::limits(g.fail, g.warn, g.sense, g.unit)
    );
    svg(WIDTH as u32, 104, &label, |area| {
        let span = Span::of(g);
        draw_bar(area, g, span)?;
        draw_limits(area, g, span)?;
        draw_value(area, g, span)
    })
}

/// The values at the ends of the bar.
#[derive(Clone, Copy)]
struct Span {
    from: f64,
    to: f64,
}

impl Span {
    fn of(g: &Gauge) -> Self {
        let limits = || [g.fail, g.warn].into_iter().flatten().filter(|l| l.is_finite());
        let greatest = limits().fold(0.0, f64::max);
        let room = limits().map(|l| 1.8 * l).fold(0.0, f64::max);
        let cap = if g.sense == Sense::Min && greatest > 0.0 { 3.2 * greatest } else { f64::MAX };
        let to = if g.high.is_finite() { g.high.max(room).min(cap) } else { room };
        let from = if g.low.is_finite() { limits().fold(g.low.min(0.0), f64::min) } else { 0.0 };
        Span { from, to: if to > from { from + (to - from) * 1.06 } else { from + 1.0 } }
    }

    /// Where a value stands, pixels.
    fn at(self, value: f64) -> i32 {
        let share = ((value - self.from) / (self.to - self.from)).clamp(0.0, 1.0);
        BAR[0] + (share * f64::from(BAR[1] - BAR[0])).round() as i32
    }
}

fn draw_bar(area: &Area, g: &Gauge, span: Span) -> Drawn {
    let bar = |from: i32, to: i32, colour: RGBColor| {
        area.draw(&Rectangle::new([(from, SIDES[0]), (to, SIDES[1])], colour.filled())).map_err(quiet)
    };
    bar(BAR[0], BAR[1], TRACK)?;
    for (limit, colour) in [(g.warn, WARN), (g.fail, FAIL)] {
        match (limit, g.sense) {
            (Some(l), Sense::Min) => bar(BAR[0], span.at(l), colour)?,
            (Some(l), Sense::Max) => bar(span.at(l), BAR[1], colour)?,
            (None, _) => {}
        }
    }
    Ok(())
}

/// Ticks of the limits, and their words side by side beneath.
fn draw_limits(area: &Area, g: &Gauge, span: Span) -> Drawn {
    let mut ticks: Vec<(i32, String)> = [(g.fail, "must"), (g.warn, "should")]
        .into_iter()
        .filter_map(|(l, word)| l.map(|l| (span.at(l), format!("{word} {} {}", phrase::relation(g.sense), short(l)))))
        .collect();
    ticks.sort_by_key(|t| t.0);
    // A letter of 20 pixels is about 12 wide.
    let width = |text: &str| 12 * text.chars().count() as i32;
    let mut starts: Vec<i32> = Vec::new();
    for (x, text) in &ticks {
        let free = starts.last().zip(ticks.get(starts.len().wrapping_sub(1))).map_or(0, |(s, t)| s + width(&t.1) + 18);
        starts.push((x - width(text) / 2).max(free));
    }
    let mut room = WIDTH;
    for (start, (_, text)) in starts.iter_mut().zip(&ticks).rev() {
        *start = (*start).min(room - width(text)).max(0);
        room = *start - 18;
    }
    let style = TextStyle::from((FONT, 25).into_font()).color(&FAINT).pos(Pos::new(HPos::Left, VPos::Top));
    for (start, (x, text)) in starts.into_iter().zip(ticks) {
        area.draw(&Rectangle::new([(x - 1, SIDES[0] - 12), (x + 1, SIDES[1] + 12)], INK.filled())).map_err(quiet)?;
        area.draw(&Text::new(text, (start, SIDES[1] + 20), style.clone())).map_err(quiet)?;
    }
    Ok(())
}

/// The dot with its whiskers, or an arrow where the value lies beyond the end of the bar.
fn draw_value(area: &Area, g: &Gauge, span: Span) -> Drawn {
    let y = (SIDES[0] + SIDES[1]) / 2;
    if g.value > span.to {
        let tip = [(BAR[1] + 10, y), (BAR[1] - 12, y - 13), (BAR[1] - 12, y + 13)];
        return area.draw(&Polygon::new(tip, INK.filled())).map_err(quiet);
    }
    let (low, high) = (span.at(g.low), span.at(g.high));
    area.draw(&PathElement::new([(low, y), (high, y)], INK.stroke_width(4))).map_err(quiet)?;
    for x in [low, high] {
        area.draw(&PathElement::new([(x, y - 13), (x, y + 13)], INK.stroke_width(4))).map_err(quiet)?;
    }
    area.draw(&Circle::new((span.at(g.value), y), 9, INK.filled())).map_err(quiet)
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
    fn a_value_far_beyond_its_limits_is_an_arrow_and_the_words_stay_apart() {
        let far = Gauge { value: 200.0, low: 199.0, high: 201.0, ..GAUGE };
        let text = gauge(&far).into_string();
        assert!(text.contains("<polygon") && !text.contains("<circle"), "{text}");
        let x = |word: &str| {
            let at = text.rfind(word).unwrap(); // The label says the words first.
            let from = text[..at].rfind("<text x=\"").unwrap() + 9;
            text[from..].split('"').next().unwrap().parse::<i32>().unwrap()
        };
        assert!(x("should ≥") - x("must ≥") >= 12 * 10, "{text}");
    }
}
