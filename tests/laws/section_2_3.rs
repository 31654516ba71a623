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
    let sheet = Singular::on_surface(&[[[0.0; 3], [5.0, 0.0, 0.0], [0.0, 4.0, 3.0]]], 1.0, Length::mm(0.1)).unwrap();
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
