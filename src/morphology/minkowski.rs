//! Dilation and erosion of sets of samples, by the cheapest exact path.

use super::cost::Costs;
use super::element::{Shape, StructuringElement};
use crate::convolution::{Descent, Precision, dilate_by_runs, dilate_tiled, sum_grid};
use crate::distance::squared_distance;
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::grid::Grid;
use rayon::prelude::*;
use std::fmt;

/// How a dilation was done. All paths give the same set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Path {
    /// Shifted bit rows, one for each run of the element.
    BitRows,
    /// Running maxima along each axis: boxes only.
    RunningMaxima,
    /// An exact distance transform, cut at the radius: balls only.
    DistanceTransform,
    /// Nodes of 64, 16 and 4 samples laid over each other, refined where they do not decide.
    Descent,
    /// Fourier transforms in tiles, with exact counts.
    Transform(Precision),
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Path::BitRows => write!(f, "bit rows"),
            Path::RunningMaxima => write!(f, "running maxima"),
            Path::DistanceTransform => write!(f, "distance transform"),
            Path::Descent => write!(f, "coarse to fine"),
            Path::Transform(Precision::Single) => write!(f, "transform (f32)"),
            Path::Transform(Precision::Double) => write!(f, "transform (f64)"),
            Path::Transform(Precision::Modular) => write!(f, "transform (integers)"),
        }
    }
}

/// A set, and the path it was come by.
#[derive(Debug, Clone, PartialEq)]
pub struct Morphed {
    /// The set.
    pub set: Indicator,
    /// How it was done.
    pub path: Path,
}

/// A ⊕ B = { a + b : a ∈ A, b ∈ B }.
///
/// Origins add, counts along each axis are nA + nB − 1: nothing is cut off.
///
/// # Errors
/// [`Error::Operand`] for different spacings.
///
/// # Cost
/// The least of: log₂(counts) walks over bit rows for a box; runs(B)·words(A) for shifted rows; a distance transform for a
/// ball; two transforms for each tile that the boundary of A passes; from coarse to fine, some hundred operations for each pair of 4³ nodes of
/// both boundaries that may meet, about 5·(nA + nB)·√min(nA, nB) of them. A descent that takes more than
/// the next best path is given up for it, so that no set costs much more than twice that.
///
/// # Source
/// J. Serra, Image Analysis and Mathematical Morphology, 1982.
///
/// ```
/// use amcheck::{field::Indicator, grid::Grid, morphology::{StructuringElement, dilate}, units::Length};
/// let h = Length::mm(1.0);
/// let dot = Indicator::from_predicate(Grid::new([5.0; 3], h, [1, 1, 1])?, |_| true);
/// let bar = StructuringElement::cuboid([3, 1, 1], h)?;
/// let sum = dilate(&dot, &bar)?.set;
/// assert_eq!((sum.count(), sum.grid().origin()), (3, [4.0, 5.0, 5.0]));
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn dilate(a: &Indicator, b: &StructuringElement) -> Result<Morphed> {
    let costs = Costs::of(a, b)?;
    match costs.cheapest() {
        Path::Descent => match dilate_by_descent(a, b.set(), costs.allowance())? {
            Some(set) => Ok(Morphed { set, path: Path::Descent }),
            None => dilate_along(costs.next_best(), a, b),
        },
        path => dilate_along(path, a, b),
    }
}

/// A ⊖ B = { x : x + B ⊆ A }, with everything outside A's grid outside A.
///
/// The grid is that of all translations that let B meet A: the origin is A's less B's last sample, counts along each
/// axis are nA + nB − 1.
///
/// # Errors
/// [`Error::Operand`] for different spacings.
///
/// # Cost
/// As [`dilate`]: A ⊖ B = ¬(¬A ⊕ B̌) where B fits into A's grid.
pub fn erode(a: &Indicator, b: &StructuringElement) -> Result<Morphed> {
    eroded(a, b, dilate)
}

/// As [`dilate`], along a given path; of transforms, in the arithmetic that its bound asks for, which the result names.
///
/// # Errors
/// As there, and [`Error::Operand`] for running maxima with an element that is not a box.
pub fn dilate_along(path: Path, a: &Indicator, b: &StructuringElement) -> Result<Morphed> {
    match path {
        Path::BitRows => Ok(Morphed { set: dilate_by_runs(a, b.set())?, path }),
        Path::RunningMaxima if b.shape() == Shape::Box => Ok(Morphed { set: dilate_by_box(a, b.set().grid())?, path }),
        Path::DistanceTransform if let Shape::Ball { radius2 } = b.shape() => {
            Ok(Morphed { set: dilate_by_ball(a, b, radius2)?, path })
        }
        Path::RunningMaxima | Path::DistanceTransform => Err(Error::Operand {
            operation: "dilation",
            problem: format!("{path} cannot use an element of the shape {:?}", b.shape()),
            remedy: "let the path be chosen".into(),
        }),
        Path::Descent => {
            let met = Descent::new(a).met_by(&b.set().reflected())?;
            Ok(Morphed { set: on_grid_of_sum(&met, a, b.set())?, path })
        }
        Path::Transform(_) => {
            let (set, precision) = dilate_tiled(a, b.set())?;
            Ok(Morphed { set, path: Path::Transform(precision) })
        }
    }
}

/// As [`erode`], along a given path.
///
/// # Errors
/// As [`dilate_along`].
pub fn erode_by_path(path: Path, a: &Indicator, b: &StructuringElement) -> Result<Morphed> {
    eroded(a, b, |a, element| {
        let boxed = path != Path::RunningMaxima || element.shape() == Shape::Box;
        dilate_along(if boxed { path } else { Path::BitRows }, a, element)
    })
}

/// Where an erosion can be: the full grid of translations, and the box in which the element fits into A's grid.
struct ErosionWindow {
    full: Grid,
    element: StructuringElement,
    /// First fitting translation in the full grid, and how many there are; `None` where the element fits nowhere.
    fit: Option<([usize; 3], [usize; 3])>,
}

fn erosion_window(a: &Indicator, b: &StructuringElement) -> Result<ErosionWindow> {
    let (size, reach) = (a.grid().dims(), b.set().grid().dims());
    let sum = sum_grid(a.grid(), b.set().grid())?;
    let axes = [0, 1, 2];
    let origin = axes.map(|i| a.grid().origin()[i] - b.set().grid().origin()[i] - a.grid().h() * (reach[i] - 1) as f64);
    let full = Grid::new(origin, sum.spacing(), sum.dims())?;
    let (first, support) = b.set().support_box().unwrap_or(([0; 3], [1; 3]));
    let fits = axes.iter().all(|&i| support[i] <= size[i]);
    // Translation i of the full grid lays sample `first` of the element on sample i − (nB − 1) + first of A.
    let fit = fits.then(|| (axes.map(|i| reach[i] - 1 - first[i]), axes.map(|i| size[i] - support[i] + 1)));
    Ok(ErosionWindow { full, element: b.cropped()?, fit })
}

/// The complement of what `dilated` makes of A's complement and the reflected element, where the element fits.
fn eroded(
    a: &Indicator,
    b: &StructuringElement,
    dilated: impl Fn(&Indicator, &StructuringElement) -> Result<Morphed>,
) -> Result<Morphed> {
    let window = erosion_window(a, b)?;
    let Some((first, dims)) = window.fit else {
        return Ok(Morphed { set: Indicator::empty(window.full), path: Path::BitRows });
    };
    let hit = dilated(&a.complement(), &window.element.reflected())?;
    let support = window.element.set().grid().dims();
    let fitting = hit.set.window(support.map(|n| n as isize - 1), dims)?.complement();
    let set = fitting.placed(first.map(|i| -(i as isize)), window.full)?;
    Ok(Morphed { set, path: hit.path })
}

/// A ⊕ B as the translations at which −B meets A, on the grid of the sum; nothing if more moves than allowed are needed.
fn dilate_by_descent(a: &Indicator, b: &Indicator, most: u64) -> Result<Option<Indicator>> {
    let met = Descent::new(a).met_by_at_most(&b.reflected(), most)?;
    met.map(|met| on_grid_of_sum(&met, a, b)).transpose()
}

/// The same samples on the grid of A ⊕ B: reflecting twice may change the last bit of the origin.
fn on_grid_of_sum(met: &Indicator, a: &Indicator, b: &Indicator) -> Result<Indicator> {
    met.placed([0; 3], sum_grid(a.grid(), b.grid())?)
}

/// Dilation by a digital ball: the samples whose squared distance to A is at most that of the ball.
fn dilate_by_ball(a: &Indicator, ball: &StructuringElement, radius2: u64) -> Result<Indicator> {
    let reach = ball.anchor().map(|n| -n);
    let wide = a.placed(reach, sum_grid(a.grid(), ball.set().grid())?)?;
    let d2 = squared_distance(&wide)?;
    Ok(Indicator::from_predicate(*wide.grid(), |at| u64::from(d2.values()[at]) <= radius2))
}

/// Dilation by a full box of samples: each axis by doubling, n samples in ⌈log₂ n⌉ steps.
fn dilate_by_box(a: &Indicator, element: &Grid) -> Result<Indicator> {
    let [mx, my, mz] = element.dims();
    let bar = Grid::new(element.origin(), element.spacing(), [mx, 1, 1])?;
    let widened = dilate_by_runs(a, &Indicator::from_predicate(bar, |_| true))?;
    let mut sum = widened.placed([0; 3], sum_grid(a.grid(), element)?)?;
    let words = sum.words_per_row();
    let plane = words * sum.grid().dims()[1];
    sum.words_mut().par_chunks_mut(plane).for_each(|rows| run_maxima(rows, words, my));
    run_maxima_of_planes(sum.words_mut(), plane, mz);
    Ok(sum)
}

/// Unites every row with the `count − 1` rows before it.
fn run_maxima(rows: &mut [u64], words: usize, count: usize) {
    let mut reached = 1;
    while reached < count {
        let step = reached.min(count - reached) * words;
        for at in (step..rows.len()).rev() {
            rows[at] |= rows[at - step];
        }
        reached += step / words;
    }
}

/// Unites every plane with the `count − 1` planes before it, planes one after the other, words in parallel.
fn run_maxima_of_planes(planes: &mut [u64], plane: usize, count: usize) {
    let mut reached = 1;
    while reached < count {
        let step = reached.min(count - reached);
        let total = planes.len() / plane;
        for k in (step..total).rev() {
            let (before, from_here) = planes.split_at_mut(k * plane);
            let lower = &before[(k - step) * plane..(k - step + 1) * plane];
            from_here[..plane].par_iter_mut().with_min_len(4096).zip(lower).for_each(|(o, &w)| *o |= w);
        }
        reached += step;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convolution::convolve_directly;
    use crate::units::Length;

    const H: f64 = 0.5;

    fn random_set(origin: [f64; 3], dims: [usize; 3], seed: u64, one_in: u64) -> Indicator {
        let grid = Grid::new(origin, Length::mm(H), dims).unwrap();
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

    fn elements() -> Vec<StructuringElement> {
        let lopsided = random_set([-1.0, 0.5, -0.25], [4, 3, 5], 77, 2);
        vec![
            StructuringElement::ball(Length::mm(1.1), Length::mm(H)).unwrap(),
            StructuringElement::cuboid([4, 1, 3], Length::mm(H)).unwrap(),
            StructuringElement::cuboid([1, 7, 2], Length::mm(H)).unwrap(),
            StructuringElement::new(lopsided).unwrap(),
            // Larger than some sets along every axis.
            StructuringElement::new(random_set([2.0, -3.0, 0.25], [14, 11, 9], 78, 7)).unwrap(),
        ]
    }

    fn paths(b: &StructuringElement) -> Vec<Path> {
        let mut paths = vec![Path::BitRows, Path::Descent, Path::Transform(Precision::Double)];
        if b.shape() == Shape::Box {
            paths.push(Path::RunningMaxima);
        }
        if matches!(b.shape(), Shape::Ball { .. }) {
            paths.push(Path::DistanceTransform);
        }
        paths
    }

    #[test]
    fn every_path_dilates_like_the_plain_sum() {
        for b in elements() {
            for (dims, one_in) in [([12, 9, 7], 5), ([70, 3, 4], 9), ([1, 1, 1], 1)] {
                let a = random_set([3.0, -2.0, 0.0], dims, 5, one_in);
                let counts = convolve_directly(&a, b.set()).unwrap();
                let want = Indicator::from_predicate(*counts.grid(), |at| counts.values()[at] > 0);
                for path in paths(&b) {
                    assert_eq!(dilate_along(path, &a, &b).unwrap().set, want, "{path}");
                }
                assert_eq!(dilate(&a, &b).unwrap().set, want);
            }
        }
    }

    #[test]
    fn every_path_dilates_nothing_to_nothing_and_the_whole_grid_up_to_its_borders() {
        for b in elements() {
            let nothing = Indicator::empty(*random_set([3.0, -2.0, 0.0], [12, 9, 7], 5, 5).grid());
            let whole = nothing.complement();
            for path in paths(&b) {
                assert!(dilate_along(path, &nothing, &b).unwrap().set.is_empty(), "{path}");
                let sum = dilate_along(path, &whole, &b).unwrap().set;
                let counts = convolve_directly(&whole, b.set()).unwrap();
                assert_eq!(sum, Indicator::from_predicate(*counts.grid(), |at| counts.values()[at] > 0), "{path}");
            }
        }
    }

    /// A ⊖ B straight from its definition.
    fn eroded_plainly(a: &Indicator, b: &StructuringElement, grid: &Grid) -> Indicator {
        Indicator::from_predicate(*grid, |at| {
            let x = grid.position(grid.index(at));
            b.set().iter().all(|s| {
                let v = b.set().grid().position(b.set().grid().index(s));
                a.grid().sample_at([0, 1, 2].map(|i| x[i] + v[i])).is_some_and(|i| a.contains(i))
            })
        })
    }

    #[test]
    fn every_path_erodes_like_the_definition_also_at_the_border() {
        for b in elements() {
            for dims in [[12, 9, 7], [70, 4, 5], [2, 2, 2]] {
                // Mostly full, so that the erosion is not empty, and full up to the border of the grid.
                let a = random_set([3.0, -2.0, 0.0], dims, 5, 40).complement();
                for path in paths(&b) {
                    let eroded = erode_by_path(path, &a, &b).unwrap();
                    assert_eq!(eroded.set, eroded_plainly(&a, &b, eroded.set.grid()), "{path} {dims:?}");
                }
                let chosen = erode(&a, &b).unwrap();
                assert_eq!(chosen.set, eroded_plainly(&a, &b, chosen.set.grid()));
            }
        }
    }

    #[test]
    fn an_element_that_fits_nowhere_erodes_to_nothing() {
        let a = random_set([0.0; 3], [3, 3, 3], 1, 1);
        let bar = StructuringElement::cuboid([4, 1, 1], Length::mm(H)).unwrap();
        assert!(erode(&a, &bar).unwrap().set.is_empty());
        let fitting = StructuringElement::cuboid([3, 3, 3], Length::mm(H)).unwrap();
        assert_eq!(erode(&a, &fitting).unwrap().set.count(), 1);
    }

    #[test]
    fn the_path_follows_the_element() {
        let a = random_set([0.0; 3], [200, 100, 100], 1, 2);
        let path = |b: &StructuringElement| Costs::of(&a, b).unwrap().cheapest();
        let h = Length::mm(H);
        assert_eq!(path(&StructuringElement::cuboid([9, 9, 9], h).unwrap()), Path::RunningMaxima);
        assert_eq!(path(&StructuringElement::ball(Length::mm(1.0), h).unwrap()), Path::BitRows);
        assert_eq!(path(&StructuringElement::ball(Length::mm(45.0), h).unwrap()), Path::DistanceTransform);
        // Boundary everywhere: pairs of nodes grow faster than samples.
        let holes = |n: usize| random_set([0.0; 3], [n; 3], 2, 2);
        let with_itself =
            |n: usize| Costs::of(&holes(n), &StructuringElement::new(holes(n)).unwrap()).unwrap().cheapest();
        assert_eq!(with_itself(30), Path::Descent);
        assert!(matches!(with_itself(110), Path::Transform(_)));
        // Bodies without known shape.
        let body = Indicator::from_predicate(*a.grid(), |at| (3..97).contains(&a.grid().index(at)[1]));
        let ball = StructuringElement::ball(Length::mm(10.0), h).unwrap().set().clone();
        let found = dilate(&body, &StructuringElement::new(ball.clone()).unwrap()).unwrap();
        assert_eq!(found.path, Path::Descent);
        assert_eq!(found.set, dilate_by_runs(&body, &ball).unwrap());
    }

    #[test]
    fn a_descent_that_gets_too_dear_is_given_up_for_the_next_best_path() {
        // Single samples: no node tells of more than itself.
        let dust = random_set([0.0; 3], [150, 150, 150], 1, 400);
        let shell = StructuringElement::ball(Length::mm(14.0), Length::mm(H)).unwrap().set().clone();
        let within = StructuringElement::ball(Length::mm(13.5), Length::mm(H)).unwrap();
        let within = within.set().placed([-1; 3], *shell.grid()).unwrap();
        let shell = StructuringElement::new(shell.difference(&within).unwrap()).unwrap();
        let costs = Costs::of(&dust, &shell).unwrap();
        assert_eq!(costs.cheapest(), Path::Descent);
        let found = dilate(&dust, &shell).unwrap();
        assert_ne!(found.path, Path::Descent);
        assert_eq!(found.set, dilate_along(Path::Descent, &dust, &shell).unwrap().set);
    }
}
