//! The convex hull of points of a plane: its area, its widths, its depth.

use crate::units::Angle;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A point of the plane.
pub type Point = [f64; 2];

/// The convex hull of points of a plane, counter-clockwise without collinear corners.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Hull(Vec<Point>);

impl Hull {
    /// The hull of a set of points.
    ///
    /// # Cost
    /// O(n log n).
    ///
    /// # Source
    /// A. M. Andrew, *Another efficient algorithm for convex hulls in two dimensions*, 1979.
    pub fn of(points: impl IntoIterator<Item = Point>) -> Self {
        let mut sorted: Vec<Point> = points.into_iter().filter(|p| p.iter().all(|c| c.is_finite())).collect();
        sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        sorted.dedup();
        if sorted.len() < 3 {
            return Hull(sorted);
        }
        let mut hull: Vec<Point> = Vec::new();
        let half = |hull: &mut Vec<Point>, points: &mut dyn Iterator<Item = &Point>| {
            let base = hull.len();
            for &p in points {
                while hull.len() >= base + 2 && turn(hull[hull.len() - 2], hull[hull.len() - 1], p) <= 0.0 {
                    hull.pop();
                }
                hull.push(p);
            }
            hull.pop();
        };
        half(&mut hull, &mut sorted.iter());
        half(&mut hull, &mut sorted.iter().rev());
        Hull(hull)
    }

    /// Corners, counter-clockwise.
    pub fn corners(&self) -> &[Point] {
        &self.0
    }

    fn edges(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        (0..self.0.len()).map(|i| (self.0[i], self.0[(i + 1) % self.0.len()]))
    }

    /// Area.
    pub fn area(&self) -> f64 {
        let first = self.0.first().copied().unwrap_or_default();
        self.edges().map(|(p, q)| 0.5 * turn(first, p, q)).sum()
    }

    /// Least and greatest distance of two parallel lines that hold the hull between them; the least one touches an edge.
    ///
    /// Corners nearer to each other than a billionth of the hull count as one.
    ///
    /// # Cost
    /// O(n): the corner opposite to an edge moves on with the edge.
    ///
    /// # Source
    /// M. I. Shamos, *Computational geometry*, 1978.
    pub fn widths(&self) -> (f64, f64) {
        let corners = self.apart();
        let n = corners.len();
        if n < 3 {
            return (0.0, self.0.first().zip(self.0.last()).map_or(0.0, |(p, q)| distance(*p, *q)));
        }
        let height = |c: &usize| turn(corners[0], corners[1], corners[*c]);
        let mut opposite = (0..n).max_by(|a, b| height(a).total_cmp(&height(b))).unwrap_or(0);
        let (mut least, mut greatest) = (f64::INFINITY, 0.0f64);
        for i in 0..n {
            let (p, q) = (corners[i], corners[(i + 1) % n]);
            for _ in 0..n {
                let next = (opposite + 1) % n;
                if turn(p, q, corners[next]) < turn(p, q, corners[opposite]) {
                    break;
                }
                opposite = next;
                greatest = greatest.max(distance(p, corners[opposite])).max(distance(q, corners[opposite]));
            }
            let far = corners[opposite];
            greatest = greatest.max(distance(p, far)).max(distance(q, far));
            least = least.min(turn(p, q, far) / distance(p, q));
        }
        (least, greatest)
    }

    /// How many times as long as wide the hull is: its extent across its least width over that width; infinite without a width.
    ///
    /// A rectangle has the ratio of its sides, a regular hexagon 2/√3.
    ///
    /// # Cost
    /// O(n²) in its corners.
    ///
    /// ```
    /// use amcheck::geometry::Hull;
    /// let hull = Hull::of([[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]]);
    /// assert!((hull.aspect() - 1.5).abs() < 1e-12);
    /// ```
    pub fn aspect(&self) -> f64 {
        let corners = self.apart();
        let spread = |along: [f64; 2]| {
            let heights = corners.iter().map(|c| along[0] * c[0] + along[1] * c[1]);
            let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            high - low
        };
        let sides = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(p, q)| [q[0] - p[0], q[1] - p[1]]);
        let widths = sides.map(|way| (spread([-way[1], way[0]]) / way[0].hypot(way[1]), way));
        let least = widths.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|least| least.0 > 0.0);
        least.map_or(f64::INFINITY, |(width, way)| spread(way) / way[0].hypot(way[1]) / width)
    }

    /// The corners without those right beside another: between these no direction is known.
    fn apart(&self) -> Vec<Point> {
        let near = self.nothing();
        let mut corners = self.0.clone();
        corners.dedup_by(|a, b| distance(*a, *b) <= near);
        while corners.len() > 1 && distance(corners[0], corners[corners.len() - 1]) <= near {
            corners.pop();
        }
        corners
    }

    /// The hull of those corners that lie off the line of their neighbours by more than rounding puts them there: a little less than this
    /// hull, and all its corners are corners of this.
    pub fn sharpened(&self) -> Hull {
        let near = self.nothing();
        let mut kept: Vec<Point> = Vec::new();
        for (i, &p) in self.0.iter().enumerate() {
            let next = self.0[(i + 1) % self.0.len()];
            let before = kept.last().or(self.0.last()).copied().unwrap_or(p);
            if turn(before, p, next) > near * distance(before, next) {
                kept.push(p);
            }
        }
        Hull(kept)
    }

    /// What a length is that rounding may make, beside the hull.
    fn nothing(&self) -> f64 {
        let side = |a: usize| {
            let ends =
                self.0.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| (lo.min(p[a]), hi.max(p[a])));
            ends.1 - ends.0
        };
        1e-9 * side(0).max(side(1))
    }

    /// Distance of a point from the boundary: positive inside, negative outside; −∞ for the empty hull.
    pub fn depth(&self, point: Point) -> f64 {
        let nearest = self.edges().map(|(p, q)| to_segment(point, p, q)).fold(f64::INFINITY, f64::min);
        let inside = self.0.len() > 2 && self.edges().all(|(p, q)| turn(p, q, point) >= 0.0);
        if inside { nearest } else { -nearest }
    }
}

/// The least share of a rectangle's sides that a hull takes as it is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Of the side of which more is taken; 1 is just full.
    pub share: f64,
    /// By so much the hull is turned, counter-clockwise; from 0 to less than half a turn.
    pub turn: Angle,
}

impl Hull {
    /// min { max (w(θ)/x, d(θ)/y) : θ }, with the extents w, d of the hull turned by θ and the sides x, y of a rectangle.
    ///
    /// Between two turns at which an edge of the hull is parallel to a side, each extent is that of one pair of corners and concave in θ: the
    /// greater of the two is least at an end or where they are equal.
    ///
    /// # Cost
    /// O(n log n).
    pub fn fit(&self, sides: [f64; 2]) -> Fit {
        let corners = self.apart();
        let n = corners.len();
        let direction = |i: usize| {
            let ([ax, ay], [bx, by]) = (corners[i], corners[(i + 1) % n]);
            (by - ay).atan2(bx - ax)
        };
        let edges: Vec<f64> = (0..n).map(direction).collect();
        let first = edges.first().copied().unwrap_or(0.0);
        let from_first: Vec<f64> = edges.iter().map(|e| (e - first).rem_euclid(TAU)).collect();
        // The corner farthest along a direction is where the first edge starts that turns off it to the left by a right angle or more.
        let farthest = |along: f64| {
            let turned = (along + FRAC_PI_2 - first).rem_euclid(TAU);
            corners.get(from_first.partition_point(|e| *e < turned) % n.max(1)).copied().unwrap_or_default()
        };
        let across = |along: f64| {
            let ([ax, ay], [bx, by]) = (farthest(along + PI), farthest(along));
            [bx - ax, by - ay]
        };
        let mut ends: Vec<f64> =
            edges.iter().flat_map(|e| [(-e).rem_euclid(PI), (FRAC_PI_2 - e).rem_euclid(PI)]).collect();
        ends.extend([0.0, PI]);
        ends.sort_by(f64::total_cmp);
        let mut best = Fit { share: f64::INFINITY, turn: Angle::default() };
        for (from, to) in ends.iter().zip(ends.iter().skip(1)) {
            // The hull turned by θ has the extents of the hull along directions turned by −θ.
            let middle = 0.5 * (from + to);
            let ([wx, wy], [dx, dy]) = (across(-middle), across(FRAC_PI_2 - middle));
            let shares = |t: f64| {
                let (sin, cos) = t.sin_cos();
                [(wx * cos - wy * sin) / sides[0], (dx * sin + dy * cos) / sides[1]]
            };
            let equal = (wx / sides[0] - dy / sides[1]).atan2(wy / sides[0] + dx / sides[1]).rem_euclid(PI);
            for t in [*from, *to, equal.clamp(*from, *to)] {
                let share = shares(t).into_iter().fold(0.0, f64::max);
                if share < best.share * (1.0 - 1e-12) && t < PI {
                    best = Fit { share, turn: Angle::radians(t) };
                }
            }
        }
        best
    }

    /// The share of a rectangle's sides that the hull takes, turned by an angle.
    pub fn share(&self, sides: [f64; 2], turn: Angle) -> f64 {
        let (sin, cos) = turn.as_radians().sin_cos();
        let extent = |of: &dyn Fn(&Point) -> f64| {
            let (lo, hi) =
                self.0.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), c| (lo.min(c), hi.max(c)));
            (hi - lo).max(0.0)
        };
        let (w, d) = (extent(&|p| p[0] * cos - p[1] * sin), extent(&|p| p[0] * sin + p[1] * cos));
        (w / sides[0]).max(d / sides[1])
    }
}

/// Twice the area of the triangle, positive if it turns to the left.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn distance(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

fn to_segment(x: Point, p: Point, q: Point) -> f64 {
    let (d, length2) = ([q[0] - p[0], q[1] - p[1]], (q[0] - p[0]).powi(2) + (q[1] - p[1]).powi(2));
    let t = if length2 > 0.0 { ((x[0] - p[0]) * d[0] + (x[1] - p[1]) * d[1]) / length2 } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    distance(x, [p[0] + t * d[0], p[1] + t * d[1]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Lcg;

    #[test]
    fn the_hull_of_a_rectangle_with_points_inside() {
        let mut points = vec![[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0], [2.0, 0.0], [1.0, 1.0], [4.0, 3.0]];
        points.extend((0..20).map(|i| [0.1 + 0.19 * i as f64, 0.1 + 0.13 * i as f64]));
        let hull = Hull::of(points);
        assert_eq!(hull.corners().len(), 4);
        assert!((hull.area() - 12.0).abs() < 1e-12);
        assert_eq!(hull.widths(), (3.0, 5.0));
        assert!((hull.depth([2.0, 1.0]) - 1.0).abs() < 1e-12 && (hull.depth([5.0, 1.0]) + 1.0).abs() < 1e-12);
        assert!((hull.depth([7.0, 7.0]) + 5.0).abs() < 1e-12);
    }

    #[test]
    fn the_best_fit_is_no_worse_than_any_of_3600_turns_and_one_of_them_is_near() {
        let mut random = Lcg(23);
        for round in 0..300 {
            let squeeze = [1.0, 0.3, 0.01, 0.0][round % 4];
            let n = [2, 3, 5, 40][round / 4 % 4];
            let hull = Hull::of((0..n).map(|_| [random.unit(), squeeze * random.unit()]));
            let sides = [[1.0, 1.0], [1.0, 0.4], [0.2, 3.0]][round % 3];
            let fit = hull.fit(sides);
            assert!((hull.share(sides, fit.turn) - fit.share).abs() < 1e-9, "{hull:?} {fit:?}");
            let all = (0..3600).map(|t| hull.share(sides, Angle::degrees(0.05 * f64::from(t))));
            let least = all.fold(f64::INFINITY, f64::min);
            let step = 0.05f64.to_radians() * 1.5 / sides[0].min(sides[1]);
            assert!(fit.share <= least + 1e-12 && least <= fit.share + step, "{hull:?} {fit:?} {least}");
        }
    }

    #[test]
    fn a_bar_lies_along_the_diagonal() {
        let bar = Hull::of([[0.0, 0.0], [290.0, 0.0], [290.0, 8.0], [0.0, 8.0]]);
        let fit = bar.fit([220.0, 220.0]);
        assert!((fit.share - 298.0 / 2f64.sqrt() / 220.0).abs() < 1e-12 && (fit.turn.as_degrees() - 45.0).abs() < 1e-9);
        // Along a rectangle's sides, or across them.
        assert_eq!(bar.fit([400.0, 10.0]).turn.as_degrees(), 0.0);
        assert!((bar.fit([10.0, 400.0]).turn.as_degrees() - 90.0).abs() < 1e-9);
        assert!(Hull::of([[1.0, 2.0]]).fit([1.0, 1.0]).share == 0.0 && Hull::default().fit([1.0; 2]).share == 0.0);
    }

    #[test]
    fn widths_are_those_of_all_pairs() {
        let mut random = Lcg(11);
        for round in 0..400 {
            let squeeze = [1.0, 0.3, 0.01, 1e-6][round % 4];
            let on_circle = round % 3 == 0;
            let point = |random: &mut Lcg| {
                let [a, b] = [random.unit(), random.unit()];
                let (s, c) = (std::f64::consts::TAU * a).sin_cos();
                if on_circle { [c, squeeze * s] } else { [a + 1e-12 * b, squeeze * (b - a)] }
            };
            let hull = Hull::of((0..3 + round % 60).map(|_| point(&mut random)));
            let c = hull.corners();
            let across = |(p, q): (Point, Point)| c.iter().map(|r| turn(p, q, *r) / distance(p, q)).fold(0.0, f64::max);
            let least = hull.edges().map(across).fold(f64::INFINITY, f64::min);
            let greatest = c.iter().flat_map(|p| c.iter().map(|q| distance(*p, *q))).fold(0.0, f64::max);
            let found = hull.widths();
            let is_near = |a: f64, b: f64| (a - b).abs() <= 1e-8 * greatest;
            assert!(is_near(found.0, least) && is_near(found.1, greatest), "{found:?} {least} {greatest} {c:?}");
            let sharp = hull.sharpened();
            let is_same = squeeze < 1e-3 || is_near(sharp.widths().0, least) && is_near(sharp.widths().1, greatest);
            assert!(is_same && sharp.corners().iter().all(|p| c.contains(p)), "{sharp:?} {hull:?}");
        }
        let ring = (0..1000).map(|k| (std::f64::consts::TAU * f64::from(k) / 1000.0).sin_cos()).map(|(s, c)| [c, s]);
        let (least, greatest) = Hull::of(ring).widths();
        assert!((least - 2.0).abs() < 2e-5 && (greatest - 2.0).abs() < 1e-12);
    }

    #[test]
    fn segments_points_and_nothing_have_no_width() {
        for points in [vec![], vec![[1.0, 2.0]], vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]] {
            let hull = Hull::of(points);
            assert_eq!((hull.area(), hull.widths().0), (0.0, 0.0));
            assert!(hull.depth([0.5, 0.7]) < 0.0);
        }
    }
}
