//! Bodies that fuse: where they stand nearer than the gap that closes, by their exact distances.

use super::contract::Context;
use super::detail::{Between, Detail, Sought};
use super::laid::{Laid, bodies_at};
use super::least_width::{LeastWidth, doubt};
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, add, along, distance, scale, sub, unit};
use crate::geometry::{BodyPair, DisjointSets};
use crate::medial::Side;
use crate::morphology::{Cells, grown};
use crate::part::Part;
use crate::process::Process;

/// Steps along a link for each cell.
const STEPS: f64 = 8.0;

/// What joins two bodies, and what that makes of the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Join {
    /// Two pieces become one.
    Pieces,
    /// One piece is joined to itself: a tunnel.
    Tunnel,
}

/// The pairs of bodies that one piece is made of in print.
pub(super) struct Fusing<'a> {
    part: &'a Part,
    process: &'a Process,
    /// Nearest first; those that touch among them.
    near: Vec<&'a BodyPair>,
}

impl<'a> Fusing<'a> {
    pub fn new(part: &'a Part, process: &'a Process) -> Self {
        let least = process.element.closing_gap_mm - part.tie();
        let mut near: Vec<&BodyPair> = part.body_pairs().iter().filter(|p| p.distance < least).collect();
        near.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        Fusing { part, process, near }
    }

    pub fn is_none(&self) -> bool {
        self.near.is_empty()
    }

    fn touches(&self, pair: &BodyPair) -> bool {
        pair.distance <= self.part.step()
    }

    /// Pairs between which there is a gap that closes.
    pub fn with_gaps(&self) -> impl Iterator<Item = &'a BodyPair> + '_ {
        self.near.iter().copied().filter(|p| !self.touches(p))
    }

    /// How much a gap lacks of one that stays open.
    pub fn missing(&self, pair: &BodyPair) -> f64 {
        self.process.element.closing_gap_mm - pair.distance
    }

    /// The most that the gaps between some bodies lack, numbered from 1; 0 where there are none.
    pub fn missing_between(&self, bodies: &[u64]) -> f64 {
        let are_among = |p: &&BodyPair| p.bodies.iter().all(|&b| bodies.contains(&(u64::from(b) + 1)));
        self.with_gaps().filter(are_among).map(|p| self.missing(p)).fold(0.0, f64::max)
    }

    /// Whether a lattice that sees so many pieces shows all bodies apart between which there is a gap.
    pub fn is_resolved(&self, pieces: u64) -> bool {
        self.with_gaps().next().is_none() || pieces >= self.left_by(|pair| self.touches(pair))
    }

    /// Pieces that the bodies make in print.
    pub fn pieces(&self) -> u64 {
        self.left_by(|_| true)
    }

    /// Pieces that are left once some of the pairs are joined.
    fn left_by(&self, joins: impl Fn(&BodyPair) -> bool) -> u64 {
        let bodies = self.part.health().bodies.len();
        let mut joined = DisjointSets::new(bodies);
        let mut pieces = bodies as u64;
        for pair in self.near.iter().filter(|pair| joins(pair)) {
            let [a, b] = pair.bodies.map(|body| joined.root(body));
            if a != b {
                joined.join(a, b);
                pieces -= 1;
            }
        }
        pieces
    }

    /// Each pair with a gap, and what closing it makes of the part, one after another, the nearest first; what touches is one piece before.
    ///
    /// # Limits
    /// A pair that is near at more than one place counts as one, and gaps that surround a body close no hole.
    pub fn by_pairs(&self) -> Vec<(&'a BodyPair, Join)> {
        let mut joined = DisjointSets::new(self.part.health().bodies.len());
        let mut join = |pair: &BodyPair| {
            let [a, b] = pair.bodies.map(|body| joined.root(body));
            if a == b {
                return Join::Tunnel;
            }
            joined.join(a, b);
            Join::Pieces
        };
        self.near.iter().filter(|p| self.touches(p)).for_each(|p| {
            join(p);
        });
        self.with_gaps().map(|pair| (pair, join(pair))).collect()
    }

    /// The cells of a lattice that join the bodies: those in gaps between them that close, wherever the lattice stands, with what of them is
    /// wider by no more than cells tell, and for pairs without any a link between their nearest points.
    ///
    /// # Errors
    /// None for shapes that exist.
    ///
    /// # Cost
    /// A search for all such gaps, and two nearest facets for each cell in them.
    pub fn cells(&self, laid: &Laid, context: &Context) -> Result<Indicator> {
        let (part, process) = (self.part, self.process);
        let designed = &laid.on_lattice.designed;
        let width = process.element.closing_gap_mm;
        let mut joining = Indicator::empty(designed.cells.grid);
        let mut joined: Vec<Vec<u32>> = Vec::new();
        if self.with_gaps().next().is_some() {
            let (side, between) = (Side::Void, Between::Surfaces);
            let found = Sought { part, process, context, side, between, width }.search();
            let least = width - part.tie();
            let mut gaps = found.sheets(|t| t.diameter < least);
            gaps.retain(|gap| gap.area > 0.0 && bodies_at(part, gap.thinnest.contacts.into_iter()).len() > 1);
            let void = LeastWidth::new(part, process, context, side);
            // A gap that is as wide as that here and there is one place.
            let cells = &designed.cells;
            joining = void.cells(&gaps, designed, &laid.designed, |n| 0.0..least + doubt(n, cells));
            let is_filled = |gap: &&Detail| {
                let mut boxes = gap.patches.iter().map(|patch| cells.touched(patch.extent));
                boxes.any(|extent| cells.indices_in(extent).any(|index| joining.contains(index)))
            };
            let filled = gaps.iter().filter(is_filled);
            joined.extend(filled.map(|gap| bodies_at(part, gap.thinnest.contacts.into_iter())));
        }
        for pair in self.near.iter().filter(|pair| !joined.iter().any(|of| pair.bodies.iter().all(|b| of.contains(b))))
        {
            link(&designed.cells, pair, self.touches(pair)).for_each(|index| joining.set(index, true));
        }
        // What beside such a gap is drawn and not printed is laid with what fills it: it would be a pit in the face, and is a void then.
        let pits = laid.designed.difference(&laid.printed)?.intersection(&grown(&joining, 1))?;
        let joining = joining.difference(&laid.designed)?.union(&pits)?;
        // What joins nothing is no link.
        laid.hanging(&joining.union(&laid.designed)?)?.intersection(&joining)
    }
}

/// The cells along the line between the nearest points of a pair, and a cell further into both bodies; about a point where they touch, which
/// tells no direction, all that are beside it.
fn link(cells: &Cells, pair: &BodyPair, touches: bool) -> Box<dyn Iterator<Item = [usize; 3]>> {
    let cell = cells.cell_mm();
    if touches {
        let at = pair.middle();
        let block: Vec<_> = cells.indices_in((sub(at, scale(cell, 1.5)), add(at, scale(cell, 1.5)))).collect();
        return Box::new(block.into_iter());
    }
    let [p, q] = pair.points;
    let way = unit(sub(q, p));
    let more = distance(cell, [0.0; 3]);
    let (from, length) = (along(p, way, -more), pair.distance + 2.0 * more);
    let steps = (STEPS * length / cell.into_iter().fold(f64::INFINITY, f64::min)).ceil().max(1.0) as usize;
    let mut path: Vec<[usize; 3]> = Vec::new();
    for n in 0..=steps {
        let at = along(from, way, length * n as f64 / steps as f64);
        let Some(index) = index_of(cells, at) else { continue };
        // One axis after another, so that each cell shares a face with the one before.
        while let Some(&last) = path.last().filter(|last| **last != index) {
            let mut next = last;
            if let Some(a) = (0..3).find(|&a| last[a] != index[a]) {
                next[a] = index[a];
            }
            path.push(next);
        }
        if path.is_empty() {
            path.push(index);
        }
    }
    Box::new(path.into_iter())
}

/// The cell that a point lies in.
fn index_of(cells: &Cells, at: Vec3) -> Option<[usize; 3]> {
    let half = scale(cells.cell_mm(), 0.5);
    cells.indices_in((sub(at, half), add(at, half))).next()
}
