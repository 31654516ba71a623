//! A look at an edge or a vertex: the ball on its nearest chord, or the one that grows straight across it.

use super::area::Share;
use super::chord::{Chord, Patch, WALL_SEPARATION, meets, runs_along};
use super::cover::Shape;
use super::feature::Feature;
use super::held::Section;
use super::seek::{Look, Seeker};
use crate::geometry::distance::{Nearest, TouchingBall};
use crate::geometry::triangle::closest_point;
use crate::geometry::vector::{Vec3, along, distance, dot, norm2, scale, sub, unit};

/// Cosine of the angle up to which two edges run the same way (0.8°).
const ALIKE: f64 = 0.9999;

impl Seeker<'_> {
    /// Looks along the shortest chord of an edge or a vertex.
    pub(super) fn look_at_edge(&mut self, patch: &Patch, chord: &Chord) -> Look {
        let q = self.question;
        if let Some(sample) = self.along_chord(patch, chord) {
            if q.is_thin(sample.diameter) && patch.longest_edge().0 > q.resolution(sample.diameter) {
                return if self.faces_others(patch, chord) { Look::Done } else { Look::Coarse { low: chord.bound } };
            }
            self.push(sample);
            return Look::Done;
        }
        // A ball from the edge along the chord that is stopped sooner, at a flatter angle, is no wall.
        let d = sub(chord.to, chord.from);
        if chord.length > 0.0 {
            let ball = self.mesh.touching_ball(chord.from, scale(d, 1.0 / chord.length), 0.51 * q.notice, q.tolerance);
            if 2.0 * ball.radius < 0.98 * chord.length && patch.longest_edge().0 <= q.resolution(chord.bound) {
                self.look_across_edge(patch, chord);
                return Look::Done;
            }
        }
        if self.faces_others(patch, chord) {
            return Look::Done;
        }
        if patch.longest_edge().0 <= q.finest {
            self.look_across_edge(patch, chord);
        }
        Look::Open { low: chord.bound, beside: None }
    }

    /// Records the wall's ball at the middle of an edge that grows straight across it: round a neck the nearest chord is one of the secants
    /// beside the diameter, which the neck itself is in the way of. Balls within the edge grow in the planes across it, and so do their chords,
    /// but for what the contacts of a wall's ball lack to be opposite.
    fn look_across_edge(&mut self, patch: &Patch, chord: &Chord) {
        let q = self.question;
        let [a, b, _] = patch.corners;
        if a == b {
            return;
        }
        let (run, way) = (unit(sub(b, a)), sub(chord.to, chord.from));
        let across = unit(along(way, run, -dot(way, run)));
        if let Some(ball) = self.across_to_parallel(patch, run) {
            self.record_beside(patch, chord, (&ball, Shape::Waist));
            return;
        }
        for way in [across, scale(patch.axis, -1.0)].into_iter().filter(|way| norm2(*way) > 0.5) {
            self.cover.evaluations += 1;
            let ball = self.mesh.touching_ball(along(a, sub(b, a), 0.5), way, 0.51 * q.notice, q.tolerance);
            let is_wall = ball.separation() >= WALL_SEPARATION && 2.0 * ball.radius <= q.notice;
            let found = match ball.stop {
                Some(_) if is_wall => Some(ball),
                Some(_) => self.held(patch, ball.centre, [run, way]),
                None => None,
            };
            // What stops on a facet that the edge runs into is a wedge.
            let stops =
                |ball: &TouchingBall| ball.stop.is_some_and(|s| !meets(&patch.whole, &self.mesh.corners(s.facet)));
            if let Some(ball) = found.filter(stops) {
                self.record_beside(patch, chord, (&ball, Shape::Waist));
                return;
            }
        }
        if let Some(ball) = self.about_chord(patch, chord) {
            self.record_beside(patch, chord, (&ball, Shape::Bent));
        }
    }

    /// The wall's ball beside the middle of a chord: it grows from the point that is nearest to the middle, away from it, which nothing beside
    /// that point is in the way of.
    ///
    /// Where a side bends towards the balls at edge after edge, as that of a twisted blade does, the edges beside leave a ball on an edge hardly
    /// any other way.
    fn about_chord(&mut self, patch: &Patch, chord: &Chord) -> Option<TouchingBall> {
        let q = self.question;
        let middle = chord.middle();
        self.cover.evaluations += 2;
        let near = self.mesh.nearest(middle, 0.5 * chord.length)?;
        let way = unit(sub(middle, near.point));
        let ball = self.mesh.touching_ball(near.point, way, 0.51 * q.notice, q.tolerance);
        let stop = ball.stop.filter(|_| ball.separation() >= WALL_SEPARATION && 2.0 * ball.radius <= q.notice)?;
        let off = |p: Vec3| distance(p, closest_point(p, patch.corners));
        let [own, other] = match off(near.point) <= off(stop.point) {
            true => [near, stop],
            false => [stop, near],
        };
        (off(own.point) <= ball.radius).then_some(TouchingBall { from: own.point, stop: Some(other), ..ball })
    }

    fn record_beside(&mut self, patch: &Patch, chord: &Chord, (ball, shape): (&TouchingBall, Shape)) {
        let [a, b, _] = patch.corners;
        let low = self.features.nearest_chord_where(patch, self.question.notice, |f| !runs_along([a, b], f));
        let low = low.map_or(chord.bound, |c| c.bound.max(chord.bound));
        self.record(ball, shape, low, (patch, Share::WHOLE));
    }

    /// The empty ball whose diameter leads from the middle of the edge to the nearest edge apart from it that runs the same way: where two
    /// corners overlap, the edges beside are nearer and in no one plane.
    fn across_to_parallel(&mut self, patch: &Patch, run: Vec3) -> Option<TouchingBall> {
        let q = self.question;
        let is_parallel = |f: &Feature| {
            let [c, d, _] = f.corners;
            f.spread > 0.0 && c != d && dot(unit(sub(d, c)), run).abs() >= ALIKE && !meets(&patch.whole, &f.corners)
        };
        let chord = self.features.nearest_chord_where(patch, q.notice, is_parallel)?;
        let opposite = self.features.list.get(chord.feature as usize)?;
        let [a, b, _] = patch.corners;
        let from = along(a, sub(b, a), 0.5);
        let point = closest_point(from, opposite.corners);
        let (centre, radius) = (along(from, sub(point, from), 0.5), 0.5 * distance(from, point));
        self.cover.evaluations += 2;
        let is_empty = self.mesh.nearest(centre, radius - q.tolerance.max(1e-4 * radius)).is_none();
        let stop = Some(Nearest { point, facet: opposite.facet, distance: radius });
        (is_empty && 2.0 * radius <= q.notice).then_some(TouchingBall { from, centre, radius, stop })
    }

    /// The ball that touches the edge among those that the surface holds from all sides of a plane through it.
    ///
    /// Across a regular polygon the ball touches each side in its middle, and is as large nowhere else along it: one that grows from
    /// anywhere else is stopped by the sides beside, and from the middle by whichever rounding makes the first.
    fn held(&mut self, patch: &Patch, origin: Vec3, axes: [Vec3; 2]) -> Option<TouchingBall> {
        let q = self.question;
        let section = Section { mesh: self.mesh, origin, axes, agree: [1e-4, q.tolerance] };
        self.cover.evaluations += 2;
        let held = section.held(q.notice).filter(|held| 2.0 * held.radius <= q.notice)?;
        let from = closest_point(held.centre, patch.corners);
        let touches = distance(from, held.centre) <= held.radius + q.tolerance.max(1e-4 * held.radius);
        let stop = touches.then(|| section.opposite(&held, from)).flatten()?;
        Some(TouchingBall { from, centre: held.centre, radius: held.radius, stop: Some(stop) })
    }
}
