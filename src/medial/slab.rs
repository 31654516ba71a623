//! Slabs: what lies between two parallel planes, with nothing else there.

use super::chord::{Chord, Patch};
use super::seek::Seeker;
use crate::geometry::Prism;
use crate::geometry::vector::{Vec3, along, cross, dot, scale, sub, unit};

/// Patches of a slab are no longer than this share of their facet, so that samples show how far it goes.
const SHARE: f64 = 1.0 / 16.0;

impl Seeker<'_> {
    /// Whether a patch is a side of a slab as thick as its nearest chord, however large it is.
    ///
    /// Its facet and the one that the chord leads to lie in parallel planes, d apart, and no facet but those of the second plane has a point
    /// that is deeper than the first one, not deeper than the second one, and within d/2 of the patch seen from above. Then nothing but
    /// the second plane stops a ball that touches the patch; and as no facet leads away from the second plane, it goes on below
    /// all of the patch if it does so anywhere.
    ///
    /// # Cost
    /// As [`Prism::is_met`].
    pub(super) fn is_slab(&self, patch: &Patch, chord: &Chord) -> bool {
        let q = self.question;
        let (edge, from) = patch.longest_edge();
        let Some(opposite) = self.features.list.get(chord.feature as usize).filter(|f| f.is_facet()) else {
            return false;
        };
        if edge > SHARE * self.extent {
            return false;
        }
        let inward = scale(patch.axis, -1.0);
        let thick = chord.bound;
        // Ball and bound that differ by less are one, and so is what the coordinates of the file do not tell apart.
        let slack = q.agree.max(2.0 * q.tolerance);
        let plane = self.mesh.corners(opposite.facet)[0];
        let depth = |p: Vec3| dot(sub(p, patch.corners[0]), inward);
        let in_plane = |p: Vec3| (depth(p) - thick).abs() <= slack;
        if thick <= 2.0 * slack || !in_plane(plane) {
            return false;
        }
        let base = around(patch, from, 0.5 * thick).map(|p| along(p, inward, slack));
        let prism = Prism { base: base.into(), along: scale(inward, thick) };
        !prism.is_met(self.mesh, |f| !self.mesh.corners(f).into_iter().all(in_plane))
    }
}

/// The rectangle along an edge of a patch that holds all that is so near to it in its plane.
fn around(patch: &Patch, edge: usize, near: f64) -> [Vec3; 4] {
    let [a, b] = [patch.corners[edge], patch.corners[(edge + 1) % 3]];
    let u = unit(sub(b, a));
    let v = cross(patch.axis, u);
    let span = |axis: Vec3| {
        let ends = patch.corners.map(|c| dot(sub(c, a), axis));
        [
            ends.into_iter().fold(f64::INFINITY, f64::min) - near,
            ends.into_iter().fold(f64::NEG_INFINITY, f64::max) + near,
        ]
    };
    let ([u0, u1], [v0, v1]) = (span(u), span(v));
    [[u0, v0], [u1, v0], [u1, v1], [u0, v1]].map(|[s, t]| along(along(a, u, s), v, t))
}

#[cfg(test)]
mod tests {
    use super::super::cover::{Cover, Question};
    use super::super::feature::{Features, Side};
    use crate::geometry::{MeshDistance, TriangleMesh, cuboid, extruded};

    /// What is found in a mesh for limits of 0.8 and 1.2 mm.
    fn searched(mesh: &TriangleMesh) -> Cover {
        let limits = vec![0.8, 1.2];
        let question = Question {
            notice: 1.8,
            tolerance: 1e-9,
            agree: Question::agree_for(1.2),
            finest: Question::finest_for(1.2),
            budget: 1 << 22,
            limits,
        };
        let features = Features::new(mesh, Side::Material, |_| true);
        Cover::search(&MeshDistance::new(mesh), &features, &question)
    }

    #[test]
    fn a_large_plate_takes_few_samples_and_its_area_is_told_all_the_same() {
        let cover = searched(&cuboid([0.0; 3], [1000.0, 800.0, 1.0]));
        let sides: Vec<_> = cover.samples.iter().filter(|s| s.area > 0.0).collect();
        let area: f64 = sides.iter().map(|s| s.thin).sum();
        assert!((area - 1.6e6).abs() < 1e-2 * 1.6e6, "{area}");
        assert!(sides.iter().all(|s| (s.diameter - 1.0).abs() < 1e-9 && (s.low - 1.0).abs() < 1e-9));
        // Where patches are no longer than 7.2 mm there are some 350,000.
        assert!(sides.len() < 60_000 && cover.unresolved.is_empty(), "{}", sides.len());
    }

    #[test]
    fn what_stands_below_a_large_plate_is_not_taken_for_its_other_side() {
        // A block below carries a tenth of the plate, away from where the balls of a patch are grown.
        let outline = [
            [0.0, 1.0],
            [400.0, 1.0],
            [400.0, 0.0],
            [100.0, 0.0],
            [100.0, -30.0],
            [60.0, -30.0],
            [60.0, 0.0],
            [0.0, 0.0],
        ];
        let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 6], [0, 6, 7], [3, 4, 5], [3, 5, 6]];
        let of = |mesh: &TriangleMesh| searched(mesh).samples.iter().map(|s| s.thin).sum::<f64>();
        let (alone, carried) = (of(&cuboid([0.0; 3], [400.0, 400.0, 1.0])), of(&extruded(&outline, &caps, 400.0)));
        let truth = 2.0 * 400.0 * 360.0;
        assert!((alone - 2.0 * 400.0 * 400.0).abs() < 0.01 * alone, "{alone}");
        assert!((carried - truth).abs() < 0.02 * truth, "{carried} of {truth}");
    }
}
