//! A part as a process lays it down: the overlap ratio of its least element, and the family of shapes that follow from it.
//!
//! With B the element, ρ(x) = vol(Ω ∩ (x + B)) / vol B is the share of the element that would lie in the part Ω. A process
//! that deposits wherever ρ ≥ λ makes Ω_λ = { ρ ≥ λ } ⊕ B. Ω₁ is the opening of Ω by B, all of it inside Ω; the smaller λ,
//! the larger Ω_λ.
//!
//! A slicer moves the outline inwards by half a bead before it lays one along it, so that faces come out where they are drawn. That is
//! [`Designed::compensated`]: what a share of the element holds stays as drawn, and nothing spreads farther than a given length.

use super::cells::Cells;
use super::least_element::Bead;
use super::overlap::Prism;
use super::spread::Spread;
use crate::error::{Error, Result};
use crate::field::{Density, Field, Indicator};
use crate::geometry::contour::superlevel_surface;
use crate::geometry::{Enclosure, InsideRule, Solid, TriangleMesh, enclose, voxelize};
use crate::grid::Grid;
use crate::units::{Length, Volume};
use rayon::prelude::*;

/// A part on the lattice of a process' element.
#[derive(Debug, Clone, PartialEq)]
pub struct Designed {
    pub cells: Cells,
    pub bead: Bead,
    /// The part as designed, from three sides.
    pub shape: Enclosure,
    element: Prism,
}

/// A part as printed at one λ, from three sides: `lower ⊆ Ω_λ ⊆ upper` as unions of closed cells, for the element made of
/// whole cells; `centres` is the same with the part's samples for the part.
///
/// The true ratio of a part is enclosed by those of its inner and outer cells. Between lattice positions the ratio of a
/// union of cells is trilinear, so a placement where it reaches λ lies less than a cell from a lattice position where it
/// does: hence the one cell by which `upper` is wider.
#[derive(Debug, Clone, PartialEq)]
pub struct AsPrinted {
    pub designed: Designed,
    pub lambda: f64,
    /// How far an upright face spreads at most, if the outline was compensated.
    pub spread: Option<Length>,
    pub lower: Indicator,
    pub centres: Indicator,
    pub upper: Indicator,
}

impl Designed {
    /// Casts a mesh on a lattice of an element.
    ///
    /// # Errors
    /// As [`enclose`].
    pub fn cast(mesh: &TriangleMesh, rule: InsideRule, bead: Bead, cells: Cells) -> Result<Self> {
        let shape = enclose(&cells.stretched(mesh), &cells.grid, rule)?;
        Ok(Designed { element: cells.element(bead.footprint)?, cells, bead, shape })
    }

    /// As [`Designed::cast`] by crossings, with the share of each cell that the part fills.
    ///
    /// # Errors
    /// As [`voxelize()`].
    ///
    /// # Cost
    /// That of [`Designed::cast`] and four bytes a cell.
    pub fn cast_with_density(mesh: &TriangleMesh, bead: Bead, cells: Cells) -> Result<(Self, Density)> {
        let Solid { inner, centres, outer, density, .. } =
            voxelize(&cells.stretched(mesh), &cells.grid, InsideRule::Crossings)?;
        let shape = Enclosure { inner, centres, outer };
        Ok((Designed { element: cells.element(bead.footprint)?, cells, bead, shape }, density))
    }

    /// The shape grown by whole cells along every axis.
    pub fn thickened(&self, cells: usize) -> Self {
        let Enclosure { inner, centres, outer } = &self.shape;
        let [inner, centres, outer] = [inner, centres, outer].map(|set| grown(set, cells));
        Designed { shape: Enclosure { inner, centres, outer }, ..self.clone() }
    }

    /// The shape without what lies within whole cells of its outside, along every axis.
    pub fn thinned(&self, cells: usize) -> Self {
        let Enclosure { inner, centres, outer } = &self.shape;
        let [inner, centres, outer] = [inner, centres, outer].map(|set| grown(&set.complement(), cells).complement());
        Designed { shape: Enclosure { inner, centres, outer }, ..self.clone() }
    }

    /// Number of cells of the element.
    pub fn element_cells(&self) -> u64 {
        self.element.cells()
    }

    /// The shape that is printed where at least the share λ of the element lies in the part.
    ///
    /// # Errors
    /// [`Error::Operand`] unless 0 ≤ λ ≤ 1.
    ///
    /// # Cost
    /// Six passes over bit rows.
    ///
    /// # Source
    /// A. Nelaturi, V. Shapiro, Representation and analysis of additively manufactured parts, 2015; the λ-family: S. Nelaturi
    /// and others, Automatic support removal and under- and over-deposition, 2019.
    pub fn printed(self, lambda: f64) -> Result<AsPrinted> {
        if !(0.0..=1.0).contains(&lambda) {
            return Err(Error::Operand {
                operation: "as printed",
                problem: format!("an overlap ratio of {lambda}"),
                remedy: "give a ratio from 0 to 1".into(),
            });
        }
        let [lower, centres, upper] = self.laid(self.least(lambda))?;
        Ok(AsPrinted { designed: self, lambda, spread: None, lower, centres, upper })
    }

    /// The shape that is printed along a compensated outline: Ω_Λ ∪ (Ω ∩ Ω_λ), with the least Λ ≥ λ at which no upright face across
    /// x spreads by more than `spread`; for a disc that is any upright face.
    ///
    /// What the element holds the share λ of is printed as drawn: a slicer moves the outline inwards by half a bead, or lays a narrower
    /// one where there is room for no more. Beyond the outline material spreads: upright slots narrower than twice the spread close.
    /// How far a face with another normal moves tells [`Bead::depth_of`]. What is left of a spread beyond half the element, Ω_Λ grows by in
    /// every direction. Union, growth, intersection and both members are increasing, so the three sides stay nested as those of [`Designed::printed`]. Lengths
    /// are rounded down to whole cells.
    ///
    /// # Errors
    /// As [`Designed::printed`].
    ///
    /// # Cost
    /// Twice that of [`Designed::printed`], and that of a growth by a ball; where faces spread by half the element or more, once.
    ///
    /// # Source
    /// S. Nelaturi, W. Kim, T. Kurtoglu, Manufacturability feedback and model correction for additive manufacturing, 2015: the opening,
    /// and what the medial axis of the rest can hold.
    pub fn compensated(self, lambda: f64, spread: Length) -> Result<AsPrinted> {
        let out = Spread::of(spread, &self.cells);
        let as_drawn = self.least(lambda);
        let least = self.element.cells_before(self.cells.wide - out.by_element).max(as_drawn);
        let mut made = self.printed(lambda)?;
        // A face that spreads by half the element is where as much of it as of a sheet is laid.
        let [lower, centres, upper] = if least == as_drawn {
            [&made.lower, &made.centres, &made.upper].map(Indicator::clone)
        } else {
            made.designed.laid(least)?
        };
        // A point of the grown set lies less than a cell from one of a cell grown by as many.
        let reach = [0, 0, usize::from(out.beyond > 0)];
        let mut grown = Vec::with_capacity(3);
        for (laid, reach) in [lower, centres, upper].into_iter().zip(reach) {
            grown.push(out.grown(laid, &made.designed.cells, reach)?);
        }
        let shape = &made.designed.shape;
        let sides = [(&shape.inner, &made.lower), (&shape.centres, &made.centres), (&shape.outer, &made.upper)];
        let mut kept = Vec::with_capacity(3);
        for ((drawn, held), grown) in sides.into_iter().zip(&grown) {
            kept.push(drawn.intersection(held)?.union(grown)?);
        }
        if let Ok([lower, centres, upper]) = <[Indicator; 3]>::try_from(kept) {
            (made.lower, made.centres, made.upper, made.spread) = (lower, centres, upper, Some(spread));
        }
        Ok(made)
    }

    /// What is deposited where so many cells of the element lie in the part, from three sides.
    fn laid(&self, least: u64) -> Result<[Indicator; 3]> {
        let side = |set: &Indicator, reach| {
            Ok::<_, Error>(self.element.deposited(&self.element.placements(set, least)?, reach))
        };
        Ok([side(&self.shape.inner, 0)?, side(&self.shape.centres, 0)?, side(&self.shape.outer, 1)?])
    }

    /// Cells of the element that must lie in the part: at least one, and ⌈λ·n⌉.
    fn least(&self, lambda: f64) -> u64 {
        let wanted = lambda * self.element.cells() as f64;
        ((wanted - 1e-9).ceil() as u64).max(1)
    }
}

impl AsPrinted {
    /// The cells that the element covers wherever it holds at least the share λ of the samples: within them the part is printed as drawn.
    ///
    /// # Errors
    /// None for elements that could be laid.
    ///
    /// # Cost
    /// Two passes over bit rows.
    pub fn held(&self) -> Result<Indicator> {
        let designed = &self.designed;
        let placed = designed.element.placements(&designed.shape.centres, designed.least(self.lambda))?;
        Ok(designed.element.deposited(&placed, 0))
    }

    /// Volume of the part that is not printed: estimate, and the two numbers that it lies between.
    pub fn under(&self) -> Result<[Volume; 3]> {
        let shape = &self.designed.shape;
        self.volumes([(&shape.centres, &self.centres), (&shape.inner, &self.upper), (&shape.outer, &self.lower)])
    }

    /// Volume that is printed outside the part: estimate, and the two numbers that it lies between.
    pub fn over(&self) -> Result<[Volume; 3]> {
        let shape = &self.designed.shape;
        self.volumes([(&self.centres, &shape.centres), (&self.lower, &shape.outer), (&self.upper, &shape.inner)])
    }

    /// Material that is not printed: for certain, by the samples, and perhaps, a skin of cells on every face among it; each holds the one
    /// before.
    ///
    /// # Errors
    /// None for shapes that exist.
    pub fn lost(&self) -> Result<[Indicator; 3]> {
        let Enclosure { inner, centres, outer } = &self.designed.shape;
        Ok([inner.difference(&self.upper)?, centres.difference(&self.centres)?, outer.difference(&self.lower)?])
    }

    /// Cells in which nothing is printed: for certain, by the samples, and perhaps, at least in part. The material in the first is lost,
    /// and what is lost lies in the last; each holds the one before.
    ///
    /// # Errors
    /// None for shapes that exist.
    pub fn lost_within(&self) -> Result<[Indicator; 3]> {
        let outer = &self.designed.shape.outer;
        Ok([outer.difference(&self.upper)?, outer.difference(&self.centres)?, outer.difference(&self.lower)?])
    }

    /// Void that is printed and from which no cell that stays open is as near as half the element, or 1.73 times a spread beyond that: slots
    /// and holes that close. The coat on a face or in a corner that stays open is not among it. For certain, by the samples, and perhaps; each holds the one before.
    ///
    /// # Errors
    /// None for shapes that exist.
    pub fn filled(&self) -> Result<[Indicator; 3]> {
        let Enclosure { inner, centres, outer } = &self.designed.shape;
        Ok([
            self.closed(&self.lower)?.difference(outer)?,
            self.closed(&self.centres)?.difference(centres)?,
            self.closed(&self.upper)?.difference(inner)?,
        ])
    }

    /// Cells whose void is filled: for certain, by the samples, and perhaps, at least in part. What is filled lies in the last; each holds
    /// the one before.
    ///
    /// # Errors
    /// None for shapes that exist.
    pub fn filled_within(&self) -> Result<[Indicator; 3]> {
        let inner = &self.designed.shape.inner;
        let [lower, centres, upper] = [&self.lower, &self.centres, &self.upper].map(|printed| self.closed(printed));
        Ok([lower?.difference(inner)?, centres?.difference(inner)?, upper?.difference(inner)?])
    }

    /// Of what is printed, what is farther from all that is not than the coat on a face is thick.
    fn closed(&self, printed: &Indicator) -> Result<Indicator> {
        let cells = &self.designed.cells;
        let reach = Spread::of(self.spread.unwrap_or_default(), cells).coat(cells);
        printed.difference(&grown(&printed.complement(), reach))
    }

    /// Volume as printed: the estimate.
    pub fn volume(&self) -> Volume {
        self.designed.cells.cell_volume() * self.centres.count() as f64
    }

    /// Volumes that the one as printed lies between, whatever way the lattice lies.
    pub fn bounds(&self) -> [Volume; 2] {
        [&self.lower, &self.upper].map(|set| self.designed.cells.cell_volume() * set.count() as f64)
    }

    /// The surface as printed in the frame of the part, on blocks of cells so large that at most `most` cover it.
    ///
    /// # Errors
    /// As [`superlevel_surface`].
    pub fn surface(&self, most: usize) -> Result<TriangleMesh> {
        let grid = self.centres.grid();
        let blocks = |side: usize| grid.dims().map(|n| n.div_ceil(side));
        let side = (1..).find(|&side| blocks(side).iter().product::<usize>() <= most.max(1)).unwrap_or(1);
        let coarse = Length::mm(grid.h() * side as f64);
        let middle = 0.5 * grid.h() * (side as f64 - 1.0);
        let target = Grid::new(grid.origin().map(|x| x + middle), coarse, blocks(side))?;
        let share = 1.0 / (side * side * side) as f32;
        let values: Vec<f32> = (0..target.samples())
            .into_par_iter()
            .map(|at| {
                let [i, j, k] = target.index(at).map(|n| n * side);
                let [_, ny, nz] = grid.dims();
                let rows = (k..(k + side).min(nz)).flat_map(|z| (j..(j + side).min(ny)).map(move |y| (y, z)));
                let cells: u32 = rows.map(|(y, z)| ones(self.centres.row(y, z), i..i + side)).sum();
                cells as f32 * share
            })
            .collect();
        let mesh = superlevel_surface(&Field::from_values(target, values, 0.0)?, 0.5)?;
        Ok(self.designed.cells.to_part(mesh))
    }

    fn volumes(&self, pairs: [(&Indicator, &Indicator); 3]) -> Result<[Volume; 3]> {
        let cell = self.designed.cells.cell_volume();
        let mut out = [cell; 3];
        for (volume, (from, without)) in out.iter_mut().zip(pairs) {
            *volume = cell * count_difference(from, without) as f64;
        }
        Ok(out)
    }
}

/// A set grown by whole samples along every axis: A ⊕ [−reach, reach]³.
pub(crate) fn grown(set: &Indicator, reach: usize) -> Indicator {
    match Prism::new(1, 1, |_, _| true) {
        Ok(cell) => cell.deposited(set, reach),
        Err(_) => set.clone(),
    }
}

/// What of a set lies in cubes of so many samples along each side that fit into it.
pub(crate) fn opened(set: &Indicator, side: usize) -> Result<Indicator> {
    let cube = Prism::new(side, side, |_, _| true)?;
    Ok(cube.deposited(&cube.placements(set, cube.cells())?, 0))
}

/// |A ∖ B| for sets on one grid.
fn count_difference(a: &Indicator, b: &Indicator) -> u64 {
    a.words().iter().zip(b.words()).map(|(a, b)| u64::from((a & !b).count_ones())).sum()
}

/// How many bits of a row are set in a range, which may end behind the row.
fn ones(row: &[u64], range: std::ops::Range<usize>) -> u32 {
    let words = row.iter().enumerate().take(range.end.div_ceil(64)).skip(range.start / 64);
    let within = |(w, bits): (usize, &u64)| {
        let from = range.start.saturating_sub(64 * w);
        let to = (range.end - 64 * w).min(64);
        (bits << (64 - to) >> (64 - to) >> from).count_ones()
    };
    words.map(within).sum()
}

#[cfg(test)]
mod tests {
    use super::super::least_element::Footprint;
    use super::*;
    use crate::geometry::Primitive;
    use crate::geometry::vector::Vec3;

    fn bead(width: f64, height: f64, footprint: Footprint) -> Bead {
        Bead { footprint, width: Length::mm(width), height: Length::mm(height) }
    }

    fn printed(mesh: &TriangleMesh, bead: Bead, lambda: f64, most: u128) -> AsPrinted {
        let cells = Cells::covering(&bead, mesh.bounds().unwrap(), most).unwrap().unwrap();
        Designed::cast(mesh, InsideRule::Crossings, bead, cells).unwrap().printed(lambda).unwrap()
    }

    fn within(truth: f64, [value, low, high]: [Volume; 3]) -> f64 {
        let [value, low, high] = [value, low, high].map(|v| v.as_mm3());
        assert!(low <= value && value <= high, "{low} {value} {high}");
        assert!(low <= truth && truth <= high, "{truth} not in {low} … {high}");
        value
    }

    fn block(size: Vec3, shift: Vec3) -> TriangleMesh {
        let text = format!("box:{}x{}x{}mm", size[0], size[1], size[2]);
        let mesh = Primitive::parse(&text).unwrap().mesh(Length::mm(1.0));
        mesh.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], shift)
    }

    #[test]
    fn a_box_loses_nothing_to_a_square_that_fits_and_everything_to_one_that_does_not() {
        for shift in [[0.0; 3], [0.013, 0.107, 0.031], [0.2, 0.05, 0.077]] {
            let thick = block([6.0, 3.0, 2.0], shift);
            let opened = printed(&thick, bead(0.4, 0.2, Footprint::Square), 1.0, 1 << 24);
            within(0.0, opened.under().unwrap());
            within(0.0, opened.over().unwrap());
            // Three of the six cells of the element, and at most one more on either side.
            let thin = block([6.0, 0.2, 2.0], shift);
            let gone = printed(&thin, bead(0.4, 0.2, Footprint::Square), 1.0, 1 << 24);
            assert!(gone.upper.is_empty(), "a wall of 0.2 mm holds no square of 0.4 mm");
            within(6.0 * 0.2 * 2.0, gone.under().unwrap());
        }
    }

    /// A half space at λ = ½ grows by half the element: a box by half a width on its sides and half a height above and
    /// below, but for its edges, where the placements end in the curve (½ + u)(½ + v) = ½.
    #[test]
    fn a_wall_grows_by_half_the_element_at_one_half() {
        for (shift, thick) in [([0.0; 3], 2.0), ([0.03, 0.01, 0.07], 1.9), ([0.111, 0.222, 0.05], 0.9)] {
            let wall = block([8.0, thick, 4.0], shift);
            let made = printed(&wall, bead(0.4, 0.2, Footprint::Square), 0.5, 1 << 25);
            let lost = within(0.0, made.under().unwrap());
            assert!(lost == 0.0);
            // Full coat less what the edges and corners miss: at an edge the deposit ends 0.293 of a side short of the
            // coat's own edge at most, over a side's length.
            let coat = (8.0 + 0.4) * (thick + 0.4) * (4.0 + 0.2) - 8.0 * thick * 4.0;
            let edges = 4.0 * (8.0 + thick) * 0.4 * 0.2 * 0.5 + 4.0 * 4.0 * 0.4 * 0.4 * 0.5;
            let over = made.over().unwrap().map(|v| v.as_mm3());
            assert!(over[1] <= coat && over[2] >= coat - edges, "{over:?} against {coat}");
            assert!(over[0] <= coat * 1.15 && over[0] >= coat - edges - 0.15 * coat, "{over:?} against {coat}");
        }
    }

    #[test]
    fn the_family_is_nested_and_the_first_of_it_is_the_opening() {
        let mesh = Primitive::parse("cone:r2r0.2h3mm").unwrap().mesh(Length::mm(0.01));
        let turned = mesh.transformed([[0.8, 0.6, 0.0], [-0.48, 0.64, 0.6], [0.36, -0.48, 0.8]], [0.0; 3]);
        let bead = bead(0.4, 0.3, Footprint::Disc);
        let all: Vec<AsPrinted> =
            [0.0, 0.25, 0.5, 0.75, 1.0].iter().map(|&l| printed(&turned, bead, l, 1 << 22)).collect();
        for pair in all.windows(2) {
            assert!(
                pair[1].lower.is_subset(&pair[0].lower).unwrap() && pair[1].upper.is_subset(&pair[0].upper).unwrap()
            );
        }
        for made in &all {
            assert!(made.lower.is_subset(&made.centres).unwrap() && made.centres.is_subset(&made.upper).unwrap());
        }
        let opened = &all[4];
        assert!(opened.lower.is_subset(&opened.designed.shape.inner).unwrap());
        assert!(opened.centres.is_subset(&opened.designed.shape.centres).unwrap());
    }

    #[test]
    fn a_slot_narrower_than_the_element_is_filled_and_a_wider_one_is_not() {
        for shift in [[0.0; 3], [0.017, 0.05, 0.081], [0.1, 0.033, 0.02]] {
            for (gap, fills) in [(0.2, true), (0.8, false)] {
                let left = block([3.0, 2.0, 2.0], [shift[0] - 1.5 - 0.5 * gap, shift[1], shift[2]]);
                let right = block([3.0, 2.0, 2.0], [shift[0] + 1.5 + 0.5 * gap, shift[1], shift[2]]);
                let made = printed(&left.joined(&right), bead(0.4, 0.2, Footprint::Square), 0.5, 1 << 23);
                let [filled, ..] = made.filled().unwrap();
                assert_eq!(!filled.is_empty(), fills, "{gap} at {shift:?}");
                if fills {
                    let cells = &made.designed.cells;
                    let (_, counts) = filled.support_box().unwrap();
                    assert!(counts[0] as f64 * cells.cell_mm()[0] < 0.2 + 1e-9, "only the slot is filled");
                    // Wider by four cells of 1/15 mm on either side: 0.73 mm.
                    let wider = made.designed.thinned(4).printed(0.5).unwrap();
                    assert!(wider.filled().unwrap()[0].is_empty());
                }
                let shown = made.surface(1 << 16).unwrap();
                let growth = shown.signed_volume() / made.volume().as_mm3();
                // Blocks of a few cells cut the edges.
                assert!((growth - 1.0).abs() < 0.03, "{growth}");
            }
        }
    }

    #[test]
    fn a_compensated_outline_keeps_faces_and_closes_what_is_narrower_than_its_spread() {
        let made = |mesh: &TriangleMesh| {
            let bead = bead(0.4, 0.2, Footprint::Disc);
            let cells = Cells::covering(&bead, mesh.bounds().unwrap(), 1 << 23).unwrap().unwrap();
            let designed = Designed::cast(mesh, InsideRule::Crossings, bead, cells).unwrap();
            designed.compensated(0.5, Length::mm(0.1)).unwrap()
        };
        for shift in [[0.0; 3], [0.017, 0.05, 0.081], [0.1, 0.033, 0.02]] {
            // One cell of 1/15 mm is all that goes into a spread of 0.1 mm: what lies in two cells closes for certain, a slot of 0.3 mm does not.
            for (gap, fills) in [(0.05, true), (0.3, false), (0.4, false)] {
                let left = block([3.0, 2.0, 2.0], [shift[0] - 1.5 - 0.5 * gap, shift[1], shift[2]]);
                let right = block([3.0, 2.0, 2.0], [shift[0] + 1.5 + 0.5 * gap, shift[1], shift[2]]);
                let made = made(&left.joined(&right));
                // Along a line across the slot; between two centres of cells it has none of its own to be listed as filled.
                let (cells, first) = (&made.designed.cells, made.designed.cells.position([0; 3]));
                let [j, k] = [1, 2].map(|a| ((shift[a] - first[a]) / cells.cell_mm()[a]).round() as usize);
                let near = |i: &usize| (cells.position([*i, j, k])[0] - shift[0]).abs() < 1.0;
                let closed = (0..cells.grid.dims()[0]).filter(near).all(|i| made.lower.contains([i, j, k]));
                assert_eq!(closed, fills, "{gap} at {shift:?}");
                assert!(fills || made.filled().unwrap()[0].is_empty(), "{gap} at {shift:?}");
            }
            // A wall thinner than a bead is printed as drawn, one below half of it is not.
            for (thick, volume) in [(0.8, 0.8), (0.3, 0.3), (0.1, 0.0)] {
                let wall = made(&block([4.0, thick, 2.0], shift));
                let printed =
                    [&wall.lower, &wall.upper].map(|s| (wall.designed.cells.cell_volume() * s.count() as f64).as_mm3());
                let truth = 8.0 * volume;
                // A coat of one cell of 1/15 mm on every upright face, and none above or below.
                let coated = (4.0 + 2.0 / 15.0) * (thick + 2.0 / 15.0) * 2.0;
                assert!(printed[0] <= coated + 1e-9 && printed[1] >= truth - 1e-9, "{thick}: {printed:?}");
                assert!(thick != 0.1 || wall.centres.is_empty(), "{thick} at {shift:?}");
                assert!(wall.lower.is_subset(&wall.centres).unwrap() && wall.centres.is_subset(&wall.upper).unwrap());
            }
        }
    }

    #[test]
    fn widths_are_those_of_a_disc_and_a_square() {
        let disc = bead(0.4, 0.2, Footprint::Disc);
        let square = bead(0.4, 0.2, Footprint::Square);
        let close = |a: Length, b: f64| assert!((a.as_mm() - b).abs() < 1e-12, "{a} {b}");
        close(disc.width_along([0.6, 0.8, 0.0]), 0.4);
        close(square.width_along([0.6, 0.8, 0.0]), 0.56);
        close(disc.width_along([0.0, 0.0, -1.0]), 0.2);
        // The largest width is the diagonal, and no direction exceeds it.
        for bead in [disc, square] {
            let most = (0..400).map(|i| (i as f64 * 0.7).sin_cos()).flat_map(|(s, c)| {
                (0..40)
                    .map(move |j| (j as f64 * 0.04).sin_cos())
                    .map(move |(t, u)| bead.width_along([s * u, c * u, t]).as_mm())
            });
            let most = most.fold(0.0, f64::max);
            assert!(most <= bead.widest().as_mm() + 1e-12 && most > 0.99 * bead.widest().as_mm());
        }
    }

    #[test]
    fn nothing_is_cast_that_the_lattice_cannot_resolve() {
        let bounds = ([0.0; 3], [100.0; 3]);
        let fine = bead(0.05, 0.05, Footprint::Square);
        assert!(Cells::covering(&fine, bounds, 1 << 27).unwrap().is_none());
        assert!(Cells::covering(&bead(0.0, 0.2, Footprint::Disc), bounds, 1 << 27).is_err());
        let coarse = Cells::covering(&bead(0.4, 0.2, Footprint::Disc), bounds, 1 << 28).unwrap().unwrap();
        assert_eq!((coarse.wide, coarse.high), (2, 2));
        assert!((coarse.cell_mm()[2] - 0.1).abs() < 1e-12);
    }

    #[test]
    fn bits_of_a_range_are_those_counted_one_by_one() {
        let mut random = crate::random::Lcg(8);
        let row: Vec<u64> = (0..3).map(|_| random.below(u64::MAX)).collect();
        let set = |i: usize| row.get(i / 64).is_some_and(|w| w >> (i % 64) & 1 == 1);
        for from in 0..192 {
            for side in [1, 2, 3, 5, 64, 65, 130] {
                let plain = (from..from + side).filter(|&i| set(i)).count();
                assert_eq!(ones(&row, from..from + side) as usize, plain, "{from} {side}");
            }
        }
    }
}
