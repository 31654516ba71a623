//! What is asked of concave edges: the radius, and what is sharp or mere relief by it.

use super::contract::Context;
use super::finding::Limits;
use crate::part::Part;
use crate::units::short;

/// The check that asks.
pub(super) const CODE: &str = "AM601";
/// A ball that stays further than this share of its radius from the bottom of a notch finds it sharp.
pub(super) const MISSED: f64 = 0.1;
/// Height in fillet radii below which a step is relief, such as text.
pub(super) const RELIEF: f64 = 5.0;
/// Places named one by one.
pub(super) const NAMED: usize = 12;

/// The notches of a part and the radius asked of them.
#[derive(Clone, Copy)]
pub(super) struct Notches<'a> {
    pub part: &'a Part,
    pub context: &'a Context,
    pub limits: Limits,
    /// The radius asked for.
    pub radius: f64,
    /// The least radius that is asked for: where there are two limits, the one below which a round fails.
    pub least: f64,
}

/// What an edge is bent by at least to be sharp.
pub(super) fn sharp_bend() -> f64 {
    2.0 * (1.0 / (1.0 + MISSED)).acos()
}

/// Three digits, for sentences.
pub(super) fn rounded(x: f64) -> String {
    let digits = if x.abs() >= 100.0 { 1.0 } else { 1e3 };
    short((x * digits).round() / digits)
}
