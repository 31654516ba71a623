//! A coarser copy of a mesh that stays closed: the corners in one cell of a lattice become one corner.

use super::mesh::TriangleMesh;
use super::vector::{Vec3, add, distance, norm, sub};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// A copy of a mesh with fewer facets.
#[derive(Debug, Clone)]
pub struct Coarser {
    /// The corners and facets that are left, wound as they were.
    pub mesh: TriangleMesh,
    /// The number that each facet of the copy has in the mesh, rising.
    pub facets: Vec<usize>,
    /// The greatest distance that a corner was moved, millimetres.
    pub moved_mm: f64,
}

impl Coarser {
    /// The copy of a mesh with at most `most` facets, mostly with nine tenths of that; `None` where the mesh has no more than that itself.
    ///
    /// Corners in one cell of a cubic lattice that face the same side become one, at their mean; where there are creases in the cell, that
    /// corner of the sharpest crease which lies nearest to the mean of those, so that edges stay where they are. Facets whose corners fall
    /// together vanish. Sides that face apart stay apart, so that walls, gaps and pins thinner than a cell are still there. The lattice is as
    /// fine as the count allows.
    ///
    /// The map of corners to corners carries facets to facets, edges or points: where every edge of the mesh is used as often one way as the
    /// other the copy's are too, and what is closed stays closed. No point moves farther than [`Coarser::moved_mm`], and that is
    /// at most a cell's diagonal: no point of the copy lies farther than that from the mesh.
    ///
    /// # Cost
    /// O(corners + facets) for each size of the cell that is tried, mostly two to four, in parallel; one hash look-up a corner at the end.
    ///
    /// # Limits
    /// A picture: facets may cross or lie on one another, rims thinner than a cell may be bevelled within it, surfaces rough within a cell
    /// stay rough, and bodies smaller than a cell may vanish.
    ///
    /// # Source
    /// J. Rossignac, P. Borrel, Multi-resolution 3D approximations for rendering complex scenes, in: Modeling in Computer Graphics,
    /// Springer 1993, pp. 455–465.
    pub fn of(mesh: &TriangleMesh, most: usize) -> Option<Self> {
        if mesh.triangles.len() <= most {
            return None;
        }
        let (low, high) = mesh.bounds().unwrap_or_default();
        let longest = sub(high, low).into_iter().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let outward = Outward::of(mesh);
        let (facing, alike) = (outward.facing(), vec![0; mesh.vertices.len()]);
        let area = outward.areas.iter().sum::<f64>() / 6.0;
        let start = (area / (FACETS_A_CELL * most as f64)).sqrt();
        let search = Search { start, least: longest / LAST as f64, most };
        let keys = |cell: f64, facing: &[u8]| keys(mesh, (low, cell), facing);
        // Where all sides of all corners are too many facets however large the cell is, sides fall together.
        let keys = [&facing, &alike]
            .into_iter()
            .find_map(|facing| search.cell(|cell| left(mesh, &keys(cell, facing))).map(|cell| keys(cell, facing)))
            .unwrap_or(vec![0; mesh.vertices.len()]);
        Some(Self::by(mesh, &keys, &outward))
    }

    /// The copy in which corners with one key are one corner.
    fn by(mesh: &TriangleMesh, keys: &[u64], outward: &Outward) -> Self {
        let mut known: FxHashMap<u64, u32> = FxHashMap::default();
        let cluster = |key: &u64| {
            let next = known.len() as u32;
            *known.entry(*key).or_insert(next)
        };
        let of_vertex: Vec<u32> = keys.iter().map(cluster).collect();
        let places = places(mesh, &of_vertex, known.len(), outward);
        let (mut copy, mut facets, mut moved_mm) = (TriangleMesh::default(), Vec::new(), 0.0f64);
        let mut number = vec![NONE; places.len()];
        for (facet, corners) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|v| of_vertex[v as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            copy.triangles.push([a, b, c].map(|cluster| {
                let number = &mut number[cluster as usize];
                if *number == NONE {
                    *number = copy.vertices.len() as u32;
                    copy.vertices.push(places[cluster as usize]);
                }
                *number
            }));
            facets.push(facet);
        }
        for &v in mesh.triangles.iter().flatten() {
            moved_mm = moved_mm.max(distance(mesh.vertices[v as usize], places[of_vertex[v as usize] as usize]));
        }
        Coarser { mesh: copy, facets, moved_mm }
    }
}

/// Facets left for each cell's side of surface, from a sphere: a first guess of the cell.
const FACETS_A_CELL: f64 = 3.0;
/// The last cell along an axis; a key has twenty bits for each.
const LAST: u64 = (1 << 20) - 2;
/// Where the least corner lies in its cell: faces along the axes at round lengths lie on no wall of the lattice.
const SHIFT: f64 = 0.37;
/// No number.
const NONE: u32 = u32::MAX;

/// The key of each corner: its cell and the side that it faces.
fn keys(mesh: &TriangleMesh, (low, cell): (Vec3, f64), facing: &[u8]) -> Vec<u64> {
    let key = |(p, side): (&Vec3, &u8)| {
        let [x, y, z] = [0, 1, 2].map(|a| (((p[a] - low[a]) / cell + SHIFT) as u64).min(LAST + 1));
        x | y << 20 | z << 40 | u64::from(*side) << 60
    };
    mesh.vertices.par_iter().zip(facing).map(key).collect()
}

/// Facets whose corners have three keys.
fn left(mesh: &TriangleMesh, keys: &[u64]) -> usize {
    let stays = |t: &&[u32; 3]| {
        let [a, b, c] = t.map(|v| keys[v as usize]);
        a != b && b != c && c != a
    };
    mesh.triangles.par_iter().filter(stays).count()
}

/// The search for the cell that leaves as many facets as may be.
struct Search {
    start: f64,
    least: f64,
    most: usize,
}

impl Search {
    /// Sizes that are tried at most.
    const TRIES: u32 = 16;
    /// Share by which the size changes at least after the first try where all tries were too fine, or all too coarse; after each further one twice that.
    const STEP: f64 = 0.1;
    /// Shares of the most facets that are aimed at, and that are enough.
    const AIM: f64 = 0.93;
    const ENOUGH: f64 = 0.85;

    /// A cell that leaves no more facets than wanted, found between sizes that leave too many and too few; `None` where no size did.
    fn cell(&self, left: impl Fn(f64) -> usize) -> Option<f64> {
        let (mut fine, mut coarse): (Option<[f64; 2]>, Option<[f64; 2]>) = (None, None);
        let mut cell = if self.start.is_finite() { self.start.max(self.least) } else { self.least };
        for tries in 0..Self::TRIES {
            let count = left(cell);
            let tried = Some([cell, count as f64]);
            if count > self.most {
                fine = tried;
            } else {
                coarse = tried;
                if count as f64 >= Self::ENOUGH * self.most as f64 || cell <= self.least {
                    break;
                }
            }
            cell = self.next(fine, coarse, 1.0 + Self::STEP * f64::from(1 << tries)).max(self.least);
        }
        coarse.map(|[cell, _]| cell)
    }

    /// The next size: counts fall with a power of it between two sizes, and with its square beyond one. Up to the distance of corners
    /// that lie regularly they do not fall at all; `step` is the factor that is taken beyond one size at least.
    fn next(&self, fine: Option<[f64; 2]>, coarse: Option<[f64; 2]>, step: f64) -> f64 {
        let aim = Self::AIM * self.most as f64;
        match (fine, coarse) {
            (Some([a, many]), Some([b, few])) => {
                let share = (many / aim).ln() / (many / few.max(1.0)).ln();
                a * (b / a).powf(share.clamp(0.1, 0.9))
            }
            (Some([cell, count]), None) => cell * (count / aim).sqrt().max(step),
            (None, Some([cell, count])) => cell * (count / aim).sqrt().clamp(0.25, 1.0).min(1.0 / step),
            (None, None) => self.start,
        }
    }
}

/// What the facets about each corner say of the way out of the part there.
struct Outward {
    /// The sum of the facets' area vectors, doubled.
    sums: Vec<Vec3>,
    /// The sum of their areas, doubled.
    areas: Vec<f64>,
}

impl Outward {
    fn of(mesh: &TriangleMesh) -> Self {
        let (mut sums, mut areas) = (vec![[0.0; 3]; mesh.vertices.len()], vec![0.0; mesh.vertices.len()]);
        for (facet, corners) in mesh.triangles.iter().enumerate() {
            let vector = mesh.area_vector(facet);
            for v in corners.map(|v| v as usize) {
                sums[v] = add(sums[v], vector);
                areas[v] += norm(vector);
            }
        }
        Outward { sums, areas }
    }

    /// The axis and side that each corner faces most, 0 to 5.
    fn facing(&self) -> Vec<u8> {
        // Faces and chamfers halfway between two axes face one of them all over.
        let side = |n: &Vec3| {
            let weight = [n[0].abs(), 1.07 * n[1].abs(), 1.15 * n[2].abs()];
            let axis = (0..3).max_by(|&i, &j| weight[i].total_cmp(&weight[j])).unwrap_or(0);
            2 * axis as u8 + u8::from(n[axis] < 0.0)
        };
        self.sums.par_iter().map(side).collect()
    }

    /// How sharp the surface is at a corner: 0 where it is flat, 0.29 on an edge of a box, 0.42 at its corner; less than 0 where no facet
    /// has an area.
    fn sharpness(&self, vertex: usize) -> f64 {
        let area = self.areas[vertex];
        if area > 0.0 { (1.0 - norm(self.sums[vertex]) / area).max(0.0) } else { BARE }
    }
}

/// Sharpness up to which a cell holds no crease: two faces that meet at 23°.
const SMOOTH: f64 = 0.02;
/// The sharpness of a corner without surface; it stands for others of its kind only.
const BARE: f64 = -1.0;
/// Share of the greatest sharpness in a cell from which corners are as sharp: a box's edge is less than its corner.
const AS_SHARP: f64 = 0.8;

/// The place of each cluster: the mean of its corners, where there are creases that corner of the sharpest which is nearest to their mean,
/// the first of equals.
fn places(mesh: &TriangleMesh, of_vertex: &[u32], clusters: usize, outward: &Outward) -> Vec<Vec3> {
    let sharpness: Vec<f64> = (0..of_vertex.len()).into_par_iter().map(|v| outward.sharpness(v)).collect();
    let mut sharpest = vec![BARE; clusters];
    for (&cluster, &sharp) in of_vertex.iter().zip(&sharpness) {
        let sharpest = &mut sharpest[cluster as usize];
        *sharpest = sharpest.max(sharp);
    }
    let creased = |cluster: u32| sharpest[cluster as usize] > SMOOTH;
    let counts = |&(v, &cluster): &(usize, &u32)| {
        let sharpest = sharpest[cluster as usize];
        sharpness[v] >= if creased(cluster) { AS_SHARP * sharpest } else { sharpest.min(0.0) }
    };
    let mut sums = vec![([0.0; 3], 0u32); clusters];
    for (v, &cluster) in of_vertex.iter().enumerate().filter(counts) {
        let (sum, count) = &mut sums[cluster as usize];
        (*sum, *count) = (add(*sum, mesh.vertices[v]), *count + 1);
    }
    let means: Vec<Vec3> = sums.into_iter().map(|(sum, count)| sum.map(|x| x / f64::from(count))).collect();
    let mut nearest = vec![(f64::INFINITY, [0.0; 3]); clusters];
    for (v, &cluster) in of_vertex.iter().enumerate().filter(|c| creased(*c.1)).filter(counts) {
        let (p, best) = (mesh.vertices[v], &mut nearest[cluster as usize]);
        let far = distance(p, means[cluster as usize]);
        if far < best.0 {
            *best = (far, p);
        }
    }
    let place = |((far, p), mean): ((f64, Vec3), Vec3)| if far.is_finite() { p } else { mean };
    nearest.into_iter().zip(means).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::super::generate::{cuboid, revolved};
    use super::super::vector::{dot, scale};
    use super::*;

    /// A mesh with every facet cut in four, and so again, `times` times.
    fn quartered(mesh: TriangleMesh, times: usize) -> TriangleMesh {
        (0..times).fold(mesh, |mesh, _| {
            let middle = |p: Vec3, q: Vec3| scale(add(p, q), 0.5);
            let four = |f| {
                let [a, b, c] = mesh.corners(f);
                let [d, e, g] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, d, g], [d, b, e], [g, e, c], [d, e, g]]
            };
            TriangleMesh::weld((0..mesh.triangles.len()).flat_map(four))
        })
    }

    /// A ball of radius 10.
    fn ball(sides: usize) -> TriangleMesh {
        let angle = |k: usize| std::f64::consts::PI * k as f64 / sides as f64;
        let arc: Vec<[f64; 2]> = (1..sides).map(|k| [10.0 * angle(k).sin(), -10.0 * angle(k).cos()]).collect();
        let outline: Vec<[f64; 2]> = [[0.0, -10.0]].into_iter().chain(arc).chain([[0.0, 10.0]]).collect();
        revolved(&outline, 2 * sides)
    }

    /// Uses of each edge one way less those the other way.
    fn balance(mesh: &TriangleMesh) -> FxHashMap<[u32; 2], i32> {
        let mut uses = FxHashMap::default();
        for &[a, b, c] in &mesh.triangles {
            for [p, q] in [[a, b], [b, c], [c, a]] {
                *uses.entry([p.min(q), p.max(q)]).or_insert(0) += if p < q { 1 } else { -1 };
            }
        }
        uses
    }

    fn parts() -> Vec<TriangleMesh> {
        let pin = cuboid([9.0, 9.0, 10.0], [9.05, 9.05, 30.0]);
        vec![
            ball(60),
            quartered(cuboid([0.0; 3], [20.0, 20.0, 20.0]), 5),
            quartered(cuboid([0.0; 3], [20.0, 0.01, 20.0]), 5),
            quartered(cuboid([0.0; 3], [20.0, 20.0, 10.0]).joined(&pin), 5),
        ]
    }

    #[test]
    fn what_has_few_facets_has_no_copy() {
        let ball = ball(20);
        assert!(Coarser::of(&ball, ball.triangles.len()).is_none());
        assert!(Coarser::of(&ball, ball.triangles.len() - 1).is_some());
    }

    #[test]
    fn a_copy_is_closed_and_has_nearly_as_many_facets_as_it_may() {
        for mesh in parts() {
            assert!(balance(&mesh).values().all(|uses| *uses == 0));
            for most in [mesh.triangles.len() - 1, 4000, 2000] {
                let copy = Coarser::of(&mesh, most).unwrap();
                assert!(balance(&copy.mesh).values().all(|uses| *uses == 0));
                let count = copy.mesh.triangles.len();
                assert!(count <= most && 2 * count > most, "{count} of {most}");
            }
        }
    }

    #[test]
    fn facets_keep_their_numbers_and_corners_move_no_farther_than_is_said() {
        for mesh in parts() {
            let copy = Coarser::of(&mesh, 3000).unwrap();
            assert_eq!(copy.facets.len(), copy.mesh.triangles.len());
            assert!(copy.facets.is_sorted_by(|a, b| a < b));
            let mut far = 0.0f64;
            for (at, &facet) in copy.facets.iter().enumerate() {
                let pairs = copy.mesh.corners(at).into_iter().zip(mesh.corners(facet));
                far = pairs.map(|(p, q)| distance(p, q)).fold(far, f64::max);
            }
            assert!(far > 0.0 && far <= copy.moved_mm);
            // With three facets a cell's side of surface the cell is not much larger than this, and no corner leaves its cell.
            let cell = (mesh.area() / (0.4 * 3000.0)).sqrt();
            assert!(copy.moved_mm < 3f64.sqrt() * cell, "{} of {cell}", copy.moved_mm);
        }
    }

    /// The area of what is seen of a mesh from above an axis.
    fn seen(mesh: &TriangleMesh, axis: usize) -> f64 {
        (0..mesh.triangles.len()).map(|f| 0.5 * mesh.area_vector(f)[axis].max(0.0)).sum()
    }

    #[test]
    fn edges_stay_sharp_and_what_is_thinner_than_a_cell_stays() {
        // A cell is about 0.7 mm: the rim of the plate of 20 × 20 mm, 0.01 mm thick, may be a bevel over one, half of 80 × 0.7 of 400 mm².
        for (mesh, kept) in parts().iter().zip([0.98, 0.9999, 0.93, 0.9999]) {
            let copy = Coarser::of(mesh, 3000).unwrap();
            let share = copy.mesh.signed_volume() / mesh.signed_volume();
            assert!((kept..1.001).contains(&share), "{share} of {} facets, {} mm", copy.facets.len(), copy.moved_mm);
            let turned = |(at, f): (usize, &usize)| dot(copy.mesh.area_vector(at), mesh.area_vector(*f)) < 0.0;
            let turned = copy.facets.iter().enumerate().filter(|f| turned(*f)).count();
            assert!(50 * turned < copy.facets.len(), "{turned} facets face the other way");
        }
        // Boxes reach as far as they did, and the plate's outline is whole.
        for mesh in &parts()[1..] {
            assert_eq!(Coarser::of(mesh, 3000).unwrap().mesh.bounds(), mesh.bounds());
        }
        let plate = Coarser::of(&parts()[2], 3000).unwrap().mesh;
        assert!((seen(&plate, 1) / 400.0 - 1.0).abs() < 1e-9, "{} mm²", seen(&plate, 1));
        // The pin on the block is less than a tenth of a cell thick.
        let copy = Coarser::of(&parts()[3], 3000).unwrap();
        let area =
            |f: usize| if copy.mesh.corners(f).iter().all(|p| p[2] > 10.5) { copy.mesh.facet_area(f) } else { 0.0 };
        let of_pin: f64 = (0..copy.facets.len()).map(area).sum();
        assert!((3.0..4.1).contains(&of_pin), "{of_pin} mm²");
    }

    #[test]
    fn the_number_of_threads_changes_nothing_and_sides_fall_together_where_they_are_too_many() {
        let mesh = ball(40);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Coarser::of(&mesh, 1000).unwrap().mesh)
        };
        assert_eq!(with(1), with(3));
        // Eight facets of octahedra about one place each have three sides however large the cell.
        let tip = |axis: usize, side: f64| [0, 1, 2].map(|a| if a == axis { side } else { 0.0 });
        let octant = |k: usize| {
            let side = |axis: usize| if k >> axis & 1 == 0 { 1.0 } else { -1.0 };
            let [x, y, z] = [0, 1, 2].map(|axis| tip(axis, side(axis)));
            if k.count_ones().is_multiple_of(2) { [x, y, z] } else { [x, z, y] }
        };
        let octahedron = TriangleMesh::weld((0..8).map(octant));
        let many = (0..200).fold(TriangleMesh::default(), |all, _| all.joined(&octahedron));
        let copy = Coarser::of(&many, 100).unwrap();
        assert!(copy.facets.len() <= 100 && balance(&copy.mesh).values().all(|uses| *uses == 0));
        // Facets without extent, and corners that no facet uses, are no trouble.
        let dots = TriangleMesh { vertices: vec![[1.0; 3], [9.0; 3]], triangles: vec![[0; 3]; 50] };
        assert!(Coarser::of(&dots, 10).unwrap().facets.is_empty());
    }
}
