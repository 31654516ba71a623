//! A limit given on the command line.

use super::limit::{Limit, LimitBasis, TYPED};
use super::profile::Process;
use super::rule::{RULES, Rule, rule};
use crate::error::{Error, Result, printable};

impl Process {
    /// Puts a limit from the command line in place: `thin-wall=0.4mm` or `thin-wall=0.4mm,0.6mm` (fail, warn).
    ///
    /// A warn limit that is not given stays if it is not weaker than the new fail limit. A key without kind, such as
    /// `narrow-gap`, sets all its kinds that are limited in the same unit.
    ///
    /// # Errors
    /// [`Error::Usage`] or [`Error::UnknownName`] for what cannot be read or contradicts itself.
    pub fn override_limit(&mut self, assignment: &str) -> Result<()> {
        let (key, values) = assignment.split_once('=').ok_or_else(|| Error::Usage {
            problem: format!("limit `{}` has no value", printable(assignment)),
            remedy: "write --limit thin-wall=0.4mm or --limit thin-wall=0.4mm,0.6mm".into(),
        })?;
        let key = key.trim();
        let named = rule(key)?;
        let (first, second) = values.split_once(',').map_or((values, None), |(first, second)| (first, Some(second)));
        if second.is_some_and(|second| is_decimal_comma(first, second)) {
            return Err(Error::Usage {
                problem: format!("limit {key}: `{}` may be one number or two", printable(values)),
                remedy: "the decimal sign is a point: write 0.8mm; for fail and warn give both their unit: 2mm,3mm"
                    .into(),
            });
        }
        let fail = named.dimension.parse(first)?;
        let warn = second.map(|w| named.dimension.parse(w)).transpose()?;
        let same = |r: &&Rule| r.key == key || r.dimension == named.dimension;
        for r in RULES.iter().filter(|r| r.follows(key)).filter(same) {
            let stricter = |w: f64| r.bound.is_stricter(w, fail);
            if let Some(w) = warn
                && !stricter(w)
                && w != fail
            {
                return Err(Error::Usage {
                    problem: format!("limit {key}: warn {w} would never be reached beside fail {fail}"),
                    remedy: "give the fail limit first; the warn limit is the stricter one".into(),
                });
            }
            let kept = self.limits.get(r.key).and_then(|l| l.warn).filter(|&w| stricter(w));
            self.limits.insert(
                r.key.into(),
                Limit {
                    fail: Some(fail),
                    warn: warn.or(kept),
                    basis: LimitBasis::User,
                    source: TYPED.into(),
                    overridden: true,
                },
            );
        }
        Ok(())
    }
}

/// Whether what stands before and after a comma may be one number: `0,8mm` or `0,8`, but not `0.8mm,1.2mm`, `0.8,1.2` or `2,3`.
fn is_decimal_comma(first: &str, second: &str) -> bool {
    let first = first.trim();
    let unit = second.trim_start_matches(|c: char| c.is_ascii_digit());
    let whole = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let named = !unit.trim().is_empty() && !unit.starts_with('.');
    whole(first)
        && second.starts_with(|c: char| c.is_ascii_digit())
        && (named || first == "0" && unit.trim().is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decimal_comma_is_refused_and_two_limits_are_read() {
        let limited = |text: &str| {
            let mut process = Process::named("fdm").unwrap();
            process.override_limit(text).map(|()| process.limits["thin-wall"].clone())
        };
        for text in ["0,8mm", "0,8", "1,2mm", "0,8 mm", "10,5in"] {
            let refused = limited(&format!("thin-wall={text}")).unwrap_err();
            assert!(refused.remedy().contains("decimal sign is a point"), "{text}");
        }
        for (text, fail, warn) in [
            ("0.8mm,1.2mm", 0.8, 1.2),
            ("0.8,1.2", 0.8, 1.2),
            ("1,2", 1.0, 2.0),
            ("1mm,2mm", 1.0, 2.0),
            ("0.8,2mm", 0.8, 2.0),
        ] {
            let limit = limited(&format!("thin-wall={text}")).unwrap();
            assert_eq!((limit.fail, limit.warn), (Some(fail), Some(warn)), "{text}");
        }
        assert_eq!(limited("thin-wall=0.5").unwrap().fail, Some(0.5));
    }
}
