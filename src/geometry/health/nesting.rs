//! Which shell lies in which.

use super::bodies::{Body, NO_LABEL, Role, assign_roles, bodies};
use super::boxes::lies_in;
use super::rays::{FacetTree, winding_of};
use super::shells::Shell;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;
use rayon::prelude::*;

/// Up to this many shells, boxes are compared in pairs to find the few that can hold another.
const PAIRS: usize = 2048;

/// Directions of the rays: no axis, no plane and no diagonal that parts are likely to have.
const DIRECTIONS: [Vec3; 8] = [
    [0.267261, 0.534523, 0.801784],
    [-0.621371, 0.112357, 0.775425],
    [0.431177, -0.733001, 0.526083],
    [-0.352183, -0.617291, 0.703511],
    [0.871329, 0.231701, -0.432509],
    [-0.190573, 0.909137, -0.370303],
    [0.577973, -0.318181, -0.751477],
    [-0.813019, -0.472301, -0.340409],
];

/// Facets that a shell has at least if it bounds anything.
const LEAST_FACETS: u64 = 4;

/// Rays that vote where a shell that does not close may hold another.
const VOTES: usize = 5;

/// Solid angles that are summed at most; beyond it, coincident shells count as lying beside each other.
const SOLID_ANGLES: usize = 500_000_000;

/// Sets role and body of every shell; the bodies in order of their first facets, and whether the whole mesh
/// is inside out.
///
/// One shell lies in another if its box does and a ray from one of its facets crosses the other with a
/// winding sum that is not zero (for a shell that does not close: an odd number of times, by vote of five
/// rays). Rays that touch an edge or start on a surface are replaced by others; where all do, the sum of
/// solid angles decides.
///
/// # Cost
/// O(facets · log facets) for the tree, then O(log facets + crossings) for each shell that can lie in another.
pub(super) fn nest(
    mesh: &TriangleMesh,
    shells: &mut [Shell],
    facet_shell: &[u32],
    extent: f64,
    miswound: u64,
) -> (Vec<Body>, bool) {
    let least = ghost_volume(mesh);
    for shell in shells.iter_mut().filter(|s| s.closed && s.volume_mm3.abs() < least) {
        shell.role = Role::Ghost;
    }
    let inside = containers(mesh, shells, facet_shell, extent);
    let tells = |s: &Shell| s.role != Role::Ghost && s.volume_mm3.abs() >= least && (s.closed || miswound == 0);
    let mut roots = shells.iter().zip(&inside).filter(|(s, i)| tells(s) && i.is_empty()).map(|(s, _)| s).peekable();
    let inverted = roots.peek().is_some() && roots.all(|s| s.volume_mm3 < 0.0);
    let hosts = assign_roles(shells, &inside, if inverted { -1.0 } else { 1.0 });
    (bodies(shells, &hosts), inverted)
}

/// The volume below which a closed shell is a ghost: 10⁻⁴ mm³, or 10⁻⁷ of the box of a part so small
/// (or in such a unit) that this would be much.
fn ghost_volume(mesh: &TriangleMesh) -> f64 {
    let volume = mesh.bounds().map_or(0.0, |(lo, hi)| (0..3).map(|a| hi[a] - lo[a]).product());
    (1e-7 * volume).min(1e-4)
}

/// For every shell the shells it lies in.
fn containers(mesh: &TriangleMesh, shells: &[Shell], facet_shell: &[u32], extent: f64) -> Vec<Vec<u32>> {
    let (holds, lies) = candidates(shells, extent);
    if !holds.contains(&true) {
        return vec![Vec::new(); shells.len()];
    }
    let held = |f: u32| holds.get(facet_shell[f as usize] as usize).is_some_and(|&h| h);
    let tree = FacetTree::new(mesh, (0..facet_shell.len() as u32).filter(|&f| held(f)).collect(), extent);
    let all_closed = shells.iter().zip(&holds).all(|(s, &h)| s.closed || !h);
    let groups = facets_by_shell(facet_shell, shells.len());
    let search = Search { mesh, shells, facet_shell, extent, tree, groups, rays: if all_closed { 1 } else { VOTES } };
    let by_ray: Vec<Option<Vec<u32>>> =
        (0..shells.len()).into_par_iter().map(|s| if lies[s] { search.by_rays(s) } else { Some(Vec::new()) }).collect();
    let tied = by_ray.iter().filter(|c| c.is_none()).count();
    let affordable = tied.saturating_mul(facet_shell.len()) <= SOLID_ANGLES;
    let last_word = |s: usize| if affordable { search.by_solid_angle(s) } else { Vec::new() };
    by_ray.into_par_iter().enumerate().map(|(s, found)| found.unwrap_or_else(|| last_word(s))).collect()
}

/// Shells whose box holds that of another, and shells whose box lies in that of another.
fn candidates(shells: &[Shell], extent: f64) -> (Vec<bool>, Vec<bool>) {
    let real: Vec<usize> = (0..shells.len()).filter(|&s| shells[s].role != Role::Ghost).collect();
    let (mut holds, mut lies) = (vec![false; shells.len()], vec![false; shells.len()]);
    for &s in real.iter().filter(|_| real.len() > 1) {
        if real.len() > PAIRS {
            (holds[s], lies[s]) = (shells[s].facets >= LEAST_FACETS, true);
            continue;
        }
        for &t in real.iter().filter(|&&t| t != s && can_hold(&shells[s], &shells[t], extent)) {
            (holds[t], lies[s]) = (true, true);
        }
    }
    (holds, lies)
}

/// Whether a shell may lie in another: the other bounds something, and its box holds that of the one.
fn can_hold(inner: &Shell, outer: &Shell, extent: f64) -> bool {
    let bounds = outer.role != Role::Ghost && outer.volume_mm3 != 0.0 && outer.facets >= LEAST_FACETS;
    bounds && lies_in(inner.box_mm, outer.box_mm, 1e-9 * extent)
}

/// Facets grouped by shell.
struct Groups {
    starts: Vec<u32>,
    facets: Vec<u32>,
}

impl Groups {
    fn of(&self, shell: usize) -> &[u32] {
        &self.facets[self.starts[shell] as usize..self.starts[shell + 1] as usize]
    }
}

fn facets_by_shell(facet_shell: &[u32], count: usize) -> Groups {
    let mut starts = vec![0u32; count + 1];
    facet_shell.iter().filter(|&&s| s != NO_LABEL).for_each(|&s| starts[s as usize + 1] += 1);
    for s in 0..count {
        starts[s + 1] += starts[s];
    }
    let mut next = starts.clone();
    let mut facets = vec![0; starts[count] as usize];
    for (f, &s) in facet_shell.iter().enumerate().filter(|(_, s)| **s != NO_LABEL) {
        facets[next[s as usize] as usize] = f as u32;
        next[s as usize] += 1;
    }
    Groups { starts, facets }
}

/// What the search for containers looks at.
struct Search<'a> {
    mesh: &'a TriangleMesh,
    shells: &'a [Shell],
    facet_shell: &'a [u32],
    extent: f64,
    tree: FacetTree<'a>,
    groups: Groups,
    /// Rays without a tie that decide: closed shells answer every ray alike, the others need a vote.
    rays: usize,
}

impl Search<'_> {
    /// Whether the shell of a facet may hold shell `s`.
    fn may_hold(&self, s: usize, facet: usize) -> bool {
        let t = self.facet_shell[facet] as usize;
        t != s && self.shells.get(t).is_some_and(|outer| can_hold(&self.shells[s], outer, self.extent))
    }

    fn probes(&self, s: usize) -> impl Iterator<Item = Vec3> + '_ {
        probes(self.groups.of(s)).map(|f| self.mesh.centroid(f))
    }

    /// The shells that one shell lies in, or `None` where every ray ties.
    fn by_rays(&self, s: usize) -> Option<Vec<u32>> {
        let mut votes: Vec<u32> = Vec::new();
        let mut rays = 0;
        for (probe, direction) in self.probes(s).flat_map(|p| DIRECTIONS.map(|d| (p, d))) {
            let Some(crossings) = self.tree.crossings(probe, direction, |f| self.may_hold(s, f)) else { continue };
            let mut sums: Vec<(u32, i32)> = crossings.iter().map(|c| (self.facet_shell[c.facet], c.sign)).collect();
            sums.sort_unstable();
            votes.extend(sums.chunk_by(|a, b| a.0 == b.0).filter(|own| self.is_around(own)).map(|own| own[0].0));
            rays += 1;
            if rays == self.rays {
                break;
            }
        }
        votes.sort_unstable();
        let most = votes.chunk_by(|a, b| a == b).filter(|v| 2 * v.len() > rays).map(|v| v[0]).collect();
        (rays > 0).then_some(most)
    }

    /// Whether the crossings of one shell mean that the start of the ray lies in it.
    fn is_around(&self, own: &[(u32, i32)]) -> bool {
        if self.shells[own[0].0 as usize].closed {
            own.iter().map(|c| c.1).sum::<i32>() != 0
        } else {
            own.len() % 2 == 1
        }
    }

    /// The last word where every ray ties: the sum of solid angles, on a surface about one half.
    fn by_solid_angle(&self, s: usize) -> Vec<u32> {
        let Some(probe) = self.probes(s).next() else { return Vec::new() };
        let mut sums = vec![0.0; self.shells.len()];
        for (f, &t) in self.facet_shell.iter().enumerate().filter(|(f, _)| self.may_hold(s, *f)) {
            sums[t as usize] += winding_of(self.mesh.corners(f), probe);
        }
        (0..self.shells.len() as u32).filter(|&t| sums[t as usize].abs() > 0.75).collect()
    }
}

/// Up to four facets of a shell, far apart in their order.
fn probes(own: &[u32]) -> impl Iterator<Item = usize> + '_ {
    let n = own.len();
    let mut at = vec![0, n / 3, 2 * n / 3, n.saturating_sub(1)];
    at.dedup();
    at.into_iter().filter_map(move |i| own.get(i)).map(|&f| f as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Health;

    /// An axis-aligned cube about a centre; a negative edge turns it inside out.
    fn cube(centre: Vec3, edge: f64) -> TriangleMesh {
        let corner = |i: usize| [0, 1, 2].map(|a| centre[a] + if i >> a & 1 == 1 { 0.5 * edge } else { -0.5 * edge });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        TriangleMesh::weld(quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|t| t.map(corner)))
    }

    fn health(parts: &[(Vec3, f64)]) -> Health {
        let parts = parts.iter().map(|&(c, e)| if e < 0.0 { cube(c, -e).flipped() } else { cube(c, e) });
        Health::of(&parts.fold(TriangleMesh::default(), |all, part| all.joined(&part)))
    }

    fn roles(parts: &[(Vec3, f64)]) -> Vec<Role> {
        health(parts).shells.iter().map(|s| s.role).collect()
    }

    const O: Vec3 = [0.0; 3];

    #[test]
    fn nested_shells_alternate() {
        let h = health(&[(O, 20.0), (O, -16.0), (O, 12.0), (O, -8.0), ([30.0, 0.0, 0.0], 4.0)]);
        let found: Vec<Role> = h.shells.iter().map(|s| s.role).collect();
        assert_eq!(found, [Role::Body, Role::Cavity, Role::Body, Role::Cavity, Role::Body]);
        let volumes: Vec<f64> = h.bodies.iter().map(|b| b.volume_mm3).collect();
        assert_eq!(volumes, [8000.0 - 4096.0, 1728.0 - 512.0, 64.0]);
        assert_eq!((h.facet_body[12], h.facet_body[24], h.facet_body[59]), (0, 1, 2));
        assert!(h.is_solid() && h.is_watertight() && !h.inverted);
    }

    #[test]
    fn inside_out_is_told_for_one_and_for_all() {
        assert_eq!(roles(&[(O, 5.0), ([9.0, 0.0, 0.0], -5.0)]), [Role::Body, Role::Inverted]);
        let h = health(&[(O, -20.0), (O, 10.0)]);
        assert!(h.inverted);
        assert_eq!((h.shells[1].role, h.bodies.len(), h.volume_mm3()), (Role::Cavity, 1, 7000.0));
    }

    #[test]
    fn swallowed_and_ghost_shells_are_apart() {
        assert_eq!(roles(&[(O, 20.0), (O, 5.0)]), [Role::Body, Role::Swallowed]);
        let h = health(&[(O, 20.0), ([30.0, 0.0, 0.0], 0.02)]);
        assert_eq!((h.shells[1].role, h.bodies.len(), h.facet_body[12]), (Role::Ghost, 1, NO_LABEL));
    }

    #[test]
    fn touching_shells_tie_and_are_still_told_apart() {
        // The small cube lies in a corner of the large one, three of its sides on the large one's.
        let corner = [-7.5; 3];
        assert_eq!(roles(&[(O, 20.0), (corner, -5.0)]), [Role::Body, Role::Cavity]);
        assert_eq!(roles(&[(O, 20.0), (O, -20.0)])[0], Role::Body);
        // Its box lies in the other's, itself it does not: an L of two boxes around nothing.
        let beside = cube([15.0, 0.0, 0.0], 10.0).joined(&cube([0.0, 20.0, 0.0], 10.0));
        assert_eq!(Health::of(&beside).bodies.len(), 2);
    }

    #[test]
    fn a_hundred_thousand_bodies_take_bounded_time() {
        let start = std::time::Instant::now();
        let unit = cube(O, 1.0);
        let mut mesh = TriangleMesh::default();
        for i in 0..100_000u32 {
            let shift = [i % 50, i / 50 % 50, i / 2500].map(|k| 2.0 * f64::from(k));
            let base = mesh.vertices.len() as u32;
            mesh.vertices.extend(unit.vertices.iter().map(|v| [0, 1, 2].map(|a| v[a] + shift[a])));
            mesh.triangles.extend(unit.triangles.iter().map(|t| t.map(|v| v + base)));
        }
        assert_eq!(Health::of(&mesh).bodies.len(), 100_000);
        // A guard against quadratic work, not a benchmark.
        assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
    }
}
