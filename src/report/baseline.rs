//! Two reports of one part compared: what is new, fixed, worse, better or the same.
//!
//! Findings are matched by check, kind and places within a tolerance, because geometry moves; a part that was moved as a whole, so that its box
//! is as large elsewhere, is taken back first. *Worse* and *better* need brackets of a place that part by more than files are rounded,
//! or places that came or went, or an area that grew or shrank by more than it is known to, or a verdict that became *fail* or was it: a change inside
//! the uncertainty is no other change. What is between bodies that are one now is *worse*: no check can tell of it any more.

use super::became::{became, joined, spread};
use super::matched::{Matched, Named};
use super::one_body::Bodies;
use super::phrase;
use super::schema::{Axis3, BaselineReport, ChangeReport, PartReport, Report};
use super::terminal::Palette;
use crate::check::{Finding, State};
use crate::error::printable;
use crate::units::short;
use serde::Serialize;
use std::cmp::Ordering;
use std::collections::BTreeSet;

/// Sides of two boxes that differ by no more are the same, millimetres.
const SAME_SIDE: f64 = 1e-3;

/// What became of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Delta {
    /// Only in the new report.
    New,
    /// In both; the new bracket of a place lies wholly on the worse side of the old, or a place is new, or it fails and did not. Or in the old report
    /// alone, between bodies that are one now.
    Worse,
    /// Only in the old report, and its check gave no answer in the new, or one by other limits, or there are fewer bodies and a report lists none of them:
    /// nobody knows. Or only in the new report, and its check was not run in the old.
    Unchecked,
    /// In both; the brackets overlap.
    Same,
    /// In both; the new bracket of a place lies wholly on the better side of the old, or a place is gone, or it failed and only warns, and
    /// none is worse or new.
    Better,
    /// Only in the old report, and its check gave an answer in the new by the same limits, and it was not between bodies that are one now.
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
    /// Numbers of the old part's bodies that the old finding was between and that are one now.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub one_body: Vec<u64>,
}

impl Change {
    /// The same, where bodies that the old finding was between are one now: that is worse.
    fn joining(self, bodies: Option<Vec<u64>>) -> Self {
        match bodies {
            Some(one_body) => Change { delta: Delta::Worse, one_body, ..self },
            None => self,
        }
    }

    /// Whether it was accepted, and is not now.
    pub fn is_no_longer_accepted(&self) -> bool {
        let was_accepted = self.old.as_ref().is_some_and(|f| f.accepted.is_some());
        was_accepted && self.new.as_ref().is_some_and(Finding::counts)
    }

    /// What is said of one that was accepted, and is not now.
    pub fn withdrawn(&self) -> Option<&'static str> {
        self.is_no_longer_accepted().then_some("no longer accepted")
    }

    /// Whether it is told by itself, and not only counted.
    pub fn is_told(&self) -> bool {
        self.delta != Delta::Same || self.is_no_longer_accepted()
    }

    /// What became of it, in words: [`from_to`], and that it was accepted if it is not now.
    pub fn words(&self) -> String {
        self.withdrawn().map_or_else(|| from_to(self), |said| format!("{}, {said}", from_to(self)))
    }

    /// The state that `--fail-on new` goes by: of what is new or worse, or was accepted, and is not accepted now; `None` for anything else.
    ///
    /// A gap between bodies that are one now fails where gaps have a limit to fail by: nothing is narrower.
    pub fn news(&self) -> Option<State> {
        let is_news = matches!(self.delta, Delta::New | Delta::Worse) || self.is_no_longer_accepted();
        let told = self.new.as_ref().filter(|f| is_news && f.counts()).map(|f| f.state);
        let joined = self.old.as_ref().filter(|f| !self.one_body.is_empty() && f.counts());
        told.max(joined.map(|f| if f.fail.is_some() { State::Fail } else { State::Warn }))
    }
}

/// The difference of two reports.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// How far a place may have moved and still be the same, millimetres.
    pub tolerance_mm: f64,
    /// What was judged differently, in words: the process, and each limit that is not the same.
    pub conditions: Vec<String>,
    /// Checks that found something and that the old report did not run: `AM101 thin-wall`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_compared: Vec<String>,
    /// How many bodies there were, and are.
    pub bodies: [u64; 2],
    /// New first, then worse, unchecked, same, better, fixed; within these worst first.
    pub changes: Vec<Change>,
}

impl Comparison {
    /// How many findings became this.
    pub fn count(&self, delta: Delta) -> usize {
        self.changes.iter().filter(|c| c.delta == delta).count()
    }

    /// The worst state of what is news: what the exit code goes by under `--fail-on new`.
    pub fn worst_news(&self) -> Option<State> {
        self.changes.iter().filter_map(Change::news).max()
    }

    /// Whether nothing is otherwise than before.
    pub fn is_same(&self) -> bool {
        self.count(Delta::Same) == self.changes.len() && self.bodies[0] == self.bodies[1]
    }

    /// The change that a finding of the new report is.
    pub fn of(&self, finding: &Finding) -> Option<&Change> {
        self.changes.iter().find(|c| c.new.as_ref() == Some(finding))
    }

    /// What cannot be compared: `not compared: the baseline did not run AM101 thin-wall`.
    pub fn not_compared_words(&self) -> Option<String> {
        let list = self.not_compared.join(", ");
        (!list.is_empty()).then(|| format!("not compared: the baseline did not run {list}"))
    }

    /// The number of bodies before and now, where that changed: `bodies 2 → 1`.
    pub fn bodies_words(&self) -> Option<String> {
        let [old, new] = self.bodies;
        (old != new).then(|| format!("bodies {} → {}", phrase::thousands(old), phrase::thousands(new)))
    }

    /// What a report repeats of it.
    pub fn told(&self) -> BaselineReport {
        let words = [Some(self.words()), self.bodies_words()];
        let of = |c: &Change| ChangeReport { delta: c.delta.word().into(), check: c.check.clone(), words: c.words() };
        BaselineReport {
            words: words.into_iter().flatten().collect::<Vec<_>>().join("; "),
            bodies: self.bodies,
            judged_otherwise: self.conditions.clone(),
            not_compared: self.not_compared.clone(),
            changes: self.changes.iter().filter(|c| c.is_told()).map(of).collect(),
        }
    }

    /// The counts as words: `1 new, 2 same`; `no findings in either` for none; `3 same (1 no longer accepted)` where that is news.
    pub fn words(&self) -> String {
        let kinds = [Delta::New, Delta::Worse, Delta::Unchecked, Delta::Same, Delta::Better, Delta::Fixed];
        let parts: Vec<String> = kinds
            .into_iter()
            .map(|d| (d, self.count(d)))
            .filter(|(_, n)| *n > 0)
            .map(|(d, n)| format!("{n} {}", d.word()))
            .collect();
        let withdrawn = self.changes.iter().filter(|c| c.is_no_longer_accepted()).count();
        let withdrawn = if withdrawn > 0 { format!(" ({withdrawn} no longer accepted)") } else { String::new() };
        if parts.is_empty() { "no findings in either".into() } else { parts.join(", ") + &withdrawn }
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
    let bodies = Bodies::of(&old.part, &new.part, by, tolerance_mm);
    let mut changes = Vec::new();
    let mut told = vec![false; before.len()];
    for (j, &(check, f)) in after.iter().enumerate() {
        let Some(i) = matched.new.most(j) else {
            let delta = if was_run(old, check) { Delta::New } else { Delta::Unchecked };
            changes.push(change(delta, check, None, Some(f)));
            continue;
        };
        told[i] = true;
        let new_places_mm = matched.new.alone(j).map(|s| s.at_mm).collect();
        let delta = became(&matched, (i, before[i].1), (j, f));
        let one_body = if matched.old.alone(i).next().is_some() { bodies.now_one(before[i].1) } else { None };
        changes.push(Change { new_places_mm, ..change(delta, check, Some(before[i].1), Some(f)) }.joining(one_body));
    }
    for (i, &(check, f)) in before.iter().enumerate().filter(|(i, _)| !told[*i]) {
        if let Some(j) = matched.old.most(i) {
            changes.push(change(joined(&matched, i, f), check, Some(f), Some(after[j].1)));
            continue;
        }
        let known = is_answered(old, new, check) && !bodies.may_be_one(f);
        let delta = if known { Delta::Fixed } else { Delta::Unchecked };
        changes.push(change(delta, check, Some(f), None).joining(bodies.now_one(f)));
    }
    changes.sort_by(|a, b| {
        let of = |c: &Change| c.new.clone().or(c.old.clone());
        a.delta.cmp(&b.delta).then_with(|| match (of(a), of(b)) {
            (Some(x), Some(y)) => Finding::worst_first(&x, &y),
            _ => Ordering::Equal,
        })
    });
    let bodies = [old.part.bodies, new.part.bodies];
    Comparison {
        tolerance_mm,
        conditions: conditions(old, new),
        not_compared: not_compared(new, &changes),
        bodies,
        changes,
    }
}

/// Whether a report says anything of a check: that it does not apply is an answer, too.
fn was_run(old: &Report, check: &str) -> bool {
    old.checks.iter().any(|c| c.name == check && !matches!(c.state, State::NotRun | State::Error))
}

/// The checks of a report whose findings there is nothing to compare with, in its order.
fn not_compared(new: &Report, changes: &[Change]) -> Vec<String> {
    let is_alone = |c: &Change| c.delta == Delta::Unchecked && c.old.is_none();
    let checks = new.checks.iter().filter(|check| changes.iter().any(|c| is_alone(c) && c.check == check.name));
    checks.map(|check| printable(&format!("{} {}", check.code, check.name))).collect()
}

/// Whether a check gave an answer in the new report, by the limits of the old.
fn is_answered(old: &Report, new: &Report, check: &str) -> bool {
    let ran = |state: State| !matches!(state, State::NotRun | State::NotApplicable | State::Error);
    new.checks.iter().any(|c| c.name == check && ran(c.state))
        && !other_limits(old, new).iter().any(|key| key.split(['.', '/']).next() == Some(check))
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

/// The comparison for a terminal: one line for each change that is told by itself, then the counts.
pub fn text(comparison: &Comparison, palette: Palette) -> String {
    let mut out = String::new();
    for c in comparison.changes.iter().filter(|c| c.is_told()) {
        let state = match c.delta {
            Delta::New | Delta::Worse => State::Fail,
            Delta::Unchecked => State::Undecided,
            _ if c.is_no_longer_accepted() => State::Fail,
            _ => State::Pass,
        };
        out.push_str(&palette.state(state, &format!("{:<10}", c.delta.word())));
        out.push_str(&format!("{:<18} {}\n", printable(&c.check), c.words()));
    }
    for said in &comparison.conditions {
        out.push_str(&format!("judged otherwise: {said}\n"));
    }
    out.extend(comparison.not_compared_words().map(|said| format!("{said}\n")));
    out.extend(comparison.bodies_words().map(|said| format!("{said}\n")));
    out.push_str(&format!("compared with the baseline: {}\n", comparison.words()));
    out
}

/// Values before and after, and the place: `0.45 mm → 0.61 mm at 21.6, 0, 11`; with the number of places where that changed.
pub fn from_to(c: &Change) -> String {
    let value = |f: &Finding| phrase::measured(f.value, f.low, f.high, &f.unit);
    let at = |f: &Finding| format!("at {}", phrase::point(f.at_mm));
    match (&c.old, &c.new) {
        (Some(a), _) if !c.one_body.is_empty() => {
            let list: Vec<String> = c.one_body.iter().take(8).map(u64::to_string).collect();
            let (last, first) =
                list.split_last().map_or((String::new(), String::new()), |(l, f)| (l.clone(), f.join(", ")));
            let others = if c.one_body.len() > 8 { " and others" } else { "" };
            format!("{} {}: bodies {first} and {last}{others} are one body now", value(a), at(a))
        }
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

fn change(delta: Delta, check: &str, old: Option<&Finding>, new: Option<&Finding>) -> Change {
    Change {
        delta,
        check: check.into(),
        old: old.cloned(),
        new: new.cloned(),
        new_places_mm: Vec::new(),
        one_body: Vec::new(),
    }
}
