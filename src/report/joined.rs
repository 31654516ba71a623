//! The corners of an exhibit joined to the vertices of a copy.

use super::exhibit::SurfaceMap;
use super::glb::{Detail, Frame, Vertex};
use super::render::colour::Scale;
use crate::check::Sense;
use crate::geometry::vector::{Vec3, add, cross, sub};
use rustc_hash::FxHashMap;

/// Corners, three a facet, with those that are one place told once for copies of any detail.
pub(super) struct Points {
    /// The place of each corner.
    of_corner: Vec<u32>,
    places: Vec<Vec3>,
    /// The axis and side that each facet faces most, 0 to 5.
    facing: Vec<u8>,
}

/// No vertex.
const NONE: u32 = u32::MAX;

impl Points {
    /// The places of corners.
    ///
    /// # Cost
    /// O(corners), one hash look-up each.
    pub(super) fn of(corners: &[Vec3]) -> Self {
        let mut known: FxHashMap<[u64; 3], u32> = FxHashMap::default();
        let mut places = Vec::new();
        let of_corner = corners.iter().map(|p| {
            *known.entry(p.map(f64::to_bits)).or_insert_with(|| {
                places.push(*p);
                places.len() as u32 - 1
            })
        });
        Points { of_corner: of_corner.collect(), places, facing: corners.chunks_exact(3).map(facing).collect() }
    }

    /// Vertices in the order of first use, and the triangles that use them; triangles without extent are left out.
    ///
    /// At full detail corners are joined where place and every map agree. In a coarser copy they are joined where they fall
    /// on one step and face the same way, at the mean of all places there, and carry the worst value of all.
    ///
    /// # Cost
    /// O(corners), and a hash look-up for each place; at full detail for each corner.
    pub(super) fn joined(&self, maps: &[(&SurfaceMap, Scale)], frame: Frame) -> (Vec<Vertex>, Vec<u32>) {
        let cells = Cells::of(&self.places, frame);
        let cell = |corner: usize| cells.of_place[self.of_corner[corner] as usize] as usize;
        let value = |map: &SurfaceMap, corner: usize| map.values.get(corner).copied().unwrap_or(f32::NAN);
        let mut vertices: Vec<Vertex> = Vec::new();
        let mut add_vertex = |cell: usize| {
            let mut vertex = Vertex::default();
            vertex[..3].copy_from_slice(&cells.steps[cell]);
            vertices.push(vertex);
            vertices.len() as u32 - 1
        };
        if frame.detail() == Detail::FULL {
            let mut known: FxHashMap<Vertex, u32> = FxHashMap::default();
            let indices = self.triangles(|corner| {
                let mut vertex = Vertex::default();
                vertex[..3].copy_from_slice(&cells.steps[cell(corner)]);
                for (code, (map, scale)) in vertex[3..].iter_mut().zip(maps) {
                    *code = frame.code(value(map, corner), scale);
                }
                *known.entry(vertex).or_insert_with(|| add_vertex(cell(corner)))
            });
            known.into_iter().for_each(|(vertex, at)| vertices[at as usize] = vertex);
            return (vertices, indices);
        }
        let mut known = vec![[NONE; 6]; cells.steps.len()];
        let mut worst: Vec<f32> = Vec::new();
        let indices = self.triangles(|corner| {
            let at = &mut known[cell(corner)][usize::from(self.facing[corner / 3])];
            if *at == NONE {
                *at = add_vertex(cell(corner));
                worst.resize(worst.len() + maps.len(), f32::NAN);
            }
            let kept = &mut worst[*at as usize * maps.len()..][..maps.len()];
            kept.iter_mut().zip(maps).for_each(|(kept, (map, _))| *kept = worse(*kept, value(map, corner), map.sense));
            *at
        });
        // Codes rise with values: the worst code is that of the worst value.
        for (vertex, worst) in vertices.iter_mut().zip(worst.chunks_exact(maps.len().max(1))) {
            vertex[3..].iter_mut().zip(worst).zip(maps).for_each(|((to, v), (_, scale))| *to = frame.code(*v, scale));
        }
        (vertices, indices)
    }

    /// The triangles by their vertices, without those that have one twice.
    fn triangles(&self, mut vertex: impl FnMut(usize) -> u32) -> Vec<u32> {
        let mut indices = Vec::with_capacity(self.of_corner.len());
        for facet in 0..self.facing.len() {
            let [a, b, c] = [0, 1, 2].map(|k| vertex(3 * facet + k));
            if a != b && b != c && c != a {
                indices.extend([a, b, c]);
            }
        }
        indices
    }
}

/// Places by the steps they fall on.
struct Cells {
    of_place: Vec<u32>,
    /// The steps of each cell, in the order of first use; in a coarse copy those of the mean of its places.
    steps: Vec<[u16; 3]>,
}

impl Cells {
    fn of(places: &[Vec3], frame: Frame) -> Self {
        let mut known: FxHashMap<u64, u32> = FxHashMap::default();
        let mut steps = Vec::new();
        let of_place = places.iter().map(|p| {
            let [x, y, z] = [0, 1, 2].map(|a| frame.step(p[a], a));
            *known.entry(u64::from(x) | u64::from(y) << 16 | u64::from(z) << 32).or_insert_with(|| {
                steps.push([x, y, z]);
                steps.len() as u32 - 1
            })
        });
        let of_place: Vec<u32> = of_place.collect();
        if frame.detail() != Detail::FULL {
            let mut sums = vec![([0.0; 3], 0u32); steps.len()];
            for (&cell, p) in of_place.iter().zip(places) {
                let (sum, count) = &mut sums[cell as usize];
                (*sum, *count) = (add(*sum, *p), *count + 1);
            }
            for (step, (sum, count)) in steps.iter_mut().zip(sums) {
                *step = [0, 1, 2].map(|a| frame.fine_step(sum[a] / f64::from(count), a));
            }
        }
        Cells { of_place, steps }
    }
}

/// The worse of two values; what has no code is none.
fn worse(a: f32, b: f32, sense: Sense) -> f32 {
    let none = |x: f32| x.is_nan() || x == f32::NEG_INFINITY;
    match (none(a), none(b), sense) {
        (true, ..) => b,
        (_, true, _) => a,
        (.., Sense::Min) => a.min(b),
        (.., Sense::Max) => a.max(b),
    }
}

/// The axis and side that a facet faces most, 0 to 5.
fn facing(facet: &[Vec3]) -> u8 {
    let [a, b, c] = facet else { return 0 };
    let n = cross(sub(*b, *a), sub(*c, *a));
    let axis = (0..3).max_by(|&i, &j| n[i].abs().total_cmp(&n[j].abs())).unwrap_or(0);
    2 * axis as u8 + u8::from(n[axis] < 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::glb::UNMEASURED;
    use super::*;
    use crate::random::Lcg;

    /// Every corner's own key looked up, and the worst of codes kept.
    fn plainly(corners: &[Vec3], maps: &[(&SurfaceMap, Scale)], frame: Frame) -> (Vec<Vertex>, Vec<u32>) {
        let mut known: FxHashMap<(Vertex, u8), u32> = FxHashMap::default();
        let (mut vertices, mut indices) = (Vec::<Vertex>::new(), Vec::new());
        let steps = |p: &Vec3| [0, 1, 2].map(|a| frame.step(p[a], a));
        let shown = |p: &Vec3| {
            let mut places: Vec<Vec3> = Vec::new();
            corners.iter().filter(|q| steps(q) == steps(p)).for_each(|q| {
                if !places.contains(q) {
                    places.push(*q);
                }
            });
            let sum = places.iter().fold([0.0; 3], |sum, q| add(sum, *q));
            [0, 1, 2].map(|a| frame.fine_step(sum[a] / places.len() as f64, a))
        };
        for (f, facet) in corners.chunks_exact(3).enumerate() {
            let mut triangle = [0u32; 3];
            for (k, p) in facet.iter().enumerate() {
                let mut vertex = Vertex::default();
                (0..3).for_each(|a| vertex[a] = frame.step(p[a], a));
                let mut key = (vertex, facing(facet));
                for (m, (map, scale)) in maps.iter().enumerate() {
                    vertex[3 + m] = frame.code(map.values[3 * f + k], scale);
                }
                if frame.detail() == Detail::FULL {
                    key = (vertex, 0);
                }
                if frame.detail() != Detail::FULL {
                    vertex[..3].copy_from_slice(&shown(p));
                }
                triangle[k] = *known.entry(key).or_insert_with(|| {
                    vertices.push(vertex);
                    vertices.len() as u32 - 1
                });
                let kept = &mut vertices[triangle[k] as usize];
                for (m, (map, _)) in maps.iter().enumerate() {
                    kept[3 + m] = match (kept[3 + m], vertex[3 + m], map.sense) {
                        (UNMEASURED, other, _) | (other, UNMEASURED, _) => other,
                        (a, b, Sense::Min) => a.min(b),
                        (a, b, Sense::Max) => a.max(b),
                    };
                }
            }
            if triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0] {
                indices.extend(triangle);
            }
        }
        (vertices, indices)
    }

    #[test]
    fn places_that_are_told_once_give_what_each_corner_gives() {
        let mut random = Lcg(31);
        let some: Vec<Vec3> = (0..150).map(|_| random.point(0.0, 4.0)).collect();
        let corners: Vec<Vec3> = (0..1500).map(|_| some[random.below(150) as usize]).collect();
        let mut map = |sense| SurfaceMap {
            check: "a".into(),
            title: "a".into(),
            unit: "mm".into(),
            sense,
            fail: Some(1.0),
            warn: None,
            open_end: 4.0,
            fills: None,
            values: (0..corners.len())
                .map(|n| match n % 11 {
                    0 => f32::NAN,
                    1 => f32::INFINITY,
                    2 => f32::NEG_INFINITY,
                    3 => 9.0,
                    _ => (4.0 * random.unit()) as f32,
                })
                .collect(),
        };
        let maps = [map(Sense::Min), map(Sense::Max)];
        let points = Points::of(&corners);
        for detail in [Detail::FULL, Detail { cells: 16, codes: 9 }, Detail { cells: 3, codes: 200 }] {
            let frame = Frame::new([0.0; 3], [4.0; 3], detail);
            for shown in [&maps[..], &[]] {
                let scaled: Vec<(&SurfaceMap, Scale)> = shown.iter().map(|m| (m, Scale::of(m))).collect();
                assert_eq!(points.joined(&scaled, frame), plainly(&corners, &scaled, frame), "{detail:?}");
            }
        }
    }
}
