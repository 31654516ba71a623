//! What a shape covers along a motion.

use super::element::{Sides, StructuringElement, lattice_box};
use super::minkowski::{Morphed, dilate};
use super::offset::{Shaped, united};
use super::sandwich::Sandwich;
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, add, bounds, distance, dot, norm, sub};
use crate::geometry::{InsideRule, TriangleMesh, enclose, swept};
use crate::grid::Grid;
use crate::units::Length;
use rayon::prelude::*;

/// More facets than this are not kept at once for the surface of a sweep: memory grows with them and their tree.
const MOST_FACETS: usize = 1 << 20;

/// A rigid placement `p ↦ R·p + t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Rotation R, rows.
    pub rotation: [[f64; 3]; 3],
    /// Translation t, millimetres.
    pub translation: Vec3,
}

/// The sweep of a closed mesh along a polyline of translations, from three sides: `∪ { B + p : p on the path }`.
///
/// Each piece of the path sweeps a solid of facets ([`swept`]), whose samples and cubes are exact; the three sides are
/// their unions. The lattice is `h·(Z³ + phase)`.
///
/// # Errors
/// [`Error::Operand`] for a path of fewer than two points or without length, or that is not finite; otherwise as
/// [`enclose`].
///
/// # Cost
/// One cast for each piece, in a window of its own.
///
/// ```
/// use amcheck::{geometry::cuboid, morphology::sweep, units::Length};
/// let bar = sweep(&cuboid([0.0; 3], [1.0; 3]), &[[0.0; 3], [4.0, 0.0, 0.0]], Length::mm(0.25), [0.5; 3])?;
/// assert!((bar.points.volume().as_mm3() - 5.0).abs() < 1e-9);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn sweep(mesh: &TriangleMesh, path: &[Vec3], spacing: Length, phase: [f64; 3]) -> Result<Sides> {
    check_path(path)?;
    let (lo, hi) = swept_box(mesh, path)?;
    let grid = lattice_box(lo, hi, spacing, phase)?;
    union(&pieces(path), &grid, |&[p, v]| swept(mesh, p, v))
}

/// The surface of the sweep of a closed mesh along a polyline, from exact distances to the solids that its pieces sweep;
/// `None` where these have more than a million facets.
///
/// Vertices lie on the surface, and those on creases where two solids meet are found as those of an [`super::offset()`]. Where a piece's
/// solid passes through itself, as that of a concave element may, its facets inside widen the bracket, and nothing else.
///
/// # Errors
/// As [`sweep`] and [`super::offset()`].
///
/// # Cost
/// As an [`super::offset()`] of a mesh with the element's facets once for each piece, and where pieces meet, a distance and perhaps a
/// winding number for each of them.
pub fn sweep_surface(mesh: &TriangleMesh, path: &[Vec3], spacing: Length) -> Result<Option<Shaped>> {
    check_path(path)?;
    let pieces = pieces(path);
    if mesh.triangles.len().saturating_mul(pieces.len()) > MOST_FACETS {
        return Ok(None);
    }
    let solids: Vec<TriangleMesh> = pieces.iter().map(|&[p, v]| swept(mesh, p, v)).collect();
    united(&solids, spacing).map(Some)
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
    between_copies(&copies(mesh, poses, grid)?)
}

/// The three sides of the copies of a closed mesh at the poses of a motion, on a given grid.
///
/// # Errors
/// As [`sweep_poses`].
///
/// # Cost
/// One cast of the mesh for each pose.
pub fn copies(mesh: &TriangleMesh, poses: &[Placement], grid: &Grid) -> Result<Sides> {
    check_poses(mesh, poses, grid.h())?;
    union(poses, grid, |pose| mesh.transformed(pose.rotation, pose.translation))
}

/// What lies between the [`copies`] at the poses of a motion, as [`sweep_poses`] has it.
///
/// # Errors
/// As [`dilate`].
///
/// # Cost
/// One dilation of a set of samples.
pub fn between_copies(copies: &Sides) -> Result<Sandwich> {
    let grid = *copies.points.grid();
    let cube = StructuringElement::cuboid([3; 3], grid.spacing())?;
    let spread = dilate(&copies.touched, &cube)?;
    let upper = spread.set.placed([1; 3], grid)?;
    let volume = [copies.full.volume(), upper.volume()];
    Ok(Sandwich { lower: copies.points.clone(), upper, volume, paths: vec![spread.path] })
}

/// The sweep of a set of samples along a path of samples: their Minkowski sum.
///
/// # Errors
/// As [`dilate`].
pub fn sweep_set(set: &Indicator, path: &StructuringElement) -> Result<Morphed> {
    dilate(set, path)
}

/// The samples of the lattice `h·(Z³ + phase)` whose closed cube a polyline touches.
///
/// # Errors
/// [`Error::Operand`] for a path that is not finite.
pub fn path_cells(path: &[Vec3], spacing: Length, phase: [f64; 3]) -> Result<Indicator> {
    let (lo, hi) = bounds(path.iter().copied()).ok_or_else(|| too_short(path.len()))?;
    let grid = lattice_box(lo, hi, spacing, phase)?;
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

/// The pieces of a polyline that have a length: where each starts, and its way.
pub(super) fn pieces(path: &[Vec3]) -> Vec<[Vec3; 2]> {
    let moving = path.windows(2).filter(|pair| pair[0] != pair[1]);
    moving.map(|pair| [pair[0], sub(pair[1], pair[0])]).collect()
}

/// The three sides of the union of meshes, those of each in a window of its own.
pub(super) fn union<T: Sync>(copies: &[T], grid: &Grid, mesh_of: impl Fn(&T) -> TriangleMesh + Sync) -> Result<Sides> {
    let nothing = || [0; 3].map(|_| Indicator::empty(*grid));
    let unite = |mut all: [Indicator; 3], sides: &[Indicator; 3], first| {
        all.iter_mut().zip(sides).for_each(|(all, side)| all.unite_window(first, side));
        all
    };
    let some = |some: &[T]| {
        some.iter().try_fold(nothing(), |all, copy| {
            let mesh = mesh_of(copy);
            let Some((first, own)) = window_of(&mesh, grid)? else { return Ok(all) };
            let cast = enclose(&mesh, &own, InsideRule::Crossings)?;
            Ok(unite(all, &[cast.inner, cast.centres, cast.outer], first))
        })
    };
    let chunks = copies.par_chunks(copies.len().div_ceil(8).max(1)).map(some);
    let [full, points, touched] = chunks.try_reduce(nothing, |a, b| Ok(unite(a, &b, [0; 3])))?;
    Ok(Sides { full, points, touched })
}

/// The box of what a mesh sweeps along a path.
fn swept_box(mesh: &TriangleMesh, path: &[Vec3]) -> Result<(Vec3, Vec3)> {
    let (own, way) = (mesh.bounds().ok_or_else(no_facets)?, bounds(path.iter().copied()).unwrap_or_default());
    Ok((add(own.0, way.0), add(own.1, way.1)))
}

/// The samples of a grid that a mesh can reach, as first index and grid; `None` where there are none.
pub(super) fn window_of(mesh: &TriangleMesh, grid: &Grid) -> Result<Option<([usize; 3], Grid)>> {
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

pub(super) fn check_path(path: &[Vec3]) -> Result<()> {
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

pub(super) fn check_poses(mesh: &TriangleMesh, poses: &[Placement], h: f64) -> Result<()> {
    if poses.len() < 2 {
        return Err(too_short(poses.len()));
    }
    let numbers = |m: &Placement| m.rotation.into_iter().flatten().chain(m.translation).all(f64::is_finite);
    if let Some(at) = poses.iter().position(|pose| !numbers(pose)) {
        return Err(Error::Operand {
            operation: "sweep",
            problem: format!("pose {at} has a coordinate that is not finite"),
            remedy: "give numbers in millimetres, and rotations as rows of their matrices".into(),
        });
    }
    let image = |m: &Placement, p: Vec3| [0, 1, 2].map(|r| dot(m.rotation[r], p) + m.translation[r]);
    for (at, pair) in poses.windows(2).enumerate() {
        let furthest =
            mesh.vertices.iter().map(|&v| distance(image(&pair[0], v), image(&pair[1], v))).fold(0.0, f64::max);
        if furthest > 0.5 * h {
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

pub(super) fn no_facets() -> Error {
    Error::NoGeometry { problem: "the mesh has no facets".into(), remedy: "give a closed mesh".into() }
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
    use crate::geometry::{MeshDistance, Primitive, Winding, extruded};

    fn mesh(text: &str) -> TriangleMesh {
        Primitive::parse(text).unwrap().mesh(Length::mm(0.01))
    }

    /// Checks the sides against a shape about a place, up to rounding.
    fn encloses(found: &Sides, shape: &Primitive, middle: Vec3, h: Length) {
        let grid = *found.points.grid();
        assert_eq!([found.full.grid(), found.touched.grid()], [&grid; 2]);
        for at in 0..grid.samples() {
            let index = grid.index(at);
            let d = shape.signed_distance(sub(grid.position(index), middle));
            assert!(d.abs() < 1e-9 || found.points.contains(index) == (d < 0.0), "{index:?}: {d}");
            let sides = [found.full.contains(index), found.touched.contains(index)];
            assert!(!sides[0] || d < -0.5 * h.as_mm() + 1e-9, "{index:?}: {d}");
            assert!(sides[1] || d > 0.5 * h.as_mm() - 1e-9, "{index:?}: {d}");
        }
    }

    #[test]
    fn a_box_along_a_line_is_a_longer_box() {
        let h = Length::mm(0.25);
        let path = [[-2.0, 0.5, 0.0], [3.0, 0.5, 0.0]];
        let found = sweep(&mesh("box:1x2x1mm"), &path, h, [0.25, 0.75, 0.5]).unwrap();
        encloses(&found, &Primitive::parse("box:6x2x1mm").unwrap(), [0.5, 0.5, 0.0], h);
        let [low, high] = [&found.full, &found.touched].map(|set| set.volume().as_mm3());
        assert!(0.0 < low && low <= 12.0 && 12.0 <= high, "{low} … {high}");
        let surface = sweep_surface(&mesh("box:1x2x1mm"), &path, h).unwrap().expect("few facets");
        assert!((surface.mesh.signed_volume() - 12.0).abs() < 1e-3, "{}", surface.mesh.signed_volume());
    }

    #[test]
    fn a_ball_along_a_path_is_a_chain_of_capsules() {
        let (h, path) = (0.2, [[0.0; 3], [3.0, 1.0, 0.5], [3.0, -2.0, 0.0]]);
        let ball = Primitive::parse("ball:0.8mm").unwrap().mesh(Length::mm(0.01 * h));
        let both = |p: Vec3| {
            [0, 1].map(|i: usize| {
                let (d, v) = (sub(path[i + 1], path[i]), sub(p, path[i]));
                let t = (dot(v, d) / dot(d, d)).clamp(0.0, 1.0);
                distance(v, d.map(|x| t * x)) - 0.8
            })
        };
        let capsules = |p: Vec3| both(p).into_iter().fold(f64::INFINITY, f64::min);
        let surface = sweep_surface(&ball, &path, Length::mm(h)).unwrap().expect("few facets");
        // The element's facets are inscribed by a hundredth of a spacing.
        let worst = surface.mesh.vertices.iter().map(|&p| capsules(p).abs()).fold(0.0, f64::max);
        assert!(worst < 0.05 * h, "{worst}");
        let made = MeshDistance::new(&surface.mesh);
        let mut creased = 0;
        for &p in &surface.mesh.vertices {
            let Some(q) = crease_near(p, both, 1.5 * h) else { continue };
            let off = made.nearest(q, f64::INFINITY).unwrap().distance;
            // Chords of √3 spacings at most over a bend of 0.8 mm.
            assert!(off < 0.1 * h, "the crease at {q:?} is {off} off the surface");
            creased += 1;
        }
        assert!(creased > 50, "{creased}");
        let found = sweep(&ball, &path, Length::mm(h), [0.3, 0.6, 0.1]).unwrap();
        let [low, high] = [&found.full, &found.touched].map(|set| set.volume());
        let [lower, upper] = surface.volume;
        assert!(lower <= high && low <= upper, "{lower:?} {upper:?} {low:?} {high:?}");
        let grid = *found.points.grid();
        for at in 0..grid.samples() {
            let d = capsules(grid.position(grid.index(at)));
            assert!(d.abs() < 0.011 * h || found.points.contains(grid.index(at)) == (d < 0.0), "{d}");
        }
    }

    /// The point near p where two distances vanish, if it is no farther than `reach` and they make an angle there.
    fn crease_near(p: Vec3, both: impl Fn(Vec3) -> [f64; 2], reach: f64) -> Option<Vec3> {
        let (mut q, step) = (p, 1e-6);
        for _ in 0..8 {
            let [a, b] = both(q);
            let slope = |side: usize| {
                [0, 1, 2].map(|x| {
                    let moved = [0, 1, 2].map(|y| if x == y { q[y] + step } else { q[y] });
                    (both(moved)[side] - both(q)[side]) / step
                })
            };
            let (m, n) = (slope(0), slope(1));
            let cosine = dot(m, n);
            if cosine > 0.8 {
                return None;
            }
            // The least step that takes both to zero.
            let (s, t) = ((a - cosine * b) / (1.0 - cosine * cosine), (b - cosine * a) / (1.0 - cosine * cosine));
            q = [0, 1, 2].map(|x| q[x] - s * m[x] - t * n[x]);
        }
        (distance(p, q) < reach && both(q).iter().all(|d| d.abs() < 1e-6)).then_some(q)
    }

    #[test]
    fn a_concave_element_leaves_none_of_its_facets_inside() {
        // Two prongs on a bar, moved across the prongs and further than they are apart: the solid passes through itself.
        let profile = [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [2.4, 2.0], [2.4, 0.5], [0.6, 0.5], [0.6, 2.0], [0.0, 2.0]];
        let fork = extruded(&profile, &[[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4], [0, 5, 6], [0, 6, 7]], 1.0);
        let (h, path) = (0.12, [[0.0; 3], [4.0, 0.7, 0.3], [3.0, 4.0, 1.0]]);
        let solids: Vec<Winding> = pieces(&path).iter().map(|&[p, v]| Winding::new(&swept(&fork, p, v))).collect();
        let covered = |p: Vec3| solids.iter().any(|solid| solid.at(p) > 0.5);
        let made = sweep_surface(&fork, &path, Length::mm(h)).unwrap().expect("few facets").mesh;
        let inside = |p: Vec3, by: f64| {
            (0..27).all(|at| covered([0, 1, 2].map(|a| p[a] + by * (f64::from(at / 3i32.pow(a as u32) % 3) - 1.0))))
        };
        let deeper = |by: f64| made.vertices.iter().filter(|&&p| inside(p, by * h)).count();
        println!("a fork along a path: {} of {} vertices inside", deeper(0.05), made.vertices.len());
        // An edge's half stays on its chord where a corner of three sheets stands in its way: once here.
        assert!(deeper(0.05) <= 1 && deeper(0.1) == 0, "{} {}", deeper(0.05), deeper(0.1));
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
    fn poses_that_are_no_numbers_are_refused() {
        let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let grid = Grid::covering([-2.0; 3], [2.0; 3], Length::mm(0.5), 1, [0.0; 3]).unwrap();
        let at = |x: f64| Placement { rotation: still, translation: [x, 0.0, 0.0] };
        let skew = Placement { rotation: [still[0], [0.0, f64::NAN, 0.0], still[2]], translation: [0.0; 3] };
        for last in [at(f64::NAN), at(f64::INFINITY), skew] {
            let refused = sweep_poses(&mesh("box:1x1x1mm"), &[at(0.0), at(0.1), last], &grid).unwrap_err();
            assert!(refused.to_string().contains("pose 2"), "{refused}");
        }
    }

    #[test]
    fn paths_without_length_are_refused() {
        let b = mesh("ball:1mm");
        for path in [vec![], vec![[0.0; 3]], vec![[1.0; 3], [1.0; 3]], vec![[0.0; 3], [f64::NAN; 3]]] {
            assert!(sweep(&b, &path, Length::mm(0.5), [0.0; 3]).is_err());
        }
    }
}
