//! The choice of a side: small depth buffers from all around say what each side really shows.

use super::camera::{Camera, SIDES};
use super::raster::{Faces, NOTHING, Raster};
use crate::geometry::vector::Vec3;
use rayon::prelude::*;

/// Width and height of the small buffers.
const SMALL: [usize; 2] = [192, 144];

/// The part from all sides, small.
pub struct Sides {
    seen: Vec<(Camera, Raster)>,
}

impl Sides {
    /// Depth buffers of the facets from each side.
    ///
    /// # Cost
    /// O(sides · facets).
    pub fn new(corners: &[Vec3], faces: Faces) -> Self {
        let [w, h] = SMALL;
        let look = |side: &[f64; 2]| {
            let frame = [1.0, 1.0, w as f64 - 1.0, h as f64 - 1.0];
            let camera = Camera::from_side(*side).fitted(corners.iter().copied(), frame);
            (camera, Raster::new(corners, &camera, w, h, faces))
        };
        Sides { seen: SIDES.par_iter().map(look).collect() }
    }

    /// The side that shows most of the marked facets and, above that, does not hide the place.
    ///
    /// A place counts as shown with at most `skin_mm` of material before it. Without marks and without a place it
    /// is the usual side, from the front and above.
    pub fn best(&self, marked: &[bool], place: Option<Vec3>, skin_mm: f64) -> Camera {
        let marks = |r: &Raster| {
            let marked = |f: &&u32| **f != NOTHING && marked.get(**f as usize).copied().unwrap_or(false);
            r.facet.iter().filter(marked).count()
        };
        let counts: Vec<usize> = self.seen.iter().map(|(_, r)| marks(r)).collect();
        let most = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
        let mut best: Option<(f64, Camera)> = None;
        for (order, ((camera, raster), count)) in self.seen.iter().zip(counts).enumerate() {
            let shown = place.is_some_and(|p| !hidden(raster, camera, p, skin_mm));
            let score = count as f64 / most + if shown { 0.6 } else { 0.0 } - 0.05 * order as f64;
            if best.is_none_or(|b| score > b.0) {
                best = Some((score, *camera));
            }
        }
        best.map_or(Camera::from_side(SIDES[0]), |b| b.1)
    }
}

/// Whether more than `skin_mm` of space lies between a place and the surface that is seen before it.
pub fn hidden(raster: &Raster, camera: &Camera, place: Vec3, skin_mm: f64) -> bool {
    let [x, y, z] = camera.project(place);
    let inside = x >= 0.0 && y >= 0.0 && x < raster.width as f64 && y < raster.height as f64;
    let at = y.max(0.0) as usize * raster.width + x.max(0.0) as usize;
    inside && raster.depth.get(at).is_some_and(|&d| f64::from(d) > z + skin_mm * camera.scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_side_without_a_wall_before_the_place_is_chosen() {
        // A wall across x = 1 hides the origin from +x.
        let wall: Vec<Vec3> = vec![[1.0, -9.0, -9.0], [1.0, 9.0, -9.0], [1.0, 0.0, 18.0]];
        let sides = Sides::new(&wall, Faces::Both);
        assert!(sides.best(&[], Some([0.0; 3]), 0.1).toward[0] < 0.0);
        // Seen from behind, a wound facet shows only its marked face.
        let sides = Sides::new(&wall, Faces::Front);
        assert!(sides.best(&[true], None, 0.1).toward[0] > 0.0);
        let back: Vec<Vec3> = wall.into_iter().rev().collect();
        assert!(Sides::new(&back, Faces::Front).best(&[true], None, 0.1).toward[0] < 0.0);
    }
}
