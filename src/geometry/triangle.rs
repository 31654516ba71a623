//! Exact distances between points, segments and triangles; degenerate ones are points or segments.

use super::ray::Ray;
use super::vector::{Vec3, add, along, cross, dot, norm2, scale, sub};

/// The point of a triangle nearest to `p`.
///
/// Source: region test on barycentric signs, after C. Ericson, *Real-Time Collision Detection*, 2005, §5.1.5.
#[inline]
pub fn closest_point(p: Vec3, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return along(a, ab, d1 / (d1 - d3));
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return along(a, ac, d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return along(b, sub(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let total = va + vb + vc;
    if total == 0.0 || total.is_nan() {
        return a;
    }
    add(a, add(scale(ab, vb / total), scale(ac, vc / total)))
}

/// The nearest points of two segments.
///
/// Source: C. Ericson, *Real-Time Collision Detection*, 2005, §5.1.9.
#[inline]
pub fn closest_on_segments([p1, q1]: [Vec3; 2], [p2, q2]: [Vec3; 2]) -> (Vec3, Vec3) {
    let (d1, d2, r) = (sub(q1, p1), sub(q2, p2), sub(p1, p2));
    let (a, e, f) = (norm2(d1), norm2(d2), dot(d2, r));
    let (s, t);
    if a == 0.0 {
        s = 0.0;
        t = if e == 0.0 { 0.0 } else { (f / e).clamp(0.0, 1.0) };
    } else {
        let c = dot(d1, r);
        if e == 0.0 {
            t = 0.0;
            s = (-c / a).clamp(0.0, 1.0);
        } else {
            let b = dot(d1, d2);
            let denominator = a * e - b * b;
            let s0 = if denominator > 1e-14 * a * e { ((b * f - c * e) / denominator).clamp(0.0, 1.0) } else { 0.0 };
            let t0 = (b * s0 + f) / e;
            if t0 < 0.0 {
                t = 0.0;
                s = (-c / a).clamp(0.0, 1.0);
            } else if t0 > 1.0 {
                t = 1.0;
                s = ((b - c) / a).clamp(0.0, 1.0);
            } else {
                t = t0;
                s = s0;
            }
        }
    }
    (along(p1, d1, s), along(p2, d2, t))
}

/// The nearest points of two triangles; equal points where they cross.
///
/// The minimum over the six corner–face and nine edge–edge pairs, which is the distance of disjoint triangles, and
/// a crossing point where an edge of one pierces the other. Degenerate triangles are their segments or points.
pub fn closest_pair(s: [Vec3; 3], t: [Vec3; 3]) -> (Vec3, Vec3) {
    Pair::of(s, t).nearest()
}

/// The nearest points of two triangles if they may be nearer than `within`; `None` where a plane between them says that
/// they are not.
pub fn closest_pair_within(s: [Vec3; 3], t: [Vec3; 3], within: f64) -> Option<(Vec3, Vec3)> {
    let pair = Pair::of(s, t);
    (!pair.is_farther_than(within)).then(|| pair.nearest())
}

/// What squares of distances differ by more than, relative to them and to a square millimetre, is no rounding.
const SURELY: f64 = 1e-6;

/// Two triangles, and how high the corners of each lie over the plane of the other: cheap bounds come before the nearest points.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    triangles: [[Vec3; 3]; 2],
    /// Twice the area vectors.
    normals: [Vec3; 2],
    /// Heights of the corners of each over the plane of the other, times the length of its normal.
    heights: [[f64; 3]; 2],
}

impl Pair {
    /// Prepares two triangles.
    #[inline]
    pub fn of(s: [Vec3; 3], t: [Vec3; 3]) -> Self {
        let (m, n) = (normal_of(s), normal_of(t));
        Pair { triangles: [s, t], normals: [m, n], heights: [heights(s, t[0], n), heights(t, s[0], m)] }
    }

    /// Whether they are farther apart than `within` along the normal of one, or along the line between their centroids; `false`
    /// does not say that they are near.
    #[inline]
    pub fn is_farther_than(&self, within: f64) -> bool {
        let far = |least: f64, n: Vec3| least * least > within * within * norm2(n);
        if far(clear_of(self.heights[0]), self.normals[1]) || far(clear_of(self.heights[1]), self.normals[0]) {
            return true;
        }
        // What is small and stands aside is told apart along the line between them rather than along a normal.
        let [s, t] = self.triangles;
        let between = sub(add(add(t[0], t[1]), t[2]), add(add(s[0], s[1]), s[2]));
        let [to, from] = [t, s].map(|of| heights(of, s[0], between));
        far((smallest(to) - largest(from)).max(0.0), between)
    }

    /// The nearest points; equal points where the triangles cross.
    pub fn nearest(&self) -> (Vec3, Vec3) {
        let [s, t] = self.triangles;
        self.nearest_within(f64::INFINITY).unwrap_or((s[0], t[0]))
    }

    /// The nearest points, if the square of their distance is below `within2`.
    ///
    /// # Cost
    /// The less, the lower that is: corners too high over the other's plane need no foot on it.
    pub fn nearest_within(&self, within2: f64) -> Option<(Vec3, Vec3)> {
        let ([s, t], [m, n], [over_t, over_s]) = (self.triangles, self.normals, self.heights);
        let mut best = None;
        let mut best2 = within2;
        let offer = |(p, q): (Vec3, Vec3), best: &mut Option<(Vec3, Vec3)>, best2: &mut f64| {
            let d2 = norm2(sub(p, q));
            if d2 < *best2 {
                (*best, *best2) = (Some((p, q)), d2);
            }
        };
        let too_high = |height: f64, n2: f64, best2: f64| {
            let square = height * height;
            square > best2 * n2 * (1.0 + SURELY) && square > SURELY * n2
        };
        let (m2, n2) = (norm2(m), norm2(n));
        // A corner whose foot lies beside the other triangle is nearest to one of its edges.
        for i in 0..3 {
            if !too_high(over_t[i], n2, best2)
                && let Some(q) = foot_inside(s[i], t, n, over_t[i])
            {
                offer((s[i], q), &mut best, &mut best2);
            }
            if !too_high(over_s[i], m2, best2)
                && let Some(p) = foot_inside(t[i], s, m, over_s[i])
            {
                offer((p, t[i]), &mut best, &mut best2);
            }
        }
        for a in edges(&s) {
            for b in edges(&t) {
                offer(closest_on_segments(a, b), &mut best, &mut best2);
            }
        }
        if clear_of(over_t) > 0.0 || clear_of(over_s) > 0.0 {
            return best;
        }
        self.pierced().map(|p| (p, p)).or(best)
    }

    /// Where an edge of one passes through the other.
    fn pierced(&self) -> Option<Vec3> {
        let ([s, t], [over_t, over_s]) = (self.triangles, self.heights);
        [(s, over_t, t), (t, over_s, s)].into_iter().find_map(|(of, heights, face)| {
            let flat = flatness(&of, &face);
            let through = |i: usize| {
                let (a, b) = (heights[i], heights[(i + 1) % 3]);
                a.min(b) < -flat && a.max(b) > flat
            };
            edges(&of).enumerate().filter(|e| through(e.0)).find_map(|(_, edge)| pierce(edge, face))
        })
    }
}

/// The least height of three corners that lie on one side of a plane; 0 where they do not.
#[inline]
fn clear_of(heights: [f64; 3]) -> f64 {
    let (up, down) = (smallest(heights), -largest(heights));
    let clear = if down > up { down } else { up };
    if clear > 0.0 { clear } else { 0.0 }
}

/// The least of three numbers.
#[inline]
fn smallest([a, b, c]: [f64; 3]) -> f64 {
    let least = |a: f64, b: f64| if b < a { b } else { a };
    least(least(a, b), c)
}

/// The greatest of three numbers.
#[inline]
fn largest([a, b, c]: [f64; 3]) -> f64 {
    let greatest = |a: f64, b: f64| if b > a { b } else { a };
    greatest(greatest(a, b), c)
}

/// Twice the area vector.
#[inline]
fn normal_of([a, b, c]: [Vec3; 3]) -> Vec3 {
    cross(sub(b, a), sub(c, a))
}

/// Heights of three points over the plane through `on` with normal `n`, times |n|.
#[inline]
fn heights(points: [Vec3; 3], on: Vec3, n: Vec3) -> [f64; 3] {
    let height = |p: Vec3| dot(sub(p, on), n);
    [height(points[0]), height(points[1]), height(points[2])]
}

/// Heights of one triangle over another's plane, times |n|, below which they may be rounding alone: an edge that passes
/// through by less is as near to the other's edges and corners.
fn flatness(of: &[Vec3; 3], face: &[Vec3; 3]) -> f64 {
    let longest = |t: &[Vec3; 3]| edges(t).map(|[p, q]| norm2(sub(q, p))).fold(0.0, f64::max);
    let (own, other) = (longest(of), longest(face));
    1e-10 * own.max(other).sqrt() * other
}

/// The foot of a point on a triangle's plane, if it lies in the triangle; `height` is over the plane, times |n|.
#[inline]
fn foot_inside(p: Vec3, [a, b, c]: [Vec3; 3], n: Vec3, height: f64) -> Option<Vec3> {
    let n2 = norm2(n);
    if n2 == 0.0 {
        return None;
    }
    let left = |from: Vec3, to: Vec3| dot(cross(sub(to, from), sub(p, from)), n) >= 0.0;
    (left(a, b) && left(b, c) && left(c, a)).then(|| along(p, n, -height / n2))
}

/// The edges of a triangle: one if it is a segment (a, b, b), its point if it has no length.
#[inline]
fn edges(&[a, b, c]: &[Vec3; 3]) -> impl Iterator<Item = [Vec3; 2]> {
    let count = if b == c { 1 } else { 3 };
    [[a, b], [b, c], [c, a]].into_iter().take(count)
}

/// Where a segment crosses the inside of a triangle, if it does.
fn pierce([p, q]: [Vec3; 2], triangle: [Vec3; 3]) -> Option<Vec3> {
    let d = sub(q, p);
    Ray::of(p, d).hit(triangle).filter(|s| (0.0..=1.0).contains(s)).map(|s| along(p, d, s))
}

#[cfg(test)]
mod tests {
    use super::super::vector::distance;
    use super::*;
    use crate::random::Lcg;

    /// Dense sampling of both triangles: an upper bound of their distance, off by at most the sample step.
    fn sampled(s: [Vec3; 3], t: [Vec3; 3]) -> f64 {
        let n = 40;
        let points = |m: [Vec3; 3]| -> Vec<Vec3> {
            (0..=n)
                .flat_map(|i| (0..=n - i).map(move |j| (i as f64 / n as f64, j as f64 / n as f64)))
                .map(|(u, v)| add(m[0], add(scale(sub(m[1], m[0]), u), scale(sub(m[2], m[0]), v))))
                .collect()
        };
        let b = points(t);
        points(s)
            .iter()
            .map(|p| b.iter().map(|q| distance(*p, *q)).fold(f64::INFINITY, f64::min))
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn pair_distance_is_never_above_and_close_to_the_sampled_one() {
        let mut rng = Lcg(7);
        for _ in 0..40 {
            let s = [rng.point(0.0, 1.0), rng.point(0.0, 1.0), rng.point(0.0, 1.0)];
            let t = [rng.point(0.0, 1.0), rng.point(0.0, 1.0), rng.point(0.0, 1.0)].map(|p| add(p, [0.8, 0.1, 0.0]));
            let (p, q) = closest_pair(s, t);
            let (exact, dense) = (distance(p, q), sampled(s, t));
            // Samples are at most 1/40 of an edge (< √3) apart on each triangle.
            assert!(exact <= dense + 1e-12 && dense <= exact + 2.0 * 1.7321 / 40.0, "{exact} {dense}");
            for (x, m) in [(p, s), (q, t)] {
                assert!(distance(x, closest_point(x, m)) < 1e-12);
            }
        }
    }

    #[test]
    fn triangles_in_one_plane_but_for_rounding_are_as_far_apart_as_they_lie() {
        let mut rng = Lcg(11);
        for _ in 0..2000 {
            // Turned about a common point and far from the origin, so that no height over the plane is exactly zero.
            let axes = [rng.point(-1.0, 1.0), rng.point(-1.0, 1.0)];
            let place = |u: f64, v: f64| add([80.0, 90.0, 4.0], add(scale(axes[0], u), scale(axes[1], v)));
            let (s, t) =
                ([place(0.0, 0.0), place(1.0, 0.0), place(0.0, 1.0)], [1.5, 2.0, 2.5].map(|u| place(u, 1.5 * u - 2.0)));
            let (p, q) = closest_pair(s, t);
            // The second lies beyond the line u + v = 1.75, the first within u + v ≤ 1.
            let n = cross(axes[0], axes[1]);
            let across = cross(sub(axes[1], axes[0]), n);
            let least = (0.75 * dot(axes[0], across) / dot(across, across).sqrt()).abs();
            assert!(distance(p, q) >= least * (1.0 - 1e-9), "{} {least}", distance(p, q));
        }
    }

    #[test]
    fn degenerate_triangles_are_points_and_segments() {
        let point = [[0.0, 0.0, 2.0]; 3];
        let segment = [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
        let face = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]];
        for (s, t, d) in [(point, face, 2.0), (segment, face, 1.0), (point, segment, 1.0)] {
            let (p, q) = closest_pair(s, t);
            assert!((distance(p, q) - d).abs() < 1e-15);
        }
    }
}
