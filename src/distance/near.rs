//! Signed distances at single samples near the boundary of a set, without the field.

use crate::field::{Indicator, bits_from};

/// How far a boundary is looked for, spacings.
const REACH: i32 = 20;

/// The values of [`super::signed_distance`] at single samples, found along the bit rows around them.
#[derive(Debug, Clone)]
pub struct NearBoundary<'a> {
    set: &'a Indicator,
    /// Rows within reach as steps along y and z with their squared distance, nearest first.
    rows: Vec<([i16; 2], i32)>,
}

impl<'a> NearBoundary<'a> {
    /// The set made ready.
    pub fn new(set: &'a Indicator) -> Self {
        let steps = || -REACH..=REACH;
        let all = steps().flat_map(|z| steps().map(move |y| ([y as i16, z as i16], y * y + z * z)));
        let mut rows: Vec<_> = all.filter(|row| row.1 <= REACH * REACH).collect();
        rows.sort_by_key(|row| row.1);
        NearBoundary { set, rows }
    }

    /// What [`super::signed_distance`] gives at a sample, millimetres; nothing where the boundary is farther than twenty spacings.
    ///
    /// # Cost
    /// One word for each row that is nearer than the boundary.
    pub fn at(&self, index: [isize; 3]) -> Option<f32> {
        let inside = self.bits(index, [0; 2]) >> MIDDLE & 1 == 1;
        let mut nearest = i32::MAX;
        for &(step, apart) in &self.rows {
            if apart >= nearest {
                break;
            }
            let bits = self.bits(index, step);
            nearest = nearest.min(apart + along_row(if inside { !bits } else { bits }));
        }
        // Beyond the reach other rows may hold a nearer sample.
        (nearest <= REACH * REACH).then(|| {
            let distance = ((nearest as f32).sqrt() - 0.5) * self.set.grid().h() as f32;
            if inside { -distance } else { distance }
        })
    }

    /// 64 bits of a row, `MIDDLE` of them before the sample; all outside beyond the grid.
    #[inline]
    fn bits(&self, [i, j, k]: [isize; 3], [y, z]: [i16; 2]) -> u64 {
        let [nx, ny, nz] = self.set.grid().dims();
        let (j, k) = (j + isize::from(y), k + isize::from(z));
        let held = (0..ny as isize).contains(&j) && (0..nz as isize).contains(&k);
        if held { bits_from(self.set.row(j as usize, k as usize), nx, i - MIDDLE as isize) } else { 0 }
    }
}

const MIDDLE: u32 = 32;

/// The squared distance from the middle of 64 bits to the nearest that is set, far beyond reach if there is none.
#[inline]
fn along_row(bits: u64) -> i32 {
    let after = (bits >> MIDDLE).trailing_zeros();
    let before = (bits << MIDDLE).leading_zeros() + 1;
    (after.min(before) as i32).pow(2)
}

#[cfg(test)]
mod tests {
    use super::super::signed_distance;
    use super::*;
    use crate::grid::Grid;
    use crate::units::Length;

    #[test]
    fn every_sample_within_reach_has_the_value_of_the_field() {
        for (dims, one_in) in [([70, 50, 9], 300), ([130, 5, 60], 40), ([3, 4, 5], 2), ([66, 66, 66], 200_000)] {
            let grid = Grid::new([0.5, -1.0, 2.0], Length::mm(0.3), dims).unwrap();
            let dots = Indicator::from_predicate(grid, |at| (at * 7919 + at / 5).is_multiple_of(one_in));
            for set in [dots.complement(), dots] {
                let (field, near) = (signed_distance(&set).unwrap(), NearBoundary::new(&set));
                let mut found = 0;
                for at in 0..grid.samples() {
                    let index = grid.index(at).map(|i| i as isize);
                    let want = field.field().at(index);
                    match near.at(index) {
                        Some(value) => assert_eq!(value, want, "{index:?}"),
                        None => assert!(want.abs() > (REACH as f32 - 0.5) * 0.3, "{index:?} {want}"),
                    }
                    found += usize::from(near.at(index).is_some());
                }
                assert!(found > 0);
            }
        }
    }
}
