//! The surface of what a body covers on its way, from distances to the body between its poses.

use super::element::Sides;
use super::level::{SMOOTH_COSINE, root_of_cubic};
use super::moving::{Moving, REACH, Sight};
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::contour::{Edge, Sheets, bend_between, creased, sharp_surface};
use crate::geometry::refine::{Halvings, split_curved_edges};
use crate::geometry::vector::{Vec3, add, along, dot, scale, unit};
use crate::geometry::{TriangleMesh, Waypoint};
use crate::grid::Grid;
use rayon::prelude::*;

/// A crossing is sought by at most so many distances along an edge, and well enough known if the last step was shorter than this, in
/// spacings: that step, Newton's, leaves about its square.
const MOST_STEPS: usize = 6;
const NEAR_CROSSING: f64 = 0.05;

/// Edges that are inscribed deeper than this, in spacings, are split.
const FINE: f64 = 0.003;

/// Points this near to the surface, in spacings, may be brought onto it.
const BESIDE: f64 = 0.6;

/// Slopes along an edge that are this near to the mean one, of at most 1, belong to no crease that matters.
const SMOOTH_SLOPE: f64 = 0.1;

/// The surface of what a mesh covers along waypoints, and the samples in it; `copies` are those at poses of which no point of the mesh goes
/// farther than half a spacing from one to the next.
///
/// A sample is inside where a copy holds it, or the body anywhere on its way. Vertices lie where the distance to the body where it is nearest
/// vanishes, whatever the phase of the lattice; creases are edges, as those of [`sharp_surface`]. The mesh must bound a solid, wound
/// outwards, and nothing else. What holds no sample is left out, and so is what the body covers within less than a spacing of its way alone.
///
/// # Errors
/// As [`sharp_surface`].
///
/// # Cost
/// For each sample beside the surface a look-up for each spacing of the way on which the mesh is about as near, and some four distances to it
/// for each time that it comes near; some twenty for each vertex on a crease.
pub fn motion_surface(
    mesh: &TriangleMesh,
    waypoints: &[Waypoint],
    copies: &Sides,
) -> Result<(TriangleMesh, Indicator)> {
    let grid = *copies.points.grid();
    let covered = Covered::measured(Moving::new(mesh, waypoints, grid.spacing())?, copies);
    let (surface, crowd) = sharp_surface(&covered.inside, &covered)?;
    let finer = split_curved_edges(&surface, Some(&crowd), FINE * grid.h(), Halvings::One, |p| covered.onto(p));
    Ok((finer, covered.inside))
}

/// What a body covers on its way, as seen from the samples beside its surface.
struct Covered {
    moving: Moving,
    grid: Grid,
    inside: Indicator,
    /// Those samples by row, in order along x.
    rows: Vec<Vec<(u32, Known)>>,
}

/// The body where it is nearest to a sample: its distance, what that changes by per millimetre, and how far it has gone.
#[derive(Clone, Copy)]
struct Known {
    value: f32,
    gradient: [f32; 3],
    at: f32,
}

impl Covered {
    /// Measures the samples of the copies that are not all of copies around, and those outside whose cubes copies touch: the body goes a
    /// quarter of a spacing from the nearer of two copies at most, so that it holds no others.
    fn measured(moving: Moving, copies: &Sides) -> Self {
        let (grid, mut inside) = (*copies.points.grid(), copies.points.clone());
        let ([nx, ny, _], words) = (grid.dims(), inside.words_per_row());
        let rows = inside.words_mut().par_chunks_mut(words).enumerate().map(|(row, inside)| {
            let (j, k) = (row % ny, row / ny);
            let (mut known, mut hint) = (Vec::new(), None);
            for i in (0..nx).filter(|&i| is_beside(copies, [i, j, k])) {
                let found = moving.least(grid.position([i, j, k]), hint);
                hint = found.map(|sight| sight.at);
                let Some(Sight { value, gradient, at, .. }) = found else { continue };
                let value = if copies.points.contains([i, j, k]) { value.min(0.0) } else { value } as f32;
                known.push((i as u32, Known { value, gradient: gradient.map(|x| x as f32), at: at as f32 }));
                inside[i / 64] |= u64::from(value <= 0.0) << (i % 64);
            }
            known
        });
        let rows = rows.collect();
        Covered { moving, grid, inside, rows }
    }

    /// What is known at a sample, if it was measured.
    fn known(&self, index: [isize; 3]) -> Option<&Known> {
        let [_, ny, nz] = self.grid.dims();
        let [i, j, k] = index.map(|i| usize::try_from(i).unwrap_or(usize::MAX));
        let row = (j < ny && k < nz).then(|| &self.rows[k * ny + j])?;
        row.binary_search_by_key(&i, |(i, _)| *i as usize).ok().map(|at| &row[at].1)
    }

    /// The places on the way from which the samples of a point's cell saw the body.
    fn places(&self, p: Vec3) -> impl Iterator<Item = f64> {
        let first = self.grid.continuous_index(p).map(|x| x.floor() as isize);
        let corners = (0..8).map(move |n| [0, 1, 2].map(|a| first[a] + (n >> a & 1)));
        let mut places: Vec<f64> =
            corners.filter_map(|index| self.known(index)).map(|known| f64::from(known.at)).collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|b, a| *b - *a < self.grid.h());
        places.into_iter()
    }

    /// The body from a point, where it is nearest of what is seen from some places on the way.
    fn from(&self, p: Vec3, places: impl Iterator<Item = f64>) -> Option<Sight> {
        places.map(|at| self.moving.near(p, at)).min_by(|a, b| a.value.total_cmp(&b.value))
    }

    fn point_of(&self, edge: Edge, t: f64) -> Vec3 {
        let step = |axis| if axis == edge.axis { t } else { 0.0 };
        [0, 1, 2].map(|a| self.grid.origin()[a] + self.grid.h() * (edge.from[a] as f64 + step(a)))
    }

    /// Where the surface crosses an edge if the values and slopes at its ends tell of no crease, and the normal there.
    fn smooth_crossing(&self, axis: usize, [a, b]: [&Known; 2]) -> Option<(f64, Vec3)> {
        let h = self.grid.h();
        let values = [a, b].map(|known| f64::from(known.value));
        let gradients = [a, b].map(|known| known.gradient.map(f64::from));
        let (slopes, mean) = (gradients.map(|gradient| h * gradient[axis]), values[1] - values[0]);
        if slopes.iter().any(|slope| (slope - mean).abs() > SMOOTH_SLOPE * h) {
            return None;
        }
        let t = root_of_cubic(values, slopes, -values[0] / mean);
        Some((t, unit(add(scale(gradients[0], 1.0 - t), scale(gradients[1], t)))))
    }

    /// Where the surface crosses an edge between values of different signs, and the normal there: by Newton's steps, and where these leave
    /// what is known to hold it, by regula falsi.
    fn stepped_crossing(&self, edge: Edge, [a, b]: [f64; 2]) -> (f64, Option<Vec3>) {
        let (mut low, mut high, mut t, mut normal) = ((0.0, a), (1.0, b), a / (a - b), None);
        let places: Vec<f64> = self.places(self.point_of(edge, 0.5)).collect();
        for _ in 0..MOST_STEPS {
            let Some(sight) = self.from(self.point_of(edge, t), places.iter().copied()) else { break };
            normal = Some(sight.off().1);
            let end = if (sight.value > 0.0) == (a > 0.0) { &mut low } else { &mut high };
            *end = (t, sight.value);
            let slope = self.grid.h() * sight.gradient[edge.axis];
            let newton = t - sight.value / slope;
            let next = match slope * (b - a) > 0.0 && (low.0..=high.0).contains(&newton) {
                true => newton,
                false => low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1),
            };
            let step = (next - t).abs();
            t = next;
            if step < NEAR_CROSSING {
                break;
            }
        }
        (t, normal)
    }
}

/// Whether a sample is one of those beside the surface of what copies cover.
fn is_beside(copies: &Sides, [i, j, k]: [usize; 3]) -> bool {
    let held = |index| copies.points.contains(index);
    if !held([i, j, k]) {
        return copies.touched.contains([i, j, k]);
    }
    let before = |n: usize| n.wrapping_sub(1);
    let around = [[i + 1, j, k], [i, j + 1, k], [i, j, k + 1], [before(i), j, k], [i, before(j), k], [i, j, before(k)]];
    !around.into_iter().all(held)
}

impl Sheets for Covered {
    /// The normal at the crossing.
    type Note = Option<Vec3>;

    fn crossing(&self, edge: Edge) -> (f64, Option<Vec3>) {
        let mut next = edge.from;
        next[edge.axis] += 1;
        let known = [edge.from, next].map(|index| self.known(index));
        if let [Some(a), Some(b)] = known
            && let Some((t, normal)) = self.smooth_crossing(edge.axis, [a, b])
        {
            return (t, Some(normal));
        }
        let [a, b] = known.map(|known| known.map(|known| f64::from(known.value)));
        // Of an end that was not measured its other one tells the side.
        let far = REACH * self.grid.h();
        let end = |end: Option<f64>, other: Option<f64>| end.unwrap_or(if other <= Some(0.0) { far } else { -far });
        self.stepped_crossing(edge, [end(a, b), end(b, a)])
    }

    fn normals(&self, _: [isize; 3], _: &[Vec3], notes: &[Option<Vec3>]) -> Option<Vec<Vec3>> {
        creased(notes, SMOOTH_COSINE)
    }

    fn bend(&self, ends: [Vec3; 2], normals: [Option<Vec3>; 2]) -> f64 {
        bend_between(ends, normals)
    }

    fn beside(&self, x: Vec3, (p, normal): (Vec3, Vec3)) -> (Vec3, Vec3) {
        let same = |sight: &Sight| dot(sight.off().1, normal) > SMOOTH_COSINE;
        let on_sheet = |at: &f64| {
            let there = self.moving.near(p, *at);
            there.value.abs() < NEAR_CROSSING * self.grid.h() && same(&there)
        };
        let seen = self.places(p).find(on_sheet).map(|at| self.moving.near(x, at)).filter(same);
        seen.map(|sight| sight.off()).map_or((p, normal), |(off, normal)| (along(x, normal, -off), normal))
    }

    fn onto(&self, p: Vec3) -> Vec3 {
        let seen = self.from(p, self.places(p)).map(|sight| sight.off());
        let near = seen.filter(|(off, _)| off.abs() < BESIDE * self.grid.h());
        near.map_or(p, |(off, normal)| along(p, normal, -off))
    }
}
