//! The patches that the boundary of a Minkowski sum is part of.

use super::bvh::{Bvh, bounds_of};
use super::gauss_image::{Arc, GaussImage};
use super::mesh::TriangleMesh;
use super::patch::Patch;
use super::vector::{add, cross, norm2, scale, sub, unit};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Edges whose directions differ by less than this, radians, sweep no area.
const PARALLEL: f64 = 1e-9;

/// Facets or edges of an operand whose partners are sought in one piece of work.
const TOGETHER: usize = 1024;

/// What `take` makes of the patches of the reduced convolution of two meshes, in order; `None` if that is more than `most`.
///
/// The patches lie in the Minkowski sum A ⊕ B, and their union holds its boundary. For where `a + b` lies on the boundary, a plane touches
/// A at a and B at b from outside: the boundary is part of the sums of facets of one with the vertices of the other that the facet's
/// plane touches, and of convex edges of both that one plane touches. The way from outside enters the sum where it first meets one.
///
/// The facets of both have to close. A mesh turned inside out stands for what is outside of it. Faces and edges of both that are
/// parallel have many partners, each of which gives a patch: [`GaussImage::of_turned`] for one of the meshes leaves enough of them.
///
/// # Cost
/// O(n log n) in the facets of both and the pairs that one plane touches: for convex B some patches for each facet of A, and some for
/// each crossing of their edges' arcs.
///
/// # Source
/// J. Basch, L. J. Guibas, G. D. Ramkumar, L. Ramshaw, *Polyhedral tracings and their convolution*, 1996; J.-M. Lien, *A simple method
/// for computing Minkowski sum boundary in 3D using collision detection*, 2008; E. Behar, J.-M. Lien, *Fast and robust 2D Minkowski
/// sum using reduced convolution*, 2011.
///
/// ```
/// use amcheck::geometry::{cuboid, gauss_image::GaussImage, reduced_convolution::reduced_convolution};
/// let [a, b] = [[1.0, 2.0, 3.0], [2.0, 1.0, 1.0]].map(|corner| cuboid([0.0; 3], corner));
/// let images = [&GaussImage::of(&a), &GaussImage::of_turned(&b)];
/// let areas = reduced_convolution(images, 1000, |patch, areas| areas.push(patch.area())).expect("they are few");
/// // The faces of a box of 3 × 3 × 4 mm.
/// assert!((areas.iter().sum::<f64>() - 66.0).abs() < 1e-9);
/// ```
pub fn reduced_convolution<T: Send + Clone>(
    [a, b]: [&GaussImage; 2],
    most: usize,
    take: impl Fn(Patch, &mut Vec<T>) + Sync,
) -> Option<Vec<T>> {
    let taken = Taken { take, most, count: AtomicUsize::new(0) };
    let mut all = taken.facets_with_vertices(a, b)?;
    all.append(&mut taken.facets_with_vertices(b, a)?);
    all.append(&mut if a.arcs.len() < b.arcs.len() { taken.edges(b, a)? } else { taken.edges(a, b)? });
    Some(all)
}

/// What is made of the patches.
struct Taken<F> {
    take: F,
    most: usize,
    count: AtomicUsize,
}

impl<F: Sync> Taken<F> {
    /// Runs over items in pieces, and gives up once too much is made of them.
    fn gathered<T: Send + Clone>(&self, items: usize, each: impl Fn(usize, &mut Vec<T>) + Sync) -> Option<Vec<T>> {
        let pieces = (0..items.div_ceil(TOGETHER)).into_par_iter().map(|piece| {
            let mut made = Vec::new();
            for item in piece * TOGETHER..items.min((piece + 1) * TOGETHER) {
                let before = made.len();
                each(item, &mut made);
                let new = made.len() - before;
                if self.count.fetch_add(new, Ordering::Relaxed) + new > self.most {
                    return None;
                }
            }
            Some(made)
        });
        Some(pieces.collect::<Option<Vec<_>>>()?.concat())
    }

    /// The facets of one mesh at each vertex of the other that their planes touch.
    fn facets_with_vertices<T: Send + Clone>(&self, of: &GaussImage, at: &GaussImage) -> Option<Vec<T>>
    where
        F: Fn(Patch, &mut Vec<T>) + Sync,
    {
        self.gathered(of.normals.len(), |f, made| {
            let n = of.normals[f];
            if n != [0.0; 3] {
                let facet = of.mesh.corners(f);
                at.touched(n, |v| {
                    let v = at.mesh.vertices[v as usize];
                    (self.take)(Patch::triangle(facet.map(|p| add(p, v))), made);
                });
            }
        })
    }

    /// The parallelograms of edges that one plane touches.
    fn edges<T: Send + Clone>(&self, a: &GaussImage, b: &GaussImage) -> Option<Vec<T>>
    where
        F: Fn(Patch, &mut Vec<T>) + Sync,
    {
        let tree = Bvh::new(&bounds_of(b.arcs.len(), |arc| b.arcs[arc].bounds()));
        let ends = |mesh: &TriangleMesh, arc: &Arc| arc.ends.map(|v| mesh.vertices[v as usize]);
        self.gathered(a.arcs.len(), |first, made| {
            let first = &a.arcs[first];
            let [p, q] = ends(a.mesh, first);
            tree.in_box(first.bounds(), |second| {
                let second = &b.arcs[second as usize];
                if have_common_plane(first, second) {
                    let [r, s] = ends(b.mesh, second);
                    (self.take)(Patch::parallelogram(add(p, r), [sub(q, p), sub(s, r)]), made);
                }
            });
        })
    }
}

/// Whether a plane touches two edges, and they are not parallel.
fn have_common_plane(a: &Arc, b: &Arc) -> bool {
    let across = cross(a.along, b.along);
    if norm2(across) < PARALLEL * PARALLEL {
        return false;
    }
    let n = unit(across);
    [n, scale(n, -1.0)].into_iter().any(|n| a.holds(n) && b.holds(n))
}

#[cfg(test)]
mod tests {
    use super::super::vector::{Vec3, dot, norm};
    use super::*;
    use crate::geometry::Primitive;
    use crate::random::Lcg;
    use crate::units::Length;

    #[test]
    fn patches_of_convex_bodies_are_the_faces_of_their_sum() {
        let mut random = Lcg(6);
        for (first, second) in
            [("ball:2mm", "cone:r1r0.4h2mm"), ("box:1x2x3mm", "cylinder:r1h3mm"), ("box:1x2x3mm", "box:2x1x1mm")]
        {
            let [a, b] = [first, second].map(|shape| Primitive::parse(shape).unwrap().mesh(Length::mm(0.05)));
            let [x, y] = [random.point(-1.0, 1.0), random.point(-1.0, 1.0)].map(unit);
            let z = unit(cross(x, y));
            let b = if first == "box:1x2x3mm" && second == "box:2x1x1mm" {
                b
            } else {
                b.transformed([x, cross(z, x), z], [0.0; 3])
            };
            let images = [GaussImage::of(&a), GaussImage::of_turned(&b)];
            let patches = reduced_convolution([&images[0], &images[1]], 1 << 20, |p, all| all.push(p)).unwrap();
            let height = |mesh: &TriangleMesh, n: Vec3| {
                mesh.vertices.iter().map(|&p| dot(p, n)).fold(f64::NEG_INFINITY, f64::max)
            };
            let mut sum = [0.0; 3];
            let mut area = 0.0;
            for patch in &patches {
                // The sum lies on one side of the patch's plane but for the turn.
                let [n, m] = [patch.normal(), scale(patch.normal(), -1.0)];
                let support = |n: Vec3| height(&a, n) + height(&b, n);
                let corners = patch.corners();
                let off = |n: Vec3| corners.iter().map(|&p| (support(n) - dot(p, n)).abs()).fold(0.0, f64::max);
                let outward = if off(n) < off(m) { n } else { m };
                assert!(off(outward) < 1e-5, "{first} {second}: {}", off(outward));
                sum = add(sum, scale(outward, patch.area()));
                area += patch.area();
            }
            // They close: none is missing.
            assert!(norm(sum) < 1e-9 * area, "{first} {second}: {sum:?} of {area} mm²");
            if second == "box:2x1x1mm" {
                assert!((area - 2.0 * (3.0 * 3.0 + 3.0 * 4.0 + 3.0 * 4.0)).abs() < 1e-9, "{area}");
            }
        }
        let cube = Primitive::parse("box:1x2x3mm").unwrap().mesh(Length::mm(1.0));
        let image = GaussImage::of(&cube);
        assert!(reduced_convolution([&image, &image], 10, |p, all| all.push(p)).is_none());
    }
}
