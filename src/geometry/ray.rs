//! Rays and triangles, without a gap where triangles meet.

use super::vector::{Vec3, cross, dot, sub};

/// The line `p + s·d`, with what it takes to look along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    p: Vec3,
    d: Vec3,
    /// The axes, that of the largest component of d last.
    axes: [usize; 3],
    /// The components of d along the first two, over that along the last.
    shear: [f64; 2],
}

impl Ray {
    /// The ray from a point in a direction of any length.
    #[inline]
    pub fn of(p: Vec3, d: Vec3) -> Self {
        let size = d.map(f64::abs);
        let last = if size[2] >= size[0] && size[2] >= size[1] { 2 } else { usize::from(size[1] >= size[0]) };
        let axes = [(last + 1) % 3, (last + 2) % 3, last];
        let shear = [d[axes[0]] / d[last], d[axes[1]] / d[last]];
        Ray { p, d, axes, shear }
    }

    /// The parameter s at which the line meets a triangle, if it meets it: edges included, triangles parallel to it not.
    ///
    /// On which side of an edge the line passes is told from its two ends alone, and for triangles that share it alike to the last bit, so
    /// that no line passes between them.
    ///
    /// # Source
    /// Sides: S. Woop, C. Benthin, I. Wald, *Watertight ray/triangle intersection*, Journal of Computer Graphics Techniques 2 (1), 2013; the
    /// parameter: T. Möller, B. Trumbore, *Fast, minimum storage ray/triangle intersection*, 1997, which for small triangles far from p is nearer.
    #[inline]
    pub fn hit(&self, [a, b, c]: [Vec3; 3]) -> Option<f64> {
        let [u, v, w] = [self.seen(a), self.seen(b), self.seen(c)];
        let sides = [turn(v, w), turn(w, u), turn(u, v)];
        if sides.iter().any(|s| *s < 0.0) && sides.iter().any(|s| *s > 0.0) {
            return None;
        }
        let (ab, ac) = (sub(b, a), sub(c, a));
        let det = dot(ab, cross(self.d, ac));
        (det != 0.0).then(|| dot(ac, cross(sub(self.p, a), ab)) / det)
    }

    /// A point as it is seen along the ray.
    #[inline]
    fn seen(&self, q: Vec3) -> [f64; 2] {
        let from = sub(q, self.p);
        let [x, y, z] = self.axes.map(|a| from[a]);
        [x - self.shear[0] * z, y - self.shear[1] * z]
    }
}

/// Twice the area of the triangle of two points and the origin: reversed if they are exchanged, exactly.
#[inline]
fn turn(p: [f64; 2], q: [f64; 2]) -> f64 {
    p[0] * q[1] - p[1] * q[0]
}

#[cfg(test)]
mod tests {
    use super::super::vector::{along, scale};
    use super::*;
    use crate::geometry::{MeshDistance, Primitive};
    use crate::random::Lcg;
    use crate::units::Length;

    #[test]
    fn no_ray_leaves_a_closed_mesh_through_its_edges_or_corners() {
        let mut random = Lcg(5);
        for n in 0..12 {
            let ball = Primitive::parse("ball:2mm").unwrap().mesh(Length::mm(0.02));
            // Turned and moved at random, so that rounding has its say; and as it is.
            let (s, c) = if n == 0 { (0.0, 1.0) } else { (6.0 * random.unit()).sin_cos() };
            let turn = [[c, -s * 0.6, s * 0.8], [s, c * 0.6, -c * 0.8], [0.0, 0.8, 0.6]];
            let mesh = ball.transformed(turn, if n == 0 { [0.0; 3] } else { random.point(-200.0, 200.0) });
            let surface = MeshDistance::new(&mesh);
            let centre =
                scale(mesh.vertices.iter().fold([0.0; 3], |a, v| along(a, *v, 1.0)), 1.0 / mesh.vertices.len() as f64);
            for f in 0..mesh.triangles.len() {
                let [a, b, _] = mesh.corners(f);
                for target in [a, along(a, sub(b, a), 0.5), along(a, sub(b, a), random.unit())] {
                    let from = along(centre, random.point(-1.0, 1.0), 0.5);
                    let hit = surface.first_hit(from, sub(target, from), 0.0, 10.0);
                    assert!(hit.is_some_and(|(s, _)| (s - 1.0).abs() < 1e-9), "{n} {f}: {hit:?}");
                }
            }
        }
    }

    #[test]
    fn a_triangle_is_met_where_it_is() {
        let t = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
        let at = |x: f64, y: f64, d: Vec3| Ray::of([x, y, 0.0], d).hit(t);
        assert_eq!((at(0.2, 0.2, [0.0, 0.0, 2.0]), at(0.2, 0.2, [0.0, 0.0, -1.0])), (Some(0.5), Some(-1.0)));
        assert_eq!((at(0.0, 0.0, [0.0, 0.0, 1.0]), at(0.5, 0.5, [0.0, 0.0, 1.0])), (Some(1.0), Some(1.0)));
        assert_eq!((at(0.6, 0.6, [0.0, 0.0, 1.0]), at(-0.1, 0.5, [0.0, 0.0, 1.0])), (None, None));
        assert_eq!((at(-1.0, 0.2, [2.0, 0.0, 1.0]), at(0.2, 0.2, [1.0, 0.0, 0.0])), (None, None));
        assert_eq!(at(-0.8, 0.2, [1.0, 0.0, 1.0]), Some(1.0));
    }
}
