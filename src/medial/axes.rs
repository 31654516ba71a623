//! Principal axes of symmetric forms.

use crate::geometry::vector::{Vec3, dot};

/// The direction along which a symmetric form is least: argmin { aᵀMa : |a| = 1 }.
pub fn least_axis(m: [[f64; 3]; 3]) -> Vec3 {
    let form = |a: Vec3| dot(a, [0, 1, 2].map(|i| dot(m[i], a)));
    eigenvectors(m).into_iter().min_by(|a, b| form(*a).total_cmp(&form(*b))).unwrap_or([0.0, 0.0, 1.0])
}

/// Eigenvectors of a symmetric matrix by Jacobi rotations.
pub(super) fn eigenvectors(mut m: [[f64; 3]; 3]) -> [Vec3; 3] {
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..24 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q].abs() < 1e-300 {
                continue;
            }
            let theta = 0.5 * (2.0 * m[p][q]).atan2(m[p][p] - m[q][q]);
            let (s, c) = theta.sin_cos();
            for row in &mut m {
                let (a, b) = (row[p], row[q]);
                (row[p], row[q]) = (c * a + s * b, c * b - s * a);
            }
            let (rp, rq) = (m[p], m[q]);
            for k in 0..3 {
                m[p][k] = c * rp[k] + s * rq[k];
                m[q][k] = c * rq[k] - s * rp[k];
            }
            let (vp, vq) = (v[p], v[q]);
            for k in 0..3 {
                v[p][k] = c * vp[k] + s * vq[k];
                v[q][k] = c * vq[k] - s * vp[k];
            }
        }
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_a_tube_leave_its_axis() {
        let axis = [0.6, 0.0, 0.8];
        let (u, v) = ([0.8, 0.0, -0.6], [0.0, 1.0, 0.0]);
        let mut m = [[0.0; 3]; 3];
        for k in 0..7 {
            let (s, c) = (0.9 * k as f64).sin_cos();
            let n = [0, 1, 2].map(|a| c * u[a] + s * v[a]);
            (0..3).for_each(|i| (0..3).for_each(|j| m[i][j] += n[i] * n[j]));
        }
        assert!(dot(least_axis(m), axis).abs() > 1.0 - 1e-12);
    }
}
