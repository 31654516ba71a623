//! The cover: every place where a wall (or a gap) could be thinner than a limit, searched by branch and bound.
//!
//! A medial ball whose contacts are at least 150° apart has diameter 2r ≥ |pq|, the chord between its contacts.
//! So where no chord between opposing features is shorter than the limit, no wall is; where one is, the patch is
//! sampled by a touching ball (a witness), proved to be blocked by something nearer at a flatter angle, or halved.
//! Facets, edges and vertices are finite, so the search needs no grid and sees walls below any voxel.

use super::chord::{Chord, PARALLEL, Patch, WALL_SEPARATION, meets};
use super::feature::{Feature, Features};
use crate::geometry::MeshDistance;
use crate::geometry::distance::TouchingBall;
use crate::geometry::triangle::closest_point;
use crate::geometry::vector::{Vec3, add, distance, dot, norm2, scale, sub};
use rayon::prelude::*;
use std::collections::VecDeque;

/// A ball whose contacts are at least this far apart, but less than a wall's, lies in a wedge (120°).
const WEDGE_SEPARATION: f64 = 120.0 * std::f64::consts::PI / 180.0;

/// Short of a wall's separation by so little that the thickness is the same (140°).
const NEARLY_WALL: f64 = 140.0 * std::f64::consts::PI / 180.0;
/// A ball stopped at less than this was stopped by the side it grew from (12°).
const GENTLE: f64 = 12.0 * std::f64::consts::PI / 180.0;

/// Ball and bound that differ by less than this share of the limit agree; the thinnest place of a group is sought further.
const AGREE: f64 = 0.005;
/// Evaluations of the first look at a feature; most are decided by one or two.
const FIRST_LOOK: u64 = 256;

/// What is searched for, all lengths in millimetres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Question {
    /// Below this a wall fails; 0 for no such limit.
    pub fail: f64,
    /// Below this a wall warns; 0 for no such limit.
    pub warn: f64,
    /// Walls up to this thickness are noticed, so that a passing value can be shown.
    pub notice: f64,
    /// Longest edge of a sampled patch.
    pub resolution: f64,
    /// What a point of the surface may intrude into a ball: the step of the file's coordinates.
    pub tolerance: f64,
    /// Evaluations that the whole search may cost; the first look at each feature is always taken.
    pub budget: u64,
}

impl Question {
    /// 0 below the fail limit, 1 below the warn limit, 2 above both.
    pub fn class(&self, thickness: f64) -> u8 {
        if thickness < self.fail {
            0
        } else if thickness < self.warn {
            1
        } else {
            2
        }
    }
}

impl Question {
    /// Longest edge of the smallest patch: what is thinner than a limit only over less than this is not looked for.
    pub fn finest(&self) -> f64 {
        self.resolution / 16.0
    }
}

/// Whether a sample lies in a sheet or in a wedge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Contacts at least 150° apart.
    Sheet,
    /// Contacts between 120° and 150° apart: an edge in the making.
    Wedge,
}

/// A medial ball found on a patch of surface.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    pub shape: Shape,
    pub centre: Vec3,
    /// Contact on the patch and contact opposite.
    pub contacts: [Vec3; 2],
    /// Diameter of the ball: a thickness that is really there.
    pub diameter: f64,
    /// No ball that touches the patch measures less.
    pub low: f64,
    /// Angle between the contacts seen from the centre, radians.
    pub separation: f64,
    /// Area of the patch, mm².
    pub area: f64,
    pub facet: u32,
    pub opposite: u32,
}

/// A patch that may hide something thinner than a limit, left when the budget or the resolution ended.
#[derive(Debug, Clone, Copy)]
pub struct Unresolved {
    pub at: Vec3,
    pub low: f64,
    /// Longest edge of the patch.
    pub extent: f64,
    pub facet: u32,
}

/// All samples thinner than asked, what stayed open, and what it cost.
#[derive(Debug, Clone, Default)]
pub struct Cover {
    pub samples: Vec<Sample>,
    pub unresolved: Vec<Unresolved>,
    /// Balls grown and chords searched.
    pub evaluations: u64,
    /// For each facet of the mesh, what is known of the sheet on it.
    pub facets: Vec<FacetSheet>,
}

/// What the search knows of one whole facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacetSheet {
    /// Length of its shortest chord; infinite if none is within notice.
    pub low: f64,
    /// Greatest diameter of a sheet sampled on it; 0 without a sample.
    pub high: f64,
    /// Area of its samples, mm².
    pub sampled_area: f64,
}

impl FacetSheet {
    const FREE: FacetSheet = FacetSheet { low: f64::INFINITY, high: 0.0, sampled_area: 0.0 };

    /// The thickness of the whole facet if it hardly varies: samples cover it and agree with the bound within 2 %.
    pub fn constant(&self, area: f64) -> Option<f64> {
        (self.sampled_area >= 0.7 * area && self.high <= 1.02 * self.low).then_some(self.low)
    }
}

impl Cover {
    /// Searches all features of one side of a mesh.
    ///
    /// # Cost
    /// O(log n) for a feature without an opposing one; a thin region costs its area over the resolution squared.
    /// Runs on all cores; the result does not depend on their number.
    pub fn search(mesh: &MeshDistance, features: &Features, question: &Question) -> Cover {
        let seek = |feature: &Feature, budget: u64| {
            let facet = feature.facet;
            let cover = Cover::default();
            let mut seeker = Seeker { mesh, features, question, facet, budget, thinnest: f64::INFINITY, cover };
            seeker.seek(Patch::from(feature));
            seeker.cover
        };
        let mut found: Vec<Cover> = features.list.par_iter().with_min_len(64).map(|f| seek(f, FIRST_LOOK)).collect();
        // What the first look left open shares the rest of the budget; the shares do not depend on the order of work.
        let spent: u64 = found.iter().map(|c| c.evaluations).sum();
        let finest = question.finest();
        let open: Vec<usize> =
            (0..found.len()).filter(|&i| found[i].unresolved.iter().any(|u| u.extent > finest)).collect();
        let share = question.budget.saturating_sub(spent) / (open.len() as u64).max(1);
        if share > FIRST_LOOK {
            let again: Vec<Cover> = open.par_iter().map(|&i| seek(&features.list[i], share)).collect();
            for (i, mut cover) in open.into_iter().zip(again) {
                cover.evaluations += found[i].evaluations;
                found[i] = cover;
            }
        }
        let facets = features.list.iter().map(|f| f.facet as usize + 1).max().unwrap_or(0);
        let mut all = Cover { facets: vec![FacetSheet::FREE; facets], ..Cover::default() };
        for (feature, c) in features.list.iter().zip(found) {
            if let (true, Some(low)) = (feature.is_facet(), c.facets.first().map(|f| f.low)) {
                let own = c.samples.iter().filter(|s| s.shape == Shape::Sheet);
                all.facets[feature.facet as usize] = FacetSheet {
                    low,
                    high: own.clone().map(|s| s.diameter).fold(0.0, f64::max),
                    sampled_area: own.map(|s| s.area).sum(),
                };
            }
            all.samples.extend(c.samples);
            all.unresolved.extend(c.unresolved);
            all.evaluations += c.evaluations;
        }
        all
    }
}

/// The search on one feature.
pub(super) struct Seeker<'a> {
    mesh: &'a MeshDistance,
    features: &'a Features,
    question: &'a Question,
    facet: u32,
    budget: u64,
    /// Least diameter of a sheet found so far.
    thinnest: f64,
    cover: Cover,
}

/// What is known of a patch after one look.
enum Look {
    /// Nothing below the limits is here, or it has been recorded.
    Done,
    /// Too coarse to say; `low` bounds what may be here.
    Open { low: f64 },
}

impl Seeker<'_> {
    fn seek(&mut self, whole: Patch) {
        let finest = self.question.finest();
        let mut queue = VecDeque::from([whole]);
        while let Some(patch) = queue.pop_front() {
            let Some(chord) = self.features.nearest_chord(&patch, self.question.notice) else {
                self.cover.evaluations += 1;
                continue;
            };
            self.cover.evaluations += 2;
            if self.cover.facets.is_empty() {
                self.cover.facets.push(FacetSheet { low: chord.bound, ..FacetSheet::FREE });
            }
            let look =
                if patch.spread > 0.0 { self.look_at_edge(&patch, &chord) } else { self.look_at_facet(&patch, &chord) };
            if let Look::Open { low } = look {
                if low >= 0.999 * self.thinnest {
                    // Something as thin is already known on this very feature.
                    continue;
                }
                if self.cover.evaluations < self.budget && patch.longest_edge().0 > finest {
                    queue.extend(patch.halves());
                } else if self.question.class(low) < 2 {
                    self.cover.unresolved.push(Unresolved {
                        at: patch.centroid(),
                        low,
                        extent: patch.longest_edge().0,
                        facet: self.facet,
                    });
                }
            }
        }
    }

    /// Looks along the shortest chord of a flat patch, then grows a ball at its centroid and compares it with the bound.
    fn look_at_facet(&mut self, patch: &Patch, chord: &Chord) -> Look {
        let q = self.question;
        let edge = patch.longest_edge().0;
        let large = patch.area() > 0.5 * q.resolution * q.resolution || edge > 8.0 * q.resolution;
        if q.class(chord.bound) < 2 && edge > q.resolution && large {
            return Look::Open { low: chord.bound };
        }
        if let Some(exact) = self.along_chord(chord, patch.area()) {
            self.push(exact);
            return Look::Done;
        }
        let inward = scale(patch.axis, -1.0);
        let ball = self.mesh.touching_ball(patch.centroid(), inward, 0.51 * q.notice, q.tolerance);
        let low = self.bound(patch, &ball, chord);
        if ball.stop.is_some() && ball.separation() >= WALL_SEPARATION && 2.0 * ball.radius <= q.notice {
            let apart = q.class(low) != q.class(2.0 * ball.radius) && 2.0 * ball.radius - low > AGREE * q.warn;
            if apart && edge > q.finest() {
                return Look::Open { low };
            }
            // At the finest patch what the ball measures is what is there.
            let low = if apart { 2.0 * ball.radius } else { low };
            let wedge = ball.stop.is_some_and(|s| meets(&patch.whole, &self.mesh.corners(s.facet)));
            let shape = if wedge && ball.separation() < PARALLEL { Shape::Wedge } else { Shape::Sheet };
            self.record(&ball, shape, low, patch.area());
            return Look::Done;
        }
        if let Some(settled) = self.settled(&ball, chord) {
            self.record(&settled, Shape::Sheet, chord.bound, patch.area());
            return Look::Done;
        }
        if self.blocked_below(patch, &ball) >= chord.bound && q.class(low) < 2 {
            return Look::Open { low };
        }
        if ball.stop.is_some() && ball.separation() >= WEDGE_SEPARATION && q.class(2.0 * ball.radius) < 2 {
            self.record(&ball, Shape::Wedge, low, patch.area());
        }
        Look::Done
    }

    /// A ball that measures the sheet at a patch although the one at its centroid is stopped at a flatter angle.
    ///
    /// Where the surface bends gently towards the ball, a neighbouring facet stops it: it is grown again from there. A ball
    /// that is almost a wall's and at most 5 % larger than the bound lies on the border between wall and wedge: the sheet
    /// is as thick as that either way.
    fn settled(&self, ball: &TouchingBall, chord: &Chord) -> Option<TouchingBall> {
        let q = self.question;
        let mut ball = *ball;
        for _ in 0..4 {
            let stop = ball.stop?;
            if ball.separation() >= NEARLY_WALL {
                let thick = 2.0 * ball.radius;
                return (thick <= 1.05 * chord.bound
                    && (q.class(thick) == q.class(chord.bound) || thick - chord.bound <= AGREE * q.warn))
                    .then_some(ball);
            }
            if ball.separation() > GENTLE {
                return None;
            }
            let inward = scale(self.mesh.normal(stop.facet), -self.features.side.sign());
            ball = self.mesh.touching_ball(stop.point, inward, 0.51 * q.notice, q.tolerance);
        }
        None
    }

    /// No wall ball on the patch is thinner: the chord bound, or the Lipschitz bound from the ball at the centroid.
    ///
    /// If a ball of radius r' touches the patch at p' with its other contact q at most 20° off the normal, then the ball
    /// through p and q has radius at most r' + δ·tan 20° + δ²/|p'q|, δ = |pp'|; so r' is at least the empty ball's
    /// radius at p less that.
    fn bound(&self, patch: &Patch, ball: &TouchingBall, chord: &Chord) -> f64 {
        let p = patch.centroid();
        let reach = patch.corners.iter().map(|&c| distance(c, p)).fold(0.0, f64::max);
        let slack = 0.364 * reach + reach * reach / chord.length.max(1e-9);
        chord.bound.max(2.0 * (ball.radius - slack))
    }

    /// Twice the largest radius any empty ball on the patch can have, because the facet that stopped `ball` is in its way.
    ///
    /// For corners cᵢ take points qᵢ of that (convex) facet; a point of the patch is a mean of the cᵢ, the same mean q of
    /// the qᵢ lies on the facet, and the ball that touches at p and reaches q has 2r = |q − p|²/depth ≤
    /// max |qᵢ − cᵢ|² / min depthᵢ.
    fn blocked_below(&self, patch: &Patch, ball: &TouchingBall) -> f64 {
        let Some(stop) = ball.stop else { return f64::INFINITY };
        let offset = sub(stop.point, patch.centroid());
        let facet = self.mesh.corners(stop.facet);
        let chords = patch.corners.map(|c| sub(closest_point(add(c, offset), facet), c));
        let depth = chords.iter().map(|d| -dot(*d, patch.axis)).fold(f64::INFINITY, f64::min);
        let longest = chords.iter().map(|d| norm2(*d)).fold(0.0, f64::max);
        if depth > 0.0 { longest / depth } else { f64::INFINITY }
    }

    /// Looks along the shortest chord of an edge or a vertex.
    fn look_at_edge(&mut self, patch: &Patch, chord: &Chord) -> Look {
        let q = self.question;
        if let Some(sample) = self.along_chord(chord, 0.0) {
            if q.class(sample.diameter) < 2 && patch.longest_edge().0 > q.resolution {
                return Look::Open { low: chord.bound };
            }
            self.push(sample);
            return Look::Done;
        }
        // A ball from the edge along the chord that is stopped sooner, at a flatter angle, is no wall.
        let d = sub(chord.to, chord.from);
        if chord.length > 0.0 {
            let ball = self.mesh.touching_ball(chord.from, scale(d, 1.0 / chord.length), 0.51 * q.notice, q.tolerance);
            if 2.0 * ball.radius < 0.98 * chord.length && patch.longest_edge().0 <= q.resolution {
                return Look::Done;
            }
        }
        Look::Open { low: chord.bound }
    }

    /// The ball on the chord as diameter, if it is empty: then the bound is attained.
    fn along_chord(&mut self, chord: &Chord, area: f64) -> Option<Sample> {
        let r = 0.5 * chord.length;
        if r <= 0.0 {
            return None;
        }
        let centre = [0, 1, 2].map(|a| 0.5 * (chord.from[a] + chord.to[a]));
        self.cover.evaluations += 1;
        if self.mesh.nearest(centre, r - self.question.tolerance.max(1e-4 * r)).is_some() {
            return None;
        }
        Some(Sample {
            shape: Shape::Sheet,
            centre,
            contacts: [chord.from, chord.to],
            diameter: chord.length,
            low: chord.bound,
            separation: std::f64::consts::PI,
            area,
            facet: self.facet,
            opposite: self.features.list[chord.feature as usize].facet,
        })
    }

    fn record(&mut self, ball: &TouchingBall, shape: Shape, low: f64, area: f64) {
        let Some(stop) = ball.stop else { return };
        self.push(Sample {
            shape,
            centre: ball.centre,
            contacts: [ball.from, stop.point],
            diameter: 2.0 * ball.radius,
            low: low.min(2.0 * ball.radius),
            separation: ball.separation(),
            area,
            facet: self.facet,
            opposite: stop.facet,
        });
    }

    fn push(&mut self, sample: Sample) {
        if sample.shape == Shape::Sheet {
            self.thinnest = self.thinnest.min(sample.diameter);
        }
        self.cover.samples.push(sample);
    }
}
