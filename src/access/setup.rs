//! A part as it stands before a tool: turned so that the tool comes from above, and cast.

use super::pose::{Rotation, Turns, frame_of, lattice_directions, transposed};
use crate::convolution::Descent;
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, dot, norm};
use crate::geometry::{InsideRule, TriangleMesh, voxelize};
use crate::grid::Grid;
use crate::once::once;
use crate::units::Length;
use rayon::prelude::*;
use std::sync::OnceLock;

/// A part cast for tools whose axis is `direction`, which points from the tip to the hand.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Direction the tool comes from, in the frame of the part.
    pub direction: Vec3,
    /// Rows of the matrix from the part's frame to this one, in which the tool comes from +z. That of an opposite direction
    /// mirrors: for tools that are symmetric about their axis that is as good as a rotation.
    pub frame: Rotation,
    /// Cubes wholly in the part.
    pub inner: Indicator,
    /// Samples in the part.
    pub centres: Indicator,
    /// Cubes the part touches.
    pub outer: Indicator,
    /// The rotations at which tools of any shape come from here; coaxial ones always do.
    pub turns: Turns,
    /// `inner` and `outer` made ready for tools of any shape, when first asked for.
    ready: [OnceLock<Descent>; 2],
}

impl Setup {
    /// The part turned and cast, with `margin` of free space around it.
    ///
    /// # Errors
    /// [`Error::Operand`] for a direction that is none, or a margin that is not finite; otherwise as [`voxelize()`].
    ///
    /// # Cost
    /// As [`voxelize()`].
    pub fn cast(
        mesh: &TriangleMesh,
        rule: InsideRule,
        direction: Vec3,
        spacing: Length,
        margin: Length,
    ) -> Result<Self> {
        let refused = |problem: String| Error::Operand {
            operation: "setup",
            problem,
            remedy: "give a finite direction that is not zero, and a finite margin".into(),
        };
        // Its length has to be a number, and not 0, to be divided by.
        if !norm(direction).is_normal() {
            return Err(refused(format!("a tool along {direction:?} comes from nowhere")));
        }
        if !margin.as_mm().is_finite() {
            return Err(refused(format!("a margin of {margin}")));
        }
        let frame = frame_of(direction);
        let turned = mesh.transformed(frame, [0.0; 3]);
        let (lo, hi) = turned.bounds().unwrap_or_default();
        let samples = (margin / spacing).ceil() as usize;
        let grid = Grid::covering(lo, hi, spacing, samples.saturating_add(1), [0.0; 3])?;
        let solid = match voxelize(&turned, &grid, rule) {
            Err(Error::Operand { .. }) => voxelize(&turned, &grid, InsideRule::Winding)?,
            other => other?,
        };
        Ok(Setup::of_sets(direction, frame, [solid.inner, solid.centres, solid.outer]))
    }

    /// A setup of its inner cubes, samples and touched cubes.
    pub(super) fn of_sets(direction: Vec3, frame: Rotation, [inner, centres, outer]: [Indicator; 3]) -> Self {
        Setup { direction, frame, inner, centres, outer, turns: Turns::default(), ready: Default::default() }
    }

    /// The part for every direction of a list, in its order; one that follows its opposite is its mirror image and costs no cast.
    ///
    /// # Errors
    /// As [`Setup::cast`].
    pub fn all(
        mesh: &TriangleMesh,
        rule: InsideRule,
        directions: &[Vec3],
        spacing: Length,
        margin: Length,
    ) -> Result<Vec<Self>> {
        let mut runs: Vec<&[Vec3]> = Vec::new();
        let mut rest = directions;
        while let Some((first, after)) = rest.split_first() {
            let mirrored = after.first().is_some_and(|d| (0..3).all(|a| d[a] == -first[a]));
            let (run, left) = rest.split_at(if mirrored { 2 } else { 1 });
            runs.push(run);
            rest = left;
        }
        let cast = runs.into_par_iter().map(|run| {
            let mut setups = vec![Setup::cast(mesh, rule, run[0], spacing, margin)?];
            if run.len() > 1 {
                setups.push(setups[0].opposite()?);
            }
            Ok(setups)
        });
        let cast: Result<Vec<Vec<Setup>>> = cast.collect();
        Ok(cast?.into_iter().flatten().collect())
    }

    /// Samples that the setups of a box from all directions have together, known before any is cast.
    pub fn samples(extent: Vec3, spacing: Length, margin: Length) -> u128 {
        let along = |row: Vec3| (0..3).map(|a| row[a].abs() * extent[a]).sum::<f64>() + 2.0 * margin.as_mm();
        let counts =
            |frame: Rotation| frame.map(|row| (along(row) / spacing.as_mm()).ceil().clamp(1.0, 1e9) as u128 + 3);
        lattice_directions().into_iter().map(|d| counts(frame_of(d)).into_iter().product::<u128>()).sum()
    }

    /// The same part for tools from the opposite direction: its mirror image, without casting again.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn opposite(&self) -> Result<Self> {
        let grid = self.inner.grid();
        let top = grid.position([0, 0, grid.dims()[2] - 1]);
        let mirrored = Grid::new([top[0], top[1], -top[2]], grid.spacing(), grid.dims())?;
        let flip = |set: &Indicator| flipped(set, mirrored);
        let [a, b, d] = self.frame;
        let sets = [flip(&self.inner)?, flip(&self.centres)?, flip(&self.outer)?];
        Ok(Setup::of_sets(self.direction.map(|x| 0.0 - x), [a, b, d.map(|x| 0.0 - x)], sets))
    }

    /// A point of the part's frame in this one; directions likewise.
    pub fn to_frame(&self, p: Vec3) -> Vec3 {
        self.frame.map(|row| dot(row, p))
    }

    /// A point of this frame in the part's.
    pub fn to_part(&self, p: Vec3) -> Vec3 {
        transposed(self.frame).map(|row| dot(row, p))
    }

    /// The cubes wholly in the part, made ready for tools of any shape.
    pub fn inner_descent(&self) -> &Descent {
        once(&self.ready[0], || Descent::new(&self.inner))
    }

    /// The cubes the part touches, made ready for tools of any shape.
    pub fn outer_descent(&self) -> &Descent {
        once(&self.ready[1], || Descent::new(&self.outer))
    }

    /// The grid of its sets.
    pub fn grid(&self) -> &Grid {
        self.inner.grid()
    }
}

/// A set with its layers in the opposite order.
pub(super) fn flipped(set: &Indicator, mirrored: Grid) -> Result<Indicator> {
    let layer = set.words_per_row() * set.grid().dims()[1];
    Indicator::from_words(mirrored, set.words().chunks(layer).rev().flatten().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;

    #[test]
    fn directions_from_nowhere_and_margins_without_end_are_refused() {
        let mesh = Primitive::parse("box:2x2x2mm").unwrap().mesh(Length::mm(1.0));
        let cast = |d, mm| Setup::cast(&mesh, InsideRule::Crossings, d, Length::mm(0.5), Length::mm(mm));
        for (direction, margin) in [
            ([0.0; 3], 1.0),
            ([0.0, f64::NAN, 1.0], 1.0),
            ([f64::INFINITY, 0.0, 0.0], 1.0),
            ([0.0, 0.0, 1.0], f64::INFINITY),
            ([0.0, 0.0, 1.0], f64::NAN),
            ([0.0, 0.0, 1.0], 1e300),
        ] {
            assert!(matches!(cast(direction, margin), Err(Error::Operand { .. })), "{direction:?} {margin}");
        }
        assert!(cast([0.0, 0.0, 7.0], 1.0).is_ok());
    }

    #[test]
    fn the_opposite_is_what_casting_the_other_way_round_gives() {
        let mesh = Primitive::parse("cone:r4r1h6mm").unwrap().mesh(Length::mm(0.01));
        let h = Length::mm(0.5);
        let cast = |d| Setup::cast(&mesh, InsideRule::Crossings, d, h, Length::mm(1.0)).unwrap();
        let (up, down) = (cast([0.0, 0.0, 1.0]), cast([0.0, 0.0, -1.0]));
        let flipped = up.opposite().unwrap();
        assert_eq!(flipped.direction, down.direction);
        assert_eq!((flipped.inner.count(), flipped.outer.count()), (down.inner.count(), down.outer.count()));
        // The thin end, which was above, is below.
        let least =
            |s: &Setup, z: usize| s.outer.row(s.grid().dims()[1] / 2, z).iter().map(|w| w.count_ones()).sum::<u32>();
        let top = up.grid().dims()[2] - 5;
        assert!(least(&up, top) < least(&up, 4) && least(&flipped, top) > least(&flipped, 4));
        for p in [[0.3, -2.0, 1.1], [1.0, 2.0, 3.0]] {
            let back = flipped.to_part(flipped.to_frame(p));
            assert!((0..3).all(|a| (back[a] - p[a]).abs() < 1e-12));
        }
    }
}
