//! What one facet is in the way of: balls on a patch that are as large as a bound, and what of the patch is left beside them.

use super::chord::Patch;
use super::seek::Seeker;
use crate::geometry::triangle::closest_point;
use crate::geometry::vector::{Vec3, along, distance, sub};

/// A cut keeps off the border of what is blocked by this share of the way to it, so that it is blocked as well.
const WITHIN: f64 = 1.0 - 1e-6;
/// What is left of a patch is looked at by itself where it is no more than this share of it; else the patch is halved.
const LEFT: f64 = 0.75;

impl Seeker<'_> {
    /// Whether one facet is in the way of every ball on the patch as large as the bound.
    ///
    /// Balls of that radius at the corners have centres oᵢ; if all of them reach deeper than the tolerance to points qᵢ of
    /// one (convex) facet, so does the ball at any mean of the corners, because |Σλᵢ(qᵢ − oᵢ)| ≤ Σλᵢ|qᵢ − oᵢ|.
    pub(super) fn blocked(&self, patch: &Patch, stop: u32, bound: f64) -> bool {
        patch.corners.iter().all(|&c| self.lacks(patch, c, (stop, bound)) < 0.0)
    }

    /// What is open of a patch: its halves, or what is left of it once that is cut off where a facet is in the way of every ball as large as the bound.
    ///
    /// Beside the middle of a long facet of a pin or a hole the facets along it are in the way, however the patch is halved across: the
    /// cut leaves the middle. Between a corner that is blocked and one that is not the blocked part ends no sooner than where what balls lack
    /// would be nothing if it grew evenly, for it is convex.
    pub(super) fn open_parts(&self, patch: &Patch, beside: Option<u32>, bound: f64) -> Vec<Patch> {
        let left = beside.filter(|_| patch.spread == 0.0).and_then(|stop| self.left_beside(patch, (stop, bound)));
        left.unwrap_or_else(|| patch.halves().to_vec())
    }

    fn left_beside(&self, patch: &Patch, by: (u32, f64)) -> Option<Vec<Patch>> {
        let lacks = patch.corners.map(|c| self.lacks(patch, c, by));
        let is_alone = |i: &usize| {
            let others = [(i + 1) % 3, (i + 2) % 3];
            others.iter().all(|&o| (lacks[o] < 0.0) != (lacks[*i] < 0.0))
        };
        // The corner that is alone on its side of the cut comes first.
        let first = (0..3).find(is_alone)?;
        let [i, j, k] = [first, (first + 1) % 3, (first + 2) % 3];
        let at = |other: usize| {
            let (blocked, free) = if lacks[i] < 0.0 { (i, other) } else { (other, i) };
            let share = WITHIN * lacks[blocked] / (lacks[blocked] - lacks[free]);
            let from = patch.corners[blocked];
            let cut = along(from, sub(patch.corners[free], from), share);
            (self.lacks(patch, cut, by) < 0.0).then_some(cut)
        };
        let ([a, b, c], p, q) = ([i, j, k].map(|n| patch.corners[n]), at(j)?, at(k)?);
        let of = |corners: [Vec3; 3]| Patch { corners, ..*patch };
        let parts = match lacks[i] < 0.0 {
            false => vec![of([a, p, q])],
            true if distance(p, c) < distance(q, b) => vec![of([p, b, c]), of([p, c, q])],
            true => vec![of([p, b, q]), of([q, b, c])],
        };
        let area: f64 = parts.iter().map(Patch::area).sum();
        (area <= LEFT * patch.area()).then_some(parts)
    }

    /// How much farther than the tolerance allows a facet is from the centre of a ball as large as the bound that touches the patch at a point;
    /// negative where it is in the way.
    fn lacks(&self, patch: &Patch, at: Vec3, (stop, bound): (u32, f64)) -> f64 {
        let r = 0.5 * bound;
        let reach = (r - self.question.tolerance).max(0.0);
        let centre = along(at, patch.axis, -r);
        distance(closest_point(centre, self.mesh.corners(stop)), centre) - reach
    }
}

#[cfg(test)]
mod tests {
    use super::super::cover::{Cover, Question, Sample, Shape};
    use super::super::feature::{Features, Side};
    use crate::geometry::{MeshDistance, revolved};

    /// Slender pins, and holes in a ring, with long facets: all of each is told, and by no more looks than there are places along it.
    #[test]
    fn long_facets_of_pins_and_holes_are_told_by_cuts_along_their_middle() {
        for sides in [16, 64, 128] {
            let pin = [[0.0, 0.0], [0.3, 0.0], [0.3, 10.0], [0.0, 10.0]];
            let ring = [[0.3, 0.0], [2.0, 0.0], [2.0, 10.0], [0.3, 10.0]];
            for (outline, side) in [(&pin, Side::Material), (&ring, Side::Void)] {
                let mesh = revolved(outline, sides);
                let (surface, features) = (MeshDistance::new(&mesh), Features::new(&mesh, side, |_| true));
                let (widest, budget) = (0.8, 1 << 20);
                let question = Question {
                    limits: vec![widest],
                    notice: 1.25 * widest,
                    tolerance: 1e-7,
                    agree: Question::agree_for(widest),
                    finest: Question::finest_for(widest),
                    budget,
                };
                let found = Cover::search(&surface, &features, &question);
                let across = 0.6 * (std::f64::consts::PI / sides as f64).cos();
                let thinnest = found.samples.iter().map(|s| s.diameter).fold(f64::INFINITY, f64::min);
                // Chords of the rim itself are shorter.
                let is_sheet = |s: &&Sample| s.shape == Shape::Sheet;
                let low = found.samples.iter().filter(is_sheet).map(|s| s.low).fold(f64::INFINITY, f64::min);
                assert!((thinnest - across).abs() < 1e-3 * across && low > 0.95 * across, "{sides}: {thinnest} {low}");
                assert!(found.unresolved.iter().all(|u| u.extent <= question.finest), "{sides} {side:?}");
                assert!(found.evaluations < 300 * sides as u64, "{sides} {side:?}: {}", found.evaluations);
            }
        }
    }
}
