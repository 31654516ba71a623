//! Places where a layer starts with nothing beneath.

use super::section::clip_below;
use crate::geometry::health::cracks;
use crate::geometry::vector::{Vec3, bounds, cross, sub};
use crate::geometry::{DisjointSets, TriangleMesh};
use rustc_hash::FxHashMap;

/// A piece of material that begins above the plate with nothing of its own beneath.
#[derive(Debug, Clone, PartialEq)]
pub struct Island {
    /// Its lowest point.
    pub lowest: Vec3,
    /// How far it rises before it joins material that began lower; infinite if it never does.
    pub rise_mm: f64,
    /// Area of its section one layer above the lowest point, mm².
    pub first_layer_area_mm2: f64,
    /// Box of its surface up to one layer above the lowest point.
    pub extent: (Vec3, Vec3),
    /// A facet at the lowest point.
    pub facet: u32,
    /// The facets of its first layer that look down, in increasing order.
    pub underside: Vec<u32>,
    /// All of its facets that look up, as far as it rises, in increasing order: it does not rest on these.
    pub own_floors: Vec<u32>,
}

/// The islands of a mesh that is closed but for cracks, lowest first; what starts up to `plate_z` stands on the plate.
///
/// Components of { z ≤ t } of the surface are born at local minima and merge at saddles as t grows. A minimum with
/// material above it (its normals point down) that is born more than `step` above `plate_z`, and rises by more than a layer
/// before it merges with one born lower, is an island: its first layer has nothing beneath. Heights that differ by no more than two `step` are
/// equal. All minima of a mesh lie at
/// vertices, so none is missed.
///
/// # Cost
/// O(V log V + E).
///
/// # Source
/// The merge tree of the height function; e.g. H. Carr, J. Snoeyink, U. Axen, *Computing contour trees in all dimensions*, 2003.
pub fn islands(mesh: &TriangleMesh, plate_z: f64, layer_mm: f64, step: f64) -> Vec<Island> {
    let (order, neighbours) = (by_height(mesh), neighbours(mesh));
    let mut found: Vec<Island> = sweep(mesh, &order, &neighbours)
        .into_iter()
        .filter(|b| b.rise > layer_mm + 2.0 * step && mesh.vertices[b.lowest as usize][2] > plate_z + step.max(1e-4))
        .filter_map(|b| first_layer(mesh, &b, &neighbours, layer_mm))
        .collect();
    found.sort_by(|a, b| a.lowest[2].total_cmp(&b.lowest[2]).then(a.facet.cmp(&b.facet)));
    found
}

/// Vertices that facets use, lowest first.
fn by_height(mesh: &TriangleMesh) -> Vec<u32> {
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    let mut order: Vec<u32> = (0..mesh.vertices.len() as u32).filter(|&v| used[v as usize]).collect();
    order.sort_by(|&a, &b| mesh.vertices[a as usize][2].total_cmp(&mesh.vertices[b as usize][2]).then(a.cmp(&b)));
    order
}

/// A component of the sublevel sets: where it was born and how far it rose before it merged.
struct Birth {
    lowest: u32,
    rise: f64,
    /// Every vertex of the component up to where it merged.
    vertices: Vec<u32>,
}

/// Vertices at the other ends of a vertex's edges and across its cracks, some of them more than once.
type Neighbours = FxHashMap<u32, Vec<u32>>;

fn neighbours(mesh: &TriangleMesh) -> Neighbours {
    let mut of = Neighbours::default();
    for t in &mesh.triangles {
        for e in 0..3 {
            of.entry(t[e]).or_default().push(t[(e + 1) % 3]);
            of.entry(t[(e + 1) % 3]).or_default().push(t[e]);
        }
    }
    // Sublevel sets on both sides of a crack meet where the upper of their lower ends is reached.
    for [a, b] in cracks(mesh).into_iter().map(|crack| crack.ends) {
        for (v, w) in a.into_iter().flat_map(|v| b.map(|w| (v, w))) {
            of.entry(v).or_default().push(w);
            of.entry(w).or_default().push(v);
        }
    }
    of
}

/// All components of the surface's sublevel sets.
fn sweep(mesh: &TriangleMesh, order: &[u32], neighbours: &Neighbours) -> Vec<Birth> {
    let z = |v: u32| mesh.vertices[v as usize][2];
    let mut rank = vec![u32::MAX; mesh.vertices.len()];
    order.iter().enumerate().for_each(|(i, &v)| rank[v as usize] = i as u32);
    let mut sets = DisjointSets::new(mesh.vertices.len());
    let mut members: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    let mut births = Vec::new();
    for &v in order {
        members.insert(v, vec![v]);
        for &n in neighbours.get(&v).map_or(&[][..], |n| n) {
            if rank[n as usize] > rank[v as usize] {
                continue;
            }
            // The root of a set is its lowest vertex, so the later of two roots dies.
            let (a, b) = (sets.root(v), sets.root(n));
            if a == b {
                continue;
            }
            let (old, young) = if rank[a as usize] < rank[b as usize] { (a, b) } else { (b, a) };
            let lost = members.remove(&young).unwrap_or_default();
            if z(v) > z(young) {
                births.push(Birth { lowest: young, rise: z(v) - z(young), vertices: lost.clone() });
            }
            sets.hang(young, old);
            merge(members.entry(old).or_default(), lost);
        }
    }
    births.extend(members.into_iter().map(|(lowest, vertices)| Birth { lowest, rise: f64::INFINITY, vertices }));
    births.sort_by_key(|b| rank[b.lowest as usize]);
    births
}

/// Appends the smaller list to the larger.
fn merge(into: &mut Vec<u32>, mut other: Vec<u32>) {
    if other.len() > into.len() {
        std::mem::swap(into, &mut other);
    }
    into.append(&mut other);
}

/// The section of a component one layer above its lowest point; `None` if void lies above it, as in the floor of a pit.
///
/// By the divergence theorem the section's area is −∫ n_z dA over the component's surface below it: over what hangs together there, for others
/// that begin as low may have joined it higher up.
fn first_layer(mesh: &TriangleMesh, birth: &Birth, neighbours: &Neighbours, layer_mm: f64) -> Option<Island> {
    let lowest = mesh.vertices[birth.lowest as usize];
    let top = lowest[2] + layer_mm;
    // Of the whole component, and of its first layer.
    let mut member = vec![[false; 2]; mesh.vertices.len()];
    birth.vertices.iter().for_each(|&v| member[v as usize][0] = true);
    let mut reached = vec![birth.lowest];
    while let Some(v) = reached.pop() {
        if mesh.vertices[v as usize][2] < top && !std::mem::replace(&mut member[v as usize][1], true) {
            reached.extend(neighbours.get(&v).into_iter().flatten());
        }
    }
    let mut area = 0.0;
    let mut facet = None;
    let (mut points, mut underside, mut own_floors) = (Vec::new(), Vec::new(), Vec::new());
    for (f, t) in mesh.triangles.iter().enumerate() {
        let up = mesh.area_vector(f)[2];
        if up > 0.0 && t.iter().any(|&v| member[v as usize][0]) {
            own_floors.push(f as u32);
        }
        if !t.iter().any(|&v| member[v as usize][1]) {
            continue;
        }
        if facet.is_none() && t.contains(&birth.lowest) {
            facet = Some(f as u32);
        }
        if up < 0.0 {
            underside.push(f as u32);
        }
        let below = clip_below(mesh.corners(f), top);
        for i in 1..below.len().saturating_sub(1) {
            area -= 0.5 * cross(sub(below[i], below[0]), sub(below[i + 1], below[0]))[2];
        }
        points.extend(below);
    }
    let extent = bounds(points)?;
    let (rise_mm, facet) = (birth.rise, facet?);
    (area > 0.0).then_some(Island { lowest, rise_mm, first_layer_area_mm2: area, extent, facet, underside, own_floors })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::union::united;
    use crate::geometry::vector::along;
    use crate::geometry::{Primitive, cuboid};
    use crate::units::Length;

    /// A plate on two legs of different length, as one outline in x–z swept along y.
    fn table(short_leg_foot: f64) -> TriangleMesh {
        let outline = [
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 8.0],
            [8.0, 8.0],
            [8.0, short_leg_foot],
            [10.0, short_leg_foot],
            [10.0, 10.0],
            [0.0, 10.0],
        ];
        let mut facets = Vec::new();
        let at = |i: usize, y: f64| [outline[i][0], y, outline[i][1]];
        for i in 0..8 {
            let j = (i + 1) % 8;
            facets.push([at(i, 0.0), at(j, 0.0), at(j, 3.0)]);
            facets.push([at(i, 0.0), at(j, 3.0), at(i, 3.0)]);
        }
        for [a, b, c] in [[0usize, 1, 2], [0, 2, 7], [2, 3, 6], [2, 6, 7], [3, 4, 5], [3, 5, 6]] {
            facets.push([at(a, 0.0), at(c, 0.0), at(b, 0.0)]);
            facets.push([at(a, 3.0), at(b, 3.0), at(c, 3.0)]);
        }
        let mesh = TriangleMesh::weld(facets);
        if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh }
    }

    #[test]
    fn a_leg_that_does_not_reach_the_plate_is_an_island() {
        assert!(islands(&table(0.0), 0.0, 0.2, 1e-6).is_empty());
        let found = islands(&table(4.0), 0.0, 0.2, 1e-6);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].lowest[2], 4.0);
        assert!(
            (found[0].rise_mm - 4.0).abs() < 1e-12 && (found[0].first_layer_area_mm2 - 6.0).abs() < 1e-9,
            "{found:?}"
        );
        // A foot within a layer of the plate's underside is printed with it.
        assert!(islands(&table(7.9), 0.0, 0.2, 1e-6).is_empty());
    }

    #[test]
    fn a_facet_that_cracks_part_from_its_neighbours_is_no_island() {
        let ball = Primitive::Ball { radius: Length::mm(5.0) }.mesh(Length::mm(0.02));
        let ball = ball.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0, 0.0, 5.0]);
        // Each facet by itself, off by two parts in a thousand of its size or less.
        let apart = |f: usize| {
            let lift = 1e-3 * ball.facet_area(f).sqrt() * if f.is_multiple_of(2) { 1.0 } else { -0.5 };
            ball.corners(f).map(|p| along(p, ball.normal(f), lift))
        };
        let loose = TriangleMesh::weld((0..ball.triangles.len()).map(apart));
        assert!(islands(&loose, 0.1, 0.2, 1e-6).is_empty(), "{:?}", islands(&loose, 0.1, 0.2, 1e-6).len());
    }

    #[test]
    fn feet_that_begin_as_low_have_first_layers_of_their_own() {
        // A stand with an arm, from which a bar hangs with three feet that reach down as far as each other.
        let mut mesh = cuboid([0.0; 3], [3.0, 3.0, 15.0]).joined(&cuboid([2.0, 0.0, 13.0], [12.0, 3.0, 15.0]));
        mesh = mesh.joined(&cuboid([10.0, 0.5, 9.5], [11.0, 2.5, 14.0]));
        mesh = mesh.joined(&cuboid([5.0, 0.0, 9.0], [20.0, 3.0, 11.0]));
        for (x, wide) in [(6.0, 1.0), (10.0, 2.0), (15.0, 3.0)] {
            mesh = mesh.joined(&cuboid([x, 0.5, 4.0], [x + wide, 2.5, 10.0]));
        }
        let found = islands(&united(&mesh, 1e-6).unwrap(), 0.1, 0.2, 1e-6);
        let mut areas: Vec<f64> = found.iter().map(|i| i.first_layer_area_mm2).collect();
        areas.sort_by(f64::total_cmp);
        assert!(areas.len() == 3 && areas.iter().zip([2.0, 4.0, 6.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
        assert!(found.iter().all(|i| i.extent.1[0] - i.extent.0[0] < 3.1), "{found:?}");
    }

    #[test]
    fn what_joins_a_layer_higher_is_printed_with_it_wherever_it_stands() {
        // A nub under the end of an arm, one layer of 0.2 mm and a little more below it, in the numbers of an STL file.
        for n in 0..40 {
            for (drop, told) in [(0.2, 0), (0.2 + 1e-4, 1)] {
                let z = 10.0 + 0.05 * f64::from(n);
                let leg = cuboid([0.0; 3], [2.0, 2.0, z + 4.0]);
                let arm = cuboid([0.0, 0.0, z], [20.0, 2.0, z + 4.0]);
                let nub = cuboid([18.0, 0.5, z - drop], [19.0, 1.5, z + 1.0]);
                let mut mesh = united(&leg.joined(&arm).joined(&nub), 1e-6).unwrap();
                mesh.vertices.iter_mut().for_each(|p| *p = p.map(|x| f64::from(x as f32)));
                assert_eq!(islands(&mesh, 0.1, 0.2, 1e-6).len(), told, "{z} {drop}");
            }
        }
    }

    #[test]
    fn a_floating_body_is_an_island_and_a_void_is_not() {
        let floating = cuboid([0.0; 3], [9.0, 9.0, 1.0]).joined(&cuboid([1.0, 1.0, 5.0], [3.0, 3.0, 6.0]));
        let found = islands(&floating, 0.0, 0.2, 1e-6);
        assert_eq!(found.len(), 1);
        assert!((found[0].first_layer_area_mm2 - 4.0).abs() < 1e-9 && found[0].rise_mm.is_infinite());
        let hollow = cuboid([0.0; 3], [9.0; 3]).joined(&cuboid([1.0; 3], [8.0; 3]).flipped());
        assert!(islands(&hollow, 0.0, 0.2, 1e-6).is_empty());
    }
}
