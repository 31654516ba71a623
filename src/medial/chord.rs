//! The nearest opposing feature: a lower bound of the thickness at a patch of surface.

use super::facing::{Query, Visit};
use super::feature::{Feature, Features};
use super::reach::{Reach, Slabs, closest_polygons};
use crate::geometry::triangle::Pair;
use crate::geometry::vector::{self, Vec3, along, cross, distance, dot, norm2, sub, unit};
use pulp::{Arch, NullaryFnOnce};

/// A ball whose contacts are seen at least this far apart measures a wall or a gap; below, a wedge (150°).
pub const WALL_SEPARATION: f64 = 150.0 * std::f64::consts::PI / 180.0;
/// Short of a wall's separation by so little that the thickness is the same (140°).
pub const NEARLY_WALL: f64 = 140.0 * std::f64::consts::PI / 180.0;
/// Surfaces whose normals are at least this far apart are parallel enough to be a sheet even where they meet (176°).
pub const PARALLEL: f64 = 176.0 * std::f64::consts::PI / 180.0;
/// What rounding may do to an angle, radians.
pub(super) const MARGIN: f64 = 1e-6;
/// What rounding may do to a squared distance: what is farther than known by less is still measured.
const ROUNDED: f64 = 1.0 + 1e-9;
/// What rounding may do to a length of nothing, millimetres.
const ROUNDED_LENGTH: f64 = 1e-9;

/// A flat patch of surface, or an edge or vertex, that chords start from.
#[derive(Debug, Clone, Copy)]
pub struct Patch {
    pub corners: [Vec3; 3],
    pub axis: Vec3,
    pub spread: f64,
    pub slack: f64,
    /// Corners of the whole feature the patch is part of.
    pub whole: [Vec3; 3],
}

impl Patch {
    /// The centroid of the corners.
    pub fn centroid(&self) -> Vec3 {
        let [a, b, c] = self.corners;
        [0, 1, 2].map(|x| (a[x] + b[x] + c[x]) / 3.0)
    }

    /// Area; 0 for an edge or a vertex.
    pub fn area(&self) -> f64 {
        let [a, b, c] = self.corners;
        0.5 * norm2(cross(sub(b, a), sub(c, a))).sqrt()
    }

    /// The centroids of the n² equal triangles that lines parallel to the edges part it into.
    pub(super) fn middles(&self, n: u32) -> impl Iterator<Item = Vec3> {
        let [a, b, c] = self.corners;
        let third = 1.0 / f64::from(3 * n);
        let at =
            move |u: u32, v: u32| along(along(a, sub(b, a), f64::from(u) * third), sub(c, a), f64::from(v) * third);
        let upright = (0..n).flat_map(move |i| (0..n - i).map(move |j| at(3 * i + 1, 3 * j + 1)));
        let turned = (1..n).flat_map(move |i| (1..=n - i).map(move |j| at(3 * i - 1, 3 * j - 1)));
        upright.chain(turned)
    }

    /// Length of the longest edge and the index of its first corner.
    pub fn longest_edge(&self) -> (f64, usize) {
        (0..3)
            .map(|i| (distance(self.corners[i], self.corners[(i + 1) % 3]), i))
            .fold((-1.0, 0), |best, e| if e.0 > best.0 { e } else { best })
    }

    /// Box around the corners.
    pub fn sides(&self) -> (Vec3, Vec3) {
        vector::bounds(self.corners).unwrap_or_default()
    }

    /// The two halves across the middle of the longest edge; an edge is halved, a vertex stays as it is.
    pub fn halves(&self) -> [Patch; 2] {
        let (_, i) = self.longest_edge();
        let [a, b, c] = [self.corners[i], self.corners[(i + 1) % 3], self.corners[(i + 2) % 3]];
        let m = along(a, sub(b, a), 0.5);
        if self.spread > 0.0 {
            let [p, q, _] = self.corners;
            let m = along(p, sub(q, p), 0.5);
            return [Patch { corners: [p, m, m], ..*self }, Patch { corners: [m, q, q], ..*self }];
        }
        [Patch { corners: [a, m, c], ..*self }, Patch { corners: [m, b, c], ..*self }]
    }
}

impl From<&Feature> for Patch {
    fn from(f: &Feature) -> Self {
        Patch { corners: f.corners, axis: f.axis, spread: f.spread, slack: f.slack, whole: f.corners }
    }
}

/// A straight line from a patch to an opposing feature.
#[derive(Debug, Clone, Copy)]
pub struct Chord {
    pub from: Vec3,
    pub to: Vec3,
    pub length: f64,
    /// No ball that touches patch and feature is thinner than this: length / sin(θ/2) for the widest angle θ of their normals, or twice the least
    /// distance of one of two facets from the plane of the other over 1 − cos θ.
    pub bound: f64,
    /// Index of the opposing feature.
    pub feature: u32,
}

impl Chord {
    /// The point halfway along it.
    pub(super) fn middle(&self) -> Vec3 {
        [0, 1, 2].map(|a| 0.5 * (self.from[a] + self.to[a]))
    }
}

impl Features {
    /// The chord of least bound from a patch to an opposing feature, if its bound is below `within`.
    ///
    /// min { |pq| : p ∈ patch, q ∈ feature, normals at p and q at least 150° apart, pq within their cones } is a
    /// lower bound for the diameter of every wall ball that touches the patch (features that meet in a wedge left aside), because such a ball touches an opposing
    /// feature q with |pq| = 2r·sin(θ/2); the widest angle of the two normals bounds 2r from below. Edges too blunt to be features widen the cones of their facets.
    ///
    /// # Cost
    /// One best-first walk of the tree, pruned by distance, cone of normals and reach of the patch. `opposite` is a feature
    /// that the chord may lead to, and becomes the one it leads to: it saves work on the next patch, and changes nothing else.
    pub fn nearest_chord(&self, patch: &Patch, within: f64, opposite: &mut Option<u32>) -> Option<Chord> {
        let chord = self.search(patch, within, *opposite, |_| true);
        *opposite = chord.map(|c| c.feature).or(*opposite);
        chord
    }

    /// The chord of least bound to the opposing features that are accepted.
    pub fn nearest_chord_where(&self, patch: &Patch, within: f64, accept: impl Fn(&Feature) -> bool) -> Option<Chord> {
        self.search(patch, within, None, accept)
    }

    fn search(
        &self,
        patch: &Patch,
        within: f64,
        from: Option<u32>,
        accept: impl Fn(&Feature) -> bool,
    ) -> Option<Chord> {
        let least_angle = WALL_SEPARATION - MARGIN - patch.spread - patch.slack;
        let reach = Reach::new(patch);
        let slabs = Slabs::new(&reach, self.facing.extent()?);
        let query = Query::new(vector::bounds(patch.corners)?, patch.axis, least_angle, slabs);
        let walk = Walk { features: self, patch, reach, least_angle, accept, best: None };
        // The same code for the widest vectors of the machine.
        Arch::new().dispatch(Search { walk, query, start: (within * within, from) })
    }
}

/// A walk to be made.
struct Search<'a, A> {
    walk: Walk<'a, A>,
    query: Query,
    start: (f64, Option<u32>),
}

impl<A: Fn(&Feature) -> bool> NullaryFnOnce for Search<'_, A> {
    type Output = Option<Chord>;

    #[inline(always)]
    fn call(mut self) -> Self::Output {
        self.walk.features.facing.opposing(&self.query, self.start, &mut self.walk);
        self.walk.best
    }
}

/// One search for the nearest chord.
struct Walk<'a, A> {
    features: &'a Features,
    patch: &'a Patch,
    reach: Reach,
    /// Least angle of the normals.
    least_angle: f64,
    accept: A,
    best: Option<Chord>,
}

impl<A: Fn(&Feature) -> bool> Visit for Walk<'_, A> {
    #[inline(always)]
    fn visit(&mut self, feature: u32, best2: f64) -> f64 {
        let of = self.features.list.get(feature as usize).filter(|f| (self.accept)(f));
        let Some(chord) = of.and_then(|f| self.chord_to((feature, f), best2)) else { return best2 };
        let squared = chord.bound * chord.bound;
        if squared < best2 || (squared == best2 && self.best.is_some_and(|b| feature < b.feature)) {
            self.best = Some(chord);
            return squared;
        }
        best2
    }
}

impl<A> Walk<'_, A> {
    /// The shortest chord from the patch to one feature, if there can be one whose bound is not above √`best2`.
    ///
    /// What rules most features out for the least work comes first.
    #[inline(always)]
    fn chord_to(&self, (index, feature): (u32, &Feature), best2: f64) -> Option<Chord> {
        let (patch, reach) = (self.patch, &self.reach);
        if !reach.meets_corners(&feature.corners) {
            return None;
        }
        let pair = Pair::of(patch.corners, feature.corners);
        // No bound is below the length.
        let within = (best2.sqrt() * ROUNDED).max(ROUNDED_LENGTH);
        if pair.is_farther_than(within) || !faces(patch, feature) {
            return None;
        }
        let widest = feature.widest_angle(patch.axis) + feature.slack;
        if widest < self.least_angle {
            return None;
        }
        let stretch = 1.0 / (0.5 * (widest + patch.spread + patch.slack).min(std::f64::consts::PI)).sin();
        // Two features that meet and are not parallel bound a wedge, whose thickness at its edge is 0.
        if meets(&patch.whole, &feature.corners) && widest < PARALLEL {
            return None;
        }
        let tangent = tangent(patch, feature);
        if tangent > within || pair.is_farther_than(within / stretch) {
            return None;
        }
        let chord = |(p, q): (Vec3, Vec3)| {
            let length = distance(p, q);
            Chord { from: p, to: q, length, bound: tangent.max(length * stretch), feature: index }
        };
        // Of chords without length the first feature counts, so that one more of them is still found.
        let most2 = (best2 * ROUNDED / (stretch * stretch)).max(f64::MIN_POSITIVE);
        let unbound = chord(pair.nearest_within(most2)?);
        if unbound.bound * unbound.bound > best2 {
            return None;
        }
        let back = Reach::new(&Patch::from(feature));
        if reach.holds(unbound.to) && back.holds(unbound.from) {
            return Some(unbound);
        }
        let target = reach.clip(feature.corners)?;
        Some(chord(closest_polygons(&back.clip(patch.corners)?, &target)))
    }
}

/// No ball that touches a flat patch and a facet without touching an edge of either is thinner; 0 for edges, and facets that bend towards it.
///
/// A ball of radius r that touches the planes of both, whose normals are θ apart, at p and q has its centre at a distance r from both: the distance of
/// p from the other plane is r (1 − cos θ), as is that of q. Round a pin or a hole chords to the facets beside the opposite one are shorter than
/// twice that; these balls are not.
#[inline(always)]
fn tangent(patch: &Patch, feature: &Feature) -> f64 {
    if patch.spread + patch.slack > 0.0 || !feature.is_facet() || feature.slack > 0.0 {
        return 0.0;
    }
    let least = |from: &[Vec3; 3], to: &[Vec3; 3], axis: Vec3| {
        from.iter().map(|p| dot(sub(to[0], *p), axis)).fold(f64::INFINITY, f64::min)
    };
    let far = least(&patch.corners, &feature.corners, feature.axis);
    let near = least(&feature.corners, &patch.corners, patch.axis);
    2.0 * far.max(near).max(0.0) / (ROUNDED * (1.0 - dot(patch.axis, feature.axis)))
}

/// Whether the feature lies below the patch's plane somewhere, and the patch below the feature's.
fn faces(patch: &Patch, feature: &Feature) -> bool {
    let below = |of: &[Vec3; 3], plane: &[Vec3; 3], axis: Vec3| {
        plane.iter().any(|p| of.iter().any(|q| dot(sub(*p, *q), axis) > 0.0))
    };
    (patch.spread > 0.0 || below(&feature.corners, &patch.corners, patch.axis))
        && (feature.spread > 0.0 || below(&patch.corners, &feature.corners, feature.axis))
}

/// Whether every chord from an edge to a feature runs farther off the planes across the edge, in which balls within it grow, than the contacts of
/// a wall's ball let it.
pub(super) fn runs_along([a, b]: [Vec3; 2], feature: &Feature) -> bool {
    let (run, off) = (unit(sub(b, a)), 0.5 * (std::f64::consts::PI - WALL_SEPARATION) + MARGIN + feature.slack);
    let (mut low, mut high, mut far2) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
    for to in [a, b].into_iter().flat_map(|p| feature.corners.iter().map(move |q| sub(*q, p))) {
        let on = dot(to, run);
        (low, high, far2) = (low.min(on), high.max(on), far2.max(norm2(to)));
    }
    let least = low.max(-high).max(0.0);
    least * least > off.sin().powi(2) * far2 * ROUNDED
}

/// Whether two features have a vertex in common.
pub fn meets(a: &[Vec3; 3], b: &[Vec3; 3]) -> bool {
    a.iter().any(|p| b.contains(p))
}

#[cfg(test)]
mod tests {
    use super::super::feature::Side;
    use super::*;
    use crate::geometry::Primitive;
    use crate::units::Length;

    #[test]
    fn the_walk_finds_the_least_chord_of_all_features() {
        let ball = |r: f64| Primitive::Ball { radius: Length::mm(r) }.mesh(Length::mm(0.05));
        let (s, c) = 0.7f64.sin_cos();
        let inner = ball(2.5).transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.05, 0.11, 0.02]);
        let mesh = ball(3.0).joined(&inner.flipped());
        let (mut found, mut random) = (0, crate::random::Lcg(5));
        for (side, within) in [(Side::Material, 0.55), (Side::Void, 5.5)] {
            let features = Features::new(&mesh, side, |_| true);
            for feature in features.list.iter().step_by(7) {
                let patch = Patch::from(feature);
                let least_angle = WALL_SEPARATION - MARGIN - patch.spread - patch.slack;
                let reach = Reach::new(&patch);
                let walk = Walk { features: &features, patch: &patch, reach, least_angle, accept: (), best: None };
                let all = (0u32..).zip(&features.list);
                let chords = all.filter_map(|f| walk.chord_to(f, f64::INFINITY));
                let plain = chords.map(|c| c.bound).filter(|b| *b < within).fold(f64::INFINITY, f64::min);
                let walked = features.nearest_chord(&patch, within, &mut None).map_or(f64::INFINITY, |c| c.bound);
                assert!(walked == plain || (walked - plain).abs() < 1e-12, "{walked} {plain}");
                let chord = |mut from| {
                    let chord = features.nearest_chord(&patch, within, &mut from);
                    assert!(chord.is_none_or(|c| from == Some(c.feature)));
                    chord.map(|c| (c.feature, c.from, c.to))
                };
                let from = random.below(features.list.len() as u64) as u32;
                assert_eq!(chord(Some(from)), chord(None));
                found += usize::from(plain.is_finite());
            }
        }
        assert!(found > 100, "{found}");
    }

    /// No ball between two sides of a pin or a hole is thinner than that in its middle: beside the facet that is straight across, too.
    #[test]
    fn the_least_bound_at_the_middle_of_a_pins_side_is_its_inscribed_diameter() {
        for sides in [8, 12, 64] {
            let rod = crate::geometry::revolved(&[[0.0, 0.0], [0.3, 0.0], [0.3, 5.0], [0.0, 5.0]], sides);
            let features = Features::new(&rod, Side::Material, |_| true);
            let across = 0.6 * (std::f64::consts::PI / sides as f64).cos();
            for feature in features.list.iter().filter(|f| f.is_facet() && f.axis[2].abs() < 0.1) {
                let middle = crate::geometry::vector::scale(feature.axis, 0.5 * across);
                let corners = [0.0, 1e-6, 2e-6].map(|up| [middle[0], middle[1], 2.5 + up]);
                let patch = Patch { corners, ..Patch::from(feature) };
                let bound = features.nearest_chord(&patch, 1.0, &mut None).unwrap().bound;
                assert!((bound - across).abs() < 1e-6, "{sides}: {bound} {across}");
            }
        }
    }
}
