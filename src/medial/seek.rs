//! The search on one feature: patches are sampled by touching balls, proved to be blocked, cut or halved.

use super::area::Share;
use super::chord::{Chord, NEARLY_WALL, PARALLEL, Patch, WALL_SEPARATION, meets};
use super::cover::{Cover, FIRST_LOOK, FacetSheet, Own, Question, Sample, Shape, Unresolved};
use super::feature::Features;
use crate::geometry::MeshDistance;
use crate::geometry::distance::{Nearest, TouchingBall};
use crate::geometry::triangle::closest_point;
use crate::geometry::vector::{Vec3, along, angle, distance, dot, norm2, scale, sub};
use rayon::prelude::*;
use std::collections::VecDeque;

/// A ball whose contacts are at least this far apart, but less than a wall's, lies in a wedge (120°).
const WEDGE_SEPARATION: f64 = 120.0 * std::f64::consts::PI / 180.0;

/// A ball stopped at less than this was stopped by the side it grew from (12°).
const GENTLE: f64 = 12.0 * std::f64::consts::PI / 180.0;

/// A patch that may be thinner than what is known on its feature by no more than this share is passed over.
const SAME: f64 = 0.95;
/// A patch that may be thinner by no more than this share, and twice what the question takes for one, is not thinner.
const ALIKE: f64 = 1e-3;
/// A ball that is almost a wall's measures the sheet if it differs from the bound by no more than this share.
const BORDERS: f64 = 0.05;
/// Patches up to this many resolutions, and larger ones of a slab, are taken whole where the sheet is even.
const EVEN: f64 = 8.0;
/// A ball stopped at up to this was stopped by a side beside its own, as in a hole of seven sides or more, and not by the rim of a wall (52°).
const BENDS: f64 = 52.0 * std::f64::consts::PI / 180.0;
/// Sides that a ball is moved away from before it is given up.
const BALANCED: usize = 4;
/// Squared sine between a facet and one that a ball cannot be moved away from along it (0.06°).
const SINE2: f64 = 1e-6;
/// Patches whose chords are sought at once, in a search that may cost more than a first look.
const WAVE: usize = 64;

/// The search on one feature.
pub(super) struct Seeker<'a> {
    pub(super) mesh: &'a MeshDistance,
    pub(super) features: &'a Features,
    pub(super) question: &'a Question,
    pub(super) feature: u32,
    pub(super) facet: u32,
    budget: u64,
    /// Longest edge of the feature.
    pub(super) extent: f64,
    /// Which sheets within a body are sought; `None` for all.
    own: Option<Own<'a>>,
    /// Least diameter of such a sheet found so far; how far bodies are apart is known from their pairs.
    thinnest: f64,
    pub(super) cover: Cover,
}

/// What is known of a patch after one look.
pub(super) enum Look {
    /// Nothing below the limits is here, or it has been recorded.
    Done,
    /// Too coarse to be sampled; `low` bounds what may be here.
    Coarse { low: f64 },
    /// Nothing is decided yet; `low` bounds what may be here, and a facet `beside` may be in the way of some of it.
    Open { low: f64, beside: Option<u32> },
}

impl<'a> Seeker<'a> {
    /// A search that may cost so many evaluations.
    pub(super) fn new(mesh: &'a MeshDistance, features: &'a Features, question: &'a Question, budget: u64) -> Self {
        let (thinnest, cover) = (f64::INFINITY, Cover::default());
        Seeker { mesh, features, question, feature: 0, facet: 0, budget, extent: 0.0, own: None, thinnest, cover }
    }

    /// The same search for one's own.
    pub(super) fn for_own(self, own: Own<'a>) -> Self {
        Seeker { own: Some(own), ..self }
    }

    fn counts(&self, sample: &Sample) -> bool {
        sample.is_within_a_body(self.features) && self.own.is_none_or(|own| (own.counts)(sample))
    }

    /// Looks at a feature, halving what is open, and returns what was found.
    ///
    /// The feature is an index into the list of all; one that is not there has nothing on it. `opposite` is a feature that chords may
    /// lead to, and becomes the last that one led to: it saves work on the next feature, and changes nothing else.
    pub(super) fn seek(mut self, feature: u32, opposite: &mut Option<u32>) -> Cover {
        let Some(of) = self.features.list.get(feature as usize) else { return self.cover };
        let whole = Patch::from(of);
        (self.feature, self.facet, self.extent) = (feature, of.facet, whole.longest_edge().0);
        let mut queue = VecDeque::from([whole]);
        // Chords depend on nothing that is found: in a search that may cost much they are sought for many patches at once.
        let wave = if self.budget > FIRST_LOOK { WAVE } else { 1 };
        while !queue.is_empty() {
            let patches: Vec<Patch> = queue.drain(..wave.min(queue.len())).collect();
            for (patch, chord) in patches.iter().zip(self.chords(&patches, opposite)) {
                match chord {
                    Some(chord) => self.look(patch, &chord, &mut queue),
                    None => self.cover.evaluations += 1,
                }
            }
        }
        // Whether a sample counts may take long: it is asked of the thinnest first, until one does.
        let mut by_diameter: Vec<(f64, usize)> =
            self.cover.samples.iter().enumerate().map(|(at, s)| (s.diameter, at)).collect();
        by_diameter.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let counts = |&(_, at): &(f64, usize)| self.cover.samples.get(at).is_some_and(|s| self.counts(s));
        let thinnest = by_diameter.into_iter().find(counts);
        if let Some(thinnest) = thinnest.and_then(|(_, at)| self.cover.samples.get_mut(at)) {
            // Its bound takes in what was passed over because of it.
            thinnest.low = self.cover.passed.iter().map(|p| p.low).fold(thinnest.low, f64::min);
        }
        self.cover
    }

    /// The nearest chord of each patch.
    fn chords(&self, patches: &[Patch], opposite: &mut Option<u32>) -> Vec<Option<Chord>> {
        let (features, notice) = (self.features, self.question.notice);
        let nearest = |near: &mut Option<u32>, patch: &Patch| features.nearest_chord(patch, notice, near);
        if let [patch] = patches {
            return vec![nearest(opposite, patch)];
        }
        patches.par_iter().with_min_len(4).map_init(|| *opposite, nearest).collect()
    }

    /// Looks at one patch along its nearest chord; passes over, halves or leaves open what that does not decide.
    fn look(&mut self, patch: &Patch, chord: &Chord, queue: &mut VecDeque<Patch>) {
        self.cover.evaluations += 2;
        if self.cover.facets.is_empty() {
            self.cover.facets.push(FacetSheet { low: chord.bound, ..FacetSheet::FREE });
        }
        let look = if patch.spread > 0.0 { self.look_at_edge(patch, chord) } else { self.look_at_facet(patch, chord) };
        let (low, beside) = match look {
            Look::Done => return,
            Look::Coarse { low } => (low, None),
            Look::Open { low, beside } => (low, beside),
        };
        let bound = low;
        let low = self.own.map_or(low, |own| (own.from)(chord.middle(), patch.longest_edge().0, low));
        if self.own.is_some() && !self.question.is_thin(low) {
            return;
        }
        // Coarse patches are sampled for their area as long as that is cheap.
        let pressed = self.budget > FIRST_LOOK && 4 * self.cover.evaluations > self.budget;
        if (pressed || matches!(look, Look::Open { .. })) && self.is_known(low) {
            self.pass_over(patch, chord, low);
        } else if self.cover.evaluations < self.budget && patch.longest_edge().0 > self.question.finest {
            queue.extend(self.open_parts(patch, beside, bound));
        } else if self.question.is_thin(low) {
            let (at, extent) = (patch.centroid(), patch.longest_edge().0);
            self.cover.unresolved.push(Unresolved { at, low, extent, facet: self.facet });
        }
    }

    /// Whether something as thin is already known on this very feature, which a small facet is all of.
    fn is_known(&self, low: f64) -> bool {
        let class = |thickness| self.question.class(thickness);
        let small = self.extent <= 2.5 * self.question.resolution(low);
        let alike = (ALIKE * self.thinnest).min(2.0 * self.question.agree);
        low >= self.thinnest - alike || (small && low >= SAME * self.thinnest && class(low) == class(self.thinnest))
    }

    /// Looks along the shortest chord of a flat patch, then grows a ball at its centroid and compares it with the bound.
    fn look_at_facet(&mut self, patch: &Patch, chord: &Chord) -> Look {
        let q = self.question;
        let edge = patch.longest_edge().0;
        let resolution = q.resolution(chord.bound);
        let large = patch.area() > 0.5 * resolution * resolution || edge > 8.0 * resolution;
        if q.is_thin(chord.bound) && edge > resolution && large {
            let is_small = edge <= EVEN * resolution;
            let is_even = (is_small || self.is_slab(patch, chord)) && self.even(patch, chord);
            let done = is_even || is_small && self.between(patch, chord);
            return if done { Look::Done } else { Look::Coarse { low: chord.bound } };
        }
        if let Some(exact) = self.along_chord(patch, chord) {
            self.push(Sample { thin: self.share_of(patch, exact.diameter).thin * exact.area, ..exact });
            return Look::Done;
        }
        let inward = scale(patch.axis, -1.0);
        let ball = self.mesh.touching_ball(patch.centroid(), inward, 0.51 * q.notice, q.tolerance);
        let low = self.bound(patch, &ball, chord);
        if ball.stop.is_some() && ball.separation() >= WALL_SEPARATION && 2.0 * ball.radius <= q.notice {
            let apart = q.class(low) != q.class(2.0 * ball.radius) && 2.0 * ball.radius - low > q.agree;
            let finest = edge <= q.finest || self.faces_others(patch, chord);
            if apart && !finest && !self.is_known(low) {
                return Look::Open { low, beside: None };
            }
            // At the finest patch what the ball measures is what is there.
            let low = if apart && finest { 2.0 * ball.radius } else { low };
            let wedge = ball.stop.is_some_and(|s| meets(&patch.whole, &self.mesh.corners(s.facet)));
            let shape = if wedge && ball.separation() < PARALLEL { Shape::Wedge } else { Shape::Sheet };
            self.record(&ball, shape, low, (patch, self.share_of(patch, 2.0 * ball.radius)));
            return Look::Done;
        }
        if let Some(wall) = self.balanced(patch, &ball).or_else(|| self.settled(&ball, chord)) {
            self.record(&wall, Shape::Sheet, chord.bound, (patch, self.share_of(patch, 2.0 * wall.radius)));
            return Look::Done;
        }
        let blocked = ball.stop.is_some_and(|stop| self.blocked(patch, stop.facet, low));
        if q.is_thin(low) && !blocked && !self.faces_others(patch, chord) {
            let beside = ball.stop.filter(|_| ball.separation() <= BENDS);
            return Look::Open { low, beside: beside.map(|s| s.facet) };
        }
        if ball.stop.is_some() && ball.separation() >= WEDGE_SEPARATION && q.is_thin(2.0 * ball.radius) {
            self.record(&ball, Shape::Wedge, low, (patch, Share::WHOLE));
        }
        Look::Done
    }

    /// Records a patch larger than the resolution as four samples if the balls at its middle and near its corners agree with
    /// the bound: the sheet is as thick as that all over.
    fn even(&mut self, patch: &Patch, chord: &Chord) -> bool {
        let q = self.question;
        let inward = scale(patch.axis, -1.0);
        let centroid = patch.centroid();
        let near = |c: Vec3| along(centroid, sub(c, centroid), 0.6);
        let [a, b, c] = patch.corners.map(near);
        let mut balls = [None; 4];
        for (at, ball) in [centroid, a, b, c].into_iter().zip(&mut balls) {
            let grown = self.mesh.touching_ball(at, inward, 0.51 * q.notice, q.tolerance);
            self.cover.evaluations += 1;
            let thick = 2.0 * grown.radius;
            let agrees = thick - chord.bound <= q.agree && q.class(thick) == q.class(chord.bound);
            if !(agrees && grown.stop.is_some() && grown.separation() >= PARALLEL) {
                return false;
            }
            *ball = Some(grown);
        }
        for ball in balls.into_iter().flatten() {
            self.record(&ball, Shape::Sheet, chord.bound, (patch, Share::QUARTER));
        }
        true
    }

    /// Records a patch larger than the resolution that other bodies alone can be opposite, as one sample.
    ///
    /// How far bodies are apart is known from their pairs; samples only show where they are near.
    fn between(&mut self, patch: &Patch, chord: &Chord) -> bool {
        if !self.faces_others(patch, chord) {
            return false;
        }
        let q = self.question;
        let ball = self.mesh.touching_ball(patch.centroid(), scale(patch.axis, -1.0), 0.51 * q.notice, q.tolerance);
        self.cover.evaluations += 1;
        if ball.stop.is_some() && ball.separation() >= WALL_SEPARATION {
            self.record(&ball, Shape::Sheet, chord.bound, (patch, Share::WHOLE));
        }
        true
    }

    /// Whether the nearest chord leads to another body and none to the patch's own.
    pub(super) fn faces_others(&mut self, patch: &Patch, chord: &Chord) -> bool {
        let own = self.features.body(self.facet);
        if self.features.body(self.features.list[chord.feature as usize].facet) == own {
            return false;
        }
        self.cover.evaluations += 1;
        let within = self.question.widest();
        self.features.nearest_chord_where(patch, within, |f| self.features.body(f.facet) == own).is_none()
    }

    /// A ball that measures the sheet at a patch although the one at its centroid is stopped at a flatter angle.
    ///
    /// Where the surface bends gently towards the ball, a neighbouring facet stops it: it is grown again from there. A ball
    /// that is almost a wall's and within 5 % of the bound lies on the border between wall and wedge: the sheet is as thick as
    /// that either way. A smaller one lies in a blunt edge of the sheet, a larger one beside it.
    fn settled(&self, ball: &TouchingBall, chord: &Chord) -> Option<TouchingBall> {
        let q = self.question;
        let mut ball = *ball;
        for _ in 0..4 {
            let stop = ball.stop?;
            if ball.separation() >= NEARLY_WALL {
                let thick = 2.0 * ball.radius;
                return ((thick / chord.bound - 1.0).abs() <= BORDERS
                    && (q.class(thick) == q.class(chord.bound) || thick - chord.bound <= q.agree))
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

    /// A ball between the patch's facet and one as good as parallel to it, where the surface bends towards the ball.
    ///
    /// Across a hole with an even number of sides the sides beside a facet stop every ball but the one at its middle, which no
    /// halving meets. Only facets as long as the ball is wide are asked: shorter ones bend both ways, or are soon halved. A ball
    /// that reaches into such a side by δ clears it if it is moved along the facet by δ / sin ψ, ψ between their normals.
    fn balanced(&mut self, patch: &Patch, ball: &TouchingBall) -> Option<TouchingBall> {
        let q = self.question;
        let mut stop = ball.stop.filter(|_| ball.separation() <= BENDS).map(|s| (s.facet, s.point))?;
        let (length, opposite) =
            self.mesh.first_hit(patch.centroid(), scale(patch.axis, -1.0), q.tolerance, q.notice)?;
        let inwards = |facet: u32| scale(self.mesh.normal(facet), -self.features.side.sign());
        let is_news = q.is_thin(length) && length < self.thinnest - q.agree && length <= self.extent;
        if !is_news || angle(inwards(opposite), scale(patch.axis, -1.0)) < PARALLEL {
            return None;
        }
        let r = 0.5 * length;
        let clear = r - q.tolerance.max(1e-4 * r);
        let mut centre = along(patch.centroid(), patch.axis, -r);
        for _ in 0..BALANCED {
            let inward = inwards(stop.0);
            let aside = sub(inward, scale(patch.axis, dot(inward, patch.axis)));
            let sine2 = norm2(aside);
            let into = r - dot(sub(centre, stop.1), inward);
            if sine2 < SINE2 || into <= 0.0 {
                return None;
            }
            centre = along(centre, aside, into / sine2);
            self.cover.evaluations += 1;
            match self.mesh.nearest(centre, clear) {
                Some(near) => stop = (near.facet, near.point),
                None => return self.across(patch, (centre, r), opposite),
            }
        }
        None
    }

    /// An empty ball, if it touches the patch's facet and another that is as good as parallel.
    fn across(&self, patch: &Patch, (centre, radius): (Vec3, f64), facet: u32) -> Option<TouchingBall> {
        let [from, point] = [patch.whole, self.mesh.corners(facet)].map(|corners| closest_point(centre, corners));
        let ball = TouchingBall { from, centre, radius, stop: Some(Nearest { point, facet, distance: radius }) };
        let touches = |p: Vec3| distance(p, centre) <= radius + 0.5 * self.question.agree;
        (touches(from) && touches(point) && ball.separation() >= PARALLEL).then_some(ball)
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

    /// The ball on the chord as diameter, if it is empty: then the bound is attained.
    pub(super) fn along_chord(&mut self, patch: &Patch, chord: &Chord) -> Option<Sample> {
        let r = 0.5 * chord.length;
        if r <= 0.0 {
            return None;
        }
        let centre = chord.middle();
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
            area: patch.area(),
            thin: patch.area(),
            edge: patch.longest_edge().0,
            sides: patch.sides(),
            feature: self.feature,
            facet: self.facet,
            opposite: self.features.list[chord.feature as usize].facet,
        })
    }

    /// Records a ball that stands for such a share of a patch.
    pub(super) fn record(&mut self, ball: &TouchingBall, shape: Shape, low: f64, (patch, share): (&Patch, Share)) {
        let Some(stop) = ball.stop else { return };
        self.push(Sample {
            shape,
            centre: ball.centre,
            contacts: [ball.from, stop.point],
            diameter: 2.0 * ball.radius,
            low: low.min(2.0 * ball.radius),
            separation: ball.separation(),
            area: share.of_patch * patch.area(),
            thin: share.thin * patch.area(),
            edge: patch.longest_edge().0,
            sides: patch.sides(),
            feature: self.feature,
            facet: self.facet,
            opposite: stop.facet,
        });
    }

    pub(super) fn push(&mut self, sample: Sample) {
        if sample.diameter < self.thinnest && self.counts(&sample) {
            self.thinnest = sample.diameter;
        }
        self.cover.samples.push(sample);
    }
}
