//! Orientations in a plane: support volume against height.

use super::drawing::{Area, Drawn, FAINT, FONT, GOOD, INK, TRACK, quiet, svg};
use crate::access::Orientation;
use crate::report::markup::Markup;
use crate::units::short;
use plotters::prelude::*;

/// Each orientation as a numbered dot at its support volume and height; filled dark where no other beats it in everything.
///
/// # Cost
/// O(orientations).
pub fn orientations(list: &[Orientation]) -> Markup {
    svg(620, 340, "Orientations: support volume against height of the part", |area| draw(area, list))
}

fn draw(area: &Area, list: &[Orientation]) -> Drawn {
    let most = |value: fn(&Orientation) -> f64| list.iter().map(value).fold(0.0, f64::max).max(1e-3) * 1.12;
    let support = |o: &Orientation| o.support_mm3 / 1000.0;
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(48)
        .y_label_area_size(64)
        .build_cartesian_2d(0.0..most(support), 0.0..most(|o| o.box_mm[2]))
        .map_err(quiet)?;
    let text = || TextStyle::from((FONT, 17).into_font()).color(&FAINT);
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(TRACK)
        .axis_style(FAINT)
        .label_style(text())
        .axis_desc_style(text())
        .x_desc("Support (cm³)")
        .y_desc("Height (mm)")
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .draw()
        .map_err(quiet)?;
    let at = |o: &Orientation| (support(o), o.box_mm[2]);
    let dots = list.iter().map(|o| Circle::new(at(o), 6, if o.pareto { INK } else { GOOD }.filled()));
    chart.draw_series(dots).map_err(quiet)?;
    // The letters stand beside their dots, so that neither hides the other.
    let style = TextStyle::from((FONT, 15).into_font()).color(&INK);
    let labels = list
        .iter()
        .enumerate()
        .map(|(n, o)| EmptyElement::at(at(o)) + Text::new((n + 1).to_string(), (8, -8), style.clone()));
    chart.draw_series(labels).map_err(quiet)?;
    Ok(())
}
