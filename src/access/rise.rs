//! How far straight up it is free.

use crate::field::Indicator;
use crate::geometry::vector::Vec3;

/// For each sample of a grid the steps up to the first that is free.
pub(super) struct Rise {
    dims: [usize; 3],
    /// Along x, then y, then z.
    steps: Vec<u32>,
}

impl Rise {
    /// Over the samples that are not free. Above the grid all is.
    ///
    /// # Cost
    /// One walk over the samples, 4 bytes each.
    pub(super) fn over(hit: &Indicator) -> Self {
        let dims @ [nx, ny, nz] = hit.grid().dims();
        let mut steps = vec![0; nx * ny * nz];
        for k in (0..nz).rev() {
            let (lower, upper) = steps.split_at_mut((k + 1) * nx * ny);
            for j in 0..ny {
                let row = hit.row(j, k);
                for i in 0..nx {
                    // Nothing is above the last layer: it is one step below what is free.
                    let next = upper.get(j * nx + i).copied().unwrap_or(0);
                    let bit = (row[i / 64] >> (i % 64) & 1) as u32;
                    lower[(k * ny + j) * nx + i] = bit * (next + 1);
                }
            }
        }
        Rise { dims, steps }
    }

    /// Steps up from a point, given by its continuous index, until it is free; nothing is known below the grid and beside it.
    pub(super) fn from(&self, [x, y, z]: Vec3) -> usize {
        let [nx, ny, nz] = self.dims;
        let within = |c: f64, n: usize| (c + 0.5 >= 0.0 && c + 0.5 < n as f64).then_some((c + 0.5) as usize);
        let layer = (z + 0.5).floor();
        let (Some(i), Some(j)) = (within(x, nx), within(y, ny)) else {
            return (nz as f64 - layer).max(0.0) as usize;
        };
        let below = (-layer).max(0.0) as usize;
        let steps = self.steps.get((layer.max(0.0) as usize * ny + j) * nx + i);
        below + steps.map_or(0, |&s| s as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::random::Lcg;
    use crate::units::Length;

    #[test]
    fn it_is_as_far_as_a_walk_up_the_column_goes() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [70, 5, 9]).unwrap();
        let mut random = Lcg(7);
        let bits: Vec<bool> = (0..grid.samples()).map(|_| random.below(10) < 8).collect();
        let hit = Indicator::from_predicate(grid, |at| bits[at]);
        let rise = Rise::over(&hit);
        for _ in 0..4000 {
            let p = random.point(0.0, 1.0);
            let at = [-3.0 + 76.0 * p[0], -1.0 + 7.0 * p[1], -4.0 + 15.0 * p[2]];
            let free = |s: usize| {
                let up = [at[0], at[1], at[2] + s as f64];
                grid.sample_of(up).map_or(up[2] >= 8.5, |i| !hit.contains(i))
            };
            assert_eq!(Some(rise.from(at)), (0..99).find(|&s| free(s)), "{at:?}");
        }
    }
}
