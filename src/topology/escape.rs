//! How wide the way out of a void is: one sweep over a clearance field in decreasing order.

use super::block::{Block, for_each_neighbour, shifted};
use super::components::{Adjacency, components};
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use crate::geometry::DisjointSets;
use crate::grid::Grid;
use rayon::prelude::*;

/// No entry of a table.
const NONE: u32 = u32::MAX;

/// A part of the void that is joined to the outside only through a throat narrower than itself, or not at all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pocket {
    /// Radius of the largest ball that can leave, millimetres; 0 if the pocket is sealed.
    pub escape_radius_mm: f32,
    /// Radius of the largest ball that fits inside (cut off at the cap), millimetres, and where.
    pub widest_radius_mm: f32,
    /// The sample in the middle of that ball, as a storage offset.
    pub deepest: usize,
    /// The sample in the throat, as a storage offset; `None` if the pocket is sealed.
    pub throat: Option<usize>,
    /// Samples of the pocket: those wider than the throat, and those from which ever wider samples lead there.
    pub samples: u64,
}

impl Pocket {
    /// Whether no path leads outside.
    pub fn is_sealed(&self) -> bool {
        self.throat.is_none()
    }
}

/// The way out of every sample of a void.
#[derive(Debug, Clone, PartialEq)]
pub struct Escape {
    /// w(x) = max over paths from x to an exit of the least clearance on the path, millimetres, cut off at the cap:
    /// the radius of the largest ball that starts in x and gets out. 0 in material and where no path leads out.
    pub radius: Field<f32>,
    /// The pockets, largest first; of equal ones the first in storage.
    pub pockets: Vec<Pocket>,
}

/// The escape radius of every sample of a void, and its pockets.
///
/// `clearance` is the distance to the material in millimetres, positive in the void and 0 or less in the material.
/// `exits` are the samples that count as outside, as a rule the border of the grid without the side that stands on the
/// plate. Ways wider than `cap_mm` are not told apart. Neighbours are the 26 around a sample.
///
/// A pocket is a maximal connected set of samples that join the outside only through a sample narrower than all of them; it is
/// reported if its widest ball exceeds its throat by more than `least_rise_mm` (distances between samples are rough
/// on the scale of the spacing, and every dent is a pocket of some tiny rise).
///
/// With the exact distance δ to the mesh at the samples the radius is within (√3/2)·h of the true one; with distances
/// between samples within √3·h.
///
/// # Errors
/// [`Error::Operand`] if the grids differ or the cap is not positive; [`Error::TooLarge`] beyond 2^32 samples.
///
/// # Cost
/// O(N log N) for N samples of the void narrower than the cap; about 20 bytes for each and 8 for each of the grid.
///
/// # Source
/// Merge tree by union-find in order of the function (Carr, Snoeyink, Axen 2003), read as a widest-path problem.
pub fn escape(clearance: &Field<f32>, exits: &Indicator, cap_mm: f32, least_rise_mm: f32) -> Result<Escape> {
    let grid = *clearance.grid();
    let bad = |problem: String| Error::Operand {
        operation: "escape",
        problem,
        remedy: "give clearance and exits on one grid, and a positive cap".into(),
    };
    if exits.grid() != &grid {
        return Err(bad("clearance and exits stand on different grids".into()));
    }
    if cap_mm.is_nan() || cap_mm <= 0.0 {
        return Err(bad(format!("the cap is {cap_mm} mm")));
    }
    if grid.samples() >= NONE as usize {
        return Err(Error::TooLarge {
            what: "the sweep over a void".into(),
            need_bytes: 24 * grid.samples() as u128,
            allowed_bytes: 24 * u128::from(NONE),
            remedy: "choose a larger spacing, or look at a window of the part".into(),
        });
    }
    let values = clearance.values();
    let open = open_space(values, exits, cap_mm);
    let order = decreasing(values, &open, cap_mm);
    let tree = MergeTree::grow(&grid, &order, &open, exits);
    Ok(tree.read(grid, values, &order, &open, cap_mm, least_rise_mm))
}

/// The samples at least `cap` wide that are joined to an exit by samples as wide.
fn open_space(values: &[f32], exits: &Indicator, cap: f32) -> Indicator {
    let wide = Indicator::from_predicate(*exits.grid(), |at| values[at] >= cap);
    let rooms = components(&wide, Adjacency::Corner);
    let mut leads_out = vec![false; rooms.count()];
    for at in exits.iter() {
        if let Some(room) = rooms.of(exits.grid().index(at)) {
            leads_out[room as usize] = true;
        }
    }
    rooms.select(|room| leads_out[room as usize])
}

/// The other samples of the void, widest first, of equal ones the first in storage.
fn decreasing(values: &[f32], open: &Indicator, cap: f32) -> Vec<u32> {
    let nx = open.grid().dims()[0];
    let words = open.words_per_row();
    let mut keys: Vec<u64> = values
        .par_chunks(nx)
        .zip(open.words().par_chunks(words))
        .enumerate()
        .flat_map_iter(|(row, (values, open))| {
            values.iter().enumerate().filter(|(i, v)| **v > 0.0 && open[i / 64] >> (i % 64) & 1 == 0).map(
                move |(i, v)| {
                    // Positive floats are ordered like their bits.
                    u64::from(!v.min(cap).to_bits()) << 32 | (row * nx + i) as u64
                },
            )
        })
        .collect();
    keys.par_sort_unstable();
    keys.into_iter().map(|key| key as u32).collect()
}

/// Samples by rank (widest first), each below the narrower sample at which its set joined others.
struct MergeTree {
    /// Rank of the sample that joined the set of this one to others; `NONE` for the last of a set.
    parent: Vec<u32>,
    /// Whether the set that this sample completes holds an exit or touches the open space.
    leads_out: Vec<bool>,
}

impl MergeTree {
    fn grow(grid: &Grid, order: &[u32], open: &Indicator, exits: &Indicator) -> Self {
        let n = order.len();
        let mut rank = vec![NONE; grid.samples()];
        let mut done = Indicator::empty(*grid);
        let mut tree = MergeTree { parent: vec![NONE; n], leads_out: vec![false; n] };
        // The root of a set is its oldest member, which new ones are hung on at once; `newest` is the root of its tree.
        let mut forest = DisjointSets::new(n);
        let mut newest: Vec<u32> = (0..n as u32).collect();
        for (r, &at) in order.iter().enumerate() {
            let index = grid.index(at as usize);
            let mut leads_out = exits.contains(index) || Block::about(open, index).bits != 0;
            // Neighbours that touch one another are one set already: one of each cluster will do.
            let mut rest = Block::about(&done, index);
            while let Some((step, others)) = rest.next_cluster() {
                let near = shifted(grid, index, step);
                let root = forest.root(rank[near]);
                let child = newest[root as usize] as usize;
                if child != r {
                    tree.parent[child] = r as u32;
                    leads_out |= tree.leads_out[child];
                    let root = forest.join(root, r as u32);
                    newest[root as usize] = r as u32;
                }
                rest = others;
            }
            tree.leads_out[r] = leads_out;
            rank[at as usize] = r as u32;
            done.set(index, true);
        }
        tree
    }

    /// Radii from the narrow end of the tree to the wide one, then the pockets.
    fn read(&self, grid: Grid, values: &[f32], order: &[u32], open: &Indicator, cap: f32, least_rise: f32) -> Escape {
        let n = order.len();
        let clearance = |r: usize| values[order[r] as usize].min(cap);
        let mut radius = Field::constant(grid, 0.0f32);
        let out = radius.values_mut();
        open.iter().for_each(|at| out[at] = cap);
        // A pocket ends where its set joins one that leads out, or never.
        let mut pocket_of = vec![NONE; n];
        let mut throats: Vec<u32> = Vec::new();
        for r in (0..n).rev() {
            let parent = self.parent[r];
            out[order[r] as usize] = match parent {
                _ if self.leads_out[r] => clearance(r),
                NONE => 0.0,
                parent => out[order[parent as usize] as usize],
            };
            if !self.leads_out[r] {
                let ends = parent == NONE || self.leads_out[parent as usize];
                pocket_of[r] = if ends { throats.len() as u32 } else { pocket_of[parent as usize] };
                if ends {
                    throats.push(parent);
                }
            }
        }
        let mut pockets = self.measure(&throats, &mut pocket_of, &clearance, order, least_rise);
        catch(&grid, values, order, &pocket_of, &mut pockets);
        pockets.sort_by_key(|pocket| (std::cmp::Reverse(pocket.samples), pocket.deepest));
        Escape { radius, pockets }
    }

    /// The pockets that rise enough, and renumbers their samples; the others' samples belong to none.
    fn measure(
        &self,
        throats: &[u32],
        pocket_of: &mut [u32],
        clearance: &impl Fn(usize) -> f32,
        order: &[u32],
        least_rise: f32,
    ) -> Vec<Pocket> {
        let mut number = vec![None; throats.len()];
        let mut pockets = Vec::new();
        for (r, pocket) in pocket_of.iter_mut().enumerate().filter(|(_, pocket)| **pocket != NONE) {
            let throat = throats[*pocket as usize];
            // The first sample met is the widest.
            let known = number[*pocket as usize].get_or_insert_with(|| {
                let escape = if throat == NONE { 0.0 } else { clearance(throat as usize) };
                if clearance(r) - escape <= least_rise {
                    return NONE;
                }
                pockets.push(Pocket {
                    escape_radius_mm: escape,
                    widest_radius_mm: clearance(r),
                    deepest: order[r] as usize,
                    throat: (throat != NONE).then(|| order[throat as usize] as usize),
                    samples: 0,
                });
                pockets.len() as u32 - 1
            });
            *pocket = *known;
        }
        pockets
    }
}

/// Counts the samples of each pocket, and those outside all pockets whose widest neighbour belongs to one.
fn catch(grid: &Grid, values: &[f32], order: &[u32], pocket_of: &[u32], pockets: &mut [Pocket]) {
    if pockets.is_empty() {
        return;
    }
    let mut owner = vec![NONE; grid.samples()];
    let mut owned = Indicator::empty(*grid);
    for (r, &at) in order.iter().enumerate() {
        let index = grid.index(at as usize);
        let mut pocket = pocket_of[r];
        if pocket == NONE && Block::about(&owned, index).bits != 0 {
            let mut widest = at as usize;
            for_each_neighbour(grid, index, |near| {
                if values[near] > values[widest] || (values[near] == values[widest] && near < widest) {
                    widest = near;
                }
            });
            pocket = owner[widest];
        }
        if let Some(found) = pockets.get_mut(pocket as usize) {
            found.samples += 1;
            owner[at as usize] = pocket;
            owned.set(index, true);
        }
    }
}

/// The samples of the grid's border on the sides given, as exits for [`escape`]: an axis and whether its low or high end.
///
/// ```
/// use amcheck::{grid::Grid, topology::{Side, border}, units::Length};
/// let grid = Grid::new([0.0; 3], Length::mm(1.0), [4, 3, 2])?;
/// assert_eq!(border(&grid, &[Side::Low(0), Side::High(2)]).count(), 6 + 12 - 3);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn border(grid: &Grid, sides: &[Side]) -> Indicator {
    let [nx, ny, nz] = grid.dims();
    let ends = |side: &Side, axis: usize, c: usize| match *side {
        Side::Low(a) => a == axis && c == 0,
        Side::High(a) => a == axis && c + 1 == grid.dims()[axis],
    };
    let mut set = Indicator::empty(*grid);
    for (j, k) in (0..nz).flat_map(|k| (0..ny).map(move |j| (j, k))) {
        if sides.iter().any(|s| ends(s, 1, j) || ends(s, 2, k)) {
            (0..nx).for_each(|i| set.set([i, j, k], true));
        } else {
            [0, nx - 1]
                .into_iter()
                .filter(|&i| sides.iter().any(|s| ends(s, 0, i)))
                .for_each(|i| set.set([i, j, k], true));
        }
    }
    set
}

/// An end of the grid along an axis (0, 1, 2 for x, y, z).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The end with the least coordinate.
    Low(usize),
    /// The end with the greatest coordinate.
    High(usize),
}

impl Side {
    /// All six sides.
    pub const ALL: [Side; 6] = [Side::Low(0), Side::High(0), Side::Low(1), Side::High(1), Side::Low(2), Side::High(2)];
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distance::squared_distance;
    use crate::units::Length;

    /// Widest paths by relaxing all neighbours until nothing changes.
    fn brute(clearance: &Field<f32>, exits: &Indicator, cap: f32) -> Vec<f32> {
        let grid = clearance.grid();
        let own = |at: usize| clearance.values()[at].clamp(0.0, cap);
        let mut w: Vec<f32> =
            (0..grid.samples()).map(|at| if exits.contains(grid.index(at)) { own(at) } else { 0.0 }).collect();
        loop {
            let before = w.clone();
            for at in 0..w.len() {
                for_each_neighbour(grid, grid.index(at), |near| w[at] = w[at].max(w[near].min(own(at))));
            }
            if w == before {
                return w;
            }
        }
    }

    #[test]
    fn radii_are_widest_paths() {
        let mut state = 6u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % n
        };
        for dims in [[1, 1, 1], [12, 1, 1], [9, 8, 7], [66, 4, 3]] {
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
            for (levels, cap) in [(4, 9.0), (4, 2.0), (1000, 600.0)] {
                let values = (0..grid.samples()).map(|_| (below(levels + 2) as f32 - 2.0).max(0.0)).collect();
                let clearance = Field::from_values(grid, values, 0.0).unwrap();
                let exits = Indicator::from_predicate(grid, |at| at % 29 == 3);
                let found = escape(&clearance, &exits, cap, 0.0).unwrap();
                assert_eq!(found.radius.values(), brute(&clearance, &exits, cap), "{dims:?} {levels} {cap}");
            }
        }
    }

    /// A room of 11×11×11 in a block, with a neck of 3×3, and a sealed room of 5×5×5.
    fn flask() -> Field<f32> {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [40, 17, 17]).unwrap();
        let void = Indicator::from_predicate(grid, |at| {
            let [i, j, k] = grid.index(at);
            let within = |lo: usize, hi: usize| (lo..hi).contains(&j) && (lo..hi).contains(&k);
            ((3..14).contains(&i) && within(3, 14))
                || (i < 3 && within(7, 10))
                || ((20..25).contains(&i) && within(6, 11))
                || i >= 30
        });
        let d2 = squared_distance(&void.complement()).unwrap();
        let values = d2.values().iter().map(|&d2| (d2 as f32).sqrt()).collect();
        Field::from_values(grid, values, 0.0).unwrap()
    }

    #[test]
    fn a_flask_is_as_open_as_its_neck_and_a_bubble_is_sealed() {
        let clearance = flask();
        let grid = *clearance.grid();
        let found = escape(&clearance, &border(&grid, &Side::ALL), 50.0, 0.9).unwrap();
        let [flask, bubble] = found.pockets[..] else { panic!("{:?}", found.pockets) };
        // The middle of an 11-sample room is 6 from the nearest sample of material, of a 3-sample neck 2.
        assert_eq!((flask.widest_radius_mm, flask.escape_radius_mm), (6.0, 2.0));
        assert_eq!(grid.index(flask.deepest), [8, 8, 8]);
        assert!(flask.samples >= 11 * 11 * 11 && flask.samples <= 11 * 11 * 11 + 27, "{}", flask.samples);
        assert_eq!((bubble.widest_radius_mm, bubble.samples, bubble.is_sealed()), (3.0, 125, true));
        assert_eq!(found.radius.at([22, 8, 8]), 0.0);
        assert_eq!((found.radius.at([8, 8, 8]), found.radius.at([1, 7, 7])), (2.0, 1.0));
    }

    #[test]
    fn plates_close_what_stands_on_them() {
        let clearance = flask();
        let grid = *clearance.grid();
        let exits = border(&grid, &[Side::High(0)]);
        let found = escape(&clearance, &exits, 50.0, 0.9).unwrap();
        assert!(found.pockets.iter().all(Pocket::is_sealed) && found.pockets.len() == 2, "{:?}", found.pockets);
        assert!(escape(&clearance, &exits, 0.0, 0.5).is_err());
    }
}
