//! The laws of chapter 2 of the thesis that the library rests on, and those of morphology, on random lopsided data.
//!
//! Numbers are those of the thesis (definitions, propositions, lemmas, theorems and equations of §2.2 and §2.3). Exact
//! statements are tested exactly; statements about integrals within the rounding said beside them.

mod morphology;
#[path = "../random/mod.rs"]
mod random;
mod section_2_2;
mod section_2_3;

use amcheck::convolution::{
    Convolver, RowContent, Spectrum, Transform, convolve_directly, convolve_fields, correlate_fields,
};
use amcheck::field::*;
use amcheck::geometry::vector::{Vec3, norm, sub};
use amcheck::geometry::{TriangleMesh, cuboid, occupancy};
use amcheck::grid::Grid;
use amcheck::morphology::*;
use amcheck::units::{Length, Volume};
use random::Random;

const H: f64 = 0.5;

impl Random {
    fn set_on(&mut self, grid: Grid, thin: usize) -> Indicator {
        let bits: Vec<bool> = (0..grid.samples()).map(|_| self.below(thin) == 0).collect();
        Indicator::from_predicate(grid, |at| bits[at])
    }

    fn function_on(&mut self, grid: Grid) -> Field<f32> {
        let values = (0..grid.samples()).map(|_| self.below(4096) as f32 / 4096.0).collect();
        Field::from_values(grid, values, 0.0).unwrap()
    }

    fn element(&mut self) -> StructuringElement {
        loop {
            let dims = [0, 1, 2].map(|_| 2 + self.below(3));
            let origin = [0, 1, 2].map(|_| H * self.below(4) as f64 - 1.0);
            let set = self.set_on(Grid::new(origin, Length::mm(H), dims).unwrap(), 2);
            if let Ok(element) = StructuringElement::new(set)
                && !element.is_symmetric()
            {
                return element;
            }
        }
    }
}

fn grid(dims: [usize; 3]) -> Grid {
    Grid::new([-1.0, 0.5, 2.0], Length::mm(H), dims).unwrap()
}

fn spectrum(f: &Field<f32>) -> (Transform<f64>, Spectrum<f64>) {
    let dims = f.grid().dims();
    let plan = Transform::<f64>::new(dims);
    let spectrum = plan.forward(|j, k, row| {
        let from = &f.values()[(k * dims[1] + j) * dims[0]..][..dims[0]];
        row.iter_mut().zip(from).for_each(|(r, &v)| *r = f64::from(v));
        RowContent::Filled
    });
    (plan, spectrum.unwrap())
}

/// Every frequency of a half spectrum, in order.
fn frequencies(dims: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..dims[2]).flat_map(move |r| (0..dims[1]).flat_map(move |q| (0..dims[0] / 2 + 1).map(move |p| [p, q, r])))
}

/// f with its samples moved cyclically: `g(i) = f(from(i))`.
fn rearranged(f: &Field<f32>, from: impl Fn([usize; 3]) -> [usize; 3]) -> Field<f32> {
    let g = f.grid();
    let values = (0..g.samples()).map(|at| f.values()[g.offset(from(g.index(at)))]).collect();
    Field::from_values(*g, values, 0.0).unwrap()
}

const CYCLIC: [usize; 3] = [6, 6, 6];
