//! The polygons that cut a cell, for each of the 256 ways in which its corners can be inside.

/// The corners of a polygon as edges of the cell, and how to cut it: from which corners it can be; if from none, from
/// its centre.
#[derive(Debug, Clone)]
pub(super) struct Polygon {
    pub(super) edges: Vec<usize>,
    pub(super) fans: Vec<usize>,
}

/// The twelve edges of a cell: first corner (bits x, y, z) and axis.
pub(super) const EDGES: [(usize, usize); 12] =
    [(0, 0), (2, 0), (4, 0), (6, 0), (0, 1), (1, 1), (4, 1), (5, 1), (0, 2), (1, 2), (2, 2), (3, 2)];

/// The six faces, corners counter-clockwise seen from outside the cell.
const FACES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// The edge between two corners that differ in one bit.
fn edge_between(a: usize, b: usize) -> usize {
    let axis = (a ^ b).trailing_zeros() as usize;
    EDGES.iter().position(|&e| e == (a.min(b), axis)).unwrap_or(0)
}

/// Whether two edges of the cell lie on one face: a diagonal between them could be a neighbour's too.
fn share_a_face(a: usize, b: usize) -> bool {
    let on = |face: &[usize; 4], edge: usize| (0..4).any(|c| edge_between(face[c], face[(c + 1) % 4]) == edge);
    FACES.iter().any(|face| on(face, a) && on(face, b))
}

/// The polygons of all 256 cells.
pub(super) fn polygons_of_all_cells() -> Vec<Vec<Polygon>> {
    (0..256usize).map(polygons_of_cell).collect()
}

fn polygons_of_cell(config: usize) -> Vec<Polygon> {
    let inside = |corner: usize| config >> corner & 1 == 1;
    // On every face, from the edge where the walk around it enters a run of inside corners to where it leaves.
    let mut next = [usize::MAX; 12];
    for face in FACES {
        for at in 0..4 {
            if inside(face[at]) || !inside(face[(at + 1) % 4]) {
                continue;
            }
            let entered = edge_between(face[at], face[(at + 1) % 4]);
            let run = (1..4).take_while(|&n| inside(face[(at + n) % 4])).count();
            let left = edge_between(face[(at + run) % 4], face[(at + run + 1) % 4]);
            next[entered] = left;
        }
    }
    let mut polygons = Vec::new();
    for start in 0..12 {
        let mut edges = Vec::new();
        let mut at = start;
        while next[at] != usize::MAX {
            edges.push(at);
            at = std::mem::replace(&mut next[at], usize::MAX);
        }
        if !edges.is_empty() {
            let n = edges.len();
            let clean = |from: usize| (2..n - 1).all(|d| !share_a_face(edges[from], edges[(from + d) % n]));
            let fans = (0..n).filter(|&from| clean(from)).collect();
            polygons.push(Polygon { edges, fans });
        }
    }
    polygons
}
