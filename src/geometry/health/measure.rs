//! The measuring of a mesh's health.

use super::bodies::{Body, NO_LABEL};
use super::boxes::grown;
use super::nesting;
use super::shells::{self, Shell};
use crate::geometry::edges::{Edge, EdgeTable, is_collapsed};
use crate::geometry::vector::{Vec3, along, distance, norm, scale, sub};
use crate::geometry::{DisjointSets, TriangleMesh};

/// A facet lower than this share of the longest side of the mesh has no area: far below the step of f32.
const FLAT: f64 = 1e-10;

/// How often something is wrong, and where it is worst.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Fault {
    /// How often.
    pub count: u64,
    /// The worst place, in the frame of the mesh.
    pub at_mm: Option<Vec3>,
}

/// A connected rim of open edges; rims that touch at a vertex are one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hole {
    /// Number of open edges.
    pub edges: u64,
    /// Length of the rim, mm.
    pub length_mm: f64,
    /// Mean of the rim along its length.
    pub at_mm: Vec3,
    /// Least and greatest corner of the rim.
    pub box_mm: [Vec3; 2],
}

/// What is wrong with a mesh as the boundary of a solid, and what it bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Health {
    /// Edges of one facet; the place is the middle of the largest hole.
    pub open_edges: Fault,
    /// Number of connected rims of open edges.
    pub holes: u64,
    /// The rim of greatest length.
    pub largest_hole: Option<Hole>,
    /// Edges of more than two facets; the place is that of most facets.
    pub non_manifold_edges: Fault,
    /// Edges of two facets that run the same way; the place is the longest.
    pub miswound_edges: Fault,
    /// Edges, of any number of facets, along which more run one way than the other.
    pub unbalanced_edges: u64,
    /// Facets on the same three vertices as an earlier one, either way round; the place is the largest.
    pub duplicate_facets: Fault,
    /// Area of those facets, mm².
    pub duplicate_mm2: f64,
    /// Facets without area: collapsed, or three corners in a line; the place is the longest.
    pub zero_area_facets: Fault,
    /// All shells are wound inside out.
    pub inverted: bool,
    /// The connected pieces, in order of their first facets.
    pub shells: Vec<Shell>,
    /// The pieces of material, in order of their first facets.
    pub bodies: Vec<Body>,
    /// Shell of every facet; [`NO_LABEL`] for collapsed facets that hang on nothing.
    pub facet_shell: Vec<u32>,
    /// Body of every facet; [`NO_LABEL`] for ghosts and loose collapsed facets.
    pub facet_body: Vec<u32>,
    /// Least and greatest corner, `None` without facets.
    pub box_mm: Option<[Vec3; 2]>,
}

impl Health {
    /// The health of a welded mesh.
    ///
    /// Facets with two equal corners count as zero-area and otherwise as absent; facets whose three corners
    /// lie in a line stay part of the surface, because they close it.
    ///
    /// # Cost
    /// O(facets) for edges and shells; O(facets · log facets) more if one shell may lie in another.
    ///
    /// # Limits
    /// Facets that cross each other, or lie on each other in part, are not looked for: see [`super::meetings()`].
    pub fn of(mesh: &TriangleMesh) -> Self {
        let table = EdgeTable::of(mesh);
        let box_mm = mesh.bounds().map(|(lo, hi)| [lo, hi]);
        let extent = box_mm.map_or(0.0, |[lo, hi]| sub(hi, lo).into_iter().fold(0.0, f64::max));
        let edges = EdgeFaults::of(mesh, &table);
        let (holes, largest_hole) = holes(mesh, &table, edges.open.count);
        let (mut shells, facet_shell) = shells::shells(mesh, &table);
        let (bodies, inverted) = nesting::nest(mesh, &mut shells, &facet_shell, extent, edges.miswound.count);
        let body_of = |s: &u32| shells.get(*s as usize).map_or(NO_LABEL, |shell| shell.body);
        Health {
            open_edges: Fault { at_mm: largest_hole.map(|h| h.at_mm), ..edges.open },
            holes,
            largest_hole,
            non_manifold_edges: edges.non_manifold,
            miswound_edges: edges.miswound,
            unbalanced_edges: edges.unbalanced,
            duplicate_facets: edges.duplicates,
            duplicate_mm2: edges.duplicate_mm2,
            zero_area_facets: zero_area(mesh, extent),
            inverted,
            facet_body: facet_shell.iter().map(body_of).collect(),
            shells,
            bodies,
            facet_shell,
            box_mm,
        }
    }

    /// Whether the facets form a cycle that encloses volume: along every edge as many run one way as the
    /// other, and some shell is more than a ghost.
    ///
    /// Then the winding number is an integer everywhere off the surface. Zero-area facets, opposite
    /// duplicates and edges of four or more balanced facets do not hinder it; a facet doubled the same way
    /// round does. An inside-out mesh is a solid, too: see [`Health::inverted`].
    pub fn is_solid(&self) -> bool {
        self.unbalanced_edges == 0 && !self.bodies.is_empty()
    }

    /// Whether an edge is open, has more than two facets or facets that disagree, or a facet repeats another.
    pub fn is_faulty(&self) -> bool {
        let faults = [self.open_edges, self.non_manifold_edges, self.miswound_edges, self.duplicate_facets];
        faults.iter().any(|f| f.count > 0)
    }

    /// Whether every edge has exactly two facets, running opposite ways: *watertight* in the strict sense.
    pub fn is_watertight(&self) -> bool {
        let faults = [self.open_edges, self.non_manifold_edges, self.miswound_edges];
        !self.shells.is_empty() && faults.iter().all(|f| f.count == 0)
    }

    /// Volume of all bodies less their cavities, mm³; bodies that overlap count twice.
    pub fn volume_mm3(&self) -> f64 {
        self.bodies.iter().map(|b| b.volume_mm3).sum()
    }

    /// Number of shells with a role.
    pub fn count_of(&self, role: super::Role) -> u64 {
        self.shells.iter().filter(|s| s.role == role).count() as u64
    }
}

/// Counts over the edges, with the worst of each kind.
#[derive(Default)]
struct EdgeFaults {
    open: Fault,
    non_manifold: Fault,
    miswound: Fault,
    duplicates: Fault,
    duplicate_mm2: f64,
    unbalanced: u64,
}

impl EdgeFaults {
    fn of(mesh: &TriangleMesh, table: &EdgeTable) -> Self {
        let mut found = EdgeFaults::default();
        let (mut most, mut longest, mut largest) = ((0, 0.0), -1.0, -1.0);
        for edge in table.edges() {
            found.unbalanced += u64::from(edge.imbalance() != 0);
            let [a, b] = edge.ends.map(|v| mesh.vertices[v as usize]);
            let middle = scale([a[0] + b[0], a[1] + b[1], a[2] + b[2]], 0.5);
            match edge.sides.len() {
                1 => found.open.count += 1,
                2 if edge.is_miswound() => {
                    found.miswound.count += 1;
                    replace_if_worse(&mut longest, distance(a, b), &mut found.miswound.at_mm, middle);
                }
                2 => {}
                n => {
                    found.non_manifold.count += 1;
                    replace_if_worse(&mut most, (n, distance(a, b)), &mut found.non_manifold.at_mm, middle);
                }
            }
            for facet in repeated(mesh, &edge) {
                found.duplicates.count += 1;
                let area = mesh.facet_area(facet);
                found.duplicate_mm2 += area;
                replace_if_worse(&mut largest, area, &mut found.duplicates.at_mm, mesh.centroid(facet));
            }
        }
        found
    }
}

fn replace_if_worse<T: PartialOrd>(worst: &mut T, candidate: T, at: &mut Option<Vec3>, place: Vec3) {
    if candidate > *worst {
        *worst = candidate;
        *at = Some(place);
    }
}

/// Facets that repeat an earlier one, found at the edge of their two lowest vertices.
fn repeated(mesh: &TriangleMesh, edge: &Edge<'_>) -> Vec<usize> {
    let [low, high] = edge.ends;
    let third = |f: usize| mesh.triangles[f].into_iter().find(|&v| v != low && v != high).unwrap_or(low);
    // The commonest edge allocates nothing.
    if let [(_, a), (_, b)] = edge.sides
        && third(a.facet()) != third(b.facet())
    {
        return Vec::new();
    }
    let mut thirds: Vec<(u32, usize)> =
        edge.sides.iter().map(|s| s.1.facet()).map(|f| (third(f), f)).filter(|t| t.0 > high).collect();
    thirds.sort_unstable();
    thirds.windows(2).filter(|w| w[0].0 == w[1].0).map(|w| w[1].1).collect()
}

/// The rims of open edges: how many, and the longest.
fn holes(mesh: &TriangleMesh, table: &EdgeTable, open_edges: u64) -> (u64, Option<Hole>) {
    if open_edges == 0 {
        return (0, None);
    }
    let mut sets = DisjointSets::new(mesh.vertices.len());
    let open = || table.edges().filter(|e| e.sides.len() == 1);
    for e in open() {
        sets.join(e.ends[0], e.ends[1]);
    }
    let mut rims: rustc_hash::FxHashMap<u32, Hole> = Default::default();
    for edge in open() {
        let [a, b] = edge.ends.map(|v| mesh.vertices[v as usize]);
        let length = distance(a, b);
        let rim = rims.entry(sets.root(edge.ends[0])).or_insert(Hole {
            edges: 0,
            length_mm: 0.0,
            at_mm: [0.0; 3],
            box_mm: [a, a],
        });
        rim.edges += 1;
        rim.length_mm += length;
        // The sum of middles times lengths; divided by the length at the end.
        rim.at_mm = along(along(rim.at_mm, a, 0.5 * length), b, 0.5 * length);
        rim.box_mm = [a, b].into_iter().fold(rim.box_mm, grown);
    }
    // By length, then by the lowest vertex, so that the order of the map does not matter.
    let largest = rims.iter().max_by(|a, b| a.1.length_mm.total_cmp(&b.1.length_mm).then_with(|| b.0.cmp(a.0)));
    let largest = largest.map(|(_, rim)| Hole {
        at_mm: if rim.length_mm > 0.0 { scale(rim.at_mm, 1.0 / rim.length_mm) } else { rim.box_mm[0] },
        ..*rim
    });
    (rims.len() as u64, largest)
}

/// Facets without area, the longest as their place.
fn zero_area(mesh: &TriangleMesh, extent: f64) -> Fault {
    let mut found = Fault::default();
    let mut longest = -1.0;
    for f in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(f);
        let side = distance(a, b).max(distance(b, c)).max(distance(c, a));
        if is_collapsed(mesh.triangles[f]) || norm(mesh.area_vector(f)) <= FLAT * extent * side {
            found.count += 1;
            replace_if_worse(&mut longest, side, &mut found.at_mm, mesh.centroid(f));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The unit cube with its origin at a corner: facets 0 and 1 are its lower side.
    fn cube() -> TriangleMesh {
        let corner = |i: usize| [0, 1, 2].map(|a| (i >> a & 1) as f64);
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        TriangleMesh::weld(quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|t| t.map(corner)))
    }

    #[test]
    fn a_cube_is_sound() {
        let h = Health::of(&cube());
        assert!(h.is_solid() && h.is_watertight());
        assert_eq!((h.bodies.len(), h.holes, h.volume_mm3(), h.shells[0].area_mm2), (1, 0, 1.0, 6.0));
        // A far origin costs no digits.
        let far = cube().transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [1e6, -1e6, 1e6]);
        assert_eq!(Health::of(&far).volume_mm3(), 1.0);
    }

    #[test]
    fn a_missing_side_is_one_hole_with_its_rim() {
        let mut mesh = cube();
        mesh.triangles.drain(..2);
        let h = Health::of(&mesh);
        let hole = h.largest_hole.unwrap();
        assert_eq!((h.open_edges.count, h.holes, hole.edges, hole.length_mm), (4, 1, 4, 4.0));
        assert_eq!((hole.at_mm, hole.box_mm), ([0.5, 0.5, 0.0], [[0.0; 3], [1.0, 1.0, 0.0]]));
        assert!(!h.is_solid() && h.open_edges.at_mm == Some(hole.at_mm));
    }

    #[test]
    fn facets_that_are_turned_doubled_or_flat_are_counted() {
        let mut turned = cube();
        turned.triangles[0].swap(0, 1);
        let h = Health::of(&turned);
        assert_eq!((h.miswound_edges.count, h.is_solid(), h.shells.len()), (3, false, 1));

        let mut doubled = cube();
        doubled.triangles.push(doubled.triangles[0]);
        let h = Health::of(&doubled);
        assert_eq!((h.duplicate_facets.count, h.non_manifold_edges.count, h.is_solid()), (1, 3, false));
        assert_eq!(h.duplicate_mm2, 0.5);

        let mut flat = cube();
        let t = flat.triangles[0];
        flat.triangles.push([t[0], t[1], t[1]]);
        let h = Health::of(&flat);
        assert_eq!((h.zero_area_facets.count, h.open_edges.count, h.is_watertight()), (1, 0, true));
        assert_eq!(h.facet_shell[12], 0);
    }

    #[test]
    fn a_sliver_that_closes_a_split_edge_is_part_of_the_surface() {
        // Edge 0-1 of facet 0 is split on one side only; the sliver (0, 1, new) closes the gap.
        let mut mesh = cube();
        let [a, b, c] = mesh.triangles[0];
        let middle = [0, 1, 2].map(|i| 0.5 * (mesh.vertices[a as usize][i] + mesh.vertices[b as usize][i]));
        mesh.vertices.push(middle);
        let m = mesh.vertices.len() as u32 - 1;
        mesh.triangles[0] = [a, m, c];
        mesh.triangles.extend([[m, b, c], [a, b, m]]);
        let h = Health::of(&mesh);
        assert_eq!((h.zero_area_facets.count, h.open_edges.count, h.is_watertight()), (1, 0, true));
    }

    #[test]
    fn a_moebius_band_and_a_lone_facet_end_in_words() {
        let ring: Vec<Vec3> = (0..12)
            .map(|i| {
                let t = f64::from(i) * std::f64::consts::PI / 6.0;
                let w = if i % 2 == 0 { 0.3 } else { -0.3 };
                [(1.0 + w * (t / 2.0).cos()) * t.cos(), (1.0 + w * (t / 2.0).cos()) * t.sin(), w * (t / 2.0).sin()]
            })
            .collect();
        let band =
            TriangleMesh { vertices: ring, triangles: (0..12).map(|i| [i, (i + 1) % 12, (i + 2) % 12]).collect() };
        let h = Health::of(&band);
        assert!(!h.is_solid() && h.open_edges.count > 0 && h.shells.len() == 1);
        let lone = TriangleMesh::weld([[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
        assert!(!Health::of(&lone).is_solid());
        assert!(!Health::of(&TriangleMesh::default()).is_solid());
    }

    #[test]
    fn notices_say_what_was_counted() {
        let mut mesh = cube();
        mesh.triangles.drain(..2);
        let notices = Health::of(&mesh.scaled(0.01)).notices();
        let codes: Vec<&str> = notices.iter().map(|n| n.code.as_str()).collect();
        assert_eq!(codes, ["open-edges"]);
        assert!(notices[0].message.contains("4 open edges around one hole"), "{}", notices[0].message);
        let guess = |factor: f64| Health::of(&cube().scaled(factor)).units_guess().map(|n| n.message);
        assert!(guess(0.047).unwrap().contains("--units m"));
        assert!(guess(1.9).unwrap().contains("--units in"));
        assert!(guess(150_000.0).unwrap().contains("--units um"));
        assert_eq!((guess(2.0), guess(1000.0)), (None, None));
    }
}
