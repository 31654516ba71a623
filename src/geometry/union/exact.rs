//! Points with rational coordinates, and on which side of what they lie.

use crate::geometry::vector::Vec3;
use num::bigint::BigInt;
use num::{Integer, One, Signed, ToPrimitive, Zero};
use std::cmp::Ordering;

/// A point of the lattice that vertices are put on.
pub(super) type Lattice = [i64; 3];

/// Coordinates on the lattice are below 2 to this power, so that what is made of three of them in a row fits an `i128`.
pub(super) const BITS: i32 = 39;

/// How far a coordinate in floats may be from the true one: the rounding of a number below 2³⁹, thrice, and twofold to spare.
const OFF: f64 = 1.0 / 1024.0;

/// What rounding may add to a sum of few products, relative to the sum of their magnitudes.
const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

/// Where a point is: on the lattice, or at `[x, y, z] / w` in lowest terms, w > 0; each point in one way only.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Place {
    Lattice(Lattice),
    Ratio(Box<[BigInt; 4]>),
}

/// A point, and about where that is.
#[derive(Debug, Clone)]
pub(super) struct Exact {
    place: Place,
    near: Vec3,
}

impl PartialEq for Exact {
    fn eq(&self, other: &Self) -> bool {
        self.place == other.place
    }
}

impl Eq for Exact {}

impl std::hash::Hash for Exact {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.place.hash(state);
    }
}

impl Exact {
    pub(super) fn on_lattice(place: Lattice) -> Self {
        Exact { place: Place::Lattice(place), near: place.map(|x| x as f64) }
    }

    /// The point `[x, y, z] / w`, w not 0.
    fn ratio(parts: [BigInt; 4]) -> Self {
        let common = parts.iter().fold(BigInt::zero(), |common, part| common.gcd(part));
        let common = if parts[3].is_negative() { -common } else { common };
        let parts = parts.map(|part| part / &common);
        let [x, y, z, w] = &parts;
        if let (true, Some(x), Some(y), Some(z)) = (w.is_one(), x.to_i64(), y.to_i64(), z.to_i64()) {
            return Self::on_lattice([x, y, z]);
        }
        let near = [x, y, z].map(|x| quotient(x, w));
        Exact { place: Place::Ratio(Box::new(parts)), near }
    }

    /// The point of the line through two others at which a function is 0 that is linear along it and has these values there, each times
    /// the w of its point.
    pub(super) fn between([p, q]: [&Exact; 2], [at_p, at_q]: [BigInt; 2]) -> Self {
        let [p, q] = [p, q].map(Exact::parts);
        Self::ratio([0, 1, 2, 3].map(|i| &q[i] * &at_p - &p[i] * &at_q))
    }

    /// The mean of three points by weights that are not all 0.
    pub(super) fn mean(points: [&Exact; 3], weights: [u32; 3]) -> Self {
        let [a, b, c] = points.map(Exact::parts);
        let shares = [&b[3] * &c[3] * weights[0], &c[3] * &a[3] * weights[1], &a[3] * &b[3] * weights[2]];
        let sum = |i: usize| &a[i] * &shares[0] + &b[i] * &shares[1] + &c[i] * &shares[2];
        let whole: u32 = weights.iter().sum();
        Self::ratio([sum(0), sum(1), sum(2), &a[3] * &b[3] * &c[3] * whole])
    }

    /// The point, rounded.
    pub(super) fn near(&self) -> Vec3 {
        self.near
    }

    fn parts(&self) -> [BigInt; 4] {
        match &self.place {
            Place::Lattice([x, y, z]) => [BigInt::from(*x), BigInt::from(*y), BigInt::from(*z), BigInt::one()],
            Place::Ratio(parts) => parts.as_ref().clone(),
        }
    }

    /// How it lies to another along an axis.
    pub(super) fn compare(&self, other: &Exact, axis: usize) -> Ordering {
        let ahead = self.near[axis] - other.near[axis];
        if ahead.abs() > 4.0 * OFF {
            return ahead.total_cmp(&0.0);
        }
        let [p, q] = [self, other].map(Exact::parts);
        (&p[axis] * &q[3]).cmp(&(&q[axis] * &p[3]))
    }

    /// Before a plane, behind it, or on it: greater, less or equal.
    pub(super) fn side(&self, plane: &Plane) -> Ordering {
        let (mut height, mut most, mut steep) = (0.0, 0.0, 0.0);
        for axis in 0..3 {
            let normal = plane.normal[axis] as f64;
            let term = normal * (self.near[axis] - plane.corner[axis] as f64);
            (height, most, steep) = (height + term, most + term.abs(), steep + normal.abs());
        }
        if height.abs() > 4.0 * OFF * steep + ROUNDING * most {
            return height.total_cmp(&0.0);
        }
        let p = self.parts();
        let term = |axis: usize| (&p[axis] - plane.corner[axis] * &p[3]) * plane.normal[axis];
        (term(0) + term(1) + term(2)).cmp(&BigInt::zero())
    }
}

/// A quotient of numbers that may be beyond all floats.
fn quotient(x: &BigInt, w: &BigInt) -> f64 {
    let beyond = w.bits().saturating_sub(900);
    let [x, w] = [x, w].map(|n| (n >> beyond).to_f64().unwrap_or_default());
    x / w
}

/// A plane through a point of the lattice.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub(super) corner: Lattice,
    pub(super) normal: [i128; 3],
}

impl Plane {
    /// The plane of a triangle; its normal is 0 if the triangle has no area.
    pub(super) fn of([a, b, c]: [Lattice; 3]) -> Self {
        let [u, v] = [b, c].map(|p| [0, 1, 2].map(|i| i128::from(p[i] - a[i])));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        Plane { corner: a, normal }
    }

    /// How far a point of the lattice is before the plane, times the length of the normal.
    pub(super) fn height(&self, p: Lattice) -> i128 {
        (0..3).map(|i| self.normal[i] * i128::from(p[i] - self.corner[i])).sum()
    }

    /// The axis along which the plane is seen best, and the two others, so that what turns left about the normal does so in them.
    pub(super) fn axes(&self) -> (usize, [usize; 2]) {
        let along = (1..3).fold(0, |most, a| if self.normal[a].abs() > self.normal[most].abs() { a } else { most });
        let (a, b) = ((along + 1) % 3, (along + 2) % 3);
        (along, if self.normal[along] > 0 { [a, b] } else { [b, a] })
    }
}

/// Whether three points, seen in two axes, turn left, right or lie on a line: greater, less or equal.
pub(super) fn turn([i, j]: [usize; 2], [a, b, c]: [&Exact; 3]) -> Ordering {
    let [u, v] = [b, c].map(|p| [p.near[i] - a.near[i], p.near[j] - a.near[j]]);
    let terms = [u[0] * v[1], u[1] * v[0]];
    let off = 4.0 * OFF * (u[0].abs() + u[1].abs() + v[0].abs() + v[1].abs() + OFF);
    let area = terms[0] - terms[1];
    if area.abs() > off + ROUNDING * (terms[0].abs() + terms[1].abs()) {
        return area.total_cmp(&0.0);
    }
    area_of([i, j], [a, b, c]).cmp(&BigInt::zero())
}

/// Twice the area of three points seen in two axes, times their w.
pub(super) fn area_of([i, j]: [usize; 2], points: [&Exact; 3]) -> BigInt {
    let [a, b, c] = points.map(Exact::parts);
    let minor = |p: &[BigInt; 4], q: &[BigInt; 4]| &p[i] * &q[j] - &p[j] * &q[i];
    &a[3] * minor(&b, &c) + &b[3] * minor(&c, &a) + &c[3] * minor(&a, &b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Lcg;

    #[test]
    fn sides_and_turns_of_points_on_lines_and_planes_are_none() {
        let mut random = Lcg(71);
        let most = 1u64 << BITS;
        let mut point = || [0; 3].map(|_| random.below(most) as i64 * 2 + random.below(2) as i64 - most as i64);
        for _ in 0..200 {
            let corners = [point(), point(), point()];
            let plane = Plane::of(corners);
            let [a, b, c] = corners.map(|p| Exact::on_lattice(p.map(|x| x / 2)));
            let plane = Plane { corner: plane.corner.map(|x| x / 2), ..Plane::of(corners.map(|p| p.map(|x| x / 2))) };
            let middle = Exact::mean([&a, &b, &c], [3, 5, 7]);
            let edge = Exact::between([&a, &b], [BigInt::from(-3), BigInt::from(11)]);
            let (_, axes) = plane.axes();
            assert_eq!((middle.side(&plane), edge.side(&plane)), (Ordering::Equal, Ordering::Equal));
            assert_eq!(turn(axes, [&a, &edge, &b]), Ordering::Equal);
            assert_eq!(turn(axes, [&a, &b, &middle]), Ordering::Greater);
            assert_eq!(turn(axes, [&c, &edge, &middle]).reverse(), turn(axes, [&edge, &c, &middle]));
            // A lattice step off the plane is a side, whatever floats say.
            let (along, _) = plane.axes();
            let mut above = [a.clone(), b.clone(), c.clone()].map(|p| p.near().map(|x| x as i64));
            above[0][along] += plane.normal[along].signum() as i64;
            let lifted = Exact::mean([&Exact::on_lattice(above[0]), &b, &c], [1, 900_000, 900_000]);
            assert_eq!(lifted.side(&plane), Ordering::Greater);
        }
    }

    #[test]
    fn one_point_made_in_two_ways_is_one() {
        let [p, q] = [[0, 0, 0], [6, 3, 9]].map(Exact::on_lattice);
        let third = |at: [i64; 2]| Exact::between([&p, &q], at.map(BigInt::from));
        assert_eq!(third([-1, 2]), Exact::on_lattice([2, 1, 3]));
        assert_eq!(third([-5, 5]), third([7, -7]));
        assert_ne!(third([-5, 5]), third([7, -8]));
        assert_eq!(third([-1, 1]).near(), [3.0, 1.5, 4.5]);
        assert_eq!(third([-1, 1]).compare(&p, 1), Ordering::Greater);
    }
}
