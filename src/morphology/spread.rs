//! How far a face spreads on a lattice: by the element that is laid over it, and beyond what half the element reaches.

use super::cells::Cells;
use super::overlap::Prism;
use crate::error::Result;
use crate::field::Indicator;
use crate::units::Length;

/// Most cells that a set grows by in one step: twice as many and one are as wide as a prism may be.
const MOST_AT_ONCE: usize = 30;

/// Whole cells by which upright faces spread, rounded down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Spread {
    /// By an element that less of lies in the part: at most half of it.
    pub by_element: usize,
    /// Beyond that, in every direction.
    pub beyond: usize,
}

impl Spread {
    /// The spread of a length on a lattice.
    pub fn of(length: Length, cells: &Cells) -> Self {
        let whole = cells.whole(length);
        let by_element = whole.min(cells.wide / 2);
        Spread { by_element, beyond: whole - by_element }
    }

    /// Layers of cells beyond the element along z.
    fn beyond_in_layers(self, cells: &Cells) -> usize {
        let [across, _, high] = cells.cell_mm();
        (self.beyond as f64 * across / high + 1e-6) as usize
    }

    /// Cells along any axis within which a cell of the coat, of a face or in a corner of three, has what stays open: half the element, or
    /// the diagonal of the spread where it goes beyond that.
    pub fn coat(self, cells: &Cells) -> usize {
        let half = cells.wide.max(cells.high).div_ceil(2);
        let whole = half + self.beyond.max(self.beyond_in_layers(cells));
        if self.beyond == 0 { half } else { (3f64.sqrt() * whole as f64).ceil() as usize }
    }

    /// A set of laid cells with all that lies within what spreads beyond the element: grown by a ball, and by `reach` cells along every
    /// axis.
    ///
    /// The ball is the union of upright discs of whole cells, the higher the narrower; larger ones are taken in steps, whose discs fall short of it by
    /// less than a cell each.
    ///
    /// # Errors
    /// None for sets that exist.
    ///
    /// # Cost
    /// O(words·cells across the ball) for each of its layers.
    pub fn grown(self, laid: Indicator, cells: &Cells, reach: usize) -> Result<Indicator> {
        let mut set = laid;
        let mut left = self.beyond;
        while left > 0 {
            let step = Spread { by_element: 0, beyond: left.min(MOST_AT_ONCE) };
            left -= step.beyond;
            set = step.by_ball(&set, cells, if left == 0 { reach } else { 0 })?;
        }
        Ok(set)
    }

    fn by_ball(self, set: &Indicator, cells: &Cells, reach: usize) -> Result<Indicator> {
        let [across, _, high] = cells.cell_mm();
        let radius = self.beyond as f64 + 1e-6;
        let mut grown = set.clone();
        for layer in 0..=self.beyond_in_layers(cells) {
            let squared = radius * radius - (layer as f64 * high / across).powi(2);
            let half = squared.max(0.0).sqrt();
            let whole = half as usize;
            let away = |i: usize| i as f64 - whole as f64;
            let within = |i: usize, j: usize| away(i).powi(2) + away(j).powi(2) <= half * half;
            let disc = Prism::new(2 * whole + 1, 2 * layer + 1, within)?;
            let first = [whole, whole, layer].map(|n| n as isize);
            grown = grown.union(&disc.deposited(&set.placed(first, *set.grid())?, reach))?;
        }
        Ok(grown)
    }
}

#[cfg(test)]
mod tests {
    use super::super::least_element::{Bead, Footprint};
    use super::*;
    use crate::geometry::vector::distance;

    #[test]
    fn a_cell_grows_to_the_cells_that_lie_within_a_ball_about_it() {
        let bead = Bead { footprint: Footprint::Square, width: Length::mm(0.1), height: Length::mm(0.08) };
        let half = [0.6; 3];
        let cells = Cells::covering(&bead, (half.map(|x| -x), half), 1 << 24).unwrap().unwrap();
        let middle = cells.grid.dims().map(|n| n / 2);
        let mut one = Indicator::empty(cells.grid);
        one.set(middle, true);
        for (beyond, tolerance) in [(1, 0.0), (5, 0.0), (9, 0.0), (40, 1.5)] {
            let grown = Spread { by_element: 3, beyond }.grown(one.clone(), &cells, 0).unwrap();
            let [across, ..] = cells.cell_mm();
            for at in (0..cells.grid.samples()).step_by(3) {
                let index = cells.grid.index(at);
                let away = distance(cells.position(index), cells.position(middle)) / across - beyond as f64;
                assert!(!grown.contains(index) || away < 1e-3, "{beyond} {index:?}: {away}");
                assert!(grown.contains(index) || away > -tolerance - 1e-9, "{beyond} {index:?}: {away}");
            }
        }
    }

    #[test]
    fn what_an_element_does_not_spread_by_is_left_beyond_it() {
        let bead = Bead { footprint: Footprint::Square, width: Length::mm(0.05), height: Length::mm(0.05) };
        let cells = Cells::divided_into(&bead, ([0.0; 3], [1.0; 3]), 1 << 24, (5, 3)).unwrap().unwrap();
        let of = |mm| Spread::of(Length::mm(mm), &cells);
        assert_eq!(of(0.02), Spread { by_element: 2, beyond: 0 });
        assert_eq!(of(0.1), Spread { by_element: 2, beyond: 8 });
        assert_eq!((of(0.02).coat(&cells), of(0.1).coat(&cells)), (3, 20));
    }
}
