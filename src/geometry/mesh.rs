//! Triangle meshes.

use super::vector::{Vec3, along, bounds, compare, cross, dot, norm, sub, unit};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// An indexed triangle mesh in millimetres; facets are wound so that their normals point out of the material.
///
/// Nothing is promised about closedness: [`super::health`] measures that.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TriangleMesh {
    /// Corner positions, millimetres.
    pub vertices: Vec<Vec3>,
    /// Corner indices, counter-clockwise seen from outside; every index is below `vertices.len()`.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// The mesh of a facet soup, welded exactly: corners are one vertex if and only if their coordinates are
    /// equal (0.0 = −0.0). Facets keep their order; facets whose corners coincide are kept.
    ///
    /// # Cost
    /// O(facets), one hash look-up per corner.
    pub fn weld(facets: impl IntoIterator<Item = [Vec3; 3]>) -> Self {
        let mut mesh = TriangleMesh::default();
        let mut known: FxHashMap<[u64; 3], u32> = FxHashMap::default();
        for facet in facets {
            let corners = facet.map(|p| {
                let p = p.map(|x| x + 0.0);
                *known.entry(p.map(f64::to_bits)).or_insert_with(|| {
                    mesh.vertices.push(p);
                    (mesh.vertices.len() - 1) as u32
                })
            });
            mesh.triangles.push(corners);
        }
        mesh
    }

    /// The corners of a facet.
    #[inline]
    pub fn corners(&self, facet: usize) -> [Vec3; 3] {
        let [a, b, c] = self.triangles[facet];
        [self.vertices[a as usize], self.vertices[b as usize], self.vertices[c as usize]]
    }

    /// Twice the vector area of a facet: its direction is the outward normal.
    pub fn area_vector(&self, facet: usize) -> Vec3 {
        let [a, b, c] = self.corners(facet);
        cross(sub(b, a), sub(c, a))
    }

    /// Outward unit normal of a facet, or zero for a facet without area.
    pub fn normal(&self, facet: usize) -> Vec3 {
        unit(self.area_vector(facet))
    }

    /// Area of a facet, mm².
    pub fn facet_area(&self, facet: usize) -> f64 {
        0.5 * norm(self.area_vector(facet))
    }

    /// Area of all facets, mm².
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|f| self.facet_area(f)).sum()
    }

    /// Signed volume ∫ x·n dA / 3 in mm³, about the centre of the box so that a far origin costs no digits.
    pub fn signed_volume(&self) -> f64 {
        let Some((lo, hi)) = self.bounds() else { return 0.0 };
        let centre = [0, 1, 2].map(|a| 0.5 * (lo[a] + hi[a]));
        (0..self.triangles.len())
            .map(|f| {
                let [a, b, c] = self.corners(f).map(|p| sub(p, centre));
                dot(a, cross(b, c)) / 6.0
            })
            .sum()
    }

    /// ∫ x dV / V of what some of the facets close, in mm; `None` where that has no volume.
    pub fn centre_of_mass(&self, counts: impl Fn(usize) -> bool) -> Option<Vec3> {
        let (lo, hi) = self.bounds()?;
        let centre = [0, 1, 2].map(|a| 0.5 * (lo[a] + hi[a]));
        let (mut volume, mut moment) = (0.0, [0.0; 3]);
        for f in (0..self.triangles.len()).filter(|&f| counts(f)) {
            let [a, b, c] = self.corners(f).map(|p| sub(p, centre));
            let v = dot(a, cross(b, c)) / 6.0;
            volume += v;
            (0..3).for_each(|x| moment[x] += 0.25 * v * (a[x] + b[x] + c[x]));
        }
        (volume > 0.0).then(|| [0, 1, 2].map(|a| centre[a] + moment[a] / volume))
    }

    /// The longest side of the box of the facets; 0 without any.
    pub fn longest_side(&self) -> f64 {
        self.bounds().map_or(0.0, |(lo, hi)| sub(hi, lo).into_iter().fold(0.0, f64::max))
    }

    /// Least and greatest corner of the vertices that facets use, or `None` without facets.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        // Each vertex once, in their order in memory: facets name most of them six times.
        let mut used = vec![false; self.vertices.len()];
        self.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        bounds(self.vertices.iter().zip(used).filter(|(_, used)| *used).map(|(p, _)| *p))
    }

    /// The same mesh after `p ↦ R·p + t`; winding is reversed where R mirrors.
    pub fn transformed(&self, rotation: [[f64; 3]; 3], translation: Vec3) -> Self {
        let along = |p: Vec3, r: usize| dot(rotation[r], p) + translation[r];
        let image = |p: Vec3| [along(p, 0), along(p, 1), along(p, 2)];
        let mirrors = dot(rotation[0], cross(rotation[1], rotation[2])) < 0.0;
        TriangleMesh {
            vertices: self.vertices.iter().map(|&p| image(p)).collect(),
            triangles: self.triangles.iter().map(|&[a, b, c]| if mirrors { [a, c, b] } else { [a, b, c] }).collect(),
        }
    }

    /// The same mesh turned inside out.
    pub fn flipped(&self) -> Self {
        TriangleMesh {
            vertices: self.vertices.clone(),
            triangles: self.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        }
    }

    /// The same mesh with all coordinates multiplied.
    pub fn scaled(&self, factor: f64) -> Self {
        TriangleMesh {
            vertices: self.vertices.iter().map(|&p| p.map(|x| x * factor)).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// This mesh and another as one, their vertices kept apart.
    pub fn joined(mut self, other: &TriangleMesh) -> Self {
        let shift = self.vertices.len() as u32;
        self.vertices.extend_from_slice(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + shift)));
        self
    }

    /// The same mesh in an order that does not depend on its file: vertices by [`compare`], each facet from its least vertex,
    /// facets by their vertices. Sums over facets and ties between places then come out the same.
    ///
    /// # Cost
    /// O(n log n), in parallel; four bytes a vertex beside the copy of the vertices.
    pub fn in_order(mut self) -> Self {
        let mut order: Vec<u32> = (0..self.vertices.len() as u32).collect();
        order.par_sort_by(|&a, &b| compare(self.vertices[a as usize], self.vertices[b as usize]));
        let mut rank = vec![0u32; order.len()];
        order.iter().enumerate().for_each(|(new, &old)| rank[old as usize] = new as u32);
        self.vertices = order.iter().map(|&old| self.vertices[old as usize]).collect();
        self.triangles.par_iter_mut().for_each(|t| {
            *t = t.map(|v| rank[v as usize]);
            let least = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
            t.rotate_left(least);
        });
        self.triangles.par_sort_unstable();
        self
    }

    /// The centroid of a facet.
    pub fn centroid(&self, facet: usize) -> Vec3 {
        let [a, b, c] = self.corners(facet);
        along(along(super::vector::scale(a, 1.0 / 3.0), b, 1.0 / 3.0), c, 1.0 / 3.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_a_file_leaves_no_trace() {
        let mesh = tetrahedron();
        let mut other = mesh.clone();
        other.vertices.reverse();
        other.triangles.iter_mut().for_each(|t| *t = t.map(|v| 3 - v));
        other.triangles.reverse();
        other.triangles[1].rotate_left(2);
        assert_eq!(other.clone().in_order(), mesh.clone().in_order());
        assert!((mesh.clone().in_order().signed_volume() - mesh.signed_volume()).abs() < 1e-15);
        assert_ne!(other.flipped().in_order(), mesh.in_order());
    }

    fn tetrahedron() -> TriangleMesh {
        let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 1.0]];
        TriangleMesh::weld([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|t: [usize; 3]| t.map(|v| p[v])))
    }

    #[test]
    fn welding_joins_equal_corners_and_both_zeros() {
        let m = tetrahedron();
        assert_eq!((m.vertices.len(), m.triangles.len()), (4, 4));
        assert!((m.signed_volume() - 1.0 / 6.0).abs() < 1e-15);
        assert!((m.flipped().signed_volume() + 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn mirroring_keeps_the_volume_positive() {
        let mirrored = tetrahedron().transformed([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [1e6, 0.0, 0.0]);
        assert!((mirrored.signed_volume() - 1.0 / 6.0).abs() < 1e-9);
    }
}
