//! Numbered pins: a shape and a colour for each state, faded where material hides the place.

use super::canvas::Canvas;
use super::colour::{PAPER, Rgb, state_colour};
use super::lettering::{Lettering, Style};
use crate::check::State;

/// A pin to be set.
pub struct Pin {
    pub number: usize,
    pub state: State,
    /// The place it marks, pixels.
    pub at: [f64; 2],
    /// Whether material stands before the place.
    pub hidden: bool,
    /// Whether it belongs to what the picture is about.
    pub own: bool,
}

/// Sets pins in order, the last drawn first so that number 1 is on top; none covers another or leaves `stage`.
pub fn set(canvas: &mut Canvas, letters: &Lettering, pins: &[Pin], stage: [f64; 4]) {
    let mut placed: Vec<[f64; 3]> = Vec::new();
    for pin in pins {
        let r = radius(pin);
        placed.push(free_place(pin.at, r, &placed, stage));
    }
    for (pin, place) in pins.iter().zip(&placed).rev() {
        let at = [place[0], place[1]];
        let cover = if pin.hidden || !pin.own { 0.55 } else { 1.0 };
        let colour = state_colour(pin.state);
        if (at[0] - pin.at[0]).hypot(at[1] - pin.at[1]) > 2.0 {
            canvas.line(pin.at, at, 3.4, PAPER, 0.8 * cover);
            canvas.line(pin.at, at, 1.6, colour, cover);
            canvas.disc(pin.at, 3.6, PAPER, cover);
            canvas.disc(pin.at, 2.4, colour, cover);
        }
        draw(canvas, letters, pin, at, colour, cover);
    }
}

fn radius(pin: &Pin) -> f64 {
    if pin.own { 13.0 } else { 10.0 }
}

fn draw(canvas: &mut Canvas, letters: &Lettering, pin: &Pin, [x, y]: [f64; 2], colour: Rgb, cover: f64) {
    let r = radius(pin);
    let (rim, inner) = (r, r - 2.0);
    match pin.state {
        State::Warn => {
            canvas.panel([x - rim, y - rim, x + rim, y + rim], 4.5, PAPER, cover);
            canvas.panel([x - inner, y - inner, x + inner, y + inner], 3.0, colour, cover);
        }
        _ => {
            canvas.disc([x, y], rim, PAPER, cover);
            canvas.disc([x, y], inner, colour, cover);
        }
    }
    let mut style = Style::bold(if pin.own { 13.0 } else { 10.5 }, PAPER);
    style.cover = cover.max(0.9);
    letters.draw_centred(canvas, [x, y + 0.36 * f64::from(style.em)], &pin.number.to_string(), &style);
}

/// The nearest place to `at`, on growing rings, where a disc of radius `r` meets no placed disc.
fn free_place(at: [f64; 2], r: f64, placed: &[[f64; 3]], [x0, y0, x1, y1]: [f64; 4]) -> [f64; 3] {
    let free = |p: [f64; 2]| {
        let inside = p[0] >= x0 + r && p[0] <= x1 - r && p[1] >= y0 + r && p[1] <= y1 - r;
        inside && placed.iter().all(|q| (p[0] - q[0]).hypot(p[1] - q[1]) >= r + q[2] + 1.0)
    };
    if free(at) {
        return [at[0], at[1], r];
    }
    for ring in 1..=6 {
        for step in 0..12 {
            // Up and to the sides first.
            let angle = -0.5 + f64::from(step / 2) * 0.2 * if step % 2 == 0 { 1.0 } else { -1.0 };
            let (s, c) = (angle * std::f64::consts::TAU * 0.5).sin_cos();
            let p = [at[0] + c * 14.0 * f64::from(ring), at[1] + s * 14.0 * f64::from(ring)];
            if free(p) {
                return [p[0], p[1], r];
            }
        }
    }
    [at[0].clamp(x0 + r, (x1 - r).max(x0 + r)), at[1].clamp(y0 + r, (y1 - r).max(y0 + r)), r]
}
