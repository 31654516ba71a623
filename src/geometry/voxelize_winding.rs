//! Inside and outside of a surface that does not close, sample by sample where it must be.

use super::solid::Doubt;
use super::voxelize_crossings::set_range;
use super::winding::Winding;
use crate::grid::Grid;
use rayon::prelude::*;

/// Samples between two probes of a free stretch of a row.
const STRIDE: usize = 16;
/// A winding number this near to one half does not tell inside from outside.
const DOUBTFUL: f64 = 0.25;

/// Sets the bits of the samples with winding number ≥ ½ and returns what was in doubt.
///
/// Every sample whose cube a facet touches is evaluated. Off the surface the winding number is harmonic, so there a row
/// is probed every few samples and evaluated in full only between probes that differ or are in doubt.
pub(super) fn classify(winding: &Winding, grid: &Grid, shell: &[u64], centres: &mut [u64]) -> Doubt {
    let [nx, ny, _] = grid.dims();
    let words = nx.div_ceil(64);
    let rows = centres.par_chunks_mut(words).zip(shell.par_chunks(words)).enumerate();
    let tally = rows
        .map(|(row, (bits, shell))| {
            let mut tally = Tally { inside: 0, doubtful: 0, worst: f64::INFINITY, at: 0, winding: 0.0 };
            let mut probe = |i: usize| {
                let w = winding.at(grid.position([i, row % ny, row / ny]));
                tally.note(row * nx + i, w);
                w
            };
            classify_row(nx, shell, bits, &mut probe);
            tally.inside = bits.iter().map(|w| u64::from(w.count_ones())).sum();
            tally
        })
        .reduce(|| Tally { inside: 0, doubtful: 0, worst: f64::INFINITY, at: usize::MAX, winding: 0.0 }, Tally::joined);
    let share = tally.doubtful as f64 / (tally.inside + tally.doubtful).max(1) as f64;
    let place = if tally.at < grid.samples() { grid.index(tally.at) } else { [0; 3] };
    Doubt { share, at_mm: grid.position(place), winding: tally.winding }
}

/// Sets the bits of one row.
fn classify_row(nx: usize, shell: &[u64], bits: &mut [u64], probe: &mut impl FnMut(usize) -> f64) {
    let touched = |i: usize| shell[i / 64] >> (i % 64) & 1 == 1;
    let mut from = 0;
    while from < nx {
        let w = probe(from);
        let inside = w >= 0.5;
        let to = (from + 1..nx.min(from + STRIDE)).find(|&i| touched(i)).unwrap_or(nx.min(from + STRIDE));
        if touched(from) || to == from + 1 {
            if inside {
                set_range(bits, from, from + 1);
            }
            from += 1;
            continue;
        }
        let last = probe(to - 1);
        let sure = (w - 0.5).abs() >= DOUBTFUL && (last - 0.5).abs() >= DOUBTFUL;
        if sure && inside == (last >= 0.5) {
            if inside {
                set_range(bits, from, to);
            }
        } else {
            for i in from..to {
                let inside = if i == from {
                    inside
                } else if i == to - 1 {
                    last >= 0.5
                } else {
                    probe(i) >= 0.5
                };
                if inside {
                    set_range(bits, i, i + 1);
                }
            }
        }
        from = to;
    }
}

/// What a set of evaluations found; joined in any order it is the same.
struct Tally {
    inside: u64,
    doubtful: u64,
    /// Least |w − ½|, the first sample in storage where it occurs, and w there.
    worst: f64,
    at: usize,
    winding: f64,
}

impl Tally {
    fn note(&mut self, at: usize, winding: f64) {
        let off = (winding - 0.5).abs();
        self.doubtful += u64::from(off < DOUBTFUL);
        if off < self.worst || (off == self.worst && at < self.at) {
            (self.worst, self.at, self.winding) = (off, at, winding);
        }
    }

    fn joined(self, other: Tally) -> Tally {
        let (inside, doubtful) = (self.inside + other.inside, self.doubtful + other.doubtful);
        let nearer = other.worst < self.worst || (other.worst == self.worst && other.at < self.at);
        let worst = if nearer { other } else { self };
        Tally { inside, doubtful, ..worst }
    }
}
