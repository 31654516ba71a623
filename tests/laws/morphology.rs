//! The laws of Minkowski sums and differences, openings and closings.

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
    let dot =
        StructuringElement::new(Indicator::from_predicate(Grid::new([0.0; 3], Length::mm(H), [1; 3]).unwrap(), |_| {
            true
        }))
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
        let most = unsweep_set(&envelope, &path).unwrap().set;
        let swept = sweep_set(&most, &path).unwrap().set;
        assert!(same(&swept, &opening(&envelope, &path).unwrap().set));
    }
}
