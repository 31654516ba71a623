//! Bodies that are thin as a whole: too small for any pair of opposing sides to be a wall, a pin or a sheet.

use super::vanishing::place;
use crate::geometry::health::{Role, Shell};
use crate::geometry::vector::{Vec3, cross, dot, scale, unit};
use crate::medial::Side;
use crate::medial::inscribed::{Region, Until, largest_ball};
use crate::part::Part;
use rayon::prelude::*;

/// Facets, largest first, whose normals are tried as directions, beside the thirteen of a cube's faces, edges and corners.
const NORMALS: usize = 64;
/// The largest ball in a body is known where it differs by less than this share of the body's width from the bound on it.
const AGREE: f64 = 1e-3;
/// Points at which a ball is looked for.
const MOST: usize = 1 << 12;

/// A body that lies between two parallel planes nearer to each other than is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct ThinBody {
    /// Its number among the part's bodies, from 0.
    pub body: u32,
    /// Distance of the planes: no ball in the body is wider.
    pub width: f64,
    /// Unit normal of the planes.
    pub direction: Vec3,
    /// Middle of its box.
    pub middle: Vec3,
    pub extent: (Vec3, Vec3),
    /// One of its facets.
    pub facet: u32,
    /// Volume inside its outer shell less its cavities, mm³.
    pub volume: f64,
}

impl ThinBody {
    /// The points of the body's middle line on both planes.
    pub fn sides(&self) -> [Vec3; 2] {
        [-0.5, 0.5].map(|t| [0, 1, 2].map(|a| self.middle[a] + t * self.width * self.direction[a]))
    }
}

/// The diameter of the largest ball found in a thin body, which is no wider than it along any direction; 0 where the surface does not say
/// what is inside.
///
/// # Cost
/// Up to 4,096 nearest points.
pub fn room_in(part: &Part, b: &ThinBody) -> f64 {
    let is_own = |s: &Shell| s.role == Role::Body && s.body == b.body;
    let Some(shell) = part.health().shells.iter().position(is_own).filter(|_| part.is_plain()) else { return 0.0 };
    let enough = 0.5 * b.width - part.tie();
    let until = Until { enough, agree: AGREE * b.width, most: MOST };
    let found = largest_ball(part.distance(), Region::between(b.extent.0, b.extent.1), until, |p, nearest| {
        place(part, Side::Material, shell as u32, (p, nearest))
    });
    found.map_or(0.0, |ball| (2.0 * ball.radius).min(b.width))
}

/// The closed bodies that have a direction n, of those tried, along which they are less wide than `asked(n)`.
///
/// w(n) = max ⟨n, x⟩ − min ⟨n, x⟩ over the body; the direction taken is the one of least w(n) − asked(n). As w(n) bounds every ball in
/// the body, what is found is thin for certain; a body that is thin only along a direction not tried is not found, nor one that touches
/// another: the two may be one.
///
/// # Cost
/// O(vertices · directions) for bodies of volume at most area · widest / 2, which a body between planes that near cannot exceed; the
/// others are left out by that bound.
pub fn thin_bodies(part: &Part, asked: impl Fn(Vec3) -> f64 + Sync) -> Vec<ThinBody> {
    let (mesh, health) = (part.mesh(), part.health());
    let touching = part.body_pairs().iter().filter(|p| p.distance <= part.step());
    let joined: Vec<u32> = touching.flat_map(|p| p.bodies).collect();
    let mut facets: Vec<Vec<u32>> = vec![Vec::new(); health.bodies.len()];
    for (f, &body) in health.facet_body.iter().enumerate() {
        facets.get_mut(body as usize).into_iter().for_each(|list| list.push(f as u32));
    }
    let looked_at = |(body, facets): (usize, Vec<u32>)| {
        let volume = health.bodies.get(body).map_or(0.0, |b| b.volume_mm3);
        let area: f64 = facets.iter().map(|&f| mesh.facet_area(f as usize)).sum();
        let directions = directions(part, facets.clone());
        let widest = directions.iter().map(|n| asked(*n)).fold(0.0, f64::max);
        if facets.is_empty() || joined.contains(&(body as u32)) || volume > 0.5 * area * widest {
            return None;
        }
        let width = |n: Vec3| {
            let heights = facets.iter().flat_map(|&f| mesh.corners(f as usize)).map(|p| dot(n, p));
            let (low, high) = heights.fold((f64::INFINITY, -f64::INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            (high - low, 0.5 * (low + high))
        };
        let least =
            |a: &(Vec3, (f64, f64)), b: &(Vec3, (f64, f64))| (a.1.0 - asked(a.0)).total_cmp(&(b.1.0 - asked(b.0)));
        let (direction, (wide, level)) = directions.into_iter().map(|n| (n, width(n))).min_by(least)?;
        if wide >= asked(direction) - part.tie() {
            return None;
        }
        let facet = *facets.first()?;
        let [lo, hi] = health.bodies.get(body)?.box_mm;
        let middle = [0, 1, 2].map(|a| 0.5 * (lo[a] + hi[a]));
        let aside = level - dot(direction, middle);
        let middle = [0, 1, 2].map(|a| middle[a] + aside * direction[a]);
        Some(ThinBody { body: body as u32, width: wide, direction, middle, extent: (lo, hi), facet, volume })
    };
    facets.into_par_iter().enumerate().filter_map(looked_at).collect()
}

/// The directions in which a body's width is taken.
fn directions(part: &Part, facets: Vec<u32>) -> Vec<Vec3> {
    let mesh = part.mesh();
    let mut by_area: Vec<(f64, u32)> = facets.into_par_iter().map(|f| (mesh.facet_area(f as usize), f)).collect();
    by_area.par_sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut all: Vec<Vec3> = Vec::new();
    for n in by_area.into_iter().filter(|(area, _)| *area > 0.0).map(|(_, f)| mesh.normal(f as usize)) {
        if all.len() == NORMALS {
            break;
        }
        if all.iter().all(|m| cross(*m, n).into_iter().map(|c| c * c).sum::<f64>() > 1e-8) {
            all.push(n);
        }
    }
    let step = |n: u32| f64::from(n % 3) - 1.0;
    let cube = (0..27).map(|n| [step(n / 9), step(n / 3), step(n)]);
    // One of each pair of opposite directions.
    all.extend(cube.filter(|d| d.iter().copied().find(|c| *c != 0.0) == Some(1.0)).map(unit));
    all.into_iter()
        .map(|n| scale(n, if n.iter().copied().find(|c| *c != 0.0) < Some(0.0) { -1.0 } else { 1.0 }))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Primitive, TriangleMesh, cuboid, extruded};
    use crate::part::Up;
    use crate::units::Length;

    fn found(mesh: TriangleMesh, limit: f64) -> Vec<ThinBody> {
        thin_bodies(&Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap(), |_| limit)
    }

    #[test]
    fn a_speck_is_as_thin_as_it_is_and_a_block_is_not() {
        let ball = Primitive::parse("ball:0.25mm").unwrap().mesh(Length::mm(1e-4));
        let both = cuboid([2.0; 3], [12.0; 3]).joined(&ball);
        let all = found(both, 0.8);
        assert!(all.len() == 1 && all[0].volume < 0.07, "{all:?}");
        // No direction tried is wider than the ball, and none narrower than its inscribed one.
        assert!(all[0].width <= 0.5 + 1e-9 && all[0].width > 0.5 - 4e-4, "{all:?}");
        assert!(found(cuboid([0.0; 3], [0.3, 0.4, 0.5]), 0.8).iter().all(|b| (b.width - 0.3).abs() < 1e-9));
        assert_eq!(found(cuboid([0.0; 3], [0.3, 0.4, 0.5]), 0.8).len(), 1);
        assert!(found(cuboid([0.0; 3], [0.9, 0.9, 0.9]), 0.8).is_empty());
    }

    #[test]
    fn the_largest_ball_in_a_body_is_what_its_least_side_or_its_edges_leave_room_for() {
        let blade = |degrees: f64| {
            let (s, c) = (0.5 * degrees.to_radians()).sin_cos();
            // An isosceles triangle of legs 5 mm, its circle of radius area over half its way round.
            let mesh = extruded(&[[0.0, 0.0], [5.0 * c, -5.0 * s], [5.0 * c, 5.0 * s]], &[[0, 1, 2]], 20.0);
            (mesh, 2.0 * 25.0 * s * c / (5.0 + 5.0 * s))
        };
        let block = |a: f64| (cuboid([0.1; 3], [a + 0.1, 1.3, 1.6]), a);
        for (mesh, ball) in [blade(20.0), blade(33.0), block(1.0), block(0.4)] {
            let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
            let all = thin_bodies(&part, |_| 3.0);
            // Along a prism there are more boxes than are looked at; what is found is a ball all the same.
            let room = room_in(&part, &all[0]);
            assert!((room / ball - 0.995).abs() < 0.00501 && room <= all[0].width, "{room} {ball} {all:?}");
        }
    }

    #[test]
    fn a_turned_block_is_as_thin_as_across_its_faces() {
        let [c, s] = [0.6, 0.8];
        let mut block = cuboid([0.0; 3], [0.5, 0.7, 0.6]);
        block.vertices.iter_mut().for_each(|p| *p = [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]]);
        let all = found(block, 0.8);
        assert!(all.len() == 1 && (all[0].width - 0.5).abs() < 1e-9, "{all:?}");
        let [a, b] = all[0].sides();
        assert!((crate::geometry::vector::distance(a, b) - 0.5).abs() < 1e-9);
    }
}
