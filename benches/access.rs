//! Obstacles, reach and overlap volumes: `cargo bench --bench access`.

use amcheck::access::{
    Inflation, Sense, Setup, Stack, Tool, Touching, Trio, about, fibonacci, lattice_directions, line_of_sight,
    overlap_counts, overlap_counts_by_transform, patches, reach,
};
use amcheck::convolution::Descent;
use amcheck::geometry::{InsideRule, MeshDistance, Primitive, TriangleMesh};
use amcheck::io::{Salvage, read_path};
use amcheck::morphology::{Sides, StructuringElement, dilate};
use amcheck::process::ToolChoice;
use amcheck::units::Length;
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

/// A ball of 40 mm with a cavity open to nowhere and four posts beside it: curved, concave, many facets.
fn part() -> TriangleMesh {
    let mesh = |text: &str| Primitive::parse(text).unwrap().mesh(Length::mm(0.01));
    let moved = |m: TriangleMesh, by: [f64; 3]| m.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], by);
    let posts = (0..4).map(|n| {
        let (x, y) = (if n % 2 == 0 { 30.0 } else { -30.0 }, if n / 2 == 0 { 30.0 } else { -30.0 });
        moved(mesh("cylinder:r4h60mm"), [x, y, 0.0])
    });
    posts.fold(mesh("ball:20mm").joined(&mesh("ball:12mm").flipped()), |part, post| part.joined(&post))
}

fn spacing(samples: usize) -> Length {
    Length::mm(68.0 / samples as f64)
}

fn tool(name: &str) -> Tool {
    Tool::chosen(&ToolChoice::named(name).unwrap()).unwrap()
}

fn setup(samples: usize) -> Setup {
    Setup::cast(&part(), InsideRule::Crossings, [0.0, 0.0, 1.0], spacing(samples), Length::mm(4.0)).unwrap()
}

/// Turning and casting the part for one oblique direction.
#[divan::bench(args = [128, 256], sample_count = 10)]
fn cast_one_direction(bencher: Bencher, samples: usize) {
    let mesh = part();
    let d = lattice_directions()[18];
    bencher.bench(|| Setup::cast(black_box(&mesh), InsideRule::Crossings, d, spacing(samples), Length::mm(4.0)));
}

/// The free tips of a coaxial tool with holder in one direction, the part being cast.
#[divan::bench(args = [128, 256], sample_count = 20)]
fn one_direction(bencher: Bencher, samples: usize) {
    let (setup, tool) = (setup(samples), tool("end-mill-6"));
    let m = tool.meridian().unwrap();
    bencher.bench(|| Stack::overlapping(m, spacing(samples)).dilate(black_box(&setup.outer), Sense::Obstacle));
}

/// What is seen along the six axes, both sides: the part being cast, one scan a direction.
#[divan::bench(args = [128, 256], sample_count = 20)]
fn six_axes_in_sight(bencher: Bencher, samples: usize) {
    let mesh = part();
    let cast = |d| Setup::cast(&mesh, InsideRule::Crossings, d, spacing(samples), Length::mm(4.0)).unwrap();
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(cast);
    let opposites = [0, 1, 2].map(|n| axes[n].opposite().unwrap());
    bencher.bench(|| axes.iter().chain(&opposites).map(|s| line_of_sight(black_box(s))).collect::<Vec<_>>());
}

/// Both sides of the obstacle.
#[divan::bench(args = [128], sample_count = 20)]
fn one_direction_from_both_sides(bencher: Bencher, samples: usize) {
    let (setup, tool) = (setup(samples), tool("end-mill-6"));
    bencher.bench(|| Trio::of_coaxial(black_box(&setup), tool.meridian().unwrap(), Inflation::default()));
}

/// Casting and free tips for 162 directions.
#[divan::bench(sample_count = 1, sample_size = 1)]
fn directions_162(bencher: Bencher) {
    let (mesh, tool, h) = (part(), tool("end-mill-6"), spacing(128));
    let m = tool.meridian().unwrap();
    bencher.bench(|| {
        fibonacci(162).chunks(2).for_each(|pair| {
            let one = Setup::cast(&mesh, InsideRule::Crossings, pair[0], h, Length::mm(4.0)).unwrap();
            let other = one.opposite().unwrap();
            for s in [&one, &other] {
                black_box(Stack::overlapping(m, h).dilate(&s.outer, Sense::Obstacle));
            }
        });
    });
}

/// Overlap volumes of the digital tool, by sums of slices and by transforms.
#[divan::bench(args = [64, 128], sample_count = 5)]
fn overlap_by_slices(bencher: Bencher, samples: usize) {
    let (setup, tool) = (setup(samples), tool("end-mill-6"));
    let stack = Stack::middles(tool.meridian().unwrap(), spacing(samples));
    bencher.bench(|| overlap_counts(black_box(&setup.centres), &stack));
}

#[divan::bench(args = [64, 128], sample_count = 3)]
fn overlap_by_transforms(bencher: Bencher, samples: usize) {
    let (setup, tool) = (setup(samples), tool("end-mill-6"));
    let stack = Stack::middles(tool.meridian().unwrap(), spacing(samples));
    bencher.bench(|| overlap_counts_by_transform(black_box(&setup.centres), &stack));
}

/// The part named by `AMCHECK_BENCH_PART`, an STL file, with `samples` along its longest side; without it, the ball among posts.
fn named_part(samples: usize) -> (TriangleMesh, Length) {
    let Some(path) = std::env::var_os("AMCHECK_BENCH_PART") else { return (part(), spacing(samples)) };
    let mesh = read_path(path.as_ref(), u64::MAX, Salvage::Refuse).unwrap().1.mesh;
    let (lo, hi) = mesh.bounds().unwrap();
    let longest = (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max);
    (mesh, Length::mm(longest / samples as f64))
}

/// An end mill with its holder and a handle to one side, as a mesh: 49 mm wide, 60 mm long.
fn lopsided_mill() -> TriangleMesh {
    let handle = Primitive::parse("box:30x4x4mm").unwrap().mesh(Length::mm(1.0));
    let handle = handle.transformed(about([0.0, 0.0, 1.0]), [20.0, 0.0, 45.0]);
    tool("end-mill-6").mesh(60.0, 48).joined(&handle)
}

/// Where a tool of any shape meets the part, for 26 directions, the tool turned and cast for each; the result is exact.
#[divan::bench(args = [128, 256], sample_count = 3, sample_size = 1)]
fn any_tool_26_directions(bencher: Bencher, samples: usize) {
    let ((mesh, h), mill) = (named_part(samples), lopsided_mill());
    let outer = Sides::of_mesh(&mesh, h, [0.25; 3]).unwrap().touched;
    bencher.bench(|| {
        let ready = Descent::new(black_box(&outer));
        for d in lattice_directions() {
            let posed = Sides::of_mesh(&mill.transformed(about(d), [0.0; 3]), h, [0.25; 3]).unwrap();
            black_box(ready.met_by(&posed.touched).unwrap());
        }
    });
}

/// One direction of the same by the cheapest path of a dilation, which keeps nothing of the part.
#[divan::bench(args = [128, 256], sample_count = 3, sample_size = 1)]
fn any_tool_one_direction_by_dilation(bencher: Bencher, samples: usize) {
    let ((mesh, h), mill) = (named_part(samples), lopsided_mill());
    let outer = Sides::of_mesh(&mesh, h, [0.25; 3]).unwrap().touched;
    let posed = Sides::of_mesh(&mill.transformed(about(lattice_directions()[18]), [0.0; 3]), h, [0.25; 3]).unwrap();
    let element = StructuringElement::new(posed.touched.reflected()).unwrap();
    bencher.bench(|| dilate(black_box(&outer), &element));
}

/// All patches of the surface against one tool from 26 directions, the part being cast.
#[divan::bench(args = [96, 128], sample_count = 3)]
fn reach_from_26_directions(bencher: Bencher, samples: usize) {
    let (mesh, h) = (part(), spacing(samples));
    let setups = Setup::all(&mesh, InsideRule::Crossings, &lattice_directions(), h, Length::mm(4.0)).unwrap();
    let list: Vec<&Setup> = setups.iter().collect();
    let (surface, view) = (patches(&mesh, 2.0 * h.as_mm(), |_| true), MeshDistance::new(&mesh));
    let tools = [tool("end-mill-6")];
    bencher.bench(|| {
        reach(black_box(&surface), &tools, &list, (Touching::WithinStandOff, 3.5 * h.as_mm()), &view, |_| false)
    });
}
