//! Facets that lie on each other in one plane.
//!
//! Nearly all pairs of a plane that are near each other are beside each other, and an edge tells: what two facets have in common is cut out only where none
//! parts them.

use crate::geometry::distance::MeshDistance;
use crate::geometry::vector::{Vec3, add, along, cross, dot, norm, norm2, scale, sub, unit};

/// Two facets that lie on each other, and what they have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Overlap {
    pub(super) facets: [u32; 2],
    /// Mean of the corners of what they have in common.
    pub(super) middle: Vec3,
    /// Its area, mm².
    pub(super) area: f64,
}

/// What two facets in one plane have in common, if it is more than the tolerance across, and wider than a hair.
pub(super) fn overlap_of(tree: &MeshDistance, [f, g]: [u32; 2], [tolerance, hair]: [f64; 2]) -> Option<Overlap> {
    let (s, t) = (tree.corners(f), tree.corners(g));
    let (m, n) = (tree.normal(f), tree.normal(g));
    let in_plane =
        |of: [Vec3; 3], on: Vec3, normal: Vec3| of.iter().all(|&p| dot(normal, sub(p, on)).abs() <= tolerance);
    if !in_plane(t, s[0], m) || !in_plane(s, t[0], n) || s.iter().all(|p| t.contains(p)) {
        return None;
    }
    // By half the tolerance, which is more than rounding: clipping, which takes all of it, would leave nothing either.
    if parted(s, t, n, 0.5 * tolerance) {
        return None;
    }
    common_of([f, g], [s, t], n, [tolerance, hair])
}

/// Whether an edge of one of two triangles of a plane has the other behind it, but for less than `within`.
fn parted(s: [Vec3; 3], t: [Vec3; 3], normal: Vec3, within: f64) -> bool {
    // Without roots: √|across|² is not worth one for each of six edges.
    let behind = |a: Vec3, across: Vec3, of: [Vec3; 3]| {
        let most = within * within * norm2(across);
        of.iter().all(|&p| {
            let height = dot(across, sub(p, a));
            height <= 0.0 || height * height <= most
        })
    };
    let by_edge = |of: [Vec3; 3], other: [Vec3; 3]| {
        [(of[0], of[1], of[2]), (of[1], of[2], of[0]), (of[2], of[0], of[1])].into_iter().any(|(a, b, opposite)| {
            // Towards the third corner: facets that lie on each other may face opposite sides.
            let across = cross(normal, sub(b, a));
            let inward = if dot(across, sub(opposite, a)) < 0.0 { scale(across, -1.0) } else { across };
            behind(a, inward, other)
        })
    };
    by_edge(t, s) || by_edge(s, t)
}

/// What two triangles of a plane have in common, cut out.
fn common_of(facets: [u32; 2], [s, t]: [[Vec3; 3]; 2], n: Vec3, [tolerance, hair]: [f64; 2]) -> Option<Overlap> {
    // Less the tolerance, so that facets with a common edge have nothing in common.
    if Common::of(s, t, n, tolerance).area() <= tolerance * tolerance {
        return None;
    }
    let common = Common::of(s, t, n, 0.0);
    if common.area() <= hair * common.longest() {
        return None;
    }
    Some(Overlap { facets, middle: common.middle(), area: common.area() })
}

/// A triangle cut by up to three planes: a convex polygon of at most six corners.
struct Common {
    corners: [Vec3; 6],
    count: usize,
}

impl Common {
    /// What of a triangle lies in another of the same plane, by at least `inset` off its edges.
    fn of(s: [Vec3; 3], t: [Vec3; 3], normal: Vec3, inset: f64) -> Self {
        let whole = Common { corners: [s[0], s[1], s[2], s[0], s[0], s[0]], count: 3 };
        (0..3).fold(whole, |common, e| {
            let inward = unit(cross(normal, sub(t[(e + 1) % 3], t[e])));
            common.beyond(inward, dot(inward, t[e]) + inset)
        })
    }

    fn area(&self) -> f64 {
        let Some((&first, rest)) = self.corners().split_first() else { return 0.0 };
        let twice = rest.windows(2).fold([0.0; 3], |sum, w| add(sum, cross(sub(w[0], first), sub(w[1], first))));
        0.5 * norm(twice)
    }

    /// Greatest distance of two corners.
    fn longest(&self) -> f64 {
        let pairs = self.corners().iter().flat_map(|&p| self.corners().iter().map(move |&q| norm2(sub(p, q))));
        pairs.fold(0.0, f64::max).sqrt()
    }

    /// Mean of the corners.
    fn middle(&self) -> Vec3 {
        scale(self.corners().iter().fold([0.0; 3], |sum, &p| add(sum, p)), 1.0 / self.count.max(1) as f64)
    }

    fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }

    /// The part on the side of a plane that its normal points to.
    fn beyond(&self, normal: Vec3, offset: f64) -> Self {
        let height = |p: Vec3| dot(normal, p) - offset;
        let mut kept = Common { corners: self.corners, count: 0 };
        let mut keep = |p: Vec3| {
            // Rounding alone can ask for a seventh corner, where two lie on each other.
            if let Some(place) = kept.corners.get_mut(kept.count) {
                *place = p;
                kept.count += 1;
            }
        };
        let corners = self.corners();
        for (&p, &q) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let (a, b) = (height(p), height(q));
            if a > 0.0 {
                keep(p);
            }
            if (a > 0.0) != (b > 0.0) {
                keep(along(p, sub(q, p), a / (a - b)));
            }
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::super::meetings;
    use super::*;
    use crate::geometry::TriangleMesh;

    /// A square from the origin, in one of its two cuts, shifted in its plane.
    fn square(side: f64, diagonal: usize, at: Vec3) -> TriangleMesh {
        let c = [[0.0, 0.0, 0.0], [side, 0.0, 0.0], [side, side, 0.0], [0.0, side, 0.0]].map(|p| add(p, at));
        let d = diagonal;
        TriangleMesh::weld([[c[d], c[d + 1], c[d + 2]], [c[d], c[d + 2], c[(d + 3) % 4]]])
    }

    #[test]
    fn two_cuts_of_a_square_have_its_area_in_common() {
        let both = square(2.0, 0, [0.0; 3]).joined(&square(2.0, 1, [0.0; 3]));
        let found = meetings(&MeshDistance::new(&both), |_, _| true, 1e-6);
        // Each facet has a quarter of the square in common with each of the others.
        assert_eq!((found.overlapping.count, found.crossing.count), (4, 0));
        assert!((found.overlap_mm2 - 4.0).abs() < 1e-4, "{found:?}");
        assert_eq!(meetings(&MeshDistance::new(&both), |f, g| (f < 2) == (g < 2), 1e-6).overlapping.count, 0);
    }

    #[test]
    fn what_is_beside_above_or_the_same_does_not_overlap() {
        let one = square(2.0, 0, [0.0; 3]);
        for at in [[2.0, 0.0, 0.0], [1.0, 2.0, 0.0], [0.5, 0.5, 1e-3], [0.0; 3]] {
            let both = one.clone().joined(&square(2.0, 0, at));
            let found = meetings(&MeshDistance::new(&both), |_, _| true, 1e-6);
            assert_eq!(found.overlapping.count, 0, "{at:?}: {found:?}");
        }
        let part = meetings(&MeshDistance::new(&one.joined(&square(2.0, 0, [1.5, 1.0, 0.0]))), |_, _| true, 1e-6);
        assert!((part.overlap_mm2 - 0.5).abs() < 1e-5, "{part:?}");
    }

    #[test]
    fn a_facet_folded_back_onto_its_neighbour_overlaps_it() {
        let folded = TriangleMesh::weld([
            [[0.0; 3], [4.0, 0.0, 0.0], [2.0, 3.0, 0.0]],
            [[4.0, 0.0, 0.0], [0.0; 3], [2.0, 1.0, 0.0]],
        ]);
        let found = meetings(&MeshDistance::new(&folded), |_, _| true, 1e-6);
        assert!(found.overlapping.count == 1 && (found.overlap_mm2 - 2.0).abs() < 1e-4, "{found:?}");
        // Opened by a hair more than the file resolves, they meet at their edge alone.
        let open = TriangleMesh {
            vertices: folded.vertices.iter().map(|p| [p[0], p[1], if p[1] == 1.0 { 1e-5 } else { 0.0 }]).collect(),
            ..folded
        };
        assert_eq!(meetings(&MeshDistance::new(&open), |_, _| true, 1e-6).overlapping.count, 0);
    }

    #[test]
    fn what_an_edge_parts_has_nothing_in_common() {
        use crate::random::Lcg;
        let mut random = Lcg(23);
        let tolerances = [4e-6, 2e-9];
        let (mut parts, mut apart, mut together, mut too_bold) = (0, 0, 0, 0);
        for round in 0..8000 {
            // Two triangles in a plane askew: anyhow, with a corner or an edge in common, and beside each other but for a few tolerances.
            let tolerance = tolerances[round % 2];
            let rotation = random.rotation();
            let at = random.point(-40.0, 40.0);
            let flat = |p: Vec3| [0, 1, 2].map(|a| at[a] + rotation[a][0] * p[0] + rotation[a][1] * p[1]);
            let mut draw = || [0; 3].map(|_| flat(random.point(-3.0, 3.0)));
            let (s, mut t) = (draw(), draw());
            let beside = |k: f64| {
                let across = unit(cross(cross(sub(s[1], s[0]), sub(s[2], s[0])), sub(s[1], s[0])));
                let inward = scale(across, dot(across, sub(s[2], s[0])).signum() * k * tolerance);
                let opposite = sub(add(s[0], s[1]), s[2]);
                [s[1], s[0], opposite].map(|p| add(p, inward))
            };
            match round / 2 % 4 {
                1 => t[0] = s[1],
                2 => (t[0], t[1]) = (s[1], s[0]),
                3 => t = beside((round / 8 % 13) as f64 * 0.5 - 3.0),
                _ => {}
            }
            let tree = MeshDistance::new(&TriangleMesh::weld([s, t]));
            let ([s, t], n) = ([0, 1].map(|f| tree.corners(f)), tree.normal(1));
            let plain = common_of([0, 1], [s, t], n, [tolerance, 0.0]);
            assert_eq!(overlap_of(&tree, [0, 1], [tolerance, 0.0]), plain, "{round}: {s:?} {t:?}");
            parts += usize::from(parted(s, t, n, 0.5 * tolerance));
            too_bold += usize::from(parted(s, t, n, 2.5 * tolerance) && plain.is_some());
            match plain {
                Some(_) => together += 1,
                None => apart += 1,
            }
        }
        // An edge tells of all that have nothing in common but of those that clipping takes for touching, and one that told of more would be seen.
        assert!(apart > 2000 && together > 2000 && too_bold > 0, "{apart} {together} {too_bold}");
        assert!(parts <= apart && 10 * parts > 9 * apart, "{parts} of {apart}");
    }

    #[test]
    fn a_needle_of_rounding_that_reaches_over_its_neighbour_does_not_lie_on_it() {
        // Written with all digits of f64; what f32 tells apart at 40 mm is 4.8 · 10⁻⁶ mm.
        let block = square(40.0, 0, [0.0; 3]);
        let needle = |high: f64| TriangleMesh::weld([[[1.0, 1.0, 0.0], [7.0, 1.0, 0.0], [3.0, 1.0 + high, 0.0]]]);
        let count = |high: f64| {
            meetings(&MeshDistance::new(&block.clone().joined(&needle(high))), |_, _| true, 2e-9).overlapping.count
        };
        assert_eq!([1e-7, 1e-6, 4e-6, 2e-5, 1e-2].map(count), [0, 0, 0, 1, 1]);
    }
}
