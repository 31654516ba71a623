//! Liquid that stands together: the components of kept samples, each on a window of its own.

use super::finding::Bracket;
use super::void::Voids;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::Vec3;
use crate::topology::{Adjacency, components};
use rayon::prelude::*;

/// Basins of fewer samples are below what the grid tells.
const LEAST_SAMPLES: u64 = 27;

/// Liquid that stands together.
pub(super) struct Basin {
    /// Index of the windows' first sample in the grid of the part.
    first: [usize; 3],
    set: Indicator,
    /// The set with the samples at its walls that the part touches.
    walled: Indicator,
    /// Samples that keep liquid whatever the doubtful ones are.
    certain: Indicator,
    /// Void in each sample of `walled`, in its order.
    void: Vec<f64>,
    /// Its volume from the densities, mm³.
    pub volume: f64,
    /// Least and greatest indices of the set in the grid of the part.
    extent: [[usize; 3]; 2],
}

impl Basin {
    /// The basins that kept samples make, largest first, sealed voids left out; and how many samples are in ones too small to tell.
    ///
    /// # Errors
    /// None for sets on the grid of the part.
    ///
    /// # Cost
    /// O(samples/64 + samples of the windows).
    pub fn all(voids: &Voids, likely: &Indicator, certain: &Indicator) -> Result<(Vec<Basin>, u64)> {
        let parts = components(likely, Adjacency::Corner);
        let (sizes, boxes, firsts) = (parts.sizes(), parts.boxes(), parts.first_samples());
        let mut order: Vec<usize> =
            (0..parts.count()).filter(|&l| !voids.is_sealed(likely.grid().offset(firsts[l]))).collect();
        order.sort_by_key(|&l| (std::cmp::Reverse(sizes[l]), l));
        let (large, small): (Vec<usize>, Vec<usize>) = order.into_iter().partition(|&l| sizes[l] >= LEAST_SAMPLES);
        let windows = parts.split(&large, 1)?;
        let basins = windows.into_par_iter().zip(&large).map(|((first, set), &l)| {
            let at = first.map(|i| i as isize);
            let window = |of: &Indicator| of.placed(at, *set.grid());
            let certain = window(certain)?.intersection(&set)?;
            let ring = super::filling::ringed(&set, &window(&voids.solid.inner)?);
            let walled = set.union(&ring.intersection(&window(&voids.solid.outer)?)?)?;
            let density = voids.solid.density.field().values();
            let inside = |at: usize| {
                let index = set.grid().index(at);
                1.0 - f64::from(density[likely.grid().offset([0, 1, 2].map(|a| first[a] + index[a]))])
            };
            let void: Vec<f64> = walled.iter().map(inside).collect();
            let volume = void.iter().sum::<f64>() * likely.grid().h().powi(3);
            Ok(Basin { first, set, walled, certain, void, volume, extent: boxes[l] })
        });
        let basins: Result<Vec<Basin>> = basins.collect();
        Ok((basins?, small.iter().map(|&l| sizes[l]).sum()))
    }

    /// Its volume: what is kept for certain, and all that may be.
    pub fn bracket(&self) -> Bracket {
        let unit = self.set.grid().h().powi(3);
        Bracket::new(self.volume, self.certain.count() as f64 * unit, self.walled.count() as f64 * unit)
    }

    /// Greatest area of one of its layers, mm².
    pub fn film(&self) -> Bracket {
        let area = self.set.grid().h().powi(2);
        let most = |set: &Indicator| greatest_layer(set, std::iter::repeat(1.0)) * area;
        let value = greatest_layer(&self.walled, self.void.iter().copied()) * area;
        Bracket::new(value, most(&self.certain), most(&self.walled))
    }

    /// Its box.
    pub fn corners(&self) -> (Vec3, Vec3) {
        let half = 0.5 * self.set.grid().h();
        let [lo, hi] = self.extent.map(|index| self.set.grid().position(self.within(index)));
        (lo.map(|c| c - half), hi.map(|c| c + half))
    }

    /// Its sample in the lowest layer for the film, nearest to the middle of that layer.
    pub fn bottom(&self) -> Vec3 {
        let [lo, hi] = self.extent.map(|index| self.within(index));
        let mut best = (usize::MAX, lo);
        for (j, i) in (lo[1]..=hi[1]).flat_map(|j| (lo[0]..=hi[0]).map(move |i| (j, i))) {
            if self.set.contains([i, j, lo[2]]) {
                let far = (2 * i).abs_diff(lo[0] + hi[0]) + (2 * j).abs_diff(lo[1] + hi[1]);
                best = best.min((far, [i, j, lo[2]]));
            }
        }
        self.set.grid().position(best.1)
    }

    /// Puts its samples into a set on the grid of the part.
    pub fn join_into(&self, set: &mut Indicator) {
        for at in self.set.iter() {
            let index = self.set.grid().index(at);
            set.set([0, 1, 2].map(|a| self.first[a] + index[a]), true);
        }
    }

    fn within(&self, index: [usize; 3]) -> [usize; 3] {
        [0, 1, 2].map(|a| index[a] - self.first[a])
    }
}

/// The greatest sum of a quantity over the samples of one layer; the quantities come in the order of the set's samples.
pub(super) fn greatest_layer(set: &Indicator, quantities: impl Iterator<Item = f64>) -> f64 {
    let mut sums = vec![0.0; set.grid().dims()[2]];
    set.iter().zip(quantities).for_each(|(at, q)| sums[set.grid().index(at)[2]] += q);
    sums.into_iter().fold(0.0, f64::max)
}
