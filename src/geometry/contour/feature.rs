//! Creases and corners of a surface: where they are, and edges along them.

use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, add, cross, distance, dot, scale, sub};
use rustc_hash::{FxHashMap, FxHashSet};

/// Normals of a polygon that differ by more than 30° tell of a feature.
pub const SMOOTH_COSINE: f64 = 0.866;

/// Directions in which the tangent planes say less than this share of what they say in the clearest one are left alone.
const UNCLEAR: f64 = 0.03;

/// How far outside its cell, in cells, a feature may be found: a crease can pass between samples that are all outside.
const BEYOND: f64 = 0.6;

/// A plane: a point of it, and its unit normal.
pub(super) type Plane = (Vec3, Vec3);

/// The cell of a grid that starts at a point.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    pub(super) first: Vec3,
    pub(super) h: f64,
}

impl Cell {
    /// The place of a point in the cell, 0 to 1 within.
    fn place(&self, x: Vec3) -> Vec3 {
        scale(sub(x, self.first), 1.0 / self.h)
    }

    /// Whether a feature at a point may be one of the cell.
    fn may_hold(&self, x: Vec3) -> bool {
        self.place(x).iter().all(|t| (-BEYOND..=1.0 + BEYOND).contains(t))
    }
}

/// The point nearest to the tangent planes at the corners of a polygon, if they tell of a feature in the cell or near it.
///
/// Along a crease, where they say nothing, it is nearest to the mean of the corners.
pub(super) fn feature_point(cell: Cell, planes: &[Plane]) -> Option<Vec3> {
    let least =
        planes.iter().enumerate().flat_map(|(i, &(_, a))| planes.iter().skip(i + 1).map(move |&(_, b)| dot(a, b)));
    if least.fold(1.0, f64::min) > SMOOTH_COSINE {
        return None;
    }
    let (x, crease) = meeting_point(middle(planes), planes);
    let shifted = crease.and_then(|crease| nearest_in_cell(cell.place(x), crease));
    let x = shifted.map_or(x, |t| add(cell.first, scale(t, cell.h)));
    cell.may_hold(x).then_some(x)
}

/// The feature near a point from planes that touch the surface beside it, if that is at most half a cell away.
pub(super) fn nearer_feature_point(cell: Cell, about: Vec3, planes: &[Plane]) -> Option<Vec3> {
    let (x, _) = meeting_point(about, planes);
    (cell.may_hold(x) && distance(x, about) < 0.5 * cell.h).then_some(x)
}

/// The mean of the points of planes.
pub(super) fn middle(planes: &[Plane]) -> Vec3 {
    scale(planes.iter().fold([0.0; 3], |sum, plane| add(sum, plane.0)), 1.0 / planes.len() as f64)
}

/// The point that minimizes `Σ (nᵢ·(x − pᵢ))²`, and of such points the nearest to `middle`; with the direction of the line
/// that they form, if they do.
fn meeting_point(middle: Vec3, planes: &[Plane]) -> (Vec3, Option<Vec3>) {
    let (mut matrix, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for &(p, n) in planes {
        let off = dot(n, sub(p, middle));
        for i in 0..3 {
            right[i] += n[i] * off;
            for j in 0..3 {
                matrix[i][j] += n[i] * n[j];
            }
        }
    }
    let (values, vectors) = eigen(matrix);
    let most = values.into_iter().fold(0.0, f64::max);
    let mut x = middle;
    let mut unclear = Vec::new();
    for (value, v) in values.into_iter().zip(vectors) {
        if value > UNCLEAR * most {
            x = add(x, scale(v, dot(v, right) / value));
        } else {
            unclear.push(v);
        }
    }
    (x, if let [crease] = unclear[..] { Some(crease) } else { None })
}

/// The point of the line `t + s·v` in the unit cell that is nearest to s = 0, if the line meets the cell.
fn nearest_in_cell(t: Vec3, v: Vec3) -> Option<Vec3> {
    let (mut from, mut to) = (f64::MIN, f64::MAX);
    for a in 0..3 {
        if v[a].abs() < 1e-12 {
            continue;
        }
        let (p, q) = (-t[a] / v[a], (1.0 - t[a]) / v[a]);
        (from, to) = (from.max(p.min(q)), to.min(p.max(q)));
    }
    (from <= to).then(|| add(t, scale(v, 0.0f64.clamp(from, to))))
}

/// Eigenvalues and eigenvectors of a symmetric matrix by Jacobi's rotations.
fn eigen(mut m: [[f64; 3]; 3]) -> ([f64; 3], [Vec3; 3]) {
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q].abs() < 1e-300 {
                continue;
            }
            let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut m {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            let (a, b) = (m[p], m[q]);
            for k in 0..3 {
                (m[p][k], m[q][k]) = (c * a[k] - s * b[k], s * a[k] + c * b[k]);
            }
            let (a, b) = (v[p], v[q]);
            for k in 0..3 {
                (v[p][k], v[q][k]) = (c * a[k] - s * b[k], s * a[k] + c * b[k]);
            }
        }
    }
    ([m[0][0], m[1][1], m[2][2]], v)
}

/// Two facets whose common edge was turned, and what they were before.
pub(super) struct Turned {
    pub(super) facets: [usize; 2],
    pub(super) before: [[u32; 3]; 2],
}

/// Turns every edge between two fans about features so that it joins the features, unless that folds the surface or the
/// features are joined already.
///
/// A fan's triangles name its feature first, as [`super::surface`] leaves them. Returns the pairs of facets whose edge was turned.
pub(super) fn creases_joined(mesh: &mut TriangleMesh, on_feature: &[bool]) -> Vec<Turned> {
    let mut all_turned = Vec::new();
    let mut waiting: FxHashMap<(u32, u32), usize> = FxHashMap::default();
    let mut joined: FxHashSet<(u32, u32)> = FxHashSet::default();
    for second in 0..mesh.triangles.len() {
        let [g, b, a] = mesh.triangles[second];
        if !on_feature[g as usize] {
            continue;
        }
        let Some(first) = waiting.remove(&(a, b)) else {
            waiting.insert((b, a), second);
            continue;
        };
        let f = mesh.triangles[first][0];
        let pair = (f.min(g), f.max(g));
        let area = |[p, q, r]: [u32; 3]| {
            let [p, q, r] = [p, q, r].map(|v| mesh.vertices[v as usize]);
            cross(sub(q, p), sub(r, p))
        };
        let old = add(area([f, a, b]), area([g, b, a]));
        let turned = [[f, a, g], [g, b, f]];
        if joined.contains(&pair) || turned.iter().any(|&t| dot(area(t), old) <= 0.0) {
            continue;
        }
        joined.insert(pair);
        let facets = [first, second];
        all_turned.push(Turned { facets, before: facets.map(|facet| mesh.triangles[facet]) });
        (mesh.triangles[first], mesh.triangles[second]) = (turned[0], turned[1]);
    }
    all_turned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_are_orthogonal_and_their_values_right() {
        let m = [[4.0, 1.0, -2.0], [1.0, 3.0, 0.5], [-2.0, 0.5, 1.0]];
        let (values, vectors) = eigen(m);
        assert!((values.iter().sum::<f64>() - 8.0).abs() < 1e-12);
        for (value, v) in values.into_iter().zip(vectors) {
            assert!((dot(v, v) - 1.0).abs() < 1e-12);
            let image = [0, 1, 2].map(|i| dot(m[i], v));
            assert!((0..3).all(|i| (image[i] - value * v[i]).abs() < 1e-10), "{value} {v:?} {image:?}");
        }
    }

    #[test]
    fn three_planes_meet_in_a_point_two_in_a_line_and_one_in_nothing() {
        let corner = [0.3, 0.6, 0.4];
        let axes: [Vec3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let on_planes = [[0.3, 0.0, 0.0], [0.0, 0.6, 0.0], [0.0, 0.0, 0.4]];
        let cell = Cell { first: [0.0; 3], h: 1.0 };
        let planes = [0, 1, 2].map(|a| (on_planes[a], axes[a]));
        let found = feature_point(cell, &planes).unwrap();
        assert!((0..3).all(|a| (found[a] - corner[a]).abs() < 1e-12), "{found:?}");
        let found = feature_point(cell, &planes[..2]).unwrap();
        assert!(
            (found[0] - 0.3).abs() < 1e-12 && (found[1] - 0.6).abs() < 1e-12 && found[2].abs() < 1e-12,
            "{found:?}"
        );
        assert!(feature_point(cell, &on_planes.map(|p| (p, axes[0]))).is_none());
        assert!(feature_point(Cell { first: [5.0; 3], h: 1.0 }, &planes).is_none(), "outside the cell");
    }
}
