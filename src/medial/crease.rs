//! Sharp edges of the surface: where two facets meet in a wedge of material, exactly.

use super::section::Adjacency;
use crate::geometry::vector::{Vec3, add, along, angle, cross, distance, dot, norm, scale, sub, unit};
use crate::geometry::{DisjointSets, MeshDistance, TriangleMesh};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Steps from an edge inwards at which its thickness is measured, at most.
const STEPS: usize = 400;
/// The first of them, as a share of the thickness asked for.
const FIRST_STEP: f64 = 0.05;
/// Wedges sharper than 0.5 degrees are followed as if they were not.
const LEAST_SINE: f64 = 0.0044;
/// A ball this much smaller than the wedge's own was stopped by something else, and the wedge ends there.
const ENDED: f64 = 0.9;

/// An edge between two facets that meet at a sharp angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crease {
    pub ends: [u32; 2],
    pub facets: [u32; 2],
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

/// The edges whose material angle is at most `widest` (radians), with the depth over which they are thinner than `thick`; coordinates are good
/// to `step`.
///
/// At a distance s from an edge of angle φ a wedge is 2 s·sin(φ/2) thick, the diameter of the ball about the point s inwards on the
/// bisector; the depth is where that ball, measured on the mesh, first reaches `thick`, or where the wedge ends.
///
/// # Cost
/// One walk over the edges; some tens of nearest points for each that is sharp.
pub fn creases(
    mesh: &TriangleMesh,
    surface: &MeshDistance,
    next: &Adjacency,
    (widest, thick, step): (f64, f64, f64),
) -> Vec<Crease> {
    (0..mesh.triangles.len() as u32)
        .into_par_iter()
        .flat_map_iter(|f| {
            let over = move |e: usize| next.across(f, e).filter(|&g| g > f).map(|g| (e, g));
            (0..3).filter_map(over).filter_map(move |(e, g)| {
                let (m, n) = (mesh.normal(f as usize), mesh.normal(g as usize));
                let t = mesh.triangles[f as usize];
                let ends = [t[e], t[(e + 1) % 3]];
                let [a, b] = ends.map(|v| mesh.vertices[v as usize]);
                let inner = PI - angle(m, n);
                let convex = dot(cross(m, n), sub(b, a)) > 0.0 || inner < 1e-6;
                if inner > widest || !convex || m == [0.0; 3] || n == [0.0; 3] {
                    return None;
                }
                let inward = bisector(mesh, [f, g], ends, [m, n])?;
                let (depth, thickness) = thinner_than(surface, along(a, sub(b, a), 0.5), inward, inner, thick);
                let doubt = [f, g].map(|f| step * distance(a, b) / norm(mesh.area_vector(f as usize))).iter().sum();
                Some(Crease { ends, facets: [f, g], angle: inner, doubt, depth, thickness })
            })
        })
        .collect()
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

/// Depth to where a wedge is as thick as asked or ends, and its thickness there.
///
/// Every step is as long as the ball's radius, so that no surface is crossed unseen.
fn thinner_than(surface: &MeshDistance, edge: Vec3, inward: Vec3, inner: f64, thick: f64) -> (f64, f64) {
    let sine = (0.5 * inner).sin().max(LEAST_SINE);
    let (mut depth, mut met) = (0.0, 0.0);
    let mut s = FIRST_STEP * thick;
    for _ in 0..STEPS {
        let p = along(edge, inward, s);
        let r = surface.nearest(p, thick).map_or(thick, |n| n.distance);
        if r < ENDED * (s * sine).min(0.5 * thick) {
            break;
        }
        if 2.0 * r >= thick {
            return (depth + (thick - met) / (2.0 * r - met) * (s - depth), thick);
        }
        (depth, met) = (s, 2.0 * r);
        s += r;
    }
    (depth, met)
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
    use crate::geometry::extruded;

    /// A prism along y whose section is an isosceles triangle of the given angle at the origin and depth 10.
    fn wedge(degrees: f64) -> TriangleMesh {
        let half = 10.0 * (0.5 * degrees).to_radians().tan();
        extruded(&[[0.0, 0.0], [10.0, -half], [10.0, half]], &[[0, 1, 2]], 8.0)
    }

    #[test]
    fn a_wedge_has_its_angle_and_its_depth_at_the_limit() {
        for degrees in [5.0, 20.0, 45.0, 59.0] {
            let mesh = wedge(degrees);
            let next = Adjacency::of(&mesh, |_| true);
            let found = creases(&mesh, &MeshDistance::new(&mesh), &next, (PI / 3.0, 0.8, 1e-9));
            assert_eq!(found.len(), 1, "{found:?}");
            let depth = 0.4 / (0.5 * degrees.to_radians()).sin();
            assert!((found[0].angle.to_degrees() - degrees).abs() < 1e-9);
            // Within the last step, and only if the back of the prism does not stop the ball.
            assert!((found[0].depth / depth - 1.0).abs() < 0.01 || depth > 9.0, "{found:?} {depth}");
            assert!((length(&mesh, &found[0]) - 8.0).abs() < 1e-12);
            assert_eq!(ridges(&found, |_| true).len(), 1);
        }
        let mesh =
            crate::geometry::Primitive::parse("box:3x2x1mm").expect("a shape").mesh(crate::units::Length::mm(0.1));
        let none = creases(&mesh, &MeshDistance::new(&mesh), &Adjacency::of(&mesh, |_| true), (PI / 3.0, 0.8, 1e-9));
        assert!(none.is_empty());
    }
}
