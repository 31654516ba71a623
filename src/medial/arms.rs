//! Whether a closed curve of a plane is made of arms with parallel sides, as a cross or a bent strip is.

/// Places along the curve from which is looked across.
const PLACES: usize = 64;
/// Of these so many at least see a side parallel to their own.
const ARMS: usize = PLACES / 5;
/// Cosine of the angle between the normals of two sides up to which they are parallel: sides that lean by more run out, or are a wedge's.
const PARALLEL: f64 = -0.985;

type Point = [f64; 2];

/// Whether a fifth of a closed curve is sides of arms: the largest circle within the curve that touches it there touches a side opposite,
/// within ten degrees of parallel.
///
/// The arms of a star are wedges: no such circle touches both of their sides at a right angle.
///
/// # Cost
/// O(corners), 64 times.
pub(super) fn has_arms(curve: &[Point]) -> bool {
    let n = curve.len();
    let sides = || (0..n).map(|i| (curve[i], curve[(i + 1) % n]));
    let turning: f64 = sides().map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum();
    let around: f64 = sides().map(|(p, q)| norm(sub(q, p))).sum();
    let stride = around / PLACES as f64;
    let (mut next, mut walled) = (0.5 * stride, 0);
    for (a, b) in sides() {
        let (d, long) = (sub(b, a), norm(sub(b, a)));
        let inward = scale([-d[1], d[0]], turning.signum() / long.max(f64::MIN_POSITIVE));
        while next < long {
            let place = [a[0] + d[0] * next / long, a[1] + d[1] * next / long];
            walled += usize::from(faces(place, inward, sides(), turning.signum()));
            next += stride;
        }
        next -= long;
    }
    walled >= ARMS
}

/// Whether the largest circle that touches the curve at a place touches a side parallel to that there as well.
fn faces(place: Point, inward: Point, sides: impl Iterator<Item = (Point, Point)>, sign: f64) -> bool {
    // Radius of the circle, and the cosine of the angle between the inward normals of its two contacts.
    let mut least = (f64::INFINITY, 1.0);
    for (a, b) in sides {
        let (d, to) = (sub(b, a), sub(place, a));
        let long = norm(d);
        let normal = scale([-d[1], d[0]], sign / long.max(f64::MIN_POSITIVE));
        let (height, cosine) = (dot(normal, to), dot(normal, inward));
        let radius = height / (1.0 - cosine);
        let along = dot(d, to) + radius * dot(d, inward);
        if height > 0.0 && cosine < 1.0 - 1e-9 && radius < least.0 && (0.0..=long * long).contains(&along) {
            least = (radius, cosine);
        }
        let corner = sub(a, place);
        let ahead = dot(corner, inward);
        let radius = dot(corner, corner) / (2.0 * ahead);
        if ahead > 1e-9 * norm(corner) && radius < least.0 {
            // From the corner to the circle's centre.
            let back = sub(scale(inward, radius), corner);
            least = (radius, dot(back, inward) / radius);
        }
    }
    least.1 <= PARALLEL
}

fn sub(p: Point, q: Point) -> Point {
    [p[0] - q[0], p[1] - q[1]]
}

fn scale(p: Point, by: f64) -> Point {
    [p[0] * by, p[1] * by]
}

fn dot(p: Point, q: Point) -> f64 {
    p[0] * q[0] + p[1] * q[1]
}

fn norm(p: Point) -> f64 {
    p[0].hypot(p[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crosses_and_bent_strips_have_arms_and_stars_have_none() {
        let star = |points: usize, inner: f64| -> Vec<Point> {
            let at = |k: usize| (std::f64::consts::PI * k as f64 / points as f64).sin_cos();
            (0..2 * points)
                .map(|k| (at(k), if k % 2 == 0 { 0.7 } else { inner }))
                .map(|((s, c), r)| [r * c, r * s])
                .collect()
        };
        for (points, inner) in
            [(3, 0.2), (4, 0.35), (4, 0.2), (5, 0.4), (5, 0.2), (6, 0.4), (6, 0.3), (8, 0.4), (12, 0.4)]
        {
            let mut curve = star(points, inner);
            assert!(!has_arms(&curve), "{points} {inner}");
            curve.reverse();
            assert!(!has_arms(&curve), "{points} {inner}");
        }
        // Lobes as those of a hexalobular drive, of as many facets as they may have.
        for (deep, facets) in [(0.1, 60), (0.15, 120), (0.15, 480)] {
            let at = |k: i32| std::f64::consts::TAU * f64::from(k) / f64::from(facets);
            let lobes = (0..facets).map(|k| (0.6 + deep * (6.0 * at(k)).cos(), at(k).sin_cos()));
            assert!(!has_arms(&lobes.map(|(r, (s, c))| [r * c, r * s]).collect::<Vec<_>>()), "{deep} {facets}");
        }
        let cross = |h: f64| {
            let corner = [[h, h], [h, 0.7], [-h, 0.7]];
            let turn = |[x, y]: Point, n: usize| (0..n).fold([x, y], |[x, y], _| [-y, x]);
            (0..4).flat_map(|n| corner.map(|p| turn(p, n))).collect::<Vec<_>>()
        };
        let bent = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.3], [0.3, 0.3], [0.3, 1.0], [0.0, 1.0]];
        assert!(has_arms(&cross(0.1)) && has_arms(&cross(0.2)) && has_arms(&bent));
        // A ring with a slit, by chords.
        let arc = |r: f64| (0..=40).map(move |k| (0.15 * f64::from(k)).sin_cos()).map(move |(s, c)| [r * c, r * s]);
        let ring: Vec<Point> = arc(1.0).chain(arc(0.7).collect::<Vec<_>>().into_iter().rev()).collect();
        assert!(has_arms(&ring));
    }
}
