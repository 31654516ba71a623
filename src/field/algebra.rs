//! The algebra of defining functions: sets as the places where a function is positive.
//!
//! Union is a sum and intersection a product; the complement is the pushed negation; the level sets lead back to sets.
//! Two functions are equal, as far as measures can tell, if their supports differ by no volume.

use super::{Field, Indicator};
use crate::error::{Error, Result};
use crate::units::Volume;
use rayon::prelude::*;

/// f + g: positive on the union of what two non-negative functions define.
///
/// # Errors
/// [`Error::Operand`] if the grids differ; so for every binary operation here.
///
/// ```
/// use amcheck::{field::{self, Field}, grid::Grid, units::Length};
/// let grid = Grid::new([0.0; 3], Length::mm(1.0), [2, 1, 1])?;
/// let f = Field::from_values(grid, vec![1.0, 0.0], 0.0)?;
/// let g = Field::from_values(grid, vec![0.5, 0.0], 0.0)?;
/// assert_eq!(field::sum(&f, &g)?.values(), [1.5, 0.0]);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn sum(f: &Field<f32>, g: &Field<f32>) -> Result<Field<f32>> {
    pointwise("sum", f, g, |a, b| a + b)
}

/// f · g: positive on the intersection of what two non-negative functions define.
///
/// # Errors
/// As [`sum`].
pub fn product(f: &Field<f32>, g: &Field<f32>) -> Result<Field<f32>> {
    pointwise("product", f, g, |a, b| a * b)
}

/// The pushed negation `1 − sign f`: 1 where f is not positive, 0 where it is; the indicator of the complement.
pub fn complement(f: &Field<f32>) -> Field<f32> {
    mapped(f, |v| if v > 0.0 { 0.0 } else { 1.0 })
}

/// The indicator of a set as a function: 1 inside, 0 outside.
pub fn indicator_function(set: &Indicator) -> Field<f32> {
    let mut f = Field::constant(*set.grid(), 0.0);
    set.iter().for_each(|at| f.values_mut()[at] = 1.0);
    f
}

/// The superlevel set `U_t(f) = { f > t }`; at t = 0 it retrieves the set that a defining function stands for.
pub fn superlevel(f: &Field<f32>, t: f32) -> Indicator {
    Indicator::from_predicate(*f.grid(), |at| f.values()[at] > t)
}

/// ⟨f, g⟩ = ∫ f·g dV in mm³ times the units of both.
///
/// Planes are summed in order, so that the result does not depend on the number of threads.
///
/// # Errors
/// As [`sum`].
pub fn inner_product(f: &Field<f32>, g: &Field<f32>) -> Result<f64> {
    same_grid("inner product", f, g)?;
    let [nx, ny, _] = f.grid().dims();
    let planes: Vec<f64> = f
        .values()
        .par_chunks(nx * ny)
        .zip(g.values().par_chunks(nx * ny))
        .map(|(a, b)| a.iter().zip(b).map(|(&a, &b)| f64::from(a) * f64::from(b)).sum())
        .collect();
    Ok(planes.iter().sum::<f64>() * f.grid().sample_volume().as_mm3())
}

/// ‖f‖_p = (∫ |f|^p dV)^(1/p) for p ≥ 1; the greatest |f| for p = ∞.
///
/// # Errors
/// [`Error::Operand`] for p below 1.
pub fn lp_norm(f: &Field<f32>, p: f64) -> Result<f64> {
    if p.is_nan() || p < 1.0 {
        return Err(Error::Operand {
            operation: "norm",
            problem: format!("p = {p}"),
            remedy: "choose p of at least 1, or infinity".into(),
        });
    }
    let magnitudes = |plane: &[f32]| plane.iter().map(|&v| f64::from(v).abs()).collect::<Vec<_>>();
    let [nx, ny, _] = f.grid().dims();
    let planes = f.values().par_chunks(nx * ny);
    if p.is_infinite() {
        return Ok(planes.map(|plane| magnitudes(plane).into_iter().fold(0.0, f64::max)).reduce(|| 0.0, f64::max));
    }
    let sums: Vec<f64> = planes.map(|plane| magnitudes(plane).iter().map(|v| v.powf(p)).sum()).collect();
    Ok((sums.iter().sum::<f64>() * f.grid().sample_volume().as_mm3()).powf(1.0 / p))
}

/// vol(A ∩ B) = ⟨1_A, 1_B⟩, exact in samples: the collision measure. Touching shapes overlap by nothing.
///
/// # Errors
/// [`Error::Operand`] if the grids differ.
pub fn overlap_volume(a: &Indicator, b: &Indicator) -> Result<Volume> {
    Ok(a.intersection(b)?.volume())
}

/// Whether two sets differ by no more than a volume: equality almost everywhere, with its tolerance said.
///
/// # Errors
/// [`Error::Operand`] if the grids differ.
pub fn equal_up_to(a: &Indicator, b: &Indicator, volume: Volume) -> Result<bool> {
    let differing = a.difference(b)?.volume() + b.difference(a)?.volume();
    Ok(differing <= volume)
}

/// How two functions, positive inside and negative outside, are joined into one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Blend {
    /// max(f, g) and min(f, g): exact sets, creases where f = g.
    Extremes,
    /// Rvachev's R-functions `f + g ± √(f² + g²)`: exact sets, smooth but where f = g = 0.
    RFunction,
    /// Extremes rounded over a band `|f − g| < width`: the union grows by at most width/4 there, the intersection
    /// shrinks by as much.
    Smooth {
        /// Width of the band, in the unit of the functions.
        width: f32,
    },
}

impl Blend {
    /// A function positive on the union.
    ///
    /// # Errors
    /// As [`sum`].
    pub fn union(self, f: &Field<f32>, g: &Field<f32>) -> Result<Field<f32>> {
        pointwise("blend", f, g, |a, b| self.greater(a, b))
    }

    /// A function positive on the intersection.
    ///
    /// # Errors
    /// As [`sum`].
    pub fn intersection(self, f: &Field<f32>, g: &Field<f32>) -> Result<Field<f32>> {
        pointwise("blend", f, g, |a, b| -self.greater(-a, -b))
    }

    fn greater(self, a: f32, b: f32) -> f32 {
        match self {
            Blend::Extremes => a.max(b),
            Blend::RFunction => a + b + a.hypot(b),
            Blend::Smooth { width } if width > 0.0 => {
                let near = (width - (a - b).abs()).max(0.0);
                a.max(b) + near * near / (4.0 * width)
            }
            Blend::Smooth { .. } => a.max(b),
        }
    }
}

fn mapped(f: &Field<f32>, op: impl Fn(f32) -> f32 + Sync) -> Field<f32> {
    let mut out = Field::constant(*f.grid(), op(f.background()));
    out.values_mut().par_iter_mut().zip(f.values()).for_each(|(o, &v)| *o = op(v));
    out
}

fn pointwise(
    operation: &'static str,
    f: &Field<f32>,
    g: &Field<f32>,
    op: impl Fn(f32, f32) -> f32 + Sync,
) -> Result<Field<f32>> {
    same_grid(operation, f, g)?;
    let mut out = Field::constant(*f.grid(), op(f.background(), g.background()));
    out.values_mut().par_iter_mut().zip(f.values().par_iter().zip(g.values())).for_each(|(o, (&a, &b))| *o = op(a, b));
    Ok(out)
}

fn same_grid(operation: &'static str, f: &Field<f32>, g: &Field<f32>) -> Result<()> {
    if f.grid() == g.grid() {
        return Ok(());
    }
    Err(Error::Operand {
        operation,
        problem: format!("grids differ: {:?} and {:?}", f.grid(), g.grid()),
        remedy: "sample both functions on one grid".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::units::Length;

    fn line(values: &[f32]) -> Field<f32> {
        let grid = Grid::new([0.0; 3], Length::mm(0.5), [values.len(), 1, 1]).unwrap();
        Field::from_values(grid, values.to_vec(), 0.0).unwrap()
    }

    #[test]
    fn norms_and_products_are_hand_computable() {
        let (f, g) = (line(&[3.0, -4.0]), line(&[1.0, 2.0]));
        let h3 = 0.125;
        assert_eq!(inner_product(&f, &g).unwrap(), -5.0 * h3);
        assert_eq!(lp_norm(&f, 1.0).unwrap(), 7.0 * h3);
        assert!((lp_norm(&f, 2.0).unwrap() - (25.0 * h3).sqrt()).abs() < 1e-15);
        assert_eq!(lp_norm(&f, f64::INFINITY).unwrap(), 4.0);
        assert!(lp_norm(&f, 0.5).is_err() && inner_product(&f, &line(&[1.0])).is_err());
    }

    #[test]
    fn blends_keep_the_sets_and_the_smooth_one_stays_within_its_band() {
        let samples: Vec<(f32, f32)> =
            (-8..=8).flat_map(|a| (-8..=8).map(move |b| (a as f32 * 0.25, b as f32 * 0.25))).collect();
        let f = line(&samples.iter().map(|s| s.0).collect::<Vec<_>>());
        let g = line(&samples.iter().map(|s| s.1).collect::<Vec<_>>());
        let (max, min) = (Blend::Extremes.union(&f, &g).unwrap(), Blend::Extremes.intersection(&f, &g).unwrap());
        let r = Blend::RFunction;
        assert_eq!(superlevel(&r.union(&f, &g).unwrap(), 1e-6), superlevel(&max, 0.0));
        assert_eq!(superlevel(&r.intersection(&f, &g).unwrap(), 1e-6), superlevel(&min, 0.0));
        let smooth = Blend::Smooth { width: 1.0 };
        for (s, m) in smooth.union(&f, &g).unwrap().values().iter().zip(max.values()) {
            assert!((0.0..=0.25).contains(&(s - m)));
        }
    }
}
