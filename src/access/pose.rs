//! Where a tool may come from: directions on the sphere, rotations, what a machine allows.

use crate::geometry::vector::{Vec3, cross, dot, norm, unit};
use std::f64::consts::{PI, SQRT_2, TAU};

/// A rotation as the rows of its matrix.
pub type Rotation = [Vec3; 3];

/// The six axis directions, from above first.
pub fn axis_directions() -> Vec<Vec3> {
    lattice_directions()[..6].to_vec()
}

/// The 26 directions from the middle of a cube to its faces, edges and corners, each followed by its opposite.
pub fn lattice_directions() -> Vec<Vec3> {
    const AXES: [[f64; 3]; 13] = [
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 1.0],
        [-1.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
        [0.0, -1.0, 1.0],
        [1.0, 1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 1.0],
        [-1.0, 1.0, 1.0],
        [1.0, -1.0, 1.0],
        [-1.0, -1.0, 1.0],
    ];
    AXES.iter().flat_map(|&a| [unit(a), unit(a).map(|x| 0.0 - x)]).collect()
}

/// `n` nearly even directions on the sphere, in opposite pairs: a Fibonacci lattice on the upper half and its mirror image.
///
/// No direction is further from one of them than about √(8.8/n) radians. An odd `n` is rounded up.
pub fn fibonacci(n: usize) -> Vec<Vec3> {
    let half = n.div_ceil(2);
    let golden = PI * (3.0 - 5f64.sqrt());
    let upper = (0..half).map(|i| {
        let z = 1.0 - (i as f64 + 0.5) / half as f64;
        let (r, turn) = ((1.0 - z * z).sqrt(), golden * i as f64);
        [r * turn.cos(), r * turn.sin(), z]
    });
    upper.flat_map(|d| [d, d.map(|x| -x)]).collect()
}

/// The directions within `tilt` radians of `up`: what a machine with a tilting head or table reaches.
pub fn within_tilt(directions: &[Vec3], up: Vec3, tilt: f64) -> Vec<Vec3> {
    let least = tilt.cos() - 1e-12;
    directions.iter().copied().filter(|&d| dot(d, unit(up)) >= least).collect()
}

/// `n` nearly even rotations: super-Fibonacci spirals on the unit quaternions.
///
/// No rotation is further from one of them than about ∛(60/n) radians for n ≥ 500. The sets of different n are not nested.
///
/// # Source
/// M. Alexa, Super-Fibonacci spirals: fast, low-discrepancy sampling of SO(3), 2022.
pub fn super_fibonacci(n: usize) -> Vec<Rotation> {
    const PSI: f64 = 1.533_751_168_755_204_3;
    let of = |i: usize| {
        let s = i as f64 + 0.5;
        let t = s / n as f64;
        let (r, big) = (t.sqrt(), (1.0 - t).sqrt());
        let (a, b) = (TAU * s / SQRT_2, TAU * s / PSI);
        of_quaternion([r * a.sin(), r * a.cos(), big * b.sin(), big * b.cos()])
    };
    (0..n).map(of).collect()
}

/// The rotation of a unit quaternion `[x, y, z, w]`.
fn of_quaternion([x, y, z, w]: [f64; 4]) -> Rotation {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// The 24 rotations that bring the axes onto axes.
pub fn axis_rotations() -> Vec<Rotation> {
    let axes: Vec<Vec3> = axis_directions();
    let frames = axes.iter().flat_map(|&x| axes.iter().filter(move |&&y| dot(x, y) == 0.0).map(move |&y| (x, y)));
    frames.map(|(x, y)| transposed([x, y, cross(x, y)])).map(|r| r.map(|row| row.map(|v| v + 0.0))).collect()
}

/// The rotations at which a tool of any shape comes along a direction; a coaxial one is the same at all.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Turns {
    /// At none.
    Nowhere,
    /// At the four of [`quarter_turns`].
    #[default]
    Quarters,
    /// At this one, which brings +z to the direction.
    At(Rotation),
}

impl Turns {
    /// How many they are.
    pub fn count(self) -> usize {
        match self {
            Turns::Nowhere => 0,
            Turns::Quarters => 4,
            Turns::At(_) => 1,
        }
    }
}

/// The four rotations that bring +z to a direction and the other axes, if the direction is an axis, onto axes.
pub fn quarter_turns(direction: Vec3) -> [Rotation; 4] {
    let upright = about(direction);
    [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]
        .map(|[c, s]| upright.map(|row| [row[0] * c + row[1] * s, row[1] * c - row[0] * s, row[2]].map(|v| v + 0.0)))
}

/// One rotation after another: the rows of a·b.
pub(super) fn product(a: Rotation, b: Rotation) -> Rotation {
    let columns = transposed(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

/// The rotation that brings +z to a direction, by the least angle.
pub fn about(direction: Vec3) -> Rotation {
    let [a, b, d] = frame_of(direction);
    transposed([a, b, d])
}

/// Two directions square to `direction`, and itself: the rows of the rotation that brings it to +z.
///
/// For a direction along an axis all three lie along axes.
pub(super) fn frame_of(direction: Vec3) -> Rotation {
    let d = unit(direction);
    let least = (0..3).fold(0, |m, a| if d[a].abs() < d[m].abs() - 1e-9 { a } else { m });
    let mut other = [0.0; 3];
    other[least] = 1.0;
    let b = cross(d, other);
    let b = unit(b);
    let a = cross(b, d);
    debug_assert!((norm(a) - 1.0).abs() < 1e-9);
    [a, b, d]
}

/// Two directions square to one and to each other.
pub fn square_to(direction: Vec3) -> [Vec3; 2] {
    let [a, b, _] = frame_of(direction);
    [a, b]
}

pub(super) fn transposed(m: Rotation) -> Rotation {
    [0, 1, 2].map(|c| [0, 1, 2].map(|r| m[r][c]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::angle;

    #[test]
    fn directions_come_in_opposite_pairs_and_cover_the_sphere() {
        assert_eq!(lattice_directions().len(), 26);
        for n in [26, 100, 162, 400, 1000] {
            let list = fibonacci(n);
            assert_eq!(list.len(), n);
            assert!(list.chunks(2).all(|p| dot(p[0], p[1]) < -1.0 + 1e-12));
            // Mirroring the half lattice costs a little at the equator.
            let far = fibonacci(20_000)
                .iter()
                .map(|&x| list.iter().map(|&d| angle(x, d)).fold(f64::INFINITY, f64::min))
                .fold(0.0, f64::max);
            assert!(far < (8.8 / n as f64).sqrt(), "{n}: {far}");
        }
        let all = lattice_directions();
        assert_eq!(within_tilt(&all, [0.0, 0.0, 1.0], 0.0), vec![[0.0, 0.0, 1.0]]);
        assert_eq!(within_tilt(&all, [0.0, 0.0, 1.0], 0.8).len(), 5);
    }

    #[test]
    fn rotations_are_proper_and_cover_all_turns() {
        let det = |m: &Rotation| dot(m[0], cross(m[1], m[2]));
        assert_eq!(axis_rotations().len(), 24);
        let n = 1000;
        let list = super_fibonacci(n);
        assert!(list.iter().chain(&axis_rotations()).all(|m| (det(m) - 1.0).abs() < 1e-9));
        // Angle between rotations: trace = 1 + 2 cos.
        let between = |a: &Rotation, b: &Rotation| {
            let trace: f64 = (0..3).map(|r| dot(a[r], b[r])).sum();
            ((trace - 1.0) / 2.0).clamp(-1.0, 1.0).acos()
        };
        let far = super_fibonacci(4001)
            .iter()
            .map(|x| list.iter().map(|d| between(x, d)).fold(f64::INFINITY, f64::min))
            .fold(0.0, f64::max);
        assert!(far < (65.0 / n as f64).cbrt(), "{far}");
        let mut turned: Vec<Rotation> = axis_directions().into_iter().flat_map(quarter_turns).collect();
        let mut all = axis_rotations();
        let by_entries = |a: &Rotation, b: &Rotation| a.as_flattened().partial_cmp(b.as_flattened()).unwrap();
        turned.sort_by(by_entries);
        all.sort_by(by_entries);
        assert_eq!(turned, all);
        for d in lattice_directions() {
            assert!(quarter_turns(d).iter().all(|m| angle([0, 1, 2].map(|r| m[r][2]), d) < 1e-7));
            assert!(quarter_turns(d).iter().all(|m| (det(m) - 1.0).abs() < 1e-9));
            let turned = about(d);
            let z = [0, 1, 2].map(|r| turned[r][2]);
            assert!(angle(z, d) < 1e-7 && (det(&turned) - 1.0).abs() < 1e-9);
        }
    }
}
