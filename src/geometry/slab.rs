//! Boxes in any direction, and whether the surface passes through them.

use super::distance::MeshDistance;
use super::halfspace::cut;
use super::vector::{Vec3, along, bounds, dot, sub};

/// A box: one corner and three sides at right angles to each other, none without length.
///
/// ```
/// use amcheck::geometry::{MeshDistance, Slab, cuboid};
/// let surface = MeshDistance::new(&cuboid([0.0; 3], [4.0; 3]));
/// let sides = [[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// assert!(Slab { corner: [0.0, 0.0, 3.5], sides }.is_met(&surface));
/// // All of it lies inside.
/// assert!(!Slab { corner: [2.0, 1.0, 1.0], sides }.is_met(&surface));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slab {
    pub corner: Vec3,
    pub sides: [Vec3; 3],
}

impl Slab {
    /// Whether any facet of the surface has a point in it.
    ///
    /// # Cost
    /// O(log n + facets whose boxes overlap that of the slab).
    pub fn is_met(&self, surface: &MeshDistance) -> bool {
        let [u, v, w] = self.sides;
        let corners = (0..8).map(|n| {
            let shares = [n & 1, n >> 1 & 1, n >> 2].map(f64::from);
            along(along(along(self.corner, u, shares[0]), v, shares[1]), w, shares[2])
        });
        let mut is_met = false;
        if let Some(extent) = bounds(corners) {
            surface.tree().in_box(extent, |f| is_met = is_met || self.holds_part_of(surface.corners(f)));
        }
        is_met
    }

    /// Whether a triangle has a point in it: what is left of the triangle when it is cut at each of its faces.
    fn holds_part_of(&self, triangle: [Vec3; 3]) -> bool {
        let share = |p: Vec3| self.sides.map(|s| dot(sub(p, self.corner), s) / dot(s, s));
        let mut left = triangle.map(share).to_vec();
        for axis in 0..3 {
            left = cut(&left, |p| p[axis]);
            left = cut(&left, |p| 1.0 - p[axis]);
        }
        !left.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn a_slab_is_met_by_what_reaches_into_it_only() {
        let half = 0.5f64.sqrt();
        let slab =
            Slab { corner: [0.0; 3], sides: [[4.0 * half, 4.0 * half, 0.0], [-half, half, 0.0], [0.0, 0.0, 1.0]] };
        let met = |lo: Vec3, hi: Vec3| slab.is_met(&MeshDistance::new(&cuboid(lo, hi)));
        // Through it, within it, round it and past its corners, within the box around it.
        assert!(met([1.0, -9.0, 0.4], [1.1, 9.0, 0.5]));
        assert!(met([1.4, 1.5, 0.4], [1.5, 1.6, 0.5]));
        assert!(!met([-9.0; 3], [9.0; 3]));
        assert!(!met([-0.7, 0.0, 0.0], [-0.6, 0.1, 1.0]) && !met([2.0, 0.1, 0.0], [2.8, 1.9, 1.0]));
        assert!(met([2.0, 0.1, 0.0], [2.8, 2.1, 1.0]));
    }
}
