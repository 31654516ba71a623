//! What of the exact surface of an offset, an opening or a closing a made one misses.

use crate::geometry::vector::{Vec3, along, dot};
use crate::geometry::{MeshDistance, TriangleMesh, Winding};
use crate::units::{Area, Length};
use rayon::prelude::*;

/// How far from the exact surface a made one may lie, in spacings: creases are blunt by less.
const OFF: f64 = 0.3;
/// How far off it is still measured, in spacings.
const FAR: f64 = 4.0;
/// A facet shows a place whose normal has a larger cosine with its own.
const FACING: f64 = 0.5;
/// Places that are looked at, at most.
const MOST: f64 = 100_000.0;
/// Facets that are looked at for them, at most: where a ball is about as large as a round part, all are about as near.
const MOST_LOOKS: f64 = 3e7;
/// Places of which the cost is taken.
const TRIED: f64 = 64.0;
/// By so much more than the ball, in spacings, a place has to be free: of a wall exactly as thick as the ball is wide nothing need be left.
const CLEAR: f64 = 0.02;
/// Fewer places, or a smaller share of all, are where creases end.
const TOLD: (usize, f64) = (32, 1e-3);

/// A ball that touches a part where the exact surface is, and where on the way from the contact to its centre that is: at the centre for an offset, at the contact for an opening or a
/// closing. Negative lengths are inwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    pub ball: Length,
    pub shift: Length,
}

/// What is missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Missed {
    /// Area of the facets above which the exact surface lies and the made one does not, and its share of all.
    pub area: Area,
    pub share: f64,
    /// How far off the made surface is at most, as far as it is measured, and where.
    pub farthest: Length,
    pub at_mm: Vec3,
}

/// What of the exact surface over the facets of a part, where a ball touches them and no other, lies farther than 0.3 spacings from all facets of the `made` surface that face as
/// it does; `None` where that is no more than ends of creases.
///
/// Places are spread evenly over the area, one for each square of the spacing and 100,000 at most, fewer where each takes long. It shares nothing with what made the surface but the distance.
///
/// # Cost
/// A tree over the made surface and two distances for each place.
pub fn missed(part: &TriangleMesh, contact: Contact, made: &TriangleMesh, spacing: Length) -> Option<Missed> {
    let h = spacing.as_mm();
    let all: f64 = (0..part.triangles.len()).map(|f| part.facet_area(f)).sum();
    let (of_part, of_made) = (MeshDistance::new(part), MeshDistance::new(made));
    let ball = contact.ball.as_mm() + CLEAR * h * if contact.ball.as_mm() < 0.0 { -1.0 } else { 1.0 };
    let looks = |&(x, n): &(Vec3, Vec3)| of_part.looks(along(x, n, ball), ball.abs() * (1.0 - 1e-6));
    let tried: Vec<u64> = places(part, all / TRIED).iter().map(looks).collect();
    let looks = tried.iter().sum::<u64>() as f64 / tried.len().max(1) as f64;
    let each = (h * h).max(all / MOST.min(MOST_LOOKS / looks.max(1.0)));
    let off = |&(x, n): &(Vec3, Vec3)| -> Option<(f64, Vec3, Vec3)> {
        let centre = along(x, n, ball);
        if of_part.nearest(centre, ball.abs() * (1.0 - 1e-6)).is_some() {
            return None;
        }
        let at = along(x, n, contact.shift.as_mm());
        let shown = of_made.nearest_where(at, FAR * h, |f, _| dot(of_made.normal(f), n) > FACING);
        Some((shown.map_or(FAR * h, |n| n.distance), at, centre))
    };
    let places: Vec<(f64, Vec3, Vec3)> = places(part, each).par_iter().filter_map(off).collect();
    let far: Vec<&(f64, Vec3, Vec3)> = places.iter().filter(|p| p.0 > OFF * h).collect();
    if far.len() < TOLD.0 {
        return None;
    }
    // The centre of a facet's ball within other bodies, or beyond all, is no place of the result.
    let winding = Winding::new(part);
    let counts = |p: &&&(f64, Vec3, Vec3)| (winding.at(p.2) > 0.5) == (ball < 0.0);
    let far: Vec<&(f64, Vec3, Vec3)> = far.par_iter().filter(counts).copied().collect();
    let share = far.len() as f64 / places.len().max(1) as f64;
    let farthest = far.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    (far.len() >= TOLD.0 && share >= TOLD.1).then(|| Missed {
        area: Area::mm2(far.len() as f64 * each),
        share,
        farthest: Length::mm(farthest.0),
        at_mm: farthest.1,
    })
}

/// Places on the facets of a mesh with their normals, one for so much area: evenly over it, each somewhere in its facet.
fn places(mesh: &TriangleMesh, each: f64) -> Vec<(Vec3, Vec3)> {
    // The additive recurrence by powers of the plastic number, which spreads evenly over a square.
    const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
    let (mut passed, mut found) = (0.5, Vec::new());
    for facet in 0..mesh.triangles.len() {
        passed += mesh.facet_area(facet) / each;
        let ([a, b, c], normal) = (mesh.corners(facet), mesh.normal(facet));
        while passed >= 1.0 {
            passed -= 1.0;
            let [u, v] = STEP.map(|step| (step * (found.len() + 1) as f64).fract());
            let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
            found.push(([0, 1, 2].map(|x| a[x] + u * (b[x] - a[x]) + v * (c[x] - a[x])), normal));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::{close_by_ball, offset, open_by_ball};
    use super::*;
    use crate::geometry::cuboid;
    use crate::geometry::union::united;

    /// A base of 12 mm with upright walls, turned.
    fn comb(wall: f64, gap: f64) -> TriangleMesh {
        let at = |n: usize| n as f64 * (wall + gap);
        let teeth = (0..8).map(|n| cuboid([at(n), 0.0, 1.0], [at(n) + wall, 5.0, 6.0]));
        let base = cuboid([0.0; 3], [at(7) + wall, 5.0, 1.5]);
        let comb = united(&teeth.fold(base, |all, tooth| all.joined(&tooth)), 1e-6).expect("one solid");
        let (s, c) = 0.4f64.sin_cos();
        comb.transformed([[c, -s * c, s * s], [s, c * c, -c * s], [0.0, s, c]], [0.1, 0.2, 0.3])
    }

    fn told(part: &TriangleMesh, by: f64, h: f64) -> Option<Missed> {
        let (by, h) = (Length::mm(by), Length::mm(h));
        let made = offset(part, by, h).unwrap();
        missed(part, Contact { ball: by, shift: by }, &made.mesh, h)
    }

    #[test]
    fn walls_that_are_left_out_are_told_and_what_shows_is_not() {
        // Walls of 0.16 mm, 0.24 apart, at 0.25 mm: some come out and some do not.
        let lost = told(&comb(0.2, 0.2), -0.02, 0.25).expect("walls");
        assert!(lost.share > 0.05 && lost.area.as_mm2() > 10.0, "{lost:?}");
        for (wall, gap, by, h) in
            [(0.2, 0.2, -0.02, 0.05), (0.6, 0.6, -0.02, 0.25), (0.6, 0.9, 0.1, 0.25), (2.0, 2.0, 0.5, 0.4)]
        {
            assert_eq!(told(&comb(wall, gap), by, h), None, "{wall} {gap} {by} {h}");
        }
        // What nothing is left of is not missed.
        assert_eq!(told(&comb(0.2, 1.0), -0.1, 0.2), None);
    }

    #[test]
    fn openings_and_closings_keep_the_facets_that_their_ball_touches() {
        let (part, h) = (comb(2.4, 2.0), Length::mm(0.4));
        for (made, ball) in
            [(open_by_ball(&part, Length::mm(0.5), h), -0.5), (close_by_ball(&part, Length::mm(0.5), h), 0.5)]
        {
            let made = made.unwrap().mesh;
            let contact = Contact { ball: Length::mm(ball), shift: Length::mm(0.0) };
            assert_eq!(missed(&part, contact, &made, h), None, "{ball}");
            // Another surface does not show it.
            let other = offset(&part, Length::mm(0.3), h).unwrap().mesh;
            let found = missed(&part, contact, &other, h).expect("all of it");
            assert!(found.share > 0.9 && (found.farthest.as_mm() - 0.3).abs() < 0.2, "{found:?}");
        }
    }
}
