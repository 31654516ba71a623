//! Which findings somebody accepts, and which acceptances have ended.

use super::contract::Meta;
use super::finding::{Accepted, Finding, Sense, Spot};
use super::registry;
use crate::error::{Result, printable};
use crate::notice::Notice;
use crate::process::{Date, Region, Waiver};
use crate::units::{short, told};
use std::collections::BTreeSet;

/// A place that fills less of its box may lie anywhere in it.
const FILLED: f64 = 0.3;
/// A value that is worse by so small a share is no other: facets of another number differ by as much.
const AS_GOOD: f64 = 0.005;

/// The entries of a process, and what became of each.
pub struct Acceptance<'a> {
    entries: Vec<(&'a Waiver, Fate)>,
    /// The checks that ran, and the kinds of their findings.
    kinds: Vec<(&'static Meta, BTreeSet<String>)>,
    today: Option<Date>,
}

/// What became of an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Fate {
    /// Its check did not run.
    Unasked,
    /// Its check ran and has no such finding.
    Unused,
    /// There is a finding at its place that is more than it allows.
    Exceeded(Excess),
    /// There is such a finding, which stands for other places too.
    Partial,
    Used,
    /// There is such a finding, and the entry no longer holds.
    Ended,
}

/// By what a finding is more than an entry allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Excess {
    Worse,
    Larger,
    Both,
}

impl Excess {
    fn words(self) -> &'static str {
        match self {
            Excess::Worse => "worse",
            Excess::Larger => "larger",
            Excess::Both => "worse and larger",
        }
    }
}

impl<'a> Acceptance<'a> {
    /// The entries on a day; without one, every entry that ends counts as ended.
    ///
    /// # Errors
    /// [`crate::Error::UnknownName`] for a check that is not in the registry.
    pub fn new(waivers: &'a [Waiver], today: Option<Date>) -> Result<Self> {
        waivers.iter().try_for_each(|w| registry::find(&w.check).map(|_| ()))?;
        Ok(Acceptance { entries: waivers.iter().map(|w| (w, Fate::Unasked)).collect(), kinds: Vec::new(), today })
    }

    /// Marks the findings of a check that ran: those whose every place is covered by an entry, by one and the same or by several.
    pub fn apply(&mut self, meta: &'static Meta, findings: &mut [Finding]) {
        self.kinds.push((meta, findings.iter().map(|f| f.kind.clone()).collect()));
        let today = self.today;
        let mut own: Vec<&mut (&Waiver, Fate)> = self.entries.iter_mut().filter(|e| is_of(e.0, meta)).collect();
        own.iter_mut().for_each(|e| e.1 = at_its_place(e.0, findings).max(e.1));
        let has_ended = |w: &Waiver| w.until.is_some_and(|end| today.is_none_or(|today| today > end));
        for f in findings {
            let places = places(f);
            let touching: Vec<usize> =
                (0..own.len()).filter(|&i| places.iter().any(|spot| holds(own[i].0, f, spot))).collect();
            let (ended, valid): (Vec<usize>, Vec<usize>) = touching.iter().partition(|&&i| has_ended(own[i].0));
            let covered =
                |entries: &[usize]| covers(&entries.iter().map(|&i| own[i].0).collect::<Vec<_>>(), f, &places);
            // One entry that holds is enough, whatever has ended beside it.
            let (said, fate) = if covered(&valid) {
                (&valid, Fate::Used)
            } else if covered(&touching) {
                (&ended, Fate::Ended)
            } else {
                (&touching, Fate::Partial)
            };
            let accepted = accepted(said.iter().map(|&i| own[i].0));
            match fate {
                Fate::Used => f.accepted = f.accepted.take().or(accepted),
                Fate::Ended => f.acceptance_ended = f.acceptance_ended.take().or(accepted),
                _ => {}
            }
            said.iter().for_each(|&i| own[i].1 = fate.max(own[i].1));
        }
    }

    /// What the report has to say of entries that ended or accept nothing.
    pub fn notices(&self) -> Vec<Notice> {
        let said = |(waiver, fate): &(&Waiver, Fate)| {
            let entry = format!("the acceptance of {} ({}, {})", waiver.check, waiver.file, waiver.place);
            let end = waiver.until.map_or(String::new(), |d| format!(" on {d}"));
            let notice = match fate {
                Fate::Ended => Notice::new("acceptance-ended", format!("{entry} ended{end}: the finding counts again")),
                Fate::Unused => {
                    Notice::new("acceptance-unused", format!("{entry} meets no finding: {}", self.why_unused(waiver)))
                }
                Fate::Exceeded(by) => Notice::new(
                    "acceptance-unused",
                    format!("{entry} accepts nothing: the finding there is {} than it allows", by.words()),
                ),
                Fate::Partial => Notice::new(
                    "acceptance-unused",
                    format!("{entry} covers only some places of a finding: give one for each, or a box around all"),
                ),
                Fate::Unasked | Fate::Used => return None,
            };
            Some(match waiver.region {
                Region::Ball { at_mm, .. } => notice.at(at_mm),
                _ => notice,
            })
        };
        self.entries.iter().filter_map(said).collect()
    }

    /// Why an entry may meet no finding of a check that ran.
    fn why_unused(&self, waiver: &Waiver) -> String {
        let met = self.kinds.iter().filter(|(meta, _)| is_of(waiver, meta)).flat_map(|(_, kinds)| kinds);
        let met: BTreeSet<&str> = met.map(String::as_str).collect();
        let usual = "it was mended or has moved";
        match waiver.kind.as_deref().filter(|kind| !met.contains(kind)).map(printable) {
            None => usual.into(),
            Some(kind) if met.is_empty() => format!("{usual}, or there is no kind `{kind}`"),
            Some(kind) => {
                let named = met.into_iter().map(|kind| format!("`{kind}`")).collect::<Vec<_>>().join(", ");
                format!("none is of the kind `{kind}`, only of {named}: that is misspelt, or {usual}")
            }
        }
    }
}

/// Whether an entry is of a check.
fn is_of(waiver: &Waiver, meta: &Meta) -> bool {
    let own = waiver.check.trim();
    own == meta.name || own.eq_ignore_ascii_case(meta.code)
}

/// What the report repeats of entries that cover a finding together: their reasons, and the first day on which one ends.
fn accepted<'w>(waivers: impl Iterator<Item = &'w Waiver> + Clone) -> Option<Accepted> {
    let mut reasons: Vec<&str> = Vec::new();
    for waiver in waivers.clone() {
        if !reasons.contains(&waiver.reason.as_str()) {
            reasons.push(&waiver.reason);
        }
    }
    let until = waivers.filter_map(|w| w.until).min();
    (!reasons.is_empty()).then(|| Accepted { reason: reasons.join("; "), until: until.map(|d| d.to_string()) })
}

/// Every place that a finding tells of, its own among them; where that is listed, it is told with its box there.
fn places(f: &Finding) -> Vec<Spot> {
    let own = Spot { at_mm: f.at_mm, box_mm: None, value: f.value, low: f.low, high: f.high };
    let is_listed = f.places.iter().any(|place| place.at_mm == f.at_mm);
    f.places.iter().copied().chain((!is_listed).then_some(own)).collect()
}

/// What becomes of an entry that accepts none of the findings of its check: the one at its place that exceeds it by least says why.
fn at_its_place(waiver: &Waiver, findings: &[Finding]) -> Fate {
    let exceeding = |f: &Finding| {
        let met: Vec<Spot> = places(f).into_iter().filter(|spot| meets(waiver, f, spot)).collect();
        let is_borne = met.iter().any(|spot| bearable(waiver, f, spot));
        match (met.is_empty(), is_borne, is_as_small(waiver, f)) {
            (true, ..) | (_, true, true) => None,
            (_, false, true) => Some(Excess::Worse),
            (_, true, false) => Some(Excess::Larger),
            (_, false, false) => Some(Excess::Both),
        }
    };
    findings.iter().filter_map(exceeding).min().map_or(Fate::Unused, Fate::Exceeded)
}

/// Whether an entry covers one place of a finding, at the value there.
fn holds(waiver: &Waiver, f: &Finding, spot: &Spot) -> bool {
    is_as_small(waiver, f) && meets(waiver, f, spot) && bearable(waiver, f, spot)
}

/// Whether a finding is no larger than an entry allows.
fn is_as_small(waiver: &Waiver, f: &Finding) -> bool {
    waiver.no_larger_than_mm2.is_none_or(|most| f.area_mm2.is_none_or(|area| area <= most))
}

/// Whether an entry is of the kind of a finding and of one place of it.
///
/// An entry anywhere along the box of a place covers it, unless the place is known to fill little of that: on an even wall the mesh alone says which point is told; the box of a wall
/// that stands around other things holds those as well.
fn meets(waiver: &Waiver, f: &Finding, spot: &Spot) -> bool {
    let is_of_kind = waiver.kind.as_ref().is_none_or(|kind| *kind == f.kind);
    is_of_kind
        && match &waiver.region {
            Region::Fingerprint(name) => *name == f.fingerprint,
            region => {
                let fills = |b: &[[f64; 3]; 2]| f.fills(*b).is_none_or(|share| share >= FILLED);
                region.holds(spot.at_mm) || f.box_of(spot).filter(fills).is_some_and(|b| region.is_along(b))
            }
        }
}

/// Whether the value at a place is not worse than an entry allows, or is the one it names, as reports tell it; a name stands for the whole finding.
fn bearable(waiver: &Waiver, f: &Finding, spot: &Spot) -> bool {
    let [value, low, high] = match waiver.region {
        Region::Fingerprint(_) => [f.value, f.low, f.high],
        _ => [spot.value, spot.low, spot.high],
    };
    waiver.no_worse_than.is_none_or(|limit| {
        let slack = AS_GOOD * limit.abs();
        let kept = match f.sense {
            Sense::Min => low >= limit - slack,
            Sense::Max => high <= limit + slack,
        };
        kept || short(told(value, low, high)) == short(limit)
    })
}

/// Whether entries cover every place that a finding stands for; what is not listed one by one lies somewhere in its box, which one of
/// them has to hold.
fn covers(waivers: &[&Waiver], f: &Finding, places: &[Spot]) -> bool {
    let listed = f.count <= f.places.len().max(1) as u64;
    let holds_box = |w: &&Waiver| {
        matches!(w.region, Region::Fingerprint(_)) || corners(f.box_mm).into_iter().all(|p| w.region.holds(p))
    };
    places.iter().all(|spot| waivers.iter().any(|w| holds(w, f, spot))) && (listed || waivers.iter().any(holds_box))
}

fn corners(box_mm: [[f64; 3]; 2]) -> Vec<[f64; 3]> {
    (0..8).map(|i| [0, 1, 2].map(|a| box_mm[i >> a & 1][a])).collect()
}

#[cfg(test)]
mod tests {
    use super::super::finding::{Basis, Bracket, Limits, State, Witness};
    use super::*;
    use crate::process::waivers;

    fn finding(value: f64, at_mm: [f64; 3]) -> Finding {
        let limits = Limits { fail: Some(0.8), warn: None, sense: Sense::Min };
        let mut f = Finding::judged("AM101", "wall", Bracket::exact(value), Basis::Exact, limits, "mm", 0.0);
        (f.at_mm, f.box_mm) = (at_mm, [at_mm; 2]);
        f.fingerprint = format!("AM101/wall/{at_mm:?}");
        f
    }

    fn day(text: &str) -> Option<Date> {
        Some(Date::parse(text).unwrap())
    }

    fn applied(entry: &str, today: Option<Date>, findings: &mut [Finding]) -> Vec<String> {
        let entries = waivers("a.toml", &format!("[[accept]]\ncheck = \"AM101\"\nreason = \"why\"\n{entry}")).unwrap();
        let mut acceptance = Acceptance::new(&entries, today).unwrap();
        acceptance.apply(registry::find("thin-wall").unwrap().meta(), findings);
        acceptance.notices().into_iter().map(|n| n.code).collect()
    }

    #[test]
    fn only_what_lies_wholly_in_the_region_is_accepted() {
        let mut two = [finding(0.4, [0.0; 3]), finding(0.4, [5.0, 0.0, 0.0])];
        assert!(applied("at_mm = [0.5, 0, 0]", None, &mut two).is_empty());
        assert_eq!(two.map(|f| f.accepted.is_some()), [true, false]);
        let mut group = [finding(0.4, [0.0; 3])];
        group[0].places =
            [0.0, 5.0].map(|x| Spot { at_mm: [x, 0.0, 0.0], box_mm: None, value: 0.4, low: 0.4, high: 0.4 }).into();
        group[0].count = 2;
        assert_eq!(applied("at_mm = [0.5, 0, 0]", None, &mut group), ["acceptance-unused"]);
        assert!(applied("box_mm = [[-1, -1, -1], [6, 1, 1]]", None, &mut group).is_empty());
        assert_eq!((group[0].accepted.is_some(), group[0].state), (true, State::Fail));
        // Two entries that cover one place each cover both; so does one by name, as long as there are no more.
        let second = "[[accept]]\ncheck = \"AM101\"\nreason = \"too\"\nat_mm = [5, 0, 0]";
        group[0].accepted = None;
        assert!(applied(&format!("at_mm = [0.5, 0, 0]\n{second}"), None, &mut group).is_empty());
        assert_eq!(group[0].accepted.take().unwrap().reason, "why; too");
        let named = format!("fingerprint = \"{}/x2\"", group[0].fingerprint);
        super::super::name_apart(&mut group);
        assert!(applied(&named, None, &mut group).is_empty() && group[0].accepted.is_some());
        let mut more = [finding(0.4, [0.0; 3])];
        (more[0].count, more[0].places) = (3, vec![group[0].places[0]; 3]);
        super::super::name_apart(&mut more);
        assert_eq!(applied(&named, None, &mut more), ["acceptance-unused"]);
    }

    #[test]
    fn an_entry_ends_after_its_day_and_says_so() {
        let entry = "at_mm = [0, 0, 0]\nuntil = 2027-06-30";
        for (today, holds) in [(day("2027-06-30"), true), (day("2027-07-01"), false), (None, false)] {
            let mut one = [finding(0.4, [0.0; 3])];
            let notices = applied(entry, today, &mut one);
            assert_eq!((one[0].accepted.is_some(), one[0].acceptance_ended.is_some()), (holds, !holds));
            assert_eq!(notices == ["acceptance-ended"], !holds);
        }
    }

    #[test]
    fn another_kind_a_larger_area_and_what_stands_around_are_not_accepted() {
        let entry =
            "kind = \"wall\"\nat_mm = [0, 0, 4]\nwithin_mm = 0.2\nno_worse_than = 0.6\nno_larger_than_mm2 = 100";
        let rib = |area: f64| {
            let mut f = finding(0.7, [0.0, 0.0, 9.0]);
            (f.box_mm, f.area_mm2) = ([[-0.35, -5.0, 0.0], [0.35, 5.0, 10.0]], Some(area));
            f
        };
        let is_accepted = |mut f: Finding| {
            let told = applied(entry, None, std::slice::from_mut(&mut f));
            assert_eq!(f.accepted.is_some(), told.is_empty(), "{told:?}");
            f.accepted.is_some()
        };
        assert!(is_accepted(rib(98.0)) && !is_accepted(rib(120.0)));
        assert!(!is_accepted(Finding { kind: "way-out".into(), ..rib(98.0) }));
        // A tube of 2 mm about the rib: its box holds the place, and it fills a tenth of that.
        let tube = Finding { box_mm: [[-6.0, -6.0, 0.0], [6.0, 6.0, 10.0]], ..rib(98.0) };
        assert!(!is_accepted(tube));
        // As another number of facets has it.
        let other = |low: f64| Finding { low, ..rib(98.0) };
        assert!(is_accepted(other(0.5975)) && !is_accepted(other(0.596)));
    }

    #[test]
    fn a_kind_that_none_is_of_is_told_with_those_that_there_are() {
        let said = |kind: &str, findings: &mut [Finding]| {
            let text = format!(
                "[[accept]]\ncheck = \"AM101\"\nreason = \"why\"\nkind = \"{kind}\"\nat_mm = [0, 0, 0]\nwithin_mm = 0.1"
            );
            let entries = waivers("a.toml", &text).unwrap();
            let mut acceptance = Acceptance::new(&entries, None).unwrap();
            acceptance.apply(registry::find("thin-wall").unwrap().meta(), findings);
            acceptance.notices().into_iter().map(|n| n.message).collect::<String>()
        };
        let body = || Finding { kind: "body".into(), ..finding(0.4, [3.0, 0.0, 0.0]) };
        let both = || [finding(0.4, [0.0; 3]), body()];
        assert_eq!(said("wall", &mut both()), "");
        let misspelt = said("wal", &mut both());
        assert!(
            misspelt.contains("none is of the kind `wal`, only of `body`, `wall`: that is misspelt, or"),
            "{misspelt}"
        );
        // Of a kind that there is, as ever; of none at all nobody knows.
        let moved = said("body", &mut both());
        assert!(moved.ends_with("meets no finding: it was mended or has moved"), "{moved}");
        assert!(said("wal", &mut []).ends_with("it was mended or has moved, or there is no kind `wal`"));
    }

    #[test]
    fn what_is_more_than_an_entry_allows_is_told_as_that() {
        let said = |limits: &str| {
            let mut f = [Finding { area_mm2: Some(484.0), ..finding(0.4, [0.0; 3]) }];
            let entry = format!("[[accept]]\ncheck = \"AM101\"\nreason = \"why\"\nat_mm = [0, 0, 0]\n{limits}");
            let entries = waivers("a.toml", &entry).unwrap();
            let mut acceptance = Acceptance::new(&entries, None).unwrap();
            acceptance.apply(registry::find("thin-wall").unwrap().meta(), &mut f);
            acceptance.notices().into_iter().map(|n| n.message).collect::<String>()
        };
        for (limits, by) in [
            ("no_larger_than_mm2 = 470", "larger"),
            ("no_worse_than = 0.5", "worse"),
            ("no_worse_than = 0.5\nno_larger_than_mm2 = 470", "worse and larger"),
        ] {
            let told = said(limits);
            assert!(told.ends_with(&format!("accepts nothing: the finding there is {by} than it allows")), "{told}");
        }
        assert_eq!(said("no_worse_than = 0.4\nno_larger_than_mm2 = 490"), "");
    }

    #[test]
    fn a_worse_value_and_another_fingerprint_are_not_accepted() {
        let mut f = [finding(0.4, [0.0; 3])];
        assert_eq!(applied("at_mm = [0, 0, 0]\nno_worse_than = 0.5", None, &mut f), ["acceptance-unused"]);
        assert_eq!(applied("fingerprint = \"AM101/wall/else\"", None, &mut f), ["acceptance-unused"]);
        let name = format!("fingerprint = \"{}\"\nno_worse_than = 0.4", f[0].fingerprint);
        assert!(applied(&name, None, &mut f).is_empty() && f[0].accepted.is_some());
    }

    #[test]
    fn one_place_is_accepted_anywhere_along_its_box() {
        let mut wall = [finding(0.4, [0.0, 0.0, 9.0])];
        wall[0].box_mm = [[0.0; 3], [60.0, 0.4, 9.0]];
        assert!(applied("at_mm = [60.5, 0, 5]", None, &mut wall).is_empty() && wall[0].accepted.is_some());
        wall[0].accepted = None;
        assert_eq!(applied("at_mm = [61.5, 0, 5]", None, &mut wall), ["acceptance-unused"]);
        wall[0].count = 2;
        assert_eq!(applied("at_mm = [60.5, 0, 5]", None, &mut wall), ["acceptance-unused"]);
    }

    #[test]
    fn each_place_of_a_group_is_accepted_anywhere_along_its_own_box() {
        let mut walls = [finding(0.4, [0.0; 3])];
        let along_z = |x: f64| Some([[x, 0.0, 0.0], [x + 0.4, 0.0, 9.0]]);
        walls[0].places = [0.0, 20.0]
            .map(|x| Spot { at_mm: [x, 0.0, 0.0], box_mm: along_z(x), value: 0.4, low: 0.4, high: 0.4 })
            .into();
        walls[0].count = 2;
        let second = "[[accept]]\ncheck = \"AM101\"\nreason = \"too\"\nat_mm = [20, 0, 8]";
        assert!(applied(&format!("at_mm = [0, 0, 8]\n{second}"), None, &mut walls).is_empty());
        assert_eq!(walls[0].accepted.take().unwrap().reason, "why; too");
        assert_eq!(applied("at_mm = [0, 0, 8]", None, &mut walls), ["acceptance-unused"]);
    }

    #[test]
    fn a_hole_is_accepted_anywhere_along_its_axis() {
        // 1.5 mm wide through 12 mm, told near one end.
        let hole = || {
            let mut f = finding(1.5, [30.0, 10.0, 8.5]);
            (f.box_mm, f.area_mm2) = ([[29.25, 9.25, 0.0], [30.75, 10.75, 12.0]], Some(1.767));
            let points_mm = vec![f.at_mm, [30.0, 10.0, 12.0], [30.0, 10.0, 0.0]];
            f.witness = Some(Witness { kind: Witness::SECTION.into(), points_mm });
            f
        };
        for z in [-0.4, 1.0, 6.0, 11.0, 12.4] {
            let mut one = [hole()];
            let entry = format!("at_mm = [30, 10, {z}]\nwithin_mm = 0.5\nno_larger_than_mm2 = 2.6");
            assert!(applied(&entry, None, &mut one).is_empty() && one[0].accepted.is_some(), "{z}");
        }
        let mut beyond = [hole()];
        assert_eq!(applied("at_mm = [30, 10, 14]", None, &mut beyond), ["acceptance-unused"]);
        // One that leads round a corner fills little of its box.
        let mut bent = [hole()];
        bent[0].box_mm = [[29.25, 0.0, 0.0], [30.75, 10.75, 12.0]];
        assert_eq!(applied("at_mm = [30, 2, 2]", None, &mut bent), ["acceptance-unused"]);
    }

    #[test]
    fn the_value_that_a_report_tells_is_not_worse_than_itself() {
        let mut exact = [finding(0.592592, [0.0; 3])];
        assert!(applied("at_mm = [0, 0, 0]\nno_worse_than = 0.5926", None, &mut exact).is_empty());
        let mut bracketed = [finding(0.4501, [0.0; 3])];
        bracketed[0].low = 0.41;
        assert!(applied("at_mm = [0, 0, 0]\nno_worse_than = 0.45", None, &mut bracketed).is_empty());
        assert_eq!(applied("at_mm = [0, 0, 0]\nno_worse_than = 0.451", None, &mut bracketed), ["acceptance-unused"]);
    }

    #[test]
    fn an_unknown_check_is_refused() {
        let entries = waivers("a", "[[accept]]\ncheck = \"thin-wal\"\nreason = \"r\"\nat_mm = [0, 0, 0]").unwrap();
        assert!(Acceptance::new(&entries, None).is_err());
    }
}
