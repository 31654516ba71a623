//! What stays inside an envelope along a motion: the dual of the sweep.

use super::element::{Sides, StructuringElement, lattice_box};
use super::minkowski::{Morphed, erode};
use super::sandwich::Sandwich;
use super::sweep::{Placement, check_path, check_poses, no_facets, pieces, union, window_of};
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, add, distance, dot};
use crate::geometry::{InsideRule, TriangleMesh, cuboid, enclose, swept};
use crate::grid::Grid;
use crate::units::Length;
use rayon::prelude::*;

/// The unsweep of a closed mesh along a polyline, from three sides: the largest set that stays inside the envelope E
/// wherever the path takes it, `∩ { E − p : p on the path }`.
///
/// What leaves the envelope is the sweep of its complement along the reflected path, so that samples and cubes are as
/// exact as those of [`super::sweep()`].
///
/// # Limits
/// Bodies of the envelope that overlap have to be united first: the complement's winding number is negative where they do.
///
/// # Errors
/// As [`super::sweep()`].
///
/// # Cost
/// As [`super::sweep()`].
pub fn unsweep(envelope: &TriangleMesh, path: &[Vec3], spacing: Length, phase: [f64; 3]) -> Result<Sides> {
    check_path(path)?;
    let back: Vec<Vec3> = path.iter().map(|p| p.map(|x| -x)).collect();
    let (lo, hi) = envelope.bounds().ok_or_else(no_facets)?;
    let grid = lattice_box(add(lo, back[0]), add(hi, back[0]), spacing, phase)?;
    // The complement within a box that no way of the grid's cubes leaves.
    let room = 2.0 * spacing.as_mm() + path.iter().map(|&p| distance(p, path[0])).fold(0.0, f64::max);
    let outside = cuboid(lo.map(|x| x - 2.0 * room), hi.map(|x| x + 2.0 * room)).joined(&envelope.flipped());
    let left = union(&pieces(&back), &grid, |&[p, v]| swept(&outside, p, v))?;
    let [full, points, touched] = [&left.touched, &left.points, &left.full].map(Indicator::complement);
    Ok(Sides { full, points, touched })
}

/// The unsweep of a closed mesh through poses of a rotating motion, on a given grid: the largest set that stays inside the
/// envelope E in every pose, `∩ { m⁻¹·E } = { x : m·x ∈ E for all m }`.
///
/// Above stand the samples that are inside in the poses themselves. Below, the cubes that lie inside in all of them with all their
/// neighbours: no point of the set moves further than h/2 from one pose to the next, and a motion keeps distances, so that what takes
/// it out between two poses would lie in a neighbour's cube.
///
/// # Errors
/// [`crate::Error::Operand`] for fewer than two poses, or for neighbours between which a vertex of the envelope, placed as in the first
/// pose, moves further than h/2; the message names the pair.
///
/// # Cost
/// One cast of E for each pose, and a walk over the words of the grid.
///
/// # Source
/// H. T. Ilieş, V. Shapiro, The dual of sweep, Computer-Aided Design 31, 1999, doi:10.1016/S0010-4485(99)00015-7.
pub fn unsweep_poses(envelope: &TriangleMesh, poses: &[Placement], grid: &Grid) -> Result<Sandwich> {
    let first = poses.first().map(|pose| envelope_from(envelope, pose)).unwrap_or_default();
    check_poses(&first, poses, grid.h())?;
    let all = || [0; 3].map(|_| Indicator::from_predicate(*grid, |_| true));
    let meet = |a: [Indicator; 3], b: [Indicator; 3]| {
        let [f, p, t] = a;
        let [g, q, u] = b;
        Ok([f.intersection(&g)?, p.intersection(&q)?, t.intersection(&u)?])
    };
    let some = |poses: &[Placement]| {
        poses.iter().try_fold(all(), |inside, pose| {
            let mesh = envelope_from(envelope, pose);
            let mut own = [0; 3].map(|_| Indicator::empty(*grid));
            if let Some((first, window)) = window_of(&mesh, grid)? {
                let cast = enclose(&mesh, &window, InsideRule::Crossings)?;
                let sides = [cast.inner, cast.centres, cast.outer];
                own.iter_mut().zip(&sides).for_each(|(own, side)| own.unite_window(first, side));
            }
            meet(inside, own)
        })
    };
    let chunks = poses.par_chunks(poses.len().div_ceil(8).max(1)).map(some);
    let [full, points, touched] = chunks.try_reduce(all, meet)?;
    let cube = StructuringElement::cuboid([3; 3], grid.spacing())?;
    let deep = erode(&full, &cube)?;
    let lower = deep.set.placed([1; 3], *grid)?;
    Ok(Sandwich { volume: [lower.volume(), touched.volume()], lower, upper: points, paths: vec![deep.path] })
}

/// `m⁻¹·E`: what a pose takes into the envelope.
fn envelope_from(envelope: &TriangleMesh, pose: &Placement) -> TriangleMesh {
    let r = pose.rotation;
    let turned_back = [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[j][i]));
    envelope.transformed(turned_back, turned_back.map(|row| -dot(row, pose.translation)))
}

/// The unsweep: the largest set that stays inside an envelope while it moves along a path of samples,
/// `∩ { E − p : p on the path } = E ⊖ path`.
///
/// # Errors
/// As [`erode`].
pub fn unsweep_set(envelope: &Indicator, path: &StructuringElement) -> Result<Morphed> {
    erode(envelope, path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::geometry::{MeshDistance, Primitive, Winding, extruded};
    use crate::morphology::{path_cells, sweep_poses, sweep_set};

    fn mesh(text: &str) -> TriangleMesh {
        Primitive::parse(text).unwrap().mesh(Length::mm(0.01))
    }

    #[test]
    fn a_box_unswept_along_a_line_is_a_shorter_box() {
        let h = Length::mm(0.25);
        let path = [[-2.0, 0.5, 0.0], [0.0, 0.0, 0.5], [1.0, 0.5, 0.0]];
        let found = unsweep(&mesh("box:6x3x2mm"), &path, h, [0.25, 0.75, 0.5]).unwrap();
        // −3 ≤ x + p ≤ 3 for p from −2 to 1, and so for the others.
        let rest = Primitive::parse("box:3x2.5x1.5mm").unwrap();
        let grid = *found.points.grid();
        for at in 0..grid.samples() {
            let (index, p) = (grid.index(at), grid.position(grid.index(at)));
            let d = rest.signed_distance([p[0] - 0.5, p[1] + 0.25, p[2] + 0.25]);
            assert!(d.abs() < 1e-9 || found.points.contains(index) == (d < 0.0), "{index:?}: {d}");
            assert!(!found.full.contains(index) || d < -0.125 + 1e-9, "{index:?}: {d}");
            assert!(found.touched.contains(index) || d > 0.125 - 1e-9, "{index:?}: {d}");
        }
        assert!(found.full.count() > 0);
        // Along a way longer than itself nothing stays inside.
        let none = unsweep(&mesh("box:6x3x2mm"), &[[0.0; 3], [9.0, 0.0, 0.0]], h, [0.0; 3]).unwrap();
        assert!(none.full.is_empty() && none.points.is_empty());
    }

    /// An L of 6 × 6 × 2 mm, 3 mm wide.
    fn angle() -> TriangleMesh {
        let profile = [[0.0, 0.0], [6.0, 0.0], [6.0, 3.0], [3.0, 3.0], [3.0, 6.0], [0.0, 6.0]];
        extruded(&profile, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], 2.0)
    }

    #[test]
    fn what_stays_in_a_concave_envelope_is_what_no_stop_of_the_path_takes_out() {
        let (envelope, h) = (angle(), 0.3);
        let path = [[0.0; 3], [1.3, 0.4, 0.2], [0.4, 1.7, -0.3]];
        let found = unsweep(&envelope, &path, Length::mm(h), [0.1, 0.6, 0.3]).unwrap();
        let (inside, surface) = (Winding::new(&envelope), MeshDistance::new(&envelope));
        let stops: Vec<Vec3> = path
            .windows(2)
            .flat_map(|w| {
                (0..=100).map(move |n| [0, 1, 2].map(|a| w[0][a] + (w[1][a] - w[0][a]) * f64::from(n) / 100.0))
            })
            .collect();
        let grid = *found.points.grid();
        let mut seen = [0, 0];
        for at in 0..grid.samples() {
            let (index, x) = (grid.index(at), grid.position(grid.index(at)));
            // The least depth under the path, known to half the distance of two stops.
            let depth = |p: &Vec3| {
                let y = add(x, *p);
                let d = surface.nearest(y, f64::INFINITY).map_or(f64::INFINITY, |n| n.distance);
                if inside.at(y) > 0.5 { d } else { -d }
            };
            let least = stops.iter().map(depth).fold(f64::INFINITY, f64::min);
            if least.abs() > 0.01 {
                assert_eq!(found.points.contains(index), least > 0.0, "{x:?}: {least}");
                seen[usize::from(least > 0.0)] += 1;
            }
            assert!(!found.full.contains(index) || least > 0.5 * h - 0.01, "{x:?}: {least}");
            assert!(found.touched.contains(index) || least < 0.01, "{x:?}: {least}");
        }
        assert!(seen[0] > 100 && seen[1] > 100, "{seen:?}");
    }

    fn quarter_turn(steps: u32) -> Vec<Placement> {
        (0..=steps)
            .map(|n| {
                let (s, c) = (0.5 * std::f64::consts::PI * f64::from(n) / f64::from(steps)).sin_cos();
                Placement { rotation: [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] }
            })
            .collect()
    }

    #[test]
    fn a_plate_turned_in_its_place_keeps_a_disc_inside() {
        // The corner, 5.66 mm out, moves 0.111 mm from pose to pose.
        let (plate, h) = (mesh("box:8x8x2mm"), 0.25);
        let poses = quarter_turn(80);
        let grid = Grid::covering([-5.0, -5.0, -1.5], [5.0, 5.0, 1.5], Length::mm(h), 1, [0.1; 3]).unwrap();
        let found = unsweep_poses(&plate, &poses, &grid).unwrap();
        for at in 0..grid.samples() {
            let (index, p) = (grid.index(at), grid.position(grid.index(at)));
            // Through a right angle some pose brings every point as near to a side as it is far from the middle.
            let d = (p[0].hypot(p[1]) - 4.0).max(p[2].abs() - 1.0);
            assert!(!found.lower.contains(index) || d < -0.5 * h, "{p:?}: {d}");
            assert!(found.upper.contains(index) || d > -1e-9, "{p:?}: {d}");
            // Two poses and a neighbour's diagonal widen the bracket, no more.
            assert!(found.lower.contains(index) || d > -2.0 * 3f64.sqrt() * h, "{p:?}: {d}");
            assert!(!found.upper.contains(index) || d < 0.01, "{p:?}: {d}");
        }
        let disc = std::f64::consts::PI * 16.0 * 2.0;
        let [low, high] = found.volume.map(|v| v.as_mm3());
        // Two samples are lost at each side: a plate of 1.25 mm and 3.5 mm radius stays, on some lattices one sample less.
        assert!(0.4 * disc < low && low < disc && disc < high && high < 1.3 * disc, "{low} … {high}");
        assert!(matches!(unsweep_poses(&plate, &quarter_turn(20), &grid), Err(Error::Operand { .. })));
        assert!(unsweep_poses(&plate, &poses[..1], &grid).is_err() && unsweep_poses(&plate, &[], &grid).is_err());
    }

    #[test]
    fn what_stays_inside_sweeps_no_more_than_the_envelope() {
        // An L that turns and goes at once; the largest set inside it, swept through the same poses, stays within its cubes.
        let (envelope, h) = (angle(), 0.25);
        let mut poses = quarter_turn(120);
        (0..).zip(&mut poses).for_each(|(n, pose)| pose.translation = [0.02 * f64::from(n), 0.0, 0.0]);
        let placed = |p: Vec3| [p[0] - 2.0, p[1] - 2.0, p[2]];
        let envelope = TriangleMesh { vertices: envelope.vertices.iter().map(|&p| placed(p)).collect(), ..envelope };
        let grid = Grid::covering([-7.0, -7.0, -0.5], [7.0, 7.0, 2.5], Length::mm(h), 1, [0.3; 3]).unwrap();
        let kept = unsweep_poses(&envelope, &poses, &grid).unwrap();
        assert!(kept.lower.count() > 20);
        let inside = Winding::new(&envelope);
        for at in kept.lower.iter() {
            let x = grid.position(grid.index(at));
            for pose in &poses {
                let y = [0, 1, 2].map(|r| dot(pose.rotation[r], x) + pose.translation[r]);
                assert!(inside.at(y) > 0.5, "{x:?} {y:?}");
            }
        }
        // And as cubes: a body of one of them, swept, is covered by what the envelope touches.
        let some = kept.lower.iter().next().map(|at| grid.position(grid.index(at))).unwrap();
        let body = cuboid(some.map(|x| x - 0.5 * h), some.map(|x| x + 0.5 * h));
        let swept = sweep_poses(&body, &poses, &grid).unwrap();
        let around = enclose(&envelope, &grid, InsideRule::Crossings).unwrap().outer;
        assert!(swept.lower.count() > 0 && swept.lower.is_subset(&around).unwrap());
    }

    #[test]
    fn unsweep_is_the_largest_set_that_stays_inside() {
        let h = Length::mm(1.0);
        let grid = Grid::new([0.0; 3], h, [9, 4, 3]).unwrap();
        let envelope = Indicator::from_predicate(grid, |at| at % 11 != 0);
        let path = StructuringElement::new(path_cells(&[[0.0; 3], [2.0, 1.0, 0.0]], h, [0.0; 3]).unwrap()).unwrap();
        let most = unsweep_set(&envelope, &path).unwrap().set;
        let swept = sweep_set(&most, &path).unwrap().set;
        let first = [0, 1, 2].map(|a| (-swept.grid().origin()[a]).round() as isize);
        assert!(swept.placed(first, grid).unwrap().is_subset(&envelope).unwrap());
        assert_eq!(swept.placed(first, grid).unwrap().count(), swept.count());
    }
}
