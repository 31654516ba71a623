//! Chambers of a void that something of a given size cannot leave, each with its widest way out.

use super::components::{Adjacency, Components, components};
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use crate::grid::Grid;

/// The narrowest sample of the widest way out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Throat {
    /// Storage offset.
    pub at: usize,
    /// Its clearance, in the unit of the field.
    pub clearance: u32,
}

/// A room of a void from which no path of at least the level's clearance leads out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chamber {
    /// Its widest sample (of equal ones the first in storage) and the clearance there.
    pub deepest: usize,
    pub widest: u32,
    /// Where its widest way out is narrowest; `None` if no path leads out.
    pub throat: Option<Throat>,
    /// The samples joined to the deepest one by samples wider than the throat, as (first offset, count) along x.
    pub region: Vec<(u32, u32)>,
}

impl Chamber {
    /// Number of samples wider than the throat.
    pub fn samples(&self) -> u64 {
        self.region.iter().map(|r| u64::from(r.1)).sum()
    }

    /// The samples wider than the throat, as offsets in storage.
    pub fn offsets(&self) -> impl Iterator<Item = usize> + '_ {
        self.region.iter().flat_map(|&(first, count)| first as usize..(first + count) as usize)
    }

    /// Whether a sample is one of them.
    pub fn holds(&self, at: usize) -> bool {
        self.region.iter().any(|&(first, count)| (first as usize..(first + count) as usize).contains(&at))
    }
}

/// The chambers of a void at a level of clearance, those with more samples first.
///
/// `clearance` is 0 in the material and grows with the distance to it (squared distances in units of the spacing will
/// do: only their order counts). A chamber holds a component of { clearance ≥ level } in which there is no exit; its throat
/// is max over paths from there to an exit of the least clearance on the path, as in [`super::escape`], and components that
/// meet at something wider than that are one chamber. Components whose first sample satisfies `known` are left out.
/// Neighbours are the 26 around a sample.
///
/// # Errors
/// [`Error::Operand`] if the grids differ or the level is 0; [`Error::TooLarge`] beyond 2^32 samples or a level of 2^24.
///
/// # Cost
/// O(N/64) words to label the level set, then O(26) for each sample between throat and level; nothing beyond the throats
/// is visited, so a part without chambers costs one labelling. Where a room is large, its throat is first narrowed down by
/// halving, one labelling for each of about log₂(level) steps, and only samples of the throat's clearance are visited.
///
/// # Source
/// Widest paths by flooding from the widest sample down (M. Pollack, The maximum capacity through a network, 1960).
pub fn chambers(
    clearance: &Field<u32>,
    exits: &Indicator,
    level: u32,
    known: impl Fn(usize) -> bool,
) -> Result<Vec<Chamber>> {
    chambers_above(clearance, exits, level, known, LARGE)
}

/// Rooms of more samples are narrowed down by halving: there are more samples between throat and level than labels cost.
const LARGE: u64 = 1 << 18;

/// The highest level: a flood has a queue for each below it.
const MOST_LEVEL: u32 = 1 << 24;

fn chambers_above(
    clearance: &Field<u32>,
    exits: &Indicator,
    level: u32,
    known: impl Fn(usize) -> bool,
    large: u64,
) -> Result<Vec<Chamber>> {
    let grid = *clearance.grid();
    let bad = |problem: &str| Error::Operand {
        operation: "chambers",
        problem: problem.into(),
        remedy: "give clearance and exits on one grid, and a level above 0".into(),
    };
    if exits.grid() != &grid {
        return Err(bad("clearance and exits stand on different grids"));
    }
    if level == 0 {
        return Err(bad("the level is 0"));
    }
    let too_large = |what: String, need: u128, allowed: u32| Error::TooLarge {
        what,
        need_bytes: 8 * need,
        allowed_bytes: 8 * u128::from(allowed),
        remedy: "choose a larger spacing, or look at a window of the part".into(),
    };
    if level > MOST_LEVEL {
        return Err(too_large(format!("the search for chambers at level {level}"), level.into(), MOST_LEVEL));
    }
    if grid.samples() >= u32::MAX as usize {
        let what = format!("the search for chambers among {:?} samples", grid.dims());
        return Err(too_large(what, grid.samples() as u128, u32::MAX));
    }
    let (wide, rooms, open) = level_set(clearance, exits, level)?;
    let shut: Vec<u32> = (0..rooms.count() as u32).filter(|&r| !open[r as usize]).collect();
    if shut.is_empty() {
        return Ok(Vec::new());
    }
    let values = clearance.values();
    let (first, sizes) = (rooms.first_samples(), rooms.sizes());
    let mut search = Search::new(&grid, values, exits, &wide, &rooms, open, level);
    let mut found = Vec::new();
    for room in shut {
        let inside = first[room as usize];
        if search.taken[room as usize] || known(grid.offset(inside)) {
            continue;
        }
        if sizes[room as usize] < large {
            found.push(search.flood(room));
            continue;
        }
        let chamber = by_halving(clearance, exits, level, inside)?;
        let met =
            chamber.region.iter().filter(|r| values[r.0 as usize..(r.0 + r.1) as usize].iter().any(|&v| v >= level));
        for at in met.flat_map(|&(from, n)| from as usize..(from + n) as usize).filter(|&at| values[at] >= level) {
            rooms.of(grid.index(at)).into_iter().for_each(|r| search.taken[r as usize] = true);
        }
        found.push(chamber);
    }
    found.sort_by_key(|c| (std::cmp::Reverse(c.samples()), c.deepest));
    Ok(found)
}

/// The samples of at least a clearance, their components, and which of these hold an exit.
fn level_set(clearance: &Field<u32>, exits: &Indicator, level: u32) -> Result<(Indicator, Components, Vec<bool>)> {
    let (grid, values) = (clearance.grid(), clearance.values());
    let wide = Indicator::from_predicate(*grid, |at| values[at] >= level);
    let rooms = components(&wide, Adjacency::Corner);
    let mut open = vec![false; rooms.count()];
    for at in exits.intersection(&wide)?.iter() {
        if let Some(room) = rooms.of(grid.index(at)) {
            open[room as usize] = true;
        }
    }
    Ok((wide, rooms, open))
}

/// The chamber around a sample that is shut at a level: the highest level at which it is open is its throat.
fn by_halving(clearance: &Field<u32>, exits: &Indicator, level: u32, inside: [usize; 3]) -> Result<Chamber> {
    let (mut open_at, mut shut_at) = (0, level);
    while shut_at - open_at > 1 {
        let middle = open_at + (shut_at - open_at) / 2;
        let (_, rooms, open) = level_set(clearance, exits, middle)?;
        if rooms.of(inside).is_some_and(|r| open[r as usize]) { open_at = middle } else { shut_at = middle }
    }
    let (wide, rooms, open) = level_set(clearance, exits, shut_at)?;
    let room = rooms.of(inside).unwrap_or(0);
    Ok(Search::new(clearance.grid(), clearance.values(), exits, &wide, &rooms, open, shut_at).flood(room))
}

/// What all floods share.
struct Search<'a> {
    grid: &'a Grid,
    values: &'a [u32],
    exits: &'a Indicator,
    wide: &'a Indicator,
    rooms: &'a Components,
    open: Vec<bool>,
    /// Rooms that belong to a chamber already.
    taken: Vec<bool>,
    /// Runs of the rooms that are not open: first offset and count.
    runs: Vec<Vec<(u32, u32)>>,
    seen: Indicator,
    /// Samples still to be visited, by clearance: their places among those marked.
    buckets: Vec<Vec<u32>>,
}

/// Before a sample that was marked from a room: no sample.
const ROOM: u32 = u32::MAX;

/// The state of one flood.
#[derive(Default)]
struct Flood {
    /// Samples visited, and rooms with the number of samples that were visited before.
    visited: Vec<u32>,
    rooms: Vec<(u32, usize)>,
    /// Samples that were marked, each with the place here of the one that it was marked from, or [`ROOM`].
    marked: Vec<(u32, u32)>,
    /// A room that leads out was met.
    out: bool,
}

impl<'a> Search<'a> {
    fn new(
        grid: &'a Grid,
        values: &'a [u32],
        exits: &'a Indicator,
        wide: &'a Indicator,
        rooms: &'a Components,
        open: Vec<bool>,
        level: u32,
    ) -> Self {
        let [nx, ny, _] = grid.dims();
        let mut runs = vec![Vec::new(); rooms.count()];
        rooms.for_each_run(|j, k, run| {
            if !open[run.label as usize] {
                let first = ((k * ny + j) * nx) as u32 + run.from;
                runs[run.label as usize].push((first, run.to - run.from));
            }
        });
        Search {
            grid,
            values,
            exits,
            wide,
            rooms,
            taken: vec![false; rooms.count()],
            open,
            runs,
            seen: Indicator::empty(*grid),
            buckets: vec![Vec::new(); level as usize],
        }
    }

    /// Floods from a room, the widest samples first, until an exit or an open room is met.
    fn flood(&mut self, room: u32) -> Chamber {
        let mut flood = Flood::default();
        self.enter(room, ROOM, &mut flood);
        let mut top = self.buckets.len();
        // The least clearance, and how many samples were visited before it was met; the sample that was visited last.
        let (mut least, mut last) = ((u32::MAX, 0), ROOM);
        while !flood.out {
            while top > 0 && self.buckets[top - 1].is_empty() {
                top -= 1;
            }
            let Some(place) = top.checked_sub(1).and_then(|b| self.buckets[b].pop()) else { break };
            let at = flood.marked[place as usize].0;
            let clearance = self.values[at as usize];
            if clearance < least.0 {
                least = (clearance, flood.visited.len());
            }
            last = place;
            flood.visited.push(at);
            let index = self.grid.index(at as usize);
            if self.exits.contains(index) {
                flood.out = true;
                break;
            }
            top = top.max(self.spread(index, place, &mut flood));
        }
        self.buckets.iter_mut().for_each(Vec::clear);
        for &(at, _) in &flood.marked {
            self.seen.set(self.grid.index(at as usize), false);
        }
        let throat = self.innermost(least.0, last, &flood).map(|throat| (throat, least.1));
        self.chamber(flood, throat)
    }

    /// The sample of a clearance that the way to the last one visited meets first: the flood visits others as narrow that lead nowhere.
    fn innermost(&self, clearance: u32, last: u32, flood: &Flood) -> Option<Throat> {
        let way = std::iter::successors(flood.marked.get(last as usize), |(_, from)| flood.marked.get(*from as usize));
        let narrow = way.map(|&(at, _)| at as usize).filter(|&at| self.values[at] == clearance);
        narrow.last().map(|at| Throat { at, clearance })
    }

    /// Marks the neighbours of a sample; the topmost bucket that got one, counted from 1.
    fn spread(&mut self, [i, j, k]: [usize; 3], from: u32, flood: &mut Flood) -> usize {
        let [nx, ny, nz] = self.grid.dims();
        let mut top = 0;
        for z in k.saturating_sub(1)..(k + 2).min(nz) {
            for y in j.saturating_sub(1)..(j + 2).min(ny) {
                for x in i.saturating_sub(1)..(i + 2).min(nx) {
                    top = top.max(self.mark([x, y, z], from, flood));
                }
            }
        }
        top
    }

    /// Puts a sample into its bucket if it is void and not yet seen; meets the room it belongs to.
    fn mark(&mut self, index: [usize; 3], from: u32, flood: &mut Flood) -> usize {
        let at = self.grid.offset(index) as u32;
        let clearance = self.values[at as usize];
        if clearance == 0 {
            return 0;
        }
        if clearance as usize >= self.buckets.len() {
            return match self.rooms.of(index) {
                Some(room) if self.open[room as usize] => {
                    flood.out = true;
                    0
                }
                Some(room) if flood.rooms.iter().all(|r| r.0 != room) => self.enter(room, from, flood),
                _ => 0,
            };
        }
        if self.seen.contains(index) {
            return 0;
        }
        self.seen.set(index, true);
        self.buckets[clearance as usize].push(flood.marked.len() as u32);
        flood.marked.push((at, from));
        clearance as usize + 1
    }

    /// Adds a room to the flood and marks what surrounds it.
    fn enter(&mut self, room: u32, origin: u32, flood: &mut Flood) -> usize {
        flood.rooms.push((room, flood.visited.len()));
        let [nx, ny, nz] = self.grid.dims();
        let mut top = 0;
        for (first, count) in self.runs[room as usize].clone() {
            let [i, j, k] = self.grid.index(first as usize);
            let (from, to) = (i.saturating_sub(1), (i + count as usize + 1).min(nx));
            for z in k.saturating_sub(1)..(k + 2).min(nz) {
                for y in j.saturating_sub(1)..(j + 2).min(ny) {
                    for w in from / 64..to.div_ceil(64) {
                        let mut rest = !self.wide.row(y, z)[w] & span(from, to, w);
                        while rest != 0 {
                            let x = 64 * w + rest.trailing_zeros() as usize;
                            rest &= rest - 1;
                            top = top.max(self.mark([x, y, z], origin, flood));
                        }
                    }
                }
            }
        }
        top
    }

    fn chamber(&mut self, flood: Flood, throat: Option<(Throat, usize)>) -> Chamber {
        // Without a way out the last narrowing is no throat, and all that was visited belongs here.
        let throat = throat.filter(|_| flood.out);
        let before = throat.map_or(flood.visited.len(), |t| t.1);
        let mut region: Vec<(u32, u32)> = flood.visited[..before].iter().map(|&at| (at, 1)).collect();
        for &(room, _) in flood.rooms.iter().filter(|r| throat.is_none() || r.1 <= before) {
            self.taken[room as usize] = true;
            region.extend(&self.runs[room as usize]);
        }
        region.sort_unstable();
        let mut joined: Vec<(u32, u32)> = Vec::new();
        for (first, count) in region {
            match joined.last_mut() {
                Some(last) if last.0 + last.1 == first && self.grid.index(first as usize)[0] > 0 => last.1 += count,
                _ => joined.push((first, count)),
            }
        }
        let mut chamber = Chamber { deepest: 0, widest: 0, throat: throat.map(|t| t.0), region: joined };
        let (mut deepest, mut widest) = (0, 0);
        for at in chamber.offsets() {
            if self.values[at] > widest {
                (deepest, widest) = (at, self.values[at]);
            }
        }
        (chamber.deepest, chamber.widest) = (deepest, widest);
        chamber
    }
}

/// The bits of word `w` from position `from` up to `to` of a row.
fn span(from: usize, to: usize, w: usize) -> u64 {
    let (lo, hi) = (from.max(64 * w) - 64 * w, to.min(64 * w + 64) - 64 * w);
    let ones = |n: usize| if n >= 64 { !0 } else { (1u64 << n) - 1 };
    ones(hi) & !ones(lo)
}

#[cfg(test)]
mod tests {
    use super::super::block::for_each_neighbour;
    use super::*;
    use crate::topology::{Side, border, escape};
    use crate::units::Length;

    fn random(seed: u64) -> impl FnMut(u64) -> u64 {
        let mut state = seed;
        move |n| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % n
        }
    }

    #[test]
    fn throats_are_the_escape_radii_and_regions_what_lies_above_them() {
        let mut below = random(5);
        for (round, dims) in [[9, 8, 7], [66, 5, 4], [130, 3, 3], [12, 12, 12]].into_iter().cycle().take(40).enumerate()
        {
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
            let levels = 3 + round as u64;
            let values: Vec<u32> = (0..grid.samples()).map(|_| below(levels + 3).saturating_sub(2) as u32).collect();
            let radii = Field::from_values(grid, values.iter().map(|&v| v as f32).collect(), 0.0).unwrap();
            let clearance = Field::from_values(grid, values.clone(), 0).unwrap();
            let exits = Indicator::from_predicate(grid, |at| at % 97 == 3);
            let truth = escape(&radii, &exits, 1e6, 0.0).unwrap().radius;
            for level in [1, 2, levels as u32 / 2 + 1, levels as u32] {
                let found = chambers(&clearance, &exits, level, |_| false).unwrap();
                // Of samples equally narrow either way of search may name another.
                let halved = chambers_above(&clearance, &exits, level, |_| false, 0).unwrap();
                let told = |c: &Chamber| (c.deepest, c.widest, c.throat.map(|t| t.clearance), c.region.clone());
                assert!(found.iter().map(told).eq(halved.iter().map(told)), "{found:?} {halved:?}");
                let mut owner = vec![usize::MAX; grid.samples()];
                for (c, chamber) in found.iter().enumerate() {
                    let way_out = chamber.throat.map_or(0, |t| t.clearance);
                    assert!(chamber.widest >= level && way_out < level);
                    assert_eq!(truth.values()[chamber.deepest], way_out as f32, "{dims:?} {level}");
                    for at in chamber.offsets() {
                        assert!(
                            owner[at] == usize::MAX && values[at] > way_out && truth.values()[at] == way_out as f32
                        );
                        owner[at] = c;
                    }
                    // Its throat touches it, and from there a way as wide leads out beside it.
                    if let Some(throat) = chamber.throat {
                        let mut touches = false;
                        for_each_neighbour(&grid, grid.index(throat.at), |n| touches |= owner[n] == c);
                        let way = Indicator::from_predicate(grid, |at| values[at] >= way_out && owner[at] != c);
                        let ways = components(&way, Adjacency::Corner);
                        let own = ways.of(grid.index(throat.at));
                        let leads_out = exits.iter().any(|at| own.is_some() && ways.of(grid.index(at)) == own);
                        assert!(touches && leads_out, "{dims:?} {level} {throat:?}");
                    }
                    // Closed under touching: what is wider than the throat and touches the region belongs to it.
                    for at in chamber.offsets() {
                        for_each_neighbour(&grid, grid.index(at), |n| {
                            assert!(values[n] <= way_out || owner[n] == c, "{at} {n}");
                        });
                    }
                }
                // Every sample as wide as the level from which nothing as wide gets out lies in a chamber.
                for at in (0..values.len()).filter(|&at| values[at] >= level) {
                    assert_eq!(truth.values()[at] < level as f32, owner[at] != usize::MAX, "{at}");
                }
            }
        }
    }

    #[test]
    fn what_is_known_is_left_out_and_nonsense_is_refused() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [5, 5, 5]).unwrap();
        let values = (0..125).map(|at| u32::from(at == 62 || at == 0)).collect();
        let field = Field::from_values(grid, values, 0).unwrap();
        let exits = border(&grid, &Side::ALL);
        let one = chambers(&field, &exits, 1, |_| false).unwrap();
        assert_eq!((one.len(), one[0].deepest, one[0].throat, one[0].samples()), (1, 62, None, 1));
        assert!(chambers(&field, &exits, 1, |at| at == 62).unwrap().is_empty());
        assert!(chambers(&field, &exits, 0, |_| false).is_err());
        let refused = chambers(&field, &exits, u32::MAX, |_| false).unwrap_err();
        assert_eq!(refused.code(), "E020");
        assert!(refused.to_string().contains("level 4294967295 needs 34.4 GB, allowed are 134.2 MB"), "{refused}");
    }
}
