//! The ordered list of checks.

use super::contract::{Check, Meta};
use crate::error::{Error, Result, nearest, printable};

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
    let listed = |names: &[String]| names.iter().any(|n| n == meta.name || n.eq_ignore_ascii_case(meta.code));
    match (listed(skip), only.is_empty() || listed(only)) {
        (true, _) => Some("left out by --skip"),
        (false, false) => Some("not in --only"),
        (false, true) => None,
    }
}

/// A check by its code or its name.
///
/// # Errors
/// [`Error::UnknownName`] with the nearest name.
pub fn find(name: &str) -> Result<&'static dyn Check> {
    let wanted = name.trim();
    CHECKS.iter().find(|c| c.meta().name == wanted || c.meta().code.eq_ignore_ascii_case(wanted)).copied().ok_or_else(
        || Error::UnknownName {
            what: "check",
            given: printable(name),
            nearest: nearest(name, metas().flat_map(|m| [m.name, m.code])),
            known: metas().map(|m| m.name.to_string()).collect(),
        },
    )
}
