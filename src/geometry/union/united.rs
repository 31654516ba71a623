//! The union of a mesh.

use super::arrangement::Arrangement;
use super::bounding::bounding;
use super::cracks::{filling, is_closed};
use super::cuts::Cuts;
use super::pieces::pieces;
use super::points::Points;
use crate::geometry::health::{Health, meetings};
use crate::geometry::{MeshDistance, TriangleMesh};
use std::f64::consts::PI;

/// What is narrower than this, millimetres, and than this share of the longest side, is a speck: folds of a surface whose facets are within the
/// tolerance of each other, where no disc so wide lies between them.
const SPECK: (f64, f64) = (0.02, 0.005);

/// The mesh of `{ x : w(x) ≥ ½ }`, w the winding number of a closed surface: the union of its bodies, where they overlap or touch, and of
/// what passes through itself; `None` if that is no surface that bounds a solid and meets itself nowhere.
///
/// Facets are cut along the segments in which they meet others, and the winding number is known on both sides of each piece, all of it in
/// rational numbers; then points are rounded. Where sheets remain that lie within `tolerance_mm` of each other, as between bodies that
/// were meant to be flush, what is nearer than that is made to meet first; points move by no more. What is left of such sheets has to be
/// specks. Vertices that nothing uses are left out.
///
/// # Cost
/// O(T log T), an exact triangulation for each facet that is met, and a line through the mesh for each region between cuts.
///
/// # Source
/// Q. Zhou, E. Grinspun, D. Zorin, A. Jacobson, Mesh arrangements for solid geometry, 2016.
///
/// ```
/// use amcheck::geometry::{cuboid, union::united};
/// let both = cuboid([0.0; 3], [2.0, 2.0, 2.0]).joined(&cuboid([1.0, 1.0, 1.0], [3.0, 3.0, 3.0]));
/// let union = united(&both, 1e-6).expect("a solid");
/// assert!((union.signed_volume() - 15.0).abs() < 1e-9);
/// ```
pub fn united(mesh: &TriangleMesh, tolerance_mm: f64) -> Option<TriangleMesh> {
    let sound = |union: &TriangleMesh| is_sound(union, tolerance_mm);
    let exact = |arrangement: Arrangement| bounding(&arrangement).filter(sound);
    let as_it_is = Arrangement::of(mesh)?;
    exact(as_it_is).or_else(|| exact(Arrangement::of(&conformed(mesh, tolerance_mm)?)?))
}

/// The mesh with all that is nearer than the tolerance made to meet: vertices as one, and facets cut through what lies on them; closed if
/// the mesh is. `None` if a crack wider than that is left.
fn conformed(mesh: &TriangleMesh, tolerance: f64) -> Option<TriangleMesh> {
    let mesh = &snapped(mesh, tolerance);
    let mut cuts = Cuts::of(mesh, &MeshDistance::new(mesh), tolerance);
    let mut triangles = pieces(mesh, &mut cuts, tolerance);
    let vertices = cuts.points.places().to_vec();
    // The sides of what was left out are within the tolerance of each other, each moved by as much.
    triangles.extend(filling(&vertices, &triangles, 4.0 * tolerance)?);
    Some(TriangleMesh { vertices, triangles })
}

/// The mesh with vertices that are nearer than the tolerance as one; facets that shrink to less than a triangle are left out.
fn snapped(mesh: &TriangleMesh, tolerance: f64) -> TriangleMesh {
    let mut points = Points::new(&[], tolerance);
    let at: Vec<u32> = mesh.vertices.iter().map(|&p| points.at(p)).collect();
    let moved = mesh.triangles.iter().map(|t| t.map(|v| at.get(v as usize).copied().unwrap_or_default()));
    let triangles = moved.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    TriangleMesh { vertices: points.places().to_vec(), triangles }
}

/// Whether a surface bounds a solid and meets itself nowhere, but for specks.
fn is_sound(union: &TriangleMesh, tolerance: f64) -> bool {
    // Quickly seen, before all else is asked.
    if !is_closed(&union.triangles) {
        return false;
    }
    let health = Health::of(union);
    if !health.is_solid() || health.duplicate_facets.count > 0 || health.open_edges.count > 0 {
        return false;
    }
    let found = meetings(&MeshDistance::new(union), |_, _| true, 2.0 * tolerance);
    let speck = SPECK.0.min(SPECK.1 * union.longest_side());
    found.crossing.count == 0 && found.overlap_mm2 <= 0.25 * PI * speck * speck
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::{Vec3, unit};
    use crate::geometry::{Winding, cuboid};
    use crate::random::Lcg;

    /// The union, and whether its volume and area are as told.
    fn check(mesh: &TriangleMesh, volume: f64, area: f64) -> TriangleMesh {
        let union = united(mesh, 1e-6).unwrap();
        assert!((union.signed_volume() - volume).abs() < 1e-5, "{} {volume}", union.signed_volume());
        assert!((union.area() - area).abs() < 1e-5, "{} {area}", union.area());
        union
    }

    /// What lies inside the one lies inside the other.
    fn holds_the_same(meshes: [&TriangleMesh; 2], places: impl Iterator<Item = Vec3>) {
        let [plain, made] = meshes.map(Winding::new);
        places.for_each(|p| assert_eq!(plain.at(p) >= 0.5, made.at(p) >= 0.5, "{p:?}"));
    }

    fn turned(mesh: &TriangleMesh, random: &mut Lcg) -> TriangleMesh {
        let [x, y] = [random.point(-1.0, 1.0), random.point(-1.0, 1.0)].map(unit);
        let z = unit(crate::geometry::vector::cross(x, y));
        mesh.transformed([x, crate::geometry::vector::cross(z, x), z], random.point(-3.0, 3.0))
    }

    #[test]
    fn boxes_that_overlap_touch_or_swallow_each_other_are_one_surface() {
        let mut random = Lcg(41);
        let big = cuboid([0.0; 3], [4.0, 4.0, 2.0]);
        for turn in 0..6 {
            let whole = |small: TriangleMesh| {
                let both = big.clone().joined(&small);
                if turn == 0 { both } else { turned(&both, &mut random) }
            };
            let mut whole = whole;
            // Through a face, face to face within it, beside it with a common top, on a part of it over an edge, and inside.
            check(&whole(cuboid([1.0, 1.0, 1.0], [2.0, 2.0, 5.0])), 35.0, 64.0 + 12.0);
            check(&whole(cuboid([1.0, 1.0, 2.0], [2.0, 3.0, 3.0])), 34.0, 64.0 + 6.0);
            check(&whole(cuboid([3.0, 1.0, 1.0], [5.0, 2.0, 2.0])), 33.0, 64.0 + 4.0);
            check(&whole(cuboid([3.0, 3.0, 2.0], [5.0, 5.0, 3.0])), 36.0, 64.0 + 16.0 - 2.0);
            check(&whole(cuboid([1.0, 1.0, 0.5], [2.0, 2.0, 1.0])), 32.0, 64.0);
            check(&whole(cuboid([4.0, 0.0, 0.0], [6.0, 4.0, 2.0])), 48.0, 48.0 + 40.0);
            check(&whole(cuboid([2.0, 0.0, 0.0], [6.0, 4.0, 2.0])), 48.0, 48.0 + 40.0);
        }
    }

    #[test]
    fn bodies_meant_to_be_flush_are_one_however_small_they_are() {
        let mut random = Lcg(46);
        let part = cuboid([0.0; 3], [4.0, 4.0, 2.0]).joined(&cuboid([0.0, 0.0, 2.0], [3.0, 3.0, 5.0]));
        for turn in 0..4 {
            let part = turned(&part, &mut random);
            for size in [1.0, 0.01, 0.003, 1e-4] {
                // Rounded as in files.
                let corners = part.vertices.iter().map(|p| p.map(|x| f64::from((size * x) as f32))).collect();
                let rounded = TriangleMesh { vertices: corners, ..part.clone() };
                let union = united(&rounded, 2e-6 * size).unwrap_or_else(|| panic!("turn {turn}, {size}"));
                let volume = union.signed_volume() / size.powi(3);
                assert!((volume - 59.0).abs() < 1e-3 && union.pieces() == 1, "turn {turn}, {size}: {volume}");
                assert!((union.area() / size.powi(2) - 100.0).abs() < 1e-2, "turn {turn}, {size}: {}", union.area());
            }
        }
    }

    #[test]
    fn three_that_meet_in_a_point_of_a_face_are_united() {
        let mut random = Lcg(42);
        let beams = cuboid([-3.0, -1.0, -1.0], [3.0, 1.0, 1.0])
            .joined(&cuboid([-1.0, -3.0, -1.0], [1.0, 3.0, 1.0]))
            .joined(&cuboid([-1.0, -1.0, -3.0], [1.0, 1.0, 3.0]));
        // Six arms of 2 × 2 × 2 on a cube.
        check(&beams, 56.0, 120.0);
        check(&turned(&beams, &mut random), 56.0, 120.0);
        let crossed = cuboid([0.0; 3], [4.0, 4.0, 4.0])
            .joined(&cuboid([1.0, 1.0, -1.0], [2.0, 2.0, 5.0]))
            .joined(&turned(&cuboid([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]), &mut random));
        let union = united(&crossed, 1e-6).unwrap();
        let winding = Winding::new(&crossed);
        let inside = Winding::new(&union);
        for _ in 0..2000 {
            let p = random.point(-3.5, 5.5);
            assert_eq!(winding.at(p) >= 0.5, inside.at(p) >= 0.5, "{p:?}");
        }
    }

    #[test]
    fn balls_that_cross_have_the_volume_of_a_lens_less() {
        use crate::geometry::Primitive;
        use crate::units::Length;
        let ball = Primitive::Ball { radius: Length::mm(3.0) }.mesh(Length::mm(0.02));
        let mut random = Lcg(43);
        let moved = ball.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [2.5, 1.3, 0.7]);
        let both = ball.clone().joined(&turned(&moved, &mut random));
        let union = united(&both, 1e-6).unwrap();
        let health = Health::of(&union);
        assert!(health.is_solid() && union.signed_volume() <= both.signed_volume());
        holds_the_same([&both, &union], (0..2000).map(|_| random.point(-6.0, 6.0)));
    }

    #[test]
    fn bodies_that_are_flush_but_for_a_thousandth_and_less_are_united() {
        let mut random = Lcg(44);
        let big = cuboid([0.0; 3], [4.0, 4.0, 2.0]);
        for turn in 0..60 {
            let most = [1e-3, 1e-4, 1e-7][turn % 3];
            let [[t, u, lift], [x, y, _]] = [random.point(-most, most), random.point(0.0, 1.0)];
            let lean = [[1.0, 0.0, t], [0.0, 1.0, u], [-t, -u, 1.0]];
            // Its top and its bottom cross those of the other, or lie within the tolerance of them.
            let at = [3.5 + x, 1.0 + 2.0 * y, lift];
            let both = big.clone().joined(&cuboid([-1.0, -1.0, 0.0], [1.0, 1.0, 2.0]).transformed(lean, at));
            let union = united(&both, 1e-6).unwrap_or_else(|| panic!("{turn}: {lean:?} {at:?}"));
            let volume = 32.0 + 4.0 * (at[0] + 1.0 - 4.0);
            assert!((union.signed_volume() - volume).abs() < 40.0 * most + 1e-5, "{} {volume}", union.signed_volume());
            holds_the_same([&both, &union], (0..200).map(|_| random.point(-1.0, 6.0)));
        }
    }

    #[test]
    fn a_facet_without_area_in_an_edge_hands_on_where_others_cross_it() {
        let mut plate = cuboid([0.0; 3], [4.0, 4.0, 2.0]);
        let on_edge = |v: u32| plate.vertices[v as usize][1] == 0.0 && plate.vertices[v as usize][2] == 2.0;
        let sides = |t: [u32; 3]| (0..3).map(move |k| [t[k], t[(k + 1) % 3], t[(k + 2) % 3]]);
        let mut all = plate.triangles.iter().enumerate().flat_map(|(f, &t)| sides(t).map(move |s| (f, s)));
        let (facet, [a, b, c]) = all.find(|(_, [a, b, _])| on_edge(*a) && on_edge(*b)).unwrap();
        // A vertex within the edge on one side of it, and a facet of no width between.
        let m = plate.vertices.len() as u32;
        plate.vertices.push([2.2, 0.0, 2.0]);
        plate.triangles[facet] = [a, m, c];
        plate.triangles.extend([[m, b, c], [a, b, m]]);
        let through = cuboid([1.0, 1.0, 1.0], [2.0, 5.0, 3.0]).joined(&cuboid([1.5, -1.0, 1.5], [3.5, 0.5, 2.5]));
        // 32 mm³, and what stands out of them at the back, on top and before the edge.
        let union = united(&plate.joined(&through), 1e-6).unwrap();
        assert!((union.signed_volume() - (32.0 + 5.0 + 2.5)).abs() < 1e-5, "{}", union.signed_volume());
        assert!(Health::of(&union).is_watertight());
    }
    #[test]
    fn bodies_flush_but_for_the_rounding_of_a_file_are_one() {
        let mut random = Lcg(45);
        let boxes = (0..16).map(|n| {
            let (x, y) = (f64::from(5 * (n % 4)), f64::from(5 * (n / 4)));
            cuboid([x, y, 0.0], [x + 5.0, y + 5.0, f64::from(3 + 7 * n % 5)])
        });
        let boxes: Vec<TriangleMesh> = boxes.collect();
        let volume: f64 = boxes.iter().map(TriangleMesh::signed_volume).sum();
        for _ in 0..4 {
            let mut whole = boxes.iter().skip(1).fold(boxes[0].clone(), |all, one| all.joined(one));
            whole = turned(&whole, &mut random);
            whole.vertices.iter_mut().flatten().for_each(|x| *x = f64::from(*x as f32));
            // Floats of 20 mm are 2e-6 apart.
            let union = united(&whole, 1e-5).expect("a solid");
            assert!((union.signed_volume() - volume).abs() < 1e-3, "{} {volume}", union.signed_volume());
            assert_eq!(Health::of(&union).bodies.len(), 1);
        }
    }

    #[test]
    fn folds_of_a_micrometre_are_cut_off() {
        use crate::geometry::Primitive;
        use crate::units::Length;
        let ball = Primitive::Ball { radius: Length::mm(3.0) }.mesh(Length::mm(0.02));
        let mut random = Lcg(46);
        for _ in 0..20 {
            let mut folded = turned(&ball, &mut random);
            for _ in 0..8 {
                // A vertex of a facet just beyond the edge opposite.
                let [a, b, c] = folded.triangles[random.below(folded.triangles.len() as u64) as usize];
                let [p, q, r] = [a, b, c].map(|v| folded.vertices[v as usize]);
                let over = 1.0 + 1e-3 * random.unit();
                folded.vertices[a as usize] = [0, 1, 2].map(|i| p[i] + over * (0.6 * q[i] + 0.4 * r[i] - p[i]));
            }
            let union = united(&folded, 1e-6).expect("a solid");
            assert!(Health::of(&union).is_solid() && is_closed(&union.triangles));
            holds_the_same([&folded, &union], (0..200).map(|_| random.point(-6.0, 6.0)));
        }
    }

    #[test]
    fn what_no_lattice_holds_is_not_united() {
        let tiny = cuboid([0.0; 3], [1e-305; 3]);
        assert_eq!(united(&tiny.clone().joined(&tiny), 1e-6), None);
        let far = cuboid([0.0; 3], [f64::INFINITY; 3]);
        assert_eq!(united(&far.clone().joined(&far), 1e-6), None);
        // So far away that no cell of the tolerance has a number.
        let far = cuboid([0.0; 3], [1e300; 3]).joined(&cuboid([5e299; 3], [2e300; 3]));
        assert_eq!(snapped(&far, 1e-6), far);
        assert!(united(&far, 1e-6).is_none_or(|union| is_closed(&union.triangles)));
    }
}
