//! Convolution and correlation of a part with many elements, the part's spectrum kept.

use super::direct::sum_grid;
use super::ntt::cyclic_convolution;
use super::precision::{Precision, Workload};
use super::size::{good_even_size, good_size};
use super::spectrum::Spectrum;
use super::transform::{Real, RowContent, Transform, Window};
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use crate::grid::{Grid, samples_of};
use ndarray::Array3;
use std::sync::OnceLock;

/// Exact counts on a grid, and how they were come by.
#[derive(Debug, Clone, PartialEq)]
pub struct Counts {
    /// The number of coinciding samples for each translation.
    pub field: Field<u32>,
    /// The arithmetic they were done in.
    pub precision: Precision,
    /// The proven bound on the error before rounding; below one half.
    pub bound: f64,
}

impl Counts {
    /// The superlevel set `{ count ≥ least }`.
    pub fn at_least(&self, least: u32) -> Indicator {
        Indicator::from_predicate(*self.field.grid(), |at| self.field.values()[at] >= least)
    }
}

/// A part made ready to be convolved with, and correlated with, any number of elements.
///
/// The spectrum of the part is made once for each arithmetic that is asked for, and kept. The two operations are
/// different functions on purpose: dilation convolves, erosion and obstacles correlate.
pub struct Convolver {
    part: Indicator,
    samples: u64,
    reach: [usize; 3],
    padded: [usize; 3],
    single: OnceLock<Kept<f32>>,
    double: OnceLock<Kept<f64>>,
}

struct Kept<T: Real> {
    plan: Transform<T>,
    spectrum: Spectrum<T>,
}

/// The two ways to lay one set over another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Overlay {
    Convolve,
    Correlate,
}

impl Convolver {
    /// A convolver for elements of at most `reach` samples along each axis.
    ///
    /// # Errors
    /// [`Error::Operand`] if the padded grid cannot be addressed.
    ///
    /// # Cost
    /// Nothing yet; the first use makes the spectrum.
    pub fn new(part: &Indicator, reach: [usize; 3]) -> Result<Self> {
        let dims = part.grid().dims();
        let need = [0, 1, 2].map(|a| dims[a].saturating_add(reach[a]).saturating_sub(1).max(1));
        Grid::new([0.0; 3], part.grid().spacing(), need)?;
        let padded = [good_even_size(need[0]), good_size(need[1]), good_size(need[2])];
        let (samples, part) = (part.count(), part.clone());
        Ok(Convolver { part, samples, reach, padded, single: OnceLock::new(), double: OnceLock::new() })
    }

    /// The convolution `(1_A ∗ 1_B)(t) = #{ (a, b) : a + b = t }`: its support is A ⊕ B.
    ///
    /// Origins add, counts along each axis are nA + nB − 1.
    ///
    /// # Errors
    /// [`Error::Operand`] for different spacings or an element beyond the reach; [`Error::PrecisionLost`] if no
    /// arithmetic gives exact counts.
    ///
    /// # Cost
    /// Two transforms (three the first time) of the padded size.
    pub fn convolve(&self, element: &Indicator) -> Result<Counts> {
        self.overlay(element, Overlay::Convolve, None)
    }

    /// The correlation `(1_A ⋆ 1_B)(t) = #{ b : b + t ∈ A }`: the overlap of A with B moved by t. It is positive on
    /// the obstacle A ⊕ (−B), and equal to the count of B on the erosion A ⊖ B.
    ///
    /// The origin is that of A less the last sample of B; counts along each axis are nA + nB − 1.
    ///
    /// # Errors
    /// As [`Convolver::convolve`].
    pub fn correlate(&self, element: &Indicator) -> Result<Counts> {
        self.overlay(element, Overlay::Correlate, None)
    }

    /// As [`Convolver::convolve`] in a given arithmetic.
    ///
    /// # Errors
    /// As there, and [`Error::PrecisionLost`] if counts done in it could not be rounded.
    pub fn convolve_in(&self, precision: Precision, element: &Indicator) -> Result<Counts> {
        self.overlay(element, Overlay::Convolve, Some(precision))
    }

    /// As [`Convolver::correlate`] in a given arithmetic.
    ///
    /// # Errors
    /// As [`Convolver::convolve_in`].
    pub fn correlate_in(&self, precision: Precision, element: &Indicator) -> Result<Counts> {
        self.overlay(element, Overlay::Correlate, Some(precision))
    }

    fn overlay(&self, element: &Indicator, overlay: Overlay, demanded: Option<Precision>) -> Result<Counts> {
        let dims = element.grid().dims();
        if (0..3).any(|a| dims[a] > self.reach[a]) {
            return Err(Error::Operand {
                operation: "convolution",
                problem: format!("an element of {dims:?} samples, prepared for {:?}", self.reach),
                remedy: "prepare the part for the largest element, or crop the element to its box".into(),
            });
        }
        let work = Workload::of_counts(self.samples, element.count(), samples_of(self.padded));
        let precision = demanded.map_or_else(|| work.exact_precision(), Ok)?;
        let bound = work.demand(precision)?;
        let grid = match overlay {
            Overlay::Convolve => sum_grid(self.part.grid(), element.grid())?,
            Overlay::Correlate => difference_grid(self.part.grid(), element.grid())?,
        };
        let counts = match precision {
            Precision::Single => self.kept(&self.single)?.counts(element, overlay, grid.dims())?,
            Precision::Double => self.kept(&self.double)?.counts(element, overlay, grid.dims())?,
            Precision::Modular => modular_counts(&self.part, element, overlay, grid.dims()),
        };
        Ok(Counts { field: Field::from_values(grid, counts, 0)?, precision, bound })
    }

    fn kept<'a, T: Real>(&self, slot: &'a OnceLock<Kept<T>>) -> Result<&'a Kept<T>> {
        if slot.get().is_none() {
            let plan = Transform::new(self.padded);
            let spectrum = plan.forward(|j, k, row| bits(&self.part, j, k, row))?;
            // Another thread may have been faster; its spectrum is the same.
            let _ = slot.set(Kept { plan, spectrum });
        }
        slot.get().ok_or_else(|| Error::Internal { problem: "a spectrum was lost".into() })
    }
}

impl<T: Real> Kept<T> {
    fn counts(&self, element: &Indicator, overlay: Overlay, dims: [usize; 3]) -> Result<Vec<u32>> {
        let mut product = self.plan.forward(|j, k, row| bits(element, j, k, row))?;
        let start = match overlay {
            Overlay::Convolve => {
                product.multiply(&self.spectrum)?;
                [0; 3]
            }
            Overlay::Correlate => {
                product.multiply_conjugate(&self.spectrum)?;
                let (padded, size) = (self.plan.dims(), element.grid().dims());
                // Translation zero comes first; the negative ones, down to 1 − nB, stand at the end.
                [0, 1, 2].map(|a| (padded[a] + 1 - size[a]) % padded[a])
            }
        };
        let mut counts = vec![0u32; dims.iter().product()];
        self.plan.inverse(product, Window { start, dims }, &mut counts, dims[0], |row, out| {
            out.iter_mut().zip(row).for_each(|(o, &v)| {
                let v: f64 = v.into();
                *o = (v + 0.5).max(0.0) as u32;
            });
        })?;
        Ok(counts)
    }
}

/// The estimate of a convolution of real fields, with the bound on its rounding.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The values, zero outside.
    pub field: Field<f32>,
    /// A rigorous bound on the rounding of any value.
    pub bound: f64,
}

/// `(f ∗ g)(t) = Σ_x f(x)·g(t − x)`, in f32: an estimate, never the ground of a verdict. To approximate the
/// integral over space multiply by h³.
///
/// # Errors
/// [`Error::Operand`] for different spacings, a background that is not zero, or values that are not finite or so great that sums of
/// their products exceed f32.
///
/// # Cost
/// Three transforms of nA + nB − 1 samples a side; two spectra and the result.
pub fn convolve_fields(f: &Field<f32>, g: &Field<f32>) -> Result<Estimate> {
    overlay_fields(f, g, Overlay::Convolve)
}

/// `(f ⋆ g)(t) = Σ_x f(x)·g(x − t)`, in f32, as [`convolve_fields`].
///
/// # Errors
/// As there.
pub fn correlate_fields(f: &Field<f32>, g: &Field<f32>) -> Result<Estimate> {
    overlay_fields(f, g, Overlay::Correlate)
}

fn overlay_fields(f: &Field<f32>, g: &Field<f32>, overlay: Overlay) -> Result<Estimate> {
    if f.background() != 0.0 || g.background() != 0.0 {
        return Err(Error::Operand {
            operation: "convolution",
            problem: format!("backgrounds {} and {}", f.background(), g.background()),
            remedy: "convolve functions that vanish outside their grid; complement a co-finite one first".into(),
        });
    }
    let grid = match overlay {
        Overlay::Convolve => sum_grid(f.grid(), g.grid())?,
        Overlay::Correlate => difference_grid(f.grid(), g.grid())?,
    };
    let dims = grid.dims();
    let plan = Transform::<f32>::new([good_even_size(dims[0]), good_size(dims[1]), good_size(dims[2])]);
    let spectrum = plan.forward(|j, k, row| samples(f, j, k, row))?;
    let mut product = plan.forward(|j, k, row| samples(g, j, k, row))?;
    let start = match overlay {
        Overlay::Convolve => {
            product.multiply(&spectrum)?;
            [0; 3]
        }
        Overlay::Correlate => {
            product.multiply_conjugate(&spectrum)?;
            [0, 1, 2].map(|a| (plan.dims()[a] + 1 - g.grid().dims()[a]) % plan.dims()[a])
        }
    };
    drop(spectrum);
    let mut values = vec![0f32; grid.samples()];
    plan.inverse(product, Window { start, dims }, &mut values, dims[0], |row, out| out.copy_from_slice(row))?;
    if !values.iter().all(|v| v.is_finite()) {
        return Err(Error::Operand {
            operation: "convolution",
            problem: "values that are not finite, or whose products sum to more than 32-bit floats hold".into(),
            remedy: "scale the fields down, and the result up again".into(),
        });
    }
    let energy = |field: &Field<f32>| field.values().iter().map(|&v| f64::from(v).powi(2)).sum::<f64>();
    let mass = |field: &Field<f32>| field.values().iter().map(|&v| f64::from(v).abs()).sum::<f64>();
    let work = Workload {
        energy_a: energy(f),
        energy_b: energy(g),
        mass_a: mass(f),
        mass_b: mass(g),
        padded: samples_of(plan.dims()),
    };
    Ok(Estimate { field: Field::from_values(grid, values, 0.0)?, bound: work.rounding_bound::<f32>() })
}

/// The grid of translations `t = a − b`: the first is A's first sample less B's last.
pub(super) fn difference_grid(a: &Grid, b: &Grid) -> Result<Grid> {
    let sum = sum_grid(a, b)?;
    let first = [0, 1, 2].map(|i| a.origin()[i] - b.origin()[i] - a.h() * (b.dims()[i] - 1) as f64);
    Grid::new(first, sum.spacing(), sum.dims())
}

/// A row of an indicator as zeros and ones.
pub(super) fn bits<T: Real>(set: &Indicator, j: usize, k: usize, row: &mut [T]) -> RowContent {
    let [nx, ny, nz] = set.grid().dims();
    if j >= ny || k >= nz || set.row(j, k).iter().all(|&w| w == 0) {
        return RowContent::Zero;
    }
    row[nx..].fill(T::zero());
    for (chunk, &word) in row[..nx].chunks_mut(64).zip(set.row(j, k)) {
        chunk.iter_mut().enumerate().for_each(|(b, v)| *v = if word >> b & 1 == 1 { T::one() } else { T::zero() });
    }
    RowContent::Filled
}

fn samples(field: &Field<f32>, j: usize, k: usize, row: &mut [f32]) -> RowContent {
    let [nx, ny, nz] = field.grid().dims();
    if j >= ny || k >= nz {
        return RowContent::Zero;
    }
    row[nx..].fill(0.0);
    row[..nx].copy_from_slice(&field.values()[(k * ny + j) * nx..][..nx]);
    RowContent::Filled
}

fn modular_counts(part: &Indicator, element: &Indicator, overlay: Overlay, dims: [usize; 3]) -> Vec<u32> {
    let [px, py, pz] = dims.map(usize::next_power_of_two);
    let spread = |set: &Indicator, reflect: Overlay| {
        let size = set.grid().dims();
        let mut values = Array3::zeros((pz, py, px));
        for at in set.iter() {
            let index = set.grid().index(at);
            let [i, j, k] = [0, 1, 2].map(|a| match reflect {
                Overlay::Convolve => index[a],
                Overlay::Correlate => size[a] - 1 - index[a],
            });
            values[[k, j, i]] = 1;
        }
        values
    };
    let product = cyclic_convolution(spread(part, Overlay::Convolve), spread(element, overlay));
    product.slice(ndarray::s![..dims[2], ..dims[1], ..dims[0]]).iter().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::super::direct::convolve_directly;
    use super::*;
    use crate::units::Length;

    fn random_set(dims: [usize; 3], seed: u64, one_in: u64) -> Indicator {
        let grid = Grid::new([0.25, -1.0, 3.0], Length::mm(0.5), dims).unwrap();
        let mut state = seed;
        let mut set = Indicator::empty(grid);
        for at in 0..grid.samples() {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            if (state >> 33).is_multiple_of(one_in) {
                set.set(grid.index(at), true);
            }
        }
        set
    }

    const PAIRS: [([usize; 3], [usize; 3]); 5] = [
        ([1, 1, 1], [1, 1, 1]),
        ([7, 5, 6], [3, 4, 2]),
        ([16, 16, 16], [1, 1, 1]),
        ([9, 2, 11], [8, 7, 1]),
        ([33, 20, 9], [4, 5, 3]),
    ];

    #[test]
    fn every_arithmetic_gives_the_plain_sum_also_tight_against_the_border() {
        for (a, b) in PAIRS {
            for one_in in [1, 3] {
                let (a, b) = (random_set(a, 5, one_in), random_set(b, 23, one_in));
                let want = convolve_directly(&a, &b).unwrap();
                let convolver = Convolver::new(&a, b.grid().dims()).unwrap();
                for precision in [Precision::Single, Precision::Double, Precision::Modular] {
                    assert_eq!(convolver.convolve_in(precision, &b).unwrap().field, want, "{precision:?}");
                }
                assert_eq!(convolver.convolve(&b).unwrap().field, want);
            }
        }
    }

    #[test]
    fn correlation_counts_the_overlap_with_the_moved_element() {
        for (a, b) in PAIRS {
            let (a, b) = (random_set(a, 6, 2), random_set(b, 24, 2));
            let convolver = Convolver::new(&a, b.grid().dims()).unwrap();
            for precision in [Precision::Single, Precision::Double, Precision::Modular] {
                let counts = convolver.correlate_in(precision, &b).unwrap().field;
                for at in 0..counts.grid().samples() {
                    let t = counts.grid().position(counts.grid().index(at));
                    let overlap = b.iter().filter(|&s| {
                        let p = b.grid().position(b.grid().index(s));
                        a.grid().sample_at([0, 1, 2].map(|i| p[i] + t[i])).is_some_and(|i| a.contains(i))
                    });
                    assert_eq!(counts.values()[at] as usize, overlap.count(), "{precision:?} at {t:?}");
                }
            }
        }
    }

    #[test]
    fn elements_beyond_the_reach_and_of_another_spacing_are_refused() {
        let convolver = Convolver::new(&random_set([5; 3], 1, 2), [2; 3]).unwrap();
        assert!(convolver.convolve(&random_set([3, 1, 1], 1, 2)).is_err());
        let other = Indicator::empty(Grid::new([0.0; 3], Length::mm(0.4), [2; 3]).unwrap());
        assert!(convolver.correlate(&other).is_err());
    }

    #[test]
    fn single_precision_is_refused_where_its_bound_does_not_hold() {
        let solid = random_set([48; 3], 1, 1);
        let convolver = Convolver::new(&solid, [48; 3]).unwrap();
        assert!(matches!(convolver.convolve_in(Precision::Single, &solid), Err(Error::PrecisionLost { .. })));
        let counts = convolver.convolve(&solid).unwrap();
        assert_eq!(counts.precision, Precision::Double);
        assert_eq!(counts.field.values().iter().max(), Some(&(48 * 48 * 48)));
    }

    #[test]
    fn fields_are_convolved_and_correlated_within_the_bound() {
        let (a, b) = (random_set([9, 7, 5], 3, 2), random_set([4, 3, 6], 4, 2));
        let as_field = |set: &Indicator| {
            let values = (0..set.grid().samples()).map(|at| f32::from(u8::from(set.contains(set.grid().index(at)))));
            Field::from_values(*set.grid(), values.collect(), 0.0).unwrap()
        };
        let convolver = Convolver::new(&a, b.grid().dims()).unwrap();
        let pairs = [
            (convolve_fields(&as_field(&a), &as_field(&b)).unwrap(), convolver.convolve(&b).unwrap()),
            (correlate_fields(&as_field(&a), &as_field(&b)).unwrap(), convolver.correlate(&b).unwrap()),
        ];
        for (estimate, counts) in pairs {
            assert_eq!(estimate.field.grid(), counts.field.grid());
            for (&v, &n) in estimate.field.values().iter().zip(counts.field.values()) {
                assert!((f64::from(v) - f64::from(n)).abs() <= estimate.bound);
            }
        }
    }

    #[test]
    fn fields_whose_products_exceed_floats_are_refused() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [2, 2, 2]).unwrap();
        let field = |v: f32| Field::from_values(grid, vec![v; 8], 0.0).unwrap();
        for (a, b) in [(3e38, 3e38), (1e30, 1e20), (f32::NAN, 1.0), (f32::INFINITY, 1.0)] {
            let [both, turned] = [convolve_fields(&field(a), &field(b)), correlate_fields(&field(a), &field(b))];
            assert!([both, turned].iter().all(|e| matches!(e, Err(Error::Operand { .. }))), "{a} {b}");
        }
        // Eight products of 10³⁶ are held.
        assert!(convolve_fields(&field(1e18), &field(1e18)).is_ok());
    }
}
