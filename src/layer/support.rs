//! Supports as columns: straight down from what hangs over to the part or the plate.

use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::Vec3;
use crate::geometry::{DisjointSets, TriangleMesh};
use crate::grid::Grid;
use crate::units::Volume;
use rustc_hash::{FxHashMap, FxHashSet};

/// The supports of a set of downward facets, sampled.
///
/// A sample c outside the part, above the plate, belongs to `columns` if the first of the part that the ray from c along +z
/// meets is one of the facets. The ends of the columns are subsets of them, so that `components(&columns, Adjacency::Face)`
/// labels the supports, and each end sample touches the part, or the plate, with one square of h × h.
#[derive(Debug, Clone, PartialEq)]
pub struct Supports {
    /// All samples of all columns.
    pub columns: Indicator,
    /// The uppermost sample of each column: what it holds up is just above.
    pub heads: Indicator,
    /// The lowest samples of columns that stand on the part.
    pub feet_on_part: Indicator,
    /// The lowest samples of columns that stand on the plate.
    pub feet_on_plate: Indicator,
}

impl Supports {
    /// Volume of the columns: samples times the volume of a sample. An estimate; the column integral has bounds.
    pub fn volume(&self) -> Volume {
        self.columns.volume()
    }

    /// Whether nothing needs a support.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Families of the pieces that the columns make, and the facets that hang on each: the family of each of `count` pieces is the
    /// number of its first, and that of a sample's piece is told by `piece`.
    ///
    /// Pieces are of one family if some facet has columns of both below it. A facet between the columns of samples hangs on
    /// the family of one that it shares a vertex with, or of one that hangs so. Facets are in increasing order.
    ///
    /// # Cost
    /// O(facets + samples of their shadow).
    pub fn families(
        &self,
        (count, piece): (usize, impl Fn([usize; 3]) -> Option<u32>),
        mesh: &TriangleMesh,
        facets: &[u32],
    ) -> (Vec<u32>, Vec<Vec<u32>>) {
        let grid = *self.columns.grid();
        let mut families = DisjointSets::new(count);
        let mut hangs: Vec<(u32, u32)> = Vec::with_capacity(facets.len());
        // Vertices whose piece is known, in the order in which they were reached; facets that wait for one of theirs.
        let (mut reached, mut seen) = (Vec::new(), FxHashSet::default());
        let mut waiting: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        for &f in facets {
            let corners = mesh.triangles[f as usize];
            let mut of: Option<u32> = None;
            each_column_under(mesh.corners(f as usize), &grid, |at| {
                of = match (of, piece(at)) {
                    (Some(a), Some(b)) => Some(families.join(a, b)),
                    (a, b) => a.or(b),
                };
            });
            match of {
                Some(of) => {
                    hangs.push((of, f));
                    reached.extend(corners.into_iter().filter(|&v| seen.insert(v)).map(|v| (v, of)));
                }
                None => corners.into_iter().for_each(|v| waiting.entry(v).or_default().push(f)),
            }
        }
        let (mut next, mut taken) = (0, FxHashSet::default());
        while let Some(&(vertex, of)) = reached.get(next) {
            next += 1;
            for f in waiting.remove(&vertex).unwrap_or_default().into_iter().filter(|&f| taken.insert(f)) {
                hangs.push((of, f));
                let corners = mesh.triangles[f as usize];
                reached.extend(corners.into_iter().filter(|&v| seen.insert(v)).map(|v| (v, of)));
            }
        }
        let mut lists = vec![Vec::new(); count];
        hangs.into_iter().for_each(|(of, f)| lists[families.root(of) as usize].push(f));
        lists.iter_mut().for_each(|list| list.sort_unstable());
        ((0..count as u32).map(|piece| families.root(piece)).collect(), lists)
    }
}

/// The supports that a part needs below some of its facets, where a plate lies at `plate_z`.
///
/// `centres` are the samples inside the part; every facet is followed straight down from the highest sample below it until a
/// sample is inside or the plate is reached.
///
/// # Errors
/// None but [`crate::Error::Internal`] if the sets do not fit their grid.
///
/// # Cost
/// O(samples/64 + samples of the facets' shadow).
///
/// ```
/// use amcheck::{field::Indicator, geometry::TriangleMesh, grid::Grid, layer::supports, units::Length};
/// // A ceiling of 4 × 4 mm, 3 mm above the plate, over a part that is not sampled.
/// let p = [[0.0, 0.0, 3.0], [4.0, 0.0, 3.0], [4.0, 4.0, 3.0], [0.0, 4.0, 3.0]];
/// let ceiling = TriangleMesh::weld([[p[0], p[2], p[1]], [p[0], p[3], p[2]]]);
/// let grid = Grid::covering([0.0; 3], [4.0; 3], Length::mm(0.5), 1, [0.0; 3])?;
/// let made = supports(&Indicator::empty(grid), &ceiling, &[0, 1], 0.0)?;
/// assert!((made.volume().as_mm3() - 48.0).abs() < 10.0);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn supports(centres: &Indicator, mesh: &TriangleMesh, facets: &[u32], plate_z: f64) -> Result<Supports> {
    let grid = *centres.grid();
    let mut heads = Indicator::empty(grid);
    let above = first_above(&grid, plate_z);
    for &f in facets {
        each_column_under(mesh.corners(f as usize), &grid, |at| {
            if at[2] >= above && !centres.contains(at) {
                heads.set(at, true);
            }
        });
    }
    let (columns, feet_on_part, feet_on_plate) = scan_down(centres, &heads, above)?;
    Ok(Supports { columns, heads, feet_on_part, feet_on_plate })
}

/// The lowest layer of samples above the plate.
fn first_above(grid: &Grid, plate_z: f64) -> usize {
    let k = ((plate_z - grid.origin()[2]) / grid.h()).floor() + 1.0;
    (k.max(0.0) as usize).min(grid.dims()[2])
}

/// Columns from the heads down to the part or the layer `above`, with their feet on either.
fn scan_down(centres: &Indicator, heads: &Indicator, above: usize) -> Result<(Indicator, Indicator, Indicator)> {
    let grid = *centres.grid();
    let [_, ny, nz] = grid.dims();
    let plane = centres.words_per_row() * ny;
    let [mut columns, mut on_part, mut on_plate] = [0; 3].map(|_| vec![0u64; plane * nz]);
    let mut active = vec![0u64; plane];
    for k in (above..nz).rev() {
        let layer = k * plane..(k + 1) * plane;
        let (solid, starts) = (&centres.words()[layer.clone()], &heads.words()[layer.clone()]);
        let below = (k > above).then(|| &centres.words()[(k - 1) * plane..k * plane]);
        for w in 0..plane {
            active[w] = (active[w] | starts[w]) & !solid[w];
            columns[layer.start + w] = active[w];
            match below {
                Some(below) => on_part[layer.start + w] = active[w] & below[w],
                None => on_plate[layer.start + w] = active[w],
            }
        }
    }
    let set = |words| Indicator::from_words(grid, words);
    Ok((set(columns)?, set(on_part)?, set(on_plate)?))
}

/// A sample that lies no further below a facet, in spacings, may count as inside: corners are cast rounded to the next 2⁻¹⁶ of a spacing, which
/// moves a facet up by half of that, and by more where it slopes.
const TIE: f64 = 1.0 / 16384.0;

/// Calls back with the highest sample strictly below a facet, for every column of samples whose axis meets it.
fn each_column_under(corners: [Vec3; 3], grid: &Grid, mut found: impl FnMut([usize; 3])) {
    let [a, b, c] = corners.map(|p| grid.continuous_index(p));
    let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if twice == 0.0 || !twice.is_finite() {
        return;
    }
    let [nx, ny, nz] = grid.dims();
    let slope = |axis: usize| {
        let (u, v) = (b[2] - a[2], c[2] - a[2]);
        let other = 1 - axis;
        let sign = if axis == 0 { 1.0 } else { -1.0 };
        sign * (u * (c[other] - a[other]) - v * (b[other] - a[other])) / twice
    };
    let (zx, zy) = (slope(0), slope(1));
    let least = |axis: usize| a[axis].min(b[axis]).min(c[axis]);
    let most = |axis: usize| a[axis].max(b[axis]).max(c[axis]);
    let (first, last) = (least(1).ceil().max(0.0), most(1).floor().min(ny as f64 - 1.0));
    let mut j = first;
    while j <= last {
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            if (p[1] <= j) != (q[1] <= j) || p[1] == j || q[1] == j {
                let t = if p[1] == q[1] { 0.0 } else { ((j - p[1]) / (q[1] - p[1])).clamp(0.0, 1.0) };
                for x in if p[1] == q[1] { [p[0], q[0]] } else { [p[0] + t * (q[0] - p[0]); 2] } {
                    lo = lo.min(x);
                    hi = hi.max(x);
                }
            }
        }
        let mut i = lo.ceil().max(0.0);
        while i <= hi.floor().min(nx as f64 - 1.0) {
            let z = (a[2] + zx * (i - a[0]) + zy * (j - a[1])).clamp(least(2), most(2));
            let k = (z - TIE).ceil() - 1.0;
            if k >= 0.0 && k < nz as f64 {
                found([i as usize, j as usize, k as usize]);
            }
            i += 1.0;
        }
        j += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::geometry::occupancy;
    use crate::layer::downward_facets;
    use crate::topology::{Adjacency, components};
    use crate::units::{Angle, Length};

    /// What the definition says of one sample, straight from the facets: the first of the part above it.
    fn first_above_is_wanted(mesh: &TriangleMesh, wanted: &[u32], p: Vec3) -> bool {
        let hit =
            |f: usize| crate::geometry::ray::Ray::of(p, [0.0, 0.0, 1.0]).hit(mesh.corners(f)).filter(|t| *t > 0.0);
        let first = (0..mesh.triangles.len()).filter_map(|f| Some((hit(f)?, f))).min_by(|a, b| a.0.total_cmp(&b.0));
        first.is_some_and(|(_, f)| wanted.contains(&(f as u32)))
    }

    #[test]
    fn a_shelf_on_a_plane_of_samples_is_held_up_wherever_the_file_puts_it() {
        let shelf = cuboid([0.0; 3], [4.0, 20.0, 30.0]).joined(&cuboid([4.0, 0.0, 27.0], [16.0, 20.0, 30.0]));
        let mut random = crate::random::Lcg(5);
        for _ in 0..60 {
            let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            // Rounded to 32 bits, and put back.
            let by = random.point(0.0, 1.0);
            let written = shelf.transformed(still, by);
            let facets = written.triangles.iter().map(|t| t.map(|v| written.vertices[v as usize]));
            let written = TriangleMesh::weld(facets.map(|t| t.map(|p| p.map(|x| f64::from(x as f32)))));
            let mesh = written.transformed(still, written.bounds().unwrap().0.map(|x| -x));
            // The layer 70 at 27 mm, but for rounding.
            let origin = [-1.1, -1.1, -1.0 + 5e-6 * (random.unit() - 0.5)];
            let grid = Grid::new(origin, Length::mm(0.4), [46, 56, 80]).unwrap();
            let facets = downward_facets(&mesh, 0.0, Angle::degrees(45.0), 1e-6);
            let made = supports(&occupancy(&mesh, &grid).unwrap(), &mesh, &facets, 0.0).unwrap();
            // To a sample at either end and at three of the sides.
            let [least, most] = [11.6 * 19.6 * 26.4, 12.4 * 20.4 * 27.4];
            assert!((least..most).contains(&made.volume().as_mm3()), "{by:?}: {}", made.volume().as_mm3());
        }
    }

    #[test]
    fn the_scan_is_the_definition_sample_by_sample() {
        let turn = |m: &TriangleMesh, d: f64| {
            let (s, c) = f64::to_radians(d).sin_cos();
            m.transformed([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]], [0.0; 3])
        };
        let floor = cuboid([0.013, 0.017, 0.0], [9.01, 7.03, 1.007]);
        for (mesh, limit) in [
            (floor.clone().joined(&cuboid([2.01, 1.03, 5.007], [12.02, 5.04, 6.009])), 45.0),
            (floor.clone().joined(&turn(&cuboid([2.0, 1.0, 6.0], [8.0, 5.0, 7.0]), 30.0)), 45.0),
            (turn(&floor, 20.0), 45.0),
        ] {
            let (lo, hi) = mesh.bounds().unwrap();
            let mesh = mesh.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0, 0.0, -lo[2]]);
            let grid =
                Grid::covering([lo[0], lo[1], 0.0], [hi[0], hi[1], hi[2] - lo[2]], Length::mm(0.31), 1, [0.0; 3])
                    .unwrap();
            let centres = occupancy(&mesh, &grid).unwrap();
            let facets = downward_facets(&mesh, 0.0, Angle::degrees(limit), 1e-6);
            assert!(!facets.is_empty());
            let made = supports(&centres, &mesh, &facets, 0.0).unwrap();
            for at in 0..grid.samples() {
                let index = grid.index(at);
                let p = grid.position(index);
                let expected = p[2] > 0.0 && !centres.contains(index) && first_above_is_wanted(&mesh, &facets, p);
                assert_eq!(made.columns.contains(index), expected, "{p:?}");
            }
            // All that hangs over hangs on some family, and on that of every piece below it.
            let pieces = components(&made.columns, Adjacency::Face);
            let (family, lists) = made.families((pieces.count(), |at| pieces.of(at)), &mesh, &facets);
            let mut listed = lists.concat();
            listed.sort_unstable();
            assert_eq!(listed, facets);
            assert!(family.iter().all(|&of| !lists[of as usize].is_empty()));
            let mut below = 0;
            for (of, list) in (0..).zip(&lists) {
                for &f in list {
                    each_column_under(mesh.corners(f as usize), &grid, |at| {
                        assert!(pieces.of(at).is_none_or(|piece| family[piece as usize] == of));
                        below += (0..=at[2]).rev().take_while(|&k| made.columns.contains([at[0], at[1], k])).count();
                    });
                }
            }
            assert_eq!(below as u64, made.columns.count());
            assert!(made.heads.is_subset(&made.columns).unwrap());
            let feet = made.feet_on_part.union(&made.feet_on_plate).unwrap();
            assert_eq!(feet.count(), made.heads.count(), "each column has a head and a foot");
        }
    }

    #[test]
    fn a_table_needs_one_block_of_support_that_stands_on_the_plate() {
        let top = cuboid([0.0, 0.0, 5.0], [10.0, 10.0, 6.0]);
        let grid = Grid::covering([0.0; 3], [10.0, 10.0, 6.0], Length::mm(0.25), 1, [0.0; 3]).unwrap();
        let centres = occupancy(&top, &grid).unwrap();
        let made = supports(&centres, &top, &downward_facets(&top, 0.0, Angle::degrees(45.0), 1e-6), 0.0).unwrap();
        // The box is a whole number of samples, so counting is exact up to the half sample at each side.
        assert!((made.volume().as_mm3() - 500.0).abs() < 2.0 * 0.25 * (100.0 + 2.0 * 50.0 + 2.0 * 50.0));
        assert!(made.feet_on_part.is_empty());
        assert_eq!(made.feet_on_plate.count(), made.heads.count());
        assert_eq!(components(&made.columns, Adjacency::Face).count(), 1);
    }

    #[test]
    fn two_rooms_under_one_ceiling_are_a_family() {
        // A wall that ends a hair below the ceiling: no sample fits between, and the ceiling's facets lie over both rooms.
        let wall = cuboid([4.0, -1.0, 0.0], [5.5, 5.0, 4.99]);
        let mesh = wall.joined(&cuboid([0.0, 0.0, 5.0], [10.0, 4.0, 6.0]));
        let grid = Grid::covering([0.0; 3], [10.0, 4.0, 6.0], Length::mm(0.5), 1, [0.0; 3]).unwrap();
        let facets = downward_facets(&mesh, 0.0, Angle::degrees(45.0), 1e-6);
        let made = supports(&occupancy(&mesh, &grid).unwrap(), &mesh, &facets, 0.0).unwrap();
        let pieces = components(&made.columns, Adjacency::Face);
        assert_eq!(pieces.count(), 2);
        let (family, lists) = made.families((2, |at| pieces.of(at)), &mesh, &facets);
        assert_eq!((family, lists), (vec![0, 0], vec![facets, vec![]]));
    }
}
