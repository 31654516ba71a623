//! Casting and distances at three sizes. `cargo bench --bench fields`; `AMCHECK_BENCH_STL=part.stl` adds a part.

use amcheck::distance::{nearest_sample, signed_distance, squared_distance, union_of_balls};
use amcheck::field::Indicator;
use amcheck::geometry::{InsideRule, TriangleMesh, occupancy, voxelize};
use amcheck::grid::Grid;
use amcheck::layer::{downward_facets, support_volume, supports};
use amcheck::medial::thickness::local_thickness;
use amcheck::topology::{Adjacency, Side, betti, border, chambers, components};
use amcheck::units::{Angle, Length};
use divan::{Bencher, black_box};

const SIZES: [usize; 3] = [128, 256, 512];

fn main() {
    divan::main();
}

/// A torus knot with ripples: closed, curved, hollow in its box, with `m`·`m`/8 facets.
fn knot(m: usize) -> TriangleMesh {
    let n = m / 16;
    let turn = std::f64::consts::TAU;
    let centre = |s: f64| {
        let (a, b) = (2.0 * turn * s, 3.0 * turn * s);
        [(20.0 + 7.0 * b.cos()) * a.cos(), (20.0 + 7.0 * b.cos()) * a.sin(), 9.0 * b.sin()]
    };
    let point = |i: usize, j: usize| {
        let (s, t) = (i as f64 / m as f64, turn * j as f64 / n as f64);
        let (p, q) = (centre(s), centre(s + 1e-5));
        let d = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
        let along = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        let d = d.map(|c| c / along);
        // Two directions across the curve.
        let flat = (d[0] * d[0] + d[1] * d[1]).sqrt();
        let u = [-d[1] / flat, d[0] / flat, 0.0];
        let v = [d[1] * u[2] - d[2] * u[1], d[2] * u[0] - d[0] * u[2], d[0] * u[1] - d[1] * u[0]];
        let r = 3.0 + 0.3 * (60.0 * turn * s).sin() * (5.0 * t).cos();
        [0, 1, 2].map(|a| p[a] + r * (t.cos() * u[a] + t.sin() * v[a]))
    };
    let vertices = (0..m * n).map(|at| point(at / n, at % n)).collect();
    let at = |i: usize, j: usize| ((i % m) * n + j % n) as u32;
    let triangles = (0..m * n)
        .flat_map(|q| {
            let (i, j) = (q / n, q % n);
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
        .collect();
    let mesh = TriangleMesh { vertices, triangles };
    if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh }
}

/// The part given by the environment, else a knot of about 225 000 facets.
fn part() -> TriangleMesh {
    let given =
        std::env::var_os("AMCHECK_BENCH_STL").and_then(|path| std::fs::File::open(path).ok()).and_then(|file| {
            let mut file = std::io::BufReader::new(file);
            let facets = stl_io::create_stl_reader(&mut file).ok()?;
            let corners = |t: stl_io::Triangle| t.vertices.map(|v| [0, 1, 2].map(|a| f64::from(v[a])));
            Some(TriangleMesh::weld(facets.flatten().map(corners)))
        });
    given.unwrap_or_else(|| knot(1344))
}

/// A grid with `n` samples along each axis about the part, which is as long as n − 4 of them.
fn grid(mesh: &TriangleMesh, n: usize) -> Grid {
    let (lo, hi) = mesh.bounds().expect("a part has facets");
    let longest = (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max);
    let h = longest / (n as f64 - 4.0);
    let origin = [0, 1, 2].map(|a| 0.5 * (lo[a] + hi[a]) - 0.5 * h * (n as f64 - 1.0));
    Grid::new(origin, Length::mm(h), [n; 3]).expect("a grid about the part")
}

fn cast(n: usize) -> Indicator {
    let mesh = part();
    occupancy(&mesh, &grid(&mesh, n)).expect("a closed part")
}

#[divan::bench(args = SIZES)]
fn samples_inside(bencher: Bencher, n: usize) {
    let mesh = part();
    let grid = grid(&mesh, n);
    bencher.bench(|| occupancy(black_box(&mesh), &grid));
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn inner_outer_density(bencher: Bencher, n: usize) {
    let mesh = part();
    let grid = grid(&mesh, n);
    bencher.bench(|| voxelize(black_box(&mesh), &grid, InsideRule::Crossings));
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn distance_both_sides(bencher: Bencher, n: usize) {
    let set = cast(n);
    bencher.bench(|| signed_distance(black_box(&set)));
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn distance_one_side(bencher: Bencher, n: usize) {
    let set = cast(n);
    bencher.bench(|| squared_distance(black_box(&set)));
}

#[divan::bench(args = [128, 256], sample_count = 10)]
fn nearest_samples(bencher: Bencher, n: usize) {
    let set = cast(n);
    bencher.bench(|| nearest_sample(black_box(&set)));
}

#[divan::bench(args = [128, 256], sample_count = 10)]
fn balls(bencher: Bencher, n: usize) {
    let set = cast(n);
    bencher.bench(|| union_of_balls(set.grid(), |at| set.contains(set.grid().index(at)).then_some(at as u32 % 60)));
}

/// Both bounds of the local thickness of the whole part, distance transforms included.
#[divan::bench(args = [128, 256], sample_count = 5)]
fn local_thickness_with_bounds(bencher: Bencher, n: usize) {
    let mesh = part();
    let solid = voxelize(&mesh, &grid(&mesh, n), InsideRule::Crossings).expect("a solid");
    bencher.bench(|| local_thickness(black_box(&solid), amcheck::medial::Side::Material, None));
}

/// Supports of the part as it lies, by columns with bounds and as samples.
#[divan::bench(args = [128, 256], sample_count = 10)]
fn support_columns_with_bounds(bencher: Bencher, n: usize) {
    let mesh = part();
    let h = grid(&mesh, n).h();
    let plate = mesh.bounds().map_or(0.0, |b| b.0[2]);
    let wanted = downward_facets(&mesh, plate, Angle::degrees(45.0), 1e-6);
    bencher.bench(|| support_volume(black_box(&mesh), |_| true, &wanted, plate, h));
}

#[divan::bench(args = [128, 256], sample_count = 10)]
fn support_samples(bencher: Bencher, n: usize) {
    let mesh = part();
    let set = cast(n);
    let plate = mesh.bounds().map_or(0.0, |b| b.0[2]);
    let wanted = downward_facets(&mesh, plate, Angle::degrees(45.0), 1e-6);
    bencher.bench(|| supports(black_box(&set), &mesh, &wanted, plate));
}

#[divan::bench(args = [128, 256], sample_count = 10)]
fn pieces_and_tunnels(bencher: Bencher, n: usize) {
    let set = cast(n);
    bencher.bench(|| (components(black_box(&set), Adjacency::Face).count(), betti(&set, Adjacency::Face)));
}

/// A cube with a room of nine tenths of it and a neck of a sixteenth, the worst case: all of the void is one chamber.
fn flask(n: usize) -> Indicator {
    let grid = Grid::new([0.0; 3], Length::mm(0.1), [n; 3]).expect("a grid");
    let within = |c: usize, wide: usize| (2 * c + 1).abs_diff(n) < wide;
    Indicator::from_predicate(grid, |at| {
        let [i, j, k] = grid.index(at);
        let room = [i, j, k].into_iter().all(|c| within(c, n * 9 / 10));
        let neck = within(i, n / 16) && within(j, n / 16) && 2 * k > n;
        [i, j, k].into_iter().all(|c| within(c, n - 4)) && !room && !neck
    })
}

#[divan::bench(args = [256, 512], sample_count = 3)]
fn trapped_volume_and_way_out(bencher: Bencher, n: usize) {
    let part = flask(n);
    let exits = border(part.grid(), &Side::ALL);
    let level = (n / 12).pow(2) as u32;
    bencher.bench(|| {
        let clearance = squared_distance(black_box(&part)).expect("a grid that fits");
        let found = chambers(&clearance, &exits, level, |_| false).expect("one grid");
        assert!(found.len() == 1 && found[0].throat.is_some());
        found
    });
}
