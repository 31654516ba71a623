//! The density of a part, coarse enough to stand in a page.

use super::exhibit::Volume;
use crate::field::Field;
use crate::grid::Grid;
use crate::units::Length;
use rayon::prelude::*;

/// Most samples along the longest side.
const LONGEST: usize = 128;

/// A density on a grid of at most 128 samples a side: each sample is the mean of a cube of the finer ones.
///
/// # Cost
/// O(samples of the density), in parallel over layers.
pub fn volume(density: &Field<f32>) -> Option<Volume> {
    let fine = density.grid();
    let dims = fine.dims();
    let k = dims.iter().copied().max().unwrap_or(1).div_ceil(LONGEST).max(1);
    let [nx, ny, nz] = dims.map(|n| n.div_ceil(k));
    // The centre of the first cube stands half a cube after the fine grid's first side.
    let origin = fine.origin().map(|x| x + 0.5 * (k as f64 - 1.0) * fine.h());
    let grid = Grid::new(origin, Length::mm(fine.h() * k as f64), [nx, ny, nz]).ok()?;
    let values = density.values();
    let mut out = vec![0u8; grid.samples()];
    out.par_chunks_mut(nx * ny).enumerate().for_each(|(layer, plane)| {
        let mut sums = vec![0f32; nx * ny];
        for z in layer * k..((layer + 1) * k).min(dims[2]) {
            for y in 0..dims[1] {
                let start = (z * dims[1] + y) * dims[0];
                let row = values.get(start..start + dims[0]).unwrap_or(&[]);
                for (sum, cube) in sums[y / k * nx..].iter_mut().zip(row.chunks(k)) {
                    *sum += cube.iter().sum::<f32>();
                }
            }
        }
        let whole = (k * k * k) as f32;
        plane.iter_mut().zip(sums).for_each(|(d, s)| *d = (255.0 * s / whole).round().clamp(0.0, 255.0) as u8);
    });
    (out.len() == nx * ny * nz).then_some(Volume { grid, density: out })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubes_are_means_and_keep_their_places() {
        let grid = Grid::new([0.5; 3], Length::mm(1.0), [256, 2, 2]).unwrap();
        // Solid from x = 3 mm on: the cube of samples 2 and 3 is half full.
        let values = (0..grid.samples()).map(|o| if grid.index(o)[0] >= 3 { 1.0 } else { 0.0 }).collect();
        let v = volume(&Field::from_values(grid, values, 0.0).unwrap()).unwrap();
        assert_eq!((v.grid.dims(), v.grid.h(), v.grid.origin()), ([128, 1, 1], 2.0, [1.0; 3]));
        assert_eq!(v.density[..3], [0, 128, 255]);
    }
}
