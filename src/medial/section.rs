//! Plane sections of a surface: the closed curve around a point.

use super::axes::least_axis;
use super::chord::WALL_SEPARATION;
use crate::geometry::vector::{Vec3, along, angle, cross, distance, dot, norm, scale, sub, unit};
use crate::geometry::{Adjacency, Hull, TriangleMesh};

/// Facets that a curve may cross before it is given up.
const LONGEST_CURVE: usize = 20_000;
/// Corners from which on a closed curve counts as a circle drawn with facets, if it is round.
const ROUND_CORNERS: usize = 8;
/// A round curve's circumscribed circle is at most this much larger than its inscribed one (an octagon: 1.082).
const ROUND: f64 = 1.09;

/// Curves whose circles differ by no more than this ratio are not looked at further.
const NEARLY_ROUND: f64 = 1.4;
/// A curve that fills less of its convex hull is a star, or bent: the hull's least width says nothing of how wide the curve is.
const FULL: f64 = 0.92;

/// A closed curve in which a plane cuts the surface, summed up.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Centroid of the area within the curve.
    pub centre: Vec3,
    /// Unit normal of the plane.
    pub axis: Vec3,
    /// Area within the curve, mm².
    pub area: f64,
    /// Diameter of the largest circle about the centroid within the curve.
    pub inscribed: f64,
    /// Diameter of the least circle about the centroid around the curve.
    pub circumscribed: f64,
    /// Corners of the curve that bend by more than a degree.
    pub corners: usize,
    /// Greatest over least width of the curve's convex hull; the ratio of the circumscribed to the inscribed diameter, which is no less, where
    /// that is up to 1.4, or where the curve fills less than 0.92 of its hull.
    pub elongation: f64,
    /// How many times as long as wide the curve's convex hull is: its extent across its least width over that; never more than `elongation`,
    /// and the same where the ratio of its circles is up to 1.4, or where the curve fills less than 0.92 of its hull and is bent: not all of
    /// it is seen from its centroid, as all of a star or a cross is.
    pub aspect: f64,
    /// Whether two of its sides face each other as those of a wall do; a curve of eight corners or more is taken to have such.
    pub is_faced: bool,
    /// The direction to which the normals along the curve are most nearly at right angles.
    pub grain: Vec3,
    /// Root mean square of the sine of the angle between the surface along the curve and that direction.
    pub taper: f64,
    /// A facet on the curve.
    pub facet: u32,
}

impl Section {
    /// Diameter of the circle of equal area.
    pub fn diameter(&self) -> f64 {
        2.0 * (self.area / std::f64::consts::PI).sqrt()
    }

    /// How much wider than [`Self::diameter`] the circle may be that the curve stands for: its corners lie on it at most; 0 for what
    /// is no circle.
    pub fn facet_loss(&self) -> f64 {
        let round = self.corners >= ROUND_CORNERS && self.circumscribed <= ROUND * self.inscribed;
        if round { self.circumscribed - self.diameter() } else { 0.0 }
    }
}

/// The plane of a section.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    pub point: Vec3,
    pub normal: Vec3,
}

/// The closed curve in which a plane cuts the surface, followed from a facet that it crosses.
///
/// `None` if the curve leaves the ball of radius `within` about the plane's point, ends at an edge without neighbour, or does not go
/// round the plane's point once.
///
/// # Cost
/// The facets along the curve.
pub fn section(mesh: &TriangleMesh, next: &Adjacency, plane: Plane, start: u32, within: f64) -> Option<Section> {
    let (points, facets) = curve(mesh, next, plane, start, within)?;
    summed_up(mesh, plane, &points, &facets)
}

/// The corners of such a curve, and the facet before each: that from which it comes there.
pub(super) fn curve(
    mesh: &TriangleMesh,
    next: &Adjacency,
    plane: Plane,
    start: u32,
    within: f64,
) -> Option<(Vec<Vec3>, Vec<u32>)> {
    let height = |v: u32| dot(sub(mesh.vertices[v as usize], plane.point), plane.normal);
    let mut points: Vec<Vec3> = Vec::new();
    let mut facets: Vec<u32> = Vec::new();
    let (mut facet, mut from) = (start, None);
    loop {
        let t = mesh.triangles.get(facet as usize)?;
        let h = t.map(height);
        // A corner in the plane is taken to stand just above it, so that two edges are crossed or none.
        let crossed = |e: &usize| (h[*e] >= 0.0) != (h[(e + 1) % 3] >= 0.0);
        let out = (0..3).filter(crossed).find(|&e| Some(e) != from && (from.is_some() || h[e] >= 0.0))?;
        let (a, b) = (mesh.vertices[t[out] as usize], mesh.vertices[t[(out + 1) % 3] as usize]);
        let p = along(a, sub(b, a), h[out] / (h[out] - h[(out + 1) % 3]));
        if distance(p, plane.point) > within || points.len() > LONGEST_CURVE {
            return None;
        }
        points.push(p);
        facets.push(facet);
        let onto = next.across(facet, out)?;
        let ends = [t[out], t[(out + 1) % 3]];
        let u = mesh.triangles.get(onto as usize)?;
        from = (0..3).find(|&e| ends.contains(&u[e]) && ends.contains(&u[(e + 1) % 3]));
        from?;
        facet = onto;
        if facet == start {
            return Some((points, facets));
        }
    }
}

/// Measures of a closed curve in a plane, or near it and dropped onto it; `None` unless it goes once round the plane's point.
pub(super) fn summed_up(mesh: &TriangleMesh, plane: Plane, points: &[Vec3], facets: &[u32]) -> Option<Section> {
    let u = unit(sub(points[0], along(plane.point, plane.normal, dot(sub(points[0], plane.point), plane.normal))));
    let v = cross(plane.normal, u);
    let flat: Vec<[f64; 2]> = points.iter().map(|p| sub(*p, plane.point)).map(|d| [dot(d, u), dot(d, v)]).collect();
    let n = flat.len();
    let side = |i: usize| (flat[i], flat[(i + 1) % n]);
    let (mut twice, mut moment, mut turns) = (0.0, [0.0; 2], 0.0);
    for (p, q) in (0..n).map(side) {
        let c = p[0] * q[1] - p[1] * q[0];
        twice += c;
        moment = [moment[0] + c * (p[0] + q[0]), moment[1] + c * (p[1] + q[1])];
        turns += c.atan2(p[0] * q[0] + p[1] * q[1]);
    }
    if (turns.abs() - std::f64::consts::TAU).abs() > 0.1 || twice == 0.0 {
        return None;
    }
    let middle = moment.map(|m| m / (3.0 * twice));
    let to = |p: [f64; 2]| (p[0] - middle[0]).hypot(p[1] - middle[1]);
    let inner = (0..n).map(side).map(|(p, q)| to(nearest_on(p, q, middle))).fold(f64::INFINITY, f64::min);
    let outer = flat.iter().map(|&p| to(p)).fold(0.0, f64::max);
    let mut m = [[0.0; 3]; 3];
    let (mut corners, mut around) = (0, 0.0);
    let mut sides: Vec<Vec3> = Vec::new();
    for i in 0..n {
        // Facet i+1 holds the stretch from point i to point i+1.
        let f = facets[(i + 1) % n] as usize;
        let (normal, length) = (mesh.normal(f), distance(points[i], points[(i + 1) % n]));
        (0..3).for_each(|r| (0..3).for_each(|c| m[r][c] += length * normal[r] * normal[c]));
        around += length;
        let before = mesh.normal(facets[i] as usize);
        if angle(before, normal) > 1f64.to_radians() {
            corners += 1;
            sides.push(normal);
        }
    }
    let faces = |a: &Vec3| sides.iter().any(|b| angle(*a, *b) >= WALL_SEPARATION);
    let grain = least_axis(m);
    let grain = if dot(grain, plane.normal) < 0.0 { scale(grain, -1.0) } else { grain };
    let form = dot(grain, [0, 1, 2].map(|r| dot(m[r], grain)));
    let [elongation, aspect] = elongated(&flat, middle, 0.5 * twice, outer / inner.max(1e-12));
    Some(Section {
        centre: [0, 1, 2].map(|a| plane.point[a] + middle[0] * u[a] + middle[1] * v[a]),
        axis: plane.normal,
        area: 0.5 * twice.abs(),
        inscribed: 2.0 * inner,
        circumscribed: 2.0 * outer,
        corners,
        elongation,
        aspect,
        is_faced: corners >= ROUND_CORNERS || sides.iter().any(faces),
        grain,
        taper: (form / around).max(0.0).sqrt(),
        facet: facets[0],
    })
}

/// How much wider a curve about such a middle is than its least width, and how much longer across that, from its area, positive if it runs
/// counter-clockwise, and the ratio of its circles.
fn elongated(curve: &[[f64; 2]], middle: [f64; 2], area: f64, ratio: f64) -> [f64; 2] {
    if ratio <= NEARLY_ROUND {
        return [ratio; 2];
    }
    let hull = Hull::of(curve.iter().copied());
    let (least, greatest) = hull.widths();
    match area.abs() >= FULL * hull.area() {
        _ if least <= 0.0 => [ratio; 2],
        true => [greatest / least, hull.aspect()],
        false if is_seen_from(curve, middle, area.signum()) => [ratio, hull.aspect()],
        false => [ratio; 2],
    }
}

/// Whether a curve that runs so way round goes round a point without turning back: from there all of it is seen.
fn is_seen_from(curve: &[[f64; 2]], [x, y]: [f64; 2], way: f64) -> bool {
    let next = curve.iter().cycle().skip(1);
    curve.iter().zip(next).all(|(p, q)| way * ((p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x)) >= 0.0)
}

/// The point of the segment pq nearest to c.
fn nearest_on(p: [f64; 2], q: [f64; 2], c: [f64; 2]) -> [f64; 2] {
    let d = [q[0] - p[0], q[1] - p[1]];
    let length2 = d[0] * d[0] + d[1] * d[1];
    let t = if length2 > 0.0 { ((c[0] - p[0]) * d[0] + (c[1] - p[1]) * d[1]) / length2 } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    [p[0] + t * d[0], p[1] + t * d[1]]
}

/// Eight unit vectors at right angles to an axis, evenly around it; none along [`across`]'s two, which facets' edges often follow.
pub fn eight_across(axis: Vec3) -> [Vec3; 8] {
    let [u, v] = across(axis);
    [0, 1, 2, 3, 4, 5, 6, 7].map(|k| {
        let (sin, cos) = (std::f64::consts::FRAC_PI_4 * f64::from(k) + 0.1).sin_cos();
        [0, 1, 2].map(|a| cos * u[a] + sin * v[a])
    })
}

/// Two unit vectors at right angles to a third and to each other.
pub fn across(axis: Vec3) -> [Vec3; 2] {
    let side = if axis[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let u = cross(axis, side);
    let u = scale(u, 1.0 / norm(u));
    [u, cross(axis, u)]
}
