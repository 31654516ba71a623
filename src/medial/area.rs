//! How much of the surface a sample stands for.

use super::chord::{Chord, Patch, WALL_SEPARATION};
use super::cover::{Cover, Passed, Question, Sample, Shape};
use super::feature::Features;
use super::seek::Seeker;
use crate::geometry::MeshDistance;
use crate::geometry::vector::{Vec3, angle, cross, distance, dot, norm, scale, sub, unit};
use rustc_hash::FxHashMap;

/// A patch is looked through at the middles of so many rows of equal parts.
const PARTS: u32 = 4;
/// A ball stands for one of them at least.
const LEAST_SHARE: f64 = 1.0 / (PARTS * PARTS) as f64;

/// What of a patch a ball stands for.
#[derive(Clone, Copy)]
pub(super) struct Share {
    pub of_patch: f64,
    /// What of it lies on a sheet.
    pub thin: f64,
}

impl Share {
    pub const WHOLE: Share = Share { of_patch: 1.0, thin: 1.0 };
    pub const QUARTER: Share = Share { of_patch: 0.25, thin: 0.25 };
}

impl Seeker<'_> {
    /// How much of a patch a ball of a wall found on it stands for.
    pub(super) fn share_of(&self, patch: &Patch, thickness: f64) -> Share {
        Share { of_patch: 1.0, thin: self.thin_share(patch, thickness).max(LEAST_SHARE) }
    }

    /// How much of a flat patch lies on a sheet that the same limits tell as one of a thickness: the share of lines straight across, from the
    /// middles of equal parts of it, that end within the next limit on a side that faces it.
    fn thin_share(&self, patch: &Patch, thickness: f64) -> f64 {
        let q = self.question;
        if patch.spread > 0.0 {
            return 0.0;
        }
        let within = q.limits.get(q.class(thickness)).copied().unwrap_or(q.notice);
        let (normal, inward) = (self.mesh.normal(self.facet), scale(patch.axis, -1.0));
        let is_thin = |from: &Vec3| {
            let hit = self.mesh.first_hit(*from, inward, q.tolerance, within);
            hit.is_some_and(|(_, facet)| angle(self.mesh.normal(facet), normal) >= WALL_SEPARATION)
        };
        patch.middles(PARTS).filter(is_thin).count() as f64 * LEAST_SHARE
    }

    /// Leaves a patch unsampled.
    pub(super) fn pass_over(&mut self, patch: &Patch, chord: &Chord, low: f64) {
        let area = self.thin_share(patch, low) * patch.area();
        let (sides, chord) = (patch.sides(), [chord.from, chord.to]);
        self.cover.passed.push(Passed { sides, chord, low, area, feature: self.feature });
    }
}

impl Cover {
    /// Adds the area of what was passed over on a feature to the thinnest of its samples, from one on, that the same limits tell as thin.
    ///
    /// What is thicker than all of them by the limits is no part of their sheets.
    pub(super) fn stands_for(&mut self, first: usize, passed: &[Passed], (question, features): (&Question, &Features)) {
        let mut areas: FxHashMap<usize, f64> = FxHashMap::default();
        for p in passed {
            *areas.entry(question.class(p.low)).or_default() += p.area;
        }
        for (class, area) in areas {
            let own = self.samples.iter_mut().skip(first);
            let alike = own.filter(|s| s.is_within_a_body(features) && question.class(s.diameter) == class);
            if let Some(thinnest) = alike.min_by(|a, b| a.diameter.total_cmp(&b.diameter)) {
                thinnest.thin += area;
            }
        }
    }

    /// Gives the samples of edges their area: strips along both sides, no wider than the ball's radius and as seen straight across the wall, of
    /// what the samples of the facets left.
    ///
    /// Where a wall's sides bend towards its balls everywhere, as those of a twisted blade do, the balls touch edges alone.
    pub(super) fn leave_to_edges(&mut self, mesh: &MeshDistance, features: &Features) {
        let area_of = |facet: u32| {
            let [a, b, c] = mesh.corners(facet);
            0.5 * norm(cross(sub(b, a), sub(c, a)))
        };
        let strips = |s: &Sample| {
            let edge = features.list.get(s.feature as usize).filter(|f| s.shape != Shape::Wedge && f.is_edge());
            edge.map(|edge| {
                let [a, b, _] = edge.corners;
                let way = scale(unit(sub(s.contacts[0], s.contacts[1])), features.side.sign());
                [edge.facet, edge.beside].map(|facet| {
                    let wide = (0.5 * s.diameter).min(area_of(facet) / distance(a, b));
                    (facet, s.edge * wide * dot(way, mesh.normal(facet)).max(0.0))
                })
            })
        };
        let mut asked: FxHashMap<u32, f64> = FxHashMap::default();
        for (facet, strip) in self.samples.iter().filter_map(strips).flatten() {
            *asked.entry(facet).or_default() += strip;
        }
        let left = |facet: u32| {
            let sampled = self.facets.get(facet as usize).map_or(0.0, |f| f.sampled_area);
            (area_of(facet) - sampled).max(0.0)
        };
        let share: FxHashMap<u32, f64> = asked
            .into_iter()
            .map(|(facet, asked)| (facet, (left(facet) / asked.max(f64::MIN_POSITIVE)).min(1.0)))
            .collect();
        for s in &mut self.samples {
            let of = |(facet, strip): (u32, f64)| strip * share.get(&facet).copied().unwrap_or(0.0);
            s.thin += strips(s).map_or(0.0, |[one, other]| of(one) + of(other));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::feature::Side;
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn what_is_passed_over_counts_for_the_thinnest_sheet_that_the_same_limits_tell() {
        let features = Features::new(&cuboid([0.0; 3], [1.0; 3]), Side::Material, |_| true);
        let limits = vec![0.8, 1.2];
        let question = Question { limits, notice: 1.8, tolerance: 0.0, agree: 0.01, finest: 0.1, budget: 1 };
        let sample = |diameter: f64| Sample {
            shape: Shape::Sheet,
            centre: [0.0; 3],
            contacts: [[0.0; 3]; 2],
            diameter,
            low: diameter,
            separation: std::f64::consts::PI,
            area: 1.0,
            thin: 1.0,
            edge: 1.0,
            sides: ([0.0; 3], [0.0; 3]),
            feature: 0,
            facet: 0,
            opposite: 1,
        };
        let passed =
            |low: f64, area: f64| Passed { sides: ([0.0; 3], [0.0; 3]), chord: [[0.0; 3]; 2], low, area, feature: 0 };
        let mut cover = Cover { samples: [0.5, 1.0, 0.9].map(sample).into(), ..Cover::default() };
        let over = [passed(0.95, 7.0), passed(0.6, 2.0), passed(0.55, 1.0), passed(1.3, 5.0)];
        cover.stands_for(0, &over, (&question, &features));
        assert_eq!(cover.samples.iter().map(|s| s.thin).collect::<Vec<_>>(), [4.0, 1.0, 8.0]);
    }
}
