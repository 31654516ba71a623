//! Prisms in any direction, and whether the surface passes through them.

use super::distance::MeshDistance;
use super::halfspace::cut;
use super::vector::{Vec3, add, along, bounds, cross, dot, scale, sub};

/// A prism over a convex polygon, which goes on along a vector out of the polygon's plane.
///
/// ```
/// use amcheck::geometry::{MeshDistance, Prism, cuboid};
/// let surface = MeshDistance::new(&cuboid([0.0; 3], [4.0; 3]));
/// let base = vec![[0.0, 0.0, 3.5], [1.0, 1.0, 3.5], [0.0, 2.0, 3.5]];
/// assert!(Prism { base: base.clone(), along: [0.0, 0.0, 1.0] }.is_met(&surface, |_| true));
/// // All of it lies inside.
/// let within = base.iter().map(|p| [p[0] + 1.5, p[1] + 1.0, 1.0]).collect();
/// assert!(!Prism { base: within, along: [0.0, 0.0, 1.0] }.is_met(&surface, |_| true));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Prism {
    pub base: Vec<Vec3>,
    pub along: Vec3,
}

impl Prism {
    /// Whether any facet of the surface that counts has a point in it.
    ///
    /// # Cost
    /// O(log n + facets whose boxes overlap that of the prism).
    pub fn is_met(&self, surface: &MeshDistance, counts: impl Fn(u32) -> bool) -> bool {
        let ends = self.base.iter().flat_map(|&p| [p, add(p, self.along)]);
        let Some(extent) = bounds(ends) else { return false };
        let sides = self.sides();
        surface.tree().any_in_box(extent, |f| counts(f) && holds_part_of(&sides, surface.corners(f)))
    }

    /// Its faces: a point on each and a vector that leads inwards.
    fn sides(&self) -> Vec<(Vec3, Vec3)> {
        let n = self.base.len();
        let middle = scale(self.base.iter().copied().fold([0.0; 3], add), 1.0 / n.max(1) as f64);
        let round = |(p, q): (&Vec3, &Vec3)| (*p, inwards(cross(self.along, sub(*q, *p)), sub(middle, *p)));
        let around = self.base.iter().zip(self.base.iter().cycle().skip(1)).map(round);
        let across = self.base.get(..3).map_or(self.along, |b| cross(sub(b[1], b[0]), sub(b[2], b[0])));
        let across = inwards(across, self.along);
        around.chain([(middle, across), (along(middle, self.along, 1.0), scale(across, -1.0))]).collect()
    }
}

/// A vector, or its opposite, that leads the way of another.
fn inwards(v: Vec3, way: Vec3) -> Vec3 {
    if dot(v, way) < 0.0 { scale(v, -1.0) } else { v }
}

/// Whether a triangle has a point in a prism: what is left of the triangle when it is cut at each of its faces.
fn holds_part_of(sides: &[(Vec3, Vec3)], triangle: [Vec3; 3]) -> bool {
    let mut left = triangle.to_vec();
    for (at, inwards) in sides {
        left = cut(&left, |p| dot(sub(p, *at), *inwards));
    }
    !left.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn a_prism_is_met_by_what_reaches_into_it_only() {
        let half = 0.5f64.sqrt();
        let [u, v] = [[4.0 * half, 4.0 * half, 0.0], [-half, half, 0.0]];
        let prism = Prism { base: vec![[0.0; 3], u, add(u, v), v], along: [0.0, 0.0, 1.0] };
        let met = |lo: Vec3, hi: Vec3| prism.is_met(&MeshDistance::new(&cuboid(lo, hi)), |_| true);
        // Through it, within it, round it and past its corners, within the box around it.
        assert!(met([1.0, -9.0, 0.4], [1.1, 9.0, 0.5]));
        assert!(met([1.4, 1.5, 0.4], [1.5, 1.6, 0.5]));
        assert!(!met([-9.0; 3], [9.0; 3]));
        assert!(!met([-0.7, 0.0, 0.0], [-0.6, 0.1, 1.0]) && !met([2.0, 0.1, 0.0], [2.8, 1.9, 1.0]));
        assert!(met([2.0, 0.1, 0.0], [2.8, 2.1, 1.0]));
        // Over either half of the base, whichever way that is gone round.
        for (base, is_in) in [([[0.0; 3], u, v], false), ([u, add(u, v), v], true), ([v, add(u, v), u], true)] {
            let prism = Prism { base: base.to_vec(), along: [0.0, 0.0, 1.0] };
            let speck = cuboid([2.1, 2.9, 0.4], [2.2, 3.0, 0.5]);
            assert_eq!(prism.is_met(&MeshDistance::new(&speck), |_| true), is_in, "{base:?}");
        }
        assert!(!prism.is_met(&MeshDistance::new(&cuboid([1.4, 1.5, 0.4], [1.5, 1.6, 0.5])), |_| false));
    }
}
