//! The ways in which a part lies at rest on a plate, whether it has a flat side there or not.

use super::direction::sphere;
use crate::geometry::Hull;
use crate::geometry::vector::{Vec3, along, angle, cross, dot, norm, norm2, scale, sub, unit};
use rayon::prelude::*;
use std::cmp::Ordering;

/// Directions from which a part is let roll.
const STARTS: usize = 96;
/// Rolls from one of them.
const ROLLS: usize = 256;
/// Rests that are told.
const RESTS: usize = 12;
/// Rests nearer to each other than this are one, radians.
const ALIKE: f64 = 1e-2;

/// The directions that point up while what has such outermost points lies at rest, at most [`RESTS`], the lowest centre of mass first.
///
/// A part rests where its centre of mass lies over the face of its convex hull that it stands on: there the height of the centre over
/// the plate is least among all directions nearby. It is let roll from many directions, over corners and edges of the hull, always down, until it
/// rests. Points within `slack` of a face lie on it.
///
/// # Limits
/// A rest that no start rolls to is not found.
///
/// # Cost
/// A look at every point for each roll.
pub(super) fn rests(points: &[Vec3], centre: Vec3, slack: f64) -> Vec<Vec3> {
    let body = Body { points, centre, slack };
    let mut found: Vec<(f64, Vec3)> =
        sphere(STARTS).into_par_iter().with_max_len(1).filter_map(|up| body.rolled(up)).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut rests: Vec<Vec3> = Vec::new();
    for (_, up) in found {
        if rests.len() < RESTS && rests.iter().all(|r| angle(*r, up) > ALIKE) {
            rests.push(up);
        }
    }
    rests
}

/// What rolls.
struct Body<'a> {
    points: &'a [Vec3],
    centre: Vec3,
    slack: f64,
}

/// What a body turns about: a point, in a direction.
struct Hinge {
    at: Vec3,
    /// Level, and towards the centre of mass.
    towards: Vec3,
}

impl Body<'_> {
    /// How high the centre of mass lies at the rest that the body rolls to, and which way is up there.
    fn rolled(&self, mut up: Vec3) -> Option<(f64, Vec3)> {
        let height = |p: &Vec3, up: Vec3| dot(*p, up);
        let lowest = |up: Vec3| self.points.iter().min_by(|a, b| height(a, up).total_cmp(&height(b, up))).copied();
        let first = lowest(up)?;
        let mut hinge = Hinge { at: first, towards: self.level_way(first, up) };
        // Over a corner, over the edge that it comes to lie on, and then from face to face.
        let mut edge_from = Some(first);
        for _ in 0..ROLLS {
            if norm(hinge.towards) == 0.0 {
                return None;
            }
            let (next, met) = self.turned(up, &hinge)?;
            up = next;
            if let Some(from) = edge_from.take() {
                let along_edge = unit(sub(met, from));
                let way = self.level_way(from, up);
                hinge = Hinge { at: from, towards: along(way, along_edge, -dot(way, along_edge)) };
                continue;
            }
            match self.past(up, hinge.at) {
                Some(over) => hinge = over,
                None => return Some((dot(sub(self.centre, hinge.at), up), up)),
            }
        }
        None
    }

    /// From a point to below the centre of mass, level.
    fn level_way(&self, from: Vec3, up: Vec3) -> Vec3 {
        let way = sub(self.centre, from);
        along(way, up, -dot(way, up))
    }

    /// The way up once the body has turned about a hinge as far as the next point lets it, and that point.
    fn turned(&self, up: Vec3, hinge: &Hinge) -> Option<(Vec3, Vec3)> {
        let towards = unit(hinge.towards);
        let turn = |p: &Vec3| {
            let way = sub(*p, hinge.at);
            let (high, far) = (dot(way, up).max(0.0), dot(way, towards));
            // What lies on the hinge itself stays.
            (high.hypot(far) > 2.0 * self.slack).then(|| (high.atan2(far), *p))
        };
        let nearer = |a: &(f64, Vec3), b: &(f64, Vec3)| {
            let farther = || norm2(sub(b.1, hinge.at)).total_cmp(&norm2(sub(a.1, hinge.at)));
            match a.0.total_cmp(&b.0) {
                Ordering::Equal => farther(),
                order => order,
            }
        };
        let (by, met) = self.points.iter().filter_map(turn).min_by(nearer)?;
        let (sin, cos) = by.sin_cos();
        (by < std::f64::consts::PI).then(|| (unit(along(scale(up, cos), towards, -sin)), met))
    }

    /// The edge of the face stood on that the centre of mass lies farthest beyond; `None` where it lies over the face.
    fn past(&self, up: Vec3, on: Vec3) -> Option<Hinge> {
        let side = if up[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let u = unit(cross(up, side));
        let v = cross(up, u);
        let flat = |p: Vec3| [dot(sub(p, on), u), dot(sub(p, on), v)];
        let face = self.points.iter().filter(|p| dot(sub(**p, on), up) <= self.slack);
        let face = Hull::of(face.map(|p| flat(*p)));
        let centre = flat(self.centre);
        if face.depth(centre) >= -self.slack {
            return None;
        }
        let corners = face.corners();
        let beyond = (0..corners.len()).filter_map(|i| {
            let ([ax, ay], [bx, by]) = (*corners.get(i)?, *corners.get((i + 1) % corners.len())?);
            let (ex, ey) = (bx - ax, by - ay);
            let long = ex.hypot(ey);
            // Counter-clockwise: outside is to the right.
            let out = [ey / long, -ex / long];
            let far = out[0] * (centre[0] - ax) + out[1] * (centre[1] - ay);
            (long > 0.0).then_some((far, [ax, ay], out))
        });
        let (far, [x, y], out) = beyond.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let at = along(along(on, u, x), v, y);
        (far > 0.0).then(|| Hinge { at, towards: along(scale(u, out[0]), v, out[1]) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::upright;
    use crate::geometry::{TriangleMesh, cuboid, revolved};

    /// The rests of a mesh turned so that its +z points along a direction, each as the angle of that direction from up.
    fn rests_of(mesh: &TriangleMesh, turn: Vec3) -> Vec<f64> {
        let rows = upright(turn);
        // The inverse of what brings the direction up, in the numbers of an STL file.
        let back = [0, 1, 2].map(|a| [rows[0][a], rows[1][a], rows[2][a]]);
        let turned = mesh.transformed(back, [3.1, -2.2, 0.7]);
        let points: Vec<Vec3> = turned.vertices.iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
        let centre = turned.centre_of_mass(|_| true).unwrap();
        rests(&points, centre, 2e-6).into_iter().map(|up| angle(up, unit(turn)).to_degrees()).collect()
    }

    #[test]
    fn a_ring_rests_flat_on_either_side_however_it_is_turned() {
        // A torus of radii 8 and 2 mm.
        let round = (0..32).map(|k| (std::f64::consts::TAU * f64::from(k) / 32.0).sin_cos());
        let ring = revolved(&round.map(|(s, c)| [8.0 + 2.0 * c, 2.0 * s]).collect::<Vec<_>>(), 64);
        for turn in [[0.0, 0.0, 1.0], [-0.21, -0.76, 0.61], [0.9, 0.1, -0.3]] {
            let found = rests_of(&ring, turn);
            assert!(found.len() >= 2 && found[..2].iter().all(|a| a.min(180.0 - a) < 0.02), "{turn:?}: {found:?}");
            assert!(found[..2].iter().any(|a| *a < 90.0) && found[..2].iter().any(|a| *a > 90.0), "{found:?}");
        }
    }

    #[test]
    fn a_box_rests_on_its_six_sides_and_on_nothing_else() {
        let found = rests_of(&cuboid([0.0; 3], [4.0, 6.0, 9.0]), [0.3, -0.5, 0.7]);
        assert_eq!(found.len(), 6, "{found:?}");
        // Lowest on its largest sides.
        assert!(found[..4].iter().all(|a| (a - 90.0).abs() < 1e-3), "{found:?}");
        assert!(found[4..].iter().all(|a| a.min(180.0 - a) < 1e-3), "{found:?}");
    }

    #[test]
    fn a_face_beyond_which_the_centre_of_mass_lies_is_no_rest() {
        // A plate on the tip of a wedge 4 mm wide below, its centre of mass 10 mm to the side.
        let outline = [[0.0, 0.0], [4.0, 0.0], [30.0, 10.0], [30.0, 12.0], [-1.0, 12.0]];
        let leaning = crate::geometry::extruded(&outline, &[[0, 1, 4], [4, 1, 2], [4, 2, 3]], 9.0);
        let points: Vec<Vec3> = leaning.vertices.clone();
        let centre = leaning.centre_of_mass(|_| true).unwrap();
        let found = rests(&points, centre, 1e-6);
        let lowest = |up: Vec3| points.iter().map(|p| dot(*p, up)).fold(f64::INFINITY, f64::min);
        assert!(!found.is_empty());
        for up in found {
            // A little turned any way, the centre lies higher.
            let high = |up: Vec3| dot(centre, up) - lowest(up);
            for d in sphere(40) {
                assert!(high(unit(along(up, d, 1e-3))) >= high(up) - 1e-9, "{up:?}");
            }
        }
    }
}
