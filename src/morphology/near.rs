//! Exact distances from the samples near a level to a mesh: facets are gathered once for a block of samples.
//!
//! With c the middle of a block and ρ the distance from it to the block's corners, the nearest facet of any point in the
//! block is no further from c than the facet nearest to c by 2ρ: |c − f| ≤ ρ + d(p) ≤ 2ρ + d(c). Where few facets are so
//! near, they are kept for the block; where many are, each point searches the tree from the facet of its neighbour.

use crate::distance::squared_distance;
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::distance::Nearest;
use crate::geometry::vector::{Vec3, distance, scale, sub};
use crate::geometry::{Enclosure, MeshDistance};
use crate::grid::Grid;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// Samples along the edge of a block.
const BLOCK: usize = 4;

/// More facets than this are not kept for a block.
const MOST_KEPT: usize = 48;

/// How far from the level distances are exact, in spacings: both ends of every edge of the grid that the level crosses.
pub(super) const EXACT: f64 = 1.0 + 1e-6;

/// How far from the level a sample may seem to be by the shell's cubes, and yet be that near: half a diagonal more.
const SEEN: f64 = 1.9;

/// The mesh as seen from the samples of a grid.
pub(super) struct Near {
    exact: MeshDistance,
    grid: Grid,
    /// Blocks along x and y.
    blocks: [usize; 2],
    slabs: Vec<Slab>,
    /// The nearest facet of each sample near the level, counted from one; else 0.
    facets: Vec<u32>,
}

/// The facets of one layer of blocks.
#[derive(Default)]
struct Slab {
    /// Where the facets of each block start in `kept`, and where those of the last one end.
    firsts: Vec<u32>,
    /// Distance from the middle of the block, and number, the nearest first.
    kept: Vec<(f64, u32)>,
}

impl Near {
    /// The signed distances less `level`, in millimetres: exact within [`EXACT`] spacings of zero, farther from it
    /// and of the right sign everywhere else; and the facets there for further points.
    ///
    /// `shell2` are squared distances, in spacings, to the cubes that facets touch. Samples `known` otherwise are not
    /// measured exactly.
    pub(super) fn of(
        exact: MeshDistance,
        centres: &Indicator,
        shell2: &Field<u32>,
        level: f64,
        known: Option<&Indicator>,
    ) -> Result<(Field<f32>, Self)> {
        let grid = *centres.grid();
        let [nx, ny, _] = grid.dims();
        let (mut values, mut facets) = (vec![0f32; grid.samples()], vec![0u32; grid.samples()]);
        let thick = BLOCK * nx * ny;
        let band = Band { exact: &exact, centres, grid, level, known };
        let slabs = (values.par_chunks_mut(thick), facets.par_chunks_mut(thick), shell2.values().par_chunks(thick))
            .into_par_iter()
            .enumerate()
            .with_max_len(1)
            .map(|(slab, (values, facets, shell2))| {
                band.about(slab, shell2, values);
                band.exactly(slab, values, facets)
            })
            .collect();
        let near = Near { exact, grid, blocks: [nx, ny].map(|n| n.div_ceil(BLOCK)), slabs, facets };
        Ok((Field::from_values(grid, values, f32::MAX)?, near))
    }

    /// The spacing of the samples, millimetres.
    pub(super) fn h(&self) -> f64 {
        self.grid.h()
    }

    /// The distances to the mesh.
    pub(super) fn mesh(&self) -> &MeshDistance {
        &self.exact
    }

    /// The distances to the mesh, for other samples or another level.
    pub(super) fn into_mesh(self) -> MeshDistance {
        self.exact
    }

    /// The point of the mesh nearest to a sample that was measured exactly.
    pub(super) fn nearest_of_sample(&self, index: [usize; 3]) -> Option<Nearest> {
        let facet = self.facets[self.grid.offset(index)].checked_sub(1)?;
        Some(self.exact.nearest_of(self.grid.position(index), facet))
    }

    /// The slope of the signed distance at a sample whose value is exact: outwards, of length 1.
    pub(super) fn slope(&self, index: [isize; 3], value: f64) -> Option<Vec3> {
        let [i, j, k] = index.map(|i| usize::try_from(i).unwrap_or(usize::MAX));
        let [nx, ny, nz] = self.grid.dims();
        if i >= nx || j >= ny || k >= nz {
            return None;
        }
        let facet = self.facets[(k * ny + j) * nx + i].checked_sub(1)?;
        let p = self.grid.position([i, j, k]);
        let n = self.exact.nearest_of(p, facet);
        let side = if value < 0.0 { -1.0 } else { 1.0 };
        (n.distance > 1e-9 * self.grid.h()).then(|| scale(sub(p, n.point), side / n.distance))
    }

    /// Outward normal of the facet that a nearest point lies on.
    pub(super) fn facing(&self, n: &Nearest) -> Vec3 {
        self.exact.normal(n.facet)
    }

    /// The point of the mesh nearest to a point near the level.
    pub(super) fn nearest(&self, p: Vec3) -> Option<Nearest> {
        let place = self.grid.continuous_index(p);
        let index = [0, 1, 2].map(|a| place[a].clamp(0.0, self.grid.dims()[a] as f64 - 1.0) as usize);
        let block = index.map(|i| i / BLOCK);
        let slab = self.slabs.get(block[2])?;
        let list = slab.list(block[1] * self.blocks[0] + block[0]);
        let (middle, corner) = middle(&self.grid, block);
        let off = distance(p, middle);
        if !list.is_empty() && off <= corner {
            return nearest_kept(&self.exact, p, off, list);
        }
        let [nx, ny, nz] = self.grid.dims();
        let corners = (0..8).map(|at| [0, 1, 2].map(|a| index[a] + (at >> a & 1)));
        let seed = corners
            .filter(|&[i, j, k]| i < nx && j < ny && k < nz)
            .map(|[i, j, k]| self.facets[(k * ny + j) * nx + i])
            .find(|&facet| facet > 0);
        match seed {
            Some(facet) => Some(self.exact.nearest_from(p, facet - 1)),
            None => self.exact.nearest(p, f64::INFINITY),
        }
    }
}

impl Slab {
    fn list(&self, block: usize) -> &[(f64, u32)] {
        match self.firsts.get(block..block + 2) {
            Some(&[first, end]) => &self.kept[first as usize..end as usize],
            _ => &[],
        }
    }
}

/// What a layer of blocks is measured with.
struct Band<'a> {
    exact: &'a MeshDistance,
    centres: &'a Indicator,
    grid: Grid,
    level: f64,
    known: Option<&'a Indicator>,
}

impl Band<'_> {
    /// The values from the distances to the shell's cubes, which touch the surface: right by half a diagonal.
    fn about(&self, slab: usize, shell2: &[u32], values: &mut [f32]) {
        let ([nx, ny, _], h, level) = (self.grid.dims(), self.grid.h() as f32, self.level as f32);
        let rows = values.chunks_mut(nx).zip(shell2.chunks(nx)).enumerate();
        for (row, (values, shell2)) in rows {
            let bits = self.centres.row(row % ny, BLOCK * slab + row / ny);
            for ((values, shell2), &bits) in values.chunks_mut(64).zip(shell2.chunks(64)).zip(bits) {
                for (i, (value, &d2)) in values.iter_mut().zip(shell2).enumerate() {
                    let sign = if bits >> i & 1 == 1 { -h } else { h };
                    *value = sign * (d2 as f32).sqrt() - level;
                }
            }
        }
    }

    /// Exact values near zero, and the facets that they were measured to, block by block.
    fn exactly(&self, slab: usize, values: &mut [f32], facets: &mut [u32]) -> Slab {
        let ([nx, ny, _], h) = (self.grid.dims(), self.grid.h());
        let layers = values.len() / (nx * ny);
        let near = (SEEN * h) as f32;
        let mut out = Slab::default();
        let (mut last, mut samples, mut list) = (None, Vec::new(), Vec::new());
        for block_y in 0..ny.div_ceil(BLOCK) {
            for block_x in 0..nx.div_ceil(BLOCK) {
                out.firsts.push(out.kept.len() as u32);
                let (x, y) = (span(block_x, nx), span(block_y, ny));
                samples.clear();
                for k in 0..layers {
                    for j in y.clone() {
                        let row = (k * ny + j) * nx;
                        let known = |i| self.known.is_some_and(|known| known.contains([i, j, BLOCK * slab + k]));
                        let asked = x.clone().filter(|&i| values[row + i].abs() <= near && !known(i));
                        samples.extend(asked.map(|i| (row + i, [i, j, k])));
                    }
                }
                if samples.is_empty() {
                    continue;
                }
                let (middle, corner) = middle(&self.grid, [block_x, block_y, slab]);
                let Some(mut found) = self.gather(middle, corner, last, &mut list) else { continue };
                last = Some(found.facet);
                for &(at, [i, j, k]) in &samples {
                    let p = self.grid.position([i, j, BLOCK * slab + k]);
                    let side = if self.centres.contains([i, j, BLOCK * slab + k]) { -1.0 } else { 1.0 };
                    let kept = nearest_kept(self.exact, p, distance(p, middle), &list);
                    found = kept.unwrap_or_else(|| self.searched(p, found.facet, side * self.level));
                    values[at] = (side * found.distance - self.level) as f32;
                    facets[at] = found.facet + 1;
                }
                out.kept.extend_from_slice(&list);
            }
        }
        out.firsts.push(out.kept.len() as u32);
        out
    }

    /// The point of the mesh nearest to p, sought from a facet that should be near it, where its distance differs from
    /// `about` by less than [`EXACT`] spacings; else a distance between, and that facet.
    fn searched(&self, p: Vec3, facet: u32, about: f64) -> Nearest {
        let start = self.exact.nearest_of(p, facet);
        let [low, high] = [-EXACT, EXACT].map(|off| about + off * self.grid.h());
        let bound = |distance| Nearest { distance, ..start };
        if start.distance <= low {
            return start;
        }
        if high <= 0.0 {
            return bound(0.0);
        }
        self.exact.nearest(p, high.min(start.distance.next_up())).unwrap_or(bound(high))
    }

    /// The facet nearest to the middle of a block; and in `list` all that can be nearest to a point of it, or none if
    /// these are many.
    fn gather(&self, middle: Vec3, corner: f64, last: Option<u32>, list: &mut Vec<(f64, u32)>) -> Option<Nearest> {
        list.clear();
        let found = match last {
            Some(facet) => self.exact.nearest_from(middle, facet),
            None => self.exact.nearest(middle, f64::INFINITY)?,
        };
        let reach = (found.distance + 2.0 * corner) * (1.0 + 1e-9);
        self.exact.within(middle, reach, |n| {
            list.push((n.distance, n.facet));
            if list.len() > MOST_KEPT { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if list.len() > MOST_KEPT {
            list.clear();
        }
        list.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        Some(found)
    }
}

/// The samples of a block along an axis.
fn span(block: usize, n: usize) -> std::ops::Range<usize> {
    BLOCK * block..n.min(BLOCK * (block + 1))
}

/// The middle of a block, whose last cells reach to the next block's first samples, and its distance to the corners.
fn middle(grid: &Grid, block: [usize; 3]) -> (Vec3, f64) {
    let half = 0.5 * BLOCK as f64 * grid.h();
    let first = grid.position(block.map(|b| BLOCK * b));
    (first.map(|x| x + half), half * 3f64.sqrt() * (1.0 + 1e-9))
}

/// The nearest of a block's facets; `off` is the distance of the point from the middle of the block.
fn nearest_kept(exact: &MeshDistance, p: Vec3, off: f64, list: &[(f64, u32)]) -> Option<Nearest> {
    let mut best: Option<Nearest> = None;
    for &(from_middle, facet) in list {
        if best.is_some_and(|b| from_middle - off > b.distance) {
            break;
        }
        let found = exact.nearest_of(p, facet);
        if best.is_none_or(|b| found.distance < b.distance || (found.distance == b.distance && facet < b.facet)) {
            best = Some(found);
        }
    }
    best
}

/// Squared distances, in spacings, to the cubes that the surface of a part touches.
pub(super) fn squared_distance_to_shell(part: &Enclosure) -> Result<Field<u32>> {
    squared_distance(&part.outer.difference(&part.inner)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{InsideRule, Primitive, TriangleMesh, enclose};
    use crate::units::Length;

    /// A coarse box and a fine ball in one mesh, so that blocks keep their facets and search for them.
    fn part() -> TriangleMesh {
        let (block, ball) = (Primitive::parse("box:6x5x4mm").unwrap(), Primitive::parse("ball:1.5mm").unwrap());
        let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        block.mesh(Length::mm(1.0)).joined(&ball.mesh(Length::mm(0.001)).transformed(still, [5.5, 0.4, 0.2]))
    }

    #[test]
    fn distances_near_a_level_are_those_to_all_facets() {
        let (mesh, h) = (part(), 0.3);
        let grid = Grid::covering([-5.0; 3], [9.0; 3], Length::mm(h), 1, [0.23, 0.31, 0.27]).unwrap();
        let sides = enclose(&mesh, &grid, InsideRule::Crossings).unwrap();
        let exact = MeshDistance::new(&mesh);
        let shell2 = squared_distance_to_shell(&sides).unwrap();
        let plainly = |p: Vec3| {
            (0..mesh.triangles.len() as u32).map(|f| exact.nearest_of(p, f).distance).fold(f64::INFINITY, f64::min)
        };
        for level in [-0.7, 0.0, 1.3] {
            let (field, near) = Near::of(exact.clone(), &sides.centres, &shell2, level, None).unwrap();
            let (kept, searched): (Vec<_>, Vec<_>) =
                near.facets.iter().enumerate().filter(|f| *f.1 > 0).map(|(at, _)| grid.index(at)).partition(|index| {
                    let block = index.map(|i| i / BLOCK);
                    !near.slabs[block[2]].list(block[1] * near.blocks[0] + block[0]).is_empty()
                });
            assert!(kept.len() > 1000 && searched.len() > 500, "{} {}", kept.len(), searched.len());
            for (n, index) in kept.into_iter().chain(searched).enumerate() {
                if n % 17 > 0 {
                    continue;
                }
                let p = grid.position(index);
                let sign = if sides.centres.contains(index) { -1.0 } else { 1.0 };
                let (found, exact) = (field.values()[grid.offset(index)], (sign * plainly(p) - level) as f32);
                let close = f64::from(exact.abs()) <= EXACT * h;
                assert!(found == exact || !close && found.signum() == exact.signum(), "{found} {exact}");
                assert!(close || f64::from(found.abs()) > h, "{found} {exact}");
                let beside = [0, 1, 2].map(|a| p[a] + h * [0.7, 0.2, 0.9][(a + n) % 3]);
                assert!((near.nearest(beside).unwrap().distance - plainly(beside)).abs() < 1e-12);
            }
        }
    }
}
