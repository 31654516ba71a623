//! Two reports of one part compared: what is new, fixed, worse, better or the same.
//!
//! Findings are matched by check, kind and places within a tolerance, because geometry moves; a part that was moved as a whole, so that its box
//! is as large elsewhere, is taken back first. *Worse* and *better* need brackets of a place that part by more than files are rounded,
//! or places that came or went, or as much again of area as half of what it was, or a verdict that became *fail* or was it: a change inside
//! the uncertainty is no other change.

use super::matched::{Matched, Named};
use super::phrase;
use super::schema::{Axis3, PartReport, Report};
use super::terminal::Palette;
use crate::check::{Finding, Sense, Spot, State};
use crate::error::printable;
use crate::units::short;
use serde::Serialize;
use std::cmp::Ordering;
use std::collections::BTreeSet;

/// Sides of two boxes that differ by no more are the same, millimetres.
const SAME_SIDE: f64 = 1e-3;
/// An area that has grown to so many times what it was is worse, however even the value; less may be how facets and samples lie.
const GROWN: f64 = 1.5;

/// What became of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Delta {
    /// Only in the new report.
    New,
    /// In both; the new bracket of a place lies wholly on the worse side of the old, or a place is new, or it fails and did not.
    Worse,
    /// Only in the old report, and its check gave no answer in the new, or one by other limits: nobody knows.
    Unchecked,
    /// In both; the brackets overlap.
    Same,
    /// In both; the new bracket of a place lies wholly on the better side of the old, or a place is gone, or it failed and only warns, and
    /// none is worse or new.
    Better,
    /// Only in the old report, and its check gave an answer in the new by the same limits.
    Fixed,
}

impl Delta {
    /// The word as it stands in the JSON.
    pub fn word(self) -> &'static str {
        match self {
            Delta::New => "new",
            Delta::Worse => "worse",
            Delta::Unchecked => "unchecked",
            Delta::Same => "same",
            Delta::Better => "better",
            Delta::Fixed => "fixed",
        }
    }
}

/// One finding of either report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    pub delta: Delta,
    pub check: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub old: Option<Finding>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub new: Option<Finding>,
    /// Places of the new finding that are of no old one, where others are.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub new_places_mm: Vec<Axis3>,
}

/// The difference of two reports.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// How far a place may have moved and still be the same, millimetres.
    pub tolerance_mm: f64,
    /// What was judged differently, in words: the process, and each limit that is not the same.
    pub conditions: Vec<String>,
    /// New first, then worse, unchecked, same, better, fixed; within these worst first.
    pub changes: Vec<Change>,
}

impl Comparison {
    /// How many findings became this.
    pub fn count(&self, delta: Delta) -> usize {
        self.changes.iter().filter(|c| c.delta == delta).count()
    }

    /// Whether `--fail-on new` fails: something that fails and that nobody accepts is new, has become worse, or was
    /// accepted before.
    pub fn has_new_failure(&self) -> bool {
        let was_accepted = |c: &Change| c.old.as_ref().is_some_and(|f| f.accepted.is_some());
        let bad = |c: &Change| matches!(c.delta, Delta::New | Delta::Worse) || was_accepted(c);
        let counts = |f: &Finding| f.counts() && f.state == State::Fail;
        self.changes.iter().any(|c| bad(c) && c.new.as_ref().is_some_and(counts))
    }

    /// The counts as words: `1 new, 2 same`; `no findings in either` for none.
    pub fn words(&self) -> String {
        let kinds = [Delta::New, Delta::Worse, Delta::Unchecked, Delta::Same, Delta::Better, Delta::Fixed];
        let parts: Vec<String> = kinds
            .into_iter()
            .map(|d| (d, self.count(d)))
            .filter(|(_, n)| *n > 0)
            .map(|(d, n)| format!("{n} {}", d.word()))
            .collect();
        if parts.is_empty() { "no findings in either".into() } else { parts.join(", ") }
    }
}

/// What changed from `old` to `new`.
///
/// Places are paired nearest first: those of findings of the same check and kind that lie within two samples of the coarser grid, or one in the
/// other's box grown by as much; of equal fingerprints wherever they are if none does. A finding is compared with the one that most of its places were
/// of; what was one place of a finding that stands for several left it, or joined it.
///
/// # Cost
/// O(m·n) for m and n places of one check.
///
/// # Limits
/// A part whose box changed as well is taken to lie where its file says. Of reports that give no box for each place of a finding, places are known
/// by the box of all.
pub fn compare(old: &Report, new: &Report) -> Comparison {
    let tolerance_mm = 2.0 * old.grid.spacing_mm.max(new.grid.spacing_mm);
    let (before, after) = (listed(old), listed(new));
    let by = moved_by(&old.part, &new.part);
    let taken: Vec<Finding> = before.iter().map(|(_, f)| f.moved(by)).collect();
    let taken: Vec<Named> = before.iter().zip(&taken).map(|((check, _), f)| (*check, f)).collect();
    let matched = Matched::of(&taken, &after, tolerance_mm);
    let mut changes = Vec::new();
    let mut told = vec![false; before.len()];
    for (j, &(check, f)) in after.iter().enumerate() {
        let Some(i) = matched.new.most(j) else {
            changes.push(change(Delta::New, check, None, Some(f)));
            continue;
        };
        told[i] = true;
        let new_places_mm = matched.new.alone(j).map(|s| s.at_mm).collect();
        let delta = became(&matched, (i, before[i].1), (j, f));
        changes.push(Change { new_places_mm, ..change(delta, check, Some(before[i].1), Some(f)) });
    }
    for (i, &(check, f)) in before.iter().enumerate().filter(|(i, _)| !told[*i]) {
        if let Some(j) = matched.old.most(i) {
            let deltas = matched.old.with(i, &matched.new).map(|(s, t)| moved(f, bracket(s), bracket(t)));
            changes.push(change(overall(deltas), check, Some(f), Some(after[j].1)));
            continue;
        }
        let answered = new
            .checks
            .iter()
            .any(|c| c.name == check && !matches!(c.state, State::NotRun | State::NotApplicable | State::Error))
            && !other_limits(old, new).iter().any(|key| key.split(['.', '/']).next() == Some(check));
        changes.push(change(if answered { Delta::Fixed } else { Delta::Unchecked }, check, Some(f), None));
    }
    changes.sort_by(|a, b| {
        let of = |c: &Change| c.new.clone().or(c.old.clone());
        a.delta.cmp(&b.delta).then_with(|| match (of(a), of(b)) {
            (Some(x), Some(y)) => Finding::worst_first(&x, &y),
            _ => Ordering::Equal,
        })
    });
    Comparison { tolerance_mm, conditions: conditions(old, new), changes }
}

/// How far a part was moved as a whole: not at all where the two boxes differ in size by more than files are rounded.
fn moved_by(old: &PartReport, new: &PartReport) -> Axis3 {
    let side = |p: &PartReport, a: usize| p.box_mm[1][a] - p.box_mm[0][a];
    let by = [0, 1, 2].map(|a| new.box_mm[0][a] - old.box_mm[0][a]);
    if (0..3).all(|a| (side(old, a) - side(new, a)).abs() <= SAME_SIDE) { by } else { [0.0; 3] }
}

/// The limits that one report has and the other has not, or has otherwise.
fn other_limits<'r>(old: &'r Report, new: &'r Report) -> BTreeSet<&'r str> {
    let of = |r: &'r Report, key: &str| r.process.limits.get(key).map(|l| (l.fail, l.warn, l.sense));
    let keys = old.process.limits.keys().chain(new.process.limits.keys());
    keys.filter(|key| of(old, key) != of(new, key)).map(String::as_str).collect()
}

/// What the two reports were judged by, where it differs.
fn conditions(old: &Report, new: &Report) -> Vec<String> {
    let mut said = Vec::new();
    let names = [&old.process.name, &new.process.name].map(|n| printable(n));
    if names[0] != names[1] {
        said.push(format!("process {} → {}", names[0], names[1]));
    }
    let units = [&old.part, &new.part].map(|p| printable(&p.units));
    if units[0] != units[1] {
        said.push(format!("units {} → {}", units[0], units[1]));
    }
    let ups = [&old.part, &new.part].map(up);
    if ups[0] != ups[1] {
        said.push(format!("up {} → {}", ups[0], ups[1]));
    }
    let limit = |r: &Report, key: &str| {
        let found = r.process.limits.get(key);
        found.map_or("no limit".into(), |l| phrase::limits(l.fail, l.warn, l.sense, &l.unit))
    };
    said.extend(
        other_limits(old, new)
            .into_iter()
            .map(|key| format!("{}: {} → {}", printable(key), limit(old, key), limit(new, key))),
    );
    said
}

/// The direction of the file that points up: an axis, or a vector of three digits.
fn up(part: &PartReport) -> String {
    let [x, y, z, _] = part.pose[2].map(|c| (1e3 * c).round() / 1e3);
    let axes = [("+x", [1.0, 0.0, 0.0]), ("+y", [0.0, 1.0, 0.0]), ("+z", [0.0, 0.0, 1.0])];
    let below = [("-x", [-1.0, 0.0, 0.0]), ("-y", [0.0, -1.0, 0.0]), ("-z", [0.0, 0.0, -1.0])];
    let axis = axes.into_iter().chain(below).find(|a| a.1 == [x, y, z]);
    axis.map_or_else(|| [x, y, z].map(short).join(","), |a| a.0.into())
}

/// The comparison for a terminal: one line for each change that is not the same, then the counts.
pub fn text(comparison: &Comparison, palette: Palette) -> String {
    let mut out = String::new();
    for c in comparison.changes.iter().filter(|c| c.delta != Delta::Same) {
        let state = match c.delta {
            Delta::New | Delta::Worse => State::Fail,
            Delta::Unchecked => State::Undecided,
            _ => State::Pass,
        };
        out.push_str(&palette.state(state, &format!("{:<10}", c.delta.word())));
        out.push_str(&format!("{:<18} {}\n", printable(&c.check), from_to(c)));
    }
    for said in &comparison.conditions {
        out.push_str(&format!("judged otherwise: {said}\n"));
    }
    out.push_str(&format!("compared with the baseline: {}\n", comparison.words()));
    out
}

/// Values before and after, and the place: `0.45 mm → 0.61 mm at 21.6, 0, 11`; with the number of places where that changed.
pub fn from_to(c: &Change) -> String {
    let value = |f: &Finding| phrase::measured(f.value, f.low, f.high, &f.unit);
    let at = |f: &Finding| format!("at {}", phrase::point(f.at_mm));
    match (&c.old, &c.new) {
        (Some(a), Some(b)) if !c.new_places_mm.is_empty() => {
            let (fresh, first) = (c.new_places_mm.len(), c.new_places_mm.first().map_or(b.at_mm, |p| *p));
            let at = phrase::point(first);
            let first = if fresh > 1 { "the first " } else { "" };
            format!("{} → {}, {fresh} of {} places new, {first}at {at}", value(a), value(b), b.count)
        }
        (Some(a), Some(b)) if a.count != b.count => {
            format!("{} → {}, {} → {} places, {}", value(a), value(b), a.count, b.count, at(b))
        }
        (Some(a), Some(b)) if value(a) == value(b) && a.state != b.state => {
            format!("{} {} → {} {}", value(b), a.state.word(), b.state.word(), at(b))
        }
        (Some(a), Some(b)) => match (spread(a, b), a.area_mm2, b.area_mm2) {
            (Some(_), Some(old), Some(new)) => {
                format!("{} over {} mm² → {} over {} mm² {}", value(a), short(old), value(b), short(new), at(b))
            }
            _ => format!("{} → {} {}", value(a), value(b), at(b)),
        },
        (Some(f), None) | (None, Some(f)) => format!("{} {}", value(f), at(f)),
        (None, None) => String::new(),
    }
}

/// Findings that are not passes, with the names of their checks.
fn listed(report: &Report) -> Vec<(&str, &Finding)> {
    let of = |c| -> Vec<(&str, &Finding)> {
        let c: &super::schema::CheckReport = c;
        c.findings.iter().filter(|f| f.state > State::Pass).map(|f| (c.name.as_str(), f)).collect()
    };
    report.checks.iter().flat_map(of).collect()
}

/// How far values may part that differ by the rounding of files alone.
///
/// Lengths are off by a file's resolution, at most 1e-4 mm. That moves an angle, an area or a volume 0.2 mm across by a thousandth, and
/// larger ones by less. Counts, and ratios that stand for one, are told apart.
fn rounding(unit: &str, values: [f64; 4]) -> f64 {
    let largest = values.into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    match unit {
        "mm" => 1e-4,
        "1" | "" => (1e-4 * largest).clamp(1e-6, 0.5),
        _ => (1e-3 * largest).max(1e-6),
    }
}

/// What a pair of brackets in the unit of a finding says: they must part for anything but `Same`.
fn moved(of: &Finding, old: [f64; 2], new: [f64; 2]) -> Delta {
    let slack = rounding(&of.unit, [old[0], old[1], new[0], new[1]]);
    let (below, above) = (new[1] < old[0] - slack, new[0] > old[1] + slack);
    match (of.sense, below, above) {
        (Sense::Min, true, _) | (Sense::Max, _, true) => Delta::Worse,
        (Sense::Min, _, true) | (Sense::Max, true, _) => Delta::Better,
        _ => Delta::Same,
    }
}

fn bracket(s: &Spot) -> [f64; 2] {
    [s.low, s.high]
}

/// The worst of some, or else the best.
fn overall(deltas: impl Iterator<Item = Delta>) -> Delta {
    deltas.fold(Delta::Same, |all, d| match (all, d) {
        (Delta::Worse, _) | (_, Delta::Worse) => Delta::Worse,
        (Delta::Better, _) | (_, Delta::Better) => Delta::Better,
        _ => Delta::Same,
    })
}

/// What became of the finding that most places of a new one were of.
fn became(matched: &Matched, (i, a): (usize, &Finding), (j, b): (usize, &Finding)) -> Delta {
    let [alone_old, alone_new] = [matched.old.alone(i).count(), matched.new.alone(j).count()];
    // What a finding counts and does not place.
    let unplaced = |f: &Finding| f.count.saturating_sub(f.places.len().max(1) as u64);
    let come = alone_new > 0 || unplaced(b) > unplaced(a);
    let gone = alone_old > 0 || unplaced(b) < unplaced(a);
    let counted = [(come, Delta::Worse), (gone, Delta::Better)].into_iter().filter(|c| c.0).map(|c| c.1);
    // What all of it says, where it is the same one.
    let whole = (!come && !gone && a.count == b.count).then(|| moved(b, [a.low, a.high], [b.low, b.high]));
    let places = matched.new.with(j, &matched.old).map(|(new, old)| moved(b, bracket(old), bracket(new)));
    overall(places.chain(counted).chain(whole).chain(spread(a, b)).chain(judged(a.state, b.state)))
}

/// What the areas of two findings say, where they are as many places and the area is not what is judged.
fn spread(a: &Finding, b: &Finding) -> Option<Delta> {
    let [old, new] = [a.area_mm2?, b.area_mm2?];
    if a.count != b.count || b.unit == "mm2" {
        return None;
    }
    let least = b.value.max(a.value).powi(2);
    match (new > GROWN * old + least, old > GROWN * new + least) {
        (true, _) => Some(Delta::Worse),
        (_, true) => Some(Delta::Better),
        _ => None,
    }
}

/// What the verdicts say, by whatever limits: that one fails is news however little its value changed, and by tighter limits it need not have changed.
fn judged(old: State, new: State) -> Option<Delta> {
    match (old, new) {
        (State::Warn | State::Undecided, State::Fail) => Some(Delta::Worse),
        (State::Fail, State::Warn) => Some(Delta::Better),
        _ => None,
    }
}

fn change(delta: Delta, check: &str, old: Option<&Finding>, new: Option<&Finding>) -> Change {
    Change { delta, check: check.into(), old: old.cloned(), new: new.cloned(), new_places_mm: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Basis, Bracket, Limits};

    fn delta(old: f64, new: f64, unit: &str) -> Delta {
        let limits = Limits { fail: Some(new + 1.0), warn: None, sense: Sense::Min };
        let of = Finding::judged("AM101", "wall", Bracket::exact(new), Basis::Exact, limits, unit, 0.0);
        moved(&of, [old; 2], [new; 2])
    }

    #[test]
    fn what_files_round_is_no_change() {
        for (old, new, unit) in
            [(0.444445, 0.44439, "mm"), (40.0, 39.97, "deg"), (250.0, 249.9, "mm2"), (15.0, 14.9999, "1")]
        {
            assert_eq!(delta(old, new, unit), Delta::Same, "{old} {new} {unit}");
        }
        for (old, new, unit) in
            [(0.4444, 0.4441, "mm"), (40.0, 39.9, "deg"), (250.0, 249.0, "mm2"), (9e9, 9e9 - 1.0, "1")]
        {
            assert_eq!(delta(old, new, unit), Delta::Worse, "{old} {new} {unit}");
        }
    }
}
