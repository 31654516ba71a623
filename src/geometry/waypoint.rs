//! Places and turns that a body passes on its way.

use super::vector::{Vec3, add, along, cross, dot, norm, scale, sub};

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
    pub fn towards(&self, other: &Waypoint, share: f64) -> Waypoint {
        Leg::new(*self, other).at(share)
    }

    /// Of the two quaternions of another's turn the one nearer to this one's.
    fn nearer_turn(&self, other: &Waypoint) -> [f64; 4] {
        let cosine: f64 = self.turn.iter().zip(other.turn).map(|(a, b)| a * b).sum();
        if cosine < 0.0 { other.turn.map(|x| -x) } else { other.turn }
    }

    /// The angle between two quaternions: half that of the turn.
    fn half_angle(&self, turn: [f64; 4]) -> f64 {
        let [apart, together] = [-1.0, 1.0].map(|sign| length([0, 1, 2, 3].map(|i| self.turn[i] + sign * turn[i])));
        2.0 * apart.atan2(together)
    }

    /// Which point of the body is at a place.
    pub fn place_of(&self, x: Vec3) -> Vec3 {
        let ([a, b, c], off) = (self.rotation(), sub(x, self.at_mm));
        add(add(scale(a, off[0]), scale(b, off[1])), scale(c, off[2]))
    }

    /// Where a point of the body is.
    pub fn image(&self, p: Vec3) -> Vec3 {
        add(self.at_mm, self.rotation().map(|row| dot(row, p)))
    }
}

/// The way from one waypoint to another, ready for many places on it.
#[derive(Debug, Clone, Copy)]
pub struct Leg {
    from: Waypoint,
    /// The quaternion at its end: of two the one nearer to that at its start.
    turn: [f64; 4],
    /// The angle between the two quaternions, half that of the turn.
    half_angle: f64,
    /// From the place at its start to that at its end.
    step: Vec3,
    /// The axis of the turn, as long as its angle.
    turning: Vec3,
}

impl Leg {
    /// The way between two waypoints: the place on the straight line, the turn evenly about one axis, the shorter way round.
    pub fn new(from: Waypoint, to: &Waypoint) -> Self {
        let turn = from.nearer_turn(to);
        let half_angle = from.half_angle(turn);
        let ([w, a @ ..], [v, b @ ..]) = (from.turn, turn);
        // The vector part of the quaternion that takes the first to the second: the axis, as long as the sine of half the angle.
        let axis = sub(sub(scale(b, w), scale(a, v)), cross(b, a));
        let angle = if half_angle > 1e-9 { 2.0 * half_angle / half_angle.sin() } else { 2.0 };
        Leg { from, turn, half_angle, step: sub(to.at_mm, from.at_mm), turning: scale(axis, angle) }
    }

    /// The waypoint at a share of the way.
    ///
    /// # Source
    /// K. Shoemake, Animating rotation with quaternion curves, 1985.
    pub fn at(&self, share: f64) -> Waypoint {
        // Both have the sine of the whole in common, which the length takes away; below a hair of an angle the arc is its chord.
        let parts = match self.half_angle > 1e-9 {
            true => [1.0 - share, share].map(|share| (share * self.half_angle).sin()),
            false => [1.0 - share, share],
        };
        let mixed = [0, 1, 2, 3].map(|i| parts[0] * self.from.turn[i] + parts[1] * self.turn[i]);
        let length = length(mixed);
        Waypoint { at_mm: along(self.from.at_mm, self.step, share), turn: mixed.map(|x| x / length) }
    }

    /// How fast the body goes at a place that is so far from its origin, per share of the way.
    pub fn velocity(&self, from_origin: Vec3) -> Vec3 {
        add(self.step, cross(self.turning, from_origin))
    }

    /// No point of the body within a distance of its origin goes farther than this.
    pub fn longest(&self, reach: f64) -> f64 {
        norm(self.step) + reach * 2.0 * self.half_angle
    }
}

fn length(q: [f64; 4]) -> f64 {
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
        assert!(distance(quarter.place_of([1.0, 3.0, 8.0]), [1.0, 0.0, 5.0]) < 1e-12);
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
            let leg = Leg::new(from, &to);
            for share in [0.0, 0.25, 0.5, 1.0] {
                let found = from.towards(&to, share);
                let (p, step) = ([1.0, 0.5, 2.0], 1e-5);
                let [before, after] = [-step, step].map(|off| leg.at(share + off).image(p));
                let speed = leg.velocity(sub(found.image(p), found.at_mm));
                assert!(distance(scale(sub(after, before), 0.5 / step), speed) < 1e-6, "{angle} {share}");
                assert!(norm(speed) < leg.longest(norm(p)) + 1e-9);
                let want = Waypoint { at_mm: [4.0 * share, 0.0, 0.0], turn: turned(axis, 0.2 + share * short) };
                for p in [[1.0, 0.0, 0.0], [0.0, 1.0, 2.0]] {
                    assert!(distance(found.image(p), want.image(p)) < 1e-9, "{angle} {share}");
                }
            }
        }
    }
}
