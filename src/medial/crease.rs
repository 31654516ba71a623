//! Sharp edges of the surface: where two facets meet in a wedge of material, exactly.

use super::chord::PARALLEL;
use super::feature::Side;
use super::flat::{is_flat, is_needle, wide_facet};
use super::wedge::Wedge;
use crate::geometry::Adjacency;
use crate::geometry::triangle::closest_point;
use crate::geometry::vector::{Vec3, add, along, angle, cross, distance, dot, norm, scale, sub, unit};
use crate::geometry::{DisjointSets, MeshDistance, TriangleMesh};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Narrow facets of a blunt edge that are crossed at most, from one side of the wedge to the other: those of a rounding in 128 strips.
const CROSSED: usize = 256;
/// A facet whose normal has this cosine with the run of an edge lies across its end and not between its sides.
const ACROSS_END: f64 = 0.7;
/// Components of two normals that differ by less say nothing about their order.
const ALIKE: f64 = 0.1;

/// Which edges are sought, lengths in millimetres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sharpness {
    /// The greatest angle of the material, radians.
    pub widest: f64,
    /// The depth is told to where the material is as thick as this.
    pub thick: f64,
    /// A face or a rounding up to this wide between the sides of a wedge makes it no less of an edge.
    pub blunt: f64,
    /// Coordinates are good to this.
    pub step: f64,
}

/// An edge between two facets that meet at a sharp angle, or would but for a narrow face between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crease {
    /// The edge, that of the first side where it is blunt.
    pub ends: [u32; 2],
    /// A facet of each side; where the edge is blunt one that is wide, which need not reach the edge.
    pub facets: [u32; 2],
    /// How far the second facet is from the middle of the edge; 0 where they meet.
    pub blunt: f64,
    /// Angle of the material between the two facets, radians.
    pub angle: f64,
    /// What a step of the coordinates may do to it, radians: step over height, for both facets.
    pub doubt: f64,
    /// How far in from the middle of the edge the material is thinner than asked, millimetres.
    pub depth: f64,
    /// The greatest thickness met on that way; as much as asked where the wedge reaches it.
    pub thickness: f64,
}

/// A line of creases that follow each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Ridge {
    /// Indices into the list of creases, in increasing order.
    pub creases: Vec<usize>,
}

/// The edges whose material angle is at most [`Sharpness::widest`], with the depth over which they are thinner than asked.
///
/// At a distance s from an edge of angle φ a wedge is 2 s·sin(φ/2) thick, the diameter of the ball between its sides; the depth is where that
/// ball, measured on the mesh, first reaches `thick`, or where the wedge ends (`Wedge::thinner_than`). An edge is blunt where its sides
/// are no further apart than `blunt` and only faces that stay as near to it lie between them; it is told once, where it is sharpest, and its depth counts from
/// the face. A face is all that is joined over edges between facets of one plane, so that a sliver of a side is no face of its own. Sides within 4° of parallel are a plate's, and no wedge's.
///
/// # Cost
/// One walk over the edges; some tens of nearest points for each that is sharp, and up to 256 facets for each beside a narrow one.
pub fn creases(mesh: &TriangleMesh, surface: &MeshDistance, next: &Adjacency, sought: Sharpness) -> Vec<Crease> {
    let normal = |f: u32| mesh.normal(f as usize);
    let wedge =
        |facets, ends| wedge_between(mesh, Side::Material, facets, ends).filter(|inner| *inner <= sought.widest);
    let crease = |facets: [u32; 2], ends: [u32; 2], inner: f64, opposite: Option<Vec3>| {
        let [a, b] = ends.map(|v| mesh.vertices[v as usize]);
        let middle = along(a, sub(b, a), 0.5);
        let inward = bisector(mesh, facets, ends, facets.map(normal))?;
        let opposite = opposite.unwrap_or(middle);
        let from = along(middle, sub(opposite, middle), 0.5);
        let (depth, thickness) = Wedge { edge: from, inward, angle: inner }.thinner_than(surface, sought.thick);
        let doubt = facets.iter().map(|&f| sought.step * distance(a, b) / norm(mesh.area_vector(f as usize))).sum();
        let blunt = distance(middle, opposite);
        Some(Crease { ends, facets, blunt, angle: inner, doubt, depth, thickness })
    };
    let of_edge = |f: u32, e: usize| {
        let g = next.across(f, e)?;
        let t = mesh.triangles[f as usize];
        let ends = [t[e], t[(e + 1) % 3]];
        if let Some(inner) = wedge([f, g], ends) {
            return (g > f).then(|| crease([f, g], ends, inner, None)).flatten().map(|c| (c, Vec::new()));
        }
        let (sides, opposite, crossed) = beyond(mesh, next, (f, g), ends, sought)?;
        let inner = wedge(sides, ends).filter(|inner| *inner > PI - PARALLEL)?;
        // From one side only, and from the same one all along.
        let [m, n] = sides.map(normal);
        let first = m.iter().zip(n).map(|(m, n)| m - n).find(|d| d.abs() > ALIKE);
        let crease = first.is_some_and(|d| d < 0.0).then(|| crease(sides, ends, inner, Some(opposite))).flatten();
        crease.map(|c| (c, crossed))
    };
    let facets = (0..mesh.triangles.len() as u32).into_par_iter();
    let found = facets.flat_map_iter(|f| (0..3).filter_map(move |e| of_edge(f, e))).collect();
    told_once(mesh, found, sought.blunt)
}

/// Creases with the narrow facets that each crosses, without those that are the edge of another: an edge between such facets and the blunt
/// one across them are one, and the sharper of both is told.
fn told_once(mesh: &TriangleMesh, found: Vec<(Crease, Vec<u32>)>, reach: f64) -> Vec<Crease> {
    let mut direct: FxHashMap<u32, Vec<usize>> = FxHashMap::default();
    for (n, (c, _)) in found.iter().enumerate().filter(|(_, (_, crossed))| crossed.is_empty()) {
        c.facets.iter().for_each(|f| direct.entry(*f).or_default().push(n));
    }
    let mut left_out = vec![false; found.len()];
    for (n, (blunt, crossed)) in found.iter().enumerate() {
        let [a, b] = blunt.ends.map(|v| mesh.vertices[v as usize]);
        let run = unit(sub(b, a));
        let off = |v: u32| norm(cross(sub(mesh.vertices[v as usize], a), run));
        for &at in crossed.iter().filter_map(|f| direct.get(f)).flatten() {
            let own = &found[at].0;
            if own.ends.into_iter().all(|v| off(v) <= reach) {
                // One of a sliver is no sharper for certain, and one that ends at once is a nick.
                let sharper = own.angle + own.doubt <= blunt.angle && own.thickness >= 0.5 * blunt.thickness;
                left_out[if sharper { n } else { at }] = true;
            }
        }
    }
    found.into_iter().zip(left_out).filter(|(_, left_out)| !left_out).map(|((c, _), _)| c).collect()
}

/// Angle of the wedge of material or void between two facets at an edge of the first; `None` if what is there is wider than a plane, or a facet
/// has no area.
fn wedge_between(mesh: &TriangleMesh, side: Side, [f, h]: [u32; 2], ends: [u32; 2]) -> Option<f64> {
    let (m, n) = (mesh.normal(f as usize), mesh.normal(h as usize));
    let [a, b] = ends.map(|v| mesh.vertices[v as usize]);
    let inner = PI - angle(m, n);
    let convex = side.sign() * dot(cross(m, n), sub(b, a)) > 0.0 || inner < 1e-6;
    (convex && m != [0.0; 3] && n != [0.0; 3]).then_some(inner)
}

/// An edge that a wedge of material or void runs out to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharpEdge {
    pub ends: [Vec3; 2],
    /// Unit normals of its two facets.
    pub normals: [Vec3; 2],
}

impl SharpEdge {
    /// How far two points are from lying one on each of the planes of its facets: the distance of the farther of them, millimetres.
    pub fn off(&self, points: [Vec3; 2]) -> f64 {
        let away = |p: Vec3, n: Vec3| dot(n, sub(p, self.ends[0])).abs();
        let [[a, b], [m, n]] = [points, self.normals];
        away(a, m).max(away(b, n)).min(away(a, n).max(away(b, m)))
    }
}

/// The edges at which the wedge on a side of the surface is sharper than an angle (radians).
///
/// # Cost
/// One walk over the edges.
pub fn sharp_edges(mesh: &TriangleMesh, next: &Adjacency, side: Side, widest: f64) -> Vec<SharpEdge> {
    let of_edge = |f: u32, e: usize| {
        let g = next.across(f, e).filter(|g| *g > f)?;
        let t = mesh.triangles[f as usize];
        let ends = [t[e], t[(e + 1) % 3]];
        let is_sharp = wedge_between(mesh, side, [f, g], ends).is_some_and(|angle| angle < widest);
        let normals = [f, g].map(|f| mesh.normal(f as usize));
        is_sharp.then(|| SharpEdge { ends: ends.map(|v| mesh.vertices[v as usize]), normals })
    };
    (0..mesh.triangles.len() as u32)
        .into_par_iter()
        .flat_map_iter(|f| (0..3).filter_map(move |e| of_edge(f, e)))
        .collect()
}

/// Both sides of a blunt edge, a wide facet of each, and where the second is nearest to the middle of the edge: the first face that makes a
/// wedge with the one before the edge, lies opposite its middle and is reached over faces that stay near it, of which the last makes none as sharp;
/// with those faces.
fn beyond(
    mesh: &TriangleMesh,
    next: &Adjacency,
    (f, g): (u32, u32),
    ends: [u32; 2],
    sought: Sharpness,
) -> Option<([u32; 2], Vec3, Vec<u32>)> {
    let [a, b] = ends.map(|v| mesh.vertices[v as usize]);
    let (middle, run) = (along(a, sub(b, a), 0.5), unit(sub(b, a)));
    let off = |p: Vec3| {
        let d = sub(p, a);
        norm(sub(d, scale(run, dot(d, run))))
    };
    let is_narrow = |h: u32| mesh.corners(h as usize).into_iter().all(|p| off(p) <= sought.blunt);
    let wide = |h: u32| wide_facet((mesh, next), h, (middle, sought.blunt, sought.step), off);
    if sought.blunt <= 0.0 || !is_narrow(g) || is_flat(mesh, [f, g], ends, sought.step) || wide(g).is_some() {
        return None;
    }
    let own = wide(f)?;
    let (mut known, mut at) = (vec![g], 0);
    while let Some(&narrow) = known.get(at).filter(|_| at < CROSSED) {
        at += 1;
        for e in 0..3 {
            let Some(h) = next.across(narrow, e).filter(|h| *h != f && !known.contains(h)) else { continue };
            let opposite = closest_point(middle, mesh.corners(h as usize));
            let Some(other) = wide(h) else {
                if distance(middle, opposite) <= sought.blunt && dot(mesh.normal(h as usize), run).abs() < ACROSS_END {
                    known.push(h);
                }
                continue;
            };
            let inner = PI - angle(mesh.normal(own as usize), mesh.normal(other as usize));
            // Where the narrow face makes as sharp an edge with the other side, that is the edge.
            let t = mesh.triangles[narrow as usize];
            let last = [t[e], t[(e + 1) % 3]];
            let direct = wedge_between(mesh, Side::Material, [narrow, h], last);
            let is_told = !is_needle(mesh, narrow, last, sought.step) && direct.is_some_and(|d| d <= inner);
            if inner <= sought.widest && !is_told && distance(middle, opposite) <= sought.blunt {
                return Some(([own, other], opposite, known));
            }
        }
    }
    None
}

/// The direction from a sharp edge into the material, at right angles to it; `None` if its facets have no corner off it.
pub fn inward(mesh: &TriangleMesh, crease: &Crease) -> Option<Vec3> {
    bisector(mesh, crease.facets, crease.ends, crease.facets.map(|f| mesh.normal(f as usize)))
}

/// The direction from an edge into the material: between the two facets.
fn bisector(mesh: &TriangleMesh, facets: [u32; 2], ends: [u32; 2], normals: [Vec3; 2]) -> Option<Vec3> {
    let outward = add(normals[0], normals[1]);
    if dot(outward, outward) > 1e-8 {
        return Some(scale(unit(outward), -1.0));
    }
    // Facets that lie on each other: towards their third corners.
    let [a, b] = ends.map(|v| mesh.vertices[v as usize]);
    let apex = facets.map(|f| mesh.triangles[f as usize].into_iter().find(|v| !ends.contains(v)));
    let apex = mesh.vertices[apex[0]? as usize];
    let d = sub(apex, a);
    let e = unit(sub(b, a));
    Some(unit(sub(d, scale(e, dot(d, e)))))
}

/// Creases joined at their ends into lines.
pub fn ridges(creases: &[Crease], chosen: impl Fn(&Crease) -> bool) -> Vec<Ridge> {
    let mut first_at: BTreeMap<u32, usize> = BTreeMap::new();
    let mut sets = DisjointSets::new(creases.len());
    for (i, c) in creases.iter().enumerate().filter(|(_, c)| chosen(c)) {
        for v in c.ends {
            let other = *first_at.entry(v).or_insert(i);
            sets.join(i as u32, other as u32);
        }
    }
    let mut lines: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (i, _) in creases.iter().enumerate().filter(|(_, c)| chosen(c)) {
        lines.entry(sets.root(i as u32)).or_default().push(i);
    }
    lines.into_values().map(|creases| Ridge { creases }).collect()
}

/// Length of a crease, millimetres.
pub fn length(mesh: &TriangleMesh, crease: &Crease) -> f64 {
    let [a, b] = crease.ends.map(|v| mesh.vertices[v as usize]);
    distance(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Adjacency;
    use crate::geometry::{cuboid, extruded};

    #[test]
    fn sharp_edges_are_those_of_wedges_of_one_side_and_know_their_sides() {
        let wedge: TriangleMesh = extruded(&[[0.0, 0.0], [8.0, 2.0], [8.0, -2.0]], &[[0, 2, 1]], 8.0);
        let found = |mesh: &TriangleMesh, side| sharp_edges(mesh, &Adjacency::of(mesh, |_| true), side, 0.6);
        let sharp = found(&wedge, Side::Material);
        assert_eq!((sharp.len(), found(&wedge, Side::Void)), (1, Vec::new()));
        let at = |x: f64, off: f64| scale([4.0, 16.0, off], x / 4.0);
        assert!(sharp[0].off([at(3.0, 1.0), at(2.0, -1.0)]) < 1e-9, "{sharp:?}");
        assert!(sharp[0].off([at(3.0, -1.0), at(2.0, 1.0)]) < 1e-9);
        assert!(sharp[0].off([at(3.0, 1.0), at(2.0, -1.2)]) > 0.09);
        assert_eq!(found(&cuboid([0.0; 3], [1.0; 3]), Side::Material), []);
    }

    const SOUGHT: Sharpness = Sharpness { widest: PI / 3.0, thick: 0.8, blunt: 0.06, step: 1e-9 };

    #[test]
    fn a_wedge_with_a_narrow_face_or_a_rounding_at_its_edge_is_one_edge_as_deep_from_there() {
        for (degrees, radius) in [(20.0f64, 0.01), (20.0, 0.025), (40.0, 0.02), (8.0, 0.001), (26.0, 0.005)] {
            let half = 0.5 * degrees.to_radians();
            for turns in [1, 2, 7, 10, 14, 20, 32, 90] {
                // The arc that touches both sides, of so many chords, its apex at x = 0.
                let turn =
                    |k: i32| (half - std::f64::consts::FRAC_PI_2) * (1.0 - 2.0 * f64::from(k) / f64::from(turns));
                let arc = (0..=turns).map(|k| turn(k).sin_cos()).map(|(s, c)| [radius * (1.0 - c), radius * s]);
                let back = 10.0 * half.tan() + radius / half.cos() - radius * half.tan();
                let outline: Vec<[f64; 2]> = arc.chain([[10.0, back], [10.0, -back]]).collect();
                let n = outline.len();
                let fan: Vec<[usize; 3]> = (1..n - 1).map(|k| [0, k, k + 1]).collect();
                let mesh = extruded(&outline, &fan, 8.0);
                let mesh = if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh };
                let found = creases(&mesh, &MeshDistance::new(&mesh), &Adjacency::of(&mesh, |_| true), SOUGHT);
                assert_eq!(found.len(), 1, "{degrees} {radius} {turns}: {found:?}");
                // Where the sides touch the arc they are 2·r·cos(φ/2) apart.
                let apart = 2.0 * radius * half.cos();
                assert!(
                    (found[0].angle.to_degrees() - degrees).abs() < 1e-6 && (found[0].blunt / apart - 1.0).abs() < 0.1,
                    "{found:?}"
                );
                // A ball of 0.8 mm has its middle 0.4 / sin(φ/2) from where the sides would meet, which is r / sin(φ/2) − r·sin(φ/2) before the face.
                let depth = (0.4 - radius) / half.sin() + radius * half.sin();
                assert!((found[0].depth / depth - 1.0).abs() < 1e-6, "{degrees} {radius} {turns}: {found:?} {depth}");
                assert_eq!(ridges(&found, |_| true).len(), 1);
            }
        }
        // A blunt edge wider than that is none, nor is a plate.
        for (x, half) in [(0.0, 0.05), (9.5, 0.02)] {
            let outline = [
                [x, -half],
                [10.0, if x > 1.0 { -half } else { -2.0 }],
                [10.0, if x > 1.0 { half } else { 2.0 }],
                [x, half],
            ];
            let mesh = extruded(&outline, &[[0, 1, 2], [0, 2, 3]], 8.0);
            let found = creases(&mesh, &MeshDistance::new(&mesh), &Adjacency::of(&mesh, |_| true), SOUGHT);
            assert!(found.is_empty(), "{found:?}");
        }
    }

    /// A cone of 96 sides upside down, its rim of radius 20 at z = 0; what covers it is given as facets between corners of the rim.
    fn rim(cap: &[[usize; 3]]) -> TriangleMesh {
        let at = |k: usize| {
            let (s, c) = (std::f64::consts::TAU * (k % 96) as f64 / 96.0).sin_cos();
            [20.0 * c, 20.0 * s, 0.0]
        };
        let tip = [0.0, 0.0, -20.0 * 25f64.to_radians().tan()];
        let flank = (0..96).map(|k| [at(k + 1), at(k), tip]);
        TriangleMesh::weld(flank.chain(cap.iter().map(|t| t.map(at))))
    }

    #[test]
    fn how_a_flat_side_is_divided_does_not_make_edges() {
        let told = |mesh: &TriangleMesh| {
            let found = creases(mesh, &MeshDistance::new(mesh), &Adjacency::of(mesh, |_| true), SOUGHT);
            (found.len(), found.iter().map(|c| length(mesh, c)).sum::<f64>())
        };
        let round = 96.0 * 40.0 * (PI / 96.0).sin();
        let fan: Vec<[usize; 3]> = (1..95).map(|k| [0, k, k + 1]).collect();
        // Every other corner is cut off, by an ear 0.043 mm high, then every other of those left.
        let ears = (0..96).step_by(2).map(|k| [k, k + 1, (k + 2) % 96]);
        let ears: Vec<[usize; 3]> = ears.chain((1..47).map(|k| [0, 2 * k, 2 * k + 2])).collect();
        for cap in [fan, ears] {
            let (count, long) = told(&rim(&cap));
            assert!(count == 96 && (long - round).abs() < 1e-9, "{count} {long}");
        }
        // A prism along y with its edge at the origin and a narrow strip of one side, with and without a blunt face of 0.02 mm.
        let half = 12.5f64.to_radians();
        let at = |s: f64, up: f64| [s * half.cos(), up * s * half.sin()];
        let strip = [at(0.02, 1.0), at(0.04, 1.0)];
        let sharp = [at(0.0, 1.0), at(20.0, -1.0), at(20.0, 1.0), strip[1], strip[0]];
        let start = 0.01 / half.sin();
        let blunt = [at(start, 1.0), at(start, -1.0), at(20.0, -1.0), at(20.0, 1.0), at(start + 0.02, 1.0)];
        for (outline, ends) in [(sharp, [[1, 2, 3], [1, 3, 4], [1, 4, 0]]), (blunt, [[2, 3, 4], [2, 4, 0], [2, 0, 1]])]
        {
            let mesh = extruded(&outline, &ends, 8.0);
            let mesh = if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh };
            let (count, long) = told(&mesh);
            assert!(count == 1 && (long - 8.0).abs() < 1e-9, "{count} {long}");
        }
    }

    #[test]
    fn of_a_narrow_face_and_what_is_behind_it_the_sharper_edge_is_told() {
        for (first, rest, count) in [(25f64, 30f64, 1), (40.0, 20.0, 1)] {
            let near = first.to_radians().sin_cos();
            let (s, c) = rest.to_radians().sin_cos();
            let bend = [0.03 * near.1, 0.03 * near.0];
            let outline = [[0.0, 0.0], [10.0, 0.0], [bend[0] + 10.0 * c, bend[1] + 10.0 * s], bend];
            let mesh = extruded(&outline, &[[3, 0, 1], [3, 1, 2]], 8.0);
            let mesh = if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh };
            let found = creases(&mesh, &MeshDistance::new(&mesh), &Adjacency::of(&mesh, |_| true), SOUGHT);
            let sharpest = found.iter().map(|c| c.angle.to_degrees()).fold(90.0, f64::min);
            assert!(found.len() == count && (sharpest - first.min(rest)).abs() < 1e-6, "{found:?}");
        }
    }

    #[test]
    fn an_edge_whose_sides_are_bevelled_on_both_sides_is_told_once_where_it_is_sharper() {
        for (first, rest) in [(26.0, 20.0), (20.0, 26.0), (16.6, 16.5), (40.0, 20.0), (12.0, 40.0)] {
            let mesh = blade(first, 0.03, rest, 8.0);
            let found = creases(&mesh, &MeshDistance::new(&mesh), &Adjacency::of(&mesh, |_| true), SOUGHT);
            assert!(found.len() == 1 && (length(&mesh, &found[0]) - 8.0).abs() < 1e-9, "{found:?}");
            assert!((found[0].angle.to_degrees() - f64::min(first, rest)).abs() < 1e-6, "{first} {rest}: {found:?}");
        }
    }

    #[test]
    fn a_wedge_whose_sides_turn_towards_each_other_is_as_deep_as_it_is_thin() {
        for (first, turn, rest) in [(26.0, 0.1, 20.0), (29.0, 0.5, 20.0), (29.0, 0.6, 15.0), (50.0, 0.2, 10.0)] {
            let mesh = blade(first, turn, rest, 12.0);
            let found = creases(&mesh, &MeshDistance::new(&mesh), &Adjacency::of(&mesh, |_| true), SOUGHT);
            let [near, far] = [first, rest].map(|d: f64| 0.5 * d.to_radians());
            // The sides behind the turn meet this far before the edge.
            let before = turn * near.tan() / far.tan() - turn;
            let depth = 0.4 / far.sin() - before;
            assert!(found.len() == 1 && found[0].thickness >= 0.8, "{found:?}");
            assert!((found[0].depth / depth - 1.0).abs() < 1e-6, "{first} {turn} {rest}: {found:?} {depth}");
        }
        // A plate behind it is no wedge, and one side that turns is enough.
        let plate = blade(26.0, 1.0, 0.0, 12.0);
        let found = creases(&plate, &MeshDistance::new(&plate), &Adjacency::of(&plate, |_| true), SOUGHT);
        let thick = 2.0 * 13f64.to_radians().tan();
        assert!(
            found.len() == 1 && found[0].depth < 2.0 && (found[0].thickness / thick - 1.0).abs() < 1e-6,
            "{found:?}"
        );
        let (near, far) = (26f64.to_radians().sin_cos(), 18f64.to_radians().sin_cos());
        let bend = [0.3 * near.1, 0.3 * near.0];
        let outline = [[0.0, 0.0], [12.0, 0.0], [bend[0] + 11.0 * far.1, bend[1] + 11.0 * far.0], bend];
        let chisel = extruded(&outline, &[[3, 0, 1], [3, 1, 2]], 8.0);
        let found = creases(&chisel, &MeshDistance::new(&chisel), &Adjacency::of(&chisel, |_| true), SOUGHT);
        // The middle of the ball of 0.8 mm is 0.4 mm above the flat side, on the bisector of it and the other one.
        let meet = bend[0] - bend[1] * far.1 / far.0;
        let depth = (meet + 0.4 / 9f64.to_radians().tan()).hypot(0.4);
        assert!(found.len() == 1 && (found[0].depth / depth - 1.0).abs() < 1e-6, "{found:?} {depth}");
    }

    /// A prism along y whose section is a wedge of the first angle up to x = `turn`, and of the second from there on.
    fn blade(first: f64, turn: f64, rest: f64, long: f64) -> TriangleMesh {
        let [near, far] = [first, rest].map(|d| (0.5 * d.to_radians()).tan());
        let (y, z) = (turn * near, turn * near + long * far);
        let outline = [[0.0, 0.0], [turn, -y], [turn + long, -z], [turn + long, z], [turn, y]];
        extruded(&outline, &[[0, 1, 4], [1, 2, 3], [1, 3, 4]], 8.0)
    }

    #[test]
    fn a_wedge_one_of_whose_sides_curves_away_is_as_deep_as_it_is_thin() {
        // The lip beside a hole of radius 4 that breaks out through a face, its middle `up` millimetres behind that.
        let radius = 4.0f64;
        for degrees in [5.0f64, 10.0, 12.8, 20.0, 28.0] {
            let lip = radius * degrees.to_radians().sin();
            let up = radius * degrees.to_radians().cos();
            let arc = (0..=400).map(|k| {
                let (s, c) = (-up.atan2(lip) * f64::from(k) / 400.0).sin_cos();
                [radius * c, if k == 400 { 0.0 } else { up + radius * s }]
            });
            let outline: Vec<[f64; 2]> = [[12.0, 0.0], [12.0, 8.0], [radius, 8.0]].into_iter().chain(arc).collect();
            let fan: Vec<[usize; 3]> = (1..outline.len() - 1).map(|k| [0, k, k + 1]).collect();
            let mesh = extruded(&outline, &fan, 8.0);
            let mesh = if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh };
            let found = creases(&mesh, &MeshDistance::new(&mesh), &Adjacency::of(&mesh, |_| true), SOUGHT);
            // The ball of 0.8 mm touches the face and the hole.
            let depth = (((radius + 0.4).powi(2) - (up - 0.4).powi(2)).sqrt() - lip).hypot(0.4);
            assert!(found.len() == 1 && found[0].thickness >= 0.8, "{degrees}: {found:?}");
            assert!((found[0].depth / depth - 1.0).abs() < 1e-3, "{degrees}: {found:?} {depth}");
        }
    }

    /// A prism along y whose section is an isosceles triangle of the given angle at the origin and depth 10.
    fn wedge(degrees: f64) -> TriangleMesh {
        let half = 10.0 * (0.5 * degrees).to_radians().tan();
        extruded(&[[0.0, 0.0], [10.0, -half], [10.0, half]], &[[0, 1, 2]], 8.0)
    }

    #[test]
    fn a_wedge_has_its_angle_and_its_depth_at_the_limit() {
        for degrees in [1.0f64, 3.0, 5.0, 20.0, 45.0, 59.0] {
            let mesh = wedge(degrees);
            let next = Adjacency::of(&mesh, |_| true);
            let found = creases(&mesh, &MeshDistance::new(&mesh), &next, SOUGHT);
            assert_eq!(found.len(), 1, "{found:?}");
            // The largest ball of the triangle touches its back, too.
            let s = (0.5 * degrees.to_radians()).sin();
            let (depth, thick) = ((0.4 / s).min(10.0 / (1.0 + s)), 0.8f64.min(20.0 * s / (1.0 + s)));
            assert!((found[0].angle.to_degrees() - degrees).abs() < 1e-9);
            assert!((found[0].depth / depth - 1.0).abs() < 1e-6, "{found:?} {depth}");
            assert!((found[0].thickness / thick - 1.0).abs() < 1e-6, "{found:?} {thick}");
            assert!((length(&mesh, &found[0]) - 8.0).abs() < 1e-12);
            assert_eq!(ridges(&found, |_| true).len(), 1);
        }
        let mesh =
            crate::geometry::Primitive::parse("box:3x2x1mm").expect("a shape").mesh(crate::units::Length::mm(0.1));
        let none = creases(&mesh, &MeshDistance::new(&mesh), &Adjacency::of(&mesh, |_| true), SOUGHT);
        assert!(none.is_empty());
    }
}
