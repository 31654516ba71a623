//! What printing alters of pieces, tunnels and voids, place by place.

use super::contract::Context;
use super::fusing::{Fusing, Join};
use super::laid::{Laid, bodies_at};
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::BodyPair;
use crate::geometry::vector::{Vec3, bounds};
use crate::medial::Side;
use crate::morphology::grown;
use crate::part::Part;
use crate::topology::{Adjacency, Betti, Change, Comparisons, changes, components};

/// A void block of so many cells along each side is no pore.
const PORE: usize = 3;

/// Whether samples are taken away from the design, or added beside it: between bodies, or elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Lost,
    Joined,
    Gained,
}

/// One thing that happens at one place, as often as given.
#[derive(Debug, Clone)]
pub(super) struct Event {
    pub kind: &'static str,
    pub times: u64,
    pub at: Vec3,
    pub extent: (Vec3, Vec3),
    /// The bodies that meet here, counted from 1.
    pub bodies: Vec<u64>,
    /// By how much the place is narrower than what would be printed as drawn, millimetres, where its sides tell.
    pub missing: f64,
}

/// All that printing alters.
pub(super) struct Altered {
    pub events: Vec<Event>,
    /// The numbers as printed, from those of the design and what is told; `None` where bodies fuse that the lattice does not show apart.
    pub after: Option<Betti>,
}

impl Altered {
    /// The changes from the design to the print on a lattice.
    ///
    /// First what is not printed is taken away, then gaps between bodies close, then what else is printed beside the design is added. What
    /// the widths of sheets and slots do not tell to depart, and the lattice cannot tell to stay, is kept as drawn where that changes less.
    ///
    /// # Errors
    /// None for shapes that exist.
    pub fn on_lattice(part: &Part, laid: &mut Laid, fusing: &Fusing, context: &Context) -> Result<Self> {
        // Most of what is printed beside the design is the same each time.
        let mut besides = Comparisons::default();
        let mut steps = again(laid, Side::Material, &[], &mut besides)?;
        for side in [Side::Material, Side::Void] {
            if let Some((departed, places)) = laid.departing(side)? {
                let others = again(&departed, side, &steps, &mut besides)?;
                // Each place changes one thing at most, unless the lattice is too coarse to take it out whole.
                if total(&others) <= total(&steps) + places {
                    (*laid, steps) = (departed, others);
                }
            }
        }
        for (step, side) in [(Step::Lost, Side::Material), (Step::Gained, Side::Void)] {
            if !steps.iter().any(|(_, s)| *s == step) {
                continue;
            }
            // What is kept changes less, or the lattice is too coarse for it as well.
            if let Some(kept) = laid.keeping(side)? {
                let fewer = again(&kept, side, &steps, &mut besides)?;
                if total(&fewer) < total(&steps) {
                    (*laid, steps) = (kept, fewer);
                }
            }
        }
        let mut by_pairs = !fusing.is_resolved(laid.seen.pieces);
        let mut gaps = Vec::new();
        if !by_pairs && !fusing.is_none() {
            let mut joined = only_lost(&steps);
            let joining = fusing.cells(laid, context)?;
            gaps = components(&joining, Adjacency::Corner).boxes();
            joined.extend(beside(laid, Some(&joining), &mut besides)?);
            without_pores(laid, &mut joined, Some(joining), &mut besides)?;
            let pieces = |of| joined.iter().filter(|(_, s)| *s == of).map(|(c, _)| c.pieces).sum::<i64>();
            let left = laid.seen.pieces.saturating_add_signed(pieces(Step::Joined));
            // Distances are exact: where the lattice has joined others, it is not asked.
            if pieces(Step::Lost) != 0 || left == fusing.pieces() { steps = joined } else { by_pairs = true }
        }
        if gaps.is_empty() || by_pairs {
            without_pores(laid, &mut steps, None, &mut besides)?;
        }
        let cells = &laid.on_lattice.designed.cells;
        // Where the lattice sees another part than the mesh describes, what is smaller than an element is not told, nor what is only the
        // holes that samples leave in something thin.
        let least = if laid.is_unlike() { (cells.wide * cells.wide) as u64 } else { 0 };
        let is_sieve = |c: &Change| laid.is_unlike() && c.tunnels.abs() > 1;
        let mut told = Altered { events: if by_pairs { fused(fusing) } else { Vec::new() }, after: None };
        let mut sums = [0; 3];
        for (change, step) in &steps {
            let mut own = Vec::new();
            // Where in a gap two bodies are joined hangs on the lattice; the gap does not.
            let mut change = change.clone();
            let at = laid.designed.grid().index(change.at);
            let holds = |gap: &&[[usize; 3]; 2]| (0..3).all(|a| gap[0][a] <= at[a] && at[a] <= gap[1][a]);
            let gap = gaps.iter().find(holds).filter(|_| *step == Step::Joined);
            change.extent = gap.copied().unwrap_or(change.extent);
            events_of(part, laid, &change, *step, &mut own);
            if *step == Step::Joined {
                own.iter_mut().for_each(|e| e.missing = e.missing.max(fusing.missing_between(&e.bodies)));
            }
            // Whether bodies meet is told by their distance.
            let between = *step != Step::Joined && own.iter().any(|e| e.bodies.len() > 1);
            if between && *step == Step::Gained || change.samples < least && *step != Step::Joined || is_sieve(&change)
            {
                continue;
            }
            let sign = if *step == Step::Lost { -1 } else { 1 };
            let counts = [change.pieces, change.tunnels, change.voids];
            (0..3).for_each(|i| sums[i] += sign * counts[i]);
            told.events.extend(own);
        }
        let [pieces, tunnels, voids] = sums;
        let seen = &laid.seen;
        told.after = (!by_pairs).then_some(Betti {
            pieces: seen.pieces.saturating_add_signed(pieces),
            tunnels: seen.tunnels.saturating_add_signed(tunnels),
            voids: seen.voids.saturating_add_signed(voids),
        });
        Ok(told)
    }

    /// What the distances of bodies alone tell.
    pub fn by_distance(fusing: &Fusing) -> Self {
        Altered { events: fused(fusing), after: None }
    }
}

/// Fills pores that the lattice leaves about new tunnels and voids, as long as there are fewer of them then and no other pieces: with what joins bodies, if
/// that is given, or with what is printed.
///
/// The coats of two slanting faces meet cell by cell, here and not there.
fn without_pores(
    laid: &mut Laid,
    steps: &mut Vec<(Change, Step)>,
    mut joining: Option<Indicator>,
    besides: &mut Comparisons,
) -> Result<()> {
    let element = laid.on_lattice.designed.cells.wide;
    for side in [PORE, element.max(PORE)] {
        let is_new = |(c, step): &&(Change, Step)| *step != Step::Lost && (c.tunnels > 0 || c.voids > 0);
        let places: Vec<[[usize; 3]; 2]> = steps.iter().filter(is_new).map(|(c, _)| c.extent).collect();
        if places.is_empty() {
            break;
        }
        let printed = joining.as_ref().map_or_else(|| Ok(laid.printed.clone()), |gap| laid.printed.union(gap))?;
        let pores = laid.pores(&printed, &places, side)?;
        if pores.is_empty() {
            continue;
        }
        let filled = joining.as_ref().map(|gap| gap.union(&pores)).transpose()?;
        let next = match &filled {
            Some(_) => laid.clone(),
            None => laid.with(&pores)?,
        };
        let mut fewer = only_lost(steps);
        fewer.extend(beside(&next, filled.as_ref(), besides)?);
        let pieces = |steps: &[(Change, Step)]| steps.iter().map(|(c, _)| c.pieces).sum::<i64>();
        if total(&fewer) < total(steps) && pieces(&fewer) == pieces(steps) {
            (*laid, *steps, joining) = (next, fewer, filled);
        }
    }
    Ok(())
}

/// How many changes there are, each as often as it happens.
fn total(steps: &[(Change, Step)]) -> u64 {
    steps.iter().map(|(c, _)| c.pieces.unsigned_abs() + c.tunnels.unsigned_abs() + c.voids.unsigned_abs()).sum()
}

/// The changes of all steps, after something has been done to one side of the surface; what is lost is known from before if that was the void.
fn again(laid: &Laid, side: Side, before: &[(Change, Step)], besides: &mut Comparisons) -> Result<Vec<(Change, Step)>> {
    let mut all = match side {
        Side::Void => only_lost(before),
        Side::Material => {
            let left = laid.designed.intersection(&laid.printed)?;
            named(changes(&left, &laid.designed, Adjacency::Face)?, Step::Lost).collect()
        }
    };
    all.extend(beside(laid, None, besides)?);
    Ok(all)
}

/// What is added to the design: first what joins bodies, then all else.
fn beside(laid: &Laid, joining: Option<&Indicator>, besides: &mut Comparisons) -> Result<Vec<(Change, Step)>> {
    let left = laid.designed.intersection(&laid.printed)?;
    let Some(joining) = joining else {
        return Ok(named(besides.changes(&left, &laid.printed, Adjacency::Face)?, Step::Gained).collect());
    };
    // The coat about a gap is laid with what fills it: what one leaves open at its ends, the other closes.
    let about = grown(joining, laid.coat_cells()).intersection(&laid.printed)?;
    let joined = left.union(joining)?.union(&about)?;
    let first = named(changes(&left, &joined, Adjacency::Face)?, Step::Joined);
    let then = besides.changes(&joined, &laid.printed.union(joining)?, Adjacency::Face)?;
    Ok(first.chain(named(then, Step::Gained)).collect())
}

fn only_lost(steps: &[(Change, Step)]) -> Vec<(Change, Step)> {
    steps.iter().filter(|(_, step)| *step == Step::Lost).cloned().collect()
}

fn named(found: Vec<Change>, step: Step) -> impl Iterator<Item = (Change, Step)> {
    found.into_iter().map(move |change| (change, step))
}

/// What a change means, read forward for what is added and backward for what is lost.
fn kinds_of(c: &Change, step: Step) -> Vec<(&'static str, u64)> {
    let all = match step {
        Step::Gained | Step::Joined => [
            ("fused", -c.pieces),
            ("hole-closed", -c.tunnels),
            ("bridged", c.tunnels),
            ("void-enclosed", c.voids),
            ("void-filled", -c.voids),
        ],
        Step::Lost => [
            ("split", -c.pieces),
            ("piece-lost", c.pieces),
            ("hole-opened", -c.tunnels),
            ("loop-cut", c.tunnels),
            ("void-opened", c.voids),
        ],
    };
    all.into_iter().filter(|k| k.1 > 0).map(|(kind, times)| (kind, times as u64)).collect()
}

fn events_of(part: &Part, laid: &Laid, c: &Change, step: Step, events: &mut Vec<Event>) {
    let cells = &laid.on_lattice.designed.cells;
    let half = cells.cell_mm().map(|c| 0.5 * c);
    let corner = |p: [usize; 3], sign: f64| {
        let q = cells.position(p);
        [0, 1, 2].map(|a| q[a] + sign * half[a])
    };
    let place = |at: usize| cells.position(cells.grid.index(at));
    let extent = (corner(c.extent[0], -1.0), corner(c.extent[1], 1.0));
    let bodies = bodies_at(part, c.meets.iter().map(|&at| place(at)));
    let side = if step == Step::Lost { Side::Material } else { Side::Void };
    let missing = laid.missing(side, extent);
    for (kind, times) in kinds_of(c, step) {
        let bodies = counted(&bodies);
        events.push(Event { kind, times, at: place(c.at), extent, bodies, missing });
    }
}

/// Bodies counted from 1.
fn counted(bodies: &[u32]) -> Vec<u64> {
    bodies.iter().map(|&body| u64::from(body) + 1).collect()
}

/// Bodies that stand nearer than the gap that closes, pair by pair.
fn fused(fusing: &Fusing) -> Vec<Event> {
    let event = |(pair, join): (&BodyPair, Join)| Event {
        kind: if join == Join::Pieces { "fused" } else { "bridged" },
        times: 1,
        at: pair.middle(),
        extent: bounds(pair.points).unwrap_or_default(),
        bodies: counted(&pair.bodies),
        missing: fusing.missing(pair),
    };
    fusing.by_pairs().into_iter().map(event).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(pieces: i64, tunnels: i64, voids: i64) -> Change {
        Change { at: 0, extent: [[0; 3]; 2], samples: 1, pieces, tunnels, voids, meets: Vec::new() }
    }

    #[test]
    fn every_change_has_a_name_in_either_direction() {
        let kinds = |c: Change, step| kinds_of(&c, step);
        assert_eq!(kinds(change(-2, 0, 0), Step::Joined), [("fused", 2)]);
        assert_eq!(kinds(change(0, -1, 1), Step::Gained), [("hole-closed", 1), ("void-enclosed", 1)]);
        assert_eq!(kinds(change(0, 1, -1), Step::Gained), [("bridged", 1), ("void-filled", 1)]);
        assert_eq!(kinds(change(1, 0, 0), Step::Lost), [("piece-lost", 1)]);
        assert_eq!(kinds(change(-1, 0, 0), Step::Lost), [("split", 1)]);
        assert_eq!(kinds(change(0, -1, 0), Step::Lost), [("hole-opened", 1)]);
        assert_eq!(kinds(change(0, 1, 1), Step::Lost), [("loop-cut", 1), ("void-opened", 1)]);
    }
}
