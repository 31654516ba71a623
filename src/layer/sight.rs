//! What is seen of the void from outside, and what liquid stays in it.

use crate::error::Result;
use crate::field::Indicator;

/// The samples outside the part that no straight line of samples reaches from the border of the grid.
///
/// { c ∉ S : for each d of the 26 directions of the lattice, some c + n·d, n ≥ 1, lies in S }. What a straight tool along one of those
/// directions cannot see.
///
/// # Errors
/// None but [`crate::Error::Internal`] if the words do not fit the grid.
///
/// # Cost
/// 26 passes over words of 64 samples.
pub fn hidden_from_outside(centres: &Indicator) -> Result<Indicator> {
    let grid = *centres.grid();
    let [nx, ny, nz] = grid.dims();
    let wpr = centres.words_per_row();
    let mut seen = vec![0u64; wpr * ny * nz];
    for sz in [-1isize, 0, 1] {
        for sy in [-1isize, 0, 1] {
            for sx in [-1isize, 0, 1] {
                if (sx, sy, sz) != (0, 0, 0) {
                    look(centres, [sx, sy, sz], &mut seen);
                }
            }
        }
    }
    let last = if nx.is_multiple_of(64) { !0 } else { !(!0u64 << (nx % 64)) };
    let words = seen.iter().zip(centres.words()).enumerate().map(|(at, (seen, solid))| {
        let row = if (at + 1).is_multiple_of(wpr) { last } else { !0 };
        !seen & !solid & row
    });
    Indicator::from_words(grid, words.collect())
}

/// Adds what light that travels along a direction reaches.
fn look(centres: &Indicator, [sx, sy, sz]: [isize; 3], seen: &mut [u64]) {
    let [nx, ny, nz] = centres.grid().dims();
    let wpr = centres.words_per_row();
    let row_of = |j: usize, k: usize| (k * ny + j) * wpr;
    let forward = |n: usize, s: isize, at: usize| if s < 0 { n - 1 - at } else { at };
    if sy == 0 && sz == 0 {
        for row in 0..ny * nz {
            along_row(centres.row(row % ny, row / ny), nx, sx, &mut seen[row * wpr..(row + 1) * wpr]);
        }
        return;
    }
    let mut light = vec![0u64; wpr * ny * nz];
    for ck in 0..nz {
        for cj in 0..ny {
            let (j, k) = (forward(ny, sy, cj), forward(nz, sz, ck));
            let (fj, fk) = (j as isize - sy, k as isize - sz);
            let inside = fj >= 0 && fk >= 0 && fj < ny as isize && fk < nz as isize;
            let at = row_of(j, k);
            for w in 0..wpr {
                let arriving = if inside {
                    let from = row_of(fj as usize, fk as usize);
                    shifted(&light[from..from + wpr], w, sx, nx)
                } else {
                    !0
                };
                light[at + w] = arriving & !centres.words()[at + w];
                seen[at + w] |= light[at + w];
            }
        }
    }
}

/// A word of a row moved by one sample along x; light enters at the end.
fn shifted(row: &[u64], w: usize, sx: isize, nx: usize) -> u64 {
    match sx {
        0 => row[w],
        1 => row[w] << 1 | if w == 0 { 1 } else { row[w - 1] >> 63 },
        _ => {
            let carry = if w + 1 < row.len() { row[w + 1] << 63 } else { 0 };
            let entry = if w == (nx - 1) / 64 { 1 << ((nx - 1) % 64) } else { 0 };
            row[w] >> 1 | carry | entry
        }
    }
}

/// Light along a row: up to the first sample inside.
fn along_row(row: &[u64], nx: usize, sx: isize, seen: &mut [u64]) {
    let order: Box<dyn Iterator<Item = usize>> = if sx > 0 { Box::new(0..nx) } else { Box::new((0..nx).rev()) };
    for i in order {
        if row[i / 64] >> (i % 64) & 1 == 1 {
            return;
        }
        seen[i / 64] |= 1 << (i % 64);
    }
}

/// Number of samples in which liquid stays: every way out from them rises.
///
/// A sample outside the part, in layer k, keeps liquid if its component among the samples outside in layers up to k does not reach the
/// side or the bottom of the grid. Neighbours share a face. What a sealed void holds counts as well.
///
/// # Cost
/// O(samples/64 + runs·α).
pub fn retained(centres: &Indicator) -> u64 {
    let [nx, ny, nz] = centres.grid().dims();
    let mut parent: Vec<u32> = vec![0];
    let mut below: Vec<(u32, u32, u32, u32)> = Vec::new();
    let mut kept = 0u64;
    for k in 0..nz {
        let mut layer: Vec<(u32, u32, u32, u32)> = Vec::new();
        let (mut previous, mut under) = (0, 0);
        for j in 0..ny as u32 {
            let first_of_row = layer.len();
            let row = centres.row(j as usize, k);
            let mut i = 0u32;
            while let Some((from, to)) = next_run(row, i, nx as u32) {
                // Set 0 is the outside: what touches a side or the bottom of the grid.
                let open = k == 0 || j == 0 || j + 1 == ny as u32 || from == 0 || to == nx as u32;
                let set = if open { 0 } else { parent.len() as u32 };
                if !open {
                    parent.push(set);
                }
                for (list, at, row) in [(&below, &mut under, j), (&layer, &mut previous, j.wrapping_sub(1))] {
                    while *at < list.len() && (list[*at].0 as i64, list[*at].2) <= (row as i32 as i64, from) {
                        *at += 1;
                    }
                    let mut n = *at;
                    while n < list.len() && list[n].0 == row && list[n].1 < to {
                        let (a, b) = (root(&mut parent, set), root(&mut parent, list[n].3));
                        parent[a.max(b) as usize] = a.min(b);
                        n += 1;
                    }
                }
                layer.push((j, from, to, set));
                i = to;
            }
            previous = previous.min(first_of_row);
        }
        for &(_, from, to, set) in &layer {
            if root(&mut parent, set) != 0 {
                kept += u64::from(to - from);
            }
        }
        below = layer;
    }
    kept
}

fn root(parent: &mut [u32], mut s: u32) -> u32 {
    while parent[s as usize] != s {
        parent[s as usize] = parent[parent[s as usize] as usize];
        s = parent[s as usize];
    }
    s
}

/// The next stretch of samples outside from a sample on.
fn next_run(row: &[u64], mut i: u32, nx: u32) -> Option<(u32, u32)> {
    let inside = |i: u32| row[(i / 64) as usize] >> (i % 64) & 1 == 1;
    while i < nx && inside(i) {
        i += 1;
    }
    let from = i;
    while i < nx && !inside(i) {
        i += 1;
    }
    (from < nx).then_some((from, i))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::units::Length;

    struct Lcg(u64);
    impl Lcg {
        fn next(&mut self) -> u64 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            self.0 >> 33
        }
    }

    fn sets() -> Vec<Indicator> {
        let mut rng = Lcg(9);
        [[5, 4, 3], [70, 5, 6], [64, 7, 4], [9, 9, 9]]
            .into_iter()
            .flat_map(|dims| [(dims, 2), (dims, 4), (dims, 7)])
            .map(|(dims, one_in)| {
                let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).unwrap();
                let mut set = Indicator::empty(grid);
                for at in 0..grid.samples() {
                    set.set(grid.index(at), rng.next().is_multiple_of(one_in));
                }
                set
            })
            .collect()
    }

    #[test]
    fn hidden_is_what_no_walk_in_26_directions_sees() {
        for set in sets() {
            let dims = set.grid().dims();
            let hidden = hidden_from_outside(&set).unwrap();
            for at in 0..set.grid().samples() {
                let index = set.grid().index(at);
                let clear = |d: [isize; 3]| {
                    let mut p = index.map(|c| c as isize);
                    loop {
                        p = [0, 1, 2].map(|a| p[a] + d[a]);
                        if (0..3).any(|a| p[a] < 0 || p[a] >= dims[a] as isize) {
                            return true;
                        }
                        if set.contains(p.map(|c| c as usize)) {
                            return false;
                        }
                    }
                };
                let steps = [-1isize, 0, 1];
                let any = steps
                    .iter()
                    .any(|&x| steps.iter().any(|&y| steps.iter().any(|&z| (x, y, z) != (0, 0, 0) && clear([x, y, z]))));
                assert_eq!(hidden.contains(index), !set.contains(index) && !any, "{index:?} {dims:?}");
            }
        }
    }

    #[test]
    fn retained_is_what_cannot_flow_down_and_out() {
        for set in sets() {
            let dims = set.grid().dims();
            let outside = |p: [isize; 3]| (0..3).any(|a| p[a] < 0 || p[a] >= dims[a] as isize);
            let mut expected = 0;
            for at in 0..set.grid().samples() {
                let start = set.grid().index(at);
                if set.contains(start) {
                    continue;
                }
                let mut seen = vec![false; set.grid().samples()];
                let mut open = vec![start];
                seen[at] = true;
                let mut drains = false;
                while let Some(p) = open.pop() {
                    for (axis, step) in [(0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1)] {
                        let mut q = p.map(|c| c as isize);
                        q[axis] += step;
                        if q[2] > start[2] as isize {
                            continue;
                        }
                        if outside(q) {
                            drains = true;
                            continue;
                        }
                        let q = q.map(|c| c as usize);
                        if !set.contains(q) && !seen[set.grid().offset(q)] {
                            seen[set.grid().offset(q)] = true;
                            open.push(q);
                        }
                    }
                }
                expected += u64::from(!drains);
            }
            assert_eq!(retained(&set), expected, "{dims:?}");
        }
    }
}
