//! How wide the widest way from a place of the void to the outside is, by the distance to the surface itself.

use super::ball_way::{Beside, Lattice, MOST_ASKED};
use super::budget::Budget;
use super::finding::Bracket;
use super::throat::Stands;
use super::void::{HALF_DIAGONAL, holds};
use crate::field::Field;
use crate::geometry::vector::{Vec3, distance};
use crate::part::Part;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BinaryHeap;

/// Steps of the lattices in the spacing of the whole grid, in turn.
const STEPS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// What a flood from a place has told.
#[derive(Debug, Clone)]
pub(super) struct Way {
    /// Diameter of the largest ball that gets from there to the outside or to a room that is told, mm.
    pub width_mm: Bracket,
    /// Where it is narrowest.
    pub throat: Option<Vec3>,
    /// Whether what it leads to is the outside.
    pub leads_out: bool,
    /// Points of the room that it leaves: those from which wider ways lead to the place.
    pub room: Vec<Vec3>,
}

/// A point that waits to be flooded; the widest goes first.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Waiting {
    /// The distance to the surface, as bits: positive numbers are ordered like these.
    clearance: u64,
    at: [i32; 3],
    /// The facet that is nearest to the point it was met from.
    facet: u32,
    /// What is known of the way on from here, by its number among those passed; nothing for a point of the lattice.
    on: Option<usize>,
}

/// What floods over one lattice have met.
#[derive(Debug)]
struct Level {
    lattice: Lattice,
    /// Points of rooms that were left by a way, with its number.
    passed: FxHashMap<[i32; 3], usize>,
    /// Their widest ways: the narrowest distance, where it is, and what they lead to.
    ways: Vec<((f64, [i32; 3]), End)>,
    /// Points of rooms that are told.
    told: FxHashSet<[i32; 3]>,
}

/// The end of one flood.
struct Flood {
    /// The least distance on the widest way, and where.
    narrowest: (f64, [i32; 3]),
    /// What was met before it.
    room: Vec<[i32; 3]>,
    end: Option<End>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    Outside,
    Told,
}

/// Ways out of places of a void, one after another.
pub(super) struct WaysOut<'a> {
    part: &'a Part,
    extent: Vec3,
    clearance: &'a Field<u32>,
    /// Where a ball of `limit_mm` may stand on the whole grid.
    stands: &'a Stands,
    limit_mm: f64,
    /// Middles of rooms that are told.
    told: Vec<Vec3>,
    levels: Vec<Level>,
}

impl<'a> WaysOut<'a> {
    /// By the clearance of the whole grid and where a ball of the limit may stand on it; ways into rooms that are told end there.
    pub fn of(
        part: &'a Part,
        (clearance, stands): (&'a Field<u32>, &'a Stands),
        limit_mm: f64,
        told: Vec<Vec3>,
    ) -> Self {
        let grid = clearance.grid();
        let level = |share: f64| Level {
            lattice: Lattice { origin: grid.position([0; 3]), step: share * grid.h() },
            passed: FxHashMap::default(),
            ways: Vec::new(),
            told: FxHashSet::default(),
        };
        WaysOut { part, extent: part.extent(), clearance, stands, limit_mm, told, levels: STEPS.map(level).into() }
    }

    /// Whether a place belongs to a room that is told, or that a ball of this diameter is known to leave.
    pub fn is_known(&self, p: Vec3, ball_mm: f64) -> bool {
        self.levels.iter().any(|level| {
            let at = level.lattice.nearest(p);
            let least = 0.5 * (ball_mm + level.lattice.step);
            level.told.contains(&at) || level.passed.get(&at).is_some_and(|&way| level.ways[way].0.0 >= least)
        })
    }

    /// The widest way from a place where a ball of `wide_mm` just fits, as close as it takes to tell whether a ball of `ball_mm` passes;
    /// `None` if more would have to be asked than the budget has or than [`MOST_ASKED`] for each lattice.
    ///
    /// Points of a lattice of step σ are flooded from the place, the widest first, over their faces. The least distance r that is met before
    /// the end bounds the way: a ball of 2r − σ passes, as between neighbours the distance falls by half a step at most; none of
    /// 2r + √3·σ does, as every way runs through cubes whose middles are half a diagonal off.
    ///
    /// # Cost
    /// A distance for each point of the room and its way that is wider than r, on each lattice.
    ///
    /// # Source
    /// M. Pollack, The maximum capacity through a network, 1960.
    pub fn from(&mut self, (place, wide_mm): (Vec3, f64), ball_mm: f64, budget: &mut Budget) -> Option<Way> {
        let mut best: Option<Way> = None;
        let mut met = Vec::new();
        for n in 0..self.levels.len() {
            let step = self.levels[n].lattice.step;
            // The next point of the lattice lies on the same side of the surface, with room to go on.
            if 0.5 * wide_mm <= (HALF_DIAGONAL + 0.5) * step {
                continue;
            }
            if !budget.allows(MOST_ASKED) {
                break;
            }
            let Some(flood) = self.flood(n, place, budget) else { break };
            let way = self.told_by(&flood, (n, wide_mm), best.as_ref());
            let decided = way.width_mm.low >= ball_mm || way.width_mm.high < ball_mm;
            met.push((n, flood));
            best = Some(way);
            if decided {
                break;
            }
        }
        let way = best?;
        let is_told = way.width_mm.low < ball_mm;
        for (n, flood) in met {
            let level = &mut self.levels[n];
            if is_told {
                level.told.extend(flood.room);
            } else {
                level.passed.extend(flood.room.into_iter().map(|at| (at, level.ways.len())));
                level.ways.push((flood.narrowest, flood.end.unwrap_or(End::Told)));
            }
        }
        Some(way)
    }

    /// What a flood says, and with it what coarser ones have said.
    fn told_by(&self, flood: &Flood, (n, wide_mm): (usize, f64), before: Option<&Way>) -> Way {
        let lattice = self.levels[n].lattice;
        let (r, step) = (flood.narrowest.0, lattice.step);
        let (low, high) = match flood.end {
            Some(_) => ((2.0 * r - step).min(wide_mm - 2.0 * HALF_DIAGONAL * step), 2.0 * (r + HALF_DIAGONAL * step)),
            // Points within half a step of the surface are not gone over.
            None => (0.0, (1.0 + 2.0 * HALF_DIAGONAL) * step),
        };
        let (least, most) = before.map_or((0.0, f64::INFINITY), |way| (way.width_mm.low, way.width_mm.high));
        let (low, high) = (low.clamp(least, most), high.clamp(least, most));
        let value = if flood.end.is_some() { (2.0 * r).clamp(low, high) } else { low };
        Way {
            width_mm: Bracket::new(value, low, high),
            throat: flood.end.map(|_| lattice.at(flood.narrowest.1)),
            leads_out: flood.end == Some(End::Outside),
            room: flood.room.iter().map(|&at| lattice.at(at)).collect(),
        }
    }

    /// Floods a lattice from a place until it leads to the outside or to a room that is told; `None` if that takes too many points.
    fn flood(&self, n: usize, place: Vec3, budget: &mut Budget) -> Option<Flood> {
        let level = &self.levels[n];
        let (step, surface) = (level.lattice.step, self.part.distance());
        // What is wider than this need not be told apart.
        let most = 0.75 * self.limit_mm + step;
        let start = level.lattice.nearest(place);
        let mut seen = FxHashSet::from_iter([start]);
        let mut waiting = BinaryHeap::new();
        let first = surface.nearest(level.lattice.at(start), f64::INFINITY)?;
        waiting.push(Waiting {
            clearance: first.distance.min(most).to_bits(),
            at: start,
            facet: first.facet,
            on: None,
        });
        let (mut met, mut narrowest, mut inside) = (Vec::new(), (f64::INFINITY, start), 0);
        let mut end = None;
        while let Some(next) = waiting.pop() {
            let r = f64::from_bits(next.clearance);
            if r < narrowest.0 {
                let at = next.on.map_or(next.at, |way| level.ways[way].0.1);
                (narrowest, inside) = ((r, at), met.len());
            }
            end = match next.on {
                Some(way) => Some(level.ways[way].1),
                None => self.end(level, next.at),
            };
            if end.is_some() || seen.len() as u64 > MOST_ASKED {
                break;
            }
            met.push(next.at);
            if let Some(&way) = level.passed.get(&next.at) {
                let clearance = r.min(level.ways[way].0.0).to_bits();
                waiting.push(Waiting { clearance, on: Some(way), ..next });
                continue;
            }
            for beside in Beside::Face.around(next.at).filter(|&at| seen.insert(at)) {
                let p = level.lattice.at(beside);
                let near = surface.nearest_from(p, next.facet);
                if near.distance > 0.5 * step {
                    let clearance = near.distance.min(most).to_bits();
                    waiting.push(Waiting { clearance, at: beside, facet: near.facet, on: None });
                }
            }
        }
        budget.note(1, seen.len() as u64);
        let is_done = end.is_some() || waiting.is_empty();
        // Without an end all that was met is the room.
        let count = if end.is_some() { inside } else { met.len() };
        met.truncate(count.max(1));
        is_done.then_some(Flood { narrowest, room: met, end })
    }

    /// Whether a ball that stands on a point is out, or in a room that is told, as far as one of the limit goes.
    fn end(&self, level: &Level, at: [i32; 3]) -> Option<End> {
        if level.told.contains(&at) {
            return Some(End::Told);
        }
        let (p, step) = (level.lattice.at(at), level.lattice.step);
        // Beyond the part's box a ball leaves along an axis.
        if !holds(([0.0; 3], self.extent), p) {
            return Some(End::Outside);
        }
        if self.told.iter().any(|&middle| distance(p, middle) <= HALF_DIAGONAL * step) {
            return Some(End::Told);
        }
        let (piece, at, away) = self.stands.beside(p)?;
        let h = self.clearance.grid().h();
        // Samples of the whole grid have half its spacing to spare, or more.
        let spare = h * (f64::from(self.clearance.values()[at]).sqrt() - HALF_DIAGONAL) - 0.5 * self.limit_mm;
        if away > spare.max(0.5 * h) {
            return None;
        }
        let is_told = || self.told.iter().any(|&middle| self.stands.at(middle) == Some(piece));
        if self.stands.is_out(piece) { Some(End::Outside) } else { is_told().then_some(End::Told) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::void::Voids;
    use super::super::void::tests::{flask, part, turned};
    use super::*;
    use crate::random::Lcg;

    #[test]
    fn the_way_out_of_a_flask_is_within_its_bracket_and_a_ball_is_decided_as_closely_as_the_finest_lattice_tells() {
        let mut rng = Lcg(97);
        let (mut passes, mut is_stuck) = (0, 0);
        for case in 0..80 {
            let (neck, h) = (0.4 + 1.5 * rng.unit(), 0.5 + 0.1 * rng.unit());
            let mesh = turned(&flask(8.0, 3.0, neck), || rng.unit());
            let part = part(mesh, h, [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let clearance = voids.clearance().unwrap();
            // The room and the block have one middle.
            let (middle, wide) = (part.extent().map(|x| 0.5 * x), 3.0);
            let stands = Stands::of(&clearance, 2.8);
            let mut ways = WaysOut::of(&part, (&clearance, &stands), 2.8, Vec::new());
            let (ball, mut budget) = (neck * (0.7 + 0.6 * rng.unit()), Budget::of(1 << 24));
            let way = ways.from((middle, wide), ball, &mut budget).unwrap();
            let Bracket { low, high, .. } = way.width_mm;
            assert!(low <= neck && neck <= high, "{case}: {neck} not in {low} to {high}, h {h}");
            let (fits, stuck) = (low >= ball, high < ball);
            assert!(
                fits || stuck || high - low <= (1.0 + 2.0 * HALF_DIAGONAL) * 0.125 * h + 1e-9,
                "{case}: {low} to {high}"
            );
            assert!(ways.is_known(middle, ball), "{case}");
            assert!(budget.looks > 0 && (way.leads_out || low == 0.0), "{case}");
            passes += usize::from(fits);
            is_stuck += usize::from(stuck);
        }
        assert!(passes > 10 && is_stuck > 20, "{passes} pass, {is_stuck} are stuck");
    }

    #[test]
    fn what_leads_into_a_room_that_is_told_ends_there_and_without_a_budget_nothing_is_followed() {
        let part = part(flask(10.0, 5.0, 2.0), 0.4, [0.1, 0.2, 0.3]);
        let voids = Voids::of(&part).unwrap();
        let clearance = voids.clearance().unwrap();
        let chamber = voids.narrow(&clearance, 4.5, &mut voids.nothing()).unwrap().remove(0);
        let (wide, middle) = voids.widest_about(chamber.at, f64::INFINITY, 5.0);
        let stands = Stands::of(&clearance, 4.5);
        let followed = |told: Vec<Vec3>, budget: u64| {
            let mut ways = WaysOut::of(&part, (&clearance, &stands), 4.5, told);
            ways.from((middle, wide), 3.0, &mut Budget::of(budget))
        };
        let (out, known) = (followed(Vec::new(), 1 << 24).unwrap(), followed(vec![middle], 1 << 24).unwrap());
        assert!(out.leads_out && out.width_mm.high < 3.0 && out.throat.is_some() && out.room.len() > 10);
        assert!(!known.leads_out && known.width_mm.low >= 3.0);
        assert!(followed(Vec::new(), MOST_ASKED - 1).is_none());
    }
}
