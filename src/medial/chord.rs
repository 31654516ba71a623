//! The nearest opposing feature: a lower bound of the thickness at a patch of surface.

use super::feature::{Feature, Features};
use crate::geometry::triangle::{Pair, closest_pair};
use crate::geometry::vector::{self, Vec3, along, cross, distance, dot, norm2, scale, sub, unit};

/// A ball whose contacts are seen at least this far apart measures a wall or a gap; below, a wedge (150°).
pub const WALL_SEPARATION: f64 = 150.0 * std::f64::consts::PI / 180.0;
/// Surfaces whose normals are at least this far apart are parallel enough to be a sheet even where they meet (176°).
pub const PARALLEL: f64 = 176.0 * std::f64::consts::PI / 180.0;
/// What rounding may do to an angle, radians.
const MARGIN: f64 = 1e-6;
/// What rounding may do to a squared distance: what is farther than known by less is still measured.
const ROUNDED: f64 = 1.0 + 1e-9;
/// Sines and cosines of the eighths of a turn.
const EIGHTHS: [(f64, f64); 8] = {
    const H: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [(0.0, 1.0), (H, H), (1.0, 0.0), (H, -H), (0.0, -1.0), (-H, -H), (-1.0, 0.0), (-H, H)]
};

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

    /// Length of the longest edge and the index of its first corner.
    pub fn longest_edge(&self) -> (f64, usize) {
        (0..3)
            .map(|i| (distance(self.corners[i], self.corners[(i + 1) % 3]), i))
            .fold((-1.0, 0), |best, e| if e.0 > best.0 { e } else { best })
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
    /// No ball that touches patch and feature is thinner than this: length / sin(θ/2) for the widest angle θ of their normals.
    pub bound: f64,
    /// Index of the opposing feature.
    pub feature: u32,
}

/// The half-spaces that hold every chord of a patch: a pyramid about the cone of chord directions, swept over the patch.
///
/// One lane each, so that eight are tested at once; lanes without a half-space hold everything.
struct Reach {
    /// Components of the outward directions: positive ones, negative ones.
    out: [[[f64; LANES]; 2]; 3],
    offset: [f64; LANES],
}

/// Half-spaces of a pyramid.
const LANES: usize = EIGHTHS.len();

impl Reach {
    fn new(patch: &Patch) -> Self {
        let inward = scale(patch.axis, -1.0);
        let half_angle = 0.5 * (std::f64::consts::PI - WALL_SEPARATION) + MARGIN + patch.spread + patch.slack;
        let offset = |w: Vec3| patch.corners.iter().map(|&p| dot(p, w)).fold(f64::NEG_INFINITY, f64::max);
        let mut reach = Reach { out: [[[0.0; LANES]; 2]; 3], offset: [f64::INFINITY; LANES] };
        if half_angle < 1.4 {
            let side = if inward[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
            let u = unit(cross(inward, side));
            let v = cross(inward, u);
            let (sin, cos) = half_angle.sin_cos();
            for (lane, (s, c)) in EIGHTHS.into_iter().enumerate() {
                let of = |a: usize| cos * (c * u[a] + s * v[a]) - sin * inward[a];
                let w = [of(0), of(1), of(2)];
                reach.set(lane, w, offset(w));
            }
        } else if half_angle < 1.57 {
            reach.set(0, patch.axis, offset(patch.axis));
        }
        reach
    }

    fn set(&mut self, lane: usize, w: Vec3, offset: f64) {
        for (parts, w) in self.out.iter_mut().zip(w) {
            (parts[0][lane], parts[1][lane]) = (w.max(0.0), w.min(0.0));
        }
        self.offset[lane] = offset;
    }

    /// The half-spaces one by one: p·w ≤ offset.
    fn planes(&self) -> impl Iterator<Item = (Vec3, f64)> {
        let [x, y, z] = &self.out;
        let of = |parts: &[[f64; LANES]; 2], lane: usize| parts[0][lane] + parts[1][lane];
        let plane = move |lane: usize| ([of(x, lane), of(y, lane), of(z, lane)], self.offset[lane]);
        (0..LANES).map(plane).filter(|(_, offset)| *offset < f64::INFINITY)
    }

    /// Whether a box has a point in all half-spaces taken one by one.
    #[inline]
    fn meets_box(&self, (lo, hi): (Vec3, Vec3)) -> bool {
        let mut meets = true;
        for lane in 0..LANES {
            let least = |a: usize| self.out[a][0][lane] * lo[a] + self.out[a][1][lane] * hi[a];
            meets &= least(0) + least(1) + least(2) <= self.offset[lane];
        }
        meets
    }

    /// Whether each half-space holds a point of a triangle.
    #[inline]
    fn meets_corners(&self, t: &[Vec3; 3]) -> bool {
        let mut meets = true;
        for lane in 0..LANES {
            let of = |a: usize| self.out[a][0][lane] + self.out[a][1][lane];
            let (x, y, z, most) = (of(0), of(1), of(2), self.offset[lane]);
            let holds = |p: Vec3| p[0] * x + p[1] * y + p[2] * z <= most;
            meets &= holds(t[0]) | holds(t[1]) | holds(t[2]);
        }
        meets
    }

    /// Whether a point lies in all half-spaces.
    fn holds(&self, p: Vec3) -> bool {
        self.meets_corners(&[p; 3])
    }

    /// The part of a feature inside all half-spaces, as a convex polygon; `None` if there is none.
    fn clip(&self, feature: [Vec3; 3]) -> Option<Polygon> {
        let mut polygon = Polygon::new(feature);
        for (w, offset) in self.planes() {
            polygon = polygon.clipped(w, offset);
            if polygon.count == 0 {
                return None;
            }
        }
        Some(polygon)
    }
}

/// A convex polygon of at most a triangle's corners plus one for each clip.
struct Polygon {
    points: [Vec3; 14],
    count: usize,
}

impl Polygon {
    fn new(t: [Vec3; 3]) -> Self {
        let mut points = [[0.0; 3]; 14];
        points[..3].copy_from_slice(&t);
        Polygon { points, count: 3 }
    }

    /// The part where p·w ≤ offset.
    fn clipped(&self, w: Vec3, offset: f64) -> Polygon {
        let mut out = Polygon { points: [[0.0; 3]; 14], count: 0 };
        for i in 0..self.count {
            let (p, q) = (self.points[i], self.points[(i + 1) % self.count]);
            let (a, b) = (dot(p, w) - offset, dot(q, w) - offset);
            if a <= 0.0 {
                out.push(p);
            }
            if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                out.push(along(p, sub(q, p), a / (a - b)));
            }
        }
        out
    }

    fn push(&mut self, p: Vec3) {
        if self.count < self.points.len() {
            self.points[self.count] = p;
            self.count += 1;
        }
    }

    /// Nearest points of another triangle and this polygon.
    fn closest(&self, from: [Vec3; 3]) -> (Vec3, Vec3) {
        let fan =
            |i: usize| [self.points[0], self.points[i.min(self.count - 1)], self.points[(i + 1).min(self.count - 1)]];
        let mut best = closest_pair(from, fan(1));
        for i in 2..self.count.saturating_sub(1) {
            let next = closest_pair(from, fan(i));
            if distance(next.0, next.1) < distance(best.0, best.1) {
                best = next;
            }
        }
        best
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
    /// One best-first walk of the tree, pruned by distance, cone of normals and reach of the patch.
    pub fn nearest_chord(&self, patch: &Patch, within: f64) -> Option<Chord> {
        self.nearest_chord_where(patch, within, |_| true)
    }

    /// The same for the opposing features that are accepted.
    pub fn nearest_chord_where(&self, patch: &Patch, within: f64, accept: impl Fn(&Feature) -> bool) -> Option<Chord> {
        let least_angle = WALL_SEPARATION - MARGIN - patch.spread - patch.slack;
        let reach = Reach::new(patch);
        let (lo, hi) = vector::bounds(patch.corners)?;
        let nodes = self.tree.nodes();
        let mut best: Option<Chord> = None;
        let mut best2 = within * within;
        let least = (least_angle.sin(), least_angle.cos(), least_angle);
        let mut stack = [(0usize, 0.0f64); 128];
        let mut depth = usize::from(!nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let (at, bound) = stack[depth];
            let node = &nodes[at];
            if bound >= best2 || !node.may_turn_from(patch.axis, least) || !reach.meets_box(node.extent()) {
                continue;
            }
            if let Some([l, r]) = node.children() {
                let (dl, dr) = (nodes[l].box_distance2(lo, hi), nodes[r].box_distance2(lo, hi));
                let order = if dl <= dr { [(r, dr), (l, dl)] } else { [(l, dl), (r, dr)] };
                for child in order {
                    if child.1 < best2 && depth < stack.len() {
                        stack[depth] = child;
                        depth += 1;
                    }
                }
                continue;
            }
            for &i in self.tree.order()[node.run()].iter().filter(|&&i| accept(&self.list[i as usize])) {
                if let Some(c) = self.chord_to(patch, &reach, i, least, best2) {
                    let c2 = c.bound * c.bound;
                    if c2 < best2 || (c2 == best2 && best.is_some_and(|b| i < b.feature)) {
                        best2 = c2;
                        best = Some(c);
                    }
                }
            }
        }
        best
    }

    /// The shortest chord from the patch to one feature, if there can be one whose bound is not above √`best2`.
    ///
    /// What rules most features out for the least work comes first.
    fn chord_to(&self, patch: &Patch, reach: &Reach, index: u32, least: (f64, f64, f64), best2: f64) -> Option<Chord> {
        let (_, cos, least_angle) = least;
        let feature = &self.list[index as usize];
        if feature.spread + feature.slack == 0.0 && dot(feature.axis, patch.axis) > cos + 1e-9 {
            return None;
        }
        if boxes_apart2(&patch.corners, &feature.corners) > best2 * ROUNDED || !reach.meets_corners(&feature.corners) {
            return None;
        }
        let pair = Pair::of(patch.corners, feature.corners);
        // No bound is below the length.
        if pair.is_farther_than(best2.sqrt()) || !faces(patch, feature) {
            return None;
        }
        let widest = feature.widest_angle(patch.axis) + feature.slack;
        if widest < least_angle {
            return None;
        }
        let stretch = 1.0 / (0.5 * (widest + patch.spread + patch.slack).min(std::f64::consts::PI)).sin();
        // Two features that meet and are not parallel bound a wedge, whose thickness at its edge is 0.
        if meets(&patch.whole, &feature.corners) && widest < PARALLEL {
            return None;
        }
        if pair.is_farther_than(best2.sqrt() / stretch) {
            return None;
        }
        let chord = |(p, q): (Vec3, Vec3)| {
            let length = distance(p, q);
            Chord { from: p, to: q, length, bound: length * stretch, feature: index }
        };
        let unbound = chord(pair.nearest());
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

/// Whether the feature lies below the patch's plane somewhere, and the patch below the feature's.
fn faces(patch: &Patch, feature: &Feature) -> bool {
    let below = |of: &[Vec3; 3], plane: &[Vec3; 3], axis: Vec3| {
        plane.iter().any(|p| of.iter().any(|q| dot(sub(*p, *q), axis) > 0.0))
    };
    (patch.spread > 0.0 || below(&feature.corners, &patch.corners, patch.axis))
        && (feature.spread > 0.0 || below(&patch.corners, &feature.corners, feature.axis))
}

/// Squared distance between the boxes of two triangles.
#[inline]
fn boxes_apart2(s: &[Vec3; 3], t: &[Vec3; 3]) -> f64 {
    let least = |t: &[Vec3; 3]| vector::least(vector::least(t[0], t[1]), t[2]);
    let greatest = |t: &[Vec3; 3]| vector::greatest(vector::greatest(t[0], t[1]), t[2]);
    let ahead = sub(least(s), greatest(t));
    let gap = vector::greatest(vector::greatest(ahead, sub(least(t), greatest(s))), [0.0; 3]);
    norm2(gap)
}

/// Whether two features have a vertex in common.
pub fn meets(a: &[Vec3; 3], b: &[Vec3; 3]) -> bool {
    a.iter().any(|p| b.contains(p))
}

/// Nearest points of two convex polygons, as the least over their fans.
fn closest_polygons(a: &Polygon, b: &Polygon) -> (Vec3, Vec3) {
    let fan = |i: usize| [a.points[0], a.points[i.min(a.count - 1)], a.points[(i + 1).min(a.count - 1)]];
    let mut best = b.closest(fan(1));
    for i in 2..a.count.saturating_sub(1) {
        let next = b.closest(fan(i));
        if distance(next.0, next.1) < distance(best.0, best.1) {
            best = next;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::super::feature::Side;
    use super::*;
    use crate::geometry::Primitive;
    use crate::random::Lcg;
    use crate::units::Length;

    #[test]
    fn lanes_hold_what_the_half_spaces_hold_one_by_one() {
        let mut random = Lcg(21);
        for n in 0..400 {
            let corners = [random.point(-1.0, 1.0), random.point(-1.0, 1.0), random.point(-1.0, 1.0)];
            let spread = [0.0, 0.3, 1.25, 1.4][n % 4];
            let patch = Patch { corners, axis: unit(random.point(-1.0, 1.0)), spread, slack: 0.0, whole: corners };
            let reach = Reach::new(&patch);
            let t = [random.point(-2.0, 2.0), random.point(-2.0, 2.0), random.point(-2.0, 2.0)];
            let (lo, hi) = vector::bounds(t).unwrap();
            let least = |w: Vec3| (0..3).map(|a| if w[a] > 0.0 { w[a] * lo[a] } else { w[a] * hi[a] }).sum::<f64>();
            assert_eq!(reach.meets_box((lo, hi)), reach.planes().all(|(w, offset)| least(w) <= offset));
            let below = |(w, offset): (Vec3, f64)| t.iter().any(|p| dot(*p, w) <= offset);
            assert_eq!(reach.meets_corners(&t), reach.planes().all(below));
        }
    }

    #[test]
    fn the_walk_finds_the_least_chord_of_all_features() {
        let ball = |r: f64| Primitive::Ball { radius: Length::mm(r) }.mesh(Length::mm(0.05));
        let (s, c) = 0.7f64.sin_cos();
        let inner = ball(2.5).transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.05, 0.11, 0.02]);
        let mesh = ball(3.0).joined(&inner.flipped());
        let mut found = 0;
        for (side, within) in [(Side::Material, 0.55), (Side::Void, 5.5)] {
            let features = Features::new(&mesh, side, |_| true);
            for feature in features.list.iter().step_by(7) {
                let patch = Patch::from(feature);
                let least_angle = WALL_SEPARATION - MARGIN - patch.spread - patch.slack;
                let least = (least_angle.sin(), least_angle.cos(), least_angle);
                let reach = Reach::new(&patch);
                let all = 0..features.list.len() as u32;
                let chords = all.filter_map(|i| features.chord_to(&patch, &reach, i, least, f64::INFINITY));
                let plain = chords.map(|c| c.bound).filter(|b| *b < within).fold(f64::INFINITY, f64::min);
                let walked = features.nearest_chord(&patch, within).map_or(f64::INFINITY, |c| c.bound);
                assert!(walked == plain || (walked - plain).abs() < 1e-12, "{walked} {plain}");
                found += usize::from(plain.is_finite());
            }
        }
        assert!(found > 100, "{found}");
    }
}
