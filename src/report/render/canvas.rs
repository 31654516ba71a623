//! A grid of pixels, and the few shapes that stand over a picture, drawn with soft edges.

use super::colour::Rgb;

/// An opaque picture, rows from the top.
#[derive(Clone)]
pub struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<Rgb>,
}

impl Canvas {
    /// A canvas of one colour.
    pub fn new(width: usize, height: usize, ground: Rgb) -> Self {
        Canvas { width, height, pixels: vec![ground; width * height] }
    }

    pub fn width(&self) -> usize {
        self.width
    }

    pub fn height(&self) -> usize {
        self.height
    }

    /// The pixels in rows from the top.
    pub fn pixels(&self) -> &[Rgb] {
        &self.pixels
    }

    /// The colour of a pixel; black outside.
    #[inline]
    pub fn at(&self, x: usize, y: usize) -> Rgb {
        if x < self.width { self.pixels.get(y * self.width + x).copied().unwrap_or([0; 3]) } else { [0; 3] }
    }

    /// Sets a pixel; nothing happens outside.
    #[inline]
    pub fn set(&mut self, x: usize, y: usize, colour: Rgb) {
        if x < self.width
            && let Some(p) = self.pixels.get_mut(y * self.width + x)
        {
            *p = colour;
        }
    }

    /// Lays a colour over a pixel with a cover between 0 and 1.
    #[inline]
    pub fn blend(&mut self, x: i64, y: i64, colour: Rgb, cover: f64) {
        if x < 0 || y < 0 || cover <= 0.0 {
            return;
        }
        let (x, y) = (x as usize, y as usize);
        let under = self.at(x, y);
        let t = cover.min(1.0);
        self.set(x, y, [0, 1, 2].map(|c| (f64::from(under[c]) * (1.0 - t) + f64::from(colour[c]) * t).round() as u8));
    }

    /// Fills `[x0, y0, x1, y1]`, whose corners are rounded by `radius`, with a cover.
    pub fn panel(&mut self, [x0, y0, x1, y1]: [f64; 4], radius: f64, colour: Rgb, cover: f64) {
        let centre = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
        let half = [0.5 * (x1 - x0) - radius, 0.5 * (y1 - y0) - radius];
        self.shape([x0, y0, x1, y1], colour, cover, |x, y| {
            let d = [(x - centre[0]).abs() - half[0], (y - centre[1]).abs() - half[1]];
            length(d[0].max(0.0), d[1].max(0.0)) + d[0].max(d[1]).min(0.0) - radius
        });
    }

    /// Fills a disc.
    pub fn disc(&mut self, [cx, cy]: [f64; 2], radius: f64, colour: Rgb, cover: f64) {
        let box_ = [cx - radius, cy - radius, cx + radius, cy + radius];
        self.shape(box_, colour, cover, |x, y| length(x - cx, y - cy) - radius);
    }

    /// Draws a straight line with round ends.
    pub fn line(&mut self, [ax, ay]: [f64; 2], [bx, by]: [f64; 2], width: f64, colour: Rgb, cover: f64) {
        let r = 0.5 * width;
        let (ex, ey) = (bx - ax, by - ay);
        let length2 = (ex * ex + ey * ey).max(1e-12);
        let box_ = [ax.min(bx) - r, ay.min(by) - r, ax.max(bx) + r, ay.max(by) + r];
        self.shape(box_, colour, cover, |x, y| {
            let t = (((x - ax) * ex + (y - ay) * ey) / length2).clamp(0.0, 1.0);
            length(x - ax - t * ex, y - ay - t * ey) - r
        });
    }

    /// Fills where a signed distance in pixels is negative, with an edge one pixel soft.
    fn shape(&mut self, box_: [f64; 4], colour: Rgb, cover: f64, distance: impl Fn(f64, f64) -> f64) {
        let rows = (box_[1] - 1.0).max(0.0) as usize..((box_[3] + 2.0).max(0.0) as usize).min(self.height);
        let columns = (box_[0] - 1.0).max(0.0) as usize..((box_[2] + 2.0).max(0.0) as usize).min(self.width);
        for y in rows {
            for x in columns.clone() {
                let d = distance(x as f64 + 0.5, y as f64 + 0.5);
                self.blend(x as i64, y as i64, colour, cover * (0.5 - d).clamp(0.0, 1.0));
            }
        }
    }
}

/// √(x² + y²): lengths here are pixels, so that nothing can overflow, and the root is exact everywhere.
#[inline]
fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}
