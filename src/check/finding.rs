//! What a check says: findings, each with value, bracket, limit and place.

use crate::units::report_digits;
use serde::{Deserialize, Serialize};

/// The state of a finding, a check or a whole report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// The check makes no sense for this process or part; the reason stands beside it.
    NotApplicable,
    /// The check was not run; never a pass.
    NotRun,
    /// The whole bracket is on the right side of both limits.
    Pass,
    /// Over the warn limit, or over a limit that rests on a convention.
    Warn,
    /// The bracket contains the fail limit.
    Undecided,
    /// The whole bracket is on the wrong side of the fail limit.
    Fail,
    /// The check itself broke down.
    Error,
}

impl State {
    /// A glyph that says the state without colour.
    pub fn glyph(self) -> &'static str {
        match self {
            State::Pass => "✔",
            State::Warn => "▲",
            State::Fail => "✖",
            State::Undecided => "?",
            State::NotRun | State::NotApplicable => "–",
            State::Error => "!",
        }
    }

    /// The word for the state as it stands in the JSON.
    pub fn word(self) -> &'static str {
        match self {
            State::Pass => "pass",
            State::Warn => "warn",
            State::Fail => "fail",
            State::Undecided => "undecided",
            State::NotRun => "not-run",
            State::NotApplicable => "not-applicable",
            State::Error => "error",
        }
    }
}

/// Which side of a limit is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sense {
    /// The value must be at least the limit.
    Min,
    /// The value must be at most the limit.
    Max,
}

/// How well a value is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// Measured on the mesh; the bracket is rounding only.
    Exact,
    /// The truth lies in the bracket, by proof.
    Certified,
    /// No bound is known; such a value warns at most.
    Estimated,
}

/// A measured number with its certified bracket, in the unit that stands beside it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bracket {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

impl Bracket {
    /// A bracket; the ends are moved out to hold the value.
    pub fn new(value: f64, low: f64, high: f64) -> Self {
        Bracket { value, low: low.min(value), high: high.max(value) }
    }

    /// A value known to rounding.
    pub fn exact(value: f64) -> Self {
        Bracket { value, low: value, high: value }
    }

    /// Judges the bracket against one limit; strict, with `tie` as what counts as equal.
    ///
    /// Returns `Some(true)` if all of it is on the right side, `Some(false)` if all of it is on the wrong side
    /// and `None` if it holds the limit.
    pub fn meets(&self, limit: f64, sense: Sense, tie: f64) -> Option<bool> {
        let (low, high) = match sense {
            Sense::Min => (self.low, self.high),
            Sense::Max => (-self.high, -self.low),
        };
        let limit = if sense == Sense::Min { limit } else { -limit };
        if low >= limit - tie {
            Some(true)
        } else if high < limit - tie {
            Some(false)
        } else {
            None
        }
    }

    /// The same bracket at the resolution of the report.
    pub fn rounded(self) -> Self {
        Bracket { value: report_digits(self.value), low: report_digits(self.low), high: report_digits(self.high) }
    }
}

/// The two limits a value is judged by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    pub fail: Option<f64>,
    pub warn: Option<f64>,
    pub sense: Sense,
}

impl Limits {
    /// State of a bracket, and whether it is decided against both limits.
    ///
    /// *Fail* needs the whole bracket on the wrong side of `fail`, *pass* all of it on the right side of both.
    /// A bracket that holds the fail limit is undecided; one that holds only the warn limit is an undecided warning.
    pub fn judge(&self, bracket: &Bracket, basis: Basis, tie: f64) -> (State, bool) {
        let against = |limit: Option<f64>| limit.map_or(Some(true), |l| bracket.meets(l, self.sense, tie));
        match (against(self.fail), against(self.warn)) {
            (Some(false), _) if basis == Basis::Estimated => (State::Warn, true),
            (Some(false), _) => (State::Fail, true),
            (None, _) if basis == Basis::Estimated => (State::Warn, false),
            (None, _) => (State::Undecided, false),
            (Some(true), Some(true)) => (State::Pass, true),
            (Some(true), Some(false)) => (State::Warn, true),
            (Some(true), None) => (State::Warn, false),
        }
    }
}

/// One of several equal places of a grouped finding.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spot {
    pub at_mm: [f64; 3],
    /// The box of this place alone; where it is left out, and the place is the only one, the finding's own is.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub box_mm: Option<[[f64; 3]; 2]>,
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

/// The points by which somebody else can check a value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Witness {
    /// What the points are: `medial-ball` (centre and contacts), `containing-ball` (a point and the centre), `nearest-pair`, `facet`, …
    pub kind: String,
    /// The points in the frame of the input file, millimetres.
    pub points_mm: Vec<[f64; 3]>,
}

impl Witness {
    /// The kind of what was cut across: the middle of its narrowest section, and both ends of its line.
    pub const SECTION: &str = "section";

    /// How long it is, of what was cut across.
    fn length(&self) -> Option<f64> {
        match (self.kind.as_str(), &self.points_mm[..]) {
            (Self::SECTION, &[_, a, b]) => Some((0..3).map(|x| (a[x] - b[x]).powi(2)).sum::<f64>().sqrt()),
            _ => None,
        }
    }
}

/// Why somebody accepts a finding, and until when.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Accepted {
    pub reason: String,
    /// The last day on which that holds, `2027-06-30`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub until: Option<String>,
}

/// One thing that is wrong, or may be, at one place or at several equal ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Code of the check, `AM101`.
    pub code: String,
    /// Kind within the check, such as `wall`, `gap-between-bodies`.
    pub kind: String,
    pub state: State,
    /// False where the bracket still holds a limit.
    pub decided: bool,
    pub basis: Basis,
    pub value: f64,
    pub low: f64,
    pub high: f64,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub fail: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub warn: Option<f64>,
    pub sense: Sense,
    /// `mm`, `deg`, `mm2`, `mm3`, `1`.
    pub unit: String,
    /// Distance of the value from the nearest limit it breaks, negative on the wrong side.
    pub margin: f64,
    /// How many equal places this finding stands for.
    pub count: u64,
    /// The worst place, in the frame of the input file.
    pub at_mm: [f64; 3],
    pub box_mm: [[f64; 3]; 2],
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub layers: Option<[u64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub area_mm2: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub volume_mm3: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub bodies: Option<Vec<u64>>,
    pub places: Vec<Spot>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub witness: Option<Witness>,
    /// What is wrong, one sentence.
    pub message: String,
    /// What to change, one sentence with a number in it; for an undecided finding, what would decide it.
    pub fix: String,
    /// Survives small edits of the part: check, kind, rounded place and size class, and an ordinal where another has all of these.
    pub fingerprint: String,
    /// Somebody accepts it: it is shown, and does not count.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub accepted: Option<Accepted>,
    /// Somebody accepted it until a day that is past: it counts again.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub acceptance_ended: Option<Accepted>,
}

impl Finding {
    /// Every place that it stands for: itself, if it names none.
    pub fn spots(&self) -> Vec<Spot> {
        let own = Spot { at_mm: self.at_mm, box_mm: None, value: self.value, low: self.low, high: self.high };
        if self.places.is_empty() { vec![own] } else { self.places.clone() }
    }

    /// The box of one of its places, where that is known.
    pub fn box_of(&self, spot: &Spot) -> Option<[[f64; 3]; 2]> {
        spot.box_mm.or((self.count == 1).then_some(self.box_mm))
    }

    /// The same finding with its places elsewhere, for comparisons; what witnesses it stays where it was.
    pub fn moved(&self, by: [f64; 3]) -> Self {
        let point = |p: [f64; 3]| [0, 1, 2].map(|a| p[a] + by[a]);
        let mut moved = self.clone();
        (moved.at_mm, moved.box_mm) = (point(self.at_mm), self.box_mm.map(point));
        for spot in &mut moved.places {
            (spot.at_mm, spot.box_mm) = (point(spot.at_mm), spot.box_mm.map(|b| b.map(point)));
        }
        moved
    }

    /// How much of a box the place that it tells of fills, at most 1, by what is known of it; `None` where nothing is. An even wall that lies along the axes
    /// fills its box, one that stands around something or lies askew does not.
    pub fn fills(&self, [lo, hi]: [[f64; 3]; 2]) -> Option<f64> {
        let holds = (0..3).map(|a| (hi[a] - lo[a]).max(0.0)).product::<f64>();
        // What has to be at least so wide is a width; a span or a height is none. Of what was cut across, the area is that of a section, and the length that
        // between its ends.
        let width = (self.unit == "mm" && self.sense == Sense::Min).then_some(self.value);
        let along = self.witness.as_ref().and_then(Witness::length).or(width);
        let filled = self.area_mm2.zip(along).map(|(area, along)| area * along);
        let all = self.volume_mm3.or(filled)? / self.count.max(1) as f64;
        Some(if all < holds { all / holds } else { 1.0 })
    }

    /// A finding from its measured bracket, judged by the limits; texts, places and extents are added after.
    pub fn judged(
        code: &str,
        kind: &str,
        bracket: Bracket,
        basis: Basis,
        limits: Limits,
        unit: &str,
        tie: f64,
    ) -> Self {
        let (state, decided) = limits.judge(&bracket, basis, tie);
        let sign = if limits.sense == Sense::Min { 1.0 } else { -1.0 };
        let broken = match state {
            State::Fail | State::Undecided => limits.fail,
            _ => limits.warn.or(limits.fail),
        };
        let b = bracket.rounded();
        Finding {
            code: code.into(),
            kind: kind.into(),
            state,
            decided,
            basis,
            value: b.value,
            low: b.low,
            high: b.high,
            fail: limits.fail,
            warn: limits.warn,
            sense: limits.sense,
            unit: unit.into(),
            margin: broken.map_or(0.0, |l| report_digits(sign * (bracket.value - l))),
            count: 1,
            at_mm: [0.0; 3],
            box_mm: [[0.0; 3]; 2],
            layers: None,
            area_mm2: None,
            volume_mm3: None,
            bodies: None,
            places: Vec::new(),
            witness: None,
            message: String::new(),
            fix: String::new(),
            fingerprint: String::new(),
            accepted: None,
            acceptance_ended: None,
        }
    }

    /// Whether it counts towards the state of its check: it is no pass, and nobody accepts it.
    pub fn counts(&self) -> bool {
        self.state > State::Pass && self.accepted.is_none()
    }

    /// Severity order: what is accepted last; worst state first, then the largest distance beyond the limit in shares of the limit (all of it
    /// where the limit is zero), then its own distance, then place.
    pub fn worst_first(a: &Finding, b: &Finding) -> std::cmp::Ordering {
        let depth = |f: &Finding| {
            let limit = f.fail.or(f.warn).unwrap_or(0.0).abs();
            if limit > 0.0 { f.margin / limit } else { f.margin.signum().min(0.0) }
        };
        let accepted = a.accepted.is_some().cmp(&b.accepted.is_some());
        accepted
            .then_with(|| b.state.cmp(&a.state))
            .then_with(|| depth(a).total_cmp(&depth(b)))
            .then_with(|| a.code.cmp(&b.code))
            .then_with(|| a.margin.total_cmp(&b.margin))
            .then_with(|| {
                a.at_mm
                    .iter()
                    .zip(&b.at_mm)
                    .map(|(x, y)| x.total_cmp(y))
                    .find(|o| o.is_ne())
                    .unwrap_or(std::cmp::Ordering::Equal)
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { fail: Some(0.8), warn: Some(1.2), sense: Sense::Min };

    #[test]
    fn equal_to_the_limit_passes_and_a_bracket_across_it_is_undecided() {
        let judge =
            |low: f64, high: f64| LIMITS.judge(&Bracket::new(0.5 * (low + high), low, high), Basis::Certified, 1e-6);
        assert_eq!(judge(0.5, 0.7), (State::Fail, true));
        assert_eq!(judge(0.5, 0.9), (State::Undecided, false));
        assert_eq!(judge(0.8, 0.8), (State::Warn, true));
        assert_eq!(judge(0.7999995, 0.8), (State::Warn, true));
        assert_eq!(judge(0.9, 1.3), (State::Warn, false));
        assert_eq!(judge(1.2, 1.3), (State::Pass, true));
    }

    #[test]
    fn an_estimate_never_fails() {
        assert_eq!(LIMITS.judge(&Bracket::exact(0.1), Basis::Estimated, 0.0), (State::Warn, true));
    }

    #[test]
    fn a_largest_limit_is_the_mirror_image() {
        let l = Limits { fail: Some(10.0), warn: None, sense: Sense::Max };
        assert_eq!(l.judge(&Bracket::exact(10.0), Basis::Exact, 0.0).0, State::Pass);
        assert_eq!(l.judge(&Bracket::exact(10.1), Basis::Exact, 0.0).0, State::Fail);
        assert_eq!(l.judge(&Bracket::new(10.0, 9.0, 11.0), Basis::Exact, 0.0).0, State::Undecided);
    }
}
