//! The surface of a part as patches small enough to be judged by one point.

use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, add, compare, distance, scale};
use rayon::prelude::*;

/// A piece of a facet, at most a few samples wide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    pub corners: [Vec3; 3],
    /// Its middle.
    pub at: Vec3,
    /// Unit normal, out of the material.
    pub normal: Vec3,
    /// Area, mm².
    pub area: f64,
    /// No point of it is further from the middle.
    pub radius: f64,
    /// The facet it is of.
    pub facet: u32,
}

/// The facets that `wanted` picks, cut until no edge is longer than `longest` millimetres; in the order of the mesh.
///
/// The areas of the patches of a facet add up to its area. Facets without area have none.
///
/// # Cost
/// O(facets + area/longest²).
pub fn patches(mesh: &TriangleMesh, longest: f64, wanted: impl Fn(usize) -> bool + Sync) -> Vec<Patch> {
    let of_facet = |f: usize| {
        let (mut found, normal) = (Vec::new(), mesh.normal(f));
        let mut open = vec![(from_the_least(mesh.corners(f)), mesh.facet_area(f))];
        while let Some(([a, b, c], area)) = open.pop() {
            let edges = [distance(a, b), distance(b, c), distance(c, a)];
            let at = (0..3).fold(0, |m, e| if edges[e] > edges[m] { e } else { m });
            if edges[at] > longest && longest > 0.0 {
                let [p, q, r] = [[a, b, c], [b, c, a], [c, a, b]][at];
                let middle = scale(add(p, q), 0.5);
                open.push(([p, middle, r], 0.5 * area));
                open.push(([middle, q, r], 0.5 * area));
                continue;
            }
            let at = scale(add(add(a, b), c), 1.0 / 3.0);
            let radius = [a, b, c].into_iter().map(|p| distance(at, p)).fold(0.0, f64::max);
            if area > 0.0 {
                found.push(Patch { corners: [a, b, c], at, normal, area, radius, facet: f as u32 });
            }
        }
        found
    };
    (0..mesh.triangles.len()).into_par_iter().filter(|&f| wanted(f)).flat_map_iter(of_facet).collect()
}

/// The corners in their sense of rotation from the least one, so that a file that starts elsewhere is cut the same way.
fn from_the_least([a, b, c]: [Vec3; 3]) -> [Vec3; 3] {
    let turns = [[a, b, c], [b, c, a], [c, a, b]];
    turns.into_iter().min_by(|p, q| compare(p[0], q[0])).unwrap_or([a, b, c])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::units::Length;

    #[test]
    fn patches_cover_the_surface_once() {
        let mesh = Primitive::parse("box:7x5x3mm").unwrap().mesh(Length::mm(1.0));
        let list = patches(&mesh, 0.8, |_| true);
        assert!((list.iter().map(|p| p.area).sum::<f64>() - mesh.area()).abs() < 1e-9);
        assert!(list.iter().all(|p| p.radius <= 0.8 && p.area <= 0.32));
        let top = patches(&mesh, 0.8, |f| mesh.normal(f)[2] > 0.9);
        assert!((top.iter().map(|p| p.area).sum::<f64>() - 35.0).abs() < 1e-9);
    }
}
