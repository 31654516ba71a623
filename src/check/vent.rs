//! A straight vent for a trapped volume, drilled into the sets and looked at again before it is suggested.

use super::void::{HALF_DIAGONAL, Trapped};
use crate::distance::squared_distance;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::Solid;
use crate::geometry::vector::{Vec3, along, distance, dot, sub};
use crate::topology::{Adjacency, Side, border, components};
use crate::units::short;

/// A channel along an axis from a trapped place to the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vent {
    pub from: Vec3,
    pub to: Vec3,
    /// 0, 1, 2 for x, y, z; the sign tells which way.
    pub axis: usize,
    pub upward: bool,
    pub diameter_mm: f64,
    /// Length of the material on its axis.
    pub wall_mm: f64,
}

impl Vent {
    /// In words: `a straight vent of 4 mm towards +z through 3.2 mm of material`.
    pub fn words(&self) -> String {
        let sign = if self.upward { '+' } else { '-' };
        format!(
            "a straight vent of {} mm towards {sign}{} through {} mm of material",
            short(self.diameter_mm),
            ["x", "y", "z"][self.axis],
            short((self.wall_mm * 10.0).round() / 10.0)
        )
    }
}

/// The shortest of the straight vents along the axes that end outside; `floor` forbids the one through the plate.
///
/// The diameter is the least multiple of half a millimetre that is wider than `wanted_mm` by two samples, because the
/// sets know it only so well.
pub(super) fn shortest_vent(solid: &Solid, at: Vec3, wanted_mm: f64, floor: Option<f64>) -> Option<Vent> {
    let grid = solid.centres.grid();
    let start = grid.sample_at(at)?;
    let diameter_mm = ((wanted_mm + 2.0 * grid.h()) * 2.0).ceil() / 2.0;
    let mut best: Option<Vent> = None;
    for axis in 0..3 {
        for upward in [true, false] {
            if axis == 2 && !upward && floor.is_some() {
                continue;
            }
            let last = grid.dims()[axis] - 1;
            let end = if upward { last } else { 0 };
            let mut index = start;
            let mut wall = 0u64;
            while index[axis] != end {
                index[axis] = if upward { index[axis] + 1 } else { index[axis] - 1 };
                wall += u64::from(solid.centres.contains(index));
            }
            let wall_mm = wall as f64 * grid.h();
            if wall > 0 && best.is_none_or(|b| wall_mm < b.wall_mm - 1e-9) {
                best = Some(Vent { from: at, to: grid.position(index), axis, upward, diameter_mm, wall_mm });
            }
        }
    }
    best
}

/// Which of the vents work, all drilled at once: through each, a ball of `ball_mm` gets from its place to the outside
/// (with 0: the place is joined to the outside by free cubes).
///
/// A cube is taken away only if all of it lies in the channel, so what works here works in the part.
pub(super) fn working(solid: &Solid, vents: &[Vent], ball_mm: f64) -> Result<Vec<bool>> {
    let grid = *solid.outer.grid();
    let outer = drilled(&solid.outer, vents);
    let exits = border(&grid, &Side::ALL);
    let (free, adjacency) = if ball_mm > 0.0 {
        // The bracket of a way out is as wide as four half diagonals; its middle is compared.
        let level = (0.5 * ball_mm / grid.h()).powi(2).ceil() as u32;
        let clearance = squared_distance(&outer)?;
        (Indicator::from_predicate(grid, |at| clearance.values()[at] >= level.max(1)), Adjacency::Corner)
    } else {
        (outer.complement(), Adjacency::Face)
    };
    let parts = components(&free, adjacency);
    let mut open = vec![false; parts.count()];
    exits.intersection(&free)?.iter().filter_map(|at| parts.of(grid.index(at))).for_each(|l| open[l as usize] = true);
    let works = |v: &Vent| grid.sample_at(v.from).and_then(|i| parts.of(i)).is_some_and(|l| open[l as usize]);
    Ok(vents.iter().map(works).collect())
}

/// The outer set without the cubes that lie wholly in a vent.
pub(super) fn drilled(outer: &Indicator, vents: &[Vent]) -> Indicator {
    let mut left = outer.clone();
    for vent in vents {
        let radius = 0.5 * vent.diameter_mm - HALF_DIAGONAL * outer.grid().h();
        drill(&mut left, vent, radius);
    }
    left
}

/// Takes away the cubes whose centres lie within a radius of the axis.
fn drill(set: &mut Indicator, vent: &Vent, radius: f64) {
    let grid = *set.grid();
    let clamped = |p: Vec3, a: usize, by: f64| {
        ((p[a] + by - grid.origin()[a]) / grid.h()).clamp(0.0, grid.dims()[a] as f64 - 1.0) as usize
    };
    let (lo, hi) = ([0, 1, 2].map(|a| vent.from[a].min(vent.to[a])), [0, 1, 2].map(|a| vent.from[a].max(vent.to[a])));
    let first = [0, 1, 2].map(|a| clamped(lo, a, -radius));
    let last = [0, 1, 2].map(|a| clamped(hi, a, radius + grid.h()));
    let length = distance(vent.from, vent.to).max(1e-9);
    let axis = sub(vent.to, vent.from).map(|c| c / length);
    for k in first[2]..=last[2] {
        for j in first[1]..=last[1] {
            for i in first[0]..=last[0] {
                let p = grid.position([i, j, k]);
                let s = dot(sub(p, vent.from), axis).clamp(0.0, length);
                if distance(p, along(vent.from, axis, s)) <= radius {
                    set.set([i, j, k], false);
                }
            }
        }
    }
}

/// For each place its shortest vent, where that works when looked at again.
pub(super) fn vents(
    solid: &Solid,
    places: &[&Trapped],
    wanted_mm: f64,
    floor: Option<f64>,
) -> Result<Vec<Option<Vent>>> {
    let found: Vec<Option<Vent>> = places.iter().map(|t| shortest_vent(solid, t.at, wanted_mm, floor)).collect();
    let drilled: Vec<Vent> = found.iter().flatten().copied().collect();
    if drilled.is_empty() {
        return Ok(found);
    }
    let works = working(solid, &drilled, wanted_mm)?;
    let mut answers = works.into_iter();
    Ok(found.into_iter().map(|v| v.filter(|_| answers.next().unwrap_or(false))).collect())
}
