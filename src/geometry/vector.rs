//! Vectors and points of three-space as plain arrays, millimetres, f64.

use std::cmp::Ordering;

/// A point or a vector.
pub type Vec3 = [f64; 3];

/// a + b.
#[inline]
pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b.
#[inline]
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// k·a.
#[inline]
pub fn scale(a: Vec3, k: f64) -> Vec3 {
    [a[0] * k, a[1] * k, a[2] * k]
}

/// a + k·b.
#[inline]
pub fn along(a: Vec3, b: Vec3, k: f64) -> Vec3 {
    [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]]
}

/// a · b.
#[inline]
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
#[inline]
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// |a|².
#[inline]
pub fn norm2(a: Vec3) -> f64 {
    dot(a, a)
}

/// |a|.
#[inline]
pub fn norm(a: Vec3) -> f64 {
    norm2(a).sqrt()
}

/// |a − b|.
#[inline]
pub fn distance(a: Vec3, b: Vec3) -> f64 {
    norm(sub(a, b))
}

/// a/|a|, or the zero vector if a has no direction.
#[inline]
pub fn unit(a: Vec3) -> Vec3 {
    let n = norm(a);
    if n > 0.0 && n.is_finite() { scale(a, 1.0 / n) } else { [0.0; 3] }
}

/// The angle between two directions in `[0, π]`, accurate also near 0 and π.
pub fn angle(a: Vec3, b: Vec3) -> f64 {
    norm(cross(a, b)).atan2(dot(a, b))
}

/// Order by x, then y, then z: an order of points that no file and no number of threads changes.
pub fn compare(a: Vec3, b: Vec3) -> Ordering {
    (0..3).fold(Ordering::Equal, |found, axis| found.then(a[axis].total_cmp(&b[axis])))
}

/// The least box over two boxes, each by its least and greatest corner.
pub fn hull(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> (Vec3, Vec3) {
    ([0, 1, 2].map(|x| a.0[x].min(b.0[x])), [0, 1, 2].map(|x| a.1[x].max(b.1[x])))
}

/// Componentwise least and greatest of a set of points; `None` for the empty set.
pub fn bounds(points: impl IntoIterator<Item = Vec3>) -> Option<(Vec3, Vec3)> {
    points.into_iter().fold(None, |found, p| Some(found.map_or((p, p), |found| hull(found, (p, p)))))
}
