//! The largest ball in a piece of material or void, however many sides it lies between: found, and bounded from above.

use crate::geometry::MeshDistance;
use crate::geometry::distance::Nearest;
use crate::geometry::vector::{Vec3, along, norm};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Shares of a ball by which its centre is moved to make it larger.
const STEPS: usize = 40;

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

    /// Both halves, across the longest edge.
    fn halves(&self) -> [Region; 2] {
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
    let mut found: Option<(Vec3, f64)> = None;
    let mut open = BinaryHeap::new();
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
        (!off).then_some(Bounded { bound: nearest.distance + reach, region })
    };
    open.extend(look(region, &mut found));
    let mut taken = 1;
    while let Some(first) = open.pop() {
        let radius = found.map_or(0.0, |f| f.1);
        if first.bound <= radius + until.agree || radius >= until.enough || taken >= until.most {
            open.push(first);
            break;
        }
        for half in first.region.halves() {
            taken += 1;
            open.extend(look(half, &mut found));
        }
    }
    let (centre, radius) = found?;
    let high = open.peek().map_or(radius, |first| first.bound);
    let (centre, radius) = settled(surface, &region, (centre, radius), (until.agree, &place));
    Some(Largest { centre, radius, high: high.max(radius) })
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
