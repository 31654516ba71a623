//! Local thickness on grids.

use crate::random::Random;
use amcheck::geometry::vector::Vec3;
use amcheck::geometry::{InsideRule, TriangleMesh, cuboid, revolved, voxelize};
use amcheck::grid::Grid;
use amcheck::medial::Side;
use amcheck::medial::thickness::{Thickness, local_thickness};
use amcheck::units::Length;
use std::f64::consts::PI;

fn map_of(mesh: &TriangleMesh, grid: &Grid) -> Thickness {
    let solid = voxelize(mesh, grid, InsideRule::Crossings).expect("a solid");
    local_thickness(&solid, Side::Material, None).expect("a map")
}

fn grid_over(mesh: &TriangleMesh, h: f64, phase: Vec3) -> Grid {
    let (lo, hi) = mesh.bounds().expect("a box");
    Grid::covering(lo, hi, Length::mm(h), 2, phase).expect("a grid")
}

/// A shape about the origin, and the bounds that its faceting leaves for the local thickness at a point, where that is known.
type Case = (TriangleMesh, Box<dyn Fn(Vec3) -> Option<(f64, f64)>>);

fn shape(r: &mut Random, kind: usize) -> Case {
    const N: usize = 64;
    // Facets of a circle take this share of its radius.
    let flat = (PI / N as f64).cos();
    let circle = |radius: f64, middle: [f64; 2], steps: usize| -> Vec<[f64; 2]> {
        (0..steps)
            .map(|i| 2.0 * PI * i as f64 / steps as f64)
            .map(|a| [middle[0] + radius * a.cos(), middle[1] + radius * a.sin()])
            .collect()
    };
    match kind {
        0 => {
            let t = r.between(0.5, 1.5);
            let wide = 3.0 * t;
            let mesh = cuboid([-wide, -wide, -0.5 * t], [wide, wide, 0.5 * t]);
            (mesh, Box::new(move |p| (p[0].abs().max(p[1].abs()) < wide - 0.5 * t).then_some((t, t))))
        }
        1 => {
            let (radius, long) = (r.between(0.5, 1.0), r.between(3.0, 4.0));
            let mesh = revolved(&[[0.0, -long], [radius, -long], [radius, long], [0.0, long]], N);
            (mesh, Box::new(move |p| (p[2].abs() < long - radius).then_some((2.0 * radius * flat, 2.0 * radius))))
        }
        2 => {
            let radius = r.between(0.6, 1.4);
            let mut half: Vec<[f64; 2]> = (1..N / 2)
                .map(|i| PI * i as f64 / (N / 2) as f64 - 0.5 * PI)
                .map(|a| [radius * a.cos(), radius * a.sin()])
                .collect();
            half.insert(0, [0.0, -radius]);
            half.push([0.0, radius]);
            (
                revolved(&half, N),
                Box::new(move |p| {
                    (p.iter().map(|x| x * x).sum::<f64>().sqrt() < radius * flat * flat)
                        .then_some((2.0 * radius * flat * flat, 2.0 * radius))
                }),
            )
        }
        3 => {
            let (tube, ring) = (r.between(0.4, 0.7), r.between(1.5, 2.5));
            let mesh = revolved(&circle(tube, [ring, 0.0], N), N);
            // Chords of the ring take up to (ring + tube)·(1 − flat) from the tube.
            let least = 2.0 * (tube * flat - (ring + tube) * (1.0 - flat));
            let inside = tube * flat - (ring + tube) * (1.0 - flat);
            (mesh, Box::new(move |p| ((p[0].hypot(p[1]) - ring).hypot(p[2]) < inside).then_some((least, 2.0 * tube))))
        }
        _ => {
            // On the axis of a cone, between the sections where the largest ball that covers the point touches base or side: the
            // ball about (0, 0, z) alone gives a lower bound, the insphere an upper one.
            let (radius, height) = (r.between(1.0, 1.5), r.between(2.0, 3.0));
            let mesh = revolved(&[[0.0, 0.0], [radius, 0.0], [0.0, height]], N);
            let slant = radius.hypot(height);
            let insphere = radius * height / (radius + slant);
            (
                mesh,
                Box::new(move |p| {
                    let at = (p[2]).min((height - p[2]) * radius / slant) - p[0].hypot(p[1]);
                    (at > 0.0).then_some((2.0 * at * flat, 2.0 * insphere))
                }),
            )
        }
    }
}

#[test]
fn the_truth_lies_between_the_bounds_at_every_sample() {
    let mut r = Random(7);
    let (mut cases, mut violated) = (0u64, Vec::new());
    for n in 0..60 {
        let (mesh, truth) = shape(&mut r, n % 5);
        let (turn, shift) = (r.rotation(), r.point(3.0));
        let moved = mesh.transformed(turn, shift);
        let phase = r.point(0.49);
        let map = map_of(&moved, &grid_over(&moved, r.between(0.12, 0.25), phase));
        let grid = *map.low.grid();
        for at in 0..grid.samples() {
            let (low, high) = (f64::from(map.low.values()[at]), f64::from(map.high.values()[at]));
            if low.is_nan() {
                continue;
            }
            let p = grid.position(grid.index(at));
            let d = [0, 1, 2].map(|a| p[a] - shift[a]);
            let own = [0, 1, 2].map(|c| (0..3).map(|k| turn[k][c] * d[k]).sum());
            let Some((least, most)) = truth(own) else { continue };
            cases += 1;
            if low > most + 1e-6 || high < least - 1e-6 {
                violated.push((n, own, low, high, least, most));
            }
        }
    }
    assert!(cases > 10_000, "{cases}");
    assert!(violated.is_empty(), "{} of {cases}: {:?}", violated.len(), violated.first());
}

#[test]
fn halving_the_spacing_never_turns_a_verdict_round() {
    let mut r = Random(8);
    let (mut cases, mut decided) = (0u64, [0u64; 2]);
    for n in 0..25 {
        let (mesh, _) = shape(&mut r, n % 5);
        let moved = r.moved(&mesh);
        let coarse_grid = grid_over(&moved, 0.25, r.point(0.49));
        let dims = coarse_grid.dims().map(|n| 2 * n - 1);
        let fine_grid = Grid::new(coarse_grid.origin(), Length::mm(0.125), dims).expect("a grid");
        let (coarse, fine) = (map_of(&moved, &coarse_grid), map_of(&moved, &fine_grid));
        let limit = r.between(0.5, 2.5) as f32;
        let verdict = |m: &Thickness, at: usize| {
            let (low, high) = (m.low.values()[at], m.high.values()[at]);
            if low >= limit {
                1
            } else if high < limit {
                -1
            } else {
                0
            }
        };
        for at in 0..coarse_grid.samples() {
            let twice = fine_grid.offset(coarse_grid.index(at).map(|i| 2 * i));
            let (before, after) = (verdict(&coarse, at), verdict(&fine, twice));
            assert!(before * after >= 0, "{n} {at}: {before} became {after}");
            cases += u64::from(!coarse.low.values()[at].is_nan());
            decided[0] += u64::from(before != 0);
            decided[1] += u64::from(after != 0);
        }
    }
    assert!(cases > 2_000 && decided[1] > decided[0], "{cases} {decided:?}");
}
