//! The connected pieces of a surface.

use super::bodies::{NO_LABEL, Role};
use super::boxes::{EMPTY, grown};
use super::cracks::cracks_of;
use crate::geometry::edges::{EdgeTable, is_collapsed};
use crate::geometry::vector::{Vec3, cross, dot, norm, sub};
use crate::geometry::{DisjointSets, TriangleMesh};

/// One connected piece of the surface.
///
/// Facets hang together over edges of exactly two facets; pieces that do not close so are joined with
/// others of that kind that they meet along edges of more facets, and with those that only a crack parts
/// from them: see [`cracks`](super::cracks).
#[derive(Debug, Clone, PartialEq)]
pub struct Shell {
    /// Number of facets.
    pub facets: u64,
    /// Its first facet.
    pub first_facet: usize,
    /// Along every edge, as many of its facets run one way as the other.
    pub closed: bool,
    /// Signed volume ∫ x·n dA / 3, mm³: negative where the normals point inward.
    pub volume_mm3: f64,
    /// Area, mm².
    pub area_mm2: f64,
    /// Least and greatest corner.
    pub box_mm: [Vec3; 2],
    /// What the shell bounds.
    pub role: Role,
    /// The body it belongs to, or [`NO_LABEL`].
    pub body: u32,
}

/// The shells in order of their first facets, and the shell of every facet.
///
/// # Cost
/// O(facets), up to the inverse Ackermann function, and O(E log E) for E edges of one facet.
pub(super) fn shells(mesh: &TriangleMesh, table: &EdgeTable) -> (Vec<Shell>, Vec<u32>) {
    let mut sets = DisjointSets::new(mesh.triangles.len());
    for edge in table.edges().filter(|e| e.sides.len() == 2) {
        sets.join(edge.sides[0].1.facet() as u32, edge.sides[1].1.facet() as u32);
    }
    let (labels, count) = labelled(&mut sets, mesh);
    let open = unbalanced(table, &labels, count);
    for edge in table.edges().filter(|e| e.sides.len() > 2) {
        let mut loose = edge.sides.iter().map(|s| s.1.facet()).filter(|&f| open[labels[f] as usize]);
        if let Some(first) = loose.next() {
            loose.for_each(|f| {
                sets.join(first as u32, f as u32);
            });
        }
    }
    let (mut labels, count) = labelled(&mut sets, mesh);
    let mut open = unbalanced(table, &labels, count);
    if open.iter().filter(|o| **o).count() > 1 {
        for crack in cracks_of(mesh, table) {
            sets.join(crack.facets[0], crack.facets[1]);
        }
        let (joined, count) = labelled(&mut sets, mesh);
        open = unbalanced(table, &joined, count);
        labels = joined;
    }
    for (f, &[a, b, c]) in mesh.triangles.iter().enumerate().filter(|(_, t)| is_collapsed(**t)) {
        let along = table.facet_along(a, b).or_else(|| table.facet_along(b, c));
        labels[f] = along.map_or(NO_LABEL, |g| labels[g]);
    }
    (measured(mesh, &labels, &open), labels)
}

/// For each set of facets, whether some edge has more of its facets one way than the other.
fn unbalanced(table: &EdgeTable, labels: &[u32], count: usize) -> Vec<bool> {
    let mut open = vec![false; count];
    let mut sums: Vec<(u32, i32)> = Vec::new();
    for edge in table.edges() {
        if let [(_, a), (_, b)] = edge.sides {
            // The commonest case, without the sorting: both facets are in one set.
            if a.direction() + b.direction() != 0 {
                open[labels[a.facet()] as usize] = true;
            }
            continue;
        }
        sums.clear();
        sums.extend(edge.sides.iter().map(|s| (labels[s.1.facet()], s.1.direction())));
        sums.sort_unstable();
        for own in sums.chunk_by(|a, b| a.0 == b.0) {
            open[own[0].0 as usize] |= own.iter().map(|s| s.1).sum::<i32>() != 0;
        }
    }
    open
}

/// Volume, area and box of every shell in one pass, facets in order.
fn measured(mesh: &TriangleMesh, labels: &[u32], open: &[bool]) -> Vec<Shell> {
    let blank = |closed: bool| Shell {
        facets: 0,
        first_facet: 0,
        closed,
        volume_mm3: 0.0,
        area_mm2: 0.0,
        box_mm: EMPTY,
        role: Role::Body,
        body: NO_LABEL,
    };
    let mut shells: Vec<Shell> = open.iter().map(|&o| blank(!o)).collect();
    // Volumes about a corner of the shell itself, so that a far origin or a far neighbour costs no digits.
    let mut about = vec![[0.0; 3]; shells.len()];
    for (f, &label) in labels.iter().enumerate() {
        let Some(shell) = shells.get_mut(label as usize) else { continue };
        let corners = mesh.corners(f);
        if shell.facets == 0 {
            shell.first_facet = f;
            about[label as usize] = corners[0];
        }
        let [a, b, c] = corners.map(|p| sub(p, about[label as usize]));
        shell.facets += 1;
        shell.volume_mm3 += dot(a, cross(b, c));
        shell.area_mm2 += 0.5 * norm(cross(sub(b, a), sub(c, a)));
        shell.box_mm = corners.into_iter().fold(shell.box_mm, grown);
    }
    // Divided once, so that parts on whole coordinates have exact volumes.
    shells.iter_mut().for_each(|s| s.volume_mm3 /= 6.0);
    shells
}

/// Labels from 0 in order of the first facet of each set, collapsed facets without one; and their number.
fn labelled(sets: &mut DisjointSets, mesh: &TriangleMesh) -> (Vec<u32>, usize) {
    let mut labels = vec![NO_LABEL; mesh.triangles.len()];
    let mut count = 0;
    for f in 0..labels.len() {
        if is_collapsed(mesh.triangles[f]) {
            continue;
        }
        let root = sets.root(f as u32) as usize;
        if labels[root] == NO_LABEL {
            labels[root] = count;
            count += 1;
        }
        labels[f] = labels[root];
    }
    (labels, count as usize)
}
