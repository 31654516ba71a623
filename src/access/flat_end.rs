//! Where the axis of a flat end may stand so that the end covers a point.

use crate::field::Indicator;
use crate::geometry::vector::Vec3;
use crate::grid::Grid;

/// The samples of a layer within a radius of a vertical, or the nearest where the radius holds none, row by row from the middle outwards.
pub(super) struct Covering {
    middle: [f64; 2],
    /// A row and its first and last sample.
    rows: Vec<(usize, [usize; 2])>,
}

impl Covering {
    /// Those of a grid about the vertical through a point.
    pub(super) fn of(grid: &Grid, at: Vec3, radius: f64) -> Self {
        let [x, y, _] = grid.continuous_index(at);
        let [nx, ny, _] = grid.dims();
        let r = radius / grid.h() * (1.0 + 1e-12);
        let row = |j: usize| {
            let half = (r * r - (j as f64 - y).powi(2)).max(0.0).sqrt();
            let [from, to] = [(x - half).ceil().max(0.0), (x + half).floor().min(nx as f64 - 1.0)];
            (from <= to).then_some((j, [from as usize, to as usize]))
        };
        let [from, to] = [(y - r).ceil().max(0.0), (y + r).floor().min(ny as f64 - 1.0)];
        let held = (from <= to).then_some(from as usize..=to as usize);
        let mut rows: Vec<_> = held.into_iter().flatten().filter_map(row).collect();
        if rows.is_empty() {
            let nearest = grid.sample_at([at[0], at[1], grid.position([0; 3])[2]]);
            rows.extend(nearest.map(|[i, j, _]| (j, [i, i])));
        }
        rows.sort_by(|a, b| (a.0 as f64 - y).abs().total_cmp(&(b.0 as f64 - y).abs()));
        Covering { middle: [x, y], rows }
    }

    /// Whether a set leaves any of them clear in a layer.
    ///
    /// # Cost
    /// A word operation for each 64 samples of a row.
    pub(super) fn any_clear(&self, set: &Indicator, layer: usize) -> bool {
        self.rows.iter().any(|&(j, [from, to])| {
            let row = set.row(j, layer);
            (from / 64..=to / 64).any(|word| {
                let upwards = if word == from / 64 { u64::MAX << (from % 64) } else { u64::MAX };
                let downwards = if word == to / 64 { u64::MAX >> (63 - to % 64) } else { u64::MAX };
                !row[word] & upwards & downwards != 0
            })
        })
    }

    /// The one nearest to the vertical that a set leaves clear in a layer.
    pub(super) fn nearest_clear(&self, set: &Indicator, layer: usize) -> Option<[usize; 3]> {
        let all = self.rows.iter().flat_map(|&(j, [from, to])| (from..=to).map(move |i| [i, j, layer]));
        let off = |[i, j, _]: [usize; 3]| (i as f64 - self.middle[0]).hypot(j as f64 - self.middle[1]);
        all.filter(|&index| !set.contains(index)).min_by(|a, b| off(*a).total_cmp(&off(*b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Lcg;
    use crate::units::Length;

    #[test]
    fn clear_samples_that_cover_a_point_are_those_that_a_look_at_every_one_finds() {
        let grid = Grid::new([-3.0, 2.0, 0.0], Length::mm(0.5), [150, 60, 3]).unwrap();
        let mut random = Lcg(5);
        let mut found = [0; 2];
        for turn in 0..400 {
            let place = random.point(0.0, 1.0);
            let at = [-6.0 + 80.0 * place[0], 35.0 * place[1], 0.6];
            let radius = if turn % 4 == 0 { 0.1 } else { 30.0 * place[2] };
            let clear: Vec<[usize; 3]> =
                (0..3).map(|_| [random.below(150) as usize, random.below(60) as usize, 1]).collect();
            let set = Indicator::from_predicate(grid, |at| !clear.contains(&grid.index(at)));
            let beside = |i: [usize; 3]| {
                let p = grid.position(i);
                (p[0] - at[0]).hypot(p[1] - at[1])
            };
            let covers = |i: [usize; 3]| beside(i) <= radius;
            let none = !(0..150 * 60).any(|n| covers([n % 150, n / 150, 1]));
            let nearest = grid.sample_at(at).filter(|_| none);
            let want = clear.iter().copied().filter(|&i| covers(i) || nearest == Some(i));
            let want = want.min_by(|a, b| beside(*a).total_cmp(&beside(*b)));
            let covering = Covering::of(&grid, at, radius);
            assert_eq!(covering.any_clear(&set, 1), want.is_some(), "{at:?} {radius} {clear:?}");
            assert_eq!(covering.nearest_clear(&set, 1), want, "{at:?} {radius}");
            assert!(!covering.any_clear(&set, 0), "nothing is clear in that layer");
            found[usize::from(want.is_some())] += 1;
        }
        assert!(found.iter().all(|&n| n > 50), "{found:?}");
    }
}
