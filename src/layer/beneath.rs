//! What a ceiling rests on from below, and what of it is left to span.

use super::line::Side;
use super::section::Point;
use crate::geometry::halfspace::cut;
use crate::geometry::vector::Vec3;
use rustc_hash::FxHashMap;

/// What holds hanging facets up that is no neighbour of theirs.
pub trait Ground: Sync {
    /// Whether all of a facet rests on something, so that what adjoins it is held.
    fn holds(&self, facet: u32) -> bool;

    /// The triangles closely below a facet on which a part of it rests.
    fn beneath(&self, facet: u32) -> Vec<[Vec3; 3]>;
}

/// Nothing but neighbours.
impl Ground for () {
    fn holds(&self, _: u32) -> bool {
        false
    }

    fn beneath(&self, _: u32) -> Vec<[Vec3; 3]> {
        Vec::new()
    }
}

/// The triangles of a triangle below a facet on which it rests: where that is in plan on an area wider than `narrow`, by a height within the
/// limits.
///
/// { (x, y) : in both in plan, least ≤ height ≤ most }: a convex polygon, cut where the height is the most. Where the two meet, none of it counts
/// unless all does: there the facet is held by what adjoins it, up to the line on which they meet.
pub fn resting_on(facet: [Vec3; 3], under: [Vec3; 3], [least, most]: [f64; 2], narrow: f64) -> Vec<[Vec3; 3]> {
    let limits = |t: [Vec3; 3], axis: usize| {
        let along = t.map(|p| p[axis]);
        [along.into_iter().fold(f64::INFINITY, f64::min), along.into_iter().fold(f64::NEG_INFINITY, f64::max)]
    };
    // How far the facet is beyond the triangle along an axis, at least and at most.
    let beyond = |axis: usize| {
        let [over, below] = [limits(facet, axis), limits(under, axis)];
        [over[0] - below[1], over[1] - below[0]]
    };
    let is_within = |[low, high]: [f64; 2], [least, most]: [f64; 2]| least <= high && low <= most;
    if !(is_within(beyond(0), [0.0; 2]) && is_within(beyond(1), [0.0; 2]) && is_within(beyond(2), [least, most])) {
        return Vec::new();
    }
    let (Some(over), Some(plane)) = (counter_clockwise(facet), Plane::of(facet)) else { return Vec::new() };
    let (Some(_), Some(ground)) = (counter_clockwise(under), Plane::of(under)) else { return Vec::new() };
    let polygon = common(under, over);
    let gap = |p: &Point| plane.height(*p) - ground.height(*p);
    let is_wide = |polygon: &[Point]| {
        let (area, sides) = measure(polygon);
        area > sides * narrow.max(1e-9 * sides)
    };
    let [lowest, highest] =
        polygon.iter().map(gap).fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], g| [l.min(g), h.max(g)]);
    if !is_wide(&polygon) || lowest < least {
        return Vec::new();
    }
    if highest <= most {
        return vec![under];
    }
    let meets = lowest <= least.abs();
    let near = if meets { Vec::new() } else { cut(&polygon, |p| most - gap(&p)) };
    let at = |n: usize| near.get(n).map_or([0.0; 3], |p| [p[0], p[1], ground.height(*p)]);
    let fan = (1..near.len().saturating_sub(1)).map(|n| [at(0), at(n), at(n + 1)]);
    if is_wide(&near) { fan.collect() } else { Vec::new() }
}

/// The share of a triangle in plan below which others lie, which do not overlap; at most 1.
pub fn share_below(facet: [Vec3; 3], under: &[[Vec3; 3]]) -> f64 {
    let Some(over) = counter_clockwise(facet) else { return 0.0 };
    let covered: f64 = under.iter().map(|&t| measure(&common(t, over)).0).sum();
    (covered / measure(&over).0).min(1.0)
}

/// What of a triangle in plan lies in a counter-clockwise one.
fn common(triangle: [Vec3; 3], over: [Point; 3]) -> Vec<Point> {
    let within = |polygon: Vec<Point>, n: usize| cut(&polygon, |x| left_of(over[n], over[(n + 1) % 3], x));
    (0..3).fold(triangle.map(in_plan).to_vec(), within)
}

/// The area of a convex polygon, and the distance of its farthest corner from its first.
fn measure(polygon: &[Point]) -> (f64, f64) {
    let turned = |w: &[Point]| match w {
        [a, b] => cross(*a, *b),
        _ => 0.0,
    };
    let origin = polygon.first().copied().unwrap_or_default();
    let own: Vec<Point> = polygon.iter().map(|p| [p[0] - origin[0], p[1] - origin[1]]).collect();
    let area = 0.5 * own.windows(2).map(turned).sum::<f64>();
    (area.abs(), own.iter().fold(0.0f64, |m, p| m.max(p[0].hypot(p[1]))))
}

/// A plane that is not upright, as a height over each place.
struct Plane {
    at: Vec3,
    slope: Point,
}

impl Plane {
    fn of([a, b, c]: [Vec3; 3]) -> Option<Self> {
        let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let (du, dv, area) = (b[2] - a[2], c[2] - a[2], cross(u, v));
        (area != 0.0).then(|| Plane { at: a, slope: [(du * v[1] - dv * u[1]) / area, (dv * u[0] - du * v[0]) / area] })
    }

    fn height(&self, p: Point) -> f64 {
        self.at[2] + self.slope[0] * (p[0] - self.at[0]) + self.slope[1] * (p[1] - self.at[1])
    }
}

/// A hanging facet in plan with what it rests on in part; all triangles run counter-clockwise.
pub(super) struct Resting {
    facet: u32,
    outline: [Point; 3],
    under: Vec<[Point; 3]>,
}

impl Resting {
    /// `None` for a facet that rests nowhere, or has no area in plan.
    pub fn of(facet: u32, corners: [Vec3; 3], ground: &impl Ground) -> Option<Self> {
        let outline = counter_clockwise(corners)?;
        let under: Vec<_> = ground.beneath(facet).into_iter().filter_map(counter_clockwise).collect();
        (!under.is_empty()).then_some(Resting { facet, outline, under })
    }

    /// Where along a segment it lies in the facet, and what that rests on beneath.
    fn beneath(&self, segment: [Point; 2]) -> impl Iterator<Item = [f64; 2]> {
        let within = stretch_in(segment, &self.outline);
        let under = within.into_iter().flat_map(|w| self.under.iter().map(move |t| (w, t)));
        under.filter_map(move |([from, to], t)| {
            let [a, b] = stretch_in(segment, t)?;
            let both = [a.max(from), b.min(to)];
            (both[0] < both[1]).then_some(both)
        })
    }
}

/// The boundary of a region less what rests, from the region's own sides with the facets that they belong to; a side of a step or a sliver,
/// which only carry the boundary on, has none.
///
/// ∂(R ∖ U), U the union of all that lies beneath: of R's sides what has R ∖ U on its right, and of the sides of U what has R ∖ U on its
/// right and U within R on its left; these are anchored. R lies on the right of its sides, as it does of facets that look down. A result
/// that does not close, as where a facet without area lies between, is given up for R itself: it spans more.
///
/// # Cost
/// O(sides + Σ over facets of (triangles beneath)² + anchored sides · sides + sides of steps · triangles beneath).
pub(super) fn left_to_span(sides: &[(Option<u32>, Side)], resting: &[Resting]) -> Vec<Side> {
    let whole: Vec<Side> = sides.iter().map(|(_, s)| *s).collect();
    if resting.is_empty() {
        return whole;
    }
    let extent = whole.iter().flat_map(|s| [s.from, s.to]).flatten().fold(0.0f64, |m, c| m.max(c.abs()));
    let aside = 1e-9 * extent;
    let of: FxHashMap<u32, &Resting> = resting.iter().map(|r| (r.facet, r)).collect();
    let mut left = Vec::new();
    for (facet, s) in sides {
        let side = [s.from, s.to];
        let covered = match facet {
            Some(f) => of.get(f).map_or_else(Vec::new, |r| stretches(side, aside, r.under.iter()).collect()),
            // Whichever facet of the region lies beside it.
            None => resting.iter().flat_map(|r| r.beneath(shifted(side, aside))).collect(),
        };
        let pieces = bare([s.from, s.to], [0.0, 1.0], covered);
        left.extend(pieces.map(|[from, to]| Side { from, to, ..*s }));
    }
    for r in resting {
        for (n, t) in r.under.iter().enumerate() {
            for e in 0..3 {
                let edge = [t[e], t[(e + 1) % 3]];
                let Some(within) = stretch_in(shifted(edge, aside), &r.outline) else { continue };
                let others = r.under.iter().enumerate().filter(|(m, _)| *m != n).map(|(_, t)| t);
                // An edge that several triangles have is the first one's: the others find that one on their left too.
                let earlier = stretches(edge, -aside, r.under.iter().take(n));
                let pieces = bare(edge, within, stretches(edge, aside, others).chain(earlier).collect());
                let inner = pieces.filter(|p| holds(&whole, middle(shifted(*p, -aside))));
                left.extend(inner.map(|[from, to]| Side { from, to, anchored: true }));
            }
        }
    }
    let sum = left.iter().fold([0.0; 2], |m, s| [m[0] + s.to[0] - s.from[0], m[1] + s.to[1] - s.from[1]]);
    if sum[0].hypot(sum[1]) <= 1e-6 * extent { left } else { whole }
}

/// Where along a segment, moved to its right, it lies in triangles.
fn stretches<'a>(
    segment: [Point; 2],
    aside: f64,
    triangles: impl Iterator<Item = &'a [Point; 3]>,
) -> impl Iterator<Item = [f64; 2]> {
    let beside = shifted(segment, aside);
    triangles.filter_map(move |t| stretch_in(beside, t))
}

/// What is left of a segment between two of its places without the covered stretches.
fn bare([a, b]: [Point; 2], [from, to]: [f64; 2], mut covered: Vec<[f64; 2]>) -> impl Iterator<Item = [Point; 2]> {
    covered.sort_by(|a, b| a[0].total_cmp(&b[0]));
    covered.push([to, to]);
    let mut at = from;
    let free = covered.into_iter().filter_map(move |[start, end]| {
        let stretch = [at, start.min(to)];
        at = at.max(end);
        (stretch[1] - stretch[0] > 1e-12).then_some(stretch)
    });
    // Ends stay those of the segment, to the bit, where nothing cuts it.
    let place = move |t: f64| match t {
        0.0 => a,
        1.0 => b,
        _ => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])],
    };
    free.map(move |stretch| stretch.map(place))
}

/// Where along a segment, from 0 to 1, it lies in a counter-clockwise triangle.
fn stretch_in([a, b]: [Point; 2], triangle: &[Point; 3]) -> Option<[f64; 2]> {
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for n in 0..3 {
        let (p, q) = (triangle[n], triangle[(n + 1) % 3]);
        let [at_a, at_b] = [a, b].map(|x| left_of(p, q, x));
        match (at_a >= 0.0, at_b >= 0.0) {
            (false, false) => return None,
            (true, true) => {}
            (false, true) => from = from.max(at_a / (at_a - at_b)),
            (true, false) => to = to.min(at_a / (at_a - at_b)),
        }
    }
    (from < to).then_some([from, to])
}

/// Whether a place lies in a region, by the sides that a line from it to the right crosses.
fn holds(sides: &[Side], x: Point) -> bool {
    let crosses = |s: &&Side| {
        let (a, b) = (s.from, s.to);
        (a[1] < x[1]) != (b[1] < x[1]) && a[0] + (b[0] - a[0]) * (x[1] - a[1]) / (b[1] - a[1]) > x[0]
    };
    sides.iter().filter(crosses).count() % 2 == 1
}

/// A segment moved to its right.
fn shifted([a, b]: [Point; 2], by: f64) -> [Point; 2] {
    let d = [b[0] - a[0], b[1] - a[1]];
    let l = d[0].hypot(d[1]).max(f64::MIN_POSITIVE);
    [a, b].map(|p| [p[0] + by * d[1] / l, p[1] - by * d[0] / l])
}

fn middle([a, b]: [Point; 2]) -> Point {
    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
}

/// A triangle in plan, turned if it has to be; `None` for one without area.
fn counter_clockwise(corners: [Vec3; 3]) -> Option<[Point; 3]> {
    let [a, b, c] = corners.map(in_plan);
    let turn = left_of(a, b, c);
    (turn != 0.0).then_some(if turn > 0.0 { [a, b, c] } else { [a, c, b] })
}

fn in_plan(p: Vec3) -> Point {
    [p[0], p[1]]
}

/// Positive where x lies left of the line from p to q.
fn left_of(p: Point, q: Point, x: Point) -> f64 {
    cross([q[0] - p[0], q[1] - p[1]], [x[0] - p[0], x[1] - p[1]])
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Lcg;

    /// A ceiling over [0, 12] × [0, 8] of triangles that look down, and a ground of boxes.
    struct Boxes(Vec<[f64; 4]>);

    const CEILING: [[Vec3; 3]; 2] =
        [[[0.0, 0.0, 5.0], [12.0, 8.0, 5.0], [12.0, 0.0, 5.0]], [[0.0, 0.0, 5.0], [0.0, 8.0, 5.0], [12.0, 8.0, 5.0]]];

    impl Boxes {
        fn tops(&self) -> Vec<[Vec3; 3]> {
            let top = |&[x0, x1, y0, y1]: &[f64; 4]| {
                let p = |x: f64, y: f64| [x, y, 4.9];
                [[p(x0, y0), p(x1, y0), p(x1, y1)], [p(x0, y0), p(x1, y1), p(x0, y1)]]
            };
            self.0.iter().flat_map(top).collect()
        }
    }

    impl Ground for Boxes {
        fn holds(&self, _: u32) -> bool {
            false
        }

        fn beneath(&self, facet: u32) -> Vec<[Vec3; 3]> {
            let on = |t| resting_on(CEILING[facet as usize], t, [0.0, 0.2], 0.0);
            self.tops().into_iter().flat_map(on).collect()
        }
    }

    /// What is left of the ceiling, its sides its own or those of steps.
    fn left(ground: &Boxes, own: impl Fn(u32) -> Option<u32>) -> Vec<Side> {
        let rim = |facet: u32, from: Point, to: Point| (own(facet), Side { from, to, anchored: false });
        let (a, b, c, d) = ([0.0, 0.0], [12.0, 0.0], [12.0, 8.0], [0.0, 8.0]);
        // The region lies right of its sides.
        let sides = [rim(0, c, b), rim(0, b, a), rim(1, a, d), rim(1, d, c)];
        let resting: Vec<Resting> = (0..2).filter_map(|f| Resting::of(f, CEILING[f as usize], ground)).collect();
        left_to_span(&sides, &resting)
    }

    #[test]
    fn what_is_left_is_the_ceiling_less_what_lies_below_it_and_is_anchored_there() {
        let mut random = Lcg(5);
        for case in 0..400 {
            // Every other ground lies on a lattice: flush with the ceiling and with itself.
            let coordinate = |random: &mut Lcg, lo: f64, hi: f64| {
                let x = lo + random.unit() * (hi - lo);
                if case % 2 == 0 { x.round() } else { x }
            };
            let mut boxes = Vec::new();
            for _ in 0..1 + case % 3 {
                let (x, y) = (coordinate(&mut random, -3.0, 12.0), coordinate(&mut random, -3.0, 8.0));
                let (w, d) = (coordinate(&mut random, 1.0, 6.0), coordinate(&mut random, 1.0, 6.0));
                boxes.push([x, x + w, y, y + d]);
            }
            let ground = Boxes(boxes);
            let sides = left(&ground, |f| Some(f).filter(|_| case % 4 < 2));
            let within = |p: Point| ground.0.iter().any(|b| b[0] < p[0] && p[0] < b[1] && b[2] < p[1] && p[1] < b[3]);
            for _ in 0..200 {
                let p = [14.0 * random.unit() - 1.0, 10.0 * random.unit() - 1.0];
                let inside = p[0] > 0.0 && p[0] < 12.0 && p[1] > 0.0 && p[1] < 8.0;
                assert_eq!(holds(&sides, p), inside && !within(p), "{case} {p:?} {:?}", ground.0);
            }
            let rim = |s: &Side| {
                let m = middle([s.from, s.to]);
                m[0].min(12.0 - m[0]).min(m[1]).min(8.0 - m[1]).abs() < 1e-9
            };
            assert!(sides.iter().all(|s| s.anchored != rim(s)), "{case} {sides:?} {:?}", ground.0);
        }
    }

    #[test]
    fn only_what_is_close_below_is_rested_on() {
        let facet = CEILING[0];
        let rests = |under: [Vec3; 3], narrow: f64| resting_on(facet, under, [0.0, 0.2], narrow);
        let at = |z: f64| [[6.0, 1.0, z], [9.0, 1.0, z], [9.0, 2.0, z]];
        assert!(rests(at(4.9), 0.0) == [at(4.9)] && rests(at(5.0), 0.0) == [at(5.0)]);
        assert!(rests(at(4.7), 0.0).is_empty() && rests(at(5.1), 0.0).is_empty());
        // One corner lies too low where the facet still is above it: the rest of it, cut at two thirds of the ways there.
        let area = |t: &[Vec3; 3]| {
            0.5 * ((t[1][0] - t[0][0]) * (t[2][1] - t[0][1]) - (t[1][1] - t[0][1]) * (t[2][0] - t[0][0]))
        };
        let sinking = [[6.0, 1.0, 4.9], [9.0, 1.0, 4.9], [9.0, 2.0, 4.75]];
        let left: f64 = rests(sinking, 0.0).iter().map(area).sum();
        assert!((left - 1.5 * (1.0 - 1.0 / 9.0)).abs() < 1e-12, "{left}");
        // Where it meets the facet at a corner, none of it.
        assert!(rests([[6.0, 1.0, 5.0], [9.0, 1.0, 4.9], [9.0, 2.0, 4.75]], 0.0).is_empty());
        // Beside the facet in plan, and upright.
        assert!(rests(at(4.9).map(|p| [p[0] - 6.0, p[1] + 5.0, p[2]]), 0.0).is_empty());
        assert!(rests([[6.0, 1.0, 4.9], [9.0, 1.0, 4.9], [9.0, 1.0, 3.0]], 0.0).is_empty());
        // All but upright: on a strip as wide as the wall leans.
        let leaning = [[6.0, 1.0, 4.9], [9.0, 1.0, 4.9], [9.0, 1.0 + 1e-5, 4.85]];
        assert!(!rests(leaning, 0.0).is_empty() && rests(leaning, 1e-4).is_empty());
    }
}
