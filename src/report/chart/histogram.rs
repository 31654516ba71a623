//! The histogram of a map: how the measured surface is spread over its values.

use super::drawing::{Area, Drawn, FAIL, FAINT, FONT, GOOD, INK, PAPER, TRACK, WARN, quiet, svg};
use crate::geometry::vector::{Vec3, cross, norm, sub};
use crate::report::exhibit::SurfaceMap;
use crate::report::markup::Markup;
use crate::report::phrase;
use crate::report::render::colour::{Scale, Zone};
use crate::units::short;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

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
    svg(560, 250, &label, |area| draw_histogram(area, map, &scale, &shares))
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

/// Axes, bars, limits.
fn draw_histogram(area: &Area, map: &SurfaceMap, scale: &Scale, shares: &[f64]) -> Drawn {
    let top = top_of(shares);
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(46)
        .y_label_area_size(64)
        .build_cartesian_2d(scale.low..scale.high, 0.0..top)
        .map_err(quiet)?;
    let text = || TextStyle::from((FONT, 17).into_font()).color(&FAINT);
    let unit = phrase::unit_sign(&map.unit);
    chart
        .configure_mesh()
        .disable_x_mesh()
        .y_labels(4)
        .x_labels(7)
        .light_line_style(TRANSPARENT)
        .bold_line_style(TRACK)
        .axis_style(FAINT)
        .label_style(text())
        .axis_desc_style(text())
        .x_desc(if unit.is_empty() { map.title.clone() } else { format!("{} ({unit})", map.title) })
        .y_desc("% of surface")
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .draw()
        .map_err(quiet)?;
    chart.draw_series(bars(scale, shares, top)).map_err(quiet)?;
    draw_limits(&mut chart, scale, top)?;
    draw_cut_off(&mut chart, scale, shares, top)
}

/// Height of the axis: the tallest bar fits, but for the last, which holds all beyond the open end and would make the others vanish.
fn top_of(shares: &[f64]) -> f64 {
    let [inner @ .., last] = shares else { return 1.0 };
    let inner = inner.iter().copied().fold(0.0, f64::max);
    let tallest = if inner > 0.0 && *last > 3.0 * inner { 1.4 * inner } else { inner.max(*last) };
    1.18 * tallest.max(0.01)
}

/// A bar for each share, cut off at the top; a bar that holds a limit changes its colour there.
fn bars(scale: &Scale, shares: &[f64], top: f64) -> Vec<Rectangle<(f64, f64)>> {
    let step = (scale.high - scale.low) / shares.len() as f64;
    let mut out = Vec::new();
    for (i, share) in shares.iter().enumerate().filter(|(_, s)| **s > 0.0) {
        let (from, to) = (scale.low + i as f64 * step, scale.low + (i + 1) as f64 * step);
        let limits = [scale.fail, scale.warn].into_iter().flatten();
        let mut cuts: Vec<f64> = limits.filter(|l| *l > from && *l < to).chain([from, to]).collect();
        cuts.sort_by(f64::total_cmp);
        for piece in cuts.windows(2) {
            let colour = match scale.zone((0.5 * (piece[0] + piece[1])) as f32) {
                Zone::Fail => FAIL,
                Zone::Warn => WARN,
                _ => GOOD,
            };
            out.push(Rectangle::new([(piece[0], 0.0), (piece[1], share.min(top))], colour.filled()));
        }
    }
    out
}

/// The axes of a histogram.
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// What the last bar comes to where it is cut off.
fn draw_cut_off(chart: &mut Chart, scale: &Scale, shares: &[f64], top: f64) -> Drawn {
    let Some(last) = shares.last().filter(|s| **s > top) else { return Ok(()) };
    let share = if *last > 99.9 && *last < 100.0 { "over 99.9".into() } else { short((last * 10.0).round() / 10.0) };
    let words = format!("{share} % here ↑");
    let side_of_scale = scale.high - scale.low;
    let (right, width) = (scale.high - 0.03 * side_of_scale, 0.021 * words.chars().count() as f64 * side_of_scale);
    let ground = Rectangle::new([(right - width, 0.66 * top), (right, 0.56 * top)], PAPER.filled());
    chart.draw_series([ground]).map_err(quiet)?;
    let style = TextStyle::from((FONT, 16).into_font()).color(&INK).pos(Pos::new(HPos::Right, VPos::Center));
    chart.draw_series([Text::new(words, (right, 0.61 * top), style)]).map_err(quiet)?;
    Ok(())
}

/// A line at each limit, with its words.
fn draw_limits(chart: &mut Chart, scale: &Scale, top: f64) -> Drawn {
    let mut limits: Vec<(f64, &str)> = [(scale.fail, "must"), (scale.warn, "should")]
        .into_iter()
        .filter_map(|(limit, word)| limit.filter(|l| *l > scale.low && *l < scale.high).map(|l| (l, word)))
        .collect();
    limits.sort_by(|a, b| a.0.total_cmp(&b.0));
    let lines = limits.iter().map(|(l, _)| PathElement::new([(*l, 0.0), (*l, top)], INK.stroke_width(2)));
    chart.draw_series(lines).map_err(quiet)?;
    let side_of_scale = scale.high - scale.low;
    for (i, (l, word)) in limits.iter().enumerate() {
        // The last limit has its words on its right. One before it has them on its left, or, where there is no room,
        // lower on its right over the other line.
        let last = i + 1 == limits.len();
        let room = (l - scale.low) / side_of_scale >= 0.25;
        let (side, offset, at) = match (last, room) {
            (true, _) => (HPos::Left, 0.012, 0.985),
            (false, true) => (HPos::Right, -0.012, 0.985),
            (false, false) => (HPos::Left, 0.012, 0.88),
        };
        let words = format!("{word} {} {}", phrase::relation(scale.sense), short(*l));
        let x = l + offset * side_of_scale;
        if !last && !room {
            let width = 0.021 * words.chars().count() as f64 * side_of_scale;
            let ground = Rectangle::new([(x, top * (at + 0.01)), (x + width, top * (at - 0.085))], PAPER.filled());
            chart.draw_series([ground]).map_err(quiet)?;
        }
        let style = TextStyle::from((FONT, 16).into_font()).color(&INK).pos(Pos::new(side, VPos::Top));
        chart.draw_series([Text::new(words, (x, top * at), style)]).map_err(quiet)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::Sense;

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
            fills: None,
            values: vec![0.05, 0.05, 0.05, 9.0, 9.0, 9.0],
        };
        let shares = shares(&map, &corners, &Scale::of(&map));
        assert_eq!((shares[0], shares[BARS - 1]), (10.0, 90.0));
        assert!(top_of(&shares) > 10.0 && top_of(&shares) < 20.0, "the last bar decides the axis");
        assert!(histogram(&map, &corners).into_string().contains("90 % here"));
        assert!(!histogram(&map, &corners).into_string().contains("</svg>\n("));
    }
}
