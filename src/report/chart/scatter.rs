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
    // The numbers stand beside their dots, so that neither hides the other; dots in one place have a common label.
    let style = TextStyle::from((FONT, 15).into_font()).color(&INK);
    let (wide, high) = (most(support), most(|o| o.box_mm[2]));
    let places = together(&list.iter().map(|o| [at(o).0 / wide, at(o).1 / high]).collect::<Vec<_>>());
    let labels = places.iter().filter_map(|ranks| {
        let first = list.get(*ranks.first()?)?;
        Some(EmptyElement::at(at(first)) + Text::new(label(ranks), (8, -8), style.clone()))
    });
    chart.draw_series(labels).map_err(quiet)?;
    Ok(())
}

/// Points of the unit square whose labels would lie on each other, by their places in the list: each with the first that is so near.
fn together(points: &[[f64; 2]]) -> Vec<Vec<usize>> {
    let mut places: Vec<Vec<usize>> = Vec::new();
    for (n, p) in points.iter().enumerate() {
        let near = |q: &[f64; 2]| (p[0] - q[0]).abs() < NEAR[0] && (p[1] - q[1]).abs() < NEAR[1];
        match places.iter_mut().find(|place| place.first().and_then(|&first| points.get(first)).is_some_and(near)) {
            Some(place) => place.push(n),
            None => places.push(vec![n]),
        }
    }
    places
}

/// Shares of width and height within which one number hides another.
const NEAR: [f64; 2] = [0.045, 0.06];

/// The ranks of dots in one place, the first few of many.
fn label(ranks: &[usize]) -> String {
    const TOLD: usize = 4;
    let told: Vec<String> = ranks.iter().take(TOLD).map(|n| (n + 1).to_string()).collect();
    let more = if ranks.len() > TOLD { ", …" } else { "" };
    told.join(", ") + more
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_in_one_place_have_a_common_label() {
        let places = together(&[[0.5, 0.5], [0.1, 0.9], [0.51, 0.52], [0.5, 0.7], [0.1, 0.9]]);
        assert_eq!(places, [vec![0, 2], vec![1, 4], vec![3]]);
        assert_eq!(places.iter().map(|p| label(p)).collect::<Vec<_>>(), ["1, 3", "2, 5", "4"]);
        assert_eq!(label(&[0, 1, 2, 3, 4, 5]), "1, 2, 3, 4, …");
        assert!(together(&[]).is_empty());
    }
}
