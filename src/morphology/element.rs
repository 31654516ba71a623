//! The structuring element: the set that a part is dilated and eroded with.

use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::geometry::{InsideRule, Primitive, TriangleMesh, enclose, interior_point};
use crate::grid::Grid;
use crate::units::Length;

/// A set B of samples about an anchor, the sample nearest to the world's origin.
///
/// The grid of the set says where the samples stand: sample `i` is the vector `origin + h·i`. An element whose origin is
/// a whole multiple of the spacing keeps the lattice of what it is applied to; any other shifts it by its phase.
#[derive(Debug, Clone, PartialEq)]
pub struct StructuringElement {
    set: Indicator,
    anchor: [isize; 3],
    shape: Shape,
}

/// What is known of an element beyond its samples: it decides which paths are open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// All samples at squared distance at most this many spacings² from the anchor: a digital ball.
    Ball { radius2: u64 },
    /// Every sample of the grid.
    Box,
    /// Anything else.
    General,
}

impl StructuringElement {
    /// The element of a set.
    ///
    /// # Errors
    /// [`Error::Operand`] if the set is empty.
    pub fn new(set: Indicator) -> Result<Self> {
        if set.is_empty() {
            return Err(empty("the set has no samples"));
        }
        let shape = if set.count() == set.grid().samples() as u64 { Shape::Box } else { Shape::General };
        Ok(StructuringElement { anchor: anchor_of(set.grid()), set, shape })
    }

    /// The digital ball `{ k·h : |k|·h ≤ radius }` about a sample at the origin.
    ///
    /// # Errors
    /// [`Error::Operand`] if the radius is negative, not finite, or more than a thousand spacings.
    pub fn ball(radius: Length, spacing: Length) -> Result<Self> {
        let cells = radius / spacing;
        if !(cells.is_finite() && (0.0..=1000.0).contains(&cells)) {
            return Err(Error::Operand {
                operation: "structuring element",
                problem: format!("a ball of {} mm at a spacing of {} mm", radius.as_mm(), spacing.as_mm()),
                remedy: "give a finite radius between zero and a thousand spacings".into(),
            });
        }
        // A radius that is a whole number of spacings but for rounding is that number.
        let radius2 = (cells * cells * (1.0 + 1e-12)).floor() as u64;
        let reach = radius2.isqrt() as usize;
        let grid = Grid::new([-(reach as f64) * spacing.as_mm(); 3], spacing, [2 * reach + 1; 3])?;
        let set = Indicator::from_predicate(grid, |at| {
            let p = grid.index(at);
            p.iter().map(|&i| i.abs_diff(reach).pow(2) as u64).sum::<u64>() <= radius2
        });
        Ok(StructuringElement { set, anchor: [reach as isize; 3], shape: Shape::Ball { radius2 } })
    }

    /// The box of `counts` samples whose anchor is its sample `counts/2`.
    ///
    /// # Errors
    /// [`Error::Operand`] if a count is zero.
    pub fn cuboid(counts: [usize; 3], spacing: Length) -> Result<Self> {
        let origin = counts.map(|n| -((n / 2) as f64) * spacing.as_mm());
        StructuringElement::new(Indicator::from_predicate(Grid::new(origin, spacing, counts)?, |_| true))
    }

    /// The samples of the element.
    pub fn set(&self) -> &Indicator {
        &self.set
    }

    /// Index of the sample nearest to the world's origin; it may lie outside the element's grid.
    pub fn anchor(&self) -> [isize; 3] {
        self.anchor
    }

    /// What is known of the element beyond its samples.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// B̌ = { −b : b ∈ B }.
    pub fn reflected(&self) -> Self {
        let set = self.set.reflected();
        StructuringElement { anchor: anchor_of(set.grid()), set, shape: self.shape }
    }

    /// Whether B = B̌, sample for sample.
    pub fn is_symmetric(&self) -> bool {
        let mirrored = self.set.reflected();
        let close =
            |a: usize| (mirrored.grid().origin()[a] - self.set.grid().origin()[a]).abs() < 1e-9 * self.set.grid().h();
        (0..3).all(close) && mirrored.words() == self.set.words()
    }

    /// The element without empty borders, on the same lattice.
    ///
    /// # Errors
    /// As [`Indicator::window`].
    pub fn cropped(&self) -> Result<Self> {
        let Some((first, dims)) = self.set.support_box() else { return Err(empty("the set has no samples")) };
        if dims == self.set.grid().dims() {
            return Ok(self.clone());
        }
        StructuringElement::new(self.set.window(first.map(|i| i as isize), dims)?)
    }
}

/// A shape on a lattice from three sides: `full ⊆ points ⊆ touched`, all on one grid.
///
/// Certified operators take one operand from one side and the other from the opposite side; [`super::Sandwich`] knows
/// which.
#[derive(Debug, Clone, PartialEq)]
pub struct Sides {
    /// Samples whose closed cube lies in the shape.
    pub full: Indicator,
    /// Samples that lie in the shape.
    pub points: Indicator,
    /// Samples whose closed cube touches the shape.
    pub touched: Indicator,
}

impl Sides {
    /// The three sides of a closed mesh on a lattice of its own, `phase` (in spacings) from the world's origin, the
    /// grid just large enough.
    ///
    /// # Errors
    /// [`Error::NoGeometry`] for a mesh without facets, otherwise as [`enclose`].
    ///
    /// # Cost
    /// As [`enclose`].
    pub fn of_mesh(mesh: &TriangleMesh, spacing: Length, phase: [f64; 3]) -> Result<Self> {
        let (lo, hi) = mesh.bounds().ok_or_else(|| Error::NoGeometry {
            problem: "the mesh has no facets".into(),
            remedy: "give a closed mesh".into(),
        })?;
        let cast = enclose(mesh, &lattice_box(lo, hi, spacing, phase)?, InsideRule::Crossings)?;
        Ok(Sides { full: cast.inner, points: cast.centres, touched: cast.outer })
    }

    /// As [`Sides::of_mesh`], with a sample in the shape however thin it is: where the lattice at `phase` has none, on one through a
    /// point of it.
    ///
    /// # Errors
    /// As [`Sides::of_mesh`].
    ///
    /// # Cost
    /// As [`Sides::of_mesh`], twice at most.
    pub fn with_sample(mesh: &TriangleMesh, spacing: Length, phase: [f64; 3]) -> Result<Self> {
        let sides = Self::of_mesh(mesh, spacing, phase)?;
        if !sides.points.is_empty() {
            return Ok(sides);
        }
        let Some(p) = interior_point(mesh) else { return Ok(sides) };
        let through = Self::of_mesh(mesh, spacing, p.map(|x| (x / spacing.as_mm()).rem_euclid(1.0)))?;
        Ok(if through.points.is_empty() { sides } else { through })
    }

    /// The three sides of a built-in shape, from its exact distance: a cube touches it, or lies in it, as far as the
    /// ball around the cube cannot tell otherwise.
    ///
    /// # Errors
    /// [`Error::Operand`] for sizes that are not positive.
    ///
    /// # Cost
    /// One distance for each sample of the box around the shape.
    pub fn of_primitive(shape: &Primitive, spacing: Length, phase: [f64; 3]) -> Result<Self> {
        shape.validate()?;
        let half = shape.half_extent();
        let grid = lattice_box(half.map(|x| -x), half, spacing, phase)?;
        let ball = 0.5 * 3f64.sqrt() * grid.h() * (1.0 + 1e-12);
        let within = |level: f64| {
            Indicator::from_predicate(grid, |at| shape.signed_distance(grid.position(grid.index(at))) <= level)
        };
        Ok(Sides { full: within(-ball), points: within(0.0), touched: within(ball) })
    }

    /// The same sides reflected about the world's origin.
    pub fn reflected(&self) -> Self {
        Sides { full: self.full.reflected(), points: self.points.reflected(), touched: self.touched.reflected() }
    }
}

/// The grid of the lattice `h·(Z³ + phase)` that holds a box and one more cube on every side.
pub(super) fn lattice_box(lo: [f64; 3], hi: [f64; 3], spacing: Length, phase: [f64; 3]) -> Result<Grid> {
    let h = spacing.as_mm();
    let axes = [0, 1, 2];
    let first = axes.map(|a| (lo[a] / h - phase[a] - 0.5).floor() - 1.0);
    let last = axes.map(|a| (hi[a] / h - phase[a] + 0.5).ceil() + 1.0);
    let counts = axes.map(|a| if (last[a] - first[a]) < 1e12 { (last[a] - first[a]) as usize + 1 } else { usize::MAX });
    Grid::new(axes.map(|a| (first[a] + phase[a]) * h), spacing, counts)
}

fn anchor_of(grid: &Grid) -> [isize; 3] {
    grid.origin().map(|o| (-o / grid.h()).round() as isize)
}

fn empty(problem: &str) -> Error {
    Error::Operand {
        operation: "structuring element",
        problem: problem.into(),
        remedy: "choose a smaller spacing or a larger element".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_and_boxes_are_symmetric_and_lopsided_sets_are_not() {
        let h = Length::mm(0.5);
        let ball = StructuringElement::ball(Length::mm(1.0), h).unwrap();
        // |k| ≤ 2: 33 points of the cubic lattice.
        assert_eq!((ball.set().count(), ball.anchor(), ball.is_symmetric()), (33, [2; 3], true));
        assert!(StructuringElement::cuboid([3, 5, 1], h).unwrap().is_symmetric());
        let even = StructuringElement::cuboid([2, 3, 3], h).unwrap();
        assert!(!even.is_symmetric());
        assert_eq!(even.reflected().anchor(), [0, 1, 1]);
        assert_eq!(even.reflected().reflected(), even);
        assert_eq!(even.shape(), Shape::Box);
    }

    #[test]
    fn empty_sets_and_impossible_radii_are_refused() {
        let h = Length::mm(0.5);
        assert!(StructuringElement::new(Indicator::empty(Grid::new([0.0; 3], h, [2; 3]).unwrap())).is_err());
        for radius in [-1.0, f64::NAN, f64::INFINITY, 1e9] {
            assert!(StructuringElement::ball(Length::mm(radius), h).is_err());
        }
    }

    #[test]
    fn a_lattice_passes_through_what_is_thinner_than_its_spacing() {
        let (h, phase) = (Length::mm(0.3), [0.25; 3]);
        let plate = Primitive::parse("box:3x2x0.01mm").unwrap().mesh(h);
        let turned = plate.transformed([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]], [7.0, 8.0, 9.0]);
        for mesh in [&plate, &turned] {
            assert!(Sides::of_mesh(mesh, h, phase).unwrap().points.is_empty());
            let found = Sides::with_sample(mesh, h, phase).unwrap();
            assert!(!found.points.is_empty() && found.full.is_empty());
            assert!(found.points.is_subset(&found.touched).unwrap());
        }
        let block = Primitive::parse("box:3x2x1mm").unwrap().mesh(h);
        assert_eq!(Sides::with_sample(&block, h, phase).unwrap(), Sides::of_mesh(&block, h, phase).unwrap());
    }

    #[test]
    fn sides_are_nested_and_sit_on_the_asked_lattice() {
        let shape = Primitive::parse("cone:r2r0.5h3mm").unwrap();
        let (h, phase) = (Length::mm(0.3), [0.25, 0.75, 0.25]);
        let mesh = shape.mesh(Length::mm(0.01));
        for sides in [Sides::of_primitive(&shape, h, phase).unwrap(), Sides::of_mesh(&mesh, h, phase).unwrap()] {
            assert!(sides.full.is_subset(&sides.points).unwrap() && sides.points.is_subset(&sides.touched).unwrap());
            for (position, phase) in sides.points.grid().origin().iter().zip(phase) {
                let turns = position / 0.3 - phase;
                assert!((turns - turns.round()).abs() < 1e-9);
            }
            let (first, dims) = sides.touched.support_box().unwrap();
            let all = sides.touched.grid().dims();
            assert!((0..3).all(|a| first[a] >= 1 && first[a] + dims[a] < all[a]), "no room around the shape");
        }
    }
}
