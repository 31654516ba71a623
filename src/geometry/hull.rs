//! The convex hull of points of a plane: its area, its widths, its depth.

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
    pub fn widths(&self) -> (f64, f64) {
        let longest = self.0.iter().flat_map(|p| self.0.iter().map(move |q| distance(*p, *q))).fold(0.0, f64::max);
        let across = |(p, q): (Point, Point)| {
            let length = distance(p, q);
            (length > 0.0).then(|| self.0.iter().map(|r| turn(p, q, *r) / length).fold(0.0, f64::max))
        };
        let least = self.edges().filter_map(across).fold(f64::INFINITY, f64::min);
        (if self.0.len() < 3 { 0.0 } else { least }, longest)
    }

    /// Distance of a point from the boundary: positive inside, negative outside; −∞ for the empty hull.
    pub fn depth(&self, point: Point) -> f64 {
        let nearest = self.edges().map(|(p, q)| to_segment(point, p, q)).fold(f64::INFINITY, f64::min);
        let inside = self.0.len() > 2 && self.edges().all(|(p, q)| turn(p, q, point) >= 0.0);
        if inside { nearest } else { -nearest }
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
    fn segments_points_and_nothing_have_no_width() {
        for points in [vec![], vec![[1.0, 2.0]], vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]] {
            let hull = Hull::of(points);
            assert_eq!((hull.area(), hull.widths().0), (0.0, 0.0));
            assert!(hull.depth([0.5, 0.7]) < 0.0);
        }
    }
}
