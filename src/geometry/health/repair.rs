//! Mending what can be mended without inventing surface.

use super::{Health, Role};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, norm2, sub};
use crate::notice::{Notice, number_of};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// The words for one and for several facets that were turned.
pub const TURNED: [&str; 2] =
    ["facet was turned to agree with its neighbours", "facets were turned to agree with their neighbours"];

/// Whether a mesh is mended before it is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Repair {
    /// Judged as it was read.
    #[default]
    Leave,
    /// What can be mended without inventing surface is mended, said and handed back.
    Mend,
}

/// A mended mesh and what was done to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Repaired {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// One notice, `repaired`, for each kind of change.
    pub notices: Vec<Notice>,
}

impl Repaired {
    /// What was done, or that there was nothing to do.
    pub fn said(&self) -> Vec<Notice> {
        if !self.notices.is_empty() {
            return self.notices.clone();
        }
        // Shells inside others are no faults, nor is what is passed over.
        let health = Health::of(&self.mesh);
        let left = [health.open_edges, health.non_manifold_edges, health.miswound_edges, health.duplicate_facets];
        let text = if left.iter().all(|fault| fault.count == 0) {
            "nothing was to be repaired"
        } else {
            "nothing could be repaired without inventing surface"
        };
        vec![Notice::new("repaired", text)]
    }
}

/// How far apart vertices of a crack may lie to be joined, in the unit of the mesh: 10⁻⁵ of the longest side, a dozen steps of
/// float32 coordinates, and at most 10⁻⁴.
pub fn repair_tolerance(mesh: &TriangleMesh) -> f64 {
    let longest = mesh.longest_side();
    (1e-5 * longest).min(1e-4)
}

/// The mesh with cracks closed, doubled walls removed and facets wound alike.
///
/// In this order: vertices on open edges that lie within `tolerance_mm` of each other become one; facets
/// that collapse are dropped; of facets on the same three vertices one remains, or none if as many run one way as
/// the other (a wall between two coincident bodies); facets are turned to agree with their neighbours; shells
/// are turned so that bodies face outward and cavities inward.
///
/// # Cost
/// O(facets) apart from sorting.
///
/// # Limits
/// Holes are not filled, crossings are not cut: no surface is made up. Vertices that are not on an open edge never move.
///
/// ```
/// use amcheck::geometry::{TriangleMesh, health};
/// // A tetrahedron whose last facet missed its corner by rounding.
/// let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0 + 1e-7]];
/// let cracked = TriangleMesh::weld([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 4, 2]].map(|t: [usize; 3]| t.map(|v| p[v])));
/// let mended = health::repaired(&cracked, 1e-6);
/// assert_eq!(mended.mesh.vertices.len(), 4);
/// ```
pub fn repaired(mesh: &TriangleMesh, tolerance_mm: f64) -> Repaired {
    let mut notices = Vec::new();
    let mut say = |count: usize, words: [&str; 2]| {
        if count > 0 {
            notices.push(Notice::new("repaired", number_of(count as u64, words)).counted(count as u64));
        }
    };
    let mut mesh = mesh.clone();
    say(
        close_cracks(&mut mesh, tolerance_mm),
        ["vertex on an open edge was joined with a near one", "vertices on open edges were joined with near ones"],
    );
    let before = mesh.triangles.len();
    mesh.triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
    say(before - mesh.triangles.len(), ["collapsed facet was dropped", "collapsed facets were dropped"]);
    say(drop_doubles(&mut mesh), ["doubled facet was dropped", "doubled facets were dropped"]);
    say(agree(&mut mesh), TURNED);
    let mesh = without_idle_vertices(&mesh);
    let health = Health::of(&mesh);
    let turned = health.shells.iter().filter(|s| s.role == Role::Inverted || health.inverted).count();
    say(turned, ["shell was turned outward", "shells were turned outward"]);
    Repaired { mesh: health.outward(&mesh).into_owned(), notices }
}

/// A mesh that only cracks keep from being a solid, with the vertices on both sides of them as one, and how many were joined with others;
/// `None` of every other mesh. No vertex moves farther than `tolerance_mm`.
///
/// # Cost
/// O(facets), and nothing where the edges are known to be closed.
pub fn without_cracks(mesh: &TriangleMesh, health: &Health, tolerance_mm: f64) -> Option<(TriangleMesh, usize)> {
    // No piece of fewer than four facets closes: where most are such, they lie about.
    let loose = health.shells.iter().filter(|shell| !shell.closed && shell.facets < 4).count();
    if health.open_edges.count == 0 || 2 * loose > health.shells.len() {
        return None;
    }
    let mut closed = mesh.clone();
    let joined = close_cracks(&mut closed, tolerance_mm);
    if joined == 0 {
        return None;
    }
    closed.triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
    let closed = without_idle_vertices(&closed);
    let health = Health::of(&closed);
    (health.is_solid() && health.open_edges.count == 0).then_some((closed, joined))
}

/// The mesh with facets turned so that neighbours over edges of two facets agree, and how many were turned: of each connected piece
/// the smaller part.
///
/// # Cost
/// O(facets).
pub fn agreed(mesh: &TriangleMesh) -> (TriangleMesh, usize) {
    let mut mesh = mesh.clone();
    let turned = agree(&mut mesh);
    (mesh, turned)
}

/// Directed edges without a partner the other way.
fn open_edges(mesh: &TriangleMesh) -> Vec<[u32; 2]> {
    let mut uses: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let edges = || mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).filter(|[a, b]| a != b);
    edges().for_each(|[a, b]| *uses.entry([a.min(b), a.max(b)]).or_default() += 1);
    edges().filter(|&[a, b]| uses.get(&[a.min(b), a.max(b)]) == Some(&1)).collect()
}

/// Joins near vertices of open edges; how many were joined with another.
///
/// Each goes to the first before it within the tolerance, so that the result depends on the order of the
/// file alone.
fn close_cracks(mesh: &mut TriangleMesh, tolerance: f64) -> usize {
    let mut rim: Vec<u32> = open_edges(mesh).into_iter().flatten().collect();
    rim.sort_unstable();
    rim.dedup();
    if rim.is_empty() || !(tolerance > 0.0 && tolerance.is_finite()) {
        return 0;
    }
    let cell = |p: Vec3| p.map(|x| (x / tolerance).floor());
    let key = |c: Vec3| c.map(f64::to_bits);
    let mut cells: FxHashMap<[u64; 3], Vec<u32>> = FxHashMap::default();
    let mut goes_to: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    let mut joined = 0;
    for v in rim {
        let p = mesh.vertices[v as usize];
        let near = neighbours(cell(p)).find_map(|c| {
            let known = cells.get(&key(c))?;
            known.iter().copied().find(|&u| norm2(sub(mesh.vertices[u as usize], p)) <= tolerance * tolerance)
        });
        match near {
            Some(u) => {
                goes_to[v as usize] = u;
                joined += 1;
            }
            None => cells.entry(key(cell(p))).or_default().push(v),
        }
    }
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = goes_to[*v as usize]);
    joined
}

/// A cell and the 26 around it; 0.0 is added so that both zeros have one key.
fn neighbours(cell: Vec3) -> impl Iterator<Item = Vec3> {
    (0..27).map(move |i| [0, 1, 2].map(|a| cell[a] + f64::from(i / 3i32.pow(a as u32) % 3 - 1) + 0.0))
}

/// Keeps one of the facets on the same three vertices, or none where they cancel; how many were dropped.
fn drop_doubles(mesh: &mut TriangleMesh) -> usize {
    let mut sums: FxHashMap<[u32; 3], i32> = FxHashMap::default();
    for &t in &mesh.triangles {
        let (key, way) = unordered(t);
        *sums.entry(key).or_default() += way;
    }
    let before = mesh.triangles.len();
    mesh.triangles.retain(|&t| {
        let (key, way) = unordered(t);
        let keeps = sums.get(&key).is_some_and(|sum| sum.signum() == way);
        if keeps {
            // The others of this kind find nothing left.
            sums.insert(key, 0);
        }
        keeps
    });
    before - mesh.triangles.len()
}

/// The vertices of a facet in rising order, and +1 or −1 for the way it runs round them.
fn unordered([a, b, c]: [u32; 3]) -> ([u32; 3], i32) {
    let (from, to) = match a.min(b).min(c) {
        low if low == a => (b, c),
        low if low == b => (c, a),
        _ => (a, b),
    };
    let mut key = [a, b, c];
    key.sort_unstable();
    (key, if from < to { 1 } else { -1 })
}

/// Turns facets so that neighbours over edges of two facets agree; how many were turned.
///
/// Of each connected piece the smaller part is turned; a piece with one side only keeps its conflicts.
fn agree(mesh: &mut TriangleMesh) -> usize {
    let across = neighbours_across(mesh);
    let mut turned: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    let mut count = 0;
    for start in 0..mesh.triangles.len() {
        if turned[start].is_some() {
            continue;
        }
        turned[start] = Some(false);
        let mut piece = vec![start];
        let mut next = 0;
        while let Some(&f) = piece.get(next) {
            next += 1;
            let own = turned[f] == Some(true);
            for &(across, alike) in across[f].iter().flatten() {
                let across = across as usize;
                if turned[across].is_none() {
                    turned[across] = Some(own ^ alike);
                    piece.push(across);
                }
            }
        }
        let differ = piece.iter().filter(|&&f| turned[f] == Some(true)).count();
        let smaller_part = Some(2 * differ <= piece.len());
        for f in piece.into_iter().filter(|&f| turned[f] == smaller_part) {
            mesh.triangles[f].swap(1, 2);
            count += 1;
        }
    }
    count
}

/// The facet across each edge of every facet, and whether both run the same way along it; none where not two facets meet.
fn neighbours_across(mesh: &TriangleMesh) -> Vec<[Option<(u32, bool)>; 3]> {
    let of_facet = |f: usize| {
        let [a, b, c] = mesh.triangles[f];
        let side =
            move |e: usize, u: u32, v: u32| (u64::from(u.min(v)) << 32 | u64::from(u.max(v)), f as u32, e as u8, u < v);
        [side(0, a, b), side(1, b, c), side(2, c, a)]
    };
    let mut sides: Vec<(u64, u32, u8, bool)> =
        (0..mesh.triangles.len()).into_par_iter().flat_map_iter(of_facet).collect();
    sides.par_sort_unstable();
    let mut across = vec![[None; 3]; mesh.triangles.len()];
    for pair in sides.chunk_by(|a, b| a.0 == b.0) {
        if let &[(_, f, e, one), (_, g, d, other)] = pair {
            across[f as usize][usize::from(e)] = Some((g, one == other));
            across[g as usize][usize::from(d)] = Some((f, one == other));
        }
    }
    across
}

/// The mesh without vertices that no facet uses.
fn without_idle_vertices(mesh: &TriangleMesh) -> TriangleMesh {
    let mut new = vec![u32::MAX; mesh.vertices.len()];
    let mut vertices = Vec::new();
    let triangles = mesh
        .triangles
        .iter()
        .map(|t| {
            t.map(|v| {
                let to = &mut new[v as usize];
                if *to == u32::MAX {
                    *to = vertices.len() as u32;
                    vertices.push(mesh.vertices[v as usize]);
                }
                *to
            })
        })
        .collect();
    TriangleMesh { vertices, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(centre: Vec3, edge: f64) -> TriangleMesh {
        let corner = |i: usize| [0, 1, 2].map(|a| centre[a] + if i >> a & 1 == 1 { 0.5 * edge } else { -0.5 * edge });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        TriangleMesh::weld(quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|t| t.map(corner)))
    }

    #[test]
    fn a_sound_mesh_is_left_alone() {
        let mesh = cube([0.0; 3], 2.0).joined(&cube([0.0; 3], 1.0).flipped());
        let mended = repaired(&mesh, 1e-3);
        assert_eq!(mended.notices, []);
        // Vertices are numbered anew in order of use, facets stay.
        let corners = |m: &TriangleMesh| (0..m.triangles.len()).map(|f| m.corners(f)).collect::<Vec<_>>();
        assert_eq!(corners(&mended.mesh), corners(&mesh));
    }

    #[test]
    fn nothing_is_to_be_repaired_of_shells_within_others() {
        let said = |mesh: TriangleMesh| repaired(&mesh, 1e-3).said().into_iter().map(|n| n.message).collect::<Vec<_>>();
        // A body in the material of another, a cavity, and a box without one of its facets.
        let (around, within) = (cube([0.0; 3], 2.0), cube([0.0; 3], 1.0));
        for sound in [around.clone().joined(&within), around.clone().joined(&within.flipped())] {
            assert!(!Health::of(&sound).notices().is_empty());
            assert_eq!(said(sound), ["nothing was to be repaired"]);
        }
        let mut open = around;
        open.triangles.pop();
        assert_eq!(said(open), ["nothing could be repaired without inventing surface"]);
    }

    #[test]
    fn cracks_are_closed_across_cell_borders_and_within_the_tolerance_only() {
        // Every facet with corners of its own, moved by up to 4e-7 in no pattern.
        let sound = cube([0.0; 3], 2.0);
        let soup = (0..sound.triangles.len()).map(|f| {
            let shift = (f as f64 * 0.61803).fract() * 4e-7 - 2e-7;
            sound.corners(f).map(|p| p.map(|x| x + shift))
        });
        let cracked = TriangleMesh::weld(soup);
        assert!(Health::of(&cracked).open_edges.count > 0);
        let mended = repaired(&cracked, 1e-6);
        assert!(Health::of(&mended.mesh).is_watertight());
        assert_eq!((mended.mesh.vertices.len(), mended.mesh.triangles.len()), (8, 12));
        assert!(!Health::of(&repaired(&cracked, 1e-9).mesh).is_watertight());
    }

    #[test]
    fn doubled_walls_turned_facets_and_inverted_shells_are_put_right() {
        // Two cubes with one wall in common, which runs both ways.
        let pair = cube([0.0; 3], 2.0).joined(&cube([2.0, 0.0, 0.0], 2.0));
        let walled = TriangleMesh::weld((0..24).map(|f| pair.corners(f)));
        let mended = repaired(&walled, 1e-6);
        let health = Health::of(&mended.mesh);
        assert_eq!((mended.mesh.triangles.len(), health.bodies.len(), health.volume_mm3()), (20, 1, 16.0));
        assert!(health.is_watertight());

        let mut mixed = cube([0.0; 3], 2.0);
        [1, 4, 7].into_iter().for_each(|f: usize| mixed.triangles[f].swap(0, 1));
        mixed.triangles.push(mixed.triangles[0]);
        let mended = repaired(&mixed.joined(&cube([9.0, 0.0, 0.0], 2.0).flipped()), 1e-6);
        let health = Health::of(&mended.mesh);
        assert!(health.is_watertight() && !health.inverted);
        assert_eq!((health.volume_mm3(), health.count_of(Role::Inverted)), (16.0, 0));
        assert_eq!(mended.notices.len(), 3, "{:?}", mended.notices);
    }

    #[test]
    fn a_solid_but_for_cracks_is_closed_and_one_with_a_hole_is_not() {
        use crate::geometry::cuboid;
        use crate::geometry::vector::add;
        let mut random = crate::random::Lcg(5);
        let block = cuboid([0.0; 3], [10.0; 3]);
        let mut cracked = |from: usize| {
            TriangleMesh::weld((from..12).map(|f| block.corners(f).map(|p| add(p, random.point(-1e-5, 1e-5)))))
        };
        let closed = |mesh: &TriangleMesh| without_cracks(mesh, &Health::of(mesh), repair_tolerance(mesh));
        let (mesh, joined) = closed(&cracked(0)).expect("a solid");
        let health = Health::of(&mesh);
        assert_eq!((mesh.vertices.len(), joined, health.bodies.len(), health.open_edges.count), (8, 28, 1, 0));
        // No corner is off by more than √3 · 10⁻⁵, and the area is 600 mm².
        assert!((health.volume_mm3() - 1000.0).abs() < 0.011, "{}", health.volume_mm3());
        assert_eq!((closed(&cracked(1)), closed(&block)), (None, None));
    }
}
