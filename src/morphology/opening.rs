//! Opening and closing, the rolling-ball blends that they are, and regularization.

use super::element::StructuringElement;
use super::minkowski::{Morphed, dilate, erode};
use crate::error::Result;
use crate::field::Indicator;
use crate::units::Length;

/// A ∘ B = (A ⊖ B) ⊕ B: the union of all copies of B that fit into A, on A's grid.
///
/// With a ball it is the rolling-ball blend from inside: convex edges are rounded, thin material vanishes.
///
/// # Errors
/// As [`erode`].
///
/// # Cost
/// One erosion and one dilation.
///
/// # Source
/// G. Matheron, Random Sets and Integral Geometry, 1975.
pub fn opening(a: &Indicator, b: &StructuringElement) -> Result<Morphed> {
    let eroded = erode(a, b)?;
    let opened = dilate(&eroded.set, b)?;
    Ok(Morphed { set: on_grid_of(a, b, &opened.set)?, path: opened.path })
}

/// A • B = (A ⊕ B) ⊖ B: the complement of the union of all copies of B̌ that fit outside A, on A's grid.
///
/// With a ball it is the rolling-ball blend from outside: concave edges are filled, narrow gaps close. No sample
/// outside A's grid is ever added, since a closing stays within the box of its set.
///
/// # Errors
/// As [`erode`].
///
/// # Cost
/// One dilation and one erosion.
pub fn closing(a: &Indicator, b: &StructuringElement) -> Result<Morphed> {
    let dilated = dilate(a, b)?;
    let closed = erode(&dilated.set, b)?;
    Ok(Morphed { set: on_grid_of(a, b, &closed.set)?, path: closed.path })
}

/// A without what is thinner than two samples: its opening by the smallest box that has a volume.
///
/// It is the digital counterpart of open regularization: sheets and wires one sample thick vanish.
///
/// # Errors
/// As [`opening`].
pub fn regularize(a: &Indicator) -> Result<Indicator> {
    let cell = StructuringElement::cuboid([2; 3], Length::mm(a.grid().h()))?;
    Ok(opening(a, &cell)?.set)
}

/// A result of an erosion and a dilation by the same element, in either order, stands on A's lattice and starts
/// nB − 1 samples before it.
pub(super) fn on_grid_of(a: &Indicator, b: &StructuringElement, set: &Indicator) -> Result<Indicator> {
    set.placed(b.set().grid().dims().map(|n| n as isize - 1), *a.grid())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;

    fn comb() -> Indicator {
        // A block with a slot one sample wide and a fin one sample thick.
        let grid = Grid::new([1.0, 2.0, 3.0], Length::mm(0.5), [20, 12, 9]).unwrap();
        Indicator::from_predicate(grid, |at| {
            let [i, j, k] = grid.index(at);
            let block = (2..14).contains(&i) && (2..10).contains(&j) && (2..7).contains(&k) && i != 7;
            let fin = (14..18).contains(&i) && j == 5 && (2..7).contains(&k);
            block || fin
        })
    }

    #[test]
    fn opening_removes_the_fin_and_closing_fills_the_slot() {
        let (a, cell) = (comb(), StructuringElement::cuboid([3; 3], Length::mm(0.5)).unwrap());
        let (open, closed) = (opening(&a, &cell).unwrap().set, closing(&a, &cell).unwrap().set);
        assert_eq!(a.count() - open.count(), 4 * 5);
        assert!(open.is_subset(&a).unwrap() && a.is_subset(&closed).unwrap());
        assert!(closed.contains([7, 5, 4]) && !a.contains([7, 5, 4]));
        assert_eq!(regularize(&a).unwrap(), open);
    }

    #[test]
    fn both_are_idempotent_for_an_element_without_symmetry() {
        let grid = Grid::new([-0.5, 0.5, 0.0], Length::mm(0.5), [3, 2, 2]).unwrap();
        let corner = Indicator::from_predicate(grid, |at| at != 3 && at != 5 && at != 10);
        let b = StructuringElement::new(corner).unwrap();
        assert!(!b.is_symmetric());
        let a = comb();
        let (open, closed) = (opening(&a, &b).unwrap().set, closing(&a, &b).unwrap().set);
        assert_eq!(opening(&open, &b).unwrap().set, open);
        assert_eq!(closing(&closed, &b).unwrap().set, closed);
    }
}
