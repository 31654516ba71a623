//! What two facets have in common, exactly.

use super::exact::{Exact, Lattice, Plane, area_of, turn};
use crate::geometry::vector::{cross, unit};
use num::bigint::BigInt;
use num::{Signed, Zero};
use std::cmp::Ordering;

/// What floats are sure of, in steps of the lattice: its coordinates are below 2³⁹, where floats are 2⁻¹⁴ apart.
const SURE: f64 = 0.01;

/// A facet on the lattice that has an area.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    /// Its corners, by number.
    pub(super) vertices: [u32; 3],
    pub(super) corners: [Lattice; 3],
    pub(super) plane: Plane,
}

impl Facet {
    /// Where its boundary passes through a plane that its corners have such heights over.
    fn crossed(&self, heights: [i128; 3]) -> Vec<Exact> {
        let corner = |i: usize| Exact::on_lattice(self.corners[i]);
        let mut ends: Vec<Exact> = (0..3).filter(|&i| heights[i] == 0).map(corner).collect();
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if heights[i].signum() * heights[j].signum() < 0 {
                ends.push(Exact::between([&corner(i), &corner(j)], [heights[i], heights[j]].map(BigInt::from)));
            }
        }
        ends
    }

    /// About from where to where along an axis it lies in a plane that its corners have such heights over, to [`SURE`].
    fn about(&self, heights: [i128; 3], axis: usize) -> [f64; 2] {
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let ([p, q], [a, b]) = ([i, j].map(|k| self.corners[k][axis] as f64), [i, j].map(|k| heights[k] as f64));
            let met = if heights[i] == 0 {
                p
            } else if heights[i].signum() * heights[j].signum() < 0 {
                p + (q - p) * (a / (a - b))
            } else {
                continue;
            };
            (from, to) = (from.min(met), to.max(met));
        }
        [from, to]
    }

    /// How many corners two facets share.
    fn shared(&self, other: &Facet) -> usize {
        self.vertices.iter().filter(|v| other.vertices.contains(v)).count()
    }
}

/// The segments that two facets have in common, points being segments from and to themselves; of facets in one plane those along the
/// edges of either.
///
/// # Cost
/// Six heights in integers, and for planes that are crossed the quotients of the ends.
pub(super) fn contact(f: &Facet, g: &Facet) -> Vec<[Exact; 2]> {
    let over_g = f.corners.map(|p| g.plane.height(p));
    let apart = |h: [i128; 3]| h.iter().all(|x| *x > 0) || h.iter().all(|x| *x < 0);
    if apart(over_g) {
        return Vec::new();
    }
    let shared = f.shared(g);
    if over_g == [0; 3] {
        // Neighbours on both sides of their edge have no more than that in common.
        return if shared == 3 || shared == 2 && !is_folded(f, g) { Vec::new() } else { in_plane(f, g) };
    }
    if shared > 1 || shared == 1 && is_on_one_side(over_g) {
        return Vec::new();
    }
    let over_f = g.corners.map(|p| f.plane.height(p));
    if apart(over_f) || shared == 1 && is_on_one_side(over_f) {
        return Vec::new();
    }
    if is_clear([f, g], [over_g, over_f]) {
        return Vec::new();
    }
    along_line([f, g], [over_g, over_f]).into_iter().collect()
}

/// Whether one corner lies in a plane, and the others on one side of it.
fn is_on_one_side(heights: [i128; 3]) -> bool {
    let on = heights.iter().filter(|h| **h == 0).count();
    on == 1 && (heights.iter().all(|h| *h >= 0) || heights.iter().all(|h| *h <= 0))
}

/// Whether floats are sure that along the line in which their planes meet two facets have nothing in common but, if they share one, a
/// corner.
fn is_clear([f, g]: [&Facet; 2], heights: [[i128; 3]; 2]) -> bool {
    let [m, n] = [f, g].map(|of| unit(of.plane.normal.map(|x| x as f64)));
    let line = cross(m, n);
    let axis = (1..3).fold(0, |most, a| if line[a].abs() > line[most].abs() { a } else { most });
    if line[axis].abs() < 1e-6 {
        return false;
    }
    let ([from, to], [start, end]) = (f.about(heights[0], axis), g.about(heights[1], axis));
    let gap = (start - to).max(from - end);
    // The end that is the corner is told exactly.
    if f.shared(g) > 0 { gap > -SURE && (to - from).min(end - start) > 4.0 * SURE } else { gap > SURE }
}

/// What two facets have in common along the line in which their planes meet, by the heights of their corners over those.
fn along_line([f, g]: [&Facet; 2], heights: [[i128; 3]; 2]) -> Option<[Exact; 2]> {
    let axis = steepest(f.plane.normal, g.plane.normal);
    let ends = |of: &Facet, heights| {
        let mut ends = of.crossed(heights);
        ends.sort_by(|p, q| p.compare(q, axis));
        Some([ends.first()?.clone(), ends.last()?.clone()])
    };
    let ([from, to], [start, end]) = (ends(f, heights[0])?, ends(g, heights[1])?);
    let from = if from.compare(&start, axis).is_lt() { start } else { from };
    let to = if to.compare(&end, axis).is_gt() { end } else { to };
    from.compare(&to, axis).is_le().then_some([from, to])
}

/// The axis along which the line moves most that two planes meet in.
fn steepest(m: [i128; 3], n: [i128; 3]) -> usize {
    let [m, n] = [m, n].map(|normal| normal.map(BigInt::from));
    let along = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        (&m[j] * &n[k] - &m[k] * &n[j]).abs()
    };
    (0..3).max_by_key(|&i| along(i)).unwrap_or(0)
}

/// Whether two facets in one plane with a common edge lie on the same side of it.
fn is_folded(f: &Facet, g: &Facet) -> bool {
    let (_, axes) = f.plane.axes();
    let tip = |of: &Facet, other: &Facet| (0..3).find(|&i| !other.vertices.contains(&of.vertices[i]));
    let (Some(i), Some(j)) = (tip(f, g), tip(g, f)) else { return false };
    let [a, b] = [f.corners[(i + 1) % 3], f.corners[(i + 2) % 3]].map(Exact::on_lattice);
    let side = |p: Lattice| turn(axes, [&a, &b, &Exact::on_lattice(p)]);
    side(f.corners[i]) == side(g.corners[j])
}

/// What the edges of each of two facets in one plane have in the other.
fn in_plane(f: &Facet, g: &Facet) -> Vec<[Exact; 2]> {
    let (_, axes) = f.plane.axes();
    let [of_f, of_g] = [f, g].map(|of| of.corners.map(Exact::on_lattice));
    let edges_within = |of: &[Exact; 3], triangle: &[Exact; 3]| {
        let ends = [[0, 1], [1, 2], [2, 0]].map(|edge| edge.map(|i: usize| of[i].clone()));
        ends.into_iter().filter_map(|[p, q]| within(axes, triangle.each_ref(), [&p, &q])).collect::<Vec<_>>()
    };
    [edges_within(&of_f, &of_g), edges_within(&of_g, &of_f)].concat()
}

/// What a segment has in a triangle of the same plane, its border included.
fn within(axes: [usize; 2], triangle: [&Exact; 3], [p, q]: [&Exact; 2]) -> Option<[Exact; 2]> {
    let left = turn(axes, triangle);
    let edges = [[0, 1], [1, 2], [2, 0]].map(|[i, j]| [triangle[i], triangle[j]]);
    let holds = |x: &Exact| edges.iter().all(|[r, s]| matches!(turn(axes, [r, s, x]), o if o == left || o.is_eq()));
    let mut met: Vec<Exact> = [p, q].into_iter().filter(|x| holds(x)).cloned().collect();
    let axis = if p.compare(q, axes[0]).is_ne() { axes[0] } else { axes[1] };
    for [r, s] in edges {
        let along = |x: &Exact| p.compare(x, axis) != q.compare(x, axis);
        if turn(axes, [p, q, r]).is_eq() && along(r) {
            met.push(r.clone());
        }
        met.extend(crossing(axes, [p, q], [r, s]));
    }
    met.sort_by(|x, y| x.compare(y, axis));
    Some([met.first()?.clone(), met.last()?.clone()])
}

/// The point in which two segments of one plane cross each other, within both.
pub(super) fn crossing(axes: [usize; 2], [a, b]: [&Exact; 2], [c, d]: [&Exact; 2]) -> Option<Exact> {
    let opposite = |x: Ordering, y: Ordering| x.is_ne() && x == y.reverse();
    let crosses = opposite(turn(axes, [a, b, c]), turn(axes, [a, b, d]))
        && opposite(turn(axes, [c, d, a]), turn(axes, [c, d, b]));
    crosses.then(|| Exact::between([c, d], [area_of(axes, [a, b, c]), area_of(axes, [a, b, d])]))
}

/// Whether a normal is that of no plane.
pub(super) fn is_flat(plane: &Plane) -> bool {
    plane.normal.iter().all(Zero::is_zero)
}
