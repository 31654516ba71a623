//! The answer of `amcheck orient`: its data, its JSON, its table for a terminal.

use super::schema::Tool;
use crate::access::{Orientation, Orientations, up_option};
use crate::error::escaped;
use crate::notice::Notice;
use crate::units::short;
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Schema name and version of [`OrientReport`].
pub const ORIENT_SCHEMA: &str = "amcheck-orient/1";

/// Ways to stand a part up, with all that they were compared by.
///
/// Lengths are millimetres, areas mm², volumes mm³; `up` and `rotation` take the frame of the file to that of the build.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OrientReport {
    /// [`ORIENT_SCHEMA`].
    pub schema: String,
    pub tool: Tool,
    /// Name of the file, without its folder.
    pub file: String,
    pub process: String,
    /// Volume of the part, mm³.
    pub volume_mm3: f64,
    /// Whether the surface is closed, as it was read.
    #[serde(default)]
    pub watertight: bool,
    /// What was noticed about the file and how it was read.
    #[serde(default)]
    pub warnings: Vec<Notice>,
    #[serde(flatten)]
    pub orientations: Orientations,
}

/// The data as JSON, the same bytes for the same input.
pub fn json(report: &OrientReport) -> String {
    serde_json::to_string_pretty(report).map_or_else(|_| String::new(), |text| text + "\n")
}

/// A column of the table: its head with the unit, and what its cells say.
pub type Column = (&'static str, fn(&Orientation) -> String);

/// The columns that every table has before those of liquid, and behind them.
const BEFORE: [Column; 6] = [
    ("up", |o| up_option(o.up)),
    ("from", |o| o.from.clone()),
    ("support cm³", |o| between(o.support_low_mm3, o.support_high_mm3, cm3)),
    ("contact mm²", |o| whole(o.contact_mm2)),
    ("on part mm²", |o| between(o.on_part_low_mm2, o.on_part_high_mm2, whole)),
    ("hidden cm³", |o| cm3(o.secluded_mm3)),
];
const BEHIND: [Column; 3] = [
    ("height mm", |o| short((o.box_mm[2] * 10.0).round() / 10.0)),
    ("first layer mm²", |o| whole(o.bed_mm2)),
    ("cost", |o| short((o.cost * 1000.0).round() / 1000.0)),
];

/// Both bounds, or what they both are at the digits that are shown.
fn between(low: f64, high: f64, shown: fn(f64) -> String) -> String {
    let [low, high] = [low, high].map(shown);
    if low == high { low } else { format!("{low}–{high}") }
}

fn cm3(mm3: f64) -> String {
    short((mm3 / 10.0).round() / 100.0)
}

fn whole(v: f64) -> String {
    short(v.round())
}

/// The columns for some orientations: liquid that is kept and cups on the film where there are any.
pub fn columns(list: &[Orientation]) -> Vec<Column> {
    let any = |of: fn(&Orientation) -> f64| list.iter().any(|o| of(o) > 0.0);
    let kept: Option<Column> = any(|o| o.retained_mm3).then_some(("liquid kept cm³", |o| cm3(o.retained_mm3)));
    let cups: Option<Column> = any(|o| o.suction_mm3).then_some(("cups cm³", |o| cm3(o.suction_mm3)));
    BEFORE.into_iter().chain(kept).chain(cups).chain(BEHIND).collect()
}

/// A direction for the eye: at three decimals.
pub fn short_direction(up: [f64; 3]) -> String {
    match up_option(up) {
        axis if axis.len() == 2 => axis,
        _ => up.map(|c| short((c * 1e3).round() / 1e3)).join(", "),
    }
}

/// The table for a terminal; `*` marks what no other row beats in everything, `~` what topples, `!` what does not fit the machine.
pub fn text(report: &OrientReport) -> String {
    let list = &report.orientations.list;
    let columns = columns(list);
    let heads: Vec<String> = columns.iter().map(|c| c.0.to_owned()).collect();
    let cells = list.iter().map(|o| columns.iter().map(|c| c.1(o)).collect());
    let rows: Vec<Vec<String>> = std::iter::once(heads).chain(cells).collect();
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|cell| cell.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns.len()).map(width).collect();
    let mut out =
        format!("{}: {} directions compared, {} in full\n\n", report.file, report.orientations.scored, list.len());
    for (n, r) in rows.iter().enumerate() {
        let mark = match n.checked_sub(1).and_then(|n| list.get(n)) {
            Some(o) if !o.fits => '!',
            Some(o) if o.topples => '~',
            Some(o) if o.pareto => '*',
            _ => ' ',
        };
        let rank = if n == 0 { "  ".to_string() } else { format!("{n:>2}") };
        let _ = write!(out, "{rank} {mark}");
        for (cell, width) in r.iter().zip(&widths) {
            let _ = write!(out, "  {}{cell}", " ".repeat(width - cell.chars().count()));
        }
        out.push('\n');
    }
    out.push_str("\n* no other is at least as good in everything   ~ topples by itself   ! does not fit the machine\n");
    for notice in &report.warnings {
        let _ = writeln!(out, "note: {}", escaped(&notice.message));
    }
    if let Some(best) = list.first() {
        let alas = if best.fits { "" } else { ", but none of these fits the machine" };
        let _ = writeln!(out, "best: --up {}{alas}", up_option(best.up));
    }
    out
}
