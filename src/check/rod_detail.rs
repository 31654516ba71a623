//! Rods among fine detail: places as long as the rods they lie in, and rods that no ball shows.

use super::detail::{Detail, Found, Patch, Thin};
use super::rods;
use crate::geometry::vector::{Vec3, add, along, cross, hull, scale, unit};
use crate::medial::rod::Rod;
use rustc_hash::FxHashMap;
use std::f64::consts::PI;

/// The direction of the build.
const UP: Vec3 = [0.0, 0.0, 1.0];

impl Found<'_> {
    /// The sheets made of those balls that are wanted, each as long as the rod that it lies in, and those in one rod together: the balls of a
    /// rod with few sides are stopped at its edges, and samples lie far apart on it. Largest first.
    pub fn places(&self, wanted: impl Fn(&Thin) -> bool) -> Vec<Detail> {
        let sheets = self.sheets(wanted);
        let Some(found) = rods::search(self.part, self.process, self.side) else { return sheets };
        let mut places = along_rods(sheets, &found.rods);
        places.sort_by(|a, b| b.volume.total_cmp(&a.volume));
        places
    }

    /// The rods that none of some places lies in and that are narrower than is asked across them: those of which no two sides face each other
    /// have no ball between opposing sides.
    ///
    /// An element that is w(n) wide along n covers, seen along the rod, an ellipse as wide as that both level and at right angles to it: no
    /// section with a lesser inscribed circle holds it, but for one whose circle is not about its centroid.
    pub fn rods_beside(&self, places: &[Detail], asked: impl Fn(Vec3) -> f64) -> Vec<Detail> {
        let Some(found) = rods::search(self.part, self.process, self.side) else { return Vec::new() };
        let is_new = |r: &&Rod| !places.iter().any(|p| r.holds(p.thinnest.centre) || p.holds_middle_of(r));
        let narrow = |r: &Rod| {
            let axis = r.narrowest.axis;
            let level = unit(cross(axis, if axis[2].abs() < 0.99 { UP } else { [1.0, 0.0, 0.0] }));
            let least = asked(level).min(asked(cross(axis, level)));
            (r.narrowest.inscribed < least - self.part.tie()).then(|| Detail::of_rod(r, level))
        };
        found.rods.iter().filter(is_new).filter_map(narrow).collect()
    }
}

/// Places, each as long as the rod that it lies in, and those in one rod together.
fn along_rods(places: Vec<Detail>, rods: &[Rod]) -> Vec<Detail> {
    let mut in_rod: FxHashMap<usize, usize> = FxHashMap::default();
    let mut out: Vec<Detail> = Vec::new();
    for place in places {
        let is_sheet = place.noun() == "sheet";
        let middle = |p: &Patch| scale(add(p.extent.0, p.extent.1), 0.5);
        let lies_in =
            |r: &Rod| r.holds(place.thinnest.centre) || !is_sheet && place.patches.iter().any(|p| r.holds(middle(p)));
        let rod = rods.iter().position(lies_in);
        let known = rod.and_then(|at| in_rod.get(&at)).and_then(|&at| out.get_mut(at));
        match (known, rod.and_then(|at| rods.get(at).zip(Some(at)))) {
            (Some(known), _) => known.join(place),
            (None, Some((rod, at))) => {
                in_rod.insert(at, out.len());
                out.push(Detail {
                    extent: hull(place.extent, rod.extent),
                    spans: [place.spans[0].max(rod.length - rod.diameter()), place.spans[1], place.spans[2]],
                    ..place
                });
            }
            (None, None) => out.push(place),
        }
    }
    out
}

impl Detail {
    /// A rod as a whole, with a direction across it.
    fn of_rod(rod: &Rod, across: Vec3) -> Self {
        let (wide, mean) = (rod.narrowest.inscribed, rod.mean_diameter());
        let contacts = [-0.5, 0.5].map(|t| along(rod.narrowest.centre, across, t * wide));
        let thinnest = Thin { centre: rod.narrowest.centre, contacts, diameter: wide };
        let (area, volume) = (0.5 * PI * mean * rod.length, 0.25 * PI * mean * mean * rod.length);
        Detail {
            thinnest,
            low: wide,
            area,
            volume,
            covers: area,
            holds: volume,
            extent: rod.extent,
            spans: [rod.length, 0.0, 0.0],
            facet: rod.narrowest.facet,
            whole: None,
            patches: vec![Patch { extent: rod.extent, across }],
            places: vec![thinnest],
        }
    }

    /// Whether the middle of a rod's narrowest section lies in its box.
    fn holds_middle_of(&self, rod: &Rod) -> bool {
        (0..3).all(|a| (self.extent.0[a]..=self.extent.1[a]).contains(&rod.narrowest.centre[a]))
    }

    /// Takes in another place.
    fn join(&mut self, other: Detail) {
        if other.thinnest.diameter < self.thinnest.diameter {
            (self.thinnest, self.facet) = (other.thinnest, other.facet);
        }
        self.low = self.low.min(other.low);
        self.area += other.area;
        self.volume += other.volume;
        self.covers += other.covers;
        self.holds += other.holds;
        self.extent = hull(self.extent, other.extent);
        self.spans = [0, 1, 2].map(|i| self.spans[i].max(other.spans[i]));
        self.patches.extend(other.patches);
        self.places.extend(other.places);
    }
}
