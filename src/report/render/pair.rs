//! Two shapes side by side: before and after an operation.

use super::camera::Camera;
use super::canvas::Canvas;
use super::colour::{FAINT, INK, PAPER, STAGE, Scale};
use super::lettering::{Lettering, Style};
use super::paint::{self, Paint, SAMPLES};
use super::png;
use super::raster::{Faces, Raster};
use super::sides::Sides;
use super::view::scale_bar;
use crate::check::Sense;
use crate::error::printable;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;

/// Height of the title over a panel.
const TITLE: usize = 56;

/// A shape in a picture of several.
pub struct Panel<'a> {
    /// Closed and wound outwards; without facets the panel stays empty.
    pub mesh: &'a TriangleMesh,
    /// What it is.
    pub title: &'a str,
    /// What is known of it, in a line.
    pub caption: &'a str,
}

/// Shapes side by side, all from one side and at one scale: a PNG of panels `[width, height]` each.
///
/// # Cost
/// O(facets + pixels) for each panel.
pub fn side_by_side(panels: &[Panel], [width, height]: [usize; 2]) -> Vec<u8> {
    let letters = Lettering::new();
    let corners: Vec<Vec<Vec3>> = panels.iter().map(|p| corners(p.mesh)).collect();
    let n = SAMPLES as f64;
    let (w, h) = (width as f64, height as f64);
    let stage = [20.0 * n, 16.0 * n, (w - 20.0) * n, (h - 40.0) * n];
    // The side is chosen by the last shape: it is the one that was made.
    let side =
        corners.last().map_or(Camera::from_side([-58.0, 28.0]), |c| Sides::new(c, Faces::Front).best(&[], None, 0.0));
    let camera = side.fitted(corners.iter().flatten().copied(), stage);
    let mut picture = Canvas::new(width * panels.len().max(1), height + TITLE, PAPER);
    let bare = Scale { low: 0.0, high: 1.0, fail: None, warn: None, sense: Sense::Min };
    for (at, (panel, corners)) in panels.iter().zip(&corners).enumerate() {
        let mut canvas = Canvas::new(width, height, STAGE);
        let raster = Raster::new(corners, &camera, SAMPLES * width, SAMPLES * height, Faces::Front);
        paint::paint(&mut canvas, &raster, corners, &camera, &Paint { scale: bare, values: &[] });
        scale_bar(&mut canvas, &letters, camera.scale / n, [w - 14.0, h - 14.0], 0.3 * w);
        for y in 0..height {
            for x in 0..width {
                picture.set(at * width + x, TITLE + y, canvas.at(x, y));
            }
        }
        let left = (at * width) as f64 + 14.0;
        let (bold, small) = (Style::bold(15.0, INK), Style::regular(12.5, FAINT));
        for (text, y, style) in [(panel.title, 23.0, &bold), (panel.caption, 44.0, &small)] {
            letters.draw(&mut picture, [left, y], &letters.fitted(&printable(text), style, w - 28.0), style);
        }
        if at > 0 {
            picture.line([left - 14.0, 0.0], [left - 14.0, h + TITLE as f64], 1.0, [205, 212, 218], 1.0);
        }
    }
    png::encode(&picture, 64)
}

/// Three corners for each facet.
fn corners(mesh: &TriangleMesh) -> Vec<Vec3> {
    (0..mesh.triangles.len()).flat_map(|f| mesh.corners(f)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::units::Length;

    #[test]
    fn panels_stand_side_by_side_and_the_bytes_do_not_change() {
        let [small, large] = ["box:2x2x2mm", "ball:3mm"].map(|s| Primitive::parse(s).unwrap().mesh(Length::mm(0.1)));
        let panels = [
            Panel { mesh: &small, title: "before", caption: "8 mm³" },
            Panel { mesh: &large, title: "after", caption: "" },
            Panel { mesh: &TriangleMesh::default(), title: "nothing", caption: "0 mm³" },
        ];
        let png = side_by_side(&panels, [200, 150]);
        assert_eq!(png, side_by_side(&panels, [200, 150]));
        let decoded = image::load_from_memory(&png).unwrap().to_rgb8();
        assert_eq!(decoded.dimensions(), (600, 150 + TITLE as u32));
        let painted = |panel: u32| {
            let pixel = |x: u32, y: u32| decoded.get_pixel(200 * panel + x, TITLE as u32 + y).0;
            (20..180).flat_map(|x| (5..110).map(move |y| (x, y))).filter(|&(x, y)| pixel(x, y) != pixel(2, 2)).count()
        };
        // One scale: the smaller shape covers less.
        assert!(painted(0) > 100 && painted(1) > painted(0) && painted(2) < 100, "{:?}", [0, 1, 2].map(painted));
    }
}
