//! Counts of set samples in the columns of an element's height, layer after layer.

use crate::field::Indicator;

/// The columns of samples that stand on one layer of a set, as high as an element.
pub(super) struct Columns<'a> {
    pub set: &'a Indicator,
    /// Of the element.
    wide: usize,
    high: usize,
    pub ny: usize,
    pub words: usize,
    /// Samples of a row, and a word more, so that what an element reaches beyond the row is nothing.
    pub pitch: usize,
    /// The layer that the columns stand on.
    k: usize,
    /// Samples in each column.
    counts: Vec<u8>,
    /// For each word the columns that hold anything and those that are full, and with what a row of the element reaches of the next.
    held: Vec<(u64, u64)>,
    pub ends: Vec<(u64, u64)>,
    /// Samples in the columns of a row before each of its columns, modulo 2¹⁶, for the rows that were summed.
    pub before: Vec<u16>,
    summed: Vec<bool>,
}

impl<'a> Columns<'a> {
    /// The columns that stand on a layer, for an element so wide and high.
    #[inline(always)]
    pub fn on(set: &'a Indicator, k: usize, (wide, high): (usize, usize)) -> Self {
        let (ny, words) = (set.grid().dims()[1], set.words_per_row());
        let pitch = 64 * (words + 1);
        let (counts, before) = (vec![0; ny * pitch], vec![0; ny * pitch]);
        let (held, ends, summed) = (vec![(0, 0); ny * words], vec![(0, 0); ny * words], vec![false; ny]);
        let mut columns = Columns { set, wide, high, ny, words, pitch, k, counts, held, ends, before, summed };
        (k..k + high).for_each(|z| columns.exchange(None, z));
        (0..ny * words).for_each(|at| columns.held[at] = columns.held_in(at));
        columns.find_ends();
        columns
    }

    /// Goes on to the columns that stand on the next layer.
    #[inline(always)]
    pub fn rise(&mut self) {
        self.k += 1;
        self.exchange(Some(self.k - 1), self.k + self.high - 1);
        self.summed.fill(false);
        self.find_ends();
    }

    /// The words of a layer; none if the set has no such layer.
    #[inline(always)]
    fn layer(&self, z: usize) -> &'a [u64] {
        let words = self.words * self.ny;
        self.set.words().get(z * words..(z + 1) * words).unwrap_or_default()
    }

    /// Takes one layer out of the columns and puts another in.
    #[inline(always)]
    fn exchange(&mut self, out: Option<usize>, new: usize) {
        let (out, new) = (out.map_or(&[][..], |z| self.layer(z)), self.layer(new));
        for y in 0..self.ny {
            for w in 0..self.words {
                let at = y * self.words + w;
                let (leaves, comes) = (out.get(at).copied().unwrap_or(0), new.get(at).copied().unwrap_or(0));
                // What leaves and comes alike changes nothing.
                if leaves != comes {
                    let first = y * self.pitch + 64 * w;
                    exchange_bits(leaves, comes, &mut self.counts[first..first + 64]);
                    self.held[at] = self.held_in(at);
                }
            }
        }
    }

    /// The columns of a word that hold anything, and those that are full.
    #[inline(always)]
    fn held_in(&self, at: usize) -> (u64, u64) {
        let mut held = (0u64, !0u64);
        for z in self.k..self.k + self.high {
            let bits = self.layer(z).get(at).copied().unwrap_or(0);
            held = (held.0 | bits, held.1 & bits);
        }
        held
    }

    /// Joins to what each word holds what an element in it reaches of the next.
    #[inline(always)]
    fn find_ends(&mut self) {
        let spill = !(!0u64 << self.wide);
        for (ends, held) in self.ends.chunks_mut(self.words).zip(self.held.chunks(self.words)) {
            for w in 0..self.words {
                let (any, all) = held.get(w + 1).copied().unwrap_or((0, 0));
                ends[w] = (held[w].0 | (any & spill), held[w].1 & (all | !spill));
            }
        }
    }

    /// Sums a row along x, unless that is done.
    #[inline(always)]
    pub fn sum_row(&mut self, y: usize) {
        if std::mem::replace(&mut self.summed[y], true) {
            return;
        }
        let row = y * self.pitch..(y + 1) * self.pitch;
        let mut sum = 0u16;
        for (before, count) in self.before[row.clone()].iter_mut().zip(&self.counts[row]) {
            *before = sum;
            sum = sum.wrapping_add(u16::from(*count));
        }
    }
}

/// Takes the bits of one word from sixty-four counts and adds those of another.
#[inline(always)]
fn exchange_bits(leaves: u64, comes: u64, counts: &mut [u8]) {
    for (at, eight) in counts.chunks_exact_mut(8).enumerate() {
        let bits = |of: u64| eight_bytes((of >> (8 * at)) as u8);
        let mut bytes = [0; 8];
        bytes.copy_from_slice(eight);
        // No byte borrows: what leaves was counted. None carries: no column is higher than a byte counts.
        let counts = u64::from_le_bytes(bytes) - bits(leaves) + bits(comes);
        eight.copy_from_slice(&counts.to_le_bytes());
    }
}

/// Each bit of a byte as a byte of its own.
#[inline(always)]
fn eight_bytes(bits: u8) -> u64 {
    // Eight copies of the byte, one bit kept in each, moved down to 1.
    let kept = u64::from(bits).wrapping_mul(0x0101_0101_0101_0101) & 0x8040_2010_0804_0201;
    kept.wrapping_add(0x7f7f_7f7f_7f7f_7f7f) >> 7 & 0x0101_0101_0101_0101
}
