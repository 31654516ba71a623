//! Local thickness on a grid, between certified bounds.

use super::feature::Side;
use crate::distance::{FAR, squared_depth, squared_distance};
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use crate::geometry::Solid;
use crate::grid::Grid;
use crate::units::Length;
use rayon::prelude::*;

/// Half the diagonal of a sample's cube, in units of the spacing: no point of a cube is further from its centre.
const HALF: f64 = 0.866_025_403_784_438_6;
/// What the reach of balls may differ by without being painted apart, in units of the spacing.
const SLACK: f64 = 0.5;

/// Local thickness at the samples of a solid or of the void: τ(x) = 2·sup { r : x ∈ B(y, r) ⊂ S }, in millimetres.
///
/// `low ≤ τ ≤ high` at every sample inside; NaN elsewhere and as the background.
#[derive(Debug, Clone, PartialEq)]
pub struct Thickness {
    pub low: Field<f32>,
    pub high: Field<f32>,
}

/// The diameter of the largest ball inside that covers a sample, between certified bounds, on the whole grid.
///
/// With e the distance of a sample centre y to the nearest cube that is not wholly inside, less half a diagonal ε = √3/2·h, the ball B(y, e) lies
/// inside: τ_lo(c) = 2·max { e(y) : |y − c| ≤ e(y) }. With d its distance to the nearest sample outside, no ball inside
/// about a point of y's cube is larger than d + ε: τ_hi(c) = 2·max { d(y) + ε : |y − c| ≤ d(y) + 2ε }. Both hold without any
/// assumption on the shape. On an upright wall τ_hi − τ_lo is between 2√3·h and
/// (2√3 + 2)·h, as its faces lie to the samples.
///
/// Thickness beyond `most` is cut off there. For the void `most` is needed, since open space is as wide as one likes; samples nearer
/// than that to the border of the grid have `high` = `most`, so widen the window by it ([`crate::geometry::Solid`] of `Part::window`).
///
/// # Errors
/// [`Error::Operand`] for the void without a finite `most`, and for one that is negative or no number; otherwise as [`squared_distance`].
///
/// # Cost
/// Two distance transforms, and for each ball of the medial set the rows it meets that are not painted yet; larger balls come first, so that a
/// sample is painted once. Twenty bytes a sample.
///
/// # Source
/// T. Hildebrand, P. Rüegsegger, *A new method for the model-independent assessment of thickness in three-dimensional
/// images*, 1997; the bounds are ours.
///
/// ```
/// use amcheck::{geometry::{InsideRule, Primitive, voxelize}, grid::Grid, medial::{Side, thickness::local_thickness}, units::Length};
/// let plate = Primitive::parse("box:8x8x2mm")?.mesh(Length::mm(0.1));
/// let grid = Grid::covering([-4.0, -4.0, -1.0], [4.0, 4.0, 1.0], Length::mm(0.2), 1, [0.0; 3])?;
/// let map = local_thickness(&voxelize(&plate, &grid, InsideRule::Crossings)?, Side::Material, None)?;
/// let middle = grid.offset(grid.sample_at([0.05; 3]).unwrap());
/// let (low, high) = (map.low.values()[middle], map.high.values()[middle]);
/// assert!(low <= 2.0 && 2.0 <= high && high - low < 0.7);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn local_thickness(solid: &Solid, side: Side, most: Option<Length>) -> Result<Thickness> {
    let grid = *solid.centres.grid();
    let refused = |problem: String| Error::Operand {
        operation: "thickness",
        problem,
        remedy: "give the widest gap of interest".into(),
    };
    if let Some(wrong) = most.filter(|l| l.as_mm().is_nan() || l.as_mm() < 0.0) {
        return Err(refused(format!("a thickness of at most {wrong}")));
    }
    // No limit at all is what an infinite one says.
    let most = most.map(|l| 0.5 * l.as_mm() / grid.h()).filter(|most| most.is_finite());
    let (set, sure, maybe) = match side {
        Side::Material => (solid.centres.clone(), squared_depth(&solid.inner)?, squared_depth(&solid.centres)?),
        Side::Void if most.is_none() => return Err(refused("open space has no thickness".into())),
        Side::Void => (solid.centres.complement(), squared_distance(&solid.outer)?, squared_distance(&solid.centres)?),
    };
    let cap = most.unwrap_or(f64::INFINITY);
    let radius = |d2: u32| if d2 == FAR { f64::INFINITY } else { f64::from(d2).sqrt() };
    let low = painted(&set, &sure, cap, |d2| Ball { worth: radius(d2) - HALF, reach: radius(d2) - HALF }, 0.0)?;
    let high =
        painted(&set, &maybe, cap, |d2| Ball { worth: radius(d2) + HALF, reach: radius(d2) + 2.0 * HALF }, SLACK)?;
    let scale = 2.0 * grid.h();
    let border = if side == Side::Void { cap + 2.0 * HALF } else { 0.0 };
    let finish = |values: Vec<f32>, outwards: f64, at_border: Option<f64>| {
        let mut values = values;
        values.par_iter_mut().enumerate().for_each(|(at, v)| {
            let i = grid.index(at);
            let near = (0..3).any(|a| (i[a].min(grid.dims()[a] - 1 - i[a]) as f64) < border);
            *v = match at_border.filter(|_| near) {
                _ if !set.contains(i) => f32::NAN,
                Some(cap) => (cap * scale * outwards) as f32,
                None => (f64::from(*v) * scale * outwards) as f32,
            };
        });
        Field::from_values(grid, values, f32::NAN)
    };
    // Rounding to f32 goes outwards.
    Ok(Thickness { low: finish(low, 1.0 - 1e-6, None)?, high: finish(high, 1.0 + 1e-6, most)? })
}

/// A ball about a sample, in units of the spacing: what it is worth to the samples it reaches.
#[derive(Clone, Copy)]
struct Ball {
    worth: f64,
    reach: f64,
}

/// max { worth(y) : |y − c| ≤ reach(y) } at every sample c of a set, worth cut off at `cap`; 0 where no ball reaches.
///
/// Balls may reach `slack` further than they should, and one that another of larger worth covers up to [`SLACK`] is left out: with
/// `slack` = [`SLACK`] the result is no less than the maximum, with 0 no more.
fn painted(
    set: &Indicator,
    squared: &Field<u32>,
    cap: f64,
    ball: impl Fn(u32) -> Ball + Sync,
    slack: f64,
) -> Result<Vec<f32>> {
    let grid = *set.grid();
    let d2 = squared.values();
    let capped = |d2: u32| {
        let b = ball(d2);
        // A ball larger than the cap holds one of that size about every point that far inside it.
        Ball { worth: b.worth.min(cap), reach: b.reach - (b.worth - cap).max(0.0) }
    };
    let deep_at = |at: usize| ball(d2[at]).worth >= cap && d2[at] > 0;
    let deep = cap.is_finite().then(|| Indicator::from_predicate(grid, deep_at)).filter(|d| !d.is_empty());
    // Where nothing bounds a ball, both its numbers are infinite: how far it reaches beyond its worth is read off a small one.
    let small = ball(1);
    let reach_of_deep = cap + (small.reach - small.worth) + slack;
    let around = deep.as_ref().map(squared_distance).transpose()?;
    let chosen =
        medial_balls(&grid, d2, &|d2| ball(d2).reach, &|at| d2[at] > 0 && !deep_at(at) && ball(d2[at]).worth > 0.0);
    let balls: Vec<([i32; 3], f64, f32)> = chosen
        .into_iter()
        .map(|at| {
            let b = capped(d2[at as usize]);
            (grid.index(at as usize).map(|i| i as i32), b.reach + slack, b.worth as f32)
        })
        .collect();
    let [nx, ny, _] = grid.dims();
    let mut values = vec![0.0f32; grid.samples()];
    values.par_chunks_mut(nx * ny).enumerate().for_each_init(
        || Canvas::new(nx, ny),
        |canvas, (k, plane)| {
            canvas.open(|j, i| {
                let at = (k * ny + j) * nx + i;
                let taken = around.as_ref().is_some_and(|a| f64::from(a.values()[at]) <= reach_of_deep * reach_of_deep);
                if taken {
                    plane[j * nx + i] = cap as f32;
                }
                !taken && set.contains([i, j, k])
            });
            for &([x, y, z], reach, worth) in &balls {
                let dz = f64::from(z - k as i32);
                let left = reach * reach - dz * dz;
                if left >= 0.0 {
                    canvas.paint([x, y], left, worth, plane);
                }
                if canvas.is_done() {
                    break;
                }
            }
        },
    );
    Ok(values)
}

/// The balls that are not covered, up to [`SLACK`], by a larger one on their way inwards; largest first.
fn medial_balls(
    grid: &Grid,
    d2: &[u32],
    reach: &(impl Fn(u32) -> f64 + Sync),
    counts: &(impl Fn(usize) -> bool + Sync),
) -> Vec<u32> {
    let [nx, ny, nz] = grid.dims();
    let mut order: Vec<u32> = (0..d2.len() as u32).into_par_iter().filter(|&at| counts(at as usize)).collect();
    order.par_sort_unstable_by_key(|&at| (std::cmp::Reverse(d2[at as usize]), at));
    // The way inwards: along the differences of the distance, to the next sample.
    let strides = [1, nx, nx * ny];
    let uphill = |at: usize| -> usize {
        let i = grid.index(at);
        let g = [0, 1, 2].map(|a| {
            let after = if i[a] + 1 < [nx, ny, nz][a] { d2[at + strides[a]] } else { 0 };
            let before = if i[a] > 0 { d2[at - strides[a]] } else { 0 };
            f64::from(after) - f64::from(before)
        });
        let most = g.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        (0..3).fold(at, |to, a| match g[a] {
            x if x > 0.4 * most && i[a] + 1 < [nx, ny, nz][a] => to + strides[a],
            x if x < -0.4 * most && i[a] > 0 => to - strides[a],
            _ => to,
        })
    };
    let inwards: Vec<u32> = order.par_iter().map(|&at| uphill(at as usize) as u32).collect();
    const UNKNOWN: u32 = u32::MAX;
    let mut owner = vec![UNKNOWN; d2.len()];
    let mut chosen = Vec::new();
    for (&at, &to) in order.iter().zip(&inwards) {
        let by = owner[to as usize];
        let covered = by != UNKNOWN && {
            let (p, q) = (grid.index(at as usize), grid.index(by as usize));
            let apart2: f64 = (0..3).map(|a| (p[a] as f64 - q[a] as f64).powi(2)).sum();
            let room = reach(d2[by as usize]) + SLACK - reach(d2[at as usize]);
            room >= 0.0 && apart2 <= room * room
        };
        owner[at as usize] = if covered { by } else { at };
        if !covered {
            chosen.push(at);
        }
    }
    chosen
}

/// One layer in the making: for every row, the samples still to be painted.
struct Canvas {
    nx: usize,
    /// In each row, the next sample at or after this one that is open; `nx` for none.
    next: Vec<u32>,
    /// Open samples of each row.
    left: Vec<u32>,
    /// The next row at or after this one with open samples.
    rows: Vec<u32>,
}

impl Canvas {
    fn new(nx: usize, ny: usize) -> Self {
        Canvas { nx, next: vec![0; (nx + 1) * ny], left: vec![0; ny], rows: vec![0; ny + 1] }
    }

    /// Starts a layer; `open` says by row and place which samples are to be painted.
    fn open(&mut self, mut open: impl FnMut(usize, usize) -> bool) {
        let ny = self.left.len();
        for j in 0..ny {
            let row = &mut self.next[j * (self.nx + 1)..(j + 1) * (self.nx + 1)];
            let mut count = 0;
            for (i, next) in row.iter_mut().enumerate().take(self.nx) {
                let is_open = open(j, i);
                *next = i as u32 + u32::from(!is_open);
                count += u32::from(is_open);
            }
            row[self.nx] = self.nx as u32;
            self.left[j] = count;
            self.rows[j] = j as u32 + u32::from(count == 0);
        }
        self.rows[ny] = ny as u32;
    }

    fn is_done(&mut self) -> bool {
        find(&mut self.rows, 0) as usize == self.left.len()
    }

    /// Paints the open samples of the disk of squared radius `left` about (x, y).
    fn paint(&mut self, [x, y]: [i32; 2], left: f64, worth: f32, plane: &mut [f32]) {
        let ny = self.left.len() as i32;
        let r = left.sqrt() as i32;
        let last = (y + r).min(ny - 1);
        let mut j = find(&mut self.rows, (y - r).max(0) as usize) as i32;
        while j <= last {
            let dy = f64::from(j - y);
            let half = (left - dy * dy).max(0.0).sqrt() as i32;
            let row = &mut self.next[j as usize * (self.nx + 1)..(j as usize + 1) * (self.nx + 1)];
            let end = (x + half).min(self.nx as i32 - 1);
            let mut i = find(row, (x - half).max(0) as usize) as i32;
            while i <= end {
                plane[j as usize * self.nx + i as usize] = worth;
                row[i as usize] = i as u32 + 1;
                self.left[j as usize] -= 1;
                i = find(row, i as usize + 1) as i32;
            }
            if self.left[j as usize] == 0 {
                self.rows[j as usize] = j as u32 + 1;
            }
            j = find(&mut self.rows, j as usize + 1) as i32;
        }
    }
}

/// The root of a place, halving the way to it.
#[inline]
fn find(next: &mut [u32], mut at: usize) -> u32 {
    while next[at] as usize != at {
        next[at] = next[next[at] as usize];
        at = next[at] as usize;
    }
    at as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{InsideRule, Primitive, TriangleMesh, voxelize};

    fn cast(mesh: &TriangleMesh, h: f64, margin: usize) -> Solid {
        let (lo, hi) = mesh.bounds().expect("a box");
        let grid = Grid::covering(lo, hi, Length::mm(h), margin, [0.1, 0.2, 0.3]).expect("a grid");
        voxelize(mesh, &grid, InsideRule::Crossings).expect("a solid")
    }

    /// Every ball tried on every sample.
    fn plainly(set: &Indicator, squared: &Field<u32>, ball: impl Fn(u32) -> Ball) -> Vec<f64> {
        let grid = set.grid();
        let balls: Vec<_> = (0..grid.samples())
            .filter(|&y| squared.values()[y] > 0)
            .map(|y| (grid.index(y), ball(squared.values()[y])))
            .collect();
        (0..grid.samples())
            .map(|c| {
                let p = grid.index(c);
                let near = |q: &[usize; 3], b: &Ball| {
                    (0..3).map(|a| (p[a] as f64 - q[a] as f64).powi(2)).sum::<f64>().sqrt() <= b.reach
                };
                balls.iter().filter(|(q, b)| near(q, b)).map(|(_, b)| b.worth).fold(0.0, f64::max)
            })
            .collect()
    }

    #[test]
    fn about_a_convex_part_all_space_is_open() {
        let mesh = Primitive::parse("box:3x2x1mm").expect("a box").mesh(Length::mm(0.1));
        let (s, c) = 0.3f64.sin_cos();
        let solid = cast(&mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]), 0.1, 18);
        let most = 1.0;
        let t = local_thickness(&solid, Side::Void, Some(Length::mm(most))).expect("a map");
        let shell = squared_distance(&solid.outer).expect("distances");
        for at in solid.centres.complement().iter() {
            let (low, high) = (f64::from(t.low.values()[at]), f64::from(t.high.values()[at]));
            assert!(low <= most && most <= high, "{at}: {low} to {high}");
            // A ball of the cap fits beside every face, but for half a diagonal on its near side.
            let clear = f64::from(shell.values()[at]).sqrt() > 2.5;
            assert!(!clear || low > 0.999 * most, "{at}: {low}");
        }
    }

    #[test]
    fn painting_lies_between_the_plain_maximum_and_that_of_balls_a_little_larger() {
        let parts = ["box:4x3x1.2mm", "ball:1.1mm", "cone:r1.5r0.5h3mm"];
        for (n, part) in parts.into_iter().enumerate() {
            let (s, c) = (0.4 + n as f64).sin_cos();
            let mesh = Primitive::parse(part).expect("a shape").mesh(Length::mm(0.05));
            let solid = cast(&mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]), 0.2, 1);
            let depth = squared_depth(&solid.centres).expect("a depth");
            let at =
                |extra: f64| move |d2: u32| Ball { worth: f64::from(d2).sqrt(), reach: f64::from(d2).sqrt() + extra };
            let (least, most) = (plainly(&solid.centres, &depth, at(0.0)), plainly(&solid.centres, &depth, at(SLACK)));
            let low = painted(&solid.centres, &depth, f64::INFINITY, at(0.0), 0.0).expect("low");
            let high = painted(&solid.centres, &depth, f64::INFINITY, at(0.0), SLACK).expect("high");
            for c in solid.centres.iter() {
                let (low, high) = (f64::from(low[c]), f64::from(high[c]));
                assert!(
                    low <= least[c] + 1e-5 && least[c] <= high + 1e-5 && high <= most[c] + 1e-5,
                    "{part} {c}: {low} {} {high}",
                    least[c]
                );
            }
            // Little is given away by leaving balls out.
            let lost: f64 =
                solid.centres.iter().map(|c| least[c] - f64::from(low[c])).sum::<f64>() / solid.centres.count() as f64;
            assert!(lost < 0.25, "{part}: {lost}");
        }
    }

    #[test]
    fn a_plate_a_ball_and_a_slit_have_their_thickness_between_the_bounds() {
        let plate = cast(&Primitive::parse("box:6x6x1mm").expect("a shape").mesh(Length::mm(0.1)), 0.1, 1);
        let map = local_thickness(&plate, Side::Material, None).expect("a map");
        let mut narrowest = f32::INFINITY;
        for c in plate.centres.iter() {
            let (low, high) = (map.low.values()[c], map.high.values()[c]);
            let p = plate.centres.grid().position(plate.centres.grid().index(c));
            // Away from the rim every ball of diameter 1 fits.
            if p[0].abs() < 2.4 && p[1].abs() < 2.4 {
                assert!(low <= 1.0 && 1.0 <= high, "{p:?} {low} {high}");
                narrowest = narrowest.min(high - low);
            }
            assert!(high <= 1.36, "{high}");
        }
        assert!(narrowest < 0.36, "{narrowest}");
        let ball = cast(&Primitive::parse("ball:1mm").expect("a shape").mesh(Length::mm(1e-4)), 0.1, 1);
        let map = local_thickness(&ball, Side::Material, None).expect("a map");
        assert!(ball.centres.iter().all(|c| map.low.values()[c] <= 2.0 && map.high.values()[c] >= 1.999));
    }

    #[test]
    fn a_slit_is_measured_in_the_void_up_to_what_is_asked() {
        let a = Primitive::parse("box:6x6x2mm").expect("a shape").mesh(Length::mm(0.1));
        let same = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let two = a.clone().joined(&a.transformed(same, [0.0, 0.0, 2.6]));
        let solid = cast(&two, 0.1, 14);
        assert!(local_thickness(&solid, Side::Void, None).is_err());
        for wrong in [-1.0, f64::NAN, f64::NEG_INFINITY] {
            for side in [Side::Void, Side::Material] {
                let refused = local_thickness(&solid, side, Some(Length::mm(wrong)));
                assert!(matches!(refused, Err(Error::Operand { .. })), "{wrong}");
            }
        }
        let endless = Some(Length::mm(f64::INFINITY));
        assert!(local_thickness(&solid, Side::Void, endless).is_err());
        let material = |most| local_thickness(&solid, Side::Material, most).expect("a map").high.values().to_vec();
        let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(material(endless)), bits(material(None)));
        let map = local_thickness(&solid, Side::Void, Some(Length::mm(1.2))).expect("a map");
        let grid = solid.centres.grid();
        let at = |p: [f64; 3]| grid.offset(grid.sample_at(p).expect("on the grid"));
        let within = at([0.1, 0.1, 1.3]);
        assert!(map.low.values()[within] <= 0.6 && map.high.values()[within] >= 0.6 && map.high.values()[within] < 1.0);
        let open = at([0.0, 0.0, -2.0]);
        assert!(map.low.values()[open] <= 1.2 && map.high.values()[open] >= 1.2 && map.low.values()[open] > 1.0);
    }
}
