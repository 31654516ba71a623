//! Surface that looks down at less than a given slope.

use super::sliver::{turned_by, with_slivers};
use crate::geometry::vector::{Vec3, along, angle, bounds, distance, scale};
use crate::geometry::{DisjointSets, TriangleMesh};
use crate::units::Angle;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// Neighbouring facets whose normals differ by less than this belong to one region (20°).
const SMOOTH: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Neighbouring facets whose normals differ by less than this lie in one plane (0.5°).
const FLAT: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// A flat piece at least this wide, in millimetres, is a face of its own, unless it is a strip of a curved one.
const FACE_WIDTH: f64 = 5.0;
/// Strips of one curved surface differ from each other in width by no more than this factor, and so do their bends,
const ALIKE: f64 = 2.0;
/// and are bent by less than this (7.5°, a round of 48 facets): plates in steps of 10° or 15° are meant to be told apart.
const GENTLE: f64 = 7.5 * std::f64::consts::PI / 180.0;

/// A connected piece of downward surface.
#[derive(Debug, Clone)]
pub struct DownwardRegion {
    /// Facets in increasing order.
    pub facets: Vec<u32>,
    /// Exact area of what counts, mm².
    pub area_mm2: f64,
    /// Least angle from the horizontal: 0 is a flat ceiling.
    pub least_angle: Angle,
    /// The least angle that a facet has with its tie: the region is certainly flatter than any greater one, and than no other.
    pub certain_angle: Angle,
    /// Greatest angle from the horizontal.
    pub greatest_angle: Angle,
    /// Area-weighted middle.
    pub centroid: Vec3,
    /// A point of the facet with the least angle, and that facet.
    pub worst: (Vec3, u32),
    pub extent: (Vec3, Vec3),
}

/// The regions of facets whose outward normal points down and whose angle from the horizontal is below `limit`.
///
/// { f : n_z < 0, ∠(n, −z) < limit − tie, f not wholly within `plate_z` }, joined over edges bent by less than 20°, except that a flat
/// face at least 5 mm wide is a region of its own, unless three such follow each other that are about as wide and bent alike, by less than 7.5°: the strips of a
/// large curved surface. The tie of a facet
/// is what a coordinate step does to its direction: `step` over its least height. A sliver that this leaves no direction of its own goes on as the
/// facet beside it. `share` tells which share of a facet counts, from 0,
/// for one that is left out, to 1.
///
/// # Cost
/// O(facets).
pub fn downward_regions(
    mesh: &TriangleMesh,
    plate_z: f64,
    limit: Angle,
    step: f64,
    share: impl Fn(u32) -> f64 + Sync,
) -> Vec<DownwardRegion> {
    let counted = |f: u32| Some((f, share(f))).filter(|(_, share)| *share > 0.0);
    let shares: Vec<(u32, f64)> =
        downward_facets(mesh, plate_z, limit, step).into_par_iter().filter_map(counted).collect();
    let counted: Vec<u32> = shares.iter().map(|s| s.0).collect();
    // Slivers only join what they lie between.
    let down = with_slivers(mesh, &counted, step);
    let edges = shared_edges(mesh, &down);
    let mut sets = DisjointSets::new(down.len());
    join(&mut sets, &edges, |i, j| angle(down[i].1, down[j].1) < FLAT);
    let faces = faces(mesh, &down, &edges, &mut sets);
    join(&mut sets, &edges, |i, j| !faces[i] && !faces[j] && angle(down[i].1, down[j].1) < SMOOTH);
    let mut regions: BTreeMap<u32, Vec<(u32, f64)>> = BTreeMap::new();
    for (i, &counted) in shares.iter().enumerate() {
        regions.entry(sets.root(i as u32)).or_default().push(counted);
    }
    regions.into_values().filter_map(|facets| describe(mesh, &facets, step)).collect()
}

/// The facets whose outward normal points down and whose angle from the horizontal is below `limit`, in increasing order.
///
/// { f : n_z < 0, ∠(n, −z) < limit − tie, f not wholly within `plate_z` }, with the tie of [`downward_regions`].
///
/// # Cost
/// O(facets).
pub fn downward_facets(mesh: &TriangleMesh, plate_z: f64, limit: Angle, step: f64) -> Vec<u32> {
    let on_plate = plate_z + step.max(1e-4);
    let looks_down = |f: usize| {
        let n = mesh.normal(f);
        let corners = mesh.corners(f);
        n[2] < 0.0
            && slope(n).as_radians() < limit.as_radians() - turned_by(corners, step)
            && corners.iter().any(|p| p[2] > on_plate)
    };
    (0..mesh.triangles.len()).into_par_iter().filter(|&f| looks_down(f)).map(|f| f as u32).collect()
}

/// Pairs of downward facets that share an edge.
fn shared_edges(mesh: &TriangleMesh, down: &[(u32, Vec3)]) -> Vec<(usize, usize)> {
    let mut at_edge: FxHashMap<(u32, u32), Vec<usize>> = FxHashMap::default();
    let mut pairs = Vec::new();
    for (i, &(f, _)) in down.iter().enumerate() {
        let t = mesh.triangles[f as usize];
        for e in 0..3 {
            let (a, b) = (t[e], t[(e + 1) % 3]);
            let seen = at_edge.entry((a.min(b), a.max(b))).or_default();
            pairs.extend(seen.iter().map(|&j| (j, i)));
            seen.push(i);
        }
    }
    pairs
}

fn join(sets: &mut DisjointSets, edges: &[(usize, usize)], alike: impl Fn(usize, usize) -> bool) {
    for &(i, j) in edges {
        if alike(i, j) {
            sets.join(i as u32, j as u32);
        }
    }
}

/// For each facet whether its flat piece is a face of its own: area over longest span at least [`FACE_WIDTH`], and no strip of a curved surface.
fn faces(mesh: &TriangleMesh, down: &[(u32, Vec3)], edges: &[(usize, usize)], sets: &mut DisjointSets) -> Vec<bool> {
    let piece: Vec<u32> = (0..down.len()).map(|i| sets.root(i as u32)).collect();
    let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    piece.iter().enumerate().for_each(|(i, &p)| members.entry(p).or_default().push(i));
    let width = |of: &Vec<usize>| {
        let area: f64 = of.iter().map(|&i| mesh.facet_area(down[i].0 as usize)).sum();
        let span = bounds(of.iter().flat_map(|&i| mesh.corners(down[i].0 as usize)));
        span.map(|(lo, hi)| distance(lo, hi)).filter(|s| *s > 0.0).map_or(0.0, |span| area / span)
    };
    let widths: BTreeMap<u32, f64> = members.iter().map(|(&p, of)| (p, width(of))).collect();
    let mut beside: BTreeMap<u32, Vec<(u32, f64)>> = BTreeMap::new();
    for &(i, j) in edges {
        let bend = angle(down[i].1, down[j].1);
        let alike = |p: u32, q: u32| widths.get(&p).zip(widths.get(&q)).is_some_and(|(a, b)| is_alike(*a, *b));
        if piece[i] != piece[j] && bend < GENTLE && alike(piece[i], piece[j]) {
            beside.entry(piece[i]).or_default().push((piece[j], bend));
            beside.entry(piece[j]).or_default().push((piece[i], bend));
        }
    }
    let next_to = |p: u32| beside.get(&p).map_or(&[][..], Vec::as_slice);
    let goes_on = |from: u32, at: u32, bend: f64| {
        next_to(at).iter().any(|&(next, other)| next != from && next != at && is_alike(bend, other))
    };
    let is_strip = |p: u32| {
        let sides = next_to(p);
        let between = sides.iter().any(|&(q, bend)| goes_on(q, p, bend));
        between || sides.iter().any(|&(q, bend)| goes_on(p, q, bend))
    };
    let own: BTreeMap<u32, bool> = widths.iter().map(|(&p, &width)| (p, width >= FACE_WIDTH && !is_strip(p))).collect();
    piece.iter().map(|p| own.get(p).is_some_and(|own| *own)).collect()
}

/// Whether two lengths, or two angles, are of one size.
fn is_alike(a: f64, b: f64) -> bool {
    a <= ALIKE * b && b <= ALIKE * a
}

/// Angle of a surface from the horizontal, from its downward normal.
fn slope(normal: Vec3) -> Angle {
    Angle::radians(angle(normal, [0.0, 0.0, -1.0]))
}

fn describe(mesh: &TriangleMesh, counted: &[(u32, f64)], step: f64) -> Option<DownwardRegion> {
    let mut area = 0.0;
    let mut moment = [0.0; 3];
    let (mut least, mut certain, mut greatest) = ((f64::INFINITY, 0u32), f64::INFINITY, 0.0f64);
    for &(f, share) in counted {
        let a = share * mesh.facet_area(f as usize);
        area += a;
        moment = along(moment, mesh.centroid(f as usize), a);
        let s = slope(mesh.normal(f as usize)).as_radians();
        greatest = greatest.max(s);
        certain = certain.min(s + turned_by(mesh.corners(f as usize), step));
        if s < least.0 {
            least = (s, f);
        }
    }
    let facets: Vec<u32> = counted.iter().map(|c| c.0).collect();
    let extent = bounds(facets.iter().flat_map(|&f| mesh.corners(f as usize)))?;
    (area > 0.0).then(|| DownwardRegion {
        area_mm2: area,
        least_angle: Angle::radians(least.0),
        certain_angle: Angle::radians(certain),
        greatest_angle: Angle::radians(greatest),
        centroid: scale(moment, 1.0 / area),
        worst: (mesh.centroid(least.1 as usize), least.1),
        extent,
        facets,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plate whose underside leans by `degrees`, as one downward quad at height 5.
    fn leaning(degrees: f64) -> TriangleMesh {
        let rise = degrees.to_radians().tan() * 10.0;
        let p = [[0.0, 0.0, 5.0], [10.0, 0.0, 5.0 + rise], [10.0, 4.0, 5.0 + rise], [0.0, 4.0, 5.0]];
        TriangleMesh::weld([[p[0], p[2], p[1]], [p[0], p[3], p[2]]])
    }

    #[test]
    fn equal_to_the_limit_passes() {
        let step = 1e-6;
        let found = |degrees: f64| downward_regions(&leaning(degrees), 0.0, Angle::degrees(45.0), step, |_| 1.0);
        assert!(found(45.0).is_empty());
        assert!(found(46.0).is_empty());
        let regions = found(44.0);
        assert_eq!(regions.len(), 1);
        assert!((regions[0].area_mm2 - 40.0 / 44.0f64.to_radians().cos()).abs() < 1e-9);
        assert!((regions[0].least_angle.as_degrees() - 44.0).abs() < 1e-9);
    }

    #[test]
    fn a_region_is_as_flat_as_its_facets_certainly_are() {
        let at = |degrees: f64| {
            let [one] = &downward_regions(&leaning(degrees), 0.0, Angle::degrees(45.0), 1e-6, |_| 1.0)[..] else {
                panic!("{degrees}")
            };
            one.certain_angle.as_degrees() - 30.0
        };
        // A step turns facets 3.7 mm high by 2e-6 / 3.7, which is 3e-5 degrees.
        assert!(at(30.0 - 1e-5) > 0.0 && at(30.0) > 0.0 && at(30.0 - 1e-4) < 0.0);
    }

    #[test]
    fn a_large_round_is_one_region_and_two_large_faces_are_two() {
        // Undersides of 40 mm: faces of a width, each bent by some degrees from the last one.
        let underside = |bends: &[f64], wide: f64| {
            let (mut at, mut lean, mut points) = ([0.0, 5.0], 0.0f64, vec![[0.0, 5.0]]);
            for bend in bends {
                lean += bend.to_radians();
                at = [at[0] + wide * lean.cos(), at[1] + wide * lean.sin()];
                points.push(at);
            }
            let facets = points.windows(2).flat_map(|w| {
                let [p, q] = [w[0], w[1]].map(|p| [[p[0], 0.0, p[1]], [p[0], 40.0, p[1]]]);
                [[p[0], q[1], q[0]], [p[0], p[1], q[1]]]
            });
            downward_regions(&TriangleMesh::weld(facets), 0.0, Angle::degrees(45.0), 1e-6, |_| 1.0).len()
        };
        for wide in [1.0, 4.0, 8.0, 30.0] {
            assert_eq!(underside(&[0.0, 3.0, 3.0, 3.0, 3.0, 3.0], wide), 1, "{wide}");
            assert_eq!(underside(&[0.0, 10.0, 10.0], wide), if wide > FACE_WIDTH { 3 } else { 1 }, "{wide}");
            assert_eq!(underside(&[0.0, 5.0], wide), if wide > FACE_WIDTH { 2 } else { 1 }, "{wide}");
        }
        // A ceiling beside a round.
        assert_eq!(underside(&[2.0, 2.0, 2.0, 18.0], 8.0), 2);
    }

    #[test]
    fn a_sliver_without_a_direction_parts_no_ceiling() {
        // Two halves of a ceiling of 20 × 4 mm, between them a facet no wider than the last digit of the file, its third corner off by that.
        for off in [0.0, 1e-6, -1e-6, 5e-6, -5e-6] {
            let at = |x: f64, y: f64| [x, y, 5.0];
            let third = [10.000_001, 2.0, 5.0 + off];
            let left = [[at(0.0, 0.0), at(10.0, 4.0), at(10.0, 0.0)], [at(0.0, 0.0), at(0.0, 4.0), at(10.0, 4.0)]];
            let sliver = [[at(10.0, 0.0), at(10.0, 4.0), third]];
            let right = [
                [at(10.0, 0.0), third, at(20.0, 0.0)],
                [third, at(20.0, 4.0), at(20.0, 0.0)],
                [third, at(10.0, 4.0), at(20.0, 4.0)],
            ];
            let mesh = TriangleMesh::weld(left.into_iter().chain(sliver).chain(right));
            let regions = downward_regions(&mesh, 0.0, Angle::degrees(45.0), 4e-6, |_| 1.0);
            let areas: Vec<f64> = regions.iter().map(|r| r.area_mm2).collect();
            assert!(matches!(areas[..], [one] if (one - 80.0).abs() < 1e-4), "{off}: {areas:?}");
        }
    }

    #[test]
    fn the_underside_on_the_plate_is_no_overhang() {
        let flat = leaning(0.0);
        assert!(downward_regions(&flat, 5.0, Angle::degrees(45.0), 1e-6, |_| 1.0).is_empty());
        assert_eq!(downward_regions(&flat, 4.0, Angle::degrees(45.0), 1e-6, |_| 1.0).len(), 1);
    }
}
