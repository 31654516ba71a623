//! §2.2: inner products, Fourier transforms and equality almost everywhere.

use super::*;

#[test]
fn definition_2_2_7_the_inner_product_is_symmetric_bilinear_and_bounded_by_norms() {
    let mut random = Random(1);
    let [f, g, e] = [0; 3].map(|_| random.function_on(grid([7, 5, 6])));
    let dot = |a: &Field<f32>, b: &Field<f32>| inner_product(a, b).unwrap();
    assert_eq!(dot(&f, &g), dot(&g, &f));
    // Sums of two 12-bit fractions are exact in f32.
    assert!((dot(&sum(&f, &g).unwrap(), &e) - dot(&f, &e) - dot(&g, &e)).abs() < 1e-9);
    assert!((lp_norm(&f, 2.0).unwrap().powi(2) - dot(&f, &f)).abs() < 1e-9);
    assert!(dot(&f, &g) <= lp_norm(&f, 2.0).unwrap() * lp_norm(&g, 2.0).unwrap() + 1e-9, "Cauchy and Schwarz");
    assert!(lp_norm(&sum(&f, &g).unwrap(), 3.0).unwrap() <= lp_norm(&f, 3.0).unwrap() + lp_norm(&g, 3.0).unwrap());
}

#[test]
fn definition_2_2_8_convolution_is_an_ensemble_of_inner_products_and_commutes() {
    let mut random = Random(2);
    let (f, g) = (random.function_on(grid([6, 4, 5])), random.function_on(grid([3, 5, 2])));
    let (fg, gf) = (convolve_fields(&f, &g).unwrap(), convolve_fields(&g, &f).unwrap());
    for at in 0..fg.field.grid().samples() {
        let [i, j, k] = fg.field.grid().index(at).map(|n| n as isize);
        let plain: f64 = (0..g.grid().samples())
            .map(|b| {
                let [p, q, r] = g.grid().index(b).map(|n| n as isize);
                f64::from(f.at([i - p, j - q, k - r])) * f64::from(g.values()[b])
            })
            .sum();
        assert!((plain - f64::from(fg.field.values()[at])).abs() <= fg.bound);
        assert!((fg.field.values()[at] - gf.field.values()[at]).abs() <= 2.0 * fg.bound as f32);
    }
}

#[test]
fn definition_2_2_9_the_transform_is_invertible() {
    let f = Random(3).function_on(grid(CYCLIC));
    let (plan, spectrum) = spectrum(&f);
    let mut back = vec![0.0; f.grid().samples()];
    let window = amcheck::convolution::Window { start: [0; 3], dims: CYCLIC };
    plan.inverse(spectrum, window, &mut back, CYCLIC[0], |row, out| out.copy_from_slice(row)).unwrap();
    assert!(back.iter().zip(f.values()).all(|(a, &b)| (a - f64::from(b)).abs() < 1e-14));
}

#[test]
fn theorem_2_2_10_parseval() {
    let mut random = Random(4);
    let (f, g) = (random.function_on(grid(CYCLIC)), random.function_on(grid(CYCLIC)));
    // ⟨f, g⟩ by polarization of the energies of f + g and f − g.
    let difference =
        Field::from_values(*f.grid(), f.values().iter().zip(g.values()).map(|(a, b)| a - b).collect(), 0.0);
    let energy = |f: &Field<f32>| spectrum(f).1.energy();
    let transformed = 0.25 * (energy(&sum(&f, &g).unwrap()) - energy(&difference.unwrap()));
    let direct = inner_product(&f, &g).unwrap() / f.grid().sample_volume().as_mm3();
    assert!((transformed - direct).abs() < 1e-10, "{transformed} {direct}");
}

#[test]
fn theorem_2_2_11_a_convolution_becomes_a_product() {
    let mut random = Random(5);
    let (f, g) = (random.function_on(grid(CYCLIC)), random.function_on(grid(CYCLIC)));
    let n = CYCLIC[0];
    let mut cyclic = Field::constant(grid(CYCLIC), 0.0f32);
    for a in 0..f.grid().samples() {
        for b in 0..g.grid().samples() {
            let (p, q) = (f.grid().index(a), g.grid().index(b));
            let to = cyclic.grid().offset([0, 1, 2].map(|i| (p[i] + q[i]) % n));
            cyclic.values_mut()[to] += f.values()[a] * g.values()[b];
        }
    }
    let [(_, f), (_, g), (_, fg)] = [&f, &g, &cyclic].map(spectrum);
    for at in frequencies(CYCLIC) {
        // 216 f32 additions of numbers near 60: 1e-3 is rounding.
        assert!((f.at(at) * g.at(at) - fg.at(at)).norm() < 1e-2, "{at:?}");
    }
}

#[test]
fn equation_2_2_16_a_translation_becomes_a_phase() {
    let f = Random(6).function_on(grid(CYCLIC));
    let shift = [1, 2, 5];
    let moved = rearranged(&f, |i| [0, 1, 2].map(|a| (i[a] + 6 - shift[a]) % 6));
    let [(_, f), (_, moved)] = [&f, &moved].map(spectrum);
    for at in frequencies(CYCLIC) {
        let turn: f64 = (0..3).map(|a| (at[a] * shift[a]) as f64 / 6.0).sum();
        let (s, c) = (-std::f64::consts::TAU * turn).sin_cos();
        let (before, after) = (f.at(at), moved.at(at));
        assert!((after.re - before.re * c + before.im * s).abs() < 1e-11, "{at:?}");
        assert!((after.im - before.im * c - before.re * s).abs() < 1e-11, "{at:?}");
    }
}

#[test]
fn equation_2_2_18_a_rotation_commutes_with_the_transform() {
    // A quarter turn about z: (x, y) from (y, −x). On the half spectrum only frequencies with p, q < 4 are compared.
    let f = Random(7).function_on(grid(CYCLIC));
    let turned = rearranged(&f, |[i, j, k]| [j, (6 - i) % 6, k]);
    let [(_, f), (_, turned)] = [&f, &turned].map(spectrum);
    for [p, q, r] in frequencies(CYCLIC).filter(|w| w[1] < 4) {
        assert!((turned.at([p, q, r]) - f.at([q, (6 - p) % 6, r])).norm() < 1e-11);
    }
}

#[test]
fn equation_2_2_20_a_reflection_becomes_a_conjugation() {
    let f = Random(8).function_on(grid(CYCLIC));
    let reflected = rearranged(&f, |i| i.map(|n| (6 - n) % 6));
    let [(_, f), (_, reflected)] = [&f, &reflected].map(spectrum);
    for at in frequencies(CYCLIC) {
        assert!((reflected.at(at) - f.at(at).conj()).norm() < 1e-11);
        // Hermitian symmetry of a real function.
        if at[0] == 0 {
            assert!((f.at(at) - f.at(at.map(|n| (6 - n) % 6)).conj()).norm() < 1e-11);
        }
    }
}

#[test]
fn proposition_2_2_15_sets_that_differ_by_sheets_and_wires_have_one_regularization() {
    let g = grid([16, 14, 12]);
    let block = Indicator::from_predicate(g, |at| g.index(at).iter().all(|&i| (4..10).contains(&i)));
    let whiskers = Indicator::from_predicate(g, |at| {
        let [i, j, k] = g.index(at);
        block.contains([i, j, k]) || (j == 6 && k == 6) || (i == 12 && (2..11).contains(&j))
    });
    assert_ne!(block, whiskers);
    assert_eq!(regularize(&block).unwrap(), regularize(&whiskers).unwrap());
    // And sets that differ by a volume do not.
    let grown = dilate(&block, &StructuringElement::cuboid([2; 3], Length::mm(H)).unwrap()).unwrap().set;
    let grown = grown.placed([1; 3], g).unwrap();
    assert_ne!(regularize(&block).unwrap(), regularize(&grown).unwrap());
    assert!(!equal_up_to(&block, &grown, Volume::mm3(1.0)).unwrap());
}

/// A block of 6³ samples, and what hangs on it in sheets and wires one sample thick.
fn whiskered(g: Grid, whisker: impl Fn([usize; 3]) -> bool + Sync) -> Indicator {
    Indicator::from_predicate(g, |at| {
        let index = g.index(at);
        index.iter().all(|&i| (4..10).contains(&i)) || whisker(index)
    })
}

#[test]
fn definition_2_2_14_equal_almost_everywhere_is_equal_measure_in_every_set() {
    // A block of a mesh with a fin of no thickness: two facets back to back on one of its edges, and a wire of such.
    let block = cuboid([0.25, 0.25, 0.25], [4.0, 3.0, 2.0]);
    let fin = TriangleMesh::weld([
        [[4.0, 0.5, 0.5], [6.0, 0.5, 1.0], [4.0, 2.5, 1.5]],
        [[4.0, 0.5, 0.5], [4.0, 2.5, 1.5], [6.0, 0.5, 1.0]],
    ]);
    let finned = block.clone().joined(&fin);
    // Sums of a few terms near 20 round by 1e-14.
    assert!((finned.signed_volume() - block.signed_volume()).abs() < 1e-12);
    let g = Grid::new([-0.4; 3], Length::mm(0.3), [24, 14, 11]).unwrap();
    let [a, b] = [&block, &finned].map(|mesh| occupancy(mesh, &g).unwrap());
    let mut random = Random(9);
    for thin in 1..20 {
        let q = random.set_on(g, thin);
        assert_eq!(overlap_volume(&a, &q).unwrap(), overlap_volume(&b, &q).unwrap());
    }
    assert!(!a.is_empty() && equal_up_to(&a, &b, Volume::mm3(0.0)).unwrap());

    // Sets that differ by a volume: some set tells them apart, and the difference itself always does.
    let moved = occupancy(&block.transformed(Random(10).rotation(), [0.4, 0.0, 0.1]), &g).unwrap();
    let apart = a.difference(&moved).unwrap().union(&moved.difference(&a).unwrap()).unwrap();
    assert!(!equal_up_to(&a, &moved, Volume::mm3(0.0)).unwrap());
    assert!(equal_up_to(&a, &moved, apart.volume()).unwrap());
    let only_a = a.difference(&moved).unwrap();
    assert!(overlap_volume(&a, &only_a).unwrap() > overlap_volume(&moved, &only_a).unwrap());
}

#[test]
fn definition_2_2_16_each_class_of_sets_equal_almost_everywhere_has_one_regular_set() {
    let g = grid([16, 14, 12]);
    let shifted = |by: usize| Indicator::from_predicate(g, |at| g.index(at).iter().all(|&i| (4..10 + by).contains(&i)));
    let classes = [
        vec![
            whiskered(g, |_| false),
            whiskered(g, |[_, j, k]| j == 6 && k == 6),
            whiskered(g, |[i, j, _]| i == 12 && j < 9),
            whiskered(g, |[i, j, k]| [i, j, k] == [1, 1, 1] || (k == 2 && i < 4)),
        ],
        vec![shifted(1), shifted(1).union(&whiskered(g, |[i, _, k]| i == 12 && k == 3)).unwrap()],
        vec![Indicator::empty(g), Indicator::from_predicate(g, |at| g.index(at)[1] == 5)],
    ];
    for (m, class) in classes.iter().enumerate() {
        for set in class {
            let regular = regularize(set).unwrap();
            assert_eq!(regularize(&regular).unwrap(), regular, "a regular set is its own");
            for (n, other) in classes.iter().enumerate() {
                for set in other {
                    assert_eq!(regularize(set).unwrap() == regular, m == n, "classes {m} and {n}");
                }
            }
        }
    }
}
