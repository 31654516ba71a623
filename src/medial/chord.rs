//! The nearest opposing feature: a lower bound of the thickness at a patch of surface.

use super::feature::{Feature, Features};
use crate::geometry::triangle::{closest_pair, closest_pair_within};
use crate::geometry::vector::{Vec3, along, cross, distance, dot, norm2, scale, sub, unit};

/// A ball whose contacts are seen at least this far apart measures a wall or a gap; below, a wedge (150°).
pub const WALL_SEPARATION: f64 = 150.0 * std::f64::consts::PI / 180.0;
/// Surfaces whose normals are at least this far apart are parallel enough to be a sheet even where they meet (176°).
pub const PARALLEL: f64 = 176.0 * std::f64::consts::PI / 180.0;
/// What rounding may do to an angle, radians.
const MARGIN: f64 = 1e-6;
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
struct Reach {
    planes: [(Vec3, f64); 9],
    count: usize,
}

impl Reach {
    fn new(patch: &Patch) -> Self {
        let inward = scale(patch.axis, -1.0);
        let half_angle = 0.5 * (std::f64::consts::PI - WALL_SEPARATION) + MARGIN + patch.spread + patch.slack;
        let offset = |w: Vec3| patch.corners.iter().map(|&p| dot(p, w)).fold(f64::NEG_INFINITY, f64::max);
        let mut reach = Reach { planes: [([0.0; 3], 0.0); 9], count: 0 };
        if half_angle < 1.4 {
            let side = if inward[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
            let u = unit(cross(inward, side));
            let v = cross(inward, u);
            let (sin, cos) = half_angle.sin_cos();
            for (s, c) in EIGHTHS {
                let w = [0, 1, 2].map(|a| cos * (c * u[a] + s * v[a]) - sin * inward[a]);
                reach.push(w, offset(w));
            }
        } else if half_angle < 1.57 {
            reach.push(patch.axis, offset(patch.axis));
        }
        reach
    }

    fn push(&mut self, w: Vec3, offset: f64) {
        self.planes[self.count] = (w, offset);
        self.count += 1;
    }

    /// Whether a box has a point in all half-spaces taken one by one.
    fn meets_box(&self, (lo, hi): (Vec3, Vec3)) -> bool {
        self.planes[..self.count].iter().all(|(w, offset)| {
            let least: f64 = (0..3).map(|a| if w[a] > 0.0 { w[a] * lo[a] } else { w[a] * hi[a] }).sum();
            least <= *offset
        })
    }

    /// Whether each half-space holds a point of a triangle.
    #[inline]
    fn meets_corners(&self, t: &[Vec3; 3]) -> bool {
        self.planes[..self.count].iter().all(|(w, offset)| t.iter().any(|p| dot(*p, *w) <= *offset))
    }

    /// Whether a point lies in all half-spaces.
    fn holds(&self, p: Vec3) -> bool {
        self.planes[..self.count].iter().all(|(w, offset)| dot(p, *w) <= *offset)
    }

    /// The part of a feature inside all half-spaces, as a convex polygon; `None` if there is none.
    fn clip(&self, feature: [Vec3; 3]) -> Option<Polygon> {
        let mut polygon = Polygon::new(feature);
        for (w, offset) in &self.planes[..self.count] {
            polygon = polygon.clipped(*w, *offset);
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
        let (lo, hi) = crate::geometry::vector::bounds(patch.corners)?;
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
    fn chord_to(&self, patch: &Patch, reach: &Reach, index: u32, least: (f64, f64, f64), best2: f64) -> Option<Chord> {
        let (_, cos, least_angle) = least;
        let feature = &self.list[index as usize];
        if feature.spread + feature.slack == 0.0 && dot(feature.axis, patch.axis) > cos + 1e-9 {
            return None;
        }
        if !reach.meets_corners(&feature.corners) {
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
        // The feature must lie below the patch's plane somewhere, and the patch below the feature's.
        let below = |of: &[Vec3; 3], plane: &[Vec3; 3], axis: Vec3| {
            plane.iter().any(|p| of.iter().any(|q| dot(sub(*p, *q), axis) > 0.0))
        };
        let facing = (patch.spread > 0.0 || below(&feature.corners, &patch.corners, patch.axis))
            && (feature.spread > 0.0 || below(&patch.corners, &feature.corners, feature.axis));
        if !facing {
            return None;
        }
        let chord = |(p, q): (Vec3, Vec3)| {
            let length = distance(p, q);
            Chord { from: p, to: q, length, bound: length * stretch, feature: index }
        };
        let unbound = chord(closest_pair_within(patch.corners, feature.corners, best2.sqrt() / stretch)?);
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
