//! Which features anything opposes at all: neighbours are asked about together.

use super::chord::{MARGIN, WALL_SEPARATION};
use super::facing::{Query, Visit};
use super::feature::{Feature, Features};
use super::reach::{Reach, Slabs};
use crate::geometry::vector::{Vec3, add, bounds, dot, norm2, unit};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Features that are asked about at once, at most.
const MOST: usize = 64;
/// Features whose directions spread by more than this about their mean are asked about by halves, radians (30°).
const WIDE: f64 = 30.0 * std::f64::consts::PI / 180.0;
/// What the arc cosine of a rounded cosine may be off by, radians.
const ROUNDED_ANGLE: f64 = 1e-6;

impl Features {
    /// The features, in the order of the tree, that a chord no longer than `within` may start from; from no other does one.
    ///
    /// A chord from any of some features starts in their hull, runs within a cone about the opposite of their mean direction and
    /// ends where the surface faces it: the cone of a single one, wider by what their directions differ. Where nothing is in the
    /// way of all these, all are done with; else their halves are asked about, and single ones are left to
    /// [`Features::nearest_chord`].
    ///
    /// # Cost
    /// One walk of the tree for up to 64 features that nothing opposes.
    pub(super) fn may_be_opposed(&self, within: f64) -> Vec<u32> {
        let runs = self.facing.order().par_chunks(MOST);
        let opposed = runs.flat_map_iter(|run| {
            let (facets, others): (Vec<u32>, Vec<u32>) = run.iter().partition(|&&f| self.list[f as usize].is_facet());
            let mut opposed = Vec::new();
            self.opposed_of(&facets, within, &mut opposed);
            self.opposed_of(&others, within, &mut opposed);
            opposed
        });
        opposed.collect()
    }

    fn opposed_of(&self, run: &[u32], within: f64, opposed: &mut Vec<u32>) {
        match run {
            [] => {}
            [one] => opposed.push(*one),
            _ => {
                if !self.are_free(run, within) {
                    let (before, after) = run.split_at(run.len() / 2);
                    self.opposed_of(before, within, opposed);
                    self.opposed_of(after, within, opposed);
                }
            }
        }
    }

    /// Whether it is certain that no chord no longer than `within` starts from any of some features.
    fn are_free(&self, run: &[u32], within: f64) -> bool {
        let all = || run.iter().map(|&f| &self.list[f as usize]);
        let axis = unit(all().fold([0.0; 3], |sum, f| add(sum, f.axis)));
        let Some(spread) = spread_about(axis, all()) else { return false };
        let corners: Vec<Vec3> = all().flat_map(|f| f.corners).collect();
        let (Some(sides), Some(extent)) = (bounds(corners.iter().copied()), self.facing.extent()) else { return true };
        let half_angle = 0.5 * (std::f64::consts::PI - WALL_SEPARATION) + MARGIN + spread;
        let slabs = Slabs::new(&Reach::of(&corners, axis, half_angle), extent);
        let query = Query::new(sides, axis, WALL_SEPARATION - MARGIN - spread, slabs);
        Arch::new().dispatch(Asked { features: self, query, within2: within * within })
    }
}

/// How far the directions of some features spread about an axis, radians; `None` if too far to be asked about together.
fn spread_about<'a>(axis: Vec3, all: impl Iterator<Item = &'a Feature>) -> Option<f64> {
    let (least, own) =
        all.fold((1.0f64, 0.0f64), |(least, own), f| (least.min(dot(axis, f.axis)), own.max(f.spread + f.slack)));
    let spread = least.clamp(-1.0, 1.0).acos() + ROUNDED_ANGLE + own;
    (norm2(axis) > 0.0 && spread <= WIDE).then_some(spread)
}

/// Whether nothing answers a query.
struct Asked<'a> {
    features: &'a Features,
    query: Query,
    within2: f64,
}

impl NullaryFnOnce for Asked<'_> {
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        let mut first = First { found: false };
        self.features.facing.opposing(&self.query, (self.within2, None), &mut first);
        !first.found
    }
}

/// Ends a walk at the first feature.
struct First {
    found: bool,
}

impl Visit for First {
    #[inline(always)]
    fn visit(&mut self, _: u32, _: f64) -> f64 {
        self.found = true;
        f64::NEG_INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::super::chord::Patch;
    use super::super::feature::Side;
    use super::*;
    use crate::geometry::{Primitive, cuboid};
    use crate::units::Length;

    #[test]
    fn no_chord_starts_from_what_is_left_out() {
        let ball = |r: f64| Primitive::Ball { radius: Length::mm(r) }.mesh(Length::mm(0.01));
        let (s, c) = 0.7f64.sin_cos();
        let inner = ball(2.5).transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.2, 0.11, 0.02]);
        let posts = ball(0.3).transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [3.5, 0.0, 0.0]);
        let mesh = ball(3.0).joined(&inner.flipped()).joined(&posts).joined(&cuboid([4.0; 3], [4.4, 6.0, 7.0]));
        let (mut opposed, mut left_out) = (0, 0);
        for (side, within) in [(Side::Material, 0.35), (Side::Material, 0.6), (Side::Void, 0.4), (Side::Void, 6.0)] {
            let features = Features::new(&mesh, side, |_| true);
            let mut asked = vec![false; features.list.len()];
            features.may_be_opposed(within).into_iter().for_each(|f| asked[f as usize] = true);
            for (feature, asked) in features.list.iter().zip(asked) {
                let chord = features.nearest_chord(&Patch::from(feature), within, &mut None);
                assert!(asked || chord.is_none());
                opposed += usize::from(chord.is_some());
                left_out += usize::from(!asked);
            }
        }
        // Both answers are given thousands of times, so neither goes untried.
        assert!(opposed > 1000 && left_out > 1000, "{opposed} {left_out}");
    }
}
