//! The directions in which strands are laid across a region.

use super::line::{Side, length};
use super::section::Point;

/// Lines are tried every 15°, counted from the direction that most of the boundary asks for.
const TURNS: usize = 12;
/// Directions that the boundary asks for: across anchored sides and along free ones, those of the greatest length first.
const ASKED: usize = 8;
/// Directions that differ by less are one, radians.
const ALIKE: f64 = 1e-3;

/// The directions of the lines that are tried: those that the boundary asks for, and turns from the first of them.
pub(super) fn directions(sides: &[Side]) -> Vec<Point> {
    let asked = |s: &Side| {
        let l = length(s.from, s.to);
        let d = [(s.to[0] - s.from[0]) / l, (s.to[1] - s.from[1]) / l];
        let d = if s.anchored { [d[1], -d[0]] } else { d };
        let angle = d[1].atan2(d[0]).rem_euclid(std::f64::consts::PI);
        // Just below half a turn is just above none.
        let angle = if angle > std::f64::consts::PI - ALIKE { angle - std::f64::consts::PI } else { angle };
        (l > 0.0).then_some((angle, l, d))
    };
    let mut all: Vec<(f64, f64, Point)> = sides.iter().filter_map(asked).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let of_group = |g: &[(f64, f64, Point)]| {
        let longest = g.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((longest.2, g.iter().map(|(_, l, _)| l).sum::<f64>()))
    };
    let mut groups: Vec<(Point, f64)> = all.chunk_by(|a, b| b.0 - a.0 < ALIKE).filter_map(of_group).collect();
    groups.sort_by(|a, b| b.1.total_cmp(&a.1));
    let first = groups.first().map_or([1.0, 0.0], |g| g.0);
    let turns = (0..TURNS).map(|n| (std::f64::consts::PI * n as f64 / TURNS as f64).sin_cos());
    let turns = turns.map(|(s, c)| [c * first[0] - s * first[1], s * first[0] + c * first[1]]);
    let mut lines: Vec<Point> = Vec::new();
    for d in groups.iter().take(ASKED).map(|g| g.0).chain(turns) {
        if lines.iter().all(|e| (d[0] * e[1] - d[1] * e[0]).abs() > 1e-6) {
            lines.push(d);
        }
    }
    lines
}
