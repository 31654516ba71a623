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
#[inline]
pub fn hull(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> (Vec3, Vec3) {
    (least(a.0, b.0), greatest(a.1, b.1))
}

/// The corners of a box.
pub fn corners_of((lo, hi): (Vec3, Vec3)) -> [Vec3; 8] {
    [0, 1, 2, 3, 4, 5, 6, 7].map(|n| [0, 1, 2].map(|a| if n >> a & 1 == 1 { hi[a] } else { lo[a] }))
}

/// The lesser of two in each component.
#[inline]
pub fn least(a: Vec3, b: Vec3) -> Vec3 {
    // Written out, here and below: the compiler does not inline `map` over an array where it stands in a hot loop. Nor does it take
    // `min`, which also minds what is not a number, for one instruction, as it does a comparison.
    let of = |a: f64, b: f64| if b < a { b } else { a };
    [of(a[0], b[0]), of(a[1], b[1]), of(a[2], b[2])]
}

/// The greater of two in each component.
#[inline]
pub fn greatest(a: Vec3, b: Vec3) -> Vec3 {
    let of = |a: f64, b: f64| if b > a { b } else { a };
    [of(a[0], b[0]), of(a[1], b[1]), of(a[2], b[2])]
}

/// Componentwise least and greatest of a set of points; `None` for the empty set.
#[inline]
pub fn bounds(points: impl IntoIterator<Item = Vec3>) -> Option<(Vec3, Vec3)> {
    let mut points = points.into_iter();
    let first = points.next()?;
    Some(points.fold((first, first), |(lo, hi), p| (least(lo, p), greatest(hi, p))))
}
