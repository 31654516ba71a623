//! Sets as trees of nodes of 4³ cells: samples at the bottom, nodes of 4, 16 and 64 samples above.
//!
//! Laid over each other, the one that moves is asked node by node (64 bits), the one that stands by the 8³ cells that a node
//! moved by less than its width may come over (a neighbourhood, one cache line).

use crate::field::Indicator;
use rayon::prelude::*;

/// Levels of nodes above the samples.
pub(super) const LEVELS: usize = 3;
/// Cells along a node.
pub(super) const SIDE: isize = 4;
/// Nodes before the first, at every level: a neighbourhood that begins there may still reach into the set.
const BEFORE: isize = 2;

/// 8³ cells: layer z, bit 8·y + x.
pub(super) type Neighbourhood = [u64; 8];

/// A table of neighbourhoods; those that are empty or full are not stored.
#[derive(Debug, Clone)]
struct Neighbourhoods {
    dims: [usize; 3],
    slots: Vec<u32>,
    stored: Vec<Neighbourhood>,
}

const EMPTY: u32 = 0;

impl Neighbourhoods {
    /// A table for nodes from −2 up to `dims` less 2 along each axis.
    fn new(dims: [usize; 3], of: impl Fn([isize; 3]) -> Neighbourhood + Sync) -> Self {
        let planes: Vec<(Vec<u32>, Vec<Neighbourhood>)> = (0..dims[2])
            .into_par_iter()
            .map(|k| {
                let (mut slots, mut own) = (Vec::with_capacity(dims[0] * dims[1]), Vec::new());
                for j in 0..dims[1] {
                    for i in 0..dims[0] {
                        let cells = of([i, j, k].map(|n| n as isize - BEFORE));
                        slots.push(if cells == [0; 8] {
                            EMPTY
                        } else if cells == [!0; 8] {
                            1
                        } else {
                            own.push(cells);
                            own.len() as u32 + 1
                        });
                    }
                }
                (slots, own)
            })
            .collect();
        let mut table = Neighbourhoods { dims, slots: Vec::new(), stored: vec![[0; 8], [!0; 8]] };
        for (slots, own) in planes {
            let before = table.stored.len() as u32 - 2;
            table.slots.extend(slots.into_iter().map(|s| if s > 1 { s + before } else { s }));
            table.stored.extend(own);
        }
        table
    }

    /// The cells that a node at an index may come over; `None` if there are none.
    #[inline]
    fn at(&self, index: [isize; 3]) -> Option<&Neighbourhood> {
        let [i, j, k] = index.map(|n| (n + BEFORE) as usize);
        let inside = i < self.dims[0] && j < self.dims[1] && k < self.dims[2];
        let slot = if inside { self.slots[(k * self.dims[1] + j) * self.dims[0] + i] } else { EMPTY };
        (slot != EMPTY).then(|| &self.stored[slot as usize])
    }
}

/// The set that stands.
#[derive(Debug, Clone)]
pub(super) struct Ground {
    /// By level, from 1: of the cells that hold any of the set within the width of a cell and the next one.
    any: Vec<Neighbourhoods>,
    /// By level, from 2: of the cells that a full cell of the other meets, moved by less than its width in whatever way.
    sure: Vec<Neighbourhoods>,
}

impl Ground {
    pub fn new(set: &Indicator) -> Self {
        let mut dims = set.grid().dims().map(|n| n.div_ceil(SIDE as usize) + BEFORE as usize);
        let mut any = vec![Neighbourhoods::new(dims, |node| samples_around(set, node))];
        let mut sure: Vec<Neighbourhoods> = Vec::new();
        let mut step = SIDE;
        for level in 1..LEVELS {
            dims = dims.map(|n| n.div_ceil(SIDE as usize) + BEFORE as usize);
            let below = &any[level - 1];
            let possible = Neighbourhoods::new(dims, |node| around(node, |cell| below.at(cell).is_some()));
            // The last sample of a cell: a full cell of the other holds it however it is moved.
            let last = |cell: [isize; 3]| inside(set, cell.map(|c| step * c + step - 1));
            sure.push(Neighbourhoods::new(dims, |node| around(node, last)));
            any.push(possible);
            step *= SIDE;
        }
        Ground { any, sure }
    }

    /// What a node of this level may meet at an index, in cells of the level below.
    #[inline]
    pub fn any(&self, level: usize, index: [isize; 3]) -> Option<&Neighbourhood> {
        self.any[level - 1].at(index)
    }

    /// What full cells of the level below meet for certain; levels from 2.
    #[inline]
    pub fn sure(&self, level: usize, index: [isize; 3]) -> Option<&Neighbourhood> {
        self.sure[level - 2].at(index)
    }
}

fn inside(set: &Indicator, at: [isize; 3]) -> bool {
    at.iter().all(|&i| i >= 0) && set.contains(at.map(|i| i as usize))
}

/// The cells from 4·node on that satisfy a predicate.
fn around(node: [isize; 3], cell: impl Fn([isize; 3]) -> bool) -> Neighbourhood {
    let mut cells = [0u64; 8];
    for (z, layer) in cells.iter_mut().enumerate() {
        for bit in 0..64 {
            let of = [bit % 8, bit / 8, z as isize];
            if cell([0, 1, 2].map(|a| SIDE * node[a] + of[a])) {
                *layer |= 1 << bit;
            }
        }
    }
    cells
}

/// The same for the samples of a set, eight at a time.
fn samples_around(set: &Indicator, node: [isize; 3]) -> Neighbourhood {
    let [_, ny, nz] = set.grid().dims();
    let first = node.map(|n| SIDE * n);
    let mut cells = [0u64; 8];
    for (z, layer) in cells.iter_mut().enumerate() {
        for y in 0..8 {
            let (j, k) = (first[1] + y, first[2] + z as isize);
            if (0..ny as isize).contains(&j) && (0..nz as isize).contains(&k) {
                *layer |= (bits_from(set.row(j as usize, k as usize), first[0]) & 0xFF) << (8 * y);
            }
        }
    }
    cells
}

/// 64 bits of a row from one of them on; what lies outside is 0.
pub(super) fn bits_from(row: &[u64], first: isize) -> u64 {
    let word = |w: isize| if w >= 0 { row.get(w as usize).copied().unwrap_or(0) } else { 0 };
    let (w, bit) = (first.div_euclid(64), first.rem_euclid(64));
    if bit == 0 { word(w) } else { word(w) >> bit | word(w + 1) << (64 - bit) }
}

/// The nodes of one level of the set that moves: bit 16·z + 4·y + x for each cell of the level below.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    pub dims: [usize; 3],
    /// Cells that hold any of the set.
    any: Vec<u64>,
    /// Cells that lie in the set.
    full: Vec<u64>,
}

impl Nodes {
    /// The nodes of a set, by level from 1.
    pub fn all(set: &Indicator) -> Vec<Nodes> {
        let lowest = |node: [usize; 3]| {
            let mut word = 0;
            let [_, ny, nz] = set.grid().dims();
            for (z, y) in (0..4).flat_map(|z| (0..4).map(move |y| (z, y))) {
                let (j, k) = (4 * node[1] + y, 4 * node[2] + z);
                if j < ny && k < nz {
                    word |= (bits_from(set.row(j, k), 4 * node[0] as isize) & 0xF) << (16 * z + 4 * y);
                }
            }
            [word, 0]
        };
        let mut levels = vec![Nodes::new(set.grid().dims(), lowest)];
        for level in 1..LEVELS {
            let below = &levels[level - 1];
            let of = |node: [usize; 3]| {
                let cells = (0..64).map(|bit| [0, 1, 2].map(|a| 4 * node[a] + (bit >> (2 * a) & 3)));
                cells.enumerate().fold([0u64; 2], |words, (bit, cell)| {
                    let cell = cell.map(|c| c as u32);
                    let whole = if level == 1 { below.any(cell) } else { below.full(cell) };
                    [words[0] | u64::from(below.any(cell) != 0) << bit, words[1] | u64::from(whole == !0) << bit]
                })
            };
            let next = Nodes::new(below.dims, of);
            levels.push(next);
        }
        levels
    }

    fn new(cells: [usize; 3], of: impl Fn([usize; 3]) -> [u64; 2]) -> Self {
        let dims = cells.map(|n| n.div_ceil(4));
        let count = dims.iter().product();
        let (mut any, mut full) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for at in 0..count {
            let [some, whole] = of([at % dims[0], at / dims[0] % dims[1], at / (dims[0] * dims[1])]);
            any.push(some);
            full.push(whole);
        }
        Nodes { dims, any, full }
    }

    #[inline]
    fn offset(&self, node: [u32; 3]) -> Option<usize> {
        let [i, j, k] = node.map(|n| n as usize);
        (i < self.dims[0] && j < self.dims[1] && k < self.dims[2]).then(|| (k * self.dims[1] + j) * self.dims[0] + i)
    }

    /// Cells of a node that hold any of the set.
    #[inline]
    pub fn any(&self, node: [u32; 3]) -> u64 {
        self.offset(node).map_or(0, |at| self.any[at])
    }

    /// Cells of a node that lie in the set; levels from 2.
    #[inline]
    pub fn full(&self, node: [u32; 3]) -> u64 {
        self.offset(node).map_or(0, |at| self.full[at])
    }
}
