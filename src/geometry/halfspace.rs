//! Convex polygons cut by lines and planes.

/// The part of a convex polygon where a linear function of the place is not negative.
pub(crate) fn cut<const N: usize>(polygon: &[[f64; N]], ahead: impl Fn([f64; N]) -> f64) -> Vec<[f64; N]> {
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (n, &p) in polygon.iter().enumerate() {
        let q = polygon[(n + 1) % polygon.len()];
        let (a, b) = (ahead(p), ahead(q));
        if a >= 0.0 {
            left.push(p);
        }
        if (a < 0.0) != (b < 0.0) {
            let t = a / (a - b);
            left.push(std::array::from_fn(|x| p[x] + t * (q[x] - p[x])));
        }
    }
    left
}
