//! The conservative shell: every cube of the grid that a facet may touch.
//!
//! Separating axes of a triangle and a cube (Akenine-Möller 2001) arranged as a plane slab and three edge tests in
//! each coordinate plane (Schwarz and Seidel 2010), so that a row of cubes is an interval test.

use super::crossings::set_range;
use super::lattice::{Lattice, ceil_shift, span};
use std::ops::Range;

/// Sets the bits of all cubes of the layers `layers` that come within one lattice unit of the facet, along each axis.
///
/// The unit covers the rounding of the corners (half a unit), so the cubes that the facet of the mesh touches, its
/// boundary included, are all among them. `words` are the bit rows of those layers.
pub(super) fn mark(lattice: &Lattice, facet: u32, layers: Range<usize>, words: &mut [u64]) {
    let t = lattice.corners(facet);
    let near = [0, 1, 2].map(|axis| touched(&t, axis, lattice.bits));
    let cut = |axis: usize, cells: Range<usize>| {
        (near[axis].0.max(cells.start as i32), near[axis].1.min(cells.end as i32 - 1))
    };
    let (x, y, z) = (cut(0, 0..lattice.dims[0]), cut(1, 0..lattice.dims[1]), cut(2, layers.clone()));
    if x.0 > x.1 || y.0 > y.1 || z.0 > z.1 {
        return;
    }
    let words_per_row = lattice.dims[0].div_ceil(64);
    let row = |j: i32, k: i32| {
        let at = ((k as usize - layers.start) * lattice.dims[1] + j as usize) * words_per_row;
        at..at + words_per_row
    };
    // A connected set whose box is one cube thick along two axes touches every cube along the third.
    let thick = near.iter().filter(|(lo, hi)| lo < hi).count();
    if thick <= 1 {
        for k in z.0..=z.1 {
            for j in y.0..=y.1 {
                set_range(&mut words[row(j, k)], x.0 as usize, x.1 as usize + 1);
            }
        }
        return;
    }
    let tests = Separation::new(&t, near.map(|(lo, hi)| lo == hi), lattice.bits);
    for k in z.0..=z.1 {
        for j in y.0..=y.1 {
            if !tests.across.iter().all(|e| e.reaches(j, k)) {
                continue;
            }
            let (lo, hi) = tests.plane.interval(j, k, x);
            let (top, side) = (tests.top.map(|e| e.along_a(j)), tests.side.map(|e| e.along_b(k)));
            let meets = |i: i32| top.iter().chain(&side).all(|(step, start)| step * i64::from(i) + start >= 0);
            // Each test leaves an interval of the row, and so do all of them together.
            let Some(first) = (lo..=hi).find(|&i| meets(i)) else { continue };
            let last = (first..=hi).rev().find(|&i| meets(i)).unwrap_or(first);
            set_range(&mut words[row(j, k)], first as usize, last as usize + 1);
        }
    }
}

/// First and last cube along an axis that come within one unit of the facet's box.
fn touched(t: &[[i32; 3]; 3], axis: usize, bits: u32) -> (i32, i32) {
    let (lo, hi) = span(t, axis);
    let reach = (1 << (bits - 1)) + 1;
    (ceil_shift(lo - reach, bits), (hi + reach) >> bits)
}

/// The separating axes that are not coordinate axes.
struct Separation {
    /// Edges seen along x, over (y, z).
    across: [EdgeReach; 3],
    /// Edges seen along z, over (x, y).
    top: [EdgeReach; 3],
    /// Edges seen along y, over (z, x).
    side: [EdgeReach; 3],
    plane: PlaneReach,
}

impl Separation {
    /// The axes that can separate a facet, whose box is one cube thick along the axes `thin`, from a cube of that box.
    ///
    /// Where the box is one cube thick along an axis, a cube is met if and only if its shadow along that axis is.
    fn new(t: &[[i32; 3]; 3], thin: [bool; 3], bits: u32) -> Self {
        let v = t.map(|p| p.map(i64::from));
        let seen = |a: usize, b: usize| {
            if thin[a] || thin[b] {
                [EdgeReach::ALWAYS; 3]
            } else {
                EdgeReach::of_triangle([[v[0][a], v[0][b]], [v[1][a], v[1][b]], [v[2][a], v[2][b]]], bits)
            }
        };
        let plane = if thin.contains(&true) { PlaneReach::ALWAYS } else { PlaneReach::new(&v, bits) };
        Separation { across: seen(1, 2), top: seen(0, 1), side: seen(2, 0), plane }
    }
}

/// Whether a square comes to the triangle's side of one of its edges, in a coordinate plane.
#[derive(Clone, Copy)]
struct EdgeReach {
    da: i64,
    db: i64,
    /// The edge function at the origin plus the most it changes within a cube widened by one unit.
    start: i64,
}

impl EdgeReach {
    const ALWAYS: EdgeReach = EdgeReach { da: 0, db: 0, start: 0 };

    /// The three edges of a triangle; for a triangle without area both sides of its line must be within reach, which
    /// the same three tests express since its edges run both ways.
    fn of_triangle(v: [[i64; 2]; 3], bits: u32) -> [Self; 3] {
        let area = (v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[1][1] - v[0][1]) * (v[2][0] - v[0][0]);
        let v = if area < 0 { [v[0], v[2], v[1]] } else { v };
        let reach = (1i64 << (bits - 1)) + 1;
        let edge = |e: usize| {
            let ([a0, b0], [a1, b1]) = (v[e], v[(e + 1) % 3]);
            let (da, db) = (a1 - a0, b1 - b0);
            // E(a, b) = da·(b − b0) − db·(a − a0), positive on the triangle's side.
            let start = db * a0 - da * b0 + reach * (da.abs() + db.abs());
            EdgeReach { da: da << bits, db: db << bits, start }
        };
        [edge(0), edge(1), edge(2)]
    }

    /// Slope and value at 0 along the first axis, at `b` on the second: the square is reached where they are not negative.
    #[inline]
    fn along_a(&self, b: i32) -> (i64, i64) {
        (-self.db, self.da * i64::from(b) + self.start)
    }

    /// Slope and value at 0 along the second axis, at `a` on the first.
    #[inline]
    fn along_b(&self, a: i32) -> (i64, i64) {
        (self.da, self.start - self.db * i64::from(a))
    }

    #[inline]
    fn reaches(&self, a: i32, b: i32) -> bool {
        let (step, start) = self.along_b(a);
        step * i64::from(b) + start >= 0
    }
}

/// Cubes that the plane of a facet cuts.
///
/// In floating point with its rounding error added to the reach: a cube in doubt counts as cut.
struct PlaneReach {
    normal: [f64; 3],
    /// 1 / n_x, not used where n_x is 0.
    inverse: f64,
    /// n·v0, in units of spacings.
    offset: f64,
    reach: f64,
}

impl PlaneReach {
    const ALWAYS: PlaneReach = PlaneReach { normal: [0.0; 3], inverse: 0.0, offset: 0.0, reach: 0.0 };

    fn new(v: &[[i64; 3]; 3], bits: u32) -> Self {
        let d = |p: usize, axis: usize| v[p][axis] - v[0][axis];
        let minor = |a: usize, b: usize| (d(1, a) * d(2, b) - d(1, b) * d(2, a)) as f64;
        let normal = [minor(1, 2), minor(2, 0), minor(0, 1)];
        let unit = 1.0 / f64::from(1u32 << bits);
        let p = v[0].map(|c| c as f64 * unit);
        let size: f64 = normal.iter().map(|n| n.abs()).sum();
        let offset = normal[0] * p[0] + normal[1] * p[1] + normal[2] * p[2];
        // Every product is below |n|₁·2^25 spacings and has passed at most 8 roundings of 2^-53: below |n|₁·2^-24;
        // |n|₁·2^-20 is added. One unit of slack is |n|₁·2^-bits, at least 2^-16.
        let reach = size * (0.5 + unit + 1.0 / f64::from(1u32 << 20));
        PlaneReach { normal, inverse: 1.0 / normal[0], offset, reach }
    }

    /// The cubes of row (j, k) between `x.0` and `x.1` that the plane cuts: a superset, exact to rounding.
    #[inline]
    fn interval(&self, j: i32, k: i32, x: (i32, i32)) -> (i32, i32) {
        let rest = self.offset - self.normal[1] * f64::from(j) - self.normal[2] * f64::from(k);
        if self.normal[0] == 0.0 {
            return if rest.abs() <= self.reach { x } else { (1, 0) };
        }
        let (a, b) = ((rest - self.reach) * self.inverse, (rest + self.reach) * self.inverse);
        let (lo, hi) = if a < b { (a, b) } else { (b, a) };
        // Outward by a hair, since these products round as well.
        let hair = 1.0 / f64::from(1u32 << 20);
        let (least, most) = (f64::from(x.0), f64::from(x.1));
        // Cut to one beyond either end, so that an empty interval stays empty and a far one stays a number.
        (-floor(-(lo - hair).clamp(least, most + 1.0)), floor((hi + hair).clamp(least - 1.0, most)))
    }
}

/// ⌊x⌋ for what fits; a call less than the library's.
#[inline]
fn floor(x: f64) -> i32 {
    let whole = x as i32;
    whole - i32::from(f64::from(whole) > x)
}
