//! Colours of values: a hard step at each limit, so that a limit is seen and not guessed.
//!
//! On the wrong side of the fail limit dark red to orange, between the limits yellow, beyond both pale blue-grey.
//! A quantity without limits runs through viridis (Smith & van der Walt 2015, CC0).

use crate::check::{Sense, State};
use crate::report::exhibit::SurfaceMap;

/// Red, green, blue.
pub type Rgb = [u8; 3];

/// Ink for lines and letters.
pub const INK: Rgb = [24, 33, 43];
/// Ink for what is said in passing.
pub const FAINT: Rgb = [88, 99, 112];
/// Ground of a picture.
pub const PAPER: Rgb = [255, 255, 255];
/// Ground behind the part.
pub const STAGE: Rgb = [236, 240, 243];
/// Surface where nothing is measured.
pub const UNMEASURED: Rgb = [196, 203, 209];

/// Nine points of viridis at equal steps.
const VIRIDIS: [Rgb; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// Where a value stands against the limits of its map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Zone {
    /// Nothing is measured here.
    Unmeasured,
    /// On the right side of both limits.
    Good,
    /// Between the limits.
    Warn,
    /// On the wrong side of the fail limit.
    Fail,
}

/// The colour of the state on white: glyphs, pins, frames.
pub fn state_colour(state: State) -> Rgb {
    match state {
        State::Fail | State::Error => [164, 14, 58],
        State::Warn => [138, 79, 0],
        State::Undecided => [72, 74, 160],
        State::Pass => [20, 108, 67],
        State::NotRun | State::NotApplicable => [88, 99, 112],
    }
}

/// The scale of a map: its ends, limits and colours.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    /// End of the scale on the bad side (0 for a least limit, the open end for a greatest).
    pub low: f64,
    pub high: f64,
    pub fail: Option<f64>,
    pub warn: Option<f64>,
    pub sense: Sense,
}

impl Scale {
    /// The scale of a map from zero, or its least value below zero, to its open end.
    pub fn of(map: &SurfaceMap) -> Self {
        let least = map.values.iter().copied().filter(|v| v.is_finite()).fold(0f32, f32::min);
        let top = [Some(map.open_end), map.fail, map.warn].into_iter().flatten().fold(f64::MIN, f64::max);
        let low = f64::from(least);
        let high = if top > low { top } else { low + 1.0 };
        let stricter = |w: &f64| {
            map.fail.is_none_or(|f| match map.sense {
                Sense::Min => *w > f,
                Sense::Max => *w < f,
            })
        };
        Scale { low, high, fail: map.fail, warn: map.warn.filter(stricter), sense: map.sense }
    }

    /// Where a value stands against the limits; equal to a limit is good.
    pub fn zone(&self, value: f32) -> Zone {
        if value.is_nan() {
            return Zone::Unmeasured;
        }
        let value = f64::from(value);
        // f32 maps carry limits like 0.8 to 24 bits; within that they are equal.
        let tie = 1e-6 * value.abs().max(1e-3);
        let breaks = |limit: Option<f64>| {
            limit.is_some_and(|l| match self.sense {
                Sense::Min => value < l - tie,
                Sense::Max => value > l + tie,
            })
        };
        if breaks(self.fail) {
            Zone::Fail
        } else if breaks(self.warn) {
            Zone::Warn
        } else {
            Zone::Good
        }
    }

    /// The colour of a value.
    pub fn colour(&self, value: f32) -> Rgb {
        let zone = self.zone(value);
        if zone == Zone::Unmeasured {
            return UNMEASURED;
        }
        let v = f64::from(value).clamp(self.low, self.high);
        if self.fail.is_none() && self.warn.is_none() {
            return ramp(&VIRIDIS, (v - self.low) / (self.high - self.low));
        }
        // Bad end, fail limit, warn limit, good end: in the order from bad to good.
        let (bad, good) = match self.sense {
            Sense::Min => (self.low, self.high),
            Sense::Max => (self.high, self.low),
        };
        let share = |from: f64, to: f64| if (to - from).abs() > 1e-12 { (v - from) / (to - from) } else { 0.0 };
        match zone {
            Zone::Fail => ramp(
                &[[140, 8, 44], [186, 26, 42], [222, 74, 30], [240, 124, 36]],
                share(bad, self.fail.unwrap_or(good)),
            ),
            Zone::Warn => {
                ramp(&[[247, 196, 52], [251, 224, 116]], share(self.fail.unwrap_or(bad), self.warn.unwrap_or(good)))
            }
            _ => ramp(&[[172, 192, 207], [222, 231, 237]], share(self.warn.or(self.fail).unwrap_or(bad), good)),
        }
    }
}

/// Linear interpolation through colours at equal steps of `[0, 1]`.
fn ramp(stops: &[Rgb], at: f64) -> Rgb {
    let last = stops.len() - 1;
    let x = at.clamp(0.0, 1.0) * last as f64;
    let i = (x as usize).min(last.saturating_sub(1));
    let t = x - i as f64;
    [0, 1, 2].map(|c| {
        let (a, b) = (f64::from(stops[i][c]), f64::from(stops[(i + 1).min(last)][c]));
        (a + (b - a) * t).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(sense: Sense, fail: f64, warn: f64) -> SurfaceMap {
        let text = String::new;
        let (fail, warn) = (Some(fail), Some(warn));
        SurfaceMap {
            check: text(),
            title: text(),
            unit: text(),
            sense,
            fail,
            warn,
            open_end: 4.0,
            fills: None,
            values: vec![],
        }
    }

    #[test]
    fn a_limit_is_a_hard_step_and_equal_to_it_is_good() {
        let s = Scale::of(&map(Sense::Min, 0.5, 0.8));
        assert_eq!([0.49, 0.5, 0.79, 0.8].map(|v| s.zone(v)), [Zone::Fail, Zone::Warn, Zone::Warn, Zone::Good]);
        let step = |a: f32, b: f32| {
            let (a, b) = (s.colour(a), s.colour(b));
            (0..3).map(|c| (i32::from(a[c]) - i32::from(b[c])).abs()).sum::<i32>()
        };
        assert!(step(0.4999, 0.5) > 60 && step(0.7999, 0.8) > 60 && step(0.6, 0.601) < 5);
        let s = Scale::of(&map(Sense::Max, 3.0, 2.0));
        assert_eq!(
            [1.0, 2.0, 2.5, 3.5, f32::NAN].map(|v| s.zone(v)),
            [Zone::Good, Zone::Good, Zone::Warn, Zone::Fail, Zone::Unmeasured]
        );
    }
}
