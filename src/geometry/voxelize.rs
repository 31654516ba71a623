//! Casting a mesh onto a grid.

use super::solid::{InsideRule, Solid};
use super::voxelize_crossings::Crossings;
use super::voxelize_lattice::{Lattice, ceil_shift, span};
use super::{TriangleMesh, voxelize_fraction, voxelize_shell};
use crate::error::{Error, Result};
use crate::field::{Density, Field, Indicator};
use crate::grid::Grid;
use rayon::prelude::*;
use std::ops::Range;

/// The solid S bounded by a mesh, cast onto a grid: `inner`, `centres`, `outer` and `density` as defined on [`Solid`].
///
/// With [`InsideRule::Crossings`], S = { p : w(p) ≥ 1 } with the winding number w: overlapping bodies are their union,
/// shells wound inwards subtract. Corners are rounded to h/2^16 (coarser where the part reaches beyond 2^12 samples);
/// samples are then classified exactly, a sample in a facet or behind an edge being taken to stand infinitesimally
/// further along x, then y, then z. `inner` and `outer` hold for the mesh as given: the shell between them is widened
/// by the rounding. `density` is min(1, ∫ w) over each cube: exact but for f32 rounding, save where the surfaces of
/// two overlapping bodies cut one cube, where it may count their overlap twice.
///
/// The grid may be a window of the part: what lies outside it still decides what is inside.
///
/// # Errors
/// [`Error::Operand`] if the surface has a boundary (use [`InsideRule::Winding`]) or lies beyond 2^24 samples from the
/// grid.
///
/// # Cost
/// O(facets + cubes touched + samples/64) time; one bit a sample for each set, four bytes for the density.
///
/// # Source
/// Crossings with simulation of simplicity (Edelsbrunner, Mücke 1990); shell by separating axes (Schwarz, Seidel 2010).
///
/// ```
/// use amcheck::{geometry::{InsideRule, TriangleMesh, voxelize}, grid::Grid, units::Length};
/// let p = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]];
/// let tetrahedron = TriangleMesh::weld([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|t: [usize; 3]| t.map(|v| p[v])));
/// let grid = Grid::covering([0.0; 3], [3.0; 3], Length::mm(0.1), 1, [0.0; 3])?;
/// let solid = voxelize(&tetrahedron, &grid, InsideRule::Crossings)?;
/// assert!((solid.density.volume().as_mm3() - 4.5).abs() < 1e-5);
/// assert!(solid.inner.volume().as_mm3() < 4.5 && 4.5 < solid.outer.volume().as_mm3());
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn voxelize(mesh: &TriangleMesh, grid: &Grid, rule: InsideRule) -> Result<Solid> {
    let lattice = Lattice::new(mesh, grid)?;
    match rule {
        InsideRule::Crossings => by_crossings(&lattice, grid),
        InsideRule::Winding => Err(Error::Operand {
            operation: "voxelize",
            problem: "this surface needs its winding number".into(),
            remedy: "close the surface first".into(),
        }),
    }
}

/// The samples inside a mesh: the `centres` of [`voxelize`] with [`InsideRule::Crossings`], and nothing else.
///
/// # Errors
/// As [`voxelize`].
///
/// # Cost
/// O(facets + crossings + samples/64).
pub fn occupancy(mesh: &TriangleMesh, grid: &Grid) -> Result<Indicator> {
    let lattice = Lattice::new(mesh, grid)?;
    let layers = slab_layers(grid);
    let crossings = Crossings::of(&lattice, layers);
    let mut set = Indicator::empty(*grid);
    let [nx, ny, _] = grid.dims();
    let words = set.words_per_row();
    set.words_mut()
        .par_chunks_mut(words * ny * layers)
        .enumerate()
        .try_for_each(|(slab, words)| crossings.fill(slab, slab * layers * ny, nx, words))?;
    Ok(set)
}

/// Layers that one task casts: few enough to stay in cache and to share the work out evenly.
fn slab_layers(grid: &Grid) -> usize {
    let [nx, ny, nz] = grid.dims();
    let cached = (1 << 18) / (nx * ny).max(1);
    cached.clamp(1, nz.div_ceil(32).max(1))
}

fn by_crossings(lattice: &Lattice, grid: &Grid) -> Result<Solid> {
    let layers = slab_layers(grid);
    let [nx, ny, nz] = grid.dims();
    let crossings = Crossings::of(lattice, layers);
    let facets = facets_by_slab(lattice, layers);
    let (mut inner, mut centres) = (Indicator::empty(*grid), Indicator::empty(*grid));
    let mut outer = Indicator::empty(*grid);
    let mut density = vec![0.0f32; grid.samples()];
    let words_per_row = centres.words_per_row();
    let slab_words = words_per_row * ny * layers;
    (inner.words_mut().par_chunks_mut(slab_words))
        .zip(centres.words_mut().par_chunks_mut(slab_words))
        .zip(outer.words_mut().par_chunks_mut(slab_words))
        .zip(density.par_chunks_mut(nx * ny * layers))
        .enumerate()
        .try_for_each(|(slab, (((inner, centres), shell), density))| {
            let range = slab * layers..((slab + 1) * layers).min(nz);
            crossings.fill(slab, range.start * ny, nx, centres)?;
            for &facet in facets.iter().flat_map(|chunk| &chunk[slab]) {
                voxelize_shell::mark(lattice, facet, range.clone(), shell);
                voxelize_fraction::add(lattice, facet, range.clone(), density);
            }
            let rows = inner.chunks_mut(words_per_row).zip(centres.chunks(words_per_row));
            let rows = rows.zip(shell.chunks_mut(words_per_row)).zip(density.chunks_mut(nx));
            for (((inner, centres), shell), density) in rows {
                settle(centres, shell, density);
                for ((inner, outer), &centre) in inner.iter_mut().zip(shell).zip(centres) {
                    *inner = centre & !*outer;
                    *outer |= centre;
                }
            }
            Ok(())
        })?;
    let density = Density::new(Field::from_values(*grid, density, 0.0)?)?;
    Ok(Solid { inner, centres, outer, density, doubt: None })
}

/// The facets that touch each slab of layers, in chunks: every slab reads its facets in the order of the mesh.
fn facets_by_slab(lattice: &Lattice, layers: usize) -> Vec<Vec<Vec<u32>>> {
    let slabs = lattice.dims[2].div_ceil(layers);
    const CHUNK: usize = 4096;
    (0..lattice.triangles.len().div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut found = vec![Vec::new(); slabs];
            for facet in chunk * CHUNK..((chunk + 1) * CHUNK).min(lattice.triangles.len()) {
                for slab in slabs_of(lattice, facet as u32, layers) {
                    found[slab].push(facet as u32);
                }
            }
            found
        })
        .collect()
}

/// The slabs whose cubes come within one lattice unit of a facet.
fn slabs_of(lattice: &Lattice, facet: u32, layers: usize) -> Range<usize> {
    let (lo, hi) = span(&lattice.corners(facet), 2);
    let reach = (1 << (lattice.bits - 1)) + 1;
    let first = ceil_shift(lo - reach, lattice.bits).max(0);
    let last = ((hi + reach) >> lattice.bits).min(lattice.dims[2] as i32 - 1);
    if first > last { 0..0 } else { first as usize / layers..last as usize / layers + 1 }
}

/// Turns the changes along a row into solid fractions: running sums within the shell, 0 or 1 elsewhere.
///
/// Off the shell the integral of the winding number is a whole number, so rounding errors end with each stretch.
fn settle(centres: &[u64], shell: &[u64], row: &mut [f32]) {
    let n = row.len();
    let (mut at, mut sum) = (0, 0.0f64);
    while at < n {
        let first = next(shell, at, n, 0);
        if first > at {
            sum = (sum + f64::from(row[at])).round();
            row[at] = 0.0;
            if centres[at / 64] >> (at % 64) & 1 == 1 {
                row[at..first].fill(1.0);
            }
        }
        at = next(shell, first, n, !0);
        for value in &mut row[first..at] {
            sum += f64::from(*value);
            *value = sum.clamp(0.0, 1.0) as f32;
        }
    }
}

/// The first position from `at` on whose bit, exclusive-or with `flip`, is set; `n` if there is none.
#[inline]
fn next(bits: &[u64], at: usize, n: usize, flip: u64) -> usize {
    let mut word = at / 64;
    let mut mask = !0u64 << (at % 64);
    while word * 64 < n {
        let found = (bits[word] ^ flip) & mask;
        if found != 0 {
            return (word * 64 + found.trailing_zeros() as usize).min(n);
        }
        (word, mask) = (word + 1, !0);
    }
    n
}
