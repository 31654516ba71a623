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
/// Powers are taken of |f| over its greatest value, so that none overflows and not all vanish, however large p is. Infinite where f
/// is anywhere, and NaN where it is NaN.
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
    // Unlike `f32::max` this keeps what is NaN.
    let greater = |a: f32, b: f32| if a.is_nan() || a > b { a } else { b };
    let greatest = f64::from(f.values().par_iter().map(|v| v.abs()).reduce(|| 0.0, greater));
    if p.is_infinite() || greatest == 0.0 || !greatest.is_finite() {
        return Ok(greatest);
    }
    let [nx, ny, _] = f.grid().dims();
    let powers = |plane: &[f32]| plane.iter().map(|&v| (f64::from(v).abs() / greatest).powf(p)).sum::<f64>();
    let sums: Vec<f64> = f.values().par_chunks(nx * ny).map(powers).collect();
    Ok(greatest * (sums.iter().sum::<f64>() * f.grid().sample_volume().as_mm3()).powf(1.0 / p))
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
            Blend::RFunction => r_union(f64::from(a), f64::from(b)) as f32,
            Blend::Smooth { width } if width > 0.0 => {
                let near = (width - (a - b).abs()).max(0.0);
                a.max(b) + near * near / (4.0 * width)
            }
            Blend::Smooth { .. } => a.max(b),
        }
    }
}

/// `a + b + √(a² + b²)`, whose sign is that of the greater: where the sum cancels the root, as the product over what does not cancel.
fn r_union(a: f64, b: f64) -> f64 {
    let (sum, root) = (a + b, (a * a + b * b).sqrt());
    if sum < 0.0 { 2.0 * a * b / (sum - root) } else { sum + root }
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
        assert_eq!(lp_norm(&line(&[0.0; 3]), 3.0).unwrap(), 0.0);
        // Neither 4⁴⁰⁰ nor 0.001⁴⁰⁰ is a double; the norm comes near the greatest value from p on both sides.
        for scale in [1.0f32, 1e-3] {
            let large = lp_norm(&line(&[3.0 * scale, -4.0 * scale]), 400.0).unwrap() / f64::from(scale);
            assert!((large / (4.0 * h3.powf(1.0 / 400.0)) - 1.0).abs() < 1e-6, "{large}");
        }
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
        let [union, intersection] = [smooth.union(&f, &g).unwrap(), smooth.intersection(&f, &g).unwrap()];
        for (at, &(a, b)) in samples.iter().enumerate() {
            // The parabola that meets max, and its slope, where |a − b| is the width: ½ + ½·d² + ¼ about d = 0, in quarters exact.
            let [over, under] = [union.values()[at] - max.values()[at], min.values()[at] - intersection.values()[at]];
            let rounded = match (a - b).abs() {
                0.0 => 0.25,
                0.25 => 0.140_625,
                0.5 => 0.0625,
                0.75 => 0.015_625,
                _ => 0.0,
            };
            assert_eq!([over, under], [rounded; 2], "{a} {b}");
        }
    }

    #[test]
    fn r_functions_have_the_sign_of_the_sets_however_far_apart_the_functions_are() {
        let sizes = [1e-44f32, 1e-20, 4.7e-8, 1e-3, 1.0, 12.32, 3e4, 1e18];
        let signed: Vec<f32> = sizes.iter().flat_map(|&x| [x, -x]).chain([0.0]).collect();
        let pairs: Vec<(f32, f32)> = signed.iter().flat_map(|&a| signed.iter().map(move |&b| (a, b))).collect();
        let f = line(&pairs.iter().map(|p| p.0).collect::<Vec<_>>());
        let g = line(&pairs.iter().map(|p| p.1).collect::<Vec<_>>());
        let both = [Blend::RFunction.union(&f, &g).unwrap(), Blend::RFunction.intersection(&f, &g).unwrap()];
        for (at, &(a, b)) in pairs.iter().enumerate() {
            let positive = both.each_ref().map(|made| made.values()[at] > 0.0);
            assert_eq!(positive, [a > 0.0 || b > 0.0, a > 0.0 && b > 0.0], "{a:e} {b:e}");
        }
        // 2ab/(a + b − √(a² + b²)), next to b here.
        let near = Blend::RFunction.union(&line(&[-12.32]), &line(&[4.7e-8])).unwrap().values()[0];
        assert!((near / 4.7e-8 - 1.0).abs() < 1e-6, "{near:e}");
    }

    #[test]
    fn a_norm_tells_what_is_no_number() {
        for p in [1.0, 2.0, f64::INFINITY] {
            assert!(lp_norm(&line(&[1.0, f32::NAN, 5.0]), p).unwrap().is_nan());
            assert!(lp_norm(&line(&[f32::INFINITY, f32::NAN]), p).unwrap().is_nan());
            assert_eq!(lp_norm(&line(&[1.0, f32::NEG_INFINITY]), p).unwrap(), f64::INFINITY);
        }
    }

    #[test]
    fn a_smooth_blend_has_no_crease_and_the_extremes_have() {
        // Along a = x, b = −x: the second difference of max is 2/ε at the crease, that of the blend never above its curvature 2/width.
        let eps = 1.0 / 64.0;
        let x: Vec<f32> = (-128..=128).map(|n| n as f32 * eps).collect();
        let (f, g) = (line(&x), line(&x.iter().map(|x| -x).collect::<Vec<_>>()));
        let bend = |blend: Blend| {
            let both = [blend.union(&f, &g).unwrap(), blend.intersection(&f, &g).unwrap()];
            both.map(|made| {
                let second = |w: &[f32]| ((w[2] - 2.0 * w[1] + w[0]) / (eps * eps)).abs();
                made.values().windows(3).map(second).fold(0.0, f32::max)
            })
        };
        assert_eq!(bend(Blend::Extremes), [2.0 / eps; 2]);
        // With b = −x the difference is 2x, whose square bends fourfold: 2/width, and not less where it is rounded at all.
        assert_eq!(bend(Blend::Smooth { width: 1.0 }), [2.0; 2]);
    }
}
