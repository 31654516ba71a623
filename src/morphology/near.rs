//! Exact distances from the samples near a level to a mesh: facets are gathered once for a block of samples.
//!
//! With c the middle of a block and ρ the distance from it to the block's corners, the nearest facet of any point in the
//! block is no further from c than the facet nearest to c by 2ρ: |c − f| ≤ ρ + d(p) ≤ 2ρ + d(c). Where few facets are so
//! near, they are kept for the block; where many are, each point searches the tree from the facet of its neighbour.

use super::bodies::{Around, Ball, Facets};
use crate::distance::squared_distance;
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::distance::Nearest;
use crate::geometry::vector::{Vec3, distance, dot, scale, sub};
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

/// How deep, in spacings, samples lie that a body holds whose surface is not near.
const DEEP: f64 = 2.0;

/// A segment is searched for facets by this much beyond its ends, as a share of it.
const BEYOND: f64 = 1e-9;

/// The mesh as seen from the samples of a grid.
pub(super) struct Near {
    of: Facets,
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
    /// Where the bodies of each block start in `bodies`, and where those of the last one end.
    body_firsts: Vec<u32>,
    /// Those that can hold a point of the block, where facets of several are near: as [`Bodies::around`] lists them.
    bodies: Vec<(f64, u32)>,
}

impl Near {
    /// The signed distances less `level`, in millimetres: exact within [`EXACT`] spacings of zero, farther from it
    /// and of the right sign everywhere else; and the facets there for further points.
    ///
    /// `shell2` are squared distances, in spacings, to the cubes that facets touch. Samples `known` otherwise are not
    /// measured exactly.
    pub(super) fn of(
        of: Facets,
        centres: &Indicator,
        shell2: &Field<u32>,
        level: f64,
        known: Option<&Indicator>,
    ) -> Result<(Field<f32>, Self)> {
        let grid = *centres.grid();
        let [nx, ny, _] = grid.dims();
        let (mut values, mut facets) = (vec![0f32; grid.samples()], vec![0u32; grid.samples()]);
        let thick = BLOCK * nx * ny;
        let band = Band { of: &of, centres, grid, level, known };
        let slabs = (values.par_chunks_mut(thick), facets.par_chunks_mut(thick), shell2.values().par_chunks(thick))
            .into_par_iter()
            .enumerate()
            .with_max_len(1)
            .map(|(slab, (values, facets, shell2))| {
                band.about(slab, shell2, values);
                band.exactly(slab, values, facets)
            })
            .collect();
        let near = Near { of, grid, blocks: [nx, ny].map(|n| n.div_ceil(BLOCK)), slabs, facets };
        Ok((Field::from_values(grid, values, f32::MAX)?, near))
    }

    /// The spacing of the samples, millimetres.
    pub(super) fn h(&self) -> f64 {
        self.grid.h()
    }

    /// Whether several bodies are measured to as one.
    pub(super) fn is_of_union(&self) -> bool {
        self.of.bodies.is_some()
    }

    /// The distances to the mesh.
    pub(super) fn mesh(&self) -> &MeshDistance {
        &self.of.exact
    }

    /// What was measured to, for other samples or another level.
    pub(super) fn into_facets(self) -> Facets {
        self.of
    }

    /// The point of the mesh nearest to a sample that was measured exactly.
    pub(super) fn nearest_of_sample(&self, index: [usize; 3]) -> Option<Nearest> {
        let facet = self.facets[self.grid.offset(index)].checked_sub(1)?;
        Some(self.of.exact.nearest_of(self.grid.position(index), facet))
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
        let n = self.of.exact.nearest_of(p, facet);
        let side = if value < 0.0 { -1.0 } else { 1.0 };
        (n.distance > 1e-9 * self.grid.h()).then(|| scale(sub(p, n.point), side / n.distance))
    }

    /// Outward normal of the facet that a nearest point lies on.
    pub(super) fn facing(&self, n: &Nearest) -> Vec3 {
        self.of.exact.normal(n.facet)
    }

    /// The point of the mesh nearest to a point near the level; in a union of bodies that of the body that holds the point
    /// deepest, if any does.
    pub(super) fn nearest(&self, p: Vec3) -> Option<Nearest> {
        let (exact, place) = (&self.of.exact, self.place(p));
        let (list, off) = (self.slabs.get(place.block[2])?.list(place.number), distance(p, place.ball.middle));
        if let Some(found) = self.deepest(p) {
            return Some(found);
        }
        if !list.is_empty() && off <= place.ball.radius {
            return nearest_kept(exact, p, off, list);
        }
        let [nx, ny, nz] = self.grid.dims();
        let corners = (0..8).map(|at| [0, 1, 2].map(|a| place.index[a] + (at >> a & 1)));
        let seed = corners
            .filter(|&[i, j, k]| i < nx && j < ny && k < nz)
            .map(|[i, j, k]| self.facets[(k * ny + j) * nx + i])
            .find(|&facet| facet > 0);
        match seed {
            Some(facet) => Some(exact.nearest_from(p, facet - 1)),
            None => exact.nearest(p, f64::INFINITY),
        }
    }

    /// Whether a point is inside, whose nearest point is given.
    pub(super) fn is_inside(&self, p: Vec3, nearest: &Nearest) -> bool {
        if self.is_of_union() { self.deepest(p).is_some() } else { self.of.exact.is_behind(p, nearest) }
    }

    /// The point nearest to one inside a union of bodies whose surfaces are near, of the body that holds it deepest.
    pub(super) fn deepest(&self, p: Vec3) -> Option<Nearest> {
        let bodies = self.of.bodies.as_ref()?;
        let place = self.place(p);
        let list = self.slabs.get(place.block[2])?.bodies(place.number);
        bodies.deepest(&self.of.exact, p, distance(p, place.ball.middle), list)
    }

    /// The point nearest to x of the body that a facet nearer than `within` belongs to, in a union of bodies.
    pub(super) fn on_body_of(&self, facet: u32, x: Vec3, within: f64) -> Option<Nearest> {
        self.of.bodies.as_ref()?.on_body_of(&self.of.exact, facet, x, within)
    }

    /// Where the segment from p to p + d enters a union of bodies, if p lies outside: its first facet, which looks back at p,
    /// since the winding number is nowhere negative. Holds where a body passes through itself, too.
    pub(super) fn entry(&self, p: Vec3, d: Vec3) -> Option<(f64, Vec3)> {
        self.of.bodies.as_ref()?;
        let (t, facet) = self.of.exact.first_hit(p, d, -BEYOND, 1.0 + BEYOND)?;
        let normal = self.of.exact.normal(facet);
        (dot(normal, d) < 0.0).then_some((t, normal))
    }

    /// Where a point stands on the grid.
    fn place(&self, p: Vec3) -> Place {
        let place = self.grid.continuous_index(p);
        let index = [0, 1, 2].map(|a| place[a].clamp(0.0, self.grid.dims()[a] as f64 - 1.0) as usize);
        let block = index.map(|i| i / BLOCK);
        Place { index, block, number: block[1] * self.blocks[0] + block[0], ball: ball(&self.grid, block) }
    }
}

/// The sample before a point, its block, the block's number in its layer, and the ball about it.
struct Place {
    index: [usize; 3],
    block: [usize; 3],
    number: usize,
    ball: Ball,
}

impl Slab {
    fn start_block(&mut self) {
        self.firsts.push(self.kept.len() as u32);
        self.body_firsts.push(self.bodies.len() as u32);
    }

    fn list(&self, block: usize) -> &[(f64, u32)] {
        match self.firsts.get(block..block + 2) {
            Some(&[first, end]) => &self.kept[first as usize..end as usize],
            _ => &[],
        }
    }

    fn bodies(&self, block: usize) -> &[(f64, u32)] {
        match self.body_firsts.get(block..block + 2) {
            Some(&[first, end]) => &self.bodies[first as usize..end as usize],
            _ => &[],
        }
    }
}

/// What a layer of blocks is measured with.
struct Band<'a> {
    of: &'a Facets,
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
        let [nx, ny, _] = self.grid.dims();
        let mut out = Slab::default();
        let (mut last, mut samples) = (None, Vec::new());
        let (mut list, mut bodies) = (Vec::new(), Vec::new());
        for block_y in 0..ny.div_ceil(BLOCK) {
            for block_x in 0..nx.div_ceil(BLOCK) {
                out.start_block();
                let block = [block_x, block_y, slab];
                self.asked(block, values, &mut samples);
                if samples.is_empty() {
                    continue;
                }
                let ball = ball(&self.grid, block);
                let Some(found) = self.gather(ball, last, &mut list) else { continue };
                let around = match &self.of.bodies {
                    Some(of) => of.around(&self.of.exact, ball, &found, DEEP * self.grid.h(), &mut bodies),
                    None => Around::One,
                };
                let block = Block { ball, around, facets: &list, bodies: &bodies };
                last = Some(self.measure(&samples, &block, found.facet, values, facets));
                out.kept.extend_from_slice(&list);
                out.bodies.extend_from_slice(&bodies);
            }
        }
        out.start_block();
        out
    }

    /// The samples of a block that seem near the level, with their places in the layer.
    fn asked(&self, [block_x, block_y, slab]: [usize; 3], values: &[f32], samples: &mut Vec<(usize, [usize; 3])>) {
        let ([nx, ny, _], near) = (self.grid.dims(), (SEEN * self.grid.h()) as f32);
        samples.clear();
        for layer in 0..values.len() / (nx * ny) {
            let k = BLOCK * slab + layer;
            for j in span(block_y, ny) {
                let row = (layer * ny + j) * nx;
                let known = |i| self.known.is_some_and(|known| known.contains([i, j, k]));
                let asked = span(block_x, nx).filter(|&i| values[row + i].abs() <= near && !known(i));
                samples.extend(asked.map(|i| (row + i, [i, j, k])));
            }
        }
    }

    /// Measures samples of a block, seeking from a facet near it; the last one found.
    fn measure(
        &self,
        samples: &[(usize, [usize; 3])],
        block: &Block,
        mut facet: u32,
        values: &mut [f32],
        facets: &mut [u32],
    ) -> u32 {
        let (exact, middle) = (&self.of.exact, block.ball.middle);
        for &(at, index) in samples {
            let (p, inside) = (self.grid.position(index), self.centres.contains(index));
            if inside && block.around == Around::Within {
                values[at] = (-DEEP * self.grid.h() - self.level) as f32;
                continue;
            }
            let side = if inside { -1.0 } else { 1.0 };
            let off = distance(p, middle);
            let bodies = self.of.bodies.as_ref().filter(|_| inside && !block.bodies.is_empty());
            let deepest = bodies.and_then(|of| of.deepest(exact, p, off, block.bodies));
            let kept = deepest.or_else(|| nearest_kept(exact, p, off, block.facets));
            let found = kept.unwrap_or_else(|| self.searched(p, facet, side * self.level));
            values[at] = (side * found.distance - self.level) as f32;
            facets[at] = found.facet + 1;
            facet = found.facet;
        }
        facet
    }

    /// The point of the mesh nearest to p, sought from a facet that should be near it, where its distance differs from
    /// `about` by less than [`EXACT`] spacings; else a distance between, and that facet.
    fn searched(&self, p: Vec3, facet: u32, about: f64) -> Nearest {
        let start = self.of.exact.nearest_of(p, facet);
        let [low, high] = [-EXACT, EXACT].map(|off| about + off * self.grid.h());
        let bound = |distance| Nearest { distance, ..start };
        if start.distance <= low {
            return start;
        }
        if high <= 0.0 {
            return bound(0.0);
        }
        self.of.exact.nearest(p, high.min(start.distance.next_up())).unwrap_or(bound(high))
    }

    /// The facet nearest to the middle of a block; and in `list` all that can be nearest to a point of it, or none if
    /// these are many.
    fn gather(&self, block: Ball, last: Option<u32>, list: &mut Vec<(f64, u32)>) -> Option<Nearest> {
        list.clear();
        let exact = &self.of.exact;
        let found = match last {
            Some(facet) => exact.nearest_from(block.middle, facet),
            None => exact.nearest(block.middle, f64::INFINITY)?,
        };
        let reach = (found.distance + 2.0 * block.radius) * (1.0 + 1e-9);
        exact.within(block.middle, reach, |n| {
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

/// What the samples of a block are measured with.
struct Block<'a> {
    ball: Ball,
    around: Around,
    facets: &'a [(f64, u32)],
    bodies: &'a [(f64, u32)],
}

/// The samples of a block along an axis.
fn span(block: usize, n: usize) -> std::ops::Range<usize> {
    BLOCK * block..n.min(BLOCK * (block + 1))
}

/// The ball about a block, whose last cells reach to the next block's first samples.
fn ball(grid: &Grid, block: [usize; 3]) -> Ball {
    let half = 0.5 * BLOCK as f64 * grid.h();
    let first = grid.position(block.map(|b| BLOCK * b));
    Ball { middle: first.map(|x| x + half), radius: half * 3f64.sqrt() * (1.0 + 1e-9) }
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
            let (field, near) = Near::of(exact.clone().into(), &sides.centres, &shell2, level, None).unwrap();
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
