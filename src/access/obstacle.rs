//! Obstacles in the space of translations: blocked for certain, free for certain, undecided.

use super::meridian::Meridian;
use super::setup::Setup;
use super::stack::{Sense, Stack};
use crate::convolution::Descent;
use crate::error::Result;
use crate::field::Indicator;
use crate::morphology::{Sides, StructuringElement, dilate};
use crate::units::{Angle, Length};

/// How far a tool may turn from the rotation it is laid out in, about its tip: the free answer then holds for all of it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inflation {
    /// Half-width of the cell of rotations.
    pub turn: Angle,
}

impl Inflation {
    /// How far a turn within the cell moves a point at a distance from the tip: 2·ℓ·sin(θ/2).
    fn moves(self, from_tip: f64) -> f64 {
        2.0 * from_tip * (0.5 * self.turn.as_radians()).sin()
    }
}

/// What is known of each cell of translations, a cube about a sample of the lattice.
///
/// *Blocked*: the tool overlaps the part at every translation of the cell, at the rotation it was laid out in. *Free*: it
/// overlaps it at none, for every rotation within the inflation. Touching is no overlap.
#[derive(Debug, Clone, PartialEq)]
pub struct Trio {
    pub blocked: Indicator,
    pub free: Indicator,
}

impl Trio {
    /// The cells of a coaxial tool in a setup, on the setup's grid.
    ///
    /// Blocked rests on cubes wholly in the part, free on cubes it touches; the tool itself is exact.
    ///
    /// # Errors
    /// [`crate::Error::Operand`] for a cell of rotations of 30° or more.
    ///
    /// # Cost
    /// As [`Stack::dilate`], twice.
    pub fn of_coaxial(setup: &Setup, tool: &Meridian, inflation: Inflation) -> Result<Self> {
        let spacing = setup.grid().spacing();
        let growth = inflation.moves(1.0);
        if !(0.0..0.5).contains(&growth) {
            return Err(crate::Error::Operand {
                operation: "obstacle",
                problem: format!("a cell of rotations of {}", inflation.turn),
                remedy: "list rotations closer to each other".into(),
            });
        }
        // A point that comes to this height may have stood as much higher as it moved.
        let far = |z: f64| growth / (1.0 - growth) * z.abs().hypot(tool.widest());
        let possibly = Stack::possibly(tool, spacing, setup.grid().dims()[2], far);
        Ok(Trio {
            blocked: Stack::surely(tool, spacing).dilate(&setup.inner, Sense::Obstacle),
            free: possibly.dilate(&setup.outer, Sense::Obstacle).complement(),
        })
    }

    /// The cells of any shape B against A, both known from three sides on lattices of one spacing: on the grid of all
    /// translations at which their grids meet, one cell wider.
    ///
    /// Blocked: fA ⋆ fB ≥ 1, as cubes moved by less than a cube still overlap. Free: tA ⋆ tB = 0 at the cell and all its
    /// neighbours.
    ///
    /// # Errors
    /// [`crate::Error::Operand`] for different spacings.
    ///
    /// # Cost
    /// As [`Descent::met_by`], twice.
    pub fn of_sides(a: &Sides, b: &Sides, inflation: Inflation) -> Result<Self> {
        let spacing = a.points.grid().spacing();
        let touched = inflated(&b.touched, inflation)?;
        let wide = |set: &Indicator, by: usize| {
            let dims = set.grid().dims().map(|n| n + 2 * by);
            set.window([-(by as isize); 3], dims)
        };
        let met = Descent::new(&a.touched).met_by(&touched)?;
        let near = StructuringElement::cuboid([3; 3], Length::mm(spacing.as_mm()))?;
        let possible = dilate(&met, &near)?.set;
        let surely = Descent::new(&a.full).met_by(&b.full)?;
        let by = (possible.grid().dims()[0] - surely.grid().dims()[0]) / 2;
        let blocked = wide(&surely, by)?;
        // One lattice, but for the rounding of origins.
        let blocked = Indicator::from_words(*possible.grid(), blocked.words().to_vec())?;
        Ok(Trio { blocked, free: possible.complement() })
    }

    /// The cells of which nothing is known.
    ///
    /// # Errors
    /// None for a trio made here.
    pub fn undecided(&self) -> Result<Indicator> {
        self.blocked.union(&self.free).map(|decided| decided.complement())
    }
}

/// A set of cubes with all that a turn within the cell of rotations may move it over.
fn inflated(set: &Indicator, inflation: Inflation) -> Result<Indicator> {
    let grid = set.grid();
    let ends = [[0; 3], grid.dims().map(|n| n - 1)].map(|i| grid.position(i));
    let far = (0..3).map(|a| ends[0][a].abs().max(ends[1][a].abs()) + grid.h()).fold(0.0, |s: f64, x| s.hypot(x));
    let by = (inflation.moves(far) / grid.h()).ceil() as usize;
    if by == 0 {
        return Ok(set.clone());
    }
    Ok(dilate(set, &StructuringElement::cuboid([2 * by + 1; 3], grid.spacing())?)?.set)
}

#[cfg(test)]
mod tests {
    use super::super::meridian::{Outline, Piece, Role};
    use super::*;
    use crate::geometry::vector::norm;
    use crate::geometry::{InsideRule, Primitive};

    const H: Length = Length::mm(0.4);

    fn sides(text: &str, phase: [f64; 3]) -> Sides {
        Sides::of_primitive(&Primitive::parse(text).unwrap(), H, phase).unwrap()
    }

    /// Asserts that no point of a blocked cell is outside the true obstacle and none of a free cell inside it.
    fn encloses(trio: &Trio, inside: impl Fn([f64; 3]) -> f64) {
        let grid = trio.free.grid();
        let half = 0.5 * grid.h();
        for at in 0..grid.samples() {
            let index = grid.index(at);
            for corner in 0..8 {
                let p = grid.position(index);
                let p = [0, 1, 2].map(|a| p[a] + half * if corner >> a & 1 == 1 { 0.999 } else { -0.999 });
                let depth = inside(p);
                assert!(!trio.blocked.contains(index) || depth > 0.0, "blocked, and free at {p:?} by {depth}");
                assert!(!trio.free.contains(index) || depth <= 0.0, "free, and blocked at {p:?} by {depth}");
            }
        }
        let share = trio.undecided().unwrap().count() as f64 / grid.samples() as f64;
        assert!(share < 0.5 && !trio.blocked.is_empty() && !trio.free.is_empty(), "{share}");
    }

    #[test]
    fn balls_and_boxes_against_each_other_as_in_the_closed_form() {
        let trio = |a, b| Trio::of_sides(&a, &b, Inflation::default()).unwrap();
        encloses(&trio(sides("ball:4mm", [0.25; 3]), sides("ball:2mm", [0.6, 0.1, 0.9])), |t| 6.0 - norm(t));
        let boxes = |t: [f64; 3]| (0..3).map(|a| [5.0, 3.5, 2.5][a] - t[a].abs()).fold(f64::INFINITY, f64::min);
        encloses(&trio(sides("box:6x5x4mm", [0.25; 3]), sides("box:4x2x1mm", [0.4, 0.2, 0.7])), boxes);
    }

    #[test]
    fn a_lopsided_tool_is_reflected() {
        // A box from the tip to one side only: it meets the part where the part lies on that side.
        let shifted = |text: &str, by: [f64; 3]| {
            let mesh = Primitive::parse(text).unwrap().mesh(H);
            let mesh = mesh.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], by);
            Sides::of_mesh(&mesh, H, [0.25; 3]).unwrap()
        };
        let (a, b) = (shifted("box:4mm", [0.0; 3]), shifted("box:3x2x1mm", [1.5, 1.0, 0.5]));
        let trio = Trio::of_sides(&a, &b, Inflation::default()).unwrap();
        let inside =
            |t: [f64; 3]| (0..3).map(|i| (t[i] + [5.0, 4.0, 3.0][i]).min(2.0 - t[i])).fold(f64::INFINITY, f64::min);
        encloses(&trio, inside);
    }

    #[test]
    fn a_coaxial_tool_over_a_block_and_beside_it() {
        let block = Primitive::parse("box:8x6x4mm").unwrap();
        let setup = Setup::cast(&block.mesh(H), InsideRule::Crossings, [0.0, 0.0, 1.0], H, Length::mm(6.0)).unwrap();
        let straight = |role, from, to, r| Piece { role, from, to, outline: Outline::Straight { lower: r, upper: r } };
        let tool = Meridian::new(vec![straight(Role::Cutter, 0.0, 2.0, 1.0), straight(Role::Holder, 2.0, 4.0, 2.5)]);
        let trio = Trio::of_coaxial(&setup, &tool, Inflation::default()).unwrap();
        encloses(&trio, |t| {
            let p = setup.to_part(t);
            let beside = (0..2).map(|a| (p[a].abs() - [4.0, 3.0][a]).max(0.0)).fold(0.0, f64::hypot);
            let under = |from: f64, r: f64| (r - beside).min(2.0 - (p[2] + from));
            under(0.0, 1.0).max(under(2.0, 2.5))
        });
    }

    #[test]
    fn a_cell_of_rotations_is_free_only_if_every_turned_tool_is() {
        let ball = Primitive::parse("ball:2mm").unwrap();
        let setup =
            Setup::cast(&ball.mesh(Length::mm(0.001)), InsideRule::Crossings, [0.0, 0.0, 1.0], H, Length::mm(5.0))
                .unwrap();
        let straight =
            Piece { role: Role::Cutter, from: 0.0, to: 8.0, outline: Outline::Straight { lower: 0.6, upper: 0.6 } };
        let tool = Meridian::new(vec![straight]);
        let turn = Angle::degrees(8.0);
        let still = Trio::of_coaxial(&setup, &tool, Inflation::default()).unwrap();
        let turning = Trio::of_coaxial(&setup, &tool, Inflation { turn }).unwrap();
        assert!(turning.free.is_subset(&still.free).unwrap() && turning.free.count() < still.free.count());
        let grid = turning.free.grid();
        for at in turning.free.iter() {
            let t = grid.position(grid.index(at));
            for n in 0..12 {
                let (a, b) = (turn.as_radians() * 0.999, std::f64::consts::TAU * f64::from(n) / 12.0);
                let axis = [a.sin() * b.cos(), a.sin() * b.sin(), a.cos()];
                // The ball's centre before the turned tool, which has no upper end: how far beside it, and how far below.
                let along = (0..3).map(|i| -t[i] * axis[i]).sum::<f64>();
                let beside = norm([0, 1, 2].map(|i| -t[i] - along * axis[i]));
                let near = (beside - 0.6).max(0.0).hypot((-along).max(0.0));
                assert!(near >= 2.0 - 0.05, "free at {t:?}, but turned it comes to {near}");
            }
        }
    }
}
