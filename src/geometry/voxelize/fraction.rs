//! Exact solid fractions: each facet is clipped to the cubes that it crosses.
//!
//! Of a cube Q = [i, i+1] × C over the cell C of the (y, z)-plane, a facet piece P over C hides the part behind it from
//! the part before it. With the signed area A of P's shadow on the (y, z)-plane (positive where the facet looks along
//! +x) and its moment M = ∫ x dA, the integral of the winding number over Q changes by −(A·(i+1) − M), and over every
//! cube behind it by −A. Summing those changes along the row (divergence theorem, row by row) gives the integral of
//! the winding number over every cube, exactly but for rounding.

use super::lattice::Lattice;
use std::ops::Range;

/// Adds the changes that a facet makes to the running sums of the rows of `layers`.
///
/// `change` holds those layers in storage order. What lies before the grid changes the first cube of a row, what
/// lies behind it nothing.
pub(super) fn add(lattice: &Lattice, facet: u32, layers: Range<usize>, scratch: &mut Scratch, change: &mut [f32]) {
    let t = lattice.corners(facet);
    let [nx, ny, _] = lattice.dims;
    // Cube i is [i, i + 1]: exact, a lattice coordinate has at most 30 bits.
    let unit = 1.0 / f64::from(1u32 << lattice.bits);
    let Scratch { whole, slices, pieces } = scratch;
    whole.n = 3;
    for (to, from) in whole.p.iter_mut().zip(&t) {
        *to = from.map(|c| f64::from(c) * unit + 0.5);
    }
    if whole.shadow_and_moment(0.0).0 == 0.0 {
        return;
    }
    whole.for_each_slice(2, layers.clone(), slices, |k, slice| {
        slice.for_each_slice(1, 0..ny, pieces, |j, piece| {
            let at = ((k - layers.start) * ny + j) * nx;
            along_row(piece, &mut change[at..at + nx]);
        });
    });
}

/// Adds the changes of a piece that lies over one cell of the (y, z)-plane to the row behind that cell.
#[inline]
fn along_row(piece: &Polygon, change: &mut [f32]) {
    let nx = change.len();
    let (lo, hi) = piece.span(0);
    if lo >= nx as f64 {
        return;
    }
    let first = if lo > 0.0 { lo as usize } else { 0 };
    let x0 = first as f64;
    // Area and moment about x0 of what lies before the current cube; what lies before the grid counts as its area.
    let mut done = if lo < 0.0 { piece.below(0.0, x0) } else { (0.0, 0.0) };
    change[first] -= done.0 as f32;
    for i in first..nx {
        let end = (i + 1) as f64;
        let last = hi <= end;
        let upto = if last { piece.shadow_and_moment(x0) } else { piece.below(end, x0) };
        let (area, moment) = (upto.0 - done.0, upto.1 - done.1);
        let here = moment - area * (end - x0);
        change[i] += here as f32;
        if let Some(next) = change.get_mut(i + 1) {
            *next -= (area + here) as f32;
        }
        if last {
            break;
        }
        done = upto;
    }
}

/// Polygons to cut into, so that nothing is copied or cleared on the way.
#[derive(Default)]
pub(super) struct Scratch {
    whole: Polygon,
    slices: [Polygon; 3],
    pieces: [Polygon; 3],
}

/// Turns the changes along a row into solid fractions: running sums within the shell, 0 or 1 elsewhere.
///
/// Off the shell the integral of the winding number is a whole number, so rounding errors end with each stretch.
pub(super) fn settle(centres: &[u64], shell: &[u64], row: &mut [f32]) {
    let n = row.len();
    let (mut at, mut sum) = (0, 0.0f64);
    while at < n {
        let first = next(shell, at, n, 0);
        if first > at {
            sum = (sum + f64::from(row[at])).round();
            row[at] = 0.0;
            if centres[at / 64] >> (at % 64) & 1 == 1 {
                row[at..first].fill(1.0);
            }
        }
        at = next(shell, first, n, !0);
        for value in &mut row[first..at] {
            sum += f64::from(*value);
            *value = sum.clamp(0.0, 1.0) as f32;
        }
    }
}

/// The same where crossings may not add up: the sums start from the samples, and where a stretch of shell contradicts
/// the samples in it or behind it, those stand for their cubes.
pub(super) fn settle_open(centres: &[u64], shell: &[u64], row: &mut [f32]) {
    let n = row.len();
    let bit = |at: usize| (centres[at / 64] >> (at % 64) & 1) as f32;
    let mut at = 0;
    while at < n {
        let first = next(shell, at, n, 0);
        for (i, value) in (at..first).zip(&mut row[at..first]) {
            *value = bit(i);
        }
        at = next(shell, first, n, !0);
        let before = if first == 0 { 0.0 } else { bit(first - 1) };
        let behind = before + row[first..n.min(at + 1)].iter().sum::<f32>();
        let sums = |row: &[f32], i: usize, sum: &mut f32| {
            *sum += row[i];
            sum.clamp(0.0, 1.0)
        };
        let mut sum = before;
        let agree = (at == n || (behind - bit(at)).abs() < 0.25)
            && (first..at).all(|i| (sums(row, i, &mut sum) - bit(i)).abs() < 0.999);
        sum = before;
        for i in first..at {
            row[i] = if agree { sums(row, i, &mut sum) } else { bit(i) };
        }
    }
}

/// The first position from `at` on whose bit, exclusive-or with `flip`, is set; `n` if there is none.
#[inline]
pub(super) fn next(bits: &[u64], at: usize, n: usize, flip: u64) -> usize {
    let mut word = at / 64;
    let mut mask = !0u64 << (at % 64);
    while word * 64 < n {
        let found = (bits[word] ^ flip) & mask;
        if found != 0 {
            return (word * 64 + found.trailing_zeros() as usize).min(n);
        }
        (word, mask) = (word + 1, !0);
    }
    n
}

/// Most corners of a triangle cut by the six planes of a cube is nine; the rest is for rounding.
const CORNERS: usize = 12;

/// A convex polygon in space.
#[derive(Clone, Copy, Default)]
struct Polygon {
    n: usize,
    p: [[f64; 3]; CORNERS],
}

impl Polygon {
    #[inline]
    fn corners(&self) -> &[[f64; 3]] {
        &self.p[..self.n]
    }

    #[inline]
    fn push(&mut self, p: [f64; 3]) {
        if self.n < CORNERS {
            self.p[self.n] = p;
            self.n += 1;
        }
    }

    /// Least and greatest coordinate along an axis; for the empty polygon +∞ and −∞.
    #[inline]
    fn span(&self, axis: usize) -> (f64, f64) {
        self.corners().iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| {
            (if p[axis] < lo { p[axis] } else { lo }, if p[axis] > hi { p[axis] } else { hi })
        })
    }

    /// Cuts into the parts below and above a plane across an axis.
    #[inline]
    fn split(&self, axis: usize, at: f64, below: &mut Polygon, above: &mut Polygon) {
        (below.n, above.n) = (0, 0);
        let Some(mut a) = self.corners().last() else { return };
        for b in self.corners() {
            if let Some(cut) = cut(a, b, axis, at) {
                below.push(cut);
                above.push(cut);
            }
            if b[axis] <= at {
                below.push(*b);
            }
            if b[axis] >= at {
                above.push(*b);
            }
            a = b;
        }
    }

    /// Calls `visit(cell, piece)` for the pieces between the whole numbers of `cells`, in order.
    #[inline]
    fn for_each_slice(
        &self,
        axis: usize,
        cells: Range<usize>,
        scratch: &mut [Polygon; 3],
        mut visit: impl FnMut(usize, &Polygon),
    ) {
        let (lo, hi) = self.span(axis);
        if hi <= cells.start as f64 || lo >= cells.end as f64 {
            return;
        }
        let first = if lo <= cells.start as f64 { cells.start } else { lo as usize };
        let [piece, mut rest, mut above] = scratch.each_mut();
        let mut left = self;
        if lo < first as f64 {
            self.split(axis, first as f64, piece, rest);
            left = rest;
        }
        for cell in first..cells.end {
            let end = (cell + 1) as f64;
            if hi <= end {
                return visit(cell, left);
            }
            left.split(axis, end, piece, above);
            if piece.n >= 3 {
                visit(cell, piece);
            }
            std::mem::swap(&mut rest, &mut above);
            left = rest;
        }
    }

    /// Signed area A of the shadow on the (y, z)-plane and ∫ (x − x0) dA.
    #[inline]
    fn shadow_and_moment(&self, x0: f64) -> (f64, f64) {
        let mut fan = Fan::new(x0);
        self.corners().iter().for_each(|p| fan.corner(p));
        fan.finish()
    }

    /// The same for the part with x ≤ `at`.
    #[inline]
    fn below(&self, at: f64, x0: f64) -> (f64, f64) {
        let mut fan = Fan::new(x0);
        let Some(mut a) = self.corners().last() else { return (0.0, 0.0) };
        for b in self.corners() {
            if let Some(cut) = cut(a, b, 0, at) {
                fan.corner(&cut);
            }
            if b[0] <= at {
                fan.corner(b);
            }
            a = b;
        }
        fan.finish()
    }
}

/// Where an edge passes through a plane across an axis, if its ends lie on different sides.
///
/// Reckoned from the lower end, so that both facets of an edge cut it alike.
#[inline]
fn cut(a: &[f64; 3], b: &[f64; 3], axis: usize, at: f64) -> Option<[f64; 3]> {
    let (from, to) = if a[axis] < at && b[axis] > at {
        (a, b)
    } else if a[axis] > at && b[axis] < at {
        (b, a)
    } else {
        return None;
    };
    let s = (at - from[axis]) / (to[axis] - from[axis]);
    let mut cut = [0, 1, 2].map(|c| from[c] + s * (to[c] - from[c]));
    cut[axis] = at;
    Some(cut)
}

/// Area and moment of a polygon whose corners come one by one.
struct Fan {
    x0: f64,
    first: [f64; 3],
    previous: [f64; 3],
    seen: usize,
    area: f64,
    moment: f64,
}

impl Fan {
    #[inline]
    fn new(x0: f64) -> Self {
        Fan { x0, first: [0.0; 3], previous: [0.0; 3], seen: 0, area: 0.0, moment: 0.0 }
    }

    #[inline]
    fn corner(&mut self, &[x, y, z]: &[f64; 3]) {
        self.seen += 1;
        if self.seen == 1 {
            self.first = [x - self.x0, y, z];
            return;
        }
        let [x, y, z] = [x - self.x0, y - self.first[1], z - self.first[2]];
        if self.seen > 2 {
            let twice = self.previous[1] * z - self.previous[2] * y;
            self.area += twice;
            self.moment += twice * (self.first[0] + self.previous[0] + x);
        }
        self.previous = [x, y, z];
    }

    #[inline]
    fn finish(&self) -> (f64, f64) {
        (0.5 * self.area, self.moment / 6.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splitting_keeps_area_and_moment() {
        let mut p = Polygon { n: 3, p: [[0.0; 3]; CORNERS] };
        p.p[0] = [0.2, 0.1, 0.3];
        p.p[1] = [3.7, 2.9, 0.4];
        p.p[2] = [1.1, 0.6, 5.2];
        let (area, moment) = p.shadow_and_moment(0.0);
        let (mut areas, mut moments, mut pieces) = (0.0, 0.0, 0);
        let mut scratch = Scratch::default();
        p.for_each_slice(2, 0..6, &mut scratch.slices, |k, slice| {
            slice.for_each_slice(1, 0..3, &mut scratch.pieces, |j, piece| {
                let (a, m) = piece.shadow_and_moment(0.0);
                let ((y0, y1), (z0, z1)) = (piece.span(1), piece.span(2));
                assert!(y0 >= j as f64 && y1 <= (j + 1) as f64 && z0 >= k as f64 && z1 <= (k + 1) as f64);
                (areas, moments, pieces) = (areas + a, moments + m, pieces + 1);
            });
        });
        assert!(pieces > 6 && (areas - area).abs() < 1e-14 && (moments - moment).abs() < 1e-14);
    }
}
