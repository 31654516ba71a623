//! A slice through the part: hatched material, outline, pins, scale bar.

use super::canvas::Canvas;
use super::colour::{FAINT, INK, PAPER, Rgb, STAGE};
use super::lettering::{Lettering, Style};
use super::pin::{self, Pin};
use super::view::scale_bar;
use super::{Picture, png};
use crate::error::printable;
use crate::report::exhibit::Slice;
use crate::report::phrase::{self, Numbered};
use crate::report::schema::Report;

/// Longest sides of the drawing inside the frame.
const ROOM: [f64; 2] = [860.0, 540.0];
const MARGIN: f64 = 24.0;
const TITLE: f64 = 44.0;
/// Colour of cut material, and of the lines that hatch it.
const CUT: [Rgb; 2] = [[150, 168, 183], [176, 191, 203]];

/// The picture of a slice; rows of the slice run upwards.
pub fn picture(report: &Report, slice: &Slice, findings: &[Numbered], letters: &Lettering) -> Picture {
    let (columns, rows) = (slice.width.max(1) as f64, slice.height.max(1) as f64);
    let zoom = (ROOM[0] / columns).min(ROOM[1] / rows);
    let (inner_w, inner_h) = ((columns * zoom).max(420.0), rows * zoom);
    let (w, h) = (inner_w + 2.0 * MARGIN, inner_h + TITLE + 2.0 * MARGIN + 26.0);
    let mut canvas = Canvas::new(w as usize, h as usize, STAGE);
    let corner = [0.5 * (w - columns * zoom), TITLE + MARGIN];
    material(&mut canvas, slice, corner, zoom);
    let place = |[u, v]: [f64; 2]| {
        let c = [(u - slice.origin_mm[0]) / slice.spacing_mm + 0.5, (v - slice.origin_mm[1]) / slice.spacing_mm + 0.5];
        [corner[0] + c[0] * zoom, corner[1] + (rows - c[1]) * zoom]
    };
    let pins: Vec<Pin> = slice
        .pins
        .iter()
        .filter_map(|&(number, at)| {
            let n = findings.iter().find(|n| n.number == number)?;
            Some(Pin { number, state: n.shown(), at: place(at), hidden: false, own: true })
        })
        .collect();
    pin::set(&mut canvas, letters, &pins, [0.0, TITLE, w, h]);
    let axis = ["x", "y", "z"].get(slice.axis).copied().unwrap_or("?");
    title(
        &mut canvas,
        letters,
        report,
        &format!("Slice at {axis} = {}", phrase::quantity((slice.at_mm * 100.0).round() / 100.0, "mm")),
    );
    let remaining: Vec<&str> = ["x", "y", "z"].into_iter().filter(|a| *a != axis).collect();
    let directions = format!("{} →   {} ↑", remaining[0], remaining[1]);
    letters.draw(&mut canvas, [MARGIN, h - 18.0], &directions, &Style::regular(12.5, FAINT));
    scale_bar(&mut canvas, letters, zoom / slice.spacing_mm.max(1e-12), [w - MARGIN, h - 20.0], 150.0);
    let numbers: Vec<String> = slice.pins.iter().map(|p| p.0.to_string()).collect();
    let pins = if numbers.is_empty() { String::new() } else { format!("; pins {}", numbers.join(", ")) };
    let alt = format!("Slice of the part at {axis} = {} mm{pins}.", phrase::quantity(slice.at_mm, "1"));
    Picture { name: format!("slice-{axis}"), png: png::encode(&canvas, 48), alt }
}

fn title(canvas: &mut Canvas, letters: &Lettering, report: &Report, text: &str) {
    let w = canvas.width() as f64;
    canvas.panel([0.0, 0.0, w, TITLE], 0.0, PAPER, 1.0);
    canvas.line([0.0, TITLE], [w, TITLE], 1.0, [205, 212, 218], 1.0);
    let end = letters.draw(canvas, [MARGIN - 6.0, 28.0], text, &Style::bold(16.0, INK));
    let small = Style::regular(13.0, FAINT);
    let name = letters.fitted(&printable(&report.part.file), &small, (w - end - 2.0 * MARGIN).max(0.0));
    letters.draw_right(canvas, [w - MARGIN, 28.0], &name, &small);
}

/// Paints the material: between samples the density is interpolated, and a sheet thinner than a sample stays grey.
fn material(canvas: &mut Canvas, slice: &Slice, [x0, y0]: [f64; 2], zoom: f64) {
    let (columns, rows) = (slice.width, slice.height);
    if slice.density.len() != columns * rows || columns == 0 {
        return;
    }
    let at = |i: i64, j: i64| {
        let inside = i >= 0 && j >= 0 && i < columns as i64 && j < rows as i64;
        if inside { f64::from(slice.density[j as usize * columns + i as usize]) } else { 0.0 }
    };
    let (w, h) = ((columns as f64 * zoom) as usize, (rows as f64 * zoom) as usize);
    let sharp = zoom.max(1.0);
    for py in 0..h {
        let v = rows as f64 - (py as f64 + 0.5) / zoom - 0.5;
        let (j, fv) = (v.floor(), v - v.floor());
        for px in 0..w {
            let u = (px as f64 + 0.5) / zoom - 0.5;
            let (i, fu) = (u.floor(), u - u.floor());
            let (i, j) = (i as i64, j as i64);
            let d = (at(i, j) * (1.0 - fu) + at(i + 1, j) * fu) * (1.0 - fv)
                + (at(i, j + 1) * (1.0 - fu) + at(i + 1, j + 1) * fu) * fv;
            if d <= 0.0 {
                continue;
            }
            let cover = ((d - 0.5) * sharp + 0.5).clamp(0.0, 1.0).max(d);
            let (x, y) = (x0 as i64 + px as i64, y0 as i64 + py as i64);
            let line = usize::from((x + y) % 8 < 2);
            canvas.blend(x, y, CUT[line], cover);
            // The outline: where the density passes one half, one pixel to each side.
            let rim = 1.0 - ((d - 0.5).abs() * sharp / 1.2).min(1.0);
            canvas.blend(x, y, INK, 0.9 * rim);
        }
    }
}
