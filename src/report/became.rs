//! What became of a finding that is in two reports: worse, better or the same.

use super::baseline::Delta;
use super::matched::Matched;
use crate::check::{Basis, Finding, Sense, Spot, State};

/// An area that has grown by this share and by a corner is worse, however even the value: on printed parts areas of the same finding differ by up to
/// 3 % from pose to pose, and by 8 % with four times the facets.
const GROWN: f64 = 0.1;
/// Those that are estimated differ by up to 27 %.
const GROWN_ESTIMATE: f64 = 0.5;
/// The least corner, mm²: what is small differs by more.
const CORNER: f64 = 0.5;

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
pub(super) fn became(matched: &Matched, (i, a): (usize, &Finding), (j, b): (usize, &Finding)) -> Delta {
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

/// What became of an old finding whose places joined one that most were not of.
pub(super) fn joined(matched: &Matched, i: usize, f: &Finding) -> Delta {
    overall(matched.old.with(i, &matched.new).map(|(s, t)| moved(f, bracket(s), bracket(t))))
}

/// What the areas of two findings say, where they are as many places and the area is not what is judged.
pub(super) fn spread(a: &Finding, b: &Finding) -> Option<Delta> {
    let [old, new] = [a.area_mm2?, b.area_mm2?];
    if a.count != b.count || b.unit == "mm2" {
        return None;
    }
    let estimated = [a, b].iter().any(|f| f.basis == Basis::Estimated);
    let share = 1.0 + if estimated { GROWN_ESTIMATE } else { GROWN };
    // A corner of what is thin may be there or not, as wide as it is.
    let width = if (b.unit.as_str(), b.sense) == ("mm", Sense::Min) { a.value.max(b.value) } else { 0.0 };
    let least = width.powi(2).max(CORNER);
    match (new > share * old + least, old > share * new + least) {
        (true, _) => Some(Delta::Worse),
        (_, true) => Some(Delta::Better),
        _ => None,
    }
}

/// What the verdicts say, by whatever limits: that one fails, or may fail, is news however little its value changed, and by tighter limits it need not have
/// changed.
fn judged(old: State, new: State) -> Option<Delta> {
    match (old, new) {
        (State::Warn | State::Undecided, State::Fail) | (State::Warn, State::Undecided) => Some(Delta::Worse),
        (State::Fail | State::Undecided, State::Warn) => Some(Delta::Better),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Bracket, Limits};

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
