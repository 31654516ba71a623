//! Lower envelopes of parabolas along a panel of neighbouring lines: the step that every transform here repeats.

use std::ops::Range;

/// Lines that are worked on together; neighbours along x, so that a row of a panel is one cache line.
pub(super) const LANES: usize = 16;

/// One value for each line of a panel.
pub(super) type Row = [u32; LANES];

/// Bits of a packed value: as a float's bit pattern it is then positive and finite, and floats compare like integers.
const PACKED_BITS: u32 = 30;

/// Lower envelopes e(y) = min over s of f(s) + (y − s)² of the lines of a panel, y in `1..=n`, s in `0..=n + 1`.
///
/// The leftmost minimizing s does not decrease with y (the matrix f(s) + (y − s)² is totally monotone), so the rows are
/// found by halving: each looks for its minimum between those of its two neighbours on the coarser level, and no
/// farther than √f(y), in all lines at once. That is O(n log n) for a line, without a branch on data.
/// A value and the number of its site share one word, so that one minimum yields both. Where so many sites share a number that
/// it tells little of where the minimum lies, as on axes of thousands of samples, envelopes are found line by line instead.
pub(super) struct Panel {
    n: usize,
    /// Bits for the number of the site; where they are too few, sites share a number.
    index_bits: u32,
    /// Sites that share a number, as a power of two.
    shared: u32,
    /// f(s) << index_bits | s >> shared.
    sites: Vec<Row>,
    /// The packed minima.
    best: Vec<Row>,
    /// √ of the greatest f(y) over the lines: how far a row must look. 0 where all of them are 0.
    reach: Vec<u32>,
    /// Least and greatest minimizing site over the lines.
    low: Vec<u32>,
    high: Vec<u32>,
    /// The minimizing sites themselves, where too many share a number; else none.
    first: Vec<Row>,
    /// What one line is worked out in: sites of the envelope, and the first row each is the least at.
    envelope: Vec<[u32; 2]>,
}

/// As many sites may share a number, as a power of two, as a search among them costs less than a line by itself.
const MOST_SHARED: u32 = 6;

impl Panel {
    /// Room for panels of `n` rows whose values are at most `most`; `None` if they do not fit a word.
    pub fn new(n: usize, most: u32) -> Option<Self> {
        let side = u64::try_from(n).ok()?.checked_add(1)?;
        let apart = side.min(u64::from(reach_of(most)));
        let greatest = apart * apart + u64::from(most);
        let value_bits = u64::BITS - greatest.leading_zeros();
        let wanted = u64::BITS - side.leading_zeros();
        let index_bits = wanted.min(PACKED_BITS.checked_sub(value_bits)?);
        let first = if wanted - index_bits > MOST_SHARED { vec![[0; LANES]; n + 2] } else { Vec::new() };
        Some(Panel {
            n,
            index_bits,
            shared: wanted - index_bits,
            sites: vec![[0; LANES]; n + 2],
            best: vec![[0; LANES]; n + 2],
            reach: vec![0; n + 2],
            low: vec![0; n + 2],
            high: vec![0; n + 2],
            first,
            envelope: Vec::new(),
        })
    }

    /// Sets the values of a row, 0 and n + 1 included.
    #[inline(always)]
    pub fn set(&mut self, s: usize, values: &Row) {
        let number = (s >> self.shared) as u32;
        for (site, &value) in self.sites[s].iter_mut().zip(values) {
            *site = value << self.index_bits | number;
        }
        self.reach[s] = reach_of(greatest(values));
    }

    /// The value of row `y` after [`Panel::solve`].
    #[inline(always)]
    pub fn value(&self, y: usize) -> Row {
        self.best[y].map(|packed| packed >> self.index_bits)
    }

    /// The first site that attains the minimum of row `y` on each line, after [`Panel::solve`].
    #[inline(always)]
    pub fn sites(&self, y: usize) -> Row {
        if self.reach[y] == 0 {
            return [y as u32; LANES];
        }
        if let Some(first) = self.first.get(y) {
            return *first;
        }
        let mask = (1 << self.index_bits) - 1;
        std::array::from_fn(|lane| {
            let packed = self.best[y][lane];
            let first = (packed & mask) << self.shared;
            let attains = |&s: &u32| {
                let d = (y as u32).abs_diff(s);
                (self.sites[s as usize][lane] >> self.index_bits) + d * d == packed >> self.index_bits
            };
            (first..first + (1 << self.shared)).take_while(|&s| s as usize <= self.n + 1).find(attains).unwrap_or(first)
        })
    }

    /// Finds the lower envelopes. Rows whose values are all 0 stay 0.
    #[inline(always)]
    pub fn solve(&mut self) {
        if !self.first.is_empty() {
            return (0..LANES).for_each(|lane| self.solve_line(lane));
        }
        let n = self.n;
        let mut stride = (n + 1).next_power_of_two();
        (self.low[0], self.high[n + 1]) = (0, n as u32 + 1);
        while stride > 1 {
            let half = stride / 2;
            for y in (half..=n).step_by(stride) {
                let reach = self.reach[y] as usize;
                if reach == 0 {
                    self.best[y] = [0; LANES];
                    (self.low[y], self.high[y]) = (y as u32, y as u32);
                    continue;
                }
                let first = (self.low[y - half] as usize).max(y.saturating_sub(reach));
                let last = (self.high[(y + half).min(n + 1)] as usize).min(y + reach);
                least(&self.sites, self.index_bits, y, first..last + 1, &mut self.best[y]);
                (self.low[y], self.high[y]) = self.ends(y);
            }
            stride = half;
        }
    }

    /// Finds the lower envelope of one line from its parabolas, each site in turn: O(n), in integers.
    ///
    /// # Source
    /// A. Meijster, J. Roerdink, W. Hesselink, A general algorithm for computing distance transforms in linear time, 2000.
    fn solve_line(&mut self, lane: usize) {
        let Panel { sites, index_bits, envelope, first, best, n, .. } = self;
        let value = |s: u32| i64::from(sites[s as usize][lane] >> *index_bits);
        let at = |s: u32, y: u32| value(s) + (i64::from(y) - i64::from(s)).pow(2);
        let last = *n as u32 + 1;
        envelope.clear();
        for s in 0..=last {
            while envelope.last().is_some_and(|&[before, from]| at(before, from) > at(s, from)) {
                envelope.pop();
            }
            // The last row at which the site before is not above this one; of equal ones the first is taken.
            let from = envelope.last().map_or(0, |&[before, _]| {
                let [p, q] = [before, s].map(i64::from);
                (q * q - p * p + value(s) - value(before)).div_euclid(2 * (q - p)) + 1
            });
            if from <= i64::from(last) {
                envelope.push([s, from as u32]);
            }
        }
        for (at, &[s, from]) in envelope.iter().enumerate() {
            let until = envelope.get(at + 1).map_or(last + 1, |next| next[1]);
            for y in from..until {
                let least = (value(s) + (i64::from(y) - i64::from(s)).pow(2)) as u32;
                (best[y as usize][lane], first[y as usize][lane]) = (least << *index_bits, s);
            }
        }
    }

    /// Least and greatest site that the minima of a row may stand for.
    #[inline(always)]
    fn ends(&self, y: usize) -> (u32, u32) {
        let mask = (1 << self.index_bits) - 1;
        let numbers = self.best[y].map(|packed| packed & mask);
        let last = (greatest(&numbers) << self.shared) + (1 << self.shared) - 1;
        (least_of(&numbers) << self.shared, last.min(self.n as u32 + 1))
    }
}

/// Least packed f(s) + (y − s)² over a range of s.
///
/// Kept out of line and in floats, so that it compiles to one addition and one minimum for each lane.
#[inline(always)]
fn least(sites: &[Row], index_bits: u32, y: usize, range: Range<usize>, best: &mut Row) {
    let mut found = [1 << PACKED_BITS; LANES];
    for (s, sites) in range.clone().zip(&sites[range]) {
        let d = y.abs_diff(s) as u32;
        // Opaque, so that the compiler puts lines and not sites side by side in a vector.
        let add = std::hint::black_box((d * d) << index_bits);
        for (found, &site) in found.iter_mut().zip(sites) {
            let candidate = site + add;
            *found = if candidate < *found { candidate } else { *found };
        }
    }
    *best = found;
}

/// How far a row whose values are at most `most` has to look.
#[inline(always)]
fn reach_of(most: u32) -> u32 {
    // Rounded up: a float has 24 bits, a root of 30 bits is then good to far less than one.
    if most == 0 { 0 } else { (most as f32).sqrt() as u32 + 1 }
}

/// The greatest of a row of words below 2^31.
#[inline(always)]
pub(super) fn greatest(row: &Row) -> u32 {
    halve(row, |a, b| if a as i32 > b as i32 { a } else { b })
}

/// The least of a row of words below 2^31.
#[inline(always)]
pub(super) fn least_of(row: &Row) -> u32 {
    halve(row, |a, b| if (a as i32) < b as i32 { a } else { b })
}

#[inline(always)]
fn halve(row: &Row, choose: impl Fn(u32, u32) -> u32) -> u32 {
    let a: [u32; 8] = std::array::from_fn(|i| choose(row[i], row[i + 8]));
    let b: [u32; 4] = std::array::from_fn(|i| choose(a[i], a[i + 4]));
    choose(choose(b[0], b[2]), choose(b[1], b[3]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn envelopes_are_those_of_all_pairs() {
        let mut state = 1u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % n
        };
        for round in 0..60 {
            let n = 1 + below(90) as usize;
            // Large values leave few bits for the sites, down to none.
            let most = [50, 5000, 1 << 20, (1 << 29) - 10_000][round % 4];
            let mut value = || if below(4) == 0 { below(u64::from(most)) as u32 } else { most };
            let mut rows: Vec<Row> = (0..n + 2).map(|_| [0; LANES].map(|_| value())).collect();
            rows.iter_mut().filter(|_| below(5) == 0).for_each(|row| *row = [0; LANES]);
            let mut panel = Panel::new(n, most).unwrap();
            rows.iter().enumerate().for_each(|(s, row)| panel.set(s, row));
            panel.solve();
            for y in 1..=n {
                for lane in 0..LANES {
                    let truth = rows.iter().enumerate().map(|(s, row)| row[lane] + (s.abs_diff(y) as u32).pow(2)).min();
                    assert_eq!(Some(panel.value(y)[lane]), truth, "n {n} most {most} y {y}");
                }
            }
        }
        assert!(Panel::new(40_000, 1 << 29).is_none() && Panel::new(40_000, 1).is_some());
    }

    #[test]
    fn long_panels_go_line_by_line_and_find_the_first_of_the_least() {
        let (n, most) = (3000, 2 * 3000 * 3000);
        let mut panel = Panel::new(n, most).unwrap();
        // Without it every row would look at every site.
        assert!(panel.shared > MOST_SHARED && !panel.first.is_empty());
        let mut random = crate::random::Lcg(3);
        let rows: Vec<Row> = (0..n + 2)
            .map(|_| [0; LANES].map(|_| if random.below(40) == 0 { random.below(90_000) as u32 } else { most }))
            .collect();
        rows.iter().enumerate().for_each(|(s, row)| panel.set(s, row));
        panel.solve();
        for y in (1..=n).step_by(7) {
            let lane = y % LANES;
            let all = rows.iter().enumerate().map(|(s, row)| (row[lane] + (s.abs_diff(y) as u32).pow(2), s as u32));
            assert_eq!(Some((panel.value(y)[lane], panel.sites(y)[lane])), all.min(), "{y}");
        }
    }
}
