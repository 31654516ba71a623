//! The directions in which a mesh can be touched from outside: points for facets, arcs for edges, cones for vertices.

use super::bvh::{Bounds, Bvh};
use super::edges::EdgeTable;
use super::mesh::TriangleMesh;
use super::vector::{Vec3, add, along, bounds, cross, dot, scale, sub, unit};
use rayon::prelude::*;

/// Facets that turn by less than this, radians, are one plane, and no plane touches the edge between them alone; directions this
/// near to the end of an arc or the side of a cone belong to it. Rounding is some 1e-15.
const FLAT: f64 = 1e-9;

/// A turn about no axis of anybody's part, radians about x, y and z.
const TURN: Vec3 = [4.8e-7, 6.1e-7, 6.3e-7];

/// A convex edge: planes with an outward normal on the arc between the normals of its two facets touch all of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    /// Its ends.
    pub(super) ends: [u32; 2],
    /// The unit vector between them.
    pub(super) along: Vec3,
    from: Vec3,
    to: Vec3,
}

impl Arc {
    /// Whether the facets leave the material between them.
    fn is_convex(&self) -> bool {
        let turn = dot(cross(self.from, self.to), self.along);
        turn > FLAT || (turn > -FLAT && dot(self.from, self.to) < -0.5)
    }

    /// Whether a unit vector across the edge lies on the arc.
    pub(super) fn holds(&self, n: Vec3) -> bool {
        let turns_on = |m: Vec3, n: Vec3| dot(cross(m, n), self.along) >= -FLAT;
        turns_on(self.from, n) && turns_on(n, self.to) && dot(n, add(self.from, self.to)) >= -FLAT
    }

    /// A box that holds the arc.
    pub(super) fn bounds(&self) -> Bounds {
        if dot(self.from, self.to) < -0.99 {
            return SPHERE;
        }
        // Between its chord and the tangent in its middle.
        let middle = unit(add(self.from, self.to));
        let height = 1.0 - dot(middle, self.from);
        let above = [self.from, self.to].map(|end| along(end, middle, height));
        bounds([self.from, self.to, above[0], above[1]]).map_or(SPHERE, grown)
    }
}

/// The box of all directions.
const SPHERE: Bounds = ([-1.5; 3], [1.5; 3]);

/// A box with room for directions that belong to what it holds but for rounding.
fn grown((lo, hi): Bounds) -> Bounds {
    (lo.map(|x| x - 10.0 * FLAT), hi.map(|x| x + 10.0 * FLAT))
}

/// A vertex with convex edges: planes touch it alone, from outside, whose normals form a cone.
#[derive(Debug, Clone, Copy)]
struct Cone {
    vertex: u32,
    /// Where the directions of its edges are.
    first: u32,
    count: u32,
}

/// The planes that touch a mesh from outside without cutting it nearby, by their outward normals.
///
/// A facet is touched by one plane, a convex edge by those on an arc of the unit sphere, a vertex by those in the cone
/// `{ n : n·u ≤ 0 for all its edges u }`, if it has a convex edge; reflex edges by none. Facets may be wound either way: a mesh turned
/// inside out is touched from within.
///
/// # Cost
/// O(facets log facets); some 200 bytes a facet.
#[derive(Debug)]
pub struct GaussImage<'a> {
    pub(super) mesh: &'a TriangleMesh,
    pub(super) normals: Vec<Vec3>,
    pub(super) arcs: Vec<Arc>,
    cones: Vec<Cone>,
    /// Unit vectors along the edges of the cones' vertices.
    directions: Vec<Vec3>,
    tree_of_cones: Bvh,
}

impl<'a> GaussImage<'a> {
    /// The image of a mesh whose facets close, turned by a millionth of a radian.
    ///
    /// So that nothing of it is parallel to another mesh, and a plane touches one vertex where it would touch many alike. Which
    /// features a plane touches is then told of a mesh that is off by a millionth of its size; the corners stay where they are.
    pub fn of_turned(mesh: &'a TriangleMesh) -> Self {
        let [x, y, z] = TURN;
        let turned = mesh.transformed([[1.0, -z, y], [z, 1.0, -x], [-y, x, 1.0]], [0.0; 3]);
        let GaussImage { normals, arcs, cones, directions, tree_of_cones, .. } = GaussImage::of(&turned);
        GaussImage { mesh, normals, arcs, cones, directions, tree_of_cones }
    }

    /// The image of a mesh whose facets close.
    pub fn of(mesh: &'a TriangleMesh) -> Self {
        let normals: Vec<Vec3> = (0..mesh.triangles.len()).into_par_iter().map(|f| mesh.normal(f)).collect();
        let table = EdgeTable::of(mesh);
        let (mut arcs, mut edges) = (Vec::new(), Vec::new());
        for edge in table.edges() {
            let [p, q] = edge.ends.map(|v| mesh.vertices[v as usize]);
            let (ends, along) = (edge.ends, unit(sub(q, p)));
            let known = arcs.len();
            // A facet that runs from p to q lies to the left of the edge, one that runs back to its right.
            let of = |way: i32| edge.sides.iter().filter(move |s| s.1.direction() == way).map(|s| normals[s.1.facet()]);
            let pairs = of(1).flat_map(|from| of(-1).map(move |to| Arc { ends, along, from, to }));
            arcs.extend(pairs.filter(Arc::is_convex));
            edges.push((ends, along, arcs.len() > known));
        }
        let (cones, directions) = cones(mesh.vertices.len(), &edges);
        let caps = caps(mesh, &normals);
        let boxes: Vec<Bounds> = cones.par_iter().map(|cone| caps[cone.vertex as usize].bounds()).collect();
        GaussImage { mesh, normals, arcs, cones, directions, tree_of_cones: Bvh::new(&boxes) }
    }

    /// Calls `visit` for the vertices that a plane with an outward normal touches.
    pub(super) fn touched(&self, n: Vec3, mut visit: impl FnMut(u32)) {
        self.tree_of_cones.in_box((n, n), |cone| {
            let Cone { vertex, first, count } = self.cones[cone as usize];
            let mut edges = self.directions[first as usize..(first + count) as usize].iter();
            if edges.all(|&u| dot(n, u) <= FLAT) {
                visit(vertex);
            }
        });
    }
}

/// The vertices with a convex edge, and the directions of all of their edges.
fn cones(vertices: usize, edges: &[([u32; 2], Vec3, bool)]) -> (Vec<Cone>, Vec<Vec3>) {
    let mut counts = vec![(0u32, false); vertices];
    for (ends, _, convex) in edges {
        for &v in ends {
            let (count, any) = &mut counts[v as usize];
            (*count, *any) = (*count + 1, *any || *convex);
        }
    }
    let (mut cones, mut numbers, mut total) = (Vec::new(), vec![u32::MAX; vertices], 0);
    for (vertex, &(count, _)) in (0u32..).zip(&counts).filter(|(_, (_, convex))| *convex) {
        numbers[vertex as usize] = cones.len() as u32;
        cones.push(Cone { vertex, first: total, count: 0 });
        total += count;
    }
    let mut directions = vec![[0.0; 3]; total as usize];
    for &(ends, along, _) in edges {
        for (v, u) in ends.into_iter().zip([along, scale(along, -1.0)]) {
            if let Some(cone) = cones.get_mut(numbers[v as usize] as usize) {
                directions[(cone.first + cone.count) as usize] = u;
                cone.count += 1;
            }
        }
    }
    (cones, directions)
}

/// The directions within an angle of an axis.
#[derive(Debug, Clone, Copy)]
struct Cap {
    axis: Vec3,
    cosine: f64,
}

impl Cap {
    /// A box that holds it.
    fn bounds(&self) -> Bounds {
        if self.cosine <= 0.0 {
            return SPHERE;
        }
        let angle = self.cosine.min(1.0).acos();
        let at = |a: usize| self.axis[a].clamp(-1.0, 1.0).acos();
        let least = |a: usize| (at(a) + angle).min(std::f64::consts::PI).cos();
        let greatest = |a: usize| (at(a) - angle).max(0.0).cos();
        grown(([0, 1, 2].map(least), [0, 1, 2].map(greatest)))
    }
}

/// A cap for each vertex that holds the normals of its facets, and so its cone: the sides of that lie on arcs of its edges.
fn caps(mesh: &TriangleMesh, normals: &[Vec3]) -> Vec<Cap> {
    let mut caps = vec![Cap { axis: [0.0; 3], cosine: 1.0 }; mesh.vertices.len()];
    let corners = || mesh.triangles.iter().zip(normals).flat_map(|(t, &n)| t.iter().map(move |&v| (v as usize, n)));
    corners().for_each(|(v, n)| caps[v].axis = add(caps[v].axis, n));
    caps.par_iter_mut().for_each(|cap| cap.axis = unit(cap.axis));
    let with_normal = corners().filter(|(_, n)| *n != [0.0; 3]);
    with_normal.for_each(|(v, n)| caps[v].cosine = caps[v].cosine.min(dot(caps[v].axis, n)));
    caps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Primitive, cuboid, extruded};
    use crate::random::Lcg;
    use crate::units::Length;

    fn touched(image: &GaussImage, n: Vec3) -> Vec<u32> {
        let mut found = Vec::new();
        image.touched(n, |v| found.push(v));
        found.sort_unstable();
        found
    }

    #[test]
    fn planes_touch_a_convex_body_where_it_is_highest() {
        let ball = Primitive::parse("ball:2mm").unwrap().mesh(Length::mm(0.05));
        let image = GaussImage::of(&ball);
        let mut random = Lcg(2);
        for _ in 0..2000 {
            let n = unit(random.point(-1.0, 1.0));
            let height = |v: &u32| dot(n, ball.vertices[*v as usize]);
            let highest = (0..ball.vertices.len() as u32).max_by(|a, b| height(a).total_cmp(&height(b))).unwrap();
            assert_eq!(touched(&image, n), [highest]);
        }
        // All of its edges are convex, but for the diagonals of flat facets; those of its inside are none.
        assert!(image.arcs.len() >= ball.vertices.len());
        let inside = ball.flipped();
        assert_eq!(GaussImage::of(&inside).arcs.len(), 0);
    }

    #[test]
    fn flat_edges_have_no_arcs_and_reflex_corners_no_cones() {
        let cube = cuboid([0.0; 3], [1.0, 2.0, 3.0]);
        let image = GaussImage::of(&cube);
        assert_eq!((image.arcs.len(), image.cones.len()), (12, 8));
        assert_eq!(touched(&image, [0.0, 0.0, 1.0]).len(), 4);
        let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let l = extruded(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], 1.0);
        let image = GaussImage::of(&l);
        // Eighteen edges between faces, of which one is reflex.
        assert_eq!(image.arcs.len(), 17);
        let at = |v: &u32| l.vertices[*v as usize];
        let ends: Vec<Vec3> = touched(&image, unit([1.0, 0.5, 1.0])).iter().map(at).collect();
        assert!(ends.contains(&[2.0, 1.0, 1.0]) && ends.contains(&[1.0, 1.0, 2.0]) && ends.len() == 2, "{ends:?}");
    }

    #[test]
    fn boxes_hold_their_arcs_and_cones() {
        let mut random = Lcg(4);
        for _ in 0..2000 {
            let [from, to] = [0; 2].map(|_| unit(random.point(-1.0, 1.0)));
            let arc = Arc { ends: [0, 1], along: unit(cross(from, to)), from, to };
            let (lo, hi) = arc.bounds();
            for t in 0..=20 {
                let n = unit(along(scale(from, 1.0 - f64::from(t) / 20.0), to, f64::from(t) / 20.0));
                assert!(arc.holds(n) && (0..3).all(|a| lo[a] <= n[a] && n[a] <= hi[a]), "{from:?} {to:?} {n:?}");
            }
            let cap = Cap { axis: from, cosine: dot(from, to) };
            let (lo, hi) = cap.bounds();
            let n = unit(random.point(-1.0, 1.0));
            assert!(
                dot(n, from) < cap.cosine || (0..3).all(|a| lo[a] <= n[a] && n[a] <= hi[a]),
                "{from:?} {to:?} {n:?}"
            );
        }
    }
}
