//! Raised and engraved detail: what ends on one side and widens on the other, little apart.

use super::detail::Thin;
use crate::geometry::vector::{Vec3, along, cross, dot, scale};
use crate::medial::Side;
use crate::medial::section::across;
use crate::part::Part;
use std::f64::consts::TAU;

/// What rises or sinks by no more than this is relief, millimetres.
const RELIEF_MM: f64 = 2.0;

/// Directions in which a rim is looked for, and the least cosine between one and the rim's normal: a little more than half of what lies
/// between two.
const DIRECTIONS: usize = 16;
const ACROSS_RIM: f64 = 0.9;

/// What reaches so many thicknesses to one side is wider.
const WIDE: f64 = 1.5;

/// What is so many thicknesses thick still belongs to the stroke, and from the last such place it is so many to where it is wider: what
/// tapers all the way has no foot.
const STRAIGHT: f64 = 1.4;
const ABRUPT: f64 = 1.0;

/// A stroke is so many thicknesses long at least, so that no pin or dot is one.
const LONG: f64 = 1.5;

/// Steps to where it widens, in thicknesses.
const STEP: f64 = 0.0625;

/// Whether what is thin at a place is raised on a wider piece of its side of the surface, or sunk below it, by at most two millimetres: in some
/// direction straight between its sides it ends, the other way it widens, and along neither it is longer than thick.
///
/// # Cost
/// At most some hundred rays for each direction that has a rim.
pub fn is_relief(part: &Part, side: Side, thin: &Thin) -> bool {
    let (between, [u, v]) = (thin.direction(), across(thin.direction()));
    let stroke = Stroke { part, side, thin, between };
    (0..DIRECTIONS).any(|k| {
        let (s, c) = (TAU * k as f64 / DIRECTIONS as f64).sin_cos();
        let up = [0, 1, 2].map(|a| c * u[a] + s * v[a]);
        let long = cross(between, up);
        stroke.rim(up).is_some_and(|rim| {
            let left = RELIEF_MM + part.tie() - rim;
            stroke.free(long) + stroke.free(scale(long, -1.0)) >= LONG * thin.diameter
                && stroke.foot(scale(up, -1.0), left).is_some()
        })
    })
}

/// Something thin, from the middle of its thinnest place.
struct Stroke<'a> {
    part: &'a Part,
    side: Side,
    thin: &'a Thin,
    between: Vec3,
}

impl Stroke<'_> {
    /// The distance to a face across a direction in which it ends.
    fn rim(&self, up: Vec3) -> Option<f64> {
        let (at, facet) = self.part.distance().first_hit(self.thin.centre, up, 0.0, RELIEF_MM)?;
        (self.side.sign() * dot(self.part.distance().normal(facet), up) >= ACROSS_RIM).then_some(at)
    }

    /// How far it goes in a direction, up to where it is long enough.
    fn free(&self, way: Vec3) -> f64 {
        let most = LONG * self.thin.diameter;
        self.part.distance().first_hit(self.thin.centre, way, 0.0, most).map_or(most, |(at, _)| at)
    }

    /// The distance to where it is wider, if that is within a length, nothing lies between and it widens there at once.
    fn foot(&self, down: Vec3, within: f64) -> Option<f64> {
        let within = self.part.distance().first_hit(self.thin.centre, down, 0.0, within).map_or(within, |(at, _)| at);
        let step = STEP * self.thin.diameter;
        let steps = (within / step).max(0.0) as usize;
        let (mut straight, mut at) = (0.0, None);
        for n in 1..=steps {
            let [ahead, behind] = self.reach(along(self.thin.centre, down, n as f64 * step));
            if ahead.max(behind) >= WIDE * self.thin.diameter {
                at = Some(n as f64 * step);
                break;
            }
            if ahead + behind <= STRAIGHT * self.thin.diameter {
                straight = n as f64 * step;
            }
        }
        at.filter(|at| at - straight <= (ABRUPT + STEP) * self.thin.diameter)
    }

    /// How far it reaches to both sides of a point, as far as that matters.
    fn reach(&self, at: Vec3) -> [f64; 2] {
        let most = WIDE * self.thin.diameter;
        [1.0, -1.0].map(|sign| {
            self.part.distance().first_hit(at, scale(self.between, sign), 0.0, most).map_or(most, |(at, _)| at)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{TriangleMesh, cuboid};
    use crate::part::Up;

    /// A plate of 20 × 10 × 3 mm with a bar of a width and height on it, or sunk into it, turned aslant.
    fn detail(width: f64, height: f64, sunk: bool) -> TriangleMesh {
        let [lo, hi] = [5.0 - 0.5 * width, 5.0 + 0.5 * width];
        let (a, b) = (if sunk { [3.0 - height, 3.0] } else { [3.0, 3.0 + height] }, [2.0, 18.0]);
        let bar = cuboid([b[0], lo, a[0]], [b[1], hi, a[1]]);
        let plate = cuboid([0.0; 3], [20.0, 10.0, 3.0]);
        let mut facets: Vec<[Vec3; 3]> = Vec::new();
        let faces = |mesh: &TriangleMesh| (0..mesh.triangles.len()).map(|f| mesh.corners(f)).collect::<Vec<_>>();
        // All of the plate but the bar's part of its top, which is a frame of four pieces.
        let is_top = |c: &[Vec3; 3], z: f64| c.iter().all(|p| p[2] == z);
        facets.extend(faces(&plate).into_iter().filter(|c| !is_top(c, 3.0)));
        facets.extend(
            faces(&bar)
                .into_iter()
                .filter(|c| !is_top(c, 3.0))
                .map(|[p, q, r]| if sunk { [p, r, q] } else { [p, q, r] }),
        );
        for [[x0, y0], [x1, y1]] in
            [[[0.0, 0.0], [20.0, lo]], [[0.0, hi], [20.0, 10.0]], [[0.0, lo], [b[0], hi]], [[b[1], lo], [20.0, hi]]]
        {
            let [p, q, r, s] = [[x0, y0, 3.0], [x1, y0, 3.0], [x1, y1, 3.0], [x0, y1, 3.0]];
            facets.extend([[p, q, r], [p, r, s]]);
        }
        TriangleMesh::weld(facets)
    }

    fn told(mesh: TriangleMesh, side: Side, thin: Thin) -> bool {
        is_relief(&Part::new(mesh, Up::PlusZ, 1e-6, 3.0).unwrap(), side, &thin)
    }

    fn thin(centre: Vec3, way: Vec3, diameter: f64) -> Thin {
        Thin { centre, contacts: [-0.5, 0.5].map(|t| along(centre, way, t * diameter)), diameter }
    }

    #[test]
    fn ridges_and_grooves_are_relief_down_to_half_their_width_and_up_to_two_millimetres() {
        for (height, relief) in [(0.3, true), (0.5, true), (1.9, true), (2.1, false)] {
            let across = [0.0, 1.0, 0.0];
            let up = thin([10.0, 5.0, 3.0 + height - 0.25], across, 0.5);
            assert_eq!(told(detail(0.5, height, false), Side::Material, up), relief, "{height} high");
            let down = thin([10.0, 5.0, 3.0 - height + 0.25], across, 0.5);
            assert_eq!(told(detail(0.5, height, true), Side::Void, down), relief, "{height} deep");
        }
    }

    #[test]
    fn the_rim_of_a_fin_that_tapers_is_no_relief() {
        // A fin of 20 × 3 mm whose sides lean towards each other by 25 degrees, up to a rim of 0.4 mm.
        let foot = 0.2 + 3.0 * 12.5f64.to_radians().tan();
        let ends = [0.0, 20.0].map(|x| [[x, -foot, 0.0], [x, foot, 0.0], [x, 0.2, 3.0], [x, -0.2, 3.0]]);
        let quad = |[p, q, r, s]: [Vec3; 4]| [[p, q, r], [p, r, s]];
        let sides = (0..4).map(|i| quad([ends[0][i], ends[1][i], ends[1][(i + 1) % 4], ends[0][(i + 1) % 4]]));
        let [[a, b, c, d], far] = ends;
        let facets = sides.chain([quad([a, b, c, d]), quad([far[3], far[2], far[1], far[0]])]).flatten();
        let fin = TriangleMesh::weld(facets.map(|[p, q, r]| [p, r, q]));
        assert!(fin.signed_volume() > 0.0);
        assert!(!told(fin, Side::Material, thin([10.0, 0.0, 2.7], [0.0, 1.0, 0.0], 0.5)));
    }

    #[test]
    fn floors_strips_webs_and_pins_are_no_relief() {
        // The floor of 0.5 mm under a groove of 2.5 mm, and a strip.
        let floor = thin([10.0, 5.0, 0.25], [0.0, 0.0, 1.0], 0.5);
        assert!(!told(detail(4.0, 2.5, true), Side::Material, floor));
        let strip = thin([10.0, 0.25, 0.5], [0.0, 1.0, 0.0], 0.5);
        assert!(!told(cuboid([0.0; 3], [20.0, 0.5, 1.0]), Side::Material, strip));
        // A bar of 0.5 × 0.5 mm, upright on a plate: as long as thick.
        let pin = cuboid([0.0; 3], [9.0, 9.0, 1.0]).joined(&cuboid([4.0, 4.0, 1.0], [4.5, 4.5, 2.5]));
        assert!(!told(pin, Side::Material, thin([4.25, 4.25, 1.8], [0.0, 1.0, 0.0], 0.5)));
    }
}
