//! A small picture of the part as it would stand on the plate.

use super::camera::{Camera, SIDES};
use super::canvas::Canvas;
use super::colour::{STAGE, Scale};
use super::paint::{Paint, SAMPLES, paint};
use super::raster::{Faces, Raster};
use super::{Picture, png};
use crate::check::Sense;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;

/// Width and height of a thumbnail.
const SMALL: [usize; 2] = [300, 220];

/// The part in a pose, seen from the front and a little from below, with the facets that need support painted.
///
/// # Cost
/// O(facets + pixels).
pub fn stance(name: &str, posed: &TriangleMesh, needs_support: &[bool]) -> Picture {
    let corners: Vec<Vec3> = (0..posed.triangles.len()).flat_map(|f| posed.corners(f)).collect();
    let values: Vec<f32> = (0..posed.triangles.len())
        .flat_map(|f| [if needs_support.get(f).copied().unwrap_or(false) { 0.0 } else { 1.0 }; 3])
        .collect();
    let [w, h] = SMALL;
    let n = SAMPLES as f64;
    let frame = [12.0 * n, 12.0 * n, (w as f64 - 12.0) * n, (h as f64 - 12.0) * n];
    let [azimuth, _] = SIDES[0];
    let camera = Camera::from_side([azimuth, -18.0]).fitted(posed.vertices.iter().copied(), frame);
    let mut canvas = Canvas::new(w, h, STAGE);
    let raster = Raster::new(&corners, &camera, SAMPLES * w, SAMPLES * h, Faces::Both);
    let scale = Scale { low: 0.0, high: 1.0, fail: None, warn: Some(0.5), sense: Sense::Min };
    paint(&mut canvas, &raster, &corners, &camera, &Paint { scale, values: &values });
    let alt = format!("The part in orientation {name}, seen from below; what needs support is hatched.");
    Picture { name: name.into(), png: png::encode(&canvas, 64), alt }
}
