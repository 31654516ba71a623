//! Directions to stand a part up, and a quick score of each from the mesh alone.

use super::question::Question;
use crate::geometry::TriangleMesh;
use crate::geometry::bvh::{Bvh, bounds_of};
use crate::geometry::vector::{Vec3, add, along, angle, distance, dot, norm, scale, unit};
use rayon::prelude::*;

/// The largest flat faces whose normals are tried.
pub const FACES: usize = 24;
/// Within 1° of the horizontal a facet leaves no steps and stands on the plate.
pub(super) const LEVEL: f64 = 0.999_847_695_156_391_2;

/// A direction's score on the mesh alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Score {
    pub up: Vec3,
    pub from: &'static str,
    pub cost: f64,
}

/// Outward normals of the largest flat pieces of the facets that bound the solid, largest first; at most [`FACES`].
pub fn flat_face_normals(mesh: &TriangleMesh, bounding: &(impl Fn(usize) -> bool + Sync)) -> Vec<Vec3> {
    Facets::of(mesh, bounding, 0).face_normals()
}

/// The facets that count, in a form that is quick to score.
pub(super) struct Facets {
    area: Vec<Vec3>,
    pub size: Vec<f64>,
    centroid: Vec<Vec3>,
    pub hull: Vec<Vec3>,
    /// How far the farthest vertex is from the middle of the surface.
    reach: f64,
}

/// Measures of the part that costs are relative to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Whole {
    pub volume: f64,
    pub area: f64,
    /// Twice as far as the part reaches from the middle of its surface, however it stands: the diagonal of a box.
    pub across: f64,
}

impl Whole {
    /// Of a part of some volume, by its facets.
    pub fn of(mesh: &TriangleMesh, facets: &Facets) -> Self {
        Whole { volume: mesh.signed_volume().abs(), area: facets.size.iter().sum(), across: 2.0 * facets.reach }
    }
}

/// Directions to be scored: axes first, then faces, then rests, then the sphere; each once.
pub(super) fn candidates(facets: &Facets, rests: &[Vec3], directions: usize) -> Vec<(Vec3, &'static str)> {
    let mut found: Vec<(Vec3, &'static str)> = Vec::new();
    let mut offer = |d: Vec3, from: &'static str| {
        if norm(d) > 0.5 && found.iter().all(|(e, _)| angle(*e, d) > 1e-3) {
            found.push((d, from));
        }
    };
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut d = [0.0; 3];
            d[axis] = sign;
            offer(d, "axis");
        }
    }
    facets.face_normals().into_iter().for_each(|n| offer(scale(n, -1.0), "face"));
    rests.iter().for_each(|d| offer(*d, "rest"));
    sphere(directions).into_iter().for_each(|d| offer(d, "sphere"));
    found
}

/// `n` directions spread evenly over the sphere: the Fibonacci lattice.
pub(super) fn sphere(n: usize) -> Vec<Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..n)
        .map(|i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / n as f64;
            let r = (1.0 - z * z).sqrt();
            let (s, c) = (golden * i as f64).sin_cos();
            [r * c, r * s, z]
        })
        .collect()
}

impl Facets {
    /// The facets that bound the solid, to be scored for some number of directions.
    pub(super) fn of(mesh: &TriangleMesh, bounding: &(impl Fn(usize) -> bool + Sync), directions: usize) -> Self {
        let mut f = Facets { area: Vec::new(), size: Vec::new(), centroid: Vec::new(), hull: Vec::new(), reach: 0.0 };
        let mut used = vec![false; mesh.vertices.len()];
        for t in (0..mesh.triangles.len()).filter(|&t| bounding(t)) {
            let area = scale(mesh.area_vector(t), 0.5);
            f.size.push(norm(area));
            f.area.push(area);
            f.centroid.push(mesh.centroid(t));
            mesh.triangles[t].iter().for_each(|&v| used[v as usize] = true);
        }
        let points: Vec<Vec3> = mesh.vertices.iter().zip(used).filter(|(_, u)| *u).map(|(p, _)| *p).collect();
        let area: f64 = f.size.iter().sum();
        let middle = f.centroid.iter().zip(&f.size).fold([0.0; 3], |sum, (&c, &s)| along(sum, c, s / area));
        f.reach = points.iter().map(|&p| distance(p, middle)).fold(0.0, f64::max);
        // Finding what is outermost costs 1500 looks at every vertex.
        f.hull = if directions > FACES { outermost(&points) } else { points };
        f
    }

    /// Normals of the largest flat pieces: facets gathered by direction, the largest sums first.
    fn face_normals(&self) -> Vec<Vec3> {
        let bin = |i: usize| {
            let s = self.size[i];
            (s > 0.0).then(|| (self.area[i].map(|c| (c / s * 2000.0).round() as i32), i as u32))
        };
        let mut bins: Vec<([i32; 3], u32)> = (0..self.size.len()).into_par_iter().filter_map(bin).collect();
        bins.par_sort_unstable();
        let sum = |bin: &[([i32; 3], u32)]| bin.iter().fold([0.0; 3], |sum, &(_, i)| add(sum, self.area[i as usize]));
        let mut sums: Vec<Vec3> = bins.chunk_by(|a, b| a.0 == b.0).map(sum).collect();
        sums.sort_by(|a, b| norm(*b).total_cmp(&norm(*a)));
        sums.into_iter().take(FACES).map(unit).collect()
    }

    /// The score of a direction: the cost as if every support reached the plate.
    pub(super) fn score(&self, up: Vec3, from: &'static str, q: &Question, whole: &Whole) -> Score {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in &self.hull {
            let z = dot(*p, up);
            low = low.min(z);
            high = high.max(z);
        }
        let least = q.support_angle.map_or(f64::INFINITY, |a| a.as_radians().cos());
        let on_plate = low + 0.5 * q.layer_mm;
        let (mut support, mut contact, mut steps, mut bed) = (0.0, 0.0, 0.0, 0.0);
        for ((a, s), c) in self.area.iter().zip(&self.size).zip(&self.centroid) {
            let up_part = dot(*a, up);
            let level = up_part.abs() >= LEVEL * s;
            if !level {
                steps += up_part.abs();
            }
            if -up_part > least.min(LEVEL) * s {
                let z = dot(*c, up);
                if z > on_plate {
                    if -up_part > least * s {
                        support -= up_part * (z - low);
                        contact += s;
                    }
                } else if level {
                    bed += s;
                }
            }
        }
        let steps = 0.5 * q.layer_mm * steps;
        let cost = support / whole.volume
            + contact / whole.area
            + steps / whole.volume
            + 0.2 * (high - low) / whole.across
            + (1.0 - 10.0 * bed / whole.area).max(0.0);
        Score { up, from, cost }
    }
}

/// The vertices that are farthest in some direction: every extreme of a fine set of directions, so heights are right to a part in a
/// thousand.
fn outermost(points: &[Vec3]) -> Vec<Vec3> {
    const MANY: usize = 4096;
    if points.len() <= MANY {
        return points.to_vec();
    }
    let tree = Bvh::new(&bounds_of(points.len(), |i| (points[i], points[i])));
    let mut kept: Vec<usize> = sphere(1500).par_iter().filter_map(|d| farthest(points, &tree, *d)).collect();
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|i| points[i]).collect()
}

/// The last of the points that are farthest in a direction.
fn farthest(points: &[Vec3], tree: &Bvh, d: Vec3) -> Option<usize> {
    // The corner of a box that is farthest.
    let most = |node: usize| tree.nodes()[node].farthest_corner(d);
    let mut best: Option<(f64, u32)> = None;
    let mut stack: Vec<(f64, usize)> = tree.nodes().first().map(|_| (f64::INFINITY, 0)).into_iter().collect();
    while let Some((bound, node)) = stack.pop() {
        if best.is_some_and(|(far, _)| bound < far) {
            continue;
        }
        let Some([left, right]) = tree.nodes()[node].children() else {
            for &i in &tree.order()[tree.nodes()[node].run()] {
                let far = (dot(points[i as usize], d), i);
                let farther = |b: (f64, u32)| far.0.total_cmp(&b.0).then(far.1.cmp(&b.1)).is_gt();
                best = if best.is_none_or(farther) { Some(far) } else { best };
            }
            continue;
        };
        let (left, right) = ((most(left), left), (most(right), right));
        // The farther one first.
        stack.extend(if left.0 < right.0 { [left, right] } else { [right, left] });
    }
    best.map(|(_, i)| i as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::random::Lcg;
    use crate::units::Length;

    #[test]
    fn the_outermost_are_the_last_of_the_farthest_in_each_direction() {
        let mut random = Lcg(17);
        // Doubled points are ties.
        let points: Vec<Vec3> = (0..2500).map(|_| random.point(-1.0, 1.0)).flat_map(|p| [p, p]).collect();
        let far = |d: &Vec3| (0..points.len()).max_by(|&i, &j| dot(points[i], *d).total_cmp(&dot(points[j], *d)));
        let mut plain: Vec<usize> = sphere(1500).iter().filter_map(far).collect();
        plain.sort_unstable();
        plain.dedup();
        assert_eq!(outermost(&points), plain.into_iter().map(|i| points[i]).collect::<Vec<_>>());
    }

    #[test]
    fn face_normals_are_the_sums_of_a_table_of_bins() {
        let mesh = Primitive::parse("cone:r4r1h6mm").unwrap().mesh(Length::mm(0.01));
        let facets = Facets::of(&mesh, &|_| true, 0);
        let mut bins: std::collections::BTreeMap<[i32; 3], Vec3> = Default::default();
        for (a, s) in facets.area.iter().zip(&facets.size).filter(|(_, s)| **s > 0.0) {
            let sum = bins.entry(a.map(|c| (c / s * 2000.0).round() as i32)).or_default();
            *sum = add(*sum, *a);
        }
        let mut sums: Vec<Vec3> = bins.into_values().collect();
        sums.sort_by(|a, b| norm(*b).total_cmp(&norm(*a)));
        assert_eq!(facets.face_normals(), sums.into_iter().take(FACES).map(unit).collect::<Vec<_>>());
    }
}
