//! Lines across a region: those beside a place along a direction, and the one through it.

use super::line::{Chord, Crossing, Turned, between_anchors, chords, own_chord};
use super::section::Point;
use super::sides::Sides;

/// What the lines of a strip show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strip {
    /// The longest of their anchored chords.
    pub longest: f64,
    /// Whether all their chords are anchored.
    pub is_whole: bool,
    /// How many pairs of a line and a side they count as.
    pub pairs: usize,
}

/// Lengths that are known when a strip is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Known {
    /// Some direction has anchored chords alone, none longer than this: of another one no more is asked than whether it has shorter ones.
    pub all: f64,
    /// Of a strip not all of whose chords are anchored no more is asked than whether it has longer ones.
    pub some: f64,
}

/// Room for the sides of a strip, kept from one strip to the next.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    local: Vec<(usize, Turned)>,
    corners: Vec<f64>,
    offsets: Vec<f64>,
    at_hand: Vec<Turned>,
    crossings: Vec<Crossing>,
}

impl Sweep {
    /// The chords of all lines along `d` that pass within `reach` of x. What is narrower than `tiny` is not seen.
    ///
    /// # Cost
    /// O(log + those in the strip · (log + those that a line meets)). It counts as if each side had been held against the strip, and each
    /// line against all sides at hand: how far the effort of a search reaches does not depend on how sides are found.
    pub fn strip(&mut self, sides: &Sides, line: [Point; 2], [reach, tiny]: [f64; 2], known: Known) -> Strip {
        self.between(sides, line, [-reach, reach], [reach, tiny], known)
    }

    /// As [`Sweep::strip`], of the lines alone that pass x at offsets between two, positive left of it.
    pub fn between(
        &mut self,
        sides: &Sides,
        line: [Point; 2],
        over: [f64; 2],
        [reach, tiny]: [f64; 2],
        known: Known,
    ) -> Strip {
        self.gather(sides, line, over, tiny);
        let mut strip = Strip { longest: 0.0, is_whole: true, pairs: sides.all().len() };
        // The lines sweep over the strip; a side is at hand from its near end to its far one.
        let mut local = self.local.iter().map(|(_, s)| *s).peekable();
        self.at_hand.clear();
        for &o in &self.offsets {
            if known.all.is_finite() && (strip.longest >= known.all || !strip.is_whole) {
                break;
            }
            self.at_hand.retain(|s| s.hi() >= o);
            while let Some(s) = local.next_if(|s| s.lo() < o) {
                self.at_hand.push(s);
            }
            strip.pairs += self.at_hand.len();
            if !strip.is_whole && between_anchors(&self.at_hand, o) <= strip.longest.max(known.some) {
                continue;
            }
            self.crossings.clear();
            self.crossings.extend(self.at_hand.iter().filter_map(|s| s.met_by(o)));
            chords(&mut self.crossings, tiny, |c| {
                if c.t[0] <= 2.0 * reach && c.t[1] >= -2.0 * reach {
                    strip.is_whole &= c.anchored;
                    strip.longest = if c.anchored { strip.longest.max(c.t[1] - c.t[0]) } else { strip.longest };
                }
            });
        }
        strip
    }

    /// Finds the sides in a strip, by their near ends, and the offsets of its lines: its edges, and beside each corner in it.
    fn gather(&mut self, sides: &Sides, [x, d]: [Point; 2], [from, to]: [f64; 2], tiny: f64) {
        // Only sides that reach into the strip are met by its lines.
        let turned = sides.in_strip(x, d, from.abs().max(to.abs()) + tiny).map(|(n, s)| (*n, Turned::new(s, x, d)));
        self.local.clear();
        self.local.extend(turned.filter(|(_, s)| s.lo() <= to + tiny && s.hi() >= from - tiny));
        self.local.sort_unstable_by(|(n, a), (m, b)| a.lo().total_cmp(&b.lo()).then(n.cmp(m)));
        self.corners.clear();
        self.corners.extend(self.local.iter().map(|(_, s)| s.across[0]).filter(|o| from < *o && *o < to));
        self.corners.sort_unstable_by(f64::total_cmp);
        self.offsets.clear();
        self.offsets.push(from);
        self.offsets.extend(self.corners.iter().map(|o| o - tiny));
        self.offsets.extend(self.corners.iter().map(|o| o + tiny));
        self.offsets.push(to);
        // Stable, as it merges what is sorted in runs.
        self.offsets.sort_by(f64::total_cmp);
    }
}

impl Sides {
    /// The chord through a point of the region; `None` outside.
    ///
    /// # Cost
    /// O(log + those in the boxes that the line meets).
    pub fn chord_at(&self, x: Point, d: Point, tiny: f64) -> Option<Chord> {
        let crossings = self.in_strip(x, d, 0.0).filter_map(|(n, s)| Some((*n, Turned::new(s, x, d).met_by(0.0)?)));
        let mut met: Vec<(usize, Crossing)> = crossings.collect();
        // Crossings at one place stay in the order of their sides.
        met.sort_unstable_by_key(|(n, _)| *n);
        let mut met: Vec<Crossing> = met.into_iter().map(|(_, c)| c).collect();
        own_chord(&mut met, tiny)
    }
}

#[cfg(test)]
mod tests {
    use super::super::line::Side;
    use super::super::sides::tests::{direction, place, ragged};
    use super::*;
    use crate::random::Lcg;

    const TINY: f64 = 1e-8;

    /// The strip as it is said: every side turned, every line held against all sides.
    fn plain(sides: &[Side], [x, d]: [Point; 2], reach: f64, known: f64) -> Strip {
        let turned = sides.iter().map(|s| Turned::new(s, x, d));
        let mut local: Vec<Turned> = turned.filter(|s| s.lo() <= reach + TINY && s.hi() >= -reach - TINY).collect();
        local.sort_by(|a, b| a.lo().total_cmp(&b.lo()));
        let corners = local.iter().map(|s| s.across[0]).filter(|o| o.abs() < reach);
        let mut offsets: Vec<f64> = corners.flat_map(|o| [o - TINY, o + TINY]).chain([-reach, reach]).collect();
        offsets.sort_by(f64::total_cmp);
        let mut strip = Strip { longest: 0.0, is_whole: true, pairs: sides.len() };
        let (mut at_hand, mut next): (Vec<Turned>, usize) = (Vec::new(), 0);
        for o in offsets {
            if known.is_finite() && (strip.longest >= known || !strip.is_whole) {
                break;
            }
            at_hand.retain(|s| s.hi() >= o);
            let new = local[next..].iter().take_while(|s| s.lo() < o).count();
            at_hand.extend(&local[next..next + new]);
            next += new;
            strip.pairs += at_hand.len();
            let mut crossings: Vec<Crossing> = at_hand.iter().filter_map(|s| s.met_by(o)).collect();
            chords(&mut crossings, TINY, |c| {
                if c.t[0] <= 2.0 * reach && c.t[1] >= -2.0 * reach {
                    strip.is_whole &= c.anchored;
                    strip.longest = if c.anchored { strip.longest.max(c.t[1] - c.t[0]) } else { strip.longest };
                }
            });
        }
        strip
    }

    #[test]
    fn strips_are_those_of_a_plain_sweep() {
        let (mut rng, mut sweep) = (Lcg(53), Sweep::default());
        for case in 0..200 {
            let mut all = ragged(&mut rng, case);
            // Held all round, here and there, or nowhere.
            let every = [1, 2, 7, 1000][rng.below(4) as usize];
            all.iter_mut().enumerate().for_each(|(n, s)| s.anchored = n % every == every - 1);
            let sides = Sides::new(all.clone());
            for _ in 0..10 {
                let line = [place(&mut rng, &all), direction(&mut rng)];
                let reach = 3.0 * rng.unit().powi(2);
                for (known, some) in [(f64::INFINITY, 0.0), (f64::INFINITY, 9.0 * rng.unit()), (9.0 * rng.unit(), 0.0)]
                {
                    let found = sweep.strip(&sides, line, [reach, TINY], Known { all: known, some });
                    let plain = plain(&all, line, reach, known);
                    assert_eq!((found.is_whole, found.pairs), (plain.is_whole, plain.pairs), "{case}: {line:?}");
                    let least = if plain.is_whole { 0.0 } else { some };
                    assert_eq!(found.longest.max(least), plain.longest.max(least), "{case}: {line:?} {reach}");
                }
            }
        }
    }

    #[test]
    fn the_chord_through_a_place_is_that_of_all_sides() {
        let mut rng = Lcg(59);
        for case in 0..300 {
            let all = ragged(&mut rng, case);
            let sides = Sides::new(all.clone());
            for _ in 0..10 {
                let (x, d) = (place(&mut rng, &all), direction(&mut rng));
                let mut met: Vec<Crossing> = all.iter().filter_map(|s| Turned::new(s, x, d).met_by(0.0)).collect();
                let told = |c: Option<Chord>| c.map(|c| (c.t, c.anchored));
                assert_eq!(told(sides.chord_at(x, d, TINY)), told(own_chord(&mut met, TINY)), "{case}: {x:?} {d:?}");
            }
        }
    }
}
