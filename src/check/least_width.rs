//! The widths from which on sheets are printed and slots stay open, and what is below them.

use super::as_printed::LAMBDA;
use super::contract::Context;
use super::detail::{Between, Detail, Sought, Thin, raised_width};
use super::rods::up_to;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, add, dot, norm2, scale, sub};
use crate::medial::Side;
use crate::medial::rod::Rod;
use crate::morphology::{Bead, Cells, Designed, grown};
use crate::part::{Part, bead_of, spread_of};
use crate::process::Process;
use crate::units::Length;
use std::ops::Range;

/// Cosine of the angle up to which a facet faces along a direction.
const FACING: f64 = 0.5;
/// The corners of a triangular hole lie so many of its equal-area radii from its middle.
const BESIDE: f64 = 1.6;

/// What a process prints of sheets of a part, or keeps open of slots: the side of the surface tells which.
pub(super) struct LeastWidth<'a> {
    part: &'a Part,
    process: &'a Process,
    context: &'a Context,
    side: Side,
    bead: Bead,
    /// How far a face spreads.
    spread: Length,
}

/// Sheets or slots that are too narrow.
pub(super) struct Narrow {
    pub places: Vec<Detail>,
    /// Nothing narrower is missing but what is smaller than this.
    pub finest: f64,
}

impl<'a> LeastWidth<'a> {
    pub fn new(part: &'a Part, process: &'a Process, context: &'a Context, side: Side) -> Self {
        LeastWidth { part, process, context, side, bead: bead_of(process), spread: spread_of(process) }
    }

    /// The thickness from which on a flat sheet with such a normal is printed, or a flat slot stays open.
    ///
    /// The middle of the element holds λ of it within as much; a slot closes that two faces cover, each moved as far as the element
    /// reaches beyond it when the share of it that is laid lies in the part, and by what is left of the spread beyond half the element.
    /// Slanting faces move up to a quarter farther than upright ones, beyond the gap that closes in the process: such slots are not held
    /// to close.
    pub fn along(&self, normal: Vec3) -> f64 {
        match self.side {
            Side::Material => self.covered(normal),
            Side::Void => self.covered(normal).min(2.0 * self.spread.as_mm()),
        }
    }

    /// The thickness from which on the model prints such a sheet, or leaves such a slot open.
    fn covered(&self, normal: Vec3) -> f64 {
        match self.side {
            Side::Material => {
                let cut = self.bead.depth_of(normal, 0.5 * (1.0 - LAMBDA));
                self.bead.width_along(normal).as_mm() - 2.0 * cut.as_mm()
            }
            Side::Void => {
                let left = self.bead.beyond_half(self.spread);
                let share = self.bead.share_beyond([1.0, 0.0, 0.0], self.spread - left);
                2.0 * (self.bead.depth_of(normal, share.min(1.0 - LAMBDA)) + left).as_mm()
            }
        }
    }

    /// The thickness from which on every lattice of such cells prints such a sheet, or leaves such a slot open: samples make it up to a cell
    /// narrower, and an element of whole cells asks for up to one more.
    fn beyond_doubt(&self, normal: Vec3, cells: &Cells) -> f64 {
        self.covered(normal) + doubt(normal, cells)
    }

    /// Whether what is so thin along a direction is worth finding [`LeastWidth::along`] for: no less of the element lies in its middle
    /// than in any part of it as wide.
    fn may_be_narrow(&self, thin: &Thin) -> bool {
        let across = self.bead.width_along(thin.direction()).as_mm();
        let most = match self.side {
            Side::Material => LAMBDA * across,
            Side::Void => across + 2.0 * self.bead.beyond_half(self.spread).as_mm(),
        };
        thin.diameter < most
    }

    /// All sheets that are thinner, or slots that are narrower, largest first.
    pub fn narrow(&self, between: Between) -> Narrow {
        let width = match self.side {
            Side::Material => raised_width(self.process),
            Side::Void => 2.0 * self.spread.as_mm(),
        };
        let (part, process, context, side) = (self.part, self.process, self.context, self.side);
        let found = Sought { part, process, context, side, between, width }.search();
        let tie = part.tie();
        let mut places = found.places(|t| self.may_be_narrow(t) && t.diameter < self.along(t.direction()) - tie);
        // Samples on edges alone are the rim of another place: between them there is no volume.
        places.retain(|d| d.area > 0.0);
        Narrow { places, finest: found.finest }
    }

    /// The cells of a lattice of the whole part in such places that depart: of each as far as the element reaches from where it tells so. Of
    /// a sheet that is where the element holds no other material, wherever it stands over a cell; of a slot, where it stands straight over
    /// its faces without reaching their ends.
    ///
    /// `drawn` is the part on the lattice. What is too short for such a cell, beside what is wider, is left to the lattice.
    ///
    /// # Errors
    /// None for shapes that exist.
    ///
    /// # Cost
    /// Two nearest facets for each cell about the places.
    pub fn departing(&self, places: &[Detail], designed: &Designed, drawn: &Indicator) -> Result<Indicator> {
        let tie = self.part.tie();
        let narrow = self.cells(places, designed, drawn, |n| 0.0..self.along(n) - tie);
        let cells = &designed.cells;
        let element = cells.wide.max(cells.high);
        let reach = if self.side == Side::Material { element } else { element.div_ceil(2) + 1 };
        let sure = narrow.difference(&grown(&self.own(drawn).difference(&narrow)?, reach))?;
        narrow.intersection(&grown(&sure, reach))
    }

    /// The cells of a lattice of the whole part that stay as drawn though the lattice may show another thing: those of sheets or slots that
    /// are wide enough, but by no more than the cells tell, and broader than the element.
    ///
    /// # Errors
    /// None for shapes that exist.
    ///
    /// # Cost
    /// A search, and two nearest facets for each cell about what it finds.
    pub fn staying(&self, designed: &Designed, drawn: &Indicator) -> Result<Indicator> {
        let (part, process, context, side) = (self.part, self.process, self.context, self.side);
        let cells = &designed.cells;
        let tie = part.tie();
        let widths = |n: Vec3| self.along(n) - tie..self.beyond_doubt(n, cells);
        let half_widest = self.half_widest();
        let width = self.in_doubt(cells);
        // Gaps between bodies stay open as slots do.
        let between = if side == Side::Material { Between::SidesOfABody } else { Between::Surfaces };
        let found = Sought { part, process, context, side, between, width }.search();
        let mut places = found.sheets(|t| widths(t.direction()).contains(&t.diameter));
        places.retain(|d| d.area > 0.0 && d.spans[1] >= 2.0 * half_widest);
        let sheets = self.cells(&places, designed, drawn, widths);
        if side == Side::Material { Ok(sheets) } else { sheets.union(&self.in_holes(designed, drawn)) }
    }

    /// Half the width of the element, whichever way, with what spreads beyond it.
    fn half_widest(&self) -> f64 {
        0.5 * self.bead.widest().as_mm() + self.bead.beyond_half(self.spread).as_mm()
    }

    /// A width from which on every lattice of such cells shows what is there, however it stands.
    fn in_doubt(&self, cells: &Cells) -> f64 {
        2.0 * self.half_widest() + 2.0 * norm2(cells.cell_mm()).sqrt()
    }

    /// The void cells in holes that the lattice may close, and into which a ball as wide as the gap that closes fits all along.
    pub fn in_holes(&self, designed: &Designed, drawn: &Indicator) -> Indicator {
        let (cells, part) = (&designed.cells, self.part);
        let width = self.in_doubt(cells);
        let (half, own) = (scale(cells.cell_mm(), 0.5), self.own(drawn));
        let mut marked = Indicator::empty(*drawn.grid());
        let stays = |r: &&Rod| (2.0 * self.spread.as_mm() - part.tie()..width).contains(&r.narrowest.inscribed);
        for rod in part.rods(up_to(self.process, self.side, width)).rods.iter().filter(stays) {
            let about = (sub(rod.extent.0, half), add(rod.extent.1, half));
            let within = |index: &[usize; 3]| own.contains(*index) && rod.nears(cells.position(*index), BESIDE);
            cells.indices_in(about).filter(within).for_each(|index| marked.set(index, true));
        }
        marked
    }

    /// The cells on the side of the surface.
    fn own(&self, drawn: &Indicator) -> Indicator {
        if self.side == Side::Material { drawn.clone() } else { drawn.complement() }
    }

    /// The cells of some places across which the surfaces are as far from each other as is asked of a direction: from the patches of each on
    /// as far as they are.
    ///
    /// # Cost
    /// Two nearest facets for each cell about the places that another one does not tell of.
    pub fn cells(
        &self,
        places: &[Detail],
        designed: &Designed,
        drawn: &Indicator,
        widths: impl Fn(Vec3) -> Range<f64>,
    ) -> Indicator {
        let cells = &designed.cells;
        let (own, dims, step) = (self.own(drawn), cells.grid.dims(), cells.cell_mm());
        let mut marked = Indicator::empty(*drawn.grid());
        for patch in places.iter().flat_map(|place| &place.patches) {
            let wanted = widths(patch.across);
            // A cell, and how far from it, at least, the surfaces are still apart as is asked.
            let mut next: Vec<([usize; 3], f64)> =
                cells.indices_in(cells.touched(patch.extent)).map(|index| (index, 0.0)).collect();
            while let Some((index, known)) = next.pop() {
                if !own.contains(index) || marked.contains(index) {
                    continue;
                }
                let is_sure = known > self.part.tie() && self.is_between(index, designed);
                let tested = || self.slack_at(index, patch.across, designed, &wanted);
                let Some(slack) = (if is_sure { Some(known) } else { tested() }) else { continue };
                marked.set(index, true);
                for axis in 0..3 {
                    let at = index[axis];
                    let beside = [at.checked_sub(1), Some(at + 1).filter(|&to| to < dims[axis])];
                    next.extend(beside.into_iter().flatten().map(|to| {
                        let mut beside = index;
                        beside[axis] = to;
                        (beside, slack - step[axis])
                    }));
                }
            }
        }
        marked
    }

    /// Whether the sample of a cell lies on the side of the surface that is looked at.
    fn is_between(&self, index: [usize; 3], designed: &Designed) -> bool {
        designed.shape.centres.contains(index) == (self.side == Side::Material)
    }

    /// How far from a cell whose surfaces are as far apart as is wanted they still are for certain, millimetres: a step changes the distance to either by
    /// no more than itself.
    fn slack_at(&self, index: [usize; 3], direction: Vec3, designed: &Designed, wanted: &Range<f64>) -> Option<f64> {
        let width = self.width_at(index, direction, designed, wanted.end).filter(|w| wanted.contains(w))?;
        // No width is less than nothing.
        let above = if wanted.start > 0.0 { width - wanted.start } else { f64::INFINITY };
        let between = self.is_between(index, designed);
        Some(if between { 0.5 * above.min(wanted.end - width) } else { 0.0 })
    }

    /// How far the surfaces before and behind a cell are from each other, if that is less than a width.
    ///
    /// The sample of a cell that a thin place only touches lies beyond one of them.
    fn width_at(&self, index: [usize; 3], direction: Vec3, designed: &Designed, most: f64) -> Option<f64> {
        let (distance, at) = (self.part.distance(), designed.cells.position(index));
        let is_between = self.is_between(index, designed);
        let cell = designed.cells.cell_mm();
        let reach = if is_between { most } else { most + (0..3).map(|a| cell[a] * direction[a].abs()).sum::<f64>() };
        let to = |way: f64| {
            let faces = |facet: u32, _| way * dot(distance.normal(facet), direction) > FACING;
            distance.nearest_where(at, reach, faces).map(|near| near.distance)
        };
        let (before, behind) = to(1.0).zip(to(-1.0))?;
        let width = if is_between { before + behind } else { (before - behind).abs() };
        (width < most).then_some(width)
    }
}

/// Two cells across a direction, millimetres.
pub(super) fn doubt(normal: Vec3, cells: &Cells) -> f64 {
    let cell = cells.cell_mm();
    (0..3).map(|a| 2.0 * cell[a] * normal[a].abs()).sum()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::{cuboid, extruded};
    use crate::part::Up;

    const CONTEXT: Context = Context { refine: 64_000_000, spacing_mm: 0.1 };

    /// Two blocks joined by an upright web along x, so thick and so long, 4 mm high.
    pub fn webbed(thick: f64, long: f64) -> Part {
        let (a, b, end) = (4.0, 4.0 + thick, 4.0 + long);
        let outline = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, a],
            [end, a],
            [end, 0.0],
            [end + 4.0, 0.0],
            [end + 4.0, 8.0],
            [end, 8.0],
            [end, b],
            [4.0, b],
            [4.0, 8.0],
            [0.0, 8.0],
        ];
        let caps = [
            [0, 1, 2],
            [0, 2, 11],
            [2, 9, 11],
            [9, 10, 11],
            [2, 3, 8],
            [2, 8, 9],
            [3, 4, 5],
            [3, 5, 6],
            [3, 6, 8],
            [6, 7, 8],
        ];
        Part::new(extruded(&outline, &caps, 4.0), Up::PlusY, 1e-6, 1.0).unwrap()
    }

    #[test]
    fn upright_slots_close_below_the_gap_that_closes_however_narrow_the_element_is() {
        let part = webbed(0.15, 6.0);
        for name in ["fdm", "sls", "sla", "mjf", "lpbf", "binder-jet"] {
            let process = Process::named(name).unwrap();
            let least = LeastWidth::new(&part, &process, &CONTEXT, Side::Void);
            let (closes, along) = (process.element.closing_gap_mm, least.along([1.0, 0.0, 0.0]));
            assert!((along - closes).abs() < 1e-3 * closes, "{name}: {along} for {closes}");
        }
    }

    #[test]
    fn a_web_that_holds_too_little_of_the_element_is_lost_but_beside_what_holds_more() {
        let process = Process::named("fdm").unwrap();
        for (thick, long, lost) in [(0.15, 6.0, true), (0.35, 6.0, false), (0.15, 0.3, false)] {
            let part = webbed(thick, long);
            let least = LeastWidth::new(&part, &process, &CONTEXT, Side::Material);
            let places = least.narrow(Between::SidesOfABody).places;
            let made = part.as_printed(&process, LAMBDA).unwrap().unwrap();
            let cells = least.departing(&places, &made.designed, &made.designed.shape.centres).unwrap();
            assert_eq!(cells.count() > 5000, lost, "{thick} × {long}");
        }
    }

    #[test]
    fn the_cells_of_a_gap_are_those_whose_surfaces_are_so_far_apart_and_all_about_them_are_not() {
        let process = Process::named("sla").unwrap();
        let ((s, c), (t, u)) = (27f64.to_radians().sin_cos(), 19f64.to_radians().sin_cos());
        let bodies = cuboid([0.0; 3], [2.0; 3]).joined(&cuboid([2.1, 0.3, -0.4], [4.0, 2.5, 2.0]));
        let turned = bodies.transformed([[u, -t * c, t * s], [t, u * c, -u * s], [0.0, s, c]], [0.013, 0.007, 0.011]);
        let part = Part::new(turned, Up::PlusZ, 1e-6, 1.0).unwrap();
        let least = LeastWidth::new(&part, &process, &CONTEXT, Side::Void);
        let made = part.as_printed(&process, LAMBDA).unwrap().unwrap();
        let (designed, drawn) = (&made.designed, &made.designed.shape.centres);
        let places = least.narrow(Between::Surfaces).places;
        let across = places[0].patches[0].across;
        let off = |across_patch: Vec3| 1.0 - dot(across_patch, across).abs();
        assert!(places.iter().flat_map(|p| &p.patches).all(|p| off(p.across) < 1e-9), "one direction");
        for wanted in [0.0..0.2, 0.05..0.15, 0.0999..0.1001, 0.11..0.2] {
            let cells = least.cells(&places, designed, drawn, |_| wanted.clone());
            let fits = |index| least.width_at(index, across, designed, wanted.end).is_some_and(|w| wanted.contains(&w));
            // About its mouth a gap is wider.
            assert!(!cells.is_empty(), "{wanted:?}");
            assert!(cells.iter().map(|at| drawn.grid().index(at)).all(fits), "{wanted:?}");
            let about = grown(&cells, 1).difference(&cells).unwrap().difference(drawn).unwrap();
            let beside = |index: [usize; 3]| {
                let next = |a: usize, by: isize| {
                    let mut to = index;
                    to[a] = to[a].saturating_add_signed(by);
                    cells.contains(to)
                };
                (0..3).any(|a| next(a, 1) || next(a, -1))
            };
            let mut left = about.iter().map(|at| drawn.grid().index(at)).filter(|&index| beside(index));
            assert!(!left.any(fits), "{wanted:?}");
        }
    }
}
