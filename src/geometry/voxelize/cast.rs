//! Casting a mesh onto a grid.

use super::crossings::Crossings;
use super::lattice::{Lattice, ceil_shift, span};
use super::{fraction, shell, winding};
use crate::error::Result;
use crate::field::{Density, Field, Indicator};
use crate::geometry::TriangleMesh;
use crate::geometry::solid::{Doubt, Enclosure, InsideRule, Solid};
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
/// With [`InsideRule::Winding`], S = { p : w(p) ≥ ½ } with the generalized winding number ([`crate::geometry::Winding`]): probed off the
/// surface, counted through the facets where that adds up, and evaluated at every sample where it does not; `centres` is
/// then an estimate. `inner` and `outer` hold for the facets, not for what closes the holes between them, and `density`
/// counts facets where the row across them is complete and samples where it is not. [`Solid::doubt`] says how much of it
/// is a guess. A mesh that is inside out as a whole comes out empty.
///
/// The grid may be a window of the part: what lies outside it still decides what is inside.
///
/// # Errors
/// [`crate::Error::Operand`] if the surface has a boundary (use [`InsideRule::Winding`]) or lies beyond 2^24 samples from the
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
    cast(mesh, Lattice::new(mesh, grid)?, grid, rule)
}

/// A slab of what [`voxelize()`] makes: the layers `range` of the grid along z, for grids that do not fit into memory.
///
/// With [`InsideRule::Crossings`] every bit and every density is that of the whole; the slab's grid is a window of the whole one.
///
/// # Errors
/// As [`voxelize()`]; [`crate::Error::Operand`] for no layers or layers beyond the grid.
///
/// # Cost
/// As [`voxelize()`], but samples and cubes of the slab only; memory grows with the slab.
pub fn voxelize_layers(mesh: &TriangleMesh, grid: &Grid, range: Range<usize>, rule: InsideRule) -> Result<Solid> {
    let [nx, ny, nz] = grid.dims();
    if range.is_empty() || range.end > nz {
        return Err(crate::Error::Operand {
            operation: "voxelize",
            problem: format!("layers {range:?} are not in a grid of {nz}"),
            remedy: "choose layers of the grid".into(),
        });
    }
    let slab = Grid::new(grid.position([0, 0, range.start]), grid.spacing(), [nx, ny, range.len()])?;
    let lattice = Lattice::new(mesh, grid)?.seen_from(range.start, range.len());
    cast(mesh, lattice, &slab, rule)
}

/// Casts onto a grid whose first sample is the origin of the lattice.
fn cast(mesh: &TriangleMesh, lattice: Lattice, grid: &Grid, rule: InsideRule) -> Result<Solid> {
    let layers = slab_layers(grid);
    let mut parts = Parts::new(grid);
    let doubt = match rule {
        InsideRule::Crossings => {
            parts.mark_surface(&lattice, layers);
            let crossings = Crossings::of(&lattice, layers);
            fill(&crossings, layers, &mut parts.centres)?;
            None
        }
        InsideRule::Winding => {
            parts.mark_surface(&lattice, layers);
            let crossings = Crossings::of(&lattice, winding::BUNDLE);
            let (shell, centres) = (parts.outer.words(), parts.centres.words_mut());
            Some(winding::classify(mesh, &crossings, grid, shell, centres))
        }
    };
    parts.settle(rule, doubt)
}

/// The samples inside a mesh: the `centres` of [`voxelize()`] with [`InsideRule::Crossings`], and nothing else.
///
/// # Errors
/// As [`voxelize()`].
///
/// # Cost
/// O(facets + crossings + samples/64).
pub fn occupancy(mesh: &TriangleMesh, grid: &Grid) -> Result<Indicator> {
    let lattice = Lattice::new(mesh, grid)?;
    let layers = slab_layers(grid);
    let crossings = Crossings::of(&lattice, layers);
    let mut set = Indicator::empty(*grid);
    fill(&crossings, layers, &mut set)?;
    Ok(set)
}

/// The solid of a mesh from three sides, as [`voxelize()`] casts it, without the density: a bit a sample for each set.
///
/// # Errors
/// As [`voxelize()`].
///
/// # Cost
/// O(facets + cubes touched + samples/64) time, three bits a sample.
pub fn enclose(mesh: &TriangleMesh, grid: &Grid, rule: InsideRule) -> Result<Enclosure> {
    let lattice = Lattice::new(mesh, grid)?;
    let layers = slab_layers(grid);
    let [mut inner, mut centres, mut outer] = [0; 3].map(|_| Indicator::empty(*grid));
    let facets = facets_by_slab(&lattice, layers);
    let [_, ny, nz] = grid.dims();
    let slab_words = outer.words_per_row() * ny * layers;
    outer.words_mut().par_chunks_mut(slab_words).enumerate().with_max_len(1).for_each(|(slab, shell)| {
        let range = slab * layers..((slab + 1) * layers).min(nz);
        for &facet in facets.iter().flat_map(|chunk| &chunk[slab]) {
            shell::mark(&lattice, facet, range.clone(), shell);
        }
    });
    match rule {
        InsideRule::Crossings => fill(&Crossings::of(&lattice, layers), layers, &mut centres)?,
        InsideRule::Winding => {
            let crossings = Crossings::of(&lattice, winding::BUNDLE);
            winding::classify(mesh, &crossings, grid, outer.words(), centres.words_mut());
        }
    }
    let sets = inner.words_mut().par_iter_mut().zip(outer.words_mut()).zip(centres.words());
    sets.for_each(|((inner, outer), &centre)| {
        *inner = centre & !*outer;
        *outer |= centre;
    });
    Ok(Enclosure { inner, centres, outer })
}

/// Layers that one task casts: few enough to stay in cache and to share the work out evenly.
fn slab_layers(grid: &Grid) -> usize {
    let [nx, ny, nz] = grid.dims();
    let cached = (1 << 18) / (nx * ny).max(1);
    cached.clamp(1, nz.div_ceil(32).max(1))
}

/// Sets the samples with winding number ≥ 1, slab by slab.
fn fill(crossings: &Crossings, layers: usize, set: &mut Indicator) -> Result<()> {
    let [nx, ny, _] = set.grid().dims();
    let slab_words = set.words_per_row() * ny * layers;
    let slabs = set.words_mut().par_chunks_mut(slab_words).enumerate().with_max_len(1);
    slabs.try_for_each(|(slab, words)| crossings.fill(slab, slab * layers * ny, nx, words))
}

/// A solid in the making: `outer` is the shell alone and `density` the change along rows, until [`Parts::settle`].
struct Parts {
    inner: Indicator,
    centres: Indicator,
    outer: Indicator,
    density: Vec<f32>,
}

impl Parts {
    fn new(grid: &Grid) -> Self {
        let [inner, centres, outer] = [0; 3].map(|_| Indicator::empty(*grid));
        Parts { inner, centres, outer, density: vec![0.0; grid.samples()] }
    }

    /// Marks the shell and collects the changes of the fractions, slab by slab, facets in the order of the mesh.
    fn mark_surface(&mut self, lattice: &Lattice, layers: usize) {
        let [nx, ny, nz] = lattice.dims;
        let facets = facets_by_slab(lattice, layers);
        let slab_words = self.outer.words_per_row() * ny * layers;
        let shells = self.outer.words_mut().par_chunks_mut(slab_words);
        let slabs = shells.zip(self.density.par_chunks_mut(nx * ny * layers)).enumerate().with_max_len(1);
        slabs.for_each(|(slab, (shell, density))| {
            let range = slab * layers..((slab + 1) * layers).min(nz);
            // A fresh page that is read before it is written costs two faults, the second told to all cores.
            density.fill(0.0);
            let mut scratch = fraction::Scratch::default();
            for &facet in facets.iter().flat_map(|chunk| &chunk[slab]) {
                shell::mark(lattice, facet, range.clone(), shell);
                fraction::add(lattice, facet, range.clone(), &mut scratch, density);
            }
        });
    }

    /// The solid, from the shell, the changes and the centres.
    fn settle(mut self, rule: InsideRule, doubt: Option<Doubt>) -> Result<Solid> {
        let grid = *self.centres.grid();
        let words = self.centres.words_per_row();
        (self.inner.words_mut().par_chunks_mut(words))
            .zip(self.centres.words().par_chunks(words))
            .zip(self.outer.words_mut().par_chunks_mut(words))
            .zip(self.density.par_chunks_mut(grid.dims()[0]))
            .for_each(|(((inner, centres), shell), density)| {
                match rule {
                    InsideRule::Crossings => fraction::settle(centres, shell, density),
                    InsideRule::Winding => fraction::settle_open(centres, shell, density),
                }
                for ((inner, outer), &centre) in inner.iter_mut().zip(shell).zip(centres) {
                    *inner = centre & !*outer;
                    *outer |= centre;
                }
            });
        let density = Density::new(Field::from_values(grid, self.density, 0.0)?)?;
        Ok(Solid { inner: self.inner, centres: self.centres, outer: self.outer, density, doubt })
    }
}

/// The facets that touch each slab of layers, in chunks: every slab reads its facets in the order of the mesh.
fn facets_by_slab(lattice: &Lattice, layers: usize) -> Vec<Vec<Vec<u32>>> {
    let slabs = lattice.dims[2].div_ceil(layers);
    const CHUNK: usize = 4096;
    (0..lattice.triangles.len().div_ceil(CHUNK))
        .into_par_iter()
        .with_max_len(1)
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
