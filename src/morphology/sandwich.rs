//! Operators on shapes known from three sides: results enclosed between two sets of samples, and volumes between two
//! numbers.
//!
//! With c the samples inside a shape, t those whose closed cube touches it and f those whose cube lies in it, every
//! operator below encloses the samples of its true result: the lower set lies in them, the upper set holds them. An
//! operator that shrinks takes its element from the opposite side; the plain "outer by outer" is no bound. The phases
//! of the lattices are carried by the grids, and add (or subtract) like the operands.

use super::element::{Sides, StructuringElement};
use super::minkowski::{Path, dilate, erode};
use super::opening::on_grid_of;
use crate::convolution::sum_grid;
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::grid::Grid;
use crate::units::{Length, Volume};

/// Two sets of samples on one grid with `lower ⊆ { samples in the true result } ⊆ upper`, and a volume bracket.
#[derive(Debug, Clone, PartialEq)]
pub struct Sandwich {
    /// Samples certainly in the result.
    pub lower: Indicator,
    /// Samples possibly in the result; every other is certainly outside.
    pub upper: Indicator,
    /// The volume of the true result lies between these two.
    pub volume: [Volume; 2],
    /// How the dilations and erosions were done, in order, each named once.
    pub paths: Vec<Path>,
}

impl Sandwich {
    /// The Minkowski sum A ⊕ B, from cA ⊕ cB and tA ⊕ tB.
    ///
    /// Volume: (fA ⊕ cB) ∪ (cA ⊕ fB) are cubes inside; cubes of twice the side about tA ⊕ tB cover.
    ///
    /// # Errors
    /// [`Error::Operand`] for different spacings.
    pub fn sum(a: &Sides, b: &Sides) -> Result<Self> {
        let mut paths = Vec::new();
        let [lower, upper] = sum_sides(a, b, &mut paths)?;
        let volume = [inside_sum(a, b, &mut paths)?.volume(), covering_volume(&upper, 2)?];
        Ok(Sandwich { lower, upper, volume, paths })
    }

    /// The obstacle A ⊕ (−B): translations at which B meets A.
    ///
    /// # Errors
    /// As [`Sandwich::sum`].
    pub fn obstacle(a: &Sides, b: &Sides) -> Result<Self> {
        Sandwich::sum(a, &b.reflected())
    }

    /// The Minkowski difference (erosion) A ⊖ B, from fA ⊖ tB and cA ⊖ cB.
    ///
    /// # Errors
    /// [`Error::Operand`] for different spacings, or if no sample lies in B.
    pub fn difference(a: &Sides, b: &Sides) -> Result<Self> {
        let mut paths = Vec::new();
        let [lower, upper] = difference_sides(a, b, &mut paths)?;
        let volume = [
            minus(&a.full, &thickened(&b.touched)?, &mut paths)?.volume(),
            minus(&a.touched, &b.points, &mut paths)?.volume(),
        ];
        Ok(Sandwich { lower, upper, volume, paths })
    }

    /// The samples next to which B may be placed so that all of it lies in A, tA ⊖ cB on the grid of the [difference](Self::difference):
    /// every such place has one of them as its nearest sample.
    ///
    /// # Errors
    /// As [`Sandwich::difference`].
    pub fn places(a: &Sides, b: &Sides) -> Result<Indicator> {
        minus(&a.touched, &b.points, &mut Vec::new())
    }

    /// The samples next to which B, mirrored, may stand free of A, on the grid of the [sum](Self::sum): every point that is not in the sum has one of
    /// them as its nearest sample.
    ///
    /// The complement of (fA ⊕ cB) ∪ (cA ⊕ fB): where a cube of one, moved by a point of the other, is full, all that is nearest lies in the sum.
    ///
    /// # Errors
    /// As [`Sandwich::sum`].
    pub fn rooms(a: &Sides, b: &Sides) -> Result<Indicator> {
        Ok(inside_sum(a, b, &mut Vec::new())?.complement())
    }

    /// The two sets of [`Sandwich::sum`] alone.
    ///
    /// # Errors
    /// As there.
    pub fn sides_of_sum(a: &Sides, b: &Sides) -> Result<[Indicator; 2]> {
        sum_sides(a, b, &mut Vec::new())
    }

    /// The two sets of [`Sandwich::difference`] alone.
    ///
    /// # Errors
    /// As there.
    pub fn sides_of_difference(a: &Sides, b: &Sides) -> Result<[Indicator; 2]> {
        difference_sides(a, b, &mut Vec::new())
    }

    /// Both sets, the lower first.
    pub fn sides(&self) -> [&Indicator; 2] {
        [&self.lower, &self.upper]
    }

    /// The opening A ∘ B on A's grid, from (fA ⊖ tB) ⊕ cB and (tA ⊖ cB) ⊕ tB.
    ///
    /// Volume: (fA ⊖ tB) ⊕ fB are cubes inside, and so are those that points of B make of cubes of places, (fA ⊖ (tB ⊕ 3³)) ⊕ cB.
    ///
    /// # Errors
    /// As [`Sandwich::difference`].
    pub fn opening(a: &Sides, b: &Sides) -> Result<Self> {
        let mut paths = Vec::new();
        let allowed = minus(&a.full, &b.touched, &mut paths)?;
        let possible = minus(&a.touched, &b.points, &mut paths)?;
        let element = StructuringElement::new(b.touched.clone())?;
        let on_a = |set: &Indicator| on_grid_of(&a.points, &element, set);
        let lower = on_a(&plus(&allowed, &b.points, &mut paths)?)?;
        let covered = plus(&possible, &b.touched, &mut paths)?;
        let upper = on_a(&covered)?;
        let inside = on_a(&plus(&allowed, &b.full, &mut paths)?)?.union(&carried(a, b, &mut paths)?)?;
        let high = covering_volume(&covered, 2)?.min(a.touched.volume());
        Ok(Sandwich { volume: [inside.volume(), high], lower, upper, paths })
    }

    /// The closing A • B on A's grid, from ((fA ⊕ cB) ∪ (cA ⊕ fB)) ⊖ tB and (tA ⊕ tB) ⊖ cB.
    ///
    /// # Errors
    /// As [`Sandwich::difference`].
    pub fn closing(a: &Sides, b: &Sides) -> Result<Self> {
        let mut paths = Vec::new();
        let element = StructuringElement::new(b.touched.clone())?;
        let on_a = |set: &Indicator| on_grid_of(&a.points, &element, set);
        let inside = inside_sum(a, b, &mut paths)?;
        let outside = plus(&a.touched, &b.touched, &mut paths)?;
        let lower = on_a(&minus(&inside, &b.touched, &mut paths)?)?;
        let upper = on_a(&minus(&outside, &b.points, &mut paths)?)?;
        // Cubes: one more layer on the side that shrinks.
        let [first, dims] = [[-1isize; 3], outside.grid().dims().map(|n| n as isize + 2)];
        let wide = outside.window(first, dims.map(|n| n as usize))?;
        let touched = minus(&around(&wide)?, &b.points, &mut paths)?;
        let kept = minus(&inside, &thickened(&b.touched)?, &mut paths)?;
        let cubes = kept.placed(b.touched.grid().dims().map(|n| n as isize), *a.full.grid())?.union(&a.full)?;
        Ok(Sandwich { volume: [cubes.volume(), touched.volume()], lower, upper, paths })
    }

    /// The regularization of A at grid scale, its opening by the closed cube of one spacing, on A's grid: sheets, wires and
    /// specks that no such cube fits into are gone.
    ///
    /// The cube's corners are samples, so that its own sides are exact; each place for it counts for the cube itself.
    ///
    /// # Errors
    /// As [`Sandwich::difference`].
    pub fn regularization(a: &Sides) -> Result<Self> {
        let cube = StructuringElement::cuboid([2; 3], a.points.grid().spacing())?.set().clone();
        let places = minus(&a.full, &cube, &mut Vec::new())?;
        let cube = Sides { full: Indicator::empty(*cube.grid()), points: cube.clone(), touched: cube };
        let opened = Sandwich::opening(a, &cube)?;
        Ok(Sandwich { volume: [places.volume(), opened.volume[1]], ..opened })
    }

    /// What a tool B sweeps when it may go wherever it does not meet A, within a window of A's lattice:
    /// `¬(A ⊕ −B) ⊕ B`, from ¬(tA ⊕ −tB) ⊕ cB and ¬((fA ⊕ −cB) ∪ (cA ⊕ −fB)) ⊕ tB.
    ///
    /// Touching is not collision, so a tool may slide along A; samples on A's boundary itself stay undecided.
    ///
    /// # Errors
    /// As [`Sandwich::sum`].
    pub fn reachable(a: &Sides, b: &Sides, window: &Grid) -> Result<Self> {
        let mut paths = Vec::new();
        let mirrored = b.reflected();
        let blocked = plus(&a.touched, &mirrored.touched, &mut paths)?;
        let certainly = inside_sum(a, &mirrored, &mut paths)?;
        let wide = window.padded([1; 3], [1; 3])?;
        let free = |obstacle: &Indicator| free_translations(obstacle, &b.points, &wide);
        let within = |swept: &Indicator, grid: &Grid| swept.placed(steps_between(swept.grid(), grid), *grid);
        let (surely_free, maybe_free) = (free(&blocked)?, free(&certainly)?);
        let lower = within(&plus(&surely_free, &b.points, &mut paths)?, window)?;
        let possible = plus(&maybe_free, &b.touched, &mut paths)?;
        let upper = within(&possible, window)?;
        let low = within(&plus(&surely_free, &b.full, &mut paths)?, window)?.volume();
        let all = window.sample_volume() * window.samples() as f64;
        let high = covering_volume(&within(&possible, &wide)?, 2)?.min(all);
        Ok(Sandwich { lower, upper, volume: [low, high], paths })
    }
}

/// Translations of the element that can reach the window, less those in the obstacle.
fn free_translations(obstacle: &Indicator, element: &Indicator, window: &Grid) -> Result<Indicator> {
    let reach = element.grid().dims();
    let origin =
        [0, 1, 2].map(|i| window.origin()[i] - element.grid().origin()[i] - window.h() * (reach[i] - 1) as f64);
    let grid = Grid::new(origin, window.spacing(), sum_grid(window, element.grid())?.dims())?;
    Ok(obstacle.placed(steps_between(obstacle.grid(), &grid), grid)?.complement())
}

/// Whole steps from the first sample of one grid to that of another on the same lattice.
fn steps_between(from: &Grid, to: &Grid) -> [isize; 3] {
    [0, 1, 2].map(|a| ((to.origin()[a] - from.origin()[a]) / from.h()).round() as isize)
}

/// Samples certainly and possibly in A ⊕ B.
fn sum_sides(a: &Sides, b: &Sides, paths: &mut Vec<Path>) -> Result<[Indicator; 2]> {
    Ok([plus(&a.points, &b.points, paths)?, plus(&a.touched, &b.touched, paths)?])
}

/// Samples certainly and possibly in A ⊖ B.
fn difference_sides(a: &Sides, b: &Sides, paths: &mut Vec<Path>) -> Result<[Indicator; 2]> {
    Ok([minus(&a.full, &b.touched, paths)?, minus(&a.points, &b.points, paths)?])
}

/// Cubes that certainly lie in A ⊕ B: a cube moved by a point of the other operand stays a cube inside.
fn inside_sum(a: &Sides, b: &Sides, paths: &mut Vec<Path>) -> Result<Indicator> {
    plus(&a.full, &b.points, paths)?.union(&plus(&a.points, &b.full, paths)?)
}

/// Cubes that certainly lie in A ∘ B: cubes of places for B moved by its points, however thin it is.
fn carried(a: &Sides, b: &Sides, paths: &mut Vec<Path>) -> Result<Indicator> {
    let places = minus(&a.full, &thickened(&b.touched)?, paths)?;
    plus(&places, &b.points, paths)?.placed(b.touched.grid().dims().map(|n| n as isize), *a.points.grid())
}

/// The volume of the union of cubes of `side` spacings about a set's samples.
pub(super) fn covering_volume(set: &Indicator, side: usize) -> Result<Volume> {
    let cube = StructuringElement::cuboid([side; 3], Length::mm(set.grid().h()))?;
    Ok(dilate(set, &cube)?.set.volume())
}

/// The set and all neighbours of its samples, on its own grid, which has room for them.
fn around(set: &Indicator) -> Result<Indicator> {
    let cube = StructuringElement::cuboid([3; 3], Length::mm(set.grid().h()))?;
    dilate(set, &cube)?.set.placed([1; 3], *set.grid())
}

/// The set with all neighbours of its samples, on a grid one sample larger on every side.
fn thickened(set: &Indicator) -> Result<Indicator> {
    let cube = StructuringElement::cuboid([3; 3], Length::mm(set.grid().h()))?;
    Ok(dilate(set, &cube)?.set)
}

fn plus(a: &Indicator, b: &Indicator, paths: &mut Vec<Path>) -> Result<Indicator> {
    if a.is_empty() || b.is_empty() {
        return Ok(Indicator::empty(sum_grid(a.grid(), b.grid())?));
    }
    let sum = dilate(a, &StructuringElement::new(b.clone())?)?;
    note(paths, sum.path);
    Ok(sum.set)
}

fn minus(a: &Indicator, b: &Indicator, paths: &mut Vec<Path>) -> Result<Indicator> {
    let element = StructuringElement::new(b.clone()).map_err(|_| Error::Operand {
        operation: "Minkowski difference",
        problem: format!("no sample lies in the element at a spacing of {}", b.grid().spacing()),
        remedy: "choose a smaller spacing".into(),
    })?;
    let difference = erode(a, &element)?;
    note(paths, difference.path);
    Ok(difference.set)
}

fn note(paths: &mut Vec<Path>, path: Path) {
    if !paths.contains(&path) {
        paths.push(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;

    const PHASES: [[f64; 3]; 3] = [[0.0; 3], [0.25, 0.75, 0.25], [0.6, 0.1, 0.9]];

    fn sides(text: &str, phase: [f64; 3]) -> Sides {
        Sides::of_primitive(&Primitive::parse(text).unwrap(), Length::mm(0.4), phase).unwrap()
    }

    /// Checks both sets against a closed form, samples nearer than 1e-9 mm to the boundary left out.
    fn encloses(found: &Sandwich, truth: impl Fn([f64; 3]) -> f64, volume: f64) {
        let grid = found.lower.grid();
        assert_eq!(grid, found.upper.grid());
        for at in 0..grid.samples() {
            let index = grid.index(at);
            let distance = truth(grid.position(index));
            assert!(distance < 1e-9 || !found.lower.contains(index), "lower has a sample {distance} mm outside");
            assert!(distance > -1e-9 || found.upper.contains(index), "upper lacks a sample {distance} mm inside");
        }
        let [low, high] = found.volume.map(|v| v.as_mm3());
        assert!(low <= volume && volume <= high, "{volume} not in {low} … {high}");
        assert!(low > 0.0, "the bracket says nothing");
    }

    #[test]
    fn balls_add_and_subtract_like_their_radii() {
        let ball = |r: f64| move |p: [f64; 3]| crate::geometry::vector::norm(p) - r;
        let volume = |r: f64| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
        for p in PHASES {
            for q in PHASES {
                let (a, b) = (sides("ball:4mm", p), sides("ball:1.5mm", q));
                encloses(&Sandwich::sum(&a, &b).unwrap(), ball(5.5), volume(5.5));
                encloses(&Sandwich::obstacle(&a, &b).unwrap(), ball(5.5), volume(5.5));
                encloses(&Sandwich::difference(&a, &b).unwrap(), ball(2.5), volume(2.5));
                encloses(&Sandwich::opening(&a, &b).unwrap(), ball(4.0), volume(4.0));
                encloses(&Sandwich::closing(&a, &b).unwrap(), ball(4.0), volume(4.0));
            }
        }
    }

    #[test]
    fn openings_by_a_plate_without_cubes_have_certain_volume() {
        for phase in PHASES {
            let plate = sides("box:2x1x0.1mm", [0.0; 3]);
            assert!(plate.full.is_empty() && !plate.points.is_empty());
            let bar = Primitive::parse("box:8x6x4mm").unwrap();
            encloses(
                &Sandwich::opening(&sides("box:8x6x4mm", phase), &plate).unwrap(),
                |p| bar.signed_distance(p),
                192.0,
            );
        }
    }

    #[test]
    fn regularization_keeps_a_solid_and_loses_a_wire() {
        for phase in PHASES {
            let bar = Primitive::parse("box:4x3x2mm").unwrap();
            encloses(
                &Sandwich::regularization(&sides("box:4x3x2mm", phase)).unwrap(),
                |p| bar.signed_distance(p),
                24.0,
            );
            // No cube of 0.4 mm fits into a rod of 0.1 mm, and the samples see none of it for certain.
            let rod = Sandwich::regularization(&sides("cylinder:r0.05h6mm", phase)).unwrap();
            assert!(rod.lower.is_empty() && rod.volume[0].as_mm3() == 0.0);
        }
    }

    #[test]
    fn a_tool_reaches_around_a_block_and_not_into_it() {
        let (a, b) = (sides("box:4x3x2mm", [0.25; 3]), sides("box:1x1x2mm", [0.75, 0.25, 0.5]));
        let (origin, h) = (a.points.grid().origin().map(|x| x - 2.0), Length::mm(0.4));
        let window = Grid::new(origin, h, a.points.grid().dims().map(|n| n + 10)).unwrap();
        let found = Sandwich::reachable(&a, &b, &window).unwrap();
        let block = Primitive::parse("box:4x3x2mm").unwrap();
        let volume = window.sample_volume().as_mm3() * window.samples() as f64 - 24.0;
        encloses(&found, |p| -block.signed_distance(p), volume);
    }

    #[test]
    fn an_element_without_samples_is_refused_for_a_difference_and_adds_nothing_below() {
        let (a, speck) = (sides("ball:2mm", [0.0; 3]), sides("ball:0.05mm", [0.5; 3]));
        assert!(Sandwich::difference(&a, &speck).is_err());
        let sum = Sandwich::sum(&a, &speck).unwrap();
        assert!(sum.lower.is_empty() && !sum.upper.is_empty());
    }
}
