//! Closed forms against the fields that checks rest on, counted over ten thousand random cases.

use crate::random::Random;
use amcheck::field::Field;
use amcheck::geometry::vector::{cross, dot, sub};
use amcheck::geometry::{InsideRule, MeshDistance, TriangleMesh, cuboid, extruded, revolved, voxelize};
use amcheck::grid::Grid;
use amcheck::layer::{downward_facets, support_volume};
use amcheck::morphology::offset;
use amcheck::topology::{Side, border, escape};
use amcheck::units::{Angle, Length};
use rayon::prelude::*;
use std::f64::consts::PI;

/// What turning, shifting and snapping to the lattice of the casts (h/2^16) may do, as a share.
const ROUNDING: f64 = 1e-4;

/// What one case showed.
#[derive(Default)]
struct Shown {
    /// Brackets that do not hold the truth, and verdicts that turned round.
    violations: Vec<String>,
    /// Verdicts that the finer bracket gave.
    decided: u64,
}

impl Shown {
    /// Two brackets of one truth, the second at half the spacing, against a limit near it.
    fn of(name: &str, truth: f64, coarse: [f64; 2], fine: [f64; 2], limit: f64) -> Self {
        let slack = ROUNDING * truth.abs();
        let mut shown = Shown::default();
        for [low, high] in [coarse, fine] {
            if low > truth + slack || high < truth - slack {
                shown.violations.push(format!("{name}: {truth} is not in {low} … {high}"));
            }
        }
        let verdict = |[low, high]: [f64; 2]| i32::from(low >= limit) - i32::from(high < limit);
        if verdict(coarse) * verdict(fine) < 0 {
            shown.violations.push(format!("{name}: {coarse:?} became {fine:?} at {limit}"));
        }
        shown.decided = u64::from(verdict(fine) != 0);
        shown
    }
}

/// Number of sides of what is turned.
const N: usize = 20;

/// Area of a regular polygon with corners on the unit circle.
fn polygon() -> f64 {
    0.5 * N as f64 * (2.0 * PI / N as f64).sin()
}

/// A solid of revolution by its outline in (r, z), with the volume of its facets: each section is a polygon of N sides.
fn turned(outline: &[[f64; 2]]) -> (TriangleMesh, f64) {
    let pairs = outline.iter().zip(outline.iter().cycle().skip(1));
    let sum: f64 = pairs.map(|([r, z], [s, w])| (w - z) * (r * r + r * s + s * s) / 3.0).sum();
    (revolved(outline, N), polygon() * sum.abs())
}

/// Ball, box, slab, cylinder, cone, torus, wedge, block with a hole; each with its volume.
fn shape(r: &mut Random, kind: usize) -> (TriangleMesh, f64) {
    let arc = |radius: f64, middle: f64, from: f64, to: f64, steps: usize| -> Vec<[f64; 2]> {
        (0..=steps)
            .map(|i| from + (to - from) * i as f64 / steps as f64)
            .map(|a| [middle + radius * a.cos(), radius * a.sin()])
            .collect()
    };
    match kind {
        0 => {
            let mut half = arc(r.between(0.6, 1.2), 0.0, -0.5 * PI, 0.5 * PI, 10);
            // The poles lie on the axis.
            half[0][0] = 0.0;
            half[10][0] = 0.0;
            turned(&half)
        }
        1 | 2 => {
            let mut size = [0; 3].map(|_| r.between(0.6, 2.4));
            size[2] = if kind == 2 { r.between(0.1, 0.4) } else { size[2] };
            (cuboid([0.0; 3], size), size.iter().product())
        }
        3 => {
            let (radius, long) = (r.between(0.3, 1.0), r.between(0.6, 2.4));
            turned(&[[0.0, 0.0], [radius, 0.0], [radius, long], [0.0, long]])
        }
        4 => turned(&[[0.0, 0.0], [r.between(0.5, 1.2), 0.0], [0.0, r.between(0.8, 2.4)]]),
        5 => {
            let (tube, ring) = (r.between(0.2, 0.5), r.between(0.8, 1.2));
            let mut circle = arc(tube, ring, 0.0, 2.0 * PI, 12);
            circle.pop();
            turned(&circle)
        }
        6 => {
            let (deep, half, long) = (r.between(1.0, 2.4), r.between(0.2, 0.8), r.between(0.6, 2.0));
            let outline = [[0.0, 0.0], [deep, -half], [deep, half]];
            (extruded(&outline, &[[0, 1, 2]], long), deep * half * long)
        }
        _ => {
            let (hole, rim, long) = (r.between(0.15, 0.5), r.between(0.8, 1.2), r.between(0.4, 1.6));
            turned(&[[hole, 0.0], [rim, 0.0], [rim, long], [hole, long]])
        }
    }
}

/// One random case by its number.
type Case = fn(usize) -> Shown;

const NAMES: [&str; 8] = ["ball", "box", "slab", "cylinder", "cone", "torus", "wedge", "tilted hole"];

/// The volume between the cubes wholly inside and the cubes touched; the density's own; the sets nested.
fn sets(case: usize) -> Shown {
    let mut r = Random(11 + case as u64 * 7919);
    let kind = case % NAMES.len();
    let (mesh, truth) = shape(&mut r, kind);
    let mesh = r.moved(&mesh);
    let (h, phase) = (r.between(0.1, 0.3), r.point(0.49));
    let (lo, hi) = mesh.bounds().expect("a box");
    let mut densities = Vec::new();
    let [coarse, fine] = [h, 0.5 * h].map(|h| {
        let grid = Grid::covering(lo, hi, Length::mm(h), 2, phase).expect("a grid");
        let solid = voxelize(&mesh, &grid, InsideRule::Crossings).expect("a solid");
        solid.validate().expect("nested sets");
        densities.push(solid.density.volume().as_mm3());
        [&solid.inner, &solid.outer].map(|s| s.volume().as_mm3())
    });
    let mut shown = Shown::of(NAMES[kind], truth, coarse, fine, truth * r.between(0.3, 1.7));
    // Densities are the exact share of each cube in single precision.
    if densities.iter().any(|d| (d / truth - 1.0).abs() > 1e-3) {
        shown.violations.push(format!("{}: densities of {densities:?}, {truth}", NAMES[kind]));
    }
    shown
}

/// The widest ball that leaves a round room through a round neck, by the clearance at the samples.
fn throats(case: usize) -> Shown {
    let mut r = Random(23 + case as u64 * 104_729);
    let (neck, room) = (r.between(0.2, 0.45), r.between(0.8, 1.2));
    let (wall, long) = (0.5, r.between(0.3, 0.8));
    let top = 2.0 * room + long;
    // Counter-clockwise: outside up, over the top, down the neck, around the room.
    let outline = [
        [0.0, -wall],
        [room + wall, -wall],
        [room + wall, top],
        [neck, top],
        [neck, 2.0 * room],
        [room, 2.0 * room],
        [room, 0.0],
        [0.0, 0.0],
    ];
    let mesh = r.moved(&revolved(&outline, N));
    let distance = MeshDistance::new(&mesh);
    // The inscribed circle of the polygon.
    let truth = 2.0 * neck * (PI / N as f64).cos();
    let (lo, hi) = mesh.bounds().expect("a box");
    let (h, phase) = (r.between(0.16, 0.24), r.point(0.49));
    let [coarse, fine] = [h, 0.5 * h].map(|h| {
        let grid = Grid::covering(lo, hi, Length::mm(h), 2, phase).expect("a grid");
        let solid = voxelize(&mesh, &grid, InsideRule::Crossings).expect("a solid");
        let cap = 3.0 * room;
        let clearance = |at: usize| {
            let index = grid.index(at);
            let d = distance.nearest(grid.position(index), cap).map_or(cap, |n| n.distance);
            if solid.centres.contains(index) { -d as f32 } else { d as f32 }
        };
        let values = (0..grid.samples()).map(clearance).collect();
        let field = Field::from_values(grid, values, 0.0).expect("a field");
        let found = escape(&field, &border(&grid, &Side::ALL), cap as f32, 0.5 * h as f32).expect("pockets");
        let half = 3f64.sqrt() * h;
        let pocket = found.pockets.iter().max_by_key(|p| p.samples);
        pocket.map_or([f64::NAN; 2], |p| [-half, half].map(|e| 2.0 * f64::from(p.escape_radius_mm) + e))
    });
    if coarse[0].is_nan() || fine[0].is_nan() {
        return Shown { violations: vec![format!("throat: no pocket behind a neck of {truth}")], decided: 0 };
    }
    Shown::of("throat", truth, coarse, fine, truth * r.between(0.4, 1.6))
}

/// Supports below a convex part that hovers over the plate: the prisms below its hanging facets.
fn supports(case: usize) -> Shown {
    let mut r = Random(37 + case as u64 * 15_485_863);
    // Nothing convex hangs over itself: torus and hole are left out.
    let kind = [0, 1, 2, 3, 4, 6][case % 6];
    let made = shape(&mut r, kind).0;
    let mesh = r.moved(&made);
    let (lo, _) = mesh.bounds().expect("a box");
    let plate = lo[2] - r.between(0.5, 3.0);
    let wanted = downward_facets(&mesh, plate, Angle::degrees(45.0), 1e-9);
    let below = |f: &u32| {
        let [a, b, c] = mesh.corners(*f as usize);
        let shadow = -0.5 * dot(cross(sub(b, a), sub(c, a)), [0.0, 0.0, 1.0]);
        shadow * ((a[2] + b[2] + c[2]) / 3.0 - plate)
    };
    let truth: f64 = wanted.iter().map(below).sum();
    let side = r.between(0.1, 0.5);
    let [coarse, fine] =
        [side, 0.5 * side].map(|side| support_volume(&mesh, |_| true, &wanted, plate, side).volume_mm3);
    Shown::of("support", truth, coarse, fine, truth * r.between(0.9, 1.1))
}

/// Boxes grown by a ball: Steiner's formula.
fn offsets(case: usize) -> Shown {
    let mut r = Random(53 + case as u64 * 32_452_843);
    let [a, b, c] = [0; 3].map(|_| r.between(0.5, 1.5));
    let mesh = r.moved(&cuboid([0.0; 3], [a, b, c]));
    let d = r.between(0.1, 0.4);
    let (faces, edges) = (2.0 * (a * b + b * c + c * a), a + b + c);
    let truth = a * b * c + faces * d + PI * d * d * edges + 4.0 / 3.0 * PI * d * d * d;
    let h = r.between(0.12, 0.2);
    let [coarse, fine] = [h, 0.5 * h].map(|h| {
        let made = offset(&mesh, Length::mm(d), Length::mm(h)).expect("an offset");
        made.volume.map(|v| v.as_mm3())
    });
    Shown::of("offset", truth, coarse, fine, truth * r.between(0.7, 1.3))
}

#[test]
fn no_bracket_of_ten_thousand_misses_its_truth_and_no_verdict_turns_round() {
    let kinds: [(&str, Case, usize); 4] =
        [("sets", sets, 7400), ("throats", throats, 200), ("supports", supports, 2500), ("offsets", offsets, 60)];
    let mut cases = 0;
    for (name, of, count) in kinds {
        let shown: Vec<Shown> = (0..count).into_par_iter().map(of).collect();
        let violations: Vec<&String> = shown.iter().flat_map(|s| &s.violations).collect();
        assert!(
            violations.is_empty(),
            "{name}: {} of {count}: {:?}",
            violations.len(),
            &violations[..violations.len().min(4)]
        );
        let decided: u64 = shown.iter().map(|s| s.decided).sum();
        assert!(decided > count as u64 / 10, "{name}: {decided} of {count} verdicts say something");
        println!("{name}: {count} cases, {decided} decided, none violated");
        cases += count;
    }
    assert!(cases >= 10_000, "{cases}");
}
