//! Liquid that stands together: the components of kept samples, each on a window of its own.

use super::finding::Bracket;
use super::void::Voids;
use crate::distance::squared_distance;
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::vector::Vec3;
use crate::grid::Grid;
use crate::topology::{Adjacency, Falls, components};
use rayon::prelude::*;

/// Basins of fewer samples are below what the grid tells.
const LEAST_SAMPLES: u64 = 27;

/// The layer in which a basin runs over.
#[derive(Debug, Clone, Copy)]
struct Last {
    /// Its index in the windows.
    layer: usize,
    /// The share of its height up to the rim.
    filled: f64,
    falls: Falls,
}

/// Liquid that stands together.
pub(super) struct Basin {
    /// Index of the windows' first sample in the grid of the part.
    first: [usize; 3],
    set: Indicator,
    /// The set with the samples at its walls that the part touches.
    walled: Indicator,
    /// Samples that keep liquid whatever the doubtful ones are.
    certain: Indicator,
    /// Void of the basin in each sample of `walled`, in its order, as far as the walls beside it go.
    void: Vec<f64>,
    /// How much of its last layer, where it runs over, lies within the rim.
    last: Last,
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
    pub fn all(voids: &Voids, likely: &Indicator, certain: &Indicator, falls: Falls) -> Result<(Vec<Basin>, u64)> {
        let parts = components(likely, Adjacency::Corner);
        let (sizes, boxes, firsts) = (parts.sizes(), parts.boxes(), parts.first_samples());
        let mut order: Vec<usize> =
            (0..parts.count()).filter(|&l| !voids.is_sealed(likely.grid().offset(firsts[l]))).collect();
        order.sort_by_key(|&l| (std::cmp::Reverse(sizes[l]), l));
        let (large, small): (Vec<usize>, Vec<usize>) = order.into_iter().partition(|&l| sizes[l] >= LEAST_SAMPLES);
        let windows = parts.split(&large, 1)?;
        let basins =
            windows.into_par_iter().zip(&large).map(|(window, &l)| Basin::of(voids, window, boxes[l], certain, falls));
        let basins: Result<Vec<Basin>> = basins.collect();
        Ok((basins?, small.iter().map(|&l| sizes[l]).sum()))
    }

    /// One of samples on a window, with the index of its first one and the box of the samples.
    fn of(
        voids: &Voids,
        (first, set): ([usize; 3], Indicator),
        extent: [[usize; 3]; 2],
        certain: &Indicator,
        falls: Falls,
    ) -> Result<Basin> {
        let at = first.map(|i| i as isize);
        let window = |of: &Indicator| of.placed(at, *set.grid());
        let certain = window(certain)?.intersection(&set)?;
        let ring = super::filling::ringed(&set, &window(&voids.solid.inner)?);
        let walled = set.union(&ring.intersection(&window(&voids.solid.outer)?)?)?;
        let near = Near { set: &set, density: voids.solid.density.field(), first, falls };
        let [lo, hi] = [0, 1].map(|end| extent[end][2] - first[2]);
        let layer = if falls == Falls::Down { hi } else { lo };
        let void: Vec<f64> = walled.iter().map(|at| near.share(set.grid().index(at), layer)).collect();
        let last = Last { layer, filled: near.filled(&walled, layer), falls };
        let filled = |at: usize| if set.grid().index(at)[2] == layer { last.filled } else { 1.0 };
        let sum: f64 = walled.iter().zip(&void).map(|(at, v)| v * filled(at)).sum();
        let volume = sum * set.grid().h().powi(3);
        Ok(Basin { first, set, walled, certain, void, last, volume, extent })
    }

    /// What stays of it of the samples that are kept once something is drilled: the basins that it falls into, those too small to tell left out.
    ///
    /// # Errors
    /// None for samples on the grid of the part.
    ///
    /// # Cost
    /// O(samples of the window).
    pub fn left(&self, voids: &Voids, kept: &Indicator) -> Result<Vec<Basin>> {
        let own = kept.placed(self.first.map(|i| i as isize), *self.set.grid())?.intersection(&self.set)?;
        let parts = components(&own, Adjacency::Corner);
        let (sizes, boxes) = (parts.sizes(), parts.boxes());
        let large: Vec<usize> = (0..parts.count()).filter(|&l| sizes[l] >= LEAST_SAMPLES).collect();
        let in_part = |index: [usize; 3]| [0, 1, 2].map(|a| self.first[a] + index[a]);
        let certain = Indicator::empty(*kept.grid());
        let basins = parts.split(&large, 1)?.into_iter().zip(&large).map(|((first, set), &l)| {
            Basin::of(voids, (in_part(first), set), boxes[l].map(in_part), &certain, self.last.falls)
        });
        basins.collect()
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

    /// The spacing of its samples.
    pub fn spacing_mm(&self) -> f64 {
        self.set.grid().h()
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

    /// Its sample so many layers above its floor, straight over a sample there, that is farthest from what bounds it in its layer.
    ///
    /// # Errors
    /// None for the basins there are.
    ///
    /// # Cost
    /// O(samples of a layer).
    pub fn over_floor(&self, layers: usize) -> Result<Vec3> {
        let [lo, hi] = self.extent.map(|index| self.within(index));
        let (grid, [nx, ny, _]) = (self.set.grid(), self.set.grid().dims());
        let layer = (lo[2] + layers).min(hi[2]);
        let plane = Grid::new(grid.origin(), grid.spacing(), [nx, ny, 1])?;
        let is_over = |k: usize, at: usize| self.set.contains([at % nx, at / nx, k]);
        let bounds = Indicator::from_predicate(plane, |at| !(is_over(layer, at) && is_over(lo[2], at)));
        let clearance = squared_distance(&bounds)?;
        // The first of the farthest, so that it does not depend on threads.
        let farthest = clearance.values().iter().enumerate().max_by_key(|(at, d)| (**d, std::cmp::Reverse(*at)));
        let at = farthest.map_or(0, |(at, _)| at);
        Ok(grid.position([at % nx, at / nx, layer]))
    }

    /// Where its rim is lowest, and it runs over, mm.
    pub fn rim_mm(&self) -> f64 {
        let h = self.set.grid().h();
        let middle = self.set.grid().position([0, 0, self.last.layer])[2];
        let beyond = h * (self.last.filled - 0.5);
        if self.last.falls == Falls::Down { middle + beyond } else { middle - beyond }
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

/// What the densities about a basin tell of the void that is its own.
struct Near<'a> {
    set: &'a Indicator,
    density: &'a Field<f32>,
    /// Index of the set's first sample on the grid of the densities.
    first: [usize; 3],
    falls: Falls,
}

impl Near<'_> {
    fn density(&self, index: [usize; 3]) -> f64 {
        let lifted = [0, 1, 2].map(|a| (self.first[a] + index[a]) as isize);
        f64::from(self.density.at(lifted))
    }

    /// The neighbours of a sample in the directions in which liquid falls and rises.
    fn below_and_above(&self, [i, j, k]: [usize; 3]) -> [Option<[usize; 3]>; 2] {
        let down = k.checked_sub(1).map(|k| [i, j, k]);
        let up = (k + 1 < self.set.grid().dims()[2]).then_some([i, j, k + 1]);
        if self.falls == Falls::Down { [down, up] } else { [up, down] }
    }

    /// Whether a sample is free and not of the basin.
    fn is_beyond(&self, index: Option<[usize; 3]>) -> bool {
        index.is_none_or(|p| !self.set.contains(p) && self.density(p) == 0.0)
    }

    /// The samples around one in its own layer.
    fn around([i, j, k]: [usize; 3]) -> impl Iterator<Item = Option<[usize; 3]>> {
        let beside = (0..9usize).filter(|n| *n != 4);
        beside.map(move |n| Some([(i + n % 3).checked_sub(1)?, (j + n / 3).checked_sub(1)?, k]))
    }

    fn is_in_set(&self, index: Option<[usize; 3]>) -> bool {
        let dims = self.set.grid().dims();
        index.is_some_and(|p| (0..3).all(|a| p[a] < dims[a]) && self.set.contains(p))
    }

    /// The share of a sample that is void of the basin, as wide as it is below the rim.
    ///
    /// In a wall that ends here the wall below tells how much is beside it; void on both sides of a wall counts half.
    fn share(&self, index: [usize; 3], last: usize) -> f64 {
        let void = 1.0 - self.density(index);
        if self.set.contains(index) {
            return void;
        }
        let beyond = if self.falls == Falls::Down { index[2] > last } else { index[2] < last };
        let [below, above] = self.below_and_above(index);
        if beyond {
            return 0.0;
        }
        if self.is_in_set(above) || !Self::around(index).any(|p| self.is_in_set(p)) {
            return void;
        }
        let under = if self.is_beyond(above) { below.map_or(0.0, |p| self.density(p)) } else { 0.0 };
        let void = void.min(1.0 - under);
        if Self::around(index).any(|p| p.is_some() && self.is_beyond(p)) { 0.5 * void } else { void }
    }

    /// The share of its last layer that is below the rim: where walls end in it, by how far they do.
    fn filled(&self, walled: &Indicator, last: usize) -> f64 {
        let grid = *walled.grid();
        let ends = walled.iter().map(|at| grid.index(at)).filter(|&index| {
            let [_, above] = self.below_and_above(index);
            index[2] == last && !self.set.contains(index) && self.is_beyond(above)
        });
        let (mut told, mut any) = (None, false);
        for index in ends.filter(|&index| Self::around(index).any(|p| self.is_in_set(p))) {
            let [below, _] = self.below_and_above(index);
            let under = below.map_or(0.0, |p| self.density(p));
            any = true;
            // A wall that fills little of a cube tells little of where it ends.
            if under > 0.5 {
                let share = (self.density(index) / under).clamp(0.0, 1.0);
                told = Some(told.map_or(share, |least: f64| least.min(share)));
            }
        }
        told.unwrap_or(if any { 0.5 } else { 1.0 })
    }
}

/// The greatest sum of a quantity over the samples of one layer; the quantities come in the order of the set's samples.
fn greatest_layer(set: &Indicator, quantities: impl Iterator<Item = f64>) -> f64 {
    let mut sums = vec![0.0; set.grid().dims()[2]];
    set.iter().zip(quantities).for_each(|(at, q)| sums[set.grid().index(at)[2]] += q);
    sums.into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::enclosed::tests::pocket;
    use super::super::void::tests::part;
    use super::*;
    use crate::random::Lcg;
    use crate::topology::{Passage, retained};

    #[test]
    fn the_value_of_a_pocket_is_its_volume_and_its_film_wherever_the_lattice_stands() {
        let mut rng = Lcg(61);
        for case in 0..40 {
            let (wide, deep, h) = (5.0 + 8.0 * rng.unit(), 3.0 + 10.0 * rng.unit(), 0.2 + 0.4 * rng.unit());
            let turn = rng.unit() - 0.5;
            let axes = [[turn.cos(), turn.sin(), 0.0], [-turn.sin(), turn.cos(), 0.0], [0.0, 0.0, 1.0]];
            let mesh = pocket(wide, deep).transformed(axes, [0.0; 3]);
            let part = part(mesh, h, [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let likely = retained(&voids.solid.outer.complement(), Falls::Up, Passage::Faces).unwrap();
            let certain = retained(&voids.solid.inner.complement(), Falls::Up, Passage::Corners).unwrap();
            let certain = certain.difference(&voids.solid.outer).unwrap();
            let (basins, _) = Basin::all(&voids, &likely, &certain, Falls::Up).unwrap();
            let [basin] = &basins[..] else { panic!("{case}: one basin") };
            for (found, truth) in [(basin.bracket(), wide * wide * deep), (basin.film(), wide * wide)] {
                assert!(found.low <= truth && truth <= found.high, "{case}: {found:?} {truth}");
                // An estimate: cubes that a turned wall crosses are told from those below; half a percent has been seen.
                assert!((found.value / truth - 1.0).abs() < 2e-2, "{case}: {found:?} {truth}");
            }
            assert!(basin.rim_mm().abs() < h, "{case}: {}", basin.rim_mm());
        }
    }
}
