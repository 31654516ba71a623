//! δ on points, curves and surfaces: what has no volume, made measurable.
//!
//! A singular function is kept as weighted points fine enough for the kernel that will spread it: the weight of a point is
//! its own, that of a piece of a curve its length times a weight per millimetre, that of a piece of a surface its area
//! times a weight per square millimetre. Spread by a nascent δ of finite width it becomes an ordinary field, whose integral
//! is still the measure.

use super::{Field, Indicator};
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::units::{Area, Length};
use rayon::prelude::*;
use std::f64::consts::PI;

/// A singular defining function as weighted points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Singular {
    points: Vec<([f64; 3], f64)>,
    /// The longest piece that a point stands for, mm; zero for points.
    step: f64,
}

/// More pieces than this are not kept.
const MOST_PIECES: f64 = 16_777_216.0;

impl Singular {
    /// Σ w_i·δ(x − p_i).
    ///
    /// # Errors
    /// [`Error::Operand`] for a place or weight that is not finite; so for the other constructors.
    pub fn on_points(points: &[([f64; 3], f64)]) -> Result<Self> {
        match points.iter().find(|(p, w)| !(w.is_finite() && p.iter().all(|x| x.is_finite()))) {
            None => Ok(Singular { points: points.to_vec(), step: 0.0 }),
            Some(bad) => Err(refused(format!("a point {bad:?} is not finite"))),
        }
    }

    /// w·δ on a polyline, w per millimetre, as midpoints of pieces no longer than `step`.
    ///
    /// # Errors
    /// As [`Singular::on_points`]; also for a path of fewer than two points, a step that is not positive, and one that makes more than
    /// 2²⁴ pieces.
    pub fn on_polyline(path: &[[f64; 3]], weight_per_mm: f64, step: Length) -> Result<Self> {
        positive_step(step)?;
        if path.len() < 2 {
            return Err(refused(format!("a polyline of {} point(s)", path.len())));
        }
        let pieces = |pair: &[[f64; 3]]| (norm(minus(pair[1], pair[0])) / step.as_mm()).ceil().max(1.0);
        few_enough(path.windows(2).map(pieces).sum(), step)?;
        let mut points = Vec::new();
        for pair in path.windows(2) {
            let (length, pieces) = (norm(minus(pair[1], pair[0])), pieces(pair) as usize);
            for n in 0..pieces {
                let t = (n as f64 + 0.5) / pieces as f64;
                let place = [0, 1, 2].map(|a| pair[0][a] + t * (pair[1][a] - pair[0][a]));
                points.push((place, weight_per_mm * length / pieces as f64));
            }
        }
        Ok(Singular { step: step.as_mm(), ..Singular::on_points(&points)? })
    }

    /// w·δ on triangles, w per square millimetre, as centroids of pieces no longer than `step`.
    ///
    /// # Errors
    /// As [`Singular::on_polyline`].
    pub fn on_surface(triangles: &[[[f64; 3]; 3]], weight_per_mm2: f64, step: Length) -> Result<Self> {
        positive_step(step)?;
        let along_edge = |&[a, b, c]: &[[f64; 3]; 3]| {
            let longest = norm(minus(b, a)).max(norm(minus(c, a))).max(norm(minus(c, b)));
            (longest / step.as_mm()).ceil().max(1.0)
        };
        few_enough(triangles.iter().map(|t| along_edge(t).powi(2)).sum(), step)?;
        let mut points = Vec::new();
        for triangle in triangles {
            let &[a, b, c] = triangle;
            let (u, v) = (minus(b, a), minus(c, a));
            let n = along_edge(triangle) as usize;
            let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let share = 0.5 * norm(cross) / (n * n) as f64;
            for i in 0..n {
                for j in 0..2 * (n - i) - 1 {
                    // Upright and inverted small triangles alternate; their centroids lie at thirds.
                    let third = if j % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
                    let (s, t) = ((i as f64 + third) / n as f64, ((j / 2) as f64 + third) / n as f64);
                    points.push(([0, 1, 2].map(|k| a[k] + s * u[k] + t * v[k]), weight_per_mm2 * share));
                }
            }
        }
        Ok(Singular { step: step.as_mm(), ..Singular::on_points(&points)? })
    }

    /// f + g.
    pub fn plus(mut self, other: Singular) -> Self {
        self.points.extend(other.points);
        Singular { points: self.points, step: self.step.max(other.step) }
    }

    /// The box of the places where the function stands; `None` without any.
    pub fn bounds(&self) -> Option<([f64; 3], [f64; 3])> {
        let first = self.points.first()?.0;
        Some(self.points.iter().fold((first, first), |(lo, hi), (p, _)| {
            ([0, 1, 2].map(|a| p[a].min(lo[a])), [0, 1, 2].map(|a| p[a].max(hi[a])))
        }))
    }

    /// ∫ f: the number, length or area that the function stands for, times its weight.
    pub fn measure(&self) -> f64 {
        self.points.iter().map(|(_, w)| w).sum()
    }

    /// The convolution with a nascent δ: an ordinary density on a grid, in weight per cubic millimetre.
    ///
    /// The points of pieces no longer than the width give what the curve or surface itself would, along it: a sum of Gaussians σ apart
    /// ripples by 2·exp(−2π²) < 1e-8. A sum of triangles does not ripple at all where the curve follows an axis and its pieces are
    /// whole fractions of σ. Elsewhere half its range over its mean is 0.1 where pieces of 0.7·σ follow an axis, 0.23 where pieces of σ
    /// follow a diagonal of the grid, and 0.03 where those of σ/3 do.
    ///
    /// # Errors
    /// [`Error::Operand`] if the width is not positive and finite, or below the spacing, as the kernel would fall between the samples, or below the step of the
    /// pieces, as it would tell them apart.
    ///
    /// # Cost
    /// (2·reach/h)³ additions a point; layers in parallel.
    pub fn dissipated(&self, grid: &Grid, kernel: Nascent) -> Result<Field<f32>> {
        let (h, reach) = (grid.h(), kernel.reach());
        positive_width(kernel.width())?;
        if kernel.width() < h {
            return Err(refused(format!("a kernel {} mm wide on a spacing of {h} mm", kernel.width())));
        }
        if kernel.width() < self.step {
            return Err(refused(format!("a kernel {} mm wide on pieces of {} mm", kernel.width(), self.step)));
        }
        let [nx, ny, _] = grid.dims();
        let mut layers = vec![0f64; grid.samples()];
        layers.par_chunks_mut(nx * ny).enumerate().for_each(|(k, layer)| {
            let z = grid.origin()[2] + h * k as f64;
            for (p, w) in &self.points {
                let along_z = kernel.at(z - p[2]);
                if (z - p[2]).abs() > reach || along_z == 0.0 {
                    continue;
                }
                let range = |axis: usize, n: usize| {
                    let c = (p[axis] - grid.origin()[axis]) / h;
                    let lo = (c - reach / h).ceil().max(0.0);
                    let hi = (c + reach / h).floor().min(n as f64 - 1.0);
                    if hi < lo { 0..0 } else { lo as usize..hi as usize + 1 }
                };
                for j in range(1, ny) {
                    let factor = w * along_z * kernel.at(grid.origin()[1] + h * j as f64 - p[1]);
                    for i in range(0, nx) {
                        layer[j * nx + i] += factor * kernel.at(grid.origin()[0] + h * i as f64 - p[0]);
                    }
                }
            }
        });
        Field::from_values(*grid, layers.into_iter().map(|v| v as f32).collect(), 0.0)
    }
}

/// A nascent δ: a kernel of unit integral that becomes δ as its width goes to zero; in space, a product over the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Nascent {
    /// `exp(−x²/2σ²)/(σ√2π)`: radial in space, and exact on a grid to 1e-8 from σ = h on.
    Gaussian {
        /// Standard deviation σ.
        width: Length,
    },
    /// `(1 − |x|/σ)/σ` on |x| ≤ σ: compact, and exact on a grid where σ is a multiple of the spacing.
    Triangle {
        /// Half the base σ.
        width: Length,
    },
}

impl Nascent {
    /// The width σ, millimetres.
    pub fn width(self) -> f64 {
        match self {
            Nascent::Gaussian { width } | Nascent::Triangle { width } => width.as_mm(),
        }
    }

    /// Beyond this distance along an axis the kernel is nothing: 6σ, or σ.
    pub fn reach(self) -> f64 {
        match self {
            Nascent::Gaussian { width } => 6.0 * width.as_mm(),
            Nascent::Triangle { width } => width.as_mm(),
        }
    }

    /// The kernel along one axis, per millimetre.
    pub fn at(self, x: f64) -> f64 {
        let s = self.width();
        match self {
            Nascent::Gaussian { .. } => (-0.5 * (x / s).powi(2)).exp() / (s * (2.0 * PI).sqrt()),
            Nascent::Triangle { .. } => (1.0 - x.abs() / s).max(0.0) / s,
        }
    }
}

/// ⟨δ_σ(· − p), 1_S⟩: the fraction of the neighbourhood of a place that a set fills; ½ on a face, ¼ on a square edge, ⅛
/// at a cube's corner.
///
/// # Errors
/// As [`Singular::dissipated`].
pub fn volume_fraction(set: &Indicator, place: [f64; 3], width: Length) -> Result<f64> {
    let spread = Singular::on_points(&[(place, 1.0)])?.dissipated(set.grid(), Nascent::Gaussian { width })?;
    super::inner_product(&spread, &super::indicator_function(set))
}

/// The area over which two surfaces lie on each other, from their densities dissipated by Gaussians of one width:
/// `2σ√π·⟨ρ_A, ρ_B⟩`, exact for plane contact that is wide against σ.
///
/// Surfaces a distance d apart count by `exp(−d²/4σ²)`.
///
/// # Errors
/// [`Error::Operand`] if the grids differ or the width is not positive and finite.
pub fn contact_area(a: &Field<f32>, b: &Field<f32>, width: Length) -> Result<Area> {
    positive_width(width.as_mm())?;
    Ok(Area::mm2(2.0 * width.as_mm() * PI.sqrt() * super::inner_product(a, b)?))
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn norm(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn positive_step(step: Length) -> Result<()> {
    let mm = step.as_mm();
    if mm.is_finite() && mm > 0.0 { Ok(()) } else { Err(refused(format!("a step of {mm} mm"))) }
}

fn positive_width(mm: f64) -> Result<()> {
    if mm.is_finite() && mm > 0.0 { Ok(()) } else { Err(refused(format!("a kernel {mm} mm wide"))) }
}

fn few_enough(pieces: f64, step: Length) -> Result<()> {
    if pieces <= MOST_PIECES { Ok(()) } else { Err(refused(format!("{pieces:.0} pieces of {step}"))) }
}

fn refused(problem: String) -> Error {
    Error::Operand {
        operation: "singular function",
        problem,
        remedy: "give finite places and weights, two points or more, at most 2²⁴ pieces, and a kernel no narrower than the pieces and \
                 the spacing"
            .into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: Length = Length::mm(0.25);

    fn square(side: f64, z: f64) -> [[[f64; 3]; 3]; 2] {
        let p = |x: f64, y: f64| [x * side, y * side, z];
        [[p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0)], [p(0.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)]]
    }

    #[test]
    fn integrals_are_counts_lengths_and_areas_before_and_after_dissipation() {
        let step = Length::mm(0.1);
        let path = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 4.0, 0.0]];
        let cases = [
            (Singular::on_points(&[([1.0; 3], 2.0), ([2.0, 1.0, 1.1], 0.5)]).unwrap(), 2.5),
            (Singular::on_polyline(&path, 2.0, step).unwrap(), 14.0),
            (Singular::on_surface(&square(3.0, 0.2), 1.0, step).unwrap(), 9.0),
        ];
        let grid = Grid::covering([0.0; 3], [4.0, 4.0, 1.0], H, 13, [0.1, 0.2, 0.3]).unwrap();
        for (f, measure) in cases {
            assert!((f.measure() - measure).abs() < 1e-9, "{}", f.measure());
            for kernel in [Nascent::Gaussian { width: Length::mm(0.5) }, Nascent::Triangle { width: Length::mm(0.5) }] {
                let field = f.dissipated(&grid, kernel).unwrap();
                let integral =
                    field.values().iter().map(|&v| f64::from(v)).sum::<f64>() * grid.sample_volume().as_mm3();
                // 6σ leaves 6e-9 outside; f32 rounds each sample by 6e-8.
                assert!((integral / measure - 1.0).abs() < 1e-6, "{kernel:?}: {integral} {measure}");
            }
        }
    }

    #[test]
    fn contact_area_is_the_area_of_touching_faces_and_fades_with_their_distance() {
        let width = Length::mm(0.3);
        let grid = Grid::covering([0.0; 3], [8.0, 8.0, 1.0], H, 8, [0.0; 3]).unwrap();
        let spread = |z: f64| {
            let f = Singular::on_surface(&square(8.0, z), 1.0, Length::mm(0.1)).unwrap();
            f.dissipated(&grid, Nascent::Gaussian { width }).unwrap()
        };
        let bottom = spread(0.5);
        let touching = contact_area(&bottom, &spread(0.5), width).unwrap().as_mm2();
        // The rim of 32 mm loses a strip of σ/√π on each side of it.
        assert!((touching - (8.0 - 2.0 * 0.3 / PI.sqrt()).powi(2)).abs() < 1.0, "{touching}");
        let apart = contact_area(&bottom, &spread(1.1), width).unwrap().as_mm2();
        assert!((apart / touching - (-0.36f64 / (4.0 * 0.09)).exp()).abs() < 1e-3, "{apart}");
    }

    #[test]
    fn kernels_narrower_than_the_grid_and_broken_places_are_refused() {
        let grid = Grid::new([0.0; 3], H, [4; 3]).unwrap();
        let point = Singular::on_points(&[([0.5; 3], 1.0)]).unwrap();
        assert!(point.dissipated(&grid, Nascent::Gaussian { width: Length::mm(0.1) }).is_err());
        assert!(Singular::on_points(&[([f64::NAN; 3], 1.0)]).is_err());
        assert_eq!((point.bounds(), Singular::default().bounds()), (Some(([0.5; 3], [0.5; 3])), None));
        assert!(Singular::on_polyline(&[[0.0; 3]], 1.0, H).is_err());
        assert!(Singular::on_polyline(&[[0.0; 3], [1e9, 0.0, 0.0]], 1.0, H).is_err());
        assert!(Singular::on_surface(&square(1e5, 0.0), 1.0, H).is_err());
        for mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let width = Length::mm(mm);
            for kernel in [Nascent::Gaussian { width }, Nascent::Triangle { width }] {
                assert!(matches!(point.dissipated(&grid, kernel), Err(Error::Operand { .. })), "{kernel:?}");
            }
            let field = Field::constant(grid, 1.0);
            assert!(matches!(contact_area(&field, &field, width), Err(Error::Operand { .. })), "{mm}");
        }
        let coarse = Singular::on_polyline(&[[0.0; 3], [1.0; 3]], 1.0, Length::mm(0.4)).unwrap();
        assert!(coarse.dissipated(&grid, Nascent::Triangle { width: H }).is_err());
        assert!(coarse.plus(point).dissipated(&grid, Nascent::Triangle { width: Length::mm(0.5) }).is_ok());
        assert!(Singular::on_surface(&square(1.0, 0.0), 1.0, Length::mm(0.0)).is_err());
    }
}
