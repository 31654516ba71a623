//! The integer lattice that the exact predicates of the cast live on.

use crate::error::{Error, Result};
use crate::geometry::TriangleMesh;
use crate::grid::Grid;
use rayon::prelude::*;

/// Most significant bit that a lattice coordinate may use: differences then have 30 bits, areas 61, and all of them
/// fit in `i64`; volumes fit in `i128`.
const COORDINATE_BITS: u32 = 29;
/// Finest snapping, as a power of two below the spacing.
const FINEST: u32 = 16;
/// Coarsest snapping that is still worth calling exact.
const COARSEST: u32 = 4;

/// The facets of a mesh with corners rounded to multiples of h/2^`bits` about the grid's first sample.
///
/// Sample `i` stands at lattice coordinate `i << bits`; its cube reaches half a step to both sides. Rounding moves a
/// corner, and so any point of a facet, by at most half a unit along each axis. It maps every edge to one edge, so
/// a surface without boundary stays without boundary.
pub(super) struct Lattice<'a> {
    /// Corner positions in units of h/2^`bits`.
    pub vertices: Vec<[i32; 3]>,
    /// Facets, as in the mesh.
    pub triangles: &'a [[u32; 3]],
    /// Log2 of the units in one spacing.
    pub bits: u32,
    /// Counts of the grid.
    pub dims: [usize; 3],
}

impl<'a> Lattice<'a> {
    /// The lattice of a mesh over a grid, as fine as 29-bit coordinates allow and no finer than h/2^16.
    pub fn new(mesh: &'a TriangleMesh, grid: &Grid) -> Result<Self> {
        let (lo, hi) = mesh.bounds().unwrap_or_default();
        let ends = grid.continuous_index(lo).into_iter().chain(grid.continuous_index(hi));
        let reach = ends.chain(grid.dims().map(|n| n as f64)).fold(1.0, |most, c| f64::max(most, c.abs()));
        let needed = reach.log2().ceil() + 1.0;
        let finite = mesh.vertices.iter().flatten().all(|c| c.is_finite());
        if !finite || needed > f64::from(COORDINATE_BITS - COARSEST) {
            return Err(Error::Operand {
                operation: "voxelize",
                problem: format!("the part reaches {reach:e} samples from the grid's origin, or has a corner nowhere"),
                remedy: "choose a larger spacing, or check the units of the part".into(),
            });
        }
        let bits = FINEST.min(COORDINATE_BITS - needed as u32);
        let unit = f64::from(1u32 << bits);
        let vertices =
            mesh.vertices.par_iter().map(|&p| grid.continuous_index(p).map(|c| (c * unit).round() as i32)).collect();
        Ok(Lattice { vertices, triangles: &mesh.triangles, bits, dims: grid.dims() })
    }

    /// The same lattice as seen from a layer: what stood at `first` stands at 0, and `layers` are left.
    ///
    /// Corners keep the rounding they had, so that a slab is cast exactly as it is in the whole.
    pub fn seen_from(mut self, first: usize, layers: usize) -> Self {
        // Both fit: a layer's index has at most 25 bits, and `bits` more make 29.
        let shift = (first as i32) << self.bits;
        self.vertices.par_iter_mut().for_each(|v| v[2] -= shift);
        self.dims[2] = layers;
        self
    }

    /// The corners of a facet.
    #[inline]
    pub fn corners(&self, facet: u32) -> [[i32; 3]; 3] {
        self.triangles[facet as usize].map(|v| self.vertices[v as usize])
    }
}

/// Least and greatest coordinate of three corners along an axis.
#[inline]
pub(super) fn span(t: &[[i32; 3]; 3], axis: usize) -> (i32, i32) {
    let [a, b, c] = [t[0][axis], t[1][axis], t[2][axis]];
    (a.min(b).min(c), a.max(b).max(c))
}

/// ⌈a / 2^bits⌉.
#[inline]
pub(super) fn ceil_shift(a: i32, bits: u32) -> i32 {
    -((-a) >> bits)
}
