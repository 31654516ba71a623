//! Samples that belong to one place.

use super::axes::eigenvectors;
use super::cover::Sample;
use crate::geometry::DisjointSets;
use crate::geometry::vector::{Vec3, bounds, distance, dot, scale, sub, unit};
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// Chords whose directions have at least this cosine run alike.
const ALIKE: f64 = 0.8;

/// Patches with shorter edges are points, millimetres.
const LEAST_EDGE: f64 = 1e-6;

/// Planes that differ by no more than this share of what lies between them are one, and directions by so many radians.
const COPLANAR: f64 = 1e-3;

/// Samples of one sheet, as indices into the list they were grouped from, in increasing order.
pub type Group = Vec<usize>;

/// Groups samples whose balls lie side by side in the same sheet.
///
/// Two samples are neighbours if their centres are at most `link` apart and neither lies more than half a thickness
/// off the other's middle surface; parallel sheets stay apart. So are samples whose patches may touch, on one facet or on
/// facets that share a vertex, if their chords run alike, and those between the same two planes whose facets share a vertex on either. Labels (of
/// bodies, say) never mix.
///
/// # Cost
/// Samples are thinned to one representative per cell of `link`/3 and direction, so the cost follows the extent of the
/// thin region and not its triangles; what touches is found in cells as large as the patches.
pub fn group(
    samples: &[Sample],
    link: f64,
    label: impl Fn(&Sample) -> u64,
    corners: impl Fn(u32) -> [u32; 3],
) -> Vec<Group> {
    let cell = |p: Vec3, size: f64| p.map(|x| (x / size).floor() as i64);
    let mut cells: FxHashMap<([i64; 3], [i8; 3], u64), usize> = FxHashMap::default();
    let mut representative = Vec::with_capacity(samples.len());
    let mut reps: Vec<usize> = Vec::new();
    for (i, s) in samples.iter().enumerate() {
        let key = (cell(s.centre, link / 3.0), direction(s).map(|x| (x * 2.0).round() as i8), label(s));
        let rep = *cells.entry(key).or_insert_with(|| {
            reps.push(i);
            reps.len() - 1
        });
        representative.push(rep);
    }
    let mut sets = DisjointSets::new(reps.len());
    let mut near: FxHashMap<[i64; 3], Vec<usize>> = FxHashMap::default();
    for (r, &i) in reps.iter().enumerate() {
        near.entry(cell(samples[i].centre, link)).or_default().push(r);
    }
    for (r, &i) in reps.iter().enumerate() {
        let s = &samples[i];
        let [x, y, z] = cell(s.centre, link);
        for (dx, dy, dz) in (0..27).map(|n| (n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)) {
            for &other in near.get(&[x + dx, y + dy, z + dz]).map_or(&[][..], |v| v) {
                let t = &samples[reps[other]];
                if other < r && label(s) == label(t) && neighbours(s, t, direction(s), direction(t), link) {
                    sets.join(r as u32, other as u32);
                }
            }
        }
    }
    // Long facets have centres far apart; those whose patches touch and run alike belong together all the same.
    let mut at_vertex: FxHashMap<u32, FxHashMap<usize, usize>> = FxHashMap::default();
    for (i, s) in samples.iter().enumerate() {
        for v in corners(s.facet) {
            let largest = at_vertex.entry(v).or_default().entry(representative[i]).or_insert(i);
            if samples[*largest].edge < s.edge {
                *largest = i;
            }
        }
    }
    for at in at_vertex.into_values() {
        let patches: Vec<(u32, &Sample)> = at.into_iter().map(|(rep, i)| (rep as u32, &samples[i])).collect();
        join_touching(&patches, &mut sets, |s, t| {
            // An edge names only one of its two facets, which may reach from sheet to sheet.
            let of_facets = s.area > 0.0 && t.area > 0.0;
            label(s) == label(t)
                && dot(direction(s), direction(t)).abs() > ALIKE
                && (of_facets || is_level(s, t, direction(s), direction(t)))
        });
    }
    join_flat(samples, &representative, &mut sets, label, corners);
    let mut groups: FxHashMap<usize, usize> = FxHashMap::default();
    let mut out: Vec<Group> = Vec::new();
    for (i, &rep) in representative.iter().enumerate() {
        let root = sets.root(rep as u32) as usize;
        let at = *groups.entry(root).or_insert_with(|| {
            out.push(Vec::new());
            out.len() - 1
        });
        out[at].push(i);
    }
    out
}

/// From contact to contact, or back: the same for what was sampled from either side.
fn direction(s: &Sample) -> Vec3 {
    let d = unit(sub(s.contacts[1], s.contacts[0]));
    let lead = d.iter().find(|x| x.abs() > 0.3).copied().unwrap_or(1.0);
    if lead < 0.0 { scale(d, -1.0) } else { d }
}

/// Joins samples between the same two planes, however far apart, if their facets share a vertex on one plane and on the other: the search looks at a large
/// facet in few places. Only facets that were sampled in places apart are looked at.
fn join_flat(
    samples: &[Sample],
    representative: &[usize],
    sets: &mut DisjointSets,
    label: impl Fn(&Sample) -> u64,
    corners: impl Fn(u32) -> [u32; 3],
) {
    let mut seen: FxHashMap<u32, (usize, bool)> = FxHashMap::default();
    for (s, &rep) in samples.iter().zip(representative) {
        for facet in [s.facet, s.opposite] {
            let (first, apart) = seen.entry(facet).or_insert((rep, false));
            *apart |= *first != rep;
        }
    }
    let is_apart = |facet: &u32| seen.get(facet).is_some_and(|(_, apart)| *apart);
    // By a vertex of the facet at which the direction starts, and one of that at which it ends: a sample of each sheet there.
    let mut between: FxHashMap<(u32, u32, u64), Vec<usize>> = FxHashMap::default();
    for (i, s) in samples.iter().enumerate().filter(|(_, s)| [s.facet, s.opposite].iter().any(is_apart)) {
        let forth = dot(direction(s), sub(s.contacts[1], s.contacts[0])) > 0.0;
        let [from, to] = if forth { [s.facet, s.opposite] } else { [s.opposite, s.facet] };
        for (v, w) in corners(from).into_iter().flat_map(|v| corners(to).map(|w| (v, w))) {
            let sheets = between.entry((v, w, label(s))).or_default();
            if let Some(&t) = sheets.iter().find(|&&t| is_of_one_plane(s, &samples[t])) {
                sets.join(representative[i] as u32, representative[t] as u32);
            } else {
                sheets.push(i);
            }
        }
    }
}

/// Whether two samples lie between the same two planes.
fn is_of_one_plane(s: &Sample, t: &Sample) -> bool {
    let (d, apart) = (direction(s), sub(t.centre, s.centre));
    let tolerance = COPLANAR * s.diameter;
    dot(d, direction(t)) > 1.0 - COPLANAR * COPLANAR
        && dot(apart, d).abs() <= tolerance
        && (s.diameter - t.diameter).abs() <= tolerance
}

/// Joins the samples at one vertex whose patches may touch: their contacts are no farther apart than both longest edges.
///
/// # Cost
/// Each looks at 27 cells for each size of patch from its own up, a power of two apart, where few of that size have room beside one another.
fn join_touching(patches: &[(u32, &Sample)], sets: &mut DisjointSets, alike: impl Fn(&Sample, &Sample) -> bool) {
    let size = |s: &Sample| s.edge.max(LEAST_EDGE).log2().ceil() as i32;
    // What is no larger than the cells' patches, and touches one, lies within two of their edges.
    let cell = |s: &Sample, size: i32| s.contacts[0].map(|x| (x / f64::from(size + 1).exp2()).floor() as i64);
    let mut sizes: BTreeMap<i32, FxHashMap<[i64; 3], Vec<usize>>> = BTreeMap::new();
    for (n, (_, s)) in patches.iter().enumerate() {
        sizes.entry(size(s)).or_default().entry(cell(s, size(s))).or_default().push(n);
    }
    for &(r, s) in patches {
        for (&size, cells) in sizes.range(size(s)..) {
            let [x, y, z] = cell(s, size);
            let beside = (0..27).filter_map(|n| cells.get(&[x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1]));
            for &(q, t) in beside.flatten().filter_map(|&n| patches.get(n)) {
                let touch = || distance(s.contacts[0], t.contacts[0]) <= s.edge + t.edge;
                if sets.root(r) != sets.root(q) && touch() && alike(s, t) {
                    sets.join(r, q);
                }
            }
        }
    }
}

fn neighbours(s: &Sample, t: &Sample, ds: Vec3, dt: Vec3, link: f64) -> bool {
    let apart = sub(t.centre, s.centre);
    dot(apart, apart) <= link * link && is_level(s, t, ds, dt)
}

/// Whether neither sample lies more than half a thickness off the other's middle surface.
fn is_level(s: &Sample, t: &Sample, ds: Vec3, dt: Vec3) -> bool {
    let apart = sub(t.centre, s.centre);
    let half = 0.5 * s.diameter.max(t.diameter);
    dot(apart, ds).abs() <= half && dot(apart, dt).abs() <= half
}

/// Sides of a box about a cloud of centres, longest first: across its principal plane, the tightest of eighteen turns in it.
///
/// Two long sides make a sheet, one makes a rod, none a blob.
pub fn principal_extents(points: &[Vec3]) -> [f64; 3] {
    let Some((lo, hi)) = bounds(points.iter().copied()) else { return [0.0; 3] };
    let middle = [0, 1, 2].map(|a| 0.5 * (lo[a] + hi[a]));
    let mut m = [[0.0; 3]; 3];
    for p in points {
        let d = sub(*p, middle);
        for i in 0..3 {
            for j in 0..3 {
                m[i][j] += d[i] * d[j];
            }
        }
    }
    let span = |axis: Vec3| {
        let ends = |(l, h): (f64, f64), p: &Vec3| (l.min(dot(*p, axis)), h.max(dot(*p, axis)));
        let (lo, hi) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
        hi - lo
    };
    let mut axes = eigenvectors(m);
    axes.sort_by(|a, b| span(*b).total_cmp(&span(*a)));
    let [u, v, across] = axes;
    let turned = (0..18).map(|k| {
        let (s, c) = (5.0 * k as f64).to_radians().sin_cos();
        let (a, b) = ([0, 1, 2].map(|i| c * u[i] + s * v[i]), [0, 1, 2].map(|i| c * v[i] - s * u[i]));
        [span(a), span(b)]
    });
    let least = turned.reduce(|best, t| if t[0] * t[1] < best[0] * best[1] - 1e-12 { t } else { best });
    let [a, b] = least.unwrap_or([0.0; 2]);
    [a.max(b), a.min(b), span(across)]
}

#[cfg(test)]
mod tests {
    use super::super::cover::Shape;
    use super::*;
    use crate::geometry::vector::along;

    /// A sample of a level sheet one millimetre thick on facet 0, with a patch of so long an edge.
    fn sample(x: f64, edge: f64) -> Sample {
        Sample {
            shape: Shape::Sheet,
            centre: [x, 0.0, 0.0],
            contacts: [[x, 0.0, 0.5], [x, 0.0, -0.5]],
            diameter: 1.0,
            low: 1.0,
            separation: std::f64::consts::PI,
            area: 0.25 * edge * edge,
            thin: 0.25 * edge * edge,
            edge,
            sides: ([x, 0.0, 0.5], [x, 0.0, 0.5]),
            feature: 0,
            facet: 0,
            opposite: 1,
        }
    }

    fn groups(samples: &[Sample]) -> Vec<Group> {
        group(samples, 1.0, |_| 0, |_| [0, 1, 2])
    }

    #[test]
    fn patches_of_one_facet_are_one_place_where_they_touch() {
        assert_eq!(groups(&[0.0, 9.0, 4.5].map(|x| sample(x, 3.0))), [[0, 1, 2]]);
        let thicker = |s: Sample| Sample { diameter: 1.2, ..s };
        assert_eq!(groups(&[sample(0.0, 0.5), thicker(sample(29.0, 0.5)), sample(0.4, 0.5)]), [vec![0, 2], vec![1]]);
        let side = |s: Sample| Sample { contacts: [s.contacts[0], along(s.contacts[0], [0.0, 1.0, 0.0], 1.0)], ..s };
        assert_eq!(groups(&[sample(0.0, 3.0), side(sample(4.5, 3.0))]), [[0], [1]]);
    }

    #[test]
    fn what_lies_between_the_same_two_large_facets_is_one_place_however_far_apart_and_from_either_side() {
        // Facets 0 and 1 bound a sheet of 1 mm, 2 goes on beside facet 1, and 3 belongs to another pad on the same plane.
        let corners = |f: u32| [[0, 1, 2], [10, 11, 12], [11, 12, 13], [20, 21, 22]][f as usize];
        let from_below =
            |s: Sample| Sample { contacts: [s.contacts[1], s.contacts[0]], facet: s.opposite, opposite: s.facet, ..s };
        let over = |x: f64, opposite: u32| Sample { opposite, ..sample(x, 0.5) };
        let list = [over(0.0, 1), over(7.0, 1), from_below(over(19.0, 2)), over(30.0, 3), over(33.0, 3)];
        assert_eq!(group(&list, 1.0, |_| 0, corners), [vec![0, 1, 2], vec![3, 4]]);
        // Not of one plane, and of another thickness.
        let lower = Sample { centre: [7.0, 0.0, 0.01], ..over(7.0, 1) };
        let thicker = Sample { diameter: 1.01, ..over(7.0, 1) };
        for other in [lower, thicker] {
            assert_eq!(group(&[over(0.0, 1), other], 1.0, |_| 0, corners), [[0], [1]]);
        }
    }

    #[test]
    fn samples_on_an_edge_belong_to_the_patches_beside_it_and_not_to_the_next_sheet() {
        let on_edge = |x: f64, z: f64| Sample {
            centre: [x, 0.0, z],
            contacts: [[x, 0.0, z + 0.5], [x, 0.0, z - 0.5]],
            area: 0.0,
            thin: 0.0,
            ..sample(x, 1.5)
        };
        assert_eq!(groups(&[sample(0.0, 3.0), on_edge(3.0, 0.0), on_edge(5.9, 0.0)]), [[0, 1, 2]]);
        assert_eq!(groups(&[on_edge(0.0, 0.0), on_edge(0.0, 1.8), sample(2.0, 3.0)]), [vec![0, 2], vec![1]]);
    }

    #[test]
    fn a_tilted_rod_has_one_long_extent() {
        let points: Vec<Vec3> = (0..100).map(|i| [0.1 * i as f64, 0.05 * i as f64, 0.02 * i as f64]).collect();
        let [a, b, c] = principal_extents(&points);
        assert!((a - 9.9 * (1.0f64 + 0.25 + 0.04).sqrt()).abs() < 1e-9 && b < 1e-9 && c < 1e-9, "{a} {b} {c}");
    }
}
