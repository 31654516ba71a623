//! §2.3: defining functions, collisions, C-obstacles and δ.

use super::*;

#[test]
fn definition_2_3_1_indicators_and_sets_are_one_to_one_and_negation_is_the_complement() {
    let set = Random(11).set_on(grid([9, 8, 7]), 3);
    let f = indicator_function(&set);
    assert_eq!(superlevel(&f, 0.0), set);
    assert_eq!(superlevel(&complement(&f), 0.0), set.complement());
    // 2.3.13: every level between 0 and 1 retrieves the set.
    assert!([0.0, 0.3, 0.999].into_iter().all(|t| superlevel(&f, t) == set));
}

#[test]
fn definition_2_3_2_union_is_a_sum_and_intersection_a_product() {
    let mut random = Random(12);
    let (a, b) = (random.set_on(grid([9, 8, 7]), 3), random.set_on(grid([9, 8, 7]), 2));
    let [f, g] = [&a, &b].map(indicator_function);
    assert_eq!(superlevel(&sum(&f, &g).unwrap(), 0.0), a.union(&b).unwrap());
    assert_eq!(superlevel(&product(&f, &g).unwrap(), 0.0), a.intersection(&b).unwrap());
}

#[test]
fn definition_2_3_3_functions_with_one_support_are_one_set_and_booleans_are_idempotent() {
    let mut random = Random(13);
    let f = random.function_on(grid([9, 8, 7]));
    let set = superlevel(&f, 0.0);
    for g in [sum(&f, &f).unwrap(), product(&f, &f).unwrap(), indicator_function(&set)] {
        assert_eq!(superlevel(&g, 0.0), set);
    }
    // 2.3.16: the pushed negation of any of them is the indicator of the complement.
    assert_eq!(complement(&f).values(), indicator_function(&set.complement()).values());
}

#[test]
fn definition_2_3_4_functions_of_one_class_share_a_regularized_superlevel_set() {
    // Random positive functions on a block and on whiskers of one sample; sums and products stay in their class.
    let g = grid([16, 14, 12]);
    let mut random = Random(17);
    let mut on = |ranges: [std::ops::Range<usize>; 3], whisker: fn([usize; 3]) -> bool| {
        let noise = random.function_on(g);
        let value = |at: usize| {
            let index = g.index(at);
            let inside = (0..3).all(|a| ranges[a].contains(&index[a])) || whisker(index);
            if inside { noise.values()[at] + 1.0 } else { 0.0 }
        };
        Field::from_values(g, (0..g.samples()).map(value).collect(), 0.0).unwrap()
    };
    let class = |f: &Field<f32>| regularize(&superlevel(f, 0.0)).unwrap();
    let (left, right) = ([2..9, 3..9, 4..9], [5..13, 2..8, 4..10]);
    let f = [on(left.clone(), |_| false), on(left, |[_, j, k]| j == 12 && k == 2)];
    let e = [on(right.clone(), |[i, _, k]| i == 15 && k == 11), on(right, |_| false)];
    assert_eq!(class(&f[0]), class(&f[1]));
    assert_ne!(superlevel(&f[0], 0.0), superlevel(&f[1], 0.0));
    assert_ne!(class(&f[0]), class(&e[0]));
    let [union, common] = [sum, product].map(|join| class(&join(&f[0], &e[0]).unwrap()));
    assert_eq!([class(&f[0]), common.clone()].map(|s| s.is_empty()), [false, false]);
    for f in &f {
        for e in &e {
            assert_eq!(class(&sum(f, e).unwrap()), union, "regularized union");
            assert_eq!(class(&product(f, e).unwrap()), common, "regularized intersection");
        }
    }
    // Blocks that share one layer of samples meet in a sheet: their regularized intersection is empty (2.3.44).
    let sheet = product(&f[0], &on([8..13, 3..9, 4..9], |_| false)).unwrap();
    assert!(!superlevel(&sheet, 0.0).is_empty() && class(&sheet).is_empty());
}

/// A grid about a mesh and some room.
fn around(mesh: &TriangleMesh, h: f64) -> Grid {
    let (lo, hi) = mesh.bounds().unwrap();
    Grid::new(sub(lo, [h; 3]), Length::mm(h), [0, 1, 2].map(|a| ((hi[a] - lo[a]) / h) as usize + 3)).unwrap()
}

#[test]
fn equation_2_3_6_indicators_are_covariant_with_motions() {
    // Within one lattice: a reflection, and the window with it.
    let set = Random(14).set_on(grid([9, 8, 7]), 3);
    let moved = set.reflected();
    for at in 0..set.grid().samples() {
        let index = set.grid().index(at);
        let image = set.grid().position(index).map(|x| -x);
        let there = moved.grid().sample_at(image).expect("the image is on the grid");
        assert_eq!(set.contains(index), moved.contains(there));
    }
    // Screws: 1_{cS}(x) = 1_S(c⁻¹x), the mesh moved and cast beside the box asked at the moved place (also 2.3.17).
    let (lo, hi) = ([-1.0, 0.5, 2.0], [5.0, 3.0, 3.25]);
    let mut random = Random(18);
    for _ in 0..40 {
        let (turn, shift) = (random.rotation(), random.point(9.0));
        let moved = cuboid(lo, hi).transformed(turn, shift);
        let set = occupancy(&moved, &around(&moved, 0.3)).unwrap();
        let mut asked = 0;
        for at in 0..set.grid().samples() {
            let index = set.grid().index(at);
            let from = sub(set.grid().position(index), shift);
            let back = [0, 1, 2].map(|a| (0..3).map(|r| turn[r][a] * from[r]).sum::<f64>());
            let room = (0..3).map(|a| (back[a] - lo[a]).min(hi[a] - back[a])).fold(f64::INFINITY, f64::min);
            // The product of rotations rounds by 1e-14.
            if room.abs() > 1e-9 {
                assert_eq!(set.contains(index), room > 0.0, "{back:?}");
                asked += 1;
            }
        }
        assert!(asked > 1000, "{asked}");
    }
}

#[test]
fn definition_2_3_5_collisions_are_overlaps_with_a_volume_whatever_the_motion() {
    // h = 0.25 mm: what shares a cube of 1 mm shares a ball of radius √3/2·h, and that holds a sample.
    let part = cuboid([0.0; 3], [4.0, 3.0, 2.0]);
    let others = [
        ("overlap of 1 mm", cuboid([3.0, 2.0, 1.0], [6.0, 6.0, 6.0]), true),
        ("one inside the other", cuboid([1.0, 1.0, 0.5], [3.0, 2.0, 1.5]), true),
        ("a shared face", cuboid([4.0, 0.0, 0.0], [6.0, 3.0, 2.0]), false),
        ("a shared edge", cuboid([4.0, 3.0, 0.0], [6.0, 6.0, 2.0]), false),
        ("apart by 0.2 mm", cuboid([0.0, 0.0, 2.2], [4.0, 3.0, 5.0]), false),
        ("far apart", cuboid([9.0, 9.0, 9.0], [10.0, 10.0, 10.0]), false),
    ];
    let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut random = Random(19);
    let mut motions = vec![(still, [0.0; 3])];
    motions.extend((0..12).map(|_| (random.rotation(), random.point(20.0))));
    for (what, other, collides) in &others {
        for &(turn, shift) in &motions {
            let [a, b] = [&part, other].map(|mesh| mesh.transformed(turn, shift));
            let g = around(&a.clone().joined(&b), 0.25);
            let [a, b] = [a, b].map(|mesh| occupancy(&mesh, &g).unwrap());
            let volume = overlap_volume(&a, &b).unwrap();
            assert_eq!(volume > Volume::mm3(0.0), *collides, "{what}: {volume:?} after {turn:?} {shift:?}");
            // (2.3.47): any functions of the two sets say the same by the sign of their inner product.
            let [f, e] = [&a, &b].map(|s| product(&indicator_function(s), &Field::constant(g, 0.375)).unwrap());
            assert_eq!(inner_product(&f, &e).unwrap() > 0.0, *collides, "{what}");
        }
    }
}

#[test]
fn lemma_2_3_6_the_inner_product_is_the_volume_of_the_intersection_and_touching_is_none() {
    let mut random = Random(15);
    let (a, b) = (random.set_on(grid([9, 8, 7]), 3), random.set_on(grid([9, 8, 7]), 2));
    let inner = inner_product(&indicator_function(&a), &indicator_function(&b)).unwrap();
    assert_eq!(inner, overlap_volume(&a, &b).unwrap().as_mm3());
    let half = |low: bool| Indicator::from_predicate(grid([8, 8, 8]), |at| (at % 8 < 4) == low);
    assert_eq!(overlap_volume(&half(true), &half(false)).unwrap().as_mm3(), 0.0);
}

#[test]
fn equation_2_3_53_the_obstacle_is_a_convolution_with_the_reflection() {
    let mut random = Random(16);
    for _ in 0..10 {
        let (a, b) = (random.set_on(grid([8, 7, 6]), 4), random.element());
        let overlap = Convolver::new(&a, b.set().grid().dims()).unwrap().correlate(b.set()).unwrap();
        let obstacle = dilate(&a, &b.reflected()).unwrap().set;
        assert_eq!(overlap.at_least(1).words(), obstacle.words());
        // The measure itself is the volume of the overlap at each translation.
        let plain = convolve_directly(&a, b.reflected().set()).unwrap();
        assert_eq!(overlap.field.values(), plain.values());
    }
    // Translating both shapes moves no overlap: covariance of the collision predicate (2.3.46).
    let f = random.function_on(grid([5, 4, 3]));
    let g = random.function_on(grid([3, 3, 2]));
    let moved = |f: &Field<f32>| {
        let g = f.grid();
        let origin = g.origin().map(|x| x + 7.5);
        Field::from_values(Grid::new(origin, g.spacing(), g.dims()).unwrap(), f.values().to_vec(), 0.0).unwrap()
    };
    assert_eq!(correlate_fields(&f, &g).unwrap().field, correlate_fields(&moved(&f), &moved(&g)).unwrap().field);
}

#[test]
fn lemma_2_3_9_a_radial_delta_measures_the_fraction_of_the_neighbourhood() {
    // A cube of 16 mm; its faces lie midway between samples.
    let g = Grid::new([-9.75; 3], Length::mm(H), [40; 3]).unwrap();
    let cube = Indicator::from_predicate(g, |at| g.position(g.index(at)).iter().all(|x| x.abs() < 8.0));
    let cases = [([0.0; 3], 1.0), ([8.0, 0.0, 0.0], 0.5), ([8.0, -8.0, 1.0], 0.25), ([8.0, 8.0, -8.0], 0.125)];
    for (place, fraction) in cases {
        let found = volume_fraction(&cube, place, Length::mm(0.5)).unwrap();
        // The corner keeps 3.5σ of room to the border of the grid: 1e-3 of the kernel may be cut off.
        assert!((found - fraction).abs() < 2e-3, "{place:?}: {found}");
    }
}

#[test]
fn sheets_and_wires_have_no_volume_and_a_measure_once_delta_is_used() {
    // A block, and the same block with a sheet of no thickness on one face and a wire off another.
    let block = cuboid([-3.0, -2.0, -2.0], [0.0, 2.0, 2.0]);
    let fin = [[0.0, -1.0, 0.0], [5.0, -1.0, 0.0], [0.0, 1.4, 1.8]];
    let sheeted = block.clone().joined(&TriangleMesh::weld([fin, [fin[0], fin[2], fin[1]]]));
    let g = Grid::new([-6.0; 3], Length::mm(H), [44; 3]).unwrap();
    let [plain, thin] = [&block, &sheeted].map(|mesh| occupancy(mesh, &g).unwrap());
    // Without δ nothing tells them apart: not the volume, not the overlap with any set, nor do the samples.
    assert_eq!(plain, thin);
    assert!((sheeted.signed_volume() - block.signed_volume()).abs() < 1e-12);

    // With δ: each as its volume and its singular part, spread by a Gaussian and added as functions.
    let step = Length::mm(0.1);
    let sheet = Singular::on_surface(&[fin], 1.0, step).unwrap();
    let wire = Singular::on_polyline(&[[-3.0, 0.0, 0.0], [-3.0, 0.0, -2.0], [-3.0, 3.0, -2.0]], 1.0, step).unwrap();
    let volume = indicator_function(&plain);
    let all = Field::constant(g, 1.0f32);
    let probe = indicator_function(&Random(23).set_on(g, 3));
    // The sheet's sides are 5 mm and 3 mm at a right angle; the wire is 2 mm and 3 mm long.
    for (singular, measure) in [(sheet, 7.5), (wire, 5.0)] {
        assert!((singular.measure() - measure).abs() < 1e-9, "{}", singular.measure());
        let spread = singular.dissipated(&g, Nascent::Gaussian { width: Length::mm(H) }).unwrap();
        let with = sum(&volume, &spread).unwrap();
        let more = inner_product(&with, &all).unwrap() - inner_product(&volume, &all).unwrap();
        // Six deviations leave 6e-9 outside; a sum of f32 rounds by 6e-8 of values near one.
        assert!((more / measure - 1.0).abs() < 1e-5, "{more} {measure}");
        // A set that the thin thing passes through sees it too.
        assert!(inner_product(&with, &probe).unwrap() > inner_product(&volume, &probe).unwrap() + 0.1 * measure);
    }
}

#[test]
fn a_sweep_is_one_convolution_of_a_path_of_deltas_with_the_shape() {
    let mut random = Random(31);
    for _ in 0..8 {
        let (shape, path) = (random.set_on(grid([7, 6, 5]), 3), random.element());
        // On the lattice: Σ w·δ_p with any positive weights; its superlevel set is the sweep, its integral Σ w·vol.
        let weights = random.function_on(*path.set().grid());
        let weights = sum(&weights, &Field::constant(*path.set().grid(), 0.5)).unwrap();
        let deltas = product(&weights, &indicator_function(path.set())).unwrap();
        let covered = convolve_fields(&indicator_function(&shape), &deltas).unwrap();
        // Below the least weight and above the rounding lies nothing.
        assert!(covered.bound < 0.25);
        let swept = sweep_set(&shape, &path).unwrap().set;
        assert_eq!(superlevel(&covered.field, 0.25).words(), swept.words());
        let total: f64 = deltas.values().iter().map(|&v| f64::from(v)).sum();
        let integral: f64 = covered.field.values().iter().map(|&v| f64::from(v)).sum();
        let said = total * shape.count() as f64;
        assert!((integral - said).abs() <= covered.bound * covered.field.values().len() as f64, "{integral} {said}");
    }
}

#[test]
fn a_curve_of_deltas_spread_by_a_kernel_sweeps_with_its_length_as_measure() {
    // A path off the lattice; the kernel is a product over the axes, so its support is a box of its reach.
    let path = [[-1.1, -0.7, 0.2], [2.3, 0.4, 1.0], [1.2, 2.9, 1.7]];
    let length: f64 = path.windows(2).map(|w| norm(sub(w[1], w[0]))).sum();
    let kernel = Nascent::Triangle { width: Length::mm(2.0 * H) };
    let curve = Singular::on_polyline(&path, 1.0, Length::mm(0.01)).unwrap();
    let (lo, hi) = ([-0.75, -0.5, -0.25], [1.25, 0.75, 0.5]);
    let shape = occupancy(&cuboid(lo, hi), &around(&cuboid(lo, hi), H)).unwrap();
    let covered = dwell(&shape, &curve, kernel).unwrap();
    let said = length * shape.volume().as_mm3();
    // Triangles of a whole number of spacings sum to one on any lattice; the rest is rounding in f32.
    assert!((covered.integral() / said - 1.0).abs() < 1e-5, "{} {said}", covered.integral());

    // The kernel is positive within its reach along every axis: measure just there, and none beyond.
    let samples: Vec<Vec3> = shape.iter().map(|at| shape.grid().position(shape.grid().index(at))).collect();
    let along_axis = |x: f64, axis: usize| samples.iter().map(|s| (x - s[axis]).abs()).fold(f64::INFINITY, f64::min);
    let stops: Vec<Vec3> = path
        .windows(2)
        .flat_map(|w| (0..400).map(move |n| [0, 1, 2].map(|a| w[0][a] + (w[1][a] - w[0][a]) * f64::from(n) / 399.0)))
        .collect();
    let mut seen = [0, 0];
    for at in (0..covered.field.grid().samples()).step_by(3) {
        let x = covered.field.grid().position(covered.field.grid().index(at));
        let value = f64::from(covered.field.values()[at]);
        // The samples of a box are a product: the nearest along each axis is the nearest in the greatest coordinate.
        let to_copy = |p: &Vec3| (0..3).map(|a| along_axis(x[a] - p[a], a)).fold(0.0, f64::max);
        let off = stops.iter().map(to_copy).fold(f64::INFINITY, f64::min);
        // Stops are less than 0.01 mm apart; a share of the reach keeps the kernel above the rounding.
        if off > kernel.reach() + 0.01 {
            assert!(value.abs() <= covered.bound, "{x:?}: {value} at {off}");
            seen[0] += 1;
        } else if off < 0.5 * kernel.reach() {
            assert!(value > covered.bound, "{x:?}: {value} at {off}");
            seen[1] += 1;
        }
    }
    assert!(seen.iter().all(|&n| n > 50), "{seen:?}");
}
