//! A part on a lattice as designed and as printed, both true to the widths that the mesh has wherever the lattice stands.

use super::contract::Context;
use super::detail::{Between, Detail};
use super::least_width::LeastWidth;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::closed_characteristic;
use crate::geometry::health::NO_LABEL;
use crate::geometry::vector::Vec3;
use crate::medial::Side;
use crate::morphology::{AsPrinted, grown, opened};
use crate::part::Part;
use crate::process::Process;
use crate::topology::{Adjacency, Betti, betti, components};

/// The part as designed and as printed on a lattice, whose sheets that are too thin are lost and whose slots that are too narrow are filled
/// wherever the lattice stands.
#[derive(Clone)]
pub(super) struct Laid<'a> {
    part: &'a Part,
    process: &'a Process,
    context: &'a Context,
    pub on_lattice: &'a AsPrinted,
    pub designed: Indicator,
    /// What the lattice sees of the design.
    pub seen: Betti,
    /// What the mesh has itself, where it tells.
    pub has: Option<Betti>,
    pub printed: Indicator,
    /// What is too narrow of material and of void.
    narrow: [Vec<Lacking>; 2],
    departs: [Option<Indicator>; 2],
}

/// A sheet or a slot, and how much it lacks of what would be printed as drawn, millimetres.
#[derive(Clone)]
struct Lacking {
    extent: (Vec3, Vec3),
    missing: f64,
}

impl<'a> Laid<'a> {
    /// # Errors
    /// None for shapes that exist.
    pub fn new(part: &'a Part, process: &'a Process, context: &'a Context, on_lattice: &'a AsPrinted) -> Result<Self> {
        let has = of_mesh(part);
        let (designed, seen) = designed(part, on_lattice, has)?;
        let mut printed = on_lattice.centres.clone();
        if designed == on_lattice.designed.shape.outer {
            // What the samples leave holes in is printed whole.
            printed = printed.union(&designed.intersection(&on_lattice.held()?)?)?;
        }
        let (narrow, departs) = ([Vec::new(), Vec::new()], [None, None]);
        Ok(Laid { part, process, context, on_lattice, designed, seen, has, printed, narrow, departs })
    }

    /// The print without the sheets that are too thin, or with the slots filled that are too narrow, and how many there are; `None` without
    /// any.
    ///
    /// # Errors
    /// None for shapes that exist.
    ///
    /// # Cost
    /// A search for all of them, and two nearest facets for each cell in them.
    pub fn departing(&self, side: Side) -> Result<Option<(Self, u64)>> {
        let least = self.least(side);
        let places = least.narrow(Between::SidesOfABody).places;
        if places.is_empty() {
            return Ok(None);
        }
        let mut laid = self.clone();
        laid.departs[side as usize] = Some(least.departing(&places, &self.on_lattice.designed, &self.designed)?);
        let lacks = |d: &Detail| Lacking {
            extent: d.extent,
            missing: least.along(d.thinnest.direction()) - d.thinnest.diameter,
        };
        laid.narrow[side as usize] = places.iter().map(lacks).collect();
        laid.depart()?;
        Ok(Some((laid, places.len() as u64)))
    }

    fn least(&self, side: Side) -> LeastWidth<'a> {
        LeastWidth::new(self.part, self.process, self.context, side)
    }

    /// Takes what is too thin out of what is printed, with the coat on it, and fills what is too narrow.
    fn depart(&mut self) -> Result<()> {
        let [lost, filled] = &self.departs;
        if let Some(lost) = lost {
            let left = self.printed.intersection(&self.designed)?.difference(lost)?;
            let coat = self.printed.difference(&self.designed)?;
            let thick = self.coat_cells();
            let bare = coat.intersection(&grown(lost, thick + 1))?.difference(&grown(&left, thick))?;
            let threads = self.threads(&left, &grown(lost, thick + 1), &left)?;
            self.printed = left.difference(&threads)?.union(&coat.difference(&bare)?)?;
        }
        if let Some(filled) = filled {
            self.printed = self.printed.union(filled)?;
        }
        self.printed = self.hanging(&self.printed)?;
        Ok(())
    }

    /// How many cells thick the coat on a face is, where the process spreads.
    pub fn coat_cells(&self) -> usize {
        let cells = &self.on_lattice.designed.cells;
        self.on_lattice.spread.map_or(0, |spread| cells.whole(spread)).max(1)
    }

    /// Threads that lattice positions have left along a rim: what of a set within it belongs to no block of 2 × 2 × 2 cells of a whole.
    fn threads(&self, set: &Indicator, rim: &Indicator, whole: &Indicator) -> Result<Indicator> {
        set.intersection(rim)?.difference(&opened(whole, 2)?)
    }

    /// A set without its pieces that hold nothing of the design.
    ///
    /// # Errors
    /// None for sets on the lattice.
    pub fn hanging(&self, set: &Indicator) -> Result<Indicator> {
        let pieces = components(set, Adjacency::Face);
        let mut hangs = vec![false; pieces.count()];
        let held = components(&set.intersection(&self.designed)?, Adjacency::Face);
        for piece in held.first_samples().into_iter().filter_map(|index| pieces.of(index)) {
            hangs.get_mut(piece as usize).into_iter().for_each(|hangs| *hangs = true);
        }
        Ok(pieces.select(|piece| hangs.get(piece as usize) == Some(&true)))
    }

    /// The print with what is wide enough on one side of the surface, by less than the lattice can tell, as designed; `None` if it is the same.
    ///
    /// # Errors
    /// None for shapes that exist.
    ///
    /// # Cost
    /// A search for all that is so wide, and two nearest facets for each cell in it.
    pub fn keeping(&self, side: Side) -> Result<Option<Self>> {
        let stays = self.least(side).staying(&self.on_lattice.designed, &self.designed)?;
        let kept = match side {
            Side::Material => self.printed.union(&stays)?,
            Side::Void => {
                let open = self.printed.difference(&stays)?;
                // The coats of both lips of its mouth may meet before it.
                let coat = open.difference(&self.designed)?;
                open.difference(&self.threads(&coat, &grown(&stays, self.coat_cells() + 1), &open)?)?
            }
        };
        if kept == self.printed {
            return Ok(None);
        }
        let mut kept = Laid { printed: kept, ..self.clone() };
        kept.depart()?;
        Ok(Some(kept))
    }

    /// The same with more printed.
    ///
    /// # Errors
    /// None for sets on the lattice.
    pub fn with(&self, more: &Indicator) -> Result<Self> {
        Ok(Laid { printed: self.printed.union(more)?, ..self.clone() })
    }

    /// What lies within an element of some places and in no void block of so many cells along each side, when a set is printed: too narrow for the
    /// lattice to tell it from what the element fills. A round hole that is wide enough is none.
    ///
    /// # Errors
    /// None for sets on the lattice.
    ///
    /// # Cost
    /// A few walks over the words of the lattice, and a search for round holes.
    pub fn pores(&self, printed: &Indicator, places: &[[[usize; 3]; 2]], side: usize) -> Result<Indicator> {
        let (grid, reach) = (printed.grid(), self.on_lattice.designed.cells.wide);
        let mut near = Indicator::empty(*grid);
        for [lo, hi] in places {
            let first = lo.map(|n| n.saturating_sub(reach));
            let dims = [0, 1, 2].map(|a| (hi[a] + reach + 1).min(grid.dims()[a]) - first[a]);
            near.unite_window(first, &Indicator::empty(*grid).window([0; 3], dims)?.complement());
        }
        // One block of outside all around, so that nothing is narrow at the border of the lattice.
        let about = side as isize;
        let void = printed.window([-about; 3], grid.dims().map(|n| n + 2 * side))?.complement();
        let narrow = void.difference(&opened(&void, side)?)?.placed([about; 3], *grid)?.intersection(&near)?;
        narrow.difference(&self.least(Side::Void).in_holes(&self.on_lattice.designed, &self.designed))
    }

    /// The most that sheets lack which are lost in a box, or slots which are filled; 0 if none is there.
    pub fn missing(&self, side: Side, extent: (Vec3, Vec3)) -> f64 {
        let meets = |n: &&Lacking| (0..3).all(|a| n.extent.0[a] <= extent.1[a] && extent.0[a] <= n.extent.1[a]);
        self.narrow[side as usize].iter().filter(meets).map(|n| n.missing).fold(0.0, f64::max)
    }

    /// Whether the lattice sees another part than the mesh describes.
    pub fn is_unlike(&self) -> bool {
        self.has.is_some_and(|has| has != self.seen)
    }
}

/// The design on the lattice, and what it has: the samples, or, where they have something else than the mesh, all cells that the part touches,
/// or those that it fills, if these have the same.
///
/// Samples leave holes in a sheet thinner than the diagonal of a cell, and threads across such a slot. The cells that a sheet touches are
/// joined by faces and leave none, however thin it is and however it stands, and nor do those that a slot touches.
fn designed(part: &Part, on_lattice: &AsPrinted, has: Option<Betti>) -> Result<(Indicator, Betti)> {
    let sampled = without_specks(part, on_lattice);
    let seen = betti(&sampled, Adjacency::Face)?;
    let Some(has) = has.filter(|has| *has != seen) else { return Ok((sampled, seen)) };
    let shape = &on_lattice.designed.shape;
    for whole in [&shape.outer, &shape.inner] {
        if betti(whole, Adjacency::Face)? == has {
            return Ok((whole.clone(), has));
        }
    }
    Ok((sampled, seen))
}

/// The part on the lattice without what thin edges leave of it: of more pieces than there are bodies, the smallest that
/// hold fewer cells than an element.
fn without_specks(part: &Part, printed: &AsPrinted) -> Indicator {
    let designed = &printed.designed.shape.centres;
    let pieces = components(designed, Adjacency::Face);
    let sizes = pieces.sizes();
    let mut order: Vec<u32> =
        (0..sizes.len() as u32).filter(|&p| sizes[p as usize] < printed.designed.element_cells()).collect();
    order.sort_by_key(|&p| (sizes[p as usize], p));
    order.truncate(sizes.len().saturating_sub(part.health().bodies.len()));
    if order.is_empty() {
        return designed.clone();
    }
    order.sort_unstable();
    pieces.select(|p| order.binary_search(&p).is_err())
}

/// What the mesh has itself, where it tells: a closed manifold whose shells do not touch.
fn of_mesh(part: &Part) -> Option<Betti> {
    let (mesh, health) = (part.mesh(), part.health());
    if !health.is_watertight() || !part.is_plain() {
        return None;
    }
    // The solid has half of the characteristic of its surface.
    let surface = closed_characteristic(mesh);
    let pieces = health.bodies.len() as i64;
    let voids: i64 = health.bodies.iter().map(|b| b.cavities.len() as i64).sum();
    let tunnels = pieces + voids - surface / 2;
    (surface % 2 == 0 && tunnels >= 0).then_some(Betti {
        pieces: pieces as u64,
        tunnels: tunnels as u64,
        voids: voids as u64,
    })
}

/// The bodies whose surfaces are nearest to some points.
pub(super) fn bodies_at(part: &Part, points: impl Iterator<Item = Vec3>) -> Vec<u32> {
    let body = |p: Vec3| {
        let near = part.distance().nearest(p, f64::INFINITY)?;
        let body = *part.health().facet_body.get(near.facet as usize)?;
        (body != NO_LABEL).then_some(body)
    };
    let mut bodies: Vec<u32> = points.filter_map(body).collect();
    bodies.sort_unstable();
    bodies.dedup();
    bodies
}
