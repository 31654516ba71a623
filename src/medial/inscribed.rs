//! The largest ball in a piece of material or void, however many sides it lies between, or about a point: found, and bounded from above.

use crate::geometry::MeshDistance;
use crate::geometry::distance::Nearest;
use crate::geometry::vector::{Vec3, along, distance, dot, norm, norm2, sub, unit};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Shares of a ball by which its centre is moved to make it larger.
const STEPS: usize = 40;
/// Points of the surface that are remembered about a point that a ball is to contain.
const WALLS: usize = 16;
/// Points of the surface between which a ball is held.
const MEETING: usize = 4;
/// A vector that is moved towards another by less than this share of the way is as good as the shortest.
const LEAST_SHARE: f64 = 1e-12;

/// A box with its own axes, in which the centre is sought; half edges of zero make it a rectangle.
#[derive(Debug, Clone, Copy)]
pub struct Region {
    pub centre: Vec3,
    /// Unit vectors at right angles to each other.
    pub axes: [Vec3; 3],
    pub half: [f64; 3],
}

impl Region {
    /// The box between two corners.
    pub fn between(lo: Vec3, hi: Vec3) -> Self {
        Region {
            centre: [0, 1, 2].map(|a| 0.5 * (lo[a] + hi[a])),
            axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            half: [0, 1, 2].map(|a| 0.5 * (hi[a] - lo[a])),
        }
    }

    /// The six boxes about this one that make up one that reaches farther by a length on all sides.
    pub(super) fn around(&self, by: f64) -> [Region; 6] {
        let mut half = self.half;
        [0, 1, 2, 3, 4, 5].map(|side| {
            let (axis, sign) = (side / 2, if side % 2 == 0 { -1.0 } else { 1.0 });
            let centre = along(self.centre, self.axes[axis], sign * (self.half[axis] + 0.5 * by));
            let mut slab = half;
            slab[axis] = 0.5 * by;
            if side % 2 == 1 {
                half[axis] += by;
            }
            Region { centre, half: slab, ..*self }
        })
    }

    /// Both halves, across the longest edge.
    pub(super) fn halves(&self) -> [Region; 2] {
        let longest = (0..3).max_by(|&a, &b| self.half[a].total_cmp(&self.half[b])).unwrap_or(0);
        let mut half = self.half;
        half[longest] *= 0.5;
        [-1.0, 1.0].map(|t| Region { centre: along(self.centre, self.axes[longest], t * half[longest]), half, ..*self })
    }
}

/// Where the middle of a part of the region lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// In the piece that is measured: a ball there counts.
    Within,
    /// Elsewhere: no ball there counts.
    Off,
    /// It is not said which.
    Unknown,
}

/// How far the search goes, lengths in millimetres.
#[derive(Debug, Clone, Copy)]
pub struct Until {
    /// A ball of this radius ends it: the piece is as wide as that.
    pub enough: f64,
    /// Bound and ball that differ by less are one.
    pub agree: f64,
    /// Points at which the distance to the surface may be asked for.
    pub most: usize,
}

/// The largest ball that was found, and a bound on all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Largest {
    pub centre: Vec3,
    /// Its radius: it is really there.
    pub radius: f64,
    /// No ball of the piece is larger.
    pub high: f64,
}

/// The largest ball of a piece whose centre lies in a region; `None` where no point of the piece was met.
///
/// The distance d to the surface changes by no more than the way: no ball about a point of a box of half diagonal h about c is larger than
/// d(c) + h. The box of the greatest bound is halved until that is `agree` beyond the largest ball found. A box with d(c) ≥ h that is off the
/// piece at c is off it altogether, and left. `place` tells where a point lies, given what of the surface is nearest to it.
///
/// # Cost
/// One nearest point for each box. A piece that is as wide all along, a prism or a plate, takes its length or its area over `agree`, or its
/// square; `most` ends that, and leaves the bound high.
pub fn largest_ball(
    surface: &MeshDistance,
    region: Region,
    until: Until,
    place: impl Fn(Vec3, &Nearest) -> Place,
) -> Option<Largest> {
    let look = |region: Region, found: &mut Option<(Vec3, f64)>| {
        let reach = norm(region.half);
        let nearest = surface.nearest(region.centre, f64::INFINITY)?;
        let larger = found.is_none_or(|(_, r)| nearest.distance > r);
        // Where a point lies is asked for only if it matters.
        let asked = larger || nearest.distance >= reach;
        let at = if asked { place(region.centre, &nearest) } else { Place::Unknown };
        if at == Place::Within && larger {
            *found = Some((region.centre, nearest.distance));
        }
        let off = at == Place::Off && nearest.distance >= reach;
        (!off).then_some(nearest.distance + reach)
    };
    let (centre, radius, high) = halved((region, None), until, look)?;
    let (centre, radius) = settled(surface, &region, (centre, radius), (until.agree, &place));
    Some(Largest { centre, radius, high: high.max(radius) })
}

/// The largest ball that contains a point, or a small ball about it, and lies on its side of the surface: half the local thickness there, and
/// what an opening may go to before it takes the point.
///
/// τ(x) = max { r : |p − x| + m ≤ r ≤ d(p) } with the radius m of the small ball. The search is that of [`largest_ball`] in a cube about the
/// point. A larger ball that contains the point holds one of `enough` that does, so that no centre need be farther off than that. A box with
/// |c − x| + m > d(c) + 2 h about c has none; nor has one that lies nearer to a point of the surface than to x. `None` where the surface is empty.
///
/// # Cost
/// As [`largest_ball`].
///
/// # Source
/// T. Hildebrand, P. Rüegsegger, A new method for the model-independent assessment of thickness in three-dimensional images, 1997.
pub fn largest_containing(surface: &MeshDistance, (at, margin): (Vec3, f64), until: Until) -> Option<Largest> {
    let own = surface.nearest(at, f64::INFINITY)?;
    let mut walls = vec![own.point];
    let look = |region: Region, found: &mut Option<(Vec3, f64)>| {
        let reach = norm(region.half);
        let from = |q: Vec3| norm2(sub(region.centre, q));
        // How far the middle is beyond the plane between the two points.
        let beyond = |wall: &Vec3| (from(at) - from(*wall)) / (2.0 * distance(at, *wall)).max(f64::MIN_POSITIVE);
        if walls.iter().any(|wall| beyond(wall) > reach) {
            return None;
        }
        let near = surface.nearest(region.centre, f64::INFINITY)?;
        let off = distance(region.centre, at) + margin - near.distance;
        if off > 0.0 && walls.len() < WALLS {
            walls.push(near.point);
        }
        if off <= 0.0 && found.is_none_or(|(_, r)| near.distance > r) {
            *found = Some((region.centre, near.distance));
        }
        (off <= 2.0 * reach).then_some(near.distance + reach)
    };
    let region = Region { half: [until.enough; 3], ..Region::between(at, at) };
    let (centre, radius, high) = halved((region, Some((at, own.distance))), until, look)?;
    let (centre, radius) = grown(surface, (at, margin), (centre, radius), (until.agree, until.enough));
    Some(Largest { centre, radius, high: high.max(radius) })
}

/// A ball that contains a point, or a small ball about it, made as large as moving its centre makes it, by steps from the first down, or as
/// large as is enough: a lower bound of [`largest_containing`] that takes some hundred nearest points.
///
/// The distance grows fastest along the shortest vector in the hull of the directions away from all points of the surface that are nearest.
/// One of these is known at once; a step that leads to no more meets another.
pub fn grown(
    surface: &MeshDistance,
    (at, margin): (Vec3, f64),
    ball: (Vec3, f64),
    (first, enough): (f64, f64),
) -> (Vec3, f64) {
    let (mut centre, mut radius) = ball;
    let away = |p: Vec3, near: &Nearest| unit(sub(p, near.point));
    let (mut step, mut known): (f64, Vec<Vec3>) = (first, Vec::new());
    for _ in 0..2 * STEPS {
        if radius >= enough {
            break;
        }
        if known.is_empty() {
            known.extend(surface.nearest(centre, f64::INFINITY).map(|near| away(centre, &near)));
        }
        let p = along(centre, unit(shortest(&known)), step);
        let Some(near) = surface.nearest(p, f64::INFINITY) else { break };
        if near.distance > radius && distance(p, at) + margin <= near.distance {
            (centre, radius) = (p, near.distance);
            known = vec![away(p, &near)];
        } else if known.len() < MEETING {
            known.push(away(p, &near));
        } else {
            step *= 0.5;
            known.clear();
        }
    }
    (centre, radius)
}

/// The shortest vector in the convex hull of some, nearly: E. G. Gilbert, An iterative procedure for computing the minimum of a quadratic
/// form on a convex set, 1966.
fn shortest(all: &[Vec3]) -> Vec3 {
    let mut v = all.first().copied().unwrap_or_default();
    for _ in 0..STEPS {
        let Some(least) = all.iter().copied().min_by(|a, b| dot(v, *a).total_cmp(&dot(v, *b))) else { break };
        let way = sub(least, v);
        let far = norm2(way);
        let share = (-dot(v, way) / far.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        if share <= LEAST_SHARE {
            break;
        }
        v = along(v, way, share);
    }
    v
}

/// Halves the box of the greatest bound until that is `agree` beyond the largest ball found: that ball's centre and radius, and the bound on
/// all. `look` takes note of a ball about the middle of a box, and bounds those of the box, if any counts.
fn halved(
    (region, mut found): (Region, Option<(Vec3, f64)>),
    until: Until,
    mut look: impl FnMut(Region, &mut Option<(Vec3, f64)>) -> Option<f64>,
) -> Option<(Vec3, f64, f64)> {
    let mut open = BinaryHeap::new();
    let mut looked =
        |region: Region, found: &mut Option<(Vec3, f64)>| look(region, found).map(|bound| Bounded { bound, region });
    open.extend(looked(region, &mut found));
    let mut taken = 1;
    while let Some(first) = open.pop() {
        let radius = found.map_or(0.0, |f| f.1);
        if first.bound <= radius + until.agree || radius >= until.enough || taken >= until.most {
            open.push(first);
            break;
        }
        for half in first.region.halves() {
            taken += 1;
            open.extend(looked(half, &mut found));
        }
    }
    let (centre, radius) = found?;
    Some((centre, radius, open.peek().map_or(radius, |first| first.bound)))
}

/// A ball made as large as moving its centre along the axes of the region makes it, by steps that become smaller.
fn settled(
    surface: &MeshDistance,
    region: &Region,
    (mut centre, mut radius): (Vec3, f64),
    (mut step, place): (f64, &impl Fn(Vec3, &Nearest) -> Place),
) -> (Vec3, f64) {
    // Along a half edge of zero the centre stays where it is.
    let axes: Vec<Vec3> = (0..3).filter(|&a| region.half[a] > 0.0).map(|a| region.axes[a]).collect();
    let aslant = |(a, &u): (usize, &Vec3)| {
        let later: Vec<Vec3> = axes.iter().skip(a + 1).flat_map(|&v| [along(u, v, 1.0), along(u, v, -1.0)]).collect();
        later
    };
    let ways: Vec<Vec3> = axes.iter().copied().chain(axes.iter().enumerate().flat_map(aslant)).collect();
    for _ in 0..STEPS {
        let tries = ways.iter().flat_map(|&way| [-step, step].map(|t| along(centre, way, t)));
        let larger = tries.filter_map(|p| {
            let nearest = surface.nearest(p, f64::INFINITY)?;
            (nearest.distance > radius && place(p, &nearest) == Place::Within).then_some((p, nearest.distance))
        });
        match larger.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some(better) => (centre, radius) = better,
            None => step *= 0.5,
        }
    }
    (centre, radius)
}

/// A box with its bound, in the order of bounds.
struct Bounded {
    bound: f64,
    region: Region,
}

impl Ord for Bounded {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

impl PartialOrd for Bounded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Bounded {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Bounded {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{TriangleMesh, Winding};
    use crate::random::Lcg;

    fn largest(mesh: &TriangleMesh, until: Until) -> Largest {
        let (surface, winding) = (MeshDistance::new(mesh), Winding::new(mesh));
        let (lo, hi) = mesh.bounds().unwrap();
        let place = |p: Vec3, _: &Nearest| if winding.at(p) > 0.5 { Place::Within } else { Place::Off };
        largest_ball(&surface, Region::between(lo, hi), until, place).unwrap()
    }

    #[test]
    fn a_tetrahedron_holds_the_ball_that_touches_its_four_faces() {
        let mut rng = Lcg(5);
        for _ in 0..60 {
            let [a, b, c, d] = [0; 4].map(|_| [0; 3].map(|_| rng.unit()));
            let mut mesh = TriangleMesh::weld([[a, c, b], [a, b, d], [b, c, d], [c, a, d]]);
            if mesh.signed_volume() < 0.0 {
                mesh = mesh.flipped();
            }
            let area: f64 = (0..4).map(|f| mesh.facet_area(f)).sum();
            let inscribed = 3.0 * mesh.signed_volume() / area;
            if inscribed < 0.03 {
                continue;
            }
            let found = largest(&mesh, Until { enough: f64::INFINITY, agree: 1e-3, most: 1 << 16 });
            assert!(found.radius <= inscribed + 1e-9 && found.high >= inscribed - 1e-9, "{found:?} {inscribed}");
            assert!(
                found.radius > inscribed - 1e-3 && found.high <= found.radius + 1e-3 + 1e-9,
                "{found:?} {inscribed}"
            );
        }
    }

    #[test]
    fn a_search_that_ends_early_leaves_the_bound_high() {
        let mesh = crate::geometry::cuboid([0.0; 3], [4.0, 3.0, 2.0]);
        let whole = largest(&mesh, Until { enough: f64::INFINITY, agree: 0.05, most: 1 << 16 });
        assert!((whole.radius - 1.0).abs() < 1e-6 && whole.high < 1.051, "{whole:?}");
        let enough = largest(&mesh, Until { enough: 0.4, agree: 0.01, most: 1 << 16 });
        assert!(enough.radius >= 0.4 && enough.high >= 1.0, "{enough:?}");
        let few = largest(&mesh, Until { enough: f64::INFINITY, agree: 1e-3, most: 20 });
        assert!(few.radius <= 1.0 + 1e-9 && few.high >= 1.0, "{few:?}");
    }
}
