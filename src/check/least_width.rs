//! The widths from which on sheets are printed and slots stay open, and what is below them.

use super::as_printed::LAMBDA;
use super::contract::Context;
use super::detail::{Between, Detail, Sought, Thin, raised_width};
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, dot};
use crate::medial::Side;
use crate::morphology::{Bead, Cells, Designed};
use crate::part::{Part, bead_of, spread_of};
use crate::process::Process;
use crate::units::Length;

/// Cosine of the angle up to which a facet faces along a direction.
const FACING: f64 = 0.5;

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
    pub evaluations: u64,
}

impl<'a> LeastWidth<'a> {
    pub fn new(part: &'a Part, process: &'a Process, context: &'a Context, side: Side) -> Self {
        LeastWidth { part, process, context, side, bead: bead_of(process), spread: spread_of(process) }
    }

    /// The thickness from which on a flat sheet with such a normal is printed, or a flat slot stays open.
    ///
    /// The middle of the element holds λ of it within as much; a slot closes that two faces cover, each moved as far as the element
    /// reaches beyond it when the share of it that is laid lies in the part, and by what is left of the spread beyond half the element. Slanting faces move up to a quarter farther than upright
    /// ones, beyond the gap that closes in the process: such slots are not held to close.
    pub fn along(&self, normal: Vec3) -> f64 {
        match self.side {
            Side::Material => {
                let cut = self.bead.depth_of(normal, 0.5 * (1.0 - LAMBDA));
                self.bead.width_along(normal).as_mm() - 2.0 * cut.as_mm()
            }
            Side::Void => {
                let left = self.bead.beyond_half(self.spread);
                let share = self.bead.share_beyond([1.0, 0.0, 0.0], self.spread - left);
                let moved = self.bead.depth_of(normal, share.min(1.0 - LAMBDA)) + left;
                2.0 * moved.as_mm().min(self.spread.as_mm())
            }
        }
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
        Narrow { places, finest: found.finest, evaluations: found.evaluations }
    }

    /// The cells of a lattice of the whole part that lie in such places and an element's width from all else on their side of the surface:
    /// wherever the element stands that would print or keep them open, it holds nothing but the place.
    ///
    /// # Errors
    /// None for shapes that exist.
    ///
    /// # Cost
    /// Two nearest facets for each cell about the places.
    pub fn cells(&self, places: &[Detail], designed: &Designed) -> Result<Indicator> {
        let solid = &designed.shape.centres;
        let own = if self.side == Side::Material { solid.clone() } else { solid.complement() };
        let mut narrow = Indicator::empty(*solid.grid());
        for place in places {
            self.mark(place, &designed.cells, &own, &mut narrow);
        }
        designed.out_of_reach(&narrow, &own.difference(&narrow)?)
    }

    /// Marks the cells of one place, across which its own surfaces are nearer than they have to be: from its patches on as far as they are.
    fn mark(&self, place: &Detail, cells: &Cells, own: &Indicator, narrow: &mut Indicator) {
        let dims = cells.grid.dims();
        for patch in &place.patches {
            let least = self.along(patch.across) - self.part.tie();
            let mut next: Vec<[usize; 3]> = cells.indices_in(cells.touched(patch.extent)).collect();
            while let Some(index) = next.pop() {
                let known = !own.contains(index) || narrow.contains(index);
                if known || !self.is_across(cells.position(index), patch.across, least) {
                    continue;
                }
                narrow.set(index, true);
                for axis in 0..3 {
                    let at = index[axis];
                    let beside = [at.checked_sub(1), Some(at + 1).filter(|&to| to < dims[axis])];
                    next.extend(beside.into_iter().flatten().map(|to| {
                        let mut beside = index;
                        beside[axis] = to;
                        beside
                    }));
                }
            }
        }
    }

    /// Whether the surfaces before and behind a point are nearer to each other than a width.
    fn is_across(&self, at: Vec3, direction: Vec3, width: f64) -> bool {
        let distance = self.part.distance();
        let to = |way: f64| {
            let faces = |facet: u32, _| way * dot(distance.normal(facet), direction) > FACING;
            distance.nearest_where(at, width, faces).map(|near| near.distance)
        };
        to(1.0).zip(to(-1.0)).is_some_and(|(before, behind)| before + behind < width)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::extruded;
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
            let cells = least.cells(&places, &made.designed).unwrap();
            assert_eq!(cells.count() > 5000, lost, "{thick} × {long}");
        }
    }
}
