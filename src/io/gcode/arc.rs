//! Arcs as chords.

use super::damaged;
use super::words::Words;
use crate::error::Result;
use crate::geometry::vector::{Vec3, distance};
use crate::io::accept;
use crate::units::short;

/// Largest distance between an arc and its chords, mm.
pub(super) const SAGITTA: f64 = 0.001;
/// How far an arc may end off its circle: beyond the first always, beyond the second by this share of the radius, mm; as Grbl
/// 1.1 has it, which slicers' rounding stays within.
const OFF_CIRCLE: (f64, f64, f64) = (0.5, 0.005, 0.001);
/// Most chords of one arc.
const MOST_CHORDS: f64 = 10_000.0;

/// The chords of an arc in the xy plane, `turns` positive counter-clockwise and negative clockwise, and how far it runs beside them; z goes evenly. An
/// arc that ends over its start has as many turns, any other is within one.
pub(super) fn arc(line: u64, from: Vec3, to: Vec3, turns: f64, words: &Words, unit: f64) -> Result<(Vec<Vec3>, f64)> {
    let turn = turns.signum();
    let (i, j, radius) = (words.get(b'I'), words.get(b'J'), words.get(b'R'));
    let centre = match (i, j, radius) {
        (None, None, Some(r)) => centre_of(from, to, r * unit, turn)
            .ok_or_else(|| damaged(line, format!("an arc of radius {r} that does not reach its end")))?,
        (None, None, None) => return Err(damaged(line, "an arc without centre (I, J) or radius (R)".into())),
        _ => [from[0] + i.unwrap_or(0.0) * unit, from[1] + j.unwrap_or(0.0) * unit, from[2]],
    };
    let radius = distance([from[0], from[1], 0.0], [centre[0], centre[1], 0.0]);
    if let Some(problem) = accept::point_problem(centre) {
        return Err(damaged(line, problem));
    }
    let off = (radius - distance([to[0], to[1], 0.0], [centre[0], centre[1], 0.0])).abs();
    if off > OFF_CIRCLE.0 || off > OFF_CIRCLE.1.max(OFF_CIRCLE.2 * radius) {
        return Err(damaged(line, format!("an arc that ends {} mm off its circle", short(off))));
    }
    let angle = |p: Vec3| (p[1] - centre[1]).atan2(p[0] - centre[0]);
    let start = angle(from);
    let full = 2.0 * std::f64::consts::PI;
    let sweep = match (turn * (angle(to) - start)).rem_euclid(full) {
        sweep if sweep < 1e-9 => full * turns.abs(),
        sweep => sweep,
    };
    let step = 2.0 * (1.0 - (SAGITTA / radius.max(SAGITTA)).min(1.0)).acos();
    let chords = (sweep / step.max(1e-3)).ceil().clamp(1.0, MOST_CHORDS);
    let corner = |n: f64| {
        let (sin, cos) = (start + turn * sweep * n / chords).sin_cos();
        [centre[0] + radius * cos, centre[1] + radius * sin, from[2] + (to[2] - from[2]) * n / chords]
    };
    let inner = (1..chords as u32).map(|n| corner(f64::from(n)));
    // The last corner is the end as it is written, so that the next stroke starts there.
    Ok((inner.chain(std::iter::once(to)).collect(), radius * (1.0 - (0.5 * sweep / chords).cos())))
}

/// The centre of an arc from its radius: the shorter arc for a positive one, the longer for a negative.
fn centre_of(from: Vec3, to: Vec3, radius: f64, turn: f64) -> Option<Vec3> {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let chord = dx.hypot(dy);
    let height = radius * radius - 0.25 * chord * chord;
    // Rounding of a half circle's radius in the file must not refuse it.
    if chord == 0.0 || height < -1e-3 * radius * radius {
        return None;
    }
    let along = turn * radius.signum() * height.max(0.0).sqrt() / chord;
    Some([from[0] + 0.5 * dx - along * dy, from[1] + 0.5 * dy + along * dx, from[2]])
}
