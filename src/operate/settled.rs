//! Sums, obstacles and differences end where their operands touch: the surface there.

use super::met::{Met, flooded};
use super::midway::widened;
use super::whole::{Whole, outward_solid};
use crate::distance::signed_distance;
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::contour::{Edge, SMOOTH_COSINE, Sheets, bend_between, creased, sharp_surface};
use crate::geometry::gauss_image::GaussImage;
use crate::geometry::vector::{Vec3, scale};
use crate::geometry::{MeshDistance, TriangleMesh};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Where the operands of a sum touch.
pub(super) struct Touch {
    operands: [TriangleMesh; 2],
    free: Free,
}

/// On which side of its boundary the result is free of the sum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Free {
    /// Outside: of a sum or an obstacle.
    Outside,
    /// Inside: of a difference, which is what the sum of the part's outside and the mirrored element leaves.
    Inside,
}

/// A surface, and how much of it is where the operands touch.
pub(super) struct Settled {
    pub(super) mesh: TriangleMesh,
    /// The samples inside.
    pub(super) inside: Indicator,
    /// Edges of the lattice that cross it there.
    pub(super) touching: usize,
    /// All that cross it.
    pub(super) crossings: usize,
}

impl Touch {
    /// For the sum of a part and an element; `None` if the facets of one do not bound a solid, wound outwards, and nothing else.
    pub(super) fn of_sum(part: &TriangleMesh, element: &TriangleMesh) -> Option<Self> {
        let solid = |mesh| outward_solid(mesh).is_some();
        let operands = || [part.clone(), element.clone()];
        (solid(part) && solid(element)).then(|| Touch { operands: operands(), free: Free::Outside })
    }

    /// For the obstacle of a part for an element; `None` as for a sum.
    pub(super) fn of_obstacle(part: &TriangleMesh, element: &TriangleMesh) -> Option<Self> {
        Self::of_sum(part, &mirrored(element))
    }

    /// For the Minkowski difference of a part and an element; `None` as for a sum, and if the part has facets inside of its material:
    /// its outside does not touch anything there.
    pub(super) fn of_difference(part: &Whole, element: &TriangleMesh) -> Option<Self> {
        let operands = || [part.mesh.flipped(), mirrored(element)];
        (part.bounding && outward_solid(element).is_some()).then(|| Touch { operands: operands(), free: Free::Inside })
    }

    /// For the way back from a surface of this one: the difference of a sum's, or the sum of a difference's, by the same element. Such a
    /// surface bounds a solid, wound outwards, and does not cross itself.
    pub(super) fn back(&self, surface: &TriangleMesh) -> Self {
        let [_, element] = &self.operands;
        let (made, free) = match self.free {
            Free::Outside => (surface.flipped(), Free::Inside),
            Free::Inside => (surface.clone(), Free::Outside),
        };
        Touch { operands: [made, mirrored(element)], free }
    }

    /// The surface of the true result between a set within it and one that holds it, its vertices where the operands touch, its creases
    /// as edges.
    ///
    /// A sample is free if edges of the lattice join it to one that is certainly free without meeting the sum; the surface crosses an
    /// edge where it first meets the sum from its free end, exactly but for rounding and for [`sharp_surface`]'s thousandth of an edge
    /// about samples. A vertex on a crease is where the faces at the corners of its cell meet; between vertices the surface is off by
    /// what facets of a spacing are. A free room in which nothing is certainly free is left to the sum, and what of the sum no sample
    /// is in to the free.
    ///
    /// `None` if nothing is certainly inside, or nothing certainly free, or the convolution of the operands crosses more than sixteen
    /// million edges between the two sets.
    ///
    /// # Errors
    /// As [`sharp_surface`].
    ///
    /// # Cost
    /// That of the [reduced convolution](crate::geometry::reduced_convolution::reduced_convolution()), whose patches are drawn into the
    /// lattice: 24 bytes for each crossing between the two sets, and three bits a sample.
    pub(super) fn surface(&self, [lower, upper]: [&Indicator; 2]) -> Result<Option<Settled>> {
        if lower.is_empty() {
            return Ok(None);
        }
        let sides = [widened(lower)?, widened(upper)?];
        let [a, b] = &self.operands;
        let Some(met) = Met::by([&GaussImage::of(a), &GaussImage::of_turned(b)], &sides) else { return Ok(None) };
        let [lower, upper] = sides;
        let open = upper.difference(&lower)?;
        let certain = match self.free {
            Free::Outside => upper.complement(),
            Free::Inside => lower,
        };
        if certain.is_empty() {
            return Ok(None);
        }
        let free = flooded(certain, &open, &met.edges);
        let inside = match self.free {
            Free::Outside => free.complement(),
            Free::Inside => free,
        };
        let faces = Faces { met, inside: &inside, free: self.free, crossings: 0.into(), touching: 0.into() };
        let (mesh, _) = sharp_surface(&inside, &faces)?;
        let [crossings, touching] = [faces.crossings, faces.touching].map(AtomicUsize::into_inner);
        Ok(Some(Settled { mesh, inside, touching, crossings }))
    }
}

/// The signed distance to a surface between the samples inside and outside: to its facets within three spacings, farther away to
/// the samples, which are within a spacing of it.
///
/// # Errors
/// As [`signed_distance`].
///
/// # Cost
/// A distance transform, and a search for each sample near the surface.
pub(super) fn field_to(mesh: &TriangleMesh, inside: &Indicator) -> Result<Field<f32>> {
    let mut field = signed_distance(inside)?.field().clone();
    let (grid, exact) = (*field.grid(), MeshDistance::new(mesh));
    field.values_mut().par_iter_mut().enumerate().for_each(|(at, value)| {
        if f64::from(value.abs()) < 3.0 * grid.h() {
            let nearest = exact.nearest(grid.position(grid.index(at)), f64::INFINITY);
            *value = nearest.map_or(*value, |n| (n.distance as f32).copysign(*value));
        }
    });
    Ok(field)
}

/// The mesh of −B.
fn mirrored(mesh: &TriangleMesh) -> TriangleMesh {
    mesh.scaled(-1.0).flipped()
}

/// The boundary of a sum as seen from its free side.
struct Faces<'a> {
    met: Met,
    inside: &'a Indicator,
    free: Free,
    /// As in [`Settled`].
    crossings: AtomicUsize,
    touching: AtomicUsize,
}

impl Sheets for Faces<'_> {
    type Note = Option<Vec3>;

    fn crossing(&self, edge: Edge) -> (f64, Option<Vec3>) {
        self.crossings.fetch_add(1, Ordering::Relaxed);
        let from = edge.from.map(|n| usize::try_from(n).ok());
        let [Some(i), Some(j), Some(k)] = from else { return (0.5, None) };
        let starts_inside = self.inside.contains([i, j, k]);
        let starts_free = starts_inside == (self.free == Free::Inside);
        let Some((t, n)) = self.met.first([i, j, k], edge.axis, starts_free) else { return (0.5, None) };
        self.touching.fetch_add(1, Ordering::Relaxed);
        let outwards = if starts_inside { 1.0 } else { -1.0 };
        (t, Some(if n[edge.axis] * outwards < 0.0 { scale(n, -1.0) } else { n }))
    }

    fn normals(&self, _: [isize; 3], _: &[Vec3], notes: &[Option<Vec3>]) -> Option<Vec<Vec3>> {
        creased(notes, SMOOTH_COSINE)
    }

    fn bend(&self, ends: [Vec3; 2], normals: [Option<Vec3>; 2]) -> f64 {
        bend_between(ends, normals)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::{add, along, unit};
    use crate::geometry::{Primitive, cuboid, extruded};
    use crate::morphology::{Sandwich, Sides};
    use crate::random::Lcg;
    use crate::units::Length;
    use std::borrow::Cow;

    const H: f64 = 0.3;

    fn sides(mesh: &TriangleMesh) -> Sides {
        Sides::of_mesh(mesh, Length::mm(H), [0.25; 3]).unwrap()
    }

    /// A body with reflex edges, turned so that nothing is parallel to an axis.
    fn turned(outline: &[[f64; 2]], caps: &[[usize; 3]], high: f64, random: &mut Lcg) -> TriangleMesh {
        let [x, y] = [random.point(-1.0, 1.0), random.point(-1.0, 1.0)].map(unit);
        let z = unit(crate::geometry::vector::cross(x, y));
        let rotation = [x, crate::geometry::vector::cross(z, x), z];
        extruded(outline, caps, high).transformed(rotation, random.point(-0.1, 0.1))
    }

    fn moved(mesh: &TriangleMesh, by: Vec3) -> MeshDistance {
        let vertices = mesh.vertices.iter().map(|&p| add(p, by)).collect();
        MeshDistance::new(&TriangleMesh { vertices, triangles: mesh.triangles.clone() })
    }

    #[test]
    fn vertices_lie_where_the_operands_touch() {
        let mut random = Lcg(5);
        let l = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.5], [1.5, 1.5], [1.5, 4.0], [0.0, 4.0]];
        let u = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.5], [1.4, 1.5], [1.4, 0.6], [0.6, 0.6], [0.6, 1.5], [0.0, 1.5]];
        let fan = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        let caps = [[0, 1, 4], [1, 2, 3], [1, 3, 4], [0, 4, 5], [0, 5, 6], [0, 6, 7]];
        for _ in 0..6 {
            let (part, element) = (turned(&l, &fan, 3.0, &mut random), turned(&u, &caps, 1.0, &mut random).scaled(0.8));
            let [a, b] = [sides(&part), sides(&element)];
            let found = Sandwich::obstacle(&a, &b).unwrap();
            let settled =
                Touch::of_obstacle(&part, &element).unwrap().surface([&found.lower, &found.upper]).unwrap().unwrap();
            assert_eq!(settled.touching, settled.crossings);
            // By the definition of the obstacle, with no convolution: outside of it the element is free of the part, inside it is not.
            let part = MeshDistance::new(&part);
            let mut normals = vec![[0.0; 3]; settled.mesh.vertices.len()];
            for (f, facet) in settled.mesh.triangles.iter().enumerate() {
                let area = settled.mesh.area_vector(f);
                facet.iter().for_each(|&v| normals[v as usize] = add(normals[v as usize], area));
            }
            let grid = *settled.inside.grid();
            let on_edge =
                |p: Vec3| grid.continuous_index(p).iter().filter(|x| (*x - x.round()).abs() < 1e-9).count() >= 2;
            // A crossing is kept a thousandth of an edge from samples.
            let step = 2e-3 * H;
            let vertices = settled.mesh.vertices.iter().zip(&normals);
            let vertices: Vec<_> = vertices.filter(|(p, _)| on_edge(**p)).step_by(5).collect();
            assert!(vertices.len() > 300, "{}", vertices.len());
            for (&p, &n) in vertices {
                let apart =
                    |by: f64| part.pair_distance(&moved(&element, along(p, unit(n), by)), 1.0).map(|found| found.0);
                assert!(apart(step).is_some_and(|d| d > 0.0), "{p:?}: meets the part outside");
                assert_eq!(apart(-step), Some(0.0), "{p:?}: free of the part inside");
            }
        }
    }

    #[test]
    fn a_difference_is_that_of_boxes_and_none_of_a_part_with_facets_inside() {
        let (part, element) = (cuboid([0.0; 3], [6.0, 5.0, 4.0]), cuboid([-0.5, -0.25, 0.0], [0.5, 0.75, 1.0]));
        let found = Sandwich::difference(&sides(&part), &sides(&element)).unwrap();
        let settled = Touch::of_difference(&Whole::of(&part), &element)
            .unwrap()
            .surface([&found.lower, &found.upper])
            .unwrap()
            .unwrap();
        let volume = settled.mesh.signed_volume();
        assert!((volume - 5.0 * 4.0 * 3.0).abs() < 94.0 * 1e-3 * H, "{volume}");
        let both = part.clone().joined(&cuboid([5.0, 1.0, 1.0], [9.0, 2.0, 2.0]));
        assert!(Touch::of_difference(&Whole::of(&both), &element).is_some(), "its union");
        assert!(Touch::of_difference(&Whole { mesh: Cow::Borrowed(&both), bounding: false }, &element).is_none());
        assert!(Touch::of_sum(&both, &element).is_some());
        assert!(Touch::of_sum(&part.flipped(), &element).is_none());
        let ball = Primitive::parse("ball:1mm").unwrap().mesh(Length::mm(0.1));
        let open = TriangleMesh { triangles: ball.triangles[1..].to_vec(), ..ball };
        assert!(Touch::of_sum(&part, &open).is_none());
    }
}
