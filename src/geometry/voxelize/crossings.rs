//! Where the rows of a grid cross a surface: samples are classified exactly, ties included.
//!
//! A sample is taken to stand at `(x + δ, y + ε, z + ε²)` with δ ≫ ε ≫ ε² > 0 infinitesimal (simulation of
//! simplicity, Edelsbrunner and Mücke 1990). No row then meets an edge or a corner and no sample lies in a facet, so
//! a face in a plane of samples or an edge along a row never flips anything.

use super::lattice::{Lattice, ceil_shift, span};
use crate::error::{Error, Result};
use rayon::prelude::*;

/// Facets that one task turns into crossings.
const CHUNK: usize = 4096;

/// Surface crossings of the rows along x, gathered by slabs of layers.
pub(super) struct Crossings {
    /// By chunk of facets, then by slab: `row << 32 | sample << 1 | leaves`, in the order of the facets.
    events: Vec<Vec<Vec<u64>>>,
}

impl Crossings {
    /// All crossings of the rows of the grid with the facets, `layers` layers to a slab.
    pub fn of(lattice: &Lattice, layers: usize) -> Self {
        let slabs = lattice.dims[2].div_ceil(layers);
        let events = (0..lattice.triangles.len().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut events = vec![Vec::new(); slabs];
                let end = ((chunk + 1) * CHUNK).min(lattice.triangles.len());
                for facet in chunk * CHUNK..end {
                    cross(lattice, facet as u32, |j, k, event| {
                        let row = (k * lattice.dims[1] + j) as u64;
                        events[k / layers].push(row << 32 | event);
                    });
                }
                events
            })
            .collect();
        Crossings { events }
    }

    /// The crossings of a slab by row and along the row: `row << 32 | sample << 1 | leaves`, where the surface is crossed
    /// just before the sample.
    pub fn sorted(&self, slab: usize) -> Vec<u64> {
        let mut events: Vec<u64> = self.events.iter().flat_map(|chunk| chunk[slab].iter().copied()).collect();
        events.sort_unstable();
        events
    }

    /// Sets the bits of the samples with winding number ≥ 1 in the rows of a slab, which must be zero before.
    ///
    /// # Errors
    /// [`Error::Operand`] if a row leaves the part more or less often than it enters: the surface has a boundary.
    pub fn fill(&self, slab: usize, first_row: usize, nx: usize, words: &mut [u64]) -> Result<()> {
        let events = self.sorted(slab);
        let words_per_row = nx.div_ceil(64);
        for row in events.chunk_by(|a, b| a >> 32 == b >> 32) {
            let at = ((row[0] >> 32) as usize - first_row) * words_per_row;
            let bits = &mut words[at..at + words_per_row];
            let (mut winding, mut from) = (0i64, 0usize);
            for &event in row {
                let sample = (event as u32 >> 1) as usize;
                if winding >= 1 {
                    set_range(bits, from, sample);
                }
                winding += 1 - 2 * (event & 1) as i64;
                from = sample;
            }
            if winding != 0 {
                return Err(Error::Operand {
                    operation: "voxelize",
                    problem: format!("a row enters the part {winding} times more than it leaves it"),
                    remedy: "the surface is not closed: use the winding rule".into(),
                });
            }
        }
        Ok(())
    }
}

/// Sets the bits `from..to` of a row.
#[inline]
pub(super) fn set_range(bits: &mut [u64], from: usize, to: usize) {
    if from >= to {
        return;
    }
    let (first, last) = (from / 64, (to - 1) / 64);
    let head = !0u64 << (from % 64);
    let tail = !0u64 >> (63 - (to - 1) % 64);
    if first == last {
        bits[first] |= head & tail;
    } else {
        bits[first] |= head;
        bits[first + 1..last].fill(!0);
        bits[last] |= tail;
    }
}

/// Calls `emit(j, k, sample << 1 | leaves)` for each row of the grid that crosses a facet, with the first sample
/// behind the crossing (0 if the crossing lies before the grid, nx if behind it).
#[inline]
fn cross(lattice: &Lattice, facet: u32, mut emit: impl FnMut(usize, usize, u64)) {
    let mut t = lattice.corners(facet);
    let bits = lattice.bits;
    let rows = |axis: usize| {
        let (lo, hi) = span(&t, axis);
        (ceil_shift(lo, bits).max(0), ceil_shift(hi, bits).min(lattice.dims[axis] as i32))
    };
    let ((j0, j1), (k0, k1)) = (rows(1), rows(2));
    if j0 >= j1 || k0 >= k1 {
        return;
    }
    let d = |a: usize, b: usize, axis: usize| i64::from(t[b][axis]) - i64::from(t[a][axis]);
    let normal_x = d(0, 1, 1) * d(0, 2, 2) - d(0, 1, 2) * d(0, 2, 1);
    if normal_x == 0 {
        return;
    }
    let leaves = u64::from(normal_x > 0);
    if normal_x < 0 {
        t.swap(1, 2);
    }
    let area = normal_x.abs();
    let edges = [Edge::new(&t[1], &t[2]), Edge::new(&t[2], &t[0]), Edge::new(&t[0], &t[1])];
    let plane = Depth::new(&t, area, bits);
    for k in k0..k1 {
        let z = i64::from(k) << bits;
        let mut at = edges.each_ref().map(|e| e.at(i64::from(j0) << bits, z));
        for j in j0..j1 {
            if at[0] + edges[0].tie > 0 && at[1] + edges[1].tie > 0 && at[2] + edges[2].tie > 0 {
                let sample = plane.first_behind(at).clamp(0, lattice.dims[0] as i64) as u64;
                emit(j as usize, k as usize, sample << 1 | leaves);
            }
            for (value, edge) in at.iter_mut().zip(&edges) {
                *value -= edge.dz << bits;
            }
        }
    }
}

/// An edge of a facet seen along x, the facet on its left: positive on the facet's side.
struct Edge {
    y: i64,
    z: i64,
    dy: i64,
    dz: i64,
    /// 1 where the infinitesimal shift of the samples carries a point on the edge to the facet's side, else 0.
    tie: i64,
}

impl Edge {
    fn new(a: &[i32; 3], b: &[i32; 3]) -> Self {
        let (dy, dz) = (i64::from(b[1]) - i64::from(a[1]), i64::from(b[2]) - i64::from(a[2]));
        let tie = i64::from(dz < 0 || (dz == 0 && dy > 0));
        Edge { y: i64::from(a[1]), z: i64::from(a[2]), dy, dz, tie }
    }

    /// Twice the signed area of the edge and the point (y, z).
    #[inline]
    fn at(&self, y: i64, z: i64) -> i64 {
        self.dy * (z - self.z) - self.dz * (y - self.y)
    }
}

/// Depth along x of a facet over a row, as a convex combination of its corners' depths.
struct Depth {
    x: [i64; 3],
    area: i64,
    scale: f64,
    bits: u32,
}

impl Depth {
    fn new(t: &[[i32; 3]; 3], area: i64, bits: u32) -> Self {
        let scale = 1.0 / (area as f64 * f64::from(1u32 << bits));
        Depth { x: [0, 1, 2].map(|v| i64::from(t[v][0])), area, scale, bits }
    }

    /// ⌈depth / 2^bits⌉: in floating point where that is certain, else in integers.
    ///
    /// A convex combination of coordinates below 2^29 has a floating-point error below 2^-20 units.
    #[inline]
    fn first_behind(&self, weight: [i64; 3]) -> i64 {
        let [a, b, c] = self.x;
        if a == b && b == c {
            return -((-a) >> self.bits);
        }
        let depth =
            (weight[0] as f64 * a as f64 + weight[1] as f64 * b as f64 + weight[2] as f64 * c as f64) * self.scale;
        let slack = 1.0 / f64::from(1u32 << 20);
        let (low, high) = ((depth - slack).ceil(), (depth + slack).ceil());
        if low == high {
            return low as i64;
        }
        let sum: i128 = weight.iter().zip(&self.x).map(|(&w, &x)| i128::from(w) * i128::from(x)).sum();
        let step = i128::from(self.area) << self.bits;
        -((-sum).div_euclid(step)) as i64
    }
}
