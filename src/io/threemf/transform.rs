//! The 3 × 4 transforms of 3MF: a point is a row, and the matrix stands behind it.

use crate::geometry::vector::{Vec3, add, along, cross, dot, norm, scale};

/// An affine map p ↦ p·M + t, as the twelve numbers of the file: the rows of M, then t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Transform {
    rows: [Vec3; 3],
    shift: Vec3,
}

impl Transform {
    pub(super) const IDENTITY: Transform =
        Transform { rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], shift: [0.0; 3] };

    /// The map that makes everything larger by a factor.
    pub(super) fn scaling(by: f64) -> Self {
        Transform { rows: [[by, 0.0, 0.0], [0.0, by, 0.0], [0.0, 0.0, by]], shift: [0.0; 3] }
    }

    /// The map of twelve finite numbers, unless it flattens space.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn new(numbers: [f64; 12]) -> Result<Self, String> {
        let [a, b, c, d, e, f, g, h, i, x, y, z] = numbers;
        let map = Transform { rows: [[a, b, c], [d, e, f], [g, h, i]], shift: [x, y, z] };
        let size: f64 = map.rows.iter().map(|&r| norm(r)).product();
        if !numbers.iter().all(|n| n.is_finite()) || !size.is_finite() {
            Err("a transform with numbers that are out of range".into())
        } else if map.determinant().abs() <= 1e-12 * size {
            Err("a singular transform: it flattens the part".into())
        } else {
            Ok(map)
        }
    }

    fn determinant(&self) -> f64 {
        dot(self.rows[0], cross(self.rows[1], self.rows[2]))
    }

    /// Whether the map turns right hands into left ones.
    pub(super) fn mirrors(&self) -> bool {
        self.determinant() < 0.0
    }

    /// The image of a point.
    pub(super) fn apply(&self, p: Vec3) -> Vec3 {
        add(self.direction(p), self.shift)
    }

    fn direction(&self, p: Vec3) -> Vec3 {
        let [r, s, t] = self.rows;
        along(along(scale(r, p[0]), s, p[1]), t, p[2])
    }

    /// First this map, then another.
    pub(super) fn then(&self, outer: &Transform) -> Transform {
        Transform { rows: self.rows.map(|r| outer.direction(r)), shift: outer.apply(self.shift) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_a_row_and_maps_follow_each_other() {
        // x → y, y → z, z → x, then a shift.
        let turn = Transform::new([0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 10.0, 20.0, 30.0]).unwrap();
        assert_eq!(turn.apply([1.0, 2.0, 3.0]), [13.0, 21.0, 32.0]);
        let stretch = Transform::new([2.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, -4.0, 0.0, 0.0, 1.0]).unwrap();
        assert!(stretch.mirrors() && !turn.mirrors() && turn.then(&stretch).mirrors());
        assert_eq!(turn.then(&stretch).apply([1.0, 2.0, 3.0]), stretch.apply(turn.apply([1.0, 2.0, 3.0])));
    }

    #[test]
    fn flat_and_endless_maps_are_refused() {
        let with = |at: usize, value: f64| {
            let mut numbers = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
            numbers[at] = value;
            Transform::new(numbers)
        };
        assert!(with(0, 0.0).is_err() && with(3, f64::INFINITY).is_err() && with(9, f64::NAN).is_err());
        assert!(with(0, 1e-6).is_ok());
    }
}
