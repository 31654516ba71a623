//! Steps lower than a layer beside a ceiling, which hold nothing up.

use super::beneath::Ground;
use super::bridge::{FLAT, Measuring};
use crate::geometry::halfspace::cut;
use crate::geometry::vector::{Vec3, along, distance, norm, sub};
use crate::geometry::{Adjacency, TriangleMesh};
use rustc_hash::FxHashMap;
use std::sync::OnceLock;

/// A facet whose normal rises by no more is upright.
const UPRIGHT: f64 = 1e-6;

/// What the surface does below an edge where it folds towards the void.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Descent {
    /// It goes down by a layer, or to what holds it: material of the layer below lies beside the edge.
    Holds,
    /// It ends before that; the facets of the step, if ceilings alone adjoin it.
    Ends(Vec<u32>),
}

/// The ways down a surface from the edges of its ceilings.
pub(super) struct Descents<'a, G> {
    mesh: &'a TriangleMesh,
    hangs: Vec<bool>,
    how: Measuring,
    ground: &'a G,
    next: OnceLock<Adjacency>,
}

impl<'a, G: Ground> Descents<'a, G> {
    /// Those of a mesh of which the facets `hanging` hang over.
    pub fn new(mesh: &'a TriangleMesh, hanging: &[u32], how: Measuring, ground: &'a G) -> Self {
        let mut hangs = vec![false; mesh.triangles.len()];
        hanging.iter().for_each(|&f| hangs[f as usize] = true);
        Descents { mesh, hangs, how, ground, next: OnceLock::new() }
    }

    /// How the surface goes on below the middle m of an edge, over the facet beyond it.
    ///
    /// { p : p on facets that do not look up, joined to that facet over edges no higher than m within R of it along x and y }, R the length of a
    /// ledge and at least three layers: a layer is laid on the one below where a place of this set is a layer lower than m.
    ///
    /// # Cost
    /// O(facets within R), and O(facets of the mesh) for the first edge that the facet beyond it does not settle.
    pub fn from(&self, [from, to]: [Vec3; 2], beyond: u32) -> Descent {
        if (to[0] - from[0]).hypot(to[1] - from[1]) <= self.how.step_mm {
            return Descent::Ends(Vec::new());
        }
        let middle = along(from, sub(to, from), 0.5);
        if self.looks_up(beyond) {
            return Descent::Holds;
        }
        // A facet of the step lies between the layer and the ceiling, and no ceiling between it and the edge.
        let band = [middle[2] - self.how.layer_mm, middle[2] + self.tie()];
        let is_step = |f: u32| {
            let heights = self.mesh.corners(f as usize).map(|p| p[2]);
            !self.hangs[f as usize] && heights.iter().all(|z| band[0] < *z && *z <= band[1])
        };
        let mut met: Vec<(u32, bool)> = vec![(beyond, is_step(beyond))];
        let mut place: FxHashMap<u32, usize> = FxHashMap::from_iter([(beyond, 0)]);
        let mut at = 0;
        while let Some(&(facet, steps)) = met.get(at) {
            at += 1;
            let Some(lowest) = self.lowest(facet, middle) else { continue };
            if lowest <= band[0] + self.tie() || lowest <= self.how.plate_z || self.ground.holds(facet) {
                return Descent::Holds;
            }
            for next in self.beside(facet).filter(|&f| !self.looks_up(f)) {
                let leads_on = steps && is_step(next);
                let n = *place.entry(next).or_insert(met.len());
                match met.get_mut(n) {
                    Some(known) => known.1 |= leads_on,
                    None => met.push((next, leads_on)),
                }
            }
        }
        let step: Vec<u32> = met.into_iter().filter(|(_, steps)| *steps).map(|(f, _)| f).collect();
        // Slopes meet levels at places: what they lead to is no part of one layer.
        let mut beside = step.iter().flat_map(|&f| self.beside(f)).filter(|&f| self.hangs[f as usize]);
        match beside.all(|f| self.is_flat(f)) {
            true => Descent::Ends(step),
            false => Descent::Ends(Vec::new()),
        }
    }

    /// Heights that differ by less are equal, millimetres.
    fn tie(&self) -> f64 {
        4.0 * self.how.step_mm
    }

    /// What looks up has its own material right below it; what leans by no more than its corners may be off does not.
    fn looks_up(&self, facet: u32) -> bool {
        let corners = self.mesh.corners(facet as usize);
        let longest = [0, 1, 2].map(|i| distance(corners[i], corners[(i + 1) % 3])).into_iter().fold(0.0, f64::max);
        let area = self.mesh.area_vector(facet as usize);
        area[2] > UPRIGHT * norm(area) && 2.0 * area[2] > self.tie() * longest
    }

    fn is_flat(&self, facet: u32) -> bool {
        self.mesh.normal(facet as usize)[2] <= -FLAT.cos()
    }

    /// The least height of what of a facet is no higher than a place, and within R of it; `None` if nothing is.
    fn lowest(&self, facet: u32, near: Vec3) -> Option<f64> {
        let reach = self.how.ledge_mm.max(3.0 * self.how.layer_mm) + self.tie();
        let mut left: Vec<Vec3> = self.mesh.corners(facet as usize).to_vec();
        for (axis, sign, most) in
            [(2, 1.0, self.tie()), (0, 1.0, reach), (0, -1.0, reach), (1, 1.0, reach), (1, -1.0, reach)]
        {
            left = cut(&left, |p| most - sign * (p[axis] - near[axis]));
        }
        left.iter().map(|p| p[2]).min_by(f64::total_cmp)
    }

    /// The facets over the edges of a facet that it shares with one other.
    fn beside(&self, facet: u32) -> impl Iterator<Item = u32> + '_ {
        self.next.get_or_init(|| Adjacency::of(self.mesh, |_| true)).beside(facet)
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::{TriangleMesh, extruded};
    use crate::layer::{Ceiling, Measuring, Search, ceilings, downward_facets};
    use crate::units::Angle;

    const LAYER: f64 = 0.2;

    /// A column 2 mm wide from which an arm reaches to the right, 10 mm deep; `under` is its underside from (2, 8).
    fn arm(under: &[[f64; 2]]) -> TriangleMesh {
        let end = under.last().map_or(2.0, |p| p[0]);
        let mut outline = vec![[0.0, 10.0], [0.0, 0.0], [2.0, 0.0], [2.0, 8.0]];
        outline.extend(under);
        outline.push([end, 10.0]);
        let caps: Vec<[usize; 3]> = (1..outline.len() - 1).map(|n| [0, n, n + 1]).collect();
        extruded(&outline, &caps, 10.0)
    }

    /// Treads so long from the wall on, each a riser higher than the one before.
    fn stairs(tread: f64, riser: f64, count: usize) -> TriangleMesh {
        let corners = |n: usize| {
            let (x, z) = (2.0 + tread * (n + 1) as f64, 8.0 + riser * n as f64);
            if n + 1 < count { vec![[x, z], [x, z + riser]] } else { vec![[x, z]] }
        };
        arm(&(0..count).flat_map(corners).collect::<Vec<_>>())
    }

    fn found(mesh: &TriangleMesh) -> Vec<Ceiling> {
        found_within(mesh, 1e-6)
    }

    /// As [`found`], coordinates off by so much.
    fn found_within(mesh: &TriangleMesh, step_mm: f64) -> Vec<Ceiling> {
        let search = Search::Measure;
        let hanging = downward_facets(mesh, 0.1, Angle::degrees(45.0), step_mm);
        let how = Measuring { plate_z: 0.1, layer_mm: LAYER, ledge_mm: 0.4, bridge_mm: 10.0, step_mm, search };
        ceilings(mesh, &hanging, how, &())
    }

    /// How far all of it reaches out.
    fn reach(mesh: &TriangleMesh) -> [f64; 2] {
        let far = found(mesh).iter().filter_map(|c| c.cantilever).map(|r| [r.low_mm, r.high_mm]).collect::<Vec<_>>();
        assert!(far.len() <= 1, "{far:?}");
        far.first().copied().unwrap_or_default()
    }

    #[test]
    fn steps_lower_than_a_layer_are_no_anchors() {
        let plain = reach(&arm(&[[10.0, 8.0]]));
        assert!(plain[0] > 7.5 && plain[1] >= 8.0, "{plain:?}");
        // Stairs that rise by 0.4 mm in all over 8 mm: the first tread is a ledge, and as long as one.
        for riser in [1e-3, 0.02] {
            let [low, high] = reach(&stairs(0.4, riser, 20));
            assert!(low > 7.2 && high >= 7.6, "{riser}: {low} {high}");
        }
        // A lip at the end, pointed or flat, and one in the middle.
        for under in [
            vec![[9.9, 8.0], [9.95, 7.9], [10.0, 7.9]],
            vec![[9.5, 8.0], [9.5, 7.999], [10.0, 7.999]],
            vec![[5.0, 8.0], [5.05, 7.91], [5.1, 8.0], [10.0, 8.0]],
            vec![[5.0, 8.0], [5.0, 7.91], [5.5, 7.91], [5.5, 8.0], [10.0, 8.0]],
        ] {
            let [low, high] = reach(&arm(&under));
            assert!(low > 7.3 && high >= 7.9, "{under:?}: {low} {high}");
        }
    }

    #[test]
    fn what_goes_down_by_a_layer_within_a_ledge_holds() {
        // A lip as deep as a layer, whatever holds that, and stairs as steep as what holds itself.
        let lip = found(&arm(&[[9.6, 8.0], [9.6, 7.8], [10.0, 7.8]]));
        assert!(lip.iter().all(|c| c.bridge.is_none_or(|b| b.high_mm <= 7.6 + 1e-6)), "{lip:?}");
        for (tread, riser) in [(0.058, 0.1), (0.1, 0.1), (0.3, 0.2)] {
            assert_eq!(reach(&stairs(tread, riser, 12)), [0.0; 2], "{tread} × {riser}");
        }
    }

    #[test]
    fn walls_that_lean_by_what_single_precision_takes_from_them_hold() {
        for (low, high) in [(0.4, 2.4), (3.0, 5.0), (0.25, 1.0)] {
            let outline = [[0.0, 0.0], [40.0, 0.0], [40.0, low], [49.0, low], [49.0, high], [0.0, high]];
            let plate = extruded(&outline, &[[0, 1, 2], [0, 2, 5], [2, 3, 4], [2, 4, 5]], 2.0);
            for turn in 0..49 {
                let (s, c) = (3.7 * f64::from(turn)).to_radians().sin_cos();
                let turned = plate.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [50.0, 30.0, 0.0]);
                let single = |p: [f64; 3]| p.map(|x| f64::from(x as f32));
                let mesh = TriangleMesh { vertices: turned.vertices.into_iter().map(single).collect(), ..turned };
                let found = found_within(&mesh, 8e-6);
                let reach: Vec<_> = found.iter().filter_map(|c| c.cantilever).collect();
                assert!(reach.len() == 1 && reach[0].low_mm > 8.8 && reach[0].high_mm > 8.99, "{turn}: {found:?}");
            }
        }
    }
}
