//! Samples of a void that are wider than all beside them, by the distance to the surface itself.

use super::throat::Stands;
use super::void::{HALF_DIAGONAL, LEAST_RISE, Voids};
use crate::field::{Field, Indicator};
use crate::geometry::vector::Vec3;
use crate::grid::Grid;
use rayon::prelude::*;

/// A sample that no sample beside it is wider than.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Peak {
    /// Its distance to the surface, mm.
    pub distance_mm: f64,
    /// Its offset in storage.
    pub at: usize,
}

/// What the distances of samples are measured by.
struct Measuring<'a> {
    voids: &'a Voids<'a>,
    grid: Grid,
    extent: Vec3,
    clearance: &'a [u32],
    /// Samples from which a ball of the limit gets out over the whole grid.
    outside: &'a Indicator,
    limit_mm: f64,
    /// Squared clearances between which samples are measured.
    between: [f64; 2],
}

impl Voids<'_> {
    /// The peaks of the distance to the surface, the highest first, beside which the middle of a ball of `room_mm` may lie, where no ball of
    /// `limit_mm` stands outside and the whole grid does not tell room from way out for certain.
    ///
    /// A sample is passed over if what fits there, and is a quarter wider than what would have to get out, is let out by a ball of the limit beside it.
    ///
    /// # Cost
    /// O(samples), and a distance for each that may be one.
    pub(super) fn peaks(&self, clearance: &Field<u32>, stands: &Stands, (room_mm, limit_mm): (f64, f64)) -> Vec<Peak> {
        let (grid, outside) = (*clearance.grid(), stands.outside());
        let radius = |diameter: f64| 0.5 * diameter / grid.h();
        let least = (radius(room_mm) - 2.0 * HALF_DIAGONAL).max(0.0);
        // What is wider is told by the whole grid where no ball of the limit gets out.
        let most = LEAST_RISE * (radius(limit_mm) + HALF_DIAGONAL) + 4.0 * HALF_DIAGONAL;
        let values = clearance.values();
        let (outside, between) = (&outside, [least * least, most * most]);
        let extent = self.part().extent();
        let measuring = Measuring { voids: self, grid, extent, clearance: values, outside, limit_mm, between };
        let nz = grid.dims()[2];
        let mut layers: Vec<Layer> = (0..nz.min(2)).map(|k| measuring.layer(k)).collect();
        let mut peaks = Vec::new();
        for k in 0..nz {
            peaks.extend(measuring.peaks_of(k, &layers));
            if k + 2 < nz {
                if layers.len() == 3 {
                    layers.remove(0);
                }
                layers.push(measuring.layer(k + 2));
            }
        }
        peaks.sort_by(|a, b| b.distance_mm.total_cmp(&a.distance_mm).then(a.at.cmp(&b.at)));
        peaks
    }
}

/// The distances of one layer of samples.
struct Layer {
    k: usize,
    /// At least so far is the surface, in mm; 0 where the part touches.
    least: Vec<f32>,
    /// Which of them are measured.
    measured: Vec<bool>,
}

impl Measuring<'_> {
    fn layer(&self, k: usize) -> Layer {
        let [nx, ny, _] = self.grid.dims();
        let first = k * nx * ny;
        let told = (first..first + nx * ny).into_par_iter().with_min_len(nx).map(|at| match self.clearance[at] {
            0 => (0.0, false),
            c if self.is_wanted(at, f64::from(c)) => {
                let far = (f64::from(c).sqrt() + 2.0 * HALF_DIAGONAL) * self.grid.h();
                let near = self.voids.part().distance().nearest(self.voids.place(at), far);
                (near.map_or(far, |near| near.distance) as f32, true)
            }
            c => (((f64::from(c).sqrt() - HALF_DIAGONAL) * self.grid.h()) as f32, false),
        });
        let (least, measured) = told.unzip();
        Layer { k, least, measured }
    }

    fn is_wanted(&self, at: usize, clearance: f64) -> bool {
        let [least, most] = self.between;
        let index = self.grid.index(at);
        // The middle of a room lies in the part's box, half a sample or less along each axis from its own.
        let half = 0.5 * self.grid.h();
        let is_within = (0..3).all(|a| (-half..=self.extent[a] + half).contains(&self.grid.position(index)[a]));
        is_within
            && (least..most).contains(&clearance)
            && !self.outside.contains(index)
            && !self.is_let_out(index, clearance)
    }

    /// Whether a ball of the limit that stands outside, so many samples along an axis away, lets out all that may fit at a sample.
    fn is_let_out(&self, index: [usize; 3], clearance: f64) -> bool {
        let radius = 0.5 * self.limit_mm / self.grid.h();
        // On the way between them a ball finds at least half of both distances less the way, and has to be the limit's or a quarter narrower.
        let fits = (clearance.sqrt() + HALF_DIAGONAL).min(LEAST_RISE * radius);
        let far = radius + 0.5 + fits - 2.0 * (fits / LEAST_RISE);
        let dims = self.grid.dims();
        (1..=far.max(0.0) as usize).any(|n| {
            (0..3).any(|a| {
                let stands = |x: Option<usize>| {
                    let mut beside = index;
                    x.filter(|&x| x < dims[a]).is_some_and(|x| {
                        beside[a] = x;
                        self.outside.contains(beside)
                    })
                };
                stands(index[a].checked_sub(n)) || stands(Some(index[a] + n))
            })
        })
    }

    /// The peaks of a layer, which lies among these.
    fn peaks_of(&self, k: usize, layers: &[Layer]) -> Vec<Peak> {
        let [nx, ny, _] = self.grid.dims();
        let Some(own) = layers.iter().find(|layer| layer.k == k) else { return Vec::new() };
        let near = layers.iter().filter(|layer| layer.k.abs_diff(k) <= 1).collect::<Vec<_>>();
        let is_peak = |at: usize| {
            let (i, j, d) = (at % nx, at / nx, f64::from(own.least[at]));
            let higher = |layer: &Layer, x: usize, y: usize| {
                let other = f64::from(layer.least[y * nx + x]);
                let steps = [x.abs_diff(i), y.abs_diff(j), layer.k.abs_diff(k)].iter().filter(|&&s| s > 0).count();
                // Nothing of the surface lies between.
                let is_clear = d + other > (steps as f64).sqrt() * self.grid.h();
                let later = (layer.k, y, x) > (k, j, i);
                is_clear && (other > d || other == d && later)
            };
            let beside = |layer: &&Layer| {
                (j.saturating_sub(1)..(j + 2).min(ny))
                    .any(|y| (i.saturating_sub(1)..(i + 2).min(nx)).any(|x| higher(layer, x, y)))
            };
            !near.iter().any(beside)
        };
        let places = (0..nx * ny).into_par_iter().with_min_len(nx).filter(|&at| own.measured[at] && is_peak(at));
        places.map(|at| Peak { distance_mm: f64::from(own.least[at]), at: k * nx * ny + at }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::void::tests::{flask, part, turned};
    use super::*;
    use crate::geometry::cuboid;
    use crate::geometry::vector::distance;
    use crate::random::Lcg;

    #[test]
    fn a_room_has_a_peak_of_its_own_wherever_it_lies_and_what_is_open_has_none() {
        let mut rng = Lcg(98);
        for case in 0..40 {
            let mesh = turned(&flask(12.0, 3.03, 1.5), || rng.unit());
            let part = part(mesh, 0.34 + 0.09 * rng.unit(), [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let clearance = voids.clearance().unwrap();
            let peaks = voids.peaks(&clearance, &Stands::of(&clearance, 2.5), (2.5, 2.5));
            let middle = part.extent().map(|x| 0.5 * x);
            // Balls of the room's width reach no farther than its corners from its middle.
            let within = |peak: &&Peak| distance(voids.place(peak.at), middle) < 1.5;
            let top = peaks.iter().find(within).expect("a peak in the room");
            let doubt = HALF_DIAGONAL * voids.spacing_mm();
            assert!((top.distance_mm - 1.515).abs() <= doubt, "{case}: {top:?}");
            assert!(peaks.is_sorted_by(|a, b| a.distance_mm >= b.distance_mm), "{case}");
        }
        let cube = part(cuboid([0.0; 3], [9.0; 3]), 0.4, [0.1, 0.2, 0.3]);
        let voids = Voids::of(&cube).unwrap();
        let clearance = voids.clearance().unwrap();
        assert_eq!(voids.peaks(&clearance, &Stands::of(&clearance, 2.5), (2.5, 2.5)), []);
    }
}
