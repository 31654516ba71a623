//! Rods that alone hold what is beyond them: pins with a head.

use super::rod::{End, Rod, Search};
use super::section::{Plane, curve};
use crate::geometry::DisjointSets;
use crate::geometry::vector::{dot, sub};
use rustc_hash::{FxHashMap, FxHashSet};

/// What is higher than the lowest level by less than this share of the width searched for is on it.
const LEVEL: f64 = 1e-3;

/// What of a surface lies on one side of a cut.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Beyond {
    /// Pieces of it that reach the lowest level.
    on_plate: u32,
    area: f64,
}

impl Beyond {
    fn and(self, other: Beyond) -> Beyond {
        Beyond { on_plate: self.on_plate + other.on_plate, area: self.area + other.area }
    }

    fn without(self, other: Beyond) -> Beyond {
        Beyond { on_plate: self.on_plate - other.on_plate, area: self.area - other.area }
    }
}

/// A rod as a link between the pieces that are left of the surface when all rods are cut.
struct Link {
    rod: usize,
    /// The piece ahead of its axis, and the one behind.
    pieces: [u32; 2],
}

/// Makes an open end a head where a cut through the rod alone parts the surface and what is beyond that end is off the plate, z being
/// up; of two such ends the one with less surface beyond it.
///
/// All rods between wider pieces are cut at once; what is left is pieces, with the rods as links between them. A link parts its
/// pieces if it is a bridge of that graph.
///
/// # Cost
/// The edges of the mesh, almost; nothing without a rod between wider pieces.
///
/// # Source
/// R. E. Tarjan, A note on finding the bridges of a graph, Information Processing Letters 2, 1974.
pub(super) fn mark_heads(search: &Search, rods: &mut [Rod], counts: impl Fn(usize) -> bool) {
    let held: Vec<usize> = (0..rods.len()).filter(|&r| rods[r].ends == [End::Open; 2]).collect();
    if held.is_empty() {
        return;
    }
    let cuts = Cuts::through(search, rods, &held);
    let mesh = search.mesh;
    let mut pieces = DisjointSets::new(mesh.vertices.len());
    let facets: Vec<usize> = (0..mesh.triangles.len()).filter(|&f| counts(f)).collect();
    for edge in facets.iter().flat_map(|&f| edges_of(mesh.triangles[f])).filter(|edge| !cuts.edges.contains(edge)) {
        pieces.join(edge.0, edge.1);
    }
    let mut named: FxHashMap<u32, u32> = FxHashMap::default();
    let links: Vec<Link> = cuts
        .sides
        .into_iter()
        .map(|(rod, ends)| {
            let pieces = ends.map(|vertex| {
                let (root, next) = (pieces.root(vertex), named.len() as u32);
                *named.entry(root).or_insert(next)
            });
            Link { rod, pieces }
        })
        .collect();
    let lowest = facets.iter().flat_map(|&f| mesh.corners(f)).map(|p| p[2]).fold(f64::INFINITY, f64::min);
    let mut of: Vec<Beyond> = vec![Beyond::default(); named.len()];
    for &f in &facets {
        if let Some(&piece) = named.get(&pieces.root(mesh.triangles[f][0])) {
            let reaches = mesh.corners(f).iter().any(|p| p[2] <= lowest + search.wanted.within * LEVEL);
            let piece = &mut of[piece as usize];
            (piece.area, piece.on_plate) = (piece.area + mesh.facet_area(f), piece.on_plate.max(u32::from(reaches)));
        }
    }
    for (link, [ahead, behind]) in bridges(&links, &of) {
        let rod = &mut rods[links[link].rod];
        let (Some(last), centre) = (rod.line.last(), rod.narrowest.centre) else { continue };
        let last_is_ahead = dot(sub(last.0, centre), rod.narrowest.axis) > 0.0;
        let by_end = if last_is_ahead { [behind, ahead] } else { [ahead, behind] };
        let lesser = usize::from(by_end[1].area < by_end[0].area);
        let head = [lesser, 1 - lesser].into_iter().find(|&end| by_end[end].on_plate == 0);
        if let Some(end) = head {
            rod.ends[end] = End::Head;
        }
    }
}

/// The cuts through the narrowest sections of rods.
#[derive(Default)]
struct Cuts {
    /// The edges of the mesh that they cross, by their ends, the lesser first.
    edges: FxHashSet<(u32, u32)>,
    /// Of each rod a vertex ahead of its section, and one behind it.
    sides: Vec<(usize, [u32; 2])>,
}

impl Cuts {
    fn through(search: &Search, rods: &[Rod], held: &[usize]) -> Self {
        let mut cuts = Cuts::default();
        for &r in held {
            let s = &rods[r].narrowest;
            let plane = Plane { point: s.centre, normal: s.axis };
            let Some((_, crossed)) = curve(search.mesh, search.next, plane, s.facet, s.circumscribed) else { continue };
            let edges: Vec<(u32, u32)> =
                crossed.into_iter().flat_map(|f| edges_of(search.mesh.triangles[f as usize])).collect();
            // Sections of a bend without an inner radius run into each other: one of them cuts the surface.
            if edges.iter().any(|edge| cuts.edges.contains(edge)) {
                continue;
            }
            let is_ahead = |v: u32| dot(sub(search.mesh.vertices[v as usize], plane.point), plane.normal) >= 0.0;
            let mut ends = None;
            for (a, b) in edges {
                if is_ahead(a) != is_ahead(b) {
                    cuts.edges.insert((a, b));
                    ends = Some(if is_ahead(a) { [a, b] } else { [b, a] });
                }
            }
            cuts.sides.extend(ends.map(|ends| (r, ends)));
        }
        cuts
    }
}

/// The edges of a triangle, the lesser end first.
fn edges_of([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), p.max(q)))
}

/// The links that alone join what lies on both sides of them, each with what lies ahead and behind.
///
/// In a depth-first search a link is a bridge if nothing from below it leads to where it came from, or above.
fn bridges(links: &[Link], of: &[Beyond]) -> Vec<(usize, [Beyond; 2])> {
    let mut at: Vec<Vec<(u32, usize)>> = vec![Vec::new(); of.len()];
    for (n, link) in links.iter().enumerate() {
        let [a, b] = link.pieces;
        at[a as usize].push((b, n));
        at[b as usize].push((a, n));
    }
    const NOT_YET: usize = usize::MAX;
    let (mut found, mut below) = (vec![NOT_YET; of.len()], of.to_vec());
    let (mut earliest, mut looked) = (vec![NOT_YET; of.len()], vec![0usize; of.len()]);
    let (mut count, mut out) = (0, Vec::new());
    for root in 0..of.len() as u32 {
        if found[root as usize] != NOT_YET {
            continue;
        }
        let mut path: Vec<(u32, Option<usize>)> = vec![(root, None)];
        let mut parted: Vec<(usize, u32)> = Vec::new();
        while let Some(&(piece, by)) = path.last() {
            let p = piece as usize;
            if found[p] == NOT_YET {
                (found[p], earliest[p], count) = (count, count, count + 1);
            }
            if let Some(&(next, link)) = at[p].get(looked[p]) {
                looked[p] += 1;
                match found[next as usize] {
                    NOT_YET => path.push((next, Some(link))),
                    seen if Some(link) != by => earliest[p] = earliest[p].min(seen),
                    _ => {}
                }
                continue;
            }
            path.pop();
            if let (Some(&(parent, _)), Some(link)) = (path.last(), by) {
                let q = parent as usize;
                (earliest[q], below[q]) = (earliest[q].min(earliest[p]), below[q].and(below[p]));
                if earliest[p] > found[q] {
                    parted.push((link, piece));
                }
            }
        }
        let all = below[root as usize];
        out.extend(parted.into_iter().map(|(link, piece)| {
            let (beyond, rest) = (below[piece as usize], all.without(below[piece as usize]));
            (link, if links[link].pieces[0] == piece { [beyond, rest] } else { [rest, beyond] })
        }));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::feature::Side;
    use super::super::rod::Wanted;
    use super::*;
    use crate::geometry::Adjacency;
    use crate::geometry::vector::Vec3;
    use crate::geometry::{MeshDistance, TriangleMesh, revolved};
    use crate::random::Lcg;

    fn ends(mesh: &TriangleMesh) -> Vec<[End; 2]> {
        let (distance, next) = (MeshDistance::new(mesh), Adjacency::of(mesh, |_| true));
        let wanted = Wanted { side: Side::Material, within: 2.0, elongation: 1.81 };
        let rods = Search { mesh, distance: &distance, next: &next, wanted }.run(|_| true).rods;
        rods.iter().map(|r| r.ends).collect()
    }

    #[test]
    fn a_neck_that_alone_holds_a_piece_above_the_plate_has_a_head_and_one_between_two_that_stand_has_none() {
        // A foot of 6 mm, a neck of 1 mm, a head of 3 mm.
        let pin = revolved(
            &[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.5, 1.0], [0.5, 5.0], [1.5, 5.0], [1.5, 7.0], [0.0, 7.0]],
            24,
        );
        let headed = |mesh: &TriangleMesh| ends(mesh).iter().filter(|e| e.contains(&End::Head)).count();
        assert_eq!((headed(&pin), ends(&pin).len()), (1, 1));
        // Upside down as well; lying both ends are on the plate.
        let turned = |rows: [Vec3; 3]| pin.transformed(rows, [0.3, 0.1, 0.2]);
        assert_eq!(headed(&turned([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])), 1);
        let dumbbell = revolved(
            &[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.5, 2.0], [0.5, 6.0], [3.0, 6.0], [3.0, 8.0], [0.0, 8.0]],
            24,
        );
        let lying = dumbbell.transformed([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]], [0.0; 3]);
        assert_eq!((headed(&dumbbell), headed(&lying), ends(&lying)), (1, 0, vec![[End::Open; 2]]));
    }

    #[test]
    fn bridges_are_the_links_without_which_their_pieces_are_apart() {
        let mut random = Lcg(5);
        for _ in 0..200 {
            let pieces = 2 + random.below(9) as usize;
            let links: Vec<Link> = (0..random.below(14) as usize)
                .map(|rod| Link { rod, pieces: [0; 2].map(|_| random.below(pieces as u64) as u32) })
                .collect();
            let of: Vec<Beyond> =
                (0..pieces).map(|n| Beyond { on_plate: u32::from(n % 3 == 0), area: 1.0 + n as f64 }).collect();
            let without = |left_out: usize, from: u32| {
                let mut sets = DisjointSets::new(pieces);
                let kept = links.iter().enumerate().filter(|(n, _)| *n != left_out);
                for (_, l) in kept {
                    sets.join(l.pieces[0], l.pieces[1]);
                }
                let root = sets.root(from);
                let side: Vec<u32> = (0..pieces as u32).filter(|&p| sets.root(p) == root).collect();
                side.iter().fold(Beyond::default(), |all, &p| all.and(of[p as usize]))
            };
            let mut plain: Vec<(usize, [Beyond; 2])> = (0..links.len())
                .map(|n| (n, links[n].pieces.map(|p| without(n, p))))
                .filter(|(n, sides)| sides[0] != without(usize::MAX, links[*n].pieces[0]))
                .collect();
            let mut found = bridges(&links, &of);
            found.sort_by_key(|b| b.0);
            plain.sort_by_key(|b| b.0);
            assert_eq!(found, plain);
        }
    }
}
