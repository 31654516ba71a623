//! What somebody accepts: a check at a place, with a reason and a day on which that ends.

use super::date::Date;
use crate::error::{Error, Place, Result, escaped, printable};
use serde::Deserialize;
use toml::{Spanned, Value};

/// How far from a point an accepted place may be where the entry does not say.
const WITHIN_MM: f64 = 1.0;

/// One `[[accept]]` entry.
///
/// A finding is accepted where its check is the entry's, and its kind if the entry names one, and every place it stands for lies in the region of such
/// an entry, with a value there that is not worse and an area that is not larger than the entry allows; where it is one place, a point near its box
/// will do, unless it is known to fill little of that. It is shown all the same, and does not count until the entry ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Waiver {
    /// Name or code of a check.
    pub check: String,
    pub region: Region,
    /// The kind of finding, where the check has several: a value of one says nothing of another.
    pub kind: Option<String>,
    /// The largest area that is accepted.
    pub no_larger_than_mm2: Option<f64>,
    /// The worst value that is accepted, in the unit of the finding.
    pub no_worse_than: Option<f64>,
    pub reason: String,
    /// The last day on which it holds.
    pub until: Option<Date>,
    /// The file it stands in, and where, for messages.
    pub file: String,
    pub place: Place,
}

impl Waiver {
    /// What is wrong with it, where it stands.
    pub fn refused(&self, why: &Error) -> Error {
        Error::Profile {
            file: self.file.clone(),
            place: self.place.clone(),
            problem: format!("[[accept]]: {why}"),
            remedy: why.remedy(),
        }
    }
}

/// Where a finding is accepted, in the frame of the input file, millimetres.
#[derive(Debug, Clone, PartialEq)]
pub enum Region {
    Ball { at_mm: [f64; 3], within_mm: f64 },
    Box { box_mm: [[f64; 3]; 2] },
    Fingerprint(String),
}

impl Region {
    /// Whether a point lies in it; a fingerprint is no set of points and holds none.
    pub fn holds(&self, p: [f64; 3]) -> bool {
        match self {
            Region::Ball { at_mm, within_mm } => {
                (0..3).map(|a| (p[a] - at_mm[a]).powi(2)).sum::<f64>() <= within_mm * within_mm
            }
            Region::Box { box_mm: [lo, hi] } => (0..3).all(|a| lo[a] <= p[a] && p[a] <= hi[a]),
            Region::Fingerprint(_) => false,
        }
    }

    /// Whether it is a point no further from a box than the entry says.
    pub fn is_along(&self, [lo, hi]: [[f64; 3]; 2]) -> bool {
        let nearest = |p: [f64; 3]| [0, 1, 2].map(|a| p[a].max(lo[a]).min(hi[a]));
        matches!(self, Region::Ball { at_mm, .. } if self.holds(nearest(*at_mm)))
    }
}

/// The entries of a file; other tables in it are left to their own readers.
#[derive(Deserialize)]
struct Entries {
    #[serde(default)]
    accept: Vec<Spanned<Entry>>,
}

/// A file of entries and nothing else.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OnlyEntries {
    #[serde(default)]
    accept: Vec<Spanned<Entry>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    check: String,
    kind: Option<String>,
    no_larger_than_mm2: Option<f64>,
    reason: String,
    until: Option<Value>,
    fingerprint: Option<String>,
    at_mm: Option<[f64; 3]>,
    within_mm: Option<f64>,
    box_mm: Option<[[f64; 3]; 2]>,
    no_worse_than: Option<f64>,
}

/// The `[[accept]]` entries of a process file.
///
/// # Errors
/// [`Error::Profile`] with the line of an unknown key, a missing one, or a value that makes no sense.
pub(super) fn in_profile(file: &str, text: &str) -> Result<Vec<Waiver>> {
    let entries: Entries = toml::from_str(text).map_err(|e| unreadable(file, text, &e))?;
    entries.accept.into_iter().map(|e| waiver(file, text, e)).collect()
}

/// The entries of a file that holds nothing but `[[accept]]`.
///
/// # Errors
/// [`Error::Profile`] with the line of an unknown key, a missing one, or a value that makes no sense.
///
/// ```
/// let text = "[[accept]]\ncheck = \"thin-wall\"\nat_mm = [16.8, 5.9, 13]\nreason = \"a membrane\"\nuntil = 2027-06-30\n";
/// let entries = amcheck::process::waivers("accept.toml", text).unwrap();
/// assert!(entries[0].region.holds([16.75, 5.9, 13.0]));
/// assert!(amcheck::process::waivers("accept.toml", &text.replace("until", "till")).is_err());
/// ```
pub fn waivers(file: &str, text: &str) -> Result<Vec<Waiver>> {
    let entries: OnlyEntries = toml::from_str(text).map_err(|e| unreadable(file, text, &e))?;
    entries.accept.into_iter().map(|e| waiver(file, text, e)).collect()
}

fn unreadable(file: &str, text: &str, e: &toml::de::Error) -> Error {
    Error::Profile {
        file: printable(file),
        place: e.span().map_or(Place::Whole, |s| line_of(text, s.start)),
        problem: escaped(&e.message().trim().replace('\n', " ")),
        remedy: "an [[accept]] entry has check, reason, one of at_mm, box_mm and fingerprint, and may have kind, within_mm, \
                 no_worse_than, no_larger_than_mm2 and until"
            .into(),
    }
}

fn line_of(text: &str, byte: usize) -> Place {
    Place::Line(1 + text.bytes().take(byte).filter(|b| *b == b'\n').count() as u64)
}

fn waiver(file: &str, text: &str, entry: Spanned<Entry>) -> Result<Waiver> {
    let place = line_of(text, entry.span().start);
    let entry = entry.into_inner();
    let bad = |problem: &str, remedy: &str| Error::Profile {
        file: printable(file),
        place: place.clone(),
        problem: format!("[[accept]] of {}: {problem}", printable(&entry.check)),
        remedy: remedy.into(),
    };
    let finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
    let region = match (&entry.fingerprint, entry.at_mm, entry.box_mm) {
        (Some(name), None, None) => Region::Fingerprint(name.clone()),
        (None, Some(at_mm), None) if finite(&at_mm) => {
            let within_mm = entry.within_mm.unwrap_or(WITHIN_MM);
            if !(within_mm.is_finite() && within_mm > 0.0) {
                return Err(bad("within_mm is not a positive number", "give a radius in millimetres, such as 1.0"));
            }
            Region::Ball { at_mm, within_mm }
        }
        (None, None, Some(box_mm)) if finite(box_mm.as_flattened()) => {
            if (0..3).any(|a| box_mm[0][a] > box_mm[1][a]) {
                return Err(bad("box_mm is empty", "give the least corner first: [[0, 0, 0], [10, 10, 5]]"));
            }
            Region::Box { box_mm }
        }
        (None, None, None) => {
            return Err(bad("no place is given", "give at_mm = [x, y, z], box_mm, or the finding's fingerprint"));
        }
        _ => return Err(bad("the place is not one finite place", "give exactly one of at_mm, box_mm and fingerprint")),
    };
    if entry.within_mm.is_some() && !matches!(region, Region::Ball { .. }) {
        return Err(bad("within_mm without at_mm", "leave it out, or give at_mm"));
    }
    if entry.no_worse_than.is_some_and(|x| !x.is_finite()) {
        return Err(bad("no_worse_than is not a number", "give the value in the unit of the finding, such as 0.4"));
    }
    if entry.no_larger_than_mm2.is_some_and(|x| !(x.is_finite() && x >= 0.0)) {
        return Err(bad("no_larger_than_mm2 is no area", "give square millimetres, such as 30"));
    }
    if !entry.reason.chars().any(char::is_alphanumeric) {
        return Err(bad("no reason is given", "say why it is accepted; the report repeats it"));
    }
    let until = match &entry.until {
        None => None,
        Some(value) => {
            let text = match value {
                Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            Some(Date::parse(&text).map_err(|e| bad(&e.to_string(), "write a day: until = 2027-06-30"))?)
        }
    };
    Ok(Waiver {
        check: entry.check,
        region,
        kind: entry.kind,
        no_larger_than_mm2: entry.no_larger_than_mm2,
        no_worse_than: entry.no_worse_than,
        reason: entry.reason.trim().to_string(),
        until,
        file: printable(file),
        place,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "[[accept]]\ncheck = \"thin-wall\"\nat_mm = [1, 2, 3.5]\nreason = \"r\"\n";

    #[test]
    fn an_entry_may_name_a_kind_and_the_largest_area() {
        let w = &waivers("a.toml", &format!("{GOOD}kind = \"wall\"\nno_larger_than_mm2 = 30\n")).unwrap()[0];
        assert_eq!((w.kind.as_deref(), w.no_larger_than_mm2), (Some("wall"), Some(30.0)));
        let e = waivers("a.toml", &format!("{GOOD}no_larger_than_mm2 = -1\n")).unwrap_err();
        assert!(e.to_string().contains("no_larger_than_mm2 is no area"), "{e}");
    }

    #[test]
    fn an_entry_is_read_with_its_defaults() {
        let w = &waivers("a.toml", GOOD).unwrap()[0];
        assert_eq!(w.region, Region::Ball { at_mm: [1.0, 2.0, 3.5], within_mm: 1.0 });
        assert_eq!((w.until, w.file.as_str(), w.place.to_string()), (None, "a.toml", "line 1".into()));
        let dated = waivers("a.toml", &format!("{GOOD}until = 2027-06-30\n")).unwrap();
        assert_eq!(dated[0].until, Some(Date::parse("2027-06-30").unwrap()));
        assert_eq!(waivers("a.toml", &format!("{GOOD}until = \"2027-06-30\"\n")).unwrap(), dated);
        // What is left when the last entry goes.
        assert_eq!(waivers("a.toml", "# none\n").unwrap(), []);
    }

    #[test]
    fn every_mistake_is_refused_and_named() {
        for (spoilt, expected) in [
            (format!("{GOOD}untill = 2027-06-30\n"), "untill"),
            (format!("{GOOD}until = 2027-06-31\n"), "date"),
            (format!("{GOOD}until = 2027\n"), "no date"),
            (format!("{GOOD}until = 2027-06-30T10:00:00Z\n"), "no date"),
            (format!("{GOOD}box_mm = [[0, 0, 0], [1, 1, 1]]\n"), "one finite place"),
            (format!("{GOOD}within_mm = -1\n"), "within_mm"),
            (format!("{GOOD}[machine]\n"), "machine"),
            (GOOD.replace("at_mm = [1, 2, 3.5]\n", ""), "no place"),
            (GOOD.replace("at_mm = [1, 2, 3.5]", "at_mm = [1, 2]"), ""),
            (GOOD.replace("at_mm = [1, 2, 3.5]", "at_mm = [1, 2, nan]"), "finite"),
            (GOOD.replace("at_mm = [1, 2, 3.5]", "box_mm = [[0, 0, 9], [1, 1, 1]]"), "empty"),
            (GOOD.replace("at_mm = [1, 2, 3.5]", "fingerprint = \"f\"\nwithin_mm = 2"), "within_mm"),
            (GOOD.replace("\"r\"", "\" \""), "no reason"),
            (GOOD.replace("\"r\"", "\"…\""), "no reason"),
            (GOOD.replace("reason = \"r\"\n", ""), "reason"),
        ] {
            let error = waivers("a.toml", &spoilt).expect_err(&spoilt);
            assert!(error.to_string().contains(expected), "{spoilt}: {error}");
        }
    }

    #[test]
    fn regions_hold_their_border() {
        let ball = Region::Ball { at_mm: [0.0; 3], within_mm: 2.0 };
        assert!(ball.holds([2.0, 0.0, 0.0]) && !ball.holds([1.5, 1.5, 0.0]));
        let cuboid = Region::Box { box_mm: [[0.0; 3], [1.0, 2.0, 3.0]] };
        assert!(cuboid.holds([1.0, 2.0, 0.0]) && !cuboid.holds([1.0, 2.1, 0.0]));
    }
}
