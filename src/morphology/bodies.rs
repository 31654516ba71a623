//! Bodies that overlap: the distance to their union, from the distances to each of them.
//!
//! Let dᵢ be the signed distance to body i, negative inside. The union is `{ s ≤ 0 }` with s = minᵢ dᵢ. Outside of all bodies
//! s is the distance to all facets, since none of them lies nearer than the union's surface. Inside it is how deep a point lies
//! in the body that holds it deepest, and the facets of other bodies that go on there do not count.
//!
//! Each dᵢ changes by at most a millimetre per millimetre, and so does their minimum: a ball of radius |s| about a point lies on
//! the point's side of the union. Inside, the surface of the union may be farther than −s.

use crate::geometry::distance::Nearest;
use crate::geometry::health::{NO_LABEL, Role};
use crate::geometry::vector::{Vec3, dot, sub};
use crate::geometry::{Health, MeshDistance, TriangleMesh, Winding, body_pairs};
use crate::units::Length;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Bodies touch that are no farther apart than this, in spacings.
const MEETING: f64 = 1e-6;

/// A point this far behind the plane of its nearest facet, as a share of its distance, is behind the facet and not beside it.
const BEHIND: f64 = 0.99;

/// What distances are measured to.
pub(super) struct Facets {
    pub(super) exact: MeshDistance,
    /// The bodies that the facets bound, where these overlap and their union is meant.
    pub(super) bodies: Option<Bodies>,
}

impl From<MeshDistance> for Facets {
    fn from(exact: MeshDistance) -> Self {
        Facets { exact, bodies: None }
    }
}

/// Bodies that overlap, each with its facets among those of all.
pub(super) struct Bodies {
    /// The body of each facet; [`NO_LABEL`] for facets of none.
    of_facet: Vec<u32>,
    bodies: Vec<Body>,
}

struct Body {
    box_mm: [Vec3; 2],
    winding: Winding,
}

/// What bodies are near a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Around {
    /// Facets of one body at most: the nearest facet of all is that of the union.
    One,
    /// Facets of several.
    Several,
    /// One that holds the ball, and every point of it deeper than asked.
    Within,
}

/// A ball about a block of samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ball {
    pub(super) middle: Vec3,
    pub(super) radius: f64,
}

impl Bodies {
    /// The bodies whose facets follow each other in one mesh, each closed; their winding numbers must nowhere be negative.
    pub(super) fn of(bodies: &[TriangleMesh]) -> Self {
        let numbers = (0u32..).zip(bodies);
        let of_facet = numbers.flat_map(|(body, mesh)| mesh.triangles.iter().map(move |_| body)).collect();
        Bodies { of_facet, bodies: bodies.par_iter().map(Body::of).collect() }
    }

    /// The bodies of a mesh, if it has several and some overlap or touch: pieces that close for themselves, wound outwards,
    /// each with its cavities. One body that passes through itself stays one.
    ///
    /// # Cost
    /// The health of the mesh; where boxes of bodies meet, their trees and a walk over both.
    pub(super) fn overlapping(mesh: &TriangleMesh, spacing: Length) -> Option<Self> {
        let health = Health::of(mesh);
        let outwards = health.shells.iter().all(|shell| !matches!(shell.role, Role::Open | Role::Inverted));
        if !health.is_solid() || health.inverted || !outwards {
            return None;
        }
        // What lies in the material of another body is one itself.
        let host = |shell: u32| match health.shells.get(shell as usize) {
            Some(own) if own.role == Role::Cavity => {
                health.bodies.get(own.body as usize).map_or(shell, |body| body.shell)
            }
            Some(_) => shell,
            None => NO_LABEL,
        };
        let hosts: Vec<u32> = health.facet_shell.iter().map(|&shell| host(shell)).collect();
        let overlap =
            health.count_of(Role::Swallowed) > 0 || !body_pairs(mesh, &health, MEETING * spacing.as_mm()).is_empty();
        overlap.then(|| Self::labelled(mesh, &hosts))
    }

    /// The bodies that facets with the same label form.
    fn labelled(mesh: &TriangleMesh, labels: &[u32]) -> Self {
        let mut facets: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (facet, &label) in labels.iter().enumerate().filter(|(_, label)| **label != NO_LABEL) {
            facets.entry(label).or_default().push(facet);
        }
        let numbers: BTreeMap<u32, u32> = facets.keys().copied().zip(0..).collect();
        let of_facet = labels.iter().map(|label| numbers.get(label).copied().unwrap_or(NO_LABEL)).collect();
        let facets: Vec<Vec<usize>> = facets.into_values().collect();
        let body = |facets: &Vec<usize>| Body::of(&TriangleMesh::weld(facets.iter().map(|&f| mesh.corners(f))));
        Bodies { of_facet, bodies: facets.par_iter().map(body).collect() }
    }

    /// What bodies are near a ball whose middle's nearest point is given; where several are, those that can hold a point of
    /// the ball, by their signed distance to its middle, the least first.
    ///
    /// # Cost
    /// A distance for each body whose box is near the ball; a winding number for those whose nearest point leaves the side open.
    pub(super) fn around(
        &self,
        exact: &MeshDistance,
        ball: Ball,
        nearest: &Nearest,
        deep: f64,
        list: &mut Vec<(f64, u32)>,
    ) -> Around {
        list.clear();
        let (middle, first) = (ball.middle, self.of_facet[nearest.facet as usize]);
        let reach = (nearest.distance + 2.0 * ball.radius).max(ball.radius + deep);
        let mut found: Vec<(Nearest, u32)> = Vec::new();
        for (number, body) in (0u32..).zip(&self.bodies).filter(|(_, body)| body.is_near(middle, reach)) {
            let near = if number == first { Some(*nearest) } else { self.nearest_on(exact, number, middle, reach) };
            match near {
                Some(near) => found.push((near, number)),
                None if body.holds(middle) => return Around::Within,
                None => {}
            }
        }
        if found.iter().all(|(_, number)| *number == first) {
            return Around::One;
        }
        for (near, number) in found {
            match self.holds(exact, number, middle, &near) {
                true if near.distance >= ball.radius + deep => {
                    list.clear();
                    return Around::Within;
                }
                true => list.push((-near.distance, number)),
                false if near.distance < ball.radius => list.push((near.distance, number)),
                false => {}
            }
        }
        list.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        Around::Several
    }

    /// The point nearest to p of the body that holds p deepest, of those that [`Bodies::around`] listed for a ball whose
    /// middle is `off` from p; none where none of them holds it.
    ///
    /// # Cost
    /// A distance, and perhaps a winding number, for each body that can hold the point deeper than those before.
    pub(super) fn deepest(&self, exact: &MeshDistance, p: Vec3, off: f64, list: &[(f64, u32)]) -> Option<Nearest> {
        let mut deepest: Option<Nearest> = None;
        for &(from_middle, number) in list {
            let depth = deepest.map_or(0.0, |n| n.distance);
            if from_middle - off >= -depth {
                break;
            }
            if !self.bodies[number as usize].is_near(p, 0.0) {
                continue;
            }
            let reach = (from_middle.abs() + off) * (1.0 + 1e-9);
            let near = self.nearest_on(exact, number, p, reach).filter(|near| near.distance > depth);
            deepest = near.filter(|near| self.holds(exact, number, p, near)).or(deepest);
        }
        deepest
    }

    /// The point nearest to p, nearer than `within`, of the body that a facet belongs to.
    pub(super) fn on_body_of(&self, exact: &MeshDistance, facet: u32, p: Vec3, within: f64) -> Option<Nearest> {
        self.nearest_on(exact, self.of_facet[facet as usize], p, within)
    }

    /// Whether a body holds a point whose nearest point on it is given: behind a facet it does, since the winding number is nowhere
    /// negative; elsewhere that tells, for a body may pass through itself.
    fn holds(&self, exact: &MeshDistance, number: u32, p: Vec3, near: &Nearest) -> bool {
        let height = dot(sub(p, near.point), exact.normal(near.facet));
        height < -BEHIND * near.distance || self.bodies[number as usize].holds(p)
    }

    fn nearest_on(&self, exact: &MeshDistance, number: u32, p: Vec3, within: f64) -> Option<Nearest> {
        exact.nearest_where(p, within, |facet, _| self.of_facet[facet as usize] == number)
    }
}

impl Body {
    fn of(mesh: &TriangleMesh) -> Self {
        let (lo, hi) = mesh.bounds().unwrap_or_default();
        Body { box_mm: [lo, hi], winding: Winding::new(mesh) }
    }

    /// Whether its box is nearer to a point than a length along each axis.
    fn is_near(&self, p: Vec3, reach: f64) -> bool {
        (0..3).all(|a| p[a] > self.box_mm[0][a] - reach && p[a] < self.box_mm[1][a] + reach)
    }

    /// Whether a point lies in it; on its surface rounding tells.
    fn holds(&self, p: Vec3) -> bool {
        self.is_near(p, 0.0) && self.winding.at(p) >= 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::super::offset::{Shaped, offset};
    use super::super::rolling::close_by_ball;
    use super::*;
    use crate::geometry::{Primitive, cuboid, revolved};
    use crate::random::Lcg;

    type Block = [Vec3; 2];

    fn joined(bodies: &[TriangleMesh]) -> TriangleMesh {
        bodies.iter().fold(TriangleMesh::default(), |all, body| all.joined(body))
    }

    fn blocks(corners: &[Block]) -> TriangleMesh {
        joined(&corners.iter().map(|&[lo, hi]| cuboid(lo, hi)).collect::<Vec<_>>())
    }

    /// The signed distance to a block.
    fn to_block(p: Vec3, [lo, hi]: Block) -> f64 {
        let off = [0, 1, 2].map(|a| (lo[a] - p[a]).max(p[a] - hi[a]));
        let beyond = off.map(|x| x.max(0.0));
        beyond[0].hypot(beyond[1]).hypot(beyond[2]) + off.into_iter().fold(f64::MIN, f64::max).min(0.0)
    }

    fn holds_volume(made: &Shaped, truth: f64) {
        let [low, high] = made.volume.map(|v| v.as_mm3());
        assert!(low <= truth && truth <= high, "{truth} not in {low} … {high}");
    }

    /// The signed distance to the union, each body by itself and all of its facets one by one.
    fn plainly(bodies: &[TriangleMesh], windings: &[Winding], p: Vec3) -> f64 {
        let to_one = |(mesh, winding): (&TriangleMesh, &Winding)| {
            let exact = MeshDistance::new(mesh);
            let distance = exact.nearest(p, f64::INFINITY).unwrap().distance;
            if winding.at(p) >= 0.5 { -distance } else { distance }
        };
        bodies.iter().zip(windings).map(to_one).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn samples_near_a_union_have_the_least_distance_of_its_bodies() {
        let mut random = Lcg(4);
        let ball = Primitive::parse("ball:1.6mm").unwrap().mesh(Length::mm(0.01));
        let ring = revolved(&[[1.0, 0.0], [2.0, 0.0], [2.5, 0.5], [1.5, 1.0]], 24);
        let hollow = cuboid([-1.5; 3], [1.5; 3]).joined(&cuboid([-0.8; 3], [0.8; 3]).flipped());
        let parts = [cuboid([-1.0, -0.6, -2.0], [1.0, 0.6, 2.0]), ring, hollow, ball];
        let bodies: Vec<TriangleMesh> =
            parts.map(|part| part.transformed(random.rotation(), random.point(-0.7, 0.7))).into();
        let windings: Vec<Winding> = bodies.iter().map(Winding::new).collect();
        let h = 0.2;
        for by in [0.0, 0.13, 0.3] {
            let field = offset(&joined(&bodies), Length::mm(by), Length::mm(h)).unwrap().field;
            let (grid, mut compared) = (*field.grid(), 0);
            for (at, &found) in field.values().iter().enumerate().step_by(5) {
                let found = f64::from(found);
                if found.abs() > 1.5 * h {
                    continue;
                }
                let want = plainly(&bodies, &windings, grid.position(grid.index(at))) - by;
                let close = want.abs() <= h;
                assert!((found - want).abs() < 1e-5 || !close && found.abs() > 0.99 * h, "{found} {want}");
                assert!(want.abs() < 1e-5 || found.signum() == want.signum(), "{found} {want}");
                compared += usize::from(close);
            }
            assert!(compared > 500, "{compared}");
        }
    }

    #[test]
    fn overlapping_blocks_are_united_to_their_creases() {
        let h = 0.25;
        let cases: [(&str, Vec<Block>, f64); 5] = [
            (
                "corners in each other",
                vec![[[0.0; 3], [4.0; 3]], [[2.1, 2.3, 1.9], [6.0, 5.0, 5.5]]],
                64.0 + 37.908 - 1.9 * 1.7 * 2.1,
            ),
            ("one in the other", vec![[[0.0; 3], [4.0; 3]], [[1.0; 3], [2.5; 3]]], 64.0),
            (
                "one through the other",
                vec![[[0.0; 3], [4.0; 3]], [[-1.0, 1.1, 1.3], [5.3, 2.4, 2.9]]],
                64.0 + 2.3 * 1.3 * 1.6,
            ),
            ("an L", vec![[[0.0; 3], [6.0, 2.0, 2.0]], [[0.0; 3], [2.0, 5.0, 2.0]]], 24.0 + 12.0),
            ("touching", vec![[[0.0; 3], [3.0; 3]], [[3.0, 0.5, 0.6], [5.0, 2.5, 2.2]]], 27.0 + 2.0 * 2.0 * 1.6),
        ];
        for (name, corners, truth) in cases {
            let made = offset(&blocks(&corners), Length::mm(0.0), Length::mm(h)).unwrap();
            let off = |p: &Vec3| corners.iter().map(|&block| to_block(*p, block)).fold(f64::INFINITY, f64::min).abs();
            let worst = made.mesh.vertices.iter().map(off).fold(0.0, f64::max);
            let relative = made.mesh.signed_volume() / truth - 1.0;
            println!("{name}: volume {relative:.1e}, vertices {worst:.1e} mm off, {:?}", made.volume);
            holds_volume(&made, truth);
            assert!(relative.abs() < 1e-4, "{name}: {relative}");
            assert!(worst < 0.01 * h, "{name}: {worst}");
        }
    }

    #[test]
    fn unions_grow_by_less_than_a_spacing_and_close_from_their_own_surface() {
        let h = 0.25;
        let corners = [[[0.0; 3], [4.0; 3]], [[-1.0, 1.1, 1.3], [5.3, 2.4, 2.9]]];
        let s = |p: Vec3| corners.iter().map(|&block| to_block(p, block)).fold(f64::INFINITY, f64::min);
        for by in [0.05, 0.15, 0.3] {
            let made = offset(&blocks(&corners), Length::mm(by), Length::mm(h)).unwrap();
            let worst = made.mesh.vertices.iter().map(|&p| by - s(p)).fold(0.0, f64::max);
            println!("+ {by} mm: vertices {worst} mm inside at most");
            // Where the round edges of one block meet the other's faces, what is rounder than the cells are fine is cut: √½ of it at
            // most.
            assert!(worst < 0.3 * by + 0.01 * h, "{by}: {worst}");
        }
        let closed = close_by_ball(&blocks(&corners), Length::mm(0.5), Length::mm(h)).unwrap();
        let worst = closed.mesh.vertices.iter().map(|&p| -s(p)).fold(0.0, f64::max);
        println!("closed: vertices {worst} mm inside at most");
        assert!(worst < 0.01 * h, "{worst}");
    }

    #[test]
    fn bodies_apart_and_single_ones_are_no_union() {
        let of = |mesh: &TriangleMesh| Bodies::overlapping(mesh, Length::mm(0.2)).map(|b| b.bodies.len());
        let one: Block = [[0.0; 3], [2.0; 3]];
        assert_eq!(of(&blocks(&[one])), None);
        assert_eq!(of(&blocks(&[one, [[3.0; 3], [4.0; 3]]])), None);
        // A hollow block, and a block in the hollow.
        let hollow = blocks(&[[[-3.0; 3], [5.0; 3]]]).joined(&blocks(&[[[-2.0; 3], [4.0; 3]]]).flipped());
        assert_eq!(of(&hollow), None);
        assert_eq!(of(&hollow.clone().joined(&blocks(&[one]))), None);
        assert_eq!(of(&hollow.joined(&blocks(&[[[0.0; 3], [6.0, 1.0, 1.0]]]))), Some(2));
        assert_eq!(of(&blocks(&[one, [[1.0; 3], [4.0; 3]], [[8.0; 3], [9.0; 3]]])), Some(3));
        assert_eq!(of(&blocks(&[one, one]).flipped()), None);
    }
}
