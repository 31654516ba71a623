//! Letters on a canvas, from a font that stands beside the code.

use super::canvas::Canvas;
use super::colour::Rgb;
use ab_glyph::{Font, FontRef, Glyph, ScaleFont, point};

/// DejaVu Sans, cut down to Latin and the signs used here; its licence stands beside it.
const REGULAR: &[u8] = include_bytes!("../assets/DejaVuSans-subset.ttf");
const BOLD: &[u8] = include_bytes!("../assets/DejaVuSans-Bold-subset.ttf");

/// Weight of letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    Regular,
    Bold,
}

/// Height, weight and colour of letters.
#[derive(Debug, Clone, Copy)]
pub struct Style {
    /// Height of the em square, pixels.
    pub em: f32,
    pub weight: Weight,
    pub colour: Rgb,
    /// 1 is opaque.
    pub cover: f64,
}

impl Style {
    /// Regular, opaque letters.
    pub fn regular(em: f32, colour: Rgb) -> Self {
        Style { em, weight: Weight::Regular, colour, cover: 1.0 }
    }

    /// Bold, opaque letters.
    pub fn bold(em: f32, colour: Rgb) -> Self {
        Style { em, weight: Weight::Bold, colour, cover: 1.0 }
    }
}

/// The fonts, ready to draw.
pub struct Lettering {
    regular: Option<FontRef<'static>>,
    bold: Option<FontRef<'static>>,
}

impl Lettering {
    /// The fonts that stand beside the code.
    pub fn new() -> Self {
        let font = |bytes| FontRef::try_from_slice(bytes).ok();
        Lettering { regular: font(REGULAR), bold: font(BOLD) }
    }

    fn font(&self, weight: Weight) -> Option<&FontRef<'static>> {
        match weight {
            Weight::Regular => self.regular.as_ref(),
            Weight::Bold => self.bold.as_ref(),
        }
    }

    /// Glyphs of a line that starts at the origin of its baseline, and the length of the line.
    fn set(&self, text: &str, style: &Style) -> (Vec<Glyph>, f32) {
        let Some(font) = self.font(style.weight) else { return (Vec::new(), 0.0) };
        // ab_glyph scales by the height of a line; an em is what designers count in.
        let height = font.height_unscaled() / font.units_per_em().unwrap_or(2048.0) * style.em;
        let scaled = font.as_scaled(height);
        let (mut x, mut last, mut glyphs) = (0.0, None, Vec::new());
        for c in text.chars() {
            let id = scaled.glyph_id(if c.is_control() { '\u{fffd}' } else { c });
            x += last.map_or(0.0, |l| scaled.kern(l, id));
            glyphs.push(id.with_scale_and_position(height, point(x, 0.0)));
            x += scaled.h_advance(id);
            last = Some(id);
        }
        (glyphs, x)
    }

    /// The length of a line, pixels.
    pub fn width(&self, text: &str, style: &Style) -> f64 {
        f64::from(self.set(text, style).1)
    }

    /// Draws a line from the left end of its baseline; returns where it ends.
    pub fn draw(&self, canvas: &mut Canvas, [x, y]: [f64; 2], text: &str, style: &Style) -> f64 {
        let (glyphs, length) = self.set(text, style);
        let Some(font) = self.font(style.weight) else { return x };
        for mut glyph in glyphs {
            glyph.position = point(glyph.position.x + x as f32, y as f32);
            if let Some(outline) = font.outline_glyph(glyph) {
                let at = outline.px_bounds().min;
                outline.draw(|i, j, cover| {
                    let place = (at.x as i64 + i64::from(i), at.y as i64 + i64::from(j));
                    canvas.blend(place.0, place.1, style.colour, f64::from(cover) * style.cover);
                });
            }
        }
        x + f64::from(length)
    }

    /// Draws a line that ends at `x`.
    pub fn draw_right(&self, canvas: &mut Canvas, [x, y]: [f64; 2], text: &str, style: &Style) {
        self.draw(canvas, [x - self.width(text, style), y], text, style);
    }

    /// Draws a line centred on `x`.
    pub fn draw_centred(&self, canvas: &mut Canvas, [x, y]: [f64; 2], text: &str, style: &Style) {
        self.draw(canvas, [x - 0.5 * self.width(text, style), y], text, style);
    }

    /// The text, cut with an ellipsis to a length in pixels.
    pub fn fitted(&self, text: &str, style: &Style, length: f64) -> String {
        if self.width(text, style) <= length {
            return text.into();
        }
        let mut kept: Vec<char> = text.chars().collect();
        while kept.pop().is_some() {
            let cut: String = kept.iter().copied().chain(['…']).collect();
            if self.width(&cut, style) <= length {
                return cut;
            }
        }
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_fonts_hold_every_sign_that_is_used() {
        let letters = Lettering::new();
        for font in [letters.regular.unwrap(), letters.bold.unwrap()] {
            for c in "✖▲✔?–!≥≤×°²³µ…−–·←→0123456789%éÄß\u{fffd}".chars() {
                assert_ne!(font.glyph_id(c).0, 0, "{c}");
            }
        }
    }
}
