//! The ordered list of checks.

use super::contract::{Check, Meta};
use crate::error::{Error, Result, nearest, printable};
use crate::notice::Notice;
use crate::process::Process;

/// All checks, in the order of the report.
pub const CHECKS: &[&dyn Check] = &[
    &super::mesh::Mesh,
    &super::build_volume::BuildVolume,
    &super::thin_wall::ThinWall,
    &super::thin_pin::ThinPin,
    &super::narrow_gap::NarrowGap,
    &super::lost_feature::LostFeature,
    &super::small_hole::SmallHole,
    &super::knife_edge::KnifeEdge,
    &super::overhang::Overhang,
    &super::island::Island,
    &super::bridge::Bridge,
    &super::support::Support,
    &super::tall_feature::TallFeature,
    &super::bed_contact::BedContact,
    &super::trapped_volume::TrappedVolume,
    &super::drain::Drain,
    &super::topology::Topology,
    &super::support_access::SupportAccess,
    &super::tool_access::ToolAccess,
    &super::offset::Offset,
    &super::as_printed::AsPrinted,
    &super::blend::Blend,
];

/// The text of every check, in order.
pub fn metas() -> impl Iterator<Item = &'static Meta> {
    CHECKS.iter().map(|c| c.meta())
}

/// Why a check does not run, if it does not: lists hold names or codes, and an empty `only` is all.
pub fn left_out(meta: &Meta, only: &[String], skip: &[String]) -> Option<&'static str> {
    let listed = |names: &[String]| names.iter().any(|n| is_called(meta, n));
    match (listed(skip), only.is_empty() || listed(only)) {
        (true, _) => Some("left out by --skip"),
        (false, false) => Some("not in --only"),
        (false, true) => None,
    }
}

/// Whether a name, with blanks around it or none, is a check's: its name or its code.
fn is_called(meta: &Meta, name: &str) -> bool {
    let name = name.trim();
    name == meta.name || name.eq_ignore_ascii_case(meta.code)
}

/// Says of typed limits whose check does not run that nothing is judged by them.
pub fn idle_limits(process: &Process, only: &[String], skip: &[String]) -> Vec<Notice> {
    let typed = |name: &str| {
        let of_check = |key: &str| key.split('.').next() == Some(name);
        process.limits.iter().any(|(key, limit)| of_check(key) && limit.is_typed())
    };
    let idle = metas().filter(|m| left_out(m, only, skip).is_some() && typed(m.name));
    let text = |m: &Meta| {
        format!(
            "the limit of {} was given, and that check does not run: nothing is judged by it, though others may reckon with it",
            m.name
        )
    };
    idle.map(|m| Notice::new("limit-idle", text(m))).collect()
}

/// Refuses lists that name what is no check: [`left_out`] would run less than was asked for.
///
/// # Errors
/// As [`find`], for the first such name.
pub fn all_known(only: &[String], skip: &[String]) -> Result<()> {
    only.iter().chain(skip).try_for_each(|name| find(name).map(|_| ()))
}

/// A check by its code or its name.
///
/// # Errors
/// [`Error::UnknownName`] with the nearest name.
pub fn find(name: &str) -> Result<&'static dyn Check> {
    CHECKS.iter().find(|c| is_called(c.meta(), name)).copied().ok_or_else(|| Error::UnknownName {
        what: "check",
        given: printable(name),
        nearest: nearest(name, metas().flat_map(|m| [m.name, m.code])),
        known: metas().map(|m| m.name.to_string()).collect(),
    })
}

/// The key of a limit with the name of its check where it begins with the code: `AM103.between-bodies=0.4mm` is one of `narrow-gap`.
pub fn named(key: &str) -> String {
    let end = key.find(['.', '=']).unwrap_or(key.len());
    let (code, rest) = key.split_at(end);
    let by_code = metas().find(|m| m.code.eq_ignore_ascii_case(code.trim()));
    by_code.map_or(key.to_string(), |m| format!("{}{rest}", m.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_name_checks_by_code_or_name_and_nothing_else() {
        let list = |names: &[&str]| names.iter().map(|n| n.to_string()).collect::<Vec<_>>();
        let known = list(&["thin-wall", "am103", " mesh "]);
        all_known(&known, &known).unwrap();
        let run = metas().filter(|m| left_out(m, &known, &[]).is_none()).map(|m| m.name);
        assert!(run.eq(["mesh", "thin-wall", "narrow-gap"]));
        for (only, skip) in [(list(&["thinwall"]), list(&[])), (list(&["mesh"]), list(&["AM999"]))] {
            assert!(matches!(all_known(&only, &skip), Err(Error::UnknownName { .. })));
        }
    }

    #[test]
    fn limits_are_named_by_code_as_well() {
        for (key, is) in [
            ("AM101=0.4mm,0.6mm", "thin-wall=0.4mm,0.6mm"),
            ("am103.between-bodies=0.4mm", "narrow-gap.between-bodies=0.4mm"),
            ("thin-wall=0.4mm", "thin-wall=0.4mm"),
            ("AM1=0.4mm", "AM1=0.4mm"),
            ("AM101", "thin-wall"),
            ("=.", "=."),
        ] {
            assert_eq!(named(key), is);
        }
    }
}
