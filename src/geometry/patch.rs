//! Flat patches, and the edges of a lattice that they cross.

use super::vector::{Vec3, add, cross, norm, scale, sub, unit};
use crate::grid::Grid;

/// A patch reaches so far beyond its sides, as a share of them, and an edge beyond its ends: nothing passes between two by rounding.
const SEAM: f64 = 1e-9;

/// Lines that meet a patch at a smaller angle, radians, run along it.
const ALONG: f64 = 1e-9;

/// A triangle or a parallelogram, by a corner and the two sides that start there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    corner: Vec3,
    sides: [Vec3; 2],
    /// What the shares of the two sides sum up to at most: 1 in a triangle.
    most: f64,
}

/// Where a patch crosses an edge of a lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossed {
    /// The sample the edge starts at.
    pub from: [usize; 3],
    /// Along x, y or z: 0, 1 or 2.
    pub axis: usize,
    /// From 0 to 1 along the edge.
    pub at: f64,
}

impl Patch {
    /// The triangle with these corners.
    pub fn triangle([p, q, r]: [Vec3; 3]) -> Self {
        Patch { corner: p, sides: [sub(q, p), sub(r, p)], most: 1.0 }
    }

    /// The parallelogram with a corner and the sides that start there.
    pub fn parallelogram(corner: Vec3, sides: [Vec3; 2]) -> Self {
        Patch { corner, sides, most: 2.0 }
    }

    /// A unit normal, on either side.
    pub fn normal(&self) -> Vec3 {
        unit(cross(self.sides[0], self.sides[1]))
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        0.5 * self.most * norm(cross(self.sides[0], self.sides[1]))
    }

    /// Its three or four corners.
    pub fn corners(&self) -> Vec<Vec3> {
        let [p, q, r] = [self.corner, add(self.corner, self.sides[0]), add(self.corner, self.sides[1])];
        if self.most > 1.0 { vec![p, q, add(q, self.sides[1]), r] } else { vec![p, q, r] }
    }

    /// Calls `visit` for the edges of a grid's lattice that the patch crosses; for both edges beside a sample that lies on it.
    ///
    /// # Cost
    /// A few operations for each line of the lattice that crosses it, and for each plane of lines that meets it.
    ///
    /// ```
    /// use amcheck::geometry::patch::Patch;
    /// use amcheck::{grid::Grid, units::Length};
    /// let grid = Grid::new([0.0; 3], Length::mm(1.0), [4, 4, 4])?;
    /// let flat = Patch::parallelogram([0.5, 0.5, 1.25], [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    /// let mut crossed = Vec::new();
    /// flat.crossings(&grid, |edge| crossed.push((edge.from, edge.axis, edge.at)));
    /// assert_eq!(crossed, [([1, 1, 1], 2, 0.25), ([2, 1, 1], 2, 0.25)]);
    /// # Ok::<(), amcheck::error::Error>(())
    /// ```
    pub fn crossings(&self, grid: &Grid, mut visit: impl FnMut(Crossed)) {
        let corner = grid.continuous_index(self.corner);
        let sides = self.sides.map(|side| scale(side, 1.0 / grid.h()));
        for axis in 0..3 {
            let lines = Lines::new(axis, corner, sides, self.most);
            lines.each(grid.dims(), |from, height| along_line(from, axis, height, grid.dims()[axis], &mut visit));
        }
    }
}

/// The edges of a line that hold a height in spacings.
fn along_line(mut from: [usize; 3], axis: usize, height: f64, samples: usize, visit: &mut impl FnMut(Crossed)) {
    let nearest = height.round();
    let mut edge = |first: f64, at: f64| {
        if first >= 0.0 && first < (samples - 1) as f64 {
            from[axis] = first as usize;
            visit(Crossed { from, axis, at });
        }
    };
    if (height - nearest).abs() <= SEAM * (1.0 + height.abs()) {
        edge(nearest - 1.0, 1.0);
        edge(nearest, 0.0);
    } else {
        edge(height.floor(), height - height.floor());
    }
}

/// The lines along an axis that cross a patch, all in spacings.
struct Lines {
    /// The axis of the lines, that of the planes of lines, and that across these.
    axes: [usize; 3],
    corner: Vec3,
    sides: [Vec3; 2],
    most: f64,
    /// Twice the area that the patch shows to the lines; 0 if they run along it.
    shown: f64,
}

impl Lines {
    fn new(axis: usize, corner: Vec3, sides: [Vec3; 2], most: f64) -> Self {
        let axes = [axis, (axis + 1) % 3, (axis + 2) % 3];
        let area = cross(sides[0], sides[1]);
        let runs_along = area[axis].abs() <= ALONG * norm(area);
        Lines { axes, corner, sides, most, shown: if runs_along { 0.0 } else { area[axis] } }
    }

    /// Calls `visit` with the first sample of a line, and the height where it crosses.
    fn each(&self, dims: [usize; 3], mut visit: impl FnMut([usize; 3], f64)) {
        if self.shown == 0.0 {
            return;
        }
        let [a, b, c] = self.axes;
        let last = if self.most > 1.0 { self.sides[0][b] + self.sides[1][b] } else { 0.0 };
        let reach = [0.0, self.sides[0][b], self.sides[1][b], last];
        let least = reach.into_iter().fold(f64::INFINITY, f64::min);
        let greatest = reach.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let slack = SEAM * (greatest - least);
        for j in within(self.corner[b] + least - slack, self.corner[b] + greatest + slack, dims[b]) {
            let share = self.shares(j as f64 - self.corner[b]);
            let Some((low, high)) = share.extent(self.most) else { continue };
            for k in within(self.corner[c] + low, self.corner[c] + high, dims[c]) {
                let [u, v] = share.at(k as f64 - self.corner[c]);
                let mut from = [0; 3];
                (from[b], from[c]) = (j, k);
                visit(from, self.corner[a] + u * self.sides[0][a] + v * self.sides[1][a]);
            }
        }
    }

    /// The shares of the two sides along a line of the plane, as they change with the way from the corner.
    fn shares(&self, off: f64) -> Shares {
        let [_, b, c] = self.axes;
        let [p, q] = self.sides;
        Shares {
            start: [off * q[c] / self.shown, -off * p[c] / self.shown],
            slope: [-q[b] / self.shown, p[b] / self.shown],
        }
    }
}

/// Shares of two sides that change evenly.
struct Shares {
    start: [f64; 2],
    slope: [f64; 2],
}

impl Shares {
    fn at(&self, x: f64) -> [f64; 2] {
        [0, 1].map(|i| self.start[i] + self.slope[i] * x)
    }

    /// Where each share is from 0 to 1, and their sum at most `most`.
    fn extent(&self, most: f64) -> Option<(f64, f64)> {
        let ([u, v], [du, dv]) = (self.start, self.slope);
        let bounds = [
            (u + SEAM, du),
            (v + SEAM, dv),
            (1.0 + SEAM - u, -du),
            (1.0 + SEAM - v, -dv),
            (most + SEAM - u - v, -du - dv),
        ];
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (value, slope) in bounds {
            let root = -value / slope;
            if slope > 0.0 {
                low = low.max(root);
            } else if slope < 0.0 {
                high = high.min(root);
            } else if value < 0.0 {
                return None;
            }
        }
        (low <= high).then_some((low, high))
    }
}

/// The samples between two places.
fn within(low: f64, high: f64, samples: usize) -> std::ops::Range<usize> {
    let end = (high.floor() + 1.0).clamp(0.0, samples as f64) as usize;
    (low.ceil().max(0.0) as usize).min(end)..end
}

#[cfg(test)]
mod tests {
    use super::super::ray::Ray;
    use super::*;
    use crate::random::Lcg;
    use crate::units::Length;

    /// The crossings of a triangle as every edge of the lattice meets it.
    fn by_every_edge(grid: &Grid, triangle: [Vec3; 3]) -> Vec<Crossed> {
        let mut found = Vec::new();
        for at in 0..grid.samples() {
            for axis in 0..3 {
                let from = grid.index(at);
                let way = [0, 1, 2].map(|a| if a == axis { grid.h() } else { 0.0 });
                match Ray::of(grid.position(from), way).hit(triangle) {
                    Some(s) if (0.0..=1.0).contains(&s) && from[axis] + 1 < grid.dims()[axis] => {
                        found.push(Crossed { from, axis, at: s });
                    }
                    _ => {}
                }
            }
        }
        found
    }

    fn crossings(grid: &Grid, patch: Patch) -> Vec<Crossed> {
        let mut found = Vec::new();
        patch.crossings(grid, |crossed| found.push(crossed));
        found.sort_by_key(|c| (grid.offset(c.from), c.axis));
        found
    }

    #[test]
    fn a_patch_crosses_the_edges_that_meet_it() {
        let grid = Grid::new([-1.0, 0.5, 0.0], Length::mm(0.4), [12, 10, 11]).unwrap();
        let (mut random, mut count) = (Lcg(8), 0);
        for n in 0..400 {
            let p = random.point(-1.5, 4.5);
            let size = [0.3, 1.0, 5.0, 20.0][n % 4];
            let [q, r] = [0; 2].map(|_| add(p, random.point(-size, size)));
            let alike = |found: Vec<Crossed>, want: Vec<Crossed>| {
                let places = |list: &[Crossed]| list.iter().map(|c| (c.from, c.axis)).collect::<Vec<_>>();
                assert_eq!(places(&found), places(&want), "{p:?} {q:?} {r:?}");
                assert!(found.iter().zip(&want).all(|(c, d)| (c.at - d.at).abs() < 1e-6), "{found:?} {want:?}");
                found.len()
            };
            count += alike(crossings(&grid, Patch::triangle([p, q, r])), by_every_edge(&grid, [p, q, r]));
            let sides = [sub(q, p), sub(r, p)];
            let mut halves = by_every_edge(&grid, [p, q, r]);
            halves.extend(by_every_edge(&grid, [add(q, sides[1]), q, r]));
            halves.sort_by_key(|c| (grid.offset(c.from), c.axis));
            alike(crossings(&grid, Patch::parallelogram(p, sides)), halves);
        }
        assert!(count > 1000, "{count}");
    }

    #[test]
    fn a_sample_on_a_patch_is_met_from_all_sides_and_patches_side_by_side_leave_no_gap() {
        let grid = Grid::new([0.0; 3], Length::mm(0.1), [9, 9, 9]).unwrap();
        // Through samples in all of its corners and along its diagonal.
        let corner = |x: f64, y: f64| [0.1 * x, 0.1 * y, 0.3];
        let flat = [
            [corner(1.0, 1.0), corner(7.0, 1.0), corner(7.0, 7.0)],
            [corner(1.0, 1.0), corner(7.0, 7.0), corner(1.0, 7.0)],
        ];
        let found: Vec<Crossed> = flat.into_iter().flat_map(|t| crossings(&grid, Patch::triangle(t))).collect();
        for (x, y) in (1..=7).flat_map(|x| (1..=7).map(move |y| (x, y))) {
            for (z, at) in [(2, 1.0), (3, 0.0)] {
                assert!(found.contains(&Crossed { from: [x, y, z], axis: 2, at }), "{x} {y} {z}");
            }
        }
        assert!(found.iter().all(|c| c.axis == 2));
    }
}
