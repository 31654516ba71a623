//! What a shape covers along a motion, and what stays inside an envelope under it.

use super::element::{Sides, StructuringElement};
use super::minkowski::{Morphed, dilate, erode};
use super::sandwich::{Sandwich, covering_volume};
use crate::convolution::sum_grid;
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, distance, dot, norm, sub};
use crate::geometry::{InsideRule, TriangleMesh, enclose};
use crate::grid::Grid;
use crate::units::Length;
use rayon::prelude::*;

/// A rigid placement `p ↦ R·p + t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Rotation R, rows.
    pub rotation: [[f64; 3]; 3],
    /// Translation t, millimetres.
    pub translation: Vec3,
}

/// The sweep of a closed mesh along a polyline of translations: `∪ { B + p : p on the path }`.
///
/// Below stand the samples of exact copies at most h/2 apart; above, the cubes that the path touches, dilated by the
/// cubes that B touches. The result's lattice is `h·(Z³ + phase)`.
///
/// # Errors
/// [`Error::Operand`] for a path of fewer than two points or without length, or that is not finite; otherwise as
/// [`enclose`].
///
/// # Cost
/// One cast of B for each half spacing of the path, and one dilation.
pub fn sweep(mesh: &TriangleMesh, path: &[Vec3], spacing: Length, phase: [f64; 3]) -> Result<Sandwich> {
    let h = spacing.as_mm();
    check_path(path)?;
    let element = Sides::of_mesh(mesh, spacing, [0.0; 3])?;
    let cells = path_cells(path, spacing, phase)?;
    let covered = dilate(&cells, &StructuringElement::new(element.touched.clone())?)?;
    let stops = points_along(path, 0.5 * h);
    let grid = sum_grid(cells.grid(), element.points.grid())?;
    let still = Placement { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] };
    let copies: Vec<Placement> = stops.iter().map(|&translation| Placement { translation, ..still }).collect();
    let [full, lower, _] = union_of_copies(mesh, &copies, &grid)?;
    let volume = [full.volume(), covering_volume(&covered.set, 2)?];
    Ok(Sandwich { lower, upper: covered.set, volume, paths: vec![covered.path] })
}

/// The sweep of a closed mesh through poses of a rotating motion: `∪ { m·B }`, on a given grid.
///
/// Below stand the samples of the copies themselves; above, the cubes they touch and all their neighbours, which covers
/// everything between two poses because no point of B moves further than h/2 from one to the next.
///
/// # Errors
/// [`Error::Operand`] for fewer than two poses, or for neighbours between which a vertex moves further than h/2 — the
/// message names the pair, so that poses can be put between them.
///
/// # Cost
/// One cast of B for each pose.
pub fn sweep_poses(mesh: &TriangleMesh, poses: &[Placement], grid: &Grid) -> Result<Sandwich> {
    check_poses(mesh, poses, grid.h())?;
    let [full, lower, outer] = union_of_copies(mesh, poses, grid)?;
    let cube = StructuringElement::cuboid([3; 3], grid.spacing())?;
    let spread = dilate(&outer, &cube)?;
    let upper = spread.set.placed([1; 3], *grid)?;
    Ok(Sandwich { volume: [full.volume(), upper.volume()], lower, upper, paths: vec![spread.path] })
}

/// The sweep of a set of samples along a path of samples: their Minkowski sum.
///
/// # Errors
/// As [`dilate`].
pub fn sweep_set(set: &Indicator, path: &StructuringElement) -> Result<Morphed> {
    dilate(set, path)
}

/// The unsweep: the largest set that stays inside an envelope while it moves along a path of samples,
/// `∩ { E − p : p on the path } = E ⊖ path`.
///
/// # Errors
/// As [`erode`].
pub fn unsweep(envelope: &Indicator, path: &StructuringElement) -> Result<Morphed> {
    erode(envelope, path)
}

/// The samples of the lattice `h·(Z³ + phase)` whose closed cube a polyline touches.
///
/// # Errors
/// [`Error::Operand`] for a path that is not finite.
pub fn path_cells(path: &[Vec3], spacing: Length, phase: [f64; 3]) -> Result<Indicator> {
    let (lo, hi) = crate::geometry::vector::bounds(path.iter().copied()).ok_or_else(|| too_short(path.len()))?;
    let grid = super::element::lattice_box(lo, hi, spacing, phase)?;
    let mut cells = Indicator::empty(grid);
    let pieces: Vec<[Vec3; 2]> = match path {
        [only] => vec![[*only, *only]],
        _ => path.windows(2).map(|w| [w[0], w[1]]).collect(),
    };
    for [from, to] in pieces {
        let [a, b] = [from, to].map(|p| grid.continuous_index(p));
        let range = |axis: usize| {
            let (lo, hi) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
            (lo - 0.5 - 1e-9).ceil().max(0.0) as usize..=((hi + 0.5 + 1e-9).floor() as usize)
        };
        for k in range(2) {
            for j in range(1) {
                for i in range(0) {
                    if segment_meets_cube(a, b, [i as f64, j as f64, k as f64]) {
                        cells.set([i, j, k], true);
                    }
                }
            }
        }
    }
    Ok(cells)
}

/// Whether a segment meets the closed unit cube about a point, with a hair of tolerance outwards.
fn segment_meets_cube(a: Vec3, b: Vec3, centre: Vec3) -> bool {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for i in 0..3 {
        let (start, step) = (a[i] - centre[i], b[i] - a[i]);
        let half = 0.5 + 1e-9;
        if step == 0.0 {
            if start.abs() > half {
                return false;
            }
            continue;
        }
        let (p, q) = ((-half - start) / step, (half - start) / step);
        enter = enter.max(p.min(q));
        leave = leave.min(p.max(q));
    }
    enter <= leave
}

/// Points on a polyline, its corners among them, no further apart than `step`.
fn points_along(path: &[Vec3], step: f64) -> Vec<Vec3> {
    let mut points: Vec<Vec3> = path.first().copied().into_iter().collect();
    for pair in path.windows(2) {
        let pieces = (distance(pair[0], pair[1]) / step).ceil().max(1.0) as usize;
        let between = |n: usize| [0, 1, 2].map(|a| pair[0][a] + (pair[1][a] - pair[0][a]) * n as f64 / pieces as f64);
        points.extend((1..=pieces).map(between));
    }
    points
}

/// The three sides of the union of copies of a mesh, those of each in a window of its own.
fn union_of_copies(mesh: &TriangleMesh, copies: &[Placement], grid: &Grid) -> Result<[Indicator; 3]> {
    let nothing = || [0; 3].map(|_| Indicator::empty(*grid));
    copies
        .par_chunks(copies.len().div_ceil(8).max(1))
        .map(|some| {
            let mut union = nothing();
            for copy in some {
                let moved = mesh.transformed(copy.rotation, copy.translation);
                let Some((first, own)) = window_of(&moved, grid)? else { continue };
                let cast = enclose(&moved, &own, InsideRule::Crossings)?;
                let sides = union.iter_mut().zip([cast.inner, cast.centres, cast.outer]);
                sides.for_each(|(all, side)| all.unite_window(first, &side));
            }
            Ok(union)
        })
        .try_reduce(nothing, |mut a, b| {
            a.iter_mut().zip(&b).for_each(|(a, b)| a.unite_window([0; 3], b));
            Ok(a)
        })
}

/// The samples of a grid that a mesh can reach, as first index and grid; `None` where there are none.
fn window_of(mesh: &TriangleMesh, grid: &Grid) -> Result<Option<([usize; 3], Grid)>> {
    let Some((lo, hi)) = mesh.bounds() else { return Ok(None) };
    let (lo, hi) = (grid.continuous_index(lo), grid.continuous_index(hi));
    let first = lo.map(|x| (x - 1.0).floor().max(0.0) as usize);
    let end = [0, 1, 2].map(|a| ((hi[a] + 2.0).ceil().max(0.0) as usize).min(grid.dims()[a]));
    if (0..3).any(|a| first[a] >= end[a]) {
        return Ok(None);
    }
    let counts = [0, 1, 2].map(|a| end[a] - first[a]);
    Ok(Some((first, Grid::new(grid.position(first), grid.spacing(), counts)?)))
}

fn check_path(path: &[Vec3]) -> Result<()> {
    if path.iter().flatten().any(|x| !x.is_finite()) {
        return Err(Error::Operand {
            operation: "sweep",
            problem: "the path has a coordinate that is not finite".into(),
            remedy: "give numbers in millimetres".into(),
        });
    }
    let length: f64 = path.windows(2).map(|w| norm(sub(w[1], w[0]))).sum();
    if path.len() < 2 || length == 0.0 { Err(too_short(path.len())) } else { Ok(()) }
}

fn check_poses(mesh: &TriangleMesh, poses: &[Placement], h: f64) -> Result<()> {
    if poses.len() < 2 {
        return Err(too_short(poses.len()));
    }
    let image = |m: &Placement, p: Vec3| [0, 1, 2].map(|r| dot(m.rotation[r], p) + m.translation[r]);
    for (at, pair) in poses.windows(2).enumerate() {
        let furthest =
            mesh.vertices.iter().map(|&v| distance(image(&pair[0], v), image(&pair[1], v))).fold(0.0, f64::max);
        if furthest.is_nan() || furthest > 0.5 * h {
            return Err(Error::Operand {
                operation: "sweep",
                problem: format!(
                    "between poses {at} and {} a point moves {furthest:.3} mm, half a spacing is {:.3}",
                    at + 1,
                    0.5 * h
                ),
                remedy: "put poses between them, or choose a larger spacing".into(),
            });
        }
    }
    Ok(())
}

fn too_short(points: usize) -> Error {
    Error::Operand {
        operation: "sweep",
        problem: format!("a path of {points} point(s) and no length"),
        remedy: "give at least two different points".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;

    fn mesh(text: &str) -> TriangleMesh {
        Primitive::parse(text).unwrap().mesh(Length::mm(0.01))
    }

    #[test]
    fn a_box_along_a_line_is_a_longer_box() {
        let h = Length::mm(0.25);
        let path = [[-2.0, 0.5, 0.0], [3.0, 0.5, 0.0]];
        let found = sweep(&mesh("box:1x2x1mm"), &path, h, [0.25, 0.75, 0.5]).unwrap();
        let whole = Primitive::parse("box:6x2x1mm").unwrap();
        let grid = found.lower.grid();
        assert_eq!(grid, found.upper.grid());
        for at in 0..grid.samples() {
            let p = grid.position(grid.index(at));
            let d = whole.signed_distance([p[0] - 0.5, p[1] - 0.5, p[2]]);
            assert!(d < 1e-9 || !found.lower.contains(grid.index(at)), "{p:?}");
            assert!(d > -1e-9 || found.upper.contains(grid.index(at)), "{p:?}");
        }
        let [low, high] = found.volume.map(|v| v.as_mm3());
        assert!(0.0 < low && low <= 12.0 && 12.0 <= high);
    }

    #[test]
    fn a_bar_turned_in_place_covers_a_disk() {
        let h = 0.25;
        let steps = 110; // half a turn: the corner of the bar, 4.03 mm out, moves 0.115 mm a step
        let poses: Vec<Placement> = (0..=steps)
            .map(|n| {
                let (s, c) = (std::f64::consts::PI * f64::from(n) / f64::from(steps)).sin_cos();
                Placement { rotation: [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] }
            })
            .collect();
        let grid = Grid::covering([-5.0, -5.0, -1.0], [5.0, 5.0, 1.0], Length::mm(h), 1, [0.1; 3]).unwrap();
        let bar = mesh("box:8x1x1mm");
        assert!(matches!(sweep_poses(&bar, &[poses[0], poses[50]], &grid), Err(Error::Operand { .. })));
        let found = sweep_poses(&bar, &poses, &grid).unwrap();
        // Half a turn of a centred bar is the whole disk, but for scallops that the outer set covers.
        let radius = 4f64.hypot(0.5);
        for at in 0..grid.samples() {
            let p = grid.position(grid.index(at));
            let r = p[0].hypot(p[1]);
            let inside = r < radius - 1e-9 && p[2].abs() < 0.5 - 1e-9;
            let outside = r > radius + 1e-9 || p[2].abs() > 0.5 + 1e-9;
            assert!(!outside || !found.lower.contains(grid.index(at)));
            assert!(!inside || found.upper.contains(grid.index(at)));
        }
        let volume = std::f64::consts::PI * radius * radius;
        assert!(found.volume[0].as_mm3() < volume && volume < found.volume[1].as_mm3());
    }

    #[test]
    fn unsweep_is_the_largest_set_that_stays_inside() {
        let h = Length::mm(1.0);
        let grid = Grid::new([0.0; 3], h, [9, 4, 3]).unwrap();
        let envelope = Indicator::from_predicate(grid, |at| at % 11 != 0);
        let path = StructuringElement::new(path_cells(&[[0.0; 3], [2.0, 1.0, 0.0]], h, [0.0; 3]).unwrap()).unwrap();
        let most = unsweep(&envelope, &path).unwrap().set;
        let swept = sweep_set(&most, &path).unwrap().set;
        let first = [0, 1, 2].map(|a| (-swept.grid().origin()[a]).round() as isize);
        assert!(swept.placed(first, grid).unwrap().is_subset(&envelope).unwrap());
        assert_eq!(swept.placed(first, grid).unwrap().count(), swept.count());
    }

    #[test]
    fn paths_without_length_are_refused() {
        let b = mesh("ball:1mm");
        for path in [vec![], vec![[0.0; 3]], vec![[1.0; 3], [1.0; 3]], vec![[0.0; 3], [f64::NAN; 3]]] {
            assert!(sweep(&b, &path, Length::mm(0.5), [0.0; 3]).is_err());
        }
    }
}
