//! The directions in which strands are laid across a region.

use super::line::{Side, length};
use super::section::Point;

/// Lines are tried every 15°, counted from the direction that most of the boundary asks for.
const TURNS: usize = 12;
/// Directions that the boundary asks for: across anchored sides and along free ones, those of the greatest length first.
const ASKED: usize = 8;
/// Directions that differ by less are one, radians.
const ALIKE: f64 = 1e-3;

/// Lengths whose ratio is nearer to one are equal, as far as files that were moved or turned tell.
const EQUAL: f64 = 1e-4;

/// The directions of the lines that are tried: those that the boundary asks for, and turns from the first of them.
///
/// Round corners ask for many directions alike. Of equal lengths those go first that follow the longest direction in its turn, whatever the
/// rounding of the coordinates makes of their order.
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
        Some((longest.0, g.iter().map(|(_, l, _)| l).sum::<f64>(), longest.2))
    };
    let mut groups: Vec<(f64, f64, Point)> = all.chunk_by(|a, b| b.0 - a.0 < ALIKE).filter_map(of_group).collect();
    groups.sort_by(|a, b| b.1.total_cmp(&a.1));
    let equal = |a: &(f64, f64, Point), b: &(f64, f64, Point)| b.1 > a.1 * (1.0 - EQUAL);
    let longest = groups.chunk_by(equal).next().into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
    let (from, first) = longest.map_or((0.0, [1.0, 0.0]), |g| (g.0, g.2));
    let turn = |g: &(f64, f64, Point)| {
        let turn = (g.0 - from).rem_euclid(std::f64::consts::PI);
        if turn > std::f64::consts::PI - ALIKE { 0.0 } else { turn }
    };
    groups.chunk_by_mut(equal).for_each(|same| same.sort_by(|a, b| turn(a).total_cmp(&turn(b))));
    let mut lines: Vec<Point> = Vec::new();
    for d in groups.iter().take(ASKED).map(|g| g.2).chain(turned(first, TURNS)) {
        if lines.iter().all(|e| (d[0] * e[1] - d[1] * e[0]).abs() > 1e-6) {
            lines.push(d);
        }
    }
    lines
}

/// So many directions over half a turn, from the first.
pub(super) fn turned(first: Point, count: usize) -> Vec<Point> {
    let turns = (0..count).map(|n| (std::f64::consts::PI * n as f64 / count as f64).sin_cos());
    turns.map(|(s, c)| [c * first[0] - s * first[1], s * first[0] + c * first[1]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rectangle of 80 × 38 mm with round corners of 16 sides each, somewhere.
    fn rounded(away: Point) -> Vec<Side> {
        let corner = |n: usize| {
            let angle =
                std::f64::consts::FRAC_PI_2 * (n % 17) as f64 / 16.0 + std::f64::consts::FRAC_PI_2 * (n / 17) as f64;
            let middle = [[36.0, 15.0], [-36.0, 15.0], [-36.0, -15.0], [36.0, -15.0]][n / 17];
            let at = [middle[0] + 4.0 * angle.cos() + away[0], middle[1] + 4.0 * angle.sin() + away[1]];
            at.map(|x| f64::from(x as f32))
        };
        (0..68).map(|n| Side { from: corner(n), to: corner((n + 1) % 68), anchored: true }).collect()
    }

    #[test]
    fn of_equal_directions_the_same_are_asked_wherever_the_region_lies() {
        let still = directions(&rounded([0.0; 2]));
        assert!(still.len() == ASKED + TURNS - 2, "{still:?}");
        for away in [[0.137, 0.0713], [-3.3, 41.7], [100.0, 200.0]] {
            let moved = directions(&rounded(away));
            let apart = |d: &Point, e: &Point| (d[0] * e[1] - d[1] * e[0]).abs();
            let same = still.len() == moved.len() && still.iter().zip(&moved).all(|(d, e)| apart(d, e) < ALIKE);
            assert!(same, "{away:?}: {still:?} {moved:?}");
        }
    }
}
