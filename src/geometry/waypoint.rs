//! Places and turns that a body passes on its way.

use super::vector::{Vec3, add, along, scale, sub};

/// A place of a body and its turn: `p ↦ R·p + at`, with R the rotation of a unit quaternion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// Where the body's origin is, millimetres.
    pub at_mm: Vec3,
    /// The unit quaternion w, x, y, z of the turn; its negative is the same turn.
    pub turn: [f64; 4],
}

impl Waypoint {
    /// The rotation of the turn, rows.
    pub fn rotation(&self) -> [Vec3; 3] {
        let [w, x, y, z] = self.turn;
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }

    /// The angle of the shorter turn from one to the other, from 0 to π.
    pub fn angle_to(&self, other: &Waypoint) -> f64 {
        2.0 * self.half_angle(self.nearer_turn(other))
    }

    /// What lies between two at a share of the way: the place on the straight line, the turn evenly about one axis, the shorter
    /// way round.
    ///
    /// # Source
    /// K. Shoemake, Animating rotation with quaternion curves, 1985.
    pub fn towards(&self, other: &Waypoint, share: f64) -> Waypoint {
        let turn = self.nearer_turn(other);
        let angle = self.half_angle(turn);
        // Below a hair of an angle the arc is its chord.
        let parts = match angle > 1e-9 {
            true => [((1.0 - share) * angle).sin() / angle.sin(), (share * angle).sin() / angle.sin()],
            false => [1.0 - share, share],
        };
        let mixed = [0, 1, 2, 3].map(|i| parts[0] * self.turn[i] + parts[1] * turn[i]);
        let at_mm = along(self.at_mm, sub(other.at_mm, self.at_mm), share);
        Waypoint { at_mm, turn: mixed.map(|x| x / norm(mixed)) }
    }

    /// Of the two quaternions of another's turn the one nearer to this one's.
    fn nearer_turn(&self, other: &Waypoint) -> [f64; 4] {
        let cosine: f64 = self.turn.iter().zip(other.turn).map(|(a, b)| a * b).sum();
        if cosine < 0.0 { other.turn.map(|x| -x) } else { other.turn }
    }

    /// The angle between two quaternions: half that of the turn.
    fn half_angle(&self, turn: [f64; 4]) -> f64 {
        let [apart, together] = [-1.0, 1.0].map(|sign| norm([0, 1, 2, 3].map(|i| self.turn[i] + sign * turn[i])));
        2.0 * apart.atan2(together)
    }

    /// Where a point of the body is.
    pub fn image(&self, p: Vec3) -> Vec3 {
        let [x, y, z] = [0, 1, 2].map(|column| self.rotation().map(|row| row[column]));
        add(self.at_mm, add(add(scale(x, p[0]), scale(y, p[1])), scale(z, p[2])))
    }
}

fn norm(q: [f64; 4]) -> f64 {
    q.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::vector::distance;
    use super::*;

    /// A turn about an axis by an angle.
    fn turned(axis: Vec3, angle: f64) -> [f64; 4] {
        let (s, c) = (0.5 * angle).sin_cos();
        [c, s * axis[0], s * axis[1], s * axis[2]]
    }

    #[test]
    fn turns_are_rotations_by_their_angle_about_their_axis() {
        let quarter = Waypoint { at_mm: [1.0, 2.0, 3.0], turn: turned([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2) };
        assert!(distance(quarter.image([1.0, 0.0, 5.0]), [1.0, 3.0, 8.0]) < 1e-12);
        assert!(distance(quarter.image([0.0, 1.0, 0.0]), [0.0, 2.0, 3.0]) < 1e-12);
        let rows = quarter.rotation();
        assert!(distance(rows[0], [0.0, -1.0, 0.0]) < 1e-12 && distance(rows[1], [1.0, 0.0, 0.0]) < 1e-12);
    }

    #[test]
    fn between_two_the_turn_is_even_and_the_shorter_one() {
        let axis = [0.6, 0.0, 0.8];
        let from = Waypoint { at_mm: [0.0; 3], turn: turned(axis, 0.2) };
        for (angle, short) in
            [(1.4, 1.2), (3.0, 2.8), (0.2, 0.0), (0.2 + 1e-12, 0.0), (5.5, 5.3 - std::f64::consts::TAU)]
        {
            let to = Waypoint { at_mm: [4.0, 0.0, 0.0], turn: turned(axis, angle).map(|x| -x) };
            assert!((from.angle_to(&to) - f64::abs(short)).abs() < 1e-9, "{angle}: {}", from.angle_to(&to));
            for share in [0.0, 0.25, 0.5, 1.0] {
                let found = from.towards(&to, share);
                let want = Waypoint { at_mm: [4.0 * share, 0.0, 0.0], turn: turned(axis, 0.2 + share * short) };
                for p in [[1.0, 0.0, 0.0], [0.0, 1.0, 2.0]] {
                    assert!(distance(found.image(p), want.image(p)) < 1e-9, "{angle} {share}");
                }
            }
        }
    }
}
