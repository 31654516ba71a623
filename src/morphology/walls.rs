//! Where a rolling ball touches the part: there its surface stays as it is.
//!
//! Let E be the positions of the ball's centre, `{ d ≤ −ρ }` for an opening. A ball that touches the part at the foot q of a
//! point x, and holds no other point of its surface, has its centre c in E, and |x − c| = ρ + d(x), which no point of E is
//! nearer than: the distance from x to E, less ρ, is d(x). So the opening is known there from distances to the part, however
//! thin E is. Closings are the same from outside.

use super::bodies::Facets;
use super::level::{Level, Seen};
use super::near::{EXACT, Near};
use super::offset::HALF_DIAGONAL;
use super::press::nearest_place;
use super::rolling::Covered;
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::MeshDistance;
use crate::geometry::distance::Nearest;
use crate::geometry::vector::{Vec3, along, distance, scale, sub};
use crate::units::Length;
use rayon::prelude::*;

/// How far facets may reach into a ball that touches, in spacings: rounding, and the facets of round walls, whose edges stand
/// out between its contacts. The surface is off by no more.
pub(super) const REACH_IN: f64 = 0.005;

/// A place of the ball counts where it is nearer by this than what was known, in spacings.
const BETTER: f64 = 0.02;

/// The walls of a part that a ball touches, rolling on one side of them.
pub(super) struct Walls {
    level: Level,
    /// The samples that were measured to walls.
    held: Indicator,
    /// Those of them where no facet reaches into the ball.
    clear: Indicator,
    /// Those measured to the nearest place of the ball.
    pressed: Indicator,
    /// The sign tells the side: below zero the ball rolls inside.
    ball: f64,
    centres: Indicator,
    /// Places of the ball that stand for exact ones at the samples near them.
    known: Vec<Vec3>,
    crowded: Indicator,
    unsought: bool,
}

/// The signed distances to the part: exact where [`Walls::held`] and within [`EXACT`] spacings of zero; elsewhere farther
/// from zero and of the right sign.
pub(super) type Distances = Field<f32>;

impl Walls {
    /// The walls of the part that a ball touches whose centre is `ball` from them, outwards. Samples are asked that are within
    /// [`EXACT`] spacings of the surface, or on the ball's side and not known to be `covered` by balls.
    ///
    /// # Cost
    /// Two distances to the mesh for each of those samples.
    pub(super) fn of(
        of: Facets,
        centres: &Indicator,
        shell2: &Field<u32>,
        ball: Length,
        covered: &Covered,
    ) -> Result<(Distances, Self)> {
        let (mut distances, near) = Near::of(of, centres, shell2, 0.0, None)?;
        let (grid, ball) = (*centres.grid(), ball.as_mm());
        let level = Level { near, r: 0.0 };
        let mut walls = Walls {
            level,
            held: Indicator::empty(grid),
            clear: Indicator::empty(grid),
            pressed: Indicator::empty(grid),
            ball,
            centres: centres.clone(),
            known: covered.known.clone(),
            crowded: covered.crowded.clone(),
            unsought: covered.unsought,
        };
        let ([nx, ny, _], words) = (grid.dims(), walls.held.words_per_row());
        let (mut held, mut clear) = (walls.held.clone(), walls.clear.clone());
        let rows = held.words_mut().par_chunks_mut(words).zip(clear.words_mut().par_chunks_mut(words));
        let rows = distances.values_mut().par_chunks_mut(nx).zip(rows).enumerate();
        rows.for_each(|(row, (distances, (held, clear)))| {
            let mut last = None;
            for (i, distance) in distances.iter_mut().enumerate() {
                let index = [i, row % ny, row / ny];
                if let Some(reach_in) = walls.holds_sample(index, distance, covered, &mut last) {
                    held[i / 64] |= 1 << (i % 64);
                    clear[i / 64] |= u64::from(reach_in == 0.0) << (i % 64);
                }
            }
        });
        (walls.held, walls.clear) = (held, clear);
        Ok((distances, walls))
    }

    /// How far facets reach into the ball that touches at a sample's foot, if the sample is measured to a wall; its distance
    /// becomes exact then. The facet of the last sample that was sought in the tree is where this one's is sought from.
    fn holds_sample(
        &self,
        index: [usize; 3],
        distance: &mut f32,
        covered: &Covered,
        last: &mut Option<u32>,
    ) -> Option<f64> {
        let (grid, near) = (self.centres.grid(), &self.level.near);
        let d = f64::from(*distance);
        let beside = d.abs() <= EXACT * grid.h();
        let balls_side = self.centres.contains(index) == (self.ball < 0.0);
        let asked = beside || balls_side && !covered.surely.contains(index);
        if !asked || !covered.reached.contains(index) || covered.crowded.contains(index) {
            return None;
        }
        let p = grid.position(index);
        let n = if beside { near.nearest_of_sample(index)? } else { self.sought(p, last)? };
        let outwards = match n.distance > 1e-6 * grid.h() {
            true => scale(sub(p, n.point), 1f64.copysign(d) / n.distance),
            false => near.facing(&n),
        };
        let reach_in = self.reach_in(&n, outwards)?;
        *distance = n.distance.copysign(d) as f32;
        Some(reach_in)
    }

    /// The point of the part nearest to another one, if it is nearer than the ball's radius.
    fn sought(&self, p: Vec3, last: &mut Option<u32>) -> Option<Nearest> {
        let (mesh, radius) = (self.level.near.mesh(), self.ball.abs());
        let found = match *last {
            Some(facet) => Some(mesh.nearest_from(p, facet)).filter(|n| n.distance < radius),
            None => mesh.nearest(p, radius),
        };
        *last = found.map(|n| n.facet).or(*last);
        found
    }

    /// Whether the ball fits that touches the part in a point, seen from the direction given.
    fn ball_touches(&self, n: &Nearest, outwards: Vec3) -> bool {
        self.reach_in(n, outwards).is_some()
    }

    /// How far facets reach into that ball, millimetres, if no further than [`REACH_IN`]; 0 but for rounding.
    fn reach_in(&self, n: &Nearest, outwards: Vec3) -> Option<f64> {
        let radius = self.ball.abs();
        let free = radius - REACH_IN * self.centres.grid().h();
        let centre = along(n.point, outwards, self.ball);
        if !self.may_stand(centre, free) {
            return None;
        }
        match self.level.near.mesh().nearest_or_any(centre, radius * (1.0 - 1e-9), free) {
            None => Some(0.0),
            Some(facet) => (facet.distance >= free).then_some(radius - facet.distance),
        }
    }

    /// As [`on_its_side()`] says of a centre.
    fn may_stand(&self, centre: Vec3, radius: f64) -> bool {
        on_its_side(self.level.near.mesh(), &self.centres, centre, radius.copysign(self.ball)) && radius > 0.0
    }

    /// Brings `values` of the result nearer to what the ball covers, at samples near the part that no wall holds, where a
    /// place of the ball is found that covers them better. Only what fits is found, so that nothing is covered in vain.
    ///
    /// # Cost
    /// A distance to the mesh for each plane that stops the ball, at samples that it seems not to cover; none for what a known place covers
    /// deeply, or where too many facets are about as near.
    pub(super) fn press(&mut self, values: &mut Field<f32>, distances: &Distances, covered: &Covered) {
        let grid = *self.centres.grid();
        let ([nx, ny, _], words, h) = (grid.dims(), self.held.words_per_row(), grid.h());
        let side = -self.ball.signum();
        let mut pressed = std::mem::replace(&mut self.pressed, Indicator::empty(grid));
        let rows = values.values_mut().par_chunks_mut(nx).zip(distances.values().par_chunks(nx));
        rows.zip(pressed.words_mut().par_chunks_mut(words)).enumerate().for_each(
            |(row, ((values, distances), bits))| {
                for (i, (value, &d)) in values.iter_mut().zip(distances).enumerate() {
                    let index = [i, row % ny, row / ny];
                    let left = side * f64::from(*value);
                    let near = f64::from(d.abs()) <= EXACT * h || self.centres.contains(index) == (self.ball < 0.0);
                    if left <= 0.0 || !near || self.held.contains(index) || !covered.reached.contains(index) {
                        continue;
                    }
                    if covered.deep.contains(index) {
                        *value = (-2.0 * side * h) as f32;
                        bits[i / 64] |= 1 << (i % 64);
                        continue;
                    }
                    if let Some(found) =
                        self.pressed_value(grid.position(index)).filter(|s| side * s.0 < left - BETTER * h)
                    {
                        *value = found.0 as f32;
                        bits[i / 64] |= 1 << (i % 64);
                    }
                }
            },
        );
        self.pressed = pressed;
    }

    /// The distance to the surface of the ball in its place nearest to a point, negative in the result, with its slope.
    fn pressed_value(&self, p: Vec3) -> Option<(f64, Vec3)> {
        let (h, side) = (self.centres.grid().h(), -self.ball.signum());
        let free = self.ball.abs() - REACH_IN * h;
        let reach = self.ball.abs() + 2.0 * h;
        let crowded = self.centres.grid().sample_at(p).is_some_and(|index| self.crowded.contains(index));
        let place = || nearest_place(self.level.near.mesh(), free * self.ball.signum(), p, reach);
        let centre = match crowded {
            true => self.known_place(p, reach),
            false => (free > 0.0 && !self.unsought).then(place)?,
        }?;
        let (off, apart) = (sub(p, centre), distance(p, centre));
        let stands = apart > 1e-9 * h && (crowded || self.may_stand(centre, free));
        stands.then(|| (side * (apart - self.ball.abs()), scale(off, side / apart)))
    }

    /// The known place of the ball that is nearest to a point, if it is within reach.
    fn known_place(&self, p: Vec3, reach: f64) -> Option<Vec3> {
        let near = self.known.iter().copied().filter(|&place| distance(p, place) <= reach);
        near.min_by(|&a, &b| distance(p, a).total_cmp(&distance(p, b)))
    }

    /// Whether a sample was measured to a wall.
    pub(super) fn hold(&self, index: [isize; 3]) -> bool {
        holds(&self.held, index)
    }

    /// Whether a sample was measured to the nearest place of the ball.
    pub(super) fn pressed(&self, index: [isize; 3]) -> bool {
        holds(&self.pressed, index)
    }

    /// The ball's surface as seen from a point, in its place nearest to it, if one of the samples about the point was
    /// measured so.
    pub(super) fn seen_pressed(&self, p: Vec3) -> Option<Seen> {
        let first = self.centres.grid().continuous_index(p).map(|i| i.floor() as isize);
        let mut about = (0..8).map(|at| [0, 1, 2].map(|a| first[a] + (at >> a & 1)));
        let value = about.any(|index| self.pressed(index)).then(|| self.pressed_value(p))??;
        Some(Seen { value, normal: value.1 })
    }

    /// The samples that were measured to walls.
    pub(super) fn held(&self) -> &Indicator {
        &self.held
    }

    /// Those of them whose ball no facet reaches into.
    pub(super) fn clear(&self) -> &Indicator {
        &self.clear
    }

    /// The part's own surface.
    pub(super) fn level(&self) -> &Level {
        &self.level
    }

    /// The wall as seen from a point near it, if the ball touches it there.
    pub(super) fn seen(&self, p: Vec3) -> Option<Seen> {
        self.touched(p)?;
        self.level.seen(p)
    }

    /// The point of a wall nearest to a point near it, if the ball touches it there.
    pub(super) fn project(&self, p: Vec3) -> Option<Vec3> {
        Some(self.touched(p)?.point)
    }

    /// Outward normal of the wall that a point lies on.
    pub(super) fn normal(&self, p: Vec3) -> Option<Vec3> {
        let n = self.level.near.nearest(p)?;
        let facing = self.level.near.facing(&n);
        (n.distance < 0.02 * self.centres.grid().h() && self.ball_touches(&n, facing)).then_some(facing)
    }

    /// The foot of a point on a facet within a quarter of a spacing, if the ball touches there.
    fn touched(&self, p: Vec3) -> Option<Nearest> {
        let n = self.level.near.nearest(p)?;
        let (_, facing) = self.level.height(p, &n)?;
        (n.distance < 0.25 * self.centres.grid().h() && self.ball_touches(&n, facing)).then_some(n)
    }
}

/// Whether the centre of a ball that no facet reaches into is on its side, outside where `ball` is positive, as far as samples tell: one that
/// lies in the ball is on the same side of all facets. A ball that may lie between samples is asked itself.
pub(super) fn on_its_side(mesh: &MeshDistance, centres: &Indicator, centre: Vec3, ball: f64) -> bool {
    let (grid, radius) = (centres.grid(), ball.abs());
    let holds = |index: [usize; 3]| distance(grid.position(index), centre) <= radius;
    let inside = match grid.sample_at(centre) {
        Some(index) if radius > HALF_DIAGONAL * grid.h() || holds(index) => centres.contains(index),
        Some(_) => mesh.nearest(centre, f64::INFINITY).is_some_and(|n| mesh.is_behind(centre, &n)),
        None => return false,
    };
    inside == (ball < 0.0)
}

/// Whether a set has a sample, which may be off the grid.
fn holds(set: &Indicator, index: [isize; 3]) -> bool {
    let (dims, index) = (set.grid().dims(), index.map(|i| usize::try_from(i).unwrap_or(usize::MAX)));
    (0..3).all(|a| index[a] < dims[a]) && set.contains(index)
}
