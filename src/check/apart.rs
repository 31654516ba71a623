//! Whether two bodies that are too near each other can be moved apart: one is moved, and what it then comes near is measured.

use crate::geometry::vector::{Vec3, add, along, bounds, sub, unit};
use crate::geometry::{BodyPair, MeshDistance, TriangleMesh};
use crate::part::Part;
use crate::units::short;

/// Facets of a body that is moved, and of what lies around it, at most.
const MOST_FACETS: usize = 20_000;
/// Pairs that are tried, the nearest first.
pub const TRIED: usize = 16;

/// Whether either body of a pair can be moved straight away from the other until they are `to` apart, with nothing nearer to it
/// than that; `None` where both have too many facets to try.
///
/// # Cost
/// Two small trees and one walk over both, for each of the two.
pub fn can_part(part: &Part, pair: &BodyPair, to: f64) -> Option<bool> {
    let by = to - pair.distance;
    let [p, q] = pair.points;
    let ways = [unit(sub(p, q)), unit(sub(q, p))];
    let tries = [0, 1].map(|n| is_clear(part, pair.bodies[n], ways[n].map(|x| x * by), to));
    match tries {
        [Some(true), _] | [_, Some(true)] => Some(true),
        [None, None] => None,
        _ => Some(false),
    }
}

/// Whether a body that is moved stays above the plate and has nothing nearer than a distance.
fn is_clear(part: &Part, body: u32, by: Vec3, distance: f64) -> Option<bool> {
    let [lo, hi] = part.health().bodies.get(body as usize)?.box_mm;
    let own = facets_in(part, (lo, hi), |of| of == body)?;
    let around = (add(lo, by).map(|x| x - distance), add(hi, by).map(|x| x + distance));
    let others = facets_in(part, around, |of| of != body)?;
    if add(lo, by)[2] < part.mesh().bounds().map_or(0.0, |b| b.0[2]) - part.tie() {
        return Some(false);
    }
    let moved = |f: usize| part.mesh().corners(f).map(|p| along(p, by, 1.0));
    let moved = TriangleMesh::weld(own.into_iter().map(moved));
    let others = MeshDistance::of_facets(part.mesh(), others);
    Some(MeshDistance::new(&moved).pair_distance(&others, distance - part.tie()).is_none())
}

/// The facets that reach into a box and whose body counts, in increasing order; `None` if they are too many.
fn facets_in(part: &Part, (lo, hi): (Vec3, Vec3), counts: impl Fn(u32) -> bool) -> Option<Vec<usize>> {
    let mut found = Vec::new();
    part.distance().tree().in_box((lo, hi), |f| {
        let body = part.health().facet_body.get(f as usize).copied();
        let reaches = bounds(part.mesh().corners(f as usize))
            .is_some_and(|(from, to)| (0..3).all(|a| from[a] <= hi[a] && lo[a] <= to[a]));
        if reaches && body.is_some_and(&counts) && part.bounds_solid(f as usize) {
            found.push(f as usize);
        }
    });
    found.sort_unstable();
    (found.len() <= MOST_FACETS).then_some(found)
}

/// What is said of moving bodies apart, from what trying it has shown; the sentence to go on with where it does not work everywhere.
pub fn words(tries: &[Option<bool>], to: f64, otherwise: &str) -> String {
    let count = |answer: Option<bool>| tries.iter().filter(|t| **t == answer).count();
    let (clear, blocked, to) = (count(Some(true)), count(Some(false)), short(to));
    match (clear, blocked) {
        (0, 0) => otherwise.to_string(),
        (_, 0) => format!("move them to {to} mm apart: there is room for it, checked on the surface"),
        (0, _) => {
            format!("{otherwise}; moved apart, one would come nearer than {to} mm to what is beside it")
        }
        (n, m) => format!("move them to {to} mm apart, for which {n} of {} have room, or {otherwise}", n + m),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::part::Up;

    fn row(gaps: &[f64]) -> Part {
        let mut at = 0.0;
        let mut mesh = cuboid([0.0; 3], [4.0, 6.0, 6.0]);
        for gap in gaps {
            at += 4.0 + gap;
            mesh = mesh.joined(&cuboid([at, 0.0, 0.0], [at + 4.0, 6.0, 6.0]));
        }
        Part::new(mesh, Up::PlusZ, 1e-6, 2.0).unwrap()
    }

    fn nearest(part: &Part) -> BodyPair {
        *part.body_pairs().iter().min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap()
    }

    #[test]
    fn what_stands_beside_others_is_moved_if_either_of_a_pair_has_room() {
        let tried = |gaps: &[f64], to| {
            let part = row(gaps);
            can_part(&part, &nearest(&part), to)
        };
        assert_eq!(tried(&[0.1], 0.6), Some(true));
        // The outer one of three is moved away.
        assert_eq!(tried(&[0.1, 0.6], 0.6), Some(true));
        // Both have a neighbour 1.0 away, which leaves 0.5.
        assert_eq!(tried(&[1.0, 0.1, 1.0], 0.6), Some(false));
        assert_eq!(tried(&[1.1, 0.1, 1.1], 0.6), Some(true));
    }

    #[test]
    fn a_peg_in_its_hole_cannot_be_moved_away_from_one_side() {
        let (outer, hole) = (cuboid([0.0; 3], [20.0; 3]), cuboid([5.0; 3], [15.0; 3]));
        let peg = cuboid([5.2; 3], [14.8; 3]);
        let part = Part::new(outer.joined(&hole.flipped()).joined(&peg), Up::PlusZ, 1e-6, 2.0).unwrap();
        assert_eq!(can_part(&part, &nearest(&part), 0.3), Some(false));
    }

    #[test]
    fn what_does_not_fit_is_not_advised() {
        let said = |tries: &[Option<bool>]| words(tries, 0.6, "open it");
        assert!(said(&[Some(true); 2]).starts_with("move them to 0.6 mm apart: there is room"));
        assert!(!said(&[Some(false)]).contains("move them") && said(&[Some(false), None]).starts_with("open it;"));
        assert_eq!(said(&[None]), "open it");
        assert!(said(&[Some(true), Some(false)]).contains("1 of 2 have room"));
    }
}
