//! The medial axis on a grid: how far apart the nearest points of the surface are seen.

use crate::distance::{NOWHERE, nearest_sample};
use crate::error::Result;
use crate::field::{Field, Indicator};
use rayon::prelude::*;

/// The angle, in radians, under which the nearest samples outside of a sample of the set and of its six neighbours are seen: 0 where
/// all agree, π in the middle of a wall; NaN outside the set. Everything beyond the grid is outside.
///
/// separation(y) = max { ∠(p(y) − y, p(y') − y) : |y − y'| = h }, p(y) a nearest sample outside. The θ-simplified medial axis is { separation ≥ θ }:
/// 150° keeps walls and rods, 120° wedges of up to 60° too, 90° the bisectors of right angles. An estimate: it is taken between
/// sample centres, and shows walls that are at least two samples thick.
///
/// # Errors
/// As [`nearest_sample`].
///
/// # Cost
/// One feature transform and one walk over the samples.
///
/// # Source
/// M. Foskey, M. Lin, D. Manocha, *Efficient computation of a simplified medial axis*, 2003.
pub fn separation(set: &Indicator) -> Result<Field<f32>> {
    let grid = *set.grid();
    // One more sample on every side, so that a set that reaches the border has an outside there.
    let wide = grid.padded([1; 3], [1; 3])?;
    let [nx, ny, _] = wide.dims();
    let nearest = nearest_sample(&set.placed([-1; 3], wide)?.complement())?;
    let nearest = nearest.values();
    let towards = |of: usize| {
        let (from, to) = (wide.index(of), (nearest[of] != NOWHERE).then(|| wide.index(nearest[of] as usize))?);
        let d = [0, 1, 2].map(|a| to[a] as f32 - from[a] as f32);
        let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        (length > 0.0).then(|| d.map(|x| x / length))
    };
    let mut values = vec![f32::NAN; grid.samples()];
    values.par_iter_mut().enumerate().for_each(|(at, value)| {
        let i = grid.index(at);
        if !set.contains(i) {
            return;
        }
        let at = wide.offset(i.map(|c| c + 1));
        let Some(own) = towards(at) else { return };
        let mut least = 1.0f32;
        for of in [1, nx, nx * ny].into_iter().flat_map(|stride| [at - stride, at + stride]) {
            if let Some(other) = towards(of) {
                least = least.min(own[0] * other[0] + own[1] * other[1] + own[2] * other[2]);
            }
        }
        *value = least.clamp(-1.0, 1.0).acos();
    });
    Field::from_values(grid, values, f32::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::units::Length;

    #[test]
    fn a_plate_has_its_axis_in_the_middle_and_right_angles_at_its_rim() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [41, 41, 12]).expect("a grid");
        let inside = |at: usize| {
            let [i, j, k] = grid.index(at);
            (2..39).contains(&i) && (2..39).contains(&j) && (2..10).contains(&k)
        };
        let set = Indicator::from_predicate(grid, inside);
        let field = separation(&set).expect("a field");
        let at = |i: [usize; 3]| field.values()[grid.offset(i)].to_degrees();
        assert!(at([20, 20, 5]) > 175.0 || at([20, 20, 6]) > 175.0, "{} {}", at([20, 20, 5]), at([20, 20, 6]));
        assert!(at([20, 20, 3]) < 20.0 && at([0, 0, 0]).is_nan());
        let bisector = at([3, 20, 3]).max(at([4, 20, 4]));
        assert!((60.0..120.0).contains(&bisector), "{bisector}");
    }

    #[test]
    fn a_set_that_fills_its_grid_has_the_axis_it_has_with_room_around() {
        let inside = |at: usize, dims: [usize; 3], room: usize| {
            let i = [at % dims[0], at / dims[0] % dims[1], at / (dims[0] * dims[1])];
            (0..3).all(|a| (room..dims[a] - room).contains(&i[a]))
        };
        let field = |room: usize| {
            let dims = [9, 7, 5].map(|n| n + 2 * room);
            let grid = Grid::new([0.0; 3], Length::mm(1.0), dims).expect("a grid");
            separation(&Indicator::from_predicate(grid, |at| inside(at, dims, room))).expect("a field")
        };
        let (tight, roomy) = (field(0), field(2));
        for at in 0..tight.grid().samples() {
            let there = roomy.grid().offset(tight.grid().index(at).map(|c| c + 2));
            assert_eq!(tight.values()[at], roomy.values()[there], "{:?}", tight.grid().index(at));
        }
    }
}
