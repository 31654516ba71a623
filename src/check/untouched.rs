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
    /// Area that cannot be touched for certain, and what of its surroundings is open, mm².
    pub area: f64,
    pub open: f64,
    /// The patch that the tools stop furthest short of.
    pub worst: usize,
    /// What cannot be touched for certain.
    pub patches: Vec<usize>,
    pub extent: (Vec3, Vec3),
}

/// The pieces, largest first: patches whose cells of three spacings touch are joined.
pub(super) fn regions(surface: &[Patch], found: &Reach, part: &Part, spacing: f64) -> Result<Vec<Region>> {
    let never = |p: &usize| found.states[*p] == State::Unreachable;
    let grid = Grid::covering([0.0; 3], part.extent(), Length::mm(3.0 * spacing), 1, [0.0; 3])?;
    let mut cells = Indicator::empty(grid);
    for p in (0..surface.len()).filter(never) {
        grid.sample_at(surface[p].at).into_iter().for_each(|i| cells.set(i, true));
    }
    let joined = components(&cells, Adjacency::Corner);
    let mut members: BTreeMap<u32, (Vec<usize>, f64)> = BTreeMap::new();
    for (p, patch) in surface.iter().enumerate() {
        let Some(index) = grid.sample_at(patch.at) else { continue };
        match found.states[p] {
            State::Unreachable => {
                joined.of(index).into_iter().for_each(|c| members.entry(c).or_default().0.push(p));
            }
            State::Open => {
                let near = (0..27).find_map(|n| {
                    let step = [n % 3, n / 3 % 3, n / 9].map(|s| s as isize - 1);
                    let i = [0, 1, 2].map(|a| index[a].checked_add_signed(step[a]));
                    let [Some(i), Some(j), Some(k)] = i else { return None };
                    joined.of([i, j, k])
                });
                near.into_iter().for_each(|c| members.entry(c).or_default().1 += patch.area);
            }
            State::Reached { .. } => {}
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
    Ok(list)
}

/// Several pieces as one.
pub(super) fn gathered(rest: &[Region]) -> Option<Region> {
    let first = rest.first()?;
    let (lo, hi) = bounds(rest.iter().flat_map(|r| [r.extent.0, r.extent.1]))?;
    let sum = |of: fn(&Region) -> f64| rest.iter().map(of).sum();
    let patches = rest.iter().flat_map(|r| r.patches.iter().copied()).collect();
    Some(Region { area: sum(|r| r.area), open: sum(|r| r.open), worst: first.worst, patches, extent: (lo, hi) })
}
