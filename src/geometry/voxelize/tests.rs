//! The cast against plain oracles: solid angles, separating axes, clipped tetrahedra.

use super::lattice::Lattice;
use super::{occupancy, shell, voxelize, voxelize_layers};
use crate::geometry::solid::InsideRule::Crossings;
use crate::geometry::vector::{Vec3, add, cross, dot, norm, scale, sub};
use crate::geometry::{Solid, TriangleMesh, cuboid};
use crate::grid::Grid;
use crate::random::Lcg;
use crate::units::Length;

/// A box whose facets come by axis: its sides along x first, its top last.
pub(in crate::geometry) fn block(lo: Vec3, hi: Vec3) -> TriangleMesh {
    let mesh = cuboid(lo, hi);
    let (level, along_x) = mesh.triangles.split_at(8);
    TriangleMesh { triangles: [along_x, &level[4..], &level[..4]].concat(), vertices: mesh.vertices }
}

/// A sphere by subdivision of an octahedron: closed, `4^(depth) * 8` facets.
pub(in crate::geometry) fn sphere(radius: f64, depth: u32) -> TriangleMesh {
    let e = |a: usize, s: f64| {
        let mut p = [0.0; 3];
        p[a] = s;
        p
    };
    let mut facets = Vec::new();
    for n in 0..8 {
        let s = [0, 1, 2].map(|a| if n >> a & 1 == 1 { -1.0 } else { 1.0 });
        let t = [e(0, s[0]), e(1, s[1]), e(2, s[2])];
        facets.push(if s[0] * s[1] * s[2] > 0.0 { t } else { [t[0], t[2], t[1]] });
    }
    let unit = |p: Vec3| scale(p, 1.0 / norm(p));
    for _ in 0..depth {
        facets = facets
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [p, q, r] = [unit(add(a, b)), unit(add(b, c)), unit(add(c, a))];
                [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
            })
            .collect();
    }
    TriangleMesh::weld(facets.into_iter().map(|t| t.map(|p| scale(p, radius))))
}

fn tetrahedron(p: [Vec3; 4]) -> TriangleMesh {
    let volume = dot(sub(p[1], p[0]), cross(sub(p[2], p[0]), sub(p[3], p[0])));
    let mesh = TriangleMesh { vertices: p.to_vec(), triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]] };
    if volume < 0.0 { mesh.flipped() } else { mesh }
}

/// Winding number as the sum of solid angles (van Oosterom and Strackee 1983).
pub(in crate::geometry) fn winding(mesh: &TriangleMesh, q: Vec3) -> f64 {
    let angle = |f: usize| {
        let [a, b, c] = mesh.corners(f).map(|p| sub(p, q));
        let (la, lb, lc) = (norm(a), norm(b), norm(c));
        2.0 * dot(a, cross(b, c)).atan2(la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
    };
    (0..mesh.triangles.len()).map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

#[test]
fn ties_are_broken_like_a_shifted_sample() {
    // Corners on half samples: faces in sample planes, edges on rows, corners on samples, all the time.
    let grid = Grid::new([0.0; 3], Length::mm(1.0), [7, 6, 5]).unwrap();
    let mut r = Lcg(1);
    let mut inside = 0;
    for _ in 0..300 {
        let mut mesh = TriangleMesh::default();
        for _ in 0..1 + r.below(3) {
            let p = [0; 4].map(|_| [0; 3].map(|_| r.below(17) as f64 / 2.0 - 1.0));
            let body = tetrahedron(p);
            mesh = mesh.joined(&if r.below(4) == 0 { body.flipped() } else { body });
        }
        let set = occupancy(&mesh, &grid).unwrap();
        for at in 0..grid.samples() {
            let index = grid.index(at);
            let q = add(grid.position(index), [1e-4, 1e-6, 1e-8]);
            let w = winding(&mesh, q);
            assert!((w - w.round()).abs() < 1e-6, "the oracle is sure: {w}");
            assert_eq!(set.contains(index), w.round() >= 1.0, "{index:?} w {w} {mesh:?}");
            inside += usize::from(set.contains(index));
        }
    }
    assert!(inside > 1000, "{inside}");
}

#[test]
fn a_box_on_the_samples_keeps_its_volume_at_every_phase() {
    for n in 0..8 {
        let phase = [n as f64 / 8.0, (n * 3 % 8) as f64 / 8.0, (n * 5 % 8) as f64 / 8.0];
        let lo = phase.map(|p| 2.0 + p);
        let mesh = block(lo, lo.map(|c| c + 4.0));
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [70, 9, 9]).unwrap();
        let solid = voxelize(&mesh, &grid, Crossings).unwrap();
        solid.validate().unwrap();
        assert_eq!(solid.centres.count(), 64, "phase {phase:?}");
        assert_eq!(solid.centres, occupancy(&mesh, &grid).unwrap());
        assert!((solid.density.volume().as_mm3() - 64.0).abs() < 1e-5, "{}", solid.density.volume());
    }
}

#[test]
fn mirrored_and_turned_boxes_give_the_same_sandwich() {
    let mesh = block([-2.0, -1.5, -1.0], [2.0, 1.5, 1.0]);
    let grid = Grid::new([-4.0; 3], Length::mm(1.0), [9, 9, 9]).unwrap();
    let turned = mesh.transformed([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);
    let [a, b] = [&mesh, &turned].map(|m| voxelize(m, &grid, Crossings).unwrap());
    for at in 0..grid.samples() {
        let [i, j, k] = grid.index(at);
        let to = [8 - j, i, k];
        assert_eq!(a.inner.contains([i, j, k]), b.inner.contains(to));
        assert_eq!(a.outer.contains([i, j, k]), b.outer.contains(to));
        assert_eq!(a.density.field().values()[at], b.density.field().values()[grid.offset(to)]);
    }
}

/// Least gap between a triangle and a closed cube over the thirteen separating axes, in `f64`; positive: apart.
fn separation(t: [Vec3; 3], centre: Vec3, half: f64) -> f64 {
    let v = t.map(|p| sub(p, centre));
    let edges = [sub(v[1], v[0]), sub(v[2], v[1]), sub(v[0], v[2])];
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut axes = unit.to_vec();
    axes.push(cross(edges[0], edges[1]));
    axes.extend(edges.iter().flat_map(|&e| unit.map(|u| cross(u, e))));
    axes.iter()
        .filter(|a| norm(**a) > 1e-12)
        .map(|&a| {
            let a = scale(a, 1.0 / norm(a));
            let p = v.map(|p| dot(p, a));
            let reach = half * (a[0].abs() + a[1].abs() + a[2].abs());
            let (lo, hi) = (p[0].min(p[1]).min(p[2]), p[0].max(p[1]).max(p[2]));
            (lo - reach).max(-reach - hi)
        })
        .fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn the_shell_is_what_separating_axes_say() {
    let grid = Grid::new([0.0; 3], Length::mm(1.0), [9, 7, 6]).unwrap();
    let mut r = Lcg(7);
    let (mut touched, mut doubtful) = (0, 0);
    for n in 0..400 {
        let mut t = [0; 3].map(|_| r.point(-2.0, 9.0));
        match n % 4 {
            1 => t[2] = add(t[0], scale(sub(t[1], t[0]), r.unit())), // no area
            2 => t = t.map(|p| p.map(|c| (2.0 * c).round() / 2.0)),  // on cube faces and samples
            3 => t[2] = add(t[0], r.point(-0.4, 0.4)),               // slivers
            _ => {}
        }
        let mesh = TriangleMesh::weld([t]);
        let lattice = Lattice::new(&mesh, &grid).unwrap();
        let mut words = vec![0u64; 7 * 6];
        shell::mark(&lattice, 0, 0..6, &mut words);
        for at in 0..grid.samples() {
            let [i, j, k] = grid.index(at);
            let marked = words[k * 7 + j] >> i & 1 == 1;
            // Rounding moves corners by less than one unit, the shell is widened by one, and an edge function by
            // one unit along both axes: three units of 2^-16 are in doubt.
            let gap = separation(t, grid.position([i, j, k]), 0.5);
            if gap <= 0.0 {
                assert!(marked, "missed {:?} by {t:?}, gap {gap:e}", [i, j, k]);
            }
            if gap > 4.0 / 65536.0 {
                assert!(!marked, "extra {:?} by {t:?}, gap {gap:e}", [i, j, k]);
            }
            touched += usize::from(marked);
            doubtful += usize::from(gap > 0.0 && gap <= 4.0 / 65536.0);
        }
    }
    assert!(touched > 5000 && doubtful < 50, "{touched} {doubtful}");
}

/// Volume of a tetrahedron cut to a box, by cutting it into tetrahedra plane by plane.
fn cut_volume(p: [Vec3; 4], lo: Vec3, hi: Vec3) -> f64 {
    let mut parts = vec![p];
    for axis in 0..3 {
        for (at, sign) in [(lo[axis], 1.0), (hi[axis], -1.0)] {
            parts = parts.into_iter().flat_map(|t| keep(t, |p| sign * (p[axis] - at))).collect();
        }
    }
    parts.iter().map(|t| dot(sub(t[1], t[0]), cross(sub(t[2], t[0]), sub(t[3], t[0]))).abs() / 6.0).sum()
}

/// The tetrahedra of the part of a tetrahedron on which a linear function is not negative.
fn keep(t: [Vec3; 4], f: impl Fn(Vec3) -> f64) -> Vec<[Vec3; 4]> {
    let (inside, outside): (Vec<Vec3>, Vec<Vec3>) = t.into_iter().partition(|&p| f(p) >= 0.0);
    let cut = |a: Vec3, b: Vec3| add(a, scale(sub(b, a), f(a) / (f(a) - f(b))));
    let prism =
        |a: [Vec3; 3], b: [Vec3; 3]| vec![[a[0], a[1], a[2], b[2]], [a[0], a[1], b[1], b[2]], [a[0], b[0], b[1], b[2]]];
    match (&inside[..], &outside[..]) {
        (_, []) => vec![t],
        ([a], [b, c, d]) => vec![[*a, cut(*a, *b), cut(*a, *c), cut(*a, *d)]],
        ([a, b], [c, d]) => prism([*a, cut(*a, *c), cut(*a, *d)], [*b, cut(*b, *c), cut(*b, *d)]),
        ([a, b, c], [d]) => prism([*a, *b, *c], [cut(*a, *d), cut(*b, *d), cut(*c, *d)]),
        _ => Vec::new(),
    }
}

#[test]
fn density_is_the_volume_of_the_cut_tetrahedron() {
    let grid = Grid::new([0.25; 3], Length::mm(0.5), [14, 15, 13]).unwrap();
    let mut r = Lcg(3);
    for n in 0..60 {
        let mut p = [0; 4].map(|_| r.point(-1.0, 8.0));
        if n % 3 == 0 {
            p = p.map(|p| p.map(|c| (2.0 * c).round() / 2.0));
        }
        let solid = voxelize(&tetrahedron(p), &grid, Crossings).unwrap();
        solid.validate().unwrap();
        for at in 0..grid.samples() {
            let c = grid.position(grid.index(at));
            let truth = cut_volume(p, c.map(|x| x - 0.25), c.map(|x| x + 0.25)) / 0.125;
            let found = f64::from(solid.density.field().values()[at]);
            // Corners move by h/2^17 along each axis: at most √3·√3·2^-17 of a cube; the rest is f32 rounding.
            assert!((found - truth).abs() < 5e-5, "{:?}: {found} for {truth} in {p:?}", grid.index(at));
        }
    }
}

fn solid_of(mesh: &TriangleMesh, h: f64, phase: Vec3) -> Solid {
    let (lo, hi) = mesh.bounds().unwrap();
    let grid = Grid::covering(lo, hi, Length::mm(h), 1, phase).unwrap();
    let solid = voxelize(mesh, &grid, Crossings).unwrap();
    solid.validate().unwrap();
    solid
}

#[test]
fn volumes_are_exact_at_any_phase_and_turn() {
    let mut r = Lcg(11);
    let cube = block([0.0; 3], [20.0; 3]);
    let ball = sphere(7.0, 5);
    for n in 0..6 {
        let phase = r.point(-0.49, 0.49);
        let turn = r.rotation();
        for (mesh, name) in [(&cube, "box"), (&ball, "ball")] {
            let mesh = if n % 2 == 0 { mesh.clone() } else { mesh.transformed(turn, [1.0, 2.0, 3.0]) };
            let (lo, hi) = mesh.bounds().unwrap();
            let longest = (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max);
            let solid = solid_of(&mesh, longest / 128.0, phase);
            let truth = mesh.signed_volume();
            let error = solid.density.volume().as_mm3() / truth - 1.0;
            // Corners are rounded to h/2^16, 1/8e6 of the part; the f32 sums are good to 1e-7.
            assert!(error.abs() < 1e-6, "{name}: {error:e}");
            assert!(solid.inner.volume().as_mm3() < truth && truth < solid.outer.volume().as_mm3());
        }
    }
}

#[test]
fn a_thin_sheet_is_touched_and_full_of_its_own_volume() {
    for n in 0..5 {
        let z = 1.0 + 0.2 * n as f64 / 5.0;
        let mesh = block([0.0, 0.0, z], [8.0, 6.0, z + 0.05]);
        let solid = solid_of(&mesh, 0.2, [0.0, 0.0, n as f64 / 11.0]);
        assert!(solid.outer.count() >= 40 * 30, "{}", solid.outer.count());
        assert!(solid.inner.is_empty());
        assert!((solid.density.volume().as_mm3() - 2.4).abs() < 1e-5);
    }
}

#[test]
fn overlapping_bodies_are_a_union_and_inner_shells_subtract() {
    let a = block([0.0; 3], [6.0, 4.0, 4.0]);
    let b = block([2.3, 1.1, -1.2], [9.0, 3.1, 5.0]);
    let both = a.clone().joined(&b);
    let solid = solid_of(&both, 0.5, [0.1, 0.2, 0.3]);
    let [one, two] = [&a, &b].map(|m| occupancy(m, solid.centres.grid()).unwrap());
    assert_eq!(solid.centres, one.union(&two).unwrap());
    let truth = 96.0 + 6.7 * 2.0 * 6.2 - 3.7 * 2.0 * 4.0;
    // Cubes along the curves where both surfaces cross may count an overlap twice: at most 12 + 4 mm of curve here.
    assert!((solid.density.volume().as_mm3() - truth).abs() < 26.0 * 0.25, "{}", solid.density.volume());
    let hollow = block([0.0; 3], [6.0; 3]).joined(&block([1.3; 3], [4.4; 3]).flipped());
    let solid = solid_of(&hollow, 0.4, [0.3, 0.1, 0.2]);
    assert!((solid.density.volume().as_mm3() - (216.0 - 3.1f64.powi(3))).abs() < 1e-4);
    assert!(!solid.centres.contains(solid.centres.grid().sample_at([3.0; 3]).unwrap()));
}

#[test]
fn a_window_sees_what_the_whole_grid_sees() {
    let mesh = sphere(3.0, 4).joined(&sphere(1.4, 3).flipped());
    let whole = Grid::new([-4.0; 3], Length::mm(0.25), [33, 33, 33]).unwrap();
    let window = Grid::new([-1.0, -2.0, -0.5], Length::mm(0.25), [9, 21, 8]).unwrap();
    let [all, part] = [&whole, &window].map(|g| voxelize(&mesh, g, Crossings).unwrap());
    part.validate().unwrap();
    for at in 0..window.samples() {
        let [i, j, k] = window.index(at);
        let there = [i + 12, j + 8, k + 14];
        assert_eq!(part.centres.contains([i, j, k]), all.centres.contains(there));
        assert_eq!(part.inner.contains([i, j, k]), all.inner.contains(there));
        assert_eq!(part.outer.contains([i, j, k]), all.outer.contains(there));
        let [a, b] = [(&part, at), (&all, whole.offset(there))].map(|(s, at)| s.density.field().values()[at]);
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let mesh = sphere(3.0, 5);
    let grid = Grid::covering([-3.0; 3], [3.0; 3], Length::mm(0.1), 1, [0.2, 0.1, 0.3]).unwrap();
    let cast = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| voxelize(&mesh, &grid, Crossings).unwrap())
    };
    assert_eq!(cast(1), cast(3));
}

#[test]
fn slabs_are_the_whole_bit_for_bit() {
    let mut random = Lcg(11);
    for case in 0..6 {
        // Turned, overlapping and with a cavity, at a size that is no multiple of the spacing.
        let turned = sphere(4.3, 4).joined(&sphere(2.1, 3).flipped());
        let part =
            turned.transformed(random.rotation(), random.point(-3.0, 3.0)).joined(&block([0.3; 3], [5.1, 4.0, 6.2]));
        let (lo, hi) = part.bounds().unwrap();
        let grid = Grid::covering(lo, hi, Length::mm(0.137), 1, [0.1 * case as f64, 0.2, 0.3]).unwrap();
        let whole = voxelize(&part, &grid, Crossings).unwrap();
        let [nx, ny, nz] = grid.dims();
        for thick in [1, 7, 32, nz] {
            for first in (0..nz).step_by(thick) {
                let range = first..(first + thick).min(nz);
                let slab = voxelize_layers(&part, &grid, range.clone(), Crossings).unwrap();
                let words =
                    range.start * ny * whole.inner.words_per_row()..range.end * ny * whole.inner.words_per_row();
                assert_eq!(slab.inner.words(), &whole.inner.words()[words.clone()], "inner, {range:?}");
                assert_eq!(slab.centres.words(), &whole.centres.words()[words.clone()], "centres, {range:?}");
                assert_eq!(slab.outer.words(), &whole.outer.words()[words], "outer, {range:?}");
                let samples = nx * ny * range.start..nx * ny * range.end;
                let [own, all] = [&slab, &whole].map(|s| s.density.field().values().to_vec());
                let same = own.iter().zip(&all[samples]).all(|(a, b)| a.to_bits() == b.to_bits());
                assert!(same, "density, {range:?}");
            }
        }
        assert!(voxelize_layers(&part, &grid, 3..3, Crossings).is_err());
        assert!(voxelize_layers(&part, &grid, 0..nz + 1, Crossings).is_err());
    }
}
