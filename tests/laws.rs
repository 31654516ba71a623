//! The laws of chapter 2 of the thesis that the library rests on, and those of morphology, on random lopsided data.
//!
//! Numbers are those of the thesis (definitions, propositions, lemmas, theorems and equations of §2.2 and §2.3). Exact
//! statements are tested exactly; statements about integrals within the rounding said beside them.

use amcheck::convolution::{
    Convolver, RowContent, Spectrum, Transform, convolve_directly, convolve_fields, correlate_fields,
};
use amcheck::field::*;
use amcheck::grid::Grid;
use amcheck::morphology::*;
use amcheck::units::{Length, Volume};

const H: f64 = 0.5;

struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % n
    }

    fn set_on(&mut self, grid: Grid, thin: usize) -> Indicator {
        let bits: Vec<bool> = (0..grid.samples()).map(|_| self.below(thin) == 0).collect();
        Indicator::from_predicate(grid, |at| bits[at])
    }

    fn function_on(&mut self, grid: Grid) -> Field<f32> {
        let values = (0..grid.samples()).map(|_| self.below(4096) as f32 / 4096.0).collect();
        Field::from_values(grid, values, 0.0).unwrap()
    }

    fn element(&mut self) -> StructuringElement {
        loop {
            let dims = [0, 1, 2].map(|_| 2 + self.below(3));
            let origin = [0, 1, 2].map(|_| H * self.below(4) as f64 - 1.0);
            let set = self.set_on(Grid::new(origin, Length::mm(H), dims).unwrap(), 2);
            if let Ok(element) = StructuringElement::new(set)
                && !element.is_symmetric()
            {
                return element;
            }
        }
    }
}

fn grid(dims: [usize; 3]) -> Grid {
    Grid::new([-1.0, 0.5, 2.0], Length::mm(H), dims).unwrap()
}

fn spectrum(f: &Field<f32>) -> (Transform<f64>, Spectrum<f64>) {
    let dims = f.grid().dims();
    let plan = Transform::<f64>::new(dims);
    let spectrum = plan.forward(|j, k, row| {
        let from = &f.values()[(k * dims[1] + j) * dims[0]..][..dims[0]];
        row.iter_mut().zip(from).for_each(|(r, &v)| *r = f64::from(v));
        RowContent::Filled
    });
    (plan, spectrum.unwrap())
}

/// Every frequency of a half spectrum, in order.
fn frequencies(dims: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..dims[2]).flat_map(move |r| (0..dims[1]).flat_map(move |q| (0..dims[0] / 2 + 1).map(move |p| [p, q, r])))
}

/// f with its samples moved cyclically: `g(i) = f(from(i))`.
fn rearranged(f: &Field<f32>, from: impl Fn([usize; 3]) -> [usize; 3]) -> Field<f32> {
    let g = f.grid();
    let values = (0..g.samples()).map(|at| f.values()[g.offset(from(g.index(at)))]).collect();
    Field::from_values(*g, values, 0.0).unwrap()
}

const CYCLIC: [usize; 3] = [6, 6, 6];

mod section_2_2 {
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
}

mod section_2_3 {
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
    fn equation_2_3_6_indicators_are_covariant_with_motions() {
        // The set moved is the function composed with the inverse motion: here a reflection and a shift of the window.
        let set = Random(14).set_on(grid([9, 8, 7]), 3);
        let moved = set.reflected();
        for at in 0..set.grid().samples() {
            let index = set.grid().index(at);
            let image = set.grid().position(index).map(|x| -x);
            let there = moved.grid().sample_at(image).expect("the image is on the grid");
            assert_eq!(set.contains(index), moved.contains(there));
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
        let g = Grid::new([-4.0; 3], Length::mm(H), [40; 3]).unwrap();
        let wire = Singular::on_polyline(&[[0.0; 3], [6.0, 3.0, 6.0]], 1.0, Length::mm(0.1)).unwrap();
        let sheet =
            Singular::on_surface(&[[[0.0; 3], [5.0, 0.0, 0.0], [0.0, 4.0, 3.0]]], 1.0, Length::mm(0.1)).unwrap();
        for (singular, measure) in [(wire, 9.0), (sheet, 12.5)] {
            // As points of the grid it is nothing that regularization would keep …
            assert!((singular.measure() - measure).abs() < 1e-9);
            let thin = singular.dissipated(&g, Nascent::Gaussian { width: Length::mm(H) }).unwrap();
            // … and as a density its integral is its length or its area.
            let all = Field::constant(g, 1.0f32);
            let integral = inner_product(&thin, &all).unwrap();
            assert!((integral / measure - 1.0).abs() < 1e-5, "{integral} {measure}");
        }
    }
}

mod morphology_laws {
    use super::*;

    fn cases() -> Vec<(Indicator, StructuringElement)> {
        let mut random = Random(21);
        let mut full = |thin| random.set_on(grid([15, 12, 10]), thin);
        let sets = [full(3), full(9).complement(), full(40).complement(), full(30)];
        let mut random = Random(22);
        sets.into_iter().flat_map(|a| (0..4).map(move |_| a.clone())).map(|a| (a, random.element())).collect()
    }

    /// Both sets on one grid that holds both.
    fn aligned(a: &Indicator, b: &Indicator) -> [Indicator; 2] {
        let first = [0, 1, 2].map(|i| ((a.grid().origin()[i] - b.grid().origin()[i]) / H).round() as isize);
        let reach = [0, 1, 2].map(|i| first[i].unsigned_abs());
        let dims = [0, 1, 2].map(|i| a.grid().dims()[i].max(b.grid().dims()[i]) + 2 * reach[i]);
        let wide = a.window(reach.map(|n| -(n as isize)), dims).unwrap();
        let from = [0, 1, 2].map(|i| first[i] - reach[i] as isize);
        [wide.clone(), b.placed(from, *wide.grid()).unwrap()]
    }

    fn same(a: &Indicator, b: &Indicator) -> bool {
        let [a, b] = aligned(a, b);
        a == b
    }

    fn within(a: &Indicator, b: &Indicator) -> bool {
        let [a, b] = aligned(a, b);
        a.is_subset(&b).unwrap()
    }

    #[test]
    fn erosion_and_dilation_are_dual() {
        for (a, b) in cases() {
            // ¬(A ⊖ B) = ¬A ⊕ B̌ on translations that keep B within the grid.
            let eroded = erode(&a, &b).unwrap().set;
            let dual = dilate(&a.complement(), &b.reflected()).unwrap().set;
            let size = b.set().grid().dims();
            let first = size.map(|n| n as isize - 1);
            let dims = [0, 1, 2].map(|i| a.grid().dims()[i] + 1 - size[i]);
            let [inner, outer] = [&eroded, &dual].map(|s| s.window(first, dims).unwrap());
            assert_eq!(inner.complement().words(), outer.words());
        }
    }

    #[test]
    fn opening_and_closing_are_idempotent_increasing_and_bounded() {
        for (a, b) in cases() {
            let (open, closed) = (opening(&a, &b).unwrap().set, closing(&a, &b).unwrap().set);
            assert_eq!(opening(&open, &b).unwrap().set, open);
            assert_eq!(closing(&closed, &b).unwrap().set, closed);
            assert!(open.is_subset(&a).unwrap() && a.is_subset(&closed).unwrap());
            let larger = a.union(&Random(5).set_on(*a.grid(), 5)).unwrap();
            assert!(open.is_subset(&opening(&larger, &b).unwrap().set).unwrap());
            assert!(closed.is_subset(&closing(&larger, &b).unwrap().set).unwrap());
        }
    }

    #[test]
    fn dilation_is_associative_and_commutes_with_union_erosion_with_intersection() {
        let mut random = Random(23);
        for (a, b) in cases() {
            let c = random.element();
            let bc = StructuringElement::new(dilate(b.set(), &c).unwrap().set).unwrap();
            let step = dilate(&dilate(&a, &b).unwrap().set, &c).unwrap().set;
            assert!(same(&step, &dilate(&a, &bc).unwrap().set), "(A ⊕ B) ⊕ C = A ⊕ (B ⊕ C)");
            let step = erode(&erode(&a, &b).unwrap().set, &c).unwrap().set;
            assert!(same(&step, &erode(&a, &bc).unwrap().set), "(A ⊖ B) ⊖ C = A ⊖ (B ⊕ C)");
            let other = random.set_on(*a.grid(), 3);
            let [da, db] = [&a, &other].map(|s| dilate(s, &b).unwrap().set);
            assert_eq!(dilate(&a.union(&other).unwrap(), &b).unwrap().set, da.union(&db).unwrap());
            let [ea, eb] = [&a, &other].map(|s| erode(s, &b).unwrap().set);
            assert_eq!(erode(&a.intersection(&other).unwrap(), &b).unwrap().set, ea.intersection(&eb).unwrap());
        }
    }

    #[test]
    fn everything_commutes_with_translation() {
        for (a, b) in cases() {
            // The set moved in space by whole samples, and elsewhere in a larger grid.
            let moved = |set: &Indicator, by: [isize; 3]| {
                let g = set.grid();
                let origin = [0, 1, 2].map(|i| g.origin()[i] + H * by[i] as f64);
                let there = Grid::new(origin, g.spacing(), g.dims()).unwrap();
                Indicator::from_words(there, set.words().to_vec()).unwrap()
            };
            let by = [3, -2, 5];
            let elsewhere = moved(&a, by).window([-4, -1, -2], a.grid().dims().map(|n| n + 7)).unwrap();
            for operator in [dilate, erode, opening, closing] {
                let [before, after] = [&a, &elsewhere].map(|set| operator(set, &b).unwrap().set);
                assert!(same(&moved(&before, by), &after));
            }
        }
    }

    #[test]
    fn dilation_and_erosion_are_adjoint_and_the_element_is_their_unit() {
        let dot = StructuringElement::new(Indicator::from_predicate(
            Grid::new([0.0; 3], Length::mm(H), [1; 3]).unwrap(),
            |_| true,
        ))
        .unwrap();
        for (a, b) in cases() {
            // B fits into A ⊕ B at every point of A; what fits in A stays in A when it is dilated.
            assert!(within(&a, &erode(&dilate(&a, &b).unwrap().set, &b).unwrap().set));
            assert!(within(&dilate(&erode(&a, &b).unwrap().set, &b).unwrap().set, &a));
            assert_eq!(dilate(&a, &dot).unwrap().set, a);
            assert_eq!(erode(&a, &dot).unwrap().set, a);
            // Sums commute.
            let swapped = dilate(b.set(), &StructuringElement::new(a.clone()).unwrap()).unwrap().set;
            assert!(same(&dilate(&a, &b).unwrap().set, &swapped));
        }
    }

    #[test]
    fn de_morgan() {
        let mut random = Random(24);
        let (a, b) = (random.set_on(grid([15, 12, 10]), 3), random.set_on(grid([15, 12, 10]), 2));
        assert_eq!(a.union(&b).unwrap().complement(), a.complement().intersection(&b.complement()).unwrap());
        assert_eq!(a.intersection(&b).unwrap().complement(), a.complement().union(&b.complement()).unwrap());
    }

    #[test]
    fn an_unswept_envelope_swept_again_is_its_opening() {
        for (envelope, path) in cases() {
            let most = unsweep(&envelope, &path).unwrap().set;
            let swept = sweep_set(&most, &path).unwrap().set;
            assert!(same(&swept, &opening(&envelope, &path).unwrap().set));
        }
    }
}
