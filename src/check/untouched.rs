//! The pieces of surface that no tool touches.

use crate::access::{Patch, Reach, State};
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, bounds};
use crate::grid::Grid;
use crate::part::Part;
use crate::topology::{Adjacency, components};
use crate::units::Length;
use std::collections::BTreeMap;

/// A connected piece of surface that cannot be touched.
pub(super) struct Region {
    /// Area that cannot be touched for certain, and what of its surroundings may not be, mm².
    pub area: f64,
    pub open: f64,
    /// The patch that the tools stop furthest short of.
    pub worst: usize,
    /// What cannot be touched for certain.
    pub patches: Vec<usize>,
    pub extent: (Vec3, Vec3),
}

/// The pieces of a surface.
pub(super) struct Pieces {
    /// Those that cannot be touched, largest first.
    pub regions: Vec<Region>,
    /// What may be touched or not and is beside none of them, by connected pieces, largest first.
    pub open: Vec<Vec<usize>>,
}

/// The cells of three spacings that hold the middles of patches.
fn cells_of(surface: &[Patch], some: impl Iterator<Item = usize>, grid: Grid) -> Indicator {
    let mut cells = Indicator::empty(grid);
    for p in some {
        grid.sample_at(surface[p].at).into_iter().for_each(|i| cells.set(i, true));
    }
    cells
}

/// Those of some patches whose cells touch, together; the largest pieces first.
fn connected(surface: &[Patch], some: &[usize], grid: Grid) -> Vec<Vec<usize>> {
    let joined = components(&cells_of(surface, some.iter().copied(), grid), Adjacency::Corner);
    let mut pieces: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for &p in some {
        let piece = grid.sample_at(surface[p].at).and_then(|index| joined.of(index));
        piece.into_iter().for_each(|c| pieces.entry(c).or_default().push(p));
    }
    let mut pieces: Vec<Vec<usize>> = pieces.into_values().collect();
    pieces.sort_by(|a, b| area_of(surface, b).total_cmp(&area_of(surface, a)).then(a.cmp(b)));
    pieces
}

/// The area of some patches, mm².
pub(super) fn area_of(surface: &[Patch], some: &[usize]) -> f64 {
    some.iter().map(|&p| surface[p].area).fold(0.0, |sum, area| sum + area)
}

/// The pieces: patches whose cells of three spacings touch are joined.
pub(super) fn pieces(surface: &[Patch], found: &Reach, part: &Part, spacing: f64) -> Result<Pieces> {
    let never = |p: &usize| found.states[*p] == State::Unreachable;
    let grid = Grid::covering([0.0; 3], part.extent(), Length::mm(3.0 * spacing), 1, [0.0; 3])?;
    let joined = components(&cells_of(surface, (0..surface.len()).filter(never), grid), Adjacency::Corner);
    let mut apart: Vec<usize> = Vec::new();
    let mut members: BTreeMap<u32, (Vec<usize>, f64)> = BTreeMap::new();
    for (p, patch) in surface.iter().enumerate() {
        let Some(index) = grid.sample_at(patch.at) else { continue };
        match found.states[p] {
            State::Unreachable => {
                joined.of(index).into_iter().for_each(|c| members.entry(c).or_default().0.push(p));
            }
            State::Open | State::Near(_) => {
                let near = (0..27).find_map(|n| {
                    let step = [n % 3, n / 3 % 3, n / 9].map(|s| s as isize - 1);
                    let i = [0, 1, 2].map(|a| index[a].checked_add_signed(step[a]));
                    let [Some(i), Some(j), Some(k)] = i else { return None };
                    joined.of([i, j, k])
                });
                match near {
                    Some(c) => members.entry(c).or_default().1 += patch.area,
                    None => apart.push(p),
                }
            }
            State::Reached(_) => {}
        }
    }
    let short = |p: usize| found.stops(p).map_or(f64::INFINITY, |s| s.0);
    let mut list: Vec<Region> = members
        .into_values()
        .filter_map(|(patches, open)| {
            let worst = patches.iter().copied().max_by(|a, b| short(*a).total_cmp(&short(*b)).then(b.cmp(a)))?;
            let extent = bounds(patches.iter().map(|&p| surface[p].at))?;
            Some(Region { area: patches.iter().map(|&p| surface[p].area).sum(), open, worst, patches, extent })
        })
        .collect();
    list.sort_by(|a, b| b.area.total_cmp(&a.area).then(a.worst.cmp(&b.worst)));
    Ok(Pieces { regions: list, open: connected(surface, &apart, grid) })
}

/// Several pieces as one.
pub(super) fn gathered(rest: &[Region]) -> Option<Region> {
    let first = rest.first()?;
    let (lo, hi) = bounds(rest.iter().flat_map(|r| [r.extent.0, r.extent.1]))?;
    let sum = |of: fn(&Region) -> f64| rest.iter().map(of).sum();
    let patches = rest.iter().flat_map(|r| r.patches.iter().copied()).collect();
    Some(Region { area: sum(|r| r.area), open: sum(|r| r.open), worst: first.worst, patches, extent: (lo, hi) })
}
