//! What a dilation costs along each path: the choice between them.

use super::element::{Shape, StructuringElement};
use super::minkowski::Path;
use crate::convolution::{Precision, boundary_nodes, run_count, sum_grid};
use crate::error::Result;
use crate::field::Indicator;

/// A row of A for each run of the element, and each word of it when widened, ns; as all rates measured on two cores.
const OF_ROW: f64 = 1.6;
const OF_WORD: f64 = 0.25;
/// A sample of the sum by tiles of four elements a side: each about (4/3)³ of its samples, transformed twice; half of them hold no
/// boundary.
const OF_TILED_SAMPLE: f64 = 30.0;
/// A sample of the sum by distances.
const OF_DISTANCE: f64 = 8.0;
/// A sample of A made ready for a descent, and one of its result.
const OF_READY_SAMPLE: f64 = 0.2;
/// A pair of nodes in a descent, and a move of such a node over another; scattered sets take up to twice that.
const OF_PAIR: f64 = 15.0;
const OF_MOVE: f64 = 1.0;

/// Nanoseconds by path, as far as they can be foreseen: infinite for paths that are closed to an element.
pub(super) struct Costs {
    maxima: f64,
    rows: f64,
    distance: f64,
    tiles: f64,
    descent: f64,
}

impl Costs {
    /// Of the sum of a set and an element.
    ///
    /// Where two bodies touch, the nodes of 4³ samples of both boundaries that lie near each other grow like the root of the
    /// smaller boundary; over all translations of the sum's boundary a descent looks at about 5·(nA + nB)·√min(nA, nB) pairs of
    /// them, within a factor of four for bodies, shells and lattices.
    pub fn of(a: &Indicator, b: &StructuringElement) -> Result<Self> {
        let sum = sum_grid(a.grid(), b.set().grid())?;
        let only = |open: bool, cost: f64| if open { cost } else { f64::INFINITY };
        let maxima = only(b.shape() == Shape::Box, 0.0);
        let ball = matches!(b.shape(), Shape::Ball { .. });
        let [_, ny, nz] = a.grid().dims();
        let row = OF_ROW + OF_WORD * sum.dims()[0].div_ceil(64) as f64;
        let mut costs = Costs {
            maxima,
            rows: run_count(b.set()) as f64 * (ny * nz) as f64 * row,
            distance: only(ball, sum.samples() as f64 * OF_DISTANCE),
            tiles: sum.samples() as f64 * OF_TILED_SAMPLE + 2e5,
            descent: (a.grid().samples() + sum.samples()) as f64 * OF_READY_SAMPLE,
        };
        // Boundaries are counted only where that can matter.
        if costs.cheapest() == Path::Descent {
            let [of_a, of_b] = [a, b.set()].map(|set| boundary_nodes(set) as f64);
            costs.descent += 5.0 * (of_a + of_b) * of_a.min(of_b).sqrt() * OF_PAIR;
        }
        Ok(costs)
    }

    fn least(&self, paths: &[(f64, Path)]) -> (f64, Path) {
        let mut best = (self.rows, Path::BitRows);
        for &path in paths.iter().filter(|path| path.0 < f64::INFINITY) {
            best = if path.0 < best.0 { path } else { best };
        }
        best
    }

    fn without_descent(&self) -> (f64, Path) {
        self.least(&[
            (self.maxima, Path::RunningMaxima),
            (self.distance, Path::DistanceTransform),
            (self.tiles, Path::Transform(Precision::Double)),
        ])
    }

    pub fn cheapest(&self) -> Path {
        let other = self.without_descent();
        if self.descent < other.0 { Path::Descent } else { other.1 }
    }

    /// The path to take where a descent has been given up.
    pub fn next_best(&self) -> Path {
        self.without_descent().1
    }

    /// The moves that a descent may take: as many as take half to all of what the next best path costs.
    pub fn allowance(&self) -> u64 {
        (0.5 * self.without_descent().0 / OF_MOVE) as u64
    }
}
