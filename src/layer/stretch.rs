//! Lines across a ceiling in plan, and its height above them.

use super::section::Point;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, norm, sub};

/// Facets this near each other along a line, in millimetres, are one stretch: slivers between them are left out of ceilings.
const JOINED: f64 = 0.02;

/// The stretch of a line through a place, along a unit vector, that lies on the facets and holds the place: its ends, at the height of the
/// facets there. `None` where no facet lies above the place.
///
/// # Cost
/// O(facets).
pub fn stretch(mesh: &TriangleMesh, facets: &[u32], at: Point, direction: Point) -> Option<[Vec3; 2]> {
    let across = |p: Vec3| (p[1] - at[1]) * direction[0] - (p[0] - at[0]) * direction[1];
    let along = |p: Vec3| (p[0] - at[0]) * direction[0] + (p[1] - at[1]) * direction[1];
    let mut met: Vec<[f64; 2]> = Vec::new();
    for &f in facets {
        let corners = mesh.corners(f as usize);
        let mut span: Option<[f64; 2]> = None;
        for e in 0..3 {
            let (p, q) = (corners[e], corners[(e + 1) % 3]);
            let (a, b) = (across(p), across(q));
            if a == b || a.min(b) > 0.0 || a.max(b) < 0.0 {
                continue;
            }
            let t = along(p) + (along(q) - along(p)) * a / (a - b);
            span = Some(span.map_or([t, t], |[lo, hi]| [lo.min(t), hi.max(t)]));
        }
        met.extend(span);
    }
    met.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for [from, to] in met {
        match joined.last_mut().filter(|last| from <= last[1] + JOINED) {
            Some(last) => last[1] = last[1].max(to),
            None => joined.push([from, to]),
        }
    }
    let own = joined.into_iter().find(|s| s[0] <= JOINED && s[1] >= -JOINED)?;
    let point = |t: f64| lifted(mesh, facets, [at[0] + t * direction[0], at[1] + t * direction[1]]);
    Some(own.map(point))
}

/// The point of the facets above a place; at the height of the lowest of them where none is.
pub fn lifted(mesh: &TriangleMesh, facets: &[u32], p: Point) -> Vec3 {
    let lowest = || facets.iter().flat_map(|&f| mesh.corners(f as usize)).map(|p| p[2]).fold(f64::INFINITY, f64::min);
    above(mesh, facets, p).unwrap_or_else(|| [p[0], p[1], lowest()])
}

/// The point of the facets above a place, if one is.
pub fn above(mesh: &TriangleMesh, facets: &[u32], p: Point) -> Option<Vec3> {
    let over = |f: &&u32| {
        let [a, b, c] = mesh.corners(**f as usize);
        let turn = |a: Vec3, b: Vec3| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
        let signs = [turn(a, b), turn(b, c), turn(c, a)];
        // A point on the boundary may lie a rounding beside it.
        let tie = 1e-9 * (1.0 + norm(sub(b, a)) * norm(sub(c, a)));
        signs.iter().all(|s| *s >= -tie) || signs.iter().all(|s| *s <= tie)
    };
    let on = |f: &u32| {
        let (n, a) = (mesh.area_vector(*f as usize), mesh.corners(*f as usize)[0]);
        a[2] - (n[0] * (p[0] - a[0]) + n[1] * (p[1] - a[1])) / n[2]
    };
    facets.iter().find(over).map(|f| [p[0], p[1], on(f)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ceiling of 6 × 4 mm that rises by half a millimetre over its length, and another one 3 mm beside it.
    fn ceilings() -> TriangleMesh {
        let quad = |x: f64| {
            let p = |dx: f64, y: f64| [x + dx, y, 5.0 + dx / 12.0];
            [[p(0.0, 0.0), p(6.0, 4.0), p(6.0, 0.0)], [p(0.0, 0.0), p(0.0, 4.0), p(6.0, 4.0)]]
        };
        TriangleMesh::weld([quad(0.0), quad(9.0)].concat())
    }

    #[test]
    fn a_stretch_ends_where_its_ceiling_ends() {
        let mesh = ceilings();
        let all: Vec<u32> = (0..4).collect();
        let ends = stretch(&mesh, &all, [2.0, 1.0], [1.0, 0.0]).unwrap();
        let near = |p: Vec3, q: Vec3| (0..3).all(|a| (p[a] - q[a]).abs() < 1e-9);
        assert!(near(ends[0], [0.0, 1.0, 5.0]) && near(ends[1], [6.0, 1.0, 5.5]), "{ends:?}");
        let d = 0.5f64.sqrt();
        let ends = stretch(&mesh, &all, [2.0, 1.0], [d, d]).unwrap();
        assert!(near(ends[0], [1.0, 0.0, 5.0 + 1.0 / 12.0]) && near(ends[1], [5.0, 4.0, 5.0 + 5.0 / 12.0]), "{ends:?}");
        assert!(stretch(&mesh, &all, [7.5, 1.0], [1.0, 0.0]).is_none());
        assert!(stretch(&mesh, &all, [2.0, 7.0], [1.0, 0.0]).is_none());
    }
}
