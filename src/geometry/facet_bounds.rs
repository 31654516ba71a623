//! Lower bounds on the distances of the four facets of a leaf, in f32 and at once: most facets of a leaf that is near are
//! themselves too far, and need no exact distance.

use super::vector::{Vec3, cross, dot, norm2, scale, sub};

/// Facets that are bounded at once; four f32 are what every processor takes in one step.
pub const LANES: usize = 4;

/// What rounding to f32 may add to a squared distance, relative to the squares it is made of: some thirty steps.
const ROUNDING: f32 = 4e-6;

/// Barycentric coordinates this far outside count as inside, where the plane's distance is the lower bound.
const NEARLY: f32 = 1e-2;

/// A triangle whose first corner has a squared sine below this is taken for its edges, thickened by its least height.
const NEEDLE: f64 = 1e-2;

/// Squared doubled areas that f32 holds the inverse of, with room.
const HELD: std::ops::Range<f64> = 1e-30..1e30;

/// Radii are no greater for the bounds, so that their squares are finite.
const FARTHEST: f64 = 1e18;

/// One number for each facet.
type Lanes = [f32; LANES];

/// Four triangles `a + s·u + t·v`, s, t ≥ 0, s + t ≤ 1, by what their distances are computed from.
#[derive(Debug, Clone, Copy)]
pub struct FacetBounds {
    /// What coordinates are relative to, for f32's sake.
    origin: Vec3,
    a: [Lanes; 3],
    u: [Lanes; 3],
    v: [Lanes; 3],
    normal: [Lanes; 3],
    /// u·u, u·v, v·v and |v − u|².
    uu: Lanes,
    uv: Lanes,
    vv: Lanes,
    ww: Lanes,
    /// One over u·u, v·v, |v − u|² and their determinant; that is no number for a needle.
    over_uu: Lanes,
    over_vv: Lanes,
    over_ww: Lanes,
    over_det: Lanes,
    /// The least height of a needle, else 0.
    height: Lanes,
}

impl FacetBounds {
    /// The bounds of at most four triangles.
    pub fn of(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> Self {
        let (none, still) = ([0.0; LANES], [[0.0; LANES]; 3]);
        let mut bounds = FacetBounds {
            origin: [0.0; 3],
            a: still,
            u: still,
            v: still,
            normal: still,
            uu: none,
            uv: none,
            vv: none,
            ww: none,
            over_uu: none,
            over_vv: none,
            over_ww: none,
            over_det: [f32::NAN; LANES],
            height: none,
        };
        for (lane, triangle) in triangles.into_iter().take(LANES).enumerate() {
            if lane == 0 {
                bounds.origin = triangle[0];
            }
            bounds.set(lane, triangle);
        }
        bounds
    }

    fn set(&mut self, lane: usize, [a, b, c]: [Vec3; 3]) {
        let (from, u, v) = (sub(a, self.origin), sub(b, a), sub(c, a));
        let (uu, uv, vv, ww) = (norm2(u), dot(u, v), norm2(v), norm2(sub(v, u)));
        let across = cross(u, v);
        let det = norm2(across);
        let needle = det <= NEEDLE * uu * vv || !HELD.contains(&det);
        let normal = if needle { [0.0; 3] } else { scale(across, 1.0 / det.sqrt()) };
        for i in 0..3 {
            (self.a[i][lane], self.normal[i][lane]) = (from[i] as f32, normal[i] as f32);
            (self.u[i][lane], self.v[i][lane]) = (u[i] as f32, v[i] as f32);
        }
        let over = |x: f64| if x > HELD.start { (1.0 / x) as f32 } else { 0.0 };
        (self.uu[lane], self.uv[lane], self.vv[lane], self.ww[lane]) = (uu as f32, uv as f32, vv as f32, ww as f32);
        (self.over_uu[lane], self.over_vv[lane], self.over_ww[lane]) = (over(uu), over(vv), over(ww));
        if needle {
            let longest = uu.max(vv).max(ww);
            self.height[lane] = if longest > 0.0 { ((det / longest).sqrt() as f32).next_up() } else { 0.0 };
        } else {
            self.over_det[lane] = (1.0 / det) as f32;
        }
    }

    /// Whether each facet may be at most `radius` from a point; `false` is certain.
    ///
    /// With w = p − a: the foot's distance on the plane is |w·n|; on an edge e it is |w|² − 2 k (w·e) + k² |e|², squared,
    /// for k = w·e / |e|² within 0 … 1. What rounding may have added is taken off.
    #[inline]
    pub fn may_be_within(&self, p: Vec3, radius: f64) -> [bool; LANES] {
        let from = sub(p, self.origin).map(|x| x as f32);
        let radius = radius.min(FARTHEST) as f32;
        let least =
            radius * radius * (1.0 + ROUNDING) + ROUNDING * (from[0] * from[0] + from[1] * from[1] + from[2] * from[2]);
        let mut out = [0f32; LANES];
        for (i, out) in out.iter_mut().enumerate() {
            let w = [from[0] - self.a[0][i], from[1] - self.a[1][i], from[2] - self.a[2][i]];
            let along = |e: &[Lanes; 3]| w[0] * e[0][i] + w[1] * e[1][i] + w[2] * e[2][i];
            let (wu, wv, plane) = (along(&self.u), along(&self.v), along(&self.normal));
            let w2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
            let (uu, uv, vv) = (self.uu[i], self.uv[i], self.vv[i]);
            let on_u = to_edge(w2, wu, uu, self.over_uu[i]);
            let on_v = to_edge(w2, wv, vv, self.over_vv[i]);
            let between = to_edge(w2 - wu - wu + uu, wv - wu - uv + uu, self.ww[i], self.over_ww[i]);
            let edges = smaller(smaller(on_u, on_v), between);
            let s = (vv * wu - uv * wv) * self.over_det[i];
            let t = (uu * wv - uv * wu) * self.over_det[i];
            let inside = (s >= -NEARLY) & (t >= -NEARLY) & (s + t <= 1.0 + NEARLY);
            let found = if inside { plane * plane } else { edges };
            let height = self.height[i];
            *out = found - height * (radius + radius + height) - ROUNDING * (w2 + uu + vv);
        }
        // What is no number may be anything.
        out.map(|bound| bound <= least || bound.is_nan())
    }
}

/// The squared distance to an edge e from a point at w, by |w|², w·e, |e|² and one over that.
#[inline(always)]
fn to_edge(w2: f32, we: f32, ee: f32, over: f32) -> f32 {
    let k = we * over;
    let k = if k > 0.0 { k } else { 0.0 };
    let k = if k < 1.0 { k } else { 1.0 };
    w2 - k * (we + we - k * ee)
}

/// A comparison that a processor has for all lanes at once.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::super::triangle::closest_point;
    use super::super::vector::{add, distance};
    use super::*;
    use crate::random::Lcg;

    #[test]
    fn no_facet_within_the_radius_is_passed_over() {
        let mut random = Lcg(7);
        let (mut within, mut passed_over, mut all) = (0, 0, 0);
        for case in 0..200_000 {
            let size = 10f64.powf(15.0 * random.unit() - 9.0);
            let point = |random: &mut Lcg, size: f64| random.point(-size, size);
            let base = point(&mut random, 100.0 * size);
            let triangle = |random: &mut Lcg| {
                let [a, b, c] = [0; 3].map(|_| add(base, point(random, size)));
                match case % 5 {
                    // A needle, a cap, a segment.
                    0 => [a, b, add(a, scale(point(random, 1.0), 1e-4 * size))],
                    1 => [a, b, add(scale(add(a, b), 0.5), point(random, 1e-3 * size))],
                    2 => [a, b, a],
                    _ => [a, b, c],
                }
            };
            let four = [0; LANES].map(|_| triangle(&mut random));
            let bounds = FacetBounds::of(four);
            let far = size * 10f64.powf(6.0 * random.unit() - 3.0);
            let p = add(base, point(&mut random, far));
            let far = four.map(|t| distance(p, closest_point(p, t)));
            let radius = far[case % LANES];
            for (d, may) in far.iter().zip(bounds.may_be_within(p, radius)) {
                assert!(may || *d > radius, "{p:?} {four:?} {d} {radius}");
                within += usize::from(*d <= radius);
                passed_over += usize::from(!may);
                all += 1;
            }
            assert_eq!(bounds.may_be_within(p, f64::INFINITY), [true; LANES]);
        }
        println!("{all} distances, {within} within, {passed_over} passed over");
        assert!(passed_over as f64 > 0.8 * (all - within) as f64);
    }

    #[test]
    fn numbers_beyond_f32_are_passed_over_only_rightly() {
        for size in [1e-30, 1e-12, 1e12, 1e25] {
            let triangle = [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]];
            let bounds = FacetBounds::of([triangle]);
            for p in [[0.2 * size, 0.2 * size, 0.0], [0.0, 0.0, 0.5 * size], [2.0 * size, 0.0, 0.0]] {
                let d = distance(p, closest_point(p, triangle));
                assert!(bounds.may_be_within(p, d)[0], "{size} {p:?}");
            }
        }
    }
}
