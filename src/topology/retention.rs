//! What a void holds under gravity: every sample whose ways out all lead over a higher place.

use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::geometry::DisjointSets;
use crate::geometry::vector::{norm, unit};

/// Which way liquid falls, along the third axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Falls {
    /// To lower layers.
    Down,
    /// To higher layers: the part hangs upside down.
    Up,
}

/// Which cubes let liquid through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Passage {
    /// Through faces only: nothing passes that cannot.
    Faces,
    /// Through corners too: everything passes that can.
    Corners,
}

/// The samples of a void that keep liquid: L(x) > height of x, with L(x) = min over paths from x to the border of the
/// grid of the greatest height on the path; heights are layers.
///
/// A void whose every path out rises keeps what is in it; liquid may stand at any height, so sealed voids belong here.
/// Read the other way round, these are the samples that are cut off from the outside when everything beyond their own layer
/// is not there yet: cups on a film.
///
/// # Errors
/// [`Error::TooLarge`] beyond 2^32 runs.
///
/// # Cost
/// One union-find over runs along x, layer by layer: O(samples/64 + runs).
///
/// # Source
/// Priority flood (R. Barnes, C. Lehman, D. Mulla, Priority-flood, 2014) with a bucket for each layer.
pub fn retained(void: &Indicator, falls: Falls, passage: Passage) -> Result<Indicator> {
    let [nx, ny, nz] = void.grid().dims();
    let mut out = Indicator::empty(*void.grid());
    let mut sea = Sea { forest: DisjointSets::new(0), out: Vec::new(), reach: u32::from(passage == Passage::Corners) };
    let mut before: Vec<Vec<Run>> = vec![Vec::new(); ny];
    for step in 0..nz {
        let k = if falls == Falls::Down { step } else { nz - 1 - step };
        let mut layer: Vec<Vec<Run>> = Vec::with_capacity(ny);
        for j in 0..ny {
            let outermost = j == 0 || j + 1 == ny || k == 0 || k + 1 == nz;
            let runs = runs_of(void.row(j, k), nx)
                .map(|(from, to)| sea.added(from, to, outermost || from == 0 || to as usize == nx))
                .collect::<Result<Vec<Run>>>()?;
            let beside = if passage == Passage::Corners { 1 } else { 0 };
            for other in before.iter().take(j + beside + 1).skip(j.saturating_sub(beside)) {
                sea.join(other, &runs);
            }
            if j > 0 {
                sea.join(&layer[j - 1], &runs);
            }
            layer.push(runs);
        }
        for (j, runs) in layer.iter().enumerate() {
            for run in runs.iter().filter(|r| !sea.leads_out(r.set)) {
                (run.from..run.to).for_each(|i| out.set([i as usize, j, k], true));
            }
        }
        before = layer;
    }
    Ok(out)
}

/// As [`retained`] with liquid that falls towards a direction, through faces: heights are −x·direction, at a resolution
/// of one sample. Only where the direction points matters, not its length.
///
/// # Errors
/// [`Error::Operand`] for a direction that is zero or not finite.
///
/// # Cost
/// O(samples) with a bucket for each height; meant for coarse grids and lists of directions.
pub fn retained_towards(void: &Indicator, direction: [f64; 3]) -> Result<Indicator> {
    let direction = of_length_one(direction)?;
    let grid = *void.grid();
    let dims = grid.dims();
    let height = |p: [usize; 3]| (0..3).map(|a| -direction[a] * p[a] as f64).sum::<f64>();
    let corners = (0..8usize).map(|c| height([0, 1, 2].map(|a| if c >> a & 1 == 1 { dims[a] - 1 } else { 0 })));
    let least = corners.fold(f64::INFINITY, f64::min);
    let bucket = |p: [usize; 3]| (height(p) - least).max(0.0) as usize;
    let mut buckets: Vec<Vec<usize>> = vec![Vec::new(); dims.iter().sum::<usize>() + 2];
    let mut seen = Indicator::empty(grid);
    for at in void.iter() {
        let p = grid.index(at);
        if (0..3).any(|a| p[a] == 0 || p[a] + 1 == dims[a]) {
            seen.set(p, true);
            buckets[bucket(p)].push(at);
        }
    }
    let mut kept = void.clone();
    for level in 0..buckets.len() {
        while let Some(at) = buckets[level].pop() {
            let p = grid.index(at);
            // Reached at its own height, or only from above.
            if bucket(p) == level {
                kept.set(p, false);
            }
            for (axis, up) in (0..3).flat_map(|a| [(a, true), (a, false)]) {
                let mut q = p;
                q[axis] = if up { p[axis] + 1 } else { p[axis].wrapping_sub(1) };
                if q[axis] < dims[axis] && void.contains(q) && !seen.contains(q) {
                    seen.set(q, true);
                    buckets[bucket(q).max(level)].push(grid.offset(q));
                }
            }
        }
    }
    Ok(kept)
}

/// A direction as a unit vector; one that is such a vector already stays what it is to the last digit.
fn of_length_one(direction: [f64; 3]) -> Result<[f64; 3]> {
    // By its greatest coordinate first, whose square is finite then and not 0.
    let most = direction.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    if !(most > 0.0 && direction.iter().all(|c| c.is_finite())) {
        return Err(Error::Operand {
            operation: "liquid that falls",
            problem: format!("{direction:?} points nowhere"),
            remedy: "give a direction with a finite coordinate that is not 0".into(),
        });
    }
    if (norm(direction) - 1.0).abs() < 1e-9 { Ok(direction) } else { Ok(unit(direction.map(|c| c / most))) }
}

/// A stretch of void along x and its set.
#[derive(Debug, Clone, Copy)]
struct Run {
    from: u32,
    to: u32,
    set: u32,
}

/// Sets of runs, and which hold one at the border.
struct Sea {
    forest: DisjointSets,
    out: Vec<bool>,
    /// How far beyond its ends a run touches others.
    reach: u32,
}

impl Sea {
    fn added(&mut self, from: u32, to: u32, leads_out: bool) -> Result<Run> {
        let set = u32::try_from(self.out.len()).map_err(|_| Error::TooLarge {
            what: "the layers of a void".into(),
            need_bytes: 1 << 36,
            allowed_bytes: 1 << 35,
            remedy: "choose a larger spacing".into(),
        })?;
        self.forest.grow();
        self.out.push(leads_out);
        Ok(Run { from, to, set })
    }

    fn join(&mut self, a: &[Run], b: &[Run]) {
        let (mut i, mut j) = (0, 0);
        while i < a.len() && j < b.len() {
            let (p, q) = (a[i], b[j]);
            if p.from < q.to + self.reach && q.from < p.to + self.reach {
                let out = self.leads_out(p.set) || self.leads_out(q.set);
                let root = self.forest.join(p.set, q.set);
                self.out[root as usize] = out;
            }
            if p.to < q.to { i += 1 } else { j += 1 }
        }
    }

    fn leads_out(&mut self, set: u32) -> bool {
        let root = self.forest.root(set);
        self.out[root as usize]
    }
}

/// First and one past last of each stretch of ones.
fn runs_of(bits: &[u64], nx: usize) -> impl Iterator<Item = (u32, u32)> + '_ {
    let mut at = 0usize;
    std::iter::from_fn(move || {
        let from = next(bits, nx, at, 0)?;
        let to = next(bits, nx, from, !0).unwrap_or(nx);
        at = to;
        Some((from as u32, to as u32))
    })
}

/// The next sample from `at` whose bit differs from those of `not`.
fn next(bits: &[u64], nx: usize, at: usize, not: u64) -> Option<usize> {
    let mut w = at / 64;
    let mut word = (bits.get(w)? ^ not) & (!0u64).checked_shl((at % 64) as u32).unwrap_or(0);
    loop {
        if word != 0 {
            let found = 64 * w + word.trailing_zeros() as usize;
            return (found < nx).then_some(found);
        }
        w += 1;
        word = bits.get(w)? ^ not;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::units::Length;

    /// Least greatest layer on a path to the border, by relaxing until nothing changes.
    fn brute(void: &Indicator, falls: Falls, passage: Passage) -> Indicator {
        let grid = *void.grid();
        let [nx, ny, nz] = grid.dims();
        let height = |k: usize| if falls == Falls::Down { k } else { nz - 1 - k };
        let edge = |p: [usize; 3]| (0..3).any(|a| p[a] == 0 || p[a] + 1 == grid.dims()[a]);
        let mut level = vec![usize::MAX; grid.samples()];
        loop {
            let before = level.clone();
            for at in void.iter() {
                let p = grid.index(at);
                let mut best = if edge(p) { 0 } else { usize::MAX };
                for n in 0..27usize {
                    let d = [n % 3, n / 3 % 3, n / 9];
                    let steps = d.iter().filter(|c| **c != 1).count();
                    let q = [0, 1, 2].map(|a| (p[a] + d[a]).wrapping_sub(1));
                    if (passage == Passage::Corners || steps == 1)
                        && q[0] < nx
                        && q[1] < ny
                        && q[2] < nz
                        && void.contains(q)
                    {
                        best = best.min(level[grid.offset(q)]);
                    }
                }
                if best < usize::MAX {
                    level[at] = level[at].min(best.max(height(p[2])));
                }
            }
            if level == before {
                return Indicator::from_predicate(grid, |at| {
                    let p = grid.index(at);
                    void.contains(p) && level[at] > height(p[2])
                });
            }
        }
    }

    #[test]
    fn what_is_kept_is_what_every_way_out_rises_from() {
        let mut state = 3u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % n
        };
        for dims in [[7, 6, 8], [66, 4, 5], [130, 3, 4], [12, 12, 12]] {
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
            for percent in [20, 40, 55, 70] {
                let bits: Vec<bool> = (0..grid.samples()).map(|_| below(100) < percent).collect();
                let void = Indicator::from_predicate(grid, |at| bits[at]);
                for falls in [Falls::Down, Falls::Up] {
                    for passage in [Passage::Faces, Passage::Corners] {
                        assert_eq!(
                            retained(&void, falls, passage).unwrap(),
                            brute(&void, falls, passage),
                            "{dims:?} {percent}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn along_the_axis_any_direction_keeps_the_same() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [20, 18, 16]).unwrap();
        let void = Indicator::from_predicate(grid, |at| (at * 2654435761) >> 9 & 7 < 4);
        for (falls, z) in [(Falls::Down, -1.0), (Falls::Up, 1.0)] {
            assert_eq!(
                retained_towards(&void, [0.0, 0.0, z]).unwrap(),
                retained(&void, falls, Passage::Faces).unwrap()
            );
        }
        let bowl = Indicator::from_predicate(grid, |at| {
            let [i, j, k] = grid.index(at);
            let block = (1..19).contains(&i) && (1..17).contains(&j) && (1..15).contains(&k);
            !block || ((4..16).contains(&i) && (4..14).contains(&j) && k >= 4)
        });
        let kept = |d: [f64; 3]| retained_towards(&bowl, d).unwrap().count();
        assert_eq!((kept([0.0, 0.0, -1.0]), kept([0.0, 0.0, 1.0]), kept([1.0, 0.0, 0.0])), (12 * 10 * 11, 0, 0));
        assert!(kept([0.7, 0.0, -0.7]) < 12 * 10 * 11);
        for scale in [1e-300, 0.01, 30.0, 1e300] {
            let far = [0.2 * scale, 0.3 * scale, -0.9 * scale];
            assert_eq!(retained_towards(&bowl, far).unwrap(), retained_towards(&bowl, [0.2, 0.3, -0.9]).unwrap());
        }
        for nowhere in [[0.0; 3], [0.0, f64::NAN, -1.0], [0.0, 0.0, f64::NEG_INFINITY]] {
            assert!(matches!(retained_towards(&bowl, nowhere), Err(Error::Operand { .. })), "{nowhere:?}");
        }
    }

    #[test]
    fn a_bowl_with_a_spout_is_filled_up_to_the_spout() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [9, 9, 9]).unwrap();
        let void = Indicator::from_predicate(grid, |at| {
            let [i, j, k] = grid.index(at);
            let inside = (3..6).contains(&i) && (3..6).contains(&j) && k >= 3;
            let block = (1..8).contains(&i) && (1..8).contains(&j) && (1..8).contains(&k);
            !block || inside || (i < 4 && j == 4 && k == 5)
        });
        assert_eq!(retained(&void, Falls::Down, Passage::Faces).unwrap().count(), 2 * 9);
        assert_eq!(retained(&void, Falls::Up, Passage::Faces).unwrap().count(), 0);
    }
}
