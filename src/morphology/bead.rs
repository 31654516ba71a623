//! What a bead leaves along strokes: δ on the path, convolved with the bead.

use super::element::{Sides, lattice_box};
use crate::error::{Error, Place, Result};
use crate::field::Indicator;
use crate::geometry::Primitive;
use crate::geometry::vector::{Vec3, bounds, distance, dot, norm2, sub};
use crate::units::Length;
use rayon::prelude::*;

/// The set that a bead B deposits along strokes P: the support of `δ_P ∗ 1_B`, `∪ { p + B : p ∈ P }`.
///
/// `points` are the samples in it, decided one by one; the cubes of `full` lie in it each under one copy of B, so their
/// union is a lower bound of the volume that misses what two beads share within one cube; `touched` covers it but for what has no volume. The
/// lattice is `h·(Z³ + phase)`. Both hold for every path that runs no farther `beside` the strokes at the same height. All hold up to a millionth of the spacing,
/// which is less than the digits of a path tell.
///
/// # Errors
/// [`Error::Operand`] without a stroke of two points or for one that is not finite; [`Error::Unsupported`] for a cone.
///
/// # Cost
/// Three tests for each sample near each bead-long piece of a stroke; planes in parallel, nothing allocated in them.
///
/// ```
/// use amcheck::{geometry::Primitive, morphology::deposit, units::Length};
/// let strokes = [vec![[0.0, 0.0, 0.0], [10.0, 0.0, 0.0]]];
/// let bead = Primitive::parse("box:0.4x0.4x0.2mm")?;
/// let made = deposit(&strokes, &bead, Length::mm(0.05), ([0.5; 3], Length::default()))?;
/// // 10.4 mm × 0.4 mm × 0.2 mm.
/// assert!((made.points.volume().as_mm3() / 0.832 - 1.0).abs() < 0.02);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn deposit(
    strokes: &[Vec<Vec3>],
    bead: &Primitive,
    spacing: Length,
    (phase, beside): ([f64; 3], Length),
) -> Result<Sides> {
    bead.validate()?;
    check(strokes)?;
    let h = spacing.as_mm();
    // A cube that only touches has no volume in common: the hair goes inwards there.
    let grown = |by: f64, hair: f64| Grown::of(bead, 0.5 * h * by, (1e-6 * h * hair, by * beside.as_mm()));
    let (full, point, touch) = (grown(-1.0, 1.0)?, grown(0.0, 1.0)?, grown(1.0, -1.0)?);
    let half = bead.half_extent();
    let all = || strokes.iter().flatten().copied();
    let (lo, hi) = bounds(all()).unwrap_or_default();
    let axes = [0, 1, 2];
    let grid = lattice_box(axes.map(|a| lo[a] - half[a]), axes.map(|a| hi[a] + half[a]), spacing, phase)?;
    let pieces = pieces(strokes, (2.0 * half.into_iter().fold(0.0, f64::max)).max(4.0 * h));
    let [nx, ny, nz] = grid.dims();
    let reach = half.map(|x| x + h);
    // The planes that each piece can reach, so that each plane walks its own pieces only.
    let mut of_plane: Vec<Vec<u32>> = vec![Vec::new(); nz];
    let range = |piece: &[Vec3; 2], axis: usize, n: usize| {
        let (a, b) = (piece[0][axis].min(piece[1][axis]), piece[0][axis].max(piece[1][axis]));
        let first = ((a - reach[axis] - grid.origin()[axis]) / h).ceil().max(0.0) as usize;
        let last = ((b + reach[axis] - grid.origin()[axis]) / h).floor().max(0.0) as usize;
        first..(last + 1).min(n)
    };
    for (number, piece) in pieces.iter().enumerate() {
        of_plane.get_mut(range(piece, 2, nz)).into_iter().flatten().for_each(|list| list.push(number as u32));
    }
    let [mut inner, mut points, mut outer] = [0; 3].map(|_| Indicator::empty(grid));
    let words = points.words_per_row();
    let planes = (inner.words_mut().par_chunks_mut(words * ny))
        .zip(points.words_mut().par_chunks_mut(words * ny))
        .zip(outer.words_mut().par_chunks_mut(words * ny))
        .zip(&of_plane);
    planes.enumerate().for_each(|(k, (((inner, points), outer), list))| {
        for piece in list.iter().filter_map(|&n| pieces.get(n as usize)) {
            for j in range(piece, 1, ny) {
                for i in range(piece, 0, nx) {
                    let (at, bit) = (j * words + i / 64, 1u64 << (i % 64));
                    if inner[at] & bit != 0 {
                        continue;
                    }
                    let x = grid.position([i, j, k]);
                    let [a, b] = [sub(piece[0], x), sub(piece[1], x)];
                    if !touch.met(a, b) {
                        continue;
                    }
                    outer[at] |= bit;
                    if point.met(a, b) {
                        points[at] |= bit;
                        inner[at] |= if full.met(a, b) { bit } else { 0 };
                    }
                }
            }
        }
    });
    Ok(Sides { full: inner, points, touched: outer })
}

/// A bead grown or shrunk by a cube, symmetric about its centre; `None` inside where nothing is left of it.
pub(super) enum Grown {
    Ball { radius2: f64 },
    Box { half: Vec3 },
    Cylinder { radius2: f64, half: f64 },
    Nothing,
}

impl Grown {
    /// The bead whose meeting with a segment tells about cubes of half side |by|: grown by them it holds B ⊕ cube,
    /// shrunk it lies in B ⊖ cube; `hair` is added to all, and `beside` to what is level.
    pub(super) fn of(bead: &Primitive, by: f64, (hair, beside): (f64, f64)) -> Result<Self> {
        let across = by * std::f64::consts::SQRT_2 + hair + beside;
        Ok(match *bead {
            Primitive::Ball { radius } => match radius.as_mm() + by * 3f64.sqrt() + hair + beside {
                r if r > 0.0 => Grown::Ball { radius2: r * r },
                _ => Grown::Nothing,
            },
            Primitive::Box { edges } => {
                let [x, y, z] = edges.map(|e| 0.5 * e.as_mm() + by + hair);
                let half = [x + beside, y + beside, z];
                if half.iter().all(|&x| x > 0.0) { Grown::Box { half } } else { Grown::Nothing }
            }
            Primitive::Cylinder { radius, height } => {
                let (r, half) = (radius.as_mm() + across, 0.5 * height.as_mm() + by + hair);
                if r > 0.0 && half > 0.0 { Grown::Cylinder { radius2: r * r, half } } else { Grown::Nothing }
            }
            Primitive::Cone { .. } => {
                return Err(Error::Unsupported {
                    what: "a cone as a bead".into(),
                    place: Place::Whole,
                    remedy: "take a ball, a box or a cylinder".into(),
                });
            }
        })
    }

    /// Whether the segment from a to b meets the shape.
    #[inline]
    pub(super) fn met(&self, a: Vec3, b: Vec3) -> bool {
        match *self {
            Grown::Ball { radius2 } => {
                let d = sub(b, a);
                let length2 = norm2(d);
                let t = if length2 > 0.0 { (-dot(a, d) / length2).clamp(0.0, 1.0) } else { 0.0 };
                norm2([0, 1, 2].map(|i| a[i] + t * d[i])) <= radius2
            }
            Grown::Box { half } => {
                let mut span = [0.0, 1.0];
                (0..3).all(|axis| clip(&mut span, a[axis], b[axis], half[axis]))
            }
            Grown::Cylinder { radius2, half } => {
                let mut span = [0.0, 1.0];
                if !clip(&mut span, a[2], b[2], half) {
                    return false;
                }
                let d = [b[0] - a[0], b[1] - a[1]];
                let length2 = d[0] * d[0] + d[1] * d[1];
                let nearest = if length2 > 0.0 { -(a[0] * d[0] + a[1] * d[1]) / length2 } else { 0.0 };
                let t = nearest.clamp(span[0], span[1]);
                (a[0] + t * d[0]).powi(2) + (a[1] + t * d[1]).powi(2) <= radius2
            }
            Grown::Nothing => false,
        }
    }
}

/// Narrows the span of parameters to where a coordinate that runs from a to b lies within ±half; false where nowhere.
fn clip(span: &mut [f64; 2], a: f64, b: f64, half: f64) -> bool {
    let step = b - a;
    if step == 0.0 {
        return a.abs() <= half;
    }
    let (p, q) = ((-half - a) / step, (half - a) / step);
    *span = [span[0].max(p.min(q)), span[1].min(p.max(q))];
    span[0] <= span[1]
}

/// The segments of all strokes, cut into pieces no longer than `longest`: their boxes stay small.
pub(super) fn pieces(strokes: &[Vec<Vec3>], longest: f64) -> Vec<[Vec3; 2]> {
    let segments = strokes.iter().flat_map(|stroke| stroke.windows(2).map(|w| [w[0], w[1]]));
    let cut = |[a, b]: [Vec3; 2]| {
        let n = (distance(a, b) / longest).ceil().clamp(1.0, 1e6) as usize;
        let at = move |m: usize| [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * m as f64 / n as f64);
        (0..n).map(move |m| [at(m), if m + 1 == n { b } else { at(m + 1) }])
    };
    segments.flat_map(cut).collect()
}

fn check(strokes: &[Vec<Vec3>]) -> Result<()> {
    let problem = if strokes.iter().all(|s| s.len() < 2) {
        "a path without a stroke of two points"
    } else if strokes.iter().flatten().flatten().any(|x| !x.is_finite()) {
        "a coordinate of the path is not finite"
    } else {
        return Ok(());
    };
    Err(Error::Operand {
        operation: "deposit",
        problem: problem.into(),
        remedy: "give strokes of at least two points, millimetres".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: Length = Length::mm(0.1);
    /// No arc beside its chords.
    const EXACT: Length = Length::mm(0.0);

    fn bead(text: &str) -> Primitive {
        Primitive::parse(text).unwrap()
    }

    /// One sloping and one level piece, and a stroke by itself.
    fn strokes() -> Vec<Vec<Vec3>> {
        vec![vec![[0.0; 3], [3.0, 1.0, 0.4], [3.0, 3.0, 0.4]], vec![[-1.0, 2.0, 0.0], [0.5, 2.5, 0.0]]]
    }

    /// Distance from x to p + B, over points p so dense that none is further than a hundredth of a spacing from one.
    fn plainly(strokes: &[Vec<Vec3>], bead: &Primitive, x: Vec3) -> f64 {
        let step = 0.01 * H.as_mm();
        pieces(strokes, step).iter().flatten().map(|p| bead.signed_distance(sub(x, *p))).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn samples_and_cubes_are_those_of_the_union_of_copies() {
        for text in ["ball:0.35mm", "box:0.6x0.4x0.5mm", "cylinder:r0.3h0.4mm"] {
            let bead = bead(text);
            let made = deposit(&strokes(), &bead, H, ([0.25, 0.6, 0.0], EXACT)).unwrap();
            assert!(made.full.is_subset(&made.points).unwrap() && made.points.is_subset(&made.touched).unwrap());
            assert!(made.full.count() > 0);
            let grid = *made.points.grid();
            let (near, half_diagonal) = (0.011 * H.as_mm(), 0.5 * 3f64.sqrt() * H.as_mm());
            for at in (0..grid.samples()).step_by(7) {
                let index = grid.index(at);
                let d = plainly(&strokes(), &bead, grid.position(index));
                assert!(!made.points.contains(index) || d <= near, "{text} {index:?}: {d}");
                assert!(made.points.contains(index) || d >= -1e-9, "{text} {index:?}: {d}");
                assert!(made.touched.contains(index) || d >= 0.5 * H.as_mm() - near, "{text} {index:?}: {d}");
                assert!(made.full.contains(index) || d >= -half_diagonal - 0.3 * H.as_mm(), "{text} {index:?}: {d}");
                assert!(!made.full.contains(index) || d <= -0.5 * H.as_mm() + near, "{text} {index:?}: {d}");
            }
        }
    }

    #[test]
    fn layers_that_stand_on_each_other_leave_no_doubt_between_them() {
        // Three layers of 0.2 mm; bottoms on cube faces.
        let layer = |n: i32| vec![[0.0, 0.0, 0.2 * f64::from(n) + 0.1], [5.0, 0.0, 0.2 * f64::from(n) + 0.1]];
        let strokes: Vec<_> = (0..3).map(layer).collect();
        let made = deposit(&strokes, &bead("box:0.4x0.4x0.2mm"), Length::mm(0.05), ([0.5; 3], EXACT)).unwrap();
        let truth = 5.4 * 0.4 * 0.6;
        for set in [&made.full, &made.points] {
            assert!((set.volume().as_mm3() - truth).abs() < 1e-9, "{:?}", set.volume());
        }
    }

    #[test]
    fn what_is_no_path_and_what_is_no_bead_is_refused() {
        let ball = bead("ball:0.3mm");
        for strokes in [vec![], vec![vec![[0.0; 3]]], vec![vec![[0.0; 3], [f64::NAN; 3]]]] {
            assert!(matches!(deposit(&strokes, &ball, H, ([0.0; 3], EXACT)), Err(Error::Operand { .. })));
        }
        assert!(matches!(
            deposit(&strokes(), &bead("cone:r1r0h1mm"), H, ([0.0; 3], EXACT)),
            Err(Error::Unsupported { .. })
        ));
        assert!(deposit(&strokes(), &Primitive::Ball { radius: Length::mm(f64::NAN) }, H, ([0.0; 3], EXACT)).is_err());
    }
}
