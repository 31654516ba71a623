//! Pieces of a surface that only cracks part: their rims lie at each other.

use crate::geometry::TriangleMesh;
use crate::geometry::bvh::Bvh;
use crate::geometry::edges::{Edge, EdgeTable};
use crate::geometry::triangle::closest_point;
use crate::geometry::vector::{Vec3, along, bounds, cross, distance, norm, sub};
use rayon::prelude::*;

/// Share of the length of either of two rim edges that a crack between them is narrower than: rounding, and vertices that exporters
/// move, leave 10⁻⁷ to 3·10⁻³, where clearances are wide against what facets round off.
const CRACK: f64 = 0.01;
/// Where along an edge a crack is looked for: two edges that cross are near each other at no more than one of these.
const ALONG: [f64; 2] = [0.25, 0.75];
/// The sine of the angle between edges at a crack is less: both their ends are off by about the crack's width, 0.02 of the shorter
/// edge, and that is doubled where cracks widen towards corners.
const TURNED: f64 = 0.05;

/// Edges at whose ends others are counted before cracks are sought at all.
const LOOKS: usize = 16;
/// Edges that may have an end of another in their boxes, on average: a vertex of a mesh has six or so, where long slivers meet some hundreds.
const MANY: usize = 1000;

/// Two edges of one facet each, on both sides of a crack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crack {
    /// Their facets.
    pub facets: [u32; 2],
    /// The vertices of each.
    pub ends: [[u32; 2]; 2],
}

/// An edge of one facet.
struct RimEdge {
    facet: u32,
    vertices: [u32; 2],
    ends: [Vec3; 2],
    length: f64,
}

/// The cracks of a mesh: along each runs an edge of one facet whose quarter and three-quarter points both lie nearer to other such edges,
/// about parallel to it, than a hundredth of the shorter edge. None are sought among edges that lie about anyhow.
///
/// # Cost
/// O(facets), and O(E log E) for E edges of one facet.
pub fn cracks(mesh: &TriangleMesh) -> Vec<Crack> {
    cracks_of(mesh, &EdgeTable::of(mesh))
}

/// As [`cracks`], of a mesh with its edges.
pub(super) fn cracks_of(mesh: &TriangleMesh, table: &EdgeTable) -> Vec<Crack> {
    let rim = |edge: Edge<'_>| {
        let &[(_, side)] = edge.sides else { return None };
        let ends = edge.ends.map(|v| mesh.vertices[v as usize]);
        let length = distance(ends[0], ends[1]);
        Some(RimEdge { facet: side.facet() as u32, vertices: edge.ends, ends, length })
    };
    let rims: Vec<RimEdge> = table.edges().filter_map(rim).collect();
    let boxes: Vec<(Vec3, Vec3)> = rims.iter().map(|r| bounds(r.ends).unwrap_or_default()).collect();
    if is_tangled(&rims, &boxes) {
        return Vec::new();
    }
    let tree = Bvh::new(&boxes);
    (0..rims.len()).into_par_iter().flat_map_iter(|n| beside(n, &rims, &tree)).collect()
}

/// Whether edges have very many others in their boxes, as those of triangles have that lie about anyhow: then none is sought beside all.
fn is_tangled(rims: &[RimEdge], boxes: &[(Vec3, Vec3)]) -> bool {
    let each = rims.len().div_ceil(LOOKS).max(1);
    let ends = || rims.iter().step_by(each).map(|rim| rim.ends[0]);
    let holds = |p: Vec3| move |(lo, hi): &&(Vec3, Vec3)| (0..3).all(|a| lo[a] <= p[a] && p[a] <= hi[a]);
    ends().map(|p| boxes.iter().filter(holds(p)).count()).sum::<usize>() > MANY * ends().count()
}

/// The cracks along one edge; none where nothing runs along a part of it.
fn beside(n: usize, rims: &[RimEdge], tree: &Bvh) -> Vec<Crack> {
    let rim = &rims[n];
    let mut found = Vec::new();
    for share in ALONG {
        let before = found.len();
        let p = along(rim.ends[0], sub(rim.ends[1], rim.ends[0]), share);
        let wide = CRACK * rim.length;
        tree.in_box((p.map(|x| x - wide), p.map(|x| x + wide)), |m| {
            let other = &rims[m as usize];
            let [a, b] = other.ends;
            let away = distance(p, closest_point(p, [a, b, b]));
            let turned = norm(cross(sub(rim.ends[1], rim.ends[0]), sub(b, a)));
            let is_along = turned < TURNED * rim.length * other.length;
            if m as usize != n && is_along && away < CRACK * rim.length.min(other.length) {
                found.push(Crack { facets: [rim.facet, other.facet], ends: [rim.vertices, other.vertices] });
            }
        });
        if found.len() == before {
            return Vec::new();
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use crate::geometry::health::{Health, Role};
    use crate::geometry::vector::add;
    use crate::geometry::{Primitive, TriangleMesh, cuboid};
    use crate::random::Lcg;
    use crate::units::Length;

    /// Every facet by itself, its corners off by up to `by` along each axis.
    fn cracked(mesh: &TriangleMesh, by: f64) -> TriangleMesh {
        let mut random = Lcg(7);
        let facets = (0..mesh.triangles.len()).map(|f| mesh.corners(f));
        TriangleMesh::weld(facets.map(|t| t.map(|p| add(p, random.point(-by, by)))))
    }

    #[test]
    fn pieces_that_only_cracks_part_are_one_body() {
        let ball = Primitive::Ball { radius: Length::mm(5.0) }.mesh(Length::mm(0.05));
        let volume = ball.signed_volume();
        for by in [1e-5, 1e-3] {
            let health = Health::of(&cracked(&ball, by));
            assert_eq!((health.bodies.len(), health.shells.len()), (1, 1), "{by}");
            assert!(health.shells[0].role == Role::Open && !health.is_solid());
            // Cracks as wide as that, all round, are off by their width times the area at most.
            assert!((health.volume_mm3() - volume).abs() < by * 314.2, "{} {volume}", health.volume_mm3());
        }
    }

    #[test]
    fn open_pieces_that_lie_apart_or_cross_stay_bodies_of_their_own() {
        let open = |mut mesh: TriangleMesh| {
            mesh.triangles.pop();
            mesh
        };
        let block = |x: f64| open(cuboid([x, 0.0, 0.0], [x + 4.0, 4.0, 4.0]));
        // A hundredth of the shortest edge of their rims is 0.04 mm; crossed, rims come together at single points.
        for other in [block(4.05), open(cuboid([0.0, -1.3, 0.7], [4.0, 2.7, 4.7]))] {
            let health = Health::of(&block(0.0).joined(&other));
            assert_eq!((health.bodies.len(), health.shells.len()), (2, 2));
        }
    }

    #[test]
    fn loose_triangles_that_lie_about_stay_bodies_of_their_own() {
        let mut random = Lcg(23);
        for _ in 0..20 {
            let soup: Vec<_> = (0..100).map(|_| [0; 3].map(|_| random.point(0.0, 1.0))).collect();
            assert_eq!(Health::of(&TriangleMesh::weld(soup)).bodies.len(), 100);
        }
    }
}
