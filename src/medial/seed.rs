//! Places of the surface from which rods are looked for.

use super::rod::Search;
use crate::geometry::vector::{Vec3, along, distance, norm2, sub, unit};
use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// Places that look the same way are one within a cell of this share of the width searched for.
const CELL: f64 = 0.125;
/// Sides that draw together by 30 degrees are as far apart again as the width searched for so soon after the limit, four fifths of it: a facet
/// whose middle is further from a corner, in shares of that width, may be a narrow rod's there and a wider one's at its middle.
const FAR: f64 = 0.37;
/// How far from such a corner it is looked across.
const BESIDE: f64 = 0.2;

/// A place, and the facet that it lies on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seed {
    pub facet: u32,
    pub at: Vec3,
}

impl Search<'_> {
    /// The greatest distance between a place that is left out and one like it that is not.
    pub(super) fn spacing(&self) -> f64 {
        CELL * self.wanted.within * 3f64.sqrt()
    }

    /// The middles of facets, in their order, then places beside the corners of long ones: what tapers is narrowest at corners.
    ///
    /// # Cost
    /// O(facets). Where none is longer than about half the width searched for, middles alone.
    pub(super) fn seeds(&self, counts: impl Fn(usize) -> bool + Sync) -> Vec<Seed> {
        let cell = CELL * self.wanted.within;
        let places = |f: usize| {
            let counts = counts(f) && norm2(self.mesh.area_vector(f)) > 0.0;
            counts.then(|| (self.mesh.centroid(f), self.mesh.normal(f)))
        };
        let middles: Vec<Option<(Vec3, Vec3)>> = (0..self.mesh.triangles.len()).into_par_iter().map(places).collect();
        let (far, beside) = (FAR * self.wanted.within, BESIDE * self.wanted.within);
        let corner = |f: usize, middle: Vec3, p: Vec3| {
            let at = along(p, unit(sub(middle, p)), beside);
            (distance(p, middle) > far).then_some(Seed { facet: f as u32, at })
        };
        let ends = middles.iter().enumerate().filter_map(|(f, m)| Some((f, (*m)?.0)));
        let ends =
            ends.flat_map(|(f, middle)| self.mesh.corners(f).map(|p| corner(f, middle, p)).into_iter().flatten());
        let first = middles.iter().enumerate().filter_map(|(f, m)| Some(Seed { facet: f as u32, at: (*m)?.0 }));
        let mut seen: FxHashSet<([i64; 3], [i8; 3])> = FxHashSet::default();
        let key = |s: &Seed| {
            let looks = middles.get(s.facet as usize).copied().flatten().map_or([0.0; 3], |m| m.1);
            (s.at.map(|x| (x / cell).floor() as i64), looks.map(|x| (2.0 * x).round() as i8))
        };
        first.chain(ends).filter(|s| seen.insert(key(s))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::feature::Side;
    use super::super::rod::{Rod, Search, Wanted};
    use crate::geometry::{Adjacency, MeshDistance, TriangleMesh, revolved};

    fn narrowest(mesh: &TriangleMesh, side: Side, within: f64) -> f64 {
        let (distance, next) = (MeshDistance::new(mesh), Adjacency::of(mesh, |_| true));
        let wanted = Wanted { side, within, elongation: 1.5 };
        let rods = Search { mesh, distance: &distance, next: &next, wanted }.run(|_| true).rods;
        rods.iter().map(Rod::diameter).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn what_tapers_is_as_narrow_as_at_its_end_however_long_its_facets_are() {
        for sides in [12, 24, 96] {
            let turn = std::f64::consts::TAU / sides as f64;
            let round = |radius: f64| 2.0 * radius * (turn.sin() / turn).sqrt();
            // In a plate, from 3 mm to 0.3 mm over 20 mm and from 2.4 mm to 0.6 mm over 5 mm; the pins alike on one.
            for (wide, narrow, long, within) in [(1.5, 0.15, 20.0, 0.625), (1.2, 0.3, 5.0, 0.875)] {
                let nozzle = [[wide, 0.0], [4.0, 0.0], [4.0, long], [narrow, long]];
                let nozzle = revolved(&nozzle, sides);
                let found = narrowest(&nozzle, Side::Void, within);
                assert!((found - round(narrow)).abs() < 0.01, "{sides} {narrow}: {found}");
                let pin =
                    revolved(&[[0.0, -2.0], [5.0, -2.0], [5.0, 0.0], [wide, 0.0], [narrow, long], [0.0, long]], sides);
                let found = narrowest(&pin, Side::Material, within);
                assert!((found - round(narrow)).abs() < 0.01, "{sides} {narrow}: {found}");
            }
            let neck = revolved(&[[0.0, 0.0], [1.5, 0.0], [0.35, 6.5], [1.5, 13.0], [0.0, 13.0]], sides);
            let found = narrowest(&neck, Side::Material, 1.25);
            assert!((found - round(0.35)).abs() < 1e-3, "{sides}: {found}");
        }
    }
}
