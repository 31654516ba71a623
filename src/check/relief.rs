//! Raised and engraved detail: what ends on one side and widens on the other, little apart.

use super::detail::Thin;
use crate::geometry::vector::{Vec3, along, cross, dot, norm, scale, unit};
use crate::medial::Side;
use crate::medial::section::across;
use crate::part::Part;
use std::f64::consts::TAU;

/// What rises or sinks by no more than this is relief, millimetres; and how near to it a height is told.
const RELIEF_MM: f64 = 2.0;
const TOLD_MM: f64 = 1e-6;

/// Directions in which a rim is looked for, and the least cosine between one and the rim's normal: a little more than half of what lies
/// between two. Rims whose normals have a greater cosine are one.
const DIRECTIONS: usize = 16;
const ACROSS_RIM: f64 = 0.9;
const SAME: f64 = 0.9999;

/// What reaches so many thicknesses to one side is wider.
const WIDE: f64 = 1.5;

/// What is so many thicknesses thick still belongs to the stroke, and from the last such place it is so many to where it is wider: what
/// tapers all the way has no foot.
const STRAIGHT: f64 = 1.4;
const ABRUPT: f64 = 1.0;

/// A stroke is looked at so many thicknesses before the face that it ends with: none that is lower than twice that is one.
const BELOW_RIM: f64 = 0.25;

/// A stroke is so many thicknesses long at least, so that no pin or dot is one.
const LONG: f64 = 1.5;

/// How far along a stroke its height is asked again, millimetres, in steps of so many thicknesses: what rises there is the tip of a rib.
const ASKED_AGAIN_MM: [f64; 3] = [2.0, 4.0, 8.0];
const STRIDE: f64 = 0.5;

/// Steps to where it widens, in thicknesses, and halvings of the last one.
const STEP: f64 = 0.0625;
const HALVINGS: usize = 24;

/// The stroke that what is thin at a place is, if that is raised on a wider piece of its side of the surface, or sunk below it, by at most two
/// millimetres: straight between its sides and square to a face it ends, the other way it widens, and along neither it is longer than thick.
///
/// # Cost
/// Some hundred rays for each face that it may end with.
pub fn relief<'a>(part: &'a Part, side: Side, thin: &Thin) -> Option<Stroke<'a>> {
    let (between, [u, v]) = (thin.direction(), across(thin.direction()));
    let mut rims: Vec<Vec3> = Vec::new();
    for k in 0..DIRECTIONS {
        let (s, c) = (TAU * k as f64 / DIRECTIONS as f64).sin_cos();
        let up = [0, 1, 2].map(|a| c * u[a] + s * v[a]);
        let stroke = Stroke { part, side, centre: thin.centre, diameter: thin.diameter, between, up };
        let Some((_, facet)) = stroke.rim() else { continue };
        let normal = scale(part.distance().normal(facet), side.sign());
        let up = unit(along(normal, between, -dot(normal, between)));
        if rims.iter().all(|rim| dot(*rim, up) < SAME) {
            rims.push(up);
            if let Some(ending) = stroke.ending(up).filter(|s| s.foot().is_some() && !s.grows()) {
                return Some(ending);
            }
        }
    }
    None
}

/// Something thin, from a place midway between its sides, and a way in which it may end.
#[derive(Clone, Copy)]
pub struct Stroke<'a> {
    pub(super) part: &'a Part,
    pub(super) side: Side,
    pub(super) centre: Vec3,
    pub(super) diameter: f64,
    /// Unit vectors from side to side, and to the face that it ends with.
    pub(super) between: Vec3,
    pub(super) up: Vec3,
}

impl Stroke<'_> {
    /// The same from a little before the face that it ends with, in the middle of how far it goes on as thin there, so that no place of a stroke
    /// says more than another; `None` if it is wider before that face, or no longer than thick.
    fn ending(self, up: Vec3) -> Option<Self> {
        let level = Stroke { up, ..self }.rim()?.0 - BELOW_RIM * self.diameter;
        let stroke = Stroke { centre: along(self.centre, up, level), up, ..self };
        let ways = stroke.ways();
        let free = ways.map(|way| stroke.clear(stroke.centre, way, LONG * self.diameter));
        if free.iter().sum::<f64>() < LONG * self.diameter {
            return None;
        }
        // A place where it runs into another sees past the corner there on one side.
        let [forth, back] = [0, 1].map(|i| stroke.as_thin(ways[i], free[i]));
        let place = along(stroke.centre, ways[0], 0.5 * (forth - back));
        let [ahead, behind] = stroke.reach(place);
        let centre = along(place, self.between, 0.5 * (ahead - behind));
        let steps = (level / (STEP * self.diameter)).max(0.0) as usize;
        let below = |n: usize| along(centre, up, n as f64 * -STEP * self.diameter);
        (0..=steps).all(|n| stroke.is_thin(below(n))).then_some(Stroke { centre, ..stroke })
    }

    /// Forth and back along it.
    pub(super) fn ways(&self) -> [Vec3; 2] {
        [1.0, -1.0].map(|sign| scale(cross(self.between, self.up), sign))
    }

    /// The distance from a point to the surface in a direction, or a length if that is less.
    pub(super) fn clear(&self, from: Vec3, way: Vec3, most: f64) -> f64 {
        self.part.distance().first_hit(from, way, 0.0, most).map_or(most, |(at, _)| at)
    }

    /// How far it goes on as thin in a direction, within a length.
    pub(super) fn as_thin(&self, way: Vec3, within: f64) -> f64 {
        let step = STEP * self.diameter;
        let steps = (within / step) as usize;
        let wider = (1..=steps).map(|n| n as f64 * step).find(|at| !self.is_thin(along(self.centre, way, *at)));
        wider.map_or(within, |at| at - step)
    }

    /// The distance to a face across the way, and that face; looked for from a little before the middle, which may lie on it.
    fn rim(&self) -> Option<(f64, u32)> {
        let before = STEP * self.diameter;
        let from = along(self.centre, self.up, -before);
        let (at, facet) = self.part.distance().first_hit(from, self.up, 0.0, RELIEF_MM + before + TOLD_MM)?;
        let is_across = self.side.sign() * dot(self.part.distance().normal(facet), self.up) >= ACROSS_RIM;
        is_across.then_some((at - before, facet))
    }

    /// Whether it is as thin at a point as at the middle, or little thicker.
    fn is_thin(&self, at: Vec3) -> bool {
        self.reach(at).into_iter().sum::<f64>() <= STRAIGHT * self.diameter
    }

    /// The distance to where it is wider, if that is little from the face that it ends with, nothing lies between and it widens there at once.
    pub(super) fn foot(&self) -> Option<f64> {
        let within = RELIEF_MM + self.part.tie() + TOLD_MM - self.rim()?.0;
        let [down, step] = [scale(self.up, -1.0), scale(self.up, -STEP * self.diameter)];
        let blocked = self.part.distance().first_hit(self.centre, down, 0.0, within).map(|(at, _)| at);
        let below = |steps: f64| along(self.centre, step, steps);
        let is_wide = |steps: f64| self.reach(below(steps)).into_iter().any(|r| r >= WIDE * self.diameter);
        let count = (blocked.unwrap_or(within) / norm(step)).max(0.0).ceil();
        let (mut straight, mut wide) = (0.0, None);
        for steps in (1..=count as usize).map(|n| n as f64) {
            if is_wide(steps) {
                wide = Some(steps);
                break;
            }
            if self.is_thin(below(steps)) {
                straight = steps;
            }
        }
        let mut high = wide?;
        let mut low = high - 1.0;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if is_wide(middle) { high = middle } else { low = middle }
        }
        let at = high * norm(step);
        // Beyond what blocks the way it is the other side that is wide.
        let is_foot = at <= within
            && blocked.is_none_or(|blocked| at < blocked - TOLD_MM)
            && at - straight * norm(step) <= (ABRUPT + STEP) * self.diameter;
        is_foot.then_some(at)
    }

    /// Whether it goes on, as thin and to the same face, to where it is higher than relief is.
    fn grows(&self) -> bool {
        let stride = STRIDE * self.diameter;
        self.ways().into_iter().any(|way| {
            let mut at = *self;
            let mut gone = 0.0;
            ASKED_AGAIN_MM.into_iter().any(|asked| {
                while gone < asked {
                    let next = Stroke { centre: along(at.centre, way, stride), ..at };
                    if at.clear(at.centre, way, stride) < stride || !next.is_thin(next.centre) {
                        return false;
                    }
                    (at, gone) = (next, gone + stride);
                }
                at.is_high()
            })
        })
    }

    /// Whether it stays as thin from a face near its middle until it is too high for relief.
    fn is_high(&self) -> bool {
        let Some((rim, _)) = self.rim().filter(|(at, _)| *at <= 2.0 * BELOW_RIM * self.diameter) else { return false };
        let (within, stride) = (RELIEF_MM + self.part.tie() + TOLD_MM - rim, STRIDE * self.diameter);
        let down = scale(self.up, -1.0);
        let steps = (within / stride).ceil() as usize;
        self.clear(self.centre, down, within) >= within
            && (1..=steps).all(|n| self.is_thin(along(self.centre, down, (n as f64 * stride).min(within))))
    }

    /// How far it reaches to both sides of a point, as far as that matters.
    pub(super) fn reach(&self, at: Vec3) -> [f64; 2] {
        [1.0, -1.0].map(|sign| self.clear(at, scale(self.between, sign), WIDE * self.diameter))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{TriangleMesh, cuboid};
    use crate::part::Up;

    /// A plate of 20 × 10 mm, from z = 0 to 3, with a bar of a width and height on it, or sunk into it.
    fn detail(width: f64, height: f64, sunk: bool) -> TriangleMesh {
        detail_on(0.0, width, height, sunk)
    }

    /// The same with the bottom of the plate elsewhere.
    fn detail_on(bottom: f64, width: f64, height: f64, sunk: bool) -> TriangleMesh {
        let [lo, hi] = [5.0 - 0.5 * width, 5.0 + 0.5 * width];
        let (a, b) = (if sunk { [3.0 - height, 3.0] } else { [3.0, 3.0 + height] }, [2.0, 18.0]);
        let bar = cuboid([b[0], lo, a[0]], [b[1], hi, a[1]]);
        let plate = cuboid([0.0, 0.0, bottom], [20.0, 10.0, 3.0]);
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
        relief(&Part::new(mesh, Up::PlusZ, 1e-6, 3.0).unwrap(), side, &thin).is_some()
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
    fn a_fin_or_a_slot_is_relief_by_its_height_wherever_it_is_asked_and_however_it_is_turned() {
        for (height, sunk) in [1.0, 1.9, 2.0, 2.1, 3.0, 6.0].into_iter().flat_map(|h| [(h, false), (h, true)]) {
            let mesh = detail_on(-9.0, 0.5, height, sunk);
            let [low, high] = if sunk { [3.0 - height, 3.0] } else { [3.0, 3.0 + height] };
            let side = if sunk { Side::Void } else { Side::Material };
            for degrees in [0.0f64, 10.0, 30.0, 45.0, 67.0] {
                let (s, c) = degrees.to_radians().sin_cos();
                let turn = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
                let part = Part::new(mesh.transformed(turn, [7.3, -1.9, 9.0]), Up::PlusZ, 1e-6, 3.0).unwrap();
                let turned = |p: Vec3| [c * p[0] - s * p[1] + 7.3, s * p[0] + c * p[1] - 1.9, p[2] + 9.0];
                for x in [2.0001, 2.1, 2.4, 6.0, 10.0, 17.8, 17.9999] {
                    for z in [low + 1e-4, low + 0.05, low + 0.4, 0.5 * (low + high), high - 0.2, high - 1e-4] {
                        let at = |y: f64| part.to_build(turned([x, y, z]));
                        let thin = Thin { centre: at(5.0), contacts: [at(4.75), at(5.25)], diameter: 0.5 };
                        let told = relief(&part, side, &thin).is_some();
                        assert_eq!(told, height <= 2.0, "{height} {sunk} {degrees} {x} {z}");
                    }
                }
            }
        }
        // The dot of an i, 0.6 mm long and 0.5 mm wide, 1 mm high, and one half as long again as wide.
        for (long, relief) in [(0.6, false), (0.8, true)] {
            let dot = cuboid([0.0; 3], [9.0, 9.0, 3.0]).joined(&cuboid([4.0, 4.0, 3.0], [4.0 + long, 4.5, 4.0]));
            for degrees in [0.0f64, 10.0, 30.0, 45.0] {
                let (s, c) = degrees.to_radians().sin_cos();
                let turned = |p: Vec3| [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]];
                let mesh = dot.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);
                let part = Part::new(mesh, Up::PlusZ, 1e-6, 3.0).unwrap();
                let centre = part.to_build(turned([4.0 + 0.5 * long, 4.25, 3.6]));
                let thin = thin(centre, turned([0.0, 1.0, 0.0]), 0.5);
                assert_eq!(super::relief(&part, Side::Material, &thin).is_some(), relief, "{long} {degrees}");
            }
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
    fn the_tip_of_a_gusset_is_no_relief() {
        // A rib of 0.85 mm whose edge climbs from the base, and a low one of 1.5 mm that climbs to no more.
        let rib = |long: f64, high: f64| {
            let side = |y: f64| [[0.0, y, 0.0], [long, y, 0.0], [0.0, y, high]];
            let ([a, b, c], [d, e, f]) = (side(4.0), side(4.85));
            let facets = [[a, b, c], [d, f, e], [a, d, e], [a, e, b], [b, e, f], [b, f, c], [c, f, d], [c, d, a]];
            cuboid([-3.0, 0.0, -3.0], [40.0, 9.0, 0.0]).joined(&TriangleMesh::weld(facets))
        };
        for (long, high, relief) in [(27.0, 27.0, false), (27.0, 9.0, false), (9.0, 27.0, false), (27.0, 1.5, true)] {
            let mesh = rib(long, high);
            assert!(mesh.signed_volume() > 43.0 * 27.0, "outwards");
            let part = Part::new(mesh, Up::PlusZ, 1e-6, 3.0).unwrap();
            let asked = (1..40).map(|n| long * (1.0 - 0.005 * f64::from(n)));
            let told = asked.filter(|&x| {
                let z = 0.6 * high * (1.0 - x / long);
                let at = |y: f64| part.to_build([x, y, z]);
                let thin = Thin { centre: at(4.425), contacts: [at(4.0), at(4.85)], diameter: 0.85 };
                super::relief(&part, Side::Material, &thin).is_some()
            });
            let told = told.count();
            assert_eq!(told > 0, relief, "{long} × {high}: {told}");
        }
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
