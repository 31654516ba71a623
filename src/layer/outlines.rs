//! The outlines of sections: which of the edges that cross a height lie on one.

use super::pieces::Rising;
use crate::geometry::DisjointSets;
use std::collections::BTreeMap;

/// Edges that all cross the same heights, by what joins them: two along one facet lie on one outline at each of these heights.
///
/// Where they are all edges that cross a height these are its outlines; where some are left out an outline may come as several groups.
///
/// # Cost
/// O(n log n).
pub(super) fn outlines<'a>(edges: &[&'a Rising]) -> Vec<Vec<&'a Rising>> {
    let mut along: Vec<(u32, u32)> =
        edges.iter().enumerate().flat_map(|(i, e)| e.facets.map(|f| (f, i as u32))).collect();
    along.sort_unstable();
    let mut sets = DisjointSets::new(edges.len());
    for pair in along.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        sets.join(pair[0].1, pair[1].1);
    }
    let mut found: BTreeMap<u32, Vec<&Rising>> = BTreeMap::new();
    for (i, &e) in edges.iter().enumerate() {
        found.entry(sets.root(i as u32)).or_default().push(e);
    }
    found.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::super::pieces::pieces;
    use super::*;
    use crate::geometry::union::united;
    use crate::geometry::{Hull, MeshDistance, cuboid};

    #[test]
    fn two_legs_are_two_outlines_and_the_beam_on_them_is_one() {
        let boxes = [cuboid([0.0; 3], [2.0, 2.0, 9.0]), cuboid([8.0, 0.0, 0.0], [11.0, 2.0, 9.0])];
        let beam = cuboid([0.0, 0.0, 9.0], [11.0, 2.0, 12.0]);
        let whole = united(&boxes.iter().fold(beam, |all, b| all.joined(b)), 1e-6).unwrap();
        let [piece] = &pieces(&whole, |_| true, &MeshDistance::new(&whole))[..] else { panic!() };
        let lengths = |z: f64| {
            let crossing: Vec<&Rising> = piece.edges.iter().filter(|e| e.heights[0] <= z && e.heights[1] > z).collect();
            let long = |o: &Vec<&Rising>| Hull::of(o.iter().map(|e| e.at(z))).area().round();
            let mut all: Vec<f64> = outlines(&crossing).iter().map(long).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        assert_eq!((lengths(5.0), lengths(10.0)), (vec![4.0, 6.0], vec![22.0]));
    }
}
