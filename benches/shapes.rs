//! Offsets, openings and general sums from mesh to mesh: `cargo bench --bench shapes`; `AMCHECK_BENCH_PART=part.stl`
//! takes a part instead of the 20 mm cube, `AMCHECK_BENCH_SAMPLES=64,84` other numbers n of samples. The spacing is the
//! longest side over n − 4.

use amcheck::geometry::{Primitive, TriangleMesh};
use amcheck::io::{Salvage, read_path};
use amcheck::operate::{Element, Operated, close, minkowski, offset, open};
use amcheck::units::Length;
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

/// The mesh whose path a variable holds, or else a built-in shape.
fn mesh(variable: &str, or_else: &str, sagitta: f64) -> TriangleMesh {
    let given = std::env::var_os(variable)
        .map(|path| read_path(path.as_ref(), u64::MAX, Salvage::Refuse).expect("a readable mesh").1.mesh);
    given.unwrap_or_else(|| Primitive::parse(or_else).expect("a shape").mesh(Length::mm(sagitta)))
}

/// Runs that processor seconds are the mean of.
const AVERAGED: u32 = 5;

fn samples() -> Vec<usize> {
    let given = std::env::var("AMCHECK_BENCH_SAMPLES").unwrap_or_else(|_| "64,96,128,192,256".into());
    given.split(',').map(|n| n.trim().parse().expect("numbers of samples, separated by commas")).collect()
}

fn measured(bencher: Bencher, n: usize, make: impl Fn(&TriangleMesh, Length) -> amcheck::Result<Operated>) {
    let mesh = mesh("AMCHECK_BENCH_PART", "box:20x20x20mm", 1.0);
    let (lo, hi) = mesh.bounds().expect("a part has facets");
    let longest = (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max);
    let h = Length::mm(longest / (n as f64 - 4.0));
    let made = make(&mesh, h).expect("an answer");
    let before = processor_seconds();
    (0..AVERAGED).for_each(|_| drop(black_box(make(&mesh, h))));
    let spent = (processor_seconds() - before) / f64::from(AVERAGED);
    let [low, high] = made.bracket.map(|v| v.as_mm3());
    let facets = made.mesh.triangles.len();
    eprintln!("{n}: {spent:.3} CPU s, {:.3} in {low:.1} … {high:.1} mm³, {facets} facets", made.volume.as_mm3());
    bencher.bench_local(|| make(black_box(&mesh), h));
}

/// Of all threads, user and system, where the system tells: what counts on a machine that does other work.
fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text.rsplit(')').next().unwrap_or("").split_whitespace();
    fields.skip(11).take(2).filter_map(|w| w.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn ball(radius: f64) -> Element {
    Element::BuiltIn(Primitive::Ball { radius: Length::mm(radius) })
}

#[divan::bench(args = samples(), sample_count = 3, sample_size = 1)]
fn offset_by_2mm(bencher: Bencher, n: usize) {
    measured(bencher, n, |mesh, h| offset(mesh, Length::mm(2.0), h));
}

#[divan::bench(args = samples(), sample_count = 3, sample_size = 1)]
fn open_by_half_a_mm(bencher: Bencher, n: usize) {
    measured(bencher, n, |mesh, h| open(mesh, &ball(0.5), h));
}

#[divan::bench(args = samples(), sample_count = 3, sample_size = 1)]
fn close_by_half_a_mm(bencher: Bencher, n: usize) {
    measured(bencher, n, |mesh, h| close(mesh, &ball(0.5), h));
}

/// The sum with a faceted ball of 2 mm, or with the mesh that `AMCHECK_BENCH_ELEMENT` names.
#[divan::bench(args = [128, 256], sample_count = 3, sample_size = 1)]
fn sum_with_a_mesh(bencher: Bencher, n: usize) {
    let element = Element::Mesh(mesh("AMCHECK_BENCH_ELEMENT", "ball:2mm", 0.04));
    measured(bencher, n, |mesh, h| minkowski(mesh, &element, h));
}
