//! Two reports of one part compared: what is new, fixed, worse, better or the same.
//!
//! Findings are matched by check, kind and place within a tolerance, because geometry moves; those of a part that was moved as a whole
//! by their fingerprints, which are of its own frame. *Worse* and *better* need brackets that part by more than files are rounded, or
//! another number of places: a change inside the uncertainty is no change.

use super::phrase;
use super::schema::{Axis3, Report};
use super::terminal::Palette;
use crate::check::{Finding, Sense, Spot, State};
use crate::error::printable;
use serde::Serialize;
use std::cmp::Ordering;
use std::collections::BTreeSet;

/// What became of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Delta {
    /// Only in the new report.
    New,
    /// In both; the new bracket lies wholly on the worse side of the old, or it stands for more places.
    Worse,
    /// Only in the old report, and its check gave no answer in the new, or one by other limits: nobody knows.
    Unchecked,
    /// In both; the brackets overlap.
    Same,
    /// In both; the new bracket lies wholly on the better side of the old, or it stands for fewer places and is no worse.
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
/// Findings of the same check and kind are paired nearest first, if their places lie within two samples of the coarser
/// grid, or one's place lies in the other's box grown by as much; equal fingerprints pair wherever they are. What was one place of a finding
/// that stands for several is compared with that finding: it left it, or joined it.
///
/// # Cost
/// O(m·n) for m and n findings of one check.
///
/// # Limits
/// Both reports are taken in the frame of their files: of a part that was moved, what has another fingerprint as well is new.
pub fn compare(old: &Report, new: &Report) -> Comparison {
    let tolerance_mm = 2.0 * old.grid.spacing_mm.max(new.grid.spacing_mm);
    let (before, after) = (listed(old), listed(new));
    let mut pairs = Vec::new();
    for (i, (check, a)) in before.iter().enumerate() {
        for (j, (other, b)) in after.iter().enumerate() {
            if check == other && a.kind == b.kind {
                pairs.extend(nearness(a, b, tolerance_mm).map(|d| (d, i, j)));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let (mut old_taken, mut new_taken) = (vec![false; before.len()], vec![false; after.len()]);
    // How many places have left each finding of the old report, and joined each of the new one.
    let [mut left, mut joined] = [&before, &after].map(|list| vec![0u64; list.len()]);
    let mut changes = Vec::new();
    for (_, i, j) in pairs {
        if !old_taken[i] && !new_taken[j] {
            (old_taken[i], new_taken[j]) = (true, true);
            let (a, b) = (before[i].1, after[j].1);
            (left[i], joined[j]) = (a.count.saturating_sub(b.count), b.count.saturating_sub(a.count));
            changes.push(change(counted(a, b), before[i].0, Some(a), Some(b)));
        }
    }
    for (_, (check, f)) in after.iter().enumerate().filter(|(j, _)| !new_taken[*j]) {
        changes.push(match among((check, f), (&before, &mut left), tolerance_mm) {
            Some(i) => change(moved(before[i].1, f), check, Some(before[i].1), Some(f)),
            None => change(Delta::New, check, None, Some(f)),
        });
    }
    for (_, (check, f)) in before.iter().enumerate().filter(|(i, _)| !old_taken[*i]) {
        if let Some(j) = among((check, f), (&after, &mut joined), tolerance_mm) {
            changes.push(change(moved(f, after[j].1), check, Some(f), Some(after[j].1)));
            continue;
        }
        let answered = new
            .checks
            .iter()
            .any(|c| c.name == *check && !matches!(c.state, State::NotRun | State::NotApplicable | State::Error))
            && !other_limits(old, new).iter().any(|key| key.split(['.', '/']).next() == Some(*check));
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
        (Some(a), Some(b)) if a.count != b.count => {
            format!("{} → {}, {} → {} places, {}", value(a), value(b), a.count, b.count, at(b))
        }
        (Some(a), Some(b)) => format!("{} → {} {}", value(a), value(b), at(b)),
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

/// How near two findings are, if they may be the same.
fn nearness(a: &Finding, b: &Finding, tolerance: f64) -> Option<f64> {
    let distance = (0..3).map(|k| (a.at_mm[k] - b.at_mm[k]).powi(2)).sum::<f64>().sqrt();
    let within = |p: Axis3, box_mm: [Axis3; 2]| {
        (0..3).all(|k| p[k] >= box_mm[0][k] - tolerance && p[k] <= box_mm[1][k] + tolerance)
    };
    let near = distance <= tolerance
        || within(a.at_mm, b.box_mm)
        || within(b.at_mm, a.box_mm)
        || (!a.fingerprint.is_empty() && a.fingerprint == b.fingerprint);
    near.then_some(distance)
}

/// How far values may part that differ by the rounding of files alone.
///
/// Lengths are off by a file's resolution, at most 1e-4 mm. That moves an angle, an area or a volume 0.2 mm across by a thousandth, and
/// larger ones by less. Counts, and ratios that stand for one, are told apart.
fn rounding(old: &Finding, new: &Finding) -> f64 {
    let largest = [old.low, old.high, new.low, new.high].into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    match new.unit.as_str() {
        "mm" => 1e-4,
        "1" | "" => (1e-4 * largest).clamp(1e-6, 0.5),
        _ => (1e-3 * largest).max(1e-6),
    }
}

/// What a pair of findings says: the brackets must part for anything but `Same`.
fn moved(old: &Finding, new: &Finding) -> Delta {
    let slack = rounding(old, new);
    let (below, above) = (new.high < old.low - slack, new.low > old.high + slack);
    match (new.sense, below, above) {
        (Sense::Min, true, _) | (Sense::Max, _, true) => Delta::Worse,
        (Sense::Min, _, true) | (Sense::Max, true, _) => Delta::Better,
        _ => Delta::Same,
    }
}

/// The same for a pair that stands for all of its places: more of them are worse.
fn counted(old: &Finding, new: &Finding) -> Delta {
    match (moved(old, new), new.count.cmp(&old.count)) {
        (Delta::Worse, _) | (_, Ordering::Greater) => Delta::Worse,
        (Delta::Same, Ordering::Less) => Delta::Better,
        (delta, _) => delta,
    }
}

/// The finding that one which has no other was a place of, or became one of: as many as that one lacks, or has more, are taken.
fn among(
    (check, f): (&str, &Finding),
    (others, open): (&[(&str, &Finding)], &mut [u64]),
    tolerance: f64,
) -> Option<usize> {
    let holds = |(i, (other, g)): &(usize, &(&str, &Finding))| {
        *other == check && g.kind == f.kind && open[*i] >= f.count && stands_for(g, f.box_mm, tolerance)
    };
    let found = others.iter().enumerate().find(holds).map(|(i, _)| i)?;
    open[found] -= f.count;
    Some(found)
}

/// Whether one of the places that a finding stands for lies in a box.
fn stands_for(f: &Finding, [lo, hi]: [Axis3; 2], tolerance: f64) -> bool {
    let within = |s: &Spot| (0..3).all(|k| s.at_mm[k] >= lo[k] - tolerance && s.at_mm[k] <= hi[k] + tolerance);
    f.places.iter().any(within)
}

fn change(delta: Delta, check: &str, old: Option<&Finding>, new: Option<&Finding>) -> Change {
    Change { delta, check: check.into(), old: old.cloned(), new: new.cloned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Basis, Bracket, Limits};

    fn delta(old: f64, new: f64, unit: &str) -> Delta {
        let of = |value: f64| {
            let limits = Limits { fail: Some(value + 1.0), warn: None, sense: Sense::Min };
            Finding::judged("AM101", "wall", Bracket::exact(value), Basis::Exact, limits, unit, 0.0)
        };
        moved(&of(old), &of(new))
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
