//! Fast paths against plain ones, exactly: on small random sets, lopsided elements, and sets tight against the border.
//!
//! These are the tests that see a count of two taken for one, padding too short by a sample, a transform that wraps
//! around, and a shifted or reflected element.

mod random;

use amcheck::convolution::{Convolver, Precision, convolve_directly, convolve_tiled, dilate_by_runs, dilate_tiled};
use amcheck::field::Indicator;
use amcheck::grid::Grid;
use amcheck::morphology::{Path, StructuringElement, dilate, dilate_along, erode, erode_by_path};
use amcheck::units::Length;
use random::Random;

const H: f64 = 0.4;

impl Random {
    /// A random set on a grid of random counts; one in `thin` samples is inside.
    fn set(&mut self, most: [usize; 3], thin: usize) -> Indicator {
        let dims = most.map(|n| 1 + self.below(n));
        let origin = [0, 1, 2].map(|_| H * self.below(9) as f64 - 1.3);
        let grid = Grid::new(origin, Length::mm(H), dims).unwrap();
        let bits: Vec<bool> = (0..grid.samples()).map(|_| self.below(thin) == 0).collect();
        Indicator::from_predicate(grid, |at| bits[at])
    }

    /// A random element that is not empty and has no symmetry but by chance.
    fn element(&mut self) -> StructuringElement {
        loop {
            let thin = 1 + self.below(3);
            if let Ok(element) = StructuringElement::new(self.set([6, 5, 4], thin)) {
                return element;
            }
        }
    }
}

/// Peak memory of a convolution with a kept spectrum: at most three fields of doubles of the padded size.
#[test]
fn a_convolution_takes_at_most_three_fields() {
    if !std::path::Path::new("/proc/self/status").exists() {
        println!("skipped: the system does not tell the peak");
        return;
    }
    // In a process of its own, where no other test takes memory.
    let this = std::env::current_exe().unwrap();
    let alone = std::process::Command::new(this)
        .args(["--ignored", "--exact", "one_convolution_and_its_peak", "--nocapture"])
        .output()
        .unwrap();
    assert!(alone.status.success(), "{}", String::from_utf8_lossy(&alone.stdout));
}

#[test]
#[ignore = "measures the process it runs in"]
fn one_convolution_and_its_peak() {
    let kib = |name: &str| -> f64 {
        let text = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = text.lines().find(|line| line.starts_with(name)).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    };
    let set = |n: usize| {
        let grid = Grid::new([0.0; 3], Length::mm(H), [n; 3]).unwrap();
        Indicator::from_predicate(grid, |at| at % 7 < 3)
    };
    let (part, element) = (set(161), set(32));
    let before = kib("VmRSS");
    let counts = Convolver::new(&part, [32; 3]).unwrap().convolve_in(Precision::Double, &element).unwrap();
    // 161 + 32 − 1 is 192 = 2⁶·3: nothing is padded beyond need.
    let field = 8.0 * 192f64.powi(3) / 1024.0;
    let fields = (kib("VmHWM") - before) / field;
    println!("{fields:.2} fields of {field} KiB, {} translations", counts.at_least(1).count());
    assert!(fields <= 3.0, "{fields} fields");
}

#[test]
fn every_way_to_count_counts_the_same_pairs() {
    let mut random = Random(2);
    for round in 0..60 {
        let (a, b) = (random.set([24, 13, 11], 1 + round % 5), random.element());
        let want = convolve_directly(&a, b.set()).unwrap();
        let convolver = Convolver::new(&a, b.set().grid().dims()).unwrap();
        for precision in [Precision::Single, Precision::Double, Precision::Modular] {
            // The smallest problems are proven even in single precision; larger ones are refused, never wrong.
            match convolver.convolve_in(precision, b.set()) {
                Ok(counts) => assert_eq!(counts.field, want, "round {round}, {precision:?}"),
                Err(e) => assert!(precision == Precision::Single && e.code() == "E040", "{e}"),
            }
        }
        assert_eq!(convolve_tiled(&a, b.set()).unwrap().field, want, "round {round}, tiles");
        let sum = Indicator::from_predicate(*want.grid(), |at| want.values()[at] >= 1);
        assert_eq!(dilate_by_runs(&a, b.set()).unwrap(), sum, "round {round}, bit rows");
        assert_eq!(dilate_tiled(&a, b.set()).unwrap().0, sum, "round {round}, tiles");
        assert_eq!(dilate(&a, &b).unwrap().set, sum, "round {round}");
    }
}

#[test]
fn a_single_pair_is_enough_and_the_last_sample_does_not_wrap() {
    // One sample in the last corner of a full-sized grid, one in the last corner of the element: count one, far corner.
    for dims in [[16, 16, 16], [12, 9, 8], [31, 2, 5]] {
        let last = |dims: [usize; 3]| {
            let mut set = Indicator::empty(Grid::new([0.0; 3], Length::mm(H), dims).unwrap());
            set.set(dims.map(|n| n - 1), true);
            set
        };
        let (a, b) = (last(dims), last([5, 4, 3]));
        let counts = Convolver::new(&a, [5, 4, 3]).unwrap().convolve(&b).unwrap().field;
        let want = [0, 1, 2].map(|i| dims[i] + [5, 4, 3][i] - 2);
        assert_eq!(counts.values().iter().sum::<u32>(), 1);
        assert_eq!(counts.values()[counts.grid().offset(want)], 1);
        assert_eq!(dilate_tiled(&a, &b).unwrap().0.iter().collect::<Vec<_>>(), [counts.grid().offset(want)]);
    }
}

#[test]
fn correlation_is_convolution_with_the_reflected_element() {
    let mut random = Random(8);
    for round in 0..40 {
        let (a, b) = (random.set([20, 9, 7], 2), random.element());
        let convolver = Convolver::new(&a, b.set().grid().dims()).unwrap();
        let correlated = convolver.correlate(b.set()).unwrap().field;
        let convolved = convolver.convolve(b.reflected().set()).unwrap().field;
        assert_eq!(correlated.values(), convolved.values(), "round {round}");
        let off = [0, 1, 2].map(|i| correlated.grid().origin()[i] - convolved.grid().origin()[i]);
        assert!(off.iter().all(|d| d.abs() < 1e-12), "round {round}: {off:?}");
    }
}

#[test]
fn erosion_is_where_the_count_is_full_on_every_path() {
    let mut random = Random(4);
    for round in 0..40 {
        let (a, b) = (random.set([18, 10, 9], 12).complement(), random.element());
        let counts = Convolver::new(&a, b.set().grid().dims()).unwrap().correlate(b.set()).unwrap();
        let want = counts.at_least(b.set().count() as u32);
        for path in [Path::BitRows, Path::Transform(Precision::Double)] {
            let eroded = erode_by_path(path, &a, &b).unwrap().set;
            assert_eq!(eroded.words(), want.words(), "round {round}, {path}");
        }
        assert_eq!(erode(&a, &b).unwrap().set.words(), want.words(), "round {round}");
    }
}

#[test]
fn balls_and_boxes_are_the_same_by_every_path() {
    let mut random = Random(6);
    let spacing = Length::mm(H);
    for radius in [0.0, 0.4, 0.9, 1.7] {
        let (a, ball) = (random.set([30, 14, 12], 20), StructuringElement::ball(Length::mm(radius), spacing).unwrap());
        let want = dilate_along(Path::BitRows, &a, &ball).unwrap().set;
        for path in [Path::DistanceTransform, Path::Transform(Precision::Double)] {
            assert_eq!(dilate_along(path, &a, &ball).unwrap().set, want, "{radius} mm, {path}");
        }
    }
    for counts in [[1, 1, 1], [5, 1, 2], [2, 9, 4], [1, 1, 8]] {
        let (a, cuboid) = (random.set([70, 14, 12], 20), StructuringElement::cuboid(counts, spacing).unwrap());
        let want = dilate_along(Path::BitRows, &a, &cuboid).unwrap().set;
        for path in [Path::RunningMaxima, Path::Transform(Precision::Double)] {
            assert_eq!(dilate_along(path, &a, &cuboid).unwrap().set, want, "{counts:?}, {path}");
        }
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let mut random = Random(12);
    let (a, b) = (random.set([60, 40, 30], 2), random.element());
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let counts = Convolver::new(&a, b.set().grid().dims()).unwrap().convolve(b.set()).unwrap();
            (counts, dilate(&a, &b).unwrap().set, amcheck::operate::offset(&part(), Length::mm(0.7), Length::mm(0.3)))
        })
    };
    assert_eq!(with(1), with(3));
}

fn part() -> amcheck::geometry::TriangleMesh {
    amcheck::geometry::Primitive::parse("cone:r2r0.5h3mm").unwrap().mesh(Length::mm(0.05))
}

/// A dilation of A by B.
type Dilates = fn(&Indicator, &Indicator) -> Indicator;

/// The harness: whether a dilation equals the plain sum `{ a + b }` on random sets, on full ones that fill their grid up
/// to the border, and on single samples in the last corner.
fn agrees_with_the_plain_sum(dilates: Dilates) -> bool {
    let mut random = Random(21);
    let full = |dims| Indicator::from_predicate(Grid::new([0.3, 0.0, -0.4], Length::mm(H), dims).unwrap(), |_| true);
    let last = |dims: [usize; 3]| {
        let mut set = Indicator::empty(Grid::new([0.0; 3], Length::mm(H), dims).unwrap());
        set.set(dims.map(|n| n - 1), true);
        set
    };
    let mut pairs = vec![(full([7, 5, 4]), full([3, 2, 2])), (last([16, 9, 8]), last([5, 4, 3]))];
    pairs.extend((0..12).map(|_| (random.set([14, 9, 8], 4), random.element().set().clone())));
    pairs.iter().all(|(a, b)| {
        let counts = convolve_directly(a, b).unwrap();
        let want = Indicator::from_predicate(*counts.grid(), |at| counts.values()[at] > 0);
        let made = dilates(a, b);
        let apart = [0, 1, 2].map(|i| (made.grid().origin()[i] - want.grid().origin()[i]).abs());
        apart.iter().all(|d| *d < 1e-9) && made.words() == want.words()
    })
}

/// Where the transform counts at least `least` pairs.
fn counted(a: &Indicator, b: &Indicator, least: u32) -> Indicator {
    Convolver::new(a, b.grid().dims()).unwrap().convolve(b).unwrap().at_least(least)
}

fn on(grid: Grid, from: &Indicator) -> Indicator {
    Indicator::from_words(grid, from.words().to_vec()).unwrap()
}

/// Counts by a cyclic transform of `short` samples too few along every axis: what is cut off at the end comes back at
/// the beginning.
fn wrapped(a: &Indicator, b: &Indicator, short: usize) -> Indicator {
    let whole = counted(a, b, 1);
    let dims = whole.grid().dims();
    let cycle = dims.map(|n| n.saturating_sub(short).max(1));
    let mut set = Indicator::empty(*whole.grid());
    for at in whole.iter() {
        let index = whole.grid().index(at);
        set.set([0, 1, 2].map(|i| index[i] % cycle[i]), true);
    }
    set
}

/// Deliberate mistakes in the operator itself, each rejected by the same harness that the right one passes:
/// `cargo test --release --test direct mutations -- --nocapture` shows the list.
#[test]
fn mutations_of_the_operator_are_rejected() {
    let right: [(&str, Dilates); 3] = [
        ("count of at least one", |a, b| counted(a, b, 1)),
        ("bit rows", |a, b| dilate_by_runs(a, b).unwrap()),
        ("padding that is long enough", |a, b| wrapped(a, b, 0)),
    ];
    for (name, dilates) in right {
        assert!(agrees_with_the_plain_sum(dilates), "{name} is right and was rejected");
    }
    let wrong: [(&str, Dilates); 8] = [
        ("count of at least two", |a, b| counted(a, b, 2)),
        ("padding short by one sample", |a, b| wrapped(a, b, 1)),
        ("padding short by the element", |a, b| wrapped(a, b, b.grid().dims()[0] - 1)),
        ("element reflected", |a, b| {
            let mirrored = b.reflected();
            on(*counted(a, b, 1).grid(), &counted(a, &mirrored, 1))
        }),
        ("element with x and y swapped", |a, b| {
            let g = b.grid();
            let ([x, y, z], [nx, ny, nz]) = (g.origin(), g.dims());
            let grid = Grid::new([y, x, z], g.spacing(), [ny, nx, nz]).unwrap();
            let swapped = Indicator::from_predicate(grid, |at| {
                let [i, j, k] = grid.index(at);
                b.contains([j, i, k])
            });
            counted(a, &swapped, 1)
        }),
        ("result one sample to +x", |a, b| {
            let sum = counted(a, b, 1);
            sum.placed([-1, 0, 0], *sum.grid()).unwrap()
        }),
        ("result half a cell off", |a, b| {
            let sum = counted(a, b, 1);
            let g = sum.grid();
            on(Grid::new(g.origin().map(|o| o + 0.5 * H), g.spacing(), g.dims()).unwrap(), &sum)
        }),
        ("last layer lost", |a, b| {
            let sum = counted(a, b, 1);
            let [nx, ny, nz] = sum.grid().dims();
            let upper = Indicator::from_predicate(*sum.grid(), |at| at / (nx * ny) == nz - 1);
            sum.difference(&upper).unwrap()
        }),
    ];
    for (name, dilates) in wrong {
        assert!(!agrees_with_the_plain_sum(dilates), "{name} went unnoticed");
        println!("rejected: {name}");
    }
}
