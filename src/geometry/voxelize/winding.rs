//! Inside and outside of a surface that does not close, sample by sample where it must be.
//!
//! Off the surface the winding number is harmonic: bundles of rows that no facet touches are probed every few samples. Between probes
//! that differ or are in doubt they are halved until a part of them is told by its middle, for the rim of the surface bounds how much
//! the number changes there. Through the shell the crossings of the row are counted from one known side to the other; where they do not
//! add up, the samples are evaluated.

use super::crossings::{Crossings, set_range};
use crate::geometry::rim::Rim;
use crate::geometry::vector::{Vec3, norm};
use crate::geometry::{Doubt, TriangleMesh, Winding};
use crate::grid::Grid;
use rayon::prelude::*;
use std::ops::Range;

/// Rows along y and along z that are probed together.
pub(super) const BUNDLE: usize = 4;
/// Samples between two probes of a bundle.
const STRIDE: usize = 16;
/// Samples in a row within the shell that are believed to the crossings alone.
const TRUSTED: usize = 3;
/// A winding number this near to one half does not tell inside from outside.
const DOUBTFUL: f64 = 0.25;
/// Samples that are evaluated one by one.
const FEW: usize = 8;

/// Sets the bits of the samples with winding number ≥ ½ and returns what was in doubt.
///
/// `crossings` are those of the facets, [`BUNDLE`] layers to a slab, and `shell` the cubes that they touch.
pub(super) fn classify(
    mesh: &TriangleMesh,
    crossings: &Crossings,
    grid: &Grid,
    shell: &[u64],
    centres: &mut [u64],
) -> Doubt {
    let [nx, ny, _] = grid.dims();
    let (winding, rim) = (&Winding::new(mesh), &Rim::of(mesh));
    let words = nx.div_ceil(64);
    let slab = words * ny * BUNDLE;
    let slabs = centres.par_chunks_mut(slab).zip(shell.par_chunks(slab)).enumerate().with_max_len(1);
    let tally = slabs
        .map(|(at, (centres, shell))| {
            let first_row = at * BUNDLE * ny;
            let mut slab = Slab { winding, rim, grid, first_row, words, shell, centres, tally: Tally::default() };
            let mut known = vec![0u64; shell.len()];
            slab.bundles(&mut known);
            slab.free_runs(&known);
            slab.shell_runs(&crossings.sorted(at));
            slab.tally.inside = slab.centres.iter().map(|w| u64::from(w.count_ones())).sum();
            slab.tally
        })
        .reduce(Tally::default, Tally::joined);
    let share = tally.doubtful as f64 / (tally.inside + tally.doubtful).max(1) as f64;
    let place = if tally.at < grid.samples() { grid.index(tally.at) } else { [0; 3] };
    let corners = if share > 0.0 { [tally.lo, tally.hi] } else { [place; 2] };
    let [lo, hi] = corners.map(|index| grid.position(index));
    let volume_mm3 = tally.doubtful as f64 * grid.sample_volume().as_mm3();
    Doubt { share, volume_mm3, at_mm: grid.position(place), winding: tally.winding, extent: (lo, hi) }
}

/// A few layers in the making.
struct Slab<'a> {
    winding: &'a Winding,
    rim: &'a Rim,
    grid: &'a Grid,
    first_row: usize,
    words: usize,
    shell: &'a [u64],
    centres: &'a mut [u64],
    tally: Tally,
}

impl Slab<'_> {
    fn nx(&self) -> usize {
        self.grid.dims()[0]
    }

    /// Rows of the slab.
    fn rows(&self) -> usize {
        self.shell.len() / self.words
    }

    fn bits(&self, row: usize) -> Range<usize> {
        row * self.words..(row + 1) * self.words
    }

    fn inside(&self, row: usize, i: usize) -> bool {
        bit(&self.centres[self.bits(row)], i)
    }

    fn index(&self, row: usize, i: usize) -> [usize; 3] {
        let ny = self.grid.dims()[1];
        let row = self.first_row + row;
        [i, row % ny, row / ny]
    }

    /// The winding number at a sample; of those seen, the one nearest to one half is kept, where no facet touches its cube: a touched one is
    /// uncertain by its sets already.
    fn evaluate(&mut self, row: usize, i: usize) -> f64 {
        let index = self.index(row, i);
        let w = self.winding.at(self.grid.position(index));
        if !bit(&self.shell[self.bits(row)], i) {
            self.tally.see(self.grid.offset(index), w);
        }
        w
    }

    /// Evaluates every sample of a range, in the shell or not.
    fn evaluate_all(&mut self, row: usize, range: Range<usize>) {
        for i in range {
            let w = self.evaluate(row, i);
            let bits = self.bits(row);
            let touched = bit(&self.shell[bits.clone()], i);
            if w >= 0.5 {
                set_range(&mut self.centres[bits], i, i + 1);
            }
            if !touched && is_doubtful(w) {
                self.tally.doubt([self.index(row, i); 2], 1);
            }
        }
    }

    /// Decides a stretch of rows that no facet touches: at once where its middle leaves no other answer, else half by half.
    fn settle(&mut self, rows: &[usize], range: Range<usize>) {
        if rows.len() * range.len() <= FEW {
            rows.iter().for_each(|&row| self.evaluate_all(row, range.clone()));
            return;
        }
        let (middle, i) = (rows[rows.len() / 2], range.start + range.len() / 2);
        let w = self.evaluate(middle, i);
        let levels = [0.5 - DOUBTFUL, 0.5, 0.5 + DOUBTFUL];
        let apart = levels.into_iter().map(|level| (w - level).abs()).fold(f64::INFINITY, f64::min);
        // By as much as one evaluation may be off, its neighbours' may be as well.
        let (from, radius) = self.about([middle, i], rows, &range);
        if self.rim.change(from, radius) < apart {
            if w >= 0.5 {
                self.set_all(rows, range.clone());
            }
            if is_doubtful(w) {
                let corners = self.corners(rows, &range);
                self.tally.doubt(corners, (rows.len() * range.len()) as u64);
            }
        } else if range.len() >= rows.len() {
            self.settle(rows, range.start..i);
            self.settle(rows, i..range.end);
        } else {
            let (some, others) = rows.split_at(rows.len() / 2);
            self.settle(some, range.clone());
            self.settle(others, range);
        }
    }

    /// Least and greatest indices of a stretch of rows.
    fn corners(&self, rows: &[usize], range: &Range<usize>) -> [[usize; 3]; 2] {
        let ends = rows.iter().flat_map(|&row| [self.index(row, range.start), self.index(row, range.end - 1)]);
        ends.fold([[usize::MAX; 3], [0; 3]], |[lo, hi], at| {
            [[0, 1, 2].map(|a| lo[a].min(at[a])), [0, 1, 2].map(|a| hi[a].max(at[a]))]
        })
    }

    /// The place of a sample, and how far from it those of a stretch of rows lie at most.
    fn about(&self, [row, i]: [usize; 2], rows: &[usize], range: &Range<usize>) -> (Vec3, f64) {
        let from = self.grid.position(self.index(row, i));
        let [lo, hi] = self.corners(rows, range).map(|index| self.grid.position(index));
        let farthest = [0, 1, 2].map(|a| (from[a] - lo[a]).max(hi[a] - from[a]));
        (from, norm(farthest))
    }

    fn set_all(&mut self, rows: &[usize], range: Range<usize>) {
        for &row in rows {
            let bits = self.bits(row);
            set_range(&mut self.centres[bits], range.start, range.end);
        }
    }

    /// Decides the stretches that are free of the shell in all rows of a bundle, and marks them as known.
    fn bundles(&mut self, known: &mut [u64]) {
        let ny = self.grid.dims()[1];
        let layers = self.rows() / ny;
        for j in (0..ny).step_by(BUNDLE) {
            let deep = BUNDLE.min(ny - j);
            let rows: Vec<usize> = (0..layers).flat_map(|k| (k * ny + j)..(k * ny + j + deep)).collect();
            let mut touched = vec![0u64; self.words];
            for &row in &rows {
                touched.iter_mut().zip(&self.shell[self.bits(row)]).for_each(|(t, s)| *t |= s);
            }
            let middle = rows[rows.len() / 2];
            for free in runs(&touched, self.nx(), 0) {
                for &row in &rows {
                    let bits = self.bits(row);
                    set_range(&mut known[bits], free.start, free.end);
                }
                self.probe(&rows, middle, free);
            }
        }
    }

    /// Decides one free stretch of a bundle from probes along one of its rows.
    fn probe(&mut self, rows: &[usize], middle: usize, free: Range<usize>) {
        let mut from = free.start;
        let mut before = self.evaluate(middle, from);
        loop {
            let to = (from + STRIDE).min(free.end - 1);
            let behind = if to > from { self.evaluate(middle, to) } else { before };
            let clear = (before - 0.5).abs() >= DOUBTFUL && (behind - 0.5).abs() >= DOUBTFUL;
            // The last probe belongs to the next stretch, and to this one if there is none.
            let range = from..if to == free.end - 1 { free.end } else { to };
            if !clear || (before >= 0.5) != (behind >= 0.5) {
                self.settle(rows, range.clone());
            } else if before >= 0.5 {
                self.set_all(rows, range.clone());
            }
            if range.end == free.end {
                return;
            }
            (from, before) = (to, behind);
        }
    }

    /// Decides what is free in a row but not in its bundle: like the known samples of the same run if they agree and are
    /// near, else by probes of its own.
    fn free_runs(&mut self, known: &[u64]) {
        for row in 0..self.rows() {
            for free in runs(&self.shell[self.bits(row)], self.nx(), 0) {
                let decided = &known[self.bits(row)];
                let gaps: Vec<Range<usize>> =
                    runs(decided, free.end, 0).map(|gap| gap.start.max(free.start)..gap.end).collect();
                for gap in gaps.into_iter().filter(|gap| gap.start < gap.end) {
                    let before = (gap.start > free.start).then(|| self.inside(row, gap.start - 1));
                    let behind = (gap.end < free.end).then(|| self.inside(row, gap.end));
                    match (before, behind) {
                        (Some(a), Some(b)) if a != b => self.settle(&[row], gap),
                        (None, None) => self.probe(&[row], row, gap),
                        _ if gap.len() > STRIDE => self.probe(&[row], row, gap),
                        (Some(true), _) | (_, Some(true)) => self.set_all(&[row], gap),
                        _ => {}
                    }
                }
            }
        }
    }

    /// Decides the shell by counting crossings from what is known before it to what is known behind it.
    fn shell_runs(&mut self, events: &[u64]) {
        let nx = self.nx();
        for row in 0..self.rows() {
            let number = (self.first_row + row) as u64;
            let first = events.partition_point(|event| event >> 32 < number);
            let last = events.partition_point(|event| event >> 32 <= number);
            let events = &events[first..last];
            let stretches: Vec<Range<usize>> = runs(&self.shell[self.bits(row)], nx, !0).collect();
            for stretch in stretches {
                let before = (stretch.start > 0).then(|| i64::from(self.inside(row, stretch.start - 1)));
                let behind = (stretch.end < nx).then(|| i64::from(self.inside(row, stretch.end)));
                let step = |event: &u64| 1 - 2 * (event & 1) as i64;
                let place = |event: &u64| (*event as u32 >> 1) as usize;
                let here: Vec<u64> =
                    events.iter().copied().filter(|e| (stretch.start..=stretch.end).contains(&place(e))).collect();
                let total: i64 = here.iter().map(step).sum();
                let start = match (before, behind) {
                    (Some(a), Some(b)) if a + total == b => Some(a),
                    (Some(a), None) => Some(a),
                    // What lies before the grid is counted at its first sample.
                    (None, Some(b)) => Some(b - total),
                    _ => None,
                };
                // A count beyond one body, or below none, says that the start was wrong.
                let mut count = start.unwrap_or(-1);
                let mut sound = (0..=1).contains(&count) || before.is_none();
                for (n, event) in here.iter().enumerate() {
                    count += step(event);
                    let settled = here.get(n + 1).is_none_or(|next| place(next) > place(event));
                    sound &= !settled || (0..=1).contains(&count);
                }
                match start {
                    Some(start) if sound => {
                        self.count_through(row, stretch.clone(), start, &here);
                        // Along a facet nothing is crossed, at its open end neither: long stretches are probed.
                        let mut probes = stretch.clone().skip(TRUSTED).step_by(TRUSTED + 1);
                        if probes.any(|i| self.inside(row, i) != (self.evaluate(row, i) >= 0.5)) {
                            let bits = self.bits(row);
                            clear_range(&mut self.centres[bits], stretch.clone());
                            self.evaluate_all(row, stretch);
                        }
                    }
                    _ => self.evaluate_all(row, stretch),
                }
            }
        }
    }

    /// Sets the samples of a stretch where the running count is positive.
    fn count_through(&mut self, row: usize, stretch: Range<usize>, start: i64, events: &[u64]) {
        let bits = self.bits(row);
        let (mut count, mut from) = (start, stretch.start);
        for &event in events {
            let at = ((event as u32 >> 1) as usize).clamp(stretch.start, stretch.end);
            if count >= 1 {
                set_range(&mut self.centres[bits.clone()], from, at);
            }
            count += 1 - 2 * (event & 1) as i64;
            from = at;
        }
        if count >= 1 {
            set_range(&mut self.centres[bits], from, stretch.end);
        }
    }
}

fn clear_range(bits: &mut [u64], range: Range<usize>) {
    range.for_each(|i| bits[i / 64] &= !(1 << (i % 64)));
}

fn bit(bits: &[u64], i: usize) -> bool {
    bits[i / 64] >> (i % 64) & 1 == 1
}

/// The maximal stretches below `n` whose bits, exclusive-or with `flip`, are 0.
fn runs(bits: &[u64], n: usize, flip: u64) -> impl Iterator<Item = Range<usize>> + '_ {
    let next = move |at: usize, flip: u64| super::fraction::next(bits, at, n, flip);
    let mut at = 0;
    std::iter::from_fn(move || {
        let from = next(at, !flip);
        at = next(from, flip);
        (from < n).then_some(from..at)
    })
}

fn is_doubtful(winding: f64) -> bool {
    (winding - 0.5).abs() < DOUBTFUL
}

/// What a set of evaluations found; joined in any order it is the same.
struct Tally {
    inside: u64,
    doubtful: u64,
    /// Least and greatest indices of what is in doubt.
    lo: [usize; 3],
    hi: [usize; 3],
    /// Least |w − ½|, the first sample in storage where it occurs, and w there.
    worst: f64,
    at: usize,
    winding: f64,
}

impl Default for Tally {
    fn default() -> Self {
        let (lo, hi) = ([usize::MAX; 3], [0; 3]);
        Tally { inside: 0, doubtful: 0, lo, hi, worst: f64::INFINITY, at: usize::MAX, winding: 0.0 }
    }
}

impl Tally {
    /// A sample that was evaluated.
    fn see(&mut self, at: usize, winding: f64) {
        let off = (winding - 0.5).abs();
        if off < self.worst || (off == self.worst && at < self.at) {
            (self.worst, self.at, self.winding) = (off, at, winding);
        }
    }

    /// So many samples between two corners that are in doubt.
    fn doubt(&mut self, [lo, hi]: [[usize; 3]; 2], samples: u64) {
        self.doubtful += samples;
        self.lo = [0, 1, 2].map(|a| self.lo[a].min(lo[a]));
        self.hi = [0, 1, 2].map(|a| self.hi[a].max(hi[a]));
    }

    fn joined(self, other: Tally) -> Tally {
        let (inside, doubtful) = (self.inside + other.inside, self.doubtful + other.doubtful);
        let nearer = other.worst < self.worst || (other.worst == self.worst && other.at < self.at);
        let lo = [0, 1, 2].map(|a| self.lo[a].min(other.lo[a]));
        let hi = [0, 1, 2].map(|a| self.hi[a].max(other.hi[a]));
        let worst = if nearer { other } else { self };
        Tally { inside, doubtful, lo, hi, ..worst }
    }
}
