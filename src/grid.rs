//! The lattice of samples every field lives on.

use crate::error::{Error, Result};
use crate::units::{Length, Volume, exact, short};
use serde::{Deserialize, Serialize};

/// A cubic lattice of samples: sample `[i, j, k]` stands at `origin + h·[i, j, k]`.
///
/// `origin` is the world position, in millimetres, of the **centre** of sample `[0, 0, 0]`, so that the
/// origin of a convolution is the sum of the operands' origins. Storage is x fastest, then y, then z:
/// the arrays have shape `(nz, ny, nx)` and a layer is one contiguous plane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    origin: [f64; 3],
    spacing: Length,
    dims: [usize; 3],
}

impl Grid {
    /// A grid from the centre of its first sample, its spacing and its counts along x, y, z.
    ///
    /// # Errors
    /// [`Error::Operand`] if the spacing is not positive and finite, the origin not finite, a count zero,
    /// or the number of samples does not fit an address.
    pub fn new(origin: [f64; 3], spacing: Length, dims: [usize; 3]) -> Result<Self> {
        let h = spacing.as_mm();
        let problem = if !(h.is_finite() && h > 0.0) {
            Some(format!("spacing {h} mm is not positive"))
        } else if origin.iter().any(|x| !x.is_finite()) {
            Some(format!("origin {origin:?} is not finite"))
        } else if dims.contains(&0) {
            Some(format!("counts {dims:?} include zero"))
        } else if samples_of(dims) > isize::MAX as u128 {
            Some(format!("counts {dims:?} are more than can be addressed"))
        } else {
            None
        };
        match problem {
            Some(problem) => Err(Error::Operand {
                operation: "grid",
                problem,
                remedy: "choose a positive spacing and a box with extent".into(),
            }),
            None => Ok(Grid { origin, spacing, dims }),
        }
    }

    /// The grid whose samples are the centres of cubes that tile the box `[min, max]` and a margin around it.
    ///
    /// The box lies centred in the grid, so that a shifted or mirrored part sees the same samples; `phase`, in
    /// units of the spacing and below one half, is what tests vary.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn covering(
        min: [f64; 3],
        max: [f64; 3],
        spacing: Length,
        margin_samples: usize,
        phase: [f64; 3],
    ) -> Result<Self> {
        let h = spacing.as_mm();
        let mut origin = [0.0; 3];
        let mut dims = [0usize; 3];
        for a in 0..3 {
            let extent = max[a] - min[a];
            if !(extent >= 0.0 && extent.is_finite() && h > 0.0) {
                return Grid::new([f64::NAN; 3], spacing, [1; 3]);
            }
            let cells = (extent / h).ceil().max(1.0) + 1.0 + 2.0 * margin_samples as f64;
            if cells > 1e12 {
                return Grid::new(min, spacing, [usize::MAX; 3]);
            }
            dims[a] = cells as usize;
            let slack = cells * h - extent;
            origin[a] = min[a] - 0.5 * slack + (phase[a] + 0.5) * h;
        }
        Grid::new(origin, spacing, dims)
    }

    /// World position of the centre of sample `[0, 0, 0]`, millimetres.
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// Edge of a sample's cube.
    pub fn spacing(&self) -> Length {
        self.spacing
    }

    /// Edge of a sample's cube in millimetres.
    pub fn h(&self) -> f64 {
        self.spacing.as_mm()
    }

    /// Counts along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Shape of an array on this grid: `(nz, ny, nx)`.
    pub fn shape(&self) -> (usize, usize, usize) {
        (self.dims[2], self.dims[1], self.dims[0])
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.dims[0] * self.dims[1] * self.dims[2]
    }

    /// Volume of one sample's cube.
    pub fn sample_volume(&self) -> Volume {
        self.spacing * self.spacing * self.spacing
    }

    /// World position of the centre of a sample, millimetres.
    pub fn position(&self, index: [usize; 3]) -> [f64; 3] {
        let h = self.h();
        [0, 1, 2].map(|a| self.origin[a] + h * index[a] as f64)
    }

    /// Continuous index of a world position: whole numbers are sample centres.
    pub fn continuous_index(&self, position_mm: [f64; 3]) -> [f64; 3] {
        let h = self.h();
        [0, 1, 2].map(|a| (position_mm[a] - self.origin[a]) / h)
    }

    /// The sample whose cube holds a world position, if it is on the grid.
    #[inline]
    pub fn sample_at(&self, position_mm: [f64; 3]) -> Option<[usize; 3]> {
        self.sample_of(self.continuous_index(position_mm))
    }

    /// The sample whose cube holds a point given by its continuous index, if it is on the grid.
    #[inline]
    pub fn sample_of(&self, continuous: [f64; 3]) -> Option<[usize; 3]> {
        let mut index = [0; 3];
        for (a, &c) in continuous.iter().enumerate() {
            // What is not negative is rounded down by being made an integer, without a call of the system's library.
            let shifted = c + 0.5;
            if !(shifted >= 0.0 && shifted < self.dims[a] as f64) {
                return None;
            }
            index[a] = shifted as usize;
        }
        Some(index)
    }

    /// Position of a sample in storage: x fastest, then y, then z.
    pub fn offset(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.dims[1] + j) * self.dims[0] + i
    }

    /// The sample at a position in storage.
    pub fn index(&self, offset: usize) -> [usize; 3] {
        let [nx, ny, _] = self.dims;
        [offset % nx, offset / nx % ny, offset / (nx * ny)]
    }

    /// The same lattice with `before` more samples in front and `after` more behind along each axis.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn padded(&self, before: [usize; 3], after: [usize; 3]) -> Result<Self> {
        let h = self.h();
        Grid::new(
            [0, 1, 2].map(|a| self.origin[a] - h * before[a] as f64),
            self.spacing,
            [0, 1, 2].map(|a| self.dims[a].saturating_add(before[a]).saturating_add(after[a])),
        )
    }

    /// Refuses another grid for an operation on both if its spacing is another one.
    ///
    /// # Errors
    /// [`Error::Operand`] with both spacings.
    pub fn one_spacing_with(&self, operation: &'static str, other: &Grid) -> Result<()> {
        if self.h() == other.h() {
            return Ok(());
        }
        Err(Error::Operand {
            operation,
            problem: format!("spacings differ: {} and {}", exact(self.spacing), exact(other.spacing)),
            remedy: "sample both operands at one spacing".into(),
        })
    }

    /// The samples of the same lattice, continued beyond this grid where need be, whose cubes meet the box `[min, max]`.
    ///
    /// # Errors
    /// As [`Grid::new`]; a box without extent still has the samples at its place.
    pub fn window(&self, min: [f64; 3], max: [f64; 3]) -> Result<Self> {
        let [first, last] = [min, max].map(|p| self.continuous_index(p).map(|c| (c + 0.5).floor()));
        let mut dims = [0usize; 3];
        for a in 0..3 {
            let count = last[a] - first[a] + 1.0;
            if !(1.0..=1e12).contains(&count) {
                return Grid::new(min, self.spacing, [if count > 1e12 { usize::MAX } else { 0 }; 3]);
            }
            dims[a] = count as usize;
        }
        Grid::new([0, 1, 2].map(|a| self.origin[a] + self.h() * first[a]), self.spacing, dims)
    }
}

/// Bytes that casting takes for each sample: three bit sets, an f32 density and the voxelizer's scratch.
pub const BYTES_PER_SAMPLE: u128 = 12;

/// A spacing and what a grid of it takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitting {
    pub spacing: Length,
    /// Samples along the three sides, margin of one included.
    pub samples: u128,
    pub bytes: u128,
}

impl Fitting {
    /// What a grid of this spacing over a box takes, computed before anything is allocated.
    pub fn of(extent_mm: [f64; 3], spacing: Length) -> Self {
        let cells = extent_mm.map(|e| ((e / spacing.as_mm()).ceil().clamp(1.0, 1e15) as u128) + 3);
        let samples = cells.into_iter().fold(1u128, u128::saturating_mul);
        Fitting { spacing, samples, bytes: samples.saturating_mul(BYTES_PER_SAMPLE) }
    }

    /// The default spacing: the larger of a sixth of the smallest limit and 1/256 of the longest side, coarsened until the
    /// grid takes at most `budget_bytes`.
    ///
    /// # Errors
    /// [`Error::Operand`] for a box without extent and no limit: no spacing follows from them.
    pub fn default_for(extent_mm: [f64; 3], smallest_limit: Option<Length>, budget_bytes: u128) -> Result<Self> {
        let longest = extent_mm.into_iter().fold(0.0, f64::max);
        let wanted = smallest_limit.map_or(0.0, |l| l.as_mm() / 6.0).max(longest / 256.0);
        Self::coarsened(extent_mm, Length::mm(wanted), budget_bytes)
    }

    /// What a grid takes at `bytes_per_sample`, if that is allowed.
    ///
    /// # Errors
    /// [`Error::TooLarge`] with the spacing that fits; [`Error::Operand`] for a spacing that is not positive and finite.
    pub fn within(extent_mm: [f64; 3], spacing: Length, bytes_per_sample: u128, allowed_bytes: u128) -> Result<Self> {
        positive(spacing)?;
        let fitting = Fitting::of(extent_mm, spacing);
        let bytes = fitting.samples.saturating_mul(bytes_per_sample);
        if bytes <= allowed_bytes {
            return Ok(Fitting { bytes, ..fitting });
        }
        let budget = (allowed_bytes / bytes_per_sample).saturating_mul(BYTES_PER_SAMPLE);
        let fits = Fitting::coarsened(extent_mm, spacing, budget.max(1))?.spacing.as_mm();
        Err(Error::TooLarge {
            what: format!("a grid of {} samples at {}", fitting.samples, fine(spacing)),
            need_bytes: bytes,
            allowed_bytes,
            remedy: format!("--voxel {}mm fits, or allow more with --memory", short((fits * 1e3).ceil() / 1e3)),
        })
    }

    /// The same box at the least spacing, not below this one by more than rounding, that has at most so many samples.
    ///
    /// # Errors
    /// As [`Fitting::coarsened`].
    pub fn with_samples(extent_mm: [f64; 3], spacing: Length, samples: u128) -> Result<Self> {
        Fitting::coarsened(extent_mm, spacing, samples.max(64).saturating_mul(BYTES_PER_SAMPLE))
    }

    /// The same box at the least spacing, not below this one by more than rounding, that fits the budget.
    ///
    /// # Errors
    /// [`Error::Operand`] for a spacing that is not positive and finite.
    pub fn coarsened(extent_mm: [f64; 3], spacing: Length, budget_bytes: u128) -> Result<Self> {
        positive(spacing)?;
        let mut fitting = Fitting::of(extent_mm, spacing);
        while fitting.bytes > budget_bytes && fitting.spacing.as_mm() < 1e12 {
            let factor = (fitting.bytes as f64 / budget_bytes as f64).cbrt().max(1.001);
            fitting = Fitting::of(extent_mm, fitting.spacing * factor);
        }
        Ok(fitting)
    }
}

/// Refuses what is no spacing, as [`Grid::new`] does.
///
/// # Errors
/// [`Error::Operand`] with the spacing.
pub fn positive(spacing: Length) -> Result<()> {
    Grid::new([0.0; 3], spacing, [1; 3]).map(|_| ())
}

/// A spacing for people, with all its digits where four decimals would say too little of it.
pub fn fine(spacing: Length) -> String {
    if spacing.as_mm() < 0.01 { exact(spacing) } else { spacing.to_string() }
}

/// Number of samples of a box of counts, without overflow.
pub fn samples_of(dims: [usize; 3]) -> u128 {
    dims.iter().map(|&n| n as u128).fold(1, u128::saturating_mul)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_and_indices_are_inverse() {
        let g = Grid::new([1.0, 2.0, 3.0], Length::mm(0.5), [4, 5, 6]).unwrap();
        for offset in 0..g.samples() {
            let index = g.index(offset);
            assert_eq!(g.offset(index), offset);
            assert_eq!(g.sample_at(g.position(index)), Some(index));
        }
        assert_eq!(g.sample_at([0.7, 2.0, 3.0]), None);
        assert_eq!(g.shape(), (6, 5, 4));
    }

    #[test]
    fn covering_holds_the_box_with_its_margin() {
        let g = Grid::covering([0.0; 3], [10.0, 1.0, 0.05], Length::mm(0.3), 2, [0.0; 3]).unwrap();
        let [last_x, last_y, last_z] = g.dims().map(|n| n - 1);
        let (first, last) = (g.position([0, 0, 0]), g.position([last_x, last_y, last_z]));
        for (a, extent) in [10.0, 1.0, 0.05].into_iter().enumerate() {
            assert!(first[a] <= -0.3 * 1.5 && last[a] >= extent + 0.3 * 1.5, "axis {a}: {first:?} {last:?}");
        }
    }

    #[test]
    fn a_window_is_made_of_samples_of_the_whole() {
        let whole = Grid::covering([0.0; 3], [10.0, 5.0, 2.0], Length::mm(0.3), 1, [0.1, 0.2, 0.3]).unwrap();
        let window = whole.window([3.1, -4.0, 1.0], [4.2, 1.0, 1.0]).unwrap();
        for at in [0, window.samples() - 1] {
            let index = whole.continuous_index(window.position(window.index(at)));
            assert!(index.iter().all(|c| (c - c.round()).abs() < 1e-9), "{index:?}");
        }
        let (first, last) = (window.position([0; 3]), window.position(window.dims().map(|n| n - 1)));
        for (a, (lo, hi)) in [(3.1, 4.2), (-4.0, 1.0), (1.0, 1.0)].into_iter().enumerate() {
            assert!(first[a] - 0.15 <= lo && lo < first[a] + 0.15 && last[a] - 0.15 <= hi && hi < last[a] + 0.15);
        }
        assert!(whole.window([1.0; 3], [0.0; 3]).is_err() && whole.window([0.0; 3], [f64::NAN; 3]).is_err());
    }

    #[test]
    fn the_need_is_known_before_it_is_taken() {
        let huge = Fitting::of([150_000.0; 3], Length::mm(0.1));
        assert!(huge.samples > 3_000_000_000_000_000_000);
        let fits = Fitting::coarsened([150_000.0; 3], Length::mm(0.1), 1 << 30).unwrap();
        assert!(fits.bytes <= 1 << 30 && fits.bytes > 1 << 29, "{fits:?}");
        let usual = Fitting::default_for([50.0, 50.0, 5.0], Some(Length::mm(0.8)), 1 << 30).unwrap();
        assert_eq!(usual.spacing, Length::mm(50.0 / 256.0));
    }

    #[test]
    fn what_is_no_spacing_is_refused_before_it_is_coarsened() {
        for mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let refused = |found: Result<Fitting>| {
                let Err(Error::Operand { problem, .. }) = found else { panic!("{mm}: {found:?}") };
                assert!(problem.contains(&format!("{mm} mm")), "{problem}");
            };
            refused(Fitting::coarsened([10.0; 3], Length::mm(mm), 1 << 20));
            refused(Fitting::with_samples([10.0; 3], Length::mm(mm), 1000));
            refused(Fitting::within([10.0; 3], Length::mm(mm), 12, 1 << 20));
        }
        assert!(Fitting::default_for([0.0; 3], None, 1 << 30).is_err());
    }

    #[test]
    fn spacings_that_differ_are_told_apart() {
        let grid = |mm: f64| Grid::new([0.0; 3], Length::mm(mm), [1; 3]).unwrap();
        let refused = grid(0.3).one_spacing_with("test", &grid(0.1 + 0.2)).unwrap_err().to_string();
        assert!(refused.ends_with("0.3 mm and 0.30000000000000004 mm"), "{refused}");
        let refused = Fitting::within([10.0; 3], Length::mm(2e-5), 12, 1 << 20).unwrap_err().to_string();
        assert!(refused.contains("2e-5 mm"), "{refused}");
    }

    #[test]
    fn impossible_grids_are_refused() {
        assert!(Grid::new([0.0; 3], Length::mm(0.0), [1; 3]).is_err());
        assert!(Grid::new([f64::NAN; 3], Length::mm(1.0), [1; 3]).is_err());
        assert!(Grid::new([0.0; 3], Length::mm(1.0), [0, 1, 1]).is_err());
        assert!(Grid::covering([0.0; 3], [1e300; 3], Length::mm(1e-9), 1, [0.0; 3]).is_err());
    }
}
