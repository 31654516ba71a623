//! The pieces of a solid above each height, and where they join, from its surface alone.

use crate::geometry::vector::{Vec3, along, compare, sub, unit};
use crate::geometry::{DisjointSets, MeshDistance, TriangleMesh};
use rayon::prelude::*;

/// A piece of a solid above a height, followed down from its top until it joins a higher one, or an equally high one in what both stand on.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Its highest point; of several the last by x, y.
    pub top: Vec3,
    /// Where it joins another piece, or its own lowest height if it never does.
    pub bottom: f64,
    /// Whether it joins another piece, as high or higher.
    pub joins: bool,
    /// The edges that its outlines cross, as far down as they are its own; none lies level.
    pub edges: Vec<Rising>,
}

/// A stretch of an edge of the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rising {
    ends: [Vec3; 2],
    /// Two facets along it.
    pub facets: [u32; 2],
    /// Heights between which the stretch lies, the lower one first.
    pub heights: [f64; 2],
}

impl Rising {
    /// Where the edge crosses a height, which has to be between its own.
    pub fn at(&self, z: f64) -> [f64; 2] {
        let [p, q] = self.ends;
        let t = (z - p[2]) / (q[2] - p[2]);
        // Each end is met exactly, so that edges that share it agree there.
        let from = |a: f64, b: f64| if t < 0.5 { a + t * (b - a) } else { b - (1.0 - t) * (b - a) };
        [from(p[0], q[0]), from(p[1], q[1])]
    }
}

/// Shares of the way from a corner to the middle of a facet where material is looked for above it.
const SHARES: [f64; 3] = [1.0, 0.1, 1e-3];
/// Facets from which the way up out of a ceiling is tried.
const TRIED: usize = 16;
/// How near a ray may meet what it starts from, in shares of the greatest coordinate.
const NEAR: f64 = 1e-9;

/// The pieces of the solid bounded by the facets for which `bounds` holds, by their tops.
///
/// Let M be the solid and M_z what of it lies at height z or above. A piece is followed down through the components of M_z that hold
/// its top; where two pieces are in one component the one with the lower top has joined the other, and of two that are equally high both
/// have joined a third, which has that height too. The surface tells all of this:
/// the parts of ∂M at z or above that belong to one component of M_z face different components of its complement, and one of them
/// reaches higher than all others. Every other has its highest point where material lies above, so the way straight up from there
/// ends on another part of the boundary of the same component. So the pieces follow from the edges of the mesh and one ray from
/// each ceiling that is a highest point of its surroundings.
///
/// Exact for a closed surface that does not cross itself, except that heights are compared as they stand, without a tolerance. Of any
/// other, what a ray out of a ceiling does not tell counts for no piece until it meets one.
///
/// # Cost
/// O(E log E) for E edges, and one ray for each ceiling.
pub fn pieces(mesh: &TriangleMesh, bounds: impl Fn(usize) -> bool, tree: &MeshDistance) -> Vec<Piece> {
    let facets: Vec<u32> = (0..mesh.triangles.len()).filter(|&f| bounds(f)).map(|f| f as u32).collect();
    let mut sweep = Sweep::over(mesh, &facets, tree);
    let edges = edges_from_the_top(mesh, &facets);
    let mut order: Vec<u32> = facets.iter().flat_map(|&f| mesh.triangles[f as usize]).collect();
    order.par_sort_unstable();
    order.dedup();
    order.par_sort_unstable_by(|&a, &b| {
        let at = |v: u32| mesh.vertices[v as usize];
        compare_from_the_top(at(a), at(b)).then(a.cmp(&b))
    });
    let mut left = edges.as_slice();
    let height = |v: u32| mesh.vertices[v as usize][2];
    for level in order.chunk_by(|&a, &b| height(a) == height(b)) {
        let z = level.first().map_or(0.0, |&v| height(v));
        let reached = left.iter().take_while(|e| height(e[1]) == z).count();
        let (here, below) = left.split_at(reached);
        left = below;
        sweep.settle(level, here, z);
    }
    sweep.into_pieces(&edges)
}

/// Higher first, then the order of points reversed.
fn compare_from_the_top(a: Vec3, b: Vec3) -> std::cmp::Ordering {
    b[2].total_cmp(&a[2]).then_with(|| compare(b, a))
}

/// The edges of facets, each once with its higher end first, by their lower ends from the top down.
fn edges_from_the_top(mesh: &TriangleMesh, facets: &[u32]) -> Vec<[u32; 2]> {
    let height = |v: u32| mesh.vertices[v as usize][2];
    let directed = |f: &u32| {
        let [a, b, c] = mesh.triangles[*f as usize];
        [[a, b], [b, c], [c, a]].map(|[p, q]| {
            let falls = height(p) > height(q) || (height(p) == height(q) && p < q);
            if falls { [p, q] } else { [q, p] }
        })
    };
    let mut edges: Vec<[u32; 2]> = facets.iter().flat_map(directed).filter(|[p, q]| p != q).collect();
    edges.par_sort_unstable_by(|a, b| height(b[1]).total_cmp(&height(a[1])).then(a.cmp(b)));
    edges.dedup();
    edges
}

/// A piece as it is known during the sweep.
struct Branch {
    top: Vec3,
    /// Of a ceiling from which no way up was found: it is not known what it belongs to.
    is_stray: bool,
    /// Height at which it joined another, and which.
    joined: Option<(f64, u32)>,
}

/// What has no branch yet.
const NEW: u32 = u32::MAX;

struct Sweep<'a> {
    mesh: &'a TriangleMesh,
    tree: &'a MeshDistance,
    /// Facets at each vertex: those from `first[v]` to `first[v + 1]` of `around`.
    first: Vec<u32>,
    around: Vec<u32>,
    near: f64,
    /// Vertices that the surface joins at or above the height reached.
    sets: DisjointSets,
    /// Branch of each set, at its root; it may have joined another since.
    branch: Vec<u32>,
    /// Branch of each vertex when its height was reached.
    began: Vec<u32>,
    branches: Vec<Branch>,
}

impl<'a> Sweep<'a> {
    fn over(mesh: &'a TriangleMesh, facets: &[u32], tree: &'a MeshDistance) -> Self {
        let count = mesh.vertices.len();
        let mut first = vec![0u32; count + 1];
        let corners = || facets.iter().flat_map(|&f| mesh.triangles[f as usize].map(|v| (v as usize, f)));
        corners().for_each(|(v, _)| first[v + 1] += 1);
        (0..count).for_each(|v| first[v + 1] += first[v]);
        let (mut next, mut around) = (first.clone(), vec![0u32; 3 * facets.len()]);
        for (v, f) in corners() {
            around[next[v] as usize] = f;
            next[v] += 1;
        }
        let greatest = mesh.vertices.iter().flatten().fold(0.0f64, |most, c| most.max(c.abs()));
        Sweep {
            mesh,
            tree,
            first,
            around,
            near: NEAR * greatest,
            sets: DisjointSets::new(count),
            branch: vec![NEW; count],
            began: vec![NEW; count],
            branches: Vec::new(),
        }
    }

    fn point(&self, v: u32) -> Vec3 {
        self.mesh.vertices[v as usize]
    }

    fn facets_at(&self, v: u32) -> &[u32] {
        &self.around[self.first[v as usize] as usize..self.first[v as usize + 1] as usize]
    }

    /// The branch that a branch is part of now.
    fn current(&self, mut branch: u32) -> u32 {
        while let Some((_, into)) = self.branches.get(branch as usize).and_then(|b| b.joined) {
            branch = into;
        }
        branch
    }

    /// Takes in the vertices of one height and the edges whose lower ends they are.
    fn settle(&mut self, level: &[u32], edges: &[[u32; 2]], z: f64) {
        for &[upper, lower] in edges {
            let (a, b) = (self.sets.root(upper), self.sets.root(lower));
            if a == b {
                continue;
            }
            let branch = match (self.branch[a as usize], self.branch[b as usize]) {
                (NEW, one) | (one, NEW) => one,
                (one, other) => self.merge(one, other, z),
            };
            let root = self.sets.join(a, b);
            self.branch[root as usize] = branch;
        }
        let mut new: Vec<(u32, u32)> = level.iter().map(|&v| (self.sets.root(v), v)).collect();
        new.retain(|&(root, _)| self.branch[root as usize] == NEW);
        // Stable: the vertices of each set stay in the order of the level.
        new.sort_by_key(|&(root, _)| root);
        for set in new.chunk_by(|a, b| a.0 == b.0) {
            let vertices: Vec<u32> = set.iter().map(|&(_, v)| v).collect();
            self.branch[set[0].0 as usize] = self.begun_by(&vertices, z);
        }
        for &v in level {
            let root = self.sets.root(v);
            self.began[v as usize] = self.current(self.branch[root as usize]);
        }
    }

    /// Makes one branch of two that meet at a height and returns it: the one with the higher top, or a third below both where they are
    /// equally high.
    fn merge(&mut self, one: u32, other: u32, z: f64) -> u32 {
        let (a, b) = (self.current(one), self.current(other));
        if a == b {
            return a;
        }
        let third = self.branches.len() as u32;
        if let [Some(x), Some(y)] = [a, b].map(|n| self.branches.get(n as usize))
            && x.top[2] == y.top[2]
            && !x.is_stray
            && !y.is_stray
        {
            let top = if compare_from_the_top(x.top, y.top).is_le() { x.top } else { y.top };
            for joining in [a, b] {
                self.branches[joining as usize].joined = Some((z, third));
            }
            self.branches.push(Branch { top, is_stray: false, joined: None });
            return third;
        }
        let (x, y) = (&self.branches[a as usize], &self.branches[b as usize]);
        let first = x.is_stray.cmp(&y.is_stray).then_with(|| compare_from_the_top(x.top, y.top)).is_le();
        let (kept, lost) = if first { (a, b) } else { (b, a) };
        self.branches[lost as usize].joined = Some((z, kept));
        kept
    }

    /// The branch of vertices that the surface joins and about which it goes down on all sides.
    fn begun_by(&mut self, vertices: &[u32], z: f64) -> u32 {
        let under_material = self.lies_under_material(vertices);
        if let Some(above) = under_material.then(|| self.above(vertices, z)).flatten() {
            return above;
        }
        let top = vertices.first().map_or([0.0; 3], |&v| self.point(v));
        self.branches.push(Branch { top, is_stray: under_material, joined: None });
        self.branches.len() as u32 - 1
    }

    /// Whether what lies straight above a highest point of the surface is material: by the facet, or the edge between two, that
    /// comes nearest to pointing upwards from there.
    fn lies_under_material(&self, vertices: &[u32]) -> bool {
        let mut steepest = (f64::NEG_INFINITY, 0.0);
        for &v in vertices {
            for &f in self.facets_at(v) {
                let n = self.mesh.normal(f as usize)[2];
                let rise = self.rise(v, f);
                if rise > steepest.0 {
                    steepest = (rise, n);
                } else if rise == steepest.0 {
                    steepest.1 += n;
                }
            }
        }
        steepest.1 < 0.0
    }

    /// The sine of the steepest way up within a facet from a corner that is its highest: along one of its edges. It is 1 for a level
    /// facet, whose side is plain.
    fn rise(&self, v: u32, facet: u32) -> f64 {
        let p = self.point(v);
        let others = self.mesh.triangles[facet as usize].into_iter().filter(|&w| w != v);
        let rises = others.map(|w| unit(sub(self.point(w), p))[2]);
        let (least, most) = rises.fold((0.0f64, f64::NEG_INFINITY), |(lo, hi), r| (lo.min(r), hi.max(r)));
        if least == 0.0 { 1.0 } else { most }
    }

    /// The branch that the way straight up from a ceiling ends on.
    fn above(&mut self, vertices: &[u32], z: f64) -> Option<u32> {
        let facets = vertices.iter().flat_map(|&v| self.facets_at(v).iter().map(move |&f| (v, f)));
        let mut down: Vec<(u32, u32, f64)> = facets.map(|(v, f)| (v, f, self.mesh.normal(f as usize)[2])).collect();
        // The most level first: from there the way up is least likely to graze what it starts from.
        down.retain(|d| d.2 < 0.0);
        down.sort_by(|a, b| a.2.total_cmp(&b.2));
        for &(v, f, _) in down.iter().take(TRIED) {
            let middle = self.mesh.centroid(f as usize);
            for share in SHARES {
                let from = along(self.point(v), sub(middle, self.point(v)), share);
                let hit = self.tree.first_hit(from, [0.0, 0.0, 1.0], self.near, f64::INFINITY);
                let Some(&corners) = hit.and_then(|(_, g)| self.mesh.triangles.get(g as usize)) else { continue };
                let leaves = hit.is_some_and(|(_, g)| self.mesh.normal(g as usize)[2] > 0.0);
                let highest = corners.into_iter().max_by(|&p, &q| self.point(p)[2].total_cmp(&self.point(q)[2]));
                if let Some(u) = highest.filter(|&u| leaves && self.point(u)[2] > z) {
                    let root = self.sets.root(u);
                    let branch = self.current(self.branch[root as usize]);
                    if branch != NEW {
                        return Some(branch);
                    }
                }
            }
        }
        None
    }

    /// The first two facets along an edge.
    fn facets_along(&self, a: u32, b: u32) -> [u32; 2] {
        let (few, other) = if self.facets_at(a).len() <= self.facets_at(b).len() { (a, b) } else { (b, a) };
        let mut along =
            self.facets_at(few).iter().copied().filter(|&f| self.mesh.triangles[f as usize].contains(&other));
        let first = along.next().unwrap_or(NEW);
        [first, along.next().unwrap_or(first)]
    }

    /// Gives every branch the edges that are its own.
    fn into_pieces(self, edges: &[[u32; 2]]) -> Vec<Piece> {
        let piece = |b: &Branch| {
            let bottom = b.joined.map_or(f64::INFINITY, |(z, _)| z);
            Piece { top: b.top, bottom, joins: b.joined.is_some(), edges: Vec::new() }
        };
        let mut found: Vec<Piece> = self.branches.iter().map(piece).collect();
        for &[upper, lower] in edges {
            let (p, q) = (self.point(lower), self.point(upper));
            let facets = self.facets_along(upper, lower);
            let (mut high, mut at) = (q[2], self.began[upper as usize]);
            while high > p[2] {
                let (Some(branch), Some(piece)) = (self.branches.get(at as usize), found.get_mut(at as usize)) else {
                    break;
                };
                let end = branch.joined.map_or(f64::NEG_INFINITY, |(z, _)| z);
                if end < high {
                    let low = p[2].max(end);
                    piece.edges.push(Rising { ends: [p, q], facets, heights: [low, high] });
                    piece.bottom = piece.bottom.min(low);
                    high = low;
                }
                at = branch.joined.map_or(NEW, |(_, into)| into);
            }
        }
        let mut kept: Vec<Piece> =
            found.into_iter().zip(&self.branches).filter(|(_, b)| !b.is_stray).map(|(piece, _)| piece).collect();
        kept.sort_by(|a, b| compare_from_the_top(a.top, b.top));
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Hull;
    use crate::random::Lcg;

    const SIDE: usize = 6;
    type Cells = [[[bool; SIDE]; SIDE]; SIDE];

    fn holds(cells: &Cells, [x, y, z]: [i64; 3]) -> bool {
        let of = |c: i64| usize::try_from(c).ok().filter(|&c| c < SIDE);
        of(x).zip(of(y)).zip(of(z)).is_some_and(|((x, y), z)| cells[z][y][x])
    }

    /// Random cells, filled up until no two touch along an edge or at a corner alone, nor do two of the void.
    fn random_cells(random: &mut Lcg, percent: u64) -> Cells {
        let mut cells = [[[false; SIDE]; SIDE]; SIDE];
        cells.iter_mut().flatten().flatten().for_each(|c| *c = random.below(100) < percent);
        let reach = -1..SIDE as i64;
        loop {
            let mut filled = false;
            for (x, y, z) in
                reach.clone().flat_map(|x| reach.clone().flat_map(move |y| (-1..SIDE as i64).map(move |z| (x, y, z))))
            {
                let corner = |n: i64| [x + (n & 1), y + (n >> 1 & 1), z + (n >> 2 & 1)];
                let is_in = |n: i64| holds(&cells, corner(n));
                let crossed = |a: i64, b: i64, c: i64, d: i64| {
                    is_in(a) == is_in(d) && is_in(b) == is_in(c) && is_in(a) != is_in(b)
                };
                let faces = [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 4, 5), (2, 3, 6, 7), (0, 2, 4, 6), (1, 3, 5, 7)];
                let alone = |n: i64| {
                    (0..8).all(|m| (m == n || m == 7 - n) == is_in(m))
                        || (0..8).all(|m| (m == n || m == 7 - n) != is_in(m))
                };
                if faces.iter().any(|&(a, b, c, d)| crossed(a, b, c, d)) || (0..4).any(alone) {
                    let within = |p: &[i64; 3]| p.iter().all(|&c| (0..SIDE as i64).contains(&c));
                    for p in (0..8).map(corner).filter(within) {
                        cells[p[2] as usize][p[1] as usize][p[0] as usize] = true;
                    }
                    filled = true;
                }
            }
            if !filled {
                return cells;
            }
        }
    }

    fn surface(cells: &Cells) -> TriangleMesh {
        let mut facets = Vec::new();
        let each =
            (0..SIDE).flat_map(|x| (0..SIDE).flat_map(move |y| (0..SIDE).map(move |z| [x, y, z].map(|c| c as i64))));
        for cell in each.filter(|&c| holds(cells, c)) {
            for (axis, step) in [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)] {
                let mut next = cell;
                next[axis] += step;
                if holds(cells, next) {
                    continue;
                }
                let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                    let mut p = cell.map(|c| c as f64);
                    p[axis] += f64::from(u8::from(step > 0));
                    p[(axis + 1) % 3] += f64::from(u);
                    p[(axis + 2) % 3] += f64::from(v);
                    p
                });
                if step < 0 {
                    quad.reverse();
                }
                let [a, b, c, d] = quad;
                facets.extend([[a, b, c], [a, c, d]]);
            }
        }
        TriangleMesh::weld(facets)
    }

    /// Top and least width of each component of the cells of a layer and above, by flooding.
    fn by_flooding(cells: &Cells, layer: i64) -> Vec<[i64; 2]> {
        let mut seen = [[[false; SIDE]; SIDE]; SIDE];
        let mut found = Vec::new();
        let each = (0..SIDE as i64)
            .flat_map(|x| (0..SIDE as i64).flat_map(move |y| (layer..SIDE as i64).map(move |z| [x, y, z])));
        for start in each {
            let mut open = vec![start];
            let (mut top, mut section) = (0, Vec::new());
            while let Some(p) = open.pop() {
                if !holds(cells, p)
                    || p[2] < layer
                    || std::mem::replace(&mut seen[p[2] as usize][p[1] as usize][p[0] as usize], true)
                {
                    continue;
                }
                top = top.max(p[2] + 1);
                if p[2] == layer {
                    let [x, y] = [p[0] as f64, p[1] as f64];
                    section.extend([[x, y], [x + 1.0, y], [x, y + 1.0], [x + 1.0, y + 1.0]]);
                }
                for (axis, step) in [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)] {
                    let mut next = p;
                    next[axis] += step;
                    open.push(next);
                }
            }
            if !section.is_empty() {
                found.push([top, (1e6 * Hull::of(section).widths().0).round() as i64]);
            }
        }
        found.sort_unstable();
        found
    }

    #[test]
    fn pieces_are_what_flooding_finds() {
        let mut random = Lcg(5);
        let (mut most, mut stray) = (0, 0);
        for round in 0..300 {
            let cells = random_cells(&mut random, [8, 15, 25, 60, 90][round % 5]);
            let mesh = surface(&cells);
            if mesh.triangles.is_empty() {
                continue;
            }
            let (s, c) = if round % 2 == 0 { (0.0, 1.0) } else { (1.0 + random.unit()).sin_cos() };
            let turned = mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.3, -0.2, 0.0]);
            let all = pieces(&turned, |_| true, &MeshDistance::new(&turned));
            for layer in 0..SIDE as i64 {
                let z = layer as f64 + 0.4;
                let section = |p: &Piece| {
                    let crossing = p.edges.iter().filter(|e| e.heights[0] < z && e.heights[1] > z);
                    let hull = Hull::of(crossing.map(|e| e.at(z)));
                    (hull.corners().len() > 2)
                        .then(|| [p.top[2].round() as i64, (1e6 * hull.widths().0).round() as i64])
                };
                let mut found: Vec<[i64; 2]> = all.iter().filter_map(section).collect();
                found.sort_unstable();
                assert_eq!(found, by_flooding(&cells, layer), "round {round}, layer {layer}");
                most = most.max(found.len());
            }
            stray += usize::from(all.len() > 6);
        }
        assert!(most > 4 && stray > 10, "{most} {stray}");
    }

    #[test]
    fn a_pin_in_a_sealed_box_joins_what_the_lid_begins_and_not_the_void() {
        let mut cells = [[[true; SIDE]; SIDE]; SIDE];
        let inner = || (1..5).flat_map(|x| (1..5).flat_map(move |y| (1..5).map(move |z| [x, y, z])));
        inner().filter(|&[x, y, z]| [x, y] != [2, 3] || z > 3).for_each(|[x, y, z]| cells[z][y][x] = false);
        let mesh = surface(&cells);
        let all = pieces(&mesh, |_| true, &MeshDistance::new(&mesh));
        let told: Vec<(f64, f64, bool)> = all.iter().map(|p| (p.top[2], p.bottom, p.joins)).collect();
        assert_eq!(told, [(6.0, 0.0, false), (4.0, 1.0, true)]);
    }
}
